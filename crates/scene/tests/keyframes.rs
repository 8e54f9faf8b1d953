//! Cameras that move: at each moment of a still and of a sequence.

use raggio_scene::{AssetOptions, Assets, Camera, Projection, Scene, Vec3};

const HEAD: &str = "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
";

const REST: &str = "[environment]
color = [1, 1, 1]
";

/// Camera of a scene with these keys at `time`, and `elapsed` seconds after the first frame.
fn camera(keys: &str, time: Option<f64>, elapsed: Option<f64>) -> Camera {
    let options = AssetOptions { time_seconds: time, elapsed_seconds: elapsed, ..AssetOptions::default() };
    let text = format!("{HEAD}{keys}{REST}");
    let scene = Scene::parse_with(&text, "scene.toml".as_ref(), &mut Assets::new(options)).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    scene.camera
}

const LINEAR: &str = "interpolation = \"linear\"
keyframes = [
    { time = 1, position = [0, 0, 4], vertical_fov_degrees = 20 },
    { time = 3, position = [4, 0, 4], focus_distance = 2 },
    { time = 4, vertical_fov_degrees = 50, aperture_radius = 0.5 },
]
";

#[test]
fn a_still_is_at_its_time_and_at_0_without_one() {
    let first = camera(LINEAR, None, None);
    let fov = |vertical_fov_degrees| Projection::Perspective { vertical_fov_degrees };
    assert_eq!((first.position, &first.projection), (Vec3::new(0.0, 0.0, 4.0), &fov(20.0)));
    assert_eq!((first.look_at, first.focus_distance, first.aperture_radius), (Vec3::Y, 2.0, 0.5));
    let middle = camera(LINEAR, Some(2.0), None);
    assert_eq!((middle.position, &middle.projection), (Vec3::new(2.0, 0.0, 4.0), &fov(30.0)));
    let last = camera(LINEAR, Some(9.0), None);
    assert_eq!((last.position, &last.projection), (Vec3::new(4.0, 0.0, 4.0), &fov(50.0)));
}

#[test]
fn a_sequence_begins_at_the_time() {
    let at = |time, elapsed| camera(LINEAR, time, Some(elapsed)).position.x;
    assert_eq!([at(None, 1.0), at(None, 1.5), at(Some(1.0), 0.5), at(Some(2.0), 7.0)], [0.0, 1.0, 1.0, 4.0]);
    // The frame before the first of all stands still.
    assert_eq!(at(Some(0.0), -1.0), 0.0);
    assert_eq!(at(Some(2.5), -0.5), 2.0);
}

#[test]
fn pictures_turn_and_parallel_rays_spread() {
    let keys = "keyframes = [
    { time = 0, up = [0, 2, 0] },
    { time = 1, up = [5, 0, 0], orthographic_height = 4 },
    { time = 3, orthographic_height = 2 },
]
";
    let at = |interpolation: &str, seconds| {
        let keys = format!("interpolation = \"{interpolation}\"\n{keys}");
        let text = format!("{HEAD}{keys}{REST}").replace("vertical_fov_degrees = 40", "orthographic_height = 9");
        let options = AssetOptions { time_seconds: Some(seconds), ..AssetOptions::default() };
        Scene::parse_with(&text, "scene.toml".as_ref(), &mut Assets::new(options)).unwrap().camera
    };
    for interpolation in ["linear", "smooth"] {
        let [first, middle, last] = [0.0, 0.5, 3.5].map(|seconds| at(interpolation, seconds));
        assert_eq!([first.up, last.up], [Vec3::Y, Vec3::X]);
        assert!((middle.up.normalize() - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6, "{}", middle.up);
        let heights = [first, middle, at(interpolation, 2.0), last].map(|camera| camera.orthographic_height());
        assert_eq!(heights, [4.0, 4.0, 3.0, 2.0].map(Some), "the camera's own counts for nothing");
    }
}

/// Circles have no cubic of their own, but what is smooth is near them, and exact where a keyframe is.
#[test]
fn keyframes_are_joined_smoothly_unless_told_otherwise() {
    let keys: String = (0..=8)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::FRAC_PI_4;
            let (x, z) = (4.0 * angle.sin(), 4.0 * angle.cos());
            format!("[[camera.keyframes]]\ntime = {i}\nposition = [{x}, 1, {z}]\n")
        })
        .collect();
    for step in 8..=56 {
        let seconds = f64::from(step) / 8.0;
        let position = camera(&keys, Some(seconds), None).position;
        let radius = position.with_y(0.0).length();
        let off = (radius - 4.0).abs();
        assert!(if step % 8 == 0 { off < 1e-5 } else { off < 0.1 }, "{radius} at {seconds}");
        assert!((camera(&keys, Some(seconds), None).focus_distance - (position - Vec3::Y).length()).abs() < 1e-6);
    }
    let straight = format!("interpolation = \"linear\"\n{keys}");
    let position = camera(&straight, Some(0.5), None).position;
    assert!((position.with_y(0.0).length() - 4.0 * (std::f32::consts::PI / 8.0).cos()).abs() < 1e-5);
}

#[test]
fn whoever_has_met_nobody_at_a_keyframe_may_do_so_between() {
    let keys = "interpolation = \"linear\"
keyframes = [{ time = 0, position = [0, 1, 4] }, { time = 1, position = [0, 1, -4] }]
";
    let text = format!("{HEAD}{keys}{REST}");
    let options = AssetOptions { time_seconds: Some(0.5), ..AssetOptions::default() };
    let error = Scene::parse_with(&text, "scene.toml".as_ref(), &mut Assets::new(options)).unwrap_err();
    let expected = "scene.toml:4:11: `look_at` in [camera] is the same point as `position`: move one of them, so that \
                    the camera looks somewhere";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_scene_that_moves_nothing_needs_no_frames() {
    let options = AssetOptions { elapsed_seconds: Some(1.0), ..AssetOptions::default() };
    let text = format!("{HEAD}{REST}");
    let scene = Scene::parse_with(&text, "scene.toml".as_ref(), &mut Assets::new(options)).unwrap();
    let expected = "frames are asked for, but nothing in the scene moves: only .gltf and .glb files have animations";
    assert!(scene.warnings[0].ends_with(expected), "{:?}", scene.warnings);
}
