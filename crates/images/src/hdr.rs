//! Radiance HDR.
//!
//! The header is read here: programs write several signatures, ends of lines and orders of pixels, of which the library
//! knows one each. It decodes the pixels, behind a header that it knows.

use std::io::Read;

use image::DynamicImage;
use image::codecs::hdr::HdrDecoder;

use crate::bitmap::{Bitmap, Texels};
use crate::error::Problem;
use crate::format::Format;
use crate::guard::{filled, grouped, radiance};
use crate::limits::Limits;
use crate::raster;

const FORMAT: &str = "32-bit_rle_rgbe";

pub(crate) fn decode(bytes: &[u8], limits: &Limits) -> Result<Bitmap, Problem> {
    let (size, pixels) = header(bytes)?;
    limits.check(size.width().into(), size.height().into(), size_of::<[f32; 3]>() as u64)?;
    let known = format!("#?RADIANCE\nFORMAT={FORMAT}\n\n-Y {} +X {}\n", size.lines, size.length);
    let failed = |error| raster::problem(Format::Hdr, error);
    let decoder = HdrDecoder::new(known.as_bytes().chain(pixels)).map_err(failed)?;
    let image = DynamicImage::from_decoder(decoder).map_err(failed)?;
    let mut texels: Vec<[f32; 3]> = grouped(image.into_rgb32f().into_raw())?;
    texels.as_flattened_mut().iter_mut().for_each(|value| *value = radiance(*value, f32::MAX));
    let texels = if size.is_usual() { texels } else { upright(&texels, &size)? };
    Ok(Bitmap { width: size.width(), height: size.height(), texels: Texels::Rgb32F(texels) })
}

/// Size of the image, and the bytes after the header, which ends with the line that says the size.
fn header(bytes: &[u8]) -> Result<(Size, &[u8]), Problem> {
    let mut rest = bytes;
    while let Some(end) = rest.iter().position(|byte| *byte == b'\n') {
        let line = String::from_utf8_lossy(&rest[..end]);
        rest = &rest[end + 1..];
        if let Some(size) = Size::parse(&line) {
            return Ok((size, rest));
        }
        match line.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("FORMAT", format)) if format != FORMAT => {
                return Err(Problem::unsupported(Format::Hdr, format!("its format is `{format}`; write `{FORMAT}`")));
            }
            _ => {}
        }
    }
    Err(Problem::malformed(Format::Hdr, "its header should end with a line that says its size, as in `-Y 3 +X 4`"))
}

/// Number of scan lines and of pixels in each, and where they go.
struct Size {
    lines: u32,
    length: u32,
    /// Direction from one line to the next, and from one pixel of a line to the next.
    directions: [Direction; 2],
}

#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Right,
    Left,
    Up,
    Down,
}

impl Direction {
    fn parse(word: &str) -> Option<Self> {
        match word {
            "+X" => Some(Self::Right),
            "-X" => Some(Self::Left),
            "+Y" => Some(Self::Up),
            "-Y" => Some(Self::Down),
            _ => None,
        }
    }

    fn is_across(self) -> bool {
        matches!(self, Self::Right | Self::Left)
    }
}

impl Size {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let mut next = || Some((Direction::parse(words.next()?)?, words.next()?.parse().ok()?));
        let ((outer, lines), (inner, length)) = (next()?, next()?);
        let fits = outer.is_across() != inner.is_across() && words.next().is_none();
        fits.then_some(Self { lines, length, directions: [outer, inner] })
    }

    fn is_usual(&self) -> bool {
        self.directions == [Direction::Down, Direction::Right]
    }

    fn width(&self) -> u32 {
        if self.directions[0].is_across() { self.lines } else { self.length }
    }

    fn height(&self) -> u32 {
        if self.directions[0].is_across() { self.length } else { self.lines }
    }
}

/// The texels row by row from the top left.
fn upright(texels: &[[f32; 3]], size: &Size) -> Result<Vec<[f32; 3]>, Problem> {
    let (width, height) = (size.width() as usize, size.height() as usize);
    let mut upright = filled(texels.len(), [0.0; 3])?;
    for (i, texel) in texels.iter().enumerate() {
        let (mut x, mut y) = (0, 0);
        for (direction, place) in size.directions.into_iter().zip([i / size.length as usize, i % size.length as usize])
        {
            match direction {
                Direction::Right => x = place,
                Direction::Left => x = width - 1 - place,
                Direction::Down => y = place,
                Direction::Up => y = height - 1 - place,
            }
        }
        upright[y * width + x] = *texel;
    }
    Ok(upright)
}
