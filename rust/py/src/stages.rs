//! The stages of the method, each on arrays: thin covers of the core's functions for `graphstipple.stages`.

use graphstipple_core::stages::{self as core, Diffusion, Graph, Lattice, Nodes, Refinement, Shaping, Stippled, Tones};
use graphstipple_core::{Field, Importance, Options as CoreOptions, Photo};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::drawing::{RegionArrays, StippleArrays, region_arrays, stipple_arrays};
use crate::options::Options;
use crate::{arrays, errors, watch};

/// Sites (n, 2) and edges (m, 2).
type GraphArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// Sites (n, 2), labels (n,) and the factor on the importance.
type LabelArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>, f64);

/// Areas (n,), centroids (n, 2), means (n,) and counts (n,) of cells.
type CellArrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<u32>>);

/// The lattice that the options ask for.
#[pyfunction]
pub(crate) fn lattice<'py>(py: Python<'py>, width: usize, height: usize, options: &Options) -> PyResult<GraphArrays<'py>> {
    let options = options.checked.clone();
    let (sites, edges) = watch::run_core(py, options.threads, move |_| {
        let density = options.budget(width as f64 * height as f64).density;
        let graph = Lattice::new(options.published.lattice, width, height, density)?.to_graph();
        let edges: Vec<[u32; 2]> = graph.edges().collect();
        Ok((graph.sites, edges))
    })?;
    Ok((arrays::from_pairs(py, sites)?, arrays::from_pairs(py, edges)?))
}

/// How far apart the nodes are that the options keep on the canvas of a tone, in pixels.
fn spacing(tone: &Field, options: &CoreOptions) -> f64 {
    options.budget((tone.width() * tone.height()) as f64).spacing
}

/// The emphasized tone, with the spacing that the options come to.
#[pyfunction]
pub(crate) fn emphasize<'py>(
    py: Python<'py>,
    tone: PyReadonlyArray2<'py, f32>,
    options: &Options,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let options = options.checked.clone();
    let tone = arrays::field(&tone)?;
    let emphasized = watch::run_core(py, options.threads, move |_| Ok(core::emphasize(&tone, spacing(&tone, &options), &options)))?;
    arrays::from_field(py, emphasized)
}

/// The importance with the photo's detail mixed in: a saliency map, or a user's map if `is_factor`.
#[pyfunction]
pub(crate) fn mixed_importance<'py>(
    py: Python<'py>,
    tone: PyReadonlyArray2<'py, f32>,
    given: PyReadonlyArray2<'py, f32>,
    is_factor: bool,
    options: &Options,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let options = options.checked.clone();
    let (tone, map) = (arrays::field(&tone)?, arrays::field(&given)?);
    let mixed = watch::run_core(py, options.threads, move |_| {
        let spacing = spacing(&tone, &options);
        let emphasized = core::emphasize(&tone, spacing, &options);
        let importance = if is_factor { Importance::Map(Photo::new(map)) } else { Importance::saliency(map) };
        importance.mixed(&tone, &emphasized, spacing, &options)
    })?;
    arrays::from_field(py, mixed)
}

/// Sites and labels of the lattice diffused on importance, and the factor that meets the node budget.
#[pyfunction]
pub(crate) fn lattice_labels<'py>(
    py: Python<'py>,
    importance: PyReadonlyArray2<'py, f32>,
    options: &Options,
) -> PyResult<LabelArrays<'py>> {
    let options = options.checked.clone();
    let importance = arrays::field(&importance)?;
    let first = watch::run_core(py, options.threads, move |control| core::first_graph(&importance, &options, control))?;
    Ok((arrays::from_pairs(py, first.lattice.sites())?, first.labels.into_pyarray(py), first.factor))
}

/// Samples a pixel, along one axis, for nodes of this density.
#[pyfunction]
pub(crate) fn samples_per_pixel(density: f64) -> usize {
    core::samples_per_pixel(density)
}

/// Areas, centroids, means of a field and sample counts of the sites' cells.
#[pyfunction]
pub(crate) fn cells<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    width: usize,
    height: usize,
    field: Option<PyReadonlyArray2<'py, f32>>,
    samples_per_pixel: usize,
) -> PyResult<CellArrays<'py>> {
    let sites = arrays::pairs("sites", &sites)?;
    let field = field.as_ref().map(arrays::field).transpose()?;
    let cells =
        watch::run_core(py, None, move |control| core::cells(&sites, width, height, samples_per_pixel, field.as_ref(), control))?;
    Ok((
        cells.areas.into_pyarray(py),
        arrays::from_pairs(py, cells.centroids)?,
        cells.means.into_pyarray(py),
        cells.counts.into_pyarray(py),
    ))
}

/// The nearest site of every sample.
#[pyfunction]
pub(crate) fn owners<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    width: usize,
    height: usize,
    samples_per_pixel: usize,
) -> PyResult<Bound<'py, PyArray2<u32>>> {
    let sites = arrays::pairs("sites", &sites)?;
    let owners = watch::run_core(py, None, move |control| core::owners(&sites, width, height, samples_per_pixel, control))?;
    arrays::from_rows(py, [height * samples_per_pixel, width * samples_per_pixel], owners)
}

