//! Keys that other programs have.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "index of refraction",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
ior = 1.5
"#,
        r#"scene.toml:7:1: unknown key `ior` in [materials.red]: did you mean `refractive_index`?"#,
    ),
    (
        "albedo",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
albedo = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `albedo` in [materials.red]: did you mean `color`?"#,
    ),
    (
        "base_color",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
base_color = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `base_color` in [materials.red]: did you mean `color`?"#,
    ),
    (
        "baseColor",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
baseColor = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `baseColor` in [materials.red]: did you mean `color`?"#,
    ),
    (
        "diffuse",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
diffuse = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `diffuse` in [materials.red]: did you mean `color`?"#,
    ),
    (
        "emission",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emission = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `emission` in [materials.red]: the light given off is `emission_color` times `emission_strength`"#,
    ),
    (
        "emissive",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emissive = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `emissive` in [materials.red]: the light given off is `emission_color` times `emission_strength`"#,
    ),
    (
        "emissive strength",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
emissive_strength = 2
"#,
        r#"scene.toml:7:1: unknown key `emissive_strength` in [materials.red]: did you mean `emission_strength`?"#,
    ),
    (
        "metallic",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
metallic = 1
"#,
        r#"scene.toml:7:1: unknown key `metallic` in [materials.red]: that is a key of `principled`: write `principled = { metallic = ... }`"#,
    ),
    (
        "metalness",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
metalness = 1
"#,
        r#"scene.toml:7:1: unknown key `metalness` in [materials.red]: that is a key of `principled`: write `principled = { metallic = ... }`"#,
    ),
    (
        "roughness",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
roughness = 1
"#,
        r#"scene.toml:7:1: unknown key `roughness` in [materials.red]: `smoothness` is its opposite, 1 for a mirror; or write `principled = { roughness = ... }`"#,
    ),
    (
        "transmission",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
transmission = 1
"#,
        r#"scene.toml:7:1: unknown key `transmission` in [materials.red]: glass has a `refractive_index`; or write `principled = { transmission = ... }`"#,
    ),
    (
        "color texture",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color_texture = "a.png"
"#,
        r#"scene.toml:7:1: unknown key `color_texture` in [materials.red]: that is a key of `principled`: write `principled = { base_color_texture = ... }`"#,
    ),
    (
        "base color texture",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
base_color_texture = "a.png"
"#,
        r#"scene.toml:7:1: unknown key `base_color_texture` in [materials.red]: that is a key of `principled`: write `principled = { base_color_texture = ... }`"#,
    ),
    (
        "clearcoat",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
clearcoat = 1
"#,
        r#"scene.toml:7:1: unknown key `clearcoat` in [materials.red]: that is a key of `principled`: write `principled = { clearcoat = ... }`"#,
    ),
    (
        "normal map",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
normalMap = "a.png"
"#,
        r#"scene.toml:7:1: unknown key `normalMap` in [materials.red]: that is a key of `principled`: write `principled = { normal_map = ... }`"#,
    ),
    (
        "kind",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
type = "glass"
"#,
        r#"scene.toml:7:1: unknown key `type` in [materials.red]: a material's keys say what it is, such as `smoothness` or `refractive_index`"#,
    ),
    (
        "color in principled",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
color = [1, 0, 0]
"#,
        r#"scene.toml:7:1: unknown key `color` in [materials.red.principled]: did you mean `base_color`?"#,
    ),
    (
        "metalness in principled",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
metalness = 1
"#,
        r#"scene.toml:7:1: unknown key `metalness` in [materials.red.principled]: did you mean `metallic`?"#,
    ),
    (
        "refractive index in principled",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
refractive_index = 1.5
"#,
        r#"scene.toml:7:1: unknown key `refractive_index` in [materials.red.principled]: did you mean `ior`?"#,
    ),
    (
        "smoothness in principled",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
smoothness = 1
"#,
        r#"scene.toml:7:1: unknown key `smoothness` in [materials.red.principled]: `roughness` is its opposite, 0 for a mirror"#,
    ),
    (
        "emission in principled",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
emission_color = [1, 1, 1]
"#,
        r#"scene.toml:7:1: unknown key `emission_color` in [materials.red.principled]: did you mean `emissive`?"#,
    ),
    (
        "opacity",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
opacity = 0.5
"#,
        r#"scene.toml:7:1: unknown key `opacity` in [materials.red.principled]: did you mean `alpha`?"#,
    ),
    (
        "samples",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
spp = 16
"#,
        r#"scene.toml:7:1: unknown key `spp` in [render]: did you mean `samples`?"#,
    ),
    (
        "integrator",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
integrator = "path"
"#,
        r#"scene.toml:7:1: unknown key `integrator` in [render]: that is an option of `raggio render`, not a key of the scene"#,
    ),
    (
        "size",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
resolution = [640, 480]
"#,
        r#"scene.toml:7:1: unknown key `resolution` in [render]: the size is `width` and `height`"#,
    ),
    (
        "sky file",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
file = "sky.hdr"
"#,
        r#"scene.toml:7:1: unknown key `file` in [environment]: did you mean `image`?"#,
    ),
    (
        "in shapes",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
cube = { center = [0, 0, 0], size = [1, 1, 1] }
[[shapes]]
material = "red"
sphere = { position = [0, 0, 0], radius = 1 }
[[shapes]]
material = "red"
radius = 1
sphere = { center = [0, 0, 0], diameter = 1 }
"#,
        r#"scene.toml:9:1: unknown key `cube` in shape 1: did you mean `box`?
scene.toml:12:12: unknown key `position` in `sphere` of shape 2: did you mean `center`?
scene.toml:15:1: unknown key `radius` in shape 3: a shape's geometry is a table of its own, as in `sphere = { center = [0, 1, 0], radius = 1 }`
scene.toml:16:10: `radius` is missing in `sphere` of shape 3
scene.toml:16:32: unknown key `diameter` in `sphere` of shape 3: `radius` is half of it"#,
    ),
];
