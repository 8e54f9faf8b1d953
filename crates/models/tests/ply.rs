//! Colours of PLY's vertices and faces, and texts of any kind.

use raggio_models::{MeshFile, parse_ply};

fn ply(text: &str) -> MeshFile {
    parse_ply(text.as_bytes(), "a.ply").expect("a valid file")
}

/// Two triangles that share an edge, with the properties of the vertices and of the faces, and the rows of the faces.
fn two_triangles(vertex: &str, rest: &str, face: &str, rows: &str) -> String {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].map(|place| format!("{place}{rest}\n")).concat();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\n{xyz}{vertex}element face 2\n\
         property list uchar int vertex_indices\n{face}end_header\n{corners}{rows}"
    )
}

fn colors(kind: &str, names: [&str; 4]) -> String {
    names.iter().filter(|name| !name.is_empty()).map(|name| format!("property {kind} {name}\n")).collect()
}

const RGB: [&str; 4] = ["red", "green", "blue", ""];
const RGBA: [&str; 4] = ["red", "green", "blue", "alpha"];
const DIFFUSE: [&str; 4] = ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"];

/// Colours of the corners of a mesh, triangle by triangle.
fn corner_colors(file: &MeshFile) -> Vec<[[f32; 4]; 3]> {
    let colors = file.mesh.colors.as_ref().expect("colours");
    file.mesh.triangles.iter().map(|triangle| triangle.map(|corner| colors[corner as usize])).collect()
}

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const HALF_BLUE: [f32; 4] = [0.0, 0.0, 1.0, 0.2];

#[test]
fn colours_of_faces_split_vertices() {
    let rows = "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n";
    let file = ply(&two_triangles("", "", &colors("uchar", RGB), rows));
    assert_eq!(corner_colors(&file), [[RED; 3], [[0.0, 0.0, 1.0, 1.0]; 3]]);
    assert_eq!((file.mesh.positions.len(), file.warnings.len()), (6, 0));
    assert_eq!(file.mesh.positions[3..], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    // Faces of one colour share their vertices.
    let same = ply(&two_triangles("", "", &colors("uchar", RGB), "3 0 1 2 255 0 0\n3 0 2 3 255 0 0\n"));
    assert_eq!((same.mesh.positions.len(), corner_colors(&same)), (4, vec![[RED; 3]; 2]));
    for names in [RGBA, DIFFUSE] {
        let rows = "3 0 1 2 255 0 0 255\n3 0 2 3 0 0 255 51\n";
        let file = ply(&two_triangles("", "", &colors("uchar", names), rows));
        assert_eq!(corner_colors(&file), [[RED; 3], [HALF_BLUE; 3]]);
    }
    // Whole numbers are sRGB, others are linear, on faces as on vertices.
    let grey = |kind: &str, value: &str| {
        let rows = format!("3 0 1 2 {value} {value} {value}\n3 0 2 3 0 0 0\n");
        corner_colors(&ply(&two_triangles("", "", &colors(kind, RGB), &rows)))[0][0][0]
    };
    assert!((grey("uchar", "51") - 0.033_104_77).abs() < 1e-6);
    assert_eq!(grey("float", "0.25"), 0.25);
    assert!((grey("ushort", "13107") - 0.033_104_77).abs() < 1e-6);
}

#[test]
fn colours_and_coordinates_of_faces_go_together() {
    let face = format!("property list uchar float texcoord\n{}", colors("uchar", RGB));
    let rows = "3 0 1 2 6 0 0 1 0 1 1 255 0 0\n3 0 2 3 6 0 0 1 1 0 1 0 0 255\n";
    let file = ply(&two_triangles("", "", &face, rows));
    assert_eq!(file.mesh.positions.len(), 6);
    assert_eq!(file.mesh.uvs[0].as_ref().unwrap()[3..], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(corner_colors(&file)[0], [RED; 3]);
}

#[test]
fn colours_of_vertices_go_before_those_of_faces() {
    let rows = "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n";
    let file = ply(&two_triangles(&colors("uchar", DIFFUSE), " 0 255 0 255", &colors("uchar", RGB), rows));
    assert_eq!(corner_colors(&file), [[[0.0, 1.0, 0.0, 1.0]; 3]; 2]);
    assert_eq!(file.mesh.positions.len(), 4);
    assert_eq!(file.warnings, ["the colours of the faces are not used: those of the vertices are"]);
    // Two parts of a colour are none.
    let partial =
        ply(&two_triangles("", "", "property uchar red\nproperty uchar blue\n", "3 0 1 2 1 2\n3 0 2 3 1 2\n"));
    assert_eq!(partial.mesh.colors, None);
}

/// Strips after faces with colours are white.
#[test]
fn strips_beside_coloured_faces() {
    let text = two_triangles("", "", &colors("uchar", RGB), "3 0 1 2 255 0 0\n3 0 2 3 255 0 0\n");
    let text = text.replace("end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header");
    let file = ply(&format!("{text}3 0 1 2\n"));
    assert_eq!(corner_colors(&file)[1..], [[RED; 3], [[1.0; 4]; 3]]);
}

#[test]
fn texts_with_marks_and_any_ending_of_lines() {
    let text = two_triangles("", "", &colors("uchar", RGB), "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n");
    let expected = ply(&text);
    let utf16 =
        |text: &str| -> Vec<u8> { format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let variants = [
        text.replace('\n', "\r").into_bytes(),
        format!("\u{feff}{text}").into_bytes(),
        utf16(&text),
        utf16(&text.replace('\n', "\r\n")),
    ];
    for bytes in variants {
        assert_eq!(parse_ply(&bytes, "").unwrap(), expected);
    }
    for ending in ["\n", "\r", "\r\n"] {
        let error = parse_ply(text.replace("3 0 2 3", "3 0 x 3").replace('\n', ending).as_bytes(), "a").unwrap_err();
        assert_eq!(error.to_string(), "a:18: `x` should be a number");
    }
}
