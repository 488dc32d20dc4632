//! Fitting: from the points in which a chain crosses the graph's edges to the curve that is drawn.
//!
//! # The idea
//! The smoothed chain is a uniform quadratic B-spline whose control points are the chain's crossings (the midpoints of its crossing
//! edges, or other points on them); its pieces join in the middle between two crossings. That is the full outline, which tolerance
//! 0 draws. With a tolerance, runs of its pieces are replaced by one cubic Bezier curve each, as long as possible, that begins where
//! and in the direction in which the last one ended. Each curve is fitted once and shared by both sides, so neighbours always fit.
//!
//! # How far curves stray
//! No point of a curve lies further from the full outline than the tolerance, and no point of the full outline further from the
//! curve (their Hausdorff distance). Cubics are measured by both flattened finely; for single pieces it follows from their points.
//!
//! # Why curves never cross
//! The pieces join inside triangles, and piece k runs from one triangle to the next across edge k. Every triangle is crossed by one
//! chain alone and once only. So a curve that walks through its own triangles one after the other, crossing each edge between its
//! two nodes, can touch no other chain and not itself, whatever the tolerance. Every curve is walked along like that, as it is
//! flattened for regions and much finer, with the rounded coordinates that are written to files. One that strays is made shorter,
//! at last a corner at the crossing, which cannot stray. (The paper's own splines have no such guarantee.)
//!
//! # Coordinates
//! All points lie on a grid of a power of two to the pixel, so that files hold them exactly in few digits; where the grid is too
//! coarse for the triangles, on a finer one. Areas are kept: every curve makes up for what rounding and fitting the ones before it
//! in the chain added or took away.

use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveArea, PathEl, Point, QuadBez, Vec2};

use crate::drawing::{FLATTENING_TOLERANCE, Frame, flatten_cubic, flatten_quad, signed_area};
use crate::pair::Pair;
use crate::samples::{Products, Quadratic, Samples};
use crate::triangulation::Side;

/// A closed loop below this area, in px^2, is rescaled to the area of its polygon of crossings: the spline shrinks such small
/// loops by 5 % and more, which would lighten or darken textures made of them. Larger loops lose less than a dot prints.
const RESCALED_LOOP_AREA: f64 = 20.0;

/// The same for a loop that encloses the cells of a component: the midpoints around a few nodes hold 10 to 20 % less than their
/// cells, and without that what is small and light in the dark would become darker, and the reverse.
const RESCALED_CELLS_AREA: f64 = 80.0;

/// How near to the end of an edge a curve may cross it, as a fraction of its length. Smaller would allow slivers; larger would
/// turn more corners sharp and split more curves.
const EDGE_CLEARANCE: f64 = 0.05;

/// How far a curve stays from the sides of its triangles, in px^2 of the triangle that a point makes with a side: rounding in the
/// sum below is a thousandth of it.
const SIDE_CLEARANCE: f64 = 1e-7;

/// The most pieces that one cubic replaces: more hardly ever fit, and looking further costs time.
const LONGEST_RUN: usize = 24;

/// How much the end of a cubic is held to the spline's tangent, against the samples: less lets noise turn it, more leaves curves
/// further from the spline, and runs shorter.
const STIFFNESS: f64 = 0.5;

/// The same for an end that must not turn, because the curve that begins there is already drawn.
const FIXED: f64 = 1e9;

/// Rounds of placing the samples on a cubic and fitting it to them again, at most: more find a few more runs, and cost time.
const ROUNDS: usize = 3;

/// What a step along the curve counts, against one away from it, when a joint is moved to the grid.
const ALONG: f64 = 0.1;

/// How much keeping the area weighs, against keeping to the samples, when control points are rounded: less lets small loops lose
/// some of it, more takes curves further from the spline.
const AREA_WEIGHT: f64 = 2.0;

/// The area that a curve may gain or lose before it is fitted again with half the tolerance, in px^2: a few per cent of a dot. Less
/// would split many curves more finely for nothing that is seen.
const AREA_LEFT: f64 = 0.25;

/// What a closed curve may gain or lose on top, as a share of its own area.
const AREA_LEFT_SHARE: f64 = 0.002;

/// The part of the tolerance below which fitting with less is given up.
const LEAST_TOLERANCE: f64 = 1.0 / 16.0;

/// How much finer than for regions a curve is flattened to see that it stays in its triangles.
const FINE: f64 = 0.25;

/// The part of the tolerance that a curve is flattened to for its distance from the full outline to be measured: what two flattened
/// curves may be nearer than the curves themselves is taken off the tolerance, twice this. Less costs time, more costs points.
const MEASURED: f64 = 1.0 / 80.0;

/// Steps from the drawing's grid to finer ones, for points that the coarser grid would move out of their triangle.
pub(crate) const FINER_GRIDS: [f64; 4] = [1.0, 16.0, 256.0, 131_072.0];

