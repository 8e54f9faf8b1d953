//! Files of the mesh that speed is measured with, for other programs.
//!
//! `cargo run --release -p raggio-scene --example write_rock -- LEVEL FOLDER` writes `rock-LEVEL.ply`, 20 * 4^LEVEL triangles
//! and a square of two, and `rock-LEVEL.toml`, a scene with it.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::Path;

use raggio_scene::{Geometry, Mesh, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [level, folder] = &arguments[..] else { return Err("usage: write_rock LEVEL FOLDER".into()) };
    let (level, folder): (u32, _) = (level.parse()?, Path::new(folder));
    let scene = Scene::rock(level);
    let Geometry::Mesh { mesh, .. } = &scene.shapes[0].geometry else { return Err("the rock is no mesh".into()) };
    let name = format!("rock-{level}.ply");
    fs::create_dir_all(folder)?;
    write(mesh, &folder.join(&name))?;
    // The scene comes last: where it is, all is there.
    let shape = format!("[[shapes]]\nmaterial = \"clay\"\nmesh = {{ file = \"{name}\" }}\n");
    fs::write(folder.join(format!("rock-{level}.toml")), Scene::ROCK.to_owned() + &shape)?;
    Ok(())
}

/// Writes corners and faces as a binary PLY.
fn write(mesh: &Mesh, path: &Path) -> std::io::Result<()> {
    let mut file = BufWriter::new(fs::File::create(path)?);
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for number in mesh.positions.iter().flatten() {
        file.write_all(&number.to_le_bytes())?;
    }
    for corners in &mesh.triangles {
        file.write_all(&[3])?;
        for corner in corners {
            file.write_all(&corner.to_le_bytes())?;
        }
    }
    file.flush()
}
