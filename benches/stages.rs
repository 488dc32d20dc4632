//! Every stage at one megapixel, each on what the stages before it made; see the crate's text for how to read the times.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime};
use graphstipple_bench::{Photo, is_smoke_run, options, photo};
use graphstipple_core::components::components;
use graphstipple_core::control::Control;
use graphstipple_core::diffusion::{Diffusion, diffuse};
use graphstipple_core::emphasis::emphasize;
use graphstipple_core::export::Export;
use graphstipple_core::mean_tone::diffuse_to_mean;
use graphstipple_core::outline::{Nodes, Shaping, outline};
use graphstipple_core::pipeline::{draw, first_graph, kept_sites};
use graphstipple_core::raster::rasterize;
use graphstipple_core::svg::to_svg;
use graphstipple_core::triangulation::triangulate;
use graphstipple_core::voronoi::{cells, lattice_means, relax, samples_per_pixel};
use spade::{DelaunayTriangulation, Point2, Triangulation as _};

/// Times one call. What it takes is made, and what it returns is dropped, outside of the measured time.
fn measure<I, O>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, input: impl Fn() -> I, call: impl Fn(I) -> O) {
    group.bench_function(name, |bencher| bencher.iter_batched(&input, |input| black_box(call(input)), BatchSize::PerIteration));
}

fn stages(criterion: &mut Criterion) {
    let (width, height) = if is_smoke_run() { (96, 72) } else { (1024, 768) };
    let options = options();
    let Photo { luma, importance } = photo(width, height);
    let control = Control::new();
    let density = options.density.expect("the measured options have a density");
    let samples = samples_per_pixel(density);

    // What every stage starts from.
    let outcome = draw(&luma, &importance, &options, &control).expect("the photo can be drawn");
    let first = first_graph(&outcome.importance, &options, &control).expect("the importance has a first graph");
    let lattice = &first.lattice;
    let mut values = lattice_means(lattice, &outcome.importance, samples, &control).expect("the field covers the lattice");
    for value in &mut values {
        *value = (f64::from(*value) * first.factor).min(1.0) as f32;
    }
    let kept = kept_sites(&first, width as f64, height as f64);
    let sites = &outcome.graph.sites;
    let points: Vec<Point2<f64>> = sites.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
    let triangulation = triangulate(sites.clone(), width, height, &control).expect("the sites are distinct");
    let areas = cells(sites, width, height, samples, None, &control).expect("the sites are on the canvas").areas;
    let (first_phase, second_phase) = (Diffusion::of_importance(&options), Diffusion::of_tone(&options));
    let (labels, drawing) = (&outcome.labels, &outcome.drawing);
    let shaping = Shaping::of(&options);
    let export = Export::default();
    println!(
        "{width} x {height} pixels, {} lattice nodes, {} kept, {} threads",
        first.labels.len(),
        sites.len(),
        rayon::current_num_threads()
    );

    let mut group = criterion.benchmark_group("stages");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(4));
    let none = || ();
    let spacing = options.budget((width * height) as f64).spacing;
    let emphasized = emphasize(&luma, spacing, &options);
    let means = cells(sites, width, height, samples, Some(&emphasized), &control).expect("the sites are on the canvas").means;
    let nodes = Nodes { labels, areas: &areas, tones: Some(&outcome.tone) };
    let wanted = options.tone_tolerance.map(|tolerance| (luma.mean(), tolerance));
    measure(&mut group, "emphasis", none, |()| emphasize(&luma, spacing, &options));
    measure(&mut group, "importance", none, |()| importance.mixed(&luma, &emphasized, spacing, &options));
    measure(&mut group, "lattice_means", none, |()| lattice_means(lattice, &outcome.importance, samples, &control));
    measure(&mut group, "first_diffusion", none, |()| diffuse(lattice, &values, None, &first_phase, &control));
    measure(&mut group, "node_budget", none, |()| first_graph(&outcome.importance, &options, &control));
    measure(&mut group, "relaxation", || kept.clone(), |kept| relax(kept, width, height, options.relax, samples, &control));
    measure(&mut group, "triangulation", || sites.clone(), |sites| triangulate(sites, width, height, &control));
    measure(&mut group, "spade_bulk_load", || points.clone(), DelaunayTriangulation::<Point2<f64>>::bulk_load);
    measure(&mut group, "cells_with_tone", none, |()| cells(sites, width, height, samples, Some(&luma), &control));
    measure(&mut group, "second_diffusion", none, |()| {
        diffuse(&triangulation.graph, &outcome.tone, Some(&areas), &second_phase, &control)
    });
    measure(&mut group, "diffusion_to_mean", none, |()| {
        diffuse_to_mean(&triangulation.graph, &means, &areas, options.carry, wanted, &second_phase, &control)
    });
    measure(&mut group, "components_and_outlines", none, |()| {
        let components = components(&triangulation.graph, labels);
        outline(&triangulation, nodes, &components, (width, height), shaping, &control)
    });
    measure(&mut group, "svg", none, |()| to_svg(drawing, &export));
    measure(&mut group, "rasterize", none, |()| rasterize(drawing, None));
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
