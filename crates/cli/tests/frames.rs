//! Frames of animations: which are rendered, where they go, and what is done already.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{SCENE, assert_refused, files_in, folder_with, program, raggio, read_exr, text};

/// The small scene with a camera that goes to the right by 2 within the first second.
fn moving() -> String {
    SCENE.replace(
        "vertical_fov_degrees = 40",
        "vertical_fov_degrees = 40
interpolation = \"linear\"
keyframes = [{ time = 0, position = [0, 1, 4] }, { time = 1, position = [2, 1, 4] }]",
    )
}

fn render(folder: &Path, arguments: &[&str]) -> Output {
    raggio(folder, &[&["render", "scene.toml", "--device", "cpu"], arguments].concat())
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = render(folder, arguments);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    said
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn count(said: &str, what: &str) -> usize {
    said.matches(what).count()
}

#[test]
fn each_frame_is_the_still_of_its_moment() {
    let folder = folder_with(&moving());
    let folder = folder.path();
    let said =
        succeeds(folder, &["--frames", "1-3,7", "--fps", "8", "-o", "f-###.exr", "-o", "f-#.png", "-o", "f#.film"]);
    let names = ["001", "002", "003", "007"].map(|number| format!("f-{number}.exr"));
    assert_eq!(files_in(folder).iter().filter(|name| name.ends_with(".exr")).cloned().collect::<Vec<_>>(), names);
    assert!(["f-1.png", "f-7.png", "f1.film", "f7.film"].iter().all(|name| folder.join(name).exists()));
    assert_eq!(count(&said, "on AMD") + count(&said, " on "), 1 + count(&said, "on AMD"), "one device: {said}");
    for (name, time) in [("f-001.exr", "0"), ("f-002.exr", "0.125"), ("f-007.exr", "0.75")] {
        succeeds(folder, &["--time", time, "-o", "still.exr"]);
        assert!(read_exr(&folder.join(name)) == read_exr(&folder.join("still.exr")), "{name}");
    }
    assert!(read_exr(&folder.join("f-001.exr")) != read_exr(&folder.join("f-002.exr")));
    // A sequence may begin elsewhere, and a still without a time is its first frame.
    succeeds(folder, &["--time", "0.5", "--frames", "3", "--fps", "8", "-o", "later.exr"]);
    assert!(read_exr(&folder.join("later.exr")) == read_exr(&folder.join("f-007.exr")));
    succeeds(folder, &["-o", "still.film"]);
    succeeds(folder, &["--frames", "1", "-o", "first.film"]);
    let merged = raggio(folder, &["merge", "still.film", "first.film", "-o", "a.png"]);
    assert!(text(&merged.stderr).contains("both films have samples 0..4"), "{}", text(&merged.stderr));
}

#[test]
fn without_an_output_frames_are_named_after_the_scene() {
    let folder = folder_with(&moving());
    succeeds(folder.path(), &["--frames", "2,12-14:2"]);
    assert_eq!(files_in(folder.path()), ["scene-0002.png", "scene-0012.png", "scene-0014.png", "scene.toml"]);
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_rendered() {
    let folder = folder_with(&moving());
    let folder = folder.path();
    let refused = |arguments: &[&str], message: &str| assert_refused(&render(folder, arguments), message);
    let one = "cannot write 3 frames to a.png: each needs its number in the name, as in a-####.png";
    refused(&["--frames", "1-3", "-o", "a.png"], one);
    refused(&["--frames", "1-3", "-o", "b-#.exr", "-o", "a.png"], one);
    refused(&["--frames", "1-3", "-o", "#.png", "--stats", "s.json"], "as in s-####.json");
    refused(&["--frames", "1-3", "-o", "#.png", "--checkpoint", "k"], "as in k-####");
    refused(&["--frames", "0-3"], "there is no frame 0: frames are counted from 1, which is the moment 0");
    refused(&["--frames", "1-3", "--fps", "0"], "give frames a second from 0.001 to 1000");
    refused(&["--overwrite"], "--frames <RANGE>");
    refused(&["--frames", "1-3", "-o", "no/such/#.png"], "cannot write no/such/1.png");
    refused(&["--frames", "1-3", "-o", "#.png", "--aov", "depth"], "--aov writes layers, which only .exr has");
    refused(&["--frames", "1-3", "-o", "#.png", "--video", "a.avi"], "--video a.avi: the ending must be .mp4");
    refused(&["--frames", "1-3", "-o", "#.png", "-o", "#.png"], "it would replace what goes to 1.png");
    assert_eq!(files_in(folder), ["scene.toml"]);
    let output = program()
        .args(["render", "scene.toml", "--frames", "1-3", "--video", "a.mp4"])
        .current_dir(folder)
        .env("PATH", folder)
        .output()
        .expect("raggio starts");
    assert_refused(
        &output,
        "--video needs the program ffmpeg, which is not on the PATH: install it, or leave --video out",
    );
    assert_eq!(files_in(folder), ["scene.toml"]);
}

#[test]
fn whole_frames_are_not_rendered_again() {
    let folder = folder_with(&moving());
    let folder = folder.path();
    let all = ["--frames", "1-3", "--fps", "8", "-o", "#.exr", "-o", "#.png", "-o", "#.film", "--aov", "depth"];
    let names: Vec<String> =
        (1..=3).flat_map(|frame| ["exr", "png", "film"].map(|ending| format!("{frame}.{ending}"))).collect();
    let contents = || names.iter().map(|name| bytes(folder, name)).collect::<Vec<_>>();
    assert!(succeeds(folder, &all).contains("3 frames rendered"));
    let before = contents();
    let rendered = |arguments: &[&str], frames: &[u32]| {
        let said = succeeds(folder, arguments);
        for frame in 1..=3 {
            let is_done = said.contains(&format!("frame {frame} is done: {frame}.exr"));
            assert_eq!(is_done, !frames.contains(&frame), "{frame} of {frames:?}: {said}");
        }
    };
    rendered(&all, &[]);
    rendered(&[&all[..], &["--overwrite"]].concat(), &[1, 2, 3]);
    assert!(contents() == before, "the same frames");

    // Half a file, another file, and none at all.
    std::fs::write(folder.join("1.exr"), &before[0][..before[0].len() - 40]).expect("half an EXR");
    rendered(&all, &[1]);
    std::fs::write(folder.join("2.png"), &before[4][..before[4].len() - 14]).expect("half a PNG");
    std::fs::write(folder.join("1.film"), &before[2][..before[2].len() / 2]).expect("half a film");
    rendered(&all, &[1, 2]);
    std::fs::write(folder.join("3.png"), &before[1]).expect("frame 1's picture");
    std::fs::remove_file(folder.join("2.film")).expect("it is there");
    rendered(&all, &[2, 3]);
    assert!(contents() == before, "the same frames");

    // A film that others were added to is not the frame any more.
    succeeds(folder, &["--frames", "1", "--fps", "8", "--samples", "4..6", "-o", "more.film"]);
    let merged = raggio(folder, &["merge", "1.film", "more.film", "-o", "sum.film"]);
    assert!(merged.status.success(), "{}", text(&merged.stderr));
    std::fs::rename(folder.join("sum.film"), folder.join("1.film")).expect("the sum is there");
    rendered(&all, &[1]);

    // Other settings, another look and other layers: each makes stale what it changes.
    rendered(&[&all[..], &["--seed", "1"]].concat(), &[1, 2, 3]);
    rendered(&[&all[..], &["--seed", "1", "--exposure", "1"]].concat(), &[1, 2, 3]);
    rendered(&all, &[1, 2, 3]);
    rendered(&[&all[..10], &["--aov", "depth,normal"]].concat(), &[1, 2, 3]);
    rendered(&all[..10], &[1, 2, 3]);
    let png = ["--frames", "1-3", "--fps", "8", "-o", "#.png"];
    let said = succeeds(folder, &png);
    assert_eq!(count(&said, "is done"), 3, "layers are nothing to a PNG: {said}");
    let said = succeeds(folder, &["--frames", "1-3", "--fps", "16", "-o", "#.png"]);
    assert_eq!(count(&said, "is done"), 1, "frame 1 is the same moment: {said}");
    succeeds(folder, &[&png[..], &["--samples", "5"]].concat());
    std::fs::write(folder.join("scene.toml"), moving().replace("0.8, 0.4", "0.8, 0.5")).expect("the scene changes");
    assert_eq!(count(&succeeds(folder, &[&png[..], &["--samples", "5"]].concat()), "is done"), 0);
    std::fs::write(folder.join("scene.toml"), format!("# A comment.\n{}", moving().replace("0.8, 0.4", "0.8, 0.5")))
        .expect("a comment");
    assert_eq!(count(&succeeds(folder, &[&png[..], &["--samples", "5"]].concat()), "is done"), 3);
}

#[test]
fn stills_know_nothing_of_frames() {
    let folder = folder_with(SCENE);
    succeeds(folder.path(), &["-o", "a.exr", "-o", "a#.png"]);
    assert_eq!(files_in(folder.path()), ["a#.png", "a.exr", "scene.toml"]);
    assert!(!String::from_utf8_lossy(&bytes(folder.path(), "a.exr")).contains("fingerprint"));
    let said = succeeds(folder.path(), &["--frames", "1-2", "-o", "b#.exr"]);
    assert!(said.contains("frames are asked for, but nothing in the scene moves"), "{said}");
    assert_eq!(count(&said, "nothing in the scene moves"), 1, "{said}");
    assert!(String::from_utf8_lossy(&bytes(folder.path(), "b1.exr")).contains("fingerprint"));
}

/// Values of a layer's channel.
fn channel(path: &Path, name: &str) -> Vec<f32> {
    use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
    let image = read_first_flat_layer_from_file(path).expect("an EXR");
    let channels = &image.layer_data.channel_data.list;
    let found = channels.iter().find(|channel| channel.name.to_string() == name).expect("the channel is there");
    let FlatSamples::F32(values) = &found.sample_data else { panic!("{name} is of another type") };
    values.clone()
}

/// The camera goes to the right by 0.5 in each frame, before a wall at the distance 4 and by 1 along the view: what is seen was
/// further to the right in the picture a frame before, by the focal length in pixels times an eighth.
#[test]
fn motion_is_that_since_the_frame_before() {
    let wall = moving()
        .replace("sphere = { center = [0, 1, 0], radius = 1 }", "plane = { point = [0, 0, 0], normal = [0, 0, 1] }");
    let look = "{ time = 0, position = [0, 1, 4], look_at = [0, 1, 0] }, { time = 1, position = [2, 1, 4], look_at = [2, 1, 0] }";
    let wall = wall.replace("{ time = 0, position = [0, 1, 4] }, { time = 1, position = [2, 1, 4] }", look);
    let folder = folder_with(&wall);
    let folder = folder.path();
    let all = ["--fps", "4", "-o", "#.exr", "--aov", "motion,depth"];
    succeeds(folder, &[&["--frames", "1-3"], &all[..]].concat());
    let of = |frame: u32, axis: &str| channel(&folder.join(format!("{frame}.exr")), &format!("motion.{axis}"));
    let expected = 12.0 / 20f32.to_radians().tan() * 0.5 / 4.0;
    for frame in 1..=3 {
        let expected = if frame == 1 { 0.0 } else { expected };
        assert!(of(frame, "X").iter().all(|x| (x - expected).abs() < 1e-3), "frame {frame}: {:?}", of(frame, "X")[0]);
        assert!(of(frame, "Y").iter().all(|y| y.abs() < 1e-4), "frame {frame}");
    }
    // The frame before need not be among those that are rendered, and a whole frame stays one.
    let before = bytes(folder, "3.exr");
    assert!(succeeds(folder, &[&["--frames", "3"], &all[..]].concat()).contains("frame 3 is done"));
    succeeds(folder, &[&["--frames", "3", "--overwrite"], &all[..]].concat());
    assert!(bytes(folder, "3.exr") == before);
    // With a time, frame 1 has one before it; a still has none.
    succeeds(folder, &[&["--frames", "1", "--time", "0.5"], &all[..]].concat());
    assert!((of(1, "X")[0] - expected).abs() < 1e-3);
    succeeds(folder, &["--time", "0.5", "-o", "still.exr", "--aov", "motion"]);
    assert!(channel(&folder.join("still.exr"), "motion.X").iter().all(|x| *x == 0.0));
}

/// A triangle of a model that rises by 3 a second, before a camera that stands still.
#[test]
fn models_move_from_frame_to_frame() {
    let model = r#"{ "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 68, "uri": "model.bin" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 68 }],
        "accessors": [
          { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-9, -9, 0], "max": [9, 9, 0] },
          { "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
          { "bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "VEC3" }
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }],
        "animations": [{
          "samplers": [{ "input": 1, "output": 2 }],
          "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }]
        }] }"#;
    let scene = SCENE.replace("sphere = { center = [0, 1, 0], radius = 1 }", "mesh = { file = \"model.gltf\" }");
    let folder = folder_with(&scene);
    let folder = folder.path();
    std::fs::write(folder.join("model.gltf"), model).expect("a model");
    let floats = [-9.0, -9.0, 0.0, 9.0, -9.0, 0.0, 0.0, 9.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0];
    std::fs::write(folder.join("model.bin"), floats.map(f32::to_le_bytes).concat()).expect("its buffer");
    succeeds(folder, &["--frames", "1-4", "--fps", "6", "-o", "#.exr", "--aov", "motion,position"]);
    // Half a unit a frame, at the distance 4.
    let expected = -12.0 / 20f32.to_radians().tan() * 0.5 / 4.0;
    for frame in 2..=4 {
        let [x, y] = ["X", "Y"].map(|axis| channel(&folder.join(format!("{frame}.exr")), &format!("motion.{axis}")));
        let middle = 12 * 32 + 16;
        assert!(x[middle].abs() < 1e-4 && (y[middle] - expected).abs() < 1e-3, "{}, {}", x[middle], y[middle]);
    }
    let said = succeeds(folder, &["--frames", "1-4", "--fps", "6", "-o", "#.exr", "--aov", "motion,position"]);
    assert_eq!(count(&said, "is done"), 4, "{said}");
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} does not come", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A signal keeps what is done, and the frame that it ends goes on from its checkpoint.
#[cfg(unix)]
#[test]
fn a_sequence_that_is_stopped_goes_on() {
    let slow = moving().replace("width = 32\nheight = 24\nsamples = 4", "width = 64\nheight = 48\nsamples = 3000");
    let folder = folder_with(&slow);
    let folder = folder.path();
    let quick = ["--frames", "1-2", "--fps", "4", "-o", "#.exr", "--samples", "2"];
    succeeds(folder, &quick);
    let all = ["--frames", "1-2", "--fps", "4", "-o", "#.exr", "--checkpoint-every", "1samples"];
    let child = program()
        .args(["render", "scene.toml", "--device", "cpu"])
        .args(all)
        .args(["--overwrite"])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .spawn()
        .expect("raggio starts");
    wait_for(&folder.join("2.exr.checkpoint"));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    let output = child.wait_with_output().expect("raggio ends");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("wrote 1.exr"), "{said}");
    assert!(
        said.contains("what there is is saved in 2.exr.checkpoint: the same command with --resume goes on"),
        "{said}"
    );
    assert!(!folder.join("1.exr.checkpoint").exists());
    // The picture of what there was by then is there, and is not taken for the frame.
    assert!(folder.join("2.exr").exists());
    let said = succeeds(folder, &[&all[..], &["--resume"]].concat());
    assert!(said.contains("frame 1 is done"), "{said}");
    assert!(said.contains("going on from 2.exr.checkpoint, which has"), "{said}");
    assert!(said.contains("1 frame rendered") && said.contains("1 done before"), "{said}");
    assert_eq!(files_in(folder), ["1.exr", "2.exr", "scene.toml"]);
    succeeds(folder, &["--frames", "2", "--fps", "4", "-o", "alone.exr"]);
    assert!(bytes(folder, "2.exr") == bytes(folder, "alone.exr"));
}

