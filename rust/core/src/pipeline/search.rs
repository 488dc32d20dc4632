//! The search for the finest drawing that fits a limit: in, how large each drawing came out against the limit; out, with which tolerance
//! and how many nodes to draw next.
//!
//! Only numbers pass through here. First the drawing as it was asked for; if it is too large, contours are simplified further, up to half
//! the distance of the nodes, where that cannot be seen yet; then there are fewer nodes. Sizes are nearly powers of the number of nodes,
//! so the next number is read off a straight line through the logarithms of the last two.

/// Drawings that are made at most.
pub(crate) const MOST_TRIALS: usize = 8;

/// A drawing that takes up this share of its limit is as fine as the limit allows.
const ENOUGH: f64 = 0.98;

/// The share that is aimed at: the middle of what is enough.
const AIM: f64 = 0.99;

/// How far contours may be simplified to make a drawing smaller, relative to the distance of the nodes. Twice the default; further, hardly
/// a point is saved (docs/output.md) and small marks lose their shape.
const SIMPLIFIED: f64 = 0.5;

/// By how much steps become longer that fell short twice: more often goes too far.
const LONGER: f64 = 1.5;

/// The largest tolerance that there is, in pixels.
const MOST_TOLERANCE: f64 = 2.0;

/// Fewer nodes make no triangle.
const LEAST_NODES: u64 = 3;

/// Tolerances are tried in steps of this many pixels, so that they are short where they are written.
const TOLERANCE_STEP: f64 = 0.001;

/// What a trial is drawn with, where it differs from what was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    /// How far contours are simplified, in pixels.
    pub(crate) tolerance: f64,
    /// How many nodes to keep; `None`: as it was asked for.
    pub(crate) nodes: Option<u64>,
}

/// The trials so far, and how large the drawings came out.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    asked: f64,
    /// The largest tolerance that is tried.
    simplest: f64,
    /// Nodes of the drawing as it was asked for, once it is there.
    nodes: u64,
    /// What was tried, and its size as a share of the limit.
    sizes: Vec<(Trial, f64)>,
}

impl Search {
    /// A search from this tolerance on, of a drawing whose nodes would lie so far apart if they were spread evenly.
    pub(crate) fn new(tolerance: f64, spacing: f64) -> Self {
        let simplest = rounded((SIMPLIFIED * spacing).min(MOST_TOLERANCE)).max(tolerance);
        Self { asked: tolerance, simplest, nodes: 0, sizes: Vec::new() }
    }

    /// What to draw next; `None` when the search is over.
    pub(crate) fn next(&self) -> Option<Trial> {
        let as_asked = |tolerance| Some(Trial { tolerance, nodes: None });
        let Some((_, first)) = self.sizes.first() else { return as_asked(self.asked) };
        let is_enough = |share: f64| (ENOUGH..=1.0).contains(&share);
        if *first <= 1.0 || self.sizes.len() == MOST_TRIALS || self.sizes.iter().any(|(_, share)| is_enough(*share)) {
            return None;
        }
        if self.sizes.len() == 1 && self.simplest > self.asked {
            return as_asked(self.simplest);
        }
        let of_asked = self.sizes.iter().filter(|(trial, _)| trial.nodes.is_none());
        if of_asked.clone().any(|(_, share)| *share <= 1.0) {
            let sizes: Vec<[f64; 2]> = of_asked.map(|(trial, share)| [trial.tolerance, share.ln()]).collect();
            // Whole steps, but no finer than what was asked for and no coarser than the largest.
            let tolerance = rounded(coarser(&sizes, 0.0)?).clamp(self.asked, self.simplest);
            return if self.is_tried(Trial { tolerance, nodes: None }) { None } else { as_asked(tolerance) };
        }
        // From here on there are fewer nodes, all with the largest tolerance.
        let nodes = self.fewer_nodes()?;
        let trial = Trial { tolerance: self.simplest, nodes: Some(nodes) };
        (!self.is_tried(trial)).then_some(trial)
    }

    /// Says how large the drawing that [`Search::next`] asked for came out, as a share of the limit, and with how many nodes.
    pub(crate) fn tell(&mut self, trial: Trial, share: f64, nodes: u64) {
        if self.sizes.is_empty() {
            self.nodes = nodes.max(LEAST_NODES);
        }
        self.sizes.push((trial, share));
    }

