//! Transparent bodies in, through and beside one another: each pixel must show the stripe of a wall that a path in
//! double precision arrives at, as bright as the media at both its ends make it.

use glam::{DVec2, DVec3, Vec3};
use raggio_scene::{Geometry, Scene};
use raggio_tests::geometry::{Ray, nearest, refracted, rotation};
use raggio_tests::render::means;
use raggio_tests::{for_each_device, render};

use crate::closed_forms::{View, materials, shapes};

/// Place of the wall along z, and below it the width of its stripes; the k-th from the left has the radiance k + 1.
const WALL_Z: f64 = -5.0;
const STRIPE: f64 = 0.25;
const STRIPES: usize = 80;

/// Bodies as (material, shape); the camera's first, the outermost before those inside it.
struct Case {
    what: &'static str,
    /// Media of the bodies: (name, refractive index, priority).
    media: &'static [(&'static str, f64, i32)],
    bodies: &'static [(&'static str, &'static str)],
}

/// Body that fills all space before the camera and behind it.
const SEA: &str = "plane = { point = [0, 0, 20], normal = [0, 0, 1] }";
/// Body that fills all space beyond the middle.
const BEYOND: &str = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
const BALL: &str = "sphere = { center = [0, 0, 0], radius = 1.5 }";
const CORE: &str = "sphere = { center = [0.3, 0.2, 0.1], radius = 0.8 }";
const CUBE: &str = "box = { center = [0, 0, 0], size = [3, 4, 1.5], rotation_degrees = [10, 20, 30] }";
const SHEET: &str = "box = { center = [0, 0, 1], size = [90, 90, 1.5] }";
const AROUND_CAMERA: &str = "box = { center = [0, 0, 5], size = [90, 90, 3] }";

const ROD: &str = "cylinder = { base = [-1.2, -1, -0.5], top = [1, 1.1, 0.7], radius = 0.9 }";
const SPIRE: &str = "cone = { base = [0.3, -1.6, 0.2], top = [-0.4, 1.9, 0.5], radius = 1.7 }";
const BUCKET: &str = "cone = { base = [0, 0, 1.4], top = [0.3, 0.2, -1], radius = 1.6, top_radius = 0.8 }";
const TUBE_AROUND_CAMERA: &str = "cylinder = { base = [0, 0, 9], top = [0, 0, 3], radius = 4 }";

const CASES: [Case; 22] = [
    Case { what: "glass rod in air", media: &[("glass", 1.5, 0)], bodies: &[("glass", ROD)] },
    Case {
        what: "glass spire in water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", SPIRE)],
    },
    Case {
        what: "bubble in a bucket of glass",
        media: &[("glass", 1.5, 0), ("bubble", 1.0, 0)],
        bodies: &[("glass", BUCKET), ("bubble", CORE)],
    },
    Case {
        what: "a rod and a spire overlap",
        media: &[("a", 1.2, 1), ("b", 1.6, 2)],
        bodies: &[("a", ROD), ("b", SPIRE)],
    },
    Case {
        what: "the camera in a tube",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", TUBE_AROUND_CAMERA), ("glass", BALL)],
    },
    Case { what: "glass ball in air", media: &[("glass", 1.5, 0)], bodies: &[("glass", BALL)] },
    Case { what: "turned diamond in air", media: &[("diamond", 2.4, 0)], bodies: &[("diamond", CUBE)] },
    Case {
        what: "glass ball in water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", BALL)],
    },
    Case {
        what: "turned glass box in water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", CUBE)],
    },
    Case {
        what: "glass beyond water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", BEYOND)],
    },
    Case {
        what: "bubble in a glass ball",
        media: &[("glass", 1.5, 0), ("bubble", 1.0, 0)],
        bodies: &[("glass", BALL), ("bubble", CORE)],
    },
    Case {
        what: "bubble in water",
        media: &[("water", 1.33, 0), ("bubble", 1.0, 0)],
        bodies: &[("water", SEA), ("bubble", BALL)],
    },
    Case {
        what: "bubble in glass in water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0), ("bubble", 1.0, 0)],
        bodies: &[("water", SEA), ("glass", BALL), ("bubble", CORE)],
    },
    Case {
        what: "camera inside glass inside water",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", AROUND_CAMERA)],
    },
    Case {
        what: "camera inside glass inside water of a higher priority",
        media: &[("water", 1.33, 1), ("glass", 1.5, 0)],
        bodies: &[("water", SEA), ("glass", AROUND_CAMERA)],
    },
    Case {
        what: "ball half in water, the ball wins",
        media: &[("water", 1.33, 0), ("glass", 1.5, 1)],
        bodies: &[("water", BEYOND), ("glass", BALL)],
    },
    Case {
        what: "ball half in water, the water wins",
        media: &[("water", 1.33, 1), ("glass", 1.5, 0)],
        bodies: &[("water", BEYOND), ("glass", BALL)],
    },
    Case {
        what: "ball half in water, the one entered last wins",
        media: &[("water", 1.33, 0), ("glass", 1.5, 0)],
        bodies: &[("water", BEYOND), ("glass", BALL)],
    },
    Case {
        what: "sheet that sticks out of a ball, the sheet wins",
        media: &[("water", 1.33, -3), ("glass", 1.5, 7)],
        bodies: &[("water", BALL), ("glass", SHEET)],
    },
    Case {
        what: "sheet that sticks out of a ball, the ball wins",
        media: &[("water", 1.33, 2), ("glass", 1.5, 1)],
        bodies: &[("water", BALL), ("glass", SHEET)],
    },
    Case {
        what: "one material, overlapping",
        media: &[("glass", 1.5, 0)],
        bodies: &[("glass", SHEET), ("glass", BALL)],
    },
    Case {
        what: "three overlap",
        media: &[("a", 1.2, 1), ("b", 1.6, 3), ("c", 1.4, 2)],
        bodies: &[("a", CUBE), ("b", CORE), ("c", BALL)],
    },
];

