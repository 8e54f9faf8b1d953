//! The bounding volume hierarchy, built by `obvhs`.

use std::time::Duration;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use raggio_kernels::{BvhNode, MAX_BVH_DEPTH};
use raggio_scene::Scene;

use crate::bounds::bounds;

/// Nodes, parents before children, and the shapes in the order of the leaves.
#[derive(Default)]
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
    pub fn build(scene: &Scene, bounded: &[u32], first_place: u32) -> Self {
        let boxes: Vec<_> = bounded
            .iter()
            .filter_map(|&i| bounds(&scene.shapes[i as usize].geometry))
            .map(|(lower, upper)| Bounds(Aabb::new(Vec3A::from(lower), Vec3A::from(upper))))
            .collect();
        if boxes.is_empty() {
            return Self::default();
        }
        let mut hierarchy = Self::fast(&boxes);
        if depth(&hierarchy.nodes) >= MAX_BVH_DEPTH as usize {
            // Bodies inside bodies inside bodies make a chain. A balanced tree is slower to follow and never deep.
            hierarchy = Self::balanced(&boxes);
        }

        for node in hierarchy.nodes.iter_mut().filter(|node| node.count > 0) {
            node.first += first_place;
        }
        for shape in &mut hierarchy.order {
            *shape = bounded[*shape as usize];
        }
        hierarchy
    }

    /// By the surface area heuristic.
    fn fast(boxes: &[Bounds]) -> Self {
        let mut bvh = build_bvh2(boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        bvh.reorder_in_stack_traversal_order();
        let nodes = bvh.nodes.iter().map(|n| node(&n.aabb, n.first_index, n.prim_count)).collect();
        Self { nodes, order: bvh.primitive_indices }
    }

    /// By halves along the longest axis.
    fn balanced(boxes: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = vec![BvhNode::default()];
        // Node, and the range of `order` it is to hold.
        let mut open = vec![(0, 0..boxes.len())];
        while let Some((place, range)) = open.pop() {
            let of = |i: &u32| boxes[*i as usize].0;
            let aabb = order[range.clone()].iter().map(of).reduce(|a, b| a.union(&b)).unwrap_or(Aabb::empty());
            if range.len() <= 2 {
                nodes[place] = node(&aabb, range.start as u32, range.len() as u32);
                continue;
            }
            let axis = aabb.largest_axis();
            let half = range.len() / 2;
            let center = |i: &u32| of(i).center_axis(axis);
            order[range.clone()].select_nth_unstable_by(half, |a, b| center(a).total_cmp(&center(b)));
            let first = nodes.len();
            nodes[place] = node(&aabb, first as u32, 0);
            nodes.extend([BvhNode::default(); 2]);
            open.push((first, range.start..range.start + half));
            open.push((first + 1, range.start + half..range.end));
        }
        Self { nodes, order }
    }
}

fn node(aabb: &Aabb, first: u32, count: u32) -> BvhNode {
    BvhNode { lower: aabb.min.to_array(), upper: aabb.max.to_array(), first, count }
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
