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

/// Knowledge that kernels have of a scene and its device; they are fastest that know least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    simple: bool,
    wide: bool,
    queries: bool,
}

impl Variant {
    /// Variant for scenes without principled materials and lights that are no surfaces.
    pub const SIMPLE: Self = Self { simple: true, wide: false, queries: false };
    /// All variants, in the order of their [indices](Self::index).
    pub const ALL: [Self; 7] = [
        Self { simple: false, wide: false, queries: false },
        Self::SIMPLE,
        Self { simple: false, wide: true, queries: false },
        Self { simple: true, wide: true, queries: false },
        Self { simple: false, wide: false, queries: true },
        Self { simple: true, wide: false, queries: true },
        Self { simple: false, wide: true, queries: true },
    ];

    /// Variant that knows so much. There are none that are simple, wide and ask hardware: such scenes have those that know more.
    pub fn new(simple: bool, wide: bool, queries: bool) -> Self {
        Self { simple: simple && !(wide && queries), wide, queries }
    }

    /// Variant for scenes of which nothing is known.
    pub fn full(self) -> Self {
        Self { simple: false, ..self }
    }

    /// Whether kernels know neither principled materials nor lights without size: `kernels/variant.slang`.
    pub fn is_simple(self) -> bool {
        self.simple
    }

    /// Whether kernels take lists of any length: `kernels/lists.slang`. The scene is not storage buffers then but one
    /// uniform buffer at binding 0, with the addresses of the lists in the order of [`SCENE_BINDINGS`], which takes
    /// `bufferDeviceAddress`.
    pub fn is_wide(self) -> bool {
        self.wide
    }

    /// Whether hardware traces the rays, through a structure that the scene is given beside its lists:
    /// `kernels/queries.slang`. It takes `rayQuery`.
    pub fn has_queries(self) -> bool {
        self.queries
    }

    /// Binding of the structure in the descriptor set of the scene, if there is one.
    pub fn structure_binding(self) -> Option<u32> {
        self.queries.then_some(if self.wide { WIDE_STRUCTURE_BINDING } else { STRUCTURE_BINDING })
    }

    /// Place of the variant in [`Variant::ALL`].
    pub fn index(self) -> usize {
        Self::ALL.iter().position(|variant| *variant == self).unwrap_or_default()
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
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.queries.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.simple.queries.spv"))),
    Cow::Borrowed(include_bytes!(concat!(env!("OUT_DIR"), "/kernels.wide.queries.spv"))),
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
