//! Lines along the middle of what is narrow: chords of a triangulation of a polygon, joined from triangle to triangle.
//!
//! A polygon is triangulated between its own points alone, so every edge of a triangle that is no side of the polygon is a chord from
//! one side of it to the other, and where the polygon is narrow its chords run across it: their middles are the line (the chordal axis
//! transform, Prasad 1997). A chord that only cuts a corner off is told by how long the way along the boundary is that it cuts off.

use kurbo::{Point, Vec2};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::base::{Error, Result};
use crate::offset::{Polygon, simplified, simplified_line};
use crate::plot::path::Path;

/// The way along the boundary that a chord must cut off, in its own lengths. A half circle's end has 1.6, a right corner 1.4; of a
/// corner of 60 degrees or less, which has 2 and more, the middle is drawn towards the tip. It also cuts off as much as a line of the
/// greatest width that is asked for reaches beyond its end.
const LEAST_CUT: f64 = 2.0;

/// Points of a boundary lie no further apart than this part of the widths that are asked for, so that chords run across.
const STEPS_A_WIDTH: f64 = 0.5;

/// How far a line may lie from the middles of the chords, as a part of the width.
const SMOOTHED: f64 = 0.04;

/// A point of a boundary.
struct Vertex {
    at: Point,
    ring: u32,
    /// Its place among the points of its ring.
    number: u32,
    /// How far along its ring it lies.
    along: f64,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.at.x, self.at.y)
    }
}

type Chords = ConstrainedDelaunayTriangulation<Vertex>;

/// The lines along the middle of a polygon where it is wider than `above` and narrower than `below` mm; of one point where it is so in one
/// place.
///
/// # Errors
/// [`Error::Internal`] if the polygon cannot be triangulated.
///
/// # Runtime
/// n log n in the number of points, and of those that long sides are divided by.
pub(super) fn middles(polygon: &Polygon, above: f64, below: f64) -> Result<Vec<Path>> {
    let Divided { vertices, sides, rings } = Divided::of(polygon, below * STEPS_A_WIDTH);
    if vertices.len() < 3 {
        return Ok(Vec::new());
    }
    // Sides that cross others by rounding are left out: what is lost is a chord.
    let chords = Chords::try_bulk_load_cdt(vertices, sides, |_| ())
        .map_err(|error| Error::Internal(format!("an area cannot be triangulated: {error}")))?;
    let is_inside = inside(&chords, &rings);
    let heights = heights(&chords);
    // By the number of the edge: the middle of the chord, if it is one that is wanted.
    let mut middles: Vec<Option<Point>> = vec![None; chords.num_undirected_edges()];
    for edge in chords.undirected_edges().filter(|edge| !edge.is_constraint_edge()) {
        let face = edge.as_directed().face();
        if face.is_outer() || !is_inside[face.fix().index()] {
            continue;
        }
        let [a, b] = &edge.vertices();
        let (a, b) = (a.data(), b.data());
        let across = [edge.as_directed(), edge.as_directed().rev()].map(|edge| heights[edge.face().fix().index()]);
        let length = (b.at - a.at).hypot2().sqrt();
        let width = length.min(across[0]).min(across[1]);
        let cut = if a.ring == b.ring {
            let one = (a.along - b.along).abs();
            one.min(rings[a.ring as usize].length - one)
        } else {
            f64::INFINITY
        };
        if width > above && width < below && cut >= below.max(LEAST_CUT * length) {
            middles[edge.fix().index()] = Some(a.at.midpoint(b.at));
        }
    }
    let lines = Axis::of(&chords, &is_inside, middles).lines();
    Ok(lines.into_iter().map(|line| smoothed(line, SMOOTHED * below)).collect())
}

/// A ring of a boundary: how many points it has, and how long it is.
struct Ring {
    count: u32,
    length: f64,
}

/// The boundary of a polygon with points no further apart than a step.
struct Divided {
    vertices: Vec<Vertex>,
    sides: Vec<[usize; 2]>,
    rings: Vec<Ring>,
}

impl Divided {
    fn of(polygon: &Polygon, step: f64) -> Self {
        let mut divided = Self { vertices: Vec::new(), sides: Vec::new(), rings: Vec::new() };
        for ring in polygon {
            let first = divided.vertices.len();
            let (mut number, mut along) = (0, 0.0);
            for (k, point) in ring.iter().enumerate() {
                let next = ring[(k + 1) % ring.len()];
                let (from, to) = (Point::new(point[0], point[1]), Point::new(next[0], next[1]));
                let length = (to - from).hypot2().sqrt();
                let parts = libm::ceil(length / step).max(1.0);
                for part in 0..parts as usize {
                    let share = part as f64 / parts;
                    divided.vertices.push(Vertex {
                        at: from.lerp(to, share),
                        ring: divided.rings.len() as u32,
                        number,
                        along: along + share * length,
                    });
                    number += 1;
                }
                along += length;
            }
            let end = divided.vertices.len();
            divided.sides.extend((first..end).map(|k| [k, if k + 1 == end { first } else { k + 1 }]));
            divided.rings.push(Ring { count: number, length: along });
        }
        divided
    }
}

