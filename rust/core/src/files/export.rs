//! How a drawing is written: in, settings by name; out, an [`Export`] whose every value keeps its rule.
//!
//! Every setting is declared once, in [`SETTINGS`]: the command line has a flag of each, and so has Python's `save` an argument.
//! Which of them a format takes is for the table of formats to say.

use crate::base::{Checked, Color, Error, Ink, Palette, Result, in_one_line, or_nearest};
use crate::files::layers::{Drawn, colours};
use crate::files::registration::LEAST_MARGIN;
use crate::files::{Layout, Length, Page, Style, Unit};
use crate::options::{Audience, Only, Typed, Value, words};

words! {
    /// What the elements of an SVG are.
    Elements {
        /// A compound path for all marks of a layer, in pieces where it would be too long.
        Layers = "layers",
        /// An element for every mark: a circle for a dot, a path with its holes for a region.
        Marks = "marks",
    }
}

words! {
    /// What the dots of an SVG are.
    Dots {
        /// Circles, exactly as they are drawn.
        Circles = "circles",
        /// Short strokes with round caps, a path for all dots of a radius; radii are rounded to few.
        Strokes = "strokes",
    }
}

words! {
    /// What the curves of a DXF are.
    Curves {
        /// Polylines close to them, which every program takes.
        Polylines = "polylines",
        /// Splines, exactly as they are drawn.
        Splines = "splines",
    }
}

/// How a drawing is written. What a format has no use for is left alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Export {
    /// How vector formats express the picture.
    pub style: Style,
    /// The inks that a flat drawing is written with.
    pub only: Only,
    /// What covers the whole page, margins included; by default the paper that the drawing was made with, if it was given one for its
    /// inks, or nothing, and the page is transparent.
    pub paper: Option<Color>,
    /// Whether the drawing's own paper is left out too.
    pub no_paper: bool,
    /// What the elements of an SVG are.
    pub elements: Elements,
    /// What the dots of an SVG are.
    pub dots: Dots,
    /// What the curves of a DXF are.
    pub curves: Curves,
    /// The size on paper, and the resolution of pixels.
    pub layout: Layout,
    /// Whether a PNG holds black and white alone, one bit a pixel, instead of antialiased grey.
    pub one_bit: bool,
    /// How far lighter inks spread under darker ones, at most 5 mm.
    pub trap: Option<Length>,
    /// Whether there are registration marks around the drawing.
    pub registration_marks: bool,
}

/// The widest trap in mm: ten times what hand printing needs.
const WIDEST_TRAP: f64 = 5.0;

/// A setting as it is declared.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Its name, in snake case.
    pub name: &'static str,
    /// What its value is called in the help; empty for a flag by itself.
    pub value_name: &'static str,
    /// What it does, in one sentence without its full stop.
    pub sentence: &'static str,
    /// What happens without it.
    pub default: &'static str,
    /// Which values it takes, as the end of a sentence that begins with "it must be".
    pub allowed: &'static str,
    /// Whether it is about the size on paper.
    pub is_size: bool,
    /// Who turns it.
    pub audience: Audience,
    /// Sets the field if the value is of its type.
    set: fn(&mut Export, &Value) -> Option<()>,
    /// For what a format without it cannot give, and so refuses instead of leaving it alone: the value, where it is given.
    pub(crate) refused: Option<fn(&Export) -> Option<String>>,
}

