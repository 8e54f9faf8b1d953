//! Intersections and the rays that leave them, against double precision.

mod hierarchy;
mod leave;
mod lists;
pub mod meshes;
mod nearest;
mod tracers;

use raggio_render::{Answer, Question};
use raggio_scene::{Geometry, Scene};
use raggio_tests::geometry::{Found, Ray};
use raggio_tests::parse;

use glam::{DVec3, Vec3};

/// Shapes of every kind, with small, large, far, thin and turned ones.
const SHAPES: &[&str] = &[
    "sphere = { center = [0, 0, 0], radius = 1 }",
    "sphere = { center = [0.3, -0.2, 0.1], radius = 0.001 }",
    "sphere = { center = [0, -10000, 0], radius = 10000 }",
    "sphere = { center = [700, -300, 500], radius = 1 }",
    "plane = { point = [0, 0, 0], normal = [0, 1, 0] }",
    "plane = { point = [0.5, 2, -1], normal = [1, 2, -0.5] }",
    "plane = { point = [500, 2000, -1000], normal = [-0.3, 0.1, 0.7] }",
    "rectangle = { corner = [-1, 0, -1], edge_u = [2, 0, 0], edge_v = [0, 0, 2] }",
    "rectangle = { corner = [1, 2, 3], edge_u = [0.6, 0.8, 0], edge_v = [-0.8, 0.6, 0] }",
    "rectangle = { corner = [-5000, -1, -4000], edge_u = [9000, 0, 0], edge_v = [0, 0, 8000] }",
    "rectangle = { corner = [300, 200, 100], edge_u = [0, 0.01, 0.02], edge_v = [0.03, 0, 0] }",
    "box = { center = [0, 0, 0], size = [2, 2, 2] }",
    "box = { center = [1, 2, -3], size = [1, 2, 3], rotation_degrees = [20, 30, 40] }",
    "box = { center = [0.1, 0.1, 0.2], size = [0.001, 0.002, 0.001], rotation_degrees = [75, -10, 5] }",
    "box = { center = [600, 100, -400], size = [3, 0.01, 2], rotation_degrees = [-50, 12, 160] }",
    "box = { center = [0, -2000, 0], size = [8000, 4000, 9000], rotation_degrees = [0, 45, 0] }",
    "disk = { center = [0, 0, 0], normal = [0, 1, 0], radius = 1 }",
    "disk = { center = [1, 2, -3], normal = [1, 2, -0.5], radius = 0.5 }",
    "disk = { center = [500, -200, 300], normal = [-0.3, 0.1, 0.7], radius = 0.02 }",
    "disk = { center = [0, -1, 0], normal = [0.1, 1, 0], radius = 9000 }",
    "cylinder = { base = [0, 0, 0], top = [0, 1, 0], radius = 1 }",
    "cylinder = { base = [1, 2, -3], top = [1.5, 0, -3.2], radius = 0.3 }",
    "cylinder = { base = [1, 2, -3], top = [1.5, 0, -3.2], radius = 0.3, capped = false }",
    "cylinder = { base = [500, -200, 300], top = [502, -199, 300.5], radius = 0.1 }",
    "cylinder = { base = [-4000, 0, 0], top = [4000, 100, 0], radius = 700, capped = false }",
    "cone = { base = [0, 0, 0], top = [0, 1, 0], radius = 1 }",
    "cone = { base = [1, 2, -3], top = [1.5, 0, -3.2], radius = 0.3 }",
    "cone = { base = [1, 2, -3], top = [1.5, 0, -3.2], radius = 0.9, top_radius = 0.2 }",
    "cone = { base = [1, 2, -3], top = [1.5, 0, -3.2], radius = 0.9, top_radius = 0.2, capped = false }",
    "cone = { base = [500, -200, 300], top = [502, -199, 300.5], radius = 1.5, capped = false }",
    "cone = { base = [0.1, 0, 0], top = [0.1, 0.002, 0.001], radius = 0.004, top_radius = 0.001 }",
    "cone = { base = [0, -3000, 0], top = [100, 3000, 0], radius = 2000 }",
];

/// A scene of one shape, whose rays start `surface_offset` or not off their surfaces.
fn scene_of(shape: &str, surface_offset: bool) -> Scene {
    parse(&format!(
        "[render]\nsurface_offset = {surface_offset}\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]
         vertical_fov_degrees = 40\n[materials.m]\n[[shapes]]\nmaterial = \"m\"\n{shape}\n"
    ))
}

/// Point about which a shape lies, and how far it reaches from there; for a plane, some part of it.
fn place(shape: &Geometry) -> (DVec3, f64) {
    match *shape {
        Geometry::Mesh { .. } => unreachable!("there are no meshes here"),
        Geometry::Sphere { center, radius } | Geometry::Disk { center, radius, .. } => {
            (center.as_dvec3(), f64::from(radius))
        }
        Geometry::Cylinder { base, top, radius, .. } | Geometry::Cone { base, top, radius, .. } => {
            let way = top.as_dvec3() - base.as_dvec3();
            (base.as_dvec3() + 0.5 * way, (0.5 * way.length()).hypot(f64::from(radius)))
        }
        Geometry::Plane { point, .. } => (point.as_dvec3(), 10.0),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let diagonal = (edge_u + edge_v).as_dvec3();
            (corner.as_dvec3() + 0.5 * diagonal, 0.5 * diagonal.length())
        }
        Geometry::Box { center, size, .. } => (center.as_dvec3(), 0.5 * size.as_dvec3().length()),
    }
}

/// A ray as the device gets it: in single precision, its direction as near to unit length as that allows.
#[derive(Clone, Copy, Debug)]
struct SingleRay {
    origin: Vec3,
    direction: Vec3,
}

impl SingleRay {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin: origin.as_vec3(), direction: direction.normalize().as_vec3() }
    }

    fn exact(&self) -> Ray {
        Ray { origin: self.origin.as_dvec3(), direction: self.direction.as_dvec3(), origin_error: 0.0 }
    }

    fn question(&self, third: [f32; 3]) -> Question {
        [self.origin.extend(0.0).to_array(), self.direction.extend(0.0).to_array(), [third[0], third[1], third[2], 0.0]]
    }
}

/// Hit that a trace found; `None` is a miss.
fn found(answer: &Answer) -> Option<Found> {
    let [[distance, ..], [x, y, z, _], [nx, ny, nz, _]] = *answer;
    (distance != -1.0).then(|| Found {
        distance: f64::from(distance),
        position: Vec3::new(x, y, z).as_dvec3(),
        normal: Vec3::new(nx, ny, nz).as_dvec3(),
    })
}
