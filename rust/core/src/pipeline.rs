//! The whole method: the only file that knows the order of the stages.
//!
//! luma -> tone -> emphasized tone; importance with detail -> lattice values -> labels -> kept sites -> relaxed sites -> Delaunay
//! graph -> node tones -> labels of the right mean, fused dots split -> components -> outlines -> drawing.

use std::time::Instant;

use crate::components::components;
use crate::control::{Control, STAGES};
use crate::diffusion::{Diffusion, diffuse};
use crate::drawing::{Drawing, Provenance, Stats};
use crate::emphasis::emphasize;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::graph::{Adjacency, Graph, distance_squared};
use crate::importance::Importance;
use crate::lattice::Lattice;
use crate::mean_tone::{Toned, diffuse_to_mean};
use crate::outline::{Nodes, Shaping, outline};
use crate::params::{Alpha, Crossings, Options};
use crate::split::split;
use crate::tone;
use crate::triangulation::triangulate;
use crate::voronoi::{cells, lattice_means, relax, samples_per_pixel};

/// A drawing, and what the stages made on the way to it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The vector result.
    pub drawing: Drawing,
    /// Counts and times.
    pub stats: Stats,
    /// The second graph.
    pub graph: Graph,
    /// Tone of every node, emphasized and bent: what was diffused.
    pub tone: Vec<f32>,
    /// Label of every node: 0 black, 1 white.
    pub labels: Vec<u8>,
    /// Component id of every node.
    pub components: Vec<u32>,
    /// The importance on the canvas, before the budget's factor.
    pub importance: Field,
}

/// The first graph and which of its nodes are kept.
#[derive(Debug, Clone)]
pub struct FirstGraph {
    /// The lattice.
    pub lattice: Lattice,
    /// 1 for every node that is kept.
    pub labels: Vec<u8>,
    /// The factor on the importance that meets the node budget; 1 without one.
    pub factor: f64,
}

/// Draws a photo given as luma.
///
/// # Errors
/// [`Error::Option`] for an option out of range, [`Error::Input`] for an importance map or canvas that cannot be used,
/// [`Error::Cancelled`] after [`Control::cancel`].
pub fn draw(luma: &Field, importance: &Importance, options: &Options, control: &Control) -> Result<Outcome> {
    options.validate()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads.unwrap_or(0))
        .build()
        .map_err(|e| Error::Internal(format!("the worker threads did not start: {e}")))?;
    pool.install(|| run(luma, importance, options, control))
}

/// Times the stages and tells the control where the work is.
struct Stages<'a> {
    control: &'a Control,
    began: Instant,
    stats: Stats,
}

impl Stages<'_> {
    fn run<T>(&mut self, stage: usize, work: impl FnOnce() -> Result<T>) -> Result<T> {
        self.control.begin(stage)?;
        let began = Instant::now();
        let result = work()?;
        self.stats.seconds.insert(STAGES[stage].0.to_owned(), began.elapsed().as_secs_f64());
        Ok(result)
    }

    /// Two stages that do not need each other, on two threads if there are two. Their seconds overlap.
    fn run_both<A: Send, B: Send>(
        &mut self,
        first: usize,
        second: usize,
        first_work: impl FnOnce() -> Result<A> + Send,
        second_work: impl FnOnce() -> Result<B> + Send,
    ) -> Result<(A, B)> {
        self.control.begin(first)?;
        let timed = |stage: usize, began: Instant| (STAGES[stage].0.to_owned(), began.elapsed().as_secs_f64());
        let began = Instant::now();
        let (a, b) = rayon::join(
            || first_work().map(|result| (result, timed(first, began))),
            || second_work().map(|result| (result, timed(second, began))),
        );
        let ((a, first_time), (b, second_time)) = (a?, b?);
        self.stats.seconds.extend([first_time, second_time]);
        Ok((a, b))
    }
}

