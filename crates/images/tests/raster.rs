//! PNG, JPEG, WebP, BMP, TGA, TIFF and Radiance HDR come out as they were written.

use crate::common::{decoded, encoded, png};
use image::{DynamicImage, ImageFormat};
use png::{BitDepth, ColorType};
use raggio_images::{Bitmap, Limits, Problem, Texels, decode, load};

const RGBA: [[u8; 4]; 6] =
    [[0, 1, 2, 3], [255, 254, 253, 252], [10, 20, 30, 40], [128, 0, 127, 1], [9, 9, 9, 0], [200, 100, 50, 255]];

/// Values that 8 bits cannot hold.
const RGBA16: [[u16; 4]; 6] = [
    [0, 1, 2, 3],
    [65535, 65534, 257, 256],
    [255, 254, 1000, 30000],
    [32768, 32767, 12345, 1],
    [9, 9, 9, 0],
    [4242, 1, 65535, 65279],
];

fn rgba8(bytes: &[u8]) -> Vec<[u8; 4]> {
    match decoded(bytes).texels {
        Texels::Rgba8(texels) => texels,
        _ => panic!("expected 8 bits"),
    }
}

fn bytes16(texels: &[[u16; 4]], channels: &[usize]) -> Vec<u8> {
    texels.iter().flat_map(|texel| channels.iter().flat_map(|c| texel[*c].to_be_bytes())).collect()
}

#[test]
fn png_of_8_bits_is_kept() {
    let bytes = png(ColorType::Rgba, BitDepth::Eight, (3, 2), RGBA.as_flattened(), |_| {});
    assert_eq!(decoded(&bytes), Bitmap { width: 3, height: 2, texels: Texels::Rgba8(RGBA.to_vec()) });
    let rgb: Vec<u8> = RGBA.iter().flat_map(|t| [t[0], t[1], t[2]]).collect();
    let opaque = RGBA.map(|[r, g, b, _]| [r, g, b, 255]);
    assert_eq!(rgba8(&png(ColorType::Rgb, BitDepth::Eight, (3, 2), &rgb, |_| {})), opaque);
    let grey = png(ColorType::Grayscale, BitDepth::Eight, (2, 1), &[7, 200], |_| {});
    assert_eq!(rgba8(&grey), [[7, 7, 7, 255], [200, 200, 200, 255]]);
    let grey_alpha = png(ColorType::GrayscaleAlpha, BitDepth::Eight, (2, 1), &[7, 1, 200, 2], |_| {});
    assert_eq!(rgba8(&grey_alpha), [[7, 7, 7, 1], [200, 200, 200, 2]]);
}

#[test]
fn png_of_16_bits_is_kept() {
    let sixteen = |color, channels: &[usize]| {
        let bytes = png(color, BitDepth::Sixteen, (3, 2), &bytes16(&RGBA16, channels), |_| {});
        match decoded(&bytes).texels {
            Texels::Rgba16(texels) => texels,
            _ => panic!("expected 16 bits"),
        }
    };
    assert_eq!(sixteen(ColorType::Rgba, &[0, 1, 2, 3]), RGBA16);
    assert_eq!(sixteen(ColorType::Rgb, &[0, 1, 2]), RGBA16.map(|[r, g, b, _]| [r, g, b, 65535]));
    assert_eq!(sixteen(ColorType::Grayscale, &[0]), RGBA16.map(|[r, ..]| [r, r, r, 65535]));
    assert_eq!(sixteen(ColorType::GrayscaleAlpha, &[0, 1]), RGBA16.map(|[r, a, ..]| [r, r, r, a]));
}

#[test]
fn png_palettes_and_transparent_colours() {
    let palette = png(ColorType::Indexed, BitDepth::Two, (3, 1), &[0b00_01_10_00], |encoder| {
        encoder.set_palette(vec![1, 2, 3, 4, 5, 6, 7, 8, 9]);
        encoder.set_trns(vec![255, 0, 99]);
    });
    assert_eq!(rgba8(&palette), [[1, 2, 3, 255], [4, 5, 6, 0], [7, 8, 9, 99]]);
    let key = png(ColorType::Rgb, BitDepth::Eight, (2, 1), &[1, 2, 3, 4, 5, 6], |encoder| {
        encoder.set_trns(vec![0, 4, 0, 5, 0, 6]);
    });
    assert_eq!(rgba8(&key), [[1, 2, 3, 255], [4, 5, 6, 0]]);
    let bits = png(ColorType::Grayscale, BitDepth::One, (3, 1), &[0b1010_0000], |_| {});
    assert_eq!(rgba8(&bits), [[255; 4], [0, 0, 0, 255], [255; 4]]);
}

/// A file with a gamma of 1 and a middle grey keeps the grey: nothing is made of the gamma.
#[test]
fn srgb_is_not_touched() {
    let bytes = png(ColorType::Rgb, BitDepth::Eight, (1, 1), &[128, 64, 32], |encoder| {
        encoder.set_source_gamma(png::ScaledFloat::new(1.0));
    });
    assert_eq!(rgba8(&bytes), [[128, 64, 32, 255]]);
}

