//! Agreement of the two integrators: every kind of light on every kind of material, block by block.

use glam::{DAffine3, DVec3};
use raggio_kernels::FilmPixel;
use raggio_render::Film;
use raggio_scene::{Integrator, LightKind, Scene};
use raggio_tests::devices::long;
use raggio_tests::statistics::sidak;
use raggio_tests::{TestDevice, for_each_device, parse, render};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::lights::{add_light, add_mesh, ball, sky};

const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;
/// Side of a block, in pixels.
const BLOCK: u32 = 8;

/// Two bodies of a material on a grey floor.
const STAGE: &str = "
    [camera]
    position = [0, 1.3, 4]
    look_at = [0, 0.8, 0]
    vertical_fov_degrees = 40
    [materials.floor]
    color = [0.6, 0.6, 0.6]
    [materials.lamp]
    color = [0.2, 0.2, 0.2]
    emission_color = [1, 0.9, 0.7]
    emission_strength = 3
    [[shapes]]
    material = \"floor\"
    rectangle = { corner = [-3, 0, -3], edge_u = [6, 0, 0], edge_v = [0, 0, 6] }
    [[shapes]]
    material = \"subject\"
    sphere = { center = [-0.7, 0.65, 0], radius = 0.6 }
    [[shapes]]
    material = \"subject\"
    box = { center = [0.8, 0.5, 0.2], size = [0.7, 0.8, 0.6], rotation_degrees = [10, 30, 5] }
";

/// Material of lamps that are there in part.
const VEIL: &str = "[materials.veil]\nprincipled = { emissive = [2, 2, 3], alpha = 0.6, alpha_mode = \"blend\" }\n";

/// Names of the materials, and their keys. The principled ones come last.
const MATERIALS: [(&str, &str); 12] = [
    ("diffuse", "color = [0.8, 0.5, 0.3]"),
    ("half a mirror", "color = [0.8, 0.8, 0.8]\nsmoothness = 0.5"),
    ("nearly a mirror", "color = [0.8, 0.8, 0.8]\nsmoothness = 0.9"),
    ("mirror", "color = [0.8, 0.8, 0.8]\nsmoothness = 1"),
    ("half reflecting", "color = [1, 1, 1]\nrefractive_index = 1.3\nreflection = 0.5"),
    ("glass", "color = [1, 1, 1]\nrefractive_index = 1.5"),
    ("rough metal", "principled = { base_color = [0.9, 0.6, 0.3], metallic = 1, roughness = 0.4 }"),
    ("rough glass", "principled = { transmission = 1, roughness = 0.4, ior = 1.5 }"),
    (
        "absorbing glass",
        "principled = { transmission = 1, roughness = 0.6, ior = 1.3, attenuation_color = [0.9, 0.4, 0.5], attenuation_distance = 0.5 }",
    ),
    ("plastic", "principled = { base_color = [0.2, 0.5, 0.3], roughness = 0.3, clearcoat = 1 }"),
    ("blended", "principled = { base_color = [0.8, 0.8, 0.8], roughness = 1, alpha = 0.5, alpha_mode = \"blend\" }"),
    (
        "leaf",
        "principled = { base_color = [0.5, 0.8, 0.5], roughness = 0.7, diffuse_transmission = 0.6, thin_walled = true }",
    ),
];

/// Number of materials without `principled`, which come first.
const SIMPLE: usize = 6;
/// Number of bodies: a sphere, a box and a mesh.
const BODIES: usize = 3;

