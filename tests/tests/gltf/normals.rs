//! Maps of normals and of anisotropy: what they turn follows the coordinates that their own image lies by.

use glam::DVec3;
use raggio_scene::Integrator;
use raggio_tests::devices::cpu;
use raggio_tests::render;
use raggio_tests::render::means;
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, merged};
use crate::gltf::picture::{Picture, Shot};

/// Texel of a normal that is tilted by 30 degrees to the right in its image.
const TILTED: [u8; 4] = [191, 128, 238, 255];
/// Texel of anisotropy at full strength, along the right in its image.
const ALONG: [u8; 4] = [255, 128, 255, 255];
/// Lamps around the square, each where the square would show it if it were tilted to its side.
const LAMPS: [(&str, [f64; 2], DVec3); 4] = [
    ("right", [1.0, 0.0], DVec3::X),
    ("top", [0.0, 1.0], DVec3::Y),
    ("left", [-1.0, 0.0], DVec3::new(1.0, 1.0, 0.0)),
    ("bottom", [0.0, -1.0], DVec3::Z),
];
/// Texture coordinates that grow upward and to the right.
const SIDEWAYS: [[f32; 2]; 4] = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];

fn lamps() -> String {
    let lamp = |(name, [x, y], color): (&str, [f64; 2], DVec3)| {
        let center = 8.0 * DVec3::new(0.75f64.sqrt() * x, 0.75f64.sqrt() * y, 0.5);
        let color = color.to_array();
        let center = center.to_array();
        format!(
            "[materials.{name}]\ncolor = [0, 0, 0]\nemission_color = {color:?}\nemission_strength = 1\n\
             [[shapes]]\nmaterial = \"{name}\"\nsphere = {{ center = {center:?}, radius = 2.5 }}\n"
        )
    };
    LAMPS.map(lamp).concat()
}

fn mirror() -> Value {
    json!({ "pbrMetallicRoughness": { "roughnessFactor": 0 } })
}

/// Square of `material`, whose texture 0 is one texel all over, with a second set of coordinates that lies sideways.
fn square(material: Value, texel: [u8; 4]) -> Asset {
    Asset::square(material).texture(&[&[texel]], json!({})).with("TEXCOORD_1", "VEC2", SIDEWAYS.as_flattened())
}

/// Ways in which an image may lie, and the side that its right is on.
fn ways() -> Vec<(Value, &'static str)> {
    let transformed = |transform: Value| json!({ "extensions": { "KHR_texture_transform": transform } });
    let quarter = std::f64::consts::FRAC_PI_2;
    vec![
        (json!({}), "right"),
        (json!({ "texCoord": 1 }), "top"),
        (transformed(json!({ "texCoord": 1 })), "top"),
        (transformed(json!({ "rotation": quarter })), "bottom"),
        (transformed(json!({ "rotation": -quarter, "offset": [0.3, 0.4] })), "top"),
        (transformed(json!({ "rotation": 2.0 * quarter })), "left"),
        (transformed(json!({ "scale": [-1, 1] })), "left"),
        (transformed(json!({ "scale": [1, -1] })), "right"),
        (transformed(json!({ "scale": [3, 0.5] })), "right"),
        (transformed(json!({ "rotation": quarter, "scale": [-2, 3] })), "bottom"),
        (merged(json!({ "texCoord": 1 }), transformed(json!({ "scale": [-1, 1] }))), "bottom"),
    ]
}

fn color_of(side: &str) -> DVec3 {
    LAMPS.iter().find(|(name, ..)| *name == side).expect("a side").2
}

#[test]
fn normal_maps_follow_their_image() {
    let shot = Shot { more: lamps(), ..Shot::default() };
    for (lies, side) in ways() {
        let info = merged(json!({ "index": 0 }), lies.clone());
        let asset = square(merged(mirror(), json!({ "normalTexture": info })), TILTED);
        shot.take(&asset).assert_at(&lies.to_string(), (0.0625, 0.0625), color_of(side), 1e-5);
    }
}

/// What the file says of tangents holds for every image, however that lies.
#[test]
fn given_tangents_say_all() {
    let shot = Shot { more: lamps(), ..Shot::default() };
    for (lies, _) in ways() {
        let info = merged(json!({ "index": 0 }), lies.clone());
        let asset = square(merged(mirror(), json!({ "normalTexture": info })), TILTED)
            .with("NORMAL", "VEC3", [[0.0f32, 0.0, 1.0]; 4].as_flattened())
            .with("TANGENT", "VEC4", [[0.0f32, 1.0, 0.0, 1.0]; 4].as_flattened());
        shot.take(&asset).assert_at(&lies.to_string(), (0.0625, 0.0625), color_of("top"), 1e-5);
    }
}

