//! What the markers of a JPEG say (ITU-T T.81, annex B): its frame, its scans and their tables.

use std::ops::Range;
use std::sync::Arc;

/// A component of the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Component {
    pub(super) id: u8,
    /// Horizontally and vertically, 1 to 4.
    pub(super) sampling: [usize; 2],
}

/// The frame header.
#[derive(Debug, Clone, Default)]
pub(super) struct Frame {
    pub(super) progressive: bool,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) components: Vec<Component>,
}

impl Frame {
    /// The largest sampling of a component.
    pub(super) fn largest(&self) -> [usize; 2] {
        [0, 1].map(|axis| self.components.iter().map(|c| c.sampling[axis]).max().unwrap_or(1).max(1))
    }

    /// Units of interleaved scans, across and down.
    pub(super) fn units(&self) -> [usize; 2] {
        let largest = self.largest();
        [self.width.div_ceil(8 * largest[0]), self.height.div_ceil(8 * largest[1])]
    }

    /// Blocks of a component that have pixels, across and down.
    pub(super) fn blocks(&self, component: &Component) -> [usize; 2] {
        let largest = self.largest();
        let side = [self.width, self.height];
        [0, 1].map(|axis| (side[axis] * component.sampling[axis]).div_ceil(largest[axis]).div_ceil(8))
    }
}

/// A scan.
#[derive(Debug, Clone)]
pub(super) struct Scan {
    /// Index of the component, numbers of its DC and AC table.
    pub(super) components: Vec<(usize, u8, u8)>,
    /// First and last coefficient.
    pub(super) band: [u8; 2],
    /// The bit that was known before, and the one that is known with this scan.
    pub(super) high: u8,
    pub(super) low: u8,
    pub(super) restart_interval: usize,
    pub(super) huffman_dc: [Option<Arc<Huffman>>; 4],
    pub(super) huffman_ac: [Option<Arc<Huffman>>; 4],
    /// The coded data.
    pub(super) data: Range<usize>,
}

impl Scan {
    /// Units of this scan, across and down.
    pub(super) fn units(&self, frame: &Frame) -> [usize; 2] {
        match self.components[..] {
            [(only, ..)] => frame.blocks(&frame.components[only]),
            _ => frame.units(),
        }
    }

    /// Whether it brings means of blocks.
    pub(super) fn is_first_of_dc(&self) -> bool {
        self.band[0] == 0 && self.high == 0
    }
}

/// Bits of a code that are looked up at once.
pub(super) const LOOKED_UP: u32 = 10;

/// A table of Huffman codes.
#[derive(Debug, Clone)]
pub(super) struct Huffman {
    /// Length and symbol by the next bits; length 0 for longer codes.
    pub(super) short: Vec<(u8, u8)>,
    /// Beyond the last code of every length, aligned to 16 bits, and the index of its symbol.
    pub(super) ends: [u32; 17],
    pub(super) offsets: [i32; 17],
    pub(super) symbols: Vec<u8>,
}

impl Huffman {
    /// A table of the numbers of codes of 1 to 16 bits, and their symbols.
    pub(super) fn new(counts: &[u8; 16], symbols: &[u8]) -> Self {
        let mut table = Self { short: vec![(0, 0); 1 << LOOKED_UP], ends: [0; 17], offsets: [0; 17], symbols: symbols.to_vec() };
        let (mut code, mut index) = (0u32, 0usize);
        for length in 1..=16u32 {
            let count = usize::from(counts[length as usize - 1]);
            table.offsets[length as usize] = index as i32 - code as i32;
            for symbol in symbols.iter().skip(index).take(count) {
                if length <= LOOKED_UP {
                    let first = (code << (LOOKED_UP - length)) as usize;
                    let end = (first + (1 << (LOOKED_UP - length))).min(table.short.len());
                    if let Some(places) = table.short.get_mut(first..end) {
                        places.fill((length as u8, *symbol));
                    }
                }
                code += 1;
            }
            index += count;
            table.ends[length as usize] = code << (16 - length);
            code <<= 1;
        }
        table
    }
}
