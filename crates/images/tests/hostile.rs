//! Hostile bytes lead to an image within the limits or to an error, never to a panic or an abort.
//!
//! `RAGGIO_FUZZ_SECONDS` says how long each format is mutated; the default is two seconds.

use std::time::{Duration, Instant};

use crate::common::{ETC1S, UASTC, UASTC_ZSTD, encoded, ktx2, png};
use exr::prelude::*;
use image::{DynamicImage, ImageFormat};
use raggio_images::{Limits, Problem, Texels, decode};

/// Limits small enough for a file that claims more than it has to be noticed.
const LIMITS: Limits = Limits { most_pixels: 1 << 20, most_bytes: 1 << 25 };

const FORMATS: [&str; 9] = ["png", "jpeg", "webp", "bmp", "tga", "tiff", "hdr", "exr", "ktx2"];

fn photo() -> image::RgbaImage {
    image::RgbaImage::from_fn(17, 9, |x, y| image::Rgba([(x * 10) as u8, (y * 12) as u8, (x * y) as u8, 255 - x as u8]))
}

fn raster_seeds(format: &str) -> Vec<Vec<u8>> {
    let image = DynamicImage::from(photo());
    match format {
        "png" => {
            let palette = png(png::ColorType::Indexed, png::BitDepth::Two, (3, 1), &[0b00_01_10_00], |encoder| {
                encoder.set_palette(vec![1, 2, 3, 4, 5, 6, 7, 8, 9]);
                encoder.set_trns(vec![255, 0, 99]);
            });
            let sixteen = DynamicImage::from(image.to_rgba16());
            vec![encoded(&image, ImageFormat::Png), encoded(&sixteen, ImageFormat::Png), palette]
        }
        "jpeg" => {
            let rgb = DynamicImage::from(image.to_rgb8());
            vec![encoded(&rgb, ImageFormat::Jpeg), encoded(&DynamicImage::from(image.to_luma8()), ImageFormat::Jpeg)]
        }
        "webp" => vec![encoded(&image, ImageFormat::WebP)],
        "bmp" => {
            vec![encoded(&image, ImageFormat::Bmp), encoded(&DynamicImage::from(image.to_rgb8()), ImageFormat::Bmp)]
        }
        "tga" => {
            vec![encoded(&image, ImageFormat::Tga), encoded(&DynamicImage::from(image.to_luma8()), ImageFormat::Tga)]
        }
        "tiff" => {
            let kinds = [image.to_rgb16().into(), DynamicImage::from(image.to_rgb32f()), image];
            kinds.iter().map(|image| encoded(image, ImageFormat::Tiff)).collect()
        }
        _ => vec![encoded(&DynamicImage::from(image.to_rgb32f()), ImageFormat::Hdr)],
    }
}

fn exr_seeds() -> Vec<Vec<u8>> {
    let scan = |compression| Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let methods = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ];
    let mut encodings: Vec<_> = methods.into_iter().map(scan).collect();
    encodings.push(Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..scan(Compression::ZIP16) });
    encodings.push(Encoding { blocks: Blocks::Tiles(Vec2(64, 8)), ..scan(Compression::PIZ) });
    let write = |encoding| {
        let values = |scale: f32| (0..11 * 9).map(move |i| (i % 11 + i / 11) as f32 * scale);
        let channels = vec![
            AnyChannel::new("B", FlatSamples::F32(values(0.1).collect())),
            AnyChannel::new("G", FlatSamples::F16(values(0.2).map(f16::from_f32).collect())),
            AnyChannel::new("R", FlatSamples::F16(values(3.0).map(f16::from_f32).collect())),
        ];
        let layer = || {
            let channels = AnyChannels::sort(channels.clone().into());
            Layer::new(Vec2(11, 9), LayerAttributes::named("a"), encoding, channels)
        };
        let mut file = std::io::Cursor::new(Vec::new());
        if encoding.compression == Compression::ZIP16 {
            let other = Layer { attributes: LayerAttributes::named("b"), ..layer() };
            let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((11, 9)));
            Image::from_layers(attributes, vec![layer(), other]).write().to_buffered(&mut file).unwrap();
        } else {
            Image::from_layer(layer()).write().to_buffered(&mut file).unwrap();
        }
        file.into_inner()
    };
    let chroma: [&[u8]; 3] = [
        include_bytes!("data/chroma-none.exr"),
        include_bytes!("data/chroma-zip.exr"),
        include_bytes!("data/chroma-piz.exr"),
    ];
    encodings.into_iter().map(write).chain(chroma.map(<[u8]>::to_vec)).collect()
}

