//! Values that were found to keep their rules: what is checked once, where it comes in, need not be checked again.

use std::ops::Deref;

/// Plain data whose every value keeps its rule. Only the `check` of the data makes one, of [`crate::Options`] and of
/// [`crate::Export`]; what draws and what writes asks for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked<T>(T);

impl<T> Checked<T> {
    /// For a `check` that has found nothing wrong.
    pub(crate) fn of(value: T) -> Self {
        Self(value)
    }

    /// The data, to be changed and checked again.
    pub fn into_inner(self) -> T {
        self.0
    }
}

impl<T> Deref for Checked<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}
