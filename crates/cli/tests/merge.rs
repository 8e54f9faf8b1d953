//! Films of ranges of samples, and what they add up to.

use std::path::Path;

use crate::common::{SCENE, assert_refused, files_in, folder_with, raggio, text};

/// Runs the program with `arguments`, which succeeds. Returns what it has said.
fn run(folder: &Path, arguments: &[&str]) -> String {
    let output = raggio(folder, arguments);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    said
}

fn render(folder: &Path, arguments: &[&str]) -> String {
    run(folder, &[&["render", "scene.toml", "--device", "cpu"], arguments].concat())
}

#[test]
fn ranges_add_up_to_the_whole_byte_for_byte() {
    let folder = folder_with(SCENE);
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    let look = ["--exposure", "-1", "--tone-mapper", "agx", "--png-bits", "16"];
    render(folder.path(), &[&["--samples", "12", "-o", "a.film", "-o", "a.exr", "-o", "a.png"], &look[..]].concat());
    for (range, name) in [("0..5", "1.film"), ("5..6", "2.film"), ("6..12", "3.film")] {
        render(folder.path(), &["--samples", range, "-o", name]);
    }
    let merge = ["merge", "3.film", "1.film", "2.film", "-o", "b.film", "-o", "b.exr", "-o", "b.png"];
    let said = run(folder.path(), &[&merge, &look[..]].concat());
    assert!(said.starts_with("3 films, 12 samples per pixel\n"), "{said}");
    for (whole, merged) in [("a.film", "b.film"), ("a.exr", "b.exr"), ("a.png", "b.png")] {
        assert!(read(whole) == read(merged), "{merged} is not {whole}");
    }
    // A film of films is one as well, and one film alone is the picture of its own.
    run(folder.path(), &["merge", "b.film", "-o", "c.exr", "--quiet"]);
    assert!(read("c.exr") == read("a.exr"));
}

#[test]
fn a_range_is_a_picture_of_its_own() {
    let folder = folder_with(SCENE);
    let said = render(folder.path(), &["--samples", "4..9", "-o", "a.png", "--stats", "s.json"]);
    assert!(said.contains("samples 4..9 on ") && !said.contains("stopped early"), "{said}");
    let stats = std::fs::read_to_string(folder.path().join("s.json")).expect("stats");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&stats).expect("JSON")["samples_per_pixel"], 5);
    for wrong in ["4..4", "5..4", "..4", "4..", "0", "0..0", "4...6", "-1..2", "1..2147483648", "a..b"] {
        let output = raggio(folder.path(), &["render", "scene.toml", &format!("--samples={wrong}")]);
        assert_refused(&output, "give a number from 1 to 2147483647, or a range as 64..128: samples 64 to 127");
    }
}

#[test]
fn what_is_missing_is_told_and_what_does_not_go_together_refused() {
    let folder = folder_with(SCENE);
    for (range, seed, name) in [("0..2", "0", "1.film"), ("4..6", "0", "2.film"), ("6..8", "1", "3.film")] {
        render(folder.path(), &["--samples", range, "--seed", seed, "-o", name]);
    }
    std::fs::write(folder.path().join("other.toml"), SCENE.replace("0.4, 0.2", "0.4, 0.3")).expect("a scene");
    let other = ["render", "other.toml", "--device", "cpu", "--samples", "2..3", "-o", "4.film"];
    run(folder.path(), &other);
    let said = run(folder.path(), &["merge", "2.film", "1.film", "-o", "a.png"]);
    assert!(said.contains("warning: samples 2..4 are missing\n"), "{said}");
    std::fs::remove_file(folder.path().join("a.png")).expect("a file");

    let bytes = std::fs::read(folder.path().join("2.film")).expect("a film");
    std::fs::write(folder.path().join("5.film"), &bytes[..bytes.len() - 1]).expect("a film");
    let refused = |films: &[&str], message: &str| {
        assert_refused(&raggio(folder.path(), &[&["merge"], films, &["-o", "a.png"]].concat()), message);
    };
    let twice = "error: cannot add 1.film: both films have samples 0..2 of rows 0..24: they would count twice";
    refused(&["1.film", "1.film"], twice);
    refused(&["2.film", "3.film"], "error: cannot add 3.film: the films differ in seed: `0` and `1`");
    refused(&["1.film", "4.film"], "error: cannot add 4.film: the films are of different scenes");
    refused(&["1.film", "5.film"], "error: 5.film: the film is damaged: it is cut short");
    refused(&["1.film", "scene.toml"], "error: scene.toml: not a film of raggio");
    refused(&["1.film", "6.film"], "error: cannot read 6.film: ");
    assert!(!folder.path().join("a.png").exists(), "nothing is written");
    let output = raggio(folder.path(), &["merge", "1.film", "2.film", "-o", "2.film"]);
    assert_refused(&output, "cannot write 2.film: it would replace what is read, 2.film");
    assert!(std::fs::read(folder.path().join("2.film")).expect("a film") == bytes);
    assert_refused(&raggio(folder.path(), &["merge", "1.film"]), "--output <FILE>");
}

#[test]
fn layers_and_denoising_are_not_of_films() {
    let folder = folder_with(SCENE);
    let refused = |arguments: &[&str], message: &str| {
        let render = ["render", "scene.toml", "--device", "cpu", "-o", "a.film"];
        assert_refused(&raggio(folder.path(), &[&render, arguments].concat()), message);
    };
    refused(&["--aov", "depth"], "--aov writes layers, which only .exr has");
    refused(&["--denoise"], "--denoise makes pictures, and a film is none: name a .png or .exr with -o");
    assert_eq!(files_in(folder.path()), ["scene.toml"]);
}

/// Films of pictures with an alpha channel have it too, in a format of their own; unfinished ones have none.
#[test]
fn films_keep_their_alpha() {
    let folder = folder_with(SCENE);
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    render(folder.path(), &["--alpha", "--samples", "12", "-o", "a.film", "-o", "a.exr", "-o", "a.png"]);
    for (range, name) in [("0..5", "1.film"), ("5..12", "2.film")] {
        render(folder.path(), &["--alpha", "--samples", range, "-o", name]);
    }
    run(folder.path(), &["merge", "2.film", "1.film", "-o", "b.film", "-o", "b.exr", "-o", "b.png"]);
    for (whole, merged) in [("a.film", "b.film"), ("a.exr", "b.exr"), ("a.png", "b.png")] {
        assert!(read(whole) == read(merged), "{merged} is not {whole}");
    }
    assert_eq!(read("a.film")[8..12], 3u32.to_le_bytes(), "the format");
    render(folder.path(), &["-o", "plain.film"]);
    assert_eq!(read("plain.film")[8..12], 2u32.to_le_bytes(), "the format without alpha stays");
    let output = raggio(folder.path(), &["merge", "a.film", "plain.film", "-o", "c.exr"]);
    assert_refused(&output, "cannot add plain.film: the films differ in alpha: `true` and `false`");
}
