//! What must hold of areas that are moved and laid over each other. In: polygons of any kind, and distances; out: nothing, or an abort.
//!
//! Rings are simplified, so areas are compared within what that may move their edges.

use graphstipple_core::stages::{Polygon, area, closed, intersection, offset, opened, signed_area, subtracted, united};

/// The most points that are moved six times: each time they may become a few more, and every run is to be short.
const MAX_POINTS: usize = 400;

/// How many insets lie one inside the other.
const INSETS: usize = 6;

/// Moves areas in and out, and checks what comes of it. Polygons may cross themselves and each other. The distance is above 0, in mm,
/// and so is the tolerance.
pub fn examine_areas(raw: &[Polygon], distance: f64, tolerance: f64) {
    let grid = grid(raw, distance);
    // Whatever goes in, it ends, and what comes out is made of numbers.
    for moved in [-distance, 0.0, distance] {
        check_finite(&offset(raw, moved, tolerance).expect("finite areas can be moved"));
    }
    // From here on areas are as they are to be.
    let areas = united(raw).expect("finite areas can be united");
    check_rings(&areas, grid, 0.0);
    if areas.iter().flatten().map(Vec::len).sum::<usize>() > MAX_POINTS {
        return;
    }
    let moved = |by: f64| offset(&areas, by, tolerance).expect("finite areas can be moved");
    let [inner, outer] = [moved(-distance), moved(distance)];
    let slack = Slack { tolerance, grid };
    for result in [&inner, &outer] {
        check_rings(result, grid, tolerance);
    }
    for result in [&inner, &outer] {
        slack.check_distance(result, &areas, distance);
    }
    // What is moved in is what is left where all around it is moved out.
    let around = subtracted(&frame(&areas, 4.0 * distance + 16.0 * grid), &areas).expect("finite areas can be subtracted");
    let around = offset(&around, distance, tolerance).expect("finite areas can be moved");
    let left = subtracted(&areas, &around).expect("finite areas can be subtracted");
    slack.check_within(&left, &inner, "what is left inside, and what is moved in");
    slack.check_within(&inner, &left, "what is moved in, and what is left inside");
    slack.check_within(&inner, &areas, "what is moved in, and what it was");
    slack.check_within(&areas, &outer, "what it was, and what is moved out");
    // What is moved in and out again lies in what it was, and what is moved out and in again around it.
    let open = opened(&areas, distance, tolerance).expect("finite areas can be opened");
    let close = closed(&areas, distance, tolerance).expect("finite areas can be closed");
    for result in [&open, &close] {
        check_rings(result, grid, tolerance);
    }
    slack.check_within(&open, &areas, "what is opened, and what it was");
    slack.check_within(&areas, &close, "what it was, and what is closed");
    check_laid_over(&areas, &outer, slack);
    check_laid_over(&areas, &inner, slack);
    check_nested(&areas, distance, tolerance);
}

/// The step of whole numbers that coordinates become, in mm, as the documentation of the offset has it.
fn grid(areas: &[Polygon], distance: f64) -> f64 {
    let most = areas.iter().flatten().flatten().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    ((most + 4.0 * distance) / f64::from(1 << 27)).max(1.0 / f64::from(1 << 16))
}

/// A rectangle around areas.
fn frame(areas: &[Polygon], room: f64) -> Vec<Polygon> {
    let points = || areas.iter().flatten().flatten();
    let low = [0, 1].map(|axis| points().fold(f64::INFINITY, |low, point| low.min(point[axis])) - room);
    let high = [0, 1].map(|axis| points().fold(f64::NEG_INFINITY, |high, point| high.max(point[axis])) + room);
    if points().next().is_none() {
        return Vec::new();
    }
    vec![vec![vec![low, [high[0], low[1]], high, [low[0], high[1]]]]]
}

fn edges(areas: &[Polygon]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    areas.iter().flatten().flat_map(|ring| (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]))
}

