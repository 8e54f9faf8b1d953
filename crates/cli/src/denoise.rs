//! Pictures without their noise, beside those that have it.

use raggio_denoise::{Denoiser, Noisy};
use raggio_render::{Display, Extras, Features, Film, Image, ImageFile};

use crate::error::Failure;
use crate::progress::Reporter;

/// A denoiser and the files it is to write.
pub struct Denoising {
    denoiser: Denoiser,
    files: Vec<ImageFile>,
}

impl Denoising {
    /// Fails early if the library is not there, or a file cannot be written: one beside each of `noisy`.
    pub fn begin(noisy: &[ImageFile]) -> Result<Self, Failure> {
        let denoiser = Denoiser::open()?;
        let files = noisy.iter().map(ImageFile::denoised).collect::<Result<_, _>>()?;
        Ok(Self { denoiser, files })
    }

    /// Denoises `film` with the help of albedo and normal, and writes it; `extras` are those of the noisy picture, whose
    /// layers are not repeated.
    pub fn write(
        &self,
        reporter: &Reporter,
        film: &Film,
        features: &Features,
        display: Display,
        extras: Extras,
    ) -> Result<(), Failure> {
        let mean = film.mean();
        let [width, height] = [mean.width, mean.height].map(|side| side as usize);
        let guides = self.denoiser.guides([width, height], &features.albedos(), &features.normals())?;
        let pixels = self.denoiser.denoise(Noisy { width, height, color: &mean.pixels, guides: Some(&guides) })?;
        let denoised = Film::from_image(&Image { pixels, ..mean.clone() });
        let mut metadata = extras.metadata;
        if let Some(metadata) = &mut metadata {
            metadata.denoiser = Some(self.denoiser.name());
        }
        let extras = Extras { channels: vec![], metadata };
        for file in &self.files {
            file.write_with(&denoised, display, &extras)?;
            reporter.say(&format!("wrote {}", file.path().display()));
        }
        Ok(())
    }
}
