//! The body of a PLY file: numbers, one after the other.

use super::header::{Element, Encoding, Header, Property, Scalar};
use crate::error::{Fault, Place};
use crate::text::Words;

/// Reads numbers; every read is checked against the bytes that are left.
pub(super) struct Body<'a> {
    encoding: Encoding,
    words: Words<'a>,
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Body<'a> {
    pub(super) fn new(bytes: &'a [u8], header: &Header<'_>) -> Self {
        let words = Words::new(bytes, header.end, header.lines + 1);
        Self { encoding: header.encoding, words, bytes, position: header.end }
    }

    /// Number of rows of an element, checked to fit into the bytes that are left.
    pub(super) fn rows(&self, element: &Element<'_>) -> Result<usize, Fault> {
        let least = element.least_bytes(self.encoding);
        if least == 0 {
            return Ok(0);
        }
        // The last blank of an ascii file may be missing.
        let left = self.bytes_left() as u64 + u64::from(self.encoding == Encoding::Ascii);
        let fit = left / least;
        if element.count > fit {
            let name = crate::text::quoted(element.name);
            let count = element.count;
            let message = format!("declares {count} rows of {name}: the bytes left hold {fit} at most");
            return Err(Fault::line(element.line, message));
        }
        usize::try_from(element.count).map_err(|_| Fault::line(element.line, "declares too many rows"))
    }

    pub(super) fn skip(&mut self, element: &Element<'_>, rows: usize) -> Result<(), Fault> {
        if self.encoding != Encoding::Ascii && !element.has_lists() {
            // The product fits: `rows` has been checked against it.
            self.position += rows * element.least_bytes(self.encoding) as usize;
            return Ok(());
        }
        for _ in 0..rows {
            for property in &element.properties {
                self.skip_property(property)?;
            }
        }
        Ok(())
    }

    pub(super) fn skip_property(&mut self, property: &Property<'_>) -> Result<(), Fault> {
        let count = match property.length {
            Some(length) => self.list_length(length, property.value)?,
            None => 1,
        };
        if self.encoding == Encoding::Ascii {
            return (0..count).try_for_each(|_| self.number(property.value).map(drop));
        }
        self.take(count * property.value.bytes()).map(drop)
    }

    /// Length of a list, checked so that as many values fit into the bytes that are left.
    pub(super) fn list_length(&mut self, length: Scalar, value: Scalar) -> Result<usize, Fault> {
        let place = self.place();
        let count = self.number(length)?;
        let (left, each) = match self.encoding {
            Encoding::Ascii => (self.bytes_left() + 1, 2),
            _ => (self.bytes_left(), value.bytes()),
        };
        if count >= 0.0 && count.fract() == 0.0 && count <= (left / each) as f64 {
            return Ok(count as usize);
        }
        let most = left / each;
        Err(self.fault(place, format!("{count} should be the length of a list: the bytes left hold {most} at most")))
    }

    pub(super) fn index(&mut self, scalar: Scalar) -> Result<u32, Fault> {
        let place = self.place();
        let index = self.index_or_restart(scalar)?;
        index.ok_or_else(|| self.fault(place, "an index of a vertex should not be negative"))
    }

    /// The index of a vertex, or `None` for a negative number.
    pub(super) fn index_or_restart(&mut self, scalar: Scalar) -> Result<Option<u32>, Fault> {
        let place = self.place();
        let number = self.number(scalar)?;
        if number.fract() != 0.0 || number.is_nan() || number > f64::from(u32::MAX) {
            return Err(self.fault(place, format!("{number} should be the index of a vertex")));
        }
        Ok((number >= 0.0).then_some(number as u32))
    }

    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        match self.encoding {
            Encoding::Ascii => self.words.number(),
            Encoding::Little => Ok(little(self.take(scalar.bytes())?, scalar)),
            Encoding::Big => {
                let mut turned = [0; 8];
                let bytes = self.take(scalar.bytes())?;
                for (turned, byte) in turned.iter_mut().zip(bytes.iter().rev()) {
                    *turned = *byte;
                }
                Ok(little(&turned[..scalar.bytes()], scalar))
            }
        }
    }

    /// A part of a colour, full strength being 1.
    pub(super) fn strength(&mut self, scalar: Scalar) -> Result<f32, Fault> {
        Ok((self.number(scalar)? / scalar.full()) as f32)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.position..];
        let taken = rest.get(..count).ok_or_else(|| {
            let message = format!("the file ends: {count} bytes should follow, {} are left", rest.len());
            Fault::new(Place::Byte(self.position), message)
        })?;
        self.position += count;
        Ok(taken)
    }

    fn bytes_left(&self) -> usize {
        match self.encoding {
            Encoding::Ascii => self.words.bytes_left(),
            _ => self.bytes.len() - self.position,
        }
    }

    /// Place of the next number of a binary file; in ascii, [`Self::fault`] names the line of the last one instead.
    fn place(&self) -> Place {
        Place::Byte(self.position)
    }

    fn fault(&self, place: Place, message: impl Into<String>) -> Fault {
        match self.encoding {
            Encoding::Ascii => self.words.fault(message),
            _ => Fault::new(place, message),
        }
    }
}

/// The number in exactly as many bytes as the type has; zero for fewer, which does not happen.
fn little(bytes: &[u8], scalar: Scalar) -> f64 {
    fn chunk<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.first_chunk().copied().unwrap_or([0; N])
    }
    match scalar {
        Scalar::I8 => f64::from(i8::from_le_bytes(chunk(bytes))),
        Scalar::U8 => f64::from(u8::from_le_bytes(chunk(bytes))),
        Scalar::I16 => f64::from(i16::from_le_bytes(chunk(bytes))),
        Scalar::U16 => f64::from(u16::from_le_bytes(chunk(bytes))),
        Scalar::I32 => f64::from(i32::from_le_bytes(chunk(bytes))),
        Scalar::U32 => f64::from(u32::from_le_bytes(chunk(bytes))),
        Scalar::F32 => f64::from(f32::from_le_bytes(chunk(bytes))),
        Scalar::F64 => f64::from_le_bytes(chunk(bytes)),
    }
}
