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

/// SPIR-V modules with all entry points (Vulkan 1.2, scalar block layout), in both variants of `kernels/variant.slang`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spirv {
    /// For any scene.
    pub full: Cow<'static, [u8]>,
    /// For scenes without principled materials and lights without size.
    pub simple: Cow<'static, [u8]>,
}

/// What the program was built with.
pub const SPIRV: Spirv = Spirv {
    full: Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.spv"))),
    simple: Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.spv"))),
};

/// Threads in a workgroup of the image kernels, in x and y.
pub const IMAGE_GROUP: u32 = 8;
/// Threads in a workgroup of the probe kernel.
pub const PROBE_GROUP: u32 = 64;

/// The kernels there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
