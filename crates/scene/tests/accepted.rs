//! Scenes that are right, and what is read from them.

mod common;

use common::{EXAMPLE, check_invariants, reference_scene};
use raggio_scene::{Camera, Environment, Filter, Geometry, Material, Reflection, RenderSettings, Scene, Shape, Vec3};

const HEAD: &str = "version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 1]
vertical_fov_degrees = 40
";

fn parse(rest: &str) -> Scene {
    let scene = Scene::parse(&format!("{HEAD}{rest}"), "scene.toml").unwrap();
    check_invariants(&scene);
    scene
}

fn material(name: &str) -> Material {
    Material {
        name: name.to_string(),
        color: Vec3::splat(0.8),
        emission_color: Vec3::ONE,
        emission_strength: 0.0,
        smoothness: 0.0,
        refractive_index: None,
        reflection: Reflection::Fresnel,
        priority: 0,
    }
}

#[test]
fn the_example_with_every_key() {
    let expected = Scene {
        render: RenderSettings::default(),
        camera: Camera {
            position: Vec3::new(0.0, 1.0, 4.0),
            look_at: Vec3::Y,
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
            aperture_radius: 0.0,
            focus_distance: 4.0,
        },
        environment: Environment::Constant(Vec3::new(0.7, 0.8, 1.0)),
        materials: vec![
            Material { color: Vec3::ONE, smoothness: 1.0, refractive_index: Some(1.5), ..material("glass") },
            material("matt white"),
        ],
        shapes: example_shapes(),
        warnings: vec![],
    };
    assert_eq!(Scene::parse(EXAMPLE, "scene.toml").unwrap(), expected);
    check_invariants(&expected);
}

fn example_shapes() -> Vec<Shape> {
    let sphere = Geometry::Sphere { center: Vec3::Y, radius: 1.0 };
    let plane = Geometry::Plane { point: Vec3::ZERO, normal: Vec3::Y };
    let rectangle = Geometry::Rectangle { corner: Vec3::ZERO, edge_u: Vec3::X, edge_v: Vec3::Z };
    let cuboid = Geometry::Box {
        center: Vec3::new(1.0, 2.0, 3.0),
        size: Vec3::new(1.0, 2.0, 3.0),
        rotation_degrees: Vec3::new(10.0, 20.0, 30.0),
    };
    let shapes = [(0, sphere), (1, plane), (1, rectangle), (1, cuboid)];
    shapes.map(|(material, geometry)| Shape { material, geometry }).to_vec()
}

#[test]
fn every_reference_scene() {
    let shapes = [("cornell", 8), ("lamp", 3), ("nested", 4), ("spheres", 4), ("weekend", 487)];
    for (name, count) in shapes {
        let scene = Scene::load(&reference_scene(name)).unwrap();
        check_invariants(&scene);
        assert_eq!(scene.shapes.len(), count, "{name}");
        assert_eq!(scene.warnings, [""; 0], "{name}");
        assert_eq!((scene.render.width, scene.render.height), (128, 96), "{name}");
    }
}

#[test]
fn defaults() {
    let scene = parse("");
    assert_eq!(scene.render, RenderSettings::default());
    assert_eq!(scene.environment, Environment::Constant(Vec3::ZERO));
    assert_eq!(scene.camera.up, Vec3::Y);
    assert_eq!(scene.camera.aperture_radius, 0.0);
    assert_eq!(scene.camera.focus_distance, 3.0);
    assert!(scene.materials.is_empty() && scene.shapes.is_empty());
}

#[test]
fn every_setting() {
    let scene = parse(
        "[render]\nwidth = 65536\nheight = 1\nsamples = 2147483647\nmax_depth = 65535\n\
         seed = 0xffff_ffff\nfilter = \"point\"\nsurface_offset = false\n",
    );
    let expected = RenderSettings {
        width: 65536,
        height: 1,
        samples: i32::MAX as u32,
        max_depth: 65535,
        seed: u32::MAX,
        filter: Filter::Point,
        surface_offset: false,
    };
    assert_eq!(scene.render, expected);
}

