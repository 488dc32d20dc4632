//! The native binary: Ctrl-C sets a flag, everything else is in the library.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    // Without a handler Ctrl-C ends the process as it does by default, which is all that is lost.
    let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
    std::process::exit(graphstipple_cli::run(std::env::args_os(), &|| flag.load(Ordering::Relaxed)).into());
}
