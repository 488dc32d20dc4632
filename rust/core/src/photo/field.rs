//! A field: a float raster in [0, 1], and the one place where axes, pixel centres and units are defined.
//!
//! Everywhere in graphstipple x runs right and y runs down, in pixels of the input image. The pixel in column c and row r covers
//! `[c, c+1) x [r, r+1)`; its centre is `(c + 0.5, r + 0.5)`. Rasters are row-major. 0 is black, 1 is white.
//! What this module does not do: colour (see [`super::tone`]) and cells (see [`crate::stages::cells`]).

use rayon::prelude::*;

use crate::base::{Error, Result};

/// The longest side that an image may have, in pixels. It keeps every pixel and sample index within 32 bits a side, and
/// every coordinate exact in the 1/8 px units of the SVG.
pub const MAX_SIDE: usize = 65_535;

/// A float raster in [0, 1], row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Field {
    /// A field of `width` x `height` values, row by row.
    ///
    /// # Errors
    /// [`Error::Input`] if a side is 0 or above [`MAX_SIDE`], the number of values is not `width * height`, or a value is not in
    /// [0, 1].
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Result<Self> {
        check_size(width, height)?;
        if values.len() != width * height {
            return Err(Error::Input(format!(
                "the field has {} values, but {width} x {height} pixels need {}",
                values.len(),
                width * height
            )));
        }
        check_values(&values, 1, width, [0, 0])?;
        Ok(Self { width, height, values })
    }

    /// A field whose values are sure to be in [0, 1] and as many as the size says.
    pub(crate) fn of_valid(width: usize, height: usize, values: Vec<f32>) -> Self {
        debug_assert!(values.len() == width * height && values.iter().all(|v| (0.0..=1.0).contains(v)));
        Self { width, height, values }
    }

    /// A field that is `value` everywhere.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn constant(width: usize, height: usize, value: f32) -> Result<Self> {
        check_size(width, height)?;
        Self::new(width, height, vec![value; width * height])
    }

    /// Width in pixels, at least 1.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels, at least 1.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values, without the size.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// The value of the pixel in `column` and `row`.
    pub fn at(&self, column: usize, row: usize) -> f32 {
        self.values[row * self.width + column]
    }

    /// The bilinear value at the point (x, y) in pixels: interpolated between pixel centres, constant beyond the outermost centres.
    pub fn bilinear(&self, x: f64, y: f64) -> f32 {
        let axis = |position: f64, length: usize| {
            let p = (position - 0.5).clamp(0.0, (length - 1) as f64);
            let low = p as usize;
            (low, (low + 1).min(length - 1), (p - low as f64) as f32)
        };
        let (x0, x1, fx) = axis(x, self.width);
        let (y0, y1, fy) = axis(y, self.height);
        let top = self.at(x0, y0) + fx * (self.at(x1, y0) - self.at(x0, y0));
        let bottom = self.at(x0, y1) + fx * (self.at(x1, y1) - self.at(x0, y1));
        (top + fy * (bottom - top)).clamp(0.0, 1.0)
    }

    /// The field at another size: each axis on its own is averaged over the source pixels that a target pixel covers when it
    /// shrinks, and interpolated linearly when it grows. The same size gives the same values.
    ///
    /// # Errors
    /// As [`Field::new`] for the new size.
    pub fn resample(&self, width: usize, height: usize) -> Result<Self> {
        check_size(width, height)?;
        if [width, height] == [self.width, self.height] {
            return Ok(self.clone());
        }
        let columns = AxisWeights::new(self.width, width);
        let rows = AxisWeights::new(self.height, height);
        let mut narrow = vec![0.0f32; width * self.height];
        self.values.par_chunks_exact(self.width).zip(narrow.par_chunks_exact_mut(width)).for_each(|(source, target)| {
            for (x, value) in target.iter_mut().enumerate() {
                *value = columns.of(x).map(|(i, w)| w * source[i]).sum();
            }
        });
        let mut values = vec![0.0f32; width * height];
        values.par_chunks_exact_mut(width).enumerate().for_each(|(y, target)| {
            for (i, w) in rows.of(y) {
                for (value, source) in target.iter_mut().zip(&narrow[i * width..(i + 1) * width]) {
                    *value += w * source;
                }
            }
            for value in target {
                *value = value.clamp(0.0, 1.0);
            }
        });
        Ok(Self { width, height, values })
    }
}

