//! Where areas are thinner than a limit, and by how much.
//!
//! # The idea
//! Moved in by half the limit and out again, an area loses what no disc of that width fits into. What is lost is a *neck* where what
//! is left of the area lies on two sides of it, a *whole* area where nothing of it is left, and otherwise a *tip*: a corner that every
//! knife rounds, or a spike. A tip counts from where it sticks out by half the limit, as corners of less than 60 degrees do.

use rayon::prelude::*;

use crate::base::{Ink, Result, distance_to_segment};
use crate::offset::{Polygon, area, intersection, offset, subtracted, united};
use crate::rules::boxes::{Bounds, Boxes};
use crate::rules::fits::{Disc, Strip, Suspects};
use crate::rules::near::nearest_on;
use kurbo::{Point, Vec2};

/// What is left is moved out by so many tolerances more than it was moved in, or what is lost would be slivers along all of its
/// outline: moving in and out simplifies and so is off by up to three.
const SLACK: f64 = 4.0;

/// Parts that are no longer than so many tolerances are none: where a disc does not fit into a neck, however short, it does not for some
/// way.
const DUST: f64 = 6.0;

/// Short parts that are no wider than so many tolerances are none either: outlines nearly lie on each other there. Where a disc does not
/// fit, that is nearly as wide as the disc on its way.
const SLIVER: f64 = 2.0;

/// Areas that are opened by a disc of this diameter, or closed, and what they have lost or gained by that.
pub(super) struct Opened {
    /// What is left of the areas that were looked at, and a hair more; or what they have become by gaining something, and a hair less.
    pub(super) areas: Vec<Polygon>,
    /// Where they were too thin, or what lies between them was.
    pub(super) thin: Vec<Polygon>,
}

impl Opened {
    /// Opens black areas on a canvas of `size`, or closes them: then what lies between them is opened. Only what comes near one of the
    /// boxes is looked at, if there are any.
    ///
    /// # Errors
    /// [`crate::Error::Input`] for coordinates that are not finite.
    pub(super) fn of(black: &[Polygon], size: [f64; 2], disc: Disc, within: Option<&Boxes>) -> Result<Self> {
        let suspects = Suspects::of(black, size, disc, within);
        if suspects.is_empty() {
            return Ok(Self { areas: Vec::new(), thin: Vec::new() });
        }
        Self::of_strips(&suspects.cut_out(black, size)?, &suspects, size[0], disc)
    }

    fn of_strips(strips: &[Strip], suspects: &Suspects, width: f64, disc: Disc) -> Result<Self> {
        let Disc { ink, diameter, tolerance } = disc;
        let of_strip = |Strip { areas: black, band }: &Strip| -> Result<Self> {
            let sign = ink.sign();
            let moved = offset(black, -sign * 0.5 * diameter, tolerance)?;
            let areas = offset(&moved, sign * (0.5 * diameter + SLACK * tolerance), tolerance)?;
            let thin = if ink == Ink::BLACK { subtracted(black, &areas)? } else { subtracted(&areas, black)? };
            let Some([top, bottom]) = *band else { return Ok(Self { areas, thin }) };
            let band = Bounds([-diameter, top, width + diameter, bottom]).area();
            Ok(Self { areas, thin: intersection(&thin, &[band])? })
        };
        let mut opened = strips.par_iter().map(of_strip).collect::<Result<Vec<_>>>()?;
        let Self { areas, mut thin } = if opened.len() == 1 {
            opened.swap_remove(0)
        } else {
            // What lies in two of them comes together again.
            let thin: Vec<Polygon> = opened.iter_mut().flat_map(|strip| std::mem::take(&mut strip.thin)).collect();
            Self { areas: opened.into_iter().flat_map(|strip| strip.areas).collect(), thin: united(&thin)? }
        };
        // Where outlines nearly lie on each other there is dust.
        thin.retain(|part| Bounds::of(&part[0]).longer_side() > DUST * tolerance && suspects.holds(part));
        Ok(Self { areas, thin })
    }

    /// The thin parts that count, and the others: corners.
    pub(super) fn apart(self, black: &[Polygon], disc: Disc) -> [Vec<Polygon>; 2] {
        let (arcs, own) = (Points::of(&self.areas), Points::of(black));
        let counts = |part: &Polygon| measured(part.clone(), &own, &arcs, disc.diameter).is_some();
        let (thin, corners) = self.thin.into_par_iter().partition(counts);
        [thin, corners]
    }

    /// What of the thin parts counts.
    fn measured(self, own: &Points, disc: Disc) -> Vec<Thin> {
        let arcs = Points::of(&self.areas);
        let parts = self.thin.into_par_iter().filter(|part| !is_sliver(part, disc));
        parts.filter_map(|part| measured(part, own, &arcs, disc.diameter)).collect()
    }
}

