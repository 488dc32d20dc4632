//! What must hold of every input, shared by the targets. In: bytes; out: nothing, or an abort.
//!
//! A decoder's panic is caught by the core and told as a damaged file, which is right; a panic of the core's own code is a defect even
//! where it is caught. [`prepare`] tells the two apart by where they are. [`Counting`] counts memory, since an input of a few bytes
//! must not take more than its pixels need.

mod areas;
mod drawings;
mod memory;
mod panics;

pub use areas::examine_areas;
pub use drawings::examine_drawing;
pub use memory::Counting;
pub use panics::prepare;

use std::io::Cursor;

use graphstipple_core::stages::{Reading, decode};
use graphstipple_core::{Control, Error};

/// The most pixels of a photo here: large enough for several bands and tiles, small enough for many runs a second.
const MAX_PIXELS: u64 = 1_000_000;

/// The most bytes that reading a photo of [`MAX_PIXELS`] may take at once: windows of LZMA and Zstandard and profiles are most of it.
const MAX_BYTES: usize = 512 << 20;

/// Reads bytes as a photo, strictly and as far as it goes, and checks what comes of it. `size` is what the file says it has, where
/// that is known.
pub fn examine(bytes: &[u8], size: Option<[usize; 2]>) {
    let read = |allow_damaged| {
        let reading = Reading { max_pixels: MAX_PIXELS, allow_damaged, background: [255, 128, 0], ..Reading::default() };
        let before = memory::restart();
        let result = decode(&mut Cursor::new(bytes), &reading, &Control::new());
        let taken = memory::peak() - before;
        assert!(taken <= MAX_BYTES, "reading {} bytes took {} MB", bytes.len(), taken >> 20);
        result
    };
    let (strict, lenient) = (read(false), read(true));
    for decoded in [&strict, &lenient].into_iter().flatten() {
        let (photo, luma) = (&decoded.photo, decoded.photo.luma());
        assert!(photo.width() * photo.height() <= MAX_PIXELS as usize);
        assert_eq!([luma.width(), luma.height()], [photo.width(), photo.height()]);
        assert_eq!(luma.values().len(), luma.width() * luma.height());
        if let Some([width, height]) = size {
            let read = [photo.width(), photo.height()];
            assert!(read == [width, height] || read == [height, width], "{read:?} pixels, not {width} x {height}");
        }
        if let Some(at) = luma.values().iter().position(|v| !(0.0..=1.0).contains(v)) {
            panic!("the luma is {} at {at}", luma.values()[at]);
        }
        decoded.warning.as_deref().into_iter().for_each(check_sentence);
    }
    match (&strict, &lenient) {
        (Ok(strict), Ok(lenient)) => assert!(strict.photo == lenient.photo, "a sound file is read differently with allow_damaged"),
        (Ok(_), Err(error)) => panic!("a sound file is refused with allow_damaged: {error}"),
        (Err(_), Ok(lenient)) => assert!(lenient.warning.is_some(), "a damaged file is drawn without a warning"),
        (Err(_), Err(_)) => {}
    }
    for error in [strict.err(), lenient.err()].iter().flatten() {
        check_error(error);
        check_sentence(&error.to_string());
    }
}

/// Checks that an error is for the user, in one line, and no defect of the core. It may quote what the user gave.
pub fn check_error(error: &Error) {
    assert!(!matches!(error, Error::Internal(_) | Error::Cancelled), "{error}");
    let sentence = error.to_string();
    assert!(!sentence.is_empty() && !sentence.contains(char::is_control), "no single line: {sentence:?}");
}

/// Checks that a sentence about a file is in words, with nothing of what `{:?}` makes.
fn check_sentence(sentence: &str) {
    assert!(!sentence.is_empty() && !sentence.contains(['\n', '\r']), "no single line: {sentence:?}");
    let of_debug = ["::", "Some(", "Ok(", "Err(", "Error(", "{ ", " }", "\\u", "panicked"];
    assert!(!of_debug.iter().any(|mark| sentence.contains(mark)), "a debug print: {sentence}");
}
