//! Reading drawings back from our own JSON and SVG files.
//!
//! # The idea
//! Whatever the style and the inks, a file holds every boundary curve and every stipple, with black on a known side. What lies
//! beside what is found again from the geometry: next to a curve lies what its nearest neighbour to the left has on its right. Then
//! the drawing is put together as it was when it was made (see [`assemble`](crate::stages::assemble)), and is the same.
//!
//! What this module does not do: read files of other programs, or our own after another program changed their paths.

use kurbo::{BezPath, PathEl, Point};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::base::{Error, Frame, Ink, Result, is_closed};
use crate::drawing::{Drawing, Provenance, invalid, put_together};
use crate::files::json::{Canvas, Dot, FORMAT, NAMES};
use crate::files::svg::NAMESPACE;
use crate::outlines::Stipple;
use crate::photo::check_size;

/// What is read from a file before it is known what lies beside what.
struct Contents {
    width: usize,
    height: usize,
    units: f64,
    /// Black on their left; closed, or from frame to frame.
    curves: Vec<BezPath>,
    stipples: Vec<Stipple>,
    /// Ink of the canvas if there is nothing on it.
    ground: Ink,
    provenance: Provenance,
}

/// Reads the text of a JSON file that [`super::json::to_json`] wrote.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub(super) fn from_json(text: &str) -> Result<Drawing> {
    #[derive(Deserialize)]
    struct Region {
        ink: u8,
    }
    #[derive(Deserialize)]
    struct Document {
        format: String,
        version: String,
        importance: String,
        options: Map<String, Value>,
        canvas: Canvas,
        units: f64,
        stipples: Vec<Dot>,
        regions: Vec<Region>,
        curves: Vec<String>,
        #[serde(flatten)]
        rest: Map<String, Value>,
    }
    let document: Document = serde_json::from_str(text).map_err(invalid)?;
    if document.format != FORMAT {
        return Err(invalid(format!("its format is \"{}\", but it must be \"{FORMAT}\"", document.format)));
    }
    let stipple = |dot: Dot| Stipple { x: dot.x, y: dot.y, radius: dot.radius, ink: Ink::of_label(dot.ink), level: 0 };
    let curve = |(number, data): (usize, &String)| {
        BezPath::from_svg(data).map_err(|error| invalid(format!("curve {number} is no path data ({error})")))
    };
    rebuild(Contents {
        width: document.canvas.width,
        height: document.canvas.height,
        units: document.units,
        curves: document.curves.iter().enumerate().map(curve).collect::<Result<_>>()?,
        stipples: document.stipples.into_iter().map(stipple).collect(),
        ground: Ink::of_label(document.regions.first().map_or(1, |region| region.ink)),
        provenance: Provenance {
            version: document.version,
            importance: document.importance,
            options: document.options,
            rest: document.rest,
        },
    })
}

/// Reads the text of an SVG file that [`super::svg::to_svg`] wrote, in any style and with any inks.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub(super) fn from_svg(text: &str) -> Result<Drawing> {
    let document = roxmltree::Document::parse(text).map_err(invalid)?;
    let about = document.descendants().find(|node| node.has_tag_name((NAMESPACE, "drawing")));
    let about = about.ok_or_else(|| invalid("it does not say how it was made"))?;
    let number = |name: &str| {
        let value = about.attribute(name).and_then(|value| value.parse::<f64>().ok());
        value.ok_or_else(|| invalid(format!("it does not say the {name} of its canvas")))
    };
    let (width, height) = (number("width")? as usize, number("height")? as usize);
    check_size(width, height)?;
    let mut contents = Contents {
        width,
        height,
        units: number("units")?,
        curves: Vec::new(),
        stipples: Vec::new(),
        ground: Ink::White,
        provenance: serde_json::from_str(about.text().unwrap_or_default()).map_err(invalid)?,
    };
    // A JSON file has names of its own beside those of the provenance.
    contents.provenance.rest.retain(|name, _| !NAMES.contains(&name.as_str()));
    let groups = || document.descendants().filter(|node| node.has_tag_name("g"));
    let ink_of = |id: &str| {
        let id = id
            .strip_prefix("level-")
            .map_or(id, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start_matches('-'));
        match id {
            "black-regions" | "black-stipples" => Some(Ink::Black),
            "white-regions" | "white-stipples" => Some(Ink::White),
            _ => None,
        }
    };
    let layers: Vec<(Ink, bool, roxmltree::Node)> = groups()
        .filter_map(|group| {
            let id = group.attribute("id")?;
            Some((ink_of(id)?, id.starts_with("level-"), group))
        })
        .collect();
    if groups().any(|group| group.attribute("id") == Some("paper") && group.attribute("fill").is_none()) {
        contents.ground = Ink::Black;
    }
    // In a flat drawing black alone, or white alone, says everything.
    let has_black = layers.iter().any(|(ink, ..)| *ink == Ink::Black);
    for (ink, is_layered, group) in layers {
        if !is_layered && ink == Ink::White && has_black {
            continue;
        }
        for path in group.children().filter(|node| node.has_tag_name("path")) {
            let data = path.attribute("d").unwrap_or_default();
            PathReader::new(data, contents.units).read(|shape| contents.add(shape, ink))?;
        }
    }
    rebuild(contents)
}

