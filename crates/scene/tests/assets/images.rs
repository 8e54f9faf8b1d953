//! Images: the sky's, and those of materials.

use std::sync::Arc;

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use raggio_scene::{Assets, Bitmap, Environment, Texels, Texture, TextureFilter, Wrap};

use crate::assets::files::Folder;

#[test]
fn an_environment() {
    let folder = Folder::new();
    let scene = folder.scene("[environment]\nimage = \"pixel.hdr\"\nrotation_degrees = -90\nintensity = 2\n");
    let Environment::Image { image, rotation_degrees, intensity } = &scene.environment else { panic!("an image") };
    assert_eq!((*rotation_degrees, *intensity), (270.0, 2.0));
    assert_eq!((image.width, image.height), (1, 1));
    assert!(image.texels == Texels::Rgb32F(vec![[1.0, 0.5, 0.25]]));
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn an_environment_by_default() {
    let scene = Folder::new().scene("[environment]\nimage = \"pixel.hdr\"\n");
    let Environment::Image { rotation_degrees, intensity, .. } = scene.environment else { panic!("an image") };
    assert_eq!((rotation_degrees, intensity), (0.0, 1.0));
}

#[test]
fn a_damaged_image_is_named() {
    let folder = Folder::new();
    folder.write("cut.hdr", "#?RADIANCE\n");
    let error = folder.error("[environment]\nimage = \"cut.hdr\"\n");
    assert!(error.starts_with("scene.toml:7:9: cut.hdr: is a Radiance HDR that is damaged"), "{error}");
    folder.write("text.png", "no picture");
    let error = folder.error("[materials.a.principled]\nnormal_map = \"text.png\"\n");
    assert!(error.starts_with("scene.toml:7:14: text.png: is not an image"), "{error}");
    assert_eq!(folder.error("[environment]\nimage = \".\"\n"), "scene.toml:7:9: .: is not a file");
}

#[test]
fn images_say_how_they_were_read() {
    let folder = Folder::new();
    let names = ["albedo", "view"].into_iter().flat_map(|layer| ["B", "G", "R"].map(|last| format!("{layer}.{last}")));
    let channel = |name: String| AnyChannel::new(name.as_str(), FlatSamples::F32(vec![0.5]));
    let channels = AnyChannels::sort(names.map(channel).collect());
    Image::from_channels((1, 1), channels).write().to_file(folder.path("layers.exr")).unwrap();
    let body = "[environment]\nimage = \"layers.exr\"\n\
        [materials.a.principled]\nbase_color_texture = \"layers.exr\"\nemissive_texture = \"layers.exr\"\n";
    let mut assets = Assets::default();
    let warning = "layers.exr: it has the layers `albedo`, `view`: `albedo` is taken";
    // Once, wherever it is used, and also where the image has been read before.
    for _ in 0..2 {
        let warnings = folder.read(body, &mut assets).unwrap().warnings;
        assert_eq!(warnings, [format!("{}:7:9: {warning}", folder.path("scene.toml").display())]);
    }
    let body = "[environment]\ncolor = [1, 1, 1]\n[materials.a.principled]\nnormal_map = \"layers.exr\"\n";
    let warnings = folder.scene(body).warnings;
    assert_eq!(warnings, [format!("{}:9:14: {warning}", folder.path("scene.toml").display())]);
}

/// The normal map of a material with these keys.
fn normal_map(keys: &str) -> Texture {
    let scene =
        Folder::new().scene(&format!("[materials.a.principled]\nnormal_map = {{ image = \"pixel.hdr\"{keys} }}\n"));
    scene.materials[0].principled.as_ref().unwrap().normal_texture.clone().unwrap()
}

#[test]
fn how_a_texture_lies() {
    assert_eq!(normal_map(""), Texture::new(normal_map("").image));
    let texture = normal_map(", uv_set = 1, wrap = [\"clamp_to_edge\", \"mirrored_repeat\"], filter = \"nearest\"");
    assert_eq!(texture.uv_set, 1);
    assert_eq!(texture.wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    assert_eq!(texture.filter, TextureFilter::Nearest);
    assert_eq!(normal_map(", wrap = \"clamp_to_edge\"").wrap, [Wrap::ClampToEdge; 2]);
}

/// Point to which the transform takes a point.
fn mapped(keys: &str, [u, v]: [f32; 2]) -> [f32; 2] {
    normal_map(keys).transform.map(|[a, b, c]| a * u + b * v + c)
}

#[test]
fn texture_coordinates_are_scaled_then_turned_then_moved() {
    assert_eq!(mapped(", offset = [0.5, 0.25]", [1.0, 1.0]), [1.5, 1.25]);
    assert_eq!(mapped(", scale = [2, -1]", [1.0, 1.0]), [2.0, -1.0]);
    // The expected part is the lower left quarter of the image, v being downwards: KHR_texture_transform's own example.
    let keys = ", offset = [0, 1], rotation_degrees = 90, scale = [0.5, 0.5]";
    for (uv, expected) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0])] {
        let found = mapped(keys, uv);
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-6), "{uv:?}: {found:?}");
    }
}

