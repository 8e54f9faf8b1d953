//! Agreement of Vulkan's picture with the CPU's.

use raggio_render::Film;
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render;
use raggio_tests::render::{means, relative_difference};

use crate::determinism::scenes_of_all_kinds;

const SAMPLES: u32 = 32;

/// Number of pixels with equal bits, and of those whose means agree to 1e-5.
fn agreeing(ours: &Film, theirs: &Film) -> (usize, usize) {
    let equal = ours.pixels().iter().zip(theirs.pixels()).filter(|(a, b)| a == b).count();
    let near = means(ours).into_iter().zip(means(theirs)).filter(|(a, b)| relative_difference(*a, *b) < 1e-5).count();
    (equal, near)
}

/// Both devices run one arithmetic. Vulkan allows a division or a square root another last bit or two, and
/// multiplications and additions to be fused; a path goes on as before but for such roundings, unless one turns a
/// decision (hit or miss, reflection or refraction), and then it is another path of equal right.
///
/// Nearly all pixels therefore agree to a few roundings, 1e-5 (of `weekend`, the worst, 99 % on lavapipe and 96.3 % on
/// an NVIDIA H200; of `cornell` and `nested` all, with equal bits, on both); and the mean of all pixels, which few
/// turned paths hardly move, to a thousandth.
#[test]
fn vulkan_agrees_with_the_cpu() {
    let Some(vulkan) = vulkan() else { return };
    for (name, scene) in scenes_of_all_kinds() {
        let (ours, theirs) = (render(vulkan, &scene, SAMPLES), render(cpu(), &scene, SAMPLES));
        let pixels = ours.pixels().len();
        let (equal, near) = agreeing(&ours, &theirs);
        let total = |film: &Film| means(film).iter().map(|m| m.element_sum()).sum::<f64>();
        let mean = (total(&ours) / total(&theirs) - 1.0).abs();
        println!(
            "{name}: of {pixels} pixels {equal} have equal bits, {near} agree to 1e-5; means differ by {mean:.1e}"
        );
        assert!(near >= pixels * 95 / 100, "{name}: expected 95 % of {pixels} pixels to agree to 1e-5, found {near}");
        assert!(mean < 1e-3, "{name}: expected means to agree to 1e-3, found a difference of {mean:.1e}");
    }
    let messages = vulkan.validation_messages();
    assert!(messages.is_empty(), "Vulkan's validation layers complain:\n{}", messages.join("\n"));
}
