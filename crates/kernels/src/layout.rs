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

impl SceneBuffers {
    /// Checks every index that a kernel follows, so that none can read outside its buffer.
    pub fn check(&self) -> Result<(), BrokenScene> {
        let fail = |what: &str| Err(BrokenScene(what.to_owned()));
        let [counts] = self.counts[..] else { return fail("`counts` must have one element") };
        if self.camera.len() != 1 || self.sky.len() != 1 {
            return fail("`camera` and `sky` must have one element each");
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
        let known = |material: u32| (material as usize) < self.materials.len();
        let shapes_known = self.spheres.iter().all(|s| known(s.material))
            && self.planes.iter().all(|s| known(s.material))
            && self.rectangles.iter().all(|s| known(s.material))
            && self.boxes.iter().all(|s| known(s.material));
        if !shapes_known || !self.camera_media.iter().all(|&m| known(m)) {
            return fail("a material index is too large");
        }
        let in_its_buffer = |reference: &ShapeReference| {
            let length = match reference.kind {
                k if k == ShapeKind::Sphere as u32 => self.spheres.len(),
                k if k == ShapeKind::Plane as u32 => self.planes.len(),
                k if k == ShapeKind::Rectangle as u32 => self.rectangles.len(),
                k if k == ShapeKind::Box as u32 => self.boxes.len(),
                _ => 0,
            };
            (reference.index as usize) < length
        };
        if !self.order.iter().all(in_its_buffer) {
            return fail("a shape index is too large");
        }
        self.check_hierarchy()
    }

    /// Children come after their parents, leaves stay inside `order`, and no branch is deeper than the kernels' stack.
    fn check_hierarchy(&self) -> Result<(), BrokenScene> {
        let mut depth = vec![0u32; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let first = node.first as usize;
            if node.count > 0 {
                if first + node.count as usize > self.order.len() {
                    return Err(BrokenScene("a leaf of the hierarchy reaches past the shapes".into()));
                }
            } else if first <= i || first + 1 >= self.nodes.len() || depth[i] + 1 >= MAX_BVH_DEPTH {
                return Err(BrokenScene("the hierarchy is not a tree that fits the kernels' stack".into()));
            } else {
                depth[first] = depth[i] + 1;
                depth[first + 1] = depth[i] + 1;
            }
        }
        Ok(())
    }
}
