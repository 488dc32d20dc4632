//! The canvas that decoders fill: rows of samples in, luma out, and the colour where it is wanted. Profiles are applied here, premultiplied alpha is undone, transparent
//! parts are laid on the background, the picture is turned upright, and reduced where it has far more pixels than are used.

use rayon::prelude::*;

use super::colour::Conversion;
use super::kinds::out_of_memory;
use super::stored::{Model, Stored};
use crate::base::{Control, Error, Result};
use crate::photo::{Colour, Field, Photo, Samples, check_values, colours_into, weigh_into};

/// Pixels that one thread converts at once.
const AT_ONCE: usize = 16_384;

/// Rows that are placed at once: the planes of a whole picture that is reduced is never in memory.
const ROWS: usize = 512;

/// What a canvas is wanted to show.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// 8-bit sRGB.
    pub(super) background: [u8; 3],
    pub(super) colour: bool,
    /// Whether parts may be left as background.
    pub(super) may_lack: bool,
}

/// Planes that are being filled: the luma, and red, green and blue behind it where it does not say them.
pub(super) struct Canvas<'a> {
    stored: Stored,
    background: [u8; 3],
    /// Whether the photo gets its colour.
    colour: bool,
    conversion: Option<Conversion>,
    control: &'a Control,
    factor: usize,
    /// Width and height of a plane.
    size: [usize; 2],
    planes: Vec<Vec<f32>>,
    /// Sums of the pixels of each box, where the picture is reduced.
    sums: Vec<Vec<f64>>,
    /// What the column and the row of a stored pixel add to its place in a plane.
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
        wanted: Wanted,
        conversion: Option<Conversion>,
        control: &'a Control,
    ) -> Result<Self> {
        let size = stored.upright().map(|side| (side / factor).max(1));
        let mut canvas = Self {
            stored,
            background: wanted.background,
            colour: wanted.colour,
            conversion,
            control,
            factor,
            size,
            planes: Vec::new(),
            sums: Vec::new(),
            columns: Vec::new(),
            rows: Vec::new(),
        };
        let count = size[0] * size[1];
        for _ in 0..planes_of(&stored, wanted) {
            if factor == 1 {
                canvas.planes.push(zeros(count)?);
            } else {
                canvas.sums.push(zeros(count)?);
            }
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
            let mut planes = std::mem::take(&mut self.planes);
            self.weigh(samples, planes.iter_mut().map(|plane| &mut plane[row * width..row * width + count]).collect());
            self.planes = planes;
            return Ok(());
        }
        let mut planes = vec![vec![0.0; count.min(ROWS * width)]; self.planes.len().max(self.sums.len())];
        for from in (0..count).step_by(ROWS * width) {
            let part = (count - from).min(ROWS * width);
            let samples = samples.part(from * channels, (from + part) * channels);
            self.weigh(samples, planes.iter_mut().map(|plane| &mut plane[..part]).collect());
            for (plane, values) in planes.iter().enumerate() {
                for (y, values) in (row + from / width..).zip(values[..part].chunks_exact(width)) {
                    self.place(plane, column, y, values.iter().copied());
                }
            }
        }
        Ok(())
    }

    /// Leaves a part of the stored image as background.
    pub(super) fn leave(&mut self, column: usize, row: usize, width: usize, height: usize) {
        let behind = self.behind();
        for (plane, behind) in behind.into_iter().enumerate().take(self.planes.len().max(self.sums.len())) {
            for y in row..row + height {
                self.place(plane, column, y, std::iter::repeat_n(behind as f32, width));
            }
        }
    }

    /// The photo.
    ///
    /// # Errors
    /// As [`Photo::of_reduced`], which do not happen.
    pub(super) fn finish(self) -> Result<Photo> {
        let size = self.stored.upright();
        let [width, height] = self.size;
        let mean = |(at, sum): (usize, f64)| {
            let side = |at: usize, reduced: usize, full: usize| {
                if at + 1 < reduced { self.factor } else { full - self.factor * (reduced - 1) }
            };
            let pixels = side(at % width, width, size[0]) * side(at / width, height, size[1]);
            ((sum / pixels as f64) as f32).clamp(0.0, 1.0)
        };
        let means = self.sums.into_iter().map(|sums| sums.into_par_iter().enumerate().map(mean).collect());
        let mut planes = self.planes.into_iter().chain(means).map(|values| Field::of_valid(width, height, values));
        let Some(luma) = planes.next() else { return Err(Error::Internal("the canvas has no plane".into())) };
        let photo = Photo::of_reduced(luma, size[0], size[1], self.factor)?;
        match (planes.next(), planes.next(), planes.next()) {
            (Some(red), Some(green), Some(blue)) => photo.with_colour(Colour::new(red, green, blue)?),
            _ if self.colour => Ok(photo.with_grey()),
            _ => Ok(photo),
        }
    }

    /// Luma, red, green and blue of the background.
    fn behind(&self) -> [f64; 4] {
        let [red, green, blue] = self.background.map(f64::from);
        [(299.0 * red + 587.0 * green + 114.0 * blue) / 255_000.0, red / 255.0, green / 255.0, blue / 255.0]
    }

    fn place(&mut self, plane: usize, column: usize, row: usize, values: impl Iterator<Item = f32>) {
        let base = self.rows[row] as usize;
        let places = self.columns[column..].iter().map(|at| base + *at as usize);
        if self.factor == 1 {
            let plane = &mut self.planes[plane];
            places.zip(values).for_each(|(at, value)| plane[at] = value);
        } else {
            let sums = &mut self.sums[plane];
            places.zip(values).for_each(|(at, value)| sums[at] += f64::from(value));
        }
    }

    /// The planes of pixels.
    fn weigh(&self, samples: Samples, planes: Vec<&mut [f32]>) {
        let channels = self.stored.channels();
        let mut chunks: Vec<_> = planes.into_iter().map(|plane| plane.chunks_mut(AT_ONCE)).collect();
        let chunks = std::iter::from_fn(|| chunks.iter_mut().map(Iterator::next).collect::<Option<Vec<&mut [f32]>>>());
        chunks.collect::<Vec<_>>().into_par_iter().enumerate().for_each(|(chunk, mut target)| {
            let from = chunk * AT_ONCE * channels;
            let samples = samples.part(from, from + target[0].len() * channels);
            let plain = self.conversion.is_none() && self.stored.model != Model::Cmyk && !self.stored.premultiplied;
            if plain {
                self.weigh_plain(samples, channels, &mut target);
            } else {
                self.weigh_converted(samples, &mut target);
            }
        });
    }

    /// The planes of pixels in sRGB.
    fn weigh_plain(&self, samples: Samples, channels: usize, target: &mut [&mut [f32]]) {
        weigh_into(samples, channels, self.background, target[0]);
        if let [_, red, green, blue] = target {
            colours_into(samples, channels, self.background, [red, green, blue]);
        }
    }

    /// As [`Canvas::weigh`], by way of sRGB.
    fn weigh_converted(&self, samples: Samples, target: &mut [&mut [f32]]) {
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
            (Model::Grey, _) => self.weigh_plain(converted.as_samples(), 1, target),
            (Model::Cmyk, None) => {
                for (at, ink) in converted.into_floats().chunks_exact(4).enumerate() {
                    let [red, green, blue] = [0, 1, 2].map(|i| f64::from(1.0 - ink[i]) * f64::from(1.0 - ink[3]));
                    let luma = 0.299 * red + 0.587 * green + 0.114 * blue;
                    for (plane, value) in target.iter_mut().zip([luma, red, green, blue]) {
                        plane[at] = value as f32;
                    }
                }
            }
            _ => self.weigh_plain(converted.as_samples(), 3, target),
        }
        if alpha {
            for (plane, behind) in target.iter_mut().zip(self.behind()) {
                for (value, opacity) in plane.iter_mut().zip(&opacity) {
                    let opacity = f64::from(*opacity);
                    *value = ((f64::from(*value) * opacity + behind * (1.0 - opacity)) as f32).clamp(0.0, 1.0);
                }
            }
        }
    }
}

