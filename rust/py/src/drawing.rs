//! Drawing a photo, reading a drawing again, and the drawing as an object.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

use graphstipple_cli::files::{self, format_of_path};
use graphstipple_cli::plates::{self, is_for_each_ink};
use graphstipple_cli::writing::{Target, write_all};
use graphstipple_core::stages::{Ink, Source, Writer, draw_owned, named_length, raster};
use graphstipple_core::{Drawing as CoreDrawing, Error, Format, Outcome};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::{Map, Value as Json};

use crate::options::{self, Options};
use crate::photo::{Photo, Reading};
use crate::watch::Watch;
use crate::{arrays, errors, values, watch};

/// Draw a photo with an importance: the name of a source, or a map.
#[pyfunction]
#[pyo3(signature = (photo, importance, reading, options, progress=None))]
pub(crate) fn draw(
    py: Python<'_>,
    photo: &Photo,
    importance: &Bound<'_, PyAny>,
    reading: &Reading,
    options: &Options,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Drawing> {
    let (photo, source, options) = (photo.photo.clone(), source(importance)?, options.checked.clone());
    let reading = reading.reading.clone();
    let watch = Watch { threads: options.threads, progress };
    let (outcome, warning) = watch::run(py, watch, errors::from_files, move |control| {
        let mut seconds = BTreeMap::new();
        let evaluated = files::evaluate(source, None, photo.luma(), &reading, &mut seconds, control)?;
        let mut outcome = draw_owned(photo, evaluated.importance, &options, control)?;
        outcome.stats.add_seconds(seconds);
        Ok((outcome, evaluated.warning))
    })?;
    Drawing::of(outcome, warning)
}

/// A source of importance: the name of one, or a map.
pub(crate) fn source(given: &Bound<'_, PyAny>) -> PyResult<Source> {
    match given.cast::<Photo>() {
        Ok(map) => Ok(Source::Map(map.get().photo.clone())),
        Err(_) => Source::parse(&given.extract::<String>()?).map_err(errors::from_core),
    }
}

/// Read a drawing from a file that graphstipple wrote; its suffix says the format.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<Drawing> {
    let (drawing, stats) = watch::run(py, Watch::on(None), errors::from_files, move |control| {
        let drawing = files::load(&path, control)?;
        let stats = counts(&drawing);
        Ok((drawing, stats))
    })?;
    Ok(Drawing { drawing: Arc::new(drawing), stats, warnings: Vec::new(), outcome: None })
}

/// A drawing of what [`Drawing::packed`] gave.
#[pyfunction]
pub(crate) fn unpacked(py: Python<'_>, json: Vec<u8>, stats: &str, warnings: Vec<String>) -> PyResult<Drawing> {
    let damaged = |what: &dyn Display| errors::invalid(format!("the pickled drawing is damaged: {what}"));
    let stats = serde_json::from_str(stats).ok().filter(are_stats).ok_or_else(|| damaged(&"its stats are no numbers by name"))?;
    let format = Format::of_suffix(PACKED).map_err(errors::from_core)?;
    let drawing = watch::run(py, Watch::on(None), errors::from_core, move |control| {
        // What is wrong with it is no error of whoever waits.
        Ok(graphstipple_core::load(&json, format, control))
    })?;
    Ok(Drawing { drawing: Arc::new(drawing.map_err(|error| damaged(&error))?), stats, warnings, outcome: None })
}

/// Whether a table has numbers, words and nothing by name, and tables of them.
fn are_stats(table: &Map<String, Json>) -> bool {
    table.iter().all(|(name, value)| match value {
        Json::Object(seconds) => name == "seconds" && seconds.values().all(Json::is_number),
        value => name != "seconds" && !value.is_array(),
    })
}

/// The suffix of the format in which a drawing is packed.
const PACKED: &str = "json";

/// What `draw` and `load` make: `graphstipple.Drawing` wraps it.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Drawing {
    drawing: Arc<CoreDrawing>,
    stats: Map<String, Json>,
    warnings: Vec<String>,
    /// What the stages made on the way to the drawing. A drawing from a file has none of it.
    outcome: Option<Arc<Outcome>>,
}

