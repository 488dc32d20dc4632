//! Places: where nodes are drawn once dots have moved, without a triangle turned over.
//!
//! Outlines need no more of a triangulation than that its triangles are the right way round (see [`crate::outlines`]); that it is
//! Delaunay they do not ask. So dots may leave their sites, and the nodes around give way, as long as every move keeps all triangles of
//! the node. Along the frame, nodes keep their order.
//!
//! Nodes move one after the other, in bands of consecutive numbers: even bands side by side, then odd ones. So the places do not depend on
//! threads.

use rayon::prelude::*;

use crate::base::{Frame, Side, distance_to_segment};
use crate::graph::{Beside, Triangulation};

type Point = [f64; 2];

/// Twice the area that every triangle keeps, as a share of the cell of the node that moves: on a lattice it is 1.
const LEAST_TRIANGLE: f64 = 0.1;

/// The part of the way between two neighbours at the frame that they keep between them along it.
const LEAST_WAY: f64 = 0.1;

/// Nodes of a band at least, and rows of one on a square canvas.
const LEAST_BAND: usize = 1024;
const ROWS_IN_BAND: usize = 16;

/// Where the nodes of a triangulation are drawn.
pub(crate) struct Places<'a> {
    fixed: Fixed<'a>,
    pub(crate) places: Vec<Point>,
}

/// What does not move.
struct Fixed<'a> {
    triangulation: &'a Triangulation,
    areas: &'a [f64],
    frame: Frame,
    /// The node at either end of an edge with the frame beside it.
    at_frame: Vec<bool>,
    /// Nodes of a band.
    size: usize,
}

impl<'a> Places<'a> {
    /// At first every node is at its site.
    pub(super) fn new(triangulation: &'a Triangulation, areas: &'a [f64], frame: Frame) -> Self {
        Self::at(triangulation.graph.sites.clone(), triangulation, areas, frame)
    }

    /// Every node is at such a place, where moves have put it before.
    pub(crate) fn at(places: Vec<Point>, triangulation: &'a Triangulation, areas: &'a [f64], frame: Frame) -> Self {
        let graph = &triangulation.graph;
        let count = graph.sites.len();
        let mut at_frame = vec![false; count];
        for slot in triangulation.at_frame(0..graph.neighbors.len()) {
            at_frame[graph.neighbors[slot] as usize] = true;
            at_frame[graph.offsets.partition_point(|offset| *offset as usize <= slot) - 1] = true;
        }
        let size = LEAST_BAND.max(ROWS_IN_BAND * count.isqrt());
        Self { fixed: Fixed { triangulation, areas, frame, at_frame, size }, places }
    }

    /// Visits some nodes, in ascending order, but for those that have neighbours beyond the bands beside their own.
    pub(crate) fn visit(&mut self, nodes: &[u32], visit: impl Fn(&mut Band, usize) + Sync) {
        let fixed = &self.fixed;
        for parity in 0..2 {
            let mut own = Vec::new();
            let mut others: Vec<&[Point]> = Vec::new();
            for (number, places) in self.places.chunks_mut(fixed.size).enumerate() {
                if number % 2 == parity {
                    own.push((number, places));
                } else {
                    others.push(places);
                }
            }
            own.into_par_iter().for_each(|(number, places)| {
                let first = number * fixed.size;
                // Those beside it are, among the others, this one and the one before, or this one and the next.
                let after = number / 2 + parity;
                let before = after.checked_sub(1).and_then(|before| others.get(before)).copied().unwrap_or_default();
                let after = others.get(after).copied().unwrap_or_default();
                let [begin, end] =
                    [first, first + places.len()].map(|node| nodes.partition_point(|other| (*other as usize) < node));
                let mut band = Band { fixed, first, places, before, after };
                for node in nodes[begin..end].iter().map(|node| *node as usize) {
                    if band.reaches(node) {
                        visit(&mut band, node);
                    }
                }
            });
        }
    }