type Lamp = (&'static str, fn(&mut Scene));

fn lamps() -> Vec<Lamp> {
    vec![
        ("sphere", |scene| add_shape(scene, "lamp", "sphere = { center = [0.5, 2.6, 0.8], radius = 0.7 }")),
        ("rectangle", |scene| {
            add_shape(
                scene,
                "lamp",
                "rectangle = { corner = [-1, 2.2, -1.5], edge_u = [2, 0, 0], edge_v = [0, 0.5, 1.5] }",
            );
        }),
        ("box", |scene| {
            add_shape(
                scene,
                "lamp",
                "box = { center = [0, 2.2, -1], size = [1.5, 0.5, 1], rotation_degrees = [0, 20, 30] }",
            );
        }),
        ("disk", |scene| {
            add_shape(scene, "lamp", "disk = { center = [0.4, 2.3, 0.3], normal = [0.3, 1, -0.4], radius = 0.9 }");
        }),
        ("cylinder", |scene| {
            add_shape(scene, "lamp", "cylinder = { base = [-1.3, 2.2, -0.4], top = [1.2, 2.5, 0.3], radius = 0.35 }");
        }),
        ("cones", |scene| {
            add_shape(
                scene,
                "lamp",
                "cone = { base = [-0.9, 2.3, 0], top = [-0.8, 1.7, 0.1], radius = 0.6, capped = false }",
            );
            add_shape(
                scene,
                "lamp",
                "cone = { base = [0.9, 2.6, 0.5], top = [0.8, 2, 0.2], radius = 0.6, top_radius = 0.4 }",
            );
        }),
        ("mesh", |scene| {
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::new(0.8, 0.4, 0.8),
                glam::DQuat::from_rotation_x(0.4),
                DVec3::new(0.2, 2.4, 0.6),
            );
            add_mesh(scene, ball(2), place, "lamp");
        }),
        ("veil", |scene| {
            add_shape(
                scene,
                "veil",
                "rectangle = { corner = [-1, 2.2, -1.5], edge_u = [2, 0, 0], edge_v = [0, 0.5, 1.5] }",
            );
            add_shape(scene, "veil", "sphere = { center = [0.9, 2.2, 0.8], radius = 0.5 }");
        }),
        ("plane", |scene| add_shape(scene, "lamp", "plane = { point = [0, 4, 0], normal = [0, -1, 0] }")),
        ("from inside", |scene| add_shape(scene, "lamp", "sphere = { center = [0, 1, 0], radius = 8 }")),
        ("sky's image", |scene| {
            scene.environment = sky(16, 8, |x, y| if x < 7 && y < 3 { [4.0, 3.0, 2.0] } else { [0.1, 0.2, 0.4] });
        }),
        ("gradient", |scene| {
            let [horizon, zenith] = [[1.0, 0.9, 0.8], [0.3, 0.5, 1.0]].map(Into::into);
            scene.environment = raggio_scene::Environment::Gradient { horizon, zenith };
        }),
        ("point", |scene| add_light(scene, LightKind::Point, [0.5, 2.6, 0.8], [0.0, -1.0, 0.0], [6.0, 5.0, 4.0])),
        ("spot", |scene| {
            let kind = LightKind::Spot { inner: 0.2, outer: 0.5 };
            add_light(scene, kind, [0.5, 2.9, 0.8], [-0.1, -1.0, -0.3], [12.0, 12.0, 9.0]);
        }),
        ("sun", |scene| add_light(scene, LightKind::Directional, [0.0; 3], [-0.5, -1.0, -0.4], [1.0, 1.5, 2.0])),
        ("sun with a size", |scene| {
            add_light(scene, LightKind::Sun { half_angle: 0.4 }, [0.0; 3], [-0.5, -1.0, -0.4], [1.0, 1.5, 2.0]);
        }),
        // A sun before a bright sky, another that overlaps it, and a light that only sampling finds.
        ("suns and sky", |scene| {
            add_light(scene, LightKind::Sun { half_angle: 0.5 }, [0.0; 3], [-0.5, -1.0, -0.4], [0.6, 0.9, 1.2]);
            add_light(scene, LightKind::Sun { half_angle: 1.4 }, [0.0; 3], [-0.9, -0.4, -0.4], [0.8, 0.5, 0.2]);
            add_light(scene, LightKind::Directional, [0.0; 3], [0.5, -1.0, -0.4], [0.2; 3]);
            scene.environment = sky(16, 8, |x, y| if x < 7 && y < 3 { [2.0, 1.5, 1.0] } else { [0.1, 0.2, 0.4] });
        }),
        ("many", |scene| {
            add_shape(scene, "lamp", "sphere = { center = [0.5, 2.6, 0.8], radius = 0.5 }");
            add_shape(scene, "lamp", "box = { center = [-1.4, 1.9, -1], size = [1, 0.5, 0.6] }");
            add_light(scene, LightKind::Point, [-1.5, 1.6, 0.8], [0.0, -1.0, 0.0], [1.0, 2.0, 3.0]);
            add_light(scene, LightKind::Directional, [0.0; 3], [-0.5, -1.0, -0.4], [0.4; 3]);
            scene.environment = sky(8, 4, |x, y| [(x * (4 - y)) as f32 * 0.03; 3]);
        }),
    ]
}

/// Adds to `scene` the shape of a file with this text, and its material where that is new.
fn add_shape(scene: &mut Scene, material: &str, shape: &str) {
    let text = format!("{STAGE}{VEIL}[materials.subject]\n[[shapes]]\nmaterial = \"{material}\"\n{shape}\n");
    let mut parsed = parse(&text);
    let shape = parsed.shapes.pop().expect("the file has shapes");
    let known = scene.materials.iter().position(|m| m.name == material);
    let material = known.unwrap_or_else(|| {
        scene.materials.push(parsed.materials.swap_remove(shape.material));
        scene.materials.len() - 1
    });
    scene.shapes.push(raggio_scene::Shape { material, ..shape });
}

