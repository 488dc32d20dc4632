//! A tour made shorter. In: stops and a tour; out: a tour that no move makes shorter, and, when it was shaken, a shorter one still.
//!
//! The moves: two legs are exchanged for two others, which turns round what lies between them (2-opt); up to three presses, lines or
//! closed paths in a row go to another place in the tour, either way round (Or-opt); a closed path is begun at another point, where it
//! is or elsewhere in the tour. The first two begin with a stop that gets a neighbour nearer than one that it has, from a list of its
//! nearest. A stop at which nothing was gained is looked at again when a leg at it has changed.
//!
//! Shaking exchanges three legs near one another in a way that no single move does, makes moves around there, and takes all back if
//! the tour is longer than before.

use std::collections::VecDeque;

use crate::base::{Control, Result, mixed};
use crate::plot::order::entries::{AROUND, Entries, NEIGHBOURS};
use crate::plot::order::near::NOBODY;
use crate::plot::order::stops::Stops;
use crate::plot::order::tour::Tour;
use crate::plot::path::Path;

/// Presses, lines and closed paths that go elsewhere together, at most. More gain next to nothing.
const ROW: usize = 3;

/// Points of a closed path that are tried, at most; the others are left to [`begin_best`](crate::plot::order::rings::begin_best).
const POINTS: usize = 64;

/// Stops that one move turns round, at most. With fewer, moves are missed whose ends are far apart in the tour; with more, a move
/// takes longer than it is worth in a tour of ever so many stops. Shaking makes many more moves, each of which gains less.
const LONGEST_TURN: usize = 150_000;
const LONGEST_TURN_SHAKING: usize = 10_000;

/// Stops that are turned round before only short turns are made, of [`SHORT_TURN`] stops, for each stop of the tour: eight times as
/// many as for dots all over a sheet.
const TURNED_A_STOP: usize = 5_000;
const SHORT_TURN: usize = 1_000;

/// In how long a part of the tour three legs are exchanged to shake it: in a longer one more moves follow, and more is gained.
const SHAKEN: usize = 30;

/// A move that gains less than this share of the coordinates gains nothing: it may be rounding, and moves could go round for ever.
const LEAST_GAIN: f64 = 1e-11;

/// A tour and what makes it shorter.
pub(crate) struct Improver<'a> {
    stops: &'a mut Stops,
    paths: &'a [Path],
    tour: Tour,
    /// The nearest of every stop.
    near: Vec<[u32; NEIGHBOURS]>,
    /// The stops around every closed path.
    around: &'a [[u32; AROUND]],
    /// Stops that are to be looked at, each once.
    waiting: VecDeque<u32>,
    is_waiting: Vec<bool>,
    /// Closed paths that are begun elsewhere since the last shaking, and where they were.
    begun: Vec<(u32, [f64; 2])>,
    least_gain: f64,
    longest_turn: usize,
    turned: usize,
    is_shaking: bool,
}