/// Every setting.
pub const SETTINGS: &[Setting] = &[
    Setting {
        name: "style",
        value_name: "STYLE",
        sentence: "Disjoint areas with holes (flat), or black over white over black (layered)",
        default: "flat",
        allowed: "\"flat\" or \"layered\"",
        is_size: false,
        audience: Audience::Everyday,
        set: |export, value| Style::read(value).map(|style| export.style = style),
        refused: None,
    },
    Setting {
        name: "only",
        value_name: "INK[,INK]",
        sentence: "Inks to write, by name; white or paper is what they leave",
        default: "all inks, or as the preset suggests",
        allowed: "names of inks of the drawing, with commas between them",
        is_size: false,
        audience: Audience::Everyday,
        set: |export, value| Only::read(value).map(|only| export.only = only),
        refused: None,
    },
    Setting {
        name: "paper",
        value_name: "COLOR",
        sentence: "Colour of the whole page, margins included; white marks that are paper have it too",
        default: "the drawing's, if its inks were given one; else what is not drawn is transparent, in a PNG white",
        allowed: "\"none\", or a colour: white, black, #rrggbb or #rgb",
        is_size: false,
        audience: Audience::Further,
        set: |export, value| {
            let is_none = matches!(value, Value::Word(word) if word == "none");
            let paper = if is_none { None } else { Some(Color::read(value)?) };
            (export.paper, export.no_paper) = (paper, is_none);
            Some(())
        },
        refused: None,
    },
    Setting {
        name: "elements",
        value_name: "ELEMENTS",
        sentence: "Elements of an SVG: one path a layer (layers), or one element a mark (marks), to be picked by itself",
        default: "layers",
        allowed: "\"layers\" or \"marks\"",
        is_size: false,
        audience: Audience::Further,
        set: |export, value| Elements::read(value).map(|elements| export.elements = elements),
        refused: None,
    },
    Setting {
        name: "dots",
        value_name: "DOTS",
        sentence: "Dots of an SVG: circles, or short strokes with round caps for small files (strokes)",
        default: "circles",
        allowed: "\"circles\" or \"strokes\"",
        is_size: false,
        audience: Audience::Further,
        set: |export, value| Dots::read(value).map(|dots| export.dots = dots),
        refused: None,
    },
    Setting {
        name: "curves",
        value_name: "CURVES",
        sentence: "Curves of a DXF: polylines, or splines, which cutters and older programs may not take",
        default: "polylines",
        allowed: "\"polylines\" or \"splines\"",
        is_size: false,
        audience: Audience::Further,
        set: |export, value| Curves::read(value).map(|curves| export.curves = curves),
        refused: None,
    },
    Setting {
        name: "one_bit",
        value_name: "",
        sentence: "Pixels of one bit, without grey edges",
        default: "grey edges",
        allowed: "True or False",
        is_size: false,
        audience: Audience::Everyday,
        set: |export, value| bool::read(value).map(|one_bit| export.one_bit = one_bit),
        refused: Some(|export| export.one_bit.then(|| "True".to_owned())),
    },
    Setting {
        name: "trap",
        value_name: "LENGTH",
        sentence: "How far the lighter of two inks spreads under the darker one beside it",
        default: "not at all",
        allowed: Length::ALLOWED,
        is_size: false,
        audience: Audience::Further,
        set: |export, value| length(value).map(|trap| export.trap = Some(trap)),
        refused: None,
    },
    Setting {
        name: "registration_marks",
        value_name: "",
        sentence: "Registration marks around the drawing, in margins of at least 10 mm",
        default: "none",
        allowed: "True or False",
        is_size: false,
        audience: Audience::Further,
        set: |export, value| bool::read(value).map(|has_marks| export.registration_marks = has_marks),
        refused: None,
    },
    Setting {
        name: "width",
        value_name: "LENGTH",
        sentence: "Width without margins, in mm, cm, in, pt or px",
        default: "what fits the page, or a px for a pixel",
        allowed: Length::ALLOWED,
        is_size: true,
        audience: Audience::Everyday,
        set: |export, value| length(value).map(|width| export.layout.width = Some(width)),
        refused: None,
    },
    Setting {
        name: "margin",
        value_name: "LENGTH",
        sentence: "Empty paper on all four sides, at least",
        default: "0",
        allowed: Length::ALLOWED,
        is_size: true,
        audience: Audience::Everyday,
        set: |export, value| length(value).map(|margin| export.layout.margin = margin),
        refused: None,
    },
    Setting {
        name: "page",
        value_name: "PAGE",
        sentence: "Sheet: A3 to A6, letter, legal, tabloid, or a size such as 300x200mm",
        default: "none",
        allowed: Page::ALLOWED,
        is_size: true,
        audience: Audience::Everyday,
        set: |export, value| {
            let Value::Word(text) = value else { return None };
            text.parse().ok().map(|page: Page| export.layout.page = Some(page))
        },
        refused: None,
    },
    Setting {
        name: "dpi",
        value_name: "NUMBER",
        sentence: "Pixels per inch",
        default: "300 on paper",
        allowed: "a number between 1 and 10000 pixels per inch",
        is_size: true,
        audience: Audience::Everyday,
        set: |export, value| f64::read(value).map(|dpi| export.layout.dpi = Some(dpi)),
        refused: Some(|export| export.layout.dpi.map(|dpi| dpi.to_string())),
    },
];

/// A length as somebody gives it: a number of px, or text with a unit.
pub(crate) fn length(value: &Value) -> Option<Length> {
    match value {
        Value::Word(text) => text.parse().ok(),
        Value::Whole(number) => number.to_string().parse().ok(),
        Value::Number(number) => number.to_string().parse().ok(),
        _ => None,
    }
}

/// A length under a name of its own, such as the least radius of a dot.
///
/// # Errors
/// [`Error::Option`] of this name if the value is none.
pub fn named_length(name: &str, value: &Value) -> Result<Length> {
    length(value).ok_or_else(|| Error::option(name, value, Length::ALLOWED))
}