#[test]
fn gradient() {
    let scene = parse("[environment]\nhorizon = [1, 1, 1]\nzenith = [0.5, 0.75, 1e3]\n");
    let zenith = Vec3::new(0.5, 0.75, 1e3);
    assert_eq!(scene.environment, Environment::Gradient { horizon: Vec3::ONE, zenith });
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn a_lamp_is_black_unless_it_has_a_color() {
    let scene = parse(
        "[materials]\nlamp.emission_strength = 2\nred = { emission_strength = 1, color = [1, 0, 0] }\n\
         matt = { emission_strength = 0 }",
    );
    let colors: Vec<Vec3> = scene.materials.iter().map(|it| it.color).collect();
    assert_eq!(colors, [Vec3::ZERO, Vec3::X, Vec3::splat(0.8)]);
}

#[test]
fn materials_keep_the_order_of_the_file() {
    let scene = parse("[materials.z]\n[materials.a]\n[materials.\"\"]\n[materials.m]\n");
    let names: Vec<&str> = scene.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["z", "a", "", "m"]);
}

#[test]
fn a_dielectric() {
    let scene = parse("[materials.water]\nrefractive_index = 1.33\nreflection = 0.25\npriority = -2147483648\n");
    let water = &scene.materials[0];
    assert_eq!(water.refractive_index, Some(1.33));
    assert_eq!(water.reflection, Reflection::Probability(0.25));
    assert_eq!(water.priority, i32::MIN);
}

#[test]
fn normals_become_unit_vectors_whatever_their_length() {
    for normal in ["[3, 0, 4]", "[3e-15, 0, 4e-15]", "[3e14, 0, 4e14]"] {
        let scene = parse(&format!(
            "[materials.a]\n[[shapes]]\nmaterial = \"a\"\nplane = {{ point = [1, 2, 3], normal = {normal} }}\n"
        ));
        let Geometry::Plane { normal, .. } = scene.shapes[0].geometry else {
            panic!("a plane was read as another shape");
        };
        assert!(normal.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-7));
    }
}

#[test]
fn a_rectangle_may_be_as_inexact_as_its_digits() {
    parse(
        "[materials.a]\n[[shapes]]\nmaterial = \"a\"\n\
         rectangle = { corner = [0, 0, 0], edge_u = [0.866, 0.5, 0], edge_v = [-0.49996, 0.866, 0] }\n",
    );
}

#[test]
fn windows_line_ends_and_a_byte_order_mark() {
    let text = format!("\u{feff}{}", EXAMPLE.replace('\n', "\r\n"));
    let scene = Scene::parse(&text, "scene.toml").unwrap();
    assert_eq!(scene, Scene::parse(EXAMPLE, "scene.toml").unwrap());
}

#[test]
fn warnings_of_a_dielectrics_keys_on_an_opaque_material() {
    let scene = parse("[environment]\ncolor = [1, 1, 1]\n[materials.\"a b\"]\npriority = 1\nreflection = 0.5\n");
    assert_eq!(
        scene.warnings,
        [
            "scene.toml:10:1: `reflection` in [materials.\"a b\"] does nothing without `refractive_index`",
            "scene.toml:9:1: `priority` in [materials.\"a b\"] does nothing without `refractive_index`",
        ]
    );
}

#[test]
fn warnings_of_a_dielectric_without_an_inside() {
    let text = "[environment]\ncolor = [1, 1, 1]\n[materials.glass]\nrefractive_index = 1.5\n[[shapes]]\nmaterial = \"glass\"\nrectangle = { corner = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [0, 1, 0] }\n";
    let [warning] = &parse(text).warnings[..] else { panic!("one warning") };
    assert!(warning.starts_with("scene.toml:12:1: a rectangle has no inside, so `glass` fills all"), "{warning}");
}

const DARK: &str = "nothing in the scene shines, so the picture will be black: give [environment] \
                    a `color`, or the material of a shape an `emission_strength`";

#[test]
fn warnings_of_darkness() {
    let lamp = "[materials.lamp]\nemission_strength = 1\n";
    let used = "[[shapes]]\nmaterial = \"lamp\"\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    let unused = parse(lamp);
    assert_eq!(unused.warnings, [format!("scene.toml:1:1: {DARK}")]);

    let black = parse(&format!("[environment]\ncolor = [0, 0, 0]\n{lamp}"));
    assert_eq!(black.warnings, [format!("scene.toml:6:1: {DARK}")]);

    let black_lamp = parse(&format!("{lamp}emission_color = [0, 0, 0]\n{used}"));
    assert_eq!(black_lamp.warnings.len(), 1);

    let lit = parse(&format!("{lamp}{used}"));
    assert_eq!(lit.warnings, [""; 0]);
}

#[test]
fn warnings_end() {
    let materials: String = (0..300).map(|i| format!("[materials.m{i}]\npriority = 1\n")).collect();
    let scene = parse(&materials);
    assert_eq!(scene.warnings.len(), 101);
    assert_eq!(scene.warnings[100], "scene.toml: 201 more warnings");
}
