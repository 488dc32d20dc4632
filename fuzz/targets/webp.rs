//! WebP files: what begins as one, with the length that it has.
#![no_main]

use fuzz::{Counting, examine, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    let mut file = data.to_vec();
    file.resize(file.len().max(12), 0);
    let length = (file.len() - 8) as u32;
    file[..4].copy_from_slice(b"RIFF");
    file[4..8].copy_from_slice(&length.to_le_bytes());
    file[8..12].copy_from_slice(b"WEBP");
    examine(&file, None);
});
