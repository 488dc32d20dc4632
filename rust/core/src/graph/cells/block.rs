//! Blocks: a few samples side by side that are compared with all sites around them at once.

use crate::graph::cells::bins::{BIN, Bins, Box2, LEAF};

/// Width and height of a block in samples, the width being that of a [`LEAF`]. Larger ones compare each sample with more sites,
/// smaller ones fetch the sites around them more often.
pub(super) const BLOCK: [usize; 2] = [LEAF, 4];

/// How far from a block owners are looked for, in samples, before it is left to the boxes.
pub(super) const FARTHEST: usize = 16;

/// The most sites that a block is compared with, a power of two; a block with more around it is left to the boxes.
const MOST_CANDIDATES: usize = 64;

/// Steps to a squared sample in which blocks compare squared distances: as many as let one coordinate's square up to
/// `(FARTHEST + 0.5)^2` stay below 2^16 steps.
const STEPS: f32 = 240.0;

/// Squared distances nearer to each other than this, in steps, are compared again exactly: both are rounded twice.
const UNSURE: f32 = 3.0;

/// A row of a block.
pub(super) type Lane<T> = [T; BLOCK[0]];

/// A block of samples with the sites around it.
///
/// A squared distance is kept as a whole number of steps, and together with the number of its candidate in one f32 that is exact:
/// `64 steps + number`, below 2^23. So one addition of a column's part and a row's part gives both, and the least of such sums
/// says who is nearest. Samples whose two nearest are too near to each other for that are looked at again.
pub(super) struct Block {
    /// How many candidates there are; what stands behind them is left from other blocks.
    count: usize,
    pub(super) sites: [u32; MOST_CANDIDATES],
    /// Where in a tile's sums the sites are.
    pub(super) slots: [u32; MOST_CANDIDATES],
    /// The sites' positions in samples, from the block's first sample.
    positions: [[f32; 2]; MOST_CANDIDATES],
    columns: [Lane<f32>; MOST_CANDIDATES],
    rows: [[f32; BLOCK[1]]; MOST_CANDIDATES],
    nearest: [Lane<f32>; BLOCK[1]],
    second: [Lane<f32>; BLOCK[1]],
}

/// What the steps are multiplied with, to share an f32 with the number of a candidate.
const SHARE: f32 = MOST_CANDIDATES as f32;

/// Adding it to a number below it, and 0 or above, rounds to a whole number, which the lowest bits then hold.
const WHOLE: f32 = 8_388_608.0;

impl Block {
    pub(super) fn new() -> Self {
        Self {
            count: 0,
            sites: [0; MOST_CANDIDATES],
            slots: [0; MOST_CANDIDATES],
            positions: [[0.0; 2]; MOST_CANDIDATES],
            columns: [[0.0; BLOCK[0]]; MOST_CANDIDATES],
            rows: [[0.0; BLOCK[1]]; MOST_CANDIDATES],
            nearest: [[0.0; BLOCK[0]]; BLOCK[1]],
            second: [[0.0; BLOCK[0]]; BLOCK[1]],
        }
    }

    /// Finds the nearest sites of the block that is `area`, if they are near and not too many. `first_slot` says of a row of bins
    /// by how much the slots of its sites differ from their places in the order of bins.
    pub(super) fn find(&mut self, bins: &Bins, area: Box2, first_slot: &impl Fn(usize) -> usize) -> bool {
        // The sum of two columns' and rows' parts is less.
        self.nearest = [[WHOLE; BLOCK[0]]; BLOCK[1]];
        self.second = self.nearest;
        self.count = 0;
        let mut inner = [(usize::MAX, usize::MAX); 2];
        let mut limit = f32::INFINITY;
        for reach in (BIN..=FARTHEST).step_by(BIN) {
            let window = bins.window(area, reach);
            let known = self.count;
            let [columns, rows] = window;
            for row in rows.0..rows.1 {
                let offset = first_slot(row);
                let is_known = (inner[1].0..inner[1].1).contains(&row);
                let parts = if is_known { [(columns.0, inner[0].0), (inner[0].1, columns.1)] } else { [columns, (0, 0)] };
                for columns in &parts[..1 + usize::from(is_known)] {
                    if !self.take(bins, area, bins.run(row, *columns), limit, offset) {
                        return false;
                    }
                }
            }
            self.compare(known);
            limit = self.farthest();
            // What was left out is further than `reach` away, and half a sample.
            if limit <= (reach * reach) as f32 {
                return true;
            }
            inner = window;
        }
        false
    }

