//! A round tour through stops, held as an array, and how two of its legs are exchanged. It does not know where stops are.

/// A round tour.
pub(crate) struct Tour {
    /// The stops in their order.
    order: Vec<u32>,
    /// Where in the order a stop is.
    position: Vec<u32>,
    /// What was turned round since the last [`Tour::keep`], as first and last positions.
    turned: Vec<[u32; 2]>,
}

impl Tour {
    pub(crate) fn new(order: Vec<u32>) -> Self {
        let mut position = vec![0; order.len()];
        for (at, stop) in (0..).zip(&order) {
            position[*stop as usize] = at;
        }
        Self { order, position, turned: Vec::new() }
    }

    /// The stops in the order of the tour, from any one on, forwards or backwards.
    pub(crate) fn into_order(self) -> Vec<u32> {
        self.order
    }

    /// How many stops there are.
    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    /// The stop after another, or before it.
    #[inline]
    pub(crate) fn beside(&self, stop: u32, is_after: bool) -> u32 {
        let at = self.position[stop as usize] as usize;
        let beside = if is_after {
            if at + 1 == self.order.len() { 0 } else { at + 1 }
        } else if at == 0 {
            self.order.len() - 1
        } else {
            at - 1
        };
        self.order[beside]
    }

    /// The stop so many steps after another.
    pub(crate) fn after(&self, stop: u32, steps: usize) -> u32 {
        self.order[(self.position[stop as usize] as usize + steps) % self.order.len()]
    }

    /// How many steps it is from one stop to another, one way round or the other.
    #[inline]
    pub(crate) fn steps(&self, a: u32, b: u32) -> usize {
        self.position[a as usize].abs_diff(self.position[b as usize]) as usize
    }

    /// In place of the legs from a to b and from c to d, those from a to c and from b to d. b is after a and d after c, or both before.
    /// Returns how many stops were turned round.
    pub(crate) fn exchange(&mut self, a: u32, b: u32, c: u32, d: u32) -> usize {
        let [first, last] = if self.beside(a, true) == b { [b, c] } else { [a, d] };
        debug_assert!(
            self.beside(a, true) == b && self.beside(c, true) == d || self.beside(b, true) == a && self.beside(d, true) == c
        );
        let [mut first, mut last] = [first, last].map(|stop| self.position[stop as usize] as usize);
        let len = self.order.len();
        let count = if last >= first { last - first } else { last + len - first } + 1;
        if 2 * count > len {
            // The other stops are fewer, and turning them round gives the same tour backwards.
            (first, last) = (if last + 1 == len { 0 } else { last + 1 }, if first == 0 { len - 1 } else { first - 1 });
        }
        self.turn(first, last);
        self.turned.push([first as u32, last as u32]);
        count.min(len - count)
    }

    /// What was done up to now stays.
    pub(crate) fn keep(&mut self) {
        self.turned.clear();
    }

    /// Back to what it was at the last [`Tour::keep`].
    pub(crate) fn take_back(&mut self) {
        while let Some([first, last]) = self.turned.pop() {
            self.turn(first as usize, last as usize);
        }
    }

    /// Turns round the stops from one position on to another, which may lie before it: then over the end of the array.
    fn turn(&mut self, first: usize, last: usize) {
        if first <= last {
            self.order[first..=last].reverse();
            for at in first..=last {
                self.position[self.order[at] as usize] = at as u32;
            }
            return;
        }
        let len = self.order.len();
        let (mut low, mut high) = (first, last);
        for _ in 0..(last + len - first).div_ceil(2) {
            self.order.swap(low, high);
            self.position[self.order[low] as usize] = low as u32;
            self.position[self.order[high] as usize] = high as u32;
            low = if low + 1 == len { 0 } else { low + 1 };
            high = if high == 0 { len - 1 } else { high - 1 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All legs, whatever their direction.
    fn legs(tour: &Tour) -> Vec<[u32; 2]> {
        let mut legs: Vec<[u32; 2]> = (0..tour.len() as u32).map(|stop| [stop, tour.beside(stop, true)]).collect();
        legs.iter_mut().for_each(|leg| leg.sort_unstable());
        legs.sort_unstable();
        legs
    }

    proptest! {
        #[test]
        fn an_exchange_changes_two_legs_and_can_be_taken_back(
            len in 4u32..20, moves in prop::collection::vec((0u32..20, 0u32..20, any::<bool>()), 1..30)
        ) {
            let mut tour = Tour::new((0..len).collect());
            for (a, c, is_after) in &moves {
                let (a, c) = (a % len, c % len);
                let [b, d] = [a, c].map(|stop| tour.beside(stop, *is_after));
                if a == c || b == c || a == d {
                    continue;
                }
                let mut expected = legs(&tour);
                for leg in [[a, b], [c, d]] {
                    let leg = [leg[0].min(leg[1]), leg[0].max(leg[1])];
                    let at = expected.iter().position(|other| *other == leg).unwrap();
                    expected.remove(at);
                }
                expected.extend([[a.min(c), a.max(c)], [b.min(d), b.max(d)]]);
                expected.sort_unstable();
                tour.exchange(a, b, c, d);
                prop_assert_eq!(legs(&tour), expected);
                prop_assert!((0..len).all(|stop| tour.beside(stop, true) == tour.after(stop, 1)));
            }
            tour.take_back();
            prop_assert_eq!(tour.into_order(), (0..len).collect::<Vec<_>>());
        }
    }
}
