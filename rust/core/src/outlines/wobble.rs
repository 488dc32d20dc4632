//! Wobble: edges that look drawn by hand.
//!
//! # The idea
//! Nodes are drawn a little beside their places, by a field that changes slowly from place to place, so contours and dots go astray
//! as a hand does. The field is a swirl, which leaves areas as they are: no tone changes. Under inked edges its waves are longer, and
//! where contours cross edges of the graph moves slowly to the one side and to the other: strokes swell and thin. Under torn ones
//! both are quick and rough, and contours go straight from crossing to crossing.
//!
//! # How far
//! No distance between two places in a triangle of the graph changes by more than a third of it, and no crossing moves by more than
//! a third of its edge. Where the field would stretch a triangle further, its nodes go along with one another, and if that is not
//! enough, less far, with those around them. So no triangle turns over, and curves keep to theirs as ever (see [`super::sleeve`]).
//! Nodes at the frame stay, and those of bands, which are as wide as they are to be.
//!
//! # The noise
//! Gradient noise (Perlin): a hash of the seed gives every point of a square lattice a direction. It is made of sums, products and
//! square roots alone, which are the same on all machines.

use std::f64::consts::FRAC_1_SQRT_2;

use kurbo::{Point, Vec2};
use rayon::prelude::*;

use crate::base::{Control, Frame, Result, mixed};
use crate::graph::{Beside, Triangulation};
use crate::options::Edge;
use crate::outlines::sleeve::NEAREST_CROSSING;

/// The most that a distance changes, and that a crossing moves along its edge, as a share of it.
const MOST: f64 = 1.0 / 3.0;

/// How much both waves of the swirl stretch at wobble 1: more is seen better, until most of it has to be taken back.
const STRETCH: f64 = 0.06;

/// How irregular dots are at wobble 1: less than they can be, as their places are uneven too.
const IRREGULARITY: f64 = 0.7;

/// The share of the most that a triangle may be stretched to which it is brought back, so that it stays there when others are.
const BROUGHT_BACK: f64 = 0.75;

/// Rounds in which stretched triangles are brought back alone; in later ones all nodes beside them are moved by this share, so that
/// what is left calms down; after the last ones nodes stay where they were.
const ROUNDS: u32 = 12;
const CALMER: f64 = 0.8;
const LAST_ROUND: u32 = 60;

/// Triangles of less area, in px^2, stay where they are: rounding could turn them over.
const LEAST_AREA: f64 = 1e-6;

/// Nodes that a thread looks at before others can take the next.
const NODES_AT_ONCE: usize = 1 << 12;

/// How steeply crossings come to the limits of where they move: more makes them swing from one to the other.
const STEEPNESS: f64 = 4.0;

/// By how much a crossing of a torn contour is drawn to the middle of its edge, where there is room to both sides.
const TO_MIDDLE: f64 = 0.5;

/// How edges are drawn by hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wobble {
    /// From 0 to 1: how much of the most.
    strength: f64,
    edge: Edge,
    key: u64,
    /// About how far nodes lie from each other, in pixels.
    spacing: f64,
    frame: Frame,
}

impl Wobble {
    /// So much wobble in [0, 1], on a canvas with nodes about so far from each other; `None` if edges are to stay as they are.
    pub(super) fn new(wobble: f64, edge: Edge, seed: u64, spacing: f64, frame: Frame) -> Option<Self> {
        // The root, so that the small ones can be seen.
        (wobble > 0.0).then(|| Self { strength: wobble.sqrt(), edge, key: mixed(seed), spacing, frame })
    }

    /// Lengths of the waves of the swirl, in distances between nodes: the long ones move whole strokes, the short ones tremble.
    fn waves(&self) -> [f64; 2] {
        match self.edge {
            Edge::Smooth => [12.0, 5.0],
            Edge::Inked => [20.0, 9.0],
            Edge::Torn => [6.0, 3.0],
        }
    }

    /// Whether contours go straight from crossing to crossing.
    pub(super) fn is_torn(&self) -> bool {
        self.edge == Edge::Torn
    }

    /// How irregular dots are at least.
    pub(super) fn irregularity(&self) -> f64 {
        IRREGULARITY * self.strength
    }

