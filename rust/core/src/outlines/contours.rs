//! Contours: the boundaries between components, each as the graph's edges that it crosses (a *contour*), black on its left.

use std::ops::Range;

use rayon::prelude::*;

use crate::base::{Error, Result, Side};
use crate::graph::{Beside, Components, Triangulation};

/// A boundary between two components.
#[derive(Debug)]
pub(super) struct Contour {
    /// The component on its left.
    pub(super) black: u32,
    /// The component on its right.
    pub(super) white: u32,
    /// For an open contour, the sides of the frame on which it begins and ends.
    pub(super) ends: Option<[Side; 2]>,
    /// Its crossing edges, in order: which of [`Contours::edges`].
    pub(super) edges: (usize, Range<usize>),
}

pub(super) struct Contours {
    pub(super) contours: Vec<Contour>,
    /// Crossing edges as (black node, white node), those of each part of the nodes.
    edges: Vec<Vec<[u32; 2]>>,
}

impl Contours {
    pub(super) fn edges(&self, contour: &Contour) -> &[[u32; 2]] {
        let (part, range) = &contour.edges;
        &self.edges[*part][range.clone()]
    }
}

/// Finds all contours: open ones first, then closed ones, each in the order of the edges that they begin with. A closed contour begins
/// with the first of its edges, so every thread finds those that begin in its part of the nodes, of which `size` make one. The
/// contours do not depend on it.
pub(super) fn trace(triangulation: &Triangulation, labels: &[u8], components: &Components, size: usize) -> Result<Contours> {
    let count = labels.len();
    let parts = (0..count.div_ceil(size)).into_par_iter().map(|part| {
        let nodes = part * size..((part + 1) * size).min(count);
        let mut tracer = Tracer::new(triangulation, labels, components, part, nodes);
        let open = tracer.find_open()?;
        let closed = tracer.find_closed()?;
        Ok((open, closed, tracer.edges))
    });
    let mut found = Contours { contours: Vec::new(), edges: Vec::new() };
    let mut all_closed = Vec::new();
    for (open, closed, edges) in parts.collect::<Result<Vec<_>>>()? {
        found.contours.extend(open);
        all_closed.push(closed);
        found.edges.push(edges);
    }
    found.contours.extend(all_closed.into_iter().flatten());
    Ok(found)
}

/// Nodes of a part at least.
pub(super) const LEAST_PART: usize = 1 << 14;

/// Some parts have more boundaries than others: with several each, threads end together.
pub(super) const PARTS_A_THREAD: usize = 4;

/// Finds the contours that begin in one part of the nodes.
struct Tracer<'a> {
    triangulation: &'a Triangulation,
    labels: &'a [u8],
    components: &'a Components,
    part: usize,
    nodes: Range<usize>,
    /// The part's directed edges, as numbered in the graph, and which of them were walked along.
    slots: Range<usize>,
    visited: Vec<bool>,
    edges: Vec<[u32; 2]>,
}

impl<'a> Tracer<'a> {
    fn new(
        triangulation: &'a Triangulation,
        labels: &'a [u8],
        components: &'a Components,
        part: usize,
        nodes: Range<usize>,
    ) -> Self {
        let offset = |node: usize| triangulation.graph.offsets[node] as usize;
        let slots = offset(nodes.start)..offset(nodes.end);
        let visited = vec![false; slots.len()];
        Self { triangulation, labels, components, part, nodes, slots, visited, edges: Vec::new() }
    }

    /// The open contours.
    fn find_open(&mut self) -> Result<Vec<Contour>> {
        let graph = &self.triangulation.graph;
        let mut contours = Vec::new();
        // Those begin at an edge from a black node with the frame on its right: on the left of the same edge the other way.
        let mut nodes: Vec<usize> = (self.triangulation.at_frame(self.slots.clone()))
            .map(|slot| graph.offsets.partition_point(|offset| *offset as usize <= slot) - 1)
            .filter(|node| self.labels[*node] == 0)
            .collect();
        nodes.dedup();
        for black in nodes {
            for first in graph.offsets[black] as usize..graph.offsets[black + 1] as usize {
                let white = graph.neighbors[first];
                if self.labels[white as usize] == 0 {
                    continue;
                }
                let behind = self.triangulation.slot(white, black as u32).ok_or_else(lost)?;
                let Beside::Frame(begin) = self.triangulation.left(behind) else { continue };
                let start = self.edges.len();
                let Walked::ToFrame(end) = self.walk(first, [black as u32, white], true)? else {
                    return Err(Error::Internal("a boundary has one end only".into()));
                };
                contours.push(self.contour(start, Some([begin, end])));
            }
        }
        Ok(contours)
    }

