//! The drawing: canvas size, shared boundary curves, the regions and stipples that they bound, and how it all was made.
//!
//! # Representation
//! Every boundary curve is stored once, in [`Drawing::curves`], and shared by the two components that it separates. A region's
//! [`Ring`] names curves (forward or reversed), stipples whose outline is its hole, and corners of the frame. So neighbours
//! fit exactly, and the areas of all regions and stipples add up to the canvas.
//!
//! The same data expresses the picture in two ways (the paper has the first): *layered*, where each region is the
//! filled disc of its exterior ring and what lies inside it is painted over it; and *flat*, where each region is its exterior
//! with its holes. In the layered way all marks of one [`level`](Region::level) have the same ink and are disjoint, and a mark's
//! container is always on the level below. So painting level by level is as good as painting one by one.

use std::sync::OnceLock;

use kurbo::{BezPath, CubicBez, ParamCurve as _, PathEl, Point, QuadBez};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::params::Options;
use crate::triangulation::Side;

/// What a mark is drawn with. Its number is the label of its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ink {
    /// Label 0.
    Black = 0,
    /// Label 1: the paper.
    White = 1,
}

impl Ink {
    /// The ink of a label: 0 is black, anything else white.
    pub fn of_label(label: u8) -> Self {
        if label == 0 { Self::Black } else { Self::White }
    }

    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Black => Self::White,
            Self::White => Self::Black,
        }
    }

    /// `black` or `white`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Black => "black",
            Self::White => "white",
        }
    }

    /// `Black` or `White`.
    pub fn capital_name(self) -> &'static str {
        match self {
            Self::Black => "Black",
            Self::White => "White",
        }
    }
}

/// A component of one node, drawn as a round dot. (An irregular one is a [`Region`].)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stipple {
    /// Centre in pixels.
    pub x: f64,
    /// Centre in pixels.
    pub y: f64,
    /// Radius in pixels, above 0.
    pub radius: f64,
    /// What it is drawn with.
    pub ink: Ink,
    /// How many marks lie under it in the layered way; see [`Region::level`].
    pub level: u32,
}

impl Stipple {
    /// A dot near `centre` whose coordinates files hold exactly in few digits: its leftmost point lies on the grid of `units` to a
    /// pixel, and its radius is a whole number of hundredths of a unit, not above the given one unless that is far below a
    /// hundredth.
    pub(crate) fn on_grid(centre: Point, radius: f64, units: f64, ink: Ink) -> Self {
        let hundredths = (radius * units * 100.0).floor();
        // A radius of few digits would be far off.
        let in_units = if hundredths >= 50.0 { hundredths / 100.0 } else { radius * units };
        let left = (centre.x * units - in_units).round();
        Self { x: (left + in_units) / units, y: (centre.y * units).round() / units, radius: in_units / units, ink, level: 0 }
    }
}

/// A component of two or more nodes, drawn as a closed path; or of one, if its dot is irregular or the canvas cuts it into more
/// than a dot.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What it is drawn with.
    pub ink: Ink,
    /// Depth in the layered picture: 0 is white that touches the frame (the paper itself), 1 is black that touches the frame or
    /// lies in such white, and every mark lies one level above the mark that contains it. Even levels are white, odd ones black.
    pub level: u32,
    /// The outer boundary; its signed area (x right, y down) is positive.
    pub exterior: Ring,
    /// The inner boundaries; their signed areas are negative.
    pub holes: Vec<Ring>,
    /// Area that the exterior encloses, holes included, in px^2: what the layered order goes by.
    pub enclosed_area: f64,
}

/// A closed boundary, as the pieces it runs along.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ring {
    /// The pieces, in order.
    pub parts: Vec<RingPart>,
}

/// A piece of a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RingPart {
    /// A boundary curve, by its index in [`Drawing::curves`].
    Curve {
        /// Which one.
        index: u32,
        /// Whether the ring runs against the curve's own direction.
        reversed: bool,
    },
    /// The outline of a stipple, by its index in [`Drawing::stipples`], as a hole of what surrounds it: it is a ring by itself.
    Stipple {
        /// Which one.
        index: u32,
    },
    /// A corner of the frame: x, y.
    Corner(f64, f64),
}

