//! Areas filled by parallel lines, neighbours joined along the outline.
//!
//! The outline of what is to be hatched is followed from line to line: between two meetings with lines that are neighbours it is the way
//! on which the pen stays down. Its rim is drawn first, so edges are as crisp as with insets.

use crate::base::Result;
use crate::offset::{Polygon, SIMPLIFIED, offset};
use crate::plot::contour::{Filled, Outlined, Spacing, between, outlined};
use crate::plot::path::Path;

/// Fills one polygon by its rim and lines at an angle, in degrees from the x axis, counter-clockwise as they are seen.
///
/// # Errors
/// As [`super::contour::contours`].
pub(super) fn hatched(polygon: &Polygon, spacing: Spacing, angle: f64) -> Result<Filled> {
    let Outlined { rims, mut lines, thin } = outlined(polygon, spacing)?;
    lines.append(&mut between(&rims, spacing)?);
    let mut paths: Vec<Path> = rims.iter().flatten().map(|ring| Path { points: ring.clone(), is_closed: true }).collect();
    // However a line lies beside the rim, what is between them is covered.
    for area in offset(&rims, (spacing.apart - spacing.pen).min(0.0), SIMPLIFIED)? {
        paths.append(&mut lines_of(&area, spacing.apart, angle));
    }
    paths.append(&mut lines);
    Ok(Filled { paths, thin })
}

/// Where a line meets a ring.
#[derive(Clone, Copy)]
struct Meeting {
    line: usize,
    x: f64,
    /// The ring, and the side of it.
    ring: usize,
    side: usize,
    /// Which one it is along the ring.
    number: usize,
}

/// The lines in one area, at most `apart` from each other and evenly so from its one end to its other.
fn lines_of(area: &Polygon, apart: f64, angle: f64) -> Vec<Path> {
    let radians = angle.to_radians();
    // y runs down, so a turn by the angle as it is seen is one by its negative.
    let (sin, cos) = (-libm::sin(radians), libm::cos(radians));
    let level = |[x, y]: [f64; 2]| [x * cos + y * sin, y * cos - x * sin];
    let back = |[x, y]: [f64; 2]| [x * cos - y * sin, y * cos + x * sin];
    let rings: Vec<Vec<[f64; 2]>> = area.iter().map(|ring| ring.iter().copied().map(level).collect()).collect();
    let ys = || rings[0].iter().map(|p| p[1]);
    let (top, bottom) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
    let count = libm::ceil((bottom - top) / apart).max(1.0);
    let step = (bottom - top) / count;
    let y_of = |line: usize| top + (line as f64 + 0.5) * step;

    let meetings = meetings(&rings, top, step, count as usize);
    // Along each line, every other piece between meetings is inside.
    let mut along: Vec<Vec<usize>> = vec![Vec::new(); count as usize];
    for (place, meeting) in meetings.iter().enumerate() {
        along[meeting.line].push(place);
    }
    let mut other_end = vec![usize::MAX; meetings.len()];
    for line in &mut along {
        line.sort_by(|a, b| meetings[*a].x.total_cmp(&meetings[*b].x).then(a.cmp(b)));
        for pair in line.chunks_exact(2) {
            (other_end[pair[0]], other_end[pair[1]]) = (pair[1], pair[0]);
        }
    }
    let first_of_ring: Vec<usize> = {
        let mut firsts = vec![meetings.len(); rings.len() + 1];
        for (place, meeting) in meetings.iter().enumerate().rev() {
            firsts[meeting.ring] = place;
        }
        for ring in (0..rings.len()).rev() {
            firsts[ring] = firsts[ring].min(firsts[ring + 1]);
        }
        firsts
    };
    let mut is_done = vec![false; meetings.len()];
    let mut paths = Vec::new();
    for begin in along.iter().flatten().copied() {
        if is_done[begin] || other_end[begin] == usize::MAX {
            continue;
        }
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut from = begin;
        loop {
            let to = other_end[from];
            (is_done[from], is_done[to]) = (true, true);
            points.extend([from, to].map(|end| [meetings[end].x, y_of(meetings[end].line)]));
            // On along the ring, in the one direction or the other, if the next line is there and not drawn yet.
            let Meeting { line, ring, number, .. } = meetings[to];
            let (first, end) = (first_of_ring[ring], first_of_ring[ring + 1]);
            let on_ring = end - first;
            let next = [(number + 1) % on_ring, (number + on_ring - 1) % on_ring].into_iter().enumerate().find(|(_, next)| {
                let next = first + next;
                meetings[next].line == line + 1 && !is_done[next] && other_end[next] != usize::MAX
            });
            let Some((direction, next)) = next else { break };
            let next = first + next;
            points.extend(way(&rings[ring], meetings[to].side, meetings[next].side, direction == 0));
            from = next;
        }
        points.dedup();
        paths.push(Path { points: points.into_iter().map(back).collect(), is_closed: false });
    }
    paths
}

