//! The layers and lobes of materials: the file's words and the scene file's give the same picture, and the feature makes
//! it brighter or darker by so much.

use glam::DVec3;
use raggio_scene::Integrator;
use raggio_tests::for_each_device;
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, matte, merged, png};
use crate::gltf::picture::Shot;

/// Texel of each kind of texture, all channels different.
const TEXEL: [u8; 4] = [204, 102, 153, 51];

struct Case {
    what: &'static str,
    /// Material in glTF's words; texture 0 is of one `TEXEL`.
    json: Value,
    /// Material in the scene file's words; "t.png" has that texel.
    own: &'static str,
    /// Material without the feature, in the scene file's words.
    without: &'static str,
    /// Least and largest mean of the picture's colours over those without the feature.
    ratio: [f64; 2],
}

fn pbr(factors: Value) -> Value {
    json!({ "pbrMetallicRoughness": merged(json!({ "baseColorFactor": [0.8, 0.4, 0.2, 1] }), factors) })
}

fn extended(factors: Value, extension: &str, values: Value) -> Value {
    merged(pbr(factors), json!({ "extensions": { extension: values } }))
}

fn plastic(extension: &str, values: Value) -> Value {
    extended(json!({ "metallicFactor": 0, "roughnessFactor": 0.3 }), extension, values)
}

const PLASTIC: &str = "base_color = [0.8, 0.4, 0.2], metallic = 0, roughness = 0.3";

