//! Keeps what compilers make, so that nothing is made again from equal text, with equal flags, by an equal compiler.

use std::fmt::Write as _;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Age at which an entry that no build has asked for is thrown away.
const KEPT: Duration = Duration::from_secs(14 * 24 * 60 * 60);

/// Folder of earlier results beside cargo's own, which `cargo clean` takes away.
///
/// Each entry is a folder with the files that were made and, in `key`, all that they were made from. The key is compared
/// whole, so the hash that names the folder may collide.
pub struct Cache(PathBuf);

impl Cache {
    /// Cache for builds that write to cargo's `OUT_DIR`, shared by all profiles.
    pub fn beside(out: &Path) -> Self {
        // OUT_DIR is target/PROFILE/build/raggio-kernels-HASH/out.
        let target = out.ancestors().nth(4).unwrap_or(out);
        let cache = Self(target.join("raggio-kernels"));
        cache.prune();
        cache
    }

    /// Puts `files` into the folder `out`: those kept under `key`, or else those that `make` writes there.
    pub fn get(
        &self,
        key: &[&str],
        out: &Path,
        files: &[String],
        make: impl FnOnce() -> Result<(), String>,
    ) -> Result<(), String> {
        let key = key.iter().fold(String::new(), |mut text, part| {
            let _ = writeln!(text, "{}\n{part}", part.len());
            text
        });
        let mut hasher = DefaultHasher::new();
        key.hash(&mut hasher);
        let entry = self.0.join(format!("{:016x}", hasher.finish()));
        if std::fs::read(entry.join("key")).is_ok_and(|kept| kept == key.as_bytes()) && copy(files, &entry, out).is_ok()
        {
            // The time of the last use is kept for `prune`.
            let _ = File::options()
                .append(true)
                .open(entry.join("key"))
                .and_then(|kept| kept.set_modified(SystemTime::now()));
            return Ok(());
        }
        make()?;
        // A cache that cannot be written costs time and nothing else. The key comes last: it says that the rest is whole.
        let _ = std::fs::create_dir_all(&entry)
            .and_then(|()| std::fs::remove_file(entry.join("key")).or(Ok(())))
            .and_then(|()| copy(files, out, &entry))
            .and_then(|()| std::fs::write(entry.join("key"), &key));
        Ok(())
    }

    fn prune(&self) {
        for entry in std::fs::read_dir(&self.0).into_iter().flatten().flatten() {
            // An entry that was never finished has no key.
            let used = std::fs::metadata(entry.path().join("key")).or_else(|_| entry.metadata());
            let used = used.and_then(|data| data.modified());
            let age = used.ok().and_then(|used| SystemTime::now().duration_since(used).ok());
            if age.is_some_and(|age| age > KEPT) {
                let _ = std::fs::remove_dir_all(entry.path());
            }
        }
    }
}

fn copy(files: &[String], from: &Path, to: &Path) -> std::io::Result<()> {
    files.iter().try_for_each(|file| std::fs::copy(from.join(file), to.join(file)).map(|_| ()))
}
