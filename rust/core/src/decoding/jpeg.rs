//! JPEG (ITU-T T.81): in, the bytes of a file or of a strip of TIFF; out, rows of samples. The markers are read here, and what the
//! decoders are handed is written anew from them: a height that stands behind the picture (DNL), a second start, trailers
//! and thumbnails never reach them. Most files are decoded by `zune-jpeg`, which is fast; those with several scans or unusual
//! sampling by `jpeg-decoder`, which knows them all.

use std::ops::Range;
use std::sync::Arc;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::colour::Colours;
use super::coverage::coverage;
use super::exif::Exif;
use super::frame::{Component, Frame, Huffman, Scan};
use super::job::{Job, Opened, decoded, needs_memory};
use super::kinds::Container::Jpeg;
use super::stored::{Depth, Model, Stored};
use crate::base::Result;
use crate::photo::{MAX_SIDE, Samples};

/// Pixels of a side of the largest unit that encoders fill up.
const UNIT: usize = 32;

/// Scans of a picture at most. Encoders make a dozen; each of a few bytes may go through all blocks of the picture.
const MAX_SCANS: usize = 256;

/// A segment that decoders need.
#[derive(Debug, Clone)]
struct Piece {
    marker: u8,
    payload: Range<usize>,
    /// Which scan begins with it.
    scan: Option<usize>,
}

/// How three or four components make colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    /// As the file says.
    Told,
    /// Luma and chroma, whatever it says.
    Ycc,
    /// As they are.
    Plain,
}

/// The markers of a stream.
#[derive(Debug, Default)]
pub(super) struct Stream {
    pub(super) frame: Frame,
    pieces: Vec<Piece>,
    scans: Vec<Scan>,
    has_jfif: bool,
    adobe: Option<u8>,
    exif: Option<Range<usize>>,
    profile: Vec<(u8, u8, Range<usize>)>,
    /// Whether it is closed.
    ends: bool,
    /// What is not supported.
    unsupported: Option<&'static str>,
}

