//! Meshes as devices read them, each with its hierarchy.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{Vec2, Vec3};
use raggio_kernels::{BvhNode, MOST_IN_HIERARCHY, Mesh as DeviceMesh, NONE, SceneBuffers, Triangle};
use raggio_scene::Mesh;
use rayon::prelude::*;

use crate::devices::machine;
use crate::translation::error::TranslationError;
use crate::translation::hierarchy::{Bounds, Hierarchy, moved};

/// The meshes of a scene, one behind the other. Kept from edit to edit: a mesh is built once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Meshes {
    known: Vec<Known>,
    /// Places of meshes among `known`, by their addresses.
    places: HashMap<usize, usize>,
    nodes: Arc<Vec<BvhNode>>,
    triangles: Arc<Vec<Triangle>>,
    materials: Arc<Vec<u32>>,
    attributes: Arc<Vec<u32>>,
    infos: Arc<Vec<DeviceMesh>>,
}

/// A mesh that has been built.
#[derive(Clone, Debug)]
struct Known {
    /// Mesh, which is kept so that no other can have its address.
    mesh: Arc<Mesh>,
    bounds: Bounds,
    /// Word at which the mesh's lists over vertices begin.
    first_word: u32,
}

impl Meshes {
    /// Holds the meshes `wanted`, each once, and no others. Builds what is new, and touches nothing if nothing is.
    pub fn hold(&mut self, wanted: &[Arc<Mesh>]) -> Result<(), TranslationError> {
        let addresses: HashSet<usize> = wanted.iter().map(address).collect();
        let is_wanted = |known: &Known| addresses.contains(&address(&known.mesh));
        if !self.known.iter().all(is_wanted) {
            let old = std::mem::take(self);
            for (place, known) in old.known.iter().enumerate().filter(|(_, known)| is_wanted(known)) {
                self.append(known.mesh.clone(), old.part(place))?;
            }
        }
        let new: Vec<_> = wanted.iter().filter(|mesh| self.place(mesh).is_none()).collect();
        if new.is_empty() {
            return Ok(());
        }
        let triangles = new.iter().map(|mesh| mesh.triangles.len()).sum();
        check_memory(triangles, machine::available_bytes())?;
        // Each mesh is built on all threads if it is large, and many are built at once.
        let parts: Vec<_> = new.par_iter().map(|mesh| Part::build(mesh)).collect();
        for (mesh, part) in new.into_iter().zip(parts) {
            self.append(mesh.clone(), part)?;
        }
        Ok(())
    }

    /// Place of `mesh` in the scene's list; `None` if it is not held.
    pub fn place(&self, mesh: &Arc<Mesh>) -> Option<usize> {
        self.places.get(&address(mesh)).copied()
    }

    /// Box around the mesh at `place`.
    pub fn bounds(&self, place: usize) -> Bounds {
        self.known[place].bounds
    }

    /// The meshes, in the order of the scene's list.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Arc<Mesh>> {
        self.known.iter().map(|known| &known.mesh)
    }

    /// Puts the lists among those of a scene.
    pub fn share(&self, buffers: &mut SceneBuffers) {
        buffers.mesh_nodes = self.nodes.clone();
        buffers.triangles = self.triangles.clone();
        buffers.triangle_materials = self.materials.clone();
        buffers.attributes = self.attributes.clone();
        buffers.meshes = self.infos.clone();
    }

    /// Gives up the hierarchies; nothing can be held anew afterwards.
    pub fn settle(&mut self) {
        self.nodes = Arc::default();
    }

    /// Part of the lists that was appended for the mesh at `place`.
    fn part(&self, place: usize) -> Part {
        let DeviceMesh { root, first_triangle, normals, tangents, uv0, uv1, colors, .. } = self.infos[place];
        let Known { bounds, first_word, .. } = self.known[place];
        let end =
            |of: fn(&DeviceMesh) -> u32, len: usize| self.infos.get(place + 1).map_or(len, |next| of(next) as usize);
        let nodes = root as usize..end(|mesh| mesh.root, self.nodes.len());
        let triangles = first_triangle as usize..end(|mesh| mesh.first_triangle, self.triangles.len());
        let last_word = self.known.get(place + 1).map_or(self.attributes.len(), |next| next.first_word as usize);
        let lists = [normals, tangents, uv0, uv1, colors];
        let [normals, tangents, uv0, uv1, colors] =
            lists.map(|list| if list == NONE { NONE } else { list - first_word });
        let info = DeviceMesh { root: 0, first_triangle: 0, normals, tangents, uv0, uv1, colors, ..self.infos[place] };
        let back = |node| moved(node, root.wrapping_neg(), first_triangle.wrapping_neg());
        Part {
            nodes: self.nodes[nodes].par_iter().map(back).collect(),
            triangles: self.triangles[triangles.clone()].to_vec(),
            materials: self.materials[triangles].to_vec(),
            attributes: self.attributes[first_word as usize..last_word].to_vec(),
            info,
            bounds,
        }
    }

    fn append(&mut self, mesh: Arc<Mesh>, mut part: Part) -> Result<(), TranslationError> {
        let place = |len: usize, more: usize, most: u32| match len + more <= most as usize {
            true => Ok(len as u32),
            false => Err(TranslationError::TooManyTriangles),
        };
        let root = place(self.nodes.len(), part.nodes.len(), MOST_IN_HIERARCHY)?;
        let first_triangle = place(self.triangles.len(), part.triangles.len(), MOST_IN_HIERARCHY)?;
        let attributes = place(self.attributes.len(), part.attributes.len(), u32::MAX)?;
        let behind = |list: u32| if list == NONE { NONE } else { attributes + list };
        let DeviceMesh { normals, tangents, uv0, uv1, colors, .. } = part.info;
        let [normals, tangents, uv0, uv1, colors] = [normals, tangents, uv0, uv1, colors].map(behind);
        let info = DeviceMesh { root, first_triangle, normals, tangents, uv0, uv1, colors, ..part.info };
        Arc::make_mut(&mut self.infos).push(info);

        part.nodes.par_iter_mut().for_each(|node| *node = moved(node, root, first_triangle));
        extend(&mut self.nodes, part.nodes);
        extend(&mut self.triangles, part.triangles);
        extend(&mut self.materials, part.materials);
        extend(&mut self.attributes, part.attributes);
        self.places.insert(address(&mesh), self.known.len());
        self.known.push(Known { mesh, bounds: part.bounds, first_word: attributes });
        Ok(())
    }
}

