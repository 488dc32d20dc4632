//! Refinement of the labels: crisper where the photo has something to show, more even where it has not.
//!
//! Diffusion labels a node once, by the errors that happen to have reached it, and never looks back. Here every node is asked again,
//! now that its neighbours are labelled: it is white if its own tone, the tone that its neighbours lack and their labels together
//! speak for white,
//!
//! `crispness (tone - 0.5) + mean(tone_j - label_j) + cohesion mean(label_j - 0.5) + shift > 0`,
//!
//! means over the neighbours j. This is iterated conditional modes (Besag 1986) on an energy with a data term, of weight `crispness`,
//! and a smoothness term, of weight `cohesion`, updated in Gauss-Seidel order: each node sees the labels that those before it have
//! just got. The first term draws what the tone says, as a threshold would; the second keeps the tone around the
//! node, as diffusion does, and spaces dots evenly; the third closes holes and straightens contours. A dot by itself, among
//! neighbours of the other label, stays: diffusion has put it there for a tone that reaches beyond the neighbours.
//!
//! The shift is nearly the same for all nodes, and follows the mean: after every sweep over the nodes it moves by what the drawing is too
//! light or too dark. So the picture is as light as the photo, although neither diffusion with an alpha below 1 nor a threshold is.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::base::{Control, Error, Result, noise};
use crate::diffusion::{band_size, check_input};
use crate::graph::{Graph, check_labels, check_one_a_node};
use crate::labels::smooth::STRUCTURED;
use crate::options::Options;

/// The parameters of a refinement; ranges as in [`Options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// Sweeps over the nodes at most; 0 refines nothing.
    pub sweeps: u32,
    /// Data weight: that of a node's own tone.
    pub crispness: f64,
    /// Smoothness weight: that of the neighbours' labels.
    pub cohesion: f64,
    /// The mean that the labels should have, weighted by area, and how far from it they may be; `None`: as it comes.
    pub mean: Option<(f64, f64)>,
}

impl Refinement {
    /// What the options say, for a photo of this mean tone; without one the mean is as it comes.
    pub fn of(options: &Options, mean: Option<f64>) -> Self {
        let Options { refine, crispness, cohesion, tone_tolerance, .. } = *options;
        Self { sweeps: refine, crispness, cohesion, mean: mean.zip(tone_tolerance) }
    }
}

/// How far the shift first moves, as a multiple of what the mean is off.
const FIRST_GAIN: f64 = 1.5;

/// Nodes are shifted by up to this share more or less, each by its own: those of one flat tone would all turn at once, or none.
const UNEVENNESS: f64 = 0.2;

/// And by up to this much whatever the shift: in flat middle grey nodes are exactly undecided.
const LEAST_UNEVENNESS: f64 = 0.005;

/// Sweeps end when no more than this share of the nodes has changed, and the mean is right.
pub(super) const SETTLED: f64 = 1e-3;

/// Refines the labels of nodes by their tones, and returns the shift. `areas` are those of the nodes' cells, in px^2.
///
/// With the grounds of smooth parts, the nodes there keep their labels, and count nothing in the mean.
///
/// Nodes are asked in blocks, the bands of [`crate::stages::diffuse`]: even ones side by side, each node after the other, then odd
/// ones. A block sees the others as they were before. So the result does not depend on threads.
///
/// # Errors
/// [`Error::Input`] if there is not one finite tone, one area of at least 0 and one label, 0 or 1, a node, or the mean is outside
/// [0, 1]; [`Error::Cancelled`].
pub fn refine(
    graph: &Graph,
    tones: &[f32],
    areas: &[f64],
    grounds: Option<&[u8]>,
    labels: &mut [u8],
    parameters: &Refinement,
    control: &Control,
) -> Result<f64> {
    check_input(graph, tones, Some(areas))?;
    check_one_a_node("labels", labels.len(), graph.sites.len())?;
    check_labels(labels)?;
    if let Some(grounds) = grounds {
        check_one_a_node("grounds", grounds.len(), graph.sites.len())?;
    }
    if let Some((mean, _)) = parameters.mean.filter(|(mean, _)| !(0.0..=1.0).contains(mean)) {
        return Err(Error::Input(format!("the mean is {mean}, but it must be between 0 and 1")));
    }
    refine_in_blocks(Parts { graph, tones, areas, grounds }, labels, parameters, band_size(labels.len()), control)
}

/// What is refined.
#[derive(Clone, Copy)]
struct Parts<'a> {
    graph: &'a Graph,
    tones: &'a [f32],
    areas: &'a [f64],
    grounds: Option<&'a [u8]>,
}

