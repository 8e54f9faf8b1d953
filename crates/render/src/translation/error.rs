//! Reasons why a scene is not translated.

use raggio_kernels::MAX_TEXTURE_SIDE;

/// A scene that no device can hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TranslationError {
    /// More bodies around the camera than a path remembers.
    #[error("the camera is inside {found} dielectric bodies at once, and a path can remember {limit}")]
    TooManyMedia {
        /// Number of bodies around the camera.
        found: usize,
        /// Most bodies that a path remembers.
        limit: usize,
    },
    /// Hierarchies that this machine has no memory to build.
    #[error(
        "building the hierarchies of {triangles} triangles takes {needed_gib:.1} GiB of memory, and this machine has {free_gib:.1} GiB free"
    )]
    TooMuchMemory {
        /// Number of triangles in meshes that are not built yet.
        triangles: usize,
        /// Memory that they take while they are built, in GiB.
        needed_gib: f64,
        /// Memory that this machine has free, in GiB.
        free_gib: f64,
    },
    /// More triangles or vertex data than lists have places for: these have 30 bits over triangles, 32 over vertices.
    #[error(
        "the meshes of this scene have more than 1 billion triangles or nodes, or 4 billion words of vertex data, together"
    )]
    TooManyTriangles,
    /// More texels than kernels can address.
    #[error(
        "the scene's images take {needed_gib:.1} GiB in all, and kernels can address {limit_gib:.0} GiB: use fewer or smaller ones"
    )]
    TooManyTexels {
        /// Memory that all texels would take, in GiB.
        needed_gib: f64,
        /// Memory of texels that kernels can address, in GiB.
        limit_gib: f64,
    },
    /// An image for which no memory is left.
    #[error("an image of the scene takes {needed_gib:.2} GiB of memory, and {available_gib:.2} GiB are available")]
    NoMemoryForTexels {
        /// Memory that the image's texels take, in GiB.
        needed_gib: f64,
        /// Memory that is available, in GiB.
        available_gib: f64,
    },
    /// A side of an image that floats cannot address.
    #[error("an image of {width} x {height} texels is too large: a side may have {MAX_TEXTURE_SIDE}")]
    ImageTooLarge {
        /// Width of the image in texels.
        width: u32,
        /// Height of the image in texels.
        height: u32,
    },
}
