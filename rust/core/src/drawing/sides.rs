//! What lies beside curves and dots, found again from where they are.
//!
//! Next to a curve lies what its nearest neighbour to the left has on its right; a sweep finds the neighbours (see
//! [`super::sweep`]), and along the frame the ends of open curves are neighbours. Around a junction every ink lies between two curves.
//! Where not all of an ink is known, the places that are joined tell it together, and across curves what does not change there.
//! Of curves that hang together by junctions and are not on the frame, the uppermost point of all says what is around them.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use kurbo::{BezPath, Point, Shape as _};

use crate::base::{Control, Frame, Ink, Result, is_closed, side_of};
use crate::drawing::assembly::{FrameEnd, assemble, ends_of, ends_on_frame, junctions};
use crate::drawing::data::Drawing;
use crate::drawing::joined::Joined;
use crate::drawing::known::Known;
use crate::drawing::loose::{Loose, Names, Shape, invalid};
use crate::drawing::sweep::Top;
use crate::outlines::{Parts, Stipple};

/// The drawing of curves and dots; its provenance is left empty. `names` says what they are called where they stand.
///
/// # Errors
/// [`crate::Error::Input`] if they are no drawing, [`crate::Error::Cancelled`].
pub(crate) fn put_together(loose: Loose, names: Names, control: &Control) -> Result<Drawing> {
    let tops = loose.check(names, control)?;
    let mut sides = Sides::new(&loose, names)?;
    for top in &tops {
        control.check()?;
        sides.take_up(top)?;
    }
    if let Some(cluster) = sides.is_placed.iter().position(|is_placed| !is_placed) {
        return Err(sides.lost(cluster));
    }
    let (known, ids) = sides.components();
    let mut inks = sides.told(known, &ids)?;
    let beside = |number: usize| [ids[left_side(number)], ids[right_side(number)]];
    let mut stipples = Vec::with_capacity(loose.stipples.len());
    for (number, (dot, around)) in loose.stipples.iter().zip(&sides.around).enumerate() {
        let around = ids[*around];
        let ink = loose.dots.get(number).map_or(dot.ink, |known| known.or(inks[around as usize]));
        if ink == inks[around as usize] {
            let ink = loose.palette.name(ink);
            return Err(invalid(format!("{} is {ink} and lies in {ink}", names(Shape::Stipple(number)))));
        }
        stipples.push((Stipple { ink, ..*dot }, [inks.len() as u32, around]));
        inks.push(ink);
    }
    let on_frame = ids[sides.ground];
    let Loose { width, height, units, palette, curves, .. } = loose;
    let with_sides = |(number, curve): (usize, BezPath)| {
        let [left, right] = beside(number);
        // The lower ink is on the left.
        let is_oriented = inks[left as usize] < inks[right as usize];
        if is_oriented { (curve, [left, right]) } else { (curve.reverse_subpaths(), [right, left]) }
    };
    let curves = curves.into_iter().enumerate().map(with_sides).collect();
    let parts = Parts { width, height, units, palette, curves, stipples, inks, on_frame };
    assemble(parts).map_err(|error| invalid(format!("its shapes do not fit together ({error})")))
}

fn left_side(curve: usize) -> usize {
    2 * curve
}

fn right_side(curve: usize) -> usize {
    2 * curve + 1
}

/// Both sides of every curve, joined where nothing lies between them.
struct Sides<'a> {
    loose: &'a Loose,
    names: Names<'a>,
    frame: Frame,
    /// The sides of every component.
    joined: Joined,
    /// What is known of them.
    inks: Vec<Known>,
    /// What stands for the canvas where no curve ends on the frame.
    ground: usize,
    ends: Vec<FrameEnd>,
    /// The side that every dot lies in.
    around: Vec<usize>,
    /// What every curve hangs together with by junctions, and of each of these whether it is known what is around it.
    clusters: Vec<u32>,
    is_placed: Vec<bool>,
}

