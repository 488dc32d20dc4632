//! Sites plus adjacency: the form in which every stage hands a graph to the next.
//!
//! Adjacency is in compressed sparse rows: the neighbours of node `i` are `neighbors[offsets[i]..offsets[i + 1]]`. Every edge
//! stands in both rows. What this module does not do: build one (see [`crate::lattice`] and [`crate::triangulation`]).

/// Whom a node's error, mean or component can reach.
pub trait Adjacency: Sync {
    /// Number of nodes.
    fn len(&self) -> usize;

    /// Whether there is no node.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Calls `visit(neighbour, squared distance in px^2)` for every neighbour of `node`, in the graph's fixed order.
    fn for_each_neighbor(&self, node: usize, visit: impl FnMut(usize, f64));
}

/// Sites with their adjacency.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Graph {
    /// Position of every node: x, y in pixels.
    pub sites: Vec<[f64; 2]>,
    /// Start of every node's row in `neighbors`; one more entry than there are nodes.
    pub offsets: Vec<u32>,
    /// All rows, one behind the other.
    pub neighbors: Vec<u32>,
}

impl Graph {
    /// The neighbours of `node`.
    pub fn row(&self, node: usize) -> &[u32] {
        &self.neighbors[self.offsets[node] as usize..self.offsets[node + 1] as usize]
    }

    /// Every edge once, as (lower index, higher index), in the order of the rows.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        (0..self.sites.len()).flat_map(move |i| {
            let i32 = i as u32;
            self.row(i).iter().filter(move |j| **j > i32).map(move |j| [i32, *j])
        })
    }
}

/// The squared distance of two points.
pub(crate) fn distance_squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    dx * dx + dy * dy
}

impl Adjacency for Graph {
    fn len(&self) -> usize {
        self.sites.len()
    }

    fn for_each_neighbor(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
        let site = self.sites[node];
        for &neighbor in self.row(node) {
            let neighbor = neighbor as usize;
            visit(neighbor, distance_squared(site, self.sites[neighbor]));
        }
    }
}
