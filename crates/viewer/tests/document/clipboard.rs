//! A camera as text.

use raggio_scene::{Camera, Intrinsics, Panorama, Projection, Vec3};
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

/// Cameras of all projections go to text and back, and over one another in a document.
#[test]
fn every_projection_goes_to_text_and_back() {
    let intrinsics = Intrinsics { focal: [80.5, 60.0], principal_point: [70.0, 40.25], skew: 0.5, size: [128, 96] };
    let projections = [
        Projection::Calibrated(intrinsics),
        Projection::Calibrated(Intrinsics { skew: 0.0, focal: [0.1, 0.3], ..intrinsics }),
        Projection::Orthographic { height: 2.5 },
        Projection::Panoramic(Panorama::LatitudeLongitude),
        Projection::Perspective { vertical_fov_degrees: 33.0 },
    ];
    for text in FORMS {
        let mut it = document(text);
        for projection in projections {
            let camera = Camera { projection, ..it.scene().camera.clone() };
            assert_eq!(camera_from_text(&camera_text(&camera)), Ok(camera.clone()));
            assert!(it.set_camera(&camera).unwrap(), "{projection:?} in {}", it.text());
            assert_eq!(it.scene().camera, camera);
            // A movement leaves the projection as it stands.
            let moved = Camera { position: camera.position + Vec3::X, ..camera };
            let before = it.text().to_string();
            let moved = Camera { focus_distance: (moved.look_at - moved.position).length(), ..moved };
            it.set_camera(&moved).unwrap();
            let changed = before.lines().zip(it.text().lines()).filter(|(old, new)| old != new).count();
            assert!(changed <= 2, "{before}\n{}", it.text());
        }
    }
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
