//! Latitude-longitude image of the sky: its centre is seen along -Z, its right along +X, its top along +Y.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use raggio_render::{DeviceScene, Probe, Question};
use raggio_scene::{Bitmap, Environment, Filter, Panorama, Projection, Scene, Texels, Texture, Wrap};
use raggio_tests::render::means;
use raggio_tests::{Pcg, TestDevice, for_each_device, for_each_device_with, render};

use crate::textures::{anywhere, bilinear, bright, distance, texel, varied};

fn under(image: &Arc<Bitmap>, rotation_degrees: f32, intensity: f32) -> Scene {
    let environment = Environment::Image { image: image.clone(), rotation_degrees, intensity };
    Scene { environment, ..anywhere() }
}

/// Asks for the radiance, and the latitude-longitude coordinates, of directions.
fn look(device: &TestDevice, scene: &Scene, rays: impl IntoIterator<Item = DVec3>) -> Vec<([f32; 4], [f32; 2])> {
    let question = |ray: DVec3| -> Question { [ray.as_vec3().extend(0.0).to_array(), [0.0; 4], [0.0; 4]] };
    let questions: Vec<_> = rays.into_iter().map(question).collect();
    let scene = DeviceScene::new(scene).expect("the scene fits devices");
    device.ask_in(&scene, Probe::Sky, &questions).into_iter().map(|[a, [u, v, ..], _]| (a, [u, v])).collect()
}

/// Direction in which the image, not yet turned, shows a place.
fn direction([u, v]: [f64; 2]) -> DVec3 {
    let (sin_longitude, cos_longitude) = (TAU * (u - 0.5)).sin_cos();
    let (sin, cos) = (PI * v).sin_cos();
    DVec3::new(sin * sin_longitude, cos, -sin * cos_longitude)
}

/// Texture that a sky is, for the double-precision blend.
fn as_texture(image: &Arc<Bitmap>) -> Texture {
    Texture { wrap: [Wrap::Repeat, Wrap::ClampToEdge], ..Texture::new(image.clone()) }
}

/// Direction turned about the y axis, counter-clockwise seen from above.
fn turned(direction: DVec3, degrees: f32) -> DVec3 {
    DMat3::from_rotation_y(f64::from(degrees).to_radians()) * direction
}

#[test]
fn the_axes_see_what_they_should() {
    let row = |texels: [f32; 4]| texels.map(|v| [v; 3]);
    let texels = [row([1.0, 2.0, 3.0, 4.0]), row([5.0, 6.0, 7.0, 8.0]), row([9.0, 10.0, 11.0, 12.0])].concat();
    let image = Arc::new(Bitmap { width: 4, height: 3, texels: Texels::Rgb32F(texels) });
    // The places are in the image's middle row, halfway between two columns.
    let axes = [(-DVec3::Z, 6.5), (DVec3::X, 7.5), (-DVec3::X, 5.5), (DVec3::Z, 6.5)];
    // The image is turned by a quarter: -Z sees what +X has seen.
    let turned = [(-DVec3::Z, 7.5), (DVec3::X, 6.5), (-DVec3::X, 6.5), (DVec3::Z, 5.5)];
    for_each_device(|device| {
        for (degrees, axes) in [(0.0, axes), (90.0, turned)] {
            for (axis, expected) in axes {
                let found = look(&device, &under(&image, degrees, 1.0), [axis])[0].0[0];
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{} along {axis} with {degrees} degrees: {found}",
                    device.label
                );
            }
        }
    });
}

/// Every texel's centre is found, through any turn, at any brightness.
#[test]
fn texels_are_where_they_should_be() {
    let image = bright(9, 6);
    let texture = as_texture(&image);
    let centers: Vec<_> = (0..54).map(|i| [f64::from(i % 9) + 0.5, f64::from(i / 9) + 0.5]).collect();
    for_each_device(|device| {
        for (degrees, intensity) in [(0.0, 1.0), (90.0, 0.5), (-90.0, 1.0), (37.5, 3.0), (180.0, 1.0), (-1234.5, 1.0)] {
            let ray = |[x, y]: &[f64; 2]| turned(direction([x / 9.0, y / 6.0]), degrees);
            let found = look(&device, &under(&image, degrees, intensity), centers.iter().map(ray));
            for ([x, y], (found, _)) in centers.iter().zip(found) {
                let [r, g, b, _] = texel(&texture, *x as i64, *y as i64).map(|v| v * f64::from(intensity));
                let what = format!("{} ({x}, {y}) with {degrees} degrees", device.label);
                // Directions in single precision are off by some 1e-7 of a turn, of 9 texels and values up to 4.
                assert!(distance([r, g, b, 0.0], found.map(f64::from)) < 2e-5, "{what}: found {found:?}");
            }
        }
    });
}

