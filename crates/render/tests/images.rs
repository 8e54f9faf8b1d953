//! Pictures read from disk and resized.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use raggio_render::{
    Channel, Display, Extras, Film, FilmPixel, Image, ImageFile, Metadata, PngBits, ToneMapper, Values, show_bytes,
};
use raggio_scene::Scene;

/// A film of 3x2 pixels whose means are exact in 8 bits: 0 or 1 in each channel.
fn film() -> Film {
    let mut film = Film::new(3, 2);
    let pixels = film.pixels().iter().enumerate().map(|(i, pixel)| {
        let sum = |bit: usize| raggio_kernels::FixedSum { low: 0, middle: ((i >> bit) as u32 & 1) << 8, high: 0 };
        FilmPixel { red: sum(0), green: sum(1), blue: sum(2), samples: 1, ..*pixel }
    });
    film = Film::from_pixels(3, 2, pixels.collect());
    film
}

fn write(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let display = Display { tone_mapper: ToneMapper::None, ..Display::default() };
    ImageFile::new(&path).expect("a format").write(&film(), display).expect("the picture is written");
    path
}

/// The error's text, which begins with the file's name or says that it cannot be read.
#[track_caller]
fn refusal(path: &Path) -> String {
    let error = Image::load(path).expect_err("the file is refused").to_string();
    assert!(error.contains(&path.display().to_string()), "{error}");
    error
}

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["picture.exr", "picture.png", "PICTURE.PNG"] {
        assert_eq!(Image::load(&write(folder.path(), name)).expect("a picture"), film().mean(), "{name}");
    }
}

/// PNGs of 16 bits are read as finely as they are written.
#[test]
fn sixteen_bits_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fine.png");
    let pixels: Vec<_> = (0..257).map(|i| [i as f32 / 256.0, i as f32 / 65536.0, 2.0]).collect();
    let image = Image { width: 257, height: 1, pixels, alpha: None };
    let file = ImageFile::new(&path).expect("a format").with_png_bits(PngBits::Sixteen);
    let display = Display { tone_mapper: ToneMapper::None, ..Display::default() };
    file.write(&Film::from_image(&image), display).expect("the picture is written");
    let found = Image::load(&path).expect("a picture");
    for (found, written) in found.pixels.iter().zip(&image.pixels) {
        for (found, written) in found.iter().zip(written) {
            let expected = written.min(1.0);
            // Half a step of 65535 becomes at most 1.2 of them where the curve is steepest.
            assert!((found - expected).abs() < 1.3 / 65535.0, "{written} became {found}");
        }
    }
}

