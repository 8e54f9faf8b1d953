//! Contract 2: what `raggio render` writes and says.

use std::path::Path;

use crate::common::{SCENE, assert_refused, files_in, folder_with, program, project_file, raggio, read_exr, text};

#[test]
fn without_output_the_picture_is_named_after_the_scene() {
    let folder = folder_with(SCENE);
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(files_in(folder.path()), ["scene.png", "scene.toml"]);
    let picture = image::open(folder.path().join("scene.png")).expect("a PNG");
    assert_eq!((picture.width(), picture.height()), (32, 24));
}

/// A decoder of images that gives up on damaged bytes is no fault of the program: the picture is made without the image.
#[test]
fn images_on_which_decoders_give_up_are_left_out() {
    let folder = folder_with(SCENE);
    let image = project_file("crates/images/tests/data/texel-dimension.ktx2");
    std::fs::copy(image, folder.path().join("damaged.ktx2")).expect("the image is copied");
    let model = r#"{ "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "images": [{ "uri": "damaged.ktx2" }],
        "textures": [{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }] }"#;
    std::fs::write(folder.path().join("model.gltf"), model).expect("the model is written");
    for arguments in [&["check", "model.gltf"][..], &["render", "model.gltf", "--size", "8x8", "--samples", "1"]] {
        let output = raggio(folder.path(), arguments);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{errors}");
        let warning = "image 0 is left out: it is a KTX2 that is damaged: its decoder gave up on what it holds";
        assert!(errors.contains(warning), "{errors}");
        assert!(!errors.contains("fault of its own"), "{errors}");
    }
    assert!(folder.path().join("model.png").exists());
}

#[test]
fn several_outputs_hold_the_same_picture() {
    let folder = folder_with(SCENE);
    let arguments = ["render", "scene.toml", "--device", "cpu", "-o", "a.png", "-o", "b.exr", "--tone-mapper", "none"];
    assert!(raggio(folder.path(), &arguments).status.success());
    assert_eq!(files_in(folder.path()), ["a.png", "b.exr", "scene.toml"]);

    let (width, height, pixels) = read_exr(&folder.path().join("b.exr"));
    assert_eq!((width, height), (32, 24));
    // The top left pixel sees the sky alone, in linear float; (0,0) is the top left in both.
    assert_eq!(pixels[0], [0.7, 0.8, 1.0]);
    let png = image::open(folder.path().join("a.png")).expect("a PNG").to_rgb8();
    // 0.7, 0.8 and 1 in sRGB.
    assert_eq!(png.get_pixel(0, 0).0, [218, 231, 255]);
}

#[test]
fn the_command_line_overrides_the_scene() {
    let folder = folder_with(SCENE);
    let arguments = [
        "render",
        "scene.toml",
        "--device",
        "cpu",
        "--threads",
        "1",
        "--size",
        "20x30",
        "--samples",
        "3",
        "--max-depth",
        "2",
        "--seed",
        "9",
        "--integrator",
        "reference",
        "--quiet",
        "--stats",
        "s.json",
        "-o",
        "a.exr",
    ];
    let output = raggio(folder.path(), &arguments);
    assert!(output.status.success());
    assert_eq!(text(&output.stderr), "", "--quiet says nothing");

    let (width, height, _) = read_exr(&folder.path().join("a.exr"));
    assert_eq!((width, height), (20, 30));
    let stats = std::fs::read_to_string(folder.path().join("s.json")).expect("stats");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    let keys: Vec<_> = stats.as_object().expect("an object").keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        [
            "device",
            "denoiser",
            "tracer",
            "width",
            "height",
            "samples_per_pixel",
            "max_depth",
            "setup_seconds",
            "read_seconds",
            "open_seconds",
            "translate_seconds",
            "upload_seconds",
            "compile_seconds",
            "compile_wait_seconds",
            "render_seconds",
            "film_seconds",
            "layers_seconds",
            "write_seconds",
            "denoise_seconds",
            "total_seconds",
            "samples_per_second",
            "rays",
            "rays_per_second",
            "peak_memory_bytes",
            "triangles",
            "shapes",
            "most_samples_per_pixel",
            "clamped_share",
        ]
    );
    assert_eq!(stats["tracer"], "software", "the CPU has no other");
    assert_eq!((&stats["width"], &stats["height"]), (&20.into(), &30.into()));
    assert_eq!((&stats["samples_per_pixel"], &stats["max_depth"], &stats["shapes"]), (&3.into(), &2.into(), &1.into()));
    let seconds = |key: &str| stats[key].as_f64().expect("seconds");
    let parts = ["read", "open", "translate", "upload", "compile_wait"].map(|part| seconds(&format!("{part}_seconds")));
    assert!(parts.iter().all(|part| *part >= 0.0) && parts.iter().sum::<f64>() <= seconds("setup_seconds"), "{stats}");
    let after = ["film", "layers", "write"].map(|part| seconds(&format!("{part}_seconds")));
    let all = seconds("setup_seconds") + seconds("render_seconds") + after.iter().sum::<f64>();
    assert!(after.iter().all(|part| *part >= 0.0) && all <= seconds("total_seconds"), "{stats}");
    assert_eq!([&stats["denoise_seconds"], &stats["denoiser"]], [&serde_json::Value::Null; 2]);
    assert_eq!(seconds("compile_seconds"), 0.0, "the CPU's kernels are part of the program");
    let rays = stats["rays"].as_u64().expect("a count");
    // Each sample traces the camera's ray, and at most one more.
    assert!((1800..=3600).contains(&rays), "{rays} rays");
}

