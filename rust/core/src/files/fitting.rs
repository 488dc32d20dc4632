//! Curves as few cubics, for the formats that have no quadratic curves. In: a [`Drawing`]; out: the same drawing with its curves
//! made of fewer pieces.
//!
//! # How
//! A run of pieces that join smoothly becomes one cubic that begins and ends where they do, in their directions. Its two lengths
//! are those of least squares; the longest run is taken whose cubic, on the grid of the file, lies within [`bound`] of it. Corners,
//! lines and the ends of open curves stay.
//!
//! A curve is fitted once and shared by its two regions, so they fit as before. Afterwards all curves and dots are compared with
//! their neighbours, as polygons and exactly: where a cubic meets anything, its run keeps its own pieces. So nothing touches that
//! did not.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveDeriv, PathSeg, Point, Rect, Vec2};

use crate::base::{distance_to_segment, flatten_cubic, is_closed, segments_meet, snap};
use crate::drawing::Drawing;

/// Pieces that one cubic stands for, at most.
const LONGEST_RUN: usize = 16;

/// Runs in a row that are too long, after which no longer one is tried.
const MISSES: usize = 2;

/// Points of a piece that its cubic is compared with.
const SAMPLES: usize = 4;

/// Times that the parameters of those points are improved.
const ROUNDS: usize = 3;

/// Cosine of the largest angle between two pieces that join smoothly: 3 degrees, above what the drawing's grid does to them.
const SMOOTH: f64 = 0.9986;

/// How far the polygons that are compared lie from their curves, in px.
const FLATNESS: f64 = 1.0 / 128.0;

/// Least side of the cells in which neighbours are looked for, in px. On canvases of few marks they are larger: as many as there are
/// edges and dots.
const LEAST_CELL: f64 = 2.0;

/// How far a cubic may lie from the pieces that it stands for, in px: a step of the grid that the drawing's own control points lie
/// on. For the default tolerance, that is a quarter of it.
pub(crate) fn bound(drawing: &Drawing) -> f64 {
    2.0 / drawing.units
}

/// The drawing with fewer pieces, all points of its curves on a grid of `units` to a pixel.
pub(crate) fn with_few_cubics(drawing: &Drawing, units: f64) -> Drawing {
    let bound = bound(drawing);
    let mut curves: Vec<Fitted> = drawing.curves.iter().map(|curve| Fitted::of(curve, bound, units)).collect();
    loop {
        let crossing = crossing_runs(&curves, drawing);
        if crossing.is_empty() {
            break;
        }
        for (curve, run) in crossing {
            curves[curve].runs[run].cubic = None;
        }
    }
    Drawing { curves: curves.iter().map(Fitted::path).collect(), ..drawing.clone() }
}

/// A curve as runs of its pieces.
struct Fitted {
    /// The pieces on the grid; cubics and lines.
    pieces: Vec<PathSeg>,
    runs: Vec<Run>,
    is_closed: bool,
}

/// Pieces in a row, and the cubic that stands for them, if there is one.
struct Run {
    pieces: Range<usize>,
    cubic: Option<CubicBez>,
}

impl Fitted {
    fn of(curve: &BezPath, bound: f64, units: f64) -> Self {
        let original: Vec<PathSeg> = curve.segments().collect();
        let source = Source::of(&original);
        let mut runs = Vec::new();
        let mut begin = 0;
        while begin < original.len() {
            let mut best = Run { pieces: begin..begin + 1, cubic: None };
            let mut misses = 0;
            for end in begin + 2..=original.len().min(begin + LONGEST_RUN) {
                if misses == MISSES || !source.is_smooth_at(end - 1) {
                    break;
                }
                match source.cubic(begin..end, bound, units) {
                    Some(cubic) => (best, misses) = (Run { pieces: begin..end, cubic: Some(cubic) }, 0),
                    None => misses += 1,
                }
            }
            begin = best.pieces.end;
            runs.push(best);
        }
        let rounded = original.iter().map(|piece| match piece {
            PathSeg::Line(line) => PathSeg::Line(kurbo::Line::new(snap(line.p0, units), snap(line.p1, units))),
            curved => {
                let CubicBez { p0, p1, p2, p3 } = curved.to_cubic();
                let [p0, p1, p2, p3] = [p0, p1, p2, p3].map(|p| snap(p, units));
                PathSeg::Cubic(CubicBez { p0, p1, p2, p3 })
            }
        });
        Self { pieces: rounded.collect(), runs, is_closed: is_closed(curve) }
    }

