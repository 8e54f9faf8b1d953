//! Transparency: coverage, thin sheets, bodies, leaves; and unlit surfaces, which need no light.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, DVec3};
use raggio_scene::Integrator;
use raggio_tests::Pcg;
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, glowing, matte, merged};
use crate::gltf::picture::{Shot, within};

fn smooth(color: [f32; 3], extensions: Value) -> Value {
    let [red, green, blue] = color;
    let factors = json!({ "baseColorFactor": [red, green, blue, 1], "metallicFactor": 0, "roughnessFactor": 0 });
    json!({ "pbrMetallicRoughness": factors, "extensions": extensions })
}

/// Nothing is there where alpha (factor x texture x vertices) is below the cutoff.
#[test]
fn masks_cut() {
    let texels = [[0, 0, 0, 255], [0, 0, 0, 127], [0, 0, 0, 64], [0, 0, 0, 0]];
    let cases = [
        ("the default cutoff", json!({ "alphaMode": "MASK" }), 1.0, -0.25),
        ("a lower cutoff", json!({ "alphaMode": "MASK", "alphaCutoff": 0.2 }), 1.0, 0.25),
        ("a factor", json!({ "alphaMode": "MASK", "alphaCutoff": 0.2 }), 0.5, 0.0),
        ("opaque", json!({ "alphaMode": "OPAQUE" }), 1.0, 0.5),
    ];
    for (what, mode, alpha, right) in cases {
        let base = json!({ "baseColorFactor": [0, 0, 0, alpha], "baseColorTexture": { "index": 0 } });
        let material = merged(merged(glowing(), mode), json!({ "pbrMetallicRoughness": base }));
        let asset = Asset::square(material).texture(&[&texels], json!({ "magFilter": 9728 }));
        Shot::default().take(&asset).assert_lit(what, |x, y| within([0.0, 0.0], [1.0, 1.0])(x, y) && x < right);
    }
    // The vertices' alpha multiplies too.
    let material = merged(glowing(), json!({ "alphaMode": "MASK" }));
    let colors = [[1.0f32, 1.0, 1.0, 0.4], [1.0, 1.0, 1.0, 0.9], [1.0, 1.0, 1.0, 0.9], [1.0, 1.0, 1.0, 0.4]];
    let asset = Asset::square(material).with("COLOR_0", "VEC4", colors.as_flattened());
    let picture = Shot::default().take(&asset);
    // Alpha is 1/2 at a fifth of the way.
    picture.assert_lit("vertices", |x, y| within([0.0, 0.0], [1.0, 1.0])(x, y) && x > -0.3);
}

/// A magnified mask is cut along the line where the blend of its texels crosses the cutoff.
#[test]
fn masks_are_cut_between_texels() {
    let texels = [[0, 0, 0, 255], [0, 0, 0, 0]];
    for (cutoff, right) in [(0.5, 0.0), (0.25, 0.125), (0.75, -0.125)] {
        let base = json!({ "baseColorFactor": [0, 0, 0, 1], "baseColorTexture": { "index": 0 } });
        let mode = json!({ "alphaMode": "MASK", "alphaCutoff": cutoff, "pbrMetallicRoughness": base });
        let asset = Asset::square(merged(glowing(), mode)).texture(&[&texels], json!({ "wrapS": 33071 }));
        let inside = within([0.0, 0.0], [1.0, 1.0]);
        let picture = Shot { samples: 16, ..Shot::default() }.take(&asset);
        picture.assert_lit(&format!("cutoff {cutoff}"), |x, y| inside(x, y) && x < right);
    }
}

/// Light without size passes smooth sheets straight, as much as they let pass: any number of them, as far as a path may
/// be long that meets each.
#[test]
fn sheets_let_light_without_size_pass() {
    let color = [0.9, 0.5, 0.25f32];
    let light = json!({ "type": "directional", "intensity": 3 });
    for integrator in [Integrator::Path, Integrator::Reference] {
        for count in 0..4u32 {
            let mut asset = Asset::square(matte([0.5; 3]));
            let sheet = smooth(color, json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } }));
            let sheet = asset.push("materials", sheet);
            let mut pane = asset.json["meshes"][0].clone();
            pane["primitives"][0]["material"] = json!(sheet);
            let pane = asset.push("meshes", pane);
            let mut nodes = vec![
                json!({ "mesh": 0, "scale": [4, 4, 1] }),
                json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
            ];
            // Behind the camera.
            let panes = (0..count).map(|i| json!({ "mesh": pane, "translation": [0, 0, 4 + i], "scale": [20, 20, 1] }));
            nodes.extend(panes);
            let mut asset = asset.nodes(json!(nodes));
            asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light.clone()] } });
            // A sheet reflects 0.04 of what falls on it squarely, and lets the rest pass in its colour.
            let left = DVec3::from_array(color.map(|c| (0.96 * f64::from(c)).powi(count as i32)));
            let expected = 3.0 * 0.5 * FRAC_1_PI * left;
            for (depth, expected) in [(2 + count, expected), (1 + count, DVec3::ZERO)] {
                let picture = Shot { samples: 1, depth, integrator, ..Shot::default() }.take(&asset);
                picture.assert_shows(&format!("{integrator}: {count} sheets, {depth} rays"), |_, _| expected);
            }
        }
    }
}

