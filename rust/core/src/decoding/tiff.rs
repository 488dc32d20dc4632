//! TIFF (6.0 with its supplements, BigTIFF): in, a file; out, the rows of its largest image. What the tags say of the samples is
//! obeyed, or the file is refused. Strips and tiles are unpacked by libraries (see [`super::unpack`]) a few rows at a time.

use std::io::{Cursor, Read};

use half::f16;

use super::canvas::{Model, Owned, Stored};
use super::colour::{Colours, Depth};
use super::directory::{Directory, Tagged};
use super::exif::Exif;
use super::jpeg::{Coding, strip};
use super::kinds::Container::Tiff;
use super::kinds::PROFILE_BYTES;
use super::reading::{Job, Opened, Source, decoded, needs_memory};
use super::unpack::{Compression, unpacked};
use super::webp;
use crate::base::{Error, Result};
use crate::photo::MAX_SIDE;

/// Images of a file that are looked at.
const MAX_IMAGES: usize = 256;

/// Samples of a pixel at most.
const MAX_SAMPLES: usize = 1024;

/// Bytes that are unpacked at once, about.
const AT_ONCE: usize = 1 << 20;

/// Bytes of a row of a strip or tile at most: it is unpacked whole. Real ones have a hundredth.
const MAX_ROW_BYTES: u64 = 64 << 20;

/// Pixels of a tile that may be more than those of the largest photo that is read: small photos have tiles of the usual size.
const USUAL_TILE: usize = 1 << 20;

mod tag {
    pub(super) const SUBFILE: u16 = 254;
    pub(super) const OLD_SUBFILE: u16 = 255;
    pub(super) const WIDTH: u16 = 256;
    pub(super) const HEIGHT: u16 = 257;
    pub(super) const BITS: u16 = 258;
    pub(super) const COMPRESSION: u16 = 259;
    pub(super) const PHOTOMETRIC: u16 = 262;
    pub(super) const FILL_ORDER: u16 = 266;
    pub(super) const STRIP_OFFSETS: u16 = 273;
    pub(super) const SAMPLES: u16 = 277;
    pub(super) const ROWS_PER_STRIP: u16 = 278;
    pub(super) const STRIP_BYTES: u16 = 279;
    pub(super) const PLANAR: u16 = 284;
    pub(super) const T4_OPTIONS: u16 = 292;
    pub(super) const PREDICTOR: u16 = 317;
    pub(super) const PALETTE: u16 = 320;
    pub(super) const TILE_WIDTH: u16 = 322;
    pub(super) const TILE_HEIGHT: u16 = 323;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_BYTES: u16 = 325;
    pub(super) const SUB_IFDS: u16 = 330;
    pub(super) const INK_SET: u16 = 332;
    pub(super) const EXTRA: u16 = 338;
    pub(super) const FORMAT: u16 = 339;
    pub(super) const JPEG_TABLES: u16 = 347;
    pub(super) const COEFFICIENTS: u16 = 529;
    pub(super) const SUBSAMPLING: u16 = 530;
    pub(super) const REFERENCE: u16 = 532;
    pub(super) const PROFILE: u16 = 34_675;
    pub(super) const DNG_VERSION: u16 = 50_706;
}

/// What the samples of a pixel mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    WhiteIsZero,
    BlackIsZero,
    Rgb,
    Palette,
    Cmyk,
    Ycc,
    /// CIE L*a*b* with signed a and b, or with those moved by half their range.
    Lab {
        signed: bool,
    },
}

/// What the bits of a sample mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    Unsigned,
    Float,
}

/// What the tags of an image say.
struct Image {
    width: usize,
    height: usize,
    meaning: Meaning,
    number: Number,
    bits: usize,
    /// Samples of a pixel, and which of them are used: colours, then opacity.
    samples: usize,
    used: Vec<usize>,
    compression: Compression,
    predictor: u64,
    lsb_first: bool,
    big_endian: bool,
    planar: bool,
    /// Width and height of a tile, or of a strip.
    chunk: [usize; 2],
    offsets: Vec<u64>,
    lengths: Vec<u64>,
    palette: Vec<u64>,
    tables: Option<Vec<u8>>,
    ycc: Ycc,
}

