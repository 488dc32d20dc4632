//! Outlines: from labelled nodes to the curves and dots of a drawing, after the paper.
//!
//! # The idea
//! Every triangle whose nodes carry two labels is crossed by exactly one piece of one boundary, from a point on one of its crossing
//! edges to one on the other: the midpoints, or where the tone between the nodes passes middle grey. The pieces join to *contours*:
//! closed ones, and open ones that begin and end on the frame.
//! A contour with the lower label on its left, black in a drawing of black and white, is the boundary between exactly two components,
//! so its curve (see [`super::fit`]) is made once and shared by both.
//!
//! # Junctions
//! In a triangle whose nodes carry three labels three contours end, in one point: a *junction*. So the areas of all inks and the paper
//! add up to the canvas, with no gap and nothing that overlaps.
//!
//! # At the frame
//! An open contour leaves through the edge between two sites whose cells both touch the frame, and goes straight to it, as the
//! spline through the mirrored crossings would. So curves meet the frame at a right angle, and nothing is drawn outside.
//!
//! # Stipples
//! A component of one node is a dot with the area of the node's cell, shrunk until it stays inside the star of the node's
//! triangles, where no other curve runs. At the frame it moves in until all of it is on the canvas. A node that cuts the canvas in
//! two, or lies between several components (its boundary is more than one contour), is a region. With irregularity a dot is a closed curve (see [`super::irregular`]).

use std::f64::consts::PI;

use kurbo::Point;
use rayon::prelude::*;

use crate::base::{Control, End, Frame, Ink, Result, mixed};
use crate::graph::{Beside, Components, Triangulation, check_areas, check_finite, check_one_a_node};
use crate::inks::Mixture;
use crate::options::{Edge, Options};
use crate::outlines::contours::{Contour, Ending, LEAST_PART, PARTS_A_THREAD, trace};
use crate::outlines::dots::Star;
use crate::outlines::fit::Fit;
use crate::outlines::irregular::irregular;
use crate::outlines::parts::{Parts, Stipple};
use crate::outlines::sleeve::{CrossingEdge, NEAREST_CROSSING};
use crate::outlines::wobble::Wobble;

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
    /// The label of every node: 0 black and 1 white, or those of several inks.
    pub labels: &'a [u8],
    /// Where every node is drawn, in pixels: its site in the triangulation, or a place near it that turns no triangle over.
    pub places: &'a [[f64; 2]],
    /// Area of every node's cell in px^2: a stipple gets `stipple_scale` times as much.
    pub areas: &'a [f64],
    /// Tone of every node, for boundaries that follow it; without, they cross edges at their midpoints.
    pub tones: Option<Tones<'a>>,
    /// White bands that run through the drawing whatever the tones: see [`Bands`].
    pub bands: Option<Bands<'a>>,
}

/// What boundaries follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tones<'a> {
    /// Tones of the nodes, in drawings of black and white.
    Grey(&'a [f32]),
    /// Mixtures of the nodes: between two labels counts by how much more a node has of the one.
    Mixed(&'a [Mixture]),
}

impl Tones<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Grey(tones) => tones.len(),
            Self::Mixed(mixtures) => mixtures.len(),
        }
    }

    /// Where a boundary crosses the edge between two nodes with these labels, the lower one first.
    fn crossing(&self, [left, right]: [u32; 2], labels: [u8; 2]) -> f64 {
        let tone = |node: u32| match self {
            Self::Grey(tones) => f64::from(tones[node as usize]),
            Self::Mixed(mixtures) => {
                let [own, other] = labels.map(|label| f64::from(mixtures[node as usize].part(label)));
                0.5 + 0.5 * (other - own)
            }
        };
        crossing(tone(left), tone(right))
    }
}

/// White bands, such as bridges: their boundaries run where they end and not halfway between nodes, so that they are as wide as they
/// are to be however far apart the nodes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bands<'a> {
    /// How far inside of a band every node lies, in any unit; below 0 how far outside, and not a number far from all of them.
    pub depths: &'a [f32],
    /// Whether a white node is white for the sake of a band alone: boundaries beside it are those of the band. Beside other white
    /// nodes they are those of what is white anyway, or of the band where it reaches further.
    pub is_added: &'a [bool],
}

