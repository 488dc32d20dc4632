#![doc = include_str!("lib.md")]

mod budget;
pub mod components;
pub mod control;
pub mod decode;
pub mod diffusion;
pub mod drawing;
pub mod error;
pub mod field;
pub mod graph;
pub mod importance;
pub mod lattice;
pub mod outline;
pub mod params;
pub mod pipeline;
pub mod raster;
pub mod saliency;
pub mod svg;
pub mod tone;
pub mod triangulation;
pub mod voronoi;

pub use control::Control;
pub use drawing::Drawing;
pub use error::{Error, Result};
pub use field::Field;
pub use params::{Alpha, LatticeKind, Options};
pub use pipeline::{Outcome, draw};
