//! Dots of several inks: where and how large as for black and white (see [`stipple`](crate::stages::stipple)).
//!
//! Every dot has the ink of which it stands for the most, with what the dots before it were wrong by: errors are diffused over the dots in
//! their order, to those that share nodes with them. So the amount of every ink is kept around every dot, and dots of several inks
//! are mixed evenly. No dot has an ink of which it itself stands for next to nothing, and a dot too small to be drawn hands on all.

use rayon::prelude::*;

use crate::base::{Control, Frame, Result, noise};
use crate::graph::{Triangulation, check_areas, check_one_a_node};
use crate::inks::{MOST_LABELS, Mixture, check_mixtures};
use crate::labels::inks::check_labels_below;
use crate::labels::inks::grounds::NO_GROUND;
use crate::labels::stipple::{Dotted, Marks, Parts, Stippled};

/// The most of a part that dots cover: beyond, none has room.
const MOST_LACK: f64 = 0.55;

/// The share of a label in what a dot itself stands for below which the dot does not have it, whatever others handed it: a black dot
/// among light grey ones would be seen.
const LEAST_SHARE: f32 = 0.03;

/// Stipples the smooth parts of a canvas of `width` x `height` pixels in the inks of the mixtures, those of the photo without emphasis.
/// The rest is as [`stipple`](crate::stages::stipple) has it; of a ground that should have less than its share, dots leave it more.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one of each a node, or an area is not finite or below 0; [`crate::Error::Cancelled`].
pub fn stipple_inks(
    triangulation: &Triangulation,
    grounds: &[u8],
    mixtures: &[Mixture],
    areas: &[f64],
    labels: &[u8],
    (width, height): (usize, usize),
    control: &Control,
) -> Result<Stippled> {
    let count = triangulation.graph.sites.len();
    check_labels_below("grounds", grounds, MOST_LABELS, count)?;
    check_mixtures(mixtures, count, MOST_LABELS)?;
    check_one_a_node("areas", areas.len(), count)?;
    check_areas("cell area", areas)?;
    check_labels_below("labels", labels, MOST_LABELS, count)?;
    let labels: Vec<u8> =
        labels.iter().zip(grounds).map(|(label, ground)| if *ground == NO_GROUND { *label } else { *ground }).collect();
    let lack_of = |(ground, mixture): (&u8, &Mixture)| match *ground {
        NO_GROUND => 0.0,
        ground => (1.0 - f64::from(mixture.part(ground))).clamp(0.0, MOST_LACK),
    };
    let lacks: Vec<f64> = grounds.par_iter().zip(mixtures).map(lack_of).collect();
    let parts = Parts { triangulation, grounds, none: NO_GROUND, labels: &labels, areas, lacks: &lacks };
    let dotted = Dotted::of(&parts, Frame { width: width as f64, height: height as f64 }, control)?;
    let inks = inks_of(&dotted, &parts, mixtures);
    let (mut labels, mut areas) = (labels.clone(), areas.to_vec());
    for ((node, ink), label) in dotted.dots.nodes.iter().map(|node| *node as usize).zip(&dotted.inks).zip(inks) {
        if let Some(label) = label {
            (labels[node], areas[node]) = (label, *ink);
        }
    }
    Ok(Stippled { labels, marks: Marks { places: dotted.places, areas } })
}

