//! Prints the C++ of a SPIR-V file: `translate FILE entry,points hooks,if,any buffers,of,columns`.

use raggio_lanes::{Options, translate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, lists @ ..] = &arguments[..] else { return Err("give a file of SPIR-V and entry points".into()) };
    let list = |i: usize| lists.get(i).map_or(vec![], |list| list.split(',').map(str::to_owned).collect());
    let bytes = std::fs::read(file)?;
    let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let options = Options { hooks: list(1), columns: list(2), ..Options::default() };
    let entry_points = list(0);
    let entry_points: Vec<&str> = entry_points.iter().map(String::as_str).collect();
    let translation = translate(&words, &entry_points, &options)?;
    print!("{}", translation.code);
    Ok(())
}