fn length(areas: &[Polygon]) -> f64 {
    edges(areas).map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

fn check_finite(areas: &[Polygon]) {
    assert!(areas.iter().flatten().flatten().flatten().all(|value| value.is_finite()), "a coordinate is not finite");
}

/// Exteriors run one way, holes the other, and next to nothing is covered twice.
fn check_rings(areas: &[Polygon], grid: f64, tolerance: f64) {
    check_finite(areas);
    for polygon in areas {
        assert!(polygon.iter().all(|ring| ring.len() > 2), "a ring has less than three points");
        let least = -(grid + tolerance) * length(std::slice::from_ref(polygon));
        assert!(signed_area(&polygon[0]) >= least, "an exterior has the area {}", signed_area(&polygon[0]));
        assert!(polygon[1..].iter().all(|hole| -signed_area(hole) >= least), "a hole runs the wrong way");
    }
    let covered = area(&united(areas).expect("what came out can be united"));
    let allowed = Slack { tolerance, grid }.of(&[areas]);
    assert!((covered - area(areas)).abs() <= allowed, "areas of {} cover {covered}, allowed {allowed}", area(areas));
}

/// What simplifying and rounding may come to.
#[derive(Clone, Copy)]
struct Slack {
    tolerance: f64,
    grid: f64,
}

impl Slack {
    /// In mm^2, on the edges of these areas.
    fn of(self, areas: &[&[Polygon]]) -> f64 {
        let edge = 4.0 * (self.tolerance + self.grid);
        areas.iter().map(|areas| edge * length(areas)).sum::<f64>() + 16.0 * edge * edge
    }

    /// Checks that every point of areas that were moved is so far from the edges that they were moved from.
    fn check_distance(self, moved: &[Polygon], from: &[Polygon], distance: f64) {
        let to_edge = |[x, y]: [f64; 2], [a, b]: [[f64; 2]; 2]| {
            let [u, v] = [b[0] - a[0], b[1] - a[1]];
            let along = (((x - a[0]) * u + (y - a[1]) * v) / (u * u + v * v)).clamp(0.0, 1.0);
            (a[0] + along * u - x).hypot(a[1] + along * v - y)
        };
        // Points of arcs are found one from the other.
        let allowed = self.tolerance + 8.0 * self.grid + distance / 4096.0;
        for point in moved.iter().flatten().flatten() {
            let nearest = edges(from).map(|edge| to_edge(*point, edge)).fold(f64::INFINITY, f64::min);
            assert!(
                (nearest - distance).abs() <= allowed,
                "{point:?} lies {nearest} from the edges, not {distance}, allowed {allowed}"
            );
        }
    }

    /// Checks that next to nothing of the one lies outside the other.
    fn check_within(self, inner: &[Polygon], outer: &[Polygon], which: &str) {
        let outside = area(&subtracted(inner, outer).expect("finite areas can be subtracted"));
        let allowed = self.of(&[inner, outer]);
        assert!(outside <= allowed, "{which}: {outside} outside, allowed {allowed}");
        assert!(area(inner) <= area(outer) + allowed, "{which}: {} and {}", area(inner), area(outer));
    }
}

/// What is in both, and what is in one alone, add up.
fn check_laid_over(a: &[Polygon], b: &[Polygon], slack: Slack) {
    let both = intersection(a, b).expect("finite areas can be intersected");
    let alone = subtracted(a, b).expect("finite areas can be subtracted");
    check_rings(&both, slack.grid, 0.0);
    check_rings(&alone, slack.grid, 0.0);
    let sum = area(&both) + area(&alone);
    let allowed = slack.of(&[a, b]);
    assert!((sum - area(a)).abs() <= allowed, "{} falls into {sum}, allowed {allowed}", area(a));
}

/// Insets one inside the other have no more points for it.
fn check_nested(areas: &[Polygon], distance: f64, tolerance: f64) {
    let count = |areas: &[Polygon]| areas.iter().flatten().map(Vec::len).sum::<usize>();
    // What rounds a corner has so many points, once.
    let around = (std::f64::consts::TAU / (2.0 * (1.0 - 0.5 * tolerance / distance).clamp(0.7, 1.0).acos())).ceil() as usize + 4;
    let before = count(areas);
    let mut inner = areas.to_vec();
    for inset in 1..=INSETS {
        let moved = offset(&inner, -distance, tolerance).expect("finite areas can be moved");
        let slack = Slack { tolerance, grid: grid(&inner, distance) };
        slack.check_within(&moved, &inner, "an inset, and what it was made of");
        inner = moved;
        assert!(count(&inner) <= 10 * before + before * around, "inset {inset} of {before} points has {}", count(&inner));
    }
}
