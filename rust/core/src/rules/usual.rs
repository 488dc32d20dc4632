//! How large dots are to be where they are dense. In: how much of an ink lies where, and the limits; out: a diameter at every place.
//!
//! # The idea
//! Discs of a diameter d with room g between them cover at most P (d / (d + g))^2 of a plane. Where they are to cover the share t of it,
//! d is at least g c / (1 - c) with c = sqrt(t / P): the denser, the larger and the fewer, as in a coarser screen. P is 0.91 for the
//! densest packing, and 0.55 for discs that come at random until there is room for none.

use rayon::prelude::*;

/// P of dots that come one by one where they are missing.
const PACKING: f64 = 0.62;

/// Dots are no larger than so many times the least one, or the room between them: then they would be seen as a pattern.
const LARGEST: f64 = 3.0;

/// How wide cells are, in the least dot and the room beside it: of what is counted in nine of them there are some dots.
const CELL: f64 = 3.0;

/// Places along a side of a cell that are looked at.
const LOOKS: usize = 3;

/// Diameters by place.
pub(super) struct Usual {
    side: f64,
    columns: usize,
    /// In mm, by the cells' rows.
    diameters: Vec<f64>,
}

impl Usual {
    /// Of areas of an ink in mm^2 at places on a canvas of `size`, which lie on ground of the other ink; `least` is the least diameter,
    /// and `room` lies between two dots.
    pub(super) fn of(
        areas: impl Iterator<Item = ([f64; 2], f64)>,
        [least, room]: [f64; 2],
        size: [f64; 2],
        is_ground: impl Fn([f64; 2]) -> bool + Sync,
    ) -> Self {
        let longest = size[0].max(size[1]);
        let side = if least * room > 0.0 { (CELL * (least + room)).max(longest / 4096.0) } else { 2.0 * longest };
        let [columns, lines] = size.map(|length| (length / side) as usize + 1);
        let mut usual = Self { side, columns, diameters: vec![least; columns * lines] };
        if least * room == 0.0 {
            return usual;
        }
        let mut sums = vec![0.0; columns * lines];
        for (place, area) in areas {
            sums[usual.cell(place)] += area;
        }
        let around = |values: &[f64], cell: usize| -> f64 {
            let (line, column) = (cell / columns, cell % columns);
            let lines = line.saturating_sub(1)..=(line + 1).min(lines - 1);
            let columns_around = column.saturating_sub(1)..=(column + 1).min(columns - 1);
            lines.flat_map(|line| columns_around.clone().map(move |column| line * columns + column)).map(|cell| values[cell]).sum()
        };
        let looks = (LOOKS * LOOKS) as f64;
        let ground_in = |cell: usize| -> f64 {
            let corner = [(cell % columns) as f64 * side, (cell / columns) as f64 * side];
            let places = (0..LOOKS * LOOKS).map(|k| {
                let within = [k % LOOKS, k / LOOKS].map(|k| (k as f64 + 0.5) / LOOKS as f64 * side);
                [corner[0] + within[0], corner[1] + within[1]]
            });
            let on_ground = places.filter(|[x, y]| *x < size[0] && *y < size[1] && is_ground([*x, *y]));
            on_ground.count() as f64 / looks * side * side
        };
        let ground: Vec<f64> = (0..columns * lines).into_par_iter().map(ground_in).collect();
        for cell in 0..columns * lines {
            let (inked, free) = (around(&sums, cell), around(&ground, cell));
            if inked > 0.0 && free > 0.0 {
                let c = (inked / free / PACKING).sqrt();
                let largest = LARGEST * least.max(room);
                let wanted = if c < 1.0 { room * c / (1.0 - c) } else { largest };
                usual.diameters[cell] = wanted.clamp(least, largest);
            }
        }
        usual
    }

    fn cell(&self, p: [f64; 2]) -> usize {
        let lines = self.diameters.len() / self.columns;
        let along = |v: f64, count: usize| ((v / self.side).max(0.0) as usize).min(count - 1);
        along(p[1], lines) * self.columns + along(p[0], self.columns)
    }

    /// The diameter that dots are to have at a place, in mm.
    pub(super) fn diameter(&self, p: [f64; 2]) -> f64 {
        self.diameters[self.cell(p)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_larger_where_they_cover_more() {
        // Dots every quarter of a mm, twice as large on the right; what lies below 20 mm is no ground.
        let places = (0..51_200).map(|i| [f64::from(i % 320) * 0.25 + 0.1, f64::from(i / 320) * 0.25 + 0.1]);
        let area = |p: [f64; 2]| if p[0] < 40.0 { 0.2 } else { 0.35 } / 16.0;
        let areas: Vec<([f64; 2], f64)> = places.filter(|p| p[1] < 20.0).map(|p| (p, area(p))).collect();
        let usual = Usual::of(areas.into_iter(), [0.3, 0.3], [80.0, 40.0], |p| p[1] < 20.0);
        let expected = |share: f64| {
            let c = (share / PACKING).sqrt();
            0.3 * c / (1.0 - c)
        };
        assert!((usual.diameter([10.0, 8.0]) - expected(0.2)).abs() < 0.04, "{}", usual.diameter([10.0, 8.0]));
        assert!((usual.diameter([70.0, 8.0]) - expected(0.35)).abs() < 0.08, "{}", usual.diameter([70.0, 8.0]));
        assert_eq!(usual.diameter([10.0, 35.0]), 0.3);
        // Without a limit there is nothing that they must be.
        assert_eq!(Usual::of(std::iter::empty(), [0.0, 0.3], [80.0, 40.0], |_| true).diameter([1.0, 1.0]), 0.0);
    }
}
