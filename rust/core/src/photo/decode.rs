//! Decoding: from the bytes of an image file to its luma.
//!
//! The format is told from the content, never from a name: PNG, JPEG, TIFF or WebP, by the `image` crate. What the file says
//! about its pixels is obeyed: the EXIF orientation is applied, an embedded colour profile is converted to sRGB (by `moxcms`),
//! samples keep their 8 or 16 bits until [`super::tone::luma`] weighs them. Of an animation, the first frame is read.
//! What this module does not do: open files (the caller has the path and puts it in front of the message), CMYK profiles
//! (those pixels are converted by the format's plain rule), and find damage inside a JPEG's pictures that the decoder can
//! paint over, as browsers do; a JPEG that is cut short is found.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use moxcms::{ColorProfile, DataColorSpace, Layout, TransformExecutor, TransformOptions};

use crate::base::{Error, Result};
use crate::photo::field::{Field, MAX_SIDE};
use crate::photo::tone::{Pixels, Samples, luma};

/// The most pixels that a file may hold. Cameras and phones make up to 200 million; more is a scanner's or a decompression
/// bomb's, a few kilobytes that unpack to a memory full of pixels. The luma field alone takes 4 bytes a pixel.
const MAX_PIXELS: u64 = 250_000_000;

/// The most memory that a decoder may take: 8 bytes a pixel (16-bit RGB and alpha) of the largest image, and a little for its
/// own buffers.
const MAX_DECODED_BYTES: u64 = 8 * MAX_PIXELS + (64 << 20);

/// By how much, of 255, a colour profile may differ from sRGB and still be taken for it. The many sRGB profiles in use differ
/// by their rounding, up to 2 in the darks; converting those would cost time and change nothing that can be seen.
const SAME_AS_SRGB: u8 = 2;

/// The luma of an image file, upright, composited on `background` (8-bit sRGB) where it is transparent.
///
/// Float samples (TIFF) are taken as sRGB-encoded, and clipped to [0, 1].
///
/// # Errors
/// [`Error::Decode`] if the bytes are not a complete image of a format and size that is read, [`Error::Input`] if a float
/// sample is not a number.
pub fn decode(bytes: &[u8], background: [u8; 3]) -> Result<Field> {
    let mut image = read(bytes)?;
    if let DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) = image {
        clip(&mut image);
    }
    let (samples, channels) = match &image {
        DynamicImage::ImageLuma8(i) => (Samples::U8(i), 1),
        DynamicImage::ImageLumaA8(i) => (Samples::U8(i), 2),
        DynamicImage::ImageRgb8(i) => (Samples::U8(i), 3),
        DynamicImage::ImageRgba8(i) => (Samples::U8(i), 4),
        DynamicImage::ImageLuma16(i) => (Samples::U16(i), 1),
        DynamicImage::ImageLumaA16(i) => (Samples::U16(i), 2),
        DynamicImage::ImageRgb16(i) => (Samples::U16(i), 3),
        DynamicImage::ImageRgba16(i) => (Samples::U16(i), 4),
        DynamicImage::ImageRgb32F(i) => (Samples::F32(i), 3),
        DynamicImage::ImageRgba32F(i) => (Samples::F32(i), 4),
        other => return Err(Error::Decode(format!("pixels of type {:?} are not supported", other.color()))),
    };
    let (width, height) = (image.width() as usize, image.height() as usize);
    luma(&Pixels { width, height, channels, samples }, background)
}

