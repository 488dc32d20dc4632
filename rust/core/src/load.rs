//! Reading drawings back from our own JSON and SVG files.
//!
//! # The idea
//! Whatever the style and the inks, a file holds every boundary curve and every stipple, with black on a known side. What lies
//! beside what is found again from the geometry: next to a curve lies what its nearest neighbour to the left has on its right. Then
//! the drawing is put together as it was when it was made (see [`crate::assembly`]), and is the same.
//!
//! What this module does not do: read files of other programs, or our own after another program changed their paths.

use kurbo::{BezPath, PathEl, Point, Shape};
use serde::Deserialize;

use crate::assembly::{End, Parts, assemble, ends_on_frame, flattened_edges, is_closed};
use crate::drawing::{Drawing, FLATTENING_TOLERANCE, Frame, Ink, Provenance, Stipple, flatten_path};
use crate::error::{Error, Result};
use crate::field::check_size;
use crate::json::{Canvas, Dot, FORMAT};
use crate::params::Options;
use crate::svg::NAMESPACE;

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

fn invalid(what: impl std::fmt::Display) -> Error {
    Error::Input(format!("this is not a drawing that graphstipple wrote: {what}"))
}

/// Reads the text of a JSON file that [`crate::json::to_json`] wrote.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub fn from_json(text: &str) -> Result<Drawing> {
    #[derive(Deserialize)]
    struct Region {
        ink: u8,
    }
    #[derive(Deserialize)]
    struct Document {
        format: String,
        version: String,
        importance: String,
        options: Options,
        canvas: Canvas,
        units: f64,
        stipples: Vec<Dot>,
        regions: Vec<Region>,
        curves: Vec<String>,
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
        provenance: Provenance { version: document.version, importance: document.importance, options: document.options },
    })
}

