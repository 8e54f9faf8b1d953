//! Light from outside: one radiance, a gradient, or an image.

use super::{Files, first_given, vec3};
use crate::fault::{Fault, steps};
use crate::file::EnvironmentFile;
use crate::scene::Environment;

pub(super) fn environment(file: &EnvironmentFile, files: &mut Files<'_>) -> Result<Environment, Fault> {
    if let Some(path) = &file.image {
        return image(path, file, files);
    }
    refuse_without_image(file)?;
    let message = match (file.color, file.horizon, file.zenith) {
        (Some(color), None, None) => return Ok(Environment::Constant(vec3(color.0))),
        (None, Some(horizon), Some(zenith)) => {
            let (horizon, zenith) = (vec3(horizon.0), vec3(zenith.0));
            return Ok(Environment::Gradient { horizon, zenith });
        }
        (None, None, None) => "[environment] is empty: give it `color`, or `horizon` and `zenith`, or `image`",
        (None, Some(_), None) => "`horizon` in [environment] needs `zenith` beside it",
        (None, None, Some(_)) => "`zenith` in [environment] needs `horizon` beside it",
        (Some(_), ..) => {
            "`color` in [environment] cannot stand beside `horizon` and `zenith`: keep one or the \
             other"
        }
    };
    Err(match colors(file) {
        Some(key) => Fault::key(steps!["environment", key], message),
        None => Fault::value(steps!["environment"], message),
    })
}

/// The first given key that is a colour.
fn colors(file: &EnvironmentFile) -> Option<&'static str> {
    first_given(&[
        ("color", file.color.is_some()),
        ("horizon", file.horizon.is_some()),
        ("zenith", file.zenith.is_some()),
    ])
}

fn image(path: &str, file: &EnvironmentFile, files: &mut Files<'_>) -> Result<Environment, Fault> {
    if let Some(key) = colors(file) {
        let message = format!("`{key}` in [environment] cannot stand beside `image`: keep one or the other");
        return Err(Fault::key(steps!["environment", key], message));
    }
    Ok(Environment::Image {
        image: files.image(path, steps!["environment", "image"])?,
        // Angles are reduced while they are precise.
        rotation_degrees: file.rotation_degrees.map_or(0.0, |degrees| degrees.0.rem_euclid(360.0) as f32),
        intensity: file.intensity.map_or(1.0, |intensity| intensity.0 as f32),
    })
}

fn refuse_without_image(file: &EnvironmentFile) -> Result<(), Fault> {
    let given = [("rotation_degrees", file.rotation_degrees.is_some()), ("intensity", file.intensity.is_some())];
    match first_given(&given) {
        Some(key) => {
            let message = format!("`{key}` in [environment] needs `image` beside it");
            Err(Fault::key(steps!["environment", key], message))
        }
        None => Ok(()),
    }
}
