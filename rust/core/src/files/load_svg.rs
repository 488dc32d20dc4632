//! Reading a drawing from our own SVG, in any style, with any inks, elements and dots: what its layers draw.
//!
//! # What is accepted
//! All that is drawn in the file has to be understood, or the file is refused with the name of the element: other elements,
//! attributes that change how ours look, layers that are not ours, twice there or out of order, colours and papers that are not those
//! of the picture. What draws nothing is passed over: comments, titles, and the elements and attributes of other namespaces, as
//! editors add them. Nothing here goes deeper than the elements of a layer, so that nothing is as deep as a file may be nested.

use std::fmt;

use kurbo::{BezPath, PathEl};
use roxmltree::{Document, Node};

use crate::base::{Color, Control, Ink, Palette, Result, WrittenPalette, in_one_line};
use crate::drawing::{Drawing, Provenance, invalid};
use crate::files::json::NAMES;
use crate::files::layers::{Area, Style};
use crate::files::load::{Contents, Subpath, rebuild};
use crate::files::load_inks::{OfLayer, Outlines};
use crate::files::plates::REGISTRATION;
use crate::files::read_path::{PathReader, circle, number};
use crate::files::sources::Sources;
use crate::files::strokes::FINER;
use crate::files::svg::{MULTIPLY, NAMESPACE};
use crate::files::text_of;
use crate::options::Only;
use crate::photo::check_size;

/// The namespace of SVG.
const SVG: &str = "http://www.w3.org/2000/svg";

/// How far the page may fall short of the canvas or a paper of the page, in pixels: numbers in files have six decimals.
const SLACK: f64 = 1e-5;

/// Reads an SVG file that [`super::svg::to_svg`] wrote, in any style and with any inks.
///
/// # Errors
/// [`crate::Error::Input`] if it is something else.
pub(super) fn from_svg(bytes: &[u8], control: &Control) -> Result<Drawing> {
    let document = Document::parse(text_of(bytes)?).map_err(invalid)?;
    let root = document.root_element();
    if !is_svg(root, "svg") {
        return Err(invalid(format!("{} is no SVG", Named(root))));
    }
    if let Some(instruction) = document.root().children().find(Node::is_pi) {
        let target = instruction.pi().map_or("", |pi| pi.target);
        return Err(invalid(format!("the instruction {} may change how it looks", quoted(target))));
    }
    check_attributes(root, &["width", "height", "viewBox", "version", "style"])?;
    // Files of older versions say what browsers are to show behind the drawing.
    if root.attribute("style").is_some_and(|style| !style.starts_with("background:") || style.contains(';')) {
        return Err(other_value(root, "style"));
    }
    let (mut about, mut groups) = (None, Vec::new());
    for node in drawn_children(root) {
        match node.tag_name().name() {
            "metadata" => about = about.or(node.children().find(|node| node.has_tag_name((NAMESPACE, "drawing")))),
            "defs" => {
                if let Some(defined) = drawn_children(node).next() {
                    return Err(not_ours(defined));
                }
            }
            "g" => groups.push(node),
            _ => return Err(not_ours(node)),
        }
    }
    let about = about.ok_or_else(|| invalid("it does not say how it was made"))?;
    let mut reader = Reader::new(about)?;
    let view = page(root, &reader.contents)?;
    reader.groups(&groups, view)?;
    let (contents, shown) = reader.finish()?;
    let drawing = rebuild(contents, control)?;
    shown.check(&drawing)?;
    Ok(drawing)
}

/// The page, as left, top, right and bottom in pixels of the canvas, which has to lie on it.
fn page(root: Node<'_, '_>, contents: &Contents) -> Result<[f64; 4]> {
    let numbers: Option<Vec<f64>> = root.attribute("viewBox").unwrap_or_default().split(' ').map(number).collect();
    match numbers.as_deref() {
        Some(&[left, top, width, height]) => {
            let sides = [left, top, left + width, top + height];
            let [right, bottom] = [contents.width as f64, contents.height as f64];
            if left <= SLACK && top <= SLACK && sides[2] >= right - SLACK && sides[3] >= bottom - SLACK {
                return Ok(sides);
            }
            Err(invalid("its viewBox does not show all of the canvas"))
        }
        _ => Err(invalid("its viewBox is not four numbers")),
    }
}

fn is_svg(node: Node<'_, '_>, name: &str) -> bool {
    node.has_tag_name((SVG, name))
}

