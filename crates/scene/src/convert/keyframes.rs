//! The camera at a moment, as its keyframes have it.

use super::{dvec3, first_given};
use crate::curve::{Curve, Interpolation};
use crate::fault::{Fault, Step, steps};
use crate::file::{CameraFile, KeyframeFile};
use crate::number::{Coordinate, FieldOfView, NonNegative, Positive};
use crate::review::Review;

/// The camera's table as it would be written for a still of that moment.
pub(super) fn posed(file: &CameraFile, seconds: f64) -> CameraFile {
    let interpolation = file.interpolation.map_or(Interpolation::Smooth, |named| named.0);
    let vector = |key: fn(&KeyframeFile) -> Option<[Coordinate; 3]>| {
        let curve = curve(file, |keyframe| key(keyframe).map(|point| point.map(f64::from)));
        curve.map(|curve| curve.at(seconds, interpolation).map(Coordinate))
    };
    let number = |key: fn(&KeyframeFile) -> Option<f64>| {
        let curve = curve(file, |keyframe| key(keyframe).map(|number| [number]));
        curve.map(|curve| curve.at(seconds, interpolation)[0])
    };
    let mut posed = file.clone();
    posed.position = vector(|keyframe| keyframe.position).unwrap_or(file.position);
    posed.look_at = vector(|keyframe| keyframe.look_at).unwrap_or(file.look_at);
    // Between directions of unequal lengths the longer would count the more.
    let up = curve(file, |keyframe| keyframe.up.map(|up| dvec3(up).normalize_or_zero().to_array()));
    posed.up = up.map_or(file.up, |curve| curve.at(seconds, interpolation).map(Coordinate));
    // Numbers between two that are in range are in range.
    let fov = number(|keyframe| keyframe.vertical_fov_degrees.map(f64::from)).map(FieldOfView);
    posed.vertical_fov_degrees = fov.or(file.vertical_fov_degrees);
    let height = number(|keyframe| keyframe.orthographic_height.map(f64::from)).map(Positive);
    posed.orthographic_height = height.filter(|_| other_kind(file).is_none()).or(file.orthographic_height);
    let radius = number(|keyframe| keyframe.aperture_radius.map(f64::from)).map(NonNegative);
    posed.aperture_radius = radius.unwrap_or(file.aperture_radius);
    posed.focus_distance =
        number(|keyframe| keyframe.focus_distance.map(f64::from)).map(Positive).or(file.focus_distance);
    posed
}

/// Key by which the camera is of another kind than an orthographic one, if it has one.
fn other_kind(file: &CameraFile) -> Option<&'static str> {
    first_given(&[
        ("vertical_fov_degrees", file.vertical_fov_degrees.is_some()),
        ("intrinsics", file.intrinsics.is_some()),
        ("panorama", file.panorama.is_some()),
    ])
}

/// Whether the camera is not the same at all times.
pub(super) fn moves(file: &CameraFile) -> bool {
    file.keyframes.0.len() > 1
}

/// Curve through the values of the keyframes that have one.
fn curve<const N: usize>(file: &CameraFile, value: impl Fn(&KeyframeFile) -> Option<[f64; N]>) -> Option<Curve<N>> {
    let keyframes = file.keyframes.0.iter();
    Curve::through(keyframes.filter_map(|keyframe| Some((f64::from(keyframe.time), value(keyframe)?))))
}

/// Objects to what is wrong with the keyframes, and to the camera of each that `check` finds wrong.
pub(super) fn check(file: &CameraFile, review: &Review, check: impl Fn(&CameraFile) -> Result<(), Fault>) {
    let keyframes = &file.keyframes.0;
    if file.interpolation.is_some() && keyframes.is_empty() {
        let message = "`interpolation` in [camera] needs keyframes: add [[camera.keyframes]], each with a `time`";
        review.object(Fault::key(steps!["camera", "interpolation"], message));
    }
    // Numbers that stand in for others say nothing of their order.
    if review.has(|place| place.first() == Some(&Step::from("camera"))) {
        return;
    }
    let before = review.count();
    for (index, keyframe) in keyframes.iter().enumerate() {
        if let Some(earlier) = index.checked_sub(1).map(|earlier| keyframes[earlier]) {
            review.accept(check_order(index, &earlier, keyframe));
        }
        if is_empty(keyframe) {
            let message = format!(
                "keyframe {} of [camera] says nothing but its time: give it a `position`, a `look_at` or another key",
                index + 1
            );
            review.object(Fault::value(steps!["camera", "keyframes", index], message));
        }
    }
    if let Some(kind) =
        other_kind(file).filter(|_| keyframes.iter().any(|keyframe| keyframe.orthographic_height.is_some()))
    {
        let message = format!(
            "`orthographic_height` in [camera.keyframes] needs an orthographic camera: give [camera] an \
             `orthographic_height` in place of its `{kind}`"
        );
        review.object(Fault::key(steps!["camera", "keyframes"], message));
    }
    if review.count() > before {
        return;
    }
    for (index, keyframe) in keyframes.iter().enumerate() {
        let checked = check(&posed(file, keyframe.time.into()));
        review.accept(checked.map_err(|fault| {
            let message = format!("at keyframe {}, {}", index + 1, fault.sentence(""));
            Fault::value(steps!["camera", "keyframes", index], message)
        }));
    }
}

fn check_order(index: usize, earlier: &KeyframeFile, keyframe: &KeyframeFile) -> Result<(), Fault> {
    let [before, time] = [earlier.time, keyframe.time].map(f64::from);
    let wrong = match time {
        _ if time == before => "the same as",
        _ if time < before => "before",
        _ => return Ok(()),
    };
    let message = format!(
        "`time` in keyframe {} of [camera] is {time}, which is {wrong} that of keyframe {index} ({before}): keyframes \
         stand in the order of their times, each with its own",
        index + 1
    );
    Err(Fault::value(steps!["camera", "keyframes", index, "time"], message))
}

fn is_empty(keyframe: &KeyframeFile) -> bool {
    let KeyframeFile {
        time: _,
        position,
        look_at,
        up,
        vertical_fov_degrees,
        orthographic_height,
        aperture_radius,
        focus_distance,
    } = keyframe;
    [position, look_at, up].iter().all(|point| point.is_none())
        && vertical_fov_degrees.is_none()
        && orthographic_height.is_none()
        && aperture_radius.is_none()
        && focus_distance.is_none()
}
