//! Projection of the camera: an angle, intrinsics, the height of parallel rays, or a panorama.

use super::first_given;
use crate::fault::{Fault, steps};
use crate::file::{CameraFile, IntrinsicsFile};
use crate::scene::{Intrinsics, Projection};

/// Most of the focal length that skew may be: what is more is no camera's, and 32 bits should hold all rays.
const MOST_SKEW: f64 = 10.0;

pub(super) fn projection(file: &CameraFile) -> Result<Projection, Fault> {
    match (file.vertical_fov_degrees, &file.intrinsics, file.orthographic_height, &file.panorama) {
        (Some(angle), None, None, None) => Ok(Projection::Perspective { vertical_fov_degrees: angle.0 as f32 }),
        (None, Some(intrinsics), None, None) => self::intrinsics(intrinsics).map(Projection::Calibrated),
        (None, None, Some(height), None) => Ok(Projection::Orthographic { height: height.0 as f32 }),
        (None, None, None, Some(panorama)) => {
            refuse_lens(file)?;
            Ok(Projection::Panoramic(panorama.0))
        }
        (None, None, None, None) => {
            let message = "`vertical_fov_degrees` is missing in [camera]; `intrinsics`, `orthographic_height` or `panorama` \
                           could stand in its place";
            Err(Fault::value(steps!["camera"], message))
        }
        _ => Err(refuse_two(file)),
    }
}

/// The fault of a camera with more than one projection.
fn refuse_two(file: &CameraFile) -> Fault {
    let given = [
        ("vertical_fov_degrees", file.vertical_fov_degrees.is_some()),
        ("intrinsics", file.intrinsics.is_some()),
        ("orthographic_height", file.orthographic_height.is_some()),
        ("panorama", file.panorama.is_some()),
    ];
    let mut given = given.iter().filter(|(_, is_given)| *is_given).map(|(key, _)| *key);
    let [first, second] = [given.next(), given.next()].map(Option::unwrap_or_default);
    let message = format!("`{second}` in [camera] cannot stand beside `{first}`: keep one or the other");
    Fault::key(steps!["camera", second], message)
}

fn refuse_lens(file: &CameraFile) -> Result<(), Fault> {
    let given = [("aperture_radius", file.aperture_radius.0 > 0.0), ("focus_distance", file.focus_distance.is_some())];
    match first_given(&given) {
        Some(key) => {
            let message =
                format!("`{key}` in [camera] cannot stand beside `panorama`, which has no lens: leave it out");
            Err(Fault::key(steps!["camera", key], message))
        }
        None => Ok(()),
    }
}

fn intrinsics(file: &IntrinsicsFile) -> Result<Intrinsics, Fault> {
    let [fx, fy] = file.focal.map(f64::from);
    let skew = file.skew.0;
    if skew.abs() > MOST_SKEW * fx {
        let message = format!(
            "`skew` in [camera.intrinsics] must be at most {MOST_SKEW} times the focal length across in size, not `{skew}`"
        );
        return Err(Fault::value(steps!["camera", "intrinsics", "skew"], message));
    }
    let size = file.size.map(|side| side.0 as u32);
    let middle = size.map(|side| side as f32 / 2.0);
    Ok(Intrinsics {
        focal: [fx as f32, fy as f32],
        principal_point: file.principal_point.map_or(middle, |point| point.map(|place| place.0 as f32)),
        skew: skew as f32,
        size,
    })
}
