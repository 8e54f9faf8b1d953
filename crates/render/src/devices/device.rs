//! Interface of devices, which is all that the rest of the program knows of them.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use raggio_denoise::{Care, DenoiseError, Denoiser};
use raggio_kernels::{BrokenScene, EntryPoint, Feature, FilmPixel, Probe};
use raggio_scene::Integrator;
use raggio_vulkan::VulkanError;

use crate::devices::adaptive::Blocks;
use crate::devices::tracer::Tracer;
use crate::pictures::display::{Denoised, Display, Pixels};
use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;
use crate::translation::device_scene::DeviceScene;

/// Something that can trace rays.
pub trait Device: Send + Sync {
    /// Name of the device, as shown to users: `NVIDIA H200 (vulkan:0)`.
    fn name(&self) -> String;

    /// Messages of Vulkan's validation layers so far, if they are on; empty when all is well.
    fn validation_messages(&self) -> Vec<String> {
        vec![]
    }

    /// Vulkan device behind this one, if there is one: windows are fastest on the same. It is another once the device was lost
    /// and has been opened again.
    fn vulkan(&self) -> Option<Arc<raggio_vulkan::Device>> {
        None
    }

    /// Has threads make ready what sampling the films of `features` of `scene` will take, where that takes a while: drivers
    /// compile kernels. Returns at once, and says nothing of errors: whoever needs it hears of them.
    fn compile_ahead(&self, _scene: &DeviceScene, _features: &[Feature]) {}

    /// Makes `scene` resident, with an empty film. A device that was lost is opened again.
    ///
    /// # Errors
    /// A [`DeviceError`] when the scene's indices are wrong, the device has no memory for it, or fails.
    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError>;
}

/// A scene and its films on a device: that of radiance and, once asked for, one of another feature.
///
/// Samples go to the film that is shown, and what is read comes from it. A session may move from thread to thread.
///
/// # Errors
/// A [`DeviceError`] from any function when the device fails or has no memory left; from [`Session::restart`] also when
/// the scene's indices are wrong.
pub trait Session: Send {
    /// Shows the film of `feature`; at first that of radiance is shown. The film of radiance is always kept, and of the
    /// others the last: any other begins empty.
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError>;

    /// Adds the samples `samples` to the pixels of `rows`, from the first row on, and waits for them. Where `stop`, which
    /// is asked as often as the device can, says so, the last rows go without; one at least is done. Returns how many are.
    /// An error means that no row has got any.
    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError>;

