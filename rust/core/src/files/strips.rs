//! An order of short ways. In: what lies on a canvas; out: the same in strips across it, one to the right and the next to the left, so
//! that the way from one to the next is short, and so is what a file says of it.

use std::cmp::Ordering;

/// Sorts by strips of this height; `place` is where something lies.
pub(super) fn sort_in_strips<T>(all: &mut [T], height: f64, place: impl Fn(&T) -> [f64; 2]) {
    let key = |one: &T| {
        let [x, y] = place(one);
        let strip = (y / height).floor();
        [strip, if strip % 2.0 == 0.0 { x } else { -x }, y]
    };
    // Places are numbers.
    all.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
}
