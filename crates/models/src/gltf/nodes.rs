//! Placement of nodes: their own transforms, and those of their parents applied to them.

use std::collections::HashMap;
use std::fmt::Display;

use glam::{DAffine3, DQuat, DVec3};

use super::asset::Asset;
use super::document::{Document, Node};
use super::fault::{Warnings, at};
use super::pose::affine;
use crate::error::Fault;

/// The nodes' transforms relative to their parents, and the weights of morph targets, where an animation sets them.
pub(super) struct Pose {
    locals: Vec<Local>,
    pub weights: HashMap<usize, Vec<f32>>,
}

/// A transform: scale first, then rotation, then translation.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

#[derive(Clone, Copy)]
enum Local {
    Place(Place),
    Matrix(DAffine3),
}

impl Pose {
    /// Pose that the document gives.
    pub(super) fn at_rest(asset: &Asset<'_>) -> Result<Self, Fault> {
        let local = |(number, node)| local(node, &format!("nodes[{number}]"), &asset.warnings);
        let locals = asset.document.nodes.iter().enumerate().map(local).collect::<Result<_, _>>()?;
        Ok(Self { locals, weights: HashMap::new() })
    }

    /// The transform of a node, to be changed; a matrix is taken apart.
    pub(super) fn place(&mut self, node: usize) -> &mut Place {
        if let Local::Matrix(matrix) = self.locals[node] {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            self.locals[node] = Local::Place(Place { translation, rotation, scale });
        }
        match &mut self.locals[node] {
            Local::Place(place) => place,
            Local::Matrix(_) => unreachable!("a matrix has just been taken apart"),
        }
    }

    /// Transforms from each node to the world. `order` has all nodes, parents first.
    pub(super) fn worlds(&self, order: &[(usize, Option<usize>)]) -> Result<Vec<DAffine3>, Fault> {
        let mut worlds = vec![DAffine3::IDENTITY; self.locals.len()];
        for (node, parent) in order {
            let local = self.locals[*node].matrix();
            let world = parent.map_or(local, |parent| worlds[parent] * local);
            if !world.is_finite() {
                return Err(at(format!("nodes[{node}]"), "its place in the world should be finite"));
            }
            worlds[*node] = world;
        }
        Ok(worlds)
    }
}

impl Local {
    fn matrix(&self) -> DAffine3 {
        match self {
            Self::Place(place) => place.matrix(),
            Self::Matrix(matrix) => *matrix,
        }
    }
}

impl Place {
    pub(super) fn matrix(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// The rotation of a quaternion of any length; one without length turns nothing, with a warning that begins with `what`.
pub(super) fn rotation(quaternion: DQuat, what: impl Display, warnings: &Warnings) -> DQuat {
    let unit = quaternion.normalize();
    if unit.is_finite() {
        return unit;
    }
    warnings.push(format!("{what} should be a unit quaternion and is {:?}: nothing is turned", quaternion.to_array()));
    DQuat::IDENTITY
}

fn local(node: &Node, path: &str, warnings: &Warnings) -> Result<Local, Fault> {
    if let Some(matrix) = &node.matrix {
        let last_row = [matrix[3], matrix[7], matrix[11], matrix[15]];
        if last_row != [0.0, 0.0, 0.0, 1.0] {
            return Err(at(path, format!("the last row of `matrix` is {last_row:?}: it should be 0, 0, 0, 1")));
        }
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            let beside = "a `translation`, `rotation` or `scale` beside its `matrix`";
            warnings.push(format!("{path} has {beside}: the matrix alone is used"));
        }
        return Ok(Local::Matrix(affine(matrix)));
    }
    let quaternion = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let rotation = rotation(quaternion, format_args!("{path}.rotation"), warnings);
    let translation = DVec3::from(node.translation.unwrap_or_default());
    Ok(Local::Place(Place { translation, rotation, scale: DVec3::from(node.scale.unwrap_or([1.0; 3])) }))
}

/// Number of morph targets of a node's mesh.
pub(super) fn morph_targets(document: &Document, node: usize) -> usize {
    let mesh = document.nodes[node].mesh.map(|mesh| &document.meshes[mesh]);
    mesh.and_then(|mesh| mesh.primitives.first()).map_or(0, |primitive| primitive.targets.len())
}

/// The nodes that the scene shows, each once, parents first, in the document's order.
pub(super) fn visible(document: &Document, roots: &[usize]) -> Vec<usize> {
    let mut waiting: Vec<usize> = roots.iter().rev().copied().collect();
    let mut visible = Vec::new();
    let mut is_met = vec![false; document.nodes.len()];
    while let Some(node) = waiting.pop() {
        let is_new = !std::mem::replace(&mut is_met[node], true);
        if is_new && !document.nodes[node].is_hidden() {
            visible.push(node);
            waiting.extend(document.nodes[node].children.iter().rev());
        }
    }
    visible
}

/// The roots of the scene of number `wanted`, or of the document's own choice.
///
/// # Errors
/// When there is no such scene.
pub(super) fn roots(
    document: &Document,
    wanted: Option<usize>,
    order: &[(usize, Option<usize>)],
) -> Result<Vec<usize>, Fault> {
    let all = order.iter().filter(|(_, parent)| parent.is_none()).map(|(node, _)| *node);
    let number = wanted.or(document.scene).unwrap_or_default();
    if document.scenes.is_empty() && wanted.is_none() {
        return Ok(all.collect());
    }
    let scene = document.scenes.get(number).ok_or_else(|| {
        at("scenes", format!("scene {number} is wanted: the file has {}, counted from 0", document.scenes.len()))
    })?;
    Ok(scene.nodes.clone())
}
