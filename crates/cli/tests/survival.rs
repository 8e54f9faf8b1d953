//! Renders that are stopped, killed and let down by their disk: afterwards they are right, or what there is is saved.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{SCENE, assert_refused, files_in, folder_with, program, raggio, text};

/// A scene whose light depends on where a ray goes, with so many samples that a test has the time to stop it.
fn slow() -> String {
    SCENE
        .replace("color = [0.7, 0.8, 1.0]", "horizon = [0, 0, 0]\nzenith = [4, 4, 4]")
        .replace("width = 32\nheight = 24\nsamples = 4", "width = 64\nheight = 48\nsamples = 60")
}

/// So many samples that it takes long.
fn endless() -> String {
    SCENE.replace("samples = 4", "samples = 2000000000")
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program();
    command.args(["render", "scene.toml", "--device", "cpu"]).args(arguments).current_dir(folder);
    command
}

/// Runs `raggio render scene.toml` on the CPU with `arguments`.
fn render(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("raggio starts")
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = render(folder, arguments);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    said
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments).stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("raggio starts")
}

/// Waits until `path` is there.
fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} does not come", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn is_long() -> bool {
    std::env::var("RAGGIO_TEST_LONG").is_ok_and(|value| value == "1")
}

/// Kills the program again and again until it comes to its end, which is that of a program that is let alone.
#[test]
fn whoever_is_killed_goes_on() {
    let folder = folder_with(&slow());
    let runs: [&[&str]; 2] = [&[], &["--noise", "0.05", "--samples", "140"]];
    let kills = if is_long() { 100 } else { 6 };
    let mut random = 12345u64;
    for arguments in runs {
        let outputs = ["-o", "a.film", "-o", "a.exr", "--aov", "samples,variance,object_id"];
        succeeds(folder.path(), &[arguments, &outputs].concat());
        let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
        let expected = ["a.film", "a.exr"].map(read);
        let always = ["--checkpoint", "k", "--resume", "--checkpoint-every", "1samples", "--quiet"];
        let all = [arguments, &outputs, &always].concat();
        let mut killed = 0;
        // Some come to their end before they are killed.
        for _ in 0..10 * kills {
            if killed == kills / 2 {
                break;
            }
            for name in ["a.film", "a.exr"] {
                let _ = std::fs::remove_file(folder.path().join(name));
            }
            let mut child = start(folder.path(), &all);
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            std::thread::sleep(Duration::from_millis(20 + (random >> 33) % 250));
            if child.try_wait().expect("a child").is_none() {
                child.kill().expect("a child");
                killed += 1;
            }
            child.wait().expect("a child");
        }
        assert!(killed > 0, "each was faster than its death");
        succeeds(folder.path(), &all);
        assert!(["a.film", "a.exr"].map(read) == expected, "{arguments:?}: another picture after {killed} kills");
        let left: Vec<_> = files_in(folder.path()).into_iter().filter(|name| name.starts_with('k')).collect();
        assert_eq!(left, Vec::<String>::new());
    }
}

#[cfg(unix)]
fn send(signal: &str, child: &Child) {
    let status = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status();
    assert!(status.expect("kill runs").success());
}

#[cfg(unix)]
#[test]
fn each_signal_saves_what_there_is() {
    for (signal, status) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        // Programs under nohup hand that on.
        if signal == "HUP" && ignores_hangups() {
            eprintln!("not checked: SIGHUP, which whoever runs the tests has ignored");
            continue;
        }
        let folder = folder_with(&endless());
        let every = ["--checkpoint-every", "1samples", "-o", "a.png"];
        let child = start(folder.path(), &every);
        wait_for(&folder.path().join("a.png.checkpoint"));
        send(signal, &child);
        let output = child.wait_with_output().expect("raggio ends");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        let how = format!(
            "stopped by SIG{signal}: what there is is saved in a.png.checkpoint: the same command with --resume goes on from it\n"
        );
        assert!(said.ends_with(&how), "{said}");
        assert!(image::open(folder.path().join("a.png")).is_ok());
        // What it says is so; the checkpoint is a film too.
        let merged = raggio(folder.path(), &["merge", "a.png.checkpoint", "-o", "b.png"]);
        assert!(merged.status.success(), "{}", text(&merged.stderr));
        let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
        assert!(read("a.png") == read("b.png"));
        let said = succeeds(folder.path(), &[&every[..], &["--resume", "--time-limit", "0.01"]].concat());
        assert!(said.contains("going on from a.png.checkpoint, which has "), "{said}");
        assert_eq!(files_in(folder.path()), ["a.png", "b.png", "scene.toml"], "checkpoints go when all is done");
    }
}