fn scene(material: &str, max_depth: u32, lamp: fn(&mut Scene)) -> Scene {
    let render = format!("[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\nmax_depth = {max_depth}\n");
    let mut scene = parse(&[&render, STAGE, "[materials.subject]\n", material, "\n"].concat());
    lamp(&mut scene);
    scene
}

/// Scene of a stage whose bodies have a material each: the sphere, the box, and a mesh in front of them.
fn trio(materials: [&str; BODIES], lamp: fn(&mut Scene)) -> Scene {
    let mut scene = scene(materials[0], 6, |_| ());
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.35, 0.4, 0.35),
        glam::DQuat::from_rotation_z(0.3),
        DVec3::new(0.05, 0.5, 0.9),
    );
    add_mesh(&mut scene, ball(2), place, "floor");
    // The floor and the sphere have their materials already.
    for (shape, keys) in scene.shapes[2..].iter_mut().zip(&materials[1..]) {
        let mut parsed = parse(&[STAGE, "[materials.subject]\n", keys, "\n"].concat());
        let subject = parsed.materials.iter().position(|m| m.name == "subject").expect("it is in the text");
        shape.material = scene.materials.len();
        scene.materials.push(parsed.materials.swap_remove(subject));
    }
    lamp(&mut scene);
    scene
}

/// Mean luminance of a block of pixels, and the variance of that.
fn block(film: &Film, left: u32, top: u32) -> (f64, f64) {
    let pixels = film.pixels();
    let places = (0..BLOCK * BLOCK).map(|i| ((top + i / BLOCK) * WIDTH + left + i % BLOCK) as usize);
    let (mean, variance) = places.map(|place| moments(&pixels[place])).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let count = f64::from(BLOCK * BLOCK);
    (mean / count, variance / (count * count))
}

/// Mean luminance of a pixel, and the variance of that.
fn moments(pixel: &FilmPixel) -> (f64, f64) {
    let [red, green, blue] = raggio_tests::render::mean(pixel).to_array();
    let mean = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let samples = f64::from(pixel.samples);
    let square = raggio_tests::render::whole(pixel.squares) as f64 * 2f64.powi(-40) / samples;
    (mean, (square - mean * mean).max(0.0) / (samples - 1.0))
}

/// Largest deviation of the two pictures' blocks, in standard errors, and the mean relative standard error.
fn deviation(device: &TestDevice, mut scene: Scene, samples: [u32; 2]) -> (f64, f64) {
    let [path, reference] = [Integrator::Path, Integrator::Reference].map(|integrator| {
        scene.render.integrator = integrator;
        // The samples of the two are independent.
        scene.render.seed = integrator as u32;
        let film = render(device.device, &scene, samples[integrator as usize]);
        assert_eq!(film.rejected(), 0, "samples without a finite value");
        film
    });
    let blocks = (0..HEIGHT / BLOCK).flat_map(|y| (0..WIDTH / BLOCK).map(move |x| (x * BLOCK, y * BLOCK)));
    let (mut largest, mut errors) = (0.0f64, vec![]);
    // Rounding is no deviation, nor is the one sample of a block that light has just touched.
    let mean = reference.pixels().iter().map(|pixel| moments(pixel).0).sum::<f64>() / f64::from(WIDTH * HEIGHT);
    for (left, top) in blocks {
        let ((a, va), (b, vb)) = (block(&path, left, top), block(&reference, left, top));
        let error = (va + vb).sqrt() + 1e-6 * (b + mean);
        largest = largest.max((a - b).abs() / error.max(1e-30));
        errors.push(error / (b + 0.01 * mean).max(1e-30));
    }
    (largest, errors.iter().sum::<f64>() / errors.len() as f64)
}

/// Checks the deviations of all `scenes` together: any of them is this large in one of a thousand runs.
fn assert_agree(device: &TestDevice, scenes: Vec<(String, Scene)>, samples: [u32; 2]) {
    let blocks = scenes.len() * (WIDTH / BLOCK * HEIGHT / BLOCK) as usize;
    let normal = Normal::standard();
    let limit = normal.inverse_cdf(1.0 - 0.5 * sidak(1e-3, blocks));
    let mut bad = vec![];
    let mut uncertain = 0.0;
    for (what, scene) in scenes {
        let (deviation, error) = deviation(device, scene, samples);
        uncertain += error / (blocks as f64 / 12.0);
        if deviation > limit {
            bad.push(format!("{what}: {deviation:.2} standard errors of {error:.4}"));
        }
    }
    println!("{}: {blocks} blocks, limit {limit:.2}, mean standard error {uncertain:.4}", device.label);
    assert!(bad.is_empty(), "{}: beyond {limit:.2} are\n{}", device.label, bad.join("\n"));
}

