//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines.

mod assembly;
mod commands;
mod contour;
mod curve;
mod digits;
mod dots;
mod entries;
mod gcode;
mod hatch;
mod hpgl;
mod improve;
mod machine;
mod middle;
mod motion;
mod near;
mod order;
mod path;
mod picture;
mod placing;
mod plot;
mod profile;
mod rings;
mod settings;
mod start;
mod stats;
mod stops;
mod svg;
mod tour;
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
