//! The thin lens: points on the focused plane are sharp, others spread over a disk of the right size.

use std::f64::consts::PI;

use raggio_scene::Scene;
use raggio_tests::render::means;
use raggio_tests::{TestDevice, for_each_device, render};

use crate::closed_forms::{View, materials, shapes};

const SIZE: u32 = 96;
const FOV_DEGREES: f64 = 20.0;
const APERTURE: f64 = 0.2;
const FOCUS: f64 = 5.0;

/// Scene of a small lamp at `distance` in front of the camera.
fn lamp(distance: f64, radius: f64, aperture: f64) -> Scene {
    let camera = format!("aperture_radius = {aperture}\nfocus_distance = {FOCUS}");
    let shape = format!("sphere = {{ center = [0, 0, {}], radius = {radius} }}", -distance);
    let rest =
        [materials(&[("lamp", "color = [0, 0, 0]\nemission_strength = 1")]), shapes(&[("lamp", &shape)])].concat();
    View::new([0.0; 3], [0.0, 0.0, -1.0], FOV_DEGREES).size(SIZE, SIZE).depth(1).scene_with("", &camera, &rest)
}

/// Size in pixels of something whose tangent is `tangent`.
fn pixels(tangent: f64) -> f64 {
    tangent * f64::from(SIZE) / (2.0 * (0.5 * FOV_DEGREES.to_radians()).tan())
}

/// Light of an image, its centre in pixels, and its second moments about it.
struct Moments {
    light: f64,
    center: [f64; 2],
    variance: [f64; 2],
}

fn moments(device: &TestDevice, scene: &Scene, samples: u32) -> Moments {
    let means = means(&render(device.device, scene, samples));
    let light: f64 = means.iter().map(|m| m.x).sum();
    let place = |i: usize| [i as u32 % SIZE, i as u32 / SIZE].map(|c| f64::from(c) + 0.5);
    let average =
        |f: &dyn Fn([f64; 2]) -> f64| means.iter().enumerate().map(|(i, m)| m.x * f(place(i))).sum::<f64>() / light;
    let center = [average(&|p| p[0]), average(&|p| p[1])];
    let variance = [0, 1].map(|axis| average(&|p: [f64; 2]| (p[axis] - center[axis]).powi(2)));
    Moments { light, center, variance }
}

/// Radius of the disk of confusion in pixels. A uniform disk has a quarter of its squared radius for variance along
/// each axis. The image is the lamp's own disk, spread by the disk of confusion and by the pixel (1/12); variances of
/// independent spreads add up.
fn disk(variance: f64, own_radius: f64) -> f64 {
    2.0 * (variance - own_radius * own_radius / 4.0 - 1.0 / 12.0).max(0.0).sqrt()
}

/// The radius of confusion is the lens's, seen from the lamp, on the focused plane, seen from the lens.
#[test]
fn out_of_focus_points_are_disks_of_the_right_size() {
    for_each_device(|device| {
        let samples = device.pick(2048, 512);
        for distance in [2.5, 3.5, 8.0, 20.0] {
            // The lamp is small enough to be a point, large enough for some of the paths to find it.
            let radius = 0.006 * distance;
            let moments = moments(&device, &lamp(distance, radius, APERTURE), samples);
            let expected = pixels(APERTURE * (1.0 / FOCUS - 1.0 / distance).abs());
            let own = pixels(radius / distance);
            let what = format!("{}: lamp at {distance}", device.label);
            // The relative error of a variance from n points of a disk is 1 / sqrt(n).
            let points = moments.light * f64::from(samples);
            let allowed = 4.0 * 0.5 * expected / points.sqrt() + 0.003 * expected;
            for axis in [0, 1] {
                let found = disk(moments.variance[axis], own);
                println!("{what}: radius of confusion {expected:.3} expected, {found:.3} found, +-{allowed:.3} pixels");
                assert!((found - expected).abs() < allowed, "{what}: expected {expected} +- {allowed}, found {found}");
                let off = (moments.center[axis] - 0.5 * f64::from(SIZE)).abs();
                assert!(off < 4.0 * expected / points.sqrt(), "{what}: the image is {off} pixels off the middle");
            }
            // A lens spreads light and loses none.
            let area = PI * own * own;
            let allowed = area * (4.0 / points.sqrt() + 0.01);
            assert!(
                (moments.light - area).abs() < allowed,
                "{what}: expected {area} of light, found {}",
                moments.light
            );
        }
    });
}

/// The image of a lamp in focus is that of a pinhole, to a twentieth of a pixel.
#[test]
fn points_in_focus_are_sharp() {
    for_each_device(|device| {
        let samples = device.pick(1024, 256);
        let size = |aperture: f64| {
            let moments = moments(&device, &lamp(FOCUS, 0.03, aperture), samples);
            [0, 1].map(|axis| 2.0 * moments.variance[axis].sqrt())
        };
        let (pinhole, lens) = (size(0.0), size(APERTURE));
        println!("{}: radius through a pinhole {pinhole:.3?}, through the lens {lens:.3?} pixels", device.label);
        for axis in [0, 1] {
            let apart = (pinhole[axis] - lens[axis]).abs();
            assert!(
                apart < 0.05,
                "{}: expected a radius of {} pixels, found {}",
                device.label,
                pinhole[axis],
                lens[axis]
            );
        }
    });
}

/// Where rays are parallel, things are as large far away as near, and a lens blurs them by how far they are from its focus.
#[test]
fn parallel_rays_see_no_distance() {
    const HEIGHT: f64 = 2.0;
    let pixel = HEIGHT / f64::from(SIZE);
    for_each_device(|device| {
        for (distance, aperture) in [(3.0, 0.0), (300.0, 0.0), (FOCUS, 0.3), (2.0 * FOCUS, 0.3)] {
            let camera =
                format!("orthographic_height = {HEIGHT}\naperture_radius = {aperture}\nfocus_distance = {FOCUS}");
            let shape = format!("sphere = {{ center = [0.1, -0.2, {}], radius = 0.25 }}", -distance);
            let rest =
                [materials(&[("lamp", "color = [0, 0, 0]\nemission_strength = 1")]), shapes(&[("lamp", &shape)])];
            let view = View::new([0.0; 3], [0.0, 0.0, -1.0], FOV_DEGREES).size(SIZE, SIZE).depth(1);
            let found = moments(&device, &view.scene_with("", &camera, &rest.concat()), device.pick(1024, 256));
            let what = format!("{}: distance {distance}, aperture {aperture}", device.label);
            let area = PI * 0.25 * 0.25 / (pixel * pixel);
            assert!((found.light / area - 1.0).abs() < 0.01, "{what}: {} pixels, not {area}", found.light);
            let middle = f64::from(SIZE) / 2.0;
            let expected = [middle + 0.1 / pixel, middle + 0.2 / pixel];
            for (axis, expected) in expected.into_iter().enumerate() {
                assert!((found.center[axis] - expected).abs() < 0.1, "{what}: {:?}", found.center);
                // Beyond the focus the lens's disk is seen again, upside down, as large as it is that far before it.
                let blur = disk(found.variance[axis], 0.25 / pixel);
                let known = aperture * (distance / FOCUS - 1.0).abs() / pixel;
                assert!(aperture == 0.0 || (blur - known).abs() < 0.03 * known + 0.7, "{what}: {blur}, not {known}");
            }
        }
    });
}