/// The pixels of an image file, upright and in sRGB.
fn read(bytes: &[u8]) -> Result<DynamicImage> {
    if bytes.is_empty() {
        return Err(Error::Decode("the file is empty".into()));
    }
    let (format, name) = match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => (ImageFormat::Png, "PNG"),
        Ok(ImageFormat::Jpeg) => (ImageFormat::Jpeg, "JPEG"),
        Ok(ImageFormat::Tiff) => (ImageFormat::Tiff, "TIFF"),
        Ok(ImageFormat::WebP) => (ImageFormat::WebP, "WebP"),
        _ => return Err(Error::Decode("the file is not an image in a format that is read: PNG, JPEG, TIFF or WebP".into())),
    };
    // The decoder paints what is missing of a JPEG grey, and reports success.
    if format == ImageFormat::Jpeg && !jpeg_has_an_end(bytes) {
        return Err(Error::Decode("the JPEG file is cut short: its end is missing".into()));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|error| explain(name, &error))?;

    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(Error::Decode(format!("the image is {width} x {height} pixels, so there is nothing to draw")));
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS || decoder.total_bytes() > MAX_DECODED_BYTES {
        return Err(Error::Decode(format!(
            "the image is too large: {width} x {height} pixels, but at most {} million pixels are read",
            MAX_PIXELS / 1_000_000
        )));
    }
    // Broken metadata is no reason to refuse a picture: it is shown as it is stored.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let profile = decoder.icc_profile().ok().flatten();
    let mut image = DynamicImage::from_decoder(decoder).map_err(|error| explain(name, &error))?;
    if let Some(profile) = profile {
        convert_to_srgb(&mut image, &profile);
    }
    image.apply_orientation(orientation);
    Ok(image)
}

/// The decoder's error as one sentence for the user.
fn explain(name: &str, error: &ImageError) -> Error {
    // The source is the format's own message; the error itself repeats the format around it.
    let detail = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
    let detail = detail.lines().next().unwrap_or_default().trim_end_matches('.');
    Error::Decode(match error {
        ImageError::Limits(_) => format!(
            "the image is too large: at most {MAX_SIDE} pixels a side and {} million pixels are read",
            MAX_PIXELS / 1_000_000
        ),
        ImageError::Unsupported(_) => format!("the {name} file uses a feature that is not supported ({error})"),
        _ => format!("the {name} file is damaged or cut short ({detail})"),
    })
}

/// Whether a JPEG's segments lead to its end-of-image marker. Looking for that marker alone would not do: embedded thumbnails
/// have their own, inside a segment.
fn jpeg_has_an_end(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    // Between segments, and in the coded data, everything up to the next 0xFF is skipped.
    while let Some(at) = rest.iter().position(|b| *b == 0xFF) {
        rest = &rest[at + 1..];
        match rest {
            [0xD9, ..] => return true,
            // A fill byte: the next 0xFF may begin the marker.
            [0xFF, ..] => {}
            // An escaped 0xFF of the coded data, or a marker without a segment (TEM, restart, start of image).
            [0x00 | 0x01 | 0xD0..=0xD8, after @ ..] => rest = after,
            [_, high, low, ..] => {
                let length = usize::from(u16::from_be_bytes([*high, *low]));
                rest = rest.get(1 + length..).unwrap_or_default();
            }
            _ => return false,
        }
    }
    false
}

/// Clips float samples to [0, 1]; a NaN stays, for [`luma`] to name its place.
fn clip(image: &mut DynamicImage) {
    let samples: &mut [f32] = match image {
        DynamicImage::ImageRgb32F(i) => i,
        DynamicImage::ImageRgba32F(i) => i,
        _ => return,
    };
    for sample in samples {
        *sample = sample.clamp(0.0, 1.0);
    }
}

/// Converts 8-bit and 16-bit pixels from an embedded colour profile to sRGB. A profile that is broken, that is sRGB, or that
/// is not for these pixels, changes nothing.
///
/// moxcms chooses its arithmetic by the processor, so a converted photo may differ by one step of 255 between kinds of machines.
fn convert_to_srgb(image: &mut DynamicImage, profile: &[u8]) {
    let Ok(profile) = ColorProfile::new_from_slice(profile) else { return };
    let grey = match (profile.color_space, image.color().has_color()) {
        (DataColorSpace::Rgb, true) => false,
        (DataColorSpace::Gray, false) => true,
        _ => return,
    };
    if is_srgb(&profile, grey) {
        return;
    }
    let srgb = ColorProfile::new_srgb();
    let options = TransformOptions::default();
    let row = image.width() as usize;
    match image {
        DynamicImage::ImageRgb8(i) => {
            if let Ok(t) = profile.create_transform_8bit(Layout::Rgb, &srgb, Layout::Rgb, options) {
                convert_rows(&*t, i, row * 3);
            }
        }
        DynamicImage::ImageRgba8(i) => {
            if let Ok(t) = profile.create_transform_8bit(Layout::Rgba, &srgb, Layout::Rgba, options) {
                convert_rows(&*t, i, row * 4);
            }
        }
        DynamicImage::ImageRgb16(i) => {
            if let Ok(t) = profile.create_transform_16bit(Layout::Rgb, &srgb, Layout::Rgb, options) {
                convert_rows(&*t, i, row * 3);
            }
        }
        DynamicImage::ImageRgba16(i) => {
            if let Ok(t) = profile.create_transform_16bit(Layout::Rgba, &srgb, Layout::Rgba, options) {
                convert_rows(&*t, i, row * 4);
            }
        }
        DynamicImage::ImageLuma8(i) => convert_grey_8(&profile, i, 1),
        DynamicImage::ImageLumaA8(i) => convert_grey_8(&profile, i, 2),
        DynamicImage::ImageLuma16(i) => convert_grey_16(&profile, i, 1),
        DynamicImage::ImageLumaA16(i) => convert_grey_16(&profile, i, 2),
        _ => {}
    }
}

