//! Shapes.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no material",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
sphere = { center = [0, 0, 0], radius = 1 }
",
        "scene.toml:7:1: `material` is missing in shape 1",
    ),
    (
        "misspelt material",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "rad"
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:8:12: unknown material `rad` in shape 1: did you mean `red`?",
    ),
    (
        "unlike every material",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "glass"
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:8:12: unknown material `glass` in shape 1: choose from `red`",
    ),
    (
        "unlike many materials",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.m0]
[materials.m1]
[materials.m2]
[materials.m3]
[materials.m4]
[materials.m5]
[materials.m6]
[materials.m7]
[materials.m8]
[materials.m9]
[materials.m10]
[materials.m11]
[[shapes]]
material = "glass"
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:19:12: unknown material `glass` in shape 1: choose from `m0`, `m1`, `m2`, `m3`, `m4`, `m5`, `m6`, `m7`, `m8` and 3 more",
    ),
    (
        "no materials at all",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:7:12: unknown material `red` in shape 1: the scene has no materials, so add [materials.red]",
    ),
    (
        "no geometry",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
"#,
        "scene.toml:7:1: shape 1 has no geometry: give it one of `sphere`, `plane`, `rectangle`, `disk`, `cylinder`, `cone`, `box`, `mesh`, `group`",
    ),
    (
        "two geometries",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:9:1: shape 1 has both `sphere` and `plane`: write a `[[shapes]]` for each",
    ),
    (
        "second shape",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 0 }
"#,
        "scene.toml:12:41: `radius` in `sphere` of shape 2 must be greater than 0, not `0`",
    ),
    (
        "negative radius",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = -1 }
"#,
        "scene.toml:9:41: `radius` in `sphere` of shape 1 must be greater than 0, not `-1`",
    ),
    (
        "radius that 32 bits lose",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1e-60 }
"#,
        "scene.toml:9:41: `radius` in `sphere` of shape 1 must be at least 1e-15 and at most 1e15, not `1e-60`",
    ),
    (
        "radius that is not a number",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = nan }
"#,
        "scene.toml:9:41: `radius` in `sphere` of shape 1 must be greater than 0, not `nan`",
    ),
    (
        "infinite center",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, inf, 0], radius = 1 }
"#,
        "scene.toml:9:25: component 2 of `center` in `sphere` of shape 1 must be a finite number, not `inf`",
    ),
    (
        "no radius",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0] }
"#,
        "scene.toml:9:10: `radius` is missing in `sphere` of shape 1",
    ),
    (
        "zero normal",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 0, 0] }
"#,
        "scene.toml:9:39: `normal` in `plane` of shape 1 must not be zero: it gives a direction",
    ),
    (
        "normal that 32 bits lose",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 1e-60, 0] }
"#,
        "scene.toml:9:39: `normal` in `plane` of shape 1 is too short: it must be at least 1e-15 long",
    ),
    (
        "zero edge",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [0, 0, 0], edge_v = [0, 1, 0] }
"#,
        "scene.toml:9:44: `edge_u` in `rectangle` of shape 1 must not be zero: it gives a direction",
    ),
    (
        "other zero edge",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [0, 1, 0], edge_v = [0, 0, 0] }
"#,
        "scene.toml:9:64: `edge_v` in `rectangle` of shape 1 must not be zero: it gives a direction",
    ),
    (
        "edges at 60 degrees",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [1, 1.7320508, 0] }
"#,
        "scene.toml:9:64: `edge_u` and `edge_v` in `rectangle` of shape 1 meet at 60 degrees, not at 90: `edge_v = [0, 1.73205, 0]` would be perpendicular",
    ),
    (
        "edges just not perpendicular",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [0.00011, 1, 0] }
"#,
        "scene.toml:9:64: `edge_u` and `edge_v` in `rectangle` of shape 1 meet at 89.9937 degrees, not at 90: `edge_v = [0, 1, 0]` would be perpendicular",
    ),
    (
        "parallel edges",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [1, 2, 3], edge_v = [2, 4, 6] }
"#,
        "scene.toml:9:64: `edge_u` and `edge_v` in `rectangle` of shape 1 meet at 0 degrees, not at 90: point `edge_v` another way",
    ),
    (
        "flat box",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
box = { center = [0, 0, 0], size = [1, 0, 1] }
"#,
        "scene.toml:9:40: component 2 of `size` in `box` of shape 1 must be greater than 0, not `0`",
    ),
    (
        "negative box",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
box = { center = [0, 0, 0], size = [1, 1, -1] }
"#,
        "scene.toml:9:43: component 3 of `size` in `box` of shape 1 must be greater than 0, not `-1`",
    ),
    (
        "rotation that is not a number",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
box = { center = [0, 0, 0], size = [1, 1, 1], rotation_degrees = [nan, 0, 0] }
"#,
        "scene.toml:9:67: component 1 of `rotation_degrees` in `box` of shape 1 must be a finite number, not `nan`",
    ),
    (
        "zero normal of a disk",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
disk = { center = [0, 0, 0], normal = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:9:39: `normal` in `disk` of shape 1 must not be zero: it gives a direction",
    ),
    (
        "a cylinder without height",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
cylinder = { base = [1, 2, 3], top = [1, 2, 3], radius = 1 }
"#,
        "scene.toml:9:38: `top` in `cylinder` of shape 1 is the same point as `base`: without a height it is a `disk`",
    ),
    (
        "a cone on its head",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
cone = { base = [0, 0, 0], top = [0, 1, 0], radius = 1, top_radius = 2 }
"#,
        "scene.toml:9:70: `top_radius` in `cone` of shape 1 is 2, and must not be more than `radius`, which is 1: `base` is the wide end",
    ),
    (
        "an apex",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
cone = { base = [0, 0, 0], apex = [0, 1, 0], radius = 1 }
"#,
        "scene.toml:9:28: unknown key `apex` in `cone` of shape 1: did you mean `top`?",
    ),
    (
        "a tube",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
tube = { base = [0, 0, 0], top = [0, 1, 0], radius = 1 }
"#,
        "scene.toml:9:1: unknown key `tube` in shape 1: did you mean `cylinder`?",
    ),
];