/// The children of an element but for those that draw nothing: of other namespaces, and titles and descriptions.
fn drawn_children<'a, 'input>(node: Node<'a, 'input>) -> impl Iterator<Item = Node<'a, 'input>> {
    let is_drawn = |node: &Node<'_, '_>| {
        node.is_element() && node.tag_name().namespace() == Some(SVG) && !matches!(node.tag_name().name(), "title" | "desc")
    };
    node.children().filter(is_drawn)
}

/// An element in words.
struct Named<'a, 'input>(Node<'a, 'input>);

impl fmt::Display for Named<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the element <{}", quoted(self.0.tag_name().name()))?;
        match self.0.attribute("id") {
            Some(id) => write!(f, " id=\"{}\">", quoted(id)),
            None => write!(f, ">"),
        }
    }
}

fn not_ours(node: Node<'_, '_>) -> crate::Error {
    invalid(format!("{} in line {} is none of its own", Named(node), line(node)))
}

fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The most characters that a message quotes.
const MOST_QUOTED: usize = 60;

/// What stands in a file, for a message.
fn quoted(text: &str) -> String {
    in_one_line(&text.chars().take(MOST_QUOTED).collect::<String>())
}

fn other_value(node: Node<'_, '_>, attribute: &str) -> crate::Error {
    let value = node.attribute(attribute).map_or("missing".to_owned(), |value| format!("\"{}\"", quoted(value)));
    invalid(format!("the attribute {attribute} of {} is {value}, which is not what it would be", Named(node)))
}

/// Refuses attributes that are not among those that the element has; an id is any element's.
fn check_attributes(node: Node<'_, '_>, known: &[&str]) -> Result<()> {
    let is_other = |name: &str| name != "id" && !known.contains(&name);
    let of_svg = |attribute: &roxmltree::Attribute<'_, '_>| attribute.namespace().is_none() && is_other(attribute.name());
    match node.attributes().find(of_svg) {
        Some(other) if other.name() == "style" && is_shown(other.value()) => Ok(()),
        Some(other) => {
            Err(invalid(format!("{} has an attribute {} that may change how it looks", Named(node), quoted(other.name()))))
        }
        None => Ok(()),
    }
}

/// Whether a style says no more than that the element is shown, as Inkscape does.
fn is_shown(style: &str) -> bool {
    matches!(style.trim_end_matches(';'), "display:inline")
}

/// Whether a style says that the element is shown and multiplies what lies under it, and no more.
fn multiplies(style: &str) -> bool {
    let mut parts = style.trim_end_matches(';').split(';');
    style.contains(MULTIPLY) && parts.all(|part| part == MULTIPLY || is_shown(part))
}

/// Refuses an element with anything in it that draws.
fn check_leaf(node: Node<'_, '_>) -> Result<()> {
    drawn_children(node).find(|child| !is_svg(*child, "metadata")).map_or(Ok(()), |child| Err(not_ours(child)))
}

/// A number in an attribute; what is missing is 0.
fn coordinate(node: Node<'_, '_>, attribute: &str) -> Result<f64> {
    let value = node.attribute(attribute).map_or(Some(0.0), number);
    value.ok_or_else(|| other_value(node, attribute))
}

/// What a group is, in the order in which they stand in a file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Role {
    Paper,
    Underlay,
    Layer(Kind),
}

impl Role {
    fn of(id: &str, palette: &Palette) -> Option<Self> {
        let is_plain = palette.is_black_and_white();
        match id {
            "paper" => return Some(Self::Paper),
            "underlay" if is_plain => return Some(Self::Underlay),
            _ => {}
        }
        let kind_of = |level: u32, name: &str| {
            let (ink, kind) = name.rsplit_once('-')?;
            let ink = Ink::of_label(palette.names().position(|name| name == ink)? as u8);
            let is_dots = ["regions", "stipples"].iter().position(|known| *known == kind)? == 1;
            Some(Kind { level, ink, is_dots })
        };
        // An ink may be called as a level is.
        if let Some(kind) = kind_of(0, id) {
            return Some(Self::Layer(kind));
        }
        let (level, name) = id.strip_prefix("level-")?.split_once('-')?;
        let kind = kind_of(level.parse().ok().filter(|level| *level > 0)?, name)?;
        // Black lies on the paper, white on black.
        let is_possible = if is_plain { kind.level % 2 == u32::from(kind.ink == Ink::BLACK) } else { !palette.overprint() };
        is_possible.then_some(Self::Layer(kind))
    }
}

/// A layer as its id tells it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    /// 0 in a flat drawing.
    level: u32,
    /// Of a flat drawing the number of the ink, which is the label unless inks lie over each other.
    ink: Ink,
    is_dots: bool,
}

