//! Variants of each format give the mesh that they describe.

use raggio_models::{
    LoadOptions, MeshFile, MtlMap, Place, load, parse_mtl, parse_obj, parse_ply, parse_stl, path_inside,
};
use std::path::Path;

fn ply(text: &str) -> MeshFile {
    parse_ply(text.as_bytes(), "a.ply").expect("a valid file")
}

fn area(model: &MeshFile) -> f32 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| model.mesh.positions[i as usize]);
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
    };
    model.mesh.triangles.iter().map(area).sum()
}

const SQUARE: &str = "ply\nformat ascii 1.0\ncomment hello\nelement vertex 4\nproperty float x\nproperty double y\n\
    property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty list uchar int extra\nelement odd 2\n\
    property list uchar float what\nproperty int n\nelement face 1\nproperty uchar flag\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0 255 0 0 0\n1 0 0 0 0 1 1 0 0 255 0 1 7\n\
    1 1 0 0 0 1 1 1 0 0 255 0\n0 1 0 0 0 1 0 1 51 51 51 2 1 2\n1 2.5 3\n0 4\n9 4 0 1 2 3\n";

#[test]
fn ascii_ply_with_everything() {
    let model = ply(SQUARE);
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(model.mesh.positions[2], [1.0, 1.0, 0.0]);
    assert_eq!(model.mesh.normals.as_ref().unwrap()[3], [0.0, 0.0, 1.0]);
    assert_eq!(model.mesh.uvs[0].as_ref().unwrap()[3], [0.0, 1.0]);
    // The value 51 of 255 is 0.2, and that is 0.0331 in sRGB's curve; floating-point numbers are linear.
    let colors = |model: &MeshFile| model.mesh.colors.clone().unwrap();
    assert_eq!(colors(&model)[..2], [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
    assert!(colors(&model)[3][..3].iter().all(|x| (x - 0.033_104_77).abs() < 1e-6) && colors(&model)[3][3] == 1.0);
    assert_eq!(
        colors(&ply(&SQUARE
            .replace("uchar red", "float red")
            .replace("uchar green", "float green")
            .replace("uchar blue", "float blue")))[3],
        [51.0, 51.0, 51.0, 1.0]
    );
    assert_eq!(model.mesh.parts[0].triangles, 0..2);
    assert_eq!(ply(&SQUARE.replace('\n', "\r\n")), model);
    assert_eq!(ply(&SQUARE.replace('\n', "\r")), model);
}

/// A concave quadrilateral (an arrow head of area one half) in any encoding.
fn arrow(big: bool, ending: &str) -> Vec<u8> {
    let kind = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{kind}_endian 1.0\nelement skipped 2\nproperty double d\nelement vertex 4\n\
         property float x\nproperty double y\nproperty short z\nelement face 1\n\
         property list ushort uint vertex_index\nend_header\n"
    )
    .replace('\n', ending)
    .into_bytes();
    let mut put = |mut number: Vec<u8>| {
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    // The first byte of the body is a line feed, which the header must not swallow.
    put(if big { [0u8, 0, 0, 0, 0, 0, 0, 10] } else { [10u8, 0, 0, 0, 0, 0, 0, 0] }.to_vec());
    put(1.0f64.to_le_bytes().to_vec());
    for (x, y) in [(0.0f32, 0.0f64), (1.0, 1.0), (0.0, 2.0), (0.5, 1.0)] {
        put(x.to_le_bytes().to_vec());
        put(y.to_le_bytes().to_vec());
        put(0i16.to_le_bytes().to_vec());
    }
    put(4u16.to_le_bytes().to_vec());
    for index in 0..4u32 {
        put(index.to_le_bytes().to_vec());
    }
    bytes
}

#[test]
fn binary_ply_in_both_byte_orders() {
    for big in [false, true] {
        for ending in ["\n", "\r", "\r\n"] {
            let model = parse_ply(&arrow(big, ending), "a.ply").unwrap();
            assert_eq!(model.mesh.positions[1], [1.0, 1.0, 0.0]);
            assert_eq!(model.mesh.triangles.len(), 2);
            assert!((area(&model) - 0.5).abs() < 1e-6);
        }
    }
}

/// Two triangles share an edge, one of whose vertices has equal texture coordinates in both, as MeshLab writes it.
#[test]
fn ply_texture_coordinates_per_face() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile my file.png\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n\
        property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nend_header\n\
        0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 0 255 0\n0 1 0 255 0 0\n3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0 0 0.5 1 0 1 0\n";
    let model = ply(text);
    let mesh = &model.mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 3, 4]]);
    assert_eq!((mesh.positions[2], mesh.positions[3]), ([1.0, 1.0, 0.0], [1.0, 1.0, 0.0]));
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[1..], [[1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]]);
    assert_eq!(mesh.colors.as_ref().unwrap()[3], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(model.materials[0].diffuse_map.as_ref().unwrap().file, "my file.png");
    assert_eq!(mesh.parts[0].material, Some(0));
    // Coordinates that are missing are zero, whatever else the row has.
    let short = ply(&text.replace("6 0 0 0.5 1 0 1 0", "3 9 9 9 0"));
    assert_eq!(short.mesh.uvs[0].as_ref().unwrap()[3..], [[9.0, 9.0], [0.0, 0.0], [0.0, 0.0]]);
}

