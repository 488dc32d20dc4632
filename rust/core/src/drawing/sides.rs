//! What lies beside curves and dots, found again from where they are.
//!
//! Next to a curve lies what its nearest neighbour to the left has on its right.

use kurbo::{BezPath, Point, Shape};

use crate::base::{Error, FLATTENING_TOLERANCE, Frame, Ink, Result, flatten_path, flattened_edges, is_closed};
use crate::drawing::assembly::{End, assemble, ends_on_frame};
use crate::drawing::data::Drawing;
use crate::outlines::{Parts, Stipple};

/// What is said of curves and dots that do not fit together: only a file can hold such.
pub(crate) fn invalid(what: impl std::fmt::Display) -> Error {
    Error::Input(format!("this is not a drawing that graphstipple wrote: {what}"))
}

/// The drawing of curves, black on their left, and dots; its provenance is left empty. `ground` is the ink of a canvas with nothing
/// on it.
///
/// # Errors
/// [`Error::Input`] if they do not fit together.
pub(crate) fn put_together(
    width: usize,
    height: usize,
    units: f64,
    curves: Vec<BezPath>,
    stipples: Vec<Stipple>,
    ground: Ink,
) -> Result<Drawing> {
    let frame = Frame { width: width as f64, height: height as f64 };
    let mut sides = Sides::new(frame, &curves, stipples.first().map_or(ground, |dot| dot.ink.other()));
    for (number, curve) in curves.iter().enumerate().filter(|(_, curve)| is_closed(curve)) {
        let outer = if curve.area() > 0.0 { white_side(number) } else { black_side(number) };
        let left = leftmost(curve);
        let beside = sides.at_left_of(left, Some(number));
        sides.join(outer, beside)?;
    }
    let around: Vec<usize> = stipples.iter().map(|dot| sides.at_left_of(Point::new(dot.x - dot.radius, dot.y), None)).collect();

    let (mut inks, ids) = sides.components();
    let beside = |number: usize| [ids[black_side(number)], ids[white_side(number)]];
    let mut parts = Parts { width, height, units, on_frame: ids[sides.ground], ..Parts::default() };
    for (dot, around) in stipples.into_iter().zip(around) {
        if dot.ink == inks[ids[around] as usize] {
            return Err(invalid(format!("a {} stipple lies in {}", dot.ink.name(), dot.ink.name())));
        }
        parts.stipples.push((dot, [inks.len() as u32, ids[around]]));
        inks.push(dot.ink);
    }
    parts.curves = curves.into_iter().enumerate().map(|(number, curve)| (curve, beside(number))).collect();
    parts.inks = inks;
    assemble(parts).map_err(|error| invalid(format!("its shapes do not fit together ({error})")))
}

fn leftmost(curve: &BezPath) -> Point {
    let points = flatten_path(curve, FLATTENING_TOLERANCE);
    let least = points.into_iter().min_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    least.map_or(Point::ZERO, |[x, y]| Point::new(x, y))
}

fn black_side(curve: usize) -> usize {
    2 * curve
}

fn white_side(curve: usize) -> usize {
    2 * curve + 1
}

/// A piece of a flattened curve.
#[derive(Clone, Copy)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    curve: usize,
}

impl Edge {
    /// Where the edge, which is not level, is at a height.
    fn x_at(&self, y: f64) -> f64 {
        self.from[0] + (y - self.from[1]) * (self.to[0] - self.from[0]) / (self.to[1] - self.from[1])
    }

    /// Whether the edge lies to the right of another at the heights that both span. They may meet at one end of these heights but
    /// do not cross, so their middle decides.
    fn is_right_of(&self, other: Self) -> bool {
        let top = self.from[1].min(self.to[1]).max(other.from[1].min(other.to[1]));
        let bottom = self.from[1].max(self.to[1]).min(other.from[1].max(other.to[1]));
        let y = 0.5 * (top + bottom);
        self.x_at(y) > other.x_at(y)
    }
}

/// Both sides of every curve, joined where nothing lies between them.
struct Sides {
    /// A forest: every side points to one of its component.
    joined: Vec<usize>,
    inks: Vec<Ink>,
    /// What stands for the canvas where no curve ends on the frame.
    ground: usize,
    ends: Vec<End>,
    /// The edges that meet a row of pixels, row by row.
    rows: Vec<Vec<Edge>>,
    frame: Frame,
}

