//! Translation of the builder's nodes to those of the kernels, which hold the boxes of both their children.

use bytemuck::zeroed_vec;
use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use raggio_kernels::{BvhChild, BvhNode};
use rayon::prelude::*;

use super::{Bounds, Hierarchy};

/// Most leaves in one child. More make a smaller hierarchy and a slower one.
const LEAVES: usize = 3;
/// A coordinate beyond all scenes.
const NOWHERE: f32 = 1e30;
/// Room that boxes get, in parts of the largest coordinate: sixteen roundings, for the kernels need twelve.
const ROOM: f32 = 8.0 * f32::EPSILON;

/// Items that the leaves of a tree hold, one each, by number.
pub(super) struct Items {
    /// Trees, which have the numbers from 0.
    pub parts: Vec<Hierarchy>,
    /// Indices of boxes, which have the numbers behind those.
    pub alone: Vec<u32>,
}

/// Translates a binary tree, its root at the front, whose leaves hold the `items` of numbers `order`. Boxes become
/// larger by `room`.
pub(super) fn translate(nodes: &[Bvh2Node], order: &[u32], items: &Items, room: Vec3A) -> Hierarchy {
    let tree = Tree { nodes, order, items, room };
    if tree.item(0).is_some() {
        // A node has two children: this one's other is the same leaf again, so far away that no ray finds it.
        let left = tree.child(0, 0, 1);
        let right = BvhChild::new([[NOWHERE; 3]; 2], 0, 1);
        return Hierarchy { nodes: vec![BvhNode { left, right }], order: items.alone.clone(), levels: 1 };
    }
    let (top, links) = tree.top();
    if links.is_empty() { top } else { join(top, &links, &items.parts) }
}

struct Tree<'a> {
    nodes: &'a [Bvh2Node],
    order: &'a [u32],
    items: &'a Items,
    room: Vec3A,
}

/// Item that a leaf holds.
enum Item {
    /// The tree of this number.
    Part(usize),
    /// The box with this index.
    Box(u32),
}

impl Tree<'_> {
    /// Item that `node` holds, if it is a leaf.
    fn item(&self, node: usize) -> Option<Item> {
        let Items { parts, alone } = self.items;
        let Bvh2Node { prim_count, first_index, .. } = self.nodes[node];
        (prim_count > 0).then(|| {
            let item = self.order[first_index as usize] as usize;
            if item < parts.len() { Item::Part(item) } else { Item::Box(alone[item - parts.len()]) }
        })
    }

    fn children(&self, node: usize) -> [usize; 2] {
        let first = self.nodes[node].first_index as usize;
        [first, first + 1]
    }

    /// Appends the boxes below `node` to `order` and returns how many they are, if they fit into one child; else 0.
    fn gather(&self, node: usize, order: &mut Vec<u32>) -> u32 {
        let before = order.len();
        let fits = self.gather_some(node, before + LEAVES, order);
        if !fits {
            order.truncate(before);
        }
        (order.len() - before) as u32
    }

    /// Appends the boxes below `node`, and stops where `order` would become longer than `most`.
    fn gather_some(&self, node: usize, most: usize, order: &mut Vec<u32>) -> bool {
        match self.item(node) {
            Some(Item::Box(index)) => order.push(index),
            Some(Item::Part(_)) => return false,
            None => return self.children(node).into_iter().all(|child| self.gather_some(child, most, order)),
        }
        order.len() <= most
    }

    /// The box of `node` around `count` leaves from place `first` on, or around the node `first`.
    fn child(&self, node: usize, first: usize, count: u32) -> BvhChild {
        around(self.nodes[node].aabb(), self.room, first as u32, count)
    }

    /// Hierarchy of all above the parts, whose levels it counts already, and links to those.
    fn top(&self) -> (Hierarchy, Vec<Link>) {
        let mut made = Hierarchy { nodes: vec![BvhNode::default()], order: vec![], levels: 1 };
        let mut links = vec![];
        // Place of a node, its level, and the builder's node that it is made of.
        let mut waiting = vec![(0, 1, 0)];
        while let Some((place, level, node)) = waiting.pop() {
            made.levels = made.levels.max(level);
            let children = self.children(node);
            let [left, right] = children.map(|child| {
                if let Some(Item::Part(part)) = self.item(child) {
                    made.levels = made.levels.max(level + self.items.parts[part].levels);
                    links.push(Link { node: place, right: child == children[1], part });
                    return self.child(child, 0, 0);
                }
                let first = made.order.len();
                let leaves = self.gather(child, &mut made.order);
                if leaves > 0 {
                    return self.child(child, first, leaves);
                }
                waiting.push((made.nodes.len(), level + 1, child));
                made.nodes.push(BvhNode::default());
                self.child(child, made.nodes.len() - 1, 0)
            });
            made.nodes[place] = BvhNode { left, right };
        }
        (made, links)
    }
}

/// A child of `node`, left or right, that is the tree of the number `part`.
struct Link {
    node: usize,
    right: bool,
    part: usize,
}

/// Joins a `top` and the `parts` that hang below it to one tree; the parts stand behind the top in their order.
fn join(mut top: Hierarchy, links: &[Link], parts: &[Hierarchy]) -> Hierarchy {
    let (mut nodes, mut leaves) = (top.nodes.len(), top.order.len());
    let mut places = Vec::with_capacity(parts.len());
    for part in parts {
        places.push((nodes as u32, leaves as u32));
        nodes += part.nodes.len();
        leaves += part.order.len();
    }
    for &Link { node, right, part } in links {
        let BvhNode { left, right: other } = &mut top.nodes[node];
        let child = if right { other } else { left };
        *child = BvhChild::new(child.corners(), places[part].0, 0);
    }
    // Zeros are no memory yet: each thread takes what it fills.
    let mut all = Hierarchy { nodes: zeroed_vec(nodes), order: zeroed_vec(leaves), levels: top.levels };
    let (above, mut nodes) = all.nodes.split_at_mut(top.nodes.len());
    above.copy_from_slice(&top.nodes);
    let (above, mut order) = all.order.split_at_mut(top.order.len());
    above.copy_from_slice(&top.order);
    let room = |part: &Hierarchy| {
        let nodes = nodes.split_off_mut(..part.nodes.len()).unwrap_or_default();
        (nodes, order.split_off_mut(..part.order.len()).unwrap_or_default())
    };
    let rooms: Vec<_> = parts.iter().map(room).collect();
    rooms.into_par_iter().zip(parts).zip(places).for_each(|(((nodes, order), part), (first_node, first_leaf))| {
        let moved = part.nodes.iter().map(|node| moved(node, first_node, first_leaf));
        nodes.iter_mut().zip(moved).for_each(|(to, node)| *to = node);
        order.copy_from_slice(&part.order);
    });
    all
}

/// Room that boxes get on each side that have `all` around them.
pub(crate) fn room(all: Bounds) -> Vec3A {
    Vec3A::splat(ROOM * all.0.abs().max(all.1.abs()).max_element())
}

/// A child whose box is `room` larger than `inside`.
fn around(inside: &Aabb, room: Vec3A, first: u32, count: u32) -> BvhChild {
    BvhChild::new([(inside.min - room).to_array(), (inside.max + room).to_array()], first, count)
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
    let room = room(boxes.iter().copied().flatten().fold(Bounds::EMPTY, Bounds::union));
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

/// Cost of following a hierarchy on average, but for a factor: the area of its boxes over that of the root's.
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
