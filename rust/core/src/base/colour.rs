//! Colours by name.

use crate::base::error::{Error, Result};

/// Reads the `background` option: `white`, `black`, `#rrggbb` or `#rgb`.
///
/// # Errors
/// [`Error::Option`] for anything else.
pub fn parse_color(text: &str) -> Result<[u8; 3]> {
    let hexadecimal = |digits: &str| {
        // Digit by digit: from_str_radix would allow a sign.
        let nibbles: Option<Vec<u8>> = digits.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
        match nibbles?.as_slice() {
            [r, g, b] => Some([r * 17, g * 17, b * 17]),
            [r, rr, g, gg, b, bb] => Some([r * 16 + rr, g * 16 + gg, b * 16 + bb]),
            _ => None,
        }
    };
    let color = match text {
        "white" => Some([255; 3]),
        "black" => Some([0; 3]),
        _ => text.strip_prefix('#').and_then(hexadecimal),
    };
    color.ok_or_else(|| Error::option("background", text, "white, black, #rrggbb or #rgb"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_name() {
        assert_eq!(parse_color("white").unwrap(), [255; 3]);
        assert_eq!(parse_color("black").unwrap(), [0; 3]);
        assert_eq!(parse_color("#1aF").unwrap(), [0x11, 0xaa, 0xff]);
        assert_eq!(parse_color("#0180fe").unwrap(), [1, 128, 254]);
        for bad in ["", "#", "red", "White", "#12", "#12345", "#+12", "#ggg", "#äöü", "123456"] {
            assert!(parse_color(bad).is_err(), "{bad}");
        }
        assert_eq!(
            parse_color("grey").unwrap_err().to_string(),
            "background is grey, but it must be white, black, #rrggbb or #rgb"
        );
    }
}
