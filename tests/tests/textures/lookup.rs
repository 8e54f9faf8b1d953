//! Lookups of textures: which way is up, sets of coordinates, and what wrapping does far away.

use std::sync::Arc;

use raggio_render::ColorSpace;
use raggio_scene::{Bitmap, Texels, Texture, TextureFilter, Wrap};
use raggio_tests::{Pcg, for_each_device};

use crate::textures::{FILTERS, Lookup, WRAPS, look_up, varied};

/// Image of four texels: red, green; blue, white.
fn four_colors() -> Arc<Bitmap> {
    let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    Arc::new(Bitmap { width: 2, height: 2, texels: Texels::Rgba8(texels.to_vec()) })
}

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const GREEN: [f32; 4] = [0.0, 1.0, 0.0, 1.0];
const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];
const WHITE: [f32; 4] = [1.0; 4];

/// Centres of texels have nothing to draw: (0, 0) is the top left corner, v goes down.
#[test]
fn the_origin_is_the_top_left_corner() {
    let texture = (Texture::new(four_colors()), ColorSpace::Linear);
    let corners = [([0.25, 0.25], RED), ([0.75, 0.25], GREEN), ([0.25, 0.75], BLUE), ([0.75, 0.75], WHITE)];
    let lookups = corners.map(|(uv, _)| Lookup::at(0, uv, 0.5));
    for_each_device(|device| {
        let found = look_up(&device, std::slice::from_ref(&texture), &lookups);
        assert_eq!(found, corners.map(|(_, color)| color), "{}", device.label);
    });
}

/// The transform is a quarter turn about the origin with a shift, and the other set of coordinates is used.
#[test]
fn transforms_and_sets_are_applied() {
    let plain = Texture { filter: TextureFilter::Nearest, ..Texture::new(four_colors()) };
    let second = Texture { uv_set: 1, ..plain.clone() };
    // The transform takes (u, v) to (v, 1 - u).
    let turned = Texture { transform: [[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]], ..plain.clone() };
    let textures = [plain, second, turned].map(|texture| (texture, ColorSpace::Linear));
    let uv = [[0.25, 0.25], [0.75, 0.25]];
    let lookups = [0, 1, 2].map(|texture| Lookup { texture, uv, random: 0.5, blended: false });
    for_each_device(|device| {
        assert_eq!(look_up(&device, &textures, &lookups), [RED, GREEN, BLUE], "{}", device.label);
    });
}

/// A shift by whole images changes nothing, to the bit, even by a million of them: at sixteenths, which floats still
/// tell apart there.
#[test]
fn distant_images_are_the_same() {
    let random = &mut Pcg::new(3);
    let mut textures = vec![];
    for (filter, wrap) in FILTERS.into_iter().flat_map(|filter| WRAPS.map(|wrap| (filter, wrap))) {
        for image in [varied(16, 8), varied(5, 3), varied(1, 7)] {
            textures.push((Texture { wrap: [wrap; 2], filter, ..Texture::new(image) }, ColorSpace::Linear));
        }
    }
    let mut near = || {
        let sixteenths = [(); 2].map(|()| random.below(16) as f32 / 16.0);
        (random.below(textures.len()), sixteenths, random.unit())
    };
    let near: Vec<_> = (0..5000).map(|_| near()).collect();
    let shifted = |by: f32| near.iter().map(|(t, uv, u)| Lookup::at(*t, uv.map(|c| c + by), *u)).collect::<Vec<_>>();
    for_each_device(|device| {
        let here = look_up(&device, &textures, &shifted(0.0));
        for by in [-1e6, -1002.0, -2.0, 2.0, 1002.0, 1e6] {
            let there = look_up(&device, &textures, &shifted(by));
            for ((place, here), there) in near.iter().zip(&here).zip(there) {
                let texture = &textures[place.0].0;
                let image = &texture.image;
                let edge = if by < 0.0 { 0 } else { image.texels.len() - 1 };
                let expected = match (texture.wrap[0], &image.texels) {
                    (Wrap::ClampToEdge, Texels::Rgba8(texels)) => texels[edge].map(|v| f32::from(v) * (1.0 / 255.0)),
                    _ => *here,
                };
                assert_eq!(there, expected, "{} {texture:?} at {place:?} shifted by {by}", device.label);
            }
        }
    });
}

/// The mirrored image is seen from behind an odd number of images away.
#[test]
fn mirrored_images_alternate() {
    let wrap = [Wrap::MirroredRepeat, Wrap::Repeat];
    let texture = Texture { wrap, filter: TextureFilter::Nearest, ..Texture::new(four_colors()) };
    let textures = [(texture, ColorSpace::Linear)];
    let across = [-3.75, -2.75, -1.75, -0.75, 0.25, 1.25, 2.25, 3.25, 1_000_001.25];
    let expected = [RED, GREEN, RED, GREEN, RED, GREEN, RED, GREEN, GREEN];
    let lookups = across.map(|u| Lookup::at(0, [u, 0.25], 0.5));
    for_each_device(|device| {
        assert_eq!(look_up(&device, &textures, &lookups), expected, "{}", device.label);
    });
}