/// What is read so far.
struct Reader {
    contents: Contents,
    /// What the white layers of a flat drawing with both inks say: the same again.
    again: Contents,
    /// The outlines of other inks than black and white, until all are read.
    outlines: Option<Outlines>,
    /// Whether a flat drawing has black, and so whether it is told twice.
    has_black: bool,
    is_twice: bool,
    shown: Shown,
    /// Colour of the paper.
    paper: Option<[u8; 3]>,
}

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

impl Reader {
    fn new(about: Node<'_, '_>) -> Result<Self> {
        let value = |name: &str| about.attribute(name).unwrap_or_default();
        let missing = |name: &str| invalid(format!("it does not say the {name} of its canvas"));
        let pixels = |name: &str| value(name).parse::<usize>().map_err(|_| missing(name));
        let (width, height) = (pixels("width")?, pixels("height")?);
        check_size(width, height)?;
        let (palette, only) = inks(about)?;
        let units = number(value("units")).filter(|units| *units >= 1.0).ok_or_else(|| missing("units"))?;
        let ground = match about.attribute("ground") {
            None => Ink::WHITE,
            Some("black") => Ink::BLACK,
            Some(_) => return Err(missing("ground")),
        };
        let mut provenance: Provenance = serde_json::from_str(about.text().unwrap_or_default()).map_err(invalid)?;
        // A JSON file has names of its own beside those of the provenance.
        provenance.rest.retain(|name, _| !NAMES.contains(&name.as_str()));
        let empty = |provenance| {
            let (curves, sides, stipples, dots, sources) = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Sources::default());
            let palette = palette.clone();
            Contents { width, height, units, palette, curves, sides, stipples, dots, ground, provenance, sources }
        };
        let (contents, again) = (empty(provenance), empty(Provenance::default()));
        let drawn = only.of(&palette)?;
        let outlines = (!palette.is_black_and_white()).then(|| Outlines::new(palette, drawn));
        if outlines.as_ref().is_some_and(|outlines| !outlines.are_enough()) {
            let what =
                format!("an SVG with {only} alone of its inks is not read back: save the drawing with all of them, or as .json");
            return Err(crate::Error::Input(what));
        }
        let shown = Shown { only, ..Shown::default() };
        Ok(Self { contents, again, outlines, has_black: false, is_twice: false, shown, paper: None })
    }

    /// Reads the groups of the root, on a page with these sides.
    fn groups(&mut self, groups: &[Node<'_, '_>], page: [f64; 4]) -> Result<()> {
        let mut last = None;
        for group in groups {
            let id = group.attribute("id").unwrap_or_default();
            if id == REGISTRATION {
                // No part of the drawing.
                continue;
            }
            let role = Role::of(id, &self.contents.palette).ok_or_else(|| not_ours(*group))?;
            if last.is_some_and(|last| last >= role) {
                return Err(invalid(format!("the layer {id} stands twice in it, or after layers that lie over it")));
            }
            match (last, role) {
                (Some(Role::Layer(before)), Role::Layer(kind)) if (before.level == 0) != (kind.level == 0) => {
                    return Err(invalid(format!("the layer {id} is of another style than those before it")));
                }
                (_, Role::Layer(kind)) => self.layer(*group, kind)?,
                _ => self.ground(*group, role, page)?,
            }
            last = Some(role);
        }
        Ok(())
    }

    /// Reads the rectangle of the paper or the underlay.
    fn ground(&mut self, group: Node<'_, '_>, role: Role, page: [f64; 4]) -> Result<()> {
        check_attributes(group, &["fill"])?;
        let rgb = colour(group, "fill")?;
        let mut children = drawn_children(group);
        let rectangle = children.next().filter(|node| is_svg(*node, "rect"));
        let rectangle = rectangle.ok_or_else(|| invalid(format!("{} holds no rectangle", Named(group))))?;
        if let Some(other) = children.next() {
            return Err(not_ours(other));
        }
        check_attributes(rectangle, &["x", "y", "width", "height"])?;
        check_leaf(rectangle)?;
        let [left, top, width, height] = ["x", "y", "width", "height"].map(|name| coordinate(rectangle, name));
        let (left, top) = (left?, top?);
        let sides = [left, top, left + width?, top + height?];
        let is_at = |others: [f64; 4]| sides.iter().zip(others).all(|(a, b)| (a - b).abs() <= 2.0 * SLACK);
        let is_on_canvas = is_at([0.0, 0.0, self.contents.width as f64, self.contents.height as f64]);
        if role == Role::Underlay {
            if rgb != BLACK || !is_on_canvas {
                return Err(invalid("its underlay is not black over all of the canvas"));
            }
            self.is_twice = true;
        } else {
            if !is_on_canvas && !is_at(page) {
                return Err(invalid("its paper covers neither the canvas nor the page"));
            }
            self.paper = Some(rgb);
        }
        Ok(())
    }

    fn layer(&mut self, group: Node<'_, '_>, kind: Kind) -> Result<()> {
        let palette = &self.contents.palette;
        let is_plain = palette.is_black_and_white();
        let known = ["transform", "fill", "stroke", "stroke-linecap", "style"];
        check_attributes(group, if palette.overprint() { &known } else { &known[..4] })?;
        if palette.overprint() && !group.attribute("style").is_some_and(multiplies) {
            return Err(other_value(group, "style"));
        }
        let has_strokes = kind.is_dots && group.has_attribute("stroke");
        let units = if has_strokes { FINER * self.contents.units } else { self.contents.units };
        let scale = group.attribute("transform").and_then(|text| text.strip_prefix("scale(")?.strip_suffix(')'));
        if scale.and_then(number).is_none_or(|scale| scale * units != 1.0) {
            return Err(other_value(group, "transform"));
        }
        let expected = match (kind.ink, kind.level) {
            _ if !is_plain => {
                let rgb = palette.of_plate(kind.ink.index()).inks()[0].rgb;
                if palette.overprint() && self.paper.is_some() { palette.multiplied(rgb) } else { rgb }
            }
            (Ink::BLACK, _) => BLACK,
            (_, 0) => WHITE,
            (_, _) => self.paper.unwrap_or(WHITE),
        };
        let as_it_is = |name: &str, value: Option<&str>| {
            if group.attribute(name) == value { Ok(()) } else { Err(other_value(group, name)) }
        };
        as_it_is("stroke-linecap", has_strokes.then_some("round"))?;
        if has_strokes {
            as_it_is("fill", Some("none"))?;
        } else {
            as_it_is("stroke", None)?;
        }
        let painted = if has_strokes { "stroke" } else { "fill" };
        if colour(group, painted)? != expected {
            return Err(other_value(group, painted));
        }

        let is_flat = kind.level == 0 && is_plain;
        let is_again = is_flat && kind.ink == Ink::WHITE && self.has_black;
        self.has_black |= is_flat && kind.ink == Ink::BLACK;
        self.is_twice |= is_again;
        let contents = if is_again { &mut self.again } else { &mut self.contents };
        let mut into = Into { contents, outlines: self.outlines.as_mut(), area: 0.0 };
        let id = group.attribute("id").unwrap_or_default();
        let layer = format!("the layer {id}");
        let mut is_in_layer = false;
        for node in drawn_children(group) {
            check_leaf(node)?;
            if let Some(id) = node.attribute("id") {
                into.contents.sources.enter(format!("the element {}", quoted(id)));
                is_in_layer = false;
            } else if !is_in_layer {
                into.contents.sources.enter(layer.clone());
                is_in_layer = true;
            }
            if is_svg(node, "circle") && kind.is_dots && !has_strokes {
                check_attributes(node, &["cx", "cy", "r"])?;
                let [x, y, radius] = ["cx", "cy", "r"].map(|name| coordinate(node, name));
                let dot = circle(x?, y?, radius?, into.contents.units, true);
                into.take(dot, kind);
            } else if is_svg(node, "path") {
                into.path(node, kind, has_strokes)?;
            } else {
                return Err(not_ours(node));
            }
        }
        self.shown.layers.push((id.to_owned(), into.area));
        self.shown.is_layered |= kind.level > 0;
        Ok(())
    }

    /// What was read and what it shows, if all that was said twice is the same.
    fn finish(mut self) -> Result<(Contents, Shown)> {
        if let Some(outlines) = self.outlines {
            outlines.into_contents(&mut self.contents)?;
        }
        if self.has_black && self.is_twice && marks(&self.contents) != marks(&self.again) {
            return Err(invalid("its white layers are not what the black ones leave"));
        }
        Ok((self.contents, Shown { paper: self.paper, is_twice: self.is_twice, ..self.shown }))
    }
}

