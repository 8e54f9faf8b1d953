//! Rays that hardware traces: they meet what software finds, and where.

use std::fmt::Write;

use glam::{DAffine3, DVec3, Vec3};
use raggio_kernels::{SPIRV, ShapeKind};
use raggio_render::{Answer, Device, DeviceScene, Probe, Session, Tracer, VulkanDevice};
use raggio_scene::{Geometry, Scene, Shape};
use raggio_tests::devices::{assert_valid, hardware, open_hardware, vulkan};
use raggio_tests::{Pcg, TestDevice, parse};
use raggio_vulkan::Device as VulkanContext;

use crate::shapes::SingleRay;
use crate::shapes::hierarchy::{random_rays, random_scene};
use crate::shapes::meshes::{ball, mesh, placed, rays, scene_of, scenes, soup};

/// Number of rays in a scene.
const RAYS: usize = 50_000;
/// Distance from an edge, in roundings, at which these may decide whether a ray meets a triangle.
const EDGE: f64 = 64.0;

fn trace(device: TestDevice, scene: &DeviceScene, rays: &[SingleRay]) -> Vec<Answer> {
    let questions: Vec<_> = rays.iter().map(|ray| ray.question([0.0; 3])).collect();
    device.ask_in(scene, Probe::Trace, &questions)
}

fn distance(answer: &Answer) -> Option<f32> {
    (answer[0][0] != -1.0).then_some(answer[0][0])
}

/// Agreement of two tracers over the rays of a scene.
#[derive(Debug, Default)]
struct Agreement {
    /// Rays that meet the same surface at the same distance, or nothing.
    equal: usize,
    /// Rays that meet surfaces at one distance, and other ones of them.
    ties: usize,
    /// Rays that software, or hardware, has go on past the edge of a triangle.
    passed_by_software: usize,
    passed_by_hardware: usize,
}

/// Compares what both find. Whoever finds a surface further away, or none, has gone past the edge of a triangle.
fn compare(name: &str, scene: &DeviceScene, rays: &[SingleRay], software: &[Answer], hardware: &[Answer]) -> Agreement {
    let mut agreement = Agreement::default();
    for ((ray, soft), hard) in rays.iter().zip(software).zip(hardware) {
        let (a, b) = (distance(soft), distance(hard));
        // Place and triangle.
        let same = soft[0][1] == hard[0][1] && soft[2][3] == hard[2][3];
        match (a, b) {
            (None, None) => agreement.equal += 1,
            (Some(a), Some(b)) if same => {
                // On one device the arithmetic is the same; compilers may fuse what they like.
                assert!((a - b).abs() <= 1e-6 * a.abs(), "{name}: {ray:?}: {a}, and by hardware {b}");
                agreement.equal += 1;
            }
            (Some(a), Some(b)) if (a - b).abs() <= 4e-6 * a.abs() => agreement.ties += 1,
            _ => {
                let nearest = |a: Option<f32>, b: Option<f32>| a.is_some_and(|a| b.is_none_or(|b| a < b));
                let (met, passed) = match nearest(a, b) {
                    true => (soft, &mut agreement.passed_by_hardware),
                    false => (hard, &mut agreement.passed_by_software),
                };
                let apart = from_edge(scene, ray, met);
                assert!(
                    apart.is_some_and(|apart| apart < EDGE),
                    "{name}: {ray:?}: software finds {soft:?}, hardware {hard:?}, {apart:?} roundings from an edge"
                );
                *passed += 1;
            }
        }
    }
    agreement
}

/// Distance at which the ray passes the nearest edge of the triangle that it has met, in roundings of the numbers that decide
/// it; `None` where it is no mesh's.
fn from_edge(scene: &DeviceScene, ray: &SingleRay, met: &Answer) -> Option<f64> {
    let shape = scene.buffers.order[met[0][1] as usize];
    if shape.kind != ShapeKind::Instance as u32 {
        return None;
    }
    let instance = &scene.buffers.instances[shape.index as usize];
    let triangle = &scene.buffers.triangles[met[2][3] as usize];
    let corner = |[x, y, z, _]: [f32; 4]| {
        let p = [x, y, z, 1.0].map(f64::from);
        let row = |row: [f32; 4]| row.iter().zip(p).map(|(a, b)| f64::from(*a) * b).sum::<f64>();
        DVec3::from_array(instance.world_from_mesh.map(row))
    };
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(corner);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let from_line = |a: DVec3, b: DVec3| {
        let across = direction.cross(b - a);
        (a - origin).dot(across).abs() / across.length().max(f64::MIN_POSITIVE)
    };
    let nearest = [from_line(a, b), from_line(b, c), from_line(c, a)].into_iter().fold(f64::INFINITY, f64::min);
    // Numbers that the ray and the triangle are compared by.
    let size = f64::from(instance.scale) + f64::from(met[0][0]);
    Some(nearest / (size * f64::from(f32::EPSILON)))
}

