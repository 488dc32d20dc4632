//! The drawing as pixels: an antialiased grey raster by tiny-skia from the same marks as the SVG, and its PNG.
//!
//! # How
//! The marks of a level are disjoint and share their ink, so a level is one path: marks that meet in a pixel add their
//! coverage there, and no seam shows. Every outline is flattened once, onto a grid of 1/256 px, which is as fine as tiny-skia
//! looks, and then painted in bands of rows, in parallel. The bands depend on the width alone, so the raster is
//! the same for any number of threads, and memory stays at a byte a pixel and a few megabytes a thread.
//!
//! A part of the canvas is painted of what is seen of it (a window): curves outside are one line each, and polygons are cut a little
//! outside of it. So a look at single dots costs what they do, at any scale.
//!
//! What this module does not do: files (the command line and Python write what [`to_png`] and [`encode_png`] return).

use std::borrow::Cow;

use kurbo::{BezPath, PathEl, Point};
use png::{BitDepth, ColorType, DeflateCompression, Encoder, Filter, PixelDimensions, Unit};
use rayon::prelude::*;
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Transform};

use crate::base::{Error, Ink, Pool, Result, circle_polygon};
use crate::drawing::{Drawing, Mark, Ring, RingPart};
use crate::files::export::Export;
use crate::files::layers::{self, Area, Drawn, colours};
use crate::files::layout::{PX_PER_INCH, PixelPlacement};
use crate::files::registration;
use crate::photo::MAX_SIDE;

/// The most pixels that a raster may have: a poster of A0 size at 800 dots per inch, and a gigabyte of memory.
pub const MAX_PIXELS: usize = 1 << 30;

/// How far a flattened curve may lie from the true one, in pixels of the raster. The chords of a convex outline lie inside it,
/// so this takes ink from small loops: 0.3 % at 20 px^2. Half of it costs a third more points.
const CURVE_TOLERANCE: f64 = 0.01;

/// The same for dots, whose polygons have the circle's area whatever their number of sides.
const DOT_TOLERANCE: f64 = 0.05;

/// Positions per pixel that tiny-skia tells apart when it antialiases. On this grid a whole number of rows up or down changes
/// nothing, in floats of 24 bits up to 65535 px.
const GRID: f64 = 256.0;

/// Pixels of a band, roughly: 4 bytes each while it is painted. Smaller bands clip more outlines, larger ones leave threads idle.
const BAND_PIXELS: usize = 1 << 17;

/// Side of the smallest part of a canvas that is painted by itself, in pixels of the canvas: a few dozen units of the grid on which
/// outlines lie.
const SMALLEST_PART: f64 = 0.01;

/// What a width may be.
const SIDES: &str = "between 1 and 65535 pixels";

/// How files are compressed: level 4 is three times as fast as the default, level 6, for files that are at most a tenth larger.
const DEFLATE: DeflateCompression = DeflateCompression::Level(4);

/// A grey raster: 0 black, 255 white, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// 1 for grey, or 3 for red, green and blue (sRGB).
    pub channels: usize,
    /// `width * height * channels` values.
    pub values: Vec<u8>,
}

/// Paints the drawing on its paper, white by default, `width` pixels wide and as high as the canvas's proportions say (rounded, at least 1);
/// `None` is the canvas's own size.
///
/// # Errors
/// [`Error::Option`] if `width` is 0 or above [`MAX_SIDE`]; [`Error::Input`] if the height comes out above it, or the
/// raster would have more than [`MAX_PIXELS`] pixels.
///
/// # Allocations
/// A byte a pixel, about 8 bytes a point of the flattened outlines, and a band of pixels a thread.
pub fn rasterize(drawing: &Drawing, width: Option<usize>) -> Result<Raster> {
    let (width, height) = size(drawing.width, drawing.height, width)?;
    Ok(Pool::new(None).run(|| rasterize_to(drawing, width, height)))
}

/// Paints a part of the canvas, given by its left, top, right and bottom in pixels of the canvas, `width` pixels wide and as high as
/// the part's proportions say (rounded, at least 1). Where the part lies on the pixels of a whole raster at the same scale, it shows
/// the same.
///
/// # Errors
/// [`Error::Option`] if the part is empty or not on the canvas, and as [`rasterize`] of what is painted.
///
/// # Allocations
/// As [`rasterize`], of what lies in the part.
pub fn rasterize_part(drawing: &Drawing, part: [f64; 4], width: usize) -> Result<Raster> {
    let [left, top, right, bottom] = part;
    let [across, down] = [right - left, bottom - top];
    // Comparisons that are false for what is no number.
    let is_on_canvas = left >= 0.0 && top >= 0.0 && right <= drawing.width as f64 && bottom <= drawing.height as f64;
    if !(is_on_canvas && across >= SMALLEST_PART && down >= SMALLEST_PART) {
        let [columns, rows] = [drawing.width, drawing.height];
        let allowed =
            format!("left, top, right and bottom on the canvas of {columns} x {rows} pixels, {SMALLEST_PART} apart at least");
        return Err(Error::option("part", format!("({left}, {top}, {right}, {bottom})"), allowed));
    }
    if width == 0 || width > MAX_SIDE {
        return Err(Error::option("width", width, SIDES));
    }
    let height = (down * width as f64 / across).round().clamp(1.0, (MAX_SIDE + 1) as f64) as usize;
    check_size(width, height)?;
    let scale = [width as f64 / across, height as f64 / down];
    let window = Window::of(part, scale);
    Ok(Pool::new(None).run(|| {
        // Smaller bands: whoever looks at a part waits for it, and what lies outside is clipped already.
        painted(drawing, [width, height], scale, Some(&window), (rows_of_a_band(width) / 4).max(16))
    }))
}

fn rasterize_to(drawing: &Drawing, width: usize, height: usize) -> Raster {
    let scale = [width as f64 / drawing.width as f64, height as f64 / drawing.height as f64];
    painted(drawing, [width, height], scale, None, rows_of_a_band(width))
}

/// The raster of a drawing, or of what is seen of it in a window, painted in bands of `rows` rows.
fn painted(drawing: &Drawing, [width, height]: [usize; 2], scale: [f64; 2], window: Option<&Window>, rows: usize) -> Raster {
    if drawing.palette.is_black_and_white() {
        let levels = flatten(drawing, scale, window);
        return Raster { width, height, channels: 1, values: paint(&levels, width, height, rows) };
    }
    let colours: Vec<[u8; 3]> = drawing.palette.labels().map(|label| drawing.palette.rgb(label)).collect();
    painted_in(drawing, &colours, &[], [width, height], scale, window, rows)
}

