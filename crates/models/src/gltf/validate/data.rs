//! Ranges of buffer views and accessors. No sum or product here may overflow unseen.

use super::{optional, reference};
use crate::error::Fault;
use crate::gltf::document::data::{Meshopt, MeshoptFilter, MeshoptMode, Sparse};
use crate::gltf::document::{Accessor, BufferView, Document};
use crate::gltf::fault::at;

pub(super) fn check(document: &Document) -> Result<(), Fault> {
    for (i, view) in document.buffer_views.iter().enumerate() {
        check_view(document, &format!("bufferViews[{i}]"), view)?;
    }
    for (i, accessor) in document.accessors.iter().enumerate() {
        check_accessor(document, &format!("accessors[{i}]"), accessor)?;
    }
    Ok(())
}

/// Checks that `count` elements of `size` bytes, `stride` apart from `offset` on, end within `available` bytes.
fn fits(path: &str, offset: usize, count: usize, stride: usize, size: usize, available: usize) -> Result<(), Fault> {
    let Some(last) = count.checked_sub(1) else { return Ok(()) };
    let end =
        last.checked_mul(stride).and_then(|start| start.checked_add(size)).and_then(|end| end.checked_add(offset));
    if end.is_some_and(|end| end <= available) {
        return Ok(());
    }
    let message = format!("{count} elements of {size} bytes, {stride} bytes apart from byte {offset} on, should end");
    Err(at(path, format!("{message} within the {available} bytes that there are")))
}

fn check_view(document: &Document, path: &str, view: &BufferView) -> Result<(), Fault> {
    reference(path, "buffer", view.buffer, document.buffers.len())?;
    fits(path, view.byte_offset, 1, 0, view.byte_length, document.buffers[view.buffer].byte_length)?;
    if let Some(compressed) = &view.extensions.meshopt {
        let path = format!("{path}.extensions.KHR_meshopt_compression");
        return check_compressed(document, &path, compressed, view.byte_length);
    }
    Ok(())
}

fn check_compressed(document: &Document, path: &str, compressed: &Meshopt, length: usize) -> Result<(), Fault> {
    let Meshopt { buffer, byte_offset, byte_length, byte_stride: stride, count, mode, filter } = *compressed;
    reference(path, "buffer", buffer, document.buffers.len())?;
    fits(path, byte_offset, 1, 0, byte_length, document.buffers[buffer].byte_length)?;
    if count.checked_mul(stride) != Some(length) {
        return Err(at(path, format!("`count` times `byteStride` should be the view's length of {length} bytes")));
    }
    let attributes = mode == MeshoptMode::Attributes;
    let stride_fits = match filter {
        _ if !attributes => matches!(stride, 2 | 4),
        MeshoptFilter::Octahedral | MeshoptFilter::Color => matches!(stride, 4 | 8),
        MeshoptFilter::Quaternion => stride == 8,
        MeshoptFilter::None | MeshoptFilter::Exponential => stride % 4 == 0 && (4..=256).contains(&stride),
    };
    let count_fits = mode != MeshoptMode::Triangles || count % 3 == 0;
    if stride_fits && count_fits && (attributes || filter == MeshoptFilter::None) {
        return Ok(());
    }
    let message = format!("mode {mode:?} and filter {filter:?} do not go with {count} elements of {stride} bytes");
    Err(at(path, format!("{message}: the sizes should be as the extension says")))
}

fn check_accessor(document: &Document, path: &str, accessor: &Accessor) -> Result<(), Fault> {
    let size = accessor.kind.size(accessor.component_type);
    optional(path, "bufferView", accessor.buffer_view, document.buffer_views.len())?;
    if let Some(view) = accessor.buffer_view {
        let view = &document.buffer_views[view];
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(at(path, format!("an element has {size} bytes: the view's `byteStride` is only {stride}")));
        }
        let extent = accessor.kind.extent(accessor.component_type);
        fits(path, accessor.byte_offset, accessor.count, stride, extent, view.byte_length)?;
    }
    if u32::try_from(accessor.count).is_err() {
        return Err(at(path, format!("has {} elements: at most {} can be used", accessor.count, u32::MAX)));
    }
    accessor.sparse.as_ref().map_or(Ok(()), |sparse| check_sparse(document, path, accessor, sparse))
}

fn check_sparse(document: &Document, path: &str, accessor: &Accessor, sparse: &Sparse) -> Result<(), Fault> {
    let path = format!("{path}.sparse");
    let (indices, values) = (&sparse.indices, &sparse.values);
    if sparse.count > accessor.count {
        return Err(at(path, format!("replaces {} elements: there are only {}", sparse.count, accessor.count)));
    }
    if !indices.component_type.is_unsigned() {
        return Err(at(path, "the indices should be unsigned integers"));
    }
    reference(&path, "indices.bufferView", indices.buffer_view, document.buffer_views.len())?;
    reference(&path, "values.bufferView", values.buffer_view, document.buffer_views.len())?;
    let available = |view: usize| document.buffer_views[view].byte_length;
    let size = indices.component_type.size();
    fits(&path, indices.byte_offset, sparse.count, size, size, available(indices.buffer_view))?;
    let size = accessor.kind.size(accessor.component_type);
    fits(&path, values.byte_offset, sparse.count, size, size, available(values.buffer_view))
}