#[test]
fn ply_strips() {
    let model = ply("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 1 1 0\n\
        8 0 1 2 3 -1 1 3 2");
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [2, 1, 3], [1, 3, 2]]);
}

#[test]
fn concave_polygons_keep_their_area() {
    // A comb with three teeth, seen from both sides.
    let comb =
        "v 0 0 5\nv 6 0 5\nv 6 3 5\nv 5 3 5\nv 5 1 5\nv 4 1 5\nv 4 3 5\nv 3 3 5\nv 3 1 5\nv 2 1 5\nv 2 3 5\nv 0 3 5\n";
    let model = parse_obj(format!("{comb}f 1 2 3 4 5 6 7 8 9 10 11 12").as_bytes(), "").unwrap();
    let every = |m: &MeshFile| m.mesh.triangles.len();
    assert_eq!((every(&model), area(&model)), (10, 14.0));
    let back = parse_obj(format!("{comb}f 12 11 10 9 8 7 6 5 4 3 2 1").as_bytes(), "").unwrap();
    assert_eq!((every(&back), area(&back)), (10, -14.0));
}

fn binary_stl(header: &[u8], facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        bytes.extend(facet.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const FACETS: [[[f32; 3]; 3]; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[1.0, 0.0, -0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]];

#[test]
fn stl_binary_and_ascii_are_the_same_mesh() {
    let bytes = binary_stl(b"solid facet", &FACETS);
    let binary = parse_stl(&bytes, "a.stl").unwrap();
    assert_eq!(binary.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
    let mut text = "solid two words\n".to_string();
    for facet in FACETS {
        let corners = facet.map(|[x, y, z]| format!("VERTEX {x} {y:e} {z}\n")).concat();
        text += &format!("facet normal -nan(ind) 0 1\r\nouter loop\n{corners}endloop\nendfacet\n");
    }
    text += "endsolid two words\n";
    let ascii = parse_stl(text.as_bytes(), "a.stl").unwrap();
    assert_eq!((&ascii.mesh.positions, &ascii.mesh.triangles), (&binary.mesh.positions, &binary.mesh.triangles));
    assert_eq!(&*ascii.mesh.parts[0].name, "two words");
    let longer = [bytes.as_slice(), b"\0\0"].concat();
    assert_eq!(parse_stl(&longer, "").unwrap().warnings.len(), 1);
}

#[test]
fn obj_with_groups_and_materials() {
    let text = "mtllib my file.mtl b.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 # corner\nv 0 1 0\nvt 0 0\nvt 1 1 0\nvn 0 0 1\n\
        g left\nusemtl red\nf 1/1/1 2//1 \\\n 3/2\ng right\nusemtl blue one\nf -4 -2 -1\nusemtl red\nf 1/1/1 2//1 3/2\n";
    let model = parse_obj(text.as_bytes(), "a.obj").unwrap();
    let mesh = &model.mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5], [0, 1, 2]]);
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[2], [1.0, 1.0]);
    assert_eq!(mesh.normals.as_ref().unwrap()[0], [0.0, 0.0, 1.0]);
    let parts: Vec<_> = mesh.parts.iter().map(|p| (&*p.name, p.material.unwrap(), p.triangles.clone())).collect();
    assert_eq!(parts, [("left", 0, 0..1), ("right", 1, 1..2), ("right", 0, 2..3)]);
    assert_eq!(model.libraries, ["my file.mtl", "b.mtl"]);
    assert_eq!(model.materials[1].name, "blue one");
    let colored = parse_obj(b"v 0 0 0\nv 1 0 0 1 0 0.5\nv 0 1 0 0 1 0\nf 1 2 3\nl 1 2\np 1", "").unwrap();
    assert_eq!(colored.warnings, ["2 lines and points are not read: only polygons are"]);
    let colors = colored.mesh.colors.unwrap();
    assert_eq!((colors[0], colors[1][0], colors[1][1]), ([1.0; 4], 1.0, 0.0));
    assert!((colors[1][2] - 0.214_041_14).abs() < 1e-6, "{}", colors[1][2]);
}

#[test]
fn errors_name_the_line_and_what_is_right() {
    let message = |text: &str| parse_obj(text.as_bytes(), "a.obj").unwrap_err().to_string();
    assert_eq!(message("v 0 0 0\nf 1 1 x"), "a.obj:2: `x` should be the number of a position");
    assert_eq!(message("\nv 0 \x1bx 0"), "a.obj:2: `\\u{1b}x` should be a number");
    let error = parse_ply(SQUARE.replace("vertex 4", "vertex 99999999999").as_bytes(), "a.ply").unwrap_err();
    assert_eq!(error.place, Place::Line(4));
    let error = parse_ply(SQUARE.replace("4 0 1 2 3", "4 0 1 2 4").as_bytes(), "a.ply").unwrap_err();
    assert!(error.to_string().contains("vertex 4: with 4 vertices the index has to be below 4"), "{error}");
}

