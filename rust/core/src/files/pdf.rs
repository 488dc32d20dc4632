//! A drawing as PDF: one page with filled vector paths, each layer an optional content group that viewers and editors show by name.
//!
//! Coordinates are whole units under one transform, curves are cubic, and greys are DeviceGray, so that a press prints them
//! with black alone. Other inks than black and white are separations of their names, each a plate by itself; what lies under them
//! is printed too where inks are laid over each other, and viewers multiply their colours there. The nonzero rule fills: holes run against their exteriors. There are no dates and no identifiers, so the same
//! drawing always gives the same bytes.
//!
//! # Size
//! A page's paths know no relative numbers and no quadratic curves, and would take four times the bytes of a compressed SVG. So
//! - curves are [fitted](super::fitting) by fewer cubics,
//! - points are rows of equal width, of which deflate gets the differences of their digits to the row above: PNG's predictor, which
//!   every reader needs for the tables of PDF files themselves,
//! - dots are moved to their places, so that those of one radius have the same text, and lie in an order of short ways.
//!
//! What this module does not do: fonts, images, or more than a page.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{BlendMode, ColorSpaceOperand, OverprintMode, Predictor};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};

use crate::base::{Error, Result};
use crate::drawing::Drawing;
use crate::files::cubic::{self, Piece, QUARTER, Sizes};
use crate::files::export::Export;
use crate::files::fitting::with_few_cubics;
use crate::files::layers::{Area, Layers, Outline};
use crate::files::layout::Placement;
use crate::files::plates::ALL;
use crate::files::strips::sort_in_strips;

/// The longest side of a page in the PDF's own units that Acrobat and others take. A longer page has larger units.
const LONGEST_SIDE: f64 = 14_400.0;

/// Deflate's effort.
const COMPRESSION: Compression = Compression::new(9);

/// The graphics state of layers under which others are printed.
const OVERPRINT: Name<'static> = Name(b"overprint");

/// PNG's name of a row that is its difference to the one above.
const UP: u8 = 2;

/// Dots that are moved one from another before the next is moved from the page's corner: renderers add up in single precision.
const DOTS_IN_A_ROW: usize = 64;

/// The drawing as the bytes of a PDF file.
///
/// # Errors
/// As [`super::layout::Layout::place`].
///
/// # Runtime
/// Linear in the number of coordinates.
pub(super) fn to_pdf(drawing: &Drawing, export: &Export) -> Result<Vec<u8>> {
    let placement = export.layout.place(drawing.width, drawing.height)?;
    let units = cubic::units_per_pixel(drawing);
    let layers = export.layers_of(&with_few_cubics(drawing, units), &placement)?;
    let groups: Vec<Group<'_>> = groups(&layers, drawing, &placement);
    let contents = contents(&groups, &placement, units);
    let compressed: std::io::Result<Vec<Stream>> = contents.into_iter().map(Stream::compressed).collect();
    compressed
        .map_err(|error| Error::Internal(format!("the PDF's content cannot be compressed: {error}")))
        .map(|streams| document(&groups, &inking(&layers, drawing), &placement, &streams))
}

/// An optional content group: the paper, the underlay or a layer.
struct Group<'a> {
    id: &'a str,
    label: &'a str,
    rgb: [u8; 3],
    /// The separation that it is painted on, if it is one.
    separation: Option<&'a str>,
    overprints: bool,
    shapes: Shapes<'a>,
}

/// What is filled.
enum Shapes<'a> {
    /// Left, top, right and bottom, in pixels.
    Rectangle([f64; 4]),
    Areas(&'a [Area]),
}

fn groups<'a>(layers: &'a Layers, drawing: &Drawing, placement: &Placement) -> Vec<Group<'a>> {
    let canvas = [drawing.width, drawing.height];
    let under = layers.grounds.iter().map(|ground| {
        let shapes = Shapes::Rectangle(ground.rectangle(canvas, placement));
        Group { id: ground.id, label: ground.label, rgb: ground.rgb, separation: None, overprints: false, shapes }
    });
    let of_layer = layers.layers.iter().map(|layer| {
        let shapes = Shapes::Areas(&layer.areas);
        let separation = layer.separation(&drawing.palette);
        Group { id: &layer.id, label: &layer.label, rgb: layer.rgb, separation, overprints: layers.overprint, shapes }
    });
    under.chain(of_layer).collect()
}