impl Field {
    /// The means of its boxes of `factor` x `factor` pixels; those of the last column and the last row take the remainder too.
    pub(super) fn reduced(&self, factor: usize) -> Self {
        let [width, height] = [self.width, self.height];
        let [columns, rows] = [width, height].map(|side| boxes(side, factor));
        let range =
            |index: usize, count: usize, side: usize| index * factor..if index + 1 == count { side } else { (index + 1) * factor };
        let mean = |i: usize| {
            let (x, y) = (range(i % columns, columns, width), range(i / columns, rows, height));
            let pixels = (x.len() * y.len()) as f64;
            let rows = y.flat_map(|y| &self.values[y * width..][x.clone()]);
            (rows.fold(0.0, |sum, value| sum + f64::from(*value)) / pixels) as f32
        };
        Self::of_valid(columns, rows, (0..columns * rows).into_par_iter().map(mean).collect())
    }
}

/// Boxes on a side of so many pixels.
pub(super) fn boxes(side: usize, factor: usize) -> usize {
    (side / factor).max(1)
}

/// How far a Gaussian kernel reaches, in sigmas: what lies beyond is 3 in a thousand.
const KERNEL_REACH: f64 = 3.0;

/// Sigma of a Gaussian, in pixels of a smaller copy, at which a blur of the copy is as good.
const REDUCED_SIGMA: f64 = 6.0;

/// Rows that one thread blurs at once. More leave threads idle on small pictures, fewer blur more rows along twice.
pub(crate) const BLURRED_ROWS: usize = 64;

/// Columns that are blurred at once, their sums in registers.
const AT_ONCE: usize = 32;

impl Field {
    /// The field under a Gaussian of `sigma` pixels, cut at three sigmas, the field mirrored at its borders. Sigma 0 changes nothing.
    ///
    /// A wide Gaussian is applied to a smaller copy, so that the work does not grow with sigma. The result does not depend on the
    /// number of threads or the platform.
    pub(crate) fn blurred(&self, sigma: f64) -> Self {
        let blur = match Blur::new(self, sigma) {
            Blur::Whole(blurred) => return blurred,
            blur => blur,
        };
        let mut values = vec![0.0f32; self.values.len()];
        values.par_chunks_mut(BLURRED_ROWS * self.width).enumerate().for_each(|(band, values)| {
            let mut rows = blur.rows();
            for (y, target) in (band * BLURRED_ROWS..).zip(values.chunks_exact_mut(self.width)) {
                target.copy_from_slice(rows.row(y));
            }
        });
        Self { values, ..*self }
    }
}

/// A field under a Gaussian, row by row: only a few rows of it are in memory at once.
pub(crate) enum Blur<'a> {
    /// Blurred as its rows are asked for.
    Rows { field: &'a Field, kernel: Vec<f32> },
    /// Blurred wholly, by way of a smaller copy.
    Whole(Field),
}

impl<'a> Blur<'a> {
    /// See [`Field::blurred`].
    pub(crate) fn new(field: &'a Field, sigma: f64) -> Self {
        let smaller = (sigma / REDUCED_SIGMA) as usize;
        if smaller > 1 {
            let size = [field.width, field.height].map(|side| side.div_ceil(smaller));
            let copy = field.resample(size[0], size[1]).map(|copy| copy.blurred(sigma / smaller as f64));
            return Self::Whole(
                copy.and_then(|copy| copy.resample(field.width, field.height)).expect("no side is 0 or longer than before"),
            );
        }
        Self::Rows { field, kernel: gaussian(sigma) }
    }

    /// The rows, which must be asked for from the top down.
    pub(crate) fn rows(&self) -> BlurredRows<'_> {
        let (width, window) = match self {
            Self::Rows { field, kernel } => (field.width, kernel.len().min(field.height)),
            Self::Whole(_) => (0, 0),
        };
        BlurredRows { blur: self, across: vec![0.0; window * width], window, done: None, padded: Vec::new(), row: vec![0.0; width] }
    }
}

/// The rows of a [`Blur`].
pub(crate) struct BlurredRows<'a> {
    blur: &'a Blur<'a>,
    /// The last rows that were blurred along, as many as the kernel needs (or all): row y in place y modulo their number.
    across: Vec<f32>,
    window: usize,
    /// The next row to blur along.
    done: Option<usize>,
    padded: Vec<f32>,
    row: Vec<f32>,
}