/// The grid of a drawing: units to a pixel, a power of two.
///
/// With a tolerance the grid's error stays a third of it, and an eighth of a pixel is enough for nodes a pixel apart. Without one,
/// control points are a sixteenth of a pixel apart, and the points between them half as much.
pub(crate) fn units_per_pixel(tolerance: f64, nodes_per_pixel: f64) -> f64 {
    let least = if tolerance > 0.0 { (2.0 / tolerance).max(8.0) } else { 32.0 };
    let spacing = (1.15 / nodes_per_pixel).sqrt();
    let mut units = 8.0;
    while units < least || units * spacing < 8.0 {
        units *= 2.0;
    }
    units
}

/// A crossing edge: its black and its white node.
pub(crate) type CrossingEdge = [Point; 2];

/// What a chain is fitted with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    /// How far a curve may lie from the full outline, in pixels; 0 keeps every crossing.
    tolerance: f64,
    /// Units to a pixel of the grid of coordinates.
    pub(crate) units: f64,
    /// The same without a tolerance, for the full outline.
    full_units: f64,
    frame: Frame,
}

impl Fit {
    /// What chains are fitted with on a canvas with so many nodes to a pixel, at a tolerance in pixels.
    pub(crate) fn new(tolerance: f64, nodes_per_pixel: f64, frame: Frame) -> Self {
        let [units, full_units] = [tolerance, 0.0].map(|tolerance| units_per_pixel(tolerance, nodes_per_pixel));
        Self { tolerance, units, full_units, frame }
    }

    /// The curve of the chain that crosses `edges` about in the points `crossings`, with black on its left. A small closed chain
    /// encloses `area` px^2 if it is given, or else that of its polygon of crossings. An open chain begins and ends on the given
    /// sides of the frame.
    pub(crate) fn curve(&self, edges: &[CrossingEdge], crossings: &[Point], area: Option<f64>, ends: Option<[Side; 2]>) -> BezPath {
        let sleeve = Sleeve::new(edges, crossings, ends, self.frame);
        let outline = self.full_outline(area, ends, &sleeve);
        let fitted = if self.tolerance > 0.0 { self.fitted(&outline, &sleeve) } else { None };
        let mut path = fitted.unwrap_or_else(|| outline.path());
        if outline.closed {
            path.close_path();
        }
        path
    }

    /// The spline through all crossings, on its grid.
    fn full_outline(&self, area: Option<f64>, ends: Option<[Side; 2]>, sleeve: &Sleeve) -> Spline {
        let fit = Self { units: self.full_units, ..*self };
        let spline = Spline::new(self.frame, sleeve, area, ends);
        // Control points on twice the grid, so that joints lie on the grid too, and files need not say both.
        let controls: Vec<Point> = spline.controls.iter().map(|p| fit.snap(*p, 0.5)).collect();
        let snapped = joints(&controls, self.frame, ends);
        let on_grid = |(k, joint): (usize, &Point)| {
            std::iter::once(snapped[k]).chain(fit.snapped(*joint)).find(|p| sleeve.cell(k).holds(*p)).unwrap_or(*joint)
        };
        let joints: Vec<Point> = spline.joints.iter().enumerate().map(on_grid).collect();
        let mut scratch = Vec::new();
        let mut piece = |k: usize| {
            let (from, to, directions) = (joints[k], joints[k + 1], spline.directions(k, 1));
            let mut candidates = std::iter::once(controls[k]).chain(fit.snapped(spline.controls[k]));
            let curved = candidates.find(|p| sleeve.holds_quad(&QuadBez::new(from, *p, to), k, directions, &mut scratch));
            (curved.unwrap_or_else(|| fit.corner(sleeve, k, [from, to], directions)), curved.is_none())
        };
        let (controls, corners) = (0..sleeve.edges.len()).map(&mut piece).unzip();
        Spline { controls, joints, corners, closed: spline.closed }
    }

    /// Where piece k has its corner, if it is not a curve: where it crosses its edge, on the coarsest grid with which it stays in its
    /// cells.
    fn corner(&self, sleeve: &Sleeve, k: usize, [from, to]: [Point; 2], directions: [Vec2; 2]) -> Point {
        let crossing = sleeve.crossings[k];
        self.snapped(crossing).find(|p| sleeve.holds(&[from, *p, to], k, k + 1, directions)).unwrap_or(crossing)
    }

    /// The outline with fewer points, or None if that strays further than the tolerance.
    fn fitted(&self, outline: &Spline, sleeve: &Sleeve) -> Option<BezPath> {
        let flattened = outline.flattened(self.tolerance * MEASURED);
        let mut tolerance = self.tolerance;
        loop {
            let mut fitter = Fitter::new(&Self { tolerance, ..*self }, outline, &flattened, sleeve);
            fitter.run()?;
            let area = if outline.closed { fitter.areas[outline.controls.len()] } else { 0.0 };
            // What the last curve could not make up for is left over: with a smaller tolerance it is less.
            let is_kept = fitter.surplus.abs() <= AREA_LEFT + AREA_LEFT_SHARE * area.abs();
            if is_kept || tolerance <= self.tolerance * LEAST_TOLERANCE {
                return Some(fitter.path);
            }
            tolerance /= 2.0;
        }
    }

