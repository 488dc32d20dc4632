//! What a tour goes through: the places at which a pen comes down and is lifted. In: paths; out: stops, and what is drawn at each.
//!
//! A press is a stop, and so is a closed path, at whichever of its points it is begun. An open line is two, its ends, which follow one
//! another in every tour. Where the pen comes from is a stop, too. It follows upon the free stop, which is no place: it is near to all
//! others, so that a round tour through it is a way that may end anywhere.

use crate::plot::order::curve::along_curve;
use crate::plot::path::{Path, distance};

/// What is drawn at a stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mark {
    /// So many presses in one place, from one of [`Stops::presses`] on.
    Presses { first: u32, count: u32 },
    /// A line, from its first point on or from its last.
    End { path: u32, is_last: bool },
    /// A closed path.
    Ring { path: u32 },
    /// Nothing: where the pen comes from, and the free stop.
    Nothing,
}

impl Mark {
    /// The points of a closed path.
    pub(crate) fn ring(self, paths: &[Path]) -> Option<&[[f64; 2]]> {
        match self {
            Self::Ring { path } => Some(&paths[path as usize].points),
            _ => None,
        }
    }
}

/// All stops, numbered along a curve, so that what is near in the plane is near in memory. The last one is the free one.
pub(crate) struct Stops {
    /// Where they are; of closed paths, where they are begun.
    pub(crate) places: Vec<[f64; 2]>,
    /// The other end of a line, and of where the pen comes from the free stop; of all else the stop itself.
    pub(crate) mates: Vec<u32>,
    /// What is drawn there.
    pub(crate) marks: Vec<Mark>,
    /// The paths that are presses. Those in one place stand together: each for itself, they would hide all others from one another.
    pub(crate) presses: Vec<u32>,
}

impl Stops {
    /// The stops of paths, each of which has a point.
    pub(crate) fn of(paths: &[Path], from: [f64; 2]) -> Self {
        // In the order of the paths: where each is begun, and what is there.
        let (mut places, mut marks) = (vec![from], vec![Mark::Nothing]);
        for (path, Path { points, is_closed }) in (0u32..).zip(paths) {
            places.push(points[0]);
            marks.push(match (points.len(), is_closed) {
                (1, _) => Mark::Presses { first: path, count: 1 },
                (_, true) => Mark::Ring { path },
                (_, false) => Mark::End { path, is_last: false },
            });
            if let Some(Mark::End { .. }) = marks.last() {
                places.push(points[points.len() - 1]);
                marks.push(Mark::End { path, is_last: true });
            }
        }
        // In that of the curve.
        let order = along_curve(&places);
        let mut stops = Self { places: Vec::new(), mates: Vec::new(), marks: Vec::new(), presses: Vec::new() };
        let mut numbers = vec![0; order.len()];
        for group in order.chunk_by(|a, b| places[*a as usize] == places[*b as usize]) {
            let mut presses = None;
            for at in group {
                let mut mark = marks[*at as usize];
                if let Mark::Presses { first: path, .. } = mark {
                    mark = Mark::Presses { first: stops.presses.len() as u32, count: 1 };
                    stops.presses.push(path);
                    if let Some(Mark::Presses { count, .. }) = presses.map(|stop: usize| &mut stops.marks[stop]) {
                        *count += 1;
                        continue;
                    }
                    presses = Some(stops.marks.len());
                }
                numbers[*at as usize] = stops.marks.len() as u32;
                stops.places.push(places[*at as usize]);
                stops.marks.push(mark);
                stops.mates.push(match mark {
                    Mark::End { is_last: false, .. } => *at + 1,
                    Mark::End { is_last: true, .. } => *at - 1,
                    _ => *at,
                });
            }
        }
        stops.mates.iter_mut().for_each(|mate| *mate = numbers[*mate as usize]);
        let (origin, free) = (numbers[0], stops.places.len() as u32);
        stops.mates[origin as usize] = free;
        stops.places.push(from);
        stops.marks.push(Mark::Nothing);
        stops.mates.push(origin);
        stops
    }

    /// How many there are, the free one among them.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// The free stop.
    pub(crate) fn free(&self) -> u32 {
        self.places.len() as u32 - 1
    }

    /// A number that the two ends of a line have in common, and no others.
    pub(crate) fn line(&self, stop: u32) -> u32 {
        stop.min(self.mates[stop as usize])
    }

    /// How far it is from one stop to another.
    #[inline]
    pub(crate) fn distance(&self, a: u32, b: u32) -> f64 {
        if a == self.free() { 0.0 } else { self.distance_to(b, self.places[a as usize]) }
    }

    /// How far it is from a place to a stop.
    #[inline]
    pub(crate) fn distance_to(&self, stop: u32, place: [f64; 2]) -> f64 {
        if stop == self.free() { 0.0 } else { distance(self.places[stop as usize], place) }
    }

    /// How long a tour is without what is drawn.
    pub(crate) fn length(&self, tour: &[u32]) -> f64 {
        let legs = tour.windows(2).filter(|leg| !self.are_mates(leg[0], leg[1]));
        legs.map(|leg| self.distance(leg[0], leg[1])).sum()
    }

    /// Whether two stops beside one another in a tour are the ends of a line, which stay together.
    #[inline]
    pub(crate) fn are_mates(&self, a: u32, b: u32) -> bool {
        self.mates[a as usize] == b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presses_in_one_place_are_one_stop_and_lines_are_two() {
        let path = |points: &[[f64; 2]], is_closed| Path { points: points.to_vec(), is_closed };
        let at = [1.0, 1.0];
        let paths = [
            path(&[at], false),
            path(&[at, [2.0, 2.0]], false),
            path(&[at], true),
            path(&[[0.0, 0.0], at], true),
            path(&[[3.0, 0.0], at], false),
        ];
        let stops = Stops::of(&paths, at);
        // The pen's, the presses', two lines', a closed path's, and the free one.
        assert_eq!(stops.len(), 1 + 1 + 4 + 1 + 1);
        assert_eq!(stops.presses, [0, 2]);
        assert_eq!(stops.marks.iter().filter(|mark| matches!(mark, Mark::Presses { first: 0, count: 2 })).count(), 1);
        for (stop, mate) in (0..).zip(&stops.mates) {
            assert_eq!(stops.mates[*mate as usize], stop);
            assert_eq!(*mate == stop, matches!(stops.marks[stop as usize], Mark::Presses { .. } | Mark::Ring { .. }));
            if let [Mark::End { path, is_last }, Mark::End { path: same, is_last: other }] =
                [stop, *mate].map(|stop| stops.marks[stop as usize])
            {
                assert!(path == same && is_last != other);
            }
        }
        assert!(stops.are_mates(stops.free(), stops.mates[stops.free() as usize]));
    }
}