/// Bytes for each triangle while its mesh is built, measured: boxes, parts of the hierarchy and all of it, the triangles
/// of the device.
const BUILD_BYTES: u64 = 160;

fn check_memory(triangles: usize, free: Option<u64>) -> Result<(), TranslationError> {
    let needed = triangles as u64 * BUILD_BYTES;
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    match free {
        Some(free) if needed > free => {
            Err(TranslationError::TooMuchMemory { triangles, needed_gib: gib(needed), free_gib: gib(free) })
        }
        _ => Ok(()),
    }
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}

/// Appends `more` to `list`, without a copy where there was nothing before.
fn extend<T: Clone>(list: &mut Arc<Vec<T>>, mut more: Vec<T>) {
    match list.is_empty() {
        true => *list = Arc::new(more),
        false => Arc::make_mut(list).append(&mut more),
    }
}

/// A mesh alone, all places counted from 0.
struct Part {
    nodes: Vec<BvhNode>,
    triangles: Vec<Triangle>,
    materials: Vec<u32>,
    attributes: Vec<u32>,
    info: DeviceMesh,
    bounds: Bounds,
}

impl Part {
    fn build(mesh: &Mesh) -> Self {
        let corner = |index: u32| Vec3::from(mesh.positions[index as usize]);
        let boxes: Vec<Bounds> = mesh
            .triangles
            .par_iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(corner);
                Bounds(a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        let bounds = boxes.par_iter().copied().reduce(|| Bounds::EMPTY, Bounds::union);
        let Hierarchy { nodes, order, levels } = Hierarchy::build(&boxes);
        drop(boxes);

        let triangle = |&index: &u32| {
            let vertices = mesh.triangles[index as usize];
            let [a, b, c] = vertices.map(|vertex| corner(vertex).extend(f32::from_bits(vertex)).to_array());
            Triangle { a, b, c }
        };
        let mut named = vec![NONE; mesh.triangles.len()];
        for part in &mesh.parts {
            named[part.triangles.clone()].fill(part.material.map_or(NONE, |material| material as u32));
        }
        let materials: Vec<u32> = order.par_iter().map(|&index| named[index as usize]).collect();
        let (attributes, lists) = attributes(mesh);
        let info = DeviceMesh {
            triangles: order.len() as u32,
            materials: named.iter().filter(|m| **m != NONE).max().map_or(0, |largest| largest + 1),
            levels,
            ..lists
        };
        Self { nodes, triangles: order.par_iter().map(triangle).collect(), materials, attributes, info, bounds }
    }
}

/// The lists over vertices, packed, and where they begin.
fn attributes(mesh: &Mesh) -> (Vec<u32>, DeviceMesh) {
    let mut words = Vec::new();
    let mut list = |packed: Option<Vec<u32>>| {
        packed.map_or(NONE, |mut packed| {
            let first = words.len() as u32;
            words.append(&mut packed);
            first
        })
    };
    let unit = |v: &[f32; 3]| pack_unit_vector(Vec3::from(*v).normalize_or_zero());
    let uv = |uvs: &Vec<[f32; 2]>| uvs.iter().flatten().map(|x| x.to_bits()).collect();
    let lists = DeviceMesh {
        normals: list(mesh.normals.as_ref().map(|normals| normals.par_iter().map(unit).collect())),
        tangents: list(mesh.tangents.as_ref().map(|tangents| tangents.par_iter().map(pack_tangent).collect())),
        uv0: list(mesh.uvs[0].as_ref().map(uv)),
        uv1: list(mesh.uvs[1].as_ref().map(uv)),
        colors: list(mesh.colors.as_ref().map(|colors| colors.par_iter().flat_map_iter(pack_color).collect())),
        ..DeviceMesh::default()
    };
    (words, lists)
}

/// Code of no direction at all, which the octahedron does not know: its lower corners fold to the same pole, and one
/// stands for it.
const ZERO_VECTOR: u32 = 0xffff_ffff;

/// A unit vector in 16 + 16 bits: the octahedron, unfolded [cigolle2014unitvectors]; zero has a code of its own.
pub(crate) fn pack_unit_vector(v: Vec3) -> u32 {
    let sum = v.abs().element_sum();
    if sum == 0.0 {
        return ZERO_VECTOR;
    }
    let p = Vec2::new(v.x, v.y) / sum;
    let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
    let e = if v.z < 0.0 { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) } else { p };
    let quantize = |x: f32| ((x * 0.5 + 0.5) * 65535.0).round() as u32;
    let packed = quantize(e.x) | quantize(e.y) << 16;
    // The opposite corner is the same pole.
    if packed == ZERO_VECTOR { 0 } else { packed }
}

