//! Voronoi cells on a grid of samples: areas, centroids and field means of cells, and Lloyd relaxation.
//!
//! The canvas carries `samples_per_pixel` x `samples_per_pixel` samples a pixel, sample (i, j) at `((i + 0.5) / s, (j + 0.5) / s)`.
//! Every sample belongs to its nearest site, the lower index on ties. Where sites are many, which is nearly everywhere on nearly all
//! canvases, the samples of a small *block* are compared with all sites around it at once. Elsewhere the owners are found box by
//! box, from the canvas down: a box with few sites in and around it, near enough to own all of it, is done with those; a crowded
//! one is quartered; and a box whose owners are far away *narrows down* the candidates of the box around it. A site can own a point
//! of a box only if, against every other site, it is nearer at some corner: what is nearer to one of two sites is a half-plane, and
//! a half-plane that meets a box holds a corner of it. So large empty cells cost as little as small ones.
//!
//! Threads share out tiles of the canvas. Every tile adds up what its samples say of the sites in and around it, and those sums are
//! put together in the order of the tiles: the result does not depend on the threads.
//!
//! What this module does not do: exact polygonal cells. Source: the paper (node values, relaxation).

use rayon::prelude::*;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, check_size};
use crate::graph::{Adjacency, cumulate};
use crate::lattice::{FRAME_MARGIN, Lattice};

/// What the samples say of every site's cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Samples that the site owns.
    pub counts: Vec<u32>,
    /// Area in px^2: samples owned over samples a pixel.
    pub areas: Vec<f64>,
    /// Mean position of the samples; the site itself if it owns none.
    pub centroids: Vec<[f64; 2]>,
    /// Mean of the field over the samples, or its bilinear value at a site that owns none. Empty without a field.
    pub means: Vec<f32>,
}

/// Samples a pixel, along one axis, for lattice cells of `1 / density` px^2: at least four samples a cell.
pub fn samples_per_pixel(density: f64) -> usize {
    (2.0 * density.sqrt() - 1e-9).ceil().max(1.0) as usize
}

/// Areas, centroids and means of the cells of any sites.
///
/// # Errors
/// [`Error::Input`] if there is no site, a site is not inside the canvas, `samples_per_pixel` is not between 1 and 16, or the field
/// has another size than the canvas; [`Error::Cancelled`].
///
/// # Runtime
/// About `n log n` in samples and sites.
pub fn cells(
    sites: &[[f64; 2]],
    width: usize,
    height: usize,
    samples_per_pixel: usize,
    field: Option<&Field>,
    control: &Control,
) -> Result<Cells> {
    check(sites, width, height, samples_per_pixel, field)?;
    let mut sums = vec![Sums::default(); sites.len()];
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    canvas.add_up(field, control, |site, part| {
        let sum = &mut sums[site as usize];
        sum.count += part.count;
        sum.columns += part.columns;
        sum.rows += part.rows;
        sum.values += part.values;
    })?;
    Ok(finish(&sums, sites, samples_per_pixel, field))
}

/// What the diffusion of tone needs of every site's cell.
#[derive(Debug, Clone, PartialEq)]
pub struct TonedCells {
    /// As [`Cells::areas`].
    pub areas: Vec<f64>,
    /// As [`Cells::means`].
    pub means: Vec<f32>,
}

/// Areas and means alone, equal to those of [`cells`], in less memory: 24 bytes a site at the peak, the sites sorted into bins apart.
///
/// # Errors
/// As [`cells`].
pub fn toned_cells(sites: &[[f64; 2]], field: &Field, samples_per_pixel: usize, control: &Control) -> Result<TonedCells> {
    let (width, height) = (field.width(), field.height());
    check(sites, width, height, samples_per_pixel, Some(field))?;
    let (mut counts, mut values) = (vec![0u32; sites.len()], vec![0f64; sites.len()]);
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    canvas.add_up(Some(field), control, |site, part| {
        counts[site as usize] += part.count;
        values[site as usize] += part.values;
    })?;
    let mean = |((sum, count), site): ((&f64, &u32), &[f64; 2])| mean_of(*sum, *count, *site, field);
    let means = values.par_iter().zip(&counts).zip(sites).map(mean).collect();
    drop(values);
    Ok(TonedCells { areas: counts.par_iter().map(|count| area_of(*count, samples_per_pixel)).collect(), means })
}

/// The mean of the field over every lattice cell, the nearest node being known in closed form.
///
/// # Errors
/// [`Error::Input`] if `samples_per_pixel` is not between 1 and 16; [`Error::Cancelled`].
pub fn lattice_means(lattice: &Lattice, field: &Field, samples_per_pixel: usize, control: &Control) -> Result<Vec<f32>> {
    check(&[lattice.site(0)], field.width(), field.height(), samples_per_pixel, Some(field))?;
    let (step, sample_rows) = (1.0 / samples_per_pixel as f64, field.height() * samples_per_pixel);
    let around = |row: usize| lattice.rows_around((row as f64 + 0.5) * step);
    // Of every sample column, for even and for odd rows of the lattice: the nearest node of a row and its squared distance along it.
    let columns: [Vec<(u32, f64)>; 2] = std::array::from_fn(|parity| {
        let x = |column: usize| (column as f64 + 0.5) * step;
        (0..field.width() * samples_per_pixel).map(|column| lattice.nearest_column(parity, x(column))).collect()
    });
    control.check()?;
    let mut means = vec![0f32; lattice.len()];
    // Bands of the lattice's rows, an even number, so that all begin alike. Samples that two bands lie around are looked at in both.
    let band = BAND * lattice.nodes_in_two_rows();
    means.par_chunks_mut(band).enumerate().for_each(|(number, means)| {
        let begin = number * band;
        let first = first_row(sample_rows, |row| around(row)[1].end() > begin);
        let last = first_row(sample_rows, |row| around(row)[0].start() >= begin + means.len());
        let start = if first < last { around(first)[0].start() } else { begin };
        let end = if first < last { around(last - 1)[1].end() } else { begin };
        let mut sums = vec![(0u32, 0f64); end.max(begin + means.len()) - start];
        for row in first..last {
            let [above, below] = around(row);
            let values = &field.values()[row / samples_per_pixel * field.width()..][..field.width()];
            let pixels = values.iter().zip(columns[above.parity()].chunks_exact(samples_per_pixel));
            for ((value, above_columns), below_columns) in pixels.zip(columns[below.parity()].chunks_exact(samples_per_pixel)) {
                for (a, b) in above_columns.iter().zip(below_columns) {
                    let is_below = b.1 + below.dy_squared() < a.1 + above.dy_squared();
                    let node = if is_below { below.start() + b.0 as usize } else { above.start() + a.0 as usize };
                    let sum = &mut sums[node - start];
                    sum.0 += 1;
                    sum.1 += f64::from(*value);
                }
            }
        }
        for ((node, mean), (count, sum)) in (begin..).zip(means).zip(&sums[begin - start..]) {
            *mean = mean_of(*sum, *count, lattice.site(node), field);
        }
    });
    Ok(means)
}

