//! Outlines as PDF and PostScript take them: lines and cubic Bezier curves in whole units, and dots whose sizes repeat.
//!
//! Whole numbers under one transform are shorter than decimals and exact in the single-precision floats of both languages, up to
//! the largest canvas. The grid is as fine as the drawing's own asks for: see [`units_per_pixel`].

use std::borrow::Cow;
use std::f64::consts::PI;

use kurbo::{BezPath, CubicBez, PathEl, Point, QuadBez};

use crate::drawing::Drawing;
use crate::files::layers::Outline;

/// Units per pixel of the canvas, at most: coordinates of the largest canvas stay exact.
const FINEST_GRID: f64 = 64.0;

/// Steps of radii between a power of two and the next. A dot grows by less than a hundredth, which is what is left between it and
/// others; and radii are few enough for dots of one radius to be many.
const RADII: f64 = 128.0;

/// How far the control points of a quarter circle are from its ends, in radii: then its middle lies on the circle, and the rest
/// within 0.03 % of the radius.
pub(crate) const QUARTER: f64 = 0.552_284_749_830_793_4;

/// The same of a half circle, with its area: it lies within 1.9 % of the radius.
const HALF: f64 = 5.0 * PI / 12.0;

/// The largest radius, in px, of a circle that is written as two curves: then it lies within 1/50 px.
const TWO_CURVES: f64 = 1.05;

/// A piece of an outline, in units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Piece {
    Move([i32; 2]),
    Line([i32; 2]),
    /// Two control points and the end.
    Curve([[i32; 2]; 3]),
    Close,
}

/// Units to a pixel: the drawing's own grid, on which most of its points lie already. The joints halfway between two of them move by
/// half a step; keeping them, on a grid twice as fine, would cost a fifth of a PDF.
pub(crate) fn units_per_pixel(drawing: &Drawing) -> f64 {
    drawing.units.clamp(1.0, FINEST_GRID)
}

/// A length or coordinate in units.
fn in_units(pixels: f64, units: f64) -> i32 {
    // Casts of floats to integers keep to the integer's range.
    (pixels * units).round() as i32
}

/// The pieces of a path. Quadratic curves are raised exactly, lines that round to nothing are left out.
pub(crate) fn for_each_piece(path: &BezPath, units: f64, mut emit: impl FnMut(Piece)) {
    let on_grid = |p: Point| [in_units(p.x, units), in_units(p.y, units)];
    let mut current = Point::ZERO;
    for element in path.elements() {
        match *element {
            PathEl::MoveTo(p) => emit(Piece::Move(on_grid(p))),
            PathEl::LineTo(p) => {
                if on_grid(p) != on_grid(current) {
                    emit(Piece::Line(on_grid(p)));
                }
            }
            PathEl::QuadTo(control, end) => {
                let CubicBez { p1, p2, p3, .. } = QuadBez::new(current, control, end).raise();
                emit(Piece::Curve([p1, p2, p3].map(on_grid)));
            }
            PathEl::CurveTo(p1, p2, p3) => emit(Piece::Curve([p1, p2, p3].map(on_grid))),
            PathEl::ClosePath => emit(Piece::Close),
        }
        current = element.end_point().unwrap_or(current);
    }
}

/// Sizes on a grid whose mean is that of what they stand for: what a dot is too large, the next ones are too small.
#[derive(Debug, Default)]
pub(crate) struct Sizes {
    /// The area that is still to be drawn, in px^2.
    owed: f64,
}

impl Sizes {
    /// The radius to draw for one in pixels.
    pub(crate) fn radius(&mut self, radius: f64) -> f64 {
        let mut step = 1.0 / RADII;
        while radius >= 2.0 * RADII * step {
            step *= 2.0;
        }
        while radius < RADII * step {
            step /= 2.0;
        }
        let area = |radius: f64| PI * radius * radius;
        let [smaller, larger] = [0.0, 1.0].map(|more| ((radius / step).floor() + more) * step);
        self.nearest(area(radius), [(smaller, area(smaller)), (larger, area(larger))])
    }

    /// Of two sizes with their areas, the one that leaves less owed.
    fn nearest<T>(&mut self, wanted: f64, [a, b]: [(T, f64); 2]) -> T {
        self.owed += wanted;
        let (size, area) = if (self.owed - a.1).abs() <= (self.owed - b.1).abs() { a } else { b };
        self.owed -= area;
        size
    }

