//! [environment].

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "empty",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
",
        "scene.toml:6:1: [environment] is empty: give it `color`, or `horizon` and `zenith`, or `image`",
    ),
    (
        "color and horizon",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
horizon = [1, 1, 1]
zenith = [1, 1, 1]
color = [1, 1, 1]
",
        "scene.toml:9:1: `color` in [environment] cannot stand beside `horizon` and `zenith`: keep one or the other",
    ),
    (
        "horizon alone",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
horizon = [1, 1, 1]
",
        "scene.toml:7:1: `horizon` in [environment] needs `zenith` beside it",
    ),
    (
        "zenith alone",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
zenith = [1, 1, 1]
",
        "scene.toml:7:1: `zenith` in [environment] needs `horizon` beside it",
    ),
    (
        "negative",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = [1, -1, 1]
",
        "scene.toml:7:13: component 2 of `color` in [environment] must be 0 or more, not `-1`",
    ),
    (
        "not a number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = [1, 1, nan]
",
        "scene.toml:7:16: component 3 of `color` in [environment] must be 0 or more, not `nan`",
    ),
    (
        "infinite",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
horizon = [inf, 1, 1]
",
        "scene.toml:7:12: component 1 of `horizon` in [environment] must be at most 1e9, not `inf`",
    ),
    (
        "image",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
image = "sky.hdr"
"#,
        "scene.toml:7:9: sky.hdr: there is no such file",
    ),
    (
        "image beside a color",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = [1, 1, 1]
image = "sky.hdr"
rotation_degrees = 90
"#,
        "scene.toml:7:1: `color` in [environment] cannot stand beside `image`: keep one or the other",
    ),
    (
        "rotation alone",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
rotation_degrees = 90
",
        "scene.toml:7:1: `rotation_degrees` in [environment] needs `image` beside it",
    ),
    (
        "intensity alone",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
intensity = 2
",
        "scene.toml:7:1: `intensity` in [environment] needs `image` beside it",
    ),
    (
        "image that is not a path",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
image = 3
",
        "scene.toml:7:9: `image` in [environment] must be a string, not `3`",
    ),
    (
        "image of negative intensity",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
image = "sky.hdr"
intensity = -1
"#,
        "scene.toml:8:13: `intensity` in [environment] must be 0 or more, not `-1`",
    ),
];
