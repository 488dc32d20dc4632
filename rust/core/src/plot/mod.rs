//! Paths for pens. In: a [`Drawing`](crate::Drawing), a pen and how it fills; out: a [`Plot`] of paths in the order in which they are
//! drawn, the time that a machine takes for them, and files for machines.

mod commands;
mod digits;
mod gcode;
mod hpgl;
mod machine;
mod motion;
mod path;
mod placing;
mod plot;
mod profile;
mod svg;

pub use machine::{Corner, Cornering, Limit, Machine, MachineFormat, Upward};
pub use motion::Timing;
pub use path::{Path, PlotLayer};
pub use plot::Plot;
pub use profile::{PROFILE_KEYS, ProfileKey, ShippedProfile};
