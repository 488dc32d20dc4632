//! Which black lies in which white: in, black polygons that are disjoint; out, for each of them the hole that it lies in, if any.
//!
//! To the left of a polygon's uppermost point lies the edge of another one with white on its right, or none. That white is a hole, or
//! what the other polygon lies in itself. Edges are kept by the squares of a grid, of which few are looked through.

use crate::base::signed_area;
use crate::offset::Polygon;

/// A ring that is no exterior: its polygon, and its number in there, from 1 on.
pub(super) type Hole = (u32, u32);

/// The hole that each polygon lies in; `None` for those that lie in no other.
pub(super) fn containers(polygons: &[Polygon]) -> Vec<Option<Hole>> {
    let grid = Grid::of(polygons);
    let top = |polygon: &Polygon| {
        let points = polygon.first().into_iter().flatten().copied();
        points.min_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])))
    };
    let tops: Vec<Option<[f64; 2]>> = polygons.iter().map(top).collect();
    // What a polygon lies in begins above it.
    let mut order: Vec<usize> = (0..polygons.len()).collect();
    let key = |polygon: usize| tops[polygon].unwrap_or_default();
    order.sort_by(|a, b| key(*a)[1].total_cmp(&key(*b)[1]).then(key(*a)[0].total_cmp(&key(*b)[0])).then(a.cmp(b)));
    let mut containers: Vec<Option<Hole>> = vec![None; polygons.len()];
    for polygon in order {
        let beside = tops[polygon].and_then(|top| grid.left_of(top, polygon as u32));
        containers[polygon] =
            beside.and_then(|(other, ring)| if ring == 0 { containers[other as usize] } else { Some((other, ring)) });
    }
    containers
}

/// The area of the white in every hole: for each polygon, of its rings from 1 on.
pub(super) fn white_areas(polygons: &[Polygon], containers: &[Option<Hole>]) -> Vec<Vec<f64>> {
    let of_polygon = |polygon: &Polygon| polygon.iter().skip(1).map(|ring| signed_area(ring).abs()).collect();
    let mut areas: Vec<Vec<f64>> = polygons.iter().map(of_polygon).collect();
    for (polygon, container) in polygons.iter().zip(containers) {
        if let (Some((around, ring)), Some(exterior)) = (container, polygon.first()) {
            areas[*around as usize][*ring as usize - 1] -= signed_area(exterior).abs();
        }
    }
    areas
}

/// Edges that fall, which have white on their right, by the squares that they come through.
struct Grid<'a> {
    polygons: &'a [Polygon],
    origin: [f64; 2],
    side: f64,
    columns: usize,
    rows: usize,
    /// Where the edges of every square begin in `edges`; one entry more than there are squares.
    starts: Vec<u32>,
    /// Polygon, ring and first point of every edge.
    edges: Vec<[u32; 3]>,
}

/// Edges that a square has on average, roughly.
const EDGES_A_SQUARE: f64 = 4.0;

/// Squares that an edge comes through on average, at most: so memory is linear, however long edges are.
const SQUARES_AN_EDGE: f64 = 4.0;

