//! Reading a drawing from our own JSON: its stipples and exact curves as they stand there.

use kurbo::BezPath;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::base::{Control, Ink, Palette, Result, WrittenPalette};
use crate::drawing::{Drawing, Known, Provenance, invalid};
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
        palette: Option<WrittenPalette>,
        canvas: Canvas,
        units: f64,
        stipples: Vec<Dot>,
        regions: Vec<Region>,
        curves: Vec<String>,
        #[serde(default)]
        sides: Vec<[u8; 2]>,
        #[serde(flatten)]
        rest: Map<String, Value>,
    }
    let document: Document = serde_json::from_str(text_of(bytes)?).map_err(invalid)?;
    if document.format != FORMAT {
        return Err(invalid(format!("its format is \"{}\", but it must be \"{FORMAT}\"", document.format)));
    }
    let palette = document.palette.map_or_else(|| Ok(Palette::default()), Palette::try_from).map_err(invalid)?;
    let ink_of = |label: u8| ink_of(label, &palette);
    if palette.len() > 2 && document.sides.len() != document.curves.len() {
        let told = format!("it tells what is beside {} curves, but it has {}", document.sides.len(), document.curves.len());
        return Err(invalid(told));
    }
    let beside = |(number, labels): (usize, &[u8; 2])| -> Result<[Known; 2]> {
        let [left, right] = labels.map(ink_of);
        let named = |told| invalid(format!("a side of curve {number} {told}"));
        let sides = [left.map_err(named)?, right.map_err(named)?];
        if sides[0] >= sides[1] {
            return Err(invalid(format!("curve {number} has the inks {labels:?} beside it, but the left must be the lower")));
        }
        Ok(sides.map(Known::of))
    };
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
        sides: document.sides.iter().enumerate().map(beside).collect::<Result<_>>()?,
        stipples: document.stipples.into_iter().enumerate().map(stipple).collect::<Result<_>>()?,
        dots: Vec::new(),
        ground: document.regions.first().map_or(Ok(palette.paper_label()), |region| ink_of(region.ink)).map_err(invalid)?,
        provenance: Provenance {
            version: document.version,
            importance: document.importance,
            options: document.options,
            rest: document.rest,
        },
        sources: Sources::default(),
        palette: palette.clone(),
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

fn ink_of(label: u8, palette: &Palette) -> std::result::Result<Ink, String> {
    if usize::from(label) < palette.len() {
        return Ok(Ink::of_label(label));
    }
    let allowed = if palette.is_black_and_white() {
        "0 (black) or 1 (white)".to_owned()
    } else {
        format!("0 to {} (the paper)", palette.len() - 1)
    };
    Err(format!("has the ink {label}, but it must be {allowed}"))
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
        if told.ink != region.ink.label() || !is_near {
            let of = |ink: u8, area: f64| format!("ink {ink} and {area:.1} px^2");
            let [told, bound] = [of(told.ink, told.area), of(region.ink.label(), area)];
            return Err(invalid(format!("region {number} is told to have {told}, but its curves bound {bound}")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::samples::patches;
    use crate::files::json::to_json;

    #[test]
    fn drawings_of_inks_are_told_by_their_json() {
        for (inks, count, seed, overprint) in [
            (1, 200, 1, false),
            (3, 900, 2, false),
            (15, 2500, 3, false),
            (2, 300, 4, true),
            (3, 900, 5, true),
            (6, 2500, 10, true),
        ] {
            let drawing = patches(inks, count, seed, overprint);
            let json = to_json(&drawing);
            let again = from_json(json.as_bytes(), &Control::new()).unwrap();
            assert!(again == drawing, "{inks} inks, overprint {overprint}");
            assert_eq!(to_json(&again), json);
        }
    }

    #[test]
    fn curves_in_another_order_are_the_same_drawing() {
        let drawing = patches(4, 900, 7, false);
        let mut told: Value = serde_json::from_str(&to_json(&drawing)).unwrap();
        for name in ["curves", "sides", "stipples"] {
            told[name].as_array_mut().unwrap().reverse();
        }
        assert!(from_json(told.to_string().as_bytes(), &Control::new()).unwrap() == drawing);
    }
}
