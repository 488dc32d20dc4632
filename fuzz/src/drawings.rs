//! What must hold of every drawing that is loaded. In: the bytes of a file; out: nothing, or an abort.
//!
//! The judge looks at the polygons of regions and dots, edge by edge and point by point, and knows nothing of how the loader finds
//! what lies beside what.

use graphstipple_core::stages::{Ink, Level, Mark, Only, Style, raster, signed_area};
use graphstipple_core::{Control, Drawing, Export, Format, load};

use crate::{check_error, memory};

/// The largest canvas that is looked at, in pixels of a side.
const MAX_SIDE: usize = 256;

/// The most edges that are compared with one another.
const MAX_EDGES: usize = 1500;

/// The most bytes that loading a file of some ten thousand may take at once: curves of a few bytes may bend into millions of points.
const MAX_BYTES: usize = 1 << 30;

/// Points a row and a column at which the ways to paint a drawing are compared.
const PROBES: usize = 12;

/// What rounding may come to, in pixels.
const ROUNDING: f64 = 1e-9;

type Point = [f64; 2];
type Ring = Vec<Point>;

/// Loads bytes as a file with this suffix, and checks what comes of it.
pub fn examine_drawing(bytes: &[u8], suffix: &str) {
    let format = Format::of_suffix(suffix).expect("there is such a format");
    let before = memory::restart();
    let result = load(bytes, format, &Control::new());
    let taken = memory::peak() - before;
    assert!(taken <= MAX_BYTES, "loading {} bytes took {} MB", bytes.len(), taken >> 20);
    let drawing = match result {
        Ok(drawing) => drawing,
        Err(error) => return check_error(&error),
    };
    if drawing.width.max(drawing.height) > MAX_SIDE {
        return;
    }
    let rings = all_rings(&drawing);
    let edges = rings.iter().map(|(exterior, holes)| exterior.len() + holes.iter().map(Vec::len).sum::<usize>()).sum::<usize>();
    if edges > MAX_EDGES {
        return;
    }
    check_rings(&drawing, &rings);
    check_levels(&drawing);
    check_probes(&drawing, &rings);
    check_raster(&drawing, &rings);
    check_files(&drawing);
    for least in [0.3, 1.5] {
        let (larger, _) = drawing.with_least_radius(least).expect("any drawing can have larger dots");
        assert!(larger.stipples.iter().all(|dot| dot.radius >= least));
        assert_eq!(larger.regions.len(), drawing.regions.len());
        let rings = all_rings(&larger);
        check_rings(&larger, &rings);
        check_probes(&larger, &rings);
    }
}

/// The exterior and the holes of every region.
fn all_rings(drawing: &Drawing) -> Vec<(Ring, Vec<Ring>)> {
    (0..drawing.regions.len()).map(|region| drawing.region_rings(region)).collect()
}

fn dots(drawing: &Drawing) -> impl Iterator<Item = Ring> {
    (0..drawing.stipples.len()).map(|dot| drawing.stipple_outline(dot, drawing.flattening_tolerance()))
}

/// Regions and dots fill the canvas, rings run the right way, and no edge crosses another.
fn check_rings(drawing: &Drawing, rings: &[(Ring, Vec<Ring>)]) {
    let mut area: f64 = dots(drawing).map(|dot| signed_area(&dot)).sum();
    for (exterior, holes) in rings {
        let (own, of_holes) = (signed_area(exterior), holes.iter().map(|hole| signed_area(hole)));
        assert!(own > 0.0, "an exterior has the area {own}");
        assert!(of_holes.clone().all(|area| area < 0.0), "a hole runs the wrong way");
        area += own + of_holes.sum::<f64>();
    }
    let canvas = (drawing.width * drawing.height) as f64;
    assert!((area / canvas - 1.0).abs() < 1e-6, "the marks have an area of {area}, the canvas one of {canvas}");

    // Neighbours share their edges.
    let mut edges: Vec<[Point; 2]> =
        rings.iter().flat_map(|(exterior, holes)| std::iter::once(exterior).chain(holes)).flat_map(edges_of).collect();
    edges.iter_mut().for_each(|edge| edge.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))));
    edges.sort_by(|a, b| a[0][1].total_cmp(&b[0][1]));
    for (i, a) in edges.iter().enumerate() {
        for b in edges[i + 1..].iter().take_while(|b| b[0][1] <= a[1][1]) {
            assert!(!cross(*a, *b), "{a:?} crosses {b:?}");
        }
    }
}

