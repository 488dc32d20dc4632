//! A drawing as DXF: closed polylines or splines, and circles, in millimetres, for laser cutters, plotters, mills and CAD.
//!
//! # What is written
//! AutoCAD 2000's version of the format, the oldest that states its unit, so that no program has to ask how large the drawing is.
//! Its LWPOLYLINE takes half the bytes of the POLYLINE of release 12. y runs up from the page's lower edge. Curves are flattened
//! within the drawing's [tolerance](Drawing::flattening_tolerance), or they are SPLINE: closed, with the drawing's own control points. Circles are
//! CIRCLE. Holes are closed outlines of their own: what lies inside them is for the program that reads it to decide.
//!
//! The page is the paper of both layouts, as wide and as high as it is and not turned, and the limits of paper space, which
//! LibreCAD prints by. Without them programs print on A4 or A3, upright.
//!
//! A flat drawing of one ink has every boundary exactly once, so nothing is cut twice. With both inks each boundary comes twice, on
//! different layers. DXF layers have the ids of the drawing's layers; black ones have colour 7 (black on white paper), white ones
//! colour 1 (red). A painted paper is a rectangle on the layer `paper`, of the number of the nearest
//! colour, or of 8 (grey) where none was asked for.
//!
//! # Why by hand
//! The format is pairs of lines, the file a fixed frame around them. The crate `dxf` brings twenty others, puts the time and random
//! identifiers into every file, and writes tables that other readers have to repair.

use std::fmt::Write;

use kurbo::{BezPath, ParamCurve, PathEl, PathSeg, Point};

use crate::base::{Ink, Result, flatten_path, is_mirrored};
use crate::drawing::Drawing;
use crate::files::export::{Curves, Export};
use crate::files::layers::{Layer, Outline};
use crate::files::layout::Placement;

/// Millimetres to the point.
const MM_PER_POINT: f64 = 25.4 / 72.0;

/// Positions are rounded to a micrometre, and on a small canvas to this part of its pixel.
const ROUNDING: f64 = 0.01;

/// Digits after the decimal point that no position needs more of.
const MOST_DECIMALS: usize = 9;

/// Handle of the block record that holds everything drawn: every entity names its owner.
const MODEL_SPACE: &str = "1F";

/// The first handle of the layers and entities; those of the frame lie below it.
const FIRST_HANDLE: usize = 0x100;

/// Tables before that of the layers: the view, and the three line types that must be there.
const TABLES: &str = "\
0|SECTION|2|TABLES|\
0|TABLE|2|VPORT|5|8|330|0|100|AcDbSymbolTable|70|0|0|ENDTAB|\
0|TABLE|2|LTYPE|5|5|330|0|100|AcDbSymbolTable|70|3|\
0|LTYPE|5|14|330|5|100|AcDbSymbolTableRecord|100|AcDbLinetypeTableRecord|2|ByBlock|70|0|3||72|65|73|0|40|0.0|\
0|LTYPE|5|15|330|5|100|AcDbSymbolTableRecord|100|AcDbLinetypeTableRecord|2|ByLayer|70|0|3||72|65|73|0|40|0.0|\
0|LTYPE|5|16|330|5|100|AcDbSymbolTableRecord|100|AcDbLinetypeTableRecord|2|Continuous|70|0|3||72|65|73|0|40|0.0|\
0|ENDTAB|";