    /// Joint k on the grid, in its cell.
    fn anchor(&self, outline: &Spline, sleeve: &Sleeve, k: usize) -> Point {
        let joint = outline.joints[k];
        let fits = |p: &Point| (*p - joint).hypot2() <= self.tolerance * self.tolerance && sleeve.cell(k).holds(*p);
        let finer = || self.snapped(joint).find(fits);
        if !outline.closed && (k == 0 || k + 1 == outline.joints.len()) {
            return finer().unwrap_or(joint);
        }
        // Along the curve a point may move: of those around, the one nearest to the curve.
        let direction = outline.direction(k) / outline.direction(k).hypot2().sqrt();
        let off = |p: Point| (p - joint).cross(direction).abs() + ALONG * (p - joint).dot(direction).abs();
        let mut nearby = around(joint, self.units).map(|p| (off(p), p));
        // The nearest to the curve nearly always fits: only where it does not, the others are put in order.
        let nearest = nearby.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| *p);
        nearest.filter(fits).unwrap_or_else(|| {
            nearby.sort_by(|a, b| a.0.total_cmp(&b.0));
            nearby.iter().map(|(_, p)| *p).find(fits).or_else(finer).unwrap_or(joint)
        })
    }

    /// A point on the grid and on finer ones, the coarsest first.
    fn snapped(self, p: Point) -> impl Iterator<Item = Point> {
        FINER_GRIDS.iter().map(move |finer| self.snap(p, *finer))
    }

    fn snap(&self, p: Point, finer: f64) -> Point {
        let units = self.units * finer;
        Point::new((p.x * units).round() / units, (p.y * units).round() / units)
    }
}

/// The nine points of a grid around p.
fn around(p: Point, units: f64) -> [Point; 9] {
    let steps = |v: f64| {
        let nearest = (v * units).round();
        [0.0, 1.0, 2.0].map(|step| (nearest + step - 1.0) / units)
    };
    let (x, y) = (steps(p.x), steps(p.y));
    std::array::from_fn(|k| Point::new(x[k % 3], y[k / 3]))
}

/// Twice the signed area of the triangle a, b, c: positive when c lies to the left of a to b (from +x towards +y).
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b - a).cross(c - a)
}

/// Where the segment from p to q crosses the line through u and v, as a fraction of the way from u to v.
fn crossing(p: Point, q: Point, u: Point, v: Point) -> f64 {
    let (from, to) = (turn(p, q, u), turn(p, q, v));
    // Parallel: nowhere.
    if from == to { f64::INFINITY } else { from / (from - to) }
}

/// Whether a fraction along an edge keeps clear of its ends.
fn clear(fraction: f64) -> bool {
    (EDGE_CLEARANCE..=1.0 - EDGE_CLEARANCE).contains(&fraction)
}

/// The points in which the pieces of a spline join, from begin to end.
fn joints(controls: &[Point], frame: Frame, ends: Option<[Side; 2]>) -> Vec<Point> {
    let (first, last) = (controls[0], controls[controls.len() - 1]);
    let [begin, end] =
        ends.map_or([last.midpoint(first); 2], |[begin, end]| [frame.project(first, begin), frame.project(last, end)]);
    let between = controls.windows(2).map(|pair| pair[0].midpoint(pair[1]));
    std::iter::once(begin).chain(between).chain(std::iter::once(end)).collect()
}

/// A chain's spline or full outline: control points and joints in turn.
struct Spline {
    /// The control point of every piece, near where it crosses its edge.
    controls: Vec<Point>,
    /// `joints[k]` is where piece k begins and `joints[k + 1]` where it ends; for a closed chain the last is the first again.
    joints: Vec<Point>,
    /// The pieces that are corners: straight to the control point and straight on.
    corners: Vec<bool>,
    closed: bool,
}

/// A spline as a polyline.
struct Flattened {
    points: Vec<Point>,
    /// Where in it the joints are.
    places: Vec<usize>,
}

impl Flattened {
    /// The part from one joint to another.
    fn part(&self, first: usize, last: usize) -> &[Point] {
        &self.points[self.places[first]..=self.places[last]]
    }
}

impl Spline {
    /// The spline through the points in which a chain crosses its edges.
    fn new(frame: Frame, sleeve: &Sleeve, area: Option<f64>, ends: Option<[Side; 2]>) -> Self {
        let controls = sleeve.crossings.to_vec();
        let mut spline =
            Self { joints: joints(&controls, frame, ends), corners: vec![false; controls.len()], controls, closed: ends.is_none() };
        if spline.closed {
            spline.rescale(sleeve, area);
        }
        spline
    }

