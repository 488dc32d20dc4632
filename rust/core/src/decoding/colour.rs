//! Colour: from what a file says of its samples to sRGB. In: a profile (ICC), chromaticities and a gamma (PNG's cHRM and gAMA), code
//! points (PNG's cICP, ITU-T H.273) or a camera's mark; out: samples of the same depth in sRGB, by the crate `moxcms`.
//!
//! moxcms chooses its arithmetic by the processor, so a converted photo may differ by one step of 255 between kinds of machines.

use std::sync::Arc;

use moxcms::{
    Chromaticity, CicpColorPrimaries, CicpProfile, ColorPrimaries, ColorProfile, DataColorSpace, Layout, MatrixCoefficients,
    ToneReprCurve, TransferCharacteristics, TransformExecutor, TransformOptions, XyY,
};

use super::caught::caught;
use super::kinds::{Container, PROFILE_BYTES};
use super::stored::{Depth, Model, Owned};
use crate::base::Result;

/// By how much, of 255, a colour profile may differ from sRGB and still be taken for it. The many sRGB profiles in use differ
/// by their rounding, up to 2 in the darks; converting those would cost time and change nothing that can be seen.
const SAME_AS_SRGB: u8 = 2;

/// The light that paper white has where samples stand for light beyond it, in cd/m2 (ITU-R BT.2408).
const REFERENCE_WHITE: f64 = 203.0;

/// Steps of a tone curve that has no formula in profiles.
const CURVE_STEPS: usize = 4096;

/// What a file says of its colours; the default is sRGB.
#[derive(Default)]
pub(super) enum Colours {
    #[default]
    Srgb,
    Profile(Box<ColorProfile>),
}

impl Colours {
    /// Those of a file with an embedded profile, or else with a camera's mark of Adobe RGB.
    ///
    /// # Errors
    /// [`Error::Decode`](crate::Error::Decode) for a profile that is larger than any.
    pub(super) fn of_file(container: Container, profile: Option<&[u8]>, adobe_rgb: bool) -> Result<Self> {
        match profile {
            Some(profile) if profile.len() > PROFILE_BYTES => Err(container.large_profile(profile.len())),
            Some(profile) => Ok(Self::of_icc(profile)),
            None if adobe_rgb => Ok(Self::adobe_rgb()),
            None => Ok(Self::Srgb),
        }
    }

    /// Those of an embedded profile; sRGB if it is broken.
    pub(super) fn of_icc(bytes: &[u8]) -> Self {
        let parsed = caught(|| ColorProfile::new_from_slice(bytes).ok()).flatten();
        parsed.map_or(Self::Srgb, |profile| Self::Profile(Box::new(profile)))
    }

    /// Adobe RGB (1998).
    pub(super) fn adobe_rgb() -> Self {
        Self::Profile(Box::new(ColorProfile::new_adobe_rgb()))
    }

    /// Those of a gamma: the light is the sample to the power 1 / `gamma`; and of chromaticities x, y of white, red, green and blue,
    /// without them sRGB's.
    pub(super) fn of_gamma(gamma: Option<f64>, chromaticities: Option<[[f64; 2]; 4]>, grey: bool) -> Self {
        let curve = match gamma {
            Some(gamma) if gamma > 0.0 => ToneReprCurve::Parametric(vec![(1.0 / gamma) as f32]),
            _ => srgb_curve(),
        };
        Self::of_curve(curve, chromaticities, grey)
    }

    /// Those of code points for primaries and transfer; `None` for those that stand for nothing.
    pub(super) fn of_code_points(primaries: u8, transfer: u8, grey: bool) -> Option<Self> {
        if [primaries, transfer] == [1, 13] {
            return Some(Self::Srgb);
        }
        let mut profile = ColorProfile::new_srgb();
        let known = CicpProfile {
            color_primaries: CicpColorPrimaries::try_from(primaries).ok()?,
            // The curve is replaced below where it is of light beyond white.
            transfer_characteristics: match transfer {
                16 | 18 => TransferCharacteristics::Linear,
                _ => TransferCharacteristics::try_from(transfer).ok()?,
            },
            matrix_coefficients: MatrixCoefficients::Identity,
            full_range: true,
        };
        ColorPrimaries::try_from(known.color_primaries).ok()?;
        ToneReprCurve::try_from(known.transfer_characteristics).ok()?;
        profile.update_rgb_colorimetry_from_cicp(known);
        profile.cicp = None;
        let curve = match transfer {
            16 => Some(curve_of(|v| perceptual_quantizer(v) * 10_000.0 / REFERENCE_WHITE)),
            // 75 % of the signal is reference white.
            18 => Some(curve_of(|v| hybrid_log_gamma(v) / hybrid_log_gamma(0.75))),
            _ => None,
        };
        if let Some(curve) = curve {
            for trc in [&mut profile.red_trc, &mut profile.green_trc, &mut profile.blue_trc] {
                *trc = Some(curve.clone());
            }
        }
        if grey {
            let mut of_grey = ColorProfile::new_gray_with_gamma(1.0);
            of_grey.gray_trc = profile.green_trc;
            profile = of_grey;
        }
        Some(Self::Profile(Box::new(profile)))
    }

