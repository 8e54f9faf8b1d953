//! The alpha channel: what is covered, and what is left out.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use raggio_render::{Film, Progress, RenderRequest, Rendering, Stop};
use raggio_scene::{Environment, Filter, Scene, Vec3};
use raggio_tests::devices::long;
use raggio_tests::render::means;
use raggio_tests::{TestDevice, for_each_device, for_each_way, parse, render};

/// Radiance of the background.
const SKY: DVec3 = DVec3::new(0.5, 0.75, 2.0);

/// Balls that shine and reflect nothing, one behind the other, and a sheet of which half is there, before a sky. 41 x 27
/// pixels: no multiple of a block.
fn lamps() -> Scene {
    parse(&format!("{BALLS}{SHEET}"))
}

const BALLS: &str = "[render]\nwidth = 41\nheight = 27\nmax_depth = 1\n
         [camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n
         [environment]\ncolor = [0.5, 0.75, 2]\n
         [materials.red]\ncolor = [0, 0, 0]\nemission_color = [1, 0.1, 0.1]\nemission_strength = 3\n
         [materials.dim]\ncolor = [0, 0, 0]\nemission_strength = 0.2\n
         [[shapes]]\nmaterial = \"red\"\nsphere = { center = [-0.4, 0, 0], radius = 0.8 }\n
         [[shapes]]\nmaterial = \"dim\"\nsphere = { center = [0.4, 0.2, 1], radius = 0.5 }\n";

/// A sheet of which half is there.
const SHEET: &str = "[materials.half.principled]\nbase_color = [0, 0, 0]\nemissive = [0, 1, 0]\nalpha = 0.5\nalpha_mode = \"blend\"\n
         [[shapes]]\nmaterial = \"half\"\nrectangle = { corner = [0.6, -1, 0], edge_u = [1, 0, 0], edge_v = [0, 0.9, 0] }\n";

/// Scenes that take software Vulkan minutes to compile kernels for are left to `make test-long` there: kernels are the same on all
/// Vulkan devices.
fn takes_too_long(device: TestDevice) -> bool {
    device.slow && !long()
}

/// Film of a request.
fn rendered(device: TestDevice, scene: &Scene, stop: Stop, patience: usize) -> Film {
    let request = RenderRequest { stop, label: true, ..RenderRequest::default() };
    let rendering = Rendering::begin(scene, device.device, request).expect("the scene loads");
    let mut portions = 0;
    let mut observer = |_: &Progress| {
        portions += 1;
        if portions == patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    rendering.run(&mut observer).expect("the film is there").picture.film
}

fn with_alpha(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.render.alpha = true;
    scene
}

fn samples(range: std::ops::Range<u32>) -> Stop {
    Stop { samples: Some(range), ..Stop::default() }
}

/// The picture over a background.
fn over(film: &Film, background: DVec3) -> Vec<DVec3> {
    let alpha = film.alpha().expect("the film has an alpha");
    means(film).into_iter().zip(alpha).map(|(mean, alpha)| mean + (1.0 - f64::from(alpha)) * background).collect()
}

/// A sphere covers its disk.
#[test]
fn silhouettes_are_covered() {
    let scene = parse(
        "[render]\nwidth = 40\nheight = 40\nalpha = true\n
         [camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\northographic_height = 4\n
         [environment]\ncolor = [1, 1, 1]\n[materials.a]\n
         [[shapes]]\nmaterial = \"a\"\nsphere = { center = [0.1, 0.05, 0], radius = 1 }\n",
    );
    for_each_device(|device| {
        for filter in [Filter::Box, Filter::BlackmanHarris, Filter::Mitchell] {
            let mut scene = scene.clone();
            scene.render.filter = filter;
            let alpha = rendered(device, &scene, samples(0..device.pick(256, 64)), 0).alpha().expect("an alpha");
            let area = alpha.iter().map(|alpha| f64::from(*alpha)).sum::<f64>();
            assert!((area / (100.0 * PI) - 1.0).abs() < 4e-3, "{}, {filter}: {area}", device.label);
            // Whatever the filter's weights, what is wholly covered is opaque, and what is not covered is not there.
            let at = |x: usize, y: usize| alpha[y * 40 + x];
            assert_eq!([at(20, 20), at(15, 22), at(0, 0), at(39, 20)], [1.0, 1.0, 0.0, 0.0], "{filter}");
        }
    });
}

/// A picture over a constant background is the picture with that background, sample for sample, where nothing reflects it:
/// with whatever filter and range of samples.
#[test]
fn alpha_composites_exactly() {
    for_each_way(&lamps(), |device, scene| {
        let quick = takes_too_long(device);
        // Without the sheet, which is of the principled material.
        let integrator = scene.render.integrator;
        let mut scene = if quick { parse(BALLS) } else { scene.clone() };
        scene.render.integrator = integrator;
        let ranges = [5..9, 0..37];
        for range in &ranges[..if quick { 1 } else { 2 }] {
            for filter in [Filter::Box, Filter::BlackmanHarris, Filter::Point] {
                let what = format!("{}, {}, {range:?}, {filter}", device.label, scene.render.integrator);
                let mut scene = scene.clone();
                scene.render.filter = filter;
                let film = rendered(device, &with_alpha(&scene), samples(range.clone()), 0);
                let alpha = film.alpha().expect("an alpha");
                assert!(alpha.contains(&0.0) && alpha.contains(&1.0), "{what}");
                let half = alpha.iter().any(|a| (0.4..0.6).contains(a));
                assert!(half || quick, "{what}: half of the sheet is there");
                let expected = rendered(device, &scene, samples(range.clone()), 0);
                assert_eq!(expected.alpha(), None);
                for (i, (found, expected)) in over(&film, SKY).into_iter().zip(means(&expected)).enumerate() {
                    assert!((found - expected).abs().max_element() < 1e-6, "{what}, {i}: {found}, not {expected}");
                }
            }
        }
    });
}

/// Coverage has the samples that each pixel's colour has, where parts of the picture rest or a pass was broken off: over the
/// background a pixel is that of a film of as many samples.
#[test]
fn parts_have_their_own_coverage() {
    let noise = Stop { noise: Some(0.1), samples: Some(0..512), ..Stop::default() };
    for_each_device(|device| {
        if takes_too_long(device) {
            return;
        }
        for (stop, patience) in [(noise.clone(), 0), (samples(0..1 << 20), 5), (samples(0..1 << 20), 6)] {
            let scene = lamps();
            let film = rendered(device, &with_alpha(&scene), stop, patience);
            let counts = |film: &Film| film.pixels().iter().map(|it| it.samples).collect::<Vec<_>>();
            assert_eq!(counts(film.coverage().expect("a coverage")), counts(&film), "{}", device.label);
            let found = over(&film, SKY);
            let numbers: BTreeSet<u32> = counts(&film).into_iter().collect();
            assert!(numbers.len() > 1 || patience > 0, "{numbers:?}");
            for number in numbers {
                let expected = means(&render(device.device, &scene, number));
                for (i, _) in film.pixels().iter().enumerate().filter(|(_, pixel)| pixel.samples == number) {
                    let apart = (found[i] - expected[i]).abs().max_element();
                    assert!(apart < 1e-6, "pixel {i} of {number} samples: {}, not {}", found[i], expected[i]);
                }
            }
        }
    });
}

/// The background is left out where it is seen directly, and nowhere else: mirrors and glass show it, and bodies are lit by
/// it. Covered pixels have the bits that they have with the background.
#[test]
fn the_background_still_shines() {
    let mut scene = parse(
        "[render]\nwidth = 40\nheight = 24\nmax_depth = 8\n
         [camera]\nposition = [0, 1, 6]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n
         [environment]\nhorizon = [1, 0.9, 0.8]\nzenith = [0.3, 0.5, 1]\n
         [materials.matte]\n[materials.mirror]\nsmoothness = 1\n[materials.glass]\ncolor = [1, 1, 1]\nrefractive_index = 1.5\n
         [materials.pane.principled]\ntransmission = 1\nroughness = 0\nthin_walled = true\n
         [[shapes]]\nmaterial = \"matte\"\nsphere = { center = [-2.2, 1, 0], radius = 0.9 }\n
         [[shapes]]\nmaterial = \"mirror\"\nsphere = { center = [0, 1, 0], radius = 0.9 }\n
         [[shapes]]\nmaterial = \"glass\"\nsphere = { center = [2.2, 1, 0], radius = 0.9 }\n
         [[shapes]]\nmaterial = \"pane\"\nrectangle = { corner = [-1, 2.2, 0], edge_u = [2, 0, 0], edge_v = [0, 0.5, 0] }\n",
    );
    for_each_way(&scene.clone(), |device, scene| {
        if takes_too_long(device) {
            return;
        }
        let film = rendered(device, &with_alpha(scene), samples(0..8), 0);
        let whole = rendered(device, scene, samples(0..8), 0);
        let alpha = film.alpha().expect("an alpha");
        for (i, (found, expected)) in film.pixels().iter().zip(whole.pixels()).enumerate() {
            if alpha[i] == 1.0 {
                assert_eq!(found, expected, "{}: pixel {i} is covered", device.label);
            } else if alpha[i] == 0.0 {
                assert_eq!(found.mean(), [0.0; 3], "{}: pixel {i} is not covered", device.label);
            }
        }
        // Matte, mirror, glass and pane are opaque.
        for (x, y) in [(8, 12), (20, 12), (31, 12), (20, 4)] {
            assert_eq!(alpha[y * 40 + x], 1.0, "({x}, {y})");
            assert!(film.pixels()[y * 40 + x].luminance() > 0.1, "({x}, {y})");
        }
        assert_eq!(alpha[0], 0.0);
    });
    // A sky that is an image is sampled as a light: what it gives off is lit as before.
    let image = raggio_scene::Bitmap {
        width: 2,
        height: 1,
        texels: raggio_scene::Texels::Rgb32F(vec![[4.0, 3.0, 2.0], [0.1, 0.2, 0.3]]),
    };
    scene.environment = Environment::Image { image: image.into(), rotation_degrees: 0.0, intensity: 1.0 };
    for_each_way(&scene, |device, scene| {
        if takes_too_long(device) {
            return;
        }
        let film = rendered(device, &with_alpha(scene), samples(0..4), 0);
        let whole = rendered(device, scene, samples(0..4), 0);
        let alpha = film.alpha().expect("an alpha");
        let covered = (0..alpha.len()).filter(|i| alpha[*i] == 1.0);
        assert!(covered.clone().count() > 100);
        covered.for_each(|i| assert_eq!(film.pixels()[i], whole.pixels()[i], "{}", device.label));
    });
}

/// Boundaries that light does not notice cover nothing of their own, and a camera in a body sees out of it.
#[test]
fn hidden_boundaries_do_not_cover() {
    let mut scene = parse(
        "[render]\nwidth = 8\nheight = 8\nmax_depth = 4\nalpha = true\n
         [camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nvertical_fov_degrees = 60\n
         [environment]\ncolor = [1, 1, 1]\n
         [materials.water]\nrefractive_index = 1.33\npriority = 2\n[materials.glass]\nrefractive_index = 1.5\npriority = 1\n
         [[shapes]]\nmaterial = \"water\"\nplane = { point = [0, 0, 1], normal = [0, 0, 1] }\n
         [[shapes]]\nmaterial = \"glass\"\nsphere = { center = [0, 0, -1.5], radius = 0.6 }\n",
    );
    for_each_device(|device| {
        let film = rendered(device, &scene, samples(0..4), 0);
        assert_eq!(film.alpha(), Some(vec![0.0; 64]), "{}", device.label);
        assert!(means(&film).iter().all(|mean| *mean == DVec3::ZERO));
    });
    scene.environment = Environment::Constant(Vec3::ZERO);
    scene.shapes.swap(0, 1);
    scene.shapes.truncate(1);
    scene.entries.truncate(1);
    for_each_device(|device| {
        let alpha = rendered(device, &scene, samples(0..4), 0).alpha().expect("an alpha");
        assert_eq!((alpha[0], alpha[27]), (0.0, 1.0), "{}: without the water there is a ball", device.label);
    });
}

/// Films of ranges add up to the film of the whole, coverage included; and films with and without a background are of
/// different settings.
#[test]
fn films_keep_their_coverage() {
    for_each_device(|device| {
        if takes_too_long(device) {
            return;
        }
        let scene = with_alpha(&lamps());
        let whole = rendered(device, &scene, samples(0..12), 0);
        let mut sum = rendered(device, &scene, samples(0..5), 0);
        sum.merge(&rendered(device, &scene, samples(5..12), 0)).expect("they are of one picture");
        assert_eq!((sum.pixels(), sum.coverage()), (whole.pixels(), whole.coverage()), "{}", device.label);
        let folder = std::env::temp_dir().join(format!("raggio-alpha-{}-{}", std::process::id(), device.label));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("whole.film");
        whole.write(&path).expect("it is written");
        assert_eq!(Film::read(&path).expect("it is read"), whole);
        let mut bytes = std::fs::read(&path).expect("it is read");
        let place = bytes.len() - 100;
        bytes[place] ^= 1;
        std::fs::write(&path, &bytes).expect("it is written");
        assert!(Film::read(&path).is_err(), "coverage is part of what the checksum is of");
        std::fs::remove_dir_all(&folder).expect("it can go");

        let plain = rendered(device, &lamps(), samples(12..13), 0);
        let error = sum.merge(&plain).expect_err("they are of different settings");
        assert_eq!(error.to_string(), "the films differ in alpha: `true` and `false`");
        assert!(!sum.lacks_coverage() && !plain.lacks_coverage());
        sum.merge(&rendered(device, &scene, samples(12..13), 0).with_coverage(None)).expect("they are of one picture");
        assert!(sum.coverage().is_none() && sum.lacks_coverage());
    });
}