    /// As it is, from begin to end.
    fn path(&self) -> BezPath {
        let mut path = BezPath::with_capacity(self.joints.len() + 1);
        path.move_to(self.joints[0]);
        for (k, control) in self.controls.iter().enumerate() {
            if self.corners[k] {
                path.line_to(*control);
                path.line_to(self.joints[k + 1]);
            } else {
                path.quad_to(*control, self.joints[k + 1]);
            }
        }
        path
    }

    fn flattened(&self, tolerance: f64) -> Flattened {
        let pieces = self.controls.len();
        let (mut points, mut places) = (Vec::with_capacity(1 + 6 * pieces), Vec::with_capacity(1 + pieces));
        points.push(self.joints[0]);
        places.push(0);
        for k in 0..pieces {
            if self.corners[k] {
                points.extend([self.controls[k], self.joints[k + 1]]);
            } else {
                flatten_quad(&self.piece(k), tolerance, &mut points);
            }
            places.push(points.len() - 1);
        }
        Flattened { points, places }
    }

    fn piece(&self, k: usize) -> QuadBez {
        QuadBez::new(self.joints[k], self.controls[k], self.joints[k + 1])
    }

    /// The middle of piece k.
    fn middle(&self, k: usize) -> Point {
        if self.corners[k] { self.controls[k] } else { self.piece(k).eval(0.5) }
    }

    /// The area under piece k, as `kurbo` counts it.
    fn area(&self, k: usize) -> f64 {
        let (from, control, to) = (self.joints[k].to_vec2(), self.controls[k].to_vec2(), self.joints[k + 1].to_vec2());
        if self.corners[k] { 0.5 * (from.cross(control) + control.cross(to)) } else { self.piece(k).signed_area() }
    }

    /// The direction of the spline in a joint, of any length.
    fn direction(&self, k: usize) -> Vec2 {
        let n = self.controls.len();
        if self.closed {
            let before = if k == 0 { n } else { k };
            self.controls[if k == n { 0 } else { k }] - self.controls[before - 1]
        } else if k == 0 {
            self.controls[0] - self.joints[0]
        } else if k == n {
            self.joints[n] - self.controls[n - 1]
        } else {
            self.controls[k] - self.controls[k - 1]
        }
    }

    /// The directions in both ends of `length` pieces from piece k on.
    fn directions(&self, k: usize, length: usize) -> [Vec2; 2] {
        [self.direction(k), self.direction(k + length)]
    }

    /// Scales a small loop about its middle so that the spline has the area that is wanted, if every joint then still lies in its
    /// cell and every piece crosses its edge; else that of the polygon of its crossings, which moves joints hardly, if every piece
    /// then still crosses its edge.
    fn rescale(&mut self, sleeve: &Sleeve, wanted: Option<f64>) {
        let n = self.controls.len();
        let polygon: Vec<[f64; 2]> = self.controls.iter().map(|p| [p.x, p.y]).collect();
        let area = signed_area(&polygon).abs();
        if area >= if wanted.is_some() { RESCALED_CELLS_AREA } else { RESCALED_LOOP_AREA } {
            return;
        }
        let spline: f64 = (0..n).map(|k| self.area(k)).sum();
        let is_done = wanted.is_some_and(|wanted| self.scale((wanted / spline.abs()).sqrt(), sleeve, true));
        if !is_done {
            self.scale((area / spline.abs()).sqrt(), sleeve, false);
        }
    }

    /// Scales a loop about its middle, if every piece then still crosses its edge and, with `holds_joints`, every joint lies in its
    /// cell; says whether it did.
    fn scale(&mut self, factor: f64, sleeve: &Sleeve, holds_joints: bool) -> bool {
        if !(factor > 1.0 && factor < 1.5) {
            return false;
        }
        let n = self.controls.len();
        let middle = (self.controls.iter().fold(Vec2::ZERO, |sum, p| sum + p.to_vec2()) / n as f64).to_point();
        let scaled = |p: &Point| middle + (*p - middle) * factor;
        let joints: Vec<Point> = self.joints.iter().map(scaled).collect();
        let stays = (0..n).all(|k| {
            let [black, white] = sleeve.edges[k];
            (!holds_joints || sleeve.cell(k).holds(joints[k])) && clear(crossing(joints[k], joints[k + 1], black, white))
        });
        if stays {
            self.controls = self.controls.iter().map(scaled).collect();
            self.joints = joints;
        }
        stays
    }
}

/// The triangles that a chain runs through. Cell k holds joint k: it lies between edges k - 1 and k. The first and last cell of an
/// open chain lie between an edge and the frame.
struct Sleeve<'a> {
    edges: &'a [CrossingEdge],
    /// Where the chain crosses them.
    crossings: &'a [Point],
    cells: Vec<Cell>,
    closed: bool,
    frame: Frame,
}

/// A convex cell: to the left of its sides.
#[derive(Clone, Copy)]
struct Cell {
    sides: [[Point; 2]; 3],
}

impl Cell {
    fn holds(&self, p: Point) -> bool {
        self.sides.iter().all(|[a, b]| turn(*a, *b, p) > SIDE_CLEARANCE)
    }
}

