//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines.

mod assembly;
mod contour;
mod dots;
mod hatch;
mod middle;
mod order;
mod path;
mod picture;
mod plot;
mod settings;

pub use assembly::plot;
pub use path::{Path, PlotLayer};
pub use picture::picture;
pub use plot::Plot;
pub use settings::{Fill, PEN_SETTINGS, Pen, PenDots, PenOrder, PenSetting};
