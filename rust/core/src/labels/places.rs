//! Places: where nodes are drawn once dots have moved, without a triangle turned over.
//!
//! Outlines need no more of a triangulation than that its triangles are the right way round (see [`crate::outlines`]); that it is
//! Delaunay they do not ask. So dots may leave their sites, and the nodes around give way, as long as every move keeps all triangles of
//! the node. Along the frame, nodes keep their order.

use crate::base::{Frame, Side, distance_to_segment};
use crate::graph::{Beside, Triangulation};

type Point = [f64; 2];

/// Twice the area that every triangle keeps, as a share of the cell of the node that moves: on a lattice it is 1.
const LEAST_TRIANGLE: f64 = 0.1;

/// The part of the way between two neighbours at the frame that they keep between them along it.
const LEAST_WAY: f64 = 0.1;

/// Where the nodes of a triangulation are drawn.
pub(super) struct Places<'a> {
    triangulation: &'a Triangulation,
    areas: &'a [f64],
    frame: Frame,
    /// The node at either end of an edge with the frame beside it.
    at_frame: Vec<bool>,
    pub(super) places: Vec<Point>,
}

impl<'a> Places<'a> {
    /// At first every node is at its site.
    pub(super) fn new(triangulation: &'a Triangulation, areas: &'a [f64], frame: Frame) -> Self {
        let graph = &triangulation.graph;
        let mut at_frame = vec![false; graph.sites.len()];
        for slot in triangulation.at_frame(0..graph.neighbors.len()) {
            at_frame[graph.neighbors[slot] as usize] = true;
            at_frame[graph.offsets.partition_point(|offset| *offset as usize <= slot) - 1] = true;
        }
        Self { triangulation, areas, frame, at_frame, places: graph.sites.clone() }
    }

    pub(super) fn is_at_frame(&self, node: usize) -> bool {
        self.at_frame[node]
    }

    /// Moves a node as much of the way to a point as its triangles allow and `suits` wants: all of it, half, or a quarter.
    pub(super) fn move_towards(&mut self, node: usize, point: Point, suits: impl Fn(&Self, Point) -> bool) {
        let from = self.places[node];
        for part in [1.0, 0.5, 0.25] {
            let to = [from[0] + part * (point[0] - from[0]), from[1] + part * (point[1] - from[1])];
            if self.frame.holds(kurbo::Point::new(to[0], to[1])) && self.keeps_triangles(node, to) && suits(self, to) {
                self.places[node] = to;
                return;
            }
        }
    }

    fn keeps_triangles(&self, node: usize, to: Point) -> bool {
        let least = LEAST_TRIANGLE * self.areas[node];
        let of_triangles = self.sides(node).all(|(a, beside)| match beside {
            Beside::Node(b) => turn(to, self.places[a], self.places[b as usize]) > least,
            Beside::Frame(side) => self.keeps_order(node, a, side, to),
        });
        of_triangles && (!self.at_frame[node] || self.sides_before(node).all(|(a, side)| self.keeps_order(node, a, side, to)))
    }

    /// Whether a node at `to` is on the same side of its neighbour as their sites are, along the frame.
    fn keeps_order(&self, node: usize, neighbor: usize, side: Side, to: Point) -> bool {
        let along = |[x, y]: Point| if matches!(side, Side::Top | Side::Bottom) { x } else { y };
        let sites = &self.triangulation.graph.sites;
        let way = along(sites[neighbor]) - along(sites[node]);
        (along(self.places[neighbor]) - along(to)) * way.signum() >= LEAST_WAY * way.abs()
    }

    /// How far a point in the star of a node is from the rim of it and from the frame.
    pub(super) fn room(&self, node: usize, point: Point) -> f64 {
        let [x, y] = point;
        let frame = x.min(self.frame.width - x).min(y).min(self.frame.height - y);
        let to_side = |(a, beside): (usize, Beside)| match beside {
            Beside::Node(b) => to_segment(point, self.places[a], self.places[b as usize]),
            Beside::Frame(_) => f64::INFINITY,
        };
        self.sides(node).map(to_side).fold(frame, f64::min)
    }

    /// The sides of the star of a node, but for those on the frame.
    pub(super) fn rim(&self, node: usize) -> impl Iterator<Item = [usize; 2]> {
        self.sides(node).filter_map(|(a, beside)| match beside {
            Beside::Node(b) => Some([a, b as usize]),
            Beside::Frame(_) => None,
        })
    }