#[test]
fn webp_is_kept() {
    let image = image::RgbaImage::from_raw(3, 2, RGBA.as_flattened().to_vec()).unwrap();
    assert_eq!(rgba8(&encoded(&DynamicImage::from(image), ImageFormat::WebP)), RGBA);
}

#[test]
fn jpeg_is_near() {
    let halves =
        image::RgbImage::from_fn(32, 16, |x, _| image::Rgb(if x < 16 { [200, 30, 60] } else { [20, 200, 90] }));
    let bitmap = decoded(&encoded(&DynamicImage::from(halves.clone()), ImageFormat::Jpeg));
    assert_eq!((bitmap.width, bitmap.height), (32, 16));
    let Texels::Rgba8(texels) = bitmap.texels else { panic!("expected 8 bits") };
    for (texel, pixel) in texels.iter().zip(halves.pixels()) {
        assert!((0..3).all(|i| texel[i].abs_diff(pixel.0[i]) <= 6) && texel[3] == 255, "{texel:?} {pixel:?}");
    }
    let grey = image::GrayImage::from_pixel(9, 9, image::Luma([77]));
    let grey = rgba8(&encoded(&DynamicImage::from(grey), ImageFormat::Jpeg));
    assert!(grey.iter().all(|t| t[0] == t[1] && t[1] == t[2] && t[0].abs_diff(77) <= 1));
}

#[test]
fn hdr_is_kept() {
    // The mantissas of a pixel share an exponent, so these survive.
    let pixels = [[1.0, 0.5, 0.25], [1024.0, 0.0, 512.0], [0.0, 0.0, 0.0], [3.0, 1.5, 0.75]];
    let image = image::Rgb32FImage::from_raw(2, 2, pixels.as_flattened().to_vec()).unwrap();
    let bytes = encoded(&DynamicImage::from(image), ImageFormat::Hdr);
    assert_eq!(decoded(&bytes), Bitmap { width: 2, height: 2, texels: Texels::Rgb32F(pixels.to_vec()) });
}

/// Pixels of a file of Radiance's, each red, green, blue and the exponent that they share, without compression.
fn hdr(header: &str) -> Vec<u8> {
    let pixels =
        [[128, 0, 0, 129], [0, 128, 0, 129], [0, 0, 128, 129], [128, 128, 0, 129], [0, 128, 128, 130], [64; 4]];
    [header.as_bytes(), pixels.as_flattened()].concat()
}

/// The colours of [`hdr`], in the file's order.
const HDR: [[f32; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.0, 2.0, 2.0], [1.355_252_7e-20; 3]];

#[test]
fn headers_of_hdr() {
    let expected = Bitmap { width: 3, height: 2, texels: Texels::Rgb32F(HDR.to_vec()) };
    let headers = [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n",
        "#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\nGAMMA=1\r\n\r\n-Y 2 +X 3\r\n",
        "#?AUTOPANO\n# a comment\nrpict -vta -x 3\nEXPOSURE=none\nFORMAT = 32-bit_rle_rgbe \n\n\n -Y 2  +X 3 \n",
        "#?RADIANCE\n-Y 2 +X 3\n",
    ];
    for header in headers {
        assert_eq!(decoded(&hdr(header)), expected, "{header}");
    }
    let problem = |header: &str| decode(&hdr(header), &Limits::default()).unwrap_err().problem.to_string();
    let other = problem("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 3\n");
    assert!(other.contains("its format is `32-bit_rle_xyze`; write `32-bit_rle_rgbe`"), "{other}");
    for header in ["#?RADIANCE\n\n", "#?RADIANCE\n\n-Y 2 +Y 3\n", "#?RADIANCE\n\n-Y 2 +X 3 4\n"] {
        assert!(problem(header).contains("its header should end with a line that says its size"), "{header}");
    }
    assert!(problem("#?RADIANCE\n\n-Y 3 +X 3\n").contains("damaged"));
}

#[test]
fn orders_of_pixels_in_hdr() {
    let order = |size: &str| {
        let bitmap = decoded(&hdr(&format!("#?RADIANCE\n\n{size}\n")));
        let Texels::Rgb32F(texels) = bitmap.texels else { panic!("expected floats") };
        let place = |texel| HDR.iter().position(|other| *other == texel).expect("a colour of the file");
        (bitmap.width, bitmap.height, texels.into_iter().map(place).collect::<Vec<_>>())
    };
    assert_eq!(order("+Y 2 +X 3"), (3, 2, vec![3, 4, 5, 0, 1, 2]));
    assert_eq!(order("-Y 2 -X 3"), (3, 2, vec![2, 1, 0, 5, 4, 3]));
    assert_eq!(order("+Y 2 -X 3"), (3, 2, vec![5, 4, 3, 2, 1, 0]));
    assert_eq!(order("+X 3 -Y 2"), (3, 2, vec![0, 2, 4, 1, 3, 5]));
    assert_eq!(order("+X 3 +Y 2"), (3, 2, vec![1, 3, 5, 0, 2, 4]));
    assert_eq!(order("-X 3 -Y 2"), (3, 2, vec![4, 2, 0, 5, 3, 1]));
    assert_eq!(order("-X 3 +Y 2"), (3, 2, vec![5, 3, 1, 4, 2, 0]));
}

