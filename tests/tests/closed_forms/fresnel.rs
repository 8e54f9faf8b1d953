//! Smooth boundaries: the part of the light that they reflect, the direction and the radiance of the rest.

use glam::{DVec3, Vec3};
use raggio_render::{Answer, Probe, Question};
use raggio_tests::geometry::{fresnel, refracted};
use raggio_tests::{TestDevice, estimate, for_each_device};

use crate::closed_forms::{ONE_DIRECTION, View, WHITE_SKY, materials, shapes, water_under_the_sky};

const DEGREES: [f64; 6] = [0.0, 10.0, 30.0, 56.3, 80.0, 89.0];

/// Scene for questions that concern none.
fn anywhere() -> raggio_scene::Scene {
    View::new([0.0; 3], [0.0, 0.0, -1.0], 40.0).scene(WHITE_SKY)
}

/// Question (wo; n; index, reflection probability or -1, eta, u): light that arrives at `degrees` from the normal.
pub fn question(degrees: f64, n: DVec3, eta: f64, reflection: f32, u: f32) -> Question {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let wo = (sin * n.any_orthonormal_vector() + cos * n).as_vec3();
    [wo.extend(0.0).to_array(), n.as_vec3().extend(0.0).to_array(), [1.5, reflection, eta as f32, u]]
}

pub fn ask(device: &TestDevice, questions: &[Question]) -> Vec<Answer> {
    device.ask(&anywhere(), Probe::Dielectric, questions)
}

/// Reflectances have the absolute error of single precision: the amplitudes are quotients of sums of a few products,
/// within ten roundings. Near the critical angle roundings of the sine are magnified by its square root, so angles keep
/// clear of it.
#[test]
fn reflectance_is_fresnels() {
    for_each_device(|device| {
        for eta in [1.0 / 1.5, 1.5, 1.0 / 1.33, 1.33, 1.0 / 2.4, 1.5 / 1.33, 1.0] {
            let angles: Vec<f64> = DEGREES.into_iter().filter(|a| eta * a.to_radians().sin() < 0.99).collect();
            let questions: Vec<_> = angles.iter().map(|&a| question(a, DVec3::Z, eta, -1.0, 0.5)).collect();
            for (angle, answer) in angles.iter().zip(ask(&device, &questions)) {
                let (expected, found) = (fresnel(angle.to_radians(), eta), f64::from(answer[2][0]));
                let near = (found - expected).abs() < 1e-5;
                assert!(near, "{}: eta {eta}, {angle} degrees: expected {expected}, found {found}", device.label);
            }
        }
    });
}

/// Nothing of the parallel part is left at Brewster's angle: the rest is half the perpendicular part.
#[test]
fn brewsters_angle_reflects_one_polarisation() {
    let brewster = 1.5f64.atan();
    let amplitude = brewster.cos() - (brewster.sin() / 1.5).asin().cos() * 1.5;
    let sum = brewster.cos() + (brewster.sin() / 1.5).asin().cos() * 1.5;
    let expected = 0.5 * (amplitude / sum).powi(2);
    for_each_device(|device| {
        let answer = ask(&device, &[question(brewster.to_degrees(), DVec3::X, 1.0 / 1.5, -1.0, 0.5)])[0];
        let found = f64::from(answer[2][0]);
        assert!((found - expected).abs() < 1e-6, "{}: expected {expected}, found {found}", device.label);
    });
}

