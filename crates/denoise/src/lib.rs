//! Intel Open Image Denoise, found while the program runs: those who never ask for it need not have it.

mod library;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use library::{Device, Library};

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

/// Denoiser of the library, ready to work on the CPU.
pub struct Denoiser {
    device: Device,
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
                Ok(library) => return Ok(Self { device: Device::new(library)? }),
                Err(words) => reason = words,
            }
        }
        Err(DenoiseError::NotFound(reason))
    }

    /// Name and version of the library: `Open Image Denoise 2.5.1`.
    pub fn name(&self) -> String {
        let version = self.device.version();
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
            self.device.filter([width, height], &[(name, pixels)], &[])
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
            None => self.device.filter(size, &[("color", color)], &["hdr"]),
            Some(Guides { albedo, normal }) => {
                check_size(size, albedo)?;
                let inputs = [("color", color), ("albedo", albedo), ("normal", normal)];
                self.device.filter(size, &inputs, &["hdr", "cleanAux"])
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