/// How wide the polygon is at each triangle that has one side of it: from there to the opposite corner. Chords run across aslant.
fn heights(chords: &Chords) -> Vec<f64> {
    let mut heights = vec![f64::INFINITY; chords.num_all_faces()];
    for face in chords.inner_faces() {
        let mut sides = face.adjacent_edges().into_iter().filter(|edge| edge.is_constraint_edge());
        if let (Some(side), None) = (sides.next(), sides.next()) {
            heights[face.fix().index()] = 2.0 * face.area() / side.length_2().sqrt();
        }
    }
    heights
}

/// Whether each face lies in the polygon: to the left of its sides, and wherever one comes from there without crossing a side.
fn inside(chords: &Chords, rings: &[Ring]) -> Vec<bool> {
    let mut found: Vec<Option<bool>> = vec![None; chords.num_all_faces()];
    let mut waiting = Vec::new();
    for edge in chords.undirected_edges().filter(|edge| edge.is_constraint_edge()) {
        let edge = edge.as_directed();
        let [a, b] = &edge.vertices();
        let (a, b) = (a.data(), b.data());
        if a.ring != b.ring {
            continue;
        }
        let count = rings[a.ring as usize].count;
        let runs_along = b.number == (a.number + 1) % count;
        if !runs_along && a.number != (b.number + 1) % count {
            continue;
        }
        for (face, is_left) in [(edge.face(), true), (edge.rev().face(), false)] {
            let place = &mut found[face.fix().index()];
            if !face.is_outer() && place.is_none() {
                *place = Some(is_left == runs_along);
                waiting.push(face.fix());
            }
        }
    }
    while let Some(face) = waiting.pop() {
        let is_inside = found[face.index()];
        let Some(face) = chords.face(face).as_inner() else { continue };
        for edge in face.adjacent_edges() {
            let beyond = edge.rev().face();
            if edge.is_constraint_edge() || beyond.is_outer() || found[beyond.fix().index()].is_some() {
                continue;
            }
            found[beyond.fix().index()] = is_inside;
            waiting.push(beyond.fix());
        }
    }
    found.into_iter().map(|is_inside| is_inside.unwrap_or(false)).collect()
}

/// The middles of chords, and of the triangles that have three of them, as a graph.
struct Axis {
    places: Vec<Point>,
    /// Numbers of the places that each one leads to, at most three.
    ways: Vec<Vec<u32>>,
}

impl Axis {
    fn of(chords: &Chords, is_inside: &[bool], middles: Vec<Option<Point>>) -> Self {
        let mut places = Vec::new();
        let numbers: Vec<Option<u32>> = middles
            .into_iter()
            .map(|middle| {
                places.push(middle?);
                Some(places.len() as u32 - 1)
            })
            .collect();
        let mut axis = Self { ways: vec![Vec::new(); places.len()], places };
        for face in chords.inner_faces().filter(|face| is_inside[face.fix().index()]) {
            let around: Vec<u32> =
                face.adjacent_edges().iter().filter_map(|edge| numbers[edge.as_undirected().fix().index()]).collect();
            match around[..] {
                [a, b] => axis.join(a, b),
                [a, b, c] => {
                    let sum: Vec2 = [a, b, c].iter().map(|place| axis.places[*place as usize].to_vec2()).sum();
                    axis.places.push((sum / 3.0).to_point());
                    axis.ways.push(Vec::new());
                    let middle = axis.places.len() as u32 - 1;
                    [a, b, c].into_iter().for_each(|place| axis.join(place, middle));
                }
                _ => {}
            }
        }
        axis
    }

    fn join(&mut self, a: u32, b: u32) {
        self.ways[a as usize].push(b);
        self.ways[b as usize].push(a);
    }

    /// Its lines from end to end and from branching to branching, and its rings.
    fn lines(mut self) -> Vec<Path> {
        let mut lines = Vec::new();
        let count = self.places.len() as u32;
        let mut is_done = vec![false; count as usize];
        for place in 0..count {
            if self.ways[place as usize].is_empty() && !is_done[place as usize] {
                is_done[place as usize] = true;
                lines.push(Path { points: vec![self.at(place)], is_closed: false });
            }
        }
        // What is left after all lines are rings.
        for wants_ends in [true, false] {
            for place in 0..count {
                loop {
                    let ways = &self.ways[place as usize];
                    if ways.is_empty() || (wants_ends && ways.len() == 2 && !is_done[place as usize]) {
                        break;
                    }
                    // One way may be left of a branching, which had two when the others were gone.
                    is_done[place as usize] = true;
                    let points = self.follow(place, &mut is_done);
                    lines.push(points);
                }
            }
        }
        lines
    }

    fn at(&self, place: u32) -> [f64; 2] {
        let place = self.places[place as usize];
        [place.x, place.y]
    }

