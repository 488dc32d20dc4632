//! The whole method: the only folder that knows the order of the stages. In: a photo, an importance and the options; out: a drawing
//! with what the stages made on the way to it, all of them kept for the next one in a session. Source: the order is the paper's.

mod draw;
#[cfg(test)]
mod geometry;
mod inking;
mod memory;
mod needs;
mod search;
mod session;
mod within;

pub use draw::{Outcome, draw, draw_owned};
pub(crate) use draw::{Relabelled, redrawn};
pub use session::Session;
pub use within::{Limits, Trials};
