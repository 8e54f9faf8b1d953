//! Motion of a scene since the frame before.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec3};
use raggio_kernels::{Camera, FrameView, MOTION_ROWS, NONE};
use raggio_scene::{Geometry, Mesh, Scene, rotation};

/// Rows of the motion from `before` to `scene`, as kernels read them: of each shape, and after these where vertices were of
/// meshes that have changed their form. Shapes are the same if they have the same place in both and are of one kind; others
/// are taken to stand still.
pub(super) fn motion_rows(scene: &Scene, before: &Scene, shape_of_place: &[u32]) -> Vec<[f32; 4]> {
    let is_same = scene.shapes.len() == before.shapes.len();
    let mut vertices = Vertices { first: MOTION_ROWS as usize * shape_of_place.len(), ..Vertices::default() };
    let mut rows = Vec::with_capacity(vertices.first);
    for &place in shape_of_place {
        let geometry = &scene.shapes[place as usize].geometry;
        let earlier = before.shapes.get(place as usize).filter(|_| is_same).map(|shape| &shape.geometry);
        let motion = earlier.and_then(|earlier| vertices.motion(geometry, earlier));
        let ShapeMotion { map, first_vertex } = motion.unwrap_or_else(|| rigid(DAffine3::IDENTITY));
        rows.extend(map);
        rows.push([f32::from_bits(first_vertex), 0.0, 0.0, 0.0]);
    }
    rows.append(&mut vertices.positions);
    rows
}

/// Motion of a shape, as its rows tell it.
struct ShapeMotion {
    /// Rows of the map to what points have to be moved by; or, where there are vertices, from the mesh before to the world.
    map: [[f32; 4]; 3],
    /// Row of the first vertex of the mesh before, or `NONE`.
    first_vertex: u32,
}

/// Positions that vertices had, in the space of the mesh before.
#[derive(Default)]
struct Vertices {
    /// Row of the first.
    first: usize,
    positions: Vec<[f32; 4]>,
    /// Rows at which those of each mesh begin, by the addresses of the mesh and of what it was before.
    rows: HashMap<[usize; 2], u32>,
}

impl Vertices {
    fn motion(&mut self, now: &Geometry, before: &Geometry) -> Option<ShapeMotion> {
        if let (Geometry::Mesh { mesh, .. }, Geometry::Mesh { mesh: mesh_before, world_from_mesh: world_before, .. }) =
            (now, before)
            && !Arc::ptr_eq(mesh, mesh_before)
            && is_same_surface(mesh, mesh_before)
            && let Some(first_vertex) = self.vertices_of(mesh, mesh_before)
        {
            return Some(ShapeMotion { map: rows(world_before), first_vertex });
        }
        before_from_now(now, before).map(rigid)
    }

    /// Row of the first vertex of `before`; `None` where there are more than a device can count.
    fn vertices_of(&mut self, mesh: &Arc<Mesh>, before: &Arc<Mesh>) -> Option<u32> {
        let key = [mesh, before].map(|mesh| Arc::as_ptr(mesh).addr());
        if let Some(row) = self.rows.get(&key) {
            return Some(*row);
        }
        let row = self.first + self.positions.len();
        // One number is for none.
        u32::try_from(row + before.positions.len()).ok().filter(|end| *end < NONE)?;
        self.positions.extend(before.positions.iter().map(|&[x, y, z]| [x, y, z, 0.0]));
        self.rows.insert(key, row as u32);
        Some(row as u32)
    }
}

/// Whether the vertices of both make the same triangles, so that they may have moved from one to the other.
fn is_same_surface(now: &Mesh, before: &Mesh) -> bool {
    // A skin that mirrors turns triangles round.
    let same = |[now, before]: [&[u32; 3]; 2]| {
        let [mut now, mut before] = [*now, *before];
        now.sort_unstable();
        before.sort_unstable();
        now == before
    };
    now.positions.len() == before.positions.len()
        && now.triangles.len() == before.triangles.len()
        && now.triangles.iter().zip(&before.triangles).all(|(now, before)| now == before || same([now, before]))
}

