//! Samples: points of an outline with their places on a cubic, which is fitted to them.
//!
//! Most of what fitting costs is done here, so samples stand in pairs: see [`crate::pair`]. A pair is the middle of a piece of
//! the outline and the joint at its end; the last joint is the end of the cubic, and counts as no sample.

use kurbo::{CubicBez, ParamCurveDeriv, Point, QuadBez, Vec2};

use crate::pair::Pair;

/// Points as two coordinates, each a pair.
type Points = [Pair; 2];

/// Samples of up to `MOST` pieces in a row.
pub(crate) struct Samples<const MOST: usize> {
    pairs: [Two; MOST],
    /// Pieces that were added, and how many of them are looked at.
    added: usize,
    length: usize,
    /// The end of what was added, and the length of the way there.
    last: Point,
    way: f64,
}

/// Two samples.
#[derive(Clone, Copy)]
struct Two {
    points: Points,
    /// How far they are from the begin, along the samples.
    ways: Pair,
    /// Their places on the cubic.
    places: Pair,
    /// From them to the cubic at their places.
    off: Points,
}

/// A cubic, its derivative and that one's derivative.
struct Curve {
    cubic: CubicBez,
    first: QuadBez,
    second: [Point; 2],
}

impl Curve {
    fn new(cubic: &CubicBez) -> Self {
        let first = cubic.deriv();
        let second = first.deriv();
        Self { cubic: *cubic, first, second: [second.p0, second.p1] }
    }

    /// As kurbo evaluates it.
    #[inline(always)]
    fn at(&self, t: Pair) -> Points {
        let CubicBez { p0, p1, p2, p3 } = self.cubic;
        let u = Pair::of(1.0) - t;
        let (cube, square, single) = (u * u * u, u * u * 3.0, u * 3.0);
        let axis = |p0: f64, p1: f64, p2: f64, p3: f64| cube * p0 + (square * p1 + (single * p2 + t * p3) * t) * t;
        [axis(p0.x, p1.x, p2.x, p3.x), axis(p0.y, p1.y, p2.y, p3.y)]
    }

    /// The derivative.
    #[inline(always)]
    fn along(&self, t: Pair) -> Points {
        let QuadBez { p0, p1, p2 } = self.first;
        let u = Pair::of(1.0) - t;
        let (square, double) = (u * u, u * 2.0);
        let axis = |p0: f64, p1: f64, p2: f64| square * p0 + (double * p1 + t * p2) * t;
        [axis(p0.x, p1.x, p2.x), axis(p0.y, p1.y, p2.y)]
    }

    /// The second derivative.
    #[inline(always)]
    fn bend(&self, t: Pair) -> Points {
        let [p0, p1] = self.second;
        let axis = |p0: f64, p1: f64| Pair::of(p0) + t * (p1 - p0);
        [axis(p0.x, p1.x), axis(p0.y, p1.y)]
    }
}

#[inline(always)]
fn dot(a: Points, b: Points) -> Pair {
    a[0] * b[0] + a[1] * b[1]
}

/// The sums of products that the cubic nearest to samples follows from: of a, b and c, by which a sample moves with the lengths of
/// the first and of the second leg and with the second leg's turn, and of r, which is how far it is from the cubic without legs.
/// b is at a right angle to c and as long, so `bc` is 0 and `cc` is `bb`.
pub(crate) struct Products {
    pub(crate) aa: f64,
    pub(crate) ab: f64,
    pub(crate) ac: f64,
    pub(crate) bb: f64,
    pub(crate) ar: f64,
    pub(crate) br: f64,
    pub(crate) cr: f64,
}

/// The sum of squared distances of samples from a cubic, sideways, as a function of steps of both its control points, less what it
/// is without.
pub(crate) struct Quadratic {
    /// The factors of x^2, xy and y^2 of the step of each.
    pub(crate) own: [[f64; 3]; 2],
    /// Half the factors of the products of x and y of the first with x and y of the second: xx, xy, yx, yy.
    pub(crate) between: [f64; 4],
    /// The factors of x and y of each.
    pub(crate) linear: [Vec2; 2],
}

impl<const MOST: usize> Samples<MOST> {
    pub(crate) fn new() -> Self {
        let nothing = [Pair::of(0.0); 2];
        let two = Two { points: nothing, ways: Pair::of(0.0), places: Pair::of(0.0), off: nothing };
        Self { pairs: [two; MOST], added: 0, length: 0, last: Point::ZERO, way: 0.0 }
    }

    /// Forgets all, and goes on from `begin`.
    pub(crate) fn begin(&mut self, begin: Point) {
        (self.added, self.length, self.last, self.way) = (0, 0, begin, 0.0);
    }

    /// How many pieces were added.
    pub(crate) fn added(&self) -> usize {
        self.added
    }

