//! The cores of white pieces: what of them is nowhere narrower than a bridge. In: a labelled graph, and how its boundaries are drawn;
//! out: the core that every white node belongs to.
//!
//! White may hang together by a hair, as where a line fades. A machine that cannot keep the hair cuts there, and what
//! was held falls out. So pieces are joined by their cores, and a way from one core to the next through such a neck is as good as
//! free, but is widened as one through black is. Black dots do not count here: where they stand too close, some of them are to go, and
//! no bridge helps.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use kurbo::Point;

use crate::base::{Control, Result, distance_to_segment};
use crate::graph::{Beside, Triangulation};
use crate::outlines::crossing;
use crate::rules::pieces::AtFrame;
use crate::rules::steiner::{NONE, Sets};

/// The part of half a bridge's width that boundaries keep from the nodes and edges of a core: the best line through a neck rarely runs
/// from node to node.
const KEPT: f64 = 0.85;

/// How a graph is drawn.
pub(super) struct Drawn<'a> {
    pub(super) triangulation: &'a Triangulation,
    pub(super) at_frame: &'a AtFrame,
    pub(super) labels: &'a [u8],
    pub(super) places: &'a [[f64; 2]],
    /// Areas of the cells, in px^2.
    pub(super) areas: &'a [f64],
    /// Tones that boundaries follow.
    pub(super) tones: Option<&'a [f32]>,
    /// Whether a node is drawn as a dot.
    pub(super) is_dot: &'a [bool],
}

/// The cores of white.
pub(super) struct Cores {
    /// Core of every node, or [`NONE`].
    pub(super) of_nodes: Vec<u32>,
    /// About the area of every core, in px^2.
    pub(super) areas: Vec<f64>,
    /// Whether a core is drawn to the frame.
    pub(super) is_held: Vec<bool>,
}

/// A piece of a boundary: a node, and the place in the graph's rows of an edge from it with the piece's triangle to its left.
type Rim = (u32, u32);

