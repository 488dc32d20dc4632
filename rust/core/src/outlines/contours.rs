//! Contours: from labelled nodes to the curves and dots of a drawing, after the paper.
//!
//! # The idea
//! Every triangle whose nodes carry both labels is crossed by exactly one piece of one boundary, from a point on one of its crossing
//! edges to one on the other: the midpoints, or where the tone between the nodes passes middle grey. The pieces join to *chains*:
//! closed ones, and open ones that begin and end on the frame.
//! A chain with black on its left is the boundary between exactly two components, so its curve (see [`super::fit`]) is made once
//! and shared by both.
//!
//! # At the frame
//! An open chain leaves through the edge between two sites whose cells both touch the frame, and goes straight to it, as the
//! spline through the mirrored crossings would. So curves meet the frame at a right angle, and nothing is drawn outside.
//!
//! # Stipples
//! A component of one node is a dot with the area of the node's cell, shrunk until it stays inside the star of the node's
//! triangles, where no other curve runs. At the frame it moves in until all of it is on the canvas. A node that cuts the canvas in
//! two (its boundary is more than one chain) is a region. With irregularity a dot is a closed curve (see [`super::irregular`]).

use std::f64::consts::PI;
use std::ops::Range;

use kurbo::{Point, Vec2};
use rayon::prelude::*;

use crate::base::{Control, Error, Frame, Ink, POLYGON_REACH, Result, Side, distance_to_segment, mixed};
use crate::graph::{Beside, Components, Triangulation, check_areas, check_finite, check_labels, check_one_a_node};
use crate::options::Options;
use crate::outlines::fit::Fit;
use crate::outlines::irregular::{Room, irregular};
use crate::outlines::parts::{Parts, Stipple};
use crate::outlines::sleeve::CrossingEdge;
use crate::outlines::spline::FINER_GRIDS;

/// What the outline stage makes.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlines {
    /// The curves and dots.
    pub parts: Parts,
    /// See [`crate::stages::Stats::vertices`].
    pub vertices: usize,
}

/// What the outlines need to know of every node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nodes<'a> {
    /// 0 black, 1 white.
    pub labels: &'a [u8],
    /// Area of every node's cell in px^2: a stipple gets `stipple_scale` times as much.
    pub areas: &'a [f64],
    /// Tone of every node, for boundaries that follow it; without, they cross edges at their midpoints.
    pub tones: Option<&'a [f32]>,
}

/// How marks are shaped; ranges as in [`crate::Options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaping {
    /// A stipple's area relative to its node's cell.
    pub stipple_scale: f64,
    /// Least radius of a stipple that has room for it, in pixels.
    pub stipple_min: f64,
    /// Largest radius of a stipple, in pixels.
    pub stipple_max: Option<f64>,
    /// How far stipples are from round; above 0 they are curves.
    pub irregularity: f64,
    /// Which irregular shapes they have.
    pub seed: u64,
    /// How far a curve may lie from the spline through the crossings, in pixels.
    pub tolerance: f64,
}

impl Shaping {
    /// What the options say of shapes.
    pub fn of(options: &Options) -> Self {
        let Options { stipple_scale, stipple_min, stipple_max, irregularity, seed, tolerance, .. } = *options;
        Self { stipple_scale, stipple_min, stipple_max, irregularity, seed, tolerance }
    }

    /// The radius that a dot in a cell of this area would like to have, on a grid of `units` to a pixel.
    fn radius(&self, cell_area: f64, units: f64) -> f64 {
        // Rounded down to the grid it must still be large enough.
        let least = MIN_RADIUS.max(self.stipple_min + 0.02 / units);
        (cell_area * self.stipple_scale / PI).sqrt().max(least).min(self.stipple_max.unwrap_or(f64::INFINITY))
    }
}

/// The least radius that a dot would like to have, in pixels, for nodes so dense that no sample fell to their cell: the dot stays a
/// mark with an area, and is too small to print.
const MIN_RADIUS: f64 = 1.0 / 1024.0;

/// How much finer the grid of dots is than that of curves, which are many points long: a dot that moves is seen.
const DOT_GRID: f64 = 4.0;

/// The part of the distance to the rim of its star that the outline of a dot may fill.
const ROOM: f64 = 0.99;

/// The part of it that the radius of a round dot may fill: its polygon reaches a little beyond its circle.
const STAR_FILL: f64 = ROOM / POLYGON_REACH;

/// How near to a node a boundary that follows the tone may come, as a fraction of the edge: nearer, thin slivers would be left
/// between it and the next boundary.
const NEAREST_CROSSING: f64 = 0.2;

