//! Signals that end a render: the first keeps what there is, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// The signal that has come, if one has.
#[derive(Clone, Default)]
pub struct Stopped(Arc<AtomicU8>);

impl Stopped {
    /// Number of the signal.
    pub fn signal(&self) -> Option<u8> {
        Some(self.0.load(Ordering::Relaxed)).filter(|signal| *signal > 0)
    }

    /// Takes a signal: the first sets `stop`, the second ends the program and leaves nothing half-written.
    fn take(&self, signal: u8, stop: &AtomicBool) {
        if self.0.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed).is_err() {
            raggio_render::abandon_files();
            std::process::exit(128 + i32::from(signal));
        }
        stop.store(true, Ordering::Relaxed);
    }
}

/// Name of a signal.
pub fn name(signal: u8) -> &'static str {
    match signal {
        1 => "SIGHUP",
        15 => "SIGTERM",
        _ => "SIGINT",
    }
}

/// Waits for signals from now on: SIGINT, which is Ctrl-C, SIGTERM and SIGHUP. The first sets `stop`. Without a handler they
/// still work, they only keep nothing.
#[cfg(unix)]
pub fn listen(stop: Arc<AtomicBool>) -> Stopped {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let stopped = Stopped::default();
    // Who runs this under nohup wants it to go on when the terminal is closed.
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| *signal != SIGHUP || !is_ignored(SIGHUP));
    let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else { return stopped };
    let seen = stopped.clone();
    let listening = move || signals.forever().for_each(|signal| seen.take(signal as u8, &stop));
    let _ = std::thread::Builder::new().name("signals".into()).spawn(listening);
    stopped
}

/// Whether this process was started with a signal ignored, where the system tells.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
pub fn listen(stop: Arc<AtomicBool>) -> Stopped {
    const INTERRUPT: u8 = 2;
    let stopped = Stopped::default();
    let seen = stopped.clone();
    let _ = ctrlc::set_handler(move || seen.take(INTERRUPT, &stop));
    stopped
}