    /// How far the place of a node is from the rim of its star and from the frame.
    pub(super) fn room(&self, node: usize) -> f64 {
        self.fixed.room(node, self.places[node], |other| self.places[other])
    }
}

/// Places of consecutive nodes, which can move, and of those before and after, which stay meanwhile.
pub(crate) struct Band<'a> {
    fixed: &'a Fixed<'a>,
    first: usize,
    places: &'a mut [Point],
    before: &'a [Point],
    after: &'a [Point],
}

impl Band<'_> {
    /// The place of a node of this band or one beside it.
    pub(crate) fn place(&self, node: usize) -> Point {
        match node.checked_sub(self.first) {
            None => self.before[node + self.before.len() - self.first],
            Some(own) if own < self.places.len() => self.places[own],
            Some(own) => self.after[own - self.places.len()],
        }
    }

    /// Whether a node is of this band, and all its neighbours are of it or of those beside it.
    fn reaches(&self, node: usize) -> bool {
        let row = self.fixed.triangulation.graph.row(node);
        let is_own = |node: usize| (self.first..self.first + self.places.len()).contains(&node);
        let is_known = |node: &u32| {
            let node = *node as usize;
            node + self.before.len() >= self.first && node < self.first + self.places.len() + self.after.len()
        };
        // Rows are sorted.
        is_own(node) && row.first().is_none_or(is_known) && row.last().is_none_or(is_known)
    }

    pub(crate) fn is_at_frame(&self, node: usize) -> bool {
        self.fixed.at_frame[node]
    }

    /// Moves a node as much of the way to a point as its triangles allow and `suits` wants: all of it, half, or a quarter.
    pub(crate) fn move_towards(&mut self, node: usize, point: Point, suits: impl Fn(&Self, Point) -> bool) {
        if !self.reaches(node) {
            return;
        }
        let from = self.place(node);
        for part in [1.0, 0.5, 0.25] {
            let to = [from[0] + part * (point[0] - from[0]), from[1] + part * (point[1] - from[1])];
            let is_inside = self.fixed.frame.holds(kurbo::Point::new(to[0], to[1]));
            if is_inside && self.fixed.keeps_triangles(node, to, |other| self.place(other)) && suits(self, to) {
                self.places[node - self.first] = to;
                return;
            }
        }
    }

    /// How far a point in the star of a node is from the rim of it and from the frame.
    pub(super) fn room(&self, node: usize, point: Point) -> f64 {
        self.fixed.room(node, point, |other| self.place(other))
    }

    /// The sides of the star of a node, but for those on the frame.
    pub(super) fn rim(&self, node: usize) -> Vec<[usize; 2]> {
        self.fixed.rim(node).collect()
    }

    /// How a side of the star of a node must move to be as far from the node as needed; `None` if it is.
    pub(super) fn way_out(&self, node: usize, side: [usize; 2], needed: f64) -> Option<Point> {
        let [a, b] = side.map(|end| self.place(end));
        let missing = needed - to_segment(self.place(node), a, b);
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        let length = (x * x + y * y).sqrt();
        // The node lies to the left of the side.
        (missing > 0.0 && length > 0.0).then(|| [y * missing / length, -x * missing / length])
    }
}

impl<'a> Fixed<'a> {
    fn keeps_triangles(&self, node: usize, to: Point, place: impl Fn(usize) -> Point) -> bool {
        let least = LEAST_TRIANGLE * self.areas[node];
        // Nodes so dense that no sample fell to their cell stay.
        if least == 0.0 {
            return false;
        }
        let of_triangles = self.sides(node).all(|(a, beside)| match beside {
            Beside::Node(b) => turn(to, place(a), place(b as usize)) > least,
            Beside::Frame(side) => self.keeps_order(node, a, side, to, &place),
        });
        of_triangles
            && (!self.at_frame[node] || self.sides_before(node).all(|(a, side)| self.keeps_order(node, a, side, to, &place)))
    }

