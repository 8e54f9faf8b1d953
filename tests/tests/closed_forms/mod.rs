//! Closed forms: scenes whose radiance can be written down.

mod bodies;
mod critical;
mod depth;
mod filters;
mod fresnel;
mod furnace;
mod hard_cases;
mod lamps;
mod lens;
mod media;
mod mirrors;
mod overlap;
mod panorama;

use glam::DVec3;
use raggio_scene::Scene;
use raggio_tests::parse;

/// Field of view in degrees so narrow that the whole picture sees what lies in one direction: all pixels estimate one
/// radiance.
const ONE_DIRECTION: f64 = 0.02;

/// View of a scene: the camera's place, the point it looks at, the field of view in degrees, the size in pixels.
#[derive(Clone, Copy)]
struct View {
    position: DVec3,
    look_at: DVec3,
    fov_degrees: f64,
    width: u32,
    height: u32,
    max_depth: u32,
}

impl View {
    /// Makes a view of 64 x 64 pixels, with paths of up to a thousand rays.
    fn new(position: [f64; 3], look_at: [f64; 3], fov_degrees: f64) -> Self {
        let [position, look_at] = [position, look_at].map(DVec3::from_array);
        Self { position, look_at, fov_degrees, width: 64, height: 64, max_depth: 1000 }
    }

    fn size(self, width: u32, height: u32) -> Self {
        Self { width, height, ..self }
    }

    fn depth(self, max_depth: u32) -> Self {
        Self { max_depth, ..self }
    }

    /// Scene of the view and of what it sees, the rest of a scene file. `render` and `camera` are keys to add to those
    /// tables.
    fn scene_with(&self, render: &str, camera: &str, rest: &str) -> Scene {
        let Self { position, look_at, fov_degrees, width, height, max_depth } = self;
        // Up is any direction across the view.
        let up = if (*look_at - *position).normalize().y.abs() > 0.9 { DVec3::NEG_Z } else { DVec3::Y };
        let [position, look_at, up] = [*position, *look_at, up].map(array);
        let has_projection = ["orthographic_height", "panorama"].iter().any(|key| camera.contains(key));
        let fov = if has_projection { String::new() } else { format!("vertical_fov_degrees = {fov_degrees}") };
        parse(&format!(
            "[render]\nwidth = {width}\nheight = {height}\nmax_depth = {max_depth}\n{render}
             [camera]\nposition = {position}\nlook_at = {look_at}\nup = {up}\n{fov}
             {camera}
             {rest}"
        ))
    }

    fn scene(&self, rest: &str) -> Scene {
        self.scene_with("", "", rest)
    }

    /// Direction through the middle of a pixel, for views with the default orientation.
    fn direction(&self, x: u32, y: u32) -> DVec3 {
        let back = (self.position - self.look_at).normalize();
        let up = if back.y.abs() > 0.9 { DVec3::NEG_Z } else { DVec3::Y };
        let right = up.cross(back).normalize();
        let half = (0.5 * self.fov_degrees.to_radians()).tan();
        let across = half * f64::from(self.width) / f64::from(self.height)
            * (2.0 * (f64::from(x) + 0.5) / f64::from(self.width) - 1.0);
        let upward = half * (1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(self.height));
        (across * right + upward * back.cross(right) - back).normalize()
    }
}

fn array(v: DVec3) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

const WHITE_SKY: &str = "[environment]\ncolor = [1, 1, 1]\n";

/// Text of the shapes of a scene file, each given as (material, shape).
fn shapes(list: &[(&str, &str)]) -> String {
    list.iter().map(|(material, shape)| format!("[[shapes]]\nmaterial = \"{material}\"\n{shape}\n")).collect()
}

/// Text of the materials of a scene file, each given as (name, keys).
fn materials(list: &[(&str, &str)]) -> String {
    list.iter().map(|(name, keys)| format!("[materials.{name}]\n{keys}\n")).collect()
}

/// Text of a white sky over water without end, with a black bottom 9 below the surface at height 0.
fn water_under_the_sky() -> String {
    let materials =
        materials(&[("water", "color = [1, 1, 1]\nrefractive_index = 1.33"), ("bottom", "color = [0, 0, 0]")]);
    let shapes = shapes(&[
        ("water", "plane = { point = [0, 0, 0], normal = [0, 1, 0] }"),
        ("bottom", "plane = { point = [0, -9, 0], normal = [0, 1, 0] }"),
    ]);
    [WHITE_SKY, &materials, &shapes].concat()
}
