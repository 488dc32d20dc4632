//! Areas moved in and out: polygons in a few bytes a point, so that they touch and cross themselves and each other, are needles and
//! lines, and lie far out or in a speck.
#![no_main]

use fuzz::{Counting, examine_areas, prepare};
use graphstipple_core::stages::Polygon;
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

/// How large the grid of the points is, in mm to the step: a speck, a pen's width, a sheet, a house, and further than any machine goes.
const STEPS: [f64; 8] = [1e-6, 1e-3, 0.01, 0.1, 0.25, 1.0, 300.0, 1e7];

const TOLERANCES: [f64; 4] = [0.01, 0.001, 0.03, 0.1];

fuzz_target!(|data: &[u8]| {
    prepare();
    let [kind, by, shift, points @ ..] = data else { return };
    let step = STEPS[usize::from(kind & 7)];
    let tolerance = TOLERANCES[usize::from(kind >> 3 & 3)];
    // From a few steps of the grid of whole numbers up to where arcs have hundreds of points.
    let distance = step.clamp(0.01, 1.0) * (0.02 + f64::from(*by) / 16.0);
    let shift = if kind & 0x80 == 0 { 0.0 } else { step * 1000.0 * f64::from(*shift) };
    examine_areas(&polygons(points, step, shift), distance, tolerance);
});

/// Polygons of the bytes: a byte that says how many points a ring has, and whether it is a hole, then two bytes a point.
fn polygons(bytes: &[u8], step: f64, shift: f64) -> Vec<Polygon> {
    let (mut polygons, mut rest) = (Vec::<Polygon>::new(), bytes);
    while let [kind, following @ ..] = rest {
        let count = (usize::from(kind & 0x3f)).min(following.len() / 2);
        let (points, after) = following.split_at(2 * count);
        rest = after;
        // Every fourth point is a little beside the grid.
        let beside = |at: usize| if kind & 0x40 != 0 && at.is_multiple_of(4) { 0.3e-4 } else { 0.0 };
        let place = |(at, pair): (usize, &[u8])| [0, 1].map(|axis| shift + step * (f64::from(pair[axis]) + beside(at)));
        let ring: Vec<[f64; 2]> = points.chunks(2).enumerate().map(place).collect();
        match polygons.last_mut().filter(|_| kind & 0x80 != 0) {
            Some(polygon) => polygon.push(ring),
            None => polygons.push(vec![ring]),
        }
    }
    polygons
}
