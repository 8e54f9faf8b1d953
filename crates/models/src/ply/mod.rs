//! PLY: ascii and binary, with any types and any unknown elements and properties.

mod body;
mod corners;
mod header;

use crate::color::make_linear;
use crate::error::{Fault, ModelError};
use crate::mesh::{Mesh, MeshFile, Part};
use crate::obj::lookup::unquoted;
use crate::obj::mtl::{MtlMap, MtlMaterial};
use crate::polygon::Triangulator;
use crate::text::{quoted, unmarked};
use body::Body;
use header::{Element, Header, Property};

/// Number of slots of a vertex row: position, normal, two sets of texture coordinates, colour.
const SLOTS: usize = 14;
const NORMAL: usize = 3;
const UV: [usize; 2] = [6, 8];
const COLOR: usize = 10;
const ALPHA: usize = 13;

/// Reads a PLY file; `name` stands for the file in messages. Colours that are whole numbers are taken for sRGB, as programs
/// write them, and made linear; those that are floating-point numbers are taken for linear. The colours of vertices count
/// where faces have colours, too, as in MeshLab and Blender.
///
/// # Errors
/// When the bytes are not a valid PLY file, or it has no vertices.
pub fn parse_ply(bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
    read(&unmarked(bytes)).map_err(|fault| fault.of(name))
}

/// Polygons of any number of corners, one behind the other.
#[derive(Default)]
struct Polygons {
    corners: Vec<u32>,
    /// End of each polygon in `corners`.
    ends: Vec<usize>,
    /// Texture coordinates of corners, if faces have some: as long as `corners` then.
    uvs: Option<Vec<[f32; 2]>>,
    /// Colours of polygons, if faces have some: as long as `ends` then.
    colors: Option<Vec<[f32; 4]>>,
}

fn read(bytes: &[u8]) -> Result<MeshFile, Fault> {
    let header = header::read(bytes)?;
    let mut body = Body::new(bytes, &header);
    let (mut mesh, mut polygons, mut warnings) = (None, Polygons::default(), Vec::new());
    for element in &header.elements {
        let rows = body.rows(element)?;
        match element.name {
            b"vertex" => mesh = Some(vertices(&mut body, element, rows)?),
            b"face" => faces(&mut body, element, rows, &mut polygons)?,
            b"tristrips" => strips(&mut body, element, rows, &mut polygons)?,
            _ => body.skip(element, rows)?,
        }
    }
    let mut mesh = mesh.ok_or_else(|| Fault::whole("has no element `vertex`: a mesh has one"))?;
    check_indices(&polygons, mesh.positions.len())?;
    if mesh.colors.is_some() && polygons.colors.take().is_some() {
        warnings.push("the colours of the faces are not used: those of the vertices are".to_string());
    }
    corners::split(&mut polygons, &mut mesh)?;
    let degenerate = triangulate(&polygons, &mut mesh);
    drop(polygons);
    let materials = material(&header, &mut mesh, &mut warnings);
    Ok(MeshFile { materials, ..MeshFile::cleaned(mesh, warnings, degenerate)? })
}

/// The texture that a comment names becomes a material of the whole mesh, if there are coordinates for it.
fn material(header: &Header<'_>, mesh: &mut Mesh, warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let Some(texture) = header.textures.first().filter(|_| mesh.uvs[0].is_some()) else { return Vec::new() };
    if header.textures.len() > 1 {
        warnings.push(format!("of {} textures only the first is used", header.textures.len()));
    }
    mesh.parts.iter_mut().for_each(|part| part.material = Some(0));
    let diffuse_map = Some(MtlMap::named(String::from_utf8_lossy(unquoted(texture)).into_owned()));
    vec![MtlMaterial { diffuse_map, ..MtlMaterial::default() }]
}

