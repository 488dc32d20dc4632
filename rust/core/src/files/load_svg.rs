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

use crate::base::{Color, Control, Ink, Result, in_one_line};
use crate::drawing::{Drawing, Provenance, invalid};
use crate::files::json::NAMES;
use crate::files::load::{Contents, Subpath, rebuild};
use crate::files::read_path::{PathReader, circle, number};
use crate::files::sources::Sources;
use crate::files::svg::NAMESPACE;
use crate::files::text_of;
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
    rebuild(reader.finish()?, control)
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
    fn of(id: &str) -> Option<Self> {
        match id {
            "paper" => return Some(Self::Paper),
            "underlay" => return Some(Self::Underlay),
            _ => {}
        }
        let (level, name) = match id.strip_prefix("level-") {
            None => (0, id),
            Some(rest) => {
                let (level, name) = rest.split_once('-')?;
                let number: u32 = level.parse().ok().filter(|number| *number > 0)?;
                (number, name)
            }
        };
        let (ink, kind) = name.split_once('-')?;
        let ink = match ink {
            "black" => Ink::Black,
            "white" => Ink::White,
            _ => return None,
        };
        // Black lies on the paper, white on black.
        if level > 0 && level % 2 != u32::from(ink == Ink::Black) {
            return None;
        }
        match kind {
            "regions" => Some(Self::Layer(Kind { level, ink, is_dots: false })),
            "stipples" => Some(Self::Layer(Kind { level, ink, is_dots: true })),
            _ => None,
        }
    }
}

/// A layer as its id tells it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    /// 0 in a flat drawing.
    level: u32,
    ink: Ink,
    is_dots: bool,
}

/// What is read so far.
struct Reader {
    contents: Contents,
    /// What the white layers of a flat drawing with both inks say: the same again.
    again: Contents,
    /// Whether a flat drawing has black, and so whether it is told twice.
    has_black: bool,
    is_twice: bool,
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
        let units = number(value("units")).filter(|units| *units >= 1.0).ok_or_else(|| missing("units"))?;
        let ground = match about.attribute("ground") {
            None => Ink::White,
            Some("black") => Ink::Black,
            Some(_) => return Err(missing("ground")),
        };
        let mut provenance: Provenance = serde_json::from_str(about.text().unwrap_or_default()).map_err(invalid)?;
        // A JSON file has names of its own beside those of the provenance.
        provenance.rest.retain(|name, _| !NAMES.contains(&name.as_str()));
        let empty = |provenance| {
            let (curves, stipples, sources) = (Vec::new(), Vec::new(), Sources::default());
            Contents { width, height, units, curves, stipples, ground, provenance, sources }
        };
        let (contents, again) = (empty(provenance), empty(Provenance::default()));
        Ok(Self { contents, again, has_black: false, is_twice: false, paper: None })
    }

    /// Reads the groups of the root, on a page with these sides.
    fn groups(&mut self, groups: &[Node<'_, '_>], page: [f64; 4]) -> Result<()> {
        let mut last = None;
        for group in groups {
            let id = group.attribute("id").unwrap_or_default();
            let role = Role::of(id).ok_or_else(|| not_ours(*group))?;
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
        check_attributes(group, &["transform", "fill", "stroke", "stroke-linecap"])?;
        let scale = group.attribute("transform").and_then(|text| text.strip_prefix("scale(")?.strip_suffix(')'));
        if scale.and_then(number).is_none_or(|scale| scale * self.contents.units != 1.0) {
            return Err(other_value(group, "transform"));
        }
        let expected = match (kind.ink, kind.level) {
            (Ink::Black, _) => BLACK,
            (Ink::White, 0) => WHITE,
            (Ink::White, _) => self.paper.unwrap_or(WHITE),
        };
        let has_strokes = kind.is_dots && group.has_attribute("stroke");
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

        let is_flat = kind.level == 0;
        let is_again = is_flat && kind.ink == Ink::White && self.has_black;
        self.has_black |= is_flat && kind.ink == Ink::Black;
        self.is_twice |= is_again;
        let contents = if is_again { &mut self.again } else { &mut self.contents };
        let layer = format!("the layer {}", group.attribute("id").unwrap_or_default());
        let mut is_in_layer = false;
        for node in drawn_children(group) {
            check_leaf(node)?;
            if let Some(id) = node.attribute("id") {
                contents.sources.enter(format!("the element {}", quoted(id)));
                is_in_layer = false;
            } else if !is_in_layer {
                contents.sources.enter(layer.clone());
                is_in_layer = true;
            }
            if is_svg(node, "circle") && kind.is_dots && !has_strokes {
                check_attributes(node, &["cx", "cy", "r"])?;
                let [x, y, radius] = ["cx", "cy", "r"].map(|name| coordinate(node, name));
                take(contents, circle(x?, y?, radius?, contents.units, true), kind);
            } else if is_svg(node, "path") {
                path(contents, node, kind, has_strokes)?;
            } else {
                return Err(not_ours(node));
            }
        }
        Ok(())
    }

    /// What was read, if all that was said twice is the same.
    fn finish(self) -> Result<Contents> {
        if self.has_black && self.is_twice && marks(&self.contents) != marks(&self.again) {
            return Err(invalid("its white layers are not what the black ones leave"));
        }
        Ok(self.contents)
    }
}

/// A colour in an attribute; what is missing is black.
fn colour(node: Node<'_, '_>, attribute: &str) -> Result<[u8; 3]> {
    let Some(value) = node.attribute(attribute) else { return Ok(BLACK) };
    value.parse().map(|colour: Color| colour.rgb()).map_err(|_| other_value(node, attribute))
}

/// Reads the data of a path of a layer.
fn path(contents: &mut Contents, node: Node<'_, '_>, kind: Kind, has_strokes: bool) -> Result<()> {
    let data = node.attribute("d").unwrap_or_default();
    let reader = PathReader::new(data, contents.units);
    let read = if has_strokes {
        check_attributes(node, &["d", "stroke-width"])?;
        let width = coordinate(node, "stroke-width")?;
        reader.strokes(0.5 * width, |dot| take(contents, dot, kind))
    } else {
        check_attributes(node, &["d"])?;
        reader.outlines(|outline| take(contents, outline, kind))
    };
    read.map_err(|byte| invalid(format!("the path data of {} in line {} are others at byte {byte}", Named(node), line(node))))
}

/// Takes up an outline of a layer, if one of its kind can be there: a dot, a ring, or in a flat region a dot as a hole.
fn take(contents: &mut Contents, outline: Subpath, kind: Kind) -> bool {
    let is_possible = match outline {
        Subpath::Circle { is_exterior, .. } => is_exterior == kind.is_dots && (is_exterior || kind.level == 0),
        Subpath::Ring(_) => !kind.is_dots,
    };
    if is_possible {
        contents.sources.begin(contents.curves.len(), contents.stipples.len());
        contents.add(outline, kind.ink);
    }
    is_possible
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
