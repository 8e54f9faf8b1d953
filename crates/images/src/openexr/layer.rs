//! The header of an OpenEXR file, checked against the bytes behind it, and the layer that is read.

use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use super::{malformed, problem, unsupported};
use crate::error::Problem;
use crate::limits::Limits;

/// Fewest bytes of a block: an entry of eight bytes in the table and a header of eight bytes or more.
const LEAST_BLOCK_BYTES: u64 = 16;
/// Bytes of an entry of the table.
const OFFSET_BYTES: usize = 8;

/// The layer to read. Sizes are in pixels.
pub(super) struct Layer<'a> {
    pub(super) file: &'a [u8],
    pub(super) meta: MetaData,
    /// Index of this layer's header among the headers.
    pub(super) index: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) block_width: usize,
    pub(super) block_height: usize,
    /// Channels of red, green and blue; `None` is zero.
    pub(super) channels: [Option<Channel>; 3],
    /// Offsets of its blocks in the file, row by row.
    pub(super) offsets: &'a [[u8; OFFSET_BYTES]],
}

/// Place of a channel among the bytes of a block.
#[derive(Clone, Copy)]
pub(super) struct Channel {
    /// Bytes per pixel of the channels before it.
    pub(super) before: usize,
    pub(super) kind: SampleType,
}

impl<'a> Layer<'a> {
    pub(super) fn find(file: &'a [u8], limits: &Limits) -> Result<Self, Problem> {
        let mut rest = file;
        let meta = MetaData::read_from_buffered(&mut rest, false).map_err(problem)?;
        check_block_count(&meta, rest.len())?;
        MetaData::validate(&meta.headers, false).map_err(problem)?;
        let colors = meta.headers.iter().map(|header| color_channels(&header.channels.list));
        let (index, channels) = colors
            .enumerate()
            .find_map(|(index, channels)| Some((index, channels?)))
            .ok_or_else(|| unsupported("no layer has channels R, G and B, or Y"))?;
        let header = &meta.headers[index];
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        limits.check(width as u64, height as u64, size_of::<[f32; 3]>() as u64)?;
        let block = header.max_block_pixel_size();
        let (block_width, block_height) = (block.width().min(width), block.height().min(height));
        check_blocks(header, block_width, block_height, limits)?;
        let before: usize = meta.headers[..index].iter().map(|header| header.chunk_count).sum();
        // The full resolution comes first where there are several.
        let count = width.div_ceil(block_width) * height.div_ceil(block_height);
        let (table, _) = rest.as_chunks::<OFFSET_BYTES>();
        let offsets = table.get(before..before + count).ok_or_else(|| malformed("its table of blocks is too short"))?;
        Ok(Self { file, index, width, height, block_width, block_height, channels, offsets, meta })
    }

    pub(super) fn header(&self) -> &Header {
        &self.meta.headers[self.index]
    }

    pub(super) fn is_tiled(&self) -> bool {
        matches!(self.header().blocks, BlockDescription::Tiles(_))
    }
}

/// Checks that the bytes left can hold as many blocks as the headers declare.
fn check_block_count(meta: &MetaData, bytes_left: usize) -> Result<(), Problem> {
    let count = meta.headers.iter().fold(0, |count: u64, header| count.saturating_add(header.chunk_count as u64));
    if count.saturating_mul(LEAST_BLOCK_BYTES) <= bytes_left as u64 {
        return Ok(());
    }
    Err(malformed(format!("{bytes_left} bytes cannot hold the {count} blocks that it declares")))
}

fn check_blocks(header: &Header, width: usize, height: usize, limits: &Limits) -> Result<(), Problem> {
    if header.channels.list.iter().any(|channel| (channel.sampling.x(), channel.sampling.y()) != (1, 1)) {
        return Err(unsupported("a channel has fewer samples than there are pixels; write R, G and B in full"));
    }
    let bytes = (width as u64 * height as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
    if bytes <= limits.most_bytes {
        return Ok(());
    }
    Err(malformed(format!("a block of {width} x {height} pixels takes more than {} bytes", limits.most_bytes)))
}

/// Channels that share a name up to the last dot, those without a dot first: red, green and blue, or else luminance.
fn color_channels(list: &[ChannelDescription]) -> Option<[Option<Channel>; 3]> {
    let mut groups: Vec<(String, [Option<Channel>; 4])> = Vec::new();
    let mut before = 0;
    for channel in list {
        let name = channel.name.to_string();
        let (prefix, last) = name.rsplit_once('.').unwrap_or(("", &name));
        if let Some(component) = component(last) {
            let found = groups.iter().position(|group| group.0 == prefix);
            let group = found.unwrap_or_else(|| {
                groups.push((prefix.to_string(), [None; 4]));
                groups.len() - 1
            });
            groups[group].1[component] = Some(Channel { before, kind: channel.sample_type });
        }
        before += channel.sample_type.bytes_per_sample();
    }
    let group = groups.iter().find(|group| group.0.is_empty()).or(groups.first())?;
    let [r, g, b, luminance] = group.1;
    Some(if r.or(g).or(b).is_some() { [r, g, b] } else { [luminance; 3] })
}

fn component(name: &str) -> Option<usize> {
    match name.to_ascii_lowercase().as_str() {
        "r" | "red" => Some(0),
        "g" | "green" => Some(1),
        "b" | "blue" => Some(2),
        "y" => Some(3),
        _ => None,
    }
}
