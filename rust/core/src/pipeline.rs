//! The whole method: the only file that knows the order of the stages.

use crate::control::Control;
use crate::drawing::{Drawing, Stats};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::graph::Graph;
use crate::importance::Importance;
use crate::params::Options;

/// A drawing, and what the stages made on the way to it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The vector result.
    pub drawing: Drawing,
    /// Counts and times.
    pub stats: Stats,
    /// The second graph.
    pub graph: Graph,
    /// Tone of every node.
    pub tone: Vec<f32>,
    /// Label of every node: 0 black, 1 white.
    pub labels: Vec<u8>,
    /// Component id of every node.
    pub components: Vec<u32>,
    /// The importance on the canvas, before the budget's factor.
    pub importance: Field,
}

/// Draws a photo given as luma.
///
/// # Errors
/// [`Error::Option`] for an option out of range, [`Error::Cancelled`] after [`Control::cancel`].
pub fn draw(luma: &Field, importance: &Importance, options: &Options, control: &Control) -> Result<Outcome> {
    options.validate()?;
    let _ = (luma, importance, control);
    Err(Error::Internal("not built yet".into()))
}
