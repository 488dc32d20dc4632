//! Nodes labelled by priority, in one order over all.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::hint::black_box;

use crate::base::Result;
use crate::diffusion::task::{Task, UNLABELLED};
use crate::diffusion::weights::{LocalMean, Open, area_ratio, weigh};
use crate::graph::Adjacency;

/// Nodes labelled between two looks at the cancellation flag: a few milliseconds of work.
pub(super) const NODES_BETWEEN_CHECKS: usize = 1 << 14;

impl<G: Adjacency> Task<'_, G> {
    /// Labels the nodes by priority.
    pub(super) fn by_priority(&self) -> Result<Vec<u8>> {
        let &Self { graph, values, areas, parameters, .. } = self;
        let mut nodes: Vec<Node> = values.iter().map(|v| Node::new(*v)).collect();
        let mut queue = PriorityQueue::new(&mut nodes);
        let mut local_mean = LocalMean::of_hops(parameters.hops, self.control);
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
            let alpha = self.share_of(number, &mut local_mean)?;
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

/// All that the loop reads and writes of a node, side by side: nodes are visited in an order that no cache can foresee.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// The current value I.
    pub(super) current: f64,
    /// The starting value I0.
    start: f32,
    pub(super) label: u8,
    /// The bucket of the node's latest entry: never below that of its priority while it waits; see [`PriorityQueue`].
    entered: u16,
}

impl Node {
    pub(super) fn new(start: f32) -> Self {
        let current = f64::from(start);
        Self { current, start, label: UNLABELLED, entered: NO_BUCKET }
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
pub(super) struct PriorityQueue {
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
    pub(super) fn new(nodes: &mut [Node]) -> Self {
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
    pub(super) fn pop(&mut self, nodes: &mut [Node], graph: &impl Adjacency) -> Option<usize> {
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
    pub(super) fn update(&mut self, number: usize, node: &mut Node) {
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
