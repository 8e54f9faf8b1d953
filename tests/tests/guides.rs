//! The shape that CONTRIBUTING.md adds as its example, kept as a patch of the tree.

use std::fs;
use std::path::Path;
use std::process::Command;

use raggio_tests::devices::{lacks, long};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const PATCH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/guides/ring.patch");

/// Everything that cargo and the tests read.
const PARTS: [&str; 7] = ["Cargo.toml", "Cargo.lock", "crates", "docs", "kernels", "scenes", "tests"];

/// What is run on the tree with the ring.
const CHECKS: [&str; 3] = [
    "test --release -p raggio-scene -p raggio-render",
    "test --release -p raggio-tests shapes::",
    "check --release -p raggio-viewer --tests",
];

/// Runs `git apply` in `folder`, which may be no repository; false if there is no git.
fn apply(folder: &Path, options: &[&str]) -> bool {
    if Command::new("git").arg("--version").output().is_err() {
        lacks("git, which applies patches, is missing");
        return false;
    }
    let mut git = Command::new("git");
    git.arg("apply").args(options).arg(PATCH).current_dir(folder);
    // A repository further up would have git take the patch for its own.
    git.env("GIT_CEILING_DIRECTORIES", folder.parent().expect("it is in a folder"));
    succeed(git, "the ring's patch does not fit the tree, or is in it: apply it with --reject, mend it, write it anew");
    true
}

/// Runs `command`, whose failure is explained by `meaning` and shown with all that it printed.
fn succeed(mut command: Command, meaning: &str) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let [printed, errors] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{meaning}\n{command:?}: {}\n{printed}\n{errors}", output.status);
}

fn copy(from: &Path, to: &Path) {
    if !from.is_dir() {
        fs::copy(from, to).expect("it can be copied");
        return;
    }
    fs::create_dir_all(to).expect("a folder can be made");
    for entry in fs::read_dir(from).expect("a folder can be read") {
        let entry = entry.expect("a folder can be read");
        copy(&entry.path(), &to.join(entry.file_name()));
    }
}

#[test]
fn the_ring_fits_the_tree() {
    let root = fs::canonicalize(ROOT).expect("the tree is here");
    apply(&root, &["--check"]);
}

/// Always in one folder, of which cargo keeps what it has built.
#[test]
fn the_ring_passes_the_tests() {
    if !long() {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guides");
    let tree = folder.join("tree");
    if tree.exists() {
        fs::remove_dir_all(&tree).expect("what an earlier test has left can be removed");
    }
    fs::create_dir_all(&tree).expect("a folder can be made");
    for part in PARTS {
        copy(&Path::new(ROOT).join(part), &tree.join(part));
    }
    if !apply(&tree, &[]) {
        return;
    }
    // The copy has no .venv.
    let tools = Path::new(ROOT).join(".venv/bin");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path =
        std::env::join_paths([tools].into_iter().chain(std::env::split_paths(&path))).expect("a list of folders");
    for arguments in CHECKS {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(arguments.split(' ')).arg("--locked").current_dir(&tree);
        cargo.env("CARGO_TARGET_DIR", folder.join("target")).env("RAGGIO_KERNEL_LEVELS", "native").env("PATH", &path);
        let start = std::time::Instant::now();
        succeed(cargo, "the tree with the ring of CONTRIBUTING.md fails");
        println!("cargo {arguments}: {:.0} s", start.elapsed().as_secs_f64());
    }
}
