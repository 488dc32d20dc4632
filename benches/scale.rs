//! Whole drawings at growing sizes, as a table; see the crate's text for how to read it.
//!
//! Every size runs in a process of its own (this program again, with `--child`), so that each has its own peak of memory and
//! none finds the heap that another left behind.

use std::collections::BTreeMap;
use std::error::Error;
use std::process::{Command, Stdio};
use std::time::Instant;

use graphstipple_bench::{Photo, is_smoke_run, options, photo};
use graphstipple_core::Options;
use graphstipple_core::control::Control;
use graphstipple_core::pipeline::draw;
use spade::{DelaunayTriangulation, Point2, Triangulation as _};

/// A size to measure.
#[derive(Clone, Copy)]
struct Size {
    width: usize,
    height: usize,
    /// Drawings of which the median counts.
    runs: usize,
}

impl Size {
    const fn new(width: usize, height: usize, runs: usize) -> Self {
        Self { width, height, runs }
    }

    fn pixels(self) -> f64 {
        (self.width * self.height) as f64
    }
}

/// A common small photo, then 1, 4 and 16 megapixels. Growth is counted from [`BASE`] on.
const SIZES: [Size; 4] = [Size::new(1024, 768, 5), Size::new(1152, 864, 5), Size::new(2304, 1728, 3), Size::new(4608, 3456, 1)];

/// The same on tiny photos.
const TINY_SIZES: [Size; 3] = [Size::new(32, 24, 1), Size::new(40, 30, 1), Size::new(80, 60, 2)];

/// Which of the sizes the larger ones are compared with.
const BASE: usize = 1;

/// What a child measured: the names in `stats.seconds`, and a few more.
type Measures = BTreeMap<String, f64>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |wanted: &str| arguments.iter().position(|a| a == wanted).map(|i| &arguments[i + 1..]);
    if let Some([width, height, runs, ..]) = after("--child") {
        for (name, value) in measure(Size::new(width.parse()?, height.parse()?, runs.parse()?))? {
            println!("{name}\t{value}");
        }
        return Ok(());
    }
    let quick = is_smoke_run() || arguments.iter().any(|a| a == "--quick");
    let largest = match after("--up-to") {
        Some(rest) => rest.first().ok_or("--up-to needs a number of megapixels")?.parse()?,
        None => f64::INFINITY,
    };
    let mut sizes = if quick { TINY_SIZES.to_vec() } else { SIZES.to_vec() };
    sizes.retain(|size| size.pixels() <= 1e6 * largest);
    let columns = sizes.into_iter().map(|size| Ok((size, in_child(size)?))).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    print!("{}", table(&columns));
    Ok(())
}

/// Measures one size in a process of its own.
fn in_child(size: Size) -> Result<Measures, Box<dyn Error>> {
    eprintln!("{} x {} pixels: {} drawing(s) ...", size.width, size.height, size.runs);
    let output = Command::new(std::env::current_exe()?)
        .arg("--child")
        .args([size.width, size.height, size.runs].map(|n| n.to_string()))
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("the drawing of {} x {} pixels failed: {}", size.width, size.height, output.status).into());
    }
    let mut measures = Measures::new();
    for line in String::from_utf8(output.stdout)?.lines() {
        let (name, value) = line.split_once('\t').ok_or_else(|| format!("a child wrote the unexpected line {line:?}"))?;
        measures.insert(name.to_owned(), value.parse()?);
    }
    Ok(measures)
}

/// Medians over all runs at one size.
fn measure(size: Size) -> Result<Measures, Box<dyn Error>> {
    let Photo { luma, importance } = photo(size.width, size.height);
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut measures = Measures::new();
    for run in 0..size.runs {
        let exact = Options { tolerance: 0.0, ..options() };
        let outcome = draw(&luma, &importance, &exact, &Control::new())?;
        if run == 0 {
            // Before spade gets its own share of the memory.
            if let Some(bytes) = peak_memory() {
                measures.insert("memory".to_owned(), bytes);
            }
            measures.insert("nodes".to_owned(), outcome.stats.nodes as f64);
        }
        let points: Vec<Point2<f64>> = outcome.graph.sites.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let began = Instant::now();
        let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load(points)?;
        let spade = began.elapsed().as_secs_f64();
        assert_eq!(mesh.num_vertices(), outcome.stats.nodes, "spade loaded another graph");
        let total = outcome.stats.seconds["total"];
        let fitted = draw(&luma, &importance, &options(), &Control::new())?.stats.seconds;
        let own = [
            ("spade".to_owned(), spade),
            ("ratio".to_owned(), total / spade),
            ("fitted_outlines".to_owned(), fitted["outlines"]),
            ("fitted_ratio".to_owned(), fitted["total"] / spade),
        ];
        for (name, value) in outcome.stats.seconds.into_iter().chain(own) {
            found.entry(name).or_default().push(value);
        }
    }
    measures.extend(found.into_iter().map(|(name, values)| (name, median(values))));
    Ok(measures)
}

