//! The stages of one drawing, each to be called alone on what the stages before it made.

use std::hint::black_box;
use std::time::{Duration, Instant};

use graphstipple_core::stages::{
    Checked, Diffusion, FirstGraph, Nodes, Refinement, Shaping, TonedCells, Tones, Triangulation, assemble, cells, components,
    diffuse, diffuse_lattice, emphasize, fine_grained, first_graph, grounds, kept_sites, lattice_means, outline, raster::rasterize,
    refine, relax, samples_per_pixel, stipple, toned_cells, triangulate,
};
use graphstipple_core::{Control, Export, Field, Format, Options, Outcome, Result, draw};
use spade::{DelaunayTriangulation, Point2, Triangulation as _};

use crate::Photo;

/// How a stage uses threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    /// Its work is cut into pieces that do not need each other.
    Parallel,
    /// Part of its work is; the rest is in an order that cannot be cut.
    Mixed,
    /// All of its work is in an order that cannot be cut, or is not worth cutting.
    Serial,
}

/// A stage that can be called again and again.
pub struct Stage<'a> {
    /// As in the tables: lower case and underscores.
    pub name: &'static str,
    /// How it uses threads.
    pub threads: Threads,
    call: Box<dyn Fn() -> Duration + Send + Sync + 'a>,
}

impl<'a> Stage<'a> {
    fn new<O>(name: &'static str, threads: Threads, call: impl Fn() -> O + Send + Sync + 'a) -> Self {
        Self::with_input(name, threads, || (), move |()| call())
    }

    fn with_input<I, O>(
        name: &'static str,
        threads: Threads,
        input: impl Fn() -> I + Send + Sync + 'a,
        call: impl Fn(I) -> O + Send + Sync + 'a,
    ) -> Self {
        let timed = move || {
            let input = input();
            let began = Instant::now();
            let output = black_box(call(input));
            let time = began.elapsed();
            drop(output);
            time
        };
        Self { name, threads, call: Box::new(timed) }
    }

    /// Times one call. What it takes is made, and what it returns is dropped, outside of the measured time.
    ///
    /// Never inlined: `callgrind.py` counts what happens between its begin and its end.
    #[inline(never)]
    pub fn time(&self) -> Duration {
        (self.call)()
    }
}

/// A photo, and what every stage makes of it.
pub struct Prepared {
    photo: Photo,
    options: Checked<Options>,
    control: Control,
    outcome: Outcome,
    first: FirstGraph,
    triangulation: Triangulation,
    /// Places that relaxation starts from.
    kept: Vec<[f64; 2]>,
    /// The final sites, as spade takes them.
    points: Vec<Point2<f64>>,
    /// The tone with its details raised, and its means over the cells of the sites.
    emphasized: Field,
    means: Vec<f32>,
    /// Those of the tone as it is.
    plain: Vec<f32>,
    /// Labels before their refinement.
    diffused: Vec<u8>,
    areas: Vec<f64>,
    /// What the first diffusion labels.
    values: Vec<f32>,
    /// The photo in whole grey levels, for the saliency.
    bytes: Vec<u8>,
}

impl Prepared {
    /// Makes the drawing, and what its stages start from.
    ///
    /// # Errors
    /// As [`draw`].
    ///
    /// # Panics
    /// If the options have no density: the lattice is then chosen inside of the pipeline.
    pub fn new(photo: Photo, options: Checked<Options>) -> Result<Self> {
        let control = Control::new();
        let (width, height) = (photo.luma().width(), photo.luma().height());
        let samples = samples_per_pixel(options.published.density.expect("the measured options have a density"));
        let outcome = draw(&photo.photo, &photo.importance, &options, &control)?;
        let first = first_graph(&outcome.importance, &options, &control)?;
        let means = lattice_means(&first.lattice, &outcome.importance, samples, &control)?;
        let values = means.into_iter().map(|value| (f64::from(value) * first.factor).min(1.0) as f32).collect();
        let kept = kept_sites(&first, width as f64, height as f64);
        let sites = &outcome.graph.sites;
        let points = sites.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let triangulation = triangulate(sites.clone(), width, height, &control)?;
        let emphasized = emphasize(photo.luma(), options.budget((width * height) as f64).spacing, &options);
        let TonedCells { areas, means, plain } = toned_cells(sites, &emphasized, photo.luma(), samples, &control)?;
        let bytes = photo.luma().values().iter().map(|value| (255.0 * value + 0.5) as u8).collect();
        let diffused = diffuse(&*triangulation.graph, &means, Some(&areas), &Diffusion::of_tone(&options), &control)?;
        Ok(Self {
            photo,
            options,
            control,
            outcome,
            first,
            triangulation,
            kept,
            points,
            emphasized,
            means,
            plain,
            diffused,
            areas,
            values,
            bytes,
        })
    }