/// A mark in the layered order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Index in [`Drawing::stipples`].
    Stipple(u32),
    /// Index in [`Drawing::regions`].
    Region(u32),
}

/// How a drawing was made: enough to make it again from the same photo. Holds no times, paths or thread counts.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of graphstipple.
    pub version: String,
    /// Where the importance came from: `saliency`, `none`, `constant:V` or `map`.
    pub importance: String,
    /// The options.
    pub options: Options,
}

/// What was counted and timed (docs/method.md; Table 4 of the paper has stipples, regions and vertices).
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Stats {
    /// Width of the canvas in pixels.
    pub width: usize,
    /// Height of the canvas in pixels.
    pub height: usize,
    /// Lattice nodes per pixel.
    pub density: f64,
    /// Nodes of the first graph.
    pub lattice_nodes: usize,
    /// The node budget; `None` when the importance alone decides.
    pub node_budget: Option<usize>,
    /// The factor on the importance that meets the budget; 1 without one.
    pub importance_factor: f64,
    /// What the refinement of the labels adds for white, so that the drawing has the photo's mean: see [`crate::refine`].
    pub tone_shift: f64,
    /// Nodes of the second graph.
    pub nodes: usize,
    /// Components drawn as dots.
    pub stipples: usize,
    /// Components drawn as closed paths.
    pub regions: usize,
    /// Crossings that region boundaries pass through, plus stipples, irregular ones too: before smoothing and
    /// simplification.
    pub vertices: usize,
    /// On-curve points written; a dot counts one.
    pub anchors: usize,
    /// Coordinate pairs written, control points included; a dot counts one.
    pub coordinates: usize,
    /// Stipples that a least radius made larger.
    pub dots_enlarged: usize,
    /// Stipples that a least radius left out.
    pub dots_dropped: usize,
    /// Seconds each stage took, and `total`.
    pub seconds: std::collections::BTreeMap<String, f64>,
}

/// The vector result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    /// Width of the canvas in pixels.
    pub width: usize,
    /// Height of the canvas in pixels.
    pub height: usize,
    /// The shared boundary curves of the regions, black on their left: closed ones end with `ClosePath`, open ones begin and end on
    /// the frame. From the top down, as all marks.
    pub curves: Vec<BezPath>,
    /// The dots, from the top down (by y, then x).
    pub stipples: Vec<Stipple>,
    /// The regions, from the top down, by the uppermost points of their exteriors.
    pub regions: Vec<Region>,
    /// All marks by the area that their exteriors enclose, largest first: a mark follows its container.
    pub order: Vec<Mark>,
    /// Units to a pixel of the grid on which coordinates lie, a power of two; single points may lie on a finer one.
    pub units: f64,
    /// How it was made.
    pub provenance: Provenance,
}

/// All marks of one level, in the drawing's order; they share their ink and are disjoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// What they are drawn with.
    pub ink: Ink,
    /// The marks.
    pub marks: Vec<Mark>,
}

/// How far a flattened outline may lie from the true curve in `regions` and `area`, in pixels: a twentieth of a pixel is below
/// what any raster or plotter shows, and costs about twice the points of a quarter.
pub const FLATTENING_TOLERANCE: f64 = 0.05;

/// No vertex of a circle's polygon lies further from its centre than this many radii: the coarsest polygon has eight sides.
pub(crate) const POLYGON_REACH: f64 = 1.055;