/// Slot of a vertex row into which a property goes.
fn slot(name: &[u8]) -> Option<usize> {
    Some(match name {
        b"x" => 0,
        b"y" => 1,
        b"z" => 2,
        b"nx" | b"normal_x" => 3,
        b"ny" | b"normal_y" => 4,
        b"nz" | b"normal_z" => 5,
        b"s" | b"u" | b"s0" | b"u0" | b"texture_u" | b"texture_s" | b"texcoord_u" => 6,
        b"t" | b"v" | b"t0" | b"v0" | b"texture_v" | b"texture_t" | b"texcoord_v" => 7,
        b"s1" | b"u1" | b"texture_u1" | b"texture_s1" => 8,
        b"t1" | b"v1" | b"texture_v1" | b"texture_t1" => 9,
        b"red" | b"r" | b"diffuse_red" => 10,
        b"green" | b"g" | b"diffuse_green" => 11,
        b"blue" | b"b" | b"diffuse_blue" => 12,
        b"alpha" | b"a" | b"diffuse_alpha" => ALPHA,
        _ => return None,
    })
}

fn vertices(body: &mut Body<'_>, element: &Element<'_>, rows: usize) -> Result<Mesh, Fault> {
    let slots: Vec<_> = element.properties.iter().map(|p| slot(p.name).filter(|_| p.length.is_none())).collect();
    let has = |first: usize, count: usize| (first..first + count).all(|slot| slots.contains(&Some(slot)));
    if !has(0, 3) {
        return Err(Fault::line(element.line, "the vertices should have the properties `x`, `y` and `z`"));
    }
    if u32::try_from(rows).is_err() {
        return Err(Fault::line(element.line, format!("a mesh has at most {} vertices", u32::MAX)));
    }
    let mut mesh = Mesh {
        positions: Vec::with_capacity(rows),
        normals: has(NORMAL, 3).then(|| Vec::with_capacity(rows)),
        uvs: UV.map(|first| has(first, 2).then(|| Vec::with_capacity(rows))),
        colors: has(COLOR, 3).then(|| Vec::with_capacity(rows)),
        ..Mesh::default()
    };
    for _ in 0..rows {
        let mut row = [0.0f32; SLOTS];
        row[ALPHA] = 1.0;
        for (property, slot) in element.properties.iter().zip(&slots) {
            match *slot {
                Some(slot) if slot >= COLOR => row[slot] = body.strength(property.value)?,
                Some(slot) => row[slot] = body.number(property.value)? as f32,
                None => body.skip_property(property)?,
            }
        }
        let three = |first: usize| [row[first], row[first + 1], row[first + 2]];
        mesh.positions.push(three(0));
        mesh.normals.iter_mut().for_each(|normals| normals.push(three(NORMAL)));
        for (uvs, first) in mesh.uvs.iter_mut().zip(UV) {
            uvs.iter_mut().for_each(|uvs| uvs.push([row[first], row[first + 1]]));
        }
        let color = [row[COLOR], row[COLOR + 1], row[COLOR + 2], row[ALPHA]];
        mesh.colors.iter_mut().for_each(|colors| colors.push(color));
    }
    if has_encoded_colors(element) {
        mesh.colors.iter_mut().for_each(|colors| make_linear(colors));
    }
    Ok(mesh)
}

/// Whether the colours of an element are whole numbers.
fn has_encoded_colors(element: &Element<'_>) -> bool {
    let red = element.properties.iter().find(|property| color_slot(property) == Some(COLOR));
    red.is_some_and(|property| property.value.is_integer())
}

/// Slot of a property that is part of a colour.
fn color_slot(property: &Property<'_>) -> Option<usize> {
    slot(property.name).filter(|slot| *slot >= COLOR && property.length.is_none())
}

/// Whether the property of a face or a strip is the list of its vertices.
fn corner_list(property: &Property<'_>) -> bool {
    property.length.is_some() && matches!(property.name, b"vertex_indices" | b"vertex_index")
}

fn check_corner_list(element: &Element<'_>) -> Result<(), Fault> {
    let mut lists = element.properties.iter().filter(|property| corner_list(property));
    match (lists.next(), lists.next()) {
        (Some(list), None) if list.value.is_integer() => Ok(()),
        _ => {
            let name = quoted(element.name);
            let message = format!("{name} should have one list `vertex_indices` of an integer type");
            Err(Fault::line(element.line, message))
        }
    }
}