/// The sun over a floor beneath a pane: what passes the pane, and what goes to and fro between floor and pane. The light
/// is followed here by hand, with glTF's one boundary of the index 1.5.
#[test]
fn sheets_send_light_back_to_the_floor() {
    let mut asset = Asset::square(matte([0.5; 3]));
    let sheet = smooth([1.0; 3], json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } }));
    let sheet = asset.push("materials", sheet);
    let mut pane = asset.json["meshes"][0].clone();
    pane["primitives"][0]["material"] = json!(sheet);
    let pane = asset.push("meshes", pane);
    // The camera is between both.
    let mut asset = asset.nodes(json!([
        { "mesh": 0, "scale": [40, 40, 1] },
        { "mesh": pane, "translation": [0, 0, 4], "scale": [40, 40, 1] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    ]));
    let light = json!({ "type": "directional", "intensity": 3 });
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let found = Shot { samples: 4096, depth: 12, ..Shot::default() }.take(&asset).middle().x;

    let reflectance = |cosine: f64| {
        let across = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
        let parallel = (cosine - 1.5 * across) / (cosine + 1.5 * across);
        let perpendicular = (1.5 * cosine - across) / (1.5 * cosine + across);
        0.5 * (parallel * parallel + perpendicular * perpendicular)
    };
    let mut random = Pcg::new(5);
    let (count, mut sum) = (200_000, 0.0);
    for _ in 0..count {
        let (mut at, mut weight) = (DVec2::ZERO, 1.0);
        for _ in 0..11 {
            sum += weight * 0.5 * FRAC_1_PI * 3.0 * (1.0 - reflectance(1.0));
            let (u, turn) = (f64::from(random.unit()), DVec2::from_angle(TAU * f64::from(random.unit())));
            let (sine, cosine) = (u.sqrt(), (1.0 - u).sqrt());
            let step = 4.0 * sine / cosine * turn;
            let met = at + step;
            if met.abs().max_element() > 20.0 || (at + 2.0 * step).abs().max_element() > 20.0 {
                break;
            }
            at += 2.0 * step;
            weight *= 0.5 * reflectance(cosine);
        }
    }
    let expected = sum / f64::from(count);
    assert!(expected > 1.02 * 1.5 * FRAC_1_PI * 0.96, "the light that comes back counts: {expected}");
    assert!((found / expected - 1.0).abs() < 4e-3, "{found}, not {expected}");
}

/// What is there in part, and passes light where it is, lets both parts pass.
#[test]
fn sheets_with_coverage_let_light_pass() {
    let alpha = 0.5;
    let sheet = merged(
        smooth([0.5; 3], json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } })),
        json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, alpha] } }),
    );
    let mut asset = Asset::square(matte([0.5; 3]));
    let sheet = asset.push("materials", sheet);
    let mut pane = asset.json["meshes"][0].clone();
    pane["primitives"][0]["material"] = json!(sheet);
    let pane = asset.push("meshes", pane);
    let mut asset = asset.nodes(json!([
        { "mesh": 0, "scale": [4, 4, 1] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        // No ray goes through the edge that the square's triangles share, where it would meet both.
        { "mesh": pane, "translation": [0.31, 0.13, 4], "scale": [20, 20, 1] },
    ]));
    let light = json!({ "type": "directional", "intensity": 3 });
    asset.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let found = Shot { samples: 1024, depth: 3, ..Shot::default() }.take(&asset).middle();
    let expected = 3.0 * 0.5 * FRAC_1_PI * (1.0 - alpha + alpha * 0.96 * 0.5);
    assert!((found / expected - 1.0).abs().max_element() < 0.01, "{found}, not {expected}");
}

