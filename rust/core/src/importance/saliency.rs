//! Fine-grained saliency: where a photo differs from its surroundings, at full resolution.
//!
//! After Montabone and Soto, "Human detection using a mobile platform and novel features derived from a visual saliency
//! mechanism" (Image and Vision Computing 28, 2010), as OpenCV's `StaticSaliencyFineGrained` computes it, rounding by
//! rounding: the photo is blurred twice; at six scales each pixel is compared with the mean of a box around it (by an
//! integral image); how much it is brighter (on) or darker (off) than its surroundings is summed over the scales, stretched
//! to 0..255 each, added, and stretched again. The map equals OpenCV's on every pixel, quirks included, so that a drawing does
//! not depend on whether Python or this code computed it. Four quirks can be seen:
//! - the box reaches one pixel further to the right and down than to the left and up;
//! - the integral image is in f32, so that from about 65,000 white pixels on the means are a little rough: 9 megapixels of one
//!   bright grey are not all 0;
//! - on and off are stretched each on its own, so that the faintest difference of a nearly flat photo becomes 255;
//! - a pixel that is brighter than its surroundings at one scale and darker at another can exceed 255, where it wraps to dark.
//!
//! What this module does not do: colour (it takes 8-bit luma) and resampling.

use rayon::prelude::*;

use crate::photo::{Field, check_size, luma_to_u8};

/// Half sides of the six boxes, in pixels: three octaves from 12 and three from 28.
const NEIGHBOURHOODS: [usize; 6] = [12, 24, 48, 28, 56, 112];

/// Columns that are summed from the top down at once: more leave threads idle on narrow pictures.
const STRIPE: usize = 128;

/// The saliency map of a photo, given as luma: on its 8-bit values, as [`fine_grained`].
pub(super) fn of_luma(luma: &Field) -> Field {
    fine_grained(&luma_to_u8(luma), luma.width(), luma.height())
}

/// The saliency map of an 8-bit image of `width * height` pixels, at the same size; its values are integers / 255.
/// An image of one grey (up to about 65,000 pixels, see above) or of one pixel has no saliency: 0 everywhere.
///
/// The result does not depend on the number of threads.
///
/// # Panics
/// If `luma` does not hold `width * height` values or a side is not one that a [`Field`] may have.
///
/// # Allocations
/// 13 bytes a pixel at the peak: the integral image (4), both sums (4), the blurred photo (1), and the map (4).
pub fn fine_grained(luma: &[u8], width: usize, height: usize) -> Field {
    assert_eq!(luma.len(), width * height, "one luma value a pixel");
    let sums = on_off_sums(luma, width, height);
    let values = mix(&sums);
    check_size(width, height).expect("the size is the caller's promise");
    Field::of_valid(width, height, values)
}

/// On and off of a pixel, summed over the scales (at most 6 * 255 each).
#[derive(Debug, Clone, Copy, Default)]
struct OnOff {
    on: u16,
    off: u16,
}

fn on_off_sums(luma: &[u8], width: usize, height: usize) -> Vec<OnOff> {
    let mut blurred = blur(luma, width);
    blurred = blur(&blurred, width);
    let integral = Integral::new(&blurred, width);
    let mut sums = vec![OnOff::default(); width * height];
    // Each row reads the finished integral image and writes its own sums: the split over threads cannot show.
    sums.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let centres = &blurred[y * width..(y + 1) * width];
        for neighbourhood in NEIGHBOURHOODS {
            integral.compare(centres, y, height, neighbourhood, row);
        }
    });
    sums
}

/// The 3 x 3 binomial blur (1 2 1 in both directions), rounded to 8 bits once; beyond the border the image is mirrored about
/// the outermost pixels.
fn blur(image: &[u8], width: usize) -> Vec<u8> {
    let height = image.len() / width;
    let mut blurred = vec![0u8; image.len()];
    blurred.par_chunks_exact_mut(width).enumerate().for_each_init(
        || vec![0u16; width + 2],
        |columns, (y, target)| {
            let row = |y: usize| &image[y * width..(y + 1) * width];
            let (above, below) = mirrored(y, height);
            // One margin on each side holds the mirrored column.
            for (((sum, a), b), c) in columns[1..=width].iter_mut().zip(row(above)).zip(row(y)).zip(row(below)) {
                *sum = u16::from(*a) + 2 * u16::from(*b) + u16::from(*c);
            }
            columns[0] = columns[1 + mirrored(0, width).0];
            columns[width + 1] = columns[1 + mirrored(width - 1, width).1];
            for (value, w) in target.iter_mut().zip(columns.windows(3)) {
                *value = ((w[0] + 2 * w[1] + w[2] + 8) >> 4) as u8;
            }
        },
    );
    blurred
}

/// The neighbours of index `i` on an axis of `length`, mirrored about its first and last index.
fn mirrored(i: usize, length: usize) -> (usize, usize) {
    if length == 1 {
        return (0, 0);
    }
    (if i == 0 { 1 } else { i - 1 }, if i == length - 1 { length - 2 } else { i + 1 })
}

/// Sums over all pixels above and to the left of a corner, in f32 as OpenCV keeps them: one row and one column more than the image.
///
/// A sum is that of the corner above it plus the row's, rounded to f32 where it exceeds 2^24. The row's own sum is exact: at most
/// 65,535 * 255 < 2^24.
struct Integral {
    sums: Vec<f32>,
    width: usize,
}

