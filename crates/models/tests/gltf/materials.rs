//! Each property of each material extension arrives under its name.

use raggio_models::{AlphaMode, Principled, TextureFilter, Wrap};
use serde_json::{Value, json};

use crate::gltf::builder::{Builder, png, texels};

/// The first material, with textures 0, 1, ... whose only texel is [1; 4], [2; 4], ...
fn builder(material: Value) -> Builder {
    let mut builder = Builder::with_material(material);
    for i in 0..8u8 {
        let view = builder.view(&png(&[[i + 1; 4]]));
        let source = builder.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        builder.push("textures", json!({ "source": source }));
    }
    builder
}

fn surface(material: Value) -> Principled {
    let model = builder(material).load();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    model.materials[0].surface.clone()
}

fn extended(extension: &str, properties: Value) -> Principled {
    surface(json!({ "extensions": { extension: properties } }))
}

/// Number of a texture.
fn number(texture: &Option<raggio_models::Texture>) -> u8 {
    texels(texture).expect("a texture")[0][0] - 1
}

#[test]
fn defaults() {
    assert_eq!(surface(json!({})), Principled { metallic: 1.0, ..Principled::default() });
}

#[test]
fn core() {
    let found = surface(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": { "index": 0 },
            "metallicFactor": 0.5,
            "roughnessFactor": 0.6,
            "metallicRoughnessTexture": { "index": 1, "texCoord": 1 },
        },
        "normalTexture": { "index": 2, "scale": 0.7 },
        "occlusionTexture": { "index": 3, "strength": 0.5 },
        "emissiveTexture": { "index": 4 },
        "emissiveFactor": [0.25, 0.5, 1],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } },
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "doubleSided": true,
    }));
    assert_eq!((found.base_color, found.alpha), ([0.1, 0.2, 0.3], 0.4));
    assert_eq!((found.metallic, found.roughness, found.normal_scale), (0.5, 0.6, 0.7));
    assert_eq!((found.emissive, found.alpha_mode), ([2.0, 4.0, 8.0], AlphaMode::Mask(0.3)));
    assert_eq!((number(&found.base_color_texture), number(&found.metallic_roughness_texture)), (0, 1));
    assert_eq!((number(&found.normal_texture), number(&found.emissive_texture)), (2, 4));
    assert_eq!(found.metallic_roughness_texture.unwrap().uv_set, 1);
    assert_eq!(surface(json!({ "alphaMode": "BLEND" })).alpha_mode, AlphaMode::Blend);
    assert_eq!(surface(json!({ "alphaMode": "MASK" })).alpha_mode, AlphaMode::Mask(0.5));
}

#[test]
fn dielectrics() {
    assert_eq!(extended("KHR_materials_ior", json!({ "ior": 1.25 })).ior, 1.25);
    assert_eq!(extended("KHR_materials_ior", json!({ "ior": 0 })).ior, 0.0);
    assert_eq!(extended("KHR_materials_dispersion", json!({ "dispersion": 0.5 })).dispersion, 0.5);
    let found = extended(
        "KHR_materials_specular",
        json!({
            "specularFactor": 0.5,
            "specularTexture": { "index": 1 },
            "specularColorFactor": [1, 2, 3],
            "specularColorTexture": { "index": 2 },
        }),
    );
    assert_eq!((found.specular, found.specular_color), (0.5, [1.0, 2.0, 3.0]));
    assert_eq!((number(&found.specular_texture), number(&found.specular_color_texture)), (1, 2));
}

#[test]
fn transmission_is_thin_without_a_volume() {
    let transmission = json!({ "transmissionFactor": 0.5, "transmissionTexture": { "index": 3 } });
    let found = extended("KHR_materials_transmission", transmission.clone());
    assert_eq!((found.transmission, number(&found.transmission_texture), found.thin_walled), (0.5, 3, true));
    let volume = json!({ "thicknessFactor": 2, "attenuationDistance": 0.5, "attenuationColor": [0.1, 0.2, 0.3] });
    let both = |volume: Value| json!({ "extensions": { "KHR_materials_transmission": transmission, "KHR_materials_volume": volume } });
    let found = surface(both(volume.clone()));
    assert_eq!((found.thin_walled, found.attenuation_distance), (false, 0.5));
    assert_eq!(found.attenuation_color, [0.1, 0.2, 0.3]);
    let mut thin = volume.clone();
    thin["thicknessFactor"] = json!(0);
    assert!(surface(both(thin)).thin_walled);
    let mut textured = volume;
    textured["thicknessTexture"] = json!({ "index": 0 });
    let warning = builder(both(textured)).warning();
    assert!(warning.contains("materials[0].thicknessTexture is not used"), "{warning}");
    assert!(!surface(json!({})).thin_walled);
}

