//! The CPU as a device: the kernels compiled to machine code, on all cores.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use raggio_kernels::cpu::{Buffers, COMPILER, CpuScene, InstructionSet, Walk, dispatch};
use raggio_kernels::{EntryPoint, Feature, FilmPixel, Probe, Work};
use rayon::ThreadPool;
use rayon::prelude::*;

use raggio_scene::{Integrator, counted};

use crate::devices::adaptive::Blocks;
use crate::devices::device::{Answer, Device, DeviceError, DeviceInfo, Question, Session, sampling};
use crate::devices::films::Films;
use crate::devices::machine::{cores, processor_name, total_memory_bytes};
use crate::devices::tracer::Tracer;
use crate::pictures::display::{Display, Pixels, display_rows, reference_pixels};
use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;
use crate::translation::device_scene::DeviceScene;

/// Options of the CPU. None of them changes the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CpuOptions {
    /// Number of threads; 0 for as many as there are cores. Where there are fewer cores, 64 at most are started.
    pub threads: usize,
    /// Level of instruction set; `None` for the best this processor has.
    pub instruction_set: Option<InstructionSet>,
    /// Rows of the image that a thread takes at a time.
    pub tile_rows: u32,
    /// Way of rays through the hierarchies.
    pub walk: Walk,
}

impl Default for CpuOptions {
    fn default() -> Self {
        Self { threads: 0, instruction_set: None, tile_rows: 4, walk: Walk::default() }
    }
}

/// Most threads on machines with fewer cores: what a thread too many takes is memory, and time to start it.
const MOST_THREADS: usize = 64;

/// The CPU as a device.
pub struct CpuDevice {
    workers: Arc<Workers>,
}

/// Threads and options, which all sessions share.
struct Workers {
    pool: ThreadPool,
    set: InstructionSet,
    tile_rows: u32,
    walk: Walk,
}

impl Workers {
    fn threads(&self) -> u32 {
        self.pool.current_num_threads() as u32
    }
}

impl CpuDevice {
    /// Starts the threads.
    ///
    /// # Errors
    /// A [`DeviceError::Host`] when the processor lacks the instruction set, or the system refuses threads.
    pub fn new(options: CpuOptions) -> Result<Self, DeviceError> {
        let set = options.instruction_set.or_else(InstructionSet::best).ok_or_else(|| {
            DeviceError::Host("this processor is too old: the kernels need x86-64-v2 (SSE4.2, from 2009 on)".into())
        })?;
        if !InstructionSet::available().contains(&set) {
            return Err(DeviceError::Host(format!("this processor cannot run {} code", set.name())));
        }
        let threads = if options.threads == 0 { cores() } else { options.threads.min(cores().max(MOST_THREADS)) };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| DeviceError::Host(format!("cannot start {}: {e}", counted(threads, "thread"))))?;
        Ok(Self { workers: Arc::new(Workers { pool, set, tile_rows: options.tile_rows.max(1), walk: options.walk }) })
    }

    /// Line of the CPU in the list of devices.
    pub fn info() -> DeviceInfo {
        DeviceInfo {
            id: "cpu".into(),
            name: processor_name(),
            kind: "processor",
            driver: match InstructionSet::best() {
                Some(set) => format!("{}, {} kernels by {COMPILER}", counted(cores(), "core"), set.name()),
                None => counted(cores(), "core"),
            },
            memory_bytes: total_memory_bytes(),
            missing: if InstructionSet::best().is_some() { vec![] } else { vec!["x86-64-v2".into()] },
            has_ray_queries: false,
            tracer: Tracer::Software,
        }
    }
}

impl Device for CpuDevice {
    fn name(&self) -> String {
        let Workers { pool, set, .. } = &*self.workers;
        format!("{} (cpu, {}, {})", processor_name(), counted(pool.current_num_threads(), "thread"), set.name())
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        let Workers { pool, set, walk, .. } = &*self.workers;
        Ok(Box::new(CpuSession {
            workers: self.workers.clone(),
            scene: pool.install(|| CpuScene::new(scene.buffers.clone(), *set, *walk))?,
            work: scene.work,
            integrator: scene.settings.integrator,
            resting: vec![],
            films: Films::new(Film::new(scene.work.width, scene.work.height)),
            reference: vec![],
        }))
    }
}

struct CpuSession {
    workers: Arc<Workers>,
    scene: CpuScene,
    work: Work,
    integrator: Integrator,
    resting: Vec<u32>,
    films: Films<Film>,
    /// Pixels of the reference image, as many as a film has, or none.
    reference: Vec<[f32; 4]>,
}

