//! Drawings of random pictures at every tolerance: nothing crosses, everything is covered once, and files give the drawing back.

use std::f64::consts::PI;

use kurbo::{Affine, BezPath, Line, ParamCurveNearest, PathEl, Point, Shape};
use proptest::prelude::*;

use crate::base::{Control, Ink, Result, signed_area};
use crate::drawing::{Drawing, RingPart};
use crate::files::{Export, Format, Style, load};
use crate::importance::Importance;
use crate::options::{Edge, Only, Options, Published};
use crate::outlines::Stipple;
use crate::photo::{Field, Photo};
use crate::pipeline::Outcome;

type Segment = [[f64; 2]; 2];

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two segments have a point in common.
fn meet([a, b]: Segment, [c, d]: Segment) -> bool {
    let on = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        turn(a, b, p) == 0.0 && (0..2).all(|axis| p[axis] >= a[axis].min(b[axis]) && p[axis] <= a[axis].max(b[axis]))
    };
    let crossed = |a, b, c, d| (turn(a, b, c) > 0.0) != (turn(a, b, d) > 0.0);
    (crossed(a, b, c, d) && crossed(c, d, a, b)) || on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b)
}

/// Every boundary once, as polygons, each with whether it is closed: the curves (as the regions on either side have them), then the
/// dots.
fn boundaries(drawing: &Drawing) -> Vec<(Vec<[f64; 2]>, bool)> {
    let mut boundaries = Vec::new();
    for (index, curve) in drawing.curves.iter().enumerate() {
        let closed = curve.elements().last() == Some(&PathEl::ClosePath);
        // The region whose exterior or hole is this curve alone has its points.
        let ring_of = |region: usize| {
            let (exterior, holes) = drawing.region_rings(region);
            let rings = std::iter::once(&drawing.regions[region].exterior).chain(&drawing.regions[region].holes);
            let points = std::iter::once(exterior).chain(holes);
            rings.zip(points).find(|(ring, _)| ring.parts == [RingPart::Curve { index: index as u32, reversed: false }])
        };
        if closed {
            let ring = (0..drawing.regions.len()).find_map(ring_of).expect("a closed curve bounds a region in its own direction");
            boundaries.push((ring.1, true));
        }
    }
    for index in 0..drawing.stipples.len() {
        boundaries.push((drawing.stipple_outline(index, drawing.flattening_tolerance()), true));
    }
    boundaries
}

fn segments(points: &[[f64; 2]], closed: bool) -> Vec<Segment> {
    let count = if closed { points.len() } else { points.len() - 1 };
    (0..count).map(|i| [points[i], points[(i + 1) % points.len()]]).collect()
}

fn check(drawing: &Drawing) {
    let canvas = (drawing.width * drawing.height) as f64;
    let regions: f64 = (0..drawing.regions.len()).map(|i| drawing.region_area(i)).sum();
    let outlines = (0..drawing.stipples.len()).map(|i| signed_area(&drawing.stipple_outline(i, drawing.flattening_tolerance())));
    assert!(((regions + outlines.sum::<f64>()) / canvas - 1.0).abs() < 1e-6);
    // Rings that touch the frame are looked at whole; the others once each.
    let touching = (0..drawing.regions.len()).filter(|i| drawing.regions[*i].exterior.parts.len() > 1);
    let rings: Vec<Vec<[f64; 2]>> = touching.map(|i| drawing.region_rings(i).0).collect();
    let mut all: Vec<Vec<Segment>> = boundaries(drawing).iter().map(|(points, closed)| segments(points, *closed)).collect();
    all.extend(rings.iter().map(|ring| segments(ring, true)));
    for (i, own) in all.iter().enumerate() {
        assert!(own.len() >= 3);
        for (k, a) in own.iter().enumerate() {
            for b in &own[k + 1..] {
                let neighbours = a[1] == b[0] || b[1] == a[0];
                assert!(neighbours || !meet(*a, *b), "{a:?} meets {b:?} in one ring");
            }
            // Rings on the frame share their curves.
            let others = if i + rings.len() >= all.len() { &[][..] } else { &all[i + 1..] };
            for b in others.iter().flatten() {
                assert!(!meet(*a, *b), "{a:?} meets {b:?}");
            }
        }
    }
}

/// How far polygons may lie from curves when distances between curves are measured, in pixels.
const FLATTENING: f64 = 2e-3;

/// Every curve as a polyline, but those of irregular dots, which are cubic: the tolerance is not about them.
fn polylines(drawing: &Drawing) -> Vec<Vec<Point>> {
    let polyline_of = |curve: &BezPath| {
        let mut points = Vec::new();
        kurbo::flatten(curve, FLATTENING, |element| points.extend(element.end_point().or(points.first().copied())));
        points
    };
    let is_dot = |curve: &&BezPath| curve.elements().iter().any(|element| matches!(element, PathEl::CurveTo(..)));
    drawing.curves.iter().filter(|curve| !is_dot(curve)).map(polyline_of).collect()
}

