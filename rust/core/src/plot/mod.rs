//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines.

mod curve;
mod entries;
mod improve;
mod near;
mod order;
mod path;
mod rings;
mod start;
mod stops;
mod tour;

pub use order::{ordered, travelled};
pub use path::{Path, PlotLayer};
