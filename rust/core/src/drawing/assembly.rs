//! Assembly: from boundary curves and dots to the regions that they bound, their order and levels.
//!
//! Every curve and every dot names the components on its two sides; a component that is not a dot becomes a region. Its rings are
//! the closed curves around it and in it, runs of open curves from junction to junction, and, if it touches the frame, runs of open
//! curves and frame in turn. Everything is put
//! into an order that depends on the geometry alone, so that a drawing read back from a file is the drawing that was written. What
//! this module does not do: find out who lies beside a curve (see [`super::sides`] and [`crate::stages::outline`]).

use std::cell::Cell;
use std::cmp::Ordering;
use std::collections::HashMap;

use kurbo::{BezPath, PathEl, Point, Shape};
use rayon::prelude::*;

use crate::base::{Error, Frame, Ink, Place, Result, circle_polygon, is_closed, signed_area};
use crate::drawing::data::{Drawing, Mark, Region, Ring, RingPart};
use crate::outlines::{Parts, Stipple};

/// The drawing of these parts; its provenance is left empty.
///
/// # Errors
/// [`Error::Input`] for an ink that is none of the palette's, [`Error::Internal`] if the parts do not fit together.
///
/// # Panics
/// If a part names a component that has no ink.
pub fn assemble(parts: Parts) -> Result<Drawing> {
    if let Some(ink) = parts.inks.iter().find(|ink| ink.index() >= parts.palette.len()) {
        let (label, most) = (ink.label(), parts.palette.len() - 1);
        let rule = if most == 1 { "0 (black) or 1 (white)".to_owned() } else { format!("between 0 and {most}") };
        return Err(Error::Input(format!("the label of a node is {label}, but it must be {rule}")));
    }
    let frame = Frame { width: parts.width as f64, height: parts.height as f64 };
    let count = parts.inks.len();
    let mut is_dot = vec![false; count];
    for (_, [own, _]) in &parts.stipples {
        is_dot[*own as usize] = true;
    }
    let Parts { width, height, units, palette, .. } = parts;
    let mut drawing = Drawing { width, height, units, palette, ..Drawing::default() };
    let mut placed: Vec<(Point, BezPath, [u32; 2])> =
        parts.curves.into_par_iter().map(|(path, beside)| (top_of_curve(&path), path, beside)).collect();
    // Whatever the number of threads, what is equal stays in its order: so in all sorts here.
    // Curves that have their top in one junction differ in what follows.
    placed.par_sort_by(|a, b| from_the_top(a.0, b.0).then_with(|| by_points(&a.1, &b.1)));
    let tops: Vec<Point> = placed.iter().map(|(top, _, _)| *top).collect();
    let (curves, beside): (Vec<BezPath>, Vec<[u32; 2]>) = placed.into_iter().map(|(_, path, beside)| (path, beside)).unzip();
    drawing.curves = curves;
    let mut stipples = parts.stipples;
    stipples.par_sort_by(|(a, _), (b, _)| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));

    // What is known of a component's region so far: its outer boundary with the area inside, and its holes.
    let mut exteriors: Vec<Option<(Ring, f64)>> = vec![None; count];
    let mut holes: Vec<Vec<Ring>> = vec![Vec::new(); count];
    // The component around a component; none for one that touches the frame.
    let mut container: Vec<Option<u32>> = vec![None; count];

    for (component, ring, is_at_frame) in open_rings(frame, &drawing.curves, &beside, parts.on_frame)? {
        let area = drawing.ring_path(&ring).area();
        if is_at_frame || area > 0.0 {
            exteriors[component as usize] = Some((ring, area));
            continue;
        }
        for part in &ring.parts {
            if let RingPart::Curve { index, reversed } = *part {
                container[beside[index as usize][usize::from(!reversed)] as usize] = Some(component);
            }
        }
        holes[component as usize].push(ring);
    }
    let areas: Vec<Option<f64>> = drawing.curves.par_iter().map(|path| is_closed(path).then(|| path.area())).collect();
    for (number, area) in areas.into_iter().enumerate().filter_map(|(number, area)| Some((number, area?))) {
        let [left, right] = beside[number];
        let part = |reversed: bool| Ring { parts: vec![RingPart::Curve { index: number as u32, reversed }] };
        // Positive: what lies on its left is inside.
        let (inner, outer) = if area > 0.0 { (left, right) } else { (right, left) };
        container[inner as usize] = Some(outer);
        exteriors[inner as usize] = Some((part(area < 0.0), area.abs()));
        holes[outer as usize].push(part(area > 0.0));
    }
    contain_neighbours(&exteriors, &beside, &mut container);
    for (index, (_, [own, around])) in stipples.iter().enumerate() {
        container[*own as usize] = Some(*around);
        holes[*around as usize].push(Ring { parts: vec![RingPart::Stipple { index: index as u32 }] });
    }
    let own_of_stipple: Vec<u32> = stipples.iter().map(|(_, [own, _])| *own).collect();
    drawing.stipples = stipples.into_iter().map(|(stipple, _)| stipple).collect();

    let mut regions: Vec<(Point, u32, Region)> = Vec::new();
    for component in (0..count).filter(|c| !is_dot[*c]) {
        let (exterior, enclosed_area) =
            exteriors[component].take().ok_or_else(|| Error::Internal(format!("component {component} has no outer boundary")))?;
        let mut placed: Vec<(Point, Ring)> =
            std::mem::take(&mut holes[component]).into_iter().map(|hole| (top(&drawing, &tops, &hole), hole)).collect();
        placed.sort_by(|a, b| from_the_top(a.0, b.0));
        let holes = placed.into_iter().map(|(_, hole)| hole).collect();
        let region = Region { ink: parts.inks[component], level: 0, exterior, holes, enclosed_area };
        regions.push((top(&drawing, &tops, &region.exterior), component as u32, region));
    }
    // The two sides of an open curve may both have their top on it.
    regions.par_sort_by(|a, b| from_the_top(a.0, b.0).then(a.2.ink.cmp(&b.2.ink)));
    let own_of_region: Vec<u32> = regions.iter().map(|(_, component, _)| *component).collect();
    drawing.regions = regions.into_iter().map(|(_, _, region)| region).collect();

    put_in_order(&mut drawing);
    find_levels(&mut drawing, &container, &own_of_region, &own_of_stipple)?;
    Ok(drawing)
}

