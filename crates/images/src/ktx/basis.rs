//! Basis Universal (ETC1S and UASTC) and ASTC, to plain texels.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use exr::prelude::f16;
use ktx2::{ColorModel, Header, Reader, SupercompressionScheme};

use super::{first_level, format_description, level, malformed, unsupported};
use crate::bitmap::Texels;
use crate::error::Problem;
use crate::guard::{collected, grouped, joined, radiance};

/// Most bytes that a texel takes in memory while it is decoded.
pub(super) const MOST_TEXEL_BYTES: u64 = 16;

const LEVEL_INDEX_BYTES: usize = 24;
/// Bytes of a block, in UASTC and in ASTC.
const BLOCK_BYTES: usize = 16;
/// Bytes at the start of BasisLZ's global data: counts and lengths. Flags and slices of each image follow.
const GLOBAL_HEADER_BYTES: usize = 20;
const IMAGE_BYTES: usize = 20;

pub(super) fn texels(reader: &Reader<&[u8]>) -> Result<Texels, Problem> {
    let file = first_level_alone(reader)?;
    let transcoder = Transcoder::new(&file).map_err(|error| malformed(format!("{error:?}")))?;
    let is_float = !transcoder.supports(TargetFormat::Rgba32);
    let target = if is_float { TargetFormat::RgbaHalf } else { TargetFormat::Rgba32 };
    let bytes = transcoder.transcode(0, target, DecodeFlags::NONE).map_err(|error| malformed(format!("{error:?}")))?;
    if !is_float {
        return Ok(Texels::Rgba8(grouped(bytes)?));
    }
    let value = |bits: [u8; 2]| radiance(f16::from_bits(u16::from_le_bytes(bits)).to_f32(), f16::MAX.to_f32());
    let (halves, _) = bytes.as_chunks();
    let (texels, _) = halves.as_chunks();
    Ok(Texels::Rgb32F(collected(texels.iter().map(|[r, g, b, _]| [value(*r), value(*g), value(*b)]))?))
}

/// A copy of the texture with one level, decompressed, and nothing else: the transcoder adds up offsets of the file
/// without checking them, and here all of them are right.
fn first_level_alone(reader: &Reader<&[u8]>) -> Result<Vec<u8>, Problem> {
    let header = reader.header();
    let description = format_description(reader, &header)?;
    let is_lz = header.supercompression_scheme == Some(SupercompressionScheme::BasisLZ);
    let (level, global) = if is_lz {
        (joined(&[first_level(reader)?])?, first_image_alone(reader, &header)?)
    } else {
        (level(reader, level_bytes(reader, &header)?)?, Vec::new())
    };
    let description_start = Header::LENGTH + LEVEL_INDEX_BYTES;
    let global_start = description_start + description.len();
    let level_start = global_start + global.len();
    let mut alone = header;
    alone.level_count = 1;
    alone.layer_count = 0;
    alone.pixel_depth = 0;
    alone.supercompression_scheme = is_lz.then_some(SupercompressionScheme::BasisLZ);
    alone.index.dfd_byte_offset = description_start as u32;
    (alone.index.kvd_byte_offset, alone.index.kvd_byte_length) = (0, 0);
    (alone.index.sgd_byte_offset, alone.index.sgd_byte_length) = (global_start as u64, global.len() as u64);
    let uncompressed = if is_lz { 0 } else { level.len() as u64 };
    let index = [level_start as u64, level.len() as u64, uncompressed].map(u64::to_le_bytes);
    joined(&[&alone.as_bytes(), index.as_flattened(), description, &global, &level])
}

/// BasisLZ's global data without the images of other levels.
fn first_image_alone(reader: &Reader<&[u8]>, header: &Header) -> Result<Vec<u8>, Problem> {
    let global = reader.supercompression_global_data();
    let images = (header.level_count.max(1) as usize).saturating_mul(IMAGE_BYTES);
    let first = global.get(..GLOBAL_HEADER_BYTES + IMAGE_BYTES);
    let rest = global.get(GLOBAL_HEADER_BYTES.saturating_add(images)..);
    let parts = first.zip(rest).ok_or_else(|| malformed("its global data is too short for its levels"))?;
    joined(&[parts.0, parts.1])
}

/// Bytes of the first level when decompressed.
fn level_bytes(reader: &Reader<&[u8]>, header: &Header) -> Result<usize, Problem> {
    let basic = reader.basic_dfd().ok_or_else(|| malformed("it does not describe its format"))?;
    let model = basic.color_model;
    if model != Some(ColorModel::UASTC) && model != Some(ColorModel::ASTC) {
        let right = "write Basis Universal (ETC1S or UASTC) or an uncompressed format, as `ktx create` does";
        return Err(unsupported(format!("its format is not one of those that are; {right}")));
    }
    let [width, height, ..] = basic.texel_block_dimensions.map(|side| u32::from(side.get()));
    let blocks = header.pixel_width.div_ceil(width) as usize * header.pixel_height.div_ceil(height) as usize;
    Ok(blocks * BLOCK_BYTES)
}
