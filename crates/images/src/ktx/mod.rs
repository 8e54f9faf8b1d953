//! KTX2: the first level of a plain 2D texture, in Basis Universal, ASTC or an uncompressed format.
//!
//! Channels that a format lacks are 0, alpha is 1; that is what a GPU gives, and differs from a grey PNG.

mod basis;
mod plain;

use std::io::Read;

use ktx2::{Header, Reader, SupercompressionScheme};
use ruzstd::decoding::StreamingDecoder;

use crate::bitmap::{Bitmap, Texels};
use crate::error::Problem;
use crate::format::Format;
use crate::guard::joined;
use crate::limits::Limits;

pub(crate) fn decode(bytes: &[u8], limits: &Limits) -> Result<Bitmap, Problem> {
    let reader = Reader::new(bytes).map_err(malformed)?;
    let header = reader.header();
    let (width, height) = (header.pixel_width, header.pixel_height);
    if height == 0 || header.pixel_depth > 1 || header.layer_count > 1 || header.face_count != 1 {
        return Err(unsupported("it is an array, a cube map or not two-dimensional; write a plain 2D texture"));
    }
    let format = header.format.and_then(plain::Layout::of);
    let texel_bytes = format.as_ref().map_or(basis::MOST_TEXEL_BYTES, plain::Layout::texel_bytes);
    limits.check(width.into(), height.into(), texel_bytes)?;
    let texels = match format {
        Some(layout) => layout.texels(&level(&reader, layout.bytes(width, height))?)?,
        None => basis::texels(&reader)?,
    };
    let mut bitmap = Bitmap { width, height, texels };
    if begins_at_bottom(&reader) {
        flip(&mut bitmap);
    }
    Ok(bitmap)
}

fn malformed(reason: impl std::fmt::Display) -> Problem {
    Problem::malformed(Format::Ktx2, reason)
}

fn unsupported(reason: impl std::fmt::Display) -> Problem {
    Problem::unsupported(Format::Ktx2, reason)
}

/// The first `bytes` bytes of the first level, decompressed; a level with fewer is an error.
fn level(reader: &Reader<&[u8]>, bytes: usize) -> Result<Vec<u8>, Problem> {
    let data = first_level(reader)?;
    let short = |length: usize| malformed(format!("its first level has {length} bytes, it needs {bytes}"));
    match reader.header().supercompression_scheme {
        None => joined(&[data.get(..bytes).ok_or_else(|| short(data.len()))?]),
        Some(SupercompressionScheme::Zstandard) => {
            let decoder = StreamingDecoder::new(data).map_err(malformed)?;
            // The list grows with what is there, not with what the header declares.
            let mut level = Vec::new();
            decoder.take(bytes as u64).read_to_end(&mut level).map_err(malformed)?;
            if level.len() == bytes { Ok(level) } else { Err(short(level.len())) }
        }
        Some(_) => {
            Err(unsupported("its levels are not compressed with BasisLZ or Zstandard; `ktx deflate --zstd` does"))
        }
    }
}

fn first_level<'a>(reader: &'a Reader<&[u8]>) -> Result<&'a [u8], Problem> {
    reader.levels().next().map(|level| level.data).ok_or_else(|| malformed("it has no level"))
}

/// The bytes that the header's index names as the description of the format.
fn format_description<'a>(reader: &'a Reader<&[u8]>, header: &Header) -> Result<&'a [u8], Problem> {
    let start = header.index.dfd_byte_offset as usize;
    let end = start.saturating_add(header.index.dfd_byte_length as usize);
    reader.data().get(start..end).ok_or_else(|| malformed("its description of the format lies behind its end"))
}

/// Whether the first row is the bottom one; without `KTXorientation`, which is `rd` by default, rows go down.
fn begins_at_bottom(reader: &Reader<&[u8]>) -> bool {
    let orientation = reader.key_value_data().find(|(key, _)| *key == "KTXorientation");
    orientation.is_some_and(|(_, value)| value.get(1) == Some(&b'u'))
}

fn flip(bitmap: &mut Bitmap) {
    let width = bitmap.width as usize;
    match &mut bitmap.texels {
        Texels::Rgba8(texels) => flip_rows(texels, width),
        Texels::Rgba16(texels) => flip_rows(texels, width),
        Texels::Rgb32F(texels) => flip_rows(texels, width),
    }
}

fn flip_rows<T>(texels: &mut [T], width: usize) {
    let mut rows = texels.chunks_exact_mut(width);
    while let (Some(top), Some(bottom)) = (rows.next(), rows.next_back()) {
        top.swap_with_slice(bottom);
    }
}
