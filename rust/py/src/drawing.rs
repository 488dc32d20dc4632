//! Drawing a photo, and the drawing as an object.

use std::path::PathBuf;
use std::sync::Arc;

use graphstipple_cli::files;
use graphstipple_core::importance::{Importance, Source};
use graphstipple_core::{Error, Outcome, drawing as core_drawing, pipeline, raster, svg};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::{arrays, errors, options, watch};

/// Draw luma (height, width) with an importance: "saliency" or "map" with the map, or the name of a constant.
#[pyfunction]
#[pyo3(signature = (luma, importance, importance_map, options_json, progress=None))]
pub(crate) fn draw(
    py: Python<'_>,
    luma: PyReadonlyArray2<'_, f32>,
    importance: &str,
    importance_map: Option<PyReadonlyArray2<'_, f32>>,
    options_json: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Drawing> {
    let options = options::parse(options_json)?;
    let luma = arrays::field(&luma)?;
    let map = importance_map.as_ref().map(arrays::field).transpose()?;
    let importance = match (importance, map) {
        ("saliency", Some(map)) => Importance::Saliency(map),
        ("map", Some(map)) => Importance::Map(map),
        (name, None) => match Source::parse(name).map_err(errors::from_core)? {
            Source::Constant(value) => Importance::Constant(value),
            _ => return Err(errors::invalid(format!("the importance \"{name}\" needs a map"))),
        },
        (name, Some(_)) => return Err(errors::invalid(format!("the importance \"{name}\" takes no map"))),
    };
    let outcome =
        watch::run(py, progress, errors::from_core, move |control| pipeline::draw(&luma, &importance, &options, control))?;
    Ok(Drawing { outcome: Arc::new(outcome) })
}

/// What `draw` made: `graphstipple.Drawing` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Drawing {
    outcome: Arc<Outcome>,
}

/// Circles (n, 3) and inks (n,) of the dots.
pub(crate) type StippleArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>);

/// Exterior, holes, area and ink of a region.
pub(crate) type RegionArrays<'py> = (Bound<'py, PyArray2<f64>>, Vec<Bound<'py, PyArray2<f64>>>, f64, u8);

#[pymethods]
impl Drawing {
    /// Width of the canvas in pixels.
    #[getter]
    fn width(&self) -> usize {
        self.outcome.drawing.width
    }

    /// Height of the canvas in pixels.
    #[getter]
    fn height(&self) -> usize {
        self.outcome.drawing.height
    }

    /// The drawing as an SVG document.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        let outcome = Arc::clone(&self.outcome);
        watch::run_core(py, move |_| Ok(svg::to_svg(&outcome.drawing)))
    }

    /// The drawing as grey values (height, width).
    #[pyo3(signature = (width=None))]
    fn rasterize<'py>(&self, py: Python<'py>, width: Option<usize>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let outcome = Arc::clone(&self.outcome);
        let raster = watch::run_core(py, move |_| raster::rasterize(&outcome.drawing, width))?;
        arrays::from_rows(py, [raster.height, raster.width], raster.values)
    }

    /// The drawing as the bytes of a PNG file.
    #[pyo3(signature = (width=None))]
    fn png<'py>(&self, py: Python<'py>, width: Option<usize>) -> PyResult<Bound<'py, PyBytes>> {
        let outcome = Arc::clone(&self.outcome);
        let bytes = watch::run_core(py, move |_| raster::encode_png(&raster::rasterize(&outcome.drawing, width)?))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Write the drawing to a file, whole or not at all; the suffix says how.
    // Not on a watched worker: an interrupt would leave a half-written file's fate to a thread that nobody waits for.
    #[pyo3(signature = (path, width=None))]
    fn save(&self, py: Python<'_>, path: PathBuf, width: Option<usize>) -> PyResult<()> {
        py.detach(|| files::save(&self.outcome.drawing, &path, width)).map_err(errors::from_files)
    }

    /// Counts and times as JSON.
    fn stats(&self) -> PyResult<String> {
        to_json(&self.outcome.stats)
    }

    /// Version, importance and options as JSON.
    fn provenance(&self) -> PyResult<String> {
        to_json(&self.outcome.drawing.provenance)
    }

    /// The dots: x, y, radius (n, 3) in pixels, and ink (n,).
    fn stipples<'py>(&self, py: Python<'py>) -> PyResult<StippleArrays<'py>> {
        stipple_arrays(py, &self.outcome.drawing)
    }

    /// Number of regions.
    #[getter]
    fn region_count(&self) -> usize {
        self.outcome.drawing.regions.len()
    }

    /// Exterior (n, 2), holes (m, 2) each, area in px^2 and ink of a region, its curves flattened.
    fn region<'py>(&self, py: Python<'py>, index: usize) -> PyResult<RegionArrays<'py>> {
        region_arrays(py, &self.outcome.drawing, index)
    }

    /// Position of every node, (n, 2).
    fn sites<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::from_pairs(py, self.outcome.graph.sites.clone())
    }

    /// Every edge once, (m, 2), lower node first.
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        arrays::from_pairs(py, self.outcome.graph.edges().collect())
    }

    /// Tone of every node.
    fn tone<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.outcome.tone.clone().into_pyarray(py)
    }

    /// Label of every node.
    fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        self.outcome.labels.clone().into_pyarray(py)
    }

    /// Component of every node.
    fn components<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.outcome.components.clone().into_pyarray(py)
    }

    /// Importance on the canvas, (height, width).
    fn importance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        arrays::from_field(py, self.outcome.importance.clone())
    }
}

/// All dots of a drawing.
pub(crate) fn stipple_arrays<'py>(py: Python<'py>, drawing: &core_drawing::Drawing) -> PyResult<StippleArrays<'py>> {
    let stipples = &drawing.stipples;
    let circles = stipples.iter().flat_map(|dot| [dot.x, dot.y, dot.radius]).collect();
    let inks: Vec<u8> = stipples.iter().map(|dot| dot.ink as u8).collect();
    Ok((arrays::from_rows(py, [stipples.len(), 3], circles)?, inks.into_pyarray(py)))
}

/// One region of a drawing, flattened.
pub(crate) fn region_arrays<'py>(py: Python<'py>, drawing: &core_drawing::Drawing, index: usize) -> PyResult<RegionArrays<'py>> {
    let Some(region) = drawing.regions.get(index) else {
        return Err(errors::invalid(format!("there is no region {index}: the drawing has {}", drawing.regions.len())));
    };
    let (exterior, holes) = drawing.region_rings(index, core_drawing::FLATTENING_TOLERANCE);
    let holes = holes.into_iter().map(|hole| arrays::from_pairs(py, hole)).collect::<PyResult<_>>()?;
    Ok((arrays::from_pairs(py, exterior)?, holes, drawing.region_area(index), region.ink as u8))
}

fn to_json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| errors::from_core(Error::Internal(error.to_string())))
}