fn view() -> View {
    View::new([0.1, -0.15, 5.0], [0.0, 0.0, 0.0], 30.0).size(192, 48).depth(40)
}

fn wall() -> (String, String) {
    let left = -0.5 * STRIPE * STRIPES as f64;
    let stripes = 0..STRIPES;
    let material = |i: usize| format!("[materials.stripe{i}]\ncolor = [0, 0, 0]\nemission_strength = {}\n", i + 1);
    let shape = |i: usize| {
        let corner = left + STRIPE * i as f64;
        format!(
            "[[shapes]]\nmaterial = \"stripe{i}\"\nrectangle = {{ corner = [{corner}, -50, {WALL_Z}], \
             edge_u = [{STRIPE}, 0, 0], edge_v = [0, 100, 0] }}\n"
        )
    };
    (stripes.clone().map(material).collect(), stripes.map(shape).collect())
}

fn scene(case: &Case) -> Scene {
    let keys = |index: f64, priority: i32| {
        format!("color = [1, 1, 1]\nrefractive_index = {index:?}\nreflection = 0\npriority = {priority}")
    };
    let media: Vec<_> = case.media.iter().map(|&(name, index, priority)| (name, keys(index, priority))).collect();
    let media = materials(&media.iter().map(|(name, keys)| (*name, keys.as_str())).collect::<Vec<_>>());
    let (stripe_materials, stripes) = wall();
    let rest = [media, stripe_materials, shapes(case.bodies), stripes].concat();
    view().scene_with("filter = \"point\"", "", &rest)
}

/// Whether a point is inside a body.
fn contains(body: &Geometry, p: DVec3) -> bool {
    match *body {
        Geometry::Mesh { .. } => unreachable!("there are no meshes here"),
        Geometry::Sphere { center, radius } => p.distance(center.as_dvec3()) < f64::from(radius),
        Geometry::Plane { point, normal } => normal.as_dvec3().dot(p - point.as_dvec3()) < 0.0,
        Geometry::Box { center, size, rotation_degrees } => {
            let local = rotation(rotation_degrees.as_dvec3()).transpose() * (p - center.as_dvec3());
            local.abs().cmplt(0.5 * size.as_dvec3()).all()
        }
        Geometry::Cylinder { base, top, radius, .. } => between(base, top, [radius; 2], p),
        Geometry::Cone { base, top, radius, top_radius, .. } => between(base, top, [radius, top_radius], p),
        Geometry::Rectangle { .. } | Geometry::Disk { .. } => false,
    }
}

/// Whether a point is between two circles around the axis between these centres.
fn between(base: Vec3, top: Vec3, radii: [f32; 2], p: DVec3) -> bool {
    let [base, top] = [base, top].map(|center| center.as_dvec3());
    let part = (p - base).dot(top - base) / (top - base).length_squared();
    let radius = f64::from(radii[0]) + part * f64::from(radii[1] - radii[0]);
    (0.0..1.0).contains(&part) && p.distance(base + part * (top - base)) < radius
}

/// Path of light in double precision: the point where it hits the wall's plane, and the index there over that at the
/// camera.
struct Reference<'a> {
    /// Bodies with the refractive index and the priority of each.
    bodies: Vec<(&'a Geometry, f64, i32)>,
}

