mod slow;

use std::ops::ControlFlow;

use raggio_render::{DeviceChoice, OpenOptions, open};

use super::*;
use slow::SlowDevice;

fn scene() -> Scene {
    let text = "version = 1\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n\
        [environment]\nhorizon = [1, 1, 1]\nzenith = [0.5, 0.7, 1]\n[materials.clay]\n[materials.moss]\n\
        [[shapes]]\nmaterial = \"moss\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }\n\
        [[shapes]]\nmaterial = \"clay\"\nsphere = { center = [0, 1, 0], radius = 1 }\n";
    Scene::parse(text, "test").expect("a scene")
}

fn tracer(size: [u32; 2]) -> Tracer {
    let device = open(DeviceChoice::Cpu, OpenOptions::default(), |_| ()).expect("the CPU");
    Tracer::new(device, &scene(), size).expect("the scene loads")
}

/// Traces frames until each pixel of the whole picture has a sample.
fn settle(tracer: &mut Tracer) {
    for _ in 0..10_000 {
        tracer.trace(0.01, 0.01).expect("it traces");
        if tracer.is_whole() {
            return;
        }
    }
    panic!("no whole picture");
}

#[test]
fn a_point_of_the_picture_is_what_the_camera_sees_there() {
    let mut tracer = tracer([64, 48]);
    let pick = tracer.pick(0.5, 0.5).expect("it traces").expect("the sphere");
    assert_eq!((pick.shape, pick.material), (1, 0));
    assert!((pick.distance - 3.0).abs() < 1e-5);
    assert!(pick.position.abs_diff_eq(Vec3::new(0.0, 1.0, 1.0), 1e-5) && pick.normal.abs_diff_eq(Vec3::Z, 1e-5));
    let pick = tracer.pick(0.5, 0.99).expect("it traces").expect("the ground");
    assert_eq!((pick.shape, pick.material), (0, 1));
    assert_eq!(tracer.pick(0.02, 0.02).expect("it traces"), None);
}

#[test]
fn through_a_wide_lens_the_point_is_that_of_its_middle() {
    let mut tracer = tracer([64, 48]);
    let sharp = tracer.pick(0.5, 0.5).expect("it traces");
    let camera = Camera { aperture_radius: 0.5, ..scene().camera };
    tracer.set_camera(&camera, false).expect("another camera");
    assert_eq!(tracer.pick(0.5, 0.5).expect("it traces"), sharp);
}

#[test]
fn after_a_change_the_picture_is_coarse_at_once_and_whole_soon() {
    let mut tracer = tracer([900, 700]);
    settle(&mut tracer);
    tracer.set_camera(&Camera { position: Vec3::new(0.5, 1.0, 4.0), ..scene().camera }, true).expect("a camera");
    assert!(tracer.is_moving() && !tracer.settled());
    // Less time than a sample of every pixel takes.
    tracer.trace(0.004, 0.004).expect("it traces");
    let [width, height] = tracer.film_size();
    assert!(width < 900 && height < 700, "{width} x {height}");
    let seen = (0..5).any(|_| {
        tracer.trace(0.05, 0.05).expect("it traces");
        tracer.progress().samples > 0
    });
    assert!(seen, "there is something to see");
    settle(&mut tracer);
    assert_eq!(tracer.film_size(), [900, 700]);
}

#[test]
fn however_slow_the_device_each_frame_shows_where_a_moving_camera_is() {
    const FRAME: f64 = 0.005;
    for samples_per_second in [1e6, 1e5, 1e4] {
        let (device, taken) = SlowDevice::new(samples_per_second);
        let mut tracer = Tracer::new(Box::new(device), &scene(), [640, 360]).expect("the scene loads");
        let mut shown = vec![];
        for step in 0..15 {
            let camera = Camera { position: Vec3::new(0.1 * step as f32, 1.0, 4.0), ..scene().camera };
            tracer.set_camera(&camera, true).expect("a camera");
            taken.lock().expect("no panic").clear();
            tracer.trace(FRAME, FRAME).expect("it traces");
            let picture = tracer.display(Look::default()).expect("it displays");
            let (Pixels::Host(pixels), size) = picture.expect("something new") else { panic!("the pixels are here") };
            assert_eq!((pixels.len(), size), (size.iter().product::<u32>() as usize, tracer.film_size()));
            assert!(shown.iter().all(|before| *before != pixels), "frame {step} shows an earlier one");
            assert!(tracer.progress().samples > 0 && tracer.scene().camera == camera);
            shown.push(pixels);
            // As soon as the speed is known, no frame does much more than it has time for.
            let taken = taken.lock().expect("no panic").iter().sum::<u64>() as f64;
            let coarsest = (640.0 / 32.0 * 360.0 / 32.0_f64).ceil();
            let most = 4.0 * f64::max(samples_per_second * FRAME, coarsest);
            assert!(step == 0 || taken <= most, "{taken} samples in frame {step} at {samples_per_second} a second");
        }
    }
}

