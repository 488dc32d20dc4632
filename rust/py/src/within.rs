//! The finest drawing within a limit: the search for it, which Python asks what to draw next.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use graphstipple_core::Format;
use graphstipple_core::stages::{Limits, Trials as CoreTrials};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::drawing::{Drawing, writer};
use crate::options::Options;
use crate::{errors, values, watch};

/// A search for the finest drawing that has at most so many bytes, as a file of this suffix with these settings, or points.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Trials {
    trials: Arc<Mutex<CoreTrials>>,
}

impl Trials {
    fn locked(trials: &Mutex<CoreTrials>) -> MutexGuard<'_, CoreTrials> {
        // What a worker that panicked was told counts, or does not.
        trials.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Trials {
    #[new]
    fn new(
        options: &Options,
        size: (usize, usize),
        max_bytes: &Bound<'_, PyAny>,
        max_points: &Bound<'_, PyAny>,
        suffix: &str,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let value = |given: &Bound<'_, PyAny>| if given.is_none() { Ok(None) } else { values::from_python(given).map(Some) };
        let limits = Limits::read(value(max_bytes)?.as_ref(), value(max_points)?.as_ref()).map_err(errors::from_core)?;
        let writer = writer(Format::of_suffix(suffix).map_err(errors::from_core)?, settings)?;
        writer.check_size(size.0, size.1).map_err(errors::from_core)?;
        let trials = CoreTrials::new(options.checked.clone(), (size.0 * size.1) as f64, writer, limits);
        Ok(Self { trials: Arc::new(Mutex::new(trials)) })
    }

    /// The options of the drawing to make next; `None` when the search is over.
    fn next_options(&self) -> PyResult<Option<Options>> {
        let next = Self::locked(&self.trials).next_options().map_err(errors::from_core)?;
        Ok(next.map(|checked| Options { checked }))
    }

    /// Says which drawing these options gave. Returns whether it is the finest so far that fits.
    fn tell(&self, py: Python<'_>, drawing: &Drawing) -> PyResult<bool> {
        let (trials, (drawing, nodes)) = (Arc::clone(&self.trials), drawing.shared());
        watch::run_core(py, None, move |_| Self::locked(&trials).tell(&drawing, nodes, None))
    }

    /// The finest drawing that fits, with what it came to in its stats. Raises if none does.
    fn found(&self, finest: Option<&Drawing>) -> PyResult<Option<Drawing>> {
        let within = Self::locked(&self.trials).found().map_err(errors::from_core)?;
        let within = serde_json::to_value(within).map_err(crate::drawing::internal)?;
        Ok(finest.map(|finest| finest.with_stat("within", within)))
    }
}
