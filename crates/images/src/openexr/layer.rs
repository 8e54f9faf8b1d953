//! The header of an OpenEXR file, checked against the bytes behind it, and the layer that is read.

use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, EnvironmentMap, SampleType};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::meta::{BlockDescription, MetaData};

use super::colors::{self, Kind};
use super::cube::unfolded_size;
use super::{chroma, malformed, problem, unsupported};
use crate::error::Problem;
use crate::limits::Limits;

/// Fewest bytes of a block: an entry of eight bytes in the table and a header of eight bytes or more.
const LEAST_BLOCK_BYTES: u64 = 16;
/// Bytes of an entry of the table.
const OFFSET_BYTES: usize = 8;

/// The layer to read. Sizes are in pixels.
pub(super) struct Layer<'a> {
    pub(super) file: &'a [u8],
    /// The one header of this layer, with nothing in it but what blocks need.
    pub(super) meta: MetaData,
    /// Number that blocks of this layer begin with, where the file has several.
    pub(super) number: Option<usize>,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) block_width: usize,
    pub(super) block_height: usize,
    /// Meaning of the samples that are read.
    pub(super) kind: Kind,
    /// Parts of red, green and blue in luminance.
    pub(super) weights: [f32; 3],
    /// All channels of the layer, in the order in which a line of a block has them.
    pub(super) channels: Vec<Channel>,
    /// Offsets of its blocks in the file, row by row.
    pub(super) offsets: &'a [[u8; OFFSET_BYTES]],
    /// Whether the layer is six faces of a cube.
    pub(super) is_cube: bool,
    /// Sentence for the user, where the layer is one of several.
    pub(super) warning: Option<String>,
}

/// A channel of the layer.
pub(super) struct Channel {
    pub(super) kind: SampleType,
    /// Columns and rows from one sample to the next.
    pub(super) sampling: [usize; 2],
    /// Components of a pixel that take its samples; none where it is not read.
    pub(super) components: &'static [usize],
}

impl<'a> Layer<'a> {
    pub(super) fn find(file: &'a [u8], limits: &Limits) -> Result<Self, Problem> {
        let mut rest = file;
        let meta = MetaData::read_from_buffered(&mut rest, false).map_err(problem)?;
        check_block_count(&meta, rest.len())?;
        validate(&meta)?;
        let (group, warning) =
            colors::choose(&meta.headers).ok_or_else(|| unsupported("no layer has channels R, G and B, or Y"))?;
        let (index, kind) = (group.header, group.kind().unwrap_or(Kind::Rgb));
        let header = &meta.headers[index];
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let is_cube = header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
        let [wide, high] = if is_cube { unfolded_size(width, height)? } else { [width, height] };
        limits.check(wide as u64, high as u64, size_of::<[f32; 3]>() as u64)?;
        let block = header.max_block_pixel_size();
        let (block_width, block_height) = (block.width().min(width), block.height().min(height));
        check_blocks(header, block_width, block_height, limits)?;
        let listed = header.channels.list.iter().enumerate();
        let channel = |(place, channel): (usize, &ChannelDescription)| Channel {
            kind: channel.sample_type,
            sampling: [channel.sampling.x(), channel.sampling.y()],
            components: group.components(place),
        };
        let channels = listed.map(channel).collect();
        let before: usize = meta.headers[..index].iter().map(|header| header.chunk_count).sum();
        // The full resolution comes first where there are several.
        let count = width.div_ceil(block_width) * height.div_ceil(block_height);
        let (table, _) = rest.as_chunks::<OFFSET_BYTES>();
        let offsets = table.get(before..before + count).ok_or_else(|| malformed("its table of blocks is too short"))?;
        let weights = chroma::weights(header.shared_attributes.chromaticities);
        let number = meta.requirements.has_multiple_layers.then_some(index);
        let meta = MetaData { requirements: meta.requirements, headers: std::iter::once(bare(header)).collect() };
        Ok(Self {
            file,
            meta,
            number,
            width,
            height,
            block_width,
            block_height,
            kind,
            weights,
            channels,
            offsets,
            is_cube,
            warning,
        })
    }

    pub(super) fn header(&self) -> &Header {
        &self.meta.headers[0]
    }

    /// Whether a channel has fewer samples than there are pixels.
    pub(super) fn is_subsampled(&self) -> bool {
        self.channels.iter().any(|channel| channel.sampling != [1, 1])
    }

    /// Bytes of `height` lines from line `first` on, `width` pixels wide.
    pub(super) fn bytes(&self, width: usize, first: usize, height: usize) -> usize {
        let bytes = |channel: &Channel| {
            let [across, down] = channel.sampling;
            let lines = (first + height).div_ceil(down) - first.div_ceil(down);
            lines * (width / across) * channel.kind.bytes_per_sample()
        };
        self.channels.iter().map(bytes).sum()
    }

    pub(super) fn is_tiled(&self) -> bool {
        matches!(self.header().blocks, BlockDescription::Tiles(_))
    }
}

/// The header without attributes that blocks do not need, which may be long.
fn bare(header: &Header) -> Header {
    let layer_position = header.own_attributes.layer_position;
    Header {
        own_attributes: LayerAttributes { layer_position, ..LayerAttributes::default() },
        shared_attributes: ImageAttributes::new(header.shared_attributes.display_window),
        channels: header.channels.clone(),
        ..*header
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

/// Lets the library check the headers, but for channels with fewer samples than pixels: those it would refuse.
fn validate(meta: &MetaData) -> Result<(), Problem> {
    let mut headers = meta.headers.clone();
    for channel in headers.iter_mut().flat_map(|header| &mut header.channels.list) {
        channel.sampling = Vec2(1, 1);
    }
    MetaData::validate(&headers, false).map(|_| ()).map_err(problem)
}

fn check_blocks(header: &Header, width: usize, height: usize, limits: &Limits) -> Result<(), Problem> {
    header.channels.list.iter().try_for_each(|channel| check_sampling(header, channel))?;
    let bytes = (width as u64 * height as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
    if bytes <= limits.most_bytes {
        return Ok(());
    }
    Err(malformed(format!("a block of {width} x {height} pixels takes more than {} bytes", limits.most_bytes)))
}

/// Checks that samples stand one or two pixels apart, begin with the first pixel and fill the image.
fn check_sampling(header: &Header, channel: &ChannelDescription) -> Result<(), Problem> {
    let Vec2(across, down) = channel.sampling;
    if (across, down) == (1, 1) {
        return Ok(());
    }
    let is_known = matches!((across, down), (1 | 2, 1 | 2)) && !matches!(header.blocks, BlockDescription::Tiles(_));
    if !is_known || matches!(header.compression, Compression::B44 | Compression::B44A) {
        let right = "write all channels in full, or chroma at every second pixel of scan lines, not in B44";
        return Err(unsupported(format!("a channel has a sample for {across} x {down} pixels; {right}")));
    }
    let Vec2(x, y) = header.own_attributes.layer_position;
    let begins = x.rem_euclid(across as i32) == 0 && y.rem_euclid(down as i32) == 0;
    let Vec2(width, height) = header.layer_size;
    if begins && width.is_multiple_of(across) && height.is_multiple_of(down) {
        return Ok(());
    }
    Err(malformed("the samples of a channel do not fit its image"))
}
