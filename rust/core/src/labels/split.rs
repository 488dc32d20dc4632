//! Dots that fused by chance, taken apart again.
//!
//! Where a light or dark tone is made of dots, diffusion at times labels two or three neighbours alike, and dots fuse to short
//! strokes that nothing in the photo asks for. Such a component keeps the nodes that are not beside each other; every other one
//! gives its label to a node nearby that has room for a dot of its own. The number of nodes of either label stays, and with it the
//! tone. What the photo asks for stays too: no node is moved whose tone lies on the side of 0.5 that its label is on.

use rayon::prelude::*;

use crate::base::Result;
use crate::graph::{Graph, check_labels, check_one_a_node};

/// Takes apart the components of 2 to `most` nodes that diffusion alone made, where there is room for all their dots.
///
/// `tones` are those that were diffused, `labels` what came of them: 0 black, 1 white. Components are taken in the order of their
/// lowest nodes.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one tone and one label, 0 or 1, a node.
pub fn split(graph: &Graph, tones: &[f32], labels: &mut [u8], most: u32) -> Result<()> {
    let count = graph.sites.len();
    check_one_a_node("tones", tones.len(), count)?;
    check_one_a_node("labels", labels.len(), count)?;
    check_labels(labels)?;
    take_apart(graph, &Tones { tones }, labels, most);
    Ok(())
}

/// What nodes ask for.
pub(super) trait Asked: Sync {
    /// How far what a node asks for is from a label.
    fn distance(&self, node: u32, label: u8) -> f32;

    /// The label that it asks for.
    fn wanted(&self, node: u32) -> u8;

    /// Whether a node has a label that only an error passed on to it can have given it.
    fn is_by_chance(&self, node: u32, label: u8) -> bool {
        self.wanted(node) != label
    }
}

struct Tones<'a> {
    tones: &'a [f32],
}

impl Asked for Tones<'_> {
    fn distance(&self, node: u32, label: u8) -> f32 {
        (self.tones[node as usize] - f32::from(label)).abs()
    }

    fn wanted(&self, node: u32) -> u8 {
        u8::from(self.tones[node as usize] >= 0.5)
    }
}

/// [`split`] of valid input, whatever nodes ask for.
pub(super) fn take_apart(graph: &Graph, asked: &impl Asked, labels: &mut [u8], most: u32) {
    if most < 2 {
        return;
    }
    for fused in fused_by_chance(graph, asked, labels, most) {
        let label = labels[fused[0] as usize];
        // Components taken before may have reached this one.
        let is_whole = |node: &u32| {
            labels[*node as usize] == label
                && graph.row(*node as usize).iter().all(|other| labels[*other as usize] != label || fused.contains(other))
        };
        if !fused.iter().all(is_whole) {
            continue;
        }
        let (kept, moved) = apart(graph, asked, &fused, label);
        if let Some(places) = places(graph, asked, labels, &fused, &kept, moved.len()) {
            for node in moved {
                labels[node as usize] = asked.wanted(node);
            }
            for node in places {
                labels[node as usize] = label;
            }
        }
    }
}

/// The nodes of every component of 2 to `most` nodes whose tones all lie on the other side of 0.5 than their label, in the order
/// of their lowest nodes.
fn fused_by_chance(graph: &Graph, asked: &impl Asked, labels: &[u8], most: u32) -> Vec<Vec<u32>> {
    let nodes = (0..labels.len()).into_par_iter().with_min_len(LEAST_PART);
    nodes.filter_map(|lowest| fused_from(lowest, graph, asked, labels, most as usize)).collect()
}

/// Nodes that one thread looks at, at least.
const LEAST_PART: usize = 1 << 12;

/// Such a component, if this is its lowest node. It is left as soon as a node says that it is none.
fn fused_from(lowest: usize, graph: &Graph, asked: &impl Asked, labels: &[u8], most: usize) -> Option<Vec<u32>> {
    let is_candidate = |node: usize| node >= lowest && asked.is_by_chance(node as u32, labels[node]);
    let alike = |node: u32| graph.row(node as usize).iter().copied().filter(|other| labels[*other as usize] == labels[lowest]);
    if !is_candidate(lowest) || alike(lowest as u32).next().is_none() {
        return None;
    }
    let mut component = vec![lowest as u32];
    let mut next = 0;
    while next < component.len() {
        for other in alike(component[next]) {
            if component.contains(&other) {
                continue;
            }
            if component.len() == most || !is_candidate(other as usize) {
                return None;
            }
            component.push(other);
        }
        next += 1;
    }
    component.sort_unstable();
    Some(component)
}

/// The nodes in the order in which they ask for the label, ties by index.
fn ordered(mut nodes: Vec<u32>, asked: &impl Asked, label: u8) -> Vec<u32> {
    nodes.sort_unstable_by(|a, b| {
        let [first, second] = [a, b].map(|node| asked.distance(*node, label));
        first.total_cmp(&second).then(a.cmp(b))
    });
    nodes
}

fn has_neighbor_in(graph: &Graph, node: u32, nodes: &[u32]) -> bool {
    graph.row(node as usize).iter().any(|other| nodes.contains(other))
}