impl Drawing {
    /// The inks to the left and to the right of every curve.
    pub fn sides(&self) -> Vec<[Ink; 2]> {
        let ink = |region: u32| self.regions[region as usize].ink;
        Surroundings::of(self).beside.into_iter().map(|sides| sides.map(ink)).collect()
    }

    /// The drawing with other dots in the place of its own, or none: what lies beside what stays as it is, and the place of a dot that
    /// goes is filled by what is around it.
    ///
    /// # Errors
    /// [`Error::Internal`] if a dot lies in no region.
    pub(crate) fn with_dots(&self, dots: &[Option<Stipple>]) -> Result<Self> {
        let drawing = assemble(parts_with(self, dots)?)?;
        Ok(Self { provenance: self.provenance.clone(), ..drawing })
    }
}

/// What is beside curves and around dots of a drawing, as numbers of regions.
pub(super) struct Surroundings {
    /// To the left and to the right of every curve.
    pub(super) beside: Vec<[u32; 2]>,
    /// Around every dot, if something is.
    pub(super) around: Vec<Option<u32>>,
    /// In a corner of the frame.
    pub(super) on_frame: u32,
}

impl Surroundings {
    pub(super) fn of(drawing: &Drawing) -> Self {
        let (beside, around) = (vec![[0; 2]; drawing.curves.len()], vec![None; drawing.stipples.len()]);
        let mut found = Self { beside, around, on_frame: 0 };
        for (number, region) in (0u32..).zip(&drawing.regions) {
            for part in std::iter::once(&region.exterior).chain(&region.holes).flat_map(|ring| &ring.parts) {
                match *part {
                    // A region runs along a curve with itself on the left.
                    RingPart::Curve { index, reversed } => found.beside[index as usize][usize::from(reversed)] = number,
                    RingPart::Stipple { index } => found.around[index as usize] = Some(number),
                    RingPart::Corner(..) => found.on_frame = number,
                }
            }
        }
        found
    }
}