/// The lower of the two in the middle, where there are two.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() - 1) / 2]
}

/// The highest resident size of this process so far, in bytes; `None` where the system does not say.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// A row of the table: what a child measured, in other units.
struct Row {
    name: &'static str,
    measure: &'static str,
    factor: fn(Size) -> f64,
    digits: usize,
    /// Whether the table says how it grows.
    grows: bool,
}

impl Row {
    /// A time in seconds, and how it grows.
    const fn seconds(name: &'static str, measure: &'static str) -> Self {
        Self { name, measure, factor: |_| 1.0, digits: 3, grows: true }
    }

    const fn other(name: &'static str, measure: &'static str, digits: usize, factor: fn(Size) -> f64) -> Self {
        Self { name, measure, factor, digits, grows: false }
    }
}

/// The stages are in the order of the pipeline and have their names in `stats.seconds`.
const ROWS: [Row; 16] = [
    Row::seconds("lattice", "lattice"),
    Row::seconds("importance", "importance"),
    Row::seconds("relaxation", "relaxation"),
    Row::seconds("triangulation", "triangulation"),
    Row::seconds("tone", "tone"),
    Row::seconds("diffusion", "diffusion"),
    Row::seconds("outlines", "outlines"),
    Row::seconds("total", "total"),
    Row::other("ns a pixel", "total", 0, |size| 1e9 / size.pixels()),
    Row::other("nodes kept", "nodes", 0, |_| 1.0),
    Row::seconds("spade bulk load", "spade"),
    Row::other("total / spade", "ratio", 2, |_| 1.0),
    Row::seconds("outlines, fitted", "fitted_outlines"),
    Row::other("total, fitted / spade", "fitted_ratio", 2, |_| 1.0),
    Row::other("peak memory, MB", "memory", 0, |_| 1e-6),
    Row::other("bytes a pixel", "memory", 0, |size| 1.0 / size.pixels()),
];

/// The whole table: a column a size, then a column of growth for every size beyond [`BASE`].
fn table(columns: &[(Size, Measures)]) -> String {
    let grown = &columns[columns.len().min(BASE + 1)..];
    let line = |name: &str, cells: Vec<String>, growth: Vec<String>| {
        let right = |cells: Vec<String>| cells.iter().map(|cell| format!("{cell:>13}")).collect::<String>();
        let bar = if grown.is_empty() { "" } else { "   |" };
        format!("{}\n", format!("{name:<22}{}{bar}{}", right(cells), right(growth)).trim_end())
    };
    let each = |columns: &[(Size, Measures)], cell: &dyn Fn(Size, &Measures) -> String| -> Vec<String> {
        columns.iter().map(|(size, measures)| cell(*size, measures)).collect()
    };

    let runs = each(columns, &|size, _| size.runs.to_string()).join(", ");
    let threads = rayon::current_num_threads();
    let mut text = format!(
        "\nPhoto and map to drawing, density 1, 0.3 nodes a pixel: seconds with {threads} threads, medians of {runs} runs\n\n"
    );
    let megapixels = |size: Size, _: &Measures| format!("{:.*} MP", if size.pixels() < 1e5 { 4 } else { 2 }, size.pixels() / 1e6);
    text +=
        &line("", each(columns, &|size, _| format!("{} x {}", size.width, size.height)), each(grown, &|_, _| "growth to".into()));
    text += &line("", each(columns, &megapixels), each(grown, &megapixels));
    for row in &ROWS {
        let value = |size, measures: &Measures| match measures.get(row.measure) {
            Some(value) => format!("{:.*}", row.digits, value * (row.factor)(size)),
            None => "-".into(),
        };
        let growth = |size: Size, measures: &Measures| {
            let (base_size, base) = &columns[BASE];
            let time = |measures: &Measures| measures.get(row.measure).copied().unwrap_or(f64::NAN);
            let effort = |size: Size| size.pixels() * size.pixels().ln();
            format!("{:.2}", time(measures) / time(base) / (effort(size) / effort(*base_size)))
        };
        text += &line(row.name, each(columns, &value), if row.grows { each(grown, &growth) } else { Vec::new() });
    }
    text
}