/// `u` chooses against the probability: the mirror direction with weight 1, or Snell's with the square of the ratio.
#[test]
fn directions_and_weights() {
    let normals = [DVec3::Y, DVec3::new(-0.6, 0.3, 0.74).normalize()];
    for_each_device(|device| {
        for (eta, normal) in [(1.0 / 1.5, normals[0]), (1.5, normals[1]), (1.33 / 2.4, normals[1]), (2.4, normals[0])] {
            for degrees in DEGREES {
                for (u, reflection) in [(0.0, -1.0), (0.999_999, -1.0), (0.29, 0.3), (0.31, 0.3)] {
                    let question = question(degrees, normal, eta, reflection, u);
                    let [[x, y, z, transmitted], weight, _] = ask(&device, &[question])[0];
                    let n = Vec3::from_slice(&question[1]).as_dvec3().normalize();
                    let incoming = -Vec3::from_slice(&question[0]).as_dvec3().normalize();
                    let through = refracted(incoming, n, f64::from(eta as f32)).filter(|_| u == 0.999_999 || u == 0.31);
                    let (direction, gain) = match through {
                        Some(direction) => (direction, eta * eta),
                        None => (incoming - 2.0 * incoming.dot(n) * n, 1.0),
                    };
                    let what = format!("{}: eta {eta}, {degrees} degrees, u {u}, {reflection}", device.label);
                    assert_eq!(transmitted == 1.0, through.is_some(), "{what}: transmitted is wrong");
                    let found = Vec3::new(x, y, z).as_dvec3();
                    let off = (found - direction).length();
                    assert!(off < 2e-6, "{what}: expected direction {direction}, found {found}");
                    let off = (f64::from(weight[0]) / gain - 1.0).abs();
                    assert!(off < 1e-6, "{what}: expected weight {gain}, found {}", weight[0]);
                }
            }
        }
    });
}

/// Scene of a wide sheet of glass between a white half of the world and a black one, met at `degrees`.
fn slab(degrees: f64, sky: &str, floor: &str, reflection: &str) -> raggio_scene::Scene {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let glass = format!("color = [1, 1, 1]\nrefractive_index = 1.5\nreflection = {reflection}");
    let materials = materials(&[("glass", &glass), ("floor", floor)]);
    let shapes = shapes(&[
        ("glass", "box = { center = [0, -0.05, 0], size = [200, 0.1, 200] }"),
        ("floor", "plane = { point = [0, -2, 0], normal = [0, 1, 0] }"),
    ]);
    let eye = [5.0 * sin, 5.0 * cos, 0.0];
    View::new(eye, [0.0; 3], ONE_DIRECTION).scene(&[sky, &materials, &shapes].concat())
}

/// A sheet reflects back and forth between its faces: R + (1-R)^2 R (1 + R^2 + ...) = 2R / (1+R) in all.
#[test]
fn a_sheet_of_glass_reflects_and_transmits() {
    for_each_device(|device| {
        for degrees in [0.0f64, 30.0, 56.3, 80.0] {
            let r = fresnel(degrees.to_radians(), 1.0 / 1.5);
            let reflected = 2.0 * r / (1.0 + r);
            let samples = device.pick(512, 128);
            let light = "color = [0, 0, 0]\nemission_strength = 1";
            for (what, sky, floor, expected) in
                [("reflected", WHITE_SKY, "color = [0, 0, 0]", reflected), ("transmitted", "", light, 1.0 - reflected)]
            {
                let found = estimate(device.device, &slab(degrees, sky, floor, "\"fresnel\""), samples);
                let what = format!("{}: {what} at {degrees} degrees", device.label);
                found.assert_near(&what, DVec3::splat(expected), 0.01);
            }
        }
    });
}

/// Light is squeezed on the way in and spread on the way out: through a whole body a lamp is as bright as beside it.
#[test]
fn a_lamp_keeps_its_radiance_through_glass() {
    for_each_device(|device| {
        for degrees in [0.0, 30.0, 80.0] {
            let lamp = "color = [0, 0, 0]\nemission_color = [1, 2, 3]\nemission_strength = 2";
            let found = estimate(device.device, &slab(degrees, "", lamp, "0"), 16);
            let what = format!("{}: lamp through glass at {degrees} degrees", device.label);
            found.assert_near(&what, DVec3::new(2.0, 4.0, 6.0), 1e-6);
        }
    });
}

/// The sky is brighter from inside water by the square of the index, less what the surface reflects.
#[test]
fn under_water_the_sky_is_brighter() {
    let rest = water_under_the_sky();
    for_each_device(|device| {
        for degrees in [0.0f64, 20.0, 45.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let scene = View::new([0.0, -1.0, 0.0], [sin, cos - 1.0, 0.0], ONE_DIRECTION).scene(&rest);
            let found = estimate(device.device, &scene, device.pick(256, 64));
            let expected = 1.33 * 1.33 * (1.0 - fresnel(degrees.to_radians(), 1.33));
            found.assert_near(&format!("{}: at {degrees} degrees", device.label), DVec3::splat(expected), 0.003);
        }
    });
}