impl Drawing {
    /// What the pipeline made, for Python.
    pub(crate) fn of(outcome: Outcome, of_map: Option<String>) -> PyResult<Self> {
        let Json::Object(stats) = serde_json::to_value(&outcome.stats).map_err(internal)? else {
            return Err(errors::from_core(Error::Internal("the stats are no table".to_owned())));
        };
        let warnings = of_map.into_iter().chain(outcome.warning.clone()).collect();
        Ok(Self { drawing: Arc::clone(&outcome.drawing), stats, warnings, outcome: Some(Arc::new(outcome)) })
    }
}

/// Inks by name with their colours, the paper's colour, and whether inks lie over each other.
type Palette = (Vec<(String, [u8; 3])>, [u8; 3], bool);

/// Circles (n, 3) and inks (n,) of the dots.
pub(crate) type StippleArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>);

/// Exterior, holes, area and ink of a region.
pub(crate) type RegionArrays<'py> = (Bound<'py, PyArray2<f64>>, Vec<Bound<'py, PyArray2<f64>>>, f64, u8);

/// Points (n, 2), the ring of every point (n,) and the area of every ring (m,); an area's first ring is its exterior.
type PolygonArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>);

/// Sites (n, 2), edges (m, 2), and tone, label and component of every node.
type GraphArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<u32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u32>>,
);

impl Drawing {
    /// The drawing itself, shared, and the number of its nodes.
    pub(crate) fn shared(&self) -> (Arc<CoreDrawing>, usize) {
        let nodes = self.stats.get("nodes").and_then(Json::as_u64).unwrap_or(0);
        (Arc::clone(&self.drawing), nodes as usize)
    }

    /// What drawing it left, if it was not changed since: a drawing from a file has no such thing.
    pub(crate) fn outcome(&self) -> Option<Arc<Outcome>> {
        self.outcome.clone().filter(|outcome| Arc::ptr_eq(&outcome.drawing, &self.drawing))
    }

    /// What was made of the drawing, with its [`counts`] and how many of what was changed.
    pub(crate) fn with_drawing<'a>(
        &self,
        drawing: CoreDrawing,
        counts: Map<String, Json>,
        changed: impl IntoIterator<Item = (&'a str, usize)>,
    ) -> Self {
        let mut stats = self.stats.clone();
        stats.extend(counts);
        stats.extend(changed.into_iter().map(|(name, count)| (name.to_owned(), count.into())));
        Self { drawing: Arc::new(drawing), stats, warnings: Vec::new(), outcome: self.outcome.clone() }
    }

    /// The same with one more entry in its stats.
    pub(crate) fn with_stat(&self, name: &str, value: Json) -> Self {
        let mut stats = self.stats.clone();
        stats.insert(name.to_owned(), value);
        Self { drawing: Arc::clone(&self.drawing), stats, warnings: self.warnings.clone(), outcome: self.outcome.clone() }
    }
}

#[pymethods]
impl Drawing {
    /// Width of the canvas in pixels.
    #[getter]
    fn width(&self) -> usize {
        self.drawing.width
    }

    /// Height of the canvas in pixels.
    #[getter]
    fn height(&self) -> usize {
        self.drawing.height
    }

