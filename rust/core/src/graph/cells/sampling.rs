//! The samples of a canvas, and what is told from those that a site owns: what all ways to find cells share.
//!
//! The canvas carries `samples_per_pixel` x `samples_per_pixel` samples a pixel, sample (i, j) at `((i + 0.5) / s, (j + 0.5) / s)`.

use crate::base::{Error, Result};
use crate::graph::graph::check_sites;
use crate::photo::{Field, check_size};

/// Samples a pixel, along one axis, for lattice cells of `1 / density` px^2: at least four samples a cell.
pub fn samples_per_pixel(density: f64) -> usize {
    (2.0 * density.sqrt() - 1e-9).ceil().max(1.0) as usize
}

pub(crate) fn check_sampling(
    sites: &[[f64; 2]],
    width: usize,
    height: usize,
    samples_per_pixel: usize,
    fields: &[&Field],
) -> Result<()> {
    check_size(width, height)?;
    if !(1..=16).contains(&samples_per_pixel) {
        return Err(Error::Input(format!("samples_per_pixel is {samples_per_pixel}, but it must be between 1 and 16")));
    }
    if let Some(field) = fields.iter().find(|f| f.width() != width || f.height() != height) {
        return Err(Error::Input(format!(
            "the field is {} x {} pixels, but the canvas is {width} x {height}",
            field.width(),
            field.height()
        )));
    }
    check_sites(sites, width, height)
}

pub(super) fn area_of(count: u32, samples_per_pixel: usize) -> f64 {
    let step = 1.0 / samples_per_pixel as f64;
    f64::from(count) * step * step
}

/// The mean position of `count` samples whose columns and rows have these sums, in pixels; the site itself without samples.
pub(crate) fn centroid_of(sums: [u64; 2], count: u32, site: [f64; 2], samples_per_pixel: usize) -> [f64; 2] {
    if count == 0 {
        return site;
    }
    let step = 1.0 / samples_per_pixel as f64;
    sums.map(|sum| (sum as f64 / f64::from(count) + 0.5) * step)
}

pub(super) fn mean_of(sum: f64, count: u32, [x, y]: [f64; 2], field: &Field) -> f32 {
    if count > 0 { (sum / f64::from(count)) as f32 } else { field.bilinear(x, y) }
}
