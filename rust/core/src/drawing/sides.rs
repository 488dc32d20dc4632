//! What lies beside curves and dots, found again from where they are.
//!
//! Next to a curve lies what its nearest neighbour to the left has on its right; a sweep finds the neighbours (see
//! [`super::sweep`]), and along the frame the ends of open curves are neighbours.

use kurbo::{Point, Shape as _};

use crate::base::{Control, Frame, Ink, Result, is_closed};
use crate::drawing::assembly::{End, assemble, ends_on_frame};
use crate::drawing::data::Drawing;
use crate::drawing::loose::{Loose, Names, Shape, invalid};
use crate::drawing::sweep::Top;
use crate::outlines::Parts;

/// The drawing of curves and dots; its provenance is left empty. `names` says what they are called where they stand.
///
/// # Errors
/// [`crate::Error::Input`] if they are no drawing, [`crate::Error::Cancelled`].
pub(crate) fn put_together(loose: Loose, names: Names, control: &Control) -> Result<Drawing> {
    let tops = loose.check(names, control)?;
    let mut sides = Sides::new(&loose, names)?;
    for top in &tops {
        control.check()?;
        sides.take_up(top)?;
    }
    let (mut inks, ids) = sides.components();
    let beside = |number: usize| [ids[black_side(number)], ids[white_side(number)]];
    let mut stipples = Vec::with_capacity(loose.stipples.len());
    for (number, (dot, around)) in loose.stipples.iter().zip(&sides.around).enumerate() {
        let around = ids[*around];
        if dot.ink == inks[around as usize] {
            let ink = dot.ink.name();
            return Err(invalid(format!("{} is {ink} and lies in {ink}", names(Shape::Stipple(number)))));
        }
        stipples.push((*dot, [inks.len() as u32, around]));
        inks.push(dot.ink);
    }
    let on_frame = ids[sides.ground];
    let Loose { width, height, units, curves, .. } = loose;
    let curves = curves.into_iter().enumerate().map(|(number, curve)| (curve, beside(number))).collect();
    let parts = Parts { width, height, units, curves, stipples, inks, on_frame };
    assemble(parts).map_err(|error| invalid(format!("its shapes do not fit together ({error})")))
}

fn black_side(curve: usize) -> usize {
    2 * curve
}

fn white_side(curve: usize) -> usize {
    2 * curve + 1
}

/// Both sides of every curve, joined where nothing lies between them.
struct Sides<'a> {
    loose: &'a Loose,
    names: Names<'a>,
    frame: Frame,
    /// A forest: every side points to one of its component.
    joined: Vec<usize>,
    inks: Vec<Ink>,
    /// What stands for the canvas where no curve ends on the frame.
    ground: usize,
    ends: Vec<End>,
    /// The side that every dot lies in.
    around: Vec<usize>,
}

impl<'a> Sides<'a> {
    fn new(loose: &'a Loose, names: Names<'a>) -> Result<Self> {
        let ground = 2 * loose.curves.len();
        let mut inks: Vec<Ink> = (0..ground).map(|side| if side % 2 == 0 { Ink::Black } else { Ink::White }).collect();
        inks.push(loose.stipples.first().map_or(loose.ground, |dot| dot.ink.other()));
        let (frame, joined) = (loose.frame(), (0..inks.len()).collect());
        let ends = ends_on_frame(frame, &loose.curves);
        let mut sides = Self { loose, names, frame, joined, inks, ground, ends, around: vec![ground; loose.stipples.len()] };
        for k in 0..sides.ends.len() {
            let next = (k + 1) % sides.ends.len();
            let ([_, after], [before, _]) = (sides.around(k), sides.around(next));
            let curve = Shape::Curve(sides.ends[k].curve as usize);
            sides
                .join(after, before)
                .map_err(|inks| sides.differ(curve, Some(Shape::Curve(sides.ends[next].curve as usize)), inks))?;
        }
        Ok(sides)
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

    /// Makes two sides one, or gives their inks if they differ.
    fn join(&mut self, a: usize, b: usize) -> std::result::Result<(), [Ink; 2]> {
        let (a, b) = (self.root(a), self.root(b));
        // What stands for the canvas has the ink of the first that is found there.
        let stand_in = 2 * self.loose.curves.len();
        if a == stand_in {
            self.inks[a] = self.inks[b];
        }
        if b == stand_in {
            self.inks[b] = self.inks[a];
        }
        if self.inks[a] != self.inks[b] {
            return Err([self.inks[a], self.inks[b]]);
        }
        self.joined[a.max(b)] = a.min(b);
        if a.max(b) == self.ground {
            self.ground = a.min(b);
        }
        Ok(())
    }

    fn differ(&self, shape: Shape, beside: Option<Shape>, [own, other]: [Ink; 2]) -> crate::Error {
        let beside = beside.map_or_else(|| "the edge of the canvas".to_owned(), self.names);
        invalid(format!("{} is {} towards {beside}, which is {} there", (self.names)(shape), own.name(), other.name()))
    }

    /// Takes up what lies beside the top of a curve or a dot. What lies on the left was taken up before.
    fn take_up(&mut self, top: &Top) -> Result<()> {
        let shape = self.loose.shape(top.line);
        let neighbour = top.beside.map(|beside| (self.loose.shape(beside.line), beside.falls));
        let side = match neighbour {
            // What falls has its left, the black side, on the left of who looks at it.
            Some((Shape::Curve(curve), falls)) => {
                if falls {
                    white_side(curve)
                } else {
                    black_side(curve)
                }
            }
            // The polygon of a dot falls on the right.
            Some((Shape::Stipple(dot), true)) => self.around[dot],
            Some((dot, false)) => return Err(invalid(format!("{} lies in {}", (self.names)(shape), (self.names)(dot)))),
            None => self.on_left_of_frame(top.point[1]),
        };
        match shape {
            Shape::Stipple(dot) => self.around[dot] = side,
            Shape::Curve(number) if is_closed(&self.loose.curves[number]) => {
                let area = self.loose.curves[number].area();
                if area == 0.0 || (area > 0.0) != top.turns_left {
                    return Err(invalid(format!("{} encloses nothing", (self.names)(shape))));
                }
                let outer = if top.turns_left { white_side(number) } else { black_side(number) };
                self.join(outer, side).map_err(|inks| self.differ(shape, neighbour.map(|(shape, _)| shape), inks))?;
            }
            // The frame has said it.
            Shape::Curve(_) => {}
        }
        Ok(())
    }

    /// The side that lies at the left of the frame, at a height or just below.
    fn on_left_of_frame(&self, y: f64) -> usize {
        if self.ends.is_empty() {
            return self.ground;
        }
        // The frame runs upwards here.
        let place = self.frame.place(Point::new(0.0, y));
        let behind = self.ends.partition_point(|end| end.place < place);
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
