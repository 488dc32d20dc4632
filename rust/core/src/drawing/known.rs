//! What is known of a label: all of it, nothing, or of inks over each other some of its bits.

use crate::base::Ink;

/// A label of which some bits are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Known {
    /// What is not known is 0 in it.
    label: u8,
    bits: u8,
}

impl Known {
    pub(crate) const NOTHING: Self = Self { label: 0, bits: 0 };

    /// All of a label.
    pub(crate) fn of(ink: Ink) -> Self {
        Self { label: ink.label(), bits: u8::MAX }
    }

    /// These bits of a label.
    pub(crate) fn of_bits(label: u8, bits: u8) -> Self {
        Self { label: label & bits, bits }
    }

    pub(crate) fn is_all(self) -> bool {
        self.bits == u8::MAX
    }

    /// The label, where what is not known is 0.
    pub(crate) fn ink(self) -> Ink {
        Ink::of_label(self.label)
    }

    /// The label, with what is not known from another one.
    pub(super) fn or(self, other: Ink) -> Ink {
        Ink::of_label(self.label | other.label() & !self.bits)
    }

    /// These bits of what is known.
    pub(super) fn only(self, bits: u8) -> Self {
        Self::of_bits(self.label, self.bits & bits)
    }

    /// The bits that are not known.
    pub(super) fn open(self) -> u8 {
        !self.bits
    }

    /// What both tell; `None` if they contradict each other.
    pub(crate) fn and(self, other: Self) -> Option<Self> {
        let differs = (self.label ^ other.label) & self.bits & other.bits != 0;
        (!differs).then_some(Self { label: self.label | other.label, bits: self.bits | other.bits })
    }
}
