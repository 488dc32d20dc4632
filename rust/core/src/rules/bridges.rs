//! Bridges in label space: the islands of a drawing joined to its frame by changing labels, so that bridges are drawn as all else is.
//! In: what drawing a photo left; out: the same with other labels, and its drawing anew.
//!
//! # The idea
//! White that falls out is a component of the labelled graph that is not drawn to the frame. Those that are too small become black.
//! All others are joined to the frame by a Steiner tree over the graph, whose edges cost what they take away from the photo's tone, and
//! something for their length. Along its edges black nodes become white, as wide as a bridge is to be, and from there the drawing is
//! made as it was.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use serde_json::json;

use crate::base::{Control, Frame, Ink, Pool, Result};
use crate::drawing::Drawing;
use crate::graph::{Components, Graph, Triangulation, triangulate};
use crate::labels::{Labels, Marks};
use crate::options::{Crossings, Options};
use crate::outlines::{Bands, Shaping};
use crate::pipeline::{Outcome, Relabelled, redrawn};
use crate::rules::bridging::{Bridge, Bridged, Bridging};
use crate::rules::cores::Drawn;
use crate::rules::pieces::{AtFrame, Piece, Pieces};
use crate::rules::steiner::{NONE, Network, steiner_tree};
use crate::rules::ways::{Banded, Sheet};

/// What a bridge costs a pixel of its length, beside the tone that it takes: with less, bridges go far out of their way to stay where the
/// photo is light; with more, they go straight through what is dark.
const LENGTH_COST: f64 = 0.25;

/// Half of a bridge is this part of the tolerance wider than asked for, as its boundaries may be drawn so much nearer.
const SPARE: f64 = 0.35;

/// A dot that is joined gives so many times the area that bridges have beside it, as they widen towards it; and more where the tone is
/// not kept by that.
const KNOTS: [f64; 3] = [1.5, 3.0, 6.0];

/// How much lighter a drawing may become if its dots can help it.
const TONE_KEPT: f64 = 0.02;

/// By how much darker a drawing must become to be drawn once more.
const WORTH_DRAWING: f64 = 1e-3;

/// What [`Provenance::rest`](crate::stages::Provenance::rest) has of bridges.
const TOLD: &str = "bridged";

/// Joins the islands of a drawing to its frame.
///
/// # Errors
/// [`Error::Option`](crate::Error::Option) if a setting is out of its range, [`Error::Input`](crate::Error::Input) if the drawing's
/// options are none of this version, [`Error::Cancelled`](crate::Error::Cancelled).
///
/// # Runtime
/// n log n in the number of nodes, most of it for their triangulation and the outlines.
pub fn bridge(outcome: &Outcome, bridging: &Bridging, control: &Control) -> Result<(Outcome, Bridged)> {
    bridging.check()?;
    let options = outcome.drawing.provenance.options()?;
    let began = Instant::now();
    let (mut made, told) = Pool::new(options.threads).run(|| bridge_here(outcome, bridging, &options, control))?;
    let seconds = began.elapsed().as_secs_f64();
    *made.stats.seconds.entry("bridges".to_owned()).or_default() += seconds;
    *made.stats.seconds.entry("total".to_owned()).or_default() += seconds;
    Ok((made, told))
}

/// What is bridged, in pixels of the raster.
struct Given<'a> {
    outcome: &'a Outcome,
    triangulation: &'a Triangulation,
    at_frame: &'a AtFrame,
    frame: Frame,
    /// Where nodes are drawn, and the areas of their marks.
    places: &'a [[f64; 2]],
    areas: &'a [f64],
    pieces: Pieces,
    shaping: Shaping,
    /// Whether boundaries follow the tone.
    follows_tone: bool,
    /// Islands of less area become black.
    least: f64,
    /// Half the width of a bridge.
    half: f64,
}