/// Alpha goes with a picture into a film and back. Bytes have the colours of what is covered, and an alpha that is no colour.
#[test]
fn alpha_stays() {
    let pixels = vec![[0.5, 0.25, 0.0], [0.0; 3], [2.0, 1.0, 0.5]];
    let image = Image { width: 3, height: 1, pixels, alpha: Some(vec![0.5, 0.0, 1.0]) };
    assert_eq!(Film::from_image(&image).mean(), image);
    assert_eq!(image.straight().pixels, [[1.0, 0.5, 0.0], [0.0; 3], [2.0, 1.0, 0.5]]);
    let display = Display { tone_mapper: ToneMapper::None, ..Display::default() };
    assert_eq!(show_bytes(&image, display), [255, 188, 0, 128, 0, 0, 0, 0, 255, 255, 188, 255]);
    let opaque = Image { alpha: None, ..image.clone() };
    assert_eq!(show_bytes(&opaque, display), [188, 137, 0, 0, 0, 0, 255, 255, 188]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    ImageFile::new(&path).expect("a format").write_image(&image, display, &Extras::default()).expect("it is written");
    let png = image::open(&path).expect("a PNG").into_rgba8();
    assert_eq!(png.into_raw(), show_bytes(&image, display));
}

/// Messages go to terminals, and nobody has asked for a temporary file.
#[test]
fn errors_name_files_safely() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, message) in [
        ("a\u{1b}[2J", "a\\u{1b}[2J: the ending must be .png"),
        ("none\u{7}/a.png", "none\\u{7}/a.png: No such file or directory"),
    ] {
        let error = ImageFile::new(&folder.path().join(name)).expect_err("no such place").to_string();
        assert!(error.contains(message) && !error.contains(".raggio-"), "{error:?}");
        assert!(!error.chars().any(char::is_control), "{error:?}");
    }
    let error = Image::load(&folder.path().join("a\u{7}.png")).expect_err("no such file").to_string();
    assert!(error.contains("a\\u{7}.png: ") && !error.chars().any(char::is_control), "{error:?}");
    // The folder goes while the picture is made, and something else stands in its place.
    let file = ImageFile::new(&folder.path().join("a.png")).expect("a place");
    folder.close().expect("the folder goes");
    std::fs::write(file.path().parent().expect("a folder"), "no folder").expect("a file");
    let error = file.write(&film(), Display::default()).expect_err("no folder").to_string();
    assert!(error.starts_with("cannot write ") && !error.contains(".raggio-"), "{error}");
    // Only where it is asked to does it go elsewhere, and there it replaces nothing.
    let refuge = tempfile::tempdir().expect("a folder");
    let file = file.with_refuge(refuge.path());
    for name in ["a.png", "a-2.png"] {
        let error = file.write(&film(), Display::default()).expect_err("no folder").to_string();
        assert!(error.ends_with(&format!(": it is in {name} instead")), "{error}");
        assert_eq!(Image::load(&refuge.path().join(name)).expect("a picture").width, film().width());
    }
    assert_eq!(std::fs::read_dir(refuge.path()).expect("the folder").count(), 2);
    std::fs::remove_file(file.path().parent().expect("a folder")).expect("the file goes");
}

/// OpenEXR's texts are UTF-8, and readers refuse a file with others.
#[test]
fn names_in_metadata_are_utf_8() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("picture.exr");
    let text = "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n";
    let scene = Scene::parse(text, "scene.toml").expect("the scene is right");
    let name = "gr\u{fc}n, \u{65e5}\u{672c}.toml";
    let extras = Extras { metadata: Some(Metadata::new(&scene, name)), ..Extras::default() };
    let file = ImageFile::new(&path).expect("a format");
    file.write_with(&film(), Display::default(), &extras).expect("the picture is written");
    let bytes = std::fs::read(&path).expect("the file");
    let attribute = b"scene\0string\0";
    let start = bytes.windows(attribute.len()).position(|window| window == attribute).expect("the attribute");
    let (length, value) = bytes[start + attribute.len()..].split_first_chunk().expect("a length");
    let value = &value[..u32::from_le_bytes(*length) as usize];
    assert_eq!(std::str::from_utf8(value), Ok(name));
    assert_eq!(Image::load(&path).expect("a picture"), film().mean());
}