/// Any direction sees the blend, near the poles and across the seam behind the viewer too.
#[test]
fn directions_see_the_blend() {
    let image = bright(12, 6);
    let texture = as_texture(&image);
    let random = &mut Pcg::new(5);
    let mut directions: Vec<_> = (0..10_000).map(|_| random.direction()).collect();
    directions.extend([DVec3::Z, DVec3::new(1e-6, 0.1, 1.0), DVec3::new(-1e-6, 0.1, 1.0)].map(DVec3::normalize));
    directions.extend([DVec3::new(1e-6, 1.0, -1e-6), DVec3::new(1e-20, -1.0, 0.0)]);
    for_each_device(|device| {
        for degrees in [0.0, 200.0] {
            let rays = directions.iter().map(|d| turned(*d, degrees));
            let found = look(&device, &under(&image, degrees, 1.0), rays);
            for (d, (found, _)) in directions.iter().zip(found) {
                let u = 0.5 + d.x.atan2(-d.z) / TAU;
                let v = d.y.clamp(-1.0, 1.0).acos() / PI;
                let [r, g, b, _] = bilinear(&texture, [12.0 * u, 6.0 * v]);
                let error = distance([r, g, b, 0.0], found.map(f64::from));
                // Close to the poles rounding turns directions about them.
                let bound = 1e-5 + 1e-6 / d.x.hypot(d.z).max(1e-7);
                assert!(error < bound, "{} along {d}: found {found:?}, off by {error}", device.label);
            }
        }
    });
}

/// The angle to the pole is as precise a hair from it as anywhere, and 0 at the pole.
#[test]
fn poles_are_exact() {
    let random = &mut Pcg::new(6);
    let mut near = |y: f64| {
        let (sin, cos) = random.between(0.0, TAU).sin_cos();
        let sine = random.log_between(1e-12, 1e-3);
        DVec3::new(sine * sin, y, sine * cos)
    };
    let directions: Vec<_> = (0..2000).map(|i| near(if i % 2 == 0 { 1.0 } else { -1.0 })).collect();
    let scene = under(&varied(4, 2), 0.0, 1.0);
    for_each_device(|device| {
        for (d, (_, [_, v])) in directions.iter().zip(look(&device, &scene, directions.iter().copied())) {
            let d = d.as_vec3().as_dvec3();
            let from_pole = d.x.hypot(d.z).atan2(d.y.abs()) / PI;
            if d.y > 0.0 {
                assert!((f64::from(v) / from_pole - 1.0).abs() < 1e-6, "{} along {d}: {v}", device.label);
            } else {
                assert!((1.0 - f64::from(v) - from_pole).abs() < 1.2e-7, "{} along {d}: {v}", device.label);
            }
        }
        let poles = look(&device, &scene, [DVec3::Y, DVec3::NEG_Y]);
        assert_eq!(poles.iter().map(|(_, uv)| *uv).collect::<Vec<_>>(), [[0.5, 0.0], [0.5, 1.0]], "{}", device.label);
    });
}

