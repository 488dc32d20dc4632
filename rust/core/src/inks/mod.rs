//! Colours as mixtures of inks. In: the colours of paper and inks, and colours of a photo; out: in which parts labels, each of one
//! colour, mix to a colour, and inks proposed for a photo. Source: our own.

mod extract;
mod mixture;

pub use extract::extract;
pub use mixture::{MOST_LABELS, Mixing, Mixture, mixtures};
pub(crate) use mixture::{axes, check_mixtures};
