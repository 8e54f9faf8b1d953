//! OBJ: polygons over positions, texture coordinates and normals that have indices of their own.

mod bump;
mod lines;
pub(crate) mod lookup;
pub(crate) mod materials;
pub(crate) mod mtl;
mod pack;
mod smoothing;
pub(crate) mod textures;

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use crate::color::make_linear;
use crate::error::{Fault, ModelError};
use crate::mesh::{Mesh, MeshFile, Part};
use crate::polygon::Triangulator;
use crate::text::{number, quoted, unmarked};
use crate::warnings::Warnings;
use lines::{Lines, keyword, words};
use lookup::unquoted;
use mtl::{MtlMaterial, lossy};
use smoothing::Smoothing;

/// Reads an OBJ file; `name` stands for the file in messages. Material libraries are named, not read. Colours of vertices
/// are taken for sRGB, as programs write them, and made linear. Corners without a normal have that of their smoothing
/// group.
///
/// # Errors
/// When the bytes are not a valid OBJ file: a number is none.
pub fn parse_obj(bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
    let text = unmarked(bytes);
    let mut reader = Reader::default();
    for (line, text) in Lines::new(&text) {
        reader.line = line;
        reader.read(&text).map_err(|message| Fault::line(line, message).of(name))?;
    }
    reader.finish().map_err(|fault| fault.of(name))
}

/// A corner of a face: indices of what it has. Equal ones are one vertex of the mesh.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    uv: Option<u32>,
    normal: Normal,
}

/// Source of a corner's normal.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Normal {
    /// The face itself.
    Flat,
    /// A normal of the file.
    Given(u32),
    /// A normal of [`Smoothing`].
    Smooth(u32),
}

/// Number of corners or faces that name something that is not there, and the line of the first.
#[derive(Default)]
struct Absent {
    count: usize,
    line: usize,
}

#[derive(Default)]
struct Reader {
    /// Number of the line at hand.
    line: usize,
    positions: Vec<[f32; 3]>,
    /// Colours of the vertices: as many as `positions`, or none as long as no vertex has had a colour.
    colors: Vec<[f32; 4]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    smoothing: Smoothing,
    /// The vertices of the mesh.
    corners: Vec<Corner>,
    numbers: foldhash::HashMap<Corner, u32>,
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
    /// Faces, of which a corner names a position that is not there.
    absent_positions: Absent,
    absent_uvs: Absent,
    absent_normals: Absent,
    curves: usize,
    /// Number of lines and points.
    lines: usize,
    warnings: Warnings,
}

