//! Every stage on one thread and on two, in turn in one process, as a table; see the crate's text for how to read it.

use std::error::Error;

use graphstipple_bench::stages::{Prepared, Threads};
use graphstipple_bench::{Limit, after, is_smoke_run, median, options, photo};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// One megapixel.
const SIZE: [usize; 2] = [1152, 864];

const TINY_SIZE: [usize; 2] = [96, 72];

/// How often one thread and two take turns with a stage. In a turn, a stage is called several times: a processor that has had
/// nothing to do is given to a thread after some milliseconds only, so the first call of two threads may be one of one.
const TURNS: usize = 3;

/// How often every stage is called in a turn, at least and at most: the median of all turns counts. In between, as often as
/// [`SECONDS`] allow, since one call of a few milliseconds says little.
const RUNS: [usize; 2] = [3, 33];

/// Seconds for the calls of a stage on one thread in a turn.
const SECONDS: f64 = 0.2;

/// How many times as fast two threads are to be in a stage that is parallel.
const LIMIT: Limit = Limit::AtLeast(1.5);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (mut size, turns, [least, most]) = if is_smoke_run() { (TINY_SIZE, 1, [1; 2]) } else { (SIZE, TURNS, RUNS) };
    let once = after(&arguments, "--once");
    if let Some([width, height, ..]) = once {
        size = [width.parse()?, height.parse()?];
    }
    let [width, height] = size;
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    let pools: [ThreadPool; 2] = [pool(1)?, pool(2)?];
    let prepared = Prepared::new(photo(width, height), options())?;
    if once.is_some() {
        // For `callgrind.py`, which counts in each.
        for stage in prepared.stages() {
            pools[0].install(|| stage.time());
            println!("{}", stage.name);
        }
        return Ok(());
    }
    println!("\n{}: medians of {turns} turns of {least} to {most} calls on one thread and on two\n", prepared.summary());
    println!("{:<24}{:>13}{:>13}{:>11}{:>10}  {:<8}its work is", "", "one, s", "two, s", "one / two", "limit", "");
    for stage in prepared.stages().into_iter().chain([prepared.whole()]) {
        let first = pools[0].install(|| stage.time()).as_secs_f64();
        let runs = ((SECONDS / first) as usize).clamp(least, most);
        let mut seconds = [Vec::new(), Vec::new()];
        for _ in 0..turns {
            for (pool, seconds) in pools.iter().zip(&mut seconds) {
                seconds.extend((0..runs).map(|_| pool.install(|| stage.time()).as_secs_f64()));
            }
        }
        let [one, two] = seconds.map(median);
        let (kind, limit) = match stage.threads {
            Threads::Parallel => ("parallel", LIMIT.cells(one / two)),
            Threads::Mixed => ("partly serial", String::new()),
            Threads::Serial => ("serial", String::new()),
        };
        println!("{:<24}{one:>13.4}{two:>13.4}{:>11.2}{limit:<20}{kind}", stage.name, one / two);
    }
    Ok(())
}
