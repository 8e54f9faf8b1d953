//! OBJ: polygons over positions, texture coordinates and normals that have indices of their own.

mod lines;
pub(crate) mod materials;
pub(crate) mod mtl;
mod pack;
pub(crate) mod textures;

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::color::make_linear;
use crate::error::{Fault, ModelError};
use crate::mesh::{Mesh, MeshFile, Part};
use crate::polygon::Triangulator;
use crate::text::{number, quoted};
use lines::{Lines, keyword, words};
use mtl::{MtlMaterial, lossy};

/// Index of a corner that has no texture coordinate, or no normal.
const NONE: u32 = u32::MAX;

/// Reads an OBJ file; `name` stands for the file in messages. Material libraries are named, not read. Colours of vertices
/// are taken for sRGB, as programs write them, and made linear.
///
/// # Errors
/// When the bytes are not a valid OBJ file: an index names nothing above its line, or a number is none.
pub fn parse_obj(bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
    let mut reader = Reader::default();
    for (line, text) in Lines::new(bytes) {
        reader.line(&text).map_err(|message| Fault::line(line, message).of(name))?;
    }
    reader.finish().map_err(|fault| fault.of(name))
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f32; 3]>,
    /// Colours of the vertices: as many as `positions`, or none as long as no vertex has had a colour.
    colors: Vec<[f32; 4]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// The vertices of the mesh: position, texture coordinate, normal.
    corners: Vec<[u32; 3]>,
    numbers: foldhash::HashMap<[u32; 3], u32>,
    triangles: Vec<[u32; 3]>,
    triangulator: Option<Triangulator>,
    polygon: Vec<u32>,
    too_few: usize,
    parts: Vec<Part>,
    part_start: usize,
    group: Arc<str>,
    material: Option<usize>,
    materials: Vec<MtlMaterial>,
    material_numbers: HashMap<String, usize>,
    libraries: Vec<String>,
    libraries_seen: HashSet<String>,
    curves: usize,
    /// Number of lines and points.
    lines: usize,
}

impl Reader {
    fn line(&mut self, text: &[u8]) -> Result<(), String> {
        let (key, rest) = keyword(text);
        match key {
            b"v" => self.vertex(rest)?,
            b"vt" => {
                let ([u, v], _) = numbers::<2>(rest, 1)?;
                self.uvs.push([u, v]);
            }
            b"vn" => self.normals.push(numbers::<3>(rest, 3)?.0),
            b"f" | b"fo" => self.face(rest)?,
            b"g" | b"o" => {
                self.end_part();
                self.group = lossy(rest).into();
            }
            b"usemtl" => {
                self.end_part();
                self.use_material(lossy(rest));
            }
            b"mtllib" => self.name_libraries(rest),
            b"curv" | b"curv2" | b"surf" => self.curves += 1,
            b"l" | b"p" => self.lines += 1,
            _ => {}
        }
        Ok(())
    }