#[test]
fn diffuse_transmission() {
    let found = extended(
        "KHR_materials_diffuse_transmission",
        json!({
            "diffuseTransmissionFactor": 0.25,
            "diffuseTransmissionTexture": { "index": 1 },
            "diffuseTransmissionColorFactor": [0.1, 0.2, 0.3],
            "diffuseTransmissionColorTexture": { "index": 2 },
        }),
    );
    assert_eq!((found.diffuse_transmission, found.diffuse_transmission_color), (0.25, [0.1, 0.2, 0.3]));
    assert_eq!(number(&found.diffuse_transmission_texture), 1);
    assert_eq!(number(&found.diffuse_transmission_color_texture), 2);
    assert!(found.thin_walled);
}

#[test]
fn clearcoat_and_sheen() {
    let found = extended(
        "KHR_materials_clearcoat",
        json!({
            "clearcoatFactor": 0.5,
            "clearcoatTexture": { "index": 1 },
            "clearcoatRoughnessFactor": 0.25,
            "clearcoatRoughnessTexture": { "index": 2 },
            "clearcoatNormalTexture": { "index": 3, "scale": 0.75 },
        }),
    );
    assert_eq!((found.clearcoat, found.clearcoat_roughness, found.clearcoat_normal_scale), (0.5, 0.25, 0.75));
    assert_eq!((number(&found.clearcoat_texture), number(&found.clearcoat_roughness_texture)), (1, 2));
    assert_eq!(number(&found.clearcoat_normal_texture), 3);
    let found = extended(
        "KHR_materials_sheen",
        json!({
            "sheenColorFactor": [0.1, 0.2, 0.3],
            "sheenColorTexture": { "index": 4 },
            "sheenRoughnessFactor": 0.5,
            "sheenRoughnessTexture": { "index": 5 },
        }),
    );
    assert_eq!((found.sheen_color, found.sheen_roughness), ([0.1, 0.2, 0.3], 0.5));
    assert_eq!((number(&found.sheen_color_texture), number(&found.sheen_roughness_texture)), (4, 5));
}

#[test]
fn anisotropy_and_iridescence() {
    let found = extended(
        "KHR_materials_anisotropy",
        json!({ "anisotropyStrength": 0.5, "anisotropyRotation": 1.5, "anisotropyTexture": { "index": 6 } }),
    );
    assert_eq!((found.anisotropy, found.anisotropy_rotation, number(&found.anisotropy_texture)), (0.5, 1.5, 6));
    let found = extended(
        "KHR_materials_iridescence",
        json!({
            "iridescenceFactor": 0.5,
            "iridescenceTexture": { "index": 1 },
            "iridescenceIor": 1.75,
            "iridescenceThicknessMinimum": 200,
            "iridescenceThicknessMaximum": 300,
            "iridescenceThicknessTexture": { "index": 2 },
        }),
    );
    assert_eq!((found.iridescence, found.iridescence_ior), (0.5, 1.75));
    assert_eq!((found.iridescence_thickness_minimum, found.iridescence_thickness_maximum), (200.0, 300.0));
    assert_eq!((number(&found.iridescence_texture), number(&found.iridescence_thickness_texture)), (1, 2));
}

