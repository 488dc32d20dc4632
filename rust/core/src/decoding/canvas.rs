//! The canvas that decoders fill: rows of samples in, luma out. Profiles are applied here, premultiplied alpha is undone, transparent
//! parts are laid on the background, the picture is turned upright, and reduced where it has far more pixels than are used.

use rayon::prelude::*;

use super::colour::Conversion;
use super::kinds::out_of_memory;
use super::stored::{Model, Stored};
use crate::base::{Control, Result};
use crate::photo::{Field, Photo, Samples, check_values, weigh_into};

/// Pixels that one thread converts at once.
const AT_ONCE: usize = 16_384;

/// Rows that are placed at once: the luma of a whole picture that is reduced is never in memory.
const ROWS: usize = 512;

/// Luma that is being filled.
pub(super) struct Canvas<'a> {
    stored: Stored,
    background: [u8; 3],
    conversion: Option<Conversion>,
    control: &'a Control,
    factor: usize,
    /// Width and height of the luma.
    size: [usize; 2],
    values: Vec<f32>,
    /// Sums of the pixels of each box, where the picture is reduced.
    sums: Vec<f64>,
    /// What the column and the row of a stored pixel add to its place in the luma.
    columns: Vec<u32>,
    rows: Vec<u32>,
}

impl<'a> Canvas<'a> {
    /// A canvas for an image, reduced by a whole factor.
    ///
    /// # Errors
    /// [`Error::Decode`] if there is not enough memory.
    pub(super) fn new(
        stored: Stored,
        factor: usize,
        background: [u8; 3],
        conversion: Option<Conversion>,
        control: &'a Control,
    ) -> Result<Self> {
        let size = stored.upright().map(|side| (side / factor).max(1));
        let mut canvas = Self {
            stored,
            background,
            conversion,
            control,
            factor,
            size,
            values: Vec::new(),
            sums: Vec::new(),
            columns: Vec::new(),
            rows: Vec::new(),
        };
        let count = size[0] * size[1];
        if factor == 1 {
            canvas.values = zeros(count)?;
        } else {
            canvas.sums = zeros(count)?;
        }
        let [width, height] = [stored.width, stored.height];
        let turned = |at: usize, side: usize, back: bool| if back { side - 1 - at } else { at };
        let (flip_x, flip_y) = match stored.orientation {
            2 => (true, false),
            3 => (true, true),
            4 => (false, true),
            6 => (false, true),
            7 => (true, true),
            8 => (true, false),
            _ => (false, false),
        };
        let swapped = stored.orientation >= 5;
        let place = |at: usize, is_row: bool| {
            let in_box = (at / factor).min(size[usize::from(is_row)] - 1);
            (if is_row { in_box * size[0] } else { in_box }) as u32
        };
        canvas.columns = (0..width).map(|x| place(turned(x, width, flip_x), swapped)).collect();
        canvas.rows = (0..height).map(|y| place(turned(y, height, flip_y), !swapped)).collect();
        Ok(canvas)
    }

    /// Fills rows of `width` pixels, from the stored column and row on.
    ///
    /// # Errors
    /// [`Error::Input`] for a float sample outside [0, 1], [`Error::Cancelled`].
    pub(super) fn put(&mut self, column: usize, row: usize, width: usize, samples: Samples) -> Result<()> {
        self.control.check()?;
        let channels = self.stored.channels();
        if let Samples::F32(values) = samples {
            check_values(values, channels, width, [column, row])?;
        }
        let count = samples.len() / channels;
        let straight = self.factor == 1 && self.stored.orientation == 1 && width == self.stored.width;
        if straight {
            let mut values = std::mem::take(&mut self.values);
            self.weigh(samples, &mut values[row * width..row * width + count]);
            self.values = values;
            return Ok(());
        }
        let mut luma = vec![0.0; count.min(ROWS * width)];
        for from in (0..count).step_by(ROWS * width) {
            let luma = &mut luma[..(count - from).min(ROWS * width)];
            self.weigh(samples.part(from * channels, (from + luma.len()) * channels), luma);
            for (y, luma) in (row + from / width..).zip(luma.chunks_exact(width)) {
                self.place(column, y, luma.iter().copied());
            }
        }
        Ok(())
    }

