//! Arbitrary output variables: the layers that say more of each pixel than its colour.

use std::collections::HashMap;
use std::ops::ControlFlow;

use raggio_choice::choice;
use raggio_kernels::{Feature, FilmPixel};

use crate::devices::device::DeviceError;
use crate::pictures::film::Film;
use crate::pictures::runs::collect;
use crate::renderer::Renderer;
use crate::translation::device_scene::DeviceScene;

choice! {
    /// A layer of an EXR beside the picture.
    pub enum Aov: "layer" {
        /// Colour of the first surface, or of a lamp's light: albedo.R, .G, .B
        Albedo = "albedo",
        /// Unit normal of the first surface in the world, on the side that is seen: normal.X, .Y, .Z
        Normal = "normal",
        /// Colour beyond smooth glass and in mirrors, for denoisers: guide_albedo.R, .G, .B
        GuideAlbedo = "guide_albedo",
        /// Normal of the surface with that colour, shorter where several are seen: guide_normal.X, .Y, .Z
        GuideNormal = "guide_normal",
        /// Distance of the first surface along the view direction, infinite where there is none: depth.Z
        Depth = "depth",
        /// Distance of the first surface along the ray, infinite where there is none: distance.Z
        Distance = "distance",
        /// Position of the first surface in the world: position.X, .Y, .Z
        Position = "position",
        /// Way in pixels, y upward, to where what is in the pixel's middle was a frame before: motion.X, .Y
        Motion = "motion",
        /// Number of the shape in the pixel's middle, in the scene's order from 1 on; 0 is none: object_id.I
        ObjectId = "object_id",
        /// Number of the material in the pixel's middle, in the scene's order from 1 on; 0 is none: material_id.I
        MaterialId = "material_id",
        /// Number of samples of the pixel: samples.N
        Samples = "samples",
        /// Variance of the mean luminance, as independent samples would have it: variance.Y
        Variance = "variance",
    }
}

/// A channel of an EXR.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the channel: `depth.Z`.
    pub name: String,
    /// Values, row by row from the top left.
    pub values: Values,
}

/// Values of a channel, one a pixel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Numbers that are measured.
    F32(Vec<f32>),
    /// Numbers that count.
    U32(Vec<u32>),
}

/// Films of features, each of the samples of the picture.
#[derive(Default)]
pub struct Features {
    films: HashMap<u32, Film>,
}

impl Aov {
    /// Features whose films the layer is made from, besides that of radiance.
    pub fn features(self) -> &'static [Feature] {
        match self {
            Self::Albedo => &[Feature::Albedo],
            Self::Normal => &[Feature::Normal, Feature::Hit],
            Self::GuideAlbedo => &[Feature::GuideAlbedo],
            Self::GuideNormal => &[Feature::GuideNormal],
            Self::Depth => &[Feature::PlaneDepth, Feature::Hit],
            Self::Distance => &[Feature::Depth, Feature::Hit],
            Self::Position => &[Feature::Position, Feature::Hit],
            Self::ObjectId => &[Feature::Object],
            Self::MaterialId => &[Feature::Material],
            Self::Motion => &[Feature::Motion],
            Self::Samples | Self::Variance => &[],
        }
    }

    /// Channels of the layer, made from the film of radiance and from [`Features`] that hold its own.
    pub fn channels(self, radiance: &Film, features: &Features, scene: &DeviceScene) -> Vec<Channel> {
        let whole = |of: &(dyn Fn(usize) -> u32 + Sync)| Values::U32(collect(radiance.pixels().len(), of));
        let number = |feature: Feature, i: usize| features.mean(feature, i)[0] as u32;
        match self {
            Self::Albedo => self.vector(["R", "G", "B"], features.vectors(Feature::Albedo)),
            Self::Normal => self.vector(["X", "Y", "Z"], features.normals()),
            Self::GuideAlbedo => self.vector(["R", "G", "B"], features.guide_albedos()),
            Self::GuideNormal => self.vector(["X", "Y", "Z"], features.guide_normals()),
            Self::Depth => vec![self.channel("Z", Values::F32(features.distances(Feature::PlaneDepth)))],
            Self::Distance => vec![self.channel("Z", Values::F32(features.distances(Feature::Depth)))],
            Self::Position => self.vector(["X", "Y", "Z"], features.positions()),
            Self::Motion => {
                let mut channels = self.vector(["X", "Y", ""], features.vectors(Feature::Motion));
                channels.truncate(2);
                channels
            }
            Self::ObjectId => {
                // Kernels number shapes by their place in the hierarchy.
                let shape = |place: u32| scene.shape_of_place.get(place.wrapping_sub(1) as usize);
                vec![self.channel("I", whole(&|i| shape(number(Feature::Object, i)).map_or(0, |shape| shape + 1)))]
            }
            Self::MaterialId => vec![self.channel("I", whole(&|i| number(Feature::Material, i)))],
            Self::Samples => vec![self.channel("N", whole(&|i| radiance.pixels()[i].samples))],
            Self::Variance => {
                let variance = |pixel: &FilmPixel| pixel.luminance_error().map_or(f32::INFINITY, |e| (e * e) as f32);
                vec![
                    self.channel(
                        "Y",
                        Values::F32(collect(radiance.pixels().len(), |i| variance(&radiance.pixels()[i]))),
                    ),
                ]
            }
        }
    }

    fn channel(self, component: &str, values: Values) -> Channel {
        Channel { name: format!("{}.{component}", self.name()), values }
    }

    fn vector(self, components: [&str; 3], values: Vec<[f32; 3]>) -> Vec<Channel> {
        let component = |i: usize| Values::F32(values.iter().map(|value| value[i]).collect());
        (0..3).map(|i| self.channel(components[i], component(i))).collect()
    }
}

