//! Dots that keep the rules. In: regions that keep them, the dots as they were, and what ink the regions have lost and gained; out:
//! dots that are large enough, with enough room between them and all else.
//!
//! # The idea
//! Dots that keep the rules stay as they are. All others, and all that has changed otherwise, come in the order of a Hilbert curve, and
//! what they were worth is added to a sum: black that is missing so far, or, below 0, white. Where a dot that is too small was and the
//! sum is worth half of a dot of the usual size there (see [`super::usual`]), one is drawn, if it has room, and its area is taken off. So
//! tones are kept as error diffusion keeps them: where small dots were dense, every so many-th is a large one.

use kurbo::Point;
use rayon::prelude::*;

use crate::base::{Control, Ink, POLYGON_REACH, Result};
use crate::drawing::Drawing;
use crate::outlines::Stipple;
use crate::rules::check::allowance;
use crate::rules::near::{Discs, Near, Pairs, along_curve};
use crate::rules::rules::{Islands, Rules};
use crate::rules::shapes::Shapes;
use crate::rules::usual::Usual;

/// A dot that stands for several has at most so many times the area of what dots usually have there: larger ones would be seen as such.
const LARGER: f64 = 1.4;

/// And at least so many times: smaller ones would take the room of those that are as dark as is wanted.
const SMALLER: f64 = 0.6;

/// What is missing is forgotten beyond so many dots: it would be drawn far from where it was.
const MOST_MISSING: f64 = 8.0;

/// A dot that is smaller than this share of the diameter that is usual there does not stay if it stands too close to another one.
const KEPT: f64 = 0.9;

/// How far a dot may stand from where one was, in its radii, to have room.
const ASIDE: f64 = 0.8;

/// What has changed somewhere: black that is missing there, in mm^2, or below 0 black that is too much.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub(super) place: [f64; 2],
    pub(super) missing: f64,
}

/// What became of the dots.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DotCounts {
    pub(super) kept: usize,
    /// Made larger, or drawn for several.
    pub(super) enlarged: usize,
    /// Made smaller, so that there is room.
    pub(super) reduced: usize,
    pub(super) dropped: usize,
}

/// What happens at a place.
enum Event {
    Dot(usize),
    Change(f64),
}

/// The dots of a drawing, to be placed in regions.
pub(super) struct Placing<'a> {
    shapes: &'a Shapes<'a>,
    old: &'a [Stipple],
    rules: &'a Rules,
    /// What happens, in the order of a curve.
    events: Vec<Event>,
    near: Near,
    /// What dots of each ink usually have as diameter, in mm.
    usual: [Usual; 2],
    size: [f64; 2],
    /// What may be less than a limit without breaking it, in mm.
    allowance: f64,
    /// Whether dots that need no room by the rules need none at all.
    trusts: bool,
}

/// Dots that are placed.
#[derive(Clone)]
struct Placed {
    discs: Discs,
    dots: Vec<Stipple>,
    counts: DotCounts,
}

/// How often dots are placed to have the tone that is wanted.
const TRIALS: usize = 4;

/// A mean tone that is so near is right.
const TONE_EXACT: f64 = 1e-3;

impl<'a> Placing<'a> {
    /// `changes` are what the regions of `shapes` have lost and gained. Dots that need no room by the rules need none at all where
    /// `trusts` says so: they had enough before, but regions may touch them now.
    pub(super) fn new(shapes: &'a Shapes<'a>, old: &'a [Stipple], changes: &[Change], rules: &'a Rules, trusts: bool) -> Self {
        let size = shapes.size();
        let side = size[0].max(size[1]);
        let mut events: Vec<(u32, Event)> = Vec::with_capacity(old.len() + changes.len());
        let at = |dot: &Stipple| shapes.disc(dot).0;
        events.extend(old.iter().enumerate().map(|(index, dot)| (along_curve(at(dot), side), Event::Dot(index))));
        events.extend(changes.iter().map(|change| (along_curve(change.place, side), Event::Change(change.missing))));
        // What is equal stays in its order.
        events.sort_by_key(|(along, _)| *along);
        let events = events.into_iter().map(|(_, event)| event).collect();
        let finest = rules.finest();
        let allowance = if finest.is_finite() { 0.5 * allowance(finest) } else { 0.0 };
        let near = Near::of(&shapes.black, size);
        let usual = [Ink::BLACK, Ink::WHITE].map(|ink| {
            let area = |dot: &Stipple| disc_area(shapes.disc(dot).1);
            let dots = old.iter().filter(|dot| dot.ink == ink).map(|dot| (at(dot), area(dot)));
            let changed = changes.iter().map(|change| (change.place, ink.sign() * change.missing));
            Usual::of(dots.chain(changed), [rules.least_dot(ink), rules.narrowest(ink.other())], size, |p| near.ink(p) != ink)
        });
        Self { shapes, old, rules, events, near, usual, size, allowance, trusts }
    }

