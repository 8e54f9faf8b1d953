//! Intel Open Image Denoise, found while the program runs: those who never ask for it need not have it.

mod device;
mod library;
#[cfg(unix)]
mod shared;

use std::ffi::{CStr, OsStr};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use device::Device;
use library::Library;

#[cfg(unix)]
pub use shared::{SHARED_PIXEL_BYTES, SharedImage, SharedImages, SharedPicture};

/// Picture to be denoised, and what is known of it: row by row from the top left, `width` times `height` pixels each.
#[derive(Clone, Copy, Debug)]
pub struct Noisy<'a> {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Linear radiance of any brightness.
    pub color: &'a [[f32; 3]],
    /// Features of the first surfaces, to keep their edges; made by [`Denoiser::guides`].
    pub guides: Option<&'a Guides>,
}

/// Albedo and normal of the first surfaces, without the noise of edges, which would come back into the picture
/// otherwise; made by [`Denoiser::guides`].
#[derive(Clone, Debug)]
pub struct Guides {
    albedo: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
}

/// Reason why there is no denoised picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DenoiseError {
    /// The library is not on this machine.
    #[error(
        "Intel Open Image Denoise was not found: run `make setup`, or set OIDN_DIR to the folder of an installation ({0})"
    )]
    NotFound(String),
    /// The library failed, in its own words.
    #[error("Intel Open Image Denoise failed: {0}")]
    Failed(String),
    /// A list has not one entry for each pixel.
    #[error("the picture is {width} x {height} pixels, and one of its parts has {found}")]
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
        /// Entries in the list.
        found: usize,
    },
}

impl DenoiseError {
    /// The error in the library's own words, where it has some.
    fn reason(&self) -> String {
        match self {
            Self::Failed(reason) => reason.clone(),
            other => other.to_string(),
        }
    }
}

/// Care with which noise is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Care {
    /// For pictures that are gone in a moment: guides are taken as noisy as they are.
    Quick,
    /// For pictures that are looked at: guides are denoised first.
    Thorough,
}

/// A GPU, as drivers of all interfaces name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gpu {
    /// Name for users: `NVIDIA H200`.
    pub name: String,
    /// UUID of the device.
    pub uuid: [u8; 16],
    /// LUID of the device, which Windows has.
    pub luid: Option<[u8; 8]>,
}

/// Interface through which the library works on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interface {
    /// The processor.
    Cpu,
    /// Intel's GPUs.
    Sycl,
    /// NVIDIA's GPUs.
    Cuda,
    /// AMD's GPUs.
    Hip,
    /// Apple's GPUs.
    Metal,
    /// Devices of later versions of the library.
    Other,
}

impl Interface {
    /// The interface of this number in the library's header.
    fn of(number: i32) -> Self {
        match number {
            1 => Self::Cpu,
            2 => Self::Sycl,
            3 => Self::Cuda,
            4 => Self::Hip,
            5 => Self::Metal,
            _ => Self::Other,
        }
    }

    /// Name of the interface.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Sycl => "SYCL",
            Self::Cuda => "CUDA",
            Self::Hip => "HIP",
            Self::Metal => "Metal",
            Self::Other => "GPU",
        }
    }
}

/// Denoiser of the library, ready to work on the CPU, and on a GPU that it [prefers](Denoiser::prefer).
pub struct Denoiser {
    library: Arc<Library>,
    cpu: Device,
    /// The GPU that is preferred, or the reason why the library cannot use it.
    gpu: OnceLock<(String, Result<Arc<Device>, String>)>,
    /// Reason why the GPU is not used any more.
    failure: OnceLock<String>,
    /// Whether somebody has heard why the CPU works instead.
    is_told: AtomicBool,
}

impl Denoiser {
    /// Looks for the library at its [paths](library_paths); an error if it is at none of them.
    pub fn open() -> Result<Self, DenoiseError> {
        let (chosen, program) = (std::env::var_os("OIDN_DIR"), std::env::current_exe().ok());
        let mut reason = String::new();
        for path in library_paths(chosen.as_deref(), program.as_deref())? {
            if path.is_absolute() && !path.exists() {
                reason = format!("there is no {}", path.display());
                continue;
            }
            match Library::open(&path) {
                Ok(library) => return Self::of(library),
                Err(words) => reason = words,
            }
        }
        Err(DenoiseError::NotFound(reason))
    }

