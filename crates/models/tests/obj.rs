//! OBJ and MTL files as programs write them, with what is wrong in them.

use raggio_models::{AlphaMode, LoadOptions, MeshFile, Model, load, parse_mtl, parse_obj};

const SQUARE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";

fn obj(text: &str) -> MeshFile {
    parse_obj(text.as_bytes(), "a.obj").expect("a valid file")
}

/// The model of an OBJ with its library, which it calls `a.mtl`.
fn model(obj: &str, mtl: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, format!("mtllib a.mtl\n{obj}")).unwrap();
    std::fs::write(folder.path().join("a.mtl"), mtl).unwrap();
    load(&path, &LoadOptions::default()).unwrap()
}

#[test]
fn names_keep_their_number_signs() {
    let mtl = "newmtl C_#1 # x\nKd 0 0 1 # blue\nnewmtl C_#2\nKd 1 0 0#red\nNs 10 # 20\nmap_Kd -s 2 2 wood#2.png\n";
    let library = parse_mtl(mtl.as_bytes(), "a.mtl");
    assert_eq!(library.warnings, [""; 0]);
    let [first, second] = &library.materials[..] else { panic!("{library:?}") };
    assert_eq!((first.name.as_str(), first.diffuse), ("C_#1 # x", Some([0.0, 0.0, 1.0])));
    assert_eq!((second.name.as_str(), second.diffuse), ("C_#2", Some([1.0, 0.0, 0.0])));
    let map = second.diffuse_map.as_ref().unwrap();
    assert_eq!((second.shininess, map.file.as_str(), map.scale), (Some(10.0), "wood#2.png", [2.0, 2.0]));

    let file = obj(&format!(
        "#v 9 9 9\n  # usemtl none \\\nmtllib a#1.mtl b#2.mtl\n{SQUARE}o Part#1\nusemtl C_#2\nf 1 2 3 4 # f 1 2 3\n\
         g Part #2\nusemtl C_#1\nf 1 2 3#4\n"
    ));
    assert_eq!(file.libraries, ["a#1.mtl", "b#2.mtl"]);
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    let parts: Vec<_> = file.mesh.parts.iter().map(|part| (&*part.name, part.material)).collect();
    assert_eq!(parts, [("Part#1", Some(0)), ("Part #2", Some(1))]);
    assert_eq!([&file.materials[0].name, &file.materials[1].name], ["C_#2", "C_#1"]);
    let mtl = "newmtl C_#1\nKd 0 0 1\nnewmtl C_#2\nKd 1 0 0\n";
    let model = model("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl C_#2\nf 1 2 3", mtl);
    assert_eq!((model.materials[0].surface.base_color, model.warnings.len()), ([1.0, 0.0, 0.0], 0));
}

/// C libraries of Windows print infinite numbers and those that are none with a number sign.
#[test]
fn numbers_that_are_none_are_no_comments() {
    let file = obj("v 0 0 0\nv 1.#IND 0 0\nv 0 -1.#QNAN 0\nv 1.#INF 1.#INF00 5\nv 1 0 0\nv 0 1 0 # end\n\
        f 1 5 6\nf 1 2 5\nf 1 3 5\nf 1 4 5\nvn 1.#IND 0 1\nf 1//1 5//1 6//1");
    assert_eq!((file.mesh.triangles.len(), file.dropped.not_finite, file.dropped.attributes), (2, 3, 3));
}