/// Noise to the last bit, which cannot be deflated, beside what can be, in blocks of rows of which the last is not full.
#[test]
fn exr_files_hold_each_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    let (width, height) = (97, 43);
    let mut state = 7u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 3) ^ (state << 9)
    };
    let numbers: Vec<u32> = (0..width * height).map(|_| noise()).collect();
    let row = |i: u32| i / width;
    let depths: Vec<f32> = (0..width * height)
        .map(|i| if (16..32).contains(&row(i)) { f32::from_bits(noise() & 0x7f7f_ffff) } else { row(i) as f32 })
        .collect();
    let pixels = depths.iter().map(|depth| [*depth, 1.0, -depth]).collect();
    let image = Image { width, height, pixels, alpha: None };
    let channels = vec![
        Channel { name: "object_id.I".into(), values: Values::U32(numbers.clone()) },
        Channel { name: "depth.Z".into(), values: Values::F32(depths.clone()) },
    ];
    let extras = Extras { channels, ..Extras::default() };
    let file = ImageFile::new(&path).expect("a format");
    file.write_image(&image, Display::default(), &extras).expect("the picture is written");
    let bytes = std::fs::read(&path).expect("the file");
    let read = exr::prelude::read_first_flat_layer_from_file(&path).expect("an EXR");
    let channel = |name: &str| {
        let found = read.layer_data.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
        found.expect("the channel").sample_data.clone()
    };
    assert!(channel("object_id.I") == exr::prelude::FlatSamples::U32(numbers));
    assert!(channel("depth.Z") == exr::prelude::FlatSamples::F32(depths.clone()) && channel("R") == channel("depth.Z"));
    assert!(channel("B") == exr::prelude::FlatSamples::F32(depths.iter().map(|depth| -depth).collect()));
    assert!(bytes.len() < (width * height * 16) as usize, "{} bytes", bytes.len());
    file.write_image(&image, Display::default(), &extras).expect("the picture is written");
    assert!(std::fs::read(&path).expect("the file") == bytes);
}

/// Means are all that a front end keeps of a film; dim ones are below the steps of its sums.
#[test]
fn files_of_means_are_those_of_the_film() {
    let folder = tempfile::tempdir().expect("a folder");
    let dim =
        FilmPixel { red: raggio_kernels::FixedSum { low: 1, middle: 0, high: 0 }, samples: 3, ..FilmPixel::default() };
    let pixels = film().pixels().iter().copied().map(|pixel| if pixel.red.middle == 0 { dim } else { pixel }).collect();
    let film = Film::from_pixels(3, 2, pixels);
    for name in ["a.exr", "a.png"] {
        let [of_film, of_means] = ["film", "means"].map(|kind| folder.path().join(format!("{kind}.{name}")));
        let file = |path: &Path| ImageFile::new(path).expect("a format");
        file(&of_film).write(&film, Display::default()).expect("the picture is written");
        let written = file(&of_means).write_image(&film.mean(), Display::default(), &Extras::default());
        written.expect("the picture is written");
        let read = |path: &Path| std::fs::read(path).expect("the file");
        assert_eq!(read(&of_film), read(&of_means), "{name}");
        if name == "a.png" {
            assert_eq!(read(&of_means), raggio_render::encode_png(&film.mean(), Display::default()).expect("a PNG"));
        }
    }
}

#[test]
fn png_values_become_linear() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grey.png");
    image::GrayImage::from_raw(2, 1, vec![128, 10]).expect("two pixels").save(&path).expect("a PNG");
    let found = Image::load(&path).expect("a picture").pixels;
    let expected = [0.215_860_5, 10.0 / 255.0 / 12.92];
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(found.iter().all(|value| (value - expected).abs() < 1e-6), "expected {expected}, found {found:?}");
    }
}

#[test]
fn half_precision_is_read_and_what_is_no_number_is_black() {
    use exr::prelude::{Image as ExrImage, SpecificChannels, Vec2, WritableImage, f16};
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("half.exr");
    let pixel = |at: Vec2<usize>| (f16::from_f32(at.x() as f32 + 0.5), f16::NAN, f16::INFINITY);
    let image = ExrImage::from_channels((4, 3), SpecificChannels::rgb(pixel));
    image.write().to_file(&path).expect("an EXR");
    let found = Image::load(&path).expect("a picture");
    assert_eq!((found.width, found.height), (4, 3));
    assert_eq!(found.pixels[6], [2.5, 0.0, 0.0]);
}