impl Bands<'_> {
    /// Where a boundary crosses the edge from a black to a white node, as a fraction of the way, if `otherwise` is where it would
    /// without bands; and whether a band has a say in that.
    fn crossing(&self, [black, white]: [u32; 2], otherwise: f64) -> (f64, bool) {
        let [outside, inside] = [black, white].map(|node| f64::from(self.depths[node as usize]));
        if !(outside.is_finite() && inside.is_finite()) {
            return (otherwise, false);
        }
        // A black node may lie inside a band, and a white one outside, where bands are narrower than nodes are apart.
        let ends = if inside > outside { -outside / (inside - outside) } else { 0.5 };
        let ends = ends.clamp(NEAREST_CROSSING, 1.0 - NEAREST_BAND);
        (if self.is_added[white as usize] { ends } else { ends.min(otherwise) }, true)
    }
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
    /// How far edges look drawn by hand; above 0 stipples are irregular too.
    pub wobble: f64,
    /// What edges look like that wobble.
    pub edge: Edge,
    /// Which irregular shapes stipples and edges have.
    pub seed: u64,
    /// How far a curve may lie from the spline through the crossings, in pixels.
    pub tolerance: f64,
}

impl Shaping {
    /// What the options say of shapes.
    pub fn of(options: &Options) -> Self {
        let Options { stipple_scale, stipple_min, stipple_max, irregularity, wobble, edge, seed, tolerance, .. } = *options;
        Self { stipple_scale, stipple_min, stipple_max, irregularity, wobble, edge, seed, tolerance }
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

/// As [`NEAREST_CROSSING`], for the boundary of a band and a node within: what is left between it and the next boundary is the band, no wider than it
/// is to be. Nearer still, curves would have to be corners to stay in their triangles.
const NEAREST_BAND: f64 = 0.08;

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
/// [`crate::Error::Input`] if labels, components, areas or tones do not match the nodes, or an area is not finite or
/// below 0; [`crate::Error::Cancelled`].
pub fn outline(
    triangulation: &Triangulation,
    nodes: Nodes,
    components: &Components,
    (width, height): (usize, usize),
    shaping: Shaping,
    control: &Control,
) -> Result<Outlines> {
    let Nodes { labels, places, areas: cell_areas, tones, bands } = nodes;
    let count = triangulation.graph.sites.len();
    for (what, length) in [
        ("labels", labels.len()),
        ("places", places.len()),
        ("component ids", components.ids.len()),
        ("cell areas", cell_areas.len()),
        ("tones", tones.map_or(count, |tones| tones.len())),
        ("depths", bands.map_or(count, |bands| bands.depths.len())),
        ("signs of what is added", bands.map_or(count, |bands| bands.is_added.len())),
    ] {
        check_one_a_node(what, length, count)?;
    }
    check_areas("cell area", cell_areas)?;
    if let Some(Tones::Grey(tones)) = tones {
        check_finite("tone", tones)?;
    }
    let frame = Frame { width: width as f64, height: height as f64 };
    let part = count.div_ceil(PARTS_A_THREAD * rayon::current_num_threads()).max(LEAST_PART);
    let contours = trace(triangulation, labels, components, part)?;
    control.report(0.3)?;

    let mut contours_of = vec![0u32; components.sizes.len()];
    for contour in &contours.contours {
        contours_of[contour.left as usize] += 1;
        contours_of[contour.right as usize] += 1;
    }
    // A dot needs something around it: one contour over two edges or more, whose far ends are then joined to each other.
    let is_dot = |component: u32, contour: &Contour| {
        components.sizes[component as usize] == 1 && contours_of[component as usize] == 1 && contour.edges.1.len() >= 2
    };
    let mut component_areas = vec![0.0; components.sizes.len()];
    for (component, area) in components.ids.iter().zip(cell_areas) {
        component_areas[*component as usize] += area;
    }
    // What a loop around a component without holes should enclose.
    let enclosed = |contour: &Contour| {
        let sides = [contour.left, contour.right].into_iter().filter(|side| contours_of[*side as usize] == 1);
        sides.map(|side| component_areas[side as usize]).min_by(f64::total_cmp).filter(|_| tones.is_some())
    };
    let fit = Fit::new(shaping.tolerance, count as f64 / (frame.width * frame.height), frame);
    let wobble = Wobble::new(shaping.wobble, shaping.edge, shaping.seed, fit.spacing, frame);
    let fit = if wobble.is_some_and(|wobble| wobble.is_torn()) { fit.with_corners() } else { fit };
    let moved = wobble.map(|wobble| wobble.places(triangulation, places, bands.map(|bands| bands.depths), control)).transpose()?;
    let places = moved.as_deref().unwrap_or(places);
    let irregularity = wobble.map_or(0.0, |wobble| wobble.irregularity()).max(shaping.irregularity);
    let shape_of = |contour: &Contour| -> Result<Shape> {
        control.check()?;
        let edges = contours.edges(contour);
        let site = |node: u32| point(places[node as usize]);
        let ends = contour.ends.map(|ends| {
            ends.map(|ending| match ending {
                Ending::Frame(side) => End::Frame(side),
                Ending::Junction(nodes) => End::Junction(fit.junction(nodes.map(site))),
            })
        });
        let crossing_edges: Vec<CrossingEdge> = edges.iter().map(|[black, white]| [site(*black), site(*white)]).collect();
        let dot = [(contour.left, contour.right), (contour.right, contour.left)].into_iter().find(|(own, _)| is_dot(*own, contour));
        let Some((own, around)) = dot else {
            let mut along_band = false;
            let mut at = |nodes: [u32; 2], edge: CrossingEdge| {
                let of_nodes = nodes.map(|node| labels[node as usize]);
                let by_tone = tones.map_or(0.5, |tones| tones.crossing(nodes, of_nodes));
                let (place, by_band) = bands.map_or((by_tone, false), |bands| bands.crossing(nodes, by_tone));
                along_band |= by_band;
                wobble.filter(|_| !by_band).map_or(place, |wobble| wobble.crossing(edge, place))
            };
            let crossings: Vec<Point> =
                edges.iter().zip(&crossing_edges).map(|(nodes, edge)| edge[0].lerp(edge[1], at(*nodes, *edge))).collect();
            // What a band leaves of cells is not to grow over it again.
            let area = enclosed(contour).filter(|_| !along_band);
            return Ok(Shape::Curve { path: fit.curve(&crossing_edges, &crossings, area, ends), dot: None });
        };
        let is_left = own == contour.left;
        let node = edges[0][usize::from(!is_left)] as usize;
        let star = Star { rim: crossing_edges.iter().map(|edge| edge[usize::from(is_left)]).collect(), ends, frame };
        let units = fit.units * DOT_GRID;
        let wanted = shaping.radius(cell_areas[node], units);
        let stipple = star.dot(point(places[node]), wanted, units, Ink::of_label(labels[node]));
        if irregularity > 0.0 {
            let room = star.room(Point::new(stipple.x, stipple.y));
            let key = mixed(mixed(shaping.seed) ^ node as u64);
            // It runs with itself on its left, as black does, or on its right.
            let oriented = Stipple { ink: if is_left { Ink::BLACK } else { Ink::WHITE }, ..stipple };
            if let Some(path) = irregular(&oriented, &room, irregularity, key, units) {
                return Ok(Shape::Curve { path, dot: Some(own) });
            }
        }
        Ok(Shape::Dot { stipple, own, around })
    };
    let shapes: Vec<Result<Shape>> = contours.contours.par_iter().with_max_len(CONTOURS_AT_ONCE).map(shape_of).collect();
    control.report(0.8)?;

    let mut vertices = 0;
    let mut parts = Parts { width, height, units: fit.units, inks: vec![Ink::BLACK; components.sizes.len()], ..Parts::default() };
    let mut drawn_as_dot = vec![false; components.sizes.len()];
    for (contour, shape) in contours.contours.iter().zip(shapes) {
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
                    vertices += contour.edges.1.len();
                }
                parts.curves.push((path, [contour.left, contour.right]));
            }
        }
    }
    for (component, label) in components.ids.iter().zip(labels) {
        parts.inks[*component as usize] = Ink::of_label(*label);
    }
    parts.on_frame = owner_of_frame(triangulation, components, &drawn_as_dot);
    Ok(Outlines { parts, vertices })
}

