//! Priority error diffusion on a graph: labels every node 0 or 1 (both phases of the paper use this routine).
//!
//! Nodes are labelled in order of decreasing `|I - 0.5|` by their *current* value I, ties by index, and pass a share alpha of
//! their error on to their unlabelled neighbours, by weights that fall with the difference of starting values and with distance.
//!
//! # Readings of the paper
//! - Weights are normalised to sum 1, since alpha = 1 is said to preserve tone; unnormalised, six neighbours would receive up to
//!   six times the error.
//! - The printed condition of the alpha rule, sign(e) = sign(I0 - 0.5), makes alpha 0 for every node whose value is in range.
//!   The rule here asks on which side of 0.5 the *label* fell.
//! - The local mean is over one ring by default; the paper says only "local average intensity".
//! - Distances are in pixels.
//!
//! # Ours
//! - The paper's alpha jumps with the side of the label and keeps dots in the lightest and darkest tones, where a drawing should be
//!   clean. [`tonal_share`] is continuous and depends on the node's own value alone.
//! - Where small cells meet large ones, an error carried as a value does not keep the tone; carried by area it does.
//!
//! Values are never clamped; an error with no unlabelled neighbour left is dropped.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};
use std::hint::black_box;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::graph::Adjacency;
use crate::params::{Alpha, Options};

/// The parameters of one diffusion; ranges as in [`Options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffusion {
    /// Weight of the difference of starting values.
    pub k1: f64,
    /// Weight of the distance, per pixel.
    pub k2: f64,
    /// Tonal alpha in middle tones, or dynamic alpha where there is no detail.
    pub base: f64,
    /// Growth of dynamic alpha with `|I0 - A|`: the paper's lambda.
    pub detail_gain: f64,
    /// Radius of the local mean A, in rings of neighbours, at least 1.
    pub rings: u32,
    /// Share of the error that is passed on.
    pub alpha: Alpha,
}

impl Diffusion {
    /// The diffusion of importance over the lattice.
    pub fn of_importance(options: &Options) -> Self {
        Self { alpha: options.importance_alpha, ..Self::of_tone(options) }
    }

    /// The diffusion of tone over the second graph.
    pub fn of_tone(options: &Options) -> Self {
        let Options { k1, k2, base, detail_gain, rings, alpha, .. } = *options;
        Self { k1, k2, base, detail_gain, rings, alpha }
    }
}

/// The most that an error grows when it is carried from a large cell to a small one.
const MOST_AREA_RATIO: f64 = 16.0;

/// The share of `base` that [`Alpha::Tonal`] passes on at a value I0: t^1.5 (1 - t)^2 scaled to 1 at its highest, t = 3/7, and 0 at
/// black and white, which stay clean. Dark tones get more than light ones as far from 0.5: white dots in the dark are what shape is
/// seen by there, whereas in the light paper alone passes for the tone.
pub fn tonal_share(value: f64) -> f64 {
    let t = value.clamp(0.0, 1.0);
    let highest = (3.0 / 7.0) * f64::sqrt(3.0 / 7.0) * (4.0 / 7.0) * (4.0 / 7.0);
    t * t.sqrt() * (1.0 - t) * (1.0 - t) / highest
}

/// Nodes labelled between two looks at the cancellation flag: a few milliseconds of work.
const NODES_BETWEEN_CHECKS: usize = 1 << 14;

