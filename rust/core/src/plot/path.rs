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

/// What one pen draws.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotLayer {
    /// The ink of the pen.
    pub ink: Ink,
    /// Its paths, in the order in which they are drawn.
    pub paths: Vec<Path>,
}
