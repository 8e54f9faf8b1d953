//! Files by the names that OBJ, MTL and PLY files give them, which were right on another machine.

use std::collections::HashMap;
use std::fs::read_dir;
use std::path::{Path, PathBuf};

use crate::inside::{Named, Refusal};

/// Most entries of a folder among which a name in other letter case is looked for.
const MOST_ENTRIES: usize = 1 << 16;

/// The folder of a model, in which files are looked for.
pub(crate) struct Lookup<'a> {
    folder: &'a Path,
    allow_outside: bool,
    /// Names in the folders that have been searched, by what they are in lower case.
    entries: HashMap<PathBuf, HashMap<String, String>>,
    /// Files that were looked for.
    named: Named,
}

/// A file that is there.
pub(crate) struct Found {
    pub path: PathBuf,
    /// Name of the file, where it is not the one that was asked for.
    pub instead: Option<String>,
}

impl<'a> Lookup<'a> {
    pub(crate) fn new(folder: &'a Path, allow_outside: bool) -> Self {
        Self { folder, allow_outside, entries: HashMap::new(), named: Named::default() }
    }

    /// The file called `name` in the first of `beside` that has it: folders as the model names them, each empty or with a
    /// slash at its end. A file of the name in other letter case is the next best, then one in these folders by the last
    /// part of the name alone, which is all that counts of a path on another machine.
    pub(crate) fn find(&mut self, beside: &[&str], name: &str) -> Result<Found, Refusal> {
        let name = name.replace('\\', "/");
        let last = name.rsplit('/').next().filter(|last| *last != name);
        let mut refusal = Refusal::Missing;
        for (name, is_whole) in [(name.as_str(), true)].into_iter().chain(last.map(|last| (last, false))) {
            let mut missing = Vec::new();
            for folder in beside {
                let candidate = if is_absolute(name) { name.to_string() } else { format!("{folder}{name}") };
                match self.named.locate(self.folder, &candidate, self.allow_outside) {
                    Ok(path) => return Ok(Found { path, instead: (!is_whole).then_some(candidate) }),
                    Err(Refusal::Missing) => missing.push(candidate),
                    Err(other) if refusal == Refusal::Missing => refusal = other,
                    Err(_) => {}
                }
            }
            let found = missing.iter().find_map(|candidate| {
                let candidate = self.in_other_case(candidate)?;
                let path = self.named.locate(self.folder, &candidate, self.allow_outside).ok()?;
                Some(Found { path, instead: Some(candidate) })
            });
            if let Some(found) = found {
                return Ok(found);
            }
        }
        Err(refusal)
    }

    /// Files that were looked for.
    pub(crate) fn into_named(self) -> Named {
        self.named
    }

    /// The name with each of its parts as a folder has it, whatever their letter case.
    fn in_other_case(&mut self, name: &str) -> Option<String> {
        let mut found = String::new();
        for (i, part) in name.split('/').enumerate() {
            let part = match part {
                "" | "." | ".." => part,
                _ => self.entries(&found).get(&part.to_lowercase())?,
            };
            let part = part.to_string();
            found = if i == 0 { part } else { format!("{found}/{part}") };
        }
        Some(found)
    }

    /// Names in a folder by what they are in lower case; none of a folder that links lead to outside the model's.
    fn entries(&mut self, folder: &str) -> &HashMap<String, String> {
        let path = self.folder.join(".").join(folder);
        self.entries.entry(path).or_insert_with_key(|path| {
            let real = [path, &self.folder.join(".")].map(|path| path.canonicalize().ok());
            let is_inside = matches!(&real, [Some(path), Some(folder)] if path.starts_with(folder));
            let mut names = HashMap::new();
            if !is_inside && !self.allow_outside {
                return names;
            }
            for entry in read_dir(path).into_iter().flatten().flatten().take(MOST_ENTRIES) {
                if let Ok(name) = entry.file_name().into_string() {
                    // Of names that differ in their case alone the first counts, in whatever order the folder gives them.
                    let known: &mut String = names.entry(name.to_lowercase()).or_insert_with(|| name.clone());
                    *known = name.min(std::mem::take(known));
                }
            }
            names
        })
    }
}

/// Whether a name, with slashes, says the whole way to a file, on any system.
fn is_absolute(name: &str) -> bool {
    name.starts_with('/') || name.as_bytes().get(1) == Some(&b':')
}

/// The name without quotes around it, which some programs write.
pub(crate) fn unquoted(name: &[u8]) -> &[u8] {
    match name {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner,
        _ => name,
    }
}
