//! TIFF (6.0 with its supplements, BigTIFF): in, a file; out, the rows of its largest image. What the tags say of the samples is
//! obeyed, or the file is refused. Strips and tiles are unpacked by libraries (see [`super::unpack`]) a few rows at a time.

use std::io::{Cursor, Read};

use super::job::{Job, Source, decoded, needs_memory};
use super::jpeg::{Coding, strip};
use super::kinds::Container::Tiff;
use super::pixels::samples_of;
use super::stored::Owned;
use super::tags::{AT_ONCE, File, Image, Meaning, chosen, image_of, opened, tag};
use super::unpack::{Compression, unpacked};
use super::{directory::Tagged, webp};
use crate::base::{Error, Result};

/// Pixels of a tile that may be more than those of the largest photo that is read: small photos have tiles of the usual size.
const USUAL_TILE: usize = 1 << 20;

/// Reads a file onto the canvas.
pub(super) fn read(source: &mut dyn Source, job: &mut Job) -> Result<()> {
    let Some((mut file, first)) = Tagged::open(source) else { return Err(Tiff.damaged("its header is broken")) };
    let directory = chosen(&mut file, first)?;
    let side = |tag| usize::try_from(file.number_of(&directory, tag).unwrap_or(0)).unwrap_or(usize::MAX);
    job.check_size([tag::WIDTH, tag::HEIGHT].map(side))?;
    let (image, alpha) = image_of(&mut file, &directory)?;
    let opened = opened(&mut file, &directory, &image, alpha)?;
    // Their decoders make all pixels of a chunk at once.
    let is_made_whole = matches!(image.compression, Compression::Jpeg | Compression::WebP);
    if is_made_whole && image.chunk[0].saturating_mul(image.chunk[1]) > USUAL_TILE {
        job.check_size(image.chunk)?;
    }
    job.begin(&opened)?;
    let missing = fill(&mut file, &image, job)?;
    if missing.pixels == 0 && (missing.is_cut || !directory.is_whole) {
        job.warn("the TIFF file lacks its end; all its pixels are there");
    }
    let total = image.width as u64 * image.height as u64;
    if missing.pixels > 0 {
        let detail = format!("{} % of its pixels are there", (total - missing.pixels.min(total)) * 100 / total);
        let error = if missing.is_cut { Tiff.cut_short(&detail) } else { Tiff.damaged(&detail) };
        job.incomplete(error, usize::from(missing.pixels < total))?;
    }
    Ok(())
}

/// Pixels that are not there, and whether the file ends before them.
#[derive(Default)]
struct Missing {
    pixels: u64,
    is_cut: bool,
}

/// Fills the canvas, chunk by chunk.
fn fill(file: &mut File, image: &Image, job: &mut Job) -> Result<Missing> {
    let across = image.width.div_ceil(image.chunk[0]);
    let down = image.height.div_ceil(image.chunk[1]);
    let planes = if image.planar { image.samples } else { 1 };
    let mut missing = Missing::default();
    for index in 0..across * down {
        job.control.check()?;
        let [column, row] = [index % across * image.chunk[0], index / across * image.chunk[1]];
        let width = image.chunk[0].min(image.width - column);
        let height = image.chunk[1].min(image.height - row);
        let mut streams = Vec::with_capacity(planes);
        for plane in 0..planes {
            if image.planar && !image.used.contains(&plane) {
                streams.push(None);
                continue;
            }
            streams.push(Some(stream_of(file, image, plane * across * down + index, &mut missing)?));
        }
        let batch = (AT_ONCE / image.bytes_of_rows(1).max(1)).clamp(1, image.chunk[1]).next_multiple_of(4);
        let mut done = 0;
        while done < height {
            let rows = batch.min(height - done);
            // Rows that are cut off at the lower edge of a tile are never unpacked.
            let Some((samples, read)) = rows_of(image, &mut streams, rows, width)? else { break };
            if read > 0 {
                job.canvas()?.put(column, row + done, width, samples.as_samples())?;
            }
            done += read;
            if read < rows {
                break;
            }
        }
        if done < height {
            job.canvas()?.leave(column, row + done, width, height - done);
            missing.pixels += (width * (height - done)) as u64;
        }
    }
    Ok(missing)
}