impl<'a> Sleeve<'a> {
    fn new(edges: &'a [CrossingEdge], crossings: &'a [Point], ends: Option<[Side; 2]>, frame: Frame) -> Self {
        let n = edges.len();
        // With black on the left of the way, an edge has what comes before on its left from white to black.
        let between = |[black, white]: CrossingEdge, [next_black, next_white]: CrossingEdge| {
            let third = if black == next_black { [white, next_white] } else { [next_black, black] };
            Cell { sides: [[black, white], [next_white, next_black], third] }
        };
        let cells = match ends {
            None => (0..n).map(|k| between(edges[(k + n - 1) % n], edges[k])).collect(),
            Some([begin, end]) => {
                let [black, white] = edges[0];
                let first =
                    Cell { sides: [[white, black], [black, frame.project(black, begin)], [frame.project(white, begin), white]] };
                let [black, white] = edges[n - 1];
                let last = Cell { sides: [[black, white], [frame.project(black, end), black], [white, frame.project(white, end)]] };
                let inner = edges.windows(2).map(|pair| between(pair[0], pair[1]));
                std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect()
            }
        };
        Self { edges, crossings, cells, closed: ends.is_none(), frame }
    }

    fn cell(&self, k: usize) -> &Cell {
        &self.cells[if self.closed && k == self.cells.len() { 0 } else { k }]
    }

    /// Whether a polyline from a point in cell `first` to one in cell `last` walks through the cells between, one after the other.
    /// Near its ends it must keep in front of the first point and behind the last, seen in the given directions, so that it cannot
    /// meet what comes before and after.
    fn holds(&self, polyline: &[Point], first: usize, last: usize, directions: [Vec2; 2]) -> bool {
        let (begin, end) = (polyline[0], polyline[polyline.len() - 1]);
        let in_front = |p: Point| (p - begin).dot(directions[0]) > 0.0;
        let behind = |p: Point| (p - end).dot(directions[1]) < 0.0;
        let mut cell = first;
        for (i, pair) in polyline.windows(2).enumerate() {
            let (p, q) = (pair[0], pair[1]);
            let is_end = i + 2 == polyline.len();
            if !is_end && !self.frame.holds(q) {
                return false;
            }
            while !self.cell(cell).holds(q) {
                if cell == last {
                    return false;
                }
                let [black, white] = self.edges[cell];
                let (beyond, fraction) = (turn(black, white, q), crossing(p, q, black, white));
                if !(beyond >= -SIDE_CLEARANCE && clear(fraction)) {
                    return false;
                }
                let at = black.lerp(white, fraction);
                if (cell == first && !in_front(at)) || (cell + 1 == last && !behind(at)) {
                    return false;
                }
                cell += 1;
                // A point on the edge is as good as beyond it.
                if beyond <= SIDE_CLEARANCE {
                    break;
                }
            }
            if (cell == first && !in_front(q)) || (cell == last && !is_end && !behind(q)) {
                return false;
            }
        }
        cell == last
    }

    /// Whether a quadratic curve stays in the cells before and behind edge k, however it is flattened if the two ways around the
    /// triangle of its points walk through them, which nearly always do, and else as it is.
    fn holds_quad(&self, quad: &QuadBez, k: usize, directions: [Vec2; 2], scratch: &mut Vec<Point>) -> bool {
        let QuadBez { p0, p1, p2 } = *quad;
        let [black, white] = self.edges[k];
        let hull_stays = directions.iter().all(|direction| (p2 - p0).dot(*direction) > 0.0)
            && clear(crossing(p0, p2, black, white))
            && self.holds(&[p0, p1, p2], k, k + 1, directions);
        hull_stays
            || [FINE, 1.0].iter().all(|part| {
                scratch.clear();
                scratch.push(p0);
                flatten_quad(quad, part * FLATTENING_TOLERANCE, scratch);
                self.holds(scratch, k, k + 1, directions)
            })
    }
}

/// Fits one chain.
struct Fitter<'a> {
    fit: Fit,
    outline: &'a Spline,
    flattened: &'a Flattened,
    sleeve: &'a Sleeve<'a>,
    /// Every joint on the finest grid that keeps it in its cell.
    anchors: Vec<Point>,
    /// Area under the outline from its begin to every joint.
    areas: Vec<f64>,
    /// Area that the path so far has more than the outline.
    surplus: f64,
    /// The direction in which the last cubic ended.
    heading: Option<Vec2>,
    path: BezPath,
    /// Points of the outline between the ends of a run, with their places on the cubic.
    samples: Samples<LONGEST_RUN>,
    /// The square of the largest distance within the tolerance.
    near: f64,
    /// The same of the distance within which two flattened curves must lie.
    nearer: f64,
    polyline: Vec<Point>,
}

