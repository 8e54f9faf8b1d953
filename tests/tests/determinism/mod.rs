//! Determinism: equal samples make equal pictures, bit for bit, however they are divided; and the film loses none.

mod bands;
mod bounds;
mod devices_agree;
mod divided;
mod film;
mod patience;
mod tracers_agree;
mod walks;

use raggio_scene::Scene;
const CORNELL: &str = include_str!("../../../scenes/reference/cornell.toml");
const NESTED: &str = include_str!("../../../scenes/reference/nested.toml");
const WEEKEND: &str = include_str!("../../../scenes/reference/weekend.toml");
const LIGHTS: &str = include_str!("../../../scenes/guide/lights.toml");
/// Scene with all shapes, a thin lens, all kinds of reflection, a gradient sky, overlapping dielectrics.
const EVERYTHING: &str = "version = 1
[render]
max_depth = 12
[camera]
position = [0, 1.5, 6]
look_at = [0, 0.8, 0]
vertical_fov_degrees = 40
aperture_radius = 0.1
focus_distance = 5
[environment]
horizon = [1, 0.9, 0.8]
zenith = [0.3, 0.5, 1]
[materials.ground]
color = [0.5, 0.5, 0.4]
smoothness = 0.3
[materials.rough]
color = [0.9, 0.6, 0.3]
smoothness = 0.7
[materials.mirror]
color = [0.9, 0.9, 0.9]
smoothness = 1
[materials.glass]
color = [0.9, 1, 0.95]
refractive_index = 1.5
priority = 1
[materials.water]
color = [0.8, 0.9, 1]
refractive_index = 1.33
reflection = 0.1
[materials.lamp]
emission_color = [1, 0.8, 0.6]
emission_strength = 4
[[shapes]]
material = \"ground\"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
[[shapes]]
material = \"rough\"
box = { center = [-1.6, 0.6, 0], size = [1, 1.2, 0.8], rotation_degrees = [0, 30, 10] }
[[shapes]]
material = \"mirror\"
rectangle = { corner = [-3, 0, -2], edge_u = [6, 0, 0], edge_v = [0, 3, 0] }
[[shapes]]
material = \"glass\"
sphere = { center = [0, 0.8, 0], radius = 0.8 }
[[shapes]]
material = \"water\"
box = { center = [0.8, 0.5, 0], size = [1.2, 0.9, 1.2] }
[[shapes]]
material = \"lamp\"
sphere = { center = [1.5, 2.2, 0.5], radius = 0.4 }
";

/// Scene with fog in a body and in the air, milk and wax, under a lamp.
const MEDIA: &str = "version = 1
[render]
max_depth = 30
[camera]
position = [0, 1.5, 6]
look_at = [0, 0.8, 0]
vertical_fov_degrees = 40
[air]
scattering = [0.02, 0.03, 0.05]
anisotropy = 0.6
[materials.ground]
color = [0.5, 0.5, 0.4]
[materials.fog]
medium = { scattering = [2, 1, 0.5], absorption = [0.1, 0.2, 0.3], anisotropy = -0.3 }
[materials.milk]
refractive_index = 1.33
color = [1, 1, 1]
medium = { scattering = 6, absorption = [0, 0.1, 0.2], anisotropy = 0.8 }
[materials.wax]
principled = { transmission = 1, roughness = 0.3, ior = 1.4 }
medium = { scattering = [3, 2, 1] }
[materials.lamp]
emission_color = [1, 0.8, 0.6]
emission_strength = 9
[[shapes]]
material = \"ground\"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
[[shapes]]
material = \"fog\"
box = { center = [-1.6, 0.6, 0], size = [1, 1.2, 0.8], rotation_degrees = [0, 30, 10] }
[[shapes]]
material = \"milk\"
sphere = { center = [0, 0.8, 0], radius = 0.8 }
[[shapes]]
material = \"wax\"
sphere = { center = [1.5, 0.5, 0.3], radius = 0.5 }
[[shapes]]
material = \"lamp\"
sphere = { center = [1.5, 2.2, 0.5], radius = 0.4 }
";

/// Small pictures of scenes that between them use everything. 42x33 pixels: no multiple of a workgroup or a tile.
fn scenes() -> Vec<(&'static str, Scene)> {
    let file = |text: &str| Scene::parse(text, "scene.toml").expect("the scene is valid");
    let scenes = [
        ("cornell", file(CORNELL)),
        ("nested", file(NESTED)),
        ("weekend", file(WEEKEND)),
        ("everything", file(EVERYTHING)),
    ];
    small(scenes)
}

/// The small pictures, one of media, and one of lights that are no surfaces. Software Vulkan takes half a minute to compile
/// the kernel of the last two.
fn scenes_of_all_kinds() -> Vec<(&'static str, Scene)> {
    let file = |text: &str| Scene::parse(text, "scene.toml").expect("the scene is valid");
    [scenes(), small([("media", file(MEDIA)), ("lights", file(LIGHTS))])].concat()
}

fn small<const N: usize>(scenes: [(&'static str, Scene); N]) -> Vec<(&'static str, Scene)> {
    scenes
        .into_iter()
        .map(|(name, mut scene)| {
            (scene.render.width, scene.render.height) = (42, 33);
            scene.render.seed = 5;
            (name, scene)
        })
        .collect()
}