/// How luma and chroma make colours (TIFF 6.0, section 21).
struct Ycc {
    subsampling: [usize; 2],
    coefficients: [f64; 3],
    reference: [f64; 6],
}

type File<'a> = Tagged<&'a mut dyn Source>;

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

/// The directory of the image that is read: the largest that is no thumbnail and no mask.
fn chosen(file: &mut File, first: u64) -> Result<Directory> {
    let mut places = vec![first];
    let mut best: Option<(bool, u64, Directory)> = None;
    let (mut seen, mut is_raw, mut found) = (Vec::new(), false, false);
    while let Some(at) = places.pop() {
        if seen.len() >= MAX_IMAGES {
            break;
        }
        if at == 0 || seen.contains(&at) {
            continue;
        }
        seen.push(at);
        let Some(directory) = file.directory(at) else { continue };
        found = true;
        // Those below an image come after it, and before the next.
        places.push(directory.next);
        places.extend(file.numbers(&directory, tag::SUB_IFDS, MAX_IMAGES).into_iter().rev());
        let photometric = file.number_of(&directory, tag::PHOTOMETRIC);
        is_raw |= matches!(photometric, Some(32_803 | 34_892))
            || directory.has(tag::DNG_VERSION)
            || matches!(file.number_of(&directory, tag::COMPRESSION), Some(34_713 | 32_767 | 32_770 | 65_535));
        let size = [tag::WIDTH, tag::HEIGHT].map(|tag| file.number_of(&directory, tag).unwrap_or(0));
        let pixels = size[0].saturating_mul(size[1]);
        let subfile = file.number_of(&directory, tag::SUBFILE).unwrap_or(0);
        let is_mask = subfile & 4 != 0 || photometric == Some(4);
        let is_reduced = subfile & 1 != 0 || file.number_of(&directory, tag::OLD_SUBFILE) == Some(2);
        let is_main = !is_mask && !is_reduced;
        // Of the pages of a document, the first.
        let is_page = subfile & 2 != 0;
        let better = match &best {
            None => true,
            Some((main, most, _)) if *main == is_main => pixels > *most && !is_page,
            Some((main, ..)) => !main,
        };
        if pixels > 0 && better {
            best = Some((is_main, pixels, directory));
        }
    }
    if is_raw {
        return Err(Error::Decode(
            "the file is a camera's raw file (DNG, NEF, ARW or the like), which is not read here: develop it with the camera's \
             program to TIFF or JPEG"
                .into(),
        ));
    }
    match best {
        Some((.., directory)) => Ok(directory),
        None if found => Err(Tiff.damaged("there is no image in it")),
        None => Err(Tiff.cut_short("its directory is missing")),
    }
}