    fn of_curve(curve: ToneReprCurve, chromaticities: Option<[[f64; 2]; 4]>, grey: bool) -> Self {
        let profile = if grey {
            let mut profile = ColorProfile::new_gray_with_gamma(1.0);
            profile.gray_trc = Some(curve);
            profile
        } else {
            let mut profile = ColorProfile::new_srgb();
            profile.cicp = None;
            if let Some([white, red, green, blue]) = chromaticities.filter(spans_colours) {
                let of = |[x, y]: [f64; 2]| Chromaticity { x: x as f32, y: y as f32 };
                let primaries = ColorPrimaries { red: of(red), green: of(green), blue: of(blue) };
                profile.update_rgb_colorimetry(XyY { x: white[0], y: white[1], yb: 1.0 }, primaries);
            }
            for trc in [&mut profile.red_trc, &mut profile.green_trc, &mut profile.blue_trc] {
                *trc = Some(curve.clone());
            }
            profile
        };
        Self::Profile(Box::new(profile))
    }

    /// What brings pixels of a model and depth to sRGB; `None` if there is nothing to do. A profile that is broken, that is sRGB,
    /// or that is not for these pixels, changes nothing.
    pub(super) fn conversion(&self, model: Model, depth: Depth) -> Option<Conversion> {
        let Self::Profile(profile) = self else { return None };
        let fits = matches!(
            (profile.color_space, model),
            (DataColorSpace::Rgb, Model::Rgb) | (DataColorSpace::Gray, Model::Grey) | (DataColorSpace::Cmyk, Model::Cmyk)
        );
        if !fits {
            return None;
        }
        caught(|| if is_srgb(profile, model) { None } else { Conversion::new(profile, model, depth) }).flatten()
    }
}

/// Whether white and primaries are a white within a triangle.
fn spans_colours([white, red, green, blue]: &[[f64; 2]; 4]) -> bool {
    let side = |a: &[f64; 2], b: &[f64; 2], p: &[f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let sides = [side(red, green, white), side(green, blue, white), side(blue, red, white)];
    let seen = [white, red, green, blue].iter().all(|c| c[0] >= 0.0 && c[1] > 0.0 && c[0] + c[1] <= 1.0 + 1e-6);
    (seen || white[1] > 0.0) && (sides.iter().all(|s| *s > 1e-4) || sides.iter().all(|s| *s < -1e-4))
}

fn srgb_curve() -> ToneReprCurve {
    ColorProfile::new_srgb().green_trc.expect("sRGB has a curve")
}

fn curve_of(light: impl Fn(f64) -> f64) -> ToneReprCurve {
    let last = (CURVE_STEPS - 1) as f64;
    ToneReprCurve::Lut((0..CURVE_STEPS).map(|i| (light(i as f64 / last).clamp(0.0, 1.0) * 65_535.0).round() as u16).collect())
}

/// The light of a sample as a share of 10,000 cd/m2 (SMPTE ST 2084).
fn perceptual_quantizer(sample: f64) -> f64 {
    const M1: f64 = 2610.0 / 16_384.0;
    const M2: f64 = 2523.0 / 32.0;
    const C1: f64 = 3424.0 / 4096.0;
    const C2: f64 = 2413.0 / 128.0;
    const C3: f64 = 2392.0 / 128.0;
    let root = libm::pow(sample, 1.0 / M2);
    libm::pow((root - C1).max(0.0) / (C2 - C3 * root), 1.0 / M1)
}

/// The light of a scene as a share of its brightest (ITU-R BT.2100, the inverse of the transfer function).
fn hybrid_log_gamma(sample: f64) -> f64 {
    const A: f64 = 0.178_832_77;
    const B: f64 = 0.284_668_92;
    const C: f64 = 0.559_910_73;
    if sample <= 0.5 { sample * sample / 3.0 } else { (libm::exp((sample - C) / A) + B) / 12.0 }
}

/// What brings samples of one depth to sRGB: grey to grey, colours and inks to R, G, B.
pub(super) enum Conversion {
    Grey8(Vec<u8>),
    Grey16(Vec<u16>),
    Colours8(Transform<u8>, usize),
    Colours16(Transform<u16>, usize),
    Floats(Transform<f32>, usize),
}

type Transform<T> = Arc<dyn TransformExecutor<T> + Send + Sync>;

impl Conversion {
    fn new(profile: &ColorProfile, model: Model, depth: Depth) -> Option<Self> {
        let srgb = ColorProfile::new_srgb();
        let options = TransformOptions::default();
        let (layout, channels) = layout_of(model);
        Some(match (depth, model) {
            (Depth::U8, Model::Grey) => Self::Grey8(grey_ramp(profile)?),
            (Depth::U16, Model::Grey) => {
                let ramp: Vec<u16> = (0..=u16::MAX).collect();
                let transform = profile.create_transform_16bit(layout, &srgb, Layout::Rgb, options).ok()?;
                Self::Grey16(of_grey(&*transform, &ramp)?)
            }
            (Depth::U8, _) => Self::Colours8(profile.create_transform_8bit(layout, &srgb, Layout::Rgb, options).ok()?, channels),
            (Depth::U16, _) => Self::Colours16(profile.create_transform_16bit(layout, &srgb, Layout::Rgb, options).ok()?, channels),
            (Depth::F32, _) => Self::Floats(profile.create_transform_f32(layout, &srgb, Layout::Rgb, options).ok()?, channels),
        })
    }

    /// Samples of whole pixels in sRGB. Floats, which premultiplied samples become, are converted by the profile's own depth.
    pub(super) fn convert(&self, samples: &Owned) -> Owned {
        fn run<T: Copy + Default>(transform: &Transform<T>, channels: usize, samples: &[T]) -> Vec<T> {
            let mut target = vec![T::default(); samples.len() / channels * 3];
            // The lengths are right, so it does not fail; should it panic, the picture is black.
            let _ = caught(|| transform.transform(samples, &mut target));
            if channels == 1 { target.chunks_exact(3).map(|pixel| pixel[1]).collect() } else { target }
        }
        match (self, samples) {
            (Self::Grey8(ramp), Owned::U8(values)) => Owned::U8(values.iter().map(|v| ramp[usize::from(*v)]).collect()),
            (Self::Grey16(ramp), Owned::U16(values)) => Owned::U16(values.iter().map(|v| ramp[usize::from(*v)]).collect()),
            (Self::Colours8(transform, channels), Owned::U8(values)) => Owned::U8(run(transform, *channels, values)),
            (Self::Colours16(transform, channels), Owned::U16(values)) => Owned::U16(run(transform, *channels, values)),
            (Self::Floats(transform, channels), Owned::F32(values)) => {
                let mut converted = run(transform, *channels, values);
                converted.iter_mut().for_each(|v| *v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) });
                Owned::F32(converted)
            }
            // The conversion is made for the samples' depth.
            (_, samples) => samples.clone(),
        }
    }
}