impl Stream {
    /// Reads all markers.
    ///
    /// # Errors
    /// [`Error::Decode`] if there is no picture.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let mut stream = Self::default();
        let mut tables = Tables::default();
        let mut at = 0;
        while let Some(marker) = next_marker(bytes, &mut at) {
            match marker {
                0xD8 | 0x01 | 0xD0..=0xD7 => continue,
                0xD9 if stream.frame.components.is_empty() => continue,
                0xD9 => {
                    stream.ends = true;
                    break;
                }
                _ => {}
            }
            let Some(length) = bytes.get(at..at + 2).map(|b| usize::from(b[0]) << 8 | usize::from(b[1])) else { break };
            let payload = at + 2..at + length.max(2);
            let Some(content) = bytes.get(payload.clone()) else { break };
            at = payload.end;
            let mut scan = None;
            match marker {
                0xC4 => tables.read_huffman(content),
                0xDD if content.len() >= 2 => tables.restart_interval = usize::from(content[0]) << 8 | usize::from(content[1]),
                0xDB => {}
                0xC0..=0xCF if marker != 0xC8 && marker != 0xCC => {
                    if !stream.frame.components.is_empty() {
                        // A second frame is another picture.
                        break;
                    }
                    stream.read_frame(marker, content)?;
                }
                0xCC => {
                    stream.lacks("arithmetic coding");
                    continue;
                }
                0xF7 => {
                    stream.lacks("JPEG-LS coding");
                    break;
                }
                0xDC => {
                    // The height, behind the first scan.
                    if let (0, [high, low, ..]) = (stream.frame.height, content) {
                        stream.frame.height = usize::from(*high) << 8 | usize::from(*low);
                    }
                    continue;
                }
                0xDA => {
                    let end = end_of_data(bytes, at);
                    let Some(read) = stream.read_scan(content, &tables, at..end) else {
                        return Err(Jpeg.damaged("the header of a scan is broken"));
                    };
                    if stream.scans.len() == MAX_SCANS {
                        return Err(Jpeg.damaged(&format!("it has more than {MAX_SCANS} scans")));
                    }
                    at = end;
                    scan = Some(stream.scans.len());
                    stream.scans.push(read);
                }
                _ => {
                    stream.note(marker, content, &payload);
                    continue;
                }
            }
            stream.pieces.push(Piece { marker, payload, scan });
        }
        Ok(stream)
    }

    /// Whether there is a picture that can be decoded.
    fn check(&self) -> Result<()> {
        let ends_in_its_header = self.scans.is_empty() && !self.frame.components.is_empty() && !self.ends;
        if let Some(what) = self.unsupported.filter(|_| !ends_in_its_header) {
            return Err(Jpeg.unsupported(what));
        }
        if self.frame.components.is_empty() || self.scans.is_empty() {
            return Err(Jpeg.cut_short("there is no picture in it"));
        }
        if self.frame.width == 0 || self.frame.height == 0 {
            return Err(Jpeg.cut_short(&format!("its size is {} x {} pixels", self.frame.width, self.frame.height)));
        }
        Ok(())
    }

    /// Notes what is not supported; the first counts.
    fn lacks(&mut self, what: &'static str) {
        self.unsupported.get_or_insert(what);
    }

    fn read_frame(&mut self, marker: u8, content: &[u8]) -> Result<()> {
        let broken = || Jpeg.damaged("the header of the picture is broken");
        let [precision, h1, h0, w1, w0, count, components @ ..] = content else { return Err(broken()) };
        match marker {
            0xC0..=0xC2 => {}
            0xC3 => self.lacks("lossless coding"),
            0xC9..=0xCB => self.lacks("arithmetic coding"),
            _ => self.lacks("hierarchical coding"),
        }
        if *precision != 8 {
            let what = if *precision == 12 { "samples of 12 bits" } else { "samples of other than 8 bits" };
            self.lacks(what);
        }
        let of = |high: u8, low: u8| usize::from(high) << 8 | usize::from(low);
        let components: Vec<Component> = components
            .chunks_exact(3)
            .take(usize::from(*count))
            .map(|c| Component { id: c[0], sampling: [usize::from(c[1] >> 4), usize::from(c[1] & 15)] })
            .collect();
        let valid = components.iter().all(|c| c.sampling.iter().all(|s| (1..=4).contains(s)));
        if components.len() != usize::from(*count) || !valid || components.is_empty() {
            return Err(broken());
        }
        if !matches!(components.len(), 1 | 3 | 4) {
            self.lacks("other than 1, 3 or 4 components");
        }
        self.frame = Frame { progressive: marker == 0xC2, width: of(*w1, *w0), height: of(*h1, *h0), components };
        let largest = self.frame.largest();
        if self.frame.components.iter().any(|c| (0..2).any(|axis| !largest[axis].is_multiple_of(c.sampling[axis]))) {
            self.lacks("components of which one's sampling is no multiple of another's");
        }
        // One component alone has no subsampling, whatever it says.
        if let [only] = &mut self.frame.components[..] {
            only.sampling = [1, 1];
        }
        Ok(())
    }

    fn read_scan(&self, content: &[u8], tables: &Tables, data: Range<usize>) -> Option<Scan> {
        let (count, rest) = content.split_first()?;
        let count = usize::from(*count);
        let named = rest.get(..2 * count)?;
        let [first, last, bits] = *rest.get(2 * count..2 * count + 3)? else { return None };
        let components: Option<Vec<_>> = named
            .chunks_exact(2)
            .map(|c| Some((self.frame.components.iter().position(|component| component.id == c[0])?, c[1] >> 4, c[1] & 15)))
            .collect();
        let components = components?;
        if components.is_empty() || components.len() > 4 {
            return None;
        }
        let band = if self.frame.progressive { [first, last.min(63)] } else { [0, 63] };
        let valid = !self.frame.progressive || band[0] <= band[1] && (band[0] == 0) == (band[1] == 0);
        valid.then(|| Scan {
            components,
            band,
            high: bits >> 4,
            low: bits & 15,
            restart_interval: tables.restart_interval,
            huffman_dc: tables.dc.clone(),
            huffman_ac: tables.ac.clone(),
            data,
        })
    }

    /// Notes what a segment says about the picture.
    fn note(&mut self, marker: u8, content: &[u8], payload: &Range<usize>) {
        let behind = |bytes: usize| payload.start + bytes..payload.end;
        match marker {
            0xE0 if content.starts_with(b"JFIF\0") => self.has_jfif = true,
            0xE1 if content.starts_with(b"Exif\0\0") && self.exif.is_none() => self.exif = Some(behind(6)),
            0xE2 if content.starts_with(b"ICC_PROFILE\0") && content.len() > 14 => {
                self.profile.push((content[12], content[13], behind(14)));
            }
            0xEE if content.starts_with(b"Adobe") && content.len() >= 12 => self.adobe = Some(content[11]),
            _ => {}
        }
    }

    /// The embedded profile, if no part of it is missing.
    fn profile(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let mut parts: Vec<_> = self.profile.iter().collect();
        let &(_, count, _) = *parts.first()?;
        parts.sort_by_key(|(number, ..)| *number);
        let expected = (1..=count).eq(parts.iter().map(|(number, ..)| *number));
        expected.then(|| parts.iter().flat_map(|(.., range)| bytes[range.clone()].iter().copied()).collect())
    }

    /// Whether three components are luma and chroma, by the rules of libjpeg; of four, whether the first three are.
    fn is_ycc(&self) -> bool {
        let ids: Vec<u8> = self.frame.components.iter().map(|c| c.id).collect();
        match ids.len() {
            3 if self.has_jfif => true,
            3 => self.adobe.map_or(ids != *b"RGB", |transform| transform != 0),
            4 => self.adobe == Some(2),
            _ => false,
        }
    }

    /// The stream anew, with what decoders need, so many rows high, without the scans that are left out. Tables that stand in a
    /// stream of their own come first.
    fn rebuilt(&self, bytes: &[u8], tables: Option<(&Self, &[u8])>, height: usize, keep: impl Fn(&Scan) -> bool) -> Vec<u8> {
        let mut stream = vec![0xFF, 0xD8];
        let of_tables = tables.into_iter().flat_map(|(tables, bytes)| tables.pieces.iter().map(move |piece| (piece, bytes)));
        // A picture in the stream of the tables is not this one.
        let of_tables = of_tables.filter(|(piece, _)| matches!(piece.marker, 0xC4 | 0xDB | 0xDD));
        for (piece, bytes) in of_tables.chain(self.pieces.iter().map(|piece| (piece, bytes))) {
            let scan = piece.scan.map(|scan| &self.scans[scan]);
            if scan.is_some_and(|scan| !keep(scan)) {
                continue;
            }
            let content = &bytes[piece.payload.clone()];
            let length = (content.len() + 2) as u16;
            stream.extend([0xFF, piece.marker, (length >> 8) as u8, length as u8]);
            let begin = stream.len();
            stream.extend(content);
            if piece.marker & 0xF0 == 0xC0 && piece.marker != 0xC4 {
                stream[begin + 1..begin + 3].copy_from_slice(&(height as u16).to_be_bytes());
                if let [_] = self.frame.components[..] {
                    stream[begin + 7] = 0x11;
                }
            }
            if let Some(scan) = scan {
                stream.extend(&bytes[scan.data.clone()]);
            }
        }
        stream.extend([0xFF, 0xD9]);
        stream
    }

    /// Whether `zune-jpeg` decodes it rightly: all components in one scan, chroma at most halved.
    fn is_plain(&self) -> bool {
        let [first, rest @ ..] = &self.frame.components[..] else { return false };
        let one_scan = self.frame.progressive || self.scans.len() == 1;
        let simple = first.sampling.iter().all(|s| *s <= 2) && rest.iter().all(|c| c.sampling == [1, 1]);
        one_scan && simple && self.frame.components.len() != 4
    }

    /// Whether the scans bring every bit of every coefficient.
    fn is_complete(&self) -> bool {
        if !self.frame.progressive {
            return (0..self.frame.components.len()).all(|c| self.scans.iter().any(|s| s.components.iter().any(|p| p.0 == c)));
        }
        (0..self.frame.components.len()).all(|component| {
            (0..64u8).all(|k| {
                let of_this = self.scans.iter().filter(|s| s.components.iter().any(|p| p.0 == component));
                let mut known = of_this.filter(|s| (s.band[0]..=s.band[1]).contains(&k)).peekable();
                // A band that no scan has is 0 everywhere: encoders leave out what is empty.
                (known.peek().is_none() && k > 0) || known.any(|s| s.low == 0)
            })
        })
    }
}

