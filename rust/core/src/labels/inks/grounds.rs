//! Smooth parts of drawings of several inks, and their grounds: see [`grounds`](crate::stages::grounds).

use crate::base::{Error, Result};
use crate::graph::{Graph, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixing, Mixture, axes, check_mixtures};
use crate::labels::smooth::{COHESION, COHESION_SWEEPS, ROUGHNESS, STEP, for_nodes, mean_around, off_plane, without_single_nodes};

/// The ground of a node in a part with structure: none.
pub const NO_GROUND: u8 = u8::MAX;

/// The part that a ground has at least where dots of one other label lie on it, about half being what they cover, and where dots of more
/// do. With less than that, grounds take the place of each other in slow changes of colour, and their borders are seen.
const LEAST_GROUND: f32 = 0.34;
const LEAST_OF_MORE: f32 = 0.6;

/// How fast it grows with the parts of those.
const GROWTH: f32 = 3.0;

/// Labels that are remembered of the mean mixture around a node.
const REMEMBERED: usize = 8;

/// The mean mixture around a node: its labels of the largest parts, in the order of their numbers.
#[derive(Clone, Copy, Default)]
struct Around {
    labels: [u8; REMEMBERED],
    parts: [f32; REMEMBERED],
}

impl Around {
    fn of(mixture: &Mixture) -> Self {
        let mut around = Self::default();
        around.labels[..4].copy_from_slice(&mixture.labels);
        around.parts[..4].copy_from_slice(&mixture.parts);
        around
    }

    fn shares(&self) -> impl Iterator<Item = (u8, f32)> + '_ {
        self.labels.iter().copied().zip(self.parts).filter(|(_, part)| *part > 0.0)
    }

    fn part(&self, label: u8) -> f32 {
        self.shares().filter(|(own, _)| *own == label).map(|(_, part)| part).sum()
    }

    /// The mean over a node and its neighbours.
    fn mean(graph: &Graph, arounds: &[Self], node: usize) -> Self {
        let row = graph.row(node);
        // Sums by label, and a bit for every label that has one.
        let (mut sums, mut found) = ([0.0; MOST_LABELS], 0u64);
        for other in row.iter().map(|other| *other as usize).chain([node]) {
            for (label, part) in arounds[other].shares() {
                sums[usize::from(label)] += part;
                found |= 1 << label;
            }
        }
        let labels = |found: u64| (0..MOST_LABELS).filter(move |label| found >> label & 1 == 1);
        while found.count_ones() as usize > REMEMBERED {
            let least = labels(found).min_by(|a, b| sums[*a].total_cmp(&sums[*b]).then(b.cmp(a)));
            found &= !least.map_or(found, |label| 1 << label);
        }
        let mut mean = Self::default();
        for k in 0..found.count_ones() as usize {
            let label = found.trailing_zeros();
            found &= found - 1;
            (mean.labels[k], mean.parts[k]) = (label as u8, sums[label as usize] / (row.len() + 1) as f32);
        }
        mean
    }

    /// The label for which its part and what else is told of it speak most, the lowest of equals.
    fn best(&self, more: impl Fn(u8) -> f32) -> u8 {
        let mut best = (f32::NEG_INFINITY, 0);
        for (label, part) in self.shares() {
            let score = part + more(label);
            if score > best.0 {
                best = (score, label);
            }
        }
        best.1
    }
}

/// The ground of every node: a label in smooth parts, [`NO_GROUND`] elsewhere.
///
/// `mixtures` and `colours`, sRGB-encoded, are those of the photo, without emphasis; `stippling` says how much is smooth: 0 nothing, 1
/// everything that a ground with dots can show. The ground is the label of the largest part around, of more than half where more than two mix. How smooth a
/// part must be is as for black and white, by its luma and, counting less, its chroma; what the ground lacks is the mean,
/// by root of the product, of the other labels' parts and of how different they look.
///
/// # Errors
/// [`Error::Input`] if there is not one mixture and one finite colour a node, or stippling is not between 0 and 1.
pub fn grounds_inks(graph: &Graph, mixtures: &[Mixture], colours: &[[f32; 3]], mixing: &Mixing, stippling: f64) -> Result<Vec<u8>> {
    let count = graph.sites.len();
    check_mixtures(mixtures, count, mixing.labels())?;
    check_one_a_node("colours", colours.len(), count)?;
    if let Some(node) = colours.iter().position(|colour| colour.iter().any(|v| !v.is_finite())) {
        return Err(Error::Input(format!("the colour of node {node} is not finite")));
    }
    if !(0.0..=1.0).contains(&stippling) {
        return Err(Error::Input(format!("stippling is {stippling}, but it must be between 0 and 1")));
    }
    if stippling == 0.0 {
        return Ok(vec![NO_GROUND; count]);
    }
    let mut around: Vec<Around> = for_nodes(count, |node| Around::of(&mixtures[node]));
    for _ in 0..2 {
        around = for_nodes(count, |node| Around::mean(graph, &around, node));
    }
    let ground = grounds_of(graph, &around);
    let can_carry = |node: usize| {
        let (own, own_part) = (ground[node], around[node].part(ground[node]));
        let second = around[node].shares().filter(|(label, _)| *label != own).map(|(_, part)| part).fold(0.0, f32::max);
        let more = (1.0 - own_part - second).max(0.0);
        own_part >= (LEAST_GROUND + GROWTH * more).min(LEAST_OF_MORE)
    };
    let smooth = if stippling == 1.0 {
        for_nodes(count, can_carry)
    } else {
        let squares = off_planes(graph, colours);
        let allowed = 2.0 * ROUGHNESS * stippling / (1.0 - stippling);
        for_nodes(count, |node| {
            // Inks that are nearly alike need not be as smooth for their parts, but smoother than for what they look like.
            let (own, mut part, mut seen) = (ground[node], 0.0, 0.0);
            for (label, share) in around[node].shares().filter(|(label, _)| *label != own) {
                part += f64::from(share);
                seen += f64::from(share) * mixing.distance(own, label);
            }
            let lack = (part * seen).sqrt().min(0.5);
            let limit = STEP + allowed * lack;
            can_carry(node) && f64::from(squares[node]) <= limit * limit
        })
    };
    let smooth = without_single_nodes(graph, smooth);
    Ok(smooth.iter().zip(ground).map(|(smooth, ground)| if *smooth { ground } else { NO_GROUND }).collect())
}

