//! A sweep over lines that may not meet: what lies beside each of them, or where two of them touch. In: polygons and polylines; out,
//! for every one of them, the line next to its uppermost point on the left. Source: Shamos and Hoey, Geometric intersection problems
//! (1976), with the exact predicates of Shewchuk (1997), so that no rounding decides.
//!
//! # The idea
//! Points come in the order of y, then x. A line is cut into chains along which that order rises, and the chains that are under way
//! are kept from left to right, in a tree to find a place by and in a list to find neighbours by. Two chains that cross or touch are
//! neighbours before they do, so looking at every edge and its two neighbours finds the first such place, and up to there the order
//! of the chains is right. Time is n log n and memory linear in the number of points, wherever they lie.

use std::cell::Cell;
use std::cmp::Ordering;
use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::base::{Control, Result, segments_meet, side_of};

/// Points after which cancellation is looked for.
const LOOK_EVERY: usize = 1 << 14;

/// Stands for no chain.
const NONE: u32 = u32::MAX;

/// A line to sweep over: no two points that follow one another are equal, nor the last and the first of a closed one.
pub(super) struct Line {
    points: Vec<[f64; 2]>,
    closed: bool,
    /// Whether others may begin and end where it begins, and where it ends, as in a junction.
    joins: [bool; 2],
}

impl Line {
    /// The line through finite points; `None` if it is a closed one of less than three, or an open one that ends where it begins.
    pub(super) fn new(points: impl Iterator<Item = [f64; 2]>, closed: bool) -> Option<Self> {
        // No -0, which would be another place in the order.
        let mut points: Vec<[f64; 2]> = points.map(|point| point.map(|v| v + 0.0)).collect();
        points.dedup();
        while closed && points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let is_line = if closed { points.len() >= 3 } else { points.first() != points.last() };
        is_line.then_some(Self { points, closed, joins: [false; 2] })
    }

    /// The line, an open one, where other ends that join may lie on its begin, and on its end.
    pub(super) fn joining(self, joins: [bool; 2]) -> Self {
        Self { joins, ..self }
    }
}

/// What lies beside a place, to the left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Neighbour {
    /// Which line.
    pub(super) line: u32,
    /// Whether the line runs down there, by y and then x.
    pub(super) falls: bool,
}

/// The uppermost point of a line, the leftmost of those, and what lies there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Top {
    pub(super) line: u32,
    pub(super) point: [f64; 2],
    /// `None` where there is nothing on the left.
    pub(super) beside: Option<Neighbour>,
    /// Whether a closed line encloses what is on its left.
    pub(super) turns_left: bool,
    /// Where it is an end of an open line, whether the line begins there.
    pub(super) end: Option<bool>,
}

/// Two lines that touch or cross, or one that does so with itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    pub(super) lines: [u32; 2],
    /// Near where.
    pub(super) at: [f64; 2],
}

impl Meeting {
    fn of(mut lines: [u32; 2], at: [f64; 2]) -> Self {
        lines.sort_unstable();
        Self { lines, at }
    }
}

/// What a sweep comes to.
pub(super) enum Swept {
    /// No two lines meet: the tops of all lines, from the first to the last.
    Apart(Vec<Top>),
    Meeting(Meeting),
}

/// Sweeps over lines.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub(super) fn sweep(lines: &[Line], control: &Control) -> Result<Swept> {
    let chains = Chains::of(lines);
    let mut events = chains.events();
    // No two are equal, so their order does not depend on the threads.
    events.par_sort_unstable_by(|a, b| order(a.point, b.point).then((a.chain, a.step).cmp(&(b.chain, b.step))));
    let mut front = Front::new(&chains);
    let mut tops = Vec::with_capacity(lines.len());
    let mut seen = vec![false; lines.len()];
    for (count, group) in events.chunk_by(|a, b| a.point == b.point).enumerate() {
        if count.is_multiple_of(LOOK_EVERY) {
            control.check()?;
        }
        let at = group[0].point;
        if let Some(lines) = chains.collision(group) {
            return Ok(Swept::Meeting(Meeting::of(lines, at)));
        }
        let of_kind = |kind: Kind| -> Vec<Event> { group.iter().copied().filter(|event| chains.kind(*event) == kind).collect() };
        let (ending, beginning) = (of_kind(Kind::End), of_kind(Kind::Begin));
        let mut met = if ending.is_empty() && beginning.is_empty() { front.advance(group[0].chain) } else { front.remove(&ending) };
        if !beginning.is_empty() {
            let (left, meeting) = front.insert(&beginning);
            met = met.or(meeting);
            let line = chains.line(left);
            if !std::mem::replace(&mut seen[line as usize], true) {
                let falls = |chain: u32| chains.all[chain as usize].falls;
                let before = front.before[left as usize];
                let beside = (before != NONE).then(|| Neighbour { line: chains.line(before), falls: falls(before) });
                let end = (beginning.iter().filter(|event| chains.line(event.chain) == line).count() == 1).then(|| falls(left));
                tops.push(Top { line, point: at, beside, turns_left: !falls(left), end });
            }
        }
        if let Some([a, b]) = met {
            return Ok(Swept::Meeting(Meeting::of([a, b].map(|chain| chains.line(chain)), at)));
        }
    }
    Ok(Swept::Apart(tops))
}

