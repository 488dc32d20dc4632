//! Compressed data of TIFF as a stream of bytes, by a library for each compression.

use std::io::{self, Cursor, Read};
use std::vec::IntoIter;

use fax::decoder::{Group4Decoder, pels};
use fax::maps::{black, white};
use fax::{BitReader, ByteReader, Color};
use lzma_rust2::XzReader;
use weezl::{BitOrder, decode::Decoder as Lzw};

/// The most memory that a window of LZMA or Zstandard may take, in KiB.
const WINDOW_KIB: u32 = 128 << 10;

/// How a strip or tile is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    /// Runs of bits, each row from a whole byte on (2), or with marks between the rows (3).
    Fax1d,
    Fax4,
    Lzw,
    Jpeg,
    Deflate,
    PackBits,
    Lzma,
    Zstd,
}

impl Compression {
    /// The compression that TIFF has a number for.
    ///
    /// # Errors
    /// The name of one that is not read.
    pub(super) fn of_number(number: u64, has_rows_in_two_dimensions: bool) -> Result<Self, String> {
        Ok(match number {
            1 => Self::None,
            2 => Self::Fax1d,
            3 if has_rows_in_two_dimensions => return Err("Group 3 compression in two dimensions".into()),
            3 => Self::Fax1d,
            4 => Self::Fax4,
            5 => Self::Lzw,
            6 => return Err("old-style JPEG compression".into()),
            7 => Self::Jpeg,
            8 | 32_946 => Self::Deflate,
            32_773 => Self::PackBits,
            34_925 => Self::Lzma,
            50_000 => Self::Zstd,
            9 | 10 | 34_661 => return Err("JBIG compression".into()),
            32_766 | 32_771 => return Err("NeXT or CCITT RLE compression of words".into()),
            32_809 => return Err("ThunderScan compression".into()),
            33_003 | 33_005 | 34_712 => return Err("JPEG 2000 compression".into()),
            34_676 | 34_677 => return Err("SGI's logarithmic compression".into()),
            34_887 => return Err("LERC compression".into()),
            50_001 | 34_927 => return Err("WebP compression".into()),
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
        Compression::None | Compression::Jpeg => Box::new(Cursor::new(data)),
        Compression::Deflate => Box::new(flate2::bufread::ZlibDecoder::new(Cursor::new(data))),
        Compression::PackBits => Box::new(PackBits { data, at: 0, run: 0, of: None }),
        Compression::Lzw => Box::new(LzwBytes::new(data)),
        Compression::Zstd => match ruzstd::decoding::StreamingDecoder::new(Cursor::new(data)) {
            Ok(stream) => Box::new(stream),
            Err(_) => Box::new(Broken),
        },
        Compression::Lzma => Box::new(XzReader::new_mem_limit(Cursor::new(data), true, WINDOW_KIB)),
        Compression::Fax1d | Compression::Fax4 => match Fax::new(data, width, compression == Compression::Fax4) {
            Some(fax) => Box::new(fax),
            None => Box::new(Broken),
        },
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
        let decoder =
            if is_old { Lzw::new(BitOrder::Lsb, 8) } else { Lzw::with_tiff_size_switch(BitOrder::Msb, 8) };
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

type FaxBytes = std::iter::Map<IntoIter<u8>, fn(u8) -> Result<u8, io::Error>>;

/// Rows of bits as faxes send them (ITU-T T.4 in one dimension, T.6); white is 0.
struct Fax {
    rows: Rows,
    width: u32,
    row: Vec<u8>,
    at: usize,
}

enum Rows {
    One(ByteReader<FaxBytes>),
    Two(Group4Decoder<FaxBytes>),
}

impl Fax {
    fn new(mut data: Vec<u8>, width: usize, is_two: bool) -> Option<Self> {
        // The last codes are looked for in more bits than they have.
        data.extend([0; 4]);
        let bytes: FaxBytes = data.into_iter().map(Ok as fn(u8) -> Result<u8, io::Error>);
        let width = u32::try_from(width).ok()?;
        let rows = if is_two {
            Rows::Two(Group4Decoder::new(bytes, width).ok()?)
        } else {
            Rows::One(ByteReader::new(bytes).ok()?)
        };
        Some(Self { rows, width, row: Vec::new(), at: 0 })
    }

    /// The next row; `None` where there is none.
    fn next(&mut self) -> Option<()> {
        let mut changes = Vec::new();
        match &mut self.rows {
            Rows::Two(decoder) => {
                if decoder.advance().ok()? == fax::decoder::DecodeStatus::End {
                    return None;
                }
                changes.extend_from_slice(decoder.transition());
            }
            Rows::One(reader) => {
                // Marks between rows, and what fills them up, or up to a whole byte.
                while let Some(next @ (0 | 1)) = reader.peek(12) {
                    reader.consume(if next == 1 { 12 } else { 1 }).ok()?;
                }
                let (mut at, mut is_white) = (0, true);
                while at < self.width {
                    loop {
                        let run = if is_white { white::decode(reader)? } else { black::decode(reader)? };
                        at += u32::from(run);
                        if run < 64 {
                            break;
                        }
                    }
                    changes.push(at);
                    is_white = !is_white;
                }
            }
        }
        self.row.clear();
        self.row.resize((self.width as usize).div_ceil(8), 0);
        for (x, colour) in pels(&changes, self.width).enumerate() {
            if colour == Color::Black {
                self.row[x / 8] |= 0x80 >> (x % 8);
            }
        }
        self.at = 0;
        Some(())
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