fn edges_of(ring: &Ring) -> impl Iterator<Item = [Point; 2]> {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// Whether two edges cross by more than rounding.
fn cross(a: [Point; 2], b: [Point; 2]) -> bool {
    let side = |[from, to]: [Point; 2], p: Point| {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        (x * (p[1] - from[1]) - y * (p[0] - from[0])) / x.hypot(y)
    };
    let are_apart = |edge, other: [Point; 2]| {
        let [p, q] = other.map(|point| side(edge, point));
        p.min(q) >= -ROUNDING || p.max(q) <= ROUNDING
    };
    !are_apart(a, b) && !are_apart(b, a)
}

/// Of two inks even levels are white, odd ones black; and every mark is painted once.
fn check_levels(drawing: &Drawing) {
    if drawing.palette.len() == 2 {
        let ink_of = |level: u32| if level.is_multiple_of(2) { Ink::WHITE } else { Ink::BLACK };
        assert!(drawing.regions.iter().all(|region| region.ink == ink_of(region.level)));
        assert!(drawing.stipples.iter().all(|dot| dot.ink == ink_of(dot.level)));
    }
    let painted: usize = drawing.levels().iter().map(|level| level.marks.len()).sum();
    let paper = drawing.regions.iter().filter(|region| region.level == 0).count();
    assert_eq!(painted + paper, drawing.regions.len() + drawing.stipples.len());
}

/// Wherever one looks, one mark is there, and painting level by level gives its ink.
fn check_probes(drawing: &Drawing, rings: &[(Ring, Vec<Ring>)]) {
    let dots: Vec<Ring> = dots(drawing).collect();
    let (levels, steps) = (drawing.levels(), PROBES as f64);
    for i in 0..PROBES * PROBES {
        // Off the grid of coordinates.
        let [u, v] = [(i % PROBES) as f64 + 0.4142, (i / PROBES) as f64 + 0.7321];
        let p = [u / steps * drawing.width as f64, v / steps * drawing.height as f64];
        let is_near = |ring: &Ring| edges_of(ring).any(|edge| distance(edge, p) < ROUNDING);
        if rings.iter().any(|(exterior, holes)| is_near(exterior) || holes.iter().any(is_near)) {
            continue;
        }
        let in_region = |(exterior, holes): &(Ring, Vec<Ring>)| holds(exterior, p) && !holes.iter().any(|hole| holds(hole, p));
        let regions = rings.iter().zip(&drawing.regions).filter(|(rings, _)| in_region(rings)).map(|(_, region)| region.ink);
        let of_dots = dots.iter().zip(&drawing.stipples).filter(|(dot, _)| holds(dot, p)).map(|(_, dot)| dot.ink);
        let flat: Vec<Ink> = regions.chain(of_dots).collect();
        let is_painted = |level: &&Level| {
            level.marks.iter().any(|mark| match *mark {
                Mark::Region(region) => holds(&rings[region as usize].0, p),
                Mark::Stipple(dot) => holds(&dots[dot as usize], p),
            })
        };
        let layered = levels.iter().rev().find(is_painted).map_or(drawing.palette.paper_label(), |level| level.ink);
        assert_eq!(flat, [layered], "what is at {p:?}, flat and layered");
    }
}

fn distance([a, b]: [Point; 2], p: Point) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    let along = ((p[0] - a[0]) * x + (p[1] - a[1]) * y) / (x * x + y * y);
    let along = along.clamp(0.0, 1.0);
    (a[0] + along * x - p[0]).hypot(a[1] + along * y - p[1])
}

/// Whether a point lies in a ring.
fn holds(ring: &Ring, p: Point) -> bool {
    let crosses =
        |[a, b]: &[Point; 2]| (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    edges_of(ring).filter(crosses).count() % 2 == 1
}

/// The raster is as light as the marks say.
fn check_raster(drawing: &Drawing, rings: &[(Ring, Vec<Ring>)]) {
    let canvas = (drawing.width * drawing.height) as f64;
    let regions = (0..drawing.regions.len()).map(|i| (drawing.regions[i].ink, drawing.region_area(i)));
    let of_dots = dots(drawing).zip(&drawing.stipples).map(|(dot, stipple)| (stipple.ink, signed_area(&dot)));
    let marks: Vec<(Ink, f64)> = regions.chain(of_dots).collect();
    let raster = raster::rasterize(drawing, Some(MAX_SIDE)).expect("a small raster");
    // Polygons lie beside the curves, and coverage is counted in steps.
    let length: f64 = rings
        .iter()
        .flat_map(|(exterior, holes)| std::iter::once(exterior).chain(holes))
        .flat_map(edges_of)
        .map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1]))
        .sum();
    let pixel = drawing.width as f64 / raster.width as f64;
    let allowed = 0.004 + length * (drawing.flattening_tolerance() + 0.02 * pixel) / canvas;
    for channel in 0..raster.channels {
        let of_mark = |(ink, area): &(Ink, f64)| f64::from(drawing.palette.rgb(*ink)[channel]) / 255.0 * area;
        let expected = marks.iter().map(of_mark).sum::<f64>() / canvas;
        let values = raster.values.iter().skip(channel).step_by(raster.channels);
        let light = values.map(|value| f64::from(*value)).sum::<f64>() / (255.0 * (raster.width * raster.height) as f64);
        assert!((light - expected).abs() <= allowed, "the raster is {light}, the marks are {expected}");
    }
}

/// Every file of it gives it back.
fn check_files(drawing: &Drawing) {
    let again = |suffix: &str, export: Export| {
        let format = Format::of_suffix(suffix).expect("there is such a format");
        let writer = format.writer(export.check().expect("the export is sound")).expect("it has these settings");
        load(&writer.write(drawing).expect("it fits"), format, &Control::new()).expect("what was written can be read")
    };
    assert!(again("json", Export::default()) == *drawing, "JSON gives another drawing");
    let all: Vec<&str> = drawing.palette.names().collect();
    let mut ways = vec![(Style::Flat, Only::default()), (Style::Flat, Only::named(&all))];
    if drawing.palette.is_black_and_white() {
        ways.push((Style::Flat, Only::named(&[drawing.palette.paper_name()])));
    }
    if !drawing.palette.overprint() {
        ways.push((Style::Layered, Only::default()));
    }
    for (style, only) in ways {
        let loaded = again("svg", Export { style, only: only.clone(), ..Export::default() });
        assert!(loaded == *drawing, "SVG gives another drawing, {style:?} {only:?}");
    }
}
