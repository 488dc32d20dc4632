//! A photo that is drawn again and again.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use graphstipple_cli::files;
use graphstipple_core::Session as CoreSession;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::drawing::{Drawing, source};
use crate::options::Options;
use crate::{arrays, errors, watch};

/// A photo and its importance, with what the last drawing of them left: `graphstipple.Session` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Session {
    size: (usize, usize),
    importance: String,
    /// What it took to make the importance, by stage.
    seconds: BTreeMap<String, f64>,
    /// Locked by the workers, which never wait for their callers: so a draw that was interrupted, or that another thread or a
    /// progress callback asked for, is waited for and holds nothing up for good.
    session: Arc<Mutex<CoreSession>>,
}

#[pymethods]
impl Session {
    /// A session on luma (height, width) with an importance, both as for `draw`; files are laid on the options' background.
    #[new]
    fn new(py: Python<'_>, luma: PyReadonlyArray2<'_, f32>, importance: &Bound<'_, PyAny>, options: &Options) -> PyResult<Self> {
        let (luma, source, background) = (arrays::field(&luma)?, source(importance)?, options.checked.background.rgb());
        let (session, seconds) = watch::run(py, None, errors::from_files, move |control| {
            let mut seconds = BTreeMap::new();
            let importance = files::evaluate(source, &luma, background, &mut seconds, control)?;
            Ok((CoreSession::new(luma, importance), seconds))
        })?;
        let (size, name) = ((session.luma().width(), session.luma().height()), session.importance().name());
        Ok(Self { size, importance: name, seconds, session: Arc::new(Mutex::new(session)) })
    }

    /// Width and height of the canvas in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Name of the importance: "saliency", "none", "constant:V" or "map".
    #[getter]
    fn importance(&self) -> &str {
        &self.importance
    }

    /// Seconds that it took to make the importance, by stage.
    #[getter]
    fn seconds(&self) -> BTreeMap<String, f64> {
        self.seconds.clone()
    }

    /// Draw with the options, from where they begin to differ from the last ones.
    #[pyo3(signature = (options, progress=None))]
    fn draw(&self, py: Python<'_>, options: &Options, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Drawing> {
        let options = options.checked.clone();
        let session = Arc::clone(&self.session);
        let outcome = watch::run(py, progress, errors::from_core, move |control| {
            // A worker that panicked left whole results only, as one that was cancelled does.
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            session.draw(&options, control)
        })?;
        Drawing::of(outcome)
    }
}
