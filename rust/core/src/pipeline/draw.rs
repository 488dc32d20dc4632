//! The whole method: the only file that knows the order of the stages.
//!
//! luma -> tone -> emphasized tone; importance with detail -> lattice values -> labels -> kept sites -> relaxed sites -> Delaunay
//! graph -> node tones -> grounds of smooth parts -> labels, refined, fused dots split, cleaned -> dots of smooth parts ->
//! components -> outlines -> drawing.
//!
//! Of a photo that is reduced, the stages up to the labels work on its raster, with the options that [`Options::on_raster`] makes of
//! those of the canvas. For the outlines the nodes are put where they stand on the canvas, so curves and dots are made there.
//!
//! Every stage is handed the options as [`super::needs`] makes them for it, and its result goes through its place in a [`Memory`]:
//! that of a [`super::session::Session`] keeps it for the next drawing, that of [`draw`] does not.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

use crate::base::{Checked, Control, Palette, Pool, Result, Step};
use crate::diffusion::{Diffusion, diffuse};
use crate::drawing::{Drawing, Provenance, Stats, VERSION, assemble};
use crate::graph::{Components, Edges, Graph, TonedCells, Triangulation, components, samples_per_pixel, toned_cells};
use crate::importance::Importance;
use crate::labels::{
    Labels, Refinement, STRUCTURED, Stippled, clean, drawn_tones, grounds, refine, split, stipple, structured_mean,
};
use crate::options::{Backdrop, Crossings, ErrorWeighting, Options, Stage};
use crate::outlines::{Bands, Nodes, Parts, Shaping, Tones, outline};
use crate::photo::{Field, Photo, adjusted, attended, backed, emphasize, emphasize_and_off, off_blurred};
use crate::pipeline::inking::{labels_of_inks, palette_of};
use crate::pipeline::memory::{Memory, Outlined, Slot, Tone};
use crate::pipeline::needs::Needs;
use crate::sites::{FirstGraph, keep, kept_sites, lattice_values, relax};

/// A drawing, and what the stages made on the way to it. The large parts are shared with the session, if it was made in one.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The vector result.
    pub drawing: Arc<Drawing>,
    /// Counts and times.
    pub stats: Stats,
    /// By how much the photo was reduced, as its [`Photo::factor`]. What the stages made is in pixels of the reduced raster, of which
    /// each is so many pixels of the canvas long; the drawing is in pixels of the canvas.
    pub factor: usize,
    /// One sentence for whoever draws, where the drawing is hardly what they wanted: it is blank, though the photo is not flat.
    pub warning: Option<String>,
    /// The second graph.
    pub graph: Arc<Graph>,
    /// Cells of the nodes, with the emphasized tone in each.
    pub cells: Arc<TonedCells>,
    /// Label of every node: 0 black, 1 white.
    pub labels: Arc<Labels>,
    /// Component of every node.
    pub components: Arc<Components>,
    /// The importance on the photo's raster, before the budget's factor.
    pub importance: Arc<Field>,
}

/// Points of a reduced raster in pixels of the canvas.
fn enlarged(points: &[[f64; 2]], factor: usize) -> Cow<'_, [[f64; 2]]> {
    if factor == 1 {
        return Cow::Borrowed(points);
    }
    Cow::Owned(points.iter().map(|point| point.map(|v| v * factor as f64)).collect())
}

/// Areas likewise.
fn enlarged_areas(areas: &[f64], factor: usize) -> Cow<'_, [f64]> {
    if factor == 1 {
        return Cow::Borrowed(areas);
    }
    Cow::Owned(areas.iter().map(|area| area * (factor * factor) as f64).collect())
}

/// Draws a photo, reduced as it is.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) for an importance map or canvas that cannot be used, or more nodes than the lattice has,
/// [`Error::Cancelled`](crate::Error::Cancelled) after [`Control::cancel`].
pub fn draw(photo: &Photo, importance: &Importance, options: &Checked<Options>, control: &Control) -> Result<Outcome> {
    draw_with(photo.clone(), Cow::Borrowed(importance), options, control, &mut Memory::new(false))
}

/// As [`draw`], with 8 bytes a pixel less at the peak: the photo and its map are given back as soon as they are done with.
///
/// # Errors
/// As [`draw`].
pub fn draw_owned(photo: Photo, importance: Importance, options: &Checked<Options>, control: &Control) -> Result<Outcome> {
    draw_with(photo, Cow::Owned(importance), options, control, &mut Memory::new(false))
}

