//! Structures by which hardware finds the surfaces of a scene.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Weak};

use raggio_kernels::{Instance, SceneBuffers, ShapeKind, ShapeReference};
use raggio_scene::Mesh;
use raggio_vulkan::{
    Buffer, Device as VulkanContext, Placed, Structure, StructureKind, StructureSize, Triangles, VulkanError,
};

use crate::translation::device_scene::{Boxed, DeviceScene};
use crate::translation::hierarchy::WORTH_REFITTING;

/// Bytes that the device reads a box, or a placed structure, from.
const BOX_BYTES: u64 = 24;
const PLACE_BYTES: u64 = 64;

/// Structures of a scene on a device: one of each mesh, one of all other shapes, and one in which those stand.
pub(crate) struct Structures {
    /// Structures in the order of the scene's meshes; `None` for one without triangles. Weak references tell the meshes: while
    /// they are there no other mesh can have such an address.
    meshes: Vec<OfMesh>,
    /// Places of meshes among them, by their addresses.
    places: HashMap<usize, usize>,
    shapes: Option<Arc<Structure>>,
    scene: Arc<Structure>,
    made_of: Parts,
}

type OfMesh = (Weak<Mesh>, Option<Arc<Structure>>);

/// Lists that say where the structures of shapes and meshes stand.
#[derive(Clone, PartialEq)]
struct Parts {
    order: Arc<Vec<ShapeReference>>,
    instances: Arc<Vec<Instance>>,
    boxed: Arc<Boxed>,
}

impl Parts {
    fn of(scene: &DeviceScene) -> Self {
        let SceneBuffers { order, instances, .. } = &scene.buffers;
        Self { order: order.clone(), instances: instances.clone(), boxed: scene.boxed().clone() }
    }

    /// Whether both are the same lists, or equal ones.
    fn same(&self, other: &Self) -> bool {
        same(&self.order, &other.order) && same(&self.instances, &other.instances) && same(&self.boxed, &other.boxed)
    }
}

fn same<T: PartialEq>(a: &Arc<T>, b: &Arc<T>) -> bool {
    Arc::ptr_eq(a, b) || a == b
}

impl Structures {
    /// Structure of the whole scene.
    pub fn scene(&self) -> &Arc<Structure> {
        &self.scene
    }

    /// Most bytes that the structures of `scene` take at once while they are built, but for what `old` has of them.
    ///
    /// # Errors
    /// A [`VulkanError`] when the device has no structures so large.
    pub fn room(context: &VulkanContext, scene: &DeviceScene, old: Option<&Self>) -> Result<u64, VulkanError> {
        let counts = |place: usize| scene.buffers.meshes[place].triangles;
        let new = scene.meshes().enumerate().filter(|(_, mesh)| old.is_none_or(|old| old.of_mesh(mesh).is_none()));
        let of_meshes = context.room_for_triangles(new.map(|(place, _)| counts(place)).filter(|count| *count > 0))?;
        if of_meshes == 0 && old.is_some_and(|old| old.made_of.same(&Parts::of(scene))) {
            return Ok(0);
        }
        let (boxes, shapes) = (scene.boxed().boxes.len(), scene.buffers.order.len());
        let of_boxes = match boxes {
            0 => 0,
            _ => context.structure_size(StructureKind::Boxes, boxes as u32)?.total() + BOX_BYTES * boxes as u64,
        };
        // Numbers of placed structures are places among all shapes, and no more of them can there be.
        let size = context.structure_size(kind(scene), shapes as u32)?;
        Ok(of_meshes + of_boxes + StructureSize::total(size) + PLACE_BYTES * shapes as u64)
    }