impl<'a> Grid<'a> {
    fn of(polygons: &'a [Polygon]) -> Self {
        let points = || polygons.iter().flatten().flatten();
        let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in points() {
            low = [0, 1].map(|axis| low[axis].min(point[axis]));
            high = [0, 1].map(|axis| high[axis].max(point[axis]));
        }
        let count = points().count().max(1) as f64;
        let rings = polygons.iter().flatten();
        let extent = |ring: &'a Vec<[f64; 2]>| {
            let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
            pairs.map(|(a, b)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs()).sum::<f64>()
        };
        let extents: f64 = rings.map(extent).sum();
        let [width, height] = [0, 1].map(|axis| (high[axis] - low[axis]).max(0.0));
        let squares = (count / EDGES_A_SQUARE).max(1.0);
        let side = (width * height / squares).sqrt().max(width.max(height) / squares).max(extents / (SQUARES_AN_EDGE * count));
        let side = if side > 0.0 { side } else { 1.0 };
        let [columns, rows] = [width, height].map(|length| (length / side) as usize + 1);
        let mut grid = Self { polygons, origin: low, side, columns, rows, starts: vec![0; columns * rows + 1], edges: Vec::new() };
        let mut starts = std::mem::take(&mut grid.starts);
        grid.for_each_edge(|_, square| starts[square + 1] += 1);
        for square in 1..starts.len() {
            starts[square] += starts[square - 1];
        }
        let (mut next, mut edges) = (starts.clone(), vec![[0; 3]; starts[starts.len() - 1] as usize]);
        grid.for_each_edge(|edge, square| {
            edges[next[square] as usize] = edge;
            next[square] += 1;
        });
        (grid.starts, grid.edges) = (starts, edges);
        grid
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.origin[0]) / self.side) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.origin[1]) / self.side) as usize).min(self.rows - 1)
    }

    /// Both ends of an edge.
    fn ends(&self, [polygon, ring, first]: [u32; 3]) -> [[f64; 2]; 2] {
        let points = &self.polygons[polygon as usize][ring as usize];
        [points[first as usize], points[(first as usize + 1) % points.len()]]
    }

    /// Visits every edge that falls, once for each of its squares.
    fn for_each_edge(&self, mut visit: impl FnMut([u32; 3], usize)) {
        for (polygon, rings) in (0u32..).zip(self.polygons) {
            for (ring, points) in (0u32..).zip(rings) {
                for edge in (0..points.len() as u32).map(|first| [polygon, ring, first]) {
                    let [a, b] = self.ends(edge);
                    if a[1] >= b[1] {
                        continue;
                    }
                    for row in self.row(a[1])..=self.row(b[1]) {
                        // Where it is in this row, and a little on both sides for what rounding does.
                        let [above, below] =
                            [row as f64 - 1e-6, row as f64 + 1.0 + 1e-6].map(|row| self.origin[1] + row * self.side);
                        let [x, z] = [above, below].map(|y| x_at([a, b], y.clamp(a[1], b[1])));
                        let spare = 1e-6 * self.side;
                        for column in self.column(x.min(z) - spare)..=self.column(x.max(z) + spare) {
                            visit(edge, row * self.columns + column);
                        }
                    }
                }
            }
        }
    }

    /// The polygon and ring of the nearest falling edge on the left of a point, not of the polygon given.
    fn left_of(&self, [x, y]: [f64; 2], own: u32) -> Option<(u32, u32)> {
        let row = self.row(y);
        let mut nearest: Option<(f64, (u32, u32))> = None;
        for column in (0..=self.column(x)).rev() {
            let square = row * self.columns + column;
            for edge in &self.edges[self.starts[square] as usize..self.starts[square + 1] as usize] {
                let [a, b] = self.ends(*edge);
                let [polygon, ring, _] = *edge;
                if polygon == own || y < a[1] || y >= b[1] {
                    continue;
                }
                let at = x_at([a, b], y);
                if at <= x && nearest.is_none_or(|(known, _)| at > known) {
                    nearest = Some((at, (polygon, ring)));
                }
            }
            // What lies in squares further left is further away.
            if nearest.is_some_and(|(at, _)| self.column(at) >= column) {
                break;
            }
        }
        nearest.map(|(_, ring)| ring)
    }
}

/// Where an edge that is not level is at a height.
fn x_at([a, b]: [[f64; 2]; 2], y: f64) -> f64 {
    a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(left: f64, top: f64, side: f64) -> Vec<[f64; 2]> {
        vec![[left, top], [left + side, top], [left + side, top + side], [left, top + side]]
    }

    fn hole(left: f64, top: f64, side: f64) -> Vec<[f64; 2]> {
        square(left, top, side).into_iter().rev().collect()
    }

    #[test]
    fn polygons_lie_in_the_holes_around_them() {
        let polygons = vec![
            vec![square(40.0, 40.0, 5.0), hole(41.0, 41.0, 3.0)],
            vec![square(0.0, 0.0, 100.0), hole(10.0, 10.0, 20.0), hole(35.0, 35.0, 50.0)],
            vec![square(42.0, 42.0, 1.0)],
            // Beside another one in the same hole, and beside all.
            vec![square(50.0, 41.0, 5.0)],
            vec![square(120.0, 50.0, 5.0)],
            // It touches the edge of its hole.
            vec![vec![[35.0, 60.0], [40.0, 58.0], [40.0, 62.0]]],
        ];
        let found = containers(&polygons);
        assert_eq!(found, [Some((1, 2)), None, Some((0, 1)), Some((1, 2)), None, Some((1, 2))]);
        let areas = white_areas(&polygons, &found);
        assert_eq!(areas[1], [400.0, 2500.0 - 25.0 - 25.0 - 10.0]);
        assert_eq!(areas[0], [8.0]);
    }

    #[test]
    fn a_grid_of_rings_in_rings_is_told_apart() {
        // Rings of several depths, of which the middle is moved from place to place.
        let mut polygons = Vec::new();
        for k in 0..400 {
            let (x, y) = (20.0 * f64::from(k % 20), 20.0 * f64::from(k / 20));
            for depth in 0..3 {
                let inset = 3.0 * f64::from(depth) + 0.01 * f64::from(k % 7);
                polygons.push(vec![
                    square(x + inset, y + inset, 18.0 - 2.0 * inset),
                    hole(x + inset + 1.0, y + inset + 1.0, 16.0 - 2.0 * inset),
                ]);
            }
        }
        let found = containers(&polygons);
        for (k, container) in found.iter().enumerate() {
            assert_eq!(*container, (k % 3 > 0).then(|| (k as u32 - 1, 1)), "{k}");
        }
    }
}
