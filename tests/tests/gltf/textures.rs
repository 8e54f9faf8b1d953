//! Textures on surfaces: texels, how they repeat, turn and move, vertex colours, and what they mean.

use glam::DVec3;
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, UPRIGHT, glowing, matte, merged};
use crate::gltf::picture::{Picture, Shot};

/// Texels of an image: red, green; blue, white.
const FOUR: [[[u8; 4]; 2]; 2] = [[[255, 0, 0, 255], [0, 255, 0, 255]], [[0, 0, 255, 255], [255; 4]]];
/// Sampler that shows texels without anything between them.
fn nearest() -> Value {
    json!({ "magFilter": 9728 })
}

/// Colour of `FOUR` at image coordinates, which repeat.
fn four(u: f64, v: f64) -> DVec3 {
    let half = |x: f64| usize::from(x.rem_euclid(1.0) >= 0.5);
    let [red, green, blue, _] = FOUR[half(v)][half(u)].map(|byte| f64::from(byte) / 255.0);
    DVec3::new(red, green, blue)
}

/// Asset of the square that shines with `FOUR`, by a texture that is `info` besides.
fn shining(info: Value, sampler: Value, uvs: [[f32; 2]; 4]) -> Asset {
    let material = merged(glowing(), json!({ "emissiveTexture": merged(json!({ "index": 0 }), info) }));
    let rows: Vec<&[[u8; 4]]> = FOUR.iter().map(|row| &row[..]).collect();
    Asset::square(material).texture(&rows, merged(nearest(), sampler)).with("TEXCOORD_0", "VEC2", uvs.as_flattened())
}

/// Checks that the square shows at (u, v) of itself what `expected` says, and that there is nothing around it.
#[track_caller]
fn assert_shows(what: &str, picture: &Picture, expected: impl Fn(f64, f64) -> DVec3) {
    picture.assert_shows(what, |x, y| {
        let on = x.abs() < 0.5 && y.abs() < 0.5;
        if on { expected(x + 0.5, 0.5 - y) } else { DVec3::ZERO }
    });
}

#[test]
fn images_stand_upright() {
    let picture = Shot::default().take(&shining(json!({}), json!({}), UPRIGHT));
    assert_shows("four colours", &picture, four);
}

#[test]
fn images_repeat_as_samplers_say() {
    let wide = UPRIGHT.map(|uv| uv.map(|x| 4.0 * x - 1.5));
    let mirrored = |x: f64| if x.floor().rem_euclid(2.0) == 0.0 { x - x.floor() } else { 1.0 - (x - x.floor()) };
    let clamped = |x: f64| x.clamp(0.0, 0.999);
    /// Name of the case, sampler of the file, and colour that the picture shows at a point of it.
    type Case<'a> = (&'a str, Value, &'a dyn Fn(f64, f64) -> DVec3);
    let cases: [Case<'_>; 4] = [
        ("repeat", json!({}), &four),
        ("mirrored", json!({ "wrapS": 33648, "wrapT": 33648 }), &|u, v| four(mirrored(u), mirrored(v))),
        ("clamped", json!({ "wrapS": 33071, "wrapT": 33071 }), &|u, v| four(clamped(u), clamped(v))),
        ("clamped across", json!({ "wrapS": 33071, "wrapT": 10497 }), &|u, v| four(clamped(u), v)),
    ];
    for (what, sampler, expected) in cases {
        let picture = Shot::default().take(&shining(json!({}), sampler, wide));
        assert_shows(what, &picture, |u, v| expected(4.0 * u - 1.5, 4.0 * v - 1.5));
    }
}

