//! Tone: from the samples of an image to one grey field, and the adjustments that a user makes to it.
//!
//! The grey level is Rec. 601 luma, 0.299 R + 0.587 G + 0.114 B, of the sRGB-encoded values, not of linear light: a drawing is
//! compared with the photo by eye, and equal steps of the encoded values look about equal. The option `linear` decodes the luma to
//! linear light, for drawings that are to reflect as much light as the photo shows. Alpha is composited on a background
//! colour, on the encoded values too, as image viewers do. Integer samples are summed in integers and divided once, so that the
//! field is the same on every machine and 16-bit samples keep their 16 bits.
//! What this module does not do: read files and convert colour profiles (see [`crate::stages::decode()`]).

use std::borrow::Cow;

use rayon::prelude::*;

use crate::base::{Error, Result};
use crate::options::{Options, Point};
use crate::photo::field::{Field, check_size, check_values};

/// Samples of an image, row-major, channels interleaved.
#[derive(Debug, Clone, Copy)]
pub enum Samples<'a> {
    /// 0 to 255.
    U8(&'a [u8]),
    /// 0 to 65535.
    U16(&'a [u16]),
    /// 0 to 1.
    F32(&'a [f32]),
}

impl Samples<'_> {
    /// How many samples there are.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::U8(s) => s.len(),
            Self::U16(s) => s.len(),
            Self::F32(s) => s.len(),
        }
    }
}

/// An image as its samples: 1 channel is grey, 2 grey and alpha, 3 sRGB, 4 sRGB and alpha (not premultiplied).
#[derive(Debug, Clone, Copy)]
pub struct Pixels<'a> {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// 1 to 4.
    pub channels: usize,
    /// `width * height * channels` samples.
    pub samples: Samples<'a>,
}

/// The luma of an image, composited on `background` (8-bit sRGB) where it is transparent.
///
/// A grey sample v gives exactly v / 255 (8 bits) or v / 65535 (16 bits), rounded once to f32, and so does the colour (v, v, v).
///
/// # Errors
/// [`Error::Input`] if a side is 0 or above [`crate::stages::MAX_SIDE`], the channels are not 1 to 4, the number of samples is
/// not `width * height * channels`, or a float sample is not in [0, 1].
pub fn luma(pixels: &Pixels, background: [u8; 3]) -> Result<Field> {
    let Pixels { width, height, channels, samples } = *pixels;
    check_size(width, height)?;
    if !(1..=4).contains(&channels) {
        return Err(Error::Input(format!("the image has {channels} channels, but it must have 1 to 4")));
    }
    let count = samples.len();
    if count != width * height * channels {
        return Err(Error::Input(format!(
            "the image has {count} samples, but {width} x {height} pixels of {channels} channels need {}",
            width * height * channels
        )));
    }
    if let Samples::F32(values) = samples {
        check_values(values, channels, width, [0, 0])?;
    }
    let mut values = vec![0.0; width * height];
    weigh_into(samples, channels, background, &mut values);
    Ok(Field::of_valid(width, height, values))
}

/// The luma of pixels of 1 to 4 channels, composited on `background`; float samples lie in [0, 1].
pub(crate) fn weigh_into(samples: Samples, channels: usize, background: [u8; 3], target: &mut [f32]) {
    weighed::<299, 587, 114>(samples, channels, background, target);
}

/// Red, green and blue of such pixels, each as the luma of a grey pixel of its value is.
pub(crate) fn colours_into(samples: Samples, channels: usize, background: [u8; 3], [red, green, blue]: [&mut [f32]; 3]) {
    weighed::<1000, 0, 0>(samples, channels, background, red);
    weighed::<0, 1000, 0>(samples, channels, background, green);
    weighed::<0, 0, 1000>(samples, channels, background, blue);
}

/// The sum of red, green and blue by these thousandths.
fn weighed<const R: u64, const G: u64, const B: u64>(samples: Samples, channels: usize, background: [u8; 3], target: &mut [f32]) {
    match samples {
        Samples::U8(s) => of_integers::<_, R, G, B>(s, channels, 255, background, target),
        Samples::U16(s) => of_integers::<_, R, G, B>(s, channels, 65_535, background, target),
        Samples::F32(s) => of_floats::<R, G, B>(s, channels, background, target),
    }
}

