//! Outlines: from labelled nodes to the marks of a drawing, after the paper.
//!
//! # The idea
//! Every triangle whose nodes carry both labels is crossed by exactly one piece of one boundary, from the midpoint of one of its
//! crossing edges to that of the other. The pieces join to *chains*: closed ones, and open ones that begin and end on the frame.
//! A chain with black on its left is the boundary between exactly two components, so it is smoothed once and shared by both.
//!
//! # Why curves never cross
//! The smoothed chain is a uniform quadratic B-spline whose control points are the edge midpoints. Its pieces join in the
//! middle between two midpoints, inside a triangle, and piece i runs from one triangle to the next across edge i. As long as the
//! chord of a piece crosses that edge between its two nodes, the whole piece lies in those two triangles, which no other
//! chain enters. So disjoint, simple curves follow from a test on each piece alone; a piece that fails it is drawn as
//! a tighter corner at the same midpoint. (The paper's own splines have no such guarantee.)
//!
//! # At the frame
//! An open chain leaves through the edge between two sites whose cells both touch the frame, and goes straight to it, as the
//! spline through the mirrored midpoints would. So curves meet the frame at a right angle, and nothing is drawn outside.
//!
//! # Stipples
//! A component of one node is a dot with the area of the node's cell, shrunk until it stays inside the star of the node's
//! triangles, where no other curve runs. A node that cuts the canvas in two (its boundary is more than one chain) is a region.

use std::f64::consts::PI;

use kurbo::{BezPath, Point, Shape as _, Vec2};
use rayon::prelude::*;

use crate::components::Components;
use crate::control::Control;
use crate::drawing::{
    Drawing, FLATTENING_TOLERANCE, Ink, Mark, POLYGON_REACH, Region, Ring, RingPart, Stipple, circle_polygon, signed_area,
};
use crate::error::{Error, Result};
use crate::triangulation::{Beside, Side, Triangulation};

/// What the outline stage makes.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlines {
    /// The drawing; its provenance is left empty.
    pub drawing: Drawing,
    /// See [`crate::drawing::Stats::vertices`].
    pub vertices: usize,
}

/// A closed loop below this area, in px^2, is rescaled to the area of its polygon of midpoints: the spline shrinks such small
/// loops by 5 % and more, which would lighten or darken textures made of them. Larger loops lose less than a dot prints.
const RESCALED_LOOP_AREA: f64 = 20.0;

/// How near to the end of an edge a piece may cross it, as a fraction of its length. Smaller would allow slivers that
/// vanish when coordinates are rounded; larger would turn more corners sharp.
const EDGE_CLEARANCE: f64 = 0.05;

/// The least radius that a dot would like to have, in pixels, for nodes so dense that no sample fell to their cell: the dot stays a
/// mark with an area, and is too small to print.
const MIN_RADIUS: f64 = 1.0 / 1024.0;

/// The part of the distance to the rim of its star that a dot may fill: its polygon reaches a little beyond its circle.
const STAR_FILL: f64 = 0.99 / POLYGON_REACH;

/// Traces, smooths and assembles the marks of a labelled triangulation over a canvas of `width` x `height` pixels.
///
/// `cell_areas` holds the area of every node's cell in px^2; a stipple gets `stipple_scale` times as much.
///
/// # Errors
/// [`Error::Input`] if labels, components or areas do not match the nodes, a label is not 0 or 1, or an area is not finite or below 0;
/// [`Error::Cancelled`].
pub fn outline(
    triangulation: &Triangulation,
    labels: &[u8],
    components: &Components,
    cell_areas: &[f64],
    (width, height): (usize, usize),
    stipple_scale: f64,
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

    let shape_of = |chain: &Chain| -> Result<Shape> {
        control.check()?;
        let edges = &chains.edges[chain.edges.clone()];
        let dot = [(chain.black, chain.white), (chain.white, chain.black)].into_iter().find(|(own, _)| is_dot(*own, chain));
        let Some((own, around)) = dot else {
            let path = smooth(triangulation, chain, edges, frame);
            let area = if chain.ends.is_none() { path.area() } else { 0.0 };
            return Ok(Shape::Curve { path, area });
        };
        let node = if own == chain.black { edges[0][0] } else { edges[0][1] } as usize;
        let star = Star { triangulation, chain, edges, own_is_black: own == chain.black, frame };
        let site = triangulation.graph.sites[node];
        let stipple = Stipple {
            x: site[0],
            y: site[1],
            radius: star.radius((cell_areas[node] * stipple_scale / PI).sqrt().max(MIN_RADIUS), site),
            ink: Ink::of_label(labels[node]),
            component: own,
            level: 0,
        };
        Ok(Shape::Dot { stipple, around })
    };
    let shapes = chains.chains.par_iter().map(shape_of).collect::<Result<Vec<Shape>>>()?;
    control.report(0.7)?;

    let mut assembly = Assembly::new(frame, components.sizes.len());
    let mut drawing = Drawing { width, height, ..Drawing::default() };
    let mut vertices = 0;
    for (chain, shape) in chains.chains.iter().zip(shapes) {
        match shape {
            Shape::Dot { stipple, around } => {
                assembly.add_stipple(drawing.stipples.len() as u32, &stipple, around);
                drawing.stipples.push(stipple);
                vertices += 1;
            }
            Shape::Curve { path, area } => {
                vertices += chain.edges.len();
                assembly.add_curve(drawing.curves.len() as u32, &path, area, chain);
                drawing.curves.push(path);
            }
        }
    }
    control.report(0.8)?;
    assembly.finish(&mut drawing, triangulation, labels, components)?;
    Ok(Outlines { drawing, vertices })
}

