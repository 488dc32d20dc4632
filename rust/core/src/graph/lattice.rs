//! The lattice: the regular first graph, whose adjacency is known in closed form, as in the paper.
//!
//! Nodes are numbered row by row. On the hexagonal lattice every other row is shifted by half the spacing; a node has six
//! neighbours, all one spacing away. On the square lattice it has four. A canvas too narrow for either holds one line of nodes.
//! Nothing is triangulated here, and positions and neighbours are computed, not stored.

use std::ops::Range;

use crate::base::{Error, Result};
use crate::graph::graph::{Adjacency, FRAME_MARGIN, Graph};
use crate::options::LatticeKind;
use crate::photo::check_size;

/// The most nodes that a lattice may have: node numbers and adjacency offsets (six a node) stay within 32 bits.
const MAX_NODES: f64 = 500e6;

/// A regular graph over the canvas.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    rows: usize,
    /// Nodes in an even and in an odd row.
    columns: [usize; 2],
    /// x of the first node of an even and of an odd row.
    first_x: [f64; 2],
    first_y: f64,
    /// Distance of nodes in a row.
    spacing: f64,
    /// Distance of rows.
    pitch: f64,
    /// Columns, relative to a node's own, of its two neighbours in the rows above and below, for a node in an even and in an odd
    /// row. Both are the same where rows are not shifted.
    across: [[isize; 2]; 2],
    across_distance: f64,
}

impl Lattice {
    /// A lattice of `density` nodes per pixel over a canvas of `width` x `height` pixels; at least one node.
    ///
    /// # Errors
    /// [`Error::Input`] if a side of the canvas is out of range or the lattice would have more than 500 million nodes;
    /// [`Error::Option`] if the density is not above 0.
    pub fn new(kind: LatticeKind, width: usize, height: usize, density: f64) -> Result<Self> {
        check_size(width, height)?;
        if !(density > 0.0 && density.is_finite()) {
            return Err(Error::option("density", density, "above 0 nodes per pixel"));
        }
        let (w, h) = (width as f64, height as f64);
        if density * w * h > MAX_NODES {
            return Err(Error::Input(format!(
                "density {density} on {width} x {height} pixels makes {:.0} lattice nodes, but at most {MAX_NODES:.0} are possible",
                density * w * h
            )));
        }
        let count = |first: f64, step: f64, length: f64| {
            let room = (length - FRAME_MARGIN - first) / step;
            if room < 0.0 { 0 } else { room as usize + 1 }
        };
        let (spacing, pitch) = match kind {
            LatticeKind::Hexagonal => {
                let spacing = (2.0 / (3f64.sqrt() * density)).sqrt();
                (spacing, spacing * 3f64.sqrt() / 2.0)
            }
            LatticeKind::Square => (1.0 / density.sqrt(), 1.0 / density.sqrt()),
        };
        // One line of nodes along the middle, as dense per area, where not even one row or two shifted columns fit.
        if h < pitch || w < spacing {
            let (short, long) = (w.min(h), w.max(h));
            let nodes = (density * short * long).round().max(1.0);
            let step = long / nodes;
            let nodes = nodes as usize;
            let line = |rows, columns, first_x, first_y| Self {
                rows,
                columns: [columns; 2],
                first_x: [first_x; 2],
                first_y,
                spacing: step,
                pitch: step,
                across: [[0, 0]; 2],
                across_distance: step,
            };
            return Ok(if w >= h { line(1, nodes, step / 2.0, h / 2.0) } else { line(nodes, 1, w / 2.0, step / 2.0) });
        }
        let first_y = pitch / 2.0;
        let rows = count(first_y, pitch, h);
        let (first_x, across) = match kind {
            LatticeKind::Hexagonal => ([spacing / 4.0, spacing * 0.75], [[-1, 0], [0, 1]]),
            LatticeKind::Square => ([spacing / 2.0; 2], [[0, 0]; 2]),
        };
        Ok(Self {
            rows,
            columns: first_x.map(|x| count(x, spacing, w)),
            first_x,
            first_y,
            spacing,
            pitch,
            across,
            across_distance: spacing,
        })
    }

    /// The position of a node: x, y in pixels.
    pub fn site(&self, node: usize) -> [f64; 2] {
        let (row, column) = self.row_and_column(node);
        [self.first_x[row % 2] + column as f64 * self.spacing, self.first_y + row as f64 * self.pitch]
    }

    /// The positions of all nodes, row by row.
    pub fn sites(&self) -> Vec<[f64; 2]> {
        (0..self.len()).map(|node| self.site(node)).collect()
    }

    /// The lattice as stored sites and adjacency.
    pub fn to_graph(&self) -> Graph {
        let mut graph = Graph { sites: self.sites(), offsets: vec![0], neighbors: Vec::new() };
        for node in 0..self.len() {
            self.for_each_neighbor(node, |neighbor, _| graph.neighbors.push(neighbor as u32));
            graph.offsets.push(graph.neighbors.len() as u32);
        }
        graph
    }

