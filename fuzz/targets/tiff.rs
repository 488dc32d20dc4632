//! TIFF files: what begins as one of the four kinds.
#![no_main]

use fuzz::{Counting, examine, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    let marks = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
    let mut file = data.to_vec();
    file.resize(file.len().max(4), 0);
    if !marks.iter().any(|mark| file.starts_with(&mark[..])) {
        let chosen = marks[usize::from(file[0]) % marks.len()];
        file[..4].copy_from_slice(chosen);
    }
    examine(&file, None);
});
