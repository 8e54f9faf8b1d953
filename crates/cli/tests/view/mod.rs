//! The window, played by scripts: on a virtual screen, and hidden.
//!
//! Needs a Vulkan device that can draw, such as lavapipe, with validation layers, and Xvfb for the tests with a window;
//! where they are missing the tests say so and pass, unless `RAGGIO_TEST_EVERYTHING=1` says that they have to be there.

mod denoise;
mod desk;
mod frame;
#[cfg(all(unix, not(target_os = "macos")))]
mod hands;
mod hidden;
mod motion;
mod refusals;
mod window;

use std::path::Path;

use crate::common::read_exr;

/// A scene that is noisy enough that no two samples are alike.
const SCENE: &str = r#"version = 1
[camera] # from the front
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
horizon = [1, 1, 1]
zenith = [0.2, 0.4, 1.0]
[materials.clay]
color = [0.8, 0.4, 0.2]
[materials.glass]
color = [1, 1, 1]
refractive_index = 1.5
[[shapes]] # the ground
material = "clay"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
[[shapes]]
material = "clay"
sphere = { center = [0, 1, 0], radius = 1 }
[[shapes]]
material = "glass"
sphere = { center = [1.4, 0.5, 0.8], radius = 0.5 }
"#;

/// Asserts that two EXRs are the same, pixels and attributes, byte for byte.
#[track_caller]
fn assert_same_picture(a: &Path, b: &Path) {
    let bits = |path| {
        let (width, height, pixels) = read_exr(path);
        (width, height, pixels.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect::<Vec<_>>())
    };
    let (a_bits, b_bits) = (bits(a), bits(b));
    assert_eq!((a_bits.0, a_bits.1), (b_bits.0, b_bits.1), "sizes differ");
    let different = a_bits.2.iter().zip(&b_bits.2).filter(|(a, b)| a != b).count();
    assert_eq!(different, 0, "pixels differ between {} and {}", a.display(), b.display());
    let bytes = |path| std::fs::read(path).expect("a picture");
    assert!(bytes(a) == bytes(b), "attributes differ between {} and {}", a.display(), b.display());
}
