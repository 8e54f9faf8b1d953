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

/// Writes a PNG of 8 bits: bytes red, green, blue, opacity, row by row from the top left. Opacity is left out.
pub(crate) fn encode_8_bits(size: [u32; 2], pixels: &[u8], to: &mut impl Write) -> io::Result<()> {
    let rgb: Vec<u8> = pixels.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    encode(size, BitDepth::Eight, &rgb, to)
}

/// Writes a PNG of 16 bits: red, green, blue, row by row from the top left.
pub(crate) fn encode_16_bits(size: [u32; 2], pixels: &[[u16; 3]], to: &mut impl Write) -> io::Result<()> {
    let rgb: Vec<u8> = pixels.as_flattened().iter().flat_map(|value| value.to_be_bytes()).collect();
    encode(size, BitDepth::Sixteen, &rgb, to)
}

fn encode([width, height]: [u32; 2], depth: BitDepth, rgb: &[u8], to: &mut impl Write) -> io::Result<()> {
    let mut encoder = Encoder::new(to, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    // The noise of pictures hardly becomes smaller by more work: see docs/performance.md.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    Ok(writer.finish()?)
}
