//! Outlines with fewer points: a spline through every other crossing or fewer, near enough to the full one.
//!
//! # The idea
//! The full outline is a uniform quadratic B-spline with a control point for every crossing. The simpler one is such a spline too,
//! with a control point for every run of its pieces. First runs are as long as one parabola through their ends and middle can be
//! without straying far. Control points are then such that the middle of every new piece lies on the middle of its run (a tridiagonal
//! system, in which what is far away hardly counts), moved a little outwards or inwards until the area is kept, and rounded to the
//! grid, each making up for what rounding the ones before did to the area. Pieces that stray too far after all, or leave their
//! triangles, are given up for those of the full outline. At last every two neighbours are tried as one.
//!
//! As joints are in the middle between two control points, a file need not write control points: one coordinate pair for each piece.
//!
//! # How far curves stray
//! Whoever goes along the simpler outline has a companion on the full one, never further away than the tolerance, who does not turn
//! back either (their Fréchet distance). The companion of a joint is the place nearest to it on the full outline; joints and
//! middles of the full outline's pieces are companions of points that are about nearest, in the same order. Between two of those
//! both outlines are quadratic curves, and so is their difference, of which no more needs to be known than its ends and how much
//! it bends.
//!
//! # Why curves never cross
//! Every piece walks through the triangles of its own contour, one after the other (see [`super::fit`]), and leaves the triangle that
//! it begins in. It turns by less than a right angle either way from its chord, so it meets neither the previous piece nor the next
//! one; others are in other triangles.

use std::ops::Range;

use kurbo::{ParamCurveArea, Point, QuadBez, Vec2};

use crate::base::snap;
use crate::outlines::sleeve::Sleeve;
use crate::outlines::spline::Spline;

/// The most pieces that one replaces: more hardly ever fit, and looking further costs time.
const LONGEST_RUN: usize = 16;

/// The part of the tolerance that the parabola of a run may stray: the spline, whose pieces depend on those around, strays further.
const FIRST_GUESS: f64 = 0.25;

/// The most that it may stray, as a part of the distance between nodes: where parabolas stray further, splines leave their triangles.
const FIRST_GUESS_OF_SPACING: f64 = 0.06;

/// Rounds of placing control points by those beside them. Each leaves a ninth of what is missing.
const ROUNDS: usize = 3;

/// How much keeping the area weighs, against staying in place, when control points are rounded.
const AREA_WEIGHT: f64 = 2.0;

/// The area that an outline may gain or lose, in px^2: a few per cent of a dot.
pub(super) const AREA_LEFT: f64 = 0.2;

/// Rounds of keeping the area, until the full outline is kept.
const AREA_ROUNDS: usize = 4;

/// Pieces of the full outline, on each side of where it is looked for, among which the place nearest to a joint must lie. Joints lie
/// in the middle between control points, not between runs.
const REACH: usize = LONGEST_RUN / 4 + 1;

/// The least pieces of a closed outline: of three, dots that fused would be pointed.
const LEAST_CLOSED: usize = 4;

/// A piece of the simpler outline.
#[derive(Clone)]
struct Piece {
    /// The pieces of the full outline that it stands for.
    run: Range<usize>,
    control: Point,
    /// Whether its control point is that of the full outline.
    is_full: bool,
    /// The previous piece and the next; at the ends of an open outline itself.
    beside: [usize; 2],
}

/// A full outline that is made simpler.
pub(super) struct Simplifier<'a> {
    tolerance: f64,
    /// How far the parabolas of the first runs may stray.
    first_guess: f64,
    /// Units to a pixel of the grid of control points.
    units: f64,
    outline: &'a Spline,
    sleeve: &'a Sleeve<'a>,
    /// The first is where the outline begins; others in any order, those that are no more too.
    pieces: Vec<Piece>,
    /// Joints and middles of the full outline's pieces in turn; for a closed one with [`REACH`] pieces more at both ends.
    halves: Vec<Point>,
    /// The second difference of both halves of every piece, as Bezier curves: a point of one, a part s of the way, lies s (1 - s) times
    /// this before that of a straight line.
    bends: Vec<Vec2>,
    /// How many pieces there are in those before the first.
    ahead: usize,
    /// The area under the full outline, and how much the simpler one has more.
    area: f64,
    surplus: f64,
    scratch: Vec<Point>,
}

