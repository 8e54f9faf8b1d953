//! From the builder's nodes to those of the kernels, which hold the boxes of both their children.

use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use raggio_kernels::{BvhChild, BvhNode};
use rayon::prelude::*;

use super::{Bounds, Hierarchy};

/// Leaves in one child. More make a smaller hierarchy and a slower one.
const LEAVES: u32 = 3;
/// A coordinate beyond all scenes.
const NOWHERE: f32 = 1e30;
/// Subtrees that threads share: many to each, because their sizes differ.
const SUBTREES: usize = 256;
/// Below this many leaves one thread is enough.
const LARGE: usize = 1 << 13;
/// How much larger boxes are made, in parts of the largest coordinate: sixteen roundings, for the kernels need twelve.
const ROOM: f32 = 8.0 * f32::EPSILON;

/// Translates a binary tree with its root at the front.
pub(super) fn translate(nodes: &[Bvh2Node], order: &[u32]) -> Hierarchy {
    let root = nodes[0].aabb();
    let room = Vec3A::splat(ROOM * root.min.abs().max(root.max.abs()).max_element());
    let tree = Tree { nodes, order, room };
    if tree.is_leaf(0) {
        // A node has two children: this one's other is the same leaf again, so far away that no ray finds it.
        let left = tree.child(0, 0, nodes[0].prim_count);
        let right = BvhChild::new([[NOWHERE; 3]; 2], 0, left.count());
        return Hierarchy { nodes: vec![BvhNode { left, right }], order: order.to_vec(), levels: 1 };
    }
    // Threads translate the subtrees below a cut, and one of them what is above.
    let cut = if order.len() < LARGE { vec![] } else { tree.cut() };
    let below: Vec<Hierarchy> = cut.par_iter().map(|&root| tree.below(root, &[], &[])).collect();
    tree.below(0, &cut, &below)
}

struct Tree<'a> {
    nodes: &'a [Bvh2Node],
    order: &'a [u32],
    room: Vec3A,
}

impl Tree<'_> {
    fn is_leaf(&self, node: usize) -> bool {
        self.nodes[node].prim_count > 0
    }

    fn children(&self, node: usize) -> [usize; 2] {
        let first = self.nodes[node].first_index as usize;
        [first, first + 1]
    }

    /// The roots of disjoint subtrees that hold all, each too large for one child; the largest boxes are opened first.
    fn cut(&self) -> Vec<usize> {
        let mut roots = vec![0];
        while roots.len() < SUBTREES {
            let area = |i: usize| self.nodes[roots[i]].aabb().half_area();
            let may_open = |&i: &usize| self.children(roots[i]).into_iter().all(|child| self.leaves(child) == 0);
            let largest = (0..roots.len()).filter(may_open).max_by(|&a, &b| area(a).total_cmp(&area(b)));
            let Some(largest) = largest else { break };
            let [left, right] = self.children(roots[largest]);
            roots[largest] = left;
            roots.push(right);
        }
        roots
    }

    /// How many leaves there are below `node`, if they fit into one child; else 0.
    fn leaves(&self, node: usize) -> u32 {
        fn count(tree: &Tree<'_>, node: usize, so_far: u32) -> u32 {
            if so_far > LEAVES || tree.is_leaf(node) {
                return so_far + tree.nodes[node].prim_count.min(LEAVES + 1);
            }
            let [left, right] = tree.children(node);
            let so_far = count(tree, left, so_far);
            if so_far > LEAVES { so_far } else { count(tree, right, so_far) }
        }
        let leaves = count(self, node, 0);
        if leaves > LEAVES { 0 } else { leaves }
    }

    /// The box of `node` around `count` leaves from place `first` on, or around the node `first`.
    fn child(&self, node: usize, first: usize, count: u32) -> BvhChild {
        around(self.nodes[node].aabb(), self.room, first as u32, count)
    }

    /// The tree below `root`, which is no leaf; below the nodes `cut` it is already there.
    fn below(&self, root: usize, cut: &[usize], known_trees: &[Hierarchy]) -> Hierarchy {
        let mut made = Hierarchy { nodes: vec![BvhNode::default()], order: vec![], levels: 1 };
        // Where a node goes, its level, and what it is made of.
        let mut waiting = vec![(0, 1, root)];
        while let Some((place, level, node)) = waiting.pop() {
            made.levels = made.levels.max(level);
            let [left, right] = self.children(node).map(|child| {
                if let Some(known) = cut.iter().position(|known| *known == child) {
                    let first = append(&mut made, level + 1, &known_trees[known]);
                    return self.child(child, first, 0);
                }
                let leaves = self.leaves(child);
                if leaves > 0 {
                    let first = made.order.len();
                    self.gather(child, &mut made.order);
                    return self.child(child, first, leaves);
                }
                waiting.push((made.nodes.len(), level + 1, child));
                made.nodes.push(BvhNode::default());
                self.child(child, made.nodes.len() - 1, 0)
            });
            made.nodes[place] = BvhNode { left, right };
        }
        made
    }

    /// Appends the leaves below `node`.
    fn gather(&self, node: usize, order: &mut Vec<u32>) {
        let it = &self.nodes[node];
        if self.is_leaf(node) {
            order.extend(&self.order[it.first_index as usize..][..it.prim_count as usize]);
        } else {
            self.children(node).into_iter().for_each(|child| self.gather(child, order));
        }
    }
}

