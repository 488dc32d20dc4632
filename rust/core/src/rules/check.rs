//! What of a drawing breaks the rules: every part that is too narrow, every dot and area that is too small, every island.
//!
//! # The idea
//! Regions are looked at without the dots, by opening them (see [`super::thin`]); dots by how far they are from what has their ink.
//! Where they are as far as the rules ask for, no disc that touches something else reaches a dot, so nothing is missed. What a limit
//! allows is measured to a fiftieth of a mm, or a tenth of the limit where that is less: finer than knives, inks and rasters are.
//!
//! Outside of the canvas is white sheet: white that touches the frame goes on there, and black ends.

use kurbo::Point;
use rayon::prelude::*;

use crate::base::{Checked, Control, Ink, Pool, Result};
use crate::drawing::Drawing;
use crate::rules::boxes::Bounds;
use crate::rules::fits::Disc;
use crate::rules::islands::inside;
use crate::rules::near::{Near, Pairs};
use crate::rules::report::{Report, Shape, Violation, ViolationKind};
use crate::rules::rules::{Islands, Rules};
use crate::rules::shapes::{Shapes, refuse_inks, tolerance_for};
use crate::rules::thin::{Thin, thin};

/// What is allowed to be narrower than a limit, in mm, and as a share of it.
const ALLOWANCE: f64 = 0.02;
const ALLOWANCE_OF_LIMIT: f64 = 0.1;

/// The share of a limit of area that is allowed to be missing.
pub(super) const ALLOWANCE_OF_AREA: f64 = 0.02;

/// What may be less than a limit of length without breaking it, in mm.
pub(super) fn allowance(limit: f64) -> f64 {
    ALLOWANCE.min(ALLOWANCE_OF_LIMIT * limit)
}

/// How exactly areas follow curves where these are the rules, in mm.
pub(super) fn tolerance_of(rules: &Rules) -> f64 {
    let finest = rules.finest().min(rules.min_area.map_or(f64::INFINITY, f64::sqrt));
    tolerance_for(if finest.is_finite() { finest } else { 1.0 })
}

/// What breaks the rules where the drawing has `scale` mm to a pixel.
///
/// # Errors
/// [`crate::Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of points; a drawing of 400,000 vertices takes a few times as long as drawing it.
pub fn check(drawing: &Drawing, rules: &Checked<Rules>, scale: f64, control: &Control) -> Result<Report> {
    refuse_inks(drawing)?;
    Pool::new(None).run(|| {
        let shapes = Shapes::new(drawing, scale, tolerance_of(rules));
        let (of_black, of_white) = rayon::join(|| too_thin(&shapes, rules, Ink::BLACK), || too_thin(&shapes, rules, Ink::WHITE));
        let mut violations = of_black?;
        violations.extend(of_white?);
        control.check()?;
        violations.extend(of_dots(&shapes, rules, control)?);
        violations.extend(of_regions(&shapes, rules));
        violations.par_sort_by(|a, b| {
            let place = a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x));
            a.kind.cmp(&b.kind).then(place).then(a.measured.total_cmp(&b.measured))
        });
        let [width, height] = shapes.size();
        Ok(Report { width, height, scale, rules: **rules, violations, changes: None })
    })
}

/// Parts of regions that are too thin.
fn too_thin(shapes: &Shapes, rules: &Rules, ink: Ink) -> Result<Vec<Violation>> {
    let limit = rules.narrowest(ink);
    if limit == 0.0 {
        return Ok(Vec::new());
    }
    let kind = if ink == Ink::BLACK { ViolationKind::Neck } else { ViolationKind::Gap };
    let of = |Thin { width, length, place: [x, y], outline }: Thin| {
        let measured = width.min(limit - allowance(limit));
        Violation { kind, x, y, measured, limit, length, shape: Shape::Area(outline) }
    };
    let disc = Disc { ink, diameter: limit - allowance(limit), tolerance: shapes.tolerance };
    let found = thin(&shapes.black, shapes.size(), disc)?;
    Ok(found.into_iter().map(of).collect())
}

