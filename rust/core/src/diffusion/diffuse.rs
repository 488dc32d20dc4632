//! The diffusion of values over a graph, in either order.

use crate::base::{Control, Result};
use crate::diffusion::parameters::Diffusion;
use crate::diffusion::rows::band_size;
use crate::diffusion::task::Task;
use crate::graph::{Adjacency, check_areas, check_finite, check_one_a_node};
use crate::options::Order;

/// A label for every node: 0 black, 1 white. With `areas`, the areas of the nodes' cells in px^2, errors are weighted by area
/// ([`crate::stages::ErrorWeighting`]).
///
/// # Errors
/// [`crate::Error::Input`] if there is not one finite value, and one area of at least 0, a node; [`crate::Error::Cancelled`].
///
/// # Runtime
/// `n log n` at worst, for values that are all nearly the same; close to linear on photos.
pub fn diffuse(
    graph: &impl Adjacency,
    values: &[f32],
    areas: Option<&[f64]>,
    parameters: &Diffusion,
    control: &Control,
) -> Result<Vec<u8>> {
    check_input(graph, values, areas)?;
    let task = Task { graph, values, areas, parameters, control };
    match parameters.order {
        Order::Global => task.by_priority(),
        Order::Rows => task.by_number(band_size(values.len())),
    }
}

