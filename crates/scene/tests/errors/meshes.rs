//! Meshes; those whose files exist are in `tests/assets`.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "without file",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { scale = 2 }
"#,
        "scene.toml:9:8: `file` is missing in `mesh` of shape 1",
    ),
    (
        "of a file that is not there",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.ply", scale = [1, 2, 1] }
"#,
        "scene.toml:9:17: bunny.ply: there is no such file",
    ),
    (
        "of a folder that is not there",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "../nowhere/at/all.glb" }
"#,
        "scene.toml:9:17: ../nowhere/at/all.glb: there is no such file",
    ),
    (
        "of no model",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.png" }
"#,
        "scene.toml:9:17: bunny.png: is not a model: give a .gltf, .glb, .ply, .obj or .stl file",
    ),
    (
        "of nothing",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "" }
"#,
        "scene.toml:9:17: : is not a model: give a .gltf, .glb, .ply, .obj or .stl file",
    ),
    (
        "escaped",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "\u001b[2J.ply" }
"#,
        "scene.toml:9:17: \\u{1b}[2J.ply: there is no such file",
    ),
    (
        "scaled to nothing",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.ply", scale = 0 }
"#,
        "scene.toml:9:38: `scale` in `mesh` of shape 1 must not be 0: nothing would be left",
    ),
    (
        "flattened",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.ply", scale = [1, 0.0, 1] }
"#,
        "scene.toml:9:38: `scale` in `mesh` of shape 1 must not be 0: nothing would be left",
    ),
    (
        "scaled by a word",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.ply", scale = "big" }
"#,
        "scene.toml:9:38: `scale` in `mesh` of shape 1 must be a number or three numbers, not `\"big\"`",
    ),
    (
        "moved to infinity",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "bunny.ply", translation = [0, inf, 0] }
"#,
        "scene.toml:9:48: component 2 of `translation` in `mesh` of shape 1 must be a finite number, not `inf`",
    ),
    (
        "before its time",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "fox.glb", time = -1 }
"#,
        "scene.toml:9:35: `time` in `mesh` of shape 1 must be 0 or more, not `-1`",
    ),
    (
        "beside another geometry",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
mesh = { file = "bunny.ply" }
"#,
        "scene.toml:10:1: shape 1 has both `sphere` and `mesh`: write a `[[shapes]]` for each",
    ),
    (
        "of an unknown material",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "rad"
mesh = { file = "bunny.ply" }
"#,
        "scene.toml:8:12: unknown material `rad` in shape 1: did you mean `red`?
scene.toml:9:17: bunny.ply: there is no such file",
    ),
];
