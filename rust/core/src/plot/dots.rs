//! Dots as a pen draws them: by a press, a circle, or a spiral out to a circle.

use std::f64::consts::TAU;

use crate::offset::SIMPLIFIED;
use crate::plot::contour::Spacing;
use crate::plot::path::Path;
use crate::plot::settings::PenDots;

/// A dot at most so many pens wide is one press: a circle of it would be shorter than half the pen.
const PRESSED: f64 = 1.15;

/// The path of a dot; inside it by half the pen.
pub(super) fn dot(centre: [f64; 2], radius: f64, spacing: Spacing, how: PenDots) -> Path {
    if 2.0 * radius <= PRESSED * spacing.pen {
        return Path { points: vec![centre], is_closed: false };
    }
    let rim = radius - spacing.inset;
    let circle = || (0..corners(rim)).map(|k| on_circle(centre, rim, k as f64 / corners(rim) as f64));
    // The pen covers the middle from the rim.
    if how == PenDots::Circle || rim <= 0.5 * spacing.pen {
        return Path { points: circle().collect(), is_closed: true };
    }
    let turns = rim / spacing.apart;
    let steps = libm::ceil(turns * corners(0.5 * rim) as f64).max(1.0);
    // Ends where the circle begins.
    let turned = libm::ceil(turns) - turns;
    let spiral = (0..steps as usize).map(|k| {
        let share = k as f64 / steps;
        on_circle(centre, rim * share, share * turns + turned)
    });
    Path { points: spiral.chain(circle()).chain([on_circle(centre, rim, 0.0)]).collect(), is_closed: false }
}

/// The corners of a circle that chords keep to half of what is simplified.
fn corners(radius: f64) -> usize {
    let half = libm::acos((1.0 - 0.5 * SIMPLIFIED / radius).clamp(0.5, 1.0));
    libm::ceil(std::f64::consts::PI / half).clamp(8.0, 720.0) as usize
}

fn on_circle([x, y]: [f64; 2], radius: f64, turn: f64) -> [f64; 2] {
    [x + radius * libm::cos(TAU * turn), y + radius * libm::sin(TAU * turn)]
}

#[cfg(test)]
mod tests {
    use kurbo::Point;

    use super::*;
    use crate::base::distance_to_segment;

    const SPACING: Spacing = Spacing { pen: 0.3, apart: 0.27, inset: 0.15 };

    fn drawn(diameter: f64, how: PenDots) -> Path {
        dot([1.0, 2.0], 0.5 * diameter, SPACING, how)
    }

    fn radius(p: &[f64; 2]) -> f64 {
        (p[0] - 1.0).hypot(p[1] - 2.0)
    }

    #[test]
    fn small_dots_are_one_press() {
        for diameter in [0.01, 0.3, 0.345] {
            let press = Path { points: vec![[1.0, 2.0]], is_closed: false };
            assert_eq!((drawn(diameter, PenDots::Press), drawn(diameter, PenDots::Circle)), (press.clone(), press));
        }
        assert!(drawn(0.35, PenDots::Press).is_closed);
    }

    #[test]
    fn the_rim_lies_inside_by_half_the_pen() {
        let circle = drawn(0.55, PenDots::Press);
        assert!(circle.is_closed && circle.points.iter().all(|p| (radius(p) - 0.125).abs() < 1e-12));
        let rim = drawn(3.0, PenDots::Circle);
        assert!(rim.is_closed && rim.points.iter().all(|p| (radius(p) - 1.35).abs() < 1e-12));
    }

    #[test]
    fn large_dots_are_a_spiral_and_a_circle() {
        let spiral = drawn(3.0, PenDots::Press);
        assert!(!spiral.is_closed && radius(&spiral.points[0]) < 1e-12);
        let radii: Vec<f64> = spiral.points.iter().map(radius).collect();
        assert!(radii.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9));
        // No place in the dot is further than half the pen from the line.
        for k in 0..2000 {
            let (share, turn) = (libm::sqrt((f64::from(k) + 0.5) / 2000.0), f64::from(k) * 0.618_034);
            let p = on_circle([1.0, 2.0], 1.49 * share, turn);
            let point = |[x, y]: [f64; 2]| Point::new(x, y);
            let to_side = |pair: &[[f64; 2]]| distance_to_segment(point(p), point(pair[0]), point(pair[1]));
            let nearest = spiral.points.windows(2).map(to_side).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.151, "{p:?} {nearest}");
        }
    }
}
