//! Finds and runs `slangc`; for the build script too, so that kernels are compiled in one way only.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The version that the kernels are tested with; layouts and generated C++ depend on it.
const VERSION: &str = "2026.14.1";

/// Variants of the SPIR-V, in the order of `Variant::ALL`: the ending of the names of their files, and the definitions
/// for Slang. `kernels/variant.slang`, `kernels/lists.slang` and `kernels/tracing.slang` say what they are.
pub const VARIANTS: [(&str, &[&str]); 7] = [
    ("spv", &[]),
    ("simple.spv", &["-DSIMPLE"]),
    ("wide.spv", &["-DADDRESSES"]),
    ("simple.wide.spv", &["-DSIMPLE", "-DADDRESSES"]),
    (QUERIES, &["-DRAY_QUERIES"]),
    ("simple.queries.spv", &["-DRAY_QUERIES", "-DSIMPLE"]),
    (WIDE_QUERIES, &["-DRAY_QUERIES", "-DADDRESSES"]),
];
/// Endings of the names of two of them, whose reflections tell where the structure stands.
pub const QUERIES: &str = "queries.spv";
pub const WIDE_QUERIES: &str = "wide.queries.spv";

/// Language that the kernels are compiled to.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// C++, for the host's compiler. Programs that are built have their machine code already.
    #[allow(dead_code)]
    Cpp,
    /// SPIR-V of the variant at a place of [`VARIANTS`].
    Spirv(usize),
    /// SPIR-V that the build script translates for processors, of a variant at a place of [`LANES`].
    #[allow(dead_code)]
    Lanes(usize),
}

/// Variants of the kernels that processors run for several paths at once: the ending of the names of their files, and the
/// definitions for Slang.
#[allow(dead_code)]
pub const LANES: [(&str, &[&str]); 3] =
    [("lanes.spv", &["-DNO_MEDIA"]), ("simple.lanes.spv", &["-DSIMPLE"]), ("media.lanes.spv", &[])];

/// Files of the kernels that processors run for several paths at once; each has an entry point of its name.
#[allow(dead_code)]
pub const LANES_FILES: [&str; 5] = ["stages/renew", "stages/find", "stages/shade", "entry/inspect", "entry/reference"];

/// Entry point that traces no rays: variants that ask hardware do without.
const WITHOUT_RAYS: &str = "display";

impl Target {
    fn asks_hardware(self) -> bool {
        matches!(self, Self::Spirv(variant) if VARIANTS[variant].1.contains(&"-DRAY_QUERIES"))
    }

    fn arguments(self) -> Vec<&'static str> {
        match self {
            Self::Cpp => vec!["-target", "cpp"],
            Self::Spirv(variant) => {
                let target = ["-target", "spirv", "-O0", "-fvk-use-entrypoint-name", "-DSPIRV"];
                [&target, VARIANTS[variant].1].concat()
            }
            Self::Lanes(variant) => {
                [&["-target", "spirv", "-O0", "-fvk-use-entrypoint-name"], LANES[variant].1].concat()
            }
        }
    }
}

/// Entry points of `kernels`, in alphabetical order: each is a file of its name in the folder `entry`.
pub fn entry_points(kernels: &Path) -> Result<Vec<String>, String> {
    let folder = kernels.join("entry");
    let unreadable = |e: std::io::Error| format!("cannot read {}: {e}", folder.display());
    let mut names = vec![];
    for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|ending| ending == "slang") {
            names.extend(path.file_stem().and_then(|stem| stem.to_str()).map(str::to_owned));
        }
    }
    names.sort();
    Ok(names)
}

/// Arguments of the compiler but for the files that it writes.
pub fn arguments(kernels: &Path, entry_points: &[String], target: Target) -> Vec<OsString> {
    let traces = |entry: &&String| !target.asks_hardware() || *entry != WITHOUT_RAYS;
    let entries = || entry_points.iter().filter(traces).map(|entry| format!("entry/{entry}")).collect();
    let files: Vec<String> =
        if let Target::Lanes(_) = target { LANES_FILES.map(String::from).into() } else { entries() };
    let files = files.into_iter().map(|file| kernels.join(file + ".slang").into_os_string());
    let folder = ["-I".into(), kernels.into()];
    // C layout and rows first: then SPIR-V, C++ and Rust's repr(C) agree.
    let layout = ["-fvk-use-c-layout", "-matrix-layout-row-major"];
    // 41035 warns of arrays that are filled as they are used, such as the traversal's stack.
    let messages = ["-line-directive-mode", "none", "-warnings-disable", "41035"];
    let options = layout.into_iter().chain(messages).chain(target.arguments()).map(OsString::from);
    files.chain(folder).chain(options).collect()
}