/// What a file shows, to be compared with what its drawing would.
#[derive(Default)]
struct Shown {
    /// Ids and areas of the layers, in px^2.
    layers: Vec<(String, f64)>,
    is_layered: bool,
    /// Of other inks than black and white, those that it is drawn with.
    only: Only,
    paper: Option<[u8; 3]>,
    is_twice: bool,
}

/// How far the area of a layer may be from that of the drawing's, as a part of the canvas: sums have other orders.
const AREA_LEFT: f64 = 1e-9;

impl Shown {
    /// Checks that the layers and the paper are those of the drawing: what lies along the frame, and what is left out, is told by no
    /// curve.
    fn check(&self, drawing: &Drawing) -> Result<()> {
        let any = |begin: &str| self.layers.iter().any(|(id, _)| id.starts_with(begin));
        let style = if self.is_layered { Style::Layered } else { Style::Flat };
        let is_plain = drawing.palette.is_black_and_white();
        let only = match (any("black"), any("white")) {
            _ if !is_plain => self.only.clone(),
            (false, true) if !self.is_twice => Only::named(&["white"]),
            (true, false) if !self.is_twice => Only::default(),
            _ => Only::named(&["black", "white"]),
        };
        if self.layers.is_empty() && is_plain {
            // Nothing is on the canvas, so the paper alone is seen.
            let ground = if self.paper == Some(BLACK) { Ink::BLACK } else { Ink::WHITE };
            let is_seen = drawing.regions.iter().all(|region| region.ink == ground);
            return if is_seen { Ok(()) } else { Err(invalid("its paper is not the ink of a canvas with nothing on it")) };
        }
        let expected = drawing.layers(style, &only, None)?;
        if self.paper.is_none() && expected.grounds.iter().any(|ground| ground.id == "paper") {
            return Err(invalid("it has no paper, which its layers need under them"));
        }
        let canvas = (drawing.width * drawing.height) as f64;
        let mut told = self.layers.iter();
        for layer in &expected.layers {
            let area: f64 = layer.areas.iter().map(Area::area).sum();
            match told.next() {
                Some((id, shown)) if *id == layer.id && (shown - area).abs() <= AREA_LEFT * canvas => {}
                Some((id, shown)) if *id == layer.id => {
                    let what = format!("the layer {id} covers {shown:.1} px^2, but what its curves bound has {area:.1}");
                    return Err(invalid(what));
                }
                _ => return Err(invalid(format!("the layer {} is missing", layer.id))),
            }
        }
        told.next().map_or(Ok(()), |(id, _)| Err(invalid(format!("the layer {id} has nothing that its curves bound"))))
    }
}

