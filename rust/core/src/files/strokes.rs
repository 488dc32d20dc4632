//! Dots as strokes with round caps, for small files. In: a drawing; out: the same with few radii, so that a file tells each once,
//! and the dots of a layer by radius.
//!
//! # How radii are rounded
//! Radii with the same leading bits are a class, 64 classes to a doubling, and the class gets one radius, in hundredths of a unit,
//! between its least and its largest, so that its dots have the ink that they had. A radius changes by less than 1.6 per cent, and a
//! dot's leftmost point stays where it was: so no point of an outline moves by more than 3.2 per cent of the radius. That is less than
//! the distance that dots keep to all else, and below a fiftieth of a pixel for dots of half a pixel. The least radius of a drawing does not become
//! smaller. A drawing whose radii were rounded is not changed again.

use std::collections::BTreeMap;

use kurbo::Point;

use crate::base::{Ink, Result};
use crate::drawing::Drawing;
use crate::files::layers::{Area, Outline};
use crate::files::strips::sort_in_strips;
use crate::files::write_path::{leftmost, rounded};
use crate::outlines::Stipple;

/// Parts of a unit that the paths of strokes count: the outlines put most dots on quarters of a unit, and whole numbers are shorter.
pub(super) const FINER: f64 = 4.0;

/// Bits of a radius, after its first, that a class shares. One more would double the paths for a tenth of a per mille of grey.
const CLASS_BITS: u32 = 6;

/// The drawing with the radii of its dots rounded to few.
///
/// # Errors
/// [`crate::Error::Internal`] if its shapes do not fit together.
pub(super) fn with_few_radii(drawing: &Drawing) -> Result<Drawing> {
    let units = drawing.units;
    let mut stipples = drawing.stipples.clone();
    let mut classes: BTreeMap<(Ink, u64), Vec<usize>> = BTreeMap::new();
    for (number, dot) in drawing.stipples.iter().enumerate() {
        let leading = (dot.radius * units).to_bits() >> (f64::MANTISSA_DIGITS - 1 - CLASS_BITS);
        classes.entry((dot.ink, leading)).or_default().push(number);
    }
    for members in classes.values() {
        let radii = || members.iter().map(|number| drawing.stipples[*number].radius * units);
        let (least, most) = radii().fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), r| (least.min(r), most.max(r)));
        let mean = (radii().map(|radius| radius * radius).sum::<f64>() / members.len() as f64).sqrt();
        let radius = ((mean * 100.0).round() / 100.0).clamp(least, most);
        for number in members {
            let dot = &mut stipples[*number];
            dot.x = (leftmost(dot.x * units, dot.radius * units) + radius) / units;
            dot.radius = radius / units;
        }
    }
    let stipples: Vec<Option<Stipple>> = stipples.into_iter().map(Some).collect();
    drawing.with_dots(&stipples)
}