impl<'a> Reference<'a> {
    fn new(scene: &'a Scene, count: usize) -> Self {
        let body = |shape: &'a raggio_scene::Shape| {
            let material = &scene.materials[shape.material];
            (&shape.geometry, f64::from(material.refractive_index.unwrap_or(1.0)), material.priority)
        };
        Self { bodies: scene.shapes[..count].iter().map(body).collect() }
    }

    /// Refractive index at a point inside these bodies, in the order they were entered: that of the body of the highest
    /// priority entered last.
    fn index(&self, inside: &[usize]) -> f64 {
        inside.iter().max_by_key(|&&body| self.bodies[body].2).map_or(1.0, |&body| self.bodies[body].1)
    }

    /// Follows a ray to the wall's plane; `None` if light never gets there.
    fn arrive(&self, mut ray: Ray) -> Option<(DVec2, f64)> {
        let mut inside: Vec<_> = (0..self.bodies.len()).filter(|&i| contains(self.bodies[i].0, ray.origin)).collect();
        let at_camera = self.index(&inside);
        for _ in 0..40 {
            let to_wall = (WALL_Z - ray.origin.z) / ray.direction.z;
            let crossings = (0..self.bodies.len()).filter_map(|i| Some((i, nearest(self.bodies[i].0, &ray)?)));
            let next = crossings.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
            let Some((body, event)) = next.filter(|(_, event)| !(to_wall > 0.0 && to_wall < event.distance)) else {
                return (to_wall > 0.0).then(|| (ray.at(to_wall).truncate(), self.index(&inside) / at_camera));
            };
            let mut beyond = inside.clone();
            if event.normal.dot(ray.direction) < 0.0 {
                beyond.push(body)
            } else {
                beyond.retain(|&b| b != body)
            }
            let eta = self.index(&inside) / self.index(&beyond);
            let normal = event.normal;
            let direction = match refracted(ray.direction, normal, eta) {
                Some(direction) => {
                    inside = beyond;
                    direction
                }
                None => ray.direction - 2.0 * ray.direction.dot(normal) * normal,
            };
            let direction = direction.normalize();
            ray = Ray { origin: ray.at(event.distance) + 1e-9 * direction, direction, origin_error: 0.0 };
        }
        None
    }

    /// Radiance of the stripe that the ray arrives at; 0 beside the wall.
    fn radiance(&self, ray: Ray) -> f64 {
        let Some((place, index_ratio)) = self.arrive(ray) else { return 0.0 };
        let stripe = (place.x / STRIPE + 0.5 * STRIPES as f64).floor();
        let on_wall = stripe >= 0.0 && stripe < STRIPES as f64 && place.y.abs() < 50.0;
        if on_wall { (stripe + 1.0) / (index_ratio * index_ratio) } else { 0.0 }
    }

    /// Radiance of a pixel; `None` if a ray a hair beside it shows another. The hair is half a thousandth at the
    /// bodies: more than the two ten-thousandths by which rays start off a sheet of this size, which decides where two
    /// bodies meet.
    fn stable_radiance(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let radiance = |offset: DVec3| {
            self.radiance(Ray { origin, direction: (direction + offset).normalize(), origin_error: 0.0 })
        };
        let offsets = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y].map(|axis| axis * 1e-4);
        let middle = radiance(DVec3::ZERO);
        offsets.iter().all(|&offset| (radiance(offset) - middle).abs() < 1e-9).then_some(middle)
    }
}

#[test]
fn paths_are_those_of_double_precision() {
    for_each_device(|device| {
        for case in &CASES {
            let (view, scene) = (view(), scene(case));
            let reference = Reference::new(&scene, case.bodies.len());
            let means = means(&render(device.device, &scene, 1));
            let (mut tested, mut lit) = (0, 0);
            for (i, found) in means.iter().enumerate() {
                let (x, y) = (i as u32 % view.width, i as u32 / view.width);
                let Some(expected) = reference.stable_radiance(view.position, view.direction(x, y)) else { continue };
                // The tolerance is for squares of a few rounded index ratios; stripes differ by more than 1 %.
                let near = (found.x - expected).abs() < 1e-5 * expected.max(1.0);
                let (label, what) = (device.label, case.what);
                assert!(near, "{label}: {what}: pixel ({x}, {y}): expected {expected}, found {}", found.x);
                tested += 1;
                lit += usize::from(expected > 0.0);
            }
            println!("{} {}: {tested} of {} pixels tested, {lit} lit", device.label, case.what, means.len());
            assert!(tested > means.len() * 3 / 4 && lit > means.len() / 2, "{}: {tested} tested, {lit} lit", case.what);
        }
    });
}
