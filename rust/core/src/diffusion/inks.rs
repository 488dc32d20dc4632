//! The diffusion of mixtures over a graph: as that of values, with a part of every label in place of one number.
//!
//! A node's current parts I begin as its mixture; its label is that of the largest, the lowest of equals, and its error what the parts
//! differ from that label alone. Errors go to unlabelled neighbours by the same weights, for which mixtures differ by half the sum of
//! the differences of their parts. The order by priority is that of the largest part over the second.
//!
//! Tonal alpha is the sum of what any two labels of a mixture, a darker and a lighter one, would have as a tone; so every label alone
//! stays clean, as black and white do. Dynamic alpha goes by the mixtures' luma. For black and white all this is
//! [`crate::stages::diffuse`].

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::base::{Control, Result, noise};
use crate::diffusion::parameters::{Diffusion, tonal_pair};
use crate::diffusion::priority::{NODES_BETWEEN_CHECKS, Node, PriorityQueue};
use crate::diffusion::rows::{WARM_UP_IN_BAND, band_size, is_at_the_top};
use crate::diffusion::task::UNLABELLED;
use crate::diffusion::weights::{LocalMean, Open, area_ratio, weigh};
use crate::graph::{Adjacency, check_areas, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixing, Mixture, check_mixtures};
use crate::options::{Alpha, Order};

/// A label for every node, from its mixture of `mixing`'s labels. With `areas`, the areas of the nodes' cells in px^2, errors are
/// weighted by area.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one mixture of these labels, and one area of at least 0, a node; [`crate::Error::Cancelled`].
pub fn diffuse_inks(
    graph: &impl Adjacency,
    mixtures: &[Mixture],
    mixing: &Mixing,
    areas: Option<&[f64]>,
    parameters: &Diffusion,
    control: &Control,
) -> Result<Vec<u8>> {
    check_mixtures(mixtures, graph.len(), mixing.labels())?;
    if let Some(areas) = areas {
        check_one_a_node("areas", areas.len(), graph.len())?;
        check_areas("area", areas)?;
    }
    let lumas = match parameters.alpha {
        Alpha::Dynamic => mixtures.par_iter().map(|mixture| mixing.luma(mixture) as f32).collect(),
        _ => Vec::new(),
    };
    let task = InkTask { graph, mixtures, mixing, lumas, areas, parameters, control };
    match parameters.order {
        Order::Global => task.by_priority(),
        Order::Rows => task.by_number(band_size(mixtures.len())),
    }
}

struct InkTask<'a, G> {
    graph: &'a G,
    mixtures: &'a [Mixture],
    mixing: &'a Mixing,
    /// Of every mixture, where alpha asks for it.
    lumas: Vec<f32>,
    areas: Option<&'a [f64]>,
    parameters: &'a Diffusion,
    control: &'a Control,
}

/// Parts of all labels, those of a drawing first.
type AllParts = [f32; MOST_LABELS];

