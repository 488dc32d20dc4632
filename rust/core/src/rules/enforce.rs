//! A drawing that keeps the rules: what is too narrow, too small or too near goes, or grows.
//!
//! # The idea
//! Regions first, without the dots. Those that are too small are filled by what is around them; then black is opened by a disc
//! of the narrowest black, and closed by one of the narrowest white, again until nothing is lost and nothing gained. Opening one may
//! make the other too narrow, back and forth; so after two rounds all that is still too narrow becomes wide instead, black or white,
//! whichever the picture has lost, and as that only grows there is an end. Islands that are to have bridges get them before all this, in
//! label space, where the drawing's graph is known; those that are there after it get straight ones. Last the dots are placed in what the
//! regions have become, where they make up for what was lost and gained (see [`super::dots`]).
//!
//! Each round opens with a disc a hair smaller than the last one did, so that what an earlier one has left is not looked at again for
//! what is rounded in between. The largest of these is a hair above the limit, the smallest still above what a check looks for.
//! After the first, a round looks only near what has changed.

use std::sync::Arc;

use serde_json::json;

use crate::base::{Checked, Control, Error, Ink, Pool, Result, circle_polygon, signed_area};
use crate::drawing::{Drawing, Loose, put_together};
use crate::offset::{Polygon, intersection, offset, subtracted, united};
use crate::pipeline::Outcome;
use crate::rules::areas::Nesting;
use crate::rules::boxes::{Bounds, Boxes};
use crate::rules::bridges::bridge;
use crate::rules::bridging::{Bridged, Bridging};
use crate::rules::changes::Changes;
use crate::rules::check::{ALLOWANCE_OF_AREA, allowance, tolerance_of};
use crate::rules::dots::{Change, Placing, black_of, changes_of, middle};
use crate::rules::fits::Disc;
use crate::rules::rules::{Islands, Rules};
use crate::rules::shapes::{Shapes, refuse_inks};
use crate::rules::straight::straight;
use crate::rules::thin::{Opened, has_thin, with_rim};

/// Rounds of opening and closing.
const ROUNDS: usize = 2;

/// Rounds in which what is too narrow grows.
const REPAIRS: usize = 16;

/// Nothing is done if nothing lacks more than this share of what is allowed: more than what rounds leave, less than what a check tells.
const KEEPS: f64 = 0.75;

/// An ink without a limit of its own may get no narrower than this share of the other one's where something has changed: areas that
/// touch are no drawing.
const UNLIMITED: f64 = 0.1;

/// How often islands are bridged that the rounds after a bridge have made.
const MOST_BRIDGINGS: usize = 4;

/// Bridges are so much wider than the narrowest white, so that they are not taken for gaps.
const BRIDGE: f64 = 1.03;

/// How wide bridges are where no width is limited, in mm: as in stencils of film.
const BRIDGE_WITHOUT_LIMIT: f64 = 0.8;

/// How often areas that touch are taken apart.
const MOST_TOUCHES: usize = 16;

/// How often a drawing of which nothing is left is tried at twice the width.
const MOST_DOUBLINGS: usize = 16;

/// Halvings of the interval in which the least width lies that leaves something: to 5 % of it.
const HALVINGS: usize = 4;

/// What [`Provenance::rest`](crate::stages::Provenance::rest) has of rules.
const TOLD: &str = "rules";

struct Work<'a> {
    rules: &'a Rules,
    shapes: &'a Shapes<'a>,
    control: &'a Control,
    /// The black areas so far.
    areas: Vec<Polygon>,
    /// Which black region of the drawing every area is, if it is that still.
    origins: Vec<Option<usize>>,
    /// What was lost and gained on the way.
    changed: Vec<Change>,
    /// What came and went since black, and since white, was opened last.
    since: [Vec<Polygon>; 2],
    /// Whether each of them was opened everywhere.
    is_begun: [bool; 2],
    changes: Changes,
}

