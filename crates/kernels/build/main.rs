//! Build of the kernels: Slang -> SPIR-V, machine code for the CPU, and the Rust twins of their structures.

mod cache;
mod cpp;
#[path = "../src/compile/declarations.rs"]
mod declarations;
mod jobs;
mod lanes;
mod layout;
mod slang;
#[path = "../src/compile/slangc.rs"]
mod slangc;
#[cfg(target_arch = "x86_64")]
#[path = "../src/cpu/x86.rs"]
mod x86;

use std::path::{Path, PathBuf};

use cache::Cache;
use declarations::Declarations;
use jobs::Jobs;
use lanes::Lanes;
use layout::Places;
use slang::Slang;
use slangc::{LANES, QUERIES, Target, VARIANTS, WIDE_QUERIES};

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
    let (entry_points, declarations) = (&slang.entry_points, Declarations::read(&slang.kernels)?);

    std::thread::scope(|scope| {
        let machine_code = scope.spawn(|| {
            let lanes: Vec<_> = LANES.iter().map(|(ending, _)| spirv.with_extension(ending)).collect();
            jobs.run_all([(Target::Cpp, &cpp)].into_iter().chain((0..).map(Target::Lanes).zip(&lanes)).map(
                |(target, code)| {
                    let (slang, cache) = (&slang, &cache);
                    move || slang.compile(cache, target, code)
                },
            ))?;
            let places = Places::read(&cpp.with_extension("json"))?;
            let translated = Lanes::translate_all(&lanes, &declarations, &places)?;
            let sources = cpp::Sources::write(&cpp, entry_points, translated, out)?;
            let units = sources.units(&levels);
            jobs.run_all(units.iter().map(|unit| || sources.compile(&cache, unit, out)))?;
            sources.link(&levels, out);
            cpp::write_table(&levels, entry_points, out)?;
            Ok::<_, String>(places)
        });
        jobs.run_all(VARIANTS.iter().enumerate().map(|(variant, (ending, _))| {
            let code = spirv.with_extension(ending);
            let (slang, cache) = (&slang, &cache);
            move || slang.compile(cache, Target::Spirv(variant), &code)
        }))?;
        let places = machine_code.join().expect("compiling does not panic")?;
        let in_spirv = Places::read(&spirv.with_extension("json"))?;
        let queries = |ending| Places::read(&spirv.with_extension(ending).with_extension("json"));
        let queries = [queries(QUERIES)?, queries(WIDE_QUERIES)?];
        layout::generate(&declarations, entry_points, &places, &in_spirv, &queries, out)
    })
}
