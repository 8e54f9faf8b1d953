//! Texture coordinates of closed forms, as docs/scene.md says them.

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use glam::DVec3;
use raggio_render::Feature;
use raggio_scene::{Bitmap, Principled, Scene, Texels, Texture, TextureFilter};
use raggio_tests::devices::long;
use raggio_tests::render::{load, means};
use raggio_tests::{TestDevice, for_each_device, parse};

/// Side of the image: a texel is as red as it is far to the right, and as green as it is far down.
const SIDE: u32 = 256;

/// Shape, a point of it, the direction from there to the eye, and the coordinates of the point.
type Case = (&'static str, [f64; 3], [f64; 3], [f64; 2]);

const SPHERE: &str = "sphere = { center = [1, 2, 3], radius = 2 }";
const FLOOR: &str = "plane = { point = [0.25, 0, 0.5], normal = [0, 1, 0] }";
const WALL: &str = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
const SIDE_WALL: &str = "plane = { point = [0, 0, 0], normal = [1, 0, 0] }";
const POSTER: &str = "rectangle = { corner = [1, 1, 0], edge_u = [4, 0, 0], edge_v = [0, 2, 0] }";
const BOX: &str = "box = { center = [0, 0, 0], size = [2, 4, 6] }";
const DISK: &str = "disk = { center = [1, 2, 3], normal = [0, 1, 0], radius = 2 }";
const DIAL: &str = "disk = { center = [1, 2, 3], normal = [0, 0, 1], radius = 2 }";
const CYLINDER: &str = "cylinder = { base = [1, 0, 3], top = [1, 4, 3], radius = 2 }";
const CONE: &str = "cone = { base = [1, 0, 3], top = [1, 2, 3], radius = 2 }";
const MOVED: &str = "box = { center = [0, 0, 0], size = [2, 4, 6] }\n\
                     transform = { translation = [5, 0, 0], rotation_degrees = [0, 90, 0], scale = 2 }";

const CASES: &[Case] = &[
    (SPHERE, [1.0, 2.0, 5.0], [0.0, 0.0, 1.0], [0.5, 0.5]),
    (SPHERE, [3.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.75, 0.5]),
    (SPHERE, [-1.0, 2.0, 3.0], [-1.0, 0.0, 0.0], [0.25, 0.5]),
    // 30 degrees to the right of the middle, and 60 above it.
    (SPHERE, [1.5, 3.7320508, 3.8660254], [0.25, 0.8660254, 0.4330127], [0.5833333, 0.1666667]),
    (FLOOR, [0.55, 0.0, 0.6], [0.0, 1.0, 0.0], [0.3, 0.1]),
    (FLOOR, [3.55, 0.0, -0.8], [0.0, 1.0, 0.0], [0.3, 0.7]),
    (WALL, [0.3, 0.2, 0.0], [0.0, 0.0, 1.0], [0.3, 0.8]),
    (SIDE_WALL, [0.0, 0.2, -0.3], [1.0, 0.0, 0.0], [0.3, 0.8]),
    (POSTER, [2.0, 2.5, 0.0], [0.0, 0.0, 1.0], [0.25, 0.25]),
    (POSTER, [1.1, 1.1, 0.0], [0.0, 0.0, 1.0], [0.025, 0.95]),
    (BOX, [0.5, 1.0, 3.0], [0.0, 0.0, 1.0], [0.75, 0.25]),
    (BOX, [0.5, 1.0, -3.0], [0.0, 0.0, -1.0], [0.25, 0.25]),
    (BOX, [1.0, 1.0, -1.5], [1.0, 0.0, 0.0], [0.75, 0.25]),
    (BOX, [-1.0, 1.0, -1.5], [-1.0, 0.0, 0.0], [0.25, 0.25]),
    (BOX, [0.5, 2.0, -1.5], [0.0, 1.0, 0.0], [0.75, 0.25]),
    (BOX, [0.5, -2.0, 1.5], [0.0, -1.0, 0.0], [0.75, 0.25]),
    (DISK, [2.0, 2.0, 2.5], [0.0, 1.0, 0.0], [0.75, 0.375]),
    (DIAL, [2.0, 2.5, 3.0], [0.0, 0.0, 1.0], [0.75, 0.375]),
    (CYLINDER, [1.0, 1.0, 5.0], [0.0, 0.0, 1.0], [0.5, 0.75]),
    (CYLINDER, [3.0, 3.0, 3.0], [1.0, 0.0, 0.0], [0.75, 0.25]),
    (CYLINDER, [-1.0, 3.0, 3.0], [-1.0, 0.0, 0.0], [0.25, 0.25]),
    (CYLINDER, [2.0, 4.0, 2.5], [0.0, 1.0, 0.0], [0.75, 0.375]),
    (CYLINDER, [2.0, 0.0, 3.5], [0.0, -1.0, 0.0], [0.75, 0.375]),
    (CONE, [1.0, 1.0, 4.0], [0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], [0.5, 0.5]),
    (CONE, [1.5, 1.5, 3.0], [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0], [0.75, 0.25]),
    (CONE, [2.0, 0.0, 3.5], [0.0, -1.0, 0.0], [0.75, 0.375]),
    // The box's face toward +Z looks along +X, and is twice as large.
    (MOVED, [11.0, 2.0, -1.0], [1.0, 0.0, 0.0], [0.75, 0.25]),
];

fn scene((shape, point, eye, _): Case) -> Scene {
    let [point, eye] = [point, eye].map(DVec3::from_array);
    let position = point + 0.5 * eye;
    let up = if eye.y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    let array = |v: DVec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
    let [position, point, up] = [position, point, up].map(array);
    let mut scene = parse(&format!(
        "[render]\nwidth = 1\nheight = 1\nfilter = \"point\"\n
         [camera]\nposition = {position}\nlook_at = {point}\nup = {up}\nvertical_fov_degrees = 1\n
         [materials.m.principled]\n[[shapes]]\nmaterial = \"m\"\n{shape}\n"
    ));
    let texel = |i: u32| [(i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5, 0.0].map(|x| x / SIDE as f32);
    let texels = Texels::Rgb32F((0..SIDE * SIDE).map(texel).collect());
    let image = Arc::new(Bitmap { width: SIDE, height: SIDE, texels });
    let texture = Texture { filter: TextureFilter::Nearest, ..Texture::new(image) };
    let surface = Principled { base_color_texture: Some(texture), ..Principled::default() };
    scene.materials[0].principled = Some(surface.into());
    scene
}

/// Coordinates at the point that the camera looks at.
fn seen(device: TestDevice, scene: &Scene) -> [f64; 2] {
    let mut session = load(device.device, scene);
    session.show(Feature::Albedo).expect("albedo can be shown");
    session.add_samples(0..1, 0..1).expect("the device renders");
    let mean = means(&session.film().expect("the film can be read"))[0];
    [mean.x, mean.y]
}

#[test]
fn coordinates_are_as_documented() {
    for_each_device(|device| {
        // Software Vulkan takes minutes to compile kernels for all materials.
        if device.slow && !long() {
            return;
        }
        for &case in CASES {
            let found = seen(device, &scene(case));
            let near = (0..2).all(|i| (found[i] - case.3[i]).abs() <= 1.0 / f64::from(SIDE));
            assert!(near, "{}: {} at {:?}: {found:?} instead of {:?}", device.label, case.0, case.1, case.3);
        }
    });
}
