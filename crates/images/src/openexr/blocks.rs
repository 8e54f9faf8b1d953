//! The blocks of an OpenEXR layer: found, decompressed and put into place, many at a time.

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::prelude::f16;
use rayon::prelude::*;

use super::colors::Kind;
use super::layer::{Channel, Layer};
use super::{chroma, malformed, problem, unsupported};
use crate::error::Problem;
use crate::format::Format;
use crate::guard::{caught, filled, joined};

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
    let blocks = caught(Format::Exr, || blocks.collect::<Result<Vec<_>, _>>())?;
    let mut pixels = filled(layer.width * layer.height, [0.0; 3])?;
    let bands = pixels.par_chunks_mut(layer.width * layer.block_height).zip(blocks.par_chunks(across));
    bands.try_for_each(|(band, blocks)| {
        blocks.iter().try_for_each(|block| {
            caught(Format::Exr, || {
                place(layer, &decompress(layer, block)?, block, band);
                Ok(())
            })
        })
    })?;
    finish(layer, &mut pixels);
    Ok(pixels)
}

/// Fills in what lies between samples, and makes colours of luminance and chroma.
fn finish(layer: &Layer<'_>, pixels: &mut [[f32; 3]]) {
    for channel in layer.channels.iter().filter(|channel| channel.sampling != [1, 1]) {
        for component in channel.components {
            chroma::fill_in(pixels, layer.width, *component, channel.sampling);
        }
    }
    if layer.kind == Kind::LuminanceChroma {
        pixels.par_iter_mut().for_each(|pixel| *pixel = chroma::rgb(*pixel, layer.weights));
    }
}

/// Compressed bytes of the block that begins at `offset`, which has to be the one at `column` and `row`.
fn find<'a>(layer: &Layer<'a>, offset: u64, column: usize, row: usize) -> Result<&'a [u8], Problem> {
    let bytes = usize::try_from(offset).ok().and_then(|offset| layer.file.get(offset..));
    let mut bytes = bytes.ok_or_else(|| malformed("a block lies behind its end"))?;
    let mut expect = |number: i64| match next(&mut bytes)? == number {
        true => Ok(()),
        false => Err(malformed("its table of blocks leads to the wrong ones")),
    };
    if let Some(number) = layer.number {
        expect(number as i64)?;
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
    let compressed_pixels_le = joined(&[block.data])?;
    let compressed_block = if layer.is_tiled() {
        let coordinates = TileCoordinates { tile_index: Vec2(block.column, block.row), level_index: Vec2(0, 0) };
        CompressedBlock::Tile(CompressedTileBlock { coordinates, compressed_pixels_le })
    } else {
        let y_coordinate = i32::try_from(line(layer, block.row)).map_err(malformed)?;
        CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate, compressed_pixels_le })
    };
    let chunk = Chunk { layer_index: 0, compressed_block };
    if !layer.is_subsampled() {
        return UncompressedBlock::decompress_chunk(chunk, &layer.meta, false).map_err(problem);
    }
    // The library multiplies pixels by the bytes of one: where some have fewer samples, the mean gives what it should.
    let (width, first, height) = extent(layer, block.column, block.row);
    let mut meta = layer.meta.clone();
    meta.headers[0].channels.bytes_per_pixel = layer.bytes(width, first, height) / (width * height);
    UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(problem)
}

/// Width of a block, its first line counted from the top of the image, and its height.
fn extent(layer: &Layer<'_>, column: usize, row: usize) -> (usize, usize, usize) {
    let width = layer.block_width.min(layer.width - column * layer.block_width);
    let first = row * layer.block_height;
    (width, first, layer.block_height.min(layer.height - first))
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
    let (width, first, height) = extent(layer, column, row);
    let bytes = layer.bytes(width, first, height);
    if !bytes.is_multiple_of(width * height) {
        return Err(unsupported("its channels have too different numbers of samples; write R, G and B in full"));
    }
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

/// Copies a block's samples into a row of blocks: each to the pixel at which it stands.
fn place(layer: &Layer<'_>, decompressed: &UncompressedBlock, block: &Block<'_>, band: &mut [[f32; 3]]) {
    let (width, first, height) = extent(layer, block.column, block.row);
    let left = block.column * layer.block_width;
    let mut data = &decompressed.data[..];
    for (line, row) in (first..first + height).zip(band.chunks_exact_mut(layer.width)) {
        let pixels = &mut row[left..left + width];
        for channel in &layer.channels {
            let [across, down] = channel.sampling;
            if line % down != 0 {
                continue;
            }
            let (samples, rest) = data.split_at(width / across * channel.kind.bytes_per_sample());
            data = rest;
            for component in channel.components {
                copy_channel(layer.kind, channel, samples, pixels, *component);
            }
        }
    }
}

fn copy_channel(kind: Kind, channel: &Channel, samples: &[u8], pixels: &mut [[f32; 3]], component: usize) {
    // Chroma may be negative.
    let least = if kind == Kind::LuminanceChroma { f32::MIN } else { 0.0 };
    let bounded =
        |value: f32, largest: f32| if value.is_nan() { 0.0 } else { value.clamp(least.max(-largest), largest) };
    let half = |bits: u16| bounded(f16::from_bits(bits).to_f32(), f16::MAX.to_f32());
    let across = channel.sampling[0];
    match channel.kind {
        SampleType::F16 => copy(samples, pixels, across, component, |bytes| half(u16::from_ne_bytes(bytes))),
        SampleType::F32 => {
            copy(samples, pixels, across, component, |bytes| bounded(f32::from_ne_bytes(bytes), f32::MAX))
        }
        SampleType::U32 => copy(samples, pixels, across, component, |bytes| u32::from_ne_bytes(bytes) as f32),
    }
}

fn copy<const N: usize>(
    samples: &[u8],
    pixels: &mut [[f32; 3]],
    across: usize,
    component: usize,
    value: impl Fn([u8; N]) -> f32,
) {
    for (sample, pixel) in samples.as_chunks().0.iter().zip(pixels.iter_mut().step_by(across)) {
        pixel[component] = value(*sample);
    }
}
