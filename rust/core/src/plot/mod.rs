//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines.

mod contour;
mod hatch;
mod middle;
mod path;

pub use path::{Path, PlotLayer};
