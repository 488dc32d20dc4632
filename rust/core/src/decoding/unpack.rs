//! Compressed data of TIFF as a stream of bytes, by a library for each compression.

use std::io::{self, Cursor, Read};

use fax::BitReader;
use fax::maps::{Mode, black, mode, white};
use lzma_rust2::XzReader;
use weezl::{BitOrder, decode::Decoder as Lzw};

/// The most memory that a window of LZMA or Zstandard may take, in KiB.
const WINDOW_KIB: u32 = 128 << 10;

/// How the rows of faxes are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rows {
    /// Each by itself, from a whole byte on.
    Bytes,
    /// Each by itself, with marks between them (ITU-T T.4).
    Marked,
    /// By the one above or by itself, as a bit behind the mark says.
    MarkedTwo,
    /// By the one above (ITU-T T.6).
    Two,
}

/// How a strip or tile is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Fax(Rows),
    Lzw,
    Jpeg,
    Deflate,
    PackBits,
    Lzma,
    Zstd,
    WebP,
}

impl Compression {
    /// The compression that TIFF has a number for.
    ///
    /// # Errors
    /// The name of one that is not read.
    pub(super) fn of_number(number: u64, has_rows_in_two_dimensions: bool) -> Result<Self, String> {
        Ok(match number {
            1 => Self::None,
            2 => Self::Fax(Rows::Bytes),
            3 if has_rows_in_two_dimensions => Self::Fax(Rows::MarkedTwo),
            3 => Self::Fax(Rows::Marked),
            4 => Self::Fax(Rows::Two),
            5 => Self::Lzw,
            6 => return Err("old-style JPEG compression".into()),
            7 => Self::Jpeg,
            8 | 32_946 => Self::Deflate,
            32_773 => Self::PackBits,
            34_925 => Self::Lzma,
            50_000 => Self::Zstd,
            50_001 | 34_927 => Self::WebP,
            9 | 10 | 34_661 => return Err("JBIG compression".into()),
            32_766 | 32_771 => return Err("NeXT or CCITT RLE compression of words".into()),
            32_809 => return Err("ThunderScan compression".into()),
            33_003 | 33_005 | 34_712 => return Err("JPEG 2000 compression".into()),
            34_676 | 34_677 => return Err("SGI's logarithmic compression".into()),
            34_887 => return Err("LERC compression".into()),
            50_002 | 52_546 => return Err("JPEG XL compression".into()),
            other => return Err(format!("a compression of number {other}")),
        })
    }
}

/// The bytes of a strip or tile whose rows have `width` samples of one bit where faxes are concerned.
pub(super) fn unpacked(compression: Compression, mut data: Vec<u8>, lsb_first: bool, width: usize) -> Box<dyn Read> {
    if lsb_first {
        data.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
    }
    match compression {
        Compression::None | Compression::Jpeg | Compression::WebP => Box::new(Cursor::new(data)),
        Compression::Deflate => Box::new(flate2::bufread::ZlibDecoder::new(Cursor::new(data))),
        Compression::PackBits => Box::new(PackBits { data, at: 0, run: 0, of: None }),
        Compression::Lzw => Box::new(LzwBytes::new(data)),
        Compression::Zstd => match ruzstd::decoding::StreamingDecoder::new(Cursor::new(data)) {
            Ok(stream) => Box::new(stream),
            Err(_) => Box::new(Broken),
        },
        Compression::Lzma => Box::new(XzReader::new_mem_limit(Cursor::new(data), true, WINDOW_KIB)),
        Compression::Fax(rows) => Box::new(Fax::new(data, width, rows)),
    }
}

/// Data whose beginning is broken already.
struct Broken;

impl Read for Broken {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        Err(io::ErrorKind::InvalidData.into())
    }
}

/// Runs of bytes (TIFF 6.0, section 9).
struct PackBits {
    data: Vec<u8>,
    at: usize,
    /// Bytes left of a run: of the byte that is repeated, or as they stand.
    run: usize,
    of: Option<u8>,
}

