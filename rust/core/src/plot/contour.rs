//! Areas filled by lines that run along their outlines, one inside the other, joined to as few lines as can be.
//!
//! # Joined
//! A point of an inset lies as far from the rings that it was made from as the lines lie apart. So each ring is joined to those around
//! it by a short way across, where nothing but the area lies: a line goes along a ring, across to a ring inside it, along that and back.
//! The rings and the ways across are a tree, and the line around a tree is closed; of an area that nowhere is narrower than the pen it
//! is one. Ways are drawn twice, which shows as little as what overlaps, and so are lines in places that no ring has room in.

use std::collections::HashMap;

use kurbo::Point;

use crate::base::{Control, Result};
use crate::offset::{Polygon, SIMPLIFIED, offset};
use crate::plot::middle::middles;
use crate::plot::path::Path;

/// How the lines of a fill lie, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spacing {
    /// Width of the pen.
    pub(super) pen: f64,
    /// From the middle of a line to that of the next.
    pub(super) apart: f64,
    /// From the edge of an area to the middle of the first line inside it.
    pub(super) inset: f64,
}

/// What fills an area.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Filled {
    pub(super) paths: Vec<Path>,
    /// How many of them are drawn along the middle of what is narrower than the pen.
    pub(super) thin: usize,
}

/// How far a way across may be longer than lines lie apart: rings are simplified.
const ACROSS: f64 = 4.0 * SIMPLIFIED;

/// Fills one polygon by insets.
///
/// # Errors
/// As [`offset`] and [`middles`].
pub(super) fn contours(polygon: &Polygon, spacing: Spacing, control: &Control) -> Result<Filled> {
    let Outlined { rims: mut level, mut lines, thin } = outlined(polygon, spacing)?;
    let mut nest = Nest::default();
    let mut outer = 0..0;
    while !level.is_empty() {
        control.check()?;
        let inner = nest.add(level.iter().flatten().cloned());
        nest.join(&outer, &inner, spacing.apart + ACROSS);
        let lines = nest.add(between(&level, spacing)?.into_iter().map(there_and_back));
        nest.join(&inner, &lines, spacing.apart + ACROSS);
        outer = inner;
        level = offset(&level, -spacing.apart, SIMPLIFIED)?;
    }
    let mut paths = nest.paths();
    paths.append(&mut lines);
    Ok(Filled { paths, thin })
}

/// A line as a ring that goes along it and back.
fn there_and_back(line: Path) -> Vec<[f64; 2]> {
    let mut ring = line.points;
    if !line.is_closed && ring.len() > 2 {
        let back: Vec<[f64; 2]> = ring[1..ring.len() - 1].iter().rev().copied().collect();
        ring.extend(back);
    }
    ring
}

/// Lines where the next ones, within these, would leave a gap: there is no room for them, but more than these cover.
///
/// # Errors
/// As [`middles`].
pub(super) fn between(rims: &[Polygon], spacing: Spacing) -> Result<Vec<Path>> {
    let mut lines = Vec::new();
    for polygon in rims {
        lines.append(&mut middles(polygon, spacing.pen, 2.0 * spacing.apart)?);
    }
    Ok(lines)
}

/// The rim of an area, and what of it is narrower than the pen.
pub(super) struct Outlined {
    /// The area within the middle of the first line.
    pub(super) rims: Vec<Polygon>,
    /// Lines along the middles of what is narrower than the pen, and how many.
    pub(super) lines: Vec<Path>,
    pub(super) thin: usize,
}

/// Insets a polygon by the first line, and finds what of it is too narrow for that.
///
/// # Errors
/// As [`contours`].
pub(super) fn outlined(polygon: &Polygon, spacing: Spacing) -> Result<Outlined> {
    let rims = offset(std::slice::from_ref(polygon), -spacing.inset, SIMPLIFIED)?;
    let mut lines = middles(polygon, 0.0, 2.0 * spacing.inset)?;
    if rims.is_empty() && lines.is_empty() {
        lines.push(Path { points: vec![inner_point(polygon)], is_closed: false });
    }
    Ok(Outlined { rims, thin: lines.len(), lines })
}

