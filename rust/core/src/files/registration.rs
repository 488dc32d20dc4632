//! Registration marks: targets in the margins, at the same place on every plate, by which plates are laid over each other. In: the size of
//! the drawing; out: a circle with a cross in it beside the middle of each side.

use kurbo::BezPath;

use crate::files::layers::{Area, Outline};

/// The least margin with registration marks, in mm: the mark, and paper on both sides of it.
pub(super) const LEAST_MARGIN: f64 = 10.0;

/// From the drawing's edge to the middle of a mark.
const APART: f64 = 5.0;

/// Radius of the circle, to the middle of its line.
const RADIUS: f64 = 2.5;

/// Half the length of the cross's lines.
const REACH: f64 = 4.0;

/// Half the width of all lines: a line that screens hold.
const HALF_LINE: f64 = 0.1;

/// Steps to a unit that numbers of marks are rounded to, for short files.
const STEPS: f64 = 256.0;

fn rounded(value: f64) -> f64 {
    (value * STEPS).round() / STEPS
}

/// The marks around a drawing of this size, given in the same units as the drawing, of which `mm` make a millimetre. Circle and cross
/// lie over each other.
pub(super) fn marks(size: [f64; 2], mm: f64) -> Vec<Area> {
    let [width, height] = size;
    let apart = APART * mm;
    let middles = [[width / 2.0, -apart], [width + apart, height / 2.0], [width / 2.0, height + apart], [-apart, height / 2.0]];
    middles.into_iter().flat_map(|middle| [circle(middle, mm), cross(middle, mm)]).collect()
}

fn circle([x, y]: [f64; 2], mm: f64) -> Area {
    let of = |radius: f64| Outline::Circle { x: rounded(x), y: rounded(y), radius: rounded(radius * mm) };
    Area { mark: None, exterior: of(RADIUS + HALF_LINE), holes: vec![of(RADIUS - HALF_LINE)] }
}

fn cross([x, y]: [f64; 2], mm: f64) -> Area {
    let (far, near) = (REACH * mm, HALF_LINE * mm);
    // An arm to the right, and the same turned by a quarter three times.
    let mut path = BezPath::new();
    for turn in 0..4 {
        for (u, v) in [(far, -near), (far, near)] {
            let (u, v) = match turn {
                0 => (u, v),
                1 => (-v, u),
                2 => (-u, -v),
                _ => (v, -u),
            };
            let corner = (rounded(x + u), rounded(y + v));
            if path.elements().is_empty() { path.move_to(corner) } else { path.line_to(corner) }
        }
        let (u, v) = [(near, near), (-near, near), (-near, -near), (near, -near)][turn];
        path.line_to((rounded(x + u), rounded(y + v)));
    }
    path.close_path();
    Area { mark: None, exterior: Outline::Path(path), holes: Vec::new() }
}
