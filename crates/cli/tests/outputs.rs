//! Files that the program writes: what is in them, what they may replace, and what happens where they cannot be written.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{SCENE, assert_refused, files_in, folder_with, program, raggio, read_exr, text};

/// So many samples that a test would not end if it rendered first.
fn endless() -> String {
    SCENE.replace("samples = 4", "samples = 2000000000")
}

/// Red, green and blue of a PNG, and what it says of their bits and of their colour space.
fn read_png(path: &Path) -> (png::BitDepth, Option<png::SrgbRenderingIntent>, Vec<u32>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).expect("the file"))).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut bytes).expect("the pixels");
    let info = reader.info();
    assert_eq!((info.color_type, info.width, info.height), (png::ColorType::Rgb, 32, 24));
    let values = match info.bit_depth {
        png::BitDepth::Sixteen => {
            bytes.chunks_exact(2).map(|pair| u32::from(pair[0]) << 8 | u32::from(pair[1])).collect()
        }
        _ => bytes.into_iter().map(u32::from).collect(),
    };
    (info.bit_depth, info.srgb, values)
}

/// The sRGB transfer function.
fn srgb(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn pngs_of_16_bits_are_those_of_8_with_finer_steps() {
    let folder = folder_with(SCENE);
    let render = |arguments: &[&str]| {
        let scene = ["render", "scene.toml", "--device", "cpu", "--exposure", "-0.5"];
        let output = raggio(folder.path(), &[&scene, arguments].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
    };
    for mapper in ["neutral", "agx", "aces", "filmic", "reinhard", "none"] {
        render(&["--tone-mapper", mapper, "-o", "a.png"]);
        render(&["--tone-mapper", mapper, "--png-bits", "16", "-o", "b.png"]);
        let (depth, space, coarse) = read_png(&folder.path().join("a.png"));
        assert_eq!((depth, space), (png::BitDepth::Eight, Some(png::SrgbRenderingIntent::Perceptual)));
        let (depth, space, fine) = read_png(&folder.path().join("b.png"));
        assert_eq!((depth, space), (png::BitDepth::Sixteen, Some(png::SrgbRenderingIntent::Perceptual)));
        assert_eq!(coarse.len(), fine.len());
        for (coarse, fine) in coarse.iter().zip(&fine) {
            // Half a step of the coarse ones, and the rounding of the fine ones.
            let difference = f64::from(*fine) / 257.0 - f64::from(*coarse);
            assert!(difference.abs() <= 0.505, "{mapper}: {coarse} and {fine}");
        }
        let between = fine.iter().filter(|fine| *fine % 257 != 0).count();
        assert!(between > fine.len() / 2, "{mapper}: only {between} values are none of the coarse steps");
    }
}

#[test]
fn pngs_of_16_bits_follow_the_srgb_curve() {
    let folder = folder_with(SCENE);
    let arguments = ["render", "scene.toml", "--device", "cpu", "--tone-mapper", "none", "--exposure", "-1"];
    let output = raggio(folder.path(), &[&arguments[..], &["--png-bits", "16", "-o", "a.png", "-o", "a.exr"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (_, _, values) = read_png(&folder.path().join("a.png"));
    let (_, _, radiance) = read_exr(&folder.path().join("a.exr"));
    assert_eq!(values.len(), 3 * radiance.len());
    for (value, radiance) in values.iter().zip(radiance.as_flattened()) {
        let expected = 65535.0 * srgb(f64::from(*radiance) / 2.0);
        assert!((f64::from(*value) - expected).abs() < 0.51, "{radiance} became {value}, not {expected}");
    }
    // 0.35, 0.4 and 0.5 in sRGB.
    assert_eq!(values[..3], [41039, 43593, 48192]);
}

#[test]
fn denoised_pngs_have_as_many_bits() {
    let folder = folder_with(SCENE);
    let arguments = ["render", "scene.toml", "--device", "cpu", "--denoise", "--png-bits", "16"];
    let errors = text(&raggio(folder.path(), &arguments).stderr);
    if errors.contains("was not found") {
        let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
        assert!(!required, "RAGGIO_TEST_EVERYTHING=1, and {errors}");
        eprintln!("not tested: {errors}");
        return;
    }
    assert_eq!(read_png(&folder.path().join("scene.denoised.png")).0, png::BitDepth::Sixteen);
}

#[test]
fn inputs_are_not_replaced() {
    let folder = folder_with(SCENE);
    let there = |name: &str| folder.path().join(name);
    assert!(raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "sky.exr"]).status.success());
    let model = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(there("model.obj"), model).expect("a model");
    let scene = endless().replace("color = [0.7, 0.8, 1.0]", "image = \"sky.exr\"")
        + "[[shapes]]\nmaterial = \"clay\"\nmesh = { file = \"model.obj\" }\n";
    std::fs::write(there("scene.toml"), &scene).expect("a scene");
    let before = std::fs::read(there("sky.exr")).expect("an image");
    let refused = |arguments: &[&str], message: &str| {
        let render = ["render", "scene.toml", "--device", "cpu"];
        assert_refused(&raggio(folder.path(), &[&render, arguments].concat()), message);
    };
    refused(&["--stats", "scene.toml"], "cannot write scene.toml: it would replace what is read, scene.toml");
    refused(&["--stats", "./scene.toml"], "cannot write ./scene.toml: it would replace what is read, scene.toml");
    refused(&["--stats", "./model.obj"], "cannot write ./model.obj: it would replace what is read, ");
    refused(&["-o", "sky.exr"], "cannot write sky.exr: it would replace what is read, ");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("sky.exr", there("link.exr")).expect("a link");
        refused(&["-o", "link.exr"], "cannot write link.exr: it would replace what is read, ");
        std::os::unix::fs::symlink("scene.toml", there("other.toml")).expect("a link");
        assert_refused(
            &raggio(folder.path(), &["render", "other.toml", "--device", "cpu", "--stats", "scene.toml"]),
            "cannot write scene.toml: it would replace what is read, other.toml",
        );
    }
    assert_eq!(std::fs::read_to_string(there("scene.toml")).expect("the scene"), scene);
    assert_eq!(std::fs::read_to_string(there("model.obj")).expect("the model"), model);
    assert_eq!(std::fs::read(there("sky.exr")).expect("an image"), before);
}

#[test]
fn what_a_model_names_is_not_replaced() {
    let folder = folder_with(SCENE);
    let there = |name: &str| folder.path().join(name);
    assert!(raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "t.png"]).status.success());
    std::fs::write(there("a.mtl"), "newmtl m\nmap_Kd t.png\n").expect("a library");
    let model = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    std::fs::write(there("a.obj"), model).expect("a model");
    std::fs::write(there("a.bin"), [0, 0, 0, 1, 0, 0, 0, 1, 0].map(|x| f32::to_le_bytes(x as f32)).concat())
        .expect("a buffer");
    let gltf = r#"{ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 36, "uri": "a.bin" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }], "scenes": [{ "nodes": [0] }], "scene": 0 }"#;
    std::fs::write(there("a.gltf"), gltf).expect("a model");
    let shape = |file: &str| format!("[[shapes]]\nmaterial = \"clay\"\nmesh = {{ file = \"{file}\" }}\n");
    std::fs::write(there("scene.toml"), endless() + &shape("a.obj") + &shape("a.gltf")).expect("a scene");
    let before = ["t.png", "a.mtl", "a.bin"].map(|name| std::fs::read(there(name)).expect("a file"));
    let refused = |scene: &str, arguments: &[&str], name: &str| {
        let render = ["render", scene, "--device", "cpu", "--samples", "2000000000"];
        let output = raggio(folder.path(), &[&render, arguments].concat());
        assert_refused(&output, &format!("cannot write {name}: it would replace what is read, "));
    };
    for scene in ["scene.toml", "a.obj"] {
        refused(scene, &["-o", "t.png"], "t.png");
        refused(scene, &["--stats", "./a.mtl"], "./a.mtl");
    }
    refused("scene.toml", &["--stats", "a.bin"], "a.bin");
    refused("a.gltf", &["--stats", "a.bin"], "a.bin");
    #[cfg(unix)]
    {
        std::fs::hard_link(there("t.png"), there("same.png")).expect("a link");
        refused("a.obj", &["-o", "same.png"], "same.png");
    }
    std::fs::write(there("a.play"), "wait 1 frames\n").expect("a script");
    let view = ["view", "scene.toml", "--hidden", "--play", "a.play", "--stats", "a.mtl"];
    assert_refused(&raggio(folder.path(), &view), "cannot write a.mtl: it would replace what is read, ");
    assert_eq!(["t.png", "a.mtl", "a.bin"].map(|name| std::fs::read(there(name)).expect("a file")), before);
}

