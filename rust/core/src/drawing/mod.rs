//! The drawing as data. In: curves and dots, with what lies beside them or without; out: a [`Drawing`] with regions, their order
//! and levels. Source: the paper (the layered order); shared curves are our own.

mod assembly;
mod data;
mod joined;
mod least_radius;
mod loose;
mod plates;
mod sides;
mod stats;
mod sweep;

pub use assembly::assemble;
pub(crate) use data::VERSION;
pub use data::{Drawing, Level, Mark, Provenance, Region, Ring, RingPart};
pub use least_radius::DotChanges;
pub(crate) use loose::{Loose, Shape, invalid};
#[cfg(test)]
pub(crate) use plates::samples;
pub(crate) use sides::put_together;
pub use stats::{Stats, Within};
