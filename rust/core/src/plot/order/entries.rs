//! Where paths may be begun. In: stops and paths; out: places of all stops, of closed paths several, with the nearest of other stops.

use crate::base::{Control, Result};
use crate::plot::order::near::{NOBODY, nearest_of_others};
use crate::plot::order::stops::{Mark, Stops};
use crate::plot::path::{Path, distance};

/// How many neighbours a place has: with more, better moves are found, in more time.
pub(crate) const NEIGHBOURS: usize = 7;

/// How many stops are told to lie around a closed path.
pub(crate) const AROUND: usize = 8;

/// Points of closed paths that a tour is begun with, at most: so many, or so many a stop. With fewer it is missed that paths are near
/// one another, with more it takes longer.
const MOST_POINTS: usize = 200_000;
const POINTS_A_STOP: usize = 4;

/// Places of stops, in the order of the stops.
pub(crate) struct Entries {
    /// The places.
    pub(crate) places: Vec<[f64; 2]>,
    /// The stop of each.
    pub(crate) stops: Vec<u32>,
    /// For each place the nearest of other owners, by their numbers here.
    pub(crate) near: Vec<[u32; NEIGHBOURS]>,
}

impl Entries {
    /// The places of all stops but the free one. Closed paths have many, if there are more than [`MOST_POINTS`] points at equal distances.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn of(stops: &Stops, paths: &[Path], control: &Control) -> Result<Self> {
        let rings = || stops.marks.iter().filter_map(|mark| mark.ring(paths));
        let count: usize = rings().map(<[_]>::len).sum();
        let most = MOST_POINTS.max(POINTS_A_STOP * stops.len());
        let length = |ring: &[[f64; 2]]| ring.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
        let spacing = if count <= most { 0.0 } else { rings().map(length).sum::<f64>() / most as f64 };
        let (mut places, mut numbers) = (Vec::with_capacity(stops.len()), Vec::with_capacity(stops.len()));
        for stop in 0..stops.free() {
            let begin = places.len();
            match stops.marks[stop as usize].ring(paths) {
                Some(points) => places.extend(thinned(points, spacing)),
                None => places.push(stops.places[stop as usize]),
            }
            numbers.extend(std::iter::repeat_n(stop, places.len() - begin));
        }
        let owners: Vec<u32> = numbers.iter().map(|stop| stops.line(*stop)).collect();
        Self::with_owners(places, numbers, &owners, control)
    }

    /// Places of stops that belong to owners.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn with_owners(places: Vec<[f64; 2]>, stops: Vec<u32>, owners: &[u32], control: &Control) -> Result<Self> {
        let near = nearest_of_others(&places, owners, control)?;
        Ok(Self { places, stops, near })
    }

    /// For every stop the nearest of other paths, where closed paths are begun as they are now.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn near_now(&self, stops: &Stops, control: &Control) -> Result<Vec<[u32; NEIGHBOURS]>> {
        let count = stops.free() as usize;
        if self.places[..] == stops.places[..count] {
            return Ok(self.near.clone());
        }
        let owners: Vec<u32> = (0..stops.free()).map(|stop| stops.line(stop)).collect();
        nearest_of_others(&stops.places[..count], &owners, control)
    }

    /// For every closed path the stops that are nearest to any of its places, or whose places are; nobody for all other stops, and
    /// nothing where there are no closed paths.
    pub(crate) fn around(&self, stops: &Stops) -> Vec<[u32; AROUND]> {
        let is_ring = |stop: u32| matches!(stops.marks[stop as usize], Mark::Ring { .. });
        let mut pairs: Vec<(u32, f64, u32)> = Vec::new();
        for (place, list) in self.near.iter().enumerate() {
            for other in list.iter().take_while(|other| **other != NOBODY).map(|other| *other as usize) {
                let [a, b] = [place, other].map(|place| self.stops[place]);
                let length = distance(self.places[place], self.places[other]);
                pairs.extend([(a, length, b), (b, length, a)].into_iter().filter(|(ring, ..)| is_ring(*ring)));
            }
        }
        if pairs.is_empty() {
            return Vec::new();
        }
        pairs.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut around = vec![[NOBODY; AROUND]; stops.len()];
        for (ring, _, other) in pairs {
            let list = &mut around[ring as usize];
            if let Some(slot) = list.iter().position(|slot| *slot == NOBODY || *slot == other) {
                list[slot] = other;
            }
        }
        around
    }
}

/// The first point, and those that are at least so far from the one before, along the path.
fn thinned(points: &[[f64; 2]], spacing: f64) -> impl Iterator<Item = [f64; 2]> {
    let (mut passed, mut before) = (f64::INFINITY, points[0]);
    points.iter().copied().filter(move |point| {
        passed += distance(before, *point);
        before = *point;
        let is_kept = passed >= spacing;
        if is_kept {
            passed = 0.0;
        }
        is_kept
    })
}
