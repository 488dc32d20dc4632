//! A drawing that keeps the rules: what is too narrow, too small or too near goes, or grows.
//!
//! # The idea
//! Regions first, without the dots. Those that are too small are filled by what is around them; then black is opened by a disc
//! of the narrowest black, and closed by one of the narrowest white, again until nothing is lost and nothing gained. Opening one may
//! make the other too narrow, back and forth; so after three rounds all that is still too narrow becomes wide instead, black or white,
//! whichever the picture has lost, and as that only grows there is an end. Last the dots are placed in what the regions have become,
//! where they make up for what was lost and gained (see [`super::dots`]).
//!
//! Each round opens with a disc a hair smaller than the last one did, so that what an earlier one has left is not looked at again for
//! what is rounded in between. The largest of these is what the rules say, the smallest still above what a check looks for.

use crate::base::{Checked, Control, Error, Ink, Pool, Result, signed_area};
use crate::drawing::{Drawing, Loose, put_together};
use crate::offset::{Polygon, intersection, offset, subtracted, united};
use crate::rules::areas::Nesting;
use crate::rules::boxes::{Bounds, Boxes, zone};
use crate::rules::changes::Changes;
use crate::rules::check::{allowance, tolerance_of};
use crate::rules::dots::{Change, DotCounts, black_of, changes_of, place};
use crate::rules::rules::Rules;
use crate::rules::shapes::{Area, Shapes};
use crate::rules::thin::{Opened, with_rim};

/// Rounds of opening and closing.
const ROUNDS: usize = 3;

/// Rounds in which what is too narrow grows.
const REPAIRS: usize = 12;

struct Work<'a> {
    rules: &'a Checked<Rules>,
    shapes: &'a Shapes<'a>,
    control: &'a Control,
    /// The black areas so far.
    areas: Vec<Area>,
    /// What was lost and gained on the way.
    changed: Vec<Change>,
    /// What came and went since black, and since white, was opened last.
    since: [Vec<Polygon>; 2],
    changes: Changes,
}

/// The drawing as the rules allow it, `scale` mm to a pixel, and what was done to it.
///
/// # Errors
/// [`Error::Input`] if nothing would be left, [`Error::Cancelled`].
pub fn enforce(drawing: &Drawing, rules: &Checked<Rules>, scale: f64, control: &Control) -> Result<(Drawing, Changes)> {
    Pool::new(None).run(|| {
        let tolerance = tolerance_of(rules);
        let canvas = (drawing.width * drawing.height) as f64 * scale * scale;
        let tone = |drawing: &Drawing| 1.0 - black_of(drawing, scale) / canvas;
        let shapes = Shapes::new(drawing, scale, tolerance);
        let changes = Changes { tone_before: tone(drawing), ..Changes::default() };
        let (changed, since) = (Vec::new(), [Vec::new(), Vec::new()]);
        let mut work = Work { rules, shapes: &shapes, control, areas: shapes.areas(), changed, since, changes };
        work.regions()?;
        let (made, counts) = work.with_dots(drawing)?;
        let DotCounts { kept, enlarged, reduced, dropped } = counts;
        let changes = Changes {
            dots_kept: kept,
            dots_enlarged: enlarged,
            dots_reduced: reduced,
            dots_dropped: dropped,
            tone: tone(&made),
            ..work.changes
        };
        Ok((made, changes))
    })
}