fn bridge_here(outcome: &Outcome, bridging: &Bridging, options: &Options, control: &Control) -> Result<(Outcome, Bridged)> {
    let shaping = Shaping::of(options);
    let scale = outcome.factor as f64;
    let (width, height) = (outcome.importance.width(), outcome.importance.height());
    let triangulation = &triangulate(outcome.graph.sites.clone(), width, height, control)?;
    let at_frame = &AtFrame::of(triangulation);
    let (places, areas) = match &outcome.labels.marks {
        Some(marks) => (&marks.places, &marks.areas),
        None => (&outcome.graph.sites, &outcome.cells.areas),
    };
    let given = Given {
        outcome,
        triangulation,
        at_frame,
        frame: Frame { width: width as f64, height: height as f64 },
        places,
        areas,
        pieces: Pieces::of(triangulation, &outcome.labels.labels, &outcome.components, at_frame),
        shaping: Shaping {
            stipple_min: shaping.stipple_min / scale,
            stipple_max: shaping.stipple_max.map(|most| most / scale),
            ..shaping
        },
        follows_tone: options.published.crossings == Crossings::Tone,
        least: bridging.min_area / (scale * scale),
        half: (0.5 * bridging.width + SPARE * shaping.tolerance) / scale,
    };
    let mut is_dropped = given.too_small();
    let terminals = given.terminals(&is_dropped, control)?;
    let costs = given.costs(&is_dropped);
    let edges = steiner_tree(&costs, &terminals.of_nodes, terminals.count, control)?;

    // What is on the way stays.
    let count = places.len();
    for node in edges.iter().flatten().filter(|node| (**node as usize) < count) {
        is_dropped[outcome.components.ids[*node as usize] as usize] = false;
    }
    let mut sheet = Sheet {
        triangulation,
        at_frame,
        frame: given.frame,
        labels: given.without(&is_dropped),
        places: places.clone(),
        areas: &outcome.cells.areas,
    };
    sheet.straighten(&edges, control)?;
    let runs = runs(&sheet, &edges, &terminals.of_nodes);
    let before = sheet.labels.clone();
    let banded = sheet.band(&edges, given.half, |node| given.radius(given.mark_area(node as usize)) as f32, control)?;

    let is_island = |piece: &&Piece| **piece == Piece::Island;
    let dropped = is_dropped.iter().filter(|is_dropped| **is_dropped).count();
    let bridged = given.pieces.pieces.iter().filter(is_island).count() - dropped;
    let mut provenance = outcome.drawing.provenance.clone();
    provenance.rest.insert(TOLD.to_owned(), json!({ "min_area": bridging.min_area, "width": bridging.width }));
    if sheet.labels == outcome.labels.labels && edges.is_empty() {
        let drawing = Arc::new(Drawing { provenance, ..(*outcome.drawing).clone() });
        return Ok((Outcome { drawing, ..outcome.clone() }, Bridged::default()));
    }
    let was = white_share(&outcome.drawing);
    let drawn = |knot: f64| -> Result<(Outcome, f64)> {
        let (areas, depths, is_added) = given.marks(&sheet, &before, &banded, &runs, knot);
        let marks = Marks { places: sheet.places.clone(), areas };
        let labels = Labels { labels: sheet.labels.clone(), shift: outcome.labels.shift, marks: Some(marks), inks: None };
        let bands = Bands { depths: &depths, is_added: &is_added };
        let relabelled = Relabelled { triangulation, labels, bands: Some(bands), provenance: provenance.clone() };
        let made = redrawn(outcome, relabelled, control)?;
        let tone = white_share(&made.drawing) - was;
        Ok((made, tone))
    };
    let (mut made, mut tone) = drawn(KNOTS[0])?;
    for knot in &KNOTS[1..] {
        if tone <= TONE_KEPT {
            break;
        }
        let (thinner, darker) = drawn(*knot)?;
        let helps = tone - darker >= WORTH_DRAWING;
        (made, tone) = (thinner, darker);
        if !helps {
            break;
        }
    }
    let bridges = runs.into_iter().filter(|run| run.length > 0.0).map(|run| run.bridge(scale)).collect();
    Ok((made, Bridged { dropped, bridged, bridges, tone }))
}

