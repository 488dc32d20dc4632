//! The drawing as SVG: its layers as named groups, each with one compound path of its ink.
//!
//! # What is written
//! Coordinates are whole numbers in units of the drawing's grid under one transform, relative to the point before, so that nothing
//! is lost and nothing accumulates: [`super::load_svg`] reads the same drawing back. A point on a finer grid has decimals. A control
//! point that is the last one mirrored is what the commands `t` and `s` stand for. Dots are true circles of two arcs.
//!
//! Groups are layers to Inkscape and have the same ids in every file. The size on paper is in the attributes of the root element
//! alone; the data stay in pixels of the canvas. The provenance is JSON in `<metadata>`: enough to make the drawing again.

use kurbo::{BezPath, PathEl, Point, Vec2};

use crate::base::{Ink, Result, is_mirrored};
use crate::drawing::Drawing;
use crate::files::export::Export;
use crate::files::layers::{Layer, Outline};
use crate::files::layout::{Layout, Unit};

/// A path is closed and another one begun after this many bytes: libxml2, and with it librsvg and lxml, refuses attributes above
/// 10 MB, and viewers skip a path that is out of view. Areas of a layer are disjoint, so the picture is the same.
const PATH_BYTES: usize = 1 << 20;

/// Names the element with the provenance; only a name, nothing is there.
pub(crate) const NAMESPACE: &str = "https://github.com/graphstipple/graphstipple";

/// Where Inkscape's attributes live.
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// The drawing as an SVG document.
///
/// # Errors
/// As [`Layout::place`].
///
/// # Runtime
/// Linear in the number of coordinates. The same drawing always gives the same bytes.
pub(super) fn to_svg(drawing: &Drawing, export: &Export) -> Result<String> {
    let (width, height) = (drawing.width, drawing.height);
    let placement = export.layout.place(width, height)?;
    let layers = drawing.layers(export.style, export.inks);
    let elements: usize = drawing.curves.iter().map(|curve| curve.elements().len()).sum();
    let mut writer = PathWriter {
        bytes: Vec::with_capacity(2048 + 16 * elements + 56 * drawing.stipples.len()),
        units: drawing.units,
        ..Default::default()
    };
    // In pixels of the canvas.
    let [left, top] = placement.origin.map(|v| decimal(-v / placement.scale));
    let [page_width, page_height] = placement.page.map(|v| decimal(v / placement.scale));
    let [on_paper_width, on_paper_height] = placement.page.map(|points| on_paper(points, &export.layout));
    let background = if layers.paper == Some(Ink::Black) { "#000" } else { "#fff" };
    let json = serde_json::to_string(&drawing.provenance).expect("plain options always serialize");
    writer.text(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"{INKSCAPE}\" width=\"{on_paper_width}\" \
         height=\"{on_paper_height}\" viewBox=\"{left} {top} {page_width} {page_height}\" style=\"background:{background}\">\n\
         <metadata><graphstipple:drawing xmlns:graphstipple=\"{NAMESPACE}\" width=\"{width}\" height=\"{height}\" units=\"{}\">{}</graphstipple:drawing></metadata>\n",
        drawing.units,
        escape(&json)
    ));
    if let Some(paper) = layers.paper {
        writer.group("paper", "Paper", paper, "");
        writer.text(&format!("<rect width=\"{width}\" height=\"{height}\"/>\n</g>\n"));
    }
    let transform = format!(" transform=\"scale({})\"", (1.0 / drawing.units).to_string().trim_start_matches('0'));
    for layer in &layers.layers {
        writer.layer(layer, &transform);
    }
    writer.text("</svg>\n");
    Ok(String::from_utf8(writer.bytes).expect("only text was written"))
}

/// A length of the page as an attribute: in the unit that was asked for.
fn on_paper(points: f64, layout: &Layout) -> String {
    let unit = match layout.width {
        Some(width) => width.unit,
        None if layout.page.is_some() => Unit::Mm,
        None => Unit::Px,
    };
    let name = if unit == Unit::Px { "" } else { unit.name() };
    format!("{}{name}", decimal(points / unit.points()))
}

