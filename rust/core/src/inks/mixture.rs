//! The parts in which labels mix to a colour.
//!
//! A drawing shows a colour by labels side by side. Of all parts w that come nearest to a colour c, those are taken whose labels k are
//! nearest to it: the least of `|sum w k - c|^2 + eps sum w |k - c|^2` over parts that add up to 1, for an eps that hardly counts. Inside
//! what the labels can mix, that is the simplex of their Delaunay triangulation that holds the colour; outside, it is the nearest
//! point that they can mix. No more than four labels have a part.
//!
//! The least is found by an active set: it begins with the label nearest to the colour, takes in the one that lowers the sum
//! fastest, and drops those whose parts come to nothing. Where a label depends on those that are in, as a grey does on black and
//! white, it takes the place of one of them.

use rayon::prelude::*;

use crate::base::{Error, Result};
use crate::graph::check_one_a_node;

/// The most labels of a drawing, paper included.
pub const MOST_LABELS: usize = 64;

/// The weight of the labels' own distances.
const NEARNESS: f64 = 1e-6;

/// What a label must lower the sum by, per part, to be taken in.
const LEAST_GAIN: f64 = 1e-11;

/// The squared distance from what the labels that are in span below which a label depends on them.
const DEPENDENT: f64 = 1e-9;

/// Rec. 601, as a photo's grey level.
const LUMA: [f64; 3] = [0.299, 0.587, 0.114];

/// How much red and blue without the luma count, where the luma counts 1: the eye asks for the right lightness first.
const RED: f64 = 0.5;
const BLUE: f64 = 0.4;

/// Colours that one thread mixes, at least.
const LEAST_PART: usize = 1 << 10;

/// In which parts labels mix to a colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mixture {
    /// Those that have a part, the largest first, the lower first among equals; behind them zeros.
    pub labels: [u8; 4],
    /// Their parts, which add up to 1.
    pub parts: [f32; 4],
}

impl Mixture {
    /// One label alone.
    pub fn pure(label: u8) -> Self {
        Self { labels: [label, 0, 0, 0], parts: [1.0, 0.0, 0.0, 0.0] }
    }

    /// The label of the largest part.
    pub fn largest(&self) -> u8 {
        self.labels[0]
    }

    /// The part of a label.
    pub fn part(&self, label: u8) -> f32 {
        self.shares().find(|(own, _)| *own == label).map_or(0.0, |(_, part)| part)
    }

    /// The labels that have a part, each with it.
    pub fn shares(&self) -> impl Iterator<Item = (u8, f32)> + use<> {
        self.labels.into_iter().zip(self.parts).take_while(|(_, part)| *part > 0.0)
    }

    /// From parts of any order.
    fn of(mut shares: Vec<(u8, f64)>) -> Self {
        shares.retain(|(_, part)| *part > 0.0);
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut mixture = Self::default();
        for (k, (label, part)) in shares.into_iter().take(4).enumerate() {
            (mixture.labels[k], mixture.parts[k]) = (label, part as f32);
        }
        mixture
    }
}

/// The colours that labels mix.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixing {
    /// Of every label: where its colour is among those that are compared.
    places: Vec<Point>,
    /// And its luma, in [0, 1].
    lumas: Vec<f64>,
    linear: bool,
}

type Point = [f64; 3];

impl Mixing {
    /// Labels of these colours, sRGB in 8 bits. They mix by encoded values, as tones do, or in linear light.
    ///
    /// # Errors
    /// [`Error::Input`] if there are not between 2 and [`MOST_LABELS`].
    pub fn new(colours: &[[u8; 3]], linear: bool) -> Result<Self> {
        if !(2..=MOST_LABELS).contains(&colours.len()) {
            return Err(Error::Input(format!("there are {} colours, but there must be from 2 to {MOST_LABELS}", colours.len())));
        }
        let encoded = |colour: &[u8; 3]| colour.map(|value| f64::from(value) / 255.0);
        let lumas = colours.iter().map(|colour| dot(LUMA, encoded(colour))).collect();
        let mut mixing = Self { places: Vec::new(), lumas, linear };
        mixing.places = colours.iter().map(|colour| mixing.place(encoded(colour))).collect();
        Ok(mixing)
    }

