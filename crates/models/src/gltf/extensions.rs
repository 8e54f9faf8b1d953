//! Extensions that are understood, and messages about others.

use super::asset::Asset;
use super::document::Document;
use super::fault::at;
use crate::error::Fault;
use crate::text::{counted, quoted};

/// Names of the extensions that are understood, those included that change nothing which can be seen.
const KNOWN: [&str; 29] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Refuses files that require unknown extensions.
pub(super) fn check_required(document: &Document) -> Result<(), Fault> {
    let unknown = document.extensions_required.iter().find(|name| !KNOWN.contains(&name.as_str()));
    unknown.map_or(Ok(()), |name| {
        let name = quoted(name.as_bytes());
        Err(at("extensionsRequired", format!("the file needs the extension {name}, which is not supported")))
    })
}

/// Warns of what the file has and is not used, by name.
pub(super) fn warn(asset: &Asset<'_>) {
    let document = &asset.document;
    for name in document.extensions_used.iter().filter(|name| !KNOWN.contains(&name.as_str())) {
        asset.warnings.push(format!("the extension {} is not supported and was ignored", quoted(name.as_bytes())));
    }
    let variants = &document.extensions.variants.variants;
    if !variants.is_empty() {
        let names: Vec<_> = variants.iter().take(20).map(|variant| quoted(variant.name.as_bytes())).collect();
        let variants = counted(variants.len(), "variant");
        asset.warnings.push(format!("the file has {variants} ({}): the default is used", names.join(", ")));
    }
}