impl<'a> Fitter<'a> {
    fn new(fit: &Fit, outline: &'a Spline, flattened: &'a Flattened, sleeve: &'a Sleeve<'a>) -> Self {
        let n = outline.controls.len();
        let anchors: Vec<Point> = (0..=n).map(|k| fit.anchor(outline, sleeve, k)).collect();
        let mut areas = Vec::with_capacity(n + 1);
        let mut area = 0.0;
        areas.push(area);
        for k in 0..n {
            area += outline.area(k);
            areas.push(area);
        }
        let mut path = BezPath::with_capacity(n + 2);
        path.move_to(anchors[0]);
        Self {
            fit: *fit,
            outline,
            flattened,
            sleeve,
            anchors,
            areas,
            surplus: 0.0,
            heading: None,
            path,
            samples: Samples::new(),
            near: square_within(fit.tolerance),
            nearer: square_within(fit.tolerance * (1.0 - 2.0 * MEASURED)),
            polyline: Vec::new(),
        }
    }

    /// Fits the chain from begin to end, or gives up.
    fn run(&mut self) -> Option<()> {
        let n = self.outline.controls.len();
        let mut k = 0;
        while k < n {
            match self.longest_run(k) {
                Some((length, cubic)) => {
                    self.push(k, length, PathEl::CurveTo(cubic.p1, cubic.p2, cubic.p3), cubic.signed_area());
                    self.heading = Some(cubic.p3 - cubic.p2);
                    k += length;
                }
                None => {
                    self.single(k)?;
                    self.heading = None;
                    k += 1;
                }
            }
        }
        Some(())
    }

    /// The longest run from piece k on that one cubic replaces, of two pieces or more, and the cubic.
    fn longest_run(&mut self, k: usize) -> Option<(usize, CubicBez)> {
        self.samples.begin(self.anchors[k]);
        let mut tried = [None; LONGEST_RUN + 1];
        let mut longest = LONGEST_RUN.min(self.outline.controls.len() - k);
        let mut cubic = |length: usize| *tried[length].get_or_insert_with(|| self.cubic(k, length));
        // One run that does not fit may be followed by a longer one that does; two hardly ever are. To find two it is enough to try
        // every other, and both beside one that does not fit. Nearly all runs are of three pieces or more.
        let mut length = 4;
        while length <= longest {
            if cubic(length).is_none() {
                if cubic(length - 1).is_none() {
                    longest = length - 2;
                } else if length < longest && cubic(length + 1).is_none() {
                    longest = length - 1;
                }
            }
            length += 2;
        }
        let mut any = false;
        for length in (3..=longest).rev() {
            let found = *tried[length].get_or_insert_with(|| self.cubic(k, length));
            any |= found.is_some();
            if let Some(cubic) = found.and_then(|cubic| self.finished(k, length, &cubic)) {
                return Some((length, cubic));
            }
        }
        if any || k + 2 > self.outline.controls.len() {
            return None;
        }
        let cubic = self.cubic(k, 2)?;
        Some((2, self.finished(k, 2, &cubic)?))
    }

    fn push(&mut self, k: usize, length: usize, element: PathEl, area: f64) {
        self.surplus += area - self.outline_area(k, length);
        self.path.push(element);
    }

    /// Area under the outline from one anchor to another, by way of the joints.
    fn outline_area(&self, k: usize, length: usize) -> f64 {
        let last = k + length;
        let triangle = |a: Point, b: Point| 0.5 * a.to_vec2().cross(b.to_vec2());
        let [begin, end] = [k, last].map(|i| (self.anchors[i], self.outline.joints[i]));
        triangle(begin.0, begin.1) + self.areas[last] - self.areas[k] + triangle(end.1, end.0)
    }

    /// How much the area weighs for a curve that ends in joint `last`: what the end of the chain leaves over stays.
    fn area_weight(&self, last: usize) -> f64 {
        if last == self.outline.controls.len() { 10.0 * AREA_WEIGHT } else { AREA_WEIGHT }
    }

    /// A cubic for `length` pieces from piece k on, if there is one near enough.
    fn cubic(&mut self, k: usize, length: usize) -> Option<CubicBez> {
        let (p0, p3) = (self.anchors[k], self.anchors[k + length]);
        let chord = p3 - p0;
        let [begin, end] = self.outline.directions(k, length);
        let begin = self.heading.unwrap_or(begin);
        // A curve that turns by less than a right angle either way from its chord has no loop.
        if !(begin.dot(chord) > 0.0 && end.dot(chord) > 0.0) {
            return None;
        }
        let (begin, end) = (begin / begin.hypot2().sqrt(), end / end.hypot2().sqrt());
        let is_last = k + length == self.outline.controls.len();
        self.sample(k, length);
        let mut cubic = self.least_squares(p0, p3, begin, end, is_last);
        self.samples.project(&cubic);
        // Places and cubic follow each other; most runs that fit at all do so after one more round.
        for round in 1.. {
            cubic = self.least_squares(p0, p3, begin, end, is_last);
            self.samples.project_and_measure(&cubic);
            if self.samples.are_near(self.near) {
                return Some(cubic);
            }
            if round == ROUNDS {
                break;
            }
            self.samples.project_measured(&cubic);
        }
        None
    }