/// A colour in an attribute; what is missing is black.
fn colour(node: Node<'_, '_>, attribute: &str) -> Result<[u8; 3]> {
    let Some(value) = node.attribute(attribute) else { return Ok(BLACK) };
    value.parse().map(|colour: Color| colour.rgb()).map_err(|_| other_value(node, attribute))
}

/// The inks and the paper as they are told, and which of them the file is drawn with, where it is not all inks.
fn inks(about: Node<'_, '_>) -> Result<(Palette, Only)> {
    let Some(inks) = about.attribute("inks") else { return Ok((Palette::default(), Only::default())) };
    let overprint = match about.attribute("overprint") {
        None => false,
        Some("true") => true,
        Some(other) => return Err(invalid(format!("its overprint is \"{}\", but it must be \"true\"", quoted(other)))),
    };
    let paper = about.attribute("paper").unwrap_or_default().to_owned();
    let written = WrittenPalette { inks: inks.split(',').map(str::to_owned).collect(), paper, overprint };
    let palette = Palette::try_from(written).map_err(invalid)?;
    let names: Vec<&str> = about.attribute("only").map_or_else(Vec::new, |names| names.split(',').collect());
    let only = Only::named(&names);
    only.of(&palette).map_err(invalid)?;
    Ok((palette, only))
}

/// Where outlines of a layer are taken up.
struct Into<'a> {
    contents: &'a mut Contents,
    outlines: Option<&'a mut Outlines>,
    /// The area of those that were.
    area: f64,
}

impl Into<'_> {
    /// Reads the data of a path of a layer.
    fn path(&mut self, node: Node<'_, '_>, kind: Kind, has_strokes: bool) -> Result<()> {
        let data = node.attribute("d").unwrap_or_default();
        let units = self.contents.units;
        let read = if has_strokes {
            check_attributes(node, &["d", "stroke-width"])?;
            let width = coordinate(node, "stroke-width")?;
            PathReader::new(data, FINER * units).strokes(0.5 * width, |dot| self.take(dot, kind))
        } else {
            check_attributes(node, &["d"])?;
            PathReader::new(data, units).outlines(|outline| self.take(outline, kind))
        };
        read.map_err(|byte| invalid(format!("the path data of {} in line {} are others at byte {byte}", Named(node), line(node))))
    }

    /// Takes up an outline of a layer and its area, if one of its kind can be there: a dot, a ring, or in a flat region a dot as a hole.
    fn take(&mut self, outline: Subpath, kind: Kind) -> bool {
        let is_possible = match outline {
            Subpath::Circle { is_exterior, .. } => is_exterior == kind.is_dots && (is_exterior || kind.level == 0),
            Subpath::Ring(_) => !kind.is_dots,
        };
        if is_possible {
            self.area += outline.area();
            let contents = &mut *self.contents;
            contents.sources.begin(contents.curves.len(), contents.stipples.len());
            match &mut self.outlines {
                None => contents.add(outline, kind.ink),
                Some(outlines) => {
                    outlines.add(outline, OfLayer { number: kind.ink.index(), level: kind.level }, contents.units);
                }
            }
        }
        is_possible
    }
}