/// The areas that count in the mean.
fn structured_areas<'a>(areas: &'a [f64], grounds: Option<&[u8]>) -> Cow<'a, [f64]> {
    let Some(grounds) = grounds else { return Cow::Borrowed(areas) };
    let counting = |(area, ground): (&f64, &u8)| if *ground == STRUCTURED { *area } else { 0.0 };
    areas.par_iter().zip(grounds).map(counting).collect::<Vec<f64>>().into()
}

/// [`refine`] of valid input in blocks of `size` nodes.
fn refine_in_blocks(parts: Parts, labels: &mut [u8], parameters: &Refinement, size: usize, control: &Control) -> Result<f64> {
    if parameters.sweeps == 0 {
        return Ok(0.0);
    }
    let Parts { graph, tones, areas, grounds } = parts;
    let areas = &*structured_areas(areas, grounds);
    // Block by block, so that it can be done side by side.
    let white_area = |labels: &[u8]| -> f64 {
        let of_block = |(labels, areas): (&[u8], &[f64])| -> f64 {
            labels.iter().zip(areas).map(|(label, area)| f64::from(*label) * area).sum()
        };
        labels.par_chunks(size).zip(areas.par_chunks(size)).map(of_block).collect::<Vec<f64>>().into_iter().sum()
    };
    let total = white_area(&vec![1; labels.len()]);
    let (mut shift, mut gain, mut last_over) = (0.0, FIRST_GAIN, 0.0);
    let mut nearest: Option<Nearest> = None;
    let mut nodes: Vec<Node> = (0..labels.len()).into_par_iter().map(|i| Node::new(graph, tones, labels, parameters, i)).collect();
    for sweep in 0..parameters.sweeps {
        control.report(sweep as f32 / parameters.sweeps as f32)?;
        let asking =
            Sweep { graph, grounds, cohesion: parameters.cohesion, shift, unevenness: UNEVENNESS * shift.abs() + LEAST_UNEVENNESS };
        let changed: usize = (0..2).map(|parity| asking.ask_blocks(parity, size, labels, &mut nodes)).sum();
        let over = parameters.mean.filter(|_| total > 0.0).map_or(0.0, |(mean, tolerance)| {
            let off = white_area(labels) / total - mean;
            off - off.clamp(-tolerance, tolerance)
        });
        if over == 0.0 && (changed as f64 <= SETTLED * labels.len() as f64 || sweep + 1 == parameters.sweeps) {
            return Ok(shift);
        }
        if nearest.as_ref().is_none_or(|nearest| over.abs() < nearest.over) {
            nearest = Some(Nearest { over: over.abs(), labels: labels.to_vec(), shift });
        }
        // Smaller and smaller steps find the mean where many nodes have nearly one tone.
        if over * last_over < 0.0 {
            gain /= 2.0;
        }
        shift -= gain * over;
        last_over = over;
    }
    let Some(nearest) = nearest else { return Ok(shift) };
    labels.copy_from_slice(&nearest.labels);
    Ok(nearest.shift)
}

/// The sweep after which the mean was least far off, for tones that have it after none.
struct Nearest {
    over: f64,
    labels: Vec<u8>,
    shift: f64,
}

/// What a node is asked, of which all but the labels and the shift is the same in every sweep.
struct Node {
    /// What speaks for white, were no neighbour white, before the shift.
    alone: f64,
    degree: u32,
    /// How many of its neighbours are white.
    white: u32,
}

impl Node {
    fn new(graph: &Graph, tones: &[f32], labels: &[u8], parameters: &Refinement, number: usize) -> Self {
        let Refinement { crispness, cohesion, .. } = *parameters;
        let row = graph.row(number);
        let own = crispness * (f64::from(tones[number]) - 0.5);
        let around: f64 = row.iter().map(|j| f64::from(tones[*j as usize])).sum();
        Self {
            alone: own + (around - cohesion * 0.5 * row.len() as f64) / row.len().max(1) as f64,
            degree: row.len() as u32,
            white: row.iter().map(|j| u32::from(labels[*j as usize])).sum(),
        }
    }

    /// The label in a sweep, of the node of this number that has `label`.
    fn label(&self, number: usize, label: u8, sweep: &Sweep) -> u8 {
        let &Self { alone, degree, white } = self;
        if degree > 0 && white == u32::from(1 - label) * degree {
            return label;
        }
        // What every white neighbour adds.
        let per_white = (sweep.cohesion - 1.0) / f64::from(degree.max(1));
        let uneven = sweep.unevenness * f64::from(noise(number as u64));
        u8::from(alone + per_white * f64::from(white) + sweep.shift + uneven > 0.0)
    }

