#![doc = include_str!("../README.md")]

mod photo;
pub mod stages;

pub use photo::{Photo, photo};

use graphstipple_core::stages::Checked;
use graphstipple_core::{Options, Published};

/// The options that are measured: as many lattice nodes as pixels, of which 0.3 a pixel are kept.
///
/// # Panics
/// Never: they keep their rules.
pub fn options() -> Checked<Options> {
    let published = Published { density: Some(1.0), ..Published::ours() };
    let options = Options { nodes_per_pixel: Some(0.3), published, ..Options::default() };
    options.check().expect("each is in its range")
}

/// Whether this is no measurement but a look at whether the benchmarks still run: cargo says `--bench` when it measures, and
/// nothing under `cargo test`.
pub fn is_smoke_run() -> bool {
    let given = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    given("--test") || !given("--bench")
}

/// What a figure is to reach. Missing it is printed and fails nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// The figure or less.
    AtMost(f64),
    /// The figure or more.
    AtLeast(f64),
}

impl Limit {
    /// Two cells of a table, 10 and 8 wide with two spaces between them: the limit, and whether a figure meets it.
    pub fn cells(self, figure: f64) -> String {
        let (sign, limit, is_met) = match self {
            Self::AtMost(limit) => ("<=", limit, figure <= limit),
            Self::AtLeast(limit) => (">=", limit, figure >= limit),
        };
        format!("{:>10}  {:<8}", format!("{sign} {limit}"), if is_met { "met" } else { "missed" })
    }
}

/// The arguments behind a flag; `None` without it.
pub fn after<'a>(arguments: &'a [String], flag: &str) -> Option<&'a [String]> {
    arguments.iter().position(|argument| argument == flag).map(|at| &arguments[at + 1..])
}

/// The lower of the two in the middle, where there are two.
///
/// # Panics
/// If there is no value.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() - 1) / 2]
}