/// From the text styles to the beginning of the entities: nothing here is the drawing's.
const BLOCKS: &str = "\
0|TABLE|2|STYLE|5|3|330|0|100|AcDbSymbolTable|70|1|\
0|STYLE|5|11|330|3|100|AcDbSymbolTableRecord|100|AcDbTextStyleTableRecord|2|Standard|70|0|40|0.0|\
41|1.0|50|0.0|71|0|42|2.5|3|txt|4||\
0|ENDTAB|\
0|TABLE|2|VIEW|5|6|330|0|100|AcDbSymbolTable|70|0|0|ENDTAB|\
0|TABLE|2|UCS|5|7|330|0|100|AcDbSymbolTable|70|0|0|ENDTAB|\
0|TABLE|2|APPID|5|9|330|0|100|AcDbSymbolTable|70|1|\
0|APPID|5|12|330|9|100|AcDbSymbolTableRecord|100|AcDbRegAppTableRecord|2|ACAD|70|0|\
0|ENDTAB|\
0|TABLE|2|DIMSTYLE|5|A|330|0|100|AcDbSymbolTable|70|1|100|AcDbDimStyleTable|\
0|DIMSTYLE|105|27|330|A|100|AcDbSymbolTableRecord|100|AcDbDimStyleTableRecord|2|Standard|70|0|\
0|ENDTAB|\
0|TABLE|2|BLOCK_RECORD|5|1|330|0|100|AcDbSymbolTable|70|2|\
0|BLOCK_RECORD|5|1F|330|1|100|AcDbSymbolTableRecord|100|AcDbBlockTableRecord|2|*Model_Space|340|23|\
0|BLOCK_RECORD|5|1B|330|1|100|AcDbSymbolTableRecord|100|AcDbBlockTableRecord|2|*Paper_Space|340|24|\
0|ENDTAB|0|ENDSEC|\
0|SECTION|2|BLOCKS|\
0|BLOCK|5|20|330|1F|100|AcDbEntity|8|0|100|AcDbBlockBegin|2|*Model_Space|70|0|10|0.0|20|0.0|30|0.0|3|*Model_Space|1||\
0|ENDBLK|5|21|330|1F|100|AcDbEntity|8|0|100|AcDbBlockEnd|\
0|BLOCK|5|1C|330|1B|100|AcDbEntity|67|1|8|0|100|AcDbBlockBegin|2|*Paper_Space|70|0|10|0.0|20|0.0|30|0.0|3|*Paper_Space|1||\
0|ENDBLK|5|1D|330|1B|100|AcDbEntity|67|1|8|0|100|AcDbBlockEnd|\
0|ENDSEC|\
0|SECTION|2|ENTITIES|";

/// What follows the entities: the dictionaries that must be there, up to the layouts.
const OBJECTS: &str = "\
0|ENDSEC|\
0|SECTION|2|OBJECTS|\
0|DICTIONARY|5|C|330|0|100|AcDbDictionary|281|1|3|ACAD_GROUP|350|D|3|ACAD_LAYOUT|350|22|\
0|DICTIONARY|5|D|330|C|100|AcDbDictionary|281|1|\
0|DICTIONARY|5|22|330|C|100|AcDbDictionary|281|1|3|Model|350|23|3|Layout1|350|24|";

/// Handle, name, block record, place among the tabs and flags of plotting (1024: it is model space) of every layout.
const LAYOUTS: [(&str, &str, &str, u8, u16); 2] = [("23", "Model", MODEL_SPACE, 0, 1024), ("24", "Layout1", "1B", 1, 0)];

/// The drawing as the text of a DXF file.
///
/// # Errors
/// As [`super::layout::Layout::place`].
///
/// # Runtime
/// Linear in the number of points.
pub(super) fn to_dxf(drawing: &Drawing, export: &Export) -> Result<String> {
    let placement = export.layout.place(drawing.width, drawing.height)?;
    let layers = export.layers_of(drawing, &placement)?;
    let mut names: Vec<(&str, u8)> = vec![("0", 7)];
    // Outlines cover nothing, so none needs an underlay.
    let paper = layers.grounds.iter().find(|ground| ground.id == "paper");
    names.extend(paper.map(|paper| (paper.id, export.paper.as_ref().map_or(GREY, |colour| nearest_colour(colour.rgb())))));
    let is_plain = drawing.palette.is_black_and_white();
    let colour_of = |layer: &Layer| if is_plain || layer.is_registration() { colour(layer.ink) } else { nearest_colour(layer.rgb) };
    names.extend(layers.layers.iter().map(|layer| (layer.id.as_str(), colour_of(layer))));

    let mut writer = Writer::new(placement, FIRST_HANDLE + names.len());
    if let Some(paper) = paper {
        let [left, top, right, bottom] = paper.rectangle([drawing.width, drawing.height], &placement);
        writer.polyline(paper.id, &[[left, top], [right, top], [right, bottom], [left, bottom]]);
    }
    for layer in &layers.layers {
        for outline in layer.areas.iter().flat_map(|area| std::iter::once(&area.exterior).chain(&area.holes)) {
            match *outline {
                Outline::Circle { x, y, radius } => writer.circle(&layer.id, [x, y], radius),
                Outline::Path(ref path) if export.curves == Curves::Splines => writer.spline(&layer.id, path),
                Outline::Path(ref path) => {
                    writer.polyline(&layer.id, &flatten_path(path, drawing.flattening_tolerance()));
                }
            }
        }
    }

    let mut text = String::with_capacity(writer.text.len() + 8192);
    text.push_str(&header(&placement, writer.handle));
    push(&mut text, TABLES);
    push(&mut text, &format!("0|TABLE|2|LAYER|5|2|330|0|100|AcDbSymbolTable|70|{}|", names.len()));
    for ((name, colour), handle) in names.iter().zip(FIRST_HANDLE..) {
        let record = format!("0|LAYER|5|{handle:X}|330|2|100|AcDbSymbolTableRecord|100|AcDbLayerTableRecord|");
        push(&mut text, &format!("{record}2|{name}|70|0|62|{colour}|6|Continuous|"));
    }
    push(&mut text, "0|ENDTAB|");
    push(&mut text, BLOCKS);
    text.push_str(&writer.text);
    push(&mut text, OBJECTS);
    layouts(&mut text, &placement);
    push(&mut text, "0|ENDSEC|0|EOF|");
    Ok(text)
}

