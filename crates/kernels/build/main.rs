//! Build of the kernels: Slang -> SPIR-V, machine code for the CPU, and the Rust twins of their structures.

mod cache;
mod cpp;
#[path = "../src/compile/declarations.rs"]
mod declarations;
mod jobs;
mod layout;
mod slang;
#[path = "../src/compile/slangc.rs"]
mod slangc;
#[cfg(target_arch = "x86_64")]
#[path = "../src/cpu/x86.rs"]
mod x86;

use std::path::{Path, PathBuf};

use cache::Cache;
use jobs::Jobs;
use slang::Slang;
use slangc::{Target, VARIANTS};

fn main() {
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-changed=src/compile");
    println!("cargo:rerun-if-changed=src/cpu");
    println!("cargo:rerun-if-changed=cpp");
    if let Err(message) = build(&out) {
        // Cargo shows this line even where it folds the rest of a failed build script's output.
        println!("cargo::error={}", message.replace('\n', " "));
        eprintln!("\nerror: {message}\n");
        std::process::exit(1);
    }
}

/// Compiles all there is to compile. The machine code waits for the C++ alone, and the SPIR-V for nothing.
fn build(out: &Path) -> Result<(), String> {
    // Asked for as it runs: a folder that was moved with its `target` has the script of the old place.
    let package = std::env::var("CARGO_MANIFEST_DIR").map_err(|_| "cargo sets CARGO_MANIFEST_DIR")?;
    let slang = Slang::find(&Path::new(&package).join("../.."))?;
    let (cache, jobs) = (Cache::beside(out), Jobs::from_cargo());
    let (cpp, spirv) = (out.join("kernels.generated.cpp"), out.join("kernels.spv"));
    let levels = cpp::levels()?;
    let entry_points = &slang.entry_points;

    std::thread::scope(|scope| {
        let machine_code = scope.spawn(|| {
            jobs.run(|| slang.compile(&cache, Target::Cpp, &cpp))?;
            let sources = cpp::Sources::split(&cpp, entry_points, out)?;
            jobs.run_all(levels.iter().map(|level| || sources.compile(&cache, level, out)))?;
            cpp::write_table(&levels, entry_points, out)
        });
        jobs.run_all(VARIANTS.iter().enumerate().map(|(variant, (ending, _))| {
            let code = spirv.with_extension(ending);
            let (slang, cache) = (&slang, &cache);
            move || slang.compile(cache, Target::Spirv(variant), &code)
        }))?;
        machine_code.join().expect("compiling does not panic")
    })?;
    layout::generate(&slang.kernels, entry_points, &cpp.with_extension("json"), &spirv.with_extension("json"), out)
}