impl Sides {
    fn new(frame: Frame, curves: &[BezPath], ground: Ink) -> Self {
        let ground_side = 2 * curves.len();
        let mut inks: Vec<Ink> = (0..ground_side).map(|side| if side % 2 == 0 { Ink::Black } else { Ink::White }).collect();
        inks.push(ground);
        let ends = ends_on_frame(frame, curves);
        let mut rows: Vec<Vec<Edge>> = (0..frame.height as usize).map(|_| Vec::new()).collect();
        let last_row = rows.len() - 1;
        let row = |y: f64| (y.max(0.0) as usize).min(last_row);
        for (curve, path) in curves.iter().enumerate() {
            for [from, to] in flattened_edges(path) {
                for row in &mut rows[row(from[1].min(to[1]))..=row(from[1].max(to[1]))] {
                    row.push(Edge { from, to, curve });
                }
            }
        }
        let mut sides = Self { joined: (0..inks.len()).collect(), inks, ground: ground_side, ends, rows, frame };
        for k in 0..sides.ends.len() {
            let next = (k + 1) % sides.ends.len();
            let ([_, after], [before, _]) = (sides.around(k), sides.around(next));
            let (a, b) = (sides.root(after), sides.root(before));
            sides.joined[a] = b;
        }
        sides
    }

    /// The sides on the frame just before and just after an end, in the positive direction.
    fn around(&self, k: usize) -> [usize; 2] {
        let curve = self.ends[k].curve as usize;
        self.ends[k].around([black_side(curve), white_side(curve)])
    }

    fn root(&mut self, mut side: usize) -> usize {
        while self.joined[side] != side {
            self.joined[side] = self.joined[self.joined[side]];
            side = self.joined[side];
        }
        side
    }

    fn join(&mut self, a: usize, b: usize) -> Result<()> {
        let (a, b) = (self.root(a), self.root(b));
        // A ground that nothing touches has the ink of what is found there.
        if a == self.ground {
            self.inks[a] = self.inks[b];
        }
        if b == self.ground {
            self.inks[b] = self.inks[a];
        }
        if self.inks[a] != self.inks[b] {
            return Err(invalid("two curves have different inks between them"));
        }
        self.joined[a.max(b)] = a.min(b);
        if a.max(b) == self.ground {
            self.ground = a.min(b);
        }
        Ok(())
    }

    /// The side that lies at a point, seen to the left of it; edges of the curve `own` are looked through.
    fn at_left_of(&mut self, p: Point, own: Option<usize>) -> usize {
        let row = (p.y.max(0.0) as usize).min(self.rows.len() - 1);
        let mut nearest: Option<Edge> = None;
        for edge in self.rows[row].iter().filter(|edge| Some(edge.curve) != own) {
            let spans = (edge.from[1] <= p.y) != (edge.to[1] <= p.y);
            if spans && edge.x_at(p.y) < p.x && nearest.is_none_or(|best| edge.is_right_of(best)) {
                nearest = Some(*edge);
            }
        }
        if let Some(edge) = nearest {
            // A curve that goes up has its left, the black side, on the right.
            return if edge.to[1] < edge.from[1] { black_side(edge.curve) } else { white_side(edge.curve) };
        }
        if self.ends.is_empty() {
            return self.ground;
        }
        let position = self.frame.position(Point::new(0.0, p.y));
        // Just below, since an edge spans its top and not its bottom: the frame runs upwards here.
        let behind = self.ends.partition_point(|end| end.position < position);
        self.around((behind + self.ends.len() - 1) % self.ends.len())[1]
    }

    /// The ink of every component, and the component of every side.
    fn components(&mut self) -> (Vec<Ink>, Vec<u32>) {
        let mut inks = Vec::new();
        let mut ids = vec![u32::MAX; self.joined.len()];
        // The stand-in for the canvas counts only where it is needed.
        let count = if self.ends.is_empty() { self.joined.len() } else { self.joined.len() - 1 };
        for side in 0..count {
            let root = self.root(side);
            if ids[root] == u32::MAX {
                ids[root] = inks.len() as u32;
                inks.push(self.inks[root]);
            }
            ids[side] = ids[root];
        }
        (inks, ids)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_edges_that_meet_the_middle_of_their_common_heights_decides() {
        let edge = |from, to| Edge { from, to, curve: 0 };
        // Both end in (1, 1), just below the height that is asked for: there they cannot be told apart.
        let (left, right) = (edge([0.0, 0.0], [1.0, 1.0]), edge([1.0, 1.0], [2.0, 0.0]));
        assert!(right.is_right_of(left) && !left.is_right_of(right));
        // Both begin there.
        let (left, right) = (edge([1.0, 1.0], [0.0, 2.0]), edge([9.0, 2.0], [1.0, 1.0]));
        assert!(right.is_right_of(left) && !left.is_right_of(right));
    }
}
