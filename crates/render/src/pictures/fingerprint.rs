//! Fingerprints of whole pictures, by which a file is known to be done.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};

use crate::pictures::aov::Aov;
use crate::pictures::display::Display;
use crate::pictures::film::Film;
use crate::pictures::format::PictureFormat;
use crate::pictures::image_file::ImageFile;
use crate::pictures::linear_image::Image;
use crate::renderer::{motion_hash, scene_hash, settings};
use crate::request::RenderRequest;
use crate::translation::device_scene::DeviceScene;

/// Name of the attribute, the text or the note in which a file has its fingerprint.
pub(crate) const NAME: &str = "fingerprint";

/// Fingerprint of a picture with all its samples: of the scene, the settings, the version of raggio, and whatever else
/// decides it. Each file has one of its own, which knows how the file was made of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    radiance: blake3::Hash,
    layers: blake3::Hash,
}

impl Fingerprint {
    /// Fingerprint of the picture of `scene` that `request` asks for.
    pub fn new(scene: &DeviceScene, request: &RenderRequest) -> Self {
        let mut radiance = blake3::Hasher::new();
        let samples = request.stop.samples(&scene.settings);
        let mut say = |text: &str| {
            // Lengths keep texts apart.
            radiance.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        };
        say(env!("CARGO_PKG_VERSION"));
        for (key, value) in settings(&scene.settings, request.stop.noise.map(f64::from)) {
            say(&key);
            say(&value);
        }
        say(&format!("{}x{}, {}..{}", scene.settings.width, scene.settings.height, samples.start, samples.end));
        say(&format!("{:?}", request.stop.time_limit));
        radiance.update(&scene_hash(&scene.buffers));
        let mut layers = blake3::Hasher::new();
        for layer in &request.layers {
            layers.update(layer.name().as_bytes()).update(b",");
            if *layer == Aov::Motion {
                layers.update(&motion_hash(&scene.buffers));
            }
        }
        Self { radiance: radiance.finalize(), layers: layers.finalize() }
    }

    /// Fingerprint of `file`, as it is written in it; `denoiser` is the name of what has removed the noise.
    pub(crate) fn of(&self, file: &ImageFile, display: Display, denoiser: Option<&str>) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.radiance.as_bytes()).update(denoiser.unwrap_or_default().as_bytes());
        match file.format() {
            PictureFormat::Exr if denoiser.is_none() => {
                hasher.update(self.layers.as_bytes());
            }
            PictureFormat::Png => {
                let Display { exposure, tone_mapper, .. } = display;
                hasher.update(format!("{exposure} {tone_mapper} {}", file.png_bits()).as_bytes());
            }
            _ => {}
        }
        hasher.finalize().to_hex().to_string()
    }
}

impl ImageFile {
    /// Whether the file is there and is all of the picture with this fingerprint, made as `display` says; `denoiser` is the
    /// name of what removes the noise, if something does.
    pub fn is_done(&self, fingerprint: &Fingerprint, display: Display, denoiser: Option<&str>) -> bool {
        let Some(place) = self.file().place() else { return false };
        if self.format() == PictureFormat::Film {
            let Ok((_, notes)) = Film::read_with_notes(place) else { return false };
            let expected = fingerprint.of(self, display, denoiser);
            return notes.iter().any(|note| note.name == NAME && note.value == expected.as_bytes());
        }
        let found = match self.format() {
            PictureFormat::Png => of_png(place),
            _ => of_exr(place),
        };
        // Half a file, which somebody has copied, begins as all of it does.
        found.is_some_and(|found| found == fingerprint.of(self, display, denoiser))
            && Image::load_as(place, self.format()).is_ok()
    }
}

fn of_png(path: &Path) -> Option<String> {
    let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|text| text.keyword == NAME).map(|text| text.text.clone())
}

fn of_exr(path: &Path) -> Option<String> {
    let mut file = BufReader::new(File::open(path).ok()?);
    let found = MetaData::read_from_buffered(&mut file, false).ok()?;
    let header = found.headers.first()?;
    match header.own_attributes.other.get(&Text::from(NAME))? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}
