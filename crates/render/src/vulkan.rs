//! A Vulkan device.

use std::ops::Range;
use std::sync::Arc;

use raggio_kernels::{
    EntryPoint, FILM_BINDING, FilmPixel, INPUT_BINDING, OUTPUT_BINDING, Probe, SCENE_BINDINGS, SCENE_SET, SPIRV, Work,
};
use raggio_vulkan::{BindingSet, Buffer, Device as VulkanContext, Module, PhysicalDevice, Pipeline};

use crate::device::{Answer, Device, DeviceError, Question, Session};
use crate::device_scene::DeviceScene;
use crate::film::Film;

// `raggio devices` calls a device fit by this number.
const _: () = assert!(SCENE_BINDINGS.len() + 3 <= raggio_vulkan::STORAGE_BUFFERS as usize);

/// Set 0 holds what kernels write; the other is the scene's.
const BUFFER_SET: u32 = 0;
/// Most bytes of film in one buffer: drivers allow at least 128 MiB, and a gigabyte in one piece may not be free.
const BAND_BYTES: u64 = 64 << 20;

/// A GPU, or a software Vulkan driver.
pub struct VulkanDevice {
    context: Arc<VulkanContext>,
    module: Arc<Module>,
    render: Pipeline,
    probe: Pipeline,
}

impl VulkanDevice {
    /// Opens `physical` and compiles the kernels for it.
    pub fn new(physical: &PhysicalDevice) -> Result<Self, DeviceError> {
        let context = VulkanContext::new(physical)?;
        let mut bindings = vec![Vec::new(); 2];
        bindings[BUFFER_SET as usize] = vec![FILM_BINDING, OUTPUT_BINDING, INPUT_BINDING];
        bindings[SCENE_SET as usize] = SCENE_BINDINGS.to_vec();
        let module = Module::new(&context, SPIRV, &bindings, size_of::<Work>() as u32)?;
        let render = module.pipeline(EntryPoint::Render.name())?;
        let probe = module.pipeline(EntryPoint::Probe.name())?;
        Ok(Self { context, module, render, probe })
    }
}

impl Device for VulkanDevice {
    fn name(&self) -> String {
        let physical = self.context.physical();
        format!("{} (vulkan:{})", physical.name, physical.index)
    }

    fn validation_messages(&self) -> Vec<String> {
        self.context.physical().instance().validation_messages()
    }

    fn load<'a>(&'a self, scene: &DeviceScene) -> Result<Box<dyn Session + 'a>, DeviceError> {
        scene.buffers.check()?;
        let buffers = SCENE_BINDINGS
            .iter()
            .zip(scene.buffers.bytes())
            .map(|(&binding, b)| Ok((binding, Arc::new(Buffer::with_bytes(&self.context, b.name, b.bytes)?))))
            .collect::<Result<Vec<_>, DeviceError>>()?;
        let scene_set = self.module.bind(SCENE_SET, &buffers)?;

        let Work { width, height, .. } = scene.work;
        let row_bytes = u64::from(width) * size_of::<FilmPixel>() as u64;
        let band_rows = (BAND_BYTES / row_bytes).max(1).min(u64::from(height)) as u32;
        let bands = (0..height)
            .step_by(band_rows as usize)
            .map(|first| {
                let rows = first..height.min(first + band_rows);
                let size = row_bytes * rows.len() as u64;
                let film = Arc::new(Buffer::zeroed(&self.context, "film", size)?);
                let set = self.module.bind(BUFFER_SET, &[(FILM_BINDING, film.clone())])?;
                Ok(Band { rows, film, set })
            })
            .collect::<Result<Vec<_>, DeviceError>>()?;
        Ok(Box::new(VulkanSession { device: self, work: scene.work, scene_set, bands }))
    }
}

/// A run of rows of the film, in a buffer of its own.
struct Band {
    rows: Range<u32>,
    film: Arc<Buffer>,
    set: BindingSet,
}

struct VulkanSession<'a> {
    device: &'a VulkanDevice,
    work: Work,
    scene_set: BindingSet,
    bands: Vec<Band>,
}

impl Session for VulkanSession<'_> {
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        for band in &self.bands {
            let first = rows.start.max(band.rows.start);
            let end = rows.end.min(band.rows.end);
            if first >= end {
                continue;
            }
            let work = Work {
                band_row: band.rows.start,
                first_row: first,
                rows: end - first,
                first_sample: samples.start,
                samples: samples.len() as u32,
                ..self.work
            };
            let groups = EntryPoint::Render.groups(&work);
            let sets = [&band.set, &self.scene_set];
            self.device.context.run(|passes| {
                passes.compute(&self.device.render, &sets, bytemuck::bytes_of(&work), groups);
            })?;
        }
        Ok(())
    }

    fn film(&self) -> Result<Film, DeviceError> {
        let mut pixels = Vec::with_capacity(self.work.width as usize * self.work.height as usize);
        for band in &self.bands {
            pixels.extend(bytemuck::allocation::pod_collect_to_vec::<u8, FilmPixel>(&band.film.read()?));
        }
        Ok(Film::from_pixels(self.work.width, self.work.height, pixels))
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        let context = &self.device.context;
        let work = Work { probe: probe as u32, count: questions.len() as u32, ..self.work };
        let input = Arc::new(Buffer::with_bytes(context, "questions", bytemuck::cast_slice(questions))?);
        let output = Arc::new(Buffer::zeroed(context, "answers", size_of_val(questions) as u64)?);
        let set = self.device.module.bind(BUFFER_SET, &[(INPUT_BINDING, input), (OUTPUT_BINDING, output.clone())])?;
        let sets = [&set, &self.scene_set];
        let groups = EntryPoint::Probe.groups(&work);
        context.run(|passes| passes.compute(&self.device.probe, &sets, bytemuck::bytes_of(&work), groups))?;
        Ok(bytemuck::allocation::pod_collect_to_vec(&output.read()?))
    }

    fn patience_seconds(&self) -> f64 {
        // A desktop drawn by the same device stays usable, and no driver's watchdog wakes up.
        0.05
    }
}
