//! The mesh as plain data, and what makes it fit to be drawn.

use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};
use std::ops::Range;
use std::sync::Arc;

use crate::error::{Fault, ModelError};
use crate::obj::mtl::MtlMaterial;

/// Triangles over shared vertices; every list over vertices has the length of `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions of the vertices, in the file's units and axes.
    pub positions: Vec<[f32; 3]>,
    /// Normals as stored, of any length; zero where a vertex has none and the triangle's own normal is meant.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of the vertices, two sets, as stored.
    pub uvs: [Option<Vec<[f32; 2]>>; 2],
    /// Colours of the vertices: linear red, green, blue, alpha, usually 0 to 1; they multiply a material's base colour
    /// and alpha.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Unit tangents along increasing u of the normal map's coordinates; the fourth component, 1 or -1, times normal x
    /// tangent is the bitangent.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Indices of vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Parts of the mesh: ranges of `triangles`, in order and without gaps.
    pub parts: Vec<Part>,
}

/// Consecutive triangles that share a name and a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Name of the file's group, object or solid; may be empty. Shared, because one name may have many parts.
    pub name: Arc<str>,
    /// Material of the part, an index into [`Model::materials`](crate::Model::materials).
    pub material: Option<usize>,
    /// Range of [`Mesh::triangles`].
    pub triangles: Range<usize>,
}

/// Contents of a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// All triangles of the file.
    pub mesh: Mesh,
    /// Materials of the file. Those of OBJ are in the order of their first use, only names until a library is applied;
    /// PLY has the one that a texture makes.
    pub materials: Vec<MtlMaterial>,
    /// Names of the material libraries, in OBJ only. Not safe as paths: see [`crate::path_inside`].
    pub libraries: Vec<String>,
    /// Counts of what cleaning took away.
    pub dropped: Dropped,
    /// Warnings for the user, one sentence each, without the file's name.
    pub warnings: Vec<String>,
}

/// Counts of what [`Mesh::clean`] took away or replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Triangles without area, and polygons with fewer than three corners.
    pub degenerate: usize,
    /// Triangles with a vertex that is infinite or not a number.
    pub not_finite: usize,
    /// Triangles in the place of several others of their part, which a ray would all have to try.
    pub repeated: usize,
    /// Normals, texture coordinates and colours that were infinite or not a number, now neutral.
    pub attributes: usize,
}

impl Dropped {
    /// One sentence for the user, if there is something to tell.
    pub fn warning(&self) -> Option<String> {
        let mut what = Vec::new();
        let mut tell = |count: usize, one: &str, several: &str| {
            if count > 0 {
                what.push(format!("{count} {}", if count == 1 { one } else { several }));
            }
        };
        tell(self.degenerate, "face without area was left out", "faces without area were left out");
        tell(
            self.not_finite,
            "triangle with a vertex that is not finite was left out",
            "triangles with a vertex that is not finite were left out",
        );
        tell(
            self.repeated,
            "triangle that coincides with others was left out",
            "triangles that coincide with others were left out",
        );
        tell(
            self.attributes,
            "normal, texture coordinate or colour that was not finite was replaced",
            "normals, texture coordinates or colours that were not finite were replaced",
        );
        (!what.is_empty()).then(|| what.join("; "))
    }
}

impl MeshFile {
    /// Cleans the mesh and wraps it up.
    pub(crate) fn cleaned(mut mesh: Mesh, mut warnings: Vec<String>, degenerate: usize) -> Result<Self, Fault> {
        let mut dropped = mesh.make_clean()?;
        dropped.degenerate += degenerate;
        if mesh.triangles.is_empty() {
            warnings.push("there are no triangles in this file".to_string());
        }
        Ok(Self { mesh, dropped, warnings, ..Self::default() })
    }

    /// Fills in the materials that `library` has; the first of a name counts. Returns how many were found.
    pub fn apply_library(&mut self, library: &[MtlMaterial]) -> usize {
        let mut by_name = std::collections::HashMap::new();
        for material in library.iter().rev() {
            by_name.insert(material.name.as_str(), material);
        }
        let mut found = 0;
        for material in &mut self.materials {
            if let Some(filled) = by_name.get(material.name.as_str()) {
                *material = (*filled).clone();
                found += 1;
            }
        }
        found
    }
}

impl Mesh {
    /// Drops degenerate triangles, vertices that are not finite and the triangles on them, and makes attributes
    /// that are not finite neutral: zero for normals and texture coordinates, white for colours.
    ///
    /// # Errors
    /// When an index is out of range, or lists do not have the lengths that they should have; `file` is named then.
    pub fn clean(&mut self, file: &str) -> Result<Dropped, ModelError> {
        self.make_clean().map_err(|fault| fault.of(file))
    }

    fn make_clean(&mut self) -> Result<Dropped, Fault> {
        self.check()?;
        let mut dropped = Dropped::default();
        self.drop_triangles(&mut dropped);
        self.drop_repeated(&mut dropped);
        self.drop_vertices();
        let fix = |value: &mut [f32], neutral: f32| {
            let broken = value.iter().any(|x| !x.is_finite());
            if broken {
                value.fill(neutral);
            }
            usize::from(broken)
        };
        dropped.attributes += self.normals.iter_mut().flatten().map(|n| fix(n, 0.0)).sum::<usize>();
        dropped.attributes += self.uvs.iter_mut().flatten().flatten().map(|uv| fix(uv, 0.0)).sum::<usize>();
        dropped.attributes += self.tangents.iter_mut().flatten().map(|t| fix(t, 0.0)).sum::<usize>();
        dropped.attributes += self.colors.iter_mut().flatten().map(|c| fix(c, 1.0)).sum::<usize>();
        Ok(dropped)
    }