/// Converts row by row, through a copy of one row.
fn convert_rows<T: Copy + Default>(transform: &(impl TransformExecutor<T> + ?Sized), samples: &mut [T], row: usize) {
    let mut copy = vec![T::default(); row];
    for target in samples.chunks_exact_mut(row) {
        copy.copy_from_slice(target);
        if transform.transform(&copy, target).is_err() {
            // The lengths are right, so the transform refuses the first row already, or none.
            target.copy_from_slice(&copy);
            return;
        }
    }
}

/// What the profile makes of every grey level, in sRGB; `None` if it makes nothing of them.
fn grey_ramp_8(profile: &ColorProfile) -> Option<Vec<u8>> {
    let ramp: Vec<u8> = (0..=u8::MAX).collect();
    let mut colours = vec![0u8; 3 * ramp.len()];
    let srgb = ColorProfile::new_srgb();
    let transform = profile.create_transform_8bit(Layout::Gray, &srgb, Layout::Rgb, TransformOptions::default()).ok()?;
    transform.transform(&ramp, &mut colours).ok()?;
    Some(colours.chunks_exact(3).map(|c| c[1]).collect())
}

fn convert_grey_8(profile: &ColorProfile, samples: &mut [u8], channels: usize) {
    let Some(ramp) = grey_ramp_8(profile) else { return };
    for pixel in samples.chunks_exact_mut(channels) {
        pixel[0] = ramp[usize::from(pixel[0])];
    }
}

fn convert_grey_16(profile: &ColorProfile, samples: &mut [u16], channels: usize) {
    let ramp: Vec<u16> = (0..=u16::MAX).collect();
    let mut colours = vec![0u16; 3 * ramp.len()];
    let srgb = ColorProfile::new_srgb();
    let Ok(transform) = profile.create_transform_16bit(Layout::Gray, &srgb, Layout::Rgb, TransformOptions::default()) else {
        return;
    };
    if transform.transform(&ramp, &mut colours).is_err() {
        return;
    }
    for pixel in samples.chunks_exact_mut(channels) {
        pixel[0] = colours[3 * usize::from(pixel[0]) + 1];
    }
}

