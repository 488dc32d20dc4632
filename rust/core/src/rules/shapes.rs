//! The regions of a drawing as areas in mm, and drawings again of areas that were changed. What no change touches stays the curve
//! that it was.
//!
//! # The idea
//! Areas are polygons through points of the curves. What is taken off an area and what is added to it comes as polygons too, and
//! what is left of the old outline has the old points. So every point of the new outline is looked up among the old ones: where all
//! points of a piece of a curve follow one another, the piece itself is taken, and elsewhere a line from point to point.
//!
//! What this module does not do: dots. They are no areas here, and a drawing that is made here has none.

use kurbo::{BezPath, CubicBez, PathEl, Point, QuadBez};
use rayon::prelude::*;

use crate::base::{
    Error, Frame, Ink, Result, bend_of_cubic, bend_of_quad, distance_to_segment, flatten_path, flattening_steps, is_closed,
    signed_area, snap,
};
use crate::drawing::{Drawing, Loose, Ring, RingPart};
use crate::offset::{Polygon, keep};
use crate::outlines::Stipple;

/// How far areas may lie from the curves where this is the narrowest limit: so much of it, and never more than so many mm, since what a
/// check allows is no more than a few times that (see [`super::check`]). Less is more points.
const OF_LIMIT: f64 = 0.01;
const FARTHEST: f64 = 0.004;

/// The grid of new points is no coarser than this share of the tolerance.
const OF_TOLERANCE: f64 = 0.5;

/// New points are left out where that moves the outline by no more than so many tolerances: what is laid over an outline reaches
/// beyond it by two.
const TIDIED: f64 = 2.0;

/// How far a point may come back from operations on areas, in units of their grid.
const MOVED: f64 = 4.0;

/// How exactly areas follow curves where this is the narrowest limit, in mm.
pub(super) fn tolerance_for(limit: f64) -> f64 {
    (limit * OF_LIMIT).min(FARTHEST)
}

/// The black regions of a drawing without its dots.
pub(super) struct Shapes<'a> {
    pub(super) drawing: &'a Drawing,
    /// mm to a pixel.
    pub(super) scale: f64,
    /// How far the areas may lie from the curves, in mm.
    pub(super) tolerance: f64,
    /// The points of every curve, in pixels.
    flat: Vec<Vec<[f64; 2]>>,
    /// The areas, in mm.
    pub(super) black: Vec<Polygon>,
    /// The curves of every area.
    curves: Vec<Vec<u32>>,
}

impl<'a> Shapes<'a> {
    pub(super) fn new(drawing: &'a Drawing, scale: f64, tolerance: f64) -> Self {
        let flat: Vec<Vec<[f64; 2]>> = drawing.curves.par_iter().map(|curve| flattened(curve, tolerance / scale)).collect();
        let mut shapes = Self { drawing, scale, tolerance, flat, black: Vec::new(), curves: Vec::new() };
        for region in drawing.regions.iter().filter(|region| region.ink == Ink::BLACK) {
            let rings = || std::iter::once(&region.exterior).chain(&region.holes).filter(|ring| !is_dot(ring));
            shapes.black.push(rings().map(|ring| shapes.ring(ring)).collect());
            let parts = rings().flat_map(|ring| &ring.parts);
            let curve = |part: &RingPart| if let RingPart::Curve { index, .. } = part { Some(*index) } else { None };
            shapes.curves.push(parts.filter_map(curve).collect());
        }
        shapes
    }

    /// Width and height of the canvas in mm.
    pub(super) fn size(&self) -> [f64; 2] {
        [self.drawing.width, self.drawing.height].map(|side| side as f64 * self.scale)
    }

    /// Centre and radius of a dot, in mm.
    pub(super) fn disc(&self, dot: &Stipple) -> ([f64; 2], f64) {
        ([dot.x * self.scale, dot.y * self.scale], dot.radius * self.scale)
    }

