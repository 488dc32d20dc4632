//! What is black and what is white. In: labels as the diffusion gives them, with tones and areas of the nodes; out: labels that
//! follow tones and neighbours, with dots that fused by chance taken apart. Source: our own.

mod refine;
mod split;

pub use refine::{Refinement, refine};
pub use split::split;

/// What the nodes of the second graph are labelled.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// 0 black, 1 white.
    pub labels: Vec<u8>,
    /// The shift that gave them the photo's mean: see [`refine()`].
    pub shift: f64,
}