/// What inks are besides their areas.
struct Inking<'a> {
    /// The separations, with the colours that stand for them.
    separations: Vec<(&'a str, [u8; 3])>,
    /// How what lies under a layer is printed too, if it is.
    blending: Option<BlendMode>,
}

fn inking<'a>(layers: &'a Layers, drawing: &Drawing) -> Inking<'a> {
    let mut separations = layers.separations(&drawing.palette);
    for (_, rgb) in separations.iter_mut().filter(|(name, _)| *name != ALL) {
        *rgb = layers.painted(*rgb, &drawing.palette);
    }
    let blending = if layers.multiply { BlendMode::Multiply } else { BlendMode::Normal };
    Inking { separations, blending: layers.overprint.then_some(blending) }
}

/// How many points a unit of the page is.
fn user_unit(placement: &Placement) -> f64 {
    (placement.page[0].max(placement.page[1]) / LONGEST_SIDE).ceil().max(1.0)
}

fn document(groups: &[Group<'_>], inking: &Inking<'_>, placement: &Placement, streams: &[Stream]) -> Vec<u8> {
    let [catalog, pages, page, info] = [1, 2, 3, 4].map(Ref::new);
    let references: Vec<Ref> = (5..).map(Ref::new).take(groups.len()).collect();
    let contents: Vec<Ref> = (5 + groups.len() as i32..).map(Ref::new).take(streams.len()).collect();
    let tints = (5 + (groups.len() + streams.len()) as i32..).map(Ref::new);
    let separations: Vec<(&str, [u8; 3], Ref)> =
        inking.separations.iter().zip(tints).map(|((name, rgb), tint)| (*name, *rgb, tint)).collect();
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
    sheet.parent(pages).contents_array(contents.iter().copied());
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
    if !separations.is_empty() {
        let mut spaces = resources.insert(Name(b"ColorSpace")).dict();
        for (name, _, tint) in &separations {
            let mut space = spaces.insert(Name(name.as_bytes())).array();
            space.item(Name(b"Separation")).item(Name(name.as_bytes())).item(Name(b"DeviceRGB")).item(*tint);
        }
    }
    if let Some(mode) = inking.blending {
        let mut states = resources.ext_g_states();
        let mut state = states.insert(OVERPRINT).start::<ExtGraphicsState>();
        state.overprint(true).overprint_fill(true).overprint_mode(OverprintMode::IgnoreZeroChannel);
        if mode != BlendMode::Normal {
            state.blend_mode(mode);
        }
    }
    resources.finish();
    sheet.finish();

    for (_, rgb, tint) in separations {
        // From nothing to the full tint.
        let mut function = pdf.exponential_function(tint);
        function.domain([0.0, 1.0]).c0([1.0; 3]).c1(rgb.map(share)).n(1.0);
    }
    pdf.document_info(info).producer(TextStr(concat!("graphstipple ", env!("CARGO_PKG_VERSION"))));
    for (stream, reference) in streams.iter().zip(contents) {
        let mut written = pdf.stream(reference, &stream.bytes);
        written.filter(Filter::FlateDecode);
        if let Some(width) = stream.width {
            written.decode_parms().predictor(Predictor::PngUp).columns(width as i32);
        }
    }
    pdf.finish()
}

/// A part of the page's content.
struct Stream {
    bytes: Vec<u8>,
    /// That of the rows whose differences the bytes are, if they are that.
    width: Option<usize>,
}

impl Stream {
    fn compressed(self) -> std::io::Result<Self> {
        let mut encoder = ZlibEncoder::new(Vec::new(), COMPRESSION);
        encoder.write_all(&self.bytes)?;
        Ok(Self { bytes: encoder.finish()?, ..self })
    }
}

/// What is painted on the page.
fn contents(groups: &[Group<'_>], placement: &Placement, units: f64) -> Vec<Stream> {
    let mut streams = Vec::new();
    let mut content = Content::new();
    let unit = user_unit(placement);
    let scale = (placement.scale / units / unit) as f32;
    // Pages run upwards.
    let [x, y] = [placement.origin[0] / unit, (placement.page[1] - placement.origin[1]) / unit];
    content.transform([scale, 0.0, 0.0, -scale, x as f32, y as f32]);
    let mut sizes = Sizes::default();
    for group in groups {
        content.begin_marked_content_with_properties(Name(b"OC")).properties_named(Name(group.id.as_bytes()));
        match group.separation {
            Some(name) => drop(content.set_fill_color_space(ColorSpaceOperand::Named(Name(name.as_bytes()))).set_fill_color([1.0])),
            None => set_colour(&mut content, group.rgb),
        }
        if group.overprints {
            content.set_parameters(OVERPRINT);
        }
        match group.shapes {
            Shapes::Rectangle(sides) => {
                let [left, top, right, bottom] = sides.map(|v| (v * units) as f32);
                content.rect(left, top, right - left, bottom - top).fill_nonzero();
            }
            Shapes::Areas(areas) => match circles(areas) {
                Some(circles) => dots(&mut content, circles, &mut sizes, units),
                None => {
                    let before = std::mem::replace(&mut content, Content::new());
                    streams.push(Stream { bytes: before.finish().into_vec(), width: None });
                    streams.push(paths(areas, &mut sizes, units));
                }
            },
        }
        content.end_marked_content();
    }
    streams.push(Stream { bytes: content.finish().into_vec(), width: None });
    streams
}

/// What part of the whole a value of 8 bits is.
fn share(value: u8) -> f32 {
    f32::from(value) / 255.0
}

/// Sets what is filled with: grey where the colour is one, so that a press prints it with black alone.
fn set_colour(content: &mut Content, rgb: [u8; 3]) {
    let [red, green, blue] = rgb.map(share);
    if red == green && green == blue {
        content.set_fill_gray(red);
    } else {
        content.set_fill_rgb(red, green, blue);
    }
}

/// Centres and radii, if the areas are nothing but dots.
fn circles(areas: &[Area]) -> Option<Vec<[f64; 3]>> {
    let circle = |area: &Area| match area.exterior {
        Outline::Circle { x, y, radius } if area.holes.is_empty() => Some([x, y, radius]),
        _ => None,
    };
    areas.iter().map(circle).collect()
}

/// Fills dots, each a path of its own: those of one radius together, so that their texts follow each other.
fn dots(content: &mut Content, circles: Vec<[f64; 3]>, sizes: &mut Sizes, units: f64) {
    let mut circles: Vec<[f64; 3]> = circles.into_iter().map(|[x, y, radius]| [x, y, sizes.radius(radius)]).collect();
    circles.sort_by(|a, b| a[2].total_cmp(&b[2]));
    circles.chunk_by_mut(|a, b| a[2] == b[2]).for_each(to_and_fro);
    for row in circles.chunks(DOTS_IN_A_ROW) {
        content.save_state();
        let mut last = [0.0, 0.0];
        for [x, y, radius] in row {
            let place = [x, y].map(|v| (v * units).round());
            content.transform([1.0, 0.0, 0.0, 1.0, (place[0] - last[0]) as f32, (place[1] - last[1]) as f32]);
            last = place;
            // In thousandths: more digits of it would make no difference.
            let (r, k) = ((radius * units) as f32, ((radius * units * QUARTER * 1e3).round() / 1e3) as f32);
            content.move_to(-r, 0.0).cubic_to(-r, -k, -k, -r, 0.0, -r).cubic_to(k, -r, r, -k, r, 0.0);
            content.cubic_to(r, k, k, r, 0.0, r).cubic_to(-k, r, -r, k, -r, 0.0).close_path().fill_nonzero();
        }
        content.restore_state();
    }
}

/// Sorts circles in strips that hold a few beside each other.
fn to_and_fro(circles: &mut [[f64; 3]]) {
    let far = |axis: usize| circles.iter().fold(0.0, |far: f64, circle| far.max(circle[axis]));
    let strip = (3.0 * far(0) * far(1) / circles.len() as f64).sqrt().max(1.0);
    sort_in_strips(circles, strip, |[x, y, _]| [*x, *y]);
}

/// A point in units, and what is done at it: the operator it ends, or a space; whether the path closes; whether it is filled.
type Row = ([i32; 2], [u8; 3]);

/// Fills areas, each a path of its own.
fn paths(areas: &[Area], sizes: &mut Sizes, units: f64) -> Stream {
    let mut rows: Vec<Row> = Vec::new();
    for area in areas {
        let holes = area.holes.iter().map(|hole| (hole, true));
        for (outline, hole) in std::iter::once((&area.exterior, false)).chain(holes) {
            cubic::for_each_piece(&sizes.path_of(outline, hole, units), units, |piece| match piece {
                Piece::Move(p) => rows.push((p, *b"m  ")),
                Piece::Line(p) => rows.push((p, *b"l  ")),
                Piece::Curve([a, b, end]) => rows.extend([(a, *b"   "), (b, *b"   "), (end, *b"c  ")]),
                Piece::Close => rows.last_mut().expect("a path begins with a point").1[1] = b'h',
            });
        }
        rows.last_mut().expect("an area has a path").1[2] = b'f';
    }
    differences(&rows)
}

/// The rows as text of equal width, each as its difference to the one above.
fn differences(rows: &[Row]) -> Stream {
    let digits = rows.iter().flat_map(|(p, _)| p).map(|v| v.to_string().len()).max().unwrap_or(1);
    let text = |([x, y], [operator, close, fill]): &Row| {
        format!("{x:0digits$} {y:0digits$} {} {} {}\n", *operator as char, *close as char, *fill as char).into_bytes()
    };
    let width = 2 * digits + 8;
    let mut above = vec![0; width];
    let mut bytes = Vec::with_capacity(rows.len() * (width + 1));
    for row in rows {
        let row = text(row);
        bytes.push(UP);
        bytes.extend(row.iter().zip(&above).map(|(byte, above)| byte.wrapping_sub(*above)));
        above = row;
    }
    Stream { bytes, width: Some(width) }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::base::Ink;
    use crate::files::layers::Style;
    use crate::files::layout::Layout;
    use crate::files::svg::samples;
    use crate::options::Only;

    fn text_of(pdf: &[u8]) -> String {
        String::from_utf8_lossy(pdf).into_owned()
    }

    /// The content of a page, all its streams inflated and their differences added up.
    fn content_of(pdf: &[u8]) -> String {
        let mut content = Vec::new();
        let mut rest = pdf;
        while let Some(begin) = rest.windows(8).position(|w| w == b"\nstream\n") {
            let about = text_of(&rest[..begin]);
            let about = &about[about.rfind(" obj\n").unwrap()..];
            let mut bytes = Vec::new();
            flate2::read::ZlibDecoder::new(&rest[begin + 8..]).read_to_end(&mut bytes).unwrap();
            if let Some((_, columns)) = about.split_once("/Columns ") {
                let width: usize = columns.split_whitespace().next().unwrap().parse().unwrap();
                let mut above = vec![0; width];
                for row in bytes.chunks_exact(width + 1) {
                    assert_eq!(row[0], UP);
                    above = row[1..].iter().zip(&above).map(|(byte, above)| byte.wrapping_add(*above)).collect();
                    content.extend_from_slice(&above);
                }
            } else {
                content.append(&mut bytes);
            }
            content.push(b'\n');
            rest = &rest[begin + 8..];
        }
        String::from_utf8(content).unwrap()
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
        let scale = 0.75 / cubic::units_per_pixel(&drawing);
        assert!(content.starts_with(&format!("{scale} 0 0 -{scale} 0 36 cm\n/OC /black-regions BDC\n0 g\n")), "{content}");
        // Two black regions and four black dots, each a path of its own; the dots' circles have four curves each.
        let closed = drawing.regions.iter().filter(|r| r.ink == Ink::BLACK).count();
        assert_eq!([closed + 4; 3], ["m", "h", "f"].map(|operator| operators(&content, operator)));
        let curves: usize = [0, 2].map(|i| drawing.curves[i].segments().count()).iter().sum();
        assert!((17..=16 + curves).contains(&operators(&content, "c")), "{content}");
        assert!(text.contains("/Predictor 12"));
    }

    #[test]
    fn paper_is_painted_where_it_has_to_be() {
        let drawing = samples::nested();
        let units = cubic::units_per_pixel(&drawing);
        let whole = format!("0 0 {} {}", 64.0 * units, 48.0 * units);
        let layered = to_pdf(&drawing, &Export { style: Style::Layered, ..Export::default() }).unwrap();
        assert!(text_of(&layered).contains("(Paper)") && text_of(&layered).contains("(Level 1: black regions)"));
        let content = content_of(&layered);
        assert!(
            content.contains(&format!("/OC /paper BDC\n1 g\n{whole} re\nf\nEMC\n/OC /level-1-black-regions BDC\n0 g\n")),
            "{content}"
        );
        let scratchboard = to_pdf(&drawing, &Export { only: Only::named(&["white"]), ..Export::default() }).unwrap();
        let content = content_of(&scratchboard);
        assert!(content.contains(&format!("/OC /paper BDC\n0 g\n{whole} re\nf\nEMC\n/OC /white-regions BDC\n1 g\n")), "{content}");
    }

    #[test]
    fn sizes_and_long_pages() {
        let layout = Layout { width: Some("4in".parse().unwrap()), margin: "1in".parse().unwrap(), ..Layout::default() };
        let pdf = to_pdf(&samples::nested(), &Export { layout, ..Export::default() }).unwrap();
        assert!(text_of(&pdf).contains("/MediaBox [0 0 432 360]"));
        let scale = 4.5 / cubic::units_per_pixel(&samples::nested());
        assert!(content_of(&pdf).starts_with(&format!("{scale} 0 0 -{scale} 72 288 cm\n")));
        let layout = Layout { width: Some("400in".parse().unwrap()), ..Layout::default() };
        let pdf = to_pdf(&samples::nested(), &Export { layout, ..Export::default() }).unwrap();
        assert!(text_of(&pdf).contains("/MediaBox [0 0 14400 10800]") && text_of(&pdf).contains("/UserUnit 2"));
        let scale = 225.0 / cubic::units_per_pixel(&samples::nested());
        assert!(content_of(&pdf).starts_with(&format!("{scale} 0 0 -{scale} 0 10800 cm\n")));
    }

    #[test]
    fn every_mark_is_a_path_and_dots_of_one_radius_have_one_text() {
        let drawing = samples::field_of_blobs(400);
        let pdf = to_pdf(&drawing, &Export::default()).unwrap();
        let content = content_of(&pdf);
        assert_eq!((operators(&content, "m"), operators(&content, "f"), operators(&content, "q")), (800, 800, 7));
        let radii: std::collections::BTreeSet<&str> =
            content.lines().filter(|line| line.starts_with('-') && line.ends_with(" 0 m")).collect();
        // The sample has eleven; each is rounded down or up.
        assert!(radii.len() <= 22, "{radii:?}");
        // Ways of dots from the corner, added up.
        let mut places = Vec::new();
        let mut place = [0, 0];
        for line in content.lines().skip(1) {
            match line.split(' ').collect::<Vec<_>>()[..] {
                ["q"] => place = [0, 0],
                ["1", "0", "0", "1", x, y, "cm"] => {
                    place = [place[0] + x.parse::<i32>().unwrap(), place[1] + y.parse::<i32>().unwrap()];
                    places.push(place);
                }
                _ => {}
            }
        }
        let units = cubic::units_per_pixel(&drawing);
        let mut expected: Vec<[i32; 2]> =
            drawing.stipples.iter().map(|dot| [dot.x, dot.y].map(|v| (v * units).round() as i32)).collect();
        places.sort_unstable();
        expected.sort_unstable();
        assert_eq!(places, expected);
    }

    #[test]
    fn a_drawing_without_marks_is_an_empty_page() {
        let pdf = to_pdf(&samples::drawing(8, 8, vec![], &[]), &Export::default()).unwrap();
        assert!(!text_of(&pdf).contains("OCProperties"));
        assert!(content_of(&pdf).trim_end().ends_with(" 0 6 cm"));
    }
}
