//! PNGs of 8 and of 16 bits.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Encoder, Filter, SrgbRenderingIntent};
use raggio_choice::choice;

choice! {
    /// Bits of each channel of a PNG.
    pub enum PngBits: "number of bits" {
        /// 256 steps from black to white, as displays have them
        Eight = "8",
        /// 65536 steps, for those who change the picture afterwards
        Sixteen = "16",
    }
}

/// Text that a PNG has beside its picture: a name and what it says.
pub(crate) type PngText<'a> = (&'static str, &'a str);

/// Writes a PNG of 8 bits: bytes red, green, blue, opacity, row by row from the top left. Opacity is left out.
pub(crate) fn encode_8_bits(
    size: [u32; 2],
    pixels: &[u8],
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    let rgb: Vec<u8> = pixels.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    encode(size, BitDepth::Eight, &rgb, text, to)
}

/// Writes a PNG of 16 bits: red, green, blue, row by row from the top left.
pub(crate) fn encode_16_bits(
    size: [u32; 2],
    pixels: &[[u16; 3]],
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    let rgb: Vec<u8> = pixels.as_flattened().iter().flat_map(|value| value.to_be_bytes()).collect();
    encode(size, BitDepth::Sixteen, &rgb, text, to)
}

fn encode(
    [width, height]: [u32; 2],
    depth: BitDepth,
    rgb: &[u8],
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(to, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    // The noise of pictures hardly becomes smaller by more work: see docs/performance.md.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    if let Some((name, text)) = text {
        encoder.add_text_chunk(name.into(), text.into())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    Ok(writer.finish()?)
}
