//! Tools that the tests share: the devices of this machine, scenes from text, estimates with their errors, and
//! references in double precision.
//!
//! Every test runs on the CPU and, where there is one, on a Vulkan device with the validation layers on. Host random
//! numbers come from fixed seeds, so a test passes always or never.

pub mod compare;
pub mod devices;
pub mod geometry;
pub mod random;
pub mod render;
pub mod statistics;

pub use devices::{TestDevice, for_each_device, for_each_device_with, for_each_way};
pub use random::Pcg;
pub use render::{Estimate, estimate, parse, render, render_range};
