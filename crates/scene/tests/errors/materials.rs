//! Materials.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "too bright together",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emission_color = [1e6, 0, 0]
emission_strength = 1e6
",
        "scene.toml:8:21: `emission_strength` times `emission_color` in [materials.red] must be at most 1e9",
    ),
    (
        "a colour of a body without a surface",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.fog]
medium = { scattering = 1 }
color = [1, 1, 1]
"#,
        r#"scene.toml:8:1: `color` in [materials.fog] is of a surface, and a body with a `medium` has none without `refractive_index`: leave out `color`, or give it a `refractive_index`"#,
    ),
    (
        "a medium behind an opaque surface",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.wax]
principled = { roughness = 0.5 }
medium = { scattering = 1 }
"#,
        r#"scene.toml:8:1: `medium` in [materials.wax] is behind a `principled` surface that lets no light in: give it a `transmission`"#,
    ),
    (
        "a medium behind a sheet",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.wax]
principled = { transmission = 1, thin_walled = true }
medium = { scattering = 1 }
"#,
        r#"scene.toml:8:1: `medium` in [materials.wax] is behind a `principled` surface that lets no light in: leave out `thin_walled`"#,
    ),
    (
        "a medium that gives light",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.fog]
medium = { scattering = [1, -2, 1] }
"#,
        r#"scene.toml:7:25: `scattering` in [materials.fog.medium] must be a number, or three numbers, of 0 or more, not `[1, -2, 1]`"#,
    ),
    (
        "a medium that scatters forward alone",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[air]
anisotropy = 1
"#,
        r#"scene.toml:7:14: `anisotropy` in [air] must be between -0.999 and 0.999, not `1`: 0 scatters to all sides alike, more goes forward, less goes back"#,
    ),
    (
        "a medium in another's words",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[air]
sigma_s = 1
"#,
        r#"scene.toml:7:1: unknown key `sigma_s` in [air]: did you mean `scattering`?"#,
    ),
    (
        "a coefficient as a word",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.fog]
medium = { scattering = "much" }
"#,
        r#"scene.toml:7:25: `scattering` in [materials.fog.medium] must be a number, or three numbers, of 0 or more, not `"much"`"#,
    ),
    (
        "color above 1",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = [1, 1.5, 1]
",
        "scene.toml:7:13: component 2 of `color` in [materials.red] must be between 0 and 1, not `1.5`: a surface reflects no more light than it gets; brightness is `emission_strength`",
    ),
    (
        "color below 0",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = [1, 1, -0.5]
",
        "scene.toml:7:16: component 3 of `color` in [materials.red] must be between 0 and 1, not `-0.5`: a surface reflects no more light than it gets; brightness is `emission_strength`",
    ),
    (
        "color as a word",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = "red"
"#,
        "scene.toml:7:9: `color` in [materials.red] must be a colour, not `\"red\"`: write `\"#rrggbb\"`, three pairs of hexadecimal digits, or `\"#rgb\"`",
    ),
    (
        "negative emission color",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emission_color = [-1, 1, 1]
",
        "scene.toml:7:19: component 1 of `emission_color` in [materials.red] must be 0 or more, not `-1`",
    ),
    (
        "negative emission",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emission_strength = -1
",
        "scene.toml:7:21: `emission_strength` in [materials.red] must be 0 or more, not `-1`",
    ),
    (
        "infinite emission",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emission_strength = inf
",
        "scene.toml:7:21: `emission_strength` in [materials.red] must be at most 1e9, not `inf`",
    ),
    (
        "smoothness above 1",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
smoothness = 1.01
",
        "scene.toml:7:14: `smoothness` in [materials.red] must be between 0 and 1, not `1.01`",
    ),
    (
        "smoothness below 0",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
smoothness = -1
",
        "scene.toml:7:14: `smoothness` in [materials.red] must be between 0 and 1, not `-1`",
    ),
    (
        "smoothness that is not a number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
smoothness = nan
",
        "scene.toml:7:14: `smoothness` in [materials.red] must be between 0 and 1, not `nan`",
    ),
    (
        "refractive index of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 0
",
        "scene.toml:7:20: `refractive_index` in [materials.red] must be between 0.1 and 10, not `0`: air has 1, water 1.33, glass 1.5, diamond 2.42",
    ),
    (
        "refractive index too large",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 15
",
        "scene.toml:7:20: `refractive_index` in [materials.red] must be between 0.1 and 10, not `15`: air has 1, water 1.33, glass 1.5, diamond 2.42",
    ),
    (
        "reflection of another name",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 1.5
reflection = "fresnal"
"#,
        r#"scene.toml:8:14: `reflection` in [materials.red] must be `"fresnel"` or a probability between 0 and 1, not `"fresnal"`"#,
    ),
    (
        "reflection above 1",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 1.5
reflection = 2
",
        r#"scene.toml:8:14: `reflection` in [materials.red] must be `"fresnel"` or a probability between 0 and 1, not `2`"#,
    ),
    (
        "reflection in a list",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 1.5
reflection = [1]
",
        r#"scene.toml:8:14: `reflection` in [materials.red] must be `"fresnel"` or a probability between 0 and 1, not `[1]`"#,
    ),
    (
        "priority between two",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 1.5
priority = 0.5
",
        "scene.toml:8:12: `priority` in [materials.red] must be a whole number, not `0.5`",
    ),
    (
        "priority too large",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
refractive_index = 1.5
priority = 3000000000
",
        "scene.toml:8:12: `priority` in [materials.red] must be at least -2147483648 and at most 2147483647, not `3000000000`",
    ),
];