impl BlurredRows<'_> {
    /// Row `y`, not above the last one that was asked for.
    pub(crate) fn row(&mut self, y: usize) -> &[f32] {
        let (field, kernel) = match self.blur {
            Blur::Whole(field) => return &field.values[y * field.width..(y + 1) * field.width],
            Blur::Rows { field, kernel } => (*field, kernel.as_slice()),
        };
        let (width, height) = (field.width, field.height);
        let reach = kernel.len() / 2;
        // A field lower than the kernel is mirrored all over.
        let (first, end) = if self.window == height { (0, height) } else { (y.saturating_sub(reach), (y + reach + 1).min(height)) };
        for source in self.done.unwrap_or(first).max(first)..end {
            let row = &field.values[source * width..(source + 1) * width];
            self.padded.clear();
            self.padded.extend((0..reach).map(|i| row[mirrored(i as isize - reach as isize, width)]));
            self.padded.extend_from_slice(row);
            self.padded.extend((0..reach).map(|i| row[mirrored((width + i) as isize, width)]));
            let target = &mut self.across[source % self.window * width..][..width];
            weigh(target, kernel, |offset| &self.padded[offset..offset + width]);
        }
        self.done = Some(end);
        let place = |offset: usize| mirrored((y + offset) as isize - reach as isize, height) % self.window * width;
        let sources: Vec<&[f32]> = (0..kernel.len()).map(|offset| &self.across[place(offset)..][..width]).collect();
        weigh(&mut self.row, kernel, |offset| sources[offset]);
        for value in &mut self.row {
            *value = if *value < 1.0 { *value } else { 1.0 };
        }
        &self.row
    }
}

/// The sum of all sources, each as long as the target, times their weights, in their order.
fn weigh<'a>(target: &mut [f32], weights: &[f32], source: impl Fn(usize) -> &'a [f32]) {
    let whole = target.len() / AT_ONCE * AT_ONCE;
    for first in (0..whole).step_by(AT_ONCE) {
        let mut sums = [0.0f32; AT_ONCE];
        for (offset, weight) in weights.iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(&source(offset)[first..first + AT_ONCE]) {
                *sum += weight * value;
            }
        }
        target[first..first + AT_ONCE].copy_from_slice(&sums);
    }
    for (i, value) in target.iter_mut().enumerate().skip(whole) {
        *value = weights.iter().enumerate().fold(0.0, |sum, (offset, weight)| sum + weight * source(offset)[i]);
    }
}

impl Field {
    /// The mean of all values.
    pub fn mean(&self) -> f64 {
        // Row by row, so that the sum is the same however the rows are shared out.
        let rows: Vec<f64> = self.values.par_chunks_exact(self.width).map(|row| row.iter().map(|v| f64::from(*v)).sum()).collect();
        rows.iter().sum::<f64>() / self.values.len() as f64
    }

    /// The least and the largest value.
    pub fn range(&self) -> [f32; 2] {
        // Bits of floats from 0 on are in the order of the floats, and whole numbers vectorize; -0 counts as 0.
        let wider = |[low, high]: [u32; 2], v: &f32| {
            let bits = v.to_bits() & (u32::MAX >> 1);
            [low.min(bits), high.max(bits)]
        };
        let of_row = |row: &[f32]| row.iter().fold([u32::MAX, 0], wider);
        let both = |a: [u32; 2], b: [u32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.values.par_chunks_exact(self.width).map(of_row).reduce(|| [u32::MAX, 0], both).map(f32::from_bits)
    }

    /// The value that so many are not above it, and the largest; no value is below 0.
    ///
    /// By counting, first the upper halves of the values' bits and then the lower halves where the upper one is that of the value that
    /// is looked for: bits of floats from 0 on are in the order of the floats. Nothing is copied.
    pub(crate) fn of_rank(&self, rank: usize) -> (f32, f32) {
        let values = &self.values;
        let count = |key: &(dyn Fn(u32) -> Option<u32> + Sync)| {
            let of_part = |part: &[f32]| {
                let mut counts = vec![0u32; 1 << 16];
                part.iter().filter_map(|value| key(value.to_bits())).for_each(|key| counts[key as usize] += 1);
                counts
            };
            let add = |mut a: Vec<u32>, b: Vec<u32>| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                a
            };
            values.par_chunks(COUNTED).map(of_part).reduce_with(add).unwrap_or_default()
        };
        let find = |counts: &[u32], rank: usize| {
            let mut below = 0;
            let key = counts.iter().position(|count| {
                below += *count as usize;
                below > rank
            });
            let key = key.unwrap_or(0);
            (key as u32, rank + counts[key] as usize - below)
        };
        let (upper, rank) = find(&count(&|bits| Some(bits >> 16)), rank);
        let (lower, _) = find(&count(&|bits| (bits >> 16 == upper).then_some(bits & 0xFFFF)), rank);
        let largest = values.par_iter().copied().reduce(|| 0.0, f32::max);
        (f32::from_bits(upper << 16 | lower), largest)
    }
}

