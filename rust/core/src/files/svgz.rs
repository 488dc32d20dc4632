//! SVG, compressed by gzip (RFC 1952) as browsers and Inkscape read it: neither time nor name, so that the same drawing gives the same
//! bytes; and back.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;

use crate::base::{Control, Error, Result};
use crate::drawing::{Drawing, invalid};
use crate::files::export::Export;
use crate::files::load_svg::from_svg;
use crate::files::svg::to_svg;

/// The most bytes that a file may unpack to: a few bytes can come to thousands of times as many, and an SVG of ten million nodes has
/// a quarter of it.
const MOST_BYTES: u64 = 1 << 30;

/// The drawing as the bytes of a compressed SVG.
///
/// # Errors
/// As [`to_svg`].
pub(super) fn to_svgz(drawing: &Drawing, export: &Export) -> Result<Vec<u8>> {
    let svg = to_svg(drawing, export)?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(svg.as_bytes()).and_then(|()| encoder.finish());
    written.map_err(|error| Error::Internal(format!("the SVG cannot be compressed: {error}")))
}

/// Reads what [`to_svgz`] wrote.
///
/// # Errors
/// [`Error::Input`] if it is something else, or unpacks to more than 1 GiB.
pub(super) fn from_svgz(bytes: &[u8], control: &Control) -> Result<Drawing> {
    unpacked(bytes, MOST_BYTES).and_then(|svg| from_svg(&svg, control))
}

fn unpacked(bytes: &[u8], most: u64) -> Result<Vec<u8>> {
    let mut svg = Vec::new();
    MultiGzDecoder::new(bytes).take(most + 1).read_to_end(&mut svg).map_err(|error| invalid(format!("it is no gzip ({error})")))?;
    if svg.len() as u64 > most {
        return Err(Error::Input(format!("the file unpacks to more than {most} bytes, which is as much as is read")));
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::svg::samples;

    #[test]
    fn what_is_broken_or_unpacks_to_too_much_is_refused() {
        let told = |bytes: &[u8], most: u64| unpacked(bytes, most).unwrap_err().to_string();
        let bytes = to_svgz(&samples::nested(), &Export::default()).unwrap();
        assert_eq!(told(&bytes, 1000), "the file unpacks to more than 1000 bytes, which is as much as is read");
        for broken in [&bytes[..bytes.len() - 9], &b"<svg/>"[..], &b""[..]] {
            assert!(told(broken, MOST_BYTES).starts_with("this is not a drawing that graphstipple wrote: it is no gzip ("));
        }
    }
}