impl Integral {
    fn new(image: &[u8], width: usize) -> Self {
        let stride = width + 1;
        let mut sums = vec![0.0f32; stride * (image.len() / width + 1)];
        sums.par_chunks_exact_mut(stride).skip(1).zip(image.par_chunks_exact(width)).for_each(|(sums, row)| {
            let mut along = 0u32;
            for (sum, value) in sums[1..].iter_mut().zip(row) {
                along += u32::from(*value);
                *sum = along as f32;
            }
        });
        // From the top down, in stripes of columns.
        let mut stripes: Vec<Vec<&mut [f32]>> = (0..stride.div_ceil(STRIPE)).map(|_| Vec::new()).collect();
        for row in sums.chunks_exact_mut(stride) {
            for (stripe, part) in stripes.iter_mut().zip(row.chunks_mut(STRIPE)) {
                stripe.push(part);
            }
        }
        stripes.into_par_iter().for_each(|mut rows| {
            for below in 1..rows.len() {
                let (above, rows) = rows.split_at_mut(below);
                for (sum, above) in rows[0].iter_mut().zip(above[below - 1].iter()) {
                    *sum += above;
                }
            }
        });
        Self { sums, width }
    }

    /// Adds to a row of `sums` how much each of its pixels differs from the mean of its box without itself.
    fn compare(&self, centres: &[u8], y: usize, height: usize, neighbourhood: usize, sums: &mut [OnOff]) {
        let width = self.width;
        // The box is [low, high) on each axis, cut at the image's border.
        let low = |p: usize| (p + 1).saturating_sub(neighbourhood);
        let high = |p: usize, length: usize| (p + neighbourhood + 1).min(length);
        let (top, bottom) = (low(y), high(y, height));
        let rows = bottom - top;
        let above = &self.sums[top * (width + 1)..(top + 1) * (width + 1)];
        let below = &self.sums[bottom * (width + 1)..(bottom + 1) * (width + 1)];

        // Between these columns no box is cut, so that the corners move along with the pixel and the division is by a constant.
        let first = (neighbourhood - 1).min(width);
        let last = (width + 1).saturating_sub(neighbourhood + 1).max(first);
        for x in (0..first).chain(last..width) {
            let (left, right) = (low(x), high(x, width));
            let others = (rows * (right - left)) as f32 - 1.0;
            let sum = below[right] + above[left] - below[left] - above[right];
            sums[x].add(centres[x], sum, others);
        }
        if first < last {
            let side = 2 * neighbourhood;
            let count = last - first;
            let others = (rows * side) as f32 - 1.0;
            let (above_left, above_right) = (&above[..count], &above[side..side + count]);
            let (below_left, below_right) = (&below[..count], &below[side..side + count]);
            let (centres, sums) = (&centres[first..last], &mut sums[first..last]);
            for i in 0..count {
                // The order of the additions is OpenCV's: it shows where the sums are rounded.
                sums[i].add(centres[i], below_right[i] + above_left[i] - below_left[i] - above_right[i], others);
            }
        }
    }
}

impl OnOff {
    /// Adds the difference between a pixel and the mean of its box of `sum` without it, over the `others`.
    #[inline(always)]
    fn add(&mut self, centre: u8, sum: f32, others: f32) {
        let centre = f32::from(centre);
        let difference = centre - (sum - centre) / others;
        // Truncated to 8 bits, as OpenCV stores it: rounded sums of huge photos may go beyond 255, and wrap. A lone pixel has no
        // others: its difference is NaN, which becomes 0.
        let whole = difference as i32;
        self.on += (whole.max(0) & 255) as u16;
        self.off += (whole.min(0).wrapping_neg() & 255) as u16;
    }
}

/// The map of the sums: on and off stretched to 0..255 each, added, stretched again, every time truncated to 8 bits.
fn mix(sums: &[OnOff]) -> Vec<f32> {
    let higher = |a: OnOff, b: OnOff| OnOff { on: a.on.max(b.on), off: a.off.max(b.off) };
    let OnOff { on: highest_on, off: highest_off } = sums.par_iter().copied().reduce(OnOff::default, higher);
    // Few distinct sums, many pixels: a table each. Where all is 0 the quotient is NaN, which becomes 0.
    let stretch =
        |highest: u16| -> Vec<u8> { (0..=highest).map(|v| (255.0 * f64::from(f32::from(v) / f32::from(highest))) as u8).collect() };
    let (on, off) = (stretch(highest_on), stretch(highest_off));
    let brightest = on[usize::from(highest_on)].max(off[usize::from(highest_off)]);
    let last: Vec<f32> = (0..=510u16)
        .map(|v| {
            let stretched = 255.0 * f64::from(v) / f64::from(brightest);
            // Through i32: beyond 255 it wraps around, as in OpenCV. The factor instead of a division is OpenCV's too.
            f32::from(stretched as i32 as u8) * (1.0 / 255.0)
        })
        .collect();
    sums.par_iter().map(|s| last[usize::from(on[usize::from(s.on)]) + usize::from(off[usize::from(s.off)])]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, grey: impl Fn(usize, usize) -> usize) -> Vec<u8> {
        (0..width * height).map(|i| (grey(i % width, i / width) % 256) as u8).collect()
    }

    /// Nearly white, so that the sums of a megapixel exceed 2^24 by far.
    fn bright(x: usize, y: usize) -> usize {
        255 - (x * x + y * 3) % 7 - ((x / 97 + y / 61) % 2) * 4
    }

    #[test]
    fn does_not_depend_on_the_threads() {
        let image = image(1200, 900, bright);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| fine_grained(&image, 1200, 900))
        };
        assert_eq!(run(1), run(7));
    }
}