/// Where a boundary crosses the edge from a black to a white node, as a fraction of the way, by the tones of both: where the tone in
/// between, going straight from one to the other, is 0.5. So an edge in the photo is drawn where it is, and straight, not from node
/// to node. If the tones do not lie on the sides of 0.5 that their labels are on, diffusion put the boundary there and not the
/// photo: it crosses in the middle.
pub fn crossing(black: f64, white: f64) -> f64 {
    if !(black < 0.5 && white > 0.5) {
        return 0.5;
    }
    ((0.5 - black) / (white - black)).clamp(NEAREST_CROSSING, 1.0 - NEAREST_CROSSING)
}

/// Traces and smooths the marks of a labelled triangulation over a canvas of `width` x `height` pixels.
///
/// # Errors
/// [`Error::Input`] if labels, components, areas or tones do not match the nodes, a label is not 0 or 1, or an area is not finite or
/// below 0; [`Error::Cancelled`].
pub fn outline(
    triangulation: &Triangulation,
    nodes: Nodes,
    components: &Components,
    (width, height): (usize, usize),
    shaping: Shaping,
    control: &Control,
) -> Result<Outlines> {
    let Nodes { labels, areas: cell_areas, tones } = nodes;
    let count = triangulation.graph.sites.len();
    for (what, length) in [
        ("labels", labels.len()),
        ("component ids", components.ids.len()),
        ("cell areas", cell_areas.len()),
        ("tones", tones.map_or(count, <[f32]>::len)),
    ] {
        check_one_a_node(what, length, count)?;
    }
    check_labels(labels)?;
    check_areas("cell area", cell_areas)?;
    check_finite("tone", tones.unwrap_or_default())?;
    let frame = Frame { width: width as f64, height: height as f64 };
    let part = count.div_ceil(PARTS_A_THREAD * rayon::current_num_threads()).max(LEAST_PART);
    let chains = trace(triangulation, labels, components, part)?;
    control.report(0.3)?;

    let mut chains_of = vec![0u32; components.sizes.len()];
    for chain in &chains.chains {
        chains_of[chain.black as usize] += 1;
        chains_of[chain.white as usize] += 1;
    }
    // A dot needs something around it: one chain over two edges or more, whose far ends are then joined to each other.
    let is_dot = |component: u32, chain: &Chain| {
        components.sizes[component as usize] == 1 && chains_of[component as usize] == 1 && chain.edges.1.len() >= 2
    };
    let mut component_areas = vec![0.0; components.sizes.len()];
    for (component, area) in components.ids.iter().zip(cell_areas) {
        component_areas[*component as usize] += area;
    }
    // What a loop around a component without holes should enclose.
    let enclosed = |chain: &Chain| {
        let sides = [chain.black, chain.white].into_iter().filter(|side| chains_of[*side as usize] == 1);
        sides.map(|side| component_areas[side as usize]).min_by(f64::total_cmp).filter(|_| tones.is_some())
    };
    let fit = Fit::new(shaping.tolerance, count as f64 / (frame.width * frame.height), frame);
    let shape_of = |chain: &Chain| -> Result<Shape> {
        control.check()?;
        let edges = chains.edges(chain);
        let site = |node: u32| point(triangulation.graph.sites[node as usize]);
        let crossing_edges: Vec<CrossingEdge> = edges.iter().map(|[black, white]| [site(*black), site(*white)]).collect();
        let dot = [(chain.black, chain.white), (chain.white, chain.black)].into_iter().find(|(own, _)| is_dot(*own, chain));
        let Some((own, around)) = dot else {
            let tone = |tones: &[f32], node: u32| f64::from(tones[node as usize]);
            let at = |[black, white]: [u32; 2]| tones.map_or(0.5, |tones| crossing(tone(tones, black), tone(tones, white)));
            let crossings: Vec<Point> =
                edges.iter().zip(&crossing_edges).map(|(nodes, [black, white])| black.lerp(*white, at(*nodes))).collect();
            return Ok(Shape::Curve { path: fit.curve(&crossing_edges, &crossings, enclosed(chain), chain.ends), dot: None });
        };
        let own_is_black = own == chain.black;
        let node = edges[0][usize::from(!own_is_black)] as usize;
        let star =
            Star { rim: crossing_edges.iter().map(|edge| edge[usize::from(own_is_black)]).collect(), ends: chain.ends, frame };
        let units = fit.units * DOT_GRID;
        let wanted = shaping.radius(cell_areas[node], units);
        let stipple = star.dot(point(triangulation.graph.sites[node]), wanted, units, Ink::of_label(labels[node]));
        if shaping.irregularity > 0.0 {
            let room = star.room(Point::new(stipple.x, stipple.y));
            let key = mixed(mixed(shaping.seed) ^ node as u64);
            if let Some(path) = irregular(&stipple, &room, shaping.irregularity, key, units) {
                return Ok(Shape::Curve { path, dot: Some(own) });
            }
        }
        Ok(Shape::Dot { stipple, own, around })
    };
    let shapes: Vec<Result<Shape>> = chains.chains.par_iter().with_max_len(CHAINS_AT_ONCE).map(shape_of).collect();
    control.report(0.8)?;

    let mut vertices = 0;
    let mut parts = Parts { width, height, units: fit.units, inks: vec![Ink::White; components.sizes.len()], ..Parts::default() };
    let mut drawn_as_dot = vec![false; components.sizes.len()];
    for (chain, shape) in chains.chains.iter().zip(shapes) {
        match shape? {
            Shape::Dot { stipple, own, around } => {
                vertices += 1;
                drawn_as_dot[own as usize] = true;
                parts.stipples.push((stipple, [own, around]));
            }
            Shape::Curve { path, dot } => {
                if let Some(own) = dot {
                    vertices += 1;
                    drawn_as_dot[own as usize] = true;
                } else {
                    vertices += chain.edges.1.len();
                }
                parts.curves.push((path, [chain.black, chain.white]));
            }
        }
    }
    for (component, label) in components.ids.iter().zip(labels) {
        parts.inks[*component as usize] = Ink::of_label(*label);
    }
    parts.on_frame = owner_of_frame(triangulation, components, &drawn_as_dot);
    Ok(Outlines { parts, vertices })
}

