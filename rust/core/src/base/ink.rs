//! Ink: what every mark is drawn with.

/// What a mark is drawn with, by the label of its nodes. In a drawing of black and white, black is 0 and white, its paper, 1; in one of
/// several inks the paper is the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ink(u8);

impl Ink {
    /// Label 0 of a drawing of black and white.
    pub const BLACK: Self = Self(0);

    /// Label 1 of a drawing of black and white: the paper.
    pub const WHITE: Self = Self(1);

    /// The ink of a label.
    pub fn of_label(label: u8) -> Self {
        Self(label)
    }

    /// Its label.
    pub fn label(self) -> u8 {
        self.0
    }

    /// Its place in tables of all inks.
    pub(crate) fn index(self) -> usize {
        usize::from(self.0)
    }

    /// Of black and white: 1 for black and -1 for white, what its area adds to the black that there is.
    pub(crate) fn sign(self) -> f64 {
        if self == Self::BLACK { 1.0 } else { -1.0 }
    }

    /// Of black and white: the other one.
    pub fn other(self) -> Self {
        if self == Self::BLACK { Self::WHITE } else { Self::BLACK }
    }

    /// Of black and white: `black` or `white`.
    pub fn name(self) -> &'static str {
        if self == Self::BLACK { "black" } else { "white" }
    }

    /// Of black and white: `Black` or `White`.
    pub fn capital_name(self) -> &'static str {
        if self == Self::BLACK { "Black" } else { "White" }
    }
}