    /// Whether a node at `to` is on the same side of its neighbour as their sites are, along the frame.
    fn keeps_order(&self, node: usize, neighbor: usize, side: Side, to: Point, place: impl Fn(usize) -> Point) -> bool {
        let along = |[x, y]: Point| if matches!(side, Side::Top | Side::Bottom) { x } else { y };
        let sites = &self.triangulation.graph.sites;
        let way = along(sites[neighbor]) - along(sites[node]);
        (along(place(neighbor)) - along(to)) * way.signum() >= LEAST_WAY * way.abs()
    }

    fn room(&self, node: usize, point: Point, place: impl Fn(usize) -> Point) -> f64 {
        let [x, y] = point;
        let frame = x.min(self.frame.width - x).min(y).min(self.frame.height - y);
        self.rim(node).map(|[a, b]| to_segment(point, place(a), place(b))).fold(frame, f64::min)
    }

    /// Every neighbour of a node, with what lies to the left of the edge to it.
    fn sides(&self, node: usize) -> impl Iterator<Item = (usize, Beside)> + use<'a> {
        let triangulation = self.triangulation;
        let graph = &triangulation.graph;
        let slots = graph.offsets[node] as usize..graph.offsets[node + 1] as usize;
        slots.map(move |slot| (triangulation.graph.neighbors[slot] as usize, triangulation.left(slot)))
    }

    fn rim(&self, node: usize) -> impl Iterator<Item = [usize; 2]> + use<'a> {
        self.sides(node).filter_map(|(a, beside)| match beside {
            Beside::Node(b) => Some([a, b as usize]),
            Beside::Frame(_) => None,
        })
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
            places.visit(&[node as u32], |places, node| {
                // Half of them only so far that it does not come near a neighbour.
                let from = places.place(node);
                let near = [from[0] + 0.05 * (to[0] - from[0]), from[1] + 0.05 * (to[1] - from[1])];
                places.move_towards(node, if k % 2 == 0 { to } else { near }, |_, _| true);
            });
        }
        let moved = places.places.iter().zip(&before).filter(|(place, site)| place != site).count();
        assert!(moved > 150, "{moved}");
        let (mut thin, mut all) = (0, 0);
        for node in 0..300 {
            let [x, y] = places.places[node];
            assert!(x > 0.0 && x < frame.width && y > 0.0 && y < frame.height);
            for [a, b] in places.fixed.rim(node) {
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
        let mut places = Places::new(&triangulation, &areas, Frame { width: 20.0, height: 20.0 });
        let room = places.room(0);
        assert!((room - 8f64.sqrt()).abs() < 1e-12);
        places.visit(&[0], |places, node| {
            let side = places.rim(node)[0];
            assert!(places.way_out(node, side, room - 0.1).is_none());
            let [x, y] = places.way_out(node, side, room + 0.5).unwrap();
            assert!(((x * x + y * y).sqrt() - 0.5).abs() < 1e-9);
            let middle = [0, 1].map(|axis| (places.place(side[0])[axis] + places.place(side[1])[axis]) / 2.0 - 10.0);
            assert!(middle[0] * x + middle[1] * y > 0.0);
        });
    }

    #[test]
    fn every_node_is_visited_once_in_bands() {
        let random = |k: u64| 0.5 + 0.499 * f64::from(noise(k));
        let mut sites: Vec<Point> = (0..5000).map(|k| [random(2 * k) * 90.0, random(2 * k + 1) * 60.0]).collect();
        sites.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let triangulation = triangulate(sites.clone(), 90, 60, &Control::new()).unwrap();
        let areas = vec![0.1; 5000];
        let mut places = Places::new(&triangulation, &areas, Frame { width: 90.0, height: 60.0 });
        assert!(places.fixed.size < 2000);
        let all: Vec<u32> = (0..5000).collect();
        places.visit(&all, |places, node| {
            assert_eq!(places.place(node), sites[node]);
            let [x, y] = places.place(node);
            places.move_towards(node, [x + 1e-6, y], |_, _| true);
        });
        let moved = places.places.iter().zip(&sites).filter(|(place, site)| place != site).count();
        assert!(moved > 4900, "{moved}");
    }
}