impl Setting {
    /// The words that it takes: they stand in quotes where its declaration says what is allowed.
    pub fn words(&self) -> impl Iterator<Item = &'static str> {
        self.allowed.split('"').skip(1).step_by(2)
    }
}

impl Export {
    /// Gives a setting a value. Its type is checked here, its range by [`Export::check`].
    ///
    /// # Errors
    /// [`Error::Option`] if the value is of another type than the setting, [`Error::Input`] if there is no such setting.
    pub fn set(&mut self, name: &str, value: &Value) -> Result<()> {
        let setting = SETTINGS.iter().find(|setting| setting.name == name);
        let setting = setting.ok_or_else(|| {
            let sentence = format!("there is no setting {} of how a drawing is written", in_one_line(name));
            Error::Input(or_nearest(&sentence, name, SETTINGS.iter().map(|setting| setting.name), str::to_owned))
        })?;
        (setting.set)(self, value).ok_or_else(|| Error::option(name, value, value.or_nearest(setting.allowed, setting.words())))
    }

    /// Checks every value, and that they go together.
    ///
    /// # Errors
    /// [`Error::Option`] for the first that breaks its rule.
    pub fn check(mut self) -> Result<Checked<Self>> {
        if self.style == Style::Layered && !self.only.is_all() {
            return Err(Error::option("only", &self.only, "left out when style is layered: a layered drawing has all inks"));
        }
        if self.elements == Elements::Marks && self.dots == Dots::Strokes {
            let rule = "left out when elements is marks: a stroke for each dot is no shorter than its circle";
            return Err(Error::option("dots", "strokes", rule));
        }
        self.layout.validate()?;
        if let Some(trap) = self.trap {
            if !(trap.value > 0.0 && trap.mm() <= WIDEST_TRAP) {
                return Err(Error::option("trap", trap, format!("above 0 and at most {WIDEST_TRAP}mm")));
            }
            if self.style == Style::Layered {
                return Err(Error::option("trap", trap, "left out when style is layered: inks lie over each other there anyway"));
            }
        }
        let least = Length { value: LEAST_MARGIN, unit: Unit::Mm };
        if self.registration_marks && self.layout.margin.points() < least.points() {
            self.layout.margin = least;
        }
        Ok(Checked::of(self))
    }

    /// The same for an ink alone, without a paper.
    pub(super) fn of_plate(&self, ink: &str) -> Self {
        // Formats without a style pass over it.
        Self { only: Only::named(&[ink]), style: Style::Flat, paper: None, no_paper: true, ..self.clone() }
    }

    /// Checks that a drawing of this palette can be written so.
    ///
    /// # Errors
    /// [`Error::Option`] for an ink that is none of the palette's, for a style that its inks cannot have, and for a paper on which nothing
    /// would show.
    pub(crate) fn check_palette(&self, palette: &Palette) -> Result<()> {
        let drawn = self.only.of(palette)?;
        if let Some(trap) = self.trap {
            if palette.overprint() {
                return Err(Error::option(
                    "trap",
                    trap,
                    "left out for inks over each other: what lies under them is printed anyway",
                ));
            }
            if palette.inks().len() < 2 {
                return Err(Error::option("trap", trap, "left out for a drawing of one ink: no two inks touch in it"));
            }
        }
        if !palette.is_black_and_white() {
            self.style.check_palette(palette)?;
            if self.one_bit && drawn.len() > 1 {
                let rule = "left out where a file has several inks: only pink, or {ink} in its name, writes the film of one";
                return Err(Error::option("one_bit", "True", rule));
            }
            return Ok(());
        }
        if let Some(paper) = &self.paper {
            let [black, white] = colours(self.style, Drawn::of(&drawn), Some(paper));
            if black == white {
                let ink = if drawn == [1] { Ink::WHITE } else { Ink::BLACK };
                let rule = format!("another colour than {0}: nothing drawn in {0} ink would show on it", ink.name());
                return Err(Error::option("paper", paper, rule));
            }
            if self.one_bit && ![black, white].contains(&paper.rgb()) {
                let rule = "left out with both inks on coloured paper: black, white and the paper's are three colours";
                return Err(Error::option("one_bit", "True", rule));
            }
        }
        Ok(())
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
        let mut export = Export::default();
        for (name, value) in [
            ("style", word("layered")),
            ("only", word("black,white")),
            ("paper", word("#1aF")),
            ("elements", word("marks")),
            ("dots", word("strokes")),
            ("curves", word("splines")),
            ("one_bit", Value::Switch(true)),
            ("trap", word("0.2mm")),
            ("registration_marks", Value::Switch(true)),
            ("width", word("20cm")),
            ("margin", Value::Whole(5)),
            ("page", word("letter")),
            ("dpi", Value::Number(600.0)),
        ] {
            let before = export.clone();
            export.set(name, &value).unwrap();
            assert_ne!(export, before, "{name}");
        }
        let length = |text: &str| text.parse::<Length>().unwrap();
        let layout =
            Layout { width: Some(length("20cm")), margin: length("5px"), page: Some("letter".parse().unwrap()), dpi: Some(600.0) };
        let paper = Some("#1aF".parse().unwrap());
        let (elements, dots, curves) = (Elements::Marks, Dots::Strokes, Curves::Splines);
        assert_eq!(
            export,
            Export {
                style: Style::Layered,
                only: Only::named(&["black", "white"]),
                paper,
                elements,
                dots,
                curves,
                layout,
                one_bit: true,
                trap: Some(length("0.2mm")),
                registration_marks: true,
                no_paper: false
            }
        );
        export.set("paper", &word("none")).unwrap();
        assert_eq!((&export.paper, export.no_paper), (&None, true));
        Export { elements: Elements::Layers, only: Only::default(), trap: None, ..export }.check().unwrap();
    }

