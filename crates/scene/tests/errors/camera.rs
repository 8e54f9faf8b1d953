//! [camera].

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "no camera",
        "version = 1
",
        "scene.toml:1:1: [camera] is missing: a scene needs one, with `position`, `look_at` and `vertical_fov_degrees`",
    ),
    (
        "no position",
        "version = 1
[render]
[camera]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:1: `position` is missing in [camera]",
    ),
    (
        "no look_at",
        "version = 1
[camera]
position = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:2:1: `look_at` is missing in [camera]",
    ),
    (
        "no field of view",
        "version = 1
[camera]
position = [0, 1, 0]
look_at = [0, 1, 4]
",
        "scene.toml:2:1: `vertical_fov_degrees` is missing in [camera]; `intrinsics`, `orthographic_height` or `panorama` could stand in its place",
    ),
    (
        "no field of view, dotted",
        "version = 1
camera.position = [0, 1, 0]
camera.look_at = [0, 1, 4]
",
        "scene.toml:2:1: `vertical_fov_degrees` is missing in [camera]; `intrinsics`, `orthographic_height` or `panorama` could stand in its place",
    ),
    (
        "no field of view, inline",
        "version = 1
camera = { position = [0, 1, 0], look_at = [0, 1, 4] }
",
        "scene.toml:2:10: `vertical_fov_degrees` is missing in [camera]; `intrinsics`, `orthographic_height` or `panorama` could stand in its place",
    ),
    (
        "nan",
        "version = 1
[camera]
position = [0, nan, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:16: component 2 of `position` in [camera] must be a finite number, not `nan`",
    ),
    (
        "infinite",
        "version = 1
[camera]
position = [0, 1, -inf]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:19: component 3 of `position` in [camera] must be a finite number, not `-inf`",
    ),
    (
        "infinite when read",
        "version = 1
[camera]
position = [0, 1, 1e400]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:3:19: component 3 of `position` in [camera] must be a finite number, not `1e400`",
    ),
    (
        "infinite in 32 bits",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [1e300, 1, 0]
vertical_fov_degrees = 40
",
        "scene.toml:4:12: component 1 of `look_at` in [camera] must be at most 1e15 in size, not `1e300`",
    ),
    (
        "looks at itself",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 4]
vertical_fov_degrees = 40
",
        "scene.toml:4:11: `look_at` in [camera] is the same point as `position`: move one of them, so that the camera looks somewhere",
    ),
    (
        "looks at itself in 32 bits",
        "version = 1
[camera]
position = [1e10, 0, 0]
look_at = [10000000001, 0, 0]
vertical_fov_degrees = 40
",
        "scene.toml:4:11: `look_at` in [camera] is the same point as `position`: move one of them, so that the camera looks somewhere",
    ),
    (
        "up is zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
up = [0, 0, 0]
",
        "scene.toml:6:6: `up` in [camera] is zero: `up = [0, 1, 0]` would do",
    ),
    (
        "up is parallel",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
up = [0, 0, -2]
",
        "scene.toml:6:6: `up` in [camera] is parallel to the viewing direction: `up = [0, 1, 0]` would do",
    ),
    (
        "default up is parallel",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 8, 4]
