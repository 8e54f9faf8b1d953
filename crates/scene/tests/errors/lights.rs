//! Lights.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no kind",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
"#,
        "scene.toml:6:1: light 1 is of no kind: give it one of `point`, `spot`, `directional`",
    ),
    (
        "two kinds",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
spot = { position = [0, 0, 0], direction = [0, 0, 1] }
point = { position = [0, 0, 0] }
"#,
        "scene.toml:7:1: light 1 is both `point` and `spot`: write a `[[lights]]` for each",
    ),
    (
        "a table for the list",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[lights]
point = { position = [0, 0, 0] }
"#,
        "scene.toml:6:1: `lights` must be a list, written `[[lights]]`, not a table",
    ),
    (
        "no position",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
point = { intensity = 1 }
"#,
        "scene.toml:7:9: `position` is missing in `point` of light 1",
    ),
    (
        "zero direction",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
point = { position = [0, 0, 0] }
[[lights]]
directional = { direction = [0, 0, 0] }
"#,
        "scene.toml:9:29: `direction` in `directional` of light 2 must not be zero: it gives a direction",
    ),
    (
        "negative intensity",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
point = { position = [0, 0, 0], intensity = -1 }
"#,
        "scene.toml:7:45: `intensity` in `point` of light 1 must be 0 or more, not `-1`",
    ),
    (
        "crossed angles",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
spot = { position = [0, 0, 0], direction = [0, 0, 1], inner_degrees = 30, outer_degrees = 20 }
"#,
        "scene.toml:7:71: `inner_degrees` in `spot` of light 1 is 30, and must not be more than `outer_degrees`, which is 20",
    ),
    (
        "inner angle beyond the default",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
spot = { position = [0, 0, 0], direction = [0, 0, 1], inner_degrees = 60 }
"#,
        "scene.toml:7:71: `inner_degrees` in `spot` of light 1 is 60, and must not be more than `outer_degrees`, which is 45 by default",
    ),
    (
        "a cone beyond a right angle",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
spot = { position = [0, 0, 0], direction = [0, 0, 1], outer_degrees = 120 }
"#,
        "scene.toml:7:71: `outer_degrees` in `spot` of light 1 must be between 0 and 90, not `120`: it is counted from the axis",
    ),
    (
        "a sun too small",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
directional = { direction = [0, -1, 0], angle_degrees = 0.001 }
"#,
        "scene.toml:7:57: `angle_degrees` in `directional` of light 1 must be 0, or at least 0.01 and at most 180, not `0.001`: the sun's is 0.53, seen from the earth",
    ),
    (
        "a sun too bright",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
directional = { direction = [0, -1, 0], angle_degrees = 0.5, intensity = 1e6 }
"#,
        "scene.toml:7:57: `angle_degrees` in `directional` of light 1 makes a disk of the radiance 1.7e10, and at most 1e10 can be rendered: a width of 0.65 or more would do, or a lower `intensity`",
    ),
    (
        "too bright",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
point = { position = [0, 0, 0], color = [2, 1, 1], intensity = 1e9 }
"#,
        "scene.toml:7:64: `intensity` times `color` in `point` of light 1 must be at most 1e9",
    ),
    (
        "a radius",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
point = { position = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:7:33: unknown key `radius` in `point` of light 1: a light with a size is a `sphere` whose material has an `emission_strength`",
    ),
    (
        "a sun by another name",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
sun = { direction = [0, -1, 0] }
"#,
        "scene.toml:7:1: unknown key `sun` in light 1: did you mean `directional`?",
    ),
    (
        "angle",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
directional = { direction = [0, -1, 0], angle = 1 }
"#,
        "scene.toml:7:41: unknown key `angle` in `directional` of light 1: did you mean `angle_degrees`?",
    ),
    (
        "flat keys",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[lights]]
type = "point"
"#,
        "scene.toml:7:1: unknown key `type` in light 1: a light's kind is a table of its own, as in `point = { position = [0, 2, 0], intensity = 5 }`",
    ),
];
