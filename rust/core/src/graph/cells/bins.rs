//! Boxes of samples, and the sites sorted into bins, in which those around a box are looked up.

use crate::graph::graph::cumulate;

/// Side of the smallest boxes, in samples, in which every sample is compared with every candidate. Smaller ones narrow down more
/// often, larger ones compare more.
pub(super) const LEAF: usize = 8;

/// Side of the bins, in samples, in which sites are looked up, and by which the surroundings of a block grow until all owners are
/// in them. Smaller ones cost more to walk through, larger ones hold sites that are too far away.
pub(super) const BIN: usize = 4;

/// A box of samples: columns `x.0..x.1`, rows `y.0..y.1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Box2 {
    pub(super) x: (usize, usize),
    pub(super) y: (usize, usize),
}

impl Box2 {
    pub(super) fn width(self) -> usize {
        self.x.1 - self.x.0
    }

    pub(super) fn longest_side(self) -> usize {
        self.width().max(self.y.1 - self.y.0)
    }

    /// The boxes of at most `side` samples a side, on the grid of that side, that make up this one.
    pub(super) fn split(self, side: usize) -> impl Iterator<Item = Self> {
        let cut = move |(begin, end): (usize, usize)| {
            (begin / side..end.div_ceil(side)).map(move |k| (begin.max(k * side), end.min((k + 1) * side)))
        };
        cut(self.y).flat_map(move |y| cut(self.x).map(move |x| Self { x, y }))
    }

    /// The outermost sample positions, in samples: left, right, top, bottom.
    pub(super) fn extent(self) -> [f64; 4] {
        [self.x.0 as f64 + 0.5, self.x.1 as f64 - 0.5, self.y.0 as f64 + 0.5, self.y.1 as f64 - 0.5]
    }
}

/// A site that may own samples of a box; its position in samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) site: u32,
}

/// All sites, sorted into bins of [`BIN`] samples a side.
pub(super) struct Bins<'a> {
    pub(super) sites: &'a [[f64; 2]],
    /// Samples a pixel.
    pub(super) scale: f64,
    /// Start of every bin's sites in `order`, row by row of bins.
    offsets: Vec<u32>,
    pub(super) order: Vec<u32>,
    columns: usize,
    rows: usize,
}

impl<'a> Bins<'a> {
    pub(super) fn new(sites: &'a [[f64; 2]], canvas: Box2, samples_per_pixel: usize) -> Self {
        let scale = samples_per_pixel as f64;
        let (columns, rows) = (canvas.x.1.div_ceil(BIN), canvas.y.1.div_ceil(BIN));
        let bin = |[x, y]: &[f64; 2]| {
            let [column, row] = [x, y].map(|v| (v * scale) as usize / BIN);
            row.min(rows - 1) * columns + column.min(columns - 1)
        };
        // Counted one place further on, and filled in from there: then every start ends up in its own place.
        let mut offsets = vec![0u32; columns * rows + 2];
        for site in sites {
            offsets[bin(site) + 2] += 1;
        }
        cumulate(&mut offsets);
        let mut order = vec![0; sites.len()];
        for (number, site) in (0u32..).zip(sites) {
            let place = &mut offsets[bin(site) + 1];
            order[*place as usize] = number;
            *place += 1;
        }
        Self { sites, scale, offsets, order, columns, rows }
    }

    pub(super) fn candidate(&self, site: u32) -> Candidate {
        let [x, y] = self.sites[site as usize];
        Candidate { x: x * self.scale, y: y * self.scale, site }
    }

    /// The columns and the rows of bins that lie within `reach` samples of a box.
    pub(super) fn window(&self, area: Box2, reach: usize) -> [(usize, usize); 2] {
        let cut = |(begin, end): (usize, usize), limit: usize| {
            (begin.saturating_sub(reach) / BIN, (end + reach).div_ceil(BIN).min(limit))
        };
        [cut(area.x, self.columns), cut(area.y, self.rows)]
    }

    /// Where in `order` the sites of some bins of a row are.
    pub(super) fn run(&self, row: usize, columns: (usize, usize)) -> std::ops::Range<usize> {
        let place = |column: usize| self.offsets[row * self.columns + column] as usize;
        place(columns.0)..place(columns.1)
    }

    /// The sites in the bins that lie within `reach` samples of a box, as runs of `order`, one a row of bins.
    pub(super) fn around(&self, area: Box2, reach: usize) -> impl Iterator<Item = &[u32]> {
        let [columns, rows] = self.window(area, reach);
        (rows.0..rows.1).map(move |row| &self.order[self.run(row, columns)])
    }
}
