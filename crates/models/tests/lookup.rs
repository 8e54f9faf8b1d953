//! Files that OBJ, MTL and PLY files name: found where they are, and nowhere else.

use std::fs::{create_dir, write};
use std::path::Path;

use raggio_images::Texels;
use raggio_models::{LoadOptions, Model, load};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";

const RED: [u8; 4] = [255, 0, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];

fn png(path: &Path, color: [u8; 4]) {
    image::RgbaImage::from_pixel(1, 1, image::Rgba(color)).save(path).unwrap();
}

/// The model of `a.obj` in a folder, whose library is called so.
fn model(folder: &Path, library: &str) -> Model {
    write(folder.join("a.obj"), format!("mtllib {library}\n{OBJ}")).unwrap();
    load(&folder.join("a.obj"), &LoadOptions::default()).unwrap()
}

/// Colour of the texture, if there is one.
fn color(model: &Model) -> Option<[u8; 4]> {
    let texture = model.materials[0].surface.base_color_texture.as_ref()?;
    match &texture.image.texels {
        Texels::Rgba8(texels) => Some(texels[0]),
        _ => panic!("expected 8 bits"),
    }
}

/// Color and warnings with a library of one texture, beside the OBJ.
fn textured(folder: &Path, name: &str) -> (Option<[u8; 4]>, Vec<String>) {
    write(folder.join("a.mtl"), format!("newmtl m\nmap_Kd {name}\n")).unwrap();
    let model = model(folder, "a.mtl");
    (color(&model), model.warnings)
}

#[test]
fn textures_lie_beside_their_library_or_the_object() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    create_dir(folder.join("mats")).unwrap();
    write(folder.join("mats/m.mtl"), "newmtl m\nmap_Kd t.png\n").unwrap();
    png(&folder.join("t.png"), BLUE);
    for library in ["mats/m.mtl", "mats\\m.mtl", "./mats/m.mtl", "\"mats/m.mtl\""] {
        let beside_object = model(folder, library);
        assert_eq!((color(&beside_object), beside_object.warnings), (Some(BLUE), vec![]), "{library}");
    }
    png(&folder.join("mats/t.png"), RED);
    let beside_library = model(folder, "mats/m.mtl");
    assert_eq!((color(&beside_library), beside_library.warnings), (Some(RED), vec![]));
    // A name may go up as far as the folder of the object.
    write(folder.join("mats/m.mtl"), "newmtl m\nmap_Kd ../t.png\n").unwrap();
    let above = model(folder, "mats/m.mtl");
    assert_eq!((color(&above), above.warnings), (Some(BLUE), vec![]));
}

#[test]
fn paths_of_other_machines_count_by_their_last_part() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    png(&folder.join("red.png"), RED);
    create_dir(folder.join("tex")).unwrap();
    png(&folder.join("tex/my red.png"), BLUE);
    for (name, shown) in [
        ("C:\\x\\red.png", "C:\\x\\red.png"),
        ("/home/me/red.png", "/home/me/red.png"),
        ("\"D:/x y/red.png\"", "D:/x y/red.png"),
        ("\\\\server\\share\\red.png", "\\\\server\\share\\red.png"),
        ("../elsewhere/red.png", "../elsewhere/red.png"),
        ("textures/red.png", "textures/red.png"),
    ] {
        let warning = format!("the texture `{shown}` is not there: `red.png` is read instead");
        assert_eq!(textured(folder, name), (Some(RED), vec![warning]), "{name}");
    }
    for name in ["tex/my red.png", "tex\\my red.png", "\"tex/my red.png\"", "'tex\\my red.png'"] {
        assert_eq!(textured(folder, name), (Some(BLUE), vec![]), "{name}");
    }
    // Libraries are found so, too.
    write(folder.join("m.mtl"), "newmtl m\nmap_Kd red.png\n").unwrap();
    let found = model(folder, "C:\\mats\\m.mtl");
    let warning = "the material library `C:\\mats\\m.mtl` is not there: `m.mtl` is read instead";
    assert_eq!((color(&found), found.warnings), (Some(RED), vec![warning.to_string()]));
}

#[test]
#[cfg(target_os = "linux")]
fn names_in_other_letter_case_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    create_dir(folder.join("Tex")).unwrap();
    png(&folder.join("Tex/Wood.PNG"), RED);
    let warning =
        |name: &str, found: &str| vec![format!("the texture `{name}` is not there: `{found}` is read instead")];
    assert_eq!(textured(folder, "tex/wood.png"), (Some(RED), warning("tex/wood.png", "Tex/Wood.PNG")));
    png(&folder.join("Wood.Png"), BLUE);
    assert_eq!(textured(folder, "C:\\wood.png"), (Some(BLUE), warning("C:\\wood.png", "Wood.Png")));
    // The exact name is better, and of several others the same in each run.
    png(&folder.join("WOOD.png"), RED);
    assert_eq!(textured(folder, "wood.png"), (Some(RED), warning("wood.png", "WOOD.png")));
    png(&folder.join("wood.png"), BLUE);
    assert_eq!(textured(folder, "wood.png"), (Some(BLUE), vec![]));
    write(folder.join("Lib.MTL"), "newmtl m\nmap_Kd wood.png\n").unwrap();
    let found = model(folder, "lib.mtl");
    let warning = "the material library `lib.mtl` is not there: `Lib.MTL` is read instead";
    assert_eq!((color(&found), found.warnings), (Some(BLUE), vec![warning.to_string()]));
}