/// What is laid beside the marks of a label, lapping over them or not, and the change of colour where it is.
struct Laid {
    label: Ink,
    areas: Vec<Area>,
    change: [i32; 3],
}

/// What of a label is painted in colours. What is laid beside its marks is painted with them, as one: no seam shows, and what that adds
/// to the label is what it covers.
struct OfLabel {
    /// The label's marks, and behind them what is laid beside these.
    batches: Vec<Polygons>,
    /// How many are of the marks.
    own: usize,
    colour: [u8; 3],
    /// The change of colour where something is laid.
    change: [i32; 3],
}

/// The same in colours, one for every label: what every label covers of a pixel is summed up, so that where two meet no third shows.
fn painted_in(
    drawing: &Drawing,
    colours: &[[u8; 3]],
    laid: &[Laid],
    [width, height]: [usize; 2],
    scale: [f64; 2],
    window: Option<&Window>,
    rows: usize,
) -> Raster {
    let mut of_labels: Vec<Vec<Mark>> = vec![Vec::new(); colours.len()];
    for &mark in &drawing.order {
        let ink = match mark {
            Mark::Stipple(i) => drawing.stipples[i as usize].ink,
            Mark::Region(i) => drawing.regions[i as usize].ink,
        };
        of_labels[ink.index()].push(mark);
    }
    let flat = |marks: &[Mark]| -> Vec<Polygons> {
        marks.par_chunks(BATCH).map(|marks| flatten_batch(drawing, scale, marks, window, true)).collect()
    };
    let of_label = |label: usize| {
        let mut batches = flat(&of_labels[label]);
        let own = batches.len();
        let laid = laid.iter().find(|laid| laid.label.index() == label);
        batches.extend(laid.map(|laid| flattened_areas(&laid.areas, scale)));
        OfLabel { batches, own, colour: colours[label], change: laid.map_or([0; 3], |laid| laid.change) }
    };
    let flattened: Vec<OfLabel> = (0..colours.len()).filter(|label| !of_labels[*label].is_empty()).map(of_label).collect();
    let mut values = vec![0u8; 3 * width * height];
    values.par_chunks_mut(3 * width * rows).enumerate().for_each(|(band, values)| {
        let mut covered = vec![0u8; values.len() / 3];
        let mut sums = vec![[0i32; 4]; covered.len()];
        for OfLabel { batches, own, colour, change } in &flattened {
            paint_band([(Ink::WHITE, &batches[..*own])], Color::BLACK, width, band * rows, &mut covered);
            for (sum, covered) in sums.iter_mut().zip(&covered).filter(|(_, covered)| **covered > 0) {
                let covered = i32::from(*covered);
                for channel in 0..3 {
                    sum[channel] += covered * i32::from(colour[channel]);
                }
                sum[3] += covered;
            }
            if *own < batches.len() {
                let mut both = vec![0u8; covered.len()];
                paint_band([(Ink::WHITE, &batches[..])], Color::BLACK, width, band * rows, &mut both);
                for (sum, (both, covered)) in sums.iter_mut().zip(both.iter().zip(&covered)) {
                    let more = i32::from(both.saturating_sub(*covered));
                    for channel in 0..3 {
                        sum[channel] += more * change[channel];
                    }
                }
            }
        }
        for (pixel, [red, green, blue, whole]) in values.chunks_exact_mut(3).zip(sums) {
            let whole = whole.max(1);
            pixel.copy_from_slice(&[red, green, blue].map(|sum| ((sum + whole / 2) / whole).clamp(0, 255) as u8));
        }
    });
    Raster { width, height, channels: 3, values }
}

fn rows_of_a_band(width: usize) -> usize {
    (BAND_PIXELS / width).clamp(16, 1024)
}

/// The drawing as the bytes of a PNG file, of the size and resolution that the layout says. Without a paper its margins are white,
/// and `style` and `inks` make no difference: the picture is the same. With one the margins have its colour, and so has what is not
/// drawn with ink.
///
/// # Errors
/// As [`super::layout::Layout::place_pixels`] and [`check_size`].
///
/// # Allocations
/// As [`rasterize`], and a byte a pixel more where there are margins; in colours three a pixel.
pub fn to_png(drawing: &Drawing, export: &Export) -> Result<Vec<u8>> {
    let placement = export.layout.place_pixels(drawing.width, drawing.height)?;
    let [width, height] = placement.page;
    check_size(width, height)?;
    export.check_palette(&drawing.palette)?;
    if !drawing.palette.is_black_and_white() {
        return to_png_of_inks(drawing, export, &placement);
    }
    let Raster { values, .. } = rasterize_to(drawing, placement.drawing[0], placement.drawing[1]);
    let paper = export.paper.as_ref().map_or([255; 3], |paper| paper.rgb());
    let [black, white] = match &export.paper {
        None => [[0; 3], [255; 3]],
        Some(paper) => colours(export.style, Drawn::of(&export.only.of(&drawing.palette)?), Some(paper)),
    };
    let between = |grey: u8, channel: usize| {
        let [from, to] = [black, white].map(|colour| u32::from(colour[channel]));
        ((from * u32::from(255 - grey) + to * u32::from(grey) + 127) / 255) as u8
    };
    let in_grey = [black, white, paper].iter().all(|[red, green, blue]| red == green && green == blue);
    let pixels = if export.one_bit {
        let margin = if paper == black { 0 } else { 255 };
        let mut page = on_page(values, &placement, margin);
        if let Some(marks) = marks(export, &placement) {
            paint_marks(&mut page, width, &marks, |pixel, covered| if covered < 128 { pixel } else { 255 - margin });
        }
        let samples = page.chunks(width).flat_map(pack).collect();
        let is_plain = [black, white] == [[0; 3], [255; 3]];
        let (color, palette) = if is_plain { (ColorType::Grayscale, None) } else { (ColorType::Indexed, Some([black, white])) };
        Pixels { width, height, color, depth: BitDepth::One, palette, samples: Cow::Owned(samples) }
    } else if in_grey {
        let values = if [black, white] == [[0; 3], [255; 3]] { values } else { values.iter().map(|v| between(*v, 0)).collect() };
        let mut samples = on_page(values, &placement, paper[0]);
        if let Some(marks) = marks(export, &placement) {
            let [mark, ..] = export.rgb_of_marks(&drawing.palette)?;
            paint_marks(&mut samples, width, &marks, |pixel, covered| mixed(pixel, mark, covered));
        }
        Pixels { width, height, color: ColorType::Grayscale, depth: BitDepth::Eight, palette: None, samples: Cow::Owned(samples) }
    } else {
        let table: Vec<[u8; 3]> = (0..=255).map(|grey| [0, 1, 2].map(|channel| between(grey, channel))).collect();
        let page = on_page(values.iter().map(|v| table[usize::from(*v)]).collect(), &placement, paper);
        let samples = marked(page, drawing, export, &placement)?.into_flattened();
        Pixels { width, height, color: ColorType::Rgb, depth: BitDepth::Eight, palette: None, samples: Cow::Owned(samples) }
    };
    write_png(&pixels, placement.dpi, DEFLATE)
}

