//! OpenEXR images with channels in any order, any compression, blocks and layers.

use crate::common::decoded;
use exr::prelude::*;
use raggio_images::{Bitmap, Limits, Problem, Texels, decode};

const SIZE: Vec2<usize> = Vec2(37, 21);

/// Value of a pixel's channel: distinct in every pixel and, for the first three channels, exact as a half.
fn value(x: usize, y: usize, channel: usize) -> f32 {
    (x + y * SIZE.0 + channel * 500) as f32 / 4.0
}

fn samples(channel: usize, kind: SampleType, size: Vec2<usize>) -> FlatSamples {
    let values = (0..size.area()).map(|i| value(i % size.0, i / size.0, channel));
    match kind {
        SampleType::F16 => FlatSamples::F16(values.map(f16::from_f32).collect()),
        SampleType::F32 => FlatSamples::F32(values.collect()),
        SampleType::U32 => FlatSamples::U32(values.map(|v| v as u32).collect()),
    }
}

fn channel(name: &str, number: usize, kind: SampleType) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, samples(number, kind, SIZE))
}

fn layer(name: &str, encoding: Encoding, channels: Vec<AnyChannel<FlatSamples>>) -> Layer<AnyChannels<FlatSamples>> {
    Layer::new(SIZE, LayerAttributes::named(name), encoding, AnyChannels::sort(channels.into()))
}

/// The bytes of a file; a macro, because the crate's bounds for what can be written do not fit on a line.
macro_rules! written {
    ($image:expr) => {{
        let mut file = std::io::Cursor::new(Vec::new());
        $image.write().to_buffered(&mut file).expect("a valid image");
        file.into_inner()
    }};
}

fn rgb(kinds: [SampleType; 3]) -> Vec<AnyChannel<FlatSamples>> {
    ["R", "G", "B"].iter().zip(kinds).enumerate().map(|(i, (name, kind))| channel(name, i, kind)).collect()
}

/// Bitmap that `samples` gives for these channels.
fn expected(channels: [usize; 3]) -> Bitmap {
    let pixel = |i: usize| channels.map(|c| value(i % SIZE.0, i / SIZE.0, c));
    let texels = Texels::Rgb32F((0..SIZE.area()).map(pixel).collect());
    Bitmap { width: SIZE.0 as u32, height: SIZE.1 as u32, texels }
}

fn assert_same(bytes: &[u8], expected: &Bitmap, what: &str) {
    let (bitmap, limits) = (decoded(bytes), (expected.width, expected.height));
    assert_eq!((bitmap.width, bitmap.height), limits, "{what}");
    assert!(bitmap.texels == expected.texels, "{what}");
}

#[test]
fn every_compression_and_block() {
    let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8)), Blocks::Tiles(Vec2(64, 64))];
    let methods =
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ];
    for (blocks, compression) in blocks.iter().flat_map(|b| methods.map(|c| (*b, c))) {
        for line_order in [LineOrder::Increasing, LineOrder::Decreasing] {
            let encoding = Encoding { compression, blocks, line_order };
            let kinds = [SampleType::F16, SampleType::F32, SampleType::F16];
            let image = Image::from_layer(layer("a", encoding, rgb(kinds)));
            assert_same(&written!(image), &expected([0, 1, 2]), &format!("{encoding:?}"));
        }
    }
}

/// The loss is up to the method, so the pixels are compared with those that the crate's own reader gives.
#[test]
fn lossy_compressions_are_what_the_crate_reads() {
    let methods =
        [Compression::PXR24, Compression::B44, Compression::B44A, Compression::DWAA(None), Compression::DWAB(None)];
    for (compression, kind) in
        methods.iter().flat_map(|method| [(*method, SampleType::F16), (*method, SampleType::F32)])
    {
        let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let bytes = written!(Image::from_layer(layer("a", encoding, rgb([kind; 3]))));
        let image = read().no_deep_data().largest_resolution_level().rgb_channels(
            |size, _| vec![[0.0; 3]; size.area()],
            |pixels: &mut Vec<[f32; 3]>, at, (r, g, b): (f32, f32, f32)| pixels[at.y() * SIZE.0 + at.x()] = [r, g, b],
        );
        let image = image.first_valid_layer().all_attributes().from_buffered(std::io::Cursor::new(&bytes)).unwrap();
        let pixels = image.layer_data.channel_data.pixels.into_iter();
        // A method that loses something may end below zero.
        let texels = Texels::Rgb32F(pixels.map(|pixel| pixel.map(|x| x.max(0.0))).collect());
        assert_same(&bytes, &Bitmap { texels, ..expected([0, 1, 2]) }, &format!("{compression:?} {kind:?}"));
    }
}