/// A label for every node: 0 black, 1 white. With `areas`, the areas of the nodes' cells in px^2, errors are carried by area
/// ([`crate::params::Carry`]).
///
/// # Errors
/// [`Error::Input`] if there is not one finite value, and one area of at least 0, a node; [`Error::Cancelled`].
///
/// # Runtime
/// `n log n` at worst, for values that are all nearly the same; close to linear on photos.
pub fn diffuse(
    graph: &impl Adjacency,
    values: &[f32],
    areas: Option<&[f64]>,
    parameters: &Diffusion,
    control: &Control,
) -> Result<Vec<u8>> {
    if values.len() != graph.len() {
        return Err(Error::Input(format!("there are {} values for {} nodes, but every node needs one", values.len(), graph.len())));
    }
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return Err(Error::Input(format!("the value of node {i} is {}, but it must be finite", values[i])));
    }
    if let Some(areas) = areas {
        if areas.len() != graph.len() {
            return Err(Error::Input(format!(
                "there are {} areas for {} nodes, but every node needs one",
                areas.len(),
                graph.len()
            )));
        }
        if let Some(i) = areas.iter().position(|area| !(*area >= 0.0 && area.is_finite())) {
            return Err(Error::Input(format!("the area of node {i} is {}, but it must be at least 0 px^2", areas[i])));
        }
    }
    let mut nodes: Vec<Node> = values.iter().map(|v| Node::new(*v)).collect();
    let mut queue = PriorityQueue::new(&nodes);
    let mut rings = Rings { radius: parameters.rings, ..Rings::default() };
    let mut open: Vec<Open> = Vec::with_capacity(16);
    let mut done = 0;

    while let Some(number) = queue.pop(&mut nodes, graph) {
        if done % NODES_BETWEEN_CHECKS == 0 {
            control.report(done as f32 / values.len() as f32)?;
        }
        done += 1;
        let node = &mut nodes[number];
        let start = f64::from(node.start);
        let label = u8::from(node.current >= 0.5);
        node.label = label;
        let error = node.current - f64::from(label);

        let keeps_side = (label == 1) == (start >= 0.5);
        if error == 0.0 || (parameters.alpha == Alpha::Dynamic && !keeps_side) {
            continue;
        }
        // Every neighbour is written down, and kept or overwritten by the next: with no branch to guess wrong, the processor
        // fetches all of them at once.
        let mut count = 0;
        let (mut sum, mut degree) = (start, 1.0);
        graph.for_each_neighbor(number, |neighbor, distance| {
            if count == open.len() {
                open.push(Open::default());
            }
            let other = &nodes[neighbor];
            open[count] = Open { number: neighbor as u32, start: other.start, weight: distance };
            count += usize::from(other.label == UNLABELLED);
            sum += f64::from(other.start);
            degree += 1.0;
        });
        let open = &mut open[..count];
        if open.is_empty() {
            continue;
        }
        let alpha = match parameters.alpha {
            Alpha::Constant(alpha) => alpha,
            Alpha::Tonal => parameters.base * tonal_share(start),
            Alpha::Dynamic => {
                let mean = if parameters.rings == 1 { sum / degree } else { rings.mean(graph, &nodes, number) };
                parameters.base + parameters.detail_gain * (start - mean).abs()
            }
        };
        if alpha == 0.0 {
            continue;
        }
        let share = alpha * error / weigh(open, start, parameters);
        for other in open {
            let neighbor = other.number as usize;
            let node = &mut nodes[neighbor];
            node.current += other.weight * share * areas.map_or(1.0, |areas| area_ratio(areas[number], areas[neighbor]));
            queue.update(neighbor, node);
        }
    }
    Ok(nodes.into_iter().map(|node| node.label).collect())
}

/// An unlabelled neighbour of the node that is labelled.
#[derive(Clone, Copy, Default)]
struct Open {
    number: u32,
    /// The starting value I0.
    start: f32,
    /// First its distance in pixels, then its weight, then unnormalised.
    weight: f64,
}

/// Turns the distances of open neighbours, one at least, from a node of the value `start` into weights, and returns their sum.
fn weigh(open: &mut [Open], start: f64, parameters: &Diffusion) -> f64 {
    if let [only] = open {
        only.weight = 1.0;
        return 1.0;
    }
    // The largest exponent is subtracted, or weights underflow to 0 / 0 where neighbours are hundreds of pixels apart.
    let mut largest = f64::NEG_INFINITY;
    for other in &mut *open {
        let length = parameters.k1 * (start - f64::from(other.start)).abs() + parameters.k2 * other.weight;
        other.weight = -(length * length);
        largest = largest.max(other.weight);
    }
    let mut total = 0.0;
    for other in open {
        other.weight = if other.weight == largest { 1.0 } else { libm::exp(other.weight - largest) };
        total += other.weight;
    }
    total
}

/// What an error is multiplied by on its way from a cell to another. A cell may own no sample at all, and then its area counts as 0.
fn area_ratio(from: f64, to: f64) -> f64 {
    if from == to { 1.0 } else { (from / to).min(MOST_AREA_RATIO) }
}

/// All that the loop reads and writes of a node, side by side: nodes are visited in an order that no cache can foresee.
#[derive(Clone, Copy)]
struct Node {
    /// The current value I.
    current: f64,
    /// The starting value I0.
    start: f32,
    label: u8,
    /// The bucket of the node's latest entry: never below that of its priority while it waits; see [`PriorityQueue`].
    entered: u16,
}