impl Given<'_> {
    /// Whether a node is drawn as a dot.
    fn is_dot(&self, node: usize) -> bool {
        self.pieces.is_dot[self.outcome.components.ids[node] as usize]
    }

    /// The area of a node's mark if it is black in the end: of white dots it is that of their cell.
    fn mark_area(&self, node: usize) -> f64 {
        if self.outcome.labels.labels[node] == 0 { self.areas[node] } else { self.outcome.cells.areas[node] }
    }

    /// The radius of the dot of such an area, if it has room.
    fn radius(&self, area: f64) -> f64 {
        let Shaping { stipple_scale, stipple_min, stipple_max, .. } = self.shaping;
        (area * stipple_scale / PI).sqrt().max(stipple_min).min(stipple_max.unwrap_or(f64::INFINITY))
    }

    /// Which components are islands of less area than the least; dots as they are drawn.
    fn too_small(&self) -> Vec<bool> {
        let Components { ids, sizes } = &*self.outcome.components;
        let mut areas = vec![0.0; sizes.len()];
        for (node, id) in ids.iter().enumerate() {
            areas[*id as usize] += if self.is_dot(node) { PI * self.radius(self.areas[node]).powi(2) } else { self.areas[node] };
        }
        let is_small = |(piece, area): (&Piece, f64)| *piece == Piece::Island && area < self.least;
        self.pieces.pieces.iter().zip(areas).map(is_small).collect()
    }

    /// The labels without the components that become black.
    fn without(&self, is_dropped: &[bool]) -> Vec<u8> {
        let kept = |(label, id): (&u8, &u32)| if is_dropped[*id as usize] { 0 } else { *label };
        self.outcome.labels.labels.iter().zip(&self.outcome.components.ids).map(kept).collect()
    }

    /// What is to be joined: the frame with the cores that it holds, other cores, and whole islands that have none.
    fn terminals(&self, is_dropped: &[bool], control: &Control) -> Result<Terminals> {
        let Outcome { cells, components, .. } = self.outcome;
        let labels = self.without(is_dropped);
        let is_dot: Vec<bool> =
            (0..labels.len()).map(|node| self.is_dot(node) && labels[node] == self.outcome.labels.labels[node]).collect();
        let drawn = Drawn {
            triangulation: self.triangulation,
            at_frame: self.at_frame,
            labels: &labels,
            places: self.places,
            areas: &cells.areas,
            tones: self.follows_tone.then_some(&cells.means[..]),
            is_dot: &is_dot,
        };
        let cores = drawn.cores(self.half, control)?;
        let mut count = 1;
        let mut next = || {
            count += 1;
            count - 1
        };
        let number = |(area, is_held): (&f64, &bool)| {
            if *is_held {
                0
            } else if *area >= self.least {
                next()
            } else {
                NONE
            }
        };
        let of_cores: Vec<u32> = cores.areas.iter().zip(&cores.is_held).map(number).collect();
        let of_core =
            |node: usize| cores.of_nodes.get(node).filter(|core| **core != NONE).map_or(NONE, |core| of_cores[*core as usize]);
        // Islands of which no core counts are joined as they are.
        let mut is_joined: Vec<bool> =
            self.pieces.pieces.iter().zip(is_dropped).map(|(piece, is_dropped)| *piece != Piece::Island || *is_dropped).collect();
        for (node, id) in components.ids.iter().enumerate() {
            is_joined[*id as usize] |= of_core(node) != NONE;
        }
        let of_pieces: Vec<u32> = is_joined.iter().map(|is_joined| if *is_joined { NONE } else { next() }).collect();
        let of_node = |(node, id): (usize, &u32)| match of_pieces[*id as usize] {
            NONE => of_core(node),
            whole => whole,
        };
        let of_nodes = components.ids.iter().enumerate().map(of_node).chain([0]).collect();
        Ok(Terminals { of_nodes, count: count as usize })
    }

    fn costs(&self, is_dropped: &[bool]) -> Costs<'_> {
        let Outcome { cells, labels, graph, components, .. } = self.outcome;
        let dark = |(label, tone): (&u8, &f32)| if *label == 1 { 0.0 } else { 1.0 - f64::from(*tone).clamp(0.0, 1.0) };
        let stays_dot = |node: usize| labels.labels[node] == 1 && self.is_dot(node) && !is_dropped[components.ids[node] as usize];
        Costs {
            graph,
            at_frame: self.at_frame,
            frame: self.frame,
            places: self.places,
            dark: labels.labels.iter().zip(&cells.plain).map(dark).collect(),
            is_dot: (0..self.places.len()).map(stays_dot).collect(),
        }
    }

    /// The areas of marks, and the bands with the dots on them: each gives `knot` times the area that bridges have beside it.
    fn marks(&self, sheet: &Sheet, before: &[u8], banded: &Banded, runs: &[Run], knot: f64) -> (Vec<f64>, Vec<f32>, Vec<bool>) {
        let count = before.len();
        let mut beside = vec![0.0; count];
        for run in runs {
            for end in
                [run.nodes[0], run.nodes[run.nodes.len() - 1]].map(|node| node as usize).into_iter().filter(|end| *end < count)
            {
                beside[end] += run.length * self.half;
            }
        }
        let mut areas = self.areas.to_vec();
        let mut bands = banded.clone();
        for node in (0..count).filter(|node| before[*node] == 1 && self.is_dot(*node)) {
            let stays = areas[node] * self.shaping.stipple_scale - knot * beside[node];
            bands.add_dot(sheet, node as u32, (stays.max(0.0) / PI).sqrt().max(self.half));
        }
        for node in (0..count).filter(|node| sheet.labels[*node] != self.outcome.labels.labels[*node]) {
            areas[node] = self.outcome.cells.areas[node];
        }
        for (node, radius) in &banded.small_dots {
            areas[*node as usize] = PI * f64::from(*radius).powi(2) / self.shaping.stipple_scale;
        }
        (areas, bands.depths, bands.is_added)
    }
}

