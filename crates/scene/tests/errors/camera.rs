//! [camera].

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no camera",
        "version = 1
",
        "scene.toml:1:1: [camera] is missing: a scene needs one, with `position`, `look_at` and `vertical_fov_degrees`",
    ),
    (
        "no position",
        "version = 1
[render]
[camera]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:1: `position` is missing in [camera]",
    ),
    (
        "no look_at",
        "version = 1
[camera]
position = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:2:1: `look_at` is missing in [camera]",
    ),
    (
        "no field of view",
        "version = 1
[camera]
position = [0, 1, 0]
look_at = [0, 1, 4]
",
        "scene.toml:2:1: `vertical_fov_degrees` is missing in [camera]",
    ),
    (
        "no field of view, dotted",
        "version = 1
camera.position = [0, 1, 0]
camera.look_at = [0, 1, 4]
",
        "scene.toml:2:1: `vertical_fov_degrees` is missing in [camera]",
    ),
    (
        "no field of view, inline",
        "version = 1
camera = { position = [0, 1, 0], look_at = [0, 1, 4] }
",
        "scene.toml:2:10: `vertical_fov_degrees` is missing in [camera]",
    ),
    (
        "nan",
        "version = 1
[camera]
position = [0, nan, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:16: component 2 of `position` in [camera] must be a finite number, not `nan`",
    ),
    (
        "infinite",
        "version = 1
[camera]
position = [0, 1, -inf]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:19: component 3 of `position` in [camera] must be a finite number, not `-inf`",
    ),
    (
        "infinite when read",
        "version = 1
[camera]
position = [0, 1, 1e400]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:19: component 3 of `position` in [camera] must be a finite number, not `1e400`",
    ),
    (
        "infinite in 32 bits",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [1e300, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:4:12: component 1 of `look_at` in [camera] must be at most 1e15 in size, not `1e300`",
    ),
    (
        "looks at itself",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 4]
vertical_fov_degrees = 40
",
        "scene.toml:4:11: `look_at` in [camera] is the same point as `position`: move one of them, so that the camera looks somewhere",
    ),
    (
        "looks at itself in 32 bits",
        "version = 1
[camera]
position = [1e10, 0, 0]
look_at = [10000000001, 0, 0]
vertical_fov_degrees = 40
",
        "scene.toml:4:11: `look_at` in [camera] is the same point as `position`: move one of them, so that the camera looks somewhere",
    ),
    (
        "up is zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
up = [0, 0, 0]
",
        "scene.toml:6:6: `up` in [camera] is zero: `up = [0, 1, 0]` would do",
    ),
    (
        "up is parallel",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
up = [0, 0, -2]
",
        "scene.toml:6:6: `up` in [camera] is parallel to the viewing direction: `up = [0, 1, 0]` would do",
    ),
    (
        "default up is parallel",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 8, 4]
vertical_fov_degrees = 40
",
        "scene.toml:2:1: `up` in [camera] is parallel to the viewing direction: `up = [0, 0, 1]` would do",
    ),
    (
        "field of view of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 0
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `0`",
    ),
    (
        "field of view of 180",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 180.0
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `180.0`",
    ),
    (
        "negative field of view",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = -40
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `-40`",
    ),
    (
        "field of view that 32 bits lose",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 1e-60
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be at least 0.001 and at most 179.999, not `1e-60`",
    ),
    (
        "field of view that 32 bits round up",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 179.999999999
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be at least 0.001 and at most 179.999, not `179.999999999`",
    ),
    (
        "negative aperture",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
aperture_radius = -0.1
",
        "scene.toml:6:19: `aperture_radius` in [camera] must be 0 or more, not `-0.1`",
    ),
    (
        "focus distance of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = 0
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `0`",
    ),
    (
        "negative focus distance",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = -1
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `-1`",
    ),
    (
        "focus distance that is not a number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = nan
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `nan`",
    ),
];
