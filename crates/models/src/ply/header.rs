//! The header of a PLY file, which says what its body holds.

use crate::error::{Fault, Place};
use crate::text::quoted;

/// Storage of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Value of a colour of full strength.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// A column of an element.
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    /// The type of the length, for lists.
    pub(super) length: Option<Scalar>,
    pub(super) value: Scalar,
}

/// A table of the body.
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
    /// The line that declares it.
    pub(super) line: usize,
}

impl Element<'_> {
    /// The fewest bytes that a row can have.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let bytes = |property: &Property<'_>| match encoding {
            // A digit and a blank; the last blank of the file may be missing, which the caller allows for.
            Encoding::Ascii => 2,
            _ => property.length.unwrap_or(property.value).bytes() as u64,
        };
        self.properties.iter().map(bytes).sum()
    }

    pub(super) fn has_lists(&self) -> bool {
        self.properties.iter().any(|property| property.length.is_some())
    }
}

/// Contents of the header.
pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'a>>,
    /// Offset in bytes at which the body begins.
    pub(super) end: usize,
    /// The number of lines before the body.
    pub(super) lines: usize,
    /// Names of textures given in comments, as MeshLab writes them.
    pub(super) textures: Vec<&'a [u8]>,
}

/// Lines of the header. They end as the first one does, or a binary body that begins with a line feed would lose it.
struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
    number: usize,
    ending: &'static [u8],
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.position..];
        let length = rest.windows(self.ending.len()).position(|window| window == self.ending);
        let message = "the header has no end: `end_header` on a line of its own ends it";
        let length = length.ok_or_else(|| Fault::line(self.number + 1, message))?;
        self.position += length + self.ending.len();
        self.number += 1;
        Ok(&rest[..length])
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Header<'_>, Fault> {
    let ending: &[u8] = match bytes {
        [b'p', b'l', b'y', b'\r', b'\n', ..] => b"\r\n",
        [b'p', b'l', b'y', b'\r', ..] => b"\r",
        [b'p', b'l', b'y', ..] => b"\n",
        _ => return Err(Fault::line(1, "is not a PLY file: one begins with a line `ply`")),
    };
    let mut lines = Lines { bytes, position: 0, number: 0, ending };
    lines.next()?;
    let (mut encoding, mut elements, mut textures) = (None, Vec::<Element<'_>>::new(), Vec::new());
    loop {
        let text = lines.next()?;
        let fault = |message: String| Fault::new(Place::Line(lines.number), message);
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let words: [_; 6] = std::array::from_fn(|_| words.next());
        match words {
            [Some(b"comment"), Some(b"TextureFile"), Some(_), ..] => textures.push(after_second_word(text)),
            [None, ..] | [Some(b"comment" | b"obj_info"), ..] => {}
            [Some(b"end_header"), ..] => break,
            [Some(b"format"), Some(kind), ..] => encoding = Some(format(kind).map_err(fault)?),
            [Some(b"element"), Some(name), Some(count), None, ..] => {
                let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                let count = count.ok_or_else(|| fault("the count of an element should be a whole number".into()))?;
                if elements.iter().any(|element| element.name == name) {
                    return Err(fault(format!("there are two elements {}: one is allowed", quoted(name))));
                }
                elements.push(Element { name, count, properties: Vec::new(), line: lines.number });
            }
            [Some(b"property"), ..] => {
                let element = elements.last_mut().ok_or_else(|| fault("a property comes after its element".into()))?;
                element.properties.push(property(words).map_err(fault)?);
            }
            _ => return Err(fault(format!("{} is not a line of a PLY header", quoted(text)))),
        }
    }
    let encoding = encoding.ok_or_else(|| Fault::whole("the header should have a line `format ascii 1.0` or alike"))?;
    Ok(Header { encoding, elements, end: lines.position, lines: lines.number, textures })
}

/// Text after the second word, such as the name of a file, which may have blanks.
fn after_second_word(text: &[u8]) -> &[u8] {
    let after_word = |text: &'_ [u8]| text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    let text = text[after_word(text)..].trim_ascii();
    text[after_word(text)..].trim_ascii()
}

fn format(kind: &[u8]) -> Result<Encoding, String> {
    match kind {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => {
            let right = "`ascii`, `binary_little_endian` or `binary_big_endian`";
            Err(format!("the format {} should be {right}", quoted(kind)))
        }
    }
}

fn property<'a>(words: [Option<&'a [u8]>; 6]) -> Result<Property<'a>, String> {
    let scalar = |name: &[u8]| Scalar::named(name).ok_or_else(|| format!("{} is not a type of PLY", quoted(name)));
    match words {
        [_, Some(b"list"), Some(length), Some(value), Some(name), None] => {
            let length = scalar(length)?;
            if !length.is_integer() {
                return Err("the length of a list should have an integer type".to_string());
            }
            Ok(Property { name, length: Some(length), value: scalar(value)? })
        }
        [_, Some(value), Some(name), None, ..] => Ok(Property { name, length: None, value: scalar(value)? }),
        _ => Err("a property should be `property TYPE NAME` or `property list TYPE TYPE NAME`".to_string()),
    }
}
