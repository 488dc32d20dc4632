//! The drawing as SVG, in the layered way: on white paper, level by level, each level one compound path of its ink.
//!
//! # What is written
//! Coordinates are whole numbers in units of 1/16 px under one group transform, relative to the point before. The absolute position
//! is tracked as it was rounded, so rounding never accumulates. Boundary curves are uniform quadratic B-splines: each control
//! point is the last one mirrored in the point between, which is what the command `t` stands for, so only the points between are
//! written. They are steered to put every mirrored control point within a unit of its place. A curve that is no such spline is
//! written with its control points.
//!
//! Dots are true circles of two arcs. The provenance is JSON in `<metadata>`: enough to make the drawing again.
//! What this module does not do: holes (see the module docs of [`crate::drawing`] on the layered way).

use kurbo::{BezPath, PathEl, Point};

use crate::drawing::{Drawing, FLATTENING_TOLERANCE, Ink, Mark, Stipple};

/// Units per pixel. A control point may lie a unit off its place, the end of a line half a unit: at 16 neither can be seen at ten
/// times the size. Half as many units save 8 % of the file, and the area of a loop of 17 px^2 comes out 1.4 % off instead of 0.8.
const UNITS_PER_PIXEL: f64 = 16.0;

/// The transform that takes units to pixels: 1 / [`UNITS_PER_PIXEL`].
const TRANSFORM: &str = "scale(.0625)";

/// A path is closed and another one begun after this many bytes: libxml2, and with it librsvg and lxml, refuses attributes above
/// 10 MB, and viewers skip a path that is out of view. Marks of one level are disjoint, so the picture is the same.
const PATH_BYTES: usize = 1 << 20;

/// Names the element with the provenance; only a name, nothing is there.
const NAMESPACE: &str = "https://github.com/graphstipple/graphstipple";

/// The drawing as an SVG document of the canvas's size in pixels.
///
/// # Runtime
/// Linear in the number of coordinates. The same drawing always gives the same bytes.
pub fn to_svg(drawing: &Drawing) -> String {
    let (width, height) = (drawing.width, drawing.height);
    let elements: usize = drawing.curves.iter().map(|curve| curve.elements().len()).sum();
    let mut writer =
        PathWriter { bytes: Vec::with_capacity(2048 + 8 * elements + 56 * drawing.stipples.len()), ..Default::default() };
    let json = serde_json::to_string(&drawing.provenance).expect("plain options always serialize");
    writer.text(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <metadata><graphstipple:drawing xmlns:graphstipple=\"{NAMESPACE}\">{}</graphstipple:drawing></metadata>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <g transform=\"{TRANSFORM}\">\n",
        escape(&json)
    ));
    for level in drawing.levels() {
        let mut begin = writer.open(level.ink);
        for mark in level.marks {
            if writer.bytes.len() - begin > PATH_BYTES {
                writer.text("\"/>\n");
                begin = writer.open(level.ink);
            }
            match mark {
                Mark::Stipple(i) => writer.dot(&drawing.stipples[i as usize]),
                Mark::Region(i) => {
                    writer.ring(&drawing.ring_path(&drawing.regions[i as usize].exterior, FLATTENING_TOLERANCE));
                }
            }
        }
        writer.text("\"/>\n");
    }
    writer.text("</g>\n</svg>\n");
    String::from_utf8(writer.bytes).expect("only text was written")
}

/// Escapes what may not stand in XML character data.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A point in whole units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Grid {
    x: i64,
    y: i64,
}

impl Grid {
    fn nearest(p: Point) -> Self {
        Self { x: p.x.round() as i64, y: p.y.round() as i64 }
    }

    /// The other end of the segment from `self` whose middle is `middle`.
    fn mirrored_in(self, middle: Self) -> Self {
        Self { x: 2 * middle.x - self.x, y: 2 * middle.y - self.y }
    }

    /// Whether neither axis is more than a unit off; the rest is for the rounding of `p` itself.
    fn is_close_to(self, p: Point) -> bool {
        const UNIT: f64 = 1.0 + 1e-6;
        (self.x as f64 - p.x).abs() <= UNIT && (self.y as f64 - p.y).abs() <= UNIT
    }
}

/// Appends path data with relative commands and as few separators and letters as the grammar asks for.
#[derive(Debug, Default)]
struct PathWriter {
    bytes: Vec<u8>,
    /// The current point.
    current: Grid,
    /// Where the current subpath began: the current point again after its `z`.
    start: Grid,
    /// The control point of the quadratic curve that ended here, if one did.
    control: Option<Grid>,
    /// The command that numbers without a letter would continue; 0 for none.
    implied: u8,
}

