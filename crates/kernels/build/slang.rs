//! Compiles the kernels, and tells cargo of them.

use std::path::{Path, PathBuf};

use crate::slangc;

/// What the two runs of the compiler left behind.
pub struct Modules {
    pub kernels: PathBuf,
    pub cpp: PathBuf,
    pub cpp_reflection: PathBuf,
    pub spirv_reflection: PathBuf,
}

pub fn compile(workspace: &Path, out: &Path) -> Result<Modules, String> {
    for variable in ["SLANGC", "VULKAN_SDK"] {
        println!("cargo:rerun-if-env-changed={variable}");
    }
    let slangc = slangc::find(workspace, |warning| println!("cargo::warning={warning}"))?;
    let kernels = workspace.join("kernels");
    let (cpp, spirv) = (out.join("kernels.generated.cpp"), out.join("kernels.spv"));
    let messages = [
        slangc::compile(&slangc, &kernels, &["-target", "cpp"], &cpp)?,
        slangc::compile_spirv(&slangc, &kernels, &spirv)?,
    ];
    for line in messages.iter().flat_map(|text| text.lines()).filter(|line| line.starts_with("warning")) {
        println!("cargo::warning={line}");
    }
    watch(&cpp.with_extension("d"))?;
    watch(&spirv.with_extension("d"))?;
    let (cpp_reflection, spirv_reflection) = (cpp.with_extension("json"), spirv.with_extension("json"));
    Ok(Modules { kernels, cpp, cpp_reflection, spirv_reflection })
}

/// Tells cargo which files the compiler read.
fn watch(depfile: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(depfile).map_err(|e| format!("cannot read slangc's dependencies: {e}"))?;
    let (_, files) = text.split_once(": ").ok_or("slangc's dependencies have no target")?;
    // As in a makefile, a space inside a name has a backslash before it.
    for file in files.replace("\\ ", "\0").split_whitespace() {
        println!("cargo:rerun-if-changed={}", file.replace('\0', " "));
    }
    Ok(())
}
