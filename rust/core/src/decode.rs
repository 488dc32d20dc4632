//! decode
use crate::error::Result;
use crate::field::Field;

/// stub
pub fn decode(_bytes: &[u8], _background: [u8; 3]) -> Result<Field> {
    unimplemented!()
}