#[test]
fn corners_without_what_they_name_are_left_without() {
    let normals = obj(&format!("{SQUARE}f 1//1 2//2 3//3 4//4"));
    assert_eq!((normals.mesh.triangles.len(), &normals.mesh.normals), (2, &None));
    assert_eq!(
        normals.warnings,
        ["4 corners of faces name normals that do not exist, the first in line 5: they have none"]
    );
    let zero = obj(&format!("{SQUARE}vn 0 0 1\nf 1//0 2//1 3//1 4//1"));
    let flat = [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    assert_eq!((zero.mesh.triangles.len(), zero.mesh.normals.unwrap()), (2, flat.to_vec()));
    assert_eq!(zero.warnings, ["a corner of the face in line 6 names normals that do not exist: it has none"]);
    let uvs = obj(&format!("{SQUARE}vt 0.5 1\nf 1/1/0 2/0/5 3/-2/-1\nf 1/1 2/1 3/1"));
    assert_eq!(uvs.mesh.uvs[0].as_ref().unwrap()[..3], [[0.5, 1.0], [0.0, 0.0], [0.0, 0.0]]);
    assert_eq!(
        uvs.warnings,
        [
            "3 corners of faces name normals that do not exist, the first in line 6: they have none",
            "2 corners of faces name texture coordinates that do not exist, the first in line 6: they have none",
        ]
    );
}

#[test]
fn faces_without_a_position_are_left_out() {
    for corner in ["0", "0/1/1", "/1", "//1", "5", "-5", "-9223372036854775808"] {
        let file = obj(&format!("{SQUARE}s 1\nf 1 2 3\nf 1 4 {corner}\nf -4 -2 -1"));
        assert_eq!(file.mesh.positions.len(), 4, "{corner}");
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{corner}");
        let warning = "the face in line 7 names a vertex that does not exist: it is left out";
        assert_eq!(file.warnings, [warning], "{corner}");
    }
    let all = obj(&format!("f 1 2 3\n{SQUARE}f 0 0 0 0\nf 9 9 9\nf 1 2 3"));
    assert_eq!(all.mesh.triangles.len(), 1);
    assert_eq!(all.warnings, ["3 faces name vertices that do not exist, the first in line 1: they are left out"]);
    // A face that is left out leaves no vertex behind, which would count for the bounds.
    let far = obj(&format!("{SQUARE}v 9 9 9\nf 5 1 0\nf 1 2 3"));
    assert_eq!((far.mesh.positions.len(), far.mesh.triangles.len()), (3, 1));
}

/// The vertices of a mesh: position and normal, rounded to three digits.
fn vertices(file: &MeshFile) -> Vec<([f32; 3], [f32; 3])> {
    let normals = file.mesh.normals.clone().unwrap_or_else(|| vec![[0.0; 3]; file.mesh.positions.len()]);
    let round = |v: [f32; 3]| v.map(|x| (x * 1000.0).round() / 1000.0 + 0.0);
    file.mesh.positions.iter().zip(normals).map(|(position, normal)| (*position, round(normal))).collect()
}

/// Two squares that meet at a right angle: along the edge both normals are at 45 degrees.
#[test]
fn smoothing_groups_share_normals() {
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 -1\nv 0 1 -1\n";
    let smooth = obj(&format!("{roof}s 1\nf 1 2 3 4\nf 5 1 4 6"));
    let half = [-0.707, 0.0, 0.707];
    let up = [0.0, 0.0, 1.0];
    let left = [-1.0, 0.0, 0.0];
    let expected = [
        ([0.0, 0.0, 0.0], half),
        ([1.0, 0.0, 0.0], up),
        ([1.0, 1.0, 0.0], up),
        ([0.0, 1.0, 0.0], half),
        ([0.0, 0.0, -1.0], left),
        ([0.0, 1.0, -1.0], left),
    ];
    assert_eq!(vertices(&smooth), expected);
    // Groups of different numbers have a crease between them, and so has the face of no group.
    for (groups, normals) in
        [(["1", "2"], [up, left]), (["3 # a", "0"], [up, [0.0; 3]]), (["off", "-4"], [[0.0; 3], left])]
    {
        let [first, second] = groups;
        let file = obj(&format!("{roof}s {first}\nf 1 2 3 4\ns {second}\nf 5 1 4 6"));
        let found = vertices(&file);
        assert_eq!((found.len(), file.warnings.len()), (8, 0), "{groups:?}");
        assert!(found[..4].iter().all(|(_, normal)| *normal == normals[0]), "{found:?}");
        assert!(found[4..].iter().all(|(_, normal)| *normal == normals[1]), "{found:?}");
    }
    // Faces after each other may be of one group again, and faces with normals keep theirs.
    let again = obj(&format!("{roof}s 1\nf 1 2 3 4\ns off\nf 1 2 3\ns 1\nf 5 1 4 6"));
    assert!(vertices(&again).contains(&([0.0; 3], half)));
    let given = obj(&format!("{roof}vn 0 1 0\ns 1\nf 1//1 2//1 3//1 4//1\nf 5 1 4 6"));
    assert_eq!(vertices(&given)[..4].iter().map(|(_, n)| *n).collect::<Vec<_>>(), [[0.0, 1.0, 0.0]; 4]);
    assert_eq!(vertices(&given)[5], ([0.0; 3], left));
    let flat = obj(&format!("{roof}f 1 2 3 4\nf 5 1 4 6"));
    assert_eq!((flat.mesh.positions.len(), flat.mesh.normals), (6, None));
    let odd = obj(&format!("{roof}s blob\nf 1 2 3 4"));
    assert_eq!(
        (odd.mesh.normals, odd.warnings),
        (None, vec!["line 7: `blob` is not a smoothing group: its faces are flat".into()])
    );
}

/// Each corner counts by its angle, not by the size of its face or the number of its triangles.
#[test]
fn smooth_normals_are_weighted_by_angle() {
    // In the first vertex: a square upwards (90 degrees), and two triangles to the left that share another 90 degrees.
    let file = obj("v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 -1\nv 0 1 -1\ns 1\nf 1 2 3 4\nf 1 6 5\nf 1 4 6");
    assert_eq!(vertices(&file)[0], ([0.0; 3], [-0.707, 0.0, 0.707]));
    // Texture coordinates split vertices, but not their normals.
    let seam = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 -1\nv 0 1 -1\nvt 0 0\nvt 1 1\ns 1\n\
        f 1/1 2/1 3/1 4/1\nf 5/2 1/2 4/2 6/2");
    let at_origin: Vec<_> = vertices(&seam).into_iter().filter(|(position, _)| *position == [0.0; 3]).collect();
    assert_eq!(at_origin, [([0.0; 3], [-0.707, 0.0, 0.707]); 2]);
    // Faces that cancel each other out leave no normal.
    let sheet = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\ns 1\nf 1 2 3\nf 3 2 1");
    assert_eq!(sheet.mesh.normals.unwrap(), [[0.0; 3]; 3]);
}

#[test]
fn models_that_tr_would_hide_are_opaque() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n";
    let shown = |mtl: &str| {
        let model = model(triangle, mtl);
        let alphas: Vec<_> = model.materials.iter().map(|m| (m.surface.alpha, m.surface.alpha_mode)).collect();
        (alphas, model.warnings)
    };
    let (opaque, clear) = ((1.0, AlphaMode::Opaque), (0.0, AlphaMode::Blend));
    let taken = "by `Tr 1` all materials would be invisible: they are taken for opaque, which some programs mean by it";
    assert_eq!(shown("newmtl a\nKd 1 0 0\nTr 1\nnewmtl b\nTr 1.0"), (vec![opaque, opaque], vec![taken.to_string()]));
    let told =
        |name: &str, line: &str| format!("the material `{name}` cannot be seen: by `{line}` it is wholly transparent");
    assert_eq!(shown("newmtl a\nTr 1\nnewmtl b\nTr 0"), (vec![clear, opaque], vec![told("a", "Tr 1")]));
    assert_eq!(
        shown("newmtl a\nd 0\nTr 1\nnewmtl b\nd 0"),
        (vec![clear, clear], vec![told("a", "d 0"), told("b", "d 0")])
    );
    assert_eq!(shown("newmtl a\nTr 1\nd 1\nnewmtl b\nd 1"), (vec![opaque, opaque], vec![]));
    // A refracting material is seen, however transparent.
    let (glass, warnings) = shown("newmtl a\nTr 1\nillum 7\nNi 1.5\nTf 1 1 1\nnewmtl b\nTr 1\nillum 7\nNi 1.5\n");
    assert_eq!((glass, warnings), (vec![opaque, opaque], vec![]));
}

