//! Reading a drawing from our own JSON: its stipples and exact curves as they stand there.

use kurbo::BezPath;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::base::{Control, Ink, Result};
use crate::drawing::{Drawing, Provenance, invalid};
use crate::files::json::{Canvas, Dot, FORMAT};
use crate::files::load::{Contents, rebuild};
use crate::files::sources::Sources;
use crate::files::text_of;
use crate::outlines::Stipple;

/// Reads a JSON file that [`super::json::to_json`] wrote.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub(super) fn from_json(bytes: &[u8], control: &Control) -> Result<Drawing> {
    #[derive(Deserialize)]
    struct Document {
        format: String,
        version: String,
        importance: String,
        options: Map<String, Value>,
        canvas: Canvas,
        units: f64,
        stipples: Vec<Dot>,
        regions: Vec<Region>,
        curves: Vec<String>,
        #[serde(flatten)]
        rest: Map<String, Value>,
    }
    let document: Document = serde_json::from_str(text_of(bytes)?).map_err(invalid)?;
    if document.format != FORMAT {
        return Err(invalid(format!("its format is \"{}\", but it must be \"{FORMAT}\"", document.format)));
    }
    let stipple = |(number, dot): (usize, Dot)| {
        let ink = ink_of(dot.ink).map_err(|told| invalid(format!("stipple {number} {told}")))?;
        Ok(Stipple { x: dot.x, y: dot.y, radius: dot.radius, ink, level: 0 })
    };
    let curve = |(number, data): (usize, &String)| {
        BezPath::from_svg(data).map_err(|error| invalid(format!("curve {number} is no path data ({error})")))
    };
    let contents = Contents {
        width: document.canvas.width,
        height: document.canvas.height,
        units: document.units,
        curves: document.curves.iter().enumerate().map(curve).collect::<Result<_>>()?,
        stipples: document.stipples.into_iter().enumerate().map(stipple).collect::<Result<_>>()?,
        ground: document.regions.first().map_or(Ok(Ink::White), |region| ink_of(region.ink)).map_err(invalid)?,
        provenance: Provenance {
            version: document.version,
            importance: document.importance,
            options: document.options,
            rest: document.rest,
        },
        sources: Sources::default(),
    };
    let drawing = rebuild(contents, control)?;
    check_regions(&document.regions, &drawing)?;
    Ok(drawing)
}

/// What is told of a region beside the curves around it.
#[derive(Deserialize)]
struct Region {
    ink: u8,
    area: f64,
}

fn ink_of(label: u8) -> std::result::Result<Ink, String> {
    match label {
        0 | 1 => Ok(Ink::of_label(label)),
        other => Err(format!("has the ink {other}, but it must be 0 (black) or 1 (white)")),
    }
}

/// How far the area of a region that is told may be from that of its curves: a part of it, and some px^2 more. Another version may
/// flatten outlines otherwise.
const AREA_LEFT: [f64; 2] = [0.01, 0.5];

/// Checks that the regions that are told are those that the curves bound.
fn check_regions(told: &[Region], drawing: &Drawing) -> Result<()> {
    if told.len() != drawing.regions.len() {
        return Err(invalid(format!("it tells of {} regions, but its curves bound {}", told.len(), drawing.regions.len())));
    }
    for (number, (told, region)) in told.iter().zip(&drawing.regions).enumerate() {
        let area = drawing.region_area(number);
        let is_near = (told.area - area).abs() <= AREA_LEFT[0] * area + AREA_LEFT[1];
        if told.ink != region.ink as u8 || !is_near {
            let of = |ink: u8, area: f64| format!("ink {ink} and {area:.1} px^2");
            let [told, bound] = [of(told.ink, told.area), of(region.ink as u8, area)];
            return Err(invalid(format!("region {number} is told to have {told}, but its curves bound {bound}")));
        }
    }
    Ok(())
}
