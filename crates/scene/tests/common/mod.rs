//! Helpers that several tests need.

use std::f32::consts::FRAC_PI_2;
use std::path::PathBuf;

use raggio_scene::{Environment, Geometry, LightKind, Reflection, Scene, Sky, Vec3};

/// Every key that a scene may have in this version, but for those that exclude others.
pub const EXAMPLE: &str = r#"version = 1
[render]                     # optional, as is every key in it
width = 1280
height = 720
samples = 256                # per pixel
max_depth = 10               # rays along one path
seed = 0
filter = "box"
surface_offset = true
[camera]
position = [0, 1, 4]         # integers are fine wherever a number is
look_at = [0, 1, 0]
up = [0, 1, 0]               # default
vertical_fov_degrees = 40
aperture_radius = 0          # thin lens when > 0
focus_distance = 4
[environment]
color = [0.7, 0.8, 1.0]
[[lights]]
point = { position = [0, 3, 0], color = [1, 0.9, 0.8], intensity = 4 }
[[lights]]
spot = { position = [1, 2, 3], direction = [0, -3, -4], inner_degrees = 10, outer_degrees = 20, color = [1, 0.9, 0.8], intensity = 5 }
[[lights]]
directional = { direction = [0, -6, -8], angle_degrees = 0.5, color = [1, 0.9, 0.8], intensity = 3 }
[materials.glass]
color = [1, 1, 1]
emission_color = [1, 1, 1]   # default
emission_strength = 0
smoothness = 1               # 0 diffuse .. 1 mirror
refractive_index = 1.5       # absent: opaque
reflection = "fresnel"       # or a probability
priority = 0
[materials."matt white"]
[materials.lacquer.principled]
base_color = [0.8, 0.1, 0.1]
alpha = 0.5
alpha_mode = "mask"
alpha_cutoff = 0.25
metallic = 0.25
roughness = 0.5
ior = 1.4
specular = 0.5
specular_color = [1, 0.9, 0.8]
transmission = 0.25
thin_walled = true
attenuation_color = [0.9, 0.8, 0.7]
attenuation_distance = 2
dispersion = 0.4
priority = 3
diffuse_transmission = 0.125
diffuse_transmission_color = [0.5, 0.6, 0.7]
clearcoat = 1
clearcoat_roughness = 0.1
clearcoat_normal_scale = 0.5
sheen_color = [0.1, 0.2, 0.3]
sheen_roughness = 0.3
anisotropy = 0.6
anisotropy_rotation = 90
iridescence = 0.7
iridescence_ior = 1.8
iridescence_thickness_minimum = 200
iridescence_thickness_maximum = 500
emissive = [0, 0.5, 1]
emissive_strength = 2
normal_scale = 2
[[shapes]]
material = "glass"
sphere = { center = [0, 1, 0], radius = 1 }
[[shapes]]
material = "matt white"
plane = { point = [0, 0, 0], normal = [0, 2, 0] }
[[shapes]]
material = "matt white"
rectangle = { corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [0, 0, 1] }
[[shapes]]
material = "matt white"
disk = { center = [0, 1, 0], normal = [0, 0, 2], radius = 1 }
[[shapes]]
material = "matt white"
cylinder = { base = [0, 1, 0], top = [0, 3, 0], radius = 0.5, capped = false }
[[shapes]]
material = "matt white"
cone = { base = [0, 1, 0], top = [2, 1, 0], radius = 0.5, top_radius = 0.25, capped = true }
[[shapes]]
material = "matt white"
box = { center = [1, 2, 3], size = [1, 2, 3], rotation_degrees = [10, 20, 30] }
"#;

/// Path of a file of the project.
pub fn project_file(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path)
}

/// Asserts that a file of the project is the text that is made from the types of the scene file. With
/// `RAGGIO_WRITE_DOCS` set, the file is written instead.
pub fn assert_written(path: &str, text: &str) {
    if std::env::var_os("RAGGIO_WRITE_DOCS").is_some() {
        std::fs::write(project_file(path), text).unwrap();
    }
    let found = std::fs::read_to_string(project_file(path)).unwrap().replace("\r\n", "\n");
    assert!(found == text, "{path} is out of date: RAGGIO_WRITE_DOCS=1 cargo test --release -p raggio-scene writes it");
}

/// One of the scenes that reference pictures exist of.
pub fn reference_scene(name: &str) -> PathBuf {
    project_file("scenes/reference").join(format!("{name}.toml"))
}

