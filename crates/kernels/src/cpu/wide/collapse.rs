//! Nodes of eight children from binary ones, at the least cost that the surface area heuristic finds [ylitie2017cwbvh].

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
#[derive(Clone, Copy, Debug, PartialEq)]
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
        children: [LEAF; WIDTH],
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

/// Contents of the leaves.
pub(super) trait Leaves {
    /// Cost of one leaf that holds `count` from place `first` on; `None` if one leaf cannot.
    fn cost(&self, first: u32, count: u32) -> Option<f32>;
    /// Reference to a leaf that holds `count` from place `first` on.
    fn reference(&mut self, first: u32, count: u32) -> u32;
}

/// Knowledge of a binary node, or of a leaf.
#[derive(Clone, Copy)]
struct Tree {
    /// Least cost of all below as at most 1, 2 ... children of a node.
    costs: [f32; WIDTH],
    /// How many of so many children stand on the left; 0: none is gained over one child less. Of a single child: 1 if it is a
    /// node, 0 if it is a leaf.
    left: [u8; WIDTH],
    /// How many of a node's own children stand on the left.
    node_left: u8,
    /// Number of leaves if they stand side by side and are few, else 0; and the first.
    count: u8,
    first: u32,
}

/// Most leaves that are counted.
const FEW: u32 = 15;

/// Appends the hierarchy below node `root` of `binary` to `wide`, and returns the reference to its root. References count
/// from the first node that is appended.
pub(super) fn collapse(binary: &[BvhNode], root: u32, leaves: &mut impl Leaves, wide: &mut Vec<Node>) -> u32 {
    let binary = below(binary, root);
    let BvhNode { left, right } = binary[0];
    if left.count() > 0 && right.count() > 0 && left.first() == right.first() {
        // What stands alone stands in both children.
        return leaves.reference(left.first(), left.count());
    }
    let unit = 1.0 / area(&binary[0].left).max(area(&binary[0].right)).max(f64::MIN_POSITIVE);
    let mut plan = Plan { binary, root, unit, trees: vec![Tree::leaf(0, 0, 0.0); binary.len()] };
    for place in (0..binary.len()).rev() {
        plan.trees[place] = plan.join(place, leaves);
    }
    plan.emit(leaves, wide)
}

/// Nodes of the hierarchy below `root`, which stand side by side, parents before children.
fn below(binary: &[BvhNode], root: u32) -> &[BvhNode] {
    let root = root as usize;
    let (mut place, mut end) = (root, root + 1);
    while place < end {
        let BvhNode { left, right } = binary[place];
        for child in [left, right].iter().filter(|child| child.count() == 0) {
            end = end.max(child.first() as usize + 1);
        }
        place += 1;
    }
    &binary[root..end]
}

/// Half of the surface of a child's box.
fn area(child: &BvhChild) -> f64 {
    let [lower, upper] = child.corners().map(|corner| corner.map(f64::from));
    let [x, y, z] = std::array::from_fn(|i| upper[i] - lower[i]);
    x * y + y * z + z * x
}

impl Tree {
    fn leaf(first: u32, count: u32, cost: f32) -> Self {
        Self { costs: [cost; WIDTH], left: [0; WIDTH], node_left: 0, count: count as u8, first }
    }
}

/// Which binary nodes become nodes of their own.
struct Plan<'a> {
    binary: &'a [BvhNode],
    /// Place that `binary` begins at, from which its references do not count.
    root: u32,
    /// Reciprocal of the largest box's area, which keeps costs within range.
    unit: f64,
    /// Knowledge of each node.
    trees: Vec<Tree>,
}

