//! What the layers of several inks tell together. In: their outlines, each of a layer; out: the curves between places and the dots,
//! with what is known of the inks beside them.
//!
//! # The idea
//! Every layer has the outlines of its own areas, with these on their left. So a boundary stands in the layers of both its sides, once
//! in each direction; of inks over each other, once in the layer of every ink that ends there. Pieces of outlines are found again by
//! their points, and a curve of the drawing is a run of pieces that stand in the same layers: where these change, there is a junction.
//! What no layer tells, as which inks go on across a curve, or what is around marks in the layered way, is for
//! [`crate::drawing::put_together`] to find out.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use kurbo::{BezPath, PathEl, Point};

use crate::base::{Ink, Palette, Result};
use crate::drawing::{Known, invalid};
use crate::files::load::{Contents, Piece, Subpath, cut_at_frame, open_curve, pieces, settled, settled_dot};
use crate::outlines::Stipple;

/// A layer, by the number of its ink, one behind the last for the paper; and its level, 0 in a flat drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OfLayer {
    pub(super) number: usize,
    pub(super) level: u32,
}

/// An outline of a layer.
struct Outline {
    layer: OfLayer,
    line: Outlined,
}

enum Outlined {
    /// A ring, its pieces in order.
    Ring(BezPath, Vec<Piece>),
    Dot {
        dot: Stipple,
        is_exterior: bool,
    },
}

/// The layers in which something stands, as bits: those that have it on their left, and those that have it on their right.
type Standing = [u16; 2];

type OfPieces = HashMap<PieceKey, Standing>;

/// By their places and radii.
type OfDots = HashMap<[u64; 3], Standing>;

/// All outlines of a file.
pub(super) struct Outlines {
    palette: Palette,
    /// The numbers of the inks, and the paper, that the file is drawn with.
    drawn: Vec<usize>,
    all: Vec<Outline>,
}

impl Outlines {
    pub(super) fn new(palette: Palette, drawn: Vec<usize>) -> Self {
        Self { palette, drawn, all: Vec::new() }
    }

    /// Whether layers of these inks tell the drawing: all of its inks, of a drawing without inks over each other all or all but one of
    /// inks and paper.
    pub(super) fn are_enough(&self) -> bool {
        let inks = self.palette.inks().len();
        (0..inks).all(|ink| self.drawn.contains(&ink)) || !self.palette.overprint() && self.drawn.len() == inks
    }

    /// Takes up an outline of a layer.
    pub(super) fn add(&mut self, subpath: Subpath, layer: OfLayer, units: f64) {
        let line = match subpath {
            Subpath::Circle { x, y, radius, is_exterior } => {
                let dot = Stipple { x, y, radius, ink: self.palette.paper_label(), level: 0 };
                Outlined::Dot { dot: settled_dot(dot, units), is_exterior }
            }
            Subpath::Ring(ring) => {
                let ring = settled(&ring);
                let pieces = pieces(&ring);
                Outlined::Ring(ring, pieces)
            }
        };
        self.all.push(Outline { layer, line });
    }

    /// The curves and dots of all outlines, into contents, which know where these stand.
    ///
    /// # Errors
    /// [`crate::Error::Input`] for an outline that contradicts another one.
    pub(super) fn into_contents(mut self, contents: &mut Contents) -> Result<()> {
        let (pieces, dots) = self.standings(contents)?;
        let seen = pieces.values().fold(0, |seen, [left, right]| seen | left | right);
        let canvas = [contents.width as f64, contents.height as f64];
        let mut ground = self.rest().unwrap_or_else(|| self.palette.paper_label());
        for (number, outline) in std::mem::take(&mut self.all).into_iter().enumerate() {
            contents.sources.place(number, contents.curves.len(), contents.stipples.len());
            let refused = |what: &str| invalid(format!("{} {what}", contents.sources.outline(number)));
            let own = 1 << outline.layer.number;
            match outline.line {
                Outlined::Dot { dot, is_exterior } => {
                    let standing @ [exterior, hole] = dots.get(&dot_key(&dot)).copied().unwrap_or_default();
                    if own != lowest(exterior | hole) || is_exterior != (exterior & own != 0) {
                        continue;
                    }
                    let known = self.known(standing).ok_or_else(|| refused("is a dot of no ink"))?;
                    contents.stipples.push(Stipple { ink: known.ink(), ..dot });
                    contents.dots.push(known);
                }
                Outlined::Ring(ring, drawn) => {
                    let standing = |piece: &Piece| {
                        let (key, is_reversed) = piece_key(piece);
                        let [left, right] = pieces.get(&key).copied().unwrap_or_default();
                        if is_reversed { [right, left] } else { [left, right] }
                    };
                    let curves = curves_of(ring, drawn, own, canvas, standing);
                    if curves.is_empty() {
                        ground = self.with_ink(ground, outline.layer.number);
                    }
                    // Once each, by the first of the layers in which they stand.
                    for (curve, beside) in curves.into_iter().filter(|(_, [left, right])| lowest(left | right) == own) {
                        let sides = self.beside(beside, outline.layer).ok_or_else(|| refused("has nothing beside it"))?;
                        contents.sides.push(sides);
                        contents.curves.push(curve);
                    }
                }
            }
        }
        contents.ground = ground;
        if self.palette.overprint() {
            // An ink that ends nowhere is where it is on the canvas.
            let everywhere = Known::of_bits(ground.label(), !(seen as u8));
            for side in contents.sides.as_flattened_mut() {
                *side = side.and(everywhere).unwrap_or(*side);
            }
        }
        Ok(())
    }

