//! Clean paper and clean ink: no mark lies wholly on pure white or pure black.
//!
//! An error that was passed on, or a dot that was moved, may end beside what it was for, where the photo is pure white or black and
//! nothing is to be drawn: a speck.

use crate::base::Result;
use crate::graph::{Graph, check_finite, check_labels, check_one_a_node};

/// What a pure tone may differ from white or black: half a level of 8 bits.
pub(super) const PURE: f32 = 0.5 / 255.0;

/// Labels whatever lies on pure white or black, and on nothing else, as its tone is: components whose nodes all have the other
/// label than their tones, each of which is within half a level of 8 bits of 0 or 1.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one finite tone and one label, 0 or 1, a node.
pub fn clean(graph: &Graph, tones: &[f32], labels: &mut [u8]) -> Result<()> {
    let count = graph.sites.len();
    check_one_a_node("tones", tones.len(), count)?;
    check_one_a_node("labels", labels.len(), count)?;
    check_finite("tone", tones)?;
    check_labels(labels)?;
    let is_speck = |node: usize, label: u8| if label == 0 { tones[node] >= 1.0 - PURE } else { tones[node] <= PURE };
    for node in specks(graph, labels, is_speck) {
        labels[node] = 1 - labels[node];
    }
    Ok(())
}

/// The nodes of all components of one label that are specks and nothing else, by what is told of a node with its label.
pub(super) fn specks(graph: &Graph, labels: &[u8], is_speck: impl Fn(usize, u8) -> bool) -> Vec<usize> {
    let count = labels.len();
    let (mut is_seen, mut gone) = (vec![false; count], Vec::new());
    for first in 0..count {
        let label = labels[first];
        if is_seen[first] || !is_speck(first, label) {
            continue;
        }
        // All specks that hang together, and whether anything else hangs on them.
        is_seen[first] = true;
        let (mut specks, mut next, mut is_held) = (vec![first], 0, false);
        while let Some(node) = specks.get(next).copied() {
            next += 1;
            for other in graph.row(node).iter().map(|other| *other as usize).filter(|other| labels[*other] == label) {
                if !is_speck(other, label) {
                    is_held = true;
                } else if !is_seen[other] {
                    is_seen[other] = true;
                    specks.push(other);
                }
            }
        }
        if !is_held {
            gone.extend(specks);
        }
    }
    gone
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specks_go_and_what_hangs_on_a_tone_stays() {
        // A chain of nodes.
        let graph = |count: u32| {
            let sites = (0..count).map(|i| [f64::from(i), 0.0]).collect();
            Graph::from_edges(sites, &(1..count).map(|i| [i - 1, i]).collect::<Vec<_>>()).unwrap()
        };
        let cleaned = |tones: &[f32], labels: &[u8]| {
            let mut labels = labels.to_vec();
            clean(&graph(tones.len() as u32), tones, &mut labels).unwrap();
            labels
        };
        assert_eq!(cleaned(&[1.0, 1.0, 1.0, 1.0], &[1, 0, 0, 1]), [1; 4]);
        assert_eq!(cleaned(&[0.0, 0.0, 0.001, 0.3], &[0, 1, 1, 0]), [0; 4]);
        assert_eq!(cleaned(&[1.0, 1.0, 0.9, 1.0], &[1, 0, 0, 1]), [1, 0, 0, 1]);
        assert_eq!(cleaned(&[1.0, 0.99, 1.0, 1.0], &[1, 0, 1, 0]), [1, 0, 1, 1]);
    }
}
