//! What becomes of all that is not the subject: in, a tone (or any channel) and where the subject is; out, the same with the rest
//! stepping back, and the importance with the nodes that the rest saves.
//!
//! It is done before the tone is emphasized and its detail found, so that the subject's edge against its new surroundings is emphasized
//! and has nodes as any edge has. What is far from the subject is as smooth as the backdrop is, and stippled therefore.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::options::Backdrop;
use crate::photo::field::Field;

/// Contrast that a softened rest keeps.
const SOFT: f32 = 0.5;

/// How far a softened rest is blurred, as a share of the photo's size (the root of its area).
const SOFT_BLUR: f64 = 0.004;

/// How far a faded rest reaches, as a share of the subject's size (the root of its area).
const REACH: f64 = 0.4;

/// How far it is blurred, as a share of its reach: so far that nothing of it is drawn as shapes.
const FADE_BLUR: f64 = 0.25;

/// Ink that a faded rest has of its own: below a half, so that all of it are dots on paper.
const FADED: f32 = 0.5;

/// Importance of the rest, as a share of what it would be.
const fn share(backdrop: Backdrop) -> f32 {
    match backdrop {
        Backdrop::Keep => 1.0,
        Backdrop::Soften => 0.35,
        Backdrop::Fade => 0.3,
        Backdrop::Paper | Backdrop::Ink => 0.1,
    }
}

/// Distances from the subject, in spacings of nodes, up to which the importance is whole, and over which it falls: the edge needs nodes
/// on both sides.
const RIM: [f64; 2] = [2.0, 4.0];

/// The tone with the rest as the backdrop says. `mask` is 1 where the subject is, on the tone's raster.
pub(crate) fn backed<'a>(tone: Cow<'a, Field>, mask: &Field, backdrop: Backdrop) -> Cow<'a, Field> {
    let (width, height) = (tone.width(), tone.height());
    let size = ((width * height) as f64).sqrt();
    let rest = match backdrop {
        Backdrop::Keep => return tone,
        Backdrop::Paper => Rest::Even(1.0),
        Backdrop::Ink => Rest::Even(0.0),
        Backdrop::Soften => {
            let mut soft = without(&tone, mask, SOFT_BLUR * size);
            let mean = mean_without(&tone, mask);
            soft.par_iter_mut().for_each(|value| *value = mean + SOFT * (*value - mean));
            Rest::Each(soft)
        }
        Backdrop::Fade => {
            let reach = reach(mask);
            let mut faded = without(&tone, mask, FADE_BLUR * reach);
            let far = distances(mask);
            faded.par_iter_mut().zip(&far).for_each(|(value, far)| {
                let left = (1.0 - far / reach as f32).max(0.0);
                *value = 1.0 - FADED * (1.0 - *value) * left * left;
            });
            Rest::Each(faded)
        }
    };
    let blend = |i: usize, tone: f32| {
        let mask = mask.values()[i];
        (mask * tone + (1.0 - mask) * rest.at(i)).clamp(0.0, 1.0)
    };
    let values = tone.values().par_iter().enumerate().map(|(i, tone)| blend(i, *tone)).collect();
    Cow::Owned(Field::of_valid(width, height, values))
}

/// The tone of the rest.
enum Rest {
    Even(f32),
    Each(Vec<f32>),
}

impl Rest {
    fn at(&self, pixel: usize) -> f32 {
        match self {
            Self::Even(tone) => *tone,
            Self::Each(tones) => tones[pixel],
        }
    }
}

/// How far a faded rest reaches, in pixels.
fn reach(mask: &Field) -> f64 {
    let area = mask.mean() * mask.values().len() as f64;
    (REACH * area.sqrt()).max(1.0)
}

/// The importance with less of it away from the subject; `spacing` is the distance of kept nodes in pixels.
///
/// Where the rest fades it is even: so nodes are as far apart as at the subject, and it is the dots that grow smaller.
pub(crate) fn attended(importance: Field, mask: &Field, spacing: f64, backdrop: Backdrop) -> Field {
    let share = share(backdrop);
    if backdrop == Backdrop::Keep {
        return importance;
    }
    let (width, height) = (importance.width(), importance.height());
    let far = distances(mask);
    let faded = (backdrop == Backdrop::Fade).then(|| (share * mean_within(&importance, mask), reach(mask) as f32));
    let mut values = importance.into_values();
    let [whole, falling] = RIM.map(|spacings| (spacings * spacing) as f32);
    values.par_iter_mut().zip(&far).for_each(|(value, far)| {
        let near = 1.0 - ((far - whole) / falling).clamp(0.0, 1.0);
        let there = match faded {
            Some((even, reach)) if *far < reach => even,
            _ => share * *value,
        };
        *value = near * *value + (1.0 - near) * there;
    });
    Field::of_valid(width, height, values)
}