    /// How many labels there are.
    pub fn labels(&self) -> usize {
        self.places.len()
    }

    /// The colours of the labels, so weighed that lengths are differences as they are seen.
    pub(crate) fn places(&self) -> &[[f64; 3]] {
        &self.places
    }

    /// The luma of a mixture, in [0, 1].
    pub fn luma(&self, mixture: &Mixture) -> f64 {
        mixture.shares().map(|(label, part)| f64::from(part) * self.lumas[usize::from(label)]).sum()
    }

    /// How far apart the colours of two labels are: 1 for black and white.
    pub(crate) fn distance(&self, a: u8, b: u8) -> f64 {
        let way = minus(self.places[usize::from(a)], self.places[usize::from(b)]);
        dot(way, way).sqrt()
    }

    /// Whether a label is darker than another; one of two that are as dark is.
    pub(crate) fn is_darker(&self, a: u8, b: u8) -> bool {
        let [first, second] = [a, b].map(|label| self.lumas[usize::from(label)]);
        first < second || (first == second && a < b)
    }

    /// The mixture for a colour: red, green and blue in [0, 1], sRGB-encoded.
    pub fn of(&self, rgb: [f32; 3]) -> Mixture {
        self.nearest(self.place(rgb.map(f64::from)))
    }

    /// How far a colour is from its mixture.
    pub(crate) fn missed(&self, rgb: [f32; 3], mixture: &Mixture) -> f64 {
        let off = mixture.shares().fold(self.place(rgb.map(f64::from)), |off, (label, part)| {
            let place = self.places[usize::from(label)];
            std::array::from_fn(|axis| off[axis] - f64::from(part) * place[axis])
        });
        dot(off, off).sqrt()
    }

    /// How far from a colour the labels are that mix it, by root mean square.
    pub(crate) fn spread(&self, rgb: [f32; 3], mixture: &Mixture) -> f64 {
        let place = self.place(rgb.map(f64::from));
        let squared = |(label, part): (u8, f32)| {
            let way = minus(self.places[usize::from(label)], place);
            f64::from(part) * dot(way, way)
        };
        mixture.shares().map(squared).sum::<f64>().sqrt()
    }

    fn place(&self, rgb: [f64; 3]) -> Point {
        axes(if self.linear { rgb.map(linear) } else { rgb })
    }

    fn nearest(&self, colour: Point) -> Mixture {
        let mut squares = [0.0; MOST_LABELS];
        let mut first = 0;
        for (label, place) in self.places.iter().enumerate() {
            let way = minus(*place, colour);
            squares[label] = dot(way, way);
            if squares[label] < squares[first] {
                first = label;
            }
        }
        let mut set = Active { places: &self.places, squares: &squares, colour, labels: [first; 5], parts: [0.0; 5], count: 1 };
        set.parts[0] = 1.0;
        for _ in 0..4 * self.places.len() + 16 {
            let Some(label) = set.best_to_take() else { break };
            set.take(label);
        }
        set.mixture()
    }
}

/// Luma, red and blue of a colour, so weighed that lengths are differences as they are seen.
pub(crate) fn axes(rgb: [f64; 3]) -> [f64; 3] {
    let luma = dot(LUMA, rgb);
    [luma, RED * (rgb[0] - luma), BLUE * (rgb[2] - luma)]
}

/// The mixture for every colour.
pub fn mixtures(colours: &[[f32; 3]], mixing: &Mixing) -> Vec<Mixture> {
    colours.par_iter().with_min_len(LEAST_PART).map(|colour| mixing.of(*colour)).collect()
}

/// # Errors
/// [`Error::Input`] if there is not one mixture of so many labels a node, with parts that add up to 1.
pub(crate) fn check_mixtures(mixtures: &[Mixture], nodes: usize, labels: usize) -> Result<()> {
    check_one_a_node("mixtures", mixtures.len(), nodes)?;
    let is_wrong = |mixture: &Mixture| {
        let total: f32 = mixture.parts.iter().sum();
        let is_total = (total - 1.0).abs() < 1e-3 && mixture.parts.iter().all(|part| *part >= 0.0);
        !is_total || mixture.labels.iter().any(|label| usize::from(*label) >= labels)
    };
    match mixtures.par_iter().position_first(is_wrong) {
        Some(node) => {
            Err(Error::Input(format!("the mixture of node {node} must be of labels below {labels}, with parts that sum 1")))
        }
        None => Ok(()),
    }
}

