//! Reading a file: in, its bytes; out, its photo. The kind is told here, and who decodes it.

use std::io::Read;

use super::job::{Job, Reading, Source, all_bytes};
use super::kinds::{Container, HEAD, kind_of};
use super::{jpeg, png, tiff, webp};
use crate::base::{Control, Error, Pool, Result};
use crate::photo::Photo;

/// What is said to have decoded what is decoded here.
const DECODER: &str = "graphstipple";

/// A photo that was read.
#[derive(Debug, Clone)]
pub struct Decoded {
    /// Its luma, and its colour if that was wanted.
    pub photo: Photo,
    /// One sentence for the user where the photo may not be what they expect: it lacks its end, or parts of it.
    pub warning: Option<String>,
    /// Which program decoded it, with its version if it is another than this.
    pub decoder: String,
}

/// The luma of an image file, upright, in sRGB, laid on the background where it is transparent.
///
/// The format is told from the content: PNG, JPEG, TIFF or WebP. Integer samples are shares of their largest value, float samples
/// sRGB-encoded values in [0, 1]. Of several images, the one with the most pixels that is no thumbnail is read, of an animation the
/// first frame.
///
/// # Errors
/// [`Error::Unsupported`] for a format or a feature that is not read, [`Error::Decode`] for what is no image, is too large,
/// damaged or cut short, [`Error::Input`] for a float sample outside [0, 1], [`Error::Cancelled`].
pub fn decode(source: &mut dyn Source, reading: &Reading, control: &Control) -> Result<Decoded> {
    let threads = reading.options.as_ref().and_then(|options| options.threads);
    Pool::new(threads).run(|| decode_here(source, reading, control))
}

