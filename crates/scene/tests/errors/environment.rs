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
        "scene.toml:6:1: [environment] is empty: give it `color`, or `horizon` and `zenith`, or `image`, or `sun_direction`, or `latitude_degrees`, `longitude_degrees` and `time`",
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
        "scene.toml:7:1: `rotation_degrees` in [environment] needs `image`, `sun_direction` or `time` beside it",
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
        "scene.toml:7:1: `intensity` in [environment] needs `image`, `sun_direction` or `time` beside it",
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
    (
        "sun below the horizon",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
sun_direction = [1, -0.1, 0]
"#,
        "scene.toml:7:17: `sun_direction` in [environment] points below the horizon, where the sky by day is not known: its y must be 0 or more",
    ),
    (
        "sun without a direction",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
sun_direction = [0, 0, 0]
"#,
        "scene.toml:7:17: `sun_direction` in [environment] must not be zero: it gives a direction",
    ),
    (
        "night",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
latitude_degrees = 48.2
longitude_degrees = 16.4
time = 2026-06-21T00:00:00Z
"#,
        "scene.toml:9:8: the sun is 16.9 degrees below the horizon at this `time` in [environment], and the sky is known by day alone: choose a time between sunrise and sunset",
    ),
    (
        "place without a time",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
latitude_degrees = 48.2
longitude_degrees = 16.4
"#,
        "scene.toml:7:1: `latitude_degrees` in [environment] needs `time` beside it",
    ),
    (
        "time without an offset",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
latitude_degrees = 48.2
longitude_degrees = 16.4
time = 2026-06-21T12:00:00
"#,
        "scene.toml:9:8: `time` in [environment] must be a date and time with its offset, such as 2026-06-21T17:30:00+02:00, not `2026-06-21T12:00:00`",
    ),
    (
        "time as a number",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
latitude_degrees = 48.2
longitude_degrees = 16.4
time = 12
"#,
        "scene.toml:9:8: `time` in [environment] must be a date and time with its offset, such as 2026-06-21T17:30:00+02:00, not `12`",
    ),
    (
        "latitude beyond the pole",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
latitude_degrees = 91
longitude_degrees = 16.4
time = 2026-06-21T12:00:00Z
"#,
        "scene.toml:7:20: `latitude_degrees` in [environment] must be between -90 and 90, not `91`: south of the equator it is negative",
    ),
    (
        "turbidity of air thicker than known",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
sun_direction = [1, 1, 0]
turbidity = 11
"#,
        "scene.toml:8:13: `turbidity` in [environment] must be between 1 and 10, not `11`: a clear day has about 3, a hazy one 6",
    ),
    (
        "turbidity alone",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
turbidity = 3
"#,
        "scene.toml:7:1: `turbidity` in [environment] needs `sun_direction` or `time` beside it",
    ),
    (
        "turbidity of an image",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
image = "sky.hdr"
turbidity = 3
"#,
        "scene.toml:8:1: `turbidity` in [environment] needs `sun_direction` or `time` beside it",
    ),
    (
        "two suns",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
sun_direction = [1, 1, 0]
time = 2026-06-21T12:00:00Z
"#,
        "scene.toml:7:1: `sun_direction` in [environment] cannot stand beside `latitude_degrees`, `longitude_degrees` and `time`: keep one or the other",
    ),
];
