//! WebP (RFC 9649): in, a file; out, its picture, or the first of an animation. The chunks are looked through here, so that lengths
//! that are not there never reach the decoder, the crate `image-webp`.

use std::io::Cursor;

use image_webp::WebPDecoder;

use super::canvas::zeros;
use super::colour::Colours;
use super::exif::Exif;
use super::job::{Job, Opened, Source, all_bytes, decoded, needs_memory};
use super::kinds::Container::WebP;
use super::stored::{Depth, Model, Stored};
use crate::base::Result;
use crate::photo::Samples;

/// A chunk's name and content, and whether all of it is there.
struct Chunk<'a> {
    name: [u8; 4],
    content: &'a [u8],
    whole: bool,
}

/// The chunks of a file or of a frame.
fn chunks(mut bytes: &[u8]) -> Vec<Chunk<'_>> {
    let mut chunks = Vec::new();
    while let Some(([a, b, c, d, length @ ..], rest)) = bytes.split_first_chunk::<8>() {
        let length = u32::from_le_bytes(*length) as usize;
        let content = &rest[..length.min(rest.len())];
        chunks.push(Chunk { name: [*a, *b, *c, *d], content, whole: content.len() == length });
        bytes = rest.get(length + (length & 1)..).unwrap_or_default();
    }
    chunks
}

/// Reads a file onto the canvas.
pub(super) fn read(source: &mut dyn Source, job: &mut Job) -> Result<()> {
    let bytes = all_bytes(source)?;
    let found = chunks(bytes.get(12..).unwrap_or_default());
    let picture = [*b"VP8 ", *b"VP8L", *b"ANMF"];
    // What lies behind the picture is of no use.
    let Some(at) = found.iter().position(|chunk| picture.contains(&chunk.name)) else {
        return Err(WebP.cut_short("there is no picture in it"));
    };
    if let Some(chunk) = found[..=at].iter().find(|chunk| !chunk.whole) {
        return Err(WebP.cut_short(&format!("only {} bytes of its picture are there", chunk.content.len())));
    }
    let of = |name: &[u8; 4]| found.iter().find(|chunk| chunk.name == *name && chunk.whole).map(|chunk| chunk.content);
    let exif = of(b"EXIF").map(Exif::of).unwrap_or_default();
    let colours = Colours::of_file(WebP, of(b"ICCP"), exif.adobe_rgb)?;
    // The decoder gets the header and the picture alone, in a file that says how long it is: a second frame that is cut short is no
    // reason to refuse the first, and other chunks are none of its concern.
    let alone = alone(&found, at);
    let unreadable = |_| WebP.damaged("its picture cannot be decoded");
    let mut decoder = decoded(WebP, || WebPDecoder::new(Cursor::new(&alone[..])).map_err(unreadable))?;
    let (width, height) = decoder.dimensions();
    if !fits(&found[at], [width, height]) {
        return Err(WebP.damaged("its picture has another size than the file says"));
    }
    let alpha = decoder.has_alpha();
    let stored = Stored {
        width: width as usize,
        height: height as usize,
        model: Model::Rgb,
        alpha,
        premultiplied: false,
        orientation: exif.orientation,
    };
    job.begin(&Opened { stored, colours, depth: Depth::U8 })?;
    let row = stored.width * stored.channels();
    // The planes and the pixels.
    needs_memory(stored.width * stored.height * 8)?;
    let mut samples = zeros(row * stored.height)?;
    decoded(WebP, || {
        if decoder.is_animated() {
            let _ = decoder.set_background_color([0; 4]);
            decoder.read_frame(&mut samples).map(drop).map_err(unreadable)
        } else {
            decoder.read_image(&mut samples).map_err(unreadable)
        }
    })?;
    if found[at..].iter().any(|chunk| !chunk.whole) {
        job.warn("the WebP file lacks its end; all its pixels are there");
    }
    job.canvas()?.put(0, 0, stored.width, Samples::U8(&samples))
}

