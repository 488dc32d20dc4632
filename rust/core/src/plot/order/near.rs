//! Nearest places of other owners. In: places, each with an owner; out: of every place the nearest ones, in lists of one length.
//!
//! Places that follow one another are packed into boxes of a few, these again into larger ones. So no arrangement makes the tree
//! deep: clusters, lines and equal places are as quick as others.

use crate::base::{Control, Result};

/// Places in a box, and boxes in a larger one. More are more to look at in vain, fewer are more boxes.
const IN_BOX: usize = 6;

/// Boxes of places in which a search looks, at most: a place amid ever so many of its own owner would look at all of them. What it
/// does not find may still find it.
const MOST_BOXES: usize = 48;

/// No place.
pub(crate) const NOBODY: u32 = u32::MAX;

/// For every place some others, the nearest first, each of another owner than the place and than the others; [`NOBODY`] where there
/// are no more. What is near in the plane is to be near in the order of the places, else it takes longer.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub(crate) fn nearest_of_others<const COUNT: usize>(
    places: &[[f64; 2]],
    owners: &[u32],
    control: &Control,
) -> Result<Vec<[u32; COUNT]>> {
    let tree = Tree::of(places, owners);
    let mut lists = Vec::with_capacity(places.len());
    for from in 0..places.len() {
        if from % 1024 == 0 {
            control.check()?;
        }
        lists.push(tree.search(from));
    }
    Ok(lists)
}

/// A box around places.
#[derive(Clone, Copy)]
struct Around {
    low: [f64; 2],
    high: [f64; 2],
}

impl Around {
    const NOTHING: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    fn with(self, other: Self) -> Self {
        let [low, high] = [[self.low, other.low], [self.high, other.high]];
        Self {
            low: [low[0][0].min(low[1][0]), low[0][1].min(low[1][1])],
            high: [high[0][0].max(high[1][0]), high[0][1].max(high[1][1])],
        }
    }

    /// The square of the distance to a place.
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let dx = (self.low[0] - x).max(x - self.high[0]).max(0.0);
        let dy = (self.low[1] - y).max(y - self.high[1]).max(0.0);
        dx * dx + dy * dy
    }
}

struct Tree<'a> {
    places: &'a [[f64; 2]],
    owners: &'a [u32],
    /// Boxes of places, then boxes of boxes, up to a single one.
    levels: Vec<Vec<Around>>,
}

impl<'a> Tree<'a> {
    fn of(places: &'a [[f64; 2]], owners: &'a [u32]) -> Self {
        let all = |boxes: &[Around]| boxes.iter().copied().fold(Around::NOTHING, Around::with);
        let of_places = |places: &[[f64; 2]]| {
            places.iter().fold(Around::NOTHING, |around, place| around.with(Around { low: *place, high: *place }))
        };
        // One at least.
        let mut levels = vec![places.chunks(IN_BOX).map(of_places).collect::<Vec<_>>()];
        while let Some(last) = levels.last()
            && last.len() > 1
        {
            let next = last.chunks(IN_BOX).map(all).collect();
            levels.push(next);
        }
        Self { places, owners, levels }
    }

    /// Those nearest to a place. The search goes up from its box, so that it begins with what is near.
    fn search<const COUNT: usize>(&self, from: usize) -> [u32; COUNT] {
        let mut search = Search {
            tree: self,
            at: self.places[from],
            owner: self.owners[from],
            found: [NOBODY; COUNT],
            distances: [f64::INFINITY; COUNT],
            boxes: 0,
        };
        let mut below = from / IN_BOX;
        search.look(below);
        for level in 0..self.levels.len() - 1 {
            let here = below / IN_BOX;
            for child in here * IN_BOX..((here + 1) * IN_BOX).min(self.levels[level].len()) {
                if child != below {
                    search.descend(level, child);
                }
            }
            below = here;
        }
        search.found
    }
}

