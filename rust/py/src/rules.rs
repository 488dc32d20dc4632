//! The rules of a process, what of a drawing breaks them, and a drawing that keeps them.

use std::path::PathBuf;
use std::sync::Arc;

use graphstipple_cli::files::suffix_of_report;
use graphstipple_cli::writing::Target;
use graphstipple_core::Drawing as CoreDrawing;
use graphstipple_core::stages::{self, Checked, PROCESSES, RULES, Report as CoreReport, ReportFormat, Value};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::Value as Json;

use crate::drawing::{Drawing, counts, internal};
use crate::options::export;
use crate::watch::Watch;
use crate::{errors, values, watch};

/// Rules that are checked.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Rules {
    rules: Checked<stages::Rules>,
}

#[pymethods]
impl Rules {
    /// Rules by name.
    #[new]
    fn new(given: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut rules = stages::Rules::default();
        for (name, value) in given {
            rules.set(&name.extract::<String>()?, &values::from_python(&value)?).map_err(errors::from_core)?;
        }
        Ok(Self { rules: rules.check().map_err(errors::from_core)? })
    }

    /// The rules of a process.
    #[staticmethod]
    fn of_process(name: &str) -> PyResult<Self> {
        let rules = stages::Rules::of_process(name).and_then(stages::Rules::check).map_err(errors::from_core)?;
        Ok(Self { rules })
    }

    /// Every rule by name: a length or an area with its unit, a word, or `None`.
    fn values(&self) -> Vec<(&'static str, Option<String>)> {
        let text = |value: Value, unit: &str| match value {
            Value::Number(number) => Some(format!("{number}{unit}")),
            Value::Word(word) => Some(word),
            _ => None,
        };
        RULES.iter().map(|rule| (rule.name, text((rule.value)(&self.rules), rule.unit()))).collect()
    }
}

/// The processes that there are rules for: name, and what it asks for.
#[pyfunction]
pub(crate) fn processes() -> Vec<(&'static str, &'static str)> {
    PROCESSES.iter().map(|process| (process.name, process.sentence)).collect()
}

/// What of a drawing breaks rules at the size that the settings say.
#[pyfunction]
pub(crate) fn check(py: Python<'_>, drawing: &Drawing, rules: &Rules, settings: &Bound<'_, PyDict>) -> PyResult<Report> {
    let (drawing, rules, export) = (drawing.shared().0, rules.rules.clone(), export(settings)?);
    let checked = Arc::clone(&drawing);
    let report = watch::run_core(py, None, move |control| {
        let scale = export.layout.mm_per_pixel(checked.width, checked.height)?;
        stages::check(&checked, &rules, scale, control)
    })?;
    Ok(Report { report: Arc::new(report), drawing })
}

/// The drawing as the rules allow it at the size that the settings say, and what was done to it, by name.
#[pyfunction]
pub(crate) fn enforce(
    py: Python<'_>,
    drawing: &Drawing,
    rules: &Rules,
    settings: &Bound<'_, PyDict>,
) -> PyResult<(Drawing, Py<PyAny>)> {
    let (given, outcome) = (drawing.shared().0, drawing.outcome());
    let (rules, export) = (rules.rules.clone(), export(settings)?);
    let (made, changes, counts) = watch::run_core(py, None, move |control| {
        let scale = export.layout.mm_per_pixel(given.width, given.height)?;
        let (made, changes) = stages::enforce(&given, outcome.as_deref(), &rules, scale, control)?;
        let counts = counts(&made);
        Ok((made, changes, counts))
    })?;
    let dots = [("dots_enlarged", changes.dots_enlarged), ("dots_dropped", changes.dots_dropped)];
    let told = values::data(py, &serde_json::to_value(changes).map_err(internal)?)?;
    Ok((drawing.with_drawing(made, counts, dots), told))
}

/// What breaks rules: `graphstipple.Report` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Report {
    report: Arc<CoreReport>,
    drawing: Arc<CoreDrawing>,
}

/// A violation: kind, place, what was measured, its limit, and how long it is.
type Violation = (&'static str, f64, f64, f64, f64, f64);

#[pymethods]
impl Report {
    /// Width and height of the drawing in mm.
    #[getter]
    fn size(&self) -> (f64, f64) {
        (self.report.width, self.report.height)
    }

    /// How many violations of every kind there are.
    fn counts(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        values::data(py, &Json::Object(self.report.counts()))
    }

    /// All violations.
    fn violations(&self) -> Vec<Violation> {
        let of = |it: &stages::Violation| (it.kind.name(), it.x, it.y, it.measured, it.limit, it.length);
        self.report.violations.iter().map(of).collect()
    }

    /// The bytes of the report's file of this suffix.
    fn encode<'py>(&self, py: Python<'py>, suffix: &str) -> PyResult<Bound<'py, PyBytes>> {
        let format = ReportFormat::of_suffix(suffix).map_err(errors::from_core)?;
        let (report, drawing) = (Arc::clone(&self.report), Arc::clone(&self.drawing));
        let bytes = watch::run_core(py, None, move |_| report.write(format, &drawing))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Write the report to a file, whole or not at all; its suffix says the format.
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let format = suffix_of_report(&path).map_err(errors::from_files)?;
        let target = Target::find(&path, force).map_err(errors::from_files)?;
        let (report, drawing) = (Arc::clone(&self.report), Arc::clone(&self.drawing));
        let bytes = watch::run(py, Watch::on(None), errors::from_core, move |_| report.write(format, &drawing))?;
        crate::drawing::write(py, target, bytes)
    }
}