#[test]
fn channels_by_name() {
    let encoding = Encoding::SMALL_LOSSLESS;
    let read = |channels: Vec<AnyChannel<FlatSamples>>| written!(Image::from_layer(layer("a", encoding, channels)));
    let float = |name, number| channel(name, number, SampleType::F32);
    assert_same(&read(vec![float("Y", 4)]), &expected([4; 3]), "luminance");
    assert_same(
        &read(vec![float("A", 7), float("Z", 8), float("r", 0), float("g", 1), float("b", 2)]),
        &expected([0, 1, 2]),
        "lower case, with alpha and depth",
    );
    let layers = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];
    let mut both: Vec<_> = layers.iter().enumerate().map(|(i, name)| float(name, i)).collect();
    assert_same(&read(both.clone()), &expected([0, 1, 2]), "without a prefix first");
    assert_same(&read(both.split_off(3)), &expected([3, 4, 5]), "with a prefix");
    let Texels::Rgb32F(red) = decoded(&read(vec![float("R", 1)])).texels else { panic!("expected floats") };
    assert_eq!(red[1], [value(1, 0, 1), 0.0, 0.0]);
    let nothing = decode(&read(vec![float("Z", 0)]), &Limits::default()).unwrap_err().problem;
    assert!(matches!(nothing, Problem::Unsupported { reason, .. } if reason.contains("R, G and B, or Y")));
}

#[test]
fn the_first_layer_with_colour() {
    let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..Encoding::SMALL_LOSSLESS };
    let depth = layer("depth", Encoding::FAST_LOSSLESS, vec![channel("Z", 9, SampleType::F32)]);
    let color = layer("color", tiles, rgb([SampleType::F32; 3]));
    let other = layer("other", tiles, vec![channel("Y", 5, SampleType::F32)]);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
    let image = Image::from_layers(attributes, vec![depth, color, other]);
    assert_same(&written!(image), &expected([0, 1, 2]), "layers");
}

#[test]
fn the_largest_of_several_resolutions() {
    let encoding = Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..Encoding::SMALL_LOSSLESS };
    let rounding_mode = exr::math::RoundingMode::Down;
    let sizes = exr::meta::mip_map_levels(rounding_mode, SIZE).map(|(_, size)| size);
    let sizes: Vec<_> = sizes.collect();
    let level =
        |number: usize, size: &Vec2<usize>| samples(if *size == SIZE { number } else { 9 }, SampleType::F32, *size);
    let channels = ["R", "G", "B"].iter().enumerate().map(|(number, name)| {
        let level_data = sizes.iter().map(|size| level(number, size)).collect();
        AnyChannel::new(*name, Levels::Mip { rounding_mode, level_data })
    });
    let layer = Layer::new(SIZE, LayerAttributes::named("a"), encoding, AnyChannels::sort(channels.collect()));
    assert_same(&written!(Image::from_layer(layer)), &expected([0, 1, 2]), "mip maps");
}

#[test]
fn a_data_window_away_from_the_origin() {
    let attributes = LayerAttributes { layer_position: Vec2(-5, 1000), ..LayerAttributes::named("a") };
    for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 16))] {
        let encoding = Encoding { blocks, ..Encoding::SMALL_LOSSLESS };
        let channels = AnyChannels::sort(rgb([SampleType::F32; 3]).into());
        let image = Image::from_layer(Layer::new(SIZE, attributes.clone(), encoding, channels));
        assert_same(&written!(image), &expected([0, 1, 2]), "offset");
    }
}

#[test]
fn numbers_that_light_cannot_be() {
    let values = [-1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5, 3e38];
    let single = FlatSamples::F32(values.to_vec());
    let half = FlatSamples::F16(values.map(f16::from_f32).to_vec());
    let channels = [("R", single), ("G", half), ("B", FlatSamples::U32(vec![0, 1, 2, 3, 4, u32::MAX]))];
    let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new(Vec2(6, 1), LayerAttributes::named("a"), Encoding::UNCOMPRESSED, channels);
    let Texels::Rgb32F(texels) = decoded(&written!(Image::from_layer(layer))).texels else { panic!("expected floats") };
    assert_eq!(texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [0.0, 0.0, f32::MAX, 0.0, 0.5, 3e38]);
    assert_eq!(texels.iter().map(|t| t[1]).collect::<Vec<_>>(), [0.0, 0.0, 65504.0, 0.0, 0.5, 65504.0]);
    assert_eq!(texels.iter().map(|t| t[2]).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0, 4294967296.0]);
}

/// Halved chromaticity beside full luminance, as OpenEXR's luminance-chroma files have it.
#[test]
fn subsampled_channels_are_refused() {
    let encoding = Encoding { compression: Compression::Uncompressed, ..Encoding::FAST_LOSSLESS };
    let mut bytes = written!(Image::from_layer(layer("a", encoding, vec![channel("Y", 0, SampleType::F32)])));
    let list = bytes.windows(7).position(|window| window == b"chlist\0").unwrap() + 7 + 4;
    // Name and zero, kind, linearity and padding, then the samplings.
    bytes[list + 10] = 2;
    let problem = decode(&bytes, &Limits::default()).unwrap_err().problem;
    assert!(matches!(&problem, Problem::Unsupported { .. } | Problem::Malformed { .. }), "{problem}");
    assert!(problem.to_string().contains("sampl"), "{problem}");
}
