//! Keys that the format does not have.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "misspelt in a material",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
colour = [1, 0, 0]
",
        "scene.toml:7:1: unknown key `colour` in [materials.red]: did you mean `color`?",
    ),
    (
        "misspelt in the camera",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus = 3
",
        "scene.toml:6:1: unknown key `focus` in [camera]: did you mean `focus_distance`?",
    ),
    (
        "misspelt table",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[enviroment]
",
        "scene.toml:6:2: unknown key `enviroment` at the top level of the scene: did you mean `environment`?",
    ),
    (
        "unlike every key",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
banana = 3
",
        "scene.toml:7:1: unknown key `banana` in [render]: choose from `width`, `height`, `samples`, `max_depth`, `seed`, `sampler`, `filter`, `clamp`, `alpha` and 1 more",
    ),
    (
        "unlike every key at the top",
        "version = 1
banana = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:2:1: unknown key `banana` at the top level of the scene: choose from `version`, `render`, `camera`, `environment`, `air`, `lights`, `materials`, `groups` and `shapes`",
    ),
    (
        "in a shape",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
spere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:9:1: unknown key `spere` in shape 1: did you mean `sphere`?",
    ),
    (
        "in a geometry",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
sphere = { center = [0, 0, 0], raduis = 1 }
"#,
        "scene.toml:9:32: unknown key `raduis` in `sphere` of shape 1: did you mean `radius`?",
    ),
    (
        "in a mesh",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[[shapes]]
material = "red"
mesh = { file = "a.ply", traslation = [0, 0, 0] }
"#,
        "scene.toml:9:26: unknown key `traslation` in `mesh` of shape 1: did you mean `translation`?",
    ),
    (
        "control characters are escaped",
        "version = 1\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n\"\\u001b[2J\" = 1\n",
        "scene.toml:6:1: unknown key `\\u{1b}[2J` in [camera]: choose from `position`, `look_at`, `up`, `vertical_fov_degrees`, `intrinsics`, `orthographic_height`, `panorama`, `aperture_radius`, `focus_distance` and 2 more",
    ),
    (
        "long names are cut",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk = 1
",
        "scene.toml:6:1: unknown key `kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk...` in [camera]: choose from `position`, `look_at`, `up`, `vertical_fov_degrees`, `intrinsics`, `orthographic_height`, `panorama`, `aperture_radius`, `focus_distance` and 2 more",
    ),
    (
        "a quoted material",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials."two words"]
shine = 1
"#,
        r#"scene.toml:7:1: unknown key `shine` in [materials."two words"]: choose from `color`, `emission_color`, `emission_strength`, `smoothness`, `refractive_index`, `reflection`, `priority`, `medium` and `principled`"#,
    ),
];