/// Shapes of every kind and meshes, of which half is there: of single surfaces by chance, of others by a mask.
fn holes(random: &mut Pcg) -> Scene {
    let mut text = String::from(
        "[camera]\nposition = [0, 0, 30]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40
         [materials.half.principled]\nbase_color = [0.8, 0.8, 0.8]\nalpha = 0.5\nalpha_mode = \"blend\"
         [materials.whole]\n",
    );
    for i in 0..60 {
        let (at, size) = (random.in_cube(8.0), random.log_between(0.3, 2.0));
        let at = format!("[{}, {}, {}]", at.x, at.y, at.z);
        let shape = match i % 3 {
            0 => format!("sphere = {{ center = {at}, radius = {size} }}"),
            1 => format!("rectangle = {{ corner = {at}, edge_u = [{size}, 0, 0], edge_v = [0, 0, {size}] }}"),
            _ => format!("box = {{ center = {at}, size = [{size}, 1, 1], rotation_degrees = [10, 20, {i}] }}"),
        };
        let material = if i % 5 == 0 { "whole" } else { "half" };
        write!(text, "[[shapes]]\nmaterial = \"{material}\"\n{shape}\n").expect("strings take all");
    }
    let mut scene = parse(&text);
    let meshes = [ball(12), soup(60, 1.0, random)];
    for i in 0..30 {
        let geometry =
            Geometry::Mesh { mesh: meshes[i % 2].clone(), world_from_mesh: placed(8.0, random), first_material: None };
        scene.shapes.push(Shape { entry: scene.shapes.len(), material: usize::from(i % 5 == 0), geometry });
    }
    scene
}

/// Hardware finds what software finds on the same device, in scenes with all kinds of shapes, mirrored, sheared and coincident
/// instances, and holes; and whether something stands before a distance is what the nearest says.
#[test]
fn hardware_meets_what_software_meets() {
    let (Some(hardware), Some(vulkan)) = (hardware(), vulkan()) else { return };
    let software = TestDevice { label: "software", device: vulkan, ..hardware };
    let random = &mut Pcg::new(31);
    let mut all: Vec<(String, Scene, Vec<SingleRay>)> = vec![];
    for (seed, count) in [(1, 1), (3, 2), (5, 20), (6, 1000)] {
        let scene = random_scene(count, &mut Pcg::new(seed));
        let rays = random_rays(&scene, random);
        all.push((format!("{count} shapes"), scene, rays));
    }
    for (name, room, scene) in scenes() {
        let rays = rays(&scene, room, RAYS, random);
        all.push((name.into(), scene, rays));
    }
    let scene = holes(random);
    let rays = rays(&scene, 8.0, RAYS, random);
    all.push(("holes".into(), scene, rays));

    for (name, scene, rays) in all {
        let scene = DeviceScene::new(&scene).expect("the scene fits devices");
        let (soft, hard) = (trace(software, &scene, &rays), trace(hardware, &scene, &rays));
        let agreement = compare(&name, &scene, &rays, &soft, &hard);
        let hits = hard.iter().filter(|answer| distance(answer).is_some()).count();
        println!("{name}: of {} rays {hits} meet something: {agreement:?}", rays.len());
        assert!(hits > rays.len() / 20 || scene.shapes() == 0, "{name}: only {hits} rays meet anything");
        // Rays that are aimed at no corner hardly ever come to an edge.
        let free: Vec<_> = (0..rays.len()).filter(|i| i % 3 == 2).collect();
        let of = |answers: &[Answer]| free.iter().map(|&i| answers[i]).collect::<Vec<_>>();
        let free_rays: Vec<_> = free.iter().map(|&i| rays[i]).collect();
        let agreement = compare(&name, &scene, &free_rays, &of(&soft), &of(&hard));
        let passed = agreement.passed_by_software + agreement.passed_by_hardware;
        assert!(passed <= rays.len() / 10_000, "{name}, rays at no corner: {agreement:?}");

        // A little before the nearest, a little behind it, and without a limit.
        let nearest = |i: usize| distance(&hard[i]).filter(|_| i % 3 < 2);
        let limit = |i: usize| nearest(i).map_or(f32::INFINITY, |near| near * [1.0 - 1e-5, 1.0 + 1e-5][i % 3]);
        let questions: Vec<_> = rays.iter().enumerate().map(|(i, ray)| ray.question([limit(i), 0.0, 0.0])).collect();
        let occluded = hardware.ask_in(&scene, Probe::Occluded, &questions);
        let expected = |i: usize| distance(&hard[i]).is_some_and(|near| near < limit(i));
        // Where needles are grazed, hardware's own distance, which the limit is compared with, may be wrong by more.
        let wrong: Vec<_> = (0..rays.len()).filter(|&i| (occluded[i][0][0] != 0.0) != expected(i)).collect();
        let first = wrong.first().map(|&i| (rays[i], limit(i), hard[i]));
        assert!(wrong.len() <= rays.len() / 2_000, "{name}: {} wrong answers, as to {first:?}", wrong.len());
    }
    assert_valid(hardware.device);
}

