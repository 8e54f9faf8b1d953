//! Rays, nodes and blocks of a sample, and how full the lanes are: what decides the speed of a path tracer beside the
//! quality of its code.
//!
//! All that is counted is the same in every run, so bounds are as tight as the differences between machines allow, whose
//! sines make other last bits of the rock. Who changes the figures on purpose puts those that the message gives in the place
//! of the old ones, and says in the change what they were: fewer are faster only if each takes no longer.

use raggio_render::{Counted, Counts, DeviceScene, InstructionSet, Walk};
use raggio_scene::{Integrator, Scene};
use raggio_tests::devices::{cpu, lacks};
use raggio_tests::render;

use crate::cost::scene;

/// Size and samples of the example `counts` of raggio-render, which prints the figures anew.
const SIZE: [u32; 2] = [160, 120];
const SAMPLES: u32 = 16;
/// Relative difference to the stated figures that is allowed.
const TOLERANCE: f64 = 0.003;

/// What a sample of a scene takes.
struct Expected {
    name: &'static str,
    rays: f64,
    /// Shapes that are tried one by one.
    tried: f64,
    /// Nodes of eight children, blocks of four triangles, blocks of four closed forms.
    work: [f64; 3],
    /// Part of the lanes that have a path in each of [`STAGES`], for each number of [`LANES`]. Rays of several vectors walk
    /// together.
    occupancy: [[f64; 5]; 3],
}

const WORK: [&str; 3] = ["nodes", "blocks of triangles", "blocks of closed forms"];
const STAGES: [&str; 5] = ["renew", "find", "shadow rays", "walks", "shade"];
const LANES: [u32; 3] = [4, 8, 16];

const SCENES: [Expected; 4] = [
    Expected {
        name: "cornell",
        rays: 7.663,
        tried: 61.30,
        work: [0.0; 3],
        occupancy: [
            [0.900, 1.000, 0.859, 0.0, 0.971],
            [0.790, 0.999, 0.826, 0.0, 0.937],
            [0.776, 0.998, 0.821, 0.0, 0.934],
        ],
    },
    Expected {
        name: "weekend",
        rays: 2.526,
        tried: 0.0,
        work: [7.366, 0.0, 4.543],
        occupancy: [
            [0.946, 1.000, 0.0, 0.969, 0.965],
            [0.881, 0.999, 0.0, 0.967, 0.922],
            [0.875, 0.998, 0.0, 0.966, 0.915],
        ],
    },
    Expected {
        name: "spheres",
        rays: 2.276,
        tried: 9.104,
        work: [0.0; 3],
        occupancy: [[0.955, 1.000, 0.0, 0.0, 0.965], [0.902, 0.999, 0.0, 0.0, 0.922], [0.895, 0.998, 0.0, 0.0, 0.917]],
    },
    Expected {
        name: "rock",
        rays: 1.821,
        tried: 0.0,
        work: [4.477, 2.474, 0.0],
        occupancy: [
            [0.968, 1.000, 0.0, 0.998, 0.962],
            [0.929, 1.000, 0.0, 0.998, 0.913],
            [0.922, 0.999, 0.0, 0.997, 0.907],
        ],
    },
];

fn count(name: &str, set: InstructionSet, walk: Walk) -> Counted {
    let mut scene = scene(name);
    scene.render.integrator = Integrator::Path;
    [scene.render.width, scene.render.height] = SIZE;
    let scene = DeviceScene::new(&scene).expect("the scene fits devices");
    Counted::render(&scene, set, walk, SAMPLES).expect("the level is available")
}

/// Asserts that a figure is the stated one.
#[track_caller]
fn assert_stated(scene: &str, what: &str, stated: f64, found: f64) {
    assert!(
        (found - stated).abs() <= TOLERANCE * stated,
        "{scene}, {what}: {stated} are stated, and there are {found:.4}. If this is meant, and `make bench` says that it is \
         no slower, put what `cargo run --release -p raggio-render --example counts` prints of the scenes of \
         tests/tests/cost/counts.rs in the place of the figures there"
    );
}

