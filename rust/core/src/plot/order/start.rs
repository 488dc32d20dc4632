//! The tour to begin with. In: stops; out: a tour through all of them, a sixth longer than the shortest, more or less.
//!
//! The shortest legs are taken first, as long as no stop gets a third one and no round is closed. They are looked for among the
//! nearest neighbours, in rounds: what the legs of one round have joined has two ends, and the next round joins those.

use crate::base::{Control, Result};
use crate::plot::order::entries::Entries;
use crate::plot::order::near::NOBODY;
use crate::plot::order::stops::Stops;
use crate::plot::path::distance;

/// How many neighbours of every end may be joined to it in a round.
const JOINED: usize = 5;

/// A round that leaves more than this share of the pieces is the last one: what is left is joined in the order of the stops.
const MOST_LEFT: f64 = 0.95;

/// The stops in the order of a tour, the free one first and where the pen comes from after it. Closed paths are begun where the tour
/// comes to them.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub(crate) fn start(stops: &mut Stops, entries: &Entries, control: &Control) -> Result<Vec<u32>> {
    let mut pieces = Pieces::of(stops);
    let mut before = pieces.count;
    pieces.join_nearest(stops, entries, control)?;
    let mut ends = pieces.ends(stops, entries, control)?;
    while pieces.count > 1 {
        if pieces.count as f64 > MOST_LEFT * before as f64 {
            pieces.join_all(stops);
            break;
        }
        before = pieces.count;
        pieces.join_nearest(stops, &ends, control)?;
        ends = pieces.ends(stops, &ends, control)?;
    }
    Ok(pieces.tour(stops.free()))
}

/// Pieces of a tour.
struct Pieces {
    /// The stops before and after each, in no order.
    beside: Vec<[u32; 2]>,
    /// Trees of stops that are joined: of each its parent, of a root itself.
    parents: Vec<u32>,
    count: usize,
}

impl Pieces {
    /// Single stops, and lines.
    fn of(stops: &Stops) -> Self {
        let len = stops.len() as u32;
        let mut pieces = Self { beside: vec![[NOBODY; 2]; len as usize], parents: (0..len).collect(), count: len as usize };
        for stop in 0..len {
            let mate = stops.mates[stop as usize];
            if stop < mate {
                pieces.join(stop, mate);
            }
        }
        pieces
    }

    fn root(&mut self, mut stop: u32) -> u32 {
        while self.parents[stop as usize] != stop {
            let above = self.parents[self.parents[stop as usize] as usize];
            self.parents[stop as usize] = above;
            stop = above;
        }
        stop
    }

    /// Joins two ends of different pieces.
    fn join(&mut self, a: u32, b: u32) {
        for (stop, other) in [(a, b), (b, a)] {
            let beside = &mut self.beside[stop as usize];
            beside[usize::from(beside[0] != NOBODY)] = other;
        }
        let [a, b] = [a, b].map(|stop| self.root(stop));
        self.parents[a.max(b) as usize] = a.min(b);
        self.count -= 1;
    }

