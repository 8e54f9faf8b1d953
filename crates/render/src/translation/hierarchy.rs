//! Bounding volume hierarchies: large ones are built in parts, each split from above, improved by `obvhs`, translated.

mod nodes;
mod parts;
mod splits;

pub(crate) use nodes::{moved, room};

use glam::{Vec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use raggio_kernels::BvhNode;
use rayon::prelude::*;

use self::nodes::Items;
use self::parts::Parts;

/// Levels that a hierarchy may have; the kernels' stack has room for one of shapes over one of triangles.
const MOST_LEVELS: u32 = raggio_kernels::BVH_STACK / 2 - 1;

/// Part of the nodes that is put where it fits better, the largest first.
const REINSERTED: f32 = 0.02;
/// Number of nodes that are put where they fit better in small trees.
const LEAST_REINSERTED: f32 = 128.0;

/// Least number of shapes whose hierarchy is refitted: fewer are built anew within a millisecond or so.
pub(crate) const WORTH_REFITTING: usize = 4096;
/// Factor by which a refitted hierarchy may cost more than before; at more it is built anew.
const WORN_OUT: f64 = 1.5;

/// Nodes, parents before children, and what stands in their leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Nodes, the root first; none if there is nothing to hold. Children and leaves count from 0.
    pub nodes: Vec<BvhNode>,
    /// Indices of boxes, in the order of the leaves.
    pub order: Vec<u32>,
    /// Number of levels of nodes.
    pub levels: u32,
}

/// A box to be held: its lower and upper corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds(pub Vec3, pub Vec3);

impl Bounds {
    /// Box around nothing.
    pub const EMPTY: Self = Self(Vec3::INFINITY, Vec3::NEG_INFINITY);

    fn center(&self) -> Vec3 {
        self.0 * 0.5 + self.1 * 0.5
    }

    /// Box around both.
    pub fn union(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.max(other.1))
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(Vec3A::from(self.0), Vec3A::from(self.1))
    }
}

