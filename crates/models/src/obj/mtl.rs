//! MTL, the material libraries of OBJ, as plain data.

use super::lines::{Lines, keyword, words};
use super::lookup::unquoted;
use crate::text::{number, quoted, unmarked};
use crate::warnings::Warnings;

/// Most unknown keywords of a material that are told.
const MOST_UNREAD: usize = 16;

/// Contents of a material library.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlLibrary {
    /// Materials in the order of the file.
    pub materials: Vec<MtlMaterial>,
    /// Warnings for the user, one sentence each, with the file's name.
    pub warnings: Vec<String>,
}

/// A material of a library; `None` where the library is silent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaterial {
    /// Name of the material, as `usemtl` gives it.
    pub name: String,
    /// Folder of the library as the OBJ names it, with a slash at its end; empty for the OBJ's own folder.
    pub folder: String,
    /// Diffuse colour (Kd).
    pub diffuse: Option<[f32; 3]>,
    /// Specular colour (Ks).
    pub specular: Option<[f32; 3]>,
    /// Emitted colour (Ke).
    pub emission: Option<[f32; 3]>,
    /// Transmission filter (Tf).
    pub transmission: Option<[f32; 3]>,
    /// Exponent of the highlight (Ns).
    pub shininess: Option<f32>,
    /// Opacity (d, or one minus Tr).
    pub opacity: Option<f32>,
    /// Whether the opacity is one minus Tr, which some programs write with the meaning of d.
    pub opacity_by_tr: bool,
    /// Refractive index (Ni).
    pub refractive_index: Option<f32>,
    /// Illumination model (illum).
    pub illumination: Option<f32>,
    /// Roughness (Pr).
    pub roughness: Option<f32>,
    /// Metalness (Pm).
    pub metallic: Option<f32>,
    /// Strength of the clear coat (Pc).
    pub clearcoat: Option<f32>,
    /// Roughness of the clear coat (Pcr).
    pub clearcoat_roughness: Option<f32>,
    /// Anisotropy (aniso).
    pub anisotropy: Option<f32>,
    /// Rotation of the anisotropy in turns (anisor).
    pub anisotropy_rotation: Option<f32>,
    /// Texture of the diffuse colour (map_Kd).
    pub diffuse_map: Option<MtlMap>,
    /// Texture of the specular colour (map_Ks).
    pub specular_map: Option<MtlMap>,
    /// Texture of the emitted colour (map_Ke).
    pub emission_map: Option<MtlMap>,
    /// Texture of the opacity (map_d).
    pub opacity_map: Option<MtlMap>,
    /// Texture of the roughness (map_Pr).
    pub roughness_map: Option<MtlMap>,
    /// Texture of the metalness (map_Pm).
    pub metallic_map: Option<MtlMap>,
    /// Normal map (norm).
    pub normal_map: Option<MtlMap>,
    /// Bump map (bump or map_Bump).
    pub bump_map: Option<MtlMap>,
    /// The first keywords of lines that say something which is not read, each once, quoted for messages.
    pub unread: Vec<String>,
}

/// A texture as a library names it, with its options. Coordinates become `scale * coordinates + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMap {
    /// Name of the file. Not safe as a path: see [`crate::path_inside`].
    pub file: String,
    /// Scale of the coordinates along u and v (-s).
    pub scale: [f32; 2],
    /// Offset of the coordinates along u and v (-o).
    pub offset: [f32; 2],
    /// Whether the image is clamped to its edges (-clamp on).
    pub clamp: bool,
    /// Bump multiplier (-bm).
    pub multiplier: f32,
}

/// Reads a material library; `name` stands for the file in warnings. Unknown lines are passed over, and so is, with a
/// warning, one whose value is missing or not a finite number.
pub fn parse_mtl(bytes: &[u8], name: &str) -> MtlLibrary {
    let text = unmarked(bytes);
    let (mut materials, mut warnings) = (Vec::<MtlMaterial>::new(), Warnings::default());
    for (line, text) in Lines::new(&text) {
        let (key, rest) = keyword(&text);
        if key.eq_ignore_ascii_case(b"newmtl") {
            materials.push(MtlMaterial { name: lossy(rest), ..MtlMaterial::default() });
        } else if let Some(material) = materials.last_mut()
            && let Err(message) = set(material, key, rest)
        {
            warnings.push(format!("{name}:{line}: {message}: {} keeps its default", quoted(key)));
        }
    }
    MtlLibrary { materials, warnings: warnings.into_sentences() }
}

pub(super) fn lossy(text: &[u8]) -> String {
    String::from_utf8_lossy(text).into_owned()
}

