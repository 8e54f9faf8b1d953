//! Checks of a document that need no buffers, so that the rest may index freely.

mod data;
mod graph;

use super::document::{Animation, Attributes, Document, Material, Mesh, Node, Primitive, Skin, Texture};
use super::fault::at;
use crate::error::Fault;

pub(super) use graph::roots_first;

/// Checks every reference and every range.
pub(super) fn check(document: &Document) -> Result<(), Fault> {
    data::check(document)?;
    for (i, image) in document.images.iter().enumerate() {
        optional(&format!("images[{i}]"), "bufferView", image.buffer_view, document.buffer_views.len())?;
    }
    each("textures", &document.textures, |path, texture| check_texture(document, path, texture))?;
    each("materials", &document.materials, |path, material| check_material(document, path, material))?;
    each("meshes", &document.meshes, |path, mesh| check_mesh(document, path, mesh))?;
    each("skins", &document.skins, |path, skin| check_skin(document, path, skin))?;
    each("animations", &document.animations, |path, animation| check_animation(document, path, animation))?;
    each("nodes", &document.nodes, |path, node| check_node(document, path, node))?;
    optional("document", "scene", document.scene, document.scenes.len())?;
    each("scenes", &document.scenes, |path, scene| {
        scene.nodes.iter().try_for_each(|node| reference(path, "nodes", *node, document.nodes.len()))
    })
}

fn each<T>(name: &str, list: &[T], check: impl Fn(&str, &T) -> Result<(), Fault>) -> Result<(), Fault> {
    list.iter().enumerate().try_for_each(|(i, item)| check(&format!("{name}[{i}]"), item))
}

/// Checks that `index`, which stands in `path` under `key`, is one of `count` things.
fn reference(path: &str, key: &str, index: usize, count: usize) -> Result<(), Fault> {
    if index < count {
        return Ok(());
    }
    Err(at(format!("{path}.{key}"), format!("is {index}: it should be below {count}, the number of what there is")))
}

fn optional(path: &str, key: &str, index: Option<usize>, count: usize) -> Result<(), Fault> {
    index.map_or(Ok(()), |index| reference(path, key, index, count))
}

fn check_texture(document: &Document, path: &str, texture: &Texture) -> Result<(), Fault> {
    optional(path, "sampler", texture.sampler, document.samplers.len())?;
    texture.sources().try_for_each(|source| reference(path, "source", source, document.images.len()))
}

fn check_material(document: &Document, path: &str, material: &Material) -> Result<(), Fault> {
    let textures = document.textures.len();
    let occlusion = material.occlusion_texture.as_ref().map(|info| ("occlusionTexture", info));
    let volume = material.extensions().volume.as_ref();
    let thickness = volume.and_then(|volume| volume.thickness_texture.as_ref()).map(|info| ("thicknessTexture", info));
    let mut infos = material.textures().chain(occlusion).chain(thickness);
    infos.try_for_each(|(name, info)| reference(path, &format!("{name}.index"), info.index, textures))
}

fn check_mesh(document: &Document, path: &str, mesh: &Mesh) -> Result<(), Fault> {
    let targets = mesh.primitives.first().map_or(0, |primitive| primitive.targets.len());
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let path = format!("{path}.primitives[{i}]");
        check_primitive(document, &path, primitive)?;
        if primitive.targets.len() != targets {
            return Err(at(path, "all primitives of a mesh should have the same number of morph targets"));
        }
    }
    check_weights(path, mesh.weights.as_deref())
}

fn check_weights(path: &str, weights: Option<&[f32]>) -> Result<(), Fault> {
    let finite = weights.unwrap_or_default().iter().all(|weight| weight.is_finite());
    if finite { Ok(()) } else { Err(at(format!("{path}.weights"), "should be finite")) }
}

fn check_primitive(document: &Document, path: &str, primitive: &Primitive) -> Result<(), Fault> {
    optional(path, "material", primitive.material, document.materials.len())?;
    optional(path, "indices", primitive.indices, document.accessors.len())?;
    check_attributes(document, &format!("{path}.attributes"), &primitive.attributes)?;
    let vertices = first_count(document, &primitive.attributes);
    for (i, target) in primitive.targets.iter().enumerate() {
        let path = format!("{path}.targets[{i}]");
        check_attributes(document, &path, target)?;
        if !target.is_empty() && first_count(document, target) != vertices {
            return Err(at(path, "should have as many elements as the primitive has vertices"));
        }
    }
    let draco = primitive.extensions.draco.as_ref().map(|draco| draco.buffer_view);
    optional(path, "extensions.KHR_draco_mesh_compression.bufferView", draco, document.buffer_views.len())
}

/// Number of elements of the accessors, which all have equally many.
fn first_count(document: &Document, attributes: &Attributes) -> usize {
    attributes.values().next().map_or(0, |accessor| document.accessors[*accessor].count)
}

fn check_attributes(document: &Document, path: &str, attributes: &Attributes) -> Result<(), Fault> {
    for (name, accessor) in attributes {
        reference(path, name, *accessor, document.accessors.len())?;
        let (count, first) = (document.accessors[*accessor].count, first_count(document, attributes));
        if count != first {
            let message = format!("has {count} elements, others have {first}: there should be one for each");
            return Err(at(format!("{path}.{name}"), message));
        }
    }
    Ok(())
}

fn check_skin(document: &Document, path: &str, skin: &Skin) -> Result<(), Fault> {
    skin.joints.iter().try_for_each(|joint| reference(path, "joints", *joint, document.nodes.len()))?;
    let Some(matrices) = skin.inverse_bind_matrices else { return Ok(()) };
    reference(path, "inverseBindMatrices", matrices, document.accessors.len())?;
    let (count, joints) = (document.accessors[matrices].count, skin.joints.len());
    if count < joints {
        let message = format!("has {count} matrices: there should be one for each of the {joints} joints");
        return Err(at(format!("{path}.inverseBindMatrices"), message));
    }
    Ok(())
}

fn check_animation(document: &Document, path: &str, animation: &Animation) -> Result<(), Fault> {
    for (i, sampler) in animation.samplers.iter().enumerate() {
        let path = format!("{path}.samplers[{i}]");
        reference(&path, "input", sampler.input, document.accessors.len())?;
        reference(&path, "output", sampler.output, document.accessors.len())?;
    }
    for (i, channel) in animation.channels.iter().enumerate() {
        let path = format!("{path}.channels[{i}]");
        reference(&path, "sampler", channel.sampler, animation.samplers.len())?;
        optional(&path, "target.node", channel.target.node, document.nodes.len())?;
    }
    Ok(())
}

fn check_node(document: &Document, path: &str, node: &Node) -> Result<(), Fault> {
    node.children.iter().try_for_each(|child| reference(path, "children", *child, document.nodes.len()))?;
    optional(path, "mesh", node.mesh, document.meshes.len())?;
    optional(path, "skin", node.skin, document.skins.len())?;
    optional(path, "camera", node.camera, document.cameras.len())?;
    let lights = document.extensions.lights.lights.len();
    optional(path, "extensions.KHR_lights_punctual.light", node.light(), lights)?;
    if let Some(attributes) = node.instancing() {
        check_attributes(document, &format!("{path}.extensions.EXT_mesh_gpu_instancing.attributes"), attributes)?;
    }
    check_weights(path, node.weights.as_deref())
}