/// What a drawing was put together from, with other dots in the place of its own, or none. Regions come first among its components,
/// in their order, then the dots.
fn parts_with(drawing: &Drawing, dots: &[Option<Stipple>]) -> Result<Parts> {
    let Surroundings { beside, around, on_frame } = Surroundings::of(drawing);
    let mut inks: Vec<Ink> = drawing.regions.iter().map(|region| region.ink).collect();
    let mut stipples = Vec::new();
    for (dot, around) in dots.iter().zip(around).filter_map(|(dot, around)| Some((dot.as_ref()?, around))) {
        let around = around.ok_or_else(|| Error::Internal("a stipple lies in no region".to_owned()))?;
        stipples.push((*dot, [inks.len() as u32, around]));
        inks.push(dot.ink);
    }
    let curves = drawing.curves.iter().cloned().zip(beside).collect();
    let Drawing { width, height, units, .. } = *drawing;
    Ok(Parts { width, height, units, palette: drawing.palette.clone(), curves, stipples, inks, on_frame })
}

/// The uppermost on-curve point of a ring, the leftmost of those; `tops` are those of the curves.
fn top(drawing: &Drawing, tops: &[Point], ring: &Ring) -> Point {
    let points = ring.parts.iter().map(|part| match *part {
        RingPart::Curve { index, .. } => tops[index as usize],
        RingPart::Stipple { index } => {
            let stipple = &drawing.stipples[index as usize];
            Point::new(stipple.x, stipple.y - stipple.radius)
        }
        RingPart::Corner(x, y) => Point::new(x, y),
    });
    points.min_by(|a, b| from_the_top(*a, *b)).unwrap_or_default()
}

fn top_of_curve(path: &BezPath) -> Point {
    path.elements().iter().filter_map(PathEl::end_point).min_by(|a, b| from_the_top(*a, *b)).unwrap_or_default()
}

