//! A photo that is drawn again and again.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use graphstipple_cli::files;
use graphstipple_core::{Importance, Options as CoreOptions, Photo as CorePhoto, Session as CoreSession};
use pyo3::prelude::*;

use crate::drawing::{Drawing, source};
use crate::options::Options;
use crate::photo::{Photo, Reading, threads_of};
use crate::watch::Watch;
use crate::{errors, watch};

/// A photo and its importance, with what the last drawing of them left: `graphstipple.Session` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Session {
    /// What transparent parts were laid on.
    background: [u8; 3],
    /// The photo, and a map that was given.
    read: Vec<CorePhoto>,
    importance: String,
    /// What it took to make the importance, by stage.
    seconds: BTreeMap<String, f64>,
    /// What is to be said of the file that the importance was read from.
    warning: Option<String>,
    /// Locked by the workers, which never wait for their callers: so a draw that was interrupted, or that another thread or a
    /// progress callback asked for, is waited for and holds nothing up for good.
    session: Arc<Mutex<CoreSession>>,
}

#[pymethods]
impl Session {
    /// A session on a photo with an importance, both as for `draw`, as they were read.
    #[new]
    fn new(py: Python<'_>, photo: &Photo, importance: &Bound<'_, PyAny>, reading: &Reading) -> PyResult<Self> {
        let (photo, source, reading) = (photo.photo.clone(), source(importance)?, reading.reading.clone());
        let background = reading.background;
        let (session, seconds, warning) = watch::run(py, Watch::on(threads_of(&reading)), errors::from_files, move |control| {
            let mut seconds = BTreeMap::new();
            let evaluated = files::evaluate(source, None, photo.luma(), &reading, &mut seconds, control)?;
            Ok((CoreSession::new(photo, evaluated.importance), seconds, evaluated.warning))
        })?;
        let map = if let Importance::Map(map) = session.importance() { Some(map) } else { None };
        let read = std::iter::once(session.photo()).chain(map).cloned().collect();
        let name = session.importance().name();
        Ok(Self { background, read, importance: name, seconds, warning, session: Arc::new(Mutex::new(session)) })
    }

    /// What the session can be begun with again: the photo, the importance (a map, or its name) and the background.
    fn packed<'py>(&self, py: Python<'py>) -> PyResult<(Photo, Bound<'py, PyAny>, [u8; 3])> {
        let importance = match &self.read[..] {
            [_, map] => Bound::new(py, Photo { photo: map.clone() })?.into_any(),
            _ => self.importance.as_str().into_pyobject(py)?.into_any(),
        };
        Ok((Photo { photo: self.read[0].clone() }, importance, self.background))
    }

    /// Width and height of the canvas in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.read[0].width(), self.read[0].height())
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

    /// Whether photo and importance would be read with these options as they were.
    fn fits(&self, options: &Options) -> bool {
        self.background == options.checked.background.rgb() && self.read.iter().all(|photo| photo.fits(&options.checked))
    }

    /// Whether the photo has the colour that drawings with these options are made of.
    fn has_colour_for(&self, options: &Options) -> bool {
        self.read[0].colour().is_some() || !options.checked.wants_colour()
    }

    /// What is to be said of the file that the importance was read from.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Whether no options would have the photo or the map reduced.
    #[getter]
    fn is_never_reduced(&self) -> bool {
        // Nothing is reduced by more than for the fewest nodes.
        let fewest = CoreOptions { nodes: Some(3), ..CoreOptions::default() };
        self.read.iter().flat_map(CorePhoto::sizes).all(|[width, height, _]| fewest.reduction(width, height) == 1)
    }

    /// Draw with the options, from where they begin to differ from the last ones.
    #[pyo3(signature = (options, progress=None))]
    fn draw(&self, py: Python<'_>, options: &Options, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Drawing> {
        let options = options.checked.clone();
        let session = Arc::clone(&self.session);
        let watch = Watch { threads: options.threads, progress };
        let outcome = watch::run(py, watch, errors::from_core, move |control| {
            // A worker that panicked left whole results only, as one that was cancelled does.
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            session.draw(&options, control)
        })?;
        Drawing::of(outcome, None)
    }
}
