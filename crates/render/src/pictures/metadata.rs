//! Metadata of EXRs: what they say of how they were made.

use std::collections::HashMap;

use exr::prelude::{AttributeValue, LayerAttributes, Text};
use glam::{DMat4, DVec4};
use raggio_scene::{Camera, RenderSettings, Scene};

/// Record of how a picture was made.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// Name of the scene.
    pub scene: String,
    /// Most samples that a pixel has.
    pub samples: u32,
    /// Name of what removed the noise, with its version; `None` where nothing did.
    pub denoiser: Option<String>,
    settings: RenderSettings,
    camera: Camera,
}

impl Metadata {
    /// Metadata of a picture of `scene`, which is called `name`.
    pub fn new(scene: &Scene, name: &str) -> Self {
        Self {
            scene: name.into(),
            samples: scene.render.samples,
            denoiser: None,
            settings: scene.render.clone(),
            camera: scene.camera.clone(),
        }
    }

    /// Writes the metadata into the header of a layer.
    pub(crate) fn describe(&self, attributes: &mut LayerAttributes) {
        let camera_from_world = self.camera_from_world();
        attributes.world_to_camera = Some(row_vectors(camera_from_world));
        attributes.world_to_normalized_device = Some(row_vectors(self.ndc_from_camera() * camera_from_world));
        // OpenEXR's texts are UTF-8; the library would make Latin-1 of them.
        let text = |value: &str| AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()));
        let number = |value: u32| text(&value.to_string());
        let mut other: HashMap<&str, AttributeValue> = HashMap::from([
            ("scene", text(&self.scene)),
            ("samples", number(self.samples)),
            ("maxDepth", number(self.settings.max_depth)),
            ("seed", number(self.settings.seed)),
            ("integrator", text(self.settings.integrator.name())),
            ("sampler", text(self.settings.sampler.name())),
            ("filter", text(self.settings.filter.name())),
        ]);
        if let Some(denoiser) = &self.denoiser {
            other.insert("denoiser", text(denoiser));
        }
        attributes.other.extend(other.into_iter().map(|(name, value)| (Text::from(name), value)));
    }

    /// Map from the world to the camera as OpenEXR has it: left-handed, x to the right, y up, z where the camera looks.
    fn camera_from_world(&self) -> DMat4 {
        let eye = self.camera.position.as_dvec3();
        let forward = (self.camera.look_at.as_dvec3() - eye).normalize();
        let right = forward.cross(self.camera.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0)).inverse()
    }

    /// Map from the camera to the picture, whose top left corner is (0, 0) and whose bottom right one is (1, 1).
    fn ndc_from_camera(&self) -> DMat4 {
        let half_height = self.camera.half_height();
        let half_width = half_height * f64::from(self.settings.width) / f64::from(self.settings.height);
        let (x, y) = (DVec4::X * (0.5 / half_width), DVec4::Y * (-0.5 / half_height));
        match self.camera.orthographic_height {
            None => DMat4::from_cols(x, y, DVec4::new(0.5, 0.5, 1.0, 1.0), DVec4::new(0.0, 0.0, -1.0, 0.0)),
            Some(_) => DMat4::from_cols(x, y, DVec4::Z, DVec4::new(0.5, 0.5, 0.0, 1.0)),
        }
    }
}

/// Numbers of a matrix as OpenEXR stores them: by rows, for row vectors from the left, which are columns of ours.
fn row_vectors(matrix: DMat4) -> [f32; 16] {
    matrix.to_cols_array().map(|value| value as f32)
}