impl Hierarchy {
    /// Builds a hierarchy over `boxes`, on all threads. Equal boxes give equal hierarchies.
    pub fn build(boxes: &[Bounds]) -> Self {
        if boxes.is_empty() {
            return Self::default();
        }
        let room = nodes::room(boxes.par_iter().copied().reduce(|| Bounds::EMPTY, Bounds::union));
        let hierarchy = in_parts(boxes, room);
        if hierarchy.levels <= MOST_LEVELS {
            return hierarchy;
        }
        // Bodies inside bodies inside bodies make a chain. A balanced tree is slower to follow and never deep.
        let (nodes, order) = balanced(boxes);
        let items = Items { parts: vec![], alone: (0..boxes.len() as u32).collect() };
        nodes::translate(&nodes, &order, &items, room)
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

/// A tree whose leaves are parts, each built alone, where there are so many boxes that this is worth it.
fn in_parts(boxes: &[Bounds], room: Vec3A) -> Hierarchy {
    let Parts { together, alone } = parts::divide(boxes);
    let build = |indices: Vec<u32>| {
        let inside: Vec<Bounds> = indices.iter().map(|&i| boxes[i as usize]).collect();
        let mut part = in_parts(&inside, room);
        part.order.iter_mut().for_each(|i| *i = indices[*i as usize]);
        (inside.into_iter().fold(Bounds::EMPTY, Bounds::union), part)
    };
    let (mut bounds, parts): (Vec<Bounds>, Vec<Hierarchy>) = together.into_par_iter().map(build).unzip();
    bounds.extend(alone.iter().map(|&i| boxes[i as usize]));
    let (nodes, order) = fast(&bounds);
    nodes::translate(&nodes, &order, &Items { parts, alone }, room)
}

/// Tree by the surface area heuristic, one box in each leaf.
fn fast(boxes: &[Bounds]) -> (Vec<Bvh2Node>, Vec<u32>) {
    let mut tree = splits::split(boxes);
    let share = REINSERTED.max(LEAST_REINSERTED / tree.nodes.len() as f32);
    ReinsertionOptimizer::default().run(&mut tree, share, None);
    (tree.nodes, tree.primitive_indices)
}

/// Tree by halves along the longest axis, one box in each leaf.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that a ray may find each of `boxes`: every one stands in one leaf, within the boxes of all nodes above
    /// it.
    fn check(name: &str, boxes: &[Bounds]) {
        let hierarchy = Hierarchy::build(boxes);
        let mut found = vec![false; boxes.len()];
        let everywhere = Bounds(Vec3::NEG_INFINITY, Vec3::INFINITY);
        let mut open = vec![(0, 1, everywhere)];
        let mut nodes = 0;
        while let Some((node, level, around)) = open.pop() {
            nodes += 1;
            assert!(level <= hierarchy.levels, "{name}: more levels than {}", hierarchy.levels);
            let BvhNode { left, right } = hierarchy.nodes[node];
            for child in [left, right] {
                let [lower, upper] = child.corners().map(Vec3::from);
                let around = Bounds(around.0.max(lower), around.1.min(upper));
                let first = child.first() as usize;
                if child.count() == 0 {
                    open.push((first, level + 1, around));
                    continue;
                }
                for &index in &hierarchy.order[first..][..child.count() as usize] {
                    let Bounds(lower, upper) = boxes[index as usize];
                    let inside = around.0.cmplt(lower).all() && around.1.cmpgt(upper).all();
                    assert!(inside, "{name}: {lower} to {upper} is not inside {around:?}");
                    assert!(!std::mem::replace(&mut found[index as usize], true), "{name}: {index} is there twice");
                }
            }
        }
        assert!(found.iter().all(|found| *found), "{name}: not all boxes are found");
        assert_eq!(nodes, hierarchy.nodes.len(), "{name}: nodes that nothing leads to");
    }

    #[test]
    fn large_hierarchies_hold_each_box_once() {
        const COUNT: u32 = 300_000;
        // Places and sizes by golden sections: evenly spread, and the same in each run.
        let at = |i: u32| {
            let part = |factor: f64| (f64::from(i) * factor).fract() as f32;
            Vec3::new(part(0.819_172_5), part(0.671_043_6), part(0.549_700_5))
        };
        let cube = |center: Vec3, size: f32| Bounds(center - size, center + size);
        let all = |make: &dyn Fn(u32) -> Bounds| (0..COUNT).map(make).collect::<Vec<_>>();
        let sphere = |i| (at(i) - 0.5).normalize_or_zero();
        let on_ground = |i| match i {
            0 => Bounds(Vec3::new(-20.0, -1.0, -20.0), Vec3::new(20.0, -1.0, 20.0)),
            _ => cube(sphere(i), 1e-3),
        };
        check("a volume", &all(&|i| cube(at(i), 1e-3)));
        check("a surface on a ground", &all(&on_ground));
        check("a line", &all(&|i| cube(Vec3::X * i as f32, 0.5)));
        check("points", &all(&|i| cube(at(i), 0.0)));
        check("in one place", &all(&|_| cube(Vec3::ONE, 1.0)));
        check("all but one in one place", &all(&|i| cube(Vec3::X * f32::from(i == 7), 1e-6)));
        check("large ones", &all(&|i| cube(at(i), 3.0)));
        check("of every size", &all(&|i| cube(at(i), 2f32.powi(-(i as i32 % 30)))));
        check("ever closer", &all(&|i| cube(at(i) * 2f32.powi(-(i as i32 % 60)), 1e-20)));
        check("far away", &all(&|i| cube(at(i) * 1e30, 1e25)));
    }

    #[test]
    fn large_hierarchies_are_the_same_on_any_number_of_threads() {
        let boxes: Vec<_> = (0..100_000)
            .map(|i| Vec3::new((i % 317) as f32, (i % 71) as f32, (i / 317) as f32))
            .map(|at| Bounds(at, at + 1.5))
            .collect();
        let built = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| Hierarchy::build(&boxes))
        };
        assert_eq!(built(1), built(5));
    }
}
