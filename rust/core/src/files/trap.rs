//! Traps: inks that spread under darker ones, so that no paper shows between them where plates are printed a little apart. In: a drawing of
//! several inks and how far a lighter ink spreads; out: what that adds to its plate. Source: trapping as print shops do it, by the offsets
//! of [`crate::offset`].
//!
//! Of two inks that touch, the lighter one grows, since the edge that is seen is that of the darker. It grows into darker inks alone,
//! never onto paper.

use kurbo::BezPath;

use crate::base::{Ink, Result};
use crate::drawing::Drawing;
use crate::files::layers::{Area, Outline};
use crate::offset::{Polygon, intersection, offset, united};

/// What a trap covers of its own ink beside the edge, in px: without it a hair of paper could show between polygons and curves. Inks
/// that are no further from each other touch.
const LAP: f64 = 0.25;

/// Steps to a pixel that points of traps are rounded to.
const STEPS: f64 = 64.0;

impl Drawing {
    /// What an ink, by its number, covers of darker ones when it spreads by `distance` px, with a lap over its own edge.
    pub(super) fn trap(&self, ink: usize, darker: &[usize], distance: f64) -> Result<Vec<Area>> {
        let tolerance = self.flattening_tolerance();
        let others = self.polygons_of(darker);
        // From the edges that they share: what lies on the other side of paper is not reached.
        let rim = intersection(&self.polygons_of(&[ink]), &offset(&others, LAP, tolerance)?)?;
        let spread = intersection(&offset(&rim, distance, tolerance)?, &others)?;
        let both: Vec<Polygon> = spread.into_iter().chain(rim).collect();
        Ok(united(&both)?.into_iter().filter_map(area).collect())
    }

    /// Regions and dots of inks of a solid drawing as polygons in pixels.
    fn polygons_of(&self, inks: &[usize]) -> Vec<Polygon> {
        let is_of = |ink: Ink| inks.contains(&ink.index());
        let regions = (0..self.regions.len()).filter(|region| is_of(self.regions[*region].ink)).map(|region| {
            let (exterior, holes) = self.region_rings(region);
            std::iter::once(exterior).chain(holes).collect()
        });
        let dots = (0..self.stipples.len()).filter(|dot| is_of(self.stipples[*dot].ink));
        regions.chain(dots.map(|dot| vec![self.stipple_outline(dot, self.flattening_tolerance())])).collect()
    }
}

/// A polygon as an area on the grid; none if nothing is left of it there.
fn area(polygon: Polygon) -> Option<Area> {
    let mut rings = polygon.into_iter().map(|ring| path(&ring));
    let exterior = Outline::Path(rings.next()??);
    Some(Area { mark: None, exterior, holes: rings.flatten().map(Outline::Path).collect() })
}

fn path(ring: &[[f64; 2]]) -> Option<BezPath> {
    let mut points: Vec<[f64; 2]> = ring.iter().map(|point| point.map(|v| (v * STEPS).round() / STEPS)).collect();
    points.dedup();
    while points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let [first, rest @ ..] = &points[..] else { return None };
    if rest.len() < 2 {
        return None;
    }
    let mut path = BezPath::new();
    path.move_to((first[0], first[1]));
    rest.iter().for_each(|point| path.line_to((point[0], point[1])));
    path.close_path();
    Some(path)
}