#[test]
fn progress_tells_the_frame_and_the_fraction_of_all() {
    let folder = folder_with(&moving());
    let said = succeeds(folder.path(), &["--frames", "1-4", "-o", "#.png", "--progress", "json"]);
    let lines: Vec<serde_json::Value> =
        said.lines().map(|line| serde_json::from_str(line).expect("each line is JSON")).collect();
    let figures: Vec<_> = lines.iter().filter(|line| line.get("phase").is_some()).collect();
    let fractions: Vec<f64> = figures.iter().map(|line| line["fraction"].as_f64().expect("a number")).collect();
    assert!(fractions.is_sorted(), "{fractions:?}");
    for line in &figures {
        let (frame, done) = (line["frame"].as_f64().expect("a frame"), line["frames_done"].as_f64().expect("frames"));
        assert_eq!(line["frames"], 4);
        assert_eq!(frame, done + 1.0);
        let fraction = line["fraction"].as_f64().expect("a number");
        assert!((done / 4.0..=(done + 1.0) / 4.0).contains(&fraction), "{line}");
    }
    let last = figures.last().expect("figures");
    assert_eq!((&last["phase"], &last["fraction"]), (&"done".into(), &1.0.into()));
    let again = succeeds(folder.path(), &["--frames", "1-4", "-o", "#.png", "--progress", "json"]);
    let last: serde_json::Value = serde_json::from_str(again.lines().last().expect("a line")).expect("JSON");
    assert_eq!((&last["phase"], &last["fraction"]), (&"done".into(), &1.0.into()));
    let openjd = render(folder.path(), &["--frames", "1-4", "-o", "b#.png", "--progress", "openjd"]);
    let said = text(&openjd.stdout);
    for percent in ["0.00", "25.00", "50.00", "75.00", "100"] {
        assert!(said.contains(&format!("openjd_progress: {percent}\n")), "{percent}: {said}");
    }
}