fn seeds(format: &str) -> Vec<Vec<u8>> {
    match format {
        "exr" => exr_seeds(),
        "ktx2" => {
            let plain = ktx2(43, 0, (2, 2), (1, 1), 16, &[7; 16], "ru");
            let float = ktx2(97, 0, (2, 2), (1, 1), 32, &[60; 32], "rd");
            let block = [0xfc, 0xfd, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 2, 3, 4, 5, 6, 7, 8];
            let astc = ktx2(157, 0, (4, 3), (162, 4), 16, &block, "rd");
            vec![ETC1S.to_vec(), UASTC.to_vec(), UASTC_ZSTD.to_vec(), plain, float, astc]
        }
        _ => raster_seeds(format),
    }
}

/// Keeps decoders' panics, which become errors, from being printed; those of these tests still are.
fn silence_decoders() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let print = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if panic.location().is_some_and(|place| place.file().ends_with("hostile.rs")) {
                print(panic);
            }
        }));
    });
}

/// Runs something that has to be over within a second; once more if it was not, because another program may have had the
/// processor meanwhile.
fn within_a_second(what: &str, run: impl Fn()) {
    let takes = || {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    let limit = Duration::from_secs(1);
    let first = takes();
    if first >= limit {
        let second = takes();
        assert!(second < limit, "{what}: {first:?}, then {second:?}");
    }
}

/// Decodes the bytes and checks that whatever comes out fits together.
fn check(bytes: &[u8]) {
    match decode(bytes, &LIMITS) {
        Ok(bitmap) => {
            let pixels = u64::from(bitmap.width) * u64::from(bitmap.height);
            assert!(pixels > 0 && pixels <= LIMITS.most_pixels && pixels == bitmap.texels.len() as u64);
            if let Texels::Rgb32F(texels) = &bitmap.texels {
                assert!(texels.as_flattened().iter().all(|x| x.is_finite() && *x >= 0.0));
            }
        }
        Err(error) => assert!(!error.to_string().chars().any(char::is_control), "{error:?}"),
    }
}

/// The most memory that this process has had, where the system tells.
fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok()).map_or(0, |kilobytes| kilobytes << 10)
}

/// A file in which a decoder panics: its description says that blocks of texels are 256 wide.
fn that_panics() -> Vec<u8> {
    include_bytes!("data/texel-dimension.ktx2").to_vec()
}

/// A hook that is told of a decoder's panic can tell that somebody else will deal with it.
#[test]
fn hooks_know_of_the_guard() {
    use std::sync::atomic::{AtomicU32, Ordering};
    static TOLD: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
    silence_decoders();
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        TOLD[usize::from(raggio_images::guarded())].fetch_add(1, Ordering::Relaxed);
        before(panic);
    }));
    let error = decode(&that_panics(), &LIMITS).unwrap_err();
    assert_eq!(error.to_string(), "is a KTX2 that is damaged: its decoder gave up on what it holds");
    assert!(TOLD[1].load(Ordering::Relaxed) > 0, "the file should make its decoder panic");
    assert!(!raggio_images::guarded());
    assert_eq!(TOLD[0].load(Ordering::Relaxed), 0, "no panic comes without a guard");
}

/// Checksums of a file that is right stay, and wrong ones become right.
#[test]
fn checksums_can_be_mended() {
    for seed in seeds("png") {
        let mut bytes = seed.clone();
        mend_checksums(&mut bytes);
        assert!(bytes == seed);
        // The checksum of the header.
        bytes[29] ^= 1;
        assert!(decode(&bytes, &LIMITS).is_err());
        mend_checksums(&mut bytes);
        assert!(bytes == seed);
    }
}

#[test]
fn seeds_are_valid() {
    for (format, seed) in FORMATS.iter().flat_map(|format| seeds(format).into_iter().map(move |seed| (format, seed))) {
        decode(&seed, &LIMITS).unwrap_or_else(|error| panic!("{format}: {error}"));
    }
}

#[test]
fn truncated_at_every_byte() {
    silence_decoders();
    for seed in FORMATS.iter().flat_map(|format| seeds(format)) {
        (0..seed.len()).for_each(|length| check(&seed[..length]));
    }
}