fn layout_of(model: Model) -> (Layout, usize) {
    match model {
        Model::Grey => (Layout::Gray, 1),
        Model::Rgb => (Layout::Rgb, 3),
        // What moxcms calls four channels, whatever they are.
        Model::Cmyk => (Layout::Rgba, 4),
    }
}

/// What a profile makes of every grey level of 8 bits; `None` if it makes nothing of them.
fn grey_ramp(profile: &ColorProfile) -> Option<Vec<u8>> {
    let ramp: Vec<u8> = (0..=u8::MAX).collect();
    let srgb = ColorProfile::new_srgb();
    let transform = profile.create_transform_8bit(Layout::Gray, &srgb, Layout::Rgb, TransformOptions::default()).ok()?;
    of_grey(&*transform, &ramp)
}

fn of_grey<T: Copy + Default>(transform: &(dyn TransformExecutor<T> + Send + Sync), ramp: &[T]) -> Option<Vec<T>> {
    let mut colours = vec![T::default(); 3 * ramp.len()];
    transform.transform(ramp, &mut colours).ok()?;
    Some(colours.chunks_exact(3).map(|c| c[1]).collect())
}

/// Whether a profile leaves a cube of colours (or every grey level) as it is, up to [`SAME_AS_SRGB`]: profiles are told by
/// what they do, since their names are many.
fn is_srgb(profile: &ColorProfile, model: Model) -> bool {
    const LEVELS: [u8; 10] = [0, 8, 32, 64, 96, 128, 160, 192, 224, 255];
    let same = |a: &[u8], b: &[u8]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= SAME_AS_SRGB);
    match model {
        Model::Grey => grey_ramp(profile).is_some_and(|ramp| same(&ramp, &(0..=u8::MAX).collect::<Vec<u8>>())),
        Model::Cmyk => false,
        Model::Rgb => {
            let cube: Vec<u8> = (0..1000).flat_map(|i| [i / 100, i / 10 % 10, i % 10].map(|level| LEVELS[level])).collect();
            let mut converted = vec![0u8; cube.len()];
            let srgb = ColorProfile::new_srgb();
            let transform = profile.create_transform_8bit(Layout::Rgb, &srgb, Layout::Rgb, TransformOptions::default());
            transform.is_ok_and(|t| t.transform(&cube, &mut converted).is_ok()) && same(&cube, &converted)
        }
    }
}
