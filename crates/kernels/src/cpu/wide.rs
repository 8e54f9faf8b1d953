//! Scene as the walk of `cpp/traversal.h` reads it: hierarchies of eight children a node, made from the binary ones that all
//! devices share, and closed forms in blocks of four.

mod blocks;
mod collapse;

use std::sync::{Arc, Weak};

use rayon::prelude::*;

use self::blocks::{Blocks, InstanceRecord};
use self::collapse::{LEAF, Leaves, MOST_PLACES, Node, collapse};
use crate::{BvhChild, BvhNode, Mesh, SceneBuffers, ShapeKind, ShapeReference};

/// `Traversal` of `cpp/traversal.h`.
pub type TraversalWords = [u64; 10];
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
    /// Hierarchies that these were made from, and that others need not keep.
    source: (Weak<Vec<BvhNode>>, Weak<Vec<Mesh>>),
    nodes: Vec<Node>,
    /// Each mesh's root and the place where its nodes begin.
    roots: Vec<(u32, u32)>,
}

impl WideScene {
    /// Translates the checked scene in `buffers`; what `before` has of the same meshes is taken over. `None` where a mesh
    /// has more triangles than a reference can count, there are as many shapes, or one is of a kind that the wide walk does not
    /// know.
    pub fn new(buffers: &SceneBuffers, before: Option<&Self>) -> Option<Self> {
        let bounded = &buffers.order[buffers.constants().counts.unbounded as usize..];
        if !bounded.iter().all(|shape| Blocks::holds(shape.kind)) || buffers.order.len() > MOST_PLACES as usize {
            return None;
        }
        let source = WideMeshes::source(buffers);
        let same = |old: &WideMeshes| old.source.0.ptr_eq(&source.0) && old.source.1.ptr_eq(&source.1);
        let meshes = match before {
            Some(before) if same(&before.meshes) => before.meshes.clone(),
            _ => Arc::new(WideMeshes::new(buffers)?),
        };
        let mut scene = Self { meshes, nodes: vec![], root: NONE, blocks: Blocks::default() };
        if !buffers.nodes.is_empty() {
            let single = one_by_one(&buffers.nodes);
            (scene.root, scene.nodes) = collapse(&single, 0..single.len(), &Shapes(buffers));
            scene.fill_blocks(buffers);
        }
        Some(scene)
    }

    /// Puts the shapes of all leaves into blocks, in the order of the nodes, and refers to these instead.
    fn fill_blocks(&mut self, buffers: &SceneBuffers) {
        let Self { meshes, nodes, root, blocks } = self;
        let children = nodes.iter_mut().flat_map(|node| &mut node.children);
        for reference in std::iter::once(root).chain(children).filter(|child| **child & LEAF != 0 && **child != NONE) {
            let (count, first) = collapse::leaf_parts(*reference);
            let shapes = buffers.order[first as usize..][..count as usize + 1].iter().enumerate();
            let placed = shapes.map(|(i, &shape)| (first + i as u32, shape));
            *reference = blocks.add(buffers, placed, |instance| {
                let mesh = instance.mesh as usize;
                let (root, first_node) = meshes.roots[mesh];
                InstanceRecord::new(instance, root, first_node, buffers.meshes[mesh].first_triangle)
            });
        }
    }

    /// `Traversal` of `cpp/traversal.h`; rays take turns if `in_turn`, or where the scene is large. Its addresses are good as
    /// long as this scene and `buffers` are.
    pub fn words(&self, buffers: &SceneBuffers, in_turn: bool) -> TraversalWords {
        let Blocks { instances, spheres, rectangles, boxes, rounds } = &self.blocks;
        [
            self.nodes.as_ptr() as u64,
            self.meshes.nodes.as_ptr() as u64,
            buffers.triangles.as_ptr() as u64,
            instances.as_ptr() as u64,
            spheres.as_ptr() as u64,
            rectangles.as_ptr() as u64,
            boxes.as_ptr() as u64,
            rounds.as_ptr() as u64,
            u64::from(self.root),
            u64::from(in_turn || self.bytes_of_nodes() + size_of_val(&buffers.triangles[..]) > NEAR),
        ]
    }

    fn bytes_of_nodes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.meshes.nodes[..])
    }

    /// Bytes of all lists.
    pub fn bytes(&self) -> usize {
        self.bytes_of_nodes() + self.blocks.bytes()
    }
}

impl WideMeshes {
    fn new(buffers: &SceneBuffers) -> Option<Self> {
        let SceneBuffers { meshes, mesh_nodes, .. } = buffers;
        if meshes.iter().any(|mesh| mesh.triangles > MOST_PLACES) {
            return None;
        }
        let parts: Vec<_> = (0..meshes.len())
            .into_par_iter()
            .map(|i| {
                let end = meshes.get(i + 1).map_or(mesh_nodes.len(), |next| next.root as usize);
                let leaves = Triangles { first: meshes[i].first_triangle };
                collapse(mesh_nodes, meshes[i].root as usize..end, &leaves)
            })
            .collect();
        let mut nodes = vec![];
        let roots = parts.into_iter().map(|(root, mut part)| {
            let first = nodes.len() as u32;
            // A single mesh is not copied.
            if nodes.is_empty() {
                nodes = part;
            } else {
                nodes.append(&mut part);
            }
            // References count from the mesh's own first node.
            (root, first)
        });
        let roots = roots.collect();
        Some(Self { source: Self::source(buffers), nodes, roots })
    }

    fn source(buffers: &SceneBuffers) -> (Weak<Vec<BvhNode>>, Weak<Vec<Mesh>>) {
        (Arc::downgrade(&buffers.mesh_nodes), Arc::downgrade(&buffers.meshes))
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

    fn reference(&self, first: u32, count: u32) -> u32 {
        collapse::leaf(count - 1, first - self.first)
    }
}

/// Shapes of the upper hierarchy. References are to their places, until blocks are there.
struct Shapes<'a>(&'a SceneBuffers);

impl Leaves for Shapes<'_> {
    fn cost(&self, first: u32, count: u32) -> Option<f32> {
        let alike = |run: &[ShapeReference]| run.iter().all(|shape| shape.kind == run[0].kind);
        if count == 1 {
            return Some(BLOCK_COST);
        }
        let run = (count <= 4).then(|| &self.0.order[first as usize..][..count as usize])?;
        (alike(run) && run[0].kind != ShapeKind::Instance as u32).then_some(BLOCK_COST)
    }

    fn reference(&self, first: u32, count: u32) -> u32 {
        collapse::leaf(count - 1, first)
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