fn set(material: &mut MtlMaterial, key: &[u8], rest: &[u8]) -> Result<(), String> {
    match key.to_ascii_lowercase().as_slice() {
        b"kd" => material.diffuse = color(rest)?,
        b"ks" => material.specular = color(rest)?,
        b"ke" => material.emission = color(rest)?,
        b"tf" => material.transmission = color(rest)?,
        b"ns" => material.shininess = Some(value(rest)?),
        b"d" => {
            let opacity = value(rest.strip_prefix(b"-halo").unwrap_or(rest))?;
            (material.opacity, material.opacity_by_tr) = (Some(opacity), false);
        }
        // The value of `d` counts where both are given: `Tr` has been written with either meaning.
        b"tr" if material.opacity.is_none() || material.opacity_by_tr => {
            (material.opacity, material.opacity_by_tr) = (Some(1.0 - value(rest)?), true);
        }
        b"tr" => {}
        b"ni" => material.refractive_index = Some(value(rest)?),
        b"illum" => material.illumination = Some(value(rest)?),
        b"pr" => material.roughness = Some(value(rest)?),
        b"pm" => material.metallic = Some(value(rest)?),
        b"pc" => material.clearcoat = Some(value(rest)?),
        b"pcr" => material.clearcoat_roughness = Some(value(rest)?),
        b"aniso" => material.anisotropy = Some(value(rest)?),
        b"anisor" => material.anisotropy_rotation = Some(value(rest)?),
        b"map_kd" => map(rest, &mut material.diffuse_map)?,
        b"map_ks" => map(rest, &mut material.specular_map)?,
        b"map_ke" => map(rest, &mut material.emission_map)?,
        b"map_d" => map(rest, &mut material.opacity_map)?,
        b"map_pr" => map(rest, &mut material.roughness_map)?,
        b"map_pm" => map(rest, &mut material.metallic_map)?,
        b"norm" | b"map_kn" => map(rest, &mut material.normal_map)?,
        b"bump" | b"map_bump" => map(rest, &mut material.bump_map)?,
        // Ambient reflection is for the light to say; the others are switches for renderers of old.
        b"ka" | b"map_ka" | b"sharpness" | b"map_aat" => {}
        _ => unread(material, key, rest),
    }
    Ok(())
}

fn value(text: &[u8]) -> Result<f32, String> {
    let word = words(text).next().ok_or("a number should follow")?;
    finite(word)
}

fn finite(word: &[u8]) -> Result<f32, String> {
    let value = number(word).map(|value| value as f32).filter(|value| value.is_finite());
    value.ok_or_else(|| format!("{} should be a finite number", quoted(word)))
}

/// Colour of a line; one number is a grey. Colours in other spaces and spectra are passed over.
fn color(text: &[u8]) -> Result<Option<[f32; 3]>, String> {
    let words: Vec<_> = words(text).take(3).collect();
    match words[..] {
        [b"xyz" | b"spectral", ..] => Ok(None),
        [grey] => Ok(Some([finite(grey)?; 3])),
        [r, g, b] => Ok(Some([finite(r)?, finite(g)?, finite(b)?])),
        _ => Err("three numbers should follow".to_string()),
    }
}

/// Notes an unread keyword, unless its line is all zeros and says nothing.
fn unread(material: &mut MtlMaterial, key: &[u8], rest: &[u8]) {
    let is_new = material.unread.len() < MOST_UNREAD && words(rest).any(|word| number(word) != Some(0.0));
    let key = quoted(key);
    if is_new && !material.unread.contains(&key) {
        material.unread.push(key);
    }
}

/// Reads the texture of a line: options such as `-s 2 2 1`, then the name of the file, which may have blanks. An option whose
/// numbers are none keeps its default, and is told.
fn map(mut rest: &[u8], into: &mut Option<MtlMap>) -> Result<(), String> {
    let (mut map, mut told) = (MtlMap::named(String::new()), Ok(()));
    loop {
        let (option, after) = keyword(rest);
        let (least, most) = match option {
            b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-bm" | b"-boost" | b"-texres" | b"-imfchan" | b"-type" => {
                (1, 1)
            }
            b"-mm" => (2, 2),
            b"-o" | b"-s" | b"-t" => (1, 3),
            _ => break,
        };
        rest = after;
        let mut values = Vec::new();
        for count in 0..most {
            let (word, after) = keyword(rest);
            if count >= least && number(word).is_none() {
                break;
            }
            values.push(word);
            rest = after;
        }
        told = told.and(map.set(option, &values));
    }
    map.file = lossy(unquoted(rest));
    *into = (!map.file.is_empty()).then_some(map);
    told
}

impl MtlMap {
    /// A texture without options.
    pub(crate) fn named(file: String) -> Self {
        Self { file, scale: [1.0; 2], offset: [0.0; 2], clamp: false, multiplier: 1.0 }
    }

    /// Sets an option; those that are not known change nothing.
    fn set(&mut self, option: &[u8], values: &[&[u8]]) -> Result<(), String> {
        let value = |i: usize, default: f32| match values.get(i) {
            Some(word) => finite(word).map_err(|message| format!("{message} behind {}", quoted(option))),
            None => Ok(default),
        };
        match option {
            b"-clamp" => self.clamp = values == [b"on"],
            b"-bm" => self.multiplier = value(0, 1.0)?,
            b"-s" => self.scale = [value(0, 1.0)?, value(1, 1.0)?],
            b"-o" => self.offset = [value(0, 0.0)?, value(1, 0.0)?],
            _ => {}
        }
        Ok(())
    }
}
