//! The kernels of raggio: SPIR-V for Vulkan, machine code for the CPU, and the structures both read.
//!
//! Everything that runs per ray is written in Slang, in `kernels/`; this crate's build script compiles it.

mod choices;
pub mod compile;
pub mod cpu;
mod film;
mod layout;
mod specialization;
mod view;

use std::borrow::Cow;

pub use layout::*;
pub use specialization::Specialization;

/// Knowledge that kernels have of a scene; they are fastest that know least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Whether kernels know neither principled materials nor lights that are no surfaces: `kernels/variant.slang`.
    pub simple: bool,
    /// Whether kernels take lists of any length: `kernels/lists.slang`. The scene is not storage buffers then but one
    /// uniform buffer at binding 0, with the addresses of the lists in the order of [`SCENE_BINDINGS`], which takes
    /// `bufferDeviceAddress`.
    pub wide: bool,
}

impl Variant {
    /// Variant for scenes without principled materials and lights that are no surfaces.
    pub const SIMPLE: Self = Self { simple: true, wide: false };
    /// All variants, in the order of their [indices](Self::index).
    pub const ALL: [Self; 4] = [
        Self { simple: false, wide: false },
        Self::SIMPLE,
        Self { simple: false, wide: true },
        Self { simple: true, wide: true },
    ];

    /// Place of the variant in [`Variant::ALL`].
    pub fn index(self) -> usize {
        usize::from(self.simple) + 2 * usize::from(self.wide)
    }
}

/// SPIR-V modules with all entry points (Vulkan 1.2, scalar block layout), one for each [`Variant`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spirv([Cow<'static, [u8]>; Variant::ALL.len()]);

impl Spirv {
    /// SPIR-V of `variant`, as bytes.
    pub fn code(&self, variant: Variant) -> &[u8] {
        &self.0[variant.index()]
    }
}

/// Modules that the program was built with.
pub const SPIRV: Spirv = Spirv([
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.wide.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.wide.spv"))),
]);

/// Threads in a workgroup of the image kernels, in x and y.
pub const IMAGE_GROUP: u32 = 8;
/// The same of the path tracer: twice as many, which is 2 % faster on an H200.
pub const PATH_GROUP: [u32; 2] = [16, 8];
/// Threads in a workgroup of the probe kernel.
pub const PROBE_GROUP: u32 = 64;

impl EntryPoint {
    /// Number of workgroups that cover the work, in x, y, z: a thread is a question, or a pixel.
    pub fn groups(self, work: &Work) -> [u32; 3] {
        match self {
            Self::Probe => [work.count.div_ceil(PROBE_GROUP), 1, 1],
            Self::Path => [work.width.div_ceil(PATH_GROUP[0]), work.rows.div_ceil(PATH_GROUP[1]), 1],
            _ => [work.width.div_ceil(IMAGE_GROUP), work.rows.div_ceil(IMAGE_GROUP), 1],
        }
    }
}
