//! The bounding volume hierarchy, built by `obvhs`.

use std::time::Duration;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use raggio_kernels::{BvhNode, MAX_BVH_DEPTH};
use raggio_scene::Scene;

use crate::bounds::bounds;
use crate::device_scene::TranslationError;

/// Nodes, parents before children, and the shapes in the order of the leaves.
pub struct Hierarchy {
    /// Root first; none if there are no shapes.
    pub nodes: Vec<BvhNode>,
    /// Scene indices; a leaf names a run of them.
    pub order: Vec<u32>,
}

struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Hierarchy {
    /// Over the shapes `bounded` of `scene`, whose places start at `first_place`.
    pub fn build(scene: &Scene, bounded: &[u32], first_place: u32) -> Result<Self, TranslationError> {
        let boxes: Vec<_> = bounded
            .iter()
            .filter_map(|&i| bounds(&scene.shapes[i as usize].geometry))
            .map(|(lower, upper)| Bounds(Aabb::new(Vec3A::from(lower), Vec3A::from(upper))))
            .collect();
        if boxes.is_empty() {
            return Ok(Self { nodes: vec![], order: vec![] });
        }

        let mut bvh = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        bvh.reorder_in_stack_traversal_order();
        let nodes: Vec<_> = bvh
            .nodes
            .iter()
            .map(|node| BvhNode {
                lower: node.aabb.min.to_array(),
                upper: node.aabb.max.to_array(),
                first: if node.prim_count > 0 { first_place + node.first_index } else { node.first_index },
                count: node.prim_count,
            })
            .collect();
        let depth = depth(&nodes);
        let limit = MAX_BVH_DEPTH as usize;
        if depth >= limit {
            return Err(TranslationError::TooDeep { depth, limit });
        }
        let order = bvh.primitive_indices.iter().map(|&i| bounded[i as usize]).collect();
        Ok(Self { nodes, order })
    }
}

/// Levels below the root; children come after their parents.
fn depth(nodes: &[BvhNode]) -> usize {
    let mut levels = vec![0; nodes.len()];
    for (i, node) in nodes.iter().enumerate().filter(|(_, node)| node.count == 0) {
        for child in [node.first, node.first + 1] {
            levels[child as usize] = levels[i] + 1;
        }
    }
    levels.into_iter().max().unwrap_or(0)
}