    /// The bytes of the drawing's file of this suffix, with settings by name.
    fn encode<'py>(&self, py: Python<'py>, suffix: &str, settings: &Bound<'_, PyDict>) -> PyResult<Bound<'py, PyBytes>> {
        let writer = writer(Format::of_suffix(suffix).map_err(errors::from_core)?, settings)?;
        let drawing = Arc::clone(&self.drawing);
        let bytes = watch::run_core(py, None, move |_| writer.write(&drawing))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The drawing as grey values (height, width), or as colours (height, width, 3) if it has other inks than black, or of a part of it: left, top, right and bottom in pixels of the canvas.
    #[pyo3(signature = (width=None, part=None))]
    fn rasterize<'py>(&self, py: Python<'py>, width: Option<usize>, part: Option<[f64; 4]>) -> PyResult<Bound<'py, PyAny>> {
        let drawing = Arc::clone(&self.drawing);
        let raster = watch::run_core(py, None, move |_| match part {
            None => raster::rasterize(&drawing, width),
            // As large as it is on the canvas.
            Some(part) => {
                let width = width.unwrap_or_else(|| (part[2] - part[0]).round().max(1.0) as usize);
                raster::rasterize_part(&drawing, part, width)
            }
        })?;
        let rows = arrays::from_rows(py, [raster.height, raster.width * raster.channels], raster.values)?;
        if raster.channels == 1 {
            return Ok(rows.into_any());
        }
        Ok(PyArrayMethods::reshape(&rows, [raster.height, raster.width, raster.channels])?.into_any())
    }

    /// The inks as (name, (red, green, blue)), the paper's colour and whether inks lie over each other.
    #[getter]
    fn palette(&self) -> Palette {
        let palette = &self.drawing.palette;
        (palette.inks().iter().map(|ink| (ink.name.clone(), ink.rgb)).collect(), palette.paper(), palette.overprint())
    }

    /// The plate of an ink, by its number.
    fn plate(&self, py: Python<'_>, ink: usize) -> PyResult<Self> {
        let drawing = Arc::clone(&self.drawing);
        let plate = watch::run_core(py, None, move |_| drawing.plate(ink))?;
        Ok(Self { stats: counts(&plate), drawing: Arc::new(plate), warnings: Vec::new(), outcome: None })
    }

    /// Height and PNG of a part of the drawing, so many pixels wide, made as quickly as can be.
    fn picture<'py>(&self, py: Python<'py>, width: usize, part: [f64; 4]) -> PyResult<(usize, Bound<'py, PyBytes>)> {
        let drawing = Arc::clone(&self.drawing);
        let (height, png) = watch::run_core(py, None, move |_| {
            let raster = raster::rasterize_part(&drawing, part, width)?;
            Ok((raster.height, raster::encode_png_at_once(&raster)?))
        })?;
        Ok((height, PyBytes::new(py, &png)))
    }

    /// Write the drawing to a file, whole or not at all, with settings by name; its suffix says the format. A file that is read-only is
    /// overwritten by `force`. Returns a sentence for whoever wrote it, if there is something to say.
    fn save(&self, py: Python<'_>, path: PathBuf, settings: &Bound<'_, PyDict>, force: bool) -> PyResult<Option<String>> {
        let writer = writer(format_of_path(&path).map_err(errors::from_files)?, settings)?;
        let drawing = Arc::clone(&self.drawing);
        if is_for_each_ink(&path).map_err(errors::from_files)? {
            let (files, warning) =
                watch::run_core(py, None, move |_| Ok((plates::files(&path, &drawing, &writer)?, writer.warning(&drawing))))?;
            let found = files.into_iter().map(|(path, bytes)| Ok((Target::find(&path, force)?, bytes)));
            let files = found.collect::<graphstipple_cli::Result<_>>().map_err(errors::from_files)?;
            let mut failed = None;
            let pour = |target: Target, bytes: Vec<u8>| {
                // As a single one: whoever takes the bytes may be waited for.
                Python::attach(|py| write(py, target, bytes)).map_err(|error| {
                    failed = Some(error);
                    Error::Cancelled.into()
                })
            };
            let written = py.detach(|| write_all(files, pour));
            return match failed {
                Some(error) => Err(error),
                None => written.map(|()| warning).map_err(errors::from_files),
            };
        }
        let target = Target::find(&path, force).map_err(errors::from_files)?;
        let (bytes, warning) = watch::run_core(py, None, move |_| Ok((writer.write(&drawing)?, writer.warning(&drawing))))?;
        write(py, target, bytes)?;
        Ok(warning)
    }

    /// Width and height of the page and of the drawing on it, in a file of this suffix with settings by name: pixels of a PNG, else mm.
    /// `None` if the format has no size.
    fn sheet(&self, suffix: &str, settings: &Bound<'_, PyDict>) -> PyResult<Option<[f64; 4]>> {
        let writer = writer(Format::of_suffix(suffix).map_err(errors::from_core)?, settings)?;
        writer.sheet(self.drawing.width, self.drawing.height).map_err(errors::from_core)
    }

    /// The drawing with no dot smaller than this radius, a length, at the size that the settings say.
    fn with_min_dot(&self, py: Python<'_>, length: &Bound<'_, PyAny>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        let least = named_length("min_dot", &values::from_python(length)?).map_err(errors::from_core)?;
        // Sizes are the same on all paper.
        let writer = writer(Format::ALL[0], settings)?;
        let drawing = Arc::clone(&self.drawing);
        let (drawing, changes, counts) = watch::run_core(py, None, move |_| {
            let (drawing, changes) = drawing.with_least_radius(writer.least_radius(least, drawing.width, drawing.height)?)?;
            let counts = counts(&drawing);
            Ok((drawing, changes, counts))
        })?;
        let changed = [("dots_enlarged", changes.enlarged), ("dots_dropped", changes.dropped)];
        Ok(self.with_drawing(drawing, counts, changed))
    }

    /// What [`unpacked`] makes the drawing of again, without what its stages made: a JSON file, the stats and the warnings.
    fn packed<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyBytes>, String, Vec<String>)> {
        let json = self.encode(py, PACKED, &PyDict::new(py))?;
        Ok((json, serde_json::to_string(&self.stats).map_err(internal)?, self.warnings.clone()))
    }

    /// Sentences for whoever drew it, if there is something to say.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Counts and times by name.
    fn stats(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        values::table_of(py, self.stats.iter().map(|(name, value)| (name.as_str(), value)))
    }

    /// Version, importance and options, as they were written.
    fn provenance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        values::data(py, &serde_json::to_value(&self.drawing.provenance).map_err(internal)?)
    }

    /// The options that the drawing was made with, if this version knows them all.
    fn options(&self) -> PyResult<Options> {
        Ok(Options { checked: self.drawing.provenance.options().map_err(errors::from_core)? })
    }

    /// The dots: x, y, radius (n, 3) in pixels, and ink (n,).
    fn stipples<'py>(&self, py: Python<'py>) -> PyResult<StippleArrays<'py>> {
        stipple_arrays(py, &self.drawing)
    }

    /// Number of regions.
    #[getter]
    fn region_count(&self) -> usize {
        self.drawing.regions.len()
    }

    /// Number of dots.
    #[getter]
    fn stipple_count(&self) -> usize {
        self.drawing.stipples.len()
    }

    /// Exterior (n, 2), holes (m, 2) each, area in px^2 and ink of a region, its curves flattened.
    fn region<'py>(&self, py: Python<'py>, index: usize) -> PyResult<RegionArrays<'py>> {
        region_arrays(py, &self.drawing, index)
    }

    /// All areas of an ink (0 black, 1 white) as polygons: its regions, then its dots.
    fn polygons<'py>(&self, py: Python<'py>, ink: u8) -> PyResult<PolygonArrays<'py>> {
        let drawing = Arc::clone(&self.drawing);
        let polygons = watch::run_core(py, None, move |_| Ok(Polygons::of(&drawing, Ink::of_label(ink))))?;
        Ok((
            arrays::from_pairs(py, polygons.points)?,
            polygons.ring_of_point.into_pyarray(py),
            polygons.area_of_ring.into_pyarray(py),
        ))
    }

    /// The second graph; `None` for a drawing from a file.
    fn graph<'py>(&self, py: Python<'py>) -> PyResult<Option<GraphArrays<'py>>> {
        let Some(stages) = &self.outcome else { return Ok(None) };
        let sites = stages.graph.sites.iter().map(|site| site.map(|v| v * stages.factor as f64)).collect();
        Ok(Some((
            arrays::from_pairs(py, sites)?,
            arrays::from_pairs(py, stages.graph.edges().collect())?,
            stages.cells.means.clone().into_pyarray(py),
            stages.labels.labels.clone().into_pyarray(py),
            stages.components.ids.clone().into_pyarray(py),
        )))
    }

    /// Importance on the canvas, (height, width); `None` for a drawing from a file.
    fn importance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let Some(stages) = &self.outcome else { return Ok(None) };
        let (importance, factor) = (Arc::clone(&stages.importance), stages.factor);
        let (width, height) = (self.drawing.width, self.drawing.height);
        let field = watch::run_core(py, None, move |_| importance.on_canvas(width, height, factor))?;
        arrays::from_field(py, field).map(Some)
    }
}

