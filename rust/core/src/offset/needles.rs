//! Rings without needles: where a ring goes out and comes back along the same line.

use kurbo::Point;

use crate::base::distance_to_segment;

/// A closed ring without the points of needles whose sides lie within `width` of each other, and without points that lie so near to
/// the one before; empty if less than three are left.
pub(super) fn without_needles(ring: Vec<[f64; 2]>, width: f64) -> Vec<[f64; 2]> {
    let is_tip = |a, b, c| is_tip([a, b, c].map(point), width);
    let mut left: Vec<[f64; 2]> = Vec::with_capacity(ring.len());
    for next in ring {
        while let [.., a, b] = left[..]
            && is_tip(a, b, next)
        {
            left.pop();
        }
        if left.last().is_none_or(|last| !is_near(*last, next, width)) {
            left.push(next);
        }
    }
    // Where the ring ends and begins.
    let mut first = 0;
    while let [a, b, .., y, z] = left[first..] {
        if is_near(z, a, width) || is_tip(y, z, a) {
            left.pop();
        } else if is_tip(z, a, b) {
            first += 1;
        } else {
            break;
        }
    }
    left.drain(..first);
    if left.len() < 3 { Vec::new() } else { left }
}

fn point([x, y]: [f64; 2]) -> Point {
    Point::new(x, y)
}

fn is_near(a: [f64; 2], b: [f64; 2], width: f64) -> bool {
    point(a).distance_squared(point(b)) <= width * width
}

/// Whether a ring turns back at b, and one of its neighbours lies beside the line to the other.
fn is_tip([a, b, c]: [Point; 3], width: f64) -> bool {
    let (there, back) = (b - a, c - b);
    if there.dot(back) >= 0.0 {
        return false;
    }
    let (short, long) = if there.hypot2() < back.hypot2() { (a, c) } else { (c, a) };
    distance_to_segment(short, b, long) <= width
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needles_go_wherever_the_ring_begins() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        // Into the square from its right side, with a blunt tip and points on its sides; out of its corner; and out and back along an edge.
        let with_needles = [
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 5.0],
            [6.0, 5.0005],
            [3.0, 5.0],
            [3.0, 5.0009],
            [5.0, 5.0009],
            [10.0, 5.0009],
            [10.0, 10.0],
            [15.0, 15.0],
            [10.0005, 10.0],
            [4.0, 10.0],
            [7.0, 10.0],
            [0.0, 10.0],
        ];
        for first in 0..with_needles.len() {
            let mut ring = with_needles.to_vec();
            ring.rotate_left(first);
            let left = without_needles(ring, 0.001);
            assert!(square.iter().all(|corner| left.iter().any(|point| is_near(*point, *corner, 0.001))), "{left:?}");
            assert!(left.iter().all(|[x, y]| [*x, *y].iter().any(|v| *v == 0.0 || (*v - 10.0).abs() < 0.001)), "{left:?}");
        }
    }

    #[test]
    fn what_is_wider_stays_and_what_is_nothing_else_goes() {
        let ring = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [3.0, 5.1], [10.0, 5.2], [10.0, 10.0]];
        assert_eq!(without_needles(ring.clone(), 0.001), ring);
        assert!(without_needles(vec![[0.0, 0.0], [5.0, 0.0005], [10.0, 0.0], [4.0, 0.0]], 0.001).is_empty());
        assert!(without_needles(vec![[1.0, 1.0]; 5], 0.001).is_empty());
        assert!(without_needles(Vec::new(), 0.001).is_empty());
    }
}
