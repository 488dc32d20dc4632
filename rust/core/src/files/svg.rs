//! The drawing as SVG: its layers as named groups, each with one compound path of its ink, or with an element for every mark.
//!
//! # What is written
//! Path data are in units of the drawing's grid under one transform ([`super::write_path`]), so that nothing is lost and
//! [`super::load_svg`] reads the same drawing back. An element of a mark has the mark's number as its id, whatever style and inks
//! are written. Dots as strokes have few radii ([`super::strokes`]), and each of these has a path.
//!
//! Groups are layers to Inkscape and have the same ids in every file. What is not drawn is transparent. The size on paper is in the
//! attributes of the root element alone; the data stay in pixels of the canvas. The provenance is JSON in `<metadata>`: enough to
//! make the drawing again.

use crate::base::{Palette, Result, WrittenPalette};
use crate::drawing::{Drawing, Mark};
use crate::files::export::{Dots, Elements, Export};
use crate::files::layers::{Area, Ground, Layer, Layers, Outline};
use crate::files::layout::{Layout, Placement, Unit};
use crate::files::strokes;
use crate::files::write_path::{PathWriter, leftmost, rounded};
use crate::options::Only;

/// A path is closed and another one begun after this many bytes: libxml2, and with it librsvg and lxml, refuses attributes above
/// 10 MB, and viewers skip a path that is out of view. Areas of a layer are disjoint, so the picture is the same.
const PATH_BYTES: usize = 1 << 20;

/// The same for dots as strokes, of which each takes less than 40 bytes.
const PATH_DOTS: usize = PATH_BYTES / 40;

/// Names the element with the provenance; only a name, nothing is there.
pub(crate) const NAMESPACE: &str = "https://github.com/graphstipple/graphstipple";

/// Where Inkscape's attributes live.
pub(crate) const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// The drawing as an SVG document.
///
/// # Errors
/// As [`Layout::place`].
///
/// # Runtime
/// Linear in the number of coordinates. The same drawing always gives the same bytes.
pub(super) fn to_svg(drawing: &Drawing, export: &Export) -> Result<String> {
    match export.dots {
        Dots::Circles => write(drawing, export),
        Dots::Strokes => write(&strokes::with_few_radii(drawing)?, export),
    }
}

fn write(drawing: &Drawing, export: &Export) -> Result<String> {
    let (width, height) = (drawing.width, drawing.height);
    let placement = export.layout.place(width, height)?;
    let layers = export.layers_of(drawing, &placement)?;
    let elements: usize = drawing.curves.iter().map(|curve| curve.elements().len()).sum();
    let mut path = PathWriter::new(drawing.units);
    path.bytes.reserve(2048 + 16 * elements + 56 * drawing.stipples.len());
    let mut writer = Writer { path, export, layers: &layers, palette: &drawing.palette, canvas: [width, height] };
    // In pixels of the canvas.
    let [left, top] = placement.origin.map(|v| decimal(-v / placement.scale));
    let [page_width, page_height] = placement.page.map(|v| decimal(v / placement.scale));
    let [on_paper_width, on_paper_height] = placement.page.map(|points| on_paper(points, &export.layout));
    let json = serde_json::to_string(&drawing.provenance).expect("plain options always serialize");
    // Of a canvas with nothing on it no style and ink would tell.
    let is_empty = drawing.curves.is_empty() && drawing.stipples.is_empty();
    let is_black = is_empty
        && drawing.palette.is_black_and_white()
        && drawing.regions.first().is_some_and(|region| region.ink != drawing.palette.paper_label());
    writer.path.text(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"{INKSCAPE}\" width=\"{on_paper_width}\" \
         height=\"{on_paper_height}\" viewBox=\"{left} {top} {page_width} {page_height}\">\n\
         <metadata><graphstipple:drawing xmlns:graphstipple=\"{NAMESPACE}\" width=\"{width}\" height=\"{height}\" \
         units=\"{}\"{}{}>{}</graphstipple:drawing></metadata>\n",
        drawing.units,
        told_palette(&drawing.palette, &export.only)?,
        if is_black { " ground=\"black\"" } else { "" },
        escape(&json)
    ));
    for ground in &layers.grounds {
        writer.ground(ground, &placement);
    }
    for layer in &layers.layers {
        writer.layer(layer);
    }
    writer.path.text("</svg>\n");
    Ok(String::from_utf8(writer.path.bytes).expect("only text was written"))
}