/// Tables as they stand at a scan.
#[derive(Default)]
struct Tables {
    dc: [Option<Arc<Huffman>>; 4],
    ac: [Option<Arc<Huffman>>; 4],
    restart_interval: usize,
}

impl Tables {
    fn read_huffman(&mut self, mut content: &[u8]) {
        while let Some((head, rest)) = content.split_at_checked(17) {
            let mut counts = [0; 16];
            counts.copy_from_slice(&head[1..]);
            let total: usize = counts.iter().map(|c| usize::from(*c)).sum();
            let Some((symbols, rest)) = rest.split_at_checked(total) else { return };
            let tables = if head[0] >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            tables[usize::from(head[0] & 3)] = Some(Arc::new(Huffman::new(&counts, symbols)));
            content = rest;
        }
    }
}

/// The next marker, and `at` behind it.
fn next_marker(bytes: &[u8], at: &mut usize) -> Option<u8> {
    loop {
        *at += bytes.get(*at..)?.iter().position(|byte| *byte == 0xFF)? + 1;
        while bytes.get(*at) == Some(&0xFF) {
            *at += 1;
        }
        let marker = *bytes.get(*at)?;
        *at += 1;
        if marker != 0 {
            return Some(marker);
        }
    }
}

/// Where the coded data end that begin at `at`: at the next marker other than those of restarts.
fn end_of_data(bytes: &[u8], at: usize) -> usize {
    let mut end = at;
    while let Some(next) = bytes[end..].iter().position(|byte| *byte == 0xFF) {
        end += next;
        match bytes.get(end + 1) {
            Some(0 | 0xD0..=0xD7) => end += 2,
            Some(0xFF) => end += 1,
            Some(_) => return end,
            None => return bytes.len(),
        }
    }
    bytes.len()
}

