//! Directories of tagged values, as TIFF files and EXIF data have them (TIFF 6.0, section 2; BigTIFF). In: bytes; out: the values
//! of a tag. The crate `tiff` gives no directory whose image it does not read, and EXIF data hold none.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

/// Entries of a directory, and directories of a file, at most: more are a circle or no directory.
const MAX_ENTRIES: u64 = 4096;

/// Bytes of the values of one tag at most; a profile may take as many.
pub(super) const MAX_VALUE_BYTES: u64 = 64 << 20;

/// Values of a tag that are read as reals at most; those of use have six.
const MAX_REALS: u64 = 16;

/// A file of directories.
pub(super) struct Tagged<R> {
    source: R,
    length: u64,
    big_endian: bool,
    /// BigTIFF: numbers of 64 bits.
    wide: bool,
}

/// Where the values of a tag are.
#[derive(Debug, Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    at: u64,
}

/// One directory.
#[derive(Debug, Clone, Default)]
pub(super) struct Directory {
    entries: BTreeMap<u16, Entry>,
    /// Where the next one is; 0 if there is none.
    pub(super) next: u64,
    /// Whether the file has all that it says.
    pub(super) is_whole: bool,
}

impl Directory {
    /// Whether there is such a tag.
    pub(super) fn has(&self, tag: u16) -> bool {
        self.entries.contains_key(&tag)
    }
}

impl<R: Read + Seek> Tagged<R> {
    /// Opens a file; also tells where its first directory is. `None` if it is no such file.
    pub(super) fn open(mut source: R) -> Option<(Self, u64)> {
        let length = source.seek(SeekFrom::End(0)).ok()?;
        let mut head = [0; 4];
        source.rewind().ok()?;
        source.read_exact(&mut head).ok()?;
        let (big_endian, wide) = match &head {
            b"II*\0" => (false, false),
            b"MM\0*" => (true, false),
            b"II+\0" => (false, true),
            b"MM\0+" => (true, true),
            _ => return None,
        };
        let mut file = Self { source, length, big_endian, wide };
        let first = if wide {
            // Eight bytes an offset, and nothing else.
            if file.number(2)? != 8 || file.number(2)? != 0 {
                return None;
            }
            file.number(8)?
        } else {
            file.number(4)?
        };
        Some((file, first))
    }

    /// Whether samples of more than 8 bits begin with their high byte.
    pub(super) fn is_big_endian(&self) -> bool {
        self.big_endian
    }

    /// Length of the file in bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// The directory at an offset; `None` if there is none that is whole.
    pub(super) fn directory(&mut self, at: u64) -> Option<Directory> {
        self.source.seek(SeekFrom::Start(at)).ok()?;
        let word = if self.wide { 8 } else { 4 };
        let count = self.number(if self.wide { 8 } else { 2 })?;
        if count > MAX_ENTRIES {
            return None;
        }
        let mut directory = Directory { is_whole: true, ..Directory::default() };
        for _ in 0..count {
            let tag = self.number(2)? as u16;
            let kind = self.number(2)? as u16;
            let values = self.number(word)?;
            let here = self.source.stream_position().ok()?;
            let bytes = values.checked_mul(size_of(kind).unwrap_or(1) as u64);
            let offset = self.number(word)?;
            let Some(bytes) = bytes else { continue };
            if size_of(kind).is_none() || bytes > MAX_VALUE_BYTES {
                continue;
            }
            let at = if bytes <= word as u64 { here } else { offset };
            directory.is_whole &= at.saturating_add(bytes) <= self.length;
            // The first of a tag counts.
            directory.entries.entry(tag).or_insert(Entry { kind, count: values, at });
        }
        match self.number(word) {
            Some(next) => directory.next = next,
            None => directory.is_whole = false,
        }
        Some(directory)
    }

    /// The values of a tag as whole numbers, the first of them where there are more than are of use; empty if there is no such tag, or
    /// they are of another kind.
    pub(super) fn numbers(&mut self, directory: &Directory, tag: u16, most: usize) -> Vec<u64> {
        let Some((kind, bytes)) = self.raw(directory, tag, most as u64) else { return Vec::new() };
        if !matches!(kind, 1 | 3 | 4 | 7 | 13 | 16 | 18) {
            return Vec::new();
        }
        let size = size_of(kind).unwrap_or(1);
        bytes.chunks_exact(size).map(|value| of_bytes(value, self.big_endian)).collect()
    }

    /// The values of a tag as reals: whole ones, fractions and floats.
    pub(super) fn reals(&mut self, directory: &Directory, tag: u16) -> Vec<f64> {
        let Some((kind, bytes)) = self.raw(directory, tag, MAX_REALS) else { return Vec::new() };
        let Some(size) = size_of(kind) else { return Vec::new() };
        let of = |value: &[u8]| of_bytes(value, self.big_endian);
        bytes
            .chunks_exact(size)
            .map(|value| match kind {
                5 => of(&value[..4]) as f64 / of(&value[4..]) as f64,
                10 => f64::from(of(&value[..4]) as i32) / f64::from(of(&value[4..]) as i32),
                11 => f64::from(f32::from_bits(of(value) as u32)),
                12 => f64::from_bits(of(value)),
                6 => f64::from(of(value) as i8),
                8 => f64::from(of(value) as i16),
                9 => f64::from(of(value) as i32),
                _ => of(value) as f64,
            })
            .collect()
    }

    /// The first value of a tag.
    pub(super) fn number_of(&mut self, directory: &Directory, tag: u16) -> Option<u64> {
        self.numbers(directory, tag, 1).first().copied()
    }

    /// The bytes of a tag.
    pub(super) fn bytes(&mut self, directory: &Directory, tag: u16) -> Option<Vec<u8>> {
        self.raw(directory, tag, u64::MAX).map(|(_, bytes)| bytes)
    }

    /// Bytes of the file, fewer than asked for where it ends before.
    pub(super) fn read(&mut self, at: u64, count: u64) -> Option<Vec<u8>> {
        let count = count.min(self.length.saturating_sub(at));
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(count).ok()?).ok()?;
        self.source.seek(SeekFrom::Start(at)).ok()?;
        (&mut self.source).take(count).read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    fn raw(&mut self, directory: &Directory, tag: u16, most: u64) -> Option<(u16, Vec<u8>)> {
        let entry = directory.entries.get(&tag)?;
        let wanted = entry.count.min(most) * size_of(entry.kind)? as u64;
        let bytes = self.read(entry.at, wanted)?;
        (bytes.len() as u64 == wanted).then_some((entry.kind, bytes))
    }

    fn number(&mut self, size: usize) -> Option<u64> {
        let mut bytes = [0; 8];
        self.source.read_exact(&mut bytes[..size]).ok()?;
        Some(of_bytes(&bytes[..size], self.big_endian))
    }
}

/// Bytes of a value of a kind.
fn size_of(kind: u16) -> Option<usize> {
    Some(match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => return None,
    })
}

fn of_bytes(bytes: &[u8], big_endian: bool) -> u64 {
    let join = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
}