/// The tone blurred by `sigma` pixels without what the subject has of it, which the rest is continued into.
fn without(tone: &Field, mask: &Field, sigma: f64) -> Vec<f32> {
    let (width, height) = (tone.width(), tone.height());
    let of = |value: &(dyn Fn(usize) -> f32 + Sync)| {
        Field::of_valid(width, height, (0..width * height).into_par_iter().map(value).collect()).blurred(sigma)
    };
    let outside = of(&|i| 1.0 - mask.values()[i]);
    let weighed = of(&|i| tone.values()[i] * (1.0 - mask.values()[i]));
    let mean = mean_without(tone, mask);
    // Deep within the subject there is nothing to continue, nor is anything drawn of it.
    let ratio = |(sum, weight): (&f32, &f32)| ((sum + 1e-3 * mean) / (weight + 1e-3)).clamp(0.0, 1.0);
    weighed.values().par_iter().zip(outside.values()).map(ratio).collect()
}

/// The mean tone of the rest.
fn mean_without(tone: &Field, mask: &Field) -> f32 {
    mean_of(tone, mask, |mask| 1.0 - mask)
}

/// The mean of what lies within the subject.
fn mean_within(field: &Field, mask: &Field) -> f32 {
    mean_of(field, mask, |mask| mask)
}

/// A mean weighted by what is made of the mask; 1 where nothing has any weight.
fn mean_of(field: &Field, mask: &Field, weight_of: impl Fn(f64) -> f64) -> f32 {
    let (mut sum, mut all) = (0.0, 0.0);
    for (value, mask) in field.values().iter().zip(mask.values()) {
        let weight = weight_of(f64::from(*mask));
        sum += weight * f64::from(*value);
        all += weight;
    }
    if all > 0.0 { ((sum / all) as f32).clamp(0.0, 1.0) } else { 1.0 }
}

/// The distance of every pixel from the subject, in pixels: 0 within.
///
/// In two passes, by columns and by rows (Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", 2012).
fn distances(mask: &Field) -> Vec<f32> {
    let (width, height) = (mask.width(), mask.height());
    let none = (width + height) as f32;
    // The distance within the column.
    let mut far: Vec<f32> = mask.values().par_iter().map(|mask| if *mask >= 0.5 { 0.0 } else { none }).collect();
    for y in 1..height {
        let (above, row) = far[(y - 1) * width..(y + 1) * width].split_at_mut(width);
        row.iter_mut().zip(above).for_each(|(far, above)| *far = far.min(*above + 1.0));
    }
    for y in (1..height).rev() {
        let (row, below) = far[(y - 1) * width..(y + 1) * width].split_at_mut(width);
        row.iter_mut().zip(below).for_each(|(far, below)| *far = far.min(*below + 1.0));
    }
    far.par_chunks_exact_mut(width).for_each(nearest_of_row);
    far
}

