//! Contours: the boundaries between components, each as the graph's edges that it crosses (a *contour*), the lower label on its left:
//! black, in a drawing of black and white.

use std::ops::Range;

use rayon::prelude::*;

use crate::base::{Error, Result, Side};
use crate::graph::{Beside, Components, Triangulation};

/// A boundary between two components.
#[derive(Debug)]
pub(super) struct Contour {
    /// The component on its left.
    pub(super) left: u32,
    /// The component on its right.
    pub(super) right: u32,
    /// Where an open contour begins and ends.
    pub(super) ends: Option<[Ending; 2]>,
    /// Its crossing edges, in order: which of [`Contours::edges`].
    pub(super) edges: (usize, Range<usize>),
}

/// Where an open contour begins or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ending {
    /// On a side of the frame.
    Frame(Side),
    /// In a triangle whose three nodes have three labels: its nodes, in the same order for all three contours that end in it.
    Junction([u32; 3]),
}

pub(super) struct Contours {
    pub(super) contours: Vec<Contour>,
    /// Crossing edges as (node on the left, node on the right), those of each part of the nodes.
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
    let range = [labels.iter().min(), labels.iter().max()].map(|label| label.copied().unwrap_or_default());
    let parts = (0..count.div_ceil(size)).into_par_iter().map(|part| {
        let nodes = part * size..((part + 1) * size).min(count);
        let mut tracer = Tracer::new(triangulation, labels, components, part, nodes, range);
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
    highest: u8,
    /// Whether there are more than two labels.
    has_junctions: bool,
}

impl<'a> Tracer<'a> {
    fn new(
        triangulation: &'a Triangulation,
        labels: &'a [u8],
        components: &'a Components,
        part: usize,
        nodes: Range<usize>,
        [lowest, highest]: [u8; 2],
    ) -> Self {
        let offset = |node: usize| triangulation.graph.offsets[node] as usize;
        let slots = offset(nodes.start)..offset(nodes.end);
        let visited = vec![false; slots.len()];
        let has_junctions = highest > lowest + 1;
        Self { triangulation, labels, components, part, nodes, slots, visited, edges: Vec::new(), highest, has_junctions }
    }

    /// The open contours.
    fn find_open(&mut self) -> Result<Vec<Contour>> {
        let mut contours = Vec::new();
        for left in self.may_begin() {
            let graph = &self.triangulation.graph;
            for first in graph.offsets[left as usize] as usize..graph.offsets[left as usize + 1] as usize {
                let right = graph.neighbors[first];
                if self.label(right) <= self.label(left) {
                    continue;
                }
                // Behind it lies what is on the left of the same edge the other way.
                let behind = self.triangulation.slot(right, left).ok_or_else(lost)?;
                let Some(begin) = self.ending([right, left], self.triangulation.left(behind)) else { continue };
                let start = self.edges.len();
                let Walked::ToEnd(end) = self.walk(first, [left, right], true)? else {
                    return Err(Error::Internal("a boundary has one end only".into()));
                };
                contours.push(self.contour(start, Some([begin, end])));
            }
        }
        Ok(contours)
    }

    /// The nodes on whose edges open contours may begin: those at the frame, or all of them where there may be junctions.
    fn may_begin(&self) -> Vec<u32> {
        if self.has_junctions {
            return (self.nodes.start as u32..self.nodes.end as u32).collect();
        }
        let offsets = &self.triangulation.graph.offsets;
        let at_frame = self.triangulation.at_frame(self.slots.clone());
        let mut nodes: Vec<u32> =
            at_frame.map(|slot| offsets.partition_point(|offset| *offset as usize <= slot) as u32 - 1).collect();
        nodes.dedup();
        nodes
    }

    fn label(&self, node: u32) -> u8 {
        self.labels[node as usize]
    }

    /// Whether a contour that crosses an edge ends in what lies beside it, and how.
    fn ending(&self, [left, right]: [u32; 2], beside: Beside) -> Option<Ending> {
        match beside {
            Beside::Frame(side) => Some(Ending::Frame(side)),
            Beside::Node(third) => {
                let [a, b, c] = [left, right, third].map(|node| self.label(node));
                (c != a && c != b).then(|| {
                    let mut nodes = [left, right, third];
                    nodes.sort_unstable();
                    Ending::Junction(nodes)
                })
            }
        }
    }

    /// The closed contours, after the open ones.
    fn find_closed(&mut self) -> Result<Vec<Contour>> {
        let graph = &self.triangulation.graph;
        let mut contours = Vec::new();
        // To the right of the highest label lies nothing.
        let (labels, highest) = (self.labels, self.highest);
        for left in self.nodes.clone().filter(|i| labels[*i] < highest) {
            for first in graph.offsets[left] as usize..graph.offsets[left + 1] as usize {
                let right = graph.neighbors[first];
                if labels[right as usize] <= labels[left] || self.visited[first - self.slots.start] {
                    continue;
                }
                let start = self.edges.len();
                match self.walk(first, [left as u32, right], false)? {
                    Walked::Around => contours.push(self.contour(start, None)),
                    // It begins in another part.
                    Walked::ToEnd(_) | Walked::FromElsewhere => self.edges.truncate(start),
                }
            }
        }
        Ok(contours)
    }

    /// The contour of the edges from one on.
    fn contour(&self, start: usize, ends: Option<[Ending; 2]>) -> Contour {
        let [left, right] = self.edges[start].map(|node| self.components.ids[node as usize]);
        Contour { left, right, ends, edges: (self.part, start..self.edges.len()) }
    }

    /// Walks along a contour from one of its edges, and writes down what it crosses. One that may be closed is left as soon as an edge
    /// comes before its first, or was walked along already: then it began there.
    fn walk(&mut self, first: usize, mut edge: [u32; 2], open: bool) -> Result<Walked> {
        let [left, right] = edge.map(|node| self.label(node));
        let mut slot = first;
        loop {
            match self.visited.get_mut(slot.wrapping_sub(self.slots.start)) {
                Some(visited) if *visited && !open => return Ok(Walked::FromElsewhere),
                Some(visited) => *visited = true,
                None => {}
            }
            self.edges.push(edge);
            match self.triangulation.left(slot) {
                Beside::Node(third) if self.label(third) == left => edge[0] = third,
                Beside::Node(third) if self.label(third) == right => edge[1] = third,
                beside => return self.ending(edge, beside).map(Walked::ToEnd).ok_or_else(lost),
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
    ToEnd(Ending),
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
            let sides = |contour: &Contour| (contour.left, contour.right, contour.ends, contours.edges(contour).to_vec());
            contours.contours.iter().map(sides).collect::<Vec<_>>()
        };
        let whole = found(2000);
        assert!(whole.iter().any(|contour| contour.2.is_some()) && whole.iter().filter(|contour| contour.2.is_none()).count() > 5);
        for size in [1, 30, 777] {
            assert_eq!(found(size), whole);
        }
    }
}
