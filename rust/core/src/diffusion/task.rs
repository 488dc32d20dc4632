//! A diffusion, whatever the order of its nodes.

use crate::base::{Control, Result};
use crate::diffusion::parameters::Diffusion;
use crate::diffusion::weights::LocalMean;
use crate::graph::Adjacency;

/// Stands for "no label yet".
pub(super) const UNLABELLED: u8 = 2;

/// A diffusion of valid input.
pub(super) struct Task<'a, G> {
    pub(super) graph: &'a G,
    pub(super) values: &'a [f32],
    pub(super) areas: Option<&'a [f64]>,
    pub(super) parameters: &'a Diffusion,
    pub(super) control: &'a Control,
}

impl<G: Adjacency> Task<'_, G> {
    /// The share of its error that a node passes on.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`]
    pub(super) fn share_of(&self, number: usize, local_mean: &mut LocalMean<'_>) -> Result<f64> {
        self.parameters.share(f64::from(self.values[number]), || local_mean.mean(self.graph, self.values, number))
    }
}