    /// A ring in mm, through the points of its curves.
    pub(super) fn ring(&self, ring: &Ring) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut push = |point: &[f64; 2]| {
            let point = point.map(|v| v * self.scale);
            if points.last() != Some(&point) {
                points.push(point);
            }
        };
        for part in &ring.parts {
            match *part {
                RingPart::Curve { index, reversed: false } => self.flat[index as usize].iter().for_each(&mut push),
                RingPart::Curve { index, reversed: true } => self.flat[index as usize].iter().rev().for_each(&mut push),
                RingPart::Stipple { .. } => {}
                RingPart::Corner(x, y) => push(&[x, y]),
            }
        }
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        points
    }

    /// Area of a region with the dots in it, in mm^2.
    pub(super) fn area_of(&self, region: usize) -> f64 {
        let region = &self.drawing.regions[region];
        let rings = std::iter::once(&region.exterior).chain(&region.holes).filter(|ring| !is_dot(ring));
        rings.map(|ring| signed_area(&self.ring(ring))).sum()
    }

    /// The curves of a drawing whose black regions are these areas; of each is told which region of this drawing it is, if it is that
    /// still.
    pub(super) fn loose_of(&self, areas: &[Polygon], origins: &[Option<usize>]) -> Loose {
        let outlines = Outlines::new(self);
        let of_area = |(area, origin): (&Polygon, &Option<usize>)| -> Vec<BezPath> {
            match *origin {
                Some(region) => self.curves[region].iter().map(|index| self.drawing.curves[*index as usize].clone()).collect(),
                None => area.iter().flat_map(|ring| outlines.curves(ring)).collect(),
            }
        };
        let curves: Vec<Vec<BezPath>> = areas.par_iter().zip(origins).map(of_area).collect();
        let Drawing { width, height, units, .. } = *self.drawing;
        let canvas = (width * height) as f64 * self.scale * self.scale;
        let ground = if crate::offset::area(areas) > 0.5 * canvas { Ink::BLACK } else { Ink::WHITE };
        let (palette, curves) = (self.drawing.palette.clone(), curves.into_iter().flatten().collect());
        Loose { width, height, units, palette, curves, sides: Vec::new(), stipples: Vec::new(), dots: Vec::new(), ground }
    }
}

/// # Errors
/// [`Error::Input`] for a drawing of more inks than one: rules are for its plates.
pub(super) fn refuse_inks(drawing: &Drawing) -> Result<()> {
    match drawing.palette.inks().len() {
        0 | 1 => Ok(()),
        count => Err(Error::Input(format!("the drawing has {count} inks, but rules are for one: take its plates one by one"))),
    }
}

fn is_dot(ring: &Ring) -> bool {
    matches!(ring.parts[..], [RingPart::Stipple { .. }])
}

/// The points of a curve, those of a closed one each once.
fn flattened(curve: &BezPath, tolerance: f64) -> Vec<[f64; 2]> {
    let mut points = flatten_path(curve, tolerance);
    if is_closed(curve) && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    points
}

/// Where a point of a new outline stands on an old curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Origin {
    curve: u32,
    /// Which point of it.
    at: u32,
}

/// A point of a new outline, in pixels.
#[derive(Debug, Clone, Copy)]
struct Placed {
    point: Point,
    origin: Option<Origin>,
}

/// The old curves by their points, to make new ones.
struct Outlines<'a> {
    shapes: &'a Shapes<'a>,
    frame: Frame,
    /// Points by the cell that they lie in, with where they stand; sorted.
    known: Vec<([i64; 2], Origin)>,
    /// How far apart two points are at most that are the same, in mm.
    near: f64,
    /// Units to a pixel of the grid of new points.
    units: f64,
}

/// Cells to look points up in are so many times as wide as points may be apart: more to compare, or more cells.
const CELL: f64 = 64.0;

impl<'a> Outlines<'a> {
    fn new(shapes: &'a Shapes<'a>) -> Self {
        let drawing = shapes.drawing;
        let frame = Frame { width: drawing.width as f64, height: drawing.height as f64 };
        let longest = frame.width.max(frame.height) * shapes.scale;
        let near = MOVED * (longest / f64::from(1u32 << 27)).max(1.0 / f64::from(1u32 << 16));
        let mut units = drawing.units;
        while units * OF_TOLERANCE * shapes.tolerance < shapes.scale {
            units *= 2.0;
        }
        let mut outlines = Self { shapes, frame, known: Vec::new(), near, units };
        let origins = |curve: u32| {
            let points = shapes.flat[curve as usize].iter();
            (0..).zip(points).map(move |(at, p)| (p.map(|v| v * shapes.scale), Origin { curve, at }))
        };
        let mut known: Vec<([i64; 2], Origin)> =
            (0..shapes.flat.len() as u32).flat_map(origins).map(|(p, origin)| (outlines.cell(p), origin)).collect();
        known.par_sort_unstable_by_key(|(cell, origin)| (*cell, origin.curve, origin.at));
        outlines.known = known;
        outlines
    }