    /// The cubic with rounded control points, if it is still near enough and stays in its cells.
    fn finished(&mut self, k: usize, length: usize, cubic: &CubicBez) -> Option<CubicBez> {
        self.sample(k, length);
        self.samples.project(cubic);
        self.samples.project_and_measure(cubic);
        let cubic = self.rounded(cubic, self.outline_area(k, length) - self.surplus, k + length);
        self.samples.project_and_measure(&cubic);
        let chord = cubic.p3 - cubic.p0;
        let legs = [cubic.p1 - cubic.p0, cubic.p2 - cubic.p1, cubic.p3 - cubic.p2];
        if !self.samples.are_near(self.near) || legs.iter().any(|leg| leg.dot(chord) < 0.0) {
            return None;
        }
        let directions = self.outline.directions(k, length);
        let fine = (FINE * FLATTENING_TOLERANCE).min(self.fit.tolerance * MEASURED);
        let stays = [FLATTENING_TOLERANCE, fine].iter().all(|tolerance| {
            self.polyline.clear();
            self.polyline.push(cubic.p0);
            flatten_cubic(&cubic, *tolerance, &mut self.polyline);
            self.sleeve.holds(&self.polyline, k, k + length, directions)
        });
        let pieces = self.flattened.part(k, k + length);
        let is_near = || keeps_within(self.nearer, &self.polyline, pieces) && keeps_within(self.nearer, pieces, &self.polyline);
        (stays && is_near()).then_some(cubic)
    }

    /// Puts the samples on the outline between joints k and k + length: the middle of every piece and the joints.
    fn sample(&mut self, k: usize, length: usize) {
        for piece in k + self.samples.added()..k + length {
            self.samples.add(self.outline.middle(piece), self.outline.joints[piece + 1]);
        }
        self.samples.place_evenly(length);
    }

    /// The cubic with the given ends and tangents that lies nearest to the samples at their places (after Schneider, 1990). Its end
    /// may turn a little from its tangent, unless `is_last`.
    fn least_squares(&self, p0: Point, p3: Point, begin: Vec2, end: Vec2, is_last: bool) -> CubicBez {
        let chord = (p3 - p0).hypot2().sqrt();
        let aside = Vec2::new(-end.y, end.x);
        let Products { aa, ab, ac, bb, ar, br, cr } = self.samples.products([p0, p3], [begin, end]);
        // Three equations in three unknowns, solved by determinants, in which the product of b and c is 0.
        let cc = bb * if is_last { FIXED } else { 1.0 + STIFFNESS };
        let det = aa * (bb * cc) - ab * (ab * cc) - ac * (bb * ac);
        let alpha = (ar * (bb * cc) - ab * (br * cc) - ac * (bb * cr)) / det;
        let beta = (aa * (br * cc) - ar * (ab * cc) + ac * (ab * cr - br * ac)) / det;
        let gamma = (aa * (bb * cr) - ab * (ab * cr - br * ac) - ar * (bb * ac)) / det;
        let range = 0.05 * chord..=1.5 * chord;
        if range.contains(&alpha) && range.contains(&beta) && gamma.abs() <= 0.5 * beta {
            CubicBez::new(p0, p0 + begin * alpha, p3 - end * beta + aside * gamma, p3)
        } else {
            CubicBez::new(p0, p0 + begin * (chord / 3.0), p3 - end * (chord / 3.0), p3)
        }
    }

