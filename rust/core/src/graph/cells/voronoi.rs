//! Areas, centroids and field means of the cells of any sites, and the owner of every sample.

use rayon::prelude::*;

use crate::base::{Control, Result};
use crate::graph::cells::bins::Box2;
use crate::graph::cells::block::{BLOCK, Block, Lane};
use crate::graph::cells::raster::{Samples, Sink};
use crate::graph::cells::sampling::{area_of, centroid_of, check_sampling, mean_of};
use crate::graph::cells::sums::Sums;
use crate::photo::Field;

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

/// Areas, centroids and means of the cells of any sites.
///
/// # Errors
/// [`crate::Error::Input`] if there is no site, a site is not inside the canvas, `samples_per_pixel` is not between 1 and 16, or
/// the field has another size than the canvas; [`crate::Error::Cancelled`].
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
    check_sampling(sites, width, height, samples_per_pixel, field.as_slice())?;
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    match field {
        Some(field) => canvas.cells([field], control),
        None => canvas.cells([], control),
    }
}

impl Samples<'_> {
    fn cells<const N: usize>(self, fields: [&Field; N], control: &Control) -> Result<Cells> {
        let Self { sites, per_pixel, .. } = self;
        let mut sums = vec![Sums::NONE; sites.len()];
        self.add_up(fields, control, |site, part| sums[site as usize].add(part))?;
        let both = || sums.par_iter().zip(sites);
        let centroid = |(s, site): (&Sums<N>, &[f64; 2])| centroid_of([s.columns, s.rows], s.count, *site, per_pixel);
        let means = |field: &&Field| both().map(|(s, site)| mean_of(s.values[0], s.count, *site, field)).collect();
        Ok(Cells {
            counts: sums.par_iter().map(|s| s.count).collect(),
            areas: sums.par_iter().map(|s| area_of(s.count, per_pixel)).collect(),
            centroids: both().map(centroid).collect(),
            means: fields.first().map_or_else(Vec::new, means),
        })
    }

    /// Areas of the cells, and the means of every field.
    fn means<const N: usize>(self, fields: [&Field; N], control: &Control) -> Result<(Vec<f64>, [Vec<f32>; N])> {
        let Self { sites, per_pixel, .. } = self;
        let (mut counts, mut values) = (vec![0u32; sites.len()], vec![[0f64; N]; sites.len()]);
        self.add_up(fields, control, |site, part| {
            counts[site as usize] += part.count;
            values[site as usize].iter_mut().zip(part.values).for_each(|(sum, value)| *sum += value);
        })?;
        let means = std::array::from_fn(|k| {
            let mean = |((sums, count), site): ((&[f64; N], &u32), &[f64; 2])| mean_of(sums[k], *count, *site, fields[k]);
            values.par_iter().zip(&counts).zip(sites).map(mean).collect()
        });
        drop(values);
        Ok((counts.par_iter().map(|count| area_of(*count, per_pixel)).collect(), means))
    }
}

/// What the labels need of every site's cell.
#[derive(Debug, Clone, PartialEq)]
pub struct TonedCells {
    /// As [`Cells::areas`].
    pub areas: Vec<f64>,
    /// As [`Cells::means`]: of the tone that shapes are made of.
    pub means: Vec<f32>,
    /// Means of the tone before its emphasis, which smooth parts are stippled by.
    pub plain: Vec<f32>,
}

/// Areas and means alone, equal to those of [`cells`], in less memory: 32 bytes a site at the peak, the sites sorted into bins
/// apart.
///
/// # Errors
/// As [`cells`].
pub fn toned_cells(
    sites: &[[f64; 2]],
    tone: &Field,
    plain: &Field,
    samples_per_pixel: usize,
    control: &Control,
) -> Result<TonedCells> {
    let (width, height) = (tone.width(), tone.height());
    check_sampling(sites, width, height, samples_per_pixel, &[plain])?;
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    let (areas, [means, plain]) = canvas.means([tone, plain], control)?;
    Ok(TonedCells { areas, means, plain })
}

/// The means of several fields of one size, all in one pass: as [`Cells::means`].
///
/// # Errors
/// As [`cells`].
pub(crate) fn cell_means<const N: usize>(
    sites: &[[f64; 2]],
    fields: [&Field; N],
    samples_per_pixel: usize,
    control: &Control,
) -> Result<[Vec<f32>; N]> {
    let (width, height) = (fields[0].width(), fields[0].height());
    check_sampling(sites, width, height, samples_per_pixel, &fields)?;
    let canvas = Samples { sites, width, height, per_pixel: samples_per_pixel };
    canvas.means(fields, control).map(|(_, means)| means)
}

/// The owner of every sample: row-major, `width * samples_per_pixel` by `height * samples_per_pixel`.
///
/// # Errors
/// As [`cells`].
pub fn owners(sites: &[[f64; 2]], width: usize, height: usize, samples_per_pixel: usize, control: &Control) -> Result<Vec<u32>> {
    check_sampling(sites, width, height, samples_per_pixel, &[])?;
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

#[cfg(test)]
mod tests {
    use super::*;

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

    /// A crowd, which is looked at in blocks, with every other sample between sites, whose numbers say nothing of their places.
    #[test]
    fn of_sites_equally_near_in_a_crowd_the_first_has_the_sample() {
        let mut sites: Vec<[f64; 2]> = (0..1024).map(|k| [0.5 + 2.0 * f64::from(k % 32), 0.5 + 2.0 * f64::from(k / 32)]).collect();
        sites.sort_by_key(|site| crate::base::mixed(site[0].to_bits() ^ site[1].to_bits().rotate_left(32)));
        let owners = owners(&sites, 64, 64, 1, &Control::new()).unwrap();
        for (k, owner) in owners.iter().enumerate() {
            let (column, row) = (k % 64, k / 64);
            assert_eq!(*owner, brute_force(&sites, column as f64 + 0.5, row as f64 + 0.5), "sample {column}, {row}");
        }
    }
}