    fn cell(&self, p: [f64; 2]) -> [i64; 2] {
        p.map(|v| (v / (CELL * self.near)).floor() as i64)
    }

    /// Where a point in mm stands on the old curves, if it is one of theirs.
    fn origin(&self, p: [f64; 2]) -> Option<Origin> {
        let corners = [-1.0, 1.0].map(|out| p.map(|v| v + out * self.near));
        let [low, high] = corners.map(|corner| self.cell(corner));
        let mut nearest: Option<(f64, Origin)> = None;
        for x in low[0]..=high[0] {
            let first = self.known.partition_point(|(cell, _)| *cell < [x, low[1]]);
            for (_, origin) in self.known[first..].iter().take_while(|(cell, _)| *cell <= [x, high[1]]) {
                let q = self.shapes.flat[origin.curve as usize][origin.at as usize].map(|v| v * self.shapes.scale);
                let distance = (p[0] - q[0]).abs().max((p[1] - q[1]).abs());
                if distance <= self.near && nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, *origin));
                }
            }
        }
        nearest.map(|(_, origin)| origin)
    }

    /// The curves of a ring: itself, or what of it does not run along the frame.
    fn curves(&self, ring: &[[f64; 2]]) -> Vec<BezPath> {
        let placed: Vec<Placed> = ring.iter().map(|p| self.place(*p)).collect();
        let mut placed = self.tidied(placed);
        let n = placed.len();
        if n < 3 {
            return Vec::new();
        }
        let sides: Vec<u8> = placed.iter().map(|p| self.sides(p.point)).collect();
        let along: Vec<bool> = (0..n).map(|i| sides[i] & sides[(i + 1) % n] != 0).collect();
        let Some(first) = (0..n).find(|i| along[*i]) else {
            for (p, _) in placed.iter_mut().zip(&sides).filter(|(_, sides)| **sides != 0) {
                self.move_in(p);
            }
            return self.closed(placed).into_iter().collect();
        };
        let mut curves = Vec::new();
        let mut chain: Vec<Placed> = Vec::new();
        // From the end of an edge on the frame all around to it.
        for k in 1..=n {
            let i = (first + k) % n;
            chain.push(placed[i]);
            if along[i] {
                let chain = std::mem::take(&mut chain);
                if chain.len() > 1 {
                    curves.extend(self.open(chain));
                }
            }
        }
        curves
    }

    /// A ring without new points that hardly differ from a line: where outlines were laid over each other there are small steps, and on
    /// the grid they would lie behind one another.
    fn tidied(&self, mut ring: Vec<Placed>) -> Vec<Placed> {
        ring.dedup_by(|a, b| a.point == b.point);
        while ring.len() > 1 && ring[0].point == ring[ring.len() - 1].point {
            ring.pop();
        }
        let n = ring.len();
        if n < 3 {
            return Vec::new();
        }
        let is_old = |placed: &Placed| placed.origin.is_some() || self.sides(placed.point) != 0;
        // Old points stay; where there is none, the outermost two do.
        let first = (0..n).find(|i| is_old(&ring[*i])).unwrap_or_else(|| {
            (0..n)
                .min_by(|a, b| ring[*a].point.x.total_cmp(&ring[*b].point.x).then(ring[*a].point.y.total_cmp(&ring[*b].point.y)))
                .unwrap_or(0)
        });
        ring.rotate_left(first);
        let mut stays: Vec<bool> = ring.iter().map(is_old).collect();
        stays[0] = true;
        if stays.iter().filter(|stays| **stays).count() < 2 {
            let away = |i: &usize| (ring[*i].point - ring[0].point).hypot2();
            let farthest = (1..n).max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(1);
            stays[farthest] = true;
        }
        let tolerance = (TIDIED * self.shapes.tolerance / self.shapes.scale).max(1.5 / self.units);
        let fixed: Vec<usize> = (0..n).filter(|i| stays[*i]).collect();
        let mut spans: Vec<(usize, usize)> = fixed.windows(2).map(|pair| (pair[0], pair[1])).collect();
        spans.push((fixed[fixed.len() - 1], n));
        // The first point again at the end.
        stays.push(true);
        keep(&|k| ring[k % n].point, &spans, tolerance, &mut stays);
        let mut kept = stays.iter();
        ring.retain(|_| kept.next().is_some_and(|stays| *stays));
        if ring.len() < 3 { Vec::new() } else { ring }
    }

    /// A point of a ring, in pixels: one of the old curves, or on the grid.
    fn place(&self, p: [f64; 2]) -> Placed {
        let origin = self.origin(p);
        if let Some(Origin { curve, at }) = origin {
            let [x, y] = self.shapes.flat[curve as usize][at as usize];
            return Placed { point: Point::new(x, y), origin };
        }
        let Point { mut x, mut y } = snap(Point::new(p[0] / self.shapes.scale, p[1] / self.shapes.scale), self.units);
        for (v, length) in [(&mut x, self.frame.width), (&mut y, self.frame.height)] {
            let hair = 1.5 / self.units;
            *v = if *v < hair {
                0.0
            } else if *v > length - hair {
                length
            } else {
                *v
            };
        }
        Placed { point: Point::new(x, y), origin: None }
    }

    /// The sides of the frame that a point lies on, a bit each.
    fn sides(&self, p: Point) -> u8 {
        let on = [p.y <= 0.0, p.x >= self.frame.width, p.y >= self.frame.height, p.x <= 0.0];
        on.into_iter().enumerate().map(|(k, on)| u8::from(on) << k).sum()
    }

    /// Moves a point off the frame that a curve only touches there.
    fn move_in(&self, p: &mut Placed) {
        let step = 2.0 / self.units;
        p.point.x = p.point.x.clamp(step, self.frame.width - step);
        p.point.y = p.point.y.clamp(step, self.frame.height - step);
        p.origin = None;
    }

    fn open(&self, mut chain: Vec<Placed>) -> Option<BezPath> {
        let last = chain.len() - 1;
        for p in chain[1..last].iter_mut().filter(|p| self.sides(p.point) != 0) {
            self.move_in(p);
        }
        if self.sides(chain[0].point) == 0 || self.sides(chain[last].point) == 0 || chain[0].point == chain[last].point {
            return None;
        }
        Some(self.path(&chain, false))
    }

    fn closed(&self, mut ring: Vec<Placed>) -> Option<BezPath> {
        let n = ring.len();
        // From where a curve begins, or where a piece of one does.
        let begins = |i: usize| ring[i].origin.is_some_and(|origin| origin.at == 0);
        let breaks = |i: usize| !self.follows(ring[(i + n - 1) % n].origin, ring[i].origin);
        let first = (0..n).find(|i| begins(*i)).or_else(|| (0..n).find(|i| breaks(*i))).unwrap_or(0);
        ring.rotate_left(first);
        Some(self.path(&ring, true))
    }

    /// Whether a point of a curve comes next after another one, or nothing but a straight line lies between.
    fn follows(&self, from: Option<Origin>, to: Option<Origin>) -> bool {
        let (Some(from), Some(to)) = (from, to) else { return false };
        if from.curve != to.curve {
            return false;
        }
        let points = &self.shapes.flat[from.curve as usize];
        let n = points.len() as u32;
        let is_ring = is_closed(&self.shapes.drawing.curves[from.curve as usize]);
        let steps = if to.at > from.at {
            to.at - from.at
        } else if is_ring {
            to.at + n - from.at
        } else {
            return false;
        };
        let at = |k: u32| Point::from((points[(k % n) as usize][0], points[(k % n) as usize][1]));
        let (a, b) = (at(from.at), at(to.at));
        steps < n && (1..steps).all(|k| distance_to_segment(at(from.at + k), a, b) * self.shapes.scale <= 4.0 * self.near)
    }

    /// A path through points, with pieces of the old curves wherever all points of one follow one another.
    fn path(&self, points: &[Placed], closed: bool) -> BezPath {
        let n = points.len();
        if let Some(whole) = self.whole(points, closed) {
            return whole.clone();
        }
        let mut path = BezPath::with_capacity(n + 2);
        let mut pieces = Pieces::default();
        // Where pieces join, points stay as they are; within a piece they are on no grid yet.
        let fine = |placed: &Placed, pieces: &mut Pieces| {
            let is_joint = placed.origin.is_none_or(|origin| pieces.join_at(self, origin));
            if is_joint { placed.point } else { snap(placed.point, self.units) }
        };
        path.move_to(fine(&points[0], &mut pieces));
        let end = if closed { n } else { n - 1 };
        let mut i = 0;
        while i < end {
            let piece = points[i].origin.and_then(|origin| {
                let (element, length) = pieces.at(self, origin)?;
                // The points up to its end.
                let mut to = i;
                let mut walked = 0;
                while walked < length && to < end {
                    let (a, b) = (points[to % n].origin, points[(to + 1) % n].origin);
                    if !self.follows(a, b) {
                        return None;
                    }
                    walked += self.steps(a?, b?);
                    to += 1;
                }
                (walked == length).then_some((element, to))
            });
            match piece {
                Some((element, to)) => {
                    path.push(element);
                    i = to;
                }
                None => {
                    i += 1;
                    if i < n || !closed {
                        path.line_to(fine(&points[i % n], &mut pieces));
                    }
                }
            }
        }
        if closed {
            path.close_path();
        }
        path
    }

    /// Steps along a curve from a point to another one that follows.
    fn steps(&self, from: Origin, to: Origin) -> u32 {
        let n = self.shapes.flat[from.curve as usize].len() as u32;
        if to.at > from.at { to.at - from.at } else { to.at + n - from.at }
    }

    /// The old curve that these points are all of.
    fn whole(&self, points: &[Placed], closed: bool) -> Option<&'a BezPath> {
        let first = points[0].origin.filter(|origin| origin.at == 0)?;
        let curve = &self.shapes.drawing.curves[first.curve as usize];
        let n = points.len();
        let pairs = if closed { n } else { n - 1 };
        let is_whole = is_closed(curve) == closed
            && (0..pairs).all(|i| self.follows(points[i].origin, points[(i + 1) % n].origin))
            && (closed || points[n - 1].origin?.at as usize + 1 == self.shapes.flat[first.curve as usize].len());
        let walked: u32 = (0..pairs).filter_map(|i| Some(self.steps(points[i].origin?, points[(i + 1) % n].origin?))).sum();
        let wanted = self.shapes.flat[first.curve as usize].len() as u32 - u32::from(!closed);
        (is_whole && walked == wanted).then_some(curve)
    }
}

