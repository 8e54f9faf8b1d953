//! Textures and image skies on every device against definitions in double precision.

mod coordinates;
mod filtering;
mod formats;
mod hostile;
mod lookup;
mod sky;

use std::sync::Arc;

use raggio_render::{ColorSpace, DeviceScene, Probe, Question, TextureTable};
use raggio_scene::{Bitmap, Scene, Texels, Texture, TextureFilter, Wrap};
use raggio_tests::{Pcg, TestDevice, parse};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
const FILTERS: [TextureFilter; 2] = [TextureFilter::Linear, TextureFilter::Nearest];

/// Scene to be given textures.
fn anywhere() -> Scene {
    parse("[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n")
}

/// Arguments of a lookup: the texture's index, texture coordinates in both sets, a random number, and whether texels are
/// blended.
#[derive(Clone, Copy, Debug)]
struct Lookup {
    texture: usize,
    uv: [[f32; 2]; 2],
    random: f32,
    blended: bool,
}

impl Lookup {
    /// Makes a lookup at equal coordinates in both sets.
    fn at(texture: usize, uv: [f32; 2], random: f32) -> Self {
        Self { texture, uv: [uv; 2], random, blended: false }
    }

    fn question(&self) -> Question {
        let [[u0, v0], [u1, v1]] = self.uv;
        [[self.texture as f32, self.random, f32::from(u8::from(self.blended)), 0.0], [u0, v0, u1, v1], [0.0; 4]]
    }
}

/// Looks up values in `textures` on a device: red, green, blue, alpha, linear.
fn look_up(device: &TestDevice, textures: &[(Texture, ColorSpace)], lookups: &[Lookup]) -> Vec<[f32; 4]> {
    let mut table = TextureTable::default();
    let indices: Vec<_> = textures.iter().map(|(texture, space)| table.add(texture, *space).unwrap()).collect();
    let mut scene = DeviceScene::new(&anywhere()).expect("the scene fits devices");
    (scene.buffers.textures, scene.buffers.texels) = table.finish();
    let own_index = |l: &Lookup| Lookup { texture: indices[l.texture] as usize, ..*l }.question();
    let questions: Vec<_> = lookups.iter().map(own_index).collect();
    device.ask_in(&scene, Probe::Texture, &questions).into_iter().map(|answer| answer[0]).collect()
}

/// An image of 8 bits whose texels all differ from one another.
fn varied(width: u32, height: u32) -> Arc<Bitmap> {
    let mut random = Pcg::new(u64::from(width * 1000 + height));
    let texel = |i: u32| (random.bits() & 0xffff_ff00 | i).to_le_bytes();
    Arc::new(Bitmap { width, height, texels: Texels::Rgba8((0..width * height).map(texel).collect()) })
}

/// Random texels of floats.
fn bright(width: u32, height: u32) -> Arc<Bitmap> {
    let random = &mut Pcg::new(u64::from(width * 1000 + height));
    let texels = (0..width * height).map(|_| [(); 3].map(|()| 4.0 * random.unit())).collect();
    Arc::new(Bitmap { width, height, texels: Texels::Rgb32F(texels) })
}

/// The number of the texel below zero or beyond the last one that is shown at `index`.
fn wrapped(index: i64, size: u32, wrap: Wrap) -> usize {
    let size = i64::from(size);
    let wrapped = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::MirroredRepeat => {
            let twice = index.rem_euclid(2 * size);
            twice.min(2 * size - 1 - twice)
        }
        Wrap::ClampToEdge => index.clamp(0, size - 1),
    };
    wrapped as usize
}

/// Linear values of the texel at (x, y), which may be outside the image; 8 and 16 bits are taken for linear.
fn texel(texture: &Texture, x: i64, y: i64) -> [f64; 4] {
    let image = &texture.image;
    let [wrap_u, wrap_v] = texture.wrap;
    let place = wrapped(y, image.height, wrap_v) * image.width as usize + wrapped(x, image.width, wrap_u);
    match &image.texels {
        Texels::Rgba8(texels) => texels[place].map(|v| f64::from(v) / 255.0),
        Texels::Rgba16(texels) => texels[place].map(|v| f64::from(v) / 65535.0),
        Texels::Rgb32F(texels) => {
            let [r, g, b] = texels[place].map(f64::from);
            [r, g, b, 1.0]
        }
    }
}

/// Place of `uv` in texels from the image's top left corner.
fn place(texture: &Texture, uv: [f32; 2]) -> [f64; 2] {
    let [u, v] = uv.map(f64::from);
    let along = |row: [f32; 3], size: u32| {
        let [a, b, c] = row.map(f64::from);
        (a * u + b * v + c) * f64::from(size)
    };
    let [row_u, row_v] = texture.transform;
    [along(row_u, texture.image.width), along(row_v, texture.image.height)]
}

/// The blend of the four texels around a place.
fn bilinear(texture: &Texture, [x, y]: [f64; 2]) -> [f64; 4] {
    let [x, y] = [x - 0.5, y - 0.5];
    let [f, g] = [x - x.floor(), y - y.floor()];
    let [i, j] = [x.floor() as i64, y.floor() as i64];
    let corners = [(0, 0, (1.0 - f) * (1.0 - g)), (1, 0, f * (1.0 - g)), (0, 1, (1.0 - f) * g), (1, 1, f * g)];
    let mut sum = [0.0; 4];
    for (right, down, weight) in corners {
        let texel = texel(texture, i + right, j + down);
        (0..4).for_each(|c| sum[c] += weight * texel[c]);
    }
    sum
}

/// Middles of `count` equal parts of [0, 1).
fn middles(count: u32) -> impl Iterator<Item = f32> + Clone {
    (0..count).map(move |k| (k as f32 + 0.5) / count as f32)
}

/// Mean of the values, channel by channel.
fn mean(values: &[[f32; 4]]) -> [f64; 4] {
    [0, 1, 2, 3].map(|c| values.iter().map(|v| f64::from(v[c])).sum::<f64>() / values.len() as f64)
}

/// Largest difference of a channel.
fn distance(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
}
