//! Scenes that are right, and what is read from them.

use crate::common::{EXAMPLE, check_invariants, reference_scene};
use raggio_scene::{
    AlphaMode, Camera, Contents, Entry, Environment, Filter, Geometry, Integrator, Intrinsics, LightEntry, LightKind,
    LightPlace, Material, Medium, Panorama, Principled, Projection, Reflection, RenderSettings, Sampler, Scene, Shape,
    Texels, Transform, Vec3,
};

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
    Material { name: name.to_string(), ..Material::default() }
}

#[test]
fn the_example_with_every_key() {
    let expected = Scene {
        render: RenderSettings::default(),
        camera: Camera {
            position: Vec3::new(0.0, 1.0, 4.0),
            look_at: Vec3::Y,
            up: Vec3::Y,
            projection: Projection::Perspective { vertical_fov_degrees: 40.0 },
            aperture_radius: 0.0,
            focus_distance: 4.0,
        },
        environment: Environment::Constant(Vec3::new(0.7, 0.8, 1.0)),
        air: None,
        materials: vec![
            Material { color: Vec3::ONE, smoothness: 1.0, refractive_index: Some(1.5), ..material("glass") },
            material("matt white"),
            Material { principled: Some(lacquer().into()), ..material("lacquer") },
        ],
        shapes: example_shapes(),
        entries: example_shapes().iter().map(entry).collect(),
        lights: example_lights().iter().map(LightEntry::light).collect(),
        light_entries: example_lights(),
        warnings: vec![],
    };
    assert_eq!(Scene::parse(EXAMPLE, "scene.toml").unwrap(), expected);
    check_invariants(&expected);
}

/// Media in the air, in bodies without a surface, and behind smooth and rough ones.
#[test]
fn media() {
    let scene = parse(
        "[air]\nabsorption = 0.5\n
         [materials.fog]\nmedium = { scattering = [1, 2, 3], anisotropy = -0.25 }\npriority = -1\n
         [materials.milk]\nrefractive_index = 1.33\n[materials.milk.medium]\nscattering = 2\nabsorption = [0, 0.5, 1]\n
         [materials.wax]\nprincipled = { transmission = 1 }\nmedium = {}\n
         [materials.clay]\n",
    );
    let medium = |absorption, scattering, anisotropy| Some(Medium { absorption, scattering, anisotropy });
    assert_eq!(scene.air, medium(Vec3::splat(0.5), Vec3::ZERO, 0.0));
    let media: Vec<_> = scene.materials.iter().map(|material| material.medium).collect();
    let fog = medium(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), -0.25);
    let milk = medium(Vec3::new(0.0, 0.5, 1.0), Vec3::splat(2.0), 0.0);
    assert_eq!(media, [fog, milk, Some(Medium::default()), None]);
    let properties = |of: fn(&Material) -> bool| scene.materials.iter().map(of).collect::<Vec<_>>();
    assert_eq!(properties(Material::is_seamless), [true, false, false, false]);
    assert_eq!(properties(Material::is_dielectric), [true, true, true, false]);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    let endless = parse("[environment]\ncolor = [1, 1, 1]\n[air]\nabsorption = [0.1, 0.2, 0.3]\n");
    assert_eq!(
        endless.warnings,
        [
            "scene.toml:8:1: [air] has no end, so no light of [environment] comes through it: for fog under a sky, give a \
          large body a material with a `medium` instead"
        ]
    );
}