/// The bytes of a chunk, unpacked as they are read; as many as are there.
fn stream_of(file: &mut File, image: &Image, index: usize, missing: &mut Missing) -> Result<Box<dyn Read>> {
    let Some(&offset) = image.offsets.get(index) else { return Ok(Box::new(std::io::empty())) };
    // Without lengths, up to the end.
    let length = match image.lengths.get(index) {
        Some(0) | None if image.offsets.len() == 1 || image.compression == Compression::None => {
            if image.compression == Compression::None { image.bytes_of_rows(image.chunk[1]) as u64 } else { file.length() }
        }
        length => length.copied().unwrap_or(0),
    };
    let Some(data) = file.read(offset, length) else {
        needs_memory(length.min(file.length()) as usize)?;
        return Ok(Box::new(std::io::empty()));
    };
    missing.is_cut |= (data.len() as u64) < length;
    if image.compression == Compression::WebP {
        return Ok(match webp::strip(&data, image.chunk) {
            Ok((samples, channels)) if channels == image.samples_of_chunk() => Box::new(Cursor::new(samples)),
            _ => Box::new(std::io::empty()),
        });
    }
    if image.compression != Compression::Jpeg {
        let stream = decoded(Tiff, || Ok(unpacked(image.compression, data, image.lsb_first, image.chunk[0])));
        return Ok(stream.unwrap_or_else(|_| Box::new(std::io::empty())));
    }
    let coding = if image.meaning == Meaning::Ycc { Coding::Ycc } else { Coding::Plain };
    let picture = match strip(&data, image.tables.as_deref(), coding, image.chunk) {
        Ok(picture) => picture,
        Err(error @ Error::Unsupported(_)) => return Err(error),
        Err(_) => return Ok(Box::new(std::io::empty())),
    };
    let row = picture.samples.len() / picture.height.max(1);
    let wanted = image.bytes_of_rows(1);
    if picture.channels != image.samples_of_chunk() || row < wanted {
        return Ok(Box::new(std::io::empty()));
    }
    if row == wanted {
        return Ok(Box::new(Cursor::new(picture.samples)));
    }
    Ok(Box::new(Cursor::new(picture.samples.chunks_exact(row).flat_map(|row| row[..wanted].iter().copied()).collect::<Vec<u8>>())))
}

/// The next rows of a chunk, `width` pixels of each, as samples for the canvas; and how many rows are there.
fn rows_of(image: &Image, streams: &mut [Option<Box<dyn Read>>], rows: usize, width: usize) -> Result<Option<(Owned, usize)>> {
    let mut planes = Vec::with_capacity(streams.len());
    let mut read = rows;
    for stream in streams.iter_mut() {
        let Some(stream) = stream else {
            planes.push(Vec::new());
            continue;
        };
        let mut bytes = vec![0; image.bytes_of_rows(rows)];
        let count = decoded(Tiff, || Ok(read_up_to(stream, &mut bytes))).unwrap_or(0);
        let whole = if image.ycc.subsampling == [1, 1] {
            count / image.bytes_of_rows(1).max(1)
        } else {
            let step = image.ycc.subsampling[1];
            (count / image.bytes_of_rows(step)) * step
        };
        read = read.min(whole);
        planes.push(bytes);
    }
    if read == 0 {
        return Ok(None);
    }
    Ok(Some((samples_of(image, &mut planes, read, width), read)))
}

