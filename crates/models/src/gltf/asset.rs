//! A checked document with its bytes, and typed reading of its accessors.

use std::borrow::Cow;
use std::collections::HashMap;

use super::container::Container;
use super::document::data::Kind;
use super::document::{Accessor, Buffer, Document};
use super::fault::{Budget, Warnings, at};
use super::resources::{Resources, fetch};
use super::{GltfOptions, mend, meshopt, validate};
use crate::error::Fault;

pub(super) struct Asset<'a> {
    pub document: Document,
    pub budget: Budget,
    pub warnings: Warnings,
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// Bytes of buffer views that were compressed, by the views' numbers.
    decompressed: HashMap<usize, Vec<u8>>,
}

impl<'a> Asset<'a> {
    /// Mends and checks the document and loads its buffers; memory is granted in proportion to `file_bytes` and theirs.
    pub(super) fn load(
        container: Container<'a>,
        warnings: Warnings,
        file_bytes: usize,
        resources: &dyn Resources,
        options: &GltfOptions,
    ) -> Result<Self, Fault> {
        let Container { mut document, binary } = container;
        mend::mend(&mut document, &warnings);
        validate::check(&document)?;
        let buffers = load_buffers(&document, binary, resources, options.most_bytes, &warnings)?;
        let loaded: usize = buffers.iter().flatten().map(|bytes| bytes.len()).sum();
        let budget = Budget::new(file_bytes.saturating_add(loaded) as u64, options.most_bytes);
        let mut asset = Self { document, budget, warnings, buffers, decompressed: HashMap::new() };
        asset.decompress()?;
        Ok(asset)
    }

    /// The asset with buffers of its own.
    pub(super) fn into_owned(self) -> Asset<'static> {
        let Self { document, budget, warnings, buffers, decompressed } = self;
        let buffers = buffers.into_iter().map(|bytes| bytes.map(|bytes| Cow::Owned(bytes.into_owned())));
        Asset { document, budget, warnings, buffers: buffers.collect(), decompressed }
    }

    fn decompress(&mut self) -> Result<(), Fault> {
        for (number, view) in self.document.buffer_views.iter().enumerate() {
            let Some(compressed) = &view.extensions.meshopt else { continue };
            let path = format!("bufferViews[{number}].extensions.KHR_meshopt_compression");
            let range = compressed.byte_offset..compressed.byte_offset + compressed.byte_length;
            let bytes = self.bytes(compressed.buffer, range, &path)?;
            // Decoders allocate once for the packed elements and once for the bytes.
            self.budget.take(compressed.count, 2 * compressed.byte_stride, &path)?;
            let decoded = meshopt::decode(compressed, bytes).map_err(|message| at(&path, message))?;
            self.decompressed.insert(number, decoded);
        }
        Ok(())
    }

    fn bytes(&self, buffer: usize, range: std::ops::Range<usize>, path: &str) -> Result<&[u8], Fault> {
        let bytes = self.buffers[buffer].as_deref();
        let bytes = bytes.ok_or_else(|| at(path, format!("buffer {buffer} should have data: it has no `uri`")))?;
        Ok(&bytes[range])
    }

    /// Bytes of a buffer view.
    pub(super) fn view(&self, number: usize, path: &str) -> Result<&[u8], Fault> {
        if let Some(bytes) = self.decompressed.get(&number) {
            return Ok(bytes);
        }
        let view = &self.document.buffer_views[number];
        self.bytes(view.buffer, view.byte_offset..view.byte_offset + view.byte_length, path)
    }

    pub(super) fn accessor(&self, number: usize) -> &Accessor {
        &self.document.accessors[number]
    }

    /// Elements of an accessor as vectors of `N` floats: all of them, or those numbered in `used`, which ascend.
    pub(super) fn floats<const N: usize>(
        &self,
        number: usize,
        used: Option<&[u32]>,
        normalized: bool,
        path: &str,
    ) -> Result<Vec<[f32; N]>, Fault> {
        let component = self.accessor(number).component_type;
        let bytes = self.gather(number, used, N, path)?;
        let mut values = vec![[0.0; N]; bytes.len() / (N * component.size())];
        let numbers = bytes.chunks_exact(component.size());
        values.as_flattened_mut().iter_mut().zip(numbers).for_each(|(value, bytes)| *value = component.float(bytes));
        let largest = component.largest();
        if normalized && largest != 1.0 {
            values.as_flattened_mut().iter_mut().for_each(|value| *value = (*value / largest).max(-1.0));
        }
        Ok(values)
    }

    /// Elements like those of [`Self::floats`], scaled as the accessor says.
    pub(super) fn floats_as_stored<const N: usize>(
        &self,
        number: usize,
        used: Option<&[u32]>,
        path: &str,
    ) -> Result<Vec<[f32; N]>, Fault> {
        self.floats(number, used, self.accessor(number).normalized, path)
    }

    /// Elements like those of [`Self::floats`], but as vectors of `N` unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        number: usize,
        used: Option<&[u32]>,
        path: &str,
    ) -> Result<Vec<[u32; N]>, Fault> {
        let component = self.accessor(number).component_type;
        if !component.is_unsigned() {
            return Err(at(path, format!("accessor {number} should have unsigned integers: it has {component:?}")));
        }
        let bytes = self.gather(number, used, N, path)?;
        let mut values = vec![[0; N]; bytes.len() / (N * component.size())];
        let numbers = bytes.chunks_exact(component.size());
        values.as_flattened_mut().iter_mut().zip(numbers).for_each(|(value, bytes)| *value = component.integer(bytes));
        Ok(values)
    }

    /// Bytes of the elements of an accessor, one after the other, each of `width` numbers.
    fn gather(&self, number: usize, used: Option<&[u32]>, width: usize, path: &str) -> Result<Vec<u8>, Fault> {
        let accessor = self.accessor(number);
        let (is, should) = (accessor.kind, kind_of_width(width));
        if is != should {
            return Err(at(path, format!("accessor {number} is {is:?}: it should be {should:?}")));
        }
        let count = used.map_or(accessor.count, <[u32]>::len);
        let size = accessor.kind.size(accessor.component_type);
        // There are these bytes, and then the numbers of them.
        self.budget.take(count, size + width * size_of::<u32>(), path)?;
        let mut elements = vec![0; count * size];
        if let Some(view) = accessor.buffer_view {
            let bytes = self.view(view, path)?.get(accessor.byte_offset..).unwrap_or_default();
            let stride = self.stride(accessor, view);
            for (i, element) in elements.chunks_exact_mut(size).enumerate() {
                let first = used.map_or(i, |used| used[i] as usize) * stride;
                element.copy_from_slice(&bytes[first..first + size]);
            }
        }
        self.replace_sparse(accessor, used, &mut elements, &format!("accessors[{number}].sparse"))?;
        Ok(elements)
    }

    fn replace_sparse(
        &self,
        accessor: &Accessor,
        used: Option<&[u32]>,
        elements: &mut [u8],
        path: &str,
    ) -> Result<(), Fault> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let indices = self.view(sparse.indices.buffer_view, path)?.get(sparse.indices.byte_offset..);
        let replacements = self.view(sparse.values.buffer_view, path)?.get(sparse.values.byte_offset..);
        let component = sparse.indices.component_type;
        let (indices, replacements) = (indices.unwrap_or_default(), replacements.unwrap_or_default());
        let size = accessor.kind.size(accessor.component_type);
        let mut least = 0;
        for k in 0..sparse.count {
            let index = component.integer(&indices[k * component.size()..]);
            if (index as usize) < least || index as usize >= accessor.count {
                let message = format!(
                    "index number {k} is {index}: the indices should increase and stay below {}",
                    accessor.count
                );
                return Err(at(format!("{path}.indices"), message));
            }
            least = index as usize + 1;
            let place = used.map_or(Some(index as usize), |used| used.binary_search(&index).ok());
            if let Some(place) = place {
                elements[place * size..][..size].copy_from_slice(&replacements[k * size..][..size]);
            }
        }
        Ok(())
    }

    fn stride(&self, accessor: &Accessor, view: usize) -> usize {
        let size = accessor.kind.size(accessor.component_type);
        self.document.buffer_views[view].byte_stride.unwrap_or(size)
    }
}

