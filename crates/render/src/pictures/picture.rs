//! A picture as it comes out of a render.

use raggio_denoise::{DenoiseError, Denoiser, Gpu, Noisy};
use raggio_vulkan::DeviceKind;

use crate::devices::device::Device;
use crate::pictures::display::Display;
use crate::pictures::film::Film;
use crate::pictures::image_file::{Extras, ImageFile, OutputError};
use crate::pictures::linear_image::Image;
use crate::pictures::metadata::Metadata;

/// A film with what is told beside it.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Film of radiance.
    pub film: Film,
    /// Layers, and how the picture was made.
    pub extras: Extras,
    /// Guides of the denoiser, if they were asked for.
    pub(crate) guides: Option<Guides>,
}

/// First surfaces of a picture, row by row from the top left, with the noise of edges.
#[derive(Clone, Debug)]
pub(crate) struct Guides {
    /// Colours, black where there is no surface.
    pub albedos: Vec<[f32; 3]>,
    /// Normals, 0 where there is no surface.
    pub normals: Vec<[f32; 3]>,
}

/// GPU of `device`, for denoisers to [prefer](Denoiser::prefer), if that is one.
pub fn gpu_of(device: &dyn Device) -> Option<Gpu> {
    let vulkan = device.vulkan()?;
    let physical = vulkan.physical();
    let is_gpu = physical.kind != DeviceKind::Software;
    is_gpu.then(|| Gpu { name: physical.name.clone(), uuid: physical.uuid, luid: physical.luid })
}

impl Picture {
    /// Picture of a film that was read from a file: without layers, and with the metadata that the film knows.
    pub fn of_film(film: Film) -> Self {
        let metadata = Metadata::of_film(&film);
        Self { film, extras: Extras { channels: vec![], metadata }, guides: None }
    }

    /// Writes the picture, whole or not at all; PNGs are made as `display` says.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write(&self, file: &ImageFile, display: Display) -> Result<(), OutputError> {
        file.write_with(&self.film, display, &self.extras)
    }

    /// The picture without its noise, and without its layers, which have none. Alpha stays as it is. Guides, if there are any, keep its edges.
    ///
    /// # Errors
    /// A [`DenoiseError`] when the library fails.
    pub fn denoised(&self, denoiser: &Denoiser) -> Result<Self, DenoiseError> {
        let mean = self.film.mean();
        let [width, height] = [mean.width, mean.height].map(|side| side as usize);
        let guides = match &self.guides {
            Some(Guides { albedos, normals }) => Some(denoiser.guides([width, height], albedos, normals)?),
            None => None,
        };
        let noisy = Noisy { width, height, color: &mean.pixels, guides: guides.as_ref() };
        let pixels = denoiser.denoise(noisy)?;
        let mut metadata = self.extras.metadata.clone();
        if let Some(metadata) = &mut metadata {
            metadata.denoiser = Some(denoiser.name());
        }
        let film = Film::from_image(&Image { pixels, ..mean });
        Ok(Self { film, extras: Extras { channels: vec![], metadata }, guides: None })
    }
}
