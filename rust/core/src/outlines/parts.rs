//! What the outlines hand out: curves and dots, each with the components on its two sides.

use kurbo::{BezPath, Point};

use crate::base::{Ink, Palette};

/// What a drawing is put together from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parts {
    /// Width of the canvas in pixels.
    pub width: usize,
    /// Height of the canvas in pixels.
    pub height: usize,
    /// Units to a pixel of the grid of coordinates.
    pub units: f64,
    /// The inks of the drawing.
    pub palette: Palette,
    /// The shared curves, the lower ink on their left, each with the components to its left and right.
    pub curves: Vec<(BezPath, [u32; 2])>,
    /// The dots, each with its own component and the one around it.
    pub stipples: Vec<(Stipple, [u32; 2])>,
    /// Ink of every component.
    pub inks: Vec<Ink>,
    /// The component on the frame, when no curve ends there.
    pub on_frame: u32,
}

/// A component of one node, drawn as a round dot. (An irregular one is a [`Region`](crate::stages::Region).)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stipple {
    /// Centre in pixels.
    pub x: f64,
    /// Centre in pixels.
    pub y: f64,
    /// Radius in pixels, above 0.
    pub radius: f64,
    /// What it is drawn with.
    pub ink: Ink,
    /// How many marks lie under it in the layered way; see [`Region::level`](crate::stages::Region::level).
    pub level: u32,
}

impl Stipple {
    /// A dot near `centre` whose coordinates files hold exactly in few digits: its leftmost point lies on the grid of `units` to a
    /// pixel, and its radius is a whole number of hundredths of a unit, not above the given one unless that is far below a
    /// hundredth.
    pub(crate) fn on_grid(centre: Point, radius: f64, units: f64, ink: Ink) -> Self {
        let hundredths = (radius * units * 100.0).floor();
        // A radius of few digits would be far off.
        let in_units = if hundredths >= 50.0 { hundredths / 100.0 } else { radius * units };
        let left = (centre.x * units - in_units).round();
        Self { x: (left + in_units) / units, y: (centre.y * units).round() / units, radius: in_units / units, ink, level: 0 }
    }
}
