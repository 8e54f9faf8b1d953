//! [render] and the version.

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no version",
        "[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:1:1: `version` is missing: a scene file starts with `version = 1`",
    ),
    (
        "version 2, with keys of its own",
        "version = 2
[world]
",
        "scene.toml:1:11: `version` must be 1, not `2`: this program reads scene files of version 1 only",
    ),
    (
        "version as a string",
        r#"version = "1"
"#,
        "scene.toml:1:11: `version` must be a whole number, not a string",
    ),
    (
        "negative width",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = -5
",
        "scene.toml:7:9: `width` in [render] must be at least 1 and at most 65536, not `-5`",
    ),
    (
        "no width",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 0
",
        "scene.toml:7:9: `width` in [render] must be at least 1 and at most 65536, not `0`",
    ),
    (
        "width beyond the largest",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
width = 65537
",
        "scene.toml:7:9: `width` in [render] must be at least 1 and at most 65536, not `65537`",
    ),
    (
        "height beyond all whole numbers",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
height = 99999999999999999999999999999999999999999999
",
        "scene.toml:7:10: `height` in [render] must be at least 1 and at most 65536, not `99999999999999999999999999999999999999999999`",
    ),
    (
        "no samples",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
samples = 0
",
        "scene.toml:7:11: `samples` in [render] must be at least 1 and at most 2147483647, not `0`",
    ),
    (
        "samples beyond the largest",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
samples = 2147483648
",
        "scene.toml:7:11: `samples` in [render] must be at least 1 and at most 2147483647, not `2147483648`",
    ),
    (
        "negative depth",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
max_depth = -1
",
        "scene.toml:7:13: `max_depth` in [render] must be at least 0 and at most 65535, not `-1`",
    ),
    (
        "depth beyond the largest",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
max_depth = 65536
",
        "scene.toml:7:13: `max_depth` in [render] must be at least 0 and at most 65535, not `65536`",
    ),
    (
        "negative seed",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
seed = -1
",
        "scene.toml:7:8: `seed` in [render] must be at least 0 and at most 4294967295, not `-1`",
    ),
    (
        "seed beyond the largest",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
seed = 4294967296
",
        "scene.toml:7:8: `seed` in [render] must be at least 0 and at most 4294967295, not `4294967296`",
    ),
    (
        "unknown sampler",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
sampler = "halton"
"#,
        r#"scene.toml:7:11: `sampler` in [render] must be `"sobol"` or `"pcg"`, not `"halton"`"#,
    ),
    (
        "unknown filter",
        r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[render]
filter = "gauss"
"#,
        r#"scene.toml:7:10: `filter` in [render] must be `"box"`, `"blackman-harris"`, `"mitchell"` or `"point"`, not `"gauss"`"#,
    ),
];
