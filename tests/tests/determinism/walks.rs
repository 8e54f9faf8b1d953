//! Ways of rays through the CPU's hierarchies, and numbers of paths that kernels follow at once: all make the same picture,
//! bit for bit.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use raggio_kernels::cpu::{CpuScene, TracedHit, TracedRay, follow};
use raggio_render::{CpuDevice, CpuOptions, DeviceScene, Feature, FilmPixel, InstructionSet, Walk};
use raggio_scene::{Geometry, Integrator, Scene, Shape};
use raggio_tests::devices::{lacks, long};
use raggio_tests::render::load;
use raggio_tests::{Pcg, parse};

use crate::determinism::scenes_of_all_kinds;
use crate::shapes::meshes::{ball, soup};

const SAMPLES: u32 = 4;
const WALKS: [Walk; 3] = [Walk::Wide, Walk::InTurn, Walk::Portable];

/// Hundreds of closed forms and instances of meshes side by side, some exactly where others are, some that let part of the
/// light pass, glass within glass.
fn crowd() -> Scene {
    let mut text = String::from(
        "[render]\nwidth = 42\nheight = 33\nmax_depth = 9\n[environment]\ncolor = [0.5, 0.6, 0.7]
         [camera]\nposition = [0, 0, 30]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40
         [materials.clay]\ncolor = [0.7, 0.6, 0.5]\n[materials.lamp]\nemission_color = [1, 1, 1]\nemission_strength = 3
         [materials.glass]\nrefractive_index = 1.5\nsmoothness = 1\n[materials.water]\nrefractive_index = 1.3\nsmoothness = 1
         [materials.veil.principled]\nalpha = 0.5\nalpha_mode = \"blend\"\nbase_color = [0.2, 0.8, 0.3]
         [materials.metal.principled]\nmetallic = 1\nroughness = 0.3\n",
    );
    let random = &mut Pcg::new(3);
    let names = ["clay", "clay", "lamp", "glass", "water", "veil", "metal"];
    let mut last = String::new();
    for i in 0..300 {
        let v = |v: DVec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
        let (at, size) = (random.in_cube(10.0), random.log_between(0.1, 2.0));
        if i % 7 != 1 {
            last = match random.below(5) {
                0 => format!("sphere = {{ center = {}, radius = {size} }}", v(at)),
                1 => format!(
                    "box = {{ center = {}, size = [{size}, 1, 1], rotation_degrees = {} }}",
                    v(at),
                    v(90.0 * at)
                ),
                2 => {
                    let (top, capped) = (at + random.log_between(0.1, 2.0) * random.direction(), random.below(2) == 0);
                    let narrow = size * random.between(0.0, 1.0);
                    let ends = format!("base = {}, top = {}, radius = {size}, capped = {capped}", v(at), v(top));
                    match random.below(3) {
                        0 => format!("cylinder = {{ {ends} }}"),
                        _ => format!("cone = {{ {ends}, top_radius = {narrow} }}"),
                    }
                }
                3 => format!("disk = {{ center = {}, normal = {}, radius = {size} }}", v(at), v(random.direction())),
                _ => {
                    let axis = random.below(3);
                    let (u, w) = (DVec3::AXES[axis] * size, DVec3::AXES[(axis + 1) % 3]);
                    format!("rectangle = {{ corner = {}, edge_u = {}, edge_v = {} }}", v(at), v(u), v(w))
                }
            };
        }
        text += &format!("[[shapes]]\nmaterial = \"{}\"\n{last}\n", names[random.below(names.len())]);
    }
    text += "[[shapes]]\nmaterial = \"clay\"\nplane = { point = [0, -11, 0], normal = [0, 1, 0] }\n";
    let mut scene = parse(&text);
    let meshes = [soup(300, 2.0, random), ball(12), ball(3)];
    for i in 0..40 {
        let map = if i == 0 {
            DAffine3::IDENTITY
        } else {
            let turn = random.direction();
            DAffine3::from_translation(random.in_cube(10.0))
                * DAffine3::from_axis_angle(turn, f64::from(i))
                * DAffine3::from_scale(DVec3::splat(random.log_between(0.1, 1.5)) * DVec3::new(1.0, 1.0, -1.0))
        };
        let material = random.below(scene.materials.len());
        let mesh = Arc::clone(&meshes[random.below(3)]);
        let geometry = Geometry::Mesh { mesh, world_from_mesh: map, first_material: None };
        scene.shapes.push(Shape { entry: scene.shapes.len(), material, geometry });
    }
    scene
}

/// Film of `scene` on the CPU, of a feature of what rays meet first or of light.
fn film(options: CpuOptions, scene: &Scene, feature: Feature) -> Vec<FilmPixel> {
    let device = CpuDevice::new(options).expect("the set is available");
    let mut session = load(&device, scene);
    session.show(feature).expect("the feature can be shown");
    session.add_samples(0..scene.render.height, 0..SAMPLES).expect("the device renders");
    session.film().expect("the film can be read").pixels().to_vec()
}