/// Draws from what the memory has, and leaves there what it keeps.
///
/// # Errors
/// As [`draw`]. The memory then has only whole results, each with what it was made from.
pub(crate) fn draw_with(
    photo: Photo,
    importance: Cow<Importance>,
    options: &Checked<Options>,
    control: &Control,
    memory: &mut Memory,
) -> Result<Outcome> {
    let mut told = options.to_json();
    if photo.subject().is_none() {
        // Without a subject there is no rest to say anything of.
        told.shift_remove("backdrop");
    }
    let provenance =
        Provenance { version: VERSION.to_owned(), importance: importance.name(), options: told, rest: serde_json::Map::new() };
    let pixels = (photo.width() * photo.height()) as f64;
    let mut seen = options.on_raster(pixels, photo.factor());
    if photo.subject().is_none() {
        // There is nothing to step back, so no stage runs again for another backdrop.
        seen.to_mut().backdrop = Backdrop::default();
    }
    let needs = Needs::of(&seen, &importance);
    let budget = options.budget(pixels);
    let stats = Stats {
        width: photo.width(),
        height: photo.height(),
        reduction: photo.factor(),
        density: budget.density,
        node_budget: budget.nodes.map(|n| n.round() as usize),
        ..Stats::default()
    };
    let stages = Stages { control, began: Instant::now(), stats };
    Pool::new(options.threads).run(|| run(photo, importance, &needs, provenance, stages, memory))
}

/// Times the stages and tells the control where the work is.
struct Stages<'a> {
    control: &'a Control,
    began: Instant,
    stats: Stats,
}

impl Stages<'_> {
    /// A stage that may be done in parts, whose seconds add up.
    fn run<T>(&mut self, step: Step, work: impl FnOnce() -> Result<T>) -> Result<T> {
        self.control.begin(step)?;
        let began = Instant::now();
        let result = work()?;
        *self.stats.seconds.entry(step.name().to_owned()).or_default() += began.elapsed().as_secs_f64();
        Ok(result)
    }

    /// As [`Stages::run`], unless the slot has the result.
    fn run_unless_kept<T>(
        &mut self,
        step: Step,
        slot: &mut Slot<T>,
        needs: &Options,
        work: impl FnOnce(&Options) -> Result<T>,
    ) -> Result<Arc<T>> {
        match slot.get(needs) {
            Some(kept) => Ok(kept),
            None => Ok(slot.put(needs, self.run(step, || work(needs))?)),
        }
    }

    /// Two stages that do not need each other, on two threads if there are two; on one, the second runs first. Their seconds overlap.
    fn run_both<A: Send, B: Send>(
        &mut self,
        first: Step,
        second: Step,
        first_work: impl FnOnce() -> Result<A> + Send,
        second_work: impl FnOnce() -> Result<B> + Send,
    ) -> Result<(A, B)> {
        self.control.begin(first)?;
        let timed = |step: Step, began: Instant| (step.name().to_owned(), began.elapsed().as_secs_f64());
        let began = Instant::now();
        let (b, a) = rayon::join(
            || second_work().map(|result| (result, timed(second, began))),
            || first_work().map(|result| (result, timed(first, began))),
        );
        let ((a, first_time), (b, second_time)) = (a?, b?);
        self.stats.seconds.extend([first_time, second_time]);
        Ok((a, b))
    }
}

