//! Frames without a window: the same ones, on a canvas that nobody sees.

use std::process::Command;

use image::RgbImage;

use crate::common::{files_in, project_file, read_exr};
use crate::view::SCENE;
use crate::view::assert_same_picture;
use crate::view::desk::{Desk, assert_good, can_draw};

#[test]
fn a_scene_that_is_opened_and_saved_stays_as_it_is() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    desk.play("wait 1 samples\nsave", &["--device", "cpu", "--size", "400x200"], None);
    assert_eq!(desk.read("scene.toml"), SCENE);
}

#[test]
fn what_a_model_names_is_read_again_when_it_changes() {
    if !can_draw() {
        return;
    }
    let library = |color: &str| format!("newmtl paint\nKd {color}\n");
    let desk = Desk::new(&format!("{SCENE}[[shapes]]\nmesh = {{ file = \"it.obj\" }}\n"));
    let triangle = "mtllib it.mtl\nv -1 0 1\nv 1 0 1\nv 0 2 1\nusemtl paint\nf 1 2 3\n";
    std::fs::write(desk.path("it.obj"), triangle).expect("the model is written");
    std::fs::write(desk.path("it.mtl"), library("1 0 0")).expect("the library is written");
    let script = "\
stop-at 2
wait 2 samples
export before.exr
screenshot ready.png
wait 1 reloads
wait 2 samples
export after.exr
wait 1 frames
";
    let mut run = desk.start(script, &["--device", "cpu", "--size", "200x120"], None);
    run.wait_for(&desk.path("ready.png"));
    std::fs::write(desk.path("it.mtl"), library("0 0.25 1")).expect("the library is written");
    assert_good(&run.finish());
    desk.assert_valid();
    let (width, height, _) = read_exr(&desk.path("after.exr"));
    desk.render("scene.toml", "again.exr", "cpu", (width, height), 2);
    assert_same_picture(&desk.path("after.exr"), &desk.path("again.exr"));
    let [before, after] = ["before.exr", "after.exr"].map(|name| std::fs::read(desk.path(name)).expect("a picture"));
    assert!(before != after, "the triangle has another colour");
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_program_as_ever() {
    use std::os::unix::process::ExitStatusExt;
    if !can_draw() {
        return;
    }
    for (signal, number) in [("-INT", 2), ("-TERM", 15)] {
        let desk = Desk::new(SCENE);
        let script = "wait 1 samples\nsave saved.toml\nwait 1000 s";
        let mut run = desk.start(script, &["--device", "cpu", "--size", "64x64"], None);
        run.wait_for(&desk.path("saved.toml"));
        let kill = Command::new("kill").args([signal, &run.id().to_string()]).status();
        assert!(kill.expect("kill runs").success());
        assert_eq!(run.finish().status.signal(), Some(number));
        assert_eq!(files_in(desk.folder()), ["saved.toml", "scene.toml", "script.play"]);
    }
}

#[test]
fn scripts_play_on_the_processor_too() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let script = "\
stop-at 4
wait 1 samples
orbit 30 over 10 frames
camera position=[1, 2, 5] look_at=[0,1,0] vertical_fov_degrees=35 aperture_radius=0.05 focus_distance=4
wait 0.4 s
view normal
wait 2 samples
view radiance
wait 4 samples
save saved.toml
export live.exr
wait 1 frames
";
    desk.play(script, &["--device", "cpu", "--size", "420x240"], None);
    let (width, height, _) = read_exr(&desk.path("live.exr"));
    desk.render("saved.toml", "again.exr", "cpu", (width, height), 4);
    assert_same_picture(&desk.path("live.exr"), &desk.path("again.exr"));
}

#[test]
fn files_hold_radiance_whatever_is_looked_at() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let script = "\
stop-at 3
wait 3 samples
view normal
wait 2 samples
reference none
export live.exr
export live.png
export other.exr 50x40 2
wait export
";
    desk.play(script, &["--device", "cpu", "--size", "420x120"], None);
    let (width, height, _) = read_exr(&desk.path("live.exr"));
    desk.render("scene.toml", "again.exr", "cpu", (width, height), 3);
    desk.render("scene.toml", "again.png", "cpu", (width, height), 3);
    desk.render("scene.toml", "other-again.exr", "cpu", (50, 40), 2);
    assert_same_picture(&desk.path("live.exr"), &desk.path("again.exr"));
    assert_same_picture(&desk.path("other.exr"), &desk.path("other-again.exr"));
    let bytes = |name: &str| std::fs::read(desk.path(name)).expect("a picture");
    assert!(bytes("live.png") == bytes("again.png"), "the PNGs differ");
}

