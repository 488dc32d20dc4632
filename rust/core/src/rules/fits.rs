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

/// How far around such points areas are looked at, in diameters of the disc: a disc that touches one reaches one of them, and a piece that
/// is cut out is wrong within one of where it was cut.
const AROUND: f64 = 2.05;

/// What is cut out to be opened is at most this share of all boxes; where it is more, all is opened.
const WORTH_CUTTING: f64 = 0.5;

/// Points of areas to a strip, roughly: fewer are more strips, whose rims are looked at twice; more leave threads without work.
const POINTS_A_STRIP: usize = 20_000;

/// Cells so many rows above a strip and below it are looked at as its own: what is found there is theirs too.
const ROWS_BESIDE: i32 = 3;

/// Rows of cells in a strip at least, so that the surroundings of two others do not touch with one between them.
const LEAST_ROWS: i32 = 12;

/// What of areas is near some rows of cells.
pub(super) struct Strip {
    pub(super) areas: Vec<Polygon>,
    /// Top and bottom of where what is found is right; `None` where it is everywhere.
    pub(super) band: Option<[f64; 2]>,
}

/// The surroundings of some rows of cells.
struct Zone {
    /// Boxes that cover it.
    runs: Vec<Polygon>,
    /// Their area, roughly.
    covered: f64,
    /// Top and bottom of its own rows.
    rows: [f64; 2],
}

/// A disc that areas of an ink are opened by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    pub(super) ink: Ink,
    pub(super) diameter: f64,
    /// How far areas may lie from what they stand for.
    pub(super) tolerance: f64,
}

/// Places on outlines beside which a disc does not fit.
pub(super) struct Suspects {
    /// Cells of a grid as wide as the disc, by rows.
    cells: Vec<[i32; 2]>,
    diameter: f64,
}