/// The sum of 8-bit or 16-bit samples (`max` is the value of white). It is linear, so the sum of the composited colour is the
/// composited sum: one sum and one division a pixel. The sums stay below 2^53, where f64 is exact.
fn of_integers<T: Copy + Into<u64>, const R: u64, const G: u64, const B: u64>(
    samples: &[T],
    channels: usize,
    max: u64,
    background: [u8; 3],
    target: &mut [f32],
) {
    let weigh = |red: u64, green: u64, blue: u64| R * red + G * green + B * blue;
    let [red, green, blue] = background.map(|v| u64::from(v) * (max / 255));
    let behind = weigh(red, green, blue);
    let opaque = |sum: u64| (sum as f64 / (1000 * max) as f64) as f32;
    let blended = |sum: u64, alpha: u64| ((sum * alpha + behind * (max - alpha)) as f64 / (1000 * max * max) as f64) as f32;
    let pixels = target.iter_mut().zip(samples.chunks_exact(channels));
    match channels {
        1 => pixels.for_each(|(target, p)| *target = opaque(1000 * p[0].into())),
        2 => pixels.for_each(|(target, p)| *target = blended(1000 * p[0].into(), p[1].into())),
        3 => pixels.for_each(|(target, p)| *target = opaque(weigh(p[0].into(), p[1].into(), p[2].into()))),
        _ => pixels.for_each(|(target, p)| *target = blended(weigh(p[0].into(), p[1].into(), p[2].into()), p[3].into())),
    }
}

/// The sum of float samples in [0, 1], computed in f64; the last digit may exceed 1, which the clamp takes away.
fn of_floats<const R: u64, const G: u64, const B: u64>(samples: &[f32], channels: usize, background: [u8; 3], target: &mut [f32]) {
    let [of_red, of_green, of_blue] = [R, G, B].map(|thousandths| thousandths as f64 / 1000.0);
    let weigh = |red: f64, green: f64, blue: f64| of_red * red + of_green * green + of_blue * blue;
    let colour = |p: &[f32]| weigh(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
    let [red, green, blue] = background.map(|v| f64::from(v) / 255.0);
    let behind = weigh(red, green, blue);
    let blended = |sum: f64, alpha: f64| ((sum * alpha + behind * (1.0 - alpha)) as f32).clamp(0.0, 1.0);
    let pixels = target.iter_mut().zip(samples.chunks_exact(channels));
    match channels {
        1 => pixels.for_each(|(target, p)| *target = p[0]),
        2 => pixels.for_each(|(target, p)| *target = blended(f64::from(p[0]), f64::from(p[1]))),
        3 => pixels.for_each(|(target, p)| *target = (colour(p) as f32).clamp(0.0, 1.0)),
        _ => pixels.for_each(|(target, p)| *target = blended(colour(p), f64::from(p[3]))),
    }
}

/// A field in 8 bits: 255 times each value, rounded to the nearest integer. It gives 8-bit grey samples back unchanged.
pub fn luma_to_u8(luma: &Field) -> Vec<u8> {
    // Adding a half and truncating is rounding here, since no value is negative; it vectorizes, `round` does not.
    luma.values().iter().map(|v| (f64::from(*v) * 255.0 + 0.5) as u8).collect()
}

/// The tone that is drawn: the luma, stretched so that the black point is 0 and the white point is 1 (clipped to [0, 1]), decoded to
/// linear light if `linear`, to the power 1 / gamma, then its distance from 0.5 times `contrast` (clipped to [0, 1]), then 1 minus it
/// if `invert`. The default options change nothing.
///
/// # Errors
/// [`Error::Input`] if the photo's own white point, where it is asked for, does not lie above the black point that is given, or the
/// other way round.
pub fn adjust(luma: &Field, options: &Options) -> Result<Field> {
    adjusted(luma, options).map(Cow::into_owned)
}

/// As [`adjust`], without a copy where nothing changes.
pub(crate) fn adjusted<'a>(luma: &'a Field, options: &Options) -> Result<Cow<'a, Field>> {
    let Options { linear, gamma, contrast, invert, .. } = *options;
    let [black, white] = points(luma, options)?;
    if [black, white] == [0.0, 1.0] && !linear && gamma == 1.0 && contrast == 1.0 && !invert {
        return Ok(Cow::Borrowed(luma));
    }
    let exponent = 1.0 / gamma;
    let tone_of = |value: &f32| {
        let mut tone = f64::from(*value);
        if [black, white] != [0.0, 1.0] {
            tone = ((tone - black) / (white - black)).clamp(0.0, 1.0);
        }
        if linear {
            tone = linear_light(tone);
        }
        if gamma != 1.0 {
            // libm's pow instead of the system's: the same bits on every platform.
            tone = libm::pow(tone, exponent);
        }
        if contrast != 1.0 {
            tone = 0.5 + contrast * (tone - 0.5);
        }
        tone = tone.clamp(0.0, 1.0);
        (if invert { 1.0 - tone } else { tone }) as f32
    };
    Ok(Cow::Owned(Field::of_valid(luma.width(), luma.height(), luma.values().par_iter().map(tone_of).collect())))
}

