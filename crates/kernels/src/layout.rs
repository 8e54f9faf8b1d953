//! Generated twins of the kernels' structures; their sizes and offsets are asserted as they are compiled.

use std::ops::Range;
use std::sync::Arc;

/// One buffer of [`SceneBuffers`], as bytes.
#[derive(Clone, Copy, Debug)]
pub struct BufferBytes<'a> {
    /// As in `kernels/scene.slang`.
    pub name: &'static str,
    /// Its elements, `count` times `stride` bytes.
    pub bytes: &'a [u8],
    /// Number of elements.
    pub count: usize,
    /// Bytes of one element.
    pub stride: usize,
}

pub use generated::*;

// What they mean is said once, in the Slang files.
#[allow(missing_docs)]
mod generated {
    use std::sync::Arc;

    use super::BufferBytes;

    include!(concat!(env!("OUT_DIR"), "/layout.rs"));
}

/// Why a [`SceneBuffers`] cannot be handed to a device: an index in it points past what it refers to.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("broken device scene: {0}")]
pub struct BrokenScene(String);

impl TexelFormat {
    /// How many words of `SceneBuffers::texels` a texel takes.
    pub fn words(self) -> u32 {
        match self {
            Self::Rgba8 | Self::Rgba8Srgb => 1,
            Self::Rgba16 | Self::Rgba16Srgb => 2,
            Self::Rgb32F => 3,
        }
    }
}

impl SceneBuffers {
    /// Checks every index that a kernel follows, so that none can read outside its buffer.
    pub fn check(&self) -> Result<(), BrokenScene> {
        self.check_after(&Self::default())
    }

