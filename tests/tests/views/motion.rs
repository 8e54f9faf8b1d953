//! Motion vectors against closed forms in double precision.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use raggio_render::{DeviceScene, Feature};
use raggio_scene::{AssetOptions, Assets, Camera, Geometry, Intrinsics, Mesh, Panorama, Projection, Scene, rotation};
use raggio_tests::geometry::{Ray, nearest};
use raggio_tests::render::means;
use raggio_tests::{for_each_device, parse};

const WIDTH: u32 = 40;
const HEIGHT: u32 = 30;

fn scene(shapes: &str) -> Scene {
    parse(&format!(
        "[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\nfilter = \"blackman-harris\"\n
         [camera]\nposition = [0, 1, 5]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n
         [environment]\ncolor = [1, 1, 1]\n[materials.clay]\n{shapes}"
    ))
}

fn shape(geometry: &str) -> String {
    format!("[[shapes]]\nmaterial = \"clay\"\n{geometry}\n")
}

/// Axes of a camera: to the right, up, forward.
fn axes(camera: &Camera) -> [DVec3; 3] {
    let forward = (camera.look_at.as_dvec3() - camera.position.as_dvec3()).normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    [right, right.cross(forward), forward]
}

/// Place of a point in the picture, in pixels from its lower left corner.
fn pixel(camera: &Camera, point: DVec3) -> DVec2 {
    let from = point - camera.position.as_dvec3();
    let seen = DVec3::from(axes(camera).map(|axis| axis.dot(from)));
    let size = DVec2::new(f64::from(WIDTH), f64::from(HEIGHT));
    let scale = size.y / 2.0 / camera.half_height();
    match &camera.projection {
        Projection::Perspective { .. } => size / 2.0 + scale * seen.truncate() / seen.z,
        Projection::Orthographic { .. } => size / 2.0 + scale * seen.truncate(),
        // Their numbers count downwards, and are of a picture of this very size.
        Projection::Calibrated(Intrinsics { focal, principal_point, skew, .. }) => {
            let (x, down) = (seen.x / seen.z, -seen.y / seen.z);
            let [[fx, fy], [cx, cy]] = [*focal, *principal_point].map(|pair| pair.map(f64::from));
            DVec2::new(fx * x + f64::from(*skew) * down + cx, size.y - (fy * down + cy))
        }
        Projection::Panoramic(_) => {
            let turn = seen.x.atan2(seen.z) / std::f64::consts::TAU;
            size * DVec2::new(0.5 + turn, 0.5 + (seen.y / seen.length()).asin() / std::f64::consts::PI)
        }
    }
}

/// Ray through the middle of a pixel, of rows from the top.
fn ray(camera: &Camera, x: u32, y: u32) -> Ray {
    let eye = camera.position.as_dvec3();
    let [right, up, forward] = axes(camera);
    let place = DVec2::new(f64::from(x) + 0.5, f64::from(HEIGHT - y) - 0.5);
    let size = DVec2::new(f64::from(WIDTH), f64::from(HEIGHT));
    let at = (place - size / 2.0) * camera.half_height() / (size.y / 2.0);
    let (origin, direction) = match &camera.projection {
        Projection::Perspective { .. } => (eye, forward + at.x * right + at.y * up),
        Projection::Orthographic { .. } => (eye + at.x * right + at.y * up, forward),
        Projection::Calibrated(Intrinsics { focal, principal_point, skew, .. }) => {
            let [[fx, fy], [cx, cy]] = [*focal, *principal_point].map(|pair| pair.map(f64::from));
            let down = (size.y - place.y - cy) / fy;
            (eye, forward + (place.x - cx - f64::from(*skew) * down) / fx * right - down * up)
        }
        Projection::Panoramic(_) => {
            let (around, above) = (place.x / size.x - 0.5, place.y / size.y - 0.5);
            let ((x, z), (y, across)) =
                ((around * std::f64::consts::TAU).sin_cos(), (above * std::f64::consts::PI).sin_cos());
            (eye, across * (x * right + z * forward) + y * up)
        }
    };
    Ray { origin, direction: direction.normalize(), origin_error: 0.0 }
}

