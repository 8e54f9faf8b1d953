//! Generated twins of the kernels' structures; their sizes and offsets are asserted as they are compiled.

use std::ops::Range;
use std::sync::Arc;

/// Bytes of one buffer of [`SceneBuffers`].
#[derive(Clone, Copy, Debug)]
pub struct BufferBytes<'a> {
    /// Name of the buffer in `kernels/scene.slang`.
    pub name: &'static str,
    /// Elements of the buffer, `count` times `stride` bytes.
    pub bytes: &'a [u8],
    /// Number of elements.
    pub count: usize,
    /// Bytes of one element.
    pub stride: usize,
}

impl BufferBytes<'_> {
    /// Whether both are one list; lists that are shared do not change.
    pub fn same(&self, other: &BufferBytes<'_>) -> bool {
        std::ptr::eq(self.bytes, other.bytes)
    }
}

/// Names of the lists over meshes, as [`BufferBytes::name`] gives them.
const MESH_BUFFERS: [&str; 5] = ["mesh_nodes", "triangles", "triangle_materials", "meshes", "attributes"];
/// Names of the lists in which one view of a scene differs from another; `check_counts` and
/// `check_motion` look at all that can be wrong there but the sky.
const VIEW_BUFFERS: [&str; 4] = ["constants", "filter_table", "motion", "motion_rows"];

pub use generated::*;

// The meaning of members is said once, in the Slang files.
#[allow(missing_docs)]
mod generated {
    use std::sync::Arc;

    use super::BufferBytes;

    include!(concat!(env!("OUT_DIR"), "/layout.rs"));
}

/// Reason why a [`SceneBuffers`] cannot be handed to a device: an index in it points past what it refers to.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("broken device scene: {0}")]
pub struct BrokenScene(String);

impl TexelFormat {
    /// Number of words of `SceneBuffers::texels` that a texel takes.
    pub fn words(self) -> u32 {
        match self {
            Self::Rgba8 | Self::Rgba8Srgb => 1,
            Self::Rgba16 | Self::Rgba16Srgb => 2,
            Self::Rgb32F => 3,
        }
    }
}

impl BvhChild {
    /// Makes a child of the box between two corners, and what is in it: `count` leaves from place `first` on, or node
    /// `first` if `count` is 0. `first` is below 2^30 and `count` below 4.
    pub fn new([lower, upper]: [[f32; 3]; 2], first: u32, count: u32) -> Self {
        let group = f32::from_bits(first | count << GROUP_SHIFT);
        let [x, y, z]: [f32; 3] = std::array::from_fn(|i| 0.5 * lower[i] + 0.5 * upper[i]);
        let half = |i: usize, center: f32| {
            let center = f64::from(center);
            at_least((f64::from(upper[i]) - center).max(center - f64::from(lower[i])))
        };
        Self { center: [x, y, z, group], half_size: [half(0, x), half(1, y), half(2, z), 0.0] }
    }

    /// Lower and upper corner of the child's box; that which it was made of lies within.
    pub fn corners(&self) -> [[f32; 3]; 2] {
        let corner = |sign: f64| {
            std::array::from_fn(|i| {
                let place = f64::from(self.center[i]) + sign * f64::from(self.half_size[i]);
                (sign * f64::from(at_least(sign * place))) as f32
            })
        };
        [corner(-1.0), corner(1.0)]
    }

    /// Place of the node in the child, or of the first of its leaves.
    pub fn first(&self) -> u32 {
        self.center[3].to_bits() & (MOST_IN_HIERARCHY - 1)
    }

    /// Number of the child's leaves; 0: a node is in it.
    pub fn count(&self) -> u32 {
        self.center[3].to_bits() >> GROUP_SHIFT
    }
}

