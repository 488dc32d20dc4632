//! The drawing as ink on paper: which shapes a vector file holds, layer by layer. Every vector format writes these layers.
//!
//! In the *flat* way all shapes of an ink are disjoint areas with true holes, so that nothing lies over anything else: what
//! cutters, plotters and screen printers need. In the *layered* way (the paper's) every mark is a filled disc, and what lies inside
//! it is painted over it. Both are the same picture. Shapes are closed curves and circles in pixels of the canvas.
//!
//! What is not drawn is transparent, unless a paper is asked for: it covers the page. Without one, what the picture needs is painted
//! under it on the canvas alone: white under a layered drawing, black under white ink.

use kurbo::{BezPath, Shape as _};

use crate::base::{Color, Error, Ink, Palette, Result};
use crate::drawing::{Drawing, Mark, Ring, RingPart};
use crate::files::layout::Placement;
use crate::options::{Only, words};

words! {
    /// How the picture is expressed.
    Style {
        /// Disjoint areas with true holes.
        Flat = "flat",
        /// Black painted over white, white over black, and so on.
        Layered = "layered",
    }
}

impl Style {
    /// Checks that a drawing of this palette can be expressed so.
    pub(super) fn check_palette(self, palette: &Palette) -> Result<()> {
        if self == Self::Layered && palette.overprint() {
            return Err(Error::option("style", "layered", "flat for a drawing of inks over each other"));
        }
        Ok(())
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
    /// Whose it is; none's, if it is there for the print alone, as traps and registration marks are.
    pub mark: Option<Mark>,
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

pub(super) fn capitalized(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_ascii_uppercase().to_string() + letters.as_str())
}

fn ground(rgb: [u8; 3], covers_page: bool) -> Ground {
    Ground { id: "paper", label: "Paper", rgb, covers_page }
}

/// Disjoint areas of one ink and one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in files, the same in every run: `black-regions`, `white-stipples`, or `level-3-black-regions` in the layered way;
    /// `pink-trap` and `registration-marks` of what is there for the print alone.
    pub id: String,
    /// Its name for people: `Black regions`, or `Level 3: black regions`.
    pub label: String,
    /// What it is drawn with; of a flat drawing of other inks than black and white the ink's number.
    pub ink: Ink,
    /// Its colour, sRGB.
    pub rgb: [u8; 3],
    /// What is filled. Stipples are circles without holes.
    pub areas: Vec<Area>,
}

impl Layer {
    /// The name of its ink, as its id has it.
    pub(super) fn ink_name(&self) -> &str {
        let id = self.id.strip_prefix("level-").and_then(|rest| rest.split_once('-')).map_or(self.id.as_str(), |(_, name)| name);
        id.rsplit_once('-').map_or(id, |(name, _)| name)
    }
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
    /// The layers, to be painted in this order.
    pub layers: Vec<Layer>,
    /// Whether their colours multiply where they lie over each other, as inks of an overprint do.
    pub multiply: bool,
    /// Whether what lies under a layer is printed too: where inks are laid over each other, and where one spreads under another.
    pub overprint: bool,
}

impl Layers {
    /// What an ink of this colour is painted with: one that multiplies with the page's paper is on it what it is.
    pub(super) fn painted(&self, rgb: [u8; 3], palette: &Palette) -> [u8; 3] {
        let has_paper = self.grounds.iter().any(|ground| ground.covers_page);
        if self.multiply && has_paper { palette.multiplied(rgb) } else { rgb }
    }
}

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

/// What of black and white is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drawn {
    Black,
    White,
    Both,
}

impl Drawn {
    /// What the numbers of a palette of black and white come to.
    pub(super) fn of(numbers: &[usize]) -> Self {
        match numbers {
            [1] => Self::White,
            [0, 1] => Self::Both,
            _ => Self::Black,
        }
    }
}

/// The colours that black and white parts of the picture have, sRGB: what is not drawn with ink is paper.
pub(super) fn colours(style: Style, drawn: Drawn, paper: Option<&Color>) -> [[u8; 3]; 2] {
    let paper = paper.map(Color::rgb);
    match (style, drawn) {
        (Style::Flat, Drawn::White) => [paper.unwrap_or(BLACK), WHITE],
        (Style::Flat, Drawn::Both) => [BLACK, WHITE],
        _ => [BLACK, paper.unwrap_or(WHITE)],
    }
}