/// Map of a shape's points to where they were; `None` for shapes of different kinds.
fn before_from_now(now: &Geometry, before: &Geometry) -> Option<DAffine3> {
    // Each shape is the image of one of its kind: a unit sphere, a box of half size 1, a square.
    let [now, before] = match (now, before) {
        (Geometry::Plane { point, normal }, Geometry::Plane { point: point_before, normal: normal_before }) => {
            // A plane has no other axes, so that it turns by the shortest way.
            let turn = DQuat::from_rotation_arc(normal.as_dvec3(), normal_before.as_dvec3());
            let about = |center: &Vec3| DAffine3::from_translation(center.as_dvec3());
            return Some(about(point_before) * DAffine3::from_quat(turn) * about(point).inverse());
        }
        (Geometry::Disk { .. }, Geometry::Disk { .. })
        | (Geometry::Cylinder { .. }, Geometry::Cylinder { .. })
        | (Geometry::Cone { .. }, Geometry::Cone { .. }) => {
            return Some(Round::of(now)?.before_from(&Round::of(before)?));
        }
        (Geometry::Mesh { world_from_mesh: now, .. }, Geometry::Mesh { world_from_mesh: before, .. }) => {
            [*now, *before]
        }
        (Geometry::Sphere { .. }, Geometry::Sphere { .. })
        | (Geometry::Rectangle { .. }, Geometry::Rectangle { .. })
        | (Geometry::Box { .. }, Geometry::Box { .. }) => [placed(now)?, placed(before)?],
        _ => return None,
    };
    Some(if now == before { DAffine3::IDENTITY } else { before * now.inverse() })
}

fn placed(geometry: &Geometry) -> Option<DAffine3> {
    let map = |matrix3: DMat3, translation: &Vec3| DAffine3 { matrix3, translation: translation.as_dvec3() };
    Some(match geometry {
        Geometry::Sphere { center, radius } => map(DMat3::from_diagonal(DVec3::splat((*radius).into())), center),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let [u, v] = [edge_u, edge_v].map(|edge| edge.as_dvec3());
            map(DMat3::from_cols(u, v, u.cross(v).normalize()), corner)
        }
        Geometry::Box { center, size, rotation_degrees } => {
            map(rotation(*rotation_degrees) * DMat3::from_diagonal(0.5 * size.as_dvec3()), center)
        }
        _ => return None,
    })
}

/// A disk, a cylinder or a cone: all that tells two of a kind apart, but for how pointed a cone is.
#[derive(PartialEq)]
struct Round {
    base: DVec3,
    /// Axis, unit.
    axis: DVec3,
    height: f64,
    radius: f64,
}

impl Round {
    fn of(geometry: &Geometry) -> Option<Self> {
        Some(match geometry {
            Geometry::Disk { center, normal, radius } => Self {
                base: center.as_dvec3(),
                axis: normal.as_dvec3().normalize(),
                height: 1.0,
                radius: (*radius).into(),
            },
            Geometry::Cylinder { base, top, radius, .. } | Geometry::Cone { base, top, radius, .. } => {
                let base = base.as_dvec3();
                let way = top.as_dvec3() - base;
                Self { base, axis: way.normalize(), height: way.length(), radius: (*radius).into() }
            }
            _ => return None,
        })
    }

    /// Map of its points to where they were when it was `before`. It has no other axes, so that it turns by the shortest way.
    fn before_from(&self, before: &Self) -> DAffine3 {
        if self == before {
            return DAffine3::IDENTITY;
        }
        let (along, across) = (before.height / self.height, before.radius / self.radius);
        let axis = self.axis;
        let project = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        let growth = DMat3::IDENTITY * across + project * (along - across);
        let turn = DMat3::from_quat(DQuat::from_rotation_arc(axis, before.axis));
        let about = |center: DVec3| DAffine3::from_translation(center);
        about(before.base) * DAffine3::from_mat3(turn * growth) * about(self.base).inverse()
    }
}

/// Motion of a shape whose points were where the map takes them: what they have to be moved by. Of what stands still that is
/// nothing, exactly.
fn rigid(before_from_now: DAffine3) -> ShapeMotion {
    let DAffine3 { matrix3, translation } = before_from_now;
    let change = DAffine3 { matrix3: matrix3 - DMat3::IDENTITY, translation };
    ShapeMotion { map: rows(&change), first_vertex: NONE }
}

fn rows(map: &DAffine3) -> [[f32; 4]; 3] {
    let columns = map.to_cols_array();
    [0, 1, 2].map(|row| [0, 3, 6, 9].map(|column| columns[column + row] as f32))
}

/// View of a camera as devices have it.
pub(super) fn frame_view(camera: &Camera) -> FrameView {
    let row = |i: usize| camera.world_from_view[i];
    let column = |j: usize| [0, 1, 2].map(|i| row(i)[j]);
    let view_from_clip = DMat4::from_cols_array_2d(&camera.view_from_clip.map(|row| row.map(f64::from))).transpose();
    let clip_from_view = view_from_clip.inverse().transpose();
    FrameView {
        right: column(0),
        up: column(1),
        back: column(2),
        eye: column(3),
        clip_from_view: clip_from_view.to_cols_array_2d().map(|row| row.map(|x| x as f32)),
        projection: camera.projection,
    }
}