    /// Those places that are still ends, with the nearest of other pieces.
    fn ends(&mut self, stops: &Stops, of: &Entries, control: &Control) -> Result<Entries> {
        let (mut places, mut ends, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        for (stop, place) in of.stops.iter().zip(&of.places) {
            if self.is_open(stops, *stop, *place) {
                places.push(*place);
                ends.push(*stop);
                owners.push(self.root(*stop));
            }
        }
        Entries::with_owners(places, ends, &owners, control)
    }

    /// Whether something may be joined to a stop at a place: once a closed path has a leg, only where it is begun.
    fn is_open(&self, stops: &Stops, stop: u32, place: [f64; 2]) -> bool {
        let [first, second] = self.beside[stop as usize];
        first == NOBODY || second == NOBODY && stops.places[stop as usize] == place
    }

    /// Joins ends that are near one another, the nearest first.
    fn join_nearest(&mut self, stops: &mut Stops, ends: &Entries, control: &Control) -> Result<()> {
        let Entries { places, stops: numbers, near } = ends;
        // A leg stands at its end of the lower number, or at the other one if only that has it in its list.
        let list = |i: u32| near[i as usize].iter().copied().take(JOINED).take_while(|j| *j != NOBODY);
        let mut legs: Vec<[u32; 2]> = Vec::new();
        let mut keys: Vec<u64> = Vec::new();
        for i in 0..places.len() as u32 {
            for j in list(i).filter(|j| i < *j || !list(*j).any(|other| other == i)) {
                let length = distance(places[i as usize], places[j as usize]) as f32;
                keys.push(u64::from(length.to_bits()) << 32 | legs.len() as u64);
                legs.push([i, j]);
            }
        }
        // Bits of floats from 0 on are in the order of the floats.
        keys.sort_unstable();
        for (at, key) in keys.into_iter().enumerate() {
            if at % 4096 == 0 {
                control.check()?;
            }
            let [i, j] = legs[key as u32 as usize];
            let joined = [i, j].map(|at| (numbers[at as usize], places[at as usize]));
            let [(a, _), (b, _)] = joined;
            if joined.into_iter().all(|(stop, place)| self.is_open(stops, stop, place)) && self.root(a) != self.root(b) {
                joined.into_iter().for_each(|(stop, place)| stops.places[stop as usize] = place);
                self.join(a, b);
            }
        }
        Ok(())
    }

    /// Joins all pieces in the order of their first stops: from the end of what is joined to the nearer end of the next.
    fn join_all(&mut self, stops: &Stops) {
        let free = stops.free();
        // The ends of a piece, at its root: the free stop is the end of one and is joined to nothing.
        let mut ends = vec![[NOBODY; 2]; stops.len()];
        for stop in (0..stops.len() as u32).filter(|stop| self.beside[*stop as usize][1] == NOBODY).collect::<Vec<_>>() {
            let root = self.root(stop) as usize;
            let slot = usize::from(ends[root][0] != NOBODY);
            ends[root][slot] = stop;
        }
        let of_free = self.root(free) as usize;
        let other = |[a, b]: [u32; 2], end: u32| if a == end && b != NOBODY { b } else { a };
        let mut last = other(ends[of_free], free);
        for (root, [a, b]) in ends.iter().copied().enumerate() {
            if a == NOBODY || root == of_free {
                continue;
            }
            let near = if b != NOBODY && stops.distance(last, b) < stops.distance(last, a) { b } else { a };
            self.join(last, near);
            last = other([a, b], near);
        }
    }

    /// The single piece that is left, from the free stop on.
    fn tour(&self, free: u32) -> Vec<u32> {
        let (mut tour, mut before, mut stop) = (Vec::with_capacity(self.beside.len()), NOBODY, free);
        while stop != NOBODY {
            tour.push(stop);
            let [a, b] = self.beside[stop as usize];
            (before, stop) = (stop, if a == before { b } else { a });
        }
        tour
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::path::Path;

    #[test]
    fn a_tour_joins_what_is_near_and_leaves_nothing_out() {
        // Two rows of dots far apart, and a line between them.
        let press = |x: f64, y: f64| Path { points: vec![[x, y]], is_closed: false };
        let mut paths: Vec<Path> = (0..20).flat_map(|i| [press(f64::from(i), 0.0), press(f64::from(i), 50.0)]).collect();
        paths.push(Path { points: vec![[19.0, 49.0], [19.0, 1.0]], is_closed: false });
        let control = Control::new();
        let mut stops = Stops::of(&paths, [0.0; 2]);
        let entries = Entries::of(&stops, &paths, &control).unwrap();
        let tour = start(&mut stops, &entries, &control).unwrap();
        assert_eq!(stops.length(&tour), 19.0 + 1.0 + 1.0 + 19.0);
        let mut all = tour.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..stops.len() as u32));
    }

    #[test]
    fn what_finds_no_neighbours_is_joined_nevertheless() {
        let paths: Vec<Path> =
            (0..9).map(|i| Path { points: vec![[f64::from(i), 0.0], [f64::from(i), 1.0]], is_closed: false }).collect();
        let stops = Stops::of(&paths, [0.0; 2]);
        let mut pieces = Pieces::of(&stops);
        pieces.join_all(&stops);
        assert_eq!((pieces.count, pieces.tour(stops.free()).len()), (1, stops.len()));
    }
}
