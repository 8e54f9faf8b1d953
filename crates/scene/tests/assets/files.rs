//! A folder with a scene, and small files beside it.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use raggio_scene::{Assets, DAffine3, Geometry, Mesh, Scene, SceneError};

use crate::common::check_invariants;

/// First five lines of a scene file.
pub const HEAD: &str = "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
";

/// A right triangle over the points (0, 0, 0), (1, 0, 0) and (0, 2, 0).
pub const TRIANGLE_PLY: &str = "ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 2 0
3 0 1 2
";

/// A triangle like that of [`TRIANGLE_PLY`] in two parts of two materials, and one without.
pub const PARTS_OBJ: &str = "mtllib parts.mtl
v 0 0 0
v 1 0 0
v 0 2 0
v 1 2 0
f 1 2 3
usemtl red
f 2 4 3
usemtl blue
f 1 4 3
";

/// Material library that [`PARTS_OBJ`] names.
pub const PARTS_MTL: &str = "newmtl red
Kd 1 0 0
newmtl blue
Kd 0 0 1
";

/// One pixel of the radiance (1, 0.5, 0.25).
pub const PIXEL_HDR: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81";

/// A folder that holds the files above, gone when it is dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("triangle.ply", TRIANGLE_PLY);
        folder.write("parts.obj", PARTS_OBJ);
        folder.write("parts.mtl", PARTS_MTL);
        folder.write("pixel.hdr", PIXEL_HDR);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Result of reading the text as that of `scene.toml` in this folder, after [`HEAD`].
    pub fn read(&self, body: &str, assets: &mut Assets) -> Result<Scene, SceneError> {
        let scene = Scene::parse_with(&format!("{HEAD}{body}"), &self.path("scene.toml"), assets);
        scene.inspect(check_invariants)
    }

    /// The scene of a text that is right.
    pub fn scene(&self, body: &str) -> Scene {
        self.read(body, &mut Assets::default()).unwrap()
    }

    /// The error of a text that is wrong, without the folder's name.
    pub fn error(&self, body: &str) -> String {
        let error = self.read(body, &mut Assets::default()).unwrap_err();
        self.shown(&error.to_string())
    }

    /// A message without the folder's name.
    pub fn shown(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.0.path().display()), "")
    }
}

/// Meshes of a scene, with their transforms and the indices of the first of their own materials.
pub fn meshes(scene: &Scene) -> Vec<(&Arc<Mesh>, DAffine3, Option<usize>)> {
    let meshes = scene.shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh { mesh, world_from_mesh, first_material } => Some((mesh, *world_from_mesh, *first_material)),
        _ => None,
    });
    meshes.collect()
}
