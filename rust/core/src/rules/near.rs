//! What lies near a place: how far the outlines of regions are, which ink is there, and in which order places follow one another.

use kurbo::Point;

use crate::base::{Ink, distance_to_segment};
use crate::offset::Polygon;

/// Edges of areas by the cells of a grid that they run through.
pub(super) struct Near {
    edges: Vec<[[f64; 2]; 2]>,
    cells: Grid,
    rows: Grid,
}

/// Numbers by cell, one after the other.
struct Grid {
    origin: [f64; 2],
    side: [f64; 2],
    columns: usize,
    lines: usize,
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

/// Edges to a cell, roughly: fewer are more cells to look into, more are more edges.
const EDGES_A_CELL: f64 = 4.0;

impl Near {
    /// Of black areas on a canvas of `size`, so that both say what is black: their outlines are closed along the frame too.
    pub(super) fn of(black: &[Polygon], size: [f64; 2]) -> Self {
        let of_ring = |ring: &Vec<[f64; 2]>| (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]).collect::<Vec<_>>();
        let edges: Vec<[[f64; 2]; 2]> = black.iter().flatten().flat_map(of_ring).collect();
        let cells = (edges.len() as f64 / EDGES_A_CELL).max(1.0);
        let side = (size[0] * size[1] / cells).sqrt();
        let cells = Grid::of(&edges, size, [side; 2]);
        // A ray to the left meets the edges of one row.
        let rows = Grid::of(&edges, size, [2.0 * size[0], (size[1] / (edges.len() as f64).sqrt().max(1.0)).max(1e-6)]);
        Self { edges, cells, rows }
    }

    /// How many edges there are.
    pub(super) fn len(&self) -> usize {
        self.edges.len()
    }

    /// Both ends of an edge; what is black lies on its left, x right and y down.
    pub(super) fn edge(&self, number: usize) -> [[f64; 2]; 2] {
        self.edges[number]
    }

    /// Whether an edge is nearer than this.
    pub(super) fn has_within(&self, p: [f64; 2], reach: f64) -> bool {
        let at = Point::new(p[0], p[1]);
        self.cells.any_around(p, reach, |number| {
            let [a, b] = self.edges[number as usize].map(|[x, y]| Point::new(x, y));
            distance_to_segment(at, a, b) < reach
        })
    }

    /// How far the nearest edge is; `reach` if none is nearer.
    pub(super) fn distance(&self, p: [f64; 2], reach: f64) -> f64 {
        self.nearest(p, reach).map_or(reach, |(distance, _)| distance)
    }

    /// How far the nearest edge is, and its point that is nearest, if it is within reach.
    pub(super) fn nearest(&self, p: [f64; 2], reach: f64) -> Option<(f64, [f64; 2])> {
        let at = Point::new(p[0], p[1]);
        let mut best: Option<(f64, u32)> = None;
        self.cells.around(p, reach, |number| {
            let [a, b] = self.edges[number as usize].map(|[x, y]| Point::new(x, y));
            let distance = distance_to_segment(at, a, b);
            let is_nearer = best.is_none_or(|(least, other)| distance < least || distance == least && number < other);
            if distance < reach && is_nearer {
                best = Some((distance, number));
            }
        });
        best.map(|(distance, number)| {
            let [a, b] = self.edges[number as usize].map(|[x, y]| Point::new(x, y));
            let Point { x, y } = nearest_on(at, [a, b]);
            (distance, [x, y])
        })
    }

    /// What the regions have at a place.
    pub(super) fn ink(&self, [x, y]: [f64; 2]) -> Ink {
        let mut crossed = false;
        self.rows.around([x, y], 0.0, |number| {
            let [[ax, ay], [bx, by]] = self.edges[number as usize];
            if (ay > y) != (by > y) && ax + (y - ay) / (by - ay) * (bx - ax) < x {
                crossed = !crossed;
            }
        });
        if crossed { Ink::BLACK } else { Ink::WHITE }
    }
}

