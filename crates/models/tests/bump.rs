//! Bump maps become normal maps.

use std::path::Path;

use raggio_images::Texels;
use raggio_models::{LoadOptions, Model, load};

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

/// The model of a library's one material, beside images of grey texels.
fn model(folder: &Path, mtl: &str) -> Model {
    std::fs::write(folder.join("a.obj"), OBJ).unwrap();
    std::fs::write(folder.join("a.mtl"), format!("newmtl m\n{mtl}\n")).unwrap();
    load(&folder.join("a.obj"), &LoadOptions::default()).unwrap()
}

fn png(path: &Path, (width, height): (u32, u32), texels: &[[u8; 3]]) {
    image::RgbImage::from_raw(width, height, texels.as_flattened().to_vec()).unwrap().save(path).unwrap();
}

/// Normal of a texel of the normal map.
fn normal(model: &Model, index: usize) -> [f32; 3] {
    let texture = model.materials[0].surface.normal_texture.as_ref().expect("a normal map");
    match &texture.image.texels {
        Texels::Rgba16(texels) => [0, 1, 2].map(|i| f32::from(texels[index][i]) / 65535.0 * 2.0 - 1.0),
        Texels::Rgba8(texels) => [0, 1, 2].map(|i| f32::from(texels[index][i]) / 255.0 * 2.0 - 1.0),
        Texels::Rgb32F(_) => panic!("expected integers"),
    }
}

#[track_caller]
fn close(found: [f32; 3], slope: [f32; 2]) {
    let length = (slope[0] * slope[0] + slope[1] * slope[1] + 1.0).sqrt();
    let expected = [-slope[0] / length, -slope[1] / length, 1.0 / length];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?} should be {expected:?}");
}

#[test]
fn heights_become_normals_of_their_slopes() {
    let folder = tempfile::tempdir().unwrap();
    // Heights of 0, 0.2 and 1 from the left to the right.
    let grey = |value: u8| [value; 3];
    png(&folder.path().join("h.png"), (3, 1), &[grey(0), grey(51), grey(255)]);
    // Heights of 1, 0.2 and 0 from the top to the bottom.
    png(&folder.path().join("v.png"), (1, 3), &[grey(255), grey(51), grey(0)]);
    for keyword in ["bump", "map_bump", "map_Bump", "map_BUMP"] {
        let across = model(folder.path(), &format!("{keyword} -bm 3 h.png"));
        assert_eq!((across.warnings.len(), across.materials[0].surface.normal_scale), (0, 3.0));
        // The edges meet: left of the first texel is the last one.
        close(normal(&across, 0), [(0.2 - 1.0) / 2.0, 0.0]);
        close(normal(&across, 1), [(1.0 - 0.0) / 2.0, 0.0]);
        close(normal(&across, 2), [(0.0 - 0.2) / 2.0, 0.0]);
    }
    let clamped = model(folder.path(), "bump -clamp on h.png");
    assert_eq!(clamped.materials[0].surface.normal_scale, 1.0);
    close(normal(&clamped, 0), [(0.2 - 0.0) / 2.0, 0.0]);
    close(normal(&clamped, 2), [(1.0 - 0.2) / 2.0, 0.0]);
    // Heights that grow to the top slope along v.
    let down = model(folder.path(), "bump v.png");
    close(normal(&down, 1), [0.0, (1.0 - 0.0) / 2.0]);
}

#[test]
fn normals_among_bump_maps_stay_normals() {
    let folder = tempfile::tempdir().unwrap();
    png(&folder.path().join("n.png"), (2, 1), &[[128, 128, 255], [218, 128, 218]]);
    png(&folder.path().join("h.png"), (2, 1), &[[201, 201, 201], [202, 202, 202]]);
    let normals = model(folder.path(), "map_Bump -bm 0.5 n.png");
    assert_eq!(normals.warnings, ["the bump map `n.png` is read as a normal map: it holds normals, not heights"]);
    assert_eq!(normals.materials[0].surface.normal_scale, 0.5);
    assert!((normal(&normals, 1)[0] - 0.7098).abs() < 1e-4, "{:?}", normal(&normals, 1));
    // Greys of this lightness could be normals by their length.
    let heights = model(folder.path(), "map_Bump -clamp on h.png");
    assert_eq!(heights.warnings, [""; 0]);
    close(normal(&heights, 0), [0.5 / 255.0, 0.0]);
    let both = model(folder.path(), "bump h.png\nnorm n.png");
    assert_eq!(both.warnings, ["bump maps are not used beside a normal map, `norm`"]);
    assert!((normal(&both, 1)[0] - 0.7098).abs() < 1e-4);
}

/// Normals take memory of their own, which counts.
#[test]
fn bump_maps_count_among_the_textures() {
    let folder = tempfile::tempdir().unwrap();
    png(&folder.path().join("h.png"), (100, 100), &[[0; 3]; 10_000]);
    model(folder.path(), "bump h.png");
    let most =
        |most_bytes| load(&folder.path().join("a.obj"), &LoadOptions { most_bytes, ..LoadOptions::default() }).unwrap();
    let enough = most(40_000 + 80_000);
    assert_eq!((enough.warnings.len(), enough.materials[0].surface.normal_texture.is_some()), (0, true));
    let short = most(40_000 + 79_999);
    assert_eq!(short.warnings, ["a bump map is not used: its normals take more memory than is allowed"]);
    assert_eq!(short.materials[0].surface.normal_texture, None);
}
