//! The palette of a drawing: its inks by name, and its paper.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::base::colour::Color;
use crate::base::error::{Error, Result};
use crate::base::ink::Ink;

/// The most inks of a drawing whose places have one ink each.
pub const MOST_INKS: usize = 15;

/// The most inks that are laid over each other.
pub const MOST_OVERPRINTED: usize = 6;

/// An ink as it is called, and its colour on the palette's paper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedInk {
    /// Of a-z, 0-9 and -, since files are named so.
    pub name: String,
    /// sRGB in 8 bits.
    pub rgb: [u8; 3],
}

impl NamedInk {
    /// An ink that is called as its colour is.
    pub fn of_colour(rgb: [u8; 3]) -> Self {
        Self { name: if rgb == [0; 3] { "black".to_owned() } else { digits(rgb) }, rgb }
    }

    /// The grey of a level of so many between black and white, called by its share of white in percent.
    pub fn of_grey(level: u32, white: u32) -> Self {
        let share = f64::from(level) / f64::from(white);
        let name = if level == 0 { "black".to_owned() } else { format!("grey-{}", (100.0 * share).round()) };
        Self { name, rgb: [(255.0 * share).round() as u8; 3] }
    }

    /// What is read as one, for messages.
    pub const ALLOWED: &str = "a colour (white, black, #rrggbb or #rgb), or name=colour with a name of a-z, 0-9 and -";

    /// Reads `#rrggbb`, which is then called so without its sign, or `name=#rrggbb`.
    ///
    /// # Errors
    /// [`Error::Option`] for anything else.
    pub fn parse(text: &str) -> Result<Self> {
        let refused = || Error::option("inks", text, Self::ALLOWED);
        let (name, colour) = text.split_once('=').map_or((None, text), |(name, colour)| (Some(name), colour));
        let rgb = colour.parse::<Color>().map_err(|_| refused())?.rgb();
        let name = match name {
            Some(name) => name.to_owned(),
            None if colour.starts_with('#') => digits(rgb),
            None => colour.to_owned(),
        };
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
        if !is_name || name == PAPER || name == WHITE && text.contains('=') {
            return Err(refused());
        }
        Ok(Self { name, rgb })
    }
}

/// As it is given: the colour alone where that is its name.
impl fmt::Display for NamedInk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let colour = digits(self.rgb);
        if self.name == colour { write!(f, "#{colour}") } else { write!(f, "{}=#{colour}", self.name) }
    }
}

/// The name of the paper where there are other inks than black.
const PAPER: &str = "paper";

/// The name of the paper of black and white.
const WHITE: &str = "white";

/// A colour in six digits.
pub(crate) fn digits([red, green, blue]: [u8; 3]) -> String {
    format!("{red:02x}{green:02x}{blue:02x}")
}

/// The inks of a drawing and its paper; by default black on white.
///
/// Every place of a *solid* drawing has one ink or is paper: labels count the inks, and the paper comes last. Of an *overprint* every
/// place has any of the inks over each other: the label of a set of inks is the number that its missing inks make, where ink k counts
/// 2^k, so that the bare paper comes last too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Palette {
    inks: Vec<NamedInk>,
    paper: [u8; 3],
    overprint: bool,
}

impl Default for Palette {
    fn default() -> Self {
        Self { inks: vec![NamedInk { name: "black".to_owned(), rgb: [0; 3] }], paper: [255; 3], overprint: false }
    }
}

impl Palette {
    /// A palette of inks on paper.
    ///
    /// # Errors
    /// [`Error::Option`] if there is no ink or there are too many, two share their name or colour, or nothing of the only one would be
    /// seen on the paper.
    pub fn new(inks: Vec<NamedInk>, paper: [u8; 3], overprint: bool) -> Result<Self> {
        let given = || inks.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
        let most = if overprint { MOST_OVERPRINTED } else { MOST_INKS };
        if inks.is_empty() || inks.len() > most {
            let way = if overprint { " with overprint" } else { "" };
            return Err(Error::option("inks", format!("{} inks", inks.len()), format!("1 to {most} inks{way}")));
        }
        for (number, ink) in inks.iter().enumerate() {
            if let Some(other) = inks[..number].iter().find(|other| other.name == ink.name || other.rgb == ink.rgb) {
                let rule = format!("inks of different names and colours, and {ink} is {other} again");
                return Err(Error::option("inks", given(), rule));
            }
        }
        if let [only] = &inks[..]
            && only.rgb == paper
        {
            let rule = "another colour than the paper: nothing of the drawing would be seen";
            return Err(Error::option("inks", only, rule));
        }
        Ok(Self { inks, paper, overprint })
    }

    /// The inks, in the order of their labels.
    pub fn inks(&self) -> &[NamedInk] {
        &self.inks
    }

