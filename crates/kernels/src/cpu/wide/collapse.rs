//! Nodes of eight children from binary ones, at the least cost that the surface area heuristic finds [ylitie2017cwbvh].

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use bytemuck::{Zeroable, zeroed_vec};
use rayon::prelude::*;

use super::NONE;
use crate::{BvhChild, BvhNode};

/// Children of a node.
const WIDTH: usize = 8;
/// Bit of references to leaves.
pub(super) const LEAF: u32 = 1 << 31;
/// Bits of a reference that hold a place.
const PLACE_BITS: u32 = 27;
/// Number of places that a reference can name.
pub(super) const MOST_PLACES: u32 = 1 << PLACE_BITS;
/// Cost of a node with all its children.
const NODE_COST: f32 = 1.0;

/// `Node` of `cpp/traversal.h`.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Zeroable)]
pub(super) struct Node {
    /// Lower and upper planes of the children's boxes along x, then y, then z.
    pub planes: [[f32; WIDTH]; 6],
    pub children: [u32; WIDTH],
    unused: [u32; WIDTH],
}

impl Node {
    /// A node whose children no ray meets.
    const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [NONE; WIDTH],
        unused: [0; WIDTH],
    };

    fn set(&mut self, child: usize, [lower, upper]: [[f32; 3]; 2], reference: u32) {
        for axis in 0..3 {
            self.planes[2 * axis][child] = lower[axis];
            self.planes[2 * axis + 1][child] = upper[axis];
        }
        self.children[child] = reference;
    }
}

/// Reference to a leaf: `kind` or count, and a place.
pub(super) fn leaf(kind: u32, place: u32) -> u32 {
    assert!(kind < 16 && place < MOST_PLACES, "a reference has four bits for the kind and 27 for the place");
    LEAF | kind << PLACE_BITS | place
}

/// Kind or count, and place, of a reference to a [`leaf`].
pub(super) fn leaf_parts(reference: u32) -> (u32, u32) {
    ((reference & !LEAF) >> PLACE_BITS, reference & (MOST_PLACES - 1))
}

/// Contents of the leaves.
pub(super) trait Leaves: Sync {
    /// Cost of one leaf that holds `count` from place `first` on; `None` if one leaf cannot.
    fn cost(&self, first: u32, count: u32) -> Option<f32>;
    /// Reference to a leaf that holds `count` from place `first` on.
    fn reference(&self, first: u32, count: u32) -> u32;
}

/// Knowledge of all below a binary node, or of a leaf.
#[derive(Clone, Copy)]
struct Tree {
    /// Least cost as at most 1, 2 ... children of a node.
    costs: [f32; WIDTH],
    /// Number of nodes that are made then.
    nodes: [u32; WIDTH],
    /// Number of leaves if they stand side by side and are few, else 0; and the first.
    count: u32,
    first: u32,
}

/// What becomes of a binary node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Choice {
    /// How many of 1, 2 ... children of a node stand on the left; 0: none is gained over one child less. Of a single child: 1 if
    /// it is a node, 0 if it is a leaf.
    left: [u8; WIDTH],
    /// How many of a node's own children stand on the left.
    node_left: u8,
    /// Leaves that a single leaf holds.
    count: u32,
    first: u32,
}

/// Most leaves that are counted.
const FEW: u32 = 15;
/// Bits of a place in [`Choice::packed`], in which one of a hierarchy fits.
const FIRST_BITS: u32 = 30;
const _: () = assert!(crate::MOST_IN_HIERARCHY <= 1 << FIRST_BITS);
/// Levels of binary nodes and of nodes below the root whose children are given to several threads.
const SHARED_LEVELS: [u32; 2] = [16, 5];

/// Nodes of the hierarchy whose binary nodes stand in `range` of `binary`, the root first, and the reference to its root.
/// References count from the first of these nodes. All threads of the pool take part; their number changes nothing.
pub(super) fn collapse(binary: &[BvhNode], range: Range<usize>, leaves: &impl Leaves) -> (u32, Vec<Node>) {
    let BvhNode { left, right } = binary[range.start];
    if left.count() > 0 && right.count() > 0 && left.first() == right.first() {
        // What stands alone stands in both children.
        return (leaves.reference(left.first(), left.count()), vec![]);
    }
    let unit = 1.0 / area(&left).max(area(&right)).max(f64::MIN_POSITIVE);
    let choices = (0..range.len()).into_par_iter().map(|_| AtomicU64::new(0)).collect();
    let below = (0..range.len()).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    let plan = Plan { binary, root: range.start, leaves, unit, choices, below };
    let whole = plan.join(range.start, SHARED_LEVELS[0]);
    let choice = plan.choice(range.start);
    if choice.left[0] == 0 {
        return (leaves.reference(choice.first, choice.count), vec![]);
    }
    // Zeros are no memory yet: each thread takes what it fills.
    let mut wide: Vec<Node> = zeroed_vec(whole.nodes[0] as usize);
    if let Some((root, below)) = wide.split_first_mut() {
        plan.fill(Open { binary: range.start, node: root, below, first: 1 }, SHARED_LEVELS[1]);
    }
    (0, wide)
}

