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
    let count = graph.sites.len();
    // A forest: every node points to a lower one of its component, its lowest to itself.
    let mut lower: Vec<u32> = Vec::with_capacity(count);
    for node in 0..count {
        let mut root = node as u32;
        lower.push(root);
        // Rows are sorted: nodes further on will look back themselves.
        for &neighbor in graph.row(node).iter().take_while(|n| **n < node as u32) {
            if labels[neighbor as usize] == labels[node] {
                let other = find(&mut lower, neighbor);
                lower[root.max(other) as usize] = root.min(other);
                root = root.min(other);
            }
        }
    }
    let mut components = Components { ids: Vec::with_capacity(count), sizes: Vec::new() };
    for (node, lower) in lower.into_iter().enumerate() {
        let id = if lower as usize == node {
            components.sizes.push(0);
            components.sizes.len() as u32 - 1
        } else {
            components.ids[lower as usize]
        };
        components.sizes[id as usize] += 1;
        components.ids.push(id);
    }
    components
}

/// The lowest node of a component as known so far; halves the way there for the next time.
fn find(lower: &mut [u32], mut node: u32) -> u32 {
    loop {
        let next = lower[node as usize];
        if next == node {
            return node;
        }
        lower[node as usize] = lower[next as usize];
        node = next;
    }
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