/// Checks that no curve lies further than the tolerance from that of the full outline, nor the other way round.
fn check_distance(drawing: &Drawing, full: &Drawing, tolerance: f64) {
    let (simple, full) = (polylines(drawing), polylines(full));
    assert_eq!(simple.len(), full.len());
    let limit = (tolerance + 2.0 * FLATTENING).powi(2);
    let is_near = |p: &Point, curve: &[Point]| {
        curve.windows(2).any(|pair| Line::new(pair[0], pair[1]).nearest(*p, FLATTENING).distance_sq <= limit)
    };
    for (curves, others) in [(&simple, &full), (&full, &simple)] {
        for curve in curves {
            let strays = !others.iter().any(|other| curve.iter().all(|p| is_near(p, other)));
            assert!(!strays, "the curve from {:?} lies further than {tolerance} px from the other outline", curve[0]);
        }
    }
}

fn picture(width: usize, height: usize, seed: u64, grain: usize) -> Field {
    let noise = |i: usize| {
        let z = (i as u64 ^ seed).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((z ^ (z >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f32 / (1u64 << 24) as f32
    };
    let value = |i: usize| {
        let (x, y) = (i % width, i / width);
        0.6 * noise(y / grain * width + x / grain) + 0.4 * noise(i + (1 << 20))
    };
    Field::new(width, height, (0..width * height).map(value).collect()).unwrap()
}

/// The drawing of a picture whose importance is the same everywhere.
fn draw(luma: &Field, importance: f32, options: Options) -> Outcome {
    draw_photo(&Photo::new(luma.clone()), importance, options)
}

fn draw_photo(photo: &Photo, importance: f32, options: Options) -> Outcome {
    super::draw(photo, &Importance::Constant(importance), &options.check().unwrap(), &Control::new()).unwrap()
}

/// The parameters of the published method with this density.
fn of_density(density: f64) -> Published {
    Published { density: Some(density), ..Published::ours() }
}

/// The bytes of a drawing's file.
fn written(drawing: &Drawing, suffix: &str, export: Export) -> Vec<u8> {
    Format::of_suffix(suffix).unwrap().writer(export.check().unwrap()).unwrap().write(drawing).unwrap()
}

/// The drawing of such a file.
fn read(bytes: impl AsRef<[u8]>, suffix: &str) -> Result<Drawing> {
    load(bytes.as_ref(), Format::of_suffix(suffix).unwrap(), &Control::new())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn drawings_are_sound_and_survive_files(
        width in 1usize..40, height in 1usize..40, seed in any::<u64>(), grain in 1usize..7,
        factor in prop_oneof![2 => Just(1), 1 => 2usize..6],
        density in prop_oneof![Just(0.3), Just(1.0), Just(4.0)],
        tolerance in prop_oneof![Just(0.0), Just(0.1), Just(0.25), Just(0.5), Just(1.0), Just(2.0)],
        stipple_scale in prop_oneof![Just(1.0), Just(4.0)],
        (stipple_min, stipple_max) in prop_oneof![
            Just((0.0, None)), Just((0.0, Some(0.4))), Just((0.0, Some(1e-9))), Just((0.8, Some(0.9))), Just((1000.0, None)),
        ],
        irregularity in prop_oneof![Just(0.0), Just(0.5), Just(1.0)],
        wobble in prop_oneof![2 => Just(0.0), 1 => Just(0.2), 1 => Just(1.0)],
        edge in prop_oneof![Just(Edge::Smooth), Just(Edge::Inked), Just(Edge::Torn)],
    ) {
        let options = Options {
            published: of_density(density / (factor * factor) as f64), tolerance, stipple_scale, stipple_min, stipple_max,
            irregularity, wobble, edge, seed: seed >> 11, ..Options::default()
        };
        // Mostly with a remainder, when it is reduced.
        let luma = picture(factor * width + seed as usize % factor, factor * height + width % factor, seed, grain * factor);
        let photo = Photo::reduced(luma, factor);
        let drawing = draw_photo(&photo, 0.5, options.clone()).drawing;
        prop_assert_eq!((drawing.width, drawing.height), (photo.width(), photo.height()));
        check(&drawing);
        prop_assert!(drawing.stipples.iter().all(|dot| dot.radius <= stipple_max.unwrap_or(f64::INFINITY)));
        // Irregular dots are curves too, but the tolerance is not about them.
        let [simple, full] = [tolerance, 0.0].map(|tolerance| {
            let options = Options { tolerance, irregularity: 0.0, ..options.clone() };
            draw_photo(&photo, 0.5, options).drawing
        });
        check_distance(&simple, &full, tolerance);

        prop_assert_eq!(&read(written(&drawing, "json", Export::default()), "json").unwrap(), &*drawing);
        for (style, only) in [
            (Style::Flat, Only::default()), (Style::Flat, Only::named(&["white"])),
            (Style::Flat, Only::named(&["black", "white"])), (Style::Layered, Only::default()),
        ] {
            let file = written(&drawing, "svg", Export { style, only: only.clone(), ..Export::default() });
            prop_assert_eq!(&read(file, "svg").unwrap(), &*drawing, "{:?} {}", style, only);
        }

        let (larger, changes) = drawing.with_least_radius(0.7).unwrap();
        check(&larger);
        prop_assert!(larger.stipples.iter().all(|dot| dot.radius >= 0.7));
        let small = drawing.stipples.iter().filter(|dot| dot.radius < 0.7).count();
        prop_assert_eq!(changes.enlarged + changes.dropped, small);
        prop_assert_eq!(larger.stipples.len() + changes.dropped, drawing.stipples.len());
    }
}

#[test]
fn edges_wobble_by_the_seed_alone_and_keep_the_tone() {
    let luma = picture(160, 120, 5, 12);
    let drawn = |wobble: f64, edge: Edge, seed: u64, threads: usize| {
        draw(&luma, 0.5, Options { wobble, edge, seed, threads: Some(threads), ..Options::default() }).drawing
    };
    let black = |drawing: &Drawing| {
        let regions = drawing.regions.iter().enumerate().filter(|(_, region)| region.ink == Ink::BLACK);
        let dots = drawing.stipples.iter().filter(|dot| dot.ink == Ink::BLACK);
        let area = regions.map(|(i, _)| drawing.region_area(i)).sum::<f64>() + dots.map(|dot| PI * dot.radius.powi(2)).sum::<f64>();
        area / (drawing.width * drawing.height) as f64
    };
    let plain = drawn(0.0, Edge::Smooth, 0, 1);
    assert_eq!(drawn(0.0, Edge::Torn, 9, 2).curves, plain.curves);
    for edge in [Edge::Smooth, Edge::Inked, Edge::Torn] {
        for wobble in [0.05, 0.3, 1.0] {
            let wobbly = drawn(wobble, edge, 0, 1);
            check(&wobbly);
            assert_eq!(drawn(wobble, edge, 0, 2), wobbly);
            let other = drawn(wobble, edge, 1, 1);
            assert!(other.curves != wobbly.curves && wobbly.curves != plain.curves);
            for drawing in [&wobbly, &other] {
                assert!((black(drawing) - black(&plain)).abs() < 0.01, "{} was {}", black(drawing), black(&plain));
            }
        }
    }
}

/// A picture on few nodes, with dots of 2 pixels and a little less.
fn sparse(options: Options) -> Outcome {
    draw(&picture(120, 90, 11, 5), 1.0, Options { published: of_density(0.1), relax: 3, ..options })
}

#[test]
fn radii_keep_to_their_limits() {
    let dots = |stipple_min: f64, stipple_max: Option<f64>| {
        sparse(Options { stipple_min, stipple_max, ..Options::default() }).drawing.stipples.clone()
    };
    let plain = dots(0.0, None);
    assert!(plain.iter().any(|dot| dot.radius < 1.5) && plain.iter().any(|dot| dot.radius > 1.8));
    assert!(dots(0.0, Some(1.8)).iter().all(|dot| dot.radius <= 1.8));
    // The largest dot that its star holds, within what the grid may cost.
    let largest = dots(1000.0, None);
    let has_no_more_room = |dot: &Stipple| {
        largest.iter().any(|other| (dot.x - other.x).hypot(dot.y - other.y) < 1.0 && dot.radius >= 0.95 * other.radius)
    };
    for dot in dots(1.5, Some(1.6)) {
        assert!(dot.radius <= 1.6 && (dot.radius >= 1.5 || has_no_more_room(&dot)), "{dot:?}");
    }
}

#[test]
fn irregular_dots_differ_between_seeds_and_are_the_same_in_every_run() {
    let drawn = |irregularity: f64, seed: u64, threads: usize| {
        sparse(Options { irregularity, seed, stipple_max: Some(1.0), threads: Some(threads), ..Options::default() })
    };
    let (round, wavy) = (drawn(0.0, 0, 1), drawn(1.0, 0, 1));
    assert!(wavy.drawing.stipples.is_empty());
    assert_eq!(wavy.drawing.regions.len(), round.drawing.regions.len() + round.drawing.stipples.len());
    assert_eq!(wavy.stats.vertices, round.stats.vertices);
    assert_eq!(drawn(1.0, 0, 3).drawing, wavy.drawing);
    assert_eq!(drawn(0.0, 1, 1).drawing.curves, round.drawing.curves);

    // Curves of one size and of six cubics, from their own begin: the dots.
    let dots = |outcome: &Outcome| {
        let shape = |curve: &BezPath| {
            let begin = curve.elements()[0].end_point().unwrap().to_vec2();
            (curve.elements().len() == 8 && curve.area().abs() < 3.2).then(|| Affine::translate(-begin) * curve.clone())
        };
        outcome.drawing.curves.iter().filter_map(shape).collect::<Vec<BezPath>>()
    };
    let (first, second) = (dots(&wavy), dots(&drawn(1.0, 1, 1)));
    assert!(first.len() >= round.drawing.stipples.len());
    assert!((1..first.len()).all(|i| !first[..i].contains(&first[i])), "two dots are the same");
    assert!(second.iter().filter(|dot| first.contains(dot)).count() < 5);
}

#[test]
fn two_regions_with_one_top_keep_their_order() {
    // Found by the test above: both sides of an open curve, with nothing higher on their other curves.
    let options = Options { published: of_density(1.0), tolerance: 0.5, ..Options::default() };
    let luma = picture(15, 12, 16_723_320_131_703_599_830, 4);
    let drawing = draw(&luma, 0.5, options).drawing;
    assert_eq!(read(written(&drawing, "json", Export::default()), "json").unwrap(), *drawing);
}

#[test]
fn what_is_no_drawing_of_ours_is_refused_in_a_sentence() {
    let luma = picture(20, 20, 7, 3);
    let drawing = draw(&luma, 0.5, Options::default()).drawing;
    let [good_json, good_svg] =
        ["json", "svg"].map(|suffix| String::from_utf8(written(&drawing, suffix, Export::default())).unwrap());
    let broken_json =
        ["", "{}", &good_json.replace("graphstipple drawing", "other"), &good_json.replace("\"curves\":[\"M", "\"curves\":[\"X")];
    let broken_svg = ["", "<svg/>", &good_svg.replace("units=", "unit="), &good_svg.replacen(" d=\"m", " d=\"m1e9 0 5 x", 1)];
    let errors = broken_json.iter().map(|text| read(text, "json")).chain(broken_svg.iter().map(|text| read(text, "svg")));
    for error in errors {
        let text = error.unwrap_err().to_string();
        assert!(text.starts_with("this is not a drawing that graphstipple wrote: "), "{text}");
    }
}

#[test]
fn what_is_told_of_a_drawing_of_another_version_is_kept() {
    let drawing = draw(&picture(20, 20, 7, 3), 0.5, Options::default()).drawing;
    for suffix in ["json", "svg"] {
        let ours = String::from_utf8(written(&drawing, suffix, Export::default())).unwrap();
        let theirs = ours.replacen("\"options\":{\"nodes\":null", "\"options\":{\"wiggle\":0.25,\"nodes\":null", 1).replacen(
            "\"version\":\"",
            "\"subject\":[\"auto\",-0.0,1e-7],\"version\":\"9",
            1,
        );
        assert_eq!(ours.len() + 44, theirs.len(), "{suffix}");
        let read = read(&theirs, suffix).unwrap();
        assert_eq!(read.curves, drawing.curves);
        let told = read.provenance.options().unwrap_err().to_string();
        assert!(told.starts_with("the drawing was made by graphstipple 9") && told.ends_with("does not know: wiggle"), "{told}");
        let again = String::from_utf8(written(&read, suffix, Export::default())).unwrap();
        assert!(again.contains("\"wiggle\":0.25,\"nodes\":null") && again.contains("\"subject\":[\"auto\",-0.0,1e-7]"), "{again}");
        assert_eq!(String::from_utf8(written(&drawing, suffix, Export::default())).unwrap(), ours);
    }
    // What would stand twice in a JSON file is not kept; names are told in one short line, whatever they are.
    let ours = String::from_utf8(written(&drawing, "svg", Export::default())).unwrap();
    let many: String = (0..1000).map(|i| format!("\"new\\nline{i}\":0,")).collect();
    let theirs = ours.replacen("{\"version\":", "{\"canvas\":1,\"format\":2,\"version\":", 1);
    let theirs = theirs.replacen("\"options\":{", &format!("\"options\":{{{many}"), 1);
    let drawing = read(&theirs, "svg").unwrap();
    assert_eq!(read(written(&drawing, "json", Export::default()), "json").unwrap(), drawing);
    let told = drawing.provenance.options().unwrap_err().to_string();
    assert!(told.len() < 200 && told.lines().count() == 1 && told.ends_with("new\\nline4, and 995 more"), "{told}");
}