/// Half of the surface of a child's box.
fn area(child: &BvhChild) -> f64 {
    let [lower, upper] = child.corners().map(|corner| corner.map(f64::from));
    let [x, y, z] = std::array::from_fn(|i| upper[i] - lower[i]);
    x * y + y * z + z * x
}

impl Tree {
    fn leaf(first: u32, count: u32, cost: f32) -> Self {
        Self { costs: [cost; WIDTH], nodes: [0; WIDTH], count, first }
    }
}

impl Choice {
    /// All in a word: three bits for each number of children, four for the number of leaves, the rest for the first.
    fn packed(&self) -> u64 {
        let children =
            self.left.iter().rev().fold(u64::from(self.node_left), |bits, &left| bits << 3 | u64::from(left));
        (children << 4 | u64::from(self.count)) << FIRST_BITS | u64::from(self.first)
    }

    fn unpacked(word: u64) -> Self {
        let children = word >> (FIRST_BITS + 4);
        let three = |place: usize| (children >> (3 * place) & 7) as u8;
        Self {
            left: std::array::from_fn(three),
            node_left: three(WIDTH),
            count: (word >> FIRST_BITS) as u32 & 15,
            first: word as u32 & ((1 << FIRST_BITS) - 1),
        }
    }
}

/// Which binary nodes become nodes of their own.
struct Plan<'a, L> {
    binary: &'a [BvhNode],
    /// Place of the root, which stands first.
    root: usize,
    leaves: &'a L,
    /// Reciprocal of the largest box's area, which keeps costs within range.
    unit: f64,
    /// [`Choice`] of each binary node, from the root on.
    choices: Vec<AtomicU64>,
    /// Number of nodes below each binary node that becomes a node.
    below: Vec<AtomicU32>,
}

/// A node that is to be filled, and the room for those below it.
struct Open<'a> {
    /// Place of the binary node that it is made of.
    binary: usize,
    node: &'a mut Node,
    below: &'a mut [Node],
    /// Place of the first node below it.
    first: u32,
}

