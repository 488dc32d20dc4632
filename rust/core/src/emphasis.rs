//! Emphasis: details made strong enough to survive being drawn in black and white.
//!
//! A node is black or white, so a detail shows only if it carries tones across middle grey. Unsharp masking at two scales, the tone
//! plus a multiple of its difference from its blurred self, raises details as fine as the nodes (lines, texture, eyes) and three
//! times as coarse (folds, features of a face). Both scales follow the spacing of the nodes, since what a drawing can show does; so
//! a photo and the same photo at twice the size, drawn with as many nodes, give the same picture.

use rayon::prelude::*;

use crate::field::Field;
use crate::params::Options;

/// Sigma of the fine scale, as a share of the nodes' spacing: a detail this fine is about a node wide.
pub(crate) const FINE: f64 = 0.5;

/// Sigma of the coarse scale, as a share of the nodes' spacing.
const COARSE: f64 = 1.5;

/// The tone plus `sharpen` of the options times what is finer than the nodes' `spacing` (in pixels) and `local_contrast` times what is
/// finer than three of them, clipped to [0, 1]. 0 and 0 change nothing.
pub fn emphasize(tone: &Field, spacing: f64, options: &Options) -> Field {
    let scales = [(options.sharpen, FINE), (options.local_contrast, COARSE)];
    let masks: Vec<(f32, Field)> = scales
        .iter()
        .filter(|(amount, _)| *amount > 0.0)
        .map(|(amount, scale)| (*amount as f32, tone.blurred(scale * spacing)))
        .collect();
    let mut values = tone.values().to_vec();
    values.par_iter_mut().enumerate().for_each(|(i, value)| {
        let added: f32 = masks.iter().map(|(amount, blurred)| amount * (*value - blurred.values()[i])).sum();
        *value = (*value + added).clamp(0.0, 1.0);
    });
    Field::new(tone.width(), tone.height(), values).expect("the size is the input's, and every value was clamped to [0, 1]")
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
