//! Metadata of EXRs: what they say of how they were made.

use std::collections::HashMap;

use exr::prelude::{AttributeValue, LayerAttributes, Text};
use glam::{DMat4, DVec4};
use raggio_scene::{Camera, Intrinsics, Projection, RenderSettings, Scene};

use crate::pictures::film::{Film, Note};
use crate::pictures::fingerprint::Fingerprint;

/// Settings that EXRs name, by their names in [labels](crate::Label) of films.
const SETTINGS: [(&str, &str); 5] = [
    ("max_depth", "maxDepth"),
    ("seed", "seed"),
    ("integrator", "integrator"),
    ("sampler", "sampler"),
    ("filter", "filter"),
];

/// Names of notes on films.
const SCENE: &str = "scene";
const WORLD_TO_CAMERA: &str = "worldToCamera";
const WORLD_TO_NDC: &str = "worldToNDC";

/// Record of how a picture was made.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Name of the scene.
    pub scene: String,
    /// Most samples that a pixel has.
    pub samples: u32,
    /// Name of what removed the noise, with its version; `None` where nothing did.
    pub denoiser: Option<String>,
    /// Fingerprint of the picture, if it has all its samples and layers; files have it too then.
    pub fingerprint: Option<Fingerprint>,
    /// Version of raggio that took the samples.
    version: String,
    /// Settings as EXRs name them, and their values.
    settings: Vec<(&'static str, String)>,
    /// `worldToCamera`, as OpenEXR defines it; `None` where nobody knows.
    camera: Option<[f32; 16]>,
    /// `worldToNDC`, as OpenEXR defines it; `None` where nobody knows, and for panoramas.
    ndc: Option<[f32; 16]>,
}

impl Metadata {
    /// Metadata of a picture of `scene`, which is called `name`.
    pub fn new(scene: &Scene, name: &str) -> Self {
        let view = View { camera: &scene.camera, settings: &scene.render };
        let camera_from_world = view.camera_from_world();
        let RenderSettings { max_depth, seed, integrator, sampler, filter, .. } = &scene.render;
        let values =
            [max_depth.to_string(), seed.to_string(), integrator.to_string(), sampler.to_string(), filter.to_string()];
        Self {
            scene: name.into(),
            samples: scene.render.samples,
            denoiser: None,
            fingerprint: None,
            version: env!("CARGO_PKG_VERSION").into(),
            settings: SETTINGS.iter().map(|(_, name)| *name).zip(values).collect(),
            camera: Some(row_vectors(camera_from_world)),
            ndc: view.ndc_from_camera().map(|ndc_from_camera| row_vectors(ndc_from_camera * camera_from_world)),
        }
    }

    /// Metadata of a picture that is made of a film from a file; `None` for films without labels.
    pub fn of_film(film: &Film) -> Option<Self> {
        let label = film.label()?;
        let setting = |(key, name): &(&str, &'static str)| {
            label.settings().find(|(known, _)| known == key).map(|(_, value)| (*name, value.to_owned()))
        };
        let matrix = |name: &str| {
            let words: [u32; 16] = bytemuck::try_pod_read_unaligned(label.note(name)?).ok()?;
            Some(words.map(|word| f32::from_bits(u32::from_le(word))))
        };
        Some(Self {
            scene: String::from_utf8_lossy(label.note(SCENE).unwrap_or_default()).into_owned(),
            samples: film.most_samples(),
            denoiser: None,
            fingerprint: None,
            version: label.version().into(),
            settings: SETTINGS.iter().filter_map(setting).collect(),
            camera: matrix(WORLD_TO_CAMERA),
            ndc: matrix(WORLD_TO_NDC),
        })
    }

    /// Notes for a film, from which [`Metadata::of_film`] knows what its label does not say.
    pub(crate) fn notes(&self) -> Vec<Note> {
        let bytes = |matrix: &[f32; 16]| matrix.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
        let matrices = [(WORLD_TO_CAMERA, &self.camera), (WORLD_TO_NDC, &self.ndc)];
        let matrices = matrices.into_iter().filter_map(|(name, matrix)| Some(Note::new(name, bytes(matrix.as_ref()?))));
        std::iter::once(Note::new(SCENE, self.scene.as_bytes())).chain(matrices).collect()
    }

    /// Writes the metadata into the header of a layer.
    pub(crate) fn describe(&self, attributes: &mut LayerAttributes) {
        attributes.software_name = Some(format!("raggio {}", self.version).as_str().into());
        attributes.world_to_camera = self.camera;
        attributes.world_to_normalized_device = self.ndc;
        // OpenEXR's texts are UTF-8; the library would make Latin-1 of them.
        let text = |value: &str| AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()));
        let mut other: HashMap<&str, AttributeValue> =
            HashMap::from([("scene", text(&self.scene)), ("samples", text(&self.samples.to_string()))]);
        other.extend(self.settings.iter().map(|(name, value)| (*name, text(value))));
        if let Some(denoiser) = &self.denoiser {
            other.insert("denoiser", text(denoiser));
        }
        attributes.other.extend(other.into_iter().map(|(name, value)| (Text::from(name), value)));
    }
}

/// Camera and size of a picture, of which its matrices are made.
struct View<'a> {
    camera: &'a Camera,
    settings: &'a RenderSettings,
}

impl View<'_> {
    /// Map from the world to the camera as OpenEXR has it: left-handed, x to the right, y up, z where the camera looks.
    fn camera_from_world(&self) -> DMat4 {
        let eye = self.camera.position.as_dvec3();
        let forward = (self.camera.look_at.as_dvec3() - eye).normalize();
        let right = forward.cross(self.camera.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0)).inverse()
    }

    /// Map from the camera to the picture, whose top left corner is (0, 0) and whose bottom right one is (1, 1); `None` for a
    /// panorama, which no matrix maps.
    fn ndc_from_camera(&self) -> Option<DMat4> {
        let [width, height] = [self.settings.width, self.settings.height];
        let half_height = self.camera.half_height();
        let half_width = half_height * f64::from(width) / f64::from(height);
        let (x, y) = (DVec4::X * (0.5 / half_width), DVec4::Y * (-0.5 / half_height));
        let last = DVec4::new(0.0, 0.0, -1.0, 0.0);
        match self.camera.projection {
            Projection::Perspective { .. } => Some(DMat4::from_cols(x, y, DVec4::new(0.5, 0.5, 1.0, 1.0), last)),
            Projection::Calibrated(intrinsics) => {
                let Intrinsics { focal, principal_point, skew, size } = intrinsics.resized(width, height);
                let [width, height] = size.map(f64::from);
                let [fx, fy] = focal.map(f64::from);
                let [cx, cy] = principal_point.map(f64::from);
                Some(DMat4::from_cols(
                    DVec4::X * (fx / width),
                    DVec4::new(-f64::from(skew) / width, -fy / height, 0.0, 0.0),
                    DVec4::new(cx / width, cy / height, 1.0, 1.0),
                    last,
                ))
            }
            Projection::Orthographic { .. } => Some(DMat4::from_cols(x, y, DVec4::Z, DVec4::new(0.5, 0.5, 0.0, 1.0))),
            Projection::Panoramic(_) => None,
        }
    }
}

/// Numbers of a matrix as OpenEXR stores them: by rows, for row vectors from the left, which are columns of ours.
fn row_vectors(matrix: DMat4) -> [f32; 16] {
    matrix.to_cols_array().map(|value| value as f32)
}
