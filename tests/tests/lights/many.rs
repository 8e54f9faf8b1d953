//! Many lights, and very bright ones.

use std::time::Instant;

use glam::{DAffine3, DVec3};
use raggio_render::DeviceScene;
use raggio_scene::{Geometry, Integrator, Scene, Shape};
use raggio_tests::{Pcg, estimate, for_each_device, parse};

use crate::lights::{add_mesh, ball, sky};

/// View of the origin on a grey floor, from so near that all pixels show one radiance.
const FLOOR: &str = "
    [render]
    width = 32
    height = 32
    max_depth = 2
    [camera]
    position = [-0.2, 0.3, -0.5]
    look_at = [0, 0, 0]
    vertical_fov_degrees = 0.02
    [materials.floor]
    color = [0.5, 0.5, 0.5]
    [materials.lamp]
    color = [0, 0, 0]
    emission_strength = 5
    [[shapes]]
    material = \"floor\"
    plane = { point = [0, 0, 0], normal = [0, 1, 0] }
";

fn with_spheres(count: usize, radius: f32) -> (Scene, f64) {
    let mut scene = parse(FLOOR);
    let material = scene.materials.iter().position(|m| m.name == "lamp").expect("the floor's lamp");
    let mut random = Pcg::new(2);
    let mut irradiance = 0.0;
    for _ in 0..count {
        let center =
            DVec3::new(random.between(-9.0, 9.0), random.between(0.5, 9.0), random.between(-9.0, 9.0)).as_vec3();
        let (distance, sine) = (center.as_dvec3().length(), f64::from(center.y) / center.as_dvec3().length());
        irradiance += 5.0 * std::f64::consts::PI * (f64::from(radius) / distance).powi(2) * sine;
        scene.shapes.push(Shape { entry: 0, material, geometry: Geometry::Sphere { center, radius } });
    }
    (scene, irradiance)
}

/// A hundred thousand lamps are so small that none hides another: the sum of what each sends has a closed form.
#[test]
fn a_hundred_thousand_spheres() {
    let (scene, irradiance) = with_spheres(100_000, 1e-4);
    let start = Instant::now();
    let translated = DeviceScene::new(&scene).expect("the scene fits devices");
    println!("{} emitters in {:.2} s", translated.buffers.emitters.len(), start.elapsed().as_secs_f64());
    for_each_device(|device| {
        let start = Instant::now();
        let found = estimate(device.device, &scene, device.pick(64, 16));
        println!("{}: error {:.2e}, {:.2?}", device.label, found.error.x / found.mean.x, start.elapsed());
        let expected = DVec3::splat(0.5 / std::f64::consts::PI * irradiance);
        found.assert_near(&format!("{}: 100,000 spheres", device.label), expected, 0.02);
    });
}

/// Light of a mesh of 131,072 triangles that lies in one plane's half space is that of the sphere it resembles.
#[test]
fn a_lit_mesh_of_a_hundred_thousand_triangles() {
    let mut scene = parse(FLOOR);
    let center = DVec3::new(0.4, 3.0, 0.2);
    add_mesh(&mut scene, ball(7), DAffine3::from_translation(center), "lamp");
    let start = Instant::now();
    let translated = DeviceScene::new(&scene).expect("the scene fits devices");
    assert_eq!(translated.buffers.emitters.len(), 131_072);
    println!("131072 emitters in {:.2} s", start.elapsed().as_secs_f64());
    let distance = center.length();
    let expected = 0.5 * 5.0 / (distance * distance) * center.y / distance;
    for_each_device(|device| {
        let start = Instant::now();
        let found = estimate(device.device, &scene, device.pick(64, 16));
        println!("{}: error {:.2e}, {:.2?}", device.label, found.error.x / found.mean.x, start.elapsed());
        // The mesh's corners lie on the sphere, so it is a little smaller.
        let relative = (found.mean.x / expected - 1.0).abs();
        assert!(
            relative < 0.02 && found.error.x < 0.01 * expected,
            "{}: {} is not {expected}",
            device.label,
            found.mean.x
        );
    });
}

/// A sun of 10^5 stands in one texel: the floor's radiance is the sum over the image, and the noise is small.
#[test]
fn a_sun_in_the_sky() {
    let (width, height) = (256, 128);
    let mut scene = parse(FLOOR);
    scene.environment = sky(width, height, |x, y| if (x, y) == (70, 30) { [1e5; 3] } else { [0.5; 3] });
    // The bilinear blend spreads a texel over its neighbours; the integral of that with the cosine, numerically.
    let steps = 16;
    let place = |i: u32, size: u32| (f64::from(i) + 0.5) / (f64::from(steps * size));
    let mut irradiance = 0.5 * std::f64::consts::PI;
    for i in 28 * steps..34 * steps {
        let theta = std::f64::consts::PI * place(i, height);
        let down = (1.0 - (place(i, height) * f64::from(height) - 30.5).abs()).max(0.0);
        let area =
            (std::f64::consts::PI / f64::from(steps * height)) * (std::f64::consts::TAU / f64::from(steps * width));
        for j in 67 * steps..74 * steps {
            let across = (1.0 - (place(j, width) * f64::from(width) - 70.5).abs()).max(0.0);
            irradiance += down * across * (1e5 - 0.5) * theta.cos() * theta.sin() * area;
        }
    }
    for_each_device(|device| {
        let found = estimate(device.device, &scene, device.pick(256, 128));
        println!("{}: error {:.2e}", device.label, found.error.x / found.mean.x);
        let expected = DVec3::splat(0.5 / std::f64::consts::PI * irradiance);
        found.assert_near(&format!("{}: a sun in the sky", device.label), expected, 0.01);
    });
}

/// Light sampling is what makes small lamps bearable.
#[test]
fn a_small_lamp_is_no_noise() {
    let (scene, irradiance) = with_spheres(3, 0.05);
    for_each_device(|device| {
        let expected = 0.5 / std::f64::consts::PI * irradiance;
        let mut scene = scene.clone();
        let mut error = |integrator| {
            scene.render.integrator = integrator;
            estimate(device.device, &scene, 64).error.x / expected
        };
        let (path, reference) = (error(Integrator::Path), error(Integrator::Reference));
        assert!(30.0 * path < reference, "{}: errors {path:.2e} and {reference:.2e}", device.label);
    });
}
