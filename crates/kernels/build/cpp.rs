//! Compiles the generated C++ once for each level of instruction set.

use std::fmt::Write as _;
use std::path::Path;

use crate::slang::Modules;
use crate::slangc::ENTRY_POINTS;

/// Name in Rust, suffix of symbols, compiler flag.
type Level = (&'static str, &'static str, Option<&'static str>);

/// The most capable first. `RAGGIO_KERNEL_LEVEL=v3`, say, builds one alone where there are several, which is quicker while
/// kernels are written.
fn levels() -> Vec<Level> {
    println!("cargo:rerun-if-env-changed=RAGGIO_KERNEL_LEVEL");
    let only = std::env::var("RAGGIO_KERNEL_LEVEL").ok();
    let all = all_levels();
    let wanted = |level: &Level| all.len() == 1 || only.as_deref().is_none_or(|only| level.1 == only);
    all.iter().copied().filter(wanted).collect()
}

fn all_levels() -> &'static [Level] {
    match std::env::var("CARGO_CFG_TARGET_ARCH").as_deref() {
        Ok("x86_64") => &[
            ("X86V4", "v4", Some("-march=x86-64-v4")),
            ("X86V3", "v3", Some("-march=x86-64-v3")),
            ("X86V2", "v2", Some("-march=x86-64-v2")),
        ],
        _ => &[("Baseline", "baseline", None)],
    }
}

pub fn compile(modules: &Modules, out: &Path) -> Result<(), String> {
    let generated = std::fs::read_to_string(&modules.cpp).map_err(|e| format!("cannot read slangc's C++: {e}"))?;
    // slangc puts its prelude at the head of the file; the prelude ends with its last conditional.
    let end = generated.rfind("#endif").map(|i| i + "#endif".len()).ok_or("slangc's C++ has no prelude")?;
    let (prelude, kernels) = generated.split_at(end);
    write(&out.join("slang_prelude.h"), prelude)?;
    write(&out.join("kernels.inc"), &inlined(kernels))?;

    for (_, suffix, flag) in levels() {
        let unit = out.join(format!("kernels_{suffix}.cpp"));
        write(&unit, &translation_unit(suffix))?;
        compile_unit(&unit, out, suffix, flag)?;
    }
    write(&out.join("cpu_table.rs"), &table())
}

/// Functions, by how their names begin, that are long and called from several places: a call costs little beside what
/// they do, and a copy for every caller costs minutes of the C++ compiler's time.
const CALLED: [&str; 21] = [
    "sobol4D",
    "RoughBoundary_",
    "sheenAlbedo",
    "PrincipledBsdf_evaluate",
    "PrincipledBsdf_x24init",
    "PrincipledFresnel_split",
    "PrincipledPoint_x24init",
    "attributesAt",
    "shapeAttributes",
    "triangleIsThere",
    "firstThere",
    "trace_",
    "traceClosestBruteForce",
    "nextVertex",
    "chooseLight",
    "emission",
    "pdfOfLight",
    "probabilityOfLight",
    "sampleLights",
    "Bsdf_look",
    "ask",
];

/// Every other function into its callers, which doubles the speed: the vectors of the generated code stay in registers.
/// slangc exports the constructors it makes up; they become local like the rest, or the levels' symbols would collide.
fn inlined(kernels: &str) -> String {
    let mut text = String::with_capacity(2 * kernels.len());
    for line in kernels.replace("extern \"C\"\n", "static ").lines() {
        let Some(declaration) = line.strip_prefix("static ") else {
            text += line;
            text.push('\n');
            continue;
        };
        let name = declaration.split('(').next().and_then(|head| head.rsplit([' ', '*']).next()).unwrap_or_default();
        let called = CALLED.iter().any(|start| name.starts_with(start));
        let kind = if called { "noinline" } else { "always_inline" };
        let _ = writeln!(text, "static {}__attribute__(({kind})) {declaration}", if called { "" } else { "inline " });
    }
    text
}

fn translation_unit(suffix: &str) -> String {
    let mut text = String::from(
        "#include <cmath>\n#include <float.h>\n#include <math.h>\n#include <assert.h>\n#include <stdint.h>\n#include <stdlib.h>\n#include <string.h>\n\
         namespace {\n\
         // The C library's calls are not inlined and cost two thirds of the speed.\n\
         inline float raggio_min(float a, float b) { return a < b ? a : b; }\n\
         inline float raggio_max(float a, float b) { return a > b ? a : b; }\n\
         #define fminf raggio_min\n\
         #define fmaxf raggio_max\n\
         #include \"slang_prelude.h\"\n\
         #undef SLANG_PRELUDE_EXPORT\n\
         #define SLANG_PRELUDE_EXPORT static\n\
         #include \"kernels.inc\"\n\
         }\n",
    );
    for entry in ENTRY_POINTS {
        let _ = write!(
            text,
            "extern \"C\" void raggio_{entry}_{suffix}(const uint32_t* groups, void* globals) {{\n\
             \x20   ComputeVaryingInput input = {{}};\n\
             \x20   input.endGroupID = uint3{{groups[0], groups[1], groups[2]}};\n\
             \x20   {entry}(&input, nullptr, globals);\n\
             }}\n"
        );
    }
    text
}

fn compile_unit(unit: &Path, out: &Path, suffix: &str, flag: Option<&str>) -> Result<(), String> {
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").opt_level(3).warnings(false).include(out).file(unit);
    println!("cargo:rerun-if-env-changed=RAGGIO_KERNEL_ASSERTS");
    if std::env::var_os("RAGGIO_KERNEL_ASSERTS").is_some() {
        build.define("SLANG_PRELUDE_ENABLE_ASSERT", None);
    }
    // No fused multiply-add, so that every instruction set gives the same bits. No fast-math: NaN must stay NaN.
    for option in ["-fno-math-errno", "-fno-trapping-math", "-fno-strict-aliasing", "-ffp-contract=off"] {
        build.flag_if_supported(option);
    }
    if let Some(flag) = flag {
        build.flag(flag);
    }
    build.try_compile(&format!("raggio_kernels_{suffix}")).map_err(|e| {
        format!(
            "the C++ compiler that builds the CPU kernels failed or is missing: install g++ or clang++ (Debian and Ubuntu: apt install g++; Fedora: dnf install gcc-c++; macOS: xcode-select --install), or name it in $CXX. {e}"
        )
    })
}

/// Rust declarations of the compiled entry points and the choice among them.
fn table() -> String {
    let mut text = String::from("unsafe extern \"C\" {\n");
    for (_, suffix, _) in levels() {
        for entry in ENTRY_POINTS {
            let _ = writeln!(text, "    fn raggio_{entry}_{suffix}(groups: *const [u32; 3], globals: *const u64);");
        }
    }
    text += "}\n\n/// The levels that this build contains, the most capable first.\npub const BUILT: &[InstructionSet] = &[";
    for (name, _, _) in levels() {
        let _ = write!(text, "InstructionSet::{name}, ");
    }
    text +=
        "];\n\nfn entry_point(set: InstructionSet, entry: EntryPoint) -> Option<Kernel> {\n    match (set, entry) {\n";
    for (name, suffix, _) in levels() {
        for entry in ENTRY_POINTS {
            let variant = entry[..1].to_uppercase() + &entry[1..];
            let _ = writeln!(
                text,
                "        (InstructionSet::{name}, EntryPoint::{variant}) => Some(raggio_{entry}_{suffix}),"
            );
        }
    }
    text += "        #[allow(unreachable_patterns)]\n        _ => None,\n    }\n}\n";
    text
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))
}
