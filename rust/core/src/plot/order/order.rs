//! The order in which a pen draws. In: paths in any order, and where the pen comes from; out: the same paths, in an order in which the
//! pen goes little without drawing.
//!
//! It is a travelling salesman's tour: begun with the shortest legs, then made shorter by moves of two and three legs, then shaken.
//! Lines are drawn from either end, closed paths from any point on.

use crate::base::{Control, Error, Result};
use crate::plot::order::entries::Entries;
use crate::plot::order::improve::Improver;
use crate::plot::order::rings::begin_best;
use crate::plot::order::start::start;
use crate::plot::order::stops::{Mark, Stops};
use crate::plot::path::{Path, distance};

/// How far from 0 a coordinate may be, in mm: a thousand kilometres. Squares of distances are far from overflowing.
const FARTHEST: f64 = 1e9;

/// How often a tour is shaken: so often, but no oftener than so many times a stop. Twice as often takes twice as long, and shortens
/// a tour of some thousand stops by one or two hundredths.
const SHAKES: usize = 100_000;
const SHAKES_A_STOP: usize = 50;

/// How often closed paths are begun anew and the tour is made shorter for that, at most.
const ROUNDS: usize = 3;

/// A round that gains less than this share of the tour is the last one.
const LEAST_GAIN: f64 = 1e-3;

/// The same paths in the order in which a pen that comes from `from`, in mm, draws them: with little way between them, and never
/// more than as they are. Lines may be turned round, closed paths begun at another of their points. The same paths always give
/// the same.
///
/// # Errors
/// [`Error::Input`] if a path has no points, or a coordinate is not finite or beyond 10^9 mm; [`Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of points but for the stops that moves turn round, which are bounded for each path.
pub fn ordered(paths: Vec<Path>, from: [f64; 2], control: &Control) -> Result<Vec<Path>> {
    ordered_with(paths, from, SHAKES, control)
}

fn ordered_with(paths: Vec<Path>, from: [f64; 2], shakes: usize, control: &Control) -> Result<Vec<Path>> {
    check(&paths, from)?;
    if paths.is_empty() {
        return Ok(paths);
    }
    let mut stops = Stops::of(&paths, from);
    control.check()?;
    let entries = Entries::of(&stops, &paths, control)?;
    let around = entries.around(&stops);
    let rounds = if around.is_empty() { 1 } else { ROUNDS };
    let mut tour = start(&mut stops, &entries, control)?;
    begin_best(&mut stops, &paths, &tour, control)?;
    for _ in 0..rounds {
        let before = stops.length(&tour);
        let shakes = (SHAKES_A_STOP * stops.len()).min(shakes) / rounds;
        let mut improver = Improver::new(&mut stops, &paths, tour, &entries, &around, control)?;
        improver.improve(control)?;
        improver.shake(shakes, control)?;
        tour = improver.into_tour();
        begin_best(&mut stops, &paths, &tour, control)?;
        if before - stops.length(&tour) < LEAST_GAIN * before {
            break;
        }
    }
    // Where they were in order already, rounding may count.
    let are_better = stops.length(&tour) < travelled(&paths, from);
    Ok(if are_better { along(paths, &stops, &tour) } else { paths })
}

/// How far a pen that comes from `from` goes without drawing, in mm: from path to path in their order, and not back.
pub fn travelled(paths: &[Path], from: [f64; 2]) -> f64 {
    let (mut at, mut way) = (from, 0.0);
    for path in paths {
        if let (Some(first), Some(end)) = (path.points.first(), path.end()) {
            way += distance(at, *first);
            at = end;
        }
    }
    way
}

fn check(paths: &[Path], from: [f64; 2]) -> Result<()> {
    if let Some(path) = paths.iter().position(|path| path.points.is_empty()) {
        return Err(Error::Input(format!("path {path} has no points, but every path must have one at least")));
    }
    let mut coordinates = paths.iter().flat_map(|path| &path.points).chain([&from]).flatten();
    match coordinates.find(|value| value.is_nan() || value.abs() > FARTHEST) {
        Some(value) => Err(Error::Input(format!("a coordinate of a path is {value} mm, but it must be within {FARTHEST:e} mm"))),
        None => Ok(()),
    }
}