#[test]
fn bmp_tga_and_tiff_of_8_bits_are_kept() {
    let image = DynamicImage::from(image::RgbaImage::from_raw(3, 2, RGBA.as_flattened().to_vec()).unwrap());
    let opaque = RGBA.map(|[r, g, b, _]| [r, g, b, 255]);
    let rgb = DynamicImage::from(image.to_rgb8());
    for format in [ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::Tiff] {
        assert_eq!(rgba8(&encoded(&image, format)), RGBA, "{format:?}");
        assert_eq!(rgba8(&encoded(&rgb, format)), opaque, "{format:?}");
        let grey = DynamicImage::from(image::GrayImage::from_raw(2, 1, vec![7, 200]).unwrap());
        assert_eq!(rgba8(&encoded(&grey, format)), [[7, 7, 7, 255], [200, 200, 200, 255]], "{format:?}");
    }
}

#[test]
fn tga_without_compression_and_with_a_palette() {
    let header = |palette: u8, kind: u8, entries: u8, depth: u8, flags: u8| {
        let entry_bits = if palette == 1 { 24 } else { 0 };
        [0, palette, kind, 0, 0, entries, 0, entry_bits, 0, 0, 0, 0, 2, 0, 2, 0, depth, flags]
    };
    // Blue, green, red; from the bottom left unless a flag says from the top.
    let pixels = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
    let rows = [[3, 2, 1, 255], [6, 5, 4, 255], [9, 8, 7, 255], [12, 11, 10, 255]];
    assert_eq!(rgba8(&[&header(0, 2, 0, 24, 0x20)[..], &pixels].concat()), rows);
    assert_eq!(rgba8(&[&header(0, 2, 0, 24, 0)[..], &pixels].concat()), [rows[2], rows[3], rows[0], rows[1]]);
    let indexed = [&header(1, 1, 4, 8, 0x20)[..], &pixels, &[3, 0, 1, 2]].concat();
    assert_eq!(rgba8(&indexed), [rows[3], rows[0], rows[1], rows[2]]);
}

#[test]
fn tiff_of_16_bits_and_of_floats_is_kept() {
    let raw = RGBA16.as_flattened().to_vec();
    let image = image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(3, 2, raw).unwrap();
    let bitmap = decoded(&encoded(&DynamicImage::from(image), ImageFormat::Tiff));
    assert_eq!(bitmap, Bitmap { width: 3, height: 2, texels: Texels::Rgba16(RGBA16.to_vec()) });
    let pixels = [[1.5, -0.5, 1e-9], [f32::NAN, f32::INFINITY, 3e38]];
    let image = image::Rgb32FImage::from_raw(2, 1, pixels.as_flattened().to_vec()).unwrap();
    let bitmap = decoded(&encoded(&DynamicImage::from(image), ImageFormat::Tiff));
    let expected = vec![[1.5, 0.0, 1e-9], [0.0, f32::MAX, 3e38]];
    assert_eq!(bitmap, Bitmap { width: 2, height: 1, texels: Texels::Rgb32F(expected) });
}

#[test]
fn sizes_are_held_against_the_limits() {
    let bytes = png(ColorType::Rgba, BitDepth::Eight, (3, 2), RGBA.as_flattened(), |_| {});
    let most = |most_pixels, most_bytes| decode(&bytes, &Limits { most_pixels, most_bytes }).map_err(|e| e.problem);
    assert!(most(6, 4096).is_ok());
    assert!(matches!(most(5, 4096), Err(Problem::TooManyPixels { width: 3, height: 2, .. })));
    assert_eq!(most(6, 20), Err(Problem::FileTooLarge { most: 20 }));
    assert_eq!(decode(b"GIF89a", &Limits::default()).unwrap_err().problem, Problem::UnknownFormat);
}

#[test]
fn files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a\u{1b}b.jpg");
    let name = |path: &std::path::Path| load(path, &Limits::default()).unwrap_err().to_string();
    assert!(name(&path).contains("a\\u{1b}b.jpg: cannot be read"), "{}", name(&path));
    // The format is told by the bytes, not by the extension.
    std::fs::write(&path, png(ColorType::Rgba, BitDepth::Eight, (3, 2), RGBA.as_flattened(), |_| {})).unwrap();
    assert_eq!(load(&path, &Limits::default()).unwrap().width, 3);
    assert!(name(folder.path()).contains("cannot be read"));
}
