//! Reading of files, under a limit of bytes and inside a folder.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Default of [`LoadOptions::most_bytes`].
pub const MOST_BYTES: u64 = 4 << 30;

/// Options for reading a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// Time at which animations are sampled, in seconds; without it nothing is animated.
    pub time_seconds: Option<f64>,
    /// Whether libraries, buffers and images may lie outside the folder of the file.
    pub allow_outside: bool,
    /// Most bytes of a file, or of all textures: larger files are refused unread, further textures left out.
    pub most_bytes: u64,
}

impl Default for LoadOptions {
    /// Options for a model at rest, inside its folder, of at most [`MOST_BYTES`].
    fn default() -> Self {
        Self { time_seconds: None, allow_outside: false, most_bytes: MOST_BYTES }
    }
}

/// The path that a file in `folder` means by `name`, unless it leads out of the folder. Links are followed later by
/// whoever opens it. Backslashes count as slashes.
pub fn path_inside(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    let drive = name.as_bytes().get(1) == Some(&b':');
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    let inside = !name.is_empty() && !drive && !name.contains('\0') && Path::new(&name).components().all(plain);
    inside.then(|| folder.join(name))
}

/// Bytes of the whole file, or the reason why it cannot be read.
pub(crate) fn read(path: &Path, most_bytes: u64) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "does not exist".to_string(),
        _ => format!("cannot be read: {error}"),
    };
    let file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err("is a folder: give a file".to_string());
    }
    let too_large = || Err(format!("is larger than {most_bytes} bytes, the most that is read"));
    if metadata.len() > most_bytes {
        return too_large();
    }
    // Devices and pipes have no length, so the limit is checked again while reading.
    let mut bytes = Vec::new();
    file.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > most_bytes { too_large() } else { Ok(bytes) }
}
