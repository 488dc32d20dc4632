//! What a file is written with, whatever its format.

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};
use crate::files::layers::Style;
use crate::files::layout::Layout;
use crate::options::Inks;

/// How a drawing is written. What a format has no use for is left alone.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Export {
    /// How vector formats express the picture.
    pub style: Style,
    /// What a flat drawing is written with.
    pub inks: Inks,
    /// The size on paper, and the resolution of pixels.
    pub layout: Layout,
    /// Whether a PNG holds black and white alone, one bit a pixel, instead of antialiased grey.
    pub one_bit: bool,
}

impl Export {
    /// Checks every field, and that they go together.
    ///
    /// # Errors
    /// [`Error::Option`] for the first that does not.
    pub fn validate(&self) -> Result<()> {
        if self.style == Style::Layered && self.inks == Inks::White {
            return Err(Error::Option {
                option: "inks",
                value: "white".into(),
                allowed: "left out when style is layered: a layered drawing has both inks",
            });
        }
        self.layout.validate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_flat_and_black_and_survive_json() {
        let export = Export::default();
        assert_eq!((export.style, export.inks, export.one_bit), (Style::Flat, Inks::Black, false));
        let given: Export =
            serde_json::from_str("{\"style\":\"layered\",\"inks\":\"both\",\"layout\":{\"width\":\"1in\"},\"one_bit\":true}")
                .unwrap();
        given.validate().unwrap();
        assert_eq!(serde_json::from_str::<Export>(&serde_json::to_string(&given).unwrap()).unwrap(), given);
        assert!(serde_json::from_str::<Export>("{\"stlye\":\"flat\"}").is_err());
    }

    #[test]
    fn white_ink_alone_is_flat() {
        let export = Export { style: Style::Layered, inks: Inks::White, ..Export::default() };
        assert_eq!(
            export.validate().unwrap_err().to_string(),
            "inks is white, but it must be left out when style is layered: a layered drawing has both inks"
        );
    }
}
