//! Pictures of assets: the plane z = 0 from -1.5 to 1.5 in both directions, seen from (0, 0, 3).

use std::fs;

use glam::DVec3;
use raggio_render::Device;
use raggio_scene::{Integrator, Scene};
use raggio_tests::devices::cpu;
use raggio_tests::render;
use raggio_tests::render::means;

use crate::gltf::asset::Asset;

/// Pixels across and down.
pub const SIDE: usize = 24;

/// Settings of a picture that is taken of an asset.
#[derive(Clone)]
pub struct Shot {
    /// Radiance of the sky, or what else stands in `[environment]`.
    pub environment: String,
    /// Samples of each pixel.
    pub samples: u32,
    /// Most rays of a path.
    pub depth: u32,
    /// Algorithm of light transport.
    pub integrator: Integrator,
    /// Time of the animations in seconds; `None` is the pose of rest.
    pub time: Option<f64>,
    /// Text of a principled material in place of the file's materials.
    pub material: Option<String>,
    /// More text of the scene file.
    pub more: String,
    /// Files beside the scene file, by name.
    pub files: Vec<(&'static str, Vec<u8>)>,
}

impl Default for Shot {
    /// Makes settings for the dark, with one ray through the middle of each pixel.
    fn default() -> Self {
        Self {
            environment: "color = [0, 0, 0]".into(),
            samples: 1,
            depth: 2,
            integrator: Integrator::Path,
            time: None,
            material: None,
            more: String::new(),
            files: vec![],
        }
    }
}

impl Shot {
    /// Makes settings for a white sky: what is white, and returns all light, is not to be seen.
    pub fn furnace() -> Self {
        Self { environment: "color = [1, 1, 1]".into(), ..Self::default() }
    }

    /// Makes settings for a sky that is blue below and orange above, with many samples.
    pub fn outdoors() -> Self {
        let environment = "horizon = [0.1, 0.2, 0.5]\nzenith = [1.0, 0.8, 0.4]".into();
        Self { environment, samples: 64, depth: 6, ..Self::default() }
    }

    pub fn at(time: f64) -> Self {
        Self { time: Some(time), ..Self::default() }
    }

    pub fn scene(&self, asset: &Asset) -> Scene {
        let folder = tempfile::tempdir().expect("there is room for temporary files");
        let time = self.time.map_or(String::new(), |time| format!(", time = {time:?}"));
        let (materials, named) = match &self.material {
            Some(text) => (format!("[materials.own]\nprincipled = {{ {text} }}\n"), "material = \"own\"\n"),
            None => (String::new(), ""),
        };
        let text = format!(
            "version = 1\n[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = 1\nmax_depth = {}\nfilter = \"point\"\n\
             [camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 53.13010235415598\n\
             [environment]\n{}\n{materials}[[shapes]]\n{named}mesh = {{ file = \"a.gltf\"{time} }}\n{}",
            self.depth, self.environment, self.more
        );
        let path = folder.path().join("scene.toml");
        fs::write(&path, text).expect("the scene is written");
        fs::write(folder.path().join("a.gltf"), asset.bytes()).expect("the model is written");
        for (name, bytes) in &self.files {
            fs::write(folder.path().join(name), bytes).expect("an image is written");
        }
        let mut scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        scene.render.integrator = self.integrator;
        scene
    }

    pub fn take(&self, asset: &Asset) -> Picture {
        self.take_on(cpu(), asset)
    }

    pub fn take_on(&self, device: &dyn Device, asset: &Asset) -> Picture {
        let film = render(device, &self.scene(asset), self.samples);
        assert_eq!(film.rejected(), 0, "samples without a finite value");
        Picture(means(&film))
    }
}

/// Radiances of the pixels, row by row from the top.
#[derive(Debug, PartialEq)]
pub struct Picture(pub Vec<DVec3>);

impl Picture {
    /// Radiance of the pixel that shows this place of the plane z = 0.
    pub fn at(&self, x: f64, y: f64) -> DVec3 {
        let pixel = |from_edge: f64| (from_edge * SIDE as f64 / 3.0) as usize;
        self.0[pixel(1.5 - y) * SIDE + pixel(x + 1.5)]
    }

    /// Mean of the 8 x 8 pixels in the middle.
    pub fn middle(&self) -> DVec3 {
        let places = (0..64).map(|i| (f64::from(i % 8), f64::from(i / 8)));
        places.map(|(x, y)| self.at(x / 8.0 - 0.45, y / 8.0 - 0.45)).sum::<DVec3>() / 64.0
    }

    /// Checks that every pixel is what `expected` says of the place in its middle, to within rounding.
    #[track_caller]
    pub fn assert_shows(&self, what: &str, expected: impl Fn(f64, f64) -> DVec3) {
        for (i, found) in self.0.iter().enumerate() {
            let place = |pixel: usize| (pixel as f64 + 0.5) * 3.0 / SIDE as f64 - 1.5;
            let (x, y) = (place(i % SIDE), -place(i / SIDE));
            let expected = expected(x, y);
            assert!((*found - expected).abs().max_element() < 1e-4, "{what}: {found} at ({x}, {y}), not {expected}");
        }
    }

    /// Checks that the picture is white where `inside` says so, and black elsewhere.
    #[track_caller]
    pub fn assert_lit(&self, what: &str, inside: impl Fn(f64, f64) -> bool) {
        self.assert_shows(what, |x, y| DVec3::splat(if inside(x, y) { 1.0 } else { 0.0 }));
    }

    #[track_caller]
    pub fn assert_at(&self, what: &str, (x, y): (f64, f64), expected: DVec3, tolerance: f64) {
        let found = self.at(x, y);
        assert!((found - expected).abs().max_element() <= tolerance, "{what}: {found} at ({x}, {y}), not {expected}");
    }
}

/// Whether (x, y) is in the rectangle around `center`.
pub fn within(center: [f64; 2], size: [f64; 2]) -> impl Fn(f64, f64) -> bool {
    move |x, y| (x - center[0]).abs() < 0.5 * size[0] && (y - center[1]).abs() < 0.5 * size[1]
}