    /// Adds sites that are nearer to the block than `limit` (squared), if there is room for them.
    #[inline(always)]
    fn take(&mut self, bins: &Bins, area: Box2, places: std::ops::Range<usize>, limit: f32, offset: usize) -> bool {
        if self.count + places.len() > MOST_CANDIDATES {
            return false;
        }
        let corner = [area.x.0 as f64 + 0.5, area.y.0 as f64 + 0.5];
        let far = [BLOCK[0] as f32 - 1.0, BLOCK[1] as f32 - 1.0];
        let first_slot = places.start.wrapping_sub(offset) as u32;
        for (slot, site) in (first_slot..).zip(&bins.order[places]) {
            let candidate = bins.candidate(*site);
            let position = [(candidate.x - corner[0]) as f32, (candidate.y - corner[1]) as f32];
            let beyond = |k: usize| {
                let before = if -position[k] > 0.0 { -position[k] } else { 0.0 };
                let behind = position[k] - far[k];
                if behind > before { behind } else { before }
            };
            // Room was made sure of above; the remainder tells the compiler so. A site too far away is written over by the next.
            let place = self.count % MOST_CANDIDATES;
            self.sites[place] = *site;
            self.slots[place] = slot;
            self.positions[place] = position;
            self.count += usize::from(beyond(0) * beyond(0) + beyond(1) * beyond(1) <= limit);
        }
        true
    }

    /// Compares all samples with the candidates from number `first` on.
    fn compare(&mut self, first: usize) {
        let new = first..self.count;
        let parts = self.columns[new.clone()].iter_mut().zip(&mut self.rows[new.clone()]);
        for (number, ((columns, rows), [x, y])) in (first as u32..).zip(parts.zip(&self.positions[new.clone()])) {
            *columns = std::array::from_fn(|i| shared_steps(i as f32 - x));
            *rows = std::array::from_fn(|j| shared_steps(j as f32 - y) + number as f32);
        }
        let (columns, rows) = (&self.columns[new.clone()], &self.rows[new]);
        for (j, (nearest, second)) in self.nearest.iter_mut().zip(&mut self.second).enumerate() {
            let (mut least, mut next) = (*nearest, *second);
            for (columns, rows) in columns.iter().zip(rows) {
                let row = rows[j];
                let sums = columns.map(|column| column + row);
                let larger: Lane<f32> = std::array::from_fn(|i| if sums[i] > least[i] { sums[i] } else { least[i] });
                next = std::array::from_fn(|i| if larger[i] < next[i] { larger[i] } else { next[i] });
                least = std::array::from_fn(|i| if sums[i] < least[i] { sums[i] } else { least[i] });
            }
            (*nearest, *second) = (least, next);
        }
    }

    /// No sample is further than this from its nearest candidate (squared).
    fn farthest(&self) -> f32 {
        let larger = |a: Lane<f32>, b: &Lane<f32>| std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] });
        let of_columns = self.nearest.iter().fold([0.0; BLOCK[0]], larger);
        let farthest = of_columns.iter().fold(0.0, |a, b| if a > *b { a } else { *b });
        (farthest / SHARE + UNSURE) / STEPS
    }

    /// The numbers of the nearest candidates of all samples.
    pub(super) fn owners(&self, bins: &Bins, area: Box2) -> [Lane<u32>; BLOCK[1]] {
        let number = |nearest: f32| (nearest + WHOLE).to_bits() % MOST_CANDIDATES as u32;
        let mut owners = self.nearest.map(|nearest| nearest.map(number));
        let mut apart = [f32::INFINITY; BLOCK[0]];
        for (nearest, second) in self.nearest.iter().zip(&self.second) {
            let gaps: Lane<f32> = std::array::from_fn(|i| second[i] - nearest[i]);
            apart = std::array::from_fn(|i| if gaps[i] < apart[i] { gaps[i] } else { apart[i] });
        }
        if apart.iter().any(|gap| *gap <= (UNSURE + 1.0) * SHARE) {
            self.decide(bins, area, &mut owners);
        }
        owners
    }

    /// Compares samples exactly whose two nearest candidates are too near to each other; the lower index wins a tie.
    #[cold]
    fn decide(&self, bins: &Bins, area: Box2, owners: &mut [Lane<u32>; BLOCK[1]]) {
        for (j, owners) in owners.iter_mut().enumerate() {
            for (i, owner) in owners.iter_mut().enumerate() {
                if self.second[j][i] - self.nearest[j][i] > (UNSURE + 1.0) * SHARE {
                    continue;
                }
                let mut best = (f64::INFINITY, u32::MAX);
                for (number, site) in (0..).zip(&self.sites[..self.count]) {
                    let candidate = bins.candidate(*site);
                    let dx = area.x.0 as f64 + 0.5 - candidate.x + i as f64;
                    let dy = (area.y.0 + j) as f64 + 0.5 - candidate.y;
                    let distance = dx * dx + dy * dy;
                    if distance < best.0 || (distance == best.0 && *site < best.1) {
                        best = (distance, *site);
                        *owner = number;
                    }
                }
            }
        }
    }
}

/// The square of a coordinate's difference in whole steps, beside which the number of a candidate has room.
#[inline(always)]
fn shared_steps(difference: f32) -> f32 {
    let steps = difference * difference * STEPS;
    let steps = if steps < 65_535.0 { steps } else { 65_535.0 };
    (steps + WHOLE - WHOLE) * SHARE
}

impl Box2 {
    /// The blocks that make up this one, on their grid.
    pub(super) fn blocks(self) -> impl Iterator<Item = Self> {
        let [wide, high] = BLOCK;
        let cut = |(begin, end): (usize, usize), side: usize| (begin..end).step_by(side).map(move |at| (at, end.min(at + side)));
        cut(self.y, high).flat_map(move |y| cut(self.x, wide).map(move |x| Self { x, y }))
    }
}