    /// A neighbour got another label.
    fn count(&mut self, label: u8) {
        self.white = if label == 1 { self.white + 1 } else { self.white - 1 };
    }
}

/// One sweep.
struct Sweep<'a> {
    graph: &'a Graph,
    grounds: Option<&'a [u8]>,
    cohesion: f64,
    shift: f64,
    /// By how much more or less single nodes are shifted.
    unevenness: f64,
}

impl Sweep<'_> {
    /// Asks the nodes of every other block, from the block `parity` on. Returns how many labels changed.
    fn ask_blocks(&self, parity: usize, size: usize, labels: &mut [u8], nodes: &mut [Node]) -> usize {
        let blocks = labels.par_chunks_mut(size).zip(nodes.par_chunks_mut(size)).enumerate();
        let asked = blocks.filter(|(block, _)| block % 2 == parity);
        let found: Vec<Changed> = asked.map(|(block, (labels, nodes))| self.ask_block(block * size, labels, nodes)).collect();
        for (neighbor, label) in found.iter().flat_map(|changed| &changed.beyond) {
            nodes[*neighbor as usize].count(*label);
        }
        found.iter().map(|changed| changed.count).sum()
    }

    fn ask_block(&self, first: usize, labels: &mut [u8], nodes: &mut [Node]) -> Changed {
        let mut changed = Changed::default();
        for i in 0..labels.len() {
            if self.grounds.is_some_and(|grounds| grounds[first + i] != STRUCTURED) {
                continue;
            }
            let label = nodes[i].label(first + i, labels[i], self);
            if label == labels[i] {
                continue;
            }
            labels[i] = label;
            changed.count += 1;
            for neighbor in self.graph.row(first + i) {
                match nodes.get_mut((*neighbor as usize).wrapping_sub(first)) {
                    Some(node) => node.count(label),
                    None => changed.beyond.push((*neighbor, label)),
                }
            }
        }
        changed
    }
}

/// What one block changed.
#[derive(Default)]
struct Changed {
    /// Labels.
    count: usize,
    /// Neighbours in other blocks, each with the new label of a node beside it.
    beyond: Vec<(u32, u8)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diffusion::{Diffusion, diffuse};
    use crate::graph::Lattice;
    use crate::options::LatticeKind;

    const PLAIN: Refinement = Refinement { sweeps: 20, crispness: 2.0, cohesion: 0.25, mean: None };

    fn lattice(width: usize, height: usize) -> Graph {
        Lattice::new(LatticeKind::Hexagonal, width, height, 1.0).unwrap().to_graph()
    }

    fn white(labels: &[u8]) -> f64 {
        labels.iter().map(|label| f64::from(*label)).sum::<f64>() / labels.len() as f64
    }

    /// Refined from what diffusion gives, in blocks of a size.
    fn refined(graph: &Graph, tones: &[f32], parameters: &Refinement, size: usize) -> (Vec<u8>, f64) {
        let control = Control::new();
        let mut labels = diffuse(graph, tones, None, &Diffusion::of_tone(&Options::default()), &control).unwrap();
        let areas = vec![1.0; tones.len()];
        let shift = refine_in_blocks(Parts { graph, tones, areas: &areas, grounds: None }, &mut labels, parameters, size, &control)
            .unwrap();
        (labels, shift)
    }

    /// The same rule, written as the module's text has it.
    fn wants_white(graph: &Graph, tones: &[f32], labels: &[u8], node: usize, shift: f64) -> bool {
        let mean =
            |of: &dyn Fn(usize) -> f64| graph.row(node).iter().map(|j| of(*j as usize)).sum::<f64>() / graph.row(node).len() as f64;
        let lack = mean(&|j| f64::from(tones[j]) - f64::from(labels[j]));
        let company = mean(&|j| f64::from(labels[j]) - 0.5);
        PLAIN.crispness * (f64::from(tones[node]) - 0.5)
            + lack
            + PLAIN.cohesion * company
            + shift
            + LEAST_UNEVENNESS * f64::from(noise(node as u64))
            > 0.0
    }