impl Session for CpuSession {
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        self.films.show(feature, || Ok(Film::new(self.work.width, self.work.height)))
    }

    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError> {
        let Self { workers, scene, work, integrator, films, resting, .. } = self;
        let feature = films.feature();
        let entry = sampling(*integrator, feature);
        let width = work.width as usize;
        let band = &mut films.shown_mut().pixels_mut()[rows.start as usize * width..rows.end as usize * width];
        // A few rows are shared by all threads too.
        let tile_rows = workers.tile_rows.min(rows.len() as u32 / workers.threads()).max(1);
        // Tiles are taken in their order, so that those that are done when work stops are the first ones.
        let tiles =
            Mutex::new(band.chunks_mut(width * tile_rows as usize).zip((rows.start..).step_by(tile_rows as usize)));
        let done = AtomicU32::new(0);
        workers.pool.broadcast(|_| {
            loop {
                let next = {
                    let mut tiles = tiles.lock().unwrap_or_else(PoisonError::into_inner);
                    let may_stop = done.load(Ordering::Relaxed) > 0 && stop();
                    if may_stop { None } else { tiles.next() }
                };
                let Some((tile, first_row)) = next else { break };
                let work = Work {
                    band_row: first_row,
                    first_row,
                    rows: (tile.len() / width) as u32,
                    first_sample: samples.start,
                    samples: samples.len() as u32,
                    feature: feature as u32,
                    filter: feature.filter(work.filter),
                    adaptive: u32::from(!resting.is_empty()),
                    ..*work
                };
                let buffers = Buffers { film: tile, resting, ..Buffers::default() };
                dispatch(workers.set, entry, Some(scene), &work, buffers);
                done.fetch_add(work.rows, Ordering::Relaxed);
            }
        });
        Ok(done.into_inner())
    }

    fn set_film(&mut self, film: &Film) -> Result<(), DeviceError> {
        self.films.shown_mut().pixels_mut().copy_from_slice(film.pixels());
        Ok(())
    }

    fn rest(&mut self, blocks: Option<&Blocks>) -> Result<(), DeviceError> {
        self.resting = blocks.map(|blocks| blocks.words().to_vec()).unwrap_or_default();
        Ok(())
    }

    fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        self.workers.pool.install(|| self.scene.renew(scene.buffers.clone()))?;
        if (self.work.width, self.work.height) != (scene.work.width, scene.work.height) {
            self.reference = vec![];
        }
        self.work = scene.work;
        self.integrator = scene.settings.integrator;
        self.resting = vec![];
        self.films.renew(|| Ok(Film::new(scene.work.width, scene.work.height)))
    }

    fn settle(&mut self) {
        self.scene.settle();
    }

    fn set_reference(&mut self, reference: Option<&Image>) -> Result<(), DeviceError> {
        let Work { width, height, .. } = self.work;
        self.reference = reference.map(|image| reference_pixels(image, width, height)).unwrap_or_default();
        Ok(())
    }

    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError> {
        let Self { workers, work, films, reference, .. } = self;
        let film = films.shown_mut().pixels_mut();
        let tile = (work.width * workers.tile_rows) as usize;
        let mut pixels = bytemuck::zeroed_vec(film.len());
        workers.pool.install(|| {
            let tiles = film.par_chunks_mut(tile).zip(pixels.par_chunks_mut(tile)).enumerate();
            tiles.for_each(|(i, (film, pixels))| {
                let reference = reference.chunks(tile).nth(i).unwrap_or_default();
                display_rows(film, reference, work.width, display, workers.set, pixels);
            });
        });
        Ok(Pixels::Host(pixels))
    }

    fn pixels(&self, columns: Range<u32>, y: u32) -> Result<Vec<FilmPixel>, DeviceError> {
        let place = |x: u32| (y * self.work.width + x) as usize;
        Ok(self.films.shown().pixels()[place(columns.start)..place(columns.end)].to_vec())
    }

    fn film(&self) -> Result<Film, DeviceError> {
        Ok(self.films.shown().clone())
    }

    fn take_film(&mut self) -> Result<Film, DeviceError> {
        Ok(std::mem::replace(self.films.shown_mut(), Film::new(0, 0)))
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        let mut output = vec![0u32; 12 * questions.len()];
        let work = Work { probe: probe as u32, count: questions.len() as u32, ..self.work };
        let input = bytemuck::cast_slice(questions);
        let buffers = Buffers { output: &mut output, input, ..Buffers::default() };
        dispatch(self.workers.set, EntryPoint::Probe, Some(&self.scene), &work, buffers);
        Ok(bytemuck::allocation::pod_collect_to_vec(&output))
    }

    fn rows_at_once(&self) -> u32 {
        self.workers.threads()
    }

    fn patience_seconds(&self) -> f64 {
        // Long enough that waiting for the last tile costs nothing, short enough for a lively progress bar.
        0.2
    }
}