impl<'a> Improver<'a> {
    /// Begins with a tour. `around` has the stops around every closed path, or is empty if there is none.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn new(
        stops: &'a mut Stops,
        paths: &'a [Path],
        tour: Vec<u32>,
        entries: &Entries,
        around: &'a [[u32; AROUND]],
        control: &Control,
    ) -> Result<Self> {
        let near = entries.near_now(stops, control)?;
        let farthest = stops.places.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
        Ok(Self {
            paths,
            tour: Tour::new(tour),
            near,
            around,
            waiting: VecDeque::new(),
            is_waiting: vec![false; stops.len()],
            begun: Vec::new(),
            least_gain: farthest * LEAST_GAIN,
            longest_turn: LONGEST_TURN,
            turned: 0,
            is_shaking: false,
            stops,
        })
    }

    /// Makes moves until none gains. Returns how much shorter the tour is.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn improve(&mut self, control: &Control) -> Result<f64> {
        self.is_shaking = false;
        self.longest_turn = LONGEST_TURN;
        (0..self.stops.free()).for_each(|stop| self.wake(stop));
        let mut gained = 0.0;
        for round in 0_usize.. {
            if round % 256 == 0 {
                control.check()?;
            }
            let Some(gain) = self.move_at_next() else { break };
            gained += gain;
            self.keep();
            if self.turned > TURNED_A_STOP * self.stops.len() {
                self.longest_turn = SHORT_TURN;
            }
        }
        Ok(gained)
    }

    /// Shakes the tour so often. Returns how much shorter it is.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn shake(&mut self, times: usize, control: &Control) -> Result<f64> {
        self.is_shaking = true;
        self.longest_turn = self.longest_turn.min(LONGEST_TURN_SHAKING);
        let mut gained = 0.0;
        for time in 0..times as u64 {
            if time % 256 == 0 {
                control.check()?;
            }
            let random = mixed(time);
            // From stop to stop as they are numbered, so that what is read is near in memory.
            let count = self.stops.len() as u64;
            let first = (time * count / times as u64 + (random >> 48) % SHAKEN as u64) % count;
            let Some(mut gain) = self.exchange_three(first as u32, random) else { continue };
            while let Some(more) = self.move_at_next() {
                gain += more;
            }
            if gain >= 0.0 {
                self.keep();
                gained += gain;
            } else {
                self.take_back();
            }
        }
        Ok(gained)
    }

    /// The stops in the order of the tour, the free one first and where the pen comes from after it.
    pub(crate) fn into_tour(self) -> Vec<u32> {
        let free = self.stops.free();
        let is_forwards = self.stops.are_mates(free, self.tour.beside(free, true));
        let mut order = self.tour.into_order();
        if !is_forwards {
            order.reverse();
        }
        let at = order.iter().position(|stop| *stop == free).unwrap_or(0);
        order.rotate_left(at);
        order
    }

    /// What was done up to now stays.
    fn keep(&mut self) {
        self.tour.keep();
        self.begun.clear();
    }

    /// Takes back what was done since [`Improver::keep`].
    fn take_back(&mut self) {
        self.tour.take_back();
        while let Some((ring, place)) = self.begun.pop() {
            self.stops.places[ring as usize] = place;
        }
    }

    fn wake(&mut self, stop: u32) {
        if !self.is_waiting[stop as usize] {
            self.is_waiting[stop as usize] = true;
            self.waiting.push_back(stop);
        }
    }

    /// Makes a move at the first stop that waits and at which one gains. Returns what it gains.
    fn move_at_next(&mut self) -> Option<f64> {
        while let Some(stop) = self.waiting.front().copied() {
            if let Some(gain) = self.move_at(stop) {
                return Some(gain);
            }
            self.waiting.pop_front();
            self.is_waiting[stop as usize] = false;
        }
        None
    }

    /// Makes the first move at a stop that gains.
    fn move_at(&mut self, a: u32) -> Option<f64> {
        if a == self.stops.free() {
            return None;
        }
        if let Some(gain) = self.begin_elsewhere(a).or_else(|| self.go_elsewhere(a)) {
            return Some(gain);
        }
        for is_after in [true, false] {
            let b = self.tour.beside(a, is_after);
            if self.stops.are_mates(a, b) {
                continue;
            }
            let ab = self.stops.distance(a, b);
            for at in 0..NEIGHBOURS {
                let c = self.near[a as usize][at];
                if c == NOBODY {
                    break;
                }
                let nearer = ab - self.stops.distance(a, c);
                if nearer <= self.least_gain {
                    break;
                }
                let moved = self.turn(a, b, c, nearer, is_after);
                if let Some(gain) = moved.or_else(|| self.relocate(a, b, c, nearer, is_after)) {
                    return Some(gain);
                }
            }
        }
        None
    }

    /// In place of the legs from a to b and from c to the stop beyond it, those from a to c and from b to that one, if that gains.
    fn turn(&mut self, a: u32, b: u32, c: u32, nearer: f64, is_after: bool) -> Option<f64> {
        let d = self.tour.beside(c, is_after);
        if self.stops.are_mates(c, d) {
            return None;
        }
        let gain = nearer + self.stops.distance(c, d) - self.stops.distance(b, d);
        if gain <= self.least_gain || self.turned_between(a, c) > self.longest_turn {
            return None;
        }
        self.exchange(a, b, c, d);
        self.woken(&[a, b, c, d], gain)
    }

    /// Moves a row that begins at a, and goes on away from b, to beside c, if that gains.
    fn relocate(&mut self, a: u32, b: u32, c: u32, nearer: f64, is_after: bool) -> Option<f64> {
        let (mut end, mut marks) = (a, 0);
        while end != c && marks < ROW {
            let f = self.tour.beside(end, !is_after);
            if f == b {
                return None;
            }
            if self.stops.are_mates(end, f) {
                end = f;
                continue;
            }
            let closed = nearer + self.stops.distance(end, f) - self.stops.distance(b, f);
            for side in [true, false] {
                let w = self.tour.beside(c, side);
                // A leg at the row itself goes away.
                if w == end || self.stops.are_mates(c, w) {
                    continue;
                }
                let gain = closed + self.stops.distance(c, w) - self.stops.distance(end, w);
                if gain > self.least_gain && self.turned_between(a, c) <= self.longest_turn {
                    // In the direction from b over a to f.
                    if side == is_after {
                        // b [a..end] f..w c becomes b f..w [end..a] c.
                        self.exchange(b, a, w, c);
                        if w != f {
                            self.exchange(b, w, f, end);
                        }
                    } else {
                        // b [a..end] f..c w becomes b f..c [a..end] w.
                        self.exchange(b, a, c, w);
                        if c != f {
                            self.exchange(b, c, f, end);
                        }
                        self.exchange(c, end, a, w);
                    }
                    return self.woken(&[a, b, c, end, f, w], gain);
                }
            }
            marks += 1;
            end = f;
        }
        None
    }

    /// Begins a closed path at another of its points, if that gains.
    fn begin_elsewhere(&mut self, a: u32) -> Option<f64> {
        let stops = &*self.stops;
        let points = stops.marks[a as usize].ring(self.paths)?;
        let [before, after] = [false, true].map(|is_after| self.tour.beside(a, is_after));
        let now = stops.distance(before, a) + stops.distance(a, after);
        let mut best = (self.least_gain, None);
        for point in tried(points) {
            let gain = now - stops.distance_to(before, point) - stops.distance_to(after, point);
            if gain > best.0 {
                best = (gain, Some(point));
            }
        }
        self.begin_at(a, best.1?);
        self.woken(&[before, a, after], best.0)
    }

    /// Moves a closed path to where it is begun at another point beside one of the stops around it, if that gains. Not in shaking,
    /// which is to be quick.
    fn go_elsewhere(&mut self, a: u32) -> Option<f64> {
        let stops = &*self.stops;
        let points = stops.marks[a as usize].ring(self.paths).filter(|_| !self.is_shaking)?;
        let [before, after] = [false, true].map(|is_after| self.tour.beside(a, is_after));
        let closed = stops.distance(before, a) + stops.distance(a, after) - stops.distance(before, after);
        if closed <= self.least_gain {
            return None;
        }
        let mut best = (self.least_gain, None);
        for c in self.around[a as usize].into_iter().take_while(|c| *c != NOBODY) {
            for side in [true, false] {
                let w = self.tour.beside(c, side);
                if w == a || stops.are_mates(c, w) || self.turned_between(a, c) > self.longest_turn {
                    continue;
                }
                let opened = stops.distance(c, w);
                for point in tried(points) {
                    let gain = closed + opened - stops.distance_to(c, point) - stops.distance_to(w, point);
                    if gain > best.0 {
                        best = (gain, Some((if side { [c, w] } else { [w, c] }, point)));
                    }
                }
            }
        }
        let ([c, w], point) = best.1?;
        // before [a] after..c w becomes before after..c [a] w.
        self.exchange(before, a, c, w);
        if c != after {
            self.exchange(before, c, after, a);
        }
        self.begin_at(a, point);
        self.woken(&[before, a, after, c, w], best.0)
    }

    /// Exchanges three legs of the part of the tour that begins with a stop, as a random number says: a b..c d..e f becomes
    /// a d..e b..c f. Returns what that gains, mostly less than nothing; `None` if the three are not to be had.
    fn exchange_three(&mut self, first: u32, random: u64) -> Option<f64> {
        let legs = self.stops.len() - 1;
        let mut at = [0, 16, 32].map(|shift| (random >> shift & 0xffff) as usize % SHAKEN.min(legs));
        for at in &mut at {
            let [one, other] = [*at, *at + 1].map(|steps| self.tour.after(first, steps));
            *at += usize::from(self.stops.are_mates(one, other));
        }
        at.sort_unstable();
        if at[0] == at[1] || at[1] == at[2] || at[2] >= legs {
            return None;
        }
        let [a, c, e] = at.map(|steps| self.tour.after(first, steps));
        let [b, d, f] = at.map(|steps| self.tour.after(first, steps + 1));
        let length = |from, to| self.stops.distance(from, to);
        let gain = length(a, b) + length(c, d) + length(e, f) - length(a, d) - length(e, b) - length(c, f);
        self.exchange(a, b, e, f);
        self.exchange(a, e, d, c);
        self.exchange(e, c, b, f);
        self.woken(&[a, b, c, d, e, f], gain)
    }

    /// How many stops lie between two, on the side where they are fewer.
    fn turned_between(&self, a: u32, c: u32) -> usize {
        let steps = self.tour.steps(a, c);
        steps.min(self.tour.len() - steps)
    }

    fn exchange(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.turned += self.tour.exchange(a, b, c, d);
    }

    fn begin_at(&mut self, ring: u32, place: [f64; 2]) {
        self.begun.push((ring, self.stops.places[ring as usize]));
        self.stops.places[ring as usize] = place;
    }

    /// Wakes stops whose legs have changed, and hands on what that gained.
    fn woken(&mut self, stops: &[u32], gain: f64) -> Option<f64> {
        stops.iter().for_each(|stop| self.wake(*stop));
        Some(gain)
    }
}