    #[test]
    fn settled_nodes_have_the_label_that_the_rule_gives() {
        let graph = lattice(70, 70);
        let tones: Vec<f32> = graph.sites.iter().map(|[x, y]| (0.5 + 0.5 * (x * 0.2).sin() * (y * 0.15).cos()) as f32).collect();
        let (labels, shift) = refined(&graph, &tones, &PLAIN, tones.len());
        let is_lone = |i: usize| graph.row(i).iter().all(|j| labels[*j as usize] != labels[i]);
        let wrong =
            (0..tones.len()).filter(|i| !is_lone(*i) && wants_white(&graph, &tones, &labels, *i, shift) != (labels[*i] == 1));
        assert!(wrong.count() <= 5 && shift == 0.0);
    }

    #[test]
    fn the_mean_is_met_on_gradients_and_on_flat_tones() {
        let graph = lattice(90, 90);
        for (low, high) in [(0.0, 1.0), (0.1, 0.5), (0.6, 0.95), (0.2, 0.2), (0.3, 0.3), (0.45, 0.45), (0.62, 0.62)] {
            let tones: Vec<f32> = graph.sites.iter().map(|[x, _]| (low + (high - low) * x / 90.0) as f32).collect();
            let mean = tones.iter().map(|tone| f64::from(*tone)).sum::<f64>() / tones.len() as f64;
            let (labels, _) = refined(&graph, &tones, &Refinement { mean: Some((mean, 0.02)), ..PLAIN }, 2000);
            // On a lattice flat tones turn by patterns, which have few densities.
            let allowed = if low == high { 0.05 } else { 0.021 };
            assert!((white(&labels) - mean).abs() <= allowed, "{low} to {high}: {} for {mean}", white(&labels));
        }
    }

    #[test]
    fn the_mean_is_that_of_structured_parts_alone() {
        let graph = lattice(90, 90);
        let (areas, control) = (vec![1.0; graph.sites.len()], Control::new());
        let grounds: Vec<u8> = graph.sites.iter().map(|[_, y]| if *y < 45.0 { 1 } else { STRUCTURED }).collect();
        let tone = |([x, _], ground): (&[f64; 2], &u8)| if *ground == STRUCTURED { (x / 90.0) as f32 } else { 1.0 };
        let tones: Vec<f32> = graph.sites.iter().zip(&grounds).map(tone).collect();
        let mut labels = vec![1; tones.len()];
        let parameters = Refinement { mean: Some((0.5, 0.01)), ..PLAIN };
        refine(&graph, &tones, &areas, Some(&grounds), &mut labels, &parameters, &control).unwrap();
        let (structured, others): (Vec<(u8, u8)>, Vec<_>) =
            labels.into_iter().zip(grounds).partition(|(_, ground)| *ground == STRUCTURED);
        assert!(others.iter().all(|(label, _)| *label == 1));
        let share = white(&structured.iter().map(|(label, _)| *label).collect::<Vec<u8>>());
        assert!((share - 0.5).abs() <= 0.01, "{share}");
    }

    #[test]
    fn black_and_white_stay_clean_and_lone_dots_stay() {
        let graph = lattice(40, 40);
        let tones: Vec<f32> = graph.sites.iter().map(|[x, _]| if *x < 20.0 { 0.0 } else { 1.0 }).collect();
        let ideal: Vec<u8> = tones.iter().map(|tone| *tone as u8).collect();
        assert_eq!(refined(&graph, &tones, &PLAIN, tones.len()).0, ideal);
        let dot = Lattice::new(LatticeKind::Hexagonal, 40, 40, 1.0).unwrap().nearest(8.0, 20.0);
        let mut labels = ideal.clone();
        labels[dot] = 1;
        let expected = labels.clone();
        refine(&graph, &tones, &vec![1.0; tones.len()], None, &mut labels, &PLAIN, &Control::new()).unwrap();
        assert_eq!(labels, expected);
    }

    #[test]
    fn no_sweep_changes_nothing_and_threads_do_not_matter() {
        let graph = lattice(160, 160);
        let tones: Vec<f32> = graph.sites.iter().map(|[x, y]| ((x * 12.9898 + y * 78.233).sin() * 0.4 + 0.5) as f32).collect();
        let wanted = Refinement { mean: Some((0.4, 0.01)), ..PLAIN };
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| refined(&graph, &tones, &wanted, 3000))
        };
        assert!(with_threads(1) == with_threads(2) && with_threads(1) == with_threads(5));
        let plain = diffuse(&graph, &tones, None, &Diffusion::of_tone(&Options::default()), &Control::new()).unwrap();
        assert_eq!(refined(&graph, &tones, &Refinement { sweeps: 0, ..wanted }, 3000), (plain, 0.0));
    }
}
