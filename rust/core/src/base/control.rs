//! Progress and cancellation between the thread that works and the thread that waits.
//!
//! The worker reports and asks; the waiting thread reads and cancels. Both go through atomics, so the core needs no callback
//! and never calls into an interpreter from a worker thread.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::base::error::{Error, Result};

/// How much of a run each stage takes, roughly, in the order of the pipeline; the shares sum to 1.
/// They only place the progress bar: the result never depends on them.
pub(crate) const STAGES: [(&str, f32); 7] = [
    ("lattice", 0.10),
    ("importance", 0.35),
    ("relaxation", 0.10),
    ("triangulation", 0.20),
    ("tone", 0.08),
    ("diffusion", 0.10),
    ("outlines", 0.07),
];

/// The state that a worker and the thread that waits for it share.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    stage: AtomicU32,
    /// Fraction of the current stage, as f32 bits.
    fraction: AtomicU32,
}

impl Control {
    /// A fresh state: nothing done, not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the worker to stop at its next check.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Control::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// The stage that runs now, and the fraction of the whole run that is done, in [0, 1].
    pub fn progress(&self) -> (&'static str, f32) {
        let stage = (self.stage.load(Ordering::Relaxed) as usize).min(STAGES.len() - 1);
        let before: f32 = STAGES[..stage].iter().map(|s| s.1).sum();
        let within = f32::from_bits(self.fraction.load(Ordering::Relaxed)).clamp(0.0, 1.0);
        (STAGES[stage].0, (before + within * STAGES[stage].1).min(1.0))
    }

    /// Fails with [`Error::Cancelled`] once [`Control::cancel`] was called. Long loops call it every few milliseconds.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Says that a stage begins, by its place in [`STAGES`], and checks for cancellation.
    pub(crate) fn begin(&self, stage: usize) -> Result<()> {
        self.fraction.store(0, Ordering::Relaxed);
        self.stage.store(stage as u32, Ordering::Relaxed);
        self.check()
    }

    /// Says how much of the current stage is done, and checks for cancellation. A stage that does its work several times over, or
    /// on several threads, never seems to go back: the bits of floats from 0 on are in the order of the floats.
    pub(crate) fn report(&self, fraction: f32) -> Result<()> {
        self.fraction.fetch_max(fraction.max(0.0).to_bits(), Ordering::Relaxed);
        self.check()
    }
}