    /// Adds a piece: its middle and its end.
    pub(crate) fn add(&mut self, middle: Point, end: Point) {
        let to_middle = self.way + (middle - self.last).hypot2().sqrt();
        self.way = to_middle + (end - middle).hypot2().sqrt();
        self.last = end;
        let two = &mut self.pairs[self.added];
        two.points = [Pair([middle.x, end.x]), Pair([middle.y, end.y])];
        two.ways = Pair([to_middle, self.way]);
        self.added += 1;
    }

    /// Looks at the first `length` pieces alone, at least one, and places their samples by the way to them.
    pub(crate) fn place_evenly(&mut self, length: usize) {
        self.length = length;
        let [_, whole] = self.pairs[length - 1].ways.0;
        for two in &mut self.pairs[..length] {
            two.places = two.ways.map(|way| way / whole);
        }
    }

    /// Moves the places towards the nearest points of a cubic.
    pub(crate) fn project(&mut self, cubic: &CubicBez) {
        self.pass::<true, false>(cubic);
    }

    /// As [`Self::project`], and measures how far the samples are from the cubic there.
    pub(crate) fn project_and_measure(&mut self, cubic: &CubicBez) {
        self.pass::<true, true>(cubic);
    }

    /// As [`Self::project`], for the cubic that was measured last.
    pub(crate) fn project_measured(&mut self, cubic: &CubicBez) {
        self.pass::<false, false>(cubic);
    }

    /// Measures, if `FIRST`; moves every place by one step of Newton's method; measures again, if `AGAIN`.
    #[inline(always)]
    fn pass<const FIRST: bool, const AGAIN: bool>(&mut self, cubic: &CubicBez) {
        let curve = Curve::new(cubic);
        let off = |points: Points, t: Pair| {
            let [x, y] = curve.at(t);
            [x - points[0], y - points[1]]
        };
        for two in &mut self.pairs[..self.length] {
            let t = two.places;
            let before = if FIRST { off(two.points, t) } else { two.off };
            let along = curve.along(t);
            let slope = dot(along, along) + dot(before, curve.bend(t));
            let next = t - dot(before, along).with(slope, |off, slope| off / slope);
            two.places = Pair(std::array::from_fn(|k| {
                let (slope, next) = (slope.0[k], next.0[k]);
                if (slope > 0.0) & (0.0..=1.0).contains(&next) { next } else { t.0[k] }
            }));
            if AGAIN {
                two.off = off(two.points, two.places);
            }
        }
    }

    /// Whether all samples were measured to be near: no squared distance is above `most`.
    pub(crate) fn are_near(&self, most: f64) -> bool {
        let square = |two: &Two| dot(two.off, two.off).map(|square| if square > most { 1.0 } else { 0.0 });
        let (last, others) = self.pairs[..self.length].split_last().expect("a run has a piece");
        !others.iter().any(|two| square(two).0 != [0.0; 2]) && square(last).0[0] == 0.0
    }

    /// For a cubic from `p0` to `p3` that begins and ends in the directions of the unit vectors `begin` and `end`.
    pub(crate) fn products(&self, [p0, p3]: [Point; 2], [begin, end]: [Vec2; 2]) -> Products {
        let [aa, ab, ac, bb, ar, br, cr] = self.sums(|two| {
            let t = two.places;
            let u = Pair::of(1.0) - t;
            let treble = u * 3.0;
            let (b1, b2) = (treble * u * t, treble * t * t);
            let (first, last) = (u * u * u + b1, b2 + t * t * t);
            let base = [first * p0.x + last * p3.x, first * p0.y + last * p3.y];
            let rest = [two.points[0] - base[0], two.points[1] - base[1]];
            // b and c are this one turned by a half and by a quarter.
            let (a, legs) = ([b1 * begin.x, b1 * begin.y], [b2 * end.x, b2 * end.y]);
            let across = |p: Points| legs[0] * p[1] - legs[1] * p[0];
            [dot(a, a), -dot(a, legs), across(a), dot(legs, legs), dot(a, rest), -dot(legs, rest), across(rest)]
        });
        Products { aa, ab, ac, bb, ar, br, cr }
    }

    /// For steps from a cubic that was measured last.
    pub(crate) fn quadratic(&self, cubic: &CubicBez) -> Quadratic {
        let curve = Curve::new(cubic);
        let [al_x, al_y, bl_x, bl_y, axx, axy, ayy, bxx, bxy, byy, xx, xy, yx, yy] = self.sums(|two| {
            let t = two.places;
            let [x, y] = curve.along(t);
            let shorten = (x * x + y * y).map(|square| square.sqrt().recip());
            let aside = [-y * shorten, x * shorten];
            let twice = dot(two.off, aside) * 2.0;
            let u = Pair::of(1.0) - t;
            let treble = u * 3.0;
            let (b1, b2) = (treble * u * t, treble * t * t);
            let ([ax, ay], [bx, by]) = (aside.map(|v| v * b1), aside.map(|v| v * b2));
            [
                ax * twice,
                ay * twice,
                bx * twice,
                by * twice,
                ax * ax,
                ax * 2.0 * ay,
                ay * ay,
                bx * bx,
                bx * 2.0 * by,
                by * by,
                ax * bx,
                ax * by,
                ay * bx,
                ay * by,
            ]
        });
        Quadratic {
            own: [[axx, axy, ayy], [bxx, bxy, byy]],
            between: [xx, xy, yx, yy],
            linear: [Vec2::new(al_x, al_y), Vec2::new(bl_x, bl_y)],
        }
    }

