//! Plates: what one ink of a drawing covers, as a drawing of two by itself. In: a drawing of several inks; out: for one of them, the
//! drawing whose black is where that ink is and whose white is all the rest.
//!
//! Boundaries between two places that both have the ink, or both have not, are gone; those that are left go on through junctions. So
//! everything that is done with black and white, as rules, plots and cutting, can be done with every plate.

use std::collections::{HashMap, HashSet};

use kurbo::{BezPath, PathEl};

use crate::base::{Error, Frame, Ink, Palette, Result, is_closed};
use crate::drawing::assembly::{Surroundings, assemble, bits, ends_of};
use crate::drawing::data::Drawing;
use crate::drawing::joined::Joined;
use crate::outlines::Parts;

impl Drawing {
    /// The plate of an ink, by its number in the palette; one behind the last stands for the bare paper. Its palette is that ink alone.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no such ink.
    pub fn plate(&self, ink: usize) -> Result<Self> {
        let inks = self.palette.inks();
        if ink > inks.len() {
            return Err(Error::Input(format!("the drawing has {} inks, but ink {ink} was asked for", inks.len())));
        }
        if self.palette.is_black_and_white() && ink == 0 {
            return Ok(self.clone());
        }
        let has = |label: Ink| if ink == inks.len() { label == self.palette.paper_label() } else { self.palette.has(label, ink) };
        let palette = self.palette.of_plate(ink);
        let provenance = self.provenance.clone();
        Ok(Self { provenance, ..assemble(self.parts_of_plate(palette, has)?)? })
    }

    fn parts_of_plate(&self, palette: Palette, has: impl Fn(Ink) -> bool) -> Result<Parts> {
        // Regions, then dots, as components of the drawing; those of the plate are sets of them.
        let regions = self.regions.len();
        let inks: Vec<Ink> = self.regions.iter().map(|region| region.ink).chain(self.stipples.iter().map(|dot| dot.ink)).collect();
        let Surroundings { beside, around, on_frame } = Surroundings::of(self);
        let within = || Error::Internal("a stipple lies in no region".to_owned());
        let around = around.into_iter().map(|region| region.ok_or_else(within)).collect::<Result<Vec<u32>>>()?;
        let is_in: Vec<bool> = inks.iter().map(|label| has(*label)).collect();
        let mut joined = Joined::new(inks.len());
        let is_kept = |[left, right]: [u32; 2]| is_in[left as usize] != is_in[right as usize];
        for [left, right] in beside.iter().copied().filter(|sides| !is_kept(*sides)) {
            joined.join(left as usize, right as usize);
        }
        for (dot, around) in (regions..).zip(&around) {
            if is_in[dot] == is_in[*around as usize] {
                joined.join(dot, *around as usize);
            }
        }
        let (ids, firsts) = joined.numbered();
        let labels = firsts.into_iter().map(|first| if is_in[first] { Ink::BLACK } else { Ink::WHITE }).collect();
        let sides = |[left, right]: [u32; 2]| [ids[left as usize], ids[right as usize]];
        let kept = (0u32..).zip(&self.curves).zip(&beside).filter(|(_, sides)| is_kept(**sides));
        let oriented = kept.map(|((number, _), [left, right])| {
            let reversed = !is_in[*left as usize];
            (number, reversed, sides(if reversed { [*right, *left] } else { [*left, *right] }))
        });
        let curves = self.joined_up(&oriented.collect::<Vec<_>>());
        let kept = self.stipples.iter().zip(regions as u32..).zip(&around);
        let stipples =
            kept.filter(|((_, dot), around)| is_in[*dot as usize] != is_in[**around as usize]).map(|((stipple, dot), around)| {
                let ink = if is_in[dot as usize] { Ink::BLACK } else { Ink::WHITE };
                (crate::outlines::Stipple { ink, level: 0, ..*stipple }, sides([dot, *around]))
            });
        let Self { width, height, units, .. } = *self;
        let on_frame = ids[on_frame as usize];
        Ok(Parts { width, height, units, palette, curves, stipples: stipples.collect(), inks: labels, on_frame })
    }