/// The part of the canvas that is white.
fn white_share(drawing: &Drawing) -> f64 {
    let regions = (0..drawing.regions.len()).into_par_iter().filter(|region| drawing.regions[*region].ink == Ink::WHITE);
    let areas: Vec<f64> = regions.map(|region| drawing.region_area(region)).collect();
    let dots = drawing.stipples.iter().filter(|dot| dot.ink == Ink::WHITE);
    let white = areas.iter().sum::<f64>() + dots.map(|dot| PI * dot.radius * dot.radius).sum::<f64>();
    white / (drawing.width * drawing.height) as f64
}

/// What is to be joined.
struct Terminals {
    /// One entry more than there are nodes: the frame's.
    of_nodes: Vec<u32>,
    count: usize,
}

/// What bridges cost: the graph, and a node for the frame.
struct Costs<'a> {
    graph: &'a Graph,
    at_frame: &'a AtFrame,
    frame: Frame,
    places: &'a [[f64; 2]],
    /// What of the paper's light is lost where a node is black, in [0, 1].
    dark: Vec<f64>,
    /// Whether a node is an island by itself, which is no more joined to the frame beside it than to anything else.
    is_dot: Vec<bool>,
}

impl Costs<'_> {
    fn to_frame(&self, node: u32) -> f64 {
        let [x, y] = self.places[node as usize];
        let length = x.min(self.frame.width - x).min(y).min(self.frame.height - y);
        length * (LENGTH_COST + self.dark[node as usize])
    }
}

impl Network for Costs<'_> {
    fn for_each_edge(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
        let count = self.places.len();
        if node == count {
            let joined = self.at_frame.nodes().filter(|other| !self.is_dot[*other as usize]);
            joined.for_each(|other| visit(other as usize, self.to_frame(other)));
            return;
        }
        let [x, y] = self.places[node];
        for other in self.graph.row(node).iter().map(|other| *other as usize) {
            let (dx, dy) = (self.places[other][0] - x, self.places[other][1] - y);
            let dark = 0.5 * (self.dark[node] + self.dark[other]);
            visit(other, (dx * dx + dy * dy).sqrt() * (LENGTH_COST + dark));
        }
        if !self.is_dot[node] && self.at_frame.sides(node as u32).is_some() {
            visit(count, self.to_frame(node as u32));
        }
    }
}

