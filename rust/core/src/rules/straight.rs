//! Straight bridges: the islands between black polygons joined to the sheet by cutting through where black is thinnest. In: polygons,
//! which have no graph; out: polygons without islands.
//!
//! # The idea
//! Every hole of a polygon is an island. All of a polygon's holes are joined to one another and to what is around the polygon by the
//! shortest bridges that do it, the minimum spanning tree of its rings: so in the end all white is joined, as what is around one polygon
//! is held or is the hole of another one. The shortest bridges are edges of a Delaunay triangulation of points along the rings.

use rayon::prelude::*;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use crate::base::{Control, Error, Pool, Result};
use crate::offset::{Polygon, area, subtracted};
use crate::rules::bridging::{Bridge, Bridged, Bridging};
use crate::rules::nesting::{containers, white_areas};
use crate::rules::steiner::Sets;

/// Points along rings lie no farther apart than this part of a bridge's width, unless there would be too many.
const STEP: f64 = 0.5;

/// The most points along rings, for each that they have anyway, and at least so many.
const MOST_A_POINT: f64 = 8.0;
const LEAST_POINTS: f64 = 4096.0;

/// Bridges are this part wider than asked for, so that no rounding makes them narrower.
const SPARE: f64 = 1e-3;

/// Rings nearer to each other than this part of a bridge's width touch.
const TOUCHING: f64 = 1e-6;

/// Numbers closer to 0 than this are 0 to the triangulation, which takes none so small.
const TINY: f64 = 1e-40;

/// How far bridges reach into white, in their widths: with less, one that ends at a corner would be narrower there; more would cut into
/// what is black beyond.
const REACH: f64 = 0.9;

/// What bridges cut off goes too if it has less area than this, in squares of their width: no machine holds it.
const CRUMB: f64 = 0.25;

/// Joins the islands between black polygons, which are disjoint, to the sheet around them. `frame` is the width and height of the canvas
/// that the tone is reckoned for.
///
/// # Errors
/// [`Error::Option`] if a setting is out of its range, [`Error::Input`] if a coordinate is not finite, [`Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of points, and of those that rings take at half a bridge's width from each other.
pub fn straight(black: &[Polygon], frame: [f64; 2], bridging: &Bridging, control: &Control) -> Result<(Vec<Polygon>, Bridged)> {
    bridging.check()?;
    if !black.iter().flatten().flatten().flatten().all(|value| value.is_finite()) {
        return Err(Error::Input("an area has a coordinate that is not finite".to_owned()));
    }
    let (polygons, dropped) = without_small(black, bridging.min_area);
    control.check()?;
    let with_holes: Vec<&Polygon> = polygons.iter().filter(|polygon| polygon.len() > 1).collect();
    let bridged = with_holes.iter().map(|polygon| polygon.len() - 1).sum();
    let joined = |polygon: &&Polygon| {
        control.check()?;
        joints(polygon, bridging.width)
    };
    let joints = Pool::new(None).run(|| with_holes.par_iter().map(joined).collect::<Result<Vec<_>>>())?;
    let joints: Vec<Joint> = joints.into_iter().flatten().collect();
    control.check()?;
    let cuts: Vec<Polygon> = joints.iter().map(|joint| joint.cut(bridging.width)).collect();
    let left = if cuts.is_empty() {
        polygons
    } else {
        without_crumbs(subtracted(&polygons, &cuts)?, &cuts, CRUMB * bridging.width * bridging.width)
    };
    let bridges = joints.iter().map(|joint| Bridge { points: joint.ends.to_vec(), length: joint.length() }).collect();
    let canvas = frame[0] * frame[1];
    let tone = if canvas > 0.0 { (area(black) - area(&left)) / canvas } else { 0.0 };
    Ok((left, Bridged { dropped, bridged, bridges, tone }))
}