/// The owner of every sample: row-major, `width * samples_per_pixel` by `height * samples_per_pixel`.
///
/// # Errors
/// As [`cells`].
pub fn owners(sites: &[[f64; 2]], width: usize, height: usize, samples_per_pixel: usize, control: &Control) -> Result<Vec<u32>> {
    check(sites, width, height, samples_per_pixel, None)?;
    let stride = width * samples_per_pixel;
    let mut owners = vec![0; stride * height * samples_per_pixel];
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    canvas.for_each_tile(
        control,
        |_, area| OwnersOf::new(area),
        |_, tile| {
            for (row, line) in (tile.area.y.0..tile.area.y.1).zip(tile.owners.chunks_exact(tile.area.width())) {
                owners[row * stride + tile.area.x.0..][..line.len()].copy_from_slice(line);
            }
        },
    )?;
    Ok(owners)
}

/// The first of `rows` rows from which on something holds; `rows` if it never does.
fn first_row(rows: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, rows);
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// Lloyd relaxation: `steps` times, every site moves to the centroid of its cell (0.001 px inside the frame at least).
///
/// # Errors
/// As [`cells`].
pub fn relax(
    mut sites: Vec<[f64; 2]>,
    width: usize,
    height: usize,
    steps: u32,
    samples_per_pixel: usize,
    control: &Control,
) -> Result<Vec<[f64; 2]>> {
    let limits = [width as f64 - FRAME_MARGIN, height as f64 - FRAME_MARGIN];
    for step in 0..steps {
        control.report(step as f32 / steps as f32)?;
        check(&sites, width, height, samples_per_pixel, None)?;
        let mut sums = vec![(0u32, [0u64; 2]); sites.len()];
        let canvas = Samples { sites: &sites, width, height, per_pixel: samples_per_pixel };
        canvas.add_up(None, control, |site, part| {
            let (count, [columns, rows]) = &mut sums[site as usize];
            *count += part.count;
            *columns += part.columns;
            *rows += part.rows;
        })?;
        for (site, (count, [columns, rows])) in sites.iter_mut().zip(sums) {
            let [x, y] = centroid_of([columns, rows], count, *site, samples_per_pixel);
            *site = [x.clamp(FRAME_MARGIN, limits[0]), y.clamp(FRAME_MARGIN, limits[1])];
        }
    }
    Ok(sites)
}

/// Side of a tile in samples: tiles are what threads share out. Smaller ones have more sites in common, whose sums are then put
/// together; the sums of larger ones leave the fastest cache. A tile's sums fit their bits up to 256.
const TILE: usize = 128;

/// Pairs of lattice rows whose means one thread computes at once.
const BAND: usize = 16;

/// Tiles between two looks at the cancellation flag. Sums of twice as many are in memory at once: of those that are put together,
/// and of those that are made meanwhile.
const TILES_AT_ONCE: usize = 128;

/// Side of the boxes, in samples, in which blocks are looked at one by one if they are crowded.
const CROWDED_BOX: usize = 32;

/// Width and height of a block in samples, the width being that of a [`LEAF`]. Larger ones compare each sample with more sites,
/// smaller ones fetch the sites around them more often.
const BLOCK: [usize; 2] = [LEAF, 4];

/// Side of the bins, in samples, in which sites are looked up, and by which the surroundings of a block grow until all owners are
/// in them. Smaller ones cost more to walk through, larger ones hold sites that are too far away.
const BIN: usize = 4;

/// How far from a block owners are looked for, in samples, before it is left to the boxes.
const FARTHEST: usize = 16;

/// The most sites that a block is compared with, a power of two; a block with more around it is left to the boxes.
const MOST_CANDIDATES: usize = 64;

/// Steps to a squared sample in which blocks compare squared distances: as many as let one coordinate's square up to
/// `(FARTHEST + 0.5)^2` stay below 2^16 steps.
const STEPS: f32 = 240.0;

/// Squared distances nearer to each other than this, in steps, are compared again exactly: both are rounded twice.
const UNSURE: f32 = 3.0;

/// Side of the smallest boxes, in samples, in which every sample is compared with every candidate. Smaller ones narrow down more
/// often, larger ones compare more.
const LEAF: usize = 8;

/// A box with more sites in and around it is quartered, if it can be, before they are looked at one by one.
const CROWD: usize = 64;

/// A leaf with more candidates than this narrows them down before it compares them with every sample.
const WORTH_NARROWING: usize = 24;

fn check(sites: &[[f64; 2]], width: usize, height: usize, samples_per_pixel: usize, field: Option<&Field>) -> Result<()> {
    check_size(width, height)?;
    if !(1..=16).contains(&samples_per_pixel) {
        return Err(Error::Input(format!("samples_per_pixel is {samples_per_pixel}, but it must be between 1 and 16")));
    }
    if let Some(field) = field.filter(|f| f.width() != width || f.height() != height) {
        return Err(Error::Input(format!(
            "the field is {} x {} pixels, but the canvas is {width} x {height}",
            field.width(),
            field.height()
        )));
    }
    check_sites(sites, width, height)
}