    /// In which layers every piece and every dot stands.
    fn standings(&self, contents: &Contents) -> Result<(OfPieces, OfDots)> {
        let (mut pieces, mut dots) = (OfPieces::new(), OfDots::new());
        let canvas = [contents.width as f64, contents.height as f64];
        for (number, outline) in self.all.iter().enumerate() {
            let own = 1u16 << outline.layer.number;
            let stand = |standing: &mut Standing, is_right: bool| {
                let is_twice = standing[usize::from(is_right)] & own != 0;
                standing[usize::from(is_right)] |= own;
                let [left, right] = *standing;
                let most = left.count_ones().max(right.count_ones());
                if is_twice || left & right != 0 || most > 1 && !self.palette.overprint() {
                    let what = "lies on another outline that has the same on the same side";
                    return Err(invalid(format!("{} {what}", contents.sources.outline(number))));
                }
                Ok(())
            };
            match &outline.line {
                Outlined::Dot { dot, is_exterior } => stand(dots.entry(dot_key(dot)).or_default(), !is_exterior)?,
                Outlined::Ring(_, drawn) => {
                    let mut drawn = drawn.clone();
                    let runs = cut_at_frame(&mut drawn, canvas).map(|runs| runs.concat());
                    for piece in runs.as_ref().unwrap_or(&drawn) {
                        let (key, is_reversed) = piece_key(piece);
                        stand(pieces.entry(key).or_default(), is_reversed)?;
                    }
                }
            }
        }
        Ok((pieces, dots))
    }

    /// What is where no layer is; `None` if layers cover all of the canvas.
    fn rest(&self) -> Option<Ink> {
        if self.palette.overprint() {
            return Some(self.palette.paper_label());
        }
        (0..=self.palette.inks().len()).find(|number| !self.drawn.contains(number)).map(|number| Ink::of_label(number as u8))
    }

    /// The label of a place with an ink more.
    fn with_ink(&self, label: Ink, number: usize) -> Ink {
        match self.palette.overprint() {
            true if number == self.palette.inks().len() => label,
            true => Ink::of_label(label.label() & !(1 << number)),
            false => Ink::of_label(number as u8),
        }
    }

    /// What is known of the ink on a side where these layers are, and those end; `None` if nothing is.
    fn known(&self, [here, there]: Standing) -> Option<Known> {
        if !self.palette.overprint() {
            return if here == 0 { self.rest() } else { Some(Ink::of_label(here.trailing_zeros() as u8)) }.map(Known::of);
        }
        // A label tells the missing inks.
        let inks = self.palette.paper_label().label();
        let told = (here | there) as u8 & inks;
        (told != 0).then(|| Known::of_bits(there as u8 & inks, told | !inks))
    }

    /// What is known of the inks on both sides of a curve.
    fn beside(&self, [left, right]: Standing, layer: OfLayer) -> Option<[Known; 2]> {
        // In the layered way, what is around a mark lies one level below.
        if layer.level > 1 && right == 0 {
            return Some([self.known([left, right])?, Known::NOTHING]);
        }
        Some([self.known([left, right])?, self.known([right, left])?])
    }
}

/// The curves of a ring of a layer between junctions and the frame, each with the layers in which it stands; none if it runs along the frame alone.
fn curves_of(
    ring: BezPath,
    mut drawn: Vec<Piece>,
    own: u16,
    canvas: [f64; 2],
    standing: impl Fn(&Piece) -> Standing,
) -> Vec<(BezPath, Standing)> {
    let cut = |run: &[Piece]| -> Vec<(BezPath, Standing)> {
        let parts = run.chunk_by(|a, b| standing(a) == standing(b));
        parts.map(|part| (open_curve(part), standing(&part[0]))).collect()
    };
    if let Some(runs) = cut_at_frame(&mut drawn, canvas) {
        return runs.into_iter().flat_map(cut).collect();
    }
    let changes = |k: &usize| standing(&drawn[*k]) != standing(&drawn[(k + drawn.len() - 1) % drawn.len()]);
    if let Some(first) = (0..drawn.len()).find(changes) {
        drawn.rotate_left(first);
        return cut(&drawn);
    }
    // A ring of nothing is refused later.
    let beside = drawn.first().map_or([own, 0], standing);
    vec![(ring, beside)]
}