/// A number without a trace of rounding in its last digits: six decimals at most, none that is 0.
fn decimal(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // Not -0.
    let text = (rounded + 0.0).to_string();
    match text.strip_prefix("0.") {
        Some(fraction) => format!(".{fraction}"),
        None => text,
    }
}

/// Escapes what may not stand in XML character data.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Appends path data with relative commands and as few separators and letters as the grammar asks for. All points are in units.
#[derive(Debug, Default)]
struct PathWriter {
    bytes: Vec<u8>,
    /// Units to a pixel.
    units: f64,
    /// The current point.
    current: Point,
    /// Where the current subpath began: the current point again after its `z`.
    start: Point,
    /// The command that numbers without a letter would continue; 0 for none.
    implied: u8,
    /// Whether the last number had a decimal point, so that another may begin with one right away.
    has_point: bool,
}

impl PathWriter {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn group(&mut self, id: &str, label: &str, ink: Ink, transform: &str) {
        let fill = if ink == Ink::Black { "" } else { " fill=\"#fff\"" };
        self.text(&format!("<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\"{fill}{transform}>\n"));
    }

    fn layer(&mut self, layer: &Layer, transform: &str) {
        self.group(&layer.id, &layer.label, layer.ink, transform);
        let mut begin = self.open();
        for area in &layer.areas {
            if self.bytes.len() - begin > PATH_BYTES {
                self.text("\"/>\n");
                begin = self.open();
            }
            self.outline(&area.exterior, true);
            for hole in &area.holes {
                self.outline(hole, false);
            }
        }
        self.text("\"/>\n</g>\n");
    }

    /// Begins a path element; returns where its data begins.
    fn open(&mut self) -> usize {
        self.text("<path d=\"");
        (self.current, self.start) = (Point::ZERO, Point::ZERO);
        (self.implied, self.has_point) = (0, false);
        self.bytes.len()
    }

    fn outline(&mut self, outline: &Outline, is_exterior: bool) {
        match outline {
            Outline::Path(path) => self.ring(path),
            Outline::Circle { x, y, radius } => self.circle(Point::new(*x, *y), *radius, is_exterior),
        }
    }

    /// A closed path, given in pixels.
    fn ring(&mut self, path: &BezPath) {
        let (elements, scale) = (path.elements(), self.units);
        let units = |p: Point| Point::new(p.x * scale, p.y * scale);
        let mut last = &PathEl::ClosePath;
        for (i, element) in elements.iter().enumerate() {
            let is_mirrored = is_mirrored(last, element);
            last = element;
            match *element {
                PathEl::MoveTo(p) => self.move_to(units(p)),
                PathEl::LineTo(p) => {
                    // `z` draws the line back to the start.
                    if !(units(p) == self.start && matches!(elements.get(i + 1), None | Some(PathEl::ClosePath))) {
                        self.line_to(units(p));
                    }
                }
                PathEl::QuadTo(c, p) => self.quad_to((!is_mirrored).then(|| units(c)), units(p)),
                PathEl::CurveTo(c, d, p) => self.curve_to((!is_mirrored).then(|| units(c)), units(d), units(p)),
                PathEl::ClosePath => self.close(),
            }
        }
    }

    /// A circle of two arcs that begins at its leftmost point, in the regions' direction or, as a hole, against it.
    fn circle(&mut self, centre: Point, radius: f64, is_exterior: bool) {
        let radius = radius * self.units;
        // The leftmost point is on the grid; the subtraction may have rounded.
        let left = ((centre.x * self.units - radius) * LEFT_GRID).round() / LEFT_GRID;
        self.move_to(Point::new(left, centre.y * self.units));
        self.command(b'a');
        for diameter in [2.0 * radius, -2.0 * radius] {
            self.number(radius);
            self.number(radius);
            // Large-arc and sweep flags; of two half circles either would do for the first.
            self.text(if is_exterior { " 0 1 1" } else { " 0 1 0" });
            self.has_point = false;
            self.number(diameter);
            self.number(0.0);
        }
        self.close();
    }