fn decode_here(source: &mut dyn Source, reading: &Reading, control: &Control) -> Result<Decoded> {
    let failed = |error: std::io::Error| Error::Decode(format!("the file cannot be read: {error}"));
    let mut head = Vec::new();
    source.rewind().map_err(failed)?;
    (&mut *source).take(HEAD as u64).read_to_end(&mut head).map_err(failed)?;
    source.rewind().map_err(failed)?;
    let container = kind_of(&head)?;
    let mut job = Job { reading, control, canvas: None, warnings: Vec::new() };
    match container {
        Container::Png => png::read(source, &mut job)?,
        Container::Jpeg => {
            let bytes = all_bytes(source)?;
            let (stream, opened) = jpeg::open(&bytes)?;
            job.begin(&opened)?;
            jpeg::read(&stream, &bytes, &mut job)?;
        }
        Container::Tiff => tiff::read(source, &mut job)?,
        Container::WebP => webp::read(source, &mut job)?,
    }
    control.check()?;
    let Some(canvas) = job.canvas else { return Err(Error::Internal("the picture has no canvas".into())) };
    let warning = (!job.warnings.is_empty()).then(|| job.warnings.join("; "));
    Ok(Decoded { photo: canvas.finish()?, warning, decoder: DECODER.to_owned() })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use ::tiff::encoder::{TiffEncoder, colortype};
    use jpeg_encoder::{ColorType as JpegColour, Encoder as JpegEncoder};
    use moxcms::ColorProfile;

    use super::*;
    use crate::photo::Field;

    const WHITE: [u8; 3] = [255; 3];

    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Kind {
        Png,
        Jpeg,
        Tiff,
        WebP,
    }

    const KINDS: [Kind; 4] = [Kind::Png, Kind::Jpeg, Kind::Tiff, Kind::WebP];

    /// A picture to encode: samples row by row, `channels` a pixel.
    #[derive(Clone)]
    struct Picture {
        size: [u32; 2],
        channels: u8,
        samples: Samples,
    }

    #[derive(Clone)]
    enum Samples {
        Bytes(Vec<u8>),
        Floats(Vec<f32>),
    }

    impl Picture {
        /// `channels` bytes a pixel.
        fn bytes(size: [u32; 2], channels: u8, samples: Vec<u8>) -> Self {
            Self { size, channels, samples: Samples::Bytes(samples) }
        }

        fn png(&self, profile: Option<Vec<u8>>) -> Vec<u8> {
            let mut info = ::png::Info::with_size(self.size[0], self.size[1]);
            info.color_type = match self.channels {
                1 => ::png::ColorType::Grayscale,
                _ => ::png::ColorType::Rgb,
            };
            info.icc_profile = profile.map(Into::into);
            let data = match &self.samples {
                Samples::Bytes(samples) => samples.clone(),
                Samples::Floats(_) => panic!("no PNG holds floats"),
            };
            info.bit_depth = ::png::BitDepth::Eight;
            let mut bytes = Vec::new();
            let mut writer = ::png::Encoder::with_info(&mut bytes, info).unwrap().write_header().unwrap();
            writer.write_image_data(&data).unwrap();
            writer.finish().unwrap();
            bytes
        }

        fn jpeg(&self) -> Vec<u8> {
            let Samples::Bytes(samples) = &self.samples else { panic!("JPEG holds bytes") };
            let mut bytes = Vec::new();
            let [width, height] = self.size.map(|side| side as u16);
            JpegEncoder::new(&mut bytes, 75).encode(samples, width, height, JpegColour::Rgb).unwrap();
            bytes
        }

        fn tiff(&self) -> Vec<u8> {
            let mut bytes = Cursor::new(Vec::new());
            let [width, height] = self.size;
            let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
            match (&self.samples, self.channels) {
                (Samples::Bytes(samples), 3) => encoder.write_image::<colortype::RGB8>(width, height, samples),
                (Samples::Floats(samples), 3) => encoder.write_image::<colortype::RGB32Float>(width, height, samples),
                _ => panic!("no test needs this TIFF"),
            }
            .unwrap();
            bytes.into_inner()
        }

        fn webp(&self) -> Vec<u8> {
            let Samples::Bytes(samples) = &self.samples else { panic!("WebP holds bytes") };
            let (mut bytes, [width, height]) = (Vec::new(), self.size);
            image_webp::WebPEncoder::new(&mut bytes).encode(samples, width, height, image_webp::ColorType::Rgb8).unwrap();
            bytes
        }

        fn encode(&self, kind: Kind) -> Vec<u8> {
            match kind {
                Kind::Png => self.png(None),
                Kind::Jpeg => self.jpeg(),
                Kind::Tiff => self.tiff(),
                Kind::WebP => self.webp(),
            }
        }
    }

    /// The luma of a file, and what is said of it.
    fn read(bytes: &[u8], reading: &Reading) -> Result<(Field, Option<String>)> {
        let Decoded { photo, warning, .. } = super::decode(&mut Cursor::new(bytes), reading, &Control::new())?;
        Ok((photo.into_luma(), warning))
    }

    fn decode(bytes: &[u8], background: [u8; 3]) -> Result<Field> {
        read(bytes, &Reading { background, ..Reading::default() }).map(|(luma, _)| luma)
    }

    /// A smooth colour picture, so that JPEG stays near it.
    fn photo(width: u32, height: u32) -> Picture {
        let colour = |x: u32, y: u32| [(x * 255 / width) as u8, (y * 255 / height) as u8, 90];
        let colours = (0..height).flat_map(|y| (0..width).flat_map(move |x| colour(x, y)));
        Picture::bytes([width, height], 3, colours.collect())
    }

    fn message(bytes: &[u8]) -> String {
        match decode(bytes, WHITE).unwrap_err() {
            Error::Decode(message) | Error::Unsupported(message) => message,
            other => panic!("not a decode error: {other}"),
        }
    }

    #[test]
    fn every_kind_of_file_keeps_its_colour_where_that_is_wanted() {
        let picture = photo(64, 48);
        for kind in KINDS {
            let bytes = picture.encode(kind);
            let read = |colour| {
                let reading = Reading { colour, ..Reading::default() };
                super::decode(&mut Cursor::new(&bytes), &reading, &Control::new()).unwrap().photo
            };
            let (plain, coloured) = (read(false), read(true));
            assert!(plain.colour().is_none());
            let colour = coloured.colour().unwrap().clone();
            assert_eq!(coloured.without_colour(), plain, "{kind:?}");
            let near = if kind == Kind::Jpeg { 0.04 } else { 0.0 };
            for (x, y) in (0..64).flat_map(|x| (0..48).map(move |y| (x, y))) {
                let expected = [x * 255 / 64, y * 255 / 48, 90].map(|v| v as f32 / 255.0);
                let told = colour.at(x, y);
                assert!(told.iter().zip(expected).all(|(v, e)| (v - e).abs() <= near), "{kind:?}: {told:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn float_samples_are_in_0_to_1_as_those_of_arrays() {
        let tiff = |v: f32| {
            let samples = Samples::Floats(vec![0.5, 0.5, 0.5, v, v, v]);
            Picture { size: [2, 1], channels: 3, samples }.encode(Kind::Tiff)
        };
        assert_eq!(decode(&tiff(0.25), WHITE).unwrap().values(), [0.5, 0.25]);
        for (wrong, told) in [(7.5, "7.5"), (-1.0, "-1"), (f32::NAN, "NaN")] {
            let error = decode(&tiff(wrong), WHITE).unwrap_err().to_string();
            assert_eq!(error, format!("the value at column 1, row 0 is {told}, but it must be between 0 and 1"));
        }
    }

    #[test]
    fn what_is_no_image_is_refused_in_one_sentence() {
        let known = "PNG, JPEG, TIFF or WebP";
        assert_eq!(message(b""), "the file is empty");
        assert_eq!(
            message(b"hello world, this is text"),
            format!("the file is text, not an image in a format that is read: {known}")
        );
        assert_eq!(message(&[7; 40]), format!("the file is not an image in a format that is read: {known}"));
        assert_eq!(message(b"<svg/>"), "the file is SVG, which is not read here: render it as PNG");
        assert_eq!(message(b"%PDF-1.7"), "the file is PDF, which is not read here: render it as PNG");
        let asked = |bytes: &[u8]| matches!(decode(bytes, WHITE), Err(Error::Unsupported(_)));
        assert!(asked(b"GIF89a\x01\0\x01\0\0\0\0;") && asked(b"P5 1 1 255 x"));
        assert!(!asked(b"8BPS") && !asked(b"II*\0\x10\0\0\0CR\x02\0"));
    }

    #[test]
    fn files_cut_anywhere_are_errors_or_told_of() {
        for kind in KINDS {
            let bytes = photo(32, 24).encode(kind);
            let half = message(&bytes[..bytes.len() / 2]);
            assert!(half.contains("cut short") && !half.contains('\n'), "{kind:?}: {half}");
            let whole = decode(&bytes, WHITE).unwrap();
            for end in 1..bytes.len() {
                if let Ok((luma, warning)) = read(&bytes[..end], &Reading::default()) {
                    // All pixels are there, and only they.
                    // The last byte of WebP fills up.
                    let told = warning.is_some() || kind == Kind::WebP && end + 1 == bytes.len();
                    assert!(told && luma == whole, "{kind:?} cut at {end} of {}", bytes.len());
                }
            }
        }
    }

    #[test]
    fn a_jpeg_ends_at_its_own_end_not_at_its_thumbnails() {
        let jpeg = photo(64, 48).encode(Kind::Jpeg);
        let mut with_thumbnail = vec![0xFF, 0xD8, 0xFF, 0xE2, 0, 6, 0xFF, 0xD8, 0xFF, 0xD9];
        with_thumbnail.extend(&jpeg[2..]);
        assert_eq!(decode(&with_thumbnail, WHITE).unwrap(), decode(&jpeg, WHITE).unwrap());
        with_thumbnail.truncate(with_thumbnail.len() * 2 / 3);
        assert!(message(&with_thumbnail).starts_with("the JPEG file is cut short: "));
        let mut trailer = jpeg.clone();
        trailer.extend(b"SEFT and other trailers of phones");
        assert_eq!(read(&trailer, &Reading::default()).unwrap().1, None);
        // Closed again where it was cut.
        let mut closed = jpeg[..jpeg.len() * 3 / 4].to_vec();
        closed.extend([0xFF, 0xD9]);
        assert!(message(&closed).starts_with("the JPEG file is cut short: "));
    }

    #[test]
    fn damaged_files_never_panic() {
        let mut state = 12_345u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize
        };
        for kind in KINDS {
            let bytes = photo(24, 18).encode(kind);
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
        let mut bytes = Picture::bytes([1, 1], 1, vec![0]).encode(Kind::Png);
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
            "the image is too large: 60000 x 60000 pixels, but at most 250000000 pixels are read"
        );
        assert_eq!(message(&png_of_size(70_000, 1)), "the image is too large: 70000 x 1 pixels, but a side may have at most 65535");
        let few = Reading { max_pixels: 99, ..Reading::default() };
        let told = read(&png_of_size(10, 10), &few).unwrap_err().to_string();
        assert_eq!(told, "the image is too large: 10 x 10 pixels, but at most 99 pixels are read");
        let empty = message(&png_of_size(0, 1));
        assert!(empty.starts_with("the PNG file is damaged"), "{empty}");
    }

    #[test]
    fn srgb_broken_and_foreign_profiles_change_nothing() {
        let picture = photo(20, 10);
        let plain = decode(&picture.encode(Kind::Png), WHITE).unwrap();
        let srgb = ColorProfile::new_srgb().encode().unwrap();
        let mut broken = ColorProfile::new_adobe_rgb().encode().unwrap();
        broken.truncate(150);
        let grey = ColorProfile::new_gray_with_gamma(1.0).encode().unwrap();
        for profile in [srgb, broken, b"not a profile".to_vec(), grey] {
            assert_eq!(decode(&picture.png(Some(profile)), WHITE).unwrap(), plain);
        }
    }
}
