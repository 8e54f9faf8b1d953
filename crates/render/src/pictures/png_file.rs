//! PNGs of 8 and of 16 bits.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Encoder, Filter, SrgbRenderingIntent};
use raggio_choice::choice;

use crate::pictures::display::Shown;
use crate::pictures::runs::collect;

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

/// Writes a PNG of 8 bits, row by row from the top left.
pub(crate) fn encode_8_bits(
    size: [u32; 2],
    shown: &Shown<u8>,
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    encode(size, BitDepth::Eight, shown.alpha.is_some(), &shown.values(), text, to)
}

/// Writes a PNG of 16 bits, row by row from the top left.
pub(crate) fn encode_16_bits(
    size: [u32; 2],
    shown: &Shown<u16>,
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    let values = shown.values();
    let bytes = collect(values.len(), |i| values[i].to_be_bytes());
    encode(size, BitDepth::Sixteen, shown.alpha.is_some(), bytes.as_flattened(), text, to)
}

fn encode(
    [width, height]: [u32; 2],
    depth: BitDepth,
    has_alpha: bool,
    data: &[u8],
    text: Option<PngText>,
    to: &mut impl Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(to, width, height);
    encoder.set_color(if has_alpha { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    // The noise of pictures hardly becomes smaller by more work: see docs/performance.md.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    if let Some((name, text)) = text {
        encoder.add_text_chunk(name.into(), text.into())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    Ok(writer.finish()?)
}
