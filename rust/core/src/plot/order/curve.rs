//! Hilbert's curve through a square: what lies close together on it lies close together in the plane. In: places; out: the order in
//! which the curve comes by them.

/// Cells of the curve's grid on a side: 2^16, a few micrometres of a large sheet.
const BITS: u32 = 16;

/// The numbers of some places in the order of the curve, those at one place beside one another. Coordinates are finite.
pub(crate) fn along_curve(places: &[[f64; 2]]) -> Vec<u32> {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for place in places {
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    let cells = f64::from((1u32 << BITS) - 1);
    let scale = if extent > 0.0 { cells / extent } else { 0.0 };
    let cell = |place: &[f64; 2], axis: usize| ((place[axis] - low[axis]) * scale).min(cells) as u32;
    let step = |place: &[f64; 2]| u64::from(step(cell(place, 0), cell(place, 1)));
    let mut keys: Vec<u64> = places.iter().zip(0u64..).map(|(place, number)| step(place) << 32 | number).collect();
    keys.sort_unstable();
    let mut order: Vec<u32> = keys.iter().map(|key| *key as u32).collect();
    // In a cell of several places, which the curve does not tell apart.
    let at = |number: u32| places[number as usize];
    for cell in keys.chunk_by(|a, b| a >> 32 == b >> 32).scan(0, |end, cell| {
        *end += cell.len();
        Some(*end - cell.len()..*end)
    }) {
        if cell.len() > 1 {
            order[cell].sort_unstable_by(|a, b| {
                let ([ax, ay], [bx, by]) = (at(*a), at(*b));
                ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(a.cmp(b))
            });
        }
    }
    order
}

/// How many steps from its beginning the curve comes by a cell.
fn step(mut x: u32, mut y: u32) -> u32 {
    let mut steps = 0;
    for bit in (0..BITS).rev() {
        let (right, down) = (x >> bit & 1, y >> bit & 1);
        steps = steps << 2 | ((3 * right) ^ down);
        if down == 0 {
            // The quarter is passed as its mirror image.
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_from_cell_to_neighbouring_cell() {
        // The first 2^14 steps are a curve through a square of 128 x 128 cells.
        let side = 128;
        let mut cells: Vec<(u32, [u32; 2])> = (0..side * side).map(|i| (step(i % side, i / side), [i % side, i / side])).collect();
        cells.sort_unstable();
        for (expected, (step, _)) in (0..).zip(&cells) {
            assert_eq!(expected, *step);
        }
        for pair in cells.windows(2) {
            let ([ax, ay], [bx, by]) = (pair[0].1, pair[1].1);
            assert_eq!(ax.abs_diff(bx) + ay.abs_diff(by), 1, "{pair:?}");
        }
    }

    #[test]
    fn equal_places_stand_beside_one_another() {
        let places = [[0.0, 0.0], [1.0, 1.0], [1e-9, 0.0], [0.0, 0.0], [1e-9, 0.0], [0.0, 1.0]];
        let order = along_curve(&places);
        let runs = order.chunk_by(|a, b| places[*a as usize] == places[*b as usize]).count();
        assert_eq!((order.len(), runs), (6, 4));
        assert!(along_curve(&[]).is_empty());
        assert_eq!(along_curve(&[[3.0, 3.0]; 3]), [0, 1, 2]);
    }
}