/// A channel of a photo of this luma, adjusted as its tone is but for `linear`: colours mix in linear light then. Automatic points are
/// those of the luma.
///
/// # Errors
/// As [`adjust`].
pub(crate) fn adjusted_channel<'a>(channel: &'a Field, luma: &Field, options: &Options) -> Result<Cow<'a, Field>> {
    let mut options = Options { linear: false, ..options.clone() };
    if [options.black_point, options.white_point].contains(&Some(Point::Auto)) {
        let [black, white] = points(luma, &options)?;
        (options.black_point, options.white_point) = (Some(Point::At(black)), Some(Point::At(white)));
    }
    adjusted(channel, &options)
}

/// The share of pixels that an automatic point leaves beyond it: specks and glints must not decide.
const BEYOND: f64 = 0.005;

/// The greys of the photo that become black and white; 0 and 1 where nothing is asked for, or where the photo is flat.
fn points(luma: &Field, options: &Options) -> Result<[f64; 2]> {
    let last = (luma.values().len() - 1) as f64;
    let of_rank = |rank: f64| f64::from(luma.of_rank(rank as usize).0);
    let black = match options.black_point {
        None => 0.0,
        Some(Point::At(grey)) => grey,
        Some(Point::Auto) => of_rank((BEYOND * last).floor()),
    };
    let white = match options.white_point {
        None => 1.0,
        Some(Point::At(grey)) => grey,
        Some(Point::Auto) => of_rank(((1.0 - BEYOND) * last).ceil()),
    };
    if black < white {
        return Ok([black, white]);
    }
    if [options.black_point, options.white_point] == [Some(Point::Auto); 2] {
        return Ok([0.0, 1.0]);
    }
    Err(Error::Input(format!("the photo's white point is {white:.3}, but it must be above its black point, which is {black:.3}")))
}