impl<'a> Sides<'a> {
    fn new(loose: &'a Loose, names: Names<'a>) -> Result<Self> {
        let ground = 2 * loose.curves.len();
        let mut inks: Vec<Known> = (0..loose.curves.len()).flat_map(|curve| loose.inks(curve)).collect();
        // What stands for the canvas has the ink of the first that is found there.
        // Of two inks a dot lies in the other.
        let of_dot = loose.stipples.first().filter(|_| loose.palette.len() == 2);
        inks.push(Known::of(of_dot.map_or(loose.ground, |dot| dot.ink.other())));
        let (frame, joined) = (loose.frame(), Joined::new(inks.len()));
        let ends = ends_on_frame(frame, &loose.curves);
        let (clusters, count) = clusters(frame, loose);
        let mut sides = Self {
            loose,
            names,
            frame,
            joined,
            inks,
            ground,
            ends,
            around: vec![ground; loose.stipples.len()],
            clusters,
            is_placed: vec![false; count],
        };
        for k in 0..sides.ends.len() {
            let cluster = sides.clusters[sides.ends[k].curve as usize];
            sides.is_placed[cluster as usize] = true;
        }
        sides.join_in_junctions()?;
        for k in 0..sides.ends.len() {
            let next = (k + 1) % sides.ends.len();
            let ([_, after], [before, _]) = (sides.around(k), sides.around(next));
            let curve = Shape::Curve(sides.ends[k].curve as usize);
            sides
                .join(after, before)
                .map_err(|inks| sides.differ(curve, Some(Shape::Curve(sides.ends[next].curve as usize)), inks))?;
        }
        Ok(sides)
    }

    /// Joins the sides of every ink around every junction.
    fn join_in_junctions(&mut self) -> Result<()> {
        let mut around: Vec<Vec<(u32, bool)>> = junctions(self.frame, &self.loose.curves).into_values().collect();
        around.sort_unstable();
        for ends in around {
            let shape = Shape::Curve(ends[0].0 as usize);
            let of_inks = <[_; 3]>::try_from(ends).ok().and_then(|ends| self.sides_of_inks(ends));
            let of_inks = of_inks.ok_or_else(|| invalid(format!("{} ends where no three inks meet", (self.names)(shape))))?;
            for [a, b] in of_inks {
                self.join(a, b).map_err(|inks| self.differ(shape, None, inks))?;
            }
        }
        Ok(())
    }

    /// The two sides of every ink around a junction of three curves, each with whether it begins there; `None` if there are no three
    /// inks.
    fn sides_of_inks(&self, ends: [(u32, bool); 3]) -> Option<[[usize; 2]; 3]> {
        let sides = ends.map(|(curve, _)| [left_side(curve as usize), right_side(curve as usize)]);
        if sides.as_flattened().iter().any(|side| !self.inks[*side].is_all()) {
            return self.sides_between(ends);
        }
        // Sides of one ink were of one ink before, whatever was joined to them.
        let mut of_inks: BTreeMap<Ink, Vec<usize>> = BTreeMap::new();
        for side in sides.as_flattened() {
            of_inks.entry(self.inks[*side].ink()).or_default().push(*side);
        }
        let pairs: Vec<[usize; 2]> = of_inks.into_values().map(|sides| sides.try_into().ok()).collect::<Option<_>>()?;
        pairs.try_into().ok()
    }

    /// The same by the places of the curves: what is to the left of one is to the right of the next one around.
    fn sides_between(&self, ends: [(u32, bool); 3]) -> Option<[[usize; 2]; 3]> {
        let (curve, begins) = ends[0];
        let [begin, end] = ends_of(&self.loose.curves[curve as usize]);
        let Point { x, y } = if begins { begin } else { end };
        let next = ends.map(|(curve, begins)| self.loose.next_to(curve, begins));
        let turn = |from: usize, to: usize| side_of([[x, y], next[from]], next[to]).partial_cmp(&0.0);
        // Left of the first or opposite to it, and then how the other two follow each other.
        let half = |k: usize| turn(0, k).map(Ordering::reverse);
        let order = half(1).cmp(&half(2)).then_with(|| turn(1, 2).map_or(Ordering::Equal, Ordering::reverse));
        let around = match order {
            Ordering::Less => [0, 1, 2],
            Ordering::Greater => [0, 2, 1],
            Ordering::Equal => return None,
        };
        // Seen from the junction.
        let side = |k: usize, left: bool| {
            let (curve, begins) = ends[around[k % 3]];
            if left == begins { left_side(curve as usize) } else { right_side(curve as usize) }
        };
        Some([0, 1, 2].map(|k| [side(k, true), side(k + 1, false)]))
    }