/// sRGB's linear light.
pub(super) fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The labels that have a part: never one that depends on the others, but for the last, just taken in.
struct Active<'a> {
    places: &'a [Point],
    /// Of all labels: the squared distances from the colour.
    squares: &'a [f64],
    colour: Point,
    labels: [usize; 5],
    parts: [f64; 5],
    count: usize,
}

impl Active<'_> {
    /// The label that lowers the sum fastest.
    fn best_to_take(&self) -> Option<usize> {
        let off = (0..self.count).fold(self.colour.map(|v| -v), |off, k| {
            let place = self.places[self.labels[k]];
            std::array::from_fn(|axis| off[axis] + self.parts[k] * place[axis])
        });
        let slope = |label: usize| 2.0 * dot(self.places[label], off) + NEARNESS * self.squares[label];
        let own: f64 = (0..self.count).map(|k| self.parts[k] * slope(self.labels[k])).sum();
        let mut best = (own - LEAST_GAIN, None);
        for label in 0..self.places.len() {
            let slope = slope(label);
            if slope < best.0 {
                best = (slope, Some(label));
            }
        }
        best.1.filter(|label| !self.labels[..self.count].contains(label))
    }

    fn take(&mut self, label: usize) {
        let (weights, off) = self.on_span(self.places[label], 0.0);
        let is_dependent = off < DEPENDENT;
        self.labels[self.count] = label;
        self.parts[self.count] = 0.0;
        self.count += 1;
        if is_dependent {
            // Its part comes from those that it depends on, until one has none left.
            let mut way = weights.map(|weight| -weight);
            way[self.count - 1] = 1.0;
            self.go(way, f64::INFINITY);
        }
        while self.count > 1 {
            let (wanted, _) = self.on_span(self.colour, NEARNESS);
            let way = std::array::from_fn(|k| wanted[k] - self.parts[k]);
            if !self.go(way, 1.0) {
                break;
            }
        }
    }

    /// Changes the parts, as far as none falls below 0; whether one fell to it and was dropped.
    fn go(&mut self, way: [f64; 5], most: f64) -> bool {
        let (mut step, mut dropped) = (most, None);
        for (k, (part, change)) in self.parts.iter().zip(way).take(self.count).enumerate() {
            if change < 0.0 && *part < -change * step {
                (step, dropped) = (part / -change, Some(k));
            }
        }
        if step.is_finite() {
            self.parts.iter_mut().zip(way).take(self.count).for_each(|(part, change)| *part += step * change);
        }
        if let Some(dropped) = dropped {
            self.count -= 1;
            self.labels.copy_within(dropped + 1.., dropped);
            self.parts.copy_within(dropped + 1.., dropped);
        }
        dropped.is_some()
    }

    /// The parts, which may be negative, in which the labels mix what comes nearest to a point, and its squared distance; with a
    /// weight of the labels' own distances from the colour.
    fn on_span(&self, point: Point, nearness: f64) -> ([f64; 5], f64) {
        let (base, edges) = (self.places[self.labels[0]], self.count - 1);
        let mut sides = [[0.0; 3]; 3];
        let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
        let off = minus(point, base);
        for i in 0..edges.min(3) {
            let label = self.labels[i + 1];
            sides[i] = minus(self.places[label], base);
            right[i] = dot(sides[i], off) - 0.5 * nearness * (self.squares[label] - self.squares[self.labels[0]]);
            for j in 0..=i {
                (matrix[i][j], matrix[j][i]) = (dot(sides[i], sides[j]), dot(sides[i], sides[j]));
            }
        }
        let solved = solved(matrix, right, edges.min(3));
        let mut parts = [0.0; 5];
        let mut rest = off;
        for k in 0..edges.min(3) {
            parts[k + 1] = solved[k];
            rest = std::array::from_fn(|axis| rest[axis] - solved[k] * sides[k][axis]);
        }
        parts[0] = 1.0 - solved.iter().sum::<f64>();
        (parts, dot(rest, rest))
    }

    /// The parts at last, as if only the mixed colour counted.
    fn mixture(&self) -> Mixture {
        let (exact, _) = self.on_span(self.colour, 0.0);
        let parts = if exact[..self.count].iter().all(|part| *part > -1e-3) { exact } else { self.parts };
        let parts: Vec<f64> = parts[..self.count].iter().map(|part| part.max(0.0)).collect();
        let total: f64 = parts.iter().sum();
        Mixture::of(self.labels.iter().zip(parts).map(|(label, part)| (*label as u8, part / total)).collect())
    }
}