/// A point in the middle of a polygon that is hardly larger than the pen: its centroid, or where it is not inside, the corner nearest it.
fn inner_point(polygon: &Polygon) -> [f64; 2] {
    let exterior = &polygon[0];
    let (mut area, mut centre) = (0.0, [0.0; 2]);
    for (k, [x, y]) in exterior.iter().enumerate() {
        let [next_x, next_y] = exterior[(k + 1) % exterior.len()];
        let cross = x * next_y - next_x * y;
        area += cross;
        centre = [centre[0] + cross * (x + next_x), centre[1] + cross * (y + next_y)];
    }
    let centre = if area == 0.0 { exterior[0] } else { centre.map(|sum| sum / (3.0 * area)) };
    if contains(exterior, centre) {
        return centre;
    }
    let distance = |p: &[f64; 2]| (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2);
    exterior.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(centre)
}

/// Whether a point lies in a ring.
fn contains(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let crosses = |k: usize| {
        let ([x0, y0], [x1, y1]) = (ring[k], ring[(k + 1) % ring.len()]);
        (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    };
    (0..ring.len()).filter(|k| crosses(*k)).count() % 2 == 1
}

/// All rings of a fill, and the ways between them.
#[derive(Default)]
struct Nest {
    rings: Vec<Vec<[f64; 2]>>,
    ways: Vec<[End; 2]>,
    /// A forest: every ring points to another one that it is joined to, roots to themselves.
    joined: Vec<usize>,
}

/// Where a way begins or ends: a place on the side of a ring that begins at its point of this number.
#[derive(Clone, Copy)]
struct End {
    ring: usize,
    side: usize,
    at: [f64; 2],
}

/// A place where the line around a tree comes by; and the way that leads away there, by the number of this end of it.
#[derive(Clone, Copy)]
struct Stop {
    at: [f64; 2],
    way: Option<usize>,
}

impl Nest {
    /// Adds rings; returns their numbers.
    fn add(&mut self, rings: impl Iterator<Item = Vec<[f64; 2]>>) -> std::ops::Range<usize> {
        let first = self.rings.len();
        self.rings.extend(rings);
        self.joined.extend(first..self.rings.len());
        first..self.rings.len()
    }

    fn root(&mut self, mut ring: usize) -> usize {
        while self.joined[ring] != ring {
            self.joined[ring] = self.joined[self.joined[ring]];
            ring = self.joined[ring];
        }
        ring
    }

    /// Joins the rings of a level to those of the level around it that lie within `reach` of one of their points.
    fn join(&mut self, outer: &std::ops::Range<usize>, inner: &std::ops::Range<usize>, reach: f64) {
        if outer.is_empty() || inner.is_empty() {
            return;
        }
        let sides = Sides::of(&self.rings, outer.clone(), reach);
        for ring in inner.clone() {
            for side in 0..self.rings[ring].len() {
                let at = self.rings[ring][side];
                let Some(end) = sides.nearest(&self.rings, at, reach) else { continue };
                let (a, b) = (self.root(ring), self.root(end.ring));
                if a != b {
                    self.joined[a.max(b)] = a.min(b);
                    self.ways.push([end, End { ring, side, at }]);
                }
            }
        }
    }

    /// The closed lines around the trees of rings and ways, from the outermost rings.
    fn paths(&self) -> Vec<Path> {
        // Number 2w is the first end of way w, 2w + 1 its second: one is the other's number with its last bit turned.
        let ends: Vec<End> = self.ways.iter().flatten().copied().collect();
        let mut of_ring: Vec<Vec<usize>> = vec![Vec::new(); self.rings.len()];
        for (number, end) in ends.iter().enumerate() {
            of_ring[end.ring].push(number);
        }
        // Where among the stops of its ring each end is.
        let mut places = vec![0; ends.len()];
        let stops: Vec<Vec<Stop>> = self
            .rings
            .iter()
            .zip(&mut of_ring)
            .map(|(points, numbers)| {
                let along = |end: &End| {
                    let [x, y] = points[end.side];
                    (end.at[0] - x).powi(2) + (end.at[1] - y).powi(2)
                };
                let by_place = |a: &usize, b: &usize| {
                    let (a, b) = (&ends[*a], &ends[*b]);
                    a.side.cmp(&b.side).then(along(a).total_cmp(&along(b)))
                };
                numbers.sort_by(by_place);
                let mut numbers = numbers.iter().peekable();
                let mut stops = Vec::with_capacity(points.len() + numbers.len());
                for (side, point) in points.iter().enumerate() {
                    stops.push(Stop { at: *point, way: None });
                    while let Some(&number) = numbers.next_if(|number| ends[**number].side == side) {
                        places[number] = stops.len();
                        stops.push(Stop { at: ends[number].at, way: Some(number) });
                    }
                }
                stops
            })
            .collect();
        let mut is_done = vec![false; self.rings.len()];
        let mut paths = Vec::new();
        for root in 0..self.rings.len() {
            if !is_done[root] {
                let points = around(root, &ends, &places, &stops, &mut is_done);
                // A line of two points, or of one, that no ring is near enough to is itself.
                paths.push(Path { is_closed: points.len() > 2, points });
            }
        }
        paths
    }
}

/// The line around the tree of a ring: along each ring from where it is come to until there again, and across at every way.
fn around(root: usize, ends: &[End], places: &[usize], stops: &[Vec<Stop>], is_done: &mut [bool]) -> Vec<[f64; 2]> {
    /// A ring that is walked along: how many stops were made since the first.
    struct Walk {
        ring: usize,
        first: usize,
        made: usize,
    }
    let mut line: Vec<[f64; 2]> = Vec::new();
    let mut walks = vec![Walk { ring: root, first: 0, made: 0 }];
    is_done[root] = true;
    while let Some(walk) = walks.last_mut() {
        let stops = &stops[walk.ring];
        // After the last stop it is at the first again.
        let stop = stops[(walk.first + walk.made) % stops.len()];
        if line.last() != Some(&stop.at) {
            line.push(stop.at);
        }
        walk.made += 1;
        if walk.made > stops.len() {
            walks.pop();
            // Back to where the way across began, which is the last stop that was made there.
            if let Some(walk) = walks.last_mut() {
                walk.made -= 1;
            }
            continue;
        }
        let beyond = stop.way.map(|number| number ^ 1).filter(|number| !is_done[ends[*number].ring]);
        if let Some(number) = beyond {
            is_done[ends[number].ring] = true;
            walks.push(Walk { ring: ends[number].ring, first: places[number], made: 0 });
        }
    }
    if line.len() > 1 && line.first() == line.last() {
        line.pop();
    }
    line
}

/// The sides of rings in square bins.
struct Sides {
    bin: f64,
    bins: HashMap<[i64; 2], Vec<(usize, usize)>>,
}

impl Sides {
    fn of(rings: &[Vec<[f64; 2]>], outer: std::ops::Range<usize>, reach: f64) -> Self {
        let mut sides = Self { bin: reach, bins: HashMap::new() };
        for ring in outer {
            let points = &rings[ring];
            for (side, from) in points.iter().enumerate() {
                let to = points[(side + 1) % points.len()];
                for bin in sides.touched(*from, to) {
                    sides.bins.entry(bin).or_default().push((ring, side));
                }
            }
        }
        sides
    }

    fn bin_of(&self, [x, y]: [f64; 2]) -> [i64; 2] {
        [x, y].map(|v| (v / self.bin).floor() as i64)
    }

    /// The bins along a side: those of points on it that are less than a bin apart.
    fn touched(&self, from: [f64; 2], to: [f64; 2]) -> Vec<[i64; 2]> {
        let length = ((to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2)).sqrt();
        let parts = (2.0 * length / self.bin).ceil().max(1.0);
        let at = |k: usize| self.bin_of([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * k as f64 / parts));
        let mut bins: Vec<[i64; 2]> = (0..=parts as usize).map(at).collect();
        bins.dedup();
        bins
    }

    /// The nearest place on a side within reach.
    fn nearest(&self, rings: &[Vec<[f64; 2]>], from: [f64; 2], reach: f64) -> Option<End> {
        let [column, row] = self.bin_of(from);
        let mut found: Option<(f64, End)> = None;
        for bin in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [column + dx, row + dy])) {
            for &(ring, side) in self.bins.get(&bin).into_iter().flatten() {
                let points = &rings[ring];
                let at = foot(from, points[side], points[(side + 1) % points.len()]);
                let distance = (at[0] - from[0]).powi(2) + (at[1] - from[1]).powi(2);
                // A side is found in every bin that it touches; of two as near it is the first.
                let is_nearer = found.is_none_or(|(least, end)| (distance, ring, side) < (least, end.ring, end.side));
                if distance <= reach * reach && is_nearer {
                    found = Some((distance, End { ring, side, at }));
                }
            }
        }
        found.map(|(_, end)| end)
    }
}

