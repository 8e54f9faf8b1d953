//! Films in files: whole again after a journey, and refused where a bit is missing or where they do not go together.

use std::fs;
use std::ops::Range;
use std::path::Path;

use raggio_render::{
    CpuDevice, CpuOptions, Device, DeviceScene, Feature, Film, FilmError, MergeError, Portion, Renderer,
};
use raggio_scene::{Scene, Vec3};

const WIDTH: u32 = 6;
const HEIGHT: u32 = 5;

fn scene() -> Scene {
    let text = "version = 1\n[render]\nwidth = 6\nheight = 5\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\n\
                vertical_fov_degrees = 60\n[environment]\ncolor = [0.5, 0.7, 1]\n[materials.a]\n[[shapes]]\n\
                material = \"a\"\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    Scene::parse(text, "scene.toml").expect("the scene is right")
}

fn renderer(scene: &Scene, samples: Range<u32>) -> Renderer {
    let device = CpuDevice::new(CpuOptions::default()).expect("threads can be had");
    let device_scene = DeviceScene::new(scene).expect("the scene fits devices");
    let session = device.load(&device_scene).expect("the scene loads");
    Renderer::new(session, &device_scene, samples)
}

fn film(scene: &Scene, samples: Range<u32>) -> Film {
    let mut renderer = renderer(scene, samples);
    while !renderer.finished() {
        renderer.advance().expect("the device renders");
    }
    renderer.labelled_film().expect("the film can be read")
}

fn bytes(film: &Film) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.film");
    film.write(&path).expect("the folder is there");
    fs::read(path).expect("the film is there")
}

/// Error of reading these bytes.
fn refused(bytes: &[u8]) -> FilmError {
    read(bytes).expect_err("these bytes are no film")
}

fn read(bytes: &[u8]) -> Result<Film, FilmError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.film");
    fs::write(&path, bytes).expect("the folder is there");
    Film::read(&path)
}

#[test]
fn films_come_back_as_they_were() {
    let film = film(&scene(), 3..7);
    let back = read(&bytes(&film)).expect("the file is whole");
    assert_eq!(back, film);
    assert_eq!(film.to_bytes().expect("it has a label"), bytes(&film), "in memory as in files");
    assert_eq!(Film::from_bytes(&bytes(&film), Path::new("a")).expect("they are whole"), film);
    let damaged = Film::from_bytes(&bytes(&film)[1..], Path::new("a")).expect_err("the first byte is missing");
    assert_eq!(damaged.to_string(), "a: not a film of raggio");
    assert!(matches!(Film::new(2, 2).to_bytes(), Err(FilmError::Unlabelled)));
    assert_eq!((back.width(), back.height(), back.samples()), (WIDTH, HEIGHT, 4 * u64::from(WIDTH * HEIGHT)));
    let label = back.label().expect("films in files have labels");
    assert_eq!(label.portions(), [Portion { samples: 3..7, rows: 0..HEIGHT }]);
    let settings: Vec<_> = label.settings().collect();
    for setting in [("integrator", "path"), ("seed", "0"), ("max_depth", "10"), ("noise", "none"), ("clamp", "none")] {
        assert!(settings.contains(&setting), "{setting:?} is not in {settings:?}");
    }
}

/// Parts of a render, from wherever they come, are the file of the whole, byte for byte.
#[test]
fn parts_in_files_merge_to_the_file_of_the_whole() {
    let scene = scene();
    let parts = [8..11, 0..3, 3..8].map(|range| read(&bytes(&film(&scene, range))).expect("the file is whole"));
    let [mut merged, others @ ..] = parts;
    for other in &others {
        merged.merge(other).expect("other samples of one picture");
    }
    assert_eq!(bytes(&merged), bytes(&film(&scene, 0..11)));
}

/// A film in the middle of a pass says so, row by row.
#[test]
fn unfinished_passes_are_told_by_row() {
    let mut scene = scene();
    // So many that one call cannot take them all: the first guess at the speed gives less than a pass.
    (scene.render.width, scene.render.height) = (400, 300);
    let mut renderer = renderer(&scene, 0..2);
    renderer.advance_for(1e-4).expect("the device renders");
    let film = renderer.labelled_film().expect("the film can be read");
    let [portion] = film.label().expect("a label").portions() else { panic!("one portion") };
    assert_eq!((portion.samples.clone(), portion.rows.start), (0..1, 0));
    let rows = portion.rows.end;
    assert!((1..300).contains(&rows), "{rows} rows");
    let sampled = |row: u32| film.pixels()[(row * 400) as usize].samples;
    assert_eq!((sampled(rows - 1), sampled(rows)), (1, 0));
}

#[test]
fn looking_at_a_feature_does_not_change_the_film() {
    let scene = scene();
    let mut renderer = renderer(&scene, 0..4);
    while !renderer.finished() {
        renderer.advance().expect("the device renders");
    }
    renderer.show(Feature::Normal).expect("the device shows normals");
    renderer.advance().expect("the device renders");
    assert_eq!(renderer.labelled_film().expect("the film can be read"), film(&scene, 0..4));
    assert_eq!(renderer.feature() as u32, Feature::Normal as u32);
}