impl<L: Leaves> Plan<'_, L> {
    fn area(&self, child: &BvhChild) -> f32 {
        (area(child) * self.unit) as f32
    }

    fn choice(&self, place: usize) -> Choice {
        Choice::unpacked(self.choices[place - self.root].load(Ordering::Relaxed))
    }

    /// Knowledge of a child, of which `levels` levels are shared among threads.
    fn tree(&self, child: &BvhChild, levels: u32) -> Tree {
        match child.count() {
            0 => self.join(child.first() as usize, levels),
            count => {
                let cost = self.leaves.cost(child.first(), count);
                let cost = cost.expect("what stands in one leaf may stand in one leaf");
                Tree::leaf(child.first(), count, self.area(child) * cost)
            }
        }
    }

    /// Knowledge of the binary node at `place`, from that of its children; what becomes of it is written down.
    fn join(&self, place: usize, levels: u32) -> Tree {
        let node = &self.binary[place];
        let (left, right) = match levels.checked_sub(1) {
            Some(levels) => rayon::join(|| self.tree(&node.left, levels), || self.tree(&node.right, levels)),
            None => (self.tree(&node.left, 0), self.tree(&node.right, 0)),
        };
        // Least cost of both children of the binary node as 2, 3 ... children.
        let mut costs = [f32::INFINITY; WIDTH];
        let mut shares = [1; WIDTH];
        for all in 2..=WIDTH {
            for share in 1..all {
                let cost = left.costs[share - 1] + right.costs[all - share - 1];
                if cost < costs[all - 1] {
                    (costs[all - 1], shares[all - 1]) = (cost, share as u8);
                }
            }
        }
        let nodes = |all: usize| {
            let share = usize::from(shares[all - 1]);
            left.nodes[share - 1] + right.nodes[all - share - 1]
        };
        let (first, count) = match (left.count, right.count) {
            (a, b) if a == 0 || b == 0 || a + b > FEW => (0, 0),
            (a, b) if left.first + a == right.first => (left.first, a + b),
            (a, b) if right.first + b == left.first => (right.first, a + b),
            _ => (0, 0),
        };
        let mut tree = Tree::leaf(first, count, 0.0);
        let mut choice = Choice { left: [0; WIDTH], node_left: shares[WIDTH - 1], count, first };
        let around = self.area(&around(node));
        let as_node = costs[WIDTH - 1] + around * NODE_COST;
        let as_leaf = if count == 0 { None } else { self.leaves.cost(first, count).map(|cost| cost * around) };
        (tree.costs[0], choice.left[0], tree.nodes[0]) = match as_leaf {
            Some(cost) if cost <= as_node => (cost, 0, 0),
            _ => (as_node, 1, 1 + nodes(WIDTH)),
        };
        for all in 2..=WIDTH {
            let fewer = tree.costs[all - 2];
            let gains = costs[all - 1] < fewer;
            (tree.costs[all - 1], choice.left[all - 1], tree.nodes[all - 1]) =
                if gains { (costs[all - 1], shares[all - 1], nodes(all)) } else { (fewer, 0, tree.nodes[all - 2]) };
        }
        self.choices[place - self.root].store(choice.packed(), Ordering::Relaxed);
        self.below[place - self.root].store(nodes(WIDTH), Ordering::Relaxed);
        tree
    }

    /// Appends to `children` what becomes of `child` as at most `all` children of a node.
    fn gather(&self, child: BvhChild, mut all: usize, children: &mut Children) {
        if child.count() == 0 {
            let choice = self.choice(child.first() as usize);
            while all > 1 && choice.left[all - 1] == 0 {
                all -= 1;
            }
            if all > 1 {
                let share = usize::from(choice.left[all - 1]);
                let BvhNode { left, right } = self.binary[child.first() as usize];
                self.gather(left, share, children);
                self.gather(right, all - share, children);
                return;
            }
        }
        children.all[children.count] = child;
        children.count += 1;
    }

    /// Reference to the leaf that `child` becomes, or the place of the binary node that it is made of.
    fn leaf_or_node(&self, child: &BvhChild) -> Result<u32, usize> {
        if child.count() > 0 {
            return Ok(self.leaves.reference(child.first(), child.count()));
        }
        let place = child.first() as usize;
        let choice = self.choice(place);
        if choice.left[0] == 0 { Ok(self.leaves.reference(choice.first, choice.count)) } else { Err(place) }
    }

    /// Fills a node and all below it: its children side by side, then what is below the first, and so on.
    fn fill(&self, open: Open<'_>, levels: u32) {
        let Open { binary, node, below, first } = open;
        let mut children = Children::default();
        let share = usize::from(self.choice(binary).node_left);
        self.gather(self.binary[binary].left, share, &mut children);
        self.gather(self.binary[binary].right, WIDTH - share, &mut children);
        *node = Node::EMPTY;
        let (mut made_of, mut inner) = ([0; WIDTH], 0);
        for (i, child) in children.all[..children.count].iter().enumerate() {
            let reference = self.leaf_or_node(child).unwrap_or_else(|place| {
                made_of[inner] = place;
                inner += 1;
                first + inner as u32 - 1
            });
            node.set(i, child.corners(), reference);
        }
        let (nodes, mut rooms) = below.split_at_mut(inner);
        let mut first = first + inner as u32;
        let opened = made_of.into_iter().zip(nodes).map(|(binary, node)| {
            let size = self.below[binary - self.root].load(Ordering::Relaxed);
            let below = rooms.split_off_mut(..size as usize).unwrap_or_default();
            first += size;
            Open { binary, node, below, first: first - size }
        });
        match levels.checked_sub(1) {
            Some(levels) => opened.collect::<Vec<_>>().into_par_iter().for_each(|open| self.fill(open, levels)),
            None => opened.for_each(|open| self.fill(open, 0)),
        }
    }
}

/// Children of a node as they are found.
#[derive(Default)]
struct Children {
    all: [BvhChild; WIDTH],
    count: usize,
}

