//! Kernels in Slang -> SPIR-V, machine code for the CPU, and the Rust twins of their structures.

mod cpp;
#[path = "../src/compile/declarations.rs"]
mod declarations;
mod layout;
mod slang;
#[path = "../src/compile/slangc.rs"]
mod slangc;

use std::path::{Path, PathBuf};

fn main() {
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-changed=src/compile");

    let outcome = slang::compile(&workspace, &out).and_then(|modules| {
        layout::generate(&modules, &out)?;
        cpp::compile(&modules, &out)
    });
    if let Err(message) = outcome {
        // Cargo shows this line even where it folds the rest of a failed build script's output.
        println!("cargo::error={}", message.replace('\n', " "));
        eprintln!("\nerror: {message}\n");
        std::process::exit(1);
    }
}