#[test]
fn size_keeps_the_vertical_field_of_view() {
    let folder = folder_with(SCENE);
    let heights: Vec<_> = ["32x24", "64x24"]
        .iter()
        .map(|size| {
            let arguments = ["render", "scene.toml", "--device", "cpu", "--size", size, "-o", "a.exr"];
            assert!(raggio(folder.path(), &arguments).status.success());
            let (width, height, pixels) = read_exr(&folder.path().join("a.exr"));
            // Rows in which the middle column sees the sphere, which is not as blue as the sky.
            (0..height).filter(|y| pixels[y * width + width / 2][2] < 0.9).count()
        })
        .collect();
    assert_eq!(heights[0], heights[1]);
    assert!(heights[0] > 5);
}

#[test]
fn exposure_brightens_the_png_alone() {
    let folder = folder_with(SCENE);
    let scene = ["render", "scene.toml", "--device", "cpu", "--tone-mapper", "none"];
    let plain = [&scene[..], &["-o", "a.png", "-o", "a.exr"]].concat();
    let darker = [&scene[..], &["--exposure", "-1", "-o", "b.png", "-o", "b.exr"]].concat();
    assert!(raggio(folder.path(), &plain).status.success());
    assert!(raggio(folder.path(), &darker).status.success());
    let read = |name| std::fs::read(folder.path().join(name)).expect("a file");
    assert_eq!(read("a.exr"), read("b.exr"));
    let png = image::open(folder.path().join("b.png")).expect("a PNG").to_rgb8();
    // 0.35, 0.4 and 0.5 in sRGB.
    assert_eq!(png.get_pixel(0, 0).0, [160, 170, 188]);
}

#[test]
fn each_tone_mapper_is_another_picture_of_the_same_film() {
    let folder = folder_with(SCENE);
    let mut pictures = vec![];
    for mapper in ["neutral", "agx", "aces", "filmic", "reinhard", "none"] {
        let arguments = ["render", "scene.toml", "--device", "cpu", "--tone-mapper", mapper, "-o", "a.png"];
        assert!(raggio(folder.path(), &arguments).status.success(), "{mapper}");
        let picture = std::fs::read(folder.path().join("a.png")).expect("a file");
        assert!(!pictures.contains(&picture), "{mapper} is one of the others");
        pictures.push(picture);
    }
}

#[test]
fn progress_is_plain_lines_where_there_is_no_terminal() {
    let folder = folder_with(SCENE);
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]);
    let said = text(&output.stderr);
    assert!(said.contains("32x24, 4 samples on "), "{said}");
    assert!(said.contains(" rays in ") && said.contains("rays/s"), "{said}");
    assert!(said.contains("wrote scene.png"), "{said}");
    assert!(!said.contains('\u{1b}') && !said.contains('\r'), "no terminal codes: {said:?}");
}

#[test]
fn warnings_are_told_and_do_not_stop_the_render() {
    let folder = folder_with(&SCENE.replace("[environment]\ncolor = [0.7, 0.8, 1.0]\n", ""));
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]);
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("warning: scene.toml:"), "{}", text(&output.stderr));
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_rendering() {
    // So many samples that the test would not end if it rendered first.
    let folder = folder_with(&SCENE.replace("samples = 4", "samples = 2000000000"));
    let refused = |output: &str, message: &str| {
        assert_refused(&raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "-o", output]), message);
    };
    refused(
        "a.jpg",
        "a.jpg: the ending must be .png (for looking at), .exr (linear radiance) or .film (sums of samples)",
    );
    refused("a", "a: the ending must be");
    refused("nowhere/a.png", "cannot write nowhere/a.png: ");
    std::fs::create_dir(folder.path().join("d.png")).expect("a folder");
    refused("d.png", "cannot write d.png: ");
    assert_eq!(files_in(folder.path()), ["d.png", "scene.toml"]);
}

