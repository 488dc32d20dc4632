//! tone
use crate::error::Result;
use crate::field::Field;

/// Samples of an image, row-major, channels interleaved.
#[derive(Debug, Clone, Copy)]
pub enum Samples<'a> {
    /// 0 to 255.
    U8(&'a [u8]),
    /// 0 to 65535.
    U16(&'a [u16]),
    /// 0 to 1.
    F32(&'a [f32]),
}

/// An image as its samples: 1 channel is grey, 2 grey and alpha, 3 sRGB, 4 sRGB and alpha (not premultiplied).
#[derive(Debug, Clone, Copy)]
pub struct Pixels<'a> {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// 1 to 4.
    pub channels: usize,
    /// `width * height * channels` samples.
    pub samples: Samples<'a>,
}

/// stub
pub fn luma(_pixels: &Pixels, _background: [u8; 3]) -> Result<Field> {
    unimplemented!()
}

/// stub
pub fn luma_to_u8(_luma: &Field) -> Vec<u8> {
    unimplemented!()
}

/// stub
pub fn adjust(_luma: &Field, _gamma: f64, _contrast: f64, _invert: bool) -> Field {
    unimplemented!()
}
