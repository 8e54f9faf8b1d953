//! Steps from the text of a scene to numbers.

use std::ops::Range;

use glam::DVec3;
use raggio_kernels::{FilmPixel, FixedSum};
use raggio_render::{Device, DeviceScene, Display, Film, Pixels, Session};
use raggio_scene::Scene;

/// Reads a scene from its TOML text; the version line is added.
pub fn parse(text: &str) -> Scene {
    Scene::parse(&format!("version = 1\n{text}"), "test.toml").unwrap_or_else(|error| panic!("{error}\nin\n{text}"))
}

/// Renders the first `samples` samples of each pixel.
pub fn render(device: &dyn Device, scene: &Scene, samples: u32) -> Film {
    render_range(device, scene, 0..samples)
}

/// Renders the samples of each pixel whose numbers are in the range.
pub fn render_range(device: &dyn Device, scene: &Scene, samples: Range<u32>) -> Film {
    let mut session = load(device, scene);
    session.add_samples(0..scene.render.height, samples).expect("the device renders");
    session.film().expect("the film can be read")
}

/// Loads the scene into a session of the device.
pub fn load(device: &dyn Device, scene: &Scene) -> Box<dyn Session> {
    let device_scene = DeviceScene::new(scene).expect("the scene fits devices");
    device.load(&device_scene).expect("the scene loads")
}

/// Returns the film that is shown as displayable pixels: red, green, blue.
pub fn displayed(session: &mut dyn Session, display: Display) -> Vec<[u8; 3]> {
    let bytes: Vec<u8> = match session.display(display).expect("the film is displayed") {
        Pixels::Host(pixels) => pixels.into_iter().flat_map(u32::to_le_bytes).collect(),
        Pixels::Device(buffer) => buffer.read().expect("the pixels can be read"),
    };
    bytes.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

/// Mean radiance with its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Mean of red, green, blue.
    pub mean: DVec3,
    /// Standard error of `mean`.
    pub error: DVec3,
}

impl Estimate {
    /// Asserts that `expected` is within four standard errors in each channel, and that these are small enough to
    /// tell: at most `most_relative_error` of it. Rounding gets a millionth.
    #[track_caller]
    pub fn assert_near(&self, what: &str, expected: DVec3, most_relative_error: f64) {
        let allowed = 4.0 * self.error + 1e-6 * expected;
        let message = format!("{what}: expected {expected}, found {} with standard error {}", self.mean, self.error);
        assert!((self.mean - expected).abs().cmple(allowed).all(), "{message}");
        assert!(
            self.error.cmple(most_relative_error * expected + DVec3::splat(1e-12)).all(),
            "{message}, which is too uncertain: {most_relative_error} of it is needed"
        );
    }
}

/// Mean over all pixels of a picture in which all show one radiance: the pixels are its independent repetitions.
pub fn estimate(device: &dyn Device, scene: &Scene, samples: u32) -> Estimate {
    let film = render(device, scene, samples);
    assert_eq!(film.rejected(), 0, "samples without a finite value");
    let means = means(&film);
    let count = means.len() as f64;
    let mean = means.iter().sum::<DVec3>() / count;
    let spread = means.iter().map(|m| (*m - mean) * (*m - mean)).sum::<DVec3>() / (count - 1.0);
    Estimate { mean, error: DVec3::from_array((spread / count).to_array().map(f64::sqrt)) }
}

/// Mean radiance of each pixel in double precision.
pub fn means(film: &Film) -> Vec<DVec3> {
    film.pixels().iter().map(mean).collect()
}

/// Mean radiance of a pixel in double precision.
pub fn mean(pixel: &FilmPixel) -> DVec3 {
    let sums = [pixel.red, pixel.green, pixel.blue].map(sum);
    DVec3::from_array(sums) / f64::from(pixel.samples.max(1))
}

/// Value of the fixed-point sum in units of 2^-40, computed anew here so that it can test the other.
pub fn whole(sum: FixedSum) -> i128 {
    let words = [sum.low, sum.middle, sum.high];
    let magnitude: i128 = words.iter().enumerate().map(|(i, &word)| i128::from(word) << (32 * i)).sum();
    if sum.high >> 31 == 1 { magnitude - (1i128 << 96) } else { magnitude }
}

fn sum(sum: FixedSum) -> f64 {
    whole(sum) as f64 * 2f64.powi(-40)
}

/// Relative difference of two radiances, in proportion to the largest channel of `b`.
pub fn relative_difference(a: DVec3, b: DVec3) -> f64 {
    (a - b).abs().max_element() / b.abs().max_element().max(1e-30)
}
