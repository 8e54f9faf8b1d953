//! OpenEXR images with channels in any order, any compression, blocks and layers.

use std::f64::consts::PI;

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

/// Files of OpenEXR's own library: luminance of every pixel, and chroma of every second one in both directions.
const CHROMA: [(&str, (usize, usize), &[u8]); 6] = [
    ("none", (12, 6), include_bytes!("data/chroma-none.exr")),
    ("rle", (12, 6), include_bytes!("data/chroma-rle.exr")),
    ("zips", (12, 6), include_bytes!("data/chroma-zips.exr")),
    ("zip", (12, 6), include_bytes!("data/chroma-zip.exr")),
    ("pxr24", (12, 6), include_bytes!("data/chroma-pxr24.exr")),
    ("piz", (20, 70), include_bytes!("data/chroma-piz.exr")),
];

/// The colour of a pixel of these files: chroma is linear, so that what is between samples is known but behind the last.
fn of_chroma(x: usize, y: usize, (width, height): (usize, usize)) -> [f32; 3] {
    let (sampled_x, sampled_y) = (x.min(width - 2) as f32, y.min(height - 2) as f32);
    let (luminance, red, blue) = ((1 + x + 2 * y) as f32 / 8.0, (sampled_x - 4.0) / 16.0, (sampled_y - 2.0) / 8.0);
    let [red, blue] = [red, blue].map(|chroma| (chroma + 1.0) * luminance);
    [red, (luminance - 0.2126 * red - 0.0722 * blue) / 0.7152, blue].map(|value| value.max(0.0))
}

#[test]
fn luminance_and_chroma_become_colours() {
    for (compression, size, bytes) in CHROMA {
        let bitmap = decoded(bytes);
        assert_eq!((bitmap.width as usize, bitmap.height as usize), size, "{compression}");
        let Texels::Rgb32F(texels) = bitmap.texels else { panic!("expected floats") };
        for (i, texel) in texels.iter().enumerate() {
            let expected = of_chroma(i % size.0, i / size.0, size);
            let near =
                texel.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-4 * expected.max(1.0));
            assert!(near, "{compression}, pixel {i}: {texel:?} should be {expected:?}");
        }
    }
}

/// Grey stays grey whatever the primaries are, and luminance keeps its value where they are given.
#[test]
fn chroma_follows_the_primaries() {
    let flat = |name: &str, value: f32| AnyChannel::new(name, FlatSamples::F32(vec![value; SIZE.area()]));
    let read = |red: f32, blue: f32, primaries: Option<attribute::Chromaticities>| {
        let channels = AnyChannels::sort(vec![flat("Y", 0.5), flat("RY", red), flat("BY", blue)].into());
        let mut image = Image::from_channels(SIZE, channels);
        image.attributes.chromaticities = primaries;
        let Texels::Rgb32F(texels) = decoded(&written!(image)).texels else { panic!("expected floats") };
        texels[7]
    };
    // Those of ACES' AP1, whose parts in luminance are 0.27223, 0.67408 and 0.05369.
    let ap1 = attribute::Chromaticities {
        red: Vec2(0.713, 0.293),
        green: Vec2(0.165, 0.830),
        blue: Vec2(0.128, 0.044),
        white: Vec2(0.32168, 0.33767),
    };
    for (primaries, weights) in [(None, [0.2126, 0.7152, 0.0722]), (Some(ap1), [0.272_229, 0.674_082, 0.053_689])] {
        assert!(read(0.0, 0.0, primaries).iter().all(|value| (value - 0.5).abs() < 1e-6));
        let found = read(0.5, -0.5, primaries);
        let expected = [0.75, (0.5 - weights[0] * 0.75 - weights[2] * 0.25) / weights[1], 0.25];
        assert!(found.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-4), "{found:?}");
    }
}

/// The file with the number of columns from one sample of its first channel to the next replaced.
fn with_sampling(mut bytes: Vec<u8>, first: &str, across: u8) -> Vec<u8> {
    let list = bytes.windows(7).position(|window| window == b"chlist\0").unwrap() + 7 + 4;
    // Name and zero, kind, linearity and padding, then the samplings.
    bytes[list + first.len() + 1 + 8] = across;
    bytes
}