/// Materials of the three bodies in each scene of a cover: a row a scene, with the lamp's number in front.
///
/// Every lamp meets every material, and every material is on every body, in a third of the scenes that each pair alone
/// would take. The two kinds of materials have kernels of their own and stay apart.
fn cover() -> Vec<(usize, [usize; BODIES])> {
    let rows = |lamp| {
        (0..MATERIALS.len() / BODIES).map(move |row| {
            let (kind, group) = (row * BODIES / SIMPLE, row * BODIES % SIMPLE);
            (lamp, [0, 1, 2].map(|body| kind * SIMPLE + (group + body + lamp) % SIMPLE))
        })
    };
    (0..lamps().len()).flat_map(rows).collect()
}

#[test]
fn the_cover_leaves_no_pair_out() {
    let cover = cover();
    assert_eq!(cover.len(), 72);
    for material in 0..MATERIALS.len() {
        for lamp in 0..lamps().len() {
            assert!(cover.iter().any(|row| row.0 == lamp && row.1.contains(&material)), "{material} under {lamp}");
        }
        for body in 0..BODIES {
            assert!(cover.iter().any(|row| row.1[body] == material), "{material} on body {body}");
        }
    }
    let is_principled = |material: &usize| MATERIALS[*material].1.starts_with("principled");
    for (_, materials) in &cover {
        let principled = materials.iter().filter(|material| is_principled(material)).count();
        assert!(principled == 0 || principled == BODIES, "{materials:?}");
    }
}

/// Bodies of different materials stand three to a scene; all pairs of a lamp and a material alone are for long tests.
#[test]
fn every_light_on_every_material() {
    let lamps = lamps();
    for_each_device(|device| {
        let mut scenes = vec![];
        for (lamp, materials) in cover() {
            let (name, add) = lamps[lamp];
            let scene = trio(materials.map(|material| MATERIALS[material].1), add);
            // Software Vulkan runs the same kernels, and takes minutes to compile those for all materials: there,
            // each light that needs none of these meets three materials.
            let is_simple = scene.lights.is_empty() && scene.materials.iter().all(|m| m.principled.is_none());
            if !device.slow || (is_simple && materials.contains(&(lamp % SIMPLE))) {
                let names = materials.map(|material| MATERIALS[material].0);
                scenes.push((format!("{} under {name}", names.join(", ")), scene));
            }
        }
        assert_agree(&device, scenes, device.pick([192, 512], [32, 96]));
    });
}

#[test]
fn every_light_on_every_material_alone() {
    if !long() {
        return;
    }
    for_each_device(|device| {
        if device.slow {
            return;
        }
        let pairs = lamps().into_iter().flat_map(|(lamp, add)| {
            MATERIALS.map(move |(what, material)| (format!("{what} under {lamp}"), scene(material, 6, add)))
        });
        assert_agree(&device, pairs.collect(), [192, 512]);
    });
}

/// A shadow ray counts as the ray it replaces: both integrators see equally far.
#[test]
fn depth_means_the_same() {
    for_each_device(|device| {
        let mut scenes = vec![];
        // The cases are a light of each kind: an area, the sky, a point, and all together.
        let chosen = device.pick(&["sphere", "sky's image", "point", "suns and sky", "many"][..], &["sphere"]);
        let is_chosen = |lamp: &str| chosen.contains(&lamp) || (long() && !device.slow);
        for (lamp, add) in lamps().into_iter().filter(|(lamp, _)| is_chosen(lamp)) {
            for max_depth in [1, 2, 3, 0] {
                let material = device.pick(MATERIALS[7], MATERIALS[0]).1;
                scenes.push((format!("{lamp} at depth {max_depth}"), scene(material, max_depth, add)));
            }
        }
        assert_agree(&device, scenes, device.pick([192, 512], [32, 96]));
    });
}

