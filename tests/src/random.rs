//! Random numbers of the host, independent of those of the kernels.

use std::f64::consts::TAU;

use glam::DVec3;

/// Generator PCG-XSH-RR 64/32.
pub struct Pcg {
    state: u64,
}

impl Pcg {
    /// Makes a generator with a sequence of its own for each seed.
    pub fn new(seed: u64) -> Self {
        let mut pcg = Self { state: 0 };
        pcg.bits();
        pcg.state = pcg.state.wrapping_add(seed);
        pcg.bits();
        pcg
    }

    /// Draws 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }

    /// Draws a number in [0, 1), a multiple of 2^-24 like the numbers of the kernels.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 * 2f32.powi(-24)
    }

    /// Draws a number between `low` and `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.bits()) * 2f64.powi(-32)
    }

    /// Draws a number between `low` and `high`, both positive, evenly on a logarithmic scale.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Draws an index less than `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((u64::from(self.bits()) * count as u64) >> 32) as usize
    }

    /// Draws a direction, uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// Draws a point, uniform in a cube of twice `half_size` around the origin.
    pub fn in_cube(&mut self, half_size: f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.between(-half_size, half_size)))
    }
}