/// Folder for the PATH with a stand-in for ffmpeg: it notes its arguments and all bytes that it gets.
#[cfg(unix)]
fn stand_in(script: &str) -> (tempfile::TempDir, String) {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ffmpeg");
    std::fs::write(&path, script).expect("a script");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("it may run");
    let paths = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap_or_default());
    (folder, paths)
}

#[cfg(unix)]
fn with_path(folder: &Path, path: &str, arguments: &[&str]) -> Output {
    program()
        .args(["render", "scene.toml", "--device", "cpu"])
        .args(arguments)
        .current_dir(folder)
        .env("PATH", path)
        .output()
        .expect("raggio starts")
}

/// Input of ffmpeg are the frames' pictures in the order of time, odd sizes with a copy of the last row and column.
#[cfg(unix)]
#[test]
fn a_video_is_made_of_the_pictures() {
    let folder = folder_with(&moving().replace("width = 32\nheight = 24", "width = 31\nheight = 23"));
    let folder = folder.path();
    let (scripts, path) = stand_in(
        "#!/bin/sh\nif [ \"$2\" = -encoders ]; then echo ' V....D libx264 '; exit 0; fi\n\
         echo \"$@\" > \"$(dirname \"$0\")/arguments\"\nfor last; do :; done\ncat > \"$last\"\n",
    );
    let arguments = ["--frames", "3,1-2", "--fps", "12.5", "-o", "#.png", "-o", "#.exr", "--video", "all.mp4"];
    let output = with_path(folder, &path, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut expected = vec![];
    for frame in 1..=3 {
        let picture = image::open(folder.join(format!("{frame}.png"))).expect("a PNG").into_rgb8();
        for y in 0..24 {
            (0..32).for_each(|x| expected.extend(picture.get_pixel(x.min(30), y.min(22)).0));
        }
    }
    assert!(bytes(folder, "all.mp4") == expected);
    let said = std::fs::read_to_string(scripts.path().join("arguments")).expect("the arguments");
    for part in ["-video_size 32x24 ", "-framerate 12.5 ", "-c:v libx264 ", "format=yuv420p", "-f mp4 "] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // EXRs alone are shown as their PNGs would be; all that is there is not rendered again.
    let output = with_path(folder, &path, &["--frames", "1-3", "--fps", "12.5", "-o", "#.exr", "--video", "exr.mp4"]);
    assert!(text(&output.stderr).contains("3 done before"), "{}", text(&output.stderr));
    assert!(bytes(folder, "exr.mp4") == expected);
}

#[cfg(unix)]
#[test]
fn a_video_that_fails_leaves_the_one_before() {
    let folder = folder_with(&moving());
    let folder = folder.path();
    let fails = "#!/bin/sh\nif [ \"$2\" = -encoders ]; then echo ' V....D libx264 '; exit 0; fi\n\
                 for last; do :; done\nhead -c 9 > \"$last\"\necho 'out of luck' >&2\nexit 1\n";
    let (_scripts, path) = stand_in(fails);
    std::fs::write(folder.join("a.mp4"), "before").expect("a file");
    let output = with_path(folder, &path, &["--frames", "1-2", "-o", "#.png", "--video", "a.mp4"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("error: cannot write a.mp4: ffmpeg has failed: out of luck"), "{said}");
    assert_eq!(bytes(folder, "a.mp4"), b"before");
    assert_eq!(files_in(folder), ["1.png", "2.png", "a.mp4", "scene.toml"]);
    let (_scripts, path) = stand_in("#!/bin/sh\necho nothing\n");
    let output = with_path(folder, &path, &["--frames", "1-2", "-o", "#.png", "--video", "a.mp4"]);
    assert_refused(&output, "--video needs an ffmpeg with the encoder libx264, which the one on the PATH lacks");
}

/// The real ffmpeg, where there is one: it says itself what it has made, and the colours come back.
#[test]
fn ffmpeg_makes_a_video() {
    let encoders = Command::new("ffmpeg").args(["-hide_banner", "-encoders"]).output();
    if !encoders.is_ok_and(|output| text(&output.stdout).contains("libx264")) {
        eprintln!("not checked: there is no ffmpeg with libx264");
        return;
    }
    let folder = folder_with(&moving().replace("width = 32\nheight = 24", "width = 63\nheight = 47"));
    let folder = folder.path();
    succeeds(folder, &["--frames", "1-6", "--fps", "25", "-o", "#.png", "--video", "a.mp4"]);
    let run = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).current_dir(folder).output().expect("it starts");
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let keys = "stream=codec_name,pix_fmt,width,height,r_frame_rate,nb_frames,color_space,color_range";
    let found = run("ffprobe", &["-v", "error", "-show_entries", keys, "-of", "csv=p=0", "a.mp4"]);
    assert_eq!(found.trim(), "h264,64,48,yuv420p,tv,bt709,25/1,6");
    run("ffmpeg", &["-v", "error", "-i", "a.mp4", "back-%d.png"]);
    for frame in [1, 6] {
        let open = |name: String| image::open(folder.join(name)).expect("a PNG").into_rgb8();
        let (there, back) = (open(format!("{frame}.png")), open(format!("back-{frame}.png")));
        let off: u64 = there
            .enumerate_pixels()
            .map(|(x, y, pixel)| (0..3).map(|c| u64::from(pixel.0[c].abs_diff(back.get_pixel(x, y).0[c]))).sum::<u64>())
            .sum();
        let mean = off as f64 / (3.0 * 63.0 * 47.0);
        assert!(mean < 4.0, "frame {frame} is off by {mean} of 255 on average");
    }
    let left: Vec<PathBuf> =
        files_in(folder).into_iter().filter(|name| name.starts_with('.')).map(PathBuf::from).collect();
    assert_eq!(left, Vec::<PathBuf>::new());
}
