//! Dots of several inks that fused by chance, taken apart again: see [`split`](crate::stages::split).

use crate::base::Result;
use crate::graph::Graph;
use crate::inks::{MOST_LABELS, Mixture, check_mixtures};
use crate::labels::inks::check_labels_below;
use crate::labels::split::{Asked, take_apart};

/// Takes apart the components of 2 to `most` nodes none of whose mixtures have most of their label, where there is room for all
/// their dots: every other one changes labels with a node nearby that has the label which its own mixture has most of.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one mixture and one label a node.
pub fn split_inks(graph: &Graph, mixtures: &[Mixture], labels: &mut [u8], most: u32) -> Result<()> {
    check_mixtures(mixtures, graph.sites.len(), MOST_LABELS)?;
    check_labels_below("labels", labels, MOST_LABELS, graph.sites.len())?;
    take_apart(graph, &Mixed { mixtures }, labels, most);
    Ok(())
}

struct Mixed<'a> {
    mixtures: &'a [Mixture],
}

impl Asked for Mixed<'_> {
    fn distance(&self, node: u32, label: u8) -> f32 {
        1.0 - self.mixtures[node as usize].part(label)
    }

    fn wanted(&self, node: u32) -> u8 {
        self.mixtures[node as usize].largest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Lattice;
    use crate::options::LatticeKind;

    #[test]
    fn a_stroke_becomes_dots_and_no_label_is_lost() {
        let graph = Lattice::new(LatticeKind::Hexagonal, 30, 30, 1.0).unwrap().to_graph();
        let mixed = vec![Mixture { labels: [2, 0, 5, 0], parts: [0.8, 0.1, 0.1, 0.0] }; graph.sites.len()];
        let mut labels = vec![2; mixed.len()];
        let middle = mixed.len() / 2;
        (labels[middle], labels[graph.row(middle)[0] as usize]) = (5, 5);
        split_inks(&graph, &mixed, &mut labels, 4).unwrap();
        let dots: Vec<usize> = (0..labels.len()).filter(|node| labels[*node] == 5).collect();
        assert!(dots.len() == 2 && !graph.row(dots[0]).contains(&(dots[1] as u32)));
        assert!(split_inks(&graph, &mixed, &mut [0], 4).is_err());
    }
}
