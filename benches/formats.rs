//! Every format of one drawing, as a table; see the crate's text for how to read it.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use graphstipple_bench::{Photo, is_smoke_run, median, options, photo};
use graphstipple_core::stages::{Only, Outline, Style};
use graphstipple_core::{Control, Drawing, Export, Format, Outcome, draw};
use kurbo::PathEl;

/// One and four megapixels.
const SIZES: [[usize; 2]; 2] = [[1152, 864], [2304, 1728]];

/// The same on a tiny photo.
const TINY_SIZES: [[usize; 2]; 1] = [[96, 72]];

/// Of the times of so many runs the median counts.
const RUNS: usize = 3;

/// A way of writing a drawing.
struct Way {
    name: &'static str,
    suffix: &'static str,
    style: Style,
    only: &'static [&'static str],
    one_bit: bool,
}

impl Way {
    const fn flat(name: &'static str, suffix: &'static str) -> Self {
        Self { name, suffix, style: Style::Flat, only: &[], one_bit: false }
    }
}

const WAYS: [Way; 9] = [
    Way::flat("SVG, flat", "svg"),
    Way { only: &["black", "white"], ..Way::flat("SVG, both inks", "svg") },
    Way { style: Style::Layered, ..Way::flat("SVG, layered", "svg") },
    Way::flat("PDF, flat", "pdf"),
    Way::flat("EPS, flat", "eps"),
    Way::flat("DXF, flat", "dxf"),
    Way::flat("PNG", "png"),
    Way { one_bit: true, ..Way::flat("PNG, 1 bit", "png") },
    Way::flat("JSON", "json"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let sizes = if is_smoke_run() { TINY_SIZES.to_vec() } else { SIZES.to_vec() };
    for [width, height] in sizes {
        let Photo { photo, importance } = photo(width, height);
        let began = Instant::now();
        let Outcome { drawing, stats, .. } = draw(&photo, &importance, &options(), &Control::new())?;
        let making = began.elapsed().as_secs_f64();
        println!(
            "\n{width} x {height} pixels: {making:.3} s to make the drawing, {} stipples, {} regions",
            stats.stipples, stats.regions
        );
        let share = |count: usize| format!("{count} ({:.2})", count as f64 / stats.vertices as f64);
        println!("{} vertices, {} anchors, {} coordinates\n", stats.vertices, share(stats.anchors), share(stats.coordinates));
        println!("{:<16}{:>12}{:>12}{:>12}{:>12}{:>12}", "", "points", "kB", "B a point", "seconds", "of making");
        for way in &WAYS {
            println!("{}", row(&drawing, way, making)?);
        }
    }
    Ok(())
}

/// Writes a drawing in memory and tells what came of it.
fn row(drawing: &Drawing, way: &Way, making: f64) -> Result<String, Box<dyn Error>> {
    let export = Export { style: way.style, only: Only::named(way.only), one_bit: way.one_bit, ..Export::default() };
    let writer = Format::of_suffix(way.suffix)?.writer(export.check()?)?;
    let mut seconds = Vec::new();
    let mut bytes = Vec::new();
    for _ in 0..RUNS {
        let began = Instant::now();
        bytes = black_box(writer.write(drawing)?);
        seconds.push(began.elapsed().as_secs_f64());
    }
    let median = median(seconds);
    let (points, each) = match points(drawing, way, &bytes) {
        Some(points) => (points.to_string(), format!("{:.1}", bytes.len() as f64 / points as f64)),
        None => ("-".to_owned(), "-".to_owned()),
    };
    let size = bytes.len() as f64 / 1e3;
    Ok(format!("{:<16}{points:>12}{size:>12.0}{each:>12}{median:>12.3}{:>12.3}", way.name, median / making))
}

/// Points that a vector file holds, control points included; a dot counts one. `None` for the others.
fn points(drawing: &Drawing, way: &Way, bytes: &[u8]) -> Option<usize> {
    match way.suffix {
        "svg" => Some(pairs(drawing, way, 2)),
        // These raise quadratic curves to cubic ones.
        "pdf" | "eps" => Some(pairs(drawing, way, 3)),
        // Vertices of polylines and centres of circles; the header has three points more, which do not count.
        "dxf" => Some(String::from_utf8_lossy(bytes).matches("\n10\n").count().saturating_sub(3)),
        _ => None,
    }
}

/// Coordinate pairs of the layers, with so many for a quadratic curve.
fn pairs(drawing: &Drawing, way: &Way, for_quadratic: usize) -> usize {
    let layers = drawing.layers(way.style, &Only::named(way.only), None).expect("black and white have these layers").layers;
    let areas = layers.iter().flat_map(|layer| &layer.areas);
    let outlines = areas.flat_map(|area| std::iter::once(&area.exterior).chain(&area.holes));
    let of_element = |element: &PathEl| match element {
        PathEl::MoveTo(_) | PathEl::LineTo(_) => 1,
        PathEl::QuadTo(..) => for_quadratic,
        PathEl::CurveTo(..) => 3,
        PathEl::ClosePath => 0,
    };
    outlines
        .map(|outline| match outline {
            Outline::Circle { .. } => 1,
            Outline::Path(path) => path.elements().iter().map(of_element).sum(),
        })
        .sum()
}
