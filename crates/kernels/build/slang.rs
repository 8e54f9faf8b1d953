//! Compiles the kernels, and tells cargo of them.

use std::path::{Path, PathBuf};

use crate::cache::Cache;
use crate::slangc::{self, Target};

/// `slangc`, the kernels it compiles, and all that its results depend on.
pub struct Slang {
    slangc: PathBuf,
    /// Folder of the kernels.
    pub kernels: PathBuf,
    /// Names of the kernels that are entered from outside.
    pub entry_points: Vec<String>,
    /// Version of the compiler, then names and texts of the kernels.
    key: String,
}

impl Slang {
    pub fn find(workspace: &Path) -> Result<Self, String> {
        for variable in ["SLANGC", "VULKAN_SDK"] {
            println!("cargo:rerun-if-env-changed={variable}");
        }
        let slangc = slangc::find(workspace, |warning| println!("cargo::warning={warning}"))?;
        let kernels = workspace.join("kernels");
        println!("cargo:rerun-if-changed={}", kernels.display());
        let mut key = slangc::version(&slangc).unwrap_or_default();
        read(&kernels, &mut key).map_err(|e| format!("cannot read {}: {e}", kernels.display()))?;
        let entry_points = slangc::entry_points(&kernels)?;
        Ok(Self { slangc, kernels, entry_points, key })
    }

    /// Compiles the kernels for `target` into `code`; their reflection stands beside it, with the ending `json`.
    pub fn compile(&self, cache: &Cache, target: Target, code: &Path) -> Result<(), String> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let files = [name(code), name(&code.with_extension("json"))];
        // Arguments as they would be in any folder.
        let arguments = slangc::arguments(Path::new(""), &self.entry_points, target);
        let (key, out) = ([&self.key, &*format!("{arguments:?}")], code.parent().unwrap_or(Path::new("")));
        cache.get(&key, out, &files, || {
            let messages = slangc::compile(&self.slangc, &self.kernels, target, code)?;
            for line in messages.lines().filter(|line| line.starts_with("warning")) {
                println!("cargo::warning={line}");
            }
            Ok(())
        })
    }
}

/// Appends names and texts of all files in `folder`, in the order of their names.
fn read(folder: &Path, text: &mut String) -> std::io::Result<()> {
    let mut entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(|entry| entry.file_name());
    for entry in entries {
        *text += &format!("\0{}\0", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            read(&entry.path(), text)?
        } else {
            *text += &std::fs::read_to_string(entry.path())?
        }
    }
    Ok(())
}
