//! Models and images that scenes name, read once.

mod cache;
mod imported;

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DVec3, Vec3};
use raggio_choice::endings;
use raggio_images::{Bitmap, Image, ImageError, Limits, Problem};
use raggio_models::{Animation, Format, GltfOptions, GltfSequence, LoadOptions, Model, ModelError, Place};

use crate::{names, sky};
use cache::{Cache, Depends, Key};

pub(crate) use imported::{Bounds, Imported, can_be_undone};

/// Options for reading models.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssetOptions {
    /// Whether a model may name files outside its own folder. The files that a scene names are its writer's choice and
    /// may lie anywhere; a model comes from somebody else.
    pub allow_outside: bool,
    /// Time at which all animations are sampled, in place of the scene file's.
    pub time_seconds: Option<f64>,
    /// Seconds since the first frame of a sequence, which are added to every time, and to 0 where there is none; below 0
    /// before that frame. `None` is a still.
    pub elapsed_seconds: Option<f64>,
    /// Width and height, in pixels, of the pictures of models that are shown without a scene file.
    pub picture: Option<[u32; 2]>,
    /// Camera of a model that is shown without a scene file: its name, or its number from 1 on. `None`: the first.
    pub camera: Option<String>,
}

/// Models and images, kept from one reading of a scene to the next.
///
/// A scene that is read again, because its text was edited, finds here the files that it named before, and no file is
/// touched. Files that it no longer names are forgotten; those that have changed on disk are read again after
/// [`Assets::refresh`], models also where a file that they name has changed, come or gone.
#[derive(Debug, Default)]
pub struct Assets {
    options: AssetOptions,
    models: Cache<Imported>,
    images: Cache<Picture>,
    /// Models that no file holds, by the paths at which scenes find them.
    given_models: HashMap<PathBuf, Arc<Imported>>,
    /// Images that no file holds, by the paths at which scenes find them.
    given_images: HashMap<PathBuf, Arc<Picture>>,
    /// glTF files of a sequence, which are posed anew for each frame, by their paths.
    sequences: HashMap<PathBuf, GltfSequence>,
    /// Times at which models were read that are equal at every time, by their paths.
    still: HashMap<PathBuf, Option<f64>>,
    /// Image of the sky that was asked for last, with what it was made of.
    sky: Option<(SkyKey, Arc<Bitmap>)>,
    /// Whether scenes are read at one moment after another.
    moves_on: bool,
    /// Whether files have changed that no scene was made of since.
    is_stale: bool,
}