    /// The pieces that are drawn for a run.
    fn drawn(&self, run: usize) -> impl Iterator<Item = PathSeg> + '_ {
        let Run { pieces, cubic } = &self.runs[run];
        let own = if cubic.is_some() { 0..0 } else { pieces.clone() };
        cubic.map(PathSeg::Cubic).into_iter().chain(self.pieces[own].iter().copied())
    }

    fn path(&self) -> BezPath {
        let mut path = BezPath::with_capacity(self.runs.len() + 2);
        path.extend(self.pieces.first().map(|first| kurbo::PathEl::MoveTo(first.start())));
        path.extend((0..self.runs.len()).flat_map(|run| self.drawn(run)).map(|piece| piece.as_path_el()));
        if self.is_closed {
            path.close_path();
        }
        path
    }
}

/// A curve as runs are fitted to it.
struct Source {
    /// [`SAMPLES`] points of every piece, the last one its end; before them the curve's first point.
    points: Vec<Point>,
    /// Length of the polygon through the points, up to each of them.
    lengths: Vec<f64>,
    /// Directions in which every piece begins and ends; none of lines and of what is but a point.
    directions: Vec<Option<[Vec2; 2]>>,
}

impl Source {
    fn of(pieces: &[PathSeg]) -> Self {
        let mut points: Vec<Point> = pieces.first().map(|piece| piece.start()).into_iter().collect();
        points.extend(pieces.iter().flat_map(|piece| (1..=SAMPLES).map(|k| piece.eval(k as f64 / SAMPLES as f64))));
        let mut length = 0.0;
        let steps = points.windows(2).map(|pair| {
            length += length_of(pair[1] - pair[0]);
            length
        });
        let lengths = std::iter::once(0.0).chain(steps).collect();
        Self { lengths, points, directions: pieces.iter().map(directions).collect() }
    }

    /// Whether a piece joins the one before it smoothly.
    fn is_smooth_at(&self, piece: usize) -> bool {
        match (self.directions[piece - 1], self.directions[piece]) {
            (Some([_, before]), Some([after, _])) => before.dot(after) > SMOOTH,
            _ => false,
        }
    }

    /// The cubic for a run of smooth pieces, if there is one within the bound. A run whose pieces turn away from its chord by a right
    /// angle has none: it could not be told from a loop.
    fn cubic(&self, run: Range<usize>, bound: f64, units: f64) -> Option<CubicBez> {
        let (first, last) = (run.start * SAMPLES, run.end * SAMPLES);
        let (begin, end) = (snap(self.points[first], units), snap(self.points[last], units));
        let chord = end - begin;
        let ends = &self.directions[run.clone()];
        if !ends.iter().all(|ends| ends.is_some_and(|ends| ends.iter().all(|direction| direction.dot(chord) > 0.0))) {
            return None;
        }
        let (out, home) = (ends.first()?.as_ref()?[0], ends.last()?.as_ref()?[1]);
        let samples = &self.points[first + 1..last];
        let whole = self.lengths[last] - self.lengths[first];
        let mut at: Vec<f64> = self.lengths[first + 1..last].iter().map(|length| (length - self.lengths[first]) / whole).collect();
        let mut cubic = least_squares([begin, end], [out, home], samples, &at)?;
        for _ in 0..ROUNDS {
            if improve(&cubic, samples, &mut at) > 16.0 * bound * bound {
                return None;
            }
            cubic = least_squares([begin, end], [out, home], samples, &at)?;
        }
        let cubic = CubicBez { p1: snap(cubic.p1, units), p2: snap(cubic.p2, units), ..cubic };
        improve(&cubic, samples, &mut at);
        let is_within = samples.iter().zip(&at).all(|(sample, t)| (cubic.eval(*t) - *sample).hypot2() <= bound * bound);
        is_within.then_some(cubic)
    }
}