impl Grid {
    fn of(edges: &[[[f64; 2]; 2]], size: [f64; 2], side: [f64; 2]) -> Self {
        let columns = (size[0] / side[0]) as usize + 1;
        let lines = (size[1] / side[1]) as usize + 1;
        let mut grid = Self { origin: [0.0; 2], side, columns, lines, starts: vec![0; columns * lines + 1], numbers: Vec::new() };
        let bounds = |[a, b]: &[[f64; 2]; 2]| [[a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]];
        for edge in edges {
            grid.each_cell(bounds(edge), |grid, cell| grid.starts[cell + 1] += 1);
        }
        for cell in 0..columns * lines {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        grid.numbers = vec![0; grid.starts[columns * lines] as usize];
        let mut next = grid.starts.clone();
        for (number, edge) in (0u32..).zip(edges) {
            grid.each_cell(bounds(edge), |grid, cell| {
                grid.numbers[next[cell] as usize] = number;
                next[cell] += 1;
            });
        }
        grid
    }

    fn each_cell(&mut self, [low, high]: [[f64; 2]; 2], mut visit: impl FnMut(&mut Self, usize)) {
        let [[left, top], [right, bottom]] = [low, high].map(|p| self.cell(p));
        for line in top..=bottom {
            for column in left..=right {
                visit(self, line * self.columns + column);
            }
        }
    }

    fn cell(&self, p: [f64; 2]) -> [usize; 2] {
        let along =
            |axis: usize, count: usize| (((p[axis] - self.origin[axis]) / self.side[axis]).max(0.0) as usize).min(count - 1);
        [along(0, self.columns), along(1, self.lines)]
    }

    /// Whether any of the numbers in the cells within reach of a place is one that is looked for.
    fn any_around(&self, p: [f64; 2], reach: f64, mut is_one: impl FnMut(u32) -> bool) -> bool {
        let [left, top] = self.cell(p.map(|v| v - reach));
        let [right, bottom] = self.cell(p.map(|v| v + reach));
        (top..=bottom).any(|line| {
            let (first, last) = (line * self.columns + left, line * self.columns + right);
            let range = self.starts[first] as usize..self.starts[last + 1] as usize;
            self.numbers[range].iter().any(|number| is_one(*number))
        })
    }

    /// The numbers in all cells within reach of a place; some of them more than once.
    fn around(&self, p: [f64; 2], reach: f64, mut visit: impl FnMut(u32)) {
        self.any_around(p, reach, |number| {
            visit(number);
            false
        });
    }
}

/// The point of a segment that is nearest to another one.
pub(super) fn nearest_on(p: Point, [a, b]: [Point; 2]) -> Point {
    let along = b - a;
    let t = ((p - a).dot(along) / along.hypot2()).clamp(0.0, 1.0);
    // Both ends in one place: the fraction is not a number.
    if t.is_nan() { a } else { a + along * t }
}

/// Discs that are all known, by cells, to be asked which are near each other.
pub(super) struct Pairs<'a> {
    discs: &'a [([f64; 2], f64)],
    cells: Grid,
    largest: f64,
}

impl<'a> Pairs<'a> {
    pub(super) fn of(discs: &'a [([f64; 2], f64)], size: [f64; 2]) -> Self {
        let largest = discs.iter().map(|(_, radius)| *radius).fold(0.0, f64::max);
        let points: Vec<[[f64; 2]; 2]> = discs.iter().map(|(centre, _)| [*centre; 2]).collect();
        let side = (size[0] * size[1] / discs.len().max(1) as f64).sqrt();
        Self { discs, cells: Grid::of(&points, size, [side; 2]), largest }
    }

    /// The discs that lie beside this one and whose rims are nearer than `reach`, with how far they are, nearest first: of two in one
    /// direction the nearer one.
    pub(super) fn neighbours(&self, number: usize, reach: f64) -> Vec<(f64, usize)> {
        let (centre, radius) = self.discs[number];
        let mut near: Vec<(f64, usize)> = Vec::new();
        self.cells.around(centre, reach + radius + self.largest, |other| {
            let other = other as usize;
            let (at, size) = self.discs[other];
            let [x, y] = [at[0] - centre[0], at[1] - centre[1]];
            let distance = (x * x + y * y).sqrt() - radius - size;
            if other != number && distance < reach {
                near.push((distance, other));
            }
        });
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut beside: Vec<(f64, usize)> = Vec::new();
        for (distance, other) in near {
            let out = |number: usize| [0, 1].map(|axis| self.discs[number].0[axis] - centre[axis]);
            let [x, y] = out(other);
            // Within 60 degrees of a nearer one it lies behind it.
            let is_behind = |(_, nearer): &(f64, usize)| {
                let [u, v] = out(*nearer);
                let dot = x * u + y * v;
                dot > 0.0 && dot * dot > 0.25 * (x * x + y * y) * (u * u + v * v)
            };
            if !beside.iter().any(is_behind) {
                beside.push((distance, other));
            }
            // There are no more than six directions.
            if beside.len() == 6 {
                break;
            }
        }
        beside
    }
}

/// Discs that are placed one after another, each to be asked how far it is.
#[derive(Clone)]
pub(super) struct Discs {
    side: f64,
    columns: usize,
    cells: Vec<Vec<([f64; 2], f64)>>,
    largest: f64,
}

impl Discs {
    /// On a canvas of `size`, of which there will be about so many.
    pub(super) fn new(size: [f64; 2], count: usize) -> Self {
        let side = (size[0] * size[1] / count.max(1) as f64).sqrt();
        let columns = (size[0] / side) as usize + 1;
        let lines = (size[1] / side) as usize + 1;
        Self { side, columns, cells: vec![Vec::new(); columns * lines], largest: 0.0 }
    }

