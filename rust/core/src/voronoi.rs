//! Voronoi cells on a grid of samples: areas, centroids and field means of cells, and Lloyd relaxation.
//!
//! The canvas carries `samples_per_pixel` x `samples_per_pixel` samples a pixel, sample (i, j) at `((i + 0.5) / s, (j + 0.5) / s)`.
//! Every sample belongs to its nearest site, the lower index on ties. For sites in general position the owners are found by
//! halving the canvas: a box keeps the sites that can own a point of it, and hands them to its halves. A site can own a point of
//! a box only if, against every other site, it is nearer at some corner: what is nearer to one of two sites is a half-plane, and
//! a half-plane that meets a box holds a corner of it. So large empty cells cost as little as small ones.
//!
//! What this module does not do: exact polygonal cells. Source: section 3.2 of the paper (node values, relaxation).

use rayon::prelude::*;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, check_size};
use crate::graph::Adjacency;
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
    let tiles = tiles(sites, width, height, samples_per_pixel);
    let pixel_of: Vec<usize> = (0..width * samples_per_pixel).map(|column| column / samples_per_pixel).collect();
    let mut sums = vec![Sums::default(); sites.len()];
    // Tiles are worked on in any order and added up in theirs, so that the result does not depend on the threads.
    for batch in tiles.chunks(TILES_AT_ONCE) {
        control.check()?;
        let parts: Vec<Vec<Sums>> = batch
            .par_iter()
            .map(|tile| {
                let mut part = vec![Sums::default(); tile.candidates.len()];
                tile.own(sites, samples_per_pixel, |run| {
                    let values = field.map(|f| &f.values()[run.row / samples_per_pixel * width..][..width]);
                    for (column, local) in (run.first_column..).zip(run.owners) {
                        let value = values.map_or(0.0, |values| f64::from(values[pixel_of[column]]));
                        part[*local as usize].add(column, run.row, value);
                    }
                });
                part
            })
            .collect();
        for (tile, part) in batch.iter().zip(parts) {
            for (candidate, sum) in tile.candidates.iter().zip(part) {
                sums[*candidate as usize].merge(&sum);
            }
        }
    }
    Ok(finish(&sums, samples_per_pixel, field, |i| sites[i]))
}