/// The attributes of inks and paper, where they are not black and white, and of those that are drawn, if these are not all inks.
fn told_palette(palette: &Palette, only: &Only) -> Result<String> {
    if palette.is_black_and_white() {
        return Ok(String::new());
    }
    let WrittenPalette { inks, paper, overprint } = palette.into();
    let overprint = if overprint { " overprint=\"true\"" } else { "" };
    let numbers = only.of(palette)?;
    let is_all = numbers.iter().copied().eq(0..palette.inks().len());
    let names: Vec<&str> =
        palette.names().enumerate().filter(|(number, _)| numbers.contains(number)).map(|(_, name)| name).collect();
    let only = if is_all { String::new() } else { format!(" only=\"{}\"", names.join(",")) };
    Ok(format!(" inks=\"{}\" paper=\"{paper}\"{overprint}{only}", inks.join(",")))
}

/// The id of a mark's element: ink, kind and number, which are the drawing's own.
fn id_of(mark: Mark, ink: &str) -> String {
    match mark {
        Mark::Region(number) => format!("{ink}-region-{number}"),
        Mark::Stipple(number) => format!("{ink}-stipple-{number}"),
    }
}

/// A colour as an attribute has it.
pub(crate) fn hexadecimal([red, green, blue]: [u8; 3]) -> String {
    let is_short = [red, green, blue].iter().all(|value| value / 16 == value % 16);
    if is_short { format!("#{:x}{:x}{:x}", red % 16, green % 16, blue % 16) } else { format!("#{red:02x}{green:02x}{blue:02x}") }
}

/// Inks over each other.
pub(super) const MULTIPLY: &str = "mix-blend-mode:multiply";

/// Writes groups and what is in them.
struct Writer<'a> {
    path: PathWriter,
    export: &'a Export,
    layers: &'a Layers,
    palette: &'a Palette,
    canvas: [usize; 2],
}

impl Writer<'_> {
    fn group(&mut self, id: &str, label: &str, paint: &str) {
        self.path.text(&format!("<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\"{paint}>\n"));
    }

    fn ground(&mut self, ground: &Ground, placement: &Placement) {
        self.group(ground.id, ground.label, &fill(ground.rgb));
        let [left, top, right, bottom] = ground.rectangle(self.canvas, placement);
        let place = if ground.covers_page { format!("x=\"{}\" y=\"{}\" ", decimal(left), decimal(top)) } else { String::new() };
        let (width, height) = (decimal(right - left), decimal(bottom - top));
        self.path.text(&format!("<rect {place}width=\"{width}\" height=\"{height}\"/>\n</g>\n"));
    }

    fn layer(&mut self, layer: &Layer) {
        // Marks for whoever prints are of no ink's colour.
        let multiplies = self.layers.multiply && !layer.is_registration();
        let rgb = if multiplies { self.layers.painted(layer.rgb, self.palette) } else { layer.rgb };
        // A layer has marks of one kind.
        let has_dots = layer.areas.iter().any(|area| matches!(area.mark, Some(Mark::Stipple(_))));
        let has_strokes = has_dots && self.export.dots == Dots::Strokes;
        let units = if has_strokes { strokes::FINER * self.path.units } else { self.path.units };
        let transform = format!(" transform=\"scale({})\"", digits(1.0 / units));
        let paint = if has_strokes {
            format!(" fill=\"none\" stroke=\"{}\" stroke-linecap=\"round\"", hexadecimal(rgb))
        } else {
            fill(rgb)
        };
        let blend = if multiplies { format!(" style=\"{MULTIPLY}\"") } else { String::new() };
        self.group(&layer.id, &layer.label, &(paint + &transform + &blend));
        match self.export.elements {
            _ if has_strokes => self.strokes(&layer.areas),
            Elements::Layers => self.compound_path(&layer.areas),
            Elements::Marks => layer.areas.iter().for_each(|area| self.mark(area, layer.ink_name())),
        }
        self.path.text("</g>\n");
    }

    fn compound_path(&mut self, areas: &[Area]) {
        let mut begin = self.open("");
        for area in areas {
            if self.path.bytes.len() - begin > PATH_BYTES {
                self.close();
                begin = self.open("");
            }
            self.outlines(area);
        }
        self.close();
    }

    fn mark(&mut self, area: &Area, ink: &str) {
        let id = area.mark.map(|mark| format!("id=\"{}\" ", id_of(mark, ink))).unwrap_or_default();
        match area.exterior {
            Outline::Circle { x, y, radius } if area.holes.is_empty() => {
                let units = self.path.units;
                let radius = radius * units;
                let x = rounded(leftmost(x * units, radius) + radius);
                let [x, y, radius] = [x, y * units, radius].map(digits);
                self.path.text(&format!("<circle {id}cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>\n"));
            }
            _ => {
                self.open(&id);
                self.outlines(area);
                self.close();
            }
        }
    }

    fn strokes(&mut self, areas: &[Area]) {
        for (radius, centres) in strokes::by_radius(areas, strokes::FINER * self.path.units, self.canvas) {
            for centres in centres.chunks(PATH_DOTS) {
                self.open(&format!("stroke-width=\"{}\" ", digits(2.0 * radius)));
                self.path.strokes(centres);
                self.close();
            }
        }
    }

    fn outlines(&mut self, area: &Area) {
        self.path.outline(&area.exterior, true);
        for hole in &area.holes {
            self.path.outline(hole, false);
        }
    }

    /// Begins a path element; returns where its data begins.
    fn open(&mut self, attributes: &str) -> usize {
        self.path.text(&format!("<path {attributes}d=\""));
        self.path.begin()
    }

    fn close(&mut self) {
        self.path.text("\"/>\n");
    }
}

