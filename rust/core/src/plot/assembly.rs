//! From a drawing to its plot: areas filled, dots pressed, and all of it in order.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::base::{Checked, Control, Error, Ink, Pool, Result};
use crate::drawing::Drawing;
use crate::files::{Export, Length};
use crate::offset::{Polygon, area};
use crate::plot::contour::{Filled, Spacing, contours, outlined};
use crate::plot::dots::dot;
use crate::plot::hatch::hatched;
use crate::plot::order::ordered;
use crate::plot::path::{Path, PlotLayer};
use crate::plot::plot::Plot;
use crate::plot::settings::{Fill, Pen, PenOrder};

/// mm to the point.
const MM_PER_POINT: f64 = 25.4 / 72.0;

/// The longest line that is planned, in mm: a hundred kilometres, weeks of any plotter.
const LONGEST: f64 = 1e8;

/// Plots a drawing with a pen, at the size and with the inks that the export says; what else it says is for files of areas.
///
/// # Errors
/// [`Error::Option`] if the pen is wider than the drawing is, or so fine that its line would be longer than 100 km;
/// [`Error::Input`] if the drawing does not fit its page; [`Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of points, for each of the lines that lie one inside the other.
pub fn plot(drawing: &Drawing, pen: &Checked<Pen>, export: &Checked<Export>, control: &Control) -> Result<Plot> {
    let placement = export.layout.place(drawing.width, drawing.height)?;
    let scale = placement.scale * MM_PER_POINT;
    let size = [drawing.width, drawing.height].map(|side| side as f64 * scale);
    let width = pen.pen.mm();
    let shorter = size[0].min(size[1]);
    if width > shorter {
        let allowed = format!("at most the shorter side of the drawing, {shorter:.3} mm");
        return Err(Error::option("pen", pen.pen, allowed));
    }
    let spacing = Spacing { pen: width, apart: width * (1.0 - pen.overlap), inset: 0.5 * width - pen.bleed.mm() };
    export.check_palette(&drawing.palette)?;
    // Of black and white both inks are in the drawing itself; of others every ink is the black of its plate.
    let is_plain = drawing.palette.is_black_and_white();
    let inks = export.only.of(&drawing.palette)?;
    let (mut layers, mut thin, mut small_dots) = (Vec::new(), 0, 0);
    let mut from = [0.0; 2];
    for number in inks {
        let plate = if is_plain { Cow::Borrowed(drawing) } else { Cow::Owned(drawing.plate(number)?) };
        let (drawing, ink) = (&*plate, if is_plain { Ink::of_label(number as u8) } else { Ink::BLACK });
        let areas = if pen.fill == Fill::None { Vec::new() } else { areas(drawing, ink, scale) };
        let filled = fill(&areas, pen, spacing, control)?;
        thin += filled.thin;
        let mut paths = filled.paths;
        for stipple in drawing.stipples.iter().filter(|stipple| stipple.ink == ink) {
            let radius = stipple.radius * scale;
            small_dots += usize::from(2.0 * radius < width);
            paths.push(dot([stipple.x * scale, stipple.y * scale], radius, spacing, pen.dots));
        }
        if pen.order == PenOrder::Short {
            paths = ordered(paths, from, control)?;
        }
        from = paths.last().and_then(Path::end).unwrap_or(from);
        let (name, rgb) = (drawing.palette.name(ink), drawing.palette.rgb(ink));
        layers.push(PlotLayer { ink: Ink::of_label(number as u8), name, rgb, paths });
    }
    Ok(Plot {
        page: placement.page.map(|side| side * MM_PER_POINT),
        origin: placement.origin.map(|place| place * MM_PER_POINT),
        canvas: [drawing.width, drawing.height],
        size,
        pen: width,
        layers,
        thin,
        small_dots,
        refill: pen.refill.map(Length::mm),
        paper: export.paper.clone(),
        provenance: drawing.provenance.clone(),
    })
}

/// The regions of an ink as polygons in mm, with their holes.
fn areas(drawing: &Drawing, ink: Ink, scale: f64) -> Vec<Polygon> {
    let in_mm = |ring: Vec<[f64; 2]>| -> Vec<[f64; 2]> { ring.into_iter().map(|point| point.map(|v| v * scale)).collect() };
    let polygon = |region: usize| {
        let (exterior, holes) = drawing.region_rings(region);
        std::iter::once(exterior).chain(holes).map(in_mm).collect()
    };
    let of_ink = (0..drawing.regions.len()).into_par_iter().filter(|region| drawing.regions[*region].ink == ink);
    Pool::new(None).run(|| of_ink.map(polygon).collect())
}

/// The lines that fill polygons, in their order.
fn fill(areas: &[Polygon], pen: &Pen, spacing: Spacing, control: &Control) -> Result<Filled> {
    let line = area(areas) / spacing.apart;
    if line > LONGEST && !matches!(pen.fill, Fill::Outline | Fill::None) {
        let allowed = format!("wider: its line would be {:.0} km long, but at most 100 can be planned", line / 1e6);
        return Err(Error::option("pen", pen.pen, allowed));
    }
    let one = |polygon: &Polygon| {
        control.check()?;
        match pen.fill {
            Fill::Contour => contours(polygon, spacing, control),
            Fill::Hatch => hatched(polygon, spacing, pen.angle),
            Fill::Outline => {
                let rim = outlined(polygon, spacing)?;
                let rings = rim.rims.into_iter().flatten().map(|points| Path { points, is_closed: true });
                Ok(Filled { paths: rings.chain(rim.lines).collect(), thin: rim.thin })
            }
            Fill::None => Ok(Filled::default()),
        }
    };
    let filled: Vec<Filled> = Pool::new(None).run(|| areas.par_iter().map(one).collect::<Result<_>>())?;
    let mut all = Filled::default();
    for mut one in filled {
        all.paths.append(&mut one.paths);
        all.thin += one.thin;
    }
    Ok(all)
}