fn lacquer() -> Principled {
    Principled {
        base_color: [0.8, 0.1, 0.1],
        alpha: 0.5,
        alpha_mode: AlphaMode::Mask(0.25),
        metallic: 0.25,
        roughness: 0.5,
        ior: 1.4,
        specular: 0.5,
        specular_color: [1.0, 0.9, 0.8],
        transmission: 0.25,
        thin_walled: true,
        attenuation_color: [0.9, 0.8, 0.7],
        attenuation_distance: 2.0,
        dispersion: 0.4,
        priority: 3,
        diffuse_transmission: 0.125,
        diffuse_transmission_color: [0.5, 0.6, 0.7],
        clearcoat: 1.0,
        clearcoat_roughness: 0.1,
        clearcoat_normal_scale: 0.5,
        sheen_color: [0.1, 0.2, 0.3],
        sheen_roughness: 0.3,
        anisotropy: 0.6,
        anisotropy_rotation: std::f32::consts::FRAC_PI_2,
        iridescence: 0.7,
        iridescence_ior: 1.8,
        iridescence_thickness_minimum: 200.0,
        iridescence_thickness_maximum: 500.0,
        emissive: [0.0, 1.0, 2.0],
        normal_scale: 2.0,
        ..Principled::default()
    }
}

fn example_lights() -> Vec<LightEntry> {
    let direction = Vec3::new(0.0, -0.6, -0.8);
    let position = Vec3::new(1.0, 2.0, 3.0);
    let point = LightPlace::Point { position: Vec3::new(0.0, 3.0, 0.0) };
    let spot = LightPlace::Spot { position, direction, inner_degrees: 10.0, outer_degrees: 20.0 };
    let sun = LightPlace::Directional { direction, angle_degrees: 0.5 };
    let color = Vec3::new(1.0, 0.9, 0.8);
    let light = |place, intensity| LightEntry { place, color, intensity };
    vec![light(point, 4.0), light(spot, 5.0), light(sun, 3.0)]
}

/// Shapes stand where their transforms take them, one inside the other.
#[test]
fn transforms_and_groups() {
    let scene = parse(
        "[materials.a]\n[materials.b]\n\
         [[groups.pair]]\nmaterial = \"a\"\nsphere = { center = [1, 0, 0], radius = 0.5 }\n\
         [[groups.pair]]\nmaterial = \"b\"\nbox = { center = [0, 1, 0], size = [1, 2, 3] }\n\
         transform = { rotation_degrees = [0, 0, 90] }\n\
         [[groups.nest]]\ngroup = \"pair\"\ntransform = { translation = [0, 0, 1], scale = 2 }\n\
         [[shapes]]\ngroup = \"nest\"\ntransform = { rotation_degrees = [0, 90, 0] }\n\
         [[shapes]]\ngroup = \"pair\"\nmaterial = \"b\"\n\
         [[shapes]]\nmaterial = \"a\"\ncone = { base = [0, 0, 0], top = [0, 1, 0], radius = 1 }\n\
         transform = { translation = [5, 0, 0], rotation_degrees = [90, 0, 0], scale = 3 }\n\
         [environment]\ncolor = [1, 1, 1]\n",
    );
    assert_eq!(scene.warnings, [""; 0]);
    let keys: Vec<_> = scene.entries.iter().map(|entry| (entry.key(), entry.shapes.clone(), entry.material)).collect();
    assert_eq!(keys, [("group", 0..2, None), ("group", 2..4, Some(1)), ("cone", 4..5, Some(0))]);
    let materials: Vec<_> = scene.shapes.iter().map(|shape| (shape.entry, shape.material)).collect();
    assert_eq!(materials, [(0, 0), (0, 1), (1, 1), (1, 1), (2, 0)]);
    let near = |a: Vec3, b: [f32; 3]| assert!(a.abs_diff_eq(b.into(), 1e-5), "{a} is not {b:?}");
    let Geometry::Sphere { center, radius } = scene.shapes[0].geometry else { panic!("a sphere") };
    // (1, 0, 0) is doubled and moved to (2, 0, 1), and a quarter of a turn about y takes x to -z and z to x.
    near(center, [1.0, 0.0, -2.0]);
    assert_eq!(radius, 1.0);
    let Geometry::Box { center, size, rotation_degrees } = scene.shapes[1].geometry else { panic!("a box") };
    near(center, [1.0, 0.0, 2.0]);
    near(size, [2.0, 4.0, 6.0]);
    let turned = raggio_scene::rotation(rotation_degrees) * raggio_scene::DVec3::X;
    near(turned.as_vec3(), [0.0, 1.0, 0.0]);
    let Geometry::Box { center, .. } = scene.shapes[3].geometry else { panic!("a box") };
    near(center, [-1.0, 0.0, 0.0]);
    let Geometry::Cone { base, top, radius, .. } = scene.shapes[4].geometry else { panic!("a cone") };
    near(base, [5.0, 0.0, 0.0]);
    near(top, [5.0, 0.0, 3.0]);
    assert_eq!(radius, 3.0);
    // What the file says is kept beside it.
    let own = Geometry::Cone { base: Vec3::ZERO, top: Vec3::Y, radius: 1.0, top_radius: 0.0, capped: true };
    assert_eq!(scene.entries[2].geometry(), Some(&own));
    assert_eq!(scene.entries[2].transform.scale, Vec3::splat(3.0));
}

