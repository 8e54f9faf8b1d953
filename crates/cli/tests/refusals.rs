//! Wrong input: status 2, one sentence, no panic, nothing written.

use std::path::Path;

use crate::common::{SCENE, assert_refused, folder_with, raggio, text};

#[test]
fn scene_errors_name_file_line_and_remedy() {
    let folder = folder_with(&SCENE.replace("color = [0.8, 0.4, 0.2]", "colour = [0.8, 0.4, 0.2]"));
    for command in ["render", "check"] {
        let output = raggio(folder.path(), &[command, "scene.toml"]);
        assert_refused(
            &output,
            "error: scene.toml:13:1: unknown key `colour` in [materials.clay]: did you mean `color`?",
        );
        assert_eq!(text(&output.stderr).lines().count(), 1, "one sentence");
    }
    assert!(!folder.path().join("scene.png").exists());
}

#[test]
fn all_mistakes_of_a_scene_are_told() {
    let folder = folder_with(&SCENE.replace("samples = 4", "spp = 4").replace("radius = 1", "radius = 0"));
    let output = raggio(folder.path(), &["check", "scene.toml"]);
    let expected = "error: scene.toml:5:1: unknown key `spp` in [render]: did you mean `samples`?\n\
                    scene.toml:16:41: `radius` in `sphere` of shape 1 must be greater than 0, not `0`\n";
    assert_refused(&output, expected);
}

#[test]
fn files_of_other_programs_are_no_scenes() {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("chair.fbx"), b"Kaydara FBX Binary  \0\x1a\0").expect("a file");
    let expected =
        "error: chair.fbx: is neither a scene nor a model that can be read: give a .toml scene or a .gltf, .glb";
    assert_refused(&raggio(folder.path(), &["render", "chair.fbx"]), expected);
}

/// Names that would clear the screen of whoever reads the message.
#[test]
fn names_are_escaped() {
    let folder = folder_with(SCENE);
    let there = |path: &str| raggio(folder.path(), &["check", path]);
    assert_refused(&there("\u{1b}[2J.toml"), "error: \\u{1b}[2J.toml: there is no such file");
    std::fs::write(folder.path().join("\u{1b}.toml"), SCENE).expect("a file");
    assert_eq!(text(&there("\u{1b}.toml").stdout), "\\u{1b}.toml: 1 shape, 1 material, 32x24, 4 samples\n");
    let stats = ["render", "scene.toml", "--device", "cpu", "--stats", "nowhere\u{1b}/stats.json"];
    let refused = raggio(folder.path(), &stats);
    assert_refused(&refused, "error: cannot write nowhere\\u{1b}/stats.json: ");
    assert!(!text(&refused.stderr).contains(".raggio-"), "{}", text(&refused.stderr));
    let picture = |name: &str| raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", name]);
    let refused = picture("nowhere\u{1b}/a.png");
    assert_refused(&refused, "error: cannot write nowhere\\u{1b}/a.png: ");
    assert!(!text(&refused.stderr).contains(".raggio-"), "{}", text(&refused.stderr));
    assert_refused(&picture("a.\u{1b}"), "error: a.\\u{1b}: the ending must be ");
    // Arguments that are none are quoted too.
    for arguments in [&["render", "scene.toml", "--size", "\u{7}12"][..], &["\u{1b}[2J"], &["render", "--\u{8}"]] {
        let refused = raggio(folder.path(), arguments);
        assert_eq!(refused.status.code(), Some(2));
        let said = text(&refused.stderr);
        assert!(said.starts_with("error: ") && !said.chars().any(|c| c.is_control() && c != '\n'), "{said:?}");
    }
}

#[test]
fn one_of_a_thing_is_no_plural() {
    let folder = folder_with(&SCENE.replace("samples = 4", "samples = 1"));
    assert!(text(&raggio(folder.path(), &["check", "scene.toml"]).stdout).ends_with(", 1 sample\n"));
    let rendered = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]);
    assert!(text(&rendered.stderr).contains("32x24, 1 sample on "), "{}", text(&rendered.stderr));
}

#[test]
fn a_missing_scene_is_named() {
    let folder = folder_with(SCENE);
    assert_refused(&raggio(folder.path(), &["render", "nothing.toml"]), "nothing.toml: ");
    assert_refused(&raggio(folder.path(), &["check", "."]), ".: ");
}

