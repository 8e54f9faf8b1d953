//! Bounding volume hierarchies: binary ones are built by `obvhs`, and translated here.

mod nodes;

pub(crate) use nodes::moved;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};
use raggio_kernels::BvhNode;

/// Levels that a hierarchy may have; the kernels' stack has room for one of shapes over one of triangles.
const MOST_LEVELS: u32 = raggio_kernels::BVH_STACK / 2 - 1;

/// Fewer shapes are built anew within a millisecond or so.
const WORTH_REFITTING: usize = 4096;
/// A hierarchy that costs so much more than before is built anew.
const WORN_OUT: f64 = 1.5;

/// Nodes, parents before children, and what stands in their leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Root first; none if there is nothing to hold. Children and leaves count from 0.
    pub nodes: Vec<BvhNode>,
    /// Indices of boxes, in the order of the leaves.
    pub order: Vec<u32>,
    /// Levels of nodes.
    pub levels: u32,
}

/// A box to be held: its lower and upper corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds(pub Vec3, pub Vec3);

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self(Vec3::INFINITY, Vec3::NEG_INFINITY);
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(Vec3A::from(self.0), Vec3A::from(self.1))
    }
}

impl Hierarchy {
    /// Over `boxes`, on all threads. The same boxes give the same hierarchy.
    pub fn build(boxes: &[Bounds]) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let (nodes, order) = fast(boxes);
        let hierarchy = nodes::translate(&nodes, &order);
        if hierarchy.levels <= MOST_LEVELS {
            return hierarchy;
        }
        // Bodies inside bodies inside bodies make a chain. A balanced tree is slower to follow and never deep.
        let (nodes, order) = balanced(boxes);
        nodes::translate(&nodes, &order)
    }

    /// Adapts the nodes of a hierarchy to boxes that have moved, without changing its shape; its leaves hold the boxes
    /// `order`. `None` where a new one would be much faster to follow, or hardly slower to have.
    pub fn refit(nodes: &[BvhNode], first_place: u32, order: &[u32], boxes: &[Option<Bounds>]) -> Option<Vec<BvhNode>> {
        if order.len() < WORTH_REFITTING {
            return None;
        }
        let before = nodes::cost(nodes);
        let refitted = nodes::refit(nodes, first_place, order, boxes);
        (nodes::cost(&refitted) < WORN_OUT * before).then_some(refitted)
    }
}

/// By the surface area heuristic.
fn fast(boxes: &[Bounds]) -> (Vec<Bvh2Node>, Vec<u32>) {
    let params = BvhBuildParams::fast_build();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut tree, params.reinsertion_batch_ratio, None);
    (tree.nodes, tree.primitive_indices)
}

/// By halves along the longest axis.
fn balanced(boxes: &[Bounds]) -> (Vec<Bvh2Node>, Vec<u32>) {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    // Node, and the range of `order` it is to hold.
    let mut open = vec![(0, 0..boxes.len())];
    while let Some((place, range)) = open.pop() {
        let of = |i: &u32| boxes[*i as usize].aabb();
        let aabb = order[range.clone()].iter().map(of).reduce(|a, b| a.union(&b)).unwrap_or(Aabb::empty());
        if range.len() == 1 {
            nodes[place] = Bvh2Node::new(aabb, 1, range.start as u32);
            continue;
        }
        let axis = aabb.largest_axis();
        let half = range.len() / 2;
        let center = |i: &u32| of(i).center_axis(axis);
        order[range.clone()].select_nth_unstable_by(half, |a, b| center(a).total_cmp(&center(b)));
        let first = nodes.len();
        nodes[place] = Bvh2Node::new(aabb, 0, first as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        open.push((first, range.start..range.start + half));
        open.push((first + 1, range.start + half..range.end));
    }
    (nodes, order)
}