/// All curves and dots as numbers, in an order that does not depend on that in the file.
fn marks(contents: &Contents) -> (Vec<Vec<u64>>, Vec<[u64; 3]>) {
    // Not -0.
    let bits = |value: f64| (value + 0.0).to_bits();
    let of_element = |element: &PathEl| -> Vec<u64> {
        let points = match *element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![p],
            PathEl::QuadTo(a, p) => vec![a, p],
            PathEl::CurveTo(a, b, p) => vec![a, b, p],
            PathEl::ClosePath => vec![],
        };
        std::iter::once(points.len() as u64).chain(points.into_iter().flat_map(|p| [bits(p.x), bits(p.y)])).collect()
    };
    let of_curve = |curve: &BezPath| curve.elements().iter().flat_map(of_element).collect();
    let mut curves: Vec<Vec<u64>> = contents.curves.iter().map(of_curve).collect();
    let mut dots: Vec<[u64; 3]> = contents.stipples.iter().map(|dot| [dot.x, dot.y, dot.radius].map(bits)).collect();
    curves.sort_unstable();
    dots.sort_unstable();
    (curves, dots)
}

#[cfg(test)]
mod tests {
    use kurbo::Point;

    use super::*;
    use crate::files::export::{Dots, Elements, Export};
    use crate::files::svg::{samples, to_svg};
    use crate::outlines::Stipple;

    fn read(svg: &[u8]) -> Result<Drawing> {
        from_svg(svg, &Control::new())
    }

    /// A drawing whose every number is on its grid.
    fn drawing() -> Drawing {
        let mut sample = samples::nested();
        // It lies on the frame there.
        sample.stipples[1].x = 58.0;
        for dot in &mut sample.stipples {
            *dot = Stipple { level: dot.level, ..Stipple::on_grid(Point::new(dot.x, dot.y), dot.radius, 16.0, dot.ink) };
        }
        let on_grid = |p: Point| Point::new((p.x * 16.0).round() / 16.0, (p.y * 16.0).round() / 16.0);
        let snapped = |element: PathEl| match element {
            PathEl::MoveTo(p) => PathEl::MoveTo(on_grid(p)),
            PathEl::QuadTo(control, p) => PathEl::QuadTo(on_grid(control), on_grid(p)),
            other => other,
        };
        for curve in &mut sample.curves {
            *curve = curve.iter().map(snapped).collect();
        }
        // Its curves and dots, put together as they are from a file.
        read(to_svg(&sample, &layered()).unwrap().as_bytes()).unwrap()
    }

    fn told(svg: &str) -> String {
        let message = read(svg.as_bytes()).unwrap_err().to_string();
        let expected = "this is not a drawing that graphstipple wrote: ";
        message.strip_prefix(expected).unwrap_or_else(|| panic!("{message}")).to_owned()
    }

    /// What is said of a file in which the first of something is replaced.
    fn changed(export: &Export, from: &str, to: &str) -> String {
        let svg = to_svg(&drawing(), export).unwrap();
        assert!(svg.contains(from), "no {from} in {svg}");
        told(&svg.replacen(from, to, 1))
    }

    fn marks() -> Export {
        Export { elements: Elements::Marks, ..Export::default() }
    }

    fn both() -> Export {
        Export { only: Only::named(&["black", "white"]), ..Export::default() }
    }

    fn layered() -> Export {
        Export { style: Style::Layered, ..Export::default() }
    }

    #[test]
    fn every_way_of_writing_gives_the_drawing_back() {
        let drawing = drawing();
        for export in [Export::default(), Export { only: Only::named(&["white"]), ..Export::default() }, both(), layered()] {
            for elements in [Elements::Layers, Elements::Marks] {
                for paper in [None, Some("#1af".parse().unwrap()), Some("#0a0a0a".parse().unwrap())] {
                    let mut export = Export { elements, paper, ..export.clone() };
                    export.layout.margin = "7.3px".parse().unwrap();
                    let svg = to_svg(&drawing, &export).unwrap();
                    assert_eq!(read(svg.as_bytes()).unwrap(), drawing, "{export:?}");
                }
            }
            let strokes = Export { dots: Dots::Strokes, ..export };
            let svg = to_svg(&drawing, &strokes).unwrap();
            let rounded = read(svg.as_bytes()).unwrap();
            assert_eq!(to_svg(&rounded, &strokes).unwrap(), svg);
            assert_eq!(read(to_svg(&rounded, &Export::default()).unwrap().as_bytes()).unwrap(), rounded);
        }
    }

