//! Drawings as SVG.
#![no_main]

use fuzz::{Counting, examine_drawing, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    examine_drawing(data, "svg");
});