/// An order of curves by their points alone, in their own direction.
fn by_points(a: &BezPath, b: &BezPath) -> Ordering {
    let points_of = |element: &PathEl| match *element {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => [Some(p), None, None],
        PathEl::QuadTo(c, p) => [Some(c), Some(p), None],
        PathEl::CurveTo(c, d, p) => [Some(c), Some(d), Some(p)],
        PathEl::ClosePath => [None; 3],
    };
    let [a, b] = [a, b].map(|path| path.elements().iter().flat_map(points_of).flatten().map(|p| [p.y, p.x]));
    // Coordinates are numbers.
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

fn from_the_top(a: Point, b: Point) -> Ordering {
    a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
}

/// Where an open curve meets the frame.
pub(crate) struct FrameEnd {
    pub(crate) place: Place,
    pub(crate) curve: u32,
    /// Whether the curve begins here.
    pub(crate) begins: bool,
}

impl FrameEnd {
    /// What lies on the frame just before and just after this end, in the positive direction, of what lies to the left and to the
    /// right of its curve.
    pub(crate) fn around<T>(&self, [left, right]: [T; 2]) -> [T; 2] {
        if self.begins { [left, right] } else { [right, left] }
    }
}

/// Where a path begins and where it ends.
pub(super) fn ends_of(path: &BezPath) -> [Point; 2] {
    let elements = path.elements();
    [elements.first(), elements.last()].map(|element| element.and_then(PathEl::end_point).unwrap_or_default())
}

/// All ends of open curves on the frame, by their place on it; the others lie in junctions.
pub(crate) fn ends_on_frame(frame: Frame, curves: &[BezPath]) -> Vec<FrameEnd> {
    let mut ends = Vec::new();
    for (number, path) in (0u32..).zip(curves).filter(|(_, path)| !is_closed(path)) {
        for (point, begins) in ends_of(path).into_iter().zip([true, false]).filter(|(point, _)| !frame.holds(*point)) {
            ends.push(FrameEnd { place: frame.place(point), curve: number, begins });
        }
    }
    // Coordinates are numbers.
    ends.sort_by(|a, b| a.place.partial_cmp(&b.place).unwrap_or(Ordering::Equal).then(a.curve.cmp(&b.curve)));
    ends
}

/// The curves that end in every junction, each with whether it begins there. Points are told apart by their bits.
pub(super) fn junctions(frame: Frame, curves: &[BezPath]) -> HashMap<[u64; 2], Vec<(u32, bool)>> {
    let mut junctions: HashMap<[u64; 2], Vec<(u32, bool)>> = HashMap::new();
    for (number, path) in (0u32..).zip(curves).filter(|(_, path)| !is_closed(path)) {
        for (point, begins) in ends_of(path).into_iter().zip([true, false]).filter(|(point, _)| frame.holds(*point)) {
            junctions.entry(bits(point)).or_default().push((number, begins));
        }
    }
    junctions
}

pub(super) fn bits(point: Point) -> [u64; 2] {
    [point.x.to_bits(), point.y.to_bits()]
}

/// The rings that run along open curves, each with the component on its left and whether it touches the frame: from curve to curve in
/// junctions, and along the frame.
fn open_rings(frame: Frame, curves: &[BezPath], beside: &[[u32; 2]], on_frame: u32) -> Result<Vec<(u32, Ring, bool)>> {
    let ends = ends_on_frame(frame, curves);
    let junctions = junctions(frame, curves);
    let mut rings = Vec::new();
    if ends.is_empty() {
        let corner = |p: Point| RingPart::Corner(p.x, p.y);
        rings.push((on_frame, Ring { parts: frame.corners().map(corner).to_vec() }, true));
    }
    // Where the ends of every curve are, of those that are on the frame.
    let mut places = vec![[usize::MAX; 2]; curves.len()];
    for (k, end) in ends.iter().enumerate() {
        places[end.curve as usize][usize::from(!end.begins)] = k;
    }
    // What is on the left of a curve in either direction, and whether a ring was walked there.
    let left_of = |curve: u32, reversed: bool| beside[curve as usize][usize::from(reversed)];
    let walked: Vec<[Cell<bool>; 2]> =
        (0..if junctions.is_empty() { 0 } else { curves.len() }).map(|_| Default::default()).collect();
    // Along a curve with a component on the left, and from junction to junction: to a place on the frame, or back to the first curve.
    let along = |mut curve: u32, mut reversed: bool, component: u32, parts: &mut Vec<RingPart>| {
        let first = (curve, reversed);
        loop {
            parts.push(RingPart::Curve { index: curve, reversed });
            if let Some(walked) = walked.get(curve as usize) {
                walked[usize::from(reversed)].set(true);
            }
            let place = places[curve as usize][usize::from(!reversed)];
            if place != usize::MAX {
                return Ok(Some(place));
            }
            let end = ends_of(&curves[curve as usize])[usize::from(!reversed)];
            let onwards = |&&(other, begins): &&(u32, bool)| other != curve && left_of(other, !begins) == component;
            let Some((other, begins)) = junctions.get(&bits(end)).and_then(|here| here.iter().find(onwards)) else {
                return Err(Error::Internal(format!("a boundary of component {component} ends in ({}, {})", end.x, end.y)));
            };
            (curve, reversed) = (*other, !begins);
            if (curve, reversed) == first {
                return Ok(None);
            }
            if parts.len() > 2 * curves.len() {
                return Err(Error::Internal(format!("a boundary of component {component} does not come back")));
            }
        }
    };
    let mut is_passed = vec![false; ends.len()];
    for first in 0..ends.len() {
        if is_passed[first] {
            continue;
        }
        let around = |end: &FrameEnd| end.around(beside[end.curve as usize]);
        let [_, component] = around(&ends[first]);
        let mut parts = Vec::new();
        let mut k = first;
        while !is_passed[k] {
            is_passed[k] = true;
            let next = (k + 1) % ends.len();
            parts.extend(corners_between(frame, ends[k].place, ends[next].place, next == 0));
            let end = &ends[next];
            let [before, _] = around(end);
            if before != component {
                return Err(Error::Internal(format!("components {component} and {before} meet on the frame without a boundary")));
            }
            k = along(end.curve, !end.begins, component, &mut parts)?
                .ok_or_else(|| Error::Internal(format!("a boundary of component {component} does not leave the frame")))?;
        }
        rings.push((component, Ring { parts }, true));
    }
    for (curve, path) in (0u32..).zip(curves).filter(|_| !junctions.is_empty()) {
        for reversed in [false, true] {
            if !is_closed(path) && !walked[curve as usize][usize::from(reversed)].get() {
                let (component, mut parts) = (left_of(curve, reversed), Vec::new());
                if along(curve, reversed, component, &mut parts)?.is_some() {
                    return Err(Error::Internal(format!("a boundary of component {component} has one end on the frame")));
                }
                rings.push((component, Ring { parts }, false));
            }
        }
    }
    Ok(rings)
}

/// Neighbours whose boundary is on the outside of both lie in the same component, or in none.
fn contain_neighbours(exteriors: &[Option<(Ring, f64)>], beside: &[[u32; 2]], container: &mut [Option<u32>]) {
    // How often a curve is part of an exterior.
    let mut outside = vec![0u8; beside.len()];
    for (ring, _) in exteriors.iter().flatten() {
        for part in &ring.parts {
            if let RingPart::Curve { index, .. } = part {
                outside[*index as usize] += 1;
            }
        }
    }
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); container.len()];
    for [a, b] in beside.iter().zip(&outside).filter(|(_, count)| **count == 2).map(|(beside, _)| *beside) {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let mut open: Vec<u32> = (0..container.len() as u32).filter(|component| container[*component as usize].is_some()).collect();
    while let Some(component) = open.pop() {
        for other in &neighbours[component as usize] {
            if container[*other as usize].is_none() {
                container[*other as usize] = container[component as usize];
                open.push(*other);
            }
        }
    }
}

