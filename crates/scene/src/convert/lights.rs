//! Lights: one kind each, cones the right way round, a brightness that films can hold.

use std::f64::consts::PI;

use glam::Vec3;

use super::shapes::{below, not_zero};
use super::{dvec3, vec3};
use crate::fault::{Fault, Step, place, steps};
use crate::file::{Color, DirectionalFile, LightFile, PointFile, Radiance, SpotFile};
use crate::names;
use crate::number::{BRIGHTEST, Brightness, ConeAngle};
use crate::review::Review;
use crate::scene::{LightEntry, LightPlace};

/// Largest radiance of a sun: that of the sun itself in candelas to the square metre is 1.6e9. A film takes a sample of 2^35
/// for a fault.
const BRIGHTEST_SUN: f64 = 1e10;
/// Angle of a spot where the file says none, in degrees, as in glTF.
const OUTER_DEGREES: f64 = 45.0;

/// Lights in the order of the file; faults are noted.
pub(super) fn lights(file: &[LightFile], review: &Review) -> Vec<LightEntry> {
    let read = |(index, file)| review.accept(light(index, file));
    file.iter().enumerate().filter_map(read).collect()
}

fn light(index: usize, file: &LightFile) -> Result<LightEntry, Fault> {
    let mut given = file.kinds().into_iter().filter(|(_, is_given)| *is_given).map(|(key, _)| key);
    if let (Some(first), Some(second)) = (given.next(), given.next()) {
        let message = format!("light {} is both `{first}` and `{second}`: write a `[[lights]]` for each", index + 1);
        return Err(Fault::key(steps!["lights", index, second], message));
    }
    let at = |key: &str| steps!["lights", index, key];
    if let Some(point) = &file.point {
        self::point(point, &at("point"))
    } else if let Some(spot) = &file.spot {
        self::spot(spot, &at("spot"))
    } else if let Some(directional) = &file.directional {
        self::directional(directional, &at("directional"))
    } else {
        let keys = file.kinds().map(|(key, _)| format!("`{key}`"));
        let message = format!("light {} is of no kind: give it one of {}", index + 1, keys.join(", "));
        Err(Fault::value(steps!["lights", index], message))
    }
}

fn point(file: &PointFile, at: &[Step]) -> Result<LightEntry, Fault> {
    let kind = LightPlace::Point { position: vec3(file.position) };
    entry(kind, file.color, file.intensity, at)
}

fn spot(file: &SpotFile, at: &[Step]) -> Result<LightEntry, Fault> {
    let direction = not_zero(dvec3(file.direction), at, "direction")?;
    let degrees = |angle: Option<ConeAngle>, default: f64| angle.map_or(default, f64::from);
    let (inner, outer) = (degrees(file.inner_degrees, 0.0), degrees(file.outer_degrees, OUTER_DEGREES));
    if inner > outer {
        let message = format!(
            "`inner_degrees` {} is {inner}, and must not be more than `outer_degrees`, which is {outer}{}",
            place(at),
            if file.outer_degrees.is_none() { " by default" } else { "" },
        );
        return Err(Fault::value(below(at, "inner_degrees"), message));
    }
    let kind = LightPlace::Spot {
        position: vec3(file.position),
        direction: direction.normalize().as_vec3(),
        inner_degrees: inner as f32,
        outer_degrees: outer as f32,
    };
    entry(kind, file.color, file.intensity, at)
}

fn directional(file: &DirectionalFile, at: &[Step]) -> Result<LightEntry, Fault> {
    let direction = not_zero(dvec3(file.direction), at, "direction")?;
    let angle = file.angle_degrees.map_or(0.0, f64::from);
    let kind = LightPlace::Directional { direction: direction.normalize().as_vec3(), angle_degrees: angle as f32 };
    let entry = entry(kind, file.color, file.intensity, at)?;
    let disk = PI * (0.5 * angle).to_radians().sin().powi(2);
    let radiance = brightness(file.color, file.intensity) / disk;
    if angle > 0.0 && radiance > BRIGHTEST_SUN {
        let widest = 2.0 * (brightness(file.color, file.intensity) / (PI * BRIGHTEST_SUN)).sqrt().asin().to_degrees();
        let message = format!(
            "`angle_degrees` {} makes a disk of the radiance {radiance:.1e}, and at most 1e10 can be rendered: a width of \
             {} or more would do, or a lower `intensity`",
            place(at),
            (100.0 * widest).ceil() / 100.0,
        );
        return Err(Fault::value(below(at, "angle_degrees"), message));
    }
    Ok(entry)
}

/// The brightest component of what a light gives.
fn brightness(color: Option<Radiance>, intensity: Option<Brightness>) -> f64 {
    let color = color.map_or([1.0; 3], Color::linear);
    color.into_iter().fold(0.0, f64::max) * intensity.map_or(1.0, f64::from)
}

fn entry(
    kind: LightPlace,
    color: Option<Radiance>,
    intensity: Option<Brightness>,
    at: &[Step],
) -> Result<LightEntry, Fault> {
    if brightness(color, intensity) > BRIGHTEST {
        let message = format!("`intensity` times `color` {} must be at most 1e9", place(at));
        return Err(Fault::value(below(at, "intensity"), message));
    }
    let color = color.map_or(Vec3::ONE, |color| vec3(color.0));
    Ok(LightEntry { place: kind, color, intensity: intensity.map_or(1.0, |intensity| intensity.0 as f32) })
}

/// Warnings of lights that give no light.
pub(super) fn dark(file: &[LightFile], entries: &[LightEntry]) -> Vec<Fault> {
    let dark = entries.iter().zip(file).enumerate().filter(|(_, (entry, _))| entry.is_black());
    let warn = |(index, (entry, _)): (usize, (&LightEntry, &LightFile))| {
        let kind = names::quoted(entry.place.key());
        let message = format!("{kind} of light {} gives no light: its `intensity` or its `color` is 0", index + 1);
        Fault::key(steps!["lights", index, entry.place.key()], message)
    };
    dark.map(warn).collect()
}
