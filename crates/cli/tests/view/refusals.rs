//! Refusals: a sentence says what cannot be done.

use std::process::Output;

use crate::common::{assert_refused, folder_with, program, raggio, text};
use crate::view::SCENE;
use crate::view::desk::{Screen, can_draw};

/// Runs `raggio view scene.toml` without a desktop.
fn view(arguments: &[&str], variables: &[(&str, &str)]) -> Output {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("wrong.play"), "wait 1 frames\n\nfly away").expect("a script");
    let mut command = program();
    command.args(["view", "scene.toml"]).args(arguments).current_dir(folder.path());
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.envs(variables.iter().copied()).output().expect("raggio starts")
}

#[track_caller]
fn assert_device_refused(output: &Output, message: &str) {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{errors}");
    assert!(errors.starts_with("error: ") && errors.contains(message), "expected `{message}` in:\n{errors}");
    assert_eq!(errors.trim_end().lines().count(), 1, "{errors}");
}

#[test]
fn without_a_desktop_it_says_what_works_without() {
    assert_device_refused(&view(&[], &[]), "`raggio render` needs none");
}

#[test]
fn without_a_driver_it_says_what_to_install() {
    let Some(screen) = Screen::new() else { return };
    let no_driver = [("VK_DRIVER_FILES", "/nowhere.json"), ("VK_ICD_FILENAMES", "/nowhere.json")];
    let output = view(&["--device", "cpu"], &[no_driver.as_slice(), &[("DISPLAY", screen.name())]].concat());
    assert_device_refused(&output, "raggio render");
}

#[test]
fn mistakes_in_scripts_and_scenes_are_the_users_to_mend() {
    // Mistakes are told before anything opens: not even a desktop is needed to hear of them.
    let wrong = view(&["--hidden", "--play", "wrong.play"], &[]);
    assert_refused(&wrong, "wrong.play:3: unknown word `fly`");
    let missing = view(&["--hidden", "--play", "missing.play"], &[]);
    assert_refused(&missing, "missing.play: there is no such file");

    let folder = folder_with(&SCENE.replace("radius = 1", "radius = -1"));
    let scene = raggio(folder.path(), &["view", "scene.toml"]);
    assert_refused(&scene, "scene.toml:19:41:");
}

#[test]
fn what_a_script_asks_for_and_cannot_have_is_its_failure() {
    if !can_draw() {
        return;
    }
    let folder = folder_with(SCENE);
    let script = "set materials.clay.colour [1, 0, 0]\nwait 2 frames\nexport /nowhere/a.exr\nwait 2 frames";
    std::fs::write(folder.path().join("a.play"), script).expect("a script");
    let arguments = ["view", "scene.toml", "--device", "cpu", "--size", "64x64", "--hidden", "--play", "a.play"];
    let output = raggio(folder.path(), &arguments);
    assert_refused(&output, "did you mean `color`?");
    assert_refused(&output, "/nowhere/a.exr");
}

#[test]
fn pictures_and_figures_do_not_replace_what_is_shown() {
    if !can_draw() {
        return;
    }
    let folder = folder_with(&SCENE.replace("horizon = [1, 1, 1]\nzenith = [0.2, 0.4, 1.0]", "image = \"sky.png\""));
    let sky = folder.path().join("sky.png");
    image::RgbImage::from_pixel(2, 1, image::Rgb([90, 120, 200])).save(&sky).expect("an image");
    let before = std::fs::read(&sky).expect("an image");
    std::fs::write(folder.path().join("other.toml"), SCENE).expect("a scene");
    let arguments = ["view", "scene.toml", "--device", "cpu", "--size", "64x64", "--hidden", "--play", "a.play"];
    let play = |script: &str| {
        std::fs::write(folder.path().join("a.play"), script).expect("a script");
        raggio(folder.path(), &[&arguments[..], &["--stats", "other.toml"]].concat())
    };
    for script in ["wait 2 frames\nexport sky.png\nwait 2 frames", "wait 2 frames\nscreenshot sky.png\nwait 2 frames"] {
        assert_refused(&play(script), "cannot write sky.png: it would replace what is read, ");
    }
    std::fs::write(folder.path().join("other.toml"), SCENE).expect("a scene");
    let opened = play("wait 2 frames\nopen other.toml\nwait 2 frames");
    assert_refused(&opened, "cannot write other.toml: it would replace what is read, other.toml");
    assert_eq!(std::fs::read(&sky).expect("an image"), before);
}

#[test]
fn what_makes_sense_only_with_a_script_needs_one() {
    assert_refused(&view(&["--hidden"], &[]), "--play <FILE>");
    assert_refused(&view(&["--stats", "a.json"], &[]), "--play <FILE>");
}
