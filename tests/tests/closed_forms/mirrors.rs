//! A corridor between two mirrors: a ray climbs by the same height at each bounce until it leaves over the top.

use glam::DVec3;
use raggio_scene::{Integrator, Scene};
use raggio_tests::render::means;
use raggio_tests::{for_each_device, render};

use crate::closed_forms::{View, WHITE_SKY, materials, shapes};

const COLOR: DVec3 = DVec3::new(0.9, 0.5, 0.1);
const GLOW: f64 = 0.25;
/// Height that a ray gains from one mirror to the next, two units away.
const RISE: f64 = 0.2;

/// Scene of mirrors at x = -1 and x = 1 that end where the ray passes after `bounces`, glowing with `glow`.
fn corridor(bounces: u32, glow: f64, max_depth: u32) -> Scene {
    let top = RISE * f64::from(bounces);
    let mirror = format!("color = [0.9, 0.5, 0.1]\nsmoothness = 1\nemission_strength = {glow}");
    let side = |x: f64| {
        format!("rectangle = {{ corner = [{x}, -5, -5], edge_u = [0, {}, 0], edge_v = [0, 0, 10] }}", top + 5.0)
    };
    let rest =
        [WHITE_SKY, &materials(&[("mirror", &mirror)]), &shapes(&[("mirror", &side(1.0)), ("mirror", &side(-1.0))])]
            .concat();
    let mut scene = View::new([0.0, 0.0, 0.0], [1.0, 0.5 * RISE, 0.0], 0.1).size(4, 4).depth(max_depth).scene(&rest);
    // Roulette would leave to chance what is exact.
    scene.render.integrator = Integrator::Reference;
    scene
}

/// Colour of the mirrors as floats hold it, which is not the colour of the file.
fn color() -> DVec3 {
    COLOR.as_vec3().as_dvec3()
}

/// Checks all pixels, to one rounding for each factor and each sum, and the film's 2^-40.
fn assert_exact(what: &str, scene: &Scene, bounces: u32, expected: DVec3) {
    for_each_device(|device| {
        for mean in means(&render(device.device, scene, 4)) {
            let allowed = f64::from(2 * bounces + 3) * 2f64.powi(-24) * expected + 2f64.powi(-40);
            let near = (mean - expected).abs().cmple(allowed).all();
            assert!(near, "{}: {what}, {bounces} bounces: expected {expected}, found {mean}", device.label);
        }
    });
}

#[test]
fn each_bounce_multiplies_by_the_color() {
    for bounces in 0..=10 {
        let expected = DVec3::from_array(color().to_array().map(|c| c.powi(bounces as i32)));
        assert_exact("enough depth", &corridor(bounces, 0.0, bounces + 1), bounces, expected);
        if bounces > 0 {
            assert_exact("one ray too few", &corridor(bounces, 0.0, bounces), bounces, DVec3::ZERO);
        }
    }
}

#[test]
fn light_is_gathered_along_the_path() {
    for bounces in 1..=10 {
        let power = |k: u32| DVec3::from_array(color().to_array().map(|c| c.powi(k as i32)));
        let gathered = |rays: u32| (0..rays.min(bounces)).map(power).sum::<DVec3>() * GLOW;
        let whole = gathered(bounces) + power(bounces);
        assert_exact("enough depth", &corridor(bounces, GLOW, bounces + 5), bounces, whole);
        assert_exact("one ray too few", &corridor(bounces, GLOW, bounces), bounces, gathered(bounces));
    }
}