impl Read for PackBits {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        while self.run == 0 {
            let Some(&head) = self.data.get(self.at) else { return Ok(0) };
            self.at += 1;
            match head {
                0..=127 => (self.run, self.of) = (usize::from(head) + 1, None),
                128 => {}
                _ => {
                    let Some(&byte) = self.data.get(self.at) else { return Ok(0) };
                    self.at += 1;
                    (self.run, self.of) = (257 - usize::from(head), Some(byte));
                }
            }
        }
        let count = match self.of {
            Some(byte) => {
                let count = self.run.min(target.len());
                target[..count].fill(byte);
                count
            }
            None => {
                let rest = &self.data[self.at..];
                let count = self.run.min(target.len()).min(rest.len());
                target[..count].copy_from_slice(&rest[..count]);
                self.at += count;
                count
            }
        };
        self.run -= count;
        Ok(count)
    }
}

/// LZW as TIFF has it, and as it had before it was written down.
struct LzwBytes {
    data: Vec<u8>,
    at: usize,
    decoder: Lzw,
}

impl LzwBytes {
    fn new(data: Vec<u8>) -> Self {
        // The first code clears the table: 256 in nine bits, from the low end in the old way.
        let is_old = matches!(data[..], [0, second, ..] if second & 1 == 1);
        let decoder = if is_old { Lzw::new(BitOrder::Lsb, 8) } else { Lzw::with_tiff_size_switch(BitOrder::Msb, 8) };
        Self { data, at: 0, decoder }
    }
}

impl Read for LzwBytes {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        loop {
            let result = self.decoder.decode_bytes(&self.data[self.at..], target);
            self.at += result.consumed_in;
            match result.status {
                _ if result.consumed_out > 0 => return Ok(result.consumed_out),
                Ok(weezl::LzwStatus::Ok) if result.consumed_in > 0 => {}
                Ok(_) => return Ok(0),
                Err(_) => return Err(io::ErrorKind::InvalidData.into()),
            }
        }
    }
}

/// Codes of faxes, bit by bit.
struct Codes {
    data: Vec<u8>,
    bit: usize,
}

impl BitReader for Codes {
    type Error = ();

    /// Beyond the data are zeros, enough to look up the last code.
    fn peek(&self, bits: u8) -> Option<u16> {
        let byte = self.bit / 8;
        if byte >= self.data.len() {
            return None;
        }
        let next = (0..4).fold(0u32, |next, i| next << 8 | u32::from(self.data.get(byte + i).copied().unwrap_or(0)));
        Some((next << (self.bit % 8) >> (32 - u32::from(bits))) as u16)
    }

    fn consume(&mut self, bits: u8) -> Result<(), ()> {
        self.bit += usize::from(bits);
        Ok(())
    }

    fn bits_to_byte_boundary(&self) -> u8 {
        (self.bit.next_multiple_of(8) - self.bit) as u8
    }
}

/// Rows of bits as faxes send them; white is 0.
struct Fax {
    codes: Codes,
    rows: Rows,
    width: u32,
    /// Where the colour changes in the last row, from white on.
    changes: Vec<u32>,
    row: Vec<u8>,
    at: usize,
}

impl Fax {
    fn new(data: Vec<u8>, width: usize, rows: Rows) -> Self {
        let width = u32::try_from(width).unwrap_or(0);
        Self { codes: Codes { data, bit: 0 }, rows, width, changes: Vec::new(), row: Vec::new(), at: 0 }
    }

    /// The next row; `None` where there is none.
    fn next(&mut self) -> Option<()> {
        let by_itself = match self.rows {
            Rows::Two => false,
            Rows::Bytes => {
                self.codes.bit = self.codes.bit.next_multiple_of(8);
                true
            }
            Rows::Marked | Rows::MarkedTwo => self.skip_marks()?,
        };
        let changes = if by_itself { self.runs()? } else { self.by_the_one_above()? };
        self.row.clear();
        self.row.resize((self.width as usize).div_ceil(8), 0);
        let end = self.width;
        for black in changes.chunks(2) {
            let to = black.get(1).copied().unwrap_or(end).min(end);
            (black[0]..to).for_each(|x| self.row[x as usize / 8] |= 0x80 >> (x % 8));
        }
        self.changes = changes;
        self.at = 0;
        Some(())
    }

    /// Goes over the marks before a row, and the zeros that fill up. Returns whether the row is coded by itself.
    fn skip_marks(&mut self) -> Option<bool> {
        let mut by_itself = true;
        while let next @ (0 | 1) = self.codes.peek(12)? {
            self.codes.bit += if next == 1 { 12 } else { 1 };
            if next == 1 && self.rows == Rows::MarkedTwo {
                by_itself = self.codes.peek(1)? == 1;
                self.codes.bit += 1;
            }
        }
        Some(by_itself)
    }

