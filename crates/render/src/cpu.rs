//! The CPU as a device: the kernels compiled to machine code, on all cores.

use std::ops::Range;
use std::sync::Arc;

use raggio_kernels::cpu::{Buffers, CpuScene, InstructionSet, dispatch};
use raggio_kernels::{EntryPoint, FilmPixel, Probe, Work};
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::device::{Answer, Change, Device, DeviceError, DeviceInfo, Pixels, Question, Session};
use crate::device_scene::DeviceScene;
use crate::display::{Display, display_rows};
use crate::film::Film;
use crate::machine::{cores, processor_name, total_memory_bytes};

/// How the CPU is used. No choice changes the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CpuOptions {
    /// Threads; 0 for as many as there are cores.
    pub threads: usize,
    /// Level of instruction set; `None` for the best this processor has.
    pub instruction_set: Option<InstructionSet>,
    /// Rows of the image that a thread takes at a time.
    pub tile_rows: u32,
}

impl Default for CpuOptions {
    fn default() -> Self {
        Self { threads: 0, instruction_set: None, tile_rows: 4 }
    }
}

/// The CPU.
pub struct CpuDevice {
    workers: Arc<Workers>,
}

/// What sessions share.
struct Workers {
    pool: ThreadPool,
    set: InstructionSet,
    tile_rows: u32,
}

impl CpuDevice {
    /// Starts the threads.
    pub fn new(options: CpuOptions) -> Result<Self, DeviceError> {
        let set = options.instruction_set.or_else(InstructionSet::best).ok_or_else(|| {
            DeviceError::Host("this processor is too old: the kernels need x86-64-v2 (SSE4.2, from 2009 on)".into())
        })?;
        if !InstructionSet::available().contains(&set) {
            return Err(DeviceError::Host(format!("this processor cannot run {} code", set.name())));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .build()
            .map_err(|e| DeviceError::Host(format!("cannot start {} threads: {e}", options.threads)))?;
        Ok(Self { workers: Arc::new(Workers { pool, set, tile_rows: options.tile_rows.max(1) }) })
    }

    /// Its line in the list of devices.
    pub fn info() -> DeviceInfo {
        DeviceInfo {
            id: "cpu".into(),
            name: processor_name(),
            kind: "processor",
            driver: match InstructionSet::best() {
                Some(set) => format!("{} cores, {} kernels", cores(), set.name()),
                None => format!("{} cores", cores()),
            },
            memory_bytes: total_memory_bytes(),
            missing: if InstructionSet::best().is_some() { vec![] } else { vec!["x86-64-v2".into()] },
        }
    }
}

impl Device for CpuDevice {
    fn name(&self) -> String {
        let Workers { pool, set, .. } = &*self.workers;
        format!("{} (cpu, {} threads, {})", processor_name(), pool.current_num_threads(), set.name())
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        Ok(Box::new(CpuSession {
            workers: self.workers.clone(),
            scene: CpuScene::new(scene.buffers.clone())?,
            work: scene.work,
            film: Film::new(scene.work.width, scene.work.height),
        }))
    }
}

struct CpuSession {
    workers: Arc<Workers>,
    scene: CpuScene,
    work: Work,
    film: Film,
}

impl Session for CpuSession {
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        let Self { workers, scene, work, film } = self;
        let width = work.width as usize;
        let band = &mut film.pixels_mut()[rows.start as usize * width..rows.end as usize * width];
        let tile_rows = workers.tile_rows;
        workers.pool.install(|| {
            band.par_chunks_mut(width * tile_rows as usize).enumerate().for_each(|(i, tile)| {
                let first_row = rows.start + i as u32 * tile_rows;
                let work = Work {
                    band_row: first_row,
                    first_row,
                    rows: (tile.len() / width) as u32,
                    first_sample: samples.start,
                    samples: samples.len() as u32,
                    ..*work
                };
                let buffers = Buffers { film: tile, ..Buffers::default() };
                dispatch(workers.set, EntryPoint::Render, Some(scene), &work, buffers);
            });
        });
        Ok(())
    }

    fn restart(&mut self, scene: &DeviceScene, change: Change) -> Result<(), DeviceError> {
        match change {
            Change::View => self.scene.set_view(&scene.buffers)?,
            Change::Scene => self.scene = CpuScene::new(scene.buffers.clone())?,
        }
        self.work = scene.work;
        self.film = Film::new(scene.work.width, scene.work.height);
        Ok(())
    }

    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError> {
        let Self { workers, work, film, .. } = self;
        let tile = (work.width * workers.tile_rows) as usize;
        let mut pixels = vec![0; film.pixels().len()];
        workers.pool.install(|| {
            let tiles = film.pixels_mut().par_chunks_mut(tile).zip(pixels.par_chunks_mut(tile));
            tiles.for_each(|(film, pixels)| display_rows(film, work.width, display, workers.set, pixels));
        });
        Ok(Pixels::Host(pixels))
    }

    fn pixel(&self, x: u32, y: u32) -> Result<FilmPixel, DeviceError> {
        Ok(self.film.pixels()[(y * self.work.width + x) as usize])
    }

    fn film(&self) -> Result<Film, DeviceError> {
        Ok(self.film.clone())
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        let mut output = vec![0u32; 12 * questions.len()];
        let work = Work { probe: probe as u32, count: questions.len() as u32, ..self.work };
        let input = bytemuck::cast_slice(questions);
        let buffers = Buffers { output: &mut output, input, ..Buffers::default() };
        dispatch(self.workers.set, EntryPoint::Probe, Some(&self.scene), &work, buffers);
        Ok(bytemuck::allocation::pod_collect_to_vec(&output))
    }

    fn patience_seconds(&self) -> f64 {
        // Long enough that waiting for the last tile costs nothing, short enough for a lively progress bar.
        0.2
    }
}