/// Whether a part is none: see [`SLIVER`].
fn is_sliver(part: &Polygon, disc: Disc) -> bool {
    let length = Bounds::of(&part[0]).longer_side();
    length < 0.5 * disc.diameter && area(std::slice::from_ref(part)) < SLIVER * disc.tolerance * length
}

/// What is thin, and a hair more: what is taken off areas or added to them has to lie over their outlines and not on them.
///
/// # Errors
/// As [`Opened::of`].
pub(super) fn with_rim(thin: &[Polygon], tolerance: f64) -> Result<Vec<Polygon>> {
    offset(thin, 0.5 * SLACK * tolerance, tolerance)
}

/// A part that is thinner than a limit.
#[derive(Debug, Clone)]
pub(super) struct Thin {
    /// A neck where it is narrowest, a whole area where it is widest, and the mean of a tip; mm.
    pub(super) width: f64,
    /// How far a tip sticks out, else the longer side of its bounds; mm.
    pub(super) length: f64,
    /// Where it is so wide: in it.
    pub(super) place: [f64; 2],
    /// Itself.
    pub(super) outline: Polygon,
}

/// The black parts of areas that are thinner than a limit, or the white ones between them.
///
/// # Errors
/// As [`Opened::of`].
pub(super) fn thin(black: &[Polygon], size: [f64; 2], disc: Disc) -> Result<Vec<Thin>> {
    Ok(Opened::of(black, size, disc, None)?.measured(&Points::of(black), disc))
}

/// Whether a disc does not fit somewhere: in a thin part, or in a corner that is about as sharp as a right angle.
///
/// # Errors
/// As [`Opened::of`].
pub(super) fn has_thin(black: &[Polygon], size: [f64; 2], disc: Disc) -> Result<bool> {
    let suspects = Suspects::of(black, size, disc, None);
    if suspects.is_empty() {
        return Ok(false);
    }
    let own = Points::of(black);
    // Where there is one there are mostly many: the first strips tell.
    for strips in suspects.cut_out(black, size)?.chunks(AT_ONCE) {
        let opened = Opened::of_strips(strips, &suspects, size[0], disc)?;
        let is_large = |part: &Polygon| area(std::slice::from_ref(part)) > CORNER * disc.diameter * disc.diameter;
        if opened.thin.iter().any(is_large) || !opened.measured(&own, disc).is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A corner of a right angle loses so much of the disc's square, and a half.
const CORNER: f64 = 0.035;

/// Strips that are looked at together.
const AT_ONCE: usize = 2;

/// Points that can be asked for, sorted.
struct Points {
    cells: Vec<[i64; 2]>,
}

/// Points that are so near are one: far above what operations on areas move them, far below a tolerance.
const NEAR: f64 = 1e-4;

impl Points {
    fn of(areas: &[Polygon]) -> Self {
        let mut cells: Vec<[i64; 2]> = areas.iter().flatten().flatten().map(|p| cell(*p, 0.0)).collect();
        cells.par_sort_unstable();
        Self { cells }
    }

    fn has(&self, p: [f64; 2]) -> bool {
        let [low, high] = [-0.25, 0.25].map(|by| cell(p, by));
        (low[0]..=high[0]).any(|x| (low[1]..=high[1]).any(|y| self.cells.binary_search(&[x, y]).is_ok()))
    }
}

fn cell(p: [f64; 2], by: f64) -> [i64; 2] {
    p.map(|v| (v / NEAR + by).floor() as i64)
}

/// The edge of a part, and whether it is one that the areas have themselves.
struct Edge {
    ends: [Point; 2],
    /// Which stretch of the areas' own outline; `None` where what is left begins.
    side: Option<usize>,
}

/// What a part is, if it counts.
fn measured(part: Polygon, own: &Points, arcs: &Points, diameter: f64) -> Option<Thin> {
    let mut edges: Vec<Edge> = Vec::new();
    let mut contacts = 0;
    for ring in &part {
        let n = ring.len();
        let is_own: Vec<bool> = ring.iter().map(|p| own.has(*p)).collect();
        let is_arc: Vec<bool> = (0..n).map(|i| !is_own[i] && arcs.has(ring[i])).collect();
        // An edge between two points where outlines cross is of the other kind than the one before it.
        let mut kinds: Vec<Option<bool>> = (0..n)
            .map(|i| {
                let j = (i + 1) % n;
                if is_arc[i] || is_arc[j] {
                    Some(false)
                } else if is_own[i] || is_own[j] {
                    Some(true)
                } else {
                    None
                }
            })
            .collect();
        if let Some(first) = kinds.iter().position(Option::is_some) {
            for k in 1..n {
                let (i, before) = ((first + k) % n, (first + k - 1) % n);
                if kinds[i].is_none() {
                    kinds[i] = kinds[before].map(|is_own| !is_own);
                }
            }
        }
        let own_edge = |i: usize| kinds[i].unwrap_or(true);
        let begins = (0..n).filter(|i| !own_edge(*i) && own_edge((*i + n - 1) % n)).count();
        let is_all_arc = (0..n).all(|i| !own_edge(i));
        contacts += if is_all_arc { 1 } else { begins };
        // Begins with a stretch, so that none is cut in two.
        let start = (0..n).find(|i| own_edge(*i) && !own_edge((*i + n - 1) % n)).unwrap_or(0);
        let mut side = edges.iter().filter_map(|edge| edge.side).max().map_or(0, |side| side + 1);
        let mut was_own = false;
        for k in 0..n {
            let i = (start + k) % n;
            let is_own = own_edge(i);
            side += usize::from(!is_own && was_own);
            was_own = is_own;
            let ends = [ring[i], ring[(i + 1) % n]].map(|[x, y]| Point::new(x, y));
            edges.push(Edge { ends, side: is_own.then_some(side) });
        }
    }
    let extent = Bounds::of(&part[0]).longer_side();
    let (width, length, place) = match contacts {
        0 => {
            let (width, place) = widest(&part, diameter);
            (width, extent, place)
        }
        1 => {
            let (out, tip) = sticks_out(&edges)?;
            // Corners of 60 degrees and more stick out by no more than that.
            if out <= 0.5 * diameter {
                return None;
            }
            let area: f64 = part.iter().map(|ring| crate::base::signed_area(ring)).sum();
            ((area.abs() / out).min(diameter), out, tip)
        }
        _ => {
            let (width, place) = narrowest(&edges)?;
            (width.min(diameter), extent, place)
        }
    };
    Some(Thin { width, length, place: [place.x, place.y], outline: part })
}

/// Points that are looked at along the outline of a part: of longer ones so many, evenly.
const MOST_LOOKED_AT: usize = 256;

/// The shortest way between two stretches of outline, and its middle.
fn narrowest(edges: &[Edge]) -> Option<(f64, Point)> {
    let own: Vec<(usize, [Point; 2])> = edges.iter().filter_map(|edge| Some((edge.side?, edge.ends))).collect();
    let step = own.len().div_ceil(MOST_LOOKED_AT).max(1);
    let mut best: Option<(f64, Point)> = None;
    for (side, [a, b]) in own.iter().step_by(step) {
        for p in [*a, a.midpoint(*b)] {
            for (_, [c, d]) in own.iter().filter(|(other, _)| other != side) {
                let distance = distance_to_segment(p, *c, *d);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, p.midpoint(nearest_on(p, [*c, *d]))));
                }
            }
        }
    }
    best
}