/// Light from everywhere together is compared with the integral of the blend in double precision.
#[test]
fn the_sphere_sees_the_images_integral() {
    const SIDE: u32 = 512;
    let image = bright(16, 8);
    let texture = as_texture(&image);
    // The blend's mean along a circle of latitude is that of the texels' means.
    let circle = |v: f64| (0..16).map(|x| bilinear(&texture, [f64::from(x) + 0.5, 8.0 * v])[0]).sum::<f64>() / 16.0;
    let steps = 100_000;
    let expected: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
        .map(|v| circle(v) * (PI * v).sin() * TAU * PI / f64::from(steps))
        .sum();
    // The rays have a direction in each cell of equal solid angle.
    let random = &mut Pcg::new(7);
    let mut ray = |i: u32| {
        let cell = |i: u32, offset: f32| (f64::from(i) + f64::from(offset)) / f64::from(SIDE);
        let y = 1.0 - 2.0 * cell(i / SIDE, random.unit());
        let (sin, cos) = (TAU * cell(i % SIDE, random.unit())).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * sin, y, radius * cos)
    };
    let rays: Vec<_> = (0..SIDE * SIDE).map(&mut ray).collect();
    for_each_device(|device| {
        let found = look(&device, &under(&image, 77.0, 2.0), rays.iter().copied());
        let values: Vec<_> = found.iter().map(|(radiance, _)| f64::from(radiance[0])).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        // The variance is that of independent directions; that each cell has one makes it smaller.
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let error = 4.0 * PI * (variance / count).sqrt();
        let (expected, found) = (2.0 * expected, 4.0 * PI * mean);
        assert!((found - expected).abs() < 4.0 * error, "{}: expected {expected}, found {found}", device.label);
        assert!(error < 0.005 * expected, "{}: {error} of {expected} is too uncertain", device.label);
    });
}

/// A panorama of the sky alone is the sky's own image, and turned as it is.
#[test]
fn panoramas_show_it() {
    let image = bright(16, 8);
    let Texels::Rgb32F(colors) = &image.texels else { panic!("an image of floats") };
    for_each_device(|device| {
        for turned in [0, 5] {
            let mut scene = under(&image, 22.5 * turned as f32, 1.0);
            (scene.render.width, scene.render.height) = (16, 8);
            scene.render.filter = Filter::Point;
            scene.camera.projection = Projection::Panoramic(Panorama::LatitudeLongitude);
            for (i, found) in means(&render(device.device, &scene, 1)).into_iter().enumerate() {
                let (x, y) = (i % 16, i / 16);
                // Counter-clockwise from above is to the left.
                let expected = Vec3::from(colors[y * 16 + (x + turned) % 16]).as_dvec3();
                assert!((found - expected).abs().max_element() < 1e-4, "{}: {found}, not {expected}", device.label);
            }
        }
    });
}

/// Rays of a camera that meet nothing see the sky: in the picture's middle the image's.
#[test]
fn cameras_see_it() {
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let image = Arc::new(Bitmap { width: 4, height: 1, texels: Texels::Rgb32F(colors.to_vec()) });
    for_each_device(|device| {
        // The sky is turned until the camera, which looks along -Z, sees the middle of each texel; a picture of one
        // pixel across takes in little else.
        for (degrees, color) in [135.0f32, 45.0, -45.0, -135.0].into_iter().zip(colors) {
            let mut scene = under(&image, -degrees, 0.25);
            (scene.render.width, scene.render.height) = (4, 4);
            scene.camera.projection = Projection::Perspective { vertical_fov_degrees: 1e-3 };
            for found in means(&render(device.device, &scene, 64)) {
                let expected = 0.25 * Vec3::from(color).as_dvec3();
                assert!((found - expected).abs().max_element() < 1e-3, "{}: {found} for {expected}", device.label);
            }
        }
    });
}

/// The ground below a sky is as bright as a plane of its albedo that sky and sun light.
#[test]
fn the_ground_is_as_bright_as_a_plane() {
    let text = "[render]
width = 8
height = 8
[camera]
position = [0, 1, 0]
look_at = [0, 0, -0.1]
vertical_fov_degrees = 10
[environment]
sun_direction = [1, 1.5, 0.5]
turbidity = 4
ground_albedo = [0.1, 0.3, 0.5]
sun_intensity = 0.5
intensity = 2
[materials.ground]
color = [0.1, 0.3, 0.5]
[[shapes]]
material = \"ground\"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
";
    let scene = raggio_tests::parse(text);
    let mut bare = scene.clone();
    bare.shapes.clear();
    for_each_device_with(&scene, |device| {
        let [ground, plane] = [(&bare, 1), (&scene, 256)].map(|(scene, samples)| {
            let means = means(&render(device.device, scene, samples));
            means.iter().sum::<DVec3>() / means.len() as f64
        });
        let off = ((plane - ground) / ground).abs().max_element();
        assert!(off < 0.01, "{}: {plane}, not {ground}", device.label);
    });
}
