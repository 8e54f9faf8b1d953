//! Features of the first hit against the probes, and the film of radiance beside theirs.

use glam::DVec3;
use raggio_render::{Answer, DeviceScene, Feature, Probe, Question, Session};
use raggio_scene::{Filter, Scene};
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render::{load, means, relative_difference};
use raggio_tests::{for_each_device, parse, render};

use crate::views::still_life;

const FEATURES: [Feature; 9] = [
    Feature::Hit,
    Feature::Albedo,
    Feature::Normal,
    Feature::Depth,
    Feature::PlaneDepth,
    Feature::Position,
    Feature::Object,
    Feature::Material,
    Feature::Coverage,
];

/// Rays through the middles of all pixels, and the answers of what they meet.
fn first_hits(session: &mut dyn Session, scene: &Scene) -> Vec<(DVec3, Answer)> {
    let (width, height) = (scene.render.width, scene.render.height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x as f32 + 0.5, y as f32 + 0.5]));
    let questions: Vec<Question> =
        pixels.map(|[x, y]| [[x, y, width as f32, height as f32], [0.0; 4], [0.0; 4]]).collect();
    let rays = session.ask(Probe::Camera, &questions).expect("the camera answers");
    let questions: Vec<Question> = rays.iter().map(|[origin, direction, _]| [*origin, *direction, [0.0; 4]]).collect();
    let hits = session.ask(Probe::Trace, &questions).expect("the rays are traced");
    rays.iter().map(|ray| first_three(ray[1])).zip(hits).collect()
}

fn first_three(v: [f32; 4]) -> DVec3 {
    glam::Vec3::from_slice(&v).as_dvec3()
}

/// Value of a feature by its definition.
fn expected(feature: Feature, scene: &Scene, direction: DVec3, hit: &Answer) -> DVec3 {
    let [distance, place, number, _] = hit[0];
    if distance < 0.0 {
        return if feature == Feature::Coverage { DVec3::Y } else { DVec3::ZERO };
    }
    let distance = f64::from(distance);
    let forward = (scene.camera.look_at - scene.camera.position).as_dvec3().normalize();
    let material = &scene.materials[number as usize];
    let normal = first_three(hit[2]);
    match feature {
        Feature::Radiance | Feature::Hit => DVec3::ONE,
        Feature::Albedo if material.name == "lamp" => material.emission_color.as_dvec3(),
        Feature::Albedo => material.color.as_dvec3(),
        Feature::Normal => 0.5 - 0.5 * normal * normal.dot(direction).signum(),
        Feature::Depth => DVec3::splat(distance),
        Feature::PlaneDepth => DVec3::splat(distance * forward.dot(direction)),
        Feature::Position => first_three(hit[1]),
        Feature::Object => DVec3::splat(f64::from(place) + 1.0),
        Feature::Material => DVec3::splat(f64::from(number) + 1.0),
        Feature::Coverage => DVec3::new(1.0, 1.0, 0.0),
        Feature::GuideAlbedo | Feature::GuideNormal | Feature::Motion => unreachable!("they have tests of their own"),
    }
}

/// A GPU may round two compilations of one formula differently, and an edge then falls to the other side.
#[test]
fn features_are_those_of_the_first_hit() {
    let mut scene = still_life();
    scene.render.filter = Filter::Point;
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        let hits = first_hits(&mut *session, &scene);
        let missed = hits.iter().filter(|(_, hit)| hit[0][0] < 0.0).count();
        assert!((100..hits.len() - 100).contains(&missed), "the scene has both hits and misses");
        for feature in FEATURES {
            session.show(feature).expect("the feature is shown");
            session.add_samples(0..scene.render.height, 0..2).expect("samples are added");
            let film = session.film().expect("the film is read");
            assert!(film.pixels().iter().all(|pixel| (pixel.samples, pixel.rays) == (2, 2)), "{feature:?}");
            let found = means(&film);
            let near = found.iter().zip(&hits).filter(|(found, (direction, hit))| {
                relative_difference(**found, expected(feature, &scene, *direction, hit)) < 1e-5
            });
            let (near, all) = (near.count(), hits.len());
            assert!(near >= all * 995 / 1000, "{} {feature:?}: {near} of {all} pixels are right", device.label);
        }
    });
}

#[test]
fn devices_agree_on_features() {
    let Some(vulkan) = vulkan() else { return };
    let scene = still_life();
    for feature in FEATURES {
        let film = |device| {
            let mut session = load(device, &scene);
            session.show(feature).expect("the feature is shown");
            session.add_samples(0..scene.render.height, 0..8).expect("samples are added");
            means(&session.film().expect("the film is read"))
        };
        let (ours, theirs) = (film(vulkan), film(cpu()));
        let near = ours.iter().zip(&theirs).filter(|(a, b)| relative_difference(**a, **b) < 1e-5).count();
        assert!(near >= ours.len() * 99 / 100, "{feature:?}: {near} of {} pixels agree", ours.len());
    }
    assert_eq!(vulkan.validation_messages(), [""; 0]);
}