/// What the tags say, and whether the last sample that is used is opacity, and premultiplied.
fn image_of(file: &mut File, directory: &Directory) -> Result<(Image, Option<bool>)> {
    let one = |file: &mut File, tag, default| file.number_of(directory, tag).unwrap_or(default);
    let [width, height] = [tag::WIDTH, tag::HEIGHT].map(|tag| one(file, tag, 0) as usize);
    let samples = one(file, tag::SAMPLES, 1) as usize;
    let photometric = file.number_of(directory, tag::PHOTOMETRIC);
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(Tiff.damaged(&format!("it says that a pixel has {samples} samples")));
    }
    let number = number_of(file, directory)?;
    let mut bits = file.numbers(directory, tag::BITS, MAX_SAMPLES);
    bits.dedup();
    let bits = match bits[..] {
        [] => 1,
        [bits @ 1..=64] => bits as usize,
        [_] => return Err(Tiff.damaged("it says how many bits its samples have, but not rightly")),
        _ => return Err(Tiff.unsupported("samples of different numbers of bits")),
    };
    let is_known = match number {
        Number::Unsigned => bits <= 32,
        Number::Float => matches!(bits, 16 | 32 | 64),
    };
    if !is_known {
        let kind = if number == Number::Float { "float samples" } else { "samples" };
        return Err(Tiff.unsupported(&format!("{kind} of {bits} bits")));
    }
    let meaning = match photometric {
        Some(0) => Meaning::WhiteIsZero,
        Some(1 | 4) => Meaning::BlackIsZero,
        Some(2) => Meaning::Rgb,
        Some(3) => Meaning::Palette,
        Some(5) if matches!(one(file, tag::INK_SET, 1), 1) => Meaning::Cmyk,
        Some(5) => return Err(Tiff.unsupported("inks other than CMYK")),
        Some(6) => Meaning::Ycc,
        Some(8) => Meaning::Lab { signed: true },
        Some(9) => Meaning::Lab { signed: false },
        Some(10) => return Err(Tiff.unsupported("colours in ITU L*a*b*")),
        Some(32_844 | 32_845) => return Err(Tiff.unsupported("logarithmic colours (LogLuv)")),
        None if samples >= 3 => Meaning::Rgb,
        None => Meaning::BlackIsZero,
        Some(other) => return Err(Tiff.unsupported(&format!("colours of a kind of number {other}"))),
    };
    let (used, alpha) = used_of(file, directory, meaning, samples)?;
    let allowed = match meaning {
        Meaning::Palette => number == Number::Unsigned && bits <= 16,
        Meaning::Ycc => number == Number::Unsigned && bits == 8,
        Meaning::Lab { .. } => number == Number::Unsigned && matches!(bits, 8 | 16),
        _ => true,
    };
    if !allowed {
        return Err(Tiff.unsupported(&format!("samples of {bits} bits for such colours")));
    }
    let in_two = one(file, tag::T4_OPTIONS, 0) & 1 == 1;
    let compression = Compression::of_number(one(file, tag::COMPRESSION, 1), in_two).map_err(|what| Tiff.unsupported(&what))?;
    if matches!(compression, Compression::Fax(_)) && (bits != 1 || samples != 1) {
        return Err(Tiff.damaged("a compression of faxes, but more than one bit a pixel"));
    }
    let predictor = one(file, tag::PREDICTOR, 1);
    let fits = match predictor {
        1 => true,
        2 => matches!(bits, 8 | 16 | 32 | 64),
        3 => number == Number::Float,
        _ => false,
    };
    let predicted = matches!(compression, Compression::Lzw | Compression::Deflate | Compression::Zstd | Compression::Lzma);
    if predicted && !fits {
        return Err(Tiff.unsupported(&format!("a predictor of number {predictor} for samples of {bits} bits")));
    }
    let tiled = directory.has(tag::TILE_OFFSETS);
    let chunk = if tiled {
        [tag::TILE_WIDTH, tag::TILE_HEIGHT].map(|tag| one(file, tag, 0) as usize)
    } else {
        [width, (one(file, tag::ROWS_PER_STRIP, height as u64) as usize).clamp(1, height.max(1))]
    };
    if chunk.iter().any(|side| *side == 0 || *side > 4 * MAX_SIDE) {
        return Err(Tiff.damaged(&format!("its tiles are {} x {} pixels", chunk[0], chunk[1])));
    }
    let names = if tiled { [tag::TILE_OFFSETS, tag::TILE_BYTES] } else { [tag::STRIP_OFFSETS, tag::STRIP_BYTES] };
    let planar = one(file, tag::PLANAR, 1) == 2 && samples > 1;
    let row_bits = chunk[0] as u64 * bits as u64 * if planar { 1 } else { samples as u64 };
    if row_bits.div_ceil(8) > MAX_ROW_BYTES {
        return Err(Tiff.unsupported(&format!("rows of {} MB", row_bits / 8_000_000)));
    }
    let chunks = width.div_ceil(chunk[0]) * height.div_ceil(chunk[1]) * if planar { samples } else { 1 };
    let [offsets, lengths] = names.map(|tag| file.numbers(directory, tag, chunks));
    let subsampling = match file.numbers(directory, tag::SUBSAMPLING, 3)[..] {
        [h @ (1 | 2 | 4), v @ (1 | 2 | 4)] => [h as usize, v as usize],
        [] => [2, 2],
        _ => return Err(Tiff.damaged("its chroma is subsampled in no known way")),
    };
    let reals = |file: &mut File, tag| file.reals(directory, tag);
    let ycc = Ycc {
        subsampling: if meaning == Meaning::Ycc && compression != Compression::Jpeg { subsampling } else { [1, 1] },
        coefficients: <[f64; 3]>::try_from(reals(file, tag::COEFFICIENTS)).unwrap_or([0.299, 0.587, 0.114]),
        reference: <[f64; 6]>::try_from(reals(file, tag::REFERENCE)).unwrap_or([0.0, 255.0, 128.0, 255.0, 128.0, 255.0]),
    };
    if ycc.subsampling != [1, 1] && (planar || samples != 3) {
        return Err(Tiff.unsupported("subsampled chroma in planes of its own"));
    }
    let mut image = Image {
        width,
        height,
        meaning,
        number,
        bits,
        samples,
        used,
        compression,
        predictor: if predicted { predictor } else { 1 },
        lsb_first: one(file, tag::FILL_ORDER, 1) == 2 && compression != Compression::Jpeg,
        big_endian: file.is_big_endian(),
        planar,
        chunk,
        offsets,
        lengths,
        palette: file.numbers(directory, tag::PALETTE, 3 << 16),
        tables: file.bytes(directory, tag::JPEG_TABLES),
        ycc,
    };
    if !tiled {
        image.split();
    }
    if meaning == Meaning::Palette && image.palette.len() < 3 << bits {
        return Err(Tiff.damaged("its palette is not whole"));
    }
    if matches!(compression, Compression::Jpeg | Compression::WebP) && bits != 8 {
        return Err(Tiff.unsupported(&format!("JPEG or WebP compression of samples of {bits} bits")));
    }
    Ok((image, alpha))
}

