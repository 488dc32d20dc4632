//! Means over the cells of a lattice, in closed form: the nearest node of a sample is one of a row above and one of a row below.
//!
//! Source: our own; the same means as those of [`cells`](crate::graph::cells::voronoi::cells), in a fraction of the time.

use rayon::prelude::*;

use crate::base::{Control, Result};
use crate::graph::cells::sampling::{check_sampling, mean_of};
use crate::graph::graph::Adjacency;
use crate::graph::lattice::Lattice;
use crate::photo::Field;

/// Pairs of lattice rows whose means one thread computes at once.
const BAND: usize = 16;

/// The mean of the field over every lattice cell, the nearest node being known in closed form.
///
/// # Errors
/// [`crate::Error::Input`] if `samples_per_pixel` is not between 1 and 16; [`crate::Error::Cancelled`].
pub fn lattice_means(lattice: &Lattice, field: &Field, samples_per_pixel: usize, control: &Control) -> Result<Vec<f32>> {
    check_sampling(&[lattice.site(0)], field.width(), field.height(), samples_per_pixel, &[field])?;
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

/// The first of `rows` rows from which on something holds; `rows` if it never does.
fn first_row(rows: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, rows);
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::cells::sampling::samples_per_pixel;
    use crate::graph::cells::voronoi::cells;
    use crate::options::LatticeKind;

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
}
