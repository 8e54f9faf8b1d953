//! Compiles kernels that were edited after the program was built.
//!
//! A development build's window exchanges them while it runs. Only the GPU's kernels: those of the CPU are part of the
//! program.

mod declarations;
mod slangc;

use std::path::Path;

use serde_json::Value;

use crate::Spirv;
use declarations::Declarations;
use slangc::Target;

/// Folder of the kernels that this program was built with, as it was called then.
pub const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../kernels");

/// Reason why kernels cannot take the place of those that the program was built with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompileError {
    /// The kernels are not there, `slangc` is not, or it refuses them: in its own words then, with file and line.
    #[error("{0}")]
    Failed(String),
    /// The host was built for another layout of this structure, parameter, entry point, enumeration or constant.
    #[error("`{0}` of the kernels changed: rebuild the program")]
    Changed(String),
}

/// Compiles the kernels in `folder` in the build's way: the unchanged ones become [`SPIRV`](crate::SPIRV).
///
/// All that they share with the host must be as it was when this program was built.
pub fn spirv(folder: &Path) -> Result<Spirv, CompileError> {
    let (code, shared) = compile(folder).map_err(CompileError::Failed)?;
    let reflection = include_str!(concat!(env!("OUT_DIR"), "/kernels.json"));
    let declarations = include_str!(concat!(env!("OUT_DIR"), "/declarations.txt"));
    let built = shared_with_host(reflection, declarations).map_err(CompileError::Failed)?;

    let new = shared.iter().find(|line| !built.contains(line));
    match new.or_else(|| built.iter().find(|line| !shared.contains(line))) {
        Some(line) => Err(CompileError::Changed(line.split(": ").next().unwrap_or_default().to_owned())),
        None => Ok(code),
    }
}

/// Compiles the kernels in `folder` to SPIR-V, and lists what they share with the host.
fn compile(folder: &Path) -> Result<(Spirv, Vec<String>), String> {
    let unreadable = |e: std::io::Error| format!("cannot read the kernels in {}: {e}", folder.display());
    let kernels = folder.canonicalize().map_err(unreadable)?;
    // The build has warned of an untested version; one that lays out differently is found by the comparison.
    let slangc = slangc::find(&Path::new(FOLDER).join(".."), |_| ())?;

    let room = tempfile::tempdir().map_err(|e| format!("cannot make a temporary folder: {e}"))?;
    let output = room.path().join("kernels.spv");
    let lost = |e: std::io::Error| format!("cannot read what slangc wrote: {e}");
    let compile = |variant: usize| {
        let code = output.with_extension(slangc::VARIANTS[variant].0);
        slangc::compile(&slangc, &kernels, Target::Spirv(variant), &code)?;
        std::fs::read(code).map_err(lost)
    };
    let modules: Vec<_> = std::thread::scope(|scope| {
        let compile = &compile;
        let threads =
            std::array::from_fn::<_, { slangc::VARIANTS.len() }, _>(|variant| scope.spawn(move || compile(variant)));
        let failed = |_| Err("compiling the kernels failed by a fault of raggio's own".into());
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(failed)).collect()
    });
    let mut spirv = crate::SPIRV;
    for (code, module) in spirv.0.iter_mut().zip(modules) {
        *code = module?.into();
    }
    let reflection = std::fs::read_to_string(output.with_extension("json")).map_err(lost)?;
    let shared = shared_with_host(&reflection, &Declarations::read(&kernels)?.text())?;
    Ok((spirv, shared))
}

/// Lists structures, parameters, entry points, enumerations and constants, a line each: the name, a colon, all there is
/// to know.
fn shared_with_host(reflection: &str, declarations: &str) -> Result<Vec<String>, String> {
    let json: Value = serde_json::from_str(reflection).map_err(|e| format!("slangc's reflection is not JSON: {e}"))?;
    // Enumerations and constants are missing from the reflection.
    let mut lines = declarations.lines().map(str::to_owned).collect();
    add_structures(&json, &mut lines);
    for list in ["parameters", "entryPoints"] {
        lines.extend(json[list].as_array().into_iter().flatten().map(line));
    }
    Ok(lines)
}

/// Adds a line for each structure, the inner ones first: they are what changed when the outer ones did.
fn add_structures(json: &Value, lines: &mut Vec<String>) {
    match json {
        Value::Array(values) => values.iter().for_each(|value| add_structures(value, lines)),
        Value::Object(members) => members.values().for_each(|value| add_structures(value, lines)),
        _ => {}
    }
    if json["kind"] == "struct" {
        lines.push(line(json));
    }
}

fn line(json: &Value) -> String {
    format!("{}: {json}", json["name"].as_str().unwrap_or_default())
}
