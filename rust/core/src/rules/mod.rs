//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them.

mod areas;
mod boxes;
mod changes;
mod check;
mod dots;
mod enforce;
mod near;
mod report;
mod rules;
mod shapes;
mod thin;

pub use changes::Changes;
pub use check::check;
pub use enforce::enforce;
pub use report::{Kind, Report, Violation};
pub use rules::{Islands, PROCESSES, Process, ProcessRule, RULES, Rules};
