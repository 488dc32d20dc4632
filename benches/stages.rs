//! Every stage at one megapixel, each on what the stages before it made; see the crate's text for how to read the times.

use std::error::Error;

use graphstipple_bench::stages::{Prepared, Stage};
use graphstipple_bench::{is_smoke_run, median, options, photo};

/// How often a stage is called, at least and at most; in between, for as many seconds.
const RUNS: [usize; 2] = [10, 1000];
const SECONDS: f64 = 4.0;

fn main() -> Result<(), Box<dyn Error>> {
    let (size, [least, most]) = if is_smoke_run() { ([96, 72], [1; 2]) } else { ([1024, 768], RUNS) };
    let prepared = Prepared::new(photo(size[0], size[1]), options())?;
    println!("{}, {} threads: milliseconds of a call\n", prepared.summary(), rayon::current_num_threads());
    println!("{:<24}{:>10}{:>10}{:>10}{:>8}", "", "least", "median", "most", "calls");
    for stage in prepared.stages() {
        println!("{}", row(&stage, least, most));
    }
    Ok(())
}

/// Calls a stage until there are enough times, the first of which only warms up.
fn row(stage: &Stage, least: usize, most: usize) -> String {
    let runs = ((SECONDS / stage.time().as_secs_f64()) as usize).clamp(least, most);
    let mut times: Vec<f64> = (0..runs).map(|_| 1000.0 * stage.time().as_secs_f64()).collect();
    times.sort_by(f64::total_cmp);
    let (fastest, slowest) = (times[0], times[runs - 1]);
    format!("{:<24}{fastest:>10.3}{:>10.3}{slowest:>10.3}{runs:>8}", stage.name, median(times))
}
