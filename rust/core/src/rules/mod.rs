//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them. Source: our own.

mod bridges;
mod bridging;
mod cores;
mod islands;
mod nesting;
mod pieces;
mod steiner;
mod straight;
mod ways;

pub use bridges::bridge;
pub use bridging::{Bridge, Bridged, Bridging};
pub use islands::{Island, islands, islands_between};
pub use straight::straight;
