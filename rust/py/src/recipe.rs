//! Many photos by the flags of one command line.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use graphstipple_cli::files::Input;
use graphstipple_cli::recipe::{self, Flag, Recipe as CliRecipe};
use graphstipple_core::Format;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::options::Options;
use crate::watch::Watch;
use crate::{errors, values, watch};

/// The bytes of files, counts and times, and sentences for the user.
type Written<'py> = (Vec<Bound<'py, PyBytes>>, Py<PyAny>, Vec<String>);

/// How any photo is drawn and written: the flags of a command line, and the suffixes of the formats. Where the
/// bytes of an importance map are given, its file is not opened.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Recipe {
    recipe: Arc<CliRecipe>,
}

#[pymethods]
impl Recipe {
    #[new]
    #[pyo3(signature = (flags, suffixes, map=None))]
    fn new(flags: Vec<OsString>, suffixes: Vec<String>, map: Option<Vec<u8>>) -> PyResult<Self> {
        let formats = suffixes.iter().map(|suffix| Format::of_suffix(suffix)).collect::<Result<Vec<_>, _>>();
        let recipe = CliRecipe::of(flags, &formats.map_err(errors::from_core)?, map).map_err(errors::from_files)?;
        Ok(Self { recipe: Arc::new(recipe) })
    }

    /// The options of every drawing.
    #[getter]
    fn options(&self) -> Options {
        Options { checked: self.recipe.options().clone() }
    }

    /// Whether files that are read-only are overwritten.
    #[getter]
    fn force(&self) -> bool {
        self.recipe.force()
    }

    /// The bytes of a file for every format, counts and times, and sentences for the user, of a photo given by the bytes of its file; the
    /// path is the name by which messages tell of it.
    fn draw<'py>(&self, py: Python<'py>, path: PathBuf, data: Vec<u8>) -> PyResult<Written<'py>> {
        let recipe = Arc::clone(&self.recipe);
        let draw = move |control: &_| recipe.draw(Input::bytes(&path, data), control);
        let written = watch::run(py, Watch::on(self.recipe.options().threads), errors::from_files, draw)?;
        let files = written.files.iter().map(|bytes| PyBytes::new(py, bytes)).collect();
        let stats = serde_json::to_value(&written.stats).map_err(crate::drawing::internal)?;
        Ok((files, values::data(py, &stats)?, written.warnings))
    }
}

/// Name, name of the value (nothing for a switch), help, heading, and whether the short help shows it, of every flag of a recipe.
#[pyfunction]
pub(crate) fn flags(with_all: bool) -> Vec<(String, String, String, String, bool)> {
    let tuple = |flag: Flag| (flag.name, flag.value_name, flag.help, flag.heading, flag.is_everyday);
    recipe::flags(with_all).into_iter().map(tuple).collect()
}
