//! Voronoi cells on a grid of samples: areas, centroids and field means of cells, and Lloyd relaxation.
//!
//! The canvas carries `samples_per_pixel` x `samples_per_pixel` samples a pixel, sample (i, j) at `((i + 0.5) / s, (j + 0.5) / s)`.
//! Every sample belongs to its nearest site, the lower index on ties. For sites in general position the owners are found box by
//! box, from the canvas down: a box with few sites in and around it, near enough to own all of it, is done with those; a crowded
//! one is quartered; and a box whose owners are far away *narrows down* the candidates of the box around it. A site can own a point
//! of a box only if, against every other site, it is nearer at some corner: what is nearer to one of two sites is a half-plane, and
//! a half-plane that meets a box holds a corner of it. So large empty cells cost as little as small ones.
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
    let pixel_of: Vec<usize> = (0..width * samples_per_pixel).map(|column| column / samples_per_pixel).collect();
    let mut sums = vec![Sums::default(); sites.len()];
    for_each_tile(sites, width, height, samples_per_pixel, control, |area, owners| {
        for (row, owners) in (area.y.0..area.y.1).zip(owners.chunks_exact(area.width())) {
            let values = field.map(|f| &f.values()[row / samples_per_pixel * width..][..width]);
            for (column, owner) in (area.x.0..area.x.1).zip(owners) {
                let value = values.map_or(0.0, |values| f64::from(values[pixel_of[column]]));
                sums[*owner as usize].add(column, row, value);
            }
        }
    })?;
    Ok(finish(&sums, sites, samples_per_pixel, field))
}

/// The mean of the field over every lattice cell, the nearest node being known in closed form.
///
/// # Errors
/// [`Error::Input`] if `samples_per_pixel` is not between 1 and 16; [`Error::Cancelled`].
pub fn lattice_means(lattice: &Lattice, field: &Field, samples_per_pixel: usize, control: &Control) -> Result<Vec<f32>> {
    check(&[lattice.site(0)], field.width(), field.height(), samples_per_pixel, Some(field))?;
    let step = 1.0 / samples_per_pixel as f64;
    // Bands of rows, whose nodes are a run of the lattice; a node on the seam of two bands gets its samples from both, in order.
    let sample_rows = field.height() * samples_per_pixel;
    let band_sums = |first: usize| {
        let last = (first + BAND).min(sample_rows);
        let y = |row: usize| (row as f64 + 0.5) * step;
        let nodes = lattice.rows_around(y(first))[0].start()..lattice.rows_around(y(last - 1))[1].end();
        let mut sums = vec![(0u32, 0f64); nodes.len()];
        for row in first..last {
            let rows = lattice.rows_around(y(row));
            let values = &field.values()[row / samples_per_pixel * field.width()..][..field.width()];
            let mut column = 0u32;
            for value in values {
                for _ in 0..samples_per_pixel {
                    let x = (f64::from(column) + 0.5) * step;
                    let [above, below] = [rows[0].nearest(x), rows[1].nearest(x)];
                    let sum = &mut sums[if below.1 < above.1 { below.0 } else { above.0 } - nodes.start];
                    sum.0 += 1;
                    sum.1 += f64::from(*value);
                    column += 1;
                }
            }
        }
        (nodes.start, sums)
    };
    control.check()?;
    let bands: Vec<_> = (0..sample_rows).into_par_iter().step_by(BAND).map(band_sums).collect();
    let mut sums = vec![(0u32, 0f64); lattice.len()];
    for (start, band) in bands {
        for (sum, part) in sums[start..].iter_mut().zip(band) {
            sum.0 += part.0;
            sum.1 += part.1;
        }
    }
    let mean = |(node, (count, sum)): (usize, &(u32, f64))| {
        if *count > 0 {
            return (*sum / f64::from(*count)) as f32;
        }
        let [x, y] = lattice.site(node);
        field.bilinear(x, y)
    };
    Ok(sums.iter().enumerate().map(mean).collect())
}