impl PathWriter {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// Begins a path element; returns where its data begins.
    fn open(&mut self, ink: Ink) -> usize {
        self.text(match ink {
            Ink::Black => "<path d=\"",
            Ink::White => "<path fill=\"#fff\" d=\"",
        });
        (self.current, self.start, self.control, self.implied) = (Grid::default(), Grid::default(), None, 0);
        self.bytes.len()
    }

    /// A closed path, given in pixels.
    fn ring(&mut self, path: &BezPath) {
        let elements = path.elements();
        let units = |p: Point| Point::new(p.x * UNITS_PER_PIXEL, p.y * UNITS_PER_PIXEL);
        for (i, element) in elements.iter().enumerate() {
            match *element {
                PathEl::MoveTo(p) => self.move_to(Grid::nearest(units(p))),
                PathEl::LineTo(p) => {
                    let p = Grid::nearest(units(p));
                    // `z` draws the line back to the start.
                    if !(p == self.start && matches!(elements.get(i + 1), None | Some(PathEl::ClosePath))) {
                        self.line_to(p);
                    }
                }
                PathEl::QuadTo(c, p) => {
                    let next_control = match elements.get(i + 1) {
                        Some(PathEl::QuadTo(next, _)) => Some(units(*next)),
                        _ => None,
                    };
                    self.quad_to(units(c), units(p), next_control);
                }
                PathEl::CurveTo(c, d, p) => {
                    self.curve_to(Grid::nearest(units(c)), Grid::nearest(units(d)), Grid::nearest(units(p)));
                }
                PathEl::ClosePath => self.close(),
            }
        }
    }

    /// A circle of two arcs in the regions' direction that begins at its leftmost point. That point is whole; the radius has three digits or more, so that
    /// the area is right within 1 %.
    fn dot(&mut self, stipple: &Stipple) {
        let radius = stipple.radius * UNITS_PER_PIXEL;
        let hundredths = if radius < 10.0 { ((radius * 100.0).round() as i64).max(1) } else { (radius * 10.0).round() as i64 * 10 };
        let left = stipple.x * UNITS_PER_PIXEL - hundredths as f64 / 100.0;
        self.move_to(Grid::nearest(Point::new(left, stipple.y * UNITS_PER_PIXEL)));
        self.command(b'a');
        for diameter in [2 * hundredths, -2 * hundredths] {
            self.decimal(hundredths);
            self.decimal(hundredths);
            self.text(" 0 1 1");
            self.decimal(diameter);
            self.number(0);
        }
        self.close();
    }

    fn move_to(&mut self, p: Grid) {
        self.implied = 0;
        self.command(b'm');
        self.offset(p);
        // Numbers after a move continue with lines.
        self.implied = b'l';
        (self.current, self.start, self.control) = (p, p, None);
    }

    fn line_to(&mut self, p: Grid) {
        match (p.x - self.current.x, p.y - self.current.y) {
            (0, 0) => return,
            (dx, 0) => {
                self.command(b'h');
                self.number(dx);
            }
            (0, dy) => {
                self.command(b'v');
                self.number(dy);
            }
            _ => {
                self.command(b'l');
                self.offset(p);
            }
        }
        (self.current, self.control) = (p, None);
    }

    /// A quadratic curve, given in units. The control point of the next curve decides where this one ends exactly.
    fn quad_to(&mut self, control: Point, end: Point, next_control: Option<Point>) {
        let mirrored = self.control.map(|last| last.mirrored_in(self.current)).filter(|c| c.is_close_to(control));
        let written = mirrored.unwrap_or_else(|| Grid::nearest(control));
        // Between two control points of a uniform spline the curve passes half-way; aim from where the first one really is.
        let steered = next_control
            .map(|next| Grid::nearest(Point::new((written.x as f64 + next.x) / 2.0, (written.y as f64 + next.y) / 2.0)))
            .filter(|p| p.is_close_to(end))
            .unwrap_or_else(|| Grid::nearest(end));
        if mirrored.is_some() {
            self.command(b't');
        } else {
            self.command(b'q');
            self.offset(written);
        }
        self.offset(steered);
        (self.current, self.control) = (steered, Some(written));
    }

    fn curve_to(&mut self, first: Grid, second: Grid, end: Grid) {
        self.command(b'c');
        for p in [first, second, end] {
            self.offset(p);
        }
        (self.current, self.control) = (end, None);
    }