/// The point of a side nearest to another.
fn foot(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let [p, a, b] = [p, a, b].map(|[x, y]| Point::new(x, y));
    let along = b - a;
    let t = ((p - a).dot(along) / along.hypot2()).clamp(0.0, 1.0);
    let at = if t.is_nan() { a } else { a + along * t };
    [at.x, at.y]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING: Spacing = Spacing { pen: 0.3, apart: 0.27, inset: 0.15 };

    fn square(left: f64, side: f64, turn: bool) -> Vec<[f64; 2]> {
        let mut ring = vec![[left, left], [left + side, left], [left + side, left + side], [left, left + side]];
        if turn {
            ring.reverse();
        }
        ring
    }

    fn length(path: &Path) -> f64 {
        let closing = if path.is_closed { path.points.first() } else { None };
        let points: Vec<&[f64; 2]> = path.points.iter().chain(closing).collect();
        points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
    }

    #[test]
    fn a_square_is_filled_by_one_line() {
        let filled = contours(&vec![square(0.0, 10.0, false)], SPACING, &Control::new()).unwrap();
        assert_eq!((filled.paths.len(), filled.thin), (1, 0));
        // The last ring leaves a place in the middle.
        assert!(filled.paths[0].points.iter().any(|p| p.iter().all(|v| (v - 5.0).abs() < 0.1)));
        // Lines cover the square, each a pen wide less what overlaps.
        let covered = length(&filled.paths[0]) * SPACING.apart;
        assert!((98.0..104.0).contains(&covered), "{covered}");
        assert!(filled.paths[0].points.iter().flatten().all(|v| (0.149..9.851).contains(v)));
    }

    #[test]
    fn holes_stay_open_and_all_rings_are_joined() {
        let filled = contours(&vec![square(0.0, 10.0, false), square(4.0, 2.0, true)], SPACING, &Control::new()).unwrap();
        assert_eq!(filled.paths.iter().filter(|path| path.is_closed).count(), 1);
        let path = &filled.paths[0];
        let to_hole = |p: &[f64; 2]| p.map(|v| (4.0 - v).max(v - 6.0).max(0.0)).iter().map(|d| d * d).sum::<f64>().sqrt();
        assert!(path.points.iter().all(|p| to_hole(p) > 0.135));
        let covered = length(path) * SPACING.apart;
        assert!((94.0..107.0).contains(&covered), "{covered}");
    }

    #[test]
    fn what_is_narrower_than_the_pen_is_one_line_and_counted() {
        let strip = vec![vec![[0.0, 0.0], [10.0, 0.0], [10.0, 0.2], [0.0, 0.2]]];
        let filled = contours(&strip, SPACING, &Control::new()).unwrap();
        assert_eq!((filled.paths.len(), filled.thin), (1, 1));
        let speck = vec![square(3.0, 0.1, false)];
        let filled = contours(&speck, SPACING, &Control::new()).unwrap();
        let [Path { points, is_closed: false }] = &filled.paths[..] else { panic!("{filled:?}") };
        assert!(points.len() == 1 && points[0].iter().all(|v| (v - 3.05).abs() < 1e-9) && filled.thin == 1, "{filled:?}");
    }

    #[test]
    fn wide_strips_have_lines_between_where_no_ring_fits() {
        // Two lines at the rims leave a gap of .21 mm.
        let strip = vec![vec![[0.0, 0.0], [10.0, 0.0], [10.0, 0.81], [0.0, 0.81]]];
        let filled = contours(&strip, SPACING, &Control::new()).unwrap();
        assert_eq!(filled.paths.len(), 1, "{filled:?}");
        let middle = filled.paths[0].points.iter().filter(|p| (p[1] - 0.405).abs() < 0.03);
        assert!(middle.count() >= 2, "{filled:?}");
    }

    #[test]
    fn a_line_goes_there_and_back() {
        for count in 1..7 {
            let points: Vec<[f64; 2]> = (0..count).map(|k| [f64::from(k), 0.0]).collect();
            let expected: Vec<f64> = (0..count).chain((1..count - 1).rev()).map(f64::from).collect();
            let ring = there_and_back(Path { points, is_closed: false });
            assert_eq!(ring.iter().map(|p| p[0]).collect::<Vec<f64>>(), expected);
        }
    }
}
