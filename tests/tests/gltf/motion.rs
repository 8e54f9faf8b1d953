//! Motion: animations, morph targets, skins.

use serde_json::{Value, json};

use crate::gltf::asset::{Asset, CORNERS, U8, glowing};
use crate::gltf::picture::{Shot, within};

/// Gives a property of the node of `asset` keys at 1 and 3 seconds.
fn animate(mut asset: Asset, path: &str, interpolation: &str, kind: &str, values: &[f32]) -> Asset {
    let input = asset.floats("SCALAR", &[1.0, 3.0]);
    let output = asset.floats(kind, values);
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    asset.push("animations", json!({ "channels": [channel], "samplers": [sampler] }));
    asset
}

/// The square moves from -0.75 to 0.75; the spline starts with 1.5 a second, and ends at rest.
#[test]
fn interpolations_at_a_time() {
    let ends = [-0.75, 0.0, 0.0, 0.75, 0.0, 0.0];
    let spline = [[0.0; 3], [-0.75, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0; 3], [0.75, 0.0, 0.0], [0.0; 3]].concat();
    let cases = [
        ("LINEAR", &ends[..], 2.0, 0.0),
        ("LINEAR", &ends, 1.5, -0.375),
        ("LINEAR", &ends, 0.0, -0.75),
        ("LINEAR", &ends, 9.0, 0.75),
        ("STEP", &ends, 2.75, -0.75),
        ("STEP", &ends, 3.0, 0.75),
        // h00 = h01 = 1/2, h10 = 1/8: half of the sum of the ends, and 1/8 of the tangent times two seconds.
        ("CUBICSPLINE", &spline, 2.0, 0.375),
    ];
    for (interpolation, values, time, x) in cases {
        let asset = animate(Asset::square(glowing()), "translation", interpolation, "VEC3", values);
        let what = format!("{interpolation} at {time} seconds");
        Shot::at(time).take(&asset).assert_lit(&what, within([x, 0.0], [1.0, 1.0]));
    }
}

#[test]
fn turning_and_growing() {
    let half = 0.5f32.sqrt();
    let mut asset = Asset::square(glowing());
    asset.json["nodes"][0]["scale"] = json!([2, 0.5, 1]);
    let turned = animate(asset, "rotation", "LINEAR", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    Shot::at(1.0).take(&turned).assert_lit("before the turn", within([0.0, 0.0], [2.0, 0.5]));
    Shot::at(3.0).take(&turned).assert_lit("after the turn", within([0.0, 0.0], [0.5, 2.0]));
    // The square has made an eighth of a turn: it lies along the diagonals.
    Shot::at(2.0).take(&turned).assert_lit("half way", |x, y| {
        let (along, across) = ((x + y) / 2f64.sqrt(), (y - x) / 2f64.sqrt());
        along.abs() < 1.0 && across.abs() < 0.25
    });
    let growing = animate(Asset::square(glowing()), "scale", "LINEAR", "VEC3", &[1.0, 1.0, 1.0, 2.0, 0.5, 1.0]);
    Shot::at(2.0).take(&growing).assert_lit("half grown", within([0.0, 0.0], [1.5, 0.75]));
}

/// Asset of the square, with a target that moves it by (1, 0) and another that moves its upper side by 1.
fn morphed() -> Asset {
    let mut asset = Asset::square(glowing());
    let aside = asset.floats("VEC3", &[1.0, 0.0, 0.0].repeat(4));
    let up = CORNERS.map(|[_, y, _]| [0.0, if y > 0.0 { 1.0 } else { 0.0 }, 0.0]);
    let up = asset.floats("VEC3", up.as_flattened());
    asset.primitive()["targets"] = json!([{ "POSITION": aside }, { "POSITION": up }]);
    asset
}

#[test]
fn morph_targets() {
    let mut asset = morphed();
    let shown = |asset: &Asset| Shot::default().take(asset);
    shown(&asset).assert_lit("no weights", within([0.0, 0.0], [1.0, 1.0]));
    asset.json["meshes"][0]["weights"] = json!([0.75, 0.5]);
    shown(&asset).assert_lit("the mesh's weights", within([0.75, 0.25], [1.0, 1.5]));
    asset.json["nodes"][0]["weights"] = json!([-0.5, 0]);
    shown(&asset).assert_lit("the node's weights", within([-0.5, 0.0], [1.0, 1.0]));
}

#[test]
fn animated_weights() {
    let asset = animate(morphed(), "weights", "LINEAR", "SCALAR", &[0.0, 0.0, 1.0, 0.5]);
    Shot::at(2.0).take(&asset).assert_lit("animated weights", within([0.5, 0.125], [1.0, 1.25]));
}

/// One of two joints moves; the left side of the square goes with one, the right with the other, in part.
#[test]
fn skins() {
    let weighted = |right: f32, node: Value| {
        let weights =
            CORNERS.map(|[x, ..]| if x > 0.0 { [1.0 - right, right, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] });
        let mut asset = Asset::square(glowing()).with("WEIGHTS_0", "VEC4", weights.as_flattened());
        let view = asset.view(&[0, 1, 0, 0].repeat(4));
        let joints = json!({ "bufferView": view, "componentType": U8, "count": 4, "type": "VEC4" });
        let joints = asset.push("accessors", joints);
        asset.primitive()["attributes"]["JOINTS_0"] = json!(joints);
        // The second joint stands at (0.5, 0) when nothing is moved.
        let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let mut second = identity;
        second[12] = -0.5;
        let inverse = asset.floats("MAT4", &[identity, second].concat());
        asset.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": inverse }]);
        asset.nodes(json!([{ "mesh": 0, "skin": 0, "translation": [9, 9, 9] }, { "children": [2] }, node]))
    };
    let shown = |right, node| Shot::default().take(&weighted(right, node));
    let rest = json!({ "translation": [0.5, 0, 0] });
    shown(1.0, rest).assert_lit("at rest, wherever the node is", within([0.0, 0.0], [1.0, 1.0]));
    let moved = json!({ "translation": [1.25, 0, 0] });
    shown(1.0, moved.clone()).assert_lit("the right side moved", within([0.375, 0.0], [1.75, 1.0]));
    shown(0.5, moved).assert_lit("half of the right side's weight", within([0.1875, 0.0], [1.375, 1.0]));
    let grown = json!({ "translation": [0.5, 0, 0], "scale": [1, 2, 1] });
    shown(1.0, grown)
        .assert_lit("the right side twice as high", |x, y| x.abs() < 0.5 && y.abs() < 0.5 + 0.5 * (x + 0.5));
}
