//! Light that is looked for: samples follow their density, and both integrators arrive at one picture.

mod agreement;
mod many;
mod samplers;
mod tree;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use raggio_scene::{Bitmap, Environment, Geometry, Light, LightKind, Mesh, Part, Scene, Shape, Texels};

/// Closed mesh of `8 * 4^levels` triangles: an octahedron, divided and blown up to a ball of radius 1.
fn ball(levels: u32) -> Arc<Mesh> {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut faces: Vec<[DVec3; 3]> = vec![];
    for (x, z) in [(x, z), (z, -x), (-x, -z), (-z, x)] {
        faces.extend([[y, z, x], [-y, x, z]]);
    }
    for _ in 0..levels {
        let parts = |[a, b, c]: [DVec3; 3]| {
            let [d, e, f] = [a + b, b + c, c + a].map(|p| p.normalize());
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        };
        faces = faces.into_iter().flat_map(parts).collect();
    }
    let positions: Vec<[f32; 3]> = faces.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
    let triangles: Vec<[u32; 3]> = (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..triangles.len() }];
    Arc::new(Mesh { positions, triangles, parts, ..Mesh::default() })
}

/// Puts a mesh of the material called `material` into `scene`.
fn add_mesh(scene: &mut Scene, mesh: Arc<Mesh>, world_from_mesh: DAffine3, material: &str) {
    let material = scene.materials.iter().position(|m| m.name == material).expect("a material of the scene");
    let geometry = Geometry::Mesh { mesh, world_from_mesh, first_material: None };
    scene.shapes.push(Shape { entry: 0, material, geometry });
}

fn add_light(scene: &mut Scene, kind: LightKind, position: [f64; 3], direction: [f64; 3], intensity: [f32; 3]) {
    let [position, direction] = [DVec3::from(position), DVec3::from(direction).normalize()];
    scene.lights.push(Light { name: String::new(), intensity, position, direction, kind });
}

/// Environment of an image that has a radiance for each texel.
fn sky(width: u32, height: u32, radiance: impl Fn(u32, u32) -> [f32; 3]) -> Environment {
    let texels = (0..width * height).map(|i| radiance(i % width, i / width)).collect();
    let image = Arc::new(Bitmap { width, height, texels: Texels::Rgb32F(texels) });
    Environment::Image { image, rotation_degrees: 25.0, intensity: 1.0 }
}
