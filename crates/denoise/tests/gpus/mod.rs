//! Denoisers on GPUs: those of a library that pretends to have some, and those that there are.

mod library;

use raggio_denoise::{DenoiseError, Denoiser, Interface, Noisy};

use super::{SIDE, denoiser, error, picture};
use library::Pretended;

/// Most that a pixel of the GPU's picture may differ from that of the CPU's, relative to its brightness: GPUs compute in half
/// precision.
const MOST_DIFFERENCE: f32 = 0.02;

fn pretended() -> Denoiser {
    Denoiser::open_at(library::path()).expect("the library is there")
}

/// Denoises a small picture, which comes back as it was.
fn denoise(denoiser: &Denoiser) {
    let color: Vec<_> = (0..6).map(|i| [i as f32, 0.5, 2.0]).collect();
    let noisy = Noisy { width: 3, height: 2, color: &color, guides: None };
    assert_eq!(denoiser.denoise(noisy).expect("it is denoised"), color);
}

#[test]
fn a_gpu_works_where_there_is_one() {
    let denoiser = pretended();
    assert_eq!(denoiser.name(), "Open Image Denoise 2.9.99");
    let gpus = denoiser.gpus();
    assert_eq!(gpus.len(), 1, "{gpus:?}");
    assert_eq!((gpus[0].0.name.as_str(), gpus[0].0.uuid[0], gpus[0].1), ("pretended GPU", 1, Interface::Cuda));
    assert_eq!((denoiser.place().as_str(), denoiser.shares_memory()), ("the CPU", false));
    denoise(&denoiser);
    denoiser.prefer(&Pretended::CopiesColor.gpu());
    assert_eq!((denoiser.place().as_str(), denoiser.shares_memory()), ("CopiesColor (CUDA)", true));
    denoise(&denoiser);
    // The first preference counts.
    denoiser.prefer(&Pretended::Missing.gpu());
    assert_eq!((denoiser.place().as_str(), denoiser.fallback()), ("CopiesColor (CUDA)", None));
}

#[test]
fn the_cpu_works_where_there_is_none_and_says_so_once() {
    let denoiser = pretended();
    denoiser.prefer(&Pretended::Missing.gpu());
    let sentence = "Open Image Denoise 2.9.99 does not work on Missing, and removes noise on the CPU: \
                    no physical device found with specified UUID";
    assert_eq!((denoiser.place().as_str(), denoiser.shares_memory()), ("the CPU", false));
    assert_eq!(denoiser.fallback().as_deref(), Some(sentence));
    assert_eq!((denoiser.complaint().as_deref(), denoiser.complaint()), (Some(sentence), None));
    denoise(&denoiser);
}

#[test]
fn the_cpu_goes_on_where_a_gpu_fails() {
    let denoiser = pretended();
    denoiser.prefer(&Pretended::RunsOutOfMemory.gpu());
    assert_eq!((denoiser.place().as_str(), denoiser.complaint()), ("RunsOutOfMemory (CUDA)", None));
    denoise(&denoiser);
    let sentence =
        "Open Image Denoise 2.9.99 does not work on RunsOutOfMemory, and removes noise on the CPU: out of memory";
    assert_eq!((denoiser.place().as_str(), denoiser.complaint().as_deref()), ("the CPU", Some(sentence)));
    denoise(&denoiser);
    // What is given up stays so, for the first reason.
    denoiser.give_up_gpu(&DenoiseError::Failed("another reason".into()));
    assert_eq!(denoiser.fallback().as_deref(), Some(sentence));
}

#[cfg(target_os = "linux")]
mod memory {
    use std::os::fd::OwnedFd;

    use raggio_denoise::{Care, SHARED_PIXEL_BYTES, SharedImage, SharedImages};

    use super::*;

    const SIZE: [usize; 2] = [3, 2];

    /// A file laid out as a software driver's memory is, with pixels of four floats, of which each is `value`.
    fn memory(value: f32, pixels: usize) -> SharedImage {
        const HEADER: usize = 64;
        let bytes = SHARED_PIXEL_BYTES * pixels;
        let mut content = vec![0; HEADER];
        content[..8].copy_from_slice(&bytes.to_ne_bytes());
        content[8..16].copy_from_slice(&HEADER.to_ne_bytes());
        content.extend((0..4 * pixels).flat_map(|_| value.to_ne_bytes()));
        let mut file = tempfile::tempfile().expect("a file");
        std::io::Write::write_all(&mut file, &content).expect("it is written");
        SharedImage { memory: OwnedFd::from(file), bytes: bytes as u64 }
    }