/// The polygons without the holes whose white has less area, and how many these were. What lay in such a hole is one with what was
/// around it.
fn without_small(black: &[Polygon], least: f64) -> (Vec<Polygon>, usize) {
    let containers = containers(black);
    let areas = white_areas(black, &containers);
    let is_small = |(polygon, ring): (u32, u32)| areas[polygon as usize][ring as usize - 1] < least;
    // The polygon that each is a part of.
    let whole = |polygon: u32| {
        let mut whole = polygon;
        while let Some(hole) = containers[whole as usize].filter(|hole| is_small(*hole)) {
            whole = hole.0;
        }
        whole
    };
    let mut polygons: Vec<Polygon> = black.iter().map(|polygon| polygon.iter().take(1).cloned().collect()).collect();
    let mut dropped = 0;
    for (polygon, rings) in (0u32..).zip(black) {
        let part_of = whole(polygon);
        for (ring, points) in (0u32..).zip(rings).skip(1) {
            if is_small((polygon, ring)) {
                dropped += 1;
            } else {
                polygons[part_of as usize].push(points.clone());
            }
        }
    }
    let is_whole = |polygon: usize| whole(polygon as u32) as usize == polygon;
    let left = polygons.into_iter().enumerate().filter(|(polygon, rings)| !rings.is_empty() && is_whole(*polygon));
    (left.map(|(_, rings)| rings).collect(), dropped)
}

/// A point on a ring: its place, the ring, and the point of the ring that it is or comes after.
#[derive(Clone, Copy)]
struct OnRing {
    place: [f64; 2],
    ring: u32,
    first: u32,
}

impl HasPosition for OnRing {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.place[0], self.place[1])
    }
}

/// The shortest bridges that join all rings of a polygon.
fn joints(polygon: &Polygon, width: f64) -> Result<Vec<Joint>> {
    let mut points = points_along(polygon, STEP * width);
    points.sort_by(|a, b| {
        let by_place = a.place[0].total_cmp(&b.place[0]).then(a.place[1].total_cmp(&b.place[1]));
        by_place.then((a.ring, a.first).cmp(&(b.ring, b.first)))
    });
    // Rings that touch are one bridge without a length apart. The mesh takes one point a place.
    let mut ways: Vec<[OnRing; 2]> =
        points.windows(2).filter(|pair| pair[0].place == pair[1].place).map(|pair| [pair[0], pair[1]]).collect();
    points.dedup_by(|later, kept| later.place == kept.place);
    let refused = |error| Error::Internal(format!("the triangulation refused the points of a polygon: {error}"));
    let mesh = DelaunayTriangulation::<OnRing>::bulk_load(points).map_err(refused)?;
    ways.extend(mesh.undirected_edges().map(|edge| edge.vertices().map(|vertex| *vertex.data())));
    ways.retain(|[a, b]| a.ring != b.ring);
    let mut ways: Vec<(f64, [OnRing; 2])> = ways
        .into_iter()
        .map(|[a, b]| (distance(a.place, b.place), if (a.ring, a.first) <= (b.ring, b.first) { [a, b] } else { [b, a] }))
        .collect();
    let key = |[a, b]: &[OnRing; 2]| [a.ring, a.first, b.ring, b.first];
    let places = |[a, b]: &[OnRing; 2]| [a.place[0], a.place[1], b.place[0], b.place[1]];
    ways.sort_by(|(a, from), (b, to)| {
        let by_place = places(from).into_iter().zip(places(to)).map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne());
        a.total_cmp(b).then(key(from).cmp(&key(to))).then(by_place.unwrap_or(std::cmp::Ordering::Equal))
    });
    let mut sets = Sets::new(polygon.len());
    let chosen = ways.into_iter().filter(|(_, [a, b])| sets.join(a.ring, b.ring));
    Ok(chosen.map(|(_, points)| Joint::of(polygon, points, width)).collect())
}

