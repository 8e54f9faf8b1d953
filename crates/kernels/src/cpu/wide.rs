//! Scene as the walk of `cpp/traversal.h` reads it: hierarchies of eight children a node, made from the binary ones that all
//! devices share, and closed forms in blocks of four.

mod blocks;
mod collapse;

use std::sync::Arc;

use self::blocks::{Blocks, InstanceRecord};
use self::collapse::{LEAF, Leaves, Node, collapse};
use crate::{BvhChild, BvhNode, Mesh, SceneBuffers, ShapeKind, ShapeReference, Triangle};

/// `Traversal` of `cpp/traversal.h`.
pub type TraversalWords = [u64; 9];
/// Reference to nothing.
const NONE: u32 = u32::MAX;
/// Triangles that a leaf may have: two of the blocks that are tested at once.
const MOST_TRIANGLES: u32 = 8;
/// Bytes that caches hold near by: the second level has half a megabyte and more, of which a core reads a part much.
const NEAR: usize = 4 << 20;
/// Cost of a block of four triangles or shapes beside that of a node.
const BLOCK_COST: f32 = 0.5;

/// A scene as the wide walk reads it.
#[derive(Debug)]
pub struct WideScene {
    meshes: Arc<WideMeshes>,
    nodes: Vec<Node>,
    root: u32,
    blocks: Blocks,
}

/// Hierarchies of all meshes.
#[derive(Debug)]
struct WideMeshes {
    /// Hierarchies that these were made from.
    source: (Arc<Vec<BvhNode>>, Arc<Vec<Mesh>>),
    nodes: Vec<Node>,
    /// Each mesh's root and the place where its nodes begin.
    roots: Vec<(u32, u32)>,
}

impl WideScene {
    /// Translates the checked scene in `buffers`; what `before` has of the same meshes is taken over. `None` where a mesh
    /// has more triangles than a reference can count, or a shape is of a kind that the wide walk does not know.
    pub fn new(buffers: &SceneBuffers, before: Option<&Self>) -> Option<Self> {
        let bounded = &buffers.order[buffers.counts[0].unbounded as usize..];
        if !bounded.iter().all(|shape| Blocks::holds(shape.kind)) {
            return None;
        }
        let source = (&buffers.mesh_nodes, &buffers.meshes);
        let same = |old: &WideMeshes| Arc::ptr_eq(&old.source.0, source.0) && Arc::ptr_eq(&old.source.1, source.1);
        let meshes = match before {
            Some(before) if same(&before.meshes) => before.meshes.clone(),
            _ => Arc::new(WideMeshes::new(buffers)?),
        };
        let mut blocks = Blocks::default();
        let mut nodes = vec![];
        let root = if buffers.nodes.is_empty() {
            NONE
        } else {
            let single = one_by_one(&buffers.nodes);
            let mut leaves = Shapes { buffers, meshes: &meshes, blocks: &mut blocks };
            collapse(&single, 0, &mut leaves, &mut nodes)
        };
        Some(Self { meshes, nodes, root, blocks })
    }

    /// `Traversal` of `cpp/traversal.h`; rays take turns if `in_turn`, or where the scene is large. Its addresses are good as long as this scene and `buffers` are.
    pub fn words(&self, buffers: &SceneBuffers, in_turn: bool) -> TraversalWords {
        let Blocks { instances, spheres, rectangles, boxes } = &self.blocks;
        [
            self.nodes.as_ptr() as u64,
            self.meshes.nodes.as_ptr() as u64,
            buffers.triangles.as_ptr() as u64,
            instances.as_ptr() as u64,
            spheres.as_ptr() as u64,
            rectangles.as_ptr() as u64,
            boxes.as_ptr() as u64,
            u64::from(self.root),
            u64::from(in_turn || self.bytes(buffers) > NEAR),
        ]
    }

    /// Bytes of nodes and triangles.
    fn bytes(&self, buffers: &SceneBuffers) -> usize {
        let nodes = self.nodes.len() + self.meshes.nodes.len();
        nodes * size_of::<Node>() + buffers.triangles.len() * size_of::<Triangle>()
    }
}

impl WideMeshes {
    fn new(buffers: &SceneBuffers) -> Option<Self> {
        if buffers.meshes.iter().any(|mesh| mesh.triangles > collapse::MOST_PLACES) {
            return None;
        }
        let mut nodes = vec![];
        let roots = buffers.meshes.iter().map(|mesh| {
            let first = nodes.len() as u32;
            let root =
                collapse(&buffers.mesh_nodes, mesh.root, &mut Triangles { first: mesh.first_triangle }, &mut nodes);
            // References count from the mesh's own first node.
            (root, first)
        });
        let roots = roots.collect();
        Some(Self { source: (buffers.mesh_nodes.clone(), buffers.meshes.clone()), nodes, roots })
    }
}

/// Triangles of one mesh.
struct Triangles {
    /// Place of the mesh's first triangle.
    first: u32,
}

impl Leaves for Triangles {
    fn cost(&self, _first: u32, count: u32) -> Option<f32> {
        (count <= MOST_TRIANGLES).then(|| BLOCK_COST * count.div_ceil(4) as f32)
    }

    fn reference(&mut self, first: u32, count: u32) -> u32 {
        collapse::leaf(count - 1, first - self.first)
    }
}

/// Shapes of the upper hierarchy.
struct Shapes<'a> {
    buffers: &'a SceneBuffers,
    meshes: &'a WideMeshes,
    blocks: &'a mut Blocks,
}

impl Shapes<'_> {
    fn run(&self, first: u32, count: u32) -> &[ShapeReference] {
        &self.buffers.order[first as usize..][..count as usize]
    }
}

impl Leaves for Shapes<'_> {
    fn cost(&self, first: u32, count: u32) -> Option<f32> {
        let alike = |run: &[ShapeReference]| run.iter().all(|shape| shape.kind == run[0].kind);
        if count == 1 {
            return Some(BLOCK_COST);
        }
        let run = (count <= 4).then(|| self.run(first, count))?;
        (alike(run) && run[0].kind != ShapeKind::Instance as u32).then_some(BLOCK_COST)
    }

    fn reference(&mut self, first: u32, count: u32) -> u32 {
        let shapes = self.buffers.order[first as usize..][..count as usize].iter().enumerate();
        let placed = shapes.map(|(i, &shape)| (first + i as u32, shape));
        self.blocks.add(self.buffers, placed, |instance| {
            let mesh = instance.mesh as usize;
            let (root, first_node) = self.meshes.roots[mesh];
            InstanceRecord::new(instance, root, first_node, self.buffers.meshes[mesh].first_triangle)
        })
    }
}

/// The hierarchy `nodes` with one shape in each leaf, so that leaves can be of one kind.
fn one_by_one(nodes: &[BvhNode]) -> Vec<BvhNode> {
    let mut single = nodes.to_vec();
    for place in 0..nodes.len() {
        let BvhNode { left, right } = nodes[place];
        let [left, right] = [left, right].map(|child| split(child, &mut single));
        single[place] = BvhNode { left, right };
    }
    single
}

/// The child with one leaf alone, or a node, new ones if need be.
fn split(child: BvhChild, nodes: &mut Vec<BvhNode>) -> BvhChild {
    if child.count() < 2 {
        return child;
    }
    let corners = child.corners();
    let place = nodes.len();
    nodes.push(BvhNode { left: BvhChild::new(corners, child.first(), 1), right: child });
    nodes[place].right = split(BvhChild::new(corners, child.first() + 1, child.count() - 1), nodes);
    BvhChild::new(corners, place as u32, 0)
}

const _: () = assert!(LEAF == 1 << 31);