/// A closed mesh lets no ray out, at whatever edge or corner it aims, by software. Nor may it by hardware: Vulkan says that the
/// test of triangles is watertight. Mesa's software Vulkan is not: of rays at corners one in a hundred leaks.
#[test]
fn closed_meshes_do_not_leak_by_hardware() {
    let (Some(hardware), Some(vulkan)) = (hardware(), vulkan()) else { return };
    let software = TestDevice { label: "software", device: vulkan, ..hardware };
    let random = &mut Pcg::new(13);
    let ball = ball(24);
    let place = DAffine3::from_mat3_translation(placed(0.0, random).matrix3, DVec3::new(30.0, -20.0, 10.0));
    for (name, place) in [("at the origin", DAffine3::IDENTITY), ("sheared and away", place)] {
        let scene = DeviceScene::new(&scene_of(vec![(ball.clone(), place)], "")).expect("the scene fits devices");
        let corner = |index: u32| place.transform_point3(Vec3::from(ball.positions[index as usize]).as_dvec3());
        for (what, most) in [("corners", 0.0), ("edges", 1.0)] {
            let rays: Vec<_> = (0..100_000)
                .map(|_| {
                    let origin = place.transform_point3(random.in_cube(0.3));
                    let [a, b, _] = ball.triangles[random.below(ball.triangles.len())].map(corner);
                    SingleRay::new(origin, a + random.between(0.0, most) * (b - a) - origin)
                })
                .collect();
            let leaks = |device| trace(device, &scene, &rays).iter().filter(|a| distance(a).is_none()).count();
            let (soft, hard) = (leaks(software), leaks(hardware));
            println!("{name}: of {} rays at {what} {soft} leak by software, {hard} by hardware", rays.len());
            assert_eq!(soft, 0, "{name}, {what}: rays that leak by software");
            let most = if hardware.slow { rays.len() / 50 } else { 0 };
            assert!(hard <= most, "{name}, {what}: {hard} rays leak by hardware");
        }
    }
}

/// Rays that leave a surface do not find it again, whatever hardware makes of so short a way.
#[test]
fn rays_leave_surfaces_by_hardware() {
    let (Some(hardware), Some(vulkan)) = (hardware(), vulkan()) else { return };
    let software = TestDevice { label: "software", device: vulkan, ..hardware };
    let random = &mut Pcg::new(17);
    for (name, room, scene) in scenes() {
        let scene = DeviceScene::new(&scene).expect("the scene fits devices");
        let inside = |random: &mut Pcg| SingleRay::new(random.in_cube(1.5 * room), random.in_cube(1.0) * room);
        let rays: Vec<_> = (0..10_000).map(|_| inside(random)).collect();
        let questions: Vec<_> = rays.iter().map(|ray| ray.question(random.direction().as_vec3().to_array())).collect();
        let [soft, hard] = [software, hardware].map(|device| device.ask_in(&scene, Probe::Leave, &questions));
        let agreement = compare(name, &scene, &rays, &soft, &hard);
        println!("{name}: {agreement:?}");
        assert!(agreement.equal + agreement.ties + 20 >= rays.len(), "{name}: {agreement:?}");
    }
}