fn kind_of_width(width: usize) -> Kind {
    match width {
        1 => Kind::Scalar,
        2 => Kind::Vec2,
        3 => Kind::Vec3,
        4 => Kind::Vec4,
        _ => Kind::Mat4,
    }
}

fn load_buffers<'a>(
    document: &Document,
    binary: Option<&'a [u8]>,
    resources: &dyn Resources,
    most_bytes: u64,
    warnings: &Warnings,
) -> Result<Vec<Option<Cow<'a, [u8]>>>, Fault> {
    let mut left = most_bytes;
    let mut buffers = Vec::new();
    for (number, buffer) in document.buffers.iter().enumerate() {
        let binary = binary.filter(|_| number == 0);
        let bytes = load_buffer(buffer, binary, resources, left, warnings);
        let bytes = bytes.map_err(|message| at(format!("buffers[{number}]"), message))?;
        if let Some(Cow::Owned(bytes)) = &bytes {
            let too_much =
                || at(format!("buffers[{number}]"), format!("the buffers have more than {most_bytes} bytes"));
            left = left.checked_sub(bytes.len() as u64).ok_or_else(too_much)?;
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// Bytes of a buffer; none where only readers that cannot decompress would need them.
fn load_buffer<'a>(
    buffer: &Buffer,
    binary: Option<&'a [u8]>,
    resources: &dyn Resources,
    most_bytes: u64,
    warnings: &Warnings,
) -> Result<Option<Cow<'a, [u8]>>, String> {
    let bytes = match (&buffer.uri, binary) {
        _ if buffer.is_fallback() => return Ok(None),
        (Some(uri), _) => Cow::Owned(fetch(uri, resources, most_bytes, warnings)?),
        (None, Some(binary)) => Cow::Borrowed(binary),
        (None, None) => return Ok(None),
    };
    if bytes.len() < buffer.byte_length {
        return Err(format!(
            "should have {} bytes as `byteLength` says: there are {}",
            buffer.byte_length,
            bytes.len()
        ));
    }
    Ok(Some(bytes))
}
