//! The node budget: one factor on the importance, clipped to [0, 1], found on the real first diffusion, so that the wanted
//! number of nodes is kept.
//!
//! The factor is applied to the lattice nodes' values. The number of nodes kept is close to the sum of the values after clipping,
//! less a part that varies slowly. So the search goes by that sum, which costs nothing to know. On most photos the first diffusion
//! meets the budget, where plain bisection needs eight.
//!
//! # Where no factor will do
//! The dynamic rule keeps flat fields at a few fixed densities only (1/4, 1/2, 3/4 and all on the hexagonal lattice, since
//! nothing but the order of ties tells nodes apart), and no factor lifts an importance of 0. When the search closes in on such a
//! jump, the importance is diffused with alpha = 1, which keeps the wanted share of any field, after a small constant is added to
//! it and it is varied a little.

use rayon::prelude::*;

use crate::base::{Control, Error, Result, noise};
use crate::diffusion::Diffusion;
use crate::graph::{Adjacency, Lattice};
use crate::options::Alpha;
use crate::sites::scan::diffuse_lattice;

/// How far from the budget the number of kept nodes may be, as a share of it.
const TOLERANCE: f64 = 0.01;

/// Diffusions after which a search gives up; the best one counts.
const MAX_DIFFUSIONS: usize = 12;

/// Added to the importance when alpha = 1 has to fill what the map leaves empty: a quarter of the least grey level of an
/// 8-bit map, so that it matters only where the map is 0 or the factor is large.
const FLOOR: f32 = 1.0 / 1024.0;

/// Share by which that importance varies from node to node, so that flat parts do not fall into a few regular patterns with jumps
/// between them. Less leaves jumps at small budgets; more is seen as noise.
const JITTER: f32 = 0.2;

/// The labels of the first phase under a budget of `nodes`, and the factor that gave them.
///
/// # Errors
/// [`Error::Input`] if the lattice has clearly fewer nodes than the budget; [`Error::Cancelled`].
pub(crate) fn meet(
    lattice: &Lattice,
    values: &[f32],
    nodes: f64,
    parameters: &Diffusion,
    control: &Control,
) -> Result<(Vec<u8>, f64)> {
    if nodes > lattice.len() as f64 * (1.0 + TOLERANCE) + 1.0 {
        return Err(Error::Input(format!(
            "the node budget is {nodes:.0}, but the lattice has only {} nodes: a higher density makes more",
            lattice.len()
        )));
    }
    let found = search(lattice, values, nodes, parameters, control)?;
    if found.miss <= allowed_miss(nodes) {
        return Ok((found.labels, found.factor));
    }
    let plain = Diffusion { alpha: Alpha::Constant(1.0), ..*parameters };
    let lifted: Vec<f32> = values.iter().enumerate().map(|(i, v)| (v + FLOOR) * (1.0 + JITTER * noise(i as u64))).collect();
    let found = search(lattice, &lifted, nodes, &plain, control)?;
    Ok((found.labels, found.factor))
}

/// One node more or less is met, whatever its share.
fn allowed_miss(nodes: f64) -> f64 {
    (TOLERANCE * nodes).max(1.0)
}

struct Found {
    labels: Vec<u8>,
    factor: f64,
    /// By how many nodes it misses the budget.
    miss: f64,
}

fn search(lattice: &Lattice, values: &[f32], nodes: f64, parameters: &Diffusion, control: &Control) -> Result<Found> {
    let sums = ClippedSum::new(values);
    let all = values.len() as f64;
    let attempt = |guess: f64| -> Result<Attempt> {
        let factor = sums.factor(guess);
        let scaled: Vec<f32> = values.par_iter().map(|v| (f64::from(*v) * factor).min(1.0) as f32).collect();
        let labels = diffuse_lattice(lattice, &scaled, parameters, control)?;
        let kept = labels.iter().filter(|label| **label == 1).count() as f64;
        Ok(Attempt { sum: sums.at(factor), kept, found: Found { labels, factor, miss: (kept - nodes).abs() } })
    };
    let lost = if matches!(parameters.alpha, Alpha::Constant(_)) { LOST_AT_ALPHA_1 } else { LOST };

    // Sums between which the budget lies, with the nodes kept there.
    let mut below = (0.0, 0.0);
    let mut above = (all, f64::INFINITY);
    let mut best: Option<Found> = None;
    let mut guess = (nodes + lost * all).min(all);
    let mut reach = 1.0;
    for _ in 0..MAX_DIFFUSIONS {
        let Attempt { sum, kept, found } = attempt(guess)?;
        if kept < nodes && sum >= below.0 {
            below = (sum, kept);
        } else if kept >= nodes && sum <= above.0 {
            above = (sum, kept);
        }
        if best.as_ref().is_none_or(|b| found.miss < b.miss) {
            best = Some(found);
        }
        let met = best.as_ref().is_some_and(|b| b.miss <= allowed_miss(nodes));
        if met || above.0 - below.0 <= 1e-4 * above.0 {
            break;
        }
        // With both ends known, where the straight line between them meets the budget, but not too close to either end; with
        // one, what was missing; where that did not do, a little more, so that the other end comes into sight.
        let line = if above.1.is_infinite() {
            below.0 + reach * (nodes - below.1)
        } else if below.0 == 0.0 {
            above.0 - reach * (above.1 - nodes)
        } else {
            let fraction = (nodes - below.1) / (above.1 - below.1);
            below.0 + fraction.clamp(0.1, 0.9) * (above.0 - below.0)
        };
        let span = above.0 - below.0;
        guess = line.clamp(below.0 + 0.02 * span, above.0);
        reach = OVERSHOOT;
    }
    best.ok_or_else(|| Error::Internal("the node budget was not searched for".into()))
}

