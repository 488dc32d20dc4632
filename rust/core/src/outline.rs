//! Outlines: from labelled nodes to the marks of a drawing, after the paper.
//!
//! # The idea
//! Every triangle whose nodes carry both labels is crossed by exactly one piece of one boundary, from the midpoint of one of its
//! crossing edges to that of the other. The pieces join to *chains*: closed ones, and open ones that begin and end on the frame.
//! A chain with black on its left is the boundary between exactly two components, so its curve (see [`crate::fit`]) is made once
//! and shared by both.
//!
//! # At the frame
//! An open chain leaves through the edge between two sites whose cells both touch the frame, and goes straight to it, as the
//! spline through the mirrored midpoints would. So curves meet the frame at a right angle, and nothing is drawn outside.
//!
//! # Stipples
//! A component of one node is a dot with the area of the node's cell, shrunk until it stays inside the star of the node's
//! triangles, where no other curve runs. At the frame it moves in until all of it is on the canvas. A node that cuts the canvas in
//! two (its boundary is more than one chain) is a region.

use std::f64::consts::PI;

use kurbo::Point;
use rayon::prelude::*;

use crate::assembly::{Parts, assemble};
use crate::components::Components;
use crate::control::Control;
use crate::drawing::{Drawing, Frame, Ink, POLYGON_REACH, Stipple};
use crate::error::{Error, Result};
use crate::fit::{CrossingEdge, FINER_GRIDS, Fit};
use crate::least_radius::distance_to_segment;
use crate::triangulation::{Beside, Side, Triangulation};

/// What the outline stage makes.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlines {
    /// The drawing; its provenance is left empty.
    pub drawing: Drawing,
    /// See [`crate::drawing::Stats::vertices`].
    pub vertices: usize,
}

/// How marks are shaped; ranges as in [`crate::params::Options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaping {
    /// A stipple's area relative to its node's cell.
    pub stipple_scale: f64,
    /// How far a curve may lie from the spline through the midpoints, in pixels.
    pub tolerance: f64,
}

/// The least radius that a dot would like to have, in pixels, for nodes so dense that no sample fell to their cell: the dot stays a
/// mark with an area, and is too small to print.
const MIN_RADIUS: f64 = 1.0 / 1024.0;

/// How much finer the grid of dots is than that of curves, which are many points long: a dot that moves is seen.
const DOT_GRID: f64 = 4.0;

/// The part of the distance to the rim of its star that a dot may fill: its polygon reaches a little beyond its circle.
const STAR_FILL: f64 = 0.99 / POLYGON_REACH;

