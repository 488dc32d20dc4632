//! Progress and cancellation between the thread that works and the thread that waits.
//!
//! The worker reports and asks; the waiting thread reads and cancels. Both go through atomics, so the core needs no callback
//! and never calls into an interpreter from a worker thread.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::base::error::{Error, Result};

/// A step of a drawing, as progress and times tell of it; in the order in which they are done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    Saliency,
    Lattice,
    Importance,
    Relaxation,
    Triangulation,
    Tone,
    Diffusion,
    Outlines,
}

impl Step {
    /// All steps, each with its name and how much of a run it takes, roughly; the shares sum to 1. They only place the progress
    /// bar: the result never depends on them.
    pub(crate) const ALL: [(Self, &'static str, f32); 8] = [
        (Self::Saliency, "saliency", 0.10),
        (Self::Lattice, "lattice", 0.10),
        (Self::Importance, "importance", 0.25),
        (Self::Relaxation, "relaxation", 0.10),
        (Self::Triangulation, "triangulation", 0.20),
        (Self::Tone, "tone", 0.08),
        (Self::Diffusion, "diffusion", 0.10),
        (Self::Outlines, "outlines", 0.07),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// The state that a worker and the thread that waits for it share.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    step: AtomicU32,
    /// Fraction of the current step, as f32 bits.
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

    /// The step that is done now, and the fraction of the whole run that is done, in [0, 1].
    pub fn progress(&self) -> (&'static str, f32) {
        let step = (self.step.load(Ordering::Relaxed) as usize).min(Step::ALL.len() - 1);
        let before: f32 = Step::ALL[..step].iter().map(|(_, _, share)| share).sum();
        let within = f32::from_bits(self.fraction.load(Ordering::Relaxed)).clamp(0.0, 1.0);
        (Step::ALL[step].1, (before + within * Step::ALL[step].2).min(1.0))
    }

    /// Fails with [`Error::Cancelled`] once [`Control::cancel`] was called. Long loops call it every few milliseconds.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Says that a step begins, and checks for cancellation.
    pub(crate) fn begin(&self, step: Step) -> Result<()> {
        self.fraction.store(0, Ordering::Relaxed);
        self.step.store(step as u32, Ordering::Relaxed);
        self.check()
    }

    /// Says how much of the current step is done, and checks for cancellation. One that does its work several times over, or
    /// on several threads, never seems to go back: the bits of floats from 0 on are in the order of the floats.
    pub(crate) fn report(&self, fraction: f32) -> Result<()> {
        self.fraction.fetch_max(fraction.max(0.0).to_bits(), Ordering::Relaxed);
        self.check()
    }
}