/// The owner of every sample: row-major, `width * samples_per_pixel` by `height * samples_per_pixel`.
///
/// # Errors
/// As [`cells`].
pub fn owners(sites: &[[f64; 2]], width: usize, height: usize, samples_per_pixel: usize, control: &Control) -> Result<Vec<u32>> {
    check(sites, width, height, samples_per_pixel, None)?;
    let stride = width * samples_per_pixel;
    let mut owners = vec![0; stride * height * samples_per_pixel];
    for_each_tile(sites, width, height, samples_per_pixel, control, |area, tile| {
        for (row, tile) in (area.y.0..area.y.1).zip(tile.chunks_exact(area.width())) {
            owners[row * stride + area.x.0..][..tile.len()].copy_from_slice(tile);
        }
    })?;
    Ok(owners)
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
        sites = cells(&sites, width, height, samples_per_pixel, None, control)?.centroids;
        for site in &mut sites {
            *site = [site[0].clamp(FRAME_MARGIN, limits[0]), site[1].clamp(FRAME_MARGIN, limits[1])];
        }
    }
    Ok(sites)
}

/// Side of a tile in samples: tiles are what threads share out. Smaller ones cost more to hand out, larger ones leave
/// threads idle on small pictures.
const TILE: usize = 256;

/// Sample rows whose lattice means one thread computes at once.
const BAND: usize = 64;

/// Tiles between two looks at the cancellation flag; their owners are in memory at once.
const TILES_AT_ONCE: usize = 32;

/// Side of the smallest boxes, in samples, in which every sample is compared with every candidate, and of the bins in which sites
/// are looked up. Smaller ones narrow down more often, larger ones compare more.
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

/// Running sums of a cell. Positions are summed as integers, so that their order does not matter.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: u32,
    columns: u64,
    rows: u64,
    values: f64,
}

impl Sums {
    fn add(&mut self, column: usize, row: usize, value: f64) {
        self.count += 1;
        self.columns += column as u64;
        self.rows += row as u64;
        self.values += value;
    }
}