/// Samples of a picture, interleaved.
pub(super) struct Decoded {
    pub(super) samples: Vec<u8>,
    pub(super) channels: usize,
    pub(super) height: usize,
}

/// Opens a file: its size, its colours and what the camera says.
pub(super) fn open(bytes: &[u8]) -> Result<(Stream, Opened)> {
    let stream = Stream::parse(bytes)?;
    stream.check()?;
    let exif = stream.exif.clone().map(|range| Exif::of(&bytes[range])).unwrap_or_default();
    let model = match stream.frame.components.len() {
        1 => Model::Grey,
        3 => Model::Rgb,
        _ => Model::Cmyk,
    };
    let marked = exif.adobe_rgb && model == Model::Rgb;
    let colours = Colours::of_file(Jpeg, stream.profile(bytes).as_deref(), marked)?;
    let stored = Stored {
        width: stream.frame.width,
        height: stream.frame.height,
        model,
        alpha: false,
        premultiplied: false,
        orientation: exif.orientation,
    };
    Ok((stream, Opened { stored, colours, depth: Depth::U8 }))
}

/// Decodes a file onto its canvas.
pub(super) fn read(stream: &Stream, bytes: &[u8], job: &mut Job) -> Result<()> {
    let Frame { width, height, .. } = stream.frame;
    needs_memory(width * height * if stream.is_plain() { 3 } else { 8 })?;
    // The pixels are made while it is found out whether all of them are there.
    let (found, decoded) = rayon::join(
        || coverage(&stream.frame, &stream.scans, bytes),
        || pixels(stream, bytes, None, height, Coding::Told, |_| true),
    );
    let complete = found.whole && stream.is_complete();
    let decoded = if complete || found.damaged && found.rows == height {
        let decoded = decoded?;
        if found.damaged {
            job.warn("the JPEG file is damaged: parts of the drawing may be wrong");
        } else if !stream.ends {
            job.warn("the JPEG file lacks its end; all its pixels are there");
        }
        decoded
    } else {
        let detail = if found.rows == height {
            "the details of its picture are missing".to_owned()
        } else {
            format!("{} of its {height} rows of pixels are there", found.rows)
        };
        let error = if found.damaged { Jpeg.damaged(&detail) } else { Jpeg.cut_short(&detail) };
        job.incomplete(error, found.rows)?;
        // As high as what is there, with those scans that are whole that far.
        let whole = |scan: &Scan| {
            let part = Frame { height: found.rows, ..stream.frame.clone() };
            scan.is_first_of_dc() || coverage(&part, std::slice::from_ref(scan), bytes).whole
        };
        pixels(stream, bytes, None, found.rows, Coding::Told, whole)?
    };
    job.canvas()?.put(0, 0, width, Samples::U8(&decoded.samples))?;
    if decoded.height < height {
        job.canvas()?.leave(0, decoded.height, width, height - decoded.height);
    }
    Ok(())
}

/// Decodes a strip or tile of TIFF, whose tables may stand in a stream of their own. It may be larger than the `most` that is
/// wanted by what fills its last units.
pub(super) fn strip(bytes: &[u8], tables: Option<&[u8]>, coding: Coding, most: [usize; 2]) -> Result<Decoded> {
    let tables = tables.map(|bytes| Stream::parse(bytes).map(|stream| (stream, bytes))).transpose()?;
    let stream = Stream::parse(bytes)?;
    stream.check()?;
    let Frame { width, height, .. } = stream.frame;
    if width > most[0].next_multiple_of(UNIT) || height > most[1].next_multiple_of(UNIT) {
        return Err(Jpeg.damaged("its size is wrong"));
    }
    needs_memory(width * height * if stream.is_plain() { 3 } else { 8 })?;
    let tables = tables.as_ref().map(|(stream, bytes)| (stream, *bytes));
    pixels(&stream, bytes, tables, height, coding, |_| true)
}