/// How far colours are from planes around every node, squared.
fn off_planes(graph: &Graph, colours: &[[f32; 3]]) -> Vec<f32> {
    let channel =
        |channel: usize| -> Vec<f32> { for_nodes(colours.len(), |node| axes(colours[node].map(f64::from))[channel] as f32) };
    let channels = [0, 1, 2].map(channel);
    let of = |node: usize| channels.iter().map(|values| off_plane(graph, values, node)).sum::<f64>() as f32;
    mean_around(graph, &mean_around(graph, &for_nodes(colours.len(), of)))
}

/// The label of the largest part, and among labels of nearly the same what the neighbours are.
fn grounds_of(graph: &Graph, around: &[Around]) -> Vec<u8> {
    let mut ground: Vec<u8> = for_nodes(around.len(), |node| around[node].best(|_| 0.0));
    for _ in 0..COHESION_SWEEPS {
        ground = for_nodes(ground.len(), |node| {
            let row = graph.row(node);
            let alike = |label: u8| row.iter().filter(|other| ground[**other as usize] == label).count();
            around[node].best(|label| COHESION * alike(label) as f32 / row.len().max(1) as f32)
        });
    }
    ground
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Lattice;
    use crate::inks::mixtures;
    use crate::labels::smooth::{STRUCTURED, grounds};
    use crate::options::LatticeKind;

    fn lattice() -> Graph {
        Lattice::new(LatticeKind::Hexagonal, 60, 60, 1.0).unwrap().to_graph()
    }

    #[test]
    fn black_and_white_have_the_grounds_of_tones() {
        let graph = lattice();
        let mixing = Mixing::new(&[[0; 3], [255; 3]], false).unwrap();
        let tone = |[x, y]: &[f64; 2]| (0.5 + 0.4 * (0.01 * x * x).sin() * (0.1 * y).cos()) as f32;
        let tones: Vec<f32> = graph.sites.iter().map(tone).collect();
        let colours: Vec<[f32; 3]> = tones.iter().map(|tone| [*tone; 3]).collect();
        for stippling in [0.0, 0.2, 0.5, 0.8, 1.0] {
            let expected = grounds(&graph, &tones, stippling).unwrap();
            let found = grounds_inks(&graph, &mixtures(&colours, &mixing), &colours, &mixing, stippling).unwrap();
            let is_other = |(a, b): &(&u8, &u8)| **a != **b && !(**a == STRUCTURED && **b == NO_GROUND);
            let other = expected.iter().zip(&found).filter(is_other).count();
            assert!(other <= 3, "{stippling}: {other}");
        }
    }

    #[test]
    fn flat_colours_have_their_nearest_ink_and_edges_have_none() {
        let graph = lattice();
        let mixing = Mixing::new(&[[29, 29, 27], [255, 72, 176], [0, 120, 191], [244, 239, 226]], false).unwrap();
        let colour = |[x, _]: &[f64; 2]| if *x < 30.0 { [0.95, 0.7, 0.8] } else { [0.1, 0.45, 0.7] };
        let colours: Vec<[f32; 3]> = graph.sites.iter().map(colour).collect();
        let found = grounds_inks(&graph, &mixtures(&colours, &mixing), &colours, &mixing, 0.5).unwrap();
        for ([x, _], ground) in graph.sites.iter().zip(&found) {
            assert!((x - 30.0).abs() > 1.0 || *ground == NO_GROUND);
            assert!((x - 30.0).abs() < 5.0 || *ground == if *x < 30.0 { 3 } else { 2 }, "{x} {ground}");
        }
        assert!(grounds_inks(&graph, &[], &colours, &mixing, 0.5).is_err());
        assert!(grounds_inks(&graph, &mixtures(&colours, &mixing), &colours, &mixing, 1.5).is_err());
    }
}
