//! Flying: speed, and a velocity that follows the keys smoothly.

use raggio_scene::Vec3;

/// Time constant of the smoothing: after it a velocity has come 63 % closer to the one that is wanted.
const SMOOTHING_SECONDS: f64 = 0.06;
/// Longest frame that is flown through; a pause between two frames is not.
const LONGEST_FRAME_SECONDS: f64 = 0.25;
/// Share of the speed below which what has been released stands still.
const REST: f32 = 1e-3;
/// Factor of the speed for each notch of the wheel.
const NOTCH: f32 = 1.2;
/// Share of a scene's diagonal flown in a second.
const SHARE_OF_DIAGONAL: f32 = 0.15;

/// A speed, in units a second, that suits a scene of that diagonal; 1 where the diagonal is not a positive length.
pub fn default_speed(bounds_diagonal: f32) -> f32 {
    let usable = bounds_diagonal > 0.0 && bounds_diagonal.is_finite();
    if usable { limited(bounds_diagonal * SHARE_OF_DIAGONAL) } else { 1.0 }
}

/// The speed after so many notches of the wheel; positive ones make it faster.
pub fn step_speed(speed: f32, notches: f32) -> f32 {
    limited(speed * NOTCH.powf(notches))
}

fn limited(speed: f32) -> f32 {
    speed.clamp(1e-6, 1e9)
}

/// A velocity that follows the wanted one exponentially, the same for every frame rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    velocity: Vec3,
}

impl Motion {
    /// The displacement over `dt` seconds, along whatever axes `wanted` is given in. `wanted` is the direction of the
    /// keys held, zero when there are none, and counts as a unit vector where it is longer; `speed` is in units a
    /// second.
    pub fn advance(&mut self, dt: f32, wanted: Vec3, speed: f32) -> Vec3 {
        let seconds = f64::from(dt).clamp(0.0, LONGEST_FRAME_SECONDS);
        let target = (wanted.clamp_length_max(1.0) * speed).as_dvec3();
        let excess = self.velocity.as_dvec3() - target;
        // The solution of v' = (target - v) / smoothing, and its integral.
        let left = (-seconds / SMOOTHING_SECONDS).exp();
        let displacement = target * seconds + excess * (SMOOTHING_SECONDS * (1.0 - left));
        self.velocity = (target + excess * left).as_vec3();
        if wanted == Vec3::ZERO && self.velocity.length() <= REST * speed {
            self.velocity = Vec3::ZERO;
        }
        displacement.as_vec3()
    }

    /// Whether the velocity is not zero.
    pub fn is_moving(&self) -> bool {
        self.velocity != Vec3::ZERO
    }

    /// Comes to rest at once.
    pub fn stop(&mut self) {
        self.velocity = Vec3::ZERO;
    }
}