/// The frame of the canvas, and positions along it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Frame {
    /// Whether a point lies inside, not on the frame.
    pub(crate) fn holds(self, p: Point) -> bool {
        p.x > 0.0 && p.y > 0.0 && p.x < self.width && p.y < self.height
    }

    /// The foot of a point on a side.
    pub(crate) fn project(self, p: Point, side: Side) -> Point {
        match side {
            Side::Top => Point::new(p.x, 0.0),
            Side::Right => Point::new(self.width, p.y),
            Side::Bottom => Point::new(p.x, self.height),
            Side::Left => Point::new(0.0, p.y),
        }
    }

    pub(crate) fn perimeter(self) -> f64 {
        2.0 * (self.width + self.height)
    }

    /// Distance along the frame from the corner (0, 0), in the positive direction: top, right, bottom, left.
    pub(crate) fn position(self, p: Point) -> f64 {
        if p.y <= 0.0 {
            p.x
        } else if p.x >= self.width {
            self.width + p.y
        } else if p.y >= self.height {
            self.width + self.height + (self.width - p.x)
        } else {
            2.0 * self.width + self.height + (self.height - p.y)
        }
    }

    /// The corners strictly between two positions, in the positive direction from the first to the second.
    pub(crate) fn corners_between(self, from: f64, to: f64) -> impl Iterator<Item = RingPart> {
        let (w, h) = (self.width, self.height);
        let corners = [(0.0, (0.0, 0.0)), (w, (w, 0.0)), (w + h, (w, h)), (2.0 * w + h, (0.0, h))];
        let around = self.perimeter();
        let twice = corners.into_iter().chain(corners.map(|(at, corner)| (at + around, corner)));
        twice.filter(move |(at, _)| *at > from && *at < to).map(|(_, (x, y))| RingPart::Corner(x, y))
    }
}

impl Drawing {
    /// The marks to paint on white paper, level by level from the lowest. Level 0 (white that touches the frame) is the paper
    /// itself and is left out.
    pub fn levels(&self) -> Vec<Level> {
        let mut levels: Vec<Level> = Vec::new();
        for &mark in &self.order {
            let (level, ink) = match mark {
                Mark::Stipple(i) => (self.stipples[i as usize].level, self.stipples[i as usize].ink),
                Mark::Region(i) => (self.regions[i as usize].level, self.regions[i as usize].ink),
            };
            let level = level as usize;
            while levels.len() <= level {
                let ink = if levels.len().is_multiple_of(2) { Ink::White } else { Ink::Black };
                levels.push(Level { ink, marks: Vec::new() });
            }
            debug_assert_eq!(levels[level].ink, ink);
            levels[level].marks.push(mark);
        }
        if !levels.is_empty() {
            levels.remove(0);
        }
        levels.retain(|level| !level.marks.is_empty());
        levels
    }

    /// The path of a ring with its true curves; empty for the outline of a stipple, which is no path but a circle.
    pub fn ring_path(&self, ring: &Ring) -> BezPath {
        let of_part = |part: &RingPart| match part {
            RingPart::Curve { index, .. } => self.curves[*index as usize].elements().len(),
            _ => 1,
        };
        let mut path = BezPath::with_capacity(ring.parts.iter().map(of_part).sum::<usize>() + 1);
        for part in &ring.parts {
            match *part {
                RingPart::Curve { index, reversed: false } => extend(&mut path, self.curves[index as usize].iter()),
                RingPart::Curve { index, reversed: true } => {
                    extend(&mut path, self.curves[index as usize].reverse_subpaths().iter())
                }
                RingPart::Stipple { .. } => return BezPath::new(),
                RingPart::Corner(x, y) => extend_to(&mut path, Point::new(x, y)),
            }
        }
        path.close_path();
        path
    }

    /// The polygon of a stipple: as many sides as keep it within `tolerance` px of its circle, with exactly the circle's area. Runs
    /// in the positive direction.
    pub fn stipple_outline(&self, index: usize, tolerance: f64) -> Vec<[f64; 2]> {
        let stipple = &self.stipples[index];
        circle_polygon([stipple.x, stipple.y], stipple.radius, tolerance)
    }

    /// A region's exterior and holes as polygons, flattened within `tolerance` px. Rings that two marks share have the same points.
    pub fn region_rings(&self, index: usize, tolerance: f64) -> (Vec<[f64; 2]>, Vec<Vec<[f64; 2]>>) {
        let region = &self.regions[index];
        let flatten = |ring: &Ring| self.flatten_ring(ring, tolerance);
        (flatten(&region.exterior), region.holes.iter().map(flatten).collect())
    }