/// Checks the motion of every pixel on every device: `before` says where a point of the surface, or a direction of the sky
/// as a point far away, was seen a frame before; `None` for what has no motion. Returns the largest motion.
fn check(scene: &Scene, earlier: &Scene, before: impl Fn(&Ray) -> Option<[DVec2; 2]>) -> f64 {
    let mut translated = DeviceScene::new(scene).expect("the scene fits devices");
    translated.move_from(scene, earlier);
    let mut largest = 0f64;
    let expected: Vec<DVec2> = (0..HEIGHT)
        .flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
        .map(|(x, y)| before(&ray(&scene.camera, x, y)).map_or(DVec2::ZERO, |[now, before]| before - now))
        .collect();
    expected.iter().for_each(|motion| largest = largest.max(motion.length()));
    for_each_device(|device| {
        let mut session = device.device.load(&translated).expect("the scene loads");
        session.show(Feature::Motion).expect("motion is shown");
        session.add_samples(0..HEIGHT, 0..1).expect("samples are added");
        let found = means(&session.film().expect("the film is read"));
        // An edge may fall to either side of a pixel's middle.
        let near = |(found, expected): (&DVec3, &DVec2)| {
            (found.truncate() - *expected).length() < 2e-4 * (1.0 + expected.length()) && found.z == 0.0
        };
        let pairs = || found.iter().zip(&expected);
        let near = pairs().filter(|(found, expected)| near((found, expected))).count();
        let worst =
            pairs().max_by(|a, b| (a.0.truncate() - *a.1).length().total_cmp(&(b.0.truncate() - *b.1).length()));
        assert!(
            near >= expected.len() - 3,
            "{}: {near} of {} pixels are right, and {worst:?}",
            device.label,
            expected.len()
        );
    });
    largest
}

/// A camera whose keyframes turn the picture and spread its parallel rays, at two moments.
#[test]
fn keyframes_turn_pictures_and_spread_parallel_rays() {
    let keys = "orthographic_height = 4\n
        keyframes = [{ time = 0, up = [0, 1, 0], orthographic_height = 5 }, { time = 2, up = [1, 1, 0], orthographic_height = 3 }]";
    for interpolation in ["linear", "smooth"] {
        let at = |seconds| {
            let text = format!(
                "version = 1\n[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\n[camera]\nposition = [0, 1, 5]\n
                 look_at = [0, 1, 0]\n{keys}\ninterpolation = \"{interpolation}\"\n
                 [environment]\ncolor = [1, 1, 1]\n[materials.clay]\n{}",
                shape("sphere = { center = [0.3, 1, 0], radius = 1.2 }")
                    + &shape("plane = { point = [0, 0, -3], normal = [0, 0, 1] }")
            );
            let options = AssetOptions { time_seconds: Some(seconds), ..AssetOptions::default() };
            Scene::parse_with(&text, "scene.toml".as_ref(), &mut Assets::new(options)).expect("the scene is right")
        };
        let [earlier, now] = [0.5, 0.75].map(at);
        assert!(earlier.camera.up != now.camera.up && earlier.camera.half_height() > now.camera.half_height());
        let largest = check_maps(&now, &earlier, &[STILL; 2]);
        assert!(largest > 2.0, "{largest}");
    }
}

/// Point that a ray meets first, and the shape that it belongs to.
fn first_hit(scene: &Scene, ray: &Ray) -> Option<(DVec3, usize)> {
    let hits = scene.shapes.iter().enumerate();
    let hits = hits.filter_map(|(place, shape)| Some((nearest(&shape.geometry, ray)?.distance, place)));
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(distance, place)| (ray.at(distance), place))
}

/// Checks shapes that `maps` took to where they are from where they were, seen by the cameras of both scenes.
fn check_maps(scene: &Scene, earlier: &Scene, maps: &[DAffine3]) -> f64 {
    check(scene, earlier, |ray| {
        let (now, before) = match first_hit(scene, ray) {
            Some((point, place)) => (point, maps[place].transform_point3(point)),
            None if scene.camera.orthographic_height().is_some() => return None,
            // The sky is further away than the camera can go.
            None => {
                [&scene.camera, &earlier.camera].map(|camera| camera.position.as_dvec3() + 1e12 * ray.direction).into()
            }
        };
        let [now, mut before] = [pixel(&scene.camera, now), pixel(&earlier.camera, before)];
        if scene.camera.is_panoramic() {
            let width = f64::from(WIDTH);
            before.x -= width * ((before.x - now.x) / width).round();
        }
        Some([now, before])
    })
}

const STILL: DAffine3 = DAffine3::IDENTITY;

#[test]
fn a_still_has_none() {
    let scene = scene(&shape("sphere = { center = [0, 1, 0], radius = 1 }"));
    let translated = DeviceScene::new(&scene).expect("the scene fits devices");
    let mut same = translated.clone();
    same.move_from(&scene, &scene);
    for_each_device(|device| {
        for translated in [&translated, &same] {
            let mut session = device.device.load(translated).expect("the scene loads");
            session.show(Feature::Motion).expect("motion is shown");
            session.add_samples(0..HEIGHT, 0..1).expect("samples are added");
            assert!(means(&session.film().expect("the film is read")).iter().all(|motion| *motion == DVec3::ZERO));
        }
    });
}