/// Whether this process, and so whatever it starts, ignores SIGHUP.
#[cfg(unix)]
fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 != 0)
}

#[cfg(target_os = "linux")]
#[test]
fn nohup_is_respected() {
    let folder = folder_with(&endless());
    let mut child = Command::new("sh")
        .args([
            "-c",
            &format!(
                "trap '' HUP; exec '{}' render scene.toml --device cpu --checkpoint-every 1samples",
                env!("CARGO_BIN_EXE_raggio")
            ),
        ])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .expect("sh starts");
    wait_for(&folder.path().join("scene.png.checkpoint"));
    send("HUP", &child);
    std::thread::sleep(Duration::from_millis(100));
    assert!(child.try_wait().expect("a child").is_none(), "the closed terminal has ended it");
    send("TERM", &child);
    assert_eq!(child.wait().expect("raggio ends").code(), Some(143));
}

#[test]
fn checkpoints_are_for_long_renders_or_those_who_ask() {
    let folder = folder_with(SCENE);
    succeeds(folder.path(), &["--resume"]);
    assert_eq!(files_in(folder.path()), ["scene.png", "scene.toml"]);
    // Who has no checkpoint of this render, or names none, is told.
    std::fs::write(folder.path().join("scene.png.checkpoint"), "x").expect("a file");
    let said = succeeds(folder.path(), &[]);
    assert!(
        said.contains("warning: scene.png.checkpoint is left of an earlier render: --resume goes on from it"),
        "{said}"
    );
    assert!(!succeeds(folder.path(), &["--no-checkpoint"]).contains("warning"));
    assert_refused(&render(folder.path(), &["--resume"]), "scene.png.checkpoint: not a film of raggio");
    let refused = |arguments: &[&str], message: &str| assert_refused(&render(folder.path(), arguments), message);
    refused(&["--no-checkpoint", "--resume"], "cannot be used with");
    refused(&["--checkpoint", "nowhere/k"], "cannot write nowhere/k: ");
    refused(&["--checkpoint", "scene.toml"], "cannot write scene.toml: it would replace what is read, scene.toml");
    refused(&["--checkpoint", "a.png", "-o", "a.png"], "cannot write a.png: it would replace what goes to a.png");
    for wrong in ["", "0s", "s", "-1s", "1d", "0samples", "1.5samples", "60", "nans"] {
        let every = format!("--checkpoint-every={wrong}");
        refused(&[&every], "give a time (60s, 5min, 2h) or a number of samples (64samples)");
    }
}

/// A render that is told to go on from what another is writing would spoil both.
#[test]
fn two_renders_have_no_checkpoint_in_common() {
    let folder = folder_with(&endless());
    let mut child = start(folder.path(), &["--checkpoint-every", "1samples", "-o", "a.png"]);
    wait_for(&folder.path().join("a.png.checkpoint"));
    let by = format!("a.png.checkpoint belongs to a render under way, process {}", child.id());
    for more in [&[][..], &["--resume"], &["--frames", "1"]] {
        assert_refused(&render(folder.path(), &[&["-o", "a.png"], more].concat()), &by);
    }
    succeeds(folder.path(), &["-o", "b.png", "--samples", "1"]);
    succeeds(folder.path(), &["-o", "a.png", "--samples", "1", "--no-checkpoint"]);
    child.kill().and_then(|()| child.wait()).expect("a child");
    // Whoever is dead holds nothing.
    succeeds(folder.path(), &["-o", "a.png", "--resume", "--time-limit", "0.01"]);
    assert_eq!(files_in(folder.path()), ["a.png", "b.png", "scene.toml"]);
}

#[test]
fn checkpoints_of_another_render_are_refused() {
    let folder = folder_with(&slow());
    let kept = ["--checkpoint", "k", "--checkpoint-every", "1samples", "--resume"];
    let before = loop {
        let mut child = start(folder.path(), &[&kept[..], &["--samples", "2000000000"]].concat());
        wait_for(&folder.path().join("k.previous"));
        child.kill().and_then(|()| child.wait()).expect("a child");
        // Between one checkpoint and the next there is, for a moment, only the one before.
        if let Ok(checkpoint) = std::fs::read(folder.path().join("k")) {
            break checkpoint;
        }
        std::fs::remove_file(folder.path().join("k.previous")).expect("a checkpoint");
    };
    let refused = |arguments: &[&str], reason: &str| {
        let output = render(folder.path(), &[&kept[..], &["--samples", "2000000000"], arguments].concat());
        assert_refused(&output, &format!("error: cannot go on from k: {reason}"));
    };
    refused(
        &["--seed", "3"],
        "it was made with seed `0`, and seed is `3` now: render as it was rendered, or remove it",
    );
    refused(&["--noise", "0.1"], "it was made with noise `none`, and noise is `0.1` now");
    refused(&["--size", "30x20"], "it has 64x48 pixels, and the picture is to have 30x20");
    std::fs::write(folder.path().join("scene.toml"), slow().replace("0.4, 0.2", "0.4, 0.3")).expect("a scene");
    refused(&[], "it is of another scene, or of this one before it was changed");
    assert!(std::fs::read(folder.path().join("k")).expect("a checkpoint") == before);
}