impl Assets {
    /// Assets that have not read any file yet.
    pub fn new(options: AssetOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// Gives a model that is in memory to scenes that name a mesh at `path`, whether there is such a file or not. It is kept
    /// whether a scene names it or not.
    pub fn give_model(&mut self, path: PathBuf, model: Model) {
        self.given_models.insert(path, Arc::new(Imported::new(model)));
    }

    /// Gives an image that is in memory to scenes that name one at `path`, as [`Assets::give_model`] does.
    pub fn give_image(&mut self, path: PathBuf, image: Arc<Bitmap>) {
        self.given_images.insert(path, Arc::new(Picture { bitmap: image, warnings: Vec::new() }));
    }

    /// Forgets what was given at `path`.
    pub fn take_back(&mut self, path: &Path) {
        self.given_models.remove(path);
        self.given_images.remove(path);
    }

    /// Gives to `others` what was given to these.
    pub fn lend(&self, others: &mut Self) {
        others.given_models.extend(self.given_models.iter().map(|(path, model)| (path.clone(), model.clone())));
        others.given_images.extend(self.given_images.iter().map(|(path, image)| (path.clone(), image.clone())));
    }

    /// Options that these assets were made with.
    pub fn options(&self) -> &AssetOptions {
        &self.options
    }

    /// Goes to another frame of a sequence, `seconds` after the first: scenes that are read from now on are at that moment.
    pub fn set_elapsed(&mut self, seconds: f64) {
        self.options.elapsed_seconds = Some(seconds);
        self.moves_on = true;
    }

    /// Changes the time of all animations, as [`AssetOptions::time_seconds`] has it, for scenes that are read from now on.
    pub fn set_time(&mut self, seconds: Option<f64>) {
        self.moves_on |= self.options.time_seconds != seconds;
        self.options.time_seconds = seconds;
    }

    /// Animations of the models that the last scene was made of, with the canonical paths of their files, in the order of these.
    pub fn animations(&self) -> Vec<(&Path, &Animation)> {
        // A file that is there at more than one moment has them all at each.
        let models: BTreeMap<_, _> = self.models.entries().collect();
        models.into_iter().flat_map(|(path, model)| model.animations.iter().map(move |it| (path, it))).collect()
    }

    /// The model at `path` at the first frame of the sequence, and at the moment of the options: the same for a still.
    pub(crate) fn model_at_first(&mut self, path: PathBuf) -> Result<[Arc<Imported>; 2], Trouble> {
        let elapsed = self.options.elapsed_seconds;
        self.options.elapsed_seconds = elapsed.map(|_| 0.0);
        let first = self.model(path.clone(), None);
        self.options.elapsed_seconds = elapsed;
        Ok([first?, self.model(path, None)?])
    }

    /// Time of the camera: it moves with the sequence, and stands at its beginning otherwise.
    pub(crate) fn camera_seconds(&self) -> f64 {
        self.moment(None).unwrap_or(0.0)
    }

    /// Time of an animation for which the scene file has `own`, if it has any.
    fn moment(&self, own: Option<f64>) -> Option<f64> {
        let time = self.options.time_seconds.or(own);
        let elapsed = self.options.elapsed_seconds.map(|elapsed| (time.unwrap_or(0.0) + elapsed).max(0.0));
        elapsed.or(time)
    }

    /// Canonical paths of the files that the last scene was made of, in no order; not of those that models name.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.models.files().chain(self.images.files())
    }

    /// Canonical paths of all files that the last scene was made of, in no order, with those that models name: whoever
    /// replaces one of these files changes the scene.
    pub fn all_files(&self) -> impl Iterator<Item = &Path> {
        self.files().chain(self.models.values().flat_map(|model| &model.files).map(PathBuf::as_path))
    }

    /// Canonical paths of the files by which the scene may change, in no order: [`Self::all_files`], and where models looked
    /// for others in vain.
    pub fn watched_files(&self) -> impl Iterator<Item = &Path> {
        self.files().chain(self.models.values().flat_map(Depends::others))
    }

    /// Forgets every file that has changed since it was read. Returns whether there was one, now or since a scene was
    /// last read without an error.
    pub fn refresh(&mut self) -> bool {
        self.is_stale |= self.models.refresh();
        self.is_stale |= self.images.refresh();
        self.still.clear();
        self.sequences.clear();
        self.is_stale
    }

    /// Forgets all files that the scene just made did not ask for.
    pub(crate) fn sweep(&mut self) {
        self.is_stale = false;
        self.models.sweep();
        self.images.sweep();
    }

    /// The model at `path`, at the moment of `time_seconds` unless the options say another.
    pub(crate) fn model(&mut self, path: PathBuf, time_seconds: Option<f64>) -> Result<Arc<Imported>, Trouble> {
        if let Some(given) = self.given_models.get(&path) {
            return Ok(given.clone());
        }
        let Some(format) = Format::of_path(&path) else {
            return Err(Trouble::whole(format!("is not a model: give a {} file", endings::<Format>())));
        };
        let allow_outside = self.options.allow_outside;
        let time_seconds = match self.still.get(&path) {
            Some(known) => *known,
            None => self.moment(time_seconds).filter(|_| format.is_animated()),
        };
        let is_frame = self.moves_on && format.is_animated();
        let sequences = &mut self.sequences;
        let model = self.models.get_or_read(Key::new(path.clone(), time_seconds), |path, earlier| {
            let most_bytes = budget(LoadOptions::default().most_bytes);
            let options = LoadOptions { time_seconds, allow_outside, most_bytes };
            let model =
                if is_frame { in_sequence(sequences, path, &options) } else { raggio_models::load(path, &options) };
            let model =
                model.map_err(|error| Trouble { place: error.place, message: names::escaped(&error.message) })?;
            let imported = Imported::new(model);
            Ok(match earlier {
                Some(earlier) => imported.sharing(earlier),
                None => imported,
            })
        })?;
        if model.animations.is_empty() {
            self.sequences.remove(&path);
            self.still.insert(path, time_seconds);
        }
        Ok(model)
    }

