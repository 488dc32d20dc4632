//! Connected components of equally labelled nodes, after the paper.
//!
//! Components are numbered in the order of their lowest nodes.

use crate::graph::Graph;

/// What is connected to what.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Components {
    /// Component of every node.
    pub ids: Vec<u32>,
    /// Number of nodes of every component.
    pub sizes: Vec<u32>,
}

/// The components of a labelled graph.
///
/// # Panics
/// If there are fewer labels than nodes.
pub fn components(graph: &Graph, labels: &[u8]) -> Components {
    const NONE: u32 = u32::MAX;
    let mut components = Components { ids: vec![NONE; graph.sites.len()], sizes: Vec::new() };
    let mut stack: Vec<u32> = Vec::new();
    for first in 0..graph.sites.len() {
        if components.ids[first] != NONE {
            continue;
        }
        let id = components.sizes.len() as u32;
        let mut size = 0;
        components.ids[first] = id;
        stack.push(first as u32);
        while let Some(node) = stack.pop() {
            size += 1;
            for &neighbor in graph.row(node as usize) {
                if components.ids[neighbor as usize] == NONE && labels[neighbor as usize] == labels[first] {
                    components.ids[neighbor as usize] = id;
                    stack.push(neighbor);
                }
            }
        }
        components.sizes.push(size);
    }
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_labels_that_touch_are_one() {
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [0, 5]];
        let graph = Graph::from_edges(vec![[0.0, 0.0]; 6], &edges).unwrap();
        let found = components(&graph, &[1, 0, 0, 1, 0, 1]);
        assert_eq!(found.ids, [0, 1, 1, 2, 3, 0]);
        assert_eq!(found.sizes, [2, 2, 1, 1]);
    }
}
