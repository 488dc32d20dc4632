//! svg
use crate::drawing::Drawing;

/// stub
pub fn to_svg(_drawing: &Drawing) -> String {
    unimplemented!()
}
