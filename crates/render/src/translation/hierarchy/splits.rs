//! A binary tree from above: each node is split where the surface area heuristic expects the least work [wald2007fast].

use std::collections::VecDeque;

use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

use super::Bounds;

/// Most slices of equal width along an axis; a split lies between two.
const SLICES: usize = 16;

#[derive(Clone, Copy)]
struct Item {
    around: Aabb,
    center: Vec3A,
    index: u32,
}

/// A tree over `boxes`, one in each leaf; nodes near the root stand at the front. Takes n log n steps wherever they are,
/// unless boxes shrink towards a point as fast as numbers can.
pub(super) fn split(boxes: &[Bounds]) -> Bvh2 {
    let mut items: Vec<Item> = (0..)
        .zip(boxes)
        .map(|(index, bounds)| Item { around: bounds.aabb(), center: bounds.center().into(), index })
        .collect();
    let mut nodes = Vec::with_capacity(2 * items.len());
    nodes.push(Bvh2Node::default());
    // Nodes, and the items each is to hold.
    let mut open = VecDeque::from([(0, 0..items.len())]);
    while let Some((place, range)) = open.pop_front() {
        let held = &mut items[range.clone()];
        let around = held.iter().map(|item| item.around).fold(Aabb::empty(), |a, b| a.union(&b));
        if held.len() == 1 {
            nodes[place] = Bvh2Node::new(around, 1, range.start as u32);
            continue;
        }
        let middle = range.start + part(held);
        let first = nodes.len();
        nodes[place] = Bvh2Node::new(around, 0, first as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        open.push_back((first, range.start..middle));
        open.push_back((first + 1, middle..range.end));
    }
    Bvh2 { nodes, primitive_indices: items.iter().map(|item| item.index).collect(), ..Bvh2::default() }
}

/// Moves those of at least two `items` to the front that go to the left, and returns how many: not all, not none.
fn part(items: &mut [Item]) -> usize {
    if items.len() == 2 {
        return 1;
    }
    let slices = Slices::new(items);
    let Some((axis, slice)) = slices.best_split(items) else {
        return items.len() / 2;
    };
    let (mut left, mut right) = (0, items.len());
    while left < right {
        if slices.along(axis, &items[left]) < slice as f32 {
            left += 1;
        } else {
            right -= 1;
            items.swap(left, right);
        }
    }
    left
}

/// Numbers of slices from centers.
struct Slices {
    /// Number of slices along each axis.
    count: usize,
    first: Vec3A,
    /// Slices per unit of length along each axis; 0 along axes that cannot be divided.
    per_unit: Vec3A,
}

impl Slices {
    fn new(items: &[Item]) -> Self {
        let (first, last) = items
            .iter()
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(a, b), item| (a.min(item.center), b.max(item.center)));
        // A little less, for the last center belongs to the last slice.
        let count = SLICES.min(2 * items.len());
        let per_unit = count as f32 * (1.0 - 4.0 * f32::EPSILON) / (last - first);
        let divided = per_unit.cmpgt(Vec3A::ZERO) & per_unit.is_finite_mask();
        Self { count, first, per_unit: Vec3A::select(divided, per_unit, Vec3A::ZERO) }
    }

    fn of(&self, item: &Item) -> [usize; 3] {
        let slice = (item.center - self.first) * self.per_unit;
        slice.to_array().map(|slice| (slice as u32 as usize).min(SLICES - 1))
    }

    fn along(&self, axis: usize, item: &Item) -> f32 {
        (item.center[axis] - self.first[axis]) * self.per_unit[axis]
    }

    /// The axis and the first slice on the right where boxes times their areas are least; none if centers coincide.
    fn best_split(&self, items: &[Item]) -> Option<(usize, usize)> {
        let mut filled = [[(Aabb::empty(), 0u32); SLICES]; 3];
        for item in items {
            for (slices, slice) in filled.iter_mut().zip(self.of(item)) {
                let (around, count) = &mut slices[slice];
                *around = around.union(&item.around);
                *count += 1;
            }
        }
        let mut best = (f32::INFINITY, None);
        for axis in (0..3).filter(|&axis| self.per_unit[axis] > 0.0) {
            let add = |sum: &mut (Aabb, u32), slice: &(Aabb, u32)| {
                *sum = (sum.0.union(&slice.0), sum.1 + slice.1);
                Some(sum.0.half_area() * sum.1 as f32)
            };
            let filled = &filled[axis][..self.count];
            let from_left = filled.iter().scan((Aabb::empty(), 0), add);
            let mut right = [0.0; SLICES];
            let from_right = filled.iter().rev().scan((Aabb::empty(), 0), add);
            right[..self.count].iter_mut().rev().zip(from_right).for_each(|(to, cost)| *to = cost);
            // The first and the last slice hold something, so no side is empty.
            for ((slice, left), right) in (1..).zip(from_left).zip(&right[1..self.count]) {
                if left + right < best.0 {
                    best = (left + right, Some((axis, slice)));
                }
            }
        }
        best.1
    }
}
