//! How an error is shared among neighbours: weights, areas, and the mean around a node.

use crate::base::{Control, Result};
use crate::diffusion::parameters::Diffusion;
use crate::graph::Adjacency;

/// The most that an error grows when it is weighted by area, from a large cell to a small one.
pub(super) const MOST_AREA_RATIO: f64 = 16.0;

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
pub(super) fn exp(x: f64) -> f64 {
    libm::exp2(x * std::f64::consts::LOG2_E)
}

/// What an error is multiplied by on its way from a cell to another. A cell may own no sample at all, and then its area counts as 0.
pub(super) fn area_ratio(from: f64, to: f64) -> f64 {
    if from == to { 1.0 } else { (from / to).min(MOST_AREA_RATIO) }
}

/// Nodes over which means are taken, or that a search meets, between two looks at the cancellation flag: a few milliseconds of work.
const NODES_BETWEEN_CHECKS: usize = 1 << 18;

/// The mean of starting values over a node and those within some hops of it.
pub(crate) struct LocalMean<'a> {
    hops: u32,
    control: &'a Control,
    /// Nodes since the last look at the flag.
    unchecked: usize,
    /// The nodes that a search has reached, in order, with a place for every node and one more; and for every node whether it is one of
    /// them, false for all but during a search.
    reached: Vec<u32>,
    is_reached: Vec<bool>,
}

impl<'a> LocalMean<'a> {
    pub(crate) fn of_hops(hops: u32, control: &'a Control) -> Self {
        Self { hops, control, unchecked: 0, reached: Vec::new(), is_reached: Vec::new() }
    }

    /// The mean around `center`.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`]
    pub(crate) fn mean(&mut self, graph: &impl Adjacency, values: &[f32], center: usize) -> Result<f64> {
        if self.hops == 1 {
            // As nearly always; no node is met twice.
            return Ok(graph.mean_around(center, values));
        }
        let (mut sum, mut count) = (0.0, 0);
        let is_known = graph.for_each_run_within(center, self.hops as usize, |run| {
            count += run.len();
            // Row by row, so that the processor adds up several at once.
            sum += values[run].iter().map(|value| f64::from(*value)).sum::<f64>();
        });
        if is_known {
            self.count(count)?;
        } else {
            count = self.search(graph, center)?;
            for node in &self.reached[..count] {
                self.is_reached[*node as usize] = false;
                sum += f64::from(values[*node as usize]);
            }
        }
        Ok(sum / count as f64)
    }

    /// Reaches all nodes within the hops of `center`, breadth first, and returns how many they are.
    fn search(&mut self, graph: &impl Adjacency, center: usize) -> Result<usize> {
        // For all nodes, though a band meets few: memory that stays zero is not touched.
        if self.is_reached.is_empty() {
            self.is_reached = vec![false; graph.len()];
            self.reached = vec![0; graph.len() + 1];
        }
        self.reached[0] = center as u32;
        self.is_reached[center] = true;
        let (mut hop, mut count) = (0..1, 1);
        for _ in 0..self.hops {
            for k in hop.clone() {
                let mut met = 0;
                let Self { reached, is_reached, .. } = self;
                // Every neighbour is written down, and kept or overwritten by the next: no branch to guess wrong.
                graph.for_each_neighbor(reached[k] as usize, |neighbor, _| {
                    met += 1;
                    reached[count] = neighbor as u32;
                    count += usize::from(!std::mem::replace(&mut is_reached[neighbor], true));
                });
                self.count(met)?;
            }
            hop = hop.end..count;
        }
        Ok(count)
    }