    /// Curves, each with whether it is reversed and what is beside it then, joined where one ends in the junction in which another
    /// begins.
    fn joined_up(&self, curves: &[(u32, bool, [u32; 2])]) -> Vec<(BezPath, [u32; 2])> {
        let frame = Frame { width: self.width as f64, height: self.height as f64 };
        let ends = |number: u32, reversed: bool| {
            let [begin, end] = ends_of(&self.curves[number as usize]);
            if reversed { [end, begin] } else { [begin, end] }
        };
        let is_open = |number: u32| !is_closed(&self.curves[number as usize]);
        // Two kept curves meet in a junction at most: one ends, the other begins.
        let mut beginning = HashMap::new();
        let mut ending = HashSet::new();
        for (k, (number, reversed, _)) in curves.iter().enumerate().filter(|(_, (number, ..))| is_open(*number)) {
            let [begin, end] = ends(*number, *reversed);
            if frame.holds(begin) {
                beginning.insert(bits(begin), k);
            }
            if frame.holds(end) {
                ending.insert(bits(end));
            }
        }
        let mut taken = vec![false; curves.len()];
        let mut joined = Vec::new();
        // First those that begin on the frame, then those that go around.
        for from_frame in [true, false] {
            for first in 0..curves.len() {
                let (number, reversed, sides) = curves[first];
                let begins_in_junction = is_open(number) && ending.contains(&bits(ends(number, reversed)[0]));
                if taken[first] || from_frame && begins_in_junction {
                    continue;
                }
                let mut path = BezPath::new();
                let mut next = Some(first);
                while let Some(k) = next.filter(|k| !std::mem::replace(&mut taken[*k], true)) {
                    let (number, reversed, _) = curves[k];
                    let curve = &self.curves[number as usize];
                    let of_piece = if reversed { curve.reverse_subpaths() } else { curve.clone() };
                    let skipped = usize::from(!path.elements().is_empty());
                    of_piece.elements()[skipped..].iter().for_each(|element| path.push(*element));
                    next = is_open(number).then(|| beginning.get(&bits(ends(number, reversed)[1])).copied()).flatten();
                }
                if next.is_some() && !path.elements().last().is_some_and(|last| *last == PathEl::ClosePath) {
                    path.close_path();
                }
                joined.push((path, sides));
            }
        }
        joined
    }
}

/// Drawings of several inks by chance, for tests of this module and others.
#[cfg(test)]
pub(crate) mod samples {
    use super::*;
    use crate::base::{Control, NamedInk, noise};
    use crate::drawing::Provenance;
    use crate::graph::{components, triangulate};
    use crate::options::Options;
    use crate::outlines::{Nodes, Shaping, outline};

    /// `count` nodes on 60 x 40 pixels in patches of `inks` inks and paper, with single nodes of other inks among them.
    pub(crate) fn patches(inks: usize, count: usize, seed: u64, overprint: bool) -> Drawing {
        patches_shaped(inks, count, seed, overprint, &Options { tolerance: 0.3, ..Options::default() })
    }

