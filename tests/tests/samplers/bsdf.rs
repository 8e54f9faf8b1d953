//! Answers of a surface to integrators, whatever its material: samples, values and densities agree, in the world and
//! where normals are bent.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use raggio_render::{Answer, Probe};
use raggio_scene::{Bitmap, Geometry, Mesh, Part, Principled, Scene, Shape, Texels, Texture};
use raggio_tests::{Pcg, TestDevice, for_each_device, parse};

/// Mesh of an octahedron with the normals of a ball: no other angles between the two kinds of normals are as large.
fn octahedron() -> Arc<Mesh> {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis]).concat();
    let positions: Vec<_> = corners.iter().map(Vec3::to_array).collect();
    let uvs = positions.iter().map(|p| [p[0], p[1] + 0.3 * p[2]]).collect();
    let triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..triangles.len() }];
    let normals = Some(positions.clone());
    Arc::new(Mesh { positions, normals, uvs: [Some(uvs), None], triangles, parts, ..Mesh::default() })
}

/// Normal map whose normals lean by up to 40 degrees.
pub fn bumps() -> Option<Texture> {
    let mut random = Pcg::new(9);
    let mut texel = |_| [0, 1, 2, 3].map(|c| if c < 2 { 50 + random.below(156) as u8 } else { 250 });
    let texels = Texels::Rgba8((0..64).map(&mut texel).collect());
    Some(Texture::new(Arc::new(Bitmap { width: 8, height: 8, texels })))
}

fn principled() -> Vec<(&'static str, Principled)> {
    let plain = Principled { roughness: 0.4, base_color: [0.9, 0.5, 0.2], ..Principled::default() };
    let bumpy = Principled { normal_texture: bumps(), clearcoat_normal_texture: bumps(), ..plain.clone() };
    let mixture = Principled {
        metallic: 0.3,
        transmission: 0.5,
        clearcoat: 0.7,
        clearcoat_roughness: 0.3,
        sheen_color: [0.3, 0.5, 0.7],
        sheen_roughness: 0.5,
        anisotropy: 0.6,
        anisotropy_rotation: 0.7,
        ..bumpy.clone()
    };
    vec![
        ("smooth glass", Principled { roughness: 0.0, transmission: 1.0, ..plain.clone() }),
        ("smooth coat", Principled { clearcoat: 1.0, ..plain.clone() }),
        ("plastic", plain),
        ("bumpy metal", Principled { metallic: 1.0, ..bumpy.clone() }),
        ("bumpy glass", Principled { transmission: 1.0, roughness: 0.6, ..bumpy.clone() }),
        ("bumpy leaf", Principled { thin_walled: true, diffuse_transmission: 0.4, ..bumpy }),
        ("mixture", mixture),
    ]
}

/// Scene of the octahedron alone, of a plain material with these keys.
pub fn scene_of_octahedron(text: &str) -> Scene {
    let camera = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n";
    let mut scene = parse(&format!("{camera}[materials.a]\ncolor = [0.9, 0.5, 0.2]\n{text}"));
    let geometry = Geometry::Mesh { mesh: octahedron(), world_from_mesh: DAffine3::IDENTITY, first_material: None };
    scene.shapes.push(Shape { entry: 0, material: 0, geometry });
    scene
}

/// Scenes of the octahedron of each material, from outside and from inside.
fn scenes() -> Vec<(String, Scene)> {
    let mut scenes: Vec<_> = ["smoothness = 0", "smoothness = 0.4", "smoothness = 0.9", "smoothness = 0.99"]
        .into_iter()
        .chain(["smoothness = 1", "refractive_index = 1.5", "refractive_index = 1.5\nreflection = 0.3"])
        .map(|text| (text.to_owned(), scene_of_octahedron(text)))
        .collect();
    for (what, surface) in principled() {
        let mut scene = scene_of_octahedron("");
        scene.materials[0].principled = Some(Arc::new(surface));
        scenes.push((what.to_owned(), scene));
    }
    scenes
}

/// Ray of a question: origin, direction, and a number that chooses texels.
pub type Ray = (Vec3, Vec3, f32);

/// End of a question.
pub enum Third {
    /// Random numbers for a sample.
    Numbers([f32; 4]),
    /// Direction to be evaluated.
    Direction(Vec3),
}

/// Rays to the surface from both sides.
pub fn rays(count: usize, random: &mut Pcg) -> Vec<Ray> {
    let mut ray = |i: usize| {
        let from = if i.is_multiple_of(3) { 0.3 * random.direction() } else { 3.0 * random.direction() };
        let direction = if i.is_multiple_of(3) { random.direction() } else { 0.3 * random.direction() - from };
        (from.as_vec3(), direction.normalize().as_vec3(), random.unit())
    };
    (0..count).map(&mut ray).collect()
}

