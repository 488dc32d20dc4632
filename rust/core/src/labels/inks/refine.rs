//! Refinement of the labels of several inks: see [`refine`](crate::stages::refine).
//!
//! Every node takes the label for which its own part, what its neighbours lack of it, and their labels speak most,
//!
//! `crispness part + mean(part_j - is_j) + cohesion mean(is_j) + shift`,
//!
//! where `is_j` is 1 for neighbours j of that label; every label has its shift, which follows its area. Asked are the labels of which
//! the node or a neighbour has a part. A dot by itself of such a label, whose
//! neighbours have one other label, stays.

use rayon::prelude::*;

use crate::base::{Control, Result, noise};
use crate::diffusion::band_size;
use crate::graph::{Graph, check_areas, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixture, check_mixtures};
use crate::labels::inks::check_labels_below;
use crate::labels::inks::grounds::NO_GROUND;
use crate::labels::refine::{FIRST_GAIN, LEAST_UNEVENNESS, Refinement, SETTLED, UNEVENNESS};

/// The most that a label is shifted.
const MOST_SHIFT: f64 = 2.0;

/// A share of the area, for labels that should have hardly any.
const LEAST_SHARE: f64 = 0.02;

/// Refines the labels of nodes by their mixtures. `areas` are those of the nodes' cells in px^2; nodes with a ground keep their labels,
/// and count nothing. The area of every label follows its share in `wanted`, mixtures of the nodes too, within the tolerance in
/// `parameters.mean`, which is smaller for labels of less than half: its mean is not looked at. Without it, areas are as they come.
///
/// Nodes are asked in blocks, as those of black and white are; so the result does not depend on threads.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one of each a node; [`crate::Error::Cancelled`].
pub fn refine_inks(
    graph: &Graph,
    [mixtures, wanted]: [&[Mixture]; 2],
    areas: &[f64],
    grounds: &[u8],
    labels: &mut [u8],
    parameters: &Refinement,
    control: &Control,
) -> Result<()> {
    let count = graph.sites.len();
    check_mixtures(mixtures, count, MOST_LABELS)?;
    check_mixtures(wanted, count, MOST_LABELS)?;
    check_one_a_node("areas", areas.len(), count)?;
    check_areas("area", areas)?;
    check_labels_below("grounds", grounds, MOST_LABELS, count)?;
    check_labels_below("labels", labels, MOST_LABELS, count)?;
    if parameters.sweeps == 0 {
        return Ok(());
    }
    let structured: Vec<u32> = (0..count as u32).into_par_iter().filter(|node| grounds[*node as usize] == NO_GROUND).collect();
    let size = band_size(count);
    let asked = Asked::of(graph, mixtures, &structured, parameters);
    let targets = shares(&structured, areas, |node| wanted[node].shares().map(|(label, part)| (label, f64::from(part))));
    let tolerance = parameters.mean.map(|(_, tolerance)| tolerance);
    let mut shifts = Shifts { shifts: [0.0; MOST_LABELS], gains: [FIRST_GAIN; MOST_LABELS], last_over: [0.0; MOST_LABELS] };
    let mut nearest: Option<(f64, Vec<u8>)> = None;
    for sweep in 0..parameters.sweeps {
        control.report(sweep as f32 / parameters.sweeps as f32)?;
        let asking = Sweep { graph, asked: &asked, structured: &structured, cohesion: parameters.cohesion, shifts: &shifts.shifts };
        let changed: usize = (0..2).map(|parity| asking.ask_blocks(parity, size, labels)).sum();
        let has_settled = changed as f64 <= SETTLED * count as f64;
        let Some(tolerance) = tolerance else {
            if has_settled {
                break;
            }
            continue;
        };
        let found = shares(&structured, areas, |node| std::iter::once((labels[node], 1.0)));
        let over: [f64; MOST_LABELS] = std::array::from_fn(|label| {
            let (off, allowed) = (found[label] - targets[label], tolerance * (2.0 * targets[label]).min(1.0));
            off - off.clamp(-allowed, allowed)
        });
        let total: f64 = over.iter().map(|over| over.abs()).sum();
        if total == 0.0 && has_settled {
            return Ok(());
        }
        if nearest.as_ref().is_none_or(|(least, _)| total <= *least) {
            nearest = Some((total, labels.to_vec()));
        }
        shifts.follow(&over, &targets);
    }
    if let Some((_, nearest)) = nearest {
        labels.copy_from_slice(&nearest);
    }
    Ok(())
}

