//! Lights of KHR_lights_punctual: the light that a matte square reflects is in closed form.

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2};

use glam::DVec3;
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, matte};
use crate::gltf::picture::{Picture, Shot};

const COLOR: [f32; 3] = [0.8, 0.5, 0.25];

/// Picture of a square of side 3 that fills it, with a light.
fn lit(light: Value, mut node: Value) -> Picture {
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    let mut asset = Asset::square(matte(COLOR)).nodes(json!([{ "mesh": 0, "scale": [4, 4, 1] }, node]));
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    Shot::default().take(&asset)
}

/// Radiance that a surface reflects of this irradiance.
fn reflected(irradiance: DVec3) -> DVec3 {
    irradiance * DVec3::from_array(COLOR.map(f64::from)) * FRAC_1_PI
}

#[test]
fn points_by_the_inverse_square() {
    let light = json!({ "type": "point", "color": [1, 0.5, 0.1], "intensity": 6 });
    let intensity = 6.0 * DVec3::new(1.0, 0.5, f64::from(0.1f32));
    for [x, y, z] in [[0.0, 0.0, 1.0], [0.5, -0.75, 2.0]] {
        lit(light.clone(), json!({ "translation": [x, y, z] })).assert_shows("a point", |px, py| {
            let to = DVec3::new(x - px, y - py, z);
            reflected(intensity * to.normalize().z / to.length_squared())
        });
    }
}

#[test]
fn directional_light_by_the_cosine() {
    let light = json!({ "type": "directional", "intensity": 3 });
    // The light's -z is turned by 45 degrees about x, toward +y.
    let rotation = [22.5f64.to_radians().sin(), 0.0, 0.0, 22.5f64.to_radians().cos()];
    let picture = lit(light.clone(), json!({ "rotation": rotation }));
    picture.assert_shows("slanted light", |_, _| reflected(DVec3::splat(3.0 * FRAC_1_SQRT_2)));
    let picture = lit(light, json!({ "rotation": [1, 0, 0, 0] }));
    picture.assert_shows("light from behind", |_, _| DVec3::ZERO);
}

/// Cones have full light inside, none outside, and the extension's square in between.
#[test]
fn spots_have_cones() {
    let (inner, outer) = (0.35f64, 0.6f64);
    let spot = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
    let light = json!({ "type": "spot", "intensity": 10, "spot": spot });
    let picture = lit(light, json!({ "translation": [0, 0, 2] }));
    let mut seen = [0; 3];
    picture.assert_shows("a spot", |x, y| {
        let to = DVec3::new(-x, -y, 2.0);
        let cosine = to.normalize().z;
        let fade = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        reflected(DVec3::splat(10.0 * fade * fade * cosine / to.length_squared()))
    });
    for radiance in &picture.0 {
        seen[usize::from(radiance.x > 0.0) + usize::from(radiance.x > 0.4)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 20), "outside, between and inside are {seen:?} pixels");
}

/// Light does not come through something in the way.
#[test]
fn lights_have_shadows() {
    let nodes = json!([
        { "mesh": 0, "scale": [4, 4, 1] },
        { "mesh": 0, "translation": [0, 0, 1], "scale": [0.5, 0.5, 1] },
        { "translation": [0, 0, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    ]);
    let mut asset = Asset::square(matte([1.0; 3])).nodes(nodes);
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let picture = Shot::default().take(&asset);
    // The shadow is 1 wide, and the camera sees past what throws it from 0.375 on.
    for (x, y, dark) in [(0.44, 0.0, true), (0.0, -0.44, true), (0.56, 0.0, false), (0.0, 0.56, false)] {
        assert_eq!(picture.at(x, y) == DVec3::ZERO, dark, "{} at ({x}, {y})", picture.at(x, y));
    }
}
