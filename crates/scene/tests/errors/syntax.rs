//! Text that is not TOML.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "unclosed string",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = "abc
"#,
        r#"scene.toml:7:13: not valid TOML: invalid basic string, expected `"`"#,
    ),
    (
        "missing value",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 
",
        "scene.toml:7:9: not valid TOML: a value is missing after `=`",
    ),
    (
        "missing equals sign",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width 3
",
        "scene.toml:7:7: not valid TOML: key with no value, expected `=`",
    ),
    (
        "bare word",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = white
",
        "scene.toml:7:9: not valid TOML: `white` is no value (a string stands in quotes)",
    ),
    (
        "unclosed list",
        "version = 1
[camera]
position = [0, 1, 4
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:4:1: not valid TOML: missing comma between array elements, expected `,`",
    ),
    (
        "unclosed header",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render
",
        "scene.toml:6:8: not valid TOML: unclosed table, expected `]`",
    ),
    (
        "two commas",
        "version = 1
[camera]
position = [0,, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:15: not valid TOML: extra comma in array, expected value",
    ),
    (
        "leading zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 0123
",
        "scene.toml:7:9: not valid TOML: unexpected leading zero",
    ),
    (
        "trailing text",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 1 2
",
        "scene.toml:7:9: not valid TOML: `1 2` is no value (a string stands in quotes)",
    ),
    (
        "duplicate key",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
color = [1, 1, 1]
color = [0, 0, 0]
",
        "scene.toml:8:1: `color` is given twice",
    ),
    (
        "duplicate table",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[camera]
",
        "scene.toml:6:2: `camera` is given twice",
    ),
    (
        "duplicate material",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.red]
[materials.red]
",
        "scene.toml:7:12: `red` is given twice",
    ),
    (
        "control character",
        "version = 1\n# \u{7}\n",
        "scene.toml:2:3: not valid TOML: invalid comment character, expected printable characters",
    ),
    (
        "number that is not one",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 1_
",
        "scene.toml:7:10: not valid TOML: `_` may only go between digits",
    ),
    (
        "nesting without end",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
a = [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[
",
        "scene.toml:6:85: not valid TOML: cannot recurse further; max recursion depth met",
    ),
    (
        "empty file",
        "",
        "scene.toml:1:1: `version` is missing: a scene file starts with `version = 1`
scene.toml:1:1: [camera] is missing: a scene needs one, with `position`, `look_at` and `vertical_fov_degrees`",
    ),
    (
        "columns count characters",
        r#"version = 1
ß = "ß"; x
"#,
        "scene.toml:2:8: not valid TOML: unexpected key or value, expected newline, `#`",
    ),
];