#[test]
fn unlit_emits_its_base_color_and_reflects_nothing() {
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 0.5], "baseColorTexture": { "index": 1 } },
        "alphaMode": "BLEND",
        "emissiveFactor": [1, 1, 1],
        "extensions": { "KHR_materials_unlit": {} },
    });
    let found = surface(material.clone());
    assert_eq!((found.base_color, found.metallic, found.specular), ([0.0; 3], 0.0, 0.0));
    assert_eq!((found.emissive, found.alpha, found.alpha_mode), ([0.1, 0.2, 0.3], 0.5, AlphaMode::Blend));
    assert_eq!((number(&found.emissive_texture), number(&found.base_color_texture)), (1, 1));
    assert!(found.emissive_by_vertex_color && !surface(json!({})).emissive_by_vertex_color);
    let mut colored = builder(material);
    let colors = colored.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    colored.attribute("COLOR_0", colors);
    let model = colored.load();
    assert_eq!(model.meshes[0].colors.as_deref(), Some(&[[1.0, 0.0, 0.0, 1.0]; 3][..]));
    assert!(model.materials[0].surface.emissive_by_vertex_color);
}

#[test]
fn distances_of_attenuation_that_stand_for_infinity() {
    let material = |distance: Value| {
        let volume =
            json!({ "thicknessFactor": 1, "attenuationDistance": distance, "attenuationColor": [0.1, 0.2, 0.3] });
        builder(json!({ "extensions": { "KHR_materials_volume": volume } }))
    };
    let told = [
        (json!(0), "materials[0].attenuationDistance is 0: nothing is absorbed"),
        (json!(-1), "materials[0].attenuationDistance is -1: nothing is absorbed"),
        (json!(null), "materials[0].extensions.KHR_materials_volume.attenuationDistance is null: its default is used"),
    ];
    for (distance, warning) in told {
        let builder = material(distance);
        assert_eq!(builder.load().materials[0].surface.attenuation_distance, f32::INFINITY);
        assert_eq!(builder.warning(), warning);
    }
}

/// Infinity and what is no number are null in the JSON of many programs, and so are names that are not there.
#[test]
fn nulls_are_defaults() {
    let mut builder = builder(json!({
        "name": null,
        "pbrMetallicRoughness": { "roughnessFactor": null, "baseColorFactor": [null, 1, 1, 1], "metallicFactor": 0.5 },
        "extras": { "none": null },
    }));
    builder.json["nodes"][0]["name"] = json!(null);
    builder.json["nodes"][0]["translation"] = json!([1, null, 3]);
    let model = builder.load();
    let surface = &model.materials[0].surface;
    assert_eq!((surface.roughness, surface.base_color, surface.metallic), (1.0, [1.0; 3], 0.5));
    assert_eq!((model.materials[0].name.as_str(), &*model.instances[0].name), ("", ""));
    assert_eq!(model.instances[0].model_from_mesh, glam::DAffine3::IDENTITY);
    let mut told = model.warnings;
    told.sort_unstable();
    let expected = [
        "materials[0].name",
        "materials[0].pbrMetallicRoughness.baseColorFactor",
        "materials[0].pbrMetallicRoughness.roughnessFactor",
        "nodes[0].name",
        "nodes[0].translation",
    ];
    assert_eq!(told, expected.map(|path| format!("{path} is null: its default is used")));
}

#[test]
fn specular_glossiness_is_translated() {
    let extension = "KHR_materials_pbrSpecularGlossiness";
    let found = extended(
        extension,
        json!({
            "diffuseFactor": [0.1, 0.2, 0.3, 0.4],
            "diffuseTexture": { "index": 0 },
            "specularFactor": [0.5, 0.6, 0.7],
            "glossinessFactor": 0.75,
        }),
    );
    assert_eq!((found.base_color, found.alpha, found.metallic), ([0.1, 0.2, 0.3], 0.4, 0.0));
    assert_eq!((found.roughness, found.ior, found.specular_color), (0.25, 0.0, [0.5, 0.6, 0.7]));
    assert_eq!(number(&found.base_color_texture), 0);

    let mut builder = Builder::with_material(json!({
        "extensions": { extension: { "glossinessFactor": 0.5, "specularGlossinessTexture": { "index": 0 } } },
    }));
    let two = [[10, 20, 30, 255], [40, 50, 60, 51]];
    let view = builder.view(&png(&two));
    builder.push("images", json!({ "bufferView": view }));
    builder.push("textures", json!({ "source": 0 }));
    let found = builder.load().materials[0].surface.clone();
    assert_eq!(texels(&found.specular_color_texture), Some(two.to_vec()));
    assert_eq!(found.roughness, 1.0);
    assert_eq!(texels(&found.metallic_roughness_texture), Some(vec![[0, 128, 0, 255], [0, 230, 0, 255]]));
}