/// How many planes there are: the luma says the colour where nothing but grey is drawn.
fn planes_of(stored: &Stored, wanted: Wanted) -> usize {
    let [red, green, blue] = wanted.background;
    let shows_background = stored.alpha || wanted.may_lack;
    let is_grey = stored.model == Model::Grey && !(shows_background && (red != green || green != blue));
    if wanted.colour && !is_grey { 4 } else { 1 }
}

/// Zeros, as many as the memory has room for.
pub(super) fn zeros<T: Copy + Default>(count: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| out_of_memory(count.saturating_mul(size_of::<T>())))?;
    values.resize(count, T::default());
    Ok(values)
}

#[cfg(test)]
mod tests {
    use moxcms::ColorProfile;

    use super::*;
    use crate::decoding::colour::Colours;
    use crate::decoding::stored::{Depth, Owned};

    const COLOURED: [u8; 3] = [200, 30, 90];

    /// Samples of no order, alike at every depth.
    fn samples(count: usize, depth: Depth) -> Owned {
        let bytes = (0..count).map(|i| (i * i * 31 + i * 57 + 11) as u8);
        match depth {
            Depth::U8 => Owned::U8(bytes.collect()),
            Depth::U16 => Owned::U16(bytes.map(|v| u16::from(v) * 257).collect()),
            Depth::F32 => Owned::F32(bytes.map(|v| f32::from(v) / 255.0).collect()),
        }
    }

