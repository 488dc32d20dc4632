//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them. Source: our own.

mod areas;
mod boxes;
mod bridges;
mod bridging;
mod changes;
mod check;
mod cores;
mod dots;
mod enforce;
mod fits;
mod islands;
mod near;
mod nesting;
mod pieces;
mod report;
mod rules;
mod shapes;
mod steiner;
mod straight;
mod thin;
mod usual;
mod ways;

pub use bridges::bridge;
pub use bridging::{Bridge, Bridged, Bridging};
pub use changes::Changes;
pub use check::check;
pub use enforce::enforce;
pub use islands::{Island, islands, islands_between};
pub use report::{Report, ReportFormat, Violation, ViolationKind};
pub use rules::{Islands, PROCESSES, Process, ProcessRule, RULES, Rules};
pub use straight::straight;
