//! A drawing as PDF: one page with filled vector paths, each layer an optional content group that viewers and editors show by name.
//!
//! Coordinates are whole 64ths of a pixel under one transform, curves are cubic, and the inks are DeviceGray, so that a press
//! prints them with black alone. The nonzero rule fills: holes run against their exteriors. The content is deflated. There are no
//! dates and no identifiers, so the same drawing always gives the same bytes.
//!
//! What this module does not do: fonts, images, or more than a page.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};

use crate::base::{Error, Result};
use crate::drawing::Drawing;
use crate::files::cubic::{self, Piece, UNITS_PER_PIXEL};
use crate::files::export::Export;
use crate::files::layers::{Area, Layers};
use crate::files::layout::Placement;

/// The longest side of a page in the PDF's own units that Acrobat and others take. A longer page has larger units.
const LONGEST_SIDE: f64 = 14_400.0;

/// A path is filled and another one begun after this many pieces: viewers skip a path that is out of view, and some slow down with
/// the square of a path's length. The areas of a layer are disjoint, so the picture is the same.
const PATH_PIECES: usize = 4096;

/// Deflate's effort: level 6 takes twice as long for half a per cent.
const COMPRESSION: Compression = Compression::new(5);

/// The drawing as the bytes of a PDF file.
///
/// # Errors
/// As [`super::layout::Layout::place`].
///
/// # Runtime
/// Linear in the number of coordinates.
pub(super) fn to_pdf(drawing: &Drawing, export: &Export) -> Result<Vec<u8>> {
    let placement = export.layout.place(drawing.width, drawing.height)?;
    let layers = drawing.layers(export.style, export.inks, export.paper.as_ref());
    let groups: Vec<Group<'_>> = groups(&layers, [drawing.width, drawing.height], &placement);

    let mut encoder = ZlibEncoder::new(Vec::new(), COMPRESSION);
    encoder
        .write_all(&content(&groups, &placement))
        .and_then(|()| encoder.finish())
        .map_err(|error| Error::Internal(format!("the PDF's content cannot be compressed: {error}")))
        .map(|compressed| document(&groups, &placement, &compressed))
}

/// An optional content group: what lies under the layers, or a layer.
struct Group<'a> {
    id: &'a str,
    label: &'a str,
    rgb: [u8; 3],
    shapes: Shapes<'a>,
}

/// What is filled.
enum Shapes<'a> {
    /// Left, top, right and bottom, in pixels.
    Rectangle([f64; 4]),
    Areas(&'a [Area]),
}

fn groups<'a>(layers: &'a Layers, canvas: [usize; 2], placement: &Placement) -> Vec<Group<'a>> {
    let under = layers.grounds.iter().map(|ground| {
        let shapes = Shapes::Rectangle(ground.rectangle(canvas, placement));
        Group { id: ground.id, label: ground.label, rgb: ground.rgb, shapes }
    });
    let of_layer = layers.layers.iter().map(|layer| {
        let shapes = Shapes::Areas(&layer.areas);
        Group { id: &layer.id, label: &layer.label, rgb: layers.colour(layer.ink), shapes }
    });
    under.chain(of_layer).collect()
}

/// How many points a unit of the page is.
fn user_unit(placement: &Placement) -> f64 {
    (placement.page[0].max(placement.page[1]) / LONGEST_SIDE).ceil().max(1.0)
}

