//! STL files as programs write them, with what is wrong in them.

use raggio_models::{MeshFile, Place, parse_stl};

const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn stl(bytes: impl AsRef<[u8]>) -> MeshFile {
    parse_stl(bytes.as_ref(), "a.stl").expect("a valid file")
}

/// The one triangle of a file and its warnings.
#[track_caller]
fn one_triangle(bytes: impl AsRef<[u8]>, warnings: &[&str]) {
    let file = stl(bytes);
    assert_eq!((&file.mesh.positions[..], &file.mesh.triangles[..]), (&CORNERS[..], &[[0, 1, 2]][..]));
    assert_eq!(file.warnings, warnings);
}

#[test]
fn ascii_files_with_less_and_more_than_they_should_have() {
    let no_end = "the file ends without `endsolid`";
    let whole = format!("solid x\n{FACET}endsolid x\n");
    one_triangle(&whole, &[]);
    one_triangle(format!("solid\n{FACET}"), &[no_end]);
    one_triangle(format!("\u{feff}{whole}"), &[]);
    one_triangle(whole.to_ascii_uppercase(), &[]);
    one_triangle(whole.replace('\n', "\r\n"), &[]);
    one_triangle(whole.replace('\n', "\r"), &[]);
    one_triangle(format!("# made by hand\n; and again\n// x\n{}", whole.replace("vertex 1", "# here\nvertex 1")), &[]);
    one_triangle(whole.replace("vertex 1 0 0", "vertex 1 0 0 # the second"), &[]);
    one_triangle(format!("\u{feff}{whole}").encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<_>>(), &[]);
    one_triangle(FACET, &[]);
    one_triangle(format!("solid\n{}endsolid", FACET.replace('\n', " ")), &[]);
    one_triangle(whole.replace("facet normal 0 0 1", "facet normal -nan(ind) 1.#QNAN x"), &[]);
    one_triangle(whole.replace("normal 0 0 1", "0 0 1"), &[]);
    let odd = whole.replace("outer", "color 1 0 0\nouter");
    one_triangle(odd, &["line 3: `color` is not a word of STL: the line is passed over"]);
    let colors = "color 1 0 0\n".repeat(500);
    let expected = "line 3: `color` is not a word of STL: the line is passed over (and 499 more like this)";
    one_triangle(whole.replace("outer", &format!("{colors}outer")), &[expected]);
    // A file that is cut off, behind a whole corner, within one, and between facets.
    let cut = "the file ends within a facet, of which the corners that are there are read";
    one_triangle(&whole[..whole.find("endloop").unwrap()], &[cut, no_end]);
    for rest in ["facet normal 0 0 1\nouter loop\nvertex 5 5 5\nvertex 5", "facet normal 0 0 1\nouter loop\n"] {
        let file = stl(format!("solid\n{FACET}{rest}"));
        assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
        assert_eq!(file.warnings.last().unwrap(), no_end);
    }
    // What is no number cannot be guessed.
    let error = parse_stl(whole.replace("1 0 0", "1 x 0").as_bytes(), "a.stl").unwrap_err();
    assert_eq!(error.to_string(), "a.stl:5: `x` should be a number");
}

#[test]
fn solids_are_parts() {
    let other = FACET.replace("vertex 0 0 0", "vertex 9 0 0");
    let text = format!("solid one\n{FACET}endsolid one\nsolid\n{other}\nsolid two\n{FACET}{other}endsolid\nendsolid\n");
    let file = stl(&text);
    let parts: Vec<_> = file.mesh.parts.iter().map(|part| (&*part.name, part.triangles.clone())).collect();
    assert_eq!(parts, [("one", 0..1), ("", 1..2), ("two", 2..4)]);
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [3, 1, 2], [0, 1, 2], [3, 1, 2]]);
}

/// A binary file that declares so many facets and has the one triangle twice.
fn binary(header: &str, declared: u32) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(declared.to_le_bytes());
    for _ in 0..2 {
        bytes.extend([0; 12]);
        bytes.extend(CORNERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn binary_files_that_miscount() {
    let twice = |bytes: &[u8], warnings: &[&str]| {
        let file = stl(bytes);
        assert_eq!((&file.mesh.positions[..], &file.mesh.triangles[..]), (&CORNERS[..], &[[0, 1, 2], [0, 1, 2]][..]));
        assert_eq!(file.warnings, warnings);
    };
    for header in ["", "solid of facets and vertices", "\u{feff}solid facet"] {
        twice(&binary(header, 2), &[]);
        twice(&binary(header, 0), &["0 facets are declared: the 2 that are there are read"]);
        twice(&binary(header, 3), &["3 facets are declared: the 2 that are there are read"]);
        twice(&binary(header, u32::MAX), &["4294967295 facets are declared: the 2 that are there are read"]);
    }
    let cut = &binary("", 2)[..84 + 99];
    one_triangle(cut, &["2 facets are declared: the 1 that are there are read"]);
    one_triangle(binary("", 1), &["50 bytes after the last facet are not read"]);
    // Bytes that are no coordinates are no facets, whatever is declared.
    let mut other = binary("", 9);
    other[84 + 12..84 + 16].copy_from_slice(&[0xff; 4]);
    let error = parse_stl(&other, "a.stl").unwrap_err();
    assert_eq!(error.place, Place::Byte(80));
    assert!(parse_stl("<html> ".repeat(100).as_bytes(), "").is_err());
    assert!(parse_stl(&binary("", 1)[..84 + 49], "").is_err());
}
