//! Paths and circles as polygons. Whoever flattens one curve gets the same points, so neighbours and files agree.

use std::sync::OnceLock;

use kurbo::{BezPath, CubicBez, ParamCurve as _, PathEl, Point, QuadBez};

/// How far a flattened outline may lie from the true curve in `regions` and `area`, in units of the drawing's grid. That is a
/// twentieth of a pixel where the grid has sixteen units to one: below what any raster or plotter shows, for about twice the points
/// of a quarter. Where nodes are so near to each other that the grid is finer, it is less.
const FLATTENING_UNITS: f64 = 0.8;

/// How far flattened outlines of a drawing may lie from the true curves, in pixels, if its grid has so many units to one.
pub(crate) fn flattening_tolerance(units: f64) -> f64 {
    FLATTENING_UNITS / units
}

/// No vertex of a circle's polygon lies further from its centre than this many radii: the coarsest polygon has eight sides.
pub(crate) const POLYGON_REACH: f64 = 1.055;

/// The part of the distance to the rim of its star, the triangles around its node, that the outline of a dot may fill.
pub(crate) const ROOM: f64 = 0.99;

/// The part of it that the radius of a round dot may fill: its polygon reaches a little beyond its circle.
pub(crate) const STAR_FILL: f64 = ROOM / POLYGON_REACH;

/// Whether a curve has no ends.
pub(crate) fn is_closed(path: &BezPath) -> bool {
    path.elements().last() == Some(&PathEl::ClosePath)
}

/// Whether the first control point of a curve is the last one before it, a curve of the same kind, mirrored at the point between:
/// then SVG leaves it out.
pub(crate) fn is_mirrored(before: &PathEl, element: &PathEl) -> bool {
    match (before, element) {
        (PathEl::QuadTo(last, joint), PathEl::QuadTo(first, _)) | (PathEl::CurveTo(_, last, joint), PathEl::CurveTo(first, ..)) => {
            *first == *joint + (*joint - *last)
        }
        _ => false,
    }
}

/// The points of a path's only subpath, flattened within `tolerance` px; the closing point is not repeated.
pub(crate) fn flatten_path(path: &BezPath, tolerance: f64) -> Vec<[f64; 2]> {
    let mut points: Vec<Point> = Vec::with_capacity(path.elements().len() * 4);
    for element in path.elements() {
        let from = points.last().copied().unwrap_or_default();
        match *element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => points.push(p),
            PathEl::QuadTo(c, p) => flatten_quad(&QuadBez::new(from, c, p), tolerance, &mut points),
            PathEl::CurveTo(c, d, p) => flatten_cubic(&CubicBez::new(from, c, d, p), tolerance, &mut points),
            PathEl::ClosePath => {}
        }
    }
    points.into_iter().map(|p| [p.x, p.y]).collect()
}

/// Appends points of a curve, at even steps of its parameter, so that the polygon through them lies within `tolerance` of it; not
/// its begin.
pub(crate) fn flatten_quad(quad: &QuadBez, tolerance: f64, points: &mut Vec<Point>) {
    let steps = flattening_steps(bend_of_quad(quad), tolerance);
    points.extend((1..steps as usize).map(|k| quad.eval(k as f64 / steps)));
    points.push(quad.p2);
}

/// The same for a cubic.
pub(crate) fn flatten_cubic(cubic: &CubicBez, tolerance: f64, points: &mut Vec<Point>) {
    let steps = flattening_steps(bend_of_cubic(cubic), tolerance);
    points.extend((1..steps as usize).map(|k| cubic.eval(k as f64 / steps)));
    points.push(cubic.p3);
}

/// How far a quadratic curve lies from its chord at most, in pixels.
pub(crate) fn bend_of_quad(quad: &QuadBez) -> f64 {
    0.25 * (quad.p0.to_vec2() - 2.0 * quad.p1.to_vec2() + quad.p2.to_vec2()).hypot2().sqrt()
}

/// A bound of the same for a cubic.
pub(crate) fn bend_of_cubic(cubic: &CubicBez) -> f64 {
    let [p0, p1, p2, p3] = [cubic.p0, cubic.p1, cubic.p2, cubic.p3].map(Point::to_vec2);
    0.75 * (p0 - 2.0 * p1 + p2).hypot2().max((p1 - 2.0 * p2 + p3).hypot2()).sqrt()
}

/// The even steps of its parameter in which a curve of such a bend keeps to a tolerance.
pub(crate) fn flattening_steps(bend: f64, tolerance: f64) -> f64 {
    (bend / tolerance).sqrt().ceil().max(1.0)
}

/// The sides of a curve's polygon.
pub(crate) fn flattened_edges(path: &BezPath, tolerance: f64) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let points = flatten_path(path, tolerance);
    let count = if is_closed(path) { points.len() } else { points.len() - 1 };
    (0..count).map(move |k| [points[k], points[(k + 1) % points.len()]])
}

/// The polygon of a circle: see [`crate::Drawing::stipple_outline`].
pub(crate) fn circle_polygon(centre: [f64; 2], radius: f64, tolerance: f64) -> Vec<[f64; 2]> {
    // A chord of half-angle h lies radius * (1 - cos h) inside the circle; half a tolerance each way once the area is corrected.
    let half = libm::acos((1.0 - (tolerance / radius).min(0.5)).max(0.5));
    let sides = (libm::ceil(std::f64::consts::PI / half) as usize).clamp(8, MOST_SIDES);
    let Polygon { circumradius, directions } = regular_polygon(sides);
    let corrected = radius * circumradius;
    directions.iter().map(|[x, y]| [centre[0] + corrected * x, centre[1] + corrected * y]).collect()
}

/// The most sides of a circle's polygon.
const MOST_SIDES: usize = 256;

/// A regular polygon around the origin with the area of the unit circle.
struct Polygon {
    circumradius: f64,
    /// Unit vectors to its vertices.
    directions: Vec<[f64; 2]>,
}

/// The polygon of so many sides, up to [`MOST_SIDES`]. Each is made once: drawings have many dots, of few numbers of sides.
fn regular_polygon(sides: usize) -> &'static Polygon {
    static POLYGONS: [OnceLock<Polygon>; MOST_SIDES + 1] = [const { OnceLock::new() }; MOST_SIDES + 1];
    POLYGONS[sides].get_or_init(|| {
        let step = std::f64::consts::TAU / sides as f64;
        let direction = |k: usize| {
            let angle = (k as f64 + 0.5) * step;
            [libm::cos(angle), libm::sin(angle)]
        };
        // A polygon with circumradius R has the area n/2 R^2 sin(2 pi / n); this R gives pi.
        Polygon { circumradius: libm::sqrt(step / libm::sin(step)), directions: (0..sides).map(direction).collect() }
    })
}