    /// How long the next run is.
    fn run(&mut self, is_white: bool) -> Option<u32> {
        let mut length = 0;
        loop {
            let part = if is_white { white::decode(&mut self.codes)? } else { black::decode(&mut self.codes)? };
            length = u32::from(part).saturating_add(length);
            if part < 64 {
                return Some(length);
            }
        }
    }

    /// The changes of a row that is coded by itself.
    fn runs(&mut self) -> Option<Vec<u32>> {
        let (mut at, mut changes) = (0, Vec::new());
        while at < self.width {
            at = self.run(changes.len().is_multiple_of(2))?.saturating_add(at).min(self.width);
            changes.push(at);
            self.check(&changes)?;
        }
        Some(changes)
    }

    /// Whether a row has no more changes than its pixels can have, twice as many for runs of none.
    fn check(&self, changes: &[u32]) -> Option<()> {
        (changes.len() <= 2 * (self.width as usize + 1)).then_some(())
    }

    /// The changes of a row that is coded by those of the one above.
    fn by_the_one_above(&mut self) -> Option<Vec<u32>> {
        let (mut at, mut started) = (0, false);
        let mut changes: Vec<u32> = Vec::new();
        let mut passed = 0;
        while at < self.width {
            // The next change above, and the next to the other colour. Both rows go forward only, so none is looked at again.
            while self.changes.get(passed).is_some_and(|change| *change < at || started && *change == at) {
                passed += 1;
            }
            let index = passed + (passed + changes.len()) % 2;
            let first = self.changes.get(index).copied().unwrap_or(self.width);
            match mode::decode(&mut self.codes)? {
                Mode::Pass => at = self.changes.get(index + 1).copied().unwrap_or(self.width),
                Mode::Vertical(moved) => {
                    let next = first.checked_add_signed(i32::from(moved))?.min(self.width);
                    if next < at {
                        return None;
                    }
                    at = next;
                    changes.push(at);
                }
                Mode::Horizontal => {
                    for _ in 0..2 {
                        at = self.run(changes.len().is_multiple_of(2))?.saturating_add(at).min(self.width);
                        changes.push(at);
                    }
                }
                Mode::Extension | Mode::EOF => return None,
            }
            started = true;
            self.check(&changes)?;
        }
        Some(changes)
    }
}

impl Read for Fax {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        if self.at == self.row.len() && self.next().is_none() {
            return Ok(0);
        }
        let rest = &self.row[self.at..];
        let count = rest.len().min(target.len());
        target[..count].copy_from_slice(&rest[..count]);
        self.at += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: Rows, data: Vec<u8>, width: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        unpacked(Compression::Fax(rows), data, false, width).read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_run_of_a_fax_that_is_longer_than_numbers_are_ends_with_its_row() {
        // White runs of 2560, two in three bytes, and one of none at last.
        let mut data = [0x01, 0xF0, 0x1F].repeat(1 << 20);
        data.extend([0b0011_0101; 4]);
        assert!(rows(Rows::Bytes, data.clone(), 16).starts_with(&[0, 0]));
        assert_eq!(rows(Rows::Two, [&[0b0010_0000][..], &data].concat(), 16).len() % 2, 0);
    }

    /// The changes of a row are looked for from where the last was found: from the first on, this takes minutes.
    #[test]
    fn a_fax_of_single_pixels_takes_no_longer_than_others() {
        const WIDTH: usize = 65_528;
        // Each pixel white, then black: after 001, 000111 and 010, in bits.
        let mut bits: Vec<u8> = (0..WIDTH / 2).flat_map(|_| *b"001000111010").collect();
        // Changes where the row above has them.
        bits.extend(vec![b'1'; 64 * (WIDTH + 1)]);
        let data = bits.chunks(8).map(|eight| eight.iter().fold(0, |byte, bit| byte << 1 | (bit - b'0'))).collect();
        let bytes = rows(Rows::Two, data, WIDTH);
        assert!(bytes.len() >= 64 * WIDTH / 8 && bytes.iter().all(|byte| *byte == 0b0101_0101));
    }

    #[test]
    fn a_row_of_a_fax_goes_forward_only() {
        // One white, one black; then three to the left of that, and over the last change again and again.
        let first = 0b0010_0011_1010_0000_u16.to_be_bytes();
        assert!(rows(Rows::Two, [&first[..], &[0b0100_0001; 1000]].concat(), 64).len() <= 8);
    }
}