    /// The photo of a stored image, with its colour or without.
    fn photo(stored: Stored, depth: Depth, factor: usize, colours: &Colours, wanted: Wanted) -> Photo {
        let depth_of_conversion = if stored.premultiplied && stored.alpha { Depth::F32 } else { depth };
        let conversion = colours.conversion(stored.model, depth_of_conversion);
        let control = Control::new();
        let mut canvas = Canvas::new(stored, factor, wanted, conversion, &control).unwrap();
        let all = samples(stored.width * stored.height * stored.channels(), depth);
        canvas.put(0, 0, stored.width, all.as_samples()).unwrap();
        canvas.finish().unwrap()
    }

    /// That the luma is the one that is read without colour, and the colour has it.
    fn check(stored: Stored, depth: Depth, factor: usize, colours: &Colours, background: [u8; 3]) -> Photo {
        let without = Wanted { background, colour: false, may_lack: false };
        let plain = photo(stored, depth, factor, colours, without);
        let coloured = photo(stored, depth, factor, colours, Wanted { colour: true, ..without });
        assert!(plain.colour().is_none());
        assert_eq!(coloured.clone().without_colour(), plain, "{stored:?} {depth:?}");
        let colour = coloured.colour().unwrap();
        let planes = colour.planes().map(Field::values);
        for (i, luma) in plain.luma().values().iter().enumerate() {
            let sum = 0.299 * planes[0][i] + 0.587 * planes[1][i] + 0.114 * planes[2][i];
            assert!((sum - luma).abs() < 2e-6, "{stored:?} {depth:?}: {sum} instead of {luma} at {i}");
        }
        coloured
    }

