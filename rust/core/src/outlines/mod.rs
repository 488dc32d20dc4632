//! From labels to shapes. In: the graph with its labels, tones, areas and components; out: smooth curves, each shared by the
//! components on its two sides, and dots, as [`Parts`]. Source: the paper; exact areas, fewer points and irregular dots are our
//! own.

mod contours;
mod dots;
mod fit;
mod irregular;
mod outline;
mod parts;
mod simplify;
mod sleeve;
mod spline;
mod wobble;

pub use outline::{Bands, Nodes, Outlines, Shaping, Tones, crossing, outline};
pub use parts::{Parts, Stipple};