/// The sides of the page in millimetres.
fn page(placement: &Placement) -> [f64; 2] {
    placement.page.map(|side| (side * MM_PER_POINT * 1e6).round() / 1e6)
}

/// Both layouts, with the page as their paper: no margins, millimetres, one to one, not turned.
fn layouts(text: &mut String, placement: &Placement) {
    let [width, height] = page(placement);
    for (handle, name, block, tab, flags) in LAYOUTS {
        let settings = format!(
            "0|LAYOUT|5|{handle}|330|22|100|AcDbPlotSettings|1||4|{width:?}x{height:?}mm|6||40|0.0|41|0.0|42|0.0|43|0.0|44|{width:?}|\
             45|{height:?}|46|0.0|47|0.0|48|0.0|49|0.0|140|0.0|141|0.0|142|1.0|143|1.0|70|{flags}|72|1|73|0|74|5|7||75|16|147|1.0|\
             148|0.0|149|0.0|"
        );
        let layout = format!(
            "100|AcDbLayout|1|{name}|70|1|71|{tab}|10|0.0|20|0.0|11|{width:?}|21|{height:?}|12|0.0|22|0.0|32|0.0|14|0.0|24|0.0|34|0.0|\
             15|{width:?}|25|{height:?}|35|0.0|146|0.0|13|0.0|23|0.0|33|0.0|16|1.0|26|0.0|36|0.0|17|0.0|27|1.0|37|0.0|76|0|330|{block}|"
        );
        push(text, &settings);
        push(text, &layout);
    }
}

fn colour(ink: Ink) -> u8 {
    match ink {
        Ink::BLACK => 7,
        _ => 1,
    }
}

/// The colour of a paper that nobody has chosen.
const GREY: u8 = 8;

/// The number of the colour that is nearest to an sRGB one: files of AutoCAD 2000 have numbers for colours and nothing else.
///
/// Programs agree on 24 full hues, their tints, white and grey; what they show for the darker ones differs.
fn nearest_colour(rgb: [u8; 3]) -> u8 {
    let hues = (10..250).step_by(10).flat_map(|number| [(number, hue(number, 0)), (number + 1, hue(number, 127))]);
    let distance = |other: [u8; 3]| -> i32 { rgb.iter().zip(other).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum() };
    let all = hues.chain([(255, [255; 3]), (GREY, [128; 3])]);
    all.min_by_key(|(_, other)| distance(*other)).expect("there are colours").0
}

/// The sRGB value of the hue of a number, 10, 20 and so on to 240, whose weakest channel has the value `least`.
fn hue(number: u8, least: u8) -> [u8; 3] {
    // In sixths of the circle: a channel is full within one of its own place, and weakest from two on.
    let hue = f64::from(number / 10 - 1) / 4.0;
    [0.0, 2.0, 4.0].map(|place: f64| {
        let away = (hue - place).rem_euclid(6.0).min((place - hue).rem_euclid(6.0));
        let least = f64::from(least);
        (least + (255.0 - least) * (2.0 - away).clamp(0.0, 1.0)) as u8
    })
}

/// Appends group codes and values that are separated by bars, each on a line of its own.
fn push(text: &mut String, pairs: &str) {
    text.extend(pairs.chars().map(|c| if c == '|' { '\n' } else { c }));
}

