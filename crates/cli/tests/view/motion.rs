//! Pictures of a camera that moves.

use crate::common::project_file;
use crate::view::desk::{Desk, can_draw};

#[test]
fn each_frame_of_a_moving_camera_shows_something_new() {
    if !can_draw() {
        return;
    }
    let scene = std::fs::read_to_string(project_file("scenes/showcase.toml")).expect("the showcase");
    let desk = Desk::new(&scene);
    let script = "\
wait 5 frames
section orbiting
orbit 90 over 40 frames
section end
section flying
hold W 20 frames
section end
size 640x360
wait 2 frames
wait 1 samples
section views
wait 1 frames
view normal
wait 1 frames
view depth
wait 1 frames
view radiance
section end
wait 1 frames
";
    desk.play(script, &["--device", "cpu", "--size", "1280x720"], None);
    let stats: serde_json::Value = serde_json::from_str(&desk.read("stats.json")).expect("stats are JSON");
    let frames = |section: &str| stats["sections"][section]["frames"].as_u64();
    assert_eq!(frames("orbiting"), Some(40), "{stats}");
    // A key that is let go ends its frame, and what follows is in the next.
    assert_eq!(frames("flying"), Some(21), "{stats}");
    assert_eq!(frames("views"), Some(3), "{stats}");
}
