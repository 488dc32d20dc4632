//! Photos of samples that somebody else has read: in, rows of them and what their file said of the colours; out, the photo, by the
//! rules that hold for files.

use super::canvas::Canvas;
use super::colour::Colours;
use super::job::Reading;
use super::stored::{Depth, Model, Stored};
use crate::base::{Control, Error, Result};
use crate::photo::{Photo, Samples};

/// What a file said of its samples.
#[derive(Debug, Clone, Default)]
pub struct Tags {
    /// Whether the colours are inks, C, M, Y and K: 0 is none.
    pub inks: bool,
    /// An embedded profile (ICC).
    pub profile: Option<Vec<u8>>,
    /// As PNG's gAMA has it: the sample is the light to this power.
    pub gamma: Option<f64>,
    /// As PNG's cHRM has it: x, y of white, red, green and blue.
    pub chromaticities: Option<[[f64; 2]; 4]>,
    /// Whether EXIF data say that the colours are Adobe RGB's.
    pub adobe_rgb: bool,
}

/// Makes a photo of rows of samples, from the top down.
pub struct PhotoBuilder<'a> {
    canvas: Canvas<'a>,
    size: [usize; 2],
    channels: usize,
    row: usize,
}

impl<'a> PhotoBuilder<'a> {
    /// For an image of `width` x `height` pixels of 1 to 4 channels, the last of 2 and of 4 being opacity unless they are inks;
    /// `first` has some of its samples, which tell the depth of all.
    ///
    /// # Errors
    /// [`Error::Input`] if the image is empty or too large, or the channels are not 1 to 4, or not 4 for inks.
    pub fn new(
        [width, height, channels]: [usize; 3],
        first: Samples,
        tags: &Tags,
        reading: &Reading,
        control: &'a Control,
    ) -> Result<Self> {
        if !(1..=4).contains(&channels) || tags.inks && channels != 4 {
            return Err(Error::Input(format!("the image has {channels} channels, but it must have 1 to 4")));
        }
        let factor = reading.factor(width, height).map_err(|error| match error {
            Error::Decode(sentence) => Error::Input(sentence),
            other => other,
        })?;
        let model = match channels {
            1 | 2 => Model::Grey,
            _ if tags.inks => Model::Cmyk,
            _ => Model::Rgb,
        };
        let alpha = !tags.inks && channels.is_multiple_of(2);
        let depth = match first {
            Samples::U8(_) => Depth::U8,
            Samples::U16(_) => Depth::U16,
            Samples::F32(_) => Depth::F32,
        };
        let colours = match (&tags.profile, tags.gamma, tags.chromaticities) {
            (Some(profile), ..) => Colours::of_icc(profile),
            (_, Some(_), _) | (.., Some(_)) => Colours::of_gamma(tags.gamma, tags.chromaticities, model == Model::Grey),
            _ if tags.adobe_rgb && model == Model::Rgb => Colours::adobe_rgb(),
            _ => Colours::Srgb,
        };
        let stored = Stored { width, height, model, alpha, premultiplied: false, orientation: 1 };
        let canvas = Canvas::new(stored, factor, reading.wanted(), colours.conversion(model, depth), control)?;
        Ok(Self { canvas, size: [width, height], channels, row: 0 })
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// [`Error::Input`] if the samples are no whole rows, or more than the image has, or a float is outside [0, 1];
    /// [`Error::Cancelled`].
    pub fn take(&mut self, samples: Samples) -> Result<()> {
        let [width, height] = self.size;
        let rows = samples.len() / (width * self.channels);
        if samples.len() != rows * width * self.channels || rows > height - self.row {
            return Err(Error::Input(format!("{} samples are no rows of {width} x {height} pixels", samples.len())));
        }
        self.canvas.put(0, self.row, width, samples)?;
        self.row += rows;
        Ok(())
    }

    /// The photo.
    ///
    /// # Errors
    /// [`Error::Input`] if a row is missing.
    pub fn finish(self) -> Result<Photo> {
        let [_, height] = self.size;
        if self.row < height {
            return Err(Error::Input(format!("the image has {height} rows, but only {} came", self.row)));
        }
        self.canvas.finish()
    }
}
