//! Emphasis: details made strong enough to survive being drawn in black and white.
//!
//! A node is black or white, so a detail shows only if it carries tones across middle grey. Unsharp masking at two scales, the tone
//! plus a multiple of its difference from its blurred self, raises details as fine as the nodes (lines, texture, eyes) and three
//! times as coarse (folds, features of a face). Both scales follow the spacing of the nodes, since what a drawing can show does; so
//! a photo and the same photo at twice the size, drawn with as many nodes, give the same picture.

use rayon::prelude::*;

use crate::options::Options;
use crate::photo::field::{BLURRED_ROWS, Blur, Field};

/// Sigma of the fine scale, as a share of the nodes' spacing: a detail this fine is about a node wide.
pub(crate) const FINE: f64 = 0.5;

/// Sigma of the coarse scale, as a share of the nodes' spacing.
const COARSE: f64 = 1.5;

/// What a tone may differ from its blurred self without showing anything: a level of 8 bits. A step of one level differs by half of it,
/// and the rest is for blocks of JPEG.
const LEVEL: f32 = 1.0 / 255.0;

/// The tone plus `sharpen` of the options times what is finer than the nodes' `spacing` (in pixels) and `local_contrast` times what is
/// finer than three of them, clipped to [0, 1]. 0 and 0 change nothing.
pub fn emphasize(tone: &Field, spacing: f64, options: &Options) -> Field {
    let mut emphasized = vec![0.0; tone.values().len()];
    emphasize_rows(tone, spacing, options, &mut emphasized, None);
    Field::of_valid(tone.width(), tone.height(), emphasized)
}

/// [`emphasize`] and [`off_blurred`], whose fine blurs are one.
pub(crate) fn emphasize_and_off(tone: &Field, spacing: f64, options: &Options) -> (Field, Field) {
    let [mut emphasized, mut off] = [(); 2].map(|()| vec![0.0; tone.values().len()]);
    emphasize_rows(tone, spacing, options, &mut emphasized, Some(&mut off));
    (Field::of_valid(tone.width(), tone.height(), emphasized), Field::of_valid(tone.width(), tone.height(), off))
}

/// How far the tone is from itself blurred at the fine scale, less a level of 8 bits: steps of rounding are no detail.
pub(crate) fn off_blurred(tone: &Field, spacing: f64) -> Field {
    let nothing = Options { sharpen: 0.0, local_contrast: 0.0, ..Options::default() };
    emphasize_and_off(tone, spacing, &nothing).1
}

fn emphasize_rows(tone: &Field, spacing: f64, options: &Options, emphasized: &mut [f32], off: Option<&mut [f32]>) {
    let width = tone.width();
    let [sharpen, local_contrast] = [options.sharpen, options.local_contrast].map(|amount| amount as f32);
    let fine = (sharpen > 0.0 || off.is_some()).then(|| Blur::new(tone, FINE * spacing));
    let coarse = (local_contrast > 0.0).then(|| Blur::new(tone, COARSE * spacing));
    let band = BLURRED_ROWS * width;
    // Without `off` its bands are empty.
    let off = off.map_or_else(
        || (0..tone.height().div_ceil(BLURRED_ROWS)).map(|_| Default::default()).collect(),
        |off| off.chunks_mut(band).collect::<Vec<&mut [f32]>>(),
    );
    let bands = tone.values().par_chunks(band).zip(emphasized.par_chunks_mut(band)).zip(off);
    bands.enumerate().for_each(|(number, ((tone, emphasized), off))| {
        let (mut fine, mut coarse) = (fine.as_ref().map(Blur::rows), coarse.as_ref().map(Blur::rows));
        let mut off = off.chunks_exact_mut(width);
        let rows = tone.chunks_exact(width).zip(emphasized.chunks_exact_mut(width));
        for (y, (tone, emphasized)) in (number * BLURRED_ROWS..).zip(rows) {
            // What is added, before it is.
            emphasized.fill(0.0);
            if let Some(fine) = &mut fine {
                let blurred = fine.row(y);
                if let Some(off) = off.next() {
                    for ((off, t), b) in off.iter_mut().zip(tone).zip(blurred) {
                        let apart = (t - b).abs();
                        *off = (apart - LEVEL).clamp(0.0, 1.0);
                    }
                }
                if sharpen > 0.0 {
                    add_difference(emphasized, sharpen, tone, blurred);
                }
            }
            if let Some(coarse) = &mut coarse {
                add_difference(emphasized, local_contrast, tone, coarse.row(y));
            }
            for (value, t) in emphasized.iter_mut().zip(tone) {
                *value = (t + *value).clamp(0.0, 1.0);
            }
        }
    });
}

fn add_difference(target: &mut [f32], amount: f32, tone: &[f32], blurred: &[f32]) {
    for ((value, t), b) in target.iter_mut().zip(tone).zip(blurred) {
        *value += amount * (t - b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn emphasized(tone: &Field, spacing: f64, sharpen: f64, local_contrast: f64) -> Field {
        emphasize(tone, spacing, &Options { sharpen, local_contrast, ..Options::default() })
    }

    #[test]
    fn an_edge_gains_contrast_and_flat_parts_stay() {
        let step = Field::new(40, 1, (0..40).map(|x| if x < 20 { 0.4 } else { 0.6 }).collect()).unwrap();
        let sharp = emphasized(&step, 2.0, 2.0, 0.0);
        assert!(sharp.at(19, 0) < 0.3 && sharp.at(20, 0) > 0.7);
        assert!((sharp.at(5, 0) - 0.4).abs() < 1e-5);
        // The coarse scale reaches further.
        let coarse = emphasized(&step, 2.0, 0.0, 2.0);
        assert!((sharp.at(14, 0) - 0.4).abs() < 1e-5 && coarse.at(14, 0) < 0.39);
        assert_eq!(emphasized(&step, 2.0, 0.0, 0.0), step);
        assert!(emphasized(&step, 2.0, 100.0, 100.0).values().iter().all(|v| (0.0..=1.0).contains(v)));
    }

    #[test]
    fn scales_follow_the_spacing() {
        let step = |n: usize| Field::new(n, 1, (0..n).map(|x| if x < n / 2 { 0.4 } else { 0.6 }).collect()).unwrap();
        let (small, large) = (emphasized(&step(40), 2.0, 1.0, 1.0), emphasized(&step(160), 8.0, 1.0, 1.0));
        // The pixel centres at twice the spacing from the edge.
        assert!((small.at(16, 0) - 0.5 * (large.at(65, 0) + large.at(66, 0))).abs() < 5e-3);
    }
}
