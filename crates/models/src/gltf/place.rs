//! Instances, lights and cameras made from nodes.

use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};

use super::asset::Asset;
use super::document::{Attributes, LightType, Node, Orthographic, Perspective, Spot};
use super::fault::at;
use super::mesh::RestMesh;
use super::nodes::{self, Place, Pose};
use super::pose;
use crate::error::Fault;
use crate::mesh::{Dropped, Mesh};
use crate::model::{Camera, Instance, Light, LightKind, Model, Projection};
use crate::text::counted;

/// Meshes that neither skins nor morph targets change, by glTF's numbers: `None` where nothing is left.
#[derive(Default)]
pub(super) struct StillMeshes(HashMap<usize, StillMesh>);

struct StillMesh {
    mesh: Option<Arc<Mesh>>,
    dropped: Dropped,
    warnings: Vec<String>,
}

/// Fills a model, node by node.
pub(super) struct Builder<'a> {
    asset: &'a Asset<'a>,
    pose: &'a Pose,
    worlds: &'a [DAffine3],
    still: &'a mut StillMeshes,
    model: Model,
    /// Indices of the model's meshes by glTF's and the bits of the morph weights; `None` where nothing is left.
    shared: HashMap<(usize, Vec<u32>), Option<usize>>,
    dropped: Dropped,
    /// Number of instances that cannot be seen.
    flat: usize,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        asset: &'a Asset<'a>,
        pose: &'a Pose,
        worlds: &'a [DAffine3],
        still: &'a mut StillMeshes,
    ) -> Self {
        let (model, dropped) = (Model::default(), Dropped::default());
        Self { asset, pose, worlds, still, model, shared: HashMap::new(), dropped, flat: 0 }
    }

    pub(super) fn add_node(&mut self, number: usize) -> Result<(), Fault> {
        let node = &self.asset.document.nodes[number];
        let world = self.worlds[number];
        if let Some(mesh) = node.mesh {
            self.add_mesh(number, node, mesh)?;
        } else if node.skin.is_some() || node.instancing().is_some() {
            self.asset.warnings.push(format!("nodes[{number}]: its skin or instancing has no mesh to work on"));
        }
        if let Some(light) = node.light() {
            self.add_light(node, light, &world);
        }
        if let Some(camera) = node.camera {
            self.add_camera(node, camera, &world);
        }
        Ok(())
    }

    /// The model without its materials, with warnings of what was left out on the way.
    pub(super) fn finish(self) -> Model {
        self.dropped.warning().into_iter().for_each(|warning| self.asset.warnings.push(warning));
        if self.flat > 0 {
            let (flat, are) = (counted(self.flat, "instance"), if self.flat == 1 { "is" } else { "are" });
            self.asset.warnings.push(format!("{flat} {are} scaled to nothing in some direction and left out"));
        }
        if self.model.instances.is_empty() {
            self.asset.warnings.push("there are no triangles in the scene");
        }
        self.model
    }

    fn add_mesh(&mut self, number: usize, node: &Node, mesh: usize) -> Result<(), Fault> {
        let weights = self.weights(number, node, mesh);
        if let Some(skin) = node.skin {
            if node.instancing().is_some() {
                self.asset.warnings.push(format!("nodes[{number}]: a skin cannot be instanced; it is shown once"));
            }
            // Skins say where vertices are in the world, whatever the node's own transform.
            let matrices = pose::joint_matrices(self.asset, skin, self.worlds)?;
            let (mesh, dropped) = self.load_mesh(mesh, &weights, Some((&matrices, &self.worlds[number])))?;
            let mesh = self.keep(mesh, dropped);
            self.instantiate(node.name.as_str().into(), mesh, DAffine3::IDENTITY);
            return Ok(());
        }
        let key = (mesh, weights.iter().map(|weight| weight.to_bits()).collect());
        let mesh = match self.shared.get(&key) {
            Some(mesh) => *mesh,
            None => {
                let (loaded, dropped) =
                    if weights.is_empty() { self.still_mesh(mesh)? } else { self.load_mesh(mesh, &weights, None)? };
                let kept = self.keep(loaded, dropped);
                self.shared.insert(key, kept);
                kept
            }
        };
        let name: Arc<str> = node.name.as_str().into();
        let world = self.worlds[number];
        match node.instancing() {
            None => self.instantiate(name, mesh, world),
            Some(attributes) => {
                let path = format!("nodes[{number}].extensions.EXT_mesh_gpu_instancing");
                let places = instances(self.asset, attributes, &path)?;
                self.asset.budget.take(places.len(), size_of::<Instance>(), &path)?;
                self.model.instances.reserve(places.len());
                places.iter().for_each(|place| self.instantiate(name.clone(), mesh, world * place.matrix()));
            }
        }
        Ok(())
    }

    /// Weights of the morph targets; none where all are zero.
    fn weights(&self, number: usize, node: &Node, mesh: usize) -> Vec<f32> {
        let animated = self.pose.weights.get(&number);
        let weights = animated.or(node.weights.as_ref()).or(self.asset.document.meshes[mesh].weights.as_ref());
        weights.filter(|weights| weights.iter().any(|weight| *weight != 0.0)).cloned().unwrap_or_default()
    }

    /// A mesh at rest, decoded when it is first asked for.
    fn still_mesh(&mut self, number: usize) -> Result<(Option<Arc<Mesh>>, Dropped), Fault> {
        if !self.still.0.contains_key(&number) {
            let (loaded, warnings) = self.asset.warnings.apart(|| self.load_mesh(number, &[], None));
            let (mesh, dropped) = loaded?;
            self.still.0.insert(number, StillMesh { mesh, dropped, warnings });
        }
        let StillMesh { mesh, dropped, warnings } = &self.still.0[&number];
        self.asset.warnings.repeat(warnings);
        Ok((mesh.clone(), *dropped))
    }

    /// Adds a mesh to the model, and returns its index there.
    fn keep(&mut self, mesh: Option<Arc<Mesh>>, dropped: Dropped) -> Option<usize> {
        self.dropped.degenerate += dropped.degenerate;
        self.dropped.not_finite += dropped.not_finite;
        self.dropped.repeated += dropped.repeated;
        self.dropped.attributes += dropped.attributes;
        self.model.meshes.push(mesh?);
        Some(self.model.meshes.len() - 1)
    }

    fn load_mesh(
        &self,
        number: usize,
        weights: &[f32],
        skin: Option<(&[DAffine3], &DAffine3)>,
    ) -> Result<(Option<Arc<Mesh>>, Dropped), Fault> {
        let mut rest = RestMesh::load(self.asset, number)?;
        pose::morph(self.asset, &mut rest, weights)?;
        if let Some((joints, node)) = skin {
            pose::skin(self.asset, &mut rest, joints, node)?;
        }
        let mut mesh = rest.mesh;
        let dropped = mesh.clean("").map_err(|error| at(format!("meshes[{number}]"), error.message))?;
        let is_empty = mesh.triangles.is_empty();
        Ok(((!is_empty).then(|| Arc::new(mesh)), dropped))
    }

    fn instantiate(&mut self, name: Arc<str>, mesh: Option<usize>, model_from_mesh: DAffine3) {
        let Some(mesh) = mesh else { return };
        if model_from_mesh.is_finite() && model_from_mesh.inverse().is_finite() {
            self.model.instances.push(Instance { name, mesh, model_from_mesh });
        } else {
            self.flat += 1;
        }
    }

    fn add_light(&mut self, node: &Node, number: usize, world: &DAffine3) {
        let light = &self.asset.document.extensions.lights.lights[number];
        let path = format!("extensions.KHR_lights_punctual.lights[{number}]");
        if light.range.is_some() {
            self.asset.warnings.push("ranges of lights are not used: light goes on for ever");
        }
        let (color, strength) = (light.color.unwrap_or([1.0; 3]), light.intensity.unwrap_or(1.0));
        let intensity = color.map(|c| c * strength);
        if !intensity.iter().all(|i| i.is_finite() && *i >= 0.0) {
            let message = format!("its intensity is {intensity:?}, and should be finite and not negative");
            self.asset.warnings.push(format!("{path} is left out: {message}"));
            return;
        }
        let kind = match light.kind {
            LightType::Directional => LightKind::Directional,
            LightType::Point => LightKind::Point,
            LightType::Spot => self.spot(&light.spot, &path),
        };
        let direction = world.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
        let name = name(&node.name, &light.name);
        self.model.lights.push(Light { name, intensity, position: world.translation, direction, kind });
    }

    /// A spot with its angles in order. Equal ones are common, though glTF has the outer one greater: they make a hard edge.
    fn spot(&self, spot: &Spot, path: &str) -> LightKind {
        let (written_inner, written_outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
        let (written_inner, written_outer) = (written_inner.unwrap_or(0.0), written_outer.unwrap_or(FRAC_PI_4));
        let outer = written_outer.clamp(0.0, FRAC_PI_2);
        let inner = written_inner.clamp(0.0, outer);
        // Files round the right angle up.
        if inner != written_inner || (outer - written_outer).abs() > 1e-6 {
            let message = format!("the angles are {written_inner} and {written_outer}: {inner} and {outer} are used");
            self.asset.warnings.push(format!("{path}.spot: {message}, for 0 <= inner <= outer <= pi / 2"));
        }
        LightKind::Spot { inner, outer }
    }

    fn add_camera(&mut self, node: &Node, number: usize, world: &DAffine3) {
        let camera = &self.asset.document.cameras[number];
        let projection = match (&camera.perspective, &camera.orthographic) {
            (Some(perspective), _) => Some(self.perspective(perspective, number)),
            (None, Some(orthographic)) => self.orthographic(orthographic, number),
            (None, None) => {
                let message = "it should be `perspective` or `orthographic`";
                self.asset.warnings.push(format!("cameras[{number}] is left out: {message}"));
                None
            }
        };
        let Some(projection) = projection else { return };
        let forward = world.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
        let up = world.transform_vector3(DVec3::Y).reject_from_normalized(forward);
        self.model.cameras.push(Camera {
            name: name(&node.name, &camera.name),
            position: world.translation,
            forward,
            up: up.normalize_or(forward.any_orthonormal_vector()),
            projection,
        });
    }

    fn perspective(&self, written: &Perspective, number: usize) -> Projection {
        let Perspective { yfov: mut vertical_fov, aspect_ratio: mut aspect } = *written;
        let warn = |key: &str, message: String| {
            self.asset.warnings.push(format!("cameras[{number}].perspective.{key} is {message}"));
        };
        if !(vertical_fov > 0.0 && vertical_fov < PI) {
            warn("yfov", format!("{vertical_fov}, and should be between 0 and pi radians: {FRAC_PI_4} is used"));
            vertical_fov = FRAC_PI_4;
        }
        if let Some(written) = aspect.filter(|aspect| !(*aspect > 0.0 && aspect.is_finite())) {
            warn("aspectRatio", format!("{written}, and should be positive and finite: it is not used"));
            aspect = None;
        }
        Projection::Perspective { vertical_fov, aspect }
    }

    /// An orthographic projection; the sign of a magnification would mirror the picture, and is not used.
    fn orthographic(&self, written: &Orthographic, number: usize) -> Option<Projection> {
        let Orthographic { xmag, ymag } = *written;
        let path = format!("cameras[{number}].orthographic");
        if ![xmag, ymag].iter().all(|mag| *mag != 0.0 && mag.is_finite()) {
            let message = format!("`xmag` and `ymag` are {xmag} and {ymag}, and should be finite and not 0");
            self.asset.warnings.push(format!("cameras[{number}] is left out: {message}"));
            return None;
        }
        if xmag < 0.0 || ymag < 0.0 {
            self.asset
                .warnings
                .push(format!("{path}: `xmag` and `ymag` are {xmag} and {ymag}: their signs are not used"));
        }
        Some(Projection::Orthographic { xmag: xmag.abs(), ymag: ymag.abs() })
    }
}

