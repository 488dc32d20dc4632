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
//! - One order over all nodes is serial, and jumps about in memory. With [`Order::Rows`] nodes are labelled one after the other, in
//!   bands side by side. They are numbered row by row, so that errors go on downwards. Each band starts some rows before its own,
//!   whose labels are forgotten, and so has the errors that come from there; what its last nodes pass on beyond it is dropped, since
//!   the next band has its own. Nodes of the first row begin with pseudo-random errors, or it would have too few dots. Labels do not
//!   depend on the threads. What [`crate::refine`] makes of them hardly depends on the order; bare, those by priority keep more of
//!   the photo's structure.
//! - On the lattice rows run to and fro: see [`crate::scan`].
//!
//! Values are never clamped; an error with no unlabelled neighbour left is dropped.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::control::Control;
use crate::error::Result;
use crate::graph::{Adjacency, check_areas, check_finite, check_one_a_node};
use crate::noise::noise;
use crate::params::{Alpha, Options, Order};

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
    /// In which order nodes are labelled.
    pub order: Order,
}

impl Diffusion {
    /// The diffusion of importance over the lattice.
    pub fn of_importance(options: &Options) -> Self {
        Self { alpha: options.importance_alpha, order: options.importance_order, ..Self::of_tone(options) }
    }

    /// The diffusion of tone over the second graph.
    pub fn of_tone(options: &Options) -> Self {
        let Options { k1, k2, base, detail_gain, rings, alpha, order, .. } = *options;
        Self { k1, k2, base, detail_gain, rings, alpha, order }
    }

    /// Whether a node of the starting value `start` that got this label may pass an error on.
    pub(crate) fn passes_on(&self, start: f64, label: u8) -> bool {
        self.alpha != Alpha::Dynamic || (label == 1) == (start >= 0.5)
    }

    /// The share of its error that it passes on if so: alpha. `mean` is the local mean around it.
    pub(crate) fn share(&self, start: f64, mean: impl FnOnce() -> f64) -> f64 {
        match self.alpha {
            Alpha::Constant(alpha) => alpha,
            Alpha::Tonal => self.base * tonal_share(start),
            Alpha::Dynamic => self.base + self.detail_gain * (start - mean()).abs(),
        }
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
    check_input(graph, values, areas)?;
    let task = Task { graph, values, areas, parameters, control };
    match parameters.order {
        Order::Global => task.by_priority(),
        Order::Rows => task.by_number(band_size(values.len())),
    }
}

/// # Errors
/// [`Error::Input`] if there is not one finite value, and one area of at least 0, a node.
pub(crate) fn check_input(graph: &impl Adjacency, values: &[f32], areas: Option<&[f64]>) -> Result<()> {
    check_one_a_node("values", values.len(), graph.len())?;
    check_finite("value", values)?;
    if let Some(areas) = areas {
        check_one_a_node("areas", areas.len(), graph.len())?;
        check_areas("area", areas)?;
    }
    Ok(())
}

/// Nodes of a band at least: below, threads cost more than they bring.
const LEAST_BAND: usize = 4096;

/// Rows of a band, on a square canvas.
const ROWS_IN_BAND: usize = 64;

/// This share of a band's nodes is labelled before it: some 16 rows.
const WARM_UP_IN_BAND: usize = 4;

/// How many nodes a band has where there are `count`, but for the last, which may have fewer. It depends on nothing else, or
/// drawings would.
pub(crate) fn band_size(count: usize) -> usize {
    let least = LEAST_BAND.max(ROWS_IN_BAND * count.isqrt());
    count.div_ceil((count / least).max(1)).max(1)
}

/// A diffusion of valid input.
struct Task<'a, G> {
    graph: &'a G,
    values: &'a [f32],
    areas: Option<&'a [f64]>,
    parameters: &'a Diffusion,
    control: &'a Control,
}

