//! Light from outside: one radiance, a gradient, an image, or a sky by day.

use glam::{DVec3, Vec3};

use super::shapes::not_zero;
use super::{Files, dvec3, vec3};
use crate::fault::{Fault, Step, steps};
use crate::file::{Color, EnvironmentFile};
use crate::names;
use crate::number::{Brightness, Coordinate};
use crate::scene::Environment;
use crate::sky::{Sky, SunPlace};

/// Sine of the angle below the horizon at which a sun counts as on it.
const HORIZON: f64 = 1e-6;

/// A way to say what light comes from outside: the keys that it needs, and those that may stand beside them.
struct Way {
    needs: &'static [&'static str],
    takes: &'static [&'static str],
}

const OF_IMAGES: &[&str] = &["rotation_degrees", "intensity"];
const OF_SKIES: &[&str] = &["turbidity", "ground_albedo", "sun_intensity", "rotation_degrees", "intensity"];
const WAYS: [Way; 5] = [
    Way { needs: &["color"], takes: &[] },
    Way { needs: &["horizon", "zenith"], takes: &[] },
    Way { needs: &["image"], takes: OF_IMAGES },
    Way { needs: &["sun_direction"], takes: OF_SKIES },
    Way { needs: &["latitude_degrees", "longitude_degrees", "time"], takes: OF_SKIES },
];

pub(super) fn environment(file: &EnvironmentFile, files: &mut Files<'_>) -> Result<Environment, Fault> {
    check(&file.given())?;
    let sun = match (file.sun_direction, file.latitude_degrees, file.longitude_degrees, file.time) {
        (Some(direction), ..) => {
            let direction = not_zero(dvec3(direction), &[Step::from("environment")], "sun_direction")?.normalize();
            Some(SunPlace::Direction(direction.as_vec3()))
        }
        (_, Some(latitude), Some(longitude), Some(time)) => Some(SunPlace::Moment {
            latitude_degrees: latitude.0 as f32,
            longitude_degrees: longitude.0 as f32,
            time: time.0,
        }),
        _ => None,
    };
    if let Some(sun) = sun {
        return sky(sun, file, files);
    }
    if let Some(path) = &file.image {
        return Ok(Environment::Image {
            image: files.image(path, steps!["environment", "image"])?,
            rotation_degrees: rotation_degrees(file),
            intensity: intensity(file.intensity),
        });
    }
    let radiance = |color: Option<Color<Brightness>>| color.map_or(Vec3::ZERO, |color| vec3(color.0));
    Ok(match file.color {
        Some(color) => Environment::Constant(vec3(color.0)),
        None => Environment::Gradient { horizon: radiance(file.horizon), zenith: radiance(file.zenith) },
    })
}

/// Checks that the `given` keys are those of one way.
fn check(given: &[&'static str]) -> Result<(), Fault> {
    let at = |key: &str| steps!["environment", key];
    let is_meant = |way: &&Way| way.needs.iter().any(|key| given.contains(key));
    let mut meant = WAYS.iter().filter(is_meant);
    let Some(way) = meant.next() else {
        let ways = || WAYS.iter().map(|way| names::list(way.needs.iter().copied(), "and"));
        return Err(match given.first() {
            Some(key) => Fault::key(at(key), needs(key)),
            None => {
                let ways: Vec<String> = ways().collect();
                let message = format!("[environment] is empty: give it {}", ways.join(", or "));
                Fault::value(steps!["environment"], message)
            }
        });
    };
    let of = |way: &Way| way.needs.iter().copied().find(|key| given.contains(key)).unwrap_or_default();
    if let Some(other) = meant.next() {
        let key = of(way);
        let beside = names::list(other.needs.iter().copied(), "and");
        let message = format!("`{key}` in [environment] cannot stand beside {beside}: keep one or the other");
        return Err(Fault::key(at(key), message));
    }
    let missing: Vec<_> = way.needs.iter().copied().filter(|key| !given.contains(key)).collect();
    if !missing.is_empty() {
        let key = of(way);
        let message = format!("`{key}` in [environment] needs {} beside it", names::list(missing, "and"));
        return Err(Fault::key(at(key), message));
    }
    match given.iter().find(|key| !way.needs.contains(key) && !way.takes.contains(key)) {
        Some(key) => Err(Fault::key(at(key), needs(key))),
        None => Ok(()),
    }
}

/// Message for a key without any of the others that it needs.
fn needs(key: &str) -> String {
    let ways = WAYS.iter().filter(|way| way.takes.contains(&key));
    // A way is known by its last key.
    let keys = ways.filter_map(|way| way.needs.last().copied());
    format!("`{key}` in [environment] needs {} beside it", names::list(keys, "or"))
}

/// Angles are reduced while they are precise.
fn rotation_degrees(file: &EnvironmentFile) -> f32 {
    file.rotation_degrees.map_or(0.0, |degrees: Coordinate| degrees.0.rem_euclid(360.0) as f32)
}

fn intensity(given: Option<Brightness>) -> f32 {
    given.map_or(1.0, |intensity| intensity.0 as f32)
}

fn sky(sun: SunPlace, file: &EnvironmentFile, files: &mut Files<'_>) -> Result<Environment, Fault> {
    let toward = sun.direction();
    if toward.y < -HORIZON {
        let degrees = (-toward.y).asin().to_degrees();
        return Err(match sun {
            SunPlace::Direction(_) => Fault::value(
                steps!["environment", "sun_direction"],
                "`sun_direction` in [environment] points below the horizon, where the sky by day is not known: its y must \
                 be 0 or more",
            ),
            SunPlace::Moment { .. } => Fault::value(
                steps!["environment", "time"],
                format!(
                    "the sun is {degrees:.1} degrees below the horizon at this `time` in [environment], and the sky is \
                     known by day alone: choose a time between sunrise and sunset"
                ),
            ),
        });
    }
    let turbidity = file.turbidity.map_or(Sky::TURBIDITY, |turbidity| turbidity.0 as f32);
    let ground_albedo = file.ground_albedo.map_or(Vec3::splat(Sky::GROUND_ALBEDO), |albedo| vec3(albedo.0));
    let sun_intensity = intensity(file.sun_intensity);
    // Only what is on the horizon, or a rounding below it, is moved.
    let toward = DVec3::new(toward.x, toward.y.max(0.0), toward.z);
    Ok(Environment::Sky(Sky {
        sun,
        turbidity,
        ground_albedo,
        sun_intensity,
        rotation_degrees: rotation_degrees(file),
        intensity: intensity(file.intensity),
        image: files.assets.sky(toward, turbidity, ground_albedo, sun_intensity),
    }))
}
