//! Pipelines that are compiled once, on any thread, and what is kept of them for the next time.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use raggio_kernels::Spirv;
use raggio_vulkan::{Device as VulkanContext, Pipeline, PipelineCache, VulkanError};

use crate::devices::device::DeviceError;
use crate::devices::kept::KeptPipelines;

/// Place of a pipeline, which is compiled once: whoever needs it meanwhile waits.
pub(crate) struct Place<T = Pipeline> {
    state: Mutex<State<T>>,
    has_run: AtomicBool,
}

enum State<T> {
    Empty,
    Made(Arc<T>),
    /// Error of a thread that compiled ahead, for the first who needs the pipeline.
    Failed(DeviceError),
}

impl<T> Default for Place<T> {
    fn default() -> Self {
        Self { state: Mutex::new(State::Empty), has_run: AtomicBool::new(false) }
    }
}

impl<T> Place<T> {
    /// The pipeline, which `make` makes if nobody has before.
    ///
    /// # Errors
    /// That of `make`, also where somebody else has called it ahead.
    pub fn get(&self, make: impl FnOnce() -> Result<T, DeviceError>) -> Result<Arc<T>, DeviceError> {
        let mut state = self.lock();
        let pipeline = match std::mem::replace(&mut *state, State::Empty) {
            State::Made(pipeline) => pipeline,
            State::Failed(error) => return Err(error),
            State::Empty => Arc::new(make()?),
        };
        *state = State::Made(pipeline.clone());
        Ok(pipeline)
    }

    /// Makes the pipeline for whoever needs it later, unless there is one.
    pub fn fill(&self, make: impl FnOnce() -> Result<T, DeviceError>) {
        let mut state = self.lock();
        if matches!(*state, State::Empty) {
            *state = make().map_or_else(State::Failed, |pipeline| State::Made(Arc::new(pipeline)));
        }
    }

    /// Whether [`Place::get`] has an answer without any wait.
    pub fn is_filled(&self) -> bool {
        self.now().is_some_and(|state| !matches!(*state, State::Empty))
    }

    /// Whether nobody has made the pipeline yet, or is making it.
    pub fn is_idle(&self) -> bool {
        self.now().is_some_and(|state| matches!(*state, State::Empty))
    }

