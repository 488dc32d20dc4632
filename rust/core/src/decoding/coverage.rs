//! How much of a JPEG's picture its coded data hold (ITU-T T.81, annexes F and G): in, the scans of a file; out, how many rows of
//! pixels are there. Decoders paint over what is missing and report success, and where a file ends says nothing: what has
//! been cut is often closed again. So the codes are counted here, without making pixels of them.

use super::frame::{Frame, Huffman, LOOKED_UP, Scan};

/// What the coded data hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Coverage {
    /// Rows of pixels, from the top, that every component has.
    pub(super) rows: usize,
    /// Whether every scan that is there is whole.
    pub(super) whole: bool,
    /// Whether codes were found that no table has.
    pub(super) damaged: bool,
}

/// Bits of coded data, with the zeros after every 0xFF taken out.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    buffer: u64,
    count: u32,
    /// Bits that were read beyond the data.
    lacking: u32,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, buffer: 0, count: 0, lacking: 0 }
    }

    /// Makes sure of 32 bits; beyond the data, or at a marker, they are zeros.
    fn fill(&mut self) {
        while self.count <= 48 {
            let byte = match self.bytes.get(self.at) {
                Some(0xFF) if self.bytes.get(self.at + 1) == Some(&0) => {
                    self.at += 2;
                    0xFF
                }
                Some(byte) if *byte != 0xFF => {
                    self.at += 1;
                    *byte
                }
                _ => {
                    self.lacking += 8;
                    0
                }
            };
            self.buffer |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    /// Bits that were taken though the data had ended.
    fn overrun(&self) -> u32 {
        self.lacking.saturating_sub(self.count)
    }

    fn take(&mut self, bits: u32) -> u32 {
        if bits == 0 {
            return 0;
        }
        let value = (self.buffer >> (64 - bits)) as u32;
        self.buffer <<= bits;
        self.count -= bits;
        value
    }

    /// The next symbol; needs 16 bits in the buffer. `None` if no code fits.
    fn symbol(&mut self, table: &Huffman) -> Option<u8> {
        let (length, symbol) = table.short[(self.buffer >> (64 - LOOKED_UP)) as usize];
        if length > 0 {
            self.take(u32::from(length));
            return Some(symbol);
        }
        let next = (self.buffer >> 48) as u32;
        for length in LOOKED_UP + 1..=16 {
            if next < table.ends[length as usize] {
                let code = self.take(length) as i32;
                return table.symbols.get((code + table.offsets[length as usize]) as usize).copied();
            }
        }
        None
    }

    /// Goes to the data behind the next restart marker; `false` if there is none.
    fn restart(&mut self) -> bool {
        (self.buffer, self.count, self.lacking) = (0, 0, 0);
        while let Some(at) = self.bytes[self.at.min(self.bytes.len())..].iter().position(|byte| *byte == 0xFF) {
            self.at += at + 1;
            match self.bytes.get(self.at) {
                Some(0xD0..=0xD7) => {
                    self.at += 1;
                    return true;
                }
                Some(_) => {}
                None => return false,
            }
        }
        false
    }
}

/// Where the blocks of a component are.
struct Blocks {
    /// Blocks of a row, with those that fill the last unit of interleaved scans.
    stride: usize,
    /// Which coefficients of every block are known not to be 0, where later scans have to know.
    nonzero: Vec<u64>,
}

/// What the scans of a frame hold.
pub(super) fn coverage(frame: &Frame, scans: &[Scan], bytes: &[u8]) -> Coverage {
    let units = frame.units();
    let mut blocks: Vec<Blocks> = frame
        .components
        .iter()
        .map(|component| {
            let [h, v] = component.sampling;
            let stride = units[0] * h;
            let nonzero = if frame.progressive { vec![0; stride * units[1] * v] } else { Vec::new() };
            Blocks { stride, nonzero }
        })
        .collect();
    let mut rows = vec![0; frame.components.len()];
    let (mut whole, mut damaged) = (true, false);
    for scan in scans {
        let (done, sound) = walk(frame, scan, &mut blocks, bytes);
        let wanted = scan.units(frame);
        whole &= done >= wanted[0] * wanted[1];
        damaged |= !sound;
        // Rows of pixels that a row of units has.
        let high = if let [(only, ..)] = scan.components[..] {
            8 * frame.largest()[1] / frame.components[only].sampling[1].max(1)
        } else {
            8 * frame.largest()[1]
        };
        if !frame.progressive || scan.is_first_of_dc() {
            for (component, ..) in &scan.components {
                rows[*component] = (done / wanted[0].max(1) * high).min(frame.height);
            }
        }
    }
    Coverage { rows: rows.into_iter().min().unwrap_or(0), whole, damaged }
}

/// Walks through a scan. Returns how many of its units are there, and whether all codes were in their tables.
fn walk(frame: &Frame, scan: &Scan, blocks: &mut [Blocks], bytes: &[u8]) -> (usize, bool) {
    let [across, down] = scan.units(frame);
    let total = across * down;
    let mut bits = Bits::new(&bytes[scan.data.clone()]);
    let interval = if scan.restart_interval == 0 { total } else { scan.restart_interval };
    let alone = scan.components.len() == 1;
    let mut done = 0;
    let mut run = 0;
    let mut sound = true;
    while done < total {
        let end = (done + interval).min(total);
        while done < end {
            let (column, row) = (done % across, done / across);
            for (component, dc, ac) in &scan.components {
                let [h, v] = if alone { [1, 1] } else { frame.components[*component].sampling };
                let blocks = &mut blocks[*component];
                for block in 0..h * v {
                    let at = (row * v + block / h) * blocks.stride + column * h + block % h;
                    let dc = scan.huffman_dc[usize::from(*dc & 3)].as_deref();
                    let ac = scan.huffman_ac[usize::from(*ac & 3)].as_deref();
                    let nonzero = blocks.nonzero.get_mut(at);
                    let known = if frame.progressive {
                        nonzero.and_then(|nonzero| progressive(&mut bits, scan, dc, ac, nonzero, &mut run))
                    } else {
                        sequential(&mut bits, dc, ac)
                    };
                    if known.is_none() {
                        // Zeros behind the end may be no code; that is no damage.
                        return (done, bits.overrun() > 0);
                    }
                }
            }
            if bits.overrun() > 0 {
                if bits.restart() {
                    // The interval is short, but there is more: damage in the middle.
                    sound = false;
                    done = end;
                    run = 0;
                    continue;
                }
                return (done, sound);
            }
            done += 1;
        }
        if done < total {
            run = 0;
            if !bits.restart() {
                return (done, sound);
            }
        }
    }
    (done, sound)
}

/// Walks through a block of a sequential scan.
fn sequential(bits: &mut Bits, dc: Option<&Huffman>, ac: Option<&Huffman>) -> Option<()> {
    bits.fill();
    let size = bits.symbol(dc?)?;
    if size > 16 {
        return None;
    }
    bits.take(u32::from(size));
    let ac = ac?;
    let mut k = 1;
    while k < 64 {
        bits.fill();
        let symbol = bits.symbol(ac)?;
        let (zeros, size) = (symbol >> 4, symbol & 15);
        if size == 0 {
            if zeros < 15 {
                break;
            }
            k += 16;
            continue;
        }
        k += zeros + 1;
        bits.take(u32::from(size));
    }
    (k <= 64).then_some(())
}

/// Walks through a block of a progressive scan; `run` is how many blocks more have nothing new.
fn progressive(
    bits: &mut Bits,
    scan: &Scan,
    dc: Option<&Huffman>,
    ac: Option<&Huffman>,
    nonzero: &mut u64,
    run: &mut u32,
) -> Option<()> {
    bits.fill();
    if scan.band[0] == 0 {
        if scan.high == 0 {
            let size = bits.symbol(dc?)?;
            if size > 16 {
                return None;
            }
            bits.take(u32::from(size));
        } else {
            bits.take(1);
        }
        return Some(());
    }
    let [first, last] = scan.band;
    let refines = scan.high != 0;
    let mut k = first;
    if *run == 0 {
        while k <= last {
            bits.fill();
            let symbol = bits.symbol(ac?)?;
            let (mut zeros, size) = (symbol >> 4, symbol & 15);
            if size == 0 && zeros < 15 {
                *run = (1 << zeros) + bits.take(u32::from(zeros));
                break;
            }
            if !refines {
                k += zeros;
                if size == 0 {
                    k += 1;
                    continue;
                }
                bits.take(u32::from(size));
                if k <= last {
                    *nonzero |= 1 << k;
                }
                k += 1;
                continue;
            }
            if size != 0 {
                bits.take(1);
            }
            // Over so many coefficients that are still 0; those that are not have a bit each.
            while k <= last {
                if *nonzero >> k & 1 == 1 {
                    bits.fill();
                    bits.take(1);
                } else if zeros == 0 {
                    break;
                } else {
                    zeros -= 1;
                }
                k += 1;
            }
            if size != 0 && k <= last {
                *nonzero |= 1 << k;
            }
            k += 1;
        }
    }
    if *run > 0 {
        if refines {
            for k in k..=last {
                if *nonzero >> k & 1 == 1 {
                    bits.fill();
                    bits.take(1);
                }
            }
        }
        *run -= 1;
    }
    Some(())
}