impl Drawn<'_> {
    fn place(&self, node: u32) -> Point {
        let [x, y] = self.places[node as usize];
        Point::new(x, y)
    }

    fn is_white(&self, node: u32) -> bool {
        self.labels[node as usize] == 1
    }

    /// Where the boundary crosses the edge between a black and a white node.
    fn crossing(&self, black: u32, white: u32) -> Point {
        let tone = |tones: &[f32], node: u32| f64::from(tones[node as usize]);
        let part = self.tones.map_or(0.5, |tones| crossing(tone(tones, black), tone(tones, white)));
        self.place(black).lerp(self.place(white), part)
    }

    /// The piece of the boundary in the triangle of an edge from a to b and a third node.
    fn piece(&self, a: u32, b: u32, third: u32) -> [Point; 2] {
        let ends = [[a, b], [b, third], [third, a]].map(|[from, to]| match [from, to].map(|node| self.is_white(node)) {
            [false, true] => Some(self.crossing(from, to)),
            [true, false] => Some(self.crossing(to, from)),
            _ => None,
        });
        let mut ends = ends.into_iter().flatten();
        let first = ends.next().unwrap_or(self.place(a));
        [first, ends.next().unwrap_or(first)]
    }

    /// How far a point is from a boundary.
    fn distance(&self, p: Point, (node, slot): Rim) -> f64 {
        let other = self.triangulation.graph.neighbors[slot as usize];
        let Beside::Node(third) = self.triangulation.left(slot as usize) else { return f64::INFINITY };
        let [a, b] = self.piece(node, other, third);
        distance_to_segment(p, a, b)
    }

    /// What of black is nearest to every white node, as far as `most` away.
    fn nearest_rims(&self, most: f64, control: &Control) -> Result<Vec<Option<(f64, Rim)>>> {
        let graph = &self.triangulation.graph;
        let mut nearest: Vec<Option<(f64, Rim)>> = vec![None; self.labels.len()];
        let mut open = BinaryHeap::new();
        let meet = |node: u32, rim: Rim, open: &mut BinaryHeap<Reached>, nearest: &mut Vec<Option<(f64, Rim)>>| {
            let distance = self.distance(self.place(node), rim);
            let known = &mut nearest[node as usize];
            if distance < most && known.is_none_or(|(known, _)| distance < known) {
                *known = Some((distance, rim));
                open.push(Reached { distance, node, rim });
            }
        };
        for node in 0..self.labels.len() as u32 {
            for slot in graph.offsets[node as usize]..graph.offsets[node as usize + 1] {
                let other = graph.neighbors[slot as usize];
                if self.is_white(node) == self.is_white(other) {
                    continue;
                }
                let Beside::Node(third) = self.triangulation.left(slot as usize) else { continue };
                if [node, other, third].into_iter().any(|corner| self.is_dot[corner as usize]) {
                    continue;
                }
                for corner in [node, other, third] {
                    if self.is_white(corner) {
                        meet(corner, (node, slot), &mut open, &mut nearest);
                    }
                }
            }
        }
        let mut steps = 0usize;
        while let Some(Reached { distance, node, rim }) = open.pop() {
            if nearest[node as usize].is_some_and(|(known, _)| known < distance) {
                continue;
            }
            steps += 1;
            if steps.is_multiple_of(1 << 14) {
                control.check()?;
            }
            for other in graph.row(node as usize).iter().filter(|other| self.is_white(**other)) {
                meet(*other, rim, &mut open, &mut nearest);
            }
        }
        Ok(nearest)
    }

    /// The cores for bridges of half this width.
    pub(super) fn cores(&self, half: f64, control: &Control) -> Result<Cores> {
        let graph = &self.triangulation.graph;
        let count = self.labels.len();
        let least = KEPT * half;
        let nearest = self.nearest_rims(2.0 * half, control)?;
        let is_wide = |node: u32| {
            self.is_white(node)
                && !self.is_dot[node as usize]
                && nearest[node as usize].is_none_or(|(distance, _)| distance >= least)
        };
        let mut sets = Sets::new(count);
        for node in (0..count as u32).filter(|node| is_wide(*node)) {
            for slot in graph.offsets[node as usize]..graph.offsets[node as usize + 1] {
                let other = graph.neighbors[slot as usize];
                if other > node || !is_wide(other) {
                    continue;
                }
                let middle = self.place(node).midpoint(self.place(other));
                let beyond = [Some(slot as usize), self.triangulation.slot(other, node)].into_iter().flatten();
                let thirds = beyond.filter_map(|slot| match self.triangulation.left(slot) {
                    Beside::Node(third) => Some(third),
                    Beside::Frame(_) => None,
                });
                let rims = thirds.chain([node, other]).filter_map(|near| nearest[near as usize].map(|(_, rim)| rim));
                if rims.into_iter().all(|rim| self.distance(middle, rim) >= least) {
                    sets.join(node, other);
                }
            }
        }
        let mut cores = Cores { of_nodes: vec![NONE; count], areas: Vec::new(), is_held: Vec::new() };
        let mut numbers = vec![NONE; count];
        for node in (0..count as u32).filter(|node| is_wide(*node)) {
            let number = &mut numbers[sets.find(node) as usize];
            if *number == NONE {
                *number = cores.areas.len() as u32;
                cores.areas.push(0.0);
                cores.is_held.push(false);
            }
            cores.of_nodes[node as usize] = *number;
            cores.is_held[*number as usize] |= self.at_frame.sides(node).is_some();
        }
        // What is beside a core is part of its breadth.
        for node in (0..count).filter(|node| self.labels[*node] == 1) {
            let own = std::iter::once(node as u32).chain(graph.row(node).iter().copied());
            if let Some(core) = own.map(|other| cores.of_nodes[other as usize]).find(|core| *core != NONE) {
                cores.areas[core as usize] += self.areas[node];
            }
        }
        Ok(cores)
    }
}

/// A node with black at some distance: the nearest first.
#[derive(PartialEq)]
struct Reached {
    distance: f64,
    node: u32,
    rim: Rim,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.node.cmp(&self.node)).then(other.rim.cmp(&self.rim))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