#[test]
fn what_is_wrong_with_a_model_is_said_of_it() {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("bunny.ply"), "ply").expect("a file");
    assert_refused(&raggio(folder.path(), &["render", "bunny.ply"]), "error: bunny.ply:");
    assert_refused(&raggio(folder.path(), &["check", "nothing.glb"]), "error: nothing.glb: there is no such file");
    assert_refused(&raggio(folder.path(), &["check", "scene.toml", "--time", "-1"]), "give seconds, 0 to 1e9");
}

#[test]
fn wrong_arguments_are_explained() {
    let folder = folder_with(SCENE);
    let refused = |arguments: &[&str], message: &str| {
        assert_refused(&raggio(folder.path(), &[&["render", "scene.toml"], arguments].concat()), message);
    };
    refused(&["--size", "12"], "give width and height in pixels, each 1 to 65536, as in 1280x720");
    refused(&["--size", "0x5"], "give width and height in pixels");
    refused(&["--samples", "0"], "give a number from 1 to 2147483647, or a range as 64..128");
    refused(&["--samples", "-3"], "-3");
    refused(&["--max-depth", "65536"], "65536 is not in 0..");
    refused(&["--threads", "0"], "0 is not in 1..");
    refused(&["--seed", "x"], "'x'");
    refused(&["--device", "gpu"], "give auto, cpu, vulkan or vulkan:N, with N as in `raggio devices`");
    refused(&["--device", "vulkan:x"], "give auto, cpu, vulkan or vulkan:N");
    refused(&["--tracer", "magic"], "possible values: auto, software, hardware");
    refused(&["--exposure", "nan"], "give stops between -32 and 32");
    refused(&["--exposure", "200"], "give stops between -32 and 32");
    refused(&["--integrator", "magic"], "possible values: path, reference");
    refused(&["--sampels", "3"], "'--samples'");
    refused(&["--spp", "3"], "a similar argument exists: '--samples'");
    refused(&["--width", "640"], "a similar argument exists: '--size'");
    assert!(!folder.path().join("scene.png").exists());
}

#[test]
fn an_image_larger_than_memory_is_refused() {
    let folder = folder_with(SCENE);
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "--size", "65536x65536"]);
    assert_refused(&output, "an image of 65536x65536 pixels needs 864.0 GiB of memory, and ");
}

#[test]
fn a_device_that_is_not_there_is_status_3() {
    let folder = folder_with(SCENE);
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "vulkan:99"]);
    assert_eq!(output.status.code(), Some(3));
    let said = text(&output.stderr);
    assert!(said.starts_with("error: ") && said.lines().count() == 1, "{said}");
    assert!(!folder.path().join("scene.png").exists());
}

/// The CPU has no hardware that traces rays, and nobody who asks for it gets anything else.
#[test]
fn hardware_that_is_not_there_is_status_3() {
    let folder = folder_with(SCENE);
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "--tracer", "hardware"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(
        text(&output.stderr),
        "error: nothing that is cpu here traces rays by hardware: `raggio devices` says what does, and `--tracer auto` does without\n"
    );
}

#[test]
fn too_many_media_around_the_camera_are_refused() {
    let sphere = |i: u32| {
        format!(
            "[materials.g{i}]\nrefractive_index = 1.5\n[[shapes]]\nmaterial = \"g{i}\"\nsphere = {{ center = [0, 1, 4], radius = {} }}\n",
            i + 1
        )
    };
    // TOML wants the tables of materials apart from the list of shapes only in meaning, not in order.
    let scene: String = std::iter::once(SCENE.to_owned()).chain((0..17).map(sphere)).collect();
    let folder = folder_with(&scene);
    assert_refused(
        &raggio(folder.path(), &["check", "scene.toml"]),
        "the camera is inside 17 dielectric bodies at once, and a path can remember 16",
    );
}

#[test]
fn listings_go_to_standard_output() {
    let here = Path::new(".");
    let devices = raggio(here, &["devices"]);
    assert!(devices.status.success());
    let first = text(&devices.stdout).lines().next().unwrap_or_default().to_owned();
    assert!(first.starts_with("cpu ") && first.ends_with("ready, traces rays by software"), "{first}");

    let schema = raggio(here, &["schema"]);
    assert!(schema.status.success());
    let schema: serde_json::Value = serde_json::from_str(&text(&schema.stdout)).expect("JSON");
    assert!(schema["properties"]["camera"].is_object());

    let folder = folder_with(SCENE);
    let check = raggio(folder.path(), &["check", "scene.toml"]);
    assert_eq!(text(&check.stdout), "scene.toml: 1 shape, 1 material, 32x24, 4 samples\n");

    assert!(text(&raggio(here, &["--version"]).stdout).starts_with("raggio "));
    assert!(text(&raggio(here, &["--help"]).stdout).contains("render"));
}