/// Points along all rings, no farther apart than the step: the rings' own, and others between.
fn points_along(polygon: &Polygon, step: f64) -> Vec<OnRing> {
    let edges = || {
        (0u32..)
            .zip(polygon)
            .flat_map(|(ring, points)| (0..points.len()).map(move |k| (ring, k as u32, points[k], points[(k + 1) % points.len()])))
    };
    let (count, whole) = edges().fold((0.0, 0.0), |(count, whole), (_, _, a, b)| (count + 1.0, whole + distance(a, b)));
    let step = step.max(whole / (MOST_A_POINT * count + LEAST_POINTS));
    let mut points = Vec::new();
    for (ring, first, a, b) in edges() {
        let pieces = (distance(a, b) / step).ceil().max(1.0);
        let settled = |v: f64| if v.abs() < TINY { 0.0 } else { v };
        let at = |k: usize| [0, 1].map(|axis| settled(a[axis] + (b[axis] - a[axis]) * (k as f64 / pieces)));
        points.extend((0..pieces as usize).map(|k| OnRing { place: at(k), ring, first }));
    }
    points
}

/// Where a bridge is cut.
struct Joint {
    /// Its ends, on the edges of two rings.
    ends: [[f64; 2]; 2],
    /// The direction from one to the other, of length 1.
    along: [f64; 2],
}

