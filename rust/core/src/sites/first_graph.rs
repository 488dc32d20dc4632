//! The first graph: a lattice over the canvas, and which of its nodes the importance keeps.

use std::collections::BTreeSet;

use crate::base::{Control, Result};
use crate::diffusion::Diffusion;
use crate::graph::{Adjacency, Lattice, distance_squared, lattice_means, samples_per_pixel};
use crate::options::{Alpha, Options};
use crate::photo::Field;
use crate::sites::budget::meet;
use crate::sites::scan::diffuse_lattice;

/// The first graph and which of its nodes are kept.
#[derive(Debug, Clone)]
pub struct FirstGraph {
    /// The lattice.
    pub lattice: Lattice,
    /// 1 for every node that is kept.
    pub labels: Vec<u8>,
    /// The factor on the importance that meets the node budget; 1 without one.
    pub factor: f64,
}

/// The first phase alone: the lattice, and the nodes that the importance keeps under the node budget.
///
/// # Errors
/// [`crate::Error::Option`] for an option out of range, [`crate::Error::Input`] for a budget that cannot be met,
/// [`crate::Error::Cancelled`].
pub fn first_graph(importance: &Field, options: &Options, control: &Control) -> Result<FirstGraph> {
    let budget = options.budget((importance.width() * importance.height()) as f64);
    let (lattice, values) = lattice_values(importance, budget.density, options, control)?;
    keep(lattice, &values, budget.nodes, options, control)
}

/// The nodes that the second graph starts from: those kept, and the nodes nearest to the corners of the canvas where those
/// kept are fewer than three or in one line.
pub fn kept_sites(first: &FirstGraph, width: f64, height: f64) -> Vec<[f64; 2]> {
    let kept = first.labels.iter().enumerate().filter(|(_, label)| **label == 1).map(|(node, _)| node);
    let site = |node: usize| first.lattice.site(node);
    if all_in_line(kept.clone().map(site)) {
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
        let with_corners: BTreeSet<usize> = kept.chain(corners.map(|[x, y]| first.lattice.nearest(x, y))).collect();
        return with_corners.into_iter().map(site).collect();
    }
    let mut sites = Vec::with_capacity(kept.clone().count());
    sites.extend(kept.map(site));
    sites
}

fn all_in_line(mut sites: impl Iterator<Item = [f64; 2]>) -> bool {
    let (Some(a), Some(b)) = (sites.next(), sites.next()) else {
        return true;
    };
    let length = distance_squared(a, b);
    // Twice the area of the triangle with the first two, against the square of their distance: rounding stays far below.
    !sites.any(|c| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() > 1e-9 * length)
}

pub(crate) fn lattice_values(
    importance: &Field,
    density: f64,
    options: &Options,
    control: &Control,
) -> Result<(Lattice, Vec<f32>)> {
    let lattice = Lattice::new(options.published.lattice, importance.width(), importance.height(), density)?;
    let values = lattice_means(&lattice, importance, samples_per_pixel(density), control)?;
    Ok((lattice, values))
}

pub(crate) fn keep(
    lattice: Lattice,
    values: &[f32],
    nodes: Option<f64>,
    options: &Options,
    control: &Control,
) -> Result<FirstGraph> {
    let mut parameters = Diffusion::of_importance(options);
    // What drops errors follows detail, and a flat importance has none: it would keep all nodes or hardly any.
    if values.iter().all(|v| *v == values[0]) && !matches!(parameters.alpha, Alpha::Constant(_)) {
        parameters.alpha = Alpha::Constant(1.0);
    }
    let (labels, factor) = match nodes {
        None => (diffuse_lattice(&lattice, values, &parameters, control)?, 1.0),
        Some(nodes) => meet(&lattice, values, nodes, &parameters, control)?,
    };
    debug_assert_eq!(labels.len(), lattice.len());
    Ok(FirstGraph { lattice, labels, factor })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Adjacency;
    use crate::options::LatticeKind;

    #[test]
    fn nodes_in_line_are_given_the_corners() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 40, 30, 0.5).unwrap();
        let corners = [[0.0, 0.0], [40.0, 0.0], [0.0, 30.0], [40.0, 30.0]].map(|[x, y]| lattice.nearest(x, y));
        let of = |kept: &[usize]| {
            let labels = (0..lattice.len()).map(|node| u8::from(kept.contains(&node))).collect();
            kept_sites(&FirstGraph { lattice: lattice.clone(), labels, factor: 1.0 }, 40.0, 30.0)
        };
        let row: Vec<usize> = lattice.row(5).collect();
        for line in [&[][..], &row[3..4], &row[3..5], &row] {
            let sites = of(line);
            assert_eq!(sites.len(), line.len() + 4);
            assert!(line.iter().chain(&corners).all(|node| sites.contains(&lattice.site(*node))));
        }
        let beside = lattice.row(6).start;
        assert_eq!(of(&[row[3], row[5], beside]).len(), 3);
    }

    #[test]
    fn a_flat_importance_keeps_its_share_though_errors_follow_detail() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 60, 60, 1.0).unwrap();
        let count = lattice.len() as f64;
        for value in [0.2, 0.8] {
            let values = vec![value; lattice.len()];
            let FirstGraph { labels, .. } = keep(lattice.clone(), &values, None, &Options::paper(), &Control::new()).unwrap();
            let share = labels.iter().map(|label| f64::from(*label)).sum::<f64>() / count;
            assert!((share - f64::from(value)).abs() < 0.06, "{value}: {share}");
        }
    }
}
