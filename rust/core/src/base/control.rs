//! Progress and cancellation between the thread that works and the thread that waits.
//!
//! The worker reports and asks; the waiting thread reads and cancels. Both go through atomics, so the core needs no callback
//! and never calls into an interpreter from a worker thread.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

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
    /// All steps, each with its name and how much of a run it takes with the default options, roughly; the shares sum to 1. The tone
    /// has little, as its work is done beside the triangulation. They only place the progress bar: the result never depends on them.
    pub(crate) const ALL: [(Self, &'static str, f32); 8] = [
        (Self::Saliency, "saliency", 0.04),
        (Self::Lattice, "lattice", 0.07),
        (Self::Importance, "importance", 0.07),
        (Self::Relaxation, "relaxation", 0.06),
        (Self::Triangulation, "triangulation", 0.26),
        (Self::Tone, "tone", 0.04),
        (Self::Diffusion, "diffusion", 0.28),
        (Self::Outlines, "outlines", 0.18),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// The state that a worker and the thread that waits for it share.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    /// Where the work is, in one number that only grows: the round, the step, and the fraction of it as f32 bits, which are in the
    /// order of the floats from 0 on.
    place: AtomicU64,
}

/// Bits of the fraction, and of fraction and step.
const FRACTION_BITS: u32 = 32;
const STEP_BITS: u32 = 40;

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

    /// The step that is done now, and the fraction of the whole run that is done, in [0, 1]. It never goes back.
    pub fn progress(&self) -> (&'static str, f32) {
        let place = self.place.load(Ordering::Relaxed);
        let step = ((place >> FRACTION_BITS) as usize & 0xff).min(Step::ALL.len() - 1);
        let before: f32 = Step::ALL[..step].iter().map(|(_, _, share)| share).sum();
        let within = f32::from_bits(place as u32).clamp(0.0, 1.0);
        let of_round = (before + within * Step::ALL[step].2).min(1.0);
        (Step::ALL[step].1, of_rounds((place >> STEP_BITS) as u32, of_round))
    }

    /// Fails with [`Error::Cancelled`] once [`Control::cancel`] was called. Long loops call it every few milliseconds.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Says that the same work begins once more, or for the first of several times. How many times nobody knows yet, so each is given
    /// half of what is left.
    pub fn begin_round(&self) {
        let rounds = self.place.load(Ordering::Relaxed) >> STEP_BITS;
        self.place.fetch_max((rounds + 1) << STEP_BITS, Ordering::Relaxed);
    }

    /// Says that a step begins, and checks for cancellation.
    pub(crate) fn begin(&self, step: Step) -> Result<()> {
        let rounds = self.place.load(Ordering::Relaxed) >> STEP_BITS;
        self.place.fetch_max(rounds << STEP_BITS | (step as u64) << FRACTION_BITS, Ordering::Relaxed);
        self.check()
    }

    /// Says how much of the current step is done, and checks for cancellation. One that does its work several times over, or
    /// on several threads, never seems to go back.
    pub(crate) fn report(&self, fraction: f32) -> Result<()> {
        let step = self.place.load(Ordering::Relaxed) >> FRACTION_BITS;
        self.place.fetch_max(step << FRACTION_BITS | u64::from(fraction.max(0.0).to_bits()), Ordering::Relaxed);
        self.check()
    }
}

/// How much of everything is done when so much of a round is; round 0 is the only one.
fn of_rounds(round: u32, done: f32) -> f32 {
    let Some(before) = round.checked_sub(1) else { return done };
    let left = 0.5f32.powi(before.min(32) as i32);
    1.0 - left + 0.5 * left * done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_never_goes_back() {
        let control = Control::new();
        let mut last = 0.0;
        let mut assert_forward = |name: &str| {
            let (step, fraction) = control.progress();
            assert!(step == name && fraction >= last && fraction <= 1.0, "{step} {fraction} {last}");
            last = fraction;
        };
        control.begin(Step::Saliency).unwrap();
        control.report(0.5).unwrap();
        assert_forward("saliency");
        control.begin(Step::Tone).unwrap();
        control.report(0.9).unwrap();
        assert_forward("tone");
        // Done again, on several threads.
        control.report(0.2).unwrap();
        control.begin(Step::Lattice).unwrap();
        assert_forward("tone");
        control.begin(Step::Outlines).unwrap();
        control.report(1.0).unwrap();
        assert_forward("outlines");
        assert_eq!(control.progress().1, 1.0);
    }

    #[test]
    fn each_round_has_half_of_what_is_left() {
        let control = Control::new();
        for (begin, end) in [(0.0, 0.5), (0.5, 0.75), (0.75, 0.875)] {
            control.begin_round();
            assert_eq!(control.progress(), ("saliency", begin));
            control.begin(Step::Outlines).unwrap();
            control.report(1.0).unwrap();
            assert!((control.progress().1 - end).abs() < 1e-6);
        }
        control.cancel();
        assert!(matches!(control.begin(Step::Tone), Err(Error::Cancelled)));
    }
}
