//! Memory that this process may still take: all that is read and made asks here before it takes much, because running
//! out ends a program halfway, without a word.

use std::path::{Path, PathBuf};

/// Memory that this process may still take, in bytes: what the system has available, what the limits of its control
/// groups leave, and what its own limit of address space leaves, whichever is least. `None` where the system does not tell.
pub fn available_bytes() -> Option<u64> {
    [kibibytes("/proc/meminfo", "MemAvailable"), left_by_control_groups(), left_of_address_space()]
        .into_iter()
        .flatten()
        .min()
}

/// Memory of this machine in bytes, or less where a control group limits it; `None` where the system does not tell.
pub fn total_bytes() -> Option<u64> {
    let limits = control_groups().filter_map(|group| number(&group.join("memory.max")));
    kibibytes("/proc/meminfo", "MemTotal").into_iter().chain(limits).min()
}

/// Memory that this process holds, in bytes; `None` where the system does not tell.
pub fn held_bytes() -> Option<u64> {
    kibibytes("/proc/self/status", "VmRSS")
}

/// Most memory that this process has held, in bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    kibibytes("/proc/self/status", "VmHWM")
}

/// Bytes that the limits of the control groups (version 2) around this process leave. Files that are cached are given
/// back before a limit is met.
fn left_by_control_groups() -> Option<u64> {
    let left = |group: PathBuf| {
        let most = number(&group.join("memory.max"))?;
        let used = number(&group.join("memory.current"))?;
        let cached =
            value(&group.join("memory.stat"), "inactive_file ").and_then(|text| text.parse().ok()).unwrap_or(0);
        Some(most.saturating_sub(used.saturating_sub(cached)))
    };
    control_groups().filter_map(left).min()
}

/// Folders of the control groups around this process, its own first.
fn control_groups() -> impl Iterator<Item = PathBuf> {
    let own = value(Path::new("/proc/self/cgroup"), "0::/");
    let own = own.map(|own| Path::new("/sys/fs/cgroup").join(own.trim_start_matches('/')));
    let groups: Vec<PathBuf> = own.iter().flat_map(|own| own.ancestors()).map(Path::to_path_buf).collect();
    groups.into_iter().take_while(|group| group.starts_with("/sys/fs/cgroup"))
}

#[cfg(unix)]
fn left_of_address_space() -> Option<u64> {
    let most = rustix::process::getrlimit(rustix::process::Resource::As).current?;
    Some(most.saturating_sub(kibibytes("/proc/self/status", "VmSize")?))
}

#[cfg(not(unix))]
fn left_of_address_space() -> Option<u64> {
    None
}

/// Number that a file consists of; `None` for the word `max`.
fn number(path: &Path) -> Option<u64> {
    std::fs::read_to_string(path).ok()?.trim().parse().ok()
}

/// Value after `key` in `file`, in bytes; the file gives it in kB.
fn kibibytes(file: &str, key: &str) -> Option<u64> {
    let value = value(Path::new(file), key)?;
    Some(value.trim_start_matches(':').split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// Text that follows `key` in the first line of `file` that begins with it.
fn value(file: &Path, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    text.lines().find_map(|line| line.strip_prefix(key)).map(|rest| rest.trim().to_owned())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn what_is_available_is_part_of_what_there_is() {
        let [available, total, held, peak] =
            [available_bytes(), total_bytes(), held_bytes(), peak_bytes()].map(|bytes| bytes.expect("Linux tells"));
        assert!(available > 0 && available <= total, "{available} of {total}");
        assert!(held > 0 && held <= peak && peak < total, "{held}, at most {peak}");
    }
}