/// Checks the promises that every scene read without an error makes to those who render it.
pub fn check_invariants(scene: &Scene) {
    check_settings(scene);
    check_camera(scene);
    match &scene.environment {
        Environment::Constant(color) => check_light(*color),
        Environment::Gradient { horizon, zenith } => {
            check_light(*horizon);
            check_light(*zenith);
        }
        Environment::Image { rotation_degrees, intensity, .. }
        | Environment::Sky(Sky { rotation_degrees, intensity, .. }) => {
            assert!(rotation_degrees.is_finite());
            check_light(Vec3::splat(*intensity));
        }
    }
    check_materials(scene);
    assert!(scene.lights.len() >= scene.light_entries.len());
    for light in &scene.lights {
        check_light(light.intensity.into());
        assert!(light.position.is_finite() && light.direction.is_normalized(), "{light:?}");
        match light.kind {
            LightKind::Spot { inner, outer } => {
                assert!(0.0 <= inner && inner <= outer && outer <= FRAC_PI_2 + 1e-6, "{light:?}")
            }
            LightKind::Sun { half_angle } => assert!(half_angle > 8e-5 && half_angle <= FRAC_PI_2 + 1e-6, "{light:?}"),
            LightKind::Directional | LightKind::Point => {}
        }
    }
    for shape in &scene.shapes {
        assert!(shape.material < scene.materials.len(), "{shape:?}");
        check_geometry(&shape.geometry, scene.materials.len());
    }
    assert!(scene.warnings.len() <= 101);
}

fn check_settings(scene: &Scene) {
    let render = &scene.render;
    assert!((1..=65536).contains(&render.width));
    assert!((1..=65536).contains(&render.height));
    assert!((1..=i32::MAX as u32).contains(&render.samples));
    assert!((0..=65535).contains(&render.max_depth));
}

fn check_camera(scene: &Scene) {
    let camera = &scene.camera;
    let points = [camera.position, camera.look_at, camera.up];
    assert!(points.iter().all(|point| point.is_finite()), "{camera:?}");
    // The camera's frame, as a renderer would make it in 32 bits.
    let forward = (camera.look_at - camera.position).normalize();
    let right = forward.cross(camera.up.normalize()).normalize();
    assert!(right.is_finite() && forward.is_finite(), "{camera:?}");
    // Half of the picture's height is that of a field of view within the limits, or of a length.
    assert!(camera.half_height() > 1e-16 && camera.half_height() < 1e16, "{camera:?}");
    assert!(camera.aperture_radius >= 0.0 && camera.aperture_radius.is_finite());
    assert!(camera.focus_distance.is_normal() && camera.focus_distance > 0.0);
}

fn check_light(color: Vec3) {
    assert!(color.is_finite() && color.min_element() >= 0.0, "{color}");
}

fn check_materials(scene: &Scene) {
    let fraction = 0.0..=1.0;
    for material in &scene.materials {
        if let Some(principled) = &material.principled {
            check_light(principled.emissive.into());
            assert!(principled.alpha >= 0.0 && principled.roughness <= 1.0, "{material:?}");
            assert!(principled.ior >= 1.0 && principled.attenuation_distance > 0.0, "{material:?}");
        }
        check_light(material.color);
        check_light(material.emission_color * material.emission_strength);
        assert!(material.color.max_element() <= 1.0, "{material:?}");
        assert!(fraction.contains(&material.smoothness), "{material:?}");
        let index = material.refractive_index.unwrap_or(1.0);
        assert!((0.09..=10.0).contains(&index), "{material:?}");
        if let Reflection::Probability(probability) = material.reflection {
            assert!(fraction.contains(&probability), "{material:?}");
        }
    }
}

fn check_geometry(geometry: &Geometry, materials: usize) {
    match *geometry {
        Geometry::Sphere { center, radius } => {
            assert!(center.is_finite() && radius.is_normal() && radius > 0.0);
            assert!((radius * radius).is_normal());
        }
        Geometry::Plane { point, normal } => {
            assert!(point.is_finite() && normal.is_normalized(), "{geometry:?}");
        }
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            assert!(corner.is_finite(), "{geometry:?}");
            let cosine = edge_u.normalize().dot(edge_v.normalize());
            assert!(cosine.abs() < 1.1e-4, "{geometry:?}");
        }
        Geometry::Disk { center, normal, radius } => {
            assert!(center.is_finite() && normal.is_normalized() && radius > 0.0, "{geometry:?}");
        }
        Geometry::Cylinder { base, top, radius, .. } => {
            assert!((top.as_dvec3() - base.as_dvec3()).normalize().is_normalized() && radius > 0.0, "{geometry:?}");
        }
        Geometry::Cone { base, top, radius, top_radius, .. } => {
            assert!((top.as_dvec3() - base.as_dvec3()).normalize().is_normalized() && radius > 0.0, "{geometry:?}");
            assert!((0.0..=radius).contains(&top_radius), "{geometry:?}");
        }
        Geometry::Box { center, size, rotation_degrees } => {
            assert!(center.is_finite() && rotation_degrees.is_finite(), "{geometry:?}");
            assert!(size.is_finite() && size.min_element() > 0.0, "{geometry:?}");
        }
        Geometry::Mesh { ref mesh, world_from_mesh, first_material } => {
            assert!(!mesh.triangles.is_empty() && world_from_mesh.inverse().is_finite(), "{world_from_mesh}");
            assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
            for part in mesh.parts.iter().filter(|_| first_material.is_some()) {
                let material = first_material.unwrap_or(0) + part.material.unwrap_or(0);
                assert!(material < materials, "{part:?}");
            }
        }
    }
}
