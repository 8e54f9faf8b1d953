//! Generated twins of the kernels' structures; their sizes and offsets are asserted as they are compiled.

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
    use super::BufferBytes;

    include!(concat!(env!("OUT_DIR"), "/layout.rs"));
}

/// Why a [`SceneBuffers`] cannot be handed to a device: an index in it points past what it refers to.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("broken device scene: {0}")]
pub struct BrokenScene(String);

impl BrokenScene {
    pub(crate) fn new(what: &str) -> Self {
        Self(what.to_owned())
    }
}

/// The buffers that depend on the camera; all others are the same from wherever the scene is seen.
pub const VIEW_BUFFERS: [&str; 3] = ["camera", "camera_media", "counts"];

impl SceneBuffers {
    /// Checks what [`VIEW_BUFFERS`] names, when the rest has been checked before.
    pub fn check_view(&self) -> Result<(), BrokenScene> {
        let fail = |what: &str| Err(BrokenScene::new(what));
        let [counts] = self.counts[..] else { return fail("`counts` must have one element") };
        if self.camera.len() != 1 {
            return fail("`camera` must have one element");
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
        let known = |medium: &CameraMedium| {
            (medium.shape as usize) < self.order.len() && (medium.material as usize) < self.materials.len()
        };
        if !self.camera_media.iter().all(known) {
            return fail("a medium around the camera is no shape, or of no material");
        }
        Ok(())
    }

    /// Checks every index that a kernel follows, so that none can read outside its buffer.
    pub fn check(&self) -> Result<(), BrokenScene> {
        self.check_view()?;
        let fail = |what: &str| Err(BrokenScene::new(what));
        if self.sky.len() != 1 {
            return fail("`sky` must have one element");
        }
        if self.largest_material().is_some_and(|material| material as usize >= self.materials.len()) {
            return fail("a material index is too large");
        }
        if !self.order.iter().all(|shape| (shape.index as usize) < self.shapes_of_kind(shape.kind)) {
            return fail("a shape index is too large");
        }
        self.check_hierarchy()
    }

    /// Children have one parent and come after it, leaves stay inside `order`, and no branch is deeper than the kernels'
    /// stack.
    fn check_hierarchy(&self) -> Result<(), BrokenScene> {
        let not_a_tree = || Err(BrokenScene("the hierarchy is not a tree that fits the kernels' stack".into()));
        let mut depth = vec![0u32; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let first = node.first as usize;
            if node.count > 0 {
                if first + node.count as usize > self.order.len() {
                    return Err(BrokenScene("a leaf of the hierarchy reaches past the shapes".into()));
                }
                continue;
            }
            if first <= i || first + 1 >= self.nodes.len() || depth[i] + 1 >= MAX_BVH_DEPTH {
                return not_a_tree();
            }
            for child in [first, first + 1] {
                // Only nodes without a parent have depth 0, and only the root may stay so.
                if depth[child] != 0 {
                    return not_a_tree();
                }
                depth[child] = depth[i] + 1;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_nodes(nodes: &[(u32, u32)]) -> SceneBuffers {
        let node = |&(first, count): &(u32, u32)| BvhNode { first, count, ..BvhNode::default() };
        SceneBuffers {
            camera: vec![Camera::default()],
            sky: vec![Sky::default()],
            spheres: vec![Sphere::default()],
            order: vec![ShapeReference { kind: ShapeKind::Sphere as u32, index: 0 }],
            materials: vec![Material::default()],
            nodes: nodes.iter().map(node).collect(),
            counts: vec![SceneCounts { shapes: 1, nodes: nodes.len() as u32, ..SceneCounts::default() }],
            ..SceneBuffers::default()
        }
    }

    #[test]
    fn a_tree_passes() {
        assert_eq!(with_nodes(&[(1, 0), (0, 1), (0, 1)]).check(), Ok(()));
    }

    #[test]
    fn indices_that_point_nowhere_are_refused() {
        let refused = |buffers: SceneBuffers| assert!(buffers.check().is_err(), "{buffers:?}");
        // A leaf past the shapes, a child before its parent, a missing child, a shared child.
        refused(with_nodes(&[(0, 2)]));
        refused(with_nodes(&[(0, 0), (0, 1)]));
        refused(with_nodes(&[(1, 0), (0, 1)]));
        refused(with_nodes(&[(1, 0), (3, 0), (3, 0), (0, 1), (0, 1)]));
        let deep: Vec<_> = (0..MAX_BVH_DEPTH).flat_map(|i| [(2 * i + 1, 0), (0, 1)]).skip(1).collect();
        refused(with_nodes(&[&[(1, 0)], &deep[..], &[(0, 1), (0, 1)]].concat()));

        let tree = || with_nodes(&[(0, 1)]);
        refused(SceneBuffers { materials: vec![], ..tree() });
        refused(SceneBuffers { spheres: vec![], ..tree() });
        refused(SceneBuffers { order: vec![ShapeReference { kind: 99, index: 0 }], ..tree() });
        refused(SceneBuffers { camera_media: vec![CameraMedium { shape: 1, material: 0 }], ..tree() });
        refused(SceneBuffers { sky: vec![], ..tree() });
    }
}