impl Reader {
    fn read(&mut self, text: &[u8]) -> Result<(), String> {
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
            b"s" => self.smooth(rest),
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

    /// Reads a smoothing group: a number, or `off` or 0 for flat faces.
    fn smooth(&mut self, rest: &[u8]) {
        let group = match rest {
            b"off" => Some(0),
            b"on" => Some(1),
            _ => number(rest).filter(|group| group.is_finite()).map(|group| group as i64),
        };
        if group.is_none() {
            let line = self.line;
            self.warnings.push(format!("line {line}: {} is not a smoothing group: its faces are flat", quoted(rest)));
        }
        self.smoothing.begin(group.unwrap_or(0));
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut polygon = std::mem::take(&mut self.polygon);
        polygon.clear();
        let known = self.corners.len();
        for word in words(rest) {
            let Some(corner) = self.corner(word)? else {
                // Blender leaves such faces out, too. Vertices of their own would count for the bounds of the mesh.
                for corner in self.corners.drain(known..) {
                    self.numbers.remove(&corner);
                }
                self.absent_positions.add(self.line);
                self.polygon = polygon;
                return Ok(());
            };
            polygon.push(self.vertex_of(corner)?);
        }
        self.too_few += usize::from(polygon.len() < 3);
        let corner = |i: usize| self.corners[polygon[i] as usize];
        let position = |i: usize| self.positions[corner(i).position as usize];
        self.smoothing.add(polygon.len(), position, |i| match corner(i).normal {
            Normal::Smooth(normal) => Some(normal),
            _ => None,
        });
        let triangulator = self.triangulator.get_or_insert_with(Triangulator::new);
        triangulator.add(&polygon, position, &mut self.triangles);
        self.polygon = polygon;
        Ok(())
    }

    /// The corner that `v`, `v/vt`, `v//vn` or `v/vt/vn` means; `None` where it has no position. Exporters name texture
    /// coordinates and normals that they do not write, or index 0 for none: such a corner has none.
    fn corner(&mut self, word: &[u8]) -> Result<Option<Corner>, String> {
        let mut fields = word.split(|byte| *byte == b'/');
        let [position, uv, normal, end] = std::array::from_fn(|_| fields.next());
        let shape = || format!("{} should be `v`, `v/vt`, `v//vn` or `v/vt/vn`", quoted(word));
        let position = position.filter(|_| end.is_none()).ok_or_else(shape)?;
        let position = if position.is_empty() { Index(0) } else { index(position, "position")? };
        let Some(position) = position.of(self.positions.len()) else { return Ok(None) };
        let uv = self.absent_uvs.check(uv, "texture coordinate", self.uvs.len(), self.line)?;
        let normal = self.absent_normals.check(normal, "normal", self.normals.len(), self.line)?;
        let normal = normal.map(Normal::Given).unwrap_or_else(|| self.smoothing.of(position));
        Ok(Some(Corner { position, uv, normal }))
    }

    /// Number of the mesh's vertex for a corner.
    fn vertex_of(&mut self, corner: Corner) -> Result<u32, String> {
        match self.numbers.entry(corner) {
            Entry::Occupied(entry) => Ok(*entry.get()),
            Entry::Vacant(entry) => {
                let number = u32::try_from(self.corners.len());
                let number = number.map_err(|_| "there are more vertices than a mesh can have")?;
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
            if word.strip_suffix(b"\"").unwrap_or(word).to_ascii_lowercase().ends_with(b".mtl") {
                names.push(lossy(unquoted(&std::mem::take(&mut name))));
            }
        }
        if !name.is_empty() {
            names.push(lossy(unquoted(&name)));
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
        let smooth = self.smoothing.into_normals();
        let uv = |corner: &Corner| corner.uv.map_or([0.0; 2], |uv| self.uvs[uv as usize]);
        let normal = |corner: &Corner| match corner.normal {
            Normal::Flat => [0.0; 3],
            Normal::Given(normal) => self.normals[normal as usize],
            Normal::Smooth(normal) => smooth[normal as usize],
        };
        let corners = &self.corners;
        let has_uvs = corners.iter().any(|corner| corner.uv.is_some());
        let has_normals = corners.iter().any(|corner| corner.normal != Normal::Flat);
        let mesh = Mesh {
            positions: gather(corners, |corner| self.positions[corner.position as usize]),
            normals: has_normals.then(|| gather(corners, normal)),
            uvs: [has_uvs.then(|| gather(corners, uv)), None],
            colors: (!self.colors.is_empty()).then(|| gather(corners, |corner| self.colors[corner.position as usize])),
            tangents: None,
            triangles: self.triangles,
            parts: self.parts,
        };
        let mut warnings = self.warnings;
        warnings.extend(self.absent_positions.faces());
        warnings.extend(self.absent_normals.corners("normals"));
        warnings.extend(self.absent_uvs.corners("texture coordinates"));
        if self.curves > 0 {
            warnings.push(format!("{} free-form curves or surfaces are not read: only polygons are", self.curves));
        }
        if self.lines > 0 {
            warnings.push(format!("{} lines and points are not read: only polygons are", self.lines));
        }
        let model = MeshFile::cleaned(mesh, warnings.into_sentences(), self.too_few)?;
        Ok(MeshFile { materials: self.materials, libraries: self.libraries, ..model })
    }
}

impl Absent {
    /// Index of what a field of a corner names, which has `count` entries so far; `None` where it names nothing.
    fn check(&mut self, field: Option<&[u8]>, what: &str, count: usize, line: usize) -> Result<Option<u32>, String> {
        let Some(field) = field.filter(|field| !field.is_empty()) else { return Ok(None) };
        let index = index(field, what)?.of(count);
        if index.is_none() {
            self.add(line);
        }
        Ok(index)
    }

    fn add(&mut self, line: usize) {
        self.line = if self.count == 0 { line } else { self.line };
        self.count += 1;
    }

    /// Sentence about faces that are left out, if there are any.
    fn faces(&self) -> Option<String> {
        match *self {
            Self { count: 0, .. } => None,
            Self { count: 1, line } => {
                Some(format!("the face in line {line} names a vertex that does not exist: it is left out"))
            }
            Self { count, line } => Some(format!(
                "{count} faces name vertices that do not exist, the first in line {line}: they are left out"
            )),
        }
    }

    /// Sentence about corners that have less than they say, if there are any.
    fn corners(&self, what: &str) -> Option<String> {
        let Self { count, line } = self;
        (*count > 0).then(|| {
            if *count == 1 {
                return format!("a corner of the face in line {line} names {what} that do not exist: it has none");
            }
            format!("{count} corners of faces name {what} that do not exist, the first in line {line}: they have none")
        })
    }
}

fn gather<T>(corners: &[Corner], of: impl Fn(&Corner) -> T) -> Vec<T> {
    corners.iter().map(of).collect()
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

/// An index as files have it: from 1, or backwards from the last one with -1.
#[derive(Clone, Copy)]
struct Index(i64);

impl Index {
    /// The index counted from 0, if there is such an entry among `count`.
    fn of(self, count: usize) -> Option<u32> {
        let Self(number) = self;
        let from_zero = if number < 0 { number.saturating_add_unsigned(count as u64) } else { number - 1 };
        u32::try_from(from_zero).ok().filter(|index| (*index as usize) < count)
    }
}

fn index(field: &[u8], what: &str) -> Result<Index, String> {
    let number = std::str::from_utf8(field).ok().and_then(|field| field.parse().ok()).map(Index);
    number.ok_or_else(|| format!("{} should be the number of a {what}", quoted(field)))
}
