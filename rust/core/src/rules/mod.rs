//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them.

mod bridges;
mod cores;
mod pieces;
mod steiner;
mod ways;

pub use bridges::{Bridge, Bridged, Bridging, bridge};