#[test]
fn a_bad_number_costs_its_line_alone() {
    let mtl =
        "newmtl a\nKd 1 0 0\nNs nan\nNi 1,5\nKs 1 x 1\nd\nPr 0.25\nmap_Kd -s 2 nan -o 1 1 t.png\nbump -bm 1,5 b.png\n";
    let library = parse_mtl(mtl.as_bytes(), "a.mtl");
    let material = &library.materials[0];
    assert_eq!((material.diffuse, material.roughness), (Some([1.0, 0.0, 0.0]), Some(0.25)));
    assert_eq!(
        (material.shininess, material.refractive_index, material.specular, material.opacity),
        (None, None, None, None)
    );
    let expected = [
        "a.mtl:3: `nan` should be a finite number: `Ns` keeps its default",
        "a.mtl:4: `1,5` should be a finite number: `Ni` keeps its default",
        "a.mtl:5: `x` should be a finite number: `Ks` keeps its default",
        "a.mtl:6: a number should follow: `d` keeps its default",
        "a.mtl:8: `nan` should be a finite number behind `-s`: `map_Kd` keeps its default",
        "a.mtl:9: `1,5` should be a finite number behind `-bm`: `bump` keeps its default",
    ];
    assert_eq!(library.warnings, expected);
    let map = material.diffuse_map.as_ref().unwrap();
    assert_eq!((map.file.as_str(), map.scale, map.offset), ("t.png", [1.0; 2], [1.0; 2]));
    assert_eq!(material.bump_map.as_ref().unwrap().multiplier, 1.0);
}