impl Node {
    fn new(start: f32) -> Self {
        let current = f64::from(start);
        Self { current, start, label: UNLABELLED, entered: bucket(priority(current)) }
    }
}

/// Stands for "no label yet".
const UNLABELLED: u8 = 2;

/// The mean of starting values over a node and more than one ring of neighbours.
#[derive(Default)]
struct Rings {
    radius: u32,
    /// The nodes reached so far, in order, and as a set.
    reached: Vec<usize>,
    seen: HashSet<usize>,
}

impl Rings {
    fn mean(&mut self, graph: &impl Adjacency, nodes: &[Node], center: usize) -> f64 {
        self.reached.clear();
        self.seen.clear();
        self.reached.push(center);
        self.seen.insert(center);
        let mut ring = 0..1;
        for _ in 0..self.radius {
            for k in ring.clone() {
                graph.for_each_neighbor(self.reached[k], |neighbor, _| {
                    if self.seen.insert(neighbor) {
                        self.reached.push(neighbor);
                    }
                });
            }
            ring = ring.end..self.reached.len();
        }
        self.reached.iter().map(|node| f64::from(nodes[*node].start)).sum::<f64>() / self.reached.len() as f64
    }
}

/// Buckets over priorities from 0 to 1 (values that errors pushed out of [0, 1] go beyond 0.5), a power of two. More make shorter
/// lists to sort, fewer make nodes whose priority falls move less often.
const BUCKETS: usize = 2048;

/// The bucket of what waits in none.
const NO_BUCKET: u16 = u16::MAX;

/// A node with the bits of its priority when it was entered; the largest comes first, ties by index.
type Entry = (u64, Reverse<u32>);

/// All unlabelled nodes by decreasing `|I - 0.5|`, ties by index: exactly the order of one big heap, at a fraction of its cost.
///
/// A node stands in the bucket of its priority. Only the highest bucket in use is sorted; what is entered into it or above
/// later goes to a small heap beside it. A node whose priority rises is entered again at once; one whose priority falls stays
/// where it is, too high, and is entered again when it comes up there. That spares most entries, since most errors move a value
/// several times. Entries that are no longer true are dropped when they come up.
struct PriorityQueue {
    buckets: Vec<Vec<u32>>,
    /// The bucket whose nodes, and all above, are in `sorted` and `late`.
    lowest: u16,
    /// In increasing order: the next node is the last.
    sorted: Vec<Entry>,
    late: BinaryHeap<Entry>,
    /// Priority, number and bucket of the nodes of a bucket; empty but while it is sorted.
    seen: Vec<(u64, u32, u16)>,
}

impl PriorityQueue {
    fn new(nodes: &[Node]) -> Self {
        let mut counts = vec![0u32; BUCKETS];
        for node in nodes {
            counts[usize::from(node.entered)] += 1;
        }
        let mut buckets: Vec<Vec<u32>> = counts.iter().map(|c| Vec::with_capacity(*c as usize)).collect();
        for (number, node) in (0u32..).zip(nodes) {
            buckets[usize::from(node.entered)].push(number);
        }
        Self { buckets, lowest: BUCKETS as u16, sorted: Vec::new(), late: BinaryHeap::new(), seen: Vec::new() }
    }

    /// The unlabelled node of the highest priority.
    fn pop(&mut self, nodes: &mut [Node], graph: &impl Adjacency) -> Option<usize> {
        loop {
            let next = match (self.sorted.last(), self.late.peek()) {
                (Some(first), Some(late)) if late > first => self.late.pop(),
                (Some(_), _) => self.sorted.pop(),
                (None, _) => self.late.pop(),
            };
            let Some((key, Reverse(number))) = next else {
                self.refill(nodes)?;
                self.fetch(nodes, graph);
                continue;
            };
            let node = &mut nodes[number as usize];
            if node.label != UNLABELLED {
                continue;
            }
            let priority = priority(node.current);
            if key == priority.to_bits() {
                return Some(number as usize);
            }
            let bucket = bucket(priority);
            if bucket < self.lowest && node.entered >= self.lowest {
                node.entered = bucket;
                self.buckets[usize::from(bucket)].push(number);
            }
        }
    }