fn lowest(layers: u16) -> u16 {
    layers & layers.wrapping_neg()
}

fn bits(p: Point) -> [u64; 2] {
    // Not -0.
    [p.x + 0.0, p.y + 0.0].map(f64::to_bits)
}

fn dot_key(dot: &Stipple) -> [u64; 3] {
    [dot.x + 0.0, dot.y + 0.0, dot.radius].map(f64::to_bits)
}

/// The ends of a piece, and its control points in short.
type PieceKey = ([u64; 2], [u64; 2], u64);

/// The name of a piece in either direction, and whether that is its own or the other one.
fn piece_key((from, element): &Piece) -> (PieceKey, bool) {
    let (mut controls, to) = match *element {
        PathEl::QuadTo(c, p) => ([Some(bits(c)), None], p),
        PathEl::CurveTo(c, d, p) => ([Some(bits(c)), Some(bits(d))], p),
        PathEl::MoveTo(p) | PathEl::LineTo(p) => ([None, None], p),
        PathEl::ClosePath => ([None, None], *from),
    };
    let (mut from, mut to) = (bits(*from), bits(to));
    let is_reversed = (from, controls[0]) > (to, controls[1].or(controls[0]));
    if is_reversed {
        std::mem::swap(&mut from, &mut to);
        if controls[1].is_some() {
            controls.swap(0, 1);
        }
    }
    let mut hasher = DefaultHasher::new();
    controls.hash(&mut hasher);
    ((from, to, hasher.finish()), is_reversed)
}

#[cfg(test)]
mod tests {
    use crate::base::Control;
    use crate::drawing::Drawing;
    use crate::files::export::{Dots, Elements, Export};
    use crate::files::layers::Style;
    use crate::files::load_svg::from_svg;
    use crate::files::svg::to_svg;
    use crate::options::Only;

    use super::*;

    fn read(svg: &str) -> Result<Drawing> {
        from_svg(svg.as_bytes(), &Control::new())
    }

    /// Inks, nodes, seed, and whether inks lie over each other.
    const DRAWINGS: [(usize, usize, u64, bool); 10] = [
        (1, 200, 1, false),
        (2, 300, 2, false),
        (3, 1200, 3, false),
        (6, 1200, 4, false),
        (15, 2500, 5, false),
        (1, 200, 6, true),
        (2, 300, 7, true),
        (3, 1200, 8, true),
        (4, 1500, 9, true),
        (6, 2500, 10, true),
    ];

    fn patches((inks, count, seed, overprint): (usize, usize, u64, bool)) -> Drawing {
        crate::drawing::samples::patches(inks, count, seed, overprint)
    }

    /// These inks alone by their numbers; one behind the last stands for the paper.
    fn only(numbers: impl Iterator<Item = usize>, inks: usize) -> Only {
        let names: Vec<String> = numbers.map(|k| if k == inks { "paper".to_owned() } else { format!("ink-{k}") }).collect();
        Only::named(&names.iter().map(String::as_str).collect::<Vec<_>>())
    }

    #[test]
    fn every_way_of_writing_inks_gives_the_drawing_back() {
        for of in DRAWINGS {
            let (drawing, (inks, .., overprint)) = (patches(of), of);
            let mut ways = vec![Export::default(), Export { only: only(0..=inks, inks), ..Export::default() }];
            if !overprint {
                ways.push(Export { style: Style::Layered, ..Export::default() });
                ways.extend([0, inks - 1].map(|left_out| {
                    let only = only((0..=inks).filter(|number| *number != left_out), inks);
                    Export { only, paper: Some("#1af".parse().unwrap()), ..Export::default() }
                }));
            }
            for export in ways {
                for elements in [Elements::Layers, Elements::Marks] {
                    let svg = to_svg(&drawing, &Export { elements, ..export.clone() }).unwrap();
                    assert!(read(&svg).unwrap() == drawing, "{of:?} {export:?}");
                }
                let strokes = Export { dots: Dots::Strokes, ..export };
                let svg = to_svg(&drawing, &strokes).unwrap();
                let rounded = read(&svg).unwrap();
                assert!(to_svg(&rounded, &strokes).unwrap() == svg, "{of:?} {strokes:?}");
            }
        }
    }