/// The paths as a tour comes by them.
fn along(mut paths: Vec<Path>, stops: &Stops, tour: &[u32]) -> Vec<Path> {
    let mut ordered = Vec::with_capacity(paths.len());
    let mut taken = |path: u32| std::mem::take(&mut paths[path as usize]);
    let mut before = stops.free();
    for stop in tour.iter().copied() {
        match stops.marks[stop as usize] {
            Mark::Presses { first, count } => {
                ordered.extend(stops.presses[first as usize..][..count as usize].iter().map(|path| taken(*path)));
            }
            // Its other end.
            Mark::End { .. } if stops.are_mates(before, stop) => {}
            Mark::End { path, is_last } => {
                let mut line = taken(path);
                if is_last {
                    line.points.reverse();
                }
                ordered.push(line);
            }
            Mark::Ring { path } => {
                let mut ring = taken(path);
                let place = stops.places[stop as usize];
                let at = ring.points.iter().position(|point| *point == place).unwrap_or(0);
                ring.points.rotate_left(at);
                ordered.push(ring);
            }
            Mark::Nothing => {}
        }
        before = stop;
    }
    ordered
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mixed;
    use proptest::prelude::*;

    fn press(point: [f64; 2]) -> Path {
        Path { points: vec![point], is_closed: false }
    }

    fn line(points: &[[f64; 2]]) -> Path {
        Path { points: points.to_vec(), is_closed: false }
    }

    /// A closed path of corners on a circle.
    fn ring([x, y]: [f64; 2], radius: f64, corners: usize) -> Path {
        let corner = |at: usize| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * at as f64 / corners as f64);
            [x + radius * cos, y + radius * sin]
        };
        Path { points: (0..corners).map(corner).collect(), is_closed: true }
    }

    /// In [0, 1).
    fn random(number: usize) -> f64 {
        (mixed(number as u64) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn scattered(count: usize) -> Vec<Path> {
        (0..count).map(|i| press([random(2 * i), random(2 * i + 1)])).collect()
    }

    /// What is the same of a path however it is drawn, as bits.
    fn shape(path: &Path) -> (bool, Vec<[u64; 2]>) {
        let bits = |points: &mut dyn Iterator<Item = &[f64; 2]>| points.map(|point| point.map(f64::to_bits)).collect::<Vec<_>>();
        let count = path.points.len();
        let mut ways = vec![bits(&mut path.points.iter())];
        if path.is_closed {
            ways.extend((1..count).map(|first| bits(&mut path.points.iter().cycle().skip(first).take(count))));
        } else {
            ways.push(bits(&mut path.points.iter().rev()));
        }
        (path.is_closed, ways.into_iter().min().unwrap_or_default())
    }

    fn shapes(paths: &[Path]) -> Vec<(bool, Vec<[u64; 2]>)> {
        let mut shapes: Vec<_> = paths.iter().map(shape).collect();
        shapes.sort_unstable();
        shapes
    }

    /// The shortest way of all, by Held and Karp's method: of every set of paths and every last one of it, begun anywhere.
    fn shortest(paths: &[Path], from: [f64; 2]) -> f64 {
        let way = |path: &Path| match path.points.as_slice() {
            points if path.is_closed => points.iter().map(|point| [*point; 2]).collect(),
            points => vec![[points[0], points[points.len() - 1]], [points[points.len() - 1], points[0]]],
        };
        let ways: Vec<Vec<[[f64; 2]; 2]>> = paths.iter().map(way).collect();
        let all = (1 << paths.len()) - 1;
        let unknown: Vec<Vec<f64>> = ways.iter().map(|ways| vec![f64::INFINITY; ways.len()]).collect();
        let mut least = vec![unknown; all + 1];
        for set in 1..=all {
            for last in (0..paths.len()).filter(|last| set >> last & 1 == 1) {
                for (at, [begin, _]) in ways[last].iter().enumerate() {
                    let before = set & !(1 << last);
                    let others = (0..paths.len()).filter(|other| before >> other & 1 == 1);
                    let so_far = others.flat_map(|other| least[before][other].iter().zip(&ways[other]));
                    let best = so_far.map(|(so_far, [_, end])| so_far + distance(*end, *begin)).fold(f64::INFINITY, f64::min);
                    least[set][last][at] = if before == 0 { distance(from, *begin) } else { best };
                }
            }
        }
        least[all].iter().flatten().copied().fold(f64::INFINITY, f64::min)
    }

    fn any_path() -> impl Strategy<Value = Path> {
        // Whole numbers, so that some are in one place.
        let point = (0u8..30, 0u8..30).prop_map(|(x, y)| [f64::from(x), f64::from(y)]);
        (prop::collection::vec(point, 1..9), any::<bool>()).prop_map(|(points, is_closed)| Path { points, is_closed })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn all_paths_are_drawn_once_as_they_are_and_with_no_longer_way(
            paths in prop::collection::vec(any_path(), 0..40), from in (-9i8..40, -9i8..40)
        ) {
            let from = [f64::from(from.0), f64::from(from.1)];
            let drawn = ordered(paths.clone(), from, &Control::new()).unwrap();
            prop_assert_eq!(shapes(&drawn), shapes(&paths));
            prop_assert!(travelled(&drawn, from) <= travelled(&paths, from));
            // What is drawn so is drawn so again, or better.
            let again = ordered(drawn.clone(), from, &Control::new()).unwrap();
            prop_assert!(travelled(&again, from) <= travelled(&drawn, from));
            prop_assert_eq!(ordered(paths, from, &Control::new()).unwrap(), drawn);
        }
    }

    #[test]
    fn few_paths_are_drawn_nearly_as_well_as_they_can_be() {
        let (mut best, mut ours, mut exact) = (0.0, 0.0, 0);
        let cases = 60;
        for case in 0..cases {
            let mut number = 1000 * case;
            let mut next = || {
                number += 1;
                100.0 * random(number)
            };
            let count = 2 + case % 7;
            let path = |_| {
                let (kind, place) = (next(), [next(), next()]);
                match kind as usize / 34 {
                    0 => press(place),
                    1 => line(&[place, [next(), next()], [next(), next()]]),
                    _ => ring(place, 0.3 * next(), 9),
                }
            };
            let paths: Vec<Path> = (0..count).map(path).collect();
            let drawn = travelled(&ordered(paths.clone(), [0.0; 2], &Control::new()).unwrap(), [0.0; 2]);
            let least = shortest(&paths, [0.0; 2]);
            assert!(drawn > least * (1.0 - 1e-9) && drawn < 1.05 * least, "case {case}: {drawn}, where {least} is the shortest");
            exact += usize::from(drawn < least * (1.0 + 1e-9));
            best += least;
            ours += drawn;
        }
        assert!(ours < 1.002 * best && exact >= cases * 9 / 10, "{ours} of {best}, {exact} of {cases} the shortest");
    }

    #[test]
    fn scattered_dots_are_near_the_shortest_tour() {
        // What the shortest tour of so many dots comes to (Johnson and McGeoch): without shaking, and shaken.
        let count = 20_000;
        let expected = 0.7124 * (count as f64).sqrt();
        for (shakes, limit) in [(0, 1.06), (5_000, 1.05)] {
            let drawn = ordered_with(scattered(count), [0.0; 2], shakes, &Control::new()).unwrap();
            let way = travelled(&drawn, [0.0; 2]);
            assert!(way > 0.98 * expected && way < limit * expected, "{} after {shakes}", way / expected);
        }
    }

    #[test]
    fn nested_rings_are_drawn_from_one_to_the_next() {
        // Three targets far apart, each of thirty rings a pen's width apart.
        let centres = [[20.0, 20.0], [100.0, 25.0], [60.0, 90.0]];
        let mut paths: Vec<Path> =
            (1..=30).flat_map(|at| centres.map(|centre| ring(centre, 0.3 * f64::from(at), 24 + 5 * at as usize))).collect();
        paths.reverse();
        let way = travelled(&ordered(paths, [0.0; 2], &Control::new()).unwrap(), [0.0; 2]);
        // To the first and on to the others, and in each in and out.
        let between = 28.3 - 9.0 + 2.0 * (76.0 - 18.0);
        let within = 3.0 * 29.0 * 0.3;
        assert!(way < 1.15 * (between + within), "{way} for {}", between + within);
    }

    #[test]
    fn hatches_are_drawn_to_and_fro() {
        let hatch: Vec<Path> =
            (0..200).map(|i| line(&[[0.0, 0.3 * f64::from(i * 77 % 200)], [40.0, 0.3 * f64::from(i * 77 % 200)]])).collect();
        let drawn = ordered(hatch, [0.0; 2], &Control::new()).unwrap();
        assert!((travelled(&drawn, [0.0; 2]) - 199.0 * 0.3).abs() < 1e-6);
        assert!(drawn.windows(2).all(|pair| pair[0].points[1][0] == pair[1].points[0][0]));
    }

    #[test]
    fn no_paths_and_single_ones() {
        let ordered = |paths: Vec<Path>| ordered(paths, [0.0; 2], &Control::new()).unwrap();
        assert_eq!(ordered(Vec::new()), []);
        assert_eq!(ordered(vec![press([3.0, 4.0])]), [press([3.0, 4.0])]);
        assert_eq!(ordered(vec![line(&[[9.0, 9.0], [5.0, 7.0], [1.0, 1.0]])]), [line(&[[1.0, 1.0], [5.0, 7.0], [9.0, 9.0]])]);
        let square = |points: [[f64; 2]; 4]| Path { points: points.to_vec(), is_closed: true };
        let drawn = ordered(vec![square([[9.0, 9.0], [9.0, 1.0], [1.0, 1.0], [1.0, 9.0]])]);
        assert_eq!(drawn, [square([[1.0, 1.0], [1.0, 9.0], [9.0, 9.0], [9.0, 1.0]])]);
        // A closed path of one point is a press.
        let dot = Path { points: vec![[2.0, 2.0]], is_closed: true };
        assert_eq!(ordered(vec![dot.clone(), press([1.0, 1.0])]), [press([1.0, 1.0]), dot]);
    }

    #[test]
    fn the_way_is_that_between_paths() {
        let paths = [press([3.0, 4.0]), line(&[[3.0, 5.0], [9.0, 9.0], [6.0, 5.0]]), ring([6.0, 6.0], 1.0, 4), press([7.0, 6.0])];
        assert!((travelled(&paths, [0.0; 2]) - (5.0 + 1.0 + 2f64.sqrt())).abs() < 1e-12);
        assert_eq!(travelled(&[], [1.0; 2]), 0.0);
    }

    #[test]
    fn many_paths_in_awkward_places_end() {
        let count = 50_000;
        let side = 220;
        let of = |place: &dyn Fn(usize) -> [f64; 2], count: usize| (0..count).map(|i| press(place(i))).collect::<Vec<_>>();
        let within = |paths: Vec<Path>, limit: f64| {
            let shapes = paths.len();
            let drawn = ordered_with(paths, [0.0; 2], 1000, &Control::new()).unwrap();
            let way = travelled(&drawn, [0.0; 2]);
            assert!(drawn.len() == shapes && way <= limit, "{way} is more than {limit}");
        };
        // In one place, in a few, on a line, and on a grid.
        within(of(&|_| [3.0, 4.0], 300_000), 5.0);
        within(of(&|i| [(i % 10) as f64, 0.0], 300_000), 9.0);
        within(of(&|i| [random(i), random(i)], count), 1.5);
        within(of(&|i| [(i * 7919 % count) as f64, 0.0], count), count as f64);
        within(of(&|i| [(i % side) as f64, (i / side) as f64], side * side), 1.01 * (side * side) as f64);
        // In clusters, the one a thousand times as dense as the other.
        within(of(&|i| [random(i) * 1000f64.powi(-((i % 5) as i32)), random(i + count)], count), 600.0);
        // Lines that begin in one place; equal lines; equal closed paths.
        within((0..count / 4).map(|i| line(&[[0.0, 0.0], [random(i), 1.0]])).collect(), 5.0);
        within(vec![line(&[[0.0, 0.0], [1.0, 0.0]]); count], 0.0);
        within(vec![ring([1.0, 0.0], 1.0, 8); count / 10], 0.8 * (count / 10) as f64);
    }

    #[test]
    fn long_closed_paths_are_begun_where_the_tour_comes_by() {
        let mut paths = scattered(1000);
        let alone = travelled(&ordered(paths.clone(), [0.0; 2], &Control::new()).unwrap(), [0.0; 2]);
        paths.extend((0..3).map(|i| ring([0.5, 0.5], 0.3 + 1e-4 * f64::from(i), 100_000)));
        let drawn = ordered_with(paths, [0.0; 2], 10_000, &Control::new()).unwrap();
        assert!(travelled(&drawn, [0.0; 2]) < 1.05 * alone);
    }

    #[test]
    fn what_cannot_be_ordered_is_told() {
        let told = |paths: Vec<Path>, from: [f64; 2]| ordered(paths, from, &Control::new()).unwrap_err().to_string();
        assert_eq!(
            told(vec![press([1.0, 1.0]), line(&[])], [0.0; 2]),
            "path 1 has no points, but every path must have one at least"
        );
        let limit = "mm, but it must be within 1e9 mm";
        assert_eq!(told(vec![press([1.0, f64::NAN])], [0.0; 2]), format!("a coordinate of a path is NaN {limit}"));
        assert_eq!(told(Vec::new(), [f64::INFINITY, 0.0]), format!("a coordinate of a path is inf {limit}"));
        assert_eq!(told(vec![press([-2e9, 0.0])], [0.0; 2]), format!("a coordinate of a path is -2000000000 {limit}"));
        let control = Control::new();
        control.cancel();
        assert!(matches!(ordered(scattered(10), [0.0; 2], &control), Err(Error::Cancelled)));
    }
}