#[test]
fn samples_take_what_is_stated() {
    for Expected { name, rays, tried, work, occupancy } in SCENES {
        for set in InstructionSet::available() {
            let found = count(name, set, Walk::Wide);
            let of_sample = |count: u64| count as f64 / found.samples as f64;
            assert_stated(name, "rays of a sample", rays, of_sample(found.rays));
            assert_stated(name, "shapes tried for a sample", tried, of_sample(found.rays * u64::from(found.tried)));
            let counts = found.counts;
            if walks_wide(set) {
                let met = [counts.nodes, counts.triangle_blocks, counts.shape_blocks];
                for ((what, stated), met) in WORK.into_iter().zip(work).zip(met) {
                    assert_stated(name, &format!("{what} of a sample"), stated, of_sample(met));
                }
            }
            // Kernels of single paths have no stages.
            let Some(place) = LANES.iter().position(|lanes| *lanes == set.lanes()) else { continue };
            let stages = [counts.renew, counts.find, counts.shadow, counts.walk, counts.shade];
            for ((stage, stated), calls) in STAGES.into_iter().zip(occupancy[place]).zip(stages) {
                let what = format!("part of {} lanes with a path in {stage}", set.lanes());
                assert_stated(name, &what, stated, calls.occupancy(set.lanes()));
            }
        }
    }
    if !InstructionSet::available().into_iter().any(walks_wide) {
        lacks("rays walk through nodes of eight children on processors with AVX2 alone");
    }
}

fn walks_wide(set: InstructionSet) -> bool {
    matches!(set, InstructionSet::X86V3 | InstructionSet::X86V4)
}

/// Rays that take turns do what they do one by one, but for the order of boxes that they enter at one distance; levels differ in
/// their lanes alone, and counting leaves no trace in the film.
#[test]
fn counts_depend_on_the_scene_alone() {
    for name in ["weekend", "rock"] {
        let mut scene = scene(name);
        [scene.render.width, scene.render.height] = SIZE;
        let film = render(cpu(), &scene, SAMPLES);
        let mut alone: Option<[u64; 3]> = None;
        for walk in [Walk::Wide, Walk::InTurn] {
            let mut first = None;
            for set in InstructionSet::available().into_iter().filter(|set| walks_wide(*set)) {
                let found = count(name, set, walk);
                assert!(found.film.pixels() == film.pixels(), "{name}: who counts renders another picture");
                let Counts { nodes, triangle_blocks, shape_blocks, walk: walks, .. } = found.counts;
                let work = [nodes, triangle_blocks, shape_blocks];
                assert_eq!(*first.get_or_insert(work), work, "{name}, {set:?}, {walk:?}");
                for (alone, work) in alone.get_or_insert(work).iter().zip(work) {
                    assert!(
                        alone.abs_diff(work) <= alone / 1000,
                        "{name}, {set:?}, {walk:?}: {work} in place of {alone}"
                    );
                }
                // Rays of the whole queue, eight vectors, go together.
                let together = walks.occupancy(set.lanes());
                assert!(
                    if walk == Walk::Wide { together <= 1.0 } else { together > 7.0 },
                    "{name}, {set:?}: {together}"
                );
            }
        }
    }
}

/// A triangle takes 48 bytes for its corners, 4 for its material, and those of one hierarchy: wide nodes come in the place of
/// binary ones. What grows from one rock to the next is of triangles alone.
#[test]
fn triangles_take_no_more_bytes_than_stated() {
    let scenes = [5, 6].map(|level| DeviceScene::new(&Scene::rock(level)).expect("the scene fits devices"));
    let triangles = (scenes[1].triangles() - scenes[0].triangles()) as f64;
    for set in InstructionSet::available() {
        for walk in [Walk::Wide, Walk::Portable] {
            let bytes = |scene: &DeviceScene| {
                Counted::render(scene, set, walk, 0).expect("the level is available").bytes as f64
            };
            let is_wide = walk == Walk::Wide && walks_wide(set);
            let [fewer, more] = [&scenes[0], &scenes[1]].map(bytes);
            let (stated, found) = (if is_wide { 63.1 } else { 78.8 }, (more - fewer) / triangles);
            assert_stated("rock", &format!("bytes of a triangle, {set:?}, {walk:?}"), stated, found);
        }
    }
}
