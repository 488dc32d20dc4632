//! Kinds of files, told by their first bytes, never by a name; and the sentences for what is not read.

use crate::base::Error;

/// The most bytes of an embedded colour profile; real ones have a few thousand, those of presses a few million.
pub(super) const PROFILE_BYTES: usize = 16 << 20;

/// Bytes of a file that are looked at to tell its kind.
pub(super) const HEAD: usize = 1024;

/// What is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Container {
    Png,
    Jpeg,
    Tiff,
    WebP,
}

impl Container {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::WebP => "WebP",
        }
    }

    /// An error for a file whose bytes are not as they should be; `detail` says where.
    pub(super) fn damaged(self, detail: &str) -> Error {
        Error::Decode(format!("the {} file is damaged: {detail}", self.name()))
    }

    /// An error for a file that ends too soon.
    pub(super) fn cut_short(self, detail: &str) -> Error {
        Error::Decode(format!("the {} file is cut short: {detail}", self.name()))
    }

    /// An error for a file whose profile is no profile's size.
    pub(super) fn large_profile(self, bytes: usize) -> Error {
        let name = self.name();
        Error::Decode(format!(
            "the {name} file has a colour profile of {bytes} bytes or more, but at most {PROFILE_BYTES} are read"
        ))
    }

    /// An error for a file that may be sound, but of which nobody knows what its samples stand for.
    pub(super) fn meaningless(self, what: &str) -> Error {
        Error::Decode(format!("the {} file is of a kind that is not supported ({what}): save it anew as PNG", self.name()))
    }

    /// An error for a file that may be sound, but has what is not read.
    pub(super) fn unsupported(self, what: &str) -> Error {
        Error::Unsupported(format!(
            "the {} file is of a kind that is not supported ({what}): save it anew as PNG, or as plain {}",
            self.name(),
            self.name()
        ))
    }
}

/// An error for a picture that has no room.
pub(super) fn out_of_memory(bytes: usize) -> Error {
    Error::Decode(format!("there is not enough memory to read the image: {} MB more are needed", bytes.div_ceil(1_000_000)))
}

const CONVERT: &str = "convert it to PNG, JPEG, TIFF or WebP";
const PILLOW: &str = "convert it to PNG, JPEG, TIFF or WebP, or use graphstipple with Python, where Pillow reads it";
const HEIF: &str = "convert it to JPEG or PNG, or use graphstipple with Python, where Pillow reads it with pillow-heif installed";
const RAW: &str = "develop it with the camera's program to TIFF or JPEG";
const RENDER: &str = "render it as PNG";
const RASTERIZE: &str = "export it as PNG";
const FRAME: &str = "save one of its frames as PNG or JPEG";
const UNPACK: &str = "unpack it and give the image in it";