fn finish(sums: &[Sums], sites: &[[f64; 2]], samples_per_pixel: usize, field: Option<&Field>) -> Cells {
    let step = 1.0 / samples_per_pixel as f64;
    let position = |sum: u64, count: u32| (sum as f64 / f64::from(count) + 0.5) * step;
    let mut cells = Cells {
        counts: sums.iter().map(|s| s.count).collect(),
        areas: sums.iter().map(|s| f64::from(s.count) * step * step).collect(),
        centroids: Vec::with_capacity(sums.len()),
        means: Vec::new(),
    };
    for (sum, site) in sums.iter().zip(sites) {
        cells.centroids.push(if sum.count > 0 { [position(sum.columns, sum.count), position(sum.rows, sum.count)] } else { *site });
        if let Some(field) = field {
            cells.means.push(if sum.count > 0 {
                (sum.values / f64::from(sum.count)) as f32
            } else {
                field.bilinear(site[0], site[1])
            });
        }
    }
    cells
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

/// All sites, sorted into bins of [`LEAF`] samples a side.
struct Bins {
    candidates: Vec<Candidate>,
    /// Start of every bin's sites in `order`, row by row of bins.
    offsets: Vec<u32>,
    order: Vec<u32>,
    columns: usize,
    rows: usize,
}

impl Bins {
    fn new(sites: &[[f64; 2]], canvas: Box2, samples_per_pixel: usize) -> Self {
        let scale = samples_per_pixel as f64;
        let (columns, rows) = (canvas.x.1.div_ceil(LEAF), canvas.y.1.div_ceil(LEAF));
        let candidates: Vec<Candidate> = (0u32..)
            .zip(sites)
            .map(|(site, position)| Candidate { x: position[0] * scale, y: position[1] * scale, site })
            .collect();
        let bin = |c: &Candidate| (c.y as usize / LEAF).min(rows - 1) * columns + (c.x as usize / LEAF).min(columns - 1);
        let mut offsets = vec![0u32; columns * rows + 1];
        for candidate in &candidates {
            offsets[bin(candidate) + 1] += 1;
        }
        cumulate(&mut offsets);
        let mut next = offsets.clone();
        let mut order = vec![0; candidates.len()];
        for candidate in &candidates {
            let place = &mut next[bin(candidate)];
            order[*place as usize] = candidate.site;
            *place += 1;
        }
        Self { candidates, offsets, order, columns, rows }
    }

    /// The sites in the bins that lie within `reach` bins of a box, as runs of `order`, one a row of bins.
    fn around(&self, area: Box2, reach: usize) -> impl Iterator<Item = &[u32]> {
        let columns = ((area.x.0 / LEAF).saturating_sub(reach), (area.x.1.div_ceil(LEAF) + reach).min(self.columns));
        let rows = (area.y.0 / LEAF).saturating_sub(reach)..(area.y.1.div_ceil(LEAF) + reach).min(self.rows);
        rows.map(move |row| {
            let begin = self.offsets[row * self.columns + columns.0] as usize;
            &self.order[begin..self.offsets[row * self.columns + columns.1] as usize]
        })
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

    /// Appends the sites in and within `reach` bins around a box, if they are sure to own all of it.
    fn gather(&mut self, bins: &Bins, area: Box2, reach: usize) -> Option<std::ops::Range<usize>> {
        let start = self.stack.len();
        for run in bins.around(area, reach) {
            self.stack.extend(run.iter().map(|site| bins.candidates[*site as usize]));
        }
        // One of them is this near to all of the box; a site that was left out is further away than `reach` bins.
        let [left, right, top, bottom] = area.extent();
        let farthest = |c: &Candidate| {
            let (dx, dy) = ((c.x - left).abs().max((c.x - right).abs()), (c.y - top).abs().max((c.y - bottom).abs()));
            dx * dx + dy * dy
        };
        let nearest = self.stack[start..].iter().map(farthest).fold(f64::INFINITY, f64::min);
        let limit = (reach * LEAF) as f64;
        if nearest >= limit * limit && self.stack.len() - start < bins.candidates.len() {
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
        let reach = longest.div_ceil(LEAF);
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

    /// Halves boxes of a few candidates until they are leaves or belong to one site, and writes their owners into those of `tile`.
    fn settle(&mut self, range: std::ops::Range<usize>, area: Box2, tile: Box2, owners: &mut [u32]) {
        let place = |row: usize| (row - tile.y.0) * tile.width() + area.x.0 - tile.x.0;
        if let [only] = self.stack[range.clone()] {
            for row in area.y.0..area.y.1 {
                owners[place(row)..][..area.width()].fill(only.site);
            }
            return;
        }
        if area.longest_side() > LEAF {
            for half in area.split((area.longest_side() / 2).next_multiple_of(LEAF)) {
                let start = self.stack.len();
                let narrowed = self.narrow(range.clone(), half);
                self.settle(narrowed, half, tile, owners);
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
            owners[place(row)..][..area.width()].copy_from_slice(&nearest_site[..area.width()]);
        }
    }
}

/// A part of the canvas with, where they were needed, its candidates.
struct Task {
    area: Box2,
    candidates: Option<Vec<Candidate>>,
}

/// Finds the owners tile by tile, several at once, and hands them over in a fixed order: the box, and its owners row by row.
fn for_each_tile(
    sites: &[[f64; 2]],
    width: usize,
    height: usize,
    samples_per_pixel: usize,
    control: &Control,
    mut take: impl FnMut(Box2, &[u32]),
) -> Result<()> {
    let canvas = Box2 { x: (0, width * samples_per_pixel), y: (0, height * samples_per_pixel) };
    let bins = Bins::new(sites, canvas, samples_per_pixel);
    let mut tasks = Vec::new();
    Lists::default().divide(&bins, None, canvas, TILE, &mut |lists, list, area| {
        let candidates: Option<Vec<Candidate>> = list.map(|list| lists.stack[list].to_vec());
        tasks.extend(area.split(TILE).map(|area| Task { area, candidates: candidates.clone() }));
    });
    for batch in tasks.chunks(TILES_AT_ONCE) {
        control.check()?;
        let owned: Vec<Vec<u32>> = batch.par_iter().map(|task| task.owners(&bins)).collect();
        for (task, owners) in batch.iter().zip(&owned) {
            take(task.area, owners);
        }
    }
    Ok(())
}

impl Task {
    /// The owner of every sample of the tile, row by row.
    fn owners(&self, bins: &Bins) -> Vec<u32> {
        let mut owners = vec![0; self.area.width() * (self.area.y.1 - self.area.y.0)];
        let mut lists = Lists { stack: self.candidates.clone().unwrap_or_default(), corners: Vec::new() };
        let all = self.candidates.as_ref().map(|list| 0..list.len());
        lists.divide(bins, all, self.area, LEAF, &mut |lists, list, area| {
            let start = lists.stack.len();
            let mut list = list.unwrap_or_else(|| lists.gather_from(bins, area, 1));
            if list.len() > WORTH_NARROWING {
                list = lists.narrow(list, area);
            }
            lists.settle(list, area, self.area, &mut owners);
            lists.stack.truncate(start);
        });
        owners
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