/// The version, the units (4 is millimetres) and the page as the drawing's extents and limits. `next` is a handle that nothing has.
fn header(placement: &Placement, next: usize) -> String {
    let [width, height] = page(placement);
    let mut text = String::new();
    push(
        &mut text,
        &format!(
            "999|graphstipple {}|0|SECTION|2|HEADER|9|$ACADVER|1|AC1015|9|$DWGCODEPAGE|3|ANSI_1252|9|$INSBASE|10|0.0|20|0.0|30|0.0|\
             9|$EXTMIN|10|0.0|20|0.0|30|0.0|9|$EXTMAX|10|{width:?}|20|{height:?}|30|0.0|9|$LIMMIN|10|0.0|20|0.0|\
             9|$LIMMAX|10|{width:?}|20|{height:?}|9|$PINSBASE|10|0.0|20|0.0|30|0.0|9|$PLIMMIN|10|0.0|20|0.0|\
             9|$PLIMMAX|10|{width:?}|20|{height:?}|9|$INSUNITS|70|4|9|$MEASUREMENT|70|1|9|$LUNITS|70|2|9|$HANDSEED|5|{next:X}|\
             0|ENDSEC|0|SECTION|2|CLASSES|0|ENDSEC|",
            env!("CARGO_PKG_VERSION")
        ),
    );
    text
}

/// A path as one clamped B-spline.
struct Spline {
    degree: usize,
    controls: Vec<Point>,
    knots: Vec<usize>,
}

impl Spline {
    /// Every piece begins at a whole knot, which is there as often as the degree; once, and without its control point, where two
    /// quadratic pieces join halfway between their control points.
    fn of(path: &BezPath) -> Self {
        let degree = if path.elements().iter().any(|element| matches!(element, PathEl::CurveTo(..))) { 3 } else { 2 };
        let pieces: Vec<PathSeg> = path.segments().collect();
        let mut controls: Vec<Point> = pieces.first().map(|piece| piece.start()).into_iter().collect();
        let mut knots = vec![0; degree + 1];
        for (i, piece) in pieces.iter().enumerate() {
            match (degree, *piece) {
                (2, PathSeg::Quad(quad)) => controls.push(quad.p1),
                (2, line) => controls.push(line.start().midpoint(line.end())),
                (_, piece) => controls.extend([piece.to_cubic().p1, piece.to_cubic().p2]),
            }
            let next = pieces.get(i + 1);
            if degree == 2 && next.is_some_and(|next| is_mirrored(&piece.as_path_el(), &next.as_path_el())) {
                knots.push(i + 1);
            } else {
                controls.push(piece.end());
                knots.extend(std::iter::repeat_n(i + 1, degree));
            }
        }
        knots.extend(knots.last().copied());
        Self { degree, controls, knots }
    }
}

/// Writes entities.
struct Writer {
    text: String,
    /// That of the next entity.
    handle: usize,
    placement: Placement,
    mm_per_px: f64,
    /// Digits after the decimal point, and the power of ten that has as many zeros.
    decimals: usize,
    power: f64,
    /// Points of the current polyline as they will be written.
    points: Vec<[i64; 2]>,
}

impl Writer {
    fn new(placement: Placement, handle: usize) -> Self {
        let mm_per_px = placement.scale * MM_PER_POINT;
        let mut decimals = 3;
        let mut power = 1000.0;
        while power * ROUNDING * mm_per_px < 1.0 && decimals < MOST_DECIMALS {
            decimals += 1;
            power *= 10.0;
        }
        Self { text: String::new(), handle, placement, mm_per_px, decimals, power, points: Vec::new() }
    }

    /// A closed ring, given in pixels of the canvas. What rounds to fewer than three points encloses nothing and is left out.
    fn polyline(&mut self, layer: &str, ring: &[[f64; 2]]) {
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        points.extend(ring.iter().map(|p| self.position(*p)));
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() >= 3 {
            self.begin("LWPOLYLINE", layer);
            let _ = write!(self.text, "100\nAcDbPolyline\n90\n{}\n70\n1\n", points.len());
            for [x, y] in &points {
                self.number(10, *x);
                self.number(20, *y);
            }
        }
        self.points = points;
    }

