//! Mean tone: the drawing is neither lighter nor darker than the photo.
//!
//! Diffusion with an alpha below 1 drops a part of every error, and emphasis clips, so that a dark photo comes out darker than it is
//! and a light one lighter. The nodes' tones are bent, all by one amount, until the share of the canvas that is white is right.
//! Bending leaves black and white as they are and moves middle tones most (Schlick's bias): adding a constant would put dots in what
//! should stay clean.

use crate::control::Control;
use crate::diffusion::{Diffusion, diffuse};
use crate::error::Result;
use crate::graph::Adjacency;
use crate::params::Carry;

/// Diffusions after which the search gives up; the best one counts.
const MAX_DIFFUSIONS: usize = 5;

/// Where within the tolerance the search aims, as a share of it: the mean moves in jumps, and the less is bent the better.
const AIM: f64 = 0.8;

/// How much lighter a drawing becomes for each unit of bending, on photos; from the second diffusion on it is measured.
const USUAL_SLOPE: f64 = 1.6;

/// Between which the measured slope is trusted.
const SLOPES: [f64; 2] = [0.5, 4.0];

/// The furthest that tones are bent.
const MOST: f64 = 0.45;

/// A tone in [0, 1] bent by `amount` in (-0.5, 0.5): lighter above 0, darker below; 0 and 1 stay. Near 0, tone + 4 amount tone (1 - tone).
pub fn bend(tone: f64, amount: f64) -> f64 {
    let slope = 1.0 / (0.5 + amount) - 2.0;
    tone / (1.0 + slope * (1.0 - tone))
}

/// What the search ends with.
#[derive(Debug, Clone, PartialEq)]
pub struct Toned {
    /// The nodes' tones after bending.
    pub tones: Vec<f32>,
    /// The labels that diffusing them gives.
    pub labels: Vec<u8>,
    /// By how much they were bent: see [`bend`].
    pub amount: f64,
}

/// Diffuses the tones of nodes, bent so that the mean label, weighted by the `areas` of the cells, is within `tolerance` of `mean`.
/// Where no bending brings it there, the nearest found counts. `None` bends nothing.
///
/// # Errors
/// As [`diffuse`].
pub fn diffuse_to_mean(
    graph: &impl Adjacency,
    tones: &[f32],
    areas: &[f64],
    carry: Carry,
    wanted: Option<(f64, f64)>,
    parameters: &Diffusion,
    control: &Control,
) -> Result<Toned> {
    let carried = (carry == Carry::Area).then_some(areas);
    let attempt = |amount: f64| -> Result<Toned> {
        let tones = if amount == 0.0 { tones.to_vec() } else { tones.iter().map(|t| bend(f64::from(*t), amount) as f32).collect() };
        let labels = diffuse(graph, &tones, carried, parameters, control)?;
        Ok(Toned { tones, labels, amount })
    };
    let mut best = attempt(0.0)?;
    let Some((mean, tolerance)) = wanted else { return Ok(best) };
    let total: f64 = areas.iter().sum();
    let miss = |toned: &Toned| {
        let white: f64 = toned.labels.iter().zip(areas).filter(|(label, _)| **label == 1).map(|(_, area)| area).sum();
        white / total - mean
    };
    let mut least = miss(&best);
    let (mut last, mut slope) = ((best.amount, least), USUAL_SLOPE);
    for _ in 1..MAX_DIFFUSIONS {
        if least.abs() <= tolerance {
            break;
        }
        let aim = last.1.clamp(-AIM * tolerance, AIM * tolerance);
        let amount = (last.0 - (last.1 - aim) / slope).clamp(-MOST, MOST);
        if amount == last.0 {
            break;
        }
        let next = attempt(amount)?;
        let missed = miss(&next);
        slope = ((missed - last.1) / (amount - last.0)).clamp(SLOPES[0], SLOPES[1]);
        last = (amount, missed);
        if missed.abs() < least.abs() {
            (best, least) = (next, missed);
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;
    use crate::params::{Alpha, LatticeKind, Options};

    #[test]
    fn bending_keeps_the_ends_and_the_order() {
        for amount in [-MOST, -0.1, 0.0, 0.2, MOST] {
            assert_eq!([bend(0.0, amount), bend(1.0, amount)], [0.0, 1.0]);
            assert!((1..=100).all(|i| bend(f64::from(i) / 100.0, amount) > bend(f64::from(i - 1) / 100.0, amount)));
        }
        assert_eq!(bend(0.3, 0.0), 0.3);
        assert!((bend(0.5, 0.01) - 0.51).abs() < 1e-3);
    }

    #[test]
    fn a_gradient_gets_its_mean() {
        let graph = Lattice::new(LatticeKind::Hexagonal, 60, 60, 1.0).unwrap().to_graph();
        let tones: Vec<f32> = graph.sites.iter().map(|[x, _]| (x / 60.0 * 0.5) as f32).collect();
        let (areas, mean) = (vec![1.0; tones.len()], 0.25);
        let parameters = Diffusion { alpha: Alpha::Constant(0.3), ..Diffusion::of_tone(&Options::default()) };
        let run = |wanted| diffuse_to_mean(&graph, &tones, &areas, Carry::Value, wanted, &parameters, &Control::new()).unwrap();
        let white = |toned: &Toned| toned.labels.iter().map(|l| f64::from(*l)).sum::<f64>() / areas.len() as f64;
        let (plain, bent) = (run(None), run(Some((mean, 0.02))));
        assert!((white(&plain) - mean).abs() > 0.05 && plain.amount == 0.0 && plain.tones == tones);
        assert!((white(&bent) - mean).abs() <= 0.02 && bent.amount > 0.0, "{} {}", white(&bent), bent.amount);
        // A mean that no tone can give: the search ends, and with the nearest.
        assert!(white(&run(Some((1.0, 0.0)))) > white(&bent));
    }
}
