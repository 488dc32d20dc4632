//! Work on threads of its own, watched by the calling thread.
//!
//! The calling thread, detached from the interpreter, looks up every few milliseconds: it lets Python handle signals and calls the
//! progress callback. When either raises, the worker is asked to stop and the exception propagates at once, without waiting
//! for the worker; so what a worker uses is its own. Workers never call Python, but to ask Pillow ([`crate::fallback`]).
//! Where the system gives no thread, the calling thread does the work, and looks up when it is done.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use graphstipple_core::stages::Pool;
use graphstipple_core::{Control, Error};
use pyo3::exceptions::PySystemExit;
use pyo3::prelude::*;

use crate::errors;

/// Time between two looks: far below the half second in which Ctrl-C has to work, and too rare to cost anything.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// What a call is watched with.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a, 'py> {
    /// How many threads work; by default one a processor.
    pub(crate) threads: Option<usize>,
    /// Called with a stage's name and the fraction that is done.
    pub(crate) progress: Option<&'a Bound<'py, PyAny>>,
}

impl Watch<'_, '_> {
    /// With so many threads, and nobody who is told of the progress.
    pub(crate) fn on(threads: Option<usize>) -> Self {
        Self { threads, progress: None }
    }
}

/// Runs `work` on a pool of threads and returns what it returns.
///
/// # Errors
/// Whatever `work` fails with, a signal handler raises, or the progress callback raises.
pub(crate) fn run<T, E, W>(py: Python<'_>, watch: Watch, convert: fn(E) -> PyErr, work: W) -> PyResult<T>
where
    T: Send + 'static,
    E: Send + 'static,
    W: FnOnce(&Control) -> Result<T, E> + Send + 'static,
{
    let control = Arc::new(Control::new());
    let (sender, receiver) = channel();
    let of_worker = Arc::clone(&control);
    py.detach(|| {
        Pool::start(watch.threads, move || {
            // Nobody receives once the caller was interrupted: then the result is dropped here.
            let _ = sender.send(work(&of_worker));
        });
    });
    let mut receiver = receiver;
    loop {
        // A Receiver cannot be shared, so it goes to the detached side and back.
        let (received, back) = py.detach(move || (receiver.recv_timeout(LOOK_EVERY), receiver));
        receiver = back;
        match received {
            Ok(result) => {
                py.check_signals()?;
                return result.map_err(convert);
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(errors::from_core(Error::Internal("a worker thread panicked (its message is above)".into())));
            }
            Err(RecvTimeoutError::Timeout) => {
                let looked = py.check_signals().and_then(|()| match watch.progress {
                    Some(progress) => progress.call1(control.progress()).map(drop),
                    None => Ok(()),
                });
                if let Err(raised) = looked {
                    control.cancel();
                    return Err(raised);
                }
            }
        }
    }
}

/// As [`run`] on so many threads, for work that fails with the core's errors and reports no progress.
pub(crate) fn run_core<T, W>(py: Python<'_>, threads: Option<usize>, work: W) -> PyResult<T>
where
    T: Send + 'static,
    W: FnOnce(&Control) -> graphstipple_core::Result<T> + Send + 'static,
{
    run(py, Watch::on(threads), errors::from_core, work)
}

/// The exit code that a signal handler asks for by raising, for the command line's own loop. The exception itself is dropped: the
/// command line says in its own words that it was interrupted.
pub(crate) fn interrupted() -> Option<u8> {
    Python::attach(|py| {
        let raised = py.check_signals().err()?;
        let code = raised.value(py).getattr("code").and_then(|code| code.extract()).ok();
        Some(code.filter(|_| raised.is_instance_of::<PySystemExit>(py)).unwrap_or(graphstipple_cli::INTERRUPTED))
    })
}
