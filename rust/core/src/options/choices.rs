//! What options that are words stand for.

use std::fmt;

use super::value::{Typed, Value, words};
use crate::base::{Error, NamedInk, Palette, Result};

words! {
    /// The regular first graph (the paper uses the hexagonal one).
    LatticeKind {
        /// Six neighbours a node, all at the same distance.
        Hexagonal = "hexagonal",
        /// Four neighbours a node.
        Square = "square",
    }
}

words! {
    /// In which order nodes are labelled when errors are diffused.
    Order {
        /// Row by row, many bands of rows at a time; ours.
        Rows = "rows",
        /// The paper's: one order by priority over all nodes.
        Global = "global",
    }
}

words! {
    /// How an error is weighted between cells of different areas.
    ErrorWeighting {
        /// By area: the error times the area of the node's cell, over that of the neighbour's. What is black here is missing there.
        Area = "area",
        /// The paper's, by value: the error itself, as if all cells were equal.
        Value = "value",
    }
}

words! {
    /// Where a contour crosses an edge of the second graph, between a black and a white node.
    Crossings {
        /// Where the tone between the nodes passes middle grey, if it does.
        Tone = "tone",
        /// The paper's: in the middle.
        Midpoint = "midpoint",
    }
}

/// The inks of a drawing, in the order of their labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InkList(pub Vec<NamedInk>);

impl Typed for InkList {
    fn read(value: &Value) -> Option<Self> {
        let Value::Word(text) = value else { return None };
        let inks = text.split(',').map(|ink| NamedInk::parse(ink.trim()));
        inks.collect::<Result<_>>().ok().map(Self)
    }

    fn value(&self) -> Value {
        Value::Word(self.0.iter().map(ToString::to_string).collect::<Vec<_>>().join(","))
    }
}

/// Which inks are drawn, by their names; without any, all of them and not the paper.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Only {
    names: Vec<String>,
}

impl Only {
    /// These inks alone.
    pub fn named(names: &[&str]) -> Self {
        Self { names: names.iter().map(|name| (*name).to_owned()).collect() }
    }

    /// Whether all inks are drawn.
    pub fn is_all(&self) -> bool {
        self.names.is_empty()
    }

    /// The numbers of the inks that are drawn, in the palette's order; one behind the last stands for the paper.
    ///
    /// # Errors
    /// [`Error::Option`] for a name that is none of the palette's.
    pub fn of(&self, palette: &Palette) -> Result<Vec<usize>> {
        if self.is_all() {
            return Ok((0..palette.inks().len()).collect());
        }
        let all: Vec<&str> = palette.names().collect();
        let number = |name: &String| {
            let allowed = || format!("inks of the drawing or its paper, with commas between them: {}", all.join(", "));
            all.iter().position(|known| known == name).ok_or_else(|| Error::option("only", self, allowed()))
        };
        let mut numbers = self.names.iter().map(number).collect::<Result<Vec<_>>>()?;
        numbers.sort_unstable();
        numbers.dedup();
        Ok(numbers)
    }
}

impl fmt::Display for Only {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.names.join(","))
    }
}

impl Typed for Only {
    fn read(value: &Value) -> Option<Self> {
        let Value::Word(text) = value else { return None };
        let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
        names.iter().all(|name| !name.is_empty()).then_some(Self { names })
    }

    fn value(&self) -> Value {
        Value::Word(self.to_string())
    }
}

words! {
    /// What becomes of all that is not the subject, where a subject is given.
    Backdrop {
        /// It stays as it is.
        Keep = "keep",
        /// Half its contrast, and fewer nodes.
        Soften = "soften",
        /// Dots around the subject that grow smaller to nothing.
        Fade = "fade",
        /// Nothing at all: white.
        Paper = "paper",
        /// All black.
        Ink = "ink",
    }
}

words! {
    /// What edges that wobble look like.
    Edge {
        /// Contours waver as a hand does.
        Smooth = "smooth",
        /// They swell and thin too, slowly, as under a pen.
        Inked = "inked",
        /// They are rough and have corners, as torn paper or a cut block.
        Torn = "torn",
    }
}

/// How much of a node's error is passed on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// The paper's: `base + detail_gain * |I0 - A|` if the label fell on the side of 0.5 where the node's own value lies, else 0.
    Dynamic,
    /// `shading` in middle tones, less towards black and white, where it is 0; ours.
    Tonal,
    /// The same share for every node: 1 is plain halftoning, 0 is thresholding. In [0, 1].
    Constant(f64),
}

/// A grey level of the photo that is to become black, or white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Point {
    /// The one beyond which half a percent of the pixels lie.
    Auto,
    /// This one, in [0, 1].
    At(f64),
}

impl Point {
    /// The words that stand beside numbers.
    pub(super) const WORDS: &'static [&'static str] = &["auto"];
}

impl Typed for Point {
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Word(word) if word == "auto" => Some(Self::Auto),
            _ => f64::read(value).map(Self::At),
        }
    }

    fn value(&self) -> Value {
        match self {
            Self::Auto => Value::Word("auto".to_owned()),
            Self::At(grey) => Value::Number(*grey),
        }
    }
}

impl Alpha {
    /// The words that stand beside numbers.
    pub(super) const WORDS: &'static [&'static str] = &["tonal", "dynamic"];
}

impl Typed for Alpha {
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Word(word) if word == "dynamic" => Some(Self::Dynamic),
            Value::Word(word) if word == "tonal" => Some(Self::Tonal),
            _ => f64::read(value).map(Self::Constant),
        }
    }

    fn value(&self) -> Value {
        match self {
            Self::Dynamic => Value::Word("dynamic".to_owned()),
            Self::Tonal => Value::Word("tonal".to_owned()),
            Self::Constant(share) => Value::Number(*share),
        }
    }
}
