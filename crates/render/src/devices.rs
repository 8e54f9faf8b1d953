//! The machines that trace rays, and how they are found, opened and told what to do.

pub mod adaptive;
pub mod choice;
pub mod counted;
pub mod cpu;
pub mod device;
pub mod films;
pub mod group;
pub mod kept;
pub mod machine;
pub mod pipelines;
pub mod structures;
pub mod tracer;
pub mod vulkan;
