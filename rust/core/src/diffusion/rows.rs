//! Nodes labelled in the order of their numbers, in bands side by side.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::base::{Result, noise};
use crate::diffusion::task::{Task, UNLABELLED};
use crate::diffusion::weights::{LocalMean, Open, area_ratio, weigh};
use crate::graph::Adjacency;

/// Nodes of a band at least: below, threads cost more than they bring.
const LEAST_BAND: usize = 4096;

/// Rows of a band, on a square canvas.
const ROWS_IN_BAND: usize = 64;

/// This share of a band's nodes is labelled before it: some 16 rows.
pub(super) const WARM_UP_IN_BAND: usize = 4;

/// How many nodes a band has where there are `count`, but for the last, which may have fewer. It depends on nothing else, or
/// drawings would.
pub(crate) fn band_size(count: usize) -> usize {
    let least = LEAST_BAND.max(ROWS_IN_BAND * count.isqrt());
    count.div_ceil((count / least).max(1)).max(1)
}

impl<G: Adjacency> Task<'_, G> {
    /// Labels the nodes in the order of their numbers, in bands of `size`.
    pub(super) fn by_number(&self, size: usize) -> Result<Vec<u8>> {
        let mut labels = vec![UNLABELLED; self.values.len()];
        let done = AtomicUsize::new(0);
        labels.par_chunks_mut(size).enumerate().try_for_each(|(band, labels)| {
            self.label_band(band * size, size / WARM_UP_IN_BAND, labels)?;
            let done = done.fetch_add(labels.len(), Ordering::Relaxed) + labels.len();
            self.control.report(done as f32 / self.values.len() as f32)
        })?;
        Ok(labels)
    }

    /// Labels the nodes from `first` on, after up to `warm_up` before them.
    fn label_band(&self, first: usize, warm_up: usize, labels: &mut [u8]) -> Result<()> {
        let &Self { graph, values, areas, parameters, .. } = self;
        let tried = first.saturating_sub(warm_up)..first + labels.len();
        let mut received = vec![0.0; tried.len()];
        let mut local_mean = LocalMean::of_hops(parameters.hops, self.control);
        let mut open: Vec<Open> = Vec::with_capacity(16);
        for number in tried.clone() {
            let start = f64::from(values[number]);
            let mut current = start + received[number - tried.start];
            if first == 0 && self.is_at_the_top(number) {
                // No row has passed errors on to it: what they might be.
                current += 0.5 * f64::from(noise(number as u64)) * self.share_of(number, &mut local_mean)?;
            }
            let label = u8::from(current >= 0.5);
            if number >= first {
                labels[number - first] = label;
            }
            let error = current - f64::from(label);
            if error == 0.0 || !parameters.passes_on(start, label) {
                continue;
            }
            let alpha = self.share_of(number, &mut local_mean)?;
            if alpha == 0.0 {
                continue;
            }
            open.clear();
            graph.for_each_neighbor(number, |neighbor, distance| {
                if neighbor > number {
                    open.push(Open { number: neighbor as u32, start: values[neighbor], weight: distance });
                }
            });
            if open.is_empty() {
                continue;
            }
            let share = alpha * error / weigh(&mut open, start, parameters);
            for other in &open {
                let neighbor = other.number as usize;
                if let Some(received) = received.get_mut(neighbor - tried.start) {
                    *received += other.weight * share * areas.map_or(1.0, |areas| area_ratio(areas[number], areas[neighbor]));
                }
            }
        }
        Ok(())
    }

    /// Whether less than a third of a node's neighbours have lower numbers, and can pass errors on to it.
    fn is_at_the_top(&self, number: usize) -> bool {
        is_at_the_top(self.graph, number)
    }
}

pub(super) fn is_at_the_top(graph: &impl Adjacency, number: usize) -> bool {
    let (mut before, mut all) = (0, 0);
    graph.for_each_neighbor(number, |neighbor, _| {
        before += usize::from(neighbor < number);
        all += 1;
    });
    3 * before < all
}