#[test]
fn samplings_that_are_not_read_are_told() {
    let bytes = written!(Image::from_layer(layer("a", Encoding::UNCOMPRESSED, vec![channel("Y", 0, SampleType::F32)])));
    let problem = |bytes: &[u8]| decode(bytes, &Limits::default()).unwrap_err().problem.to_string();
    assert!(problem(&with_sampling(bytes.clone(), "Y", 3)).contains("a channel has a sample for 3 x 1 pixels"));
    assert!(problem(&with_sampling(bytes, "Y", 2)).contains("the samples of a channel do not fit its image"));
    assert!(problem(include_bytes!("data/chroma-b44.exr")).contains("not in B44"));
    assert!(decode(&with_sampling(CHROMA[0].2.to_vec(), "BY", 0), &Limits::default()).is_err());
}

fn warnings(bytes: &[u8]) -> Vec<String> {
    raggio_images::Image::decode(bytes, &Limits::default()).expect("a valid image").warnings
}

#[test]
fn the_best_of_several_layers_and_which_it_is() {
    let float = |name: String, number| channel(&name, number, SampleType::F32);
    let colors = |prefix: &str, first: usize| {
        let color = |(i, last): (usize, &str)| float(format!("{prefix}.{last}"), first + i);
        ["R", "G", "B"].into_iter().enumerate().map(color).collect::<Vec<_>>()
    };
    let file = |channels: Vec<AnyChannel<FlatSamples>>| {
        written!(Image::from_layer(layer("a", Encoding::SMALL_LOSSLESS, channels)))
    };
    // As Blender has them, in the order of the alphabet.
    let mut all = [colors("View.AO", 3), colors("View.Combined", 6), colors("View.Normal", 9)].concat();
    all.push(float("View.Depth.Z".into(), 1));
    let bytes = file(all.clone());
    assert_same(&bytes, &expected([6, 7, 8]), "Combined");
    let named = "it has the layers `View.AO`, `View.Combined`, `View.Normal`: `View.Combined` is taken";
    assert_eq!(warnings(&bytes), [named]);
    all.extend(rgb([SampleType::F32; 3]));
    let bytes = file(all);
    assert_same(&bytes, &expected([0, 1, 2]), "without a name");
    assert_eq!(warnings(&bytes), [""; 0]);
    // Luminance alone and a vector's y are less of a colour than red, green and blue.
    let vector = ["X", "Y", "Z"].map(|last| float(format!("N.{last}"), 12)).to_vec();
    let bytes = file([vec![float("A.Y".into(), 11)], vector, colors("Other", 3)].concat());
    assert_same(&bytes, &expected([3, 4, 5]), "the first with all colours");
    assert_eq!(warnings(&bytes), ["it has the layers `A`, `Other`: `Other` is taken"]);
    assert_eq!(warnings(&file(colors("Other", 3))), [""; 0]);
}

#[test]
fn parts_have_names_too() {
    let encoding = Encoding::SMALL_LOSSLESS;
    let grey = |name: &str, number| layer(name, encoding, vec![channel("Y", number, SampleType::F32)]);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
    let parts = vec![grey("albedo", 5), grey("View.rgba", 6), grey("gr\u{fc}n", 7)];
    let bytes = written!(Image::from_layers(attributes, parts));
    assert_same(&bytes, &expected([6; 3]), "rgba");
    // The library writes the name in Latin-1, which is no UTF-8.
    let named = "it has the layers `albedo`, `View.rgba`, `gr\u{fffd}n`: `View.rgba` is taken";
    assert_eq!(warnings(&bytes), [named]);
}