/// The sites after Lloyd steps.
#[pyfunction]
pub(crate) fn relax<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    width: usize,
    height: usize,
    steps: u32,
    samples_per_pixel: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let sites = arrays::pairs("sites", &sites)?;
    let relaxed = watch::run_core(py, None, move |control| core::relax(sites, width, height, steps, samples_per_pixel, control))?;
    arrays::from_pairs(py, relaxed)
}

/// The Delaunay edges of sites on a canvas.
#[pyfunction]
pub(crate) fn triangulate<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyArray2<u32>>> {
    let sites = arrays::pairs("sites", &sites)?;
    let edges = watch::run_core(py, None, move |control| {
        Ok(core::triangulate(sites, width, height, control)?.graph.edges().collect::<Vec<_>>())
    })?;
    arrays::from_pairs(py, edges)
}

/// Labels of the nodes by priority error diffusion, with the options of the tone's diffusion.
#[pyfunction]
pub(crate) fn diffuse<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    edges: PyReadonlyArray2<'py, u32>,
    values: PyReadonlyArray1<'py, f32>,
    areas: Option<PyReadonlyArray1<'py, f64>>,
    options: &Options,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let parameters = Diffusion::of_tone(&options.checked);
    let (sites, edges) = (arrays::pairs("sites", &sites)?, arrays::pairs("edges", &edges)?);
    let (values, areas) = (arrays::values(&values), areas.as_ref().map(arrays::values));
    let labels = watch::run_core(py, options.checked.threads, move |control| {
        core::diffuse(&Graph::from_edges(sites, &edges)?, &values, areas.as_deref(), &parameters, control)
    })?;
    Ok(labels.into_pyarray(py))
}

/// The graph of these edges, for stages that ask who is connected, not where: any positions will do.
fn graph_anywhere(nodes: usize, edges: &[[u32; 2]]) -> graphstipple_core::Result<Graph> {
    Graph::from_edges(vec![[0.0; 2]; nodes], edges)
}

/// Labels changed by a stage that asks for edges and tones alone.
fn relabelled<'py>(
    py: Python<'py>,
    edges: &PyReadonlyArray2<'py, u32>,
    tones: &PyReadonlyArray1<'py, f32>,
    labels: &PyReadonlyArray1<'py, u8>,
    stage: impl FnOnce(&Graph, &[f32], &mut [u8]) -> graphstipple_core::Result<()> + Send + 'static,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let (edges, tones, mut labels) = (arrays::pairs("edges", edges)?, arrays::values(tones), arrays::values(labels));
    let labels = watch::run_core(py, None, move |_| {
        stage(&graph_anywhere(labels.len(), &edges)?, &tones, &mut labels)?;
        Ok(labels)
    })?;
    Ok(labels.into_pyarray(py))
}

/// Labels refined, and the shift that gave them their mean.
#[pyfunction]
pub(crate) fn refine<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u32>,
    tones: PyReadonlyArray1<'py, f32>,
    labels: PyReadonlyArray1<'py, u8>,
    cells: (PyReadonlyArray1<'py, f64>, Option<PyReadonlyArray1<'py, u8>>),
    mean: Option<f64>,
    options: &Options,
) -> PyResult<(Bound<'py, PyArray1<u8>>, f64)> {
    let (areas, grounds) = cells;
    let parameters = Refinement::of(&options.checked, mean);
    let (edges, tones, areas) = (arrays::pairs("edges", &edges)?, arrays::values(&tones), arrays::values(&areas));
    let (mut labels, grounds) = (arrays::values(&labels), grounds.as_ref().map(arrays::values));
    let (labels, shift) = watch::run_core(py, options.checked.threads, move |control| {
        let graph = graph_anywhere(labels.len(), &edges)?;
        let shift = core::refine(&graph, &tones, &areas, grounds.as_deref(), &mut labels, &parameters, control)?;
        Ok((labels, shift))
    })?;
    Ok((labels.into_pyarray(py), shift))
}

/// The labels with dots taken apart that fused by chance.
#[pyfunction]
pub(crate) fn split<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u32>,
    tones: PyReadonlyArray1<'py, f32>,
    labels: PyReadonlyArray1<'py, u8>,
    most: u32,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    relabelled(py, &edges, &tones, &labels, move |graph, tones, labels| core::split(graph, tones, labels, most))
}

/// The grounds of smooth parts.
#[pyfunction]
pub(crate) fn grounds<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    edges: PyReadonlyArray2<'py, u32>,
    tones: PyReadonlyArray1<'py, f32>,
    options: &Options,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    let stippling = options.checked.stippling;
    let (sites, edges) = (arrays::pairs("sites", &sites)?, arrays::pairs("edges", &edges)?);
    let tones = arrays::values(&tones);
    let grounds = watch::run_core(py, options.checked.threads, move |_| {
        core::grounds(&Graph::from_edges(sites, &edges)?, &tones, stippling)
    })?;
    Ok(grounds.into_pyarray(py))
}