    /// The names of the inks, in the order of their numbers, and that of the paper behind the last.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.inks.iter().map(|ink| ink.name.as_str()).chain([self.paper_name()])
    }

    /// The colour of the paper, sRGB in 8 bits.
    pub fn paper(&self) -> [u8; 3] {
        self.paper
    }

    /// Whether inks are laid over each other.
    pub fn overprint(&self) -> bool {
        self.overprint
    }

    /// Whether it is the default, black on white.
    pub fn is_black_and_white(&self) -> bool {
        *self == Self::default()
    }

    /// How many labels there are.
    pub fn len(&self) -> usize {
        if self.overprint { 1 << self.inks.len() } else { self.inks.len() + 1 }
    }

    /// Whether there is no label: never.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// All labels, the paper's last.
    pub fn labels(&self) -> impl Iterator<Item = Ink> + use<> {
        (0..self.len() as u8).map(Ink::of_label)
    }

    /// The label of the bare paper.
    pub fn paper_label(&self) -> Ink {
        Ink::of_label(self.len() as u8 - 1)
    }

    /// Whether a place with this label has an ink, by its number.
    pub fn has(&self, label: Ink, ink: usize) -> bool {
        if self.overprint { label.index() >> ink & 1 == 0 } else { label.index() == ink }
    }

    /// What colour an ink of this colour has to be where it is multiplied with the paper's, to be as it is on the paper; sRGB in 8 bits.
    pub(crate) fn multiplied(&self, rgb: [u8; 3]) -> [u8; 3] {
        std::array::from_fn(|channel| {
            let [ink, paper] = [rgb, self.paper].map(|rgb| u32::from(rgb[channel]));
            (255 * ink).checked_div(paper).unwrap_or(255).min(255) as u8
        })
    }

    /// The label of a place when only these inks are laid, by their numbers; one behind the last stands for the paper, and changes
    /// nothing.
    pub(crate) fn with_only(&self, label: Ink, drawn: &[usize]) -> Ink {
        if !self.overprint {
            return if drawn.contains(&label.index()) { label } else { self.paper_label() };
        }
        let missing = (0..self.inks.len()).filter(|ink| !drawn.contains(ink)).fold(0, |bits, ink| bits | 1 << ink);
        Ink::of_label(label.label() | missing)
    }

    /// What a place with this label looks like, sRGB in 8 bits. Inks over each other multiply what the light of each is to that of the
    /// paper.
    pub fn rgb(&self, label: Ink) -> [u8; 3] {
        if label == self.paper_label() {
            return self.paper;
        }
        let mut laid = (0..self.inks.len()).filter(|ink| self.has(label, *ink)).map(|ink| self.inks[ink].rgb);
        let first = laid.next().unwrap_or(self.paper);
        let paper = self.paper.map(|value| light(value).max(LEAST_LIGHT));
        let mut lit = first.map(light);
        let mut is_alone = true;
        for other in laid {
            is_alone = false;
            for channel in 0..3 {
                lit[channel] *= light(other[channel]) / paper[channel];
            }
        }
        if is_alone { first } else { lit.map(encoded) }
    }

    /// The numbers of the inks, from the one that reflects most light on.
    pub(crate) fn lightest_first(&self) -> Vec<usize> {
        let luminance = |ink: &usize| {
            let [red, green, blue] = self.inks[*ink].rgb.map(light);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let mut order: Vec<usize> = (0..self.inks.len()).collect();
        order.sort_by(|a, b| luminance(b).total_cmp(&luminance(a)));
        order
    }

    /// The palette of the plate of an ink by its number: that ink alone on the paper; one behind the last stands for the paper, whose
    /// plate is shown in its colour on black, or on white if it is black.
    pub(crate) fn of_plate(&self, ink: usize) -> Self {
        let Some(ink) = self.inks.get(ink) else {
            let name = self.paper_name().to_owned();
            let behind = if self.paper == [0; 3] { [255; 3] } else { [0; 3] };
            return Self { inks: vec![NamedInk { name, rgb: self.paper }], paper: behind, overprint: false };
        };
        Self { inks: vec![ink.clone()], paper: self.paper, overprint: false }
    }

    /// What a label is called: an ink, several as `blue+pink`, or the paper.
    pub fn name(&self, label: Ink) -> String {
        if label == self.paper_label() {
            return self.paper_name().to_owned();
        }
        let laid = (0..self.inks.len()).filter(|ink| self.has(label, *ink)).map(|ink| self.inks[ink].name.as_str());
        laid.collect::<Vec<_>>().join("+")
    }

    /// The name of the paper: white of black and white.
    pub fn paper_name(&self) -> &'static str {
        if self.is_black_and_white() { WHITE } else { PAPER }
    }
}

