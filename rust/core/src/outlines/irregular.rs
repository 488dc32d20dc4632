//! Irregular dots: stipples that look made by hand.
//!
//! # The idea
//! Around the circle the radius rises and falls in a few slow waves, whose heights and phases come from a hash (see
//! [`noise()`]). A closed curve of [`JOINTS`] cubics follows them and encloses the area of the round dot. It stays in its
//! [`Room`], where nothing else is drawn: there it turns to where it fits, and in a tight one the waves are lower.
//!
//! # Coordinates
//! All points lie on a grid of a power of two to the pixel, so that files hold them exactly. It is as fine as a small dot needs.

use std::f64::consts::{PI, TAU};
use std::iter::successors;

use kurbo::{BezPath, ParamCurve, PathSeg, Point, Shape, Vec2};

use crate::base::{Ink, noise};
use crate::outlines::parts::Stipple;
use crate::outlines::spline::FINER_GRIDS;

/// How far the radius varies at irregularity 1, as a share of it: more looks like a splash.
const VARIATION: f64 = 0.35;

/// The number of waves around the circle, and the share of the variation that they have: slow ones make an outline uneven, fast
/// ones make it a star.
const WAVES: [(f64, f64); 3] = [(2.0, 0.55), (3.0, 0.35), (4.0, 0.1)];

/// Cubics around a dot: fewer cannot follow the waves, more make files larger.
const JOINTS: usize = 6;

/// How far a control point is from its joint, in radii, for a circle: 4/3 of the tangent of a quarter of the angle between joints.
const HANDLE: f64 = 0.357_265_589_908_163_5;

/// In how many directions, over half a turn, an outline is tried: more find more room, and cost time.
const TURNS: usize = 6;

/// By how much waves become lower while they have no room, and how often at most.
const LOWER: f64 = 0.75;
const TIMES_LOWER: usize = 24;

/// The part of the room that is used before rounding, which may move points outwards.
const USED_ROOM: f64 = 0.98;

/// The least radius of a dot in steps of its grid: fewer would change its shape.
const STEPS: f64 = 32.0;

/// The area that rounding may add or take away, as a share of it.
const AREA_LEFT: f64 = 0.005;

/// Where a dot may lie, around its centre: in the disc, or between the straight sides. Both are convex, so a curve lies in one of
/// them if its control points do.
#[derive(Debug, Clone)]
pub(crate) struct Room {
    /// The disc's radius.
    pub(crate) radius: f64,
    /// The sides: a unit vector towards each, and the distance of its line.
    pub(crate) sides: Vec<(Vec2, f64)>,
}

impl Room {
    /// How much of the way from the centre to the limits a curve of cubics takes up: up to 1 it stays inside.
    fn filled(&self, path: &BezPath, centre: Point) -> f64 {
        let cubics = path.segments().filter_map(|segment| if let PathSeg::Cubic(cubic) = segment { Some(cubic) } else { None });
        // The control points of halves lie much nearer to the curve than its own.
        let halves = cubics.flat_map(|cubic| <[_; 2]>::from(cubic.subdivide()));
        let points: Vec<Vec2> = halves.flat_map(|half| [half.p1, half.p2, half.p3]).map(|p| p - centre).collect();
        let most = |filled: &dyn Fn(&Vec2) -> f64| points.iter().map(filled).fold(0.0, f64::max);
        let of_disc = most(&|p| p.hypot2().sqrt() / self.radius);
        self.sides.iter().map(|(normal, distance)| most(&|p| p.dot(*normal) / distance)).fold(0.0, f64::max).min(of_disc)
    }
}

/// A joint, and the way from it to the next control point: the control point before it lies on the other side.
type Joint = (Vec2, Vec2);

/// A curve with the area of a round dot, black on its left, that nowhere leaves the room around the dot's centre. Its radius varies
/// by `irregularity`, in [0, 1]; `key` says how. Points lie on the grid of `units` to a pixel, or on a finer one. `None` if the dot
/// is too small or too tight for any other shape than a circle.
pub(crate) fn irregular(dot: &Stipple, room: &Room, irregularity: f64, key: u64, units: f64) -> Option<BezPath> {
    let centre = Point::new(dot.x, dot.y);
    let area = PI * dot.radius * dot.radius;
    let with_area = |variation: f64, turn: f64| {
        let joints = waves(variation, turn, key);
        let scale = (area / closed(Point::ZERO, &joints).area()).sqrt();
        joints.map(|(joint, handle)| (joint * scale, handle * scale))
    };
    let variations = successors(Some(VARIATION * irregularity), |variation| Some(variation * LOWER)).take(TIMES_LOWER);
    let turns = (0..TURNS).map(|turn| turn as f64 * PI / TURNS as f64);
    let mut shapes = variations.flat_map(|variation| turns.clone().map(move |turn| with_area(variation, turn)));
    let joints = shapes.find(|joints| room.filled(&closed(centre, joints), centre) <= USED_ROOM)?;

    let finest = units * FINER_GRIDS[FINER_GRIDS.len() - 1];
    let grids = successors(Some(units), |units| Some(2.0 * units)).take_while(|units| *units <= finest);
    let rounded = |units: f64| {
        let round = |v: Vec2| Vec2::new((v.x * units).round() / units, (v.y * units).round() / units);
        closed(Point::ZERO, &joints.map(|(joint, handle)| (round(centre.to_vec2() + joint), round(handle))))
    };
    let mut paths = grids.filter(|units| dot.radius * units >= STEPS).map(rounded);
    let path = paths.find(|path| (path.area() / area - 1.0).abs() <= AREA_LEFT && room.filled(path, centre) <= 1.0)?;
    Some(if dot.ink == Ink::BLACK { path } else { path.reverse_subpaths() })
}

