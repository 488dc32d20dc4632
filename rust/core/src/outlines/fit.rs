//! Outlines: from the points in which a contour crosses the graph's edges to the curve that is drawn.
//!
//! # The idea
//! The smoothed contour is a uniform quadratic B-spline whose control points are the contour's crossings (the midpoints of its crossing
//! edges, or other points on them); its pieces join in the middle between two crossings. That is the full outline, which tolerance
//! 0 draws. With a tolerance it is drawn with fewer points (see [`super::simplify`]). Each curve is made once and shared by both
//! sides, so neighbours always fit.

use kurbo::{BezPath, Point, QuadBez, Vec2};

use crate::base::{End, FINEST_GRID, Frame, flattening_tolerance, snap};
use crate::outlines::simplify::Simplifier;
use crate::outlines::sleeve::{CrossingEdge, Sleeve};
use crate::outlines::spline::{FINER_GRIDS, Spline, joints, spacing, units_per_pixel};

/// Units to a pixel of the grid for points that no coarser one keeps where they have to be: middles of two of them lie on the finest.
const LAST_GRID: f64 = 0.5 * FINEST_GRID;

/// What a contour is fitted with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// How far a curve may lie from the full outline, in pixels; 0 keeps every crossing.
    pub(super) tolerance: f64,
    /// Units to a pixel of the grid of coordinates.
    pub(super) units: f64,
    /// The same without a tolerance, for the full outline.
    full_units: f64,
    /// About how far nodes lie from each other, in pixels.
    pub(super) spacing: f64,
    /// Whether curves go straight from crossing to crossing, with a corner in each.
    has_corners: bool,
    frame: Frame,
}

impl Fit {
    /// What contours are fitted with on a canvas with so many nodes to a pixel, at a tolerance in pixels.
    pub(super) fn new(tolerance: f64, nodes_per_pixel: f64, frame: Frame) -> Self {
        let [units, full_units] = [tolerance, 0.0].map(|tolerance| units_per_pixel(tolerance, nodes_per_pixel));
        Self { tolerance, units, full_units, spacing: spacing(nodes_per_pixel), has_corners: false, frame }
    }

    /// The same for curves that go straight from crossing to crossing and keep every one.
    pub(super) fn with_corners(self) -> Self {
        Self { tolerance: 0.0, units: self.full_units, has_corners: true, ..self }
    }

    /// The curve of the contour that crosses `edges` about in the points `crossings`, with black on its left. A small closed contour
    /// encloses `area` px^2 if it is given, or else that of its polygon of crossings. An open contour begins and ends on the given
    /// sides of the frame, or in junctions.
    pub(super) fn curve(&self, edges: &[CrossingEdge], crossings: &[Point], area: Option<f64>, ends: Option<[End; 2]>) -> BezPath {
        let sleeve = Sleeve::new(edges, crossings, ends, self.frame, flattening_tolerance(self.units));
        let outline = self.full_outline(area, ends, &sleeve);
        let outline = if self.tolerance > 0.0 {
            Simplifier::new(self.tolerance, self.spacing, self.units, &outline, &sleeve).run()
        } else {
            outline
        };
        let mut path = if self.has_corners { outline.polyline() } else { outline.path() };
        if outline.closed {
            path.close_path();
        }
        path
    }

    /// Where the three contours of a triangle of three inks meet: in its middle, on the coarsest grid that keeps that clear of its
    /// sides.
    pub(super) fn junction(&self, [a, b, c]: [Point; 3]) -> Point {
        let middle = ((a.to_vec2() + b.to_vec2() + c.to_vec2()) / 3.0).to_point();
        // Of the three triangles that a junction makes with the sides, each has at least half of what the middle gives it, and lies
        // within: a grid that is too coarse for a thin triangle would put the junction outside.
        let turn = (b - a).cross(c - a);
        let keeps_clear =
            |p: &Point| [[a, b], [b, c], [c, a]].iter().all(|[u, v]| (*v - *u).cross(*p - *u) * turn.signum() >= turn.abs() / 6.0);
        self.snapped(middle).find(keeps_clear).unwrap_or(snap(middle, LAST_GRID))
    }

