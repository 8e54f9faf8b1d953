//! Places of numbers: buffers, views, accessors.

use serde::{Deserialize, Deserializer};

use super::code;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Buffer {
    pub byte_length: usize,
    pub uri: Option<String>,
    #[serde(default)]
    pub extensions: BufferExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(in crate::gltf) struct BufferExtensions {
    #[serde(rename = "KHR_meshopt_compression", alias = "EXT_meshopt_compression")]
    pub meshopt: Option<Fallback>,
}

#[derive(Deserialize)]
pub(in crate::gltf) struct Fallback {
    #[serde(default)]
    pub fallback: bool,
}

impl Buffer {
    /// Whether only readers that cannot decompress need it.
    pub(in crate::gltf) fn is_fallback(&self) -> bool {
        self.extensions.meshopt.as_ref().is_some_and(|meshopt| meshopt.fallback)
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(in crate::gltf) struct ViewExtensions {
    /// Compression by either of two extensions, which give one meaning to equal names.
    #[serde(rename = "KHR_meshopt_compression", alias = "EXT_meshopt_compression")]
    pub meshopt: Option<Box<Meshopt>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Meshopt {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: MeshoptMode,
    #[serde(default)]
    pub filter: MeshoptFilter,
}

#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum MeshoptMode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Deserialize, Clone, Copy, Debug, Default, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum MeshoptFilter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: Component,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: Kind,
    pub sparse: Option<Box<Sparse>>,
}

/// Elements that replace some of an accessor's.
#[derive(Deserialize)]
pub(in crate::gltf) struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: Component,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

/// The type of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::gltf) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl TryFrom<u32> for Component {
    type Error = String;

    fn try_from(code: u32) -> Result<Self, String> {
        match code {
            5120 => Ok(Self::I8),
            5121 => Ok(Self::U8),
            5122 => Ok(Self::I16),
            5123 => Ok(Self::U16),
            5125 => Ok(Self::U32),
            5126 => Ok(Self::F32),
            _ => Err(format!("the component type is {code}: it should be 5120, 5121, 5122, 5123, 5125 or 5126")),
        }
    }
}

impl<'de> Deserialize<'de> for Component {
    fn deserialize<D: Deserializer<'de>>(reader: D) -> Result<Self, D::Error> {
        code::read(reader)
    }
}

impl Component {
    /// Size in bytes.
    pub(in crate::gltf) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    pub(in crate::gltf) fn is_unsigned(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// Number by which a normalized integer is divided.
    pub(in crate::gltf) fn largest(self) -> f32 {
        match self {
            Self::I8 => f32::from(i8::MAX),
            Self::U8 => f32::from(u8::MAX),
            Self::I16 => f32::from(i16::MAX),
            Self::U16 => f32::from(u16::MAX),
            Self::U32 => u32::MAX as f32,
            Self::F32 => 1.0,
        }
    }

    /// Value of the first number of this type in `bytes`, little-endian, which hold at least one.
    pub(in crate::gltf) fn float(self, bytes: &[u8]) -> f32 {
        match self {
            Self::I8 => f32::from(bytes[0] as i8),
            Self::I16 => f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            Self::U8 | Self::U16 | Self::U32 => self.integer(bytes) as f32,
        }
    }

    /// Value of the first number of this unsigned type in `bytes`, little-endian, which hold at least one.
    pub(in crate::gltf) fn integer(self, bytes: &[u8]) -> u32 {
        match self.size() {
            1 => u32::from(bytes[0]),
            2 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }
}

/// The shape of one element.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum Kind {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Kind {
    /// Number of components of a vector, or of each column of a matrix.
    fn rows(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 | Self::Mat2 => 2,
            Self::Vec3 | Self::Mat3 => 3,
            Self::Vec4 | Self::Mat4 => 4,
        }
    }

    fn is_matrix(self) -> bool {
        matches!(self, Self::Mat2 | Self::Mat3 | Self::Mat4)
    }

    /// Number of components of an element.
    pub(in crate::gltf) fn width(self) -> usize {
        if self.is_matrix() { self.rows() * self.rows() } else { self.rows() }
    }

    /// Bytes from one tightly packed element to the next; columns of matrices begin at multiples of four.
    pub(in crate::gltf) fn size(self, component: Component) -> usize {
        let column = self.rows() * component.size();
        if self.is_matrix() { self.rows() * column.next_multiple_of(4) } else { column }
    }

    /// Bytes of an element, without those that pad a matrix's last column.
    pub(in crate::gltf) fn extent(self, component: Component) -> usize {
        let column = self.rows() * component.size();
        self.size(component) - if self.is_matrix() { column.next_multiple_of(4) - column } else { 0 }
    }
}
