//! Saved views, and the way from one view to another.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use raggio_scene::{Camera, Projection};

use super::view::{axes, camera_heading, heading, pitch_of, pitched, vertical, view_distance};

/// Duration of a transition, long enough to see where one goes.
const TRANSITION_SECONDS: f32 = 0.25;

/// Views kept under the numbers 1 to 9.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bookmarks {
    views: [Option<Camera>; 9],
}

impl Bookmarks {
    /// Keeps a view; numbers other than 1 to 9 keep nothing.
    pub fn store(&mut self, number: usize, camera: Camera) {
        if let Some(view) = number.checked_sub(1).and_then(|index| self.views.get_mut(index)) {
            *view = Some(camera);
        }
    }

    /// The view of that number, if one was kept.
    pub fn recall(&self, number: usize) -> Option<&Camera> {
        self.views.get(number.checked_sub(1)?)?.as_ref()
    }
}

/// The way from one camera to another, slow at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    from: Camera,
    to: Camera,
    seconds: f32,
}

impl Transition {
    /// Begins a transition.
    pub fn new(from: Camera, to: Camera) -> Self {
        Self { from, to, seconds: 0.0 }
    }

    /// Goes on by `dt` seconds and returns the camera there.
    pub fn advance(&mut self, dt: f32) -> Camera {
        self.seconds += dt.max(0.0);
        self.camera()
    }

    /// The camera at this place of the way; exactly the last one at its end.
    pub fn camera(&self) -> Camera {
        if self.is_done() {
            return self.to.clone();
        }
        let way = f64::from(self.seconds / TRANSITION_SECONDS);
        between(&self.from, &self.to, way * way * (3.0 - 2.0 * way))
    }

    /// Whether the transition has arrived.
    pub fn is_done(&self) -> bool {
        self.seconds >= TRANSITION_SECONDS
    }
}

/// The view a part of the way from one to the other, 0 to 1.
fn between(from: &Camera, to: &Camera, part: f64) -> Camera {
    let mix = |from: f32, to: f32| (f64::from(from) + (f64::from(to) - f64::from(from)) * part) as f32;
    let up = slerp(vertical(from), vertical(to), part, axes(from).forward);
    let projection = match (from.projection, to.projection) {
        (
            Projection::Perspective { vertical_fov_degrees: from },
            Projection::Perspective { vertical_fov_degrees: to },
        ) => Projection::Perspective { vertical_fov_degrees: mix(from, to) },
        (Projection::Orthographic { height: from }, Projection::Orthographic { height: to }) => {
            Projection::Orthographic { height: mix(from, to) }
        }
        (_, to) => to,
    };
    let mut camera = Camera {
        position: from.position.as_dvec3().lerp(to.position.as_dvec3(), part).as_vec3(),
        up: up.as_vec3(),
        projection,
        aperture_radius: mix(from.aperture_radius, to.aperture_radius),
        focus_distance: mix(from.focus_distance, to.focus_distance),
        ..to.clone()
    };
    if from.up == to.up {
        camera.up = to.up;
    }
    let direction = slerp(axes(from).forward, axes(to).forward, part, up);
    // The shortest way may lead over a pole, where the camera would have no up.
    let heading = heading(direction, up).unwrap_or_else(|| camera_heading(from));
    let direction = pitched(heading, up, pitch_of(direction, up));
    let distance = mix(view_distance(from), view_distance(to));
    camera.look_at = (camera.position.as_dvec3() + direction * f64::from(distance)).as_vec3();
    camera
}

/// The unit vector a part of the way from one to the other; about `axis` where they are opposite.
fn slerp(from: DVec3, to: DVec3, part: f64, axis: DVec3) -> DVec3 {
    let angle = from.angle_between(to);
    let axis = from.cross(to).try_normalize().filter(|_| angle < PI - 1e-3).unwrap_or(axis);
    DQuat::from_axis_angle(axis, angle * part) * from
}