    /// The dots. Those that are made anew are worth so much more or less than they were that the whole canvas of an area in mm^2 has
    /// the share of black that is wanted, as far as they can.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub(super) fn placed(&self, wanted: f64, canvas: f64, control: &Control) -> Result<(Vec<Stipple>, DotCounts)> {
        let black = crate::offset::area(&self.shapes.black);
        let area = |dot: &Stipple| disc_area(self.shapes.disc(dot).1);
        let signed = |dot: &Stipple| dot.ink.sign() * area(dot);
        let (begun, stays) = self.as_they_are(control)?;
        let loose: f64 = self.old.iter().zip(&stays).filter(|(_, stays)| stays.is_none()).map(|(dot, _)| area(dot)).sum();
        let mut best: Option<(f64, Placed)> = None;
        let mut more = 0.0;
        for _ in 0..TRIALS {
            let placed = self.trial(begun.clone(), &stays, more, control)?;
            let missing = wanted * canvas - black - placed.dots.iter().map(signed).sum::<f64>();
            let is_better = best.as_ref().is_none_or(|(least, _)| missing.abs() < least.abs());
            if is_better {
                best = Some((missing, placed));
            }
            if missing.abs() <= TONE_EXACT * canvas || loose == 0.0 || !is_better {
                break;
            }
            // Black dots are worth more by that share, white ones less.
            more = (more + missing / loose).clamp(-1.0, 1.0);
        }
        let (_, placed) = best.unwrap_or((0.0, begun));
        Ok((placed.dots, placed.counts))
    }

    /// Dots that may stay as they are, or nearly: they come first, wherever the others would like to be. Of every dot its radius in
    /// pixels then.
    fn as_they_are(&self, control: &Control) -> Result<(Placed, Vec<Option<f64>>)> {
        let discs = Discs::new(self.size, self.old.len());
        let mut placed = Placed { discs, dots: Vec::new(), counts: DotCounts::default() };
        let mut stays = vec![None; self.old.len()];
        let is_crowded = self.are_crowded();
        for (count, event) in self.events.iter().enumerate() {
            if count.is_multiple_of(1 << 12) {
                control.check()?;
            }
            if let Event::Dot(index) = *event {
                stays[index] = self.as_it_is(&self.old[index], is_crowded[index], &mut placed);
            }
        }
        Ok((placed, stays))
    }

    /// Which dots are too close to another one and smaller than what is usual there: of those every so many-th as it is would be too
    /// light.
    fn are_crowded(&self) -> Vec<bool> {
        let scale = self.shapes.scale;
        let mut are_crowded = vec![false; self.old.len()];
        for ink in [Ink::BLACK, Ink::WHITE] {
            let reach = self.rules.narrowest(ink.other()) - self.allowance;
            let least = 0.5 * (self.rules.least_dot(ink) - self.allowance);
            let of_ink = (0..self.old.len()).filter(|index| {
                let dot = &self.old[*index];
                dot.ink == ink && dot.radius * scale >= least
            });
            let numbers: Vec<usize> = of_ink.collect();
            let discs: Vec<([f64; 2], f64)> = numbers.iter().map(|index| self.shapes.disc(&self.old[*index])).collect();
            let pairs = Pairs::of(&discs, self.size);
            let crowded: Vec<usize> = (0..discs.len())
                .into_par_iter()
                .filter(|k| {
                    let (centre, radius) = discs[*k];
                    2.0 * radius < KEPT * self.usual[ink.index()].diameter(centre) && !pairs.neighbours(*k, reach).is_empty()
                })
                .collect();
            crowded.into_iter().for_each(|k| are_crowded[numbers[k]] = true);
        }
        are_crowded
    }

    /// All others, with black worth so much more than it is.
    fn trial(&self, mut placed: Placed, stays: &[Option<f64>], more: f64, control: &Control) -> Result<Placed> {
        let area = |radius: f64| disc_area(radius * self.shapes.scale);
        let mut missing = 0.0;
        for (count, event) in self.events.iter().enumerate() {
            if count.is_multiple_of(1 << 12) {
                control.check()?;
            }
            match *event {
                Event::Change(by) => missing += by,
                Event::Dot(index) => {
                    let dot = &self.old[index];
                    let sign = dot.ink.sign();
                    if let Some(radius) = stays[index] {
                        missing += sign * (area(dot.radius) - area(radius));
                        continue;
                    }
                    missing += sign * area(dot.radius) * (1.0 + sign * more);
                    let most = MOST_MISSING * self.usual_area(dot);
                    if most > 0.0 {
                        missing = missing.clamp(-most, most);
                    }
                    if let Some(drawn) = self.in_place_of(dot, sign * missing, &mut placed) {
                        missing -= sign * area(drawn.radius);
                        placed.counts.enlarged += 1;
                    } else {
                        placed.counts.dropped += 1;
                    }
                }
            }
        }
        Ok(placed)
    }

    /// The area of the least dot of an ink, in mm^2.
    fn least_area(&self, ink: Ink) -> f64 {
        disc_area(0.5 * self.rules.least_dot(ink))
    }

    /// The area that dots of its ink usually have where one is, in mm^2.
    fn usual_area(&self, dot: &Stipple) -> f64 {
        let diameter = self.usual[dot.ink.index()].diameter(self.shapes.disc(dot).0);
        0.25 * std::f64::consts::PI * diameter * diameter
    }

    /// Whether dots of an ink may be: a white one is an island.
    fn may_be(&self, ink: Ink) -> bool {
        ink == Ink::BLACK || self.rules.islands != Islands::Bridge
    }

    /// How much must lie between a dot of a radius in mm and what has its ink, so that nothing of the other ink there is too narrow; at
    /// least so much that their polygons do not touch.
    fn clearance(&self, ink: Ink, radius: f64) -> f64 {
        let polygons = radius * (POLYGON_REACH - 1.0) + 2.0 * self.shapes.drawing.flattening_tolerance() * self.shapes.scale;
        // Dots that no rule moves lie as they lay, however close that is.
        let least = if self.trusts { 0.0 } else { polygons };
        self.rules.narrowest(ink.other()).max(least)
    }

    /// The largest radius of a dot around a place in mm, up to `wanted`; below 0 if something is too near.
    fn room(&self, p: [f64; 2], ink: Ink, wanted: f64, discs: &Discs) -> f64 {
        let clearance = self.clearance(ink, wanted);
        let reach = wanted + clearance;
        let frame = p.into_iter().chain([0, 1].map(|axis| self.size[axis] - p[axis])).fold(f64::INFINITY, f64::min);
        // The sheet goes on beyond the frame; black ends there.
        let to_frame = if ink == Ink::WHITE { frame } else { frame + clearance - wanted * (POLYGON_REACH - 1.0) };
        let to_edges = self.near.distance(p, reach);
        discs.distance(p, reach).min(to_edges).min(to_frame) - clearance
    }

    /// Whether a dot's polygon lies on the canvas.
    fn is_on_canvas(&self, dot: &Stipple) -> bool {
        let Drawing { width, height, .. } = *self.shapes.drawing;
        let reach = dot.radius * POLYGON_REACH;
        [dot.x, dot.y, width as f64 - dot.x, height as f64 - dot.y].into_iter().all(|to_frame| to_frame >= reach)
    }

    fn add(&self, dot: Stipple, placed: &mut Placed) {
        let (centre, radius) = self.shapes.disc(&dot);
        placed.discs.add(centre, radius);
        placed.dots.push(dot);
    }

    /// Places a dot that is large enough, as it is or smaller; its radius in pixels.
    fn as_it_is(&self, dot: &Stipple, is_crowded: bool, placed: &mut Placed) -> Option<f64> {
        let scale = self.shapes.scale;
        let (p, radius) = self.shapes.disc(dot);
        let least = 0.5 * (self.rules.least_dot(dot.ink) - self.allowance);
        if radius < least || is_crowded || !self.may_be(dot.ink) || self.near.ink(p) == dot.ink {
            return None;
        }
        let room = self.room(p, dot.ink, radius + self.allowance, &placed.discs);
        if room >= radius - self.allowance.min(0.5 * self.rules.narrowest(dot.ink.other())) {
            self.add(*dot, placed);
            placed.counts.kept += 1;
            return Some(dot.radius);
        }
        if room < least || self.rules.least_dot(dot.ink) == 0.0 {
            return None;
        }
        let smaller = Stipple::on_grid(Point::new(dot.x, dot.y), room / scale, self.shapes.drawing.units, dot.ink);
        let (at, own) = self.shapes.disc(&smaller);
        // The grid moves its centre.
        if own < least || !self.is_on_canvas(&smaller) || self.room(at, dot.ink, own, &placed.discs) < own - self.allowance {
            return None;
        }
        self.add(smaller, placed);
        placed.counts.reduced += 1;
        Some(smaller.radius)
    }

    /// Places a dot of at least the least size where one is that is too small, if so much of its ink is missing, in mm^2, and if it
    /// has room there or beside it.
    fn in_place_of(&self, dot: &Stipple, missing: f64, placed: &mut Placed) -> Option<Stipple> {
        let (scale, ink, units) = (self.shapes.scale, dot.ink, self.shapes.drawing.units);
        let least_area = self.least_area(ink);
        let usual_area = self.usual_area(dot);
        if least_area == 0.0 || !self.may_be(ink) || missing < 0.5 * usual_area {
            return None;
        }
        let (centre, _) = self.shapes.disc(dot);
        // Rounded down to the grid it must still be large enough.
        let least = 0.5 * self.rules.least_dot(ink) + 0.02 / units * scale;
        let radius_of = |area: f64| (area / std::f64::consts::PI).sqrt();
        let least = least.max(radius_of(SMALLER * usual_area));
        let wanted = radius_of(missing.min(LARGER * usual_area)).max(least);
        for p in std::iter::once(centre).chain(aside(centre, ASIDE * least)) {
            let is_on_canvas = p[0] > 0.0 && p[1] > 0.0 && p[0] < self.size[0] && p[1] < self.size[1];
            if !is_on_canvas {
                continue;
            }
            let room = self.room(p, ink, wanted, &placed.discs);
            if room < least || self.near.ink(p) == ink {
                continue;
            }
            let radius = room.min(wanted) / scale;
            let drawn = Stipple::on_grid(Point::new(p[0] / scale, p[1] / scale), radius, units, ink);
            let (at, own) = self.shapes.disc(&drawn);
            let may_be = own >= 0.5 * self.rules.least_dot(ink) && self.is_on_canvas(&drawn);
            if may_be && self.room(at, ink, own, &placed.discs) >= own - 0.5 * self.allowance {
                self.add(drawn, placed);
                return Some(drawn);
            }
        }
        None
    }
}

