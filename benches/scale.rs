//! Whole drawings at growing sizes, as a table; see the crate's text for how to read it.
//!
//! Every size runs in a process of its own (this program again, with `--bare`), so that each has its own peak of memory and
//! none finds the heap that another left behind.

use std::collections::BTreeMap;
use std::error::Error;
use std::process::{Command, Stdio};
use std::time::Instant;

use graphstipple_bench::{Limit, Photo, after, is_smoke_run, median, options, photo};
use graphstipple_core::stages::{Alpha, Checked};
use graphstipple_core::{Control, Options, Published, Session, draw};
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

/// A common small photo, then 1, 4, 16 and 24 megapixels. Growth is counted from [`BASE`] on.
const SIZES: [Size; 5] = [
    Size::new(1024, 768, 5),
    Size::new(1152, 864, 7),
    Size::new(2304, 1728, 3),
    Size::new(4608, 3456, 3),
    Size::new(6000, 4000, 1),
];

/// The same on tiny photos.
const TINY_SIZES: [Size; 5] =
    [Size::new(32, 24, 1), Size::new(40, 30, 1), Size::new(80, 60, 2), Size::new(84, 63, 1), Size::new(96, 64, 1)];

/// Which of the sizes the larger ones are compared with.
const BASE: usize = 1;

/// Which of the sizes have limits too.
const SIXTEEN: usize = 3;
const TWENTY_FOUR: usize = 4;

/// The largest size without `--up-to`, in megapixels: a larger one takes minutes or many gigabytes.
const UP_TO: f64 = 16.0;

/// How many nodes the lattice has, and how many of them are kept.
#[derive(Clone, Copy)]
enum Nodes {
    /// As the default options have it.
    Default,
    Given {
        density: f64,
        nodes_per_pixel: f64,
    },
}

impl Nodes {
    /// The share of the lattice's nodes that is kept by default, at another density.
    fn at_density(density: f64) -> Self {
        let nodes_per_pixel = options().nodes_per_pixel.expect("the measured options have a budget") * density;
        Self::Given { density, nodes_per_pixel }
    }

    fn options(self) -> Result<Checked<Options>, Box<dyn Error>> {
        let options = match self {
            Self::Default => Options::default(),
            Self::Given { density, nodes_per_pixel } => {
                let published = Published { density: Some(density), ..Published::ours() };
                Options { nodes_per_pixel: Some(nodes_per_pixel), published, ..Options::default() }
            }
        };
        Ok(options.check()?)
    }

    /// As arguments to a child.
    fn arguments(self) -> Vec<String> {
        match self {
            Self::Default => vec!["default".to_owned()],
            Self::Given { density, nodes_per_pixel } => vec![density.to_string(), nodes_per_pixel.to_string()],
        }
    }

    fn parse(arguments: &[String]) -> Result<Self, Box<dyn Error>> {
        Ok(match arguments {
            [word, ..] if word == "default" => Self::Default,
            [density, nodes_per_pixel, ..] => Self::Given { density: density.parse()?, nodes_per_pixel: nodes_per_pixel.parse()? },
            _ => return Err("a child needs a density and nodes a pixel, or the word default".into()),
        })
    }
}

