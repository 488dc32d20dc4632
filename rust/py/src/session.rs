//! A photo that is drawn again and again.

use std::sync::{Arc, Mutex, PoisonError};

use graphstipple_core::Session as CoreSession;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::drawing::{Drawing, given_importance};
use crate::{arrays, errors, options, watch};

/// A photo and its importance, with what the last drawing of them left: `graphstipple.Session` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Session {
    size: (usize, usize),
    importance: String,
    /// Locked by the workers, which never wait for their callers: so a draw that was interrupted, or that another thread or a
    /// progress callback asked for, is waited for and holds nothing up for good.
    session: Arc<Mutex<CoreSession>>,
}

#[pymethods]
impl Session {
    /// A session on luma (height, width) with an importance, both as for `draw`.
    #[new]
    #[pyo3(signature = (luma, importance, importance_map))]
    fn new(luma: PyReadonlyArray2<'_, f32>, importance: &str, importance_map: Option<PyReadonlyArray2<'_, f32>>) -> PyResult<Self> {
        let (luma, importance) = (arrays::field(&luma)?, given_importance(importance, importance_map)?);
        let (size, name) = ((luma.width(), luma.height()), importance.name());
        Ok(Self { size, importance: name, session: Arc::new(Mutex::new(CoreSession::new(luma, importance))) })
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

    /// Draw with the options (JSON), from where they begin to differ from the last ones.
    #[pyo3(signature = (options_json, progress=None))]
    fn draw(&self, py: Python<'_>, options_json: &str, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Drawing> {
        let options = options::parse(options_json)?;
        let session = Arc::clone(&self.session);
        let outcome = watch::run(py, progress, errors::from_core, move |control| {
            // A worker that panicked left whole results only, as one that was cancelled does.
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            session.draw(&options, control)
        })?;
        Drawing::of(outcome)
    }
}