impl Joint {
    /// The bridge between two points of rings, moved along the edges beside these to where it is shortest.
    fn of(polygon: &Polygon, points: [OnRing; 2], width: f64) -> Self {
        let edges_beside = |point: &OnRing| -> [[[f64; 2]; 2]; 2] {
            let ring = &polygon[point.ring as usize];
            let (first, count) = (point.first as usize, ring.len());
            [first + count - 1, first].map(|k| [ring[k % count], ring[(k + 1) % count]])
        };
        let nearest = |point: &OnRing, to: [f64; 2]| {
            let [before, after] = edges_beside(point).map(|[a, b]| foot(to, a, b));
            if distance(to, after) <= distance(to, before) { after } else { before }
        };
        let mut ends = points.map(|point| point.place);
        // The second of them comes as near as the first one's edges let it, and the other way round.
        for _ in 0..4 {
            ends[0] = nearest(&points[0], ends[1]);
            ends[1] = nearest(&points[1], ends[0]);
        }
        let direction = |[a, b]: [[f64; 2]; 2]| {
            let length = distance(a, b);
            [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
        };
        if distance(ends[0], ends[1]) > TOUCHING * width {
            let along = direction(ends);
            // Between straight edges it may be elsewhere as well: not where half of it goes past the corner of an island.
            let moved = |by: f64| {
                let to = ends.map(|[x, y]| [x - by * along[1], y + by * along[0]]);
                let is_on = |k: usize| distance(nearest(&points[k], to[k]), to[k]) <= TOUCHING * width;
                (is_on(0) && is_on(1)).then_some(to)
            };
            let ends = match [moved(0.5 * width), moved(-0.5 * width)] {
                [Some(to), None] | [None, Some(to)] => to,
                _ => ends,
            };
            return Self { along, ends };
        }
        // Where rings touch, across the first of them.
        let [_, edge] = edges_beside(&points[0]);
        let [x, y] = direction(edge);
        Self { ends, along: if (x + y).is_finite() { [-y, x] } else { [1.0, 0.0] } }
    }

    fn length(&self) -> f64 {
        distance(self.ends[0], self.ends[1])
    }

    /// What is cut away: it reaches into white on both sides, so that the bridge is as wide where it begins.
    fn cut(&self, width: f64) -> Polygon {
        let ([a, b], [x, y]) = (self.ends, self.along);
        let (half, reach) = (0.5 * width * (1.0 + SPARE), REACH * width);
        let corner = |p: [f64; 2], forwards: f64, sideways: f64| {
            let (forwards, sideways) = (forwards * reach, sideways * half);
            [p[0] + forwards * x - sideways * y, p[1] + forwards * y + sideways * x]
        };
        vec![vec![corner(a, -1.0, -1.0), corner(b, 1.0, -1.0), corner(b, 1.0, 1.0), corner(a, -1.0, 1.0)]]
    }
}

/// The point of a segment that is nearest to another one.
fn foot(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let part = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / square;
    let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
    [a[0] + part * along[0], a[1] + part * along[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}

/// The polygons but for those of less area that were cut off: one of their points lies on the rim of a cut.
fn without_crumbs(polygons: Vec<Polygon>, cuts: &[Polygon], least: f64) -> Vec<Polygon> {
    let near = Squares::of(cuts);
    let is_on_rim = |p: &[f64; 2]| {
        near.at(*p).any(|rim| {
            let spare = 1e-3 * distance(rim[1], rim[2]);
            (0..4).any(|k| distance(foot(*p, rim[k], rim[(k + 1) % 4]), *p) <= spare)
        })
    };
    let is_crumb = |polygon: &Polygon| area(std::slice::from_ref(polygon)) < least && polygon.iter().flatten().any(is_on_rim);
    polygons.into_iter().filter(|polygon| !is_crumb(polygon)).collect()
}

/// Cuts by the squares of a grid that they come into.
struct Squares<'a> {
    cuts: &'a [Polygon],
    side: f64,
    /// Square and cut, in order.
    entries: Vec<([i64; 2], u32)>,
}

impl<'a> Squares<'a> {
    fn of(cuts: &'a [Polygon]) -> Self {
        let whole: f64 = cuts.iter().map(|cut| distance(cut[0][0], cut[0][2])).sum();
        // As large as cuts are on average: then few come into many squares.
        let side = (whole / cuts.len().max(1) as f64).max(f64::MIN_POSITIVE);
        let mut squares = Self { cuts, side, entries: Vec::new() };
        for (number, cut) in (0u32..).zip(cuts) {
            let [a, b, c, d] = cut[0][..] else { continue };
            let spare = 1e-3 * distance(b, c);
            // Piece by piece, as the box of a long one that lies aslant is large.
            let pieces = (distance(a, b) / side).ceil().max(1.0);
            let at = |from: [f64; 2], to: [f64; 2], k: f64| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * (k / pieces));
            for k in (0..pieces as usize).map(|k| k as f64) {
                let corners = [at(a, b, k), at(a, b, k + 1.0), at(d, c, k), at(d, c, k + 1.0)];
                let end =
                    |axis: usize, pick: fn(f64, f64) -> f64| corners.iter().map(|corner| corner[axis]).fold(corners[0][axis], pick);
                let low = [0, 1].map(|axis| squares.along(end(axis, f64::min) - spare));
                let high = [0, 1].map(|axis| squares.along(end(axis, f64::max) + spare));
                let within = (low[0]..=high[0]).flat_map(|column| (low[1]..=high[1]).map(move |row| [column, row]));
                squares.entries.extend(within.map(|square| (square, number)));
            }
        }
        squares.entries.sort_unstable();
        squares.entries.dedup();
        squares
    }

    fn along(&self, value: f64) -> i64 {
        (value / self.side).floor() as i64
    }

    /// The cuts that may be at a point.
    fn at(&self, point: [f64; 2]) -> impl Iterator<Item = &'a [[f64; 2]]> {
        let square = point.map(|value| self.along(value));
        let first = self.entries.partition_point(|(other, _)| *other < square);
        let entries = self.entries[first..].iter().take_while(move |(other, _)| *other == square);
        entries.map(|(_, cut)| self.cuts[*cut as usize][0].as_slice())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::offset::closed;
    use crate::rules::islands::islands_between;

    fn rectangle(left: f64, top: f64, width: f64, height: f64) -> Vec<[f64; 2]> {
        vec![[left, top], [left + width, top], [left + width, top + height], [left, top + height]]
    }

    fn hole(left: f64, top: f64, width: f64, height: f64) -> Vec<[f64; 2]> {
        rectangle(left, top, width, height).into_iter().rev().collect()
    }

    fn joined(black: &[Polygon], min_area: f64, width: f64) -> (Vec<Polygon>, Bridged) {
        let made = straight(black, [100.0, 100.0], &Bridging { min_area, width }, &Control::new()).unwrap();
        assert!(made.0.iter().all(|polygon| polygon.len() == 1), "a hole is left");
        made
    }

    #[test]
    fn holes_are_joined_by_the_shortest_bridges() {
        let sheet = vec![rectangle(0.0, 0.0, 100.0, 100.0), hole(10.0, 40.0, 20.0, 20.0), hole(35.0, 30.0, 20.0, 40.0)];
        let (left, told) = joined(std::slice::from_ref(&sheet), 0.0, 2.0);
        // From the first one to the left and to the second one, straight.
        let mut lengths: Vec<f64> = told.bridges.iter().map(|bridge| bridge.length).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [5.0, 10.0]);
        let expected = 10_000.0 - 400.0 - 800.0 - 2.0 * 15.0;
        assert!((area(&left) - expected).abs() < 0.1, "{}", area(&left));
        assert!((told.tone - 30.0 / 10_000.0).abs() < 1e-5 && (told.dropped, told.bridged) == (0, 2));
        // A gap that is closed by half of its width or more is too narrow.
        assert!(closed(&left, 0.99, 1e-3).unwrap().iter().all(|polygon| polygon.len() == 1));
        assert_eq!(closed(&left, 1.01, 1e-3).unwrap().iter().map(|polygon| polygon.len() - 1).sum::<usize>(), 2);
    }

