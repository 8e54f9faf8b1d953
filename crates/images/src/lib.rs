//! Images from files, as plain texels.
//!
//! Values stay as the file stores them: 8 and 16 bits stay what they are, and whether they are sRGB or linear is for
//! whoever uses them to say, because that is how materials say it.
//!
//! | format | what is read of it | texels |
//! |---|---|---|
//! | PNG | every kind; the first frame of an animation | 8 or 16 bits |
//! | JPEG | baseline and progressive; grey, RGB, CMYK | 8 bits |
//! | WebP | the first frame | 8 bits |
//! | BMP | every kind | 8 bits |
//! | TGA | with and without a palette or runs | 8 bits |
//! | TIFF | grey, RGB and CMYK of 8 or 16 bits, RGB of floats; the first page | 8 or 16 bits, or float |
//! | Radiance HDR | RGBE | float |
//! | OpenEXR | scan lines and tiles, the full resolution of one layer: RGB, luminance with or without chroma | float |
//! | KTX2 | Basis Universal, ASTC and uncompressed formats, the first level | 8 or 16 bits, or float |
//!
//! Colour profiles, gamma values and orientations beside the texels are not applied. Alpha of float images is dropped:
//! they light scenes, and nothing reads it. In float images, negative numbers and those that are none become 0, and
//! infinite ones the largest finite number of the file's type.
//!
//! Files come from anywhere, so none of their numbers is trusted: sizes are held against [`Limits`] and against the
//! bytes that are there before memory is reserved. Whatever the bytes, the answer is a [`Bitmap`] or an [`ImageError`].

mod bitmap;
mod error;
mod format;
mod guard;
mod hdr;
mod ktx;
mod limits;
mod load;
mod openexr;
mod raster;

pub use bitmap::{Bitmap, Texels};
pub use error::{ImageError, Problem};
pub use format::Format;
pub use guard::guarded;
pub use limits::Limits;
pub use load::{Image, decode, load};
