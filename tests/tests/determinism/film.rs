//! The film's sums.

use raggio_kernels::FixedSum;
use raggio_render::{Answer, Probe, Question};
use raggio_scene::Environment;
use raggio_tests::render::{means, whole};
use raggio_tests::{Pcg, for_each_device, parse, render, render_range};

/// Scene of the sky alone, in a film of a few pixels.
fn sky(color: &str) -> raggio_scene::Scene {
    parse(&format!(
        "[render]\nwidth = 4\nheight = 2\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n
         vertical_fov_degrees = 40\n[environment]\ncolor = {color}\n"
    ))
}

/// Number in units of 2^-40, to the nearest, halves away from zero.
fn fixed(x: f32) -> i128 {
    // The product is exact: a float has 24 bits, and 2^40 moves its point.
    let scaled = f64::from(x) * 2f64.powi(40);
    scaled.round() as i128
}

fn words(answer: &Answer) -> FixedSum {
    let [low, middle, high, _] = answer[0].map(f32::to_bits);
    FixedSum { low, middle, high }
}

/// Twelve numbers of all magnitudes that a sample may have, a third of them negative, some zero or tiny.
fn terms(random: &mut Pcg) -> Question {
    [(); 3].map(|()| {
        [(); 4].map(|()| {
            let magnitude = random.log_between(1e-12, 3e10) as f32;
            match random.below(12) {
                0 => 0.0,
                1 => f32::from_bits(random.bits() & 0x007f_ffff),
                2..6 => -magnitude,
                _ => magnitude,
            }
        })
    })
}

/// Integers must be equal to the bit. The float beside them comes of three conversions and two additions, each a
/// rounding of the largest number involved, which is the sum itself.
#[test]
fn sums_are_exact() {
    for_each_device(|device| {
        let random = &mut Pcg::new(40);
        let questions: Vec<_> = (0..200_000).map(|_| terms(random)).collect();
        let answers = device.ask(&sky("[1, 1, 1]"), Probe::Sum, &questions);
        for (question, answer) in questions.iter().zip(&answers) {
            let expected: i128 = question.iter().flatten().map(|&x| fixed(x)).sum();
            let found = whole(words(answer));
            assert_eq!(expected, found, "{}: sum of {question:?} in units of 2^-40", device.label);
            let value = expected as f64 * 2f64.powi(-40);
            let error = (f64::from(answer[1][0]) - value).abs();
            assert!(
                error <= 5.0 * 2f64.powi(-24) * value.abs(),
                "{}: expected {value} as a float, found {}",
                device.label,
                answer[1][0]
            );
        }
    });
}

/// A float would have stopped growing, or lost a part of each addition.
#[test]
fn a_million_equal_samples_keep_their_mean() {
    for_each_device(|device| {
        let expected = [0.1f32, 1e-6, 12345.678];
        let mut film = render(device.device, &sky("[0.1, 1e-6, 12345.678]"), 1);
        for _ in 0..20 {
            let other = film.clone();
            film.merge(&other).expect("films of one size");
        }
        for (pixel, mean) in film.pixels().iter().zip(film.mean().pixels) {
            assert_eq!(pixel.samples, 1 << 20);
            for (found, expected) in mean.into_iter().zip(expected) {
                // Half a unit of 2^-40 is 4.5e-7 of the smallest; the sky's interpolation rounds the others.
                let allowed = 1e-7 * expected + 2f32.powi(-41);
                assert!((found - expected).abs() <= allowed, "{}: expected {expected}, found {found}", device.label);
            }
        }
    });
}

/// A sample that cannot be added up is counted and left out, and spoils nothing. No scene file can say such numbers.
#[test]
fn samples_that_overflow_are_rejected() {
    for_each_device(|device| {
        let film = |color: [f32; 3]| {
            let mut scene = sky("[1, 1, 1]");
            scene.environment = Environment::Constant(color.into());
            render(device.device, &scene, 3)
        };
        for color in [[1e15, 1.0, 1.0], [1.0, 1.0, 3.5e10], [f32::INFINITY, 0.0, 0.0], [0.0, f32::NAN, 0.0]] {
            let film = film(color);
            assert_eq!((film.rejected(), film.samples()), (8 * 3, 0), "{}: a sky of {color:?}", device.label);
            assert!(means(&film).iter().all(|m| m.length() == 0.0), "{}: a sky of {color:?}: not black", device.label);
        }
        let film = film([1.0, 1.0, 3.4e10]);
        assert_eq!((film.rejected(), film.samples()), (0, 8 * 3), "{}: the brightest that fits", device.label);
    });
}

/// The variance is compared with that of the samples themselves, rendered one by one. The kernel rounds each square a
/// few times to single precision and once to 2^-40.
#[test]
fn the_variance_is_that_of_the_samples() {
    const SAMPLES: u32 = 12;
    for_each_device(|device| {
        for (name, scene) in crate::determinism::scenes() {
            let film = render(device.device, &scene, SAMPLES);
            let singles: Vec<_> = (0..SAMPLES).map(|i| render_range(device.device, &scene, i..i + 1)).collect();
            let values: Vec<_> = singles.iter().map(means).collect();
            for (place, pixel) in film.pixels().iter().enumerate() {
                let weights = glam::DVec3::new(0.2126, 0.7152, 0.0722);
                let luminances: Vec<f64> = values.iter().map(|means| means[place].dot(weights)).collect();
                let count = f64::from(SAMPLES);
                let mean = luminances.iter().sum::<f64>() / count;
                let expected = luminances.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / (count - 1.0);
                let squares = luminances.iter().map(|y| y * y).sum::<f64>() / (count - 1.0);
                let found = pixel.luminance_variance().expect("more than one sample");
                let what = format!("{} {name}: pixel {place}", device.label);
                let allowed = 1e-6 * squares + 2f64.powi(-39);
                assert!((found - expected).abs() <= allowed, "{what}: expected {expected}, found {found}");
                assert_eq!(pixel.luminance_error(), Some((found / count).sqrt()), "{what}");
                assert_eq!(singles[0].pixels()[place].luminance_variance(), None, "{what}: of one sample");
            }
        }
    });
}

/// Squares of the brightest samples count as the largest that a sum takes, so that no sum overflows.
#[test]
fn squares_saturate() {
    for_each_device(|device| {
        for brightness in [2e5, 3.4e10] {
            let mut scene = sky("[1, 1, 1]");
            scene.environment = Environment::Constant([brightness; 3].into());
            for pixel in render(device.device, &scene, 3).pixels() {
                assert_eq!(pixel.squares.value(), 3.0 * 34359736320.0, "{}: a sky of {brightness}", device.label);
            }
        }
    });
}
