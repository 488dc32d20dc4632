//! PNG (third edition, and APNG): in, a file; out, its rows, as the crate `png` unpacks them one by one. Of an animation, the
//! picture that programs show which know no animations.

use std::io::{ErrorKind, Read};

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Reader, Transformations};

use super::canvas::zeros;
use super::colour::Colours;
use super::exif::Exif;
use super::job::{Job, Opened, Source, decoded};
use super::kinds::Container::Png;
use super::kinds::PROFILE_BYTES;
use super::stored::{Depth, Model, Stored};
use crate::base::{Error, Result};
use crate::photo::Samples;

/// Rows that are handed on at once.
const ROWS: usize = 64;

/// The most bytes that the decoder takes for what is no picture.
const MAX_DECODER_BYTES: usize = 64 << 20;

/// Reads a file onto the canvas.
pub(super) fn read(source: &mut dyn Source, job: &mut Job) -> Result<()> {
    let Beside { profile, exif } = beside(source)?;
    let mut decoder = Decoder::new_with_limits(source, Limits { bytes: MAX_DECODER_BYTES });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoded(Png, || decoder.read_info().map_err(|error| broken(&error, "its header is not whole")))?;
    let (color, bits) = decoded(Png, || Ok(reader.output_color_type()))?;
    let info = reader.info();
    let grey = matches!(color, ColorType::Grayscale | ColorType::GrayscaleAlpha);
    let exif = exif.as_deref().map(Exif::of).unwrap_or_default();
    let stored = Stored {
        width: info.width as usize,
        height: info.height as usize,
        model: if grey { Model::Grey } else { Model::Rgb },
        alpha: matches!(color, ColorType::GrayscaleAlpha | ColorType::Rgba),
        premultiplied: false,
        orientation: exif.orientation,
    };
    let depth = if bits == BitDepth::Sixteen { Depth::U16 } else { Depth::U8 };
    let colours = colours(info, profile, exif.adobe_rgb, grey);
    let interlaced = info.interlaced;
    job.begin(&Opened { stored, colours, depth })?;
    let row = stored.width * stored.channels() * if depth == Depth::U16 { 2 } else { 1 };
    let have = if interlaced {
        read_interlaced(&mut reader, stored, row, depth, job)?
    } else {
        read_rows(&mut reader, stored, row, depth, job)?
    };
    if have && decoded(Png, || reader.finish().map_err(|_| Png.damaged(""))).is_err() {
        job.warn("the PNG file lacks its end, or something behind its picture is damaged; all its pixels are there");
    }
    Ok(())
}

/// Reads row by row. Returns whether all rows are there.
fn read_rows(reader: &mut Reader<&mut dyn Source>, stored: Stored, row: usize, depth: Depth, job: &mut Job) -> Result<bool> {
    let mut band = zeros(ROWS.min(stored.height) * row)?;
    let mut done = 0;
    while done < stored.height {
        let wanted = ROWS.min(stored.height - done);
        let mut read = 0;
        let mut failed = None;
        for target in band.chunks_exact_mut(row).take(wanted) {
            let one = decoded(Png, || {
                let found = reader.next_row().map_err(|error| broken(&error, ""))?;
                let data = found.map(|found| found.data()).filter(|data| data.len() >= row);
                target.copy_from_slice(&data.ok_or_else(|| Png.cut_short(""))?[..row]);
                Ok(())
            });
            if let Err(error) = one {
                failed = Some(error);
                break;
            }
            read += 1;
        }
        put(job, done, stored, &band[..read * row], depth)?;
        done += read;
        if let Some(error) = failed {
            let detail = format!("{done} of its {} rows of pixels are there", stored.height);
            job.incomplete(with_detail(&error, &detail), done)?;
            job.canvas()?.leave(0, done, stored.width, stored.height - done);
            return Ok(false);
        }
    }
    Ok(true)
}

/// Reads the seven passes. Returns whether all of them are there.
fn read_interlaced(reader: &mut Reader<&mut dyn Source>, stored: Stored, row: usize, depth: Depth, job: &mut Job) -> Result<bool> {
    let mut samples = zeros(row * stored.height)?;
    let bytes = if depth == Depth::U16 { 2 } else { 1 };
    let background = pixel_of(job.background(), stored, bytes);
    samples.chunks_exact_mut(background.len()).for_each(|pixel| pixel.copy_from_slice(&background));
    let (mut rows, mut whole) = (0, true);
    loop {
        job.control.check()?;
        let next = decoded(Png, || {
            let found = reader.next_interlaced_row().map_err(|error| broken(&error, ""))?;
            let Some(found) = found else { return Ok(None) };
            let png::InterlaceInfo::Adam7(info) = found.interlace() else { return Ok(None) };
            let bits = (stored.channels() * bytes * 8) as u8;
            png::expand_interlaced_row(&mut samples, row, found.data(), info, bits);
            Ok(Some(()))
        });
        match next {
            Ok(Some(())) => rows += 1,
            Ok(None) => break,
            Err(error) => {
                job.incomplete(with_detail(&error, "only a part of its interlaced pixels are there"), rows)?;
                whole = false;
                break;
            }
        }
    }
    put(job, 0, stored, &samples, depth)?;
    Ok(whole)
}