/// Dots that are too small, or too near to something.
fn of_dots(shapes: &Shapes, rules: &Rules, control: &Control) -> Result<Vec<Violation>> {
    let drawing = shapes.drawing;
    if drawing.stipples.is_empty() {
        return Ok(Vec::new());
    }
    let size = shapes.size();
    let near = Near::of(&shapes.black, size);
    let mut violations = Vec::new();
    for ink in [Ink::BLACK, Ink::WHITE] {
        control.check()?;
        let dots: Vec<([f64; 2], f64)> = drawing.stipples.iter().filter(|dot| dot.ink == ink).map(|dot| shapes.disc(dot)).collect();
        let least = rules.least_dot(ink);
        let small = dots.iter().filter(|(_, radius)| 2.0 * radius < least - allowance(least));
        violations.extend(small.map(|disc| of_disc(ViolationKind::Dot, *disc, 2.0 * disc.1, least)));
        // Between a dot and what has its ink lies the other ink.
        let limit = rules.narrowest(ink.other());
        if limit == 0.0 {
            continue;
        }
        let kind = if ink == Ink::BLACK { ViolationKind::Gap } else { ViolationKind::Neck };
        let reach = limit - allowance(limit);
        let between = |p: [f64; 2], q: [f64; 2], distance: f64| {
            let shape = Shape::Way([p, q]);
            Violation { kind, x: 0.5 * (p[0] + q[0]), y: 0.5 * (p[1] + q[1]), measured: distance, limit, length: limit, shape }
        };
        let pairs = Pairs::of(&dots, size);
        let of_dot = |number: usize| -> Vec<Violation> {
            let (centre, radius) = dots[number];
            let on_rim = |towards: [f64; 2], radius: f64, centre: [f64; 2]| {
                let out = Point::new(towards[0], towards[1]) - Point::new(centre[0], centre[1]);
                let out = out * (radius / out.hypot2().sqrt().max(1e-12));
                [centre[0] + out.x, centre[1] + out.y]
            };
            let mut found = Vec::new();
            let edge = near.nearest(centre, radius + reach);
            let to_edge = edge.map_or(f64::INFINITY, |(distance, _)| distance - radius);
            if let Some((_, at)) = edge {
                found.push(between(on_rim(at, radius, centre), at, to_edge.max(0.0)));
            }
            for (distance, other) in pairs.neighbours(number, reach) {
                // Each pair once. Where an edge is nearer it lies between, or it is told of already.
                let (other_centre, other_radius) = dots[other];
                let is_first = other > number || !pairs.neighbours(other, reach).iter().any(|(_, back)| *back == number);
                if is_first && distance < to_edge && distance < near.distance(other_centre, other_radius + reach) - other_radius {
                    let (a, b) = (on_rim(other_centre, radius, centre), on_rim(centre, other_radius, other_centre));
                    found.push(between(a, b, distance.max(0.0)));
                }
            }
            found
        };
        let found: Vec<Vec<Violation>> = (0..dots.len()).into_par_iter().map(of_dot).collect();
        violations.extend(found.into_iter().flatten());
    }
    Ok(violations)
}

/// Regions that are too small, and islands.
fn of_regions(shapes: &Shapes, rules: &Rules) -> Vec<Violation> {
    let drawing = shapes.drawing;
    let mut violations = Vec::new();
    let reports_islands = rules.islands != Islands::Allow;
    let least = rules.min_area.unwrap_or(0.0);
    if least == 0.0 && !reports_islands {
        return violations;
    }
    let found = (0..drawing.regions.len()).into_par_iter().map(|index| {
        let region = &drawing.regions[index];
        let is_sheet = region.ink == Ink::WHITE && region.level == 0;
        let is_island = reports_islands && region.ink == Ink::WHITE && !is_sheet;
        let area = if is_sheet { f64::INFINITY } else { shapes.area_of(index) };
        let is_small = area < least * (1.0 - ALLOWANCE_OF_AREA);
        if !is_island && !is_small {
            return Vec::new();
        }
        let path = drawing.ring_path(&region.exterior);
        let rings: Vec<Vec<[f64; 2]>> =
            std::iter::once(&region.exterior).chain(&region.holes).map(|ring| shapes.ring(ring)).collect();
        let bounds = Bounds::of(&rings[0]);
        let [x, y] = inside(&rings, bounds.0).unwrap_or(rings[0][0]);
        let violation = |kind, limit| Violation {
            kind,
            x,
            y,
            measured: area,
            limit,
            length: bounds.longer_side(),
            shape: Shape::Region(path.clone()),
        };
        let mut found = Vec::new();
        if is_small {
            found.push(violation(ViolationKind::Area, least));
        }
        if is_island {
            found.push(violation(ViolationKind::Island, 0.0));
        }
        found
    });
    let found: Vec<Vec<Violation>> = found.collect();
    violations.extend(found.into_iter().flatten());
    if reports_islands {
        violations.extend(drawing.stipples.iter().filter(|dot| dot.ink == Ink::WHITE).map(|dot| {
            let disc = shapes.disc(dot);
            of_disc(ViolationKind::Island, disc, std::f64::consts::PI * disc.1 * disc.1, 0.0)
        }));
    }
    violations
}

/// What is wrong with a dot.
fn of_disc(kind: ViolationKind, ([x, y], radius): ([f64; 2], f64), measured: f64, limit: f64) -> Violation {
    Violation { kind, x, y, measured, limit, length: 2.0 * radius, shape: Shape::Circle(radius) }
}
