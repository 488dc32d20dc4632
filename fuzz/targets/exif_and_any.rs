//! Any bytes as they are, and the same as the EXIF data of a small JPEG.
#![no_main]

use fuzz::{Counting, examine, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

/// A grey JPEG of 8 x 8 pixels, behind its first marker.
const PICTURE: &[u8] = &[
    0xFF, 0xDB, 0, 67, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, // All steps are 1.
    0xFF, 0xC0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0, // The frame.
    0xFF, 0xC4, 0, 20, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // A code for no difference,
    0xFF, 0xC4, 0, 20, 0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // and one for the end of a block.
    0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0, 0x3F, 0xFF, 0xD9,
];

fuzz_target!(|data: &[u8]| {
    prepare();
    examine(data, None);
    let content = &data[..data.len().min(65_000)];
    let mut file = vec![0xFF, 0xD8, 0xFF, 0xE1];
    file.extend((content.len() as u16 + 8).to_be_bytes());
    file.extend(b"Exif\0\0");
    file.extend(content);
    file.extend(PICTURE);
    examine(&file, Some([8, 8]));
});
