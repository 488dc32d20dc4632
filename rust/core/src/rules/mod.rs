//! What a machine cannot make. In: a [`Drawing`](crate::Drawing), its size and the limits of a process; out: a report of what breaks
//! them, and a drawing that keeps them.

mod areas;
mod boxes;
mod dots;
mod enforce;
mod near;
mod rules;
mod shapes;
mod thin;

pub use enforce::{Changes, enforce};
pub use rules::{Islands, PROCESSES, Process, ProcessRule, RULES, Rules};