/// By y, then x.
fn order(a: [f64; 2], b: [f64; 2]) -> Ordering {
    a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
}

/// Two points in their order.
type Edge = [[f64; 2]; 2];

/// Whether two edges have a point in common, other than one in which both begin or both end.
fn meet(a: Edge, b: Edge) -> bool {
    if a[0] == b[0] || a[1] == b[1] {
        // They lie on one another if they are in line.
        return side_of(a, b[usize::from(a[0] == b[0])]) == 0.0;
    }
    segments_meet(a, b)
}

/// A piece of a line along which the order of points rises.
struct Chain {
    line: u32,
    /// Its points in [`Chains::points`].
    begin: u32,
    end: u32,
    /// Whether the line itself runs that way.
    falls: bool,
    /// Whether it begins, and whether it ends, in an end of its line that joins others.
    joins: [bool; 2],
    /// Where the edge begins that the sweep has come to.
    current: Cell<u32>,
}

/// All chains.
struct Chains {
    all: Vec<Chain>,
    points: Vec<[f64; 2]>,
}

/// A point of a chain.
#[derive(Clone, Copy)]
struct Event {
    point: [f64; 2],
    chain: u32,
    /// Its place in the chain.
    step: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Begin,
    Between,
    End,
}

impl Chains {
    fn of(lines: &[Line]) -> Self {
        let mut chains = Self { all: Vec::new(), points: Vec::new() };
        for (number, line) in (0u32..).zip(lines) {
            let count = line.points.len();
            let edges = if line.closed { count } else { count - 1 };
            let falls = |edge: usize| order(line.points[edge % count], line.points[(edge + 1) % count]) == Ordering::Less;
            // A closed line is entered where it turns.
            let first = if line.closed { (0..count).find(|edge| falls(*edge) != falls(edge + count - 1)).unwrap_or(0) } else { 0 };
            let mut from = first;
            while from < first + edges {
                let to = (from + 1..first + edges).find(|edge| falls(*edge) != falls(from)).unwrap_or(first + edges);
                let begin = chains.points.len();
                chains.points.extend((from..=to).map(|point| line.points[point % count]));
                if !falls(from) {
                    chains.points[begin..].reverse();
                }
                let end = chains.points.len() as u32;
                let (falls, current) = (falls(from), Cell::new(begin as u32));
                let mut joins = [line.joins[0] && from == 0, line.joins[1] && to == edges];
                if !falls {
                    joins.reverse();
                }
                chains.all.push(Chain { line: number, begin: begin as u32, end, falls, joins, current });
                from = to;
            }
        }
        chains
    }

    fn line(&self, chain: u32) -> u32 {
        self.all[chain as usize].line
    }

    fn events(&self) -> Vec<Event> {
        let of_chain = |(number, chain): (u32, &Chain)| {
            let points = &self.points[chain.begin as usize..chain.end as usize];
            (0u32..).zip(points).map(move |(step, point)| Event { point: *point, chain: number, step })
        };
        (0u32..).zip(&self.all).flat_map(of_chain).collect()
    }

    fn kind(&self, event: Event) -> Kind {
        let chain = &self.all[event.chain as usize];
        match event.step {
            0 => Kind::Begin,
            step if step + 1 == chain.end - chain.begin => Kind::End,
            _ => Kind::Between,
        }
    }