/// The light of an sRGB-encoded value, both in [0, 1] (IEC 61966-2-1).
fn linear_light(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [u8; 3] = [255; 3];

    fn of(channels: usize, samples: Samples, background: [u8; 3]) -> Vec<f32> {
        let count = match samples {
            Samples::U8(s) => s.len(),
            Samples::U16(s) => s.len(),
            Samples::F32(s) => s.len(),
        };
        luma(&Pixels { width: count / channels, height: 1, channels, samples }, background).unwrap().into_values()
    }

    #[test]
    fn grey_samples_are_exact_and_survive_the_round_trip() {
        let grey: Vec<u8> = (0..=255).collect();
        let values = of(1, Samples::U8(&grey), WHITE);
        for (v, value) in grey.iter().zip(&values) {
            assert_eq!(*value, f32::from(*v) / 255.0);
        }
        assert_eq!(luma_to_u8(&Field::new(256, 1, values.clone()).unwrap()), grey);

        let rgb: Vec<u8> = grey.iter().flat_map(|v| [*v; 3]).collect();
        assert_eq!(of(3, Samples::U8(&rgb), WHITE), values);
        let opaque: Vec<u8> = grey.iter().flat_map(|v| [*v, *v, *v, 255]).collect();
        assert_eq!(of(4, Samples::U8(&opaque), [1, 2, 3]), values);

        let deep: Vec<u16> = (0..=65_534).collect();
        let values = of(1, Samples::U16(&deep), WHITE);
        for (v, value) in deep.iter().zip(&values) {
            assert_eq!(*value, f32::from(*v) / 65_535.0);
        }
        let rgb: Vec<u16> = deep[..20_000].iter().flat_map(|v| [*v; 3]).collect();
        assert_eq!(of(3, Samples::U16(&rgb), WHITE), values[..20_000]);
    }

    #[test]
    fn colours_are_weighted_by_rec_601() {
        let primaries = [255, 0, 0, 0, 255, 0, 0, 0, 255, 10, 20, 30];
        assert_eq!(of(3, Samples::U8(&primaries), WHITE), [0.299, 0.587, 0.114, 18_150.0 / 255_000.0]);
        let floats = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0];
        assert_eq!(of(3, Samples::F32(&floats), WHITE), [0.299, 0.587, 1.0]);
    }

    #[test]
    fn transparency_shows_the_background() {
        let grey_alpha = [0u8, 0, 0, 255, 200, 51];
        assert_eq!(of(2, Samples::U8(&grey_alpha), WHITE), [1.0, 0.0, ((200.0 * 51.0 + 255.0 * 204.0) / 65_025.0f64) as f32]);
        assert_eq!(of(2, Samples::U8(&grey_alpha), [0; 3])[0], 0.0);
        assert_eq!(of(4, Samples::U8(&[9, 9, 9, 0]), [255, 0, 0]), [0.299]);
        assert_eq!(of(4, Samples::U16(&[9, 9, 9, 0]), [0, 255, 0]), [0.587]);
        assert_eq!(of(4, Samples::F32(&[0.0, 0.0, 0.0, 0.5]), WHITE), [0.5]);
        assert_eq!(of(2, Samples::F32(&[0.25, 1.0]), WHITE), [0.25]);
    }

    #[test]
    fn what_is_not_an_image_is_refused_in_one_sentence() {
        let message = |width, channels, samples: Samples| {
            luma(&Pixels { width, height: 2, channels, samples }, WHITE).unwrap_err().to_string()
        };
        assert_eq!(message(1, 5, Samples::U8(&[0; 10])), "the image has 5 channels, but it must have 1 to 4");
        assert_eq!(message(1, 0, Samples::U8(&[])), "the image has 0 channels, but it must have 1 to 4");
        assert_eq!(message(3, 3, Samples::U16(&[0; 17])), "the image has 17 samples, but 3 x 2 pixels of 3 channels need 18");
        assert!(message(0, 1, Samples::U8(&[])).starts_with("the image is 0 x 2 pixels"));
        let nan = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN];
        let negative = [0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(message(3, 2, Samples::F32(&nan)), "the value at column 2, row 1 is NaN, but it must be between 0 and 1");
        assert_eq!(message(3, 2, Samples::F32(&negative)), "the value at column 1, row 0 is -0.5, but it must be between 0 and 1");
    }

    #[test]
    fn adjustments_follow_their_formula() {
        let luma = Field::new(5, 1, vec![0.0, 0.25, 0.5, 0.81, 1.0]).unwrap();
        let adjusted = |gamma: f64, contrast: f64, invert: bool| {
            adjust(&luma, &Options { gamma, contrast, invert, ..Options::default() }).unwrap().into_values()
        };
        assert_eq!(adjusted(1.0, 1.0, false), luma.values());
        assert_eq!(adjusted(1.0, 1.0, true), [1.0, 0.75, 0.5, (1.0 - f64::from(0.81f32)) as f32, 0.0]);
        assert_eq!(adjusted(2.0, 1.0, false), [0.0, 0.5, libm::pow(0.5, 0.5) as f32, 0.9, 1.0]);
        assert_eq!(adjusted(1.0, 2.0, false), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(adjusted(1.0, 0.0, true), [0.5; 5]);
        // Gamma comes before contrast, contrast before inversion.
        assert_eq!(adjusted(0.5, 2.0, true)[2], 1.0);
        for gamma in [0.1, 10.0] {
            assert!(adjusted(gamma, 10.0, false).iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }

    #[test]
    fn linear_light_is_srgb_decoded_before_all_else() {
        let luma = Field::new(5, 1, vec![0.0, 0.04, 0.04045, 0.5, 1.0]).unwrap();
        let linear = Options { linear: true, ..Options::default() };
        let expected = [0.0, 0.003_095_975, 0.003_130_805, 0.214_041_14, 1.0];
        for (value, expected) in adjust(&luma, &linear).unwrap().values().iter().zip(expected) {
            assert!((value - expected).abs() < 1e-7, "{value} instead of {expected}");
        }
        let bright = adjust(&luma, &Options { gamma: 2.0, ..linear }).unwrap();
        assert!((bright.values()[3] - 0.214_041_14f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn points_become_black_and_white() {
        let luma = Field::new(5, 1, vec![0.2, 0.4, 0.5, 0.6, 0.9]).unwrap();
        let stretched = |black_point, white_point| {
            let tone = adjust(&luma, &Options { black_point, white_point, ..Options::default() });
            tone.map(|tone| tone.into_values().iter().map(|v| (v * 1e4).round() / 1e4).collect::<Vec<f32>>())
        };
        assert_eq!(stretched(Some(Point::At(0.4)), Some(Point::At(0.6))).unwrap(), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(stretched(None, Some(Point::At(0.5))).unwrap(), [0.4, 0.8, 1.0, 1.0, 1.0]);
        assert_eq!(stretched(Some(Point::Auto), Some(Point::Auto)).unwrap(), [0.0, 0.2857, 0.4286, 0.5714, 1.0]);
        let told = stretched(Some(Point::At(0.95)), Some(Point::Auto)).unwrap_err().to_string();
        assert_eq!(told, "the photo's white point is 0.900, but it must be above its black point, which is 0.950");
        // Half a percent of specks decides nothing; a flat photo stays as it is.
        let specks = |i: usize| {
            if i < 4 {
                1.0
            } else if i < 8 {
                0.0
            } else {
                0.4 + 0.2 * (i % 2) as f32
            }
        };
        let specked = Field::new(100, 10, (0..1000).map(specks).collect()).unwrap();
        let auto = Options { black_point: Some(Point::Auto), white_point: Some(Point::Auto), ..Options::default() };
        assert_eq!(points(&specked, &auto).unwrap().map(|grey| grey as f32), [0.4, 0.6]);
        let flat = Field::constant(9, 9, 0.5).unwrap();
        assert_eq!(adjust(&flat, &auto).unwrap(), flat);
    }
}