    fn move_to(&mut self, p: Point) {
        self.implied = 0;
        self.command(b'm');
        self.offset(p);
        // Numbers after a move continue with lines.
        self.implied = b'l';
        (self.current, self.start) = (p, p);
    }

    fn line_to(&mut self, p: Point) {
        let by = p - self.current;
        if by == Vec2::ZERO {
            return;
        }
        if by.y == 0.0 {
            self.command(b'h');
            self.number(by.x);
        } else if by.x == 0.0 {
            self.command(b'v');
            self.number(by.y);
        } else {
            self.command(b'l');
            self.offset(p);
        }
        self.current = p;
    }

    /// A quadratic curve, without its control point if that is the last one mirrored.
    fn quad_to(&mut self, control: Option<Point>, end: Point) {
        self.command(if control.is_some() { b'q' } else { b't' });
        control.into_iter().for_each(|p| self.offset(p));
        self.offset(end);
        self.current = end;
    }

    /// A cubic curve, without its first control point if that is the last one mirrored.
    fn curve_to(&mut self, first: Option<Point>, second: Point, end: Point) {
        self.command(if first.is_some() { b'c' } else { b's' });
        first.into_iter().chain([second, end]).for_each(|p| self.offset(p));
        self.current = end;
    }

    fn close(&mut self) {
        self.bytes.push(b'z');
        (self.current, self.implied, self.has_point) = (self.start, 0, false);
    }

    fn command(&mut self, letter: u8) {
        if self.implied != letter {
            self.bytes.push(letter);
            (self.implied, self.has_point) = (letter, false);
        }
    }

    /// A point relative to the current one.
    fn offset(&mut self, p: Point) {
        self.number(p.x - self.current.x);
        self.number(p.y - self.current.y);
    }

    /// A number with all its digits: a minus sign or a second point separates by itself, a digit needs a space unless a letter is
    /// before it.
    fn number(&mut self, value: f64) {
        let is_whole = value == value.trunc() && value.abs() < 1e15;
        let begins_with_point = !is_whole && value.abs() < 1.0;
        let after_number = self.bytes.last().is_some_and(u8::is_ascii_digit);
        if value < 0.0 {
            self.bytes.push(b'-');
        } else if after_number && !(begins_with_point && self.has_point) {
            self.bytes.push(b' ');
        }
        if is_whole {
            self.digits(value.abs() as u64);
        } else {
            let text = value.abs().to_string();
            self.text(text.strip_prefix('0').unwrap_or(&text));
        }
        self.has_point = !is_whole;
    }

    fn digits(&mut self, mut value: u64) {
        let mut buffer = [0u8; 20];
        let mut begin = buffer.len();
        loop {
            begin -= 1;
            buffer[begin] = b'0' + (value % 10) as u8;
            value /= 10;
            if value == 0 {
                break;
            }
        }
        self.bytes.extend_from_slice(&buffer[begin..]);
    }
}

/// The finest grid in a drawing has fewer parts to a unit than this.
const LEFT_GRID: f64 = (1u64 << 20) as f64;

/// Drawings made by hand, for the tests of this module and of [`super::raster`].
#[cfg(test)]
pub(crate) mod samples {
    use kurbo::{BezPath, Point, Shape};

    use crate::base::Ink;
    use crate::drawing::{Drawing, Mark, Provenance, Region, Ring, RingPart};
    use crate::options::Options;
    use crate::outlines::Stipple;

    /// A closed uniform quadratic B-spline.
    pub(crate) fn spline(controls: &[Point]) -> BezPath {
        let middle = |i: usize| controls[i % controls.len()].midpoint(controls[(i + 1) % controls.len()]);
        let mut path = BezPath::new();
        path.move_to(middle(controls.len() - 1));
        for (i, control) in controls.iter().enumerate() {
            path.quad_to(*control, middle(i));
        }
        path.close_path();
        path
    }

