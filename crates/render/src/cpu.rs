//! The CPU as a device: the kernels compiled to machine code, on all cores.

use std::ops::Range;

use raggio_kernels::cpu::{Buffers, CpuScene, InstructionSet, dispatch};
use raggio_kernels::{EntryPoint, Probe, Work};
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::device::{Answer, Device, DeviceError, DeviceInfo, Question, Session};
use crate::device_scene::DeviceScene;
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
        Ok(Self { pool, set, tile_rows: options.tile_rows.max(1) })
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
        format!("{} (cpu, {} threads, {})", processor_name(), self.pool.current_num_threads(), self.set.name())
    }

    fn load<'a>(&'a self, scene: &DeviceScene) -> Result<Box<dyn Session + 'a>, DeviceError> {
        Ok(Box::new(CpuSession {
            device: self,
            scene: CpuScene::new(scene.buffers.clone())?,
            work: scene.work,
            film: Film::new(scene.work.width, scene.work.height),
        }))
    }
}

struct CpuSession<'a> {
    device: &'a CpuDevice,
    scene: CpuScene,
    work: Work,
    film: Film,
}

impl Session for CpuSession<'_> {
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        let Self { device, scene, work, film } = self;
        let width = work.width as usize;
        let band = &mut film.pixels_mut()[rows.start as usize * width..rows.end as usize * width];
        let tile_rows = device.tile_rows;
        device.pool.install(|| {
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
                dispatch(device.set, EntryPoint::Render, Some(scene), &work, buffers);
            });
        });
        Ok(())
    }

    fn film(&self) -> Result<Film, DeviceError> {
        Ok(self.film.clone())
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        let mut output = vec![0u32; 12 * questions.len()];
        let work = Work { probe: probe as u32, count: questions.len() as u32, ..self.work };
        let input = bytemuck::cast_slice(questions);
        let buffers = Buffers { output: &mut output, input, ..Buffers::default() };
        dispatch(self.device.set, EntryPoint::Probe, Some(&self.scene), &work, buffers);
        Ok(bytemuck::allocation::pod_collect_to_vec(&output))
    }

    fn patience_seconds(&self) -> f64 {
        // Long enough that waiting for the last tile costs nothing, short enough for a lively progress bar.
        0.2
    }
}