impl<G: Adjacency> Task<'_, G> {
    /// Labels the nodes in the order of their numbers, in bands of `size`.
    fn by_number(&self, size: usize) -> Result<Vec<u8>> {
        let mut labels = vec![UNLABELLED; self.values.len()];
        let done = AtomicUsize::new(0);
        labels.par_chunks_mut(size).enumerate().try_for_each(|(band, labels)| {
            self.label_band(band * size, size / WARM_UP_IN_BAND, labels);
            let done = done.fetch_add(labels.len(), Ordering::Relaxed) + labels.len();
            self.control.report(done as f32 / self.values.len() as f32)
        })?;
        Ok(labels)
    }

    /// Labels the nodes from `first` on, after up to `warm_up` before them.
    fn label_band(&self, first: usize, warm_up: usize, labels: &mut [u8]) {
        let &Self { graph, values, areas, parameters, .. } = self;
        let tried = first.saturating_sub(warm_up)..first + labels.len();
        let mut received = vec![0.0; tried.len()];
        let mut rings = Rings::of_radius(parameters.rings);
        let mut open: Vec<Open> = Vec::with_capacity(16);
        for number in tried.clone() {
            let start = f64::from(values[number]);
            let mut current = start + received[number - tried.start];
            if first == 0 && self.is_at_the_top(number) {
                // No row has passed errors on to it: what they might be.
                current += 0.5 * f64::from(noise(number as u64)) * self.share_of(number, &mut rings);
            }
            let label = u8::from(current >= 0.5);
            if number >= first {
                labels[number - first] = label;
            }
            let error = current - f64::from(label);
            if error == 0.0 || !parameters.passes_on(start, label) {
                continue;
            }
            let alpha = self.share_of(number, &mut rings);
            if alpha == 0.0 {
                continue;
            }
            open.clear();
            graph.for_each_neighbor(number, |neighbor, distance| {
                if neighbor > number {
                    open.push(Open { number: neighbor as u32, start: values[neighbor], weight: distance });
                }
            });
            if open.is_empty() {
                continue;
            }
            let share = alpha * error / weigh(&mut open, start, parameters);
            for other in &open {
                let neighbor = other.number as usize;
                if let Some(received) = received.get_mut(neighbor - tried.start) {
                    *received += other.weight * share * areas.map_or(1.0, |areas| area_ratio(areas[number], areas[neighbor]));
                }
            }
        }
    }

    /// Whether less than a third of a node's neighbours have lower numbers, and can pass errors on to it.
    fn is_at_the_top(&self, number: usize) -> bool {
        let (mut before, mut all) = (0, 0);
        self.graph.for_each_neighbor(number, |neighbor, _| {
            before += usize::from(neighbor < number);
            all += 1;
        });
        3 * before < all
    }

    /// The share of its error that a node passes on.
    fn share_of(&self, number: usize, rings: &mut Rings) -> f64 {
        self.parameters.share(f64::from(self.values[number]), || rings.mean(self.graph, self.values, number))
    }

    /// Labels the nodes by priority.
    fn by_priority(&self) -> Result<Vec<u8>> {
        let &Self { graph, values, areas, parameters, .. } = self;
        let mut nodes: Vec<Node> = values.iter().map(|v| Node::new(*v)).collect();
        let mut queue = PriorityQueue::new(&mut nodes);
        let mut rings = Rings::of_radius(parameters.rings);
        let mut open: Vec<Open> = Vec::with_capacity(16);
        let mut labelled = 0;

        while let Some(number) = queue.pop(&mut nodes, graph) {
            if labelled % NODES_BETWEEN_CHECKS == 0 {
                self.control.report(labelled as f32 / nodes.len() as f32)?;
            }
            labelled += 1;
            let node = &mut nodes[number];
            let start = f64::from(node.start);
            let label = u8::from(node.current >= 0.5);
            node.label = label;
            let error = node.current - f64::from(label);
            if error == 0.0 || !parameters.passes_on(start, label) {
                continue;
            }
            // Every neighbour is written down, and kept or overwritten by the next: with no branch to guess wrong, the processor
            // fetches all of them at once.
            let mut count = 0;
            graph.for_each_neighbor(number, |neighbor, distance| {
                if count == open.len() {
                    open.push(Open::default());
                }
                let other = &nodes[neighbor];
                open[count] = Open { number: neighbor as u32, start: other.start, weight: distance };
                count += usize::from(other.label == UNLABELLED);
            });
            let open = &mut open[..count];
            if open.is_empty() {
                continue;
            }
            let alpha = self.share_of(number, &mut rings);
            if alpha == 0.0 {
                continue;
            }
            let share = alpha * error / weigh(open, start, parameters);
            for other in open {
                let neighbor = other.number as usize;
                let ratio = areas.map_or(1.0, |areas| area_ratio(areas[number], areas[neighbor]));
                let node = &mut nodes[neighbor];
                node.current += other.weight * share * ratio;
                queue.update(neighbor, node);
            }
        }
        Ok(nodes.into_iter().map(|node| node.label).collect())
    }
}