    /// How many drawings were made.
    pub(crate) fn trials(&self) -> usize {
        self.sizes.len()
    }

    fn is_tried(&self, trial: Trial) -> bool {
        self.sizes.iter().any(|(tried, _)| *tried == trial)
    }

    /// The next number of nodes.
    fn fewer_nodes(&self) -> Option<u64> {
        let simplest = self.sizes.iter().filter(|(trial, _)| trial.tolerance == self.simplest);
        let nodes_of = |trial: &Trial| trial.nodes.unwrap_or(self.nodes);
        let sizes: Vec<[f64; 2]> = simplest.map(|(trial, share)| [-(nodes_of(trial) as f64).ln(), share.ln()]).collect();
        let fits = |size: &[f64; 2]| size[1] <= 0.0;
        if self.sizes.len() == MOST_TRIALS - 1 && !sizes.iter().any(fits) {
            // The last one says what is possible at all.
            return Some(LEAST_NODES);
        }
        let nodes = ((-coarser(&sizes, -1.0)?).exp().round() as u64).clamp(LEAST_NODES, self.nodes);
        // Next to one that is too large there may still be room.
        let tried = |nodes: u64| self.sizes.iter().any(|(trial, _)| nodes_of(trial) == nodes);
        [nodes, nodes.saturating_sub(1).max(LEAST_NODES)].into_iter().find(|nodes| !tried(*nodes))
    }
}

/// A tolerance in whole steps.
fn rounded(tolerance: f64) -> f64 {
    // Divided, so that it is the float nearest to its decimals.
    (tolerance / TOLERANCE_STEP).round() / TOLERANCE_STEP.recip().round()
}

