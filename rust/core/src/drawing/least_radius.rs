//! A least radius for stipples, for pens, drills and screens that can make no smaller dot.

use kurbo::Point;
use serde::Serialize;

use crate::base::{Error, POLYGON_REACH, Pool, Result, distance_to_segment, flattened_edges};
use crate::drawing::data::Drawing;
use crate::outlines::Stipple;

/// What [`Drawing::with_least_radius`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct DotChanges {
    /// Stipples that became larger.
    pub enlarged: usize,
    /// Stipples that were left out, their place filled by what surrounds them.
    pub dropped: usize,
}

/// A thing that a dot must not touch.
#[derive(Clone, Copy)]
enum Obstacle {
    /// A piece of a flattened curve.
    Edge([Point; 2]),
    /// A dot, by its index.
    Dot(u32),
}

impl Drawing {
    /// The drawing with every stipple's radius at least `least` px: smaller ones are enlarged to it where they then touch nothing,
    /// the larger ones first, and left out (their hole is filled) where they would touch something. Irregular dots are regions and
    /// stay as they are.
    ///
    /// # Errors
    /// [`crate::Error::Option`] if `least` is negative or not finite.
    pub fn with_least_radius(&self, least: f64) -> Result<(Self, DotChanges)> {
        if !(least >= 0.0 && least.is_finite()) {
            return Err(Error::option("min_dot", least, "a length of 0 or more"));
        }
        let mut small: Vec<usize> = (0..self.stipples.len()).filter(|i| self.stipples[*i].radius < least).collect();
        if small.is_empty() {
            return Ok((self.clone(), DotChanges::default()));
        }
        small.sort_by(|a, b| self.stipples[*b].radius.total_cmp(&self.stipples[*a].radius).then(a.cmp(b)));
        let flattening = self.flattening_tolerance();
        let reach = least * POLYGON_REACH + flattening;
        let bins = Bins::new(self, reach);
        let mut stipples: Vec<Option<Stipple>> = self.stipples.iter().copied().map(Some).collect();
        let mut changes = DotChanges::default();
        for index in small {
            let dot = self.stipples[index];
            // Rounded down to the grid it must still be large enough.
            let wanted = least + 0.02 / self.units;
            let enlarged = Stipple::on_grid(Point::new(dot.x, dot.y), wanted, self.units, dot.ink);
            let centre = Point::new(enlarged.x, enlarged.y);
            let room = enlarged.radius * POLYGON_REACH;
            let inside =
                [centre.x, centre.y, self.width as f64 - centre.x, self.height as f64 - centre.y].into_iter().all(|d| d > room);
            let is_free = |obstacle: &Obstacle| match *obstacle {
                Obstacle::Edge([a, b]) => distance_to_segment(centre, a, b) > room + flattening,
                Obstacle::Dot(other) if other as usize == index => true,
                Obstacle::Dot(other) => stipples[other as usize].is_none_or(|other| {
                    (Point::new(other.x, other.y) - centre).hypot2().sqrt() > room + other.radius * POLYGON_REACH
                }),
            };
            if inside && bins.around(centre).all(is_free) {
                stipples[index] = Some(enlarged);
                changes.enlarged += 1;
            } else {
                stipples[index] = None;
                changes.dropped += 1;
            }
        }
        Ok((Pool::new(None).run(|| self.with_dots(&stipples))?, changes))
    }
}

/// Obstacles by the square bins that come within reach of them.
struct Bins {
    side: f64,
    columns: usize,
    bins: Vec<Vec<Obstacle>>,
}

impl Bins {
    fn new(drawing: &Drawing, reach: f64) -> Self {
        // Smaller ones are more to fill, larger ones more to look through; not more of them than pixels.
        let side = reach.max(4.0);
        let (columns, rows) = ((drawing.width as f64 / side) as usize + 1, (drawing.height as f64 / side) as usize + 1);
        let mut bins = Self { side, columns, bins: vec![Vec::new(); columns * rows] };
        for curve in &drawing.curves {
            for edge in flattened_edges(curve, drawing.flattening_tolerance()) {
                let [a, b] = edge.map(|[x, y]| Point::new(x, y));
                bins.add(Obstacle::Edge([a, b]), a, b, reach);
            }
        }
        for (index, dot) in (0u32..).zip(&drawing.stipples) {
            let centre = Point::new(dot.x, dot.y);
            // It may be enlarged itself.
            bins.add(Obstacle::Dot(index), centre, centre, reach + (dot.radius * POLYGON_REACH).max(reach));
        }
        bins
    }

    fn add(&mut self, obstacle: Obstacle, a: Point, b: Point, reach: f64) {
        let range = |low: f64, high: f64, count: usize| {
            let bin = |v: f64| ((v / self.side).max(0.0) as usize).min(count - 1);
            bin(low - reach)..=bin(high + reach)
        };
        let rows = self.bins.len() / self.columns;
        for row in range(a.y.min(b.y), a.y.max(b.y), rows) {
            for column in range(a.x.min(b.x), a.x.max(b.x), self.columns) {
                self.bins[row * self.columns + column].push(obstacle);
            }
        }
    }

    fn around(&self, p: Point) -> std::slice::Iter<'_, Obstacle> {
        let rows = self.bins.len() / self.columns;
        let (row, column) = ((p.y / self.side) as usize, (p.x / self.side) as usize);
        self.bins[row.min(rows - 1) * self.columns + column.min(self.columns - 1)].iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Control, Ink};
    use crate::drawing::{Loose, put_together};

    /// Black dots on a canvas of 40 x 20, all of one radius.
    fn dots(centres: &[[f64; 2]], radius: f64) -> Drawing {
        let dot = |[x, y]: &[f64; 2]| Stipple { x: *x, y: *y, radius, ink: Ink::BLACK, level: 0 };
        let stipples = centres.iter().map(dot).collect();
        let loose = Loose::plain(40, 20, vec![], stipples);
        put_together(loose, &|shape| format!("{shape:?}"), &Control::new()).unwrap()
    }

    #[test]
    fn of_two_that_would_touch_when_enlarged_one_is_dropped() {
        // On both sides of where bins meet, and far from there.
        for x in [8.0, 9.0, 10.0, 10.5, 11.0, 12.0, 13.0] {
            let (drawing, changes) = dots(&[[x, 10.0], [x + 2.2, 10.0]], 0.3).with_least_radius(1.2).unwrap();
            assert_eq!(changes, DotChanges { enlarged: 1, dropped: 1 }, "{x}");
            assert_eq!(drawing.stipples.len(), 1);
            let (_, changes) = dots(&[[x, 10.0], [x + 3.0, 10.0]], 0.3).with_least_radius(1.2).unwrap();
            assert_eq!(changes, DotChanges { enlarged: 2, dropped: 0 }, "{x}");
        }
    }

    #[test]
    fn what_is_enlarged_is_no_smaller_than_the_least() {
        for k in 0..100 {
            let least = 0.4 + 0.0137 * f64::from(k);
            let (drawing, _) = dots(&[[10.3, 10.7]], 0.3).with_least_radius(least).unwrap();
            let radius = drawing.stipples[0].radius;
            assert!(radius >= least && radius < least + 0.021 / drawing.units, "{radius} for {least}");
        }
    }
}