    fn flatten_ring(&self, ring: &Ring, tolerance: f64) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> = Vec::new();
        for part in &ring.parts {
            let piece = match *part {
                RingPart::Curve { index, reversed } => {
                    let mut piece = flatten_path(&self.curves[index as usize], tolerance);
                    if reversed {
                        piece.reverse();
                    }
                    piece
                }
                RingPart::Stipple { index } => {
                    let mut piece = self.stipple_outline(index as usize, tolerance);
                    piece.reverse();
                    piece
                }
                RingPart::Corner(x, y) => vec![[x, y]],
            };
            for point in piece {
                if points.last() != Some(&point) {
                    points.push(point);
                }
            }
        }
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        points
    }

    /// Area of a region without its holes, in px^2, as flattened to [`FLATTENING_TOLERANCE`].
    pub fn region_area(&self, index: usize) -> f64 {
        let (exterior, holes) = self.region_rings(index, FLATTENING_TOLERANCE);
        signed_area(&exterior) + holes.iter().map(|hole| signed_area(hole)).sum::<f64>()
    }

    /// On-curve points and coordinate pairs that an SVG file of one ink holds, control points included but for those that are the
    /// last one mirrored: every curve is written once, a dot counts one, and so does a corner of the canvas that is black.
    pub fn count_written(&self) -> (usize, usize) {
        let black = self.regions.iter().filter(|region| region.ink == Ink::Black);
        let corners = black.flat_map(|region| &region.exterior.parts).filter(|part| matches!(part, RingPart::Corner(..))).count();
        let (mut anchors, mut coordinates) = (self.stipples.len() + corners, self.stipples.len() + corners);
        let of_curves = self.curves.par_iter().map(count_points).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        anchors += of_curves.0;
        coordinates += of_curves.1;
        (anchors, coordinates)
    }
}

/// On-curve points and coordinate pairs of a path; a closed one's first point again at its end is not written twice.
fn count_points(path: &BezPath) -> (usize, usize) {
    let (mut anchors, mut coordinates) = (0, 0);
    let mut last = PathEl::ClosePath;
    for element in path.elements() {
        let pairs = match element {
            PathEl::MoveTo(_) | PathEl::LineTo(_) => 1,
            PathEl::QuadTo(..) => 2,
            PathEl::CurveTo(..) => 3,
            PathEl::ClosePath => continue,
        };
        anchors += 1;
        coordinates += pairs - usize::from(is_mirrored(&last, element));
        last = *element;
    }
    let twice = usize::from(closes_on_its_start(path));
    (anchors - twice, coordinates - twice)
}

/// Whether the first control point of a curve is the last one before it, a curve of the same kind, mirrored at the point between:
/// then SVG leaves it out.
pub(crate) fn is_mirrored(before: &PathEl, element: &PathEl) -> bool {
    match (before, element) {
        (PathEl::QuadTo(last, joint), PathEl::QuadTo(first, _)) | (PathEl::CurveTo(_, last, joint), PathEl::CurveTo(first, ..)) => {
            *first == *joint + (*joint - *last)
        }
        _ => false,
    }
}

/// Whether the last drawn point of a closed path is its first one again.
fn closes_on_its_start(path: &BezPath) -> bool {
    let elements = path.elements();
    let last = elements.iter().rev().find_map(PathEl::end_point);
    elements.len() > 2 && elements.first().and_then(PathEl::end_point) == last
}

/// Appends a curve to a ring's path: its first point joins by a line unless the path is already there, and its close is dropped.
fn extend(path: &mut BezPath, elements: impl Iterator<Item = PathEl>) {
    for element in elements {
        match element {
            PathEl::MoveTo(p) => extend_to(path, p),
            PathEl::ClosePath => {}
            other => path.push(other),
        }
    }
}

fn extend_to(path: &mut BezPath, p: Point) {
    match path.elements().last().and_then(PathEl::end_point) {
        None => path.move_to(p),
        Some(last) if last == p => {}
        Some(_) => path.line_to(p),
    }
}