/// The drawing as the rules allow it where it has `scale` mm to a pixel, and what was done to it. With what drawing it left, islands get
/// their bridges in label space; without, and where they come to be only by what else is done, straight ones.
///
/// # Errors
/// [`Error::Input`] if nothing would be left, [`Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of points; a drawing of 400,000 vertices takes a few times as long as drawing it.
pub fn enforce(
    drawing: &Drawing,
    outcome: Option<&Outcome>,
    rules: &Checked<Rules>,
    scale: f64,
    control: &Control,
) -> Result<(Drawing, Changes)> {
    refuse_inks(drawing)?;
    Pool::new(None).run(|| {
        let given = Given { drawing, outcome: outcome.filter(|outcome| outcome.labels.inks.is_none()), rules };
        let (made, changes) = given.enforced(scale, control)?;
        if is_blank(&made) && !is_blank(drawing) {
            return Err(Error::Input(given.nothing_left(scale, control)?));
        }
        let mut told = json!(**rules);
        told["width"] = json!(drawing.width as f64 * scale);
        let mut provenance = drawing.provenance.clone();
        provenance.rest.insert(TOLD.to_owned(), told);
        Ok((Drawing { provenance, ..made }, changes))
    })
}

fn is_blank(drawing: &Drawing) -> bool {
    drawing.curves.is_empty() && drawing.stipples.is_empty()
}

/// A width with three digits.
fn rounded_up(width: f64) -> f64 {
    let unit = libm::exp10(libm::floor(libm::log10(width)) - 2.0);
    // Powers below 1 are not exact.
    if unit >= 1.0 { (width / unit - 1e-9).ceil() * unit } else { (width / unit - 1e-9).ceil() / (1.0 / unit).round() }
}

/// What is to keep rules.
struct Given<'a> {
    drawing: &'a Drawing,
    /// What drawing it left.
    outcome: Option<&'a Outcome>,
    rules: &'a Rules,
}

impl Given<'_> {
    /// The sentence for rules that leave nothing.
    fn nothing_left(&self, scale: f64, control: &Control) -> Result<String> {
        let width = self.drawing.width as f64 * scale;
        let leaves = |times: f64| Ok(!is_blank(&self.enforced(scale * times, control)?.0));
        let begin = format!("the rules leave nothing of a drawing {} mm wide", rounded_up(width));
        let mut high = 2.0;
        for _ in 0..MOST_DOUBLINGS {
            if leaves(high)? {
                let mut low = 0.5 * high;
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    if leaves(middle)? { high = middle } else { low = middle }
                }
                return Ok(format!("{begin}: it must be at least {} mm wide", rounded_up(high * width)));
            }
            high *= 2.0;
        }
        Ok(format!("{begin}, nor of one {} mm wide", rounded_up(0.5 * high * width)))
    }

    /// The drawing with its islands joined, and what that was, if it can be done in label space.
    fn bridged(&self, scale: f64, control: &Control) -> Result<Option<(Arc<Drawing>, Bridged)>> {
        let Some(outcome) = self.outcome.filter(|_| self.rules.islands == Islands::Bridge) else { return Ok(None) };
        let min_area = self.rules.min_area.unwrap_or(0.0) / (scale * scale);
        let bridging = Bridging { min_area, width: bridge_width(self.rules) / scale };
        let (made, told) = bridge(outcome, &bridging, control)?;
        Ok(Some((made.drawing, told)))
    }

    fn enforced(&self, scale: f64, control: &Control) -> Result<(Drawing, Changes)> {
        let canvas = (self.drawing.width * self.drawing.height) as f64 * scale * scale;
        let tone = |drawing: &Drawing| 1.0 - black_of(drawing, scale) / canvas;
        let mut changes = Changes { tone_before: tone(self.drawing), ..Changes::default() };
        let bridged = self.bridged(scale, control)?;
        let drawing = match &bridged {
            Some((drawing, told)) => {
                changes.joined(told);
                drawing
            }
            None => self.drawing,
        };
        let shapes = Shapes::new(drawing, scale, tolerance_of(self.rules));
        let areas = shapes.black.clone();
        let mut work = Work {
            rules: self.rules,
            shapes: &shapes,
            control,
            origins: (0..areas.len()).map(Some).collect(),
            areas,
            changed: Vec::new(),
            since: [Vec::new(), Vec::new()],
            is_begun: [false; 2],
            changes,
        };
        work.take_up_islands()?;
        work.open_all(None)?;
        work.bridge()?;
        let regions = work.assembled()?;
        let made = work.with_dots(drawing, regions, canvas)?;
        let changes = Changes { tone: tone(&made), ..work.changes };
        Ok((made, changes))
    }
}