/// How far the outline lies from where what is left begins, at most, and where.
fn sticks_out(edges: &[Edge]) -> Option<(f64, Point)> {
    let contact: Vec<[Point; 2]> = edges.iter().filter(|edge| edge.side.is_none()).map(|edge| edge.ends).collect();
    let own: Vec<[Point; 2]> = edges.iter().filter(|edge| edge.side.is_some()).map(|edge| edge.ends).collect();
    let step = own.len().div_ceil(MOST_LOOKED_AT).max(1);
    let of = |p: Point| contact.iter().map(|[a, b]| distance_to_segment(p, *a, *b)).fold(f64::INFINITY, f64::min);
    let all = own.iter().step_by(step).map(|[a, _]| (of(*a), *a));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(out, _)| out.is_finite())
}

/// The diameter of the largest disc in a part that is all outline and nowhere as wide as `diameter`, and its middle: of discs that touch
/// the outline from within, no other point of it lying in them.
fn widest(part: &Polygon, diameter: f64) -> (f64, Point) {
    // Points along the outline, each with the direction of its edge, so near to each other that none is far from what is opposite.
    let mut points: Vec<(Point, Vec2)> = Vec::new();
    for ring in part {
        for (i, [x, y]) in ring.iter().enumerate() {
            let [next_x, next_y] = ring[(i + 1) % ring.len()];
            let (a, b) = (Point::new(*x, *y), Point::new(next_x, next_y));
            let length = (b - a).hypot2().sqrt();
            if length > 0.0 {
                let steps = (8.0 * length / diameter).ceil().max(1.0);
                points.extend((0..steps as usize).map(|k| (a.lerp(b, (k as f64 + 0.5) / steps), (b - a) / length)));
            }
        }
    }
    let step = points.len().div_ceil(MOST_LOOKED_AT).max(1);
    let mut best = (0.0, Point::from((part[0][0][0], part[0][0][1])));
    for (p, along) in points.iter().step_by(step) {
        // The inside lies on the left of exteriors and of holes: x right, y down.
        let inwards = Vec2::new(-along.y, along.x);
        let mut radius = 0.5 * diameter;
        for (q, _) in &points {
            let to = *q - *p;
            let depth = to.dot(inwards);
            if depth > 1e-9 {
                radius = radius.min(0.5 * to.hypot2() / depth);
            }
        }
        if 2.0 * radius > best.0 {
            best = (2.0 * radius, *p + inwards * radius);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: f64 = 0.002;
    const SIZE: [f64; 2] = [20.0, 20.0];

    fn disc(ink: Ink, diameter: f64) -> Disc {
        Disc { ink, diameter, tolerance: TOLERANCE }
    }

    fn polygon(points: &[[f64; 2]]) -> Polygon {
        vec![points.to_vec()]
    }

    /// Two squares of 4 mm that a bar joins.
    fn dumbbell(width: f64) -> Polygon {
        let (low, high) = (2.0 - 0.5 * width, 2.0 + 0.5 * width);
        polygon(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, low],
            [8.0, low],
            [8.0, 0.0],
            [12.0, 0.0],
            [12.0, 4.0],
            [8.0, 4.0],
            [8.0, high],
            [4.0, high],
            [4.0, 4.0],
            [0.0, 4.0],
        ])
    }

    #[test]
    fn a_neck_is_as_wide_as_its_bar() {
        for width in [0.1, 0.25, 0.39] {
            let found = thin(&[dumbbell(width)], SIZE, disc(Ink::BLACK, 0.4)).unwrap();
            assert_eq!(found.len(), 1, "{width}");
            assert!((found[0].width - width).abs() < 0.005, "{} for {width}", found[0].width);
            assert!((found[0].place[1] - 2.0).abs() < 0.01 && (4.0..8.0).contains(&found[0].place[0]));
        }
        assert!(thin(&[dumbbell(0.41)], SIZE, disc(Ink::BLACK, 0.4)).unwrap().is_empty());
    }

    #[test]
    fn a_gap_is_as_wide_as_it_is_white() {
        let areas = [
            polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]),
            polygon(&[[4.3, 0.0], [9.0, 0.0], [9.0, 4.0], [4.3, 4.0]]),
        ];
        let found = thin(&areas, SIZE, disc(Ink::WHITE, 0.4)).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].width - 0.3).abs() < 0.005, "{}", found[0].width);
        assert!(thin(&areas, SIZE, disc(Ink::WHITE, 0.29)).unwrap().is_empty());
    }

    #[test]
    fn what_is_thin_everywhere_is_as_wide_as_its_largest_disc() {
        for (points, width) in [
            (polygon(&[[0.0, 0.0], [6.0, 0.0], [6.0, 0.2], [0.0, 0.2]]), 0.2),
            (polygon(&crate::base::circle_polygon([3.0, 3.0], 0.15, 0.001)), 0.3),
        ] {
            let found = thin(&[points], SIZE, disc(Ink::BLACK, 0.4)).unwrap();
            assert_eq!(found.len(), 1);
            assert!((found[0].width - width).abs() < 0.02, "{} for {width}", found[0].width);
        }
        // A ring: all of it is outline, too.
        let mut ring = polygon(&crate::base::circle_polygon([3.0, 3.0], 2.0, 0.001));
        ring.push(crate::base::circle_polygon([3.0, 3.0], 1.75, 0.001).into_iter().rev().collect());
        let found = thin(&[ring], SIZE, disc(Ink::BLACK, 0.4)).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].width - 0.25).abs() < 0.02, "{}", found[0].width);
    }

    #[test]
    fn corners_count_when_they_are_sharper_than_60_degrees() {
        for (height, counts) in [(4.0, true), (1.3, true), (1.0, false), (0.5, false)] {
            // A triangle on a broad base: the angle at its tip is twice atan(1 / height) of the half base.
            let half = 0.6;
            let tip = [polygon(&[
                [0.0, 0.0],
                [10.0, 0.0],
                [10.0, -4.0],
                [5.0 + half, -4.0],
                [5.0, -4.0 - height],
                [5.0 - half, -4.0],
                [0.0, -4.0],
            ])];
            let tip: Vec<Polygon> = tip.iter().map(|area| vec![area[0].iter().rev().copied().collect()]).collect();
            let found = thin(&tip, SIZE, disc(Ink::BLACK, 0.4)).unwrap();
            assert_eq!(found.len(), usize::from(counts), "{height}");
            assert!(found.iter().all(|thin| (thin.place[1] + 4.0 + height).abs() < 1e-3));
        }
    }
}