    /// A circle as curves on the grid; as a hole it runs backwards, against its exterior.
    fn circle(&mut self, [x, y, radius]: [f64; 3], hole: bool, units: f64) -> BezPath {
        let turn = if hole { -1.0 } else { 1.0 };
        let mut path = BezPath::new();
        if radius > TWO_CURVES {
            let at = |along: f64, across: f64| Point::new(x + radius * along, y + turn * radius * across);
            path.move_to(at(-1.0, 0.0));
            path.curve_to(at(-1.0, -QUARTER), at(-QUARTER, -1.0), at(0.0, -1.0));
            path.curve_to(at(QUARTER, -1.0), at(1.0, -QUARTER), at(1.0, 0.0));
            path.curve_to(at(1.0, QUARTER), at(QUARTER, 1.0), at(0.0, 1.0));
            path.curve_to(at(-QUARTER, 1.0), at(-1.0, QUARTER), at(-1.0, 0.0));
        } else {
            let [left, right, y] = [x - radius, x + radius, y].map(|v| (v * units).round() / units);
            let reach = (HALF * radius * units).floor();
            for side in [-turn, turn] {
                // What two control points at this distance enclose with the diameter.
                let area = |reach: f64| 0.6 * (right - left) * reach / units;
                let sizes = [reach, reach + 1.0].map(|reach| (reach / units, area(reach)));
                let across = y + side * self.nearest(PI * radius * radius / 2.0, sizes);
                let [from, to] = if side == -turn { [left, right] } else { [right, left] };
                if side == -turn {
                    path.move_to((from, y));
                }
                path.curve_to((from, across), (to, across), (to, y));
            }
        }
        path.close_path();
        path
    }

    /// The path of an outline; paths already run as they should.
    pub(crate) fn path_of<'a>(&mut self, outline: &'a Outline, hole: bool, units: f64) -> Cow<'a, BezPath> {
        match *outline {
            Outline::Path(ref path) => Cow::Borrowed(path),
            Outline::Circle { x, y, radius } => Cow::Owned(self.circle([x, y, radius], hole, units)),
        }
    }
}

#[cfg(test)]
mod tests {
    use kurbo::{ParamCurve as _, Shape};

    use super::*;

    #[test]
    fn circles_have_their_area_and_holes_run_backwards() {
        for radius in [0.3, 0.65, 1.0, 2.0] {
            for (hole, turn) in [(false, 1.0), (true, -1.0)] {
                let circle = Outline::Circle { x: 3.0, y: 4.0, radius };
                let path = Sizes::default().path_of(&circle, hole, FINEST_GRID).into_owned();
                let area = turn * PI * radius * radius;
                assert!((path.area() / area - 1.0).abs() < 0.02, "{radius}: {} instead of {area}", path.area());
                for piece in path.segments() {
                    for t in [0.0, 0.25, 0.5, 0.75] {
                        let off = (piece.eval(t) - Point::new(3.0, 4.0)).hypot() - radius;
                        assert!(off.abs() < 0.02 + 1.0 / FINEST_GRID, "{radius}: {off}");
                    }
                }
            }
        }
    }

    #[test]
    fn many_dots_keep_their_ink() {
        let mut sizes = Sizes::default();
        let (mut wanted, mut radii, mut curves) = (0.0, 0.0, 0.0);
        for i in 0..1000 {
            let radius = 0.4 + 0.0007 * f64::from(i % 700);
            wanted += PI * radius * radius;
            let drawn = sizes.radius(radius);
            assert!((drawn / radius - 1.0).abs() <= 1.0 / RADII, "{drawn} for {radius}");
            radii += PI * drawn * drawn;
            let circle = Outline::Circle { x: f64::from(i) / 16.0, y: 4.0, radius };
            curves += sizes.path_of(&circle, false, 16.0).area();
        }
        assert!((radii / wanted - 1.0).abs() < 1e-3, "{radii} instead of {wanted}");
        assert!((curves / wanted - 1.0).abs() < 1e-3, "{curves} instead of {wanted}");
    }

    #[test]
    fn dots_of_one_radius_between_those_that_are_written_keep_their_ink() {
        for radius in [0.4013, 0.7021, 1.3007] {
            let mut sizes = Sizes::default();
            let drawn: f64 = (0..1000).map(|_| sizes.radius(radius)).map(|radius| radius * radius).sum();
            assert!((drawn / (1000.0 * radius * radius) - 1.0).abs() < 2e-5, "{radius}: {drawn}");
        }
    }

    #[test]
    fn quadratic_curves_are_raised_and_empty_lines_left_out() {
        let mut path = BezPath::new();
        path.move_to((1.0, 1.0));
        path.quad_to((4.0, 1.0), (4.0, 4.0));
        path.line_to((4.001, 4.0));
        path.line_to((1.0, 4.126));
        path.close_path();
        let mut pieces = Vec::new();
        for_each_piece(&path, 64.0, |piece| pieces.push(piece));
        let curve = Piece::Curve([[192, 64], [256, 128], [256, 256]]);
        assert_eq!(pieces, [Piece::Move([64, 64]), curve, Piece::Line([64, 264]), Piece::Close]);
    }
}