    #[test]
    fn what_leaves_inks_out_is_refused_in_one_sentence() {
        for (of, numbers, told) in [
            (DRAWINGS[2], vec![0, 2], "ink-0,ink-2"),
            (DRAWINGS[2], vec![0, 3], "ink-0,paper"),
            (DRAWINGS[7], vec![0, 1, 3], "ink-0,ink-1,paper"),
        ] {
            let export = Export { only: only(numbers.into_iter(), of.0), ..Export::default() };
            let error = read(&to_svg(&patches(of), &export).unwrap()).unwrap_err().to_string();
            let rest = "alone of its inks is not read back: save the drawing with all of them, or as .json";
            assert_eq!(error, format!("an SVG with {told} {rest}"));
        }
    }

    #[test]
    fn a_canvas_of_one_ink_or_none_is_told_by_every_way_of_writing() {
        for overprint in [false, true] {
            for label in 0..=2 {
                let palette = patches((2, 40, 1, overprint)).palette;
                let label = if label == 2 { palette.paper_label() } else { Ink::of_label(label) };
                let parts = crate::outlines::Parts {
                    width: 30,
                    height: 20,
                    units: 16.0,
                    palette,
                    curves: vec![],
                    stipples: vec![],
                    inks: vec![label],
                    on_frame: 0,
                };
                let drawing = crate::drawing::assemble(parts).unwrap();
                for only in [Only::default(), only(0..=2, 2)] {
                    let again = read(&to_svg(&drawing, &Export { only, ..Export::default() }).unwrap()).unwrap();
                    assert_eq!(again.regions, drawing.regions, "{label:?}");
                }
            }
        }
    }

    /// What is said of a file of which something is changed.
    fn told(svg: &str) -> String {
        let message = read(svg).unwrap_err().to_string();
        let expected = "this is not a drawing that graphstipple wrote: ";
        message.strip_prefix(expected).unwrap_or_else(|| panic!("{message}")).to_owned()
    }

    /// The same without the outline of a layer with this number.
    fn without(svg: &str, layer: &str, outline: usize) -> String {
        let begin = svg.find(&format!("<g id=\"{layer}\"")).unwrap();
        let data = begin + svg[begin..].find(" d=\"").unwrap() + 4;
        let length = svg[data..].find('"').unwrap();
        // Every one begins where the one before began, so all that follow move too.
        let outlines: Vec<&str> = svg[data..data + length].split_inclusive('z').collect();
        let left: String = outlines.iter().enumerate().filter(|(k, _)| *k != outline).map(|(_, data)| *data).collect();
        format!("{}{left}{}", &svg[..data], &svg[data + length..])
    }

    #[test]
    fn layers_that_contradict_each_other_are_refused() {
        // With the paper, all of the canvas is told.
        let drawing = patches(DRAWINGS[2]);
        let svg = to_svg(&drawing, &Export { only: only(0..=3, 3), ..Export::default() }).unwrap();
        for layer in ["ink-0-regions", "ink-1-regions", "ink-2-stipples", "paper-regions"] {
            for outline in [0, 1] {
                assert!(!told(&without(&svg, layer, outline)).is_empty());
            }
            let begin = svg.find(&format!("<g id=\"{layer}\"")).unwrap();
            let end = begin + svg[begin..].find("</g>").unwrap() + 4;
            assert!(!told(&format!("{}{}", &svg[..begin], &svg[end..])).is_empty());
            let again = format!("{}{}{}", &svg[..end], &svg[begin..end], &svg[end..]);
            assert_eq!(told(&again), format!("the layer {layer} stands twice in it, or after layers that lie over it"));
        }
        let fill = svg.split("ink-1-regions").nth(1).unwrap().split(" fill=\"").nth(1).unwrap().split('"').next().unwrap();
        assert!(told(&svg.replacen(&format!("fill=\"{fill}\""), "fill=\"#123456\"", 1)).starts_with("the attribute fill of"));
        for (from, to, sentence) in [
            (" only=\"ink-0,ink-1,ink-2,paper\"", "", "the layer paper-regions has nothing that its curves bound"),
            ("only=\"ink-0", "only=\"mauve", "only is mauve,ink-1,ink-2,paper, but it must be inks of the drawing or its paper"),
            ("paper=\"#", "paper=\"", "colour is fafaf0, but it must be"),
            ("inks=\"", "overprint=\"false\" inks=\"", "its overprint is \"false\", but it must be \"true\""),
            ("inks=\"", "overprint=\"true\" inks=\"", "the attribute style of the element <g id=\"ink-0-regions\"> is missing"),
        ] {
            let told = told(&svg.replacen(from, to, 1));
            assert!(told.starts_with(sentence), "{told}");
        }
    }
}