/// A camera that moves sideways by d before a wall at the distance z: the wall goes the other way by d f / z pixels.
#[test]
fn a_camera_that_pans_moves_what_is_near_the_more() {
    let wall = shape("plane = { point = [0, 0, -1], normal = [0, 0, 1] }");
    let now = scene(&wall);
    let mut earlier = now.clone();
    earlier.camera.position.x -= 0.5;
    earlier.camera.look_at.x -= 0.5;
    let focal = f64::from(HEIGHT) / 2.0 / 20f64.to_radians().tan();
    let expected = DVec2::new(0.5 * focal / 6.0, 0.0);
    let largest = check(&now, &earlier, |ray| {
        Some([pixel(&now.camera, ray.at(1.0)), pixel(&now.camera, ray.at(1.0)) + expected])
    });
    assert!((largest - expected.length()).abs() < 1e-9 && largest > 3.0);
    check_maps(&now, &earlier, &[STILL]);
}

#[test]
fn cameras_turn_zoom_and_go_forward() {
    let shapes = shape("sphere = { center = [0.3, 1, 0], radius = 0.8 }")
        + &shape("plane = { point = [0, 0, 0], normal = [0, 1, 0] }");
    let fov = |vertical_fov_degrees| Projection::Perspective { vertical_fov_degrees };
    let calibrated = |skew| {
        let size = [WIDTH, HEIGHT];
        Projection::Calibrated(Intrinsics { focal: [45.0, 38.0], principal_point: [17.0, 18.5], skew, size })
    };
    let panorama = || Projection::Panoramic(Panorama::LatitudeLongitude);
    for [projection, other] in [[fov(40.0), fov(33.0)], [calibrated(3.0), calibrated(-2.0)], [panorama(), panorama()]] {
        let mut now = scene(&shapes);
        now.camera.projection = projection;
        let turned = Camera { look_at: Vec3::new(0.4, 1.3, 0.0), up: Vec3::new(0.1, 1.0, 0.0), ..now.camera.clone() };
        let nearer = Camera { position: Vec3::new(0.1, 1.1, 4.5), ..now.camera.clone() };
        let zoomed = Camera { projection: other, ..nearer.clone() };
        for camera in [turned, zoomed, nearer] {
            let earlier = Scene { camera, ..now.clone() };
            let largest = check_maps(&now, &earlier, &[STILL; 2]);
            assert!(largest > 1.0, "{largest}");
        }
    }
}

#[test]
fn parallel_rays_have_a_sky_without_motion() {
    let mut now = scene(&shape("box = { center = [0, 1, 0], size = [1, 1, 1], rotation_degrees = [20, 30, 0] }"));
    now.camera.projection = Projection::Orthographic { height: 3.0 };
    let mut earlier = now.clone();
    earlier.camera.position += Vec3::new(0.2, 0.1, 0.0);
    earlier.camera.look_at += Vec3::new(0.2, 0.1, 0.0);
    let largest = check_maps(&now, &earlier, &[STILL]);
    // Ten pixels are a unit of length.
    assert!((largest - 10.0 * 0.05f64.sqrt()).abs() < 1e-5, "{largest}");
}

