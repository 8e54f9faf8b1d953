//! The blocks of an OpenEXR layer: found, decompressed and put into place, many at a time.

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::prelude::f16;
use rayon::prelude::*;

use super::layer::Layer;
use super::{malformed, problem};
use crate::error::Problem;
use crate::guard::{filled, radiance};

/// Number of integers in the header of a DWA block: version, nine sizes and counts, a method.
const DWA_HEADER_NUMBERS: usize = 11;

/// Highest ratio of DWA's compression: it stores two numbers for 64 equal pixels, then all are deflated.
const MOST_DWA_RATIO: usize = 1 << 17;
const MOST_RATIO: usize = 1 << 11;

/// A block in the file, still compressed.
struct Block<'a> {
    column: usize,
    row: usize,
    data: &'a [u8],
}

/// Pixels of the layer, row by row.
pub(super) fn decode(layer: &Layer<'_>) -> Result<Vec<[f32; 3]>, Problem> {
    let across = layer.width.div_ceil(layer.block_width);
    let blocks = layer.offsets.iter().enumerate().map(|(i, offset)| {
        let (column, row) = (i % across, i / across);
        Ok(Block { column, row, data: find(layer, u64::from_le_bytes(*offset), column, row)? })
    });
    let blocks = blocks.collect::<Result<Vec<_>, _>>()?;
    let mut pixels = filled(layer.width * layer.height, [0.0; 3])?;
    let bands = pixels.par_chunks_mut(layer.width * layer.block_height).zip(blocks.par_chunks(across));
    bands.try_for_each(|(band, blocks)| {
        blocks.iter().try_for_each(|block| {
            place(layer, &decompress(layer, block)?, block.column * layer.block_width, band);
            Ok(())
        })
    })?;
    Ok(pixels)
}

/// Compressed bytes of the block that begins at `offset`, which has to be the one at `column` and `row`.
fn find<'a>(layer: &Layer<'a>, offset: u64, column: usize, row: usize) -> Result<&'a [u8], Problem> {
    let bytes = usize::try_from(offset).ok().and_then(|offset| layer.file.get(offset..));
    let mut bytes = bytes.ok_or_else(|| malformed("a block lies behind its end"))?;
    let mut expect = |number: i64| match next(&mut bytes)? == number {
        true => Ok(()),
        false => Err(malformed("its table of blocks leads to the wrong ones")),
    };
    if layer.meta.requirements.has_multiple_layers {
        expect(layer.index as i64)?;
    }
    if layer.is_tiled() {
        [column as i64, row as i64, 0, 0].into_iter().try_for_each(&mut expect)?;
    } else {
        expect(line(layer, row))?;
    }
    let size = usize::try_from(next(&mut bytes)?).ok();
    let data = size.and_then(|size| bytes.get(..size)).ok_or_else(|| malformed("it ends within a block"))?;
    check(layer, data, column, row)?;
    Ok(data)
}

/// The first line of a row of blocks, as scan lines count them.
fn line(layer: &Layer<'_>, row: usize) -> i64 {
    i64::from(layer.header().own_attributes.layer_position.y()) + (row * layer.block_height) as i64
}

fn decompress(layer: &Layer<'_>, block: &Block<'_>) -> Result<UncompressedBlock, Problem> {
    let compressed_pixels_le = block.data.to_vec();
    let compressed_block = if layer.is_tiled() {
        let coordinates = TileCoordinates { tile_index: Vec2(block.column, block.row), level_index: Vec2(0, 0) };
        CompressedBlock::Tile(CompressedTileBlock { coordinates, compressed_pixels_le })
    } else {
        let y_coordinate = i32::try_from(line(layer, block.row)).map_err(malformed)?;
        CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate, compressed_pixels_le })
    };
    let chunk = Chunk { layer_index: layer.index, compressed_block };
    UncompressedBlock::decompress_chunk(chunk, &layer.meta, false).map_err(problem)
}

fn next(bytes: &mut &[u8]) -> Result<i64, Problem> {
    let (number, rest) = bytes.split_first_chunk().ok_or_else(|| malformed("it ends within a block"))?;
    *bytes = rest;
    Ok(i32::from_le_bytes(*number).into())
}

/// Checks whether so few bytes can hold a block. DWA's blocks also declare how large their parts are when decompressed,
/// which the library takes at their word: no part is larger than two bytes a byte of the pixels, with sides rounded up
/// to eight.
fn check(layer: &Layer<'_>, data: &[u8], column: usize, row: usize) -> Result<(), Problem> {
    let header = layer.header();
    let width = layer.block_width.min(layer.width - column * layer.block_width);
    let height = layer.block_height.min(layer.height - row * layer.block_height);
    let bytes = width * height * header.channels.bytes_per_pixel;
    let is_dwa = matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_));
    let most_ratio = if is_dwa { MOST_DWA_RATIO } else { MOST_RATIO };
    if data.len() < bytes / most_ratio {
        return Err(malformed(format!("{} bytes cannot hold a block of {width} x {height} pixels", data.len())));
    }
    // A block that did not get smaller is stored as it is, without these numbers.
    if !is_dwa || data.len() == bytes {
        return Ok(());
    }
    let pixels = width.next_multiple_of(8) * height.next_multiple_of(8);
    let most = (2 * pixels * header.channels.bytes_per_pixel) as u64;
    let (numbers, _) = data.as_chunks();
    let mut sizes = numbers.iter().take(DWA_HEADER_NUMBERS - 1).skip(1).map(|number| u64::from_le_bytes(*number));
    if sizes.all(|size| size <= most) { Ok(()) } else { Err(malformed("a block declares a size beyond its pixels")) }
}

/// Copies a block's colours into a row of blocks, where the block begins at pixel `left`.
fn place(layer: &Layer<'_>, block: &UncompressedBlock, left: usize, band: &mut [[f32; 3]]) {
    let width = block.index.pixel_size.width();
    let line_bytes = width * layer.header().channels.bytes_per_pixel;
    for (line, row) in block.data.chunks_exact(line_bytes).zip(band.chunks_exact_mut(layer.width)) {
        for (component, channel) in layer.channels.iter().enumerate() {
            let Some(channel) = channel else { continue };
            let samples = &line[width * channel.before..];
            let pixels = &mut row[left..left + width];
            match channel.kind {
                SampleType::F16 => copy(samples, pixels, component, |bytes| half(u16::from_ne_bytes(bytes))),
                SampleType::F32 => {
                    copy(samples, pixels, component, |bytes| radiance(f32::from_ne_bytes(bytes), f32::MAX))
                }
                SampleType::U32 => copy(samples, pixels, component, |bytes| u32::from_ne_bytes(bytes) as f32),
            }
        }
    }
}

fn half(bits: u16) -> f32 {
    radiance(f16::from_bits(bits).to_f32(), f16::MAX.to_f32())
}

fn copy<const N: usize>(samples: &[u8], pixels: &mut [[f32; 3]], component: usize, value: impl Fn([u8; N]) -> f32) {
    for (sample, pixel) in samples.as_chunks().0.iter().zip(pixels) {
        pixel[component] = value(*sample);
    }
}