/// Chains that a thread shapes before others can take the next: a few are thousands of edges long, so parts of all chains with the
/// same number of them would end far apart.
const CHAINS_AT_ONCE: usize = 32;

/// What is drawn for a chain.
enum Shape {
    /// The component on one side is a dot, `around` the one on the other.
    Dot { stipple: Stipple, own: u32, around: u32 },
    /// A shared curve; `dot` is the component that it is an irregular dot of.
    Curve { path: kurbo::BezPath, dot: Option<u32> },
}

/// The component that holds the frame when no curve ends on it.
fn owner_of_frame(triangulation: &Triangulation, components: &Components, drawn_as_dot: &[bool]) -> u32 {
    let graph = &triangulation.graph;
    let at_frame = (0..graph.sites.len()).filter(|i| {
        let row = graph.offsets[*i] as usize..graph.offsets[*i + 1] as usize;
        row.into_iter().any(|slot| matches!(triangulation.left(slot), Beside::Frame(_)))
    });
    at_frame.map(|i| components.ids[i]).find(|id| !drawn_as_dot[*id as usize]).unwrap_or(0)
}

fn point(p: [f64; 2]) -> Point {
    Point::new(p[0], p[1])
}

/// A boundary between two components.
#[derive(Debug)]
struct Chain {
    /// The component on its left.
    black: u32,
    /// The component on its right.
    white: u32,
    /// For an open chain, the sides of the frame on which it begins and ends.
    ends: Option<[Side; 2]>,
    /// Its crossing edges, in order: which of [`Chains::edges`].
    edges: (usize, Range<usize>),
}

struct Chains {
    chains: Vec<Chain>,
    /// Crossing edges as (black node, white node), those of each part of the nodes.
    edges: Vec<Vec<[u32; 2]>>,
}

impl Chains {
    fn edges(&self, chain: &Chain) -> &[[u32; 2]] {
        let (part, range) = &chain.edges;
        &self.edges[*part][range.clone()]
    }
}

/// Finds all chains: open ones first, then closed ones, each in the order of the edges that they begin with. A closed chain begins
/// with the first of its edges, so every thread finds those that begin in its part of the nodes, of which `size` make one. The
/// chains do not depend on it.
fn trace(triangulation: &Triangulation, labels: &[u8], components: &Components, size: usize) -> Result<Chains> {
    let count = labels.len();
    let parts = (0..count.div_ceil(size)).into_par_iter().map(|part| {
        let nodes = part * size..((part + 1) * size).min(count);
        let mut tracer = Tracer::new(triangulation, labels, components, part, nodes);
        let open = tracer.find_open()?;
        let closed = tracer.find_closed()?;
        Ok((open, closed, tracer.edges))
    });
    let mut found = Chains { chains: Vec::new(), edges: Vec::new() };
    let mut all_closed = Vec::new();
    for (open, closed, edges) in parts.collect::<Result<Vec<_>>>()? {
        found.chains.extend(open);
        all_closed.push(closed);
        found.edges.push(edges);
    }
    found.chains.extend(all_closed.into_iter().flatten());
    Ok(found)
}

