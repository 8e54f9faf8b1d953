//! Reconstruction filters: their pictures of a plain sky and of an edge.

use glam::DVec3;
use raggio_scene::{Filter, Scene};
use raggio_tests::render::{Estimate, means};
use raggio_tests::{for_each_device, parse, render};

/// Description of a filter: its name, its radius in pixels, and the filter along one axis, of any scale.
type Described = (Filter, f64, fn(f64) -> f64);

fn filters() -> [Described; 3] {
    let window = |x: f64| {
        let angle = |k: f64| (k * std::f64::consts::TAU * (x / 3.0 + 0.5)).cos();
        0.35875 - 0.48829 * angle(1.0) + 0.14128 * angle(2.0) - 0.01168 * angle(3.0)
    };
    let mitchell = |x: f64| {
        let x = x.abs();
        if x < 1.0 { 7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0 } else { (2.0 - x).powi(2) * (8.0 - 7.0 * x) / 3.0 }
    };
    [(Filter::Box, 0.5, |_| 1.0), (Filter::BlackmanHarris, 1.5, window), (Filter::Mitchell, 2.0, mitchell)]
}

/// Scene of an edge, `edge` pixels from the left border of a 12 x 64 picture: left of it everything has radiance 1.
fn edge(edge: f64) -> Scene {
    let right = (edge - 6.0) / 32.0;
    parse(&format!(
        "[render]\nwidth = 12\nheight = 64\nmax_depth = 1\n
         [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 90\n
         [materials.light]\nemission_strength = 1\n
         [[shapes]]\nmaterial = \"light\"\n
         rectangle = {{ corner = [{}, -2, -1], edge_u = [4, 0, 0], edge_v = [0, 4, 0] }}\n",
        right - 4.0
    ))
}

/// Estimates of each column of the picture, from its rows.
fn columns(means: &[DVec3]) -> Vec<Estimate> {
    let rows = (means.len() / 12) as f64;
    let column = |x: usize| {
        let values: Vec<DVec3> = means.iter().copied().skip(x).step_by(12).collect();
        let mean = values.iter().sum::<DVec3>() / rows;
        let spread = values.iter().map(|v| (*v - mean) * (*v - mean)).sum::<DVec3>() / (rows - 1.0);
        Estimate { mean, error: DVec3::from_array((spread / rows).to_array().map(f64::sqrt)) }
    };
    (0..12).map(column).collect()
}

#[test]
fn an_edge_becomes_the_integral_of_the_filter() {
    const PLACE: f64 = 5.3;
    for_each_device(|device| {
        for (filter, radius, value) in filters() {
            let mut scene = edge(PLACE);
            scene.render.filter = filter;
            let film = render(device.device, &scene, device.pick(4096, 1024));
            let integral = |to: f64| {
                let step = (to + radius).clamp(0.0, 2.0 * radius) / 10_000.0;
                (0..10_000).map(|i| value(-radius + (f64::from(i) + 0.5) * step)).sum::<f64>() * step
            };
            for (x, found) in columns(&means(&film)).into_iter().enumerate() {
                let expected = integral(PLACE - (x as f64 + 0.5)) / integral(radius);
                // A cell of the table is a 1024th of the filter, and the edge may divide one.
                let allowed = 4.0 * found.error.x + 1e-3;
                assert!(
                    (found.mean.x - expected).abs() < allowed && found.error.x < 1e-3,
                    "{}, {filter:?}: column {x}: expected {expected}, found {found:?}",
                    device.label
                );
            }
        }
    });
}

/// Weights are 1 on average: a plain sky stays what it is.
#[test]
fn a_plain_sky_keeps_its_radiance() {
    for_each_device(|device| {
        for (filter, ..) in filters() {
            let mut scene = parse(
                "environment = { color = [0.25, 1, 4] }\n[render]\nwidth = 32\nheight = 32\n
                 [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 60\n",
            );
            scene.render.filter = filter;
            let what = format!("{}, {filter:?}", device.label);
            let found = raggio_tests::render::estimate(device.device, &scene, 64);
            found.assert_near(&what, DVec3::new(0.25, 1.0, 4.0), 1e-3);
        }
    });
}