    /// A wobbly closed spline of `count` control points around a centre.
    pub(crate) fn blob(centre: [f64; 2], radius: f64, count: usize) -> BezPath {
        let controls: Vec<Point> = (0..count)
            .map(|i| {
                let angle = i as f64 / count as f64 * std::f64::consts::TAU;
                let r = radius * (1.0 + 0.2 * (3.0 * angle + centre[0]).sin());
                Point::new(centre[0] + r * angle.cos(), centre[1] + r * angle.sin())
            })
            .collect();
        spline(&controls)
    }

    /// A drawing of closed curves and dots, each with its level; what lies in what is not looked at.
    pub(crate) fn drawing(width: usize, height: usize, curves: Vec<(BezPath, u32)>, dots: &[(f64, f64, f64, u32)]) -> Drawing {
        let ink = |level: u32| if level.is_multiple_of(2) { Ink::White } else { Ink::Black };
        let mut areas: Vec<(f64, Mark)> = Vec::new();
        let mut regions = Vec::new();
        for (i, (curve, level)) in curves.iter().enumerate() {
            areas.push((curve.area(), Mark::Region(i as u32)));
            regions.push(Region {
                ink: ink(*level),
                level: *level,
                exterior: Ring { parts: vec![RingPart::Curve { index: i as u32, reversed: false }] },
                holes: Vec::new(),
                enclosed_area: curve.area(),
            });
        }
        let mut stipples = Vec::new();
        for (i, &(x, y, radius, level)) in dots.iter().enumerate() {
            areas.push((radius * radius * std::f64::consts::PI, Mark::Stipple(i as u32)));
            stipples.push(Stipple { x, y, radius, ink: ink(level), level });
        }
        areas.sort_by(|a, b| b.0.total_cmp(&a.0));
        Drawing {
            width,
            height,
            curves: curves.into_iter().map(|c| c.0).collect(),
            stipples,
            regions,
            order: areas.into_iter().map(|a| a.1).collect(),
            units: 16.0,
            provenance: Provenance {
                version: "0.1.0".into(),
                importance: "saliency".into(),
                options: Options::default().to_json(),
                ..Provenance::default()
            },
        }
    }

    /// Black that touches the frame on the left half of 64 x 48, a white blob in it, a black dot in that, a dot on the frame.
    pub(crate) fn nested() -> Drawing {
        let mut left = BezPath::new();
        left.move_to((32.0, 0.0));
        left.quad_to((40.0, 12.0), (32.0, 24.0));
        left.quad_to((24.0, 36.0), (32.0, 48.0));
        let mut sample = drawing(
            64,
            48,
            vec![(left, 1), (blob([16.0, 24.0], 10.0, 9), 2), (blob([50.3, 12.6], 5.0, 7), 1)],
            &[(15.7, 23.9, 2.35, 3), (64.0, 30.0, 3.0, 1), (48.0, 40.0, 0.5, 1), (53.21, 40.4, 1.3, 1)],
        );
        let corners = [RingPart::Corner(0.0, 48.0), RingPart::Corner(0.0, 0.0)];
        sample.regions[0].exterior.parts.extend(corners);
        sample.order = vec![
            Mark::Region(0),
            Mark::Region(1),
            Mark::Region(2),
            Mark::Stipple(0),
            Mark::Stipple(1),
            Mark::Stipple(2),
            Mark::Stipple(3),
        ];
        sample
    }

    /// Rows of blobs and dots, 16 px apart: `count` of each.
    pub(crate) fn field_of_blobs(count: usize) -> Drawing {
        let columns = (count as f64).sqrt().ceil() as usize;
        let at = |i: usize| [(i % columns) as f64 * 16.0 + 6.5, (i / columns) as f64 * 16.0 + 6.5];
        let curves = (0..count).map(|i| (blob(at(i), 3.0 + (i % 7) as f64 * 0.4, 8 + i % 5), 1)).collect();
        let dots: Vec<_> = (0..count).map(|i| (at(i)[0] + 7.9, at(i)[1] + 7.7, 0.6 + (i % 11) as f64 * 0.11, 1)).collect();
        drawing(columns * 16, columns * 16, curves, &dots)
    }
}

