//! Which site owns which sample: the pass over tiles of the canvas, for any sites.
//!
//! Every sample belongs to its nearest site, the lower index on ties. Where sites are many, which is nearly everywhere on nearly all
//! canvases, the samples of a small *block* are compared with all sites around it at once. Elsewhere the owners are found box by
//! box, from the canvas down: a box with few sites in and around it, near enough to own all of it, is done with those; a crowded
//! one is quartered; and a box whose owners are far away *narrows down* the candidates of the box around it. A site can own a point
//! of a box only if, against every other site, it is nearer at some corner: what is nearer to one of two sites is a half-plane, and
//! a half-plane that meets a box holds a corner of it. So large empty cells cost as little as small ones.
//!
//! Threads share out the tiles. What is made of every tile is handed over in the order of the tiles: it does not depend on the
//! threads.

use rayon::prelude::*;

use crate::base::{Control, Result};
use crate::graph::cells::bins::{Bins, Box2, Candidate, LEAF};
use crate::graph::cells::block::{BLOCK, Block, Lane};

/// Side of a tile in samples: tiles are what threads share out. Smaller ones have more sites in common, whose sums are then put
/// together; the sums of larger ones leave the fastest cache. A tile's sums fit their bits up to 256.
const TILE: usize = 128;

/// Tiles between two looks at the cancellation flag. Sums of twice as many are in memory at once: of those that are put together,
/// and of those that are made meanwhile.
const TILES_AT_ONCE: usize = 128;

/// Side of the boxes, in samples, in which blocks are looked at one by one if they are crowded.
const CROWDED_BOX: usize = 32;

/// A box with more sites in and around it is quartered, if it can be, before they are looked at one by one.
const CROWD: usize = 64;

/// A leaf with more candidates than this narrows them down before it compares them with every sample.
const WORTH_NARROWING: usize = 24;

/// Takes the owners of a tile.
pub(super) trait Sink {
    /// By how much the slots of the sites in a row of bins differ from their places in the order of bins (wrapping).
    fn first_slot(&self, row: usize) -> usize;

    /// The samples of these columns of a row belong to a site.
    fn run(&mut self, row: usize, columns: std::ops::Range<usize>, site: u32);

    /// The owners of a block, as numbers of its candidates.
    fn block(&mut self, area: Box2, owners: &[Lane<u32>; BLOCK[1]], block: &Block);
}

/// Candidate lists of boxes inside one another, one behind the other, as on a stack.
#[derive(Default)]
struct Lists {
    stack: Vec<Candidate>,
    /// Squared distances to the four corners of the box that is narrowed down, by candidate.
    corners: Vec<[f64; 4]>,
}

impl Lists {
    /// Appends those of the candidates `range` that can own a sample of the box.
    ///
    /// Each is compared with a few rivals: the nearest sites to the corners and to the middles of the sides. More rivals would cut
    /// off more, but these leave little more than the sites in the box and a seam around it.
    fn narrow(&mut self, range: std::ops::Range<usize>, area: Box2) -> std::ops::Range<usize> {
        let start = self.stack.len();
        let [left, right, top, bottom] = area.extent();
        let (middle_x, middle_y) = (0.5 * (left + right), 0.5 * (top + bottom));
        self.corners.clear();
        let mut nearest = [(f64::INFINITY, 0); 8];
        for (i, candidate) in self.stack[range.clone()].iter().enumerate() {
            let [l, r, m] = [left, right, middle_x].map(|x| (candidate.x - x) * (candidate.x - x));
            let [t, b, n] = [top, bottom, middle_y].map(|y| (candidate.y - y) * (candidate.y - y));
            for (best, distance) in nearest.iter_mut().zip([l + t, r + t, l + b, r + b, m + t, m + b, l + n, r + n]) {
                if distance < best.0 {
                    *best = (distance, i);
                }
            }
            self.corners.push([l + t, r + t, l + b, r + b]);
        }
        let rivals = nearest.map(|(_, i)| self.corners[i]);
        for (i, corners) in range.zip(&self.corners) {
            // At a tie both stay: the leaf decides by index.
            let survives = |rival: &[f64; 4]| {
                (corners[0] <= rival[0]) | (corners[1] <= rival[1]) | (corners[2] <= rival[2]) | (corners[3] <= rival[3])
            };
            if rivals.iter().all(survives) {
                self.stack.push(self.stack[i]);
            }
        }
        start..self.stack.len()
    }