/// The solution of a positive definite system of so many rows, by Cholesky's way.
fn solved(matrix: [[f64; 3]; 3], right: [f64; 3], rows: usize) -> [f64; 3] {
    let (mut lower, mut solution) = ([[0.0f64; 3]; 3], [0.0; 3]);
    for i in 0..rows {
        for j in 0..=i {
            let rest = matrix[i][j] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / lower[j][j] };
        }
        solution[i] = (right[i] - (0..i).map(|k| lower[i][k] * solution[k]).sum::<f64>()) / lower[i][i];
    }
    for i in (0..rows).rev() {
        solution[i] = (solution[i] - (i + 1..rows).map(|k| lower[k][i] * solution[k]).sum::<f64>()) / lower[i][i];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::noise;

    fn random(number: u64) -> f64 {
        0.5 + 0.5 * f64::from(noise(number))
    }

    fn colour(number: u64) -> [f32; 3] {
        std::array::from_fn(|channel| random(3 * number + channel as u64) as f32)
    }

    fn palette(count: u64, seed: u64) -> Vec<[u8; 3]> {
        (0..count).map(|k| colour(1000 * seed + k).map(|v| (v * 255.0) as u8)).collect()
    }

    fn total(mixture: &Mixture) -> f64 {
        mixture.parts.iter().map(|part| f64::from(*part)).sum()
    }

    /// What the parts are to be least for.
    fn cost(mixing: &Mixing, place: Point, parts: &[(u8, f64)]) -> f64 {
        let of = |label: u8| mixing.places[usize::from(label)];
        let mixed = parts.iter().fold([0.0; 3], |sum, (label, part)| std::array::from_fn(|a| sum[a] + part * of(*label)[a]));
        let off = minus(mixed, place);
        let own = |label: u8| dot(minus(of(label), place), minus(of(label), place));
        dot(off, off) + NEARNESS * parts.iter().map(|(label, part)| part * own(*label)).sum::<f64>()
    }

    #[test]
    fn black_and_white_mix_to_grey_as_tones_do() {
        let mixing = Mixing::new(&[[0; 3], [255; 3]], false).unwrap();
        for tone in (0..=1000).map(|k| k as f32 / 1000.0) {
            let mixture = mixing.of([tone; 3]);
            assert!((mixture.part(1) - tone).abs() <= 1e-7 && (mixture.part(0) - (1.0 - tone)).abs() <= 1e-7, "{tone} {mixture:?}");
        }
        assert_eq!(mixing.of([-0.5; 3]), Mixture::pure(0));
        assert_eq!(mixing.of([1.5; 3]), Mixture::pure(1));
        let in_light = Mixing::new(&[[0; 3], [255; 3]], true).unwrap();
        assert!((in_light.of([0.5; 3]).part(1) - 0.214_041).abs() < 1e-5);
    }

    #[test]
    fn parts_are_the_least_of_their_sum() {
        for (count, seed) in [(2, 1), (3, 2), (4, 3), (6, 4), (15, 5), (64, 6)] {
            let mixing = Mixing::new(&palette(count, seed), seed % 2 == 0).unwrap();
            for number in 0..400 {
                let rgb = colour(900_000 + number);
                let (place, mixture) = (mixing.place(rgb.map(f64::from)), mixing.of(rgb));
                assert!((total(&mixture) - 1.0).abs() < 1e-6 && mixture.parts.is_sorted_by(|a, b| a >= b), "{mixture:?}");
                let parts: Vec<(u8, f64)> = mixture.shares().map(|(label, part)| (label, f64::from(part))).collect();
                let found = cost(&mixing, place, &parts);
                // The sum is convex: no step towards any label lowers it.
                for label in 0..mixing.labels() as u8 {
                    for step in [1e-3, 0.1] {
                        let mut other: Vec<(u8, f64)> = parts.iter().map(|(own, part)| (*own, part * (1.0 - step))).collect();
                        other.push((label, step));
                        assert!(cost(&mixing, place, &other) > found - 1e-8, "{count} {rgb:?} {mixture:?} {label}");
                    }
                }
            }
        }
    }

    #[test]
    fn colours_of_labels_are_pure_and_those_between_mix_exactly() {
        let colours = palette(15, 9);
        let mixing = Mixing::new(&colours, false).unwrap();
        for (label, colour) in colours.iter().enumerate() {
            assert!(mixing.of(colour.map(|v| f32::from(v) / 255.0)).part(label as u8) > 1.0 - 1e-5);
        }
        let between = |a: usize, b: usize| std::array::from_fn(|k| (f32::from(colours[a][k]) + f32::from(colours[b][k])) / 510.0);
        for (a, b) in [(0, 1), (3, 9), (14, 2)] {
            let rgb: [f32; 3] = between(a, b);
            assert!(mixing.missed(rgb, &mixing.of(rgb)) < 1e-6);
        }
    }

    #[test]
    fn greys_on_a_line_mix_with_those_beside_them() {
        let greys: Vec<[u8; 3]> = [0, 85, 170, 255].map(|v| [v; 3]).to_vec();
        let mixing = Mixing::new(&greys, false).unwrap();
        let mixture = mixing.of([0.5; 3]);
        assert_eq!(mixture.labels, [1, 2, 0, 0]);
        assert!((mixture.parts[0] - 0.5).abs() < 1e-6);
        // Whatever their chroma.
        let mixture = mixing.of([0.9, 0.2, 0.1]);
        assert!(mixture.parts[2] == 0.0 && (mixing.luma(&mixture) - 0.3979).abs() < 1e-4, "{mixture:?}");
    }

    #[test]
    fn inks_in_one_plane_and_inks_that_are_equal_do_no_harm() {
        // A square with its middle in the plane of no blue, and one twice.
        let colours = [[0, 0, 0], [200, 0, 0], [0, 200, 0], [200, 200, 0], [100, 100, 0], [100, 100, 0], [200, 0, 0]];
        let mixing = Mixing::new(&colours, false).unwrap();
        for number in 0..500 {
            let [r, g, _] = colour(number);
            let rgb = [r * 0.78, g * 0.78, 0.0];
            let mixture = mixing.of(rgb);
            assert!(mixture.parts[3] == 0.0 && mixing.missed(rgb, &mixture) < 1e-5, "{rgb:?} {mixture:?}");
        }
        assert_eq!(Mixing::new(&[[9; 3]; 5], false).unwrap().of([0.3; 3]), Mixture::pure(0));
        assert!(Mixing::new(&[[0; 3]], false).is_err() && Mixing::new(&[[0; 3]; 65], false).is_err());
    }

    #[test]
    fn many_colours_mix_as_one_does() {
        let mixing = Mixing::new(&palette(7, 3), false).unwrap();
        let colours: Vec<[f32; 3]> = (0..5000).map(colour).collect();
        assert_eq!(mixtures(&colours, &mixing), colours.iter().map(|rgb| mixing.of(*rgb)).collect::<Vec<_>>());
        assert_eq!(mixing.of([f32::NAN; 3]).parts[1], 0.0);
    }

    #[test]
    #[ignore = "a measurement"]
    fn time_of_a_mixture() {
        for count in [2, 4, 7, 16, 64] {
            let mixing = Mixing::new(&palette(count, 3), false).unwrap();
            let began = std::time::Instant::now();
            let sum: f32 = (0..300_000).map(|k| mixing.of(colour(k)).parts[0]).sum();
            println!("{count} labels: {:.2} us a colour ({sum})", began.elapsed().as_secs_f64() * 1e6 / 300_000.0);
        }
    }
}
