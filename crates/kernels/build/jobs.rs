//! Compilers side by side, as many at once as cargo was told.

use std::sync::{Condvar, Mutex};

/// Number of compilers that may still be started.
pub struct Jobs {
    free: Mutex<usize>,
    freed: Condvar,
}

impl Jobs {
    /// Makes room for as many compilers as `cargo build --jobs` says.
    pub fn from_cargo() -> Self {
        let count = std::env::var("NUM_JOBS").ok().and_then(|count| count.parse().ok());
        Self { free: Mutex::new(count.unwrap_or(1).max(1)), freed: Condvar::new() }
    }

    /// Runs `compiler` once one of those that run has ended, and returns what it returns.
    pub fn run<T>(&self, compiler: impl FnOnce() -> T) -> T {
        let free = self.free.lock().expect("no compiler panics");
        *self.freed.wait_while(free, |free| *free == 0).expect("no compiler panics") -= 1;
        let result = compiler();
        *self.free.lock().expect("no compiler panics") += 1;
        self.freed.notify_one();
        result
    }

    /// Runs all of `compilers`, side by side as far as there is room, and returns their first failure.
    pub fn run_all<F>(&self, compilers: impl IntoIterator<Item = F>) -> Result<(), String>
    where
        F: FnOnce() -> Result<(), String> + Send,
    {
        std::thread::scope(|scope| {
            let threads: Vec<_> = compilers.into_iter().map(|compiler| scope.spawn(|| self.run(compiler))).collect();
            let results = threads.into_iter().map(|thread| thread.join().expect("compiling does not panic"));
            results.collect::<Vec<_>>().into_iter().collect()
        })
    }
}
