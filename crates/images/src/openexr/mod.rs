//! OpenEXR: the full resolution of the first layer with colour, the pixels of its data window.
//!
//! The library reads the header and decompresses blocks. What lies between - where blocks are, how large they may be -
//! is done here, because the library reserves what a file declares and ends the program where that is too much.

mod blocks;
mod layer;

use crate::bitmap::{Bitmap, Texels};
use crate::error::Problem;
use crate::format::Format;
use crate::limits::Limits;
use layer::Layer;

pub(crate) fn decode(bytes: &[u8], limits: &Limits) -> Result<Bitmap, Problem> {
    let layer = Layer::find(bytes, limits)?;
    let texels = Texels::Rgb32F(blocks::decode(&layer)?);
    // The limits have made sure that the sides fit.
    Ok(Bitmap { width: layer.width as u32, height: layer.height as u32, texels })
}

fn malformed(reason: impl std::fmt::Display) -> Problem {
    Problem::malformed(Format::Exr, reason)
}

fn unsupported(reason: impl std::fmt::Display) -> Problem {
    Problem::unsupported(Format::Exr, reason)
}

fn problem(error: exr::error::Error) -> Problem {
    match error {
        exr::error::Error::NotSupported(reason) => unsupported(reason),
        error => malformed(error),
    }
}