/// One step of writing files fails, each in its turn: what is done is right, or says what is not and where the film is.
#[test]
fn whichever_step_of_writing_fails_nothing_is_lost() {
    let expected = folder_with(SCENE);
    let outputs = ["-o", "out/a.png", "-o", "out/a.exr", "-o", "out/a.film", "--stats", "out/s.json"];
    let names = ["a.png", "a.exr", "a.film"];
    std::fs::create_dir(expected.path().join("out")).expect("a folder");
    succeeds(expected.path(), &outputs);
    let expected = names.map(|name| std::fs::read(expected.path().join("out").join(name)).expect("a file"));
    for kept in [&["--checkpoint", "k", "--checkpoint-every", "2samples"][..], &["--no-checkpoint"]] {
        let (mut refused, mut saved, mut overcome) = (0, 0, 0);
        for step in 1.. {
            let folder = folder_with(SCENE);
            let there = |name: &str| folder.path().join(name);
            std::fs::create_dir(there("out")).expect("a folder");
            names.iter().for_each(|name| std::fs::write(there("out").join(name), "old").expect("a file"));
            let mut command = command(folder.path(), &[&outputs[..], kept].concat());
            let output = command.env("RAGGIO_PRETEND_FILE_FAULT", step.to_string()).output().expect("raggio starts");
            let said = text(&output.stderr);
            let found = names.map(|name| std::fs::read(there("out").join(name)).expect("a file"));
            for name in files_in(folder.path()).into_iter().chain(files_in(&there("out"))) {
                assert!(!name.starts_with(".raggio") && !name.ends_with(".part"), "step {step} leaves {name}");
            }
            match output.status.code() {
                Some(0) => {
                    assert!(found == expected, "step {step}: {said}");
                    assert_eq!(files_in(folder.path()), ["out", "scene.toml"], "step {step}: {said}");
                    if !said.contains("warning: ") {
                        break;
                    }
                    assert!(said.contains("warning: no checkpoint could be written to k: "), "step {step}: {said}");
                    overcome += 1;
                }
                Some(2) => {
                    assert!(found.iter().all(|bytes| bytes == b"old"), "step {step}: {said}");
                    assert!(said.starts_with("error: cannot write "), "step {step}: {said}");
                    refused += 1;
                }
                Some(4) => {
                    for ((name, found), expected) in names.iter().zip(&found).zip(&expected) {
                        let told = said.contains(&format!("error: cannot write out/{name}: "));
                        assert!(if told { found == b"old" } else { found == expected }, "step {step}, {name}: {said}");
                    }
                    let (_, film) = said.split_once("the film is saved in ").expect("where the film is");
                    let film = film.split(": ").next().expect("a path");
                    let merged = raggio(folder.path(), &["merge", film, "-o", "m.exr"]);
                    assert!(merged.status.success(), "step {step}: {}", text(&merged.stderr));
                    assert!(std::fs::read(there("m.exr")).expect("a picture") == expected[1], "step {step}");
                    saved += 1;
                }
                other => panic!("step {step}: status {other:?}: {said}"),
            }
        }
        let has_kept = kept.len() > 1;
        assert!(refused > 3 && saved > 6 && (overcome > 4) == has_kept, "{refused}, {saved}, {overcome}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_no_samples() {
    let folder = folder_with(SCENE);
    std::os::unix::fs::symlink("/dev/full", folder.path().join("full.png")).expect("a link");
    let output = render(folder.path(), &["-o", "full.png"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("error: cannot write full.png: No space left on device"), "{said}");
    assert_eq!(files_in(folder.path()), ["full.film", "full.png", "scene.toml"], "{said}");
    let film = folder.path().join("full.film").canonicalize().expect("a path");
    assert!(said.contains(&format!("the film is saved in {}: ", film.display())), "{said}");
    // What it advises works.
    succeeds(folder.path(), &["-o", "a.exr", "--checkpoint", "full.film", "--resume"]);
    succeeds(folder.path(), &["-o", "b.exr"]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    assert!(read("a.exr") == read("b.exr"));
    assert!(!folder.path().join("full.film").exists(), "it was a checkpoint of the render that is done");
}

/// A disk of 64 KiB, where this program may make one.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_becomes_full_keeps_the_last_checkpoint_that_fitted() {
    let folder = folder_with(&endless());
    let disk = folder.path().join("disk");
    std::fs::create_dir(&disk).expect("a folder");
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=100k", "none"]).arg(&disk).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        eprintln!("not tested: only root can mount a disk");
        return;
    }
    // The film has 56 KiB: one fits, and no second beside it.
    let child = start(folder.path(), &["-o", "disk/a.png", "--checkpoint-every", "1samples"]);
    wait_for(&disk.join("a.png.checkpoint"));
    std::thread::sleep(Duration::from_millis(200));
    send("TERM", &child);
    let output = child.wait_with_output().expect("raggio ends");
    let said = text(&output.stderr);
    let (kept, here) = (files_in(&disk), files_in(folder.path()));
    let kept_is_film = raggio(folder.path(), &["merge", "disk/a.png.checkpoint", "-o", "k.png"]).status.success();
    let newer_is_film = raggio(folder.path(), &["merge", "a.png.checkpoint", "-o", "n.png"]).status.success();
    let unmounted = Command::new("umount").arg(&disk).status();
    assert!(unmounted.is_ok_and(|status| status.success()));
    assert_eq!(output.status.code(), Some(143), "{said}");
    let warning = "warning: no checkpoint could be written to disk/a.png.checkpoint: No space left on device";
    assert_eq!(said.matches(warning).count(), 1, "{said}");
    assert!(kept_is_film && newer_is_film, "{kept:?}, {here:?}, {said}");
    assert_eq!(kept, ["a.png", "a.png.checkpoint"], "{said}");
    assert!(said.contains("the same command with --checkpoint /"), "{said}");
}

#[test]
fn progress_is_told_to_programs() {
    let folder = folder_with(&slow());
    let output = render(folder.path(), &["--progress", "json", "--checkpoint", "k", "--checkpoint-every", "1samples"]);
    assert!(output.status.success() && output.stdout.is_empty());
    let lines: Vec<serde_json::Value> =
        text(&output.stderr).lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    let told: Vec<_> = lines.iter().filter(|line| line.get("phase").is_some()).collect();
    let of = |phase: &str| told.iter().filter(|line| line["phase"] == phase).count();
    assert!(of("sampling") > 0 && of("writing") == 1 && of("done") == 1, "{told:?}");
    let writing = told.iter().find(|line| line["phase"] == "writing").expect("a line");
    let figures = ["samples", "samples_wanted", "fraction", "checkpoint"].map(|key| &writing[key]);
    assert_eq!(serde_json::json!(figures), serde_json::json!([60, 60, 1.0, "k"]));
    assert!(writing["seconds"].as_f64().is_some_and(|seconds| seconds > 0.0) && writing["seconds_left"] == 0.0);
    assert!(lines.iter().any(|line| line["message"] == "wrote scene.png"), "{lines:?}");
    let output = render(folder.path(), &["--progress", "json", "--samples", "1", "-o", "nowhere/a.png"]);
    let error: serde_json::Value = serde_json::from_str(&text(&output.stderr)).expect("a line of JSON");
    assert!(error["error"].as_str().is_some_and(|error| error.starts_with("cannot write nowhere/a.png: ")), "{error}");

    let output = render(folder.path(), &["--progress", "openjd"]);
    let lines = text(&output.stdout);
    assert!(lines.starts_with("openjd_status: sampling\nopenjd_progress: "), "{lines}");
    assert!(lines.ends_with("openjd_progress: 100\nopenjd_status: done\n"), "{lines}");
    for line in lines.lines() {
        let progress = line.strip_prefix("openjd_progress: ").map(|number| number.parse::<f64>());
        let is_right = progress.map_or(line.starts_with("openjd_status: "), |number| {
            number.is_ok_and(|number| (0.0..=100.0).contains(&number))
        });
        assert!(is_right, "{line}");
    }
    let output = render(folder.path(), &["--progress", "openjd", "-o", "nowhere/a.png"]);
    assert!(text(&output.stdout).starts_with("openjd_fail: cannot write nowhere/a.png: "), "{}", text(&output.stdout));
    assert_eq!(text(&render(folder.path(), &["--progress", "none"]).stderr).matches('%').count(), 0);
}
