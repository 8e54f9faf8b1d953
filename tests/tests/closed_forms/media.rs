//! Media: Beer and Lambert's law, single scattering, and white furnaces.

use std::f64::consts::TAU;

use glam::DVec3;
use raggio_scene::{Integrator, Light, LightKind, Scene};
use raggio_tests::render::{estimate, mean, means};
use raggio_tests::{for_each_device_with, for_each_way, render};

use crate::closed_forms::{ONE_DIRECTION, View, WHITE_SKY, materials, shapes};

/// Coefficients of the tests' fog, which differ from colour to colour.
const ABSORPTION: [f64; 3] = [0.1, 0.0, 0.4];
const SCATTERING: [f64; 3] = [0.6, 0.3, 0.0];

fn fog(anisotropy: f64) -> String {
    format!("medium = {{ absorption = {ABSORPTION:?}, scattering = {SCATTERING:?}, anisotropy = {anisotropy} }}")
}

fn extinction() -> DVec3 {
    DVec3::from(ABSORPTION) + DVec3::from(SCATTERING)
}

fn exp(x: DVec3) -> DVec3 {
    DVec3::from(x.to_array().map(f64::exp))
}

/// Density of Henyey and Greenstein's phase function.
fn phase(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (2.0 * TAU * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

/// Integral over an interval, by Simpson's rule.
fn integral(low: f64, high: f64, f: impl Fn(f64) -> DVec3) -> DVec3 {
    const INTERVALS: u32 = 400;
    let step = (high - low) / f64::from(INTERVALS);
    let weight = |i: u32| if i == 0 || i == INTERVALS { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=INTERVALS).map(|i| weight(i) * f(low + f64::from(i) * step)).sum::<DVec3>() * step / 3.0
}

/// A ball of fog around the camera, which looks along -z, in white surroundings.
fn inside_a_ball(radius: f64, anisotropy: f64, sky: &str, max_depth: u32) -> Scene {
    let ball = format!("sphere = {{ center = [0, 0, 0], radius = {radius} }}");
    let rest = [sky, &materials(&[("fog", &fog(anisotropy))]), &shapes(&[("fog", &ball)])].concat();
    View::new([0.0; 3], [0.0, 0.0, -1.0], ONE_DIRECTION).depth(max_depth).scene(&rest)
}

/// Bodies without a surface that only absorb leave an exact part of the light, in both integrators and in layers; where two of
/// them overlap the one of higher priority fills the room. A ray starts anew behind each boundary, 16 roundings of a dozen units
/// further, and what lies between is not absorbed.
#[test]
fn absorption_is_exact() {
    let list = materials(&[
        ("red", "medium = { absorption = [0.1, 0.5, 2] }"),
        ("blue", "medium = { absorption = [1.5, 0.2, 0] }\npriority = 1"),
    ]);
    let bodies = shapes(&[
        ("red", "box = { center = [0, 0, 0], size = [9, 9, 2] }"),
        ("blue", "box = { center = [0, 0, 0.75], size = [8, 8, 1] }"),
        ("red", "sphere = { center = [0, 0, -5], radius = 0.5 }"),
    ]);
    let scene = View::new([0.0, 0.0, 3.0], [0.0; 3], ONE_DIRECTION).scene(&[WHITE_SKY, &list, &bodies].concat());
    // The blue box reaches from 0.25 to 1.25, the red one from -1 to 1 but for that, and the ball is 1 across.
    let expected = exp(-(2.25 * DVec3::new(0.1, 0.5, 2.0) + DVec3::new(1.5, 0.2, 0.0)));
    for_each_way(&scene, |device, scene| {
        for mean in means(&render(device.device, scene, 4)) {
            let error = ((mean - expected) / expected).abs().max_element();
            assert!(error < 1e-4, "{}: expected {expected}, found {mean}", device.label);
        }
    });
}

/// Light that comes straight through fog is what neither absorption nor scattering has taken: a path of a single ray finds that
/// by chance of not being scattered, whose probability it shares among colours.
#[test]
fn what_is_not_scattered_follows_beer_and_lambert() {
    let scene = inside_a_ball(1.5, 0.3, WHITE_SKY, 1);
    let expected = exp(-1.5 * extinction());
    for_each_way(&scene, |device, scene| {
        let what = format!("{}: {:?}", device.label, scene.render.integrator);
        estimate(device.device, scene, device.pick(256, 32)).assert_near(&what, expected, device.pick(0.002, 0.01));
    });
}

/// Light of a white sky that is scattered once: over the way to the camera, and over the directions from which it comes.
#[test]
fn single_scattering_of_the_sky() {
    let radius: f64 = 1.5;
    for g in [0.0, 0.7, -0.5] {
        let scene = inside_a_ball(radius, g, WHITE_SKY, 2);
        let scattered = |t: f64| {
            let from_all_sides = integral(-1.0, 1.0, |cosine| {
                let way = -t * cosine + (radius * radius - t * t * (1.0 - cosine * cosine)).max(0.0).sqrt();
                TAU * phase(g, cosine) * exp(-way * extinction())
            });
            exp(-t * extinction()) * from_all_sides
        };
        let once = DVec3::from(SCATTERING) * integral(0.0, radius, scattered);
        let expected = exp(-radius * extinction()) + once;
        for_each_way(&scene, |device, scene| {
            let what = format!("{}, g = {g}: {:?}", device.label, scene.render.integrator);
            let samples = device.pick(512, 64);
            estimate(device.device, scene, samples).assert_near(&what, expected, device.pick(0.002, 0.01));
        });
    }
}

/// Light of a sun that is scattered once arrives by shadow rays, which lose on their way what the fog takes.
#[test]
fn single_scattering_of_the_sun() {
    let (radius, g): (f64, f64) = (2.0, 0.6);
    let mut scene = inside_a_ball(radius, g, "", 2);
    let (irradiance, toward) = ([3.0, 2.0, 1.0], DVec3::new(0.5, 0.6, -0.3).normalize());
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Directional,
        position: DVec3::ZERO,
        direction: -toward,
        intensity: irradiance,
    });
    let cosine = -toward.z;
    let scattered = |t: f64| {
        let way = -t * cosine + (radius * radius - t * t * (1.0 - cosine * cosine)).sqrt();
        exp(-(t + way) * extinction())
    };
    let irradiance = DVec3::from(irradiance.map(f64::from));
    let expected = phase(g, cosine) * irradiance * DVec3::from(SCATTERING) * integral(0.0, radius, scattered);
    for_each_way(&scene, |device, scene| {
        let what = format!("{}: {:?}", device.label, scene.render.integrator);
        let found = estimate(device.device, scene, device.pick(256, 32));
        // Blue is not scattered at all.
        assert_eq!(found.mean.z, 0.0, "{what}");
        found.assert_near(&what, expected, device.pick(0.003, 0.01));
    });
}