    #[test]
    fn a_bridge_at_a_corner_is_as_broad() {
        let diamond = vec![[50.0, 20.0], [40.0, 30.0], [50.0, 40.0], [60.0, 30.0]];
        let (left, told) = joined(&[vec![rectangle(0.0, 0.0, 100.0, 100.0), diamond]], 0.0, 4.0);
        assert_eq!(told.bridges[0].length, 20.0);
        assert!(closed(&left, 1.98, 1e-3).unwrap().iter().all(|polygon| polygon.len() == 1));
    }

    #[test]
    fn a_round_island_is_joined_as_broad_as_a_bridge() {
        let round: Vec<[f64; 2]> = crate::base::circle_polygon([50.0, 50.0], 3.0, 1e-3).into_iter().rev().collect();
        let (left, told) = joined(&[vec![rectangle(0.0, 0.0, 100.0, 100.0), round]], 0.0, 4.0);
        assert!((told.bridges[0].length - 47.0).abs() < 0.01);
        assert!(closed(&left, 1.98, 1e-3).unwrap().iter().all(|polygon| polygon.len() == 1));
    }

    #[test]
    fn small_islands_go_with_what_is_black_in_them() {
        // A thin ring around a disc with a large hole, which stays; and one that goes with all that is in it.
        let black = [
            vec![rectangle(0.0, 0.0, 100.0, 100.0), hole(10.0, 10.0, 40.0, 40.0), hole(70.0, 70.0, 5.0, 5.0)],
            vec![rectangle(11.0, 11.0, 38.0, 38.0), hole(15.0, 15.0, 30.0, 30.0)],
            vec![rectangle(71.0, 71.0, 3.0, 3.0), hole(72.0, 72.0, 1.0, 1.0)],
            vec![rectangle(20.0, 20.0, 5.0, 5.0)],
        ];
        assert_eq!(islands_between(&black).iter().map(|island| island.area).collect::<Vec<f64>>(), [156.0, 875.0, 16.0, 1.0]);
        let (left, told) = joined(&black, 200.0, 1.0);
        assert_eq!((told.dropped, told.bridged, told.bridges.len()), (3, 1, 1));
        assert!((area(&left) - (10_000.0 - 875.0 - 15.0)).abs() < 0.05, "{}", area(&left));
        let (left, told) = joined(&black, 0.0, 1.0);
        assert_eq!((told.dropped, told.bridged, told.bridges.len()), (0, 4, 4));
        assert_eq!(left.len(), 4);
    }

