#![doc = include_str!("lib.md")]

// The folders stand in the order of the data: each imports from those above it alone.

mod base;

mod options;

mod photo;

mod decoding;

mod importance;

mod graph;

mod inks;

mod diffusion;

mod sites;

mod labels;

mod outlines;

mod drawing;

mod offset;

mod files;

mod pipeline;
mod plot;
mod rules;

pub mod stages;

pub use base::{Control, Error, Result};
pub use drawing::Drawing;
pub use files::{Export, Format, load};
pub use importance::Importance;
pub use options::{Options, Published, presets};
pub use photo::{Field, Photo};
pub use pipeline::{Outcome, Session, draw};