    /// Appends the sites in and within `reach` samples around a box, if they are sure to own all of it.
    fn gather(&mut self, bins: &Bins, area: Box2, reach: usize) -> Option<std::ops::Range<usize>> {
        let start = self.stack.len();
        for run in bins.around(area, reach) {
            self.stack.extend(run.iter().map(|site| bins.candidate(*site)));
        }
        // One of them is this near to all of the box; a site that was left out is further away than `reach`.
        let [left, right, top, bottom] = area.extent();
        let farthest = |c: &Candidate| {
            let (dx, dy) = ((c.x - left).abs().max((c.x - right).abs()), (c.y - top).abs().max((c.y - bottom).abs()));
            dx * dx + dy * dy
        };
        let nearest = self.stack[start..].iter().map(farthest).fold(f64::INFINITY, f64::min);
        let limit = reach as f64;
        if nearest >= limit * limit && self.stack.len() - start < bins.sites.len() {
            self.stack.truncate(start);
            return None;
        }
        Some(start..self.stack.len())
    }

    /// Hands over boxes that make up `area`, each with its candidates, or without any if it is crowded and no more than `side`
    /// samples long. `list` holds all that can own a sample of `area`, if that is known.
    fn divide(
        &mut self,
        bins: &Bins,
        list: Option<std::ops::Range<usize>>,
        area: Box2,
        side: usize,
        visit: &mut impl FnMut(&mut Self, Option<std::ops::Range<usize>>, Box2),
    ) {
        let start = self.stack.len();
        let longest = area.longest_side();
        let reach = longest.next_multiple_of(LEAF);
        let crowded = bins.around(area, reach).map(<[u32]>::len).sum::<usize>() > CROWD;
        if crowded && longest <= side {
            visit(self, list, area);
            return;
        }
        let mut list = list;
        if !crowded {
            let narrowed = self.gather(bins, area, reach).unwrap_or_else(|| {
                let wider = list.clone().unwrap_or_else(|| self.gather_from(bins, area, 2 * reach));
                self.narrow(wider, area)
            });
            if narrowed.len() <= CROWD || longest <= side {
                visit(self, Some(narrowed), area);
                self.stack.truncate(start);
                return;
            }
            list = Some(narrowed);
        }
        for quarter in area.split((longest / 2).next_power_of_two()) {
            self.divide(bins, list.clone(), quarter, side, visit);
        }
        self.stack.truncate(start);
    }

    /// As [`Lists::gather`], with `reach` doubled until the sites are sure to own all of the box.
    fn gather_from(&mut self, bins: &Bins, area: Box2, mut reach: usize) -> std::ops::Range<usize> {
        loop {
            match self.gather(bins, area, reach) {
                Some(found) => return found,
                None => reach *= 2,
            }
        }
    }

    /// Settles a box no larger than a leaf, whose candidates are not known.
    fn leaf(&mut self, bins: &Bins, area: Box2, sink: &mut impl Sink) {
        self.divide(bins, None, area, LEAF, &mut |lists, list, area| {
            let start = lists.stack.len();
            let mut list = list.unwrap_or_else(|| lists.gather_from(bins, area, LEAF));
            if list.len() > WORTH_NARROWING {
                list = lists.narrow(list, area);
            }
            lists.settle(list, area, sink);
            lists.stack.truncate(start);
        });
    }

