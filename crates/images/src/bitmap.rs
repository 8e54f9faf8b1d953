/// An image as plain texels, row by row from the top left.
#[derive(Clone)]
pub struct Bitmap {
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// Texels of the image, `width * height` of them.
    pub texels: Texels,
}

/// Texels in one of the forms that files store.
#[derive(Clone, PartialEq)]
pub enum Texels {
    /// Texels of 8 bits: red, green, blue, alpha; 255 is 1. Values are kept as stored: colours are usually sRGB,
    /// everything else linear.
    Rgba8(Vec<[u8; 4]>),
    /// Texels of 16 bits: red, green, blue, alpha; 65535 is 1. Values are kept as stored, like those of `Rgba8`.
    Rgba16(Vec<[u16; 4]>),
    /// Texels of floats: linear red, green, blue, unbounded; finite and not negative. No alpha: it is 1.
    Rgb32F(Vec<[f32; 3]>),
}

impl Texels {
    /// Number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::Rgba8(texels) => texels.len(),
            Self::Rgba16(texels) => texels.len(),
            Self::Rgb32F(texels) => texels.len(),
        }
    }

    /// Whether there are no texels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Equality of two images, decided at once for one that is compared with itself, as happens whenever two things that
/// share an image are compared: that must not look at every texel.
impl PartialEq for Bitmap {
    fn eq(&self, other: &Self) -> bool {
        let same_size = (self.width, self.height) == (other.width, other.height);
        std::ptr::eq(self, other) || same_size && self.texels == other.texels
    }
}

impl std::fmt::Debug for Bitmap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = match self.texels {
            Texels::Rgba8(_) => "8-bit RGBA",
            Texels::Rgba16(_) => "16-bit RGBA",
            Texels::Rgb32F(_) => "32-bit float RGB",
        };
        write!(f, "Bitmap({}x{}, {kind})", self.width, self.height)
    }
}