#[test]
fn shapes_move_turn_and_grow() {
    let now = scene(
        &[
            shape("sphere = { center = [-0.8, 1.5, 0], radius = 0.6 }"),
            shape("box = { center = [0.7, 1.2, 0], size = [1, 0.8, 0.6], rotation_degrees = [10, 40, 5] }"),
            shape("rectangle = { corner = [-2, 0.2, 0.5], edge_u = [1.5, 0, 0], edge_v = [0, 0.6, 0] }"),
            shape("plane = { point = [0, 0, 0], normal = [0, 1, 0] }"),
        ]
        .concat(),
    );
    let mut earlier = now.clone();
    let mut place = |place: usize, geometry: Geometry| earlier.shapes[place].geometry = geometry;
    place(0, Geometry::Sphere { center: Vec3::new(-0.6, 1.4, 0.3), radius: 0.5 });
    let turned = Vec3::new(15.0, 20.0, 5.0);
    place(
        1,
        Geometry::Box { center: Vec3::new(0.8, 1.2, 0.1), size: Vec3::new(1.0, 0.8, 0.6), rotation_degrees: turned },
    );
    let [edge_u, edge_v] = [Vec3::new(1.2, 0.0, 0.9), Vec3::Y * 0.6];
    place(2, Geometry::Rectangle { corner: Vec3::new(-2.0, 0.3, 0.5), edge_u, edge_v });
    place(3, Geometry::Plane { point: Vec3::new(0.0, -0.1, 0.0), normal: Vec3::Y });
    let about = |center: [f64; 3]| DAffine3::from_translation(DVec3::from(center));
    let grown = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::splat(f64::from(0.5f32) / f64::from(0.6f32))));
    let turn = DAffine3::from_mat3(rotation(turned) * rotation(Vec3::new(10.0, 40.0, 5.0)).transpose());
    let swing = DAffine3::from_mat3(DMat3::from_cols(DVec3::new(0.8, 0.0, 0.6), DVec3::Y, DVec3::new(-0.6, 0.0, 0.8)));
    let largest = check_maps(
        &now,
        &earlier,
        &[
            about([-0.6, 1.4, 0.3]) * grown * about([-0.8, 1.5, 0.0]).inverse(),
            about([0.8, 1.2, 0.1]) * turn * about([0.7, 1.2, 0.0]).inverse(),
            about([-2.0, 0.3, 0.5]) * swing * about([-2.0, 0.2, 0.5]).inverse(),
            about([0.0, -0.1, 0.0]),
        ],
    );
    assert!(largest > 3.0, "{largest}");
}

#[test]
fn round_shapes_move_turn_and_grow() {
    let now = scene(
        &[
            shape("disk = { center = [-1, 1.5, 0], normal = [0, 0, 1], radius = 0.6 }"),
            shape("cylinder = { base = [0.8, 0.2, 0], top = [0.8, 1.2, 0], radius = 0.4 }"),
            shape("cone = { base = [-0.9, 0.1, 0.6], top = [-0.9, 0.7, 0.6], radius = 0.3, top_radius = 0.1 }"),
        ]
        .concat(),
    );
    let mut earlier = now.clone();
    let mut place = |place: usize, geometry: Geometry| earlier.shapes[place].geometry = geometry;
    place(0, Geometry::Disk { center: Vec3::new(-0.9, 1.6, 0.1), normal: Vec3::new(0.6, 0.0, 0.8), radius: 0.5 });
    let [base, top] = [Vec3::new(0.9, 0.1, 0.0), Vec3::new(0.9, 1.6, 0.0)];
    place(1, Geometry::Cylinder { base, top, radius: 0.5, capped: true });
    let [base, top] = [Vec3::new(-0.9, 0.1, 0.7), Vec3::new(-0.54, 0.58, 0.7)];
    place(2, Geometry::Cone { base, top, radius: 0.3, top_radius: 0.1, capped: true });
    let about = |center: [f64; 3]| DAffine3::from_translation(DVec3::from(center));
    let matrix =
        |x: [f64; 3], y: [f64; 3], z: [f64; 3]| DAffine3::from_mat3(DMat3::from_cols(x.into(), y.into(), z.into()));
    let shrunk = f64::from(0.5f32) / f64::from(0.6f32);
    let [c, s] = [0.8 * shrunk, 0.6 * shrunk];
    let wider = f64::from(0.5f32) / f64::from(0.4f32);
    let taller = f64::from(1.6f32 - 0.1f32) / f64::from(1.2f32 - 0.2f32);
    let largest = check_maps(
        &now,
        &earlier,
        &[
            about([-0.9, 1.6, 0.1])
                * matrix([c, 0.0, -s], [0.0, shrunk, 0.0], [s, 0.0, c])
                * about([-1.0, 1.5, 0.0]).inverse(),
            about([0.9, 0.1, 0.0])
                * matrix([wider, 0.0, 0.0], [0.0, taller, 0.0], [0.0, 0.0, wider])
                * about([0.8, 0.2, 0.0]).inverse(),
            about([-0.9, 0.1, 0.7])
                * matrix([0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0])
                * about([-0.9, 0.1, 0.6]).inverse(),
        ],
    );
    assert!(largest > 3.0, "{largest}");
}

/// A square of two triangles in the plane z = 0.
fn square(place: impl Fn([f32; 2]) -> [f32; 3]) -> Arc<Mesh> {
    let positions = [[-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [-1.0, 2.0]].map(place).to_vec();
    Arc::new(Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() })
}