fn number_of(file: &mut File, directory: &Directory) -> Result<Number> {
    let mut formats = file.numbers(directory, tag::FORMAT, MAX_SAMPLES);
    formats.dedup();
    match formats[..] {
        [] | [1 | 4] => Ok(Number::Unsigned),
        [3] => Ok(Number::Float),
        // Of L*a*b*, a and b are signed without saying so; some writers do say it.
        [1 | 2, ..] if matches!(file.number_of(directory, tag::PHOTOMETRIC), Some(8)) => Ok(Number::Unsigned),
        [2] => Err(Tiff.meaningless("signed samples, of which nothing says what is black and white")),
        [_] => Err(Tiff.meaningless("complex samples")),
        _ => Err(Tiff.meaningless("samples of different kinds")),
    }
}

/// Which samples of a pixel are used, colours first; and whether the last of them is opacity, and premultiplied.
fn used_of(file: &mut File, directory: &Directory, meaning: Meaning, samples: usize) -> Result<(Vec<usize>, Option<bool>)> {
    let colours = match meaning {
        Meaning::WhiteIsZero | Meaning::BlackIsZero | Meaning::Palette => 1,
        Meaning::Cmyk => 4,
        _ => 3,
    };
    if samples < colours {
        return Err(Tiff.damaged(&format!("a pixel has {samples} samples, but its colours need {colours}")));
    }
    let mut used: Vec<usize> = (0..colours).collect();
    let extra = file.numbers(directory, tag::EXTRA, MAX_SAMPLES);
    let alpha = if directory.has(tag::EXTRA) {
        extra.iter().position(|kind| matches!(kind, 1 | 2)).map(|at| (colours + at, extra[at] == 1))
    } else {
        // One more sample than the colours need, and nothing said of it: opacity, as programs take it.
        (samples == colours + 1).then_some((colours, false))
    };
    let Some((at, premultiplied)) = alpha.filter(|(at, _)| *at < samples) else { return Ok((used, None)) };
    used.push(at);
    Ok((used, Some(premultiplied)))
}

/// What is made of the tags for the canvas.
fn opened(file: &mut File, directory: &Directory, image: &Image, alpha: Option<bool>) -> Result<Opened> {
    let exif = Exif::of_directory(file, directory);
    let model = match image.meaning {
        Meaning::WhiteIsZero | Meaning::BlackIsZero => Model::Grey,
        Meaning::Cmyk => Model::Cmyk,
        _ => Model::Rgb,
    };
    let profile = file.bytes(directory, tag::PROFILE).filter(|_| !matches!(image.meaning, Meaning::Lab { .. }));
    let colours = match profile {
        Some(profile) if profile.len() > PROFILE_BYTES => {
            return Err(Tiff.large_profile(profile.len()));
        }
        Some(profile) => Colours::of_icc(&profile),
        None if exif.adobe_rgb && image.meaning == Meaning::Rgb => Colours::adobe_rgb(),
        None => Colours::Srgb,
    };
    let stored = Stored {
        width: image.width,
        height: image.height,
        model,
        alpha: alpha.is_some(),
        premultiplied: alpha == Some(true),
        orientation: exif.orientation,
    };
    Ok(Opened { stored, colours, depth: image.depth() })
}