    /// How a side of the star of a node must move to be as far from the node as needed; `None` if it is.
    pub(super) fn way_out(&self, node: usize, side: [usize; 2], needed: f64) -> Option<Point> {
        let [a, b] = side.map(|end| self.places[end]);
        let missing = needed - to_segment(self.places[node], a, b);
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        let length = (x * x + y * y).sqrt();
        // The node lies to the left of the side.
        (missing > 0.0 && length > 0.0).then(|| [y * missing / length, -x * missing / length])
    }

    /// Every neighbour of a node, with what lies to the left of the edge to it.
    fn sides(&self, node: usize) -> impl Iterator<Item = (usize, Beside)> {
        let graph = &self.triangulation.graph;
        let slots = graph.offsets[node] as usize..graph.offsets[node + 1] as usize;
        slots.map(|slot| (graph.neighbors[slot] as usize, self.triangulation.left(slot)))
    }

    /// The neighbours of a node from which the edge to it has the frame to its left.
    fn sides_before(&self, node: usize) -> impl Iterator<Item = (usize, Side)> {
        let row = self.triangulation.graph.row(node).iter();
        row.filter_map(move |other| match self.triangulation.left(self.triangulation.slot(*other, node as u32)?) {
            Beside::Frame(side) => Some((*other as usize, side)),
            Beside::Node(_) => None,
        })
    }
}

/// Twice the signed area of the triangle a, b, c.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    let point = |[x, y]: Point| kurbo::Point::new(x, y);
    distance_to_segment(point(p), point(a), point(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Control, noise};
    use crate::graph::triangulate;

    #[test]
    fn no_triangle_is_turned_over_however_nodes_are_pushed() {
        let random = |k: u64| 0.5 + 0.499 * f64::from(noise(k));
        let frame = Frame { width: 40.0, height: 30.0 };
        let sites = (0..300).map(|k| [random(2 * k) * frame.width, random(2 * k + 1) * frame.height]).collect();
        let triangulation = triangulate(sites, 40, 30, &Control::new()).unwrap();
        let areas = vec![1.0; 300];
        let mut places = Places::new(&triangulation, &areas, frame);
        let before = places.places.clone();
        for k in 0..3000 {
            let node = k as usize % 300;
            let to = [60.0 * random(9000 + 2 * k) - 10.0, 50.0 * random(9001 + 2 * k) - 10.0];
            // Half of them only so far that it does not come near a neighbour.
            let from = places.places[node];
            let near = [from[0] + 0.05 * (to[0] - from[0]), from[1] + 0.05 * (to[1] - from[1])];
            places.move_towards(node, if k % 2 == 0 { to } else { near }, |_, _| true);
        }
        let moved = places.places.iter().zip(&before).filter(|(place, site)| place != site).count();
        assert!(moved > 150, "{moved}");
        let (mut thin, mut all) = (0, 0);
        for node in 0..300 {
            let [x, y] = places.places[node];
            assert!(x > 0.0 && x < frame.width && y > 0.0 && y < frame.height);
            for [a, b] in places.rim(node) {
                let [area, of_sites] = [&places.places, &before].map(|at| turn(at[node], at[a], at[b]));
                // A triangle that began thin is only left as it is.
                assert!(area > 0.0);
                all += 1;
                thin += usize::from(area < 0.99 * LEAST_TRIANGLE && of_sites >= LEAST_TRIANGLE);
            }
        }
        assert!(thin == 0 && all > 1500, "{thin} of {all}");
    }

    #[test]
    fn a_side_moves_out_as_far_as_is_missing() {
        let sites = vec![[10.0, 10.0], [14.0, 10.0], [10.0, 14.0], [6.0, 10.0], [10.0, 6.0]];
        let triangulation = triangulate(sites, 20, 20, &Control::new()).unwrap();
        let areas = vec![1.0; 5];
        let places = Places::new(&triangulation, &areas, Frame { width: 20.0, height: 20.0 });
        let room = places.room(0, [10.0, 10.0]);
        assert!((room - 8f64.sqrt()).abs() < 1e-12);
        let side = places.rim(0).next().unwrap();
        assert!(places.way_out(0, side, room - 0.1).is_none());
        let [x, y] = places.way_out(0, side, room + 0.5).unwrap();
        assert!(((x * x + y * y).sqrt() - 0.5).abs() < 1e-9);
        let middle = [0, 1].map(|axis| (places.places[side[0]][axis] + places.places[side[1]][axis]) / 2.0 - 10.0);
        assert!(middle[0] * x + middle[1] * y > 0.0);
    }
}
