//! Principled materials and textures made from MTL.

use std::path::Path;

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use raggio_images::Texels;
use raggio_models::{AlphaMode, LoadOptions, Model, Principled, Texture, Wrap, load};

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

/// Writes an image.
fn png(path: &Path, (width, height): (u32, u32), texels: &[[u8; 4]]) {
    let image = image::RgbaImage::from_raw(width, height, texels.as_flattened().to_vec()).unwrap();
    image.save(path).unwrap();
}

fn folder_with(mtl: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), OBJ).unwrap();
    std::fs::write(folder.path().join("a.mtl"), format!("newmtl m\n{mtl}\n")).unwrap();
    folder
}

fn model(folder: &Path) -> Model {
    load(&folder.join("a.obj"), &LoadOptions::default()).unwrap()
}

fn surface(mtl: &str) -> Principled {
    let mut model = model(folder_with(mtl).path());
    assert_eq!(model.warnings, [""; 0]);
    model.materials.remove(0).surface
}

/// Texel of a texture at a place of OBJ's coordinates, the nearest one.
fn at(texture: &Texture, u: f32, v: f32) -> [u8; 4] {
    let image = &texture.image;
    let [x, y] = texture.transform.map(|[a, b, c]| a * u + b * v + c);
    let texel = |value: f32, count: u32| (value.rem_euclid(1.0) * count as f32) as u32;
    let index = texel(y, image.height) * image.width + texel(x, image.width);
    match &image.texels {
        Texels::Rgba8(texels) => texels[index as usize],
        _ => panic!("expected 8 bits"),
    }
}

#[test]
fn diffuse_materials() {
    let diffuse = surface("Kd 0.2 0.4 2");
    let expected =
        Principled { base_color: [0.2, 0.4, 1.0], specular: 0.0, specular_color: [0.0; 3], ..Principled::default() };
    assert_eq!(diffuse, expected);
    assert_eq!(surface("illum 1\nKs 1 1 1\nNs 50").specular, 0.0);
    assert_eq!(surface("").base_color, [0.8; 3]);
    let emissive = surface("Ke 3 2 0\nd 0.5");
    assert_eq!((emissive.emissive, emissive.alpha, emissive.alpha_mode), ([3.0, 2.0, 0.0], 0.5, AlphaMode::Blend));
    assert_eq!(emissive.transmission, 0.0);
}

