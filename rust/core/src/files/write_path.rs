//! Path data of SVG. In: closed outlines in pixels of the canvas; out: text with relative commands, as short as the grammar allows.
//!
//! Coordinates are whole numbers in units of the drawing's grid, relative to the point before, so that nothing is lost and nothing
//! accumulates: [`super::read_path`] reads the same outlines back. A point on a finer grid has decimals. A control point that is the
//! last one mirrored is what the commands `t` and `s` stand for. Dots are true circles of two arcs, or short strokes.

use kurbo::{BezPath, PathEl, Point, Vec2};

use crate::base::is_mirrored;
use crate::files::layers::Outline;

/// Appends path data with relative commands and as few separators and letters as the grammar asks for. All points are in units.
#[derive(Debug, Default)]
pub(super) struct PathWriter {
    /// What is written so far: path data, and the elements around them.
    pub(super) bytes: Vec<u8>,
    /// Units to a pixel.
    pub(super) units: f64,
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
    pub(super) fn new(units: f64) -> Self {
        Self { units, ..Self::default() }
    }

    pub(super) fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// Begins the data of another path; returns where.
    pub(super) fn begin(&mut self) -> usize {
        (self.current, self.start) = (Point::ZERO, Point::ZERO);
        (self.implied, self.has_point) = (0, false);
        self.bytes.len()
    }

    pub(super) fn outline(&mut self, outline: &Outline, is_exterior: bool) {
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
        self.move_to(Point::new(leftmost(centre.x * self.units, radius), centre.y * self.units));
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

    /// Strokes of [`STROKE`] units, each in the middle of a dot, whose centres are given in units. They run to the right and to the
    /// left in turn: then moves between dots of one radius are whole numbers, as most of these have the same decimals.
    pub(super) fn strokes(&mut self, centres: &[Point]) {
        let mut along = STROKE;
        for centre in centres {
            let begin = Point::new(rounded(centre.x - 0.5 * along), centre.y);
            self.implied = 0;
            self.command(b'm');
            self.number(rounded(begin.x - self.current.x));
            self.number(rounded(begin.y - self.current.y));
            self.command(b'h');
            self.number(along);
            self.current = Point::new(rounded(begin.x + along), begin.y);
            along = -along;
        }
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

/// Length of the stroke that stands for a dot, in units of its path: programs leave out what has none. Its round ends make its picture
/// wider than the dot by as much, a few tenths of a per mille of the ink.
pub(super) const STROKE: f64 = 0.04;

/// The leftmost point of a circle, in units: it lies on the grid, and the subtraction may have rounded.
pub(super) fn leftmost(x: f64, radius: f64) -> f64 {
    on_dot_grid(x - radius)
}

/// The finest grid on which dots lie has fewer parts to a unit than this.
const DOT_GRID: f64 = (1u64 << 20) as f64;

/// The nearest coordinate on that grid, in units.
pub(super) fn on_dot_grid(v: f64) -> f64 {
    (v * DOT_GRID).round() / DOT_GRID
}

/// A coordinate whose last digits rounding has left: eight decimals tell points of the finest grid apart.
pub(super) fn rounded(value: f64) -> f64 {
    // Not -0.
    (value * 1e8).round() / 1e8 + 0.0
}

#[cfg(test)]
mod tests {
    use kurbo::{Affine, Shape};

    use super::*;
    use crate::base::Ink;
    use crate::files::svg::samples;

    const UNITS: f64 = 16.0;

    fn writer() -> PathWriter {
        PathWriter::new(UNITS)
    }

    /// The data of a path of one ring.
    fn data_of(curve: &BezPath) -> String {
        let mut writer = writer();
        writer.ring(curve);
        String::from_utf8(writer.bytes).unwrap()
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
            let dot = crate::outlines::Stipple::on_grid(Point::new(x, y), radius, UNITS, Ink::BLACK);
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
    fn strokes_turn_back_and_forth_around_their_centres() {
        let mut writer = writer();
        writer.strokes(&[Point::new(12.34, 5.0), Point::new(20.34, 7.0), Point::new(3.34, 8.5)]);
        assert_eq!(String::from_utf8(writer.bytes).unwrap(), "m12.32 5h.04m8 2h-.04m-17 1.5h.04");
    }
}
