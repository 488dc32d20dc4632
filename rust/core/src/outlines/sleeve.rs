//! The triangles that a contour runs through, one after the other, and whether a curve keeps to them.
//!
//! # Why curves never cross
//! The pieces join inside triangles, and piece k runs from one triangle to the next across edge k. Every triangle is crossed by one
//! contour alone and once only. So a curve that walks through its own triangles one after the other, crossing each edge between its
//! two nodes, can touch no other contour. Every curve is walked along like that, with the rounded coordinates that are written to
//! files: on both ways around it, or as it is flattened for regions and much finer. A piece that strays becomes a corner at the
//! crossing, which cannot stray. (The paper's own splines have no such guarantee.)
//!
//! In a triangle of three inks three contours end, each in the part of it between its edge and the junction.

use kurbo::{Point, QuadBez, Vec2};

use crate::base::{End, Frame, flatten_quad};

/// How near to the end of an edge a curve may cross it, as a fraction of its length. Smaller would allow slivers; larger would
/// turn more corners sharp and split more curves.
const EDGE_CLEARANCE: f64 = 0.05;

/// How far a curve stays from the sides of its triangles, in px^2 of the triangle that a point makes with a side: rounding in the
/// sum below is a thousandth of it.
const SIDE_CLEARANCE: f64 = 1e-7;

/// How near to a node a boundary that follows the tone may come, as a fraction of the edge: nearer, thin slivers would be left
/// between it and the next boundary.
pub(super) const NEAREST_CROSSING: f64 = 0.2;

/// How much finer than for regions a curve is flattened to see that it stays in its triangles.
const FINE: f64 = 0.25;

/// A crossing edge: its black and its white node.
pub(super) type CrossingEdge = [Point; 2];

/// Twice the signed area of the triangle a, b, c: positive when c lies to the left of a to b (from +x towards +y).
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b - a).cross(c - a)
}

/// Where the segment from p to q crosses the line through u and v, as a fraction of the way from u to v.
pub(super) fn crossing(p: Point, q: Point, u: Point, v: Point) -> f64 {
    let (from, to) = (turn(p, q, u), turn(p, q, v));
    // Parallel: nowhere.
    if from == to { f64::INFINITY } else { from / (from - to) }
}

/// Whether a fraction along an edge keeps clear of its ends.
pub(super) fn clear(fraction: f64) -> bool {
    (EDGE_CLEARANCE..=1.0 - EDGE_CLEARANCE).contains(&fraction)
}

/// The triangles that a contour runs through. Cell k holds joint k: it lies between edges k - 1 and k. The first and last cell of an
/// open contour lie between an edge and the frame, or the junction.
pub(super) struct Sleeve<'a> {
    pub(super) edges: &'a [CrossingEdge],
    /// Where the contour crosses them.
    pub(super) crossings: &'a [Point],
    cells: Vec<Cell>,
    closed: bool,
    frame: Frame,
    /// How far curves may lie from their polygons, in pixels.
    flattening: f64,
}

/// A convex cell: to the left of its sides.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    sides: [[Point; 2]; 3],
    /// The junction that is its corner, in which the contour ends.
    junction: Option<Point>,
}

impl Cell {
    pub(super) fn holds(&self, p: Point) -> bool {
        self.junction == Some(p) || self.sides.iter().all(|[a, b]| turn(*a, *b, p) > SIDE_CLEARANCE)
    }
}

impl<'a> Sleeve<'a> {
    pub(super) fn new(
        edges: &'a [CrossingEdge],
        crossings: &'a [Point],
        ends: Option<[End; 2]>,
        frame: Frame,
        flattening: f64,
    ) -> Self {
        let n = edges.len();
        // With black on the left of the way, an edge has what comes before on its left from white to black.
        let between = |[black, white]: CrossingEdge, [next_black, next_white]: CrossingEdge| {
            let third = if black == next_black { [white, next_white] } else { [next_black, black] };
            Cell { sides: [[black, white], [next_white, next_black], third], junction: None }
        };
        let cells = match ends {
            None => (0..n).map(|k| between(edges[(k + n - 1) % n], edges[k])).collect(),
            Some([begin, end]) => {
                // To a junction a triangle, to the frame what lies between the edge and it.
                let [black, white] = edges[0];
                let sides = [[white, black], [black, frame.end_point(black, begin)], [frame.end_point(white, begin), white]];
                let first = Cell { sides, junction: begin.junction() };
                let [black, white] = edges[n - 1];
                let sides = [[black, white], [frame.end_point(black, end), black], [white, frame.end_point(white, end)]];
                let last = Cell { sides, junction: end.junction() };
                let inner = edges.windows(2).map(|pair| between(pair[0], pair[1]));
                std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect()
            }
        };
        Self { edges, crossings, cells, closed: ends.is_none(), frame, flattening }
    }

    /// The number of a cell or edge that was counted on beyond the end of a closed contour, up to two rounds.
    fn wrapped(&self, k: usize) -> usize {
        let n = self.edges.len();
        match k {
            k if self.closed && k >= 2 * n => k - 2 * n,
            k if self.closed && k >= n => k - n,
            k => k,
        }
    }

    pub(super) fn cell(&self, k: usize) -> &Cell {
        &self.cells[self.wrapped(k)]
    }

    /// Whether a polyline from a point in cell `first` to one in cell `last` walks through the cells between, one after the other.
    /// Near its ends it must keep in front of the first point and behind the last, seen in the given directions, so that it cannot
    /// meet what comes before and after.
    pub(super) fn holds(&self, polyline: &[Point], first: usize, last: usize, directions: [Vec2; 2]) -> bool {
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

    /// The cell that holds a point about joint k, counted on from there; for a closed contour after a round more.
    pub(super) fn cell_of(&self, p: Point, k: usize) -> Option<usize> {
        let k = if self.closed { k + self.cells.len() } else { k };
        [k, k + 1, k.wrapping_sub(1)].into_iter().find(|k| (self.closed || *k < self.cells.len()) && self.cell(*k).holds(p))
    }

    /// Whether a quadratic curve from a point in cell `first` to one in cell `last` walks through the cells between, one after the
    /// other, however it is flattened: if the ways around it do, which nearly always do, and else as it is. The directions are as
    /// for [`Sleeve::holds`].
    pub(super) fn holds_quad(
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
                flatten_quad(quad, part * self.flattening, scratch);
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