/// Whatever is edited, what is kept of the structures, refitted or built anew finds what a scene that was just loaded has.
#[test]
fn structures_follow_edits() {
    let Some(hardware) = hardware() else { return };
    let random = &mut Pcg::new(41);
    let (first, second) = (ball(6), mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]));
    // One scene has so many shapes that they are refitted, another so few that they are built anew.
    for count in [30, 5000] {
        let room = 20.0;
        let others = "[[shapes]]\nmaterial = \"a\"\nsphere = { center = [1, 0, 0], radius = 1.5 }
            [[shapes]]\nmaterial = \"a\"\nplane = { point = [0, -9, 0], normal = [0, 1, 0] }";
        let shapes = (0..count).map(|_| (first.clone(), placed(room, random))).collect();
        let mut scene = scene_of(shapes, others);
        let rays = rays(&scene, room, 5000, random);
        let questions: Vec<_> = rays.iter().map(|ray| ray.question([0.0; 3])).collect();
        let mut translated = DeviceScene::new(&scene).expect("the scene fits devices");
        let mut session = hardware.device.load(&translated).expect("the scene loads");
        let move_all = |scene: &mut Scene, by: DVec3| {
            for shape in &mut scene.shapes {
                match &mut shape.geometry {
                    Geometry::Mesh { world_from_mesh, .. } => world_from_mesh.translation += by,
                    Geometry::Sphere { center, .. } => *center += by.as_vec3(),
                    _ => {}
                }
            }
        };
        type Edit<'a> = (&'static str, &'a dyn Fn(&mut Scene));
        let edits: [Edit; 7] = [
            ("nothing", &|_| ()),
            ("the camera", &|scene| scene.camera.position.x += 1.0),
            ("a small step", &|scene| move_all(scene, DVec3::new(0.1, 0.0, 0.0))),
            ("a colour", &|scene| scene.materials[0].color *= 0.5),
            ("another mesh", &|scene| {
                let last = scene.shapes.len() - 1;
                let Geometry::Mesh { mesh, .. } = &mut scene.shapes[last].geometry else { panic!("a mesh") };
                *mesh = second.clone();
            }),
            ("fewer shapes", &|scene| scene.shapes.truncate(scene.shapes.len() - 3)),
            ("no meshes", &|scene| scene.shapes.retain(|shape| !matches!(shape.geometry, Geometry::Mesh { .. }))),
        ];
        for (what, edit) in edits {
            edit(&mut scene);
            translated.update(&scene).expect("the scene fits devices");
            session.restart(&translated).expect("the scene loads");
            assert_eq!(session.tracer(), Some(Tracer::Hardware));
            let found = session.ask(Probe::Trace, &questions).expect("the probe answers");
            // Places of shapes may be others.
            let fresh = trace(hardware, &translated, &rays);
            let distances = |answers: &[Answer]| answers.iter().map(|answer| answer[0][0]).collect::<Vec<_>>();
            assert_eq!(distances(&found), distances(&fresh), "{count} shapes, {what}");
        }
    }
    assert_valid(hardware.device);
}

/// The scene with a picture that takes next to nothing.
fn small(mut scene: Scene) -> DeviceScene {
    (scene.render.width, scene.render.height) = (64, 64);
    DeviceScene::new(&scene).expect("it can be translated")
}

/// Lists that are larger than storage buffers may be are reached by address beside the structure, too.
#[test]
fn hardware_and_lists_of_any_length() {
    let Some(device) = open_hardware() else { return };
    // The device lives as long as its tests do elsewhere; here it is leaked for the same reason.
    let device: &'static dyn Device = Box::leak(device);
    let hardware = TestDevice { label: "hardware", slow: true, device };
    let scene = small(scene_of(vec![(ball(60), DAffine3::from_scale(DVec3::splat(2.0)))], ""));
    let random = &mut Pcg::new(21);
    let rays: Vec<_> = (0..5000).map(|_| SingleRay::new(random.in_cube(4.0), random.direction())).collect();
    let small = trace(hardware, &scene, &rays);
    device.vulkan().expect("it is one").pretend_small_bindings(300_000);
    let wide = trace(hardware, &scene, &rays);
    let hits = small.iter().filter(|answer| distance(answer).is_some()).count();
    assert!(hits > rays.len() / 10, "only {hits} rays meet anything");
    let agreement = compare("wide", &scene, &rays, &small, &wide);
    assert!(agreement.equal + 2 >= rays.len(), "{agreement:?}");
    assert_valid(device);
}

/// Where the structures do not fit, software traces the rays, unless hardware alone is asked for; then the error counts them.
#[test]
fn structures_count_as_the_scene_does() {
    let Some(device) = open_hardware() else { return };
    let scene = small(scene_of(vec![(ball(100), DAffine3::IDENTITY)], ""));
    let context = device.vulkan().expect("it is one");
    let lists: usize = scene.buffers.bytes().iter().map(|list| list.bytes.len()).sum();
    // Room for the lists and an eighth more, which a structure over all triangles is not.
    context.pretend_small_memory(lists as u64 * 9 / 8);
    let error = device.load(&scene).err().expect("the structures do not fit").to_string();
    assert!(error.starts_with("this scene needs ") && error.contains(" GiB of memory on "), "{error}");

    let context = VulkanContext::with_ray_queries(context.physical()).expect("the device opens once more");
    let device = VulkanDevice::with_kernels(context.clone(), &SPIRV).expect("the kernels are known");
    let tracer = |session: Box<dyn Session>| session.tracer();
    assert_eq!(tracer(device.load(&scene).expect("all fits")), Some(Tracer::Hardware));
    context.pretend_small_memory(lists as u64 * 9 / 8);
    assert_eq!(tracer(device.load(&scene).expect("the lists fit")), Some(Tracer::Software));
}
