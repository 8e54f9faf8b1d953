//! The picture's place in the window, and what is beside and over it.

use image::RgbImage;

use crate::common::read_exr;
use crate::view::SCENE;
use crate::view::assert_same_picture;
use crate::view::desk::{Desk, can_draw};

const SQUARE: &str = "version = 1\n[render]\nwidth = 120\nheight = 120\n";

/// A scene whose frame is a square.
fn square() -> String {
    SCENE.replace("version = 1\n", SQUARE)
}

fn open(desk: &Desk, name: &str) -> RgbImage {
    image::open(desk.path(name)).unwrap_or_else(|error| panic!("{name}: {error}")).to_rgb8()
}

#[test]
fn the_window_shows_the_scenes_own_frame_on_grey() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(&square());
    let script = "\
panels
stop-at 2
wait 2 samples
screenshot fitting.png
export fitting.exr
fill on
wait 2 frames
wait 2 samples
export filling.exr
scene-size on
wait 2 frames
wait 2 samples
export sized.exr
wait 1 frames
";
    desk.play(script, &["--device", "cpu", "--size", "300x200"], None);
    let size = |name: &str| {
        let (width, height, _) = read_exr(&desk.path(name));
        [width, height]
    };
    assert_eq!(["fitting.exr", "filling.exr", "sized.exr"].map(size), [[200, 200], [300, 200], [120, 120]]);
    desk.render("scene.toml", "again.png", "cpu", (200, 200), 2);
    let (window, picture) = (open(&desk, "fitting.png"), open(&desk, "again.png"));
    assert!(picture.enumerate_pixels().all(|(x, y, pixel)| window.get_pixel(50 + x, y) == pixel), "another picture");
    let beside = window.enumerate_pixels().filter(|(x, ..)| !(50..250).contains(x));
    let colors: Vec<_> = beside.map(|(.., pixel)| pixel.0).collect();
    let grey = colors[0];
    assert!(grey[0] == grey[1] && grey[1] == grey[2] && grey[0] < 60, "{grey:?}");
    assert!(colors.iter().all(|color| *color == grey), "something is beside the picture");
}

#[test]
fn a_click_beside_the_picture_meets_nothing_and_one_at_its_edge_what_is_seen_there() {
    if !can_draw() {
        return;
    }
    // The ground fills the lower half of the frame up to its sides.
    let desk = Desk::new(&square());
    let script = "\
panels
wait 1 samples
select 2
wait 1 frames
click left 45,195
delete
save unchanged.toml
click left 55,195
wait 1 frames
delete
save without-ground.toml
";
    desk.play(script, &["--device", "cpu", "--size", "300x200"], None);
    assert_eq!(desk.read("unchanged.toml"), square());
    let ground = "[[shapes]] # the ground\nmaterial = \"clay\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    assert_eq!(desk.read("without-ground.toml"), square().replace(ground, ""));
}

#[test]
fn what_the_window_writes_is_what_the_program_writes() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(&square());
    let script = "\
scene-size on
stop-at 5
wait 5 samples
export live.exr
export rendered.exr 90x60 3
wait export
";
    desk.play(script, &["--device", "cpu", "--size", "400x300"], None);
    // The scene's own size.
    let arguments = ["render", "scene.toml", "--device", "cpu", "--samples", "5", "-o", "again.exr"];
    let rendered = crate::common::raggio(desk.folder(), &arguments);
    assert!(rendered.status.success(), "{}", crate::common::text(&rendered.stderr));
    desk.render("scene.toml", "rendered-again.exr", "cpu", (90, 60), 3);
    assert_same_picture(&desk.path("live.exr"), &desk.path("again.exr"));
    assert_same_picture(&desk.path("rendered.exr"), &desk.path("rendered-again.exr"));
}

#[test]
fn a_small_window_is_the_pictures_and_its_help_fits() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let script = "\
stop-at 1
wait 1 samples
set materials.clay.colour [1, 0, 0]
wait 1 frames
screenshot small.png
export small.exr
help
wait 3 frames
screenshot help.png
help
size 700x300
wait 2 frames
wait 1 samples
screenshot wide.png
export wide.exr
wait 1 frames
";
    let output = desk.start(script, &["--device", "cpu", "--size", "400x300"], None).finish();
    // The edit that fails leaves a message that no screenshot shows.
    crate::common::assert_refused(&output, "did you mean `color`?");
    let size = |name: &str| {
        let (width, height, _) = read_exr(&desk.path(name));
        (width, height)
    };
    assert_eq!([size("small.exr"), size("wide.exr")], [(400, 225), (380, 214)]);
    desk.render("scene.toml", "again.png", "cpu", (400, 225), 1);
    let (small, picture) = (open(&desk, "small.png"), open(&desk, "again.png"));
    // The picture's place begins at a half, which is rounded.
    let top = (300 - 225_u32).div_ceil(2);
    assert!(
        picture.enumerate_pixels().all(|(x, y, pixel)| small.get_pixel(x, top + y) == pixel),
        "something is over it"
    );
    let (help, wide) = (open(&desk, "help.png"), open(&desk, "wide.png"));
    // The table's frame ends inside of the window on all sides.
    let edge = |x: u32, y: u32| x < 4 || y < 4 || x >= 396 || y >= 296;
    let differs = |(x, y, pixel): &(u32, u32, &image::Rgb<u8>)| small.get_pixel(*x, *y) != *pixel;
    let changed: Vec<_> = help.enumerate_pixels().filter(differs).collect();
    assert!(changed.len() > 30_000, "the help covers {} pixels", changed.len());
    assert!(!changed.iter().any(|(x, y, _)| edge(*x, *y)), "the help reaches over the window");
    let bright = wide.enumerate_pixels().filter(|(x, _, pixel)| *x > 384 && pixel.0[1] > 180).count();
    assert!(bright > 300, "{bright} bright pixels in the panel");
}

#[test]
fn a_hint_at_the_start_tells_of_the_help() {
    if !can_draw() {
        return;
    }
    let desk = Desk::new(SCENE);
    let script = "stop-at 1\nwait 1 samples\nscreenshot plain.png\npress F12\nwait 3 frames";
    desk.play(script, &["--device", "cpu", "--size", "300x200"], None);
    // What a hand takes shows the window as the user sees it.
    let (plain, window) = (open(&desk, "plain.png"), open(&desk, "scene-window-1.png"));
    let changed: Vec<_> = window.enumerate_pixels().filter(|(x, y, pixel)| plain.get_pixel(*x, *y) != *pixel).collect();
    assert!(changed.len() > 2000, "{} pixels", changed.len());
    assert!(changed.iter().all(|(_, y, _)| *y > 120), "the hint is at the bottom");
    assert!(changed.iter().filter(|(.., pixel)| pixel.0[1] > 180).count() > 50, "it has a text");
}