/// Every label's share of the structured area.
fn shares<I: Iterator<Item = (u8, f64)>>(structured: &[u32], areas: &[f64], of: impl Fn(usize) -> I + Sync) -> [f64; MOST_LABELS] {
    let part = |nodes: &[u32]| {
        let mut sums = [0.0; MOST_LABELS];
        for node in nodes.iter().map(|node| *node as usize) {
            of(node).for_each(|(label, part)| sums[usize::from(label)] += areas[node] * part);
        }
        sums
    };
    // Chunk by chunk, and then in their order: what floats add up to must not depend on threads.
    let parts: Vec<_> = structured.par_chunks(1 << 13).map(part).collect();
    let sums = parts.iter().fold([0.0; MOST_LABELS], |sums: [f64; MOST_LABELS], part| std::array::from_fn(|k| sums[k] + part[k]));
    let total: f64 = sums.iter().sum();
    sums.map(|sum| if total > 0.0 { sum / total } else { 0.0 })
}

struct Shifts {
    shifts: [f64; MOST_LABELS],
    gains: [f64; MOST_LABELS],
    last_over: [f64; MOST_LABELS],
}

impl Shifts {
    /// Moves the shifts by what labels have too much or too little.
    fn follow(&mut self, over: &[f64; MOST_LABELS], targets: &[f64; MOST_LABELS]) {
        for label in 0..MOST_LABELS {
            // Smaller and smaller steps find the area where many nodes have nearly one mixture.
            if over[label] * self.last_over[label] < 0.0 {
                self.gains[label] /= 2.0;
            }
            // Fewer nodes are undecided about a rare label.
            let step = self.gains[label] * over[label] / (2.0 * targets[label]).clamp(LEAST_SHARE, 1.0);
            self.shifts[label] = (self.shifts[label] - step).clamp(-MOST_SHIFT, MOST_SHIFT);
            self.last_over[label] = over[label];
        }
    }
}

/// What speaks for the labels that nodes are asked about, were no neighbour of them, before the shifts.
struct Asked {
    /// Where every structured node's begin, and one end more.
    offsets: Vec<usize>,
    alone: Vec<(u8, f32)>,
}

impl Asked {
    fn of(graph: &Graph, mixtures: &[Mixture], structured: &[u32], parameters: &Refinement) -> Self {
        let of_node = |node: usize, alone: &mut Vec<(u8, f32)>| {
            let (row, first) = (graph.row(node), alone.len());
            let mut add = |mixture: &Mixture, weight: f32| {
                for (label, part) in mixture.shares() {
                    match alone[first..].iter_mut().find(|(own, _)| *own == label) {
                        Some((_, sum)) => *sum += weight * part,
                        None => alone.push((label, weight * part)),
                    }
                }
            };
            add(&mixtures[node], parameters.crispness as f32);
            let weight = 1.0 / row.len().max(1) as f32;
            row.iter().for_each(|other| add(&mixtures[*other as usize], weight));
            alone[first..].sort_unstable_by_key(|(label, _)| *label);
            alone.len() - first
        };
        let of_chunk = |nodes: &[u32]| {
            let mut alone = Vec::with_capacity(4 * nodes.len());
            let counts: Vec<usize> = nodes.iter().map(|node| of_node(*node as usize, &mut alone)).collect();
            (counts, alone)
        };
        let (counts, alone): (Vec<_>, Vec<_>) = structured.par_chunks(1 << 13).map(of_chunk).unzip();
        let mut offsets = vec![0];
        for count in counts.into_iter().flatten() {
            offsets.push(offsets[offsets.len() - 1] + count);
        }
        Self { offsets, alone: alone.concat() }
    }

    /// Those of the structured node of this place among them.
    fn of_node(&self, k: usize) -> &[(u8, f32)] {
        &self.alone[self.offsets[k]..self.offsets[k + 1]]
    }
}

/// One sweep.
struct Sweep<'a> {
    graph: &'a Graph,
    asked: &'a Asked,
    structured: &'a [u32],
    cohesion: f64,
    shifts: &'a [f64; MOST_LABELS],
}