/// An unlabelled neighbour of the node that is labelled.
#[derive(Clone, Copy, Default)]
pub(crate) struct Open {
    pub(crate) number: u32,
    /// The starting value I0.
    pub(crate) start: f32,
    /// First its distance in pixels, then its weight, unnormalised.
    pub(crate) weight: f64,
}

/// Turns the distances of open neighbours, one at least, from a node of the value `start` into weights, and returns their sum.
pub(crate) fn weigh(open: &mut [Open], start: f64, parameters: &Diffusion) -> f64 {
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
        other.weight = if other.weight == largest { 1.0 } else { exp(other.weight - largest) };
        total += other.weight;
    }
    total
}

/// `e` to the power of x, by the power of 2, which takes half the time.
fn exp(x: f64) -> f64 {
    libm::exp2(x * std::f64::consts::LOG2_E)
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
        Self { current, start, label: UNLABELLED, entered: NO_BUCKET }
    }
}

/// Stands for "no label yet".
const UNLABELLED: u8 = 2;

/// The mean of starting values over a node and some rings of neighbours.
#[derive(Default)]
pub(crate) struct Rings {
    radius: u32,
    /// The nodes reached so far, in order, and as a set.
    reached: Vec<usize>,
    seen: HashSet<usize>,
}

impl Rings {
    pub(crate) fn of_radius(radius: u32) -> Self {
        Self { radius, ..Self::default() }
    }

    pub(crate) fn mean(&mut self, graph: &impl Adjacency, values: &[f32], center: usize) -> f64 {
        if self.radius == 1 {
            // As nearly always; no node is met twice.
            let (mut sum, mut count) = (f64::from(values[center]), 1.0);
            graph.for_each_neighbor(center, |neighbor, _| {
                sum += f64::from(values[neighbor]);
                count += 1.0;
            });
            return sum / count;
        }
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
        self.reached.iter().map(|node| f64::from(values[*node])).sum::<f64>() / self.reached.len() as f64
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
    fn new(nodes: &mut [Node]) -> Self {
        let mut counts = vec![0u32; BUCKETS];
        for node in &mut *nodes {
            node.entered = bucket(priority(node.current));
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
    use crate::error::Error;
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
                let precedes = |n: usize| p.order == Order::Global && (value - 0.5).abs() > (current[n] - 0.5).abs();
                if labels[i] == UNLABELLED && next.is_none_or(precedes) {
                    next = Some(i);
                }
            }
            let i = next.unwrap();
            let start = f64::from(values[i]);
            let row: Vec<usize> = graph.row(i).iter().map(|j| *j as usize).collect();
            let mean = row.iter().fold(start, |sum, j| sum + f64::from(values[*j])) / (row.len() + 1) as f64;
            let alpha = match p.alpha {
                Alpha::Constant(alpha) => alpha,
                Alpha::Dynamic => p.base + p.detail_gain * (start - mean).abs(),
                Alpha::Tonal => p.base * tonal_share(start),
            };
            if p.order == Order::Rows && 3 * row.iter().filter(|j| **j < i).count() < row.len() {
                current[i] += 0.5 * f64::from(noise(i as u64)) * alpha;
            }
            let label = u8::from(current[i] >= 0.5);
            labels[i] = label;
            let error = current[i] - f64::from(label);
            let alpha = if p.alpha != Alpha::Dynamic || (label == 1) == (start >= 0.5) { alpha } else { 0.0 };
            let open: Vec<usize> = row.into_iter().filter(|j| labels[*j] == UNLABELLED).collect();
            let exponent = |j: &usize| {
                let d = crate::graph::distance_squared(graph.sites[i], graph.sites[*j]).sqrt();
                -(p.k1 * (start - f64::from(values[*j])).abs() + p.k2 * d).powi(2)
            };
            let largest = open.iter().map(exponent).fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = open.iter().map(|j| exp(exponent(j) - largest)).collect();
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
            order in prop_oneof![Just(Order::Rows), Just(Order::Global)], by_area in any::<bool>(),
            seed in prop::collection::vec(0.0f32..1.0, 600),
        ) {
            let kind = if square { LatticeKind::Square } else { LatticeKind::Hexagonal };
            let graph = Lattice::new(kind, width, height, 1.5).unwrap().to_graph();
            // Eighths make many exact ties, at 0 and 1 too.
            let values: Vec<f32> = (0..graph.sites.len()).map(|i| if eighths { (seed[i] * 9.0).floor() / 8.0 } else { seed[i] }).collect();
            let cells: Vec<f64> = values.iter().rev().map(|v| 0.01 + f64::from(*v)).collect();
            let areas = by_area.then_some(&cells[..]);
            let p = Diffusion { alpha, order, ..Diffusion::of_tone(&Options::default()) };
            prop_assert_eq!(diffuse(&graph, &values, areas, &p, &Control::new()).unwrap(), oracle(&graph, &values, areas, &p));
        }
    }

