//! Bounds of lights: where they are, where they shine to, and how much [conty2018manylights].

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

/// Bounds of one light, or of several together. `LightNode` in `kernels/lights/node.slang` says what the members mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBounds {
    pub lower: Vec3,
    pub upper: Vec3,
    pub power: f32,
    pub axis: Vec3,
    /// Largest angle of a light's normal to the axis, in radians; negative if there is no light.
    pub spread: f32,
    /// Largest angle to its normal at which a light shines, in radians.
    pub falloff: f32,
    pub two_sided: bool,
    pub infinite: bool,
}

impl LightBounds {
    /// Bounds of no light at all.
    pub const NONE: Self = Self {
        lower: Vec3::INFINITY,
        upper: Vec3::NEG_INFINITY,
        power: 0.0,
        axis: Vec3::Z,
        spread: -1.0,
        falloff: 0.0,
        two_sided: false,
        infinite: false,
    };

    /// Bounds of flat pieces with one normal.
    pub fn flat(lower: Vec3, upper: Vec3, power: f32, normal: Vec3, two_sided: bool) -> Self {
        let (axis, spread, falloff) = (normal, 0.0, FRAC_PI_2);
        Self { lower, upper, power, axis, spread, falloff, two_sided, infinite: false }
    }

    /// Bounds of a light that shines in all directions.
    pub fn round(lower: Vec3, upper: Vec3, power: f32) -> Self {
        Self { spread: PI, falloff: FRAC_PI_2, ..Self::flat(lower, upper, power, Vec3::Z, false) }
    }

    /// Bounds of a light that shines to all sides within an angle of `axis`, from one point.
    pub fn spot(position: Vec3, power: f32, axis: Vec3, angle: f32) -> Self {
        Self { falloff: angle, ..Self::flat(position, position, power, axis, false) }
    }

    /// Bounds of a light that is infinitely far away, in one direction.
    pub fn distant(direction: Vec3, irradiance: f32) -> Self {
        Self { infinite: true, falloff: 0.0, ..Self::flat(Vec3::ZERO, Vec3::ZERO, irradiance, direction, false) }
    }

    /// Bounds of a light that is infinitely far away, in all directions.
    pub fn everywhere(irradiance: f32) -> Self {
        Self { spread: PI, ..Self::distant(Vec3::Y, irradiance) }
    }

    /// Bounds of both together.
    pub fn with(self, other: Self) -> Self {
        if other.spread < 0.0 {
            return self;
        }
        if self.spread < 0.0 {
            return other;
        }
        let two_sided = self.two_sided || other.two_sided;
        let turned = self.two_sided && other.two_sided && self.axis.dot(other.axis) < 0.0;
        let other_axis = if turned { -other.axis } else { other.axis };
        let (axis, spread) = cone((self.axis, self.spread), (other_axis, other.spread));
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
            power: self.power + other.power,
            axis,
            spread,
            falloff: self.falloff.max(other.falloff),
            two_sided,
            infinite: self.infinite || other.infinite,
        }
    }

    pub fn center(&self) -> Vec3 {
        0.5 * (self.lower + self.upper)
    }

    /// Cost of having these lights in one node: power x size x the measure of directions that they reach.
    pub fn cost(&self) -> f32 {
        let (o, w) = (self.spread, (self.spread + self.falloff).min(PI));
        let beyond = 2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos();
        let directions = 2.0 * PI * (1.0 - o.cos()) + FRAC_PI_2 * beyond;
        self.power * directions * (self.upper - self.lower).length_squared()
    }
}

/// The least cone around two, each given by its axis and the angle from that to its rim.
fn cone((a, angle_a): (Vec3, f32), (b, angle_b): (Vec3, f32)) -> (Vec3, f32) {
    if angle_b > angle_a {
        return cone((b, angle_b), (a, angle_a));
    }
    let between = a.cross(b).length().atan2(a.dot(b));
    if angle_a >= PI || between + angle_b <= angle_a {
        return (a, angle_a);
    }
    let angle = 0.5 * (angle_a + between + angle_b);
    let across = (b - a.dot(b) * a).normalize_or_zero();
    // Opposite directions have no plane between them.
    if angle >= PI || across == Vec3::ZERO {
        return (a, PI);
    }
    let (sine, cosine) = (angle - angle_a).sin_cos();
    ((cosine * a + sine * across).normalize(), angle)
}

/// Makes the largest power 1, so that no sum or product of them is too large.
pub(super) fn normalize(lights: &mut [LightBounds]) {
    let largest = lights.iter().map(|light| light.power).fold(0.0, f32::max);
    lights.iter_mut().for_each(|light| light.power /= largest);
}
