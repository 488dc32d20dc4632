//! Sites plus adjacency: the form in which every stage hands a graph to the next.
//!
//! Adjacency is in compressed sparse rows: the neighbours of node `i` are `neighbors[offsets[i]..offsets[i + 1]]`. Every edge
//! stands in both rows. What this module does not do: build one (see [`super::lattice`], [`super::triangulation`]).

use std::ops::Range;

use rayon::prelude::*;

use crate::base::{Error, Result};

/// Whom a node's error, mean or component can reach.
pub trait Adjacency: Sync {
    /// Number of nodes.
    fn len(&self) -> usize;

    /// Whether there is no node.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Calls `visit(neighbour, distance in px)` for every neighbour of `node`, in the graph's fixed order.
    fn for_each_neighbor(&self, node: usize, visit: impl FnMut(usize, f64));

    /// The mean of values over a node and its neighbours.
    fn mean_around(&self, node: usize, values: &[impl Copy + Into<f64>]) -> f64 {
        let (mut sum, mut count) = (values[node].into(), 1.0);
        self.for_each_neighbor(node, |neighbor, _| {
            sum += values[neighbor].into();
            count += 1.0;
        });
        sum / count
    }

    /// Calls `visit` with ranges of numbers that hold every node within so many hops of `node` once, itself too, and no other;
    /// or returns `false`, having called nothing, where only a search finds them.
    fn for_each_run_within(&self, _node: usize, _hops: usize, _visit: impl FnMut(Range<usize>)) -> bool {
        false
    }
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
    /// A graph from its edges, in any order and direction; every row is sorted.
    ///
    /// # Errors
    /// [`Error::Input`] if an edge names a node that does not exist, joins a node to itself or stands twice, or there are more
    /// nodes or edges than 32 bits can number.
    pub fn from_edges(sites: Vec<[f64; 2]>, edges: &[[u32; 2]]) -> Result<Self> {
        if sites.len().max(edges.len()) > (u32::MAX / 2) as usize {
            return Err(Error::Input(format!("{} nodes and {} edges are too many", sites.len(), edges.len())));
        }
        let mut offsets = vec![0u32; sites.len() + 1];
        for (k, edge) in edges.iter().enumerate() {
            if edge.iter().any(|i| *i as usize >= sites.len()) || edge[0] == edge[1] {
                return Err(Error::Input(format!(
                    "edge {k} joins nodes {} and {}, but it must join two different nodes below {}",
                    edge[0],
                    edge[1],
                    sites.len()
                )));
            }
            for i in edge {
                offsets[*i as usize + 1] += 1;
            }
        }
        cumulate(&mut offsets);
        let mut next = offsets.clone();
        let mut neighbors = vec![0; edges.len() * 2];
        for &[a, b] in edges {
            for (from, to) in [(a, b), (b, a)] {
                neighbors[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        let graph = Self { sites, offsets, neighbors };
        graph.sorted()
    }

    fn sorted(mut self) -> Result<Self> {
        for i in 0..self.sites.len() {
            let row = &mut self.neighbors[self.offsets[i] as usize..self.offsets[i + 1] as usize];
            row.sort_unstable();
            if let Some(pair) = row.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(Error::Input(format!("the edge between nodes {i} and {} stands twice", pair[0])));
            }
        }
        Ok(self)
    }

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

/// # Errors
/// [`Error::Input`] unless there is one of what is `found` for every node.
pub(crate) fn check_one_a_node(what: &str, found: usize, nodes: usize) -> Result<()> {
    if found == nodes {
        return Ok(());
    }
    Err(Error::Input(format!("there are {found} {what} for {nodes} nodes, but every node needs one")))
}

/// # Errors
/// [`Error::Input`] for a label that is neither 0 nor 1.
pub(crate) fn check_labels(labels: &[u8]) -> Result<()> {
    match first_refused(labels, |label| *label <= 1) {
        None => Ok(()),
        Some(i) => Err(Error::Input(format!("the label of node {i} is {}, but it must be 0 (black) or 1 (white)", labels[i]))),
    }
}

/// # Errors
/// [`Error::Input`] for a value that is not finite; `what` one of them is called.
pub(crate) fn check_finite(what: &str, values: &[f32]) -> Result<()> {
    match first_refused(values, |value| value.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::Input(format!("the {what} of node {i} is {}, but it must be finite", values[i]))),
    }
}

/// # Errors
/// [`Error::Input`] for an area that is not finite or is below 0; `what` one of them is called.
pub(crate) fn check_areas(what: &str, areas: &[f64]) -> Result<()> {
    match first_refused(areas, |area| *area >= 0.0 && area.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::Input(format!("the {what} of node {i} is {}, but it must be at least 0 px^2", areas[i]))),
    }
}

/// The first place whose value is not as it must be, if there is one.
fn first_refused<T: Sync>(values: &[T], is_fine: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    // Whole blocks, without a branch: a parallel search asks after every step whether another thread has found something.
    let refused = |block: &[T]| !block.iter().fold(true, |fine, value| fine & is_fine(value));
    let block = values.par_chunks(CHECKED_AT_ONCE).position_first(refused)?;
    let begin = block * CHECKED_AT_ONCE;
    values[begin..].iter().position(|value| !is_fine(value)).map(|within| begin + within)
}

/// Values of which is known that all are fine, or that one is not.
const CHECKED_AT_ONCE: usize = 4096;

/// How far inside the frame every site lies, in pixels: enough to tell a site from its mirror image, too little to see.
pub const FRAME_MARGIN: f64 = 1e-3;

/// # Errors
/// [`Error::Input`] if there is no site or one does not lie at least [`FRAME_MARGIN`] inside the canvas.
pub(crate) fn check_sites(sites: &[[f64; 2]], width: usize, height: usize) -> Result<()> {
    if sites.is_empty() {
        return Err(Error::Input("there are no sites, but at least one is needed".into()));
    }
    if sites.len() > u32::MAX as usize / 8 {
        return Err(Error::Input(format!("there are {} sites, but at most {} are possible", sites.len(), u32::MAX / 8)));
    }
    // Half the margin, so that a site clamped to the margin passes whatever the rounding.
    let margin = FRAME_MARGIN / 2.0;
    let inside = |v: f64, length: usize| v >= margin && v <= length as f64 - margin;
    match sites.iter().position(|s| !(inside(s[0], width) && inside(s[1], height))) {
        None => Ok(()),
        Some(i) => Err(Error::Input(format!(
            "site {i} is at ({}, {}), but it must lie at least {FRAME_MARGIN} px inside the canvas of {width} x {height} px",
            sites[i][0], sites[i][1]
        ))),
    }
}

/// Turns lengths of rows, each one place late, into the starts of the rows.
pub(crate) fn cumulate(offsets: &mut [u32]) {
    for i in 1..offsets.len() {
        offsets[i] += offsets[i - 1];
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
            visit(neighbor, distance_squared(site, self.sites[neighbor]).sqrt());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_refused_values_is_found_wherever_it_stands() {
        let mut values = vec![0u8; 3 * CHECKED_AT_ONCE + 7];
        assert_eq!(first_refused(&values, |value| *value == 0), None);
        for place in [values.len() - 1, 2 * CHECKED_AT_ONCE, 2 * CHECKED_AT_ONCE - 1, CHECKED_AT_ONCE + 9, 0] {
            values[place] = 1;
            assert_eq!(first_refused(&values, |value| *value == 0), Some(place));
        }
    }
}