/// Traces, smooths and assembles the marks of a labelled triangulation over a canvas of `width` x `height` pixels.
///
/// `cell_areas` holds the area of every node's cell in px^2; a stipple gets `stipple_scale` times as much.
///
/// # Errors
/// [`Error::Input`] if labels, components or areas do not match the nodes, a label is not 0 or 1, or an area is not finite or below
/// 0; [`Error::Cancelled`].
pub fn outline(
    triangulation: &Triangulation,
    labels: &[u8],
    components: &Components,
    cell_areas: &[f64],
    (width, height): (usize, usize),
    shaping: Shaping,
    control: &Control,
) -> Result<Outlines> {
    let count = triangulation.graph.sites.len();
    for (what, length) in [("labels", labels.len()), ("component ids", components.ids.len()), ("cell areas", cell_areas.len())] {
        if length != count {
            return Err(Error::Input(format!("there are {length} {what} for {count} nodes, but every node needs one")));
        }
    }
    if let Some(i) = labels.iter().position(|label| *label > 1) {
        return Err(Error::Input(format!("the label of node {i} is {}, but it must be 0 (black) or 1 (white)", labels[i])));
    }
    if let Some(i) = cell_areas.iter().position(|area| !(*area >= 0.0 && area.is_finite())) {
        return Err(Error::Input(format!("the cell area of node {i} is {}, but it must be at least 0 px^2", cell_areas[i])));
    }
    let frame = Frame { width: width as f64, height: height as f64 };
    let chains = trace(triangulation, labels, components)?;
    control.report(0.3)?;

    let mut chains_of = vec![0u32; components.sizes.len()];
    for chain in &chains.chains {
        chains_of[chain.black as usize] += 1;
        chains_of[chain.white as usize] += 1;
    }
    // A dot needs something around it: one chain over two edges or more, whose far ends are then joined to each other.
    let is_dot = |component: u32, chain: &Chain| {
        components.sizes[component as usize] == 1 && chains_of[component as usize] == 1 && chain.edges.len() >= 2
    };
    let fit = Fit::new(shaping.tolerance, count as f64 / (frame.width * frame.height), frame);
    let shape_of = |chain: &Chain| -> Result<Shape> {
        control.check()?;
        let edges = &chains.edges[chain.edges.clone()];
        let site = |node: u32| point(triangulation.graph.sites[node as usize]);
        let crossing_edges: Vec<CrossingEdge> = edges.iter().map(|[black, white]| [site(*black), site(*white)]).collect();
        let dot = [(chain.black, chain.white), (chain.white, chain.black)].into_iter().find(|(own, _)| is_dot(*own, chain));
        let Some((own, around)) = dot else {
            return Ok(Shape::Curve(fit.curve(&crossing_edges, chain.ends)));
        };
        let own_is_black = own == chain.black;
        let node = edges[0][usize::from(!own_is_black)] as usize;
        let star =
            Star { rim: crossing_edges.iter().map(|edge| edge[usize::from(own_is_black)]).collect(), ends: chain.ends, frame };
        let wanted = (cell_areas[node] * shaping.stipple_scale / PI).sqrt().max(MIN_RADIUS);
        let stipple = star.dot(point(triangulation.graph.sites[node]), wanted, fit.units * DOT_GRID, Ink::of_label(labels[node]));
        Ok(Shape::Dot { stipple, own, around })
    };
    let shapes = chains.chains.par_iter().map(shape_of).collect::<Result<Vec<Shape>>>()?;
    control.report(0.8)?;

    let mut vertices = 0;
    let mut parts = Parts { width, height, units: fit.units, inks: vec![Ink::White; components.sizes.len()], ..Parts::default() };
    let mut is_stipple = vec![false; components.sizes.len()];
    for (chain, shape) in chains.chains.iter().zip(shapes) {
        match shape {
            Shape::Dot { stipple, own, around } => {
                vertices += 1;
                is_stipple[own as usize] = true;
                parts.stipples.push((stipple, [own, around]));
            }
            Shape::Curve(path) => {
                vertices += chain.edges.len();
                parts.curves.push((path, [chain.black, chain.white]));
            }
        }
    }
    for (component, label) in components.ids.iter().zip(labels) {
        parts.inks[*component as usize] = Ink::of_label(*label);
    }
    parts.on_frame = owner_of_frame(triangulation, components, &is_stipple);
    Ok(Outlines { drawing: assemble(parts)?, vertices })
}

/// What is drawn for a chain.
enum Shape {
    /// The component on one side is a dot, `around` the one on the other.
    Dot { stipple: Stipple, own: u32, around: u32 },
    /// A shared curve.
    Curve(kurbo::BezPath),
}

/// The component that holds the frame when no curve ends on it.
fn owner_of_frame(triangulation: &Triangulation, components: &Components, is_stipple: &[bool]) -> u32 {
    let graph = &triangulation.graph;
    let at_frame = (0..graph.sites.len()).filter(|i| {
        let row = graph.offsets[*i] as usize..graph.offsets[*i + 1] as usize;
        row.into_iter().any(|slot| matches!(triangulation.left(slot), Beside::Frame(_)))
    });
    at_frame.map(|i| components.ids[i]).find(|id| !is_stipple[*id as usize]).unwrap_or(0)
}

fn point(p: [f64; 2]) -> Point {
    Point::new(p[0], p[1])
}

/// A boundary between two components.
struct Chain {
    /// The component on its left.
    black: u32,
    /// The component on its right.
    white: u32,
    /// For an open chain, the sides of the frame on which it begins and ends.
    ends: Option<[Side; 2]>,
    /// Its crossing edges, in order, in [`Chains::edges`].
    edges: std::ops::Range<usize>,
}

struct Chains {
    chains: Vec<Chain>,
    /// Crossing edges as (black node, white node).
    edges: Vec<[u32; 2]>,
}

