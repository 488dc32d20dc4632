//! Ink: what every mark is drawn with.

use serde::{Deserialize, Serialize};

/// What a mark is drawn with. Its number is the label of its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ink {
    /// Label 0.
    Black = 0,
    /// Label 1: the paper.
    White = 1,
}

impl Ink {
    /// The ink of a label: 0 is black, anything else white.
    pub fn of_label(label: u8) -> Self {
        if label == 0 { Self::Black } else { Self::White }
    }

    /// 1 for black and -1 for white: what its area adds to the black that there is.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Black => 1.0,
            Self::White => -1.0,
        }
    }

    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Black => Self::White,
            Self::White => Self::Black,
        }
    }

    /// `black` or `white`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Black => "black",
            Self::White => "white",
        }
    }

    /// `Black` or `White`.
    pub fn capital_name(self) -> &'static str {
        match self {
            Self::Black => "Black",
            Self::White => "White",
        }
    }
}
