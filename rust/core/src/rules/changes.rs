//! What was done to a drawing so that it keeps the rules.

use serde::Serialize;

use crate::rules::bridging::Bridged;

/// What [`crate::stages::enforce`] did.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Changes {
    /// Dots that stay as they were.
    pub dots_kept: usize,
    /// Dots that were too small and are larger now, many of them in the place of several.
    pub dots_enlarged: usize,
    /// Dots that are smaller now, so that there is room around them.
    pub dots_reduced: usize,
    /// Dots that were left out.
    pub dots_dropped: usize,
    /// Regions that were too small and are filled.
    pub areas_filled: usize,
    /// Black parts that were too thin.
    pub features: usize,
    /// White parts that were too thin.
    pub gaps: usize,
    /// Islands that were too small for a bridge and are filled.
    pub islands_filled: usize,
    /// Islands that were joined to the frame.
    pub islands_bridged: usize,
    /// Bridges that join them.
    pub bridges: usize,
    /// Rounds of opening and closing.
    pub rounds: usize,
    /// Mean tone before, 0 black to 1 white.
    pub tone_before: f64,
    /// Mean tone now.
    pub tone: f64,
}

impl Changes {
    /// Counts islands that were joined.
    pub(super) fn joined(&mut self, told: &Bridged) {
        self.islands_filled += told.dropped;
        self.islands_bridged += told.bridged;
        self.bridges += told.bridges.len();
    }
}