/// No glass sphere is seen in water of higher priority, only the wall behind it.
#[test]
fn hidden_boundaries_are_looked_through() {
    let scene = parse(
        "[render]\nwidth = 5\nheight = 5\nfilter = \"point\"\n
         [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 60\n
         [materials.water]\nrefractive_index = 1.33\npriority = 2\n
         [materials.glass]\nrefractive_index = 1.5\npriority = 1\n
         [materials.wall]\ncolor = [0.2, 0.4, 0.6]\n
         [[shapes]]\nmaterial = \"water\"\nbox = { center = [0, 0, 0], size = [20, 20, 20] }\n
         [[shapes]]\nmaterial = \"glass\"\nsphere = { center = [0, 0, -1.5], radius = 0.5 }\n
         [[shapes]]\nmaterial = \"wall\"\nrectangle = { corner = [-5, -5, -3], edge_u = [10, 0, 0], edge_v = [0, 10, 0] }\n",
    );
    let shape_of_place = DeviceScene::new(&scene).expect("it is translated").shape_of_place;
    let wall = shape_of_place.iter().position(|shape| *shape == 2).expect("the wall is there") as f64;
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        for feature in FEATURES {
            session.show(feature).expect("the feature is shown");
            session.add_samples(0..5, 0..1).expect("samples are added");
            let film = session.film().expect("the film is read");
            let (found, what) = (means(&film), format!("{}, {feature:?}", device.label));
            // The path goes into the sphere, out of it, to the wall; past the sphere the first ray arrives.
            assert_eq!((film.pixels()[12].rays, film.pixels()[0].rays), (3, 1), "{what}");
            let side = 30f64.to_radians().tan() * 0.8;
            for (place, direction) in [(12, DVec3::NEG_Z), (0, DVec3::new(-side, side, -1.0))] {
                let expected = match feature {
                    Feature::Radiance | Feature::Hit => DVec3::ONE,
                    Feature::Albedo => DVec3::new(0.2, 0.4, 0.6),
                    Feature::Normal => DVec3::new(0.5, 0.5, 1.0),
                    Feature::Depth => DVec3::splat(3.0 * direction.length()),
                    Feature::PlaneDepth => DVec3::splat(3.0),
                    Feature::Position => 3.0 * direction,
                    Feature::Object => DVec3::splat(wall + 1.0),
                    Feature::Material => DVec3::splat(3.0),
                    Feature::Coverage => DVec3::new(1.0, 1.0, 0.0),
                    Feature::GuideAlbedo | Feature::GuideNormal | Feature::Motion => unreachable!("tested alone"),
                };
                let error = relative_difference(found[place], expected);
                assert!(error < 1e-6, "{what}: expected {expected}, found {}", found[place]);
            }
        }
    });
}