/// Answer of a surface: a sample, and what is evaluated there.
#[derive(Debug)]
pub struct Sample {
    pub wi: Vec3,
    pub weight: Vec3,
    pub pdf: f32,
    pub delta: bool,
    /// Value evaluated in direction `wi`.
    value: Vec3,
    density: f32,
}

/// Asks the surface along each ray for a sample, or for what it does to light from the direction that is given.
pub fn ask(device: &TestDevice, scene: &Scene, asked: impl Iterator<Item = (Ray, Third)>) -> Vec<Sample> {
    let questions: Vec<_> = asked
        .map(|((origin, direction, texel), third)| {
            let (sampled, third) = match third {
                Third::Numbers(u) => (1.0, u),
                Third::Direction(wi) => (0.0, wi.extend(0.0).to_array()),
            };
            [origin.extend(texel).to_array(), direction.extend(sampled).to_array(), third]
        })
        .collect();
    let sample = |[a, b, c]: Answer| Sample {
        wi: Vec3::from_slice(&a),
        weight: Vec3::from_slice(&b),
        pdf: a[3],
        delta: b[3] >= 2.0,
        value: Vec3::from_slice(&c),
        density: c[3],
    };
    device.ask(scene, Probe::Bsdf, &questions).into_iter().map(sample).collect()
}

#[test]
fn weights_times_densities_are_values() {
    for_each_device(|device| {
        for (what, scene) in scenes() {
            let (what, mut random) = (format!("{}: {what}", device.label), Pcg::new(21));
            let rays = rays(device.pick(20_000, 5000), &mut random);
            let numbers = rays.iter().map(|ray| (*ray, Third::Numbers([0; 4].map(|_| random.unit()))));
            let mut compared = 0;
            for s in ask(&device, &scene, numbers) {
                assert!(s.weight.is_finite() && s.pdf >= 0.0 && s.wi.is_normalized(), "{what}: {s:?}");
                assert!(!s.delta || s.pdf == 0.0, "{what}: {s:?}");
                if s.delta || s.weight == Vec3::ZERO {
                    continue;
                }
                compared += 1;
                // Directions go to the surface's frame and back, which narrow lobes notice.
                let near = (s.pdf - s.density).abs() <= 1e-2 * s.pdf
                    && (s.weight * s.pdf - s.value).abs().max_element() <= 1e-2 * s.value.max_element().max(1e-6);
                assert!(near, "{what}: {s:?}");
            }
            let smooth = ["smoothness = 1", "refractive", "smooth glass"].iter().any(|s| what.contains(s));
            assert!((compared == 0) == smooth, "{what}: {compared} samples with a density");
        }
    });
}

/// Light of samples with a density is the integral of the values, whatever normals do.
#[test]
fn samples_bring_what_values_integrate_to() {
    for_each_device(|device| {
        // Directions drawn evenly miss narrow lobes.
        for (what, scene) in scenes().into_iter().filter(|(what, _)| !what.contains("0.9")) {
            let (what, mut random) = (format!("{}: {what}", device.label), Pcg::new(22));
            let rays = rays(device.pick(200_000, 80_000), &mut random);
            let numbers = rays.iter().map(|ray| (*ray, Third::Numbers([0; 4].map(|_| random.unit()))));
            let drawn = ask(&device, &scene, numbers);
            let brought = drawn.iter().map(|s| if s.delta { DVec3::ZERO } else { s.weight.as_dvec3() });
            let evenly = rays.iter().map(|ray| (*ray, Third::Direction(random.direction().as_vec3())));
            let worth = ask(&device, &scene, evenly).into_iter().map(|s| 2.0 * TAU * s.value.as_dvec3());
            let (brought, error) = mean(brought, rays.len());
            let (worth, other) = mean(worth, rays.len());
            let allowed = 4.0 * (error * error + other * other).map(f64::sqrt) + 1e-9;
            let message = format!("{what}: {brought} by samples, {worth} by values, allowed {allowed}");
            assert!((brought - worth).abs().cmple(allowed).all(), "{message}");
            assert!(allowed.max_element() < 0.1, "{message}, which is too uncertain");
        }
    });
}

/// Mean of the values, with its standard error.
fn mean(values: impl Iterator<Item = DVec3>, count: usize) -> (DVec3, DVec3) {
    let (sum, squares) = values.fold((DVec3::ZERO, DVec3::ZERO), |(s, q), v| (s + v, q + v * v));
    let mean = sum / count as f64;
    (mean, ((squares / count as f64 - mean * mean) / count as f64).map(|v| v.max(0.0).sqrt()))
}