    /// The number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// The numbers of the nodes of a row, from left to right.
    pub(crate) fn row(&self, row: usize) -> Range<usize> {
        let start = self.row_start(row);
        start..start + self.columns[row % 2]
    }

    /// Distances of neighbours in a row, and in rows next to each other.
    pub(crate) fn distances(&self) -> [f64; 2] {
        [self.spacing, self.across_distance]
    }

    /// The first and the last of the columns, relative to a node's own, of its neighbours in the next row and the one before.
    pub(crate) fn columns_beside(&self, row: usize) -> [isize; 2] {
        self.across[row % 2]
    }

    /// Number of the first node of a row.
    fn row_start(&self, row: usize) -> usize {
        (row / 2) * (self.columns[0] + self.columns[1]) + (row % 2) * self.columns[0]
    }

    fn row_and_column(&self, node: usize) -> (usize, usize) {
        // 32-bit division is several times as fast, and this is the innermost loop of the first diffusion.
        let pair = (self.columns[0] + self.columns[1]) as u32;
        let (rows, within) = ((node as u32 / pair * 2) as usize, (node as u32 % pair) as usize);
        if within < self.columns[0] { (rows, within) } else { (rows + 1, within - self.columns[0]) }
    }

    /// The two rows between which y lies (the nearest node is in one of them), each with its squared distance from y.
    pub(crate) fn rows_around(&self, y: f64) -> [LatticeRow; 2] {
        let above = ((y - self.first_y) / self.pitch).clamp(0.0, self.rows.saturating_sub(2) as f64) as usize;
        [above, (above + 1).min(self.rows - 1)].map(|row| {
            let dy = y - (self.first_y + row as f64 * self.pitch);
            LatticeRow { start: self.row_start(row), columns: self.columns[row % 2], parity: row % 2, dy_squared: dy * dy }
        })
    }

    /// The column of the node of an even (0) or odd (1) row that is nearest to x, and its squared distance along the row.
    pub(crate) fn nearest_column(&self, parity: usize, x: f64) -> (u32, f64) {
        // A cast cuts off the fraction, and what is below 0 becomes 0.
        let (first_x, per_spacing) = (self.first_x[parity], 1.0 / self.spacing);
        let column = (((x - first_x) * per_spacing + 0.5) as usize).min(self.columns[parity] - 1);
        let dx = x - (first_x + column as f64 * self.spacing);
        (column as u32, dx * dx)
    }

    /// Nodes in an even and an odd row together.
    pub(crate) fn nodes_in_two_rows(&self) -> usize {
        self.columns[0] + self.columns[1]
    }

    /// The node nearest to the point (x, y) of the canvas; one of them on ties.
    pub fn nearest(&self, x: f64, y: f64) -> usize {
        let [above, below] = self.rows_around(y).map(|row| {
            let (column, along) = self.nearest_column(row.parity, x);
            (row.start + column as usize, along + row.dy_squared)
        });
        if below.1 < above.1 { below.0 } else { above.0 }
    }
}

/// One row of a lattice, seen from points at one height.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LatticeRow {
    start: usize,
    columns: usize,
    parity: usize,
    dy_squared: f64,
}

impl LatticeRow {
    /// The row's first node.
    pub(crate) fn start(&self) -> usize {
        self.start
    }

    /// The node behind the row's last.
    pub(crate) fn end(&self) -> usize {
        self.start + self.columns
    }

    /// 0 for an even row, 1 for an odd one.
    pub(crate) fn parity(&self) -> usize {
        self.parity
    }

    /// The squared distance across the rows.
    pub(crate) fn dy_squared(&self) -> f64 {
        self.dy_squared
    }
}

impl Adjacency for Lattice {
    fn len(&self) -> usize {
        self.row_start(self.rows)
    }

    #[inline]
    fn for_each_neighbor(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
        let (row, column) = self.row_and_column(node);
        let [left, right] = self.across[row % 2];
        let (own_columns, other_columns) = (self.columns[row % 2], self.columns[(row + 1) % 2]);
        // Away from the frame of a hexagonal lattice, which is nearly everywhere, there is nothing to clamp.
        let inner = row > 0 && row + 1 < self.rows && column > 0 && column + 1 < own_columns.min(other_columns);
        if left != right && inner {
            let above = (node - other_columns).wrapping_add_signed(left);
            let below = (node + own_columns).wrapping_add_signed(left);
            visit(above, self.across_distance);
            visit(above + 1, self.across_distance);
            visit(node - 1, self.spacing);
            visit(node + 1, self.spacing);
            visit(below, self.across_distance);
            visit(below + 1, self.across_distance);
            return;
        }
        // The neighbours in a row above or below: one, or two beside each other.
        let across = |row: usize| {
            let columns = self.columns[row % 2] as isize;
            let begin = (column as isize + left).clamp(0, columns);
            let end = (column as isize + right + 1).clamp(0, columns);
            let start = self.row_start(row);
            start + begin as usize..start + end as usize
        };
        if row > 0 {
            for neighbor in across(row - 1) {
                visit(neighbor, self.across_distance);
            }
        }
        if column > 0 {
            visit(node - 1, self.spacing);
        }
        if column + 1 < own_columns {
            visit(node + 1, self.spacing);
        }
        if row + 1 < self.rows {
            for neighbor in across(row + 1) {
                visit(neighbor, self.across_distance);
            }
        }
    }

