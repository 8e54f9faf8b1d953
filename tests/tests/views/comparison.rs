//! Comparisons of films with a reference.

use raggio_render::{Comparison, DeviceScene, Display, Image, Session, ToneMapper, View};
use raggio_tests::for_each_device;
use raggio_tests::render::{displayed, load};

use crate::views::{assert_alike, encoded, still_life};

/// Image of colours that differ from pixel to pixel, some beyond white.
fn gradient(width: u32, height: u32) -> Image {
    let pixels = (0..height).flat_map(|y| {
        (0..width).map(move |x| [x as f32 / width as f32, y as f32 / height as f32, 1.5 * (x + y) as f32 / 100.0])
    });
    Image { width, height, pixels: pixels.collect(), alpha: None }
}

fn display(comparison: Comparison) -> Display {
    Display { exposure: 0.5, tone_mapper: ToneMapper::None, comparison, split: 17, ..Display::default() }
}

#[test]
fn comparisons_show_what_they_say() {
    let scene = still_life();
    let gain = 2f64.sqrt();
    let shown = |value: [f64; 3]| value.map(|channel| encoded(gain * channel));
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        session.add_samples(0..33, 0..4).expect("samples are added");
        let film = session.film().expect("the film is read");
        let alone = displayed(&mut *session, display(Comparison::Off));
        let found = displayed(&mut *session, display(Comparison::Difference));
        assert_eq!(alone, found, "{}: nothing to compare with", device.label);

        // One reference has a size of its own, so that it has to be resized.
        for reference in [gradient(42, 33), gradient(30, 50)] {
            session.set_reference(Some(&reference)).expect("the reference is taken");
            let reference = reference.resized(42, 33);
            for comparison in Comparison::ALL {
                let found = displayed(&mut *session, display(comparison));
                let expected =
                    film.pixels().iter().zip(&reference.pixels).enumerate().map(|(place, (pixel, theirs))| {
                        let (ours, theirs) = (pixel.mean(), theirs.map(f64::from));
                        let column = place % 42;
                        match comparison {
                            Comparison::Off => shown(ours),
                            Comparison::Reference => shown(theirs),
                            Comparison::Split if column == 17 => [255; 3],
                            Comparison::Split => shown(if column < 17 { ours } else { theirs }),
                            Comparison::Difference => shown([0, 1, 2].map(|c| (ours[c] - theirs[c]).abs())),
                        }
                    });
                let what = format!("{} {comparison:?}", device.label);
                assert_alike(&what, &expected.collect::<Vec<_>>(), &found, 1);
            }
        }
    });
}

#[test]
fn a_reference_goes_with_the_size_or_when_told_to() {
    for_each_device(|device| {
        let mut scene = still_life();
        let mut session = load(device.device, &scene);
        // The film is empty, so all that is not black is the reference.
        let compared = |session: &mut dyn Session, view| {
            let shown = displayed(session, Display { view, ..display(Comparison::Reference) });
            shown.windows(2).any(|pair| pair[0] != pair[1])
        };
        assert!(!compared(&mut *session, View::Radiance), "{}: none at first", device.label);
        session.set_reference(Some(&gradient(42, 33))).expect("the reference is taken");
        assert!(compared(&mut *session, View::Radiance), "{}", device.label);
        assert!(!compared(&mut *session, View::Bounces), "{}: light is compared with light alone", device.label);

        for (width, height, kept) in [(42, 33, true), (21, 20, false)] {
            (scene.render.width, scene.render.height) = (width, height);
            let device_scene = DeviceScene::new(&scene).expect("the scene fits devices");
            session.restart(&device_scene).expect("the session restarts");
            assert_eq!(compared(&mut *session, View::Radiance), kept, "{}: {width}x{height}", device.label);
        }
        session.set_reference(Some(&gradient(42, 33))).expect("the reference is taken");
        assert!(compared(&mut *session, View::Radiance), "{}: anew", device.label);
        session.set_reference(None).expect("the reference is dropped");
        assert!(!compared(&mut *session, View::Radiance), "{}: dropped", device.label);
    });
}
