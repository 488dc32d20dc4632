//! The drawing as ink on paper: which shapes a vector file holds, layer by layer. Every vector format writes these layers.
//!
//! In the *flat* way all shapes of an ink are disjoint areas with true holes, so that nothing lies over anything else: what
//! cutters, plotters and screen printers need. In the *layered* way (the paper's) every mark is a filled disc, and what lies inside
//! it is painted over it. Both are the same picture. Shapes are closed curves and circles in pixels of the canvas.
//!
//! What is not drawn is transparent, unless a paper is asked for: it covers the page. Without one, what the picture needs is painted
//! under it on the canvas alone: white under a layered drawing, black under white ink.

use kurbo::{BezPath, Shape as _};

use crate::base::{Color, Ink};
use crate::drawing::{Drawing, Mark, Ring, RingPart};
use crate::files::layout::Placement;
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

/// What a mark covers: a filled area. Its holes run against its exterior, so that the even-odd and the nonzero rule fill the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Whose it is.
    pub mark: Mark,
    /// The outer boundary, of positive turn (from +x towards +y).
    pub exterior: Outline,
    /// The inner boundaries; none in the layered way.
    pub holes: Vec<Outline>,
}

impl Area {
    /// Its area in px^2, without its holes.
    pub fn area(&self) -> f64 {
        let of = |outline: &Outline| match outline {
            Outline::Path(path) => path.area().abs(),
            Outline::Circle { radius, .. } => circle_area(*radius),
        };
        of(&self.exterior) - self.holes.iter().map(of).sum::<f64>()
    }
}

/// The area of a circle.
pub(super) fn circle_area(radius: f64) -> f64 {
    std::f64::consts::PI * radius * radius
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

/// A rectangle under the layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ground {
    /// Its name in files: `paper` or `underlay`.
    pub id: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// Its colour, sRGB.
    pub rgb: [u8; 3],
    /// Whether it covers the page with its margins, or else the canvas.
    pub covers_page: bool,
}

impl Ground {
    /// Left, top, right and bottom, in pixels of the canvas.
    pub fn rectangle(&self, canvas: [usize; 2], placement: &Placement) -> [f64; 4] {
        if !self.covers_page {
            return [0.0, 0.0, canvas[0] as f64, canvas[1] as f64];
        }
        let [left, top] = placement.origin.map(|v| -v / placement.scale);
        let [width, height] = placement.page.map(|v| v / placement.scale);
        [left, top, left + width, top + height]
    }
}

/// What a vector file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// What is painted first: the paper, where there is one, and under both inks of a flat drawing the *underlay*, black, so that
    /// nothing shines through where their edges meet.
    pub grounds: Vec<Ground>,
    /// The colours of black and of white marks, sRGB: white ones have the paper's where they are paper.
    pub colours: [[u8; 3]; 2],
    /// The layers, to be painted in this order.
    pub layers: Vec<Layer>,
}

impl Layers {
    /// The colour of marks.
    pub fn colour(&self, ink: Ink) -> [u8; 3] {
        self.colours[ink.index()]
    }
}

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

/// The colours that black and white parts of the picture have, sRGB: what is not drawn with ink is paper.
pub(super) fn colours(style: Style, inks: Inks, paper: Option<&Color>) -> [[u8; 3]; 2] {
    let paper = paper.map(Color::rgb);
    match (style, inks) {
        (Style::Flat, Inks::White) => [paper.unwrap_or(BLACK), WHITE],
        (Style::Flat, Inks::Both) => [BLACK, WHITE],
        _ => [BLACK, paper.unwrap_or(WHITE)],
    }
}

impl Drawing {
    /// The layers of a vector file. `inks` tells which ink a flat drawing has, `paper` the colour of the page, if it has one.
    pub fn layers(&self, style: Style, inks: Inks, paper: Option<&Color>) -> Layers {
        let colours = colours(style, inks, paper);
        // Without it there would be another picture.
        let needed = match (style, inks) {
            (Style::Layered, _) => Some(WHITE),
            (Style::Flat, Inks::White) => Some(BLACK),
            (Style::Flat, _) => None,
        };
        let ground = |rgb, covers_page| Ground { id: "paper", label: "Paper", rgb, covers_page };
        let paper = paper.map(|paper| ground(paper.rgb(), true)).or_else(|| needed.map(|rgb| ground(rgb, false)));
        let underlay = Ground { id: "underlay", label: "Underlay", rgb: BLACK, covers_page: false };
        let has_underlay = style == Style::Flat && inks == Inks::Both;
        let layers = match style {
            Style::Layered => self.layered(),
            Style::Flat => self.flat(inks),
        };
        Layers { grounds: paper.into_iter().chain(has_underlay.then_some(underlay)).collect(), colours, layers }
    }

    fn layered(&self) -> Vec<Layer> {
        let mut layers = Vec::new();
        for level in self.levels() {
            let number = level.level;
            let (stipples, regions): (Vec<Mark>, Vec<Mark>) =
                level.marks.into_iter().partition(|mark| matches!(mark, Mark::Stipple(_)));
            for (kind, marks) in [("regions", regions), ("stipples", stipples)] {
                if !marks.is_empty() {
                    layers.push(Layer {
                        id: format!("level-{number}-{}-{kind}", self.palette.name(level.ink)),
                        label: format!("Level {number}: {} {kind}", self.palette.name(level.ink)),
                        ink: level.ink,
                        areas: marks.iter().map(|mark| self.area(*mark, false)).collect(),
                    });
                }
            }
        }
        layers
    }

    fn flat(&self, inks: Inks) -> Vec<Layer> {
        let wanted = |ink: Ink| matches!((inks, ink), (Inks::Both, _) | (Inks::Black, Ink::BLACK) | (Inks::White, Ink::WHITE));
        let mut layers = Vec::new();
        for ink in [Ink::BLACK, Ink::WHITE].into_iter().filter(|ink| wanted(*ink)) {
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
        layers
    }

    fn area(&self, mark: Mark, with_holes: bool) -> Area {
        match mark {
            Mark::Stipple(i) => Area { mark, exterior: self.circle(i), holes: Vec::new() },
            Mark::Region(i) => {
                let region = &self.regions[i as usize];
                let holes = if with_holes { region.holes.iter().map(|hole| self.outline(hole)).collect() } else { Vec::new() };
                Area { mark, exterior: self.outline(&region.exterior), holes }
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