/// The label of every dot that is drawn.
fn inks_of(dotted: &Dotted, parts: &Parts, mixtures: &[Mixture]) -> Vec<Option<u8>> {
    let Dotted { dots, shares, inks, .. } = dotted;
    let count = dots.nodes.len();
    let labels = mixtures.iter().flat_map(Mixture::shares).map(|(label, _)| usize::from(label) + 1).max().unwrap_or(0);
    // Of every dot, what of each label it stands for and what others handed it, in px^2.
    let mut held = vec![0.0f32; count * labels];
    for share in shares.iter().flatten() {
        let (node, dot) = (share.node as usize, share.dot as usize);
        let ground = parts.grounds[node];
        let lack = 1.0 - mixtures[node].part(ground);
        for (label, part) in mixtures[node].shares().filter(|(label, _)| *label != ground && lack > 0.0) {
            held[dot * labels + usize::from(label)] += share.ink as f32 * part / lack;
        }
    }
    let (near, offsets) = near(shares, count);
    let stands = held.clone();
    let mut result = vec![None; count];
    let mut own = [0.0f32; MOST_LABELS];
    for dot in 0..count {
        let node = dots.nodes[dot] as usize;
        let (ground, ink) = (parts.grounds[node], inks[dot] as f32);
        let own = &mut own[..labels];
        own.copy_from_slice(&held[dot * labels..(dot + 1) * labels]);
        let row = &near[offsets[dot]..offsets[dot + 1]];
        let later = row.partition_point(|other| other.0 <= dot as u32);
        if 3 * later < row.len() {
            disturb(own, ground, ink, dot);
        }
        if parts.is_drawn(node, inks[dot]) {
            let stands = &stands[dot * labels..(dot + 1) * labels];
            let least = LEAST_SHARE * stands.iter().sum::<f32>();
            let mut best = None;
            for label in (0..labels).filter(|label| *label != usize::from(ground) && stands[*label] >= least) {
                if best.is_none_or(|best: usize| own[label] > own[best]) {
                    best = Some(label);
                }
            }
            if let Some(label) = best {
                result[dot] = Some(label as u8);
                own[label] -= ink;
            }
        }
        let total: f32 = row[later..].iter().map(|(_, weight)| weight).sum();
        for (other, weight) in &row[later..] {
            let held = &mut held[*other as usize * labels..(*other as usize + 1) * labels];
            held.iter_mut().zip(&*own).for_each(|(held, error)| *held += error * weight / total);
        }
    }
    result
}

/// Gives a dot errors as others before it might have handed them on: of the labels that it stands for.
fn disturb(own: &mut [f32], ground: u8, ink: f32, dot: usize) {
    let stands_for: Vec<usize> = (0..own.len()).filter(|label| own[*label] > 0.0 && *label != usize::from(ground)).collect();
    let errors: Vec<f32> = stands_for.iter().map(|label| 0.5 * ink * noise((*label as u64) << 32 | dot as u64)).collect();
    let mean = errors.iter().sum::<f32>() / errors.len().max(1) as f32;
    stands_for.iter().zip(&errors).for_each(|(label, error)| own[*label] += error - mean);
}

