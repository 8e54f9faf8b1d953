//! The mesh that speed is measured with: as many triangles as are asked for, from no file.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use raggio_models::{Mesh, Part};

use crate::scene::{Geometry, Scene, Shape};

impl Scene {
    /// Text of the scene file of [`rock`](Self::rock), but for the shape.
    pub const ROCK: &str = "version = 1
[render]
width = 1024
height = 1024
max_depth = 11
[camera]
position = [0.0, 1.6, 4.0]
look_at = [0.0, 1.45, 3.0]
vertical_fov_degrees = 61.9
[environment]
color = [0.75, 0.85, 1.0]
[materials.clay]
color = [0.7, 0.7, 0.7]
";

    /// Scene with a bumpy sphere of 20 * 4^`level` triangles on a square of two, diffuse under a constant sky. Benchmarks
    /// compare themselves by it, so it stays as it is.
    pub fn rock(level: u32) -> Self {
        let mut scene = Self::parse(Self::ROCK, "rock").expect("the scene is valid");
        let mesh = Arc::new(rock(level));
        let geometry = Geometry::Mesh { mesh, world_from_mesh: DAffine3::IDENTITY, first_material: None };
        scene.shapes.push(Shape { entry: 0, material: 0, geometry });
        scene
    }
}

/// Corners of an icosahedron on the unit sphere, and its faces.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let signs = [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
    let mut corners: Vec<_> = signs.map(|(a, b)| corner(a, b * golden, 0.0)).into();
    corners.extend(signs.map(|(a, b)| corner(0.0, a, b * golden)));
    corners.extend(signs.map(|(a, b)| corner(b * golden, 0.0, a)));
    let edge = (corners[0] - corners[1]).length() * 1.01;
    let near = |a: usize, b: usize| (corners[a] - corners[b]).length() < edge;
    let mut faces = vec![];
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(corners[a]) > 0.0;
                    faces.push(if outward { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    (corners, faces)
}

/// Splits each triangle into four, on the sphere.
fn subdivide(points: &mut Vec<DVec3>, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::with_capacity(faces.len() * 3 / 2);
    let mut finer = Vec::with_capacity(faces.len() * 4);
    for &[a, b, c] in faces {
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    finer
}

fn bumpy(p: DVec3) -> [f32; 3] {
    let DVec3 { x, y, z } = p;
    let wide = (9.0 * x + 2.0 * (7.0 * y).sin()).sin() * (8.0 * y + 3.0 * (5.0 * z).sin()).sin() * (7.0 * z + x).sin();
    let fine = (40.0 * x).sin() * (37.0 * y).sin() * (43.0 * z).sin();
    (p * (1.0 + 0.12 * wide + 0.03 * fine) + DVec3::Y).as_vec3().to_array()
}

fn rock(level: u32) -> Mesh {
    let (mut points, mut faces) = icosahedron();
    for _ in 0..level {
        faces = subdivide(&mut points, &faces);
    }
    let mut positions: Vec<_> = points.into_iter().map(bumpy).collect();
    let ground = positions.len() as u32;
    positions.extend([[-20.0, 0.0, -20.0], [20.0, 0.0, -20.0], [20.0, 0.0, 20.0], [-20.0, 0.0, 20.0]]);
    faces.extend([[0, 2, 1], [0, 3, 2]].map(|face| face.map(|i| ground + i)));
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..faces.len() }];
    Mesh { positions, triangles: faces, parts, ..Mesh::default() }
}
