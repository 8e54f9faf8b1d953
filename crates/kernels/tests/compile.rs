//! Kernels that are compiled while the program runs.

use std::path::Path;

use raggio_kernels::compile::{CompileError, FOLDER, spirv};
use raggio_kernels::{SPIRV, Spirv, Variant};

/// Compiles a copy of the kernels in which `old` of one file reads `new`, and returns the outcome.
fn edited(file: &str, old: &str, new: &str) -> Result<Spirv, CompileError> {
    edited_for(false, file, old, new)
}

/// Compiles so, those that ask hardware too if `queries` says so.
fn edited_for(queries: bool, file: &str, old: &str, new: &str) -> Result<Spirv, CompileError> {
    let copy = tempfile::tempdir().expect("a temporary folder");
    copy_folder(Path::new(FOLDER), copy.path());
    let path = copy.path().join(file);
    let source = std::fs::read_to_string(&path).expect("the file is there");
    assert!(source.contains(old), "{file} has no `{old}`");
    std::fs::write(&path, source.replacen(old, new, 1)).expect("the copy can be written");
    spirv(copy.path(), queries)
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("the kernels are there") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

fn changed(name: &str) -> Result<Spirv, CompileError> {
    Err(CompileError::Changed(name.into()))
}

/// The folder's own kernels take the same way; that a comment is new as well costs no further run of the compiler.
#[test]
fn kernels_whose_comments_alone_are_new_are_those_of_the_build() {
    let (old, new) = ("enum ShapeKind : uint\n{\n", "enum ShapeKind : uint\n{\n    // New.\n");
    let code = edited_for(true, "shapes/list.slang", old, new);
    assert!(code.expect("they compile") == SPIRV);
}

#[test]
fn code_may_change() {
    let code = edited("camera.slang", "2.0 * film.x", "3.0 * film.x").expect("it compiles");
    let same = |variant: &Variant| code.code(*variant) == SPIRV.code(*variant);
    // Nobody needs kernels that ask hardware where none can be asked.
    assert!(Variant::ALL.iter().all(|variant| same(variant) == variant.has_queries()));
}

#[test]
fn what_the_host_knows_may_not() {
    assert_eq!(
        edited("camera.slang", "float focusDistance;", "float focusDistance;\n    float tint;"),
        changed("Camera")
    );
    assert_eq!(edited("bvh.slang", "BVH_STACK = 96", "BVH_STACK = 97"), changed("BVH_STACK"));
    assert_eq!(edited("entry/path.slang", "[numthreads(16, 8, 1)]", "[numthreads(4, 8, 1)]"), changed("path"));
    let sentence = CompileError::Changed("View".into()).to_string();
    assert_eq!(sentence, "`View` of the kernels changed: rebuild the program");
}

#[test]
fn mistakes_are_named_with_file_and_line() {
    let error = edited("camera.slang", "// The camera: rays of points of the film.", "float broken( {")
        .expect_err("not Slang")
        .to_string();
    assert!(error.contains("camera.slang:1"), "{error}");
    let error = spirv(Path::new("nowhere"), false).expect_err("no kernels").to_string();
    assert!(error.contains("nowhere"), "{error}");
}
