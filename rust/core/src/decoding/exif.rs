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

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of little-endian EXIF data: tag, type, count and value of each entry.
    fn directory(entries: &[(u16, u16, u32, [u8; 4])]) -> Vec<u8> {
        let entry = |(tag, kind, count, value): &(u16, u16, u32, [u8; 4])| {
            [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), value].concat()
        };
        let entries_of = entries.iter().flat_map(entry);
        (entries.len() as u16).to_le_bytes().into_iter().chain(entries_of).chain([0; 4]).collect()
    }

    /// What a camera says that calls its colours others than sRGB's, and names them.
    fn uncalibrated(name: &[u8; 4]) -> Exif {
        let at = |offset: u32| offset.to_le_bytes();
        let of_exif = [(COLOUR_SPACE, 3, 1, at(0xFFFF)), (INTEROPERABILITY, 4, 1, at(56))];
        let parts = [directory(&[(EXIF, 4, 1, at(26))]), directory(&of_exif), directory(&[(1, 2, 4, *name)])];
        Exif::of(&[&b"II*\0\x08\0\0\0"[..], &parts.concat()].concat())
    }

    #[test]
    fn only_the_name_of_adobe_rgb_stands_for_it() {
        assert!(uncalibrated(b"R03\0").adobe_rgb);
        assert!(!uncalibrated(b"R98\0").adobe_rgb && !uncalibrated(b"THM\0").adobe_rgb);
    }
}
