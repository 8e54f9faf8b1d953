//! Compiles kernels that were edited after the program was built.
//!
//! A development build's window exchanges them while it runs. Only the GPU's kernels: those of the CPU are part of the
//! program.

mod declarations;
mod slangc;

use std::path::Path;

use serde_json::Value;

use crate::{Spirv, Variant};
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

/// Compiles the kernels in `folder` in the build's way: the unchanged ones become [`SPIRV`](crate::SPIRV). Those that ask
/// hardware stay what they were built as unless `queries` says that they are needed.
///
/// All that they share with the host must be as it was when this program was built.
pub fn spirv(folder: &Path, queries: bool) -> Result<Spirv, CompileError> {
    let unreadable = |e: std::io::Error| format!("cannot read the kernels in {}: {e}", folder.display());
    let kernels = folder.canonicalize().map_err(unreadable).map_err(CompileError::Failed)?;
    // Declarations are found without the compiler, which takes seconds.
    let declarations = Declarations::read(&kernels).map_err(CompileError::Failed)?.text();
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    same(&lines(&declarations), &lines(include_str!(concat!(env!("OUT_DIR"), "/declarations.txt"))))?;

    let (code, reflection) = compile(&kernels, queries).map_err(CompileError::Failed)?;
    let reflected = |json: &str| reflected(json).map_err(CompileError::Failed);
    same(&reflected(&reflection)?, &reflected(include_str!(concat!(env!("OUT_DIR"), "/kernels.json")))?)?;
    Ok(code)
}

/// Checks that what the kernels share with the host is what it was; each line begins with a name and a colon.
fn same(found: &[String], built: &[String]) -> Result<(), CompileError> {
    let new = found.iter().find(|line| !built.contains(line));
    match new.or_else(|| built.iter().find(|line| !found.contains(line))) {
        Some(line) => Err(CompileError::Changed(line.split(": ").next().unwrap_or_default().to_owned())),
        None => Ok(()),
    }
}

/// Compiles the kernels in the folder `kernels` to SPIR-V, those that ask hardware if `queries` says so; returns the compiler's reflection beside it.
fn compile(kernels: &Path, queries: bool) -> Result<(Spirv, String), String> {
    // The build has warned of an untested version; one that lays out differently is found by the comparison.
    let slangc = slangc::find(&Path::new(FOLDER).join(".."), |_| ())?;

    let room = tempfile::tempdir().map_err(|e| format!("cannot make a temporary folder: {e}"))?;
    let output = room.path().join("kernels.spv");
    let lost = |e: std::io::Error| format!("cannot read what slangc wrote: {e}");
    let compile = |variant: usize| {
        let code = output.with_extension(slangc::VARIANTS[variant].0);
        slangc::compile(&slangc, kernels, Target::Spirv(variant), &code)?;
        std::fs::read(code).map_err(lost)
    };
    let wanted = |place: &usize| queries || !Variant::ALL[*place].has_queries();
    let wanted: Vec<_> = (0..Variant::ALL.len()).filter(wanted).collect();
    let modules: Vec<_> = std::thread::scope(|scope| {
        let compile = &compile;
        let threads: Vec<_> = wanted.iter().map(|&variant| scope.spawn(move || compile(variant))).collect();
        let failed = |_| Err("compiling the kernels failed by a fault of raggio's own".into());
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(failed)).collect()
    });
    let mut spirv = crate::SPIRV;
    for (variant, module) in wanted.into_iter().zip(modules) {
        spirv.0[variant] = module?.into();
    }
    let reflection = std::fs::read_to_string(output.with_extension("json")).map_err(lost)?;
    Ok((spirv, reflection))
}

/// Lists structures, parameters and entry points, a line each: the name, a colon, all there is to know. Enumerations and
/// constants are missing from the reflection.
fn reflected(reflection: &str) -> Result<Vec<String>, String> {
    let json: Value = serde_json::from_str(reflection).map_err(|e| format!("slangc's reflection is not JSON: {e}"))?;
    let mut lines = vec![];
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
