//! Pictures that lose their noise in the memory of the device that traced them. A library that pretends to have a GPU there does
//! what is known.

use std::time::{Duration, Instant};

use raggio_kernels::cpu::{Buffers, dispatch};
use raggio_kernels::{EntryPoint, Work};
use raggio_render::{
    Care, Denoised, Denoiser, DeviceScene, Display, Feature, Image, InstructionSet, Pixels, Session, show_bytes,
};
use raggio_scene::Scene;
use raggio_tests::devices::{cpu, lacks, vulkan};
use raggio_tests::for_each_device;
use raggio_tests::render::{displayed, load};

#[path = "../../../crates/denoise/tests/gpus/library.rs"]
mod library;

use crate::views::{assert_alike, still_life};
use library::Pretended;

/// Time that drivers get for the kernels of guides.
const PATIENCE: Duration = Duration::from_secs(600);

fn denoiser(gpu: Pretended) -> Denoiser {
    let denoiser = Denoiser::open_at(library::path()).expect("the library is there");
    denoiser.prefer(&gpu.gpu());
    denoiser
}

/// Red, green and blue of what the session shows without noise; `None` where the denoiser works elsewhere.
fn denoised(session: &mut dyn Session, denoiser: &Denoiser, care: Care) -> Option<Vec<[u8; 3]>> {
    let start = Instant::now();
    loop {
        match session.denoise(denoiser, care, Display::default()).expect("it is denoised") {
            Denoised::Elsewhere => return None,
            Denoised::NotYet => assert!(start.elapsed() < PATIENCE, "the kernels take too long"),
            Denoised::Shown(Pixels::Device(buffer)) => {
                let bytes = buffer.read().expect("the pixels are read");
                return Some(bytes.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect());
            }
            Denoised::Shown(Pixels::Host(_)) => panic!("the pixels are on the device"),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Picture of `samples` samples of a guide, its values as the denoiser gets them.
fn guide(scene: &Scene, feature: Feature, samples: u32) -> Vec<[u8; 3]> {
    let device = vulkan().expect("there was one a moment ago");
    let mut session = load(device, scene);
    session.show(feature).expect("there is room");
    session.add_samples(0..scene.render.height, 0..samples).expect("the device renders");
    let Image { width, height, pixels, .. } = session.film().expect("the film is read").mean();
    let value = |channel: f32| if feature == Feature::GuideNormal { 2.0 * channel - 1.0 } else { channel };
    let pixels = pixels.into_iter().map(|pixel| pixel.map(value)).collect();
    let bytes = show_bytes(&Image { width, height, pixels, alpha: None }, Display::default());
    bytes.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

#[test]
fn a_denoiser_on_the_device_gets_the_picture_and_its_guides() {
    let mut scene = still_life();
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        session.add_samples(0..33, 0..3).expect("samples are added");
        let before = displayed(&mut *session, Display::default());
        let copier = denoiser(Pretended::CopiesColor);
        let Some(found) = denoised(&mut *session, &copier, Care::Quick) else {
            assert!(device.label == "cpu" || copier.fallback().is_some(), "{:?}", copier.place());
            if let Some(sentence) = copier.fallback() {
                lacks(&sentence);
            }
            return;
        };
        assert_eq!(found, before, "what the denoiser leaves alone is the picture");
        assert_eq!(displayed(&mut *session, Display::default()), before, "the film stays as it is");
        // More samples, and more in half of the rows.
        session.add_samples(0..33, 3..4).expect("samples are added");
        session.add_samples(0..20, 4..5).expect("samples are added");
        assert_eq!(
            denoised(&mut *session, &copier, Care::Thorough).expect("as before"),
            displayed(&mut *session, Display::default())
        );
        // Features other than radiance have no noise to lose.
        session.show(Feature::Albedo).expect("there is room");
        assert_eq!(denoised(&mut *session, &copier, Care::Quick), None);
    });
    if vulkan().is_none() {
        return;
    }
    let guides = [(Feature::GuideAlbedo, Pretended::CopiesAlbedo), (Feature::GuideNormal, Pretended::CopiesNormal)];
    for (feature, gpu) in guides {
        let mut session = load(vulkan().expect("there is one"), &scene);
        let copier = denoiser(gpu);
        // Guides get as many samples again each time.
        for (care, samples) in [(Care::Quick, 1), (Care::Thorough, 2), (Care::Quick, 4)] {
            let Some(found) = denoised(&mut *session, &copier, care) else { return };
            assert_alike(&format!("{feature:?}, {samples}"), &guide(&scene, feature, samples), &found, 1);
        }
        // Another view has guides of its own, and so has another size.
        for width in [42, 50] {
            scene.camera.position.x += 0.5;
            scene.render.width = width;
            session.restart(&DeviceScene::new(&scene).expect("it is translated")).expect("it begins anew");
            let found = denoised(&mut *session, &copier, Care::Quick).expect("as before");
            assert_alike(&format!("{feature:?}, {width}"), &guide(&scene, feature, 1), &found, 1);
        }
    }
}

#[test]
fn a_gpu_that_fails_leaves_the_picture_to_the_cpu() {
    let Some(device) = vulkan() else { return };
    let mut session = load(device, &still_life());
    for (gpu, reason) in [
        (Pretended::RunsOutOfMemory, Some("out of memory")),
        (Pretended::RefusesMemory, Some("the memory cannot be imported")),
        (Pretended::TakesNoMemory, None),
        (Pretended::Missing, Some("no physical device found with specified UUID")),
    ] {
        let denoiser = denoiser(gpu);
        for _ in 0..2 {
            assert_eq!(denoised(&mut *session, &denoiser, Care::Quick), None, "{gpu:?}");
        }
        let told = denoiser.fallback();
        assert_eq!(told.as_deref().and_then(|told| told.rsplit(": ").next()), reason, "{told:?}");
    }
    assert_eq!(device.validation_messages(), Vec::<String>::new());
}

/// The kernel that makes means gives what the host makes of the same film, on the CPU too.
#[test]
fn means_of_kernels_are_those_of_the_host() {
    let scene = still_life();
    let mut session = load(cpu(), &scene);
    session.add_samples(0..33, 0..3).expect("samples are added");
    let film = session.film().expect("the film is read");
    for set in InstructionSet::available() {
        let mut output = vec![0; 4 * film.pixels().len()];
        let work = Work { width: 42, height: 33, rows: 33, ..Work::default() };
        let (mut pixels, set) = (film.pixels().to_vec(), set);
        let buffers = Buffers { film: &mut pixels, output: &mut output, ..Buffers::default() };
        dispatch(set, EntryPoint::Means, None, &work, buffers);
        for (found, expected) in output.chunks_exact(4).zip(film.mean().pixels) {
            let found = [0, 1, 2].map(|i| f32::from_bits(found[i]));
            let is_near =
                found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= 1e-6 * expected);
            assert!(is_near, "{}: expected {expected:?}, found {found:?}", set.name());
        }
        assert!(output.iter().skip(3).step_by(4).all(|word| *word == 0));
    }
}