/// Reads as much as there is, and returns how much that was.
fn read_up_to(stream: &mut dyn Read, target: &mut [u8]) -> usize {
    let mut done = 0;
    while done < target.len() {
        match stream.read(&mut target[done..]) {
            Ok(0) | Err(_) => break,
            Ok(count) => done += count,
        }
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Control;
    use crate::decoding::{Decoded, Reading, decode};

    /// A file of little endian numbers, whose data stand at byte 8 and whose entries are long.
    fn file(entries: &[(u16, &[u32])], data: &[u8]) -> Vec<u8> {
        let mut file = b"II*\0\0\0\0\0".to_vec();
        file.extend(data);
        let places: Vec<u32> = entries
            .iter()
            .map(|(_, values)| match values {
                [one] => *one,
                several => {
                    let at = file.len() as u32;
                    file.extend(several.iter().flat_map(|value| value.to_le_bytes()));
                    at
                }
            })
            .collect();
        let at = file.len() as u32;
        file[4..8].copy_from_slice(&at.to_le_bytes());
        file.extend((entries.len() as u16).to_le_bytes());
        for ((tag, values), place) in entries.iter().zip(places) {
            file.extend(tag.to_le_bytes());
            file.extend(4u16.to_le_bytes());
            file.extend((values.len() as u32).to_le_bytes());
            file.extend(place.to_le_bytes());
        }
        file.extend([0; 4]);
        file
    }

    fn read(file: &[u8], max_pixels: u64) -> Result<Decoded> {
        let reading = Reading { max_pixels, ..Reading::default() };
        decode(&mut Cursor::new(file), &reading, &Control::new())
    }

    fn told(entries: &[(u16, &[u32])], data: &[u8]) -> String {
        read(&file(entries, data), 10_000_000).unwrap_err().to_string()
    }

    /// Bytes as the values of a tag, four by four.
    fn longs(bytes: &[u8]) -> Vec<u32> {
        bytes.chunks(4).map(|four| four.iter().rev().fold(0, |long, byte| long << 8 | u32::from(*byte))).collect()
    }

    #[test]
    fn rows_that_no_photo_has_are_refused_before_there_is_room_for_them() {
        let tiled = |samples, bits| {
            let entries: &[(u16, &[u32])] = &[
                (tag::WIDTH, &[1]),
                (tag::HEIGHT, &[1]),
                (tag::BITS, &[bits]),
                (tag::FORMAT, &[3]),
                (tag::SAMPLES, &[samples]),
                (tag::EXTRA, &[0]),
                (tag::TILE_WIDTH, &[260_000]),
                (tag::TILE_HEIGHT, &[260_000]),
                (tag::TILE_OFFSETS, &[8]),
            ];
            told(entries, &[0; 8])
        };
        assert!(tiled(1024, 64).contains("rows of 2129 MB"), "{}", tiled(1024, 64));
        assert!(tiled(1, 32).contains("0 % of its pixels"), "{}", tiled(1, 32));
    }

    #[test]
    fn a_size_beyond_all_numbers_is_too_large() {
        let entries: &[(u16, &[u32])] =
            &[(tag::WIDTH, &[u32::MAX]), (tag::HEIGHT, &[u32::MAX]), (tag::TILE_WIDTH, &[1]), (tag::TILE_HEIGHT, &[1])];
        assert!(told(entries, &[]).contains("too large: 4294967295 x 4294967295 pixels"), "{}", told(entries, &[]));
    }

    #[test]
    fn a_picture_in_a_tile_is_not_larger_than_the_tile() {
        // A header of 65535 x 65535 pixels and nothing behind it.
        let jpeg = b"\xFF\xD8\xFF\xC0\0\x0B\x08\xFF\xFF\xFF\xFF\x01\x01\x11\0\xFF\xDA\0\x08\x01\x01\0\0\x3F\0\0";
        let webp = b"RIFF\x12\0\0\0WEBPVP8L\x05\0\0\0\x2F\xFE\xBF\xFF\x0F\0";
        for (data, compression, [photometric, samples]) in [(&jpeg[..], 7, [1, 1]), (&webp[..], 50_001, [2, 3])] {
            let of_tiles = |side: u32| {
                let bytes = [data.len() as u32];
                let entries: &[(u16, &[u32])] = &[
                    (tag::WIDTH, &[1]),
                    (tag::HEIGHT, &[1]),
                    (tag::BITS, &[8]),
                    (tag::COMPRESSION, &[compression]),
                    (tag::PHOTOMETRIC, &[photometric]),
                    (tag::SAMPLES, &[samples]),
                    (tag::TILE_WIDTH, &[side]),
                    (tag::TILE_HEIGHT, &[side]),
                    (tag::TILE_OFFSETS, &[8]),
                    (tag::TILE_BYTES, &bytes),
                ];
                told(entries, data)
            };
            assert!(of_tiles(256).contains("0 % of its pixels"), "{}", of_tiles(256));
            assert!(of_tiles(60_000).contains("too large: 60000 x 60000 pixels"), "{}", of_tiles(60_000));
        }
    }

    #[test]
    fn a_picture_in_the_stream_of_the_tables_is_no_part_of_the_strips() {
        let picture = b"\xFF\xD8\xFF\xC0\0\x0B\x08\0\x08\0\x08\x01\x01\x11\0\xFF\xDA\0\x08\x01\x01\0\0\x3F\0\0\xFF\xD9";
        let tables = [&picture[..2], &[0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 0x3F, 0, 0], &picture[2..]].concat();
        for tables in [&picture[..], &[&picture[..15], &picture[15..26], &picture[15..]].concat(), &tables] {
            let entries: &[(u16, &[u32])] = &[
                (tag::WIDTH, &[8]),
                (tag::HEIGHT, &[8]),
                (tag::BITS, &[8]),
                (tag::COMPRESSION, &[7]),
                (tag::PHOTOMETRIC, &[1]),
                (tag::STRIP_OFFSETS, &[8]),
                (tag::STRIP_BYTES, &[picture.len() as u32]),
                (tag::JPEG_TABLES, &longs(tables)),
            ];
            let mut file = file(entries, picture);
            // The tables are bytes of no kind.
            let entry = file.len() - 16;
            file[entry + 2] = 7;
            let length = 4 * longs(tables).len() as u32;
            file[entry + 4..entry + 8].copy_from_slice(&length.to_le_bytes());
            assert!(read(&file, 64).unwrap_err().to_string().contains("0 % of its pixels"));
        }
    }
}
