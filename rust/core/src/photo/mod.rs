//! From a photo to the tone that is drawn. In: luma, or samples; out: a [`Photo`] with its luma, its subject, tone and
//! emphasized tone, each a [`Field`], and its colour where that is wanted. Source: our own (the paper takes grey levels as given).

mod backdrop;
mod colour;
mod emphasis;
mod field;
mod photo;
mod subject;
mod tone;

pub(crate) use backdrop::{attended, backed};
pub use colour::Colour;
pub use emphasis::emphasize;
pub(crate) use emphasis::{FINE, emphasize_and_off, off_blurred};
pub use field::{Field, MAX_SIDE};
pub(crate) use field::{check_size, check_values};
pub use photo::Photo;
pub use tone::{Pixels, Samples, adjust, luma, luma_to_u8};
pub(crate) use tone::{adjusted, adjusted_channel, colours_into, weigh_into};