impl<G: Adjacency> InkTask<'_, G> {
    fn by_number(&self, size: usize) -> Result<Vec<u8>> {
        let mut labels = vec![0; self.mixtures.len()];
        let done = AtomicUsize::new(0);
        labels.par_chunks_mut(size).enumerate().try_for_each(|(band, labels)| {
            self.label_band(band * size, size / WARM_UP_IN_BAND, labels)?;
            let done = done.fetch_add(labels.len(), Ordering::Relaxed) + labels.len();
            self.control.report(done as f32 / self.mixtures.len() as f32)
        })?;
        Ok(labels)
    }

    /// Labels the nodes from `first` on, after up to `warm_up` before them.
    fn label_band(&self, first: usize, warm_up: usize, labels: &mut [u8]) -> Result<()> {
        let &Self { graph, mixtures, mixing, .. } = self;
        let count = mixing.labels();
        let tried = first.saturating_sub(warm_up)..first + labels.len();
        // Of nodes on the way, label by label.
        let mut received = vec![0.0f32; tried.len() * count];
        let mut local_mean = LocalMean::of_hops(self.parameters.hops, self.control);
        let mut open: Vec<Open> = Vec::with_capacity(16);
        let mut current: AllParts = [0.0; MOST_LABELS];
        for number in tried.clone() {
            let mixture = &mixtures[number];
            let own = (number - tried.start) * count;
            let current = &mut current[..count];
            current.copy_from_slice(&received[own..own + count]);
            mixture.shares().for_each(|(label, part)| current[usize::from(label)] += part);
            if first == 0 && is_at_the_top(graph, number) {
                // No row has passed errors on to it: what they might be.
                self.disturb(number, self.share_of(number, &mut local_mean)? as f32, current);
            }
            let label = largest(current);
            if number >= first {
                labels[number - first] = label;
            }
            let Some(alpha) = self.passes_on(number, label, current, &mut local_mean)? else { continue };
            self.find_open(number, |neighbor| neighbor > number, &mut open);
            if open.is_empty() {
                continue;
            }
            let share = alpha / weigh(&mut open, 0.0, self.parameters);
            for other in &open {
                let neighbor = (other.number as usize - tried.start) * count;
                if let Some(received) = received.get_mut(neighbor..neighbor + count) {
                    let weight = self.weight(number, other, share);
                    received.iter_mut().zip(&*current).for_each(|(received, error)| *received += weight * error);
                }
            }
        }
        Ok(())
    }

    fn by_priority(&self) -> Result<Vec<u8>> {
        let &Self { graph, mixtures, mixing, .. } = self;
        let count = mixing.labels();
        let mut currents = vec![0.0f32; mixtures.len() * count];
        for (current, mixture) in currents.chunks_exact_mut(count).zip(mixtures) {
            mixture.shares().for_each(|(label, part)| current[usize::from(label)] += part);
        }
        // The queue's nodes stand for how far the largest part is above the second.
        let mut nodes: Vec<Node> = currents.chunks_exact(count).map(|current| Node::new(ahead(current) as f32)).collect();
        nodes.iter_mut().zip(currents.chunks_exact(count)).for_each(|(node, current)| node.current = ahead(current));
        let mut queue = PriorityQueue::new(&mut nodes);
        let mut labels = vec![0; mixtures.len()];
        let mut local_mean = LocalMean::of_hops(self.parameters.hops, self.control);
        let mut open: Vec<Open> = Vec::with_capacity(16);
        let mut error: AllParts = [0.0; MOST_LABELS];
        let mut labelled = 0;
        while let Some(number) = queue.pop(&mut nodes, graph) {
            if labelled % NODES_BETWEEN_CHECKS == 0 {
                self.control.report(labelled as f32 / nodes.len() as f32)?;
            }
            labelled += 1;
            let error = &mut error[..count];
            error.copy_from_slice(&currents[number * count..(number + 1) * count]);
            let label = largest(error);
            // To the queue any label is as good as another.
            (labels[number], nodes[number].label) = (label, 0);
            let Some(alpha) = self.passes_on(number, label, error, &mut local_mean)? else { continue };
            self.find_open(number, |neighbor| nodes[neighbor].label == UNLABELLED, &mut open);
            if open.is_empty() {
                continue;
            }
            let share = alpha / weigh(&mut open, 0.0, self.parameters);
            for other in &open {
                let (neighbor, weight) = (other.number as usize, self.weight(number, other, share));
                let current = &mut currents[neighbor * count..(neighbor + 1) * count];
                current.iter_mut().zip(&*error).for_each(|(current, error)| *current += weight * error);
                let node = &mut nodes[neighbor];
                node.current = ahead(current);
                queue.update(neighbor, node);
            }
        }
        Ok(labels)
    }

    /// The neighbours of a node that are open, each with how far its mixture is from the node's and its distance.
    fn find_open(&self, number: usize, is_open: impl Fn(usize) -> bool, open: &mut Vec<Open>) {
        open.clear();
        let of_others = Others::new(&self.mixtures[number]);
        self.graph.for_each_neighbor(number, |neighbor, distance| {
            if is_open(neighbor) {
                let start = of_others.difference(&self.mixtures[neighbor]);
                open.push(Open { number: neighbor as u32, start, weight: distance });
            }
        });
    }

    /// Makes current parts the error of the label that they got, and returns the share of it that is passed on, if any.
    fn passes_on(&self, number: usize, label: u8, current: &mut [f32], local_mean: &mut LocalMean<'_>) -> Result<Option<f64>> {
        current[usize::from(label)] -= 1.0;
        let is_off = current.iter().any(|error| *error != 0.0);
        if !is_off || (self.parameters.alpha == Alpha::Dynamic && label != self.mixtures[number].largest()) {
            return Ok(None);
        }
        let alpha = self.share_of(number, local_mean)?;
        Ok((alpha != 0.0).then_some(alpha))
    }

    /// What part of a node's error reaches a neighbour.
    fn weight(&self, number: usize, other: &Open, share: f64) -> f32 {
        let neighbor = other.number as usize;
        (other.weight * share * self.areas.map_or(1.0, |areas| area_ratio(areas[number], areas[neighbor]))) as f32
    }

    /// The share of its error that a node passes on: alpha.
    fn share_of(&self, number: usize, local_mean: &mut LocalMean<'_>) -> Result<f64> {
        let mixture = &self.mixtures[number];
        if self.parameters.alpha != Alpha::Tonal {
            let luma = self.lumas.get(number).map_or(0.0, |luma| f64::from(*luma));
            return self.parameters.share(luma, || local_mean.mean(self.graph, &self.lumas, number));
        }
        let mut sum = 0.0;
        for (a, part_a) in mixture.shares() {
            for (b, part_b) in mixture.shares().filter(|(b, _)| self.mixing.is_darker(a, *b)) {
                debug_assert_ne!(a, b);
                sum += tonal_pair(f64::from(part_a), f64::from(part_b));
            }
        }
        Ok(self.parameters.shading * sum)
    }

    /// Gives the parts of a node errors as another row might have passed them on.
    fn disturb(&self, number: usize, alpha: f32, current: &mut [f32]) {
        let mixture = self.mixtures[number];
        let (first, second) = match mixture.parts[1] > 0.0 {
            true => (mixture.labels[0], mixture.labels[1]),
            false => (mixture.labels[0], u8::from(mixture.labels[0] == 0)),
        };
        let error = 0.5 * alpha * noise(number as u64);
        current[usize::from(first.max(second))] += error;
        current[usize::from(first.min(second))] -= error;
        let more = mixture.labels.into_iter().zip(mixture.parts).skip(2).filter(|(_, part)| *part > 0.0);
        for (k, (label, _)) in more.enumerate() {
            let error = 0.5 * alpha * noise((k as u64 + 1) << 32 | number as u64);
            current[usize::from(label)] += error;
            current[usize::from(first)] -= error;
        }
    }
}

