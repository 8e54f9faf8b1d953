//! Filtering of textures: the mean of drawn texels is the bilinear blend.

use raggio_render::ColorSpace;
use raggio_scene::{Texture, Wrap};
use raggio_tests::{Pcg, for_each_device};

use crate::textures::{FILTERS, Lookup, WRAPS, bilinear, distance, look_up, mean, middles, place, texel, varied};

/// Evenly spaced random numbers choose every texel exactly as often as it weighs, at eighths of texels: all wrap modes,
/// from two images before to two beyond.
#[test]
fn texels_are_drawn_as_they_weigh() {
    let image = varied(8, 4);
    for_each_device(|device| {
        for wrap in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| [u, v])) {
            let texture = Texture { wrap, ..Texture::new(image.clone()) };
            let eighths = |i: u32, size: u32| (i as f32 / 8.0 - 2.0 * size as f32) / size as f32;
            let points: Vec<_> = (0..8 * 5 * 8).map(|i| [eighths(i, 8), eighths(7 * i % (8 * 5 * 4), 4)]).collect();
            let lookups: Vec<_> =
                points.iter().flat_map(|uv| middles(64).map(|random| Lookup::at(0, *uv, random))).collect();
            let found = look_up(&device, &[(texture.clone(), ColorSpace::Linear)], &lookups);
            for (uv, found) in points.iter().zip(found.chunks_exact(64)) {
                let (expected, found) = (bilinear(&texture, place(&texture, *uv)), mean(found));
                let what = format!("{} {wrap:?} at {uv:?}", device.label);
                assert!(distance(expected, found) < 1e-6, "{what}: expected {expected:?}, found {found:?}");
            }
        }
    });
}

/// Drawn texels average to the blend anywhere, through any transform, of images of any size: as often as evenly spaced
/// numbers can say.
#[test]
fn drawn_texels_average_to_the_blend() {
    const NUMBERS: u32 = 1024;
    // Each of the three borders between the four texels' numbers may be off by one; coordinates of up to a hundred
    // texels are rounded to a hundred-thousandth of one.
    const TOLERANCE: f64 = 3.0 / NUMBERS as f64 + 1e-4;
    let random = &mut Pcg::new(1);
    let texture = |i: usize| {
        let image = varied([1, 2, 3, 7, 16][i % 5], [1, 5, 8, 2][i % 4]);
        let transform = [(); 2].map(|()| [(); 3].map(|()| random.between(-2.0, 2.0) as f32));
        let wrap = [WRAPS[random.below(3)], WRAPS[random.below(3)]];
        Texture { uv_set: (i % 2) as u8, transform, wrap, ..Texture::new(image) }
    };
    let textures: Vec<_> = (0..60).map(texture).map(|texture| (texture, ColorSpace::Linear)).collect();
    let points: Vec<_> =
        (0..600).map(|i| (i % 60, [(); 2].map(|()| [(); 2].map(|()| 4.0 * random.unit() - 2.0)))).collect();
    let lookups: Vec<_> = points
        .iter()
        .flat_map(|(texture, uv)| {
            middles(NUMBERS).map(|random| Lookup { texture: *texture, uv: *uv, random, blended: false })
        })
        .collect();
    for_each_device(|device| {
        let found = look_up(&device, &textures, &lookups);
        for ((index, uv), found) in points.iter().zip(found.chunks_exact(NUMBERS as usize)) {
            let texture = &textures[*index].0;
            let place = place(texture, uv[usize::from(texture.uv_set)]);
            let (expected, found) = (bilinear(texture, place), mean(found));
            let what = format!("{} {texture:?} at {uv:?}", device.label);
            assert!(distance(expected, found) < TOLERANCE, "{what}: expected {expected:?}, found {found:?}");
        }
    });
}

/// Where texels are blended no random number changes anything.
#[test]
fn blends_are_blends() {
    let random = &mut Pcg::new(5);
    let mut textures = vec![];
    for wrap in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| [u, v])) {
        for image in [varied(16, 8), varied(5, 3), varied(1, 7)] {
            textures.push((Texture { wrap, ..Texture::new(image) }, ColorSpace::Linear));
        }
    }
    let lookup = |i: usize| {
        let uv = [(); 2].map(|()| 6.0 * random.unit() - 3.0);
        Lookup { blended: true, ..Lookup::at(i % 27, uv, random.unit()) }
    };
    let lookups: Vec<_> = (0..20_000).map(lookup).collect();
    for_each_device(|device| {
        for (lookup, found) in lookups.iter().zip(look_up(&device, &textures, &lookups)) {
            let texture = &textures[lookup.texture].0;
            let expected = bilinear(texture, place(texture, lookup.uv[0]));
            // Coordinates of three images of 16 texels are rounded to a few millionths of a texel.
            let apart = distance(expected, found.map(f64::from));
            assert!(apart < 2e-5, "{} {lookup:?}: expected {expected:?}, found {found:?}", device.label);
        }
    });
}

/// The random number is of no meaning without a filter, and the texel that holds the place is found.
#[test]
fn the_nearest_texel_is_the_one_around() {
    let random = &mut Pcg::new(2);
    let image = varied(7, 5);
    let wraps: Vec<[Wrap; 2]> = WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| [u, v])).collect();
    let texture = |wrap| Texture { wrap, filter: FILTERS[1], ..Texture::new(image.clone()) };
    let textures: Vec<_> = wraps.into_iter().map(|wrap| (texture(wrap), ColorSpace::Linear)).collect();
    let lookup = |i: usize| Lookup::at(i % 9, [(); 2].map(|()| 6.0 * random.unit() - 3.0), random.unit());
    let lookups: Vec<_> = (0..20_000).map(lookup).collect();
    for_each_device(|device| {
        let mut certain = 0;
        for (lookup, found) in lookups.iter().zip(look_up(&device, &textures, &lookups)) {
            let texture = &textures[lookup.texture].0;
            let [x, y] = place(texture, lookup.uv[0]);
            let near_border = [x, y].iter().any(|x| (x - x.round()).abs() < 1e-5);
            let expected = texel(texture, x.floor() as i64, y.floor() as i64);
            let right = distance(expected, found.map(f64::from)) < 1e-6;
            assert!(right || near_border, "{} {lookup:?}: expected {expected:?}, found {found:?}", device.label);
            certain += u32::from(!near_border);
        }
        assert!(certain > 19_900, "{certain} lookups were away from borders");
    });
}