    /// The cubic with its control points on the grid: of those around, the ones with which it lies nearest to the samples,
    /// sideways, and its area comes near to the wanted one.
    fn rounded(&self, cubic: &CubicBez, wanted: f64, last: usize) -> CubicBez {
        let Quadratic { own, between, linear } = self.samples.quadratic(cubic);
        let cost_of = |k: usize, step: Vec2| {
            let [xx, xy, yy] = own[k];
            linear[k].dot(step) + xx * step.x * step.x + xy * step.x * step.y + yy * step.y * step.y
        };
        // Twenty times the area is a sum of cross products: of each control point with the ends, and of one with the other.
        let [p0, p3] = [cubic.p0, cubic.p3].map(Point::to_vec2);
        let area_of =
            |k: usize, p: Vec2| if k == 0 { 6.0 * p0.cross(p) + 3.0 * p.cross(p3) } else { 3.0 * p0.cross(p) + 6.0 * p.cross(p3) };
        let chord = (cubic.p3 - cubic.p0).hypot2();
        // The area as a mean distance along the chord.
        let weight = self.area_weight(last) * self.samples.count() as f64 / chord;
        let candidates = [cubic.p1, cubic.p2].map(|p| around(p, self.fit.units));
        let of = |k: usize, p: Point| {
            let step = p - [cubic.p1, cubic.p2][k];
            (step, cost_of(k, step), area_of(k, p.to_vec2()))
        };
        // Those of the second point two by two; the tenth is none.
        let seconds: [[Pair; 6]; 5] = std::array::from_fn(|pair| {
            let each = [2 * pair, 2 * pair + 1].map(|i| match candidates[1].get(i) {
                Some(p) => {
                    let (step, cost, area) = of(1, *p);
                    [p.x, p.y, step.x, step.y, cost, area]
                }
                None => [f64::INFINITY; 6],
            });
            std::array::from_fn(|value| Pair([each[0][value], each[1][value]]))
        });
        let mut best = (f64::INFINITY, *cubic);
        for p1 in candidates[0] {
            let (step1, cost1, area1) = of(0, p1);
            let across = Vec2::new(between[0] * step1.x + between[2] * step1.y, between[1] * step1.x + between[3] * step1.y) * 2.0;
            let rest = p0.cross(p3) + area1;
            let costs = seconds.map(|[x, y, step_x, step_y, cost2, area2]| {
                let cross = y * p1.x - x * p1.y;
                let area = (Pair::of(rest) + area2 + cross * 3.0).map(|area| area / 20.0);
                let off = area - Pair::of(wanted);
                Pair::of(cost1) + cost2 + (step_x * across.x + step_y * across.y) + off * weight * off
            });
            // Few rows have one that is better than all before: the others need no look at each.
            let less = |cost: f64, least: f64| if cost < least { cost } else { least };
            let least = costs.iter().fold(Pair::of(f64::INFINITY), |least, cost| cost.with(least, less));
            if !least.0.iter().any(|cost| *cost < best.0) {
                continue;
            }
            for (p2, cost) in candidates[1].iter().zip(costs.iter().flat_map(|pair| pair.0)) {
                if cost < best.0 {
                    best = (cost, CubicBez { p1, p2: *p2, ..*cubic });
                }
            }
        }
        best.1
    }

    /// Piece k as it is, on the coarsest grid that keeps it in its cells; None if that moves it further than the tolerance.
    fn single(&mut self, k: usize) -> Option<()> {
        let (from, control, to) = (self.anchors[k], self.outline.controls[k], self.anchors[k + 1]);
        let directions = self.outline.directions(k, 1);
        // Two pieces of one kind are nowhere further apart than their points are.
        let is_near = |p: &Point| (*p - control).hypot2() <= self.fit.tolerance * self.fit.tolerance;
        if self.outline.corners[k] {
            let corner = Some(self.fit.corner(self.sleeve, k, [from, to], directions)).filter(is_near)?;
            let area = 0.5 * (from.to_vec2().cross(corner.to_vec2()) + corner.to_vec2().cross(to.to_vec2()));
            self.push(k, 1, PathEl::LineTo(corner), area);
            self.path.line_to(to);
            return Some(());
        }
        let wanted = self.outline_area(k, 1) - self.surplus;
        let cost = |p: &Point| {
            let off = QuadBez::new(from, *p, to).signed_area() - wanted;
            self.area_weight(k + 1) * off * off / (to - from).hypot2() + (*p - control).hypot2()
        };
        let mut nearby = around(control, self.fit.units).map(|p| (cost(&p), p));
        nearby.sort_by(|a, b| a.0.total_cmp(&b.0));
        let finer = self.fit.snapped(control);
        let points = nearby.into_iter().map(|(_, p)| p).chain(finer).filter(is_near);
        let mut candidates = points.map(|p| QuadBez::new(from, p, to));
        let quad = candidates.find(|quad| self.sleeve.holds_quad(quad, k, directions, &mut self.polyline))?;
        self.push(k, 1, PathEl::QuadTo(quad.p1, to), quad.signed_area());
        Some(())
    }
}

/// The largest number with a square root that is not above a distance: squares compare with it as roots do with the distance.
fn square_within(distance: f64) -> f64 {
    let mut square = distance * distance;
    while square.sqrt() > distance {
        square = square.next_down();
    }
    while square.next_up().sqrt() <= distance {
        square = square.next_up();
    }
    square
}

/// Whether a point lies within a distance of a segment, of which the square is given: in the circle around one of its ends, or
/// beside it. Nothing is divided, and no branch is taken: this is what fitting spends most of its time on.
fn is_within(square: f64, p: Point, a: Point, b: Point) -> bool {
    let (along, off) = (b - a, p - a);
    let (length, place, aside) = (along.hypot2(), off.dot(along), off.cross(along));
    let is_beside = (place > 0.0) & (place < length) & (aside * aside <= square * length);
    is_beside | (off.hypot2() <= square) | ((p - b).hypot2() <= square)
}

/// Whether every point of one polyline lies within a distance of another, of which the square is given, both followed from begin to
/// end.
fn keeps_within(square: f64, polyline: &[Point], of: &[Point]) -> bool {
    let mut segment = 0;
    polyline.iter().all(|p| {
        while segment + 1 < of.len() {
            if is_within(square, *p, of[segment], of[segment + 1]) {
                return true;
            }
            segment += 1;
        }
        false
    })
}
