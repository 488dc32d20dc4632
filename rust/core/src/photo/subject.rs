//! The subject of a photo: in, a mask of any size; out, a field on the photo's raster, 1 where the subject is, its edge refined by the
//! photo.
//!
//! A mask is drawn, or guessed, more coarsely than hair is. So its edge is moved to that of the photo by a guided filter (He, Sun and
//! Tang, "Guided Image Filtering", 2010): around every pixel the mask is told as a line of the luma, and what the lines come to is
//! averaged. Where mask and luma do not change together the mask is left as it was, but blurred by as much.
//! What this module does not do: find a subject (Python does), and say what becomes of the rest (see [`super::backdrop`]).

use rayon::prelude::*;

use crate::base::Result;
use crate::photo::field::{BLURRED_ROWS, Field};

/// Where the subject of a photo is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Subject {
    /// On the photo's raster.
    pub(super) mask: Field,
    /// Width and height of the mask as it was given, and by how much it was reduced.
    pub(super) read: [usize; 3],
}

/// Radius of the filter as a share of the photo's size (the root of its area): as far as a mask's edge is off, no further than hair
/// is long.
const RADIUS: f64 = 0.008;

/// Radius in pixels of the mask, where it is the coarser one: its own steps are no edge.
const OF_MASK: f64 = 1.5;

/// Variance of the luma below which there is no edge to go by: noise, and the blocks of a JPEG.
const NOISE: f32 = 1e-3;

/// What is left of the mask below and taken for all of it above its counterpart: far from the edge there is nothing in between.
const FAINT: f32 = 0.2;

impl Subject {
    /// The subject that a mask shows, read as `read` says; `None` where it shows none, being below a half everywhere.
    ///
    /// # Errors
    /// As [`Field::resample`].
    pub(super) fn of(raw: &Field, read: [usize; 3], luma: &Field) -> Result<Option<Self>> {
        let (width, height) = (luma.width(), luma.height());
        if raw.range()[1] < 0.5 {
            return Ok(None);
        }
        let coarseness = (width as f64 / raw.width() as f64).max(height as f64 / raw.height() as f64);
        let radius = (RADIUS * ((width * height) as f64).sqrt()).max(OF_MASK * if coarseness > 1.0 { coarseness } else { 0.0 });
        let resampled = raw.resample(width, height)?;
        let radius = radius.ceil() as usize;
        let mut values = guided(resampled.values(), luma, radius);
        values.par_iter_mut().for_each(|value| *value = ((*value - FAINT) / (1.0 - 2.0 * FAINT)).clamp(0.0, 1.0));
        let mask = Field::of_valid(width, height, values);
        Ok((mask.range()[1] >= 0.5).then_some(Self { mask, read }))
    }
}

/// The mask, filtered by the luma within a radius; not clipped. It takes 24 bytes a pixel at the peak.
fn guided(mask: &[f32], luma: &Field, radius: usize) -> Vec<f32> {
    let (width, guide) = (luma.width(), luma.values());
    let mean = |values: &[f32]| boxed(values, width, radius);
    let of = |value: &(dyn Fn(usize) -> f32 + Sync)| (0..guide.len()).into_par_iter().map(value).collect::<Vec<f32>>();
    let (mean_guide, mean_mask) = (mean(guide), mean(mask));
    let slope = {
        let mean_both = mean(&of(&|i| guide[i] * mask[i]));
        let mean_square = mean(&of(&|i| guide[i] * guide[i]));
        of(&|i| {
            let variance = (mean_square[i] - mean_guide[i] * mean_guide[i]).max(0.0);
            (mean_both[i] - mean_guide[i] * mean_mask[i]) / (variance + NOISE)
        })
    };
    let offset = mean(&of(&|i| mean_mask[i] - slope[i] * mean_guide[i]));
    drop((mean_guide, mean_mask));
    let slope = mean(&slope);
    of(&|i| slope[i] * guide[i] + offset[i])
}

