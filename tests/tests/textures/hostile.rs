//! Hostile coordinates: whatever they are, a lookup ends in its own image.

use std::sync::Arc;

use raggio_render::ColorSpace;
use raggio_scene::{Bitmap, Texels, Texture};
use raggio_tests::for_each_device;

use crate::textures::{FILTERS, Lookup, WRAPS, look_up};

const NUMBERS: [f32; 20] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    4_294_967_296.0,
    -2_147_483_648.0,
    16_777_217.0,
    1.0,
    0.999_999_94,
    1.000_000_1,
    2.0,
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    -1e-9,
    -1.0,
];

/// Every image is one number all over, and those before and after it are others.
#[test]
fn no_lookup_leaves_its_image() {
    let image = |i: usize, width: u32, height: u32| {
        let texels = Texels::Rgb32F(vec![[i as f32; 3]; (width * height) as usize]);
        Arc::new(Bitmap { width, height, texels })
    };
    let mut textures = vec![];
    for (filter, wrap) in FILTERS.into_iter().flat_map(|filter| WRAPS.map(|wrap| (filter, wrap))) {
        for (width, height) in [(1, 1), (3, 1), (4, 5), (1, 6)] {
            for scale in [1.0, 1e38, f32::INFINITY, f32::NAN] {
                let transform = [[scale, 0.0, 0.0], [0.0, scale, 0.0]];
                let image = image(textures.len(), width, height);
                textures
                    .push((Texture { transform, wrap: [wrap; 2], filter, ..Texture::new(image) }, ColorSpace::Linear));
            }
        }
    }
    let mut lookups = vec![];
    for texture in 0..textures.len() {
        for uv in NUMBERS.into_iter().flat_map(|u| NUMBERS.map(|v| [u, v])) {
            lookups.extend([0.0, 0.5, 0.999_999_94].map(|random| Lookup::at(texture, uv, random)));
        }
    }
    for_each_device(|device| {
        for (lookup, found) in lookups.iter().zip(look_up(&device, &textures, &lookups)) {
            let expected = lookup.texture as f32;
            assert_eq!(found, [expected, expected, expected, 1.0], "{} {lookup:?}", device.label);
        }
    });
}