/// The dots of a layer by radius, from the smallest: radius and centres, `units` to a pixel. Those of one radius follow one another in strips
/// across the canvas, there and back, so that the way from one to the next is short.
pub(super) fn by_radius(areas: &[Area], units: f64, canvas: [usize; 2]) -> Vec<(f64, Vec<Point>)> {
    // Positive numbers have the order of their bits.
    let mut classes: BTreeMap<u64, Vec<Point>> = BTreeMap::new();
    for area in areas {
        if let Outline::Circle { x, y, radius } = area.exterior {
            let radius = radius * units;
            let centre = Point::new(rounded(leftmost(x * units, radius) + radius), y * units);
            classes.entry(radius.to_bits()).or_default().push(centre);
        }
    }
    let [width, height] = canvas.map(|side| side as f64 * units);
    for centres in classes.values_mut() {
        let strip = (2.0 * width * height / centres.len() as f64).sqrt();
        sort_in_strips(centres, strip, |p| [p.x, p.y]);
    }
    classes.into_iter().map(|(radius, centres)| (f64::from_bits(radius), centres)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Control;
    use crate::drawing::{Loose, put_together};
    use crate::files::layers::Style;
    use crate::options::Only;

    /// Many dots of many radii, in hundredths of a unit as the outlines make them.
    fn dotted() -> Drawing {
        let dot = |i: u32| {
            let radius = f64::from(480 + i * 7919 % 2400) / 1600.0;
            let (x, y) = (f64::from(i % 80) * 8.0 + 4.0 + radius, f64::from(i / 80) * 8.0 + 4.0);
            Stipple { x, y, radius, ink: Ink::BLACK, level: 0 }
        };
        let stipples = (0..4000).map(dot).collect();
        let loose = Loose::plain(648, 408, vec![], stipples);
        put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap()
    }

    fn ink(drawing: &Drawing) -> f64 {
        drawing.stipples.iter().map(|dot| dot.radius * dot.radius).sum()
    }

    #[test]
    fn radii_are_few_and_near_and_the_ink_stays() {
        let drawing = dotted();
        let few = with_few_radii(&drawing).unwrap();
        let mut radii: Vec<u64> = few.stipples.iter().map(|dot| dot.radius.to_bits()).collect();
        radii.sort_unstable();
        radii.dedup();
        assert!((100..200).contains(&radii.len()), "{}", radii.len());
        assert!((ink(&few) / ink(&drawing) - 1.0).abs() < 1e-4);
        for (before, after) in drawing.stipples.iter().zip(&few.stipples) {
            assert!((after.radius / before.radius - 1.0).abs() < 1.0 / 64.0);
            let left = |dot: &crate::outlines::Stipple| dot.x - dot.radius;
            assert!((left(before) - left(after)).abs() < 1e-9 && before.y == after.y);
        }
        let least = |drawing: &Drawing| drawing.stipples.iter().map(|dot| dot.radius).fold(f64::INFINITY, f64::min);
        assert!(least(&few) >= least(&drawing));
        assert_eq!(with_few_radii(&few).unwrap(), few);
    }

    #[test]
    fn a_dot_that_is_alone_of_its_size_keeps_it() {
        let dot = |(k, radius): (usize, f64)| Stipple { x: 10.0 * k as f64 + 5.0, y: 5.0, radius, ink: Ink::BLACK, level: 0 };
        let radii = [0.000_123, 0.0321, 0.777_777, 3.654_321];
        let stipples = radii.into_iter().enumerate().map(dot).collect();
        let loose = Loose::plain(40, 10, vec![], stipples);
        let drawing = put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap();
        for (dot, radius) in with_few_radii(&drawing).unwrap().stipples.iter().zip(radii) {
            assert!((dot.radius / radius - 1.0).abs() < 1e-12, "{} instead of {radius}", dot.radius);
        }
    }

    #[test]
    fn dots_of_a_radius_follow_one_another() {
        let drawing = with_few_radii(&dotted()).unwrap();
        let layers = drawing.layers(Style::Flat, &Only::default(), None).unwrap();
        let classes = by_radius(&layers.layers[0].areas, drawing.units, [640, 400]);
        assert_eq!(classes.iter().map(|(_, centres)| centres.len()).sum::<usize>(), 4000);
        assert!(classes.is_sorted_by(|a, b| a.0 < b.0));
        let (ways, length) = classes.iter().flat_map(|(_, centres)| centres.windows(2)).fold((0, 0.0), |(ways, length), pair| {
            let by = pair[1] - pair[0];
            // Whole numbers, since the decimals are those of the radius.
            assert_eq!(rounded(by.x), rounded(by.x).round());
            (ways + 1, length + by.hypot() / drawing.units)
        });
        // Some thirty dots of a radius lie 90 px apart; in the order of rows it would be 213 px.
        assert!(length / f64::from(ways) < 120.0, "{}", length / f64::from(ways));
    }
}
