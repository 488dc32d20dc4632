//! Labels of drawings of several inks: what the folder above does for black and white, for mixtures of any labels. In: mixtures,
//! colours and areas of the nodes; out: a label of every node, and dots in smooth parts. Source: our own.

mod clean;
mod grounds;
mod label;
mod refine;
mod split;
mod stipple;

pub use clean::clean_inks;
pub use grounds::{NO_GROUND, grounds_inks};
pub use label::{Inked, label_inks};
pub use refine::refine_inks;
pub use split::split_inks;
pub use stipple::stipple_inks;

use crate::base::{Error, Result};
use crate::graph::check_one_a_node;

/// # Errors
/// [`Error::Input`] if there is not one label below `labels` a node; grounds may be [`NO_GROUND`] too.
fn check_labels_below(what: &str, found: &[u8], labels: usize, nodes: usize) -> Result<()> {
    check_one_a_node(what, found.len(), nodes)?;
    let is_wrong = |label: &u8| usize::from(*label) >= labels && !(what == "grounds" && *label == NO_GROUND);
    match found.iter().position(is_wrong) {
        Some(node) => Err(Error::Input(format!("node {node} of the {what} is {}, but it must be below {labels}", found[node]))),
        None => Ok(()),
    }
}