    /// That nothing says what is around a cluster.
    fn lost(&self, cluster: usize) -> crate::Error {
        let curve = self.clusters.iter().position(|of_curve| *of_curve as usize == cluster).unwrap_or_default();
        invalid(format!("{} has no uppermost point", (self.names)(Shape::Curve(curve))))
    }

    /// The sides on the frame just before and just after an end, in the positive direction.
    fn around(&self, k: usize) -> [usize; 2] {
        let curve = self.ends[k].curve as usize;
        self.ends[k].around([left_side(curve), right_side(curve)])
    }

    /// Makes two sides one, or gives their inks if they differ.
    fn join(&mut self, a: usize, b: usize) -> std::result::Result<(), [Ink; 2]> {
        let (a, b) = (self.joined.lowest(a), self.joined.lowest(b));
        // What stands for the canvas has the ink of the first that is found there.
        let stand_in = 2 * self.loose.curves.len();
        if a == stand_in && self.inks[b].is_all() {
            self.inks[a] = self.inks[b];
        }
        if b == stand_in && self.inks[a].is_all() {
            self.inks[b] = self.inks[a];
        }
        let known = self.inks[a].and(self.inks[b]).ok_or_else(|| [a, b].map(|side| self.inks[side].ink()))?;
        (self.inks[a], self.inks[b]) = (known, known);
        self.joined.join(a, b);
        if a.max(b) == self.ground {
            self.ground = a.min(b);
        }
        Ok(())
    }

    fn differ(&self, shape: Shape, beside: Option<Shape>, [own, other]: [Ink; 2]) -> crate::Error {
        let beside = beside.map_or_else(|| "the edge of the canvas".to_owned(), self.names);
        let [own, other] = [own, other].map(|ink| self.loose.palette.name(ink));
        invalid(format!("{} is {own} towards {beside}, which is {other} there", (self.names)(shape)))
    }

    /// Takes up what lies beside the top of a curve or a dot. What lies on the left was taken up before.
    fn take_up(&mut self, top: &Top) -> Result<()> {
        let shape = self.loose.shape(top.line);
        let neighbour = top.beside.map(|beside| (self.loose.shape(beside.line), beside.falls));
        let side = match neighbour {
            // What falls has its left side on the left of who looks at it.
            Some((Shape::Curve(curve), falls)) => {
                if falls {
                    right_side(curve)
                } else {
                    left_side(curve)
                }
            }
            // The polygon of a dot falls on the right.
            Some((Shape::Stipple(dot), true)) => self.around[dot],
            Some((dot, false)) => return Err(invalid(format!("{} lies in {}", (self.names)(shape), (self.names)(dot)))),
            None => self.on_left_of_frame(top.point[1]),
        };
        match shape {
            Shape::Stipple(dot) => self.around[dot] = side,
            Shape::Curve(number) if is_closed(&self.loose.curves[number]) => {
                self.is_placed[self.clusters[number] as usize] = true;
                let area = self.loose.curves[number].area();
                if area == 0.0 || (area > 0.0) != top.turns_left {
                    return Err(invalid(format!("{} encloses nothing", (self.names)(shape))));
                }
                let outer = if top.turns_left { right_side(number) } else { left_side(number) };
                self.join(outer, side).map_err(|inks| self.differ(shape, neighbour.map(|(shape, _)| shape), inks))?;
            }
            // An open one: if the frame has not said it, what comes first of all that hangs together says it.
            Shape::Curve(number) => {
                if !std::mem::replace(&mut self.is_placed[self.clusters[number] as usize], true) {
                    let outer = self.side_around_top(number, top);
                    self.join(outer, side).map_err(|inks| self.differ(shape, neighbour.map(|(shape, _)| shape), inks))?;
                }
            }
        }
        Ok(())
    }