/// A way through black.
struct Run {
    /// The nodes along it, whose numbers beyond the graph's stand for the frame.
    nodes: Vec<u32>,
    /// Where these are drawn.
    points: Vec<[f64; 2]>,
    /// Of what is black.
    length: f64,
}

impl Run {
    /// In pixels of the canvas.
    fn bridge(self, scale: f64) -> Bridge {
        let points = self.points.into_iter().map(|point| point.map(|v| v * scale)).collect();
        Bridge { points, length: self.length * scale }
    }
}

/// The ways that edges make through black: each from white, the frame or where ways meet to the next of these.
fn runs(sheet: &Sheet, edges: &[[u32; 2]], terminals: &[u32]) -> Vec<Run> {
    let count = sheet.labels.len();
    let mut beside: Vec<[u32; 2]> = edges.iter().flat_map(|[a, b]| [[*a, *b], [*b, *a]]).collect();
    beside.sort_unstable();
    let others = |node: u32| {
        let from = beside.partition_point(|[other, _]| *other < node);
        &beside[from..beside.partition_point(|[other, _]| *other <= node)]
    };
    let is_white = |node: u32| node as usize == count || sheet.labels[node as usize] == 1;
    let is_end = |node: u32| terminals[node as usize] != NONE || others(node).len() != 2;
    let mut runs = Vec::new();
    for [first, second] in beside.iter().filter(|[first, _]| is_end(*first)) {
        let mut nodes = vec![*first, *second];
        while let [before, node] = nodes[nodes.len() - 2..]
            && !is_end(node)
        {
            let next = others(node).iter().map(|[_, other]| *other).find(|other| *other != before);
            nodes.extend(next);
        }
        // Each is found from both of its ends.
        let last = nodes[nodes.len() - 1];
        if (last, nodes[nodes.len() - 2]) < (*first, *second) {
            continue;
        }
        let place = |k: usize| match nodes[k] as usize {
            node if node < count => sheet.places[node],
            _ => {
                let point = sheet.on_frame(nodes[if k == 0 { 1 } else { k - 1 }]);
                [point.x, point.y]
            }
        };
        let points: Vec<[f64; 2]> = (0..nodes.len()).map(place).collect();
        let length = |k: usize| {
            let part = match [nodes[k], nodes[k + 1]].map(|node| is_white(node) && (node as usize) < count) {
                [false, false] => 1.0,
                [true, true] => 0.0,
                // Halfway from node to node, roughly.
                _ => 0.5,
            };
            let (dx, dy) = (points[k + 1][0] - points[k][0], points[k + 1][1] - points[k][1]);
            part * (dx * dx + dy * dy).sqrt()
        };
        let length = (0..points.len() - 1).map(length).sum();
        runs.push(Run { nodes, points, length });
    }
    runs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::base::{Error, noise};
    use crate::files::{Export, Format, load, raster};
    use crate::importance::Importance;
    use crate::options::Published;
    use crate::photo::{Field, Photo};
    use crate::pipeline::draw;
    use crate::rules::islands;

    /// Spots of several sizes, some in others, on noise.
    fn picture(width: usize, height: usize, seed: u64, grain: usize) -> Field {
        let random = |k: u64| 0.5 + f64::from(noise(seed ^ k));
        let value = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let wave = libm::sin(x / (2.0 + 5.0 * random(1))) * libm::sin(y / (2.0 + 5.0 * random(2)) + random(3));
            let grainy = random(10 + (i / width / grain * width + i % width / grain) as u64);
            (0.35 + 0.3 * wave + 0.4 * (grainy - 0.5)).clamp(0.0, 1.0) as f32
        };
        Field::new(width, height, (0..width * height).map(value).collect()).unwrap()
    }

    fn drawn(photo: &Photo, options: Options) -> Outcome {
        draw(photo, &Importance::Constant(0.6), &options.check().unwrap(), &Control::new()).unwrap()
    }

    fn bridged(outcome: &Outcome, min_area: f64, width: f64) -> (Outcome, Bridged) {
        bridge(outcome, &Bridging { min_area, width }, &Control::new()).unwrap()
    }

    /// How many pieces white falls into, with white around the canvas: as labels and as pixels have it.
    fn white_pieces(outcome: &Outcome, scale: usize) -> [usize; 2] {
        let (width, height) = (outcome.importance.width(), outcome.importance.height());
        let triangulation = triangulate(outcome.graph.sites.clone(), width, height, &Control::new()).unwrap();
        let at_frame = AtFrame::of(&triangulation);
        let pieces = Pieces::of(&triangulation, &outcome.labels.labels, &outcome.components, &at_frame).pieces;
        let islands = pieces.iter().filter(|piece| **piece == Piece::Island).count();

        let raster = raster::rasterize(&outcome.drawing, Some(outcome.drawing.width * scale)).unwrap();
        let (width, height) = (raster.width + 2, raster.height + 2);
        let is_white = |x: usize, y: usize| {
            let is_outside = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            is_outside || raster.values[(y - 1) * raster.width + x - 1] >= 128
        };
        let mut sets = crate::rules::steiner::Sets::new(width * height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|(x, y)| is_white(*x, *y)) {
            let own = (y * width + x) as u32;
            if x > 0 && is_white(x - 1, y) {
                sets.join(own, own - 1);
            }
            if y > 0 && is_white(x, y - 1) {
                sets.join(own, own - width as u32);
            }
        }
        let white = (0..width * height).filter(|i| is_white(i % width, i / width));
        [islands + 1, white.filter(|i| sets.find(*i as u32) == *i as u32).count()]
    }

    /// Nothing in the drawing touches or crosses anything, and its files give it back.
    fn check_sound(drawing: &Drawing) {
        for suffix in ["svg", "json"] {
            let format = Format::of_suffix(suffix).unwrap();
            let bytes = format.writer(Export::default().check().unwrap()).unwrap().write(drawing).unwrap();
            assert_eq!(load(&bytes, format, &Control::new()).unwrap(), *drawing);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(120))]
        #[test]
        fn white_is_one_piece_and_drawings_are_sound(
            width in 1usize..60, height in 1usize..60, seed in any::<u64>(), grain in 1usize..6,
            factor in prop_oneof![2 => Just(1), 1 => 2usize..5],
            density in prop_oneof![Just(0.3), Just(1.0), Just(4.0)],
            stippling in prop_oneof![Just(0.0), Just(0.5), Just(1.0)],
            (irregularity, tolerance) in prop_oneof![3 => Just((0.0, 0.5)), 1 => Just((0.0, 0.0)), 1 => Just((0.7, 0.25))],
            stipple_scale in prop_oneof![3 => Just(1.0), 1 => Just(3.0)],
            is_paper in prop::bool::weighted(0.2),
            min_area in prop_oneof![Just(0.0), Just(2.0), Just(12.0)],
            bridge_width in prop_oneof![Just(1e-3), Just(0.5), Just(1.5), Just(6.0), Just(200.0)],
        ) {
            let published = if is_paper { Published::default() } else { Published::ours() };
            let options = Options {
                published: Published { density: Some(density / (factor * factor) as f64), ..published },
                stippling, irregularity, tolerance, stipple_scale, ..Options::default()
            };
            let luma = picture(factor * width + seed as usize % factor, factor * height, seed, grain * factor);
            let outcome = drawn(&Photo::reduced(luma, factor), options);
            let unit = (factor * factor) as f64;
            let (made, told) = bridged(&outcome, min_area * unit, bridge_width * factor as f64);
            prop_assert_eq!(white_pieces(&made, 1)[0], 1);
            prop_assert_eq!(islands(&made.drawing), vec![]);
            check_sound(&made.drawing);
            let before = islands(&outcome.drawing).len();
            prop_assert_eq!(told.dropped + told.bridged, before);
            prop_assert!(told.bridges.iter().all(|bridge| bridge.length > 0.0 && bridge.points.len() > 1));
            prop_assert_eq!(made.stats.regions, made.drawing.regions.len());
            // What was asked for is told, and it is done: again there is nothing to do.
            prop_assert_eq!(&made.drawing.provenance.rest["bridged"]["width"], &json!(bridge_width * factor as f64));
            prop_assert_eq!(made.drawing.provenance.options().unwrap(), outcome.drawing.provenance.options().unwrap());
            let (again, told) = bridged(&made, min_area * unit, bridge_width * factor as f64);
            prop_assert_eq!((told.dropped, told.bridged), (0, 0));
            prop_assert_eq!(white_pieces(&again, 1)[0], 1);
        }
    }

    /// A picture with islands in the dark.
    fn dark(width: usize, height: usize, nodes: u64, stippling: f64) -> Outcome {
        drawn(&Photo::new(picture(width, height, 11, 7)), Options { nodes: Some(nodes), stippling, ..Options::default() })
    }

    #[test]
    fn bridges_are_as_wide_as_asked_for_in_pixels_too() {
        for (nodes, width, scale) in [(1500, 3.0, 4), (6000, 1.5, 6), (6000, 4.0, 3)] {
            for stippling in [0.0, 0.5] {
                let outcome = dark(160, 120, nodes, stippling);
                let [_, before] = white_pieces(&outcome, scale);
                let (made, told) = bridged(&outcome, 4.0, width);
                assert!(before > 20 && told.bridged > 10, "{before} {}", told.bridged);
                assert_eq!(white_pieces(&made, scale), [1, 1], "{nodes} {width} {stippling}");
                // Beside the middle of bridges, but for the outer sides of bends.
                let raster = raster::rasterize(&made.drawing, Some(160 * 8)).unwrap();
                let mut black = 0;
                let mut all = 0;
                for pair in told.bridges.iter().flat_map(|bridge| bridge.points.windows(2)) {
                    let [a, b] = [pair[0], pair[1]];
                    let length = ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt();
                    let across = [(a[1] - b[1]) / length, (b[0] - a[0]) / length];
                    for (along, side) in (1..8).flat_map(|k| [-0.4, 0.0, 0.4].map(|side| (f64::from(k) / 8.0, side))) {
                        let at = [0, 1].map(|axis| a[axis] + along * (b[axis] - a[axis]) + side * width * across[axis]);
                        let [column, row] = at.map(|v| (v * 8.0) as usize);
                        if at[0] > 0.0 && at[1] > 0.0 && column < raster.width && row < raster.height {
                            black += usize::from(raster.values[row * raster.width + column] < 128);
                            all += 1;
                        }
                    }
                }
                assert!(all > 500 && black * 100 < all, "{black} of {all} are black: {nodes} {width} {stippling}");
            }
        }
    }

    #[test]
    fn the_tone_is_kept_where_dots_are_joined() {
        let outcome = dark(200, 150, 3000, 1.0);
        let (made, told) = bridged(&outcome, 0.0, 1.0);
        assert!(told.dropped == 0 && told.bridged > 100, "{}", told.bridged);
        assert!(told.tone.abs() <= TONE_KEPT, "{}", told.tone);
        let mean = |outcome: &Outcome| {
            let raster = raster::rasterize(&outcome.drawing, None).unwrap();
            raster.values.iter().map(|value| f64::from(*value)).sum::<f64>() / raster.values.len() as f64 / 255.0
        };
        assert!((mean(&made) - mean(&outcome) - told.tone).abs() < 2e-3);
    }

    /// One white square on black, of which one half is lighter than the other.
    fn square(lighter: f32) -> Outcome {
        let value = |i: usize| {
            let (x, y) = (i % 120, i / 120);
            if (50..70).contains(&x) && (30..50).contains(&y) {
                1.0
            } else if x > 60 {
                lighter
            } else {
                0.0
            }
        };
        let luma = Field::new(120, 80, (0..120 * 80).map(value).collect()).unwrap();
        drawn(&Photo::new(luma), Options { nodes: Some(3000), stippling: 0.0, ..Options::default() })
    }

    #[test]
    fn a_bridge_goes_the_shortest_way_or_where_it_is_lighter() {
        // Straight up or down.
        let (made, told) = bridged(&square(0.0), 1.0, 2.0);
        assert_eq!((told.bridged, told.bridges.len()), (1, 1));
        let bridge = &told.bridges[0];
        assert!((bridge.length - 30.0).abs() < 4.0, "{}", bridge.length);
        let (first, last) = (bridge.points[0], bridge.points[bridge.points.len() - 1]);
        assert!((first[0] - last[0]).abs() < 4.0, "{first:?} {last:?}");
        assert!((told.tone - 30.0 * 2.5 / (120.0 * 80.0)).abs() < 2e-3, "{}", told.tone);
        assert_eq!(islands(&made.drawing), []);
        // To the right it is longer.
        let (_, told) = bridged(&square(0.45), 1.0, 2.0);
        let last = told.bridges[0].points.iter().map(|point| point[0]).fold(0.0, f64::max);
        assert!(last > 60.0, "{last}");
        // Too small a square goes.
        let (made, told) = bridged(&square(0.0), 500.0, 2.0);
        assert_eq!((told.dropped, told.bridged, made.drawing.regions.len()), (1, 0, 1));
        assert!((told.tone + 400.0 / (120.0 * 80.0)).abs() < 2e-3, "{}", told.tone);
    }

    #[test]
    fn a_drawing_without_islands_stays_as_it_is() {
        let luma = Field::new(60, 40, (0..2400).map(|i| if i % 60 < 30 { 0.0 } else { 1.0 }).collect()).unwrap();
        let outcome = drawn(&Photo::new(luma), Options::default());
        let (made, told) = bridged(&outcome, 1.0, 2.0);
        assert_eq!(told, Bridged::default());
        assert_eq!((&made.drawing.curves, &made.labels), (&outcome.drawing.curves, &outcome.labels));
        assert!(made.drawing.provenance.rest.contains_key("bridged"));
    }

    #[test]
    fn threads_do_not_matter() {
        let outcome = dark(200, 150, 20_000, 0.5);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = Options { threads: Some(threads), ..(*outcome.drawing.provenance.options().unwrap()).clone() };
            let bridging = Bridging { min_area: 4.0, width: 1.0 };
            pool.install(|| bridge_here(&outcome, &bridging, &options, &Control::new())).unwrap()
        };
        let ((one, told), (three, told_again)) = (with(1), with(3));
        assert!(one.drawing == three.drawing && one.labels == three.labels && told == told_again);
        assert!(told.bridged > 10);
    }

    #[test]
    fn what_cannot_be_is_refused_in_a_sentence_and_work_can_be_stopped() {
        let outcome = square(0.0);
        for (min_area, width, told) in [
            (-1.0, 2.0, "min_area is -1, but it must be an area of 0 or more"),
            (f64::NAN, 2.0, "min_area is NaN, but it must be an area of 0 or more"),
            (1.0, 0.0, "bridge_width is 0, but it must be a length above 0"),
            (1.0, f64::INFINITY, "bridge_width is inf, but it must be a length above 0"),
        ] {
            let refused = bridge(&outcome, &Bridging { min_area, width }, &Control::new()).unwrap_err();
            assert_eq!(refused.to_string(), told);
        }
        let cancelled = Control::new();
        cancelled.cancel();
        let stopped = bridge(&outcome, &Bridging { min_area: 1.0, width: 2.0 }, &cancelled);
        assert!(matches!(stopped, Err(Error::Cancelled)));
    }
}
