//! Samplers: samples follow the density that the kernels state, and random numbers are random.

mod bsdf;
mod densities;
mod directions;
mod functions;
mod microfacets;
mod mirroring;
mod numbers;
mod principled;
mod sobol;

use glam::DVec3;
use raggio_scene::Scene;
use raggio_tests::parse;

/// Scene for questions that concern none.
fn anywhere() -> Scene {
    parse("[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n")
}

/// Frame of perpendicular unit vectors, the third along `axis`.
fn frame(axis: DVec3) -> [DVec3; 3] {
    let axis = axis.normalize();
    let (x, y) = axis.any_orthonormal_pair();
    [x, y, axis]
}