#[test]
fn all_walks_and_levels_make_one_picture() {
    let scenes = scenes_of_all_kinds().into_iter().chain([("crowd", crowd())]);
    for (name, mut scene) in scenes {
        for (integrator, feature) in [
            (Integrator::Path, Feature::Radiance),
            (Integrator::Reference, Feature::Radiance),
            (Integrator::Path, Feature::Depth),
            (Integrator::Path, Feature::GuideAlbedo),
        ] {
            scene.render.integrator = integrator;
            let mut first: Option<Vec<FilmPixel>> = None;
            for set in InstructionSet::available() {
                for walk in WALKS {
                    let options = CpuOptions { instruction_set: Some(set), walk, ..CpuOptions::default() };
                    let film = film(options, &scene, feature);
                    let first = first.get_or_insert_with(|| film.clone());
                    let differ = film.iter().zip(&*first).filter(|(a, b)| a != b).count();
                    assert_eq!(
                        differ,
                        0,
                        "{name}, {integrator:?}, {feature:?}, {}, {walk:?}: pixels differ",
                        set.name()
                    );
                }
            }
            let seen = first.expect("there are levels");
            let rejected: u32 = seen.iter().map(|pixel| pixel.rejected).sum();
            let seen = seen.iter().filter(|pixel| pixel.rays > SAMPLES).count() as u32 + rejected;
            assert!(feature != Feature::Radiance || seen > 100, "{name}: few paths meet anything");
        }
    }
}

/// What single rays find is the same on all ways, whether they want the nearest surface or any: a million rays in
/// `make test-long`.
#[test]
fn rays_find_the_same() {
    let buffers = DeviceScene::new(&crowd()).expect("the scene fits").buffers;
    let random = &mut Pcg::new(5);
    let rays: Vec<_> = (0..if long() { 1_000_000 } else { 5000 })
        .map(|i| TracedRay {
            origin: random.in_cube(12.0).as_vec3().to_array(),
            direction: random.direction().as_vec3().to_array(),
            key: random.below(1 << 31) as u32,
            any: i % 3 == 0,
        })
        .collect();
    let mut expected: Option<Vec<TracedHit>> = None;
    // Rays take turns with those that are followed at once.
    let all = rays.len();
    for (walk, at_once) in [(Walk::Portable, all), (Walk::Wide, all), (Walk::InTurn, all), (Walk::InTurn, 7)] {
        for set in InstructionSet::available() {
            let scene = CpuScene::new(buffers.clone(), set, walk).expect("the scene is whole");
            let mut hits = vec![TracedHit::NOTHING; rays.len()];
            for (rays, hits) in rays.chunks(at_once).zip(hits.chunks_mut(at_once)) {
                follow(set, &scene, rays, hits);
            }
            // Of any surfaces each way may find another.
            for (hit, ray) in hits.iter_mut().zip(&rays).filter(|(_, ray)| ray.any) {
                let found = if hit.shape == u32::MAX { 0.0 } else { 1.0 };
                assert!(hit.distance > 0.0, "{ray:?}: {hit:?}");
                *hit = TracedHit { distance: found, ..TracedHit::NOTHING };
            }
            let expected = expected.get_or_insert_with(|| hits.clone());
            let other = hits.iter().zip(&*expected).position(|(found, expected)| found != expected);
            assert_eq!(other.map(|i| (rays[i], hits[i], expected[i])), None, "{walk:?} {set:?} {at_once}");
        }
    }
    let found = expected.expect("some level is there").iter().filter(|hit| hit.shape != u32::MAX).count();
    assert!((rays.len() / 10..9 * rays.len() / 10).contains(&found), "{found} of the rays find something");
}

/// Binary nodes that were given up are read by no level that needs them.
#[test]
fn levels_without_wide_walks_are_refused_where_nodes_were_given_up() {
    let levels = InstructionSet::available();
    if !levels.contains(&InstructionSet::X86V3) {
        return lacks("rays walk through nodes of eight children on processors with AVX2 alone");
    }
    let buffers = DeviceScene::new(&crowd()).expect("the scene fits").buffers;
    let ray = TracedRay { origin: [0.0, 0.0, 30.0], direction: [0.0, 0.0, -1.0], key: 0, any: false };
    for scene_level in [InstructionSet::X86V3, InstructionSet::X86V2] {
        let mut scene = CpuScene::new(buffers.clone(), scene_level, Walk::Wide).expect("the scene is whole");
        scene.settle();
        for &set in &levels {
            let followed = std::panic::catch_unwind(|| {
                let mut hits = [TracedHit::NOTHING];
                follow(set, &scene, &[ray], &mut hits);
                hits[0]
            });
            let walks_wide = matches!(set, InstructionSet::X86V3 | InstructionSet::X86V4);
            assert_eq!(
                followed.is_ok(),
                walks_wide || scene_level == InstructionSet::X86V2,
                "{scene_level:?}, {set:?}"
            );
        }
    }
}