/// Finds all chains: open ones first, then closed ones, each in the order of the edges that they begin with.
fn trace(triangulation: &Triangulation, labels: &[u8], components: &Components) -> Result<Chains> {
    let graph = &triangulation.graph;
    let mut visited = vec![false; graph.neighbors.len()];
    let mut chains = Chains { chains: Vec::new(), edges: Vec::new() };
    let lost = || Error::Internal("a boundary runs along an edge that is not there".into());
    for open in [true, false] {
        for black in (0..graph.sites.len()).filter(|i| labels[*i] == 0) {
            let row = graph.offsets[black] as usize..graph.offsets[black + 1] as usize;
            if open && !row.clone().any(|slot| matches!(triangulation.left(slot), Beside::Frame(_))) {
                continue;
            }
            for first in row {
                let white = graph.neighbors[first];
                if labels[white as usize] == 0 || visited[first] {
                    continue;
                }
                let begin = if open {
                    let behind = triangulation.slot(white, black as u32).ok_or_else(lost)?;
                    match triangulation.left(behind) {
                        Beside::Frame(side) => Some(side),
                        Beside::Node(_) => continue,
                    }
                } else {
                    None
                };
                let start = chains.edges.len();
                let (mut slot, mut edge) = (first, [black as u32, white]);
                let end = loop {
                    visited[slot] = true;
                    chains.edges.push(edge);
                    match triangulation.left(slot) {
                        Beside::Frame(side) => break Some(side),
                        Beside::Node(third) if labels[third as usize] == 0 => edge[0] = third,
                        Beside::Node(third) => edge[1] = third,
                    }
                    slot = triangulation.slot(edge[0], edge[1]).ok_or_else(lost)?;
                    if slot == first {
                        break None;
                    }
                };
                let ends = match (begin, end) {
                    (Some(begin), Some(end)) => Some([begin, end]),
                    (None, None) => None,
                    _ => return Err(Error::Internal("a boundary has one end only".into())),
                };
                chains.chains.push(Chain {
                    black: components.ids[black],
                    white: components.ids[white as usize],
                    ends,
                    edges: start..chains.edges.len(),
                });
            }
        }
    }
    Ok(chains)
}

/// The triangles around the node of a dot.
struct Star {
    /// The nodes around it, in order.
    rim: Vec<Point>,
    /// Where it meets the frame, the sides of the first and the last of them.
    ends: Option<[Side; 2]>,
    frame: Frame,
}

impl Star {
    /// The dot of a node at `site` that would like to have the radius `wanted`.
    fn dot(&self, site: Point, wanted: f64, units: f64, ink: Ink) -> Stipple {
        // Away from the frame as far as the whole dot needs; the circle around the site within its reach is inside the star.
        let Frame { width, height } = self.frame;
        let room = wanted / STAR_FILL;
        let inwards = |v: f64, length: f64| if 2.0 * room < length { v.clamp(room, length - room) } else { length / 2.0 };
        let inner = Point::new(inwards(site.x, width), inwards(site.y, height));
        let reach = self.to_rim(site);
        let mut best: Option<Stipple> = None;
        for part in [1.0, 0.5, 0.25, 0.0] {
            let centre = site.lerp(inner, part);
            if part > 0.0 && (centre == site || (centre - site).hypot2().sqrt() > 0.8 * reach) {
                continue;
            }
            let dot = self.fitting(centre, wanted, units, ink);
            if best.as_ref().is_none_or(|best| dot.radius > best.radius) {
                best = Some(dot);
            }
        }
        best.unwrap_or_else(|| Stipple::on_grid(site, wanted.min(self.reach(site)), units, ink))
    }

    /// The largest dot around `centre`, of a radius up to `wanted`, on the coarsest grid that costs it next to nothing.
    fn fitting(&self, centre: Point, wanted: f64, units: f64, ink: Ink) -> Stipple {
        let possible = wanted.min(self.reach(centre));
        let mut dot = Stipple::on_grid(centre, possible, units, ink);
        for finer in FINER_GRIDS {
            // Rounding moves the centre: what is left there, and a little less for moving again.
            dot = Stipple::on_grid(centre, possible, units * finer, ink);
            for _ in 0..3 {
                let left = self.reach(Point::new(dot.x, dot.y));
                if dot.radius <= left {
                    break;
                }
                dot = Stipple::on_grid(centre, left * 0.99, units * finer, ink);
            }
            if dot.radius >= 0.97 * possible && dot.radius <= self.reach(Point::new(dot.x, dot.y)) {
                break;
            }
        }
        dot
    }

    /// The largest radius of a dot around a point inside the star.
    fn reach(&self, centre: Point) -> f64 {
        let Frame { width, height } = self.frame;
        let frame = centre.x.min(width - centre.x).min(centre.y).min(height - centre.y);
        STAR_FILL * self.to_rim(centre).min(frame)
    }

    fn to_rim(&self, centre: Point) -> f64 {
        let mut reach = f64::INFINITY;
        let mut limit = |a: Point, b: Point| reach = reach.min(distance_to_segment(centre, a, b));
        for pair in self.rim.windows(2) {
            limit(pair[0], pair[1]);
        }
        let (first, last) = (self.rim[0], self.rim[self.rim.len() - 1]);
        match self.ends {
            None => limit(last, first),
            Some([begin, end]) => {
                limit(first, self.frame.project(first, begin));
                limit(last, self.frame.project(last, end));
            }
        }
        reach
    }
}