/// Guides are those of the wall that is seen through glass and in mirrors, in the colours these leave of it, but of the
/// first surface where that is rough.
#[test]
fn guides_look_through_glass_and_into_mirrors() {
    let wall = DVec3::new(0.2, 0.4, 0.6);
    let behind = "rectangle = { corner = [-90, -90, -9], edge_u = [180, 0, 0], edge_v = [0, 180, 0] }";
    let front = "rectangle = { corner = [-90, -90, 9], edge_u = [180, 0, 0], edge_v = [0, 180, 0] }";
    let flat = "rectangle = { corner = [-9, -9, -2], edge_u = [18, 0, 0], edge_v = [0, 18, 0] }";
    let body = "box = { center = [0, 0, -3], size = [20, 20, 1] }";
    let pane =
        "principled = { base_color = [0.5, 0.8, 1], transmission = 1, roughness = 0, thin_walled = true, ior = 1 }";
    let towards = DVec3::new(0.5, 0.5, 1.0);
    // (what, its material, its shape, where the wall is, colour, normal as it is encoded)
    let cases = [
        ("nothing", "", "", behind, wall, towards),
        ("a pane", pane, flat, behind, DVec3::new(0.5, 0.8, 1.0) * wall, towards),
        (
            "glass",
            "color = [0.9, 0.9, 0.5]\nrefractive_index = 1.5\nreflection = 0",
            body,
            behind,
            DVec3::new(0.81, 0.81, 0.25) * wall,
            towards,
        ),
        (
            "a mirror",
            "color = [0.9, 0.8, 0.7]\nsmoothness = 1",
            flat,
            front,
            DVec3::new(0.9, 0.8, 0.7) * wall,
            DVec3::new(0.5, 0.5, 0.0),
        ),
        (
            "metal",
            "principled = { base_color = [1, 1, 1], metallic = 1, roughness = 0 }",
            flat,
            front,
            wall,
            DVec3::new(0.5, 0.5, 0.0),
        ),
        ("a mirror of the sky", "smoothness = 1", flat, behind, DVec3::ZERO, DVec3::splat(0.5)),
        ("chalk", "color = [0.7, 0.6, 0.5]", flat, behind, DVec3::new(0.7, 0.6, 0.5), towards),
        (
            "lacquer",
            "principled = { base_color = [0.7, 0.6, 0.5], clearcoat = 1, roughness = 1 }",
            flat,
            behind,
            DVec3::new(0.7, 0.6, 0.5),
            towards,
        ),
    ];
    for (what, material, shape, wall, albedo, normal) in cases {
        let subject = format!("[materials.m]\n{material}\n[[shapes]]\nmaterial = \"m\"\n{shape}\n");
        let scene = parse(&format!(
            "[render]\nwidth = 5\nheight = 5\n
             [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 20\n
             [materials.wall]\ncolor = [0.2, 0.4, 0.6]\n{}
             [[shapes]]\nmaterial = \"wall\"\n{wall}\n",
            if shape.is_empty() { "" } else { &subject },
        ));
        for_each_device(|device| {
            let mut session = load(device.device, &scene);
            for (feature, expected) in [(Feature::GuideAlbedo, albedo), (Feature::GuideNormal, normal)] {
                session.show(feature).expect("the feature is shown");
                session.add_samples(0..5, 0..4).expect("samples are added");
                for found in means(&session.film().expect("the film is read")) {
                    let near = (found - expected).abs().max_element() < 1e-5;
                    assert!(near, "{}, {what}, {feature:?}: expected {expected}, found {found}", device.label);
                }
            }
        });
    }
}

/// Mirrors that face each other have no end, and guides have.
#[test]
fn guides_end() {
    let scene = parse(
        "[render]\nwidth = 2\nheight = 2\n
         [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 20\n
         [materials.mirror]\ncolor = [1, 1, 1]\nsmoothness = 1\n
         [[shapes]]\nmaterial = \"mirror\"\nsphere = { center = [0, 0, 0], radius = 1 }\n",
    );
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        session.show(Feature::GuideAlbedo).expect("the feature is shown");
        session.add_samples(0..2, 0..1).expect("samples are added");
        let film = session.film().expect("the film is read");
        assert!(film.pixels().iter().all(|pixel| pixel.rays == 8), "{}", device.label);
        assert_eq!(means(&film), [DVec3::ONE; 4], "{}", device.label);
    });
}

#[test]
fn looking_at_features_leaves_the_picture_alone() {
    let scene = still_life();
    let rows = || 0..scene.render.height;
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        session.add_samples(rows(), 0..5).expect("samples are added");
        session.show(Feature::Normal).expect("normals are shown");
        session.add_samples(rows(), 0..3).expect("samples are added");
        let normals = session.film().expect("the film is read");
        let pixel = session.pixel(20, 16).expect("there is such a pixel");
        assert_eq!(pixel, normals.pixels()[16 * 42 + 20], "the pixel is of the film that is shown");

        // The last feature's film is kept when the view goes back and forth; another one begins empty.
        session.show(Feature::Radiance).expect("radiance is shown");
        session.add_samples(rows(), 5..8).expect("samples are added");
        session.show(Feature::Normal).expect("normals are shown again");
        assert_eq!(session.film().expect("the film is read"), normals, "{}", device.label);
        session.show(Feature::Depth).expect("depth is shown");
        assert_eq!(session.film().expect("the film is read").samples(), 0, "{}", device.label);
        session.show(Feature::Radiance).expect("radiance is shown");
        let expected = render(device.device, &scene, 8);
        assert_eq!(session.film().expect("the film is read"), expected, "{}", device.label);
    });
}

#[test]
fn a_restart_clears_both_films_and_shows_the_same() {
    for_each_device(|device| {
        let mut scene = still_life();
        let mut session = load(device.device, &scene);
        for size in [(42, 33), (20, 10)] {
            (scene.render.width, scene.render.height) = size;
            for feature in [Feature::Radiance, Feature::Hit] {
                session.show(feature).expect("the feature is shown");
                session.add_samples(0..10, 0..1).expect("samples are added");
            }
            let device_scene = DeviceScene::new(&scene).expect("the scene fits devices");
            session.restart(&device_scene).expect("the session restarts");
            session.add_samples(0..1, 0..1).expect("samples are added");
            let film = session.film().expect("the film is read");
            let what = format!("{}, {size:?}", device.label);
            assert_eq!((film.width(), film.height(), film.samples()), (size.0, size.1, size.0.into()), "{what}");
            assert!(means(&film).iter().all(|mean| *mean == DVec3::ZERO || *mean == DVec3::ONE), "{what}: hits");
            session.show(Feature::Radiance).expect("radiance is shown");
            assert_eq!(session.film().expect("the film is read").samples(), 0, "{what}");
        }
    });
}
