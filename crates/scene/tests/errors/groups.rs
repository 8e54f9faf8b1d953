//! Groups and transforms.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "unknown group",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
group = "tree"
"#,
        "scene.toml:8:9: unknown group `tree` in shape 1: the scene has no groups, so add [[groups.tree]]",
    ),
    (
        "misspelt group",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.tree]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
[[shapes]]
group = "treee"
"#,
        "scene.toml:11:9: unknown group `treee` in shape 1: did you mean `tree`?",
    ),
    (
        "a group inside itself",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.a]]
group = "b"
[[groups.b]]
group = "a"
[[shapes]]
group = "a"
"#,
        "scene.toml:10:9: group `a` contains itself: leave it out here",
    ),
    (
        "a fault in a group is told once",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.a]]
material = "rod"
sphere = { center = [0, 0, 0], radius = 1 }
[[shapes]]
group = "a"
[[shapes]]
group = "a"
"#,
        "scene.toml:8:12: unknown material `rod` in shape 1 of group `a`: did you mean `red`?",
    ),
    (
        "a fault in a group that nobody names",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.a]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 0, 0] }
"#,
        "scene.toml:9:39: `normal` in `plane` of shape 1 of group `a` must not be zero: it gives a direction",
    ),
    (
        "a stretched sphere",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
transform = { scale = [1, 2, 1] }
"#,
        "scene.toml:10:23: `scale` in `transform` of shape 1 must be one factor, greater than 0: a sphere would not stay a sphere; only meshes can be stretched and mirrored",
    ),
    (
        "a mirrored group",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.a]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
[[shapes]]
group = "a"
transform = { scale = -1 }
"#,
        "scene.toml:12:23: `scale` in `transform` of shape 1 must be one factor, greater than 0: a sphere would not stay a sphere; only meshes can be stretched and mirrored",
    ),
    (
        "a scale of nothing",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
transform = { scale = 0 }
"#,
        "scene.toml:10:23: `scale` in `transform` of shape 1 must not be 0: nothing would be left",
    ),
    (
        "out of range",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], radius = 1 }
transform = { scale = 1e15, translation = [1e15, 0, 0] }
[[shapes]]
material = "red"
sphere = { center = [1, 0, 0], radius = 1 }
transform = { scale = 1e15, translation = [1e15, 0, 0] }
"#,
        "scene.toml:14:13: what is placed in `transform` of shape 2 is too large or too small: keep all of it within 1e15 of the origin",
    ),
    (
        "a table for a group",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[groups.a]
material = "red"
"#,
        "scene.toml:7:1: group `a` must be a list, written `[[groups.NAME]]`, not a table",
    ),
    (
        "both group and sphere",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[groups.a]]
material = "red"
[[shapes]]
group = "a"
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:7:1: shape 1 of group `a` has no geometry: give it one of `sphere`, `plane`, `rectangle`, `disk`, `cylinder`, `cone`, `box`, `mesh`, `group`
scene.toml:10:1: shape 1 has both `sphere` and `group`: write a `[[shapes]]` for each",
    ),
];