    fn cell(&self, p: [f64; 2]) -> [usize; 2] {
        let lines = self.cells.len() / self.columns;
        let along = |v: f64, count: usize| ((v / self.side).max(0.0) as usize).min(count - 1);
        [along(p[0], self.columns), along(p[1], lines)]
    }

    pub(super) fn add(&mut self, centre: [f64; 2], radius: f64) {
        let [column, line] = self.cell(centre);
        self.cells[line * self.columns + column].push((centre, radius));
        self.largest = self.largest.max(radius);
    }

    /// How far the nearest disc's rim is from a place; `reach` if none is nearer.
    pub(super) fn distance(&self, p: [f64; 2], reach: f64) -> f64 {
        self.nearest(p, reach).map_or(reach, |(distance, _)| distance)
    }

    /// The disc whose rim is nearest, how far that is, and its centre, if it is within reach.
    pub(super) fn nearest(&self, p: [f64; 2], reach: f64) -> Option<(f64, [f64; 2])> {
        let out = reach + self.largest;
        let [left, top] = self.cell(p.map(|v| v - out));
        let [right, bottom] = self.cell(p.map(|v| v + out));
        let mut best: Option<(f64, [f64; 2])> = None;
        for line in top..=bottom {
            for (centre, radius) in (left..=right).flat_map(|column| &self.cells[line * self.columns + column]) {
                let [x, y] = [centre[0] - p[0], centre[1] - p[1]];
                let distance = (x * x + y * y).sqrt() - radius;
                if distance < reach && best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, *centre));
                }
            }
        }
        best
    }
}

/// The place of a point on a Hilbert curve over a square of `side`: points that are near on the curve are near in the plane.
pub(super) fn along_curve(p: [f64; 2], side: f64) -> u32 {
    const ORDER: u32 = 16;
    let whole = |v: f64| ((v / side * f64::from(1u32 << ORDER)).max(0.0) as u32).min((1 << ORDER) - 1);
    let (mut x, mut y) = (whole(p[0]), whole(p[1]));
    let mut along = 0u32;
    let mut s = 1u32 << (ORDER - 1);
    while s > 0 {
        let (rx, ry) = (u32::from(x & s > 0), u32::from(y & s > 0));
        along = along.wrapping_add(s.wrapping_mul(s).wrapping_mul((3 * rx) ^ ry));
        // Turned so that the next quarter begins where the last one ended.
        if ry == 0 {
            if rx == 1 {
                (x, y) = ((1 << ORDER) - 1 - x, (1 << ORDER) - 1 - y);
            }
            std::mem::swap(&mut x, &mut y);
        }
        s >>= 1;
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_from_neighbour_to_neighbour() {
        // All cells of a grid of 16 x 16, in order.
        let mut cells: Vec<(u32, [f64; 2])> = Vec::new();
        for i in 0..256u32 {
            let p = [f64::from(i % 16) + 0.5, f64::from(i / 16) + 0.5];
            cells.push((along_curve(p, 16.0), p));
        }
        cells.sort_by_key(|(along, _)| *along);
        for pair in cells.windows(2) {
            let [a, b] = [pair[0].1, pair[1].1];
            assert_eq!((a[0] - b[0]).abs() + (a[1] - b[1]).abs(), 1.0, "{a:?} {b:?}");
        }
    }

    #[test]
    fn distances_and_inks_are_those_of_the_areas() {
        let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
        let mut ring = square(2.0, 8.0);
        let hole: Vec<[f64; 2]> = square(4.0, 6.0).into_iter().rev().collect();
        let near = Near::of(&[vec![std::mem::take(&mut ring), hole]], [10.0, 10.0]);
        for (p, ink, distance) in [
            ([1.0, 1.5], Ink::WHITE, 1.0f64.hypot(0.5)),
            ([3.0, 5.0], Ink::BLACK, 1.0),
            ([5.0, 5.5], Ink::WHITE, 0.5),
            ([9.5, 5.0], Ink::WHITE, 1.5),
            ([7.9, 7.9], Ink::BLACK, 0.1),
        ] {
            assert_eq!(near.ink(p), ink, "{p:?}");
            assert!((near.distance(p, 5.0) - distance).abs() < 1e-9, "{p:?}");
            assert_eq!(near.distance(p, 0.05), 0.05);
        }
    }

    #[test]
    fn the_nearest_disc_is_found() {
        let mut discs = Discs::new([10.0, 10.0], 3);
        assert_eq!(discs.nearest([1.0, 1.0], 20.0), None);
        discs.add([2.0, 2.0], 0.5);
        discs.add([8.0, 2.0], 4.0);
        assert_eq!(discs.nearest([4.0, 2.0], 20.0), Some((0.0, [8.0, 2.0])));
        assert_eq!(discs.distance([2.0, 5.0], 20.0), 2.5);
        assert_eq!(discs.distance([2.0, 5.0], 1.0), 1.0);
    }
}
