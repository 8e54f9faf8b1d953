//! [[camera.keyframes]].

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "all mistakes at once",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
interpolation = \"cubic\"
[[camera.keyframes]]
time = -1
position = [0, nan, 4]
[[camera.keyframes]]
fov = 30
[[camera.keyframes]]
time = 2
look_at = [0, 1]
frame = 3
",
        "scene.toml:6:17: `interpolation` in [camera] must be `\"linear\"` or `\"smooth\"`, not `\"cubic\"`
scene.toml:8:8: `time` in keyframe 1 of [camera] must be 0 or more, not `-1`
scene.toml:9:16: component 2 of `position` in keyframe 1 of [camera] must be a finite number, not `nan`
scene.toml:10:1: `time` is missing in keyframe 2 of [camera]
scene.toml:11:1: unknown key `fov` in keyframe 2 of [camera]: did you mean `vertical_fov_degrees`?
scene.toml:14:11: `look_at` in keyframe 3 of [camera] must be a list of 3 numbers, not of 2
scene.toml:15:1: unknown key `frame` in keyframe 3 of [camera]: a keyframe's `time` is in seconds: that of frame F is (F - 1) / fps",
    ),
    (
        "times that do not ascend",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
keyframes = [
    { time = 1, position = [0, 1, 4] },
    { time = 1, position = [0, 1, 3] },
    { time = 0.5, position = [0, 1, 2] },
    { time = 4 },
]
",
        "scene.toml:8:14: `time` in keyframe 2 of [camera] is 1, which is the same as that of keyframe 1 (1): keyframes stand in the order of their times, each with its own
scene.toml:9:14: `time` in keyframe 3 of [camera] is 0.5, which is before that of keyframe 2 (1): keyframes stand in the order of their times, each with its own
scene.toml:10:5: keyframe 4 of [camera] says nothing but its time: give it a `position`, a `look_at` or another key",
    ),
    (
        "cameras that see nothing",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[camera.keyframes]]
time = 0
position = [0, 1, 4]
[[camera.keyframes]]
time = 1
position = [0, 1, 0]
[[camera.keyframes]]
time = 2
position = [0, 4, 0]
",
        "scene.toml:9:1: at keyframe 2, `look_at` in [camera] is the same point as `position`: move one of them, so that the camera looks somewhere
scene.toml:12:1: at keyframe 3, `up` in [camera] is parallel to the viewing direction: `up = [0, 0, 1]` would do",
    ),
    (
        "directions that point nowhere",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
keyframes = [{ time = 0, up = [0, 0, 0] }, { time = 1, up = [0, 0, -3] }]
",
        "scene.toml:6:14: at keyframe 1, `up` in [camera] is zero: `up = [0, 1, 0]` would do
scene.toml:6:44: at keyframe 2, `up` in [camera] is parallel to the viewing direction: `up = [0, 1, 0]` would do",
    ),
    (
        "the height of another kind of camera",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
keyframes = [{ time = 0, orthographic_height = 3 }, { time = 1, orthographic_height = 2 }]
",
        "scene.toml:6:1: `orthographic_height` in [camera.keyframes] needs an orthographic camera: give [camera] an `orthographic_height` in place of its `vertical_fov_degrees`",
    ),
    (
        "a way between no keyframes",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
interpolation = \"linear\"
",
        "scene.toml:6:1: `interpolation` in [camera] needs keyframes: add [[camera.keyframes]], each with a `time`",
    ),
    (
        "one keyframe in place of a list",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[camera.keyframes]
time = 1
",
        "scene.toml:6:1: `keyframes` in [camera] must be a list, written `[[camera.keyframes]]`, not a table",
    ),
    (
        "a key of animations of other programs",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
animation = [{ time = 1, position = [0, 1, 4] }]
",
        "scene.toml:6:1: unknown key `animation` in [camera]: did you mean `keyframes`?",
    ),
];
