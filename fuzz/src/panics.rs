//! Whose panic it is.

use std::backtrace::Backtrace;
use std::io::Cursor;
use std::panic::{set_hook, take_hook};
use std::sync::Once;

use graphstipple_core::Control;
use graphstipple_core::stages::{Reading, decode};

/// Where the core's files are, in the paths that panics and backtraces name.
const CORE: &str = "rust/core/src/";

/// Makes panics of the core's own code abort, even where the core catches and silences them. To be called before every input.
pub fn prepare() {
    static PREPARED: Once = Once::new();
    PREPARED.call_once(|| {
        // The core puts its hook over libFuzzer's, which aborts, at the first file that it hands to a decoder; this one goes over both.
        let _ = decode(&mut Cursor::new(b"\x89PNG\r\n\x1A\n"), &Reading::default(), &Control::new());
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            let file = panic.location().map_or("", |location| location.file());
            // A check of the standard library may be broken by anybody: then it counts who called it.
            let is_ours = file.contains(CORE) || file.starts_with("/rustc/") && is_called_by_core();
            if is_ours {
                eprintln!("the core panics: {panic}\n{}", Backtrace::force_capture());
                std::process::abort();
            }
            before(panic);
        }));
    });
}

/// Whether the first function of a backtrace outside the standard library is the core's.
fn is_called_by_core() -> bool {
    let trace = Backtrace::force_capture().to_string();
    let places = trace.lines().filter_map(|line| line.trim().strip_prefix("at "));
    let mut others =
        places.filter(|place| !place.starts_with("/rustc/") && !place.contains("fuzz/src/") && !place.contains("/library/"));
    others.next().is_some_and(|place| place.contains(CORE))
}
