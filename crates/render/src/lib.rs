//! Rendering: the way of a scene to a picture, on any device.
//!
//! `Scene -> DeviceScene -> kernels -> Film -> file`: [`DeviceScene`] is the scene as flat buffers, a [`Device`] makes
//! it resident and adds samples to a [`Film`], [`Renderer`] does so in portions that leave the machine usable, and
//! [`ImageFile`] writes the result. Nothing above [`Device`] knows whether it is a CPU or a GPU.
//!
//! A front end fills in a [`RenderRequest`]; a [`Rendering`] goes all of that way and tells an [`Observer`].

mod checkpoint;
mod devices;
mod frames;
mod pictures;
mod renderer;
mod rendering;
mod request;
mod translation;

pub use checkpoint::{CheckpointError, Checkpoints, Every};
pub use devices::adaptive::Blocks;
pub use devices::choice::{DeviceChoice, DeviceSelection, OpenOptions, devices, open, open_all};
pub use devices::counted::Counted;
pub use devices::cpu::{CpuDevice, CpuOptions};
pub use devices::device::{Answer, Device, DeviceError, DeviceInfo, Question, Session};
pub use devices::group::DeviceGroup;
pub use devices::kept::cache_folder;
pub use devices::machine::{TooLarge, check_memory, memory_bytes, peak_memory_bytes, total_memory_bytes};
pub use devices::tracer::Tracer;
pub use devices::vulkan::VulkanDevice;
pub use frames::{FrameRate, Frames, Pattern};
pub use pictures::aov::{Aov, Channel, Features, Values};
pub use pictures::display::{Denoised, Display, Pixels, show_bytes, show_image};
pub use pictures::file_faults::{file_fault_is_due, pretend_file_fault};
pub use pictures::film::{Film, FilmError, Label, MergeError, Portion, film_bytes};
pub use pictures::fingerprint::Fingerprint;
pub use pictures::format::PictureFormat;
pub use pictures::image_file::{Extras, ImageFile, OutputError, encode_png, write_png};
pub use pictures::image_input::{DisplayedImage, InputError};
pub use pictures::linear_image::Image;
pub use pictures::metadata::Metadata;
pub use pictures::output_file::{OutputFile, abandon_files, write_whole};
pub use pictures::picture::{Picture, gpu_of};
pub use pictures::png_file::PngBits;
pub use raggio_choice::{Choice, UnknownName, endings, listed};
pub use raggio_denoise::{Care, DenoiseError, Denoiser, Gpu, Interface};
pub use raggio_kernels::compile::FOLDER as KERNELS_FOLDER;
pub use raggio_kernels::cpu::{Counts, InstructionSet, StageCounts, Walk};
pub use raggio_kernels::{
    Comparison, Feature, FilmPixel, MAX_NESTED_MEDIA, Probe, SamplerKind, Sequence, ShapeKind, Spirv, ToneMapper, View,
};
#[cfg(target_os = "linux")]
pub use raggio_vulkan::CudaMemory;
pub use renderer::{NoiseProgress, Progress, Renderer};
pub use rendering::{Development, Preparation, RenderError, Rendered, Rendering};
pub use request::{Observer, Phase, RenderRequest, Stop, UNLIMITED_SAMPLES};
pub use translation::bounds::bounds;
pub use translation::device_scene::DeviceScene;
pub use translation::error::TranslationError;
pub use translation::textures::{ColorSpace, TextureTable};