/// A diffusion of the search.
struct Attempt {
    /// The clipped sum.
    sum: f64,
    kept: f64,
    found: Found,
}

/// How much further than what is missing a guess goes that is not the first.
const OVERSHOOT: f64 = 1.2;

/// Share of all nodes by which a diffusion that drops errors keeps fewer than the sum: 0.022 to 0.034 on photos, at 0.3 nodes a
/// pixel, where the tolerance is 0.006 to either side.
const LOST: f64 = 0.028;

/// The same at alpha = 1, which loses next to nothing.
const LOST_AT_ALPHA_1: f64 = 0.0;

/// The sum of `min(1, factor * value)` over all nodes, and the factor that makes it a given sum. It only guides the search, so on
/// large lattices every so many-th node stands for those behind it.
struct ClippedSum {
    /// The values above 0, in increasing order.
    values: Vec<f32>,
    /// `prefix[k]` is the sum of the first k values.
    prefix: Vec<f64>,
    /// How many nodes each value stands for.
    weight: f64,
}

/// Values that a [`ClippedSum`] looks at: enough to place a factor within a fraction of a per cent.
const CLIPPED_SUM_VALUES: usize = 1 << 16;

impl ClippedSum {
    fn new(values: &[f32]) -> Self {
        let stride = values.len().div_ceil(CLIPPED_SUM_VALUES);
        let all = values.iter().step_by(stride);
        let weight = values.len() as f64 / all.len() as f64;
        let mut values: Vec<f32> = all.copied().filter(|v| *v > 0.0).collect();
        values.par_sort_unstable_by(f32::total_cmp);
        let mut prefix = Vec::with_capacity(values.len() + 1);
        let mut sum = 0.0;
        prefix.push(sum);
        for value in &values {
            sum += f64::from(*value);
            prefix.push(sum);
        }
        Self { values, prefix, weight }
    }

    fn at(&self, factor: f64) -> f64 {
        let unclipped = self.values.partition_point(|v| f64::from(*v) * factor < 1.0);
        self.weight * (self.prefix[unclipped] * factor + (self.values.len() - unclipped) as f64)
    }

    /// The largest factor is that at which every value above 0 is clipped.
    fn factor(&self, sum: f64) -> f64 {
        let Some(smallest) = self.values.first() else {
            return 1.0;
        };
        let (mut low, mut high) = (0.0, 1.0 / f64::from(*smallest));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle) < sum { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{LatticeKind, Options, Order};

    fn kept(values: impl Fn(usize) -> f32, nodes: f64, order: Order) -> f64 {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 80, 60, 1.0).unwrap();
        let values: Vec<f32> = (0..lattice.len()).map(values).collect();
        let parameters = Diffusion { order, ..Diffusion::of_importance(&Options::paper()) };
        let (labels, _) = meet(&lattice, &values, nodes, &parameters, &Control::new()).unwrap();
        labels.iter().filter(|l| **l == 1).count() as f64
    }

    #[test]
    fn the_budget_is_met_on_smooth_flat_and_mostly_empty_maps() {
        for nodes in [200.0, 1000.0, 1500.0, 3500.0] {
            for (name, map) in [
                ("smooth", Box::new(|i: usize| (i % 80) as f32 / 79.0) as Box<dyn Fn(usize) -> f32>),
                ("flat", Box::new(|_| 0.3)),
                ("two flats", Box::new(|i| if i % 80 < 40 { 0.2 } else { 0.9 })),
                ("mostly empty", Box::new(|i| if i < 500 { 0.5 + (i % 7) as f32 / 20.0 } else { 0.0 })),
            ] {
                for order in [Order::Global, Order::Rows] {
                    let kept = kept(&map, nodes, order);
                    assert!((kept - nodes).abs() <= 0.02 * nodes, "{name}: {kept} of {nodes}");
                }
            }
        }
    }

    #[test]
    fn a_budget_beyond_the_lattice_is_refused() {
        let lattice = Lattice::new(LatticeKind::Square, 10, 10, 1.0).unwrap();
        let parameters = Diffusion::of_importance(&Options::paper());
        let error = meet(&lattice, &[0.5; 100], 150.0, &parameters, &Control::new()).unwrap_err().to_string();
        assert_eq!(error, "the node budget is 150, but the lattice has only 100 nodes: a higher density makes more");
    }

    #[test]
    fn some_values_stand_for_all_where_there_are_many() {
        let count = 3 * CLIPPED_SUM_VALUES + 5;
        let sums = ClippedSum::new(&vec![0.25; count]);
        assert!(sums.values.len() <= CLIPPED_SUM_VALUES);
        for (factor, each) in [(1.0, 0.25), (2.0, 0.5), (9.0, 1.0)] {
            assert!((sums.at(factor) - each * count as f64).abs() < 1e-6 * count as f64, "{factor}: {}", sums.at(factor));
        }
    }

    #[test]
    fn the_clipped_sum_and_its_factor_are_inverse() {
        let sums = ClippedSum::new(&[0.0, 0.1, 0.4, 0.5]);
        assert!((sums.at(2.0) - 2.0).abs() < 1e-6);
        assert!((sums.at(sums.factor(1.7)) - 1.7).abs() < 1e-6);
    }
}
