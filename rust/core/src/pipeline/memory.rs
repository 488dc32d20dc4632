//! What is kept from one drawing to the next: the last result of every stage, with what the stage needed of the options.

use std::sync::Arc;

use crate::drawing::Drawing;
use crate::graph::{Components, TonedCells, Triangulation};
use crate::labels::Labels;
use crate::options::{Options, identical};
use crate::photo::Field;
use crate::sites::FirstGraph;

/// The last result of every stage, or of none.
pub(super) struct Memory {
    pub(super) tone: Slot<Tone>,
    pub(super) emphasis: Slot<Field>,
    pub(super) importance: Slot<Field>,
    pub(super) first_graph: Slot<FirstGraph>,
    pub(super) second_graph: Slot<Triangulation>,
    pub(super) cells: Slot<TonedCells>,
    pub(super) labels: Slot<Labels>,
    pub(super) components: Slot<Components>,
    pub(super) outlines: Slot<Outlined>,
}

impl Memory {
    pub(super) fn new(keeps: bool) -> Self {
        Self {
            tone: Slot::new(keeps),
            emphasis: Slot::new(keeps),
            importance: Slot::new(keeps),
            first_graph: Slot::new(keeps),
            second_graph: Slot::new(keeps),
            cells: Slot::new(keeps),
            labels: Slot::new(keeps),
            components: Slot::new(keeps),
            outlines: Slot::new(keeps),
        }
    }
}

/// The last result of a stage, with what it needed of the options.
pub(super) struct Slot<T> {
    keeps: bool,
    last: Option<(Options, Arc<T>)>,
}

impl<T> Slot<T> {
    fn new(keeps: bool) -> Self {
        Self { keeps, last: None }
    }

    /// The last result, if the stage needed the same.
    pub(super) fn get(&self, needs: &Options) -> Option<Arc<T>> {
        self.last.as_ref().filter(|(needed, _)| identical(needed, needs)).map(|(_, made)| Arc::clone(made))
    }

    /// A new result. Where nothing is kept the caller is its only owner, and frees it by dropping it.
    pub(super) fn put(&mut self, needs: &Options, made: T) -> Arc<T> {
        let made = Arc::new(made);
        if self.keeps {
            self.last = Some((needs.clone(), Arc::clone(&made)));
        }
        made
    }
}

/// The tone before emphasis, its mean, and its least and largest value.
pub(super) struct Tone {
    /// `None` where it is the luma.
    pub(super) adjusted: Option<Field>,
    pub(super) mean: f64,
    pub(super) range: [f32; 2],
}

/// The drawing as the outlines make it, and what is counted in it.
pub(super) struct Outlined {
    pub(super) drawing: Arc<Drawing>,
    pub(super) vertices: usize,
    pub(super) anchors: usize,
    pub(super) coordinates: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_that_keeps_nothing_holds_nothing() {
        let needs = Options::default();
        let mut slots = [Memory::new(false), Memory::new(true)].map(|memory| memory.emphasis);
        let made = slots.each_mut().map(|slot| slot.put(&needs, Field::constant(3, 3, 0.5).unwrap()));
        assert_eq!(made.map(|made| Arc::strong_count(&made)), [1, 2]);
        assert!(slots[0].get(&needs).is_none() && slots[1].get(&needs).is_some());
        assert!(slots[1].get(&Options { gamma: 2.0, ..needs }).is_none());
    }
}
