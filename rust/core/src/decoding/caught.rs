//! Panics of libraries, caught: what other people's files bring them to is no defect of ours, and nothing for users to read.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    /// Whether what panics on this thread is a library's, which is told as an error and not printed.
    static IN_LIBRARY: Cell<bool> = const { Cell::new(false) };
}

/// What a library returns, called on this thread alone; `None` if it panics.
pub(super) fn caught<T>(run: impl FnOnce() -> T) -> Option<T> {
    static SILENCED: Once = Once::new();
    SILENCED.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IN_LIBRARY.get() {
                before(panic);
            }
        }));
    });
    let outer = IN_LIBRARY.replace(true);
    let result = catch_unwind(AssertUnwindSafe(run));
    IN_LIBRARY.set(outer);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_nothing_and_leaves_nothing() {
        assert_eq!(caught(|| caught(|| panic!("a library's")).map_or(1, |()| 2)), Some(1));
        assert_eq!(caught(|| 3), Some(3));
        assert!(!IN_LIBRARY.get());
    }
}