#[test]
fn a_factor_beside_its_texture_is_1_unless_it_is_given() {
    let scene = Folder::new().scene(
        "[materials.a.principled]\nmetallic_roughness_texture = \"pixel.hdr\"\nemissive_texture = \"pixel.hdr\"\n\
         sheen_color_texture = \"pixel.hdr\"\nclearcoat_texture = \"pixel.hdr\"\nclearcoat = 0.5\n",
    );
    let surface = scene.materials[0].principled.as_ref().unwrap();
    assert_eq!((surface.metallic, surface.roughness, surface.clearcoat), (1.0, 1.0, 0.5));
    assert_eq!((surface.emissive, surface.sheen_color), ([1.0; 3], [1.0; 3]));
    assert_eq!((surface.transmission, surface.sheen_roughness), (0.0, 0.0));
}

#[test]
fn every_texture_is_where_its_key_says() {
    let keys = [
        "base_color_texture",
        "metallic_roughness_texture",
        "normal_map",
        "emissive_texture",
        "specular_texture",
        "specular_color_texture",
        "transmission_texture",
        "diffuse_transmission_texture",
        "diffuse_transmission_color_texture",
        "clearcoat_texture",
        "clearcoat_roughness_texture",
        "clearcoat_normal_map",
        "sheen_color_texture",
        "sheen_roughness_texture",
        "anisotropy_texture",
        "iridescence_texture",
        "iridescence_thickness_texture",
    ];
    for (place, key) in keys.iter().enumerate() {
        let scene = Folder::new().scene(&format!("[materials.a.principled]\n{key} = \"pixel.hdr\"\n"));
        let it = scene.materials[0].principled.as_ref().unwrap();
        let found = [
            &it.base_color_texture,
            &it.metallic_roughness_texture,
            &it.normal_texture,
            &it.emissive_texture,
            &it.specular_texture,
            &it.specular_color_texture,
            &it.transmission_texture,
            &it.diffuse_transmission_texture,
            &it.diffuse_transmission_color_texture,
            &it.clearcoat_texture,
            &it.clearcoat_roughness_texture,
            &it.clearcoat_normal_texture,
            &it.sheen_color_texture,
            &it.sheen_roughness_texture,
            &it.anisotropy_texture,
            &it.iridescence_texture,
            &it.iridescence_thickness_texture,
        ];
        let given: Vec<usize> = (0..found.len()).filter(|i| found[*i].is_some()).collect();
        assert_eq!(given, [place], "{key}");
    }
}

#[test]
fn an_image_is_read_once_for_all_its_uses() {
    let scene = Folder::new().scene(
        "[environment]\nimage = \"pixel.hdr\"\n[materials.a.principled]\nbase_color_texture = \"./pixel.hdr\"\n",
    );
    let Environment::Image { image, .. } = &scene.environment else { panic!("an image") };
    let texture = scene.materials[0].principled.as_ref().unwrap().base_color_texture.as_ref().unwrap();
    assert!(Arc::ptr_eq(image, &texture.image));
}

#[test]
fn an_image_in_memory() {
    let folder = Folder::new();
    let body = "[environment]\nimage = \"pixel.hdr\"\n[materials.a.principled]\nnormal_map = \"memory:1\"\n";
    let bitmap = |value: u8| Arc::new(Bitmap { width: 1, height: 1, texels: Texels::Rgba8(vec![[value; 4]]) });
    let mut assets = Assets::default();
    let told = folder.read(body, &mut assets).unwrap_err().to_string();
    assert!(told.ends_with("scene.toml:9:14: memory:1: there is no such file"), "{told}");
    assets.give_image(folder.path("memory:1"), bitmap(1));
    // What is given stands before a file of that name.
    assets.give_image(folder.path("pixel.hdr"), bitmap(2));
    let mut lent = Assets::default();
    assets.lend(&mut lent);
    for assets in [&mut assets, &mut lent] {
        let scene = folder.read(body, assets).unwrap();
        let Environment::Image { image, .. } = &scene.environment else { panic!("an image") };
        assert_eq!(**image, *bitmap(2));
        let normals = scene.materials[0].principled.as_ref().unwrap().normal_texture.as_ref().unwrap();
        assert_eq!(*normals.image, *bitmap(1));
    }
    assets.take_back(&folder.path("pixel.hdr"));
    let scene = folder.read(body, &mut assets).unwrap();
    let Environment::Image { image, .. } = &scene.environment else { panic!("an image") };
    assert!(image.texels == Texels::Rgb32F(vec![[1.0, 0.5, 0.25]]));
}
