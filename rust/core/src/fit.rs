//! Outlines: from the points in which a chain crosses the graph's edges to the curve that is drawn.
//!
//! # The idea
//! The smoothed chain is a uniform quadratic B-spline whose control points are the chain's crossings (the midpoints of its crossing
//! edges, or other points on them); its pieces join in the middle between two crossings. That is the full outline, which tolerance
//! 0 draws. With a tolerance it is drawn with fewer points (see [`crate::simplify`]). Each curve is made once and shared by both
//! sides, so neighbours always fit.
//!
//! # Why curves never cross
//! The pieces join inside triangles, and piece k runs from one triangle to the next across edge k. Every triangle is crossed by one
//! chain alone and once only. So a curve that walks through its own triangles one after the other, crossing each edge between its
//! two nodes, can touch no other chain. Every curve is walked along like that, with the rounded coordinates that are written to
//! files: on both ways around it, or as it is flattened for regions and much finer. A piece that strays becomes a corner at the
//! crossing, which cannot stray. (The paper's own splines have no such guarantee.)
//!
//! # Coordinates
//! All points lie on a grid of a power of two to the pixel, so that files hold them exactly in few digits; where the grid is too
//! coarse for the triangles, on a finer one.

use kurbo::{BezPath, ParamCurve, ParamCurveArea, Point, QuadBez, Vec2};

use crate::drawing::{FLATTENING_TOLERANCE, Frame, flatten_quad, signed_area};
use crate::simplify::Simplifier;
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

/// How much finer than for regions a curve is flattened to see that it stays in its triangles.
const FINE: f64 = 0.25;

/// Steps from the drawing's grid to finer ones, for points that the coarser grid would move out of their triangle.
pub(crate) const FINER_GRIDS: [f64; 4] = [1.0, 16.0, 256.0, 131_072.0];

/// The grid of a drawing: units to a pixel, a power of two.
///
/// Control points take every other place. With a tolerance they are moved by no more than a third of it, and an eighth of a pixel
/// is enough for nodes a pixel apart. Without one they are a sixteenth of a pixel apart.
pub(crate) fn units_per_pixel(tolerance: f64, nodes_per_pixel: f64) -> f64 {
    let least = if tolerance > 0.0 { (4.0 / tolerance).max(16.0) } else { 32.0 };
    let mut units = 8.0;
    while units < least || units * spacing(nodes_per_pixel) < 8.0 {
        units *= 2.0;
    }
    units
}

/// The distance between neighbours where so many nodes to a pixel lie evenly.
fn spacing(nodes_per_pixel: f64) -> f64 {
    (1.15 / nodes_per_pixel).sqrt()
}

/// A crossing edge: its black and its white node.
pub(crate) type CrossingEdge = [Point; 2];

/// What a chain is fitted with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    /// How far a curve may lie from the full outline, in pixels; 0 keeps every crossing.
    pub(crate) tolerance: f64,
    /// Units to a pixel of the grid of coordinates.
    pub(crate) units: f64,
    /// The same without a tolerance, for the full outline.
    full_units: f64,
    /// About how far nodes lie from each other, in pixels.
    pub(crate) spacing: f64,
    frame: Frame,
}

impl Fit {
    /// What chains are fitted with on a canvas with so many nodes to a pixel, at a tolerance in pixels.
    pub(crate) fn new(tolerance: f64, nodes_per_pixel: f64, frame: Frame) -> Self {
        let [units, full_units] = [tolerance, 0.0].map(|tolerance| units_per_pixel(tolerance, nodes_per_pixel));
        Self { tolerance, units, full_units, spacing: spacing(nodes_per_pixel), frame }
    }