    /// Sorts the highest bucket that is not empty; `None` when all are.
    fn refill(&mut self, nodes: &mut [Node]) -> Option<()> {
        let highest = (0..usize::from(self.lowest)).rev().find(|b| !self.buckets[*b].is_empty())?;
        self.lowest = highest as u16;
        // First all are looked at, with no branch that depends on what is seen: the processor then fetches many at once.
        for number in std::mem::take(&mut self.buckets[highest]) {
            let node = &nodes[number as usize];
            let priority = priority(node.current);
            let waits = (node.label == UNLABELLED) & (node.entered == self.lowest);
            let bucket = if waits { bucket(priority) } else { NO_BUCKET };
            self.seen.push((priority.to_bits(), number, bucket));
        }
        for (key, number, bucket) in self.seen.drain(..) {
            if bucket == self.lowest {
                self.sorted.push((key, Reverse(number)));
            } else if bucket != NO_BUCKET {
                nodes[number as usize].entered = bucket;
                self.buckets[usize::from(bucket)].push(number);
            }
        }
        self.sorted.sort_unstable();
        Some(())
    }

    /// Looks at the neighbours of the nodes that come next, so that they are in the cache by then. Memory is what a diffusion waits
    /// for, since the order of nodes is as good as random; looked at one node after the other, without work in between, many are
    /// fetched at once. What is seen does not matter.
    fn fetch(&self, nodes: &[Node], graph: &impl Adjacency) {
        let (mut labels, mut reach) = (0, 0.0);
        for (_, Reverse(number)) in &self.sorted {
            graph.for_each_neighbor(*number as usize, |neighbor, distance| {
                labels |= nodes[neighbor].label;
                reach += distance;
            });
        }
        black_box((labels, reach));
    }

    /// Says that the value of an unlabelled node changed.
    fn update(&mut self, number: usize, node: &mut Node) {
        let priority = priority(node.current);
        let bucket = bucket(priority);
        if bucket >= self.lowest {
            node.entered = bucket;
            self.late.push((priority.to_bits(), Reverse(number as u32)));
        } else if bucket > node.entered {
            node.entered = bucket;
            self.buckets[usize::from(bucket)].push(number as u32);
        }
    }
}

/// Not negative, so that the order of its bits is the order of its values.
fn priority(value: f64) -> f64 {
    (value - 0.5).abs()
}

