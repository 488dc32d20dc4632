//! Error diffusion over the lattice row by row: which nodes are kept, our way.
//!
//! The paper diffuses importance as it diffuses tone, by priority ([`diffuse`]). On a lattice nothing but the order of
//! ties then tells the nodes of a flat part apart: they fall into a few regular patterns with seams between them, parts below
//! some 0.08 keep no node at all, and a tenth of the nodes more or fewer is kept than the importance asks for.
//!
//! Here nodes are labelled row by row, every other row backwards (a serpentine scan), by the same rule and with the same weights.
//! Errors always find an unlabelled neighbour, so the number of nodes kept is the sum of the values, but for what crosses the
//! borders of the canvas.
//! Weights vary by a pseudo-random share, as in R. Ulichney, "Dithering with blue noise" (1988), or labels would line up here too.
//!
//! Bands of rows are labelled side by side, whatever the number of threads. Each starts some rows before its own, with pseudo-random
//! errors, so that patterns are as far as elsewhere when its own rows come; the labels of those before are forgotten. Beyond the
//! borders the canvas lies mirrored, or errors would gather at them.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::base::{Control, Result, mixed, noise};
use crate::diffusion::{Diffusion, LocalMean, Open, check_input, diffuse, weigh};
use crate::graph::Lattice;
use crate::options::Order;

/// Rows of a band, an even number.
const ROWS_IN_BAND: usize = 128;

/// Rows that are labelled before those of a band: as far as errors are felt where one node in twenty is kept.
const WARM_UP: usize = 16;

/// Columns that are labelled beyond both ends of a row, and forgotten.
const MARGIN: usize = 8;

/// By which share weights vary, at most.
const UNEVENNESS: f64 = 0.5;

/// A label for every node of the lattice: 1 where it is kept.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one finite value a node; [`crate::Error::Cancelled`].
pub fn diffuse_lattice(lattice: &Lattice, values: &[f32], parameters: &Diffusion, control: &Control) -> Result<Vec<u8>> {
    match parameters.order {
        Order::Global => diffuse(lattice, values, None, parameters, control),
        Order::Rows => diffuse_in_rows(lattice, values, parameters, control),
    }
}

fn diffuse_in_rows(lattice: &Lattice, values: &[f32], parameters: &Diffusion, control: &Control) -> Result<Vec<u8>> {
    check_input(lattice, values, None)?;
    let mut labels = vec![0; values.len()];
    let margin = MARGIN.min(lattice.row(0).len().min(lattice.nodes_in_two_rows() - lattice.row(0).len()).saturating_sub(1));
    let scan = Scan { lattice, values, parameters, margin };
    let done = AtomicUsize::new(0);
    labels.par_chunks_mut(ROWS_IN_BAND / 2 * lattice.nodes_in_two_rows()).enumerate().try_for_each(|(band, labels)| {
        let first = ROWS_IN_BAND * band;
        scan.label(first..(first + ROWS_IN_BAND).min(lattice.rows()), labels, control)?;
        control.report(done.fetch_add(labels.len(), Ordering::Relaxed) as f32 / values.len() as f32)
    })?;
    Ok(labels)
}

struct Scan<'a> {
    lattice: &'a Lattice,
    values: &'a [f32],
    parameters: &'a Diffusion,
    /// Columns beyond the ends of rows. In here a row has places: these, its columns, and as many again.
    margin: usize,
}

