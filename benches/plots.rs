//! What a plot and rules need beyond their drawing, beside limits, all in one run; see the crate's text for how to read it.

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use graphstipple_bench::{Limit, Photo, after, is_smoke_run, median, options, photo};
use graphstipple_core::stages::{Ink, Path, Polygon, Rules, SIMPLIFIED, check, enforce, offset, ordered, travelled};
use graphstipple_core::{Control, Drawing, draw};
use spade::{DelaunayTriangulation, Point2, Triangulation as _};

/// Dots that are put in order.
const DOTS: usize = 300_000;
const FEW_DOTS: usize = 500;

/// The photo whose areas are moved in: they have some 400,000 vertices.
const SIZE: [usize; 2] = [1216, 912];
const TINY_SIZE: [usize; 2] = [96, 72];

/// As wide as the drawing is on paper, in mm, and how far its areas are moved in: half a pen's width.
const WIDTH: f64 = 180.0;
const INSET: f64 = 0.15;

/// Of what is compared so many runs are made, in turn.
const RUNS: usize = 5;

/// How long the shortest tour of n random dots in an area A is, in the limit, over the root of n A (Johnson and McGeoch).
const SHORTEST: f64 = 0.7124;

/// A line of the table.
struct Figure {
    title: String,
    value: f64,
    limit: Option<Limit>,
    note: String,
}

impl Figure {
    fn new(title: impl Into<String>, value: f64, limit: Option<Limit>, note: String) -> Self {
        Self { title: title.into(), value, limit, note }
    }

    fn line(&self) -> String {
        let limit = self.limit.map_or(format!("{:20}", ""), |limit| limit.cells(self.value));
        format!("{:<58}{:>10.2}{limit}{}", self.title, self.value, self.note).trim_end().to_owned()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some([count, path, ..]) = after(&arguments, "--dots") {
        return order_for_others(count.parse()?, path);
    }
    let (dots, size, runs) = if is_smoke_run() { (FEW_DOTS, TINY_SIZE, 1) } else { (DOTS, SIZE, RUNS) };
    let figures = [order(dots, runs)?, moved_in(size, runs)?, kept(size, runs)?];
    println!("{:<58}{:>10}{:>10}", format!("to reach; medians of {runs} runs in turn"), "measured", "limit");
    figures.iter().flatten().for_each(|figure| println!("{}", figure.line()));
    Ok(())
}

/// Random dots in a square of a side of 1000 mm.
fn random_dots(count: usize) -> Vec<[f64; 2]> {
    // A linear congruential generator (Knuth's MMIX); the upper bits are the random ones.
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 1000.0
    };
    (0..count).map(|_| [next(), next()]).collect()
}

fn presses(dots: &[[f64; 2]]) -> Vec<Path> {
    dots.iter().map(|dot| Path { points: vec![*dot], is_closed: false }).collect()
}

/// Seconds that a call takes, and what it returns.
fn timed<T>(call: impl FnOnce() -> T) -> (f64, T) {
    let began = Instant::now();
    let value = black_box(call());
    (began.elapsed().as_secs_f64(), value)
}

/// The order of dots beside spade's bulk load of the same, and its length beside what the shortest one has.
fn order(count: usize, runs: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let dots = random_dots(count);
    let (mut ours, mut spades, mut way) = (Vec::new(), Vec::new(), 0.0);
    for _ in 0..runs {
        let points = dots.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let (seconds, loaded) = timed(|| DelaunayTriangulation::<Point2<f64>>::bulk_load(points));
        loaded?;
        spades.push(seconds);
        let paths = presses(&dots);
        let (seconds, paths) = timed(|| ordered(paths, [0.0; 2], &Control::new()));
        way = travelled(&paths?, [0.0; 2]);
        ours.push(seconds);
    }
    let ratio = median(ours.iter().zip(&spades).map(|(ours, spade)| ours / spade).collect());
    let note = format!("{:.3} s, spade {:.3} s", median(ours), median(spades));
    let shortest = SHORTEST * 1000.0 * (count as f64).sqrt();
    Ok(vec![
        Figure::new(format!("order of {count} dots / spade's bulk load"), ratio, Some(Limit::AtMost(15.0)), note),
        Figure::new("their tour / 0.7124 sqrt(n A)", way / shortest, Some(Limit::AtMost(1.1)), String::new()),
    ])
}