impl Image {
    /// The depth of the samples that the canvas gets.
    fn depth(&self) -> Depth {
        match (self.meaning, self.number, self.bits) {
            (Meaning::Palette, ..) if self.used.len() == 1 => Depth::U8,
            (Meaning::Palette | Meaning::Lab { .. }, ..) | (_, Number::Float, _) | (_, _, 17..) => Depth::F32,
            (_, _, 1 | 2 | 4 | 8) => Depth::U8,
            _ => Depth::U16,
        }
    }

    /// Samples of a pixel that a chunk has.
    fn samples_of_chunk(&self) -> usize {
        if self.planar { 1 } else { self.samples }
    }

    /// Makes several strips of each that is not compressed: those of one strip need not be in memory whole then.
    fn split(&mut self) {
        let rows = (AT_ONCE / self.bytes_of_rows(1).max(1)).max(1).next_multiple_of(4);
        let high = self.chunk[1];
        if self.compression != Compression::None || high <= rows {
            return;
        }
        let strips = self.height.div_ceil(high);
        let planes = if self.planar { self.samples } else { 1 };
        if !high.is_multiple_of(rows) && strips > 1 {
            return;
        }
        let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
        for strip in 0..strips * planes {
            let Some(&offset) = self.offsets.get(strip) else { break };
            let length = self.lengths.get(strip).copied().filter(|length| *length > 0).unwrap_or(u64::MAX);
            let height = high.min(self.height - strip % strips * high);
            for row in (0..height).step_by(rows) {
                let before = self.bytes_of_rows(row) as u64;
                let here = length.saturating_sub(before);
                // What a strip does not have is nowhere.
                offsets.push(if here > 0 { offset.saturating_add(before) } else { u64::MAX });
                lengths.push(here.clamp(1, self.bytes_of_rows(rows.min(height - row)) as u64));
            }
        }
        (self.offsets, self.lengths, self.chunk[1]) = (offsets, lengths, rows);
    }

