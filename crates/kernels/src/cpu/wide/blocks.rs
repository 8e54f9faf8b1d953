//! Closed forms in blocks of four of one kind, and instances.

use crate::{Instance, SceneBuffers, ShapeKind, ShapeReference};

use super::NONE;
use super::collapse::leaf;

/// Kinds of leaves: `Kind` of `cpp/traversal.h`.
const SPHERES: u32 = 0;
const RECTANGLES: u32 = 1;
const BOXES: u32 = 2;
const INSTANCE: u32 = 3;
const ROUNDS: u32 = 4;

/// `Block` of `cpp/traversal.h`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Block<const ROWS: usize> {
    rows: [[f32; 4]; ROWS],
    shapes: [u32; 4],
    holes: [u32; 4],
}

impl<const ROWS: usize> Block<ROWS> {
    /// A block of these shapes: their places, holes and numbers.
    fn new(shapes: impl Iterator<Item = (u32, ShapeReference, [f32; ROWS])>) -> Self {
        let mut block = Self { rows: [[f32::NAN; 4]; ROWS], shapes: [NONE; 4], holes: [0; 4] };
        for (lane, (place, shape, numbers)) in shapes.enumerate() {
            block.rows.iter_mut().zip(numbers).for_each(|(row, number)| row[lane] = number);
            (block.shapes[lane], block.holes[lane]) = (place, shape.has_holes);
        }
        block
    }
}

/// `InstanceRecord` of `cpp/traversal.h`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InstanceRecord {
    columns: [[f32; 4]; 4],
    root: u32,
    first_node: u32,
    first_triangle: u32,
    shape: u32,
    holes: u32,
    identity: u32,
    unused: [u32; 2],
}

impl InstanceRecord {
    /// Record of `instance`, whose place is filled in later, of a mesh with this root and these first places.
    pub fn new(instance: &Instance, root: u32, first_node: u32, first_triangle: u32) -> Self {
        const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let map = instance.mesh_from_world;
        let columns = std::array::from_fn(|column| [map[0][column], map[1][column], map[2][column], 0.0]);
        let identity = u32::from(map == IDENTITY);
        Self {
            columns,
            root,
            first_node,
            first_triangle,
            shape: NONE,
            holes: instance.has_holes,
            identity,
            unused: [0; 2],
        }
    }
}

/// All that leaves of the upper hierarchy refer to.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    pub instances: Vec<InstanceRecord>,
    pub spheres: Vec<Block<4>>,
    pub rectangles: Vec<Block<14>>,
    pub boxes: Vec<Block<15>>,
    pub rounds: Vec<Block<16>>,
}

impl Blocks {
    /// Whether shapes of this kind can be added.
    pub fn holds(kind: u32) -> bool {
        let known = [ShapeKind::Sphere, ShapeKind::Rectangle, ShapeKind::Box, ShapeKind::Round, ShapeKind::Instance];
        known.iter().any(|known| *known as u32 == kind)
    }

    /// Bytes of all lists.
    pub fn bytes(&self) -> usize {
        let Self { instances, spheres, rectangles, boxes, rounds } = self;
        let of_blocks = size_of_val(&spheres[..]) + size_of_val(&rectangles[..]) + size_of_val(&boxes[..]);
        size_of_val(&instances[..]) + of_blocks + size_of_val(&rounds[..])
    }

    /// Adds up to four `shapes` of one kind, or one instance, and returns the reference to the leaf that holds them.
    pub fn add(
        &mut self,
        buffers: &SceneBuffers,
        mut shapes: impl Iterator<Item = (u32, ShapeReference)>,
        record: impl FnOnce(&Instance) -> InstanceRecord,
    ) -> u32 {
        let first = shapes.next().expect("no leaf is empty");
        let kind = first.1.kind;
        let all = std::iter::once(first).chain(shapes);
        let index = |shape: ShapeReference| shape.index as usize;
        if kind == ShapeKind::Sphere as u32 {
            let rows = all.map(|(place, shape)| (place, shape, sphere(&buffers.spheres[index(shape)])));
            push(&mut self.spheres, Block::new(rows), SPHERES)
        } else if kind == ShapeKind::Rectangle as u32 {
            let rows = all.map(|(place, shape)| (place, shape, rectangle(&buffers.rectangles[index(shape)])));
            push(&mut self.rectangles, Block::new(rows), RECTANGLES)
        } else if kind == ShapeKind::Box as u32 {
            let rows = all.map(|(place, shape)| (place, shape, cuboid(&buffers.boxes[index(shape)])));
            push(&mut self.boxes, Block::new(rows), BOXES)
        } else if kind == ShapeKind::Round as u32 {
            let rows = all.map(|(place, shape)| (place, shape, round(&buffers.rounds[index(shape)])));
            push(&mut self.rounds, Block::new(rows), ROUNDS)
        } else {
            let (place, shape) = first;
            let record = InstanceRecord { shape: place, ..record(&buffers.instances[index(shape)]) };
            push(&mut self.instances, record, INSTANCE)
        }
    }
}

/// Appends `item`, and returns the reference to it.
fn push<T>(items: &mut Vec<T>, item: T, kind: u32) -> u32 {
    items.push(item);
    leaf(kind, items.len() as u32 - 1)
}

fn sphere(sphere: &crate::Sphere) -> [f32; 4] {
    let [x, y, z] = sphere.center;
    [x, y, z, sphere.radius]
}

fn rectangle(rectangle: &crate::Rectangle) -> [f32; 14] {
    // In the order in which kernels add up.
    let square = |[x, y, z]: [f32; 3]| x * x + y * y + z * z;
    let crate::Rectangle { corner, edge_u, edge_v, normal, .. } = *rectangle;
    let squares = [square(edge_u), square(edge_v)];
    joined([&corner, &edge_u, &edge_v, &normal, &squares])
}

fn cuboid(cuboid: &crate::Box) -> [f32; 15] {
    let crate::Box { center, half_size, axis_x, axis_y, axis_z, .. } = cuboid;
    joined([center, half_size, axis_x, axis_y, axis_z])
}

fn round(round: &crate::Round) -> [f32; 16] {
    let crate::Round { base, axis_x, axis_y, axis_z, radius, height, slope, capped, .. } = *round;
    joined([&base, &axis_x, &axis_y, &axis_z, &[radius, height, slope, capped as f32]])
}

/// All numbers of `parts`, one part after the other.
fn joined<const N: usize>(parts: [&[f32]; 5]) -> [f32; N] {
    let mut numbers = parts.into_iter().flatten().copied();
    std::array::from_fn(|_| numbers.next().expect("the parts fill the rows"))
}