/// The black areas of a drawing, in mm.
fn areas(drawing: &Drawing) -> Vec<Polygon> {
    let scale = WIDTH / drawing.width as f64;
    let black = (0..drawing.regions.len()).filter(|region| drawing.regions[*region].ink == Ink::BLACK);
    let rings = black.map(|region| drawing.region_rings(region));
    let in_mm = |ring: Vec<[f64; 2]>| -> Vec<[f64; 2]> { ring.into_iter().map(|point| point.map(|v| v * scale)).collect() };
    rings.map(|(exterior, holes)| std::iter::once(exterior).chain(holes).map(in_mm).collect()).collect()
}

/// The areas of a drawing moved in, beside making the drawing.
fn moved_in([width, height]: [usize; 2], runs: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let Photo { photo, importance } = photo(width, height);
    let (mut ours, mut drawings, mut vertices) = (Vec::new(), Vec::new(), 0);
    for _ in 0..runs {
        let (seconds, outcome) = timed(|| draw(&photo, &importance, &options(), &Control::new()));
        drawings.push(seconds);
        let areas = areas(&outcome?.drawing);
        vertices = areas.iter().flatten().map(Vec::len).sum();
        let (seconds, moved) = timed(|| offset(&areas, -INSET, SIMPLIFIED));
        moved?;
        ours.push(seconds);
    }
    let ratio = median(ours.iter().zip(&drawings).map(|(ours, drawing)| ours / drawing).collect());
    let note = format!("{:.3} s, drawing {:.3} s", median(ours), median(drawings));
    Ok(vec![Figure::new(format!("areas of {vertices} vertices moved in / drawing them"), ratio, None, note)])
}

/// The rules of processes checked and enforced, at the same size, beside making the drawing.
fn kept([width, height]: [usize; 2], runs: usize) -> Result<Vec<Figure>, Box<dyn Error>> {
    let Photo { photo, importance } = photo(width, height);
    let control = Control::new();
    let mut figures = Vec::new();
    for process in ["laser", "stencil"] {
        let rules = Rules::of_process(process)?.check()?;
        let (mut checks, mut ours, mut drawings, mut left) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for _ in 0..runs {
            let (seconds, outcome) = timed(|| draw(&photo, &importance, &options(), &control));
            drawings.push(seconds);
            let outcome = outcome?;
            let scale = WIDTH / outcome.drawing.width as f64;
            let (seconds, report) = timed(|| check(&outcome.drawing, &rules, scale, &control));
            report?;
            checks.push(seconds);
            let (seconds, made) = timed(|| enforce(&outcome.drawing, Some(&outcome), &rules, scale, &control));
            ours.push(seconds);
            left = check(&made?.0, &rules, scale, &control)?.violations.len();
        }
        let both = checks.iter().zip(&ours).zip(&drawings);
        let ratio = median(both.map(|((check, ours), drawing)| (check + ours) / drawing).collect());
        let times = format!("{:.3} s, then {:.3} s, drawing {:.3} s", median(checks), median(ours), median(drawings));
        let title = format!("rules of {process} checked and enforced / drawing it");
        figures.push(Figure::new(title, ratio, Some(Limit::AtMost(15.0)), format!("{times}; {left} violations left")));
    }
    Ok(figures)
}

/// Puts dots in order, and writes them, a line each, for programs that are to do the same; prints the seconds and the length.
fn order_for_others(count: usize, path: &str) -> Result<(), Box<dyn Error>> {
    let dots = random_dots(count);
    let mut text = String::new();
    for [x, y] in &dots {
        writeln!(text, "{x} {y}")?;
    }
    std::fs::write(path, text)?;
    let (mut seconds, mut way) = (Vec::new(), 0.0);
    for _ in 0..RUNS {
        let paths = presses(&dots);
        let (taken, paths) = timed(|| ordered(paths, [0.0; 2], &Control::new()));
        way = travelled(&paths?, [0.0; 2]);
        seconds.push(taken);
    }
    println!("{}\t{way}", median(seconds));
    Ok(())
}