#[test]
fn an_existing_picture_is_replaced_whole() {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("scene.png"), "old").expect("a file");
    assert!(raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]).status.success());
    assert!(image::open(folder.path().join("scene.png")).is_ok());
    assert_eq!(files_in(folder.path()), ["scene.png", "scene.toml"], "no temporary file stays behind");
}

#[cfg(unix)]
#[test]
fn a_picture_can_be_read_by_whom_any_new_file_can() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder_with(SCENE);
    assert!(raggio(folder.path(), &["render", "scene.toml", "--device", "cpu"]).status.success());
    let mode = |name: &str| std::fs::metadata(folder.path().join(name)).expect("a file").permissions().mode() & 0o777;
    assert_eq!(mode("scene.png"), mode("scene.toml"));
}

#[cfg(unix)]
#[test]
fn interrupting_writes_what_there_is() {
    use std::io::{BufRead, BufReader};
    let folder = folder_with(&SCENE.replace("samples = 4", "samples = 2000000000"));
    let mut child = program()
        .args(["render", "scene.toml", "--device", "cpu", "--stats", "s.json"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("raggio starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map(|line| line.expect("UTF-8"));
    // The first line of progress comes after two seconds: samples, rate, time left.
    let progress = lines.by_ref().find(|line| line.contains('%')).expect("progress is told");
    let told = ["/2000000000 samples  ", " M samples/s  ", " left"].iter().all(|part| progress.contains(part));
    assert!(told, "{progress}");

    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
    let said: Vec<_> = lines.collect();
    assert_eq!(child.wait().expect("raggio ends").code(), Some(130), "{said:?}");
    let stopped =
        |line: &String| line.starts_with("stopped early: ") && line.contains(" of 2000000000 samples per pixel");
    assert!(said.iter().any(stopped), "{said:?}");
    let saved =
        "stopped by SIGINT: what there is is saved in scene.png.checkpoint: the same command with --resume goes on";
    assert!(said.iter().any(|line| line.starts_with(saved)), "{said:?}");
    assert_eq!(files_in(folder.path()), ["s.json", "scene.png", "scene.png.checkpoint", "scene.toml"]);
    let picture = image::open(folder.path().join("scene.png")).expect("a PNG").to_rgb8();
    assert_ne!(picture.get_pixel(16, 23).0, [0, 0, 0], "the last row has samples too");
    let stats = std::fs::read_to_string(folder.path().join("s.json")).expect("stats");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    assert!(stats["samples_per_pixel"].as_u64().expect("a count") > 0);
}

#[cfg(unix)]
#[test]
fn a_closed_standard_error_does_not_stop_the_render() {
    let folder = folder_with(SCENE);
    let status = std::process::Command::new("sh")
        .args(["-c", &format!("'{}' render scene.toml --device cpu 2>&-", env!("CARGO_BIN_EXE_raggio"))])
        .current_dir(folder.path())
        .status()
        .expect("sh starts");
    assert!(status.success());
    assert!(image::open(folder.path().join("scene.png")).is_ok());
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_left_alone() {
    let folder = folder_with(SCENE);
    std::fs::write(folder.path().join("target.png"), "old").expect("a file");
    std::os::unix::fs::symlink("target.png", folder.path().join("link.png")).expect("a link");
    let arguments = ["render", "scene.toml", "--device", "cpu", "-o", "link.png", "--stats", "/dev/null"];
    let output = raggio(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(folder.path().join("link.png").is_symlink());
    assert!(image::open(folder.path().join("target.png")).is_ok());
    assert!(!Path::new("/dev/null").metadata().expect("the null device").is_file());
}

#[test]
fn dots_in_a_name_stay() {
    let folder = folder_with("");
    std::fs::write(folder.path().join("room.v2.toml"), SCENE).expect("a file");
    assert!(raggio(folder.path(), &["render", "room.v2.toml", "--device", "cpu"]).status.success());
    assert!(folder.path().join("room.v2.png").exists());
}

#[test]
fn statistics_that_cannot_be_written_are_refused_before_rendering() {
    let folder = folder_with(&SCENE.replace("samples = 4", "samples = 2000000000"));
    let output = raggio(folder.path(), &["render", "scene.toml", "--device", "cpu", "--stats", "nowhere/s.json"]);
    assert_refused(&output, "cannot write nowhere/s.json: ");
}

/// Hardware traces the rays of whoever asks for it: software Vulkan passes for it where it answers ray queries.
#[test]
fn tracers_are_chosen() {
    let folder = folder_with(SCENE);
    let render = |arguments: &[&str]| {
        let stats = ["render", "scene.toml", "-o", "a.exr", "--stats", "s.json"];
        program()
            .args([&stats, arguments].concat())
            .env("RAGGIO_VALIDATE", "1")
            .current_dir(folder.path())
            .output()
            .expect("raggio starts")
    };
    let tracer = || {
        let stats = std::fs::read_to_string(folder.path().join("s.json")).expect("stats");
        serde_json::from_str::<serde_json::Value>(&stats).expect("JSON")["tracer"].as_str().map(str::to_owned)
    };
    let hardware = render(&["--device", "vulkan", "--tracer", "hardware"]);
    let said = text(&hardware.stderr);
    if !hardware.status.success() {
        // Errors of devices; the first is of machines without Vulkan.
        let known = ["Vulkan", "traces rays by hardware", "RAGGIO_VALIDATE"].iter().any(|words| said.contains(words));
        assert!(hardware.status.code() == Some(3) && known, "{said}");
        let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
        assert!(!required, "RAGGIO_TEST_EVERYTHING=1, scripts/setup.sh --tests installs Mesa 25, and {said}");
        eprintln!("not tested: {said}");
        return;
    }
    assert!(!said.contains("vulkan validation"), "{said}");
    assert_eq!(tracer().as_deref(), Some("hardware"));
    let ours = read_exr(&folder.path().join("a.exr"));
    assert!(render(&["--device", "vulkan", "--tracer", "software"]).status.success());
    assert_eq!(tracer().as_deref(), Some("software"));
    let theirs = read_exr(&folder.path().join("a.exr"));
    let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-4;
    assert!(ours.2.as_flattened().iter().zip(theirs.2.as_flattened()).all(near));
}

#[test]
fn automatic_choice_renders_everywhere_and_validation_is_silent() {
    let folder = folder_with(SCENE);
    let output = program()
        .args(["render", "scene.toml"])
        .env("RAGGIO_VALIDATE", "1")
        .current_dir(folder.path())
        .output()
        .expect("raggio starts");
    let said = text(&output.stderr);
    if said.contains("needs the Vulkan validation layers") {
        // Validation layers that are missing are told, not passed over.
        assert_eq!(output.status.code(), Some(3));
        return;
    }
    assert!(output.status.success() && !said.contains("vulkan validation"), "{said}");
    // Software Vulkan is never chosen by itself.
    assert!(!said.contains("llvmpipe"), "{said}");
}

#[test]
fn the_demo_writes_the_showcase() {
    let folder = folder_with("");
    let output = raggio(folder.path(), &["demo", "--device", "cpu", "--size", "64x36", "--samples", "2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("wrote showcase.png"));
    assert!(image::open(folder.path().join("showcase.png")).is_ok());
}

#[test]
fn every_scene_of_the_project_passes_its_check() {
    let mut checked = 0;
    for folder in ["scenes", "scenes/guide", "scenes/notes", "scenes/reference"] {
        for entry in std::fs::read_dir(project_file(folder)).expect("the scenes") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|e| e == "toml") {
                let output = raggio(Path::new("."), &["check", path.to_str().expect("a name")]);
                assert!(output.status.success(), "{}", text(&output.stderr));
                assert_eq!(text(&output.stderr), "", "no warnings");
                checked += 1;
            }
        }
    }
    assert!(checked > 20, "only {checked} scenes found");
}

#[test]
fn the_same_render_is_the_same_file() {
    let folder = folder_with(SCENE);
    let render = |name: &str| {
        // Large enough for several blocks of an EXR, which threads compress at once.
        let arguments = ["render", "scene.toml", "--device", "cpu", "--size", "200x150", "--samples", "2", "-o", name];
        assert!(raggio(folder.path(), &arguments).status.success());
        std::fs::read(folder.path().join(name)).expect("a picture")
    };
    let first = render("0.exr");
    for again in 1..4 {
        assert!(render(&format!("{again}.exr")) == first, "run {again} wrote another file");
    }
}
