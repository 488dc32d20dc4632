//! Where a disc does not fit beside the outline of an area: found edge by edge, so that areas are opened only near there.
//!
//! A point of an outline that opening by a disc leaves has that disc beside it: it touches the outline there, and nothing else of the
//! outline lies in it. So points along all edges are tried. What is too thin lies between points at which it fails.

use rayon::prelude::*;

use crate::base::{Ink, Result};
use crate::offset::{Polygon, intersection, united};
use crate::rules::boxes::{Bounds, Boxes};
use crate::rules::near::Near;

/// Points along an edge are no farther apart than this share of the radius: a thin part that is shorter is hardly any thinner.
const STEP: f64 = 0.25;

/// A disc may hold so many tolerances of an outline: flat corners are no places where it does not fit.
const HELD: f64 = 2.0;

/// How far around such points areas are looked at, in diameters of the disc: a disc that touches one reaches one of them, and a piece that is
/// cut out is wrong within one of where it was cut.
const AROUND: f64 = 2.3;

/// What is cut out to be opened is at most this share of all boxes; where it is more, all is opened.
const WORTH_CUTTING: f64 = 0.5;

/// Places on outlines beside which a disc does not fit.
pub(super) struct Suspects {
    /// Cells of a grid as wide as the disc, by rows.
    cells: Vec<[i32; 2]>,
    diameter: f64,
}

impl Suspects {
    /// Of black areas on a canvas of `size`, or of the white between them: beside the edges that come near one of the boxes, or
    /// beside all.
    pub(super) fn of(areas: &[Polygon], size: [f64; 2], ink: Ink, diameter: f64, tolerance: f64, within: Option<&Boxes>) -> Self {
        let near = Near::of(areas, size);
        let radius = 0.5 * diameter;
        let least = (radius - HELD * tolerance).max(0.5 * radius);
        let inwards = if ink == Ink::Black { 1.0 } else { -1.0 };
        let of_edge = |number: usize| -> Vec<[i32; 2]> {
            let [a, b] = near.edge(number);
            if within.is_some_and(|boxes| !boxes.meets(Bounds::of(&[a, b]))) {
                return Vec::new();
            }
            let along = [b[0] - a[0], b[1] - a[1]];
            let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
            if length == 0.0 {
                return Vec::new();
            }
            let steps = (length / (STEP * radius)).ceil().max(1.0);
            // What is inside lies on the left of an edge: x right, y down.
            let aside = [-along[1], along[0]].map(|v| v * inwards * radius / length);
            let mut found = Vec::new();
            for k in 0..steps as usize {
                let t = (k as f64 + 0.5) / steps;
                let p = [0, 1].map(|axis| a[axis] + t * along[axis]);
                if near.has_within([p[0] + aside[0], p[1] + aside[1]], least) {
                    let cell = p.map(|v| (v / diameter).floor() as i32);
                    let cell = [cell[1], cell[0]];
                    if found.last() != Some(&cell) {
                        found.push(cell);
                    }
                }
            }
            found
        };
        let found: Vec<Vec<[i32; 2]>> = (0..near.len()).into_par_iter().map(of_edge).collect();
        let mut cells: Vec<[i32; 2]> = found.into_iter().flatten().collect();
        cells.par_sort_unstable();
        cells.dedup();
        Self { cells, diameter }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The areas near these places.
    ///
    /// # Errors
    /// As [`united`].
    pub(super) fn cut_out(&self, areas: &[Polygon], size: [f64; 2]) -> Result<Vec<Polygon>> {
        let around = AROUND * self.diameter;
        let mut runs: Vec<Polygon> = Vec::new();
        let mut covered = 0.0;
        for row in self.cells.chunk_by(|a, b| a[0] == b[0]) {
            // Runs of cells that overlap once they are wider.
            for run in row.chunk_by(|a, b| f64::from(b[1] - a[1] - 1) * self.diameter <= 2.0 * around) {
                let [top, left] = run[0].map(|v| f64::from(v) * self.diameter);
                let right = f64::from(run[run.len() - 1][1] + 1) * self.diameter;
                let bounds = Bounds([left, top, right, top + self.diameter]).wider(around);
                covered += (right - left + 2.0 * around) * self.diameter;
                runs.push(bounds.area());
            }
        }
        if covered > WORTH_CUTTING * size[0] * size[1] {
            return Ok(areas.to_vec());
        }
        let zone = united(&runs)?;
        let boxes = Boxes::new(zone.iter().map(|area| Bounds::of(&area[0])).collect());
        let near: Vec<Polygon> = areas.iter().filter(|area| boxes.meets(Bounds::of(&area[0]))).cloned().collect();
        intersection(&near, &zone)
    }

    /// Whether an area comes to one of these places: what is found at the rim of what was cut out does not.
    pub(super) fn holds(&self, area: &Polygon) -> bool {
        area.iter().flatten().any(|p| {
            let [x, y] = p.map(|v| (v / self.diameter).floor() as i32);
            // Rounding may have moved it into the next cell.
            (-1..=1).any(|row| {
                let first = self.cells.partition_point(|cell| *cell < [y + row, x - 1]);
                self.cells.get(first).is_some_and(|cell| *cell <= [y + row, x + 1])
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::circle_polygon;

    fn square(left: f64, top: f64, side: f64) -> Vec<[f64; 2]> {
        vec![[left, top], [left + side, top], [left + side, top + side], [left, top + side]]
    }

    #[test]
    fn discs_do_not_fit_at_corners_in_necks_and_in_gaps() {
        let size = [100.0, 100.0];
        let suspects = |areas: &[Polygon], ink: Ink| Suspects::of(areas, size, ink, 1.0, 0.005, None);
        // A large circle has neither; a square has corners, from inside.
        let circle = [vec![circle_polygon([30.0, 30.0], 8.0, 0.002)]];
        assert!(suspects(&circle, Ink::Black).is_empty() && suspects(&circle, Ink::White).is_empty());
        let squares = [vec![square(10.0, 10.0, 10.0)], vec![square(20.7, 10.0, 10.0)]];
        let black = suspects(&squares, Ink::Black);
        assert!(black.cells.iter().all(|[y, x]| [9, 10, 19, 20].contains(y) && [9, 10, 19, 20, 21, 30].contains(x)), "{:?}", black.cells);
        let white = suspects(&squares, Ink::White);
        assert!(white.cells.iter().all(|[y, x]| (9..=20).contains(y) && [19, 20].contains(x)) && white.cells.len() >= 10);
        assert!(white.holds(&vec![square(20.0, 12.0, 0.7)]) && !white.holds(&vec![square(12.0, 12.0, 0.7)]));
        let cut = white.cut_out(&squares, size).unwrap();
        assert_eq!(cut.len(), 2);
        assert!(crate::offset::area(&cut) < 80.0);
    }
}