fn run(luma: &Field, importance: &Importance, options: &Options, control: &Control) -> Result<Outcome> {
    let (width, height) = (luma.width(), luma.height());
    let mut stages = Stages { control, began: Instant::now(), stats: Stats { width, height, ..Stats::default() } };
    let budget = options.budget((width * height) as f64);
    let samples = samples_per_pixel(budget.density);

    let (mean, tone, field, lattice, values) = stages.run(0, || {
        let tone = tone::adjust(luma, options);
        let mean = tone.mean();
        let emphasized = emphasize(&tone, budget.spacing, options);
        control.check()?;
        let field = importance.mixed(&tone, &emphasized, budget.spacing, options)?;
        control.check()?;
        let (lattice, values) = lattice_values(&field, budget.density, options, control)?;
        Ok((mean, emphasized, field, lattice, values))
    })?;
    let first = stages.run(1, || keep(lattice, &values, budget.nodes, options, control))?;
    drop(values);
    let sites = stages.run(2, || {
        let sites = kept_sites(&first, width as f64, height as f64);
        relax(sites, width, height, options.relax, samples, control)
    })?;
    // The triangulation runs on one thread; beside it another finds the cells, which need the sites alone.
    let (triangulation, cells) = stages.run_both(
        3,
        4,
        || triangulate(sites.clone(), width, height, control),
        || cells(&sites, width, height, samples, Some(&tone), control),
    )?;
    drop((sites, tone));
    let Toned { tones, labels, amount } = stages.run(5, || {
        let wanted = options.tone_tolerance.map(|tolerance| (mean, tolerance));
        let parameters = Diffusion::of_tone(options);
        let graph = &triangulation.graph;
        let mut toned = diffuse_to_mean(graph, &cells.means, &cells.areas, options.carry, wanted, &parameters, control)?;
        split(graph, &toned.tones, &mut toned.labels, options.split)?;
        Ok(toned)
    })?;
    let (components, outlines) = stages.run(6, || {
        let components = components(&triangulation.graph, &labels);
        let shaping = Shaping::of(options);
        let followed = (options.crossings == Crossings::Tone).then_some(&tones[..]);
        let nodes = Nodes { labels: &labels, areas: &cells.areas, tones: followed };
        let outlines = outline(&triangulation, nodes, &components, (width, height), shaping, control)?;
        Ok((components, outlines))
    })?;

    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        importance: importance.name(),
        options: Options { threads: None, ..options.clone() },
    };
    let drawing = Drawing { provenance, ..outlines.drawing };
    let (anchors, coordinates) = drawing.count_written();
    let mut stats = stages.stats;
    stats.seconds.insert("total".to_owned(), stages.began.elapsed().as_secs_f64());
    let stats = Stats {
        density: budget.density,
        lattice_nodes: first.labels.len(),
        node_budget: budget.nodes.map(|n| n.round() as usize),
        importance_factor: first.factor,
        nodes: labels.len(),
        tone_bend: amount,
        stipples: drawing.stipples.len(),
        regions: drawing.regions.len(),
        vertices: outlines.vertices,
        anchors,
        coordinates,
        ..stats
    };
    Ok(Outcome { drawing, stats, graph: triangulation.graph, tone: tones, labels, components: components.ids, importance: field })
}

/// The first phase alone: the lattice, and the nodes that the importance keeps under the node budget.
///
/// # Errors
/// As [`draw`].
pub fn first_graph(importance: &Field, options: &Options, control: &Control) -> Result<FirstGraph> {
    options.validate()?;
    let budget = options.budget((importance.width() * importance.height()) as f64);
    let (lattice, values) = lattice_values(importance, budget.density, options, control)?;
    keep(lattice, &values, budget.nodes, options, control)
}

/// The nodes that the second graph starts from: those kept, and the nodes nearest to the corners of the canvas where those
/// kept are fewer than three or in one line.
pub fn kept_sites(first: &FirstGraph, width: f64, height: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<usize> = (0..first.labels.len()).filter(|i| first.labels[*i] == 1).collect();
    let site = |i: &usize| first.lattice.site(*i);
    if all_in_line(kept.iter().map(site)) {
        for [x, y] in [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]] {
            kept.push(first.lattice.nearest(x, y));
        }
        kept.sort_unstable();
        kept.dedup();
    }
    kept.iter().map(site).collect()
}

fn all_in_line(mut sites: impl Iterator<Item = [f64; 2]>) -> bool {
    let (Some(a), Some(b)) = (sites.next(), sites.next()) else {
        return true;
    };
    let length = distance_squared(a, b);
    // Twice the area of the triangle with the first two, against the square of their distance: rounding stays far below.
    !sites.any(|c| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() > 1e-9 * length)
}

fn lattice_values(importance: &Field, density: f64, options: &Options, control: &Control) -> Result<(Lattice, Vec<f32>)> {
    let lattice = Lattice::new(options.lattice, importance.width(), importance.height(), density)?;
    let values = lattice_means(&lattice, importance, samples_per_pixel(density), control)?;
    Ok((lattice, values))
}

fn keep(lattice: Lattice, values: &[f32], nodes: Option<f64>, options: &Options, control: &Control) -> Result<FirstGraph> {
    let mut parameters = Diffusion::of_importance(options);
    // What drops errors follows detail, and a flat importance has none: it would keep all nodes or hardly any.
    if values.iter().all(|v| *v == values[0]) && !matches!(parameters.alpha, Alpha::Constant(_)) {
        parameters.alpha = Alpha::Constant(1.0);
    }
    let (labels, factor) = match nodes {
        None => (diffuse(&lattice, values, None, &parameters, control)?, 1.0),
        Some(nodes) => crate::budget::meet(&lattice, values, nodes, &parameters, control)?,
    };
    debug_assert_eq!(labels.len(), lattice.len());
    Ok(FirstGraph { lattice, labels, factor })
}