    #[test]
    fn every_kind_of_pixels_keeps_its_colour_and_its_luma() {
        let srgb = || Colours::Srgb;
        let icc = |profile: ColorProfile| Colours::of_icc(&profile.encode().unwrap());
        let kinds = [
            (Model::Grey, srgb()),
            (Model::Rgb, srgb()),
            (Model::Cmyk, srgb()),
            (Model::Rgb, icc(ColorProfile::new_display_p3())),
            (Model::Rgb, Colours::adobe_rgb()),
            (Model::Grey, icc(ColorProfile::new_gray_with_gamma(1.0))),
        ];
        for (model, colours) in &kinds {
            for depth in [Depth::U8, Depth::U16, Depth::F32] {
                for (alpha, premultiplied) in [(false, false), (true, false), (true, true)] {
                    // Conversions take their time to make.
                    let last = if matches!(colours, Colours::Srgb) { 8 } else { 1 };
                    for orientation in 1..=last {
                        for (factor, background) in [(1, [255; 3]), (1, COLOURED), (2, COLOURED)] {
                            let stored = Stored { width: 7, height: 5, model: *model, alpha, premultiplied, orientation };
                            let read = check(stored, depth, factor, colours, background);
                            let is_grey = *model == Model::Grey && (!alpha || background == [255; 3]);
                            assert_eq!(read.colour().unwrap().is_grey(), is_grey, "{stored:?}");
                        }
                    }
                }
            }
        }
        // More than a thread converts at once, and than is placed at once.
        let large = Stored { width: 130, height: 700, model: Model::Rgb, alpha: true, premultiplied: false, orientation: 6 };
        for factor in [1, 3] {
            check(large, Depth::U8, factor, &Colours::adobe_rgb(), COLOURED);
            check(Stored { orientation: 1, ..large }, Depth::U8, factor, &srgb(), COLOURED);
        }
    }

    #[test]
    fn plain_colours_are_shares_of_their_samples_in_their_places() {
        let stored = Stored { width: 4, height: 3, model: Model::Rgb, alpha: false, premultiplied: false, orientation: 1 };
        let Owned::U8(bytes) = samples(36, Depth::U8) else { unreachable!("they are bytes") };
        let value = |x: usize, y: usize, c: usize| f32::from(bytes[(y * 4 + x) * 3 + c]) / 255.0;
        for depth in [Depth::U8, Depth::U16, Depth::F32] {
            let upright = check(stored, depth, 1, &Colours::Srgb, [255; 3]);
            // A quarter turn clockwise brings the stored left column to the top.
            let turned = check(Stored { orientation: 6, ..stored }, depth, 1, &Colours::Srgb, [255; 3]);
            for (x, y) in (0..4).flat_map(|x| (0..3).map(move |y| (x, y))) {
                let expected = [0, 1, 2].map(|c| value(x, y, c));
                assert_eq!(upright.colour().unwrap().at(x, y), expected);
                assert_eq!(turned.colour().unwrap().at(2 - y, x), expected);
            }
            let reduced = check(stored, depth, 2, &Colours::Srgb, [255; 3]);
            assert_eq!(reduced.colour().unwrap().at(0, 0).map(|v| (v * 1e5).round()), {
                let mean = |c| (0..6).map(|i| value(i % 2, i / 2, c)).sum::<f32>() / 6.0;
                [0, 1, 2].map(|c| (mean(c) * 1e5).round())
            });
        }
    }

    #[test]
    fn what_is_left_is_the_background_in_its_colour() {
        let control = Control::new();
        for model in [Model::Grey, Model::Rgb] {
            let stored = Stored { width: 3, height: 2, model, alpha: false, premultiplied: false, orientation: 1 };
            let wanted = Wanted { background: COLOURED, colour: true, may_lack: true };
            let mut canvas = Canvas::new(stored, 1, wanted, None, &control).unwrap();
            canvas.put(0, 0, 3, samples(3 * stored.channels(), Depth::U8).as_samples()).unwrap();
            canvas.leave(0, 1, 3, 1);
            let photo = canvas.finish().unwrap();
            assert_eq!(photo.colour().unwrap().at(1, 1), COLOURED.map(|v| f32::from(v) / 255.0));
        }
    }

    #[test]
    fn inks_without_a_profile_are_laid_over_one_another() {
        let wanted = Wanted { background: [255; 3], colour: true, may_lack: false };
        let stored = Stored { width: 2, height: 1, model: Model::Cmyk, alpha: false, premultiplied: false, orientation: 1 };
        let control = Control::new();
        let mut canvas = Canvas::new(stored, 1, wanted, None, &control).unwrap();
        canvas.put(0, 0, 2, Samples::F32(&[1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.75])).unwrap();
        let photo = canvas.finish().unwrap();
        assert_eq!(photo.colour().unwrap().at(0, 0), [0.0, 1.0, 0.5]);
        assert_eq!(photo.colour().unwrap().at(1, 0), [0.25; 3]);
    }
}
