//! The white pieces of a labelled graph: which are held by the sheet beyond the frame, and which fall out. In: a triangulation with
//! labels and components; out: what every component is.
//!
//! A piece is held if it is drawn to the frame. One node there is not: it is drawn as a dot beside the frame, with black all around
//! it, if it is not cut in two by the canvas (see [`crate::stages::outline`]).

use crate::base::Side;
use crate::graph::{Beside, Components, Triangulation};

/// Where nodes meet the frame.
pub(super) struct AtFrame {
    /// The nodes that do, in ascending order, each with the sides that it meets.
    nodes: Vec<(u32, Vec<Side>)>,
}

impl AtFrame {
    pub(super) fn of(triangulation: &Triangulation) -> Self {
        let graph = &triangulation.graph;
        let mut nodes: Vec<(u32, Vec<Side>)> = Vec::new();
        // Every node there has an edge with the frame on its left, if it has any.
        for slot in triangulation.at_frame(0..graph.neighbors.len()) {
            let Beside::Frame(side) = triangulation.left(slot) else { continue };
            let node = graph.offsets.partition_point(|offset| *offset as usize <= slot) as u32 - 1;
            match nodes.last_mut() {
                Some((last, sides)) if *last == node => sides.push(side),
                _ => nodes.push((node, vec![side])),
            }
        }
        if graph.neighbors.is_empty() {
            nodes.extend((0..graph.sites.len() as u32).map(|node| (node, Vec::new())));
        }
        Self { nodes }
    }

    /// The sides that a node meets; `None` if it does not meet the frame.
    pub(super) fn sides(&self, node: u32) -> Option<&[Side]> {
        let at = self.nodes.binary_search_by_key(&node, |(node, _)| *node).ok()?;
        Some(&self.nodes[at].1)
    }

    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().map(|(node, _)| *node)
    }
}

/// What a component is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Piece {
    Black,
    /// White that the sheet holds.
    Held,
    /// White that falls out.
    Island,
}

/// What every component is, and whether it is drawn as a dot.
pub(super) struct Pieces {
    pub(super) pieces: Vec<Piece>,
    pub(super) is_dot: Vec<bool>,
}

impl Pieces {
    pub(super) fn of(triangulation: &Triangulation, labels: &[u8], components: &Components, at_frame: &AtFrame) -> Self {
        let mut pieces = vec![Piece::Black; components.sizes.len()];
        let mut is_dot: Vec<bool> = components.sizes.iter().map(|size| *size == 1).collect();
        for (id, label) in components.ids.iter().zip(labels) {
            if *label == 1 {
                pieces[*id as usize] = Piece::Island;
            }
        }
        for (node, sides) in &at_frame.nodes {
            let id = components.ids[*node as usize] as usize;
            is_dot[id] &= sides.len() == 1 && triangulation.graph.row(*node as usize).len() >= 2;
            if pieces[id] == Piece::Island && !is_dot[id] {
                pieces[id] = Piece::Held;
            }
        }
        Self { pieces, is_dot }
    }
}