/// # Errors
/// [`Error::Input`] if there is no site or one does not lie at least [`FRAME_MARGIN`] inside the canvas.
pub(crate) fn check_sites(sites: &[[f64; 2]], width: usize, height: usize) -> Result<()> {
    if sites.is_empty() {
        return Err(Error::Input("there are no sites, but at least one is needed".into()));
    }
    if sites.len() > u32::MAX as usize / 8 {
        return Err(Error::Input(format!("there are {} sites, but at most {} are possible", sites.len(), u32::MAX / 8)));
    }
    // Half the margin, so that a site clamped to the margin passes whatever the rounding.
    let margin = FRAME_MARGIN / 2.0;
    let inside = |v: f64, length: usize| v >= margin && v <= length as f64 - margin;
    match sites.iter().position(|s| !(inside(s[0], width) && inside(s[1], height))) {
        None => Ok(()),
        Some(i) => Err(Error::Input(format!(
            "site {i} is at ({}, {}), but it must lie at least {FRAME_MARGIN} px inside the canvas of {width} x {height} px",
            sites[i][0], sites[i][1]
        ))),
    }
}

/// Running sums of a cell, or of a part of it. Positions are summed as integers, so that their order does not matter.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: u32,
    columns: u64,
    rows: u64,
    values: f64,
}

fn area_of(count: u32, samples_per_pixel: usize) -> f64 {
    let step = 1.0 / samples_per_pixel as f64;
    f64::from(count) * step * step
}

/// The mean position of `count` samples whose columns and rows have these sums, in pixels; the site itself without samples.
fn centroid_of(sums: [u64; 2], count: u32, site: [f64; 2], samples_per_pixel: usize) -> [f64; 2] {
    if count == 0 {
        return site;
    }
    let step = 1.0 / samples_per_pixel as f64;
    sums.map(|sum| (sum as f64 / f64::from(count) + 0.5) * step)
}

fn mean_of(sum: f64, count: u32, [x, y]: [f64; 2], field: &Field) -> f32 {
    if count > 0 { (sum / f64::from(count)) as f32 } else { field.bilinear(x, y) }
}

fn finish(sums: &[Sums], sites: &[[f64; 2]], samples_per_pixel: usize, field: Option<&Field>) -> Cells {
    let both = || sums.par_iter().zip(sites);
    let centroid = |(s, site): (&Sums, &[f64; 2])| centroid_of([s.columns, s.rows], s.count, *site, samples_per_pixel);
    Cells {
        counts: sums.par_iter().map(|s| s.count).collect(),
        areas: sums.par_iter().map(|s| area_of(s.count, samples_per_pixel)).collect(),
        centroids: both().map(centroid).collect(),
        means: field.map_or_else(Vec::new, |field| both().map(|(s, site)| mean_of(s.values, s.count, *site, field)).collect()),
    }
}

/// A box of samples: columns `x.0..x.1`, rows `y.0..y.1`.
#[derive(Debug, Clone, Copy)]
struct Box2 {
    x: (usize, usize),
    y: (usize, usize),
}

impl Box2 {
    fn width(self) -> usize {
        self.x.1 - self.x.0
    }

    fn longest_side(self) -> usize {
        self.width().max(self.y.1 - self.y.0)
    }

    /// The boxes of at most `side` samples a side, on the grid of that side, that make up this one.
    fn split(self, side: usize) -> impl Iterator<Item = Self> {
        let cut = move |(begin, end): (usize, usize)| {
            (begin / side..end.div_ceil(side)).map(move |k| (begin.max(k * side), end.min((k + 1) * side)))
        };
        cut(self.y).flat_map(move |y| cut(self.x).map(move |x| Self { x, y }))
    }

    /// The blocks that make up this one, on their grid.
    fn blocks(self) -> impl Iterator<Item = Self> {
        let [wide, high] = BLOCK;
        let cut = |(begin, end): (usize, usize), side: usize| (begin..end).step_by(side).map(move |at| (at, end.min(at + side)));
        cut(self.y, high).flat_map(move |y| cut(self.x, wide).map(move |x| Self { x, y }))
    }

    /// The outermost sample positions, in samples: left, right, top, bottom.
    fn extent(self) -> [f64; 4] {
        [self.x.0 as f64 + 0.5, self.x.1 as f64 - 0.5, self.y.0 as f64 + 0.5, self.y.1 as f64 - 0.5]
    }
}

/// A site that may own samples of a box; its position in samples.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    x: f64,
    y: f64,
    site: u32,
}

/// All sites, sorted into bins of [`BIN`] samples a side.
struct Bins<'a> {
    sites: &'a [[f64; 2]],
    /// Samples a pixel.
    scale: f64,
    /// Start of every bin's sites in `order`, row by row of bins.
    offsets: Vec<u32>,
    order: Vec<u32>,
    columns: usize,
    rows: usize,
}

impl<'a> Bins<'a> {
    fn new(sites: &'a [[f64; 2]], canvas: Box2, samples_per_pixel: usize) -> Self {
        let scale = samples_per_pixel as f64;
        let (columns, rows) = (canvas.x.1.div_ceil(BIN), canvas.y.1.div_ceil(BIN));
        let bin = |[x, y]: &[f64; 2]| {
            let [column, row] = [x, y].map(|v| (v * scale) as usize / BIN);
            row.min(rows - 1) * columns + column.min(columns - 1)
        };
        // Counted one place further on, and filled in from there: then every start ends up in its own place.
        let mut offsets = vec![0u32; columns * rows + 2];
        for site in sites {
            offsets[bin(site) + 2] += 1;
        }
        cumulate(&mut offsets);
        let mut order = vec![0; sites.len()];
        for (number, site) in (0u32..).zip(sites) {
            let place = &mut offsets[bin(site) + 1];
            order[*place as usize] = number;
            *place += 1;
        }
        Self { sites, scale, offsets, order, columns, rows }
    }