/// The corners of the frame strictly between two places, in the positive direction from the first to the second; `past_begin` says
/// that the frame's begin lies between.
fn corners_between(frame: Frame, from: Place, to: Place, past_begin: bool) -> impl Iterator<Item = RingPart> {
    let corners = frame.corners();
    let after = corners.into_iter().filter(move |corner| frame.place(*corner) > from && (past_begin || frame.place(*corner) < to));
    let before = corners.into_iter().filter(move |corner| past_begin && frame.place(*corner) < to);
    after.chain(before).map(|corner| RingPart::Corner(corner.x, corner.y))
}

/// The layered order.
fn put_in_order(drawing: &mut Drawing) {
    let regions = drawing.regions.par_iter().enumerate().map(|(i, region)| (region.enclosed_area, Mark::Region(i as u32)));
    let tolerance = drawing.flattening_tolerance();
    let dot_area = |s: &Stipple| signed_area(&circle_polygon([s.x, s.y], s.radius, tolerance));
    let stipples = drawing.stipples.par_iter().enumerate().map(|(i, stipple)| (dot_area(stipple), Mark::Stipple(i as u32)));
    let mut order: Vec<(f64, Mark)> = regions.chain(stipples).collect();
    order.par_sort_by(|a, b| b.0.total_cmp(&a.0));
    drawing.order = order.into_iter().map(|(_, mark)| mark).collect();
}

fn find_levels(drawing: &mut Drawing, container: &[Option<u32>], own_of_region: &[u32], own_of_stipple: &[u32]) -> Result<()> {
    const UNKNOWN: u32 = u32::MAX;
    let mut levels = vec![UNKNOWN; container.len()];
    for &mark in &drawing.order {
        let (component, ink) = match mark {
            Mark::Region(i) => (own_of_region[i as usize], drawing.regions[i as usize].ink),
            Mark::Stipple(i) => (own_of_stipple[i as usize], drawing.stipples[i as usize].ink),
        };
        let level = match container[component as usize] {
            None => u32::from(ink != drawing.palette.paper_label()),
            Some(around) => match levels[around as usize] {
                UNKNOWN => return Err(Error::Internal(format!("component {component} comes before the one around it"))),
                level => level + 1,
            },
        };
        levels[component as usize] = level;
        match mark {
            Mark::Region(i) => drawing.regions[i as usize].level = level,
            Mark::Stipple(i) => drawing.stipples[i as usize].level = level,
        }
    }
    Ok(())
}
