//! The switch that takes the noise away, as far as the screen is concerned.

use crate::common::{read_exr, text};
use crate::view::SCENE;
use crate::view::desk::{Desk, can_draw};

const SCRIPT: &str = "\
panels
stop-at 2
wait 2 samples
screenshot noisy.png
denoise on
wait denoised
screenshot denoised.png
export a.exr
denoise off
wait 4 frames
screenshot after.png
";

#[test]
fn the_screen_loses_its_noise_and_files_do_not() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let output = desk.start(SCRIPT, &["--device", "cpu", "--size", "400x240"], None).finish();
    let errors = text(&output.stderr);
    if errors.contains("Open Image Denoise was not found") {
        let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
        assert!(!required, "RAGGIO_TEST_EVERYTHING=1, and {errors}");
        assert_eq!(output.status.code(), Some(2), "{errors}");
        eprintln!("not tested: {errors}");
        return;
    }
    assert!(output.status.success(), "{errors}");
    desk.assert_valid();
    let screen = |name: &str| image::open(desk.path(name)).expect("a screenshot").to_rgb8();
    // Neighbours differ by noise first of all.
    let roughness = |picture: &image::RgbImage| {
        let pairs = picture.as_raw().chunks_exact(3).zip(picture.as_raw().chunks_exact(3).skip(1));
        pairs.map(|(a, b)| f64::from(a[0].abs_diff(b[0])).powi(2)).sum::<f64>()
    };
    let [noisy, denoised, after] = ["noisy.png", "denoised.png", "after.png"].map(|name| roughness(&screen(name)));
    assert!(denoised < 0.8 * noisy, "roughness {noisy} became {denoised}");
    assert!(after > 0.9 * noisy, "roughness {noisy} is {after} when the switch is off again");
    let (width, height, _) = read_exr(&desk.path("a.exr"));
    desk.render("scene.toml", "again.exr", "cpu", (width, height), 2);
    crate::view::assert_same_picture(&desk.path("a.exr"), &desk.path("again.exr"));
}