/// Archives carry links and pipes. Neither may be read by way of a model's names, nor keep it waiting.
#[test]
#[cfg(unix)]
fn links_that_lead_out_and_pipes_are_not_read() {
    use std::os::unix::fs::symlink;
    let outer = tempfile::tempdir().unwrap();
    let folder = &outer.path().join("model");
    create_dir(folder).unwrap();
    png(&outer.path().join("secret.png"), RED);
    write(outer.path().join("secret.mtl"), "newmtl m\nKd 1 0 0\n").unwrap();
    symlink("../secret.png", folder.join("link.png")).unwrap();
    symlink("..", folder.join("up")).unwrap();
    symlink("/dev/zero", folder.join("zero.png")).unwrap();
    symlink("../secret.mtl", folder.join("link.mtl")).unwrap();
    symlink("loop.png", folder.join("loop.png")).unwrap();
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe.png")).arg(folder.join("pipe.mtl")).status();
    assert!(made.unwrap().success());

    let out = "is a link that leads out of the folder of the model, where files are not read unless \
               `--allow-outside` is given";
    for (name, why) in [
        ("link.png", out),
        ("up/secret.png", out),
        ("UP/SECRET.png", "does not exist"),
        ("zero.png", out),
        ("pipe.png", "is a device or a pipe: only regular files are read"),
        (".", "is a folder: give a file"),
    ] {
        let warning = format!("the texture `{name}` is not used: it {why}");
        assert_eq!(textured(folder, name), (None, vec![warning]), "{name}");
    }
    let (none, warnings) = textured(folder, "loop.png");
    assert_eq!((none, warnings.len()), (None, 1), "{warnings:?}");
    for (name, why) in [("link.mtl", out), ("pipe.mtl", "is a device or a pipe: only regular files are read")] {
        let model = model(folder, name);
        assert_eq!(model.materials[0].surface.base_color, [0.8; 3]);
        assert_eq!(model.warnings[0], format!("the material library `{name}` {why}"));
    }
    // Whoever allows what is outside gets what links lead to, but still nothing that never ends.
    let allowed = |name: &str| {
        write(folder.join("a.mtl"), format!("newmtl m\nmap_Kd {name}\n")).unwrap();
        write(folder.join("a.obj"), format!("mtllib a.mtl\n{OBJ}")).unwrap();
        let options = LoadOptions { allow_outside: true, ..LoadOptions::default() };
        let model = load(&folder.join("a.obj"), &options).unwrap();
        (color(&model), model.warnings)
    };
    for name in ["link.png", "up/secret.png", "../secret.png", outer.path().join("secret.png").to_str().unwrap()] {
        assert_eq!(allowed(name), (Some(RED), vec![]), "{name}");
    }
    for name in ["zero.png", "pipe.png", "/dev/zero"] {
        let warning =
            format!("the texture `{name}` is not used: it is a device or a pipe: only regular files are read");
        assert_eq!(allowed(name), (None, vec![warning]));
    }
    // Links inside the folder are followed.
    png(&folder.join("real.png"), BLUE);
    symlink("real.png", folder.join("inner.png")).unwrap();
    assert_eq!(textured(folder, "inner.png"), (Some(BLUE), vec![]));
}

#[test]
fn all_that_is_found_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = &folder.path().canonicalize().unwrap();
    create_dir(folder.join("maps")).unwrap();
    png(&folder.join("maps/Color.png"), RED);
    // Whoever writes it anew may mean it to be read the next time.
    write(folder.join("maps/damaged.png"), "no picture").unwrap();
    let materials = "map_Kd maps/color.png\nmap_Ke maps/Color.png\nmap_Pr maps/damaged.png\nmap_d none.png\n";
    write(folder.join("a.mtl"), format!("newmtl m\n{materials}")).unwrap();
    let listed = ["a.mtl", "maps/Color.png", "maps/damaged.png"].map(|name| folder.join(name));
    assert_eq!(model(folder, "a.mtl").files, listed);

    write(folder.join("a.bin"), [0; 36]).unwrap();
    let gltf = r#"{ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 36, "uri": "maps/../a%2Ebin" }],
        "images": [{ "uri": "maps/Color.png" }, { "uri": "maps/unused.png" }],
        "textures": [{ "source": 0 }, { "source": 1 }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }] }"#;
    write(folder.join("a.gltf"), gltf).unwrap();
    let model = load(&folder.join("a.gltf"), &LoadOptions::default()).unwrap();
    assert_eq!(model.files, ["a.bin", "maps/Color.png"].map(|name| folder.join(name)));
}
