//! Agreement of pictures whose rays hardware traces with those of software on the same device.

use std::sync::Arc;

use raggio_render::Film;
use raggio_scene::Scene;
use raggio_tests::devices::{assert_valid, hardware, long, vulkan};
use raggio_tests::render::{means, relative_difference};
use raggio_tests::{parse, render};

use crate::determinism::scenes;

const SAMPLES: u32 = 32;

/// A rock among shapes of all kinds, twice: once mirrored.
fn rocks() -> Scene {
    let mut scene = parse(
        "[render]\nwidth = 42\nheight = 33\nmax_depth = 8\nseed = 3
         [camera]\nposition = [0, 1.5, 6]\nlook_at = [0, 0.6, 0]\nvertical_fov_degrees = 40
         [environment]\nhorizon = [1, 0.9, 0.8]\nzenith = [0.3, 0.5, 1]
         [materials.ground]\n[materials.rock]\ncolor = [0.6, 0.4, 0.3]\nsmoothness = 0.3
         [materials.glass]\ncolor = [1, 1, 1]\nrefractive_index = 1.5
         [materials.lamp]\nemission_strength = 5
         [[shapes]]\nmaterial = \"ground\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }
         [[shapes]]\nmaterial = \"glass\"\nsphere = { center = [0, 0.6, 1.5], radius = 0.6 }
         [[shapes]]\nmaterial = \"lamp\"\nrectangle = { corner = [-1, 3, -1], edge_u = [2, 0, 0], edge_v = [0, 0, 2] }
         [[shapes]]\nmaterial = \"rock\"\nbox = { center = [0, 0.3, -1.5], size = [4, 0.6, 0.4], rotation_degrees = [0, 10, 0] }",
    );
    let rock = Scene::rock(4).shapes.swap_remove(0);
    for (place, mirror) in [(-1.3, 1.0), (1.3, -1.0)] {
        let mut rock = rock.clone();
        let raggio_scene::Geometry::Mesh { mesh, world_from_mesh, .. } = &mut rock.geometry else { panic!("a mesh") };
        *mesh = Arc::clone(mesh);
        let stretch = glam::DVec3::new(mirror, 1.0, 1.0);
        *world_from_mesh = glam::DAffine3::from_scale_rotation_translation(
            stretch,
            glam::DQuat::from_rotation_y(0.5),
            glam::DVec3::new(place, 1.0, 0.0),
        );
        rock.material = 1;
        scene.shapes.push(rock);
    }
    scene
}

/// Meshes and shapes of which half is there, through masks and coverage, and lit through them.
fn holes() -> Scene {
    let mut scene = rocks();
    let text = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40
        [materials.half.principled]\nbase_color = [0.8, 0.3, 0.2]\nalpha = 0.5\nalpha_mode = \"blend\"";
    scene.materials[1] = parse(text).materials.swap_remove(0);
    scene
}

/// Number of pixels with equal bits, and of those whose means agree to 1e-5.
fn agreeing(ours: &Film, theirs: &Film) -> (usize, usize) {
    let equal = ours.pixels().iter().zip(theirs.pixels()).filter(|(a, b)| a == b).count();
    let near = means(ours).into_iter().zip(means(theirs)).filter(|(a, b)| relative_difference(*a, *b) < 1e-5).count();
    (equal, near)
}

/// Hardware chooses what a ray meets, and the kernels' own arithmetic says where: paths are those of software, but where a ray
/// meets an edge, or surfaces at one distance. Nearly all pixels therefore agree, and so do the means.
#[test]
fn hardware_agrees_with_software() {
    let (Some(hardware), Some(software)) = (hardware(), vulkan()) else { return };
    let mut scenes = scenes();
    scenes.push(("rocks", rocks()));
    // Software Vulkan takes minutes to compile kernels that know of principled materials.
    if long() || !hardware.slow {
        scenes.push(("holes", holes()));
    }
    for (name, scene) in scenes {
        let (ours, theirs) = (render(hardware.device, &scene, SAMPLES), render(software, &scene, SAMPLES));
        let pixels = ours.pixels().len();
        let (equal, near) = agreeing(&ours, &theirs);
        let total = |film: &Film| means(film).iter().map(|mean| mean.element_sum()).sum::<f64>();
        let mean = (total(&ours) / total(&theirs) - 1.0).abs();
        println!(
            "{name}: of {pixels} pixels {equal} have equal bits, {near} agree to 1e-5; means differ by {mean:.1e}"
        );
        assert!(near >= pixels * 95 / 100, "{name}: expected 95 % of {pixels} pixels to agree to 1e-5, found {near}");
        assert!(mean < 1e-3, "{name}: expected means to agree to 1e-3, found a difference of {mean:.1e}");
    }
    assert_valid(hardware.device);
}