    /// Loads the library at `path`.
    ///
    /// # Errors
    /// A [`DenoiseError`] when there is none, or it does not work.
    pub fn open_at(path: &Path) -> Result<Self, DenoiseError> {
        Self::of(Library::open(path).map_err(DenoiseError::NotFound)?)
    }

    fn of(library: Library) -> Result<Self, DenoiseError> {
        let library = Arc::new(library);
        let cpu = Device::cpu(library.clone())?;
        let (gpu, failure, is_told) = (OnceLock::new(), OnceLock::new(), AtomicBool::new(false));
        Ok(Self { library, cpu, gpu, failure, is_told })
    }

    /// Works on `gpu` from now on, if the library can; the first call counts. It takes some tenths of a second.
    pub fn prefer(&self, gpu: &Gpu) {
        let open = || Device::gpu(self.library.clone(), gpu).map(Arc::new).map_err(|error| error.reason());
        self.gpu.get_or_init(|| (gpu.name.clone(), open()));
    }

    /// GPUs of this machine that the library can use. To ask takes some tenths of a second.
    pub fn gpus(&self) -> Vec<(Gpu, Interface)> {
        let Library { count_devices, physical_int, physical_bool, physical_string, physical_data, .. } = &*self.library;
        // SAFETY: devices have numbers below their count, and these properties; what the library points to it keeps.
        unsafe {
            let data = |device, is_there: &CStr, name: &CStr| {
                let mut bytes = 0;
                let data = (physical_data)(device, name.as_ptr(), &raw mut bytes);
                let is_there = (physical_bool)(device, is_there.as_ptr()) && !data.is_null();
                is_there.then(|| std::slice::from_raw_parts(data.cast::<u8>(), bytes))
            };
            let described = |device| {
                let interface = Interface::of((physical_int)(device, c"type".as_ptr()));
                let name = (physical_string)(device, c"name".as_ptr());
                let name = if name.is_null() { "GPU".into() } else { CStr::from_ptr(name).to_string_lossy() };
                let uuid = data(device, c"uuidSupported", c"uuid").and_then(|uuid| uuid.try_into().ok())?;
                let luid = data(device, c"luidSupported", c"luid").and_then(|luid| luid.try_into().ok());
                let gpu = Gpu { name: name.into_owned(), uuid, luid };
                (interface != Interface::Cpu).then_some((gpu, interface))
            };
            (0..(count_devices)()).filter_map(described).collect()
        }
    }

    /// The device that works, if it is a GPU.
    fn working_gpu(&self) -> Option<(&str, &Arc<Device>)> {
        let (name, device) = self.gpu.get().filter(|_| self.failure.get().is_none())?;
        Some((name, device.as_ref().ok()?))
    }

    /// Name of what works, in words: `the CPU`, or `NVIDIA H200 (CUDA)`.
    pub fn place(&self) -> String {
        let gpu = self.working_gpu().map(|(name, device)| format!("{name} ({})", device.interface.name()));
        gpu.unwrap_or_else(|| "the CPU".into())
    }

    /// Sentence on why the CPU works instead of the GPU that was preferred, where it does.
    pub fn fallback(&self) -> Option<String> {
        let (name, device) = self.gpu.get()?;
        let reason = self.failure.get().or(device.as_ref().err())?;
        Some(format!("{} does not work on {name}, and removes noise on the CPU: {reason}", self.name()))
    }

    /// The sentence of [`fallback`](Self::fallback), for the first who asks.
    pub fn complaint(&self) -> Option<String> {
        self.fallback().filter(|_| !self.is_told.swap(true, Ordering::Relaxed))
    }

    /// Does `work` on the device that is preferred, and on the CPU from the time on when that fails.
    fn attempt<T>(&self, work: impl Fn(&Device) -> Result<T, DenoiseError>) -> Result<T, DenoiseError> {
        let Some((_, gpu)) = self.working_gpu() else { return work(&self.cpu) };
        match work(gpu) {
            Err(DenoiseError::Failed(reason)) => {
                self.failure.get_or_init(|| reason);
                work(&self.cpu)
            }
            worked => worked,
        }
    }