    #[test]
    fn what_draws_nothing_is_passed_over() {
        let drawing = drawing();
        let svg = to_svg(&drawing, &marks()).unwrap();
        let editors = "<defs id=\"defs1\"/><sodipodi:namedview xmlns:sodipodi=\"urn:s\" pagecolor=\"#fff\"/><!-- a comment -->\
                       <title>A drawing</title><g id=\"black-regions\" sodipodi:insensitive=\"true\" style=\"display:inline\" \
                       xmlns:sodipodi=\"urn:s\"";
        let edited = svg.replacen("<g id=\"black-regions\"", editors, 1);
        let edited = edited.replacen("<circle ", "<circle xmlns:i=\"urn:i\" i:label=\"a dot\" ", 1);
        assert_ne!(edited, svg);
        assert_eq!(read(edited.as_bytes()).unwrap(), drawing);
        let with_style = svg.replacen("viewBox", "style=\"background:#fff\" viewBox", 1);
        assert_eq!(read(with_style.as_bytes()).unwrap(), drawing);
    }

    #[test]
    fn other_elements_are_refused_by_name() {
        let end = "</svg>";
        let at_end = |element: &str| changed(&Export::default(), end, &format!("{element}{end}"));
        for name in ["text", "image", "use", "path", "circle", "style", "script", "svg", "a", "switch"] {
            let line = to_svg(&drawing(), &Export::default()).unwrap().lines().count();
            assert_eq!(at_end(&format!("<{name}/>")), format!("the element <{name}> in line {line} is none of its own"));
        }
        assert!(at_end("<g id=\"mine\"/>").starts_with("the element <g id=\"mine\"> in line "));
        assert!(at_end("<defs><style>path{fill:red}</style></defs>").starts_with("the element <style> in line "));
        let in_layer = |element: &str| changed(&marks(), "<circle ", &format!("{element}<circle "));
        for element in ["<text/>", "<g/>", "<rect/>", "<image/>"] {
            assert!(in_layer(element).contains(&format!("{} in line ", element.replace('/', ""))));
        }
        assert!(changed(&marks(), "<path ", "<circle r=\"1\"/><path ").contains("the element <circle> in line "));
        let animated = changed(&marks(), "r=\"8\"/>", "r=\"8\"><animate/></circle>");
        assert!(animated.starts_with("the element <animate> in line "), "{animated}");
        assert!(changed(&Export::default(), "<svg", "<?xml-stylesheet href=\"a.css\"?><svg").contains("xml-stylesheet"));
        let hostile = at_end(&format!("<text id=\"{}\u{9b}\"/>", "x".repeat(5000)));
        assert!(hostile.len() < 200 && !hostile.contains('\u{9b}'));
    }

    #[test]
    fn other_attributes_are_refused() {
        for attribute in ["display=\"none\"", "style=\"opacity:.5\"", "clip-path=\"url(#a)\"", "class=\"a\"", "stroke-width=\"1\""]
        {
            let name = attribute.split('=').next().unwrap();
            let rule = format!("has an attribute {name} that may change how it looks");
            for (export, element) in [(marks(), "<path"), (marks(), "<circle"), (marks(), "<g"), (layered(), "<rect")] {
                let message = changed(&export, &format!("{element} "), &format!("{element} {attribute} "));
                assert!(message.ends_with(&rule) && message.starts_with(&format!("the element {element}")), "{message}");
            }
        }
        assert!(changed(&marks(), "<path", "<path transform=\"scale(2)\"").contains("an attribute transform"));
        assert!(changed(&marks(), "<svg", "<svg transform=\"scale(2)\"").contains("an attribute transform"));
        assert!(
            changed(&marks(), "<svg", "<svg style=\"background:red;opacity:0\"")
                .contains("the attribute style of the element <svg>")
        );
    }

