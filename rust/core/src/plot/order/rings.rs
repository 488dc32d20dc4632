//! Where in a tour closed paths are begun. In: closed paths of many points, and a tour; out: of each the point at which the tour is
//! shortest, as nearly as a few passes find it.

use crate::base::{Control, Result};
use crate::plot::order::stops::Stops;
use crate::plot::path::{Path, distance};

/// How often the closed paths between two other stops are looked at together: each time they come nearer to one another.
const PASSES: usize = 3;

/// A way that is shorter by less than this share is none: rounding.
const ROUNDING: f64 = 1e-12;

/// Begins closed paths where they lie best in a tour, from the free stop on. Never makes it longer.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub(crate) fn begin_best(stops: &mut Stops, paths: &[Path], tour: &[u32], control: &Control) -> Result<()> {
    let is_ring = |stops: &Stops, stop: u32| stops.marks[stop as usize].ring(paths).is_some();
    let mut at = 0;
    while at < tour.len() {
        let end = (at..tour.len()).find(|end| !is_ring(stops, tour[*end])).unwrap_or(tour.len());
        if end > at {
            // The pen comes from somewhere, which is no closed path. After the last one it may stay.
            let after = tour.get(end).copied().unwrap_or(stops.free());
            let run = Run { rings: &tour[at..end], before: tour[at - 1], after, paths };
            for _ in 0..PASSES {
                control.check()?;
                if !run.begin_better(stops) {
                    break;
                }
            }
        }
        at = end + 1;
    }
    Ok(())
}

/// Closed paths one after the other in a tour, and the stops before and after them.
struct Run<'a> {
    rings: &'a [u32],
    before: u32,
    after: u32,
    paths: &'a [Path],
}

impl Run<'_> {
    fn points(&self, stops: &Stops, ring: usize) -> &[[f64; 2]] {
        stops.marks[self.rings[ring] as usize].ring(self.paths).unwrap_or_default()
    }

    /// Takes the shortest way through some points of each. Returns whether it is shorter than before.
    fn begin_better(&self, stops: &mut Stops) -> bool {
        let candidates = self.candidates(stops);
        // Of every candidate the length of the way up to it, and the candidate before it.
        let mut ways: Vec<Vec<(f64, usize)>> = Vec::with_capacity(candidates.len());
        for (ring, points) in candidates.iter().enumerate() {
            let way = |point: &[f64; 2]| match ring.checked_sub(1) {
                None => (stops.distance_to(self.before, *point), 0),
                Some(last) => {
                    shortest(candidates[last].iter().zip(&ways[last]).map(|(other, (way, _))| way + distance(*other, *point)))
                }
            };
            let ways_here = points.iter().map(way).collect();
            ways.push(ways_here);
        }
        let last = candidates.len() - 1;
        let ends = candidates[last].iter().zip(&ways[last]);
        let (length, mut at) = shortest(ends.map(|(point, (way, _))| way + stops.distance_to(self.after, *point)));
        let tour: Vec<u32> = [&[self.before], self.rings, &[self.after]].concat();
        if length >= stops.length(&tour) * (1.0 - ROUNDING) {
            return false;
        }
        for ring in (0..candidates.len()).rev() {
            stops.places[self.rings[ring] as usize] = candidates[ring][at];
            at = ways[ring][at].1;
        }
        true
    }

    /// Of each path the point at which it is begun now; the nearest to that of the path before, as the pen comes from one to the
    /// nearest point of the next, and the same from the other end; and the best and the nearest as its neighbours are begun now.
    fn candidates(&self, stops: &Stops) -> Vec<Vec<[f64; 2]>> {
        let count = self.rings.len();
        let place = |stop: u32| (stop != stops.free()).then(|| stops.places[stop as usize]);
        let mut candidates: Vec<Vec<[f64; 2]>> = self.rings.iter().map(|ring| vec![stops.places[*ring as usize]]).collect();
        let mut follow = |rings: &mut dyn Iterator<Item = usize>, from: u32| {
            let mut last = place(from);
            for ring in rings {
                last = last.map(|last| nearest(self.points(stops, ring), last));
                candidates[ring].extend(last);
            }
        };
        follow(&mut (0..count), self.before);
        follow(&mut (0..count).rev(), self.after);
        for (ring, points) in candidates.iter_mut().enumerate() {
            let before = if ring == 0 { self.before } else { self.rings[ring - 1] };
            let after = if ring + 1 == count { self.after } else { self.rings[ring + 1] };
            let all = self.points(stops, ring);
            points.push(least(all, |point| stops.distance_to(before, point) + stops.distance_to(after, point)));
            points.extend([before, after].into_iter().filter_map(place).map(|other| nearest(all, other)));
        }
        candidates
    }
}

/// The least of some lengths, the first one if several are, and which it is.
fn shortest(lengths: impl Iterator<Item = f64>) -> (f64, usize) {
    let mut best = (f64::INFINITY, 0);
    for (at, length) in lengths.enumerate() {
        if length < best.0 {
            best = (length, at);
        }
    }
    best
}

/// The first of the points for which a number is the least.
fn least(points: &[[f64; 2]], number: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    points[shortest(points.iter().map(|point| number(*point))).1]
}

fn nearest(points: &[[f64; 2]], to: [f64; 2]) -> [f64; 2] {
    least(points, |point| (point[0] - to[0]).powi(2) + (point[1] - to[1]).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_paths_are_begun_on_the_way() {
        // Squares in a row, the way passing under them.
        let square = |x: f64| Path { points: vec![[x, 5.0], [x + 4.0, 5.0], [x + 4.0, 1.0], [x, 1.0]], is_closed: true };
        let end = Path { points: vec![[40.0, 0.0]], is_closed: false };
        let paths = [square(10.0), square(20.0), end, square(50.0)];
        let mut stops = Stops::of(&paths, [0.0; 2]);
        let at = |x: f64| (0u32..).zip(&stops.places).find(|(_, place)| place[0] == x).map_or(0, |(stop, _)| stop);
        let tour = [stops.free(), at(0.0), at(10.0), at(20.0), at(40.0), at(50.0)];
        let before = stops.length(&tour);
        begin_best(&mut stops, &paths, &tour, &Control::new()).unwrap();
        let begun = tour[2..].iter().map(|stop| stops.places[*stop as usize]).collect::<Vec<_>>();
        // The second is passed on the straight way from the first to the end; after the last one, the nearest point counts.
        assert!(begun[0][1] == 1.0 && begun[1][1] == 1.0 && begun[2..] == [[40.0, 0.0], [50.0, 1.0]], "{begun:?}");
        assert!(stops.length(&tour) < before);
    }
}