    /// Bytes of so many rows of a chunk.
    fn bytes_of_rows(&self, rows: usize) -> usize {
        let [h, v] = self.ycc.subsampling;
        if self.ycc.subsampling != [1, 1] {
            return rows.div_ceil(v).saturating_mul(self.chunk[0].div_ceil(h) * (h * v + 2));
        }
        rows.saturating_mul((self.chunk[0] * self.samples_of_chunk() * self.bits).div_ceil(8))
    }
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

/// Samples for the canvas of the bytes of rows, one plane or several.
fn samples_of(image: &Image, planes: &mut [Vec<u8>], rows: usize, width: usize) -> Owned {
    if image.ycc.subsampling != [1, 1] {
        return Owned::U8(upsampled(image, &planes[0], rows, width));
    }
    let row_bytes = image.bytes_of_rows(1);
    let stride = image.samples_of_chunk();
    let planes: Vec<Owned> = planes
        .iter_mut()
        .map(|bytes| {
            if bytes.is_empty() {
                return Owned::U8(Vec::new());
            }
            bytes.chunks_exact_mut(row_bytes).take(rows).for_each(|row| unpredict(image, row, stride));
            numbers(image, bytes, row_bytes, rows, width * stride)
        })
        .collect();
    let picked = if image.planar {
        interleaved(&planes, &image.used)
    } else {
        picked(planes.into_iter().next().unwrap_or(Owned::U8(Vec::new())), image.samples, &image.used)
    };
    meant(image, picked)
}

/// Undoes the predictor of a row (TIFF 6.0, section 14, and Technical Note 3); `stride` samples a pixel.
fn unpredict(image: &Image, row: &mut [u8], stride: usize) {
    let bytes = image.bits / 8;
    match image.predictor {
        2 => {
            let back = stride * bytes;
            let is_big = image.big_endian;
            let number = |at: &[u8]| {
                let mut wide = [0; 8];
                if is_big {
                    wide[8 - bytes..].copy_from_slice(at);
                    u64::from_be_bytes(wide)
                } else {
                    wide[..bytes].copy_from_slice(at);
                    u64::from_le_bytes(wide)
                }
            };
            for at in (back..row.len().saturating_sub(bytes - 1)).step_by(bytes) {
                if bytes == 1 {
                    row[at] = row[at].wrapping_add(row[at - back]);
                    continue;
                }
                let sum = number(&row[at..at + bytes]).wrapping_add(number(&row[at - back..at - back + bytes]));
                if is_big {
                    row[at..at + bytes].copy_from_slice(&sum.to_be_bytes()[8 - bytes..]);
                } else {
                    row[at..at + bytes].copy_from_slice(&sum.to_le_bytes()[..bytes]);
                }
            }
        }
        3 => {
            for at in stride..row.len() {
                row[at] = row[at].wrapping_add(row[at - stride]);
            }
            let count = row.len() / bytes;
            let split = row.to_vec();
            for i in 0..count {
                for byte in 0..bytes {
                    // The high bytes of all samples come first.
                    let target = if image.big_endian { byte } else { bytes - 1 - byte };
                    row[i * bytes + target] = split[byte * count + i];
                }
            }
        }
        _ => {}
    }
}

/// The numbers of rows: indices and L*a*b* as they are stored, others as shares of the largest value.
fn numbers(image: &Image, bytes: &[u8], row_bytes: usize, rows: usize, wanted: usize) -> Owned {
    let rows = || bytes.chunks_exact(row_bytes).take(rows);
    let is_big = image.big_endian;
    let wide = |b: &[u8]| if is_big { u16::from_be_bytes([b[0], b[1]]) } else { u16::from_le_bytes([b[0], b[1]]) };
    let four = |b: &[u8]| {
        let b = [b[0], b[1], b[2], b[3]];
        if is_big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) }
    };
    let as_stored = matches!(image.meaning, Meaning::Palette);
    match (image.number, image.bits) {
        (Number::Unsigned, 8) => Owned::U8(rows().flat_map(|row| row[..wanted].iter().copied()).collect()),
        (Number::Unsigned, 16) => Owned::U16(rows().flat_map(|row| row.chunks_exact(2).take(wanted).map(wide)).collect()),
        (Number::Unsigned, 32) => {
            let share = |b: &[u8]| (f64::from(four(b)) / f64::from(u32::MAX)) as f32;
            Owned::F32(rows().flat_map(|row| row.chunks_exact(4).take(wanted).map(share)).collect())
        }
        (Number::Float, 16) => {
            Owned::F32(rows().flat_map(|row| row.chunks_exact(2).take(wanted).map(|b| f16::from_bits(wide(b)).to_f32())).collect())
        }
        (Number::Float, 32) => {
            Owned::F32(rows().flat_map(|row| row.chunks_exact(4).take(wanted).map(|b| f32::from_bits(four(b)))).collect())
        }
        (Number::Float, _) => {
            let eight = |b: &[u8]| {
                let mut wide = [0; 8];
                wide.copy_from_slice(b);
                (if is_big { f64::from_be_bytes(wide) } else { f64::from_le_bytes(wide) }) as f32
            };
            Owned::F32(rows().flat_map(|row| row.chunks_exact(8).take(wanted).map(eight)).collect())
        }
        (Number::Unsigned, bits) => {
            let largest = (1u64 << bits) - 1;
            let packed = rows().flat_map(|row| BitsOf { row, bits, at: 0 }.take(wanted));
            match bits {
                _ if as_stored => Owned::U16(packed.map(|v| v as u16).collect()),
                1..=4 if 255 % largest == 0 => Owned::U8(packed.map(|v| (v * 255 / largest) as u8).collect()),
                1..=15 => Owned::U16(packed.map(|v| ((v * 65_535 + largest / 2) / largest) as u16).collect()),
                _ => Owned::F32(packed.map(|v| (v as f64 / largest as f64) as f32).collect()),
            }
        }
    }
}

