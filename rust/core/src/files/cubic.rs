//! Outlines as PDF and PostScript take them: lines and cubic Bezier curves, in whole units of 1/64 px.
//!
//! Whole numbers under one transform are shorter than decimals and exact in the single-precision floats of both languages, up to
//! the largest canvas.

use std::borrow::Cow;

use kurbo::{BezPath, CubicBez, PathEl, Point, QuadBez};

use crate::files::layers::Outline;

/// Units per pixel of the canvas: a power of two, so that points on the drawing's own grid stay where they are. Others move by less
/// than 1/100 px, which keeps the size of the smallest dots too. Half as many units would save 9 % of a PDF.
pub(crate) const UNITS_PER_PIXEL: f64 = 64.0;

/// How far the control points of a quarter circle are from its ends, in radii: then its middle lies on the circle, and the rest
/// within 0.03 % of the radius.
const QUARTER: f64 = 0.552_284_749_830_793_4;

/// A piece of an outline, in units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Piece {
    Move([i32; 2]),
    Line([i32; 2]),
    /// Two control points and the end.
    Curve([[i32; 2]; 3]),
    Close,
}

/// A length or coordinate in units.
pub(crate) fn units(pixels: f64) -> i32 {
    // Casts of floats to integers keep to the integer's range.
    (pixels * UNITS_PER_PIXEL).round() as i32
}

/// The pieces of a path. Quadratic curves are raised exactly, lines that round to nothing are left out.
pub(crate) fn for_each_piece(path: &BezPath, mut emit: impl FnMut(Piece)) {
    let on_grid = |p: Point| [units(p.x), units(p.y)];
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

/// The path of an outline, a circle as four curves. A circle that is a `hole` runs backwards, against its exterior; paths already
/// run as they should.
pub(crate) fn path_of(outline: &Outline, hole: bool) -> Cow<'_, BezPath> {
    match *outline {
        Outline::Path(ref path) => Cow::Borrowed(path),
        Outline::Circle { x, y, radius } => {
            let turn = if hole { -1.0 } else { 1.0 };
            let at = |along: f64, across: f64| Point::new(x + radius * along, y + turn * radius * across);
            let mut path = BezPath::new();
            path.move_to(at(1.0, 0.0));
            path.curve_to(at(1.0, QUARTER), at(QUARTER, 1.0), at(0.0, 1.0));
            path.curve_to(at(-QUARTER, 1.0), at(-1.0, QUARTER), at(-1.0, 0.0));
            path.curve_to(at(-1.0, -QUARTER), at(-QUARTER, -1.0), at(0.0, -1.0));
            path.curve_to(at(QUARTER, -1.0), at(1.0, -QUARTER), at(1.0, 0.0));
            path.close_path();
            Cow::Owned(path)
        }
    }
}

#[cfg(test)]
mod tests {
    use kurbo::Shape;

    use super::*;

    #[test]
    fn circles_have_their_area_and_holes_run_backwards() {
        let circle = Outline::Circle { x: 3.0, y: 4.0, radius: 2.0 };
        let area = std::f64::consts::PI * 4.0;
        assert!((path_of(&circle, false).area() / area - 1.0).abs() < 1e-3);
        assert!((path_of(&circle, true).area() / area + 1.0).abs() < 1e-3);
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
        for_each_piece(&path, |piece| pieces.push(piece));
        let curve = Piece::Curve([[192, 64], [256, 128], [256, 256]]);
        assert_eq!(pieces, [Piece::Move([64, 64]), curve, Piece::Line([64, 264]), Piece::Close]);
    }
}