/// Box around both children.
fn around(node: &BvhNode) -> BvhChild {
    let ([a, b], [c, d]) = (node.left.corners(), node.right.corners());
    let lower = std::array::from_fn(|i| a[i].min(c[i]));
    let upper = std::array::from_fn(|i| b[i].max(d[i]));
    BvhChild::new([lower, upper], 0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves that say of what they are.
    struct Runs;

    impl Leaves for Runs {
        fn cost(&self, _first: u32, count: u32) -> Option<f32> {
            (count <= 8).then(|| 0.5 * count.div_ceil(4) as f32)
        }

        fn reference(&self, first: u32, count: u32) -> u32 {
            leaf(count - 1, first)
        }
    }

    /// Binary hierarchy of `count` boxes, which lie in a long row of three lanes; `skew` eighths of them stand on the left.
    fn binary(count: u32, skew: u32) -> Vec<BvhNode> {
        let corners = |range: &Range<u32>| {
            let lane = |i: u32| (i * 7 % 3) as f32;
            let (low, high) = range.clone().fold((f32::MAX, f32::MIN), |(a, b), i| (a.min(lane(i)), b.max(lane(i))));
            [[range.start as f32, low, 0.0], [range.end as f32, high + 0.5, 1.0]]
        };
        let mut nodes = vec![BvhNode::default()];
        let mut open = vec![(0, 0..count)];
        while let Some((place, range)) = open.pop() {
            let middle = range.start + (range.len() as u32 * skew / 8).clamp(1, range.len() as u32 - 1);
            let [left, right] = [range.start..middle, middle..range.end].map(|part| {
                if part.len() <= 3 {
                    return BvhChild::new(corners(&part), part.start, part.len() as u32);
                }
                nodes.push(BvhNode::default());
                open.push((nodes.len() - 1, part.clone()));
                BvhChild::new(corners(&part), nodes.len() as u32 - 1, 0)
            });
            nodes[place] = BvhNode { left, right };
        }
        nodes
    }

    fn on_threads(threads: usize, nodes: &[BvhNode]) -> (u32, Vec<Node>) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| collapse(nodes, 0..nodes.len(), &Runs))
    }

    #[test]
    fn nodes_are_the_same_on_any_number_of_threads() {
        for skew in [4, 7] {
            let nodes = binary(50_000, skew);
            let (root, wide) = on_threads(1, &nodes);
            assert_eq!(root, 0);
            for threads in [2, 3, 8] {
                assert!((root, wide.clone()) == on_threads(threads, &nodes), "{threads} threads");
            }
        }
    }

    #[test]
    fn every_leaf_is_below_one_node_whose_box_holds_it() {
        for (count, skew) in [(2, 4), (9, 4), (64, 1), (5000, 4), (5000, 7)] {
            let nodes = binary(count, skew);
            let (root, wide) = collapse(&nodes, 0..nodes.len(), &Runs);
            let mut met = vec![0; count as usize];
            let mut referred = vec![0; wide.len()];
            let everywhere = [[f32::MIN; 3], [f32::MAX; 3]];
            let mut open = vec![(root, everywhere)];
            while let Some((reference, within)) = open.pop() {
                if reference & LEAF != 0 {
                    let (more, first) = leaf_parts(reference);
                    (first..=first + more).for_each(|i| met[i as usize] += 1);
                    assert!(within[0][0] <= first as f32 && within[1][0] >= (first + more + 1) as f32);
                    continue;
                }
                referred[reference as usize] += 1;
                let node = &wide[reference as usize];
                for child in (0..WIDTH).filter(|&child| node.children[child] != NONE) {
                    let corner = |side: usize| std::array::from_fn(|axis| node.planes[2 * axis + side][child]);
                    let (lower, upper): ([f32; 3], [f32; 3]) = (corner(0), corner(1));
                    assert!((0..3).all(|i| within[0][i] <= lower[i] && upper[i] <= within[1][i]));
                    open.push((node.children[child], [lower, upper]));
                }
            }
            assert!(met.iter().all(|&times| times == 1), "{count} boxes: leaves are lost, or there twice");
            assert!(referred.iter().all(|&times| times == 1), "{count} boxes: nodes are lost, or there twice");
            // Nodes have room for eight: of a balanced tree most of it is used.
            let children: usize = wide.iter().map(|node| node.children.iter().filter(|c| **c != NONE).count()).sum();
            assert!(skew != 4 || count < 5000 || children * 4 > wide.len() * WIDTH * 3, "{children} in {}", wide.len());
        }
    }

    #[test]
    fn choices_fit_into_a_word() {
        let choice =
            Choice { left: [1, 1, 2, 3, 4, 5, 6, 7], node_left: 7, count: FEW, first: crate::MOST_IN_HIERARCHY - 1 };
        assert_eq!(Choice::unpacked(choice.packed()), choice);
        let other = Choice { left: [0, 1, 0, 1, 0, 1, 0, 1], node_left: 1, count: 0, first: 5 };
        assert_eq!(Choice::unpacked(other.packed()), other);
    }
}
