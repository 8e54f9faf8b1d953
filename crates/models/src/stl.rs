//! STL, binary and ascii. The normals of the file are not read: the corners' order says which way a facet faces, and
//! writers often leave the normals zero.

use std::collections::hash_map::Entry;
use std::sync::Arc;

use foldhash::HashMap;

use crate::error::{Fault, ModelError, Place};
use crate::mesh::{Mesh, MeshFile, Part};
use crate::polygon::Triangulator;
use crate::text::{Words, quoted};

const HEADER_BYTES: usize = 84;
const FACET_BYTES: usize = 50;
/// Bytes within which an ascii file has its first facet.
const ASCII_PROBE_BYTES: usize = 4096;

/// Reads an STL file; `name` stands for the file in messages. Vertices at the same place become one.
///
/// # Errors
/// When the bytes are not a valid STL file.
pub fn parse_stl(bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
    let mut warnings = Vec::new();
    let (mesh, degenerate) = read(bytes, &mut warnings).map_err(|fault| fault.of(name))?;
    MeshFile::cleaned(mesh, warnings, degenerate).map_err(|fault| fault.of(name))
}

/// Reads a binary or ascii file. A length that fits the declared count decides for binary, because binary headers may
/// begin with "solid", too. No ascii file can fit: four characters of text in the place of the count declare more than
/// 25 GB.
fn read(bytes: &[u8], warnings: &mut Vec<String>) -> Result<(Mesh, usize), Fault> {
    let declared = binary_length(bytes);
    if declared == Some(bytes.len() as u64) {
        return Ok((binary(bytes), 0));
    }
    if is_ascii(bytes) {
        return ascii(bytes);
    }
    match declared {
        Some(declared) if declared < bytes.len() as u64 => {
            let extra = bytes.len() as u64 - declared;
            warnings.push(format!("{extra} bytes after the last facet are not read"));
            Ok((binary(bytes), 0))
        }
        Some(declared) => {
            let count = (declared - HEADER_BYTES as u64) / FACET_BYTES as u64;
            let message = format!(
                "a binary STL with {count} facets has {declared} bytes: this file has {}; an ascii one begins with \
                 `solid`",
                bytes.len()
            );
            Err(Fault::new(Place::Byte(80), message))
        }
        None => Err(Fault::whole("is not an STL: an ascii one begins with `solid`, a binary one has 84 bytes or more")),
    }
}

/// Length in bytes of a binary file with this header.
fn binary_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER_BYTES)?.first_chunk()?;
    Some(HEADER_BYTES as u64 + FACET_BYTES as u64 * u64::from(u32::from_le_bytes(*count)))
}

fn is_ascii(bytes: &[u8]) -> bool {
    let probe = bytes[..bytes.len().min(ASCII_PROBE_BYTES)].trim_ascii_start().to_ascii_lowercase();
    let has = |word: &[u8]| probe.windows(word.len()).any(|window| window == word);
    probe.starts_with(b"solid") && !probe.contains(&0) && (has(b"facet") || has(b"endsolid"))
}

/// All facets that the header declares, which the caller has found to be there.
fn binary(bytes: &[u8]) -> Mesh {
    let count = binary_length(bytes).unwrap_or(0).saturating_sub(HEADER_BYTES as u64) / FACET_BYTES as u64;
    let facets = bytes[HEADER_BYTES..].chunks_exact(FACET_BYTES).take(usize::try_from(count).unwrap_or(usize::MAX));
    let mut welder = Welder::default();
    let mut triangles = Vec::with_capacity(facets.len());
    for facet in facets {
        let (numbers, _) = facet[12..48].as_chunks::<4>();
        let corner = |first: usize| [0, 1, 2].map(|axis| f32::from_le_bytes(numbers[first + axis]));
        triangles.push([0, 3, 6].map(|first| welder.vertex(corner(first))));
    }
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..triangles.len() }];
    Mesh { positions: welder.positions, triangles, parts, ..Mesh::default() }
}

fn ascii(bytes: &[u8]) -> Result<(Mesh, usize), Fault> {
    let mut words = Words::new(bytes, 0, 1);
    let (mut welder, mut triangulator) = (Welder::default(), Triangulator::new());
    let mut mesh = Mesh::default();
    let (mut corners, mut degenerate) = (Vec::new(), 0);
    while let Some(word) = words.next() {
        expect(&words, Some(word), "solid")?;
        let name: Arc<str> = String::from_utf8_lossy(words.rest_of_line()).into();
        let start = mesh.triangles.len();
        while is_facet(&mut words)? {
            facet(&mut words, &mut welder, &mut corners)?;
            degenerate += usize::from(corners.len() < 3);
            triangulator.add(&corners, |i| welder.positions[corners[i] as usize], &mut mesh.triangles);
        }
        words.rest_of_line();
        mesh.parts.push(Part { name, material: None, triangles: start..mesh.triangles.len() });
    }
    mesh.positions = welder.positions;
    Ok((mesh, degenerate))
}

/// Whether a facet follows, or the end of the solid.
fn is_facet(words: &mut Words<'_>) -> Result<bool, Fault> {
    match words.next() {
        Some(word) if word.eq_ignore_ascii_case(b"facet") => Ok(true),
        Some(word) if word.eq_ignore_ascii_case(b"endsolid") => Ok(false),
        Some(word) => Err(words.fault(format!("{} should be `facet` or `endsolid`", quoted(word)))),
        None => Err(words.fault("the file ends where `facet` or `endsolid` should be")),
    }
}

fn facet(words: &mut Words<'_>, welder: &mut Welder, corners: &mut Vec<u32>) -> Result<(), Fault> {
    // The words after `facet` are its normal, in whatever form.
    words.rest_of_line();
    for expected in ["outer", "loop"] {
        let word = words.next();
        expect(words, word, expected)?;
    }
    corners.clear();
    loop {
        let word = words.next();
        if word.is_some_and(|word| word.eq_ignore_ascii_case(b"endloop")) {
            break;
        }
        expect(words, word, "vertex")?;
        corners.push(welder.vertex([words.number()?, words.number()?, words.number()?].map(|x| x as f32)));
    }
    let word = words.next();
    expect(words, word, "endfacet")
}

fn expect(words: &Words<'_>, word: Option<&[u8]>, expected: &str) -> Result<(), Fault> {
    match word {
        Some(word) if word.eq_ignore_ascii_case(expected.as_bytes()) => Ok(()),
        Some(word) => Err(words.fault(format!("{} should be `{expected}`", quoted(word)))),
        None => Err(words.fault(format!("the file ends where `{expected}` should be"))),
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