/// The attribute of a colour to fill with; black needs none.
fn fill(rgb: [u8; 3]) -> String {
    if rgb == [0; 3] { String::new() } else { format!(" fill=\"{}\"", hexadecimal(rgb)) }
}

/// A length of the page as an attribute: in the unit that was asked for.
fn on_paper(points: f64, layout: &Layout) -> String {
    let unit = match layout.width {
        Some(width) => width.unit,
        None if layout.page.is_some() => Unit::Mm,
        None => Unit::Px,
    };
    let name = if unit == Unit::Px { "" } else { unit.name() };
    format!("{}{name}", decimal(points / unit.points()))
}

/// A number without a trace of rounding in its last digits: six decimals at most, none that is 0.
fn decimal(value: f64) -> String {
    // Not -0.
    digits((value * 1e6).round() / 1e6 + 0.0)
}

/// A number with all its digits.
fn digits(value: f64) -> String {
    let text = value.to_string();
    match text.strip_prefix("0.") {
        Some(fraction) => format!(".{fraction}"),
        None => text,
    }
}

/// Escapes what may not stand in XML character data.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Drawings made by hand, for the tests of this module and of [`super::raster`].
#[cfg(test)]
pub(crate) mod samples {
    use kurbo::{BezPath, Point, Shape};

    use crate::base::{Control, Ink, Palette};
    use crate::drawing::{Drawing, Loose, Mark, Provenance, Region, Ring, RingPart, put_together};
    use crate::options::Options;
    use crate::outlines::Stipple;

    /// A closed uniform quadratic B-spline.
    pub(crate) fn spline(controls: &[Point]) -> BezPath {
        let middle = |i: usize| controls[i % controls.len()].midpoint(controls[(i + 1) % controls.len()]);
        let mut path = BezPath::new();
        path.move_to(middle(controls.len() - 1));
        for (i, control) in controls.iter().enumerate() {
            path.quad_to(*control, middle(i));
        }
        path.close_path();
        path
    }

    /// A wobbly closed spline of `count` control points around a centre.
    pub(crate) fn blob(centre: [f64; 2], radius: f64, count: usize) -> BezPath {
        let controls: Vec<Point> = (0..count)
            .map(|i| {
                let angle = i as f64 / count as f64 * std::f64::consts::TAU;
                let r = radius * (1.0 + 0.2 * (3.0 * angle + centre[0]).sin());
                Point::new(centre[0] + r * angle.cos(), centre[1] + r * angle.sin())
            })
            .collect();
        spline(&controls)
    }

