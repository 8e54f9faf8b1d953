//! Kernels as they are built, and as a running program compiles them.

mod compile;
mod spirv;