/// Of distances within columns, along a row, those in the plane: the lower envelope of a parabola for every column.
fn nearest_of_row(row: &mut [f32]) {
    let heights: Vec<f64> = row.iter().map(|far| f64::from(*far) * f64::from(*far)).collect();
    let meet = |p: usize, q: usize| {
        let (a, b) = (p as f64, q as f64);
        ((heights[q] + b * b) - (heights[p] + a * a)) / (2.0 * (b - a))
    };
    // The lowest parabolas from left to right, and where each begins to be it.
    let (mut lowest, mut begins) = (vec![0usize], vec![f64::NEG_INFINITY]);
    for q in 1..row.len() {
        let mut at = meet(lowest[lowest.len() - 1], q);
        while at <= begins[begins.len() - 1] {
            lowest.pop();
            begins.pop();
            at = meet(lowest[lowest.len() - 1], q);
        }
        lowest.push(q);
        begins.push(at);
    }
    let mut k = 0;
    for (x, far) in row.iter_mut().enumerate() {
        while begins.get(k + 1).is_some_and(|begin| *begin < x as f64) {
            k += 1;
        }
        let across = x as f64 - lowest[k] as f64;
        *far = (across * across + heights[lowest[k]]).sqrt() as f32;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn field(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Field {
        Field::new(width, height, (0..width * height).map(|i| value(i % width, i / width)).collect()).unwrap()
    }

    proptest! {
        #[test]
        fn distances_are_those_to_the_nearest_pixel(width in 1usize..24, height in 1usize..24, seeds in proptest::collection::vec(0usize..576, 1..6)) {
            let inside = |i: usize| seeds.iter().any(|seed| seed % (width * height) == i);
            let far = distances(&field(width, height, |x, y| f32::from(u8::from(inside(y * width + x)))));
            for (i, far) in far.iter().enumerate() {
                let of = |j: usize| (((i % width) as f64 - (j % width) as f64).hypot((i / width) as f64 - (j / width) as f64)) as f32;
                let least = (0..width * height).filter(|j| inside(*j)).map(of).fold(f32::MAX, f32::min);
                prop_assert!((far - least).abs() < 1e-4, "{} {}", far, least);
            }
        }
    }

    /// A texture, and the subject its middle.
    fn texture_and_mask() -> (Field, Field) {
        let tone = field(120, 120, |x, y| if (x / 4 + y / 4).is_multiple_of(2) { 0.2 } else { 0.6 });
        let mask = field(120, 120, |x, y| f32::from(u8::from((40..80).contains(&x) && (40..80).contains(&y))));
        (tone, mask)
    }

    #[test]
    fn the_subject_stays_and_the_rest_is_what_the_backdrop_says() {
        let (tone, mask) = texture_and_mask();
        for backdrop in [Backdrop::Keep, Backdrop::Soften, Backdrop::Fade, Backdrop::Paper, Backdrop::Ink] {
            let made = backed(Cow::Borrowed(&tone), &mask, backdrop);
            for i in (0..120 * 120).filter(|i| mask.values()[*i] == 1.0) {
                assert_eq!(made.values()[i], tone.values()[i]);
            }
            let range = |x0: usize, x1: usize| {
                let of = |i: &usize| (x0..x1).contains(&(i % 120)) && (40..80).contains(&(i / 120));
                let values: Vec<f32> = (0..120 * 120).filter(of).map(|i| made.values()[i]).collect();
                values.iter().fold([1.0f32, 0.0], |[low, high], v| [low.min(*v), high.max(*v)])
            };
            let [low, high] = range(81, 120);
            match backdrop {
                Backdrop::Keep => assert!(matches!(made, Cow::Borrowed(_))),
                Backdrop::Paper => assert_eq!([low, high], [1.0; 2]),
                Backdrop::Ink => assert_eq!([low, high], [0.0; 2]),
                Backdrop::Soften => assert!(low > 0.28 && high < 0.52 && high - low > 0.1, "{low} {high}"),
                Backdrop::Fade => {
                    // Smooth, on paper, and lighter and lighter up to nothing.
                    assert!(low > 0.5 && high == 1.0);
                    let means: Vec<f32> =
                        [81, 84, 87, 90, 93].map(|x| range(x, x + 1)).iter().map(|[low, high]| low + high).collect();
                    assert!(means.windows(2).all(|pair| pair[0] < pair[1]), "{means:?}");
                    assert_eq!(range(97, 120), [1.0; 2]);
                }
            }
        }
    }

    #[test]
    fn the_importance_falls_away_from_the_subject() {
        let (_, mask) = texture_and_mask();
        let one = || Field::constant(120, 120, 0.8).unwrap();
        let made = attended(one(), &mask, 2.0, Backdrop::Paper);
        assert_eq!([made.at(60, 60), made.at(83, 60)], [0.8; 2]);
        assert!((made.at(110, 60) - 0.08).abs() < 1e-6 && made.at(88, 60) < 0.8 && made.at(88, 60) > 0.08);
        assert_eq!(attended(one(), &mask, 2.0, Backdrop::Keep), one());
        // Where it fades, even, and beyond that less of what there is.
        let uneven = field(120, 120, |x, _| if x < 84 { 0.8 } else { 0.4 });
        let faded = attended(uneven, &mask, 0.5, Backdrop::Fade);
        assert!([84, 88, 92].iter().all(|x| (faded.at(*x, 60) - 0.24).abs() < 1e-6) && (faded.at(110, 60) - 0.12).abs() < 1e-6);
    }
}