    /// A closed path as a spline that is exactly it: of degree 2, or 3 if one of its curves is cubic.
    fn spline(&mut self, layer: &str, path: &BezPath) {
        let Spline { degree, controls, knots } = Spline::of(path);
        self.begin("SPLINE", layer);
        // Closed and flat; how close knots and control points have to be to be the same.
        let counts = [(70, 9), (71, degree), (72, knots.len()), (73, controls.len()), (74, 0)];
        self.text.push_str("100\nAcDbSpline\n210\n0.0\n220\n0.0\n230\n1.0\n");
        for (code, count) in counts {
            let _ = write!(self.text, "{code}\n{count}\n");
        }
        self.text.push_str("42\n1e-9\n43\n1e-9\n");
        for knot in knots {
            let _ = write!(self.text, "40\n{knot}.0\n");
        }
        for point in controls {
            let [x, y] = self.position([point.x, point.y]);
            self.number(10, x);
            self.number(20, y);
            self.text.push_str("30\n0.0\n");
        }
    }

    fn circle(&mut self, layer: &str, centre: [f64; 2], radius: f64) {
        self.begin("CIRCLE", layer);
        self.text.push_str("100\nAcDbCircle\n");
        let [x, y] = self.position(centre);
        self.number(10, x);
        self.number(20, y);
        self.number(40, ((radius * self.mm_per_px * self.power).round() as i64).max(1));
    }

    fn begin(&mut self, kind: &str, layer: &str) {
        // Writing to a string cannot fail.
        let _ = write!(self.text, "0\n{kind}\n5\n{:X}\n330\n{MODEL_SPACE}\n100\nAcDbEntity\n8\n{layer}\n", self.handle);
        self.handle += 1;
    }

    /// A point of the canvas on the page, in millimetres times the power of ten, y up.
    fn position(&self, [x, y]: [f64; 2]) -> [i64; 2] {
        let left = self.placement.origin[0] * MM_PER_POINT + x * self.mm_per_px;
        let up = (self.placement.page[1] - self.placement.origin[1]) * MM_PER_POINT - y * self.mm_per_px;
        [left, up].map(|value| (value * self.power).round() as i64)
    }

    /// A group code and a number without trailing zeros; it keeps one digit after the point, since some readers tell reals by it.
    fn number(&mut self, code: u8, value: i64) {
        let power = self.power as u64;
        let sign = if value < 0 { "-" } else { "" };
        let (whole, rest) = (value.unsigned_abs() / power, value.unsigned_abs() % power);
        let _ = write!(self.text, "{code}\n{sign}{whole}.{rest:0width$}", width = self.decimals);
        while self.text.ends_with('0') && !self.text.ends_with(".0") {
            self.text.pop();
        }
        self.text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::signed_area;
    use crate::drawing::{Ring, RingPart};
    use crate::files::layers::Style;
    use crate::files::layout::Layout;
    use crate::files::svg::samples;
    use crate::options::Only;

    /// The pairs of a file.
    fn pairs(text: &str) -> Vec<(u16, &str)> {
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len().is_multiple_of(2), "a code without a value");
        lines.chunks(2).map(|pair| (pair[0].parse().unwrap(), pair[1])).collect()
    }

    #[derive(Debug, PartialEq)]
    enum Entity {
        Polyline(Vec<[f64; 2]>),
        Circle([f64; 2], f64),
    }

    /// Layer and shape of every entity.
    fn entities(text: &str) -> Vec<(String, Entity)> {
        let pairs = pairs(text);
        let begin = pairs.iter().position(|p| *p == (2, "ENTITIES")).unwrap() + 1;
        let end = begin + pairs[begin..].iter().position(|p| *p == (0, "ENDSEC")).unwrap();
        let of = |group: &[(u16, &str)]| {
            let values = |code: u16| group.iter().filter(move |p| p.0 == code).map(|p| p.1);
            let numbers = |code| values(code).map(|v| v.parse::<f64>().unwrap());
            let points: Vec<[f64; 2]> = numbers(10).zip(numbers(20)).map(|(x, y)| [x, y]).collect();
            let entity = match group[0].1 {
                "CIRCLE" => Entity::Circle(points[0], numbers(40).next().unwrap()),
                "LWPOLYLINE" => {
                    assert_eq!(values(90).next(), Some(points.len().to_string().as_str()));
                    assert_eq!(values(70).next(), Some("1"), "not closed");
                    Entity::Polyline(points)
                }
                other => panic!("{other}"),
            };
            (values(8).next().unwrap().to_owned(), entity)
        };
        pairs[begin..end].chunk_by(|_, next| next.0 != 0).map(of).collect()
    }

