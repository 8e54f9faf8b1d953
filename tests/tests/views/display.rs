//! Views of a film against their formulas in double precision.

use raggio_render::{Display, FilmPixel, ToneMapper, View};
use raggio_tests::for_each_device;
use raggio_tests::render::{displayed, load};

use crate::views::{assert_alike, byte, encoded, still_life};

/// Colour of Zucker's polynomial.
fn viridis(x: f64) -> [u8; 3] {
    let coefficients = [
        [0.2777273272, 0.0054073445, 0.3340998053],
        [0.1050930431, 1.4046135299, 1.3845901626],
        [-0.3308618287, 0.2148475595, 0.0950951630],
        [-4.6342304990, -5.7991009734, -19.3324409563],
        [6.2282699363, 14.1799333668, 56.6905526007],
        [4.7763849977, -13.7451453778, -65.3530326334],
        [-5.4354558559, 4.6458526122, 26.3124352496],
    ];
    let x = x.clamp(0.0, 1.0);
    [0, 1, 2].map(|channel| byte(coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c[channel])))
}

/// Colour that `view` makes of a pixel, one stop brighter and cut off at 1 if it is a photograph.
fn expected(view: View, scale: f64, pixel: &FilmPixel) -> [u8; 3] {
    let mean = pixel.mean();
    let relative_error = match pixel.luminance_error() {
        Some(error) => error / pixel.luminance().max(1e-30),
        None => 1.0,
    };
    match view {
        View::Radiance => mean.map(|value| encoded(2.0 * value)),
        View::Hit | View::Albedo => mean.map(encoded),
        View::Normal => mean.map(byte),
        View::Depth => [byte(if mean[0] > 0.0 { scale / (scale + mean[0]) } else { 0.0 }); 3],
        View::Bounces => viridis(f64::from(pixel.rays) / f64::from(pixel.samples.max(1)) / scale),
        View::Samples => viridis(f64::from(pixel.samples) / scale),
        View::Variance => viridis(1.0 + relative_error.log10() / 3.0),
    }
}

#[test]
fn views_are_what_they_are_called() {
    let scene = still_life();
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        for view in View::ALL {
            session.show(view.feature()).expect("the feature is shown");
            // Bands of rows have none, one and more samples.
            session.add_samples(5..33, 0..1).expect("samples are added");
            session.add_samples(10..33, 1..8).expect("samples are added");
            let scale = match view {
                View::Depth => 5.0,
                View::Samples => 12.0,
                _ => 6.0,
            };
            let display = Display { exposure: 1.0, tone_mapper: ToneMapper::None, view, scale, ..Display::default() };
            let found = displayed(&mut *session, display);
            let film = session.film().expect("the film is read");
            let expected: Vec<_> = film.pixels().iter().map(|p| expected(view, scale.into(), p)).collect();
            // The smallest errors that are shown suffer from the single precision of the kernel's second moment.
            let allowed = if view == View::Variance { 3 } else { 1 };
            assert_alike(&format!("{} {view:?}", device.label), &expected, &found, allowed);
        }
    });
}

/// The colours are compared with the table of matplotlib, from which the polynomial is nowhere here more than four
/// steps off.
#[test]
fn viridis_is_viridis() {
    for (x, expected) in [(0.0, [68, 1, 84]), (0.25, [59, 82, 139]), (0.5, [33, 145, 140]), (1.0, [253, 231, 37])] {
        assert_alike(&format!("viridis of {x}"), &[expected], &[viridis(x)], 4);
    }
}

#[test]
fn scales_that_are_no_numbers_do_no_harm() {
    let scene = still_life();
    for_each_device(|device| {
        let mut session = load(device.device, &scene);
        session.add_samples(10..33, 0..2).expect("samples are added");
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            for view in View::ALL {
                displayed(&mut *session, Display { view, scale, ..Display::default() });
            }
        }
    });
}

#[test]
fn false_colours_come_with_a_legend() {
    assert_eq!(View::Bounces.legend(8.0).as_deref(), Some("rays per sample: 0 to 8"));
    for view in View::ALL {
        let plain = matches!(view, View::Radiance | View::Hit | View::Albedo);
        assert_eq!(view.legend(4.5).is_none(), plain, "{view:?}");
    }
}