/// Numbers of any count of bits, high bits first.
struct BitsOf<'a> {
    row: &'a [u8],
    bits: usize,
    at: usize,
}

impl Iterator for BitsOf<'_> {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        if self.at + self.bits > 8 * self.row.len() {
            return None;
        }
        let mut value = 0;
        let mut left = self.bits;
        while left > 0 {
            let free = 8 - self.at % 8;
            let taken = free.min(left);
            let byte = u64::from(self.row[self.at / 8]) >> (free - taken) & ((1 << taken) - 1);
            value = value << taken | byte;
            self.at += taken;
            left -= taken;
        }
        Some(value)
    }
}

/// The used samples of pixels that have more.
fn picked(samples: Owned, stride: usize, used: &[usize]) -> Owned {
    fn of<T: Copy>(values: Vec<T>, stride: usize, used: &[usize]) -> Vec<T> {
        if used.len() == stride {
            return values;
        }
        values.chunks_exact(stride).flat_map(|pixel| used.iter().map(|at| pixel[*at])).collect()
    }
    match samples {
        Owned::U8(values) => Owned::U8(of(values, stride, used)),
        Owned::U16(values) => Owned::U16(of(values, stride, used)),
        Owned::F32(values) => Owned::F32(of(values, stride, used)),
    }
}

/// The samples of planes, interleaved.
fn interleaved(planes: &[Owned], used: &[usize]) -> Owned {
    fn of<T: Copy>(planes: Vec<&[T]>) -> Vec<T> {
        let count = planes.iter().map(|plane| plane.len()).min().unwrap_or(0);
        (0..count).flat_map(|i| planes.iter().map(move |plane| plane[i])).collect()
    }
    match &planes[used[0]] {
        Owned::U8(_) => Owned::U8(of(used
            .iter()
            .filter_map(|at| if let Owned::U8(values) = &planes[*at] { Some(&values[..]) } else { None })
            .collect())),
        Owned::U16(_) => Owned::U16(of(used
            .iter()
            .filter_map(|at| if let Owned::U16(values) = &planes[*at] { Some(&values[..]) } else { None })
            .collect())),
        Owned::F32(_) => Owned::F32(of(used
            .iter()
            .filter_map(|at| if let Owned::F32(values) = &planes[*at] { Some(&values[..]) } else { None })
            .collect())),
    }
}

/// Samples as the canvas takes them.
fn meant(image: &Image, samples: Owned) -> Owned {
    let channels = image.used.len();
    match image.meaning {
        Meaning::BlackIsZero | Meaning::Rgb | Meaning::Cmyk => samples,
        Meaning::WhiteIsZero => match samples {
            Owned::U8(mut values) => {
                values.iter_mut().step_by(channels).for_each(|v| *v = 255 - *v);
                Owned::U8(values)
            }
            Owned::U16(mut values) => {
                values.iter_mut().step_by(channels).for_each(|v| *v = 65_535 - *v);
                Owned::U16(values)
            }
            Owned::F32(mut values) => {
                values.iter_mut().step_by(channels).for_each(|v| *v = 1.0 - *v);
                Owned::F32(values)
            }
        },
        Meaning::Palette => coloured(image, samples),
        // JPEG has made colours of it.
        Meaning::Ycc if image.compression == Compression::Jpeg => samples,
        Meaning::Ycc => match samples {
            Owned::U8(mut values) => {
                for pixel in values.chunks_exact_mut(channels) {
                    let colour = colour_of(&image.ycc, pixel[0], pixel[1], pixel[2]);
                    pixel[..3].copy_from_slice(&colour);
                }
                Owned::U8(values)
            }
            other => other,
        },
        Meaning::Lab { signed } => from_lab(samples, channels, signed),
    }
}

