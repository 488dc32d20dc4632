//! What is black and what is white. In: labels as the diffusion gives them, with tones and areas of the nodes; out: labels that
//! follow tones and neighbours, and dots in smooth parts, with their places and areas. Source: our own.

mod clean;
mod inks;
mod places;
mod refine;
mod smooth;
mod split;
mod stipple;

pub use clean::clean;
pub use inks::{Inked, NO_GROUND, clean_inks, grounds_inks, label_inks, refine_inks, split_inks, stipple_inks};
pub(crate) use places::Places;
pub use refine::{Refinement, refine};
pub use smooth::{STRUCTURED, grounds};
pub(crate) use smooth::{drawn_tones, structured_mean};
pub use split::split;
pub use stipple::{Marks, Stippled, stipple};

use crate::base::Palette;
use crate::inks::Mixture;

/// What the nodes of the second graph are labelled.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// 0 black, 1 white; of several inks, numbers of their colours.
    pub labels: Vec<u8>,
    /// The shift that gave the labels of structured parts their mean: see [`refine()`].
    pub shift: f64,
    /// How the nodes are drawn, where smooth parts were stippled.
    pub marks: Option<Marks>,
    /// What the labels are of, if not of black and white.
    pub inks: Option<OfInks>,
}

/// What labels of other inks than black and white are of.
#[derive(Debug, Clone, PartialEq)]
pub struct OfInks {
    /// The inks and the paper.
    pub palette: Palette,
    /// The mixture of every node, which boundaries follow.
    pub mixtures: Vec<Mixture>,
}
