//! Dots: how large one may be where it stands, and where it moves to have room.

use kurbo::{Point, Vec2};

use crate::base::{End, Frame, Ink, ROOM, STAR_FILL, distance_to_segment};
use crate::outlines::irregular::Room;
use crate::outlines::parts::Stipple;
use crate::outlines::spline::FINER_GRIDS;

/// The triangles around the node of a dot.
pub(super) struct Star {
    /// The nodes around it, in order.
    pub(super) rim: Vec<Point>,
    /// Where it meets the frame, the ends of its contour beside the first and the last of them.
    pub(super) ends: Option<[End; 2]>,
    pub(super) frame: Frame,
}

impl Star {
    /// The dot of a node at `site` that would like to have the radius `wanted`.
    pub(super) fn dot(&self, site: Point, wanted: f64, units: f64, ink: Ink) -> Stipple {
        // Away from the frame as far as the whole dot needs; the circle around the site within its reach is inside the star.
        let Frame { width, height } = self.frame;
        let room = wanted / STAR_FILL;
        let inwards = |v: f64, length: f64| if 2.0 * room < length { v.clamp(room, length - room) } else { length / 2.0 };
        let inner = Point::new(inwards(site.x, width), inwards(site.y, height));
        let reach = self.to_rim(site);
        let mut best: Option<Stipple> = None;
        for part in [1.0, 0.5, 0.25, 0.0] {
            let centre = site.lerp(inner, part);
            if part > 0.0 && (centre == site || (centre - site).hypot2().sqrt() > 0.8 * reach) {
                continue;
            }
            let dot = self.fitting(centre, wanted, units, ink);
            if best.as_ref().is_none_or(|best| dot.radius > best.radius) {
                best = Some(dot);
            }
        }
        best.unwrap_or_else(|| Stipple::on_grid(site, wanted.min(self.reach(site)), units, ink))
    }

    /// The largest dot around `centre`, of a radius up to `wanted`, on the coarsest grid that costs it next to nothing.
    fn fitting(&self, centre: Point, wanted: f64, units: f64, ink: Ink) -> Stipple {
        let possible = wanted.min(self.reach(centre));
        let mut dot = Stipple::on_grid(centre, possible, units, ink);
        for finer in FINER_GRIDS {
            // Rounding moves the centre: what is left there, and a little less for moving again.
            dot = Stipple::on_grid(centre, possible, units * finer, ink);
            for _ in 0..3 {
                let left = self.reach(Point::new(dot.x, dot.y));
                if dot.radius <= left {
                    break;
                }
                dot = Stipple::on_grid(centre, left * 0.99, units * finer, ink);
            }
            if dot.radius >= 0.97 * possible && dot.radius <= self.reach(Point::new(dot.x, dot.y)) {
                break;
            }
        }
        dot
    }

    /// The largest radius of a dot around a point inside the star.
    fn reach(&self, centre: Point) -> f64 {
        STAR_FILL * self.to_outline(centre)
    }

    /// How far a point inside the star is from its outline, rim and frame.
    fn to_outline(&self, centre: Point) -> f64 {
        let Frame { width, height } = self.frame;
        let frame = centre.x.min(width - centre.x).min(centre.y).min(height - centre.y);
        self.to_rim(centre).min(frame)
    }

    /// What a dot around a point inside the star may fill.
    pub(super) fn room(&self, centre: Point) -> Room {
        let Frame { width, height } = self.frame;
        let frame = [
            (Vec2::new(1.0, 0.0), width - centre.x),
            (Vec2::new(0.0, 1.0), height - centre.y),
            (Vec2::new(-1.0, 0.0), centre.x),
            (Vec2::new(0.0, -1.0), centre.y),
        ];
        let rim = self.sides().map(|[a, b]| {
            let along = b - a;
            let normal = Vec2::new(-along.y, along.x) / along.hypot2().sqrt();
            let distance = (a - centre).dot(normal);
            if distance < 0.0 { (-normal, -distance) } else { (normal, distance) }
        });
        let sides = rim.chain(frame).map(|(normal, distance)| (normal, ROOM * distance)).collect();
        Room { radius: ROOM * self.to_outline(centre), sides }
    }

    fn to_rim(&self, centre: Point) -> f64 {
        self.sides().map(|[a, b]| distance_to_segment(centre, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// The sides of the star, without those on the frame.
    fn sides(&self) -> impl Iterator<Item = [Point; 2]> {
        let (first, last) = (self.rim[0], self.rim[self.rim.len() - 1]);
        let others = match self.ends {
            None => [Some([last, first]), None],
            Some([begin, end]) => [(first, begin), (last, end)].map(|(p, end)| Some([p, self.frame.end_point(p, end)])),
        };
        self.rim.windows(2).map(|pair| [pair[0], pair[1]]).chain(others.into_iter().flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Side;

    #[test]
    fn a_dot_beside_the_frame_moves_in_as_far_as_it_needs() {
        let rim = [(1.0, 5.0), (6.0, 10.0), (1.0, 15.0)].map(Point::from).to_vec();
        let star = Star { rim, ends: Some([End::Frame(Side::Left); 2]), frame: Frame { width: 40.0, height: 20.0 } };
        for wanted in [0.5, 1.0, 1.5] {
            let dot = star.dot(Point::new(0.8, 10.0), wanted, 128.0, Ink::BLACK);
            assert!((0.97 * wanted..=wanted).contains(&dot.radius), "{} instead of {wanted}", dot.radius);
            assert!(dot.x > dot.radius && (dot.y - 10.0).abs() < 0.01);
        }
    }
}