    /// A drawing of closed curves and dots, each with its level; what lies in what is not looked at.
    pub(crate) fn drawing(width: usize, height: usize, curves: Vec<(BezPath, u32)>, dots: &[(f64, f64, f64, u32)]) -> Drawing {
        let ink = |level: u32| if level.is_multiple_of(2) { Ink::WHITE } else { Ink::BLACK };
        let mut areas: Vec<(f64, Mark)> = Vec::new();
        let mut regions = Vec::new();
        for (i, (curve, level)) in curves.iter().enumerate() {
            areas.push((curve.area(), Mark::Region(i as u32)));
            regions.push(Region {
                ink: ink(*level),
                level: *level,
                exterior: Ring { parts: vec![RingPart::Curve { index: i as u32, reversed: false }] },
                holes: Vec::new(),
                enclosed_area: curve.area(),
            });
        }
        let mut stipples = Vec::new();
        for (i, &(x, y, radius, level)) in dots.iter().enumerate() {
            areas.push((radius * radius * std::f64::consts::PI, Mark::Stipple(i as u32)));
            stipples.push(Stipple { x, y, radius, ink: ink(level), level });
        }
        areas.sort_by(|a, b| b.0.total_cmp(&a.0));
        Drawing {
            width,
            height,
            palette: Palette::default(),
            curves: curves.into_iter().map(|c| c.0).collect(),
            stipples,
            regions,
            order: areas.into_iter().map(|a| a.1).collect(),
            units: 16.0,
            provenance: provenance(),
        }
    }

    fn provenance() -> Provenance {
        let options = Options::default().to_json();
        Provenance { version: "0.1.0".into(), importance: "saliency".into(), options, ..Provenance::default() }
    }

    /// Black that touches the frame on the left half of 64 x 48, a white blob in it, a black dot in that, a dot on the frame.
    pub(crate) fn nested() -> Drawing {
        let mut left = BezPath::new();
        left.move_to((32.0, 0.0));
        left.quad_to((40.0, 12.0), (32.0, 24.0));
        left.quad_to((24.0, 36.0), (32.0, 48.0));
        let mut sample = drawing(
            64,
            48,
            vec![(left, 1), (blob([16.0, 24.0], 10.0, 9), 2), (blob([50.3, 12.6], 5.0, 7), 1)],
            &[(15.7, 23.9, 2.35, 3), (64.0, 30.0, 3.0, 1), (48.0, 40.0, 0.5, 1), (53.21, 40.4, 1.3, 1)],
        );
        let corners = [RingPart::Corner(0.0, 48.0), RingPart::Corner(0.0, 0.0)];
        sample.regions[0].exterior.parts.extend(corners);
        sample.order = vec![
            Mark::Region(0),
            Mark::Region(1),
            Mark::Region(2),
            Mark::Stipple(0),
            Mark::Stipple(1),
            Mark::Stipple(2),
            Mark::Stipple(3),
        ];
        sample
    }

    /// Rows of blobs and dots, 16 px apart: `count` of each.
    pub(crate) fn field_of_blobs(count: usize) -> Drawing {
        let columns = (count as f64).sqrt().ceil() as usize;
        let at = |i: usize| [(i % columns) as f64 * 16.0 + 6.5, (i / columns) as f64 * 16.0 + 6.5];
        let curves = (0..count).map(|i| blob(at(i), 3.0 + (i % 7) as f64 * 0.4, 8 + i % 5)).collect();
        let dot = |i: usize| Stipple {
            x: at(i)[0] + 7.9,
            y: at(i)[1] + 7.7,
            radius: 0.6 + (i % 11) as f64 * 0.11,
            ink: Ink::BLACK,
            level: 0,
        };
        let (side, stipples) = (columns * 16 + 8, (0..count).map(dot).collect());
        let loose = Loose::plain(side, side, curves, stipples);
        let drawing = put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).expect("they are apart");
        Drawing { provenance: provenance(), ..drawing }
    }
}

#[cfg(test)]
mod tests {
    use kurbo::{Affine, BezPath, PathEl, Shape};

    use super::*;
    use crate::base::Ink;
    use crate::files::layers::Style;
    use crate::options::Only;

    const UNITS: f64 = 16.0;

    fn flat(only: Only) -> Export {
        Export { only, ..Export::default() }
    }

    fn layered() -> Export {
        Export { style: Style::Layered, ..Export::default() }
    }