/// Nodes of a part at least.
const LEAST_PART: usize = 1 << 14;

/// Some parts have more boundaries than others: with several each, threads end together.
const PARTS_A_THREAD: usize = 4;

/// Finds the chains that begin in one part of the nodes.
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

    /// The open chains.
    fn find_open(&mut self) -> Result<Vec<Chain>> {
        let graph = &self.triangulation.graph;
        let mut chains = Vec::new();
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
                chains.push(self.chain(start, Some([begin, end])));
            }
        }
        Ok(chains)
    }

    /// The closed chains, after the open ones.
    fn find_closed(&mut self) -> Result<Vec<Chain>> {
        let graph = &self.triangulation.graph;
        let mut chains = Vec::new();
        for black in self.nodes.clone().filter(|i| self.labels[*i] == 0) {
            for first in graph.offsets[black] as usize..graph.offsets[black + 1] as usize {
                let white = graph.neighbors[first];
                if self.labels[white as usize] == 0 || self.visited[first - self.slots.start] {
                    continue;
                }
                let start = self.edges.len();
                match self.walk(first, [black as u32, white], false)? {
                    Walked::Around => chains.push(self.chain(start, None)),
                    // It begins in another part.
                    Walked::ToFrame(_) | Walked::FromElsewhere => self.edges.truncate(start),
                }
            }
        }
        Ok(chains)
    }

    /// The chain of the edges from one on.
    fn chain(&self, start: usize, ends: Option<[Side; 2]>) -> Chain {
        let [black, white] = self.edges[start].map(|node| self.components.ids[node as usize]);
        Chain { black, white, ends, edges: (self.part, start..self.edges.len()) }
    }

    /// Walks along a chain from one of its edges, and writes down what it crosses. One that may be closed is left as soon as an edge
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

/// How walking along a chain ended.
enum Walked {
    /// Back where it began.
    Around,
    ToFrame(Side),
    /// Where it is known that the chain begins elsewhere.
    FromElsewhere,
}

fn lost() -> Error {
    Error::Internal("a boundary runs along an edge that is not there".into())
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
        STAR_FILL * self.to_outline(centre)
    }

    /// How far a point inside the star is from its outline, rim and frame.
    fn to_outline(&self, centre: Point) -> f64 {
        let Frame { width, height } = self.frame;
        let frame = centre.x.min(width - centre.x).min(centre.y).min(height - centre.y);
        self.to_rim(centre).min(frame)
    }

    /// What a dot around a point inside the star may fill.
    fn room(&self, centre: Point) -> Room {
        let Frame { width, height } = self.frame;
        let frame = [
            (Vec2::new(1.0, 0.0), width - centre.x),
            (Vec2::new(0.0, 1.0), height - centre.y),
            (Vec2::new(-1.0, 0.0), centre.x),
            (Vec2::new(0.0, -1.0), centre.y),
        ];
        let rim = self.sides().map(|[a, b]| {
            let along = b - a;
            let normal = Vec2::new(-along.y, along.x) / along.hypot2().sqrt();
            let distance = (a - centre).dot(normal);
            if distance < 0.0 { (-normal, -distance) } else { (normal, distance) }
        });
        let sides = rim.chain(frame).map(|(normal, distance)| (normal, ROOM * distance)).collect();
        Room { radius: ROOM * self.to_outline(centre), sides }
    }

    fn to_rim(&self, centre: Point) -> f64 {
        self.sides().map(|[a, b]| distance_to_segment(centre, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// The sides of the star, without those on the frame.
    fn sides(&self) -> impl Iterator<Item = [Point; 2]> {
        let (first, last) = (self.rim[0], self.rim[self.rim.len() - 1]);
        let others = match self.ends {
            None => [Some([last, first]), None],
            Some([begin, end]) => [(first, begin), (last, end)].map(|(p, side)| Some([p, self.frame.project(p, side)])),
        };
        self.rim.windows(2).map(|pair| [pair[0], pair[1]]).chain(others.into_iter().flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            let chains = trace(&triangulation, &labels, &components, size).unwrap();
            let sides = |chain: &Chain| (chain.black, chain.white, chain.ends, chains.edges(chain).to_vec());
            chains.chains.iter().map(sides).collect::<Vec<_>>()
        };
        let whole = found(2000);
        assert!(whole.iter().any(|chain| chain.2.is_some()) && whole.iter().filter(|chain| chain.2.is_none()).count() > 5);
        for size in [1, 30, 777] {
            assert_eq!(found(size), whole);
        }
    }
}