    /// The side of an open curve that is around its uppermost point.
    fn side_around_top(&self, number: usize, top: &Top) -> usize {
        let is_right = match top.end {
            // It begins there and falls, with its left on the left of who looks at it; or it rises and ends there.
            Some(begins) => !begins,
            None => top.turns_left,
        };
        if is_right { right_side(number) } else { left_side(number) }
    }

    /// The side that lies at the left of the frame, at a height or just below.
    fn on_left_of_frame(&self, y: f64) -> usize {
        if self.ends.is_empty() {
            return self.ground;
        }
        // The frame runs upwards here.
        let place = self.frame.place(Point::new(0.0, y));
        let behind = self.ends.partition_point(|end| end.place < place);
        self.around((behind + self.ends.len() - 1) % self.ends.len())[1]
    }

    /// What is known of the ink of every component, and the component of every side.
    fn components(&mut self) -> (Vec<Known>, Vec<u32>) {
        let mut inks = Vec::new();
        let mut ids = vec![u32::MAX; self.joined.len()];
        // The stand-in for the canvas counts only where it is needed.
        let count = if self.ends.is_empty() { self.joined.len() } else { self.joined.len() - 1 };
        for side in 0..count {
            let root = self.joined.lowest(side);
            if ids[root] == u32::MAX {
                ids[root] = inks.len() as u32;
                inks.push(self.inks[root]);
            }
            ids[side] = ids[root];
        }
        (inks, ids)
    }

    /// The inks of components, by what is known of them and of what is beside them: what a curve does not tell is the same on both of
    /// its sides.
    fn told(&self, mut known: Vec<Known>, ids: &[u32]) -> Result<Vec<Ink>> {
        let curves = self.loose.curves.len();
        let beside = |curve: usize| [ids[left_side(curve)], ids[right_side(curve)]];
        let name = |curve: usize| (self.names)(Shape::Curve(curve));
        if known.iter().any(|known| !known.is_all()) {
            let mut across: Vec<Vec<(usize, u32, u8)>> = vec![Vec::new(); known.len()];
            for curve in 0..curves {
                let [left, right] = self.loose.inks(curve);
                let [a, b] = beside(curve);
                let same = left.open() & right.open();
                across[a as usize].push((curve, b, same));
                across[b as usize].push((curve, a, same));
            }
            let mut open: Vec<u32> = (0..known.len() as u32).collect();
            while let Some(component) = open.pop() {
                let own = known[component as usize];
                for (curve, other, same) in &across[component as usize] {
                    let its = &mut known[*other as usize];
                    let both = its.and(own.only(*same));
                    let both =
                        both.ok_or_else(|| invalid(format!("what layers tell beside {} goes not together", name(*curve))))?;
                    if std::mem::replace(its, both) != both {
                        open.push(*other);
                    }
                }
            }
        }
        for curve in 0..curves {
            let [left, right] = beside(curve).map(|component| known[component as usize]);
            if !left.is_all() || !right.is_all() {
                return Err(invalid(format!("nothing tells what is beside {}", name(curve))));
            }
            if left == right {
                return Err(invalid(format!("{} has {} on both sides", name(curve), self.loose.palette.name(left.ink()))));
            }
        }
        Ok(known.into_iter().map(Known::ink).collect())
    }
}

/// What every curve hangs together with by junctions, by numbers from 0 on, and how many there are.
fn clusters(frame: Frame, loose: &Loose) -> (Vec<u32>, usize) {
    let mut joined = Joined::new(loose.curves.len());
    for ends in junctions(frame, &loose.curves).into_values() {
        for pair in ends.windows(2) {
            joined.join(pair[0].0 as usize, pair[1].0 as usize);
        }
    }
    let (clusters, lowest) = joined.numbered();
    (clusters, lowest.len())
}