/// Writes the bytes of a file.
pub(crate) fn write(py: Python<'_>, target: Target, bytes: Vec<u8>) -> PyResult<()> {
    if target.is_stream() {
        return watch::run(py, Watch::on(Some(1)), errors::from_files, move |_| target.write(&bytes));
    }
    // Not on a watched worker: an interrupt would leave a half-written file's fate to a thread that nobody waits for.
    py.detach(|| target.write(&bytes)).map_err(errors::from_files)
}

/// Areas of one ink as polygons, flat.
#[derive(Default)]
struct Polygons {
    points: Vec<[f64; 2]>,
    ring_of_point: Vec<u32>,
    area_of_ring: Vec<u32>,
}

impl Polygons {
    fn of(drawing: &CoreDrawing, ink: Ink) -> Self {
        let mut polygons = Self::default();
        let mut area = 0;
        for index in (0..drawing.regions.len()).filter(|i| drawing.regions[*i].ink == ink) {
            let (exterior, holes) = drawing.region_rings(index);
            polygons.push(area, exterior);
            holes.into_iter().for_each(|hole| polygons.push(area, hole));
            area += 1;
        }
        for index in (0..drawing.stipples.len()).filter(|i| drawing.stipples[*i].ink == ink) {
            polygons.push(area, drawing.stipple_outline(index, drawing.flattening_tolerance()));
            area += 1;
        }
        polygons
    }

