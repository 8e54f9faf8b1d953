//! Declarations of the Slang files that slangc's reflection leaves out: `enum X : uint { A = 0, ... }` and
//! `static const uint N = 1;`.
//!
//! The build script reads them too.

use std::path::{Path, PathBuf};

#[derive(Default)]
pub struct Declarations {
    pub enumerations: Vec<Enumeration>,
    /// Names and values of the constants.
    pub constants: Vec<(String, String)>,
}

pub struct Enumeration {
    pub name: String,
    /// Lines of the variants, such as `A = 0,`, and the comments between, in the order of the file.
    pub variants: Vec<String>,
}

impl Enumeration {
    /// Lines of the variants, such as `A = 0,`, without the comments between.
    pub fn values(&self) -> impl Iterator<Item = &str> {
        self.variants.iter().map(String::as_str).filter(|line| !line.starts_with("//"))
    }
}

impl Declarations {
    /// Reads the declarations of all Slang files below `kernels`, in the order of the files' paths.
    pub fn read(kernels: &Path) -> Result<Self, String> {
        let mut files = Vec::new();
        slang_files(kernels, &mut files).map_err(|e| format!("cannot list the kernels: {e}"))?;
        files.sort();
        let mut declarations = Self::default();
        for file in files {
            let source = std::fs::read_to_string(&file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
            declarations.add(&source);
        }
        Ok(declarations)
    }

    /// Text of the declarations, a line each, the name first: equal for kernels that differ in comments alone.
    pub fn text(&self) -> String {
        let enumerations =
            self.enumerations.iter().map(|e| format!("{}: {}\n", e.name, e.values().collect::<String>()));
        let constants = self.constants.iter().map(|(name, value)| format!("{name}: {value}\n"));
        enumerations.chain(constants).collect()
    }

    fn add(&mut self, source: &str) {
        let mut lines = source.lines().map(str::trim);
        while let Some(line) = lines.next() {
            if let Some(name) = line.strip_prefix("enum ").and_then(|l| l.strip_suffix(" : uint")) {
                let body = lines.by_ref().take_while(|l| !l.starts_with('}'));
                let variants = body.filter(|l| l.starts_with("//") || l.contains('=')).map(str::to_owned).collect();
                self.enumerations.push(Enumeration { name: name.into(), variants });
            } else if let Some((name, value)) = line
                .strip_prefix("static const uint ")
                .and_then(|l| l.strip_suffix(';'))
                .and_then(|l| l.split_once(" = "))
                .filter(|(_, value)| value.parse::<u32>().is_ok())
            {
                self.constants.push((name.into(), value.into()));
            }
        }
    }
}

fn slang_files(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            slang_files(&path, found)?;
        } else if path.extension().is_some_and(|e| e == "slang") {
            found.push(path);
        }
    }
    Ok(())
}