/// # Errors
/// [`crate::Error::Input`] if there is not one finite value, and one area of at least 0, a node.
pub(crate) fn check_input(graph: &impl Adjacency, values: &[f32], areas: Option<&[f64]>) -> Result<()> {
    check_one_a_node("values", values.len(), graph.len())?;
    check_finite("value", values)?;
    if let Some(areas) = areas {
        check_one_a_node("areas", areas.len(), graph.len())?;
        check_areas("area", areas)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Error, noise};
    use crate::diffusion::parameters::tonal_share;
    use crate::diffusion::task::UNLABELLED;
    use crate::diffusion::weights::{MOST_AREA_RATIO, area_ratio, exp};
    use crate::graph::{Graph, Lattice};
    use crate::options::{Alpha, LatticeKind, Options};
    use proptest::prelude::*;

    /// The definition, read literally: look for the next node among all, every time.
    fn oracle(graph: &Graph, values: &[f32], areas: Option<&[f64]>, p: &Diffusion) -> Vec<u8> {
        let mut current: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let mut labels = vec![UNLABELLED; values.len()];
        for _ in 0..values.len() {
            let mut next = None;
            for (i, value) in current.iter().enumerate() {
                let precedes = |n: usize| p.order == Order::Global && (value - 0.5).abs() > (current[n] - 0.5).abs();
                if labels[i] == UNLABELLED && next.is_none_or(precedes) {
                    next = Some(i);
                }
            }
            let i = next.unwrap();
            let start = f64::from(values[i]);
            let row: Vec<usize> = graph.row(i).iter().map(|j| *j as usize).collect();
            let mean = row.iter().fold(start, |sum, j| sum + f64::from(values[*j])) / (row.len() + 1) as f64;
            let alpha = match p.alpha {
                Alpha::Constant(alpha) => alpha,
                Alpha::Dynamic => p.base + p.detail_gain * (start - mean).abs(),
                Alpha::Tonal => p.shading * tonal_share(start),
            };
            if p.order == Order::Rows && 3 * row.iter().filter(|j| **j < i).count() < row.len() {
                current[i] += 0.5 * f64::from(noise(i as u64)) * alpha;
            }
            let label = u8::from(current[i] >= 0.5);
            labels[i] = label;
            let error = current[i] - f64::from(label);
            let alpha = if p.alpha != Alpha::Dynamic || (label == 1) == (start >= 0.5) { alpha } else { 0.0 };
            let open: Vec<usize> = row.into_iter().filter(|j| labels[*j] == UNLABELLED).collect();
            let exponent = |j: &usize| {
                let d = crate::graph::distance_squared(graph.sites[i], graph.sites[*j]).sqrt();
                -(p.k1 * (start - f64::from(values[*j])).abs() + p.k2 * d).powi(2)
            };
            let largest = open.iter().map(exponent).fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = open.iter().map(|j| exp(exponent(j) - largest)).collect();
            let total: f64 = weights.iter().sum();
            for (j, w) in open.iter().zip(&weights) {
                current[*j] += w * (alpha * error / total) * areas.map_or(1.0, |a| (a[i] / a[*j]).min(16.0));
            }
        }
        labels
    }

    proptest! {
        #[test]
        fn labels_equal_the_definition_where_values_tie(
            width in 1usize..14, height in 1usize..14, square in any::<bool>(),
            alpha in prop_oneof![Just(Alpha::Dynamic), Just(Alpha::Tonal), (0.0f64..=1.0).prop_map(Alpha::Constant)],
            order in prop_oneof![Just(Order::Rows), Just(Order::Global)], by_area in any::<bool>(),
            seed in prop::collection::vec(0.0f32..1.0, 600),
        ) {
            let kind = if square { LatticeKind::Square } else { LatticeKind::Hexagonal };
            let graph = Lattice::new(kind, width, height, 1.5).unwrap().to_graph();
            // Eighths make many exact ties, at 0 and 1 too.
            let values: Vec<f32> = (0..graph.sites.len()).map(|i| (seed[i] * 9.0).floor() / 8.0).collect();
            let cells: Vec<f64> = values.iter().rev().map(|v| 0.01 + f64::from(*v)).collect();
            let areas = by_area.then_some(&cells[..]);
            let p = Diffusion { alpha, order, ..Diffusion::of_tone(&Options::default()) };
            prop_assert_eq!(diffuse(&graph, &values, areas, &p, &Control::new()).unwrap(), oracle(&graph, &values, areas, &p));
        }
    }

    /// A flat grey with a little noise, which keeps the order of ties from making patterns.
    fn grey(lattice: &Lattice, value: f32) -> Vec<f32> {
        (0..lattice.len()).map(|i| value + 0.02 * crate::base::noise(i as u64)).collect()
    }

    fn of_order(order: Order) -> Diffusion {
        Diffusion { alpha: Alpha::Constant(1.0), order, ..Diffusion::of_tone(&Options::default()) }
    }

    #[test]
    fn bands_are_of_a_size_that_depends_on_the_number_of_nodes_alone() {
        assert_eq!([0, 1, 16_255, 16_256, 1 << 20].map(band_size), [1, 1, 16_255, 8128, 1 << 16]);
        assert!(diffuse(&Graph::default(), &[], None, &of_order(Order::Rows), &Control::new()).unwrap().is_empty());
    }

    fn by_number(lattice: &Lattice, values: &[f32], size: usize) -> Vec<u8> {
        let (parameters, control) = (of_order(Order::Rows), Control::new());
        Task { graph: lattice, values, areas: None, parameters: &parameters, control: &control }.by_number(size).unwrap()
    }

    #[test]
    fn labels_do_not_depend_on_the_threads() {
        let lattice = Lattice::new(LatticeKind::Square, 150, 150, 1.0).unwrap();
        let values = grey(&lattice, 0.4);
        // Bands of 11 rows, of parts of rows, and of less than a row.
        for size in [1650, 1000, 64, 1] {
            let [one, two, five] = [1, 2, 5].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| by_number(&lattice, &values, size))
            });
            assert!(one == two && two == five && one.iter().all(|label| *label < UNLABELLED), "{size}");
        }
    }

    #[test]
    fn bands_do_not_show_in_a_flat_grey() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 200, 1600, 1.0).unwrap();
        let values = grey(&lattice, 0.3);
        let columns = lattice.nodes_in_two_rows() / 2;
        let labels = by_number(&lattice, &values, 64 * columns);
        let sum = |labels: &[u8]| labels.iter().map(|label| f64::from(*label)).sum::<f64>();
        let wanted: f64 = values.iter().map(|value| f64::from(*value)).sum();
        assert!((sum(&labels) - wanted).abs() < 0.003 * wanted, "{} of {wanted}", sum(&labels));
        let rows: Vec<f64> = labels.chunks_exact(columns).map(|row| sum(row) / columns as f64).collect();
        // The rows at this distance from a seam, all seams together; labels drawn at random would scatter by 0.007.
        let seams = rows.len() / 64 - 1;
        for distance in 0..8 {
            let at_seams = (1..=seams).map(|band| rows[64 * band + distance - 4]).sum::<f64>() / seams as f64;
            assert!((at_seams - 0.3).abs() < 0.02, "{distance}: {at_seams}");
        }
    }

    #[test]
    fn a_cancelled_diffusion_ends() {
        let lattice = Lattice::new(LatticeKind::Square, 200, 200, 1.0).unwrap();
        let control = Control::new();
        control.cancel();
        for order in [Order::Rows, Order::Global] {
            let ended = diffuse(&lattice, &grey(&lattice, 0.3), None, &of_order(order), &control);
            assert!(matches!(ended, Err(Error::Cancelled)));
        }
    }

    #[test]
    fn errors_weighted_by_area_keep_the_tone_where_small_cells_meet_large_ones() {
        // A node of 1 px^2 and its only neighbour of 4: what the first makes too light darkens the second by a quarter of it.
        let graph = Graph::from_edges(vec![[0.0, 0.0], [1.0, 0.0]], &[[0, 1]]).unwrap();
        let p = of_order(Order::Global);
        let label = |areas| diffuse(&graph, &[0.7, 0.6], areas, &p, &Control::new()).unwrap();
        assert_eq!(label(None), [1, 0]);
        assert_eq!(label(Some(&[1.0, 4.0][..])), [1, 1]);
        assert_eq!(area_ratio(0.0, 0.0), 1.0);
        assert_eq!(area_ratio(1.0, 0.0), MOST_AREA_RATIO);
        assert!(diffuse(&graph, &[0.7, 0.6], Some(&[1.0]), &p, &Control::new()).is_err());
        assert!(diffuse(&graph, &[0.7, 0.6], Some(&[1.0, -1.0]), &p, &Control::new()).is_err());
    }

    #[test]
    fn nodes_hundreds_of_pixels_apart_still_pass_their_error_on() {
        let graph = Graph::from_edges(vec![[0.0, 0.0], [900.0, 0.0], [0.0, 901.0]], &[[0, 1], [0, 2]]).unwrap();
        let p = of_order(Order::Global);
        let labels = diffuse(&graph, &[0.95, 0.52, 0.52], None, &p, &Control::new()).unwrap();
        // Node 0 takes 0.05 from its neighbours' white: the nearer one falls below 0.5.
        assert_eq!(labels, [1, 0, 1]);
    }
}