#[test]
fn many_warnings_alike_are_one() {
    let bad = "Ns nan\n".repeat(500);
    let library = parse_mtl(format!("newmtl a\nKd x\n{bad}").as_bytes(), "a.mtl");
    let expected = "a.mtl:2: `x` should be a finite number: `Kd` keeps its default (and 500 more like this)";
    assert_eq!(library.warnings, [expected]);
    let textures: String = (0..100).map(|i| format!("newmtl m{i}\nmap_Kd t{i}.png\n")).collect();
    let faces: String = (0..100).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let model = model(&format!("{SQUARE}{faces}usemtl other\nf 1 2 3"), &textures);
    let expected = [
        "1 material is named but in no material library",
        "the texture `t0.png` is not used: it does not exist (and 99 more like this)",
    ];
    assert_eq!(model.warnings, expected);
}

/// Files of old Macintoshes end their lines with a carriage return, and some programs of Windows save UTF-16.
#[test]
fn any_ending_of_lines_and_any_unicode() {
    let text = format!("# first\nmtllib a.mtl\n\n{SQUARE}usemtl é\nf 1 2 \\\n3 4\ns 1\nf 1 2 3\nl 1 2\n");
    let expected = obj(&text);
    assert_eq!(expected.mesh.triangles.len(), 3);
    let utf16 = |text: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(unit).collect()
    };
    let variants = [
        text.replace('\n', "\r").into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        format!("\u{feff}{text}").into_bytes(),
        utf16(&text, u16::to_le_bytes),
        utf16(&text.replace('\n', "\r\n"), u16::to_be_bytes),
    ];
    for bytes in variants {
        assert_eq!(parse_obj(&bytes, "").unwrap(), expected);
    }
    let mtl = "newmtl é\n\nKd 1 0 0\nNs x\n";
    let expected = parse_mtl(mtl.as_bytes(), "a");
    assert_eq!(expected.warnings, ["a:4: `x` should be a finite number: `Ns` keeps its default"]);
    for bytes in [mtl.replace('\n', "\r").into_bytes(), utf16(mtl, u16::to_le_bytes), utf16(mtl, u16::to_be_bytes)] {
        assert_eq!(parse_mtl(&bytes, "a"), expected);
    }
    // The line of an error is the same whatever ends the lines.
    for ending in ["\n", "\r", "\r\n"] {
        let error = parse_obj("v 0 0 0\n\nv 1 x 0\n".replace('\n', ending).as_bytes(), "a").unwrap_err();
        assert_eq!(error.to_string(), "a:3: `x` should be a number");
    }
}