/// Where the lines meet the rings, along each ring.
fn meetings(rings: &[Vec<[f64; 2]>], top: f64, step: f64, count: usize) -> Vec<Meeting> {
    let mut meetings = Vec::new();
    // The first line below a height, at it included.
    let line_at = |y: f64| libm::ceil((y - top) / step - 0.5).clamp(0.0, count as f64) as usize;
    for (ring, points) in rings.iter().enumerate() {
        let mut number = 0;
        for (side, &[x0, y0]) in points.iter().enumerate() {
            let [x1, y1] = points[(side + 1) % points.len()];
            let (low, high) = (line_at(y0.min(y1)), line_at(y0.max(y1)));
            let mut meet = |line: usize| {
                let y = top + (line as f64 + 0.5) * step;
                let share = ((y - y0) / (y1 - y0)).clamp(0.0, 1.0);
                meetings.push(Meeting { line, x: x0 + share * (x1 - x0), ring, side, number });
                number += 1;
            };
            if y0 < y1 { (low..high).for_each(&mut meet) } else { (low..high).rev().for_each(&mut meet) }
        }
    }
    meetings
}

/// The points of a ring from one side to another, forwards or backwards.
fn way(ring: &[[f64; 2]], from: usize, to: usize, forwards: bool) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    let mut side = from;
    while side != to {
        if forwards {
            side = (side + 1) % ring.len();
            points.push(ring[side]);
        } else {
            points.push(ring[side]);
            side = (side + ring.len() - 1) % ring.len();
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING: Spacing = Spacing { pen: 0.3, apart: 0.27, inset: 0.15 };

    fn length(points: &[[f64; 2]]) -> f64 {
        points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
    }

    fn square(left: f64, side: f64) -> Vec<[f64; 2]> {
        vec![[left, left], [left + side, left], [left + side, left + side], [left, left + side]]
    }

    #[test]
    fn a_square_is_one_line_at_any_angle() {
        for angle in [0.0, 30.0, 45.0, 90.0, 137.0] {
            let filled = hatched(&vec![square(0.0, 10.0)], SPACING, angle).unwrap();
            assert_eq!(filled.paths.len(), 2, "{angle}");
            let covered = (length(&filled.paths[1].points) + 4.0 * 9.7) * SPACING.apart;
            assert!((97.0..110.0).contains(&covered), "{angle}: {covered}");
            assert!(filled.paths.iter().flat_map(|path| &path.points).flatten().all(|v| (0.149..9.851).contains(v)));
        }
    }

    #[test]
    fn lines_run_at_the_angle_as_it_is_seen() {
        let filled = hatched(&vec![square(0.0, 10.0)], SPACING, 30.0).unwrap();
        let steps = filled.paths[1].points.windows(2).map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]]);
        let along = steps.filter(|[x, y]| x.hypot(*y) > 2.0);
        assert!(along.into_iter().all(|[x, y]| (y / x + 30.0_f64.to_radians().tan()).abs() < 1e-6));
    }

    #[test]
    fn lines_never_cross_a_hole() {
        let mut hole = square(4.0, 2.0);
        hole.reverse();
        let filled = hatched(&vec![square(0.0, 10.0), hole], SPACING, 0.0).unwrap();
        for path in &filled.paths {
            for pair in path.points.windows(2) {
                for k in 0..=20 {
                    let p = [0, 1].map(|axis| pair[0][axis] + (pair[1][axis] - pair[0][axis]) * f64::from(k) / 20.0);
                    let to_hole = p.map(|v| (4.0 - v).max(v - 6.0).max(0.0)).iter().map(|d| d * d).sum::<f64>().sqrt();
                    assert!(to_hole > 0.135, "{p:?}");
                }
            }
        }
        // Two rims; before the hole, on its one side and behind it; and on its other side.
        assert_eq!(filled.paths.len(), 4);
    }
}