#[test]
fn films_that_do_not_go_together_are_refused_with_the_reason() {
    let mut base = film(&scene(), 0..4);
    let unchanged = base.clone();
    let mut merge = |change: fn(&mut Scene), samples: Range<u32>| {
        let mut scene = scene();
        change(&mut scene);
        base.merge(&film(&scene, samples)).expect_err("the films do not go together")
    };
    assert_eq!(merge(|_| (), 3..6), MergeError::Overlap(Portion { samples: 3..4, rows: 0..HEIGHT }));
    assert_eq!(merge(|scene| scene.camera.position = Vec3::new(0.1, 0.0, 3.0), 4..6), MergeError::Scene);
    assert_eq!(merge(|scene| scene.materials[0].color = Vec3::ONE, 4..6), MergeError::Scene);
    assert_eq!(merge(|scene| scene.render.height = 6, 4..6), MergeError::Size([6, 5], [6, 6]));
    type Change = fn(&mut Scene);
    let changes: [(Change, &str); 8] = [
        (|scene| scene.render.seed = 1, "seed"),
        (|scene| scene.render.max_depth = 3, "max_depth"),
        (|scene| scene.render.clamp = Some(2.0), "clamp"),
        (|scene| scene.render.filter = raggio_scene::Filter::Mitchell, "filter"),
        (|scene| scene.render.sampler = raggio_scene::Sampler::Pcg, "sampler"),
        (|scene| scene.render.integrator = raggio_scene::Integrator::Reference, "integrator"),
        (|scene| scene.render.alpha = true, "alpha"),
        (|scene| scene.render.surface_offset = false, "surface_offset"),
    ];
    for (change, expected) in changes {
        match merge(change, 4..6) {
            MergeError::Setting { key, .. } => assert_eq!(key, expected),
            other => panic!("{expected}: {other}"),
        }
    }
    let unlabelled = Film::new(WIDTH, HEIGHT);
    assert_eq!(base.merge(&unlabelled), Err(MergeError::Unlabelled));
    assert_eq!(base, unchanged, "what is refused changes nothing");
    base.merge(&film(&scene(), 4..6)).expect("other samples of one picture");
}

#[test]
fn noise_is_a_setting() {
    let scene = scene();
    let mut other = renderer(&scene, 4..8);
    other.set_noise(0.5);
    let other = other.labelled_film().expect("the film can be read");
    let error = film(&scene, 0..4).merge(&other).expect_err("one of the films is adaptive");
    assert_eq!(error.to_string(), "the films differ in noise: `none` and `0.5`");
}

#[test]
fn a_file_that_is_cut_short_anywhere_is_refused() {
    let bytes = bytes(&film(&scene(), 0..2));
    for length in 0..bytes.len() {
        match refused(&bytes[..length]) {
            FilmError::NotAFilm { .. } => assert!(length < 8, "{length} bytes"),
            FilmError::Damaged { reason, .. } => assert!(length >= 8 && reason.contains("cut short"), "{reason}"),
            other => panic!("{length} bytes: {other}"),
        }
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(refused(&longer).to_string().contains("goes on after its end"));
}

#[test]
fn every_bit_counts() {
    let bytes = bytes(&film(&scene(), 0..2));
    for place in 0..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[place] ^= 1 << (place % 8);
        let error = refused(&flipped);
        assert!(!matches!(error, FilmError::Unreadable { .. }), "byte {place}: {error}");
    }
}

#[test]
fn sizes_are_not_believed() {
    let bytes = bytes(&film(&scene(), 0..2));
    let with = |place: usize, word: u32| {
        let mut changed = bytes.clone();
        changed[place..place + 4].copy_from_slice(&word.to_le_bytes());
        refused(&changed)
    };
    assert!(matches!(with(8, 4), FilmError::Version { found: 4, .. }));
    assert!(matches!(with(12, 0), FilmError::Damaged { .. }));
    assert!(matches!(with(12, 1 << 17), FilmError::Damaged { .. }));
    // A list of four thousand million entries, where the version's text is.
    assert!(matches!(with(52, u32::MAX), FilmError::Damaged { .. }));
    let mut huge = bytes.clone();
    huge[12..20].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
    assert!(matches!(refused(&huge), FilmError::TooLarge { .. } | FilmError::Damaged { .. }));
}

#[test]
fn what_cannot_be_read_or_written_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("nowhere/a.film");
    let film = film(&scene(), 0..1);
    assert!(matches!(film.write(&path), Err(FilmError::Unwritable { .. })));
    assert!(matches!(Film::read(&path), Err(FilmError::Unreadable { .. })));
    assert!(matches!(Film::read(folder.path()), Err(FilmError::Unreadable { .. })));
    assert!(matches!(Film::new(2, 2).write(&folder.path().join("a.film")), Err(FilmError::Unlabelled)));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/showcase.toml");
    let error = Film::read(&scene).expect_err("a scene is no film");
    assert!(error.to_string().ends_with("showcase.toml: not a film of raggio"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).expect("the folder is there").count(), 0, "nothing is left behind");
}