/// The least float that is not below `x`.
fn at_least(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// Most nodes, or leaves, that all hierarchies of a level may have together.
pub const MOST_IN_HIERARCHY: u32 = 1 << GROUP_SHIFT;

impl SceneBuffers {
    /// Whether there are no principled materials, no lights that are no surfaces and no media: kernels that know of none are faster.
    pub fn is_simple(&self) -> bool {
        let absorbs = self.constants.first().is_some_and(|constants| constants.counts.absorbing != 0);
        self.principled.is_empty() && self.lights.is_empty() && !absorbs && !self.has_media()
    }

    /// Whether media scatter light or bodies have no surface: kernels that know of neither are faster.
    pub fn has_media(&self) -> bool {
        let has = |constants: &Constants| constants.counts.scattering != 0 || constants.counts.seamless != 0;
        self.constants.first().is_some_and(has)
    }

    /// Has every ray try all shapes one by one, if they are `few` at most and no meshes; false if it does not.
    pub fn try_all(&mut self, few: usize) -> bool {
        let is_instance = |shape: &ShapeReference| shape.kind == ShapeKind::Instance as u32;
        let tries_all = self.order.len() <= few && !self.order.iter().any(is_instance);
        if tries_all {
            self.constants_mut().counts.tried = self.order.len() as u32;
        }
        tries_all
    }

    /// What the scene has one of.
    ///
    /// # Panics
    /// If it is not there yet.
    pub fn constants(&self) -> &Constants {
        &self.constants[0]
    }

    /// The same, to be changed; it comes to be if it is not there yet.
    pub fn constants_mut(&mut self) -> &mut Constants {
        let constants = Arc::make_mut(&mut self.constants);
        if constants.is_empty() {
            constants.push(Constants::default());
        }
        &mut constants[0]
    }

    /// Whether this is another view of `scene` at most.
    pub fn is_view_of(&self, scene: &Self) -> bool {
        self.changes_from(scene).iter().all(|name| VIEW_BUFFERS.contains(name))
    }

    /// Names of the lists that are not those of `scene`.
    fn changes_from(&self, scene: &Self) -> Vec<&'static str> {
        self.bytes().iter().zip(scene.bytes()).filter(|(a, b)| !a.same(b)).map(|(a, _)| a.name).collect()
    }

    /// Checks every index that a kernel follows, so that none can read outside its buffer.
    pub fn check(&self) -> Result<(), BrokenScene> {
        self.check_after(&Self::default())
    }

    /// Checks like [`check`](Self::check), knowing that `checked` has been found right: what they share is not looked
    /// at again, so that another view of a large scene is checked at once.
    pub fn check_after(&self, checked: &Self) -> Result<(), BrokenScene> {
        self.check_counts()?;
        let changed = self.changes_from(checked);
        if changed.iter().any(|name| MESH_BUFFERS.contains(name)) {
            self.check_meshes()?;
        }
        let (now, before) = (self.constants(), checked.constants.first());
        let same_places = before.is_some_and(|before| before.counts.unbounded == now.counts.unbounded);
        let same_sky = before.is_some_and(|before| before.sky == now.sky);
        if same_places && same_sky && changed.iter().all(|name| VIEW_BUFFERS.contains(name)) {
            return self.check_motion();
        }
        self.check_textures()?;
        self.check_shapes()?;
        self.check_lights()?;
        self.check_levels()?;
        self.check_motion()
    }

    /// Checks that each shape of a scene that moves has its motion, and each vertex its place before.
    fn check_motion(&self) -> Result<(), BrokenScene> {
        let [motion] = &self.motion[..] else { return fail("`motion` must have one element") };
        if motion.moves == 0 {
            return Ok(());
        }
        let (rows, shape_rows) = (self.motion_rows.as_slice(), MOTION_ROWS as usize);
        if rows.len() < shape_rows * self.order.len() {
            return fail("`motion_rows` disagrees with `order`");
        }
        let is_known = |(shape, rows_of_shape): (&ShapeReference, &[[f32; 4]])| {
            let first = rows_of_shape[shape_rows - 1][0].to_bits();
            let is_mesh = shape.kind == ShapeKind::Instance as u32;
            let largest = || self.largest_vertex(shape.index).filter(|_| is_mesh);
            first == NONE || largest().is_some_and(|largest| u64::from(first) + u64::from(largest) < rows.len() as u64)
        };
        match self.order.iter().zip(rows.chunks_exact(shape_rows)).all(is_known) {
            true => Ok(()),
            false => fail("a vertex has no place before"),
        }
    }

    /// Largest number of a vertex of an instance's mesh.
    fn largest_vertex(&self, instance: u32) -> Option<u32> {
        let mesh = self.meshes.get(self.instances.get(instance as usize)?.mesh as usize)?;
        let first = mesh.first_triangle as usize;
        let corners = |triangle: &Triangle| [triangle.a[3], triangle.b[3], triangle.c[3]].map(f32::to_bits);
        self.triangles.get(first..first + mesh.triangles as usize)?.iter().flat_map(corners).max()
    }

    fn check_levels(&self) -> Result<(), BrokenScene> {
        let leaves = self.constants().counts.unbounded as usize..self.order.len();
        let levels = levels(&self.nodes, 0..self.nodes.len(), leaves)?;
        let below = self.meshes.iter().map(|mesh| mesh.levels).max().unwrap_or(0);
        // One child waits on each level, and a mark stands below those of each hierarchy.
        if levels + below + 2 > BVH_STACK {
            return fail("the hierarchies are deeper than the kernels' stack");
        }
        Ok(())
    }

    fn check_counts(&self) -> Result<(), BrokenScene> {
        let [Constants { counts, camera_media, .. }] = self.constants[..] else {
            return fail("`constants` must have one element");
        };
        if counts.shapes as usize != self.order.len() || counts.nodes as usize != self.nodes.len() {
            return fail("`counts` disagrees with the buffers");
        }
        if ![0, FILTER_CELLS as usize + 1].contains(&self.filter_table.len()) {
            return fail("the filter's table has another number of cells");
        }
        if counts.unbounded as usize > self.order.len() {
            return fail("more unbounded shapes than shapes");
        }
        let all_but_instances = || self.order.iter().all(|shape| shape.kind != ShapeKind::Instance as u32);
        if counts.tried != counts.unbounded && (counts.tried != counts.shapes || !all_but_instances()) {
            return fail("shapes are tried one by one that cannot be");
        }
        if counts.nodes == 0 && counts.tried < counts.shapes {
            return fail("shapes are neither tried one by one nor in the hierarchy");
        }
        let Some(around) = camera_media.get(..counts.camera_media as usize) else {
            return fail("more media around the camera than a path can remember");
        };
        if self.albedos.len() != ALBEDO_NODES as usize {
            return fail("the tables of albedos have another size");
        }
        let is_shape = |medium: &CameraMedium| (medium.shape as usize) < self.order.len();
        if !around.iter().all(|medium| is_shape(medium) || medium.shape == SHEETS | medium.material) {
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
        let counts = self.constants().counts;
        if !self.materials.iter().all(known)
            || u64::from(counts.lights) + u64::from(counts.suns) != self.lights.len() as u64
        {
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

    /// Checks that every image is inside `texels`, and that the sky's texture is there.
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
        let textures = self.principled.iter().flat_map(|material| material.textures);
        if textures.filter(|texture| *texture != NO_TEXTURE).any(|texture| texture as usize >= self.textures.len()) {
            return fail("a material has a texture that is not there");
        }
        let image = self.constants().sky.image;
        if image != NO_TEXTURE && image as usize >= self.textures.len() {
            return fail("the sky's image is not among the textures");
        }
        Ok(())
    }

    /// Checks that every emitter is what it says and has a leaf of the tree, and that from each node a way leads to the
    /// root.
    fn check_lights(&self) -> Result<(), BrokenScene> {
        let counts = self.constants().counts;
        let (emitters, nodes) = (self.emitters.len(), self.light_nodes.len());
        if counts.emitters as usize != emitters || (2 * emitters).saturating_sub(1) != nodes {
            return fail("`counts` disagrees with the lights");
        }
        let is_leaf = |node: &LightNode| node.flags & LIGHT_LEAF != 0;
        for (place, node) in self.light_nodes.iter().enumerate() {
            let known = match is_leaf(node) {
                true => self.emitters.get(node.child as usize).is_some_and(|emitter| emitter.leaf as usize == place),
                false => {
                    let child = |child: usize| self.light_nodes.get(child).map(|child| child.parent as usize);
                    let first = node.child as usize;
                    first > place && first % 2 == 1 && [first, first + 1].map(child) == [Some(place); 2]
                }
            };
            if !known || node.parent as usize > place.saturating_sub(1) {
                return fail("the light tree is broken");
            }
        }
        if !self.emitters.iter().all(|emitter| self.knows(emitter)) {
            return fail("an emitter is not there");
        }
        let listed = |shape: &ShapeReference| {
            let faces = if shape.kind == ShapeKind::Box as u32 { 6 } else { 1 };
            let end = u64::from(shape.first_emitter) + u64::from(shape.emitters);
            shape.emitters == 0 || shape.emitters >= faces && end <= emitters as u64
        };
        let sky = counts.sky_emitter;
        let is_sky = |emitter: &Emitter| emitter.kind == EmitterKind::Sky as u32;
        let sky_listed = sky == NONE || self.emitters.get(sky as usize).is_some_and(is_sky);
        let is_sun = |place: u64, number: u64| {
            let emitter = self.emitters.get(place as usize);
            let is_its = |emitter: &Emitter| u64::from(emitter.shape) == u64::from(counts.lights) + number;
            emitter.is_some_and(|emitter| emitter.kind == EmitterKind::Sun as u32 && is_its(emitter))
        };
        let first_sun = u64::from(counts.first_sun_emitter);
        if !(0..u64::from(counts.suns)).all(|number| is_sun(first_sun + number, number)) {
            return fail("a sun has no emitter");
        }
        if !self.order.iter().all(listed) || !sky_listed {
            return fail("a shape has emitters that are not there");
        }
        Ok(())
    }

    fn knows(&self, emitter: &Emitter) -> bool {
        let leaf = self.light_nodes.get(emitter.leaf as usize).is_some_and(|leaf| leaf.flags & LIGHT_LEAF != 0);
        let shape = self.order.get(emitter.shape as usize);
        let is = |kind: ShapeKind| shape.is_some_and(|shape| shape.kind == kind as u32);
        let Some(kind) = EmitterKind::ALL.into_iter().find(|kind| *kind as u32 == emitter.kind) else { return false };
        leaf && match kind {
            EmitterKind::Sphere => is(ShapeKind::Sphere),
            EmitterKind::Rectangle => is(ShapeKind::Rectangle),
            EmitterKind::BoxFace => is(ShapeKind::Box) && emitter.part < 6,
            EmitterKind::Round => is(ShapeKind::Round) && emitter.part <= ROUND_TOP,
            EmitterKind::Triangle => is(ShapeKind::Instance) && (emitter.part as usize) < self.triangles.len(),
            EmitterKind::Light | EmitterKind::Sun => (emitter.shape as usize) < self.lights.len(),
            EmitterKind::Sky => self.has_sky_sums(),
        }
    }

    /// Whether the sky's image has its pyramid of sums.
    fn has_sky_sums(&self) -> bool {
        let Some(image) = self.textures.get(self.constants().sky.image as usize) else { return false };
        let (mut across, mut down, mut blocks) = (image.width, image.height, 0);
        while blocks == 0 || across > 1 || down > 1 {
            (across, down) = (across.div_ceil(2), down.div_ceil(2));
            blocks += across as usize * down as usize;
        }
        self.sky_sums.len() == blocks
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

/// Index of nothing: `Mesh.NONE` of the kernels.
pub const NONE: u32 = u32::MAX;

/// Bit of a [`CameraMedium::shape`] that stands for all that is of one material: `Body.SHEETS` of the kernels.
pub const SHEETS: u32 = 1 << 31;

/// Number of levels of the hierarchy in `range` of `nodes`, whose leaves must be in `leaves`: each node but the first
/// has one parent, which stands before it.
fn levels(nodes: &[BvhNode], range: Range<usize>, leaves: Range<usize>) -> Result<u32, BrokenScene> {
    let mut level = vec![0u32; range.len()];
    level.iter_mut().take(1).for_each(|root| *root = 1);
    for place in range.clone() {
        let own = level[place - range.start];
        if own == 0 {
            return fail("a node of a hierarchy has no parent before it");
        }
        for child in [&nodes[place].left, &nodes[place].right] {
            let (first, count) = (child.first() as usize, child.count() as usize);
            if count > 0 {
                if first < leaves.start || first + count > leaves.end {
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

    /// Scene of one sphere below a hierarchy of these nodes, their children given as `first` and `count`.
    fn with_nodes(nodes: &[[(u32, u32); 2]]) -> SceneBuffers {
        let child = |(first, count): (u32, u32)| BvhChild::new([[0.0; 3]; 2], first, count);
        let node = |&[left, right]: &[(u32, u32); 2]| BvhNode { left: child(left), right: child(right) };
        SceneBuffers {
            constants: vec![Constants {
                sky: Sky { image: NO_TEXTURE, ..Sky::default() },
                counts: SceneCounts {
                    shapes: 1,
                    nodes: nodes.len() as u32,
                    sky_emitter: NONE,
                    ..SceneCounts::default()
                },
                ..Constants::default()
            }]
            .into(),
            spheres: vec![Sphere::default()].into(),
            order: vec![ShapeReference { kind: ShapeKind::Sphere as u32, ..ShapeReference::default() }].into(),
            materials: vec![Material { principled: NONE, ..Material::default() }].into(),
            nodes: Arc::new(nodes.iter().map(node).collect()),
            albedos: vec![[0; 2]; ALBEDO_NODES as usize].into(),
            motion: vec![Motion::default()].into(),
            ..SceneBuffers::default()
        }
    }

    /// Scene of one sphere below the image `image`.
    fn with_sky(image: u32) -> SceneBuffers {
        let mut scene = with_nodes(&[LEAF]);
        scene.constants_mut().sky.image = image;
        scene
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
        let with = |constants: Constants| SceneBuffers { constants: vec![constants].into(), ..tree() };
        let constants = *tree().constants();
        assert_eq!(with(constants).check(), Ok(()));
        let (mut around, counts) = (constants.camera_media, constants.counts);
        around[0].shape = 1;
        let inside = |camera_media| SceneCounts { camera_media, ..counts };
        refused(with(Constants { camera_media: around, counts: inside(1), ..constants }));
        refused(with(Constants { counts: inside(MAX_NESTED_MEDIA + 1), ..constants }));
        refused(SceneBuffers { constants: vec![].into(), ..tree() });
        refused(SceneBuffers { albedos: vec![].into(), ..tree() });
        let instance = Instance { first_material: NONE, ..Instance::default() };
        refused(SceneBuffers { instances: vec![instance].into(), ..tree() });
        let material = Material { principled: 0, ..Material::default() };
        refused(SceneBuffers { materials: vec![material].into(), ..tree() });
        let mesh = Mesh { triangles: 1, normals: NONE, ..Mesh::default() };
        refused(SceneBuffers { meshes: vec![mesh].into(), ..tree() });
        let moving: Arc<Vec<Motion>> = vec![Motion { moves: 1, ..Motion::default() }].into();
        let rows = |first: u32| vec![[0.0; 4], [0.0; 4], [0.0; 4], [f32::from_bits(first), 0.0, 0.0, 0.0]];
        let moved = |first| SceneBuffers { motion: moving.clone(), motion_rows: rows(first).into(), ..tree() };
        assert_eq!(moved(NONE).check(), Ok(()));
        refused(SceneBuffers { motion: vec![].into(), ..tree() });
        refused(SceneBuffers { motion: moving.clone(), ..tree() });
        refused(moved(0));
    }

    #[test]
    fn images_stay_inside_the_texels() {
        let texture =
            Texture { first_word: 3, width: 5, height: 2, format: TexelFormat::Rgba16 as u32, ..Texture::default() };
        let with = |texture: Texture, texels: usize| SceneBuffers {
            textures: vec![texture].into(),
            texels: vec![0; texels].into(),
            ..with_sky(0)
        };
        assert_eq!(with(texture, 23).check(), Ok(()));

        let refused = |buffers: SceneBuffers| assert!(buffers.check().is_err(), "{buffers:?}");
        refused(with(texture, 22));
        refused(with(Texture { width: 0, ..texture }, 23));
        refused(with(Texture { height: 0, ..texture }, 23));
        refused(with(Texture { format: 99, ..texture }, 23));
        refused(with(Texture { first_word: u32::MAX, ..texture }, 23));
        refused(with(Texture { width: u32::MAX, height: u32::MAX, ..texture }, 23));
        refused(SceneBuffers { constants: with_sky(1).constants, ..with(texture, 23) });
    }
}