    /// Has `run` run the pipeline, unless it has run before: some drivers compile only then.
    ///
    /// # Errors
    /// That of `run`; it will be called again.
    pub fn warm_up(&self, run: impl FnOnce() -> Result<(), DeviceError>) -> Result<(), DeviceError> {
        if !self.has_run() {
            run()?;
            self.has_run.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Whether the pipeline has run.
    pub fn has_run(&self) -> bool {
        self.has_run.load(Ordering::Relaxed)
    }

    /// The state, unless somebody is making the pipeline.
    fn now(&self) -> Option<MutexGuard<'_, State<T>>> {
        match self.state.try_lock() {
            Ok(state) => Some(state),
            Err(TryLockError::Poisoned(state)) => Some(state.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Store of all that a driver has compiled, in memory and in a file, and the time that compiling has taken.
#[derive(Default)]
pub(crate) struct Store {
    file: Option<(KeptPipelines, PipelineCache)>,
    work: Mutex<Work>,
}

/// Compiling that is under way, and that is over.
#[derive(Default)]
struct Work {
    /// Number of pipelines that are being compiled, and the moment at which the first of them was begun.
    active: Option<(usize, Instant)>,
    /// Time in which at least one pipeline was being compiled.
    total: Duration,
    /// Bytes that the file has at least: drivers only ever add to them.
    kept: usize,
    /// Thread that writes the file.
    writer: Option<JoinHandle<()>>,
}

impl Store {
    /// Store of what `context` compiles of `kernels`, with a file in `folder`.
    ///
    /// # Errors
    /// A [`DeviceError::Vulkan`] when the device is lost.
    pub fn new(context: &Arc<VulkanContext>, kernels: &Spirv, folder: Option<&Path>) -> Result<Self, DeviceError> {
        let Some(folder) = folder else { return Ok(Self::default()) };
        let file = KeptPipelines::new(folder, context.physical().compiler(), kernels);
        let data = file.read().unwrap_or_default();
        // A driver may refuse what another of its version has written.
        let cache = match PipelineCache::new(context, &data) {
            Err(error) if !data.is_empty() && !matches!(error, VulkanError::DeviceLost) => {
                PipelineCache::new(context, &[])
            }
            cache => cache,
        };
        match cache {
            Ok(cache) => {
                Ok(Self { file: Some((file, cache)), work: Mutex::new(Work { kept: data.len(), ..Work::default() }) })
            }
            Err(VulkanError::DeviceLost) => Err(VulkanError::DeviceLost.into()),
            // It works without, and takes longer.
            Err(_) => Ok(Self::default()),
        }
    }

    /// Compiles a pipeline by `make`, which is given the driver's own store. When nobody compiles any more, what is new is
    /// written to the file.
    pub fn compile<T>(&self, make: impl FnOnce(Option<&PipelineCache>) -> T) -> T {
        self.lock().active.get_or_insert((0, Instant::now())).0 += 1;
        let made = make(self.file.as_ref().map(|(_, cache)| cache));
        let mut work = self.lock();
        work.active = match work.active {
            Some((1, since)) => {
                work.total += since.elapsed();
                self.save(&mut work);
                None
            }
            active => active.map(|(count, since)| (count - 1, since)),
        };
        made
    }

    /// Time in which at least one pipeline was being compiled.
    pub fn time(&self) -> Duration {
        let work = self.lock();
        work.total + work.active.map_or(Duration::ZERO, |(_, since)| since.elapsed())
    }

    /// Writes the file, on a thread of its own, if there is more than it has. Whatever fails costs no more than time.
    fn save(&self, work: &mut Work) {
        let Some((file, cache)) = &self.file else { return };
        let Ok(data) = cache.data() else { return };
        if data.len() <= work.kept {
            return;
        }
        // What another process has written meanwhile stays.
        let others = file.read().filter(|others| others.len() != work.kept && *others != data);
        let data = match others {
            Some(others) => match cache.merge(&others).and_then(|()| cache.data()) {
                Ok(data) => data,
                Err(_) => return,
            },
            None => data,
        };
        work.kept = data.len();
        finish(work.writer.take());
        let file = file.clone();
        let writer = std::thread::Builder::new().name("pipelines".into());
        work.writer = writer.spawn(move || drop(file.write(&data))).ok();
    }

    fn lock(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        finish(self.lock().writer.take());
    }
}

/// Threads that compile ahead of need. Whoever drops them waits until they are done, for no driver bears it that the program
/// ends under it.
#[derive(Default)]
pub(crate) struct Ahead(Mutex<Vec<JoinHandle<()>>>);

impl Ahead {
    /// Has a thread do `work`. Where the machine has none to spare, the work is left to who needs it.
    pub fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        let mut threads = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        threads.retain(|thread| !thread.is_finished());
        threads.extend(std::thread::Builder::new().name("compiler".into()).spawn(work));
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        let threads = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        threads.drain(..).for_each(|thread| finish(Some(thread)));
    }
}

fn finish(thread: Option<JoinHandle<()>>) {
    // A panic has been told when it happened.
    let _ = thread.map(JoinHandle::join);
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::AtomicU32;

    use super::*;

    fn lost() -> DeviceError {
        VulkanError::DeviceLost.into()
    }

    #[test]
    fn what_many_want_is_made_once() {
        let (place, made, start) = (Place::default(), AtomicU32::new(0), Barrier::new(8));
        let make = || {
            // Long enough for all of them to come meanwhile.
            std::thread::sleep(Duration::from_millis(50));
            Ok(made.fetch_add(1, Ordering::Relaxed))
        };
        std::thread::scope(|scope| {
            for i in 0..8 {
                let (place, start, make) = (&place, &start, &make);
                scope.spawn(move || {
                    start.wait();
                    if i % 2 == 0 { place.fill(make) } else { assert_eq!(*place.get(make).expect("it is made"), 0) }
                });
            }
        });
        assert_eq!(made.into_inner(), 1);
        assert!(place.is_filled() && !place.is_idle());
    }

    #[test]
    fn while_it_is_made_it_is_neither_there_nor_idle() {
        let (place, begun, goes_on) = (Place::default(), Barrier::new(2), Barrier::new(2));
        assert!(place.is_idle() && !place.is_filled());
        std::thread::scope(|scope| {
            scope.spawn(|| {
                place.fill(|| {
                    begun.wait();
                    goes_on.wait();
                    Ok(7)
                });
            });
            begun.wait();
            assert!(!place.is_idle() && !place.is_filled());
            goes_on.wait();
            assert_eq!(*place.get(|| unreachable!("it is being made")).expect("it is made"), 7);
        });
    }

    #[test]
    fn a_failure_ahead_is_told_once_to_who_needs_it() {
        let place = Place::default();
        place.fill(|| Err(lost()));
        // Nobody tries again behind the back of who is to hear of it.
        place.fill(|| Ok(1));
        assert!(place.is_filled());
        assert!(matches!(place.get(|| Ok(2)), Err(DeviceError::Vulkan(VulkanError::DeviceLost))));
        assert!(place.get(|| Err(lost())).is_err() && place.is_idle());
        assert_eq!(*place.get(|| Ok(3)).expect("it is made"), 3);
    }

    #[test]
    fn what_has_failed_to_run_runs_again() {
        let place = Place::<u32>::default();
        assert!(place.warm_up(|| Err(lost())).is_err() && !place.has_run());
        assert!(place.warm_up(|| Ok(())).is_ok() && place.has_run());
        place.warm_up(|| unreachable!("it has run")).expect("nothing is done");
    }

    /// Time counts once, however many compile at once.
    #[test]
    fn time_is_that_in_which_anything_is_compiled() {
        let store = Store::default();
        let nap = Duration::from_millis(100);
        let start = Instant::now();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| store.compile(|_| std::thread::sleep(nap)));
            }
        });
        let together = store.time();
        assert!(together >= nap && together <= start.elapsed(), "{together:?}");
        std::thread::sleep(nap);
        assert_eq!(store.time(), together);
        assert!(store.compile(|cache| cache.is_none()));
    }

    #[test]
    fn whoever_drops_threads_waits_for_them() {
        let (ahead, done) = (Ahead::default(), Arc::new(AtomicU32::new(0)));
        for _ in 0..3 {
            let done = done.clone();
            ahead.spawn(move || {
                std::thread::sleep(Duration::from_millis(30));
                done.fetch_add(1, Ordering::Relaxed);
            });
        }
        drop(ahead);
        assert_eq!(done.load(Ordering::Relaxed), 3);
    }
}
