//! Samples of a TIFF: in, the bytes of unpacked rows and what the tags say of them; out, samples for the canvas.

use half::f16;

use super::stored::Owned;
use super::tags::{Image, Meaning, Number, Ycc};
use super::unpack::Compression;

/// Samples for the canvas of the bytes of rows, one plane or several.
pub(super) fn samples_of(image: &Image, planes: &mut [Vec<u8>], rows: usize, width: usize) -> Owned {
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
        // JPEG has made colours of it, where it had all three.
        Meaning::Ycc if image.compression == Compression::Jpeg && !image.planar => samples,
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
