//! Priority error diffusion on a graph: labels every node 0 or 1 (both phases of the paper use this routine). In: a graph and a
//! value of every node; out: a label of every node. Source: the paper.
//!
//! Nodes are labelled in order of decreasing `|I - 0.5|` by their *current* value I, ties by index, and pass a share alpha of
//! their error on to their unlabelled neighbours, by weights that fall with the difference of starting values and with distance.
//!
//! # Readings of the paper
//! - Weights are normalised to sum 1, since alpha = 1 is said to preserve tone; unnormalised, six neighbours would receive up to
//!   six times the error.
//! - The printed condition of the alpha rule, sign(e) = sign(I0 - 0.5), makes alpha 0 for every node whose value is in range.
//!   The rule here asks on which side of 0.5 the *label* fell.
//! - The local mean is over one hop by default; the paper says only "local average intensity".
//! - Distances are in pixels.
//!
//! # Ours
//! - The paper's alpha jumps with the side of the label and keeps dots in the lightest and darkest tones, where a drawing should be
//!   clean. [`tonal_share`] is continuous and depends on the node's own value alone.
//! - Where small cells meet large ones, an error that counts by its value does not keep the tone; weighted by area it does.
//! - One order over all nodes is serial, and jumps about in memory. With [`crate::stages::Order::Rows`] nodes are labelled one
//!   after the other, in bands side by side. They are numbered row by row, so that errors go on downwards. Each band starts some
//!   rows before its own, whose labels are forgotten, and so has the errors that come from there; what its last nodes pass on
//!   beyond it is dropped, since the next band has its own. Nodes of the first row begin with pseudo-random errors, or it would
//!   have too few dots. Labels do not depend on the threads. What [`crate::stages::refine`] makes of them hardly depends on the
//!   order; bare, those by priority keep more of the photo's structure.
//! - On the lattice rows run to and fro: see [`crate::stages::diffuse_lattice`].
//!
//! Values are never clamped; an error with no unlabelled neighbour left is dropped.

mod diffuse;
mod inks;
mod parameters;
mod priority;
mod rows;
mod task;
mod weights;

pub(crate) use diffuse::check_input;
pub use diffuse::diffuse;
pub use inks::diffuse_inks;
pub use parameters::{Diffusion, tonal_share};
pub(crate) use rows::band_size;
pub(crate) use weights::{LocalMean, Open, weigh};