/// What a child measured: the names in `stats.seconds`, and a few more.
type Measures = BTreeMap<String, f64>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some([width, height, runs, nodes @ ..]) = after(&arguments, "--bare") {
        let size = Size::new(width.parse()?, height.parse()?, runs.parse()?);
        for (name, value) in measure(size, &Nodes::parse(nodes)?.options()?)? {
            println!("{name}\t{value}");
        }
        return Ok(());
    }
    if let Some([width, height, path, ..]) = after(&arguments, "--photo") {
        return write_photo(width.parse()?, height.parse()?, path);
    }
    let number = |flag: &str, default: f64| -> Result<f64, Box<dyn Error>> {
        Ok(match after(&arguments, flag) {
            Some(rest) => rest.first().ok_or_else(|| format!("{flag} needs a number"))?.parse()?,
            None => default,
        })
    };
    let tiny = is_smoke_run() || after(&arguments, "--quick").is_some();
    if after(&arguments, "--memory").is_some() {
        print!("{}", memory_table(if tiny { TINY_SIZES[2] } else { Size { runs: 1, ..SIZES[2] } })?);
        return Ok(());
    }
    let (density, up_to) = (number("--density", 1.0)?, number("--up-to", UP_TO)?);
    let mut sizes = if tiny { TINY_SIZES.to_vec() } else { SIZES.to_vec() };
    sizes.retain(|size| size.pixels() <= 1e6 * up_to);
    let nodes = Nodes::at_density(density);
    let columns = sizes.into_iter().map(|size| Ok((size, in_child(size, nodes)?))).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    print!("{}", table(&columns, density));
    if density == 1.0 {
        print!("{}", targets(&columns)?);
    }
    Ok(())
}

/// Writes the photo that is measured as a PGM, for programs that are to draw the same.
fn write_photo(width: usize, height: usize, path: &str) -> Result<(), Box<dyn Error>> {
    let mut file = format!("P5 {width} {height} 255\n").into_bytes();
    file.extend(photo(width, height).luma().values().iter().map(|value| (255.0 * value + 0.5) as u8));
    Ok(std::fs::write(path, file)?)
}

/// Measures one size in a process of its own.
fn in_child(size: Size, nodes: Nodes) -> Result<Measures, Box<dyn Error>> {
    eprintln!("{} x {} pixels: {} drawing(s) ...", size.width, size.height, size.runs);
    let output = Command::new(std::env::current_exe()?)
        .arg("--bare")
        .args([size.width, size.height, size.runs].map(|n| n.to_string()))
        .args(nodes.arguments())
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
fn measure(size: Size, options: &Checked<Options>) -> Result<Measures, Box<dyn Error>> {
    let Photo { photo, importance } = photo(size.width, size.height);
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut measures = Measures::new();
    for run in 0..size.runs {
        let outcome = draw(&photo, &importance, options, &Control::new())?;
        if run == 0 {
            // Before spade gets its own share of the memory.
            if let Some(bytes) = peak_memory() {
                measures.insert("memory".to_owned(), bytes);
            }
            measures.insert("nodes".to_owned(), outcome.stats.nodes as f64);
            measures.insert("lattice_nodes".to_owned(), outcome.stats.lattice_nodes as f64);
        }
        let points: Vec<Point2<f64>> = outcome.graph.sites.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let began = Instant::now();
        let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load(points)?;
        let spade = began.elapsed().as_secs_f64();
        assert_eq!(mesh.num_vertices(), outcome.stats.nodes, "spade loaded another graph");
        let total = outcome.stats.seconds["total"];
        let mut session = Session::new(photo.clone(), importance.clone());
        let published = Published { alpha: Alpha::Dynamic, ..options.published };
        session.draw(&Options { published, ..options.clone().into_inner() }.check()?, &Control::new())?;
        let relabel = session.draw(options, &Control::new())?.stats.seconds["total"];
        let own = [
            ("spade".to_owned(), spade),
            ("ratio".to_owned(), total / spade),
            ("relabel".to_owned(), relabel),
            ("relabel_share".to_owned(), relabel / total),
        ];
        for (name, value) in outcome.stats.seconds.into_iter().chain(own) {
            found.entry(name).or_default().push(value);
        }
    }
    measures.extend(found.into_iter().map(|(name, values)| (name, median(values))));
    Ok(measures)
}

/// The highest resident size of this process so far, in bytes; `None` where the system does not say.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// What was measured, or no number where the system did not say.
fn of(measures: &Measures, name: &str) -> f64 {
    measures.get(name).copied().unwrap_or(f64::NAN)
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
    Row::seconds("relabel", "relabel"),
    Row::other("relabel / full", "relabel_share", 2, |_| 1.0),
    Row::other("peak memory, MB", "memory", 0, |_| 1e-6),
    Row::other("bytes a pixel", "memory", 0, |size| 1.0 / size.pixels()),
];

/// The whole table: a column a size, then a column of growth for every size beyond [`BASE`].
fn table(columns: &[(Size, Measures)], density: f64) -> String {
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
        "\nPhoto and map to drawing, density {density}, {:.1} nodes a pixel: seconds with {threads} threads, medians of {runs} runs\n\n",
        0.3 * density
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
            let effort = |size: Size| size.pixels() * size.pixels().ln();
            format!("{:.2}", of(measures, row.measure) / of(base, row.measure) / (effort(size) / effort(*base_size)))
        };
        text += &line(row.name, each(columns, &value), if row.grows { each(grown, &growth) } else { Vec::new() });
    }
    text
}