impl Drawing {
    /// The layers of a vector file. `only` tells which inks a flat drawing has, `paper` the colour of the page, if it has one.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for an ink that the drawing has not, or a style that its inks cannot have.
    pub fn layers(&self, style: Style, only: &Only, paper: Option<&Color>) -> Result<Layers> {
        style.check_palette(&self.palette)?;
        let numbers = only.of(&self.palette)?;
        if !self.palette.is_black_and_white() {
            return self.layers_of_inks(style, &numbers, paper);
        }
        let drawn = Drawn::of(&numbers);
        let colours = colours(style, drawn, paper);
        // Without it there would be another picture.
        let needed = match (style, drawn) {
            (Style::Layered, _) => Some(WHITE),
            (Style::Flat, Drawn::White) => Some(BLACK),
            (Style::Flat, _) => None,
        };
        let paper = paper.map(|paper| ground(paper.rgb(), true)).or_else(|| needed.map(|rgb| ground(rgb, false)));
        let underlay = Ground { id: "underlay", label: "Underlay", rgb: BLACK, covers_page: false };
        let has_underlay = style == Style::Flat && drawn == Drawn::Both;
        let rgb = |ink: Ink| colours[ink.index()];
        let layers = match style {
            Style::Layered => self.layered(rgb),
            Style::Flat => self.flat(drawn, rgb),
        };
        let grounds = paper.into_iter().chain(has_underlay.then_some(underlay)).collect();
        Ok(Layers { grounds, layers, multiply: false, overprint: false })
    }

    /// The layers of other inks than black and white: of a flat drawing those of its plates.
    fn layers_of_inks(&self, style: Style, numbers: &[usize], paper: Option<&Color>) -> Result<Layers> {
        let needed = (style == Style::Layered).then(|| ground(self.palette.paper(), false));
        let mut layers = Vec::new();
        if style == Style::Layered {
            layers = self.layered(|label| self.palette.rgb(label));
        } else {
            for number in numbers {
                let plate = self.plate(*number)?;
                let of_plate = plate.flat(Drawn::Black, |_| plate.palette.inks()[0].rgb);
                layers.extend(of_plate.into_iter().map(|layer| Layer { ink: Ink::of_label(*number as u8), ..layer }));
            }
        }
        let grounds = paper.map(|paper| ground(paper.rgb(), true)).or(needed).into_iter().collect();
        let multiply = self.palette.overprint();
        Ok(Layers { grounds, layers, multiply, overprint: multiply })
    }

    fn layered(&self, rgb: impl Fn(Ink) -> [u8; 3]) -> Vec<Layer> {
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
                        rgb: rgb(level.ink),
                        areas: marks.iter().map(|mark| self.area(*mark, false)).collect(),
                    });
                }
            }
        }
        layers
    }

    fn flat(&self, drawn: Drawn, rgb: impl Fn(Ink) -> [u8; 3]) -> Vec<Layer> {
        let is_drawn =
            |ink: Ink| matches!((drawn, ink), (Drawn::Both, _) | (Drawn::Black, Ink::BLACK) | (Drawn::White, Ink::WHITE));
        let mut layers = Vec::new();
        for ink in [Ink::BLACK, Ink::WHITE].into_iter().filter(|ink| is_drawn(*ink)) {
            let regions = (0..self.regions.len()).filter(|i| self.regions[*i].ink == ink);
            let stipples = (0..self.stipples.len()).filter(|i| self.stipples[*i].ink == ink);
            let regions: Vec<Area> = regions.map(|i| self.area(Mark::Region(i as u32), true)).collect();
            let stipples: Vec<Area> = stipples.map(|i| self.area(Mark::Stipple(i as u32), true)).collect();
            for (kind, areas) in [("regions", regions), ("stipples", stipples)] {
                if !areas.is_empty() {
                    let name = self.palette.name(ink);
                    let capital = capitalized(&name);
                    layers.push(Layer {
                        id: format!("{name}-{kind}"),
                        label: format!("{capital} {kind}"),
                        ink,
                        rgb: rgb(ink),
                        areas,
                    });
                }
            }
        }
        layers
    }

    fn area(&self, mark: Mark, with_holes: bool) -> Area {
        match mark {
            Mark::Stipple(i) => Area { mark: Some(mark), exterior: self.circle(i), holes: Vec::new() },
            Mark::Region(i) => {
                let region = &self.regions[i as usize];
                let holes = if with_holes { region.holes.iter().map(|hole| self.outline(hole)).collect() } else { Vec::new() };
                Area { mark: Some(mark), exterior: self.outline(&region.exterior), holes }
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