impl Plan<'_> {
    fn area(&self, child: &BvhChild) -> f32 {
        (area(child) * self.unit) as f32
    }

    /// Knowledge of a child.
    fn tree(&self, child: &BvhChild, leaves: &impl Leaves) -> Tree {
        match child.count() {
            0 => self.trees[(child.first() - self.root) as usize],
            count => {
                let cost = leaves.cost(child.first(), count).expect("what stands in one leaf may stand in one leaf");
                Tree::leaf(child.first(), count, self.area(child) * cost)
            }
        }
    }

    /// Knowledge of the node at `place`, from that of its children.
    fn join(&self, place: usize, leaves: &impl Leaves) -> Tree {
        let node = &self.binary[place];
        let around = self.area(&around(node));
        let [left, right] = [self.tree(&node.left, leaves), self.tree(&node.right, leaves)];
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
        let (first, count) = match (left.count as u32, right.count as u32) {
            (a, b) if a == 0 || b == 0 || a + b > FEW => (0, 0),
            (a, b) if left.first + a == right.first => (left.first, a + b),
            (a, b) if right.first + b == left.first => (right.first, a + b),
            _ => (0, 0),
        };
        let mut tree = Tree::leaf(first, count, 0.0);
        tree.node_left = shares[WIDTH - 1];
        let as_node = costs[WIDTH - 1] + around * NODE_COST;
        let as_leaf = if count == 0 { None } else { leaves.cost(first, count).map(|cost| cost * around) };
        (tree.costs[0], tree.left[0]) = match as_leaf {
            Some(cost) if cost <= as_node => (cost, 0),
            _ => (as_node, 1),
        };
        for all in 2..=WIDTH {
            let fewer = tree.costs[all - 2];
            let gains = costs[all - 1] < fewer;
            (tree.costs[all - 1], tree.left[all - 1]) =
                if gains { (costs[all - 1], shares[all - 1]) } else { (fewer, 0) };
        }
        tree
    }

    /// Appends to `children` what becomes of `child` as at most `all` children of a node.
    fn gather(&self, child: BvhChild, mut all: usize, children: &mut Vec<BvhChild>) {
        if child.count() == 0 {
            let tree = &self.trees[(child.first() - self.root) as usize];
            while all > 1 && tree.left[all - 1] == 0 {
                all -= 1;
            }
            if all > 1 {
                let share = tree.left[all - 1] as usize;
                let BvhNode { left, right } = self.binary[(child.first() - self.root) as usize];
                self.gather(left, share, children);
                self.gather(right, all - share, children);
                return;
            }
        }
        children.push(child);
    }

    /// Appends the nodes, and returns the reference to the root.
    fn emit(&self, leaves: &mut impl Leaves, wide: &mut Vec<Node>) -> u32 {
        let base = wide.len();
        let whole = BvhChild::new(around(&self.binary[0]).corners(), self.root, 0);
        // Binary nodes that become nodes, and their places.
        let mut open = vec![];
        let mut children = Vec::with_capacity(WIDTH);
        let root = self.place(whole, leaves, wide, base, &mut open);
        while let Some((node, place)) = open.pop() {
            let share = self.trees[node].node_left as usize;
            children.clear();
            self.gather(self.binary[node].left, share, &mut children);
            self.gather(self.binary[node].right, WIDTH - share, &mut children);
            let begun = open.len();
            for (i, &child) in children.iter().enumerate() {
                let reference = self.place(child, leaves, wide, base, &mut open);
                wide[place].set(i, child.corners(), reference);
            }
            // The first child's nodes come first.
            open[begun..].reverse();
        }
        root
    }

    /// Reference to what `child` becomes: a leaf, or a node that is still open.
    fn place(
        &self,
        child: BvhChild,
        leaves: &mut impl Leaves,
        wide: &mut Vec<Node>,
        base: usize,
        open: &mut Vec<(usize, usize)>,
    ) -> u32 {
        if child.count() > 0 {
            return leaves.reference(child.first(), child.count());
        }
        let node = (child.first() - self.root) as usize;
        let tree = &self.trees[node];
        if tree.left[0] == 0 {
            return leaves.reference(tree.first, u32::from(tree.count));
        }
        open.push((node, wide.len()));
        wide.push(Node::EMPTY);
        (wide.len() - 1 - base) as u32
    }
}

/// Box around both children.
fn around(node: &BvhNode) -> BvhChild {
    let ([a, b], [c, d]) = (node.left.corners(), node.right.corners());
    let lower = std::array::from_fn(|i| a[i].min(c[i]));
    let upper = std::array::from_fn(|i| b[i].max(d[i]));
    BvhChild::new([lower, upper], 0, 0)
}
