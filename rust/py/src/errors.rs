//! Core errors become Python exceptions, here and nowhere else. The classes are defined in `python/graphstipple/_errors.py`.

use std::io;
use std::path::Path;

use graphstipple_core::Error;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

mod classes {
    #![allow(missing_docs, unreachable_pub, reason = "written by the macro")]
    pyo3::import_exception!(graphstipple._errors, GraphStippleError);
    pyo3::import_exception!(graphstipple._errors, InvalidInputError);
    pyo3::import_exception!(graphstipple._errors, ImageFileError);
    pyo3::import_exception!(graphstipple._errors, ImageFileNotFoundError);
}

/// The Python exception for an error of the core.
pub(crate) fn from_core(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::Option { .. } | Error::Input(_) => classes::InvalidInputError::new_err(message),
        Error::Decode(_) | Error::Unsupported(_) => classes::ImageFileError::new_err(message),
        Error::Cancelled => PyKeyboardInterrupt::new_err(()),
        _ => classes::GraphStippleError::new_err(message),
    }
}

/// The Python exception for an array or an option that breaks a rule.
pub(crate) fn invalid(message: impl Into<String>) -> PyErr {
    classes::InvalidInputError::new_err(message.into())
}

/// The Python exception for an error of reading or writing files.
pub(crate) fn from_files(error: graphstipple_cli::Error) -> PyErr {
    use graphstipple_cli::Error;
    let message = error.to_string();
    match error {
        Error::Core(error) => from_core(error),
        Error::Usage(_) => classes::InvalidInputError::new_err(message),
        Error::Interrupted(_) => PyKeyboardInterrupt::new_err(()),
        Error::File { path, source } if is_missing(&path, &source) => classes::ImageFileNotFoundError::new_err(message),
        _ => classes::ImageFileError::new_err(message),
    }
}

/// What an exception says, as one sentence.
pub(crate) fn sentence(py: Python<'_>, error: &PyErr) -> String {
    error.value(py).to_string()
}

/// Whether the file, or the folder that it should be written to, does not exist: Python says `FileNotFoundError` to both.
fn is_missing(path: &Path, error: &io::Error) -> bool {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    error.kind() == io::ErrorKind::NotFound || folder.is_some_and(|folder| !folder.exists())
}