    /// Image of a sky by day: see [`sky::bake`].
    pub(crate) fn sky(&mut self, toward: DVec3, turbidity: f32, albedo: Vec3, sun_intensity: f32) -> Arc<Bitmap> {
        let key = (toward, turbidity, albedo, sun_intensity);
        if let Some((known, image)) = &self.sky
            && *known == key
        {
            return image.clone();
        }
        let image = Arc::new(sky::bake(toward, turbidity, albedo, sun_intensity));
        self.sky = Some((key, image.clone()));
        image
    }

    /// The image at `path`.
    pub(crate) fn image(&mut self, path: PathBuf) -> Result<Arc<Picture>, Trouble> {
        if let Some(given) = self.given_images.get(&path) {
            return Ok(given.clone());
        }
        self.images.get_or_read(Key::new(path, None), |path, _| {
            let most_bytes = budget(Limits::default().most_bytes);
            let image = Image::load(path, &Limits { most_bytes, ..Limits::default() });
            let told = |error: ImageError| match &error.problem {
                Problem::TooManyPixels { .. } if most_bytes < Limits::default().most_bytes => {
                    format!("{}, because no more memory is available", error.problem)
                }
                problem => problem.to_string(),
            };
            let Image { bitmap, warnings } = image.map_err(|error| Trouble::whole(names::escaped(&told(error))))?;
            Ok(Picture { bitmap: Arc::new(bitmap), warnings })
        })
    }
}

/// What the image of a sky is made of: the direction toward the sun, turbidity, the ground's albedo, the sun's intensity.
type SkyKey = (DVec3, f32, Vec3, f32);

impl Depends for Picture {
    fn others(&self) -> impl Iterator<Item = &Path> {
        std::iter::empty()
    }
}

/// An image, and what the user should know of how it was read.
#[derive(Debug)]
pub(crate) struct Picture {
    pub bitmap: Arc<Bitmap>,
    /// Warnings, one sentence each, without the file's name.
    pub warnings: Vec<String>,
}

/// A model at the moment of the options, of a file that is kept open for those that follow.
fn in_sequence(
    sequences: &mut HashMap<PathBuf, GltfSequence>,
    path: &Path,
    options: &LoadOptions,
) -> Result<Model, ModelError> {
    let sequence = match sequences.entry(path.into()) {
        Entry::Occupied(known) => known.into_mut(),
        Entry::Vacant(place) => place.insert(GltfSequence::open(path, &GltfOptions::from(*options))?),
    };
    sequence.at(options.time_seconds)
}

/// Bytes that a file may take, of at most `most`: what is read is decoded in up to three times as much memory, and then
/// held by the scene and by the device.
fn budget(most: u64) -> u64 {
    raggio_memory::available_bytes().map_or(most, |bytes| most.min(bytes / 4))
}

/// Problem of a file; shown right after the file's name.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {message}")]
pub(crate) struct Trouble {
    pub place: Place,
    pub message: String,
}

impl Trouble {
    fn whole(message: impl Into<String>) -> Self {
        Self { place: Place::Whole, message: message.into() }
    }
}

/// Whether the file is a model rather than a scene, by its extension.
pub fn is_model(path: &Path) -> bool {
    Format::of_path(path).is_some()
}