/// Whether a profile leaves a cube of colours (or every grey level) as it is, up to [`SAME_AS_SRGB`]: profiles are told by
/// what they do, since their names are many.
fn is_srgb(profile: &ColorProfile, grey: bool) -> bool {
    if grey {
        return grey_ramp_8(profile).is_none_or(|ramp| ramp.iter().zip(0u8..).all(|(a, b)| a.abs_diff(b) <= SAME_AS_SRGB));
    }
    const LEVELS: [u8; 10] = [0, 8, 32, 64, 96, 128, 160, 192, 224, 255];
    let cube: Vec<u8> = (0..1000).flat_map(|i| [i / 100, i / 10 % 10, i % 10].map(|level| LEVELS[level])).collect();
    let mut converted = vec![0u8; cube.len()];
    let srgb = ColorProfile::new_srgb();
    match profile.create_transform_8bit(Layout::Rgb, &srgb, Layout::Rgb, TransformOptions::default()) {
        Ok(t) if t.transform(&cube, &mut converted).is_ok() => {
            cube.iter().zip(&converted).all(|(a, b)| a.abs_diff(*b) <= SAME_AS_SRGB)
        }
        // A profile that cannot be used is ignored.
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::tone::luma_to_u8;
    use image::{GrayImage, ImageBuffer, ImageEncoder, Luma, LumaA, Rgb, Rgb32FImage, RgbImage, RgbaImage};

    const WHITE: [u8; 3] = [255; 3];
    const FORMATS: [ImageFormat; 4] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::WebP];

    fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// A smooth colour picture, so that JPEG stays near it.
    fn photo(width: u32, height: u32) -> RgbImage {
        RgbImage::from_fn(width, height, |x, y| Rgb([(x * 255 / width) as u8, (y * 255 / height) as u8, 90]))
    }

    fn message(bytes: &[u8]) -> String {
        match decode(bytes, WHITE).unwrap_err() {
            Error::Decode(message) => message,
            other => panic!("not a decode error: {other}"),
        }
    }

    #[test]
    fn each_format_is_told_from_its_content() {
        let photo = photo(60, 40);
        let exact = decode(&encode(photo.clone(), ImageFormat::Png), WHITE).unwrap();
        assert_eq!((exact.width(), exact.height()), (60, 40));
        for (x, y, pixel) in photo.enumerate_pixels() {
            let [r, g, b] = pixel.0.map(f64::from);
            let expected = (299.0 * r + 587.0 * g + 114.0 * b) / 255_000.0;
            assert!((f64::from(exact.at(x as usize, y as usize)) - expected).abs() < 1e-7);
        }
        for format in [ImageFormat::Tiff, ImageFormat::WebP] {
            assert_eq!(decode(&encode(photo.clone(), format), WHITE).unwrap(), exact, "{format:?}");
        }
        let lossy = decode(&encode(photo, ImageFormat::Jpeg), WHITE).unwrap();
        for (a, b) in lossy.values().iter().zip(exact.values()) {
            assert!((a - b).abs() < 0.05);
        }
    }

    #[test]
    fn grey_comes_back_exactly_in_8_and_16_bits() {
        let grey: Vec<u8> = (0..=255).collect();
        let field = decode(&encode(GrayImage::from_raw(16, 16, grey.clone()).unwrap(), ImageFormat::Png), WHITE).unwrap();
        assert_eq!(luma_to_u8(&field), grey);

        let deep = ImageBuffer::<Luma<u16>, _>::from_fn(256, 2, |x, y| Luma([(x * 257 + y * 3) as u16]));
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            let field = decode(&encode(deep.clone(), format), WHITE).unwrap();
            for (x, y, pixel) in deep.enumerate_pixels() {
                assert_eq!(field.at(x as usize, y as usize), f32::from(pixel.0[0]) / 65_535.0);
            }
        }
    }

    #[test]
    fn transparency_shows_the_background() {
        let image = RgbaImage::from_raw(2, 1, vec![10, 20, 30, 0, 0, 0, 0, 255]).unwrap();
        for format in [ImageFormat::Png, ImageFormat::WebP, ImageFormat::Tiff] {
            let bytes = encode(image.clone(), format);
            assert_eq!(decode(&bytes, WHITE).unwrap().values(), [1.0, 0.0], "{format:?}");
            assert_eq!(decode(&bytes, [255, 0, 0]).unwrap().values(), [0.299, 0.0], "{format:?}");
        }
        let grey = ImageBuffer::<LumaA<u16>, _>::from_raw(1, 1, vec![0u16, 0]).unwrap();
        assert_eq!(decode(&encode(grey, ImageFormat::Png), WHITE).unwrap().values(), [1.0]);
    }

    #[test]
    fn float_samples_are_clipped_and_a_nan_is_named() {
        let tiff = |v: f32| encode(Rgb32FImage::from_raw(2, 1, vec![0.5, 0.5, 0.5, v, v, v]).unwrap(), ImageFormat::Tiff);
        assert_eq!(decode(&tiff(7.5), WHITE).unwrap().values(), [0.5, 1.0]);
        assert_eq!(decode(&tiff(-1.0), WHITE).unwrap().values(), [0.5, 0.0]);
        let error = decode(&tiff(f32::NAN), WHITE).unwrap_err().to_string();
        assert_eq!(error, "the value at column 1, row 0 is NaN, but it must be between 0 and 1");
    }

    /// A JPEG with an EXIF segment that holds nothing but the orientation.
    fn oriented(jpeg: &[u8], orientation: u8) -> Vec<u8> {
        let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
        exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
        let mut bytes = jpeg[..2].to_vec();
        bytes.extend([0xFF, 0xE1, 0, exif.len() as u8 + 2]);
        bytes.extend(exif);
        bytes.extend(&jpeg[2..]);
        bytes
    }

    #[test]
    fn the_exif_orientation_is_applied() {
        // Dark but for a bright top left quarter.
        let quarter = GrayImage::from_fn(32, 16, |x, y| Luma([if x < 16 && y < 8 { 255 } else { 0 }]));
        let jpeg = encode(quarter, ImageFormat::Jpeg);
        let plain = decode(&jpeg, WHITE).unwrap();
        assert_eq!(decode(&oriented(&jpeg, 1), WHITE).unwrap(), plain);
        // Where the bright quarter goes: (right, bottom), and whether the sides are swapped.
        let places = [
            (2, true, false, false),
            (3, true, true, false),
            (4, false, true, false),
            (5, false, false, true),
            (6, true, false, true),
            (7, true, true, true),
            (8, false, true, true),
        ];
        for (orientation, right, bottom, swapped) in places {
            let field = decode(&oriented(&jpeg, orientation), WHITE).unwrap();
            let (width, height) = (field.width(), field.height());
            assert_eq!((width, height), if swapped { (16, 32) } else { (32, 16) }, "{orientation}");
            for (column, at_right) in [(1, false), (width - 2, true)] {
                for (row, at_bottom) in [(1, false), (height - 2, true)] {
                    let bright = (at_right, at_bottom) == (right, bottom);
                    assert_eq!(field.at(column, row) > 0.5, bright, "{orientation} {column} {row}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_image_is_refused_in_one_sentence() {
        assert_eq!(message(b""), "the file is empty");
        let not_an_image = "the file is not an image in a format that is read: PNG, JPEG, TIFF or WebP";
        for bytes in [&b"hello world, this is text"[..], b"\0", b"GIF89a\x01\0\x01\0\0\0\0;", b"<svg/>", b"BM", b"%PDF-1.7"] {
            assert_eq!(message(bytes), not_an_image);
        }
    }

    #[test]
    fn files_cut_anywhere_are_errors_and_never_panics() {
        for format in FORMATS {
            let bytes = encode(photo(64, 48), format);
            let half = message(&bytes[..bytes.len() / 2]);
            assert!(half.contains("cut short") && !half.contains('\n'), "{format:?}: {half}");
            for end in 1..bytes.len() {
                let result = decode(&bytes[..end], WHITE);
                // The last bytes of PNG and TIFF hold nothing of the picture.
                assert!(result.is_err() || end > bytes.len() * 9 / 10, "{format:?} cut at {end} of {}", bytes.len());
            }
        }
        let jpeg = encode(photo(64, 48), ImageFormat::Jpeg);
        assert_eq!(message(&jpeg[..jpeg.len() - 2]), "the JPEG file is cut short: its end is missing");
    }

    #[test]
    fn a_jpeg_ends_at_its_own_end_not_at_its_thumbnails() {
        let jpeg = encode(photo(64, 48), ImageFormat::Jpeg);
        let mut with_thumbnail = vec![0xFF, 0xD8, 0xFF, 0xE2, 0, 6, 0xFF, 0xD8, 0xFF, 0xD9];
        with_thumbnail.extend(&jpeg[2..]);
        assert_eq!(decode(&with_thumbnail, WHITE).unwrap(), decode(&jpeg, WHITE).unwrap());
        with_thumbnail.truncate(with_thumbnail.len() / 2);
        assert_eq!(message(&with_thumbnail), "the JPEG file is cut short: its end is missing");
        let mut trailer = jpeg.clone();
        trailer.extend(b"SEFT and other trailers of phones");
        assert!(decode(&trailer, WHITE).is_ok());
    }

    #[test]
    fn damaged_files_never_panic() {
        let mut state = 12_345u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize
        };
        for format in FORMATS {
            let bytes = encode(photo(24, 18), format);
            for _ in 0..400 {
                let mut damaged = bytes.clone();
                for _ in 0..1 + random() % 4 {
                    let at = random() % damaged.len().min(if random() % 2 == 0 { 64 } else { usize::MAX });
                    damaged[at] = random() as u8;
                }
                if let Ok(field) = decode(&damaged, WHITE) {
                    assert!(field.width() > 0 && field.height() > 0);
                }
            }
        }
    }

    /// A PNG whose header claims a size; its checksum is right, its data are not for that size.
    fn png_of_size(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = encode(GrayImage::new(1, 1), ImageFormat::Png);
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let mut crc = u32::MAX;
        for byte in &bytes[12..29] {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
            }
        }
        bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
        bytes
    }

    #[test]
    fn too_large_and_zero_sized_images_are_refused_before_they_take_memory() {
        assert_eq!(
            message(&png_of_size(60_000, 60_000)),
            "the image is too large: 60000 x 60000 pixels, but at most 250 million pixels are read"
        );
        assert_eq!(
            message(&png_of_size(70_000, 1)),
            "the image is too large: at most 65535 pixels a side and 250 million pixels are read"
        );
        let empty = message(&png_of_size(0, 1));
        assert!(empty.starts_with("the PNG file is damaged"), "{empty}");
    }

    fn png_with_profile(image: &DynamicImage, profile: Vec<u8>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.set_icc_profile(profile).unwrap();
        let data: Vec<u8> = match image {
            // The encoder takes 16-bit samples in the machine's byte order.
            DynamicImage::ImageRgb16(i) => i.iter().flat_map(|v| v.to_ne_bytes()).collect(),
            other => other.as_bytes().to_vec(),
        };
        encoder.write_image(&data, image.width(), image.height(), image.color().into()).unwrap();
        bytes
    }

    #[test]
    fn an_embedded_profile_is_converted_to_srgb() {
        // Adobe RGB's (219, 0, 0) is sRGB's pure red, up to rounding: 0.299 in luma, where the raw values give 0.257.
        let red = DynamicImage::ImageRgb8(RgbImage::from_pixel(3, 2, Rgb([219, 0, 0])));
        let adobe = ColorProfile::new_adobe_rgb().encode().unwrap();
        let field = decode(&png_with_profile(&red, adobe.clone()), WHITE).unwrap();
        assert!((field.at(2, 1) - 0.299).abs() < 0.006, "{}", field.at(2, 1));

        let deep = DynamicImage::ImageRgb16(ImageBuffer::from_pixel(3, 2, Rgb([219 * 257, 0, 0])));
        let field = decode(&png_with_profile(&deep, adobe.clone()), WHITE).unwrap();
        assert!((field.at(2, 1) - 0.299).abs() < 0.006, "{}", field.at(2, 1));

        // Linear grey: 0.2140 of the light is 0.5 encoded.
        let linear = ColorProfile::new_gray_with_gamma(1.0).encode().unwrap();
        let grey = DynamicImage::ImageLuma8(GrayImage::from_pixel(1, 1, Luma([55])));
        assert!((decode(&png_with_profile(&grey, linear), WHITE).unwrap().at(0, 0) - 0.5).abs() < 0.01);
    }

    #[test]
    fn srgb_broken_and_foreign_profiles_change_nothing() {
        let image = DynamicImage::ImageRgb8(photo(20, 10));
        let plain = decode(&encode(image.clone(), ImageFormat::Png), WHITE).unwrap();
        let srgb = ColorProfile::new_srgb().encode().unwrap();
        let mut broken = ColorProfile::new_adobe_rgb().encode().unwrap();
        broken.truncate(150);
        let grey = ColorProfile::new_gray_with_gamma(1.0).encode().unwrap();
        for profile in [srgb, broken, b"not a profile".to_vec(), grey] {
            assert_eq!(decode(&png_with_profile(&image, profile), WHITE).unwrap(), plain);
        }
    }
}