    /// Counts nodes, and now and then looks at the flag.
    fn count(&mut self, nodes: usize) -> Result<()> {
        self.unchecked += nodes;
        if self.unchecked >= NODES_BETWEEN_CHECKS {
            self.unchecked = 0;
            self.control.check()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::base::{Error, noise};
    use crate::graph::{Graph, Lattice};
    use crate::options::LatticeKind;

    /// The definition: who is within a hop of those within one hop less.
    fn within(graph: &impl Adjacency, center: usize, hops: u32) -> BTreeSet<usize> {
        let mut found = BTreeSet::from([center]);
        for _ in 0..hops {
            for node in found.clone() {
                graph.for_each_neighbor(node, |neighbor, _| {
                    found.insert(neighbor);
                });
            }
        }
        found
    }

    fn mean(graph: &impl Adjacency, values: &[f32], center: usize, hops: u32) -> f64 {
        LocalMean::of_hops(hops, &Control::new()).mean(graph, values, center).unwrap()
    }

    fn any_lattice() -> impl Strategy<Value = Lattice> {
        (any::<bool>(), 1usize..50, 1usize..50, 0.1f64..1.5).prop_map(|(square, width, height, density)| {
            let kind = if square { LatticeKind::Square } else { LatticeKind::Hexagonal };
            Lattice::new(kind, width, height, density).unwrap()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_mean_is_over_all_nodes_within_the_hops(
            lattice in any_lattice(), place in 0.0f64..1.0, extra in prop::collection::vec(0.0f64..1.0, 4),
        ) {
            // Values that f64 adds up exactly in any order: then not even the last bit may differ.
            let values: Vec<f32> = (0..lattice.len()).map(|i| (noise(i as u64) * 65536.0).round() / 65536.0).collect();
            let node = |share: f64| (share * lattice.len() as f64) as usize;
            // As a graph with an edge or two across the lattice, which no closed form knows.
            let grid = lattice.to_graph();
            let mut edges: BTreeSet<[u32; 2]> = grid.edges().collect();
            for pair in extra.chunks(2).map(|pair| [pair[0], pair[1]].map(node)).filter(|[a, b]| a != b) {
                edges.insert([pair[0].min(pair[1]) as u32, pair[0].max(pair[1]) as u32]);
            }
            let graph = Graph::from_edges(lattice.sites(), &edges.into_iter().collect::<Vec<_>>()).unwrap();
            let [no_control, control] = [Control::new(), Control::new()];
            for hops in [1, 2, 5, 16] {
                let mut local_mean = LocalMean::of_hops(hops, &control);
                // One search after the other leaves nothing behind.
                for center in [place, 1.0 - place, place, 0.0, 0.999_999].map(|share| node(share).min(lattice.len() - 1)) {
                    let of = |nodes: BTreeSet<usize>| nodes.iter().map(|i| f64::from(values[*i])).sum::<f64>() / nodes.len() as f64;
                    let expected = of(within(&lattice, center, hops));
                    let mut of_lattice = LocalMean::of_hops(hops, &no_control);
                    prop_assert_eq!(of_lattice.mean(&lattice, &values, center).unwrap(), expected);
                    prop_assert_eq!(of_lattice.mean(&grid, &values, center).unwrap(), expected);
                    prop_assert_eq!(local_mean.mean(&graph, &values, center).unwrap(), of(within(&graph, center, hops)));
                }
            }
        }

        #[test]
        fn runs_of_a_lattice_hold_every_node_within_the_hops_once(lattice in any_lattice(), place in 0.0f64..1.0) {
            let center = (place * lattice.len() as f64) as usize;
            for hops in [0, 1, 2, 5, 16, 60] {
                let mut nodes = Vec::new();
                prop_assert!(lattice.for_each_run_within(center, hops, |run| nodes.extend(run)));
                prop_assert_eq!(nodes, within(&lattice, center, hops as u32).into_iter().collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn more_hops_reach_further() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], &[[0, 1], [1, 2]]).unwrap();
        assert_eq!([1, 2].map(|hops| mean(&graph, &[0.0, 0.5, 1.0], 0, hops)), [0.25, 0.5]);
    }

    #[test]
    fn means_end_when_they_are_cancelled_whatever_they_are_taken_over() {
        // One node joined to all others, from each of which all are two hops away: a single mean is long work.
        let spokes: Vec<[u32; 2]> = (1..100_000).map(|i| [0, i]).collect();
        let star = Graph::from_edges(vec![[0.0, 0.0]; 100_000], &spokes).unwrap();
        let lattice = Lattice::new(LatticeKind::Hexagonal, 300, 300, 1.0).unwrap();
        let control = Control::new();
        control.cancel();
        /// How many means were taken.
        fn taken(graph: &impl Adjacency, control: &Control) -> usize {
            let (values, mut local_mean) = (vec![0.5; graph.len()], LocalMean::of_hops(16, control));
            let ends = (0..graph.len()).position(|i| matches!(local_mean.mean(graph, &values, i), Err(Error::Cancelled)));
            ends.unwrap()
        }
        assert!(taken(&star, &control) <= NODES_BETWEEN_CHECKS / 100_000);
        // 817 nodes each where the frame cuts nothing off, a quarter in the corner where it begins.
        assert!(taken(&lattice, &control) <= NODES_BETWEEN_CHECKS / 200);
        assert!(taken(&lattice.to_graph(), &control) <= NODES_BETWEEN_CHECKS / 1000);
    }
}