/// Contours that a thread shapes before others can take the next: a few are thousands of edges long, so parts of all contours with the
/// same number of them would end far apart.
const CONTOURS_AT_ONCE: usize = 32;

/// What is drawn for a contour.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_cross_where_tone_is_middle_grey_but_not_near_a_node() {
        let crossings =
            [(0.2, 0.8), (0.4, 0.8), (0.3, 0.6), (0.45, 0.95), (0.05, 0.55)].map(|(black, white)| crossing(black, white));
        for (found, expected) in crossings.into_iter().zip([0.5, 0.25, 2.0 / 3.0, 0.2, 0.8]) {
            assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
        }
        // Where tone does not go from dark to light, it says nothing.
        for (black, white) in [(0.5, 0.8), (0.2, 0.5), (0.5, 0.5), (0.9, 0.1), (0.1, 0.2)] {
            assert_eq!(crossing(black, white), 0.5, "{black} {white}");
        }
    }

    #[test]
    fn a_dot_on_the_grid_is_no_smaller_than_the_least_and_hardly_larger() {
        for (units, k) in [4.0, 32.0, 256.0].into_iter().flat_map(|units| (1..200).map(move |k| (units, k))) {
            let shaping = Shaping { stipple_min: 0.0137 * f64::from(k), ..Shaping::of(&Options::default()) };
            let dot = Stipple::on_grid(Point::new(10.3, 7.7), shaping.radius(0.0, units), units, Ink::BLACK);
            assert!((0.0..0.021 / units).contains(&(dot.radius - shaping.stipple_min)), "{} on {units}", shaping.stipple_min);
        }
    }
}