/// All stages. What a stage made is dropped here as soon as no other needs it, and is gone with that unless the memory keeps it.
fn run(
    photo: Photo,
    importance: Cow<Importance>,
    needs: &Needs,
    provenance: Provenance,
    mut stages: Stages,
    memory: &mut Memory,
) -> Result<Outcome> {
    let (canvas, factor) = ((photo.width(), photo.height()), photo.factor());
    let luma = photo.shared_luma();
    let (width, height) = (luma.width(), luma.height());
    let (pixels, control) = ((width * height) as f64, stages.control);

    let tone = stages.run_unless_kept(Step::Lattice, &mut memory.tone, needs.at(Stage::Tone), |needs| {
        let tone = adjusted(&luma, needs)?;
        let tone = if let Some(mask) = photo.subject() { backed(tone, mask, needs.backdrop) } else { tone };
        let (mean, range) = (tone.mean(), tone.range());
        let adjusted = match tone {
            Cow::Owned(field) => Some(field),
            Cow::Borrowed(_) => None,
        };
        Ok(Tone { mean, range, adjusted })
    })?;
    let (mean, range) = (tone.mean, tone.range);
    let plain = tone.adjusted.as_ref().unwrap_or(&luma);
    // Emphasis and importance share a blur where both are to be made.
    let wants_off =
        importance.needs_detail(needs.at(Stage::Importance)) && memory.importance.get(needs.at(Stage::Importance)).is_none();
    let mut off = None;
    let emphasized = stages.run_unless_kept(Step::Lattice, &mut memory.emphasis, needs.at(Stage::Emphasis), |needs| {
        let spacing = needs.budget(pixels).spacing;
        if !wants_off {
            return Ok(emphasize(plain, spacing, needs));
        }
        let (emphasized, found) = emphasize_and_off(plain, spacing, needs);
        off = Some(found);
        Ok(emphasized)
    })?;
    let field = stages.run_unless_kept(Step::Lattice, &mut memory.importance, needs.at(Stage::Importance), |needs| {
        let spacing = needs.budget(pixels).spacing;
        let off = off.take().or_else(|| wants_off.then(|| off_blurred(plain, spacing)));
        let mixed = importance.mixed_with(off, &emphasized, spacing, needs)?;
        Ok(if let Some(mask) = photo.subject() { attended(mixed, mask, spacing, needs.backdrop) } else { mixed })
    })?;
    // Smooth parts are stippled by the tone as it is.
    // Other inks than black and white are made of its colour.
    let coloured = needs.at(Stage::Labels).wants_colour().then(|| photo.clone());
    drop((importance, photo));
    let plain = Plain { tone, luma };
    let first = first_graph_of(&field, needs.at(Stage::FirstGraph), &mut stages, &mut memory.first_graph)?;
    (stages.stats.lattice_nodes, stages.stats.importance_factor) = (first.labels.len(), first.factor);
    let (triangulation, cells) = second_graph_of(first, emphasized, plain, needs, &mut stages, memory)?;
    let labels = stages.run_unless_kept(Step::Diffusion, &mut memory.labels, needs.at(Stage::Labels), |needs| {
        if let Some(photo) = &coloured {
            let palette = palette_of(photo, needs)?;
            if !palette.is_black_and_white() {
                return labels_of_inks(photo, palette, &triangulation, &cells, needs, control);
            }
        }
        labels_of(&triangulation, &cells, (width, height), mean, needs, control)
    })?;
    drop(coloured);
    let connected = |_: &Options| Ok(components(&triangulation.graph, &labels.labels));
    let components = stages.run_unless_kept(Step::Outlines, &mut memory.components, needs.at(Stage::Labels), connected)?;
    let outlined = stages.run_unless_kept(Step::Outlines, &mut memory.outlines, needs.at(Stage::Outlines), |needs| {
        let graph =
            Labelled { triangulation: &triangulation, labels: &labels, components: &components, cells: &cells, bands: None };
        graph.outlined(canvas, factor, needs, provenance.clone(), control)
    })?;
    let outlined = signed(outlined, provenance, needs.at(Stage::Outlines), &mut memory.outlines);

    let mut stats = stages.stats;
    stats.seconds.insert("total".to_owned(), stages.began.elapsed().as_secs_f64());
    let stats = counted(Stats { nodes: labels.labels.len(), tone_shift: labels.shift, ..stats }, &outlined);
    let (drawing, graph) = (Arc::clone(&outlined.drawing), Arc::clone(&triangulation.graph));
    let warning = blank(&drawing, range);
    Ok(Outcome { drawing, stats, factor, warning, graph, cells, labels, components, importance: field })
}

/// A labelled graph on the raster, of which a drawing is made.
struct Labelled<'a> {
    triangulation: &'a Triangulation,
    labels: &'a Labels,
    components: &'a Components,
    cells: &'a TonedCells,
    bands: Option<Bands<'a>>,
}

