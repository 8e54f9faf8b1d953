//! Movements of the camera as pure mathematics: a camera and a motion go in, a camera comes out.
//!
//! Conventions: angles are in radians, lengths in the scene's unit. The camera's `up`, made a unit vector, is the
//! *vertical*: it never changes, and no movement tilts the horizon against it. *Pitch* is the angle of the viewing
//! direction above the horizon and stays within ±89°; a camera that looks more steeply is brought within when it turns.
//! Positive yaw turns to the left as seen from above, positive pitch turns upwards.
//!
//! The focus stays where it is, at its distance from the camera, unless it is the distance of `look_at` and the lens is
//! closed: then it follows, because it says nothing.
//!
//! A movement to where 32 bits end, or by a value that is not a number, leaves the camera as it was. `look_at` keeps so
//! far from the camera (1e-4 of the coordinates) that rounding does not turn the view.

mod bookmarks;
mod motion;
mod presets;
mod view;

use glam::{DQuat, DVec3};
use raggio_scene::{Camera, Projection, Vec3};

pub use bookmarks::{Bookmarks, Transition};
pub use motion::{Motion, default_speed, step_speed};
pub use presets::{Button, DragAction, Modifiers, Preset, WheelAction, action, describe, wheel};
pub use view::{Axes, axes, view_distance};

use view::{camera_heading, heading, moved, pitch_of, pitched, turned, vertical};

/// Share of the picture's smaller side that [`focus_on`] gives the diameter of the sphere.
const FILLED: f64 = 0.85;
/// Least factor of one [`dolly`], which approaches to this part of the distance and not beyond.
const LEAST_FACTOR: f64 = 1e-3;
/// Half of the angle that [`focus_on`] takes for a panorama's, whose whole picture no sphere could fill.
const PANORAMIC_HALF_ANGLE: f64 = 0.5;
/// Least and greatest height of a picture with parallel rays, well within those that a scene may have.
const LEAST_HEIGHT: f64 = 1e-12;
const GREATEST_HEIGHT: f64 = 1e12;

/// Moves position and `look_at` together by `distance` times `motion`: to the right, along the vertical, forward.
pub fn fly(camera: &Camera, motion: Vec3, distance: f32) -> Camera {
    let Axes { right, forward, .. } = axes(camera);
    let motion = motion.as_dvec3() * f64::from(distance);
    translate(camera, right * motion.x + vertical(camera) * motion.y + forward * motion.z)
}

/// Turns the camera on the spot by `yaw` and `pitch`, in radians; `look_at` keeps its distance.
pub fn look(camera: &Camera, yaw: f32, pitch: f32) -> Camera {
    let position = camera.position.as_dvec3();
    let towards = camera.look_at.as_dvec3() - position;
    let forward = turned(camera, yaw.into(), pitch.into());
    moved(camera, position, position + forward * towards.length())
}

/// Turns the camera about `pivot`, which stays where it is in the picture, by `yaw` and `pitch` in radians. The viewing
/// direction turns by the same angles as it does in [`look`], so that with positive pitch the camera sinks.
pub fn orbit(camera: &Camera, pivot: Vec3, yaw: f32, pitch: f32) -> Camera {
    let before = axes(camera);
    let forward = turned(camera, yaw.into(), pitch.into());
    // Yaw first, then pitch about the right that yaw has turned: right stays level, so that up needs no roll.
    let level = DQuat::from_axis_angle(vertical(camera), yaw.into());
    let right = level * before.right;
    let level_forward = level * before.forward;
    let angle = level_forward.cross(forward).dot(right).atan2(level_forward.dot(forward));
    let turn = DQuat::from_axis_angle(right, angle) * level;
    let pivot = pivot.as_dvec3();
    let about = |point: Vec3| pivot + turn * (point.as_dvec3() - pivot);
    moved(camera, about(camera.position), about(camera.look_at))
}

/// Moves parallel to the picture, so that a point at `distance` along the viewing direction goes `dx` to the right and
/// `dy` down, in heights of the picture. Where rays are parallel all points go as far, whatever the distance.
pub fn pan(camera: &Camera, dx: f32, dy: f32, distance: f32) -> Camera {
    let Axes { right, up, .. } = axes(camera);
    let distance = if camera.orthographic_height().is_some() { 1.0 } else { f64::from(distance) };
    let height = 2.0 * camera.half_height() * distance;
    translate(camera, (up * f64::from(dy) - right * f64::from(dx)) * height)
}

