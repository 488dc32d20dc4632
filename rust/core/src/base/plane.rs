//! The plane of the canvas: its frame with four sides, distances and areas.

use kurbo::Point;
use robust::{Coord, orient2d};

/// A side of the frame, in the order in which a ring with positive area runs along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// y = 0.
    Top = 0,
    /// x = width.
    Right = 1,
    /// y = height.
    Bottom = 2,
    /// x = 0.
    Left = 3,
}

impl Side {
    pub(crate) const ALL: [Self; 4] = [Self::Top, Self::Right, Self::Bottom, Self::Left];
}

/// Where an open curve begins or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum End {
    /// On a side of the frame, which it meets at a right angle.
    Frame(Side),
    /// In a junction, where three inks meet.
    Junction(Point),
}

impl End {
    /// The junction, if it is one.
    pub(crate) fn junction(self) -> Option<Point> {
        match self {
            Self::Frame(_) => None,
            Self::Junction(junction) => Some(junction),
        }
    }
}

/// The frame of the canvas, and positions along it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Frame {
    /// Whether a point lies inside, not on the frame.
    pub(crate) fn holds(self, p: Point) -> bool {
        p.x > 0.0 && p.y > 0.0 && p.x < self.width && p.y < self.height
    }

    /// The foot of a point on a side.
    pub(crate) fn project(self, p: Point, side: Side) -> Point {
        match side {
            Side::Top => Point::new(p.x, 0.0),
            Side::Right => Point::new(self.width, p.y),
            Side::Bottom => Point::new(p.x, self.height),
            Side::Left => Point::new(0.0, p.y),
        }
    }

    /// Where a curve that comes straight from a point ends.
    pub(crate) fn end_point(self, p: Point, end: End) -> Point {
        match end {
            End::Frame(side) => self.project(p, side),
            End::Junction(junction) => junction,
        }
    }

    /// The place of a point on the frame. A corner is where a side begins.
    pub(crate) fn place(self, p: Point) -> Place {
        if p.y <= 0.0 && p.x < self.width {
            Place { side: Side::Top, along: p.x }
        } else if p.x >= self.width && p.y < self.height {
            Place { side: Side::Right, along: p.y }
        } else if p.y >= self.height && p.x > 0.0 {
            Place { side: Side::Bottom, along: -p.x }
        } else {
            Place { side: Side::Left, along: -p.y }
        }
    }

    /// The corners, from (0, 0) on in the positive direction.
    pub(crate) fn corners(self) -> [Point; 4] {
        [(0.0, 0.0), (self.width, 0.0), (self.width, self.height), (0.0, self.height)].map(Point::from)
    }
}

/// A place on the frame. Places come in the positive direction from the corner (0, 0): top, right, bottom, left. They are compared
/// by coordinates as they stand, so that nothing is rounded.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Place {
    side: Side,
    /// A coordinate that rises in this direction.
    along: f64,
}

/// How far a point is from a segment.
pub(crate) fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.hypot2()).clamp(0.0, 1.0);
    // Both ends in one place: the fraction is not a number.
    let nearest = if t.is_nan() { a } else { a + along * t };
    // Not `distance`, whose hypot may differ between platforms in the last bit.
    (p - nearest).hypot2().sqrt()
}

/// Twice-halved shoelace sum: positive when the ring turns from +x towards +y.
pub fn signed_area(ring: &[[f64; 2]]) -> f64 {
    let mut sum = 0.0;
    for (i, p) in ring.iter().enumerate() {
        let q = ring[(i + 1) % ring.len()];
        sum += p[0] * q[1] - q[0] * p[1];
    }
    sum / 2.0
}

/// The point of a grid of so many units to a pixel that is nearest to p; never -0, which relative numbers do not keep.
pub(crate) fn snap(p: Point, units: f64) -> Point {
    Point::new((p.x * units).round() / units + 0.0, (p.y * units).round() / units + 0.0)
}

/// Units to a pixel of the finest grid on which coordinates lie: differences of any two on a canvas and its surroundings are exact, so
/// that files hold them exactly whether they are absolute or relative.
pub(crate) const FINEST_GRID: f64 = (1u64 << 32) as f64;

/// Which side of the line from one point to another a third one lies on, exactly: 0 on the line, and above 0 to the left of a line
/// that falls, as a reader sees it.
pub(crate) fn side_of([from, to]: [[f64; 2]; 2], p: [f64; 2]) -> f64 {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    orient2d(coord(from), coord(to), coord(p))
}

/// Whether two segments have a point in common, their ends included; exactly.
pub(crate) fn segments_meet(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    let range = |[p, q]: [[f64; 2]; 2], axis: usize| [p[axis].min(q[axis]), p[axis].max(q[axis])];
    // The boxes tell segments on one line apart.
    let boxes_meet = (0..2).all(|axis| {
        let ([a_low, a_high], [b_low, b_high]) = (range(a, axis), range(b, axis));
        a_low <= b_high && b_low <= a_high
    });
    boxes_meet && side_of(a, b[0]) * side_of(a, b[1]) <= 0.0 && side_of(b, a[0]) * side_of(b, a[1]) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_snapped_to_minus_zero() {
        let Point { x, y } = snap(Point::new(-0.01, -0.0), 16.0);
        assert!(x == 0.0 && y == 0.0 && x.is_sign_positive() && y.is_sign_positive());
        assert_eq!(snap(Point::new(-0.04, 0.04), 16.0), Point::new(-0.0625, 0.0625));
    }

    #[test]
    fn segments_meet_where_they_cross_touch_or_lie_on_each_other() {
        let a = [[0.0, 0.0], [4.0, 2.0]];
        for (b, meets) in [
            ([[0.0, 2.0], [4.0, 0.0]], true),
            ([[2.0, 1.0], [2.0, 9.0]], true),
            ([[4.0, 2.0], [5.0, 0.0]], true),
            ([[2.0, 1.0], [8.0, 4.0]], true),
            ([[6.0, 3.0], [8.0, 4.0]], false),
            ([[2.0, 1.0_f64.next_up()], [2.0, 9.0]], false),
            ([[0.0, 1.0], [4.0, 3.0]], false),
        ] {
            assert_eq!([segments_meet(a, b), segments_meet(b, a)], [meets; 2], "{b:?}");
        }
    }
}
