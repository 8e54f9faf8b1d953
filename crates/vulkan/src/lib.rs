//! Vulkan for raggio: all of `ash`, behind an interface without `unsafe`.
//!
//! [`Instance`] lists the physical devices; [`Device`] opens one; [`Buffer`]s hold data; [`Module`] holds the compute
//! pipelines of a SPIR-V module; [`Structure`]s hold what hardware traces rays by; [`Device::run`] records typed passes, which place their own barriers, and waits.
//! Everything is released by `Drop`, in the right order, because each part keeps alive what it was made from.

mod buffer;
mod cache;
#[cfg(feature = "window")]
mod canvas;
mod compute;
#[cfg(target_os = "linux")]
mod cuda;
mod device;
mod error;
#[cfg(target_os = "linux")]
mod exported;
mod faults;
#[cfg(feature = "window")]
mod image;
mod instance;
mod passes;
mod structure;
#[cfg(feature = "window")]
mod surface;
mod transfer;

pub use buffer::{Buffer, Location};
pub use cache::{Compiler, PipelineCache};
#[cfg(feature = "window")]
pub use canvas::{Area, Canvas, Overlay, Picture, Pixels, Shown};
pub use compute::{BindingSet, Lists, Module, Pipeline, SetLayout};
#[cfg(target_os = "linux")]
pub use cuda::{CudaMemory, SAMPLES_OFFSET, SUM_BYTES};
pub use device::Device;
pub use error::VulkanError;
#[cfg(target_os = "linux")]
pub use exported::ExportedBuffer;
pub use faults::Fault;
pub use instance::{DeviceKind, Instance, PhysicalDevice, STORAGE_BUFFERS};
pub use passes::Passes;
pub use structure::{Placed, Structure, StructureKind, StructureSize, Triangles};
#[cfg(feature = "window")]
pub use surface::Surface;
