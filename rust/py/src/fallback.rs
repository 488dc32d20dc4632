//! Pillow reads what the core does not support: `python/graphstipple/_pillow.py`.

use graphstipple_cli::files::Handed;
use graphstipple_core::stages::{Decoded, Reading as CoreReading};
use graphstipple_core::{Error, Result};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors;
use crate::photo::{Photo, Reading};

/// Hands an image to Pillow, on the thread that reads it; `None` if Pillow does not know it either.
pub(crate) fn by_pillow(handed: Handed, reading: &CoreReading) -> Option<Result<Decoded>> {
    Python::attach(|py| match asked(py, handed, reading) {
        Ok(read) => read.map(Ok),
        Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => Some(Err(Error::Cancelled)),
        Err(error) => Some(Err(Error::Decode(errors::sentence(py, &error)))),
    })
}

/// What Python is handed: a path, or all bytes.
pub(crate) fn file_of<'py>(py: Python<'py>, handed: Handed) -> PyResult<Bound<'py, PyAny>> {
    Ok(match handed {
        Handed::Path(path) => path.as_os_str().into_pyobject(py)?.into_any(),
        Handed::Bytes(bytes) => PyBytes::new(py, bytes).into_any(),
    })
}

fn asked(py: Python<'_>, handed: Handed, reading: &CoreReading) -> PyResult<Option<Decoded>> {
    let file = file_of(py, handed)?;
    let colour = reading.colour;
    let reading = Bound::new(py, Reading { reading: reading.clone() })?;
    let read = py.import("graphstipple._pillow")?.getattr("read")?.call1((file, reading, colour))?;
    let read: Option<(PyRef<'_, Photo>, String)> = read.extract()?;
    Ok(read.map(|(photo, decoder)| Decoded { photo: photo.photo.clone(), warning: None, decoder }))
}