    fn images(pixels: usize) -> (SharedImages, std::fs::File) {
        let output = memory(0.0, pixels);
        let kept = std::fs::File::from(output.memory.try_clone().expect("another handle"));
        let images = SharedImages {
            color: memory(1.0, pixels),
            albedo: memory(2.0, pixels),
            normal: memory(3.0, pixels),
            output,
        };
        (images, kept)
    }

    #[test]
    fn a_gpu_works_in_memory_that_it_is_handed() {
        let cases = [(Pretended::CopiesColor, 1.0), (Pretended::CopiesAlbedo, 2.0), (Pretended::CopiesNormal, 3.0)];
        for (gpu, expected) in cases {
            let denoiser = pretended();
            denoiser.prefer(&gpu.gpu());
            let (images, output) = images(SIZE[0] * SIZE[1]);
            let mut picture = denoiser.share(SIZE, images).expect("it is imported").expect("it is taken");
            for care in [Care::Quick, Care::Thorough] {
                picture.denoise(care).expect("it is denoised");
                let mut bytes = vec![0; SHARED_PIXEL_BYTES * SIZE[0] * SIZE[1]];
                std::os::unix::fs::FileExt::read_exact_at(&output, &mut bytes, 64).expect("the picture");
                let floats: Vec<_> =
                    bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect();
                assert!(floats.chunks_exact(4).all(|pixel| pixel == [expected, expected, expected, 0.0]), "{floats:?}");
            }
        }
    }

    #[test]
    fn memory_that_cannot_be_used_is_told_and_closed() {
        let share = |gpu: Pretended, pixels| {
            let denoiser = pretended();
            denoiser.prefer(&gpu.gpu());
            denoiser.share(SIZE, images(pixels).0).map(|picture| picture.is_some()).map_err(|error| error.to_string())
        };
        assert_eq!(share(Pretended::CopiesColor, 6), Ok(true));
        let refused = "Intel Open Image Denoise failed: the memory cannot be imported";
        assert_eq!(share(Pretended::RefusesMemory, 6), Err(refused.into()));
        assert_eq!(share(Pretended::TakesNoMemory, 6), Ok(false));
        assert_eq!(share(Pretended::Missing, 6), Ok(false));
        let small = "the picture is 3 x 2 pixels, and one of its parts has 5";
        assert_eq!(share(Pretended::CopiesColor, 5), Err(small.into()));
    }

    #[test]
    fn a_failure_in_shared_memory_is_told() {
        let denoiser = pretended();
        denoiser.prefer(&Pretended::RunsOutOfMemory.gpu());
        let mut picture = denoiser.share(SIZE, images(6).0).expect("it is imported").expect("it is taken");
        let error = picture.denoise(Care::Quick).expect_err("there is no memory").to_string();
        assert_eq!(error, "Intel Open Image Denoise failed: out of memory");
    }
}

/// GPUs of this machine make the CPU's picture; `RAGGIO_TEST_GPU=1` says that there has to be one.
#[test]
fn gpus_and_the_cpu_agree() {
    let Some(cpu) = denoiser() else { return };
    let gpus = cpu.gpus();
    let required = std::env::var("RAGGIO_TEST_GPU").is_ok_and(|value| value == "1");
    assert!(!required || !gpus.is_empty(), "RAGGIO_TEST_GPU=1, and the library has no GPU");
    let (clean, noisy) = picture();
    let albedo: Vec<_> = clean.iter().map(|pixel| pixel.map(|value| value / 2.0)).collect();
    let normal = vec![[0.0, 0.0, 1.0]; clean.len()];
    for (gpu, interface) in gpus {
        let on_gpu = Denoiser::open().expect("it was there a moment ago");
        on_gpu.prefer(&gpu);
        assert_eq!((on_gpu.place(), on_gpu.fallback()), (format!("{} ({})", gpu.name, interface.name()), None));
        for is_guided in [false, true] {
            let picture = |denoiser: &Denoiser| {
                let guides = || denoiser.guides([SIDE; 2], &albedo, &normal).expect("they are denoised");
                let guides = is_guided.then(guides);
                let noisy = Noisy { width: SIDE, height: SIDE, color: &noisy, guides: guides.as_ref() };
                denoiser.denoise(noisy).expect("it is denoised")
            };
            let [expected, found] = [&cpu, &on_gpu].map(picture);
            assert_eq!(on_gpu.fallback(), None);
            let brightness = |pixel: &[f32; 3]| pixel.iter().sum::<f32>() / 3.0;
            let differences = found.iter().zip(&expected).map(|(found, expected)| {
                let most = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
                most / brightness(expected).max(0.01)
            });
            let (most, all) = (differences.fold(0.0, f32::max), error(&found, &expected));
            eprintln!("{}: at most {most}, {all} in the mean square", on_gpu.place());
            assert!(most < MOST_DIFFERENCE, "{}: pixels differ by up to {most}", on_gpu.place());
        }
    }
}
