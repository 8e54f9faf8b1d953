//! Every stored number becomes the number it stands for.

use std::sync::Arc;

use raggio_render::ColorSpace;
use raggio_scene::{Bitmap, Texels, Texture, TextureFilter};
use raggio_tests::{TestDevice, for_each_device};

use crate::textures::{Lookup, look_up};

/// Reads all texels in order.
fn read_back(device: &TestDevice, image: &Arc<Bitmap>, space: ColorSpace) -> Vec<[f32; 4]> {
    let texture = Texture { filter: TextureFilter::Nearest, ..Texture::new(image.clone()) };
    let (width, height) = (image.width, image.height);
    let center = |i: u32, size: u32| (i as f32 + 0.5) / size as f32;
    let lookup = |i: u32| Lookup::at(0, [center(i % width, width), center(i / width, height)], 0.0);
    look_up(device, &[(texture, space)], &(0..width * height).map(lookup).collect::<Vec<_>>())
}

/// Linear value by the definition, IEC 61966-2-1.
fn decoded(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Relative error of a number, none where nothing is expected and found.
fn error(expected: f64, found: f32) -> f64 {
    if expected == 0.0 { f64::from(found).abs() } else { (f64::from(found) / expected - 1.0).abs() }
}

/// Relative error of one rounding of the factor and one of the product.
const LINEAR_ERROR: f64 = 1.2e-7;
/// Relative error of sRGB values as documented.
const SRGB_ERROR: f64 = 5e-7;

/// Checks an image that has a different number in each channel, and all numbers in each.
fn check(device: &TestDevice, image: &Arc<Bitmap>, stored: impl Fn(usize, usize) -> f64) {
    let mut worst = 0.0f64;
    for (i, found) in read_back(device, image, ColorSpace::Linear).into_iter().enumerate() {
        for (c, found) in found.into_iter().enumerate() {
            let error = error(stored(i, c), found);
            assert!(error < LINEAR_ERROR, "{} {image:?}: {} became {found}", device.label, stored(i, c));
        }
    }
    for (i, found) in read_back(device, image, ColorSpace::Srgb).into_iter().enumerate() {
        let rgb = (0..3).map(|c| (decoded(stored(i, c)), SRGB_ERROR));
        for (c, (expected, allowed)) in rgb.chain([(stored(i, 3), LINEAR_ERROR)]).enumerate() {
            let error = error(expected, found[c]);
            worst = worst.max(error);
            assert!(error < allowed, "{} {image:?}: {expected} is expected, not {}", device.label, found[c]);
        }
    }
    println!("{} {image:?}: worst relative error of sRGB {worst:.2e}", device.label);
}

#[test]
fn all_numbers_of_8_bits() {
    let number = |i: usize, c: usize| (i + 64 * c) as u8;
    let texels = (0..256).map(|i| [0, 1, 2, 3].map(|c| number(i, c))).collect();
    let image = Arc::new(Bitmap { width: 32, height: 8, texels: Texels::Rgba8(texels) });
    for_each_device(|device| check(&device, &image, |i, c| f64::from(number(i, c)) / 255.0));
}

#[test]
fn all_numbers_of_16_bits() {
    let number = |i: usize, c: usize| (i + 16384 * c) as u16;
    let texels = (0..65536).map(|i| [0, 1, 2, 3].map(|c| number(i, c))).collect();
    let image = Arc::new(Bitmap { width: 512, height: 128, texels: Texels::Rgba16(texels) });
    for_each_device(|device| check(&device, &image, |i, c| f64::from(number(i, c)) / 65535.0));
}

/// Floats are equal to the bit, and the alpha that is not stored is 1.
#[test]
fn floats_stay_what_they_are() {
    let texels: Vec<_> = (0..250u32).map(|i| [i as f32 * 1e-3, 1.5f32.powi(i as i32 / 2), 1e-30 * i as f32]).collect();
    let image = Arc::new(Bitmap { width: 25, height: 10, texels: Texels::Rgb32F(texels.clone()) });
    for_each_device(|device| {
        for space in [ColorSpace::Linear, ColorSpace::Srgb] {
            let expected: Vec<_> = texels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
            assert_eq!(read_back(&device, &image, space), expected, "{}", device.label);
        }
    });
}

/// Black and white are exact, or closed rooms would gain light.
#[test]
fn black_and_white_are_exact() {
    let images = [Texels::Rgba8(vec![[0; 4], [255; 4]]), Texels::Rgba16(vec![[0; 4], [65535; 4]])];
    for_each_device(|device| {
        for texels in images.clone() {
            let image = Arc::new(Bitmap { width: 2, height: 1, texels });
            for space in [ColorSpace::Linear, ColorSpace::Srgb] {
                assert_eq!(read_back(&device, &image, space), [[0.0; 4], [1.0; 4]], "{} {image:?}", device.label);
            }
        }
    });
}