/// The length of a vector, by what is the same everywhere.
fn length_of(v: Vec2) -> f64 {
    v.hypot2().sqrt()
}

/// The directions in which a curved piece begins and ends.
fn directions(piece: &PathSeg) -> Option<[Vec2; 2]> {
    if matches!(piece, PathSeg::Line(_)) {
        return None;
    }
    let CubicBez { p0, p1, p2, p3 } = piece.to_cubic();
    let unit = |v: Vec2| (v != Vec2::ZERO).then(|| v / length_of(v));
    Some([unit(p1 - p0)?, unit(p3 - p2)?])
}

/// The cubic between two ends, in the directions there, that is nearest to samples at these parameters; none if it would begin or
/// end the other way round.
fn least_squares([begin, end]: [Point; 2], [out, home]: [Vec2; 2], samples: &[Point], at: &[f64]) -> Option<CubicBez> {
    let (mut c00, mut c01, mut c11, mut x0, mut x1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (sample, &t) in samples.iter().zip(at) {
        let s = 1.0 - t;
        let (b1, b2) = (3.0 * s * s * t, 3.0 * s * t * t);
        let rest = *sample - begin.lerp(end, b2 + t * t * t);
        let (first, second) = (b1 * out, -b2 * home);
        c00 += first.dot(first);
        c01 += first.dot(second);
        c11 += second.dot(second);
        x0 += first.dot(rest);
        x1 += second.dot(rest);
    }
    let determinant = c00 * c11 - c01 * c01;
    let a = (x0 * c11 - x1 * c01) / determinant;
    let b = (c00 * x1 - c01 * x0) / determinant;
    // Not a number, where the directions are the same and leave it open, is not above 0 either.
    (a > 0.0 && b > 0.0).then(|| CubicBez::new(begin, begin + a * out, end - b * home, end))
}

/// Moves the parameters towards the points of the cubic that are nearest to the samples; returns the largest squared distance before.
fn improve(cubic: &CubicBez, samples: &[Point], at: &mut [f64]) -> f64 {
    let (first, second) = (cubic.deriv(), cubic.deriv().deriv());
    let mut largest: f64 = 0.0;
    for (sample, t) in samples.iter().zip(at) {
        let off = cubic.eval(*t) - *sample;
        largest = largest.max(off.hypot2());
        let (along, bend) = (first.eval(*t).to_vec2(), second.eval(*t).to_vec2());
        let slope = along.hypot2() + off.dot(bend);
        if slope > 0.0 {
            *t = (*t - off.dot(along) / slope).clamp(0.0, 1.0);
        }
    }
    largest
}

/// A side of a curve's polygon.
#[derive(Clone, Copy)]
struct Edge {
    ends: [Point; 2],
    curve: usize,
    run: usize,
}

/// The runs, by curve, whose cubics meet another curve or a dot, or leave the canvas.
fn crossing_runs(curves: &[Fitted], drawing: &Drawing) -> BTreeSet<(usize, usize)> {
    let edges: Vec<Edge> = (0..curves.len()).flat_map(|curve| edges_of(curves, curve)).collect();
    let area = (drawing.width * drawing.height) as f64;
    let side = (area / (edges.len() + drawing.stipples.len()).max(1) as f64).sqrt().max(LEAST_CELL);
    let mut cells: HashMap<[i32; 2], Vec<u32>> = HashMap::new();
    for (number, edge) in edges.iter().enumerate() {
        for cell in cells_of(edge.ends, side) {
            cells.entry(cell).or_default().push(number as u32);
        }
    }
    let fitted = |edge: &Edge| curves[edge.curve].runs[edge.run].cubic.is_some().then_some((edge.curve, edge.run));
    let canvas = Rect::new(0.0, 0.0, drawing.width as f64, drawing.height as f64);
    let leaves = edges.iter().filter(|edge| canvas.union_pt(edge.ends[1]) != canvas);
    let mut crossing: BTreeSet<(usize, usize)> = leaves.filter_map(fitted).collect();
    for there in cells.values() {
        for (i, a) in there.iter().enumerate() {
            let a = &edges[*a as usize];
            for b in &there[i + 1..] {
                let b = &edges[*b as usize];
                if (fitted(a).is_some() || fitted(b).is_some()) && do_meet(a, b) {
                    crossing.extend([fitted(a), fitted(b)].into_iter().flatten());
                }
            }
        }
    }
    for dot in &drawing.stipples {
        let (centre, reach) = (Point::new(dot.x, dot.y), Vec2::new(dot.radius, dot.radius));
        for cell in cells_of([centre - reach, centre + reach], side) {
            let near = cells.get(&cell).into_iter().flatten().map(|number| &edges[*number as usize]);
            crossing.extend(
                near.filter(|edge| distance_to_segment(centre, edge.ends[0], edge.ends[1]) < dot.radius).filter_map(fitted),
            );
        }
    }
    crossing
}

/// The polygon of a curve.
fn edges_of(curves: &[Fitted], curve: usize) -> Vec<Edge> {
    let mut edges = Vec::new();
    let mut points = Vec::new();
    for run in 0..curves[curve].runs.len() {
        for piece in curves[curve].drawn(run) {
            points.clear();
            points.push(piece.start());
            match piece {
                PathSeg::Line(line) => points.push(line.p1),
                curved => flatten_cubic(&curved.to_cubic(), FLATNESS, &mut points),
            }
            edges.extend(points.windows(2).map(|pair| Edge { ends: [pair[0], pair[1]], curve, run }));
        }
    }
    edges
}

/// The cells that a box around two points covers.
fn cells_of([a, b]: [Point; 2], side: f64) -> impl Iterator<Item = [i32; 2]> {
    let cell = |v: f64| (v / side).floor() as i32;
    let columns = cell(a.x.min(b.x))..=cell(a.x.max(b.x));
    (cell(a.y.min(b.y))..=cell(a.y.max(b.y))).flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// Whether two edges have a point in common, but for the end that neighbours on a curve share.
fn do_meet(a: &Edge, b: &Edge) -> bool {
    let ([a0, a1], [b0, b1]) = (a.ends, b.ends);
    if a.curve == b.curve && (a1 == b0 || b1 == a0) {
        return false;
    }
    let [a, b] = [a, b].map(|edge| edge.ends.map(|p| [p.x, p.y]));
    segments_meet(a, b)
}

#[cfg(test)]
mod tests {
    use kurbo::{ParamCurveNearest as _, Shape as _};

    use super::*;
    use crate::base::flatten_path;
    use crate::files::svg::samples;

    const UNITS: f64 = 16.0;

    fn pieces_of(drawing: &Drawing) -> usize {
        drawing.curves.iter().map(|curve| curve.segments().count()).sum()
    }

    fn distance(p: Point, path: &BezPath) -> f64 {
        path.segments().map(|piece| piece.nearest(p, 1e-9).distance_sq.sqrt()).fold(f64::MAX, f64::min)
    }

    #[test]
    fn fewer_curves_lie_within_the_bound_and_keep_their_area() {
        let drawing =
            Drawing { units: UNITS, ..samples::drawing(400, 400, vec![(samples::blob([200.0, 200.0], 60.0, 300), 1)], &[]) };
        let fitted = with_few_cubics(&drawing, UNITS);
        assert!(pieces_of(&fitted) * 3 < pieces_of(&drawing), "{} of {}", pieces_of(&fitted), pieces_of(&drawing));
        let (before, after) = (&drawing.curves[0], &fitted.curves[0]);
        assert!((after.area() / before.area() - 1.0).abs() < 1e-3, "{} instead of {}", after.area(), before.area());
        for (from, to) in [(before, after), (after, before)] {
            for piece in from.segments() {
                for t in [0.1, 0.3, 0.5, 0.9] {
                    let off = distance(piece.eval(t), to);
                    assert!(off <= bound(&drawing) + 1e-6, "{off}");
                }
            }
        }
        assert_eq!(fitted, with_few_cubics(&drawing, UNITS));
    }

    #[test]
    fn corners_lines_and_ends_stay() {
        let mut path = BezPath::new();
        path.move_to((0.0, 10.0));
        path.quad_to((5.0, 10.0), (5.0, 15.0));
        path.quad_to((10.0, 15.0), (10.0, 20.0));
        path.line_to((10.0, 40.0));
        let drawing = Drawing { curves: vec![path.clone()], units: UNITS, width: 50, height: 40, ..Drawing::default() };
        let fitted = with_few_cubics(&drawing, UNITS);
        let ends = |path: &BezPath| path.segments().map(|piece| [piece.start(), piece.end()]).collect::<Vec<_>>();
        assert_eq!(ends(&fitted.curves[0]), ends(&path));
        assert!(!is_closed(&fitted.curves[0]));
    }

    /// Two curves side by side, `apart` from each other: one wavy, and the other with waves that a fit would level.
    fn side_by_side(apart: f64) -> Drawing {
        let wave = |y: f64, height: f64| {
            let mut path = BezPath::new();
            path.move_to((0.0, y));
            for i in 0..40 {
                let (x, side) = (f64::from(i), if i % 2 == 0 { height } else { -height });
                path.quad_to((x + 0.5, y + side), (x + 1.0, y));
            }
            path
        };
        let curves = vec![wave(10.0, 0.2), wave(10.0 + apart, 0.2)];
        Drawing { curves, units: UNITS, width: 40, height: 40, ..Drawing::default() }
    }

    #[test]
    fn what_would_meet_keeps_its_pieces() {
        for apart in [0.01, 0.05, 0.1, 1.0] {
            let drawing = side_by_side(apart);
            let fitted = with_few_cubics(&drawing, 1024.0);
            let [upper, lower] = [0, 1].map(|i| flatten_path(&fitted.curves[i], FLATNESS));
            for a in upper.windows(2) {
                for b in lower.windows(2) {
                    let edge = |ends: &[[f64; 2]], curve| {
                        let [a, b] = [ends[0], ends[1]].map(|[x, y]| Point::new(x, y));
                        Edge { ends: [a, b], curve, run: 0 }
                    };
                    assert!(!do_meet(&edge(a, 0), &edge(b, 1)), "{apart}: {a:?} and {b:?}");
                }
            }
        }
    }

    #[test]
    fn a_dot_beside_a_curve_stays_beside_it() {
        let mut drawing = side_by_side(1.0);
        let dot = |x: f64, y: f64| crate::outlines::Stipple { x, y, radius: 0.3, ..samples::nested().stipples[0] };
        // Above a wave that points down, and so near that a level line would cut it.
        drawing.stipples = vec![dot(10.5, 10.1 + 0.32), dot(21.5, 9.6)];
        let fitted = with_few_cubics(&drawing, 1024.0);
        for dot in &fitted.stipples {
            let centre = Point::new(dot.x, dot.y);
            let before = drawing.curves.iter().map(|curve| distance(centre, curve)).fold(f64::MAX, f64::min);
            let after = fitted.curves.iter().map(|curve| distance(centre, curve)).fold(f64::MAX, f64::min);
            assert!(before < dot.radius || after >= dot.radius - 1e-3, "{after}");
        }
    }
}
