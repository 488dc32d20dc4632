//! The order of a plot. In: paths in any order, and where the pen comes from; out: the same paths in an order in which the pen goes
//! little without drawing, and how far it goes.
//!
//! Paths become stops of a tour, which is begun, improved and shaken; closed paths have several places at which it may come to them.

mod curve;
mod entries;
mod improve;
mod near;
mod order;
mod rings;
mod start;
mod stops;
mod tour;

pub use order::{ordered, travelled};
