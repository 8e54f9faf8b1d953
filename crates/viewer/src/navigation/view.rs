//! Directions of a camera, and new cameras made from it.

use glam::{DQuat, DVec3};
use raggio_scene::Camera;

/// Greatest pitch: 89 degrees, in radians.
const STEEPEST: f64 = 89.0 / 180.0 * std::f64::consts::PI;
/// Sine of the least angle between a direction and the vertical at which it has a heading.
const PARALLEL: f64 = 1e-5;
/// Distance of `look_at` relative to the coordinates: closer, rounding would turn the view by more than a pixel.
const CLOSEST: f64 = 1e-4;
/// Distance of `look_at` in any case, well above the least that a scene may have.
const SHORTEST: f64 = 1e-12;
/// Largest coordinate, well within those that a scene may have.
const FARTHEST: f64 = 1e14;

/// The directions of a picture: unit vectors at right angles, `right` × `up` = -`forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Direction to the picture's right edge.
    pub right: DVec3,
    /// Direction to the picture's top edge; not the vertical unless the camera looks level.
    pub up: DVec3,
    /// Viewing direction, into the picture.
    pub forward: DVec3,
}

/// The directions of the camera's picture.
pub fn axes(camera: &Camera) -> Axes {
    let forward = (camera.look_at.as_dvec3() - camera.position.as_dvec3()).normalize_or(DVec3::NEG_Z);
    let right = forward.cross(vertical(camera)).normalize_or(forward.any_orthonormal_vector());
    Axes { right, up: right.cross(forward), forward }
}

/// Distance from `position` to `look_at`, as a scene file without `focus_distance` has it.
pub fn view_distance(camera: &Camera) -> f32 {
    (camera.look_at.as_dvec3() - camera.position.as_dvec3()).length() as f32
}

/// The camera's `up` as a unit vector.
pub(super) fn vertical(camera: &Camera) -> DVec3 {
    camera.up.as_dvec3().normalize_or(DVec3::Y)
}

/// The level direction nearest to `direction`; `None` when that is vertical.
pub(super) fn heading(direction: DVec3, vertical: DVec3) -> Option<DVec3> {
    let level = direction.reject_from_normalized(vertical);
    (level.length() > PARALLEL).then(|| level.normalize())
}

/// The level direction into the camera's picture.
pub(super) fn camera_heading(camera: &Camera) -> DVec3 {
    vertical(camera).cross(axes(camera).right)
}

/// The unit vector `pitch` above the level `heading`, within the limit.
pub(super) fn pitched(heading: DVec3, vertical: DVec3, pitch: f64) -> DVec3 {
    let pitch = pitch.clamp(-STEEPEST, STEEPEST);
    heading * pitch.cos() + vertical * pitch.sin()
}

/// The angle of a unit vector above the horizon.
pub(super) fn pitch_of(direction: DVec3, vertical: DVec3) -> f64 {
    direction.dot(vertical).clamp(-1.0, 1.0).asin()
}

/// The camera's viewing direction, turned; angles that are not finite do not turn it.
pub(super) fn turned(camera: &Camera, yaw: f64, pitch: f64) -> DVec3 {
    let vertical = vertical(camera);
    let (yaw, pitch) = if yaw.is_finite() && pitch.is_finite() { (yaw, pitch) } else { (0.0, 0.0) };
    let heading = DQuat::from_axis_angle(vertical, yaw) * camera_heading(camera);
    pitched(heading, vertical, pitch_of(axes(camera).forward, vertical) + pitch)
}

/// Moves the camera to `position` and `look_at`, its focus following or not; leaves it as it was if 32 bits could not
/// hold the new one. A `look_at` that would be too close is moved away along the viewing direction.
pub(super) fn moved(camera: &Camera, position: DVec3, look_at: DVec3) -> Camera {
    let size = position.abs().max(look_at.abs()).max_element();
    let Some(forward) = (look_at - position).try_normalize() else { return camera.clone() };
    if !position.is_finite() || !look_at.is_finite() || size > FARTHEST {
        return camera.clone();
    }
    let least = (CLOSEST * size).max(SHORTEST);
    let look_at = if position.distance(look_at) < least { position + forward * least } else { look_at };
    let mut new = Camera { position: position.as_vec3(), look_at: look_at.as_vec3(), ..camera.clone() };
    if camera.aperture_radius == 0.0 && camera.focus_distance == view_distance(camera) {
        new.focus_distance = view_distance(&new);
    }
    new
}
