//! What a pen draws in one go.

use crate::base::Ink;

/// What a pen draws without being lifted. All coordinates are mm from the drawing's top left corner, y running down.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// The points, at least one; a single one is a press of the pen. A closed path does not repeat its first point.
    pub points: Vec<[f64; 2]>,
    /// Whether it ends where it begins, and so may begin anywhere.
    pub is_closed: bool,
}

impl Path {
    /// How long a line it draws, in mm: of a closed one all around, of a press 0.
    pub fn length(&self) -> f64 {
        let closing = self.is_closed.then(|| Some((self.points.last()?, self.points.first()?))).flatten();
        let steps = self.points.windows(2).map(|pair| (&pair[1], &pair[0])).chain(closing);
        steps.map(|(a, b)| distance(*a, *b)).sum()
    }

    /// Where the pen is when it has been drawn; nowhere without a point.
    pub fn end(&self) -> Option<[f64; 2]> {
        if self.is_closed { self.points.first().copied() } else { self.points.last().copied() }
    }
}

/// How far two points are from each other.
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}

/// What one pen draws.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotLayer {
    /// The ink of the pen; of other inks than black and white the ink's number.
    pub ink: Ink,
    /// What it is called.
    pub name: String,
    /// Its colour, sRGB.
    pub rgb: [u8; 3],
    /// Its paths, in the order in which they are drawn.
    pub paths: Vec<Path>,
}