/// Light of paper below which there is nothing to divide by.
const LEAST_LIGHT: f64 = 1e-3;

/// The light of an sRGB-encoded value, from 0 to 1 (IEC 61966-2-1).
fn light(value: u8) -> f64 {
    let encoded = f64::from(value) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

fn encoded(light: f64) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055 };
    (value * 255.0 + 0.5) as u8
}

/// A palette as files have it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Written {
    pub(crate) inks: Vec<String>,
    pub(crate) paper: String,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) overprint: bool,
}

impl From<&Palette> for Written {
    fn from(palette: &Palette) -> Self {
        let inks = palette.inks.iter().map(ToString::to_string).collect();
        Self { inks, paper: format!("#{}", digits(palette.paper)), overprint: palette.overprint }
    }
}

impl TryFrom<Written> for Palette {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self> {
        let inks = written.inks.iter().map(|ink| NamedInk::parse(ink)).collect::<Result<_>>()?;
        Self::new(inks, written.paper.parse::<Color>()?.rgb(), written.overprint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn palette(inks: &str, overprint: bool) -> Result<Palette> {
        let inks = inks.split(',').map(NamedInk::parse).collect::<Result<_>>()?;
        Palette::new(inks, [255, 255, 255], overprint)
    }

    #[test]
    fn black_and_white_have_their_labels_and_names() {
        let palette = Palette::default();
        assert_eq!(palette.labels().collect::<Vec<_>>(), [Ink::BLACK, Ink::WHITE]);
        assert_eq!(palette.labels().map(|ink| palette.name(ink)).collect::<Vec<_>>(), ["black", "white"]);
        assert_eq!(palette.labels().map(|ink| palette.rgb(ink)).collect::<Vec<_>>(), [[0; 3], [255; 3]]);
        assert!(palette.is_black_and_white() && palette == self::palette("black", false).unwrap());
    }

    #[test]
    fn solid_labels_count_the_inks_and_then_the_paper() {
        let palette = palette("#1d1d1b,pink=#ff48b0,#0078bf", false).unwrap();
        assert_eq!(palette.labels().map(|ink| palette.name(ink)).collect::<Vec<_>>(), ["1d1d1b", "pink", "0078bf", "paper"]);
        assert!(palette.has(Ink::of_label(1), 1) && !palette.has(Ink::of_label(1), 0) && !palette.has(palette.paper_label(), 2));
        assert_eq!(palette.rgb(Ink::of_label(1)), [0xff, 0x48, 0xb0]);
        let written: Palette = Written::from(&palette).try_into().unwrap();
        assert_eq!(written, palette);
    }

    #[test]
    fn inks_over_each_other_multiply() {
        let palette = palette("y=#ffff00,c=#00ffff", true).unwrap();
        let of = |label: u8| (palette.name(Ink::of_label(label)), palette.rgb(Ink::of_label(label)));
        assert_eq!(of(0), ("y+c".to_owned(), [0, 255, 0]));
        assert_eq!(of(1), ("c".to_owned(), [0, 255, 255]));
        assert_eq!(of(2), ("y".to_owned(), [255, 255, 0]));
        assert_eq!(of(3), ("paper".to_owned(), [255; 3]));
        assert_eq!(palette.multiplied([255, 128, 0]), [255, 128, 0]);
        let inks = palette.inks().to_vec();
        let palette = Palette::new(inks, [255, 128, 0], true).unwrap();
        assert_eq!(palette.multiplied([255, 64, 9]), [255, 127, 255]);
    }

    #[test]
    fn what_is_no_palette_is_refused_in_one_sentence() {
        let told = |inks: &str, overprint| palette(inks, overprint).unwrap_err().to_string();
        assert_eq!(
            told("#f00,red=#ff0000", false),
            "inks is #ff0000,red=#ff0000, but it must be inks of different names and colours, and red=#ff0000 is #ff0000 again"
        );
        assert_eq!(
            told("#fff", false),
            "inks is #ffffff, but it must be another colour than the paper: nothing of the drawing would be seen"
        );
        let many = (0..16).map(|k| format!("#0000{k:02x}")).collect::<Vec<_>>().join(",");
        assert_eq!(told(&many, false), "inks is 16 inks, but it must be 1 to 15 inks");
        assert_eq!(told(&many[..7 * 8 + 7 - 8], true), "inks is 7 inks, but it must be 1 to 6 inks with overprint");
        for bad in ["", "Pink=#f00", "pink=", "paper=#f00", "a b=#f00", "=#f00", "mauve"] {
            assert_eq!(told(bad, false), format!("inks is {bad}, but it must be {}", NamedInk::ALLOWED));
        }
    }
}