impl Scan<'_> {
    /// Labels the nodes of some rows.
    fn label(&self, band: Range<usize>, labels: &mut [u8], control: &Control) -> Result<()> {
        let lattice = self.lattice;
        let (warm_up, first) = (WARM_UP.min(lattice.rows() - 1), lattice.row(band.start).start);
        let mut local_mean = LocalMean::of_hops(self.parameters.hops, control);
        // What a row was passed, and what it passes to the next. Errors that begin at 0 would all come to a half in the same row.
        let spread = if warm_up > 0 { 0.5 } else { 0.0 };
        let mut received: Vec<f64> =
            (0..(lattice.nodes_in_two_rows() + 2 * self.margin) as u64).map(|k| spread * f64::from(noise(k))).collect();
        let mut passed = vec![0.0; received.len()];
        let mut forgotten = vec![0; lattice.nodes_in_two_rows()];
        let before = (1..=warm_up).rev().map(|k| band.start.abs_diff(k));
        for (k, row) in before.chain(band.clone()).enumerate() {
            // Beyond the last row lies the one above it.
            let following = (band.start + k + 1).abs_diff(warm_up);
            let next = if following < lattice.rows() { Some(following) } else { row.checked_sub(1) };
            let own = lattice.row(row);
            let labels = match k < warm_up {
                true => &mut forgotten[..own.len()],
                false => &mut labels[own.start - first..own.end - first],
            };
            control.check()?;
            self.label_row(row, next, &received, &mut passed, labels, &mut local_mean)?;
            std::mem::swap(&mut received, &mut passed);
            passed.fill(0.0);
        }
        Ok(())
    }

    /// Labels a row, which was passed errors, and passes its own to the next.
    fn label_row(
        &self,
        row: usize,
        next: Option<usize>,
        received: &[f64],
        passed: &mut [f64],
        labels: &mut [u8],
        local_mean: &mut LocalMean<'_>,
    ) -> Result<()> {
        let &Self { lattice, values, parameters, margin } = self;
        let (own, [along, across]) = (lattice.row(row), lattice.distances());
        let next = next.map(|next| lattice.row(next));
        let places = own.len() + 2 * margin;
        let is_backwards = row % 2 == 1;
        let mut carried = 0.0;
        for k in 0..places {
            let place = if is_backwards { places - 1 - k } else { k };
            let number = self.mirrored(&own, place);
            let start = f64::from(values[number]);
            let current = start + received[place] + carried;
            carried = 0.0;
            let label = u8::from(current >= 0.5);
            if let Some(own) = place.checked_sub(margin).and_then(|column| labels.get_mut(column)) {
                *own = label;
            }

            // The next in the row, then those in the next row.
            let mut open = [Open::default(); 3];
            let mut count = 0;
            if k + 1 < places {
                let ahead = if is_backwards { place - 1 } else { place + 1 };
                open[0] = Open { number: ahead as u32, start: values[self.mirrored(&own, ahead)], weight: along };
                count = 1;
            }
            let ahead = count;
            if let Some(next) = &next {
                let [left, right] = lattice.columns_beside(row);
                for side in left..=right {
                    let place = place.wrapping_add_signed(side);
                    if place < next.len() + 2 * margin {
                        open[count] = Open { number: place as u32, start: values[self.mirrored(next, place)], weight: across };
                        count += 1;
                    }
                }
            }
            let open = &mut open[..count];
            if open.is_empty() || !parameters.passes_on(start, label) {
                continue;
            }
            let alpha = parameters.share(start, || local_mean.mean(lattice, values, number))?;
            weigh(open, start, parameters);
            let bits = mixed(number as u64);
            let mut sum = 0.0;
            for (k, other) in open.iter_mut().enumerate() {
                let unit = (bits >> (20 * k) & 0xF_FFFF) as f64 / f64::from(1 << 20);
                other.weight *= 1.0 + UNEVENNESS * (2.0 * unit - 1.0);
                sum += other.weight;
            }
            let share = alpha * (current - f64::from(label)) / sum;
            for (k, other) in open.iter().enumerate() {
                if k < ahead {
                    carried = other.weight * share;
                } else {
                    passed[other.number as usize] += other.weight * share;
                }
            }
        }
        Ok(())
    }

    /// The node in a place of a row, or that it mirrors.
    fn mirrored(&self, row: &Range<usize>, place: usize) -> usize {
        match place.checked_sub(self.margin) {
            None => row.start + self.margin - 1 - place,
            Some(column) if column < row.len() => row.start + column,
            Some(column) => row.end - 1 - (column - row.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Error;
    use crate::graph::Adjacency;
    use crate::options::{Alpha, LatticeKind, Options};

    fn kept(lattice: &Lattice, values: &[f32], alpha: Alpha) -> Vec<u8> {
        let parameters = Diffusion { alpha, ..Diffusion::of_importance(&Options::default()) };
        diffuse_in_rows(lattice, values, &parameters, &Control::new()).unwrap()
    }

    fn count(labels: &[u8]) -> f64 {
        labels.iter().map(|label| f64::from(*label)).sum()
    }

    #[test]
    fn of_any_flat_importance_its_share_is_kept_in_every_part() {
        for kind in [LatticeKind::Hexagonal, LatticeKind::Square] {
            let lattice = Lattice::new(kind, 200, 300, 1.0).unwrap();
            for value in [0.01, 0.05, 0.1, 0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75, 0.97] {
                let labels = kept(&lattice, &vec![value; lattice.len()], Alpha::Constant(1.0));
                let share = |labels: &[u8]| count(labels) / labels.len() as f64;
                assert!((share(&labels) - f64::from(value)).abs() < 0.002, "{kind:?}, {value}: {}", share(&labels));
                for part in labels.chunks(lattice.len().div_ceil(10)) {
                    assert!((share(part) - f64::from(value)).abs() < 0.011, "{kind:?}, {value}: {} in a part", share(part));
                }
            }
        }
    }

    #[test]
    fn bands_do_not_show() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 600, 800, 1.0).unwrap();
        let labels = kept(&lattice, &vec![0.1; lattice.len()], Alpha::Constant(1.0));
        // Nodes next to each other that are both kept, by row; at random, a tenth of 0.3 a node would be.
        let mut pairs = vec![0.0; lattice.rows()];
        for (row, pairs) in pairs.iter_mut().enumerate() {
            for node in lattice.row(row).filter(|node| labels[*node] == 1) {
                lattice.for_each_neighbor(node, |other, _| *pairs += f64::from(labels[other]));
            }
        }
        let of_rows = |rows: Range<usize>| rows.clone().map(|row| pairs[row]).sum::<f64>() / rows.len() as f64;
        let seams: Vec<usize> = (1..lattice.rows() / ROWS_IN_BAND).map(|band| band * ROWS_IN_BAND).collect();
        assert!(seams.len() >= 4);
        let at_seams = seams.iter().map(|seam| of_rows(seam - 1..seam + 1)).sum::<f64>() / seams.len() as f64;
        let random = 0.1 * 0.1 * 6.0 * 600.0 / 1.07;
        assert!(at_seams < 0.6 * random && of_rows(0..lattice.rows()) < 0.1 * random, "{at_seams} {random}");
    }

    #[test]
    fn labels_do_not_depend_on_the_threads_and_a_cancelled_scan_ends() {
        let lattice = Lattice::new(LatticeKind::Square, 90, 700, 1.0).unwrap();
        let values: Vec<f32> = (0..lattice.len()).map(|i| 0.5 + 0.5 * crate::base::noise(i as u64)).collect();
        let [one, two, five] = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| kept(&lattice, &values, Alpha::Dynamic))
        });
        assert!(one == two && two == five && one.contains(&0) && one.contains(&1));
        let control = Control::new();
        control.cancel();
        let ended = diffuse_in_rows(&lattice, &values, &Diffusion::of_importance(&Options::default()), &control);
        assert!(matches!(ended, Err(Error::Cancelled)));
    }

    #[test]
    fn a_threshold_passes_nothing_on_and_a_line_of_nodes_is_one_row_or_column() {
        for (width, height) in [(400, 1), (1, 400), (1, 1)] {
            let lattice = Lattice::new(LatticeKind::Hexagonal, width, height, 1.0).unwrap();
            let flat = |value: f32, alpha| count(&kept(&lattice, &vec![value; lattice.len()], Alpha::Constant(alpha)));
            assert_eq!([flat(0.4, 0.0), flat(0.6, 0.0)], [0.0, lattice.len() as f64]);
            assert!((flat(0.3, 1.0) - 0.3 * lattice.len() as f64).abs() <= 2.0);
        }
    }
}
