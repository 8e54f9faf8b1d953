//! Translation of the camera.

use glam::{DMat4, DVec4};
use raggio_kernels::{Camera as DeviceCamera, Projection as DeviceProjection};
use raggio_scene::{Camera, Intrinsics, Projection, RenderSettings};

/// The camera as kernels read it, for a picture of the size in `render`.
pub fn device_camera(camera: &Camera, render: &RenderSettings) -> DeviceCamera {
    let eye = camera.position.as_dvec3();
    let back = (eye - camera.look_at.as_dvec3()).normalize();
    let right = camera.up.as_dvec3().cross(back).normalize();
    let up = back.cross(right);
    let world_from_view = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0));
    let projection = match camera.projection {
        Projection::Perspective { .. } | Projection::Calibrated(_) => DeviceProjection::Perspective,
        Projection::Orthographic { .. } => DeviceProjection::Orthographic,
        Projection::Panoramic(_) => DeviceProjection::Panoramic,
    };
    DeviceCamera {
        world_from_view: rows(world_from_view),
        view_from_clip: rows(view_from_clip(camera, render)),
        aperture_radius: camera.aperture_radius,
        focus_distance: camera.focus_distance,
        projection: projection as u32,
    }
}

/// The inverse of the usual projection, with its planes at 1 and 2: only directions, or places of parallel rays, are taken
/// from it.
fn view_from_clip(camera: &Camera, render: &RenderSettings) -> DMat4 {
    let half_height = camera.half_height();
    let half_width = half_height * f64::from(render.width) / f64::from(render.height);
    let (x, y) = (DVec4::X * half_width, DVec4::Y * half_height);
    match camera.projection {
        Projection::Perspective { .. } => DMat4::from_cols(x, y, DVec4::W * -0.25, DVec4::new(0.0, 0.0, -1.0, 0.75)),
        Projection::Calibrated(intrinsics) => calibrated(&intrinsics.resized(render.width, render.height)),
        Projection::Orthographic { .. } => DMat4::from_cols(x, y, -DVec4::Z, DVec4::new(0.0, 0.0, -1.0, 1.0)),
        Projection::Panoramic(_) => DMat4::IDENTITY,
    }
}

/// The inverse of the projection by intrinsics: u = fx x + skew y + cx and v = fy y + cy, with y and v downwards.
fn calibrated(intrinsics: &Intrinsics) -> DMat4 {
    let [width, height] = intrinsics.size.map(f64::from);
    let [fx, fy] = intrinsics.focal.map(f64::from);
    let [cx, cy] = intrinsics.principal_point.map(f64::from);
    let skew = f64::from(intrinsics.skew);
    let (half_width, half_height) = (0.5 * width / fx, 0.5 * height / fy);
    let y = (cy - 0.5 * height) / fy;
    let x = (0.5 * width - cx + skew * y) / fx;
    DMat4::from_cols(
        DVec4::X * half_width,
        DVec4::new(skew * half_height / fx, half_height, 0.0, 0.0),
        DVec4::W * -0.25,
        DVec4::new(x, y, -1.0, 0.75),
    )
}

fn rows(matrix: DMat4) -> [[f32; 4]; 4] {
    [0, 1, 2, 3].map(|i| matrix.row(i).as_vec4().to_array())
}