/// What is drawn for a chain.
enum Shape {
    /// The component on one side is a dot, `around` the one on the other.
    Dot { stipple: Stipple, around: u32 },
    /// A shared curve with the area that it encloses, if it is closed.
    Curve { path: BezPath, area: f64 },
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

/// The frame of the canvas, and positions along it.
#[derive(Debug, Clone, Copy)]
struct Frame {
    width: f64,
    height: f64,
}

impl Frame {
    /// The foot of a point on a side.
    fn project(self, p: Point, side: Side) -> Point {
        match side {
            Side::Top => Point::new(p.x, 0.0),
            Side::Right => Point::new(self.width, p.y),
            Side::Bottom => Point::new(p.x, self.height),
            Side::Left => Point::new(0.0, p.y),
        }
    }

    fn perimeter(self) -> f64 {
        2.0 * (self.width + self.height)
    }

    /// Distance along the frame from the corner (0, 0), in the positive direction: top, right, bottom, left.
    fn position(self, p: [f64; 2]) -> f64 {
        if p[1] <= 0.0 {
            p[0]
        } else if p[0] >= self.width {
            self.width + p[1]
        } else if p[1] >= self.height {
            self.width + self.height + (self.width - p[0])
        } else {
            2.0 * self.width + self.height + (self.height - p[1])
        }
    }

    /// The corners strictly between two positions, in the positive direction from the first to the second.
    fn corners_between(self, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
        let (w, h) = (self.width, self.height);
        let corners = [(0.0, [0.0, 0.0]), (w, [w, 0.0]), (w + h, [w, h]), (2.0 * w + h, [0.0, h])];
        let around = self.perimeter();
        let twice = corners.into_iter().chain(corners.map(|(at, corner)| (at + around, corner)));
        twice.filter(move |(at, _)| *at > from && *at < to).map(|(_, corner)| corner)
    }

    /// Distances of a point from the four sides, in the order top, right, bottom, left.
    fn distances(self, p: [f64; 2]) -> [f64; 4] {
        [p[1], self.width - p[0], self.height - p[1], p[0]]
    }
}

fn point(p: [f64; 2]) -> Point {
    Point::new(p[0], p[1])
}

/// Twice the signed area of the triangle a, b, c: positive when c lies to the left of a to b.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b - a).cross(c - a)
}

/// Where the segment from p to q crosses the line through u and v, as a fraction of the way from u to v.
fn crossing(p: Point, q: Point, u: Point, v: Point) -> f64 {
    let (from, to) = (turn(p, q, u), turn(p, q, v));
    // Parallel: nowhere.
    if from == to { f64::INFINITY } else { from / (from - to) }
}

/// Whether a fraction along an edge keeps clear of its ends.
fn clear(fraction: f64) -> bool {
    (EDGE_CLEARANCE..=1.0 - EDGE_CLEARANCE).contains(&fraction)
}

/// A chain's geometry before smoothing: controls and joints in turn.
struct Polyline {
    /// Midpoint of every crossing edge.
    controls: Vec<Point>,
    /// `joints[i]` is where piece i begins and `joints[i + 1]` where it ends; for a closed chain the last is the first again.
    joints: Vec<Point>,
}