    fn close(&mut self) {
        self.bytes.push(b'z');
        (self.current, self.control, self.implied) = (self.start, None, 0);
    }

    fn command(&mut self, letter: u8) {
        if self.implied != letter {
            self.bytes.push(letter);
            self.implied = letter;
        }
    }

    /// A point relative to the current one.
    fn offset(&mut self, p: Grid) {
        self.number(p.x - self.current.x);
        self.number(p.y - self.current.y);
    }

    fn number(&mut self, value: i64) {
        self.sign_or_space(value < 0);
        self.digits(value.unsigned_abs());
    }

    /// A number given in hundredths, without trailing zeros.
    fn decimal(&mut self, hundredths: i64) {
        self.sign_or_space(hundredths < 0);
        let (whole, rest) = (hundredths.unsigned_abs() / 100, (hundredths.unsigned_abs() % 100) as u8);
        if whole > 0 || rest == 0 {
            self.digits(whole);
        }
        if rest > 0 {
            self.bytes.extend_from_slice(&[b'.', b'0' + rest / 10]);
            if rest % 10 > 0 {
                self.bytes.push(b'0' + rest % 10);
            }
        }
    }

    /// A minus sign separates by itself; a digit needs a space unless a letter is before it.
    fn sign_or_space(&mut self, negative: bool) {
        if negative {
            self.bytes.push(b'-');
        } else if self.bytes.last().is_some_and(u8::is_ascii_digit) {
            self.bytes.push(b' ');
        }
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

/// Drawings made by hand, for the tests of this module and of [`crate::raster`].
#[cfg(test)]
pub(crate) mod samples {
    use kurbo::{BezPath, Point, Shape};

    use crate::drawing::{Drawing, Ink, Mark, Provenance, Region, Ring, RingPart, Stipple};
    use crate::params::Options;

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
                component: i as u32,
                level: *level,
                exterior: Ring { parts: vec![RingPart::Curve { index: i as u32, reversed: false }] },
                holes: Vec::new(),
                enclosed_area: curve.area(),
            });
        }
        let mut stipples = Vec::new();
        for (i, &(x, y, radius, level)) in dots.iter().enumerate() {
            areas.push((radius * radius * std::f64::consts::PI, Mark::Stipple(i as u32)));
            stipples.push(Stipple { x, y, radius, ink: ink(level), component: (regions.len() + i) as u32, level });
        }
        areas.sort_by(|a, b| b.0.total_cmp(&a.0));
        Drawing {
            width,
            height,
            curves: curves.into_iter().map(|c| c.0).collect(),
            stipples,
            regions,
            order: areas.into_iter().map(|a| a.1).collect(),
            provenance: Provenance { version: "0.1.0".into(), importance: "saliency".into(), options: Options::default() },
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

    /// The data of the only path in a drawing of one closed curve.
    fn data_of(curve: BezPath) -> String {
        let mut writer = PathWriter::default();
        writer.ring(&curve);
        String::from_utf8(writer.bytes).unwrap()
    }

    fn paths_of(svg: &str) -> Vec<(Option<String>, BezPath)> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let group = document.descendants().find(|n| n.has_tag_name("g")).unwrap();
        assert_eq!(group.attribute("transform"), Some("scale(.0625)"));
        let of = |n: roxmltree::Node| {
            let path = BezPath::from_svg(n.attribute("d").unwrap()).unwrap();
            (n.attribute("fill").map(str::to_owned), Affine::scale(1.0 / UNITS_PER_PIXEL) * path)
        };
        group.children().filter(roxmltree::Node::is_element).map(of).collect()
    }

    #[test]
    fn a_polygon_is_written_without_a_byte_to_spare() {
        let mut path = BezPath::new();
        path.move_to((1.0, 2.0));
        path.line_to((3.0, 1.0));
        path.line_to((3.5, 2.5));
        path.line_to((3.5, 2.51));
        path.line_to((1.0, 2.5));
        path.line_to((1.0, 2.0));
        path.close_path();
        assert_eq!(data_of(path), "m16 32 32-16 8 24h-40z");
    }

    #[test]
    fn what_rounds_to_nothing_is_still_path_data() {
        let mut path = BezPath::new();
        path.move_to((1.0, 1.0));
        path.line_to((1.01, 1.0));
        path.close_path();
        assert_eq!(data_of(path), "m16 16z");
        let data = data_of(samples::blob([1.0, 1.0], 0.001, 5));
        assert!(BezPath::from_svg(&data).is_ok(), "{data}");
    }

    #[test]
    fn a_spline_takes_one_point_per_control_point_and_stays_in_place() {
        for count in [3, 8, 4000] {
            let curve = samples::blob([300.0, 200.0], 100.0, count);
            let data = data_of(curve.clone());
            assert_eq!((data.matches('q').count(), data.matches('t').count()), (1, 1), "{data}");
            let written = Affine::scale(1.0 / UNITS_PER_PIXEL) * BezPath::from_svg(&data).unwrap();
            assert_eq!(written.segments().count(), count);
            for (a, b) in written.segments().zip(curve.segments()) {
                let (kurbo::PathSeg::Quad(a), kurbo::PathSeg::Quad(b)) = (a, b) else { panic!("not quadratic") };
                for (p, q) in [(a.p0, b.p0), (a.p1, b.p1), (a.p2, b.p2)] {
                    assert!((p - q).hypot() <= 2f64.sqrt() / UNITS_PER_PIXEL + 1e-9, "{p} is far from {q}");
                }
            }
            assert!((written.area() / curve.area() - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn other_curves_keep_their_control_points() {
        let mut path = BezPath::new();
        path.move_to((0.0, 0.0));
        path.quad_to((1.0, 0.0), (2.0, 1.0));
        path.quad_to((2.0, 3.0), (1.0, 4.0));
        path.curve_to((0.5, 4.0), (0.0, 3.0), (0.0, 0.0));
        path.close_path();
        assert_eq!(data_of(path), "m0 0q16 0 32 16 0 32-16 48c-8 0-16-16-16-64z");
    }

    #[test]
    fn dots_keep_their_place_and_their_ink() {
        for (x, y, radius) in [(10.0, 20.0, 0.5), (3.3, 4.4, 0.3), (7.77, 1.23, 0.7), (100.1, 50.2, 3.21)] {
            let mut writer = PathWriter::default();
            writer.dot(&Stipple { x, y, radius, ink: Ink::Black, component: 0, level: 1 });
            let data = String::from_utf8(writer.bytes).unwrap();
            let circle = Affine::scale(1.0 / UNITS_PER_PIXEL) * BezPath::from_svg(&data).unwrap();
            let area = std::f64::consts::PI * radius * radius;
            assert!((circle.area() / area - 1.0).abs() < 0.011, "{data}");
            let centre = circle.bounding_box().center();
            assert!((centre - Point::new(x, y)).hypot() < 0.75 / UNITS_PER_PIXEL, "{data}: {centre}");
        }
    }

    #[test]
    fn the_document_holds_paper_levels_and_provenance() {
        let sample = samples::nested();
        let svg = to_svg(&sample);
        assert_eq!(svg, to_svg(&sample));
        let document = roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("viewBox"), Some("0 0 64 48"));
        let json = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap().text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);

        let paths = paths_of(&svg);
        let fills: Vec<_> = paths.iter().map(|p| p.0.as_deref()).collect();
        assert_eq!(fills, [None, Some("#fff"), None]);
        let white = sample.ring_path(&sample.regions[1].exterior, 0.05).area();
        assert!((paths[1].1.area() / white - 1.0).abs() < 0.005, "{} instead of {white}", paths[1].1.area());
    }

    #[test]
    fn text_is_escaped() {
        let mut sample = samples::nested();
        sample.provenance.importance = "a<b>&\"c\"".into();
        let svg = to_svg(&sample);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let json = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap().text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);
    }

    #[test]
    fn long_levels_are_split_between_marks() {
        let sample = samples::field_of_blobs(20_000);
        let svg = to_svg(&sample);
        let paths = paths_of(&svg);
        assert!(paths.len() > 1 && paths.len() < 6, "{}", paths.len());
        let moves: usize = paths.iter().map(|p| p.1.elements().iter().filter(|e| matches!(e, PathEl::MoveTo(_))).count()).sum();
        assert_eq!(moves, 40_000);
        let regions: f64 = sample.regions.iter().map(|r| r.enclosed_area).sum();
        let dots: f64 = sample.stipples.iter().map(|s| s.radius * s.radius * std::f64::consts::PI).sum();
        let written: f64 = paths.iter().map(|p| p.1.area()).sum();
        assert!((written / (regions + dots) - 1.0).abs() < 1e-3, "{written} instead of {regions} + {dots}");
    }
}