/// The bytes with the four at `at` replaced by `number`.
fn with(mut bytes: Vec<u8>, at: usize, number: [u8; 4]) -> Vec<u8> {
    bytes[at..at + 4].copy_from_slice(&number);
    bytes
}

fn position(bytes: &[u8], word: &[u8]) -> usize {
    bytes.windows(word.len()).position(|window| window == word).expect("a file with this word")
}

/// The header of a file of 16384 x 16384 pixels with all its blocks, but next to nothing in them.
fn empty_exr() -> Vec<u8> {
    const SIDE: usize = 1 << 14;
    let compression = Compression::DWAB(None);
    let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(vec![AnyChannel::new("Y", FlatSamples::F16(vec![f16::ZERO; 1]))].into());
    let mut file = std::io::Cursor::new(Vec::new());
    let layer = Layer::new(Vec2(1, 1), LayerAttributes::named("a"), encoding, channels);
    Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
    let mut bytes = file.into_inner();
    let window = position(&bytes, b"dataWindow\0box2i\0") + 17 + 4 + 8;
    bytes = with(with(bytes, window, (SIDE as u32 - 1).to_le_bytes()), window + 4, (SIDE as u32 - 1).to_le_bytes());
    // The only block follows the header and its one offset.
    bytes.truncate(bytes.len() - 8 - 8 - 2);
    let (count, start) = (SIDE / 256, bytes.len());
    bytes.extend((0..count).flat_map(|i| ((start + 8 * count + 8 * i) as u64).to_le_bytes()));
    bytes.extend((0..count).flat_map(|i| (256 * i as u64).to_le_bytes()));
    bytes
}

/// A file whose entries of width and height are `side`.
fn tiff(side: u32) -> Vec<u8> {
    let bytes = seeds("tiff").swap_remove(2);
    let entry = |tag: u8| position(&bytes, &[tag, 1, 4, 0, 1, 0, 0, 0]) + 8;
    let (width, height) = (entry(0), entry(1));
    with(with(bytes, width, side.to_le_bytes()), height, side.to_le_bytes())
}

/// Headers that declare 30000 x 30000 pixels and more, under the limits that a program has.
#[test]
fn huge_dimensions_are_refused_at_once() {
    let jpeg = |size: [u8; 4]| {
        let bytes = seeds("jpeg").swap_remove(0);
        let at = position(&bytes, &[0xff, 0xc0]) + 5;
        with(bytes, at, size)
    };
    let png = seeds("png").swap_remove(0);
    let hdr =
        String::from_utf8_lossy(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483647 +X 2147483647\n").into_owned();
    let exr = seeds("exr").swap_remove(0);
    let window = position(&exr, b"dataWindow\0box2i\0") + 17 + 4 + 8;
    let files = [
        jpeg([0xff; 4]),
        // These sizes are within the limits, but beyond what so few bytes can hold.
        jpeg([0x3f, 0xff, 0x3f, 0xff]),
        with(with(png.clone(), 16, [0x7f; 4]), 20, [0x7f; 4]),
        hdr.into_bytes(),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16383 +X 16383\n\x02\x02".to_vec(),
        b"#?RGBE\n+X 16383 -Y 16383\n\x02\x02".to_vec(),
        with(with(seeds("bmp").swap_remove(1), 18, 16_000u32.to_le_bytes()), 22, 16_000u32.to_le_bytes()),
        with(with(seeds("bmp").swap_remove(0), 18, [0xff, 0xff, 0xff, 0x7f]), 22, [0xff, 0xff, 0xff, 0x7f]),
        with(seeds("tga").swap_remove(0), 12, [0x80, 0x3e, 0x80, 0x3e]),
        with(seeds("tga").swap_remove(0), 12, [0xff; 4]),
        tiff(16_000),
        tiff(u32::MAX),
        with(with(exr.clone(), window, 30_000u32.to_le_bytes()), window + 4, 30_000u32.to_le_bytes()),
        with(with(exr, window, 0x3000_0000u32.to_le_bytes()), window + 4, 0x3000_0000u32.to_le_bytes()),
        empty_exr(),
        with(with(ETC1S.to_vec(), 20, [0xff; 4]), 24, [0xff; 4]),
        with(with(UASTC.to_vec(), 20, 16_000u32.to_le_bytes()), 24, 16_000u32.to_le_bytes()),
        with(with(UASTC_ZSTD.to_vec(), 20, 16_000u32.to_le_bytes()), 24, 16_000u32.to_le_bytes()),
        ktx2(109, 0, (u32::MAX, u32::MAX), (1, 1), 16, &[0; 16], "rd"),
    ];
    for (i, file) in files.iter().enumerate() {
        within_a_second(&format!("file {i}"), || {
            let error = decode(file, &Limits::default()).unwrap_err();
            assert!(!matches!(error.problem, Problem::UnknownFormat | Problem::Unreadable(_)), "{i}: {error}");
        });
    }
    let reason = decode(&empty_exr(), &Limits::default()).unwrap_err().to_string();
    assert!(reason.contains("0 bytes cannot hold a block of 16384 x 256 pixels"), "{reason}");
    // A WebP whose extended header declares the largest size.
    let webp = [b"RIFF\x1e\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0", [0xff; 6].as_slice(), b"VP8 \0\0\0\0"].concat();
    assert!(decode(&webp, &Limits::default()).is_err());
}

/// SplitMix64, a generator of random numbers.
struct Rng(u64);

impl Rng {
    fn next_u32(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 32) as u32
    }
}