    #[test]
    fn contradictions_are_refused() {
        let plain = Export::default();
        let layer = "of the element <g id=\"black-regions\">";
        assert_eq!(
            changed(&plain, "scale(.0625)", "scale(.125)"),
            format!("the attribute transform {layer} is \"scale(.125)\", which is not what it would be")
        );
        assert!(changed(&plain, "units=\"16\"", "units=\"8\"").starts_with(&format!("the attribute transform {layer}")));
        assert!(changed(&plain, " transform=", " fill=\"#fff\" transform=").starts_with(&format!("the attribute fill {layer}")));
        assert!(changed(&layered(), "regions\" fill=\"#fff\"", "regions\" fill=\"#eee\"").starts_with("the attribute fill of"));
        assert_eq!(
            changed(&layered(), "<rect width=\"64\"", "<rect width=\"32\""),
            "its paper covers neither the canvas nor the page"
        );
        assert_eq!(
            changed(&both(), "<rect width=\"64\"", "<rect width=\"32\""),
            "its underlay is not black over all of the canvas"
        );
        assert!(changed(&plain, "viewBox=\"0 0 64 48\"", "viewBox=\"0 0 32 48\"").starts_with("its viewBox does not show"));
        assert!(changed(&plain, "viewBox=\"0 0 64 48\"", "viewBox=\"0 0 nan 48\"").starts_with("its viewBox is not four numbers"));
        assert!(
            changed(&plain, "width=\"64\" height=\"48\" units", "width=\"64.5\" height=\"48\" units")
                .contains("does not say the width")
        );
        assert!(changed(&plain, "black-stipples", "black-regions").starts_with("the layer black-regions stands twice in it"));
        assert!(changed(&plain, "black-stipples", "level-1-black-stipples").contains("is of another style than those before it"));
        assert!(changed(&layered(), "level-2-white", "level-3-white").starts_with("the element <g id=\"level-3-white-regions\">"));
        // A dot of the white layers alone moves, or goes.
        let drawing = to_svg(&drawing(), &Export { elements: Elements::Marks, ..both() }).unwrap();
        let white = drawing.split("<g id=\"white-regions\"").nth(1).unwrap();
        for to in ["m1 1h2v3z", ""] {
            let circle = &white[white.find(" d=\"").unwrap() + 4..];
            let data = circle.split('"').next().unwrap();
            let expected = "its white layers are not what the black ones leave";
            assert_eq!(told(&drawing.replacen(data, to, 1)), expected);
        }
    }

    /// A file without the groups whose ids begin so.
    fn without(export: &Export, begin: &str) -> String {
        let svg = to_svg(&drawing(), export).unwrap();
        let mut groups = svg.split("<g id=\"").map(str::to_owned);
        let head = groups.next().unwrap();
        let left: Vec<String> = groups.filter(|group| !group.starts_with(begin)).map(|group| format!("<g id=\"{group}")).collect();
        let end = if left.last().is_some_and(|group| group.ends_with("</svg>\n")) { "" } else { "</svg>\n" };
        format!("{head}{}{end}", left.concat())
    }

    #[test]
    fn what_a_file_shows_is_what_its_curves_bound() {
        let white = Export { only: Only::named(&["white"]), ..Export::default() };
        let needed = "it has no paper, which its layers need under them";
        assert_eq!([&white, &layered()].map(|export| told(&without(export, "paper"))), [needed; 2]);
        // Black is seen, and nothing says that the canvas is.
        assert_eq!(told(&without(&white, "white")), "its paper is not the ink of a canvas with nothing on it");
    }

    #[test]
    fn malformed_numbers_and_shapes_of_the_wrong_kind_are_refused() {
        for wrong in ["nan", "1e999", "inf", "+1", "0x1", &"1".repeat(41)] {
            let message = changed(&marks(), "cx=\"768\"", &format!("cx=\"{wrong}\""));
            assert!(message.starts_with("the attribute cx of the element <circle id=\"black-stipple-"), "{message}");
        }
        let ring = changed(
            &Export::default(),
            "stipples\" transform=\"scale(.0625)\">\n<path d=\"",
            "stipples\" transform=\"scale(.0625)\">\n<path d=\"m1 1h1v1z",
        );
        assert!(
            ring.starts_with("the path data of the element <path> in line ") && ring.ends_with(" are others at byte 9"),
            "{ring}"
        );
        let dot = changed(&Export::default(), "<path d=\"", "<path d=\"m1 9a3 3 0 1 1 6 0 3 3 0 1 1-6 0z");
        assert!(dot.ends_with(" are others at byte 33"), "{dot}");
    }

    #[test]
    fn deep_and_doubled_files_end_in_a_sentence() {
        let svg = to_svg(&drawing(), &Export::default()).unwrap();
        let deep = svg.replacen("</svg>", &format!("{}{}</svg>", "<g>".repeat(200_000), "</g>".repeat(200_000)), 1);
        assert!(!told(&deep).is_empty());
        let declared = format!("<!DOCTYPE svg [<!ENTITY a \"b\">]>{svg}");
        assert!(!told(&declared).is_empty());
    }
}
