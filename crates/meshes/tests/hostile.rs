//! Whatever the bytes: no panic, and what is read fits together and is not much larger than the file.

use proptest::collection::vec;
use proptest::prelude::*;
use raggio_meshes::{Format, Model, parse, parse_mtl};

const FORMATS: [Format; 3] = [Format::Ply, Format::Stl, Format::Obj];

fn seeds() -> Vec<Vec<u8>> {
    let vertex = "property float x\nproperty float y\nproperty float z\n";
    let ascii = format!(
        "ply\nformat ascii 1.0\nelement vertex 5\n{vertex}property uchar red\nproperty uchar green\n\
         property uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n\
         2 0 0 1 2 3\n1 1 0 1 2 3\n0 2 0 1 2 3\nnan 1 1 9 9 9\n4 0 1 2 3\n3 1 2 4\n"
    );
    let mut seeds = vec![ascii.into_bytes()];
    for kind in ["little", "big"] {
        let header = format!(
            "ply\nformat binary_{kind}_endian 1.0\nelement vertex 3\n{vertex}element odd 1\n\
             property list int double d\nelement face 1\nproperty list uchar uchar vertex_indices\nelement tristrips 1\n\
             property list uchar char vertex_indices\nend_header\n"
        );
        let one = if kind == "big" { 1f32.to_be_bytes() } else { 1f32.to_le_bytes() };
        let zero = [0; 4];
        let body = [zero, zero, zero, one, zero, zero, zero, one, zero, zero].concat();
        seeds.push([header.as_bytes(), &body, &[3, 0, 1, 2, 4, 0, 1, 2, 0xff]].concat());
    }
    let mut stl = vec![b'x'; 80];
    stl.extend(2u32.to_le_bytes());
    stl.extend((0..100u8).map(|i| i.wrapping_mul(37)));
    seeds.push(stl);
    seeds.push(
        b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
          endsolid a\n"
            .to_vec(),
    );
    seeds.push(
        b"mtllib a.mtl\nv 0 0 0\nv 2 0 0 1 1 1\nv 1 1 0\nv 0 2 0\nvt 0 0\nvn 0 0 1\ng a\nusemtl m\nf 1/1/1 2//1 3 -1\\\n\
          \nusemtl n\nf 1 2 3\n"
            .to_vec(),
    );
    seeds.push(b"newmtl a\nKd 1 1 1\nTr 0.5\nd -halo 1\nmap_Kd -s 1 1 -bm 2 a b.png\nKs spectral a\n".to_vec());
    seeds
}

fn check(model: &Model, bytes: usize) {
    let mesh = &model.mesh;
    let vertices = mesh.positions.len();
    assert!(mesh.triangles.as_flattened().iter().all(|index| (*index as usize) < vertices));
    assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert!(mesh.normals.as_ref().is_none_or(|list| list.len() == vertices));
    assert!(mesh.colors.as_ref().is_none_or(|list| list.len() == vertices));
    assert!(mesh.uvs.iter().flatten().all(|list| list.len() == vertices));
    assert_eq!(mesh.parts.iter().map(|part| part.triangles.len()).sum::<usize>(), mesh.triangles.len());
    assert!(mesh.positions.capacity() <= 2 * bytes + 64 && mesh.triangles.capacity() <= 2 * bytes + 64);
}

fn read_all(bytes: &[u8]) {
    for format in FORMATS {
        match parse(format, bytes, "a") {
            Ok(model) => check(&model, bytes.len()),
            Err(error) => assert!(!error.to_string().chars().any(char::is_control), "{error:?}"),
        }
    }
    let _ = parse_mtl(bytes, "a");
}

#[test]
fn truncated_at_every_length() {
    for seed in seeds() {
        (0..=seed.len()).for_each(|length| read_all(&seed[..length]));
    }
}

#[test]
fn seeds_are_valid() {
    let formats = [Format::Ply, Format::Ply, Format::Ply, Format::Stl, Format::Stl, Format::Obj];
    for (seed, format) in seeds().iter().zip(formats) {
        parse(format, seed, "a").unwrap();
    }
}

#[test]
fn huge_counts_are_refused_before_memory_is_reserved() {
    for (from, to) in
        [("vertex 5", "vertex 18446744073709551615"), ("face 2", "face 9223372036854775807"), ("\n4 0", "\n4e18 0")]
    {
        let text = String::from_utf8(seeds().swap_remove(0)).unwrap().replace(from, to);
        let error = parse(Format::Ply, text.as_bytes(), "a").unwrap_err();
        assert!(error.message.contains("at most"), "{error}");
    }
}

#[test]
fn elements_without_properties_take_no_time() {
    let text = "ply\nformat ascii 1.0\nelement a 18446744073709551615\nelement vertex 0\nproperty float x\n\
                property float y\nproperty float z\nend_header\n";
    assert_eq!(parse(Format::Ply, text.as_bytes(), "a").unwrap().warnings.len(), 1);
}

/// Cutting ears off one polygon of so many corners would take hours without a budget.
#[test]
fn enormous_concave_polygons_end() {
    let count = 200_000;
    let mut text = String::new();
    for i in 0..count {
        text += &format!("v {} {} 0\n", i % 1000, (i * 7919) % 1009);
    }
    text += "f";
    (1..=count).for_each(|i| text += &format!(" {i}"));
    let model = parse(Format::Obj, text.as_bytes(), "a").unwrap();
    check(&model, text.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn mutated(
        seed in 0..7usize,
        changes in vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..8),
    ) {
        let mut bytes = seeds().swap_remove(seed);
        for (index, byte, kind) in changes {
            if bytes.is_empty() {
                break;
            }
            let at = index.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] = b"0123456789-/ \nnife.\xff"[byte as usize % 20],
                2 => bytes.insert(at, byte),
                _ => drop(bytes.remove(at)),
            }
        }
        read_all(&bytes);
    }

    #[test]
    fn arbitrary(bytes in vec(any::<u8>(), 0..300)) {
        read_all(&bytes);
    }
}
