//! Lloyd steps: sites move to the middles of their cells.
//!
//! Source: the paper (relaxation).

use crate::base::{Control, Result};
use crate::graph::{FRAME_MARGIN, Samples, centroid_of, check_sampling};

/// Lloyd relaxation: `steps` times, every site moves to the centroid of its cell (0.001 px inside the frame at least).
///
/// # Errors
/// As [`cells`](crate::stages::cells).
pub fn relax(
    mut sites: Vec<[f64; 2]>,
    width: usize,
    height: usize,
    steps: u32,
    samples_per_pixel: usize,
    control: &Control,
) -> Result<Vec<[f64; 2]>> {
    let limits = [width as f64 - FRAME_MARGIN, height as f64 - FRAME_MARGIN];
    for step in 0..steps {
        control.report(step as f32 / steps as f32)?;
        check_sampling(&sites, width, height, samples_per_pixel, &[])?;
        let mut sums = vec![(0u32, [0u64; 2]); sites.len()];
        let canvas = Samples { sites: &sites, width, height, per_pixel: samples_per_pixel };
        canvas.add_up([], control, |site, part| {
            let (count, [columns, rows]) = &mut sums[site as usize];
            *count += part.count;
            *columns += part.columns;
            *rows += part.rows;
        })?;
        for (site, (count, [columns, rows])) in sites.iter_mut().zip(sums) {
            let [x, y] = centroid_of([columns, rows], count, *site, samples_per_pixel);
            *site = [x.clamp(FRAME_MARGIN, limits[0]), y.clamp(FRAME_MARGIN, limits[1])];
        }
    }
    Ok(sites)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Lattice, cells};
    use crate::options::LatticeKind;

    #[test]
    fn sites_come_to_the_middle_of_a_canvas_that_is_far_from_square() {
        for (width, height) in [(6, 40), (40, 6)] {
            let [x, y] = relax(vec![[1.0, 1.0]], width, height, 1, 2, &Control::new()).unwrap()[0];
            assert_eq!([x, y], [width as f64 / 2.0, height as f64 / 2.0]);
        }
    }

    #[test]
    fn relaxation_stays_inside_and_keeps_a_regular_graph_nearly_still() {
        let lattice = Lattice::new(LatticeKind::Square, 20, 20, 1.0).unwrap();
        let relaxed = relax(lattice.sites(), 20, 20, 3, 4, &Control::new()).unwrap();
        for (a, b) in relaxed.iter().zip(lattice.sites()) {
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
        }
        assert!(relax(vec![[30.0, 1.0]], 20, 20, 1, 1, &Control::new()).is_err());
        assert!(cells(&[], 4, 4, 1, None, &Control::new()).is_err());
    }
}