fn with_meshes(scene: &Scene, meshes: &[(&Arc<Mesh>, DAffine3)]) -> Scene {
    let mut scene = scene.clone();
    let model = scene.shapes[0].clone();
    scene.shapes = meshes
        .iter()
        .map(|(mesh, world_from_mesh)| {
            let mesh = (*mesh).clone();
            let geometry = Geometry::Mesh { mesh, world_from_mesh: *world_from_mesh, first_material: None };
            raggio_scene::Shape { geometry, ..model.clone() }
        })
        .collect();
    scene
}

/// Instances of one mesh move each in its own way; their mesh is shared with the frame before.
#[test]
fn instances_move_each_in_its_own_way() {
    let base = scene(&shape("sphere = { center = [0, 1, 0], radius = 1 }"));
    let mesh = square(|[x, y]| [x, y, 0.0]);
    let near = DAffine3::from_translation(DVec3::new(-1.2, 0.2, 0.0));
    let far = DAffine3::from_translation(DVec3::new(1.0, 0.0, -1.0)) * DAffine3::from_scale(DVec3::splat(1.25));
    let [near_before, far_before] = [
        DAffine3::from_translation(DVec3::new(-1.0, 0.1, 0.5)) * DAffine3::from_rotation_y(0.3),
        far * DAffine3::from_rotation_z(0.1),
    ];
    let now = with_meshes(&base, &[(&mesh, near), (&mesh, far)]);
    let earlier = with_meshes(&base, &[(&mesh, near_before), (&mesh, far_before)]);
    check(&now, &earlier, |ray| {
        let hits = [(0.0, near, near_before), (-1.0, far, far_before)].into_iter().filter_map(|(z, map, before)| {
            let distance = (z - ray.origin.z) / ray.direction.z;
            let local = map.inverse().transform_point3(ray.at(distance));
            let is_inside = local.x.abs() <= 1.0 && (0.0..=2.0).contains(&local.y);
            is_inside.then(|| (distance, before.transform_point3(local)))
        });
        let (distance, before) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some([pixel(&now.camera, ray.at(distance)), pixel(&now.camera, before)])
    });
}

/// A mesh that changes its form, as skins and morph targets do, and moves at once: its points are those of the same place in
/// their triangle before. One with other triangles is taken to have moved as a whole.
#[test]
fn meshes_that_change_their_form_move_as_their_vertices_do() {
    let base = scene(&shape("sphere = { center = [0, 1, 0], radius = 1 }"));
    let mesh = square(|[x, y]| [x, y, 0.0]);
    let sheared = square(|[x, y]| [x + 0.25 * y, y, -0.5]);
    let map_before = DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.0));
    let now = with_meshes(&base, &[(&mesh, STILL)]);
    let on_square = |ray: &Ray| {
        let point = ray.at(-ray.origin.z / ray.direction.z);
        (point.x.abs() <= 1.0 && (0.0..=2.0).contains(&point.y)).then_some(point)
    };
    let earlier = with_meshes(&base, &[(&sheared, map_before)]);
    let largest = check(&now, &earlier, |ray| {
        let point = on_square(ray)?;
        let before = map_before.transform_point3(DVec3::new(point.x + 0.25 * point.y, point.y, -0.5));
        Some([pixel(&now.camera, point), pixel(&now.camera, before)])
    });
    assert!(largest > 2.0, "{largest}");
    // A turned triangle is the same one: a skin that mirrors makes it.
    let turned = Arc::new(Mesh { triangles: vec![[0, 2, 1], [0, 2, 3]], ..Mesh::clone(&sheared) });
    check(&now, &with_meshes(&base, &[(&turned, map_before)]), |ray| {
        let point = on_square(ray)?;
        let before = map_before.transform_point3(DVec3::new(point.x + 0.25 * point.y, point.y, -0.5));
        Some([pixel(&now.camera, point), pixel(&now.camera, before)])
    });
    let other = Arc::new(Mesh { triangles: vec![[0, 1, 3], [1, 2, 3]], ..Mesh::clone(&sheared) });
    check(&now, &with_meshes(&base, &[(&other, map_before)]), |ray| {
        let point = on_square(ray)?;
        Some([pixel(&now.camera, point), pixel(&now.camera, map_before.transform_point3(point))])
    });
}

/// What was behind the camera a frame before has no place in the picture then.
#[test]
fn what_was_behind_the_camera_has_no_motion() {
    let now = scene(&shape("plane = { point = [0, 0, -1], normal = [0, 0, 1] }"));
    let mut earlier = now.clone();
    earlier.camera.position.z = -2.0;
    earlier.camera.look_at.z = -3.0;
    assert_eq!(check(&now, &earlier, |_| None), 0.0);
}
