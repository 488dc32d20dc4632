//! Offsets and what is made of them, over the crate `i_overlay`, which works on whole numbers and so does not fail on what is nearly
//! collinear or nearly equal.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::scale::FixedScaleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};

use crate::base::{Error, Result, signed_area};
use crate::offset::needles::without_needles;
use crate::offset::simplify::simplified;

/// An area in mm: its exterior, then its holes.
pub type Polygon = Vec<Vec<[f64; 2]>>;

/// Grid of the whole numbers on sheets of common sizes, to the mm: a sixteenth of a micrometre, so a thousandth of what is simplified.
const FINEST: f64 = (1 << 16) as f64;

/// Whole numbers within which `i_overlay` is safe: 2^29 to either side.
const LARGEST: f64 = (1 << 28) as f64;

/// Units of the grid within which the two sides of a needle lie. `i_overlay` goes back to a corner between the edges that it moves towards
/// one another there. Where they are nearly in one line, rounding may turn that way round, and it is taken for a needle of area. Its
/// sides are two units apart or less.
const NEEDLE: f64 = 4.0;

/// Polygons moved out by `distance` mm, or in by one below 0, corners rounded, rings simplified by `tolerance` mm.
///
/// # Errors
/// [`Error::Input`] if a coordinate or the distance is not finite.
///
/// # Runtime
/// n log n in the number of points, and of those that round corners bring.
pub fn offset(polygons: &[Polygon], distance: f64, tolerance: f64) -> Result<Vec<Polygon>> {
    let Some(scale) = scale(&[polygons], distance)? else { return Ok(Vec::new()) };
    if distance == 0.0 {
        return united(polygons);
    }
    let style = OutlineStyle::new(distance).line_join(LineJoin::Round(step(distance.abs(), tolerance)));
    let moved = polygons.outline_fixed_scale(&style, scale).map_err(|error| failed(&error))?;
    Ok(cleaned(moved, NEEDLE / scale, tolerance))
}

/// The angle of an arc's steps whose chords keep to half the tolerance.
fn step(radius: f64, tolerance: f64) -> f64 {
    2.0 * libm::acos((1.0 - 0.5 * tolerance / radius).clamp(0.7, 1.0))
}

/// What is left of polygons that are moved in by `radius` mm and out again: nothing is narrower than twice the radius, and convex
/// corners are rounded.
///
/// # Errors
/// As [`offset`].
pub fn opened(polygons: &[Polygon], radius: f64, tolerance: f64) -> Result<Vec<Polygon>> {
    offset(&offset(polygons, -radius, tolerance)?, radius, tolerance)
}

/// Polygons moved out by `radius` mm and in again: no gap is narrower than twice the radius, and concave corners are rounded.
///
/// # Errors
/// As [`offset`].
pub fn closed(polygons: &[Polygon], radius: f64, tolerance: f64) -> Result<Vec<Polygon>> {
    offset(&offset(polygons, radius, tolerance)?, -radius, tolerance)
}

/// The area that any of the polygons covers, which may overlap here.
///
/// # Errors
/// [`Error::Input`] if a coordinate is not finite.
pub fn united(polygons: &[Polygon]) -> Result<Vec<Polygon>> {
    overlaid(polygons, &[], OverlayRule::Union)
}

/// What of the first polygons the second do not cover.
///
/// # Errors
/// As [`united`].
pub fn subtracted(from: &[Polygon], these: &[Polygon]) -> Result<Vec<Polygon>> {
    overlaid(from, these, OverlayRule::Difference)
}

/// What both cover.
///
/// # Errors
/// As [`united`].
pub fn intersection(a: &[Polygon], b: &[Polygon]) -> Result<Vec<Polygon>> {
    overlaid(a, b, OverlayRule::Intersect)
}