fn index(rng: &mut Rng, count: usize) -> usize {
    rng.next_u32() as usize % count
}

/// Makes one to eight changes: bytes replaced, flipped, inserted, removed, repeated, or numbers made extreme.
fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    const NUMBERS: [u32; 8] = [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x0001_0000];
    for _ in 0..=index(rng, 8) {
        if bytes.is_empty() {
            return;
        }
        let at = index(rng, bytes.len());
        match rng.next_u32() % 6 {
            0 => bytes[at] = rng.next_u32() as u8,
            1 => bytes[at] ^= 1 << (rng.next_u32() % 8),
            2 => bytes.insert(at, rng.next_u32() as u8),
            3 => drop(bytes.drain(at..bytes.len().min(at + 1 + index(rng, 4)))),
            4 => {
                let end = bytes.len().min(at + 1 + index(rng, 32));
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            _ => {
                let number = NUMBERS[index(rng, NUMBERS.len())].to_le_bytes();
                let end = bytes.len().min(at + 4);
                bytes[at..end].copy_from_slice(&number[..end - at]);
            }
        }
    }
}

/// Makes the checksums of a PNG's chunks right again: no decoder looks at what is behind a wrong one.
fn mend_checksums(bytes: &mut [u8]) {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let mut chunk = 8;
    while let Some(length) = bytes.get(chunk..).and_then(|rest| rest.first_chunk()) {
        let end = chunk + 8 + u32::from_be_bytes(*length) as usize;
        if end + 4 > bytes.len() {
            return;
        }
        let crc = !bytes[chunk + 4..end].iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step));
        bytes[end..end + 4].copy_from_slice(&crc.to_be_bytes());
        chunk = end + 4;
    }
}

/// Mutates files of a format for a while; each run makes the same changes for as far as it gets.
fn fuzz(format: &str) {
    silence_decoders();
    let seconds = std::env::var("RAGGIO_FUZZ_SECONDS").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(2.0);
    let (seeds, start) = (seeds(format), Instant::now());
    let mut rng = Rng(1);
    let mut files = 0u64;
    while start.elapsed().as_secs_f64() < seconds {
        let mut bytes = seeds[index(&mut rng, seeds.len())].clone();
        mutate(&mut bytes, &mut rng);
        if format == "png" && index(&mut rng, 4) > 0 {
            mend_checksums(&mut bytes);
        }
        within_a_second(&format!("{format}, file {files}"), || check(&bytes));
        files += 1;
    }
    let peak = peak_bytes();
    assert!(peak < 1 << 30, "{format}: {peak} bytes after {files} files");
    println!("{format}: {files} files");
}

#[test]
fn fuzz_png() {
    fuzz("png");
}

#[test]
fn fuzz_jpeg() {
    fuzz("jpeg");
}

#[test]
fn fuzz_webp() {
    fuzz("webp");
}

#[test]
fn fuzz_bmp() {
    fuzz("bmp");
}

#[test]
fn fuzz_tga() {
    fuzz("tga");
}

#[test]
fn fuzz_tiff() {
    fuzz("tiff");
}

#[test]
fn fuzz_hdr() {
    fuzz("hdr");
}

#[test]
fn fuzz_exr() {
    fuzz("exr");
}

#[test]
fn fuzz_ktx2() {
    fuzz("ktx2");
}