    fn check(&self) -> Result<(), Fault> {
        let vertices = self.positions.len();
        let lengths = [&self.tangents, &self.colors].map(|list| list.as_ref().map(Vec::len));
        let lengths = lengths.into_iter().chain([self.normals.as_ref().map(Vec::len)]);
        let lengths = lengths.chain(self.uvs.iter().map(|uv| uv.as_ref().map(Vec::len)));
        if let Some(length) = lengths.flatten().find(|length| *length != vertices) {
            return Err(Fault::whole(format!("a list over the vertices has {length} entries: there are {vertices}")));
        }
        for (number, triangle) in self.triangles.iter().enumerate() {
            if let Some(index) = triangle.iter().find(|index| **index as usize >= vertices) {
                let message = format!(
                    "triangle {number} (counted from 0) names vertex {index}: with {vertices} vertices the index \
                     has to be below {vertices}"
                );
                return Err(Fault::whole(message));
            }
        }
        let mut end = 0;
        let in_order = self.parts.iter().all(|part| {
            let fits = part.triangles.start == end && part.triangles.end >= end;
            end = part.triangles.end;
            fits
        });
        if in_order && end == self.triangles.len() {
            return Ok(());
        }
        Err(Fault::whole("the parts of the mesh should hold all its triangles in order"))
    }

    fn drop_triangles(&mut self, dropped: &mut Dropped) {
        let mut kept = 0;
        for part in &mut self.parts {
            let start = kept;
            for number in part.triangles.clone() {
                let triangle = self.triangles[number];
                let corners = triangle.map(|index| self.positions[index as usize]);
                if corners.as_flattened().iter().any(|x| !x.is_finite()) {
                    dropped.not_finite += 1;
                } else if has_no_area(corners) {
                    dropped.degenerate += 1;
                } else {
                    self.triangles[kept] = triangle;
                    kept += 1;
                }
            }
            part.triangles = start..kept;
        }
        self.triangles.truncate(kept);
        self.parts.retain(|part| !part.triangles.is_empty());
    }

    /// Drops triangles that have the corners of several others of their part, in the same order. A few in one place stay:
    /// they cost little, and may be meant, as coats of glass are. In a large mesh a few such places are not looked for.
    fn drop_repeated(&mut self, dropped: &mut Dropped) {
        /// Triangles that are looked at to find out whether any coincide.
        const LOOKED_AT: usize = 1 << 18;
        /// Triangles that may stay in one place.
        const FEW: u32 = 4;
        let stride = self.triangles.len().div_ceil(LOOKED_AT).max(1);
        let hasher = RandomState::new();
        let mut hashes: Vec<u64> =
            self.triangles.iter().step_by(stride).map(|t| hasher.hash_one(self.corners(t))).collect();
        hashes.sort_unstable();
        if hashes.windows(2).all(|pair| pair[0] != pair[1]) {
            return;
        }
        let mut kept = 0;
        for place in 0..self.parts.len() {
            let mut known = HashMap::<_, u32>::new();
            let start = kept;
            for number in self.parts[place].triangles.clone() {
                let there = known.entry(self.corners(&self.triangles[number])).or_default();
                *there += 1;
                if *there <= FEW {
                    self.triangles[kept] = self.triangles[number];
                    kept += 1;
                }
            }
            self.parts[place].triangles = start..kept;
        }
        dropped.repeated += self.triangles.len() - kept;
        self.triangles.truncate(kept);
    }

    /// Bits of a triangle's corners, of which the least stands first.
    fn corners(&self, triangle: &[u32; 3]) -> [[u32; 3]; 3] {
        // Zero has two signs.
        let bits = |index: u32| self.positions[index as usize].map(|x| (x + 0.0).to_bits());
        let mut corners = triangle.map(bits);
        let least = (0..3).min_by_key(|i| corners[*i]).unwrap_or(0);
        corners.rotate_left(least);
        corners
    }

    /// Drops vertices that are not finite even where no triangle uses them, because bounds are taken over all vertices.
    fn drop_vertices(&mut self) {
        let finite: Vec<bool> = self.positions.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
        if finite.iter().all(|finite| *finite) {
            return;
        }
        let mut kept = 0;
        let renumbered = finite.iter().map(|finite| {
            let number: u32 = kept;
            kept += u32::from(*finite);
            number
        });
        let renumbered: Vec<u32> = renumbered.collect();
        for index in self.triangles.iter_mut().flatten() {
            *index = renumbered[*index as usize];
        }
        keep(&mut self.positions, &finite);
        self.normals.iter_mut().for_each(|normals| keep(normals, &finite));
        self.uvs.iter_mut().flatten().for_each(|uvs| keep(uvs, &finite));
        self.tangents.iter_mut().for_each(|tangents| keep(tangents, &finite));
        self.colors.iter_mut().for_each(|colors| keep(colors, &finite));
    }
}

fn keep<T>(list: &mut Vec<T>, wanted: &[bool]) {
    let mut wanted = wanted.iter();
    list.retain(|_| wanted.next().copied().unwrap_or(false));
}

/// Whether a triangle has no area, in double precision: neither differences nor products of single-precision numbers
/// overflow or vanish in it.
fn has_no_area(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    (0..3).all(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] - u[k] * v[j] == 0.0
    })
}