/// A child whose box is `room` larger than `inside`.
fn around(inside: &Aabb, room: Vec3A, first: u32, count: u32) -> BvhChild {
    BvhChild::new([(inside.min - room).to_array(), (inside.max + room).to_array()], first, count)
}

/// Puts the tree `part`, whose root is on `level`, behind `tree`; returns where its root is.
fn append(tree: &mut Hierarchy, level: u32, part: &Hierarchy) -> usize {
    let (nodes, leaves) = (tree.nodes.len(), tree.order.len());
    tree.nodes.extend(part.nodes.iter().map(|node| moved(node, nodes as u32, leaves as u32)));
    tree.order.extend(&part.order);
    tree.levels = tree.levels.max(level + part.levels - 1);
    nodes
}

/// A node whose nodes and leaves stand so many places further, modulo 2^32.
pub(crate) fn moved(node: &BvhNode, nodes: u32, leaves: u32) -> BvhNode {
    let moved = |child: BvhChild| {
        let first = child.first().wrapping_add(if child.count() == 0 { nodes } else { leaves });
        BvhChild::new(child.corners(), first, child.count())
    };
    BvhNode { left: moved(node.left), right: moved(node.right) }
}

/// The nodes of a hierarchy around boxes that have moved; the order of its leaves is `order`, whose first has the place
/// `first_place`.
pub(super) fn refit(nodes: &[BvhNode], first_place: u32, order: &[u32], boxes: &[Option<Bounds>]) -> Vec<BvhNode> {
    let mut nodes = nodes.to_vec();
    let all = boxes.iter().flatten().map(|bounds| bounds.aabb()).reduce(|a, b| a.union(&b)).unwrap_or(Aabb::empty());
    let room = Vec3A::splat(ROOM * all.min.abs().max(all.max.abs()).max_element());
    let mut boxes_of_nodes = vec![Aabb::empty(); nodes.len()];
    // Children stand behind their parents.
    for place in (0..nodes.len()).rev() {
        let fitted = |child: BvhChild| {
            let first = child.first() as usize;
            if child.count() == 0 {
                return boxes_of_nodes[first];
            }
            let leaves = &order[first - first_place as usize..][..child.count() as usize];
            let boxes = leaves.iter().filter_map(|&i| boxes[i as usize]).map(|bounds| bounds.aabb());
            boxes.reduce(|a, b| a.union(&b)).unwrap_or(Aabb::empty())
        };
        let BvhNode { left, right } = nodes[place];
        let [left_box, right_box] = [left, right].map(fitted);
        boxes_of_nodes[place] = left_box.union(&right_box);
        let moved = |child: BvhChild, aabb| around(aabb, room, child.first(), child.count());
        nodes[place] = BvhNode { left: moved(left, &left_box), right: moved(right, &right_box) };
    }
    nodes
}

/// What following a hierarchy costs on average, but for a factor: the area of its boxes over that of the root's.
pub(super) fn cost(nodes: &[BvhNode]) -> f64 {
    let area = |child: &BvhChild| {
        let [lower, upper] = child.corners().map(|corner| corner.map(f64::from));
        let [x, y, z] = std::array::from_fn(|i| upper[i] - lower[i]);
        x * y + y * z + z * x
    };
    let root = nodes.first().map_or(0.0, |root| area(&root.left).max(area(&root.right)));
    let all: f64 = nodes.iter().map(|node| area(&node.left) + area(&node.right)).sum();
    all / root.max(f64::MIN_POSITIVE)
}