/// Colours of indices, and their opacity where there is one.
fn coloured(image: &Image, samples: Owned) -> Owned {
    let channels = image.used.len();
    let indices: Vec<usize> = match samples {
        Owned::U8(values) => values.into_iter().map(usize::from).collect(),
        Owned::U16(values) => values.into_iter().map(usize::from).collect(),
        Owned::F32(_) => return samples,
    };
    let size = 1 << image.bits;
    // 16 bits an entry; some writers store 8.
    let shift = if image.palette.iter().any(|v| *v > 255) { 8 } else { 0 };
    let colour = |index: usize| [0, 1, 2].map(|plane| (image.palette[plane * size + index.min(size - 1)] >> shift) as u8);
    if channels == 1 {
        return Owned::U8(indices.into_iter().flat_map(colour).collect());
    }
    let largest = (size - 1) as f32;
    let with_opacity = |pixel: &[usize]| {
        let [red, green, blue] = colour(pixel[0]).map(|v| f32::from(v) / 255.0);
        [red, green, blue, pixel[1] as f32 / largest]
    };
    Owned::F32(indices.chunks_exact(2).flat_map(with_opacity).collect())
}

/// Colours of luma and chroma that are stored in units of several pixels, each with one chroma.
fn upsampled(image: &Image, bytes: &[u8], rows: usize, width: usize) -> Vec<u8> {
    let [h, v] = image.ycc.subsampling;
    let across = image.chunk[0].div_ceil(h);
    let size = h * v + 2;
    let mut colours = Vec::with_capacity(3 * rows * width);
    for y in 0..rows {
        for x in 0..width {
            let unit = &bytes[(y / v * across + x / h) * size..][..size];
            colours.extend(colour_of(&image.ycc, unit[y % v * h + x % h], unit[size - 2], unit[size - 1]));
        }
    }
    colours
}

fn colour_of(ycc: &Ycc, luma: u8, blue: u8, red: u8) -> [u8; 3] {
    let Ycc { coefficients: [of_red, of_green, of_blue], reference, .. } = ycc;
    let scaled = |value: u8, black: f64, white: f64, range: f64| (f64::from(value) - black) * range / (white - black);
    let y = scaled(luma, reference[0], reference[1], 255.0);
    let cb = scaled(blue, reference[2], reference[3], 127.0);
    let cr = scaled(red, reference[4], reference[5], 127.0);
    let r = cr * (2.0 - 2.0 * of_red) + y;
    let b = cb * (2.0 - 2.0 * of_blue) + y;
    let g = (y - of_blue * b - of_red * r) / of_green;
    [r, g, b].map(|v| (v + 0.5).clamp(0.0, 255.0) as u8)
}

/// sRGB of CIE L*a*b* under D50 (CIE 15; Bradford's adaptation to D65).
fn from_lab(samples: Owned, channels: usize, signed: bool) -> Owned {
    let (values, unit): (Vec<f64>, f64) = match samples {
        Owned::U8(values) => (values.into_iter().map(f64::from).collect(), 1.0),
        Owned::U16(values) => (values.into_iter().map(f64::from).collect(), 256.0),
        Owned::F32(_) => return samples,
    };
    let (half, range) = (128.0 * unit, 256.0 * unit);
    let chroma = |v: f64| {
        if signed { (if v >= half { v - range } else { v }) / unit } else { (v - half) / unit }
    };
    // White is the whole range, or, as profiles of version 2 have it, what 255 is in 16 bits.
    let white = if signed { range - 1.0 } else { 255.0 * unit };
    let colour = |pixel: &[f64]| {
        let [l, a, b] = [pixel[0] / white * 100.0, chroma(pixel[1]), chroma(pixel[2])];
        let fy = (l + 16.0) / 116.0;
        let inverse = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { 3.0 * (6.0 / 29.0) * (6.0 / 29.0) * (f - 4.0 / 29.0) };
        let [x, y, z] = [0.964_22 * inverse(fy + a / 500.0), inverse(fy), 0.825_21 * inverse(fy - b / 200.0)];
        let light = [
            3.133_856_1 * x - 1.616_866_7 * y - 0.490_614_6 * z,
            -0.978_768_4 * x + 1.916_141_5 * y + 0.033_454_0 * z,
            0.071_945_3 * x - 0.228_991_4 * y + 1.405_242_7 * z,
        ];
        light.map(|v| {
            let v = v.clamp(0.0, 1.0);
            (if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 }) as f32
        })
    };
    let opacity = |pixel: &[f64]| pixel.get(3).map(|v| (v / (range - 1.0)) as f32);
    Owned::F32(values.chunks_exact(channels).flat_map(|pixel| colour(pixel).into_iter().chain(opacity(pixel))).collect())
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