    /// Leaves a part of the stored image as background.
    pub(super) fn leave(&mut self, column: usize, row: usize, width: usize, height: usize) {
        let grey = self.behind() as f32;
        for y in row..row + height {
            self.place(column, y, std::iter::repeat_n(grey, width));
        }
    }

    /// The photo.
    ///
    /// # Errors
    /// As [`Photo::of_reduced`], which do not happen.
    pub(super) fn finish(self) -> Result<Photo> {
        let size = self.stored.upright();
        let [width, height] = self.size;
        let mut values = self.values;
        if self.factor > 1 {
            let side = |at: usize, reduced: usize, full: usize| {
                if at + 1 < reduced { self.factor } else { full - self.factor * (reduced - 1) }
            };
            values = self
                .sums
                .into_par_iter()
                .enumerate()
                .map(|(at, sum)| {
                    let pixels = side(at % width, width, size[0]) * side(at / width, height, size[1]);
                    ((sum / pixels as f64) as f32).clamp(0.0, 1.0)
                })
                .collect();
        }
        Photo::of_reduced(Field::of_valid(width, height, values), size[0], size[1], self.factor)
    }

    /// The luma of the background.
    fn behind(&self) -> f64 {
        let [red, green, blue] = self.background.map(f64::from);
        (299.0 * red + 587.0 * green + 114.0 * blue) / 255_000.0
    }

    fn place(&mut self, column: usize, row: usize, luma: impl Iterator<Item = f32>) {
        let base = self.rows[row] as usize;
        let places = self.columns[column..].iter().map(|at| base + *at as usize);
        if self.factor == 1 {
            places.zip(luma).for_each(|(at, value)| self.values[at] = value);
        } else {
            places.zip(luma).for_each(|(at, value)| self.sums[at] += f64::from(value));
        }
    }

    /// The luma of pixels.
    fn weigh(&self, samples: Samples, target: &mut [f32]) {
        let channels = self.stored.channels();
        target.par_chunks_mut(AT_ONCE).enumerate().for_each(|(chunk, target)| {
            let from = chunk * AT_ONCE * channels;
            let samples = samples.part(from, from + target.len() * channels);
            let plain = self.conversion.is_none() && self.stored.model != Model::Cmyk && !self.stored.premultiplied;
            if plain {
                weigh_into(samples, channels, self.background, target);
            } else {
                self.weigh_converted(samples, target);
            }
        });
    }

    /// As [`Canvas::weigh`], by way of sRGB.
    fn weigh_converted(&self, samples: Samples, target: &mut [f32]) {
        let Stored { model, alpha, premultiplied, .. } = self.stored;
        let channels = self.stored.channels();
        let opacity: Vec<f32> = if alpha { samples.channel(channels - 1, channels) } else { Vec::new() };
        let mut colours = samples.without_last(channels, alpha);
        if premultiplied && alpha {
            colours = colours.divided(&opacity, channels - 1);
        }
        let converted = match &self.conversion {
            Some(conversion) => conversion.convert(&colours),
            None => colours,
        };
        match (model, &self.conversion) {
            (Model::Grey, _) => weigh_into(converted.as_samples(), 1, self.background, target),
            (Model::Cmyk, None) => {
                for (target, ink) in target.iter_mut().zip(converted.into_floats().chunks_exact(4)) {
                    let light = |i: usize| f64::from(1.0 - ink[i]) * f64::from(1.0 - ink[3]);
                    *target = (0.299 * light(0) + 0.587 * light(1) + 0.114 * light(2)) as f32;
                }
            }
            _ => weigh_into(converted.as_samples(), 3, self.background, target),
        }
        if alpha {
            let behind = self.behind();
            for (value, opacity) in target.iter_mut().zip(opacity) {
                let opacity = f64::from(opacity);
                *value = ((f64::from(*value) * opacity + behind * (1.0 - opacity)) as f32).clamp(0.0, 1.0);
            }
        }
    }
}

/// Zeros, as many as the memory has room for.
pub(super) fn zeros<T: Copy + Default>(count: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| out_of_memory(count.saturating_mul(size_of::<T>())))?;
    values.resize(count, T::default());
    Ok(values)
}