/// [`to_png`] of other inks than black and white.
fn to_png_of_inks(drawing: &Drawing, export: &Export, placement: &PixelPlacement) -> Result<Vec<u8>> {
    let palette = &drawing.palette;
    let drawn = export.only.of(palette)?;
    // A film: what the one ink covers is black.
    let paper = if export.one_bit { [255; 3] } else { export.paper.as_ref().map_or(palette.paper(), |paper| paper.rgb()) };
    let of_ink = |label: Ink| if export.one_bit { [0; 3] } else { palette.rgb(label) };
    let behind = if export.one_bit { [255; 3] } else { palette.of_plate(palette.inks().len()).paper() };
    let colour = |label: Ink| {
        if drawn[..] == [palette.inks().len()] {
            // The paper as the only ink.
            return if label == palette.paper_label() { of_ink(label) } else { behind };
        }
        // Without the inks that are not drawn.
        let shown = palette.with_only(label, &drawn);
        if shown == palette.paper_label() { paper } else { of_ink(shown) }
    };
    let colours: Vec<[u8; 3]> = palette.labels().map(colour).collect();
    let [across, down] = placement.drawing;
    let scale = [across as f64 / drawing.width as f64, down as f64 / drawing.height as f64];
    let mut laid: Vec<Laid> = Vec::new();
    if let Some(trap) = export.trap {
        let distance = trap.points() / export.layout.place(drawing.width, drawing.height)?.scale;
        let order = palette.lightest_first();
        for (place, ink) in order.iter().enumerate().filter(|(_, ink)| drawn.contains(ink)) {
            // Under darker inks that are drawn too, nothing is seen of it.
            let bare: Vec<usize> = order[place + 1..].iter().copied().filter(|other| !drawn.contains(other)).collect();
            let label = Ink::of_label(*ink as u8);
            let change = [0, 1, 2].map(|i| i32::from(of_ink(label)[i]) - i32::from(paper[i]));
            laid.push(Laid { label, areas: drawing.trap(*ink, &bare, distance)?, change });
        }
    }
    let rows = rows_of_a_band(across);
    let Raster { values, .. } = painted_in(drawing, &colours, &laid, placement.drawing, scale, None, rows);
    if export.one_bit {
        let mut page = on_page(values.chunks_exact(3).map(|pixel| pixel[0]).collect(), placement, 255);
        if let Some(marks) = marks(export, placement) {
            paint_marks(&mut page, placement.page[0], &marks, |pixel, covered| if covered < 128 { pixel } else { 0 });
        }
        let samples = Cow::Owned(page.chunks(placement.page[0]).flat_map(pack).collect());
        let [width, height] = placement.page;
        let (color, depth) = (ColorType::Grayscale, BitDepth::One);
        return write_png(&Pixels { width, height, color, depth, palette: None, samples }, placement.dpi, DEFLATE);
    }
    let pixels: Vec<[u8; 3]> = values.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let page = marked(on_page(pixels, placement, paper), drawing, export, placement)?;
    let samples = Cow::Owned(page.into_flattened());
    let [width, height] = placement.page;
    let pixels = Pixels { width, height, color: ColorType::Rgb, depth: BitDepth::Eight, palette: None, samples };
    write_png(&pixels, placement.dpi, DEFLATE)
}

/// Registration marks in pixels of the page, if they are asked for.
fn marks(export: &Export, placement: &PixelPlacement) -> Option<Polygons> {
    if !export.registration_marks {
        return None;
    }
    let ([across, down], [left, top]) = (placement.drawing, placement.origin);
    let per_inch = placement.dpi.unwrap_or(PX_PER_INCH);
    let areas = registration::marks([across as f64, down as f64], per_inch / 25.4);
    let mut polygons = flattened_areas(&areas, [1.0; 2]);
    polygons.points.iter_mut().for_each(|[x, y]| (*x, *y) = (*x + left as f32, *y + top as f32));
    polygons.outlines.iter_mut().for_each(|outline| {
        outline.top += top as f32;
        outline.bottom += top as f32;
    });
    Some(polygons)
}

/// Areas as what is painted, of so many pixels to one of the canvas.
fn flattened_areas(areas: &[Area], scale: [f64; 2]) -> Polygons {
    let mut polygons = Polygons { points: Vec::new(), outlines: Vec::new() };
    let tolerance = CURVE_TOLERANCE / scale[0].max(scale[1]);
    for area in areas {
        for (place, outline) in std::iter::once(&area.exterior).chain(&area.holes).enumerate() {
            let mut points = Vec::new();
            match outline {
                layers::Outline::Path(path) => {
                    kurbo::flatten(path.iter(), tolerance, |element| points.extend(element.end_point().map(|p| [p.x, p.y])));
                }
                layers::Outline::Circle { x, y, radius } => {
                    points = circle_polygon([*x, *y], *radius, DOT_TOLERANCE / scale[0].max(scale[1]));
                    if place > 0 {
                        points.reverse();
                    }
                }
            }
            polygons.push(scale, points.into_iter());
        }
    }
    polygons
}

/// Paints marks over the pixels of a page: what becomes of each, by how much of it is covered, of 255.
fn paint_marks<T: Copy + Send>(page: &mut [T], width: usize, marks: &Polygons, paint: impl Fn(T, u8) -> T + Sync) {
    let rows = rows_of_a_band(width);
    page.par_chunks_mut(width * rows).enumerate().for_each(|(band, pixels)| {
        let mut covered = vec![0u8; pixels.len()];
        paint_band([(Ink::WHITE, std::slice::from_ref(marks))], Color::BLACK, width, band * rows, &mut covered);
        for (pixel, covered) in pixels.iter_mut().zip(covered).filter(|(_, covered)| *covered > 0) {
            *pixel = paint(*pixel, covered);
        }
    });
}

