//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines. Source: our own, but for what the files name.

mod assembly;
mod commands;
mod contour;
mod digits;
mod dots;
mod gcode;
mod hatch;
mod hpgl;
mod machine;
mod middle;
mod motion;
mod order;
mod path;
mod picture;
mod placing;
mod plot;
mod profile;
mod settings;
mod stats;
mod svg;
mod writing;

pub use assembly::plot;
pub use machine::{Corner, Cornering, Limit, Machine, MachineFormat, Upward};
pub use motion::Timing;
pub use order::{ordered, travelled};
pub use path::{Path, PlotLayer};
pub use picture::picture;
pub use plot::Plot;
pub use profile::{PROFILE_KEYS, ProfileKey, ShippedProfile};
pub use settings::{Fill, PEN_SETTINGS, Pen, PenDots, PenOrder, PenSetting};
pub use stats::PlotStats;