    fn candidate(&self, site: u32) -> Candidate {
        let [x, y] = self.sites[site as usize];
        Candidate { x: x * self.scale, y: y * self.scale, site }
    }

    /// The columns and the rows of bins that lie within `reach` samples of a box.
    fn window(&self, area: Box2, reach: usize) -> [(usize, usize); 2] {
        let cut = |(begin, end): (usize, usize), limit: usize| {
            (begin.saturating_sub(reach) / BIN, (end + reach).div_ceil(BIN).min(limit))
        };
        [cut(area.x, self.columns), cut(area.y, self.rows)]
    }

    /// Where in `order` the sites of some bins of a row are.
    fn run(&self, row: usize, columns: (usize, usize)) -> std::ops::Range<usize> {
        let place = |column: usize| self.offsets[row * self.columns + column] as usize;
        place(columns.0)..place(columns.1)
    }

    /// The sites in the bins that lie within `reach` samples of a box, as runs of `order`, one a row of bins.
    fn around(&self, area: Box2, reach: usize) -> impl Iterator<Item = &[u32]> {
        let [columns, rows] = self.window(area, reach);
        (rows.0..rows.1).map(move |row| &self.order[self.run(row, columns)])
    }
}

/// A row of a block.
type Lane<T> = [T; BLOCK[0]];

/// A block of samples with the sites around it.
///
/// A squared distance is kept as a whole number of steps, and together with the number of its candidate in one f32 that is exact:
/// `64 steps + number`, below 2^23. So one addition of a column's part and a row's part gives both, and the least of such sums
/// says who is nearest. Samples whose two nearest are too near to each other for that are looked at again.
struct Block {
    /// How many candidates there are; what stands behind them is left from other blocks.
    count: usize,
    sites: [u32; MOST_CANDIDATES],
    /// Where in a tile's sums the sites are.
    slots: [u32; MOST_CANDIDATES],
    /// The sites' positions in samples, from the block's first sample.
    positions: [[f32; 2]; MOST_CANDIDATES],
    columns: [Lane<f32>; MOST_CANDIDATES],
    rows: [[f32; BLOCK[1]]; MOST_CANDIDATES],
    nearest: [Lane<f32>; BLOCK[1]],
    second: [Lane<f32>; BLOCK[1]],
}

/// What the steps are multiplied with, to share an f32 with the number of a candidate.
const SHARE: f32 = MOST_CANDIDATES as f32;

/// Adding it to a number below it, and 0 or above, rounds to a whole number, which the lowest bits then hold.
const WHOLE: f32 = 8_388_608.0;

impl Block {
    fn new() -> Self {
        Self {
            count: 0,
            sites: [0; MOST_CANDIDATES],
            slots: [0; MOST_CANDIDATES],
            positions: [[0.0; 2]; MOST_CANDIDATES],
            columns: [[0.0; BLOCK[0]]; MOST_CANDIDATES],
            rows: [[0.0; BLOCK[1]]; MOST_CANDIDATES],
            nearest: [[0.0; BLOCK[0]]; BLOCK[1]],
            second: [[0.0; BLOCK[0]]; BLOCK[1]],
        }
    }

    /// Finds the nearest sites of the block that is `area`, if they are near and not too many. `first_slot` says of a row of bins
    /// by how much the slots of its sites differ from their places in the order of bins.
    fn find(&mut self, bins: &Bins, area: Box2, first_slot: &impl Fn(usize) -> usize) -> bool {
        // The sum of two columns' and rows' parts is less.
        self.nearest = [[WHOLE; BLOCK[0]]; BLOCK[1]];
        self.second = self.nearest;
        self.count = 0;
        let mut inner = [(usize::MAX, usize::MAX); 2];
        let mut limit = f32::INFINITY;
        for reach in (BIN..=FARTHEST).step_by(BIN) {
            let window = bins.window(area, reach);
            let known = self.count;
            let [columns, rows] = window;
            for row in rows.0..rows.1 {
                let offset = first_slot(row);
                let is_known = (inner[1].0..inner[1].1).contains(&row);
                let parts = if is_known { [(columns.0, inner[0].0), (inner[0].1, columns.1)] } else { [columns, (0, 0)] };
                for columns in &parts[..1 + usize::from(is_known)] {
                    if !self.take(bins, area, bins.run(row, *columns), limit, offset) {
                        return false;
                    }
                }
            }
            self.compare(known);
            limit = self.farthest();
            // What was left out is further than `reach` away, and half a sample.
            if limit <= (reach * reach) as f32 {
                return true;
            }
            inner = window;
        }
        false
    }

    /// Adds sites that are nearer to the block than `limit` (squared), if there is room for them.
    #[inline(always)]
    fn take(&mut self, bins: &Bins, area: Box2, places: std::ops::Range<usize>, limit: f32, offset: usize) -> bool {
        if self.count + places.len() > MOST_CANDIDATES {
            return false;
        }
        let corner = [area.x.0 as f64 + 0.5, area.y.0 as f64 + 0.5];
        let far = [BLOCK[0] as f32 - 1.0, BLOCK[1] as f32 - 1.0];
        let first_slot = places.start.wrapping_sub(offset) as u32;
        for (slot, site) in (first_slot..).zip(&bins.order[places]) {
            let candidate = bins.candidate(*site);
            let position = [(candidate.x - corner[0]) as f32, (candidate.y - corner[1]) as f32];
            let beyond = |k: usize| {
                let before = if -position[k] > 0.0 { -position[k] } else { 0.0 };
                let behind = position[k] - far[k];
                if behind > before { behind } else { before }
            };
            // Room was made sure of above; the remainder tells the compiler so. A site too far away is written over by the next.
            let place = self.count % MOST_CANDIDATES;
            self.sites[place] = *site;
            self.slots[place] = slot;
            self.positions[place] = position;
            self.count += usize::from(beyond(0) * beyond(0) + beyond(1) * beyond(1) <= limit);
        }
        true
    }