/// Transforms scale, then turn counter-clockwise for the eye, then offset; the scene file's table says so too.
#[test]
fn transforms_of_textures() {
    let degrees = 90.0f64;
    let cases = [
        ("an offset", json!({ "offset": [0.25, 0.5] }), "offset = [0.25, 0.5]"),
        ("a scale", json!({ "scale": [2, 3] }), "scale = [2, 3]"),
        ("a turn", json!({ "rotation": 0.5 }), "rotation_degrees = 28.64788975654116"),
        (
            "the extension's example: the lower left quarter, turned clockwise",
            json!({ "offset": [0, 1], "rotation": degrees.to_radians(), "scale": [0.5, 0.5] }),
            "offset = [0, 1], rotation_degrees = 90, scale = [0.5, 0.5]",
        ),
        (
            "all three",
            json!({ "offset": [0.1, 0.7], "rotation": -0.8, "scale": [1.5, 0.75] }),
            "offset = [0.1, 0.7], rotation_degrees = -45.83662361046586, scale = [1.5, 0.75]",
        ),
    ];
    for (what, transform, table) in cases {
        let number = |key: &str, i: usize, default: f64| transform[key][i].as_f64().unwrap_or(default);
        let (sine, cosine) = transform["rotation"].as_f64().unwrap_or(0.0).sin_cos();
        let expected = |u: f64, v: f64| {
            let (u, v) = (u * number("scale", 0, 1.0), v * number("scale", 1, 1.0));
            let (u, v) = (cosine * u + sine * v, -sine * u + cosine * v);
            four(u + number("offset", 0, 0.0), v + number("offset", 1, 0.0))
        };
        let extensions = json!({ "extensions": { "KHR_texture_transform": transform } });
        let asset = shining(extensions, json!({}), UPRIGHT);
        assert_shows(what, &Shot::default().take(&asset), expected);

        let texture = format!("{{ image = \"four.png\", filter = \"nearest\", {table} }}");
        let own = format!("base_color = [0, 0, 0], specular = 0, emissive = [1, 1, 1], emissive_texture = {texture}");
        let rows: Vec<&[[u8; 4]]> = FOUR.iter().map(|row| &row[..]).collect();
        let files = vec![("four.png", crate::gltf::asset::png(&rows))];
        let shot = Shot { material: Some(own), files, ..Shot::default() };
        assert_shows(&format!("{what}, by the scene file"), &shot.take(&asset), expected);
    }
}

#[test]
fn second_coordinates() {
    let turned = UPRIGHT.map(|[u, v]| [v, u]);
    let of_second = |info| shining(info, json!({}), UPRIGHT).with("TEXCOORD_1", "VEC2", turned.as_flattened());
    let picture = Shot::default().take(&of_second(json!({ "texCoord": 1 })));
    assert_shows("the second set", &picture, |u, v| four(v, u));
    let overridden = json!({ "extensions": { "KHR_texture_transform": { "texCoord": 1 } } });
    let picture = Shot::default().take(&of_second(overridden));
    assert_shows("the transform's own set", &picture, |u, v| four(v, u));
}

/// A checkerboard needs no image: its fields have the side 1 in texture coordinates, the first colour at their origin.
#[test]
fn checkerboards() {
    let (first, second) = (DVec3::new(0.75, 0.5, 0.25), DVec3::new(0.125, 0.0, 1.0));
    let board = "checker = [[0.75, 0.5, 0.25], [0.125, 0, 1]]";
    for (table, scale, offset) in [
        ("scale = [4, 4]", [4.0, 4.0], [0.0, 0.0]),
        ("scale = [8, 2], offset = [1, 0]", [8.0, 2.0], [1.0, 0.0]),
        ("scale = [4, 0]", [4.0, 0.0], [0.0, 0.0]),
    ] {
        let own = format!(
            "base_color = [0, 0, 0], specular = 0, emissive = [1, 1, 1], emissive_texture = {{ {board}, {table} }}"
        );
        let shot = Shot { material: Some(own), ..Shot::default() };
        assert_shows(table, &shot.take(&Asset::square(glowing())), |u, v| {
            let field = (u * scale[0] + offset[0]).floor() + (v * scale[1] + offset[1]).floor();
            if field.rem_euclid(2.0) == 0.0 { first } else { second }
        });
    }
}

/// More colours take turns, along both sides.
#[test]
fn checkerboards_of_more_colors() {
    let colors =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.5, 0.25, 0.75]].map(DVec3::from_array);
    for count in [3, 5] {
        let board: Vec<_> = colors[..count].iter().map(DVec3::to_array).collect();
        let own = format!(
            "base_color = [0, 0, 0], specular = 0, emissive = [1, 1, 1], \
             emissive_texture = {{ checker = {board:?}, scale = [8, 4], offset = [-2, 1] }}"
        );
        let shot = Shot { material: Some(own), ..Shot::default() };
        assert_shows(&format!("{count} colours"), &shot.take(&Asset::square(glowing())), |u, v| {
            let field = (u * 8.0 - 2.0).floor() + (v * 4.0 + 1.0).floor();
            colors[field.rem_euclid(count as f64) as usize]
        });
    }
}

/// Light between texels is blended: halfway between 0 and 1 it is a half.
#[test]
fn linear_filters_blend() {
    let material = merged(glowing(), json!({ "emissiveTexture": { "index": 0 } }));
    let asset = Asset::square(material).texture(&[&[[0, 0, 0, 255], [255; 4]]], json!({ "magFilter": 9729 }));
    let picture = Shot { samples: 4096, ..Shot::default() }.take(&asset);
    for x in [-0.1875, 0.0625, 0.1875] {
        let expected = (2.0 * (x + 0.5) - 0.5f64).clamp(0.0, 1.0);
        picture.assert_at("between black and white", (x, 0.1), DVec3::splat(expected), 0.04);
    }
}

