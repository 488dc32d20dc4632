//! Curves and dots of which it is not known yet what lies beside them, as files hold them; and whether they can be a drawing's.
//!
//! # What a drawing is
//! Curves are closed, or go from frame to frame; on-curve points lie on the canvas, and control points no further outside than the
//! canvas is wide and high. Flattened, all but the ends of open curves lies inside the frame, and nothing touches or crosses anything,
//! itself included. Dots touch nothing. Time is n log n and memory linear in the number of points.

use kurbo::{BezPath, CubicBez, PathEl, Point, QuadBez};
use rayon::prelude::*;

use crate::base::{
    Control, Error, Frame, Ink, Palette, Result, bend_of_cubic, bend_of_quad, circle_polygon, flatten_path, flattening_steps,
    flattening_tolerance, in_one_line, is_closed,
};
use crate::drawing::assembly::ends_of;
use crate::drawing::known::Known;
use crate::drawing::sweep::{Line, Meeting, Swept, Top, sweep};
use crate::outlines::Stipple;

/// The finest grid of a drawing, units to a pixel. Drawings have a few to some hundreds.
const MOST_UNITS: f64 = (1 << 20) as f64;

/// The most points that curves may be flattened to: so many, and so many more for each of their pieces. Drawings come to a few a
/// piece.
const MOST_POINTS: f64 = (1 << 22) as f64;
const MOST_POINTS_A_PIECE: f64 = 16.0;

/// What is said of curves and dots that are no drawing: only a file can hold such.
pub(crate) fn invalid(what: impl std::fmt::Display) -> Error {
    Error::Input(format!("this is not a drawing that graphstipple wrote: {}", in_one_line(&what.to_string())))
}

/// Curves and dots, on a canvas.
pub(crate) struct Loose {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) units: f64,
    pub(crate) palette: Palette,
    /// The lower ink on their left, where it is known what is on both sides.
    pub(crate) curves: Vec<BezPath>,
    /// What is known to be on the left and on the right of every curve; where there is nothing, black and white.
    pub(crate) sides: Vec<[Known; 2]>,
    pub(crate) stipples: Vec<Stipple>,
    /// What is known of the inks of dots, where it is not all: the rest of an ink is that around the dot.
    pub(crate) dots: Vec<Known>,
    /// Ink of the canvas if there is nothing on it.
    pub(crate) ground: Ink,
}

/// A curve or a dot, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Curve(usize),
    Stipple(usize),
}

/// What shapes are called where they stand.
pub(crate) type Names<'a> = &'a (dyn Fn(Shape) -> String + Sync);

impl Loose {
    /// Curves and dots of black and white, on white, with 16 units to a pixel.
    #[cfg(test)]
    pub(crate) fn plain(width: usize, height: usize, curves: Vec<BezPath>, stipples: Vec<Stipple>) -> Self {
        let (palette, sides, dots) = (Palette::default(), Vec::new(), Vec::new());
        Self { width, height, units: 16.0, palette, curves, sides, stipples, dots, ground: Ink::WHITE }
    }

    /// What is known to be on the left and on the right of a curve.
    pub(super) fn inks(&self, curve: usize) -> [Known; 2] {
        self.sides.get(curve).copied().unwrap_or([Ink::BLACK, Ink::WHITE].map(Known::of))
    }

    pub(super) fn frame(&self) -> Frame {
        Frame { width: self.width as f64, height: self.height as f64 }
    }

    /// The shape of a line of the sweep: curves come first.
    pub(super) fn shape(&self, line: u32) -> Shape {
        let line = line as usize;
        if line < self.curves.len() { Shape::Curve(line) } else { Shape::Stipple(line - self.curves.len()) }
    }