/// A way to tell a kind: bytes at an offset.
struct Mark(usize, &'static [u8], &'static str, &'static str);

/// Formats that are not read: their marks, names and ways out. The first that fits counts.
const FOREIGN: &[Mark] = &[
    Mark(0, b"GIF87a", "GIF", PILLOW),
    Mark(0, b"GIF89a", "GIF", PILLOW),
    Mark(0, b"\x00\x00\x00\x0CjP  ", "JPEG 2000", PILLOW),
    Mark(0, b"\xFF\x4F\xFF\x51", "JPEG 2000", PILLOW),
    Mark(0, b"\x00\x00\x00\x0CJXL ", "JPEG XL", CONVERT),
    Mark(0, b"\xFF\x0A", "JPEG XL", CONVERT),
    Mark(0, b"II\xBC", "JPEG XR", CONVERT),
    Mark(0, b"8BPS", "Photoshop (PSD)", RASTERIZE),
    Mark(0, b"gimp xcf", "GIMP (XCF)", RASTERIZE),
    Mark(0, b"%PDF", "PDF", RENDER),
    Mark(0, b"%!PS", "PostScript", RENDER),
    Mark(0, b"\xC5\xD0\xD3\xC6", "PostScript", RENDER),
    Mark(128, b"DICM", "DICOM", "export it as PNG or TIFF with a viewer of medical images"),
    Mark(0, b"SIMPLE  =", "FITS", CONVERT),
    Mark(0, b"v/1\x01", "OpenEXR", CONVERT),
    Mark(0, b"#?RADIANCE", "Radiance HDR", CONVERT),
    Mark(0, b"#?RGBE", "Radiance HDR", CONVERT),
    Mark(0, b"\x00\x00\x01\x00", "icon (ICO)", CONVERT),
    Mark(0, b"\x00\x00\x02\x00", "cursor (CUR)", CONVERT),
    Mark(0, b"icns", "icon (ICNS)", CONVERT),
    Mark(0, b"DDS ", "DDS", PILLOW),
    Mark(0, b"qoif", "QOI", PILLOW),
    Mark(0, b"\x59\xA6\x6A\x95", "Sun raster", PILLOW),
    Mark(0, b"\x01\xDA", "SGI", PILLOW),
    Mark(0, b"FLIF", "FLIF", CONVERT),
    Mark(0, b"FUJIFILMCCD-RAW", "a camera's raw (RAF)", RAW),
    Mark(0, b"IIRO", "a camera's raw (ORF)", RAW),
    Mark(0, b"IIRS", "a camera's raw (ORF)", RAW),
    Mark(0, b"MMOR", "a camera's raw (ORF)", RAW),
    Mark(0, b"IIU\0", "a camera's raw (RW2)", RAW),
    Mark(0, b"\0MRM", "a camera's raw (MRW)", RAW),
    Mark(0, b"FOVb", "a camera's raw (X3F)", RAW),
    Mark(0, b"HEAPCCDR", "a camera's raw (CRW)", RAW),
    Mark(6, b"HEAPCCDR", "a camera's raw (CRW)", RAW),
    Mark(8, b"CR\x02", "a camera's raw (CR2)", RAW),
    Mark(0, b"PK\x03\x04", "ZIP", UNPACK),
    Mark(0, b"\x1F\x8B", "gzip", UNPACK),
    Mark(0, b"7z\xBC\xAF\x27\x1C", "7z", UNPACK),
    Mark(0, b"Rar!", "RAR", UNPACK),
    Mark(0, b"\xFD7zXZ\0", "xz", UNPACK),
    Mark(0, b"BZh", "bzip2", UNPACK),
    Mark(0, b"\x28\xB5\x2F\xFD", "Zstandard", UNPACK),
    Mark(0, b"\x1A\x45\xDF\xA3", "video (Matroska)", FRAME),
    Mark(0, b"\x00\x00\x01\xBA", "video (MPEG)", FRAME),
    Mark(0, b"\x0A\x05\x01", "PCX", PILLOW),
    Mark(0, b"\x0A\x02\x01", "PCX", PILLOW),
    Mark(0, b"\xD7\xCD\xC6\x9A", "WMF", RENDER),
    Mark(40, b" EMF", "EMF", RENDER),
    Mark(0, b"AT&TFORM", "DjVu", RENDER),
    Mark(0, b"SQLite format 3", "a database", "give an image file"),
];

/// What kind a file is by its first bytes.
///
/// # Errors
/// [`Error::Unsupported`] for a format that Pillow may read, [`Error::Decode`] for other formats and for what is no image.
pub(super) fn kind_of(head: &[u8]) -> Result<Container, Error> {
    if head.is_empty() {
        return Err(Error::Decode("the file is empty".into()));
    }
    if let Some((name, way_out)) = foreign(head) {
        let sentence = format!("the file is {}, which is not read here: {way_out}", with_article(name));
        return Err(if [PILLOW, HEIF].contains(&way_out) { Error::Unsupported(sentence) } else { Error::Decode(sentence) });
    }
    if head.starts_with(b"\x89PNG\r\n\x1A\n") {
        if head.get(12..16) == Some(b"CgBI") {
            return Err(Error::Decode(
                "the file is a PNG as Apple's tools make them for apps (CgBI), which is not read here: convert it with pngcrush \
                 -revert-iphone-optimizations"
                    .into(),
            ));
        }
        return Ok(Container::Png);
    }
    if head.starts_with(b"\xFF\xD8") {
        return Ok(Container::Jpeg);
    }
    if [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|mark| head.starts_with(mark)) {
        return Ok(Container::Tiff);
    }
    if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP") {
        return Ok(Container::WebP);
    }
    Err(Error::Decode(told(head)))
}

