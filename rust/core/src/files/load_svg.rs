//! Reading a drawing from our own SVG, in any style and with any inks: the path data of its layers.

use kurbo::{BezPath, Point};

use crate::base::{Control, Error, Ink, Result};
use crate::drawing::{Drawing, invalid};
use crate::files::json::NAMES;
use crate::files::load::{Contents, Subpath, rebuild};
use crate::files::svg::NAMESPACE;
use crate::photo::check_size;

/// Reads the text of an SVG file that [`super::svg::to_svg`] wrote, in any style and with any inks.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub(super) fn from_svg(text: &str, control: &Control) -> Result<Drawing> {
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
    rebuild(contents, control)
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