/// A lamp shines through the air: a shadow ray in it loses what the air takes, and so does the camera's. The floor is seen from
/// straight above at distance 2, and the lamp's light comes from 3 above it.
#[test]
fn air_takes_light_from_surfaces() {
    let air = "[air]\nabsorption = [0.1, 0.2, 0.3]\n";
    let floor = "[materials.floor]\ncolor = [0.5, 0.5, 0.5]\n[[shapes]]\nmaterial = \"floor\"\n\
                 plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    let view = View::new([0.0, 2.0, 0.0], [0.0; 3], ONE_DIRECTION).depth(2);
    let mut scene = view.scene(&[air, floor].concat());
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point,
        position: DVec3::new(0.0, 3.0, 0.0),
        direction: DVec3::NEG_Y,
        intensity: [9.0; 3],
    });
    let expected = 0.5 / std::f64::consts::PI * exp(-5.0 * DVec3::new(0.1, 0.2, 0.3));
    for_each_way(&scene, |device, scene| {
        for mean in means(&render(device.device, scene, 4)) {
            let error = ((mean - expected) / expected).abs().max_element();
            assert!(error < 1e-5, "{}: expected {expected}, found {mean}", device.label);
        }
    });
}

/// Fog that absorbs nothing sends all light on: in white surroundings it cannot be seen, with or without a boundary that bends
/// light, and whatever is in it. A path is worth 1 but for roundings, for all colours are scattered alike.
#[test]
fn white_fog_vanishes() {
    let list = materials(&[
        ("fog", "medium = { scattering = 2, anisotropy = 0.5 }"),
        ("dense", "medium = { scattering = 30, anisotropy = -0.2 }\npriority = 2"),
        ("milk", "color = [1, 1, 1]\nrefractive_index = 1.33\nmedium = { scattering = 5, anisotropy = 0.8 }"),
        ("white", "color = [1, 1, 1]"),
    ]);
    let bodies = shapes(&[
        ("fog", "box = { center = [0, 0, 0], size = [3, 2.4, 2] }"),
        ("milk", "sphere = { center = [0.5, 0.2, 0.3], radius = 0.5 }"),
        ("dense", "sphere = { center = [-0.6, 0, 0.6], radius = 0.45 }"),
        ("white", "sphere = { center = [-0.4, -0.6, 0], radius = 0.4 }"),
        ("milk", "box = { center = [0.8, -0.8, 0.4], size = [0.7, 0.5, 0.6], rotation_degrees = [10, 20, 30] }"),
    ]);
    let view = View::new([0.0, 0.0, 5.0], [0.0; 3], 35.0).size(32, 32).depth(0);
    let scene = view.scene(&[WHITE_SKY, &list, &bodies].concat());
    for_each_way(&scene, |device, scene| {
        let means = means(&render(device.device, scene, device.pick(64, 8)));
        let worst = means.iter().map(|mean| (*mean - 1.0).abs().max_element()).fold(0.0, f64::max);
        let what = format!("{}: {:?}", device.label, scene.render.integrator);
        println!("{what}: at most {worst:.1e} from 1");
        assert!(worst < 5e-4, "{what}: expected 1, found {worst:.1e} from it");
    });
}

