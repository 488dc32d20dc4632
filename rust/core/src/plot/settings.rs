//! What a pen is told: in, settings by name; out, a [`Pen`] whose every value keeps its rule.
//!
//! Every setting is declared once, in [`PEN_SETTINGS`]: the command line has a flag of each, and Python's `plot` an argument.

use crate::base::{Checked, Error, Result, in_one_line, or_nearest};
use crate::files::{Length, Unit, length};
use crate::options::{Typed, Value, words};

words! {
    /// How areas are filled.
    Fill {
        /// By lines along their outlines, one inside the other, joined where they nest.
        Contour = "contour",
        /// By their rims and parallel lines, neighbours joined.
        Hatch = "hatch",
        /// Not at all: their rims are drawn.
        Outline = "outline",
        /// They are left out, and dots alone are drawn.
        None = "none",
    }
}

words! {
    /// How dots are drawn.
    PenDots {
        /// By one press of the pen where they are hardly wider than it, else filled.
        Press = "press",
        /// By their rims, but for those that are hardly wider than the pen.
        Circle = "circle",
    }
}

words! {
    /// In which order paths are drawn.
    PenOrder {
        /// With short ways of the lifted pen.
        Short = "short",
        /// As one reads: regions and then dots, from the top down.
        None = "none",
    }
}

/// A pen, and how it draws. Lengths are as somebody gives them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen {
    /// How wide a line it draws.
    pub pen: Length,
    /// How areas are filled.
    pub fill: Fill,
    /// How dots are drawn.
    pub dots: PenDots,
    /// In which order.
    pub order: PenOrder,
    /// How much of a line the next one covers, as a part of its width; below 0 there is paper between them.
    pub overlap: f64,
    /// How far lines reach beyond the edge of an area.
    pub bleed: Length,
    /// Of hatching, in degrees from the x axis, counter-clockwise as they are seen.
    pub angle: f64,
    /// After how much line the pen is filled again.
    pub refill: Option<Length>,
}

/// A setting as it is declared.
#[derive(Debug, Clone, Copy)]
pub struct PenSetting {
    /// Its name, in snake case; the flag is `--pen-NAME`, that of the pen itself `--pen`.
    pub name: &'static str,
    /// What its value is called in the help.
    pub value_name: &'static str,
    /// What it does, in one sentence without its full stop.
    pub sentence: &'static str,
    /// What happens without it.
    pub default: &'static str,
    /// Which values it takes, as the end of a sentence that begins with "it must be".
    pub allowed: &'static str,
    /// Sets the field if the value is of its type and in its range.
    set: fn(&mut Pen, &Value) -> Option<()>,
}

/// The finest pen, in mm: about what technical pens and lasers draw. A tenth of it would be a hundred times the line.
const FINEST: f64 = 0.01;

/// Every setting.
pub const PEN_SETTINGS: &[PenSetting] = &[
    PenSetting {
        name: "pen",
        value_name: "WIDTH",
        sentence: "Draw paths for a pen of this width in place of areas",
        default: "areas",
        allowed: "a width of at least 0.01mm, with mm, cm, in, pt or px, such as 0.3mm",
        set: |pen, value| length(value).filter(|width| width.mm() >= FINEST).map(|width| pen.pen = width),
    },
    PenSetting {
        name: "fill",
        value_name: "FILL",
        sentence: "How a pen fills areas: along their outlines (contour), by parallel lines (hatch), rims alone (outline), or not (none)",
        default: "contour",
        allowed: "\"contour\", \"hatch\", \"outline\" or \"none\"",
        set: |pen, value| Fill::read(value).map(|fill| pen.fill = fill),
    },
    PenSetting {
        name: "dots",
        value_name: "DOTS",
        sentence: "How a pen draws dots: one press where they are at most 1.15 pens wide, else filled (press), or rims (circle)",
        default: "press",
        allowed: "\"press\" or \"circle\"",
        set: |pen, value| PenDots::read(value).map(|dots| pen.dots = dots),
    },
    PenSetting {
        name: "order",
        value_name: "ORDER",
        sentence: "Order of a pen's paths: with short ways between them (short), or as one reads (none)",
        default: "short",
        allowed: "\"short\" or \"none\"",
        set: |pen, value| PenOrder::read(value).map(|order| pen.order = order),
    },
    PenSetting {
        name: "overlap",
        value_name: "PART",
        sentence: "How much of a line in an area the next one covers, as a part of the pen's width; below 0 paper shows between",
        default: "0.1",
        allowed: "a number between -9 and 0.9",
        set: |pen, value| f64::read(value).filter(|part| (-9.0..=0.9).contains(part)).map(|part| pen.overlap = part),
    },
    PenSetting {
        name: "bleed",
        value_name: "LENGTH",
        sentence: "How far a pen's lines reach beyond the edges of areas, at most half its width",
        default: "0",
        allowed: Length::ALLOWED,
        set: |pen, value| length(value).map(|bleed| pen.bleed = bleed),
    },
    PenSetting {
        name: "angle",
        value_name: "DEGREES",
        sentence: "Angle of hatching, counter-clockwise from level lines",
        default: "45",
        allowed: "a number of degrees between -360 and 360",
        set: |pen, value| f64::read(value).filter(|angle| (-360.0..=360.0).contains(angle)).map(|angle| pen.angle = angle),
    },
    PenSetting {
        name: "refill",
        value_name: "LENGTH",
        sentence: "Pause to fill the pen again after so much line, such as 50m",
        default: "no pause",
        allowed: "a length above 0, with mm, cm, m or in, such as 50m",
        set: |pen, value| line(value).filter(|line| line.value > 0.0).map(|line| pen.refill = Some(line)),
    },
];