/// The bytes of a pixel that shows the background.
fn pixel_of([red, green, blue]: [u8; 3], stored: Stored, bytes: usize) -> Vec<u8> {
    let weighed = (299 * u32::from(red) + 587 * u32::from(green) + 114 * u32::from(blue)) / 1000;
    let mut pixel = if stored.model == Model::Grey { vec![weighed as u8] } else { vec![red, green, blue] };
    if stored.alpha {
        pixel.push(0);
    }
    pixel.into_iter().flat_map(|value| std::iter::repeat_n(value, bytes)).collect()
}

fn put(job: &mut Job, row: usize, stored: Stored, bytes: &[u8], depth: Depth) -> Result<()> {
    if bytes.is_empty() {
        return Ok(());
    }
    if depth == Depth::U8 {
        return job.canvas()?.put(0, row, stored.width, Samples::U8(bytes));
    }
    let wide: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
    job.canvas()?.put(0, row, stored.width, Samples::U16(&wide))
}

/// What the chunks say of the colours; the first of them that is there counts (PNG, third edition, 4.3).
fn colours(info: &png::Info, profile: Option<Vec<u8>>, adobe_rgb: bool, grey: bool) -> Colours {
    if let Some(points) = &info.coding_independent_code_points
        && let Some(colours) = Colours::of_code_points(points.color_primaries, points.transfer_function, grey)
    {
        return colours;
    }
    if let Some(profile) = profile {
        return Colours::of_icc(&profile);
    }
    if info.srgb.is_some() {
        return Colours::Srgb;
    }
    let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_scaled()) / 100_000.0);
    let chromaticities = info.chrm_chunk.map(|c| {
        let of = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x, y].map(|v| f64::from(v.into_scaled()) / 100_000.0);
        [of(c.white), of(c.red), of(c.green), of(c.blue)]
    });
    match (gamma, chromaticities) {
        (Some(_), _) | (_, Some(_)) => Colours::of_gamma(gamma, chromaticities, grey),
        _ if adobe_rgb && !grey => Colours::adobe_rgb(),
        _ => Colours::Srgb,
    }
}

/// What stands beside the picture and is looked for here.
#[derive(Default)]
struct Beside {
    /// The decoder drops profiles that are large beside the image.
    profile: Option<Vec<u8>>,
    /// The decoder does not see those behind the picture in time.
    exif: Option<Vec<u8>>,
}

/// Looks through all chunks, and leaves the file at its beginning.
fn beside(source: &mut dyn Source) -> Result<Beside> {
    let mut found = Beside::default();
    let mut head = [0; 8];
    let _ = source.read_exact(&mut head);
    while source.read_exact(&mut head).is_ok() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]);
        let name = &head[4..];
        if name == b"IEND" {
            break;
        }
        let wanted = name == b"iCCP" && found.profile.is_none() || name == b"eXIf" && found.exif.is_none();
        let mut skipped = i64::from(length) + 4;
        if wanted && length as usize <= PROFILE_BYTES {
            let mut content = Vec::new();
            let _ = (&mut *source).take(u64::from(length)).read_to_end(&mut content);
            skipped = 4;
            if name == b"eXIf" {
                found.exif = Some(content);
            } else {
                found.profile = Some(profile_of(&content)?);
            }
        }
        if source.seek_relative(skipped).is_err() {
            break;
        }
    }
    source.rewind().map_err(|error| Error::Decode(format!("the file cannot be read: {error}")))?;
    Ok(found)
}

/// The profile in a chunk: a name, a zero, a zero for deflate, and what it made of the profile. What is broken gives no profile.
fn profile_of(content: &[u8]) -> Result<Vec<u8>> {
    let packed = content.iter().position(|byte| *byte == 0).and_then(|end| content.get(end + 2..));
    let mut profile = Vec::new();
    let unpacked = flate2::read::ZlibDecoder::new(packed.unwrap_or_default());
    let whole = unpacked.take(PROFILE_BYTES as u64 + 1).read_to_end(&mut profile).is_ok();
    if profile.len() > PROFILE_BYTES {
        return Err(Png.large_profile(profile.len()));
    }
    Ok(if whole { profile } else { Vec::new() })
}

/// The decoder's error in the user's words.
fn broken(error: &DecodingError, detail: &str) -> Error {
    match error {
        DecodingError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => Png.cut_short(detail),
        // The pixels end before the picture does; this error has no name.
        DecodingError::Format(error) if error.to_string().contains("enough data") => Png.cut_short(detail),
        DecodingError::LimitsExceeded => Error::Decode("the image is too large for the memory that a PNG may take".into()),
        _ => Png.damaged(if detail.is_empty() { "its picture cannot be decoded" } else { detail }),
    }
}

/// The same error of another part of the picture.
fn with_detail(error: &Error, detail: &str) -> Error {
    match error {
        Error::Decode(sentence) if sentence.contains("cut short") => Png.cut_short(detail),
        _ => Png.damaged(detail),
    }
}