/// Values that one thread counts at once.
const COUNTED: usize = 1 << 18;

/// Weights that sum to 1, an odd number of them.
fn gaussian(sigma: f64) -> Vec<f32> {
    let reach = (KERNEL_REACH * sigma).ceil() as i64;
    let weights: Vec<f64> =
        (-reach..=reach).map(|i| if i == 0 { 1.0 } else { libm::exp(-0.5 * (i as f64 / sigma).powi(2)) }).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| (w / total) as f32).collect()
}

/// Index `i` on an axis of `length`, mirrored about its borders as often as it takes: ..., 1, 0, 0, 1, ..., n - 1, n - 1, n - 2, ...
fn mirrored(i: isize, length: usize) -> usize {
    let period = 2 * length;
    let at = i.rem_euclid(period as isize) as usize;
    at.min(period - 1 - at)
}

/// Checks that values are in [0, 1]: those of rows of `width` pixels of so many channels, from a column and row of an image on.
///
/// # Errors
/// [`Error::Input`] with the first that is not, and its place.
pub(crate) fn check_values(values: &[f32], channels: usize, width: usize, [column, row]: [usize; 2]) -> Result<()> {
    // A NaN fails both comparisons, so it is caught too.
    let Some(at) = values.iter().position(|v| !(*v >= 0.0 && *v <= 1.0)) else { return Ok(()) };
    let pixel = at / channels;
    Err(Error::Input(format!(
        "the value at column {}, row {} is {}, but it must be between 0 and 1",
        column + pixel % width,
        row + pixel / width,
        values[at]
    )))
}

/// # Errors
/// [`Error::Input`] if a side is 0 or above [`MAX_SIDE`].
pub(crate) fn check_size(width: usize, height: usize) -> Result<()> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(Error::Input(format!(
            "the image is {width} x {height} pixels, but each side must be between 1 and {MAX_SIDE}"
        )));
    }
    Ok(())
}

/// Which source pixels a target pixel takes along one axis, and with what weight (the weights of a target sum to 1).
struct AxisWeights {
    first: Vec<usize>,
    offsets: Vec<usize>,
    weights: Vec<f32>,
}

impl AxisWeights {
    fn new(source: usize, target: usize) -> Self {
        let scale = source as f64 / target as f64;
        let mut axis = Self { first: Vec::with_capacity(target), offsets: vec![0], weights: Vec::new() };
        for t in 0..target {
            if scale >= 1.0 {
                let (begin, end) = (t as f64 * scale, (t + 1) as f64 * scale);
                let first = begin as usize;
                let last = (end.ceil() as usize).clamp(first + 1, source);
                axis.first.push(first);
                for i in first..last {
                    let covered = end.min((i + 1) as f64) - begin.max(i as f64);
                    axis.weights.push((covered / scale) as f32);
                }
            } else {
                let p = ((t as f64 + 0.5) * scale - 0.5).clamp(0.0, (source - 1) as f64);
                let first = (p as usize).min(source.saturating_sub(2));
                axis.first.push(first);
                let f = (p - first as f64) as f32;
                axis.weights.push(1.0 - f);
                if source > 1 {
                    axis.weights.push(f);
                }
            }
            axis.offsets.push(axis.weights.len());
        }
        axis
    }

