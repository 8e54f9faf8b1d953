//! The principled material.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "unknown key",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
baseColor = [1, 1, 1]
",
        "scene.toml:7:1: unknown key `baseColor` in [materials.a.principled]: did you mean `base_color`?",
    ),
    (
        "misspelt texture",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normalmap = "a.png"
"#,
        "scene.toml:7:1: unknown key `normalmap` in [materials.a.principled]: did you mean `normal_map`?",
    ),
    (
        "too reflective",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color = [1, 1.5, 1]
",
        "scene.toml:7:18: component 2 of `base_color` in [materials.a.principled] must be between 0 and 1, not `1.5`",
    ),
    (
        "too metallic",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
metallic = 2
",
        "scene.toml:7:12: `metallic` in [materials.a.principled] must be between 0 and 1, not `2`",
    ),
    (
        "rarer than vacuum",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
ior = 0.9
",
        "scene.toml:7:7: `ior` in [materials.a.principled] must be between 1 and 10, not `0.9`: water has 1.33, glass 1.5, diamond 2.42",
    ),
    (
        "absorbing at once",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
attenuation_distance = 0
",
        "scene.toml:7:24: `attenuation_distance` in [materials.a.principled] must be greater than 0, not `0`",
    ),
    (
        "alpha mode",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
alpha_mode = "BLEND"
"#,
        "scene.toml:7:14: `alpha_mode` in [materials.a.principled] must be `\"opaque\"`, `\"mask\"` or `\"blend\"`, not `\"BLEND\"`",
    ),
    (
        "too bright",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
emissive = [1e5, 0, 0]
emissive_strength = 1e5
",
        "scene.toml:8:21: `emissive_strength` times `emissive` in [materials.a.principled] must be at most 1e9",
    ),
    (
        "sheet of paper",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
thin_walled = 1
",
        "scene.toml:7:15: `thin_walled` in [materials.a.principled] must be `true` or `false`, not `1`",
    ),
    (
        "texture that is not there",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = "wood.png"
"#,
        "scene.toml:7:22: wood.png: there is no such file",
    ),
    (
        "texture in a table that is not there",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { image = "wood.png", uv_set = 1 }
"#,
        "scene.toml:7:32: wood.png: there is no such file",
    ),
    (
        "texture without image",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { uv_set = 1 }
",
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] needs `image` or `checker`",
    ),
    (
        "texture by number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = 3
",
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] must be the path of an image, or a table with `image` or `checker`, not `3`",
    ),
    (
        "texture list",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = ["wood.png"]
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] must be the path of an image, or a table with `image` or `checker`, not `[\"wood.png\"]`",
    ),
    (
        "no picture at all",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { uv_set = 1 }
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] needs `image` or `checker`",
    ),
    (
        "two pictures",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { image = "a.png", checker = [[0, 0, 0], [1, 1, 1]] }
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] has both `image` and `checker`: choose one of them",
    ),
    (
        "a checkerboard with edges",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { checker = [[0, 0, 0], [1, 1, 1]], wrap = "repeat" }
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] is a checkerboard, which has no edge: leave out `wrap`",
    ),
    (
        "a checkerboard with texels",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { checker = [[0, 0, 0], [1, 1, 1]], filter = "nearest" }
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] is a checkerboard, which has no texels: leave out `filter`",
    ),
    (
        "a checkerboard of one colour",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
base_color_texture = { checker = [[0, 0, 0]] }
"#,
        "scene.toml:7:22: `base_color_texture` in [materials.a.principled] needs 2 to 16 colours in `checker`, not 1",
    ),
    (
        "third set of coordinates",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normal_map = { image = "a.png", uv_set = 2 }
"#,
        "scene.toml:7:42: `uv_set` in [materials.a.principled.normal_map] must be at least 0 and at most 1, not `2`",
    ),
    (
        "unknown key of a texture",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normal_map = { image = "a.png", rotation = 90 }
"#,
        "scene.toml:7:33: unknown key `rotation` in [materials.a.principled.normal_map]: did you mean `rotation_degrees`?",
    ),
    (
        "unknown wrap",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normal_map = { image = "a.png", wrap = "clamp" }
"#,
        "scene.toml:7:40: `wrap` in [materials.a.principled.normal_map] must be `\"repeat\"`, `\"mirrored_repeat\"`, `\"clamp_to_edge\"`, or a list of two of them, not `\"clamp\"`",
    ),
    (
        "offset with three numbers",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normal_map = { image = "a.png", offset = [1, 2, 3] }
"#,
        "scene.toml:7:42: `offset` in [materials.a.principled.normal_map] must be a list of 2 numbers, not of 3",
    ),
    (
        "unknown filter",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a.principled]
normal_map = { image = "a.png", filter = "cubic" }
"#,
        "scene.toml:7:42: `filter` in [materials.a.principled.normal_map] must be `\"linear\"` or `\"nearest\"`, not `\"cubic\"`",
    ),
    (
        "not a table",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a]
principled = 1
",
        "scene.toml:7:14: `principled` in [materials.a] must be a table, not `1`",
    ),
    (
        "a colour beside it",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a]
color = [1, 1, 1]
principled = {}
",
        "scene.toml:7:1: `color` in [materials.a] cannot stand beside `principled`: keep one or the other, or write `base_color` inside `principled`",
    ),
    (
        "a strength beside it",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.a]
principled = {}
emission_strength = 0
",
        "scene.toml:8:1: `emission_strength` in [materials.a] cannot stand beside `principled`: keep one or the other, or write `emissive_strength` inside `principled`",
    ),
    (
        "a priority beside it",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials."a b"]
principled = {}
priority = 1
"#,
        "scene.toml:8:1: `priority` in [materials.\"a b\"] cannot stand beside `principled`: keep one or the other, or write `priority` inside `principled`",
    ),
];