fn textured(info: Value) -> raggio_models::Texture {
    surface(json!({ "emissiveTexture": info })).emissive_texture.unwrap()
}

#[test]
fn texture_transforms() {
    let transform =
        |transform: Value| textured(json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } }));
    assert_eq!(transform(json!({ "offset": [0.5, 0.25] })).transform, [[1.0, 0.0, 0.5], [0.0, 1.0, 0.25]]);
    assert_eq!(transform(json!({ "scale": [2, 3], "texCoord": 1 })).transform, [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    assert_eq!(transform(json!({ "texCoord": 1 })).uv_set, 1);
    // The expected part is the lower left quarter of the image, the extension's own example.
    let quarter = json!({ "offset": [0, 1], "rotation": std::f32::consts::FRAC_PI_2, "scale": [0.5, 0.5] });
    let rows = transform(quarter).transform;
    let expected = [[0.0, 0.5, 0.0], [-0.5, 0.0, 1.0]];
    let near = rows.as_flattened().iter().zip(expected.as_flattened()).all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-6);
    assert!(near, "{rows:?}");
}

#[test]
fn samplers() {
    let mut builder = builder(json!({ "emissiveTexture": { "index": 0 } }));
    let texture = builder.load().materials[0].surface.emissive_texture.clone().unwrap();
    assert_eq!((texture.wrap, texture.filter), ([Wrap::Repeat; 2], TextureFilter::Linear));
    builder.json["samplers"] = json!([{ "magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648 }]);
    builder.json["textures"][0]["sampler"] = json!(0);
    let texture = builder.load().materials[0].surface.emissive_texture.clone().unwrap();
    assert_eq!(texture.wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    assert_eq!(texture.filter, TextureFilter::Nearest);
    builder.json["samplers"] = json!([{ "magFilter": 9987, "wrapS": 10496, "wrapT": 33071 }]);
    let texture = builder.load().materials[0].surface.emissive_texture.clone().unwrap();
    assert_eq!((texture.wrap, texture.filter), ([Wrap::Repeat, Wrap::ClampToEdge], TextureFilter::Linear));
    let expected = [
        "samplers[0].magFilter is 9987, which has no meaning: 9729 (linear) is used",
        "samplers[0].wrapS is 10496, which has no meaning: 10497 (repeat) is used",
    ];
    let mut told = builder.load().warnings;
    told.sort_unstable();
    assert_eq!(told, expected);
}

#[test]
fn images_are_shared() {
    let found = surface(json!({ "emissiveTexture": { "index": 1 }, "normalTexture": { "index": 1 } }));
    let (a, b) = (found.emissive_texture.unwrap(), found.normal_texture.unwrap());
    assert!(std::sync::Arc::ptr_eq(&a.image, &b.image));
}

#[test]
fn other_sets_of_coordinates_are_told() {
    let builder = builder(json!({ "emissiveTexture": { "index": 0, "texCoord": 2 } }));
    assert!(builder.load().materials[0].surface.emissive_texture.is_none());
    assert!(builder.warning().contains("materials[0]: texture 0 is left out: it uses TEXCOORD_2"));
}

#[test]
fn numbers_out_of_range_are_clamped_and_told() {
    let builder = builder(json!({ "pbrMetallicRoughness": { "metallicFactor": 1.5 } }));
    assert_eq!(builder.load().materials[0].surface.metallic, 1.0);
    assert_eq!(builder.warning(), "materials[0].pbrMetallicRoughness.metallicFactor is 1.5: 1 is used instead");
}

#[test]
fn variants_and_unknown_extensions_are_told() {
    let mut builder = builder(json!({}));
    builder.json["extensionsUsed"] = json!(["KHR_materials_variants", "EXT_unheard_of"]);
    builder.json["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "red" }, { "name": "blue" }] } });
    let warnings = builder.load().warnings;
    assert_eq!(
        warnings,
        [
            "the extension `EXT_unheard_of` is not supported and was ignored",
            "the file has 2 variants (`red`, `blue`): the default is used",
        ]
    );
}