impl Work<'_> {
    fn tolerance(&self) -> f64 {
        self.shapes.tolerance
    }

    /// The area of the least dot: what is shared out along outlines.
    fn part(&self) -> f64 {
        let least = self.rules.least_dot(Ink::Black).max(self.rules.least_dot(Ink::White));
        0.25 * std::f64::consts::PI * least * least
    }

    fn regions(&mut self) -> Result<()> {
        let mut grows = None;
        for round in 0..ROUNDS + REPAIRS {
            self.fill_small()?;
            if round == ROUNDS {
                let missing: f64 = self.changed.iter().map(|change| change.missing).sum();
                grows = Some(if missing >= 0.0 { Ink::Black } else { Ink::White });
            }
            let has_lost = self.open(Ink::Black, round, grows)?;
            let has_gained = self.open(Ink::White, round, grows)?;
            self.changes.rounds = round + 1;
            if !has_lost && !has_gained {
                break;
            }
        }
        self.fill_small()
    }

    /// Fills what is too small until nothing is.
    fn fill_small(&mut self) -> Result<()> {
        let Some(least) = self.rules.min_area else { return Ok(()) };
        loop {
            self.control.check()?;
            let outlines: Vec<&Polygon> = self.areas.iter().map(|area| &area.outline).collect();
            let nesting = Nesting::of(&outlines);
            let gone = nesting.too_small(least);
            if gone.is_empty() {
                return Ok(());
            }
            for &node in &gone {
                let [area, ring] = nesting.rings[node];
                let points = &outlines[area][ring];
                let sum = points.iter().fold([0.0, 0.0], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
                let missing = if ring == 0 { nesting.sizes[node] } else { -nesting.sizes[node] };
                self.changed.push(Change { place: sum.map(|v| v / points.len() as f64), missing });
                self.since.iter_mut().for_each(|since| since.push(vec![points.clone()]));
            }
            let left = nesting.without(&gone);
            let made = |rings: &Vec<[usize; 2]>| {
                let [own, _] = rings[0];
                let is_same = rings.len() == outlines[own].len() && rings.iter().all(|[area, _]| *area == own);
                Area {
                    outline: rings.iter().map(|[area, ring]| outlines[*area][*ring].clone()).collect(),
                    region: self.areas[own].region.filter(|_| is_same),
                }
            };
            self.areas = left.iter().map(made).collect();
            self.changes.areas_filled += gone.len();
        }
    }

    /// Opens what has an ink: takes off what is too thin, or makes it wide where that ink grows. Says whether there was any.
    fn open(&mut self, ink: Ink, round: usize, grows: Option<Ink>) -> Result<bool> {
        let limit = self.rules.narrowest(ink);
        let since = std::mem::take(&mut self.since[ink as usize]);
        if limit == 0.0 || (round > 0 && since.is_empty()) {
            return Ok(false);
        }
        // From a hundredth above the limit down to half of what is allowed.
        let diameter = (limit * (1.01 - 0.01 * round as f64)).max(limit - 0.5 * allowance(limit));
        let thin = if round == 0 {
            let all: Vec<Polygon> = self.areas.iter().map(|area| area.outline.clone()).collect();
            Opened::of(&all, ink, diameter, self.tolerance())?.thin
        } else {
            self.thin_near(&since, ink, diameter)?
        };
        if thin.is_empty() {
            return Ok(false);
        }
        if std::env::var("DBG").is_ok() { eprintln!("round {round} {ink:?} grows {grows:?}: {} thin of {:.4} mm2, largest {:.4}, d {diameter}", thin.len(), crate::offset::area(&thin), thin.iter().map(|t| crate::offset::area(std::slice::from_ref(t))).fold(0.0, f64::max)); if round > 3 { for t in thin.iter().take(2) { eprintln!("   {:?}", t); } } }
        self.control.check()?;
        // Black that goes is missing, and so is black where white grows.
        let sign = if ink == Ink::Black { 1.0 } else { -1.0 };
        let part = self.part();
        self.changed.extend(changes_of(&thin, sign, part));
        match ink {
            Ink::Black => self.changes.features += thin.len(),
            Ink::White => self.changes.gaps += thin.len(),
        }
        let (patches, is_added) = if grows == Some(ink) {
            let wide = self.widened(&thin, 0.5 * limit)?;
            self.changed.extend(changes_of(&wide, -sign, part));
            (wide, ink == Ink::Black)
        } else {
            (with_rim(&thin, self.tolerance())?, ink == Ink::White)
        };
        self.patch(&patches, is_added)?;
        self.since.iter_mut().for_each(|since| since.extend(patches.iter().cloned()));
        Ok(true)
    }

    /// What is too thin near what has changed: elsewhere it is as it was.
    fn thin_near(&self, since: &[Polygon], ink: Ink, diameter: f64) -> Result<Vec<Polygon>> {
        // What a disc that touches something has in it lies within its diameter.
        let inner = zone(since, 1.1 * diameter)?;
        let outer = zone(since, 2.3 * diameter)?;
        let boxes = Boxes::new(outer.iter().map(|area| Bounds::of(&area[0])).collect());
        let near = self.areas.iter().map(|area| &area.outline).filter(|outline| boxes.meets(Bounds::of(&outline[0])));
        let near: Vec<Polygon> = near.cloned().collect();
        let cut = intersection(&near, &outer)?;
        let thin = Opened::of(&cut, ink, diameter, self.tolerance())?.thin;
        intersection(&thin, &inner)
    }

    /// Adds patches to the areas, or takes them off.
    fn patch(&mut self, patches: &[Polygon], is_added: bool) -> Result<()> {
        let boxes = Boxes::new(patches.iter().map(|patch| Bounds::of(&patch[0])).collect());
        let (near, far): (Vec<Area>, Vec<Area>) =
            std::mem::take(&mut self.areas).into_iter().partition(|area| boxes.meets(Bounds::of(&area.outline[0])));
        let near: Vec<Polygon> = near.into_iter().map(|area| area.outline).collect();
        let made = if is_added { united(&[&near, patches].concat())? } else { subtracted(&near, patches)? };
        // What is smaller than the tolerance is not there.
        let least = self.tolerance() * self.tolerance();
        let clean = |outline: Polygon| -> Option<Area> {
            let mut rings = outline.into_iter();
            let exterior = rings.next().filter(|ring| signed_area(ring).abs() > least)?;
            let holes = rings.filter(|ring| signed_area(ring).abs() > least);
            Some(Area { outline: std::iter::once(exterior).chain(holes).collect(), region: None })
        };
        self.areas = far;
        self.areas.extend(made.into_iter().filter_map(clean));
        Ok(())
    }

    /// Thin parts as wide as a limit, on the canvas.
    fn widened(&self, thin: &[Polygon], radius: f64) -> Result<Vec<Polygon>> {
        let Drawing { width, height, .. } = *self.shapes.drawing;
        let [width, height] = [width, height].map(|side| side as f64 * self.shapes.scale);
        let canvas = vec![vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]];
        intersection(&offset(thin, radius, self.tolerance())?, &[canvas])
    }

    /// The regions with dots.
    fn with_dots(&self, old: &Drawing) -> Result<(Drawing, DotCounts)> {
        let regions = self.shapes.drawing_of(&self.areas, self.control)?;
        let shapes = Shapes::new(&regions, self.shapes.scale, self.tolerance());
        let limits = [self.rules.min_feature, self.rules.min_gap, self.rules.min_dot];
        let finest = limits.into_iter().flatten().fold(f64::INFINITY, f64::min);
        let allowance = if finest.is_finite() { 0.5 * allowance(finest) } else { 0.0 };
        let (stipples, counts) = place(&shapes, &old.stipples, &self.changed, self.rules, allowance, self.control)?;
        let Drawing { width, height, units, .. } = regions;
        let ground = regions.regions.first().map_or(Ink::White, |region| region.ink);
        let loose = Loose { width, height, units, curves: regions.curves, stipples, ground };
        let made = put_together(loose, &|shape| format!("{shape:?}"), self.control).map_err(|error| match error {
            Error::Cancelled => error,
            other => Error::Internal(format!("what keeps the rules is no drawing: {other}")),
        })?;
        Ok((Drawing { provenance: old.provenance.clone(), ..made }, counts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Format;
    use std::time::Instant;

    #[test]
    #[ignore]
    fn times() {
        for file in std::env::var("F").unwrap().split(',') {
            let bytes = std::fs::read(file).unwrap();
            let control = Control::new();
            let drawing = crate::load(&bytes, Format::of_suffix("json").unwrap(), &control).unwrap();
            for (process, width) in [("stencil", 200.0), ("laser", 200.0), ("laser", 60.0), ("pen", 60.0), ("screen-print", 60.0), ("lino", 100.0)] {
                let rules = Rules::of_process(process).unwrap().check().unwrap();
                let t = Instant::now();
                let made = enforce(&drawing, &rules, width / drawing.width as f64, &control);
                match made {
                    Ok((made, changes)) => {
                        println!("{process} {width}: {:?} {} curves {changes:?}", t.elapsed(), made.curves.len());
                        let writer = Format::of_suffix("json").unwrap().writer(crate::Export::default().check().unwrap()).unwrap();
                        let path = format!("{}.{process}.{width}.out.json", file.trim_end_matches(".json"));
                        std::fs::write(path, writer.write(&made).unwrap()).unwrap();
                    }
                    Err(error) => println!("{process} {width}: {:?} {error}", t.elapsed()),
                }
            }
        }
    }
}
