//! A camera as text.

use raggio_scene::Vec3;
use raggio_viewer::document::{camera_from_text, camera_text};

use crate::document::{FORMS, HEADERS, document};

#[test]
fn a_camera_goes_to_text_and_back() {
    let mut camera = document(HEADERS).scene().camera.clone();
    assert_eq!(
        camera_text(&camera),
        "[camera]\nposition = [0, 1.5, 4]\nlook_at = [0, 1, 0]\nup = [0, 1, 0]\nvertical_fov_degrees = 40\n\
         aperture_radius = 0\nfocus_distance = 4.031129\n"
    );
    (camera.aperture_radius, camera.up, camera.focus_distance) = (0.1, Vec3::new(0.1, 1.0, 0.0), 1.0 / 3.0);
    let text = camera_text(&camera);
    assert_eq!(camera_from_text(&text), Ok(camera.clone()));
    assert_eq!(camera_from_text(text.trim_start_matches("[camera]")), Ok(camera));
}

#[test]
fn a_whole_scene_has_a_camera() {
    for text in FORMS {
        assert_eq!(camera_from_text(text), Ok(document(text).scene().camera.clone()));
        assert_eq!(
            camera_from_text(&text.replace("[0, 2, 0]", "[0, 0, 0]")),
            Ok(document(text).scene().camera.clone())
        );
    }
}

#[test]
fn other_texts_have_none() {
    for text in ["", "hello", "a = 1", "[camera", "\u{0}"] {
        let message = "the text has no camera: copy a [camera] table of a scene file";
        assert_eq!(camera_from_text(text).unwrap_err(), message);
    }
    let error = camera_from_text("camera = { position = [0, 0, 0], look_at = [0, 0, 0] }").unwrap_err();
    assert!(error.starts_with("the text's camera cannot be used: "), "{error}");
}
