//! Colours by name.

use std::fmt;
use std::str::FromStr;

use crate::base::error::{Error, Result};

/// A colour, with the name that it was given by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Color {
    name: String,
    rgb: [u8; 3],
}

impl Color {
    /// What is read as one, for messages.
    pub(crate) const ALLOWED: &str = "white, black, #rrggbb or #rgb";

    /// The paper's.
    pub fn white() -> Self {
        Self { name: "white".to_owned(), rgb: [255; 3] }
    }

    /// Red, green and blue in 8 bits, sRGB.
    pub fn rgb(&self) -> [u8; 3] {
        self.rgb
    }
}

impl fmt::Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl FromStr for Color {
    type Err = Error;

    /// Reads `white`, `black`, `#rrggbb` or `#rgb`.
    ///
    /// # Errors
    /// [`Error::Option`] for anything else.
    fn from_str(text: &str) -> Result<Self> {
        let hexadecimal = |digits: &str| {
            // Digit by digit: from_str_radix would allow a sign.
            let nibbles: Option<Vec<u8>> = digits.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
            match nibbles?.as_slice() {
                [r, g, b] => Some([r * 17, g * 17, b * 17]),
                [r, rr, g, gg, b, bb] => Some([r * 16 + rr, g * 16 + gg, b * 16 + bb]),
                _ => None,
            }
        };
        let rgb = match text {
            "white" => Some([255; 3]),
            "black" => Some([0; 3]),
            _ => text.strip_prefix('#').and_then(hexadecimal),
        };
        let rgb = rgb.ok_or_else(|| Error::option("colour", text, Self::ALLOWED))?;
        Ok(Self { name: text.to_owned(), rgb })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_name() {
        let rgb = |text: &str| text.parse::<Color>().map(|color| color.rgb());
        assert_eq!(rgb("white").unwrap(), Color::white().rgb());
        assert_eq!(rgb("black").unwrap(), [0; 3]);
        assert_eq!(rgb("#1aF").unwrap(), [0x11, 0xaa, 0xff]);
        assert_eq!(rgb("#0180fe").unwrap(), [1, 128, 254]);
        assert_eq!("#1aF".parse::<Color>().unwrap().to_string(), "#1aF");
        for bad in ["", "#", "red", "White", "#12", "#12345", "#+12", "#ggg", "#äöü", "123456"] {
            assert!(rgb(bad).is_err(), "{bad}");
        }
        assert_eq!(rgb("grey").unwrap_err().to_string(), "colour is grey, but it must be white, black, #rrggbb or #rgb");
    }
}
