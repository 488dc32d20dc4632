//! A file that is being read: the limits that hold for every format, what is done about damage, and how decoders are run.

use std::io::{BufRead, Seek};

use super::canvas::{Canvas, Wanted};
use super::caught::caught;
use super::colour::Colours;
use super::kinds::{Container, out_of_memory};
use super::stored::{Depth, Stored};
use crate::base::{Checked, Control, Error, Result};
use crate::options::Options;
use crate::photo::MAX_SIDE;

/// The most pixels that a photo may have. Cameras and phones make up to 200 million; more is a scanner's or a decompression
/// bomb's, a few kilobytes that unpack to a memory full of pixels.
pub const MAX_PIXELS: u64 = 250_000_000;

/// The most bytes of a file that has to be in memory whole: JPEG, WebP, and what comes from a pipe.
pub const MAX_FILE_BYTES: u64 = 2 << 30;

/// Bytes of an image file that can be looked into: a file, or bytes in memory.
pub trait Source: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> Source for T {}

/// How a photo is read.
#[derive(Debug, Clone)]
pub struct Reading {
    /// What transparent parts show, 8-bit sRGB.
    pub background: [u8; 3],
    /// The most pixels that are read, at most [`MAX_PIXELS`].
    pub max_pixels: u64,
    /// Whether a file that is cut short or damaged is read as far as it goes; what is missing is background then.
    pub allow_damaged: bool,
    /// What the photo will be drawn with: one with far more pixels than those nodes can use is reduced as
    /// [`Options::reduction`] says. `None`: every pixel is kept.
    pub options: Option<Checked<Options>>,
    /// Whether the photo keeps its colour, which takes up to 12 bytes a pixel more. The luma is the same.
    pub colour: bool,
}

impl Default for Reading {
    fn default() -> Self {
        Self { background: [255; 3], max_pixels: MAX_PIXELS, allow_damaged: false, options: None, colour: false }
    }
}

impl Reading {
    /// Checks the size of a photo and returns by which whole factor it is reduced.
    ///
    /// # Errors
    /// [`Error::Decode`] if it has no pixels, or too many.
    pub fn factor(&self, width: usize, height: usize) -> Result<usize> {
        if width == 0 || height == 0 {
            return Err(Error::Decode(format!("the image is {width} x {height} pixels, so there is nothing to draw")));
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(Error::Decode(format!(
                "the image is too large: {width} x {height} pixels, but a side may have at most {MAX_SIDE}"
            )));
        }
        let most = self.max_pixels.min(MAX_PIXELS);
        if width as u64 * height as u64 > most {
            return Err(Error::Decode(format!(
                "the image is too large: {width} x {height} pixels, but at most {most} pixels are read"
            )));
        }
        Ok(self.options.as_ref().map_or(1, |options| options.reduction(width, height)))
    }
}

impl Reading {
    /// What the canvas shows.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted { background: self.background, colour: self.colour, may_lack: self.allow_damaged }
    }
}

/// What a header says.
pub(super) struct Opened {
    pub(super) stored: Stored,
    pub(super) colours: Colours,
    pub(super) depth: Depth,
}

/// A file that is being read.
pub(super) struct Job<'a> {
    pub(super) reading: &'a Reading,
    pub(super) control: &'a Control,
    pub(super) canvas: Option<Canvas<'a>>,
    pub(super) warnings: Vec<String>,
}

impl<'a> Job<'a> {
    /// Makes the canvas for what a header says.
    ///
    /// # Errors
    /// [`Error::Decode`] if it is empty, too large, or there is no memory for it.
    pub(super) fn begin(&mut self, opened: &Opened) -> Result<()> {
        let [width, height] = opened.stored.upright();
        let factor = self.reading.factor(width, height)?;
        // What was multiplied is divided in floats.
        let depth = if opened.stored.premultiplied && opened.stored.alpha { Depth::F32 } else { opened.depth };
        let conversion = opened.colours.conversion(opened.stored.model, depth);
        self.canvas = Some(Canvas::new(opened.stored, factor, self.reading.wanted(), conversion, self.control)?);
        Ok(())
    }

    /// Whether a picture of this size is read at all.
    ///
    /// # Errors
    /// As [`Reading::factor`].
    pub(super) fn check_size(&self, [width, height]: [usize; 2]) -> Result<()> {
        self.reading.factor(width, height).map(drop)
    }

    pub(super) fn canvas(&mut self) -> Result<&mut Canvas<'a>> {
        self.canvas.as_mut().ok_or_else(|| Error::Internal("the picture has no canvas".into()))
    }

    pub(super) fn background(&self) -> [u8; 3] {
        self.reading.background
    }

    /// Says something to the user, once.
    pub(super) fn warn(&mut self, sentence: &str) {
        if !self.warnings.iter().any(|said| said == sentence) {
            self.warnings.push(sentence.to_owned());
        }
    }

    /// What is done about a picture of which only a part is there, of a size that is 0 if that is nothing to look at.
    ///
    /// # Errors
    /// The error, unless what is there is wanted.
    pub(super) fn incomplete(&mut self, error: Error, part: usize) -> Result<()> {
        match error {
            Error::Decode(sentence) if self.reading.allow_damaged && part > 0 => {
                self.warn(&format!("{sentence}; the rest is background"));
                Ok(())
            }
            Error::Decode(sentence) if part > 0 => Err(Error::Decode(format!("{sentence} (allow_damaged draws what is there)"))),
            error => Err(error),
        }
    }
}

/// All bytes of a file.
pub(super) fn all_bytes(source: &mut dyn Source) -> Result<Vec<u8>> {
    let failed = |error: std::io::Error| Error::Decode(format!("the file cannot be read: {error}"));
    let length = source.seek(std::io::SeekFrom::End(0)).map_err(failed)?;
    source.rewind().map_err(failed)?;
    if length > MAX_FILE_BYTES {
        return Err(Error::Decode(format!("the file is too large: {length} bytes, but at most {MAX_FILE_BYTES} are read")));
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(length).map_err(|_| out_of_memory(length))?;
    source.read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Whether there is room for what a decoder will take, which asks for it without asking whether it is there.
pub(super) fn needs_memory(bytes: usize) -> Result<()> {
    let mut room: Vec<u8> = Vec::new();
    room.try_reserve_exact(bytes).map_err(|_| out_of_memory(bytes))
}

/// Runs a decoder, on this thread alone; a panic of it becomes the error of a file that cannot be decoded.
pub(super) fn decoded<T>(container: Container, run: impl FnOnce() -> Result<T>) -> Result<T> {
    caught(run).unwrap_or_else(|| Err(container.damaged("it cannot be decoded")))
}