/// The dots that share nodes with every dot, in their order, each with how many they share, and where those of a dot begin.
fn near(shares: &[Vec<crate::labels::stipple::Share>], count: usize) -> (Vec<(u32, f32)>, Vec<usize>) {
    let of_chunk = |shares: &Vec<crate::labels::stipple::Share>| {
        let mut pairs = Vec::with_capacity(2 * shares.len());
        for group in shares.chunk_by(|a, b| a.node == b.node) {
            for a in group {
                pairs.extend(group.iter().filter(|b| b.dot != a.dot).map(|b| (a.dot, b.dot)));
            }
        }
        pairs
    };
    let mut pairs: Vec<(u32, u32)> = shares.par_iter().map(of_chunk).flatten_iter().collect();
    pairs.par_sort_unstable();
    let mut near = Vec::with_capacity(pairs.len() / 3);
    let mut offsets = vec![0; count + 1];
    for alike in pairs.chunk_by(|a, b| a == b) {
        near.push((alike[0].1, alike.len() as f32));
        offsets[alike[0].0 as usize + 1] = near.len();
    }
    for dot in 0..count {
        offsets[dot + 1] = offsets[dot + 1].max(offsets[dot]);
    }
    (near, offsets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Error;
    use crate::graph::{cells, triangulate};
    use crate::labels::{grounds, stipple};
    use crate::sites::relax;

    const SIZE: (usize, usize) = (60, 50);

    fn canvas(count: usize) -> (Triangulation, Vec<f64>) {
        let (width, height) = SIZE;
        let random = |k: usize| 0.5 + 0.499 * f64::from(noise(k as u64));
        let scattered = (0..count).map(|k| [random(2 * k) * width as f64, random(2 * k + 1) * height as f64]).collect();
        let mut sites = relax(scattered, width, height, 3, 2, &Control::new()).unwrap();
        sites.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let areas = cells(&sites, width, height, 2, None, &Control::new()).unwrap().areas;
        (triangulate(sites, width, height, &Control::new()).unwrap(), areas)
    }

    #[test]
    fn black_and_white_are_stippled_as_ever() {
        let (triangulation, areas) = canvas(900);
        let tones: Vec<f32> = triangulation.graph.sites.iter().map(|[x, _]| (x / 60.0) as f32).collect();
        let grounds = grounds(&triangulation.graph, &tones, 1.0).unwrap();
        let mixed: Vec<Mixture> = tones
            .iter()
            .map(|tone| match *tone < 0.5 {
                true => Mixture { labels: [0, 1, 0, 0], parts: [1.0 - tone, *tone, 0.0, 0.0] },
                false => Mixture { labels: [1, 0, 0, 0], parts: [*tone, 1.0 - tone, 0.0, 0.0] },
            })
            .collect();
        let labels = vec![0; tones.len()];
        let expected = stipple(&triangulation, &grounds, &tones, &areas, &labels, SIZE, &Control::new()).unwrap();
        let found = stipple_inks(&triangulation, &grounds, &mixed, &areas, &labels, SIZE, &Control::new()).unwrap();
        let other = expected.labels.iter().zip(&found.labels).filter(|(a, b)| a != b).count();
        assert!(other <= 2, "{other}");
    }

    #[test]
    fn dots_stand_apart_and_every_ink_has_its_part() {
        let (triangulation, areas) = canvas(4000);
        for parts in [[0.6, 0.2, 0.15, 0.05], [0.9, 0.06, 0.04, 0.0], [0.5, 0.25, 0.25, 0.0]] {
            let mixed = vec![Mixture { labels: [3, 5, 0, 1], parts }; areas.len()];
            let grounds = vec![3; areas.len()];
            let Stippled { labels, marks } =
                stipple_inks(&triangulation, &grounds, &mixed, &areas, &grounds, SIZE, &Control::new()).unwrap();
            for node in (0..labels.len()).filter(|node| labels[*node] != 3) {
                assert!(triangulation.graph.row(node).iter().all(|other| labels[*other as usize] == 3));
            }
            for (label, part) in mixed[0].shares().skip(1) {
                let own = (0..labels.len()).filter(|node| labels[*node] == label);
                let found = own.map(|node| marks.areas[node]).sum::<f64>() / areas.iter().sum::<f64>();
                assert!((found - f64::from(part)).abs() < 0.006, "{label}: {found} of {part}");
            }
        }
    }

    #[test]
    fn threads_do_not_matter_and_cancelling_ends_it() {
        let (triangulation, areas) = canvas(9000);
        let mixed = vec![Mixture { labels: [3, 5, 0, 1], parts: [0.6, 0.2, 0.15, 0.05] }; areas.len()];
        let grounds: Vec<u8> = (0..areas.len()).map(|node| if node % 1000 < 300 { NO_GROUND } else { 3 }).collect();
        let labels = vec![5; areas.len()];
        let run = |control: &Control| stipple_inks(&triangulation, &grounds, &mixed, &areas, &labels, SIZE, control);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&Control::new()).unwrap())
        });
        assert!(one == three);
        for node in (0..areas.len()).filter(|node| grounds[*node] == NO_GROUND) {
            assert!(one.labels[node] == 5 && one.marks.areas[node] == areas[node]);
        }
        let cancelled = Control::new();
        cancelled.cancel();
        assert!(matches!(run(&cancelled), Err(Error::Cancelled)));
    }
}