/// The points of a path's only subpath, flattened within `tolerance` px; the closing point is not repeated.
pub(crate) fn flatten_path(path: &BezPath, tolerance: f64) -> Vec<[f64; 2]> {
    let mut points: Vec<Point> = Vec::with_capacity(path.elements().len() * 4);
    for element in path.elements() {
        let from = points.last().copied().unwrap_or_default();
        match *element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => points.push(p),
            PathEl::QuadTo(c, p) => flatten_quad(&QuadBez::new(from, c, p), tolerance, &mut points),
            PathEl::CurveTo(c, d, p) => flatten_cubic(&CubicBez::new(from, c, d, p), tolerance, &mut points),
            PathEl::ClosePath => {}
        }
    }
    points.into_iter().map(|p| [p.x, p.y]).collect()
}

/// Appends points of a curve, at even steps of its parameter, so that the polygon through them lies within `tolerance` of it; not
/// its begin.
pub(crate) fn flatten_quad(quad: &QuadBez, tolerance: f64, points: &mut Vec<Point>) {
    let bend = (quad.p0.to_vec2() - 2.0 * quad.p1.to_vec2() + quad.p2.to_vec2()).hypot2().sqrt();
    let steps = (bend / (4.0 * tolerance)).sqrt().ceil().max(1.0);
    points.extend((1..steps as usize).map(|k| quad.eval(k as f64 / steps)));
    points.push(quad.p2);
}

/// The same for a cubic.
pub(crate) fn flatten_cubic(cubic: &CubicBez, tolerance: f64, points: &mut Vec<Point>) {
    let [p0, p1, p2, p3] = [cubic.p0, cubic.p1, cubic.p2, cubic.p3].map(Point::to_vec2);
    let bend = (p0 - 2.0 * p1 + p2).hypot2().max((p1 - 2.0 * p2 + p3).hypot2()).sqrt();
    let steps = (0.75 * bend / tolerance).sqrt().ceil().max(1.0);
    points.extend((1..steps as usize).map(|k| cubic.eval(k as f64 / steps)));
    points.push(cubic.p3);
}

/// Twice-halved shoelace sum: positive when the ring turns from +x towards +y.
pub fn signed_area(ring: &[[f64; 2]]) -> f64 {
    let mut sum = 0.0;
    for (i, p) in ring.iter().enumerate() {
        let q = ring[(i + 1) % ring.len()];
        sum += p[0] * q[1] - q[0] * p[1];
    }
    sum / 2.0
}

/// See [`Drawing::stipple_outline`].
pub(crate) fn circle_polygon(centre: [f64; 2], radius: f64, tolerance: f64) -> Vec<[f64; 2]> {
    // A chord of half-angle h lies radius * (1 - cos h) inside the circle; half a tolerance each way once the area is corrected.
    let half = libm::acos((1.0 - (tolerance / radius).min(0.5)).max(0.5));
    let sides = (libm::ceil(std::f64::consts::PI / half) as usize).clamp(8, MOST_SIDES);
    let Polygon { circumradius, directions } = regular_polygon(sides);
    let corrected = radius * circumradius;
    directions.iter().map(|[x, y]| [centre[0] + corrected * x, centre[1] + corrected * y]).collect()
}

/// The most sides of a circle's polygon.
const MOST_SIDES: usize = 256;

/// A regular polygon around the origin with the area of the unit circle.
struct Polygon {
    circumradius: f64,
    /// Unit vectors to its vertices.
    directions: Vec<[f64; 2]>,
}

/// The polygon of so many sides, up to [`MOST_SIDES`]. Each is made once: drawings have many dots, of few numbers of sides.
fn regular_polygon(sides: usize) -> &'static Polygon {
    static POLYGONS: [OnceLock<Polygon>; MOST_SIDES + 1] = [const { OnceLock::new() }; MOST_SIDES + 1];
    POLYGONS[sides].get_or_init(|| {
        let step = std::f64::consts::TAU / sides as f64;
        let direction = |k: usize| {
            let angle = (k as f64 + 0.5) * step;
            [libm::cos(angle), libm::sin(angle)]
        };
        // A polygon with circumradius R has the area n/2 R^2 sin(2 pi / n); this R gives pi.
        Polygon { circumradius: libm::sqrt(step / libm::sin(step)), directions: (0..sides).map(direction).collect() }
    })
}