/// Colours that are scattered unequally are so by chance, and white on average; a rough boundary around them keeps all light up
/// to what its tables of lost light err by.
#[test]
fn fog_of_unequal_colours_is_white() {
    let medium = "medium = { scattering = [1, 4, 9], anisotropy = 0.3 }";
    let wax = format!("principled = {{ transmission = 1, roughness = 0.5, ior = 1.4 }}\n{medium}");
    for (material, most) in [(medium, 1e-3), (&*wax, 0.012)] {
        let list = materials(&[("subject", material)]);
        let body = shapes(&[("subject", "sphere = { center = [0, 0, 0], radius = 1 }")]);
        let view = View::new([0.0, 0.0, 3.0], [0.0; 3], 20.0).size(32, 32).depth(0);
        let scene = view.scene(&[WHITE_SKY, &list, &body].concat());
        for_each_way(&scene, |device, scene| {
            // Software Vulkan takes minutes to compile principled kernels: single pictures test them there.
            if device.slow && material != medium {
                return;
            }
            let film = render(device.device, scene, device.pick(256, 32));
            let count = film.pixels().len() as f64;
            let mean = film.pixels().iter().map(mean).sum::<DVec3>() / count;
            let spread = means(&film).iter().map(|m| (*m - mean).length_squared()).sum::<f64>() / count;
            let allowed = most + 4.0 * (spread / count).sqrt();
            let what = format!("{}: {:?} of {material}", device.label, scene.render.integrator);
            println!("{what}: {mean}, allowed {allowed:.4}");
            assert!((mean - 1.0).abs().max_element() < allowed, "{what}: expected 1 within {allowed}, found {mean}");
        });
    }
}

/// A body without a surface is nothing to the layers that say what is seen first, and an empty one nothing at all.
#[test]
fn bodies_without_surface_are_not_seen() {
    let floor = ("floor", "rectangle = { corner = [-9, 0, -9], edge_u = [18, 0, 0], edge_v = [0, 0, 18] }");
    let list = materials(&[("floor", "color = [0.5, 0.6, 0.7]"), ("nothing", "medium = {}")]);
    let lamp = "[environment]\nhorizon = [1, 0.8, 0.6]\nzenith = [0.2, 0.4, 1]\n";
    let view = View::new([0.0, 2.0, 5.0], [0.0, 0.5, 0.0], 40.0).size(32, 32).depth(5);
    let ball = ("nothing", "sphere = { center = [0, 1, 0], radius = 0.8 }");
    let [without, with] = [&[floor][..], &[floor, ball][..]].map(|list_of| [lamp, &list, &shapes(list_of)].concat());
    for integrator in [Integrator::Path, Integrator::Reference] {
        let [without, with] = [&without, &with].map(|rest| {
            let mut scene = view.scene(rest);
            scene.render.integrator = integrator;
            scene
        });
        for_each_device_with(&with, |device| {
            let pictures = [&without, &with].map(|scene| means(&render(device.device, scene, 16)));
            let pairs = pictures[0].iter().zip(&pictures[1]);
            let alike = pairs.filter(|(a, b)| (**a - **b).abs().max_element() < 1e-4).count();
            assert!(alike > 32 * 32 * 97 / 100, "{}: {alike} of {} pixels alike", device.label, 32 * 32);
        });
    }
}
