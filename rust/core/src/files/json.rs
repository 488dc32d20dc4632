//! The drawing as JSON, for programs: the canvas, every stipple as x, y, radius and ink, every region as rings of points, and how
//! the drawing was made. The exact curves are there too, once each, so that [`super::load_json`] reads the same drawing back.
//!
//! All lengths are in pixels of the canvas. An ink is 0 (black) or 1 (white); with a palette of other inks, its label there.

use serde::{Deserialize, Serialize};

use crate::base::{Ink, WrittenPalette};
use crate::drawing::{Drawing, Provenance};

/// The value of `format` in every file.
pub(crate) const FORMAT: &str = "graphstipple drawing";

/// What a file has beside the provenance.
pub(crate) const NAMES: [&str; 8] = ["format", "palette", "canvas", "units", "stipples", "regions", "curves", "sides"];

/// The canvas.
#[derive(Serialize, Deserialize)]
pub(crate) struct Canvas {
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// A stipple.
#[derive(Serialize, Deserialize)]
pub(crate) struct Dot {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) radius: f64,
    pub(crate) ink: u8,
}

#[derive(Serialize)]
struct RegionRings {
    ink: u8,
    area: f64,
    exterior: Vec<[f64; 2]>,
    holes: Vec<Vec<[f64; 2]>>,
}

#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    #[serde(flatten)]
    provenance: &'a Provenance,
    /// The inks and the paper, where they are not black and white.
    #[serde(skip_serializing_if = "Option::is_none")]
    palette: Option<WrittenPalette>,
    canvas: Canvas,
    /// Units to a pixel of the grid of the curves' coordinates.
    units: f64,
    stipples: Vec<Dot>,
    regions: Vec<RegionRings>,
    /// The shared boundaries of regions as SVG path data, the lower ink on their left.
    curves: Vec<String>,
    /// The inks to the left and to the right of every curve, where they are not black and white.
    #[serde(skip_serializing_if = "Option::is_none")]
    sides: Option<Vec<[u8; 2]>>,
}

/// The drawing as a JSON document.
///
/// # Runtime
/// Linear in the number of points. The same drawing always gives the same bytes.
pub(super) fn to_json(drawing: &Drawing) -> String {
    let dot = |s: &crate::outlines::Stipple| Dot { x: s.x, y: s.y, radius: s.radius, ink: s.ink.label() };
    let region = |index: usize| {
        let (exterior, holes) = drawing.region_rings(index);
        let ink = drawing.regions[index].ink.label();
        let holes = holes.into_iter().map(rounded).collect();
        RegionRings { ink, area: round(drawing.region_area(index)), exterior: rounded(exterior), holes }
    };
    let is_plain = drawing.palette.is_black_and_white();
    let document = Document {
        format: FORMAT,
        provenance: &drawing.provenance,
        palette: (!is_plain).then(|| WrittenPalette::from(&drawing.palette)),
        canvas: Canvas { width: drawing.width, height: drawing.height },
        units: drawing.units,
        stipples: drawing.stipples.iter().map(dot).collect(),
        regions: (0..drawing.regions.len()).map(region).collect(),
        curves: drawing.curves.iter().map(kurbo::BezPath::to_svg).collect(),
        sides: (!is_plain).then(|| drawing.sides().into_iter().map(|sides| sides.map(Ink::label)).collect()),
    };
    serde_json::to_string(&document).expect("numbers and names always serialize") + "\n"
}

/// Six decimals are a hundredth of what a flattened curve is off, and half the digits. (The curves have all of theirs.)
fn round(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn rounded(mut ring: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    for point in &mut ring {
        *point = point.map(round);
    }
    ring
}