    /// Builds the structures of `scene`, whose triangles are in a buffer on the device. What `old` has of them is kept, and where
    /// its shapes have only moved they are refitted, if the hierarchy of the host was.
    ///
    /// # Errors
    /// A [`VulkanError`] when the device fails, or has no memory for them.
    pub fn build(
        context: &Arc<VulkanContext>,
        scene: &DeviceScene,
        triangles: &Arc<Buffer>,
        old: Option<&Self>,
    ) -> Result<Self, VulkanError> {
        let made_of = Parts::of(scene);
        let meshes = Self::of_meshes(context, scene, triangles, old)?;
        let places = meshes.iter().enumerate().map(|(place, (mesh, _))| (mesh.as_ptr().addr(), place)).collect();
        let same_meshes = old.is_some_and(|old| old.has(&meshes));
        if let Some(old) = old.filter(|old| same_meshes && old.made_of.same(&made_of)) {
            return Ok(Self { meshes, places, shapes: old.shapes.clone(), scene: old.scene.clone(), made_of });
        }
        let boxes = &made_of.boxed.boxes;
        let shapes = match old {
            _ if boxes.is_empty() => None,
            Some(old) if same(&old.made_of.boxed, &made_of.boxed) => old.shapes.clone(),
            _ => Some(Structure::of_boxes(context, boxes)?),
        };
        let placed = placed(&made_of, &meshes, shapes.as_ref());
        let moved = |old: &&Self| same_meshes && same(&old.made_of.order, &made_of.order) && refits(scene);
        let scene = match old.filter(moved) {
            Some(old) if old.scene.parts() == placed.len() as u32 => old.scene.refitted(&placed)?,
            _ => Structure::of_placed(context, &placed, refits(scene))?,
        };
        Ok(Self { meshes, places, shapes, scene, made_of })
    }

    fn of_meshes(
        context: &Arc<VulkanContext>,
        scene: &DeviceScene,
        triangles: &Arc<Buffer>,
        old: Option<&Self>,
    ) -> Result<Vec<OfMesh>, VulkanError> {
        let known: Vec<_> = scene.meshes().map(|mesh| old.and_then(|old| old.of_mesh(mesh))).collect();
        let ranges = scene.buffers.meshes.iter().map(|mesh| mesh.first_triangle..mesh.first_triangle + mesh.triangles);
        let is_new = |known: &Option<Arc<Structure>>, range: &Range<u32>| known.is_none() && !range.is_empty();
        let new: Vec<_> = (known.iter().zip(ranges.clone()))
            .filter(|(known, range)| is_new(known, range))
            .map(|(_, range)| Triangles { buffer: triangles.clone(), range })
            .collect();
        let mut built = Structure::of_triangles(context, &new)?.into_iter();
        let all = scene.meshes().zip(known).zip(ranges).map(|((mesh, known), range)| {
            let structure = if is_new(&known, &range) { built.next() } else { known };
            (Arc::downgrade(mesh), structure)
        });
        Ok(all.collect())
    }

    /// Structure of `mesh`, if it is there.
    fn of_mesh(&self, mesh: &Arc<Mesh>) -> Option<Arc<Structure>> {
        self.meshes[*self.places.get(&Arc::as_ptr(mesh).addr())?].1.clone()
    }

    /// Whether the structures of meshes are these, in the same order.
    fn has(&self, meshes: &[OfMesh]) -> bool {
        let structure = |(_, structure): &OfMesh| structure.as_ref().map(Arc::as_ptr);
        self.meshes.iter().map(structure).eq(meshes.iter().map(structure))
    }
}

/// Whether the structure of `scene` is refitted where shapes move: as the hierarchy of the host is, whose order of shapes stays
/// then.
fn refits(scene: &DeviceScene) -> bool {
    scene.buffers.order.len() >= WORTH_REFITTING
}

fn kind(scene: &DeviceScene) -> StructureKind {
    StructureKind::Placed { refits: refits(scene) }
}

/// Structures where they stand: that of all shapes that are no meshes, then the meshes in the order of the scene's shapes.
fn placed(parts: &Parts, meshes: &[OfMesh], shapes: Option<&Arc<Structure>>) -> Vec<Placed> {
    const STILL: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let shapes = shapes.map(|structure| Placed {
        world_from_structure: STILL,
        number: 0,
        has_holes: false,
        structure: structure.clone(),
    });
    let instances = parts.order.iter().zip(0..).filter(|(shape, _)| shape.kind == ShapeKind::Instance as u32);
    let instances = instances.filter_map(|(shape, number)| {
        let instance = &parts.instances[shape.index as usize];
        Some(Placed {
            world_from_structure: instance.world_from_mesh,
            number,
            has_holes: instance.has_holes != 0,
            structure: meshes[instance.mesh as usize].1.clone()?,
        })
    });
    shapes.into_iter().chain(instances).collect()
}
