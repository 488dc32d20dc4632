//! Boxes around areas, to tell which of many come near which.

use crate::offset::Polygon;

/// Left, top, right and bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds(pub(super) [f64; 4]);

impl Bounds {
    pub(super) fn of(points: &[[f64; 2]]) -> Self {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for [x, y] in points {
            bounds = [bounds[0].min(*x), bounds[1].min(*y), bounds[2].max(*x), bounds[3].max(*y)];
        }
        Self(bounds)
    }

    pub(super) fn wider(self, by: f64) -> Self {
        let [left, top, right, bottom] = self.0;
        Self([left - by, top - by, right + by, bottom + by])
    }

    pub(super) fn longer_side(self) -> f64 {
        let [left, top, right, bottom] = self.0;
        (right - left).max(bottom - top)
    }

    fn meets(self, other: Self) -> bool {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        a <= g && e <= c && b <= h && f <= d
    }

    pub(super) fn area(self) -> Polygon {
        let [left, top, right, bottom] = self.0;
        vec![vec![[left, top], [right, top], [right, bottom], [left, bottom]]]
    }
}

/// Many boxes, to ask whether one of them meets another one.
pub(super) struct Boxes {
    /// By their tops.
    boxes: Vec<Bounds>,
    /// Over every box and those before it: how far down they reach.
    reach: Vec<f64>,
}

impl Boxes {
    pub(super) fn new(mut boxes: Vec<Bounds>) -> Self {
        boxes.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]));
        let mut reach = Vec::with_capacity(boxes.len());
        for bounds in &boxes {
            reach.push(reach.last().copied().unwrap_or(f64::NEG_INFINITY).max(bounds.0[3]));
        }
        Self { boxes, reach }
    }

    pub(super) fn meets(&self, other: Bounds) -> bool {
        // What reaches down to its top begins there, and what begins above its bottom ends there.
        let first = self.reach.partition_point(|reach| *reach < other.0[1]);
        self.boxes[first..].iter().take_while(|b| b.0[1] <= other.0[3]).any(|b| b.meets(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_meet_as_they_would_one_by_one() {
        let boxes: Vec<Bounds> = (0..60)
            .map(|i| {
                let (x, y) = (f64::from(i * 37 % 41), f64::from(i * 53 % 43));
                Bounds([x, y, x + f64::from(i % 7), y + f64::from(i % 5) * f64::from(1 + i % 11)])
            })
            .collect();
        let index = Boxes::new(boxes.clone());
        for i in 0..500 {
            let (x, y) = (f64::from(i * 29 % 97) * 0.5, f64::from(i * 71 % 101) * 0.5);
            let asked = Bounds([x, y, x + 0.25, y + f64::from(i % 3)]);
            assert_eq!(index.meets(asked), boxes.iter().any(|b| b.meets(asked)), "{asked:?}");
        }
    }
}