fn overlaid(a: &[Polygon], b: &[Polygon], rule: OverlayRule) -> Result<Vec<Polygon>> {
    let Some(scale) = scale(&[a, b], 0.0)? else { return Ok(Vec::new()) };
    a.overlay_with_fixed_scale(&b, rule, FillRule::NonZero, scale).map_err(|error| failed(&error))
}

/// Area of polygons in mm^2, their holes taken off.
pub fn area(polygons: &[Polygon]) -> f64 {
    polygons.iter().flatten().map(|ring| signed_area(ring)).sum()
}

/// Units of the grid to the mm that hold all coordinates, moved by so much; `None` if there are none.
fn scale(of: &[&[Polygon]], distance: f64) -> Result<Option<f64>> {
    let points = || of.iter().flat_map(|polygons| polygons.iter().flatten().flatten());
    if points().next().is_none() {
        return Ok(None);
    }
    let most = points().flatten().fold(0.0_f64, |most, value| if value.is_finite() { most.max(value.abs()) } else { f64::NAN });
    let reach = most + distance.abs() * 2.0;
    if !(reach.is_finite() && points().flatten().all(|value| value.is_finite())) {
        return Err(Error::Input("an area has a coordinate that is not finite".to_owned()));
    }
    let fits = libm::exp2(libm::floor(libm::log2(LARGEST / reach.max(f64::MIN_POSITIVE))));
    Ok(Some(fits.min(FINEST)))
}

/// Rings simplified and without needles that are no wider than this, and those left out that come to nothing.
fn cleaned(polygons: Vec<Polygon>, needle: f64, tolerance: f64) -> Vec<Polygon> {
    let clean = |polygon: Polygon| -> Option<Polygon> {
        let mut rings = polygon.into_iter().map(|ring| simplified(&without_needles(ring, needle), tolerance));
        let exterior = rings.next().filter(|ring| !ring.is_empty())?;
        Some(std::iter::once(exterior).chain(rings.filter(|ring| !ring.is_empty())).collect())
    };
    polygons.into_iter().filter_map(clean).collect()
}

fn failed(error: &dyn std::fmt::Debug) -> Error {
    Error::Internal(format!("areas cannot be laid over each other: {error:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(left: f64, top: f64, side: f64) -> Vec<[f64; 2]> {
        vec![[left, top], [left + side, top], [left + side, top + side], [left, top + side]]
    }

    #[test]
    fn a_square_moves_in_and_out() {
        let polygons = [vec![square(0.0, 0.0, 10.0)]];
        assert!((area(&offset(&polygons, -1.0, 0.01).unwrap()) - 64.0).abs() < 1e-3);
        let out = area(&offset(&polygons, 1.0, 0.001).unwrap());
        assert!((out - (140.0 + std::f64::consts::PI)).abs() < 0.02, "{out}");
        assert!(offset(&polygons, -5.1, 0.01).unwrap().is_empty());
    }

    #[test]
    fn nothing_of_what_is_moved_out_goes_back_to_a_corner_that_is_hardly_one() {
        // The third corner lies on the line of its neighbours but for a ten thousandth of a mm.
        let ring = vec![
            [6.8000030517578125, 9.0000015],
            [3.4808502197265625, 4.704637120117187],
            [3.9761962890625, 3.9761977890624998],
            [6.0, 1.0000014999999998],
            [6.0, 6.0000015],
            [9.0, 9.0000015],
        ];
        let point = |[x, y]: [f64; 2]| kurbo::Point::new(x, y);
        for moved in offset(&[vec![ring.clone()]], 0.1895, 0.001).unwrap().into_iter().flatten().flatten() {
            let to = |k: usize| {
                let [a, b] = [ring[k], ring[(k + 1) % ring.len()]].map(point);
                crate::base::distance_to_segment(point(moved), a, b)
            };
            let nearest = (0..ring.len()).map(to).fold(f64::INFINITY, f64::min);
            assert!((nearest - 0.1895).abs() < 0.002, "{moved:?} lies {nearest} from the edges");
        }
    }
}