    #[test]
    fn rings_that_touch_are_joined_where_they_do() {
        let black = [vec![rectangle(0.0, 0.0, 50.0, 50.0), vec![[0.0, 25.0], [20.0, 35.0], [20.0, 15.0]]]];
        let (_, told) = joined(&black, 0.0, 3.0);
        assert_eq!(told.bridges[0].length, 0.0);
    }

    #[test]
    fn what_is_cut_off_goes_and_what_is_small_anyway_stays() {
        let cuts = [
            Joint { ends: [[10.0, 10.0], [40.0, 10.0]], along: [1.0, 0.0] },
            Joint { ends: [[0.0, 0.0], [20.0, 20.0]], along: [0.6, 0.8] },
        ];
        let cuts = cuts.map(|joint| joint.cut(2.0));
        let beside = vec![vec![[20.0, 11.001], [21.0, 11.001], [20.5, 11.5]]];
        let [apart, large] = [vec![rectangle(20.0, 12.0, 0.5, 0.5)], vec![rectangle(20.0, 11.001, 5.0, 5.0)]];
        let left = without_crumbs(vec![beside, apart.clone(), large.clone()], &cuts, 1.0);
        assert_eq!(left, [apart, large]);
    }

    #[test]
    fn there_may_be_nothing_to_do() {
        let black = [vec![rectangle(0.0, 0.0, 50.0, 50.0)], vec![rectangle(60.0, 0.0, 5.0, 5.0)]];
        assert_eq!(joined(&black, 0.0, 3.0), (black.to_vec(), Bridged::default()));
        assert_eq!(joined(&[], 0.0, 3.0), (vec![], Bridged::default()));
        let refused = |black: &[Polygon], min_area: f64, width: f64| {
            straight(black, [1.0, 1.0], &Bridging { min_area, width }, &Control::new()).unwrap_err().to_string()
        };
        assert_eq!(refused(&black, 0.0, -1.0), "bridge_width is -1, but it must be a length above 0");
        assert_eq!(refused(&[vec![vec![[f64::NAN, 0.0]]]], 0.0, 1.0), "an area has a coordinate that is not finite");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn no_island_is_left_of_holes_of_any_kind(
            places in prop::collection::vec((0u32..30, 0u32..30, 1u32..7, 1u32..7, any::<bool>()), 1..40),
            width in prop_oneof![Just(0.01), Just(0.3), Just(2.0), Just(30.0)],
            min_area in prop_oneof![Just(0.0), Just(2.0), Just(9.0)],
            moved in prop_oneof![Just(0.0), Just(0.013)],
        ) {
            // Rectangles that overlap and touch as they come, cut out or put in one after the other.
            let mut black: Vec<Polygon> = vec![vec![rectangle(0.0, 0.0, 40.0, 40.0)]];
            for (k, (x, y, w, h, is_white)) in places.iter().enumerate() {
                let by = moved * k as f64;
                let one = [vec![rectangle(f64::from(*x) + by, f64::from(*y) + by, f64::from(*w), f64::from(*h))]];
                black = if *is_white { subtracted(&black, &one) } else { crate::offset::united(&[black, one.to_vec()].concat()) }.unwrap();
            }
            let islands = islands_between(&black);
            let holes: usize = black.iter().map(|polygon| polygon.len() - 1).sum();
            prop_assert_eq!(islands.len(), holes);
            let (left, told) = joined(&black, min_area, width);
            prop_assert_eq!(told.dropped + told.bridged, holes);
            prop_assert_eq!(told.dropped, islands.iter().filter(|island| island.area < min_area).count());
            prop_assert_eq!(told.bridges.len(), told.bridged);
            prop_assert!(((area(&black) - area(&left)) / 1e4 - told.tone).abs() < 1e-9);
            prop_assert_eq!(islands_between(&left), vec![]);
        }
    }
}
