//! MTL, the material libraries of OBJ, as plain data.

use super::lines::{Lines, keyword, words};
use crate::error::{Fault, MeshError};
use crate::text::{number, quoted};

/// A material of a library; `None` where the library is silent. Names of textures are not safe as paths: see
/// [`crate::path_inside`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaterial {
    /// As `usemtl` gives it.
    pub name: String,
    /// Kd.
    pub diffuse: Option<[f32; 3]>,
    /// Ks.
    pub specular: Option<[f32; 3]>,
    /// Ke.
    pub emission: Option<[f32; 3]>,
    /// Tf.
    pub transmission: Option<[f32; 3]>,
    /// Ns.
    pub shininess: Option<f32>,
    /// d, or one minus Tr.
    pub opacity: Option<f32>,
    /// Ni.
    pub refractive_index: Option<f32>,
    /// illum.
    pub illumination: Option<f32>,
    /// Pr.
    pub roughness: Option<f32>,
    /// Pm.
    pub metallic: Option<f32>,
    /// map_Kd.
    pub diffuse_map: Option<String>,
    /// map_Ks.
    pub specular_map: Option<String>,
    /// map_Ke.
    pub emission_map: Option<String>,
    /// map_d.
    pub opacity_map: Option<String>,
    /// map_Pr.
    pub roughness_map: Option<String>,
    /// map_Pm.
    pub metallic_map: Option<String>,
    /// norm.
    pub normal_map: Option<String>,
    /// bump or map_Bump.
    pub bump_map: Option<String>,
}

/// Reads a material library; `name` stands for the file in messages. Unknown lines are passed over.
///
/// # Errors
/// When a value is missing, or is not a finite number.
pub fn parse_mtl(bytes: &[u8], name: &str) -> Result<Vec<MtlMaterial>, MeshError> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for (line, text) in Lines::new(bytes) {
        let (key, rest) = keyword(&text);
        if key == b"newmtl" {
            materials.push(MtlMaterial { name: lossy(rest), ..MtlMaterial::default() });
        } else if let Some(material) = materials.last_mut() {
            set(material, key, rest).map_err(|message| Fault::line(line, message).of(name))?;
        }
    }
    Ok(materials)
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
        b"d" => material.opacity = Some(value(rest.strip_prefix(b"-halo").unwrap_or(rest))?),
        b"tr" => material.opacity = Some(1.0 - value(rest)?),
        b"ni" => material.refractive_index = Some(value(rest)?),
        b"illum" => material.illumination = Some(value(rest)?),
        b"pr" => material.roughness = Some(value(rest)?),
        b"pm" => material.metallic = Some(value(rest)?),
        b"map_kd" => material.diffuse_map = map(rest),
        b"map_ks" => material.specular_map = map(rest),
        b"map_ke" => material.emission_map = map(rest),
        b"map_d" => material.opacity_map = map(rest),
        b"map_pr" => material.roughness_map = map(rest),
        b"map_pm" => material.metallic_map = map(rest),
        b"norm" | b"map_kn" => material.normal_map = map(rest),
        b"bump" | b"map_bump" => material.bump_map = map(rest),
        _ => {}
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

/// One number is a grey. Colours in other spaces and spectra are passed over.
fn color(text: &[u8]) -> Result<Option<[f32; 3]>, String> {
    let words: Vec<_> = words(text).take(3).collect();
    match words[..] {
        [b"xyz" | b"spectral", ..] => Ok(None),
        [grey] => Ok(Some([finite(grey)?; 3])),
        [r, g, b] => Ok(Some([finite(r)?, finite(g)?, finite(b)?])),
        _ => Err("three numbers should follow".to_string()),
    }
}

/// The name of the file, which may have blanks, after options such as `-s 2 2 1`.
fn map(mut rest: &[u8]) -> Option<String> {
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
        for count in 0..most {
            let (word, after) = keyword(rest);
            if count >= least && number(word).is_none() {
                break;
            }
            rest = after;
        }
    }
    (!rest.is_empty()).then(|| lossy(rest))
}