impl Labelled<'_> {
    /// Its drawing on a canvas that is so much larger.
    fn outlined(
        &self,
        canvas: (usize, usize),
        factor: usize,
        needs: &Options,
        provenance: Provenance,
        control: &Control,
    ) -> Result<Outlined> {
        let Self { triangulation, labels, components, cells, bands } = *self;
        let followed = (needs.published.crossings == Crossings::Tone).then_some(&cells.means[..]);
        let (places, areas) = match &labels.marks {
            Some(marks) => (&marks.places, &marks.areas),
            None => (&triangulation.graph.sites, &cells.areas),
        };
        // From here on all is on the canvas.
        let (places, areas) = (enlarged(places, factor), enlarged_areas(areas, factor));
        let mixed = labels.inks.as_ref().filter(|_| followed.is_some()).map(|inks| &inks.mixtures[..]);
        let tones = mixed.map(Tones::Mixed).or(followed.map(Tones::Grey));
        let nodes = Nodes { labels: &labels.labels, places: &places, areas: &areas, tones, bands };
        let palette = labels.inks.as_ref().map_or_else(Palette::default, |inks| inks.palette.clone());
        let outlines = outline(triangulation, nodes, components, canvas, Shaping::of(needs), control)?;
        let drawing = Arc::new(Drawing { provenance, ..assemble(Parts { palette, ..outlines.parts })? });
        let (anchors, coordinates) = drawing.count_written();
        Ok(Outlined { drawing, vertices: outlines.vertices, anchors, coordinates })
    }
}

/// The same with the counts of a drawing.
fn counted(stats: Stats, outlined: &Outlined) -> Stats {
    Stats {
        stipples: outlined.drawing.stipples.len(),
        regions: outlined.drawing.regions.len(),
        vertices: outlined.vertices,
        anchors: outlined.anchors,
        coordinates: outlined.coordinates,
        ..stats
    }
}

/// Other labels for the nodes of a drawing, and how their outlines run.
pub(crate) struct Relabelled<'a> {
    /// The triangulation of the nodes, anew: an [`Outcome`] keeps its graph alone.
    pub(crate) triangulation: &'a Triangulation,
    pub(crate) labels: Labels,
    pub(crate) bands: Option<Bands<'a>>,
    /// What is told of how the drawing was made.
    pub(crate) provenance: Provenance,
}

/// The drawing of other labels, made as the first one was from its components on. Nothing else changes, nor is any time told.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the drawing's options are none of this version, or there is not one label a node;
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub(crate) fn redrawn(outcome: &Outcome, relabelled: Relabelled, control: &Control) -> Result<Outcome> {
    let Relabelled { triangulation, labels, bands, provenance } = relabelled;
    // What outlines go by is in pixels of the canvas, so it is no other for a reduced photo.
    let options = provenance.options()?;
    let canvas = (outcome.drawing.width, outcome.drawing.height);
    let (components, cells) = (components(&triangulation.graph, &labels.labels), &outcome.cells);
    let graph = Labelled { triangulation, labels: &labels, components: &components, cells, bands };
    let outlined = graph.outlined(canvas, outcome.factor, &options, provenance, control)?;
    let stats = counted(outcome.stats.clone(), &outlined);
    let (labels, components) = (Arc::new(labels), Arc::new(components));
    Ok(Outcome { drawing: outlined.drawing, stats, labels, components, ..outcome.clone() })
}

/// The largest difference of tones of a photo that counts as flat: one level of 8 bits, and what rounding adds.
const FLAT: f32 = 1.5 / 255.0;

/// Tones that differ by more need no stretching: then the nodes are too few.
const WIDE: f32 = 0.5;

/// What to say of a drawing of one ink alone, if the photo was not flat.
fn blank(drawing: &Drawing, [low, high]: [f32; 2]) -> Option<String> {
    let ([only], []) = (&drawing.regions[..], &drawing.stipples[..]) else { return None };
    let way_out =
        if high - low < WIDE { "set white point and black point to auto to stretch them" } else { "draw it with more nodes" };
    (high - low > FLAT).then(|| {
        let ink = drawing.palette.name(only.ink);
        format!("the whole drawing is {ink}, as the photo's tones lie between {low:.2} and {high:.2}: {way_out}")
    })
}