/// The coat mirrors a part of its lamp, and what is beneath is black.
#[test]
fn normals_of_coats_follow_their_own_image() {
    let shot = Shot { more: lamps(), ..Shot::default() };
    for (lies, side) in ways() {
        let info = merged(json!({ "index": 0 }), lies.clone());
        let coat = json!({ "clearcoatFactor": 1, "clearcoatNormalTexture": info });
        let extensions = json!({ "KHR_materials_clearcoat": coat, "KHR_materials_specular": { "specularFactor": 0 } });
        let factors = json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 });
        let asset = square(json!({ "pbrMetallicRoughness": factors, "extensions": extensions }), TILTED);
        // Fresnel's reflectance at 30 degrees, for an index of 1.5.
        let expected = 0.0415 * color_of(side);
        let picture = Shot { samples: 64, ..shot.clone() }.take(&asset);
        assert!((picture.middle() - expected).abs().max_element() < 2e-3, "{lies}: {}", picture.middle());
    }
}

/// Light is spread along the direction of anisotropy, to both sides alike.
#[test]
fn anisotropy_follows_its_own_image() {
    let shot = Shot { more: lamps(), samples: 64, ..Shot::default() };
    for (lies, side) in ways() {
        let info = merged(json!({ "index": 0 }), lies.clone());
        let extension = json!({ "anisotropyStrength": 1, "anisotropyTexture": info });
        let factors = json!({ "roughnessFactor": 0.2 });
        let extensions = json!({ "KHR_materials_anisotropy": extension });
        let asset = square(json!({ "pbrMetallicRoughness": factors, "extensions": extensions }), ALONG);
        let DVec3 { x, y, z } = shot.take(&asset).middle();
        // Red comes from the right, red with green from the left, green from the top, blue from the bottom.
        let (across, upward) = (x, y - x.min(y) / 2.0 + z);
        let level = side == "right" || side == "left";
        let (along, other) = if level { (across, z) } else { (upward, x) };
        assert!(along > 0.02 && along > 3.0 * other, "{lies}: {along} along, {other} across");
    }
}

/// A mirror in white surroundings is white, however its normals are turned and wherever the eye is. What is nearly smooth
/// keeps what stays above the surface.
#[test]
fn turned_mirrors_keep_all_light() {
    let mapped = |roughness: f64, tilt: f64| {
        let (sine, cosine) = tilt.to_radians().sin_cos();
        let byte = |x: f64| (127.5 * x + 127.5).round() as u8;
        let factors = json!({ "roughnessFactor": roughness });
        let material = json!({ "pbrMetallicRoughness": factors, "normalTexture": { "index": 0 } });
        square(material, [byte(sine), byte(0.0), byte(cosine), 255])
    };
    for tilt in [0.0, 10.0, 20.0, 32.0, 45.0, 60.0] {
        for (integrator, view) in [Integrator::Path, Integrator::Reference]
            .into_iter()
            .flat_map(|integrator| [-85.0, -70.0, -40.0, 0.0, 40.0, 70.0, 85.0f64].map(|view| (integrator, view)))
        {
            let (sine, cosine) = (0.5 * view.to_radians()).sin_cos();
            let turned = json!([{ "mesh": 0, "scale": [9, 2, 1], "rotation": [0, sine, 0, cosine] }]);
            let picture = Shot { integrator, ..Shot::furnace() }.take(&mapped(0.0, tilt).nodes(turned));
            picture.assert_shows(&format!("{integrator}, {tilt} degrees, seen at {view}"), |_, _| DVec3::ONE);
        }
    }
    for tilt in [10.0, 20.0, 32.0] {
        let found = Shot { samples: 256, ..Shot::furnace() }.take(&mapped(0.1, tilt)).middle();
        assert!((found - 1.0).abs().max_element() < 5e-3, "{tilt} degrees: {found}");
    }
}

/// Between texels a normal map is as smooth as its blend: a mirror shows one direction at each point, whatever chance
/// says, and these change evenly from texel to texel.
#[test]
fn magnified_normals_are_blended() {
    let material = merged(mirror(), json!({ "normalTexture": { "index": 0, "texCoord": 1 } }));
    let texels = [[128, 128, 255, 255], TILTED];
    let asset = Asset::square(material).texture(&[&texels], json!({ "wrapS": 33071 })).with(
        "TEXCOORD_1",
        "VEC2",
        SIDEWAYS.as_flattened(),
    );
    let shot = Shot { environment: "horizon = [0, 0, 0]\nzenith = [1, 1, 1]".into(), ..Shot::default() };
    let pictures = [0, 7].map(|seed| {
        let mut scene = shot.scene(&asset);
        scene.render.seed = seed;
        means(&render(cpu(), &scene, 1))
    });
    assert_eq!(pictures[0], pictures[1]);
    let column = |y: f64| Picture(pictures[0].clone()).at(0.0625, y).x;
    // Upward the normal is turned upward, from texel to texel, and the sky grows brighter.
    for step in (-2..1).map(|i| column(f64::from(i + 1) / 8.0 + 0.0625) - column(f64::from(i) / 8.0 + 0.0625)) {
        assert!(step > 0.01 && step < 0.15, "{step}");
    }
}
