//! OpenEXR files.

use std::io;

use exr::block::BlockIndex;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::ChunksWriter;
use exr::image::write::layers::{LayersWriter, WritableLayers};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, LineOrder, Text, WritableImage,
};
use rayon::prelude::*;

use crate::pictures::aov::Values;
use crate::pictures::fingerprint;
use crate::pictures::image_file::Extras;
use crate::pictures::linear_image::Image;

/// Level of deflation. The library of OpenEXR files has 4, which takes five times as long for files that are a fortieth smaller:
/// the last bits of what was sampled are noise.
const LEVEL: u8 = 1;

/// Writes a picture with its layers and metadata, in 32 bits a channel.
pub(crate) fn write_exr(
    mean: &Image,
    extras: &Extras,
    fingerprint: Option<&str>,
    to: &mut io::Cursor<Vec<u8>>,
) -> io::Result<()> {
    let (width, height) = (mean.width as usize, mean.height as usize);
    let color = |i: usize| FlatSamples::F32(mean.pixels.iter().map(|pixel| pixel[i]).collect());
    let colors = ["R", "G", "B"].into_iter().enumerate().map(|(i, name)| AnyChannel::new(name, color(i)));
    let alpha = mean.alpha.iter().map(|alpha| AnyChannel::new("A", FlatSamples::F32(alpha.clone())));
    let others = extras.channels.iter().map(|channel| {
        let samples = match &channel.values {
            Values::F32(values) => FlatSamples::F32(values.clone()),
            Values::U32(values) => FlatSamples::U32(values.clone()),
        };
        AnyChannel::new(channel.name.as_str(), samples)
    });
    let channels = AnyChannels::sort(colors.chain(alpha).chain(others).collect());
    let mut image = exr::prelude::Image::from_channels((width, height), channels);
    let attributes = &mut image.layer_data.attributes;
    attributes.software_name = Some(concat!("raggio ", env!("CARGO_PKG_VERSION")).into());
    if let Some(metadata) = &extras.metadata {
        metadata.describe(attributes);
    }
    if let Some(fingerprint) = fingerprint {
        attributes.other.insert(Text::from(fingerprint::NAME), AttributeValue::Text(Text::from(fingerprint)));
    }
    image.layer_data.encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let headers = image.write().infer_meta_data();
    let layers = image.layer_data.create_writer(&headers);
    let written = exr::block::write(&mut *to, headers, true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        let compress = |(place, index): (usize, BlockIndex)| {
            let pixels = layers.extract_uncompressed_block(&meta.headers, index);
            let top = index.pixel_position.y();
            let block = CompressedScanLineBlock { y_coordinate: top as i32, compressed_pixels_le: compressed(pixels) };
            (place, Chunk { layer_index: index.layer, compressed_block: CompressedBlock::ScanLine(block) })
        };
        let chunks: Vec<_> = blocks.into_par_iter().map(compress).collect();
        chunks.into_iter().try_for_each(|(place, chunk)| writer.write_chunk(place, chunk))
    });
    written.map_err(io::Error::other)?;
    sort_attributes(to.get_mut());
    Ok(())
}

/// A block of pixels, of channels of 32 bits, as OpenEXR's ZIP compression has it: the even and the odd bytes apart, each as its
/// difference from the one before, and deflated. What would not become smaller stays as it is.
fn compressed(mut pixels: Vec<u8>) -> Vec<u8> {
    if cfg!(target_endian = "big") {
        pixels.chunks_exact_mut(4).for_each(<[u8]>::reverse);
    }
    let (even, odd) = (pixels.iter().step_by(2), pixels.iter().skip(1).step_by(2));
    let mut before = None;
    let difference = |byte: u8| {
        let before = before.replace(byte).map_or(0, |before: u8| before.wrapping_sub(128));
        byte.wrapping_sub(before)
    };
    let differences: Vec<u8> = even.chain(odd).copied().map(difference).collect();
    let deflated = miniz_oxide::deflate::compress_to_vec_zlib(&differences, LEVEL);
    if deflated.len() < pixels.len() { deflated } else { pixels }
}

/// Orders the attributes of an OpenEXR file of one part by their names: the library writes ours in another order each
/// time. Pixels stay where they are.
fn sort_attributes(file: &mut [u8]) {
    // Attributes begin after the magic number and the version; each has a name and a type that end with a zero, a
    // length and a value.
    const FIRST: usize = 8;
    let mut end = FIRST;
    let mut attributes = vec![];
    while file[end] != 0 {
        let start = end;
        for _ in 0..2 {
            end += file[end..].iter().take_while(|&&byte| byte != 0).count() + 1;
        }
        let length = u32::from_le_bytes([file[end], file[end + 1], file[end + 2], file[end + 3]]);
        end += 4 + length as usize;
        attributes.push(file[start..end].to_vec());
    }
    attributes.sort_unstable();
    file[FIRST..end].copy_from_slice(&attributes.concat());
}