/// A page in colours with its registration marks.
fn marked(mut page: Vec<[u8; 3]>, drawing: &Drawing, export: &Export, placement: &PixelPlacement) -> Result<Vec<[u8; 3]>> {
    if let Some(marks) = marks(export, placement) {
        let rgb = export.rgb_of_marks(&drawing.palette)?;
        paint_marks(&mut page, placement.page[0], &marks, |pixel, covered| [0, 1, 2].map(|i| mixed(pixel[i], rgb[i], covered)));
    }
    Ok(page)
}

/// A value of which so much, of 255, is covered by another.
fn mixed(value: u8, other: u8, covered: u8) -> u8 {
    let [value, other, covered] = [value, other, covered].map(u32::from);
    ((value * (255 - covered) + other * covered + 127) / 255) as u8
}

/// The drawing's pixels with margins around them.
fn on_page<T: Copy>(pixels: Vec<T>, placement: &PixelPlacement, margin: T) -> Vec<T> {
    let ([width, height], [left, top]) = (placement.page, placement.origin);
    if placement.page == placement.drawing {
        return pixels;
    }
    let mut page = vec![margin; width * height];
    for (row, pixels) in pixels.chunks(placement.drawing[0]).enumerate() {
        let begin = (top + row) * width + left;
        page[begin..begin + pixels.len()].copy_from_slice(pixels);
    }
    page
}

/// Whether the drawing on a canvas of `width` x `height` pixels can have the pixels that the export asks for.
///
/// # Errors
/// As [`Layout::place_pixels`](crate::stages::Layout::place_pixels) and [`check_size`].
pub(super) fn fits(export: &Export, width: usize, height: usize) -> Result<()> {
    let [width, height] = export.layout.place_pixels(width, height)?.page;
    check_size(width, height)
}

/// The raster as an 8-bit greyscale PNG. The same raster always gives the same bytes.
///
/// # Errors
/// [`Error::Input`] if the number of values does not fit the size.
pub fn encode_png(raster: &Raster) -> Result<Vec<u8>> {
    encode(raster, DEFLATE)
}

/// The same in a fraction of the time, for about twice the bytes: for pictures that are looked at and thrown away.
///
/// # Errors
/// As [`encode_png`].
pub fn encode_png_at_once(raster: &Raster) -> Result<Vec<u8>> {
    encode(raster, DeflateCompression::FdeflateUltraFast)
}

fn encode(raster: &Raster, deflate: DeflateCompression) -> Result<Vec<u8>> {
    let pixels = raster.width * raster.height * raster.channels;
    if raster.values.len() != pixels || pixels == 0 {
        return Err(Error::Input(format!(
            "the raster has {} values, but {} x {} pixels need {pixels}, at least one",
            raster.values.len(),
            raster.width,
            raster.height
        )));
    }
    let color = if raster.channels == 3 { ColorType::Rgb } else { ColorType::Grayscale };
    let (depth, palette) = (BitDepth::Eight, None);
    let samples = Cow::Borrowed(&raster.values[..]);
    write_png(&Pixels { width: raster.width, height: raster.height, color, depth, palette, samples }, None, deflate)
}

/// What a PNG holds.
struct Pixels<'a> {
    width: usize,
    height: usize,
    color: ColorType,
    depth: BitDepth,
    /// The colours of the samples 0 and 1.
    palette: Option<[[u8; 3]; 2]>,
    samples: Cow<'a, [u8]>,
}

/// The bytes of a PNG; `dpi` goes into the file if given.
fn write_png(pixels: &Pixels<'_>, dpi: Option<f64>, deflate: DeflateCompression) -> Result<Vec<u8>> {
    let mut png = Vec::with_capacity(pixels.samples.len() / 4 + 1024);
    let mut encoder = Encoder::new(&mut png, pixels.width as u32, pixels.height as u32);
    encoder.set_color(pixels.color);
    encoder.set_depth(pixels.depth);
    if let Some(palette) = pixels.palette {
        encoder.set_palette(palette.as_flattened().to_vec());
    }
    // Filters predict smooth gradients; here they would only hide the runs of black and white from the compressor.
    encoder.set_deflate_compression(deflate);
    encoder.set_filter(Filter::NoFilter);
    encoder.set_pixel_dims(dpi.map(|dpi| {
        let per_metre = (dpi / 0.0254).round() as u32;
        PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }
    }));
    encoder
        .write_header()
        .and_then(|mut writer| {
            writer.write_image_data(&pixels.samples)?;
            writer.finish()
        })
        .map_err(|error| Error::Internal(format!("the PNG cannot be encoded: {error}")))?;
    Ok(png)
}

/// A row of grey values as bits, the leftmost highest: 1 is white, where less than half a pixel is black. The last byte is filled up with zeros.
fn pack(row: &[u8]) -> impl Iterator<Item = u8> {
    let bit = |(i, value): (usize, &u8)| u8::from(*value >= 128) << (7 - i);
    row.chunks(8).map(move |values| values.iter().enumerate().map(bit).sum())
}

/// Width and height in pixels of a canvas's raster, see [`rasterize`].
///
/// # Errors
/// As [`rasterize`].
pub fn size(canvas_width: usize, canvas_height: usize, width: Option<usize>) -> Result<(usize, usize)> {
    let width = width.unwrap_or(canvas_width);
    if width == 0 || width > MAX_SIDE {
        return Err(Error::option("width", width, SIDES));
    }
    let height = (canvas_height as f64 * width as f64 / canvas_width as f64).round().max(1.0) as usize;
    check_size(width, height)?;
    Ok((width, height))
}

/// Checks that a raster has neither too long a side nor too many pixels.
///
/// # Errors
/// [`Error::Input`] with the size and the limits.
pub fn check_size(width: usize, height: usize) -> Result<()> {
    if width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_PIXELS {
        return Err(Error::Input(format!(
            "the raster would be {width} x {height} pixels, but a side may have at most {MAX_SIDE} and the whole {MAX_PIXELS}"
        )));
    }
    Ok(())
}

/// Marks of a level that are flattened at once.
const BATCH: usize = 1024;

/// The marks of a level, in batches.
struct Flattened {
    ink: Ink,
    batches: Vec<Polygons>,
}