/// A subpath.
enum Subpath {
    /// A circle, and whether it runs as exteriors do.
    Circle {
        x: f64,
        y: f64,
        radius: f64,
        is_exterior: bool,
    },
    Ring(BezPath),
}

impl Contents {
    /// Takes up a subpath of a layer of the given ink.
    fn add(&mut self, subpath: Subpath, ink: Ink) {
        match subpath {
            Subpath::Circle { x, y, radius, is_exterior } => {
                let ink = if is_exterior { ink } else { ink.other() };
                self.stipples.push(Stipple { x, y, radius, ink, level: 0 });
            }
            Subpath::Ring(ring) => {
                let oriented = |curve: BezPath| if ink == Ink::Black { curve } else { curve.reverse_subpaths() };
                match self.cut_at_frame(&ring) {
                    None => self.curves.push(oriented(ring)),
                    Some(curves) => {
                        if curves.is_empty() {
                            self.ground = ink;
                        }
                        self.curves.extend(curves.into_iter().map(oriented));
                    }
                }
            }
        }
    }

    /// The curves of a ring between its runs along the frame; `None` if it has no such run.
    fn cut_at_frame(&self, ring: &BezPath) -> Option<Vec<BezPath>> {
        let (width, height) = (self.width as f64, self.height as f64);
        let on_one_side =
            |p: Point, q: Point| (p.y == q.y && (p.y == 0.0 || p.y == height)) || (p.x == q.x && (p.x == 0.0 || p.x == width));
        let mut elements: Vec<PathEl> = ring.elements().iter().copied().filter(|element| *element != PathEl::ClosePath).collect();
        let start = elements.first().and_then(PathEl::end_point)?;
        // Every element with the point where it begins; the line that closes the ring is one of them.
        elements.push(PathEl::LineTo(start));
        let mut drawn: Vec<(Point, PathEl)> = Vec::new();
        let mut at = start;
        for element in &elements[1..] {
            let end = element.end_point()?;
            if end != at || !matches!(element, PathEl::LineTo(_)) {
                drawn.push((at, *element));
            }
            at = end;
        }
        let on_frame = |(from, element): &(Point, PathEl)| matches!(element, PathEl::LineTo(to) if on_one_side(*from, *to));
        let first = drawn.iter().position(on_frame)?;
        drawn.rotate_left(first);
        let mut curves = Vec::new();
        for run in drawn.split(on_frame).filter(|run| !run.is_empty()) {
            let mut curve = BezPath::new();
            curve.move_to(run[0].0);
            run.iter().for_each(|(_, element)| curve.push(*element));
            curves.push(curve);
        }
        Some(curves)
    }
}

/// Reads the path data that [`super::svg`] writes: relative commands, every subpath closed.
struct PathReader<'a> {
    bytes: &'a [u8],
    at: usize,
    units: f64,
}

impl<'a> PathReader<'a> {
    fn new(data: &'a str, units: f64) -> Self {
        Self { bytes: data.as_bytes(), at: 0, units }
    }

