//! EXT_meshopt_compression and KHR_meshopt_compression.
//!
//! The codecs are meshoptimizer's own, whose decoders are made for untrusted bytes; what they assume of sizes is
//! checked before.

use bytemuck::{Pod, Zeroable, cast_slice, pod_collect_to_vec};
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};

use super::document::data::{Meshopt, MeshoptFilter, MeshoptMode};

/// The decompressed bytes of `compressed`, whose sizes are checked.
pub(super) fn decode(compressed: &Meshopt, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let count = compressed.count;
    if count == 0 {
        return Ok(Vec::new());
    }
    let decoded = match (compressed.mode, compressed.byte_stride) {
        (MeshoptMode::Attributes, stride) => return attributes(stride, bytes, count, compressed.filter),
        (MeshoptMode::Triangles, 2) => {
            decode_index_buffer::<u16>(bytes, count).map(|indices| cast_slice(&indices).to_vec())
        }
        (MeshoptMode::Triangles, _) => {
            decode_index_buffer::<u32>(bytes, count).map(|indices| cast_slice(&indices).to_vec())
        }
        (MeshoptMode::Indices, 2) => {
            decode_index_sequence::<u16>(bytes, count).map(|indices| cast_slice(&indices).to_vec())
        }
        (MeshoptMode::Indices, _) => {
            decode_index_sequence::<u32>(bytes, count).map(|indices| cast_slice(&indices).to_vec())
        }
    };
    decoded.map_err(damaged)
}

fn damaged(error: meshopt::Error) -> String {
    format!("the compressed data is damaged: {error}")
}

/// An element of `4 * N` bytes; the decoder writes them as they lie in memory.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
struct Element<const N: usize>([u32; N]);

impl<const N: usize> Default for Element<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// Bytes of decoded elements. There are 64 of this function, so it does nothing that need not know the size.
fn elements<const N: usize>(bytes: &[u8], count: usize) -> Result<Vec<u8>, String> {
    Ok(cast_slice(&decode_vertex_buffer::<Element<N>>(bytes, count).map_err(damaged)?).to_vec())
}

/// Decoded attributes; `stride` is a multiple of 4 up to 256, and 4 or 8 where a filter asks for that.
fn attributes(stride: usize, bytes: &[u8], count: usize, filter: MeshoptFilter) -> Result<Vec<u8>, String> {
    use MeshoptFilter::{Color, Exponential, Octahedral, Quaternion};
    match (filter, stride) {
        (Octahedral, 4) => filtered::<i8>(bytes, count, decode_filter_oct),
        (Octahedral, _) => filtered::<i16>(bytes, count, decode_filter_oct),
        (Quaternion, _) => filtered::<i16>(bytes, count, decode_filter_quat),
        (Color, 4) => filtered::<i8>(bytes, count, decode_filter_color),
        (Color, _) => filtered::<i16>(bytes, count, decode_filter_color),
        (Exponential, _) => {
            let mut decoded = elements_of_stride(stride, bytes, count)?;
            // Each word has an exponent of its own, whatever the stride.
            let mut words: Vec<[u32; 1]> = pod_collect_to_vec(&decoded);
            decode_filter_exp(&mut words);
            decoded.copy_from_slice(cast_slice(&words));
            Ok(decoded)
        }
        (MeshoptFilter::None, _) => elements_of_stride(stride, bytes, count),
    }
}

fn filtered<T: Pod + Default>(bytes: &[u8], count: usize, filter: impl Fn(&mut [[T; 4]])) -> Result<Vec<u8>, String> {
    let mut vectors = decode_vertex_buffer::<[T; 4]>(bytes, count).map_err(damaged)?;
    filter(&mut vectors);
    Ok(cast_slice(&vectors).to_vec())
}

/// Calls `elements` for the stride: the size of an element is part of its type.
fn elements_of_stride(stride: usize, bytes: &[u8], count: usize) -> Result<Vec<u8>, String> {
    macro_rules! choose {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => elements::<$words>(bytes, count),)*
                _ => Err(format!("`byteStride` is {stride}: it should be 4 to 256")),
            }
        };
    }
    choose!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39
        40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}