/// Marks as polygons, in pixels of the raster.
struct Polygons {
    points: Vec<[f32; 2]>,
    outlines: Vec<Outline>,
}

/// One polygon of a batch: which points, and which rows it spans.
struct Outline {
    begin: usize,
    end: usize,
    top: f32,
    bottom: f32,
}

impl Polygons {
    /// The polygon of a dot, against its direction where it is a hole.
    fn push_dot(&mut self, drawing: &Drawing, scale: [f64; 2], index: u32, window: Option<&Window>, is_hole: bool) {
        let dot = &drawing.stipples[index as usize];
        let [x, y, radius] = [dot.x, dot.y, dot.radius];
        let corners = [[x - radius, y - radius], [x + radius, y + radius]];
        if window.is_some_and(|window| window.leaves_out(&corners)) {
            return;
        }
        let mut points = drawing.stipple_outline(index as usize, DOT_TOLERANCE / scale[0].max(scale[1]));
        if is_hole {
            points.reverse();
        }
        self.push_seen(scale, points, window, window.is_none_or(|window| window.holds(corners)));
    }

    fn push_ring(&mut self, drawing: &Drawing, scale: [f64; 2], ring: &Ring, window: Option<&Window>) {
        let tolerance = CURVE_TOLERANCE / scale[0].max(scale[1]);
        let path = drawing.ring_path(ring);
        let bounds = path.control_box();
        let whole = window.is_none_or(|window| window.holds([[bounds.x0, bounds.y0], [bounds.x1, bounds.y1]]));
        let mut points = Vec::new();
        match window {
            // What is seen whole is neither looked at piece by piece nor cut.
            Some(window) if !whole => window.flatten(&path, tolerance, &mut points),
            _ => kurbo::flatten(path.iter(), tolerance, |element| points.extend(element.end_point().map(|p| [p.x, p.y]))),
        }
        self.push_seen(scale, points, window, whole);
    }

    fn push_seen(&mut self, scale: [f64; 2], mut points: Vec<[f64; 2]>, window: Option<&Window>, whole: bool) {
        if let Some(window) = window {
            if !whole {
                window.cut(&mut points);
            }
            let corner = window.corner;
            points.iter_mut().for_each(|point| *point = [point[0] - corner[0], point[1] - corner[1]]);
        }
        // What is not seen, and what has no area.
        if points.len() > 2 {
            self.push(scale, points.into_iter());
        }
    }

    fn push(&mut self, scale: [f64; 2], points: impl Iterator<Item = [f64; 2]>) {
        let begin = self.points.len();
        let (mut top, mut bottom) = (f32::INFINITY, f32::NEG_INFINITY);
        for point in points {
            let on_grid = |axis: usize| ((point[axis] * scale[axis] * GRID).round() / GRID) as f32;
            let point = [on_grid(0), on_grid(1)];
            if self.points.len() == begin || self.points.last() != Some(&point) {
                (top, bottom) = (top.min(point[1]), bottom.max(point[1]));
                self.points.push(point);
            }
        }
        self.outlines.push(Outline { begin, end: self.points.len(), top, bottom });
    }
}

/// What is painted of the canvas, in its pixels: a little more than what is seen, so that the cuts are not.
struct Window {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    /// The upper left corner of what is seen.
    corner: [f64; 2],
}

/// Raster pixels around a part in which outlines are cut.
const AROUND: f64 = 2.0;

impl Window {
    fn of([left, top, right, bottom]: [f64; 4], scale: [f64; 2]) -> Self {
        let [across, down] = scale.map(|scale| AROUND / scale);
        Self { left: left - across, top: top - down, right: right + across, bottom: bottom + down, corner: [left, top] }
    }

    /// How far a point lies inside of every side.
    fn insides(&self, [x, y]: [f64; 2]) -> [f64; 4] {
        [x - self.left, y - self.top, self.right - x, self.bottom - y]
    }

    /// Whether the box between two corners lies inside.
    fn holds(&self, corners: [[f64; 2]; 2]) -> bool {
        corners.into_iter().all(|corner| self.insides(corner).into_iter().all(|inside| inside >= 0.0))
    }

    /// Whether all points lie outside of one side, and so all lines between them.
    fn leaves_out(&self, points: &[[f64; 2]]) -> bool {
        let all = points.iter().map(|point| self.insides(*point));
        let inmost = all.fold([f64::NEG_INFINITY; 4], |most, each| std::array::from_fn(|side| most[side].max(each[side])));
        inmost.into_iter().any(|inside| inside < 0.0)
    }

    /// A path as a polygon, its curves flattened where they may be seen.
    fn flatten(&self, path: &BezPath, tolerance: f64, points: &mut Vec<[f64; 2]>) {
        let mut last = Point::ZERO;
        for element in path.iter() {
            let controls: &[Point] = match &element {
                PathEl::CurveTo(a, b, c) => &[last, *a, *b, *c],
                PathEl::QuadTo(a, b) => &[last, *a, *b],
                _ => &[],
            };
            let controls: Vec<[f64; 2]> = controls.iter().map(|point| [point.x, point.y]).collect();
            if controls.is_empty() || self.leaves_out(&controls) {
                points.extend(element.end_point().map(|p| [p.x, p.y]));
            } else {
                let mut skipped = 0;
                kurbo::flatten([PathEl::MoveTo(last), element], tolerance, |piece| {
                    // The first is where the last curve has ended.
                    points.extend(piece.end_point().filter(|_| skipped > 0).map(|p| [p.x, p.y]));
                    skipped += 1;
                });
            }
            last = element.end_point().unwrap_or(last);
        }
    }

    /// What of a polygon lies in the window, as one polygon whose edges may run along the window's (Sutherland and Hodgman 1974).
    fn cut(&self, polygon: &mut Vec<[f64; 2]>) {
        for side in 0..4 {
            if polygon.iter().all(|point| self.insides(*point)[side] >= 0.0) {
                continue;
            }
            let mut kept = Vec::with_capacity(polygon.len());
            for (i, point) in polygon.iter().enumerate() {
                let before = polygon[if i == 0 { polygon.len() - 1 } else { i - 1 }];
                let [from, to] = [self.insides(before)[side], self.insides(*point)[side]];
                if (from < 0.0) != (to < 0.0) {
                    let share = from / (from - to);
                    kept.push([0, 1].map(|axis| before[axis] + share * (point[axis] - before[axis])));
                }
                if to >= 0.0 {
                    kept.push(*point);
                }
            }
            *polygon = kept;
        }
    }
}

