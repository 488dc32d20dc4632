//! What the tags of a TIFF say: in, its directories; out, which image is read, and what its samples mean.

use super::colour::Colours;
use super::directory::{Directory, Tagged};
use super::exif::Exif;
use super::job::{Opened, Source};
use super::kinds::Container::Tiff;
use super::stored::{Depth, Model, Stored};
use super::unpack::Compression;
use crate::base::{Error, Result};
use crate::photo::MAX_SIDE;

/// Images of a file that are looked at.
const MAX_IMAGES: usize = 256;

/// Samples of a pixel at most.
const MAX_SAMPLES: usize = 1024;

/// Bytes that are unpacked at once, about.
pub(super) const AT_ONCE: usize = 1 << 20;

/// Bytes of a row of a strip or tile at most: it is unpacked whole. Real ones have a hundredth.
const MAX_ROW_BYTES: u64 = 64 << 20;

pub(super) mod tag {
    pub(in crate::decoding) const SUBFILE: u16 = 254;
    pub(in crate::decoding) const OLD_SUBFILE: u16 = 255;
    pub(in crate::decoding) const WIDTH: u16 = 256;
    pub(in crate::decoding) const HEIGHT: u16 = 257;
    pub(in crate::decoding) const BITS: u16 = 258;
    pub(in crate::decoding) const COMPRESSION: u16 = 259;
    pub(in crate::decoding) const PHOTOMETRIC: u16 = 262;
    pub(in crate::decoding) const FILL_ORDER: u16 = 266;
    pub(in crate::decoding) const STRIP_OFFSETS: u16 = 273;
    pub(in crate::decoding) const SAMPLES: u16 = 277;
    pub(in crate::decoding) const ROWS_PER_STRIP: u16 = 278;
    pub(in crate::decoding) const STRIP_BYTES: u16 = 279;
    pub(in crate::decoding) const PLANAR: u16 = 284;
    pub(in crate::decoding) const T4_OPTIONS: u16 = 292;
    pub(in crate::decoding) const PREDICTOR: u16 = 317;
    pub(in crate::decoding) const PALETTE: u16 = 320;
    pub(in crate::decoding) const TILE_WIDTH: u16 = 322;
    pub(in crate::decoding) const TILE_HEIGHT: u16 = 323;
    pub(in crate::decoding) const TILE_OFFSETS: u16 = 324;
    pub(in crate::decoding) const TILE_BYTES: u16 = 325;
    pub(in crate::decoding) const SUB_IFDS: u16 = 330;
    pub(in crate::decoding) const INK_SET: u16 = 332;
    pub(in crate::decoding) const EXTRA: u16 = 338;
    pub(in crate::decoding) const FORMAT: u16 = 339;
    pub(in crate::decoding) const JPEG_TABLES: u16 = 347;
    pub(in crate::decoding) const COEFFICIENTS: u16 = 529;
    pub(in crate::decoding) const SUBSAMPLING: u16 = 530;
    pub(in crate::decoding) const REFERENCE: u16 = 532;
    pub(in crate::decoding) const PROFILE: u16 = 34_675;
    pub(in crate::decoding) const DNG_VERSION: u16 = 50_706;
}

/// What the samples of a pixel mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
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
pub(super) enum Number {
    Unsigned,
    Float,
}

/// What the tags of an image say.
pub(super) struct Image {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) meaning: Meaning,
    pub(super) number: Number,
    pub(super) bits: usize,
    /// Samples of a pixel, and which of them are used: colours, then opacity.
    pub(super) samples: usize,
    pub(super) used: Vec<usize>,
    pub(super) compression: Compression,
    pub(super) predictor: u64,
    pub(super) lsb_first: bool,
    pub(super) big_endian: bool,
    pub(super) planar: bool,
    /// Width and height of a tile, or of a strip.
    pub(super) chunk: [usize; 2],
    pub(super) offsets: Vec<u64>,
    pub(super) lengths: Vec<u64>,
    pub(super) palette: Vec<u64>,
    pub(super) tables: Option<Vec<u8>>,
    pub(super) ycc: Ycc,
}

/// How luma and chroma make colours (TIFF 6.0, section 21).
pub(super) struct Ycc {
    pub(super) subsampling: [usize; 2],
    pub(super) coefficients: [f64; 3],
    pub(super) reference: [f64; 6],
}

/// A TIFF.
pub(super) type File<'a> = Tagged<&'a mut dyn Source>;

/// The directory of the image that is read: the largest that is no thumbnail and no mask.
pub(super) fn chosen(file: &mut File, first: u64) -> Result<Directory> {
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
pub(super) fn image_of(file: &mut File, directory: &Directory) -> Result<(Image, Option<bool>)> {
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
    let is_subsampled = if planar { meaning == Meaning::Ycc && subsampling != [1, 1] } else { ycc.subsampling != [1, 1] };
    if is_subsampled && (planar || samples != 3) {
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
pub(super) fn opened(file: &mut File, directory: &Directory, image: &Image, alpha: Option<bool>) -> Result<Opened> {
    let exif = Exif::of_directory(file, directory);
    let model = match image.meaning {
        Meaning::WhiteIsZero | Meaning::BlackIsZero => Model::Grey,
        Meaning::Cmyk => Model::Cmyk,
        _ => Model::Rgb,
    };
    let profile = file.bytes(directory, tag::PROFILE).filter(|_| !matches!(image.meaning, Meaning::Lab { .. }));
    let marked = exif.adobe_rgb && image.meaning == Meaning::Rgb;
    let colours = Colours::of_file(Tiff, profile.as_deref(), marked)?;
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
    pub(super) fn samples_of_chunk(&self) -> usize {
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
    pub(super) fn bytes_of_rows(&self, rows: usize) -> usize {
        let [h, v] = self.ycc.subsampling;
        if self.ycc.subsampling != [1, 1] {
            return rows.div_ceil(v).saturating_mul(self.chunk[0].div_ceil(h) * (h * v + 2));
        }
        rows.saturating_mul((self.chunk[0] * self.samples_of_chunk() * self.bits).div_ceil(8))
    }
}
