//! saliency
use crate::field::Field;

/// stub
pub fn fine_grained(_luma: &[u8], _width: usize, _height: usize) -> Field {
    unimplemented!()
}