    /// Adds the samples `samples` to the pixels of `rows`, and waits for them.
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        self.add_samples_until(rows, samples, &|| false).map(|_| ())
    }

    /// Puts the sums of `film`, which is as large, into the film that is shown, in place of its own.
    fn set_film(&mut self, film: &Film) -> Result<(), DeviceError>;

    /// Makes ready what [`Session::add_samples`] needs, which takes a while where a driver compiles kernels.
    fn prepare(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Whether [`Session::prepare`] returns at once.
    fn is_prepared(&self) -> bool {
        true
    }

    /// Begins on threads, or ends, what [`Session::prepare`] does, to be called until [`Session::is_prepared`]. Only drivers that
    /// compile kernels no sooner than these run have it take a while.
    fn prepare_ahead(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Lets kernels that know more than the scene has serve until those for the scene are compiled, so that edits need not wait.
    fn accept_general(&mut self) {}

    /// Time in which a driver compiled kernels since the device was opened.
    fn compile_time(&self) -> Duration {
        Duration::ZERO
    }

    /// Lets those of `blocks` rest that are marked so: their radiance takes no more samples. `None`: no block rests.
    fn rest(&mut self, blocks: Option<&Blocks>) -> Result<(), DeviceError>;

    /// Begins anew with another scene, camera, resolution or settings: films have no samples, and no block rests.
    /// Buffers that `scene` shares with the one before stay where they are. With another resolution the reference is
    /// gone.
    fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError>;

    /// Gives up memory that only [`Session::restart`] could need again, which should not follow: it would take longer. What may
    /// be lost is asked for no such thing.
    fn settle(&mut self) {}

    /// Begins anew with `scene` after a failure: what was lost is opened again, or the others of several devices go on without
    /// it. Films have no samples, no block rests, and the reference is gone. Returns what has been done, in words. After an
    /// error nothing but this can follow.
    fn revive(&mut self, _scene: &DeviceScene) -> Result<String, DeviceError> {
        Err(DeviceError::Host("it cannot be opened again".into()))
    }

    /// Who finds what rays meet, [`Tracer::Software`] or [`Tracer::Hardware`]; `None` where devices that share a picture differ.
    fn tracer(&self) -> Option<Tracer> {
        Some(Tracer::Software)
    }

    /// Whether what the session holds may be lost from one moment to the next.
    fn may_be_lost(&self) -> bool {
        false
    }

    /// Sets the image that films of radiance are [compared](Display::comparison) with from now on, resized to the
    /// film's size; `None` takes it away.
    fn set_reference(&mut self, reference: Option<&Image>) -> Result<(), DeviceError>;

    /// The film as displayable pixels.
    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError>;

    /// The film of radiance as displayable pixels, without its noise and without a comparison, where `denoiser` works in the
    /// memory of the device: guides are sampled there too.
    fn denoise(&mut self, _denoiser: &Denoiser, _care: Care, _display: Display) -> Result<Denoised, DeviceError> {
        Ok(Denoised::Elsewhere)
    }

    /// Pixels `columns` of row `y` of the film as it is now; they have to be inside it.
    fn pixels(&self, columns: Range<u32>, y: u32) -> Result<Vec<FilmPixel>, DeviceError>;

    /// One pixel of the film as it is now; `x` and `y` have to be inside it.
    fn pixel(&self, x: u32, y: u32) -> Result<FilmPixel, DeviceError> {
        Ok(self.pixels(x..x + 1, y)?[0])
    }

    /// The film as it is now.
    fn film(&self) -> Result<Film, DeviceError>;

    /// The film as it is now, for who asks this film for nothing more: it may be gone then.
    fn take_film(&mut self) -> Result<Film, DeviceError> {
        self.film()
    }

    /// Means of the film of radiance, three floats a pixel, for CUDA on the same device; `None` where that cannot be without a
    /// way through the host.
    #[cfg(target_os = "linux")]
    fn means_in_cuda(&self) -> Result<Option<raggio_vulkan::CudaMemory>, DeviceError> {
        Ok(None)
    }

    /// Evaluates one function of the kernels for many arguments: see `Probe` in `kernels/entry/probe.slang`.
    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError>;

    /// Number of rows that take no longer together than one alone.
    fn rows_at_once(&self) -> u32 {
        1
    }

    /// Longest time that one call of [`Session::add_samples`] may take without harm, in seconds.
    fn patience_seconds(&self) -> f64;
}

/// Kernel that adds samples to the film of `feature`. The kernel of an integrator has its name.
pub(crate) fn sampling(integrator: Integrator, feature: Feature) -> EntryPoint {
    let kernel = EntryPoint::ALL.into_iter().find(|entry| entry.name() == integrator.name());
    if feature == Feature::Radiance { kernel.expect("tests see to it that there is one") } else { EntryPoint::Inspect }
}

/// Arguments of a probe: three vectors of four numbers.
pub type Question = [[f32; 4]; 3];
/// Results of a probe: three vectors of four numbers.
pub type Answer = [[f32; 4]; 3];

/// Reasons why a device cannot be had or has failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// A Vulkan call failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// A denoiser failed in the memory of the device.
    #[error(transparent)]
    Denoise(#[from] DenoiseError),
    /// The scene's indices are wrong.
    #[error(transparent)]
    BrokenScene(#[from] BrokenScene),
    /// There is no such device.
    #[error("{0}")]
    NotFound(String),
    /// The machine refused threads or the like.
    #[error("{0}")]
    Host(String),
}

impl DeviceError {
    /// Whether the device was lost: all that it held is gone.
    pub fn is_lost(&self) -> bool {
        matches!(self, Self::Vulkan(VulkanError::DeviceLost))
    }

    /// Whether the device has too little memory left for what it was to do: less may fit.
    pub fn is_out_of_memory(&self) -> bool {
        matches!(self, Self::Vulkan(VulkanError::OutOfMemory(_) | VulkanError::NoRoom { .. }))
    }

    /// Whether something was too large for the device.
    pub(crate) fn does_not_fit(&self) -> bool {
        let is_too_large =
            matches!(self, Self::Vulkan(VulkanError::TooLarge { .. } | VulkanError::TooManyParts { .. }));
        is_too_large || self.is_out_of_memory()
    }
}

/// A line of `raggio devices`.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Word by which `--device` names the device.
    pub id: String,
    /// Name of the processor.
    pub name: String,
    /// Kind of the device, in a word.
    pub kind: &'static str,
    /// Driver of the device; of the CPU, its cores and their instruction set.
    pub driver: String,
    /// Memory of the device in bytes; `None` if unknown.
    pub memory_bytes: Option<u64>,
    /// Features that the device lacks to run the kernels.
    pub missing: Vec<String>,
    /// Whether the device can trace rays by hardware, or says so: `VK_KHR_ray_query`.
    pub has_ray_queries: bool,
    /// Who finds what rays meet if nobody asks for another: [`Tracer::Software`] or [`Tracer::Hardware`].
    pub tracer: Tracer,
}

#[cfg(test)]
mod tests {
    use raggio_choice::Choice;

    use super::*;

    #[test]
    fn every_integrator_has_a_kernel() {
        for integrator in Integrator::ALL {
            assert_eq!(sampling(*integrator, Feature::Radiance).name(), integrator.name());
            assert_eq!(sampling(*integrator, Feature::Normal), EntryPoint::Inspect);
        }
    }
}
