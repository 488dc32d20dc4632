//! Clean inks: no mark lies wholly where the photo has none of its label.

use crate::base::Result;
use crate::graph::{Graph, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixture, check_mixtures};
use crate::labels::clean::{PURE, specks};
use crate::labels::inks::check_labels_below;

/// Gives back to the label of their largest part the nodes of every component whose mixtures all have none of its label: less than
/// half a level of 8 bits.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one mixture and one label a node.
pub fn clean_inks(graph: &Graph, mixtures: &[Mixture], labels: &mut [u8]) -> Result<()> {
    let count = graph.sites.len();
    check_mixtures(mixtures, count, MOST_LABELS)?;
    check_labels_below("labels", labels, MOST_LABELS, count)?;
    check_one_a_node("labels", labels.len(), count)?;
    let is_speck = |node: usize, label: u8| mixtures[node].part(label) <= PURE;
    for node in specks(graph, labels, is_speck) {
        labels[node] = mixtures[node].largest();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specks_go_and_what_hangs_on_a_part_of_its_ink_stays() {
        let sites = (0..4).map(|i| [f64::from(i), 0.0]).collect();
        let graph = Graph::from_edges(sites, &[[0, 1], [1, 2], [2, 3]]).unwrap();
        let mixed = Mixture { labels: [2, 3, 0, 0], parts: [0.8, 0.2, 0.0, 0.0] };
        let cleaned = |mixtures: [Mixture; 4], labels: [u8; 4]| {
            let mut labels = labels;
            clean_inks(&graph, &mixtures, &mut labels).unwrap();
            labels
        };
        let pure = Mixture::pure(2);
        assert_eq!(cleaned([pure; 4], [2, 3, 3, 1]), [2; 4]);
        assert_eq!(cleaned([pure, pure, mixed, pure], [2, 3, 3, 1]), [2, 3, 3, 2]);
        assert!(clean_inks(&graph, &[pure; 4], &mut [0, 1]).is_err());
    }
}
