//! The camera at a moment, as its keyframes have it.

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
    // Numbers between two that are in range are in range.
    let fov = number(|keyframe| keyframe.vertical_fov_degrees.map(f64::from)).map(FieldOfView);
    posed.vertical_fov_degrees = fov.or(file.vertical_fov_degrees);
    let radius = number(|keyframe| keyframe.aperture_radius.map(f64::from)).map(NonNegative);
    posed.aperture_radius = radius.unwrap_or(file.aperture_radius);
    posed.focus_distance =
        number(|keyframe| keyframe.focus_distance.map(f64::from)).map(Positive).or(file.focus_distance);
    posed
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
    let KeyframeFile { time: _, position, look_at, vertical_fov_degrees, aperture_radius, focus_distance } = keyframe;
    position.is_none()
        && look_at.is_none()
        && vertical_fov_degrees.is_none()
        && aperture_radius.is_none()
        && focus_distance.is_none()
}
