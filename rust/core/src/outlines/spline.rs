//! The spline of a contour, and the grid that its points lie on.
//!
//! # Coordinates
//! All points lie on a grid of a power of two to the pixel, so that files hold them exactly in few digits; where the grid is too
//! coarse for the triangles, on a finer one.

use kurbo::{BezPath, ParamCurve, ParamCurveArea, Point, QuadBez, Vec2};

use crate::base::{End, Frame, signed_area};
use crate::outlines::sleeve::{Sleeve, clear, crossing};

/// A closed loop below this area, in px^2, is rescaled to the area of its polygon of crossings: the spline shrinks such small
/// loops by 5 % and more, which would lighten or darken textures made of them. Larger loops lose less than a dot prints.
const RESCALED_LOOP_AREA: f64 = 20.0;

/// The same for a loop that encloses the cells of a component: the midpoints around a few nodes hold 10 to 20 % less than their
/// cells, and without that what is small and light in the dark would become darker, and the reverse.
const RESCALED_CELLS_AREA: f64 = 80.0;

/// Steps from the drawing's grid to finer ones, for points that the coarser grid would move out of their triangle.
pub(super) const FINER_GRIDS: [f64; 4] = [1.0, 16.0, 256.0, 131_072.0];

/// The grid of a drawing: units to a pixel, a power of two.
///
/// Control points take every other place. With a tolerance they are moved by no more than a third of it, and an eighth of a pixel
/// is enough for nodes a pixel apart. Without one they are a sixteenth of a pixel apart.
pub(super) fn units_per_pixel(tolerance: f64, nodes_per_pixel: f64) -> f64 {
    let least = if tolerance > 0.0 { (4.0 / tolerance).max(16.0) } else { 32.0 };
    let mut units = 8.0;
    while units < least || units * spacing(nodes_per_pixel) < 8.0 {
        units *= 2.0;
    }
    units
}

/// The distance between neighbours where so many nodes to a pixel lie evenly.
pub(super) fn spacing(nodes_per_pixel: f64) -> f64 {
    (1.15 / nodes_per_pixel).sqrt()
}

/// The points in which the pieces of a spline join, from begin to end.
pub(super) fn joints(controls: &[Point], frame: Frame, ends: Option<[End; 2]>) -> Vec<Point> {
    let (first, last) = (controls[0], controls[controls.len() - 1]);
    let [begin, end] =
        ends.map_or([last.midpoint(first); 2], |[begin, end]| [frame.end_point(first, begin), frame.end_point(last, end)]);
    let between = controls.windows(2).map(|pair| pair[0].midpoint(pair[1]));
    std::iter::once(begin).chain(between).chain(std::iter::once(end)).collect()
}

/// A contour's spline or full outline: control points and joints in turn.
pub(super) struct Spline {
    /// The control point of every piece, near where it crosses its edge.
    pub(super) controls: Vec<Point>,
    /// `joints[k]` is where piece k begins and `joints[k + 1]` where it ends; for a closed contour the last is the first again.
    pub(super) joints: Vec<Point>,
    /// The pieces that are corners: straight to the control point and straight on.
    pub(super) corners: Vec<bool>,
    pub(super) closed: bool,
}

impl Spline {
    /// The spline through the points in which a contour crosses its edges.
    pub(super) fn new(frame: Frame, sleeve: &Sleeve, area: Option<f64>, ends: Option<[End; 2]>, has_corners: bool) -> Self {
        let controls = sleeve.crossings.to_vec();
        let corners = vec![has_corners; controls.len()];
        let mut spline = Self { joints: joints(&controls, frame, ends), corners, controls, closed: ends.is_none() };
        if spline.closed {
            spline.rescale(sleeve, area);
        }
        spline
    }

    /// As it is, from begin to end.
    pub(super) fn path(&self) -> BezPath {
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

    /// One that is all corners, from begin to end, without the joints that lie in the middle between two of them.
    pub(super) fn polyline(&self) -> BezPath {
        let mut path = BezPath::with_capacity(self.joints.len() + 2);
        path.move_to(self.joints[0]);
        for (k, control) in self.controls.iter().enumerate() {
            path.line_to(*control);
            let is_between = self.controls.get(k + 1).is_some_and(|next| control.midpoint(*next) == self.joints[k + 1]);
            if !is_between {
                path.line_to(self.joints[k + 1]);
            }
        }
        path
    }

    fn piece(&self, k: usize) -> QuadBez {
        QuadBez::new(self.joints[k], self.controls[k], self.joints[k + 1])
    }

    /// The second difference of piece k: 0 for a corner, which is straight on both sides.
    pub(super) fn bend(&self, k: usize) -> Vec2 {
        let QuadBez { p0, p1, p2 } = self.piece(k);
        if self.corners[k] { Vec2::ZERO } else { (p2 - p1) - (p1 - p0) }
    }

    /// The middle of piece k.
    pub(super) fn middle(&self, k: usize) -> Point {
        if self.corners[k] { self.controls[k] } else { self.piece(k).eval(0.5) }
    }

    /// The area under the spline from begin to end.
    pub(super) fn whole_area(&self) -> f64 {
        (0..self.controls.len()).map(|k| self.area(k)).sum()
    }

    /// The area under piece k, as `kurbo` counts it.
    pub(super) fn area(&self, k: usize) -> f64 {
        let (from, control, to) = (self.joints[k].to_vec2(), self.controls[k].to_vec2(), self.joints[k + 1].to_vec2());
        if self.corners[k] { 0.5 * (from.cross(control) + control.cross(to)) } else { self.piece(k).signed_area() }
    }

    /// The direction of the spline in a joint, of any length.
    pub(super) fn direction(&self, k: usize) -> Vec2 {
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
    pub(super) fn directions(&self, k: usize) -> [Vec2; 2] {
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