#[test]
fn paths_are_shortened_only_where_the_coarsest_film_is_too_fine_and_until_the_camera_rests() {
    let depth = |tracer: &Tracer| (tracer.device_scene.settings.max_depth, tracer.scene().render.max_depth);
    let whole = scene().render.max_depth;
    assert!(whole > SHORT_PATH);
    for (samples_per_second, while_moving) in [(1e9, whole), (1e4, SHORT_PATH)] {
        let (device, _) = SlowDevice::new(samples_per_second);
        let mut tracer = Tracer::new(Box::new(device), &scene(), [320, 240]).expect("the scene loads");
        let depths = (0..20).map(|step| {
            let camera = Camera { position: Vec3::new(0.1 * step as f32, 1.0, 4.0), ..scene().camera };
            tracer.set_camera(&camera, true).expect("a camera");
            tracer.trace(0.003, 0.003).expect("it traces");
            depth(&tracer)
        });
        let depths = depths.collect::<Vec<_>>();
        // A busy machine may make a fast device slow for some frames, though not a slow one fast.
        let as_expected = depths[1..].iter().filter(|depth| **depth == (while_moving, whole)).count();
        assert!(as_expected >= if while_moving == whole { 1 } else { 19 }, "{depths:?}");
        std::thread::sleep(REST);
        (0..3).for_each(|_| tracer.trace(0.003, 0.003).expect("it traces"));
        assert_eq!(depth(&tracer), (whole, whole));
    }
}

#[test]
fn another_view_is_shown_at_once_and_leaves_the_radiance_that_there_is() {
    let mut tracer = tracer([400, 300]);
    settle(&mut tracer);
    (0..20).for_each(|_| tracer.trace(0.005, 0.005).expect("it traces"));
    let (before, samples) = tracer.radiance().expect("it traces");
    for view in [View::Normal, View::Depth, View::Albedo, View::Hit, View::Bounces, View::Radiance] {
        tracer.set_view(view).expect("a film");
        // Less time than a sample of every pixel takes.
        tracer.trace(1e-5, 1e-5).expect("it traces");
        let look = Look { view, ..Look::default() };
        let (_, size) = tracer.display(look).expect("it displays").unwrap_or_else(|| panic!("{view} shows nothing"));
        assert_eq!(size, [400, 300]);
    }
    let (after, more) = tracer.radiance().expect("it traces");
    assert!(more >= samples && after.samples() >= before.samples(), "radiance goes on");
}

#[test]
fn a_change_is_never_mixed_with_what_was_before() {
    let mut tracer = tracer([40, 30]);
    settle(&mut tracer);
    let camera = Camera { position: Vec3::new(1.0, 2.0, 4.0), ..scene().camera };
    tracer.set_camera(&camera, true).expect("a camera");
    settle(&mut tracer);
    tracer.set_limit(Some(tracer.progress().samples));
    let (film, samples) = tracer.radiance().expect("it traces");

    let mut fresh = Scene { camera, ..scene() };
    [fresh.render.width, fresh.render.height] = [40, 30];
    let device_scene = DeviceScene::new(&fresh).expect("it fits");
    let mut session = tracer.device().load(&device_scene).expect("it loads");
    session.add_samples(0..30, 0..samples).expect("it traces");
    assert_eq!(session.film().expect("the film"), film);
}

#[test]
fn guides_are_gathered_beside_the_picture() {
    let mut tracer = tracer([40, 30]);
    settle(&mut tracer);
    let (before, samples) = tracer.radiance().expect("it traces");
    let wanted = Features::GUIDES;
    let mut features = Features::default();
    // No portion fits into this time, so that each is as small as can be.
    let frames = (1..10_000).find(|_| tracer.gather(&mut features, &wanted, 4, 1e-7).expect("it traces"));
    assert!(frames.expect("an end") > 2, "all was done in {frames:?} frames");
    assert!(tracer.shows_radiance());
    assert_eq!(tracer.radiance().expect("it traces"), (before, samples));

    let once = Features::render(&mut tracer.renderer, &wanted, 4, || ControlFlow::Continue(())).expect("it traces");
    let guides = |features: &Features| (features.guide_albedos(), features.guide_normals());
    assert_eq!(guides(&features), guides(&once));
    let [center, corner] = [15 * 40 + 20, 0].map(|i| Vec3::from(features.guide_normals()[i]));
    assert!(center.abs_diff_eq(Vec3::Z, 0.1) && corner == Vec3::ZERO, "{center} and {corner}");
}

#[test]
fn nothing_is_displayed_twice() {
    let mut tracer = tracer([40, 30]);
    settle(&mut tracer);
    let look = Look::default();
    assert!(tracer.display(look).expect("it displays").is_some());
    assert!(tracer.display(look).expect("it displays").is_none());
    assert!(tracer.display(Look { exposure: 1.0, ..look }).expect("it displays").is_some());
    tracer.show_again();
    assert!(tracer.display(Look { exposure: 1.0, ..look }).expect("it displays").is_some());
}

#[test]
fn a_scene_that_no_device_can_hold_leaves_the_old_one() {
    let mut tracer = tracer([40, 30]);
    settle(&mut tracer);
    let samples = tracer.progress().samples;
    let bodies: String = (0..40)
        .map(|i| format!("[[shapes]]\nmaterial = \"glass\"\nsphere = {{ center = [0, 1, 4], radius = {} }}\n", 10 + i))
        .collect();
    let text = format!(
        "version = 1\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n\
         [materials.glass]\nrefractive_index = 1.5\n{bodies}"
    );
    let too_much = Scene::parse(&text, "test").expect("a scene");
    assert!(tracer.set_scene(&too_much, &too_much.camera).is_err());
    assert_eq!(tracer.progress().samples, samples);
    assert_eq!(tracer.scene().shapes.len(), 2);
}

#[test]
fn rays_are_counted_from_some_rows() {
    let mut tracer = tracer([40, 30]);
    settle(&mut tracer);
    tracer.set_limit(Some(1));
    for _ in 0..200 {
        tracer.count_rays().expect("the film");
    }
    let (film, _) = tracer.radiance().expect("it traces");
    let exact = film.rays() as f64 / film.samples() as f64;
    assert!((tracer.rays_per_sample() / exact - 1.0).abs() < 0.03, "{} for {exact}", tracer.rays_per_sample());
}
