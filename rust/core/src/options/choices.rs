//! What options that are words stand for.

use super::value::{Typed, Value, words};

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

words! {
    /// What a flat drawing is written with; a layered one always has both inks.
    Inks {
        /// Black ink on white paper.
        Black = "black",
        /// White ink on black paper.
        White = "white",
        /// Both, each in layers of its own.
        Both = "both",
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