/// The pieces of the curve that was asked for last, by the points where they begin.
#[derive(Default)]
struct Pieces {
    curve: Option<u32>,
    /// The first point of every piece, the piece, and its steps.
    pieces: Vec<(u32, PathEl, u32)>,
}

impl Pieces {
    /// The piece that begins at a point, and how many steps it has.
    fn at(&mut self, outlines: &Outlines, origin: Origin) -> Option<(PathEl, u32)> {
        self.load(outlines, origin);
        let k = self.pieces.binary_search_by_key(&origin.at, |(at, ..)| *at).ok()?;
        let (_, element, steps) = self.pieces[k];
        Some((element, steps))
    }

    /// Whether a piece begins or ends at a point.
    fn join_at(&mut self, outlines: &Outlines, origin: Origin) -> bool {
        self.load(outlines, origin);
        let begins = self.pieces.binary_search_by_key(&origin.at, |(at, ..)| *at).is_ok();
        begins || self.pieces.last().is_some_and(|(at, _, steps)| at + steps == origin.at)
    }

    fn load(&mut self, outlines: &Outlines, origin: Origin) {
        if self.curve != Some(origin.curve) {
            self.curve = Some(origin.curve);
            self.pieces.clear();
            let tolerance = outlines.shapes.tolerance / outlines.shapes.scale;
            let (mut from, mut at) = (Point::ZERO, 0);
            for element in outlines.shapes.drawing.curves[origin.curve as usize].elements() {
                let steps = match *element {
                    PathEl::QuadTo(c, p) => flattening_steps(bend_of_quad(&QuadBez::new(from, c, p)), tolerance) as u32,
                    PathEl::CurveTo(c, d, p) => flattening_steps(bend_of_cubic(&CubicBez::new(from, c, d, p)), tolerance) as u32,
                    PathEl::LineTo(_) => 1,
                    _ => 0,
                };
                if steps > 0 {
                    self.pieces.push((at, *element, steps));
                }
                at += steps;
                from = element.end_point().unwrap_or(from);
            }
        }
    }
}
