//! STL, binary and ascii. The normals of the file are not read: the corners' order says which way a facet faces, and
//! writers often leave the normals zero.

use std::collections::hash_map::Entry;
use std::sync::Arc;

use foldhash::HashMap;

use crate::error::{Fault, ModelError, Place};
use crate::mesh::{Mesh, MeshFile, Part};
use crate::polygon::Triangulator;
use crate::text::{Words, quoted, unmarked};
use crate::warnings::Warnings;

const HEADER_BYTES: usize = 84;
const FACET_BYTES: usize = 50;
/// Bytes within which an ascii file has its first facet.
const ASCII_PROBE_BYTES: usize = 4096;
/// Words after `facet` that are its normal, in whatever form: `normal` and three numbers.
const MOST_NORMAL_WORDS: u32 = 4;
/// Largest coordinate that is taken for one where the length of a binary file does not say that it is an STL at all.
const LARGEST_PLAUSIBLE: f32 = 1e18;

/// Reads an STL file; `name` stands for the file in messages. Vertices at the same place become one.
///
/// # Errors
/// When the bytes are not a valid STL file.
pub fn parse_stl(bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
    let mut warnings = Warnings::default();
    let (mesh, degenerate) = read(bytes, &mut warnings).map_err(|fault| fault.of(name))?;
    MeshFile::cleaned(mesh, warnings.into_sentences(), degenerate).map_err(|fault| fault.of(name))
}

/// Reads a binary or ascii file. A length that fits the declared count decides for binary, because binary headers may
/// begin with "solid", too. No ascii file can fit: four characters of text in the place of the count declare more than
/// 25 GB.
fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<(Mesh, usize), Fault> {
    let facets = facets(bytes);
    if let Some(facets) = facets.filter(|facets| facets.are_all_there()) {
        return Ok((binary(facets.bytes), 0));
    }
    let text = unmarked(bytes);
    if is_ascii(&text) {
        return ascii(&text, warnings);
    }
    let message = "is not an STL: an ascii one begins with `solid`, a binary one has 84 bytes or more";
    let facets = facets.ok_or_else(|| Fault::whole(message))?;
    if facets.declared <= facets.there() && (facets.declared > 0 || facets.there() == 0) {
        let extra = facets.bytes.len() as u64 - facets.declared * FACET_BYTES as u64;
        warnings.push(format!("{extra} bytes after the last facet are not read"));
        return Ok((binary(&facets.bytes[..facets.bytes.len() - extra as usize]), 0));
    }
    if facets.are_plausible() {
        let Facets { declared, .. } = facets;
        warnings.push(format!("{declared} facets are declared: the {} that are there are read", facets.there()));
        return Ok((binary(facets.bytes), 0));
    }
    let message = format!(
        "a binary STL with {} facets has {} bytes: this file has {}; an ascii one begins with `solid`",
        facets.declared,
        HEADER_BYTES as u64 + facets.declared * FACET_BYTES as u64,
        bytes.len()
    );
    Err(Fault::new(Place::Byte(80), message))
}

/// Body of a binary file.
#[derive(Clone, Copy)]
struct Facets<'a> {
    declared: u64,
    bytes: &'a [u8],
}

fn facets(bytes: &[u8]) -> Option<Facets<'_>> {
    let (header, bytes) = bytes.split_at_checked(HEADER_BYTES)?;
    let declared = u64::from(u32::from_le_bytes(*header.last_chunk()?));
    Some(Facets { declared, bytes })
}

impl Facets<'_> {
    /// Number of facets for which there are bytes.
    fn there(&self) -> u64 {
        (self.bytes.len() / FACET_BYTES) as u64
    }

    fn are_all_there(&self) -> bool {
        self.declared * FACET_BYTES as u64 == self.bytes.len() as u64
    }

    /// Whether there are facets, and all their coordinates are numbers of a size that coordinates have. Whatever is not an
    /// STL soon has others.
    fn are_plausible(&self) -> bool {
        let coordinates = self.bytes.chunks_exact(FACET_BYTES).flat_map(corners).flatten();
        let is_text = self.bytes.iter().all(|byte| *byte >= b'\t');
        self.there() > 0 && !is_text && coordinates.into_iter().all(|x| x.abs() <= LARGEST_PLAUSIBLE)
    }
}

/// Whether it is a text with the words of an STL. Some begin with a comment, and some lack `solid`.
fn is_ascii(text: &[u8]) -> bool {
    let probe = text[..text.len().min(ASCII_PROBE_BYTES)].to_ascii_lowercase();
    let has = |word: &[u8]| probe.windows(word.len()).any(|window| window == word);
    let is_empty_solid = || probe.trim_ascii_start().starts_with(b"solid") && has(b"endsolid");
    !probe.contains(&0) && (has(b"facet") && (has(b"solid") || has(b"vertex")) || is_empty_solid())
}

