//! Islands: white that falls out when black is cut away, as black is all around it. In: a drawing, or black polygons; out: where they
//! are and how large. White that touches the frame is held by the sheet, which goes on beyond it.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::base::{Ink, Pool, signed_area};
use crate::drawing::Drawing;
use crate::offset::Polygon;
use crate::rules::nesting::{Hole, containers, white_areas};

/// White that falls out. Lengths are in pixels of the canvas, or in the unit of the polygons.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Island {
    /// A point in it.
    pub at: [f64; 2],
    /// Its area, without the black in it.
    pub area: f64,
    /// Left, top, right and bottom.
    pub bounds: [f64; 4],
}

/// The islands of a drawing, from the top down.
pub fn islands(drawing: &Drawing) -> Vec<Island> {
    // All white on a level above the lowest lies in black.
    let is_island = |ink: Ink, level: u32| ink == Ink::WHITE && level > 0;
    let regions: Vec<usize> =
        (0..drawing.regions.len()).filter(|k| is_island(drawing.regions[*k].ink, drawing.regions[*k].level)).collect();
    let of_region = |region: &usize| {
        let (exterior, holes) = drawing.region_rings(*region);
        island(&exterior, holes.iter().map(Vec::as_slice))
    };
    let mut islands: Vec<Island> = Pool::new(None).run(|| regions.par_iter().filter_map(of_region).collect());
    islands.extend(drawing.stipples.iter().filter(|dot| is_island(dot.ink, dot.level)).map(|dot| Island {
        at: [dot.x, dot.y],
        area: PI * dot.radius * dot.radius,
        bounds: [dot.x - dot.radius, dot.y - dot.radius, dot.x + dot.radius, dot.y + dot.radius],
    }));
    from_the_top(islands)
}

/// The islands between black polygons that are disjoint, from the top down.
pub fn islands_between(black: &[Polygon]) -> Vec<Island> {
    let containers = containers(black);
    let areas = white_areas(black, &containers);
    // What lies in every hole.
    let mut inside: Vec<(Hole, u32)> = (0u32..).zip(&containers).filter_map(|(k, container)| Some(((*container)?, k))).collect();
    inside.sort_unstable();
    let mut islands = Vec::new();
    for (polygon, rings) in (0u32..).zip(black) {
        for (ring, points) in (0u32..).zip(rings).skip(1) {
            let own = (polygon, ring);
            let first = inside.partition_point(|(hole, _)| *hole < own);
            let within = inside[first..].iter().take_while(|(hole, _)| *hole == own);
            let holes = within.filter_map(|(_, other)| black[*other as usize].first()).map(Vec::as_slice);
            let found = island(points, holes);
            islands.extend(found.map(|island| Island { area: areas[polygon as usize][ring as usize - 1], ..island }));
        }
    }
    from_the_top(islands)
}