    /// The lines that collide in a point; `None` if all that is there is one line, which passes, begins, ends or turns once, or are ends
    /// that join.
    fn collision(&self, group: &[Event]) -> Option<[u32; 2]> {
        let first = group[0];
        let joins = |event: &Event| match self.kind(*event) {
            Kind::Begin => self.all[event.chain as usize].joins[0],
            Kind::Between => false,
            Kind::End => self.all[event.chain as usize].joins[1],
        };
        if group.iter().all(joins) {
            return None;
        }
        let goes_on = match *group {
            [_] => true,
            [a, b] => self.kind(a) == self.kind(b) && self.kind(a) != Kind::Between && self.line(a.chain) == self.line(b.chain),
            _ => false,
        };
        let other = group.iter().map(|event| self.line(event.chain)).find(|line| *line != self.line(first.chain));
        (!goes_on).then(|| [self.line(first.chain), other.unwrap_or(self.line(first.chain))])
    }
}

/// The chains that are under way.
struct Front<'a> {
    chains: &'a Chains,
    tree: BTreeSet<UnderWay<'a>>,
    before: Vec<u32>,
    after: Vec<u32>,
    leftmost: u32,
}

impl<'a> Front<'a> {
    fn new(chains: &'a Chains) -> Self {
        let nowhere = vec![NONE; chains.all.len()];
        Self { chains, tree: BTreeSet::new(), before: nowhere.clone(), after: nowhere, leftmost: NONE }
    }

    /// Goes on to the next edge of a chain. Returns chains that meet, as all of these do.
    fn advance(&mut self, chain: u32) -> Option<[u32; 2]> {
        let current = &self.chains.all[chain as usize].current;
        current.set(current.get() + 1);
        self.meeting(self.before[chain as usize], chain).or_else(|| self.meeting(chain, self.after[chain as usize]))
    }

    /// Takes up the chains that begin in a point; returns the one on the left, too.
    fn insert(&mut self, group: &[Event]) -> (u32, Option<[u32; 2]>) {
        let mut begun: Vec<UnderWay> = group.iter().map(|event| UnderWay { chain: event.chain, chains: self.chains }).collect();
        begun.sort_unstable();
        let numbers: Vec<u32> = begun.iter().map(|chain| chain.chain).collect();
        let mut last = self.tree.range(..&begun[0]).next_back().map_or(NONE, |chain| chain.chain);
        let after = if last == NONE { self.leftmost } else { self.after[last as usize] };
        let mut met = None;
        for &chain in numbers.iter().chain([&after]) {
            met = met.or_else(|| self.meeting(last, chain));
            self.link(last, chain);
            last = chain;
        }
        self.tree.extend(begun);
        (numbers[0], met)
    }

    /// Leaves the chains that end in a point.
    fn remove(&mut self, group: &[Event]) -> Option<[u32; 2]> {
        let mut beside = [NONE; 2];
        for event in group {
            self.tree.remove(&UnderWay { chain: event.chain, chains: self.chains });
            beside = [self.before[event.chain as usize], self.after[event.chain as usize]];
            self.link(beside[0], beside[1]);
        }
        self.meeting(beside[0], beside[1])
    }

    fn link(&mut self, chain: u32, next: u32) {
        match chain {
            NONE => self.leftmost = next,
            _ => self.after[chain as usize] = next,
        }
        if next != NONE {
            self.before[next as usize] = chain;
        }
    }

    /// Two chains, if both are there and meet.
    fn meeting(&self, a: u32, b: u32) -> Option<[u32; 2]> {
        let edge = |chain| UnderWay { chain, chains: self.chains }.edge();
        (a != NONE && b != NONE && meet(edge(a), edge(b))).then_some([a, b])
    }
}

/// A chain that is under way, less than those to the right of it.
struct UnderWay<'a> {
    chain: u32,
    chains: &'a Chains,
}

impl UnderWay<'_> {
    fn edge(&self) -> Edge {
        let from = self.chains.all[self.chain as usize].current.get() as usize;
        [self.chains.points[from], self.chains.points[from + 1]]
    }
}

impl Ord for UnderWay<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        if self.chain == other.chain {
            return Ordering::Equal;
        }
        let (own, its) = (self.edge(), other.edge());
        // The edge that begins later is seen from the one that was there.
        let seen_from = |edge: Edge, seen: Edge| {
            let begin = side_of(edge, seen[0]);
            let decides = if begin == 0.0 { side_of(edge, seen[1]) } else { begin };
            0.0.partial_cmp(&decides).unwrap_or(Ordering::Equal)
        };
        let is_earlier = order(own[0], its[0]) == Ordering::Less;
        let place = if is_earlier { seen_from(own, its).reverse() } else { seen_from(its, own) };
        place.then(self.chain.cmp(&other.chain))
    }
}

