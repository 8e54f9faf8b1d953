//! Scripts in a window of a virtual screen.

use image::{Rgb, RgbImage};

use crate::common::read_exr;
use crate::view::SCENE;
use crate::view::assert_same_picture;
use crate::view::desk::{Desk, Screen, assert_good, can_draw};

/// A hand that does a bit of everything: flies, orbits, looks, edits, resizes, saves, exports.
const TOUR: &str = "\
section all
stop-at 3
wait 1 samples
hold W 5 frames
hold Shift+D 3 frames
drag right 200,200 230,210 over 5 frames
drag left 160,160 190,170 over 5 frames
drag middle 160,160 150,165 over 3 frames
wheel 1
wait 2 frames
double-click left 150,190
wait 0.4 s
click left 150,190
wait 3 frames
set materials.clay.color [0.1, 0.6, 0.3]
press Ctrl+Z
press Ctrl+Y
add sphere 0.5,2.2,0 0.3
select none
size 700x480
wait 3 frames
size 900x500
wait 3 frames
size 333x222
wait 3 frames
size 1x1
wait 3 frames
size 640x480
wait 3 frames
minimise
wait 3 frames
restore
wait 3 frames
press F1
wait 2 frames
press F1
press F2
wait 2 frames
press F2
move 5,5
wait 3 samples
save saved.toml
export live.exr
export large.exr 200x150 5
wait export
section end
screenshot window.png
wait 2 frames
";

#[test]
fn a_hand_in_the_window_leaves_a_scene_that_renders_to_the_same_picture() {
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    desk.play(TOUR, &["--device", "vulkan", "--size", "800x500"], Some(&screen));

    let saved = desk.read("saved.toml");
    assert!(saved.contains("color = [0.1, 0.6, 0.3]"), "{saved}");
    assert!(saved.contains("radius = 0.3"), "{saved}");
    assert!(!saved.contains("position = [0, 1, 4]"), "the camera has moved:\n{saved}");

    // The film as it was on the screen, and one that was rendered for the file alone.
    let (width, height, _) = read_exr(&desk.path("live.exr"));
    // The frame of a scene that does not say otherwise, in what the panel leaves of 640 x 480.
    assert_eq!((width, height), (320, 180));
    desk.render("saved.toml", "again.exr", "vulkan", (width, height), 3);
    assert_same_picture(&desk.path("live.exr"), &desk.path("again.exr"));
    desk.render("saved.toml", "large-again.exr", "vulkan", (200, 150), 5);
    assert_same_picture(&desk.path("large.exr"), &desk.path("large-again.exr"));

    // The window shows the picture, pixel for pixel, with the panel to its right.
    desk.render("saved.toml", "again.png", "vulkan", (width, height), 3);
    let window = open(&desk, "window.png");
    let picture = open(&desk, "again.png");
    assert_eq!((window.width(), window.height()), (640, 480));
    // Files are encoded by the CPU, whose powers are rounded in another way: that may be one level.
    let levels = |a: &Rgb<u8>, b: &Rgb<u8>| (0..3).map(|i| a.0[i].abs_diff(b.0[i])).max().unwrap_or_default();
    let top = (480 - height as u32) / 2;
    let farthest = picture.enumerate_pixels().map(|(x, y, pixel)| levels(window.get_pixel(x, top + y), pixel)).max();
    assert!(farthest <= Some(1), "the picture is another on the screen, by {farthest:?} levels");
    // Text is bright on dark, and there is some everywhere.
    let panel: Vec<_> = window.enumerate_pixels().filter(|(x, ..)| *x > width as u32 + 4).collect();
    for quarter in 0..4 {
        let rows = 120 * quarter..120 * (quarter + 1);
        let bright = panel.iter().filter(|(_, y, pixel)| rows.contains(y) && pixel.0[1] > 180).count();
        assert!((60..8000).contains(&bright), "{bright} bright pixels in quarter {quarter} of the panel");
    }

    let stats: serde_json::Value = serde_json::from_str(&desk.read("stats.json")).expect("stats are JSON");
    let all = &stats["sections"]["all"];
    assert!(all["frames"].as_u64() > Some(60), "{stats}");
    assert!(all["median_ms"].as_f64() <= all["percentile_99_ms"].as_f64(), "{stats}");
}

#[test]
fn a_scene_that_changes_on_disk_is_read_again_and_mistakes_leave_the_old_one() {
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    let script = "\
stop-at 2
wait 1 samples
screenshot ready.png
wait 1 reloads
wait 2 samples
export after.exr
wait 1 frames
";
    let mut run = desk.start(script, &["--device", "vulkan", "--size", "640x300"], Some(&screen));
    run.wait_for(&desk.path("ready.png"));
    let replace = |text: &str| {
        // Careful programs write beside the file first.
        std::fs::write(desk.path("new"), text).expect("the scene is written");
        std::fs::rename(desk.path("new"), desk.path("scene.toml")).expect("the scene is replaced");
    };
    replace(&SCENE.replace("radius = 1", "radius = -1"));
    std::thread::sleep(std::time::Duration::from_millis(600));
    replace(&SCENE.replace("radius = 1", "radius = 0.5"));
    // A mistake that was mended is no failure in the end.
    assert_good(&run.finish());
    desk.assert_valid();
    let (width, height, _) = read_exr(&desk.path("after.exr"));
    desk.render("scene.toml", "again.exr", "vulkan", (width, height), 2);
    assert_same_picture(&desk.path("after.exr"), &desk.path("again.exr"));
}

#[test]
fn a_lost_device_is_opened_again() {
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    let script = "\
stop-at 3
wait 3 samples
lose-device
wait 2 frames
wait 3 samples
export after.exr
screenshot after.png
wait 2 frames
";
    desk.play(script, &["--device", "vulkan", "--size", "640x300"], Some(&screen));
    let (width, height, _) = read_exr(&desk.path("after.exr"));
    desk.render("scene.toml", "again.exr", "vulkan", (width, height), 3);
    assert_same_picture(&desk.path("after.exr"), &desk.path("again.exr"));
    // The panels came back with their text.
    let bright = open(&desk, "after.png").enumerate_pixels().filter(|(x, _, p)| *x > 400 && p.0[1] > 180).count();
    assert!(bright > 500, "{bright} bright pixels in the panel");
}

#[test]
fn the_processors_film_is_shown_in_the_same_window() {
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    let script = "fill on\nstop-at 4\nwait 4 samples\nscreenshot window.png\nexport live.exr\nwait 2 frames";
    desk.play(script, &["--device", "cpu", "--size", "640x300"], Some(&screen));
    let (width, height, _) = read_exr(&desk.path("live.exr"));
    desk.render("scene.toml", "again.png", "cpu", (width, height), 4);
    let (window, picture) = (open(&desk, "window.png"), open(&desk, "again.png"));
    assert!(
        picture.enumerate_pixels().all(|(x, y, pixel)| window.get_pixel(x, y) == pixel),
        "the window shows another"
    );
}

fn open(desk: &Desk, name: &str) -> RgbImage {
    image::open(desk.path(name)).unwrap_or_else(|error| panic!("{name}: {error}")).to_rgb8()
}
