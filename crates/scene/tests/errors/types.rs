//! Values of the wrong type.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "string for a whole number",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = "wide"
"#,
        "scene.toml:7:9: `width` in [render] must be a whole number, not a string",
    ),
    (
        "decimal for a whole number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 640.0
",
        "scene.toml:7:9: `width` in [render] must be a whole number, not `640.0`",
    ),
    (
        "boolean for a whole number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
samples = true
",
        "scene.toml:7:11: `samples` in [render] must be a whole number, not `true`",
    ),
    (
        "list for a whole number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
samples = [1]
",
        "scene.toml:7:11: `samples` in [render] must be a whole number, not a list",
    ),
    (
        "date for a whole number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
seed = 2020-01-01
",
        "scene.toml:7:8: `seed` in [render] must be a whole number, not a date",
    ),
    (
        "table for a whole number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width.x = 1
",
        "scene.toml:7:1: `width` in [render] must be a whole number, not a table",
    ),
    (
        "number for a boolean",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
surface_offset = 1
",
        "scene.toml:7:18: `surface_offset` in [render] must be `true` or `false`, not `1`",
    ),
    (
        "number for a name",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
filter = 1
",
        r#"scene.toml:7:10: `filter` in [render] must be `"box"`, `"blackman-harris"`, `"mitchell"` or `"point"`, not `1`"#,
    ),
    (
        "string for a point",
        r#"version = 1
[camera]
position = "here"
look_at = [0, 1, 0]
vertical_fov_degrees = 40
"#,
        "scene.toml:3:12: `position` in [camera] must be a list of 3 numbers, not a string",
    ),
    (
        "number for a point",
        "version = 1
[camera]
position = 3
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:12: `position` in [camera] must be a list of 3 numbers, not `3`",
    ),
    (
        "two numbers for a point",
        "version = 1
[camera]
position = [0, 1]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:12: `position` in [camera] must be a list of 3 numbers, not of 2",
    ),
    (
        "four numbers for a point",
        "version = 1
[camera]
position = [0, 1, 2, 3]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:12: `position` in [camera] must be a list of 3 numbers, not of 4",
    ),
    (
        "string in a point",
        r#"version = 1
[camera]
position = [0, "up", 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
"#,
        "scene.toml:3:16: component 2 of `position` in [camera] must be a number, not a string",
    ),
    (
        "string for a number",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = "wide"
"#,
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be a number, not a string",
    ),
    (
        "number for a table",
        "version = 1
camera = 3
",
        "scene.toml:2:10: `camera` must be a table, not `3`",
    ),
    (
        "list for a table",
        "version = 1
[[camera]]
",
        "scene.toml:2:1: `camera` must be a table, not a list",
    ),
    (
        "table for the list of shapes",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[shapes]
material = "red"
"#,
        "scene.toml:6:1: `shapes` must be a list, written `[[shapes]]`, not a table",
    ),
    (
        "number for the list of shapes",
        "shapes = 3
version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:1:10: `shapes` must be a list, not `3`",
    ),
    (
        "number for a shape",
        "shapes = [3]
version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:1:11: shape 1 must be a table, not `3`",
    ),
    (
        "number for a material",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials]
red = 3
",
        "scene.toml:7:7: `red` in [materials] must be a table, not `3`",
    ),
    (
        "list for the materials",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[materials]]
color = [1, 1, 1]
",
        "scene.toml:6:1: `materials` must be a table, not a list",
    ),
    (
        "number for a material's name",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = 3
",
        "scene.toml:8:12: `material` in shape 1 must be a string, not `3`",
    ),
    (
        "number for a sphere",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = 1
"#,
        "scene.toml:9:10: `sphere` in shape 1 must be a table, not `1`",
    ),
    (
        "string for a mesh's scale",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "a.ply", scale = "big" }
"#,
        r#"scene.toml:9:34: `scale` in `mesh` of shape 1 must be a number or three numbers, not `"big"`"#,
    ),
];
