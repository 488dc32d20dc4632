//! Refinement of the labels of several inks, by colour.
//!
//! Diffusion labels a node once, by the errors that happen to have reached it. Here every node is asked again, among the labels of its
//! mixture, for what brings the colours around nearest to the photo's. An error e is a label's colour less the mixture's, as far as it
//! is seen; the least is looked for of
//!
//! `sum area (|mean(e_j)|^2 + crispness |e|^2 + cohesion mean |colour - colour_j|^2)`,
//!
//! with means over a node and its neighbours j, the first by area, and weights in proportion to those. So two colours side by side
//! that make up for each other are as good as none that is off, as in direct binary search (Analoui and Allebach 1992); crispness speaks
//! for the ink that is nearest, and cohesion for larger shapes.

use rayon::prelude::*;

use crate::base::{Control, Result};
use crate::diffusion::band_size;
use crate::graph::{Graph, check_areas, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixing, Mixture, check_mixtures};
use crate::labels::inks::check_labels_below;
use crate::labels::inks::grounds::NO_GROUND;
use crate::labels::refine::{Refinement, SETTLED};

/// What crispness and cohesion count here. More leaves fewer mixtures: colours that are farther off, in larger shapes.
const CRISPNESS: f32 = 0.05;
const COHESION: f32 = 3.0;

/// What red and blue count here, beside the mixtures: less leaves specks of colour where the lightness is right.
const CHROMA: f32 = 1.6;

/// Nodes that one thread looks at, at least.
const LEAST_PART: usize = 1 << 12;

type Colour = [f32; 3];

/// Refines the labels of nodes by their mixtures. `areas` are those of the nodes' cells in px^2; nodes with a ground keep their labels,
/// and are not off.
///
/// Nodes are asked in blocks, as those of black and white are; so the result does not depend on threads.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one of each a node; [`crate::Error::Cancelled`].
pub fn refine_inks(
    graph: &Graph,
    (mixtures, mixing): (&[Mixture], &Mixing),
    areas: &[f64],
    grounds: &[u8],
    labels: &mut [u8],
    parameters: &Refinement,
    control: &Control,
) -> Result<()> {
    let count = graph.sites.len();
    check_mixtures(mixtures, count, mixing.labels())?;
    check_one_a_node("areas", areas.len(), count)?;
    check_areas("area", areas)?;
    check_labels_below("grounds", grounds, MOST_LABELS, count)?;
    check_labels_below("labels", labels, mixing.labels(), count)?;
    let colours: Vec<Colour> = mixing
        .places()
        .iter()
        .map(|place| place.map(|v| v as f32))
        .map(|[luma, red, blue]| [luma, CHROMA * red, CHROMA * blue])
        .collect();
    let mixed =
        |mixture: &Mixture| mixture.shares().fold([0.0; 3], |sum, (label, part)| plus(sum, part, colours[usize::from(label)]));
    let whole = |node: usize| areas[node] + graph.row(node).iter().map(|other| areas[*other as usize]).sum::<f64>();
    let asking = Asking {
        graph,
        mixtures,
        grounds,
        wanted: mixtures.par_iter().with_min_len(LEAST_PART).map(mixed).collect(),
        areas: areas.iter().map(|area| *area as f32).collect(),
        wholes: (0..count).into_par_iter().with_min_len(LEAST_PART).map(|node| whole(node).max(f64::MIN_POSITIVE) as f32).collect(),
        colours,
        crispness: CRISPNESS * parameters.crispness as f32,
        cohesion: COHESION * parameters.cohesion as f32,
    };
    let size = band_size(count);
    for sweep in 0..parameters.sweeps {
        control.report(sweep as f32 / parameters.sweeps as f32)?;
        let changed: usize = (0..2).map(|parity| asking.ask_blocks(parity, size, labels)).sum();
        if changed as f64 <= SETTLED * count as f64 {
            break;
        }
    }
    Ok(())
}