/// All levels, lowest first, at `scale` raster pixels per pixel of the canvas in x and y; what is seen in a window alone, from its
/// corner on, or the whole canvas.
fn flatten(drawing: &Drawing, scale: [f64; 2], window: Option<&Window>) -> Vec<Flattened> {
    let flatten_level = |level: crate::drawing::Level| Flattened {
        ink: level.ink,
        batches: level.marks.par_chunks(BATCH).map(|marks| flatten_batch(drawing, scale, marks, window, false)).collect(),
    };
    drawing.levels().into_iter().map(flatten_level).collect()
}

/// Marks as polygons: their exteriors, and their holes too if they are to be cut out.
fn flatten_batch(drawing: &Drawing, scale: [f64; 2], marks: &[Mark], window: Option<&Window>, with_holes: bool) -> Polygons {
    let mut polygons = Polygons { points: Vec::new(), outlines: Vec::with_capacity(marks.len()) };
    for mark in marks {
        match *mark {
            Mark::Stipple(i) => polygons.push_dot(drawing, scale, i, window, false),
            Mark::Region(i) => {
                let region = &drawing.regions[i as usize];
                polygons.push_ring(drawing, scale, &region.exterior, window);
                for hole in region.holes.iter().filter(|_| with_holes) {
                    match hole.parts[..] {
                        [RingPart::Stipple { index }] => polygons.push_dot(drawing, scale, index, window, true),
                        _ => polygons.push_ring(drawing, scale, hole, window),
                    }
                }
            }
        }
    }
    polygons
}

/// Paints in bands of `rows` rows.
fn paint(levels: &[Flattened], width: usize, height: usize, rows: usize) -> Vec<u8> {
    let mut values = vec![0u8; width * height];
    values.par_chunks_mut(width * rows).enumerate().for_each(|(band, values)| {
        let shown = levels.iter().map(|level| (level.ink, &level.batches[..]));
        paint_band(shown, Color::WHITE, width, band * rows, values);
    });
    values
}

/// Paints the rows from `first_row` that `values` holds, on a ground: batches in black or white, one after the other.
fn paint_band<'a>(
    levels: impl IntoIterator<Item = (Ink, &'a [Polygons])>,
    ground: Color,
    width: usize,
    first_row: usize,
    values: &mut [u8],
) {
    let rows = values.len() / width;
    let (top, bottom) = (first_row as f32, (first_row + rows) as f32);
    let mut pixmap = Pixmap::new(width as u32, rows as u32).expect("a band has pixels, and fewer than 2^26 of them");
    pixmap.fill(ground);
    for (ink, batches) in levels {
        let mut builder = PathBuilder::new();
        for batch in batches {
            for outline in batch.outlines.iter().filter(|outline| outline.bottom > top && outline.top < bottom) {
                push_within(&mut builder, &batch.points[outline.begin..outline.end], top, bottom);
            }
        }
        // An empty level, or one whose outlines all fell onto a point or a line, has no path.
        let Some(path) = builder.finish() else { continue };
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.set_color(match ink {
            Ink::BLACK => Color::BLACK,
            _ => Color::WHITE,
        });
        pixmap.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
    }
    for (value, pixel) in values.iter_mut().zip(pixmap.pixels()) {
        *value = pixel.red();
    }
}

