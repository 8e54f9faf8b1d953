//! Colours.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no colour",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = true
"##,
        "scene.toml:7:9: `color` in [materials.red] must be a colour: 3 linear numbers, a text such as `\"#ff8800\"`, or `{ srgb = [1, 0.5, 0] }`, not `true`",
    ),
    (
        "a name",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = "red"
"##,
        "scene.toml:7:9: `color` in [materials.red] must be a colour, not `\"red\"`: write `\"#rrggbb\"`, three pairs of hexadecimal digits, or `\"#rgb\"`",
    ),
    (
        "four pairs",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = "#ff8800ff"
"##,
        "scene.toml:7:9: `color` in [environment] must be a colour, not `\"#ff8800ff\"`: write `\"#rrggbb\"`, three pairs of hexadecimal digits, or `\"#rgb\"`",
    ),
    (
        "two numbers",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = [1, 0]
"##,
        "scene.toml:7:9: `color` in [materials.red] must be a list of 3 numbers, not of 2",
    ),
    (
        "bytes as sRGB",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = { srgb = [255, 0, 0] }
"##,
        "scene.toml:7:19: component 1 of `srgb` in [materials.red.color] must be between 0 and 1, not `255`: sRGB of 255 steps is a text such as `\"#ff8800\"`",
    ),
    (
        "another space",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = { rgb = [1, 0, 0] }
"##,
        "scene.toml:7:11: unknown key `rgb` in [materials.red.color]: did you mean `srgb`?",
    ),
    (
        "two numbers as sRGB",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = { srgb = [1, 0] }
"##,
        "scene.toml:7:18: `srgb` in [materials.red.color] must be a list of 3 numbers, not of 2",
    ),
    (
        "a checkerboard",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
base_color_texture = { checker = ["#fff", "#12345"] }
"##,
        "scene.toml:7:43: component 2 of `checker` in [materials.red.principled.base_color_texture] must be a colour, not `\"#12345\"`: write `\"#rrggbb\"`, three pairs of hexadecimal digits, or `\"#rgb\"`",
    ),
    (
        "one colour of a checkerboard",
        r##"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red.principled]
base_color_texture = { checker = [[1, 0, 2], [0, 0, 0]] }
"##,
        "scene.toml:7:42: component 3 of component 1 of `checker` in [materials.red.principled.base_color_texture] must be between 0 and 1, not `2`",
    ),
];