/// The means of squares around every pixel, which reach so many pixels to every side and end at the borders. In bands of rows, each
/// summed anew, so that the result does not depend on the number of threads.
fn boxed(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let height = values.len() / width;
    let mut along = vec![0.0f32; values.len()];
    along.par_chunks_exact_mut(width).zip(values.par_chunks_exact(width)).for_each(|(target, row)| {
        let mut sum: f64 = row[..radius.min(width)].iter().map(|value| f64::from(*value)).sum();
        for (x, mean) in target.iter_mut().enumerate() {
            sum += f64::from(row.get(x + radius).copied().unwrap_or(0.0));
            sum -= if x > radius { f64::from(row[x - radius - 1]) } else { 0.0 };
            *mean = (sum / ((x + radius + 1).min(width) - x.saturating_sub(radius)) as f64) as f32;
        }
    });
    let mut means = vec![0.0f32; values.len()];
    means.par_chunks_mut(BLURRED_ROWS * width).enumerate().for_each(|(band, target)| {
        let row = |y: usize| &along[y * width..][..width];
        let first = band * BLURRED_ROWS;
        let mut sums = vec![0.0f64; width];
        let add = |sums: &mut [f64], y: usize, sign: f64| {
            sums.iter_mut().zip(row(y)).for_each(|(sum, value)| *sum += sign * f64::from(*value));
        };
        (first.saturating_sub(radius)..(first + radius).min(height)).for_each(|y| add(&mut sums, y, 1.0));
        for (y, target) in (first..).zip(target.chunks_exact_mut(width)) {
            if y + radius < height {
                add(&mut sums, y + radius, 1.0);
            }
            if y > first && y > radius {
                add(&mut sums, y - radius - 1, -1.0);
            }
            let count = ((y + radius + 1).min(height) - y.saturating_sub(radius)) as f64;
            target.iter_mut().zip(&sums).for_each(|(mean, sum)| *mean = (sum / count) as f32);
        }
    });
    means
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn means_are_those_of_squares(width in 1usize..30, height in 1usize..150, radius in 1usize..9) {
            let values: Vec<f32> = (0..width * height).map(|i| (i * 37 % 101) as f32).collect();
            let means = boxed(&values, width, radius);
            for (i, mean) in means.iter().enumerate() {
                let (x, y) = (i % width, i / width);
                let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
                let columns = x.saturating_sub(radius)..(x + radius + 1).min(width);
                let count = (rows.len() * columns.len()) as f64;
                let sum: f64 = rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| f64::from(values[y * width + x])).sum();
                prop_assert!((f64::from(*mean) - sum / count).abs() < 1e-4);
            }
        }
    }

    /// A dark disc on light ground, with a mask that is a few pixels too large.
    #[test]
    fn the_edge_of_a_mask_moves_to_that_of_the_photo() {
        let from_middle = |i: usize| ((i % 200) as f64 - 99.5).hypot((i / 200) as f64 - 99.5);
        let of = |value: &dyn Fn(usize) -> f32| Field::new(200, 200, (0..40_000).map(value).collect()).unwrap();
        let luma = of(&|i| if from_middle(i) < 60.0 { 0.1 } else { 0.9 });
        let mask = of(&|i| f32::from(u8::from(from_middle(i) < 61.0)));
        let subject = Subject::of(&mask, [200, 200, 1], &luma).unwrap().unwrap();
        assert_eq!(subject.read, [200, 200, 1]);
        let off =
            |mask: &Field| (0..40_000).map(|i| f64::from((mask.values()[i] - (1.0 - luma.values()[i] - 0.1) / 0.8).abs())).sum();
        let [before, after]: [f64; 2] = [off(&mask), off(&subject.mask)];
        assert!(after < 0.7 * before, "{before} {after}");
        assert!(subject.mask.at(100, 100) == 1.0 && subject.mask.at(5, 5) == 0.0 && subject.mask.at(100, 30) == 0.0);
    }

    #[test]
    fn a_mask_is_resampled_and_one_that_shows_nothing_is_no_subject() {
        let luma = Field::constant(60, 40, 0.5).unwrap();
        let of = |value: f32| Subject::of(&Field::constant(3, 2, value).unwrap(), [3, 2, 1], &luma).unwrap();
        assert!(of(0.0).is_none() && of(0.49).is_none());
        assert_eq!(of(1.0).unwrap().mask, Field::constant(60, 40, 1.0).unwrap());
        let half = Field::new(12, 2, (0..24).map(|i| f32::from(u8::from(i % 12 >= 6))).collect()).unwrap();
        let mask = Subject::of(&half, [12, 2, 1], &luma).unwrap().unwrap().mask;
        assert!(mask.at(2, 20) < 0.3 && mask.at(57, 20) > 0.7);
    }
}