/// Adds a polygon, `top` rows up. Of a run of points that lie all above or all below the band, only the first and the last
/// are needed: the line between them stays out of the band as the run did.
fn push_within(builder: &mut PathBuilder, points: &[[f32; 2]], top: f32, bottom: f32) {
    let side = |point: &[f32; 2]| (point[1] >= bottom) as i8 - (point[1] <= top) as i8;
    for (i, point) in points.iter().enumerate() {
        if i == 0 {
            builder.move_to(point[0], point[1] - top);
            continue;
        }
        let here = side(point);
        let skipped = here != 0 && side(&points[i - 1]) == here && points.get(i + 1).is_some_and(|next| side(next) == here);
        if !skipped {
            builder.line_to(point[0], point[1] - top);
        }
    }
    builder.close();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::layout::Layout;
    use crate::files::svg::samples;
    use crate::options::Only;

    fn ink(raster: &Raster) -> f64 {
        raster.values.iter().map(|v| f64::from(255 - v) / 255.0).sum()
    }

    #[test]
    fn nested_marks_are_painted_level_by_level() {
        let raster = rasterize(&samples::nested(), None).unwrap();
        assert_eq!((raster.width, raster.height, raster.values.len()), (64, 48, 64 * 48));
        let at = |x: usize, y: usize| raster.values[y * 64 + x];
        assert_eq!([at(1, 1), at(20, 24), at(15, 24), at(62, 2), at(50, 12), at(63, 30)], [0, 255, 0, 255, 0, 0]);
        assert!((0..48).all(|y| at(0, y) == 0), "black reaches the frame");
    }

    #[test]
    fn a_black_canvas_has_no_fringe() {
        let mut frame = kurbo::BezPath::new();
        frame.move_to((0.0, 0.0));
        for corner in [(31.0, 0.0), (31.0, 17.0), (0.0, 17.0)] {
            frame.line_to(corner);
        }
        frame.close_path();
        let drawing = samples::drawing(31, 17, vec![(frame, 1)], &[]);
        for width in [1, 7, 31, 100, 1000] {
            let raster = rasterize(&drawing, Some(width)).unwrap();
            assert!(raster.values.iter().all(|v| *v == 0), "{width}");
        }
    }

    #[test]
    fn ink_is_area() {
        let drawing = samples::field_of_blobs(400);
        let dots: f64 = drawing.stipples.iter().map(|s| s.radius * s.radius * std::f64::consts::PI).sum();
        let black = drawing.regions.iter().filter(|region| region.ink == Ink::BLACK);
        let regions: f64 = black.map(|region| region.enclosed_area).sum();
        let full = samples::drawing(drawing.width, drawing.height, drawing.curves.iter().map(|c| (c.clone(), 1)).collect(), &[]);
        for scale in [1usize, 2, 4] {
            let area = (scale * scale) as f64;
            let all = ink(&rasterize(&drawing, Some(drawing.width * scale)).unwrap()) / area;
            let curves = ink(&rasterize(&full, Some(drawing.width * scale)).unwrap()) / area;
            assert!((curves / regions - 1.0).abs() < 0.005, "regions at {scale}: {curves} instead of {regions}");
            assert!(((all - curves) / dots - 1.0).abs() < 0.01, "dots at {scale}: {} instead of {dots}", all - curves);
        }
    }

    #[test]
    fn small_dots_keep_their_ink_wherever_they_are() {
        // Low-discrepancy centres, so that 4000 dots a radius show a bias of a tenth of a per cent.
        for radius in [0.5, 0.7, 1.0, 1.5, 2.0] {
            let dots: Vec<_> = (0..4096)
                .map(|i| {
                    let (u, v) = ((i as f64 * 0.754_877_666).fract(), (i as f64 * 0.569_840_29).fract());
                    ((i % 64) as f64 * 8.0 + 3.5 + u, (i / 64) as f64 * 8.0 + 3.5 + v, radius, 1)
                })
                .collect();
            let raster = rasterize(&samples::drawing(512, 512, vec![], &dots), None).unwrap();
            let bias = ink(&raster) / (4096.0 * std::f64::consts::PI * radius * radius) - 1.0;
            println!("radius {radius}: ink {:+.3} %", bias * 100.0);
            assert!(bias.abs() < 0.01, "radius {radius}: {bias}");
        }
    }

    #[test]
    fn bands_and_threads_do_not_show() {
        let mut drawing = samples::field_of_blobs(300);
        drawing.curves[17] = samples::blob([150.0, 150.0], 90.0, 40);
        let scale = [1.7, 1.7];
        let levels = flatten(&drawing, scale, None);
        let (width, height) = (490, 490);
        let whole = paint(&levels, width, height, height);
        for rows in [1, 7, 64] {
            let banded = paint(&levels, width, height, rows);
            let differences: Vec<u8> = whole.iter().zip(&banded).map(|(a, b)| a.abs_diff(*b)).filter(|d| *d > 0).collect();
            println!("{rows} rows: {} pixels differ, at most {:?}", differences.len(), differences.iter().max());
            assert!(differences.iter().all(|d| *d <= 16), "more than one of tiny-skia's 16 samples");
            assert!(differences.len() <= whole.len() / 1000);
        }
        let threads = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let one = threads(1).install(|| rasterize(&drawing, Some(2000)).unwrap());
        assert!(one == threads(3).install(|| rasterize(&drawing, Some(2000)).unwrap()));
    }

    #[test]
    fn a_part_is_a_cutout_of_the_whole() {
        let mut drawing = samples::field_of_blobs(300);
        drawing.curves[17] = samples::blob([150.0, 150.0], 90.0, 40);
        let [width, height] = [drawing.width, drawing.height];
        for scale in [1usize, 3, 8] {
            let whole = rasterize(&drawing, Some(width * scale)).unwrap();
            for part in [[0, 0, width, height], [40, 60, 130, 101], [149, 150, 150, 152], [width - 7, height - 5, width, height]] {
                let [left, top, right, bottom] = part;
                let columns = (right - left) * scale;
                let painted = rasterize_part(&drawing, part.map(|side| side as f64), columns).unwrap();
                assert_eq!([painted.width, painted.height], [columns, (bottom - top) * scale]);
                let cut = |row: usize| {
                    let begin = (top * scale + row) * whole.width + left * scale;
                    &whole.values[begin..begin + columns]
                };
                let of_both = painted.values.chunks(columns).enumerate().flat_map(|(row, values)| values.iter().zip(cut(row)));
                let differences: Vec<u8> = of_both.map(|(a, b)| a.abs_diff(*b)).filter(|d| *d > 0).collect();
                assert!(differences.iter().all(|d| *d <= 16), "more than one of tiny-skia's 16 samples");
                assert!(differences.len() <= painted.values.len() / 100, "{part:?} at {scale}: {}", differences.len());
            }
        }
    }

    #[test]
    fn a_part_of_a_dot_is_sharp_at_every_scale() {
        let drawing = samples::drawing(60_000, 4, vec![], &[(50_000.0, 2.0, 1.0, 1)]);
        // A thousand pixels a pixel: the right end of the dot, and nothing beside it.
        let seen = rasterize_part(&drawing, [50_000.5, 1.5, 50_001.5, 2.5], 1000).unwrap();
        let row = &seen.values[500 * 1000..501 * 1000];
        let black = row.iter().filter(|v| **v < 128).count();
        assert!((498..=502).contains(&black) && row[0] == 0 && row[999] == 255, "{black}");
    }

    #[test]
    fn a_part_lies_on_the_canvas() {
        let drawing = samples::nested();
        let told = |part, width| rasterize_part(&drawing, part, width).map(|_| ()).map_err(|error| error.to_string());
        let nan = f64::NAN;
        for part in
            [[0.0, 0.0, 65.0, 48.0], [-1.0, 0.0, 3.0, 3.0], [3.0, 3.0, 3.0, 9.0], [9.0, 3.0, 2.0, 9.0], [nan, 0.0, 1.0, 1.0]]
        {
            let sentence = told(part, 10).unwrap_err();
            assert!(sentence.starts_with("part is (") && sentence.contains("on the canvas of 64 x 48 pixels"), "{sentence}");
        }
        assert_eq!(told([0.0, 0.0, 9.0, 9.0], 0).unwrap_err(), "width is 0, but it must be between 1 and 65535 pixels");
        assert!(told([0.0, 0.0, 0.01, 48.0], 100).unwrap_err().starts_with("the raster would be 100 x 65536 pixels"));
        assert_eq!(told([0.0, 0.0, 64.0, 48.0], 7), Ok(()));
    }

    #[test]
    fn sizes() {
        let drawing = samples::drawing(4, 1000, vec![], &[(2.0, 500.0, 1.0, 1)]);
        let size = |width| rasterize(&drawing, Some(width)).map(|r| (r.width, r.height)).map_err(|e| e.to_string());
        assert_eq!(size(2), Ok((2, 500)));
        assert_eq!(super::size(300, 200, Some(100)).unwrap(), (100, 67));
        assert_eq!(size(0), Err("width is 0, but it must be between 1 and 65535 pixels".into()));
        assert!(size(65_536).is_err());
        assert!(size(1000).unwrap_err().starts_with("the raster would be 1000 x 250000 pixels"));
        let wide = samples::drawing(1000, 4, vec![], &[(500.0, 2.0, 1.0, 1)]);
        assert_eq!(rasterize(&wide, Some(10)).map(|r| (r.width, r.height)).unwrap(), (10, 1));
    }

    #[test]
    fn more_columns_than_a_tile_of_tiny_skia() {
        let drawing = samples::drawing(100, 4, vec![], &[(90.0, 2.0, 1.0, 1)]);
        let raster = rasterize(&drawing, Some(20_000)).unwrap();
        assert!((ink(&raster) / (200.0 * 200.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
        assert_eq!(raster.values[400 * 20_000 + 18_000], 0);
    }

    /// The raw file: its header, and its samples as they are stored.
    fn decode(png: &[u8]) -> (png::Info<'static>, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut samples).unwrap();
        (reader.info().clone(), samples)
    }

    fn layout(width: Option<&str>, margin: &str, dpi: Option<f64>) -> Layout {
        Layout { width: width.map(|w| w.parse().unwrap()), margin: margin.parse().unwrap(), page: None, dpi }
    }

    #[test]
    fn margins_are_white_and_the_resolution_is_told() {
        let drawing = samples::nested();
        let plain = to_png(&drawing, &Export::default()).unwrap();
        let raster = rasterize(&drawing, None).unwrap();
        assert_eq!(plain, encode_png(&raster).unwrap());
        assert!(decode(&plain).0.pixel_dims.is_none());

        let export = Export { layout: layout(Some("1in"), "5mm", Some(128.0)), ..Export::default() };
        let (info, samples) = decode(&to_png(&drawing, &export).unwrap());
        assert_eq!((info.width, info.height), (128 + 2 * 25, 96 + 2 * 25));
        let dimensions = info.pixel_dims.unwrap();
        assert_eq!((dimensions.xppu, dimensions.yppu, dimensions.unit), (5039, 5039, Unit::Meter));
        let inner = rasterize(&drawing, Some(128)).unwrap();
        for (y, row) in samples.chunks(178).enumerate() {
            for (x, value) in row.iter().enumerate() {
                let inside = (25..153).contains(&x) && (25..121).contains(&y);
                assert_eq!(*value, if inside { inner.values[(y - 25) * 128 + x - 25] } else { 255 }, "{x} {y}");
            }
        }
        let huge = Export { layout: layout(Some("60000px"), "0", None), ..Export::default() };
        assert!(to_png(&drawing, &huge).unwrap_err().to_string().starts_with("the raster would be 60000 x 45000 pixels"));
    }

    #[test]
    fn the_resolution_is_the_nearest_that_can_be_told() {
        for (dpi, per_metre) in [(72.0, 2835), (96.0, 3780), (300.0, 11_811)] {
            let export = Export { layout: layout(None, "0", Some(dpi)), ..Export::default() };
            let (info, _) = decode(&to_png(&samples::nested(), &export).unwrap());
            assert_eq!(info.pixel_dims.map(|dims| [dims.xppu, dims.yppu]), Some([per_metre; 2]), "{dpi}");
        }
    }

    #[test]
    fn one_bit_is_the_threshold_of_the_grey() {
        let drawing = samples::nested();
        let export = Export { layout: layout(Some("203"), "2px", None), one_bit: true, ..Export::default() };
        let (info, packed) = decode(&to_png(&drawing, &export).unwrap());
        assert_eq!((info.width, info.bit_depth, info.color_type), (207, BitDepth::One, ColorType::Grayscale));
        let (_, grey) = decode(&to_png(&drawing, &Export { one_bit: false, ..export }).unwrap());
        for (row, bits) in grey.chunks(207).zip(packed.chunks(26)) {
            assert!(row.iter().enumerate().all(|(x, v)| (bits[x / 8] >> (7 - x % 8) & 1 == 1) == (*v >= 128)));
        }
    }

    #[test]
    fn a_png_holds_the_same_values() {
        let raster = rasterize(&samples::nested(), Some(200)).unwrap();
        let png = encode_png(&raster).unwrap();
        let (info, values) = decode(&png);
        assert_eq!((info.bit_depth, info.color_type), (BitDepth::Eight, ColorType::Grayscale));
        assert_eq!(values, raster.values);
        assert_eq!(decode(&encode_png_at_once(&raster).unwrap()).1, raster.values);
        assert!(encode_png(&Raster { width: 3, height: 3, channels: 1, values: vec![0; 8] }).is_err());
    }

    #[test]
    fn a_paper_has_its_colour_where_there_is_no_ink() {
        let sample = samples::nested();
        // The colours of a black place, of a white one in it, of white paper on the canvas, and of the margin.
        let at = |export: &Export| -> [Vec<u8>; 4] {
            let bytes = to_png(&sample, export).unwrap();
            let mut decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
            decoder.set_transformations(png::Transformations::EXPAND);
            let mut reader = decoder.read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            let frame = reader.next_frame(&mut pixels).unwrap();
            let samples = frame.color_type.samples();
            [(9, 9), (28, 32), (46, 10), (2, 2)].map(|(x, y)| {
                let begin = (y * 80 + x) * samples;
                pixels[begin..begin + samples].to_vec()
            })
        };
        let mut export = Export::default();
        export.layout.margin = "8px".parse().unwrap();
        assert_eq!(at(&export), [[0], [255], [255], [255]].map(|v| v.to_vec()));
        let [black, white, red] = [[0; 3], [255; 3], [200, 16, 32]].map(|rgb| rgb.to_vec());
        for one_bit in [false, true] {
            export.paper = Some("#c81020".parse().unwrap());
            let flat = |only: Only| Export { only, one_bit, ..export.clone() };
            assert_eq!(at(&flat(Only::default())), [&black, &red, &red, &red].map(Clone::clone));
            assert_eq!(at(&flat(Only::named(&["white"]))), [&red, &white, &white, &red].map(Clone::clone));
            assert_eq!(at(&Export { style: crate::files::Style::Layered, ..flat(Only::default()) }), at(&flat(Only::default())));
            if !one_bit {
                assert_eq!(at(&flat(Only::named(&["black", "white"]))), [&black, &white, &white, &red].map(Clone::clone));
            }
            // Greys stay grey.
            export.paper = Some("black".parse().unwrap());
            let on_black = Export { only: Only::named(&["white"]), one_bit, ..export.clone() };
            assert_eq!(at(&on_black), [[0], [255], [255], [0]].map(|v| v.to_vec()));
        }
        export.paper = Some("#808080".parse().unwrap());
        assert_eq!(at(&export), [[0], [128], [128], [128]].map(|v| v.to_vec()));
    }
}
