//! The kernels of raggio: SPIR-V for Vulkan, machine code for the CPU, and the structures both read.
//!
//! Everything that runs per ray is written in Slang, in `kernels/`; this crate's build script compiles it.

pub mod compile;
pub mod cpu;
mod film;
mod layout;
mod view;

use std::borrow::Cow;

pub use layout::*;

/// What kernels know of a scene and what they do not; they are fastest that know least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Of neither principled materials nor lights without size: `kernels/variant.slang`.
    pub simple: bool,
    /// Of lists of any length: `kernels/lists.slang`. The scene is not storage buffers but one uniform buffer at binding 0,
    /// with the addresses of the lists in the order of [`SCENE_BINDINGS`], which takes `bufferDeviceAddress`.
    pub wide: bool,
}

impl Variant {
    /// The simple one.
    pub const SIMPLE: Self = Self { simple: true, wide: false };
    /// All there are.
    pub const ALL: [Self; 4] = [
        Self { simple: false, wide: false },
        Self::SIMPLE,
        Self { simple: false, wide: true },
        Self { simple: true, wide: true },
    ];

    /// Its place in [`Variant::ALL`].
    pub fn index(self) -> usize {
        usize::from(self.simple) + 2 * usize::from(self.wide)
    }
}

/// SPIR-V modules with all entry points (Vulkan 1.2, scalar block layout), one for each [`Variant`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spirv([Cow<'static, [u8]>; Variant::ALL.len()]);

impl Spirv {
    /// The module of `variant`.
    pub fn code(&self, variant: Variant) -> &[u8] {
        &self.0[variant.index()]
    }
}

/// What the program was built with.
pub const SPIRV: Spirv = Spirv([
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.wide.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.wide.spv"))),
]);

/// Threads in a workgroup of the image kernels, in x and y.
pub const IMAGE_GROUP: u32 = 8;
/// Threads in a workgroup of the probe kernel.
pub const PROBE_GROUP: u32 = 64;

/// The kernels there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EntryPoint {
    /// Adds samples to the film, looking for light.
    Path,
    /// Adds samples to the film, and finds light by chance.
    Reference,
    /// Adds samples of what the camera's rays meet first.
    Inspect,
    /// Turns the film into displayable pixels.
    Display,
    /// Evaluates a single function for many arguments.
    Probe,
}

impl EntryPoint {
    /// All there are, in order.
    pub const ALL: [Self; 5] = [Self::Path, Self::Reference, Self::Inspect, Self::Display, Self::Probe];

    /// Its name in the SPIR-V module.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Reference => "reference",
            Self::Inspect => "inspect",
            Self::Display => "display",
            Self::Probe => "probe",
        }
    }

    /// Workgroups that cover the work, in x, y, z.
    pub fn groups(self, work: &Work) -> [u32; 3] {
        match self {
            Self::Path | Self::Reference | Self::Inspect | Self::Display => {
                [work.width.div_ceil(IMAGE_GROUP), work.rows.div_ceil(IMAGE_GROUP), 1]
            }
            Self::Probe => [work.count.div_ceil(PROBE_GROUP), 1, 1],
        }
    }
}