fn bucket(priority: f64) -> u16 {
    // Adding 1 aligns the bits: all of [0, 1) has one exponent, and the next bits are the bucket.
    let bits = (1.0 + priority).to_bits() - 1f64.to_bits();
    (bits >> (52 - BUCKETS.ilog2())).min(BUCKETS as u64 - 1) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Graph;
    use crate::lattice::Lattice;
    use crate::params::LatticeKind;
    use proptest::prelude::*;

    /// The definition, read literally: look for the next node among all, every time.
    fn oracle(graph: &Graph, values: &[f32], areas: Option<&[f64]>, p: &Diffusion) -> Vec<u8> {
        let mut current: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let mut labels = vec![UNLABELLED; values.len()];
        for _ in 0..values.len() {
            let mut next = None;
            for (i, value) in current.iter().enumerate() {
                if labels[i] == UNLABELLED && next.is_none_or(|n: usize| (value - 0.5).abs() > (current[n] - 0.5).abs()) {
                    next = Some(i);
                }
            }
            let i = next.unwrap();
            let label = u8::from(current[i] >= 0.5);
            labels[i] = label;
            let error = current[i] - f64::from(label);
            let start = f64::from(values[i]);
            let row: Vec<usize> = graph.row(i).iter().map(|j| *j as usize).collect();
            let mean = row.iter().fold(start, |sum, j| sum + f64::from(values[*j])) / (row.len() + 1) as f64;
            let alpha = match p.alpha {
                Alpha::Constant(alpha) => alpha,
                Alpha::Dynamic if (label == 1) == (start >= 0.5) => p.base + p.detail_gain * (start - mean).abs(),
                Alpha::Dynamic => 0.0,
                Alpha::Tonal => p.base * tonal_share(start),
            };
            let open: Vec<usize> = row.into_iter().filter(|j| labels[*j] == UNLABELLED).collect();
            let exponent = |j: &usize| {
                let d = crate::graph::distance_squared(graph.sites[i], graph.sites[*j]).sqrt();
                -(p.k1 * (start - f64::from(values[*j])).abs() + p.k2 * d).powi(2)
            };
            let largest = open.iter().map(exponent).fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = open.iter().map(|j| libm::exp(exponent(j) - largest)).collect();
            let total: f64 = weights.iter().sum();
            for (j, w) in open.iter().zip(&weights) {
                current[*j] += w * (alpha * error / total) * areas.map_or(1.0, |a| (a[i] / a[*j]).min(16.0));
            }
        }
        labels
    }

    proptest! {
        #[test]
        fn labels_equal_the_definition(
            width in 1usize..14, height in 1usize..14, square in any::<bool>(), eighths in any::<bool>(),
            alpha in prop_oneof![Just(Alpha::Dynamic), Just(Alpha::Tonal), (0.0f64..=1.0).prop_map(Alpha::Constant)],
            by_area in any::<bool>(), seed in prop::collection::vec(0.0f32..1.0, 600),
        ) {
            let kind = if square { LatticeKind::Square } else { LatticeKind::Hexagonal };
            let graph = Lattice::new(kind, width, height, 1.5).unwrap().to_graph();
            // Eighths make many exact ties, at 0 and 1 too.
            let values: Vec<f32> = (0..graph.sites.len()).map(|i| if eighths { (seed[i] * 9.0).floor() / 8.0 } else { seed[i] }).collect();
            let cells: Vec<f64> = values.iter().rev().map(|v| 0.01 + f64::from(*v)).collect();
            let areas = by_area.then_some(&cells[..]);
            let p = Diffusion { alpha, ..Diffusion::of_tone(&Options::default()) };
            prop_assert_eq!(diffuse(&graph, &values, areas, &p, &Control::new()).unwrap(), oracle(&graph, &values, areas, &p));
        }
    }

    #[test]
    fn tonal_alpha_is_highest_in_dark_middle_tones_and_nothing_at_black_and_white() {
        assert_eq!([0.0, 1.0, -0.5, 1.5].map(tonal_share), [0.0; 4]);
        assert!((tonal_share(3.0 / 7.0) - 1.0).abs() < 1e-12);
        for value in [0.1, 0.3, 0.42, 0.44, 0.6, 0.9] {
            assert!(tonal_share(value) < 1.0 && tonal_share(0.5 - value / 2.0) > tonal_share(0.5 + value / 2.0), "{value}");
        }
    }

    #[test]
    fn errors_carried_by_area_keep_the_tone_where_small_cells_meet_large_ones() {
        // A node of 1 px^2 and its only neighbour of 4: what the first makes too light darkens the second by a quarter of it.
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0]], &[[0, 1]]).unwrap();
        let p = Diffusion { alpha: Alpha::Constant(1.0), ..Diffusion::of_tone(&Options::default()) };
        let label = |areas| diffuse(&graph, &[0.7, 0.6], areas, &p, &Control::new()).unwrap();
        assert_eq!(label(None), [1, 0]);
        assert_eq!(label(Some(&[1.0, 4.0][..])), [1, 1]);
        assert_eq!(area_ratio(0.0, 0.0), 1.0);
        assert_eq!(area_ratio(1.0, 0.0), MOST_AREA_RATIO);
        assert!(diffuse(&graph, &[0.7, 0.6], Some(&[1.0]), &p, &Control::new()).is_err());
        assert!(diffuse(&graph, &[0.7, 0.6], Some(&[1.0, -1.0]), &p, &Control::new()).is_err());
    }

    #[test]
    fn nodes_hundreds_of_pixels_apart_still_pass_their_error_on() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [900.0, 0.0], [0.0, 901.0]], &[[0, 1], [0, 2]]).unwrap();
        let p = Diffusion { alpha: Alpha::Constant(1.0), ..Diffusion::of_tone(&Options::default()) };
        let labels = diffuse(&graph, &[0.95, 0.52, 0.52], None, &p, &Control::new()).unwrap();
        // Node 0 takes 0.05 from its neighbours' white: the nearer one falls below 0.5.
        assert_eq!(labels, [1, 0, 1]);
    }

    #[test]
    fn more_rings_reach_further() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], &[[0, 1], [1, 2]]).unwrap();
        let nodes = [0.0, 0.5, 1.0].map(Node::new);
        let mean = |radius| Rings { radius, ..Rings::default() }.mean(&graph, &nodes, 0);
        assert_eq!([mean(1), mean(2)], [0.25, 0.5]);
    }
}