    #[test]
    fn what_is_wrong_is_told_by_its_name() {
        let message = |name: &str, value: &Value| Export::default().set(name, value).unwrap_err().to_string();
        assert_eq!(
            message("style", &word("flatt")),
            "style is \"flatt\", but it must be \"flat\" or \"layered\"; did you mean \"flat\"?"
        );
        assert_eq!(message("one_bit", &Value::Whole(1)), "one_bit is 1, but it must be True or False");
        assert_eq!(message("dpi", &word("fine")), "dpi is \"fine\", but it must be a number between 1 and 10000 pixels per inch");
        let rule = "but it must be \"none\", or a colour: white, black, #rrggbb or #rgb";
        assert_eq!(message("paper", &word("red")), format!("paper is \"red\", {rule}"));
        assert_eq!(message("paper", &Value::Whole(0)), format!("paper is 0, {rule}"));
        assert_eq!(message("elements", &word("dots")), "elements is \"dots\", but it must be \"layers\" or \"marks\"");
        assert_eq!(message("dots", &word("dot")), "dots is \"dot\", but it must be \"circles\" or \"strokes\"");
        for wrong in [word("5 parsecs"), word(""), Value::Number(-1.0), Value::Number(f64::NAN), Value::Switch(true)] {
            let told = message("width", &wrong);
            assert!(told.starts_with(&format!("width is {wrong}, but it must be a number, at least 0, with mm")), "{told}");
        }
        assert!(message("page", &Value::Whole(4)).starts_with("page is 4, but it must be A3, A4"));
        assert_eq!(message("stlye", &word("flat")), "there is no setting stlye of how a drawing is written; did you mean style?");
        assert!(named_length("min_dot", &word("x")).unwrap_err().to_string().starts_with("min_dot is \"x\", but it must be"));
    }

    #[test]
    fn what_would_not_show_or_does_not_go_together_is_refused() {
        let told = |export: Export| {
            let checked = export.check().and_then(|export| export.check_palette(&Palette::default()));
            checked.err().map(|error| error.to_string())
        };
        let on = |paper: &str| Export { paper: Some(paper.parse().unwrap()), ..Export::default() };
        let rule = "but it must be another colour than black: nothing drawn in black ink would show on it";
        assert_eq!(told(on("#000")), Some(format!("paper is #000, {rule}")));
        assert_eq!(told(Export { style: Style::Layered, ..on("black") }), Some(format!("paper is black, {rule}")));
        let rule = "but it must be another colour than white: nothing drawn in white ink would show on it";
        assert_eq!(told(Export { only: Only::named(&["white"]), ..on("#ffffff") }), Some(format!("paper is #ffffff, {rule}")));
        let both = |paper: &str| Export { only: Only::named(&["black", "white"]), one_bit: true, ..on(paper) };
        let rule = "but it must be left out with both inks on coloured paper: black, white and the paper's are three colours";
        assert_eq!(told(both("#777")), Some(format!("one_bit is True, {rule}")));
        let strokes = Export { elements: Elements::Marks, dots: Dots::Strokes, ..Export::default() };
        let rule = "but it must be left out when elements is marks: a stroke for each dot is no shorter than its circle";
        assert_eq!(told(strokes), Some(format!("dots is strokes, {rule}")));
        for shown in
            [on("white"), on("#010000"), Export { only: Only::named(&["white"]), ..on("black") }, both("black"), both("white")]
        {
            assert_eq!(told(shown.clone()), None, "{shown:?}");
        }
    }

    #[test]
    fn white_ink_alone_is_flat() {
        let export = Export { style: Style::Layered, only: Only::named(&["white"]), ..Export::default() };
        assert_eq!(
            export.check().unwrap_err().to_string(),
            "only is white, but it must be left out when style is layered: a layered drawing has all inks"
        );
    }
}