/// The spline of a chain; see the module's text for why it stays in its triangles.
fn smooth(triangulation: &Triangulation, chain: &Chain, edges: &[[u32; 2]], frame: Frame) -> BezPath {
    let site = |node: u32| point(triangulation.graph.sites[node as usize]);
    let controls: Vec<Point> = edges.iter().map(|[a, b]| site(*a).midpoint(site(*b))).collect();
    let last = controls[controls.len() - 1];
    let mut joints = Vec::with_capacity(controls.len() + 1);
    joints.push(match chain.ends {
        Some([begin, _]) => frame.project(controls[0], begin),
        None => last.midpoint(controls[0]),
    });
    joints.extend(controls.windows(2).map(|pair| pair[0].midpoint(pair[1])));
    joints.push(match chain.ends {
        Some([_, end]) => frame.project(last, end),
        None => joints[0],
    });
    let mut line = Polyline { controls, joints };
    if chain.ends.is_none() {
        rescale(&mut line, edges, site);
    }

    let mut path = BezPath::with_capacity(edges.len() + 2);
    path.move_to(line.joints[0]);
    for (i, [a, b]) in edges.iter().enumerate() {
        let (from, control, to) = (line.joints[i], line.controls[i], line.joints[i + 1]);
        let off = (crossing(from, to, site(*a), site(*b)) - 0.5).abs();
        let limit = 0.5 - EDGE_CLEARANCE;
        if off <= limit {
            path.quad_to(control, to);
        } else {
            // Towards the control point the crossing moves to the middle of the edge in proportion.
            let tightness = if off.is_finite() { limit / off } else { 0.0 };
            path.line_to(control + (from - control) * tightness);
            path.quad_to(control, control + (to - control) * tightness);
            path.line_to(to);
        }
    }
    if chain.ends.is_none() {
        path.close_path();
    }
    path
}

/// Scales a small closed loop about its middle so that the spline has the area of the polygon of its midpoints, if every piece
/// then still lies in its two triangles.
fn rescale(line: &mut Polyline, edges: &[[u32; 2]], site: impl Fn(u32) -> Point) {
    let n = line.controls.len();
    let polygon: Vec<[f64; 2]> = line.controls.iter().map(|p| [p.x, p.y]).collect();
    let area = signed_area(&polygon).abs();
    if area >= RESCALED_LOOP_AREA {
        return;
    }
    // A quadratic piece encloses two thirds of its control triangle with its chord.
    let chords: Vec<[f64; 2]> = line.joints[..n].iter().map(|p| [p.x, p.y]).collect();
    let bulges: f64 = (0..n).map(|i| turn(line.joints[i], line.controls[i], line.joints[i + 1]) / 3.0).sum();
    let spline = (signed_area(&chords) + bulges).abs();
    let factor = (area / spline).sqrt();
    if !(factor > 1.0 && factor < 1.5) {
        return;
    }
    let middle = (line.controls.iter().fold(Vec2::ZERO, |sum, p| sum + p.to_vec2()) / n as f64).to_point();
    let scaled = |p: &Point| middle + (*p - middle) * factor;
    let controls: Vec<Point> = line.controls.iter().map(scaled).collect();
    let joints: Vec<Point> = line.joints.iter().map(scaled).collect();

    let triangle = |i: usize| {
        let ([a, b], next) = (edges[i % n], edges[(i + 1) % n]);
        let third = if next[0] == a { next[1] } else { next[0] };
        [site(a), site(b), site(third)]
    };
    let inside = |p: Point, [a, b, c]: [Point; 3]| turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0;
    let fits = (0..n).all(|i| {
        let (before, after) = (triangle(i + n - 1), triangle(i));
        let (from, control, to) = (joints[i], controls[i], joints[i + 1]);
        let (a, b) = (site(edges[i][0]), site(edges[i][1]));
        inside(to, after)
            && clear(crossing(from, to, a, b))
            && (inside(control, after) && clear(crossing(from, control, a, b))
                || inside(control, before) && clear(crossing(to, control, a, b)))
    });
    if fits {
        *line = Polyline { controls, joints };
    }
}

/// The triangles around a lone node.
struct Star<'a> {
    triangulation: &'a Triangulation,
    chain: &'a Chain,
    edges: &'a [[u32; 2]],
    own_is_black: bool,
    frame: Frame,
}