#[test]
fn highlights() {
    let shiny = surface("Kd 1 1 1\nKs 0.5 0.25 0\nNs 30\nillum 2");
    // An exponent of 30 is a width of 1/4, which is a roughness of 1/2.
    assert_eq!((shiny.roughness, shiny.specular, shiny.specular_color), (0.5, 1.0, [1.0, 0.5, 0.0]));
    let physical = surface("Pr 0.3\nPm 0.75\nNs 900\nPc 0.5\nPcr 0.25\naniso 0.125\nanisor 0.25");
    assert_eq!((physical.roughness, physical.metallic, physical.specular), (0.3, 0.75, 1.0));
    assert_eq!((physical.clearcoat, physical.clearcoat_roughness, physical.anisotropy), (0.5, 0.25, 0.125));
    assert!((physical.anisotropy_rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert_eq!(physical.specular_color, [1.0; 3]);
    assert_eq!((surface("Ni 1").ior, surface("Ni 1.33").ior), (1.5, 1.33));
}

#[test]
fn glass() {
    let glass = surface("Kd 0 0 0\nKs 1 1 1\nNi 1.6\nTf 1 0.5 1\nillum 7");
    assert_eq!((glass.transmission, glass.ior, glass.roughness, glass.base_color), (1.0, 1.6, 0.0, [1.0, 0.5, 1.0]));
    assert_eq!((glass.specular, glass.specular_color, glass.alpha_mode), (1.0, [1.0; 3], AlphaMode::Opaque));
    let half = surface("Kd 0.2 0.2 0.2\nNi 1.5\nTf 1 1 1\nd 0.25");
    assert_eq!((half.transmission, half.alpha, half.base_color), (0.75, 1.0, [0.2; 3]));
    // Exporters write opaque materials so.
    for opaque in ["illum 4\nTf 1 1 1\nNi 1", "illum 2\nTf 1 1 1\nNi 1.5\nd 1", "illum 7\nTf 0 0 0\nNi 1.5"] {
        assert_eq!(surface(opaque).transmission, 0.0, "{opaque}");
    }
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const WHITE: [u8; 4] = [255; 4];

#[test]
fn textures_lie_from_the_bottom_left() {
    let folder = folder_with(
        "Kd 0 0 0\nmap_Kd t.png\nKe 2 2 2\nmap_Ke -s 2 1 -o 0.5 0.5 -clamp on t.png\nnorm -bm 0.5 t.png\nKs 1 1 1\nmap_Ks t.png",
    );
    png(&folder.path().join("t.png"), (2, 2), &[RED, GREEN, BLUE, WHITE]);
    let model = model(folder.path());
    assert_eq!(model.warnings, [""; 0]);
    let surface = &model.materials[0].surface;
    let color = surface.base_color_texture.as_ref().unwrap();
    assert_eq!(surface.base_color, [1.0; 3]);
    assert_eq!(
        [at(color, 0.1, 0.9), at(color, 0.9, 0.9), at(color, 0.1, 0.1), at(color, 0.9, 0.1)],
        [RED, GREEN, BLUE, WHITE]
    );
    let emissive = surface.emissive_texture.as_ref().unwrap();
    assert_eq!((surface.emissive, emissive.wrap), ([2.0; 3], [Wrap::ClampToEdge; 2]));
    // The coordinates become (0.6, 0.6), on the right and above: twice 0.05 and a half, and 0.1 and a half.
    assert_eq!(at(emissive, 0.05, 0.1), GREEN);
    assert!(std::sync::Arc::ptr_eq(&color.image, &emissive.image));
    assert_eq!((surface.normal_scale, surface.normal_texture.is_some()), (0.5, true));
    assert_eq!((surface.specular_color, surface.specular_color_texture.is_some()), ([2.0; 3], true));
}

#[test]
fn coverage_joins_the_colour() {
    let folder = folder_with("map_Kd t.png\nmap_d d.png");
    png(&folder.path().join("t.png"), (2, 1), &[RED, GREEN]);
    png(&folder.path().join("d.png"), (1, 2), &[[7, 0, 0, 255], [200, 0, 0, 255]]);
    let surface = &model(folder.path()).materials[0].surface;
    let texture = surface.base_color_texture.as_ref().unwrap();
    assert_eq!((texture.image.width, texture.image.height, surface.alpha_mode), (2, 2, AlphaMode::Blend));
    assert_eq!((at(texture, 0.1, 0.9), at(texture, 0.9, 0.1)), ([255, 0, 0, 7], [0, 255, 0, 200]));
    // The coverage is the texture's alpha where it has one; without a colour there is white.
    let folder = folder_with("Kd 1 1 1\nmap_d d.png");
    png(&folder.path().join("d.png"), (1, 1), &[[9, 9, 9, 50]]);
    let surface = &model(folder.path()).materials[0].surface;
    assert_eq!(at(surface.base_color_texture.as_ref().unwrap(), 0.0, 0.0), [255, 255, 255, 50]);
}

#[test]
fn roughness_and_metalness_share_an_image() {
    let folder = folder_with("Pr 0.5\nmap_Pr r.png\nmap_Pm m.png");
    png(&folder.path().join("r.png"), (1, 1), &[[10, 1, 1, 255]]);
    png(&folder.path().join("m.png"), (1, 1), &[[20, 1, 1, 255]]);
    let surface = &model(folder.path()).materials[0].surface;
    assert_eq!((surface.roughness, surface.metallic), (0.5, 1.0));
    assert_eq!(at(surface.metallic_roughness_texture.as_ref().unwrap(), 0.0, 0.0), [255, 10, 20, 255]);
    let folder = folder_with("map_Pr r.png\nmap_Pm -s 2 m.png");
    png(&folder.path().join("r.png"), (1, 1), &[[10, 1, 1, 255]]);
    png(&folder.path().join("m.png"), (1, 1), &[[20, 1, 1, 255]]);
    let model = model(folder.path());
    let texture = model.materials[0].surface.metallic_roughness_texture.as_ref().unwrap();
    assert_eq!((at(texture, 0.0, 0.0), model.warnings.len()), ([255, 10, 255, 255], 1));
}

#[test]
fn what_is_not_used_is_a_warning() {
    let folder =
        folder_with("Kd 0.5 0.5 0.5\nmap_Kd none.png\nmap_Ke ../out.png\nmap_bump b.png\ndisp d.png\nKa 1 1 1");
    let surface_and_warnings = |options: &LoadOptions| {
        let model = load(&folder.path().join("a.obj"), options).unwrap();
        (model.materials[0].surface.clone(), model.warnings)
    };
    let (surface, warnings) = surface_and_warnings(&LoadOptions::default());
    assert_eq!((surface.base_color, surface.base_color_texture, surface.emissive_texture), ([0.5; 3], None, None));
    let starts = [
        "the texture `none.png` is not used: it does not exist",
        "the texture `b.png` is not used: it does not exist",
        "the texture `../out.png` is not used: it is outside the folder of the model, where files are not read unless \
         `--allow-outside` is given",
        "the lines `disp` of materials are not used",
    ];
    assert!(warnings.iter().zip(starts).all(|(warning, start)| warning.starts_with(start)), "{warnings:?}");
    assert_eq!(warnings.len(), 4);
    let (_, warnings) = surface_and_warnings(&LoadOptions { allow_outside: true, ..LoadOptions::default() });
    assert_eq!(warnings[1], "the texture `../out.png` is not used: it does not exist");
}

#[test]
fn textures_say_how_they_were_read() {
    let folder = folder_with("map_Kd layers.exr\nmap_Ke layers.exr");
    let names = ["albedo", "view"].into_iter().flat_map(|layer| ["B", "G", "R"].map(|last| format!("{layer}.{last}")));
    let channel = |name: String| AnyChannel::new(name.as_str(), FlatSamples::F32(vec![0.5]));
    let channels = AnyChannels::sort(names.map(channel).collect());
    Image::from_channels((1, 1), channels).write().to_file(folder.path().join("layers.exr")).unwrap();
    let model = load(&folder.path().join("a.obj"), &LoadOptions::default()).unwrap();
    let warning = "the texture `layers.exr`: it has the layers `albedo`, `view`: `albedo` is taken";
    assert_eq!(model.warnings, [warning]);
}

/// Two small files that would make a large texture together are left out.
#[test]
fn textures_that_get_large_together_are_left_out() {
    let folder = folder_with("map_Kd wide.png\nmap_d high.png");
    png(&folder.path().join("wide.png"), (4000, 1), &[RED; 4000]);
    png(&folder.path().join("high.png"), (1, 4000), &[RED; 4000]);
    let options = LoadOptions { most_bytes: 1 << 20, ..LoadOptions::default() };
    let model = load(&folder.path().join("a.obj"), &options).unwrap();
    assert_eq!(model.warnings, ["textures are left out: put together they take more memory than is allowed"]);
    assert_eq!(model.materials[0].surface.base_color_texture.as_ref().unwrap().image.height, 1);
}

/// The texture that a PLY's comment names is read as MTL's are.
#[test]
fn the_texture_of_a_ply() {
    let folder = tempfile::tempdir().unwrap();
    png(&folder.path().join("t.png"), (1, 2), &[RED, BLUE]);
    let path = folder.path().join("a.ply");
    let text = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    std::fs::write(&path, text).unwrap();
    let model = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!((model.warnings.len(), model.meshes[0].parts[0].material), (0, Some(0)));
    assert_eq!(at(model.materials[0].surface.base_color_texture.as_ref().unwrap(), 0.0, 0.1), BLUE);
}