/// The nodes of a component that stay, none beside another, and those that do not.
fn apart(graph: &Graph, asked: &impl Asked, fused: &[u32], label: u8) -> (Vec<u32>, Vec<u32>) {
    let (mut kept, mut moved) = (Vec::new(), Vec::new());
    for node in ordered(fused.to_vec(), asked, label) {
        if has_neighbor_in(graph, node, &kept) { moved.push(node) } else { kept.push(node) }
    }
    (kept, moved)
}

/// Nodes at most two edges away from a component that can be `wanted` dots beside those kept, those that ask for the label most
/// first; `None` if there are not so many.
fn places(graph: &Graph, asked: &impl Asked, labels: &[u8], fused: &[u32], kept: &[u32], wanted: usize) -> Option<Vec<u32>> {
    let label = labels[fused[0] as usize];
    let mut places: Vec<u32> = Vec::with_capacity(wanted);
    while places.len() < wanted {
        let in_the_way = |other: &u32| {
            if fused.contains(other) { kept.contains(other) } else { labels[*other as usize] == label || places.contains(other) }
        };
        let around = fused.iter().flat_map(|node| graph.row(*node as usize)).flat_map(|node| graph.row(*node as usize));
        let mut best: Option<(f32, u32)> = None;
        for node in around.copied() {
            let is_free = labels[node as usize] == asked.wanted(node) && labels[node as usize] != label && !places.contains(&node);
            let own = (asked.distance(node, label), node);
            // Whether it has room takes longest to say.
            if is_free
                && asked.is_by_chance(node, label)
                && best.is_none_or(|best| own < best)
                && !graph.row(node as usize).iter().any(in_the_way)
            {
                best = Some(own);
            }
        }
        places.push(best?.1);
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Control;
    use crate::diffusion::{Diffusion, diffuse};
    use crate::graph::{Lattice, components};
    use crate::options::{LatticeKind, Options};

    fn lattice(width: usize, height: usize) -> Graph {
        Lattice::new(LatticeKind::Hexagonal, width, height, 1.0).unwrap().to_graph()
    }

    /// Nodes with the label `own` that have a neighbour of the same label.
    fn fused(graph: &Graph, labels: &[u8], own: u8) -> Vec<usize> {
        let is_fused = |node: &usize| labels[*node] == own && graph.row(*node).iter().any(|other| labels[*other as usize] == own);
        (0..labels.len()).filter(is_fused).collect()
    }

    /// A graph of one label with `count` neighbouring nodes of the other in its middle.
    fn stroke(graph: &Graph, count: usize, own: u8) -> Vec<u8> {
        let mut labels = vec![1 - own; graph.sites.len()];
        let first = graph.sites.len() / 2 + 5;
        labels[first..first + count].fill(own);
        labels
    }

    #[test]
    fn strokes_become_dots_and_their_number_stays() {
        let graph = lattice(20, 20);
        for own in [0, 1] {
            let tones = vec![if own == 0 { 0.8 } else { 0.2 }; graph.sites.len()];
            for count in 2..=4 {
                let before = stroke(&graph, count, own);
                assert_eq!(fused(&graph, &before, own).len(), count);
                let mut labels = before.clone();
                split(&graph, &tones, &mut labels, 4).unwrap();
                assert_eq!(fused(&graph, &labels, own), [0usize; 0]);
                assert_eq!(labels.iter().filter(|label| **label == own).count(), count);
                let mut longer = before.clone();
                split(&graph, &tones, &mut longer, count as u32 - 1).unwrap();
                assert_eq!(longer, before, "longer than asked for");
            }
        }
    }

    #[test]
    fn what_the_photo_asks_for_stays() {
        let graph = lattice(20, 20);
        let before = stroke(&graph, 3, 0);
        let mut tones = vec![0.8; before.len()];
        let middle = before.iter().position(|label| *label == 0).unwrap() + 1;
        tones[middle] = 0.4;
        let mut labels = before.clone();
        split(&graph, &tones, &mut labels, 4).unwrap();
        assert_eq!(labels, before);
    }

    #[test]
    fn without_room_nothing_changes() {
        // In a triangle the third node is beside the first two; in a row it is beside one.
        let sites = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]];
        for (edges, after) in [(&[[0, 1], [1, 2], [0, 2]][..], [0, 0, 1]), (&[[0, 1], [1, 2]][..], [0, 1, 0])] {
            let mut labels = [0, 0, 1];
            split(&Graph::from_edges(sites.clone(), edges).unwrap(), &[0.6; 3], &mut labels, 4).unwrap();
            assert_eq!(labels, after);
        }
    }

    #[test]
    fn a_grainy_tone_keeps_its_mean_and_gets_more_dots() {
        let graph = lattice(80, 80);
        let tones: Vec<f32> = (0..graph.sites.len()).map(|i| 0.55 + 0.3 * (i * i % 101) as f32 / 101.0).collect();
        let before =
            diffuse(&graph, &tones, None, &Diffusion { shading: 0.3, ..Diffusion::of_tone(&Options::default()) }, &Control::new())
                .unwrap();
        let mut labels = before.clone();
        split(&graph, &tones, &mut labels, 4).unwrap();
        let white = |labels: &[u8]| labels.iter().map(|label| u32::from(*label)).sum::<u32>();
        assert_eq!(white(&labels), white(&before));
        let dots = |labels: &[u8]| components(&graph, labels).sizes.iter().filter(|size| **size == 1).count();
        assert!(dots(&labels) > dots(&before), "{} {}", dots(&labels), dots(&before));
    }
}