impl Features {
    /// Features that guide a denoiser: [`Features::guide_albedos`] and [`Features::guide_normals`] are made from these.
    pub const GUIDES: [Feature; 2] = [Feature::GuideAlbedo, Feature::GuideNormal];

    /// Renders each of `wanted` once, with `samples` samples a pixel, or at least one if `proceed`, which is asked
    /// after each portion, no longer lets it. The film that is shown stays as it is.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn render(
        renderer: &mut Renderer,
        wanted: &[Feature],
        mut samples: u32,
        mut proceed: impl FnMut() -> ControlFlow<()>,
    ) -> Result<Self, DeviceError> {
        let mut features = Self::default();
        let mut is_second_try = false;
        loop {
            match features.advance(renderer, wanted, samples, f64::INFINITY) {
                Ok(true) => return Ok(features),
                Ok(false) => is_second_try = false,
                // Less of it may fit.
                Err(error) if error.is_out_of_memory() && !is_second_try => is_second_try = true,
                Err(error) => return Err(error),
            }
            if proceed().is_break() {
                samples = 1;
            }
        }
    }

    /// Renders one portion, of about `seconds`, of the first of `wanted` that is not there yet. Returns whether all are
    /// there. The film that is shown stays as it is.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn advance(
        &mut self,
        renderer: &mut Renderer,
        wanted: &[Feature],
        samples: u32,
        seconds: f64,
    ) -> Result<bool, DeviceError> {
        let Some(feature) = wanted.iter().copied().find(|feature| !self.films.contains_key(&(*feature as u32))) else {
            return Ok(true);
        };
        let (shown, target) = (renderer.feature(), renderer.target());
        renderer.show(feature)?;
        renderer.set_target(if feature.is_single() { 1 } else { samples });
        let film = renderer.advance_for(seconds).and_then(|_| renderer.finished().then(|| renderer.film()).transpose());
        if film.is_err() {
            renderer.begin_small();
        }
        renderer.set_target(target);
        renderer.show(shown)?;
        if let Some(film) = film? {
            self.films.insert(feature as u32, film);
        }
        Ok(wanted.iter().all(|feature| self.films.contains_key(&(*feature as u32))))
    }

    /// Mean colours of what is seen through smooth glass and in mirrors too, row by row from the top left; black where
    /// there is nothing.
    pub fn guide_albedos(&self) -> Vec<[f32; 3]> {
        self.vectors(Feature::GuideAlbedo)
    }

    /// Mean normals of the surfaces that [`Features::guide_albedos`] are of; 0 where there is none, and shorter than 1
    /// where several are seen.
    pub fn guide_normals(&self) -> Vec<[f32; 3]> {
        let normal = |i: usize| self.mean(Feature::GuideNormal, i).map(|encoded| (2.0 * encoded - 1.0) as f32);
        collect(self.pixels(), normal)
    }

    /// Mean normals of the first surfaces; 0 where there is none, and shorter than 1 where several are seen.
    fn normals(&self) -> Vec<[f32; 3]> {
        let normal = |i: usize| {
            let [coverage, ..] = self.mean(Feature::Hit, i);
            self.mean(Feature::Normal, i).map(|encoded| (2.0 * encoded - coverage) as f32)
        };
        collect(self.pixels(), normal)
    }

    /// Mean distances, as `feature` measures them, of what is covered in each pixel; infinite where nothing is.
    fn distances(&self, feature: Feature) -> Vec<f32> {
        let distance = |i: usize| match self.mean(Feature::Hit, i)[0] {
            coverage if coverage > 0.0 => (self.mean(feature, i)[0] / coverage) as f32,
            _ => f32::INFINITY,
        };
        collect(self.pixels(), distance)
    }

    /// Mean positions of what is covered in each pixel; 0 where nothing is.
    fn positions(&self) -> Vec<[f32; 3]> {
        let position = |i: usize| match self.mean(Feature::Hit, i)[0] {
            coverage if coverage > 0.0 => self.mean(Feature::Position, i).map(|sum| (sum / coverage) as f32),
            _ => [0.0; 3],
        };
        collect(self.pixels(), position)
    }

    fn vectors(&self, feature: Feature) -> Vec<[f32; 3]> {
        collect(self.pixels(), |i| self.mean(feature, i).map(|channel| channel as f32))
    }

    fn mean(&self, feature: Feature, pixel: usize) -> [f64; 3] {
        self.films.get(&(feature as u32)).map_or([0.0; 3], |film| film.pixels()[pixel].mean())
    }

    fn pixels(&self) -> usize {
        self.films.values().next().map_or(0, |film| film.pixels().len())
    }
}