impl Star<'_> {
    /// The radius of a dot at `site` that would like to be `wanted`: it stays inside the star, and crosses the frame clearly, in
    /// one piece, or not at all.
    fn radius(&self, wanted: f64, site: [f64; 2]) -> f64 {
        let rim = |edge: &[u32; 2]| point(self.triangulation.graph.sites[edge[usize::from(self.own_is_black)] as usize]);
        let mut reach = f64::INFINITY;
        let mut limit = |a: Point, b: Point| reach = reach.min(distance_to_segment(point(site), a, b));
        for pair in self.edges.windows(2) {
            limit(rim(&pair[0]), rim(&pair[1]));
        }
        let (first, last) = (rim(&self.edges[0]), rim(&self.edges[self.edges.len() - 1]));
        match self.chain.ends {
            None => limit(last, first),
            Some([begin, end]) => {
                limit(first, self.frame.project(first, begin));
                limit(last, self.frame.project(last, end));
            }
        }
        self.fit_to_frame(wanted.min(reach * STAR_FILL), site)
    }

    /// Shrinks a radius until each side of the frame is either out of reach of any polygon of the circle or well inside every one of
    /// them, and the part inside the canvas is one piece. Then how finely the circle is drawn does not change what it touches.
    fn fit_to_frame(&self, mut radius: f64, site: [f64; 2]) -> f64 {
        /// Every polygon of a circle covers at least this part of its radius.
        const COVERED: f64 = 0.92;
        let distances = self.frame.distances(site);
        loop {
            let touched = |d: f64| d < radius * POLYGON_REACH;
            let unclear = distances.iter().copied().filter(|d| touched(*d) && *d > radius * COVERED);
            let apart = (0..4).filter_map(|k| {
                let (d, next, opposite) = (distances[k], distances[(k + 1) % 4], distances[(k + 2) % 4]);
                // Two sides that meet are one piece if the dot covers their corner.
                let corner = touched(d) && touched(next) && (d * d + next * next).sqrt() > radius * COVERED;
                let across = touched(d) && touched(opposite);
                if corner {
                    Some(d.max(next))
                } else if across {
                    Some(d.max(opposite))
                } else {
                    None
                }
            });
            match unclear.chain(apart).reduce(f64::min) {
                // A little less than the distance, so that the loop ends.
                Some(distance) => radius = distance / POLYGON_REACH * 0.999,
                None => return radius,
            }
        }
    }
}

fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.hypot2()).clamp(0.0, 1.0);
    // Both ends in one place: the fraction is not a number.
    let nearest = if t.is_nan() { a } else { a + along * t };
    // Not `distance`, whose hypot may differ between platforms in the last bit.
    (p - nearest).hypot2().sqrt()
}

/// A piece of boundary on its way into rings: a curve or the outline of a stipple.
struct Piece {
    /// As the component on its left runs along it; `None` for a stipple, which needs no ring of its own.
    forward: Option<RingPart>,
    /// As the component on its right runs along it.
    backward: RingPart,
    left: u32,
    right: u32,
}

/// Where an open piece meets the frame.
struct End {
    position: f64,
    piece: u32,
    /// Whether the piece begins here.
    begins: bool,
}

/// Puts the pieces together to rings, and the rings to regions.
struct Assembly {
    frame: Frame,
    pieces: Vec<Piece>,
    ends: Vec<End>,
    /// Of closed pieces: the piece, and the area that it encloses in its own direction.
    closed: Vec<(u32, f64)>,
    /// Of every component that is a dot: its area inside the canvas, and whether the frame cuts it.
    dots: Vec<Option<(f64, bool)>>,
}

impl Assembly {
    fn new(frame: Frame, components: usize) -> Self {
        Self { frame, pieces: Vec::new(), ends: Vec::new(), closed: Vec::new(), dots: vec![None; components] }
    }

    fn add(&mut self, piece: Piece, open: Option<[[f64; 2]; 2]>, area: impl FnOnce() -> f64) {
        let number = self.pieces.len() as u32;
        match open {
            Some(ends) => {
                for (end, begins) in ends.into_iter().zip([true, false]) {
                    self.ends.push(End { position: self.frame.position(end), piece: number, begins });
                }
            }
            None => self.closed.push((number, area())),
        }
        self.pieces.push(piece);
    }

    fn add_curve(&mut self, index: u32, path: &BezPath, area: f64, chain: &Chain) {
        let ends = |_| {
            let first = path.elements().first().and_then(kurbo::PathEl::end_point)?;
            let last = path.elements().last().and_then(kurbo::PathEl::end_point)?;
            Some([[first.x, first.y], [last.x, last.y]])
        };
        let piece = Piece {
            forward: Some(RingPart::Curve { index, reversed: false }),
            backward: RingPart::Curve { index, reversed: true },
            left: chain.black,
            right: chain.white,
        };
        self.add(piece, chain.ends.and_then(ends), || area);
    }

