//! What was counted and timed on the way to a drawing.

use serde::Serialize;

use crate::drawing::Drawing;

/// What was counted and timed (docs/method.md; Table 4 of the paper has stipples, regions and vertices).
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Stats {
    /// Width of the canvas in pixels.
    pub width: usize,
    /// Height of the canvas in pixels.
    pub height: usize,
    /// By which factor the photo was reduced before it was drawn; 1 if it was not.
    pub reduction: usize,
    /// Lattice nodes per pixel of the canvas.
    pub density: f64,
    /// Nodes of the first graph.
    pub lattice_nodes: usize,
    /// The node budget; `None` when the importance alone decides.
    pub node_budget: Option<usize>,
    /// The factor on the importance that meets the budget; 1 without one.
    pub importance_factor: f64,
    /// What the refinement of the labels adds for white, so that the drawing has the photo's mean: see [`crate::stages::refine`].
    pub tone_shift: f64,
    /// Nodes of the second graph.
    pub nodes: usize,
    /// Components drawn as dots.
    pub stipples: usize,
    /// Components drawn as closed paths.
    pub regions: usize,
    /// Crossings that region boundaries pass through, plus stipples, irregular ones too: before smoothing and
    /// simplification.
    pub vertices: usize,
    /// On-curve points written; a dot counts one.
    pub anchors: usize,
    /// Coordinate pairs written, control points included; a dot counts one.
    pub coordinates: usize,
    /// Stipples that a least radius made larger.
    pub dots_enlarged: usize,
    /// Stipples that a least radius left out.
    pub dots_dropped: usize,
    /// What it took to keep the drawing within a limit, and what it came to; `None` where there was none.
    pub within: Option<Within>,
    /// Which program decoded the photo's file: `graphstipple`, or another with its version; `None` where there was none.
    pub decoder: Option<String>,
    /// Seconds each stage took, and `total`.
    pub seconds: std::collections::BTreeMap<String, f64>,
}

/// What a drawing within limits came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Within {
    /// Drawings that were made to find it.
    pub trials: usize,
    /// Bytes of its file, if they are limited.
    pub bytes: Option<u64>,
    /// Points: coordinate pairs of the drawing.
    pub points: u64,
    /// Seconds of its plot, if they are limited.
    pub seconds: Option<u64>,
    /// Nodes of the drawing.
    pub nodes: usize,
    /// Its tolerance in pixels.
    pub tolerance: f64,
}

impl Stats {
    /// Counts what was made of the drawing; so many dots were enlarged and dropped for it.
    pub fn recount(&mut self, drawing: &Drawing, enlarged: usize, dropped: usize) {
        (self.anchors, self.coordinates) = drawing.count_written();
        (self.stipples, self.regions) = (drawing.stipples.len(), drawing.regions.len());
        (self.dots_enlarged, self.dots_dropped) = (enlarged, dropped);
    }

    /// Adds what was done before the drawing was begun, by stage; it counts in the total too.
    pub fn add_seconds(&mut self, before: std::collections::BTreeMap<String, f64>) {
        *self.seconds.entry("total".to_owned()).or_default() += before.values().sum::<f64>();
        for (stage, seconds) in before {
            *self.seconds.entry(stage).or_default() += seconds;
        }
    }
}
