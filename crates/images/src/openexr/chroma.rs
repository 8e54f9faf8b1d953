//! Channels with fewer samples than there are pixels, and colours from luminance and chroma.

use exr::meta::attribute::Chromaticities;

use crate::guard::radiance;

/// Parts of red, green and blue in luminance, by the primaries of ITU-R BT.709.
const BT709: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Fills in the pixels between samples that stand `across` pixels and `down` rows apart, by linear interpolation.
pub(super) fn fill_in(pixels: &mut [[f32; 3]], width: usize, component: usize, [across, down]: [usize; 2]) {
    let height = pixels.len() / width;
    for row in pixels.chunks_exact_mut(width).step_by(down) {
        for x in (0..width).filter(|x| x % across != 0) {
            let (left, right, fraction) = neighbours(x, across, width);
            row[x][component] = mix(row[left][component], row[right][component], fraction);
        }
    }
    for y in (0..height).filter(|y| y % down != 0) {
        let (above, below, fraction) = neighbours(y, down, height);
        for x in 0..width {
            let [above, below] = [above, below].map(|y| pixels[y * width + x][component]);
            pixels[y * width + x][component] = mix(above, below, fraction);
        }
    }
}

/// The samples on both sides of a place, `apart` from each other, and how far it is from the first to the second. Behind
/// the last sample there is none.
fn neighbours(place: usize, apart: usize, end: usize) -> (usize, usize, f32) {
    let first = place - place % apart;
    let second = if first + apart < end { first + apart } else { first };
    (first, second, (place - first) as f32 / apart as f32)
}

fn mix(a: f32, b: f32, fraction: f32) -> f32 {
    a + (b - a) * fraction
}

/// Red, green and blue of a luminance Y with (R - Y) / Y and (B - Y) / Y.
pub(super) fn rgb([luminance, red, blue]: [f32; 3], weights: [f32; 3]) -> [f32; 3] {
    let [red, blue] = [red, blue].map(|chroma| (chroma + 1.0) * luminance);
    let green = (luminance - weights[0] * red - weights[2] * blue) / weights[1];
    [red, green, blue].map(|value| radiance(value, f32::MAX))
}

/// Parts that red, green and blue of these primaries have in luminance; together they make white.
pub(super) fn weights(primaries: Option<Chromaticities>) -> [f32; 3] {
    let Some(primaries) = primaries else { return BT709 };
    let color = |at: exr::math::Vec2<f32>| {
        let (x, y) = (f64::from(at.x()), f64::from(at.y()));
        [x, y, 1.0 - x - y]
    };
    let [red, green, blue] = [primaries.red, primaries.green, primaries.blue].map(color);
    let white = color(primaries.white).map(|value| value / f64::from(primaries.white.y()));
    let volume = determinant(red, green, blue);
    let parts = [determinant(white, green, blue), determinant(red, white, blue), determinant(red, green, white)];
    let weights = [red, green, blue].map(|color| color[1]);
    let weights = [0, 1, 2].map(|i| (weights[i] * parts[i] / volume) as f32);
    let is_sound = weights.iter().all(|weight| weight.is_finite()) && weights[1] > 0.0;
    if is_sound { weights } else { BT709 }
}

fn determinant(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)
}