impl Suspects {
    /// Of black areas on a canvas of `size`, or of the white between them: beside the edges that come near one of the boxes, or
    /// beside all.
    pub(super) fn of(areas: &[Polygon], size: [f64; 2], disc: Disc, within: Option<&Boxes>) -> Self {
        let Disc { ink, diameter, tolerance } = disc;
        let near = Near::of(areas, size);
        let radius = 0.5 * diameter;
        let least = (radius - HELD * tolerance).max(0.5 * radius);
        let inwards = ink.sign();
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

    /// The areas near these places, in strips that can be looked at one by one.
    ///
    /// # Errors
    /// As [`united`].
    pub(super) fn cut_out(&self, areas: &[Polygon], size: [f64; 2]) -> Result<Vec<Strip>> {
        let points: usize = areas.iter().flatten().map(Vec::len).sum();
        let count = (points / POINTS_A_STRIP).clamp(1, self.cells.len().max(1));
        let mut strips: Vec<Zone> = Vec::new();
        let mut rest = &self.cells[..];
        while let [first, ..] = rest {
            // As many cells in each, and no row in two; those of every other strip do not touch.
            let end = rest[(self.cells.len().div_ceil(count) - 1).min(rest.len() - 1)][0].max(first[0] + LEAST_ROWS);
            strips.push(self.zone([first[0], end]));
            rest = &rest[rest.partition_point(|cell| cell[0] <= end)..];
        }
        let covered: f64 = strips.iter().map(|strip| strip.covered).sum();
        if strips.len() <= 1 && covered > WORTH_CUTTING * size[0] * size[1] {
            return Ok(vec![Strip { areas: areas.to_vec(), band: None }]);
        }
        let (even, odd): (Vec<_>, Vec<_>) = strips.into_iter().enumerate().partition(|(number, _)| number % 2 == 0);
        let cut = |strips: Vec<(usize, Zone)>| self.cut(areas, strips);
        let (even, odd) = rayon::join(|| cut(even), || cut(odd));
        let mut cut = even?;
        cut.extend(odd?);
        cut.sort_by_key(|(number, _)| *number);
        let is_one = cut.len() == 1;
        Ok(cut.into_iter().map(|(_, strip)| if is_one { Strip { band: None, ..strip } } else { strip }).collect())
    }

    /// The surroundings of the cells in these rows and beside them.
    fn zone(&self, [first, last]: [i32; 2]) -> Zone {
        let before = |row: i32| self.cells.partition_point(|cell| cell[0] < row);
        let cells = &self.cells[before(first - ROWS_BESIDE)..before(last + 1 + ROWS_BESIDE)];
        let around = AROUND * self.diameter;
        let mut runs: Vec<Polygon> = Vec::new();
        let mut covered = 0.0;
        for row in cells.chunk_by(|a, b| a[0] == b[0]) {
            // Runs of cells that overlap once they are wider.
            for run in row.chunk_by(|a, b| f64::from(b[1] - a[1] - 1) * self.diameter <= 2.0 * around) {
                let [top, left] = run[0].map(|v| f64::from(v) * self.diameter);
                let right = f64::from(run[run.len() - 1][1] + 1) * self.diameter;
                let bounds = Bounds([left, top, right, top + self.diameter]).wider(around);
                covered += (right - left + 2.0 * around) * self.diameter;
                runs.push(bounds.area());
            }
        }
        let rows = [first, last + 1].map(|row| f64::from(row) * self.diameter);
        Zone { runs, covered, rows }
    }

    /// What of areas lies in zones that do not touch, from the top down.
    fn cut(&self, areas: &[Polygon], zones: Vec<(usize, Zone)>) -> Result<Vec<(usize, Strip)>> {
        let runs: Vec<Polygon> = zones.iter().flat_map(|(_, zone)| zone.runs.iter().cloned()).collect();
        let zone = united(&runs)?;
        let boxes = Boxes::new(zone.iter().map(|area| Bounds::of(&area[0])).collect());
        let near: Vec<Polygon> = areas.iter().filter(|area| boxes.meets(Bounds::of(&area[0]))).cloned().collect();
        // Between two zones lie the rows of a strip that is not among these.
        let ends: Vec<f64> = zones.windows(2).map(|pair| 0.5 * (pair[0].1.rows[1] + pair[1].1.rows[0])).collect();
        let mut strips: Vec<(usize, Strip)> = zones
            .into_iter()
            .map(|(number, Zone { rows: [top, bottom], .. })| {
                let band = Some([top - self.diameter, bottom + self.diameter]);
                (number, Strip { areas: Vec::new(), band })
            })
            .collect();
        for area in intersection(&near, &zone)? {
            let place = ends.partition_point(|end| *end < area[0][0][1]);
            strips[place].1.areas.push(area);
        }
        Ok(strips)
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
        let suspects = |areas: &[Polygon], ink: Ink| Suspects::of(areas, size, Disc { ink, diameter: 1.0, tolerance: 0.005 }, None);
        // A large circle has neither; a square has corners, from inside.
        let circle = [vec![circle_polygon([30.0, 30.0], 8.0, 0.002)]];
        assert!(suspects(&circle, Ink::BLACK).is_empty() && suspects(&circle, Ink::WHITE).is_empty());
        let squares = [vec![square(10.0, 10.0, 10.0)], vec![square(20.7, 10.0, 10.0)]];
        let black = suspects(&squares, Ink::BLACK);
        assert!(
            black.cells.iter().all(|[y, x]| [9, 10, 19, 20].contains(y) && [9, 10, 19, 20, 21, 30].contains(x)),
            "{:?}",
            black.cells
        );
        let white = suspects(&squares, Ink::WHITE);
        assert!(white.cells.iter().all(|[y, x]| (9..=20).contains(y) && [19, 20].contains(x)) && white.cells.len() >= 10);
        assert!(white.holds(&vec![square(20.0, 12.0, 0.7)]) && !white.holds(&vec![square(12.0, 12.0, 0.7)]));
        let cut = white.cut_out(&squares, size).unwrap();
        assert!(cut.len() == 1 && cut[0].band.is_none());
        assert_eq!(cut[0].areas.len(), 2);
        assert!(crate::offset::area(&cut[0].areas) < 80.0);
    }
}
