//! Portions end in time on every device, whatever paths cost.

use std::time::{Duration, Instant};

use raggio_render::{DeviceScene, Renderer};
use raggio_tests::{for_each_device, parse};

/// White room, seen from inside, whose upper half of the view is a hole: a path there is one ray, and one below has some
/// sixty before it finds the hole.
const ROOM: &str = "render = { width = 512, height = 512, max_depth = 0 }
camera = { position = [0, 0, 0], look_at = [0, 0, -1], vertical_fov_degrees = 40 }
environment = { color = [1, 1, 1] }
materials = { white = { color = [1, 1, 1] } }
shapes = [
    { material = \"white\", rectangle = { corner = [-1, -1, 1], edge_u = [2, 0, 0], edge_v = [0, 2, 0] } },
    { material = \"white\", rectangle = { corner = [-1, -1, -1], edge_u = [2, 0, 0], edge_v = [0, 1, 0] } },
    { material = \"white\", rectangle = { corner = [-1, 0.4, -1], edge_u = [2, 0, 0], edge_v = [0, 0.6, 0] } },
    { material = \"white\", rectangle = { corner = [-1, -1, -1], edge_u = [2, 0, 0], edge_v = [0, 0, 2] } },
    { material = \"white\", rectangle = { corner = [-1, 1, -1], edge_u = [2, 0, 0], edge_v = [0, 0, 2] } },
    { material = \"white\", rectangle = { corner = [-1, -1, -1], edge_u = [0, 2, 0], edge_v = [0, 0, 2] } },
    { material = \"white\", rectangle = { corner = [1, -1, -1], edge_u = [0, 2, 0], edge_v = [0, 0, 2] } },
]
";

#[test]
fn portions_of_dear_paths_after_cheap_ones_are_short() {
    for_each_device(|device| {
        let scene = DeviceScene::new(&parse(ROOM)).expect("the scene fits devices");
        let session = device.device.load(&scene).expect("the scene loads");
        let mut renderer = Renderer::new(session, &scene, 0..1);
        // The first portion waits for the driver's compiler.
        renderer.advance().expect("the device renders");
        let (start, mut longest) = (Instant::now(), Duration::ZERO);
        while !renderer.finished() && start.elapsed() < Duration::from_secs(4) {
            let begun = Instant::now();
            renderer.advance().expect("the device renders");
            longest = longest.max(begun.elapsed());
        }
        let done = renderer.progress().fraction;
        println!("{}: {longest:?} at the longest, {done:.2} of the picture", device.label);
        assert!(done > 0.5, "{}: {done} of the picture: the room was not reached", device.label);
        assert!(longest < Duration::from_secs(2), "{}: a portion took {longest:?}", device.label);
    });
}
