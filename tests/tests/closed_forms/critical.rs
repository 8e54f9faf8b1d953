//! The critical angle of total internal reflection.

use glam::DVec3;
use raggio_tests::render::means;
use raggio_tests::{for_each_device, render};

use crate::closed_forms::fresnel::{ask, question};
use crate::closed_forms::{View, water_under_the_sky};

/// Largest `u` that the kernels can draw: it refracts wherever refraction is possible.
const LAST: f32 = 1.0 - 5.960_464_5e-8;

/// Angles are swept in steps of a thousandth of a degree; single precision rounds the sine by far less than one step.
#[test]
fn transmission_ends_at_the_critical_angle() {
    const STEPS: i32 = 500;
    for_each_device(|device| {
        for index in [1.33f64, 1.5, 1.7, 2.4] {
            let critical = (1.0 / index).asin().to_degrees();
            let angles: Vec<_> = (-STEPS..=STEPS).map(|i| critical + f64::from(i) * 1e-3).collect();
            let questions: Vec<_> = angles.iter().map(|&a| question(a, DVec3::Y, index, -1.0, LAST)).collect();
            let transmitted: Vec<_> = ask(&device, &questions).iter().map(|answer| answer[0][3] == 1.0).collect();
            let flips: Vec<_> = (1..angles.len()).filter(|&i| transmitted[i] != transmitted[i - 1]).collect();
            let label = device.label;
            assert!(
                transmitted[0] && flips.len() == 1,
                "{label}: index {index}: transmission ends {} times",
                flips.len()
            );
            let found = angles[flips[0]];
            assert!((found - critical).abs() < 0.01, "{label}: index {index}: expected {critical}, found {found}");
        }
    });
}

/// The whole sky is seen in a disk from under water, and black water around it.
#[test]
fn snells_window_ends_at_the_critical_angle() {
    let rest = water_under_the_sky();
    // The view is wide enough for 55 degrees to both sides.
    let view = View::new([0.0, -1.0, 0.0], [0.0, 0.0, 0.0], 4.0).size(1600, 40);
    let scene = view.scene_with("filter = \"point\"", "", &rest);
    let critical = (1.0f64 / 1.33).asin().to_degrees();
    for_each_device(|device| {
        let film = render(device.device, &scene, 64);
        let (mut inside, mut outside) = (0, 0);
        for (i, mean) in means(&film).into_iter().enumerate() {
            let direction = view.direction(i as u32 % view.width, i as u32 / view.width);
            let degrees = direction.y.acos().to_degrees();
            // 71 % of the light is reflected a tenth of a degree inside: all of 64 samples, 3 times in 10^10.
            if (degrees - critical).abs() < 0.1 {
                continue;
            }
            let (bright, what) = (mean.x > 0.0, format!("{}: {degrees} degrees, radiance {}", device.label, mean.x));
            if degrees < critical {
                inside += 1;
                assert!(bright, "expected sky within {critical} degrees: {what}");
            } else {
                outside += 1;
                assert!(!bright, "expected black water beyond {critical} degrees: {what}");
            }
        }
        assert!(inside > 1000 && outside > 1000, "the picture shows both sides: {inside} and {outside} pixels");
    });
}
