//! Connected components of equally labelled nodes, after the paper.
//!
//! Components are numbered in the order of their lowest nodes.

use rayon::prelude::*;

use crate::graph::graph::Graph;

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
    in_bands(graph, labels, graph.sites.len().div_ceil(rayon::current_num_threads()).max(LEAST_BAND))
}

/// Nodes that one thread connects, at least.
const LEAST_BAND: usize = 1 << 14;

/// [`components`], found in bands of `size` nodes at first. The result does not depend on it.
fn in_bands(graph: &Graph, labels: &[u8], size: usize) -> Components {
    let count = graph.sites.len();
    // A forest: every node points to a lower one of its component, its lowest to itself.
    let mut lower = vec![0u32; count];
    let bands = lower.par_chunks_mut(size).enumerate();
    let links: Vec<Vec<[u32; 2]>> = bands.map(|(band, lower)| connect(graph, labels, band * size, lower)).collect();
    for [a, b] in links.into_iter().flatten() {
        join(&mut lower, a, b);
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

/// Connects the nodes from `first` on, as many as `lower` is to have values for, among themselves. Returns the edges from them to
/// equally labelled nodes before.
fn connect(graph: &Graph, labels: &[u8], first: usize, lower: &mut [u32]) -> Vec<[u32; 2]> {
    let mut links = Vec::new();
    // In here nodes count from the first.
    for own in 0..lower.len() {
        let node = first + own;
        lower[own] = own as u32;
        let mut root = own as u32;
        // Rows are sorted: nodes further on will look back themselves.
        for &neighbor in graph.row(node).iter().take_while(|n| (**n as usize) < node) {
            if labels[neighbor as usize] == labels[node] {
                match (neighbor as usize).checked_sub(first) {
                    Some(other) => root = join(lower, root, other as u32),
                    None => links.push([node as u32, neighbor]),
                }
            }
        }
    }
    for node in lower {
        *node += first as u32;
    }
    links
}

/// Makes one component of those of two nodes, and returns its lowest node.
fn join(lower: &mut [u32], a: u32, b: u32) -> u32 {
    let (a, b) = (find(lower, a), find(lower, b));
    lower[a.max(b) as usize] = a.min(b);
    a.min(b)
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
    use crate::graph::lattice::Lattice;
    use crate::options::LatticeKind;

    #[test]
    fn equal_labels_that_touch_are_one() {
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [0, 5]];
        let graph = Graph::from_edges(vec![[0.0, 0.0]; 6], &edges).unwrap();
        let found = components(&graph, &[1, 0, 0, 1, 0, 1]);
        assert_eq!(found.ids, [0, 1, 1, 2, 3, 0]);
        assert_eq!(found.sizes, [2, 2, 1, 1]);
    }

    #[test]
    fn bands_do_not_show() {
        let graph = Lattice::new(LatticeKind::Hexagonal, 60, 50, 1.0).unwrap().to_graph();
        let labels: Vec<u8> = (0..graph.sites.len()).map(|i| u8::from(i * i % 7 < 3 || i % 60 < 4)).collect();
        let whole = in_bands(&graph, &labels, labels.len());
        assert!(whole.sizes.len() > 20 && whole.sizes.iter().any(|size| *size > 300));
        for size in [1, 59, 700] {
            assert_eq!(in_bands(&graph, &labels, size), whole);
        }
    }
}