    /// One line that says what is measured.
    pub fn summary(&self) -> String {
        let (width, height) = (self.photo.luma().width(), self.photo.luma().height());
        format!("{width} x {height} pixels, {} lattice nodes, {} kept", self.first.labels.len(), self.points.len())
    }

    /// The whole drawing, with as many threads as the pool that it is called in.
    pub fn whole(&self) -> Stage<'_> {
        Stage::new("whole_drawing", Threads::Mixed, || {
            let options = Options { threads: Some(rayon::current_num_threads()), ..self.options.clone().into_inner() }.check()?;
            draw(&self.photo.photo, &self.photo.importance, &options, &self.control)
        })
    }

    /// The stages in the order of the pipeline, before them the saliency and after them two exports.
    pub fn stages(&self) -> Vec<Stage<'_>> {
        use Threads::{Mixed, Parallel, Serial};
        let (luma, importance, options, control) = (self.photo.luma(), &self.photo.importance, &self.options, &self.control);
        let (width, height) = (luma.width(), luma.height());
        let budget = options.budget((width * height) as f64);
        let samples = samples_per_pixel(budget.density);
        let (outcome, lattice, graph) = (&self.outcome, &self.first.lattice, &*self.triangulation.graph);
        let (sites, emphasized, areas, labels) = (&outcome.graph.sites, &self.emphasized, &self.areas, &outcome.labels.labels);
        let (first_phase, second_phase) = (Diffusion::of_importance(options), Diffusion::of_tone(options));
        let refinement = Refinement::of(options, Some(luma.mean()));
        let shaping = Shaping::of(options);
        let (places, mark_areas) = match &outcome.labels.marks {
            Some(marks) => (&marks.places, &marks.areas),
            None => (sites, areas),
        };
        let nodes = move || Nodes { labels, places, areas: mark_areas, tones: Some(Tones::Grey(&self.means)), bands: None };
        vec![
            Stage::new("saliency", Parallel, move || fine_grained(&self.bytes, width, height)),
            Stage::new("emphasis", Parallel, move || emphasize(luma, budget.spacing, options)),
            Stage::new("importance", Parallel, move || importance.mixed(luma, emphasized, budget.spacing, options)),
            Stage::new("lattice_means", Parallel, move || lattice_means(lattice, &outcome.importance, samples, control)),
            Stage::new("first_diffusion", Parallel, move || diffuse_lattice(lattice, &self.values, &first_phase, control)),
            Stage::new("node_budget", Mixed, move || first_graph(&outcome.importance, options, control)),
            Stage::with_input(
                "relaxation",
                Parallel,
                || self.kept.clone(),
                move |kept| relax(kept, width, height, options.relax, samples, control),
            ),
            Stage::with_input("triangulation", Mixed, || sites.clone(), move |sites| triangulate(sites, width, height, control)),
            Stage::with_input("spade_bulk_load", Serial, || self.points.clone(), DelaunayTriangulation::<Point2<f64>>::bulk_load),
            Stage::new("cells_with_tone", Parallel, move || cells(sites, width, height, samples, Some(luma), control)),
            Stage::new("second_diffusion", Parallel, move || diffuse(graph, &self.means, Some(areas), &second_phase, control)),
            Stage::with_input(
                "refinement",
                Parallel,
                || self.diffused.clone(),
                move |mut labels| refine(graph, &self.means, areas, None, &mut labels, &refinement, control),
            ),
            Stage::new("stippling", Mixed, move || {
                let grounds = grounds(graph, &self.plain, options.stippling)?;
                stipple(&self.triangulation, &grounds, &self.plain, areas, &self.diffused, (width, height), control)
            }),
            Stage::new("components_and_outlines", Mixed, move || {
                let components = components(graph, labels);
                assemble(outline(&self.triangulation, nodes(), &components, (width, height), shaping, control)?.parts)
            }),
            Stage::new("svg", Serial, move || {
                Format::of_suffix("svg")
                    .and_then(|svg| svg.writer(Export::default().check()?))
                    .and_then(|svg| svg.write(&outcome.drawing))
            }),
            Stage::new("rasterize", Parallel, move || rasterize(&outcome.drawing, None)),
        ]
    }
}