/// Whether the pictures that a chunk holds, itself or as a frame, are no larger than the file says. The decoder makes room for what a
/// lossy picture says of itself before it compares the two; of the others it asks first.
fn fits(chunk: &Chunk, [width, height]: [u32; 2]) -> bool {
    let picture_fits = |chunk: &Chunk| {
        let side = |at: usize| chunk.content.get(at..at + 2).map_or(0, |b| u32::from(b[0]) | u32::from(b[1] & 0x3F) << 8);
        chunk.name != *b"VP8 " || side(6) <= width && side(8) <= height
    };
    let frame = if chunk.name == *b"ANMF" { chunk.content.get(16..).unwrap_or_default() } else { &[] };
    picture_fits(chunk) && chunks(frame).iter().all(picture_fits)
}

/// Decodes a strip or tile of TIFF that is as wide as the first of `most`, and at most as high as the second. Returns its samples
/// and how many a pixel has.
pub(super) fn strip(bytes: &[u8], most: [usize; 2]) -> Result<(Vec<u8>, usize)> {
    let unreadable = |_| WebP.damaged("its picture cannot be decoded");
    let found = chunks(bytes.get(12..).unwrap_or_default());
    if found.iter().any(|chunk| !chunk.whole) {
        return Err(WebP.cut_short("a part of its picture is missing"));
    }
    let mut decoder = decoded(WebP, || WebPDecoder::new(Cursor::new(bytes)).map_err(unreadable))?;
    let (width, height) = decoder.dimensions();
    if width as usize != most[0] || height as usize > most[1] || !found.iter().all(|chunk| fits(chunk, [width, height])) {
        return Err(WebP.damaged("its size is wrong"));
    }
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    needs_memory(width as usize * height as usize * 8)?;
    let mut samples = zeros(width as usize * height as usize * channels)?;
    decoded(WebP, || decoder.read_image(&mut samples).map_err(unreadable))?;
    Ok((samples, channels))
}

/// A file of the chunks that the picture at `at` needs.
fn alone(found: &[Chunk], at: usize) -> Vec<u8> {
    let needed = [*b"VP8X", *b"ALPH", *b"ANIM"];
    let kept = found[..at].iter().filter(|chunk| needed.contains(&chunk.name)).chain([&found[at]]);
    let mut file = b"RIFF\0\0\0\0WEBP".to_vec();
    for chunk in kept {
        file.extend(chunk.name);
        file.extend((chunk.content.len() as u32).to_le_bytes());
        let begin = file.len();
        file.extend(chunk.content);
        if chunk.name == *b"VP8X"
            && let Some(flags) = file.get_mut(begin)
        {
            // No profile, EXIF data or XMP any more.
            *flags &= !0b0010_1100;
        }
        if file.len() % 2 == 1 {
            file.push(0);
        }
    }
    let length = (file.len() - 8) as u32;
    file[4..8].copy_from_slice(&length.to_le_bytes());
    file
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use crate::base::Control;
    use crate::decoding::{Reading, decode};

    fn told(chunks: &[(&[u8; 4], &[u8])]) -> String {
        let mut file = b"RIFF\0\0\0\0WEBP".to_vec();
        for (name, content) in chunks {
            file.extend(*name);
            file.extend((content.len() as u32).to_le_bytes());
            file.extend(*content);
        }
        decode(&mut Cursor::new(file), &Reading { max_pixels: 100, ..Reading::default() }, &Control::new()).unwrap_err().to_string()
    }

    #[test]
    fn a_picture_is_not_larger_than_the_file_says() {
        // The canvas has a pixel, the picture 16383 x 16383; then the same in a frame of an animation.
        let picture = b"\0\0\0\x9D\x01\x2A\xFF\x3F\xFF\x3F";
        let still = told(&[(b"VP8X", &[0; 10]), (b"VP8 ", picture)]);
        assert!(still.contains("another size than the file says"), "{still}");
        let frame = [&[0; 16][..], b"VP8 \x0A\0\0\0", picture].concat();
        let moving = told(&[(b"VP8X", &[2, 0, 0, 0, 0, 0, 0, 0, 0, 0]), (b"ANIM", &[0; 6]), (b"ANMF", &frame)]);
        assert!(moving.contains("another size than the file says"), "{moving}");
    }
}