    fn push(&mut self, area: u32, ring: Vec<[f64; 2]>) {
        self.ring_of_point.extend(std::iter::repeat_n(self.area_of_ring.len() as u32, ring.len()));
        self.area_of_ring.push(area);
        self.points.extend(ring);
    }
}

/// What a drawing itself tells: its size and what is in it.
pub(crate) fn counts(drawing: &CoreDrawing) -> Map<String, Json> {
    let (anchors, coordinates) = drawing.count_written();
    let counts = [
        ("width", drawing.width),
        ("height", drawing.height),
        ("stipples", drawing.stipples.len()),
        ("regions", drawing.regions.len()),
        ("anchors", anchors),
        ("coordinates", coordinates),
    ];
    counts.into_iter().map(|(name, count)| (name.to_owned(), count.into())).collect()
}

/// All dots of a drawing.
pub(crate) fn stipple_arrays<'py>(py: Python<'py>, drawing: &CoreDrawing) -> PyResult<StippleArrays<'py>> {
    let stipples = &drawing.stipples;
    let circles = stipples.iter().flat_map(|dot| [dot.x, dot.y, dot.radius]).collect();
    let inks: Vec<u8> = stipples.iter().map(|dot| dot.ink.label()).collect();
    Ok((arrays::from_rows(py, [stipples.len(), 3], circles)?, inks.into_pyarray(py)))
}

/// One region of a drawing, flattened.
pub(crate) fn region_arrays<'py>(py: Python<'py>, drawing: &CoreDrawing, index: usize) -> PyResult<RegionArrays<'py>> {
    let Some(region) = drawing.regions.get(index) else {
        return Err(errors::invalid(format!("there is no region {index}: the drawing has {}", drawing.regions.len())));
    };
    let (exterior, holes) = drawing.region_rings(index);
    let holes = holes.into_iter().map(|hole| arrays::from_pairs(py, hole)).collect::<PyResult<_>>()?;
    Ok((arrays::from_pairs(py, exterior)?, holes, drawing.region_area(index), region.ink.label()))
}

/// What writes drawings in a format with these settings.
pub(crate) fn writer(format: Format, settings: &Bound<'_, PyDict>) -> PyResult<Writer> {
    format.writer(options::export(settings)?).map_err(errors::from_core)
}

pub(crate) fn internal(error: serde_json::Error) -> PyErr {
    errors::from_core(Error::Internal(error.to_string()))
}
