//! How an error is shared among neighbours: weights, areas, and the mean around a node.

use std::collections::HashSet;

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

/// The mean of starting values over a node and those within some hops of it.
#[derive(Default)]
pub(crate) struct LocalMean {
    radius: u32,
    /// The nodes reached so far, in order, and as a set.
    reached: Vec<usize>,
    seen: HashSet<usize>,
}

impl LocalMean {
    pub(crate) fn of_radius(radius: u32) -> Self {
        Self { radius, ..Self::default() }
    }

    pub(crate) fn mean(&mut self, graph: &impl Adjacency, values: &[f32], center: usize) -> f64 {
        if self.radius == 1 {
            // As nearly always; no node is met twice.
            return graph.mean_around(center, values);
        }
        self.reached.clear();
        self.seen.clear();
        self.reached.push(center);
        self.seen.insert(center);
        let mut hop = 0..1;
        for _ in 0..self.radius {
            for k in hop.clone() {
                graph.for_each_neighbor(self.reached[k], |neighbor, _| {
                    if self.seen.insert(neighbor) {
                        self.reached.push(neighbor);
                    }
                });
            }
            hop = hop.end..self.reached.len();
        }
        self.reached.iter().map(|node| f64::from(values[*node])).sum::<f64>() / self.reached.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Graph;

    #[test]
    fn more_hops_reach_further() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], &[[0, 1], [1, 2]]).unwrap();
        let mean = |radius| LocalMean { radius, ..LocalMean::default() }.mean(&graph, &[0.0, 0.5, 1.0], 0);
        assert_eq!([mean(1), mean(2)], [0.25, 0.5]);
    }
}