/// Blending is chance: on average a part of the square's light and the rest of what is behind.
#[test]
fn blending_mixes() {
    for alpha in [0.25, 0.8] {
        let base = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, alpha] }, "alphaMode": "BLEND" });
        let environment = "color = [0, 0, 0.5]".into();
        let shot = Shot { environment, samples: 1024, depth: 3, ..Shot::default() };
        let picture = shot.take(&Asset::square(merged(glowing(), base)));
        let mean = (-4..4).flat_map(|i| (-4..4).map(move |j| (i, j)));
        let mean =
            mean.map(|(i, j)| picture.at(f64::from(i) / 8.0 + 0.06, f64::from(j) / 8.0 + 0.06)).sum::<DVec3>() / 64.0;
        let expected = DVec3::new(alpha, alpha, alpha + 0.5 * (1.0 - alpha));
        // The mean is of 65536 coins.
        assert!((mean - expected).abs().max_element() < 0.008, "alpha {alpha}: {mean}, not {expected}");
    }
}

/// Both sides are there, whatever `doubleSided` says.
#[test]
fn surfaces_have_two_sides() {
    for double_sided in [false, true] {
        let material = merged(glowing(), json!({ "doubleSided": double_sided }));
        let asset = Asset::square(material).nodes(json!([{ "mesh": 0, "rotation": [0, 1, 0, 0] }]));
        let what = format!("from behind, doubleSided {double_sided}");
        Shot::default().take(&asset).assert_lit(&what, within([0.0, 0.0], [1.0, 1.0]));
    }
}

#[test]
fn unlit_surfaces_are_their_color() {
    let unlit = json!({ "KHR_materials_unlit": {} });
    let base = json!({ "baseColorFactor": [0.9, 0.5, 0.1, 1], "baseColorTexture": { "index": 0 } });
    let material = json!({ "pbrMetallicRoughness": base, "extensions": unlit });
    let asset = Asset::square(material).texture(&[&[[255, 188, 255, 255]]], json!({}));
    let half = ((188.0f64 / 255.0 + 0.055) / 1.055).powf(2.4);
    let color = DVec3::new(0.9, 0.5 * half, 0.1);
    for environment in ["color = [0, 0, 0]", "color = [1, 1, 1]"] {
        let shot = Shot { environment: environment.into(), ..Shot::default() };
        let sky = if environment.contains('1') { DVec3::ONE } else { DVec3::ZERO };
        let inside = |x: f64, y: f64| if within([0.0, 0.0], [1.0, 1.0])(x, y) { color } else { sky };
        shot.take(&asset).assert_shows("unlit", inside);
    }
}

/// Colours of vertices are all the colour that many unlit models have.
#[test]
fn unlit_surfaces_have_the_colors_of_their_vertices() {
    let material = json!({ "extensions": { "KHR_materials_unlit": {} } });
    let colors = [[1.0f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let asset = Asset::square(material).with("COLOR_0", "VEC3", colors.as_flattened());
    Shot::default().take(&asset).assert_shows("unlit vertices", |x, y| {
        let on = within([0.0, 0.0], [1.0, 1.0])(x, y);
        if on { DVec3::new(0.5 - x, 0.5 + x, 0.0) } else { DVec3::ZERO }
    });
}

/// A thin sheet in a furnace shows what it reflects, and the rest in its colour.
#[test]
fn thin_sheets_transmit_their_color() {
    let color = [0.9, 0.5, 0.1f32];
    let sheet = smooth(color, json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } }));
    let picture = Shot { samples: 4096, depth: 3, ..Shot::furnace() }.take(&Asset::square(sheet));
    let expected = 0.04 + 0.96 * DVec3::from_array(color.map(f64::from));
    picture.assert_at("a sheet", (0.0625, 0.0625), expected, 0.01);
}

/// The factor, and red of the texture, leave the rest to the matte part: over a lamp behind it.
#[test]
fn transmission_by_factor_and_texture() {
    let lamp = json!({ "translation": [0, 0, -1], "scale": [2, 2, 1], "mesh": 1 });
    for (texel, part) in [(255u8, 0.8), (51, 0.16)] {
        let transmission = json!({ "transmissionFactor": 0.8, "transmissionTexture": { "index": 0 } });
        let extensions = json!({
            "KHR_materials_transmission": transmission,
            "KHR_materials_ior": { "ior": 1 },
        });
        let mut asset = Asset::square(smooth([1.0; 3], extensions)).texture(&[&[[texel, 0, 0, 255]]], json!({}));
        let glow = asset.push("materials", glowing());
        let mut other = asset.json["meshes"][0].clone();
        other["primitives"][0]["material"] = json!(glow);
        asset.push("meshes", other);
        asset.push("nodes", lamp.clone());
        // Paths have two rays: nothing that is scattered finds the lamp.
        let picture = Shot { samples: 4096, depth: 2, ..Shot::default() }.take(&asset);
        let found = picture.at(0.0625, 0.0625).x;
        // The matte part scatters no light backward through the square: the lamp is behind it.
        assert!((found - part).abs() < 0.03, "texel {texel}: {found} of the lamp's light, not {part}");
    }
}