#[test]
fn environments_are_images_of_latitude_and_longitude() {
    let mut image = Image::from_layer(layer("a", Encoding::SMALL_LOSSLESS, rgb([SampleType::F32; 3])));
    image.layer_data.attributes.environment_map = Some(attribute::EnvironmentMap::LatitudeLongitude);
    assert_same(&written!(image), &expected([0, 1, 2]), "latitude and longitude");
    image.layer_data.attributes.environment_map = Some(attribute::EnvironmentMap::Cube);
    let problem = decode(&written!(image), &Limits::default()).unwrap_err().problem;
    let reason = "37 x 21 pixels are not six square faces of a cube";
    assert!(matches!(&problem, Problem::Malformed { reason: found, .. } if found.contains(reason)), "{problem}");
}

/// Cube map of faces with `side` pixels along each edge whose colours are `color` of their directions.
fn cube(side: usize, color: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<u8> {
    let size = Vec2(side, 6 * side);
    let pixels: Vec<_> = (0..size.area())
        .map(|i| {
            let along = |pixel: usize| 2.0 * pixel as f64 / (side - 1) as f64 - 1.0;
            // Rightward and upward, looking at the face from the middle, with -Y below, and with +Z below for +Y.
            let (right, up) = (along(i % side), -along(i / side % side));
            let direction = [
                [1.0, up, right],
                [-1.0, up, -right],
                [right, 1.0, up],
                [right, -1.0, -up],
                [-right, up, 1.0],
                [right, up, -1.0],
            ];
            color(direction[i / size.0 / side])
        })
        .collect();
    let channels = ["R", "G", "B"].iter().enumerate().map(|(c, name)| {
        let values = pixels.iter().map(|pixel| pixel[c] as f32).collect();
        AnyChannel::new(*name, FlatSamples::F32(values))
    });
    let channels: Vec<_> = channels.collect();
    let channels = AnyChannels::sort(channels.into());
    let mut image = Image::from_layer(Layer::new(size, LayerAttributes::named("a"), Encoding::UNCOMPRESSED, channels));
    image.layer_data.attributes.environment_map = Some(attribute::EnvironmentMap::Cube);
    written!(image)
}

#[test]
fn cube_maps_are_unfolded() {
    let unit = |[x, y, z]: [f64; 3]| {
        let length = (x * x + y * y + z * z).sqrt();
        [x, y, z].map(|component| component / length)
    };
    // Colours are directions, so that each texel says where it was in the cube.
    let side = 64;
    let bitmap = decoded(&cube(side, |direction| unit(direction).map(|component| 0.5 + 0.5 * component)));
    assert_eq!((bitmap.width as usize, bitmap.height as usize), (4 * side, 2 * side));
    let Texels::Rgb32F(texels) = &bitmap.texels else { panic!("floats") };
    for (i, texel) in texels.iter().enumerate() {
        let [column, row] = [i % (4 * side), i / (4 * side)].map(|pixel| pixel as f64 + 0.5);
        let (east, up) = ((column / (2 * side) as f64 - 1.0) * PI, (0.5 - row / (2 * side) as f64) * PI);
        let expected = [up.cos() * east.sin(), up.sin(), -up.cos() * east.cos()].map(|component| 0.5 + 0.5 * component);
        let error = (0..3).map(|c| (f64::from(texel[c]) - expected[c]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-3, "texel {i}: {texel:?}, not {expected:?}");
    }
    // A sun keeps its light: the sum over solid angles is that over the cube's.
    let toward = unit([1.0, 0.9, -0.8]);
    let cosine = |direction| (0..3).map(|c| unit(direction)[c] * toward[c]).sum::<f64>();
    let bitmap = decoded(&cube(side, |direction| [(400.0 * (cosine(direction) - 1.0)).exp(); 3]));
    let Texels::Rgb32F(texels) = &bitmap.texels else { panic!("floats") };
    let step = PI / (2 * side) as f64;
    let weight = |i: usize| ((i / (4 * side)) as f64 + 0.5) * step;
    let sum: f64 =
        texels.iter().enumerate().map(|(i, texel)| f64::from(texel[0]) * weight(i).sin() * step * step).sum();
    let expected = 2.0 * PI / 400.0;
    assert!((sum / expected - 1.0).abs() < 0.01, "{sum}, not {expected}");
}
