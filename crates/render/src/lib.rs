//! From a scene to a picture, on any device.
//!
//! `Scene -> DeviceScene -> kernels -> Film -> file`: [`DeviceScene`] is the scene as flat buffers, a [`Device`] makes it
//! resident and adds samples to a [`Film`], [`Renderer`] does so in portions that leave the machine usable, and
//! [`ImageFile`] writes the result. Nothing above [`Device`] knows whether it is a CPU or a GPU.

mod adaptive;
mod aov;
mod bounds;
mod choice;
mod cpu;
mod device;
mod device_scene;
mod display;
mod film;
mod films;
mod filters;
mod hierarchy;
mod image_file;
mod image_input;
mod lights;
mod linear_image;
mod machine;
mod media;
mod meshes;
mod metadata;
mod renderer;
mod textures;
mod translation_error;
mod vulkan;

pub use adaptive::Blocks;
pub use aov::{Aov, Channel, Features};
pub use bounds::bounds;
pub use choice::{DeviceChoice, OpenOptions, devices, open};
pub use cpu::{CpuDevice, CpuOptions};
pub use device::{Answer, Device, DeviceError, DeviceInfo, Question, Session};
pub use device_scene::DeviceScene;
pub use display::{Display, Pixels, show_image};
pub use film::{Film, SizeMismatch, film_bytes};
pub use image_file::{Extras, ImageFile, OutputError, check_writable, write_png, write_whole};
pub use image_input::InputError;
pub use linear_image::Image;
pub use machine::{TooLarge, check_memory, memory_bytes, peak_memory_bytes, total_memory_bytes};
pub use metadata::Metadata;
pub use raggio_kernels::compile::FOLDER as KERNELS_FOLDER;
pub use raggio_kernels::cpu::InstructionSet;
pub use raggio_kernels::{
    Comparison, Feature, FilmPixel, MAX_NESTED_MEDIA, Probe, SamplerKind, Sequence, ShapeKind, Spirv, ToneMapper, View,
};
pub use renderer::{Progress, Renderer};
pub use textures::{ColorSpace, TextureTable};
pub use translation_error::TranslationError;
pub use vulkan::VulkanDevice;