    /// Where the nodes are drawn, instead of at `places`. Those that have a depth in bands stay.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub(super) fn places(
        &self,
        triangulation: &Triangulation,
        places: &[[f64; 2]],
        depths: Option<&[f32]>,
        control: &Control,
    ) -> Result<Vec<[f64; 2]>> {
        let graph = &triangulation.graph;
        let slots = |node: usize| graph.offsets[node] as usize..graph.offsets[node + 1] as usize;
        let stays = |node: usize| {
            depths.is_some_and(|depths| depths[node].is_finite())
                || slots(node).any(|slot| matches!(triangulation.left(slot), Beside::Frame(_)))
        };
        let place = |node: usize| Point::new(places[node][0], places[node][1]);
        let step = |node: usize| if stays(node) { Vec2::ZERO } else { self.step(place(node)) };
        let mut steps: Vec<Vec2> = (0..places.len()).into_par_iter().with_min_len(NODES_AT_ONCE).map(step).collect();
        // The nodes and those around them, each once.
        let and_around = |nodes: &[usize]| {
            let all = nodes.iter().flat_map(|node| graph.row(*node).iter().map(|other| *other as usize).chain([*node]));
            let mut all: Vec<usize> = all.collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let mut looked_at: Vec<usize> = (0..places.len()).collect();
        for round in 0.. {
            control.check()?;
            let brought_back = |node: usize| {
                let (mut sum, mut count) = (Vec2::ZERO, 0.0);
                for slot in slots(node) {
                    let Beside::Node(third) = triangulation.left(slot) else { continue };
                    let corners = [node, graph.neighbors[slot] as usize, third as usize];
                    let of_corners = corners.map(|corner| steps[corner]);
                    let stretch = stretch(corners.map(place), of_corners);
                    if stretch > MOST {
                        let [own, second, third] = of_corners;
                        sum += ((own + second + third) / 3.0).lerp(own, BROUGHT_BACK * MOST / stretch);
                        count += 1.0;
                    }
                }
                let step = if round > LAST_ROUND || stays(node) { Vec2::ZERO } else { sum / count };
                (count > 0.0).then_some((node, step))
            };
            let nodes = looked_at.into_par_iter().with_min_len(NODES_AT_ONCE);
            let (stretched, back): (Vec<usize>, Vec<Vec2>) = nodes.filter_map(brought_back).unzip();
            if stretched.is_empty() {
                break;
            }
            stretched.iter().zip(back).for_each(|(node, step)| steps[*node] = step);
            let mut changed = stretched;
            if round >= ROUNDS {
                changed = and_around(&changed);
                changed.iter().for_each(|node| steps[*node] *= CALMER);
            }
            looked_at = and_around(&changed);
        }
        Ok(places.iter().zip(steps).map(|([x, y], step)| [x + step.x, y + step.y]).collect())
    }

    /// How far the node at a place is moved at first.
    fn step(&self, place: Point) -> Vec2 {
        let Frame { width, height } = self.frame;
        let to_frame = place.x.min(width - place.x).min(place.y).min(height - place.y);
        let of_wave = |(k, wave): (u64, f64)| {
            let length = wave * self.spacing;
            let slope = noise(mixed(self.key ^ k), place, length).1;
            Vec2::new(slope.y, -slope.x) * (self.strength * STRETCH * length * ease(2.0 * to_frame / length))
        };
        (0..).zip(self.waves()).map(of_wave).fold(Vec2::ZERO, |sum, step| sum + step)
    }

    /// Where a contour crosses an edge from a node on its left to one on its right, as a fraction of the way, if it would at `fraction`, which is
    /// no nearer to a node than [`NEAREST_CROSSING`].
    pub(super) fn crossing(&self, [left, right]: [Point; 2], fraction: f64) -> f64 {
        let height = |k: u64, wave: f64| noise(mixed(self.key ^ k), left.lerp(right, fraction), wave * self.spacing).0;
        let limited = |height: f64| STEEPNESS * height / (1.0 + STEEPNESS * STEEPNESS * height * height).sqrt();
        let (nearest, furthest) = (NEAREST_CROSSING, 1.0 - NEAREST_CROSSING);
        match self.edge {
            Edge::Smooth => fraction,
            Edge::Inked => (fraction + self.strength * MOST * limited(height(2, 8.0))).clamp(nearest, furthest),
            Edge::Torn => {
                let middle = fraction + (0.5 - fraction) * TO_MIDDLE * self.strength;
                let room = (middle - nearest).min(furthest - middle).clamp(0.0, MOST);
                middle + self.strength * room * limited(0.6 * height(3, 3.0) + 0.4 * height(4, 1.5))
            }
        }
    }
}