/// What is to be reached at density 1, as far as its sizes are there.
fn targets(columns: &[(Size, Measures)]) -> Result<String, Box<dyn Error>> {
    let mut lines = Vec::new();
    let mut line = |title: &str, figure: f64, digits: usize, limit: f64, note: String| {
        lines.push(format!("{title:<58}{figure:>10.digits$}{}{note}\n", Limit::AtMost(limit).cells(figure)));
    };
    let mut runs = Vec::new();
    if let Some((size, one)) = columns.get(BASE) {
        runs.push(size.runs);
        let (total, spade) = (of(one, "total"), of(one, "spade"));
        let note = format!("{total:.3} s, spade {spade:.3} s");
        line("core / spade's bulk load of the same sites", of(one, "ratio"), 2, 2.5, note);
        if let Some((size, sixteen)) = columns.get(SIXTEEN) {
            runs.push(size.runs);
            let note = format!("{:.2} s", of(sixteen, "total"));
            line("core at 16 megapixels / at 1", of(sixteen, "total") / total, 1, 18.0, note);
        }
    }
    if let Some((size, large)) = columns.get(TWENTY_FOUR) {
        runs.push(size.runs);
        let mut peak = |title, measures: &Measures, limit| {
            line(title, of(measures, "memory") / 1e9, 2, limit, format!("{:.2} s", of(measures, "total")));
        };
        peak("24 megapixels: peak memory, GB", large, 2.4);
        peak("24 megapixels, default budget: peak memory, GB", &in_child(*size, Nodes::Default)?, 1.0);
    }
    let runs = runs.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let head = format!("\n{:<58}{:>10}{:>10}\n", format!("to reach; medians of {runs} runs"), "measured", "limit");
    Ok(if lines.is_empty() { String::new() } else { head + &lines.concat() })
}

/// What one more pixel, lattice node and site add to the peak of memory: a size, and the same with twice as many of one alone.
fn memory_table(size: Size) -> Result<String, Box<dyn Error>> {
    let memory = |size: Size, density: f64, nodes_per_pixel: f64| -> Result<f64, Box<dyn Error>> {
        Ok(of(&in_child(size, Nodes::Given { density, nodes_per_pixel })?, "memory"))
    };
    let pixels = size.pixels();
    let base = memory(size, 1.0, 0.3)?;
    let rows = [
        ("pixel", memory(Size { width: 2 * size.width, ..size }, 0.5, 0.15)?, pixels),
        ("lattice node", memory(size, 2.0, 0.3)?, pixels),
        ("site", memory(size, 1.0, 0.6)?, 0.3 * pixels),
    ];
    let mut text = format!(
        "\nPeak memory at {} x {} pixels, density 1, 0.3 nodes a pixel: {:.0} MB, {:.0} bytes a pixel\n\n{:<22}{:>13}{:>13}\n",
        size.width,
        size.height,
        base / 1e6,
        base / pixels,
        "with twice as many",
        "peak, MB",
        "bytes each"
    );
    for (name, peak, added) in rows {
        text += &format!("{:<22}{:>13.0}{:>13.0}\n", format!("{name}s"), peak / 1e6, (peak - base) / added);
    }
    Ok(text)
}
