//! The native binary: signals that ask it to stop are noted, everything else is in the library.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use signal_hook::consts;
use signal_hook::flag;

fn main() {
    let noted = Arc::new(AtomicUsize::new(0));
    for signal in signals() {
        // Without a handler the signal ends the process as it does by default, which is all that is lost.
        let _ = flag::register_usize(signal, Arc::clone(&noted), signal as usize);
    }
    let interrupted = || match noted.load(Ordering::Relaxed) as u8 {
        0 => None,
        signal => Some(128 + signal),
    };
    std::process::exit(graphstipple_cli::run(std::env::args_os(), &interrupted).into());
}

/// The signals to note: those that ask to stop, but for what whoever started this has had ignored, as nohup does.
fn signals() -> Vec<i32> {
    let ignored = ignored();
    let mut signals = vec![consts::SIGINT, consts::SIGTERM];
    // Where the system does not tell, hanging up stays as it is.
    #[cfg(unix)]
    signals.extend(ignored.map(|_| consts::SIGHUP));
    signals.retain(|signal| ignored.unwrap_or(0) >> (signal - 1) & 1 == 0);
    signals
}

/// The signals that are ignored, a bit each, the lowest for number 1; `None` where the system, unlike Linux, has no file that says so.
fn ignored() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let bits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(bits.trim(), 16).ok()
}
