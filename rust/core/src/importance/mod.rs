//! Where detail is wanted. In: a source by name, or a map, and the tone; out: the importance on the canvas, a field. Source: the
//! paper (saliency), and our own (the photo's detail).

mod importance;
mod saliency;
mod source;

pub use importance::Importance;
pub use saliency::fine_grained;
pub use source::{KINDS, Kind, Source};
