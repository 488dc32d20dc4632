//! What a camera says of its picture (EXIF 2.32): which way is up, and whether the colours are Adobe RGB's.

use std::io::Cursor;

use super::directory::{Directory, Tagged};

const ORIENTATION: u16 = 274;
const EXIF: u16 = 34_665;
const INTEROPERABILITY: u16 = 40_965;
const COLOUR_SPACE: u16 = 40_961;

/// What is used of EXIF data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Exif {
    /// 1 to 8; 1 is upright.
    pub(super) orientation: u8,
    /// Whether the samples are Adobe RGB's.
    pub(super) adobe_rgb: bool,
}

impl Default for Exif {
    fn default() -> Self {
        Self { orientation: 1, adobe_rgb: false }
    }
}

impl Exif {
    /// Reads EXIF data, with or without the six bytes that JPEG has in front of them. What is broken says nothing.
    pub(super) fn of(bytes: &[u8]) -> Self {
        let bytes = bytes.strip_prefix(b"Exif\0\0").unwrap_or(bytes);
        let Some((mut file, first)) = Tagged::open(Cursor::new(bytes)) else { return Self::default() };
        match file.directory(first) {
            Some(directory) => Self::of_directory(&mut file, &directory),
            None => Self::default(),
        }
    }

    /// What a file's directory and those under it say.
    pub(super) fn of_directory<R: std::io::Read + std::io::Seek>(file: &mut Tagged<R>, directory: &Directory) -> Self {
        let orientation = match file.number_of(directory, ORIENTATION) {
            Some(turn @ 1..=8) => turn as u8,
            _ => 1,
        };
        let below = |file: &mut Tagged<R>, directory: &Directory, tag| {
            let at = file.number_of(directory, tag)?;
            file.directory(at)
        };
        let adobe_rgb = below(file, directory, EXIF).is_some_and(|exif| {
            // 2 is Adobe RGB in cameras that do not keep to the standard; those that do say 0xFFFF (other than sRGB) and name it.
            match file.number_of(&exif, COLOUR_SPACE) {
                Some(2) => true,
                Some(0xFFFF) => below(file, &exif, INTEROPERABILITY)
                    .and_then(|directory| file.bytes(&directory, 1))
                    .is_some_and(|index| index.starts_with(b"R03")),
                _ => false,
            }
        });
        Self { orientation, adobe_rgb }
    }
}