    /// Ids of the layers, and their paths in pixels.
    fn paths_of(svg: &str) -> Vec<(String, BezPath)> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let of = |n: roxmltree::Node| {
            let group = n.parent().unwrap();
            assert_eq!(group.attribute((INKSCAPE, "groupmode")), Some("layer"));
            assert_eq!(group.attribute("transform"), Some("scale(.0625)"));
            let path = BezPath::from_svg(n.attribute("d").unwrap()).unwrap();
            (group.attribute("id").unwrap().to_owned(), Affine::scale(1.0 / UNITS) * path)
        };
        document.descendants().filter(|n| n.has_tag_name("path")).map(of).collect()
    }

    #[test]
    fn the_document_holds_layers_paper_and_provenance() {
        let sample = samples::nested();
        let svg = to_svg(&sample, &layered()).unwrap();
        assert_eq!(svg, to_svg(&sample, &layered()).unwrap());
        let document = roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!((root.attribute("viewBox"), root.attribute("width")), (Some("0 0 64 48"), Some("64")));
        let about = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap();
        let json = about.text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);
        assert_eq!((about.attribute("width"), about.attribute("height")), (Some("64"), Some("48")));

        let paths = paths_of(&svg);
        let ids: Vec<_> = paths.iter().map(|p| p.0.as_str()).collect();
        assert_eq!(ids, ["level-1-black-regions", "level-1-black-stipples", "level-2-white-regions", "level-3-black-stipples"]);
        let white = sample.ring_path(&sample.regions[1].exterior).area();
        assert!((paths[2].1.area() / white - 1.0).abs() < 1e-9, "{} instead of {white}", paths[2].1.area());
        assert!(svg.contains("<g id=\"paper\""));
        assert!(!to_svg(&sample, &flat(Only::default())).unwrap().contains("id=\"paper\""));
    }

    #[test]
    fn what_is_not_drawn_is_transparent_unless_there_is_a_paper() {
        let mut export = flat(Only::default());
        export.layout.margin = "8px".parse().unwrap();
        let head = |export: &Export| {
            let svg = to_svg(&samples::nested(), export).unwrap();
            let lines: Vec<String> = svg.lines().skip(2).take(3).map(str::to_owned).collect();
            (!svg.contains("style="), lines.concat())
        };
        let group = |id: &str, label: &str, fill: &str| {
            format!("<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\"{fill}")
        };
        let transform = " transform=\"scale(.0625)\">";
        let starts = |export: &Export, expected: &str| {
            let (is_transparent, lines) = head(export);
            assert!(is_transparent && lines.starts_with(expected), "{lines} instead of {expected}");
        };
        starts(&export, &(group("black-regions", "Black regions", "") + transform));
        let page = "<rect x=\"-8\" y=\"-8\" width=\"80\" height=\"64\"/></g>";
        let canvas = "<rect width=\"64\" height=\"48\"/></g>";
        starts(&flat(Only::named(&["white"])), &format!("{}>{canvas}", group("paper", "Paper", "")));
        starts(&flat(Only::named(&["black", "white"])), &format!("{}>{canvas}", group("underlay", "Underlay", "")));
        starts(&layered(), &format!("{}>{canvas}", group("paper", "Paper", " fill=\"#fff\"")));
        export.paper = Some("#1af".parse().unwrap());
        starts(&export, &format!("{}>{page}", group("paper", "Paper", " fill=\"#1af\"")));
        export.style = Style::Layered;
        let svg = to_svg(&samples::nested(), &export).unwrap();
        assert!(svg.contains(&(group("level-2-white-regions", "Level 2: white regions", " fill=\"#1af\"") + transform)));
    }

    #[test]
    fn every_mark_has_an_element_whose_id_stays() {
        let sample = samples::nested();
        let ids = |export: Export| -> Vec<(String, String)> {
            let svg = to_svg(&sample, &Export { elements: Elements::Marks, ..export }).unwrap();
            let document = roxmltree::Document::parse(&svg).unwrap();
            let marks = document.descendants().filter(|node| matches!(node.tag_name().name(), "path" | "circle"));
            marks.map(|node| (node.tag_name().name().to_owned(), node.attribute("id").unwrap().to_owned())).collect()
        };
        let of = |name: &str, ids: &[&str]| -> Vec<(String, String)> {
            ids.iter().map(|id| (name.to_owned(), (*id).to_owned())).collect()
        };
        let regions = of("path", &["black-region-0", "black-region-2"]);
        let dots = of("circle", &["black-stipple-1", "black-stipple-2", "black-stipple-3"]);
        let inner = of("circle", &["black-stipple-0"]);
        assert_eq!(ids(flat(Only::default())), [regions.clone(), inner.clone(), dots.clone()].concat());
        assert_eq!(ids(layered()), [regions, dots, of("path", &["white-region-1"]), inner].concat());
        let svg = to_svg(&sample, &Export { elements: Elements::Marks, ..Export::default() }).unwrap();
        // 53.21, 40.4 and 1.3 px in sixteenths: these are on no grid.
        assert!(svg.contains("<circle id=\"black-stipple-2\" cx=\"768\" cy=\"640\" r=\"8\"/>"), "{svg}");
    }

    #[test]
    fn strokes_take_a_fraction_of_the_bytes() {
        let sample = samples::field_of_blobs(2000);
        let dots = |dots: Dots| to_svg(&sample, &Export { dots, ..Export::default() }).unwrap();
        let layer = |svg: &str| svg.split("id=\"black-stipples\"").nth(1).unwrap().to_owned();
        let strokes = layer(&dots(Dots::Strokes));
        let paint = " fill=\"none\" stroke=\"#000\" stroke-linecap=\"round\" transform=\"scale(.015625)\">\n<path stroke-width=\"76.8\" d=\"m";
        assert!(strokes.split("Black stipples\"").nth(1).unwrap().starts_with(paint), "{}", &strokes[..300]);
        assert_eq!(strokes.matches("h.04").count() + strokes.matches("h-.04").count(), 2000);
        assert!(strokes.len() < 2000 * 17 && layer(&dots(Dots::Circles)).len() > 2000 * 40, "{}", strokes.len());
    }

    #[test]
    fn sizes_are_in_the_unit_asked_for_and_the_data_are_not_scaled() {
        let sample = samples::nested();
        let plain = to_svg(&sample, &layered()).unwrap();
        let mut export = layered();
        export.layout.width = Some("128mm".parse().unwrap());
        export.layout.margin = "10mm".parse().unwrap();
        let sized = to_svg(&sample, &export).unwrap();
        assert!(sized.contains("width=\"148mm\" height=\"116mm\" viewBox=\"-5 -5 74 58\""), "{}", &sized[..400]);
        assert_eq!(paths_of(&plain), paths_of(&sized));
        // A page has no width of the drawing's that would say the unit.
        export.layout = Layout { page: Some("A4".parse().unwrap()), ..Layout::default() };
        assert!(to_svg(&sample, &export).unwrap().contains("width=\"297mm\" height=\"210mm\""));
    }

    #[test]
    fn text_is_escaped() {
        let mut sample = samples::nested();
        sample.provenance.importance = "a<b>&\"c\"".into();
        let svg = to_svg(&sample, &layered()).unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let json = document.descendants().find(|n| n.has_tag_name((NAMESPACE, "drawing"))).unwrap().text().unwrap();
        assert_eq!(serde_json::from_str::<crate::drawing::Provenance>(json).unwrap(), sample.provenance);
    }

    #[test]
    fn long_layers_are_split_between_areas() {
        let sample = samples::field_of_blobs(20_000);
        let svg = to_svg(&sample, &layered()).unwrap();
        let paths = paths_of(&svg);
        assert!(paths.len() > 2 && paths.len() < 30, "{}", paths.len());
        let moves: usize = paths.iter().map(|p| p.1.elements().iter().filter(|e| matches!(e, PathEl::MoveTo(_))).count()).sum();
        assert_eq!(moves, 40_000);
        let black = sample.regions.iter().filter(|region| region.ink == Ink::BLACK);
        let regions: f64 = black.map(|region| region.enclosed_area).sum();
        let dots: f64 = sample.stipples.iter().map(|s| s.radius * s.radius * std::f64::consts::PI).sum();
        let written: f64 = paths.iter().map(|p| p.1.area()).sum();
        // These blobs lie on no grid and are written with all their digits; kurbo makes the arcs of dots of cubics.
        assert!((written / (regions + dots) - 1.0).abs() < 2e-3, "{written} instead of {regions} + {dots}");
    }
}