/// Places around a place: eight, at a distance.
fn aside(p: [f64; 2], distance: f64) -> impl Iterator<Item = [f64; 2]> {
    const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let directions = [
        [1.0, 0.0],
        [0.0, 1.0],
        [-1.0, 0.0],
        [0.0, -1.0],
        [DIAGONAL, DIAGONAL],
        [-DIAGONAL, DIAGONAL],
        [-DIAGONAL, -DIAGONAL],
        [DIAGONAL, -DIAGONAL],
    ];
    directions.into_iter().map(move |[x, y]| [p[0] + distance * x, p[1] + distance * y])
}

/// The mean of points.
pub(super) fn middle(points: &[[f64; 2]]) -> [f64; 2] {
    let sum = points.iter().fold([0.0, 0.0], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    sum.map(|v| v / points.len() as f64)
}

/// The area of a disc of this radius.
fn disc_area(radius: f64) -> f64 {
    std::f64::consts::PI * radius.powi(2)
}

/// Changes where areas came or went: the whole of it in its middle, or in parts along its outline where it is large.
pub(super) fn changes_of(areas: &[crate::offset::Polygon], sign: f64, part: f64) -> Vec<Change> {
    let mut changes = Vec::new();
    for area in areas {
        let missing = sign * crate::offset::area(std::slice::from_ref(area));
        let ring = &area[0];
        let parts = ((missing.abs() / part.max(1e-9)) as usize).clamp(1, ring.len());
        for k in 0..parts {
            let place = if parts == 1 { middle(ring) } else { ring[k * ring.len() / parts] };
            changes.push(Change { place, missing: missing / parts as f64 });
        }
    }
    changes
}

/// Black in mm^2 on a drawing: regions with what is in them, and dots.
pub(super) fn black_of(drawing: &Drawing, scale: f64) -> f64 {
    use kurbo::Shape as _;
    let of_region = |index: usize| -> f64 {
        let region = &drawing.regions[index];
        let rings = std::iter::once(&region.exterior).chain(&region.holes);
        rings.map(|ring| drawing.ring_path(ring).area()).sum()
    };
    let regions: f64 = (0..drawing.regions.len())
        .into_par_iter()
        .filter(|i| drawing.regions[*i].ink == Ink::BLACK)
        .map(of_region)
        .collect::<Vec<f64>>()
        .iter()
        .sum();
    let dots: f64 = drawing.stipples.iter().map(|dot| std::f64::consts::PI * dot.radius * dot.radius * dot.ink.sign()).sum();
    (regions + dots) * scale * scale
}
