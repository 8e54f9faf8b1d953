//! Faults of the disk that a test asks for.

use std::cell::Cell;
use std::fmt;
use std::fs::File;
use std::io::{self, Write};
use std::thread::JoinHandle;

thread_local! {
    /// Steps of writing on this thread until one fails; 0: none will.
    static STEPS_LEFT: Cell<u64> = const { Cell::new(0) };
}

/// Makes one step of writing files on this thread fail as on a full disk: the first for 1. Steps are the making of a file,
/// each write, each wait for the disk and each renaming; 0 takes the fault back. What follows a fault can be tried out on
/// disks that have none.
pub fn pretend_file_fault(step: u64) {
    STEPS_LEFT.set(step);
}

/// Whether a fault that [`pretend_file_fault`] has asked for on this thread is still to come.
pub fn file_fault_is_due() -> bool {
    STEPS_LEFT.get() > 0
}

/// Files that another thread writes.
pub(crate) struct Writing<T>(JoinHandle<(T, u64)>);

impl<T: Send + 'static> Writing<T> {
    /// Has `write` write files on a thread of its own, whose faults those of this thread are until it has ended.
    ///
    /// # Errors
    /// The system's error when there is no thread to be had.
    pub fn begin(write: impl FnOnce() -> T + Send + 'static) -> io::Result<Self> {
        let steps = STEPS_LEFT.get();
        let thread = std::thread::Builder::new().name("writing".into()).spawn(move || {
            STEPS_LEFT.set(steps);
            (write(), STEPS_LEFT.get())
        });
        Ok(Self(thread?))
    }

    /// Whether it has ended.
    pub fn has_ended(&self) -> bool {
        self.0.is_finished()
    }

    /// Waits for its end, and returns what came of it.
    pub fn end(self) -> T {
        let (done, steps) = self.0.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        STEPS_LEFT.set(steps);
        done
    }
}

impl<T> fmt::Debug for Writing<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Writing")
    }
}

/// Fails where a test has asked for it.
pub(crate) fn attempt() -> io::Result<()> {
    let left = STEPS_LEFT.get();
    STEPS_LEFT.set(left.saturating_sub(1));
    if left == 1 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
}

/// A file that is being written.
pub(crate) struct Sink<'a>(pub &'a mut File);

impl Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Err(error) = attempt() {
            // Disks that become full have taken some of it.
            let _ = self.0.write_all(&bytes[..bytes.len() / 2]);
            return Err(error);
        }
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