    /// The curve of the chain that crosses `edges` about in the points `crossings`, with black on its left. A small closed chain
    /// encloses `area` px^2 if it is given, or else that of its polygon of crossings. An open chain begins and ends on the given
    /// sides of the frame.
    pub(crate) fn curve(&self, edges: &[CrossingEdge], crossings: &[Point], area: Option<f64>, ends: Option<[Side; 2]>) -> BezPath {
        let sleeve = Sleeve::new(edges, crossings, ends, self.frame);
        let outline = self.full_outline(area, ends, &sleeve);
        let outline = if self.tolerance > 0.0 { Simplifier::new(self, &outline, &sleeve).run() } else { outline };
        let mut path = outline.path();
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
            let (from, to, directions) = (joints[k], joints[k + 1], spline.directions(k));
            let mut candidates = std::iter::once(controls[k]).chain(fit.snapped(spline.controls[k]));
            let curved = candidates.find(|p| sleeve.holds_quad(&QuadBez::new(from, *p, to), k, k + 1, directions, &mut scratch));
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

    /// A point on the grid and on finer ones, the coarsest first.
    fn snapped(self, p: Point) -> impl Iterator<Item = Point> {
        FINER_GRIDS.iter().map(move |finer| self.snap(p, *finer))
    }

    fn snap(&self, p: Point, finer: f64) -> Point {
        snap(p, self.units * finer)
    }
}

/// The point of a grid that is nearest to p.
pub(crate) fn snap(p: Point, units: f64) -> Point {
    Point::new((p.x * units).round() / units, (p.y * units).round() / units)
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
pub(crate) struct Spline {
    /// The control point of every piece, near where it crosses its edge.
    pub(crate) controls: Vec<Point>,
    /// `joints[k]` is where piece k begins and `joints[k + 1]` where it ends; for a closed chain the last is the first again.
    pub(crate) joints: Vec<Point>,
    /// The pieces that are corners: straight to the control point and straight on.
    pub(crate) corners: Vec<bool>,
    pub(crate) closed: bool,
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

    fn piece(&self, k: usize) -> QuadBez {
        QuadBez::new(self.joints[k], self.controls[k], self.joints[k + 1])
    }

    /// The second difference of piece k: 0 for a corner, which is straight on both sides.
    pub(crate) fn bend(&self, k: usize) -> Vec2 {
        let QuadBez { p0, p1, p2 } = self.piece(k);
        if self.corners[k] { Vec2::ZERO } else { (p2 - p1) - (p1 - p0) }
    }

    /// The middle of piece k.
    pub(crate) fn middle(&self, k: usize) -> Point {
        if self.corners[k] { self.controls[k] } else { self.piece(k).eval(0.5) }
    }

    /// The area under the spline from begin to end.
    pub(crate) fn whole_area(&self) -> f64 {
        (0..self.controls.len()).map(|k| self.area(k)).sum()
    }

    /// The area under piece k, as `kurbo` counts it.
    pub(crate) fn area(&self, k: usize) -> f64 {
        let (from, control, to) = (self.joints[k].to_vec2(), self.controls[k].to_vec2(), self.joints[k + 1].to_vec2());
        if self.corners[k] { 0.5 * (from.cross(control) + control.cross(to)) } else { self.piece(k).signed_area() }
    }

    /// The direction of the spline in a joint, of any length.
    pub(crate) fn direction(&self, k: usize) -> Vec2 {
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

    /// The directions in both ends of a piece.
    fn directions(&self, k: usize) -> [Vec2; 2] {
        [self.direction(k), self.direction(k + 1)]
    }

    /// Scales a small loop about its middle so that the spline has the area that is wanted, if every joint then still lies in its
    /// cell and every piece crosses its edge; else that of the polygon of its crossings, which moves joints hardly, if every piece
    /// then still crosses its edge.
    fn rescale(&mut self, sleeve: &Sleeve, wanted: Option<f64>) {
        let polygon: Vec<[f64; 2]> = self.controls.iter().map(|p| [p.x, p.y]).collect();
        let area = signed_area(&polygon).abs();
        if area >= if wanted.is_some() { RESCALED_CELLS_AREA } else { RESCALED_LOOP_AREA } {
            return;
        }
        let spline = self.whole_area();
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
pub(crate) struct Sleeve<'a> {
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

    /// The number of a cell or edge that was counted on beyond the end of a closed chain, up to two rounds.
    fn wrapped(&self, k: usize) -> usize {
        let n = self.edges.len();
        match k {
            k if self.closed && k >= 2 * n => k - 2 * n,
            k if self.closed && k >= n => k - n,
            k => k,
        }
    }

    fn cell(&self, k: usize) -> &Cell {
        &self.cells[self.wrapped(k)]
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
                let [black, white] = self.edges[self.wrapped(cell)];
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

    /// The cell that holds a point about joint k, counted on from there; for a closed chain after a round more.
    pub(crate) fn cell_of(&self, p: Point, k: usize) -> Option<usize> {
        let k = if self.closed { k + self.cells.len() } else { k };
        [k, k + 1, k.wrapping_sub(1)].into_iter().find(|k| (self.closed || *k < self.cells.len()) && self.cell(*k).holds(p))
    }

    /// Whether a quadratic curve from a point in cell `first` to one in cell `last` walks through the cells between, one after the
    /// other, however it is flattened: if the ways around it do, which nearly always do, and else as it is. The directions are as
    /// for [`Sleeve::holds`].
    pub(crate) fn holds_quad(
        &self,
        quad: &QuadBez,
        first: usize,
        last: usize,
        directions: [Vec2; 2],
        scratch: &mut Vec<Point>,
    ) -> bool {
        self.holds_ways_around(quad, first, last, directions).unwrap_or_else(|| {
            [FINE, 1.0].iter().all(|part| {
                scratch.clear();
                scratch.push(quad.p0);
                flatten_quad(quad, part * FLATTENING_TOLERANCE, scratch);
                self.holds(scratch, first, last, directions)
            })
        })
    }

    /// Whether both ways around a curve, straight and over the middles of its legs, walk through the cells as for
    /// [`Sleeve::holds_quad`]; it lies between them, and so does every polyline through points of it. Not known if they do not both.
    ///
    /// A line from a point in a cell that has the black node of an edge of it on its left and the white one on its right comes to
    /// the next cell. So no more needs to be asked of edges between the cells of two points than on which sides of the line
    /// their nodes are.
    fn holds_ways_around(&self, quad: &QuadBez, first: usize, last: usize, directions: [Vec2; 2]) -> Option<bool> {
        let QuadBez { p0, p1, p2 } = *quad;
        let legs = [p1 - p0, p2 - p0, p2 - p1];
        let begins = [p0, p0.midpoint(p1), p1.midpoint(p2)];
        let keeps_direction = |direction: Vec2, leg: usize| legs[leg].dot(direction) > 0.0 && legs[1].dot(direction) > 0.0;
        let mut stays = keeps_direction(directions[0], 0) && keeps_direction(directions[1], 2);
        stays &= begins[1..].iter().all(|begin| self.frame.holds(*begin));
        let mut leg = 0;
        for k in first..last {
            let [black, white] = self.edges[self.wrapped(k)];
            // The leg that passes this edge is the first whose end is behind it.
            while leg < 2 && turn(black, white, begins[leg + 1]) <= SIDE_CLEARANCE {
                leg += 1;
                stays &= self.cell(k).holds(begins[leg]);
            }
            // Whether a line passes on the right side of the black node, and of the white one.
            let passes = |begin: Point, way: Vec2| {
                let [black, white] = [black, white].map(|node| way.cross(node - begin));
                [black + EDGE_CLEARANCE * (white - black) >= 0.0, white + EDGE_CLEARANCE * (black - white) <= 0.0]
            };
            let (straight, around) = (passes(p0, legs[1]), passes(begins[leg], legs[leg]));
            if (0..2).any(|side| !straight[side] && !around[side]) {
                return Some(false);
            }
            stays &= straight == [true; 2] && around == [true; 2];
        }
        stays &= begins[leg + 1..].iter().all(|begin| self.cell(last).holds(*begin));
        stays.then_some(true)
    }
}
