//! Scenes with more than one mistake: all are told, in the order of the file, and none that comes of another.

use raggio_scene::Scene;

use super::Case;

/// Cases: name, text of the file, message of the error.
pub const CASES: &[Case] = &[
    (
        "one of each kind",
        r#"version = 1
[render]
width = "wide"
spp = 16
[camera]
position = [0, "up", nan]
look_at = [0, 1, 0]
fov = 40
[materials.red]
colour = [1, 0, 0]
smoothness = 2
[materials.wood.principled]
base_color_texture = "wood.png"
normal_map = "bumps.png"
[[shapes]]
material = "rad"
sphere = { center = [0, 1], radius = -1 }
[[shapes]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 0, 0] }
[[shapes]]
sphere = { raduis = 1 }
[[shapes]]
material = "red"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
sphere = { center = [0, 0, 0], radius = 1 }
"#,
        "scene.toml:3:9: `width` in [render] must be a whole number, not a string
scene.toml:4:1: unknown key `spp` in [render]: did you mean `samples`?
scene.toml:6:16: component 2 of `position` in [camera] must be a number, not a string
scene.toml:6:22: component 3 of `position` in [camera] must be a finite number, not `nan`
scene.toml:8:1: unknown key `fov` in [camera]: did you mean `vertical_fov_degrees`?
scene.toml:10:1: unknown key `colour` in [materials.red]: did you mean `color`?
scene.toml:11:14: `smoothness` in [materials.red] must be between 0 and 1, not `2`
scene.toml:13:22: wood.png: there is no such file
scene.toml:14:14: bumps.png: there is no such file
scene.toml:16:12: unknown material `rad` in shape 1: did you mean `red`?
scene.toml:17:21: `center` in `sphere` of shape 1 must be a list of 3 numbers, not of 2
scene.toml:17:38: `radius` in `sphere` of shape 1 must be greater than 0, not `-1`
scene.toml:20:39: `normal` in `plane` of shape 2 must not be zero: it gives a direction
scene.toml:21:1: `material` is missing in shape 3
scene.toml:22:10: `center` is missing in `sphere` of shape 3
scene.toml:22:12: unknown key `raduis` in `sphere` of shape 3: did you mean `radius`?
scene.toml:25:1: shape 4 has both `sphere` and `plane`: write a `[[shapes]]` for each",
    ),
    (
        "all that is missing",
        r#"# This scene is hardly begun.
[camera]
up = [0, 1, 0]
[materials.red]
[[shapes]]
material = "red"
rectangle = { edge_v = [0, 1, 0] }
[[shapes]]
mesh = {}
"#,
        "scene.toml:1:1: `version` is missing: a scene file starts with `version = 1`
scene.toml:2:1: `position` is missing in [camera]
scene.toml:2:1: `look_at` is missing in [camera]
scene.toml:7:13: `corner` is missing in `rectangle` of shape 1
scene.toml:7:13: `edge_u` is missing in `rectangle` of shape 1
scene.toml:9:8: `file` is missing in `mesh` of shape 2",
    ),
    (
        "nothing that comes of something else",
        r#"version = 1
[camera]
position = "here"
look_at = [1, 1, 1]
up = [1, 1, 1]
vertical_fov_degrees = 40
[environment]
horizon = [1, 1, 1]
zenit = [0, 0, 1]
[material.red]
color = [1, 0, 0]
[[shapes]]
material = "red"
sphere = 3
[[shapes]]
material = "red"
rectangle = { corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = "up" }
"#,
        "scene.toml:3:12: `position` in [camera] must be a list of 3 numbers, not a string
scene.toml:9:1: unknown key `zenit` in [environment]: did you mean `zenith`?
scene.toml:10:2: unknown key `material` at the top level of the scene: did you mean `materials`?
scene.toml:14:10: `sphere` in shape 1 must be a table, not `3`
scene.toml:17:64: `edge_v` in `rectangle` of shape 2 must be a list of 3 numbers, not a string",
    ),
    (
        "another version alone",
        "version = 2\nbanana = 3\n",
        "scene.toml:1:11: `version` must be 1, not `2`: this program reads scene files of version 1 only",
    ),
];

fn errors(mistakes: usize) -> Vec<String> {
    let shape = "[[shapes]]\nmaterial = \"glas\"\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    let camera = "camera = { position = [0, 1, 4], look_at = [0, 1, 0], vertical_fov_degrees = 40 }\n";
    let text = format!("version = 1\n{camera}[materials.glass]\n{}", shape.repeat(mistakes));
    let error = Scene::parse(&text, "scene.toml").unwrap_err();
    assert_eq!(error.others.len() + 1, error.to_string().lines().count());
    error.to_string().lines().map(str::to_string).collect()
}

#[test]
fn twenty_are_shown_and_the_others_counted() {
    assert_eq!(errors(1).len(), 1);
    assert_eq!(errors(20).len(), 20);
    let last = "scene.toml:62:12: unknown material `glas` in shape 20: did you mean `glass`?";
    for (mistakes, rest) in [(21, "and 1 more"), (50, "and 30 more"), (5_000, "and at least 80 more")] {
        let lines = errors(mistakes);
        assert_eq!(lines.len(), 21);
        assert_eq!(lines[19], last);
        assert_eq!(lines[20], format!("scene.toml: {rest}"));
    }
}

#[test]
fn unknown_keys_without_end() {
    let keys: String = (0..1_000).map(|i| format!("x{i} = 1\n")).collect();
    let lines = Scene::parse(&format!("version = 1\n{keys}"), "scene.toml").unwrap_err().to_string();
    assert_eq!(lines.lines().count(), 21);
    assert_eq!(lines.lines().last(), Some("scene.toml: and perhaps more"));
}

/// Each shape has a mistake, and all are read in a time that does not grow with the square of their number.
#[test]
fn a_mistake_in_each_of_many_shapes() {
    let shape = "[[shapes]]\nmaterial = \"red\"\nsphere = { center = [0, 0, 0], radius = 0, r = 1 }\n";
    let text = format!("version = 1\n[materials.red]\n{}", shape.repeat(50_000));
    let error = Scene::parse(&text, "scene.toml").unwrap_err().to_string();
    assert_eq!(error.lines().count(), 21);
    assert!(error.ends_with("\nscene.toml: and at least 80 more"), "{error}");
}