/// The mean of the field over every lattice cell, the nearest node being known in closed form.
///
/// # Errors
/// [`Error::Input`] if `samples_per_pixel` is not between 1 and 16; [`Error::Cancelled`].
pub fn lattice_means(lattice: &Lattice, field: &Field, samples_per_pixel: usize, control: &Control) -> Result<Vec<f32>> {
    check(&[lattice.site(0)], field.width(), field.height(), samples_per_pixel, Some(field))?;
    let step = 1.0 / samples_per_pixel as f64;
    let mut sums = vec![(0u32, 0f64); lattice.len()];
    for row in 0..field.height() * samples_per_pixel {
        if row % 256 == 0 {
            control.check()?;
        }
        let rows = lattice.rows_around((row as f64 + 0.5) * step);
        let values = &field.values()[row / samples_per_pixel * field.width()..][..field.width()];
        let mut column = 0;
        for value in values {
            for _ in 0..samples_per_pixel {
                let x = (f64::from(column) + 0.5) * step;
                let [above, below] = [rows[0].nearest(x), rows[1].nearest(x)];
                let sum = &mut sums[if below.1 < above.1 { below.0 } else { above.0 }];
                sum.0 += 1;
                sum.1 += f64::from(*value);
                column += 1;
            }
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
    for tile in tiles(sites, width, height, samples_per_pixel) {
        control.check()?;
        tile.own(sites, samples_per_pixel, |run| {
            for (owner, local) in owners[run.row * stride + run.first_column..].iter_mut().zip(run.owners) {
                *owner = tile.candidates[*local as usize];
            }
        });
    }
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

/// Side of a tile in samples: tiles are what threads share out. Smaller ones repeat more sites along their borders, larger
/// ones leave threads idle on small pictures.
const TILE: usize = 256;

/// Tiles between two looks at the cancellation flag.
const TILES_AT_ONCE: usize = 64;

/// Side of the boxes, in samples, in which every sample is compared with every candidate. Smaller boxes narrow down more often,
/// larger ones compare more; the comparison runs several samples at a time.
const LEAF: usize = 8;

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

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.columns += other.columns;
        self.rows += other.rows;
        self.values += other.values;
    }
}

fn finish(sums: &[Sums], samples_per_pixel: usize, field: Option<&Field>, site: impl Fn(usize) -> [f64; 2]) -> Cells {
    let step = 1.0 / samples_per_pixel as f64;
    let position = |sum: u64, count: u32| (sum as f64 / f64::from(count) + 0.5) * step;
    let mut cells = Cells {
        counts: sums.iter().map(|s| s.count).collect(),
        areas: sums.iter().map(|s| f64::from(s.count) * step * step).collect(),
        centroids: Vec::with_capacity(sums.len()),
        means: Vec::new(),
    };
    for (i, sum) in sums.iter().enumerate() {
        cells.centroids.push(if sum.count > 0 {
            [position(sum.columns, sum.count), position(sum.rows, sum.count)]
        } else {
            site(i)
        });
        if let Some(field) = field {
            cells.means.push(if sum.count > 0 {
                (sum.values / f64::from(sum.count)) as f32
            } else {
                field.bilinear(site(i)[0], site(i)[1])
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
    /// The two halves across the longer side.
    fn halves(self) -> [Self; 2] {
        if self.x.1 - self.x.0 >= self.y.1 - self.y.0 {
            let middle = (self.x.0 + self.x.1) / 2;
            [Self { x: (self.x.0, middle), ..self }, Self { x: (middle, self.x.1), ..self }]
        } else {
            let middle = (self.y.0 + self.y.1) / 2;
            [Self { y: (self.y.0, middle), ..self }, Self { y: (middle, self.y.1), ..self }]
        }
    }

    fn longest_side(self) -> usize {
        (self.x.1 - self.x.0).max(self.y.1 - self.y.0)
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
    /// Its place in the tile's (or, for the canvas, the caller's) list.
    local: u32,
}

/// Candidate sites; the lists of nested boxes lie one behind the other, as on a stack.
#[derive(Debug, Default)]
struct Candidates {
    stack: Vec<Candidate>,
    /// Squared distances to the four corners of the box that is narrowed down, by candidate.
    corners: Vec<[f64; 4]>,
}

impl Candidates {
    fn new(sites: impl Iterator<Item = [f64; 2]>, samples_per_pixel: usize) -> Self {
        let scale = samples_per_pixel as f64;
        let stack = sites.enumerate().map(|(i, site)| Candidate { x: site[0] * scale, y: site[1] * scale, local: i as u32 });
        Self { stack: stack.collect(), corners: Vec::new() }
    }

    /// Appends those of the candidates `range` that can own a sample of the box, in their order.
    fn narrow(&mut self, range: std::ops::Range<usize>, area: Box2) {
        let [left, right, top, bottom] = area.extent();
        self.corners.clear();
        let mut nearest = [(f64::INFINITY, 0); 4];
        for (i, candidate) in self.stack[range.clone()].iter().enumerate() {
            let [l, r] = [candidate.x - left, candidate.x - right].map(|d| d * d);
            let [t, b] = [candidate.y - top, candidate.y - bottom].map(|d| d * d);
            let corners = [l + t, r + t, l + b, r + b];
            for (best, distance) in nearest.iter_mut().zip(corners) {
                if distance < best.0 {
                    *best = (distance, i);
                }
            }
            self.corners.push(corners);
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
    }
}

/// A tile of the canvas with the sites that can own a sample of it, by index.
struct Tile {
    area: Box2,
    candidates: Vec<u32>,
}

/// Divides the canvas into tiles of at most [`TILE`] samples a side.
fn tiles(sites: &[[f64; 2]], width: usize, height: usize, samples_per_pixel: usize) -> Vec<Tile> {
    let mut candidates = Candidates::new(sites.iter().copied(), samples_per_pixel);
    let mut tiles = Vec::new();
    let canvas = Box2 { x: (0, width * samples_per_pixel), y: (0, height * samples_per_pixel) };
    divide(&mut candidates, 0..sites.len(), canvas, TILE, &mut |candidates, area| {
        tiles.push(Tile { area, candidates: candidates.iter().map(|c| c.local).collect() });
    });
    tiles
}

/// Halves a box until it is at most `side` samples long or a single site owns it, then hands it to `visit`.
fn divide(
    candidates: &mut Candidates,
    range: std::ops::Range<usize>,
    area: Box2,
    side: usize,
    visit: &mut impl FnMut(&[Candidate], Box2),
) {
    if area.longest_side() <= side || range.len() == 1 {
        visit(&candidates.stack[range], area);
        return;
    }
    for half in area.halves() {
        let start = candidates.stack.len();
        candidates.narrow(range.clone(), half);
        divide(candidates, start..candidates.stack.len(), half, side, visit);
        candidates.stack.truncate(start);
    }
}

/// The owners of some samples of one row, one beside the other, as places in the tile's list.
struct Run<'a> {
    row: usize,
    first_column: usize,
    owners: &'a [u32],
}

impl Tile {
    /// Calls `emit` so that every sample of the tile comes once.
    fn own(&self, sites: &[[f64; 2]], samples_per_pixel: usize, mut emit: impl FnMut(Run)) {
        let all = 0..self.candidates.len();
        let mut candidates = Candidates::new(self.candidates.iter().map(|i| sites[*i as usize]), samples_per_pixel);
        let mut dx_squared: Vec<[f64; LEAF]> = Vec::new();
        divide(&mut candidates, all, self.area, LEAF, &mut |candidates, area| {
            if let [only] = candidates {
                let owners = vec![only.local; area.x.1 - area.x.0];
                for row in area.y.0..area.y.1 {
                    emit(Run { row, first_column: area.x.0, owners: &owners });
                }
                return;
            }
            dx_squared.clear();
            dx_squared.extend(candidates.iter().map(|c| {
                std::array::from_fn(|i| {
                    let dx = (area.x.0 + i) as f64 + 0.5 - c.x;
                    dx * dx
                })
            }));
            for row in area.y.0..area.y.1 {
                // Arrays of a fixed length, so that the comparisons run several samples at a time.
                let mut nearest = [f64::INFINITY; LEAF];
                let mut owners = [0; LEAF];
                for (candidate, dx_squared) in candidates.iter().zip(&dx_squared) {
                    let dy = row as f64 + 0.5 - candidate.y;
                    let dy_squared = dy * dy;
                    for i in 0..LEAF {
                        let distance = dx_squared[i] + dy_squared;
                        let nearer = distance < nearest[i];
                        nearest[i] = if nearer { distance } else { nearest[i] };
                        owners[i] = if nearer { candidate.local } else { owners[i] };
                    }
                }
                emit(Run { row, first_column: area.x.0, owners: &owners[..area.x.1 - area.x.0] });
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
