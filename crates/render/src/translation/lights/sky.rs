//! The density by which kernels sample the sky's image: see `kernels/lights/sky_light.slang`.

use std::f64::consts::PI;
use std::sync::Arc;

use raggio_kernels::Texture;
use rayon::prelude::*;

use super::luminance;
use crate::translation::textures::texel;

/// A pyramid of sums over the image's cells.
#[derive(Clone, Debug)]
pub(super) struct Density {
    /// Sums of cells, four in each element, the coarsest level first; empty if there is nothing to sample.
    pub sums: Arc<Vec<[f32; 4]>>,
    /// Irradiance that the image causes beyond its mean, about.
    pub power: f32,
}

impl Density {
    /// Density of an image of the sky whose radiance is multiplied by `intensity`.
    pub fn new(texture: &Texture, texels: &[u32], intensity: f32) -> Self {
        let (width, height) = (texture.width as usize, texture.height as usize);
        let solid_angles: Vec<f64> = (0..height)
            .map(|y| {
                let edge = |y: usize| (PI * y as f64 / height as f64).cos();
                2.0 * PI / width as f64 * (edge(y) - edge(y + 1))
            })
            .collect();
        let mut cells: Vec<f32> = (0..width * height)
            .into_par_iter()
            .map(|i| (intensity * luminance(texel(texture, texels, i))).min(1e25))
            .collect();
        let rows = || cells.chunks(width).zip(&solid_angles);
        let sum: f64 = rows().map(|(row, angle)| angle * row.iter().map(|&l| f64::from(l)).sum::<f64>()).sum();
        let mean = sum / (4.0 * PI);
        cells.par_chunks_mut(width).zip(&solid_angles).for_each(|(row, angle)| {
            row.iter_mut().for_each(|cell| *cell = ((f64::from(*cell) - mean).max(0.0) * angle) as f32);
        });
        let total: f64 = cells.par_chunks(width).map(|row| row.iter().map(|&c| f64::from(c)).sum::<f64>()).sum();
        // A constant image differs from its mean by rounding alone.
        if total <= 1e-4 * sum {
            return Self { sums: Arc::default(), power: 0.0 };
        }
        Self { sums: Arc::new(pyramid(cells, width, height)), power: (0.5 * total) as f32 }
    }
}

fn pyramid(mut cells: Vec<f32>, mut width: usize, mut height: usize) -> Vec<[f32; 4]> {
    let mut levels = vec![];
    loop {
        let (across, down) = (width.div_ceil(2), height.div_ceil(2));
        let at = |x: usize, y: usize| if x < width && y < height { cells[y * width + x] } else { 0.0 };
        let block = |i: usize| {
            let (x, y) = (2 * (i % across), 2 * (i / across));
            [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]
        };
        let level: Vec<[f32; 4]> = (0..across * down).into_par_iter().map(block).collect();
        cells = level.par_iter().map(|[a, b, c, d]| a + b + (c + d)).collect();
        levels.push(level);
        (width, height) = (across, down);
        if (width, height) == (1, 1) {
            return levels.into_iter().rev().flatten().collect();
        }
    }
}