/// How coarse to draw next. `sizes` holds how coarse and how large drawings were, both so that they are related by about a straight
/// line, and 0 is the limit; the first is too large. `slope` is what that line falls with as far as one point can tell.
fn coarser(sizes: &[[f64; 2]], slope: f64) -> Option<f64> {
    let aim = AIM.ln();
    let fitting = sizes.iter().filter(|size| size[1] <= 0.0).copied().reduce(|a, b| if b[0] < a[0] { b } else { a });
    let too_large = sizes.iter().filter(|size| size[1] > 0.0 && fitting.is_none_or(|fitting| size[0] < fitting[0]));
    let large = too_large.copied().reduce(|a, b| if b[0] > a[0] { b } else { a })?;
    let Some(small) = fitting else {
        // Nothing fits yet: on along the line through the last two.
        let before = sizes.iter().filter(|size| size[0] < large[0]).copied().reduce(|a, b| if b[0] > a[0] { b } else { a });
        let found = before.map_or(slope, |before| (large[1] - before[1]) / (large[0] - before[0]));
        // A line that hardly falls leads far away, and one that rises nowhere.
        let step = (aim - large[1]) / found.min(0.2 * slope);
        // What every file has, however coarse the drawing, bends the line: then each step falls short, so they become longer.
        return Some(large[0] + if sizes.len() < 3 { step } else { LONGER * step });
    };
    let along = (large[1] - aim) / (large[1] - small[1]);
    // Two in a row on one side: a curve that is far from straight is halved.
    let is_stuck = matches!(sizes, [.., a, b, c] if (a[1] > 0.0) == (b[1] > 0.0) && (b[1] > 0.0) == (c[1] > 0.0));
    let along = if is_stuck { 0.5 } else { along.clamp(0.05, 0.95) };
    Some(large[0] + along * (small[0] - large[0]))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Runs a search to its end on drawings of this size; returns what was tried.
    fn searched(tolerance: f64, spacing: f64, nodes: u64, size: impl Fn(f64, f64) -> f64) -> Vec<(Trial, f64)> {
        let mut search = Search::new(tolerance, spacing);
        while let Some(trial) = search.next() {
            let kept = trial.nodes.unwrap_or(nodes);
            search.tell(trial, size(trial.tolerance, kept as f64), kept);
            assert!(search.trials() <= MOST_TRIALS);
        }
        search.sizes
    }

    fn largest_that_fits(sizes: &[(Trial, f64)]) -> Option<(Trial, f64)> {
        sizes.iter().copied().filter(|(_, share)| *share <= 1.0).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    #[test]
    fn what_fits_is_left_as_it_is() {
        assert_eq!(searched(0.5, 2.0, 1000, |_, _| 1.0), [(Trial { tolerance: 0.5, nodes: None }, 1.0)]);
    }

    #[test]
    fn contours_are_simplified_before_nodes_go() {
        let sizes = searched(0.5, 3.0, 1000, |tolerance, _| 1.25 - 0.3 * tolerance);
        assert!(sizes.iter().all(|(trial, _)| trial.nodes.is_none() && (0.5..=1.5).contains(&trial.tolerance)), "{sizes:?}");
        assert_eq!(sizes[1].0.tolerance, 1.5);
        let (trial, share) = largest_that_fits(&sizes).unwrap();
        assert!(share >= ENOUGH && trial.tolerance < 0.95 && sizes.len() <= 4, "{sizes:?}");
        assert_eq!(trial.tolerance, format!("{:.3}", trial.tolerance).parse::<f64>().unwrap());
        // No further than the option goes, and not back from where it is.
        assert_eq!(searched(0.5, 40.0, 1000, |_, _| 2.0)[1].0.tolerance, 2.0);
        assert_eq!(searched(1.8, 2.0, 1000, |_, _| 2.0)[1].0, Trial { tolerance: 1.8, nodes: Some(495) });
    }

    #[test]
    fn what_never_fits_ends_with_the_fewest_nodes() {
        for share in [1.001, 1.5, 7.0, 1e6] {
            let sizes = searched(0.5, 2.0, 300_000, |_, _| share);
            assert_eq!(sizes.last().unwrap().0.nodes, Some(3), "{sizes:?}");
        }
        let sizes = searched(0.5, 2.0, 300_000, |_, nodes| 1.0 + nodes / 300_000.0);
        assert!(sizes.len() <= MOST_TRIALS && sizes.last().unwrap().0.nodes == Some(3), "{sizes:?}");
        assert!(searched(0.5, 2.0, 3, |_, _| 5.0).len() == 2);
    }

    proptest! {
        /// Sizes that grow with a power of the nodes, with something that every file has, and some unevenness.
        #[test]
        fn the_finest_that_fits_is_found(
            nodes in 1000u64..300_000,
            power in 0.6f64..1.1,
            fixed in 0.0f64..0.2,
            saved in 0.0f64..0.2,
            limit in 0.01f64..0.99,
            seed: u64,
        ) {
            // Below that a node more or less is more than what is allowed for.
            prop_assume!(limit * nodes as f64 > 200.0 && limit > 1.2 * fixed);
            let uneven = |nodes: f64| 1.0 + 0.002 * ((nodes + (seed % 1000) as f64) * 0.37).sin();
            let size = |tolerance: f64, kept: f64| {
                let share = fixed + (1.0 - fixed) * (kept / nodes as f64).powf(power) * (1.0 - saved * (tolerance - 0.5));
                share * uneven(kept) / limit
            };
            let sizes = searched(0.5, 2.0, nodes, size);
            let found = largest_that_fits(&sizes);
            prop_assert!(found.is_some_and(|(_, share)| share >= ENOUGH), "{:?}", sizes);
        }

        /// Whatever sizes come, the search ends.
        #[test]
        fn it_ends_with_any_sizes(shares in prop::collection::vec(prop_oneof![1e-3f64..1e3, Just(0.0)], 8), nodes in 3u64..1_000_000, tolerance in 0.0f64..2.0) {
            let mut search = Search::new(tolerance, 3.0);
            while let Some(trial) = search.next() {
                prop_assert!((3..=nodes).contains(&trial.nodes.unwrap_or(nodes)) && (tolerance..=2.0).contains(&trial.tolerance));
                prop_assert!(search.sizes.iter().all(|(tried, _)| *tried != trial));
                let share = shares[search.trials()];
                search.tell(trial, share, trial.nodes.unwrap_or(nodes));
            }
            prop_assert!(search.trials() <= MOST_TRIALS);
        }
    }
}