    fn value_of<'a>(text: &'a str, variable: &str) -> &'a str {
        let pairs = pairs(text);
        pairs[pairs.iter().position(|p| p.1 == variable).unwrap() + 1].1
    }

    #[test]
    fn every_boundary_of_a_flat_drawing_comes_once() {
        let mut drawing = samples::nested();
        let hole = |part| Ring { parts: vec![part] };
        drawing.regions[0].holes.push(hole(RingPart::Curve { index: 1, reversed: true }));
        drawing.regions[1].holes.push(hole(RingPart::Stipple { index: 0 }));
        let text = to_dxf(&drawing, &Export::default()).unwrap();
        assert_eq!(text, to_dxf(&drawing, &Export::default()).unwrap());
        let found = entities(&text);
        let layers: Vec<&str> = found.iter().map(|e| e.0.as_str()).collect();
        assert_eq!(layers, [vec!["black-regions"; 3], vec!["black-stipples"; 4]].concat());

        // px are 25.4 / 96 mm, y runs up from the lower edge of 48 px.
        let mm = 25.4 / 96.0;
        let Entity::Circle(centre, radius) = &found[3].1 else { panic!("{:?}", found[3]) };
        for (value, expected) in [(centre[0], 15.7 * mm), (centre[1], (48.0 - 23.9) * mm), (*radius, 2.35 * mm)] {
            assert!((value - expected).abs() <= 0.0005 + 1e-9, "{value} instead of {expected}");
        }
        let Entity::Polyline(ring) = &found[0].1 else { panic!("{:?}", found[0]) };
        let (exterior, _) = drawing.region_rings(0);
        assert!((signed_area(ring) / mm / mm + signed_area(&exterior)).abs() < 0.5, "turned over, as y is");
        let (low, high) = ring.iter().fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p[1]), high.max(p[1])));
        assert_eq!((low, high), (0.0, 12.7));
    }

    #[test]
    fn splines_are_the_curves() {
        let drawing = samples::nested();
        let text = to_dxf(&drawing, &Export { curves: Curves::Splines, ..Export::default() }).unwrap();
        assert_eq!(text.matches("\nSPLINE\n").count(), 2);
        assert!(!text.contains("LWPOLYLINE"));
        let path = drawing.ring_path(&drawing.regions[0].exterior);
        let spline = Spline::of(&path);
        assert_eq!((spline.degree, spline.knots.len()), (2, spline.controls.len() + 3));
        assert_eq!(spline.controls.first(), spline.controls.last());
        let pieces = path.segments().count();
        assert_eq!(spline.knots.last(), Some(&pieces));
        // Every piece of the path is the spline's, by de Boor's algorithm in the middle of it.
        for (i, piece) in path.segments().enumerate() {
            let t = i as f64 + 0.5;
            let k = spline.knots.iter().rposition(|knot| *knot == i).unwrap();
            let mut points = spline.controls[k - 2..=k].to_vec();
            for level in 1..=2 {
                for j in (level..=2).rev() {
                    let [from, to] = [spline.knots[k - 2 + j] as f64, spline.knots[k + 1 + j - level] as f64];
                    points[j] = points[j - 1].lerp(points[j], (t - from) / (to - from));
                }
            }
            assert!((points[2] - piece.eval(0.5)).hypot() < 1e-9, "piece {i}");
        }
    }

    #[test]
    fn cubic_curves_make_cubic_splines() {
        let mut path = BezPath::new();
        path.move_to((0.0, 0.0));
        path.curve_to((1.0, 0.0), (2.0, 1.0), (2.0, 2.0));
        path.line_to((0.0, 2.0));
        path.close_path();
        let Spline { degree, controls, knots } = Spline::of(&path);
        assert_eq!((degree, controls.len()), (3, 10));
        assert_eq!(knots, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3]);
    }

    #[test]
    fn the_header_tells_units_and_page() {
        let layout = Layout { width: Some("200mm".parse().unwrap()), margin: "10mm".parse().unwrap(), ..Layout::default() };
        let text = to_dxf(&samples::nested(), &Export { layout, ..Export::default() }).unwrap();
        assert_eq!(
            (value_of(&text, "$INSUNITS"), value_of(&text, "$MEASUREMENT"), value_of(&text, "$ACADVER")),
            ("4", "1", "AC1015")
        );
        assert_eq!((value_of(&text, "$EXTMAX"), value_of(&text, "$PLIMMAX")), ("220.0", "220.0"));
        // Both layouts are a page of 220 mm x 170 mm that is not turned.
        for (code, value) in [(44, "220.0"), (45, "170.0"), (73, "0")] {
            let after = pairs(&text).split(|pair| *pair == (0, "LAYOUT")).skip(1).filter(|of| of.contains(&(code, value))).count();
            assert_eq!(after, 2, "{code}");
        }
        let handles: Vec<&str> = pairs(&text).iter().filter(|p| p.0 == 5 || p.0 == 105).map(|p| p.1).collect();
        let unique: std::collections::BTreeSet<&str> = handles.iter().copied().collect();
        assert_eq!(unique.len(), handles.len());
        let seed = usize::from_str_radix(value_of(&text, "$HANDSEED"), 16).unwrap();
        assert!(
            handles.iter().filter(|h| **h != value_of(&text, "$HANDSEED")).all(|h| usize::from_str_radix(h, 16).unwrap() < seed)
        );
    }

    #[test]
    fn both_inks_and_layered_drawings_have_more_layers() {
        let layers_of = |export: Export| {
            let text = to_dxf(&samples::nested(), &export).unwrap();
            let mut layers: Vec<String> = entities(&text).into_iter().map(|e| e.0).collect();
            layers.dedup();
            layers
        };
        let both = layers_of(Export { only: Only::named(&["black", "white"]), ..Export::default() });
        assert_eq!(both, ["black-regions", "black-stipples", "white-regions"]);
        let white = layers_of(Export { only: Only::named(&["white"]), ..Export::default() });
        assert_eq!(white, ["paper", "white-regions"]);
        let layered = layers_of(Export { style: Style::Layered, ..Export::default() });
        assert_eq!(layered[..2], ["paper", "level-1-black-regions"]);
        let text = to_dxf(&samples::nested(), &Export { only: Only::named(&["white"]), ..Export::default() }).unwrap();
        assert!(text.contains("\n2\nwhite-regions\n70\n0\n62\n1\n") && text.contains("\n2\npaper\n70\n0\n62\n8\n"), "{text}");
    }

    #[test]
    fn digits_follow_the_size_of_a_pixel() {
        let write = |scale: f64, value: i64| {
            let mut writer = Writer::new(Placement { scale, page: [1.0, 1.0], origin: [0.0, 0.0] }, 1);
            writer.number(10, value);
            (writer.decimals, writer.text)
        };
        assert_eq!(write(0.75, 12_340), (3, "10\n12.34\n".into()));
        assert_eq!(write(0.75, -12_000), (3, "10\n-12.0\n".into()));
        assert_eq!(write(0.75, 7), (3, "10\n0.007\n".into()));
        assert_eq!(write(0.001, 1_234_567), (6, "10\n1.234567\n".into()));
        assert_eq!(write(1e-9, 1).0, MOST_DECIMALS);
    }

    #[test]
    fn a_paper_is_a_rectangle_of_the_nearest_colour() {
        for (rgb, number) in [([255; 3], 255), ([128, 120, 130], 8), ([255, 0, 0], 10), ([255, 160, 120], 21), ([0, 60, 250], 160)]
        {
            assert_eq!(nearest_colour(rgb), number, "{rgb:?}");
        }
        let mut export =
            Export { paper: Some("#ff0000".parse().unwrap()), only: Only::named(&["black", "white"]), ..Export::default() };
        export.layout.margin = "96px".parse().unwrap();
        let text = to_dxf(&samples::nested(), &export).unwrap();
        assert!(text.contains("\n2\npaper\n70\n0\n62\n10\n") && !text.contains("underlay"), "{text}");
        // An inch of margin around 64 x 48 px.
        let page = "8\npaper\n100\nAcDbPolyline\n90\n4\n70\n1\n10\n0.0\n20\n63.5\n10\n67.733\n20\n63.5\n10\n67.733\n20\n0.0\n10\n0.0\n20\n0.0\n";
        assert!(text.contains(page), "{text}");
    }
}