/// A colour is the same in each of the ways to write it, wherever it stands.
#[test]
fn colors() {
    let orange = [1.0, 0.246_201_33, 0.0f32];
    for text in ["[1, 0.24620133, 0]", "\"#ff8800\"", "\"#F80\"", "{ srgb = [1, 0.5333333333, 0] }"] {
        let scene = parse(&format!(
            "[environment]\nhorizon = {text}\nzenith = {text}\n[[lights]]\npoint = {{ position = [0, 0, 0], color = {text} }}\n\
             [materials.plain]\ncolor = {text}\nemission_color = {text}\n[materials.rich.principled]\nbase_color = {text}\n\
             emissive = {text}\nsheen_color = {text}\nspecular_color = {text}\nattenuation_color = {text}\n\
             diffuse_transmission_color = {text}\nbase_color_texture = {{ checker = [{text}, \"#000\"] }}\n"
        ));
        let is_orange =
            |color: [f32; 3]| assert!(Vec3::from(color).abs_diff_eq(orange.into(), 1e-6), "{text}: {color:?}");
        let Environment::Gradient { horizon, zenith } = scene.environment else { panic!("a gradient") };
        let plain = &scene.materials[0];
        let rich = scene.materials[1].principled.as_ref().unwrap();
        for color in [horizon, zenith, scene.light_entries[0].color, plain.color, plain.emission_color] {
            is_orange(color.to_array());
        }
        for color in [rich.base_color, rich.emissive, rich.sheen_color, rich.specular_color, rich.attenuation_color] {
            is_orange(color);
        }
        is_orange(rich.diffuse_transmission_color);
        let checker = &rich.base_color_texture.as_ref().unwrap().image.texels;
        let Texels::Rgb32F(texels) = checker else { panic!("colours are numbers") };
        is_orange(texels[0]);
    }
}

/// What a light has without its optional keys, and what becomes of its numbers.
#[test]
fn lights() {
    let scene = parse(
        "[[lights]]\npoint = { position = [0, 1, 2] }\n[[lights]]\nspot = { position = [0, 1, 2], direction = [0, 0, -3] }\n\
         [[lights]]\ndirectional = { direction = [0, -2, 0], color = [1, 0.5, 0], intensity = 4 }\n\
         [[lights]]\ndirectional = { direction = [0, -2, 0], angle_degrees = 90 }\n",
    );
    let kinds = scene.lights.iter().map(|light| light.kind);
    let expected = [
        LightKind::Point,
        LightKind::Spot { inner: 0.0, outer: std::f32::consts::FRAC_PI_4 },
        LightKind::Directional,
        LightKind::Sun { half_angle: std::f32::consts::FRAC_PI_4 },
    ];
    assert_eq!(kinds.collect::<Vec<_>>(), expected);
    assert_eq!(scene.lights[0].intensity, [1.0; 3]);
    assert_eq!(scene.lights[0].position.to_array(), [0.0, 1.0, 2.0]);
    assert_eq!(scene.lights[1].direction.to_array(), [0.0, 0.0, -1.0]);
    assert_eq!((scene.lights[2].intensity, scene.lights[2].direction.to_array()), ([4.0, 2.0, 0.0], [0.0, -1.0, 0.0]));
    // A scene with a light is not dark, and one with a black light is.
    assert_eq!(scene.warnings, [""; 0]);
    let scene = parse("[[lights]]\npoint = { position = [0, 1, 2], intensity = 0 }\n");
    assert!(
        scene.warnings[0].ends_with(":7:1: `point` of light 1 gives no light: its `intensity` or its `color` is 0")
    );
    assert!(scene.warnings[1].contains("nothing in the scene shines"));
}

