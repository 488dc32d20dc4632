//! OpenCV finds the subject of a photo: `python/graphstipple.subject.py`.

use graphstipple_cli::files::Handed;
use graphstipple_core::stages::Reading as CoreReading;
use graphstipple_core::{Error, Photo as CorePhoto, Result};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::errors;
use crate::fallback::file_of;
use crate::photo::{Photo, Reading};

/// A mask, and a sentence for the user.
type Found = (Option<CorePhoto>, Option<String>);

/// Hands a photo to OpenCV, on the thread that reads it.
pub(crate) fn by_opencv(handed: Handed, photo: &CorePhoto, reading: &CoreReading) -> Result<Found> {
    Python::attach(|py| {
        asked(py, handed, photo, reading).map_err(|error| {
            let is_interrupt = error.is_instance_of::<PyKeyboardInterrupt>(py);
            if is_interrupt { Error::Cancelled } else { Error::Input(errors::sentence(py, &error)) }
        })
    })
}

fn asked(py: Python<'_>, handed: Handed, photo: &CorePhoto, reading: &CoreReading) -> PyResult<Found> {
    let photo = Bound::new(py, Photo { photo: photo.clone() })?;
    let reading = Bound::new(py, Reading { reading: reading.clone() })?;
    let found = py.import("graphstipple.subject")?.getattr("of_file")?.call1((file_of(py, handed)?, photo, reading))?;
    let (mask, warning): (Option<PyRef<'_, Photo>>, Option<String>) = found.extract()?;
    Ok((mask.map(|mask| mask.photo.clone()), warning))
}
