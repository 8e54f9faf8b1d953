//! The film of radiance without its noise, in memory that the device and the denoiser have in common.

use std::sync::Arc;

use raggio_denoise::{Care, DenoiseError, Denoiser, SHARED_PIXEL_BYTES, SharedImage, SharedImages, SharedPicture};
use raggio_kernels::{
    Comparison, EntryPoint, FILM_BINDING, Feature, OUTPUT_BINDING, Specialization, Variant, View, Work,
};
use raggio_vulkan::{BindingSet, Buffer, Pipeline};

use super::{Band, Kernel, Kernels, Output, Resident, VulkanSession};
use crate::devices::device::DeviceError;
use crate::pictures::aov::Features;
use crate::pictures::display::{Denoised, Display, Pixels};

/// Samples that each pixel of the guides gets: it is edges alone that are noisy.
const GUIDE_SAMPLES: u32 = 16;

/// Images that device and denoiser share, and the films of the guides.
pub(super) struct Noiseless {
    picture: SharedPicture,
    /// Sets that make means of the film of radiance, band by band.
    means: Vec<BindingSet>,
    guides: [Guide; 2],
    /// Samples of each pixel of the guides; 0 where they are of another view.
    samples: u32,
    output: Output,
}

/// Film of a guide, and the sets that make means of it, band by band.
struct Guide {
    feature: Feature,
    bands: Vec<Band>,
    means: Vec<BindingSet>,
}

impl Noiseless {
    /// Makes images and films for pictures of the size of `work`, whose film of radiance is in `bands`; `None` where the
    /// denoiser takes no memory of others.
    fn new(kernels: &Kernels, work: &Work, bands: &[Band], denoiser: &Denoiser) -> Result<Option<Self>, DeviceError> {
        let (context, size) = (&kernels.context, [work.width as usize, work.height as usize]);
        let bytes = (SHARED_PIXEL_BYTES * size[0] * size[1]) as u64;
        let image = |what| Buffer::shared(context, what, bytes).map(Arc::new);
        let images = [image("radiance")?, image("albedo")?, image("normals")?, image("radiance without noise")?];
        let mut lent = vec![];
        for image in &images {
            lent.extend(image.handle()?.map(|(memory, bytes)| SharedImage { memory, bytes }));
        }
        let Ok([color, albedo, normal, output]) = <[_; 4]>::try_from(lent) else { return Ok(None) };
        let lent = SharedImages { color, albedo, normal, output };
        let Some(picture) = denoiser.share(size, lent).map_err(DeviceError::from)? else { return Ok(None) };
        let [color, albedo, normal, output] = &images;
        let resting = kernels.resting(&[])?;
        let guide = |feature, image| {
            let bands = kernels.film(work, &resting)?;
            let means = means(kernels, &bands, image)?;
            Ok::<_, DeviceError>(Guide { feature, bands, means })
        };
        let guides = [guide(Features::GUIDES[0], albedo)?, guide(Features::GUIDES[1], normal)?];
        let output = kernels.output(work, bands, Some(output))?;
        let means = means(kernels, bands, color)?;
        Ok(Some(Self { picture, means, guides, samples: 0, output }))
    }

    /// Makes the guides begin anew: the view is another.
    pub fn begin_anew(&mut self) {
        self.samples = 0;
    }
}

/// Sets that make means of a film in `bands` for `image`.
fn means(kernels: &Kernels, bands: &[Band], image: &Arc<Buffer>) -> Result<Vec<BindingSet>, DeviceError> {
    let set = |band: &Band| kernels.bind(&[(FILM_BINDING, band.film.clone()), (OUTPUT_BINDING, image.clone())]);
    bands.iter().map(set).collect()
}

