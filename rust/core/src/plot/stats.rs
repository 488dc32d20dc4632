//! What a plot comes to: in, a plot and a machine; out, its counts, ways and times.

use serde::Serialize;

use crate::plot::machine::Machine;
use crate::plot::motion::Timing;
use crate::plot::plot::Plot;

/// What a plot comes to on a machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlotStats {
    /// The machine's name.
    pub machine: String,
    /// Its times and ways.
    #[serde(flatten)]
    pub timing: Timing,
    /// Paths, presses included.
    pub paths: usize,
    /// Presses of the pen.
    pub presses: usize,
    /// Parts narrower than the pen, drawn as one line along their middle.
    pub thin: usize,
    /// Dots narrower than the pen, pressed nonetheless.
    pub small_dots: usize,
}

impl Plot {
    /// What is counted and measured, and how long a machine takes.
    pub fn stats(&self, machine: &Machine) -> PlotStats {
        PlotStats {
            machine: machine.name.clone(),
            timing: machine.seconds(self),
            paths: self.lifts(),
            presses: self.presses(),
            thin: self.thin,
            small_dots: self.small_dots,
        }
    }
}