/// The whole facets of a body.
fn binary(bytes: &[u8]) -> Mesh {
    let facets = bytes.chunks_exact(FACET_BYTES);
    let mut welder = Welder::default();
    let mut triangles = Vec::with_capacity(facets.len());
    triangles.extend(facets.map(|facet| corners(facet).map(|corner| welder.vertex(corner))));
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..triangles.len() }];
    Mesh { positions: welder.positions, triangles, parts, ..Mesh::default() }
}

/// The corners of a facet of a binary file.
fn corners(facet: &[u8]) -> [[f32; 3]; 3] {
    let (numbers, _) = facet[12..48].as_chunks::<4>();
    [0, 3, 6].map(|first| [0, 1, 2].map(|axis| f32::from_le_bytes(numbers[first + axis])))
}

/// Reads solids for as long as there are some. What the words mean is plain whatever is missing around them: a file may
/// lack `endsolid`, and be cut off.
fn ascii(bytes: &[u8], warnings: &mut Warnings) -> Result<(Mesh, usize), Fault> {
    let mut solids = Solids::default();
    let mut words = Words::new(bytes, 0, 1);
    let mut normal_words = 0;
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => solids.begin(String::from_utf8_lossy(words.rest_of_line()).into()),
            b"endsolid" => {
                words.rest_of_line();
                solids.end();
            }
            b"facet" => {
                solids.facet();
                normal_words = MOST_NORMAL_WORDS;
            }
            b"outer" | b"loop" => normal_words = 0,
            // A vertex at which the file is cut off is none.
            b"vertex" => match [words.number(), words.number(), words.number()] {
                _ if words.bytes_left() == 0 => break,
                [x, y, z] => solids.vertex([x? as f32, y? as f32, z? as f32]),
            },
            b"endloop" | b"endfacet" => solids.facet(),
            [b'#' | b';' | b'!', ..] | [b'/', b'/', ..] => drop(words.rest_of_line()),
            _ if normal_words > 0 => normal_words -= 1,
            _ => {
                words.rest_of_line();
                let Place::Line(line) = words.place() else { continue };
                warnings.push(format!("line {line}: {} is not a word of STL: the line is passed over", quoted(word)));
            }
        }
    }
    if !solids.corners.is_empty() {
        solids.facet();
        warnings.push("the file ends within a facet, of which the corners that are there are read");
    }
    if solids.is_open {
        warnings.push("the file ends without `endsolid`");
    }
    solids.end();
    let Solids { mut mesh, welder, degenerate, .. } = solids;
    mesh.positions = welder.positions;
    Ok((mesh, degenerate))
}

/// The solids of an ascii file.
#[derive(Default)]
struct Solids {
    mesh: Mesh,
    welder: Welder,
    triangulator: Option<Triangulator>,
    /// Corners of the facet at hand.
    corners: Vec<u32>,
    degenerate: usize,
    name: Arc<str>,
    is_open: bool,
}

impl Solids {
    fn begin(&mut self, name: Arc<str>) {
        self.end();
        (self.name, self.is_open) = (name, true);
    }

    fn vertex(&mut self, position: [f32; 3]) {
        self.corners.push(self.welder.vertex(position));
    }

    /// Ends the facet at hand, which may have been ended before.
    fn facet(&mut self) {
        let Self { mesh, welder, corners, .. } = self;
        if corners.is_empty() {
            return;
        }
        self.degenerate += usize::from(corners.len() < 3);
        let triangulator = self.triangulator.get_or_insert_with(Triangulator::new);
        triangulator.add(corners, |i| welder.positions[corners[i] as usize], &mut mesh.triangles);
        corners.clear();
    }

    /// Ends the solid at hand, if there is one or facets are in none.
    fn end(&mut self) {
        self.facet();
        let start = self.mesh.parts.last().map_or(0, |part| part.triangles.end);
        let triangles = start..self.mesh.triangles.len();
        if self.is_open || !triangles.is_empty() {
            let name = std::mem::take(&mut self.name);
            self.mesh.parts.push(Part { name, material: None, triangles });
        }
        self.is_open = false;
    }
}

/// Numbers vertices; those with the same coordinates share a number.
#[derive(Default)]
struct Welder {
    positions: Vec<[f32; 3]>,
    numbers: HashMap<[u32; 3], u32>,
}

impl Welder {
    fn vertex(&mut self, position: [f32; 3]) -> u32 {
        // Adding zero makes -0 and 0 the same.
        let position = position.map(|x| x + 0.0);
        match self.numbers.entry(position.map(f32::to_bits)) {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                // Files have fewer vertices than fit: each takes twelve bytes, and `MOST_BYTES` of them are read.
                let number = self.positions.len() as u32;
                self.positions.push(position);
                *entry.insert(number)
            }
        }
    }
}
