//! Rings with fewer points, by Douglas and Peucker's method.

use kurbo::Point;

use crate::base::distance_to_segment;

/// How far a ring may move where points are left out, in mm: a tenth of what a hand-held rule shows, and finer than any pen or knife
/// is set. Without it the points of nested insets grow tenfold in six of them.
pub const SIMPLIFIED: f64 = 0.01;

/// Points between two that are kept, at most. Where saw teeth grow along a ring, each span is cut at its end and not in its middle, and
/// all its points are looked at for each of them: a hundred thousand would take a minute. More points take that much longer, fewer leave
/// a point more in long rings.
const LONGEST_SPAN: usize = 512;

/// A closed ring without the points that lie within `tolerance` of what is left; empty if nothing is left that has an area.
pub fn simplified(ring: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    if ring.len() < 4 {
        return ring.to_vec();
    }
    // From the uppermost of the leftmost points, wherever the ring begins, to the point farthest from it, and back.
    let first = (0..ring.len()).min_by(|a, b| ring[*a][0].total_cmp(&ring[*b][0]).then(ring[*a][1].total_cmp(&ring[*b][1])));
    let first = first.unwrap_or(0);
    let at = |k: usize| {
        let [x, y] = ring[(first + k) % ring.len()];
        Point::new(x, y)
    };
    let farthest = (1..ring.len()).max_by(|a, b| at(*a).distance_squared(at(0)).total_cmp(&at(*b).distance_squared(at(0))));
    let farthest = farthest.unwrap_or(1);
    let mut kept = vec![false; ring.len() + 1];
    keep(&at, &[(0, farthest), (farthest, ring.len())], tolerance, &mut kept);
    let left: Vec<[f64; 2]> = (0..ring.len()).filter(|k| kept[*k]).map(|k| ring[(first + k) % ring.len()]).collect();
    if left.len() < 3 { Vec::new() } else { left }
}

/// An open line likewise; its ends stay.
pub fn simplified_line(line: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut kept = vec![false; line.len()];
    keep(&|k| Point::new(line[k][0], line[k][1]), &[(0, line.len() - 1)], tolerance, &mut kept);
    line.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(point, _)| *point).collect()
}

/// Marks the points that are kept of spans from one point to another: their ends, and the farthest from the chord where it is too far.
pub(crate) fn keep(at: &dyn Fn(usize) -> Point, spans: &[(usize, usize)], tolerance: f64, kept: &mut [bool]) {
    let mut spans = spans.to_vec();
    while let Some((begin, end)) = spans.pop() {
        (kept[begin], kept[end]) = (true, true);
        if end - begin > LONGEST_SPAN {
            let middle = begin.midpoint(end);
            spans.extend([(begin, middle), (middle, end)]);
            continue;
        }
        let (mut most, mut place) = (tolerance, None);
        for k in begin + 1..end {
            let distance = distance_to_segment(at(k), at(begin), at(end));
            if distance > most {
                (most, place) = (distance, Some(k));
            }
        }
        if let Some(place) = place {
            spans.extend([(begin, place), (place, end)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saw_teeth_that_grow_take_no_longer_than_others() {
        let count = 100_000;
        let tooth = |i: usize| [i as f64, if i.is_multiple_of(2) { 0.0 } else { 1.0 + 1e-3 * i as f64 }];
        let mut ring: Vec<[f64; 2]> = (0..count).map(tooth).collect();
        ring.extend([[count as f64, -5.0], [0.0, -5.0]]);
        assert_eq!(simplified(&ring, SIMPLIFIED).len(), ring.len());
        assert_eq!(simplified_line(&ring, SIMPLIFIED).len(), ring.len());
    }

    #[test]
    fn long_lines_keep_few_points_of_none_that_matters() {
        let line: Vec<[f64; 2]> = (0..10_000).map(|i| [0.01 * f64::from(i), 1e-3 * f64::from(i % 3)]).collect();
        let left = simplified_line(&line, SIMPLIFIED);
        assert!(left.len() <= 2 + 2 * line.len() / LONGEST_SPAN && left.first() == line.first() && left.last() == line.last());
    }
}
