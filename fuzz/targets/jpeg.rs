//! JPEG files: what begins as one.
#![no_main]

use fuzz::{Counting, examine, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    let mut file = data.to_vec();
    file.resize(file.len().max(2), 0);
    file[..2].copy_from_slice(b"\xFF\xD8");
    examine(&file, None);
});
