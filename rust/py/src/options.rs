//! Options, checked once when they are made; presets; the settings of files.

use graphstipple_core::stages::{Audience, Checked, DECLARATIONS, Group, KINDS, PUBLISHED, SETTINGS, Setting, preset, schema};
use graphstipple_core::{Export, Format, Options as CoreOptions, presets as core_presets};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::{errors, values};

/// Options whose every value was found to be in its range: `graphstipple.Options` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Options {
    pub(crate) checked: Checked<CoreOptions>,
}

#[pymethods]
impl Options {
    /// Options of these values, the defaults where there are none. Those of the published method, `published.NAME`, are taken from
    /// other options where they are given.
    #[new]
    #[pyo3(signature = (values, published=None))]
    fn new(values: &Bound<'_, PyDict>, published: Option<&Self>) -> PyResult<Self> {
        let mut options = CoreOptions::default();
        if let Some(given) = published {
            options.published = given.checked.published;
        }
        for (name, value) in values {
            options.set(&name.extract::<String>()?, &values::from_python(&value)?).map_err(errors::from_core)?;
        }
        Ok(Self { checked: options.check().map_err(errors::from_core)? })
    }

    /// All values by name.
    fn values(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        values_of(py, &self.checked)
    }

    /// How many nodes a drawing on a canvas of this size may come to have.
    fn most_nodes(&self, width: usize, height: usize) -> f64 {
        self.checked.most_nodes(width as f64 * height as f64)
    }

    /// By how much a photo of this size is reduced for a drawing.
    fn reduction(&self, width: usize, height: usize) -> usize {
        self.checked.reduction(width, height)
    }

    /// The same drawing asked for more coarsely, where it may have more than so many nodes on a canvas of this size.
    fn with_at_most(&self, nodes: u64, width: usize, height: usize) -> PyResult<Self> {
        let coarse = self.checked.with_at_most(nodes, width as f64 * height as f64).into_owned();
        Ok(Self { checked: coarse.check().map_err(errors::from_core)? })
    }

    /// Whether a drawing needs the colour of its photo.
    fn wants_colour(&self) -> bool {
        self.checked.wants_colour()
    }

    /// The colour (R, G, B) of the background.
    #[getter]
    fn background(&self) -> (u8, u8, u8) {
        self.checked.background.rgb().into()
    }
}

/// The values of options by name; those of the published method in a table of their own.
fn values_of(py: Python<'_>, options: &CoreOptions) -> PyResult<Py<PyDict>> {
    let (plain, method) = (PyDict::new(py), PyDict::new(py));
    for declaration in DECLARATIONS {
        let table = if declaration.group == Group::Method { &method } else { &plain };
        table.set_item(declaration.name, values::to_python(py, &declaration.value(options))?)?;
    }
    plain.set_item(PUBLISHED, method)?;
    Ok(plain.unbind())
}

/// The options of the preset of a name.
#[pyfunction]
#[pyo3(name = "preset")]
pub(crate) fn of_preset(name: &str) -> PyResult<Options> {
    let checked = preset(name).and_then(|preset| preset.options.check()).map_err(errors::from_core)?;
    Ok(Options { checked })
}

/// Name, description and inks of every preset.
#[pyfunction]
pub(crate) fn presets() -> Vec<(&'static str, &'static str, String)> {
    core_presets().into_iter().map(|preset| (preset.name, preset.description, preset.only.to_string())).collect()
}

/// The options as a JSON schema, as data.
#[pyfunction]
pub(crate) fn options_schema(py: Python<'_>) -> PyResult<Py<PyAny>> {
    values::data(py, &schema())
}

/// A setting: name, what it does, default, the suffixes of the formats that take it, whether the short help shows it, what its value is
/// called (nothing for a switch), and the words that it takes.
type SettingTuple = (&'static str, &'static str, &'static str, Vec<&'static str>, bool, &'static str, Vec<&'static str>);

/// Every setting of how a file is written.
#[pyfunction]
pub(crate) fn settings() -> Vec<SettingTuple> {
    let takers = |name| Format::ALL.iter().filter(|format| format.settings.contains(&name)).map(|format| format.suffix).collect();
    let tuple = |setting: &Setting| {
        let is_everyday = setting.audience == Audience::Everyday;
        let words = if setting.value_name.is_empty() { Vec::new() } else { setting.words().collect() };
        (setting.name, setting.sentence, setting.default, takers(setting.name), is_everyday, setting.value_name, words)
    };
    SETTINGS.iter().map(tuple).collect()
}

/// Every format: suffix, name, what it holds, and whether a file of it gives the drawing back.
#[pyfunction]
pub(crate) fn formats() -> Vec<(&'static str, &'static str, &'static str, bool)> {
    Format::ALL.iter().map(|format| (format.suffix, format.name, format.holds, format.can_be_read())).collect()
}

/// Every kind of source of importance: its form, and what it stands for.
#[pyfunction]
pub(crate) fn sources() -> Vec<(&'static str, &'static str)> {
    KINDS.iter().map(|kind| (kind.form, kind.sentence)).collect()
}

/// How a file is written, from settings by name.
pub(crate) fn export(settings: &Bound<'_, PyDict>) -> PyResult<Checked<Export>> {
    let mut export = Export::default();
    for (name, value) in settings {
        export.set(&name.extract::<String>()?, &values::from_python(&value)?).map_err(errors::from_core)?;
    }
    export.check().map_err(errors::from_core)
}
