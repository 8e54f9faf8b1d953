//! Mending of a document: what is wrong but plain in its meaning is put right, with a warning, before all is checked.
//!
//! References are not checked yet, so that none is followed blindly.

use std::collections::HashSet;

use super::document::Document;
use super::fault::Warnings;
use crate::text::counted;

pub(super) fn mend(document: &mut Document, warnings: &Warnings) {
    mend_strides(document, warnings);
    mend_weights(document, warnings);
    mend_children(document, warnings);
    mend_scenes(document, warnings);
}

fn mend_strides(document: &mut Document, warnings: &Warnings) {
    for (i, view) in document.buffer_views.iter_mut().enumerate() {
        match view.byte_stride {
            Some(0) => {
                warnings.push(format!("bufferViews[{i}].byteStride is 0: the elements are read without gaps"));
                view.byte_stride = None;
            }
            Some(stride) if stride % 4 != 0 || stride > 252 => warnings.push(format!(
                "bufferViews[{i}].byteStride is {stride}: it should be a multiple of 4 up to 252, and is used as it is"
            )),
            _ => {}
        }
    }
}

/// Takes away weights that have no morph target; targets without a weight have that of 0.
fn mend_weights(document: &mut Document, warnings: &Warnings) {
    let mend = |list: &str, i: usize, weights: &mut Option<Vec<f32>>, targets: usize| {
        let Some(weights) = weights.as_mut().filter(|weights| weights.len() != targets) else { return };
        let (count, path) = (weights.len(), format!("{list}[{i}].weights"));
        let rest = if count > targets { "the rest is not used" } else { "the rest is 0" };
        let (has, wants) = (counted(count, "weight"), counted(targets, "morph target"));
        warnings.push(format!("{path} has {has} for {wants}: {rest}"));
        weights.truncate(targets);
    };
    let targets = document.meshes.iter().map(|mesh| mesh.primitives.first().map_or(0, |first| first.targets.len()));
    let targets: Vec<usize> = targets.collect();
    for (i, mesh) in document.meshes.iter_mut().enumerate() {
        mend("meshes", i, &mut mesh.weights, targets[i]);
    }
    for (i, node) in document.nodes.iter_mut().enumerate() {
        let targets = node.mesh.and_then(|mesh| targets.get(mesh)).copied().unwrap_or_default();
        mend("nodes", i, &mut node.weights, targets);
    }
}

/// Leaves each node the first of its parents.
fn mend_children(document: &mut Document, warnings: &Warnings) {
    let mut parents = vec![None; document.nodes.len()];
    for (parent, node) in document.nodes.iter_mut().enumerate() {
        node.children.retain(|child| {
            let Some(known) = parents.get_mut(*child) else { return true };
            if let Some(first) = *known {
                warnings.push(format!(
                    "nodes[{parent}].children lists node {child}, a child of node {first} already: it is shown there alone"
                ));
                return false;
            }
            *known = Some(parent);
            true
        });
    }
}

fn mend_scenes(document: &mut Document, warnings: &Warnings) {
    let children: HashSet<usize> = document.nodes.iter().flat_map(|node| &node.children).copied().collect();
    for (i, scene) in document.scenes.iter_mut().enumerate() {
        let mut listed = HashSet::new();
        scene.nodes.retain(|node| {
            let is_new = listed.insert(*node);
            if !is_new || children.contains(node) {
                warnings.push(format!(
                    "scenes[{i}].nodes lists node {node}, which is listed twice or a child of another: it is shown once"
                ));
            }
            is_new
        });
    }
}