impl Sweep<'_> {
    /// Asks the nodes of every other block, from the block `parity` on. Returns how many labels changed.
    fn ask_blocks(&self, parity: usize, size: usize, labels: &mut [u8]) -> usize {
        let before = labels.to_vec();
        let blocks = labels.par_chunks_mut(size).enumerate().filter(|(block, _)| block % 2 == parity);
        blocks.map(|(block, labels)| self.ask_block(block * size, labels, &before)).sum()
    }

    fn ask_block(&self, first: usize, labels: &mut [u8], before: &[u8]) -> usize {
        let [begin, end] =
            [first, first + labels.len()].map(|node| self.structured.partition_point(|other| (*other as usize) < node));
        let (mut changed, mut counts) = (0, [0u8; MOST_LABELS]);
        for k in begin..end {
            let node = self.structured[k] as usize;
            let row = self.graph.row(node);
            let label_of = |other: u32| labels.get((other as usize).wrapping_sub(first)).copied().unwrap_or(before[other as usize]);
            row.iter()
                .for_each(|other| counts[usize::from(label_of(*other))] = counts[usize::from(label_of(*other))].saturating_add(1));
            let own = labels[node - first];
            let is_lone = row.first().is_some_and(|other| {
                let around = label_of(*other);
                let is_asked = || self.asked.of_node(k).iter().any(|(label, _)| *label == own);
                around != own && usize::from(counts[usize::from(around)]) == row.len() && is_asked()
            });
            let label = if is_lone { own } else { self.label(node, k, &counts, row.len(), own) };
            row.iter().for_each(|other| counts[usize::from(label_of(*other))] = 0);
            changed += usize::from(label != own);
            labels[node - first] = label;
        }
        changed
    }

    fn label(&self, node: usize, k: usize, counts: &[u8; MOST_LABELS], degree: usize, own: u8) -> u8 {
        // What every neighbour of the label adds.
        let per_neighbor = (self.cohesion - 1.0) / degree.max(1) as f64;
        let mut best = (f64::NEG_INFINITY, own);
        for (label, alone) in self.asked.of_node(k) {
            let number = usize::from(*label);
            let shift = self.shifts[number];
            let unevenness = UNEVENNESS * shift.abs() + LEAST_UNEVENNESS;
            let uneven = unevenness * f64::from(noise((number as u64) << 32 | node as u64));
            let score = f64::from(*alone) + per_neighbor * f64::from(counts[number]) + shift + uneven;
            if score > best.0 {
                best = (score, *label);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diffusion::{Diffusion, diffuse_inks};
    use crate::graph::Lattice;
    use crate::inks::{Mixing, mixtures};
    use crate::options::{LatticeKind, Options};

    fn refined(colour: impl Fn(&[f64; 2]) -> [f32; 3], mixing: &Mixing, tolerance: f64) -> (Vec<Mixture>, Vec<u8>) {
        let graph = Lattice::new(LatticeKind::Hexagonal, 120, 120, 1.0).unwrap().to_graph();
        let (options, control) = (Options::default(), Control::new());
        let mixed = mixtures(&graph.sites.iter().map(colour).collect::<Vec<_>>(), mixing);
        let mut labels = diffuse_inks(&graph, &mixed, mixing, None, &Diffusion::of_tone(&options), &control).unwrap();
        let parameters = Refinement { sweeps: 20, mean: Some((0.5, tolerance)), ..Refinement::of(&options, None) };
        let grounds = vec![NO_GROUND; mixed.len()];
        refine_inks(&graph, [&mixed, &mixed], &vec![1.0; mixed.len()], &grounds, &mut labels, &parameters, &control).unwrap();
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
            let (mixed, labels) = refined(colour, &mixing, 0.01);
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
        let (mixed, labels) = refined(colour, &mixing, 0.01);
        assert!(mixed.iter().zip(&labels).all(|(mixture, label)| mixture.largest() == *label));
        let graph = Lattice::new(LatticeKind::Square, 10, 10, 1.0).unwrap().to_graph();
        let count = graph.sites.len();
        let (mixed, mut labels) = (vec![Mixture::pure(1); count], vec![2; count]);
        let parameters = Refinement::of(&Options::default(), None);
        let run = |grounds: &[u8], labels: &mut Vec<u8>| {
            refine_inks(&graph, [&mixed, &mixed], &vec![1.0; count], grounds, labels, &parameters, &Control::new())
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
            pool.install(|| refined(colour, &mixing, 0.01))
        });
        assert!(one == three);
    }
}