    /// How many samples there are.
    pub(crate) fn count(&self) -> usize {
        2 * self.length - 1
    }

    /// Sums over all samples, in their order.
    #[inline(always)]
    fn sums<const N: usize>(&self, terms: impl Fn(&Two) -> [Pair; N]) -> [f64; N] {
        let mut sums = [0.0; N];
        for (number, two) in (1..).zip(&self.pairs[..self.length]) {
            let terms = terms(two);
            for (sum, term) in sums.iter_mut().zip(&terms) {
                *sum += term.0[0];
            }
            // Nothing is added for the end. (No sum is ever a negative zero.)
            let second = |term: &Pair| if number < self.length { term.0[1] } else { 0.0 };
            for (sum, term) in sums.iter_mut().zip(&terms) {
                *sum += second(term);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use kurbo::ParamCurve;

    use super::*;

    /// The same, one sample at a time: the points with their places.
    fn projected(points: &[(Point, f64)], cubic: &CubicBez) -> Vec<(Point, f64)> {
        let first = cubic.deriv();
        let second = first.deriv();
        let moved = |(point, t): &(Point, f64)| {
            let off = cubic.eval(*t) - *point;
            let along = first.eval(*t).to_vec2();
            let next = t - off.dot(along) / (along.dot(along) + off.dot(second.eval(*t).to_vec2()));
            (*point, next)
        };
        points.iter().map(moved).collect()
    }

    #[test]
    fn two_at_a_time_are_what_each_is_alone() {
        let cubic = CubicBez::new((0.3, 0.1), (1.2, 1.9), (3.1, 2.2), (4.7, 0.4));
        let points: Vec<Point> =
            (0..=6).map(|k| cubic.eval(f64::from(k) / 6.0) + Vec2::new(0.03, 0.01) * f64::from(k % 3)).collect();
        let mut samples = Samples::<4>::new();
        samples.begin(points[0]);
        for piece in points[1..].chunks_exact(2) {
            samples.add(piece[0], piece[1]);
        }
        assert_eq!(samples.added(), 3);
        samples.place_evenly(3);
        assert_eq!(samples.count(), 5);

        let ways = points.windows(2).scan(0.0, |way, pair| {
            *way += (pair[1] - pair[0]).hypot2().sqrt();
            Some(*way)
        });
        let ways: Vec<f64> = ways.collect();
        let placed: Vec<(Point, f64)> = points[1..6].iter().zip(&ways).map(|(point, way)| (*point, way / ways[5])).collect();
        let once = projected(&placed, &cubic);
        let twice = projected(&once, &cubic);
        let places =
            |samples: &Samples<4>| -> Vec<f64> { samples.pairs[..3].iter().flat_map(|two| two.places.0).take(5).collect() };
        samples.project_and_measure(&cubic);
        assert_eq!(places(&samples), once.iter().map(|(_, t)| *t).collect::<Vec<_>>());
        let mut measured = samples;
        measured.project_measured(&cubic);
        assert_eq!(places(&measured), twice.iter().map(|(_, t)| *t).collect::<Vec<_>>());
        measured.place_evenly(3);
        measured.project(&cubic);
        measured.project_and_measure(&cubic);
        assert_eq!(places(&measured), twice.iter().map(|(_, t)| *t).collect::<Vec<_>>());

        let largest = twice.iter().map(|(point, t)| (cubic.eval(*t) - *point).hypot2()).fold(0.0, f64::max);
        assert!(measured.are_near(largest) && !measured.are_near(largest.next_down()));

        let (begin, end) = (Vec2::new(0.6, 0.8), Vec2::new(0.8, -0.6));
        let aside = Vec2::new(-end.y, end.x);
        let Products { aa, ab, ac, bb, ar, br, cr } = measured.products([cubic.p0, cubic.p3], [begin, end]);
        let mut sums = [0.0; 9];
        for (point, t) in &twice {
            let u = 1.0 - t;
            let (b1, b2) = (3.0 * u * u * t, 3.0 * u * t * t);
            let (a, b, c) = (begin * b1, end * -b2, aside * b2);
            let rest = point.to_vec2() - (cubic.p0.to_vec2() * (u * u * u + b1) + cubic.p3.to_vec2() * (b2 + t * t * t));
            for (sum, (v, w)) in
                sums.iter_mut().zip([(a, a), (a, b), (a, c), (b, b), (b, c), (c, c), (a, rest), (b, rest), (c, rest)])
            {
                *sum += v.dot(w);
            }
        }
        assert_eq!([aa, ab, ac, bb, 0.0, bb, ar, br, cr], sums);
    }
}
