//! What the samples of every cell add up to.
//!
//! Every tile adds up what its samples say of the sites in and around it, and those sums are put together in the order of the
//! tiles: the result does not depend on the threads.

use crate::base::{Control, Result};
use crate::graph::cells::bins::{Bins, Box2};
use crate::graph::cells::block::{BLOCK, Block, FARTHEST, Lane};
use crate::graph::cells::raster::{Samples, Sink};
use crate::photo::Field;

/// Running sums of a cell, or of a part of it: of `N` fields' values. Positions are summed as integers, so that their order does not
/// matter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums<const N: usize> {
    pub(crate) count: u32,
    pub(crate) columns: u64,
    pub(crate) rows: u64,
    pub(crate) values: [f64; N],
}

impl<const N: usize> Sums<N> {
    pub(crate) const NONE: Self = Self { count: 0, columns: 0, rows: 0, values: [0.0; N] };

    pub(crate) fn add(&mut self, part: &Self) {
        self.count += part.count;
        self.columns += part.columns;
        self.rows += part.rows;
        self.values.iter_mut().zip(part.values).for_each(|(sum, value)| *sum += value);
    }
}

impl Samples<'_> {
    /// Hands over the sums of all cells, part by part: always the same parts in the same order.
    pub(crate) fn add_up<const N: usize>(
        self,
        fields: [&Field; N],
        control: &Control,
        mut take: impl FnMut(u32, &Sums<N>) + Send,
    ) -> Result<()> {
        let pixel_of: Vec<u32> = (0..self.width * self.per_pixel).map(|column| (column / self.per_pixel) as u32).collect();
        self.for_each_tile(
            control,
            |bins, area| SumsOf::new(bins, area, fields, &pixel_of),
            |bins, sums: SumsOf<N>| sums.parts(bins, &mut take),
        )
    }
}

/// The sums of all sites over one tile.
struct SumsOf<'a, const N: usize> {
    area: Box2,
    fields: [&'a Field; N],
    /// The pixel column of every sample column of the canvas.
    pixel_of: &'a [u32],
    samples_per_pixel: usize,
    /// The first row of bins around the tile.
    first_row: usize,
    /// Of every row of bins around the tile: where in the order of bins its sites begin that are around the tile, and where in the sums.
    rows: Vec<[usize; 2]>,
    /// Counts in the lowest 16 bits, sums of columns in the next 24, and of rows in the highest, both from the tile's corner.
    positions: Vec<u64>,
    /// Sums of values.
    values: Vec<[f64; N]>,
    /// What belongs to sites that may not be around the tile.
    others: Vec<(u32, Sums<N>)>,
}

impl<'a, const N: usize> SumsOf<'a, N> {
    fn new(bins: &Bins, area: Box2, fields: [&'a Field; N], pixel_of: &'a [u32]) -> Self {
        let [columns, (first_row, end_row)] = bins.window(area, FARTHEST);
        let mut count = 0;
        let mut row_of = |row: usize| {
            let run = bins.run(row, columns);
            let begin = [run.start, count];
            count += run.len();
            begin
        };
        let rows = (first_row..end_row).map(&mut row_of).collect();
        let values = vec![[0.0; N]; count];
        let samples_per_pixel = bins.scale as usize;
        Self { area, fields, pixel_of, samples_per_pixel, first_row, rows, positions: vec![0; count], values, others: Vec::new() }
    }

    fn values_of_row(&self, row: usize) -> [&'a [f32]; N] {
        self.fields.map(|field| &field.values()[row / self.samples_per_pixel * field.width()..][..field.width()])
    }

    /// Hands over all sums, each with its site, in an order of their own.
    fn parts(&self, bins: &Bins, mut take: impl FnMut(u32, &Sums<N>)) {
        self.others.iter().for_each(|(site, part)| take(*site, part));
        let ends = self.rows[1..].iter().map(|next| next[1]).chain([self.positions.len()]);
        for ([begin, first], end) in self.rows.iter().zip(ends) {
            for (slot, site) in (*first..end).zip(&bins.order[*begin..]) {
                let packed = self.positions[slot];
                let count = packed as u16;
                if count > 0 {
                    let (columns, rows) = (packed >> 16 & 0xFF_FFFF, packed >> 40);
                    let sums = Sums {
                        count: u32::from(count),
                        columns: columns + u64::from(count) * self.area.x.0 as u64,
                        rows: rows + u64::from(count) * self.area.y.0 as u64,
                        values: self.values[slot],
                    };
                    take(*site, &sums);
                }
            }
        }
    }
}

impl<const N: usize> Sink for SumsOf<'_, N> {
    fn first_slot(&self, row: usize) -> usize {
        let [begin, first] = self.rows[row - self.first_row];
        begin.wrapping_sub(first)
    }

    fn run(&mut self, row: usize, columns: std::ops::Range<usize>, site: u32) {
        let mut sums = Sums { count: columns.len() as u32, rows: (row * columns.len()) as u64, ..Sums::NONE };
        let values = self.values_of_row(row);
        for column in columns {
            sums.columns += column as u64;
            let pixel = self.pixel_of[column] as usize;
            sums.values.iter_mut().zip(values).for_each(|(sum, values)| *sum += f64::from(values[pixel]));
        }
        self.others.push((site, sums));
    }

    fn block(&mut self, area: Box2, owners: &[Lane<u32>; BLOCK[1]], block: &Block) {
        let left = (area.x.0 - self.area.x.0) as u64;
        for (row, owners) in (area.y.0..).zip(owners) {
            let first = 1 | left << 16 | ((row - self.area.y.0) as u64) << 40;
            for (i, number) in (0u64..).zip(owners) {
                self.positions[block.slots[*number as usize] as usize] += first + (i << 16);
            }
            let values = self.values_of_row(row);
            if N == 0 {
                continue;
            }
            let pixels = &self.pixel_of[area.x.0..area.x.1];
            // Of every pixel, once: one has several samples.
            let mut last = (u32::MAX, [0.0; N]);
            for (pixel, number) in pixels.iter().zip(owners) {
                if last.0 != *pixel {
                    last = (*pixel, values.map(|values| f64::from(values[*pixel as usize])));
                }
                let sums = &mut self.values[block.slots[*number as usize] as usize];
                for (sum, value) in sums.iter_mut().zip(last.1) {
                    *sum += value;
                }
            }
        }
    }
}