#[cfg(test)]
mod tests {
    use kurbo::{Affine, Shape};

    use super::*;
    use crate::files::layers::Style;
    use crate::options::Inks;

    const UNITS: f64 = 16.0;

    fn writer() -> PathWriter {
        PathWriter { units: UNITS, ..PathWriter::default() }
    }

    /// The data of a path of one ring.
    fn data_of(curve: &BezPath) -> String {
        let mut writer = writer();
        writer.ring(curve);
        String::from_utf8(writer.bytes).unwrap()
    }

    fn flat(inks: Inks) -> Export {
        Export { inks, ..Export::default() }
    }

    fn layered() -> Export {
        Export { style: Style::Layered, ..Export::default() }
    }

    /// Ids of the layers, and their paths in pixels.
    fn paths_of(svg: &str) -> Vec<(String, BezPath)> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let of = |n: roxmltree::Node| {
            let group = n.parent().unwrap();
            assert_eq!(group.attribute((INKSCAPE, "groupmode")), Some("layer"));
            assert_eq!(group.attribute("transform"), Some("scale(.0625)"));
            let path = BezPath::from_svg(n.attribute("d").unwrap()).unwrap();
            (group.attribute("id").unwrap().to_owned(), Affine::scale(1.0 / UNITS) * path)
        };
        document.descendants().filter(|n| n.has_tag_name("path")).map(of).collect()
    }

    #[test]
    fn a_polygon_is_written_without_a_byte_to_spare() {
        let mut path = BezPath::new();
        path.move_to((1.0, 2.0));
        path.line_to((3.0, 1.0));
        path.line_to((3.5, 2.5));
        path.line_to((1.0, 2.5));
        path.line_to((1.0, 2.0));
        path.close_path();
        assert_eq!(data_of(&path), "m16 32 32-16 8 24h-40z");
    }

    #[test]
    fn a_finer_grid_has_all_its_decimals() {
        let mut path = BezPath::new();
        path.move_to((1.0, 1.0));
        path.quad_to((1.0 + 1.0 / 64.0, 1.0 + 3.0 / 128.0), (1.0 - 1.0 / 32.0, 1.5));
        path.close_path();
        assert_eq!(data_of(&path), "m16 16q.25.375-.5 8z");
    }

    #[test]
    fn smooth_curves_leave_out_what_is_mirrored() {
        let mut path = BezPath::new();
        path.move_to((0.0, 0.0));
        path.quad_to((1.0, 0.0), (2.0, 1.0));
        path.quad_to((3.0, 2.0), (1.0, 4.0));
        path.curve_to((0.5, 4.0), (0.0, 3.0), (0.0, 2.0));
        path.curve_to((0.0, 1.0), (0.5, 0.5), (0.0, 0.0));
        path.close_path();
        assert_eq!(data_of(&path), "m0 0q16 0 32 16t-16 48c-8 0-16-16-16-32s8-24 0-32z");
    }

    #[test]
    fn what_is_written_is_what_is_drawn() {
        for count in [3, 8, 4000] {
            let mut curve = samples::blob([300.0, 200.0], 100.0, count);
            // On the grid.
            let snap = |p: Point| Point::new((p.x * UNITS).round() / UNITS, (p.y * UNITS).round() / UNITS);
            curve = curve
                .iter()
                .map(|element| match element {
                    PathEl::MoveTo(p) => PathEl::MoveTo(snap(p)),
                    PathEl::QuadTo(c, p) => PathEl::QuadTo(snap(c), snap(p)),
                    other => other,
                })
                .collect();
            let written = Affine::scale(1.0 / UNITS) * BezPath::from_svg(&data_of(&curve)).unwrap();
            assert_eq!(written, curve);
        }
    }

    #[test]
    fn circles_keep_their_place_and_size() {
        for (x, y, radius) in [(10.0, 20.0, 0.5), (3.3, 4.4, 0.3), (7.77, 1.23, 0.7), (100.1, 50.2, 3.21)] {
            let dot = crate::outlines::Stipple::on_grid(Point::new(x, y), radius, UNITS, Ink::Black);
            let mut writer = writer();
            writer.circle(Point::new(dot.x, dot.y), dot.radius, true);
            let data = String::from_utf8(writer.bytes).unwrap();
            let circle = Affine::scale(1.0 / UNITS) * BezPath::from_svg(&data).unwrap();
            assert!((circle.area() / (std::f64::consts::PI * radius * radius) - 1.0).abs() < 0.011, "{data}");
            let centre = circle.bounding_box().center();
            assert!((centre - Point::new(x, y)).hypot() < 0.75 / UNITS, "{data}: {centre}");
        }
    }

    #[test]
    fn the_document_holds_layers_paper_and_provenance() {
        let sample = samples::nested();
        let svg = to_svg(&sample, &layered()).unwrap();
        assert_eq!(svg, to_svg(&sample, &layered()).unwrap());
        let document = roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!((root.attribute("viewBox"), root.attribute("width")), (Some("0 0 64 48"), Some("64")));
        let about = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap();
        let json = about.text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);
        assert_eq!((about.attribute("width"), about.attribute("height")), (Some("64"), Some("48")));

        let paths = paths_of(&svg);
        let ids: Vec<_> = paths.iter().map(|p| p.0.as_str()).collect();
        assert_eq!(ids, ["level-1-black-regions", "level-1-black-stipples", "level-2-white-regions", "level-3-black-stipples"]);
        let white = sample.ring_path(&sample.regions[1].exterior).area();
        assert!((paths[2].1.area() / white - 1.0).abs() < 1e-9, "{} instead of {white}", paths[2].1.area());
        assert!(svg.contains("<g id=\"paper\""));
        assert!(!to_svg(&sample, &flat(Inks::Black)).unwrap().contains("paper"));
    }

    #[test]
    fn sizes_are_in_the_unit_asked_for_and_the_data_are_not_scaled() {
        let sample = samples::nested();
        let plain = to_svg(&sample, &layered()).unwrap();
        let mut export = layered();
        export.layout.width = Some("128mm".parse().unwrap());
        export.layout.margin = "10mm".parse().unwrap();
        let sized = to_svg(&sample, &export).unwrap();
        assert!(sized.contains("width=\"148mm\" height=\"116mm\" viewBox=\"-5 -5 74 58\""), "{}", &sized[..400]);
        assert_eq!(paths_of(&plain), paths_of(&sized));
    }

    #[test]
    fn text_is_escaped() {
        let mut sample = samples::nested();
        sample.provenance.importance = "a<b>&\"c\"".into();
        let svg = to_svg(&sample, &layered()).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let json = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap().text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);
    }

    #[test]
    fn long_layers_are_split_between_areas() {
        let sample = samples::field_of_blobs(20_000);
        let svg = to_svg(&sample, &layered()).unwrap();
        let paths = paths_of(&svg);
        assert!(paths.len() > 2 && paths.len() < 30, "{}", paths.len());
        let moves: usize = paths.iter().map(|p| p.1.elements().iter().filter(|e| matches!(e, PathEl::MoveTo(_))).count()).sum();
        assert_eq!(moves, 40_000);
        let regions: f64 = sample.regions.iter().map(|r| r.enclosed_area).sum();
        let dots: f64 = sample.stipples.iter().map(|s| s.radius * s.radius * std::f64::consts::PI).sum();
        let written: f64 = paths.iter().map(|p| p.1.area()).sum();
        // These blobs lie on no grid and are written with all their digits; kurbo makes the arcs of dots of cubics.
        assert!((written / (regions + dots) - 1.0).abs() < 2e-3, "{written} instead of {regions} + {dots}");
    }
}