    /// Compares all samples with the candidates from number `first` on.
    fn compare(&mut self, first: usize) {
        let new = first..self.count;
        let parts = self.columns[new.clone()].iter_mut().zip(&mut self.rows[new.clone()]);
        for (number, ((columns, rows), [x, y])) in (first as u32..).zip(parts.zip(&self.positions[new.clone()])) {
            *columns = std::array::from_fn(|i| shared_steps(i as f32 - x));
            *rows = std::array::from_fn(|j| shared_steps(j as f32 - y) + number as f32);
        }
        let (columns, rows) = (&self.columns[new.clone()], &self.rows[new]);
        for (j, (nearest, second)) in self.nearest.iter_mut().zip(&mut self.second).enumerate() {
            let (mut least, mut next) = (*nearest, *second);
            for (columns, rows) in columns.iter().zip(rows) {
                let row = rows[j];
                let sums = columns.map(|column| column + row);
                let larger: Lane<f32> = std::array::from_fn(|i| if sums[i] > least[i] { sums[i] } else { least[i] });
                next = std::array::from_fn(|i| if larger[i] < next[i] { larger[i] } else { next[i] });
                least = std::array::from_fn(|i| if sums[i] < least[i] { sums[i] } else { least[i] });
            }
            (*nearest, *second) = (least, next);
        }
    }

    /// No sample is further than this from its nearest candidate (squared).
    fn farthest(&self) -> f32 {
        let larger = |a: Lane<f32>, b: &Lane<f32>| std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] });
        let of_columns = self.nearest.iter().fold([0.0; BLOCK[0]], larger);
        let farthest = of_columns.iter().fold(0.0, |a, b| if a > *b { a } else { *b });
        (farthest / SHARE + UNSURE) / STEPS
    }

    /// The numbers of the nearest candidates of all samples.
    fn owners(&self, bins: &Bins, area: Box2) -> [Lane<u32>; BLOCK[1]] {
        let number = |nearest: f32| (nearest + WHOLE).to_bits() % MOST_CANDIDATES as u32;
        let mut owners = self.nearest.map(|nearest| nearest.map(number));
        let mut apart = [f32::INFINITY; BLOCK[0]];
        for (nearest, second) in self.nearest.iter().zip(&self.second) {
            let gaps: Lane<f32> = std::array::from_fn(|i| second[i] - nearest[i]);
            apart = std::array::from_fn(|i| if gaps[i] < apart[i] { gaps[i] } else { apart[i] });
        }
        if apart.iter().any(|gap| *gap <= (UNSURE + 1.0) * SHARE) {
            self.decide(bins, area, &mut owners);
        }
        owners
    }

    /// Compares samples exactly whose two nearest candidates are too near to each other; the lower index wins a tie.
    #[cold]
    fn decide(&self, bins: &Bins, area: Box2, owners: &mut [Lane<u32>; BLOCK[1]]) {
        for (j, owners) in owners.iter_mut().enumerate() {
            for (i, owner) in owners.iter_mut().enumerate() {
                if self.second[j][i] - self.nearest[j][i] > (UNSURE + 1.0) * SHARE {
                    continue;
                }
                let mut best = (f64::INFINITY, u32::MAX);
                for (number, site) in (0..).zip(&self.sites[..self.count]) {
                    let candidate = bins.candidate(*site);
                    let dx = area.x.0 as f64 + 0.5 - candidate.x + i as f64;
                    let dy = (area.y.0 + j) as f64 + 0.5 - candidate.y;
                    let distance = dx * dx + dy * dy;
                    if distance < best.0 || (distance == best.0 && *site < best.1) {
                        best = (distance, *site);
                        *owner = number;
                    }
                }
            }
        }
    }
}

/// The square of a coordinate's difference in whole steps, beside which the number of a candidate has room.
#[inline(always)]
fn shared_steps(difference: f32) -> f32 {
    let steps = difference * difference * STEPS;
    let steps = if steps < 65_535.0 { steps } else { 65_535.0 };
    (steps + WHOLE - WHOLE) * SHARE
}

/// Takes the owners of a tile.
trait Sink {
    /// By how much the slots of the sites in a row of bins differ from their places in the order of bins (wrapping).
    fn first_slot(&self, row: usize) -> usize;

    /// The samples of these columns of a row belong to a site.
    fn run(&mut self, row: usize, columns: std::ops::Range<usize>, site: u32);

    /// The owners of a block, as numbers of its candidates.
    fn block(&mut self, area: Box2, owners: &[Lane<u32>; BLOCK[1]], block: &Block);
}

/// The owner of every sample of a tile, row by row.
struct OwnersOf {
    area: Box2,
    owners: Vec<u32>,
}

impl OwnersOf {
    fn new(area: Box2) -> Self {
        Self { area, owners: vec![0; area.width() * (area.y.1 - area.y.0)] }
    }

    fn line(&mut self, row: usize, column: usize) -> &mut [u32] {
        let begin = (row - self.area.y.0) * self.area.width() + column - self.area.x.0;
        &mut self.owners[begin..]
    }
}

impl Sink for OwnersOf {
    fn first_slot(&self, _: usize) -> usize {
        0
    }

    fn run(&mut self, row: usize, columns: std::ops::Range<usize>, site: u32) {
        self.line(row, columns.start)[..columns.len()].fill(site);
    }

    fn block(&mut self, area: Box2, owners: &[Lane<u32>; BLOCK[1]], block: &Block) {
        for (row, owners) in (area.y.0..).zip(owners) {
            for (target, number) in self.line(row, area.x.0).iter_mut().zip(owners) {
                *target = block.sites[*number as usize];
            }
        }
    }
}