impl<'a> Simplifier<'a> {
    pub(super) fn new(tolerance: f64, spacing: f64, units: f64, outline: &'a Spline, sleeve: &'a Sleeve<'a>) -> Self {
        let n = outline.controls.len();
        let ahead = if outline.closed { REACH } else { 0 };
        let pieces = (0..n + 2 * ahead).map(|k| (k + n * ahead - ahead) % n);
        let halves = pieces.clone().flat_map(|k| [outline.joints[k], outline.middle(k)]);
        Self {
            tolerance,
            first_guess: (FIRST_GUESS * tolerance).min(FIRST_GUESS_OF_SPACING * spacing),
            units: units / 2.0,
            outline,
            sleeve,
            pieces: Vec::with_capacity(n),
            halves: halves.chain([outline.joints[if outline.closed { ahead % n } else { n }]]).collect(),
            bends: pieces.map(|k| outline.bend(k) / 4.0).collect(),
            ahead,
            area: outline.whole_area(),
            surplus: 0.0,
            scratch: Vec::new(),
        }
    }

    /// The simpler outline.
    pub(super) fn run(mut self) -> Spline {
        self.divide();
        let all: Vec<usize> = self.in_order().collect();
        (0..ROUNDS).for_each(|_| self.relax(&all));
        self.place(&all);
        self.settle(all);
        // Giving up pieces changes the area, and keeping it may make others stray: a few rounds nearly always do.
        for round in 0..AREA_ROUNDS {
            self.surplus = self.whole_area() - self.area;
            if self.surplus.abs() <= AREA_LEFT {
                break;
            }
            let all: Vec<usize> = self.in_order().collect();
            let mut changed = Vec::new();
            if round + 1 < AREA_ROUNDS {
                changed = self.place(&all);
            } else {
                all.iter().for_each(|i| self.divide_run(*i, true, &mut changed));
            }
            self.settle(self.around(&changed));
        }
        self.surplus = self.whole_area() - self.area;
        let mut next = Some(0);
        while let Some(i) = next {
            while self.merge(i) {}
            next = self.next_before_end(i);
        }
        self.spline()
    }

    /// Moves all control points to where the area is kept, on the grid; which ones are elsewhere then.
    fn place(&mut self, all: &[usize]) -> Vec<usize> {
        let before: Vec<Point> = all.iter().map(|i| self.control(*i)).collect();
        self.surplus = self.whole_area() - self.area;
        self.keep_area(all);
        self.surplus = self.whole_area() - self.area;
        self.round(all);
        all.iter().zip(before).filter(|(i, before)| self.control(**i) != *before).map(|(i, _)| *i).collect()
    }

    /// Looks at pieces that are new or beside new ones, and gives up those that stray, until none does.
    fn settle(&mut self, mut new: Vec<usize>) {
        loop {
            let bad: Vec<usize> = new.into_iter().filter(|i| !(self.keeps_way(*i) && self.keeps_near(*i))).collect();
            if bad.is_empty() {
                return;
            }
            let changed = self.give_up(&bad);
            new = self.around(&changed);
        }
    }

    /// The next piece, if that is not the last.
    fn next_before_end(&self, i: usize) -> Option<usize> {
        let next = self.next(i);
        (next != 0 && next != i).then_some(next)
    }