fn faces(body: &mut Body<'_>, element: &Element<'_>, rows: usize, polygons: &mut Polygons) -> Result<(), Fault> {
    check_corner_list(element)?;
    let is_uv = |property: &Property<'_>| property.length.is_some() && property.name == b"texcoord";
    let has_uvs = element.properties.iter().any(is_uv);
    let has = |slot: usize| element.properties.iter().any(|property| color_slot(property) == Some(slot));
    let has_colors = (COLOR..ALPHA).all(has);
    // The lists are made as long as that of the corners and of the polygons, whatever the file has.
    let fill = |polygons: &mut Polygons| {
        if has_uvs {
            polygons.uvs.get_or_insert_default().resize(polygons.corners.len(), [0.0; 2]);
        }
        if has_colors {
            polygons.colors.get_or_insert_default().resize(polygons.ends.len(), [1.0; 4]);
        }
    };
    fill(polygons);
    for _ in 0..rows {
        let mut color = [1.0; 4];
        for property in &element.properties {
            if let Some(slot) = color_slot(property) {
                color[slot - COLOR] = body.strength(property.value)?;
                continue;
            }
            let Some(length) = property.length.filter(|_| corner_list(property) || is_uv(property)) else {
                body.skip_property(property)?;
                continue;
            };
            let count = body.list_length(length, property.value)?;
            if is_uv(property) {
                face_uvs(body, property, count, polygons.uvs.get_or_insert_default())?;
                continue;
            }
            for _ in 0..count {
                let corner = body.index(property.value)?;
                polygons.corners.push(corner);
            }
            polygons.ends.push(polygons.corners.len());
        }
        polygons.colors.iter_mut().for_each(|colors| colors.push(color));
        fill(polygons);
    }
    if has_encoded_colors(element) {
        polygons.colors.iter_mut().for_each(|colors| make_linear(colors));
    }
    Ok(())
}

fn face_uvs(body: &mut Body<'_>, property: &Property<'_>, count: usize, uvs: &mut Vec<[f32; 2]>) -> Result<(), Fault> {
    for _ in 0..count / 2 {
        let uv = [body.number(property.value)? as f32, body.number(property.value)? as f32];
        uvs.push(uv);
    }
    (0..count % 2).try_for_each(|_| body.number(property.value).map(drop))
}

/// Reads strips of triangles; a negative index begins a new one.
fn strips(body: &mut Body<'_>, element: &Element<'_>, rows: usize, polygons: &mut Polygons) -> Result<(), Fault> {
    check_corner_list(element)?;
    for _ in 0..rows {
        for property in &element.properties {
            let Some(length) = property.length.filter(|_| corner_list(property)) else {
                body.skip_property(property)?;
                continue;
            };
            let mut last = [None; 2];
            let mut flipped = false;
            for _ in 0..body.list_length(length, property.value)? {
                let Some(corner) = body.index_or_restart(property.value)? else {
                    (last, flipped) = ([None; 2], false);
                    continue;
                };
                if let [Some(a), Some(b)] = last {
                    polygons.corners.extend(if flipped { [b, a, corner] } else { [a, b, corner] });
                    polygons.ends.push(polygons.corners.len());
                    flipped = !flipped;
                }
                last = [last[1], Some(corner)];
            }
        }
    }
    Ok(())
}

fn check_indices(polygons: &Polygons, vertices: usize) -> Result<(), Fault> {
    let Some(corner) = polygons.corners.iter().position(|index| *index as usize >= vertices) else { return Ok(()) };
    let face = polygons.ends.partition_point(|end| *end <= corner);
    let index = polygons.corners[corner];
    Err(Fault::whole(format!(
        "face {face} (counted from 0) names vertex {index}: with {vertices} vertices the index has to be below {vertices}"
    )))
}

/// Cuts the polygons into triangles. Returns how many polygons have fewer than three corners.
fn triangulate(polygons: &Polygons, mesh: &mut Mesh) -> usize {
    let mut triangulator = Triangulator::new();
    let (mut start, mut too_few) = (0, 0);
    mesh.triangles.reserve_exact(polygons.corners.len().saturating_sub(2 * polygons.ends.len()));
    for end in &polygons.ends {
        let corners = &polygons.corners[start..*end];
        start = *end;
        too_few += usize::from(corners.len() < 3);
        triangulator.add(corners, |i| mesh.positions[corners[i] as usize], &mut mesh.triangles);
    }
    mesh.parts = vec![Part { name: "".into(), material: None, triangles: 0..mesh.triangles.len() }];
    too_few
}