/// The sums of all sites over one tile.
struct SumsOf<'a> {
    area: Box2,
    field: Option<&'a Field>,
    /// The pixel column of every sample column of the canvas.
    pixel_of: &'a [u32],
    samples_per_pixel: usize,
    /// The first row of bins around the tile.
    first_row: usize,
    /// Of every row of bins around the tile: where in the order of bins its sites begin that are around the tile, and where in the sums.
    rows: Vec<[usize; 2]>,
    /// Counts in the lowest 16 bits, sums of columns in the next 24, and of rows in the highest, both from the tile's corner.
    positions: Vec<u64>,
    /// Sums of values; empty without a field.
    values: Vec<f64>,
    /// What belongs to sites that may not be around the tile.
    others: Vec<(u32, Sums)>,
}

impl<'a> SumsOf<'a> {
    fn new(bins: &Bins, area: Box2, field: Option<&'a Field>, pixel_of: &'a [u32]) -> Self {
        let [columns, (first_row, end_row)] = bins.window(area, FARTHEST);
        let mut count = 0;
        let mut row_of = |row: usize| {
            let run = bins.run(row, columns);
            let begin = [run.start, count];
            count += run.len();
            begin
        };
        let rows = (first_row..end_row).map(&mut row_of).collect();
        let values = if field.is_some() { vec![0.0; count] } else { Vec::new() };
        let samples_per_pixel = bins.scale as usize;
        Self { area, field, pixel_of, samples_per_pixel, first_row, rows, positions: vec![0; count], values, others: Vec::new() }
    }

    fn values_of_row(&self, row: usize) -> Option<&'a [f32]> {
        self.field.map(|field| &field.values()[row / self.samples_per_pixel * field.width()..][..field.width()])
    }

    /// Hands over all sums, each with its site, in an order of their own.
    fn parts(&self, bins: &Bins, mut take: impl FnMut(u32, &Sums)) {
        self.others.iter().for_each(|(site, part)| take(*site, part));
        let ends = self.rows[1..].iter().map(|next| next[1]).chain([self.positions.len()]);
        for ([begin, first], end) in self.rows.iter().zip(ends) {
            for (slot, site) in (*first..end).zip(&bins.order[*begin..]) {
                let packed = self.positions[slot];
                let count = packed as u16;
                if count > 0 {
                    let (columns, rows) = (packed >> 16 & 0xFF_FFFF, packed >> 40);
                    let sums = Sums {
                        count: u32::from(count),
                        columns: columns + u64::from(count) * self.area.x.0 as u64,
                        rows: rows + u64::from(count) * self.area.y.0 as u64,
                        values: self.values.get(slot).copied().unwrap_or(0.0),
                    };
                    take(*site, &sums);
                }
            }
        }
    }
}

impl Sink for SumsOf<'_> {
    fn first_slot(&self, row: usize) -> usize {
        let [begin, first] = self.rows[row - self.first_row];
        begin.wrapping_sub(first)
    }

    fn run(&mut self, row: usize, columns: std::ops::Range<usize>, site: u32) {
        let mut sums = Sums { count: columns.len() as u32, rows: (row * columns.len()) as u64, ..Sums::default() };
        let values = self.values_of_row(row);
        for column in columns {
            sums.columns += column as u64;
            sums.values += values.map_or(0.0, |values| f64::from(values[self.pixel_of[column] as usize]));
        }
        self.others.push((site, sums));
    }

    fn block(&mut self, area: Box2, owners: &[Lane<u32>; BLOCK[1]], block: &Block) {
        let left = (area.x.0 - self.area.x.0) as u64;
        for (row, owners) in (area.y.0..).zip(owners) {
            let first = 1 | left << 16 | ((row - self.area.y.0) as u64) << 40;
            for (i, number) in (0u64..).zip(owners) {
                self.positions[block.slots[*number as usize] as usize] += first + (i << 16);
            }
            if let Some(values) = self.values_of_row(row) {
                for (pixel, number) in self.pixel_of[area.x.0..area.x.1].iter().zip(owners) {
                    self.values[block.slots[*number as usize] as usize] += f64::from(values[*pixel as usize]);
                }
            }
        }
    }
}

/// Candidate lists of boxes inside one another, one behind the other, as on a stack.
#[derive(Default)]
struct Lists {
    stack: Vec<Candidate>,
    /// Squared distances to the four corners of the box that is narrowed down, by candidate.
    corners: Vec<[f64; 4]>,
}

impl Lists {
    /// Appends those of the candidates `range` that can own a sample of the box.
    ///
    /// Each is compared with a few rivals: the nearest sites to the corners and to the middles of the sides. More rivals would cut
    /// off more, but these leave little more than the sites in the box and a seam around it.
    fn narrow(&mut self, range: std::ops::Range<usize>, area: Box2) -> std::ops::Range<usize> {
        let start = self.stack.len();
        let [left, right, top, bottom] = area.extent();
        let (middle_x, middle_y) = (0.5 * (left + right), 0.5 * (top + bottom));
        self.corners.clear();
        let mut nearest = [(f64::INFINITY, 0); 8];
        for (i, candidate) in self.stack[range.clone()].iter().enumerate() {
            let [l, r, m] = [left, right, middle_x].map(|x| (candidate.x - x) * (candidate.x - x));
            let [t, b, n] = [top, bottom, middle_y].map(|y| (candidate.y - y) * (candidate.y - y));
            for (best, distance) in nearest.iter_mut().zip([l + t, r + t, l + b, r + b, m + t, m + b, l + n, r + n]) {
                if distance < best.0 {
                    *best = (distance, i);
                }
            }
            self.corners.push([l + t, r + t, l + b, r + b]);
        }
        let rivals = nearest.map(|(_, i)| self.corners[i]);
        for (i, corners) in range.zip(&self.corners) {
            // At a tie both stay: the leaf decides by index.
            let survives = |rival: &[f64; 4]| {
                (corners[0] <= rival[0]) | (corners[1] <= rival[1]) | (corners[2] <= rival[2]) | (corners[3] <= rival[3])
            };
            if rivals.iter().all(survives) {
                self.stack.push(self.stack[i]);
            }
        }
        start..self.stack.len()
    }