/// The label of the largest part, the lowest of equals.
fn largest(parts: &[f32]) -> u8 {
    let mut best = 0;
    for (label, part) in parts.iter().enumerate() {
        if *part > parts[best] {
            best = label;
        }
    }
    best as u8
}

/// How far the largest part is above the second, as a value of two labels that would be as far from undecided.
fn ahead(parts: &[f32]) -> f64 {
    let (mut first, mut second) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    for part in parts {
        second = second.max(part.min(first));
        first = first.max(*part);
    }
    0.5 + 0.5 * f64::from(first - second)
}

/// A mixture to which others are compared.
struct Others {
    own: AllParts,
}

impl Others {
    fn new(mixture: &Mixture) -> Self {
        let mut own = [0.0; MOST_LABELS];
        mixture.shares().for_each(|(label, part)| own[usize::from(label)] += part);
        Self { own }
    }

    /// Half the sum of the differences of their parts.
    fn difference(&self, other: &Mixture) -> f32 {
        // What of the own parts no label of the other has adds up to 1 less what they share.
        let shared: f32 = other.labels.iter().zip(&other.parts).map(|(label, part)| part.min(self.own[usize::from(*label)])).sum();
        (1.0 - shared).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Error;
    use crate::diffusion::diffuse;
    use crate::graph::Lattice;
    use crate::inks::mixtures;
    use crate::options::{LatticeKind, Options};

    fn random(number: u64) -> f32 {
        0.5 + 0.5 * noise(number)
    }

    fn lattice() -> Lattice {
        Lattice::new(LatticeKind::Hexagonal, 160, 160, 1.0).unwrap()
    }

    fn palette(count: usize) -> Mixing {
        let colours: Vec<[u8; 3]> = (0..count as u64).map(|k| [0, 1, 2].map(|c| (255.0 * random(3 * k + c + 77)) as u8)).collect();
        Mixing::new(&colours, false).unwrap()
    }

    #[test]
    fn black_and_white_get_the_labels_of_values() {
        let graph = lattice();
        let mixing = Mixing::new(&[[0; 3], [255; 3]], false).unwrap();
        let values: Vec<f32> = graph
            .sites()
            .iter()
            .enumerate()
            .map(|(k, [x, y])| (0.5 + 0.5 * ((0.05 * x).sin() * (0.07 * y).cos()) as f32 + 0.03 * noise(k as u64)).clamp(0.0, 1.0))
            .collect();
        let mixed = mixtures(&values.iter().map(|value| [*value; 3]).collect::<Vec<_>>(), &mixing);
        let areas: Vec<f64> = (0..values.len() as u64).map(|k| 0.5 + f64::from(random(k))).collect();
        for order in [Order::Rows, Order::Global] {
            for alpha in [Alpha::Tonal, Alpha::Dynamic, Alpha::Constant(0.7), Alpha::Constant(1.0)] {
                for areas in [None, Some(&areas[..])] {
                    let p = Diffusion { alpha, order, shading: 0.8, ..Diffusion::of_tone(&Options::default()) };
                    let expected = diffuse(&graph, &values, areas, &p, &Control::new()).unwrap();
                    let found = diffuse_inks(&graph, &mixed, &mixing, areas, &p, &Control::new()).unwrap();
                    let other = expected.iter().zip(&found).filter(|(a, b)| a != b).count();
                    assert!(other * 1000 < values.len(), "{order:?} {alpha:?}: {other} of {}", values.len());
                }
            }
        }
    }

    #[test]
    fn labels_come_to_the_parts_of_a_flat_colour() {
        let graph = lattice();
        for count in [2, 3, 6, 15, 64] {
            let mixing = palette(count);
            // A little noise keeps the order of ties from making patterns.
            let noisy = |k: u64| [0.45, 0.5, 0.4].map(|v| v + 0.01 * noise(k));
            let mixed = mixtures(&(0..graph.len() as u64).map(noisy).collect::<Vec<_>>(), &mixing);
            for order in [Order::Rows, Order::Global] {
                let p = Diffusion { alpha: Alpha::Constant(1.0), order, ..Diffusion::of_tone(&Options::default()) };
                let labels = diffuse_inks(&graph, &mixed, &mixing, None, &p, &Control::new()).unwrap();
                for label in 0..count as u8 {
                    let found = labels.iter().filter(|own| **own == label).count() as f32 / labels.len() as f32;
                    let part = mixed.iter().map(|mixture| mixture.part(label)).sum::<f32>() / labels.len() as f32;
                    assert!((found - part).abs() < 0.03, "{count} {order:?} {label}: {found} of {part}");
                }
            }
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let graph = lattice();
        let mixing = palette(7);
        let colours: Vec<[f32; 3]> =
            (0..graph.len() as u64).map(|k| [random(3 * k), random(3 * k + 1), random(3 * k + 2)]).collect();
        let mixed = mixtures(&colours, &mixing);
        for order in [Order::Rows, Order::Global] {
            let p = Diffusion { alpha: Alpha::Constant(1.0), order, ..Diffusion::of_tone(&Options::default()) };
            let [one, three] = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| diffuse_inks(&graph, &mixed, &mixing, None, &p, &Control::new()).unwrap())
            });
            assert!(one == three && (0..7).all(|label| one.contains(&label)));
        }
    }

    #[test]
    fn bad_input_and_cancelling() {
        let (graph, mixing) = (lattice(), palette(3));
        let p = Diffusion::of_tone(&Options::default());
        let run = |mixed: &[Mixture], areas: Option<&[f64]>| diffuse_inks(&graph, mixed, &mixing, areas, &p, &Control::new());
        assert!(run(&[Mixture::pure(0)], None).is_err());
        assert!(run(&vec![Mixture::pure(3); graph.len()], None).is_err());
        assert!(run(&vec![Mixture::default(); graph.len()], None).is_err());
        assert!(run(&vec![Mixture::pure(0); graph.len()], Some(&[1.0])).is_err());
        assert!(run(&vec![Mixture::pure(2); graph.len()], None).unwrap().iter().all(|label| *label == 2));
        let cancelled = Control::new();
        cancelled.cancel();
        let ended = diffuse_inks(&graph, &vec![Mixture::pure(2); graph.len()], &mixing, None, &p, &cancelled);
        assert!(matches!(ended, Err(Error::Cancelled)));
    }
}