/// The labels of the second graph, with the dots of smooth parts; `mean` is that of the photo's tone.
fn labels_of(
    triangulation: &Triangulation,
    cells: &TonedCells,
    size: (usize, usize),
    mean: f64,
    needs: &Options,
    control: &Control,
) -> Result<Labels> {
    let (graph, TonedCells { areas, means, plain }) = (&*triangulation.graph, cells);
    let weighting = (needs.published.error_weighting == ErrorWeighting::Area).then_some(&areas[..]);
    let diffusion = Diffusion::of_tone(needs);
    if needs.stippling == 0.0 {
        let mut labels = diffuse(graph, means, weighting, &diffusion, control)?;
        let shift = refine(graph, means, areas, None, &mut labels, &Refinement::of(needs, Some(mean)), control)?;
        split(graph, means, &mut labels, needs.split)?;
        return Ok(Labels { labels, shift, marks: None, inks: None });
    }
    let grounds = grounds(graph, plain, needs.stippling)?;
    let tones = drawn_tones(&grounds, means);
    let mut labels = diffuse(graph, &tones, weighting, &diffusion, control)?;
    labels.iter_mut().zip(&grounds).filter(|(_, ground)| **ground != STRUCTURED).for_each(|(label, ground)| *label = *ground);
    let mean = structured_mean(&grounds, plain, areas);
    let shift = refine(graph, &tones, areas, Some(&grounds), &mut labels, &Refinement::of(needs, mean), control)?;
    split(graph, &tones, &mut labels, needs.split)?;
    clean(graph, plain, &mut labels)?;
    let Stippled { labels, marks } = stipple(triangulation, &grounds, plain, areas, &labels, size, control)?;
    Ok(Labels { labels, shift, marks: Some(marks), inks: None })
}

/// The first graph of an importance on the photo's raster.
fn first_graph_of(field: &Field, needs: &Options, stages: &mut Stages, slot: &mut Slot<FirstGraph>) -> Result<Arc<FirstGraph>> {
    if let Some(kept) = slot.get(needs) {
        return Ok(kept);
    }
    let control = stages.control;
    let budget = needs.budget((field.width() * field.height()) as f64);
    let (lattice, values) = stages.run(Step::Lattice, || lattice_values(field, budget.density, needs, control))?;
    let first = stages.run(Step::Importance, || keep(lattice, &values, budget.nodes, needs, control))?;
    Ok(slot.put(needs, first))
}

/// The tone before emphasis.
struct Plain {
    tone: Arc<Tone>,
    luma: Arc<Field>,
}

impl Plain {
    fn field(&self) -> &Field {
        self.tone.adjusted.as_ref().unwrap_or(&self.luma)
    }
}

/// The second graph, and the cells of its nodes with their tone.
fn second_graph_of(
    first: Arc<FirstGraph>,
    tone: Arc<Field>,
    plain: Plain,
    needs: &Needs,
    stages: &mut Stages,
    memory: &mut Memory,
) -> Result<(Arc<Triangulation>, Arc<TonedCells>)> {
    let (width, height, control) = (tone.width(), tone.height(), stages.control);
    let samples = |needs: &Options| samples_per_pixel(needs.budget((width * height) as f64).density);
    if let Some(kept) = memory.second_graph.get(needs.at(Stage::SecondGraph)) {
        let of_kept = |needs: &Options| toned_cells(&kept.graph.sites, &tone, plain.field(), samples(needs), control);
        let cells = stages.run_unless_kept(Step::Tone, &mut memory.cells, needs.at(Stage::Cells), of_kept)?;
        return Ok((kept, cells));
    }
    let sites = stages.run(Step::Relaxation, || {
        let sites = kept_sites(&first, width as f64, height as f64);
        drop(first);
        relax(sites, width, height, needs.at(Stage::SecondGraph).relax, samples(needs.at(Stage::SecondGraph)), control)
    })?;
    // The cells need the sites alone, so they are found beside the triangulation: neither waits at the serial parts of the other.
    // The tone is given back as soon as they have it.
    let (of, samples) = (&sites, samples(needs.at(Stage::Cells)));
    let (edges, cells) = stages.run_both(
        Step::Triangulation,
        Step::Tone,
        || Edges::of(of, width, height, control),
        move || toned_cells(of, &tone, plain.field(), samples, control),
    )?;
    Ok((
        memory.second_graph.put(needs.at(Stage::SecondGraph), edges.with_sites(sites)),
        memory.cells.put(needs.at(Stage::Cells), cells),
    ))
}

/// The drawing with its provenance. A kept one may have been made with other options, of which no stage needed the difference.
fn signed(outlined: Arc<Outlined>, provenance: Provenance, needs: &Options, slot: &mut Slot<Outlined>) -> Arc<Outlined> {
    let written = |provenance: &Provenance| serde_json::to_string(provenance).expect("names and numbers always serialize");
    // As text, since 0 and -0 are equal and are written differently.
    if written(&outlined.drawing.provenance) == written(&provenance) {
        return outlined;
    }
    let drawing = Arc::new(Drawing { provenance, ..(*outlined.drawing).clone() });
    slot.put(needs, Outlined { drawing, ..*outlined })
}