/// Multiplies the distance to `pivot` by `factor`, less than 1 to approach. The direction stays, and `pivot` stays
/// where it is in the picture; a factor of 0 or less approaches to a thousandth and not beyond. Where rays are parallel,
/// and a closer camera would see all as large as before, the picture's height is multiplied instead.
pub fn dolly(camera: &Camera, factor: f32, pivot: Vec3) -> Camera {
    let factor = f64::from(factor).max(LEAST_FACTOR);
    let pivot = pivot.as_dvec3();
    if let Some(height) = camera.orthographic_height() {
        let new = (f64::from(height) * factor).clamp(LEAST_HEIGHT, GREATEST_HEIGHT);
        let across = (pivot - camera.position.as_dvec3()).reject_from_normalized(axes(camera).forward);
        let new = Camera { projection: Projection::Orthographic { height: new as f32 }, ..camera.clone() };
        return translate(&new, across * (1.0 - new.half_height() / camera.half_height()));
    }
    let scaled = |point: Vec3| pivot + (point.as_dvec3() - pivot) * factor;
    moved(camera, scaled(camera.position), scaled(camera.look_at))
}

/// Keeps the direction and moves so that the sphere fills most of a picture of that `aspect` ratio (width by height);
/// looks at its centre and focuses there. Without a positive radius the distance of `look_at` stays. Where rays are
/// parallel the picture's height is what fits, and the camera stands outside the sphere.
pub fn focus_on(camera: &Camera, center: Vec3, radius: f32, aspect: f32) -> Camera {
    if camera.orthographic_height().is_some() {
        return focus_on_parallel(camera, center, radius, aspect);
    }
    let vertical = half_angle(camera);
    let horizontal = (vertical.tan() * f64::from(aspect)).atan();
    // The cone around the sphere takes its share of the narrower angle.
    let cone = (vertical.min(horizontal).tan() * FILLED).atan();
    let fitting = f64::from(radius) / cone.sin();
    let distance = if radius > 0.0 && fitting.is_finite() { fitting } else { view_distance(camera).into() };
    let center = center.as_dvec3();
    let mut new = moved(camera, center - axes(camera).forward * distance, center);
    new.focus_distance = view_distance(&new);
    new
}

fn focus_on_parallel(camera: &Camera, center: Vec3, radius: f32, aspect: f32) -> Camera {
    let fitting = 2.0 * f64::from(radius) / FILLED / f64::from(aspect).min(1.0);
    let fits = radius > 0.0 && (LEAST_HEIGHT..=GREATEST_HEIGHT).contains(&fitting);
    let projection = if fits { Projection::Orthographic { height: fitting as f32 } } else { camera.projection };
    let distance = f64::from(view_distance(camera).max(2.0 * radius));
    let center = center.as_dvec3();
    let mut new = moved(camera, center - axes(camera).forward * distance, center);
    new.projection = projection;
    new.focus_distance = view_distance(&new);
    new
}

/// Puts the plane in focus through a point: its distance is taken along the viewing direction. A point behind the
/// camera changes nothing, and a panorama has no plane in focus.
pub fn set_focus(camera: &Camera, point: Vec3) -> Camera {
    if camera.is_panoramic() {
        return camera.clone();
    }
    let distance = (point.as_dvec3() - camera.position.as_dvec3()).dot(axes(camera).forward) as f32;
    let focus_distance = if distance >= 1e-15 && distance.is_finite() { distance } else { camera.focus_distance };
    Camera { focus_distance, ..camera.clone() }
}

/// Looks at the same point, over the same distance, from `direction` of it: `Vec3::Z` is the front, `Vec3::X` the
/// right, `Vec3::Y` the top. Straight from above or below it keeps its heading and looks as steeply as it may, 89°,
/// because at 90° nothing would say where up is.
pub fn view_from(camera: &Camera, direction: Vec3) -> Camera {
    let forward = -direction.as_dvec3().normalize_or_zero();
    if forward == DVec3::ZERO {
        return camera.clone();
    }
    let vertical = vertical(camera);
    let heading = heading(forward, vertical).unwrap_or_else(|| camera_heading(camera));
    let (look_at, distance) = (camera.look_at.as_dvec3(), f64::from(view_distance(camera)));
    moved(camera, look_at - pitched(heading, vertical, pitch_of(forward, vertical)) * distance, look_at)
}

fn translate(camera: &Camera, by: DVec3) -> Camera {
    moved(camera, camera.position.as_dvec3() + by, camera.look_at.as_dvec3() + by)
}

/// Half of the vertical field of view.
fn half_angle(camera: &Camera) -> f64 {
    if camera.is_panoramic() { PANORAMIC_HALF_ANGLE } else { camera.half_height().atan() }
}