    /// A hexagon, or a square on its corner, cut off at the frame: no way within so many hops has to leave it.
    fn for_each_run_within(&self, node: usize, hops: usize, mut visit: impl FnMut(Range<usize>)) -> bool {
        let (row, column) = self.row_and_column(node);
        let (own, both) = (self.across[row % 2], [0, 1].map(|side| self.across[0][side] + self.across[1][side]));
        for other in row.saturating_sub(hops)..(row + hops + 1).min(self.rows) {
            let steps = row.abs_diff(other);
            // As far as the steps across the rows reach, and the hops that are left along the row.
            let [left, right] = [0, 1].map(|side| (steps / 2) as isize * both[side] + (steps % 2) as isize * own[side]);
            let (along, columns) = ((hops - steps) as isize, self.columns[other % 2] as isize);
            let begin = (column as isize + left - along).clamp(0, columns);
            let end = (column as isize + right + along + 1).clamp(0, columns);
            let start = self.row_start(other);
            visit(start + begin as usize..start + end as usize);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::graph::distance_squared;
    use proptest::prelude::*;

    fn any_lattice() -> impl Strategy<Value = (Lattice, usize, usize, f64)> {
        (any::<bool>(), 1usize..40, 1usize..40, 0.01f64..4.0).prop_map(|(square, width, height, density)| {
            let kind = if square { LatticeKind::Square } else { LatticeKind::Hexagonal };
            (Lattice::new(kind, width, height, density).unwrap(), width, height, density)
        })
    }

    proptest! {
        #[test]
        fn sites_lie_inside_and_number_as_the_density_says((lattice, width, height, density) in any_lattice()) {
            let (w, h) = (width as f64, height as f64);
            for [x, y] in lattice.sites() {
                prop_assert!(x > 0.0 && x < w && y > 0.0 && y < h);
            }
            let expected = density * w * h;
            // A row and a column more or less at the border.
            let slack = 1.0 + (w + h) * density.sqrt() * 1.2;
            prop_assert!((lattice.len() as f64 - expected).abs() <= slack, "{} nodes, expected {expected}", lattice.len());
            prop_assert!(lattice.len() >= 1);
        }

        #[test]
        fn adjacency_is_symmetric_sorted_and_one_spacing_long((lattice, ..) in any_lattice()) {
            let graph = lattice.to_graph();
            for i in 0..graph.sites.len() {
                prop_assert!(graph.row(i).windows(2).all(|w| w[0] < w[1]));
                lattice.for_each_neighbor(i, |j, distance| {
                    assert!(graph.row(j).contains(&(i as u32)));
                    assert!((distance_squared(graph.sites[i], graph.sites[j]).sqrt() - distance).abs() < 1e-9 * distance);
                });
            }
        }

        #[test]
        fn nearest_is_the_nearest((lattice, width, height, _) in any_lattice(), u in 0.0f64..1.0, v in 0.0f64..1.0) {
            let point = [u * width as f64, v * height as f64];
            let best = lattice.sites().iter().map(|s| distance_squared(*s, point)).fold(f64::INFINITY, f64::min);
            let found = distance_squared(lattice.site(lattice.nearest(point[0], point[1])), point);
            prop_assert!(found <= best + 1e-9, "found {found}, best {best}");
        }
    }

    #[test]
    fn the_first_hexagonal_node_is_a_quarter_spacing_in() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 100, 100, 1.0).unwrap();
        let spacing = (2.0 / 3f64.sqrt()).sqrt();
        assert_eq!(lattice.site(0), [spacing / 4.0, spacing * 3f64.sqrt() / 4.0]);
        let mut inner = 0;
        lattice.for_each_neighbor(lattice.nearest(50.0, 50.0), |_, _| inner += 1);
        assert_eq!(inner, 6);
    }

    #[test]
    fn a_strip_holds_one_line() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 1, 5000, 0.3).unwrap();
        assert_eq!(lattice.len(), 1500);
        assert_eq!(lattice.to_graph().edges().count(), 1499);
        // As dense as elsewhere, however many pixels wide.
        assert_eq!(Lattice::new(LatticeKind::Hexagonal, 3, 500, 0.06).unwrap().len(), 90);
        assert_eq!(Lattice::new(LatticeKind::Square, 1, 1, 0.1).unwrap().site(0), [0.5, 0.5]);
    }
}
