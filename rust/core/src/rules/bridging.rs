//! How islands are joined, and what came of it: in label space (see [`super::bridges`]) and by straight cuts (see [`super::straight`]).

use crate::base::{Error, Result};

/// How islands are joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridging {
    /// Islands of less area become black; in px^2 of the canvas, or of what unit polygons have.
    pub min_area: f64,
    /// How wide bridges are at least; in pixels of the canvas, or in that unit.
    pub width: f64,
}

impl Bridging {
    /// # Errors
    /// [`Error::Option`] if the area is below 0, the width is not above 0, or one is not finite.
    pub(super) fn check(&self) -> Result<()> {
        if !(self.min_area >= 0.0 && self.min_area.is_finite()) {
            return Err(Error::option("min_area", self.min_area, "an area of 0 or more"));
        }
        if !(self.width > 0.0 && self.width.is_finite()) {
            return Err(Error::option("bridge_width", self.width, "a length above 0"));
        }
        Ok(())
    }
}

/// A way through black, from white to white.
#[derive(Debug, Clone, PartialEq)]
pub struct Bridge {
    /// Its middle line, from one end to the other.
    pub points: Vec<[f64; 2]>,
    /// How long it is, in black alone.
    pub length: f64,
}

/// What bridging did; lengths and areas in the units of [`Bridging`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bridged {
    /// Islands that became black.
    pub dropped: usize,
    /// Islands that were joined.
    pub bridged: usize,
    /// What joins them.
    pub bridges: Vec<Bridge>,
    /// By how much the mean tone of the canvas became lighter, in [-1, 1].
    pub tone: f64,
}