    /// The same, knowing that `checked` has been found right: what they share is not looked at again.
    pub fn check_after(&self, checked: &Self) -> Result<(), BrokenScene> {
        self.check_counts()?;
        let meshes = |scene: &Self| {
            let Self { mesh_nodes, triangles, triangle_materials, meshes, attributes, .. } = scene.clone();
            (mesh_nodes, triangles, triangle_materials, meshes, attributes)
        };
        let ((nodes, triangles, materials, infos, attributes), old) = (meshes(self), meshes(checked));
        let same = Arc::ptr_eq(&nodes, &old.0)
            && Arc::ptr_eq(&triangles, &old.1)
            && Arc::ptr_eq(&materials, &old.2)
            && Arc::ptr_eq(&infos, &old.3)
            && Arc::ptr_eq(&attributes, &old.4);
        if !same {
            self.check_meshes()?;
        }
        self.check_textures()?;
        self.check_shapes()?;
        let leaves = self.counts[0].unbounded as usize..self.order.len();
        let levels = levels(&self.nodes, 0..self.nodes.len(), leaves)?;
        let below = self.meshes.iter().map(|mesh| mesh.levels).max().unwrap_or(0);
        // On each level one child waits, and the rest of a leaf when a mesh is entered.
        if levels + below + 1 > BVH_STACK {
            return fail("the hierarchies are deeper than the kernels' stack");
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), BrokenScene> {
        let [counts] = self.counts[..] else { return fail("`counts` must have one element") };
        if self.camera.len() != 1 || self.sky.len() != 1 {
            return fail("`camera` and `sky` must have one element");
        }
        if counts.shapes as usize != self.order.len()
            || counts.nodes as usize != self.nodes.len()
            || counts.camera_media as usize != self.camera_media.len()
        {
            return fail("`counts` disagrees with the buffers");
        }
        if counts.unbounded as usize > self.order.len() {
            return fail("more unbounded shapes than shapes");
        }
        if self.camera_media.len() > MAX_NESTED_MEDIA as usize {
            return fail("more media around the camera than a path can remember");
        }
        if self.albedos.len() != ALBEDO_NODES as usize {
            return fail("the tables of albedos have another size");
        }
        if self.camera_media.iter().any(|medium| medium.shape as usize >= self.order.len()) {
            return fail("a medium around the camera is no shape");
        }
        Ok(())
    }

    fn check_shapes(&self) -> Result<(), BrokenScene> {
        if self.largest_material().is_some_and(|material| material as usize >= self.materials.len()) {
            return fail("a material index is too large");
        }
        let known =
            |material: &Material| material.principled == NONE || (material.principled as usize) < self.principled.len();
        if !self.materials.iter().all(known) || self.counts[0].lights as usize != self.lights.len() {
            return fail("a material or a light is not there");
        }
        if !self.order.iter().all(|shape| (shape.index as usize) < self.shapes_of_kind(shape.kind)) {
            return fail("a shape index is too large");
        }
        let fits = |instance: &Instance| {
            let mesh = self.meshes.get(instance.mesh as usize);
            let end = |mesh: &Mesh| u64::from(instance.first_material) + u64::from(mesh.materials);
            mesh.is_some_and(|mesh| instance.first_material == NONE || end(mesh) <= self.materials.len() as u64)
        };
        if !self.instances.iter().all(fits) {
            return fail("an instance is of no mesh, or of no material");
        }
        Ok(())
    }

    /// Every image is inside `texels`, and the sky's texture is there.
    fn check_textures(&self) -> Result<(), BrokenScene> {
        let size = 1..=MAX_TEXTURE_SIDE;
        for texture in self.textures.iter() {
            let Some(format) = TexelFormat::ALL.into_iter().find(|format| *format as u32 == texture.format) else {
                return fail("a texture has an unknown format");
            };
            if !size.contains(&texture.width) || !size.contains(&texture.height) {
                return fail("a texture is empty or too wide or high");
            }
            let words = u64::from(texture.width) * u64::from(texture.height) * u64::from(format.words());
            if u64::from(texture.first_word) + words > self.texels.len() as u64 {
                return fail("a texture reaches past the texels");
            }
        }
        let textures = self.principled.iter().flat_map(principled_textures);
        if textures.filter(|texture| *texture != NO_TEXTURE).any(|texture| texture as usize >= self.textures.len()) {
            return fail("a material has a texture that is not there");
        }
        if self.sky.iter().any(|sky| sky.image != NO_TEXTURE && sky.image as usize >= self.textures.len()) {
            return fail("the sky's image is not among the textures");
        }
        Ok(())
    }

    fn check_meshes(&self) -> Result<(), BrokenScene> {
        if self.triangle_materials.len() != self.triangles.len() {
            return fail("`triangle_materials` disagrees with `triangles`");
        }
        let (mut first_node, mut first_triangle) = (0, 0);
        for (i, mesh) in self.meshes.iter().enumerate() {
            // Nodes and triangles of a mesh stand together, and those of the next behind them.
            let next = self.meshes.get(i + 1).map_or(self.mesh_nodes.len(), |next| next.root as usize);
            if next < mesh.root as usize || next > self.mesh_nodes.len() {
                return fail("the meshes are out of order");
            }
            let nodes = mesh.root as usize..next;
            let triangles = mesh.first_triangle as usize..mesh.first_triangle as usize + mesh.triangles as usize;
            if nodes.start != first_node || triangles.start != first_triangle || triangles.end > self.triangles.len() {
                return fail("a mesh is not where the one before it ends");
            }
            (first_node, first_triangle) = (nodes.end, triangles.end);
            if levels(&self.mesh_nodes, nodes, triangles.clone())? > mesh.levels {
                return fail("a mesh has more levels than it says");
            }
            self.check_vertices(mesh, triangles)?;
        }
        Ok(())
    }

    fn check_vertices(&self, mesh: &Mesh, triangles: Range<usize>) -> Result<(), BrokenScene> {
        let named = |material: &u32| *material == NONE || *material < mesh.materials;
        if !self.triangle_materials[triangles.clone()].iter().all(named) {
            return fail("a triangle names a material that its mesh does not have");
        }
        let corner = |corner: &[f32; 4]| corner[3].to_bits();
        let largest = self.triangles[triangles].iter().map(|t| corner(&t.a).max(corner(&t.b)).max(corner(&t.c))).max();
        let Some(largest) = largest else { return Ok(()) };
        let lists = [(mesh.normals, 1), (mesh.tangents, 1), (mesh.uv0, 2), (mesh.uv1, 2), (mesh.colors, 2)];
        let inside = |(first, words): (u32, u64)| {
            first == NONE || u64::from(first) + words * (u64::from(largest) + 1) <= self.attributes.len() as u64
        };
        if !lists.into_iter().all(inside) {
            return fail("a list over vertices is too short");
        }
        Ok(())
    }
}

fn principled_textures(p: &Principled) -> [u32; 17] {
    [
        p.base_color_texture,
        p.metallic_roughness_texture,
        p.normal_texture,
        p.emissive_texture,
        p.specular_texture,
        p.specular_color_texture,
        p.transmission_texture,
        p.diffuse_transmission_texture,
        p.diffuse_transmission_color_texture,
        p.clearcoat_texture,
        p.clearcoat_roughness_texture,
        p.clearcoat_normal_texture,
        p.sheen_color_texture,
        p.sheen_roughness_texture,
        p.anisotropy_texture,
        p.iridescence_texture,
        p.iridescence_thickness_texture,
    ]
}

/// No index: `Mesh.NONE` of the kernels.
pub const NONE: u32 = u32::MAX;

/// Levels of the hierarchy in `range` of `nodes`, whose leaves must be in `leaves`: each node but the first has one
/// parent, which stands before it.
fn levels(nodes: &[BvhNode], range: Range<usize>, leaves: Range<usize>) -> Result<u32, BrokenScene> {
    let mut level = vec![0u32; range.len()];
    level.iter_mut().take(1).for_each(|root| *root = 1);
    for place in range.clone() {
        let own = level[place - range.start];
        if own == 0 {
            return fail("a node of a hierarchy has no parent before it");
        }
        for child in [&nodes[place].left, &nodes[place].right] {
            let first = child.first as usize;
            if child.count > 0 {
                if first < leaves.start || first + child.count as usize > leaves.end {
                    return fail("a leaf of a hierarchy is not there");
                }
                continue;
            }
            let Some(level) = first.checked_sub(range.start).and_then(|child| level.get_mut(child)) else {
                return fail("a node of a hierarchy has a child that is not there");
            };
            if first <= place || *level != 0 {
                return fail("a node of a hierarchy stands before its parent, or has two");
            }
            *level = own + 1;
        }
    }
    Ok(level.into_iter().max().unwrap_or(0))
}

fn fail<T>(what: &str) -> Result<T, BrokenScene> {
    Err(BrokenScene(what.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sphere below a hierarchy of these nodes, their children given as `first` and `count`.
    fn with_nodes(nodes: &[[(u32, u32); 2]]) -> SceneBuffers {
        let child = |(first, count): (u32, u32)| BvhChild { first, count, ..BvhChild::default() };
        let node = |&[left, right]: &[(u32, u32); 2]| BvhNode { left: child(left), right: child(right) };
        SceneBuffers {
            camera: vec![Camera::default()].into(),
            sky: vec![Sky { image: NO_TEXTURE, ..Sky::default() }].into(),
            spheres: vec![Sphere::default()].into(),
            order: vec![ShapeReference { kind: ShapeKind::Sphere as u32, ..ShapeReference::default() }].into(),
            materials: vec![Material { principled: NONE, ..Material::default() }].into(),
            nodes: Arc::new(nodes.iter().map(node).collect()),
            albedos: vec![[0; 2]; ALBEDO_NODES as usize].into(),
            counts: vec![SceneCounts { shapes: 1, nodes: nodes.len() as u32, ..SceneCounts::default() }].into(),
            ..SceneBuffers::default()
        }
    }

    const LEAF: [(u32, u32); 2] = [(0, 1), (0, 1)];

    #[test]
    fn a_tree_passes() {
        assert_eq!(with_nodes(&[LEAF]).check(), Ok(()));
        assert_eq!(with_nodes(&[[(1, 0), (0, 1)], LEAF]).check(), Ok(()));
    }

    #[test]
    fn indices_that_point_nowhere_are_refused() {
        let refused = |buffers: SceneBuffers| assert!(buffers.check().is_err(), "{buffers:?}");
        // A leaf past the shapes, a missing child, a child before its parent, a shared child, a node without a parent.
        refused(with_nodes(&[[(0, 2), (0, 1)]]));
        refused(with_nodes(&[[(1, 0), (0, 1)]]));
        refused(with_nodes(&[[(0, 0), (0, 1)]]));
        refused(with_nodes(&[[(1, 0), (1, 0)], LEAF]));
        refused(with_nodes(&[LEAF, LEAF]));
        let deep: Vec<_> = (1..=BVH_STACK).map(|next| [(next, 0), (0, 1)]).collect();
        refused(with_nodes(&[&deep[..], &[LEAF]].concat()));

        let tree = || with_nodes(&[LEAF]);
        refused(SceneBuffers { materials: vec![].into(), ..tree() });
        refused(SceneBuffers { spheres: vec![].into(), ..tree() });
        refused(SceneBuffers {
            order: vec![ShapeReference { kind: 99, ..ShapeReference::default() }].into(),
            ..tree()
        });
        refused(SceneBuffers { camera_media: vec![CameraMedium { shape: 1, material: 0 }].into(), ..tree() });
        refused(SceneBuffers { sky: vec![].into(), ..tree() });
        refused(SceneBuffers { albedos: vec![].into(), ..tree() });
        let instance = Instance { first_material: NONE, ..Instance::default() };
        refused(SceneBuffers { instances: vec![instance].into(), ..tree() });
        let material = Material { principled: 0, ..Material::default() };
        refused(SceneBuffers { materials: vec![material].into(), ..tree() });
        let mesh = Mesh { triangles: 1, normals: NONE, ..Mesh::default() };
        refused(SceneBuffers { meshes: vec![mesh].into(), ..tree() });
    }

    #[test]
    fn images_stay_inside_the_texels() {
        let texture =
            Texture { first_word: 3, width: 5, height: 2, format: TexelFormat::Rgba16 as u32, ..Texture::default() };
        let with = |texture: Texture, texels: usize| SceneBuffers {
            textures: vec![texture].into(),
            texels: vec![0; texels].into(),
            sky: vec![Sky { image: 0, ..Sky::default() }].into(),
            ..with_nodes(&[LEAF])
        };
        assert_eq!(with(texture, 23).check(), Ok(()));

        let refused = |buffers: SceneBuffers| assert!(buffers.check().is_err(), "{buffers:?}");
        refused(with(texture, 22));
        refused(with(Texture { width: 0, ..texture }, 23));
        refused(with(Texture { height: 0, ..texture }, 23));
        refused(with(Texture { format: 99, ..texture }, 23));
        refused(with(Texture { first_word: u32::MAX, ..texture }, 23));
        refused(with(Texture { width: u32::MAX, height: u32::MAX, ..texture }, 23));
        refused(SceneBuffers { sky: vec![Sky { image: 1, ..Sky::default() }].into(), ..with(texture, 23) });
    }
}
