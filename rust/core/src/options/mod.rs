//! The options, with defaults, ranges and checks, and the presets. In: what a user asks for; out: [`Options`], from which every
//! stage takes its parameters. Source: parameters of the paper, and our own.

mod params;
pub mod presets;

pub use params::{Alpha, Budget, Carry, Crossings, DEFAULT_MAX_NODES, DEFAULT_NODES_PER_PIXEL, LatticeKind, Options, Order};
pub use presets::{Inks, Preset};