impl VulkanSession {
    /// Does what [`Session::denoise`](crate::Session::denoise) says.
    pub(super) fn show_denoised(
        &mut self,
        denoiser: &Denoiser,
        care: Care,
        display: Display,
    ) -> Result<Denoised, DeviceError> {
        let can = self.films.feature() == Feature::Radiance
            && self.kernels.context.exports_memory()
            && denoiser.shares_memory();
        if !can {
            return Ok(Denoised::Elsewhere);
        }
        let Some(kernels) = self.kernels_of_guides()? else { return Ok(Denoised::NotYet) };
        match self.denoise_here(&kernels, denoiser, care, display) {
            Ok(shown) => Ok(shown),
            // The CPU needs none of the device's memory.
            Err(error) if error.is_out_of_memory() => {
                self.noiseless = None;
                denoiser.give_up_gpu(&DenoiseError::Failed(error.to_string()));
                Ok(Denoised::Elsewhere)
            }
            Err(DeviceError::Denoise(error)) => {
                self.noiseless = None;
                denoiser.give_up_gpu(&error);
                Ok(Denoised::Elsewhere)
            }
            Err(error) => Err(error),
        }
    }

    /// Kernels that sample guides, and that make means; `None` while a driver compiles them.
    fn kernels_of_guides(&self) -> Result<Option<[Arc<Pipeline>; 2]>, DeviceError> {
        let Resident { variant, special, .. } = self.resident;
        let own = Kernel::sampling(self.integrator, Feature::GuideAlbedo, variant, special);
        let inspect = if self.accepts_general { self.kernels.serving(own) } else { own };
        let special = Specialization::GENERAL;
        let means = Kernel { entry: EntryPoint::Means, variant: Variant::SIMPLE, special };
        let wanted = [inspect, means];
        if wanted.iter().all(|kernel| self.kernels.place(*kernel).is_filled()) {
            return Ok(Some([self.kernels.get(inspect)?, self.kernels.get(means)?]));
        }
        self.kernels.compile_ahead(&self.hardware.ahead, wanted);
        Ok(None)
    }

    fn denoise_here(
        &mut self,
        [inspect, means]: &[Arc<Pipeline>; 2],
        denoiser: &Denoiser,
        care: Care,
        display: Display,
    ) -> Result<Denoised, DeviceError> {
        let (kernels, bands) = (&self.kernels, self.films.shown());
        let noiseless = match &mut self.noiseless {
            Some(noiseless) => noiseless,
            none => match Noiseless::new(kernels, &self.work, bands, denoiser)? {
                Some(made) => none.insert(made),
                None => return Ok(Denoised::Elsewhere),
            },
        };
        let Noiseless { picture, means: color, guides, samples, output } = noiseless;
        // Guides become better with the picture: each time as many samples come as there are.
        let more = if *samples < GUIDE_SAMPLES { (*samples).clamp(1, GUIDE_SAMPLES - *samples) } else { 0 };
        let rows = |band: &Band| Work {
            band_row: band.rows.start,
            first_row: band.rows.start,
            rows: band.rows.len() as u32,
            ..self.work
        };
        kernels.context.run(|passes| {
            if *samples == 0 {
                guides.iter().flat_map(|guide| &guide.bands).for_each(|band| passes.clear(&band.film));
            }
            for Guide { feature, bands, .. } in guides.iter().filter(|_| more > 0) {
                for band in bands {
                    let work = Work {
                        first_sample: *samples,
                        samples: more,
                        feature: *feature as u32,
                        filter: feature.filter(self.work.filter),
                        ..rows(band)
                    };
                    let sets = [&band.set, &self.resident.set];
                    passes.compute(inspect, &sets, bytemuck::bytes_of(&work), EntryPoint::Inspect.groups(&work));
                }
            }
            let all = guides.iter().map(|guide| (guide.feature, &guide.bands[..], &guide.means));
            for (feature, bands, sets) in all.chain([(Feature::Radiance, bands.as_slice(), &*color)]) {
                for (band, set) in bands.iter().zip(sets) {
                    let work = Work { feature: feature as u32, ..rows(band) };
                    passes.compute(means, &[set], bytemuck::bytes_of(&work), EntryPoint::Means.groups(&work));
                }
            }
        })?;
        *samples += more;
        picture.denoise(care).map_err(DeviceError::from)?;
        let display = Display { view: View::Radiance, comparison: Comparison::Reference, ..display };
        kernels.display(&display.apply(self.work, true), bands, output)?;
        Ok(Denoised::Shown(Pixels::Device(output.pixels.clone())))
    }
}