    /// The spline through all crossings, on its grid.
    fn full_outline(&self, area: Option<f64>, ends: Option<[End; 2]>, sleeve: &Sleeve) -> Spline {
        let fit = Self { units: self.full_units, ..*self };
        let spline = Spline::new(self.frame, sleeve, area, ends, self.has_corners);
        // Control points on twice the grid, so that joints lie on the grid too, and files need not say both.
        let controls: Vec<Point> = spline.controls.iter().map(|p| fit.snap(*p, 0.5)).collect();
        let snapped = joints(&controls, self.frame, ends);
        let on_grid = |(k, joint): (usize, &Point)| {
            // A junction is on its grid.
            std::iter::once(snapped[k])
                .chain(fit.snapped(*joint))
                .find(|p| sleeve.cell(k).holds(*p))
                .unwrap_or(snap(*joint, LAST_GRID))
        };
        let joints: Vec<Point> = spline.joints.iter().enumerate().map(on_grid).collect();
        let mut scratch = Vec::new();
        let mut piece = |k: usize| {
            let (from, to, directions) = (joints[k], joints[k + 1], spline.directions(k));
            if self.has_corners {
                let stays = sleeve.holds(&[from, controls[k], to], k, k + 1, directions);
                return (if stays { controls[k] } else { fit.corner(sleeve, k, [from, to], directions) }, true);
            }
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
        self.snapped(crossing).find(|p| sleeve.holds(&[from, *p, to], k, k + 1, directions)).unwrap_or(snap(crossing, LAST_GRID))
    }

    /// A point on the grid and on finer ones, the coarsest first.
    fn snapped(self, p: Point) -> impl Iterator<Item = Point> {
        FINER_GRIDS.iter().map(move |finer| self.snap(p, *finer))
    }

    fn snap(&self, p: Point, finer: f64) -> Point {
        snap(p, self.units * finer)
    }
}

#[cfg(test)]
mod tests {
    use kurbo::{PathEl, Shape};

    use super::*;
    use crate::base::is_mirrored;
    use crate::outlines::simplify::AREA_LEFT;

    /// The outline of a black disc with a radius of 20 px, around which 60 triangles lie, crossed at uneven places.
    fn disc(tolerance: f64) -> BezPath {
        let node = |angle: usize, radius: f64| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * angle as f64 / 60.0);
            Point::new(40.0 + radius * cos, 40.0 + radius * sin)
        };
        let edges: Vec<[Point; 2]> = (0..60usize).map(|k| [node(k.div_ceil(2) * 2, 19.0), node(k / 2 * 2 + 1, 21.0)]).collect();
        let at = |k: usize| 0.4 + 0.2 * f64::from(crate::base::noise(k as u64));
        let crossings: Vec<Point> = edges.iter().enumerate().map(|(k, [black, white])| black.lerp(*white, at(k))).collect();
        Fit::new(tolerance, 0.3, Frame { width: 80.0, height: 80.0 }).curve(&edges, &crossings, None, None)
    }

    #[test]
    fn a_disc_takes_few_points_and_keeps_its_area() {
        let full = disc(0.0);
        let mut last = full.elements().len();
        assert!(last >= 62);
        for tolerance in [0.1, 0.25, 0.5] {
            let simple = disc(tolerance);
            let curves = simple.elements();
            assert!(curves.len() < last, "{} points of {last} at {tolerance}", curves.len());
            assert!((simple.area() - full.area()).abs() <= AREA_LEFT, "{} for {}", simple.area(), full.area());
            // Joints are between control points: pieces say only where they end, but the first, and where the full outline was kept.
            let quads = curves.windows(2).filter(|pair| matches!(pair[1], PathEl::QuadTo(..)));
            assert!(quads.filter(|pair| !is_mirrored(&pair[0], &pair[1])).count() <= 2);
            last = curves.len();
        }
        assert!(last <= 25);
    }

    #[test]
    fn a_junction_lies_in_its_triangle_however_thin() {
        let fit = Fit::new(0.5, 0.3, Frame { width: 20.0, height: 20.0 });
        for k in 0..2000 {
            let random = |j: u64| f64::from(crate::base::noise(8 * k + j));
            let [a, b] = [0, 2].map(|j| Point::new(10.0 + random(j), 10.0 + random(j + 1)));
            let c = a.lerp(b, 0.5 + 0.4 * random(4)) + 0.02 * random(5) * (b - a).turn_90();
            let triangle = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
            let junction = fit.junction(triangle);
            let [a, b, c] = triangle;
            let turn = (b - a).cross(c - a);
            for [u, v] in [[a, b], [b, c], [c, a]] {
                let share = (v - u).cross(junction - u) / turn;
                assert!(share > 0.1 && share < 0.9 || turn.abs() < 1e-6, "{junction:?} has {share} of {triangle:?}");
            }
        }
    }

    /// Six cells around one: a curve through the middles of the edges alone would enclose much less than the cell.
    #[test]
    fn a_small_loop_encloses_what_its_cells_have() {
        let centre = Point::new(10.0, 10.0);
        let white = |k: u32| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 6.0);
            Point::new(10.0 + 2.0 * cos, 10.0 + 2.0 * sin)
        };
        let edges: Vec<[Point; 2]> = (0..6).map(|k| [centre, white(k)]).collect();
        let crossings: Vec<Point> = edges.iter().map(|[black, white]| black.midpoint(*white)).collect();
        let fit = Fit::new(0.0, 0.3, Frame { width: 20.0, height: 20.0 });
        let cell = 2.0 * 3f64.sqrt();
        let area = fit.curve(&edges, &crossings, Some(cell), None).area();
        assert!((area / cell - 1.0).abs() < 0.02, "{area} instead of {cell}");
    }
}