/// Smooth sheets, and one with a rough coat, hang between the stage and its lamps: light passes them in both ways of
/// looking for it, as far as paths may be long.
#[test]
fn sheets_hide_no_light() {
    let pane = "base_color = [0.9, 0.8, 0.6], transmission = 1, roughness = 0, thin_walled = true";
    let panes = format!(
        "[materials.pane]\nprincipled = {{ {pane} }}\n
         [materials.coated]\nprincipled = {{ {pane}, clearcoat = 1, clearcoat_roughness = 0.4 }}\n
         [[shapes]]\nmaterial = \"pane\"
         rectangle = {{ corner = [-4, 1.7, -4], edge_u = [8, 0, 0], edge_v = [0, 0.1, 8] }}\n
         [[shapes]]\nmaterial = \"coated\"
         rectangle = {{ corner = [-4, 1.6, -4], edge_u = [8, 0, 0], edge_v = [0, -0.1, 8] }}\n"
    );
    let subject = "base_color = [0.7, 0.7, 0.7], transmission = 0.5, roughness = 0, thin_walled = true";
    let chosen = ["sphere", "rectangle", "mesh", "sky's image", "gradient", "point", "sun", "many"];
    for_each_device(|device| {
        // Software Vulkan takes minutes to compile principled kernels: single pictures test them there.
        if device.slow {
            return;
        }
        let mut scenes = vec![];
        for (lamp, add) in lamps().into_iter().filter(|(lamp, _)| chosen.contains(lamp)) {
            for max_depth in [2, 3, 4, 6] {
                let render = format!("[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\nmax_depth = {max_depth}\n");
                let material = format!("[materials.subject]\nprincipled = {{ {subject} }}\n");
                let mut scene = parse(&[&render, STAGE, &material, &panes].concat());
                add(&mut scene);
                scenes.push((format!("{lamp} at depth {max_depth}"), scene));
            }
        }
        assert_agree(&device, scenes, [192, 512]);
    });
}

/// Fog in a body without a surface, milk behind a smooth and wax behind a rough one, and a stage full of mist: a lamp of each
/// kind shines into all of them, and through.
#[test]
fn every_light_through_media() {
    let media = [
        "medium = { scattering = [3, 1.5, 0.7], absorption = [0.1, 0.2, 0.4], anisotropy = 0.5 }",
        "color = [1, 1, 1]\nrefractive_index = 1.33\nmedium = { scattering = [2, 3, 4], absorption = 0.3, anisotropy = -0.3 }",
        "principled = { transmission = 1, roughness = 0.4, ior = 1.4 }\nmedium = { scattering = 4, absorption = [0.5, 1, 2] }",
    ];
    let mist = raggio_scene::Medium {
        scattering: [0.05, 0.04, 0.03].into(),
        absorption: [0.0, 0.01, 0.02].into(),
        anisotropy: 0.7,
    };
    for_each_device(|device| {
        let mut scenes = vec![];
        for (number, (lamp, add)) in lamps().into_iter().enumerate() {
            // Software Vulkan takes minutes to compile principled kernels: single pictures test them there.
            if device.slow {
                continue;
            }
            let order = [0, 1, 2].map(|body| media[(body + number) % media.len()]);
            let mut scene = trio(order, add);
            scenes.push((format!("media under {lamp}"), scene.clone()));
            scene.air = Some(mist);
            scenes.push((format!("media in mist under {lamp}"), scene));
        }
        assert_agree(&device, scenes, [256, 768]);
    });
}

/// A diffuse ball lies in the middle of priorities: it and a lamp are inside water, in which a body of lower priority
/// hides.
#[test]
fn hidden_boundaries_stop_no_light() {
    let bodies = "
        [materials.water]
        color = [1, 1, 1]
        refractive_index = 1.33
        priority = 2
        [materials.hidden]
        color = [1, 1, 1]
        refractive_index = 1.6
        priority = 1
        [[shapes]]
        material = \"water\"
        box = { center = [0, 2, 1], size = [20, 20, 20] }
        [[shapes]]
        material = \"hidden\"
        sphere = { center = [0.2, 2, 0.3], radius = 0.5 }
        [[shapes]]
        material = \"hidden\"
        box = { center = [-0.8, 1.8, 0.3], size = [0.5, 0.3, 3] }
        [[shapes]]
        material = \"lamp\"
        sphere = { center = [0.3, 3.2, 0.5], radius = 0.6 }
    ";
    for_each_device(|device| {
        let scenes = [("diffuse", "color = [0.7, 0.7, 0.7]"), ("glass", "color = [1, 1, 1]\nrefractive_index = 1.5")];
        let scenes = scenes.map(|(what, material)| {
            let render = format!("[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\nmax_depth = 6\n");
            let mut scene = parse(&[&render, STAGE, "[materials.subject]\n", material, bodies].concat());
            if !device.slow {
                add_light(&mut scene, LightKind::Point, [-0.9, 2.6, 0.5], [0.0, -1.0, 0.0], [2.0; 3]);
            }
            (what.to_owned(), scene)
        });
        assert_agree(&device, scenes.into(), device.pick([512, 2048], [64, 256]));
    });
}