#[test]
fn cleaning_drops_and_counts() {
    let text = "v 0 0 0\nv nan 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 1e99 0 0\nvn nan 0 0\n\
        f 1 3 4\nf 1 2 3\nf 1 3 3\nf 1 3 5\nf 1 3\nf 6 3 4\nf 1//1 4 3\n";
    let model = parse_obj(text.as_bytes(), "").unwrap();
    let dropped = model.dropped;
    assert_eq!((dropped.degenerate, dropped.not_finite, dropped.attributes), (3, 2, 1));
    assert_eq!(model.mesh.triangles.len(), 2);
    assert!(model.mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert!(dropped.warning().unwrap().starts_with("3 faces"));
}

#[test]
fn mtl_values_and_maps() {
    let text = b"newmtl a b\nKd 1 0.5 0\nKs 0.25\nKe 3 3 3\nNs 10\nTr 0.25\nNi 1.5\nPr 0.5\nPm 1\n\
        map_Kd -s 2 2 -bm 1 dir/my file.png\nbump -o 1 2 3 -clamp on -bm 0.5 n.png\nPs 0\ndisp a\nrefl b\ndisp c\n";
    let library = parse_mtl(text, "a.mtl");
    let material = &library.materials[0];
    assert_eq!((material.name.as_str(), material.diffuse), ("a b", Some([1.0, 0.5, 0.0])));
    assert_eq!((material.specular, material.opacity), (Some([0.25; 3]), Some(0.75)));
    let map =
        MtlMap { file: "dir/my file.png".into(), scale: [2.0, 2.0], offset: [0.0; 2], clamp: false, multiplier: 1.0 };
    assert_eq!(material.diffuse_map, Some(map));
    let map = MtlMap { file: "n.png".into(), scale: [1.0; 2], offset: [1.0, 2.0], clamp: true, multiplier: 0.5 };
    assert_eq!(material.bump_map, Some(map));
    assert_eq!(material.unread, ["`disp`", "`refl`"]);
    let both = &parse_mtl(b"newmtl a\nd 0.25\nTr 0.25\nmap_Kd -s", "a.mtl").materials[0];
    assert_eq!((both.opacity, &both.diffuse_map), (Some(0.25), &None));
    assert_eq!(library.warnings, [""; 0]);
}

#[test]
fn files_with_their_libraries() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.OBJ");
    let text = "mtllib a.mtl ../b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3";
    std::fs::write(&path, text).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl m\nPr 0.5").unwrap();
    let model = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!((model.materials[0].name.as_str(), model.materials[0].surface.roughness), ("m", 0.5));
    assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
    assert_eq!((&*model.instances[0].name, model.instances[0].mesh), ("a", 0));
    assert_eq!(model.meshes[0].parts[0].material, Some(0));
    let small = LoadOptions { most_bytes: 10, ..LoadOptions::default() };
    assert!(load(&path, &small).unwrap_err().message.contains("larger than 10 bytes"));
    let fails = |path: &Path| load(path, &LoadOptions::default()).is_err();
    assert!(fails(folder.path()) && fails(&folder.path().join("none.ply")));
    std::fs::write(folder.path().join("none.stl"), "solid a\nendsolid a").unwrap();
    let empty = load(&folder.path().join("none.stl"), &LoadOptions::default()).unwrap();
    assert_eq!((empty.meshes.len(), empty.instances.len()), (0, 0));
    assert_eq!(empty.warnings, ["there are no triangles in this file"]);
}

#[test]
fn what_was_dropped_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 3\nusemtl m\nf 1 2 3").unwrap();
    let model = load(&path, &LoadOptions::default()).unwrap();
    let expected = ["1 material is named but in no material library", "1 face without area was left out"];
    assert_eq!(model.warnings, expected);
}

#[test]
fn names_that_lead_outside_are_refused() {
    for name in ["../a", "/etc/passwd", "a/../../b", "C:\\a", "..\\a", "", "a\0b"] {
        assert_eq!(path_inside(Path::new("f"), name), None, "{name}");
    }
    assert_eq!(path_inside(Path::new("f"), "a\\b c.png"), Some("f/a/b c.png".into()));
}

/// Exporters write the same faces many times over, and each would cost a test a ray.
#[test]
fn of_triangles_in_one_place_a_few_are_kept() {
    let copies = "f 1 2 3\nf 2 3 1\nf 1 3 2\n".repeat(10_000);
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 -0.0\nv 0 1 0\n{copies}f 1 2 4\nusemtl other\nf 1 2 3\n");
    let file = parse_obj(text.as_bytes(), "a.obj").expect("the file can be read");
    // Four of either orientation stay, and what is of another material.
    assert_eq!(file.mesh.triangles.len(), 9);
    let told = file.dropped.warning().expect("there is something to tell");
    assert_eq!(told, "29993 triangles that coincide with others were left out");
}