    /// The uppermost points of all curves and dots, from the first to the last, with what lies beside them; if they are such as a
    /// drawing has.
    ///
    /// # Errors
    /// [`Error::Input`] that says of which shape this is not so, [`Error::Cancelled`].
    pub(super) fn check(&self, names: Names, control: &Control) -> Result<Vec<Top>> {
        if !(self.units >= 1.0 && self.units <= MOST_UNITS && self.units.log2().fract() == 0.0) {
            let told =
                format!("its grid has {} units to a pixel, but there must be a power of two from 1 to {MOST_UNITS}", self.units);
            return Err(invalid(told));
        }
        let refused = |(shape, what): (Shape, &'static str)| invalid(format!("{} {what}", names(shape)));
        let frame = self.frame();
        let has_junctions = self.palette.len() > 2;
        for (number, curve) in self.curves.iter().enumerate() {
            check_curve(curve, frame, has_junctions).map_err(|what| refused((Shape::Curve(number), what)))?;
        }
        for (number, dot) in self.stipples.iter().enumerate() {
            check_dot(dot, frame).map_err(|what| refused((Shape::Stipple(number), what)))?;
        }
        control.check()?;
        match sweep(&self.lines().map_err(refused)?, control)? {
            Swept::Apart(tops) => Ok(tops),
            Swept::Meeting(Meeting { lines: [a, b], at: [x, y] }) => {
                let name = |line| names(self.shape(line));
                let what = if a == b { "itself".to_owned() } else { name(b) };
                Err(invalid(format!("{} touches or crosses {what} near ({x:.1}, {y:.1})", name(a))))
            }
        }
    }

    /// Near where a curve or a dot touches another one, or itself; `None` if none does.
    ///
    /// # Errors
    /// [`Error::Input`] for a shape that is no line on the canvas, [`Error::Cancelled`].
    pub(crate) fn meeting(&self, control: &Control) -> Result<Option<[f64; 2]>> {
        let lines = self.lines().map_err(|(shape, what)| invalid(format!("{shape:?} {what}")))?;
        match sweep(&lines, control)? {
            Swept::Apart(_) => Ok(None),
            Swept::Meeting(Meeting { at, .. }) => Ok(Some(at)),
        }
    }

    /// All curves and dots as lines, or the first that is none.
    fn lines(&self) -> std::result::Result<Vec<Line>, (Shape, &'static str)> {
        let tolerance = flattening_tolerance(self.units);
        let mut left = MOST_POINTS;
        for (number, curve) in self.curves.iter().enumerate() {
            left += MOST_POINTS_A_PIECE * curve.elements().len() as f64 - flattened_count(curve, tolerance);
            if left < 0.0 {
                return Err((Shape::Curve(number), "bends further than curves of a drawing do"));
            }
        }
        let frame = self.frame();
        let line = |(number, curve): (usize, &BezPath)| {
            let points = flatten_path(curve, tolerance);
            let closed = is_closed(curve);
            let inner = if closed { &points[..] } else { &points[1..points.len() - 1] };
            let refused = |what| (Shape::Curve(number), what);
            // An open curve of one edge may lie on the edge of the canvas with nothing in between.
            let lies_on_frame = !closed && inner.is_empty() && {
                let [[a, b], [c, d]] = [points[0], points[1]];
                !frame.holds(Point::new(0.5 * (a + c), 0.5 * (b + d)))
            };
            if lies_on_frame || !inner.iter().all(|[x, y]| frame.holds(Point::new(*x, *y))) {
                return Err(refused("touches or crosses the edge of the canvas"));
            }
            // What does not end on the frame ends in a junction.
            let joins = ends_of(curve).map(|end| !closed && frame.holds(end));
            let line = Line::new(points.into_iter(), closed).ok_or_else(|| refused("encloses nothing"))?;
            Ok(line.joining(joins))
        };
        let of_curves = self.curves.par_iter().enumerate().map(line);
        let of_dots = self.stipples.par_iter().enumerate().map(|(number, dot)| {
            let points = circle_polygon([dot.x, dot.y], dot.radius, tolerance);
            let refused = |what| (Shape::Stipple(number), what);
            if !points.iter().all(|[x, y]| frame.holds(Point::new(*x, *y))) {
                return Err(refused("does not lie on the canvas"));
            }
            let points = around(dot, &points);
            // Of a dot that is lost in the last digits of its place, nothing is left to divide by.
            let is_there = points.iter().flatten().all(|v| v.is_finite());
            Line::new(points.into_iter(), true).filter(|_| is_there).ok_or_else(|| refused("is too small"))
        });
        of_curves.chain(of_dots).collect()
    }
}

impl Loose {
    /// The point of a curve next to its begin, or its end: where the sweep sees it go.
    pub(super) fn next_to(&self, curve: u32, begins: bool) -> [f64; 2] {
        let elements = self.curves[curve as usize].elements();
        let piece = if begins { &elements[..2] } else { &elements[elements.len() - 2..] };
        let from = piece[0].end_point().unwrap_or_default();
        let points = flatten_path(&BezPath::from_vec(vec![PathEl::MoveTo(from), piece[1]]), flattening_tolerance(self.units));
        points[if begins { 1 } else { points.len() - 2 }]
    }
}

/// A polygon around the circle of a dot and around its own polygon, which regions have for a hole. Between two corners of that one, where
/// the circle reaches beyond the side, there is another: as far out as the tangents from both corners meet.
fn around(dot: &Stipple, polygon: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let out = |[x, y]: [f64; 2]| [x - dot.x, y - dot.y];
    let length = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();
    let half = std::f64::consts::PI / polygon.len() as f64;
    let to_tangent = libm::acos((dot.radius / length(out(polygon[0]))).min(1.0));
    let reach = dot.radius / libm::cos((half - to_tangent).max(0.0));
    let with_next = |(k, corner): (usize, &[f64; 2])| {
        let next = polygon[(k + 1) % polygon.len()];
        let [x, y] = out([0.5 * (corner[0] + next[0]), 0.5 * (corner[1] + next[1])]);
        let scale = reach / length([x, y]);
        [*corner, [dot.x + scale * x, dot.y + scale * y]]
    };
    polygon.iter().enumerate().flat_map(with_next).collect()
}

/// How many points a curve is flattened to, at most.
fn flattened_count(curve: &BezPath, tolerance: f64) -> f64 {
    let mut at = Point::ZERO;
    let mut count = 0.0;
    for element in curve.elements() {
        count += match *element {
            PathEl::QuadTo(c, p) => flattening_steps(bend_of_quad(&QuadBez::new(at, c, p)), tolerance),
            PathEl::CurveTo(c, d, p) => flattening_steps(bend_of_cubic(&CubicBez::new(at, c, d, p)), tolerance),
            _ => 1.0,
        };
        at = element.end_point().unwrap_or(at);
    }
    count
}

fn check_curve(curve: &BezPath, frame: Frame, has_junctions: bool) -> std::result::Result<(), &'static str> {
    let elements = curve.elements();
    let is_one = matches!(elements, [PathEl::MoveTo(_), rest @ ..] if !rest.is_empty()
        && rest.iter().all(|element| !matches!(element, PathEl::MoveTo(_)))
        && rest[..rest.len() - 1].iter().all(|element| *element != PathEl::ClosePath));
    if !is_one {
        return Err("is not one curve");
    }
    if !elements.iter().all(PathEl::is_finite) {
        return Err("has coordinates that are no numbers");
    }
    let within = |p: Point, margin: f64| {
        let [x, y] = [frame.width, frame.height].map(|side| -margin * side..=(1.0 + margin) * side);
        x.contains(&p.x) && y.contains(&p.y)
    };
    let stays = |element: &PathEl| match *element {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => within(p, 0.0),
        PathEl::QuadTo(c, p) => within(c, 1.0) && within(p, 0.0),
        PathEl::CurveTo(c, d, p) => within(c, 1.0) && within(d, 1.0) && within(p, 0.0),
        PathEl::ClosePath => true,
    };
    if !elements.iter().all(stays) {
        return Err("leaves the canvas");
    }
    let on_frame = |element: Option<&PathEl>| element.and_then(PathEl::end_point).is_some_and(|p| !frame.holds(p));
    let has_ends = !is_closed(curve);
    if has_ends && !has_junctions && [elements.first(), elements.last()].into_iter().any(|end| !on_frame(end)) {
        return Err("is neither closed nor goes from frame to frame");
    }
    Ok(())
}