    /// The line from a place until it ends, branches, or is there again; its ways are taken away.
    fn follow(&mut self, from: u32, is_done: &mut [bool]) -> Path {
        let (mut points, mut here) = (vec![self.at(from)], from);
        while let Some(next) = self.ways[here as usize].pop() {
            let back = &mut self.ways[next as usize];
            if let Some(place) = back.iter().position(|way| *way == here) {
                back.swap_remove(place);
            }
            if next == from {
                return Path { points, is_closed: true };
            }
            points.push(self.at(next));
            let is_branching = self.ways[next as usize].len() != 1 || is_done[next as usize];
            is_done[next as usize] = true;
            here = next;
            if is_branching {
                break;
            }
        }
        Path { points, is_closed: false }
    }
}

/// A line evened out, as chords run aslant to one side and to the other, and without the points that lie within `tolerance` of what is
/// left.
fn smoothed(line: Path, tolerance: f64) -> Path {
    let count = line.points.len();
    if count < 3 {
        return line;
    }
    let is_end = |k: usize| !line.is_closed && (k == 0 || k + 1 == count);
    let at = |k: usize| line.points[k % count];
    let evened = |k: usize| {
        let ([a, b, c], share) = ([at(k + count - 1), at(k), at(k + 1)], [0.25, 0.5, 0.25]);
        [0, 1].map(|axis| share[0] * a[axis] + share[1] * b[axis] + share[2] * c[axis])
    };
    let even: Vec<[f64; 2]> = (0..count).map(|k| if is_end(k) { at(k) } else { evened(k) }).collect();
    let points = if line.is_closed { simplified(&even, tolerance) } else { simplified_line(&even, tolerance) };
    if points.is_empty() { line } else { Path { points, ..line } }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.to_vec()
    }

    fn length(path: &Path) -> f64 {
        path.points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
    }

    #[test]
    fn a_strip_has_one_line_along_its_middle() {
        let strip = vec![ring(&[[0.0, 0.0], [10.0, 0.0], [10.0, 0.2], [0.0, 0.2]])];
        let lines = middles(&strip, 0.0, 0.3).unwrap();
        assert_eq!(lines.len(), 1);
        assert!(lines[0].points.iter().all(|p| (p[1] - 0.1).abs() < 0.02), "{lines:?}");
        assert!((9.4..10.0).contains(&length(&lines[0])), "{}", length(&lines[0]));
        assert!(middles(&strip, 0.0, 0.15).unwrap().is_empty());
        assert!(middles(&strip, 0.3, 0.6).unwrap().is_empty());
    }

    #[test]
    fn a_ring_has_a_ring_and_a_cross_branches() {
        let circle = |radius: f64, turn: f64| -> Vec<[f64; 2]> {
            (0..60)
                .map(|k| turn * f64::from(k) * std::f64::consts::TAU / 60.0)
                .map(|a| [radius * a.cos(), radius * a.sin()])
                .collect()
        };
        let lines = middles(&vec![circle(5.0, 1.0), circle(4.8, -1.0)], 0.0, 0.3).unwrap();
        assert_eq!((lines.len(), lines[0].is_closed), (1, true));
        assert!(lines[0].points.iter().all(|p| (p[0].hypot(p[1]) - 4.9).abs() < 0.03));
        let (a, b) = (0.1, 5.0);
        let cross =
            ring(&[[-a, -b], [a, -b], [a, -a], [b, -a], [b, a], [a, a], [a, b], [-a, b], [-a, a], [-b, a], [-b, -a], [-a, -a]]);
        let lines = middles(&vec![cross], 0.0, 0.3).unwrap();
        let all: f64 = lines.iter().map(length).sum();
        assert!((18.5..20.5).contains(&all), "{all}: {lines:?}");
    }

    #[test]
    fn only_the_neck_of_an_hourglass_is_narrow() {
        let glass = ring(&[[0.0, 0.0], [4.0, 0.0], [2.1, 2.0], [2.1, 3.0], [4.0, 5.0], [0.0, 5.0], [1.9, 3.0], [1.9, 2.0]]);
        let lines = middles(&vec![glass], 0.0, 0.4).unwrap();
        let necks: Vec<&Path> = lines.iter().filter(|line| line.points.iter().any(|p| (p[0] - 2.0).abs() < 1.0)).collect();
        assert_eq!(necks.len(), 1, "{lines:?}");
        assert!(necks[0].points.iter().all(|p| (p[0] - 2.0).abs() < 0.08 && (1.7..3.3).contains(&p[1])), "{lines:?}");
        // In the corners of 45 degrees a line runs towards the tip.
        assert_eq!(lines.len(), 5, "{lines:?}");
    }

    #[test]
    fn blunt_corners_have_no_line_and_sharp_ones_have() {
        let square = vec![ring(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])];
        assert!(middles(&square, 0.0, 0.3).unwrap().is_empty());
        let needle = vec![ring(&[[8.0, 0.5], [0.0, 1.0], [0.0, 0.0]])];
        let lines = middles(&needle, 0.0, 0.3).unwrap();
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!((1.8..2.4).contains(&length(&lines[0])), "{}", length(&lines[0]));
    }
}