    fn add_stipple(&mut self, index: u32, stipple: &Stipple, around: u32) {
        let canvas = [self.frame.width, self.frame.height];
        let outline = circle_polygon([stipple.x, stipple.y], stipple.radius, canvas, FLATTENING_TOLERANCE);
        let reach = stipple.radius * POLYGON_REACH;
        let cut = self.frame.distances([stipple.x, stipple.y]).iter().any(|d| *d < reach);
        self.dots[stipple.component as usize] = Some((signed_area(&outline), cut));
        let piece = Piece { forward: None, backward: RingPart::Stipple { index }, left: stipple.component, right: around };
        self.add(piece, cut.then(|| [outline[0], outline[outline.len() - 1]]), || signed_area(&outline));
    }

    /// The component that holds the frame when no piece ends on it.
    fn owner_of_frame(&self, triangulation: &Triangulation, components: &Components) -> u32 {
        let graph = &triangulation.graph;
        let at_frame = (0..graph.sites.len()).filter(|i| {
            let row = graph.offsets[*i] as usize..graph.offsets[*i + 1] as usize;
            row.into_iter().any(|slot| matches!(triangulation.left(slot), Beside::Frame(_)))
        });
        at_frame.map(|i| components.ids[i]).find(|id| self.dots[*id as usize].is_none()).unwrap_or(0)
    }

    fn finish(
        mut self,
        drawing: &mut Drawing,
        triangulation: &Triangulation,
        labels: &[u8],
        components: &Components,
    ) -> Result<()> {
        let count = components.sizes.len();
        // What is known of a component's region so far: its outer boundary with the area inside, and its holes.
        let mut exteriors: Vec<Option<(Ring, f64)>> = vec![None; count];
        let mut holes: Vec<Vec<Ring>> = vec![Vec::new(); count];
        // The component around a component; none for one that touches the frame.
        let mut container: Vec<Option<u32>> = vec![None; count];

        for (component, ring) in self.frame_rings(triangulation, components)? {
            let area = drawing.ring_path(&ring, FLATTENING_TOLERANCE).area();
            exteriors[component as usize] = Some((ring, area));
        }
        for &(number, area) in &self.closed {
            let piece = &self.pieces[number as usize];
            // Positive: the left component is inside, and this is its exterior.
            let (inner, inner_part, outer, outer_part) = if area > 0.0 {
                (piece.left, piece.forward, piece.right, Some(piece.backward))
            } else {
                (piece.right, Some(piece.backward), piece.left, piece.forward)
            };
            container[inner as usize] = Some(outer);
            if let Some(part) = inner_part {
                exteriors[inner as usize] = Some((Ring { parts: vec![part] }, area.abs()));
            }
            if let Some(part) = outer_part {
                holes[outer as usize].push(Ring { parts: vec![part] });
            }
        }
        for piece in self.pieces.iter().filter(|piece| piece.forward.is_none()) {
            container[piece.left as usize] = Some(piece.right);
            // A dot that the frame cuts lies outside the ring of what surrounds it, but is painted over it all the same.
            if let (Some((area, true)), Some((_, enclosed))) =
                (self.dots[piece.left as usize], &mut exteriors[piece.right as usize])
            {
                *enclosed += area;
            }
        }

        let mut ink = vec![Ink::White; count];
        for (node, component) in components.ids.iter().enumerate() {
            ink[*component as usize] = Ink::of_label(labels[node]);
        }
        for component in (0..count).filter(|c| self.dots[*c].is_none()) {
            let (exterior, enclosed_area) = exteriors[component]
                .take()
                .ok_or_else(|| Error::Internal(format!("component {component} has no outer boundary")))?;
            drawing.regions.push(Region {
                ink: ink[component],
                component: component as u32,
                level: 0,
                enclosed_area,
                exterior,
                holes: std::mem::take(&mut holes[component]),
            });
        }
        drawing.stipples.sort_by_key(|s| s.component);
        self.renumber_stipples(drawing);
        self.order(drawing, &container)
    }

