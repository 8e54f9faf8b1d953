//! Files that the tests write come back bit for bit.

use proptest::collection::vec;
use proptest::prelude::*;
use raggio_models::{Mesh, parse_obj, parse_ply, parse_stl};

type Triangles = Vec<[[f32; 3]; 3]>;

/// Triangles, each a corner and two steps along different axes, because those without area are dropped.
fn triangles() -> impl Strategy<Value = Triangles> {
    let triangle = (prop::array::uniform3(-1e6f32..1e6), 1f32..10.0, 1f32..10.0);
    vec(triangle.prop_map(|([x, y, z], u, v)| [[x, y, z], [x + u, y, z], [x, y + v, z]]), 1..20)
}

fn corners(mesh: &Mesh) -> Triangles {
    mesh.triangles.iter().map(|triangle| triangle.map(|index| mesh.positions[index as usize])).collect()
}

fn ply_header(format: &str, triangles: &Triangles) -> String {
    let (count, faces) = (3 * triangles.len(), triangles.len());
    format!(
        "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_binary(triangles: &Triangles, big: bool) -> Vec<u8> {
    let mut bytes = ply_header(if big { "binary_big_endian" } else { "binary_little_endian" }, triangles).into_bytes();
    let mut word = |prefix: &[u8], bits: u32| {
        bytes.extend(prefix);
        bytes.extend(if big { bits.to_be_bytes() } else { bits.to_le_bytes() });
    };
    triangles.as_flattened().as_flattened().iter().for_each(|x| word(&[], x.to_bits()));
    (0..3 * triangles.len() as u32).for_each(|i| word(if i % 3 == 0 { &[3] } else { &[] }, i));
    bytes
}

proptest! {
    #[test]
    fn ply(triangles in triangles()) {
        for big in [false, true] {
            let model = parse_ply(&ply_binary(&triangles, big), "a").unwrap();
            prop_assert_eq!(&corners(&model.mesh), &triangles);
        }
        let mut text = ply_header("ascii", &triangles);
        triangles.as_flattened().iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z}\n"));
        (0..triangles.len()).for_each(|i| text += &format!("3 {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2));
        prop_assert_eq!(&corners(&parse_ply(text.as_bytes(), "a").unwrap().mesh), &triangles);
    }

    #[test]
    fn stl(triangles in triangles()) {
        let mut bytes = vec![b's'; 80];
        bytes.extend((triangles.len() as u32).to_le_bytes());
        let mut text = "solid\n".to_string();
        for triangle in &triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
            let lines = triangle.map(|[x, y, z]| format!("vertex {x:e} {y:e} {z:e}\n")).concat();
            text += &format!("facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n");
        }
        text += "endsolid\n";
        prop_assert_eq!(&corners(&parse_stl(&bytes, "a").unwrap().mesh), &triangles);
        prop_assert_eq!(&corners(&parse_stl(text.as_bytes(), "a").unwrap().mesh), &triangles);
    }

    #[test]
    fn obj(triangles in triangles()) {
        let mut text = String::new();
        for triangle in &triangles {
            triangle.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
            text += "f -3 -2 -1\n";
        }
        prop_assert_eq!(&corners(&parse_obj(text.as_bytes(), "a").unwrap().mesh), &triangles);
    }
}