/// The samples of a stream, so many rows: grey, R, G, B or inks.
fn pixels(
    stream: &Stream,
    bytes: &[u8],
    tables: Option<(&Stream, &[u8])>,
    height: usize,
    coding: Coding,
    keep: impl Fn(&Scan) -> bool,
) -> Result<Decoded> {
    let anew = stream.rebuilt(bytes, tables, height, keep);
    let channels = stream.frame.components.len();
    let is_ycc = match coding {
        Coding::Told => stream.is_ycc(),
        Coding::Ycc => channels >= 3,
        Coding::Plain => false,
    };
    let expected = stream.frame.width * height * channels;
    let samples = if stream.is_plain() && (channels == 1 || is_ycc) {
        by_zune(&anew, channels)?
    } else {
        by_jpeg_decoder(&anew, channels, is_ycc)?
    };
    if samples.len() != expected {
        return Err(Jpeg.damaged("its size is wrong"));
    }
    let inverted = coding == Coding::Told && channels == 4 && stream.adobe.is_some();
    let samples = if channels == 4 { inks(samples, is_ycc, inverted) } else { samples };
    Ok(Decoded { samples, channels, height })
}

fn by_zune(stream: &[u8], channels: usize) -> Result<Vec<u8>> {
    let colours = if channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    let options = DecoderOptions::default().set_max_width(MAX_SIDE).set_max_height(MAX_SIDE).jpeg_set_out_colorspace(colours);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(stream), options);
    decoded(Jpeg, || decoder.decode().map_err(|_| Jpeg.damaged("its picture cannot be decoded")))
}

fn by_jpeg_decoder(stream: &[u8], channels: usize, is_ycc: bool) -> Result<Vec<u8>> {
    use jpeg_decoder::{ColorTransform, Decoder, Error as Failed};
    let mut decoder = Decoder::new(stream);
    decoder.set_color_transform(match channels {
        1 => ColorTransform::Grayscale,
        3 if is_ycc => ColorTransform::YCbCr,
        3 => ColorTransform::RGB,
        _ => ColorTransform::CMYK,
    });
    let mut samples = decoded(Jpeg, || {
        decoder.decode().map_err(|error| match error {
            Failed::Unsupported(_) => Jpeg.unsupported("a coding that is rare"),
            _ => Jpeg.damaged("its picture cannot be decoded"),
        })
    })?;
    if channels == 4 {
        // It takes all of them for inverted.
        samples.iter_mut().for_each(|sample| *sample = 255 - *sample);
    }
    Ok(samples)
}

/// Inks, 0 for none, of four components as they are stored: luma, chroma and black, or inks; inverted where Adobe's mark says so.
fn inks(mut samples: Vec<u8>, is_ycck: bool, inverted: bool) -> Vec<u8> {
    for pixel in samples.chunks_exact_mut(4) {
        if is_ycck {
            let (luma, blue, red) = (f32::from(pixel[0]), f32::from(pixel[1]) - 128.0, f32::from(pixel[2]) - 128.0);
            let light = [luma + 1.402 * red, luma - 0.344_136 * blue - 0.714_136 * red, luma + 1.772 * blue];
            for (ink, light) in pixel.iter_mut().zip(light) {
                *ink = 255 - (light + 0.5).clamp(0.0, 255.0) as u8;
            }
        }
        if inverted {
            pixel.iter_mut().for_each(|ink| *ink = 255 - *ink);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_no_thousand_scans() {
        let frame = b"\xFF\xD8\xFF\xC2\0\x0B\x08\x10\0\x10\0\x01\x01\x11\0";
        let scan = b"\xFF\xDA\0\x08\x01\x01\0\0\0\0\0";
        let told = |scans| Stream::parse(&[&frame[..], &scan.repeat(scans)].concat()).map(|stream| stream.scans.len());
        assert_eq!(told(MAX_SCANS).unwrap(), MAX_SCANS);
        assert!(told(MAX_SCANS + 1).unwrap_err().to_string().contains("more than 256 scans"));
    }
}