    /// Halves boxes of a few candidates until they are leaves or belong to one site, and hands over their owners.
    fn settle(&mut self, range: std::ops::Range<usize>, area: Box2, sink: &mut impl Sink) {
        if let [only] = self.stack[range.clone()] {
            for row in area.y.0..area.y.1 {
                sink.run(row, area.x.0..area.x.1, only.site);
            }
            return;
        }
        if area.longest_side() > LEAF {
            for half in area.split((area.longest_side() / 2).next_multiple_of(LEAF)) {
                let start = self.stack.len();
                let narrowed = self.narrow(range.clone(), half);
                self.settle(narrowed, half, sink);
                self.stack.truncate(start);
            }
            return;
        }
        // In order, so that the lower index wins a tie.
        self.stack[range.clone()].sort_unstable_by_key(|c| c.site);
        for row in area.y.0..area.y.1 {
            // Arrays of a fixed length, so that the comparisons run several samples at a time.
            let mut nearest = [f64::INFINITY; LEAF];
            let mut nearest_site = [0; LEAF];
            for candidate in &self.stack[range.clone()] {
                let dy = row as f64 + 0.5 - candidate.y;
                let left = area.x.0 as f64 + 0.5 - candidate.x;
                for i in 0..LEAF {
                    let dx = left + i as f64;
                    let distance = dx * dx + dy * dy;
                    let nearer = distance < nearest[i];
                    nearest[i] = if nearer { distance } else { nearest[i] };
                    nearest_site[i] = if nearer { candidate.site } else { nearest_site[i] };
                }
            }
            let mut column = area.x.0;
            for run in nearest_site[..area.width()].chunk_by(|a, b| a == b) {
                sink.run(row, column..column + run.len(), run[0]);
                column += run.len();
            }
        }
    }
}

/// A part of the canvas with, where they were needed, its candidates.
struct Task {
    area: Box2,
    candidates: Option<Vec<Candidate>>,
}

/// The samples of a canvas and the sites that own them.
#[derive(Clone, Copy)]
pub(crate) struct Samples<'a> {
    pub(crate) sites: &'a [[f64; 2]],
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) per_pixel: usize,
}

impl Samples<'_> {
    /// Finds the owners tile by tile, several tiles at once, and hands over what it has made of each, in a fixed order.
    pub(super) fn for_each_tile<S: Sink + Send>(
        self,
        control: &Control,
        open: impl Fn(&Bins, Box2) -> S + Sync,
        mut take: impl FnMut(&Bins, S) + Send,
    ) -> Result<()> {
        let canvas = Box2 { x: (0, self.width * self.per_pixel), y: (0, self.height * self.per_pixel) };
        let bins = Bins::new(self.sites, canvas, self.per_pixel);
        let mut tasks = Vec::new();
        Lists::default().divide(&bins, None, canvas, TILE, &mut |lists, list, area| {
            let candidates: Option<Vec<Candidate>> = list.map(|list| lists.stack[list].to_vec());
            tasks.extend(area.split(TILE).map(|area| Task { area, candidates: candidates.clone() }));
        });
        let run = |block: &mut Block, task: &Task| {
            let mut sink = open(&bins, task.area);
            task.run(&bins, block, &mut sink);
            sink
        };
        let mut take_all = |made: Vec<S>| made.into_iter().for_each(|sink| take(&bins, sink));
        // While what was made of some tiles is taken, the next are looked at.
        let mut made: Vec<S> = Vec::new();
        for batch in tasks.chunks(TILES_AT_ONCE) {
            control.check()?;
            (_, made) = rayon::join(|| take_all(made), || batch.par_iter().map_init(Block::new, run).collect());
        }
        take_all(made);
        Ok(())
    }
}

impl Task {
    /// Finds the owner of every sample of the tile.
    fn run(&self, bins: &Bins, block: &mut Block, sink: &mut impl Sink) {
        let mut lists = Lists { stack: self.candidates.clone().unwrap_or_default(), corners: Vec::new() };
        let all = self.candidates.as_ref().map(|list| 0..list.len());
        lists.divide(bins, all, self.area, CROWDED_BOX, &mut |lists, list, area| match list {
            Some(list) => lists.settle(list, area, sink),
            None => {
                for area in area.blocks() {
                    let is_whole = [area.width(), area.y.1 - area.y.0] == BLOCK;
                    if is_whole && block.find(bins, area, &|row| sink.first_slot(row)) {
                        sink.block(area, &block.owners(bins, area), block);
                    } else {
                        lists.leaf(bins, area, sink);
                    }
                }
            }
        });
    }
}