fn check_dot(dot: &Stipple, frame: Frame) -> std::result::Result<(), &'static str> {
    let reach = [dot.x, dot.y, frame.width - dot.x, frame.height - dot.y].into_iter().fold(f64::INFINITY, f64::min);
    let is_on_canvas = [dot.x, dot.y, dot.radius].into_iter().all(f64::is_finite) && dot.radius <= reach;
    match dot.radius > 0.0 {
        true if is_on_canvas => Ok(()),
        true => Err("does not lie on the canvas"),
        false => Err("has no radius above 0"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::put_together;

    /// Puts together curves, given as path data, and black dots, on a canvas of 40 x 20.
    fn made(curves: &[&str], dots: &[[f64; 3]]) -> Result<crate::Drawing> {
        let curves = curves.iter().map(|data| BezPath::from_svg(data).unwrap()).collect();
        let dot = |[x, y, radius]: &[f64; 3]| Stipple { x: *x, y: *y, radius: *radius, ink: Ink::BLACK, level: 0 };
        let stipples = dots.iter().map(dot).collect();
        let loose = Loose::plain(40, 20, curves, stipples);
        put_together(loose, &|shape| format!("{shape:?}"), &Control::new())
    }

    fn told(curves: &[&str], dots: &[[f64; 3]]) -> String {
        let error = made(curves, dots).unwrap_err().to_string();
        error.strip_prefix("this is not a drawing that graphstipple wrote: ").unwrap().to_owned()
    }

    /// Black, the other way around white.
    const RING: &str = "M10 5 L30 5 L30 15 L10 15 Z";

    #[test]
    fn shapes_that_touch_nothing_are_a_drawing() {
        let drawing = made(&[RING, "M12 7 L12 13 L20 13 L20 7 Z", "M2 0 L0 2"], &[[14.0, 10.0, 1.9], [18.0, 10.0, 1.9]]).unwrap();
        let areas: Vec<f64> = (0..drawing.regions.len()).map(|region| drawing.region_area(region)).collect();
        let dots = 2.0 * std::f64::consts::PI * 1.9 * 1.9;
        let expected = [2.0, 800.0 - 2.0 - 200.0, 200.0 - 48.0, 48.0 - dots];
        for area in expected {
            assert!(areas.iter().any(|found| (found - area).abs() < 1e-9), "{area} is not among {areas:?}");
        }
        assert_eq!(areas.len(), expected.len());
    }

    #[test]
    fn what_is_no_drawing_is_told_of_its_shape() {
        for (curves, dots, sentence) in [
            (vec![RING, RING], vec![], "Curve(0) touches or crosses Curve(1) near (10.0, 5.0)"),
            (vec!["M5 5 L9 9 L9 5 L5 9 Z"], vec![], "Curve(0) touches or crosses itself near (5.0, 5.0)"),
            (vec!["M0 5 L40 15", "M0 15 L40 5"], vec![], "Curve(0) touches or crosses Curve(1) near (0.0, 5.0)"),
            (vec!["M0 5 L40 5", "M0 15 L40 15"], vec![], "Curve(0) is black towards Curve(1), which is white there"),
            (vec![RING, "M12 7 L20 7 L20 13 Z"], vec![], "Curve(1) is white towards Curve(0), which is black there"),
            (vec!["M5 5 L9 5 L5 5 Z"], vec![], "Curve(0) encloses nothing"),
            (vec!["M5 5 L9 5 L9 9"], vec![], "Curve(0) is neither closed nor goes from frame to frame"),
            (vec!["M0 5 L9 5 L9 9"], vec![], "Curve(0) is neither closed nor goes from frame to frame"),
            (vec!["M9 5 L9 9 L0 9"], vec![], "Curve(0) is neither closed nor goes from frame to frame"),
            // It bends beyond its third corner, but by less than shows where crossings are looked for.
            (vec!["M10 10 Q15 10.04 20 10 L15 10.01 Z"], vec![], "Curve(0) encloses nothing"),
            (vec!["M0 5 L50 5"], vec![], "Curve(0) leaves the canvas"),
            (vec!["M1 5 Q9 1e14 9 5 Z"], vec![], "Curve(0) leaves the canvas"),
            (vec!["M1 5 Q5 -8 9 5 Z"], vec![], "Curve(0) touches or crosses the edge of the canvas"),
            (vec!["M1 5 L9 5 L9 9 Z M11 5 L19 5 L19 9 Z"], vec![], "Curve(0) is not one curve"),
            (vec![], vec![[5.0, 5.0, 2.0], [8.0, 5.0, 1.0]], "Stipple(0) touches or crosses Stipple(1) near (7.1, 4.4)"),
            (vec![], vec![[5.0, 5.0, 4.0], [5.0, 5.0, 1.0]], "Stipple(1) lies in Stipple(0)"),
            (vec![], vec![[5.0, 5.0, 6.0]], "Stipple(0) does not lie on the canvas"),
            (vec![], vec![[5.0, 5.0, 0.0]], "Stipple(0) has no radius above 0"),
            (vec![], vec![[5.0, 5.0, 1e-300]], "Stipple(0) is too small"),
            (vec![], vec![[5.0, 5.0, 5e-16]], "Stipple(0) is too small"),
            (vec![RING], vec![[20.0, 10.0, 2.0]], "Stipple(0) is black and lies in black"),
            (vec![RING], vec![[9.0, 10.0, 1.0]], "Curve(0) touches or crosses Stipple(0) near (9.3, 9.0)"),
        ] {
            let told = told(&curves, &dots);
            let part = |text: &str| text.split(" near ").next().unwrap_or_default().to_owned();
            assert_eq!(part(&told), part(sentence), "{curves:?} {dots:?}: {told}");
        }
    }

    #[test]
    fn a_curve_from_corner_to_corner_bounds_triangles() {
        for diagonal in ["M0 0 L40 20", "M40 20 L0 0", "M40 0 L0 20", "M0 20 L40 0"] {
            let drawing = made(&[diagonal], &[]).unwrap();
            let corners = |region: usize| drawing.regions[region].exterior.parts.len() - 1;
            assert_eq!([corners(0), corners(1)], [1, 1], "{diagonal}");
            assert_eq!([drawing.region_area(0), drawing.region_area(1)], [400.0, 400.0]);
        }
    }

    #[test]
    fn work_is_bounded_before_it_begins() {
        // Each bends by the height of the canvas.
        let units = MOST_UNITS;
        let quads = "Q39 -19 1 10 Q-39 39 39 10 ".repeat(4000);
        let curves = vec![BezPath::from_svg(&format!("M39 10 {quads}Z")).unwrap()];
        let loose = Loose { units, ..Loose::plain(40, 20, curves, vec![]) };
        let error = put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap_err().to_string();
        assert!(error.ends_with("Curve(0) bends further than curves of a drawing do"), "{error}");
        for units in [0.5, 3.0, f64::NAN, f64::INFINITY, 2.0 * MOST_UNITS, -16.0] {
            let loose = Loose { units, ..Loose::plain(40, 20, vec![], vec![]) };
            let error = put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap_err().to_string();
            assert!(error.ends_with("but there must be a power of two from 1 to 1048576"), "{error}");
        }
    }
}