    /// Shares the `images` of pictures of `width` times `height` pixels with the GPU that works; `None` where none does, or it
    /// takes no memory of others.
    ///
    /// # Errors
    /// A [`DenoiseError`] when the library fails to import the memory, or it is too small for the pictures.
    #[cfg(unix)]
    pub fn share(&self, size: [usize; 2], images: SharedImages) -> Result<Option<SharedPicture>, DenoiseError> {
        let Some((_, device)) = self.working_gpu().filter(|_| self.shares_memory()) else { return Ok(None) };
        SharedPicture::new(device.clone(), size, images).map(Some)
    }

    /// Whether a GPU works that takes memory of others on the same GPU.
    #[cfg(unix)]
    pub fn shares_memory(&self) -> bool {
        let types = |device: &Arc<Device>| device.int(c"externalMemoryTypes");
        self.working_gpu().is_some_and(|(_, device)| types(device) & library::OPAQUE_FD != 0)
    }

    /// Goes on without the GPU, of which `error` says that it cannot work.
    pub fn give_up_gpu(&self, error: &DenoiseError) {
        self.failure.get_or_init(|| error.reason());
    }

    /// Name and version of the library: `Open Image Denoise 2.5.1`.
    pub fn name(&self) -> String {
        let version = self.cpu.int(c"version");
        format!("Open Image Denoise {}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// Makes guides from the albedo of the first surfaces, 0 to 1, and their normals, -1 to 1, as noisy as they are;
    /// row by row, `width` times `height` each.
    pub fn guides(
        &self,
        [width, height]: [usize; 2],
        albedo: &[[f32; 3]],
        normal: &[[f32; 3]],
    ) -> Result<Guides, DenoiseError> {
        let clean = |name, pixels| {
            check_size([width, height], pixels)?;
            self.attempt(|device| device.filter([width, height], &[(name, pixels)], &[]))
        };
        Ok(Guides { albedo: clean("albedo", albedo)?, normal: clean("normal", normal)? })
    }

    /// Returns the picture without its noise, linear radiance row by row; an error if a list has not one entry for each
    /// pixel.
    pub fn denoise(&self, noisy: Noisy<'_>) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let Noisy { width, height, color, guides } = noisy;
        let size = [width, height];
        check_size(size, color)?;
        match guides {
            None => self.attempt(|device| device.filter(size, &[("color", color)], &["hdr"])),
            Some(Guides { albedo, normal }) => {
                check_size(size, albedo)?;
                let inputs = [("color", color), ("albedo", albedo), ("normal", normal)];
                self.attempt(|device| device.filter(size, &inputs, &["hdr", "cleanAux"]))
            }
        }
    }
}

fn check_size([width, height]: [usize; 2], pixels: &[[f32; 3]]) -> Result<(), DenoiseError> {
    let found = pixels.len();
    if found == width * height { Ok(()) } else { Err(DenoiseError::Size { width, height, found }) }
}

const NAME: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// Paths at which the library is looked for, the likeliest first: in the folder `chosen`, where `OIDN_DIR` names one; else
/// in `../lib` of the folder of `program`, in the project's `.venv`, and where the system keeps its own. All but the last,
/// which is a name alone, are absolute: what the current folder happens to hold is not loaded.
///
/// # Errors
/// A [`DenoiseError::NotFound`] when `chosen` is a path from the current folder.
pub fn library_paths(chosen: Option<&OsStr>, program: Option<&Path>) -> Result<Vec<PathBuf>, DenoiseError> {
    let within = |root: &Path| ["lib", "bin", ""].map(|folder| root.join(folder).join(NAME));
    if let Some(chosen) = chosen.filter(|chosen| !chosen.is_empty()).map(Path::new) {
        return if chosen.is_absolute() {
            Ok(within(chosen).into())
        } else {
            Err(DenoiseError::NotFound("OIDN_DIR is not a path from the root".into()))
        };
    }
    let installation = program.filter(|program| program.is_absolute()).and_then(Path::parent).and_then(Path::parent);
    let beside = installation.map(|folder| folder.join("lib").join(NAME));
    let pythons = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv/lib"));
    let wheels = pythons.into_iter().flatten().flatten().map(|it| it.path().join("site-packages/pyoidn/oidn"));
    let installed = beside.into_iter().chain(wheels.flat_map(|wheel| within(&wheel)));
    Ok(installed.chain([PathBuf::from(NAME)]).collect())
}