struct Asking<'a> {
    graph: &'a Graph,
    mixtures: &'a [Mixture],
    grounds: &'a [u8],
    /// The mixtures' colours.
    wanted: Vec<Colour>,
    areas: Vec<f32>,
    /// Areas of nodes with their neighbours.
    wholes: Vec<f32>,
    /// Those of the labels.
    colours: Vec<Colour>,
    crispness: f32,
    cohesion: f32,
}

impl Asking<'_> {
    /// Asks the nodes of every other block, from the block `parity` on. Returns how many labels changed.
    fn ask_blocks(&self, parity: usize, size: usize, labels: &mut [u8]) -> usize {
        let before = labels.to_vec();
        let off = |node: usize| self.off(node, before[node]);
        let of = |node: usize| {
            let of_neighbors = self.graph.row(node).iter().map(|other| *other as usize);
            let sum = of_neighbors.chain([node]).fold([0.0; 3], |sum, other| plus(sum, self.areas[other], off(other)));
            sum.map(|sum| sum / self.wholes[node])
        };
        let means: Vec<Colour> = (0..labels.len()).into_par_iter().with_min_len(LEAST_PART).map(of).collect();
        let blocks = labels.par_chunks_mut(size).enumerate().filter(|(block, _)| block % 2 == parity);
        blocks.map(|(block, labels)| self.ask_block(block * size, labels, &before, &means)).sum()
    }

    /// How far the colour of a node is off with a label.
    fn off(&self, node: usize, label: u8) -> Colour {
        if self.grounds[node] == NO_GROUND { plus(self.colours[usize::from(label)], -1.0, self.wanted[node]) } else { [0.0; 3] }
    }

    fn ask_block(&self, first: usize, labels: &mut [u8], before: &[u8], means: &[Colour]) -> usize {
        let mut own_means = means[first..first + labels.len()].to_vec();
        let mut changed = 0;
        for node in first..first + labels.len() {
            let mixture = &self.mixtures[node];
            let own = labels[node - first];
            if self.grounds[node] != NO_GROUND || (mixture.parts[1] == 0.0 && mixture.largest() == own) {
                continue;
            }
            let row = self.graph.row(node);
            let inside = |other: usize| other.wrapping_sub(first);
            let (mut around, mut lightness) = ([0.0; 3], 0.0);
            let mut beside = [0.0; 3];
            for other in row.iter().map(|other| *other as usize).chain([node]) {
                around = plus(around, 1.0, *own_means.get(inside(other)).unwrap_or(&means[other]));
                lightness += 1.0 / self.wholes[other];
                if other != node {
                    let label = *labels.get(inside(other)).unwrap_or(&before[other]);
                    beside = plus(beside, 1.0 / row.len() as f32, self.colours[usize::from(label)]);
                }
            }
            let own_off = self.off(node, own);
            let weight = lightness * self.areas[node];
            let mut best = (f32::INFINITY, own);
            for label in mixture.shares().map(|(label, _)| label) {
                let off = self.off(node, label);
                let change = plus(off, -1.0, own_off);
                let colour = self.colours[usize::from(label)];
                let score = 2.0 * dot(change, around)
                    + weight * dot(change, change)
                    + self.crispness * dot(off, off)
                    + self.cohesion * (dot(colour, colour) - 2.0 * dot(colour, beside));
                if score < best.0 {
                    best = (score, label);
                }
            }
            if best.1 != own {
                changed += 1;
                labels[node - first] = best.1;
                let change = plus(self.off(node, best.1), -1.0, own_off);
                for other in row.iter().map(|other| *other as usize).chain([node]) {
                    if let Some(mean) = own_means.get_mut(inside(other)) {
                        *mean = plus(*mean, self.areas[node] / self.wholes[other], change);
                    }
                }
            }
        }
        changed
    }
}

fn plus(a: Colour, times: f32, b: Colour) -> Colour {
    [a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]]
}