fn entry(shape: &Shape) -> Entry {
    let contents = Contents::Geometry(shape.geometry.clone());
    let (material, transform) = (Some(shape.material), Transform::IDENTITY);
    Entry { shapes: shape.entry..shape.entry + 1, material, contents, transform }
}

fn example_shapes() -> Vec<Shape> {
    let sphere = Geometry::Sphere { center: Vec3::Y, radius: 1.0 };
    let plane = Geometry::Plane { point: Vec3::ZERO, normal: Vec3::Y };
    let rectangle = Geometry::Rectangle { corner: Vec3::ZERO, edge_u: Vec3::X, edge_v: Vec3::Z };
    let disk = Geometry::Disk { center: Vec3::Y, normal: Vec3::Z, radius: 1.0 };
    let cylinder = Geometry::Cylinder { base: Vec3::Y, top: 3.0 * Vec3::Y, radius: 0.5, capped: false };
    let top = Vec3::new(2.0, 1.0, 0.0);
    let cone = Geometry::Cone { base: Vec3::Y, top, radius: 0.5, top_radius: 0.25, capped: true };
    let cuboid = Geometry::Box {
        center: Vec3::new(1.0, 2.0, 3.0),
        size: Vec3::new(1.0, 2.0, 3.0),
        rotation_degrees: Vec3::new(10.0, 20.0, 30.0),
    };
    let shapes = [(0, sphere), (1, plane), (1, rectangle), (1, disk), (1, cylinder), (1, cone), (1, cuboid)];
    let shapes = shapes.into_iter().enumerate();
    shapes.map(|(entry, (material, geometry))| Shape { entry, material, geometry }).collect()
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
         seed = 0xffff_ffff\nsampler = \"pcg\"\nfilter = \"point\"\nclamp = 12\nalpha = true\nsurface_offset = false\n",
    );
    let expected = RenderSettings {
        width: 65536,
        height: 1,
        samples: i32::MAX as u32,
        max_depth: 65535,
        seed: u32::MAX,
        sampler: Sampler::Pcg,
        filter: Filter::Point,
        clamp: Some(12.0),
        alpha: true,
        surface_offset: false,
        integrator: Integrator::Path,
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

#[test]
fn an_empty_principled_is_gltf_s_default_but_no_metal() {
    let scene = parse("[environment]\ncolor = [1, 1, 1]\n[materials.a]\nprincipled = {}\n");
    assert_eq!(scene.materials[0].principled.as_deref(), Some(&Principled::default()));
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn a_principled_that_is_given_a_strength_shines() {
    let scene =
        parse("[materials.a.principled]\nemissive_strength = 3\n[materials.b.principled]\nemissive = [0, 1, 0]\n");
    let emissive: Vec<[f32; 3]> = scene.materials.iter().map(|it| it.principled.as_ref().unwrap().emissive).collect();
    assert_eq!(emissive, [[3.0; 3], [0.0, 1.0, 0.0]]);
}

#[test]
fn warnings_of_coverage_that_does_nothing() {
    let scene = parse(
        "[environment]\ncolor = [1, 1, 1]\n[materials.a.principled]\nalpha = 0.5\nalpha_cutoff = 0.5\n\
         [materials.b.principled]\nalpha = 0.5\nalpha_cutoff = 0.5\nalpha_mode = \"blend\"\n",
    );
    let expected = [
        "scene.toml:9:1: `alpha` in [materials.a.principled] does nothing without `alpha_mode = \"blend\"` or `\"mask\"`",
        "scene.toml:10:1: `alpha_cutoff` in [materials.a.principled] does nothing without `alpha_mode = \"mask\"`",
        "scene.toml:13:1: `alpha_cutoff` in [materials.b.principled] does nothing without `alpha_mode = \"mask\"`",
    ];
    assert_eq!(scene.warnings, expected);
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
fn many_warnings_of_a_kind_are_one() {
    let materials = |count: u32| (0..count).map(|i| format!("[materials.m{i}]\npriority = 1\n")).collect::<String>();
    let light = "[environment]\ncolor = [1, 1, 1]\n";
    let warning = |place: &str, i: u32| {
        format!("scene.toml:{place}: `priority` in [materials.m{i}] does nothing without `refractive_index`")
    };
    let few = parse(&format!("{light}{}", materials(3)));
    assert_eq!(few.warnings, [warning("9:1", 0), warning("11:1", 1), warning("13:1", 2)]);
    let many = parse(&format!("{light}{}[materials.other]\nreflection = 1\n", materials(300)));
    let other =
        "scene.toml:609:1: `reflection` in [materials.other] does nothing without `refractive_index`".to_string();
    assert_eq!(many.warnings, [format!("{} (and 299 more like this)", warning("9:1", 0)), other]);
}

#[test]
fn projections() {
    let projection = |keys: &str| parse_with_camera(keys).camera.projection;
    assert_eq!(projection("orthographic_height = 2.5"), Projection::Orthographic { height: 2.5 });
    assert_eq!(
        projection("panorama = \"latitude-longitude\"\naperture_radius = 0"),
        Projection::Panoramic(Panorama::LatitudeLongitude)
    );
    let middle = Intrinsics { focal: [50.0, 60.0], principal_point: [20.5, 15.0], skew: 0.0, size: [41, 30] };
    assert_eq!(projection("intrinsics = { focal = [50, 60], size = [41, 30] }"), Projection::Calibrated(middle));
    let skewed = Intrinsics { principal_point: [-1.5, 31.0], skew: 0.25, ..middle };
    assert_eq!(
        projection("[camera.intrinsics]\nfocal = [50, 60]\nprincipal_point = [-1.5, 31]\nskew = 0.25\nsize = [41, 30]"),
        Projection::Calibrated(skewed)
    );
}

/// The scene of a camera with these keys in place of a field of view.
fn parse_with_camera(keys: &str) -> Scene {
    let text = format!("{}\n", HEAD.replace("vertical_fov_degrees = 40", keys));
    let scene = Scene::parse(&text, "scene.toml").unwrap();
    check_invariants(&scene);
    scene
}

/// A picture of another height has intrinsics in proportion; one of other proportions shows more to the sides.
#[test]
fn intrinsics_of_another_size() {
    let intrinsics = Intrinsics { focal: [50.0, 60.0], principal_point: [22.0, 10.0], skew: 1.0, size: [40, 30] };
    assert_eq!(intrinsics.resized(40, 30), intrinsics);
    let twice = Intrinsics { focal: [100.0, 120.0], principal_point: [44.0, 20.0], skew: 2.0, size: [80, 60] };
    assert_eq!(intrinsics.resized(80, 60), twice);
    let wider = Intrinsics { principal_point: [54.0, 20.0], size: [100, 60], ..twice };
    assert_eq!(intrinsics.resized(100, 60), wider);
}

#[test]
fn a_warning_of_radians() {
    let text = format!("{HEAD}[environment]\ncolor = [1, 1, 1]\n");
    let warnings =
        |angle: &str| Scene::parse(&text.replace("= 40", &format!("= {angle}")), "scene.toml").unwrap().warnings;
    let expected = "scene.toml:5:24: `vertical_fov_degrees` in [camera] is 0.7, which shows very little: if these are \
                    radians, write 40.1";
    assert_eq!(warnings("0.7"), [expected]);
    assert_eq!(warnings("3.2"), [""; 0]);
}