#[test]
fn figures_of_a_script_replace_neither_it_nor_its_scene() {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("a.play"), "wait 1 frames\n").expect("a script");
    for name in ["a.play", "scene.toml"] {
        let view = ["view", "scene.toml", "--hidden", "--play", "a.play", "--stats", name];
        let message = format!("cannot write {name}: it would replace what is read, {name}");
        assert_refused(&raggio(folder.path(), &view), &message);
    }
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder_with(&endless());
    let refused = |arguments: &[&str], message: &str| {
        let render = ["render", "scene.toml", "--device", "cpu"];
        assert_refused(&raggio(folder.path(), &[&render, arguments].concat()), message);
    };
    refused(&["-o", "a.png", "-o", "a.png"], "cannot write a.png: it would replace what goes to a.png");
    refused(&["-o", "a.png", "-o", "./a.png"], "cannot write ./a.png: it would replace what goes to a.png");
    refused(&["-o", "a.exr", "--stats", "a.exr"], "cannot write a.exr: it would replace what goes to a.exr");
    let denoised = ["--denoise", "-o", "a.png", "-o", "a.denoised.png"];
    refused(&denoised, "cannot write a.denoised.png: it would replace what goes to a.denoised.png");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.png", folder.path().join("b.png")).expect("a link to what is not there yet");
        refused(&["-o", "a.png", "-o", "b.png"], "cannot write b.png: it would replace what goes to a.png");
    }
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn what_is_replaced_keeps_its_permissions() {
        let folder = folder_with(SCENE);
        for (name, mode) in [("scene.png", 0o600), ("s.json", 0o664)] {
            std::fs::write(folder.path().join(name), "old").expect("a file");
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(folder.path().join(name), permissions).expect("a mode");
        }
        assert!(
            raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "--stats", "s.json"]).status.success()
        );
        let mode = |name: &str| folder.path().join(name).metadata().expect("a file").permissions().mode() & 0o777;
        assert_eq!([mode("scene.png"), mode("s.json")], [0o600, 0o664]);
        assert!(image::open(folder.path().join("scene.png")).is_ok());
    }

    #[test]
    fn links_to_nothing_are_followed() {
        let folder = folder_with(SCENE);
        std::fs::create_dir(folder.path().join("far")).expect("a folder");
        symlink("near.png", folder.path().join("link.png")).expect("a link");
        symlink("far/there.png", folder.path().join("near.png")).expect("a link");
        let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "link.png"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(folder.path().join("link.png").is_symlink() && folder.path().join("near.png").is_symlink());
        assert!(image::open(folder.path().join("far/there.png")).is_ok());

        symlink("round.png", folder.path().join("round.png")).expect("a link");
        let round = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "round.png"]);
        assert_refused(&round, "cannot write round.png: its links lead nowhere");
    }

    #[test]
    fn links_of_others_in_shared_folders_are_not_followed() {
        let folder = folder_with(&endless());
        let shared = folder.path().join("shared");
        std::fs::create_dir(&shared).expect("a folder");
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o1777)).expect("a mode");
        std::fs::write(folder.path().join("mine"), "mine").expect("a file");
        symlink("../mine", shared.join("a.png")).expect("a link");
        if let Err(error) = std::os::unix::fs::lchown(shared.join("a.png"), Some(65534), None) {
            eprintln!("not tested: only root can make files of others: {error}");
            return;
        }
        let refused = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "shared/a.png"]);
        let reason = "it is a link of another user in a folder that all may write to";
        assert_refused(&refused, &format!("cannot write shared/a.png: {reason}"));
        assert_eq!(std::fs::read_to_string(folder.path().join("mine")).expect("a file"), "mine");

        // In a folder of one's own others cannot put links, so whoever owns one is trusted.
        std::fs::write(folder.path().join("scene.toml"), SCENE).expect("a scene");
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o755)).expect("a mode");
        assert!(
            raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", "shared/a.png"]).status.success()
        );
        assert_eq!(std::fs::read(folder.path().join("mine")).expect("a file")[..4], *b"\x89PNG");
        assert_eq!(shared.join("a.png").symlink_metadata().expect("a link").uid(), 65534);
    }

    #[test]
    fn files_beyond_the_limit_of_their_size_leave_nothing() {
        let folder = folder_with(SCENE);
        let render = "render scene.toml --device cpu --samples 1 --size 640x480 -o a.exr -o b.png";
        let output = Command::new("sh")
            .args(["-c", &format!("ulimit -f 16; '{}' {render}", env!("CARGO_BIN_EXE_raggio"))])
            .current_dir(folder.path())
            .output()
            .expect("sh starts");
        assert_refused(&output, "cannot write a.exr: File too large");
        assert_eq!(files_in(folder.path()), ["scene.toml"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn listings_that_do_not_arrive_are_a_failure() {
        let folder = folder_with(SCENE);
        let commands: [&[&str]; 8] = [
            &["schema"],
            &["devices"],
            &["check", "scene.toml"],
            &["completions", "bash"],
            &["--help"],
            &["--version"],
            &["help", "render"],
            &["render", "--help"],
        ];
        for arguments in commands {
            let full = File::options().write(true).open("/dev/full").expect("a full disk");
            let mut command = program();
            command.args(arguments).current_dir(folder.path()).env("VK_DRIVER_FILES", "/nowhere.json");
            let output = command.stdout(full).output().expect("raggio starts");
            let expected = "error: cannot write to standard output: No space left on device (os error 28)\n";
            assert_eq!((output.status.code(), &*text(&output.stderr)), (Some(2), expected), "{arguments:?}");

            // Whoever has stopped reading has had enough.
            let (reader, writer) = std::io::pipe().expect("a pipe");
            drop(reader);
            let output = command.stdout(writer).output().expect("raggio starts");
            assert_eq!((output.status.code(), &*text(&output.stderr)), (Some(0), ""), "{arguments:?}");
        }
    }

    #[test]
    fn a_folder_that_vanishes_meanwhile_is_made_again() {
        let folder = folder_with(&endless());
        std::fs::create_dir_all(folder.path().join("out/deep")).expect("a folder");
        let mut child = program()
            .args(["render", "scene.toml", "--device", "cpu", "-o", "out/deep/a.png", "--stats", "out/s.json"])
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .expect("raggio starts");
        let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map(|line| line.expect("UTF-8"));
        assert!(lines.by_ref().any(|line| line.contains('%')), "progress is told");
        std::fs::remove_dir_all(folder.path().join("out")).expect("the folder goes");
        let pid = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
        let said: Vec<_> = lines.collect();
        assert_eq!(child.wait().expect("raggio ends").code(), Some(130), "{said:?}");
        assert!(said.contains(&"wrote out/deep/a.png".to_string()), "{said:?}");
        assert!(image::open(folder.path().join("out/deep/a.png")).is_ok());
        assert!(folder.path().join("out/s.json").exists());
    }

    #[test]
    fn a_picture_whose_folder_cannot_be_made_again_is_in_the_current_one() {
        let folder = folder_with(&endless());
        let there = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(there("out/deep")).expect("a folder");
        std::fs::write(there("a.png"), "older").expect("a file");
        let mut child = program()
            .args(["render", "scene.toml", "--device", "cpu", "-o", "out/deep/a.png", "-o", "out/deep/b.exr"])
            .args(["-o", "c.png", "--stats", "out/s.json"])
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .expect("raggio starts");
        let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map(|line| line.expect("UTF-8"));
        assert!(lines.by_ref().any(|line| line.contains('%')), "progress is told");
        std::fs::remove_dir_all(there("out")).expect("the folder goes");
        std::fs::write(there("out"), "in the way").expect("a file in its place");
        let pid = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
        let said: Vec<_> = lines.collect();
        assert_eq!(child.wait().expect("raggio ends").code(), Some(4), "{said:?}");
        for (name, instead) in [("out/deep/a.png", "a-2.png"), ("out/deep/b.exr", "b.exr"), ("out/s.json", "s.json")] {
            let told = |line: &String| {
                line.starts_with(&format!("error: cannot write {name}: "))
                    && line.ends_with(&format!(": it is in {instead} instead"))
            };
            assert_eq!(said.iter().filter(|line| told(line)).count(), 1, "{name}: {said:?}");
        }
        assert_eq!(
            files_in(folder.path()),
            ["a-2.png", "a.png", "a.png.checkpoint", "b.exr", "c.png", "out", "s.json", "scene.toml"],
            "{said:?}"
        );
        let film = "/a.png.checkpoint --resume goes on from it";
        assert!(
            said.iter().any(|line| line.contains("the same command with --checkpoint /") && line.ends_with(film)),
            "{said:?}"
        );
        assert!(image::open(there("a-2.png")).is_ok() && read_exr(&there("b.exr")).0 == 32);
        assert_eq!(std::fs::read_to_string(there("a.png")).expect("a file"), "older");
    }

    #[test]
    fn pipes_are_refused_and_open_files_written_to() {
        let folder = folder_with(SCENE);
        let made = Command::new("mkfifo").arg(folder.path().join("a.png")).status().expect("mkfifo runs");
        assert!(made.success());
        std::os::unix::net::UnixListener::bind(folder.path().join("b.png")).expect("a socket");
        let start = Instant::now();
        let render = |name: &str| raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", name]);
        let remedy = "give a file, or a device such as /dev/null or /dev/stdout";
        assert_refused(&render("a.png"), &format!("cannot write a.png: it is a pipe: {remedy}"));
        assert_refused(&render("b.png"), &format!("cannot write b.png: it is a socket: {remedy}"));
        assert!(start.elapsed() < Duration::from_secs(20));

        // Standard output is a pipe here, and a file there, to which is added.
        let arguments = ["render", "scene.toml", "--device", "cpu", "--stats", "/dev/stdout"];
        let output = raggio(folder.path(), &arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let stats: serde_json::Value = serde_json::from_str(&text(&output.stdout)).expect("JSON");
        assert_eq!(stats["width"], 32);
        let path = folder.path().join("all.json");
        std::fs::write(&path, "before\n").expect("a file");
        let log = File::options().append(true).open(&path).expect("a file");
        let mut command = program();
        command.args(arguments).current_dir(folder.path()).stdout(log).stderr(Stdio::null());
        assert!(command.status().expect("raggio starts").success());
        let mut all = String::new();
        File::open(&path).and_then(|mut file| file.read_to_string(&mut all)).expect("a file");
        assert!(all.starts_with("before\n{"), "{all}");
    }
}

#[test]
fn threads_are_no_more_than_are_of_use() {
    let folder = folder_with(SCENE);
    let device = |threads: &str| {
        let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "--threads", threads]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stderr).lines().next().expect("a line").to_owned()
    };
    let most = std::thread::available_parallelism().map_or(1, usize::from).max(64);
    assert!(device("1").contains("(cpu, 1 thread, "), "{}", device("1"));
    assert!(device("5").contains("(cpu, 5 threads, "), "{}", device("5"));
    assert!(device("4096").contains(&format!("(cpu, {most} threads, ")), "{}", device("4096"));
}

#[test]
fn help_tells_exit_statuses() {
    let here = Path::new(".");
    for arguments in [&["--help"][..], &["render", "--help"]] {
        let help = text(&raggio(here, arguments).stdout);
        for line in ["  0    done", "  2    ", "  3    ", "  4    ", "  129  ", "  130  interrupted", "  143  "] {
            assert!(help.contains(line), "{line} is not in {help}");
        }
    }
}
