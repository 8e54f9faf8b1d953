//! Memory and processor of this machine, as far as the system tells.

pub use raggio_memory::{
    available_bytes, held_bytes as memory_bytes, peak_bytes as peak_memory_bytes, total_bytes as total_memory_bytes,
};

use crate::pictures::film::film_bytes;

/// An image that this machine has no memory for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "an image of {width}x{height} pixels needs {needed_gib:.1} GiB of memory, and {available_gib:.1} GiB are available"
)]
pub struct TooLarge {
    width: u32,
    height: u32,
    needed_gib: f64,
    available_gib: f64,
}

/// Checks that the film of an image of `width` x `height` pixels, with its copies while files are written, fits the
/// machine: the system would end the program halfway.
///
/// # Errors
/// A [`TooLarge`] when it needs more memory than is available.
pub fn check_memory(width: u32, height: u32) -> Result<(), TooLarge> {
    check_films(width, height, 0)
}

/// [`check_memory`] for a picture with `more` films beside its own, for layers and guides.
pub(crate) fn check_films(width: u32, height: u32, more: u64) -> Result<(), TooLarge> {
    let gib = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
    let needed = (3 + more) * film_bytes(width, height);
    match available_bytes() {
        Some(available) if needed > available => {
            Err(TooLarge { width, height, needed_gib: gib(needed), available_gib: gib(available) })
        }
        _ => Ok(()),
    }
}

/// Number of processor cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Name of the processor as its maker calls it, where the system tells; else its architecture.
pub fn processor_name() -> String {
    let line = proc_value("/proc/cpuinfo", "model name");
    line.unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH))
}

/// The value after `key` in one of Linux's text files about itself; `None` elsewhere.
fn proc_value(file: &str, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