/// By how much distances in a triangle change if its corners make these steps, as the largest share of any of them; no limit for
/// a triangle that may not move and does.
fn stretch([p, q, r]: [Point; 3], [at_p, at_q, at_r]: [Vec2; 3]) -> f64 {
    let ([e, f], [d, g]) = ([q - p, r - p], [at_q - at_p, at_r - at_p]);
    let area = e.cross(f);
    if area.abs() < 2.0 * LEAST_AREA {
        return if [at_p, at_q, at_r] == [Vec2::ZERO; 3] { 0.0 } else { f64::INFINITY };
    }
    let [xx, xy] = [d.x * f.y - g.x * e.y, g.x * e.x - d.x * f.x].map(|v| v / area);
    let [yx, yy] = [d.y * f.y - g.y * e.y, g.y * e.x - d.y * f.x].map(|v| v / area);
    // The singular values of the matrix that takes sides to what they become: their mean, and how far they are from it.
    let mean = Vec2::new(1.0 + 0.5 * (xx + yy), 0.5 * (yx - xy)).hypot2().sqrt();
    let half = Vec2::new(0.5 * (xx - yy), 0.5 * (yx + xy)).hypot2().sqrt();
    (mean + half - 1.0).max(1.0 - (mean - half))
}

/// From 0 to 1, without a kink at either.
fn ease(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Noise at a place, about in [-0.7, 0.7] and 0 on average, and its slope per wave.
fn noise(key: u64, place: Point, wave: f64) -> (f64, Vec2) {
    const DIRECTIONS: [Vec2; 8] = [
        Vec2::new(1.0, 0.0),
        Vec2::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2),
        Vec2::new(0.0, 1.0),
        Vec2::new(-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
        Vec2::new(-1.0, 0.0),
        Vec2::new(-FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
        Vec2::new(0.0, -1.0),
        Vec2::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
    ];
    let (x, y) = (place.x / wave, place.y / wave);
    let (column, row) = (x.floor(), y.floor());
    let inside = Vec2::new(x - column, y - row);
    let corner = |right: u8, down: u8| {
        let key = mixed(key ^ (column as i64 + i64::from(right)) as u64);
        let slope = DIRECTIONS[(mixed(key ^ (row as i64 + i64::from(down)) as u64) >> 61) as usize];
        (slope.dot(inside - Vec2::new(f64::from(right), f64::from(down))), slope)
    };
    let [(a, at_a), (b, at_b), (c, at_c), (d, at_d)] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
    let fade = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let fade_slope = |t: f64| 30.0 * t * t * (t * (t - 2.0) + 1.0);
    let (u, v) = (fade(inside.x), fade(inside.y));
    let both = a - b - c + d;
    let value = a + u * (b - a) + v * (c - a) + u * v * both;
    let slope = at_a + u * (at_b - at_a) + v * (at_c - at_a) + u * v * (at_a - at_b - at_c + at_d);
    let of_fade = Vec2::new(fade_slope(inside.x) * (b - a + v * both), fade_slope(inside.y) * (c - a + u * both));
    (value, slope + of_fade)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::graph::triangulate;

    const SIDE: usize = 60;

    fn wobble(strength: f64, edge: Edge, seed: u64) -> Wobble {
        let frame = Frame { width: SIDE as f64, height: SIDE as f64 };
        Wobble { strength, edge, key: mixed(seed), spacing: 2.0, frame }
    }

    fn scattered(seed: u64, count: u64) -> Triangulation {
        let random = |k: u64| (0.5 + 0.499 * f64::from(crate::base::noise(mixed(seed) ^ k))) * SIDE as f64;
        let sites = (0..count).map(|k| [random(2 * k), random(2 * k + 1)]).collect();
        triangulate(sites, SIDE, SIDE, &Control::new()).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_distance_in_a_triangle_changes_by_more_than_a_third(
            seed: u64, count in 4u64..900, strength in 0.01..=1.0, edge in prop::sample::select(vec![Edge::Smooth, Edge::Inked, Edge::Torn]),
        ) {
            let triangulation = scattered(seed, count);
            let graph = &triangulation.graph;
            let moved = wobble(strength, edge, seed).places(&triangulation, &graph.sites, None, &Control::new()).unwrap();
            let point = |p: [f64; 2]| Point::new(p[0], p[1]);
            for a in 0..graph.sites.len() {
                for slot in graph.offsets[a] as usize..graph.offsets[a + 1] as usize {
                    let Beside::Node(c) = triangulation.left(slot) else {
                        prop_assert_eq!(moved[a], graph.sites[a]);
                        continue;
                    };
                    let corners = [a, graph.neighbors[slot] as usize, c as usize];
                    let ([p, q, r], [u, v, w]) = (corners.map(|k| point(graph.sites[k])), corners.map(|k| point(moved[k])));
                    if (q - p).cross(r - p) < 1e-5 {
                        continue;
                    }
                    prop_assert!((v - u).cross(w - u) > 0.4 * (q - p).cross(r - p));
                    for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
                        let (before, now) = (q.lerp(r, t).distance(p), v.lerp(w, t).distance(u));
                        prop_assert!((now / before - 1.0).abs() < MOST + 1e-6, "{before} became {now}");
                    }
                }
            }
        }

        #[test]
        fn crossings_move_by_no_more_than_a_third_and_not_near_a_node(
            x in 0.0..60.0, y in 0.0..60.0, fraction in 0.2..=0.8, strength in 0.0..=1.0, seed: u64,
        ) {
            let edge = [Point::new(x, y), Point::new(y, x)];
            prop_assert_eq!(wobble(strength, Edge::Smooth, seed).crossing(edge, fraction), fraction);
            for kind in [Edge::Inked, Edge::Torn] {
                let moved = wobble(strength, kind, seed).crossing(edge, fraction);
                prop_assert!((moved - fraction).abs() <= MOST + 1e-12 && (0.2 - 1e-12..=0.8 + 1e-12).contains(&moved));
            }
        }
    }

    #[test]
    fn noise_has_its_slope_is_even_and_differs_between_keys() {
        let (mut sum, mut squares, mut product) = (0.0, 0.0, 0.0);
        for k in 0..10_000u64 {
            let at = |axis: u64| 400.0 * f64::from(crate::base::noise(2 * k + axis));
            let place = Point::new(at(0), at(1));
            let (value, slope) = noise(7, place, 5.0);
            assert!(value.abs() < 1.0);
            for (step, along) in [(Vec2::new(1e-6, 0.0), slope.x), (Vec2::new(0.0, 1e-6), slope.y)] {
                let measured = (noise(7, place + step, 5.0).0 - noise(7, place - step, 5.0).0) / 2e-6 * 5.0;
                assert!((measured - along).abs() < 1e-4, "{measured} for {along}");
            }
            sum += value;
            squares += value * value;
            product += value * noise(8, place, 5.0).0;
        }
        assert!((sum / 1e4).abs() < 0.01 && squares / 1e4 > 0.04 && product.abs() < 0.1 * squares);
    }

    /// What one machine draws all others do: these are the same bits everywhere.
    #[test]
    fn noise_is_exact() {
        let (value, slope) = noise(1, Point::new(12.5, -7.25), 4.0);
        assert_eq!(
            [value, slope.x, slope.y].map(f64::to_bits),
            [0xBFCF_03D9_3216_3BF9, 0xBFE9_BBBA_33F7_5B89, 0xBFEA_4BA2_C851_ACD2]
        );
    }

    #[test]
    fn nodes_of_bands_stay() {
        let triangulation = scattered(3, 500);
        let sites = &triangulation.graph.sites;
        let depths: Vec<f32> = sites.iter().map(|[x, _]| if *x < 30.0 { -1.0 } else { f32::NAN }).collect();
        let moved = wobble(1.0, Edge::Smooth, 0).places(&triangulation, sites, Some(&depths), &Control::new()).unwrap();
        let stays = |k: usize| moved[k] == sites[k];
        assert!((0..sites.len()).filter(|k| depths[*k].is_finite()).all(stays));
        assert!((0..sites.len()).filter(|k| !stays(*k)).count() > 100);
    }
}