/// Scenes with an alpha channel, of whatever camera, are flown through with their background, and exported without.
#[test]
fn exports_have_an_alpha_channel() {
    if !can_draw() {
        return;
    }
    for camera in [
        "vertical_fov_degrees = 40",
        "intrinsics = { focal = [50, 60], principal_point = [18, 10], skew = 1, size = [40, 30] }",
        "panorama = \"latitude-longitude\"",
    ] {
        let desk = Desk::new(
            &SCENE.replace("[camera]", "[render]\nalpha = true\n[camera]").replace("vertical_fov_degrees = 40", camera),
        );
        let script = "\
wait 1 samples
click left 100,60
orbit 30 over 3 frames
stop-at 3
wait 3 samples
save saved.toml
export other.exr 50x40 2
wait export
export other.png 50x40 2
wait export
";
        desk.play(script, &["--device", "cpu", "--size", "420x120"], None);
        desk.render("saved.toml", "again.exr", "cpu", (50, 40), 2);
        let saved = std::fs::read_to_string(desk.path("saved.toml")).expect("a scene");
        assert!(saved.contains(camera) && saved.contains("alpha = true"), "{saved}");
        assert_same_picture(&desk.path("other.exr"), &desk.path("again.exr"));
        desk.render("saved.toml", "again.png", "cpu", (50, 40), 2);
        let read = |name: &str| std::fs::read(desk.path(name)).expect("a file");
        assert!(read("other.png") == read("again.png"), "the PNGs differ");
    }
}

#[test]
fn clicks_choose_shapes_and_leave_the_camera_where_it_is() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    // The red sphere is in the middle; what is deleted is what was clicked.
    let script = "\
wait 1 samples
move 10,10
click left 110,120
wait 2 frames
delete
click left 5,5
delete
save
";
    desk.play(script, &["--device", "cpu", "--size", "540x240"], None);
    let without = SCENE.replace("[[shapes]]\nmaterial = \"clay\"\nsphere = { center = [0, 1, 0], radius = 1 }\n", "");
    assert_eq!(desk.read("scene.toml"), without);
}

#[test]
fn what_a_hand_drags_is_one_step_to_undo() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    // The sphere's radius is there in the panel.
    let script = "\
wait 1 samples
select 2
wait 20 frames
screenshot before.png
drag left 676,625 716,625 over 20 frames
wait 3 frames
save dragged.toml
undo
wait 2 frames
save undone.toml
";
    desk.play(script, &["--device", "cpu", "--size", "900x900"], None);
    assert_ne!(desk.read("dragged.toml"), SCENE, "the drag changes a number");
    assert_eq!(desk.read("undone.toml"), SCENE);
}

#[test]
fn a_script_that_waits_for_what_never_comes_says_so() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let output = desk.start("stop-at 2\nwait 5 samples", &["--device", "cpu", "--size", "64x64"], None).finish();
    crate::common::assert_refused(&output, "waited for 5 samples per pixel, and sampling stopped at 2");
}

#[test]
fn twice_as_many_pixels_in_a_point_draw_the_panel_twice_as_large() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let shot = |name: &str, size: &str, scale: &str| {
        let script = format!("stop-at 1\nwait 1 samples\nexport {name}.exr\nscreenshot {name}.png\nwait 2 frames");
        desk.play(&script, &["--device", "cpu", "--size", size, "--scale", scale], None);
        let picture: RgbImage = image::open(desk.path(&format!("{name}.png"))).expect("a screenshot").to_rgb8();
        let (width, _, _) = read_exr(&desk.path(&format!("{name}.exr")));
        (picture.width() - width as u32, picture)
    };
    let (panel_1, _) = shot("one", "700x400", "1");
    let (panel_2, picture_2) = shot("two", "1400x800", "2");
    assert!(panel_1.abs_diff(panel_2 / 2) <= 2, "{panel_1} and {panel_2} pixels");
    let bright = picture_2.enumerate_pixels().filter(|(x, _, p)| *x > 1400 - panel_2 && p.0[1] > 180).count();
    assert!(bright > 2000, "{bright} bright pixels in the panel");
}

#[test]
fn kernels_are_compiled_again_when_they_change() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    copy(&project_file("kernels"), &desk.path("kernels"));
    let script = "panels\nfill on\nwait 1 samples\nscreenshot ready.png\nwait 1 kernels\nwait 1 samples\nscreenshot after.png\nwait 2 frames";
    let arguments = ["--device", "vulkan", "--size", "64x64", "--watch-kernels", "kernels"];
    let mut run = desk.start(script, &arguments, None);
    run.wait_for(&desk.path("ready.png"));
    let sky = desk.read("kernels/sky.slang");
    // A sky without red.
    let edited = sky.replace("return lerp(", "return float3(0, 1, 1) * lerp(");
    assert_ne!(sky, edited);
    std::fs::write(desk.path("kernels/sky.slang"), edited).expect("the kernel is written");
    crate::view::desk::assert_good(&run.finish());
    desk.assert_valid();
    let corner = |name: &str| image::open(desk.path(name)).expect("a screenshot").to_rgb8().get_pixel(1, 1).0;
    assert!(corner("ready.png")[0] > 100, "{:?}", corner("ready.png"));
    assert!(corner("after.png")[0] < 50, "{:?}", corner("after.png"));
}

fn copy(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).expect("a folder is made");
    for entry in std::fs::read_dir(from).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::write(&target, std::fs::read(&path).expect("a file")).expect("a copy");
        }
    }
}