/// A length of line, which may be in metres.
fn line(value: &Value) -> Option<Length> {
    let in_metres = match value {
        Value::Word(text) => text.trim().strip_suffix('m').and_then(|number| number.trim().parse::<f64>().ok()),
        _ => None,
    };
    match in_metres {
        Some(metres) => (metres.is_finite() && metres >= 0.0).then_some(Length { value: 1000.0 * metres, unit: Unit::Mm }),
        None => length(value),
    }
}

impl Pen {
    /// A pen of this width, as somebody gives it, with everything else at its default.
    ///
    /// # Errors
    /// [`Error::Option`] if it is no width.
    pub fn of_width(width: &Value) -> Result<Self> {
        let mut pen = Self {
            pen: Length::default(),
            fill: Fill::default(),
            dots: PenDots::default(),
            order: PenOrder::default(),
            overlap: 0.1,
            bleed: Length::default(),
            angle: 45.0,
            refill: None,
        };
        pen.set("pen", width)?;
        Ok(pen)
    }

    /// Gives a setting a value.
    ///
    /// # Errors
    /// [`Error::Option`] if the value is not one of the setting's, [`Error::Input`] if there is no such setting.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<()> {
        let setting = PEN_SETTINGS.iter().find(|setting| setting.name == name);
        let setting = setting.ok_or_else(|| {
            let sentence = format!("there is no setting {} of a pen", in_one_line(name));
            Error::Input(or_nearest(&sentence, name, PEN_SETTINGS.iter().map(|setting| setting.name), str::to_owned))
        })?;
        let told = || if name == "pen" { "pen".to_owned() } else { format!("pen_{name}") };
        (setting.set)(self, value).ok_or_else(|| Error::option(told(), value, value.or_nearest(setting.allowed, setting.words())))
    }

    /// Checks that the settings go together.
    ///
    /// # Errors
    /// [`Error::Option`] for the first that does not.
    pub fn check(self) -> Result<Checked<Self>> {
        if self.bleed.mm() > 0.5 * self.pen.mm() {
            return Err(Error::option("pen_bleed", self.bleed, format!("at most half the pen's width, which is {}", self.pen)));
        }
        Ok(Checked::of(self))
    }
}

impl PenSetting {
    /// The words that it takes: they stand in quotes where its declaration says what is allowed.
    pub fn words(&self) -> impl Iterator<Item = &'static str> {
        self.allowed.split('"').skip(1).step_by(2)
    }

    /// What it is called among other settings: in a flag, and in messages.
    pub fn full_name(&self) -> String {
        if self.name == "pen" { self.name.to_owned() } else { format!("pen_{}", self.name) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(text: &str) -> Value {
        Value::Word(text.to_owned())
    }

    #[test]
    fn settings_are_set_by_name() {
        let mut pen = Pen::of_width(&word("0.3mm")).unwrap();
        for (name, value) in [
            ("pen", word("0.5mm")),
            ("fill", word("hatch")),
            ("dots", word("circle")),
            ("order", word("none")),
            ("overlap", Value::Number(0.25)),
            ("bleed", word("0.1mm")),
            ("angle", Value::Whole(30)),
            ("refill", word("50m")),
        ] {
            let before = pen;
            pen.set(name, &value).unwrap();
            assert_ne!(pen, before, "{name}");
        }
        assert!((pen.refill.unwrap().mm() - 50_000.0).abs() < 1e-6);
        assert_eq!((pen.overlap, pen.angle), (0.25, 30.0));
        pen.check().unwrap();
    }

    #[test]
    fn what_is_wrong_is_told_by_its_name() {
        let told = |name: &str, value: Value| {
            let pen = Pen::of_width(&word("0.3mm"));
            pen.and_then(|mut pen| pen.set(name, &value).and_then(|()| pen.check())).unwrap_err().to_string()
        };
        let rule = "but it must be a width of at least 0.01mm, with mm, cm, in, pt or px, such as 0.3mm";
        for wrong in [Value::Whole(0), word("0mm"), word("0.009mm"), word("-1mm"), word("thick"), Value::Number(f64::NAN)] {
            assert_eq!(told("pen", wrong.clone()), format!("pen is {wrong}, {rule}"));
        }
        assert_eq!(
            told("fill", word("hatsch")),
            "pen_fill is \"hatsch\", but it must be \"contour\", \"hatch\", \"outline\" or \"none\"; did you mean \"hatch\"?"
        );
        assert_eq!(told("overlap", Value::Number(1.0)), "pen_overlap is 1, but it must be a number between -9 and 0.9");
        assert_eq!(told("bleed", word("0.2mm")), "pen_bleed is 0.2mm, but it must be at most half the pen's width, which is 0.3mm");
        assert!(told("refill", word("0m")).starts_with("pen_refill is \"0m\", but it must be a length above 0"));
        assert_eq!(told("filll", word("hatch")), "there is no setting filll of a pen; did you mean fill?");
    }
}
