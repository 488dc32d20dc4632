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

use std::collections::BTreeMap;

use kurbo::{BezPath, PathEl, Point};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::base::{
    Checked, Color, Error, Ink, Palette, Pool, Result, circle_polygon, flatten_path, flattening_tolerance, is_mirrored, signed_area,
};
use crate::options::Options;
use crate::outlines::Stipple;

/// A component of two or more nodes, drawn as a closed path; or of one, if its dot is irregular or the canvas cuts it into more
/// than a dot.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What it is drawn with.
    pub ink: Ink,
    /// Depth in the layered picture: 0 is paper that touches the frame (the paper itself), 1 is ink that touches the frame or lies in
    /// such paper, and every mark lies one level above the mark that contains it. Of black and white, even levels are white, odd ones
    /// black.
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
///
/// All of it is data, kept as it was written: a file of another version may have options that this one does not know.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of graphstipple.
    pub version: String,
    /// Where the importance came from: `saliency`, `none`, `constant:V` or `map`.
    pub importance: String,
    /// The options by name, as [`Options::to_json`] has them.
    pub options: Map<String, Value>,
    /// What else is told of it.
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

/// Unknown options that a message names.
const MOST_NAMED: usize = 5;

impl Provenance {
    /// The options, to draw with them again.
    ///
    /// # Errors
    /// [`Error::Input`] with those that this version does not know, or for the first of which it takes no such value.
    pub fn options(&self) -> Result<Checked<Options>> {
        let made_by = format!("the drawing was made by graphstipple {}", self.version.escape_debug());
        let unknown = Options::unknown(&self.options);
        if !unknown.is_empty() {
            let mut told: Vec<String> = unknown.iter().take(MOST_NAMED).map(|name| name.escape_debug().to_string()).collect();
            if unknown.len() > MOST_NAMED {
                told.push(format!("and {} more", unknown.len() - MOST_NAMED));
            }
            let told = told.join(", ");
            return Err(Error::Input(format!("{made_by} with options that this version, {VERSION}, does not know: {told}")));
        }
        let known = Options::from_json(&self.options).and_then(Options::check);
        known.map_err(|error| Error::Input(format!("{made_by}; in this version, {VERSION}, {error}")))
    }
}

/// The version of graphstipple that this is.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The vector result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    /// Width of the canvas in pixels.
    pub width: usize,
    /// Height of the canvas in pixels.
    pub height: usize,
    /// Its inks and its paper.
    pub palette: Palette,
    /// The shared boundary curves of the regions, the lower ink on their left (black, of black and white): closed ones end with
    /// `ClosePath`, open ones begin and end on the frame, or in a junction where three inks meet. From the top down, as all marks.
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

/// All marks of one level and ink, in the drawing's order; they are disjoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// How many marks lie under each of them.
    pub level: u32,
    /// What they are drawn with.
    pub ink: Ink,
    /// The marks.
    pub marks: Vec<Mark>,
}

impl Drawing {
    /// The marks to paint on the paper, level by level from the lowest, and by ink. Level 0 (paper that touches the frame) is the paper
    /// itself and is left out.
    pub fn levels(&self) -> Vec<Level> {
        let mut levels: BTreeMap<(u32, Ink), Vec<Mark>> = BTreeMap::new();
        for &mark in &self.order {
            let place = match mark {
                Mark::Stipple(i) => (self.stipples[i as usize].level, self.stipples[i as usize].ink),
                Mark::Region(i) => (self.regions[i as usize].level, self.regions[i as usize].ink),
            };
            if place.0 > 0 {
                levels.entry(place).or_default().push(mark);
            }
        }
        levels.into_iter().map(|((level, ink), marks)| Level { level, ink, marks }).collect()
    }

    /// The paper that it was made with, if its inks were given one.
    pub(crate) fn given_paper(&self) -> Option<Color> {
        if self.palette.is_black_and_white() {
            return None;
        }
        self.provenance.options.get("paper")?.as_str()?.parse().ok()
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

    /// How far flattened outlines may lie from the true curves, in pixels: 0.8 units of the grid, so less where nodes are close.
    pub fn flattening_tolerance(&self) -> f64 {
        flattening_tolerance(self.units)
    }

    /// A region's exterior and holes as polygons, within [`Drawing::flattening_tolerance`]. Rings that two marks share have the same
    /// points.
    pub fn region_rings(&self, index: usize) -> (Vec<[f64; 2]>, Vec<Vec<[f64; 2]>>) {
        let region = &self.regions[index];
        let flatten = |ring: &Ring| self.flatten_ring(ring);
        (flatten(&region.exterior), region.holes.iter().map(flatten).collect())
    }

    fn flatten_ring(&self, ring: &Ring) -> Vec<[f64; 2]> {
        let tolerance = self.flattening_tolerance();
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

    /// Area of a region without its holes, in px^2, as flattened.
    pub fn region_area(&self, index: usize) -> f64 {
        let (exterior, holes) = self.region_rings(index);
        signed_area(&exterior) + holes.iter().map(|hole| signed_area(hole)).sum::<f64>()
    }

    /// On-curve points and coordinate pairs that an SVG file of one ink holds, control points included but for those that are the
    /// last one mirrored: every curve is written once, a dot counts one, and so does a corner of the canvas that is black.
    pub fn count_written(&self) -> (usize, usize) {
        let black = self.regions.iter().filter(|region| region.ink == Ink::BLACK);
        let corners = black.flat_map(|region| &region.exterior.parts).filter(|part| matches!(part, RingPart::Corner(..))).count();
        let (mut anchors, mut coordinates) = (self.stipples.len() + corners, self.stipples.len() + corners);
        let add = |a: (usize, usize), b: (usize, usize)| (a.0 + b.0, a.1 + b.1);
        let of_curves = Pool::new(None).run(|| self.curves.par_iter().map(count_points).reduce(|| (0, 0), add));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_need_not_say_is_no_coordinate() {
        for (data, counted) in [
            ("M0 0 L4 0 L4 4 Z", (3, 3)),
            // The begin is said once, and so is a control point that mirrors the one before.
            ("M0 0 L4 0 L4 4 L0 0 Z", (3, 3)),
            ("M0 0 Q1 1 2 0 Q3 -1 4 0 Q9 9 0 0 Z", (3, 5)),
            ("M0 0 Q1 1 2 0 Q3 -1.5 4 0", (3, 5)),
            ("M0 0 C1 1 2 1 3 0 C4 -1 5 -1 6 0", (3, 6)),
        ] {
            assert_eq!(count_points(&BezPath::from_svg(data).unwrap()), counted, "{data}");
        }
    }
}