    fn read(mut self, mut visit: impl FnMut(Subpath)) -> Result<()> {
        // In units.
        let mut start = Point::ZERO;
        while let Some(command) = self.command() {
            if command != b'm' {
                return Err(self.unexpected());
            }
            let begin = self.point(start)?;
            start = begin;
            let pixels = |p: Point, units: f64| Point::new(p.x / units, p.y / units);
            let mut path = BezPath::new();
            path.move_to(pixels(begin, self.units));
            let (mut current, mut mirrored, mut circle) = (begin, begin, None);
            let mut command = b'l';
            loop {
                match self.command() {
                    Some(b'z') => break,
                    Some(letter) => command = letter,
                    None if self.at >= self.bytes.len() => return Err(self.unexpected()),
                    None => {}
                }
                let units = self.units;
                match command {
                    b'l' => current = self.point(current)?,
                    b'h' => current.x += self.number()?,
                    b'v' => current.y += self.number()?,
                    b'q' | b't' => {
                        let control = if command == b'q' { self.point(current)? } else { mirrored };
                        current = self.point(current)?;
                        mirrored = current + (current - control);
                        path.quad_to(pixels(control, units), pixels(current, units));
                    }
                    b'c' | b's' => {
                        let first = if command == b'c' { self.point(current)? } else { mirrored };
                        let second = self.point(current)?;
                        current = self.point(current)?;
                        mirrored = current + (current - second);
                        path.curve_to(pixels(first, units), pixels(second, units), pixels(current, units));
                    }
                    b'a' => {
                        let radius = self.number()?;
                        let [_, _, _, sweep, _, _] = [(); 6].map(|()| self.number());
                        circle = Some(Subpath::Circle {
                            x: (begin.x + radius) / units,
                            y: begin.y / units,
                            radius: radius / units,
                            is_exterior: sweep? == 1.0,
                        });
                    }
                    _ => return Err(self.unexpected()),
                }
                if matches!(command, b'l' | b'h' | b'v') {
                    path.line_to(pixels(current, units));
                }
            }
            if current != begin {
                path.line_to(Point::new(begin.x / self.units, begin.y / self.units));
            }
            path.close_path();
            visit(circle.unwrap_or(Subpath::Ring(path)));
        }
        if self.at < self.bytes.len() { Err(self.unexpected()) } else { Ok(()) }
    }

    fn unexpected(&self) -> Error {
        invalid(format!("its path data are others at byte {}", self.at))
    }

    /// The letter at this place, if there is one.
    fn command(&mut self) -> Option<u8> {
        let letter = *self.bytes.get(self.at).filter(|byte| byte.is_ascii_alphabetic())?;
        self.at += 1;
        Some(letter)
    }

    fn number(&mut self) -> Result<f64> {
        while self.bytes.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
        let begin = self.at;
        if self.bytes.get(self.at) == Some(&b'-') {
            self.at += 1;
        }
        let mut has_point = false;
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'0'..=b'9' => {}
                b'.' if !has_point => has_point = true,
                _ => break,
            }
            self.at += 1;
        }
        let text = std::str::from_utf8(&self.bytes[begin..self.at]).unwrap_or_default();
        text.parse().map_err(|_| self.unexpected())
    }

    /// A point relative to another.
    fn point(&mut self, from: Point) -> Result<Point> {
        Ok(Point::new(from.x + self.number()?, from.y + self.number()?))
    }
}

/// The drawing of these curves and dots.
fn rebuild(contents: Contents) -> Result<Drawing> {
    let Contents { width, height, units, curves, stipples, ground, provenance } = contents;
    check_size(width, height)?;
    if !(units.is_finite() && units >= 1.0) {
        return Err(invalid(format!("its grid has {units} units to a pixel")));
    }
    let frame = Frame { width: width as f64, height: height as f64 };
    for (number, curve) in curves.iter().enumerate() {
        check_curve(curve, frame).map_err(|what| invalid(format!("curve {number} {what}")))?;
    }
    for (number, dot) in stipples.iter().enumerate() {
        let reach = [dot.x, dot.y, frame.width - dot.x, frame.height - dot.y].into_iter().fold(f64::INFINITY, f64::min);
        if !(dot.radius > 0.0 && dot.radius <= reach) {
            return Err(invalid(format!("stipple {number} does not lie on the canvas")));
        }
    }
    let drawing = put_together(width, height, units, curves, stipples, ground)?;
    Ok(Drawing { provenance, ..drawing })
}

fn check_curve(curve: &BezPath, frame: Frame) -> std::result::Result<(), &'static str> {
    let elements = curve.elements();
    let points = || elements.iter().filter_map(PathEl::end_point);
    let moves = elements.iter().filter(|element| matches!(element, PathEl::MoveTo(_))).count();
    let (Some(first), Some(last)) = (points().next(), points().next_back()) else {
        return Err("is empty");
    };
    if moves != 1 || elements.len() < 2 {
        return Err("is not one curve");
    }
    let on_canvas = |p: Point| p.x >= 0.0 && p.y >= 0.0 && p.x <= frame.width && p.y <= frame.height;
    if !points().all(on_canvas) || !elements.iter().all(PathEl::is_finite) {
        return Err("leaves the canvas");
    }
    if !is_closed(curve) && (frame.holds(first) || frame.holds(last)) {
        return Err("is neither closed nor goes from frame to frame");
    }
    Ok(())
}