    /// The same, shaped as options say.
    pub(crate) fn patches_shaped(inks: usize, count: usize, seed: u64, overprint: bool, options: &Options) -> Drawing {
        let random = |k: usize| 0.5 + 0.499 * f64::from(noise(seed.wrapping_mul(1 << 20) + k as u64));
        let sites: Vec<[f64; 2]> = (0..count).map(|k| [60.0 * random(2 * k), 40.0 * random(2 * k + 1)]).collect();
        let triangulation = triangulate(sites, 60, 40, &Control::new()).unwrap();
        let inks =
            (0..inks).map(|k| NamedInk { name: format!("ink-{k}"), rgb: [(13 * k) as u8, 30, (200 - 9 * k) as u8] }).collect();
        let palette = Palette::new(inks, [250, 250, 240], overprint).unwrap();
        let labels: Vec<u8> = (triangulation.graph.sites.iter().enumerate())
            .map(|(node, [x, y])| {
                let wave = libm::sin(0.25 * x + random(7)) * libm::cos(0.3 * y) + 0.15 * random(90_000 + node);
                let patch = ((0.5 + 0.45 * wave) * palette.len() as f64) as usize;
                let is_speck = random(50_000 + node) > 0.93;
                (if is_speck { (7919 * node) % palette.len() } else { patch.min(palette.len() - 1) }) as u8
            })
            .collect();
        let components = components(&triangulation.graph, &labels);
        let areas = vec![2400.0 / count as f64; count];
        let nodes = Nodes { labels: &labels, places: &triangulation.graph.sites, areas: &areas, tones: None, bands: None };
        let outlines = outline(&triangulation, nodes, &components, (60, 40), Shaping::of(options), &Control::new()).unwrap();
        let provenance = Provenance { version: "0.1.0".into(), importance: "none".into(), ..Provenance::default() };
        Drawing { provenance, ..assemble(Parts { palette, ..outlines.parts }).unwrap() }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::{patches, patches_shaped};
    use super::*;
    use crate::base::{Control, signed_area};
    use crate::drawing::{Known, Loose, put_together};
    use crate::options::{Edge, Options};

    fn area_of_dot(drawing: &Drawing, dot: usize) -> f64 {
        signed_area(&drawing.stipple_outline(dot, drawing.flattening_tolerance()))
    }

    /// Area of every label.
    fn areas(drawing: &Drawing) -> Vec<f64> {
        let mut areas = vec![0.0; drawing.palette.len()];
        for (number, region) in drawing.regions.iter().enumerate() {
            let area = drawing.region_area(number);
            assert!(area > 0.0, "region {number} has {area} px^2");
            areas[region.ink.index()] += area;
        }
        for (number, dot) in drawing.stipples.iter().enumerate() {
            areas[dot.ink.index()] += area_of_dot(drawing, number);
        }
        areas
    }

    #[test]
    fn areas_of_all_inks_and_the_paper_add_up_to_the_canvas() {
        for (inks, count, seed) in [(2, 300, 1), (3, 1200, 2), (6, 1200, 3), (15, 2500, 4), (4, 40, 5)] {
            let drawing = patches(inks, count, seed, false);
            let sum: f64 = areas(&drawing).iter().sum();
            assert!((sum - 2400.0).abs() < 1e-6, "{inks} inks: {sum}");
            assert!(drawing.curves.iter().any(|curve| !is_closed(curve)));
        }
    }

    #[test]
    fn curves_of_many_inks_touch_in_junctions_alone_and_tell_the_drawing() {
        for (inks, count, seed) in [(2, 300, 1), (3, 1200, 2), (6, 1200, 3), (15, 2500, 4), (5, 900, 6), (8, 1500, 7)] {
            assert_told_by_curves(&patches(inks, count, seed, false));
        }
    }

    /// Puts a drawing together again from its curves and dots, which are checked to touch in junctions alone.
    fn assert_told_by_curves(drawing: &Drawing) {
        let Drawing { width, height, units, palette, curves, stipples, .. } = drawing.clone();
        let stipples = stipples.into_iter().map(|dot| crate::outlines::Stipple { level: 0, ..dot }).collect();
        let sides = drawing.sides().into_iter().map(|sides| sides.map(Known::of)).collect();
        let inks = palette.inks().len();
        let loose = Loose { width, height, units, palette, curves, sides, stipples, dots: Vec::new(), ground: Ink::BLACK };
        let again = put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap();
        let again = Drawing { provenance: drawing.provenance.clone(), ..again };
        assert!(again == *drawing, "{inks} inks are other ones");
    }

    #[test]
    fn edges_of_many_inks_wobble_and_still_touch_in_junctions_alone() {
        for edge in [Edge::Smooth, Edge::Inked, Edge::Torn] {
            for (inks, count, overprint) in [(3, 1200, false), (6, 900, false), (15, 2500, false), (4, 60, false), (3, 1500, true)]
            {
                for (seed, wobble) in [(1, 0.2), (2, 1.0), (10, 1.0), (14, 1.0), (20, 0.2), (24, 1.0)] {
                    let options = Options { wobble, edge, seed, tolerance: 0.3, ..Options::default() };
                    let drawing = patches_shaped(inks, count, seed, overprint, &options);
                    assert!(drawing.curves != patches(inks, count, seed, overprint).curves);
                    assert!((areas(&drawing).iter().sum::<f64>() - 2400.0).abs() < 1e-6);
                    assert_told_by_curves(&drawing);
                }
            }
        }
    }

    #[test]
    fn plates_have_the_areas_of_their_inks() {
        for (inks, seed, overprint) in [(3, 1, false), (6, 2, false), (3, 3, true), (4, 4, true)] {
            let drawing = patches(inks, 1500, seed, overprint);
            let areas = areas(&drawing);
            let mut solid = 0.0;
            for ink in 0..=inks {
                let plate = drawing.plate(ink).unwrap();
                assert_eq!(plate.palette.len(), 2);
                let has = |label: &Ink| {
                    if ink == inks { *label == drawing.palette.paper_label() } else { drawing.palette.has(*label, ink) }
                };
                let expected: f64 = drawing.palette.labels().filter(has).map(|label| areas[label.index()]).sum();
                let found = self::areas(&plate);
                assert!((found[0] - expected).abs() < 1e-6, "plate {ink} of {inks}: {} of {expected}", found[0]);
                assert!((found[0] + found[1] - 2400.0).abs() < 1e-6);
                solid += found[0];
            }
            assert!(overprint || (solid - 2400.0).abs() < 1e-6);
        }
        assert!(patches(3, 100, 1, false).plate(4).is_err());
    }
}