/// How wide bridges are, in mm.
fn bridge_width(rules: &Rules) -> f64 {
    let limits = [rules.min_gap, rules.min_feature, rules.min_dot];
    BRIDGE * limits.into_iter().flatten().next().unwrap_or(BRIDGE_WITHOUT_LIMIT)
}

impl Work<'_> {
    fn tolerance(&self) -> f64 {
        self.shapes.tolerance
    }

    /// The area of the least dot: what is shared out along outlines.
    fn part(&self) -> f64 {
        let least = self.rules.least_dot(Ink::BLACK).max(self.rules.least_dot(Ink::WHITE));
        0.25 * std::f64::consts::PI * least * least
    }

    /// Makes white dots holes of the areas where they are islands that get a bridge; the others go.
    fn take_up_islands(&mut self) -> Result<()> {
        if self.rules.islands != Islands::Bridge {
            return Ok(());
        }
        let least = self.rules.min_area.unwrap_or(0.0);
        let dots = self.shapes.drawing.stipples.iter().filter(|dot| dot.ink == Ink::WHITE).map(|dot| self.shapes.disc(dot));
        let dots = dots.filter(|(_, radius)| std::f64::consts::PI * radius * radius >= least);
        let holes: Vec<Polygon> = dots.map(|(centre, radius)| vec![circle_polygon(centre, radius, self.tolerance())]).collect();
        if !holes.is_empty() {
            // The dots count as lost later: they are in what the areas lack.
            self.changed.extend(changes_of(&holes, 1.0, self.part()));
            self.patch(&holes, false)?;
        }
        Ok(())
    }

    /// Opens black and white in turn until nothing is too thin.
    fn open_all(&mut self, grows: Option<Ink>) -> Result<()> {
        let mut grows = grows;
        let first = if grows.is_some() { ROUNDS } else { 0 };
        for round in first..ROUNDS + REPAIRS {
            self.fill_small()?;
            if round == ROUNDS && grows.is_none() {
                grows = Some(self.lost());
            }
            let has_lost = self.open(Ink::BLACK, round, grows)?;
            let has_gained = self.open(Ink::WHITE, round, grows)?;
            self.changes.rounds += 1;
            if !has_lost && !has_gained {
                break;
            }
        }
        self.fill_small()
    }

    /// The ink that the picture has lost on the way.
    fn lost(&self) -> Ink {
        let missing: f64 = self.changed.iter().map(|change| change.missing).sum();
        if missing >= 0.0 { Ink::BLACK } else { Ink::WHITE }
    }

    /// Fills what is too small until nothing is.
    fn fill_small(&mut self) -> Result<()> {
        let Some(least) = self.rules.min_area else { return Ok(()) };
        loop {
            self.control.check()?;
            let nesting = Nesting::of(&self.areas);
            // As with what is too thin.
            let spared = if self.changed.is_empty() { KEEPS * ALLOWANCE_OF_AREA } else { 0.0 };
            let gone = nesting.too_small(least * (1.0 - spared));
            if gone.is_empty() {
                return Ok(());
            }
            for &node in &gone {
                let [area, ring] = nesting.rings[node];
                let points = &self.areas[area][ring];
                let missing = if ring == 0 { nesting.sizes[node] } else { -nesting.sizes[node] };
                self.changed.push(Change { place: middle(points), missing });
                self.since.iter_mut().for_each(|since| since.push(vec![points.clone()]));
            }
            let left = nesting.without(&gone);
            let is_same = |rings: &Vec<[usize; 2]>| {
                let [own, _] = rings[0];
                rings.len() == self.areas[own].len() && rings.iter().all(|[area, _]| *area == own)
            };
            self.origins = left.iter().map(|rings| self.origins[rings[0][0]].filter(|_| is_same(rings))).collect();
            self.areas =
                left.iter().map(|rings| rings.iter().map(|[area, ring]| self.areas[*area][*ring].clone()).collect()).collect();
            self.changes.areas_filled += gone.len();
        }
    }

    /// Opens what has an ink: takes off what is too thin, or makes it wide where that ink grows. Says whether there was any.
    fn open(&mut self, ink: Ink, round: usize, grows: Option<Ink>) -> Result<bool> {
        let rule = self.rules.narrowest(ink);
        let limit = if rule > 0.0 { rule } else { UNLIMITED * self.rules.narrowest(ink.other()) };
        let since = std::mem::take(&mut self.since[ink.index()]);
        let is_first = !std::mem::replace(&mut self.is_begun[ink.index()], true) && rule > 0.0;
        if limit == 0.0 || (since.is_empty() && !is_first) {
            return Ok(false);
        }
        // From a hundredth above the limit down to half of what is allowed.
        let diameter = (limit * (1.01 - 0.01 * round as f64)).max(limit - 0.5 * allowance(limit));
        // Elsewhere all is as it was: what a disc that touches something has in it lies within its diameter.
        let boxes = Boxes::new(since.iter().map(|area| Bounds::of(&area[0]).wider(1.1 * diameter)).collect());
        let within = (!is_first).then_some(&boxes);
        // A drawing that keeps the rules stays as it is.
        let disc = |diameter: f64| Disc { ink, diameter, tolerance: self.tolerance() };
        if is_first && !has_thin(&self.areas, self.shapes.size(), disc(limit - KEEPS * allowance(limit)))? {
            return Ok(false);
        }
        let opened = Opened::of(&self.areas, self.shapes.size(), disc(diameter), within)?;
        if opened.thin.is_empty() {
            return Ok(false);
        }
        // Where an ink grows its corners do, too, but for those at the frame: they would walk along it.
        let (thin, wide) = if grows == Some(ink) {
            let [thin, corners] = opened.apart(&self.areas, disc(diameter));
            let (at_frame, others): (Vec<_>, Vec<_>) = corners.into_iter().partition(|part| self.is_at_frame(part));
            (at_frame, self.widened(&[thin, others].concat(), 0.5 * limit)?)
        } else {
            (opened.thin, Vec::new())
        };
        self.control.check()?;
        // Black that goes is missing, and so is black where white grows.
        let sign = ink.sign();
        let part = self.part();
        self.changed.extend(changes_of(&thin, sign, part));
        match ink {
            Ink::BLACK => self.changes.features += thin.len() + wide.len(),
            _ => self.changes.gaps += thin.len() + wide.len(),
        }
        if !wide.is_empty() {
            let gained = if ink == Ink::BLACK { subtracted(&wide, &self.areas)? } else { intersection(&wide, &self.areas)? };
            self.changed.extend(changes_of(&gained, -sign, part));
            self.patch(&wide, ink == Ink::BLACK)?;
        }
        if !thin.is_empty() {
            self.patch(&with_rim(&thin, self.tolerance())?, ink == Ink::WHITE)?;
        }
        Ok(true)
    }

    /// Whether an area reaches the frame.
    fn is_at_frame(&self, area: &Polygon) -> bool {
        let ([width, height], near) = (self.shapes.size(), self.tolerance());
        let Bounds([left, top, right, bottom]) = Bounds::of(&area[0]);
        left < near || top < near || right > width - near || bottom > height - near
    }

    /// Adds patches to the areas, or takes them off.
    fn patch(&mut self, patches: &[Polygon], is_added: bool) -> Result<()> {
        let boxes = Boxes::new(patches.iter().map(|patch| Bounds::of(&patch[0])).collect());
        let (mut near, mut far, mut origins) = (Vec::new(), Vec::new(), Vec::new());
        for (area, origin) in std::mem::take(&mut self.areas).into_iter().zip(&self.origins) {
            if boxes.meets(Bounds::of(&area[0])) {
                near.push(area);
            } else {
                far.push(area);
                origins.push(*origin);
            }
        }
        let made = if is_added { united(&[&near, patches].concat())? } else { subtracted(&near, patches)? };
        // What is smaller than the tolerance is not there.
        let least = self.tolerance() * self.tolerance();
        let clean = |area: Polygon| -> Option<Polygon> {
            let mut rings = area.into_iter();
            let exterior = rings.next().filter(|ring| signed_area(ring).abs() > least)?;
            let holes = rings.filter(|ring| signed_area(ring).abs() > least);
            Some(std::iter::once(exterior).chain(holes).collect())
        };
        far.extend(made.into_iter().filter_map(clean));
        origins.resize(far.len(), None);
        (self.areas, self.origins) = (far, origins);
        self.since.iter_mut().for_each(|since| since.extend(patches.iter().cloned()));
        Ok(())
    }

    /// Thin parts as wide as a limit, on the canvas.
    fn widened(&self, thin: &[Polygon], radius: f64) -> Result<Vec<Polygon>> {
        let [width, height] = self.shapes.size();
        let canvas = Bounds([0.0, 0.0, width, height]).area();
        intersection(&offset(thin, radius, self.tolerance())?, &[canvas])
    }

    /// Joins all islands to the frame, those that bridges or what comes after them has made too.
    fn bridge(&mut self) -> Result<()> {
        if self.rules.islands != Islands::Bridge {
            return Ok(());
        }
        let width = bridge_width(self.rules);
        for _ in 0..MOST_BRIDGINGS {
            if self.areas.iter().all(|area| area.len() == 1) {
                return Ok(());
            }
            // What is too small is filled already.
            let (areas, told) = straight(&self.areas, self.shapes.size(), &Bridging { min_area: 0.0, width }, self.control)?;
            for bridge in &told.bridges {
                self.changed.push(Change { place: middle(&bridge.points), missing: bridge.length * width });
                let around = Bounds::of(&bridge.points).wider(width).area();
                self.since.iter_mut().for_each(|since| since.push(around.clone()));
            }
            self.changes.joined(&told);
            self.origins = vec![None; areas.len()];
            self.areas = areas;
            // Black that grew could close a bridge again.
            self.open_all(Some(Ink::WHITE))?;
        }
        Ok(())
    }

    /// The drawing of the areas. Where they touch after all, they are made one, or taken apart.
    fn assembled(&mut self) -> Result<Drawing> {
        for touch in 0..MOST_TOUCHES {
            let loose = self.shapes.loose_of(&self.areas, &self.origins);
            let Some(at) = loose.meeting(self.control)? else { return assembled(loose, self.control) };
            let limits = [Ink::BLACK, Ink::WHITE].map(|ink| self.rules.narrowest(ink));
            let radius = 0.5 * limits[0].max(limits[1]).max(8.0 * self.tolerance()) * (1.0 + touch as f64 / 4.0);
            let place = at.map(|v| v * self.shapes.scale);
            let disc = vec![circle_polygon(place, radius, self.tolerance())];
            let ink = self.lost();
            let grown = self.widened(&[disc], 2.0 * self.tolerance())?;
            self.patch(&grown, ink == Ink::BLACK)?;
            self.open_all(Some(ink))?;
        }
        assembled(self.shapes.loose_of(&self.areas, &self.origins), self.control)
    }

    /// The regions with dots, of which those that are made anew are worth more or less than they were, so that the whole has its tone.
    fn with_dots(&mut self, old: &Drawing, regions: Drawing, canvas: f64) -> Result<Drawing> {
        let shapes = Shapes::new(&regions, self.shapes.scale, self.tolerance());
        let Drawing { width, height, units, .. } = regions;
        let ground = regions.regions.first().map_or(Ink::WHITE, |region| region.ink);
        let mut trusts = [Ink::BLACK, Ink::WHITE].iter().any(|ink| self.rules.narrowest(*ink) == 0.0);
        loop {
            let placing = Placing::new(&shapes, &old.stipples, &self.changed, self.rules, trusts);
            let (stipples, counts) = placing.placed(1.0 - self.changes.tone_before, canvas, self.control)?;
            let (curves, palette) = (regions.curves.clone(), regions.palette.clone());
            let loose = Loose { width, height, units, palette, curves, sides: Vec::new(), stipples, dots: Vec::new(), ground };
            if trusts && loose.meeting(self.control)?.is_some() {
                trusts = false;
                continue;
            }
            self.changes = Changes {
                dots_kept: counts.kept,
                dots_enlarged: counts.enlarged,
                dots_reduced: counts.reduced,
                dots_dropped: counts.dropped,
                ..self.changes
            };
            return assembled(loose, self.control);
        }
    }
}

fn assembled(loose: Loose, control: &Control) -> Result<Drawing> {
    put_together(loose, &|shape| format!("{shape:?}"), control).map_err(|error| match error {
        Error::Cancelled => error,
        other => Error::Internal(format!("what keeps the rules is no drawing: {other}")),
    })
}