#[test]
fn files_that_are_no_pictures_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    assert!(refusal(&path("none.exr")).starts_with("cannot read "));
    assert!(
        refusal(&path("picture.jpg"))
            .ends_with("the ending must be .png (for looking at), .exr (linear radiance) or .film (sums of samples)")
    );
    std::fs::create_dir(path("folder.png")).expect("a folder");
    assert!(refusal(&path("folder.png")).starts_with("cannot read "));
    for (name, kind) in [("text.exr", "an OpenEXR"), ("text.png", "a PNG")] {
        std::fs::write(path(name), "not a picture").expect("a file");
        let error = refusal(&path(name));
        assert!(error.contains(&format!(": not {kind} image with red, green and blue that can be read: ")), "{error}");
    }
    // Cut short anywhere, a file is refused or, where only its end is missing, read.
    for name in ["whole.exr", "whole.png"] {
        let bytes = std::fs::read(write(folder.path(), name)).expect("the file");
        for length in 0..bytes.len() {
            std::fs::write(path(name), &bytes[..length]).expect("a file");
            let loaded = Image::load(&path(name));
            assert!(loaded.is_err() || length > bytes.len() / 2, "{name}, {length} of {} bytes", bytes.len());
        }
    }
}

/// A few bytes must not cost gigabytes.
#[test]
fn sizes_beyond_reason_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), "large.exr");
    let mut bytes = std::fs::read(&path).expect("the file");
    let key = b"dataWindow\0box2i\0";
    let at = bytes.windows(key.len()).position(|window| window == key).expect("a data window") + key.len() + 4;
    bytes[at + 8..at + 16].copy_from_slice(&[59_999u32.to_le_bytes(), 49_999u32.to_le_bytes()].concat());
    std::fs::write(&path, &bytes).expect("a file");
    let error = refusal(&path);
    assert!(error.contains("60000x50000 pixels are more than the 67108864 that a reference image may have"), "{error}");

    let path = write(folder.path(), "large.png");
    let mut bytes = std::fs::read(&path).expect("the file");
    bytes[16..24].copy_from_slice(&[60_000u32.to_be_bytes(), 50_000u32.to_be_bytes()].concat());
    let checksum = crc(&bytes[12..29]).to_be_bytes();
    bytes[29..33].copy_from_slice(&checksum);
    std::fs::write(&path, &bytes).expect("a file");
    let error = refusal(&path);
    assert!(error.contains("60000x50000 pixels are more than"), "{error}");
}

/// The checksum of PNG's chunks.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

fn mean(image: &Image) -> [f64; 3] {
    let count = image.pixels.len() as f64;
    [0, 1, 2].map(|channel| image.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / count)
}

proptest! {
    #[test]
    fn resizing_keeps_means_and_constants(
        from in (1u32..40, 1u32..40),
        to in (1u32..60, 1u32..60),
        values in proptest::collection::vec([0.0f32..10.0, 0.0f32..1.0, -1.0f32..1.0], 1600),
    ) {
        let count = (from.0 * from.1) as usize;
        let image = Image { width: from.0, height: from.1, pixels: values[..count].to_vec(), alpha: None };
        let resized = image.resized(to.0, to.1);
        prop_assert_eq!((resized.width, resized.height, resized.pixels.len() as u32), (to.0, to.1, to.0 * to.1));
        for (before, after) in mean(&image).into_iter().zip(mean(&resized)) {
            prop_assert!((before - after).abs() < 1e-6 * before.abs().max(1.0), "{} becomes {}", before, after);
        }
        let constant = Image { pixels: vec![[0.1, 2.5, 1e-6]; count], ..image.clone() };
        for pixel in constant.resized(to.0, to.1).pixels {
            for (found, expected) in pixel.into_iter().zip([0.1f32, 2.5, 1e-6]) {
                prop_assert!((found - expected).abs() <= 2e-7 * expected);
            }
        }
        prop_assert_eq!(image.resized(from.0, from.1), image);
    }
}

#[test]
fn resizing_averages_what_a_pixel_covers() {
    let row = Image { width: 3, height: 1, pixels: [0.0, 3.0, 6.0].map(|v| [v; 3]).to_vec(), alpha: None };
    let halves: Vec<f32> = row.resized(2, 1).pixels.iter().map(|pixel| pixel[0]).collect();
    assert_eq!(halves, [1.0, 5.0]);
}