vertical_fov_degrees = 40
",
        "scene.toml:2:1: `up` in [camera] is parallel to the viewing direction: `up = [0, 0, 1]` would do",
    ),
    (
        "field of view of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 0
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `0`",
    ),
    (
        "field of view of 180",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 180.0
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `180.0`",
    ),
    (
        "negative field of view",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = -40
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be greater than 0 and less than 180, not `-40`",
    ),
    (
        "field of view that 32 bits lose",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 1e-60
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be at least 0.001 and at most 179.999, not `1e-60`",
    ),
    (
        "field of view that 32 bits round up",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 179.999999999
",
        "scene.toml:5:24: `vertical_fov_degrees` in [camera] must be at least 0.001 and at most 179.999, not `179.999999999`",
    ),
    (
        "negative aperture",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
aperture_radius = -0.1
",
        "scene.toml:6:19: `aperture_radius` in [camera] must be 0 or more, not `-0.1`",
    ),
    (
        "focus distance of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = 0
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `0`",
    ),
    (
        "negative focus distance",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = -1
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `-1`",
    ),
    (
        "focus distance that is not a number",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
focus_distance = nan
",
        "scene.toml:6:18: `focus_distance` in [camera] must be greater than 0, not `nan`",
    ),
    (
        "an angle and a height",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
orthographic_height = 2
",
        "scene.toml:6:1: `orthographic_height` in [camera] cannot stand beside `vertical_fov_degrees`: keep one or the other",
    ),
    (
        "an angle and a panorama",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
panorama = \"latitude-longitude\"
vertical_fov_degrees = 40
",
        "scene.toml:5:1: `panorama` in [camera] cannot stand beside `vertical_fov_degrees`: keep one or the other",
    ),
    (
        "intrinsics and a height",
        "version = 1
camera = { position = [0, 1, 4], look_at = [0, 1, 0], orthographic_height = 1, intrinsics = { focal = [1, 1], size = [2, 2] } }
",
        "scene.toml:2:55: `orthographic_height` in [camera] cannot stand beside `intrinsics`: keep one or the other",
    ),
    (
        "a panorama with a lens",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
panorama = \"latitude-longitude\"
aperture_radius = 0.1
",
        "scene.toml:6:1: `aperture_radius` in [camera] cannot stand beside `panorama`, which has no lens: leave it out",
    ),
    (
        "a panorama in focus",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
panorama = \"latitude-longitude\"
focus_distance = 1
",
        "scene.toml:6:1: `focus_distance` in [camera] cannot stand beside `panorama`, which has no lens: leave it out",
    ),
    (
        "an unknown panorama",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
panorama = \"fisheye\"
",
        "scene.toml:5:12: `panorama` in [camera] must be `\"latitude-longitude\"`, not `\"fisheye\"`",
    ),
    (
        "a panorama that is a truth",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
panorama = true
",
        "scene.toml:5:12: `panorama` in [camera] must be `\"latitude-longitude\"`, not `true`",
    ),
    (
        "a height of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
orthographic_height = 0
",
        "scene.toml:5:23: `orthographic_height` in [camera] must be greater than 0, not `0`",
    ),
    (
        "intrinsics without a size",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [50, 50] }
",
        "scene.toml:5:14: `size` is missing in [camera.intrinsics]",
    ),
    (
        "one focal length",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
[camera.intrinsics]
focal = [50]
size = [40, 30]
",
        "scene.toml:6:9: `focal` in [camera.intrinsics] must be a list of 2 numbers, not of 1",
    ),
    (
        "a focal length of zero",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [50, 0], size = [40, 30] }
",
        "scene.toml:5:29: component 2 of `focal` in [camera.intrinsics] must be greater than 0, not `0`",
    ),
    (
        "a focal length that is no camera's",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [1e-4, 1], size = [40, 30] }
",
        "scene.toml:5:25: component 1 of `focal` in [camera.intrinsics] must be at least 0.001 and at most 1e9, not `1e-4`: it is in pixels",
    ),
    (
        "a skew that is no camera's",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [50, 50], skew = -501, size = [40, 30] }
",
        "scene.toml:5:41: `skew` in [camera.intrinsics] must be at most 10 times the focal length across in size, not `-501`",
    ),
    (
        "a size in fractions",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [50, 50], size = [40, 30.5] }
",
        "scene.toml:5:46: component 2 of `size` in [camera.intrinsics] must be a whole number, not `30.5`",
    ),
    (
        "intrinsics by other names",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
intrinsics = { focal = [50, 50], size = [40, 30], cx = 20 }
",
        "scene.toml:5:51: unknown key `cx` in [camera.intrinsics]: did you mean `principal_point`?",
    ),
    (
        "a kind of camera",
        "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
projection = \"orthographic\"
orthographic_height = 2
",
        "scene.toml:5:1: unknown key `projection` in [camera]: one of `vertical_fov_degrees`, `intrinsics`, `orthographic_height` and `panorama` says what kind of camera it is",
    ),
];