    /// Reads a vertex: `x y z`, `x y z w` or `x y z red green blue`.
    fn vertex(&mut self, rest: &[u8]) -> Result<(), String> {
        let ([x, y, z, r, g, b], count) = numbers::<6>(rest, 3)?;
        if count == 6 || !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 4]);
            self.colors.push(if count == 6 { [r, g, b, 1.0] } else { [1.0; 4] });
        }
        self.positions.push([x, y, z]);
        Ok(())
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut polygon = std::mem::take(&mut self.polygon);
        polygon.clear();
        for word in words(rest) {
            polygon.push(self.corner(word)?);
        }
        self.too_few += usize::from(polygon.len() < 3);
        let triangulator = self.triangulator.get_or_insert_with(Triangulator::new);
        let position = |i: usize| self.positions[self.corners[polygon[i] as usize][0] as usize];
        triangulator.add(&polygon, position, &mut self.triangles);
        self.polygon = polygon;
        Ok(())
    }

    /// The vertex that `v`, `v/vt`, `v//vn` or `v/vt/vn` means.
    fn corner(&mut self, word: &[u8]) -> Result<u32, String> {
        let mut fields = word.split(|byte| *byte == b'/');
        let mut field = |what: &str, count: usize| match fields.next() {
            None | Some(b"") => Ok(NONE),
            Some(field) => index(field, what, count),
        };
        let corner = [
            field("position", self.positions.len())?,
            field("texture coordinate", self.uvs.len())?,
            field("normal", self.normals.len())?,
        ];
        if corner[0] == NONE || fields.next().is_some() {
            return Err(format!("{} should be `v`, `v/vt`, `v//vn` or `v/vt/vn`", quoted(word)));
        }
        match self.numbers.entry(corner) {
            Entry::Occupied(entry) => Ok(*entry.get()),
            Entry::Vacant(entry) => {
                let number = u32::try_from(self.corners.len()).ok().filter(|number| *number != NONE);
                let number = number.ok_or("there are more vertices than a mesh can have")?;
                self.corners.push(corner);
                Ok(*entry.insert(number))
            }
        }
    }

    fn end_part(&mut self) {
        let end = self.triangles.len();
        if end > self.part_start {
            let name = Arc::clone(&self.group);
            self.parts.push(Part { name, material: self.material, triangles: self.part_start..end });
            self.part_start = end;
        }
    }

    fn use_material(&mut self, name: String) {
        let next = self.materials.len();
        let number = *self.material_numbers.entry(name).or_insert_with_key(|name| {
            self.materials.push(MtlMaterial { name: name.clone(), ..MtlMaterial::default() });
            next
        });
        self.material = Some(number);
    }

    /// Reads the names of libraries: several, or one with blanks, as a name ends in `.mtl`.
    fn name_libraries(&mut self, rest: &[u8]) {
        let mut name = Vec::new();
        let mut names = Vec::new();
        for word in words(rest) {
            if !name.is_empty() {
                name.push(b' ');
            }
            name.extend_from_slice(word);
            if word.to_ascii_lowercase().ends_with(b".mtl") {
                names.push(lossy(&std::mem::take(&mut name)));
            }
        }
        if !name.is_empty() {
            names.push(lossy(&name));
        }
        for name in names {
            if self.libraries_seen.insert(name.clone()) {
                self.libraries.push(name);
            }
        }
    }

    fn finish(mut self) -> Result<MeshFile, Fault> {
        self.end_part();
        self.numbers = foldhash::HashMap::default();
        make_linear(&mut self.colors);
        let has = |field: usize| self.corners.iter().any(|corner| corner[field] != NONE);
        let mesh = Mesh {
            positions: gather(&self.corners, 0, &self.positions, [0.0; 3]),
            normals: has(2).then(|| gather(&self.corners, 2, &self.normals, [0.0; 3])),
            uvs: [has(1).then(|| gather(&self.corners, 1, &self.uvs, [0.0; 2])), None],
            colors: (!self.colors.is_empty()).then(|| gather(&self.corners, 0, &self.colors, [1.0; 4])),
            tangents: None,
            triangles: self.triangles,
            parts: self.parts,
        };
        let mut warnings = Vec::new();
        if self.curves > 0 {
            warnings.push(format!("{} free-form curves or surfaces are not read: only polygons are", self.curves));
        }
        if self.lines > 0 {
            warnings.push(format!("{} lines and points are not read: only polygons are", self.lines));
        }
        let model = MeshFile::cleaned(mesh, warnings, self.too_few)?;
        Ok(MeshFile { materials: self.materials, libraries: self.libraries, ..model })
    }
}

fn gather<T: Copy>(corners: &[[u32; 3]], field: usize, from: &[T], missing: T) -> Vec<T> {
    corners.iter().map(|corner| from.get(corner[field] as usize).copied().unwrap_or(missing)).collect()
}

/// Numbers of a text, at least `least` and at most N, and their count; the others are zero.
fn numbers<const N: usize>(text: &[u8], least: usize) -> Result<([f32; N], usize), String> {
    let (mut values, mut count) = ([0.0; N], 0);
    for (value, word) in values.iter_mut().zip(words(text)) {
        *value = number(word).ok_or_else(|| format!("{} should be a number", quoted(word)))? as f32;
        count += 1;
    }
    if count < least {
        return Err(format!("{least} numbers should follow, there are {count}"));
    }
    Ok((values, count))
}

/// Index counted from 0 of one that counts from 1, or backwards from the last one with -1.
fn index(field: &[u8], what: &str, count: usize) -> Result<u32, String> {
    let number = std::str::from_utf8(field).ok().and_then(|field| field.parse::<i64>().ok());
    let number = number.ok_or_else(|| format!("{} should be the number of a {what}", quoted(field)))?;
    let from_zero = if number < 0 { number.saturating_add_unsigned(count as u64) } else { number - 1 };
    let index = u32::try_from(from_zero).ok().filter(|index| (*index as usize) < count && *index != NONE);
    index.ok_or_else(|| {
        let right = format!("1 to {count} or -1 to -{count}");
        match count {
            0 => format!("the {what} {number} does not exist: there are none above this line"),
            _ => format!("the {what} {number} does not exist: the lines above allow {right}"),
        }
    })
}
