//! Reading drawings back from our own JSON and SVG files.
//!
//! # The idea
//! Whatever the style and the inks, a file holds every boundary curve and every stipple, with black on a known side. What lies
//! beside what is found again from the geometry: next to a curve lies what its nearest neighbour to the left has on its right. Then
//! the drawing is put together as it was when it was made (see [`assemble`](crate::stages::assemble)), and is the same.
//!
//! Of several inks, what lies beside a curve is told by JSON, and by the layers of SVG together (see [`super::load_inks`]).
//!
//! What this module does not do: read files of other programs.

use kurbo::{BezPath, PathEl, Point, Shape as _};

use crate::base::{Control, FINEST_GRID, Ink, Palette, Result, snap};
use crate::drawing::{Drawing, Known, Loose, Provenance, Shape, put_together};
use crate::files::layers::circle_area;
use crate::files::sources::Sources;
use crate::files::write_path::{leftmost, on_dot_grid};
use crate::outlines::Stipple;
use crate::photo::check_size;

/// What is read from a file before it is known what lies beside what.
pub(super) struct Contents {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) units: f64,
    pub(super) palette: Palette,
    /// The lower ink on their left; closed, or from frame or junction to frame or junction.
    pub(super) curves: Vec<BezPath>,
    /// What is known to be on the left and on the right of every curve, of other inks than black and white.
    pub(super) sides: Vec<[Known; 2]>,
    pub(super) stipples: Vec<Stipple>,
    /// What is known of the inks of dots, where it is not all.
    pub(super) dots: Vec<Known>,
    /// Ink of the canvas if there is nothing on it.
    pub(super) ground: Ink,
    pub(super) provenance: Provenance,
    /// Where the curves and dots stand in the file.
    pub(super) sources: Sources,
}

/// A subpath.
pub(super) enum Subpath {
    /// A circle, and whether it runs as exteriors do.
    Circle {
        x: f64,
        y: f64,
        radius: f64,
        is_exterior: bool,
    },
    Ring(BezPath),
}

impl Subpath {
    /// Its area in px^2; of what runs as holes do, below 0.
    pub(super) fn area(&self) -> f64 {
        match self {
            Self::Circle { radius, is_exterior, .. } => circle_area(*radius) * if *is_exterior { 1.0 } else { -1.0 },
            Self::Ring(path) => path.area(),
        }
    }
}

impl Contents {
    /// Takes up a subpath of a layer of the given ink.
    pub(super) fn add(&mut self, subpath: Subpath, ink: Ink) {
        match subpath {
            Subpath::Circle { x, y, radius, is_exterior } => {
                let ink = if is_exterior { ink } else { ink.other() };
                self.stipples.push(Stipple { x, y, radius, ink, level: 0 });
            }
            Subpath::Ring(ring) => {
                let oriented = |curve: BezPath| if ink == Ink::BLACK { curve } else { curve.reverse_subpaths() };
                match cut_at_frame(&mut pieces(&ring), [self.width as f64, self.height as f64]) {
                    None => self.curves.push(oriented(ring)),
                    Some(runs) => {
                        if runs.is_empty() {
                            self.ground = ink;
                        }
                        self.curves.extend(runs.into_iter().map(|run| oriented(open_curve(run))));
                    }
                }
            }
        }
    }
}

/// An element of a path with the point where it begins.
pub(super) type Piece = (Point, PathEl);

/// The lines and curves of a ring, with the line that closes it, and without those of no length.
pub(super) fn pieces(ring: &BezPath) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(ring.elements().len());
    let Some(start) = ring.elements().first().and_then(PathEl::end_point) else { return pieces };
    let drawn = ring.elements()[1..].iter().copied().filter(|element| *element != PathEl::ClosePath);
    let mut at = start;
    for element in drawn.chain([PathEl::LineTo(start)]) {
        let end = element.end_point().unwrap_or(at);
        if end != at || !matches!(element, PathEl::LineTo(_)) {
            pieces.push((at, element));
        }
        at = end;
    }
    pieces
}

/// What a ring is between its runs along the frame of a canvas of this width and height; `None` if it has no such run.
pub(super) fn cut_at_frame(pieces: &mut [Piece], [width, height]: [f64; 2]) -> Option<Vec<&[Piece]>> {
    let on_one_side =
        |p: Point, q: Point| (p.y == q.y && (p.y == 0.0 || p.y == height)) || (p.x == q.x && (p.x == 0.0 || p.x == width));
    let on_frame = |(from, element): &Piece| matches!(element, PathEl::LineTo(to) if on_one_side(*from, *to));
    let first = pieces.iter().position(on_frame)?;
    pieces.rotate_left(first);
    Some(pieces.split(on_frame).filter(|run| !run.is_empty()).collect())
}

/// The open curve of these pieces, of which there is one at least.
pub(super) fn open_curve(run: &[Piece]) -> BezPath {
    let mut curve = BezPath::with_capacity(run.len() + 1);
    curve.move_to(run[0].0);
    run.iter().for_each(|(_, element)| curve.push(*element));
    curve
}

/// The drawing of these curves and dots.
pub(super) fn rebuild(contents: Contents, control: &Control) -> Result<Drawing> {
    let Contents { width, height, units, palette, curves, sides, stipples, dots, ground, provenance, sources } = contents;
    check_size(width, height)?;
    let names = |shape: Shape| match shape {
        Shape::Curve(number) => sources.curve(number),
        Shape::Stipple(number) => sources.stipple(number),
    };
    let curves = curves.into_iter().map(|curve| settled(&curve)).collect();
    let stipples = stipples.into_iter().map(|dot| settled_dot(dot, units)).collect();
    let drawing = put_together(Loose { width, height, units, palette, curves, sides, stipples, dots, ground }, &names, control)?;
    Ok(Drawing { provenance, ..drawing })
}

/// A curve as every file of it gives it back, whoever wrote this one: on a grid, without lines of no length, and if it is closed,
/// back at its begin.
pub(super) fn settled(curve: &BezPath) -> BezPath {
    let on_grid = |p: Point| snap(p, FINEST_GRID);
    let mut settled = BezPath::with_capacity(curve.elements().len() + 1);
    let (mut begin, mut at) = (None, None);
    for element in curve.elements() {
        let element = match *element {
            PathEl::MoveTo(p) => PathEl::MoveTo(on_grid(p)),
            PathEl::LineTo(p) => PathEl::LineTo(on_grid(p)),
            PathEl::QuadTo(c, p) => PathEl::QuadTo(on_grid(c), on_grid(p)),
            PathEl::CurveTo(c, d, p) => PathEl::CurveTo(on_grid(c), on_grid(d), on_grid(p)),
            PathEl::ClosePath => {
                if let (Some(begin), true) = (begin, at != begin) {
                    settled.push(PathEl::LineTo(begin));
                }
                PathEl::ClosePath
            }
        };
        let is_nothing = matches!(element, PathEl::LineTo(p) if at == Some(p));
        if !is_nothing {
            settled.push(element);
        }
        at = element.end_point().or(at);
        begin = begin.or(at);
    }
    settled
}

/// A dot likewise: its leftmost point lies on a grid, as it was when it was made.
pub(super) fn settled_dot(dot: Stipple, units: f64) -> Stipple {
    let radius = dot.radius * units;
    let left = leftmost(dot.x * units, radius);
    Stipple { x: (left + radius) / units, y: on_dot_grid(dot.y * units) / units, ..dot }
}