    /// Appends the sites in and within `reach` samples around a box, if they are sure to own all of it.
    fn gather(&mut self, bins: &Bins, area: Box2, reach: usize) -> Option<std::ops::Range<usize>> {
        let start = self.stack.len();
        for run in bins.around(area, reach) {
            self.stack.extend(run.iter().map(|site| bins.candidate(*site)));
        }
        // One of them is this near to all of the box; a site that was left out is further away than `reach`.
        let [left, right, top, bottom] = area.extent();
        let farthest = |c: &Candidate| {
            let (dx, dy) = ((c.x - left).abs().max((c.x - right).abs()), (c.y - top).abs().max((c.y - bottom).abs()));
            dx * dx + dy * dy
        };
        let nearest = self.stack[start..].iter().map(farthest).fold(f64::INFINITY, f64::min);
        let limit = reach as f64;
        if nearest >= limit * limit && self.stack.len() - start < bins.sites.len() {
            self.stack.truncate(start);
            return None;
        }
        Some(start..self.stack.len())
    }

    /// Hands over boxes that make up `area`, each with its candidates, or without any if it is crowded and no more than `side`
    /// samples long. `list` holds all that can own a sample of `area`, if that is known.
    fn divide(
        &mut self,
        bins: &Bins,
        list: Option<std::ops::Range<usize>>,
        area: Box2,
        side: usize,
        visit: &mut impl FnMut(&mut Self, Option<std::ops::Range<usize>>, Box2),
    ) {
        let start = self.stack.len();
        let longest = area.longest_side();
        let reach = longest.next_multiple_of(LEAF);
        let crowded = bins.around(area, reach).map(<[u32]>::len).sum::<usize>() > CROWD;
        if crowded && longest <= side {
            visit(self, list, area);
            return;
        }
        let mut list = list;
        if !crowded {
            let narrowed = self.gather(bins, area, reach).unwrap_or_else(|| {
                let wider = list.clone().unwrap_or_else(|| self.gather_from(bins, area, 2 * reach));
                self.narrow(wider, area)
            });
            if narrowed.len() <= CROWD || longest <= side {
                visit(self, Some(narrowed), area);
                self.stack.truncate(start);
                return;
            }
            list = Some(narrowed);
        }
        for quarter in area.split((longest / 2).next_power_of_two()) {
            self.divide(bins, list.clone(), quarter, side, visit);
        }
        self.stack.truncate(start);
    }

    /// As [`Lists::gather`], with `reach` doubled until the sites are sure to own all of the box.
    fn gather_from(&mut self, bins: &Bins, area: Box2, mut reach: usize) -> std::ops::Range<usize> {
        loop {
            match self.gather(bins, area, reach) {
                Some(found) => return found,
                None => reach *= 2,
            }
        }
    }

    /// Settles a box no larger than a leaf, whose candidates are not known.
    fn leaf(&mut self, bins: &Bins, area: Box2, sink: &mut impl Sink) {
        self.divide(bins, None, area, LEAF, &mut |lists, list, area| {
            let start = lists.stack.len();
            let mut list = list.unwrap_or_else(|| lists.gather_from(bins, area, LEAF));
            if list.len() > WORTH_NARROWING {
                list = lists.narrow(list, area);
            }
            lists.settle(list, area, sink);
            lists.stack.truncate(start);
        });
    }

    /// Halves boxes of a few candidates until they are leaves or belong to one site, and hands over their owners.
    fn settle(&mut self, range: std::ops::Range<usize>, area: Box2, sink: &mut impl Sink) {
        if let [only] = self.stack[range.clone()] {
            for row in area.y.0..area.y.1 {
                sink.run(row, area.x.0..area.x.1, only.site);
            }
            return;
        }
        if area.longest_side() > LEAF {
            for half in area.split((area.longest_side() / 2).next_multiple_of(LEAF)) {
                let start = self.stack.len();
                let narrowed = self.narrow(range.clone(), half);
                self.settle(narrowed, half, sink);
                self.stack.truncate(start);
            }
            return;
        }
        // In order, so that the lower index wins a tie.
        self.stack[range.clone()].sort_unstable_by_key(|c| c.site);
        for row in area.y.0..area.y.1 {
            // Arrays of a fixed length, so that the comparisons run several samples at a time.
            let mut nearest = [f64::INFINITY; LEAF];
            let mut nearest_site = [0; LEAF];
            for candidate in &self.stack[range.clone()] {
                let dy = row as f64 + 0.5 - candidate.y;
                let left = area.x.0 as f64 + 0.5 - candidate.x;
                for i in 0..LEAF {
                    let dx = left + i as f64;
                    let distance = dx * dx + dy * dy;
                    let nearer = distance < nearest[i];
                    nearest[i] = if nearer { distance } else { nearest[i] };
                    nearest_site[i] = if nearer { candidate.site } else { nearest_site[i] };
                }
            }
            let mut column = area.x.0;
            for run in nearest_site[..area.width()].chunk_by(|a, b| a == b) {
                sink.run(row, column..column + run.len(), run[0]);
                column += run.len();
            }
        }
    }
}

/// A part of the canvas with, where they were needed, its candidates.
struct Task {
    area: Box2,
    candidates: Option<Vec<Candidate>>,
}

/// The samples of a canvas and the sites that own them.
#[derive(Clone, Copy)]
struct Samples<'a> {
    sites: &'a [[f64; 2]],
    width: usize,
    height: usize,
    per_pixel: usize,
}