fn from_the_top(mut islands: Vec<Island>) -> Vec<Island> {
    let key = |island: &Island| [island.bounds[1], island.bounds[0], island.bounds[3], island.bounds[2]];
    islands.sort_by(|a, b| {
        let pairs = key(a).into_iter().zip(key(b));
        pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    islands
}

/// The white in a ring, but for what lies in others; `None` if the ring has no height.
fn island<'a>(exterior: &'a [[f64; 2]], holes: impl Iterator<Item = &'a [[f64; 2]]>) -> Option<Island> {
    let rings: Vec<&[[f64; 2]]> = std::iter::once(exterior).chain(holes).collect();
    let bound = |axis: usize, pick: fn(f64, f64) -> f64| exterior.iter().map(|point| point[axis]).reduce(pick);
    let bounds = [bound(0, f64::min)?, bound(1, f64::min)?, bound(0, f64::max)?, bound(1, f64::max)?];
    let others: f64 = rings[1..].iter().map(|ring| signed_area(ring).abs()).sum();
    Some(Island { at: inside(&rings, bounds)?, area: signed_area(exterior).abs() - others, bounds })
}

/// Where lines through a white piece are looked at, as parts of its height: of one that is cut by holes there, another is wider.
const LINES: [f64; 3] = [0.5, 0.31, 0.69];

/// A point in the first of some rings and in none of the others: the middle of the widest white on one of a few level lines.
pub(super) fn inside(rings: &[impl AsRef<[[f64; 2]]>], [_, top, _, bottom]: [f64; 4]) -> Option<[f64; 2]> {
    let on_line = |part: f64| {
        let y = top + part * (bottom - top);
        let mut crossings: Vec<f64> = Vec::new();
        for ring in rings.iter().map(AsRef::as_ref) {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                if (a[1] <= y) != (b[1] <= y) {
                    crossings.push(a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])));
                }
            }
        }
        crossings.sort_by(f64::total_cmp);
        let widths = crossings.chunks_exact(2).map(|pair| (pair[1] - pair[0], [0.5 * (pair[0] + pair[1]), y]));
        widths.reduce(|widest, other| if other.0 > widest.0 { other } else { widest })
    };
    let widths = LINES.into_iter().filter_map(on_line);
    widths.reduce(|widest, other| if other.0 > widest.0 { other } else { widest }).map(|(_, point)| point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Control, circle_polygon};
    use crate::importance::Importance;
    use crate::options::Options;
    use crate::photo::{Field, Photo};
    use crate::pipeline::draw;

    /// A drawing with islands, in some of them black, and dots.
    fn drawing() -> Drawing {
        let value = |i: usize| {
            let (x, y) = ((i % 120) as f64, (i / 120) as f64);
            let ring = ((x - 60.0).powi(2) + (y - 45.0).powi(2)).sqrt();
            let is_white = (ring > 20.0 && ring < 30.0) || ring < 8.0 || x > 112.0;
            if is_white {
                1.0
            } else if y > 80.0 {
                0.12
            } else {
                0.0
            }
        };
        let luma = Field::new(120, 100, (0..12_000).map(|i| value(i) as f32).collect()).unwrap();
        let options = Options { nodes: Some(4000), ..Options::default() }.check().unwrap();
        (*draw(&Photo::new(luma), &Importance::Constant(1.0), &options, &Control::new()).unwrap().drawing).clone()
    }

    #[test]
    fn islands_are_told_with_a_point_in_them() {
        let drawing = drawing();
        let found = islands(&drawing);
        let large: Vec<&Island> = found.iter().filter(|island| island.area > 150.0).collect();
        let [ring, disc] = large[..] else { panic!("{found:?}") };
        for (island, least, most) in [(ring, 20.0, 30.0), (disc, 0.0, 8.0)] {
            let from_middle = ((island.at[0] - 60.0).powi(2) + (island.at[1] - 45.0).powi(2)).sqrt();
            assert!((least - 1.0..most + 1.0).contains(&from_middle), "{island:?}");
            let expected = PI * (most * most - least * least);
            assert!((island.area / expected - 1.0).abs() < 0.08, "{} for {expected}", island.area);
            for (bound, expected) in island.bounds.into_iter().zip([60.0 - most, 45.0 - most, 60.0 + most, 45.0 + most]) {
                assert!((bound - expected).abs() < 1.0, "{island:?}");
            }
        }
        // The strip on the right is held.
        assert!(found.len() > 20 && found.iter().all(|island| island.bounds[2] < 113.0));
        assert!(found.windows(2).all(|pair| pair[0].bounds[1] <= pair[1].bounds[1]));
    }

    #[test]
    fn polygons_have_the_islands_of_their_drawing() {
        let drawing = drawing();
        let of_region = |k: usize| {
            let (exterior, holes) = drawing.region_rings(k);
            std::iter::once(exterior).chain(holes).collect()
        };
        let regions = (0..drawing.regions.len()).filter(|k| drawing.regions[*k].ink == Ink::BLACK).map(of_region);
        let dots = drawing.stipples.iter().filter(|dot| dot.ink == Ink::BLACK);
        let dots = dots.map(|dot| vec![circle_polygon([dot.x, dot.y], dot.radius, drawing.flattening_tolerance())]);
        let black: Vec<Polygon> = regions.chain(dots).collect();
        let (of_polygons, of_drawing) = (islands_between(&black), islands(&drawing));
        assert_eq!(of_polygons.len(), of_drawing.len());
        // A circle's polygon is not quite as high.
        let are_near = |a: &Island, b: &Island| a.bounds.iter().zip(&b.bounds).all(|(a, b)| (a - b).abs() < 0.1);
        for island in &of_drawing {
            let same = of_polygons.iter().find(|other| are_near(island, other)).unwrap();
            assert!((same.area - island.area).abs() < 1e-6 * island.area, "{same:?} {island:?}");
        }
    }

    #[test]
    fn a_point_lies_between_holes() {
        let square =
            |left: f64, top: f64, side: f64| vec![[left, top], [left + side, top], [left + side, top + side], [left, top + side]];
        let holes = [square(1.0, 1.0, 8.0), square(9.1, 2.0, 0.5)];
        let found = island(&square(0.0, 0.0, 10.0), holes.iter().map(Vec::as_slice)).unwrap();
        assert!(found.at[0] < 1.0 && (found.area - 35.75).abs() < 1e-9, "{found:?}");
        assert_eq!(island(&[[0.0, 1.0], [2.0, 1.0], [1.0, 1.0]], std::iter::empty()), None);
    }
}
