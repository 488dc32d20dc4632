//! From the bytes of an image file to its photo. In: a file or bytes in memory, what to do about transparency, damage and size;
//! out: a [`crate::photo::Photo`]. Source: the specifications of the formats, which each file names.
//!
//! What is read is told from the content, never from a name. What a file says of its pixels is obeyed, or the file is refused in one
//! sentence: [`crate::Error::Unsupported`] for what other programs may read, [`crate::Error::Decode`] for the rest. The bytes
//! are unpacked by libraries; markers and tags are read here where a library would hide what is needed.

mod canvas;
mod caught;
mod colour;
mod coverage;
mod directory;
mod exif;
mod frame;
mod job;
mod jpeg;
mod kinds;
mod pixels;
mod png;
mod reading;
mod samples;
mod stored;
mod tags;
mod tiff;
mod unpack;
mod webp;

pub use job::{MAX_FILE_BYTES, MAX_PIXELS, Reading, Source};
pub use reading::{Decoded, decode};
pub use samples::{PhotoBuilder, Tags};