/// The labels without marks on pure white or black.
#[pyfunction]
pub(crate) fn clean<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u32>,
    tones: PyReadonlyArray1<'py, f32>,
    labels: PyReadonlyArray1<'py, u8>,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    relabelled(py, &edges, &tones, &labels, core::clean)
}

/// Labels (n,), places (n, 2) and areas (n,) with the dots of smooth parts.
type StippledArrays<'py> = (Bound<'py, PyArray1<u8>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

/// The smooth parts stippled.
#[pyfunction]
pub(crate) fn stipple<'py>(
    py: Python<'py>,
    sites: PyReadonlyArray2<'py, f64>,
    grounds: PyReadonlyArray1<'py, u8>,
    tones: PyReadonlyArray1<'py, f32>,
    areas: PyReadonlyArray1<'py, f64>,
    labels: PyReadonlyArray1<'py, u8>,
    size: (usize, usize),
) -> PyResult<StippledArrays<'py>> {
    let sites = arrays::pairs("sites", &sites)?;
    let (grounds, tones) = (arrays::values(&grounds), arrays::values(&tones));
    let (areas, labels) = (arrays::values(&areas), arrays::values(&labels));
    let Stippled { labels, marks } = watch::run_core(py, None, move |control| {
        let triangulation = core::triangulate(sites, size.0, size.1, control)?;
        core::stipple(&triangulation, &grounds, &tones, &areas, &labels, size, control)
    })?;
    Ok((labels.into_pyarray(py), arrays::from_pairs(py, marks.places)?, marks.areas.into_pyarray(py)))
}

/// The component of every node.
#[pyfunction]
pub(crate) fn components<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u32>,
    labels: PyReadonlyArray1<'py, u8>,
) -> PyResult<Bound<'py, PyArray1<u32>>> {
    let (edges, labels) = (arrays::pairs("edges", &edges)?, arrays::values(&labels));
    let ids = watch::run_core(py, None, move |_| {
        let graph = graph_anywhere(labels.len(), &edges)?;
        Ok(core::components(&graph, &labels).ids)
    })?;
    Ok(ids.into_pyarray(py))
}

/// The stipples and regions of labelled sites, shaped as the options say.
#[pyfunction]
pub(crate) fn outline<'py>(
    py: Python<'py>,
    positions: (PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, f64>>),
    labels: PyReadonlyArray1<'py, u8>,
    areas: PyReadonlyArray1<'py, f64>,
    tones: Option<PyReadonlyArray1<'py, f32>>,
    size: (usize, usize),
    options: &Options,
) -> PyResult<(StippleArrays<'py>, Vec<RegionArrays<'py>>)> {
    let (sites, places) = positions;
    let options = options.checked.clone();
    let sites = arrays::pairs("sites", &sites)?;
    let (labels, areas, tones) = (arrays::values(&labels), arrays::values(&areas), tones.as_ref().map(arrays::values));
    let places = places.map(|places| arrays::pairs("places", &places)).transpose()?;
    if sites.len() != labels.len() {
        return Err(errors::invalid(format!("there are {} labels for {} sites", labels.len(), sites.len())));
    }
    let drawing = watch::run_core(py, options.threads, move |control| {
        let triangulation = core::triangulate(sites, size.0, size.1, control)?;
        let components = core::components(&triangulation.graph, &labels);
        let shaping = Shaping::of(&options);
        let nodes = Nodes {
            labels: &labels,
            places: places.as_deref().unwrap_or(&triangulation.graph.sites),
            areas: &areas,
            tones: tones.as_deref().map(Tones::Grey),
            bands: None,
        };
        let outlines = core::outline(&triangulation, nodes, &components, size, shaping, control)?;
        core::assemble(outlines.parts)
    })?;
    let regions = (0..drawing.regions.len()).map(|index| region_arrays(py, &drawing, index)).collect::<PyResult<_>>()?;
    Ok((stipple_arrays(py, &drawing)?, regions))
}

/// Polygons moved out by a distance, or in by one below 0: rings (n, 2) each, the exterior first.
#[pyfunction]
pub(crate) fn offset<'py>(
    py: Python<'py>,
    polygons: Vec<Vec<PyReadonlyArray2<'py, f64>>>,
    distance: f64,
    tolerance: f64,
) -> PyResult<Vec<Vec<Bound<'py, PyArray2<f64>>>>> {
    let ring = |ring: &PyReadonlyArray2<'py, f64>| arrays::pairs("ring", ring);
    let polygons = polygons.iter().map(|rings| rings.iter().map(ring).collect()).collect::<PyResult<Vec<core::Polygon>>>()?;
    let moved = watch::run_core(py, None, move |_| core::offset(&polygons, distance, tolerance))?;
    let rings = |polygon: core::Polygon| polygon.into_iter().map(|ring| arrays::from_pairs(py, ring)).collect();
    moved.into_iter().map(rings).collect()
}
