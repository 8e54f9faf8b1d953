//! Views besides the picture itself: features of the first surface, views of the film, comparisons.

mod comparison;
#[cfg(target_os = "linux")]
mod denoised;
mod display;
mod features;
mod motion;

use raggio_scene::Scene;
use raggio_tests::parse;

/// Scene of all kinds of materials, bodies that overlap, and a sky that is seen. 42x33 pixels: no multiple of a
/// workgroup or a tile.
fn still_life() -> Scene {
    parse(
        "[render]\nwidth = 42\nheight = 33\nmax_depth = 6\nseed = 5\n
         [camera]\nposition = [0, 1.5, 6]\nlook_at = [0, 0.8, 0]\nvertical_fov_degrees = 40\n
         [environment]\nhorizon = [1, 0.9, 0.8]\nzenith = [0.3, 0.5, 1]\n
         [materials.ground]\ncolor = [0.5, 0.5, 0.4]\n
         [materials.mirror]\ncolor = [0.9, 0.6, 0.3]\nsmoothness = 1\n
         [materials.glass]\ncolor = [0.9, 1, 0.95]\nrefractive_index = 1.5\npriority = 1\n
         [materials.water]\ncolor = [0.8, 0.9, 1]\nrefractive_index = 1.33\n
         [materials.lamp]\ncolor = [0, 0, 0]\nemission_color = [1, 0.8, 0.6]\nemission_strength = 4\n
         [[shapes]]\nmaterial = \"ground\"\nbox = { center = [0, -0.5, 0], size = [6, 1, 6] }\n
         [[shapes]]\nmaterial = \"mirror\"\nbox = { center = [-1.6, 0.6, 0], size = [1, 1.2, 0.8], rotation_degrees = [0, 30, 10] }\n
         [[shapes]]\nmaterial = \"glass\"\nsphere = { center = [0, 0.8, 0], radius = 0.8 }\n
         [[shapes]]\nmaterial = \"water\"\nbox = { center = [0.8, 0.5, 0], size = [1.2, 0.9, 1.2] }\n
         [[shapes]]\nmaterial = \"lamp\"\nsphere = { center = [1.5, 2.2, 0.5], radius = 0.4 }\n",
    )
}

/// Byte of the sRGB transfer function.
fn encoded(x: f64) -> u8 {
    let x = x.clamp(0.0, 1.0);
    byte(if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
}

fn byte(x: f64) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Checks that colours are at most `allowed` apart in each channel, for what rounding does to the last step.
#[track_caller]
fn assert_alike(what: &str, expected: &[[u8; 3]], found: &[[u8; 3]], allowed: u8) {
    assert_eq!(expected.len(), found.len(), "{what}");
    for (place, (e, f)) in expected.iter().zip(found).enumerate() {
        let apart = e.iter().zip(f).map(|(e, f)| e.abs_diff(*f)).max();
        assert!(apart <= Some(allowed), "{what}: pixel {place}: expected {e:?}, found {f:?}");
    }
}
