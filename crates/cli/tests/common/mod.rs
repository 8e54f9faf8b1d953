//! Runs the program as a user would.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program, which keeps nothing in the user's own folders.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raggio"));
    command.env("RAGGIO_NO_CACHE", "1");
    command
}

/// Runs the program in `folder`, on the CPU unless the arguments say otherwise.
pub fn raggio(folder: &Path, arguments: &[&str]) -> Output {
    program().args(arguments).current_dir(folder).output().expect("raggio starts")
}

/// Path of a file of the project.
pub fn project_file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// A small scene that renders at once.
pub const SCENE: &str = r#"version = 1
[render]
width = 32
height = 24
samples = 4
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = [0.7, 0.8, 1.0]
[materials.clay]
color = [0.8, 0.4, 0.2]
[[shapes]]
material = "clay"
sphere = { center = [0, 1, 0], radius = 1 }
"#;

/// A folder of its own with `scene.toml` in it.
pub fn folder_with(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("scene.toml"), scene).expect("the scene is written");
    folder
}

/// Asserts that the program refused its input: status 2, nothing on standard output, `message` on standard error.
pub fn assert_refused(output: &Output, message: &str) {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "stderr: {errors}");
    assert_eq!(text(&output.stdout), "");
    assert!(errors.contains(message), "expected `{message}` in:\n{errors}");
}

/// Size and linear radiance of an EXR.
pub fn read_exr(path: &Path) -> (usize, usize, Vec<[f32; 3]>) {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), size.height(), vec![[0f32; 3]; size.area()]),
        |(width, _, pixels), position, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[position.y() * *width + position.x()] = [r, g, b];
        },
    );
    image.unwrap_or_else(|error| panic!("{}: {error}", path.display())).layer_data.channel_data.pixels
}

/// Names of all that is in a folder, in order.
pub fn files_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"))
        .collect();
    names.sort();
    names
}
