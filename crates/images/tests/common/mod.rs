//! Image files, made by the encoders of the formats' crates.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat};
use raggio_images::{Bitmap, Limits, decode};

pub fn decoded(bytes: &[u8]) -> Bitmap {
    decode(bytes, &Limits::default()).expect("a valid image")
}

pub fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.write_to(&mut file, format).expect("an image that can be written");
    file.into_inner()
}

/// A PNG file of `data`, which is laid out as stored before compression.
pub fn png(
    color: png::ColorType,
    depth: png::BitDepth,
    (width, height): (u32, u32),
    data: &[u8],
    set_up: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    set_up(&mut encoder);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(data)).expect("a PNG that can be written");
    file
}

/// A KTX2 file with one level; `format` is Vulkan's number, `model` the colour model and block size where it is 0.
pub fn ktx2(
    format: u32,
    scheme: u32,
    (width, height): (u32, u32),
    model: (u8, u8),
    uncompressed: u64,
    level: &[u8],
    orientation: &str,
) -> Vec<u8> {
    let mut description = vec![0, 0, 0, 0, 2, 0, 40, 0, model.0, 1, 1, 0];
    description.extend([model.1 - 1, model.1 - 1, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0]);
    // One sample: 128 bits, channel 3 of UASTC is RGBA.
    description.extend([0, 0, 127, 3, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255]);
    let description_bytes = description.len() as u32 + 4;
    let key_value = format!("KTXorientation\0{orientation}\0");
    let mut values = (key_value.len() as u32).to_le_bytes().to_vec();
    values.extend(key_value.bytes());
    let start = 104 + description_bytes as usize + values.len();
    let mut file = vec![0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];
    let header = [format, 1, width, height, 0, 0, 1, 1, scheme, 104, description_bytes];
    let index = [104 + description_bytes, values.len() as u32, 0, 0, 0, 0];
    file.extend(header.iter().chain(&index).flat_map(|number| number.to_le_bytes()));
    file.extend([start as u64, level.len() as u64, uncompressed].iter().flat_map(|number| number.to_le_bytes()));
    file.extend(description_bytes.to_le_bytes());
    file.extend(description);
    file.extend(values);
    file.extend(level);
    file
}

pub const ETC1S: &[u8] = include_bytes!("../data/etc1s.ktx2");
pub const UASTC: &[u8] = include_bytes!("../data/uastc.ktx2");
pub const UASTC_ZSTD: &[u8] = include_bytes!("../data/uastc-zstd.ktx2");