fn linear(byte: u8) -> f64 {
    let x = f64::from(byte) / 255.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// A matte surface in a furnace is its colour: factor x texture (from sRGB) x colour of the vertices (linear).
#[test]
fn base_colors_multiply() {
    let factor = [0.5, 0.25, 1.0f32];
    let textured = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let plain = Asset::square(matte(factor));
    let texel = [200, 100, 50, 255];
    let image = Asset::square(merged(matte(factor), textured)).texture(&[&[texel]], json!({}));
    let vertices = [[0.5, 0.5, 0.25f32]; 4];
    let factor = DVec3::from_array(factor.map(f64::from));
    let texel = DVec3::new(linear(200), linear(100), linear(50));
    let vertex = DVec3::new(0.5, 0.5, 0.25);
    let colored = |asset: Asset| asset.with("COLOR_0", "VEC3", vertices.as_flattened());
    let cases = [
        ("the factor", plain.clone(), factor),
        ("and the texture", image.clone(), factor * texel),
        ("and colours of vertices", colored(plain), factor * vertex),
        ("all three", colored(image), factor * texel * vertex),
    ];
    for (what, asset, color) in cases {
        let inside = |x: f64, y: f64| if x.abs() < 0.5 && y.abs() < 0.5 { color } else { DVec3::ONE };
        Shot::furnace().take(&asset).assert_shows(what, inside);
    }
}

/// Vertex colours change evenly from one corner to the next. None is so dark that roulette would add noise.
#[test]
fn vertex_colors_are_interpolated() {
    let colors = [[0.2f32, 0.2, 0.0], [1.0, 0.2, 0.0], [1.0, 1.0, 0.0], [0.2, 1.0, 0.0]];
    let asset = Asset::square(matte([1.0; 3])).with("COLOR_0", "VEC3", colors.as_flattened());
    Shot::furnace().take(&asset).assert_shows("colours of corners", |x, y| {
        if x.abs() < 0.5 && y.abs() < 0.5 { DVec3::new(0.6 + 0.8 * x, 0.6 + 0.8 * y, 0.0) } else { DVec3::ONE }
    });
}

#[test]
fn emission_by_factor_strength_and_texture() {
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 6 } });
    let emission = json!({
        "emissiveFactor": [1, 0.5, 0.25], "emissiveTexture": { "index": 0 }, "extensions": strength,
    });
    let asset = Asset::square(merged(glowing(), emission)).texture(&[&[[255, 128, 64, 255]]], json!({}));
    let expected = 6.0 * DVec3::new(1.0, 0.5 * linear(128), 0.25 * linear(64));
    assert_shows("emission", &Shot::default().take(&asset), |_, _| expected);
}

/// A mirror shows the sky where its normal, tilted by the map, sends the view: to the right by red, up by green.
#[test]
fn normal_maps_tilt_mirrors() {
    let mirror = json!({ "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 0 } });
    let shown = |texel: [u8; 4], scale: f64| {
        let map = json!({ "normalTexture": { "index": 0, "scale": scale } });
        let asset = Asset::square(merged(mirror.clone(), map)).texture(&[&[texel]], json!({}));
        let environment = "horizon = [0, 0, 0]\nzenith = [1, 1, 1]".into();
        Shot { environment, ..Shot::default() }.take(&asset).at(0.0625, 0.0625).x
    };
    let expected = |texel: [u8; 4], scale: f64| {
        let n = texel.map(|byte| 2.0 * f64::from(byte) / 255.0 - 1.0);
        let n = DVec3::new(scale * n[0], scale * n[1], n[2]).normalize();
        let wo = DVec3::new(-0.0625, -0.0625, 3.0).normalize();
        let wi = 2.0 * wo.dot(n) * n - wo;
        0.5 * wi.y + 0.5
    };
    for (texel, scale) in [([128, 168, 250, 255], 1.0), ([128, 88, 250, 255], 1.0), ([180, 168, 230, 255], 0.5)] {
        let (found, expected) = (shown(texel, scale), expected(texel, scale));
        assert!((found - expected).abs() < 1e-4, "{texel:?} x {scale}: {found}, not {expected}");
    }
}

/// Path tracing finds what is occluded: the texture changes nothing.
#[test]
fn occlusion_textures_change_nothing() {
    let occluded = merged(matte([0.5; 3]), json!({ "occlusionTexture": { "index": 0 } }));
    let asset = |material| Asset::square(material).texture(&[&[[0, 0, 0, 255]]], json!({}));
    let [with, without] = [occluded, matte([0.5; 3])].map(|material| Shot::furnace().take(&asset(material)));
    assert_eq!(with, without);
}