impl Samples<'_> {
    /// Hands over the sums of all cells, part by part: always the same parts in the same order.
    fn add_up(self, field: Option<&Field>, control: &Control, mut take: impl FnMut(u32, &Sums) + Send) -> Result<()> {
        let pixel_of: Vec<u32> = (0..self.width * self.per_pixel).map(|column| (column / self.per_pixel) as u32).collect();
        self.for_each_tile(
            control,
            |bins, area| SumsOf::new(bins, area, field, &pixel_of),
            |bins, sums: SumsOf| sums.parts(bins, &mut take),
        )
    }

    /// Finds the owners tile by tile, several tiles at once, and hands over what it has made of each, in a fixed order.
    fn for_each_tile<S: Sink + Send>(
        self,
        control: &Control,
        open: impl Fn(&Bins, Box2) -> S + Sync,
        mut take: impl FnMut(&Bins, S) + Send,
    ) -> Result<()> {
        let canvas = Box2 { x: (0, self.width * self.per_pixel), y: (0, self.height * self.per_pixel) };
        let bins = Bins::new(self.sites, canvas, self.per_pixel);
        let mut tasks = Vec::new();
        Lists::default().divide(&bins, None, canvas, TILE, &mut |lists, list, area| {
            let candidates: Option<Vec<Candidate>> = list.map(|list| lists.stack[list].to_vec());
            tasks.extend(area.split(TILE).map(|area| Task { area, candidates: candidates.clone() }));
        });
        let run = |block: &mut Block, task: &Task| {
            let mut sink = open(&bins, task.area);
            task.run(&bins, block, &mut sink);
            sink
        };
        let mut take_all = |made: Vec<S>| made.into_iter().for_each(|sink| take(&bins, sink));
        // While what was made of some tiles is taken, the next are looked at.
        let mut made: Vec<S> = Vec::new();
        for batch in tasks.chunks(TILES_AT_ONCE) {
            control.check()?;
            (_, made) = rayon::join(|| take_all(made), || batch.par_iter().map_init(Block::new, run).collect());
        }
        take_all(made);
        Ok(())
    }
}

impl Task {
    /// Finds the owner of every sample of the tile.
    fn run(&self, bins: &Bins, block: &mut Block, sink: &mut impl Sink) {
        let mut lists = Lists { stack: self.candidates.clone().unwrap_or_default(), corners: Vec::new() };
        let all = self.candidates.as_ref().map(|list| 0..list.len());
        lists.divide(bins, all, self.area, CROWDED_BOX, &mut |lists, list, area| match list {
            Some(list) => lists.settle(list, area, sink),
            None => {
                for area in area.blocks() {
                    let is_whole = [area.width(), area.y.1 - area.y.0] == BLOCK;
                    if is_whole && block.find(bins, area, &|row| sink.first_slot(row)) {
                        sink.block(area, &block.owners(bins, area), block);
                    } else {
                        lists.leaf(bins, area, sink);
                    }
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::LatticeKind;
    use proptest::prelude::*;

    fn brute_force(sites: &[[f64; 2]], x: f64, y: f64) -> u32 {
        let mut best = (f64::INFINITY, 0);
        for (i, site) in sites.iter().enumerate() {
            let d = (site[0] - x).powi(2) + (site[1] - y).powi(2);
            if d < best.0 {
                best = (d, i as u32);
            }
        }
        best.1
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_sample_goes_to_its_nearest_site(
            width in 1usize..90, height in 1usize..90, samples in 1usize..4,
            raw in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 1..60), squeeze in 0.05f64..1.0,
        ) {
            // Squeezed into a corner: large empty cells beside small ones.
            let sites: Vec<[f64; 2]> = raw.iter().map(|(u, v)| {
                [(u * squeeze * width as f64).clamp(0.001, width as f64 - 0.001), (v * squeeze * height as f64).clamp(0.001, height as f64 - 0.001)]
            }).collect();
            let owners = owners(&sites, width, height, samples, &Control::new()).unwrap();
            for (k, owner) in owners.iter().enumerate() {
                let (i, j) = (k % (width * samples), k / (width * samples));
                let (x, y) = ((i as f64 + 0.5) / samples as f64, (j as f64 + 0.5) / samples as f64);
                let (a, b) = (sites[*owner as usize], sites[brute_force(&sites, x, y) as usize]);
                let d = |s: [f64; 2]| (s[0] - x).powi(2) + (s[1] - y).powi(2);
                prop_assert!(d(a) - d(b) <= 1e-9, "sample {i}, {j}");
            }
            let field = Field::new(width, height, (0..width * height).map(|k| (k % 7) as f32 / 6.0).collect()).unwrap();
            let cells = cells(&sites, width, height, samples, Some(&field), &Control::new()).unwrap();
            prop_assert_eq!(cells.counts.iter().map(|c| *c as usize).sum::<usize>(), owners.len());
            let mean: f64 = cells.means.iter().zip(&cells.areas).map(|(m, a)| f64::from(*m) * a).sum::<f64>();
            let expected: f64 = field.values().iter().map(|v| f64::from(*v)).sum();
            prop_assert!((mean - expected).abs() < 1e-4 * expected.max(1.0));
        }
    }

    #[test]
    fn lattice_means_equal_the_general_pass() {
        let field = Field::new(37, 23, (0..37 * 23).map(|k| (k * 31 % 101) as f32 / 100.0).collect()).unwrap();
        for (kind, density) in [(LatticeKind::Hexagonal, 1.0), (LatticeKind::Square, 0.7), (LatticeKind::Hexagonal, 3.0)] {
            let lattice = Lattice::new(kind, 37, 23, density).unwrap();
            let samples = samples_per_pixel(density);
            let means = lattice_means(&lattice, &field, samples, &Control::new()).unwrap();
            let general = cells(&lattice.sites(), 37, 23, samples, Some(&field), &Control::new()).unwrap();
            let off = means.iter().zip(&general.means).filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
            // A sample as far from two nodes may go to either, by rounding.
            assert!(off * 50 <= means.len(), "{off} of {} means differ", means.len());
        }
    }

    #[test]
    fn relaxation_stays_inside_and_keeps_a_regular_graph_nearly_still() {
        let lattice = Lattice::new(LatticeKind::Square, 20, 20, 1.0).unwrap();
        let relaxed = relax(lattice.sites(), 20, 20, 3, 4, &Control::new()).unwrap();
        for (a, b) in relaxed.iter().zip(lattice.sites()) {
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
        }
        assert!(relax(vec![[30.0, 1.0]], 20, 20, 1, 1, &Control::new()).is_err());
        assert!(cells(&[], 4, 4, 1, None, &Control::new()).is_err());
    }
}