/// Points that stand for all of a closed path.
fn tried(points: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> {
    points.iter().copied().step_by(points.len().div_ceil(POINTS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::order::start::start;
    use proptest::prelude::*;

    fn any_path() -> impl Strategy<Value = Path> {
        let point = (0.0..100.0, 0.0..100.0).prop_map(|(x, y)| [x, y]);
        (prop::collection::vec(point, 1..6), any::<bool>()).prop_map(|(points, is_closed)| Path { points, is_closed })
    }

    proptest! {
        #[test]
        fn the_tour_is_as_much_shorter_as_the_moves_say(paths in prop::collection::vec(any_path(), 1..80)) {
            let control = Control::new();
            let mut stops = Stops::of(&paths, [0.0; 2]);
            let entries = Entries::of(&stops, &paths, &control).unwrap();
            let around = entries.around(&stops);
            let mut tour = start(&mut stops, &entries, &control).unwrap();
            for shakes in [0, 200] {
                let before = stops.length(&tour);
                let mut improver = Improver::new(&mut stops, &paths, tour, &entries, &around, &control).unwrap();
                let gain = improver.improve(&control).unwrap() + improver.shake(shakes, &control).unwrap();
                tour = improver.into_tour();
                let after = stops.length(&tour);
                prop_assert!(gain >= 0.0 && (before - after - gain).abs() < 1e-7, "{} from {} to {}", gain, before, after);
                // Every stop once, lines whole, from the free stop on.
                let mut all = tour.clone();
                all.sort_unstable();
                prop_assert!(all.into_iter().eq(0..stops.len() as u32));
                prop_assert!(tour[0] == stops.free() && stops.are_mates(tour[0], tour[1]));
                for pair in tour.windows(3) {
                    let mate = stops.mates[pair[1] as usize];
                    prop_assert!(mate == pair[0] || mate == pair[1] || mate == pair[2]);
                }
            }
        }
    }
}