/// Compiles the entry points of `kernels` into the file `code`; their reflection stands beside that, with the ending
/// `json`. Warnings of the compiler are returned.
pub fn compile(slangc: &Path, kernels: &Path, target: Target, code: &Path) -> Result<String, String> {
    let mut command = Command::new(slangc);
    command.args(arguments(kernels, &entry_points(kernels)?, target));
    command.arg("-o").arg(code).arg("-reflection-json").arg(code.with_extension("json"));
    let result = command.output().map_err(|e| format!("cannot run {}: {e}", slangc.display()))?;
    let messages = String::from_utf8_lossy(&result.stderr).into_owned();
    if !result.status.success() {
        return Err(format!("slangc failed:\n{messages}"));
    }
    if let Target::Spirv(_) = target {
        drop_source_language(code)?;
    }
    Ok(messages)
}

/// Removes OpSource, a note on the source language: validation layers older than Slang take its number for an error.
fn drop_source_language(path: &Path) -> Result<(), String> {
    const HEADER_WORDS: usize = 5;
    const OP_SOURCE: u32 = 3;
    let failed = |e: std::io::Error| format!("cannot rewrite {}: {e}", path.display());
    let bytes = std::fs::read(path).map_err(failed)?;
    let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();

    let mut kept = words.get(..HEADER_WORDS).ok_or("slangc's SPIR-V has no header")?.to_vec();
    let mut rest = &words[HEADER_WORDS..];
    while let Some(&first) = rest.first() {
        // An instruction's length in words and its opcode share its first word.
        let (length, opcode) = (first as usize >> 16, first & 0xffff);
        let instruction = rest.get(..length.max(1)).ok_or("slangc's SPIR-V is cut short")?;
        if opcode != OP_SOURCE {
            kept.extend_from_slice(instruction);
        }
        rest = &rest[length.max(1)..];
    }
    let bytes: Vec<u8> = kept.into_iter().flat_map(u32::to_le_bytes).collect();
    std::fs::write(path, bytes).map_err(failed)
}

/// Finds slangc: `$SLANGC`, what `make setup` installed, `PATH`, the Vulkan SDK: the first there is. `warn` is told of
/// an untested version.
pub fn find(workspace: &Path, warn: impl FnOnce(String)) -> Result<PathBuf, String> {
    if let Some(path) = std::env::var_os("SLANGC").filter(|v| !v.is_empty()) {
        let path = PathBuf::from(path);
        return version(&path).map(|_| path).ok_or_else(|| {
            "$SLANGC does not name a slangc that runs: correct it, or unset it and run `make setup`".into()
        });
    }

    let mut candidates = vec![workspace.join(".venv/bin/slangc")];
    if let Some(path) = std::env::var_os("PATH") {
        candidates.extend(std::env::split_paths(&path).map(|folder| folder.join("slangc")));
    }
    if let Some(sdk) = std::env::var_os("VULKAN_SDK") {
        candidates.push(PathBuf::from(sdk).join("bin/slangc"));
    }
    let found: Vec<_> = candidates
        .into_iter()
        .filter(|path| path.is_file())
        .filter_map(|path| version(&path).map(|version| (path, version)))
        .collect();
    if let Some((path, _)) = found.iter().find(|(_, version)| version == VERSION) {
        return Ok(path.clone());
    }
    let (path, version) = found.into_iter().next().ok_or(format!(
        "slangc, the compiler of the kernels, is missing: run `make setup`, or install the Vulkan SDK or Slang {VERSION} and put slangc on PATH or into $SLANGC"
    ))?;
    warn(format!("slangc {version} is not the tested {VERSION}; `make setup` installs that one into .venv"));
    Ok(path)
}

/// Version of `slangc` as it prints it; `None` where it does not run.
pub fn version(slangc: &Path) -> Option<String> {
    let output = Command::new(slangc).arg("-v").output().ok()?;
    // Some versions print it on standard error.
    let text = [output.stdout, output.stderr].concat();
    Some(String::from_utf8_lossy(&text).trim().trim_start_matches('v').to_owned())
}