/// Reads the text of an SVG file that [`crate::svg::to_svg`] wrote, in any style and with any inks.
///
/// # Errors
/// [`Error::Input`] if it is something else.
pub fn from_svg(text: &str) -> Result<Drawing> {
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

/// Reads the path data that [`crate::svg`] writes: relative commands, every subpath closed.
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

/// The drawing of curves, black on their left, and dots; its provenance is left empty. `ground` is the ink of a canvas with nothing
/// on it.
///
/// # Errors
/// [`Error::Input`] if they do not fit together.
pub(crate) fn put_together(
    width: usize,
    height: usize,
    units: f64,
    curves: Vec<BezPath>,
    stipples: Vec<Stipple>,
    ground: Ink,
) -> Result<Drawing> {
    let frame = Frame { width: width as f64, height: height as f64 };
    let mut sides = Sides::new(frame, &curves, stipples.first().map_or(ground, |dot| dot.ink.other()));
    for (number, curve) in curves.iter().enumerate().filter(|(_, curve)| is_closed(curve)) {
        let outer = if curve.area() > 0.0 { white_side(number) } else { black_side(number) };
        let left = leftmost(curve);
        let beside = sides.at_left_of(left, Some(number));
        sides.join(outer, beside)?;
    }
    let around: Vec<usize> = stipples.iter().map(|dot| sides.at_left_of(Point::new(dot.x - dot.radius, dot.y), None)).collect();

    let (mut inks, ids) = sides.components();
    let beside = |number: usize| [ids[black_side(number)], ids[white_side(number)]];
    let mut parts = Parts { width, height, units, on_frame: ids[sides.ground], ..Parts::default() };
    for (dot, around) in stipples.into_iter().zip(around) {
        if dot.ink == inks[ids[around] as usize] {
            return Err(invalid(format!("a {} stipple lies in {}", dot.ink.name(), dot.ink.name())));
        }
        parts.stipples.push((dot, [inks.len() as u32, ids[around]]));
        inks.push(dot.ink);
    }
    parts.curves = curves.into_iter().enumerate().map(|(number, curve)| (curve, beside(number))).collect();
    parts.inks = inks;
    assemble(parts).map_err(|error| invalid(format!("its shapes do not fit together ({error})")))
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

fn leftmost(curve: &BezPath) -> Point {
    let points = flatten_path(curve, FLATTENING_TOLERANCE);
    let least = points.into_iter().min_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    least.map_or(Point::ZERO, |[x, y]| Point::new(x, y))
}

fn black_side(curve: usize) -> usize {
    2 * curve
}

fn white_side(curve: usize) -> usize {
    2 * curve + 1
}

/// A piece of a flattened curve.
#[derive(Clone, Copy)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    curve: usize,
}

impl Edge {
    /// Where the edge, which is not level, is at a height.
    fn x_at(&self, y: f64) -> f64 {
        self.from[0] + (y - self.from[1]) * (self.to[0] - self.from[0]) / (self.to[1] - self.from[1])
    }

    /// Whether the edge lies to the right of another at the heights that both span. They may meet at one end of these heights but
    /// do not cross, so their middle decides.
    fn is_right_of(&self, other: Self) -> bool {
        let top = self.from[1].min(self.to[1]).max(other.from[1].min(other.to[1]));
        let bottom = self.from[1].max(self.to[1]).min(other.from[1].max(other.to[1]));
        let y = 0.5 * (top + bottom);
        self.x_at(y) > other.x_at(y)
    }
}

/// Both sides of every curve, joined where nothing lies between them.
struct Sides {
    /// A forest: every side points to one of its component.
    joined: Vec<usize>,
    inks: Vec<Ink>,
    /// What stands for the canvas where no curve ends on the frame.
    ground: usize,
    ends: Vec<End>,
    /// The edges that meet a row of pixels, row by row.
    rows: Vec<Vec<Edge>>,
    frame: Frame,
}

impl Sides {
    fn new(frame: Frame, curves: &[BezPath], ground: Ink) -> Self {
        let ground_side = 2 * curves.len();
        let mut inks: Vec<Ink> = (0..ground_side).map(|side| if side % 2 == 0 { Ink::Black } else { Ink::White }).collect();
        inks.push(ground);
        let ends = ends_on_frame(frame, curves);
        let mut rows: Vec<Vec<Edge>> = (0..frame.height as usize).map(|_| Vec::new()).collect();
        let last_row = rows.len() - 1;
        let row = |y: f64| (y.max(0.0) as usize).min(last_row);
        for (curve, path) in curves.iter().enumerate() {
            for [from, to] in flattened_edges(path) {
                for row in &mut rows[row(from[1].min(to[1]))..=row(from[1].max(to[1]))] {
                    row.push(Edge { from, to, curve });
                }
            }
        }
        let mut sides = Self { joined: (0..inks.len()).collect(), inks, ground: ground_side, ends, rows, frame };
        for k in 0..sides.ends.len() {
            let next = (k + 1) % sides.ends.len();
            let ([_, after], [before, _]) = (sides.around(k), sides.around(next));
            let (a, b) = (sides.root(after), sides.root(before));
            sides.joined[a] = b;
        }
        sides
    }

    /// The sides on the frame just before and just after an end, in the positive direction.
    fn around(&self, k: usize) -> [usize; 2] {
        let curve = self.ends[k].curve as usize;
        self.ends[k].around([black_side(curve), white_side(curve)])
    }

    fn root(&mut self, mut side: usize) -> usize {
        while self.joined[side] != side {
            self.joined[side] = self.joined[self.joined[side]];
            side = self.joined[side];
        }
        side
    }

    fn join(&mut self, a: usize, b: usize) -> Result<()> {
        let (a, b) = (self.root(a), self.root(b));
        // A ground that nothing touches has the ink of what is found there.
        if a == self.ground {
            self.inks[a] = self.inks[b];
        }
        if b == self.ground {
            self.inks[b] = self.inks[a];
        }
        if self.inks[a] != self.inks[b] {
            return Err(invalid("two curves have different inks between them"));
        }
        self.joined[a.max(b)] = a.min(b);
        if a.max(b) == self.ground {
            self.ground = a.min(b);
        }
        Ok(())
    }

    /// The side that lies at a point, seen to the left of it; edges of the curve `own` are looked through.
    fn at_left_of(&mut self, p: Point, own: Option<usize>) -> usize {
        let row = (p.y.max(0.0) as usize).min(self.rows.len() - 1);
        let mut nearest: Option<Edge> = None;
        for edge in self.rows[row].iter().filter(|edge| Some(edge.curve) != own) {
            let spans = (edge.from[1] <= p.y) != (edge.to[1] <= p.y);
            if spans && edge.x_at(p.y) < p.x && nearest.is_none_or(|best| edge.is_right_of(best)) {
                nearest = Some(*edge);
            }
        }
        if let Some(edge) = nearest {
            // A curve that goes up has its left, the black side, on the right.
            return if edge.to[1] < edge.from[1] { black_side(edge.curve) } else { white_side(edge.curve) };
        }
        if self.ends.is_empty() {
            return self.ground;
        }
        let position = self.frame.position(Point::new(0.0, p.y));
        // Just below, since an edge spans its top and not its bottom: the frame runs upwards here.
        let behind = self.ends.partition_point(|end| end.position < position);
        self.around((behind + self.ends.len() - 1) % self.ends.len())[1]
    }

    /// The ink of every component, and the component of every side.
    fn components(&mut self) -> (Vec<Ink>, Vec<u32>) {
        let mut inks = Vec::new();
        let mut ids = vec![u32::MAX; self.joined.len()];
        // The stand-in for the canvas counts only where it is needed.
        let count = if self.ends.is_empty() { self.joined.len() } else { self.joined.len() - 1 };
        for side in 0..count {
            let root = self.root(side);
            if ids[root] == u32::MAX {
                ids[root] = inks.len() as u32;
                inks.push(self.inks[root]);
            }
            ids[side] = ids[root];
        }
        (inks, ids)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_edges_that_meet_the_middle_of_their_common_heights_decides() {
        let edge = |from, to| Edge { from, to, curve: 0 };
        // Both end in (1, 1), just below the height that is asked for: there they cannot be told apart.
        let (left, right) = (edge([0.0, 0.0], [1.0, 1.0]), edge([1.0, 1.0], [2.0, 0.0]));
        assert!(right.is_right_of(left) && !left.is_right_of(right));
        // Both begin there.
        let (left, right) = (edge([1.0, 1.0], [0.0, 2.0]), edge([9.0, 2.0], [1.0, 1.0]));
        assert!(right.is_right_of(left) && !left.is_right_of(right));
    }
}