fn document(groups: &[Group<'_>], placement: &Placement, content: &[u8]) -> Vec<u8> {
    let [catalog, pages, page, info, stream] = [1, 2, 3, 4, 5].map(Ref::new);
    let references: Vec<Ref> = (6..).map(Ref::new).take(groups.len()).collect();
    let mut pdf = Pdf::new();

    let mut root = pdf.catalog(catalog);
    root.pages(pages);
    if !groups.is_empty() {
        let mut properties = root.insert(Name(b"OCProperties")).dict();
        properties.insert(Name(b"OCGs")).array().items(references.iter().copied());
        let mut shown = properties.insert(Name(b"D")).dict();
        // Layer panels list the topmost first.
        shown.insert(Name(b"Order")).array().items(references.iter().rev().copied());
    }
    root.finish();
    for (group, reference) in groups.iter().zip(&references) {
        let mut dictionary = pdf.indirect(*reference).dict();
        dictionary.pair(Name(b"Type"), Name(b"OCG"));
        dictionary.pair(Name(b"Name"), TextStr(group.label));
    }

    pdf.pages(pages).kids([page]).count(1);
    let unit = user_unit(placement);
    let mut sheet = pdf.page(page);
    sheet.parent(pages).contents(stream);
    sheet.media_box(Rect::new(0.0, 0.0, (placement.page[0] / unit) as f32, (placement.page[1] / unit) as f32));
    if unit > 1.0 {
        sheet.user_unit(unit as f32);
    }
    let mut resources = sheet.resources();
    let mut properties = resources.insert(Name(b"Properties")).dict();
    for (group, reference) in groups.iter().zip(&references) {
        properties.pair(Name(group.id.as_bytes()), *reference);
    }
    properties.finish();
    resources.finish();
    sheet.finish();

    pdf.document_info(info).producer(TextStr(concat!("graphstipple ", env!("CARGO_PKG_VERSION"))));
    pdf.stream(stream, content).filter(Filter::FlateDecode);
    pdf.finish()
}

/// What is painted on the page.
fn content(groups: &[Group<'_>], placement: &Placement) -> Vec<u8> {
    let mut content = Content::new();
    let unit = user_unit(placement);
    let scale = (placement.scale / UNITS_PER_PIXEL / unit) as f32;
    // Pages run upwards.
    let [x, y] = [placement.origin[0] / unit, (placement.page[1] - placement.origin[1]) / unit];
    content.transform([scale, 0.0, 0.0, -scale, x as f32, y as f32]);
    for group in groups {
        content.begin_marked_content_with_properties(Name(b"OC")).properties_named(Name(group.id.as_bytes()));
        set_colour(&mut content, group.rgb);
        match group.shapes {
            Shapes::Rectangle(sides) => {
                let [left, top, right, bottom] = sides.map(|v| (v * UNITS_PER_PIXEL) as f32);
                content.rect(left, top, right - left, bottom - top).fill_nonzero();
            }
            Shapes::Areas(areas) => fill(&mut content, areas),
        }
        content.end_marked_content();
    }
    content.finish().into_vec()
}

/// Sets what is filled with: grey where the colour is one, so that a press prints it with black alone.
fn set_colour(content: &mut Content, rgb: [u8; 3]) {
    let [red, green, blue] = rgb.map(|v| f32::from(v) / 255.0);
    if red == green && green == blue {
        content.set_fill_gray(red);
    } else {
        content.set_fill_rgb(red, green, blue);
    }
}

/// Fills areas of one ink.
fn fill(content: &mut Content, areas: &[Area]) {
    let mut pieces = 0;
    for (i, area) in areas.iter().enumerate() {
        let exterior = cubic::path_of(&area.exterior, false);
        for path in std::iter::once(exterior).chain(area.holes.iter().map(|hole| cubic::path_of(hole, true))) {
            cubic::for_each_piece(&path, |piece| {
                pieces += 1;
                let float = |p: [i32; 2]| (p[0] as f32, p[1] as f32);
                match piece {
                    Piece::Move(p) => {
                        let (x, y) = float(p);
                        content.move_to(x, y);
                    }
                    Piece::Line(p) => {
                        let (x, y) = float(p);
                        content.line_to(x, y);
                    }
                    Piece::Curve(points) => {
                        let [(x1, y1), (x2, y2), (x3, y3)] = points.map(float);
                        content.cubic_to(x1, y1, x2, y2, x3, y3);
                    }
                    Piece::Close => {
                        content.close_path();
                    }
                }
            });
        }
        if pieces >= PATH_PIECES || i + 1 == areas.len() {
            content.fill_nonzero();
            pieces = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::base::Ink;
    use crate::files::layers::Style;
    use crate::files::layout::Layout;
    use crate::files::svg::samples;
    use crate::options::Inks;

    fn text_of(pdf: &[u8]) -> String {
        String::from_utf8_lossy(pdf).into_owned()
    }

    /// The inflated content of a file.
    fn content_of(pdf: &[u8]) -> String {
        let find = |what: &[u8]| pdf.windows(what.len()).position(|w| w == what).unwrap() + what.len();
        let mut content = String::new();
        flate2::read::ZlibDecoder::new(&pdf[find(b"\nstream\n")..]).read_to_string(&mut content).unwrap();
        content
    }

    fn operators(content: &str, operator: &str) -> usize {
        content.split_ascii_whitespace().filter(|word| *word == operator).count()
    }

    #[test]
    fn a_flat_drawing_has_a_group_for_each_kind_of_mark() {
        let drawing = samples::nested();
        let pdf = to_pdf(&drawing, &Export::default()).unwrap();
        assert_eq!(pdf, to_pdf(&drawing, &Export::default()).unwrap());
        assert!(pdf.starts_with(b"%PDF-1.7"));
        let text = text_of(&pdf);
        assert!(text.contains("/MediaBox [0 0 48 36]"), "{text}");
        assert_eq!(text.matches("/Type /OCG").count(), 2);
        for name in ["(Black regions)", "(Black stipples)", concat!("(graphstipple ", env!("CARGO_PKG_VERSION"), ")")] {
            assert!(text.contains(name), "no {name} in {text}");
        }
        assert!(!text.contains("Date") && !text.contains("/UserUnit"));
        let content = content_of(&pdf);
        assert!(content.starts_with("0.01171875 0 0 -0.01171875 0 36 cm\n/OC /black-regions BDC\n0 g\n"), "{content}");
        // Two black regions and four black dots; the dots' circles have four curves each.
        let black_curves: usize = [0, 2].map(|i| drawing.curves[i].segments().count()).iter().sum();
        let closed = drawing.regions.iter().filter(|r| r.ink == Ink::Black).count();
        assert_eq!((operators(&content, "m"), operators(&content, "h"), operators(&content, "f")), (closed + 4, closed + 4, 2));
        assert_eq!(operators(&content, "c"), black_curves + 16);
    }

    #[test]
    fn paper_is_painted_where_it_has_to_be() {
        let drawing = samples::nested();
        let layered = to_pdf(&drawing, &Export { style: Style::Layered, ..Export::default() }).unwrap();
        assert!(text_of(&layered).contains("(Paper)") && text_of(&layered).contains("(Level 1: black regions)"));
        let content = content_of(&layered);
        assert!(
            content.contains("/OC /paper BDC\n1 g\n0 0 4096 3072 re\nf\nEMC\n/OC /level-1-black-regions BDC\n0 g\n"),
            "{content}"
        );
        let scratchboard = to_pdf(&drawing, &Export { inks: Inks::White, ..Export::default() }).unwrap();
        let content = content_of(&scratchboard);
        assert!(content.contains("/OC /paper BDC\n0 g\n0 0 4096 3072 re\nf\nEMC\n/OC /white-regions BDC\n1 g\n"), "{content}");
    }

    #[test]
    fn a_paper_covers_the_page_and_both_inks_lie_on_black() {
        let mut export = Export { paper: Some("#ff8000".parse().unwrap()), ..Export::default() };
        export.layout.margin = "8px".parse().unwrap();
        let orange = |export: &Export| content_of(&to_pdf(&samples::nested(), export).unwrap());
        let paper = "/OC /paper BDC\n1 0.5019608 0 rg\n-512 -512 5120 4096 re\nf\nEMC\n";
        assert!(orange(&export).contains(&format!("{paper}/OC /black-regions BDC\n0 g\n")), "{}", orange(&export));
        export.style = Style::Layered;
        assert!(orange(&export).contains("/OC /level-2-white-regions BDC\n1 0.5019608 0 rg\n"));
        (export.style, export.inks) = (Style::Flat, Inks::Both);
        let content = orange(&export);
        assert!(
            content.contains(&format!("{paper}/OC /underlay BDC\n0 g\n0 0 4096 3072 re\nf\nEMC\n/OC /black-regions BDC\n0 g\n"))
        );
        assert!(content.contains("/OC /white-regions BDC\n1 g\n"));
    }

    #[test]
    fn sizes_and_long_pages() {
        let layout = Layout { width: Some("4in".parse().unwrap()), margin: "1in".parse().unwrap(), ..Layout::default() };
        let pdf = to_pdf(&samples::nested(), &Export { layout, ..Export::default() }).unwrap();
        assert!(text_of(&pdf).contains("/MediaBox [0 0 432 360]"));
        assert!(content_of(&pdf).starts_with("0.0703125 0 0 -0.0703125 72 288 cm\n"));
        let layout = Layout { width: Some("400in".parse().unwrap()), ..Layout::default() };
        let pdf = to_pdf(&samples::nested(), &Export { layout, ..Export::default() }).unwrap();
        assert!(text_of(&pdf).contains("/MediaBox [0 0 14400 10800]") && text_of(&pdf).contains("/UserUnit 2"));
    }

    #[test]
    fn long_layers_are_split_between_areas() {
        let pdf = to_pdf(&samples::field_of_blobs(4000), &Export::default()).unwrap();
        let content = content_of(&pdf);
        assert_eq!(operators(&content, "m"), 8000);
        assert!((10..40).contains(&operators(&content, "f")), "{}", operators(&content, "f"));
    }

    #[test]
    fn a_drawing_without_marks_is_an_empty_page() {
        let pdf = to_pdf(&samples::drawing(8, 8, vec![], &[]), &Export::default()).unwrap();
        assert!(!text_of(&pdf).contains("OCProperties"));
        assert_eq!(content_of(&pdf).trim_end(), "0.01171875 0 0 -0.01171875 0 6 cm");
    }
}