    fn of(&self, target: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let weights = &self.weights[self.offsets[target]..self.offsets[target + 1]];
        weights.iter().enumerate().map(move |(k, w)| (self.first[target] + k, *w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_rank_is_what_sorting_says() {
        let values: Vec<f32> = (0..1000u32).map(|i| (i * 7919 % 1000 / 3) as f32 / 1e3).collect();
        let mut sorted = values.clone();
        sorted.sort_by(f32::total_cmp);
        let field = Field::new(100, 10, values).unwrap();
        for rank in [0, 1, 500, 990, 999] {
            assert_eq!(field.of_rank(rank), (sorted[rank], sorted[999]));
        }
        assert_eq!(field.range(), [sorted[0], sorted[999]]);
        assert_eq!(Field::new(2, 1, vec![-0.0, 0.25]).unwrap().range(), [0.0, 0.25]);
    }

    #[test]
    fn rejects_what_is_not_a_field() {
        assert!(Field::new(0, 1, vec![]).is_err());
        assert!(Field::new(2, 1, vec![0.0]).is_err());
        let message = Field::new(2, 1, vec![0.0, f32::NAN]).unwrap_err().to_string();
        assert_eq!(message, "the value at column 1, row 0 is NaN, but it must be between 0 and 1");
        assert!(Field::new(1, 1, vec![1.5]).is_err());
    }

    #[test]
    fn bilinear_is_exact_at_pixel_centres_and_constant_outside() {
        let field = Field::new(2, 2, vec![0.0, 1.0, 0.5, 0.25]).unwrap();
        assert_eq!(field.bilinear(0.5, 0.5), 0.0);
        assert_eq!(field.bilinear(1.5, 1.5), 0.25);
        assert_eq!(field.bilinear(1.0, 0.5), 0.5);
        assert_eq!(field.bilinear(-3.0, 9.0), 0.5);
    }

    #[test]
    fn blurring_spreads_a_point_and_keeps_the_mean_up_to_the_border() {
        let mut values = vec![0.0; 31 * 21];
        values[10 * 31 + 15] = 1.0;
        let field = Field::new(31, 21, values).unwrap();
        let blurred = field.blurred(2.0);
        assert!((blurred.mean() - field.mean()).abs() < 1e-8);
        // The density of a Gaussian of sigma 2 in its middle and two sigmas away.
        let expected = |d: f64| (-0.5 * (d / 2.0).powi(2)).exp() / (8.0 * std::f64::consts::PI);
        assert!((f64::from(blurred.at(15, 10)) - expected(0.0)).abs() < 3e-4);
        assert!((f64::from(blurred.at(19, 10)) - expected(4.0)).abs() < 3e-4);
        assert_eq!(blurred.at(15, 6), blurred.at(15, 14));
        assert_eq!(field.blurred(0.0), field);
        // A wide one, by way of a smaller copy: an edge becomes the error function.
        let edge = Field::new(400, 8, (0..3200).map(|i| if i % 400 < 200 { 0.0 } else { 1.0 }).collect()).unwrap().blurred(20.0);
        for (column, expected) in [(199, 0.49), (220, 0.847), (240, 0.978), (160, 0.024)] {
            assert!((edge.at(column, 4) - expected).abs() < 0.01, "{column}: {}", edge.at(column, 4));
        }
        // A kernel much wider than the field, and a flat field.
        assert!((f64::from(Field::new(2, 1, vec![0.0, 1.0]).unwrap().blurred(9.0).at(0, 0)) - 0.5).abs() < 0.01);
        assert!(Field::constant(5, 4, 1.0).unwrap().blurred(1.3).values().iter().all(|v| (*v - 1.0).abs() < 1e-6 && *v <= 1.0));
        assert_eq!([-3, -1, 0, 2, 3, 7].map(|i| mirrored(i, 3)), [2, 0, 0, 2, 2, 1]);
    }

    #[test]
    fn resample_keeps_the_mean_and_the_identity() {
        let values: Vec<f32> = (0..35).map(|i| (i * 13 % 35) as f32 / 34.0).collect();
        let field = Field::new(7, 5, values).unwrap();
        assert_eq!(field.resample(7, 5).unwrap(), field);
        let mean = |f: &Field| f.values().iter().sum::<f32>() / f.values().len() as f32;
        assert!((mean(&field.resample(3, 2).unwrap()) - mean(&field)).abs() < 1e-6);
        let one = Field::new(1, 1, vec![0.3]).unwrap().resample(4, 3).unwrap();
        assert!(one.values().iter().all(|v| (*v - 0.3).abs() < 1e-6));
    }
}
