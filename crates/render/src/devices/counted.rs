//! Work of the CPU's path tracer, counted: unlike time it is the same in every run, whatever else a machine does.

use raggio_kernels::cpu::{Buffers, Counts, CpuScene, InstructionSet, Walk, dispatch};
use raggio_kernels::{EntryPoint, Feature, Work};

use crate::devices::cpu::CpuOptions;
use crate::devices::device::DeviceError;
use crate::pictures::film::Film;
use crate::translation::device_scene::DeviceScene;

/// A picture and what it took.
#[derive(Clone, Debug)]
pub struct Counted {
    /// Film of radiance.
    pub film: Film,
    /// Number of samples in all pixels together.
    pub samples: u64,
    /// Number of rays along them.
    pub rays: u64,
    /// Work of the kernels.
    pub counts: Counts,
    /// Number of shapes that rays try one by one.
    pub tried: u32,
    /// Bytes of the scene as kernels read it.
    pub bytes: usize,
}

impl Counted {
    /// Renders `samples` samples of each pixel of `scene` by the path tracer, on this thread, in tiles like those of a CPU
    /// device with default options, and counts.
    ///
    /// # Errors
    /// A [`DeviceError`] when the scene's indices are wrong, or this processor lacks the level `set`.
    pub fn render(scene: &DeviceScene, set: InstructionSet, walk: Walk, samples: u32) -> Result<Self, DeviceError> {
        if !InstructionSet::available().contains(&set) {
            return Err(DeviceError::Host(format!("this processor cannot run {} code", set.name())));
        }
        let mut on_device = CpuScene::new(scene.buffers.clone(), set, walk)?;
        on_device.settle();
        let (width, tile_rows) = (scene.work.width, CpuOptions::default().tile_rows);
        let mut film = Film::new(width, scene.work.height);
        let mut counts = Counts::default();
        let tiles = film.pixels_mut().chunks_mut((width * tile_rows) as usize);
        for (tile, first_row) in tiles.zip((0..).step_by(tile_rows as usize)) {
            let rows = tile.len() as u32 / width;
            let feature = Feature::Radiance as u32;
            let work = Work { band_row: first_row, first_row, rows, samples, feature, ..scene.work };
            let buffers = Buffers { film: tile, counts: Some(&mut counts), ..Buffers::default() };
            dispatch(set, EntryPoint::Path, Some(&on_device), &work, buffers);
        }
        Ok(Self {
            samples: u64::from(samples) * u64::from(width) * u64::from(scene.work.height),
            rays: film.pixels().iter().map(|pixel| u64::from(pixel.rays)).sum(),
            counts,
            tried: on_device.tried(),
            bytes: on_device.bytes(),
            film,
        })
    }
}