impl PartialOrd for UnderWay<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for UnderWay<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.chain == other.chain
    }
}

impl Eq for UnderWay<'_> {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn line(points: &[[f64; 2]], closed: bool) -> Line {
        Line::new(points.iter().copied(), closed).unwrap()
    }

    fn square(x: f64, y: f64, side: f64) -> Line {
        line(&[[x, y], [x + side, y], [x + side, y + side], [x, y + side]], true)
    }

    fn tops(lines: &[Line]) -> Vec<Top> {
        match sweep(lines, &Control::new()).unwrap() {
            Swept::Apart(tops) => tops,
            Swept::Meeting(meeting) => panic!("{meeting:?}"),
        }
    }

    fn meeting(lines: &[Line]) -> Option<[u32; 2]> {
        match sweep(lines, &Control::new()).unwrap() {
            Swept::Apart(_) => None,
            Swept::Meeting(Meeting { lines, .. }) => Some(lines),
        }
    }

    #[test]
    fn what_lies_beside_is_the_nearest_on_the_left() {
        let backwards = line(&[[2.0, 2.0], [2.0, 4.0], [4.0, 4.0], [4.0, 2.0]], true);
        let tops = tops(&[square(0.0, 0.0, 10.0), backwards, square(6.0, 2.5, 2.0), square(2.5, 2.5, 1.0)]);
        let found: Vec<_> = tops.iter().map(|top| (top.line, top.beside, top.turns_left)).collect();
        let beside = |line, falls| Some(Neighbour { line, falls });
        assert_eq!(found, [(0, None, true), (1, beside(0, false), false), (3, beside(1, true), true), (2, beside(1, false), true)]);
        assert_eq!(tops[2].point, [2.5, 2.5]);
    }

    #[test]
    fn what_touches_is_found() {
        let a = || square(1.0, 1.0, 4.0);
        // Nothing meets, however near.
        assert_eq!(meeting(&[a(), square(5.0_f64.next_up(), 1.0, 4.0), square(1.0, 5.0_f64.next_up(), 4.0)]), None);
        for (other, why) in [
            (square(1.0, 1.0, 4.0), "the same twice"),
            (square(5.0, 1.0, 4.0), "a side in common"),
            (square(5.0, 5.0, 4.0), "a corner in common"),
            (square(5.0, 2.0, 1.0), "a part of a side in common"),
            (square(3.0, 3.0, 4.0), "they cross"),
            (line(&[[5.0, 3.0], [7.0, 2.0], [7.0, 4.0]], true), "a corner on a side"),
            (line(&[[0.0, 3.0], [9.0, 3.0]], false), "an open one crosses"),
            (line(&[[0.0, 0.0], [5.0, 1.0]], false), "an open one ends on a corner"),
            (line(&[[3.0, 0.0], [3.0, 3.0]], false), "an open one ends inside"),
        ] {
            assert_eq!(meeting(&[a(), other]), Some([0, 1]), "{why}");
        }
        for (points, why) in [
            (vec![[1.0, 1.0], [5.0, 5.0], [5.0, 1.0], [1.0, 5.0]], "a bow-tie"),
            (vec![[1.0, 1.0], [5.0, 1.0], [3.0, 3.0], [5.0, 5.0], [1.0, 5.0], [3.0, 3.0]], "it touches itself in a point"),
            (vec![[1.0, 1.0], [5.0, 1.0], [5.0, 5.0], [5.0, 3.0]], "it goes back on itself"),
            (vec![[1.0, 1.0], [5.0, 1.0], [3.0, 1.0]], "it has no inside"),
            (vec![[1.0, 3.0], [5.0, 1.0], [9.0, 3.0], [5.0, 1.0]], "it has no inside but turns"),
        ] {
            assert_eq!(meeting(&[line(&points, true)]), Some([0, 0]), "{why}");
        }
    }

    #[test]
    fn ends_that_join_do_not_touch_and_nothing_is_seen_through_them() {
        let joining = |points: &[[f64; 2]], joins| line(points, false).joining(joins);
        let junction = || {
            [
                joining(&[[5.0, 0.0], [5.0, 5.0]], [false, true]),
                joining(&[[5.0, 5.0], [5.0, 10.0]], [true, false]),
                joining(&[[2.0, 6.0], [5.0, 5.0]], [false, true]),
            ]
        };
        for (top, expected) in [(5.0_f64.next_down(), 0), (5.0, 1), (5.0_f64.next_up(), 1)] {
            let [a, b, c] = junction();
            let tops = tops(&[a, b, c, square(7.0, top, 1.0)]);
            let found = tops.iter().find(|top| top.line == 3).and_then(|top| top.beside);
            assert_eq!(found, Some(Neighbour { line: expected, falls: true }), "{top}");
        }
        for (other, why) in [
            (joining(&[[8.0, 6.0], [5.0, 5.0]], [true, false]), "an end that does not join"),
            (joining(&[[8.0, 9.0], [5.0, 5.0], [9.0, 8.0]], [true, true]), "a turn between ends that join"),
            (joining(&[[8.0, 2.0], [5.0, 5.0], [9.0, 8.0]], [true, true]), "a line that passes"),
            (joining(&[[5.0, 5.0], [5.0, 8.0]], [true, false]), "one on another"),
        ] {
            let [a, b, c] = junction();
            assert!(meeting(&[a, b, c, other]).is_some(), "{why}");
        }
    }

    #[test]
    fn a_sweep_can_be_stopped() {
        let control = Control::new();
        control.cancel();
        assert!(sweep(&[square(0.0, 0.0, 1.0)], &control).is_err());
    }

    /// Whether two segments have a point in common, in whole numbers.
    fn naive([a, b]: [[i64; 2]; 2], [c, d]: [[i64; 2]; 2]) -> bool {
        let turn = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let on = |a: [i64; 2], b: [i64; 2], p: [i64; 2]| {
            turn(a, b, p) == 0 && (0..2).all(|k| (a[k].min(b[k])..=a[k].max(b[k])).contains(&p[k]))
        };
        let crossed = turn(a, b, c).signum() * turn(a, b, d).signum() < 0 && turn(c, d, a).signum() * turn(c, d, b).signum() < 0;
        crossed || on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn it_finds_what_looking_at_all_pairs_finds(
            shapes in prop::collection::vec((prop::collection::vec((0i64..9, 0i64..9), 3..5), 0i64..30, 0i64..30, any::<bool>()), 1..9),
        ) {
            let moved = shapes.iter().map(|(points, x, y, closed)| {
                (points.iter().map(|(a, b)| [a + x, b + y]).collect::<Vec<_>>(), *closed)
            });
            let swept: Vec<(Vec<[i64; 2]>, bool, Line)> = moved.filter_map(|(points, closed)| {
                let line = Line::new(points.iter().map(|p| p.map(|v| v as f64)), closed)?;
                Some((line.points.iter().map(|p| p.map(|v| v as i64)).collect(), closed, line))
            }).collect();
            let edges: Vec<Vec<[[i64; 2]; 2]>> = swept.iter().map(|(points, closed, _)| {
                let count = if *closed { points.len() } else { points.len() - 1 };
                (0..count).map(|k| [points[k], points[(k + 1) % points.len()]]).collect()
            }).collect();
            let mut meets = false;
            for (i, own) in edges.iter().enumerate() {
                for (k, a) in own.iter().enumerate() {
                    for (n, b) in own.iter().enumerate().skip(k + 1) {
                        let follows = n == k + 1 || (k == 0 && n + 1 == own.len() && swept[i].1);
                        // Those that follow one another meet in one point, or lie on one another.
                        let (p, q, r) = if n == k + 1 { (a[0], a[1], b[1]) } else { (b[0], b[1], a[1]) };
                        let turn = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
                        let back = (q[0] - p[0]) * (r[0] - q[0]) + (q[1] - p[1]) * (r[1] - q[1]) < 0;
                        meets |= if follows { turn == 0 && back } else { naive(*a, *b) };
                    }
                    meets |= edges[i + 1..].iter().flatten().any(|b| naive(*a, *b));
                }
            }
            let lines: Vec<Line> = swept.into_iter().map(|(_, _, line)| line).collect();
            prop_assert_eq!(meeting(&lines).is_some(), meets);
        }
    }
}