/// Name and way out of a format that is not read.
fn foreign(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let marked = FOREIGN.iter().find(|Mark(at, bytes, ..)| head.get(*at..).is_some_and(|rest| rest.starts_with(bytes)));
    if let Some(Mark(_, _, name, way_out)) = marked {
        return Some((name, way_out));
    }
    match head {
        // A bitmap's header has a size of its own, and no two words begin like this.
        [b'B', b'M', ..] if matches!(head.get(14..18), Some([12 | 16 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0])) => {
            return Some(("BMP", PILLOW));
        }
        [b'P', b'1'..=b'7', b' ' | b'\n' | b'\r' | b'\t' | b'#', ..] | [b'P', b'F' | b'f', b'\n' | b'\r', ..] => {
            return Some(("PNM", PILLOW));
        }
        [b'R', b'I', b'F', b'F', ..] => match head.get(8..12) {
            Some(b"AVI ") => return Some(("video (AVI)", FRAME)),
            Some(b"WAVE") => return Some(("sound (WAV)", "give an image file")),
            _ => {}
        },
        _ => {}
    }
    if head.get(4..8) == Some(b"ftyp") {
        // The brand that it is made for, then those that it can be read as.
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let brands = head.get(8..length.max(12).min(head.len())).unwrap_or_default();
        let major = brands.get(..4).unwrap_or_default();
        let has = |wanted: &[&[u8]]| brands.chunks_exact(4).any(|brand| wanted.contains(&brand));
        return Some(match major {
            b"crx " => ("a camera's raw (CR3)", RAW),
            b"avif" | b"avis" => ("AVIF", PILLOW),
            _ if has(&[b"avif", b"avis"]) => ("AVIF", PILLOW),
            _ if has(&[b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1"]) => ("HEIC", HEIF),
            _ => ("video (MP4 or MOV)", FRAME),
        });
    }
    text(head)
}

/// Kinds that are text.
fn text(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let text = String::from_utf8_lossy(head).trim_start().to_ascii_lowercase();
    if text.starts_with("version https://git-lfs") {
        return Some(("a pointer of Git LFS instead of the image", "fetch the image with git lfs pull"));
    }
    if text.starts_with("<!doctype html") || text.starts_with("<html") || text.starts_with("<head") || text.starts_with("<body") {
        return Some(("an HTML page", "download the image itself"));
    }
    if text.starts_with("<svg") || (text.starts_with('<') && text.contains("<svg")) {
        return Some(("SVG", RENDER));
    }
    if text.starts_with("<?xml") && text.contains("html") {
        return Some(("an HTML page", "download the image itself"));
    }
    None
}

/// A name with what belongs in front of it.
fn with_article(name: &str) -> String {
    let has_article = name.starts_with("a ") || name.starts_with("an ");
    if name.starts_with("a camera's raw") {
        name.replacen("raw", "raw file", 1)
    } else if has_article || !name.starts_with(char::is_lowercase) {
        name.to_owned()
    } else {
        let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
        format!("{article} {name}")
    }
}

/// What to say of bytes that are no image.
fn told(head: &[u8]) -> String {
    let known = "PNG, JPEG, TIFF or WebP";
    let printable = head.iter().all(|byte| matches!(byte, b'\t' | b'\n' | b'\r' | 0x20..=0x7E | 0x80..));
    if head.iter().all(|byte| *byte == 0) {
        format!("the file holds nothing but zeros, so it is no image ({known})")
    } else if printable && std::str::from_utf8(&head[..head.len().min(256)]).is_ok() {
        format!("the file is text, not an image in a format that is read: {known}")
    } else {
        format!("the file is not an image in a format that is read: {known}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_of_a_video_that_ends_at_once_is_told_as_one() {
        for length in 8..16 {
            let head = &b"\0\0\0\x08ftypheic"[..length.min(12)];
            let told = kind_of(head).unwrap_err().to_string();
            assert!(told.contains(if length < 12 { "video" } else { "HEIC" }), "{told}");
        }
    }
}