fn dot(a: Colour, b: Colour) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::noise;
    use crate::diffusion::{Diffusion, diffuse_inks};
    use crate::graph::Lattice;
    use crate::inks::{Mixing, mixtures};
    use crate::options::{LatticeKind, Options};

    fn refined(colour: impl Fn(&[f64; 2]) -> [f32; 3], mixing: &Mixing) -> (Vec<Mixture>, Vec<u8>) {
        let graph = Lattice::new(LatticeKind::Hexagonal, 120, 120, 1.0).unwrap().to_graph();
        let (options, control) = (Options::default(), Control::new());
        let mixed = mixtures(&graph.sites.iter().map(colour).collect::<Vec<_>>(), mixing);
        let mut labels = diffuse_inks(&graph, &mixed, mixing, None, &Diffusion::of_tone(&options), &control).unwrap();
        let parameters = Refinement { sweeps: 20, ..Refinement::of(&options, None) };
        let grounds = vec![NO_GROUND; mixed.len()];
        refine_inks(&graph, (&mixed, mixing), &vec![1.0; mixed.len()], &grounds, &mut labels, &parameters, &control).unwrap();
        (mixed, labels)
    }

    fn palette(count: u64) -> Mixing {
        let value = |k: u64| (127.5 + 127.4 * noise(k)) as u8;
        Mixing::new(&(0..count).map(|k| [3 * k + 7, 3 * k + 8, 3 * k + 9].map(value)).collect::<Vec<_>>(), false).unwrap()
    }

    #[test]
    fn areas_follow_the_mixtures_on_gradients() {
        for count in [2, 3, 6, 15, 64] {
            let mixing = palette(count);
            let colour = |[x, y]: &[f64; 2]| [x / 120.0, y / 120.0, 0.5 + 0.4 * (0.1 * x).sin()].map(|v| v as f32);
            let (mixed, labels) = refined(colour, &mixing);
            for label in 0..count as u8 {
                let found = labels.iter().filter(|own| **own == label).count() as f64 / labels.len() as f64;
                let part = mixed.iter().map(|mixture| f64::from(mixture.part(label))).sum::<f64>() / labels.len() as f64;
                assert!((found - part).abs() < 0.03, "{count} {label}: {found} of {part}");
            }
        }
    }

    #[test]
    fn what_is_of_one_ink_stays_so_and_grounds_keep_their_labels() {
        let mixing = Mixing::new(&[[0; 3], [255, 0, 0], [0, 0, 255], [255; 3]], false).unwrap();
        let colour = |[x, _]: &[f64; 2]| if *x < 60.0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let (mixed, labels) = refined(colour, &mixing);
        assert!(mixed.iter().zip(&labels).all(|(mixture, label)| mixture.largest() == *label));
        let graph = Lattice::new(LatticeKind::Square, 10, 10, 1.0).unwrap().to_graph();
        let count = graph.sites.len();
        let (mixed, mut labels) = (vec![Mixture::pure(1); count], vec![2; count]);
        let parameters = Refinement::of(&Options::default(), None);
        let run = |grounds: &[u8], labels: &mut Vec<u8>| {
            refine_inks(&graph, (&mixed, &mixing), &vec![1.0; count], grounds, labels, &parameters, &Control::new())
        };
        run(&vec![2; count], &mut labels).unwrap();
        assert_eq!(labels, vec![2; count]);
        run(&vec![NO_GROUND; count], &mut labels).unwrap();
        assert_eq!(labels, vec![1; count]);
        assert!(run(&[64], &mut labels).is_err());
    }

    #[test]
    fn threads_do_not_matter() {
        let mixing = palette(7);
        let colour = |[x, y]: &[f64; 2]| [0.5 + 0.5 * (12.9 * x + 78.2 * y).sin(), x / 120.0, y / 120.0].map(|v| v as f32);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| refined(colour, &mixing))
        });
        assert!(one == three);
    }
}
