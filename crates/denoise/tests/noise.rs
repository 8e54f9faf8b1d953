//! Error that denoising leaves in noisy pictures, where the library is installed; and where it is looked for.

mod gpus;

use std::path::Path;

use raggio_denoise::{DenoiseError, Denoiser, Noisy, library_paths};

const SIDE: usize = 128;

/// Draws a grey wall left and a bright one right, clean and with noise of a fixed kind.
fn picture() -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let mut state = 1u32;
    let mut unit = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let clean: Vec<_> =
        (0..SIDE * SIDE).map(|i| if i % SIDE < SIDE / 2 { [0.2; 3] } else { [2.0, 1.5, 1.0] }).collect();
    let noisy = clean.iter().map(|pixel| pixel.map(|value| value * 2.0 * unit())).collect();
    (clean, noisy)
}

fn error(found: &[[f32; 3]], clean: &[[f32; 3]]) -> f32 {
    let squares = found.iter().flatten().zip(clean.iter().flatten()).map(|(a, b)| (a - b) * (a - b));
    (squares.sum::<f32>() / (3 * clean.len()) as f32).sqrt()
}

/// Opens the library; `None`, with a word on standard error, where there is none.
fn denoiser() -> Option<Denoiser> {
    match Denoiser::open() {
        Ok(denoiser) => Some(denoiser),
        Err(error @ DenoiseError::NotFound(_)) => {
            let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
            assert!(!required, "RAGGIO_TEST_EVERYTHING=1, and {error}");
            eprintln!("not tested: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn noise_goes_and_edges_stay() {
    let Some(denoiser) = denoiser() else { return };
    assert!(denoiser.name().starts_with("Open Image Denoise 2."), "{}", denoiser.name());
    let (clean, noisy) = picture();
    let albedo: Vec<_> = clean.iter().map(|pixel| pixel.map(|value| value / 2.0)).collect();
    let normal = vec![[0.0, 0.0, 1.0]; clean.len()];
    let guides = denoiser.guides([SIDE; 2], &albedo, &normal).expect("they are denoised");
    let before = error(&noisy, &clean);
    for guides in [None, Some(&guides)] {
        let picture = Noisy { width: SIDE, height: SIDE, color: &noisy, guides };
        let found = error(&denoiser.denoise(picture).expect("it is denoised"), &clean);
        assert!(found < 0.15 * before, "with guides: {}: {found} is left of {before}", guides.is_some());
    }
}

#[test]
fn lists_of_other_lengths_are_refused() {
    let Some(denoiser) = denoiser() else { return };
    let (_, noisy) = picture();
    let picture = Noisy { width: SIDE, height: SIDE + 1, color: &noisy, guides: None };
    let error = denoiser.denoise(picture).expect_err("a row is missing").to_string();
    assert_eq!(error, "the picture is 128 x 129 pixels, and one of its parts has 16384");
    let guides = denoiser.guides([SIDE; 2], &noisy, &noisy[1..]).map(|_| ());
    assert!(matches!(guides, Err(DenoiseError::Size { found: 16383, .. })), "{guides:?}");
    let guides = denoiser.guides([SIDE, 1], &noisy[..SIDE], &noisy[..SIDE]).expect("a row");
    let picture = Noisy { width: SIDE, height: SIDE, color: &noisy, guides: Some(&guides) };
    assert!(matches!(denoiser.denoise(picture), Err(DenoiseError::Size { found: SIDE, .. })));
}

/// Names of the library's file on all systems.
fn is_library(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains("OpenImageDenoise"))
}

#[test]
fn the_library_is_looked_for_where_it_belongs() {
    let root = std::env::temp_dir();
    let program = root.join("install/bin/raggio");
    let paths = library_paths(None, Some(&program)).expect("paths");
    assert!(paths.iter().all(|path| is_library(path)), "{paths:?}");
    // Of what is around the program, its own folder of libraries and nothing else.
    let around: Vec<_> = paths.iter().filter(|path| path.starts_with(&root)).collect();
    assert_eq!(around.len(), 1, "{around:?}");
    assert_eq!(paths[0].parent(), Some(&*root.join("install/lib")));
    let (last, others) = paths.split_last().expect("paths");
    assert_eq!(last.components().count(), 1, "the system looks for a name: {last:?}");
    assert!(others.iter().all(|path| path.is_absolute()), "{others:?}");
    // A program that does not know where it is, or is nowhere in particular, has no such folder.
    let elsewhere = &paths[1..];
    assert_eq!(library_paths(None, None).expect("paths"), elsewhere);
    assert_eq!(library_paths(None, Some(Path::new("bin/raggio"))).expect("paths"), elsewhere);
    assert_eq!(library_paths(Some("".as_ref()), Some(&program)).expect("paths"), paths, "empty is unset");
}

#[test]
fn a_chosen_folder_is_the_only_one() {
    let chosen = std::env::temp_dir().join("oidn");
    let paths = library_paths(Some(chosen.as_os_str()), Some(Path::new("/usr/bin/raggio"))).expect("paths");
    assert!(paths.iter().all(|path| is_library(path)), "{paths:?}");
    let folders: Vec<_> = paths.iter().map(|path| path.parent().expect("a folder")).collect();
    assert_eq!(folders, [&*chosen.join("lib"), &*chosen.join("bin"), &*chosen]);
    for relative in [".", "oidn", "../oidn"] {
        let error =
            library_paths(Some(relative.as_ref()), None).expect_err("a path from the current folder").to_string();
        assert!(error.ends_with("(OIDN_DIR is not a path from the root)"), "{error}");
    }
}