    /// The closed contours, after the open ones.
    fn find_closed(&mut self) -> Result<Vec<Contour>> {
        let graph = &self.triangulation.graph;
        let mut contours = Vec::new();
        for black in self.nodes.clone().filter(|i| self.labels[*i] == 0) {
            for first in graph.offsets[black] as usize..graph.offsets[black + 1] as usize {
                let white = graph.neighbors[first];
                if self.labels[white as usize] == 0 || self.visited[first - self.slots.start] {
                    continue;
                }
                let start = self.edges.len();
                match self.walk(first, [black as u32, white], false)? {
                    Walked::Around => contours.push(self.contour(start, None)),
                    // It begins in another part.
                    Walked::ToFrame(_) | Walked::FromElsewhere => self.edges.truncate(start),
                }
            }
        }
        Ok(contours)
    }

    /// The contour of the edges from one on.
    fn contour(&self, start: usize, ends: Option<[Side; 2]>) -> Contour {
        let [black, white] = self.edges[start].map(|node| self.components.ids[node as usize]);
        Contour { black, white, ends, edges: (self.part, start..self.edges.len()) }
    }

    /// Walks along a contour from one of its edges, and writes down what it crosses. One that may be closed is left as soon as an edge
    /// comes before its first, or was walked along already: then it began there.
    fn walk(&mut self, first: usize, mut edge: [u32; 2], open: bool) -> Result<Walked> {
        let mut slot = first;
        loop {
            match self.visited.get_mut(slot.wrapping_sub(self.slots.start)) {
                Some(visited) if *visited && !open => return Ok(Walked::FromElsewhere),
                Some(visited) => *visited = true,
                None => {}
            }
            self.edges.push(edge);
            match self.triangulation.left(slot) {
                Beside::Frame(side) => return Ok(Walked::ToFrame(side)),
                Beside::Node(third) if self.labels[third as usize] == 0 => edge[0] = third,
                Beside::Node(third) => edge[1] = third,
            }
            slot = self.triangulation.slot(edge[0], edge[1]).ok_or_else(lost)?;
            if slot == first {
                return Ok(Walked::Around);
            }
            if slot < first && !open {
                return Ok(Walked::FromElsewhere);
            }
        }
    }
}

/// How walking along a contour ended.
enum Walked {
    /// Back where it began.
    Around,
    ToFrame(Side),
    /// Where it is known that the contour begins elsewhere.
    FromElsewhere,
}

fn lost() -> Error {
    Error::Internal("a boundary runs along an edge that is not there".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Control;
    use crate::graph::{components, triangulate};

    #[test]
    fn parts_do_not_show() {
        let random = |i: usize| 0.5 + 0.49 * f64::from(crate::base::noise(i as u64));
        let sites = (0..2000).map(|i| [40.0 * random(2 * i), 30.0 * random(2 * i + 1)]).collect();
        let triangulation = triangulate(sites, 40, 30, &Control::new()).unwrap();
        let side = |[x, y]: [f64; 2]| libm::sin(0.9 * x) + libm::sin(1.1 * y);
        let labels: Vec<u8> = triangulation.graph.sites.iter().map(|site| u8::from(side(*site) > 0.1)).collect();
        let components = components(&triangulation.graph, &labels);
        let found = |size: usize| {
            let contours = trace(&triangulation, &labels, &components, size).unwrap();
            let sides = |contour: &Contour| (contour.black, contour.white, contour.ends, contours.edges(contour).to_vec());
            contours.contours.iter().map(sides).collect::<Vec<_>>()
        };
        let whole = found(2000);
        assert!(whole.iter().any(|contour| contour.2.is_some()) && whole.iter().filter(|contour| contour.2.is_none()).count() > 5);
        for size in [1, 30, 777] {
            assert_eq!(found(size), whole);
        }
    }
}
