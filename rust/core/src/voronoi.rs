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
    let mut sums = vec![Sums::default(); sites.len()];
    // Tiles are worked on in any order and added up in theirs, so that the result does not depend on the threads.
    for batch in tiles.chunks(TILES_AT_ONCE) {
        control.check()?;
        let parts: Vec<Vec<Sums>> = batch
            .par_iter()
            .map(|tile| {
                let mut part = vec![Sums::default(); tile.candidates.len()];
                tile.own(sites, samples_per_pixel, |local, column, row| {
                    let value = field.map_or(0.0, |f| f64::from(f.at(column / samples_per_pixel, row / samples_per_pixel)));
                    part[local].add(column, row, value);
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
        tile.own(sites, samples_per_pixel, |local, column, row| owners[row * stride + column] = tile.candidates[local]);
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

/// Side of the boxes, in samples, in which every sample is compared with every candidate.
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

/// Candidate sites, positions in samples; lists of nested boxes lie one behind the other, as on a stack.
#[derive(Debug, Default)]
struct Candidates {
    local: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Squared distances to the four corners of the box that is narrowed down, by candidate.
    corners: Vec<[f64; 4]>,
}

impl Candidates {
    fn push(&mut self, local: u32, x: f64, y: f64) {
        self.local.push(local);
        self.x.push(x);
        self.y.push(y);
    }

    fn truncate(&mut self, length: usize) {
        self.local.truncate(length);
        self.x.truncate(length);
        self.y.truncate(length);
    }

    /// Appends those of the candidates `range` that can own a sample of the box, in their order.
    fn narrow(&mut self, range: std::ops::Range<usize>, area: Box2) {
        let [left, right, top, bottom] = area.extent();
        self.corners.clear();
        let mut nearest = [(f64::INFINITY, 0); 4];
        for i in range.clone() {
            let (x, y) = (self.x[i], self.y[i]);
            let [l, r, t, b] = [x - left, x - right, y - top, y - bottom].map(|d| d * d);
            let corners = [l + t, r + t, l + b, r + b];
            for (best, distance) in nearest.iter_mut().zip(corners) {
                if distance < best.0 {
                    *best = (distance, i - range.start);
                }
            }
            self.corners.push(corners);
        }
        let rivals = nearest.map(|(_, i)| self.corners[i]);
        for i in range.clone() {
            let corners = self.corners[i - range.start];
            // At a tie both stay: the leaf decides by index.
            let survives = rivals.iter().all(|rival| (0..4).any(|k| corners[k] <= rival[k]));
            if survives {
                let (local, x, y) = (self.local[i], self.x[i], self.y[i]);
                self.push(local, x, y);
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
    let scale = samples_per_pixel as f64;
    let mut candidates = Candidates::default();
    for (i, site) in sites.iter().enumerate() {
        candidates.push(i as u32, site[0] * scale, site[1] * scale);
    }
    let mut tiles = Vec::new();
    let canvas = Box2 { x: (0, width * samples_per_pixel), y: (0, height * samples_per_pixel) };
    divide(&mut candidates, 0..sites.len(), canvas, TILE, &mut |candidates, range, area| {
        tiles.push(Tile { area, candidates: candidates.local[range].to_vec() });
    });
    tiles
}

/// Halves a box until it is at most `side` samples long or a single site owns it, then hands it to `visit`.
fn divide(
    candidates: &mut Candidates,
    range: std::ops::Range<usize>,
    area: Box2,
    side: usize,
    visit: &mut impl FnMut(&Candidates, std::ops::Range<usize>, Box2),
) {
    if area.longest_side() <= side || range.len() == 1 {
        visit(candidates, range, area);
        return;
    }
    for half in area.halves() {
        let start = candidates.local.len();
        candidates.narrow(range.clone(), half);
        divide(candidates, start..candidates.local.len(), half, side, visit);
        candidates.truncate(start);
    }
}

impl Tile {
    /// Calls `emit(position in the candidate list, column, row)` once for every sample of the tile.
    fn own(&self, sites: &[[f64; 2]], samples_per_pixel: usize, mut emit: impl FnMut(usize, usize, usize)) {
        let scale = samples_per_pixel as f64;
        let mut candidates = Candidates::default();
        for (local, candidate) in self.candidates.iter().enumerate() {
            let site = sites[*candidate as usize];
            candidates.push(local as u32, site[0] * scale, site[1] * scale);
        }
        let all = 0..self.candidates.len();
        divide(&mut candidates, all, self.area, LEAF, &mut |candidates, range, area| {
            let (local, xs, ys) = (&candidates.local[range.clone()], &candidates.x[range.clone()], &candidates.y[range]);
            for row in area.y.0..area.y.1 {
                let y = row as f64 + 0.5;
                for column in area.x.0..area.x.1 {
                    let x = column as f64 + 0.5;
                    let mut best = (f64::INFINITY, 0);
                    for (i, (site_x, site_y)) in xs.iter().zip(ys).enumerate() {
                        let (dx, dy) = (site_x - x, site_y - y);
                        let distance = dx * dx + dy * dy;
                        if distance < best.0 {
                            best = (distance, i);
                        }
                    }
                    emit(local[best.1] as usize, column, row);
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
