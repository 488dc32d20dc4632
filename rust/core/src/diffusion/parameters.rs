//! The parameters of a diffusion, and the share of its error that a node passes on.

use crate::base::Result;
use crate::options::{Alpha, Options, Order, Published};

/// The parameters of one diffusion; ranges as in [`Options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffusion {
    /// Weight of the difference of starting values.
    pub k1: f64,
    /// Weight of the distance, per pixel.
    pub k2: f64,
    /// Tonal alpha in middle tones.
    pub shading: f64,
    /// Dynamic alpha where there is no detail.
    pub base: f64,
    /// Growth of dynamic alpha with `|I0 - A|`: the paper's lambda.
    pub detail_gain: f64,
    /// Radius of the local mean A, in hops along edges, at least 1.
    pub hops: u32,
    /// Share of the error that is passed on.
    pub alpha: Alpha,
    /// In which order nodes are labelled.
    pub order: Order,
}

impl Diffusion {
    /// The diffusion of importance over the lattice.
    pub fn of_importance(options: &Options) -> Self {
        let Published { importance_alpha: alpha, importance_order: order, .. } = options.published;
        Self { alpha, order, ..Self::of_tone(options) }
    }

    /// The diffusion of tone over the second graph.
    pub fn of_tone(options: &Options) -> Self {
        let Published { k1, k2, base, detail_gain, hops, alpha, order, .. } = options.published;
        Self { k1, k2, shading: options.shading, base, detail_gain, hops, alpha, order }
    }

    /// Whether a node of the starting value `start` that got this label may pass an error on.
    pub(crate) fn passes_on(&self, start: f64, label: u8) -> bool {
        self.alpha != Alpha::Dynamic || (label == 1) == (start >= 0.5)
    }

    /// The share of its error that it passes on if so: alpha. `mean` is the local mean around it.
    ///
    /// # Errors
    /// Those of `mean`.
    pub(crate) fn share(&self, start: f64, mean: impl FnOnce() -> Result<f64>) -> Result<f64> {
        Ok(match self.alpha {
            Alpha::Constant(alpha) => alpha,
            Alpha::Tonal => self.shading * tonal_share(start),
            Alpha::Dynamic => self.base + self.detail_gain * (start - mean()?).abs(),
        })
    }
}

/// The share of `shading` that [`Alpha::Tonal`] passes on at a value I0: t^1.5 (1 - t)^2 scaled to 1 at its highest, t = 3/7, and 0 at
/// black and white, which stay clean. Dark tones get more than light ones as far from 0.5: white dots in the dark are what shape is
/// seen by there, whereas in the light paper alone passes for the tone.
pub fn tonal_share(value: f64) -> f64 {
    let t = value.clamp(0.0, 1.0);
    let highest = (3.0 / 7.0) * f64::sqrt(3.0 / 7.0) * (4.0 / 7.0) * (4.0 / 7.0);
    t * t.sqrt() * (1.0 - t) * (1.0 - t) / highest
}

/// The same for two of the labels that a mixture has, of which it may have more: the parts of a darker and of a lighter one.
pub(super) fn tonal_pair(darker: f64, lighter: f64) -> f64 {
    let highest = (3.0 / 7.0) * f64::sqrt(3.0 / 7.0) * (4.0 / 7.0) * (4.0 / 7.0);
    lighter * lighter.sqrt() * darker * darker / highest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tonal_alpha_is_highest_in_dark_middle_tones_and_nothing_at_black_and_white() {
        assert_eq!([0.0, 1.0, -0.5, 1.5].map(tonal_share), [0.0; 4]);
        assert!((tonal_share(3.0 / 7.0) - 1.0).abs() < 1e-12);
        for value in [0.1, 0.3, 0.42, 0.44, 0.6, 0.9] {
            assert!(tonal_share(value) < 1.0 && tonal_share(0.5 - value / 2.0) > tonal_share(0.5 + value / 2.0), "{value}");
        }
    }
}
