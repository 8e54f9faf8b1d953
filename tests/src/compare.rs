//! Comparison of pictures with reference pictures: averaged over blocks, where noise falls and bias stays.

use std::path::{Path, PathBuf};

use exr::prelude::{read_first_rgba_layer_from_file, write_rgb_file};
use raggio_render::{Film, Image};

/// Side of the blocks, in pixels.
const BLOCK: usize = 8;

/// Difference of a picture from its reference.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Relative error of the mean over all pixels.
    pub mean: f64,
    /// Median of the blocks' relative errors.
    pub median: f64,
    /// 95th percentile of the blocks' relative errors.
    pub p95: f64,
}

impl Difference {
    /// Whether the difference is within half a percent in the mean, 1 % in the median block, 4 % in all but a twentieth
    /// of the blocks.
    pub fn within_bounds(&self) -> bool {
        self.mean <= 0.005 && self.median <= 0.01 && self.p95 <= 0.04
    }
}

/// Difference of `image` from `reference`. The error of a dark block counts in proportion to a hundredth of the mean.
pub fn difference(reference: &Image, image: &Image) -> Difference {
    assert_eq!((reference.width, reference.height), (image.width, image.height), "pictures of different sizes");
    let finite = image.pixels.iter().flatten().all(|value| value.is_finite());
    assert!(finite, "the picture has values that are not finite");
    let mean = |image: &Image| {
        image.pixels.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / (3 * image.pixels.len()) as f64
    };
    let reference_mean = mean(reference);
    let mut errors: Vec<f64> = blocks(reference)
        .into_iter()
        .zip(blocks(image))
        .map(|(r, i)| (i - r).abs() / (r + 0.01 * reference_mean))
        .collect();
    errors.sort_by(f64::total_cmp);
    Difference {
        mean: (mean(image) / reference_mean - 1.0).abs(),
        median: percentile(&errors, 0.5),
        p95: percentile(&errors, 0.95),
    }
}

/// Errors of the blocks' mean luminances, each in units of the standard error that the film's own variance tells. A film
/// of independent samples without bias has the normal distribution's. The reference counts as right to a thousandth, and
/// the standard error of a block that samples hardly reach, where variances are guesses, as 3e-4 of the picture's mean.
pub fn scores(reference: &Image, film: &Film) -> Vec<f64> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    assert_eq!((reference.width as usize, reference.height as usize), (width, height), "pictures of different sizes");
    let luminance = |&[red, green, blue]: &[f32; 3]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let corners = (0..height / BLOCK).flat_map(|y| (0..width / BLOCK).map(move |x| (y * BLOCK, x * BLOCK)));
    let mean = reference.pixels.iter().map(|pixel| f64::from(luminance(pixel))).sum::<f64>() / (width * height) as f64;
    let dark = 3e-4 * mean * (BLOCK * BLOCK) as f64;
    let score = |(top, left): (usize, usize)| {
        let (mut found, mut expected, mut variance) = (0.0, 0.0, 0f64);
        for i in 0..BLOCK * BLOCK {
            let place = (top + i / BLOCK) * width + left + i % BLOCK;
            let pixel = &film.pixels()[place];
            expected += f64::from(luminance(&reference.pixels[place]));
            found += pixel.luminance();
            variance += pixel.luminance_error().expect("more than one sample").powi(2);
        }
        (found - expected) / variance.sqrt().hypot(dark + 1e-3 * expected)
    };
    corners.map(score).collect()
}

/// Means of all whole blocks, channel by channel.
fn blocks(image: &Image) -> Vec<f64> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut means = vec![];
    for top in (0..height / BLOCK * BLOCK).step_by(BLOCK) {
        for left in (0..width / BLOCK * BLOCK).step_by(BLOCK) {
            for channel in 0..3 {
                let pixel = |i: usize| image.pixels[(top + i / BLOCK) * width + left + i % BLOCK][channel];
                let sum: f64 = (0..BLOCK * BLOCK).map(|i| f64::from(pixel(i))).sum();
                means.push(sum / (BLOCK * BLOCK) as f64);
            }
        }
    }
    means
}

/// Percentile of sorted values, interpolated between neighbours.
fn percentile(sorted: &[f64], fraction: f64) -> f64 {
    let place = fraction * (sorted.len() - 1) as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    sorted[below] + (sorted[above] - sorted[below]) * place.fract()
}

/// Reads a picture of linear red, green and blue.
pub fn read_exr(path: &Path) -> Image {
    let read = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![[0f32; 3]; size.area()]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
    );
    let image = read.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let layer = image.layer_data;
    let (width, pixels) = layer.channel_data.pixels;
    Image { width: width as u32, height: (pixels.len() / width) as u32, pixels, alpha: None }
}

/// Writes reference, result and difference as EXR and PNG for people to look at; returns the folder.
pub fn leave_behind(name: &str, reference: &Image, result: &Image) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/test-failures");
    std::fs::create_dir_all(&folder).expect("target can be written to");
    let apart = |(r, i): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| (i[c] - r[c]).abs());
    let difference =
        Image { pixels: reference.pixels.iter().zip(&result.pixels).map(apart).collect(), ..reference.clone() };
    // Differences are small: brightened to be seen in the PNG.
    for (kind, image, gain) in
        [("reference", reference, 1.0), ("result", result, 1.0), ("difference", &difference, 10.0)]
    {
        let path = |ending: &str| folder.join(format!("{name}-{kind}.{ending}"));
        let (width, height) = (image.width as usize, image.height as usize);
        let pixel = |x: usize, y: usize| <(f32, f32, f32)>::from(image.pixels[y * width + x]);
        write_rgb_file(path("exr"), width, height, pixel).expect("target can be written to");
        let bytes: Vec<u8> = image.pixels.iter().flatten().map(|value| encoded(value * gain)).collect();
        let format = image::ColorType::Rgb8;
        image::save_buffer(path("png"), &bytes, image.width, image.height, format).expect("target can be written to");
    }
    folder.canonicalize().unwrap_or(folder)
}

/// Byte that encodes a linear value near enough to sRGB for looking at.
fn encoded(value: f32) -> u8 {
    (value.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0 + 0.5) as u8
}
