//! raster
use crate::drawing::Drawing;
use crate::error::Result;

/// A grey raster: 0 black, 255 white, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width * height` values.
    pub values: Vec<u8>,
}

/// stub
pub fn rasterize(_drawing: &Drawing, _width: Option<usize>) -> Result<Raster> {
    unimplemented!()
}
/// stub
pub fn encode_png(_raster: &Raster) -> Result<Vec<u8>> {
    unimplemented!()
}
