//! Bump maps: heights, which become the normals of their slopes.
//!
//! MTL gives heights no unit. Ours is the width of a texel, as in programs that make normal maps of heights: at `-bm 1`
//! white lies one texel above black, so that a step from black to white between two texels is a slope of 45 degrees.
//! The multiplier stretches the slopes afterwards, as that of a normal map does.

use raggio_images::{Bitmap, Texels};
use rayon::prelude::*;

/// Part of an image's texels that have to be normals if it is a normal map: compression spoils some.
const NORMALS: f64 = 0.95;

/// Whether an image holds unit normals rather than heights: a grey is none, unless it is so light that it is blue besides.
pub(super) fn holds_normals(image: &Bitmap) -> bool {
    let is_normal = |index: &usize| {
        let [x, y, z] = color(image, *index).map(|value| 2.0 * value - 1.0);
        let length = (x * x + y * y + z * z).sqrt();
        z > 0.25 && (length - 1.0).abs() < 0.15
    };
    let count = image.texels.len();
    let is_grey = || (0..count).all(|index| color(image, index).windows(2).all(|pair| pair[0] == pair[1]));
    let normals = (0..count).into_par_iter().filter(is_normal).count();
    normals as f64 >= NORMALS * count as f64 && !is_grey()
}

/// The normal map of a height map: central differences, across the edges unless the image is clamped to them. Green points
/// to the top of the image.
pub(super) fn normals_of_heights(image: &Bitmap, clamp: bool) -> Bitmap {
    let [width, height] = [image.width, image.height].map(|side| side as usize);
    let heights: Vec<f64> =
        (0..image.texels.len()).into_par_iter().map(|index| luminance(color(image, index))).collect();
    let at = |x: usize, y: usize| heights[y * width + x];
    let texel = |index: usize| {
        let (x, y) = (index % width, index / width);
        let [left, right] = neighbours(x, width, clamp);
        let [above, below] = neighbours(y, height, clamp);
        let slope = |before: f64, after: f64| (after - before) / 2.0;
        encoded([-slope(at(left, y), at(right, y)), -slope(at(x, below), at(x, above)), 1.0])
    };
    let texels = (0..heights.len()).into_par_iter().map(texel).collect();
    Bitmap { width: image.width, height: image.height, texels: Texels::Rgba16(texels) }
}

/// The places before and after one of `count` in a row.
fn neighbours(at: usize, count: usize, clamp: bool) -> [usize; 2] {
    if clamp { [at.saturating_sub(1), (at + 1).min(count - 1)] } else { [(at + count - 1) % count, (at + 1) % count] }
}

fn encoded(normal: [f64; 3]) -> [u16; 4] {
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = normal.map(|x| ((x / length + 1.0) / 2.0 * 65535.0).round() as u16);
    [x, y, z, u16::MAX]
}

fn color(image: &Bitmap, index: usize) -> [f64; 3] {
    match &image.texels {
        Texels::Rgba8(texels) => [0, 1, 2].map(|i| f64::from(texels[index][i]) / 255.0),
        Texels::Rgba16(texels) => [0, 1, 2].map(|i| f64::from(texels[index][i]) / 65535.0),
        Texels::Rgb32F(texels) => texels[index].map(f64::from),
    }
}

/// Luminance by Rec. 709, of values taken as they are: heights are data.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
