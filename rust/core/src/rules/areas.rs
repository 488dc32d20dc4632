//! Which area lies in which, and which of them are too small.
//!
//! Black areas lie in the sheet or in a hole of another one, and a hole is white that touches no frame. What goes becomes one
//! with what is around it and in it, all of which is of the other ink: together they may be large enough. So the smallest goes
//! first, and what it has become a part of is looked at anew when all is done.

use crate::base::signed_area;
use crate::offset::Polygon;
use crate::rules::nesting::containers;

/// Black areas and the white in them: nodes of a tree whose root is the sheet.
pub(super) struct Nesting {
    /// What surrounds every node; the sheet itself.
    around: Vec<usize>,
    /// The area and the ring of every node but the sheet: ring 0 stands for the black area, the others for its holes.
    pub(super) rings: Vec<[usize; 2]>,
    /// How large every node is, without what lies in it.
    pub(super) sizes: Vec<f64>,
    /// The node of every area; its holes come next.
    first: Vec<usize>,
}

/// The node of the sheet.
const SHEET: usize = 0;

impl Nesting {
    pub(super) fn of(areas: &[Polygon]) -> Self {
        let mut first = Vec::with_capacity(areas.len());
        let mut rings = vec![[usize::MAX; 2]];
        for (number, area) in areas.iter().enumerate() {
            first.push(rings.len());
            rings.extend((0..area.len()).map(|ring| [number, ring]));
        }
        let mut around = vec![SHEET; rings.len()];
        for (number, area) in areas.iter().enumerate() {
            around[first[number] + 1..first[number] + area.len()].fill(first[number]);
        }
        for (number, hole) in containers(areas).into_iter().enumerate() {
            if let Some((outer, ring)) = hole {
                around[first[number]] = first[outer as usize] + ring as usize;
            }
        }
        let mut sizes = vec![f64::INFINITY; rings.len()];
        for node in 1..rings.len() {
            sizes[node] = signed_area(&areas[rings[node][0]][rings[node][1]]).abs();
        }
        for node in 1..rings.len() {
            let enclosed = signed_area(&areas[rings[node][0]][rings[node][1]]).abs();
            if around[node] != SHEET {
                sizes[around[node]] -= enclosed;
            }
        }
        Self { around, rings, sizes, first }
    }

    /// The nodes that are smaller than `least` and go, no two of which lie beside each other.
    pub(super) fn too_small(&self, least: f64) -> Vec<usize> {
        let count = self.rings.len();
        let mut order: Vec<usize> = (1..count).filter(|node| self.sizes[*node] < least).collect();
        order.sort_by(|a, b| self.sizes[*a].total_cmp(&self.sizes[*b]).then(a.cmp(b)));
        let mut is_joined = vec![false; count];
        let mut inside: Vec<Vec<usize>> = vec![Vec::new(); if order.is_empty() { 0 } else { count }];
        for node in 1..inside.len() {
            inside[self.around[node]].push(node);
        }
        order.retain(|&node| {
            let goes = !is_joined[node];
            if goes {
                inside[node].iter().for_each(|other| is_joined[*other] = true);
                is_joined[self.around[node]] = true;
            }
            goes
        });
        order
    }

    /// The areas when these nodes have become what is around them, as [`Nesting::too_small`] gives them: of every area that
    /// stays, the rings that it then has, by area and number, its own first.
    pub(super) fn without(&self, gone: &[usize]) -> Vec<Vec<[usize; 2]>> {
        let mut is_gone = vec![false; self.rings.len()];
        gone.iter().for_each(|node| is_gone[*node] = true);
        let mut left: Vec<Vec<[usize; 2]>> = vec![Vec::new(); self.first.len()];
        for (number, &node) in self.first.iter().enumerate().filter(|(_, node)| !is_gone[**node]) {
            // Where the hole around it is filled, it is one with what has that hole.
            let mut owner = number;
            let mut outer = self.around[node];
            while outer != SHEET && is_gone[outer] {
                owner = self.rings[outer][0];
                outer = self.around[self.first[owner]];
            }
            if owner == number {
                left[number].insert(0, [number, 0]);
            }
            let end = self.first.get(number + 1).copied().unwrap_or(self.rings.len());
            left[owner].extend((node + 1..end).filter(|hole| !is_gone[*hole]).map(|hole| self.rings[hole]));
        }
        left.retain(|rings| !rings.is_empty());
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(a: f64, b: f64) -> Vec<[f64; 2]> {
        vec![[a, a], [b, a], [b, b], [a, b]]
    }

    fn hole(a: f64, b: f64) -> Vec<[f64; 2]> {
        square(a, b).into_iter().rev().collect()
    }

    #[test]
    fn the_smallest_goes_first_and_what_it_joins_stays() {
        // A black ring of 1 mm, with a large white middle, and in it a black square with a white one.
        let areas = [vec![square(5.0, 35.0), hole(6.0, 34.0)], vec![square(10.0, 14.0), hole(11.0, 13.0)]];
        let nesting = Nesting::of(&areas);
        assert_eq!(nesting.around, [0, 0, 1, 2, 3]);
        assert_eq!(nesting.sizes[1..], [116.0, 768.0, 12.0, 4.0]);
        assert!(nesting.too_small(4.0).is_empty());
        assert_eq!(nesting.too_small(5.0), [4]);
        assert_eq!(nesting.without(&[4]), [vec![[0, 0], [0, 1]], vec![[1, 0]]]);
        // The square that was filled is looked at anew, then.
        assert_eq!(nesting.too_small(200.0), [4, 1]);
        assert_eq!(nesting.without(&[4, 1]), [vec![[1, 0]]]);
        assert_eq!(nesting.without(&[3]), [vec![[0, 0], [0, 1]]]);
        // Of the black in a hole that is filled its own hole stays.
        assert_eq!(nesting.without(&[2]), [vec![[0, 0], [1, 1]]]);
    }

    #[test]
    fn areas_in_a_row_lie_in_the_same() {
        let areas: Vec<Polygon> = (0..5).map(|i| vec![square(f64::from(i) * 3.0, f64::from(i) * 3.0 + 2.0)]).collect();
        let outer = vec![square(-1.0, 20.0), hole(-0.5, 19.0)];
        let all: Vec<Polygon> = areas.into_iter().chain([outer]).collect();
        let nesting = Nesting::of(&all);
        assert_eq!(nesting.around[1..6], [7; 5]);
        assert_eq!(nesting.around[6..], [0, 6]);
    }
}
