//! Builds the tree by which kernels choose lights [conty2018manylights].

use glam::Vec3;
use raggio_kernels::{LIGHT_INFINITE, LIGHT_LEAF, LIGHT_TWO_SIDED, LightNode};

use super::bounds::LightBounds;
use crate::translation::meshes::pack_unit_vector;

/// Places along each axis between which lights are parted.
const BINS: usize = 12;
/// Most levels of a tree that are parted by cost; those beyond are parted by halves.
const MOST_LEVELS: u32 = 64;
/// Least number of lights that are worth another thread.
const FEW: usize = 4096;
/// Angle by which the packed axes of nodes may be off, in radians, and more.
const AXIS_ERROR: f32 = 1e-4;

/// A tree with one light in each leaf: the root first, children side by side, left ones at odd places. The same lights
/// give the same tree.
pub(super) fn build(lights: &[LightBounds]) -> Vec<LightNode> {
    if lights.is_empty() {
        return vec![];
    }
    let mut items: Vec<Item> = lights.iter().zip(0..).map(|(bounds, light)| Item { bounds: *bounds, light }).collect();
    let mut nodes = vec![LightNode::default(); 2 * lights.len() - 1];
    let (root, below) = nodes.split_first_mut().expect("there are lights");
    Branch { place: 0, first: 1, parent: 0, level: 0 }.fill(&mut items, root, below);
    nodes
}

#[derive(Clone, Copy)]
struct Item {
    bounds: LightBounds,
    light: u32,
}

/// Place of a node, and the place where the room for those below it begins: two for each light but one.
struct Branch {
    place: u32,
    first: u32,
    parent: u32,
    level: u32,
}

impl Branch {
    /// Fills the node and those below it, and returns the bounds of all `items`.
    fn fill(self, items: &mut [Item], root: &mut LightNode, below: &mut [LightNode]) -> LightBounds {
        let is_leaf = items.len() == 1;
        let (bounds, child) = match items {
            [item] => (item.bounds, item.light),
            items => (self.part(items, below), self.first),
        };
        let flag = |set: bool, flag: u32| if set { flag } else { 0 };
        *root = LightNode {
            lower: bounds.lower.to_array(),
            upper: bounds.upper.to_array(),
            power: bounds.power,
            child,
            axis: pack_unit_vector(bounds.axis),
            cos_spread: (bounds.spread + AXIS_ERROR).min(std::f32::consts::PI).cos(),
            cos_falloff: bounds.falloff.cos(),
            parent: self.parent,
            flags: flag(is_leaf, LIGHT_LEAF)
                | flag(bounds.two_sided, LIGHT_TWO_SIDED)
                | flag(bounds.infinite, LIGHT_INFINITE),
        };
        bounds
    }

    /// Fills the nodes of both halves of `items`, and returns the bounds of all.
    fn part(&self, items: &mut [Item], below: &mut [LightNode]) -> LightBounds {
        let large = items.len() >= FEW;
        let middle = split(items, self.level);
        let (left_items, right_items) = items.split_at_mut(middle);
        let (pair, rest) = below.split_at_mut(2);
        let (left_below, right_below) = rest.split_at_mut(2 * (middle - 1));
        let [left, right] = pair else { unreachable!("two lights have room for two nodes") };
        let branch = |place, first| Branch { place, first, parent: self.place, level: self.level + 1 };
        let left_branch = branch(self.first, self.first + 2);
        let right_branch = branch(self.first + 1, self.first + 2 * middle as u32);
        let fill_left = || left_branch.fill(left_items, left, left_below);
        let fill_right = || right_branch.fill(right_items, right, right_below);
        let (a, b) = if large { rayon::join(fill_left, fill_right) } else { (fill_left(), fill_right()) };
        a.with(b)
    }
}

/// Sorts `items` into two parts, and returns where the second begins. Infinitely far lights stand apart from others.
fn split(items: &mut [Item], level: u32) -> usize {
    let far = partition(items, |item| item.bounds.infinite);
    if far > 0 && far < items.len() {
        return far;
    }
    let best = if far == 0 && level < MOST_LEVELS { best_plane(items) } else { None };
    let middle = best.map_or(0, |(axis, place)| partition(items, |item| item.bounds.center()[axis] < place));
    if middle == 0 || middle == items.len() { items.len() / 2 } else { middle }
}

/// The axis and the place on it with the least cost of both sides; `None` where all lights are in one place.
fn best_plane(items: &[Item]) -> Option<(usize, f32)> {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = items.iter().fold(none, |(low, high), item| {
        let center = item.bounds.center();
        (low.min(center), high.max(center))
    });
    let extent = high - low;
    let mut best = None;
    let mut least = f32::INFINITY;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let scale = BINS as f32 / extent[axis];
        let mut bins = [LightBounds::NONE; BINS];
        for item in items {
            let bin = ((item.bounds.center()[axis] - low[axis]) * scale) as usize;
            let bin = &mut bins[bin.min(BINS - 1)];
            *bin = bin.with(item.bounds);
        }
        let mut right = [LightBounds::NONE; BINS];
        for i in (1..BINS).rev() {
            right[i - 1] = right[i].with(bins[i]);
        }
        // Thin boxes are parted across.
        let shape = extent.max_element() / extent[axis];
        let mut left = LightBounds::NONE;
        for i in 0..BINS - 1 {
            left = left.with(bins[i]);
            let cost = shape * (left.cost() + right[i].cost());
            if cost < least && left.spread >= 0.0 && right[i].spread >= 0.0 {
                least = cost;
                best = Some((axis, low[axis] + (i + 1) as f32 / scale));
            }
        }
    }
    best
}

/// Brings the items of which `first` is true to the front, and returns how many they are. Their order depends on
/// nothing else.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(i, count);
            count += 1;
        }
    }
    count
}