fn reflections() -> Vec<Case> {
    let metal = json!({ "metallicFactor": 1, "roughnessFactor": 0.3 });
    let both = json!({ "metallicFactor": 1, "roughnessFactor": 1, "metallicRoughnessTexture": { "index": 0 } });
    let brushed = json!({ "anisotropyStrength": 0.9, "anisotropyRotation": 0.5235987755982988 });
    vec![
        Case {
            what: "metal",
            json: pbr(metal.clone()),
            own: "base_color = [0.8, 0.4, 0.2], metallic = 1, roughness = 0.3",
            without: PLASTIC,
            ratio: [0.75, 0.79],
        },
        Case {
            what: "blue is metallic, green is roughness",
            json: pbr(both),
            own: "base_color = [0.8, 0.4, 0.2], metallic = 0.6, roughness = 0.4",
            without: "base_color = [0.8, 0.4, 0.2], metallic = 1, roughness = 1",
            ratio: [1.31, 1.38],
        },
        Case {
            what: "index of refraction",
            json: plastic("KHR_materials_ior", json!({ "ior": 2.4 })),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, ior = 2.4",
            without: PLASTIC,
            ratio: [1.08, 1.13],
        },
        Case {
            what: "specular strength and colour",
            json: plastic(
                "KHR_materials_specular",
                json!({ "specularFactor": 1, "specularTexture": { "index": 0 }, "specularColorFactor": [4, 2, 0.5] }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, specular_texture = \"t.png\", specular_color = [4, 2, 0.5]",
            without: PLASTIC,
            ratio: [0.93, 0.975],
        },
        Case {
            what: "anisotropy",
            json: extended(metal, "KHR_materials_anisotropy", brushed),
            own: "base_color = [0.8, 0.4, 0.2], metallic = 1, roughness = 0.3, anisotropy = 0.9, anisotropy_rotation = 30",
            without: "base_color = [0.8, 0.4, 0.2], metallic = 1, roughness = 0.3",
            ratio: [0.77, 0.81],
        },
    ]
}

fn layers() -> Vec<Case> {
    vec![
        Case {
            what: "clear coat",
            json: plastic(
                "KHR_materials_clearcoat",
                json!({ "clearcoatFactor": 1, "clearcoatTexture": { "index": 0 }, "clearcoatRoughnessFactor": 0.5,
                        "clearcoatRoughnessTexture": { "index": 0 } }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, clearcoat_texture = \"t.png\", \
                  clearcoat_roughness = 0.5, clearcoat_roughness_texture = \"t.png\"",
            without: PLASTIC,
            ratio: [1.02, 1.06],
        },
        Case {
            what: "sheen",
            json: plastic(
                "KHR_materials_sheen",
                json!({ "sheenColorFactor": [0.2, 0.5, 1], "sheenRoughnessFactor": 0.6 }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, sheen_color = [0.2, 0.5, 1], sheen_roughness = 0.6",
            without: PLASTIC,
            ratio: [1.03, 1.07],
        },
        Case {
            what: "iridescence",
            json: plastic(
                "KHR_materials_iridescence",
                json!({ "iridescenceFactor": 1, "iridescenceIor": 1.8, "iridescenceThicknessMinimum": 200,
                        "iridescenceThicknessMaximum": 500, "iridescenceThicknessTexture": { "index": 0 } }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, iridescence = 1, iridescence_ior = 1.8, \
                  iridescence_thickness_minimum = 200, iridescence_thickness_maximum = 500, \
                  iridescence_thickness_texture = \"t.png\"",
            without: PLASTIC,
            ratio: [0.965, 0.995],
        },
        Case {
            what: "transmission through a rough sheet",
            json: plastic(
                "KHR_materials_transmission",
                json!({ "transmissionFactor": 1, "transmissionTexture": { "index": 0 } }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, transmission_texture = \"t.png\", thin_walled = true",
            without: PLASTIC,
            ratio: [1.17, 1.23],
        },
        Case {
            what: "diffuse transmission",
            json: plastic(
                "KHR_materials_diffuse_transmission",
                json!({ "diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": { "index": 0 },
                        "diffuseTransmissionColorFactor": [0.5, 1, 0.5] }),
            ),
            own: "base_color = [0.8, 0.4, 0.2], roughness = 0.3, diffuse_transmission = 0.5, \
                  diffuse_transmission_texture = \"t.png\", diffuse_transmission_color = [0.5, 1, 0.5], thin_walled = true",
            without: PLASTIC,
            ratio: [1.06, 1.11],
        },
    ]
}

/// Asset of a square that is tilted, so that the eye sees it at 50 degrees to its normal.
fn tilted(material: Value) -> Asset {
    let half = 25f64.to_radians();
    let node =
        json!({ "mesh": 0, "scale": [2, 2, 1], "rotation": [half.sin() * 0.6, half.sin() * 0.8, 0, half.cos()] });
    Asset::square(material).nodes(json!([node])).texture(&[&[TEXEL]], json!({}))
}

fn outdoors(own: &str) -> Shot {
    let files = vec![("t.png", png(&[&[TEXEL]]))];
    Shot { material: Some(own.into()), files, ..Shot::outdoors() }
}

#[test]
fn files_and_scenes_say_the_same() {
    let mut wrong = vec![];
    for Case { what, json, own, without, ratio } in reflections().into_iter().chain(layers()) {
        let asset = tilted(json);
        let (by_file, by_scene) = (Shot::outdoors().take(&asset), outdoors(own).take(&asset));
        let difference = by_file.0.iter().zip(&by_scene.0).map(|(a, b)| (*a - *b).abs().max_element());
        // A texel times a factor is rounded otherwise than their product.
        let largest = difference.fold(0.0, f64::max);
        let sum = |c: DVec3| c.x + c.y + c.z;
        let found = sum(by_file.middle()) / sum(outdoors(without).take(&asset).middle());
        if largest > 1e-6 || !(ratio[0]..ratio[1]).contains(&found) {
            wrong.push(format!("{what}: the pictures differ by {largest}; {found} times as bright as without"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Black dielectrics reflect ((n - 1) / (n + 1))^2 straight back, times strength and colour; so does a coat on top.
#[test]
fn reflectances_at_normal_incidence() {
    let black = pbr(json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 0 }));
    let coat = json!({
        "KHR_materials_specular": { "specularFactor": 0 },
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.5 },
    });
    let colored = json!({ "specularFactor": 0.5, "specularColorFactor": [1, 0.5, 3] });
    let cases = [
        ("the default index", json!({}), DVec3::splat(0.04)),
        ("index 2", json!({ "KHR_materials_ior": { "ior": 2 } }), DVec3::splat(1.0 / 9.0)),
        ("an infinite index", json!({ "KHR_materials_ior": { "ior": 0 } }), DVec3::ONE),
        ("half strength, in colour", json!({ "KHR_materials_specular": colored }), DVec3::new(0.02, 0.01, 0.06)),
        ("none but half of a coat", coat, DVec3::splat(0.02)),
    ];
    for (what, extensions, expected) in cases {
        let material = merged(black.clone(), json!({ "extensions": extensions }));
        let picture = Shot { samples: 4096, ..Shot::furnace() }.take(&Asset::square(material));
        picture.assert_at(what, (0.0625, 0.0625), expected, 1e-3);
    }
}

/// A highlight is long across the grooves: turning them by a quarter turns it.
#[test]
fn anisotropy_has_a_direction() {
    let brushed = |turn: f64| {
        let values = json!({ "anisotropyStrength": 1, "anisotropyRotation": turn });
        let factors = json!({ "metallicFactor": 1, "roughnessFactor": 0.2 });
        Asset::square(extended(factors, "KHR_materials_anisotropy", values))
            .nodes(json!([{ "mesh": 0, "scale": [4, 4, 1] }]))
    };
    // The lamp is small and stands behind the eye.
    let more = "[materials.lamp]\nemission_strength = 100\n[[shapes]]\nmaterial = \"lamp\"\n\
                sphere = { center = [0, 0, 8], radius = 1 }\n";
    let shot = Shot { samples: 2048, more: more.into(), ..Shot::default() };
    let elongation = |turn| {
        let picture = shot.take(&brushed(turn));
        let sum = |places: [(f64, f64); 4]| places.iter().map(|(x, y)| picture.at(*x, *y).x).sum::<f64>();
        let across = [(1.0, 0.0), (-1.0, 0.0), (1.2, 0.0), (-1.2, 0.0)];
        sum(across) / sum(across.map(|(x, y)| (y, x)))
    };
    let (along_x, along_y) = (elongation(0.0), elongation(std::f64::consts::FRAC_PI_2));
    assert!(along_x > 3.0 && along_y < 1.0 / 3.0, "{along_x} times as bright along x, and {along_y} when turned");
}

/// Pictures agree on every device, by either integrator; where drivers compile for minutes, by the shorter one.
#[test]
fn devices_agree_on_layers() {
    let material = merged(
        plastic("KHR_materials_clearcoat", json!({ "clearcoatFactor": 1 })),
        json!({ "extensions": { "KHR_materials_sheen": { "sheenColorFactor": [0.2, 0.5, 1] } } }),
    );
    let asset = tilted(material);
    for_each_device(|device| {
        for integrator in [Integrator::Reference, Integrator::Path].into_iter().take(device.pick(2, 1)) {
            let case = format!("{}, {integrator:?}", device.label);
            let outdoors = Shot { integrator, ..Shot::outdoors() };
            let (found, expected) = (outdoors.take_on(device.device, &asset).middle(), outdoors.take(&asset).middle());
            assert!((found - expected).abs().max_element() < 1e-3, "{case}: {found}, not {expected}");
            let furnace = Shot { integrator, ..Shot::furnace() };
            let matte = furnace.take_on(device.device, &Asset::square(matte([0.5, 0.25, 0.125])));
            matte.assert_at(&case, (0.06, 0.06), DVec3::new(0.5, 0.25, 0.125), 1e-6);
        }
    });
}