    /// Stipples were numbered as their chains came; rings name them by their place in the sorted list.
    fn renumber_stipples(&mut self, drawing: &mut Drawing) {
        let mut component_of = vec![0u32; drawing.stipples.len()];
        for piece in &self.pieces {
            if let (None, RingPart::Stipple { index }) = (piece.forward, piece.backward) {
                component_of[index as usize] = piece.left;
            }
        }
        let stipples = &drawing.stipples;
        for ring in drawing.regions.iter_mut().flat_map(|r| std::iter::once(&mut r.exterior).chain(&mut r.holes)) {
            for part in &mut ring.parts {
                if let RingPart::Stipple { index } = part {
                    let component = component_of[*index as usize];
                    // Every stipple of a ring is in the list, which is sorted.
                    *index = stipples.partition_point(|s| s.component < component) as u32;
                }
            }
        }
    }

    /// The rings of the components that touch the frame.
    fn frame_rings(&mut self, triangulation: &Triangulation, components: &Components) -> Result<Vec<(u32, Ring)>> {
        let mut rings = Vec::new();
        if self.ends.is_empty() {
            let corners = self.frame.corners_between(-1.0, self.frame.perimeter()).map(|[x, y]| RingPart::Corner(x, y));
            rings.push((self.owner_of_frame(triangulation, components), Ring { parts: corners.collect() }));
            return Ok(rings);
        }
        self.ends.sort_by(|a, b| a.position.total_cmp(&b.position).then(a.piece.cmp(&b.piece)));
        let count = self.ends.len();
        // Where the other end of every end is.
        let mut places = vec![[0usize; 2]; self.pieces.len()];
        for (k, end) in self.ends.iter().enumerate() {
            places[end.piece as usize][usize::from(!end.begins)] = k;
        }
        // The component on the frame just after an end, in the positive direction, and just before it.
        let sides = |end: &End| {
            let piece = &self.pieces[end.piece as usize];
            if end.begins { (piece.right, piece.left) } else { (piece.left, piece.right) }
        };
        let mut walked = vec![false; count];
        for first in 0..count {
            let (component, _) = sides(&self.ends[first]);
            if walked[first] || self.dots[component as usize].is_some() {
                continue;
            }
            let mut parts = Vec::new();
            let mut k = first;
            while !walked[k] {
                walked[k] = true;
                let next = (k + 1) % count;
                let lap = if next == 0 { self.frame.perimeter() } else { 0.0 };
                let corners = self.frame.corners_between(self.ends[k].position, self.ends[next].position + lap);
                parts.extend(corners.map(|[x, y]| RingPart::Corner(x, y)));
                let end = &self.ends[next];
                if sides(end).1 != component {
                    return Err(Error::Internal(format!(
                        "components {component} and {} meet on the frame without a boundary",
                        sides(end).1
                    )));
                }
                let piece = &self.pieces[end.piece as usize];
                if end.begins {
                    parts.extend(piece.forward);
                } else {
                    parts.push(piece.backward);
                }
                k = places[end.piece as usize][usize::from(end.begins)];
            }
            rings.push((component, Ring { parts }));
        }
        Ok(rings)
    }

    /// Areas, the layered order and the levels.
    fn order(&self, drawing: &mut Drawing, container: &[Option<u32>]) -> Result<()> {
        let regions = drawing.regions.iter().enumerate().map(|(i, r)| (r.enclosed_area, r.component, Mark::Region(i as u32)));
        let dot_area = |s: &Stipple| self.dots[s.component as usize].map_or(0.0, |dot| dot.0);
        let stipples = drawing.stipples.iter().enumerate().map(|(i, s)| (dot_area(s), s.component, Mark::Stipple(i as u32)));
        let mut order: Vec<(f64, u32, Mark)> = regions.chain(stipples).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        drawing.order = order.iter().map(|(_, _, mark)| *mark).collect();

        const UNKNOWN: u32 = u32::MAX;
        let mut levels = vec![UNKNOWN; container.len()];
        for (_, component, mark) in &order {
            let ink = match mark {
                Mark::Region(i) => drawing.regions[*i as usize].ink,
                Mark::Stipple(i) => drawing.stipples[*i as usize].ink,
            };
            let level = match container[*component as usize] {
                None => u32::from(ink == Ink::Black),
                Some(around) => levels[around as usize].wrapping_add(1),
            };
            if level == 0 && container[*component as usize].is_some() {
                return Err(Error::Internal(format!("component {component} comes before the one around it")));
            }
            levels[*component as usize] = level;
            match mark {
                Mark::Region(i) => drawing.regions[*i as usize].level = level,
                Mark::Stipple(i) => drawing.stipples[*i as usize].level = level,
            }
        }
        Ok(())
    }
}