/// The light left after a way of 1 through the body is the attenuation colour to the power of 1 over its distance.
#[test]
fn volumes_absorb() {
    for distance in [0.5, 1.0, 4.0] {
        let attenuation = [0.7, 0.9, 0.3f64];
        let volume = json!({
            "thicknessFactor": 1, "attenuationColor": attenuation, "attenuationDistance": distance,
        });
        let extensions = json!({
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": volume,
            "KHR_materials_ior": { "ior": 1 },
        });
        let asset = Asset::cube(smooth([1.0; 3], extensions));
        let picture = Shot { samples: 16, depth: 4, ..Shot::furnace() }.take(&asset);
        let expected = DVec3::from_array(attenuation.map(|left| left.powf(1.0 / distance)));
        picture.assert_at(&format!("a distance of {distance}"), (0.0625, 0.0625), expected, 2e-3);
    }
}

/// A leaf hangs under a sky that is bright behind it alone.
#[test]
fn leaves_transmit_diffusely() {
    let color = [0.2, 0.9, 0.4f32];
    let transmission = json!({ "diffuseTransmissionFactor": 0.75, "diffuseTransmissionColorFactor": color });
    let leaf = merged(
        matte([1.0, 0.5, 0.25]),
        json!({
            "extensions": { "KHR_materials_diffuse_transmission": transmission },
        }),
    );
    let picture = Shot { samples: 4096, ..Shot::furnace() }.take(&Asset::square(leaf));
    let expected = 0.25 * DVec3::new(1.0, 0.5, 0.25) + 0.75 * DVec3::from_array(color.map(f64::from));
    picture.assert_at("a leaf in a furnace", (0.0625, 0.0625), expected, 0.03);
}

/// A body of glass that bends each colour differently parts them; in a furnace all of them are there.
#[test]
fn dispersion_parts_colors() {
    let glass = |dispersion: f64| {
        let extensions = json!({
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1 },
            "KHR_materials_ior": { "ior": 1.5 },
            "KHR_materials_dispersion": { "dispersion": dispersion },
        });
        let turned = json!([{ "mesh": 0, "rotation": [0.0, 0.3, 0.0, 0.954] }]);
        Asset::cube(smooth([1.0; 3], extensions)).nodes(turned)
    };
    // A narrow lamp behind the body.
    let more = "[materials.lamp]\nemission_strength = 20\n[[shapes]]\nmaterial = \"lamp\"\n\
                sphere = { center = [0.4, 0, -4], radius = 0.2 }\n";
    let shot = Shot { samples: 512, depth: 8, more: more.into(), ..Shot::default() };
    let part = |dispersion| {
        let picture = shot.take(&glass(dispersion));
        let apart: f64 = picture.0.iter().map(|c| c.max_element() - c.min_element()).sum();
        apart / picture.0.iter().map(|c| c.max_element()).sum::<f64>()
    };
    let (none, some) = (part(0.0), part(4.0));
    assert!(none < 1e-6, "without dispersion glass is colourless: {none}");
    assert!(some > 0.1, "with dispersion, {some} of the light is coloured");

    let furnace = Shot { samples: 8192, depth: 64, ..Shot::furnace() }.take(&glass(4.0));
    let mean = furnace.0.iter().sum::<DVec3>() / furnace.0.len() as f64;
    assert!((mean - 1.0).abs().max_element() < 3e-3, "in a furnace all colours are there: {mean}");
}

/// Variants name other materials: the picture is of the default, and the user is told.
#[test]
fn variants_are_told() {
    let mut asset = Asset::square(glowing());
    let other = asset.push("materials", matte([0.0; 3]));
    asset.json["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "dark" }] } });
    let mappings = json!([{ "material": other, "variants": [0] }]);
    asset.primitive()["extensions"] = json!({ "KHR_materials_variants": { "mappings": mappings } });
    Shot::default().take(&asset).assert_lit("the default", within([0.0, 0.0], [1.0, 1.0]));
    let warnings = Shot::default().scene(&asset).warnings;
    assert!(warnings.iter().any(|w| w.contains("variant") && w.contains("dark")), "{warnings:?}");
}
