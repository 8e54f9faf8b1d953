//! OpenEXR: the full resolution of one layer with colour, the pixels of its data window; cube maps unfolded.
//!
//! The library reads the header and decompresses blocks. What lies between - where blocks are, how large they may be -
//! is done here, because the library reserves what a file declares and ends the program where that is too much; so are
//! channels with fewer samples than pixels, which it does not know.

mod blocks;
mod chroma;
mod colors;
mod cube;
mod layer;

use crate::bitmap::{Bitmap, Texels};
use crate::error::Problem;
use crate::format::Format;
use crate::guard::caught;
use crate::limits::Limits;
use crate::load::Image;
use layer::Layer;

pub(crate) fn decode(bytes: &[u8], limits: &Limits) -> Result<Image, Problem> {
    let mut layer = caught(Format::Exr, || Layer::find(bytes, limits))?;
    let warnings = layer.warning.take().into_iter().collect();
    let mut texels = blocks::decode(&layer)?;
    let [mut width, mut height] = [layer.width, layer.height];
    if layer.is_cube {
        texels = cube::unfolded(width, &texels);
        [width, height] = cube::unfolded_size(width, height)?;
    }
    // The limits have made sure that the sides fit.
    let bitmap = Bitmap { width: width as u32, height: height as u32, texels: Texels::Rgb32F(texels) };
    Ok(Image { bitmap, warnings })
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
