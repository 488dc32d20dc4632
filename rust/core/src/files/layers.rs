//! The drawing as ink on paper: which shapes a vector file holds, layer by layer. Every vector format writes these layers.
//!
//! In the *flat* way all shapes of an ink are disjoint areas with true holes, so that nothing lies over anything else: what
//! cutters, plotters and screen printers need. In the *layered* way (the paper's) every mark is a filled disc, and what lies inside
//! it is painted over it. Both are the same picture. Shapes are closed curves and circles in pixels of the canvas.

use kurbo::BezPath;

use crate::base::Ink;
use crate::drawing::{Drawing, Mark, Ring, RingPart};
use crate::options::{Inks, words};

words! {
    /// How the picture is expressed.
    Style {
        /// Disjoint areas with true holes.
        Flat = "flat",
        /// Black painted over white, white over black, and so on.
        Layered = "layered",
    }
}

/// A closed outline.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// A closed path of lines and Bezier curves; it ends with `ClosePath`.
    Path(BezPath),
    /// The outline of a stipple.
    Circle {
        /// Centre in pixels.
        x: f64,
        /// Centre in pixels.
        y: f64,
        /// Radius in pixels.
        radius: f64,
    },
}

/// A filled area. Its holes run against its exterior, so that the even-odd and the nonzero rule fill the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// The outer boundary, of positive turn (from +x towards +y).
    pub exterior: Outline,
    /// The inner boundaries; none in the layered way.
    pub holes: Vec<Outline>,
}

/// Disjoint areas of one ink and one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in files, the same in every run: `black-regions`, `white-stipples`, or `level-3-black-regions` in the layered way.
    pub id: String,
    /// Its name for people: `Black regions`, or `Level 3: black regions`.
    pub label: String,
    /// What it is drawn with.
    pub ink: Ink,
    /// What is filled. Stipples are circles without holes.
    pub areas: Vec<Area>,
}

/// What a vector file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// The colour of the paper where it has to be painted for the picture to come out: white under a layered drawing, black under
    /// white ink alone. `None` where the page is left as it is.
    pub paper: Option<Ink>,
    /// The layers, to be painted in this order.
    pub layers: Vec<Layer>,
}

impl Drawing {
    /// The layers of a vector file. `inks` tells which ink a flat drawing has.
    pub fn layers(&self, style: Style, inks: Inks) -> Layers {
        match style {
            Style::Layered => self.layered(),
            Style::Flat => self.flat(inks),
        }
    }

    fn layered(&self) -> Layers {
        let mut layers = Vec::new();
        for (number, level) in (1..).zip(self.levels()) {
            let (stipples, regions): (Vec<Mark>, Vec<Mark>) =
                level.marks.into_iter().partition(|mark| matches!(mark, Mark::Stipple(_)));
            for (kind, marks) in [("regions", regions), ("stipples", stipples)] {
                if !marks.is_empty() {
                    layers.push(Layer {
                        id: format!("level-{number}-{}-{kind}", level.ink.name()),
                        label: format!("Level {number}: {} {kind}", level.ink.name()),
                        ink: level.ink,
                        areas: marks.iter().map(|mark| self.area(*mark, false)).collect(),
                    });
                }
            }
        }
        Layers { paper: Some(Ink::White), layers }
    }

    fn flat(&self, inks: Inks) -> Layers {
        let wanted = |ink: Ink| matches!((inks, ink), (Inks::Both, _) | (Inks::Black, Ink::Black) | (Inks::White, Ink::White));
        let mut layers = Vec::new();
        for ink in [Ink::Black, Ink::White].into_iter().filter(|ink| wanted(*ink)) {
            let regions = (0..self.regions.len()).filter(|i| self.regions[*i].ink == ink);
            let stipples = (0..self.stipples.len()).filter(|i| self.stipples[*i].ink == ink);
            let regions: Vec<Area> = regions.map(|i| self.area(Mark::Region(i as u32), true)).collect();
            let stipples: Vec<Area> = stipples.map(|i| self.area(Mark::Stipple(i as u32), true)).collect();
            for (kind, areas) in [("regions", regions), ("stipples", stipples)] {
                if !areas.is_empty() {
                    let (name, capital) = (ink.name(), ink.capital_name());
                    layers.push(Layer { id: format!("{name}-{kind}"), label: format!("{capital} {kind}"), ink, areas });
                }
            }
        }
        Layers { paper: (inks == Inks::White).then_some(Ink::Black), layers }
    }

    fn area(&self, mark: Mark, with_holes: bool) -> Area {
        match mark {
            Mark::Stipple(i) => Area { exterior: self.circle(i), holes: Vec::new() },
            Mark::Region(i) => {
                let region = &self.regions[i as usize];
                let holes = if with_holes { region.holes.iter().map(|hole| self.outline(hole)).collect() } else { Vec::new() };
                Area { exterior: self.outline(&region.exterior), holes }
            }
        }
    }

    fn outline(&self, ring: &Ring) -> Outline {
        match ring.parts[..] {
            [RingPart::Stipple { index }] => self.circle(index),
            _ => Outline::Path(self.ring_path(ring)),
        }
    }

    fn circle(&self, index: u32) -> Outline {
        let stipple = &self.stipples[index as usize];
        Outline::Circle { x: stipple.x, y: stipple.y, radius: stipple.radius }
    }
}