    /// A flat grey with a little noise, which keeps the order of ties from making patterns.
    fn grey(lattice: &Lattice, value: f32) -> Vec<f32> {
        (0..lattice.len()).map(|i| value + 0.02 * crate::noise::noise(i as u64)).collect()
    }

    fn of_order(order: Order) -> Diffusion {
        Diffusion { alpha: Alpha::Constant(1.0), order, ..Diffusion::of_tone(&Options::default()) }
    }

    #[test]
    fn bands_are_of_a_size_that_depends_on_the_number_of_nodes_alone() {
        assert_eq!([0, 1, 16_255, 16_256, 1 << 20].map(band_size), [1, 1, 16_255, 8128, 1 << 16]);
        assert!(diffuse(&Graph::default(), &[], None, &of_order(Order::Rows), &Control::new()).unwrap().is_empty());
    }

    fn by_number(lattice: &Lattice, values: &[f32], size: usize) -> Vec<u8> {
        let (parameters, control) = (of_order(Order::Rows), Control::new());
        Task { graph: lattice, values, areas: None, parameters: &parameters, control: &control }.by_number(size).unwrap()
    }

    #[test]
    fn labels_do_not_depend_on_the_threads() {
        let lattice = Lattice::new(LatticeKind::Square, 150, 150, 1.0).unwrap();
        let values = grey(&lattice, 0.4);
        // Bands of 11 rows, of parts of rows, and of less than a row.
        for size in [1650, 1000, 64, 1] {
            let [one, two, five] = [1, 2, 5].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| by_number(&lattice, &values, size))
            });
            assert!(one == two && two == five && one.iter().all(|label| *label < UNLABELLED), "{size}");
        }
    }

    #[test]
    fn bands_do_not_show_in_a_flat_grey() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 200, 1600, 1.0).unwrap();
        let values = grey(&lattice, 0.3);
        let columns = lattice.nodes_in_two_rows() / 2;
        let labels = by_number(&lattice, &values, 64 * columns);
        let sum = |labels: &[u8]| labels.iter().map(|label| f64::from(*label)).sum::<f64>();
        let wanted: f64 = values.iter().map(|value| f64::from(*value)).sum();
        assert!((sum(&labels) - wanted).abs() < 0.003 * wanted, "{} of {wanted}", sum(&labels));
        let rows: Vec<f64> = labels.chunks_exact(columns).map(|row| sum(row) / columns as f64).collect();
        // The rows at this distance from a seam, all seams together; labels drawn at random would scatter by 0.007.
        let seams = rows.len() / 64 - 1;
        for distance in 0..8 {
            let at_seams = (1..=seams).map(|band| rows[64 * band + distance - 4]).sum::<f64>() / seams as f64;
            assert!((at_seams - 0.3).abs() < 0.02, "{distance}: {at_seams}");
        }
    }

    #[test]
    fn a_cancelled_diffusion_ends() {
        let lattice = Lattice::new(LatticeKind::Square, 200, 200, 1.0).unwrap();
        let control = Control::new();
        control.cancel();
        for order in [Order::Rows, Order::Global] {
            let ended = diffuse(&lattice, &grey(&lattice, 0.3), None, &of_order(order), &control);
            assert!(matches!(ended, Err(Error::Cancelled)));
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
        let p = of_order(Order::Global);
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
        let p = of_order(Order::Global);
        let labels = diffuse(&graph, &[0.95, 0.52, 0.52], None, &p, &Control::new()).unwrap();
        // Node 0 takes 0.05 from its neighbours' white: the nearer one falls below 0.5.
        assert_eq!(labels, [1, 0, 1]);
    }

    #[test]
    fn more_rings_reach_further() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], &[[0, 1], [1, 2]]).unwrap();
        let mean = |radius| Rings { radius, ..Rings::default() }.mean(&graph, &[0.0, 0.5, 1.0], 0);
        assert_eq!([mean(1), mean(2)], [0.25, 0.5]);
    }
}
