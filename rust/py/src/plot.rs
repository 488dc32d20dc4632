//! A drawing as paths for a pen, and the plot as an object.

use std::path::PathBuf;
use std::sync::Arc;

use graphstipple_cli::files::suffix_of_plot;
use graphstipple_cli::machines::machine;
use graphstipple_cli::writing::Target;
use graphstipple_core::Error;
use graphstipple_core::stages::{Machine, MachineFormat, PEN_SETTINGS, Pen, Plot as CorePlot, picture, plot};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::drawing::{Drawing, internal};
use crate::options::export;
use crate::watch::Watch;
use crate::{arrays, errors, values, watch};

/// The paths of a drawing for a pen, with settings of the pen and of the file by name.
#[pyfunction]
#[pyo3(name = "plot")]
pub(crate) fn of_drawing(
    py: Python<'_>,
    drawing: &Drawing,
    pen: &Bound<'_, PyDict>,
    settings: &Bound<'_, PyDict>,
) -> PyResult<Plot> {
    let mut given = Vec::with_capacity(pen.len());
    for (name, value) in pen {
        given.push((name.extract::<String>()?, values::from_python(&value)?));
    }
    let width = given.iter().find(|(name, _)| name == "pen").map(|(_, value)| value.clone());
    let width = width.ok_or_else(|| errors::invalid("a plot needs the width of its pen".to_owned()))?;
    let mut pen = Pen::of_width(&width).map_err(in_arguments)?;
    for (name, value) in given {
        pen.set(&name, &value).map_err(in_arguments)?;
    }
    let (pen, export, drawing) = (pen.check().map_err(in_arguments)?, export(settings)?, drawing.shared().0);
    let plot = watch::run(py, Watch::on(None), in_arguments, move |control| plot(&drawing, &pen, &export, control))?;
    Ok(Plot { plot: Arc::new(plot) })
}

/// A core error with the names of Python's arguments, which need not say that they are a pen's.
fn in_arguments(error: Error) -> PyErr {
    errors::from_core(match error {
        Error::Option { option, value, allowed } => {
            Error::Option { option: option.strip_prefix("pen_").map_or(option.clone(), str::to_owned), value, allowed }
        }
        other => other,
    })
}

/// The settings of a pen: name, what it does, default, and what its value is called.
#[pyfunction]
pub(crate) fn pen_settings() -> Vec<(&'static str, &'static str, &'static str, &'static str)> {
    PEN_SETTINGS.iter().map(|setting| (setting.name, setting.sentence, setting.default, setting.value_name)).collect()
}

/// The machines whose profiles come with the program: name, what it is, and the profile.
#[pyfunction]
pub(crate) fn machines() -> Vec<(&'static str, &'static str, &'static str)> {
    Machine::SHIPPED.iter().map(|profile| (profile.name, profile.description, profile.toml)).collect()
}

/// Paths for pens: `graphstipple.Plot` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Plot {
    plot: Arc<CorePlot>,
}

/// A layer: its ink, all points (n, 2) and where each path ends among them.
type LayerArrays<'py> = (u8, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u64>>);

#[pymethods]
impl Plot {
    /// The paths of every layer, those that are closed with their first point again at the end.
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Vec<LayerArrays<'py>>> {
        let mut layers = Vec::with_capacity(self.plot.layers.len());
        for layer in &self.plot.layers {
            let (mut points, mut ends) = (Vec::new(), Vec::with_capacity(layer.paths.len()));
            for path in &layer.paths {
                points.extend_from_slice(&path.points);
                points.extend(path.is_closed.then(|| path.points.first().copied()).flatten());
                ends.push(points.len() as u64);
            }
            layers.push((layer.ink.label(), arrays::from_pairs(py, points)?, ends.into_pyarray(py)));
        }
        Ok(layers)
    }

    /// Width of the pen, then width and height of the drawing, width and height of the page, and the drawing's corner on it, in mm.
    #[getter]
    fn sizes(&self) -> (f64, [f64; 2], [f64; 2], [f64; 2]) {
        (self.plot.pen, self.plot.size, self.plot.page, self.plot.origin)
    }

    /// What is counted and measured, and the time of a machine.
    fn stats(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let machine = machine(name).map_err(errors::from_files)?;
        let plot = Arc::clone(&self.plot);
        let stats = watch::run_core(py, None, move |_| Ok(plot.stats(&machine)))?;
        values::data(py, &serde_json::to_value(stats).map_err(internal)?)
    }

    /// The bytes of a file of this suffix, for a machine.
    #[pyo3(signature = (suffix, machine_name=None))]
    fn encode<'py>(&self, py: Python<'py>, suffix: &str, machine_name: Option<&str>) -> PyResult<Bound<'py, PyBytes>> {
        let format = MachineFormat::of_suffix(suffix).map_err(errors::from_core)?;
        let machine = machine_name.map(machine).transpose().map_err(errors::from_files)?;
        let plot = Arc::clone(&self.plot);
        let bytes = watch::run_core(py, None, move |_| plot.write(format, machine.as_ref()))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Write the plot to a file, whole or not at all; its suffix says the format.
    fn save(&self, py: Python<'_>, path: PathBuf, machine_name: Option<&str>, force: bool) -> PyResult<()> {
        let format = suffix_of_plot(&path).map_err(errors::from_files)?;
        let machine = machine_name.map(machine).transpose().map_err(errors::from_files)?;
        let target = Target::find(&path, force).map_err(errors::from_files)?;
        let plot = Arc::clone(&self.plot);
        let bytes = watch::run_core(py, None, move |_| plot.write(format, machine.as_ref()))?;
        crate::drawing::write(py, target, bytes)
    }

    /// What the pens draw as grey values (height, width).
    #[pyo3(signature = (width=None))]
    fn rasterize<'py>(&self, py: Python<'py>, width: Option<usize>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let plot = Arc::clone(&self.plot);
        let raster = watch::run_core(py, None, move |_| picture(&plot, width))?;
        arrays::from_rows(py, [raster.height, raster.width], raster.values)
    }
}
