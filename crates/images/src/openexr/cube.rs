//! Cube maps as images of latitude and longitude.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::malformed;
use crate::error::Problem;

/// Lookups along each side of a texel: where three faces meet the cube's texels are a little smaller.
const LOOKUPS: usize = 2;

/// Size of the image that is made of a cube map of this size: at the equator texels are as large as in the middle of faces.
pub(super) fn unfolded_size(width: usize, height: usize) -> Result<[usize; 2], Problem> {
    if height.is_multiple_of(6) && width == height / 6 {
        return Ok([4 * width, 2 * width]);
    }
    Err(malformed(format!("{width} x {height} pixels are not six square faces of a cube, one above the other")))
}

/// Image of latitude and longitude of a cube map with faces of `side` x `side` pixels, from the top +X, -X, +Y, -Y, +Z, -Z.
/// Its centre is -Z, its right +X, its top +Y, as this program looks at skies.
pub(super) fn unfolded(side: usize, faces: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let [width, height] = [4 * side, 2 * side];
    let texel = |place: usize| {
        let (column, row) = (place % width, place / width);
        let at = |pixel: usize, lookup: usize| pixel as f64 + (lookup as f64 + 0.5) / LOOKUPS as f64;
        let mut sum = [0.0; 3];
        for (i, j) in (0..LOOKUPS * LOOKUPS).map(|lookup| (lookup % LOOKUPS, lookup / LOOKUPS)) {
            let (east, up) = (2.0 * PI * (at(column, i) / width as f64 - 0.5), PI * (0.5 - at(row, j) / height as f64));
            let direction = [up.cos() * east.sin(), up.sin(), -up.cos() * east.cos()];
            let color = sample(side, faces, direction);
            sum = [0, 1, 2].map(|c| sum[c] + color[c]);
        }
        sum.map(|sum| (sum / (LOOKUPS * LOOKUPS) as f64) as f32)
    };
    (0..width * height).into_par_iter().map(texel).collect()
}

/// Colour in a direction. The outermost texels of a face have their centres on the cube's edges.
fn sample(side: usize, faces: &[[f32; 3]], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let largest = x.abs().max(y.abs()).max(z.abs());
    let [x, y, z] = [x, y, z].map(|component| component / largest);
    // Rightward and downward in the face, from -1 to 1 (OpenEXR's `ImfEnvmap.h`).
    let (face, right, down) = if x.abs() == 1.0 {
        if x > 0.0 { (0, z, -y) } else { (1, -z, -y) }
    } else if y.abs() == 1.0 {
        if y > 0.0 { (2, x, -z) } else { (3, x, z) }
    } else if z > 0.0 {
        (4, -x, -y)
    } else {
        (5, x, -y)
    };
    let cell = |along: f64| {
        let place = 0.5 * (along + 1.0) * (side - 1) as f64;
        let first = (place as usize).min(side.saturating_sub(2));
        (first, place - first as f64)
    };
    let ((column, right), (row, down)) = (cell(right), cell(down));
    let texel = |i: usize, j: usize| {
        let place = (face * side + (row + j).min(side - 1)) * side + (column + i).min(side - 1);
        faces[place].map(f64::from)
    };
    let lerp = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|c| a[c] + t * (b[c] - a[c]));
    lerp(lerp(texel(0, 0), texel(1, 0), right), lerp(texel(0, 1), texel(1, 1), right), down)
}
