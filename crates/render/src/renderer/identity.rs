//! Identity of what a renderer renders, for the labels of its films.

use std::sync::{Arc, OnceLock};

use raggio_kernels::SceneBuffers;
use raggio_scene::RenderSettings;

use crate::pictures::film::{Label, Portion};
use crate::translation::device_scene::DeviceScene;

/// Label of a film that is made when somebody asks for it: it takes a hash of the whole scene.
#[derive(Clone)]
pub(crate) struct LateLabel {
    identity: Arc<Identity>,
    settings: Vec<(String, String)>,
    portions: Vec<Portion>,
}

/// Identity of a scene in the labels of its films. Hashing a large scene takes a while, and not all films need a label.
pub(super) struct Identity {
    buffers: SceneBuffers,
    settings: RenderSettings,
    hash: OnceLock<[u8; 32]>,
}

impl LateLabel {
    pub(super) fn new(identity: Arc<Identity>, settings: Vec<(String, String)>, portions: Vec<Portion>) -> Self {
        Self { identity, settings, portions }
    }

    /// Makes the label.
    pub fn make(&self) -> Label {
        Label::new(self.identity.hash(), self.settings.clone(), self.portions.clone())
    }
}

impl std::fmt::Debug for LateLabel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("LateLabel").field(&self.portions).finish()
    }
}

impl Identity {
    pub fn new(scene: &DeviceScene) -> Self {
        Self { buffers: scene.buffers.clone(), settings: scene.settings.clone(), hash: OnceLock::new() }
    }

    /// This identity without what its hash does not need.
    pub fn settled(&self) -> Self {
        let buffers = SceneBuffers { mesh_nodes: Arc::default(), ..self.buffers.clone() };
        Self { buffers, settings: self.settings.clone(), hash: self.hash.clone() }
    }

    /// Settings of the render.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Hash of the scene.
    fn hash(&self) -> [u8; 32] {
        *self.hash.get_or_init(|| scene_hash(&self.buffers))
    }
}

/// Lists that tell how the scene has moved, by their names.
const MOTION: [&str; 2] = ["motion", "motion_rows"];

/// Lists that decide how fast surfaces are found, and never which: hits are the same in any hierarchy.
const HIERARCHY: [&str; 2] = ["nodes", "mesh_nodes"];

/// Hash of all that decides a sample of radiance in a scene. The filter's table is a setting.
pub(crate) fn scene_hash(buffers: &SceneBuffers) -> [u8; 32] {
    hash(buffers, |name| name != "filter_table" && !MOTION.contains(&name) && !HIERARCHY.contains(&name))
}

/// Hash of how a scene has moved since the frame before.
pub(crate) fn motion_hash(buffers: &SceneBuffers) -> [u8; 32] {
    hash(buffers, |name| MOTION.contains(&name))
}

fn hash(buffers: &SceneBuffers, is_part: impl Fn(&str) -> bool) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for list in buffers.bytes().iter().filter(|list| is_part(list.name)) {
        // Lengths keep lists apart.
        hasher.update(list.name.as_bytes()).update(&(list.bytes.len() as u64).to_le_bytes()).update(list.bytes);
    }
    *hasher.finalize().as_bytes()
}

/// Settings that decide the values of samples, as a label has them.
pub(crate) fn settings(settings: &RenderSettings, noise: Option<f64>) -> Vec<(String, String)> {
    let RenderSettings {
        integrator,
        sampler,
        seed,
        filter,
        max_depth,
        clamp,
        alpha,
        surface_offset,
        width: _,
        height: _,
        samples: _,
    } = settings;
    let optional = |value: Option<String>| value.unwrap_or_else(|| "none".into());
    [
        ("integrator", integrator.to_string()),
        ("sampler", sampler.to_string()),
        ("seed", seed.to_string()),
        ("filter", filter.to_string()),
        ("max_depth", max_depth.to_string()),
        ("clamp", optional(clamp.map(|clamp| clamp.to_string()))),
        ("alpha", alpha.to_string()),
        ("surface_offset", surface_offset.to_string()),
        ("noise", optional(noise.map(short))),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}

/// A number as it was written: most are of 32 bits first, and have fewer digits so.
fn short(number: f64) -> String {
    let narrow = number as f32;
    if f64::from(narrow) == number { narrow.to_string() } else { number.to_string() }
}