/// The joints of an outline around the origin, of a radius near 1, with its waves turned by an angle.
fn waves(variation: f64, turn: f64, key: u64) -> [Joint; JOINTS] {
    let random = |k: usize| f64::from(noise(key.wrapping_add(k as u64)));
    std::array::from_fn(|joint| {
        let angle = joint as f64 * TAU / JOINTS as f64;
        let (mut radius, mut slope) = (1.0, 0.0);
        for (k, (count, share)) in WAVES.into_iter().enumerate() {
            // Every wave has at least half of its height, so that no dot is round by chance.
            let height = variation * share * (0.75 + 0.25 * random(2 * k));
            let (sin, cos) = libm::sincos(count * (angle - turn) + PI * random(2 * k + 1));
            radius += height * cos;
            slope -= height * count * sin;
        }
        let (sin, cos) = libm::sincos(angle);
        let (outwards, along) = (Vec2::new(cos, sin), Vec2::new(-sin, cos));
        (outwards * radius, (outwards * slope + along * radius) * HANDLE)
    })
}

/// The closed curve through joints around a centre.
fn closed(centre: Point, joints: &[Joint; JOINTS]) -> BezPath {
    let mut path = BezPath::with_capacity(JOINTS + 2);
    path.move_to(centre + joints[0].0);
    for (k, (joint, handle)) in joints.iter().enumerate() {
        let (next, next_handle) = joints[(k + 1) % JOINTS];
        path.curve_to(centre + *joint + *handle, centre + next - next_handle, centre + next);
    }
    path.close_path();
    path
}

#[cfg(test)]
mod tests {
    use kurbo::PathEl;
    use proptest::prelude::*;

    use super::*;
    use crate::base::{POLYGON_REACH, flatten_path};

    fn dot(x: f64, y: f64, radius: f64, ink: Ink) -> Stipple {
        Stipple { x, y, radius, ink, level: 0 }
    }

    fn disc(radius: f64) -> Room {
        Room { radius, sides: vec![(Vec2::new(0.0, 1.0), 0.0)] }
    }

    proptest! {
        #[test]
        fn irregular_dots_stay_in_their_room_and_keep_their_area(
            x in 20.0..40.0, y in 20.0..40.0, radius in 0.002..15.0, slack in 1.0..2.0,
            irregularity in 0.01..=1.0, key in any::<u64>(), is_black in any::<bool>(), is_open in any::<bool>(),
        ) {
            let ink = if is_black { Ink::BLACK } else { Ink::WHITE };
            let limit = radius * POLYGON_REACH * slack;
            let far = if is_open { 1.0 } else { 0.1 } * limit;
            let room = Room { radius: limit, sides: vec![
                (Vec2::new(1.0, 0.0), 2.0 * far), (Vec2::new(0.0, 1.0), far),
                (Vec2::new(-1.0, 0.0), 3.0 * far), (Vec2::new(0.0, -1.0), far),
            ] };
            let (dot, centre) = (dot(x, y, radius, ink), Point::new(x, y));
            let path = irregular(&dot, &room, irregularity, key, 32.0).unwrap();
            let turn = if is_black { 1.0 } else { -1.0 };
            prop_assert!((path.area() * turn / (PI * radius * radius) - 1.0).abs() < 0.01);

            // Seen from the centre it goes round once, however coarsely it is flattened.
            for tolerance in [0.05, 1e-4 * radius] {
                let points: Vec<Vec2> = flatten_path(&path, tolerance).into_iter().map(|[x, y]| Point::new(x, y) - centre).collect();
                let in_disc = points.iter().all(|p| p.hypot() <= limit);
                let between = points.iter().all(|p| room.sides.iter().all(|side| p.dot(side.0) <= side.1));
                prop_assert!((in_disc || between) && points.iter().all(|p| p.hypot() > 0.4 * radius));
                prop_assert!(points.iter().zip(points.iter().cycle().skip(1)).all(|(a, b)| *a == *b || a.cross(*b) * turn > 0.0));
            }

            let units = 32.0 * FINER_GRIDS[FINER_GRIDS.len() - 1];
            let on_grid = |p: Point| (p.x * units).fract() == 0.0 && (p.y * units).fract() == 0.0;
            let mut cubics = path.elements().iter().filter_map(|e| if let PathEl::CurveTo(a, b, c) = *e { Some([a, b, c]) } else { None });
            prop_assert!(cubics.all(|points| points.into_iter().all(on_grid)));
        }
    }

    #[test]
    fn the_variation_is_as_asked() {
        let spread = |irregularity: f64, key: u64| {
            let path = irregular(&dot(30.0, 30.0, 4.0, Ink::BLACK), &disc(8.0), irregularity, key, 32.0).unwrap();
            let radii: Vec<f64> =
                flatten_path(&path, 1e-3).iter().map(|[x, y]| ((x - 30.0).hypot(y - 30.0) / 4.0 - 1.0).abs()).collect();
            radii.into_iter().fold(0.0, f64::max)
        };
        for key in 0..200 {
            let (half, whole) = (spread(0.5, key), spread(1.0, key));
            assert!(half > 0.05 && half < 0.5 * VARIATION + 0.02, "{half}");
            assert!(whole > 0.1 && whole < VARIATION + 0.02, "{whole}");
        }
    }

    #[test]
    fn a_dot_without_room_or_far_below_the_grid_stays_round() {
        assert_eq!(irregular(&dot(30.0, 30.0, 2.0, Ink::BLACK), &disc(1.9), 1.0, 0, 32.0), None);
        assert_eq!(irregular(&dot(30.0, 30.0, 1e-9, Ink::BLACK), &disc(1.0), 1.0, 0, 32.0), None);
    }
}
