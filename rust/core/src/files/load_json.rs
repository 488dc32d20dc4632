//! Reading a drawing from our own JSON: its stipples and exact curves as they stand there.

use kurbo::BezPath;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::base::{Ink, Result};
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
pub(super) fn from_json(bytes: &[u8]) -> Result<Drawing> {
    #[derive(Deserialize)]
    struct Region {
        ink: u8,
    }
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
    let stipple = |dot: Dot| Stipple { x: dot.x, y: dot.y, radius: dot.radius, ink: Ink::of_label(dot.ink), level: 0 };
    let curve = |(number, data): (usize, &String)| {
        BezPath::from_svg(data).map_err(|error| invalid(format!("curve {number} is no path data ({error})")))
    };
    rebuild(Contents {
        width: document.canvas.width,
        height: document.canvas.height,
        units: document.units,
        curves: document.curves.iter().enumerate().map(curve).collect::<Result<_>>()?,
        stipples: document.stipples.into_iter().map(stipple).collect(),
        ground: Ink::of_label(document.regions.first().map_or(1, |region| region.ink)),
        provenance: Provenance {
            version: document.version,
            importance: document.importance,
            options: document.options,
            rest: document.rest,
        },
        sources: Sources::default(),
    })
}
