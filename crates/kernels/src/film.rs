//! The host's side of the film's sums: exact, then in double precision.

use std::ops::Add;

use crate::{FilmPixel, FixedSum};

impl FixedSum {
    /// Makes the sum of one number, rounded to 2^-40; the nearest sum there is to a number that does not fit.
    pub fn of(value: f64) -> Self {
        let whole = (value * (1u64 << 40) as f64).round() as i128;
        let bits = whole.clamp(-(1 << 95), (1 << 95) - 1) as u128;
        Self { low: bits as u32, middle: (bits >> 32) as u32, high: (bits >> 64) as u32 }
    }

    /// Value of the sum in units of 2^-40.
    pub fn whole(self) -> i128 {
        let bits = u128::from(self.low) | u128::from(self.middle) << 32 | u128::from(self.high) << 64;
        // 96 bits in two's complement, widened to 128.
        ((bits << 32) as i128) >> 32
    }

    /// Value of the sum, rounded to the nearest double.
    pub fn value(self) -> f64 {
        self.whole() as f64 / (1u64 << 40) as f64
    }
}

impl Add for FixedSum {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let total = (self.whole() + other.whole()) as u128;
        Self { low: total as u32, middle: (total >> 32) as u32, high: (total >> 64) as u32 }
    }
}

impl FilmPixel {
    /// Adds other samples of the same pixel.
    pub fn merge(&mut self, other: &Self) {
        *self = Self {
            red: self.red + other.red,
            green: self.green + other.green,
            blue: self.blue + other.blue,
            clamped: self.clamped + other.clamped,
            squares: self.squares + other.squares,
            samples: self.samples + other.samples,
            rejected: self.rejected + other.rejected,
            rays: self.rays.wrapping_add(other.rays),
        };
    }

    /// Mean radiance; black before the first sample.
    pub fn mean(&self) -> [f64; 3] {
        [self.red, self.green, self.blue].map(|sum| sum.value() / f64::from(self.samples.max(1)))
    }

    /// Luminance of the mean radiance, its channels weighed as Rec. 709 does.
    pub fn luminance(&self) -> f64 {
        let [red, green, blue] = self.mean();
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    }

    /// Variance of the samples' luminance, without bias; `None` before the second sample.
    ///
    /// Squares are rounded to single precision and to 2^-40, so variances below a ten millionth of the squared luminance
    /// are not told from 0.
    pub fn luminance_variance(&self) -> Option<f64> {
        let count = f64::from(self.samples);
        let squares = self.squares.value() - count * self.luminance() * self.luminance();
        (self.samples >= 2).then(|| squares.max(0.0) / (count - 1.0))
    }

    /// Standard error of [`luminance`](Self::luminance); `None` before the second sample.
    pub fn luminance_error(&self) -> Option<f64> {
        Some((self.luminance_variance()? / f64::from(self.samples)).sqrt())
    }
}