    /// All pieces from begin to end.
    fn in_order(&self) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(0), |i| self.next_before_end(*i))
    }

    /// Joints and middles from where a run begins.
    fn halves_from(&self, k: usize) -> &[Point] {
        &self.halves[2 * (k + self.ahead)..]
    }

    /// The control point of the parabola through both ends of a run and its middle.
    fn parabola(&self, run: &Range<usize>) -> Point {
        let halves = self.halves_from(run.start);
        let [begin, middle, end] = [0, run.len(), 2 * run.len()].map(|h| halves[h]);
        middle + (middle - begin.midpoint(end))
    }

    /// Whether the parabola of a run strays less than some pixels.
    fn is_parabola(&self, run: &Range<usize>, limit: f64) -> bool {
        let halves = &self.halves_from(run.start)[..=2 * run.len()];
        let (begin, end) = (halves[0], halves[2 * run.len()]);
        let control = self.parabola(run);
        let legs = [control - begin, end - control];
        if legs.iter().any(|leg| leg.dot(end - begin) <= 0.0) {
            return false;
        }
        let step = 1.0 / (2 * run.len()) as f64;
        halves.iter().enumerate().skip(1).all(|(h, half)| {
            let t = h as f64 * step;
            let tangent = legs[0] * (1.0 - t) + legs[1] * t;
            let point = begin + legs[0] * (2.0 * t * (1.0 - t)) + (end - begin) * (t * t);
            let off = (*half - point).cross(tangent);
            off * off <= limit * limit * tangent.hypot2()
        })
    }

    /// Divides the outline into runs.
    fn divide(&mut self) {
        let (n, closed) = (self.outline.controls.len(), self.outline.closed);
        // The first and last piece of an open outline stay as they are.
        let last = if closed { n } else { n - 1 };
        let mut k = 0;
        if !closed {
            self.push_full(0);
            k = 1;
        }
        while k < last {
            let mut length = 1;
            for longer in 2..=LONGEST_RUN.min(last - k).min(n / LEAST_CLOSED) {
                if self.is_parabola(&(k..k + longer), self.first_guess) {
                    length = longer;
                } else if longer > length + 1 {
                    break;
                }
            }
            self.push(k..k + length);
            k += length;
        }
        if !closed && n > 1 {
            self.push_full(n - 1);
        }
        let m = self.pieces.len();
        for (i, piece) in self.pieces.iter_mut().enumerate() {
            piece.beside = if closed { [(i + m - 1) % m, (i + 1) % m] } else { [i.saturating_sub(1), (i + 1).min(m - 1)] };
        }
    }

    fn push(&mut self, run: Range<usize>) {
        let control = self.parabola(&run);
        self.pieces.push(Piece { run, control, is_full: false, beside: [0, 0] });
    }

    fn push_full(&mut self, k: usize) {
        let control = self.outline.controls[k];
        self.pieces.push(Piece { run: k..k + 1, control, is_full: true, beside: [0, 0] });
    }

    fn previous(&self, i: usize) -> usize {
        self.pieces[i].beside[0]
    }

    fn next(&self, i: usize) -> usize {
        self.pieces[i].beside[1]
    }

    fn control(&self, i: usize) -> Point {
        self.pieces[i].control
    }

    /// Both ends of a piece.
    fn joints(&self, i: usize) -> [Point; 2] {
        let piece = &self.pieces[i];
        // Between two pieces of the full outline, and at its ends, a joint is the full outline's.
        let joint = |beside: usize, k: usize| {
            let other = &self.pieces[beside];
            if piece.is_full && other.is_full { self.outline.joints[k] } else { piece.control.midpoint(other.control) }
        };
        [joint(piece.beside[0], piece.run.start), joint(piece.beside[1], piece.run.end)]
    }

    fn quad(&self, i: usize) -> QuadBez {
        let [begin, end] = self.joints(i);
        QuadBez::new(begin, self.pieces[i].control, end)
    }

    /// Whether a piece is one of the full outline.
    fn is_exact(&self, i: usize) -> bool {
        [self.previous(i), i, self.next(i)].iter().all(|k| self.pieces[*k].is_full)
    }

    fn area_of(&self, i: usize) -> f64 {
        if self.is_exact(i) { self.outline.area(self.pieces[i].run.start) } else { self.quad(i).signed_area() }
    }

    fn whole_area(&self) -> f64 {
        self.in_order().map(|i| self.area_of(i)).sum()
    }

    /// Places control points so that the middles of pieces are those of their runs.
    fn relax(&mut self, pieces: &[usize]) {
        for i in pieces {
            let Piece { is_full, ref run, beside: [previous, next], .. } = self.pieces[*i];
            if !is_full {
                let middle = self.halves_from(run.start)[run.len()].to_vec2();
                let beside = self.control(previous).to_vec2() + self.control(next).to_vec2();
                self.pieces[*i].control = ((middle * 8.0 - beside) / 6.0).to_point();
            }
        }
    }

    /// What moving a control point by a vector does to the area is their cross product.
    fn gain(&self, i: usize) -> Vec2 {
        let [previous, next] = self.pieces[i].beside;
        let [far_previous, far_next] = [self.previous(previous), self.next(next)];
        (self.control(next) - self.control(previous)) * (5.0 / 12.0) + (self.control(far_next) - self.control(far_previous)) / 24.0
    }

    /// Moves control points outwards, or all inwards, until the area is kept.
    fn keep_area(&mut self, pieces: &[usize]) {
        let gain = |of: &Self, i: usize| if of.pieces[i].is_full { Vec2::ZERO } else { of.gain(i) };
        let whole: f64 = pieces.iter().map(|i| gain(self, *i).hypot2().sqrt()).sum();
        let step = (-self.surplus / whole).clamp(-self.tolerance / 2.0, self.tolerance / 2.0);
        for i in pieces {
            let gain = gain(self, *i);
            let length = gain.hypot2().sqrt();
            if length > 0.0 {
                self.pieces[*i].control += Vec2::new(gain.y, -gain.x) * (step / length);
            }
        }
    }

    /// Rounds control points to the grid: of the four around, to the one that is near and leaves the least area over.
    fn round(&mut self, pieces: &[usize]) {
        for i in pieces {
            let Piece { is_full, control, .. } = self.pieces[*i];
            if is_full {
                continue;
            }
            let gain = self.gain(*i);
            let weight = AREA_WEIGHT / gain.hypot2().max(1e-9);
            let mut best = (f64::INFINITY, control, 0.0);
            for p in corners(control, self.units) {
                let step = p - control;
                let area = self.surplus + step.cross(gain);
                let cost = step.hypot2() + weight * area * area;
                if cost < best.0 {
                    best = (cost, p, area);
                }
            }
            (self.pieces[*i].control, self.surplus) = (best.1, best.2);
        }
    }

    /// Where the full outline, as straight lines between joints and middles, is nearest to a joint of the simpler one, on the way from
    /// where its piece k begins: the number in `halves` and the part of the way to the next. None if it is far off.
    fn nearest(&self, joint: Point, k: usize) -> Option<(usize, f64)> {
        let from = 2 * (k + self.ahead);
        let (mut half, mut went_on) = (from, false);
        loop {
            if half + 2 * REACH < from || half > from + 2 * REACH {
                return None;
            }
            // Open outlines end there.
            let Some(end) = self.halves.get(half + 1) else { return Some((half, 0.0)) };
            let begin = self.halves[half];
            let along = *end - begin;
            let (place, length) = ((joint - begin).dot(along), along.hypot2());
            if place >= length {
                (half, went_on) = (half + 1, true);
            } else if place >= 0.0 {
                return Some((half, place / length));
            } else if went_on || half == 0 {
                return Some((half, 0.0));
            } else {
                // Back, to the end of that or further.
                half -= 1;
                let (begin, end) = (self.halves[half], self.halves[half + 1]);
                if (joint - begin).dot(end - begin) >= (end - begin).hypot2() {
                    return Some((half + 1, 0.0));
                }
            }
        }
    }

    /// Whether a piece and the part of the full outline between the places nearest to its ends are within the tolerance of each other
    /// all along: their Fréchet distance.
    fn keeps_near(&self, i: usize) -> bool {
        if self.is_exact(i) {
            return true;
        }
        let run = &self.pieces[i].run;
        let QuadBez { p0, p1, p2 } = self.quad(i);
        let (Some((begin, before)), Some((end, behind))) = (self.nearest(p0, run.start), self.nearest(p2, run.end)) else {
            return false;
        };
        let length = (end as f64 + behind) - (begin as f64 + before);
        if length <= 0.0 {
            return false;
        }
        let bend_at = |half: usize| self.bends[(half / 2).min(self.bends.len() - 1)];
        let at = |half: usize, part: f64| {
            let straight = self.halves[half].lerp(self.halves[(half + 1).min(self.halves.len() - 1)], part);
            straight - bend_at(half) * (part * (1.0 - part))
        };
        let (legs, bend) = ([p1 - p0, p2 - p1], (p2 - p1) - (p1 - p0));
        // Half by half both are quadratic curves, and so is their difference: nowhere more than a quarter of its own second difference
        // longer than at one of its ends.
        let (mut t, mut off) = (0.0, (at(begin, before) - p0).hypot2());
        for half in begin..=end {
            let from = if half == begin { before } else { 0.0 };
            let (to, near, off_there) = if half == end {
                (behind, 1.0, (at(end, behind) - p2).hypot2())
            } else {
                let place = self.halves[half + 1];
                let guess = ((half + 1 - begin) as f64 - before) / length;
                let tangent = legs[0] + bend * guess;
                let away = place - (p0 + (legs[0] * 2.0 + bend * guess) * guess);
                // A step of Newton's method to the point that is nearest.
                let near = (guess + 0.5 * away.dot(tangent) / tangent.hypot2()).clamp(t, 1.0);
                (1.0, near, (place - (p0 + (legs[0] * 2.0 + bend * near) * near)).hypot2())
            };
            let difference = bend_at(half) * (to - from).powi(2) - bend * (near - t).powi(2);
            let left = self.tolerance - 0.25 * difference.hypot2().sqrt();
            if !(left > 0.0 && off.max(off_there) <= left * left) {
                return false;
            }
            (t, off) = (near, off_there);
        }
        true
    }

    /// Whether a piece keeps clear of all others.
    fn keeps_way(&mut self, i: usize) -> bool {
        if self.is_exact(i) {
            return true;
        }
        let (quad, run) = (self.quad(i), &self.pieces[i].run);
        let chord = quad.p2 - quad.p0;
        // Tangents in both joints; those of the full outline are its own.
        let [previous, next] = self.pieces[i].beside.map(|k| self.pieces[i].is_full && self.pieces[k].is_full);
        let begin = if previous { self.outline.direction(run.start) } else { quad.p1 - quad.p0 };
        let end = if next { self.outline.direction(run.end) } else { quad.p2 - quad.p1 };
        if !(begin.dot(chord) > 0.0 && end.dot(chord) > 0.0) {
            return false;
        }
        let [first, last] = [(quad.p0, run.start), (quad.p2, run.end)].map(|(p, k)| self.sleeve.cell_of(p, k));
        let (Some(first), Some(last)) = (first, last) else { return false };
        last > first && self.sleeve.holds_quad(&quad, first, last, [begin, end], &mut self.scratch)
    }

    /// Puts others in place of pieces that stray, or of those beside them if they are the full outline's; which ones are new.
    fn give_up(&mut self, bad: &[usize]) -> Vec<usize> {
        let mut changed = Vec::new();
        for i in bad {
            let around = if self.pieces[*i].is_full { self.pieces[*i].beside.to_vec() } else { vec![*i] };
            for k in around {
                // First a piece for each of the full outline's, on the grid; then those themselves.
                let is_full = self.pieces[k].run.len() == 1;
                self.divide_run(k, is_full, &mut changed);
            }
        }
        changed
    }

    /// Some pieces with two on each side of every one.
    fn around(&self, pieces: &[usize]) -> Vec<usize> {
        let mut around: Vec<usize> = pieces
            .iter()
            .flat_map(|i| {
                let [previous, next] = self.pieces[*i].beside;
                [self.previous(previous), previous, *i, next, self.next(next)]
            })
            .collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// Puts a piece for each of the full outline's in place of the one for all of its run: those themselves, or as they are on the grid.
    fn divide_run(&mut self, i: usize, is_full: bool, changed: &mut Vec<usize>) {
        if self.pieces[i].is_full {
            return;
        }
        let Piece { run, beside: [_, next], .. } = self.pieces[i].clone();
        let mut last = i;
        for k in run.clone() {
            let control = self.outline.controls[k];
            let control = if is_full { control } else { snap(control, self.units) };
            let piece = Piece { run: k..k + 1, control, is_full, beside: self.pieces[i].beside };
            if k == run.start {
                self.pieces[i] = piece;
            } else {
                self.pieces.push(piece);
                self.link(last, self.pieces.len() - 1);
                last = self.pieces.len() - 1;
            }
            changed.push(last);
        }
        self.link(last, next);
    }

    fn link(&mut self, previous: usize, next: usize) {
        self.pieces[previous].beside[1] = next;
        self.pieces[next].beside[0] = previous;
    }

    /// Whether a piece is the first or last of an open outline.
    fn is_end(&self, i: usize) -> bool {
        self.pieces[i].beside.contains(&i)
    }

    fn area_of_all(&self, pieces: &[usize]) -> f64 {
        pieces.iter().map(|i| self.area_of(*i)).sum()
    }

    /// Makes one of a piece and the next, if that strays nowhere; says whether it did.
    fn merge(&mut self, i: usize) -> bool {
        let [previous, next] = self.pieces[i].beside;
        let after = self.next(next);
        let run = self.pieces[i].run.start..self.pieces[next].run.end;
        // Not over the begin of a closed outline, of which four are left.
        let is_short = after == previous || self.next(after) == previous;
        if next == 0
            || is_short
            || run.len() > LONGEST_RUN
            || self.is_end(i)
            || self.is_end(next)
            || !self.is_parabola(&run, self.tolerance)
        {
            return false;
        }
        let (old, surplus) = (self.pieces[i].clone(), self.surplus);
        let area = self.area_of_all(&[previous, i, next, after]);
        (self.pieces[i].run, self.pieces[i].is_full) = (run, false);
        self.link(i, after);
        let changed = [i, previous, after];
        self.relax(&[i]);
        self.surplus = surplus + self.area_of_all(&changed) - area;
        self.keep_area(&[i]);
        self.surplus = surplus + self.area_of_all(&changed) - area;
        self.round(&[i]);
        let is_kept = self.surplus.abs() <= surplus.abs().max(AREA_LEFT);
        if is_kept && changed.into_iter().all(|k| self.keeps_way(k) && self.keeps_near(k)) {
            return true;
        }
        (self.pieces[i], self.surplus) = (old, surplus);
        self.link(i, next);
        self.link(next, after);
        false
    }

    fn spline(&self) -> Spline {
        let order: Vec<usize> = self.in_order().collect();
        let mut joints: Vec<Point> = order.iter().map(|i| self.joints(*i)[0]).collect();
        joints.extend(order.last().map(|i| self.joints(*i)[1]));
        let corners = order.iter().map(|i| self.is_exact(*i) && self.outline.corners[self.pieces[*i].run.start]).collect();
        Spline { controls: order.iter().map(|i| self.control(*i)).collect(), joints, corners, closed: self.outline.closed }
    }
}

/// The four points of a grid around p.
fn corners(p: Point, units: f64) -> [Point; 4] {
    // Not -0, as `snap` gives none.
    let [x, y] = [p.x, p.y].map(|v| [(v * units).floor() / units + 0.0, (v * units).ceil() / units + 0.0]);
    std::array::from_fn(|k| Point::new(x[k % 2], y[k / 2]))
}
