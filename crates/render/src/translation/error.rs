//! Why a scene is not translated.

use raggio_kernels::MAX_TEXTURE_SIDE;

/// A scene that no device can hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TranslationError {
    /// More bodies around the camera than a path remembers.
    #[error("the camera is inside {found} dielectric bodies at once, and a path can remember {limit}")]
    TooManyMedia {
        /// How many there are.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Hierarchies that this machine has no memory to build.
    #[error(
        "building the hierarchies of {triangles} triangles takes {needed_gib:.1} GiB of memory, and this machine has {free_gib:.1} GiB free"
    )]
    TooMuchMemory {
        /// In meshes that are not built yet.
        triangles: usize,
        /// What they take while they are built.
        needed_gib: f64,
        /// What there is.
        free_gib: f64,
    },
    /// Places in lists over triangles have 30 bits, those in lists over vertices 32.
    #[error(
        "the meshes of this scene have more than 1 billion triangles or nodes, or 4 billion words of vertex data, together"
    )]
    TooManyTriangles,
    /// More texels than kernels can address.
    #[error(
        "the scene's images take {needed_gib:.1} GiB in all, and kernels can address {limit_gib:.0} GiB: use fewer or smaller ones"
    )]
    TooManyTexels {
        /// What they would take.
        needed_gib: f64,
        /// What there may be.
        limit_gib: f64,
    },
    /// A side of an image that floats cannot address.
    #[error("an image of {width} x {height} texels is too large: a side may have {MAX_TEXTURE_SIDE}")]
    ImageTooLarge {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
    },
}
