//! Sets of numbers that are joined one by one, each with its lowest number for a name (Galler and Fischer 1964).

/// The sets of the numbers below a count.
pub(super) struct Joined {
    /// A forest: every number points to a lower one of its set, the lowest to itself.
    lower: Vec<usize>,
}

impl Joined {
    /// Every number by itself.
    pub(super) fn new(count: usize) -> Self {
        Self { lower: (0..count).collect() }
    }

    pub(super) fn len(&self) -> usize {
        self.lower.len()
    }

    /// The lowest number of a set.
    pub(super) fn lowest(&mut self, mut number: usize) -> usize {
        while self.lower[number] != number {
            self.lower[number] = self.lower[self.lower[number]];
            number = self.lower[number];
        }
        number
    }

    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.lowest(a), self.lowest(b));
        self.lower[a.max(b)] = a.min(b);
    }

    /// The sets by numbers from 0 on, in the order of their lowest numbers: that of every number, and the lowest of every set.
    pub(super) fn numbered(&mut self) -> (Vec<u32>, Vec<usize>) {
        let (mut sets, mut lowest) = (vec![0; self.len()], Vec::new());
        for number in 0..self.len() {
            let first = self.lowest(number);
            if first == number {
                lowest.push(number);
                sets[number] = lowest.len() as u32 - 1;
            } else {
                sets[number] = sets[first];
            }
        }
        (sets, lowest)
    }
}