/// A unit vector with a bit less, and the sign of the bitangent in the lowest; zero stays zero.
fn pack_tangent(tangent: &[f32; 4]) -> u32 {
    let [x, y, z, sign] = *tangent;
    let vector = pack_unit_vector(Vec3::new(x, y, z).normalize_or_zero());
    if vector == ZERO_VECTOR {
        return ZERO_VECTOR;
    }
    let packed = vector & !1 | u32::from(sign < 0.0);
    // The opposite corner is the same pole.
    if packed == ZERO_VECTOR { 1 } else { packed }
}

/// Four components in 16 bits each, 65535 being 1.
fn pack_color(color: &[f32; 4]) -> [u32; 2] {
    let [r, g, b, a] = color.map(|c| (c.clamp(0.0, 1.0) * 65535.0).round() as u32);
    [r | g << 16, b | a << 16]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of triangles, with or without normals.
    fn fan(count: u32, normals: bool) -> Arc<Mesh> {
        let positions: Vec<_> = (0..count + 2).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
        let normals = normals.then(|| vec![[0.0, 0.0, 1.0]; positions.len()]);
        let triangles = (0..count).map(|i| [0, i + 1, i + 2]).collect();
        Arc::new(Mesh { positions, triangles, normals, ..Mesh::default() })
    }

    fn held(meshes: &Meshes) -> SceneBuffers {
        let mut buffers = SceneBuffers::default();
        meshes.share(&mut buffers);
        buffers
    }

    #[test]
    fn only_no_tangent_is_packed_as_none() {
        assert_eq!(pack_tangent(&[0.0; 4]), ZERO_VECTOR);
        assert_eq!(pack_tangent(&[0.0, 0.0, 0.0, -1.0]), ZERO_VECTOR);
        for x in [1e-5, -1e-5, 0.0] {
            assert!([1.0, -1.0].iter().all(|sign| pack_tangent(&[x, x, -1.0, *sign]) != ZERO_VECTOR), "{x}");
        }
    }

    #[test]
    fn what_is_left_of_meshes_is_as_if_built_alone() {
        let [a, b, c, d] = [fan(20, true), fan(7, false), fan(30, true), fan(5, true)];
        let mut meshes = Meshes::default();
        meshes.hold(&[a.clone(), b.clone(), c.clone(), d.clone()]).expect("they fit");
        meshes.hold(&[b.clone(), d.clone()]).expect("they fit");
        let mut alone = Meshes::default();
        alone.hold(&[b.clone(), d.clone()]).expect("they fit");
        assert_eq!(held(&meshes), held(&alone));
        assert_eq!([&a, &b, &c, &d].map(|mesh| meshes.place(mesh)), [None, Some(0), None, Some(1)]);
    }

    #[test]
    fn memory_is_told_before_it_is_taken() {
        let free = Some(3 << 30);
        assert_eq!(check_memory(20_000_000, free), Ok(()));
        let refused = check_memory(21_000_000, free).expect_err("more than there is").to_string();
        let told =
            "building the hierarchies of 21000000 triangles takes 3.1 GiB of memory, and this machine has 3.0 GiB free";
        assert_eq!(refused, told);
        assert_eq!(check_memory(usize::MAX / 256, None), Ok(()));
    }
}