fn name(node: &str, object: &str) -> String {
    if node.is_empty() { object.to_string() } else { node.to_string() }
}

/// The places of EXT_mesh_gpu_instancing, relative to the node.
fn instances(asset: &Asset<'_>, attributes: &Attributes, path: &str) -> Result<Vec<Place>, Fault> {
    let translations = instance_attribute::<3>(asset, attributes, "TRANSLATION", path)?;
    let rotations = instance_attribute::<4>(asset, attributes, "ROTATION", path)?;
    let scales = instance_attribute::<3>(asset, attributes, "SCALE", path)?;
    let known = ["TRANSLATION", "ROTATION", "SCALE"];
    for name in attributes.keys().filter(|name| !known.contains(&name.as_str()) && !name.starts_with('_')) {
        asset.warnings.push(format!("{path}: the attribute {} is not used", crate::text::quoted(name.as_bytes())));
    }
    let count = attributes.values().next().map_or(0, |accessor| asset.accessor(*accessor).count);
    asset.budget.take(count, size_of::<Place>(), path)?;
    let place = |i: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |list| DQuat::from_array(list[i].map(f64::from)));
        let rotation = nodes::rotation(rotation, format_args!("{path}: the rotation of instance {i}"), &asset.warnings);
        let translation = translations.as_ref().map_or(DVec3::ZERO, |list| DVec3::from(list[i].map(f64::from)));
        let scale = scales.as_ref().map_or(DVec3::ONE, |list| DVec3::from(list[i].map(f64::from)));
        Place { translation, rotation, scale }
    };
    Ok((0..count).map(place).collect())
}

fn instance_attribute<const N: usize>(
    asset: &Asset<'_>,
    attributes: &Attributes,
    name: &str,
    path: &str,
) -> Result<Option<Vec<[f32; N]>>, Fault> {
    let values = |accessor: &usize| asset.floats_as_stored(*accessor, None, &format!("{path}.attributes.{name}"));
    attributes.get(name).map(values).transpose()
}