struct Search<'a, const COUNT: usize> {
    tree: &'a Tree<'a>,
    at: [f64; 2],
    owner: u32,
    /// The nearest, and the squares of their distances.
    found: [u32; COUNT],
    distances: [f64; COUNT],
    /// Boxes of places that were looked at.
    boxes: usize,
}

impl<const COUNT: usize> Search<'_, COUNT> {
    fn descend(&mut self, level: usize, number: usize) {
        if self.boxes >= MOST_BOXES || self.tree.levels[level][number].distance(self.at) >= self.distances[COUNT - 1] {
            return;
        }
        if level == 0 {
            self.look(number);
            return;
        }
        for child in number * IN_BOX..((number + 1) * IN_BOX).min(self.tree.levels[level - 1].len()) {
            self.descend(level - 1, child);
        }
    }

    /// Looks at the places of a box.
    fn look(&mut self, number: usize) {
        self.boxes += 1;
        let tree = self.tree;
        for place in number * IN_BOX..((number + 1) * IN_BOX).min(tree.places.len()) {
            let [dx, dy] = [tree.places[place][0] - self.at[0], tree.places[place][1] - self.at[1]];
            let distance = dx * dx + dy * dy;
            if distance < self.distances[COUNT - 1] && tree.owners[place] != self.owner {
                self.take(distance, place as u32);
            }
        }
    }

    /// Takes a place that is nearer than the last one found, in place of the other one of its owner or of the last one.
    fn take(&mut self, distance: f64, place: u32) {
        let owner = self.tree.owners[place as usize];
        let is_same = |other: &u32| *other != NOBODY && self.tree.owners[*other as usize] == owner;
        let mut at = self.found.iter().position(is_same).unwrap_or(COUNT - 1);
        if self.distances[at] <= distance {
            return;
        }
        while at > 0 && self.distances[at - 1] > distance {
            self.distances[at] = self.distances[at - 1];
            self.found[at] = self.found[at - 1];
            at -= 1;
        }
        self.distances[at] = distance;
        self.found[at] = place;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_are_those_of_a_look_at_all(
            places in prop::collection::vec((0u8..12, 0u8..12), 1..120),
            owners in prop::collection::vec(0u32..20, 120),
        ) {
            // On a coarse grid many are equal, and many distances are.
            let places: Vec<[f64; 2]> = places.iter().map(|(x, y)| [f64::from(*x), f64::from(*y)]).collect();
            let owners = &owners[..places.len()];
            let lists = nearest_of_others::<3>(&places, owners, &Control::new()).unwrap();
            for (i, list) in lists.iter().enumerate() {
                let distance = |j: u32| (0..2).map(|axis| (places[i][axis] - places[j as usize][axis]).powi(2)).sum::<f64>();
                let mut best = std::collections::BTreeMap::new();
                for j in (0..places.len() as u32).filter(|j| owners[*j as usize] != owners[i]) {
                    let least = best.entry(owners[j as usize]).or_insert(f64::INFINITY);
                    *least = least.min(distance(j));
                }
                let mut expected: Vec<f64> = best.into_values().collect();
                expected.sort_by(f64::total_cmp);
                expected.truncate(3);
                let found: Vec<f64> = list.iter().filter(|j| **j != NOBODY).map(|j| distance(*j)).collect();
                prop_assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn places_in_one_place_are_found_at_once() {
        let places = vec![[1.0, 2.0]; 100_000];
        let owners: Vec<u32> = (0..100_000).collect();
        let lists = nearest_of_others::<4>(&places, &owners, &Control::new()).unwrap();
        assert!(lists.as_flattened().iter().all(|other| *other != NOBODY));
        // All of one owner: nothing is found, and it ends.
        let lists = nearest_of_others::<4>(&places, &vec![7; 100_000], &Control::new()).unwrap();
        assert!(lists.as_flattened().iter().all(|other| *other == NOBODY));
    }
}
