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
#[derive(Default)]
pub(crate) struct Place {
    state: Mutex<State>,
    has_run: AtomicBool,
}

#[derive(Default)]
enum State {
    #[default]
    Empty,
    Made(Arc<Pipeline>),
    /// Error of a thread that compiled ahead, for the first who needs the pipeline.
    Failed(DeviceError),
}

impl Place {
    /// The pipeline, which `make` makes if nobody has before.
    ///
    /// # Errors
    /// That of `make`, also where somebody else has called it ahead.
    pub fn get(&self, make: impl FnOnce() -> Result<Pipeline, DeviceError>) -> Result<Arc<Pipeline>, DeviceError> {
        let mut state = self.lock();
        let pipeline = match std::mem::take(&mut *state) {
            State::Made(pipeline) => pipeline,
            State::Failed(error) => return Err(error),
            State::Empty => Arc::new(make()?),
        };
        *state = State::Made(pipeline.clone());
        Ok(pipeline)
    }

    /// Makes the pipeline for whoever needs it later, unless there is one.
    pub fn fill(&self, make: impl FnOnce() -> Result<Pipeline, DeviceError>) {
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
    fn now(&self) -> Option<MutexGuard<'_, State>> {
        match self.state.try_lock() {
            Ok(state) => Some(state),
            Err(TryLockError::Poisoned(state)) => Some(state.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
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
