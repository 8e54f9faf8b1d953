//! The pretended library, compiled where there is a C compiler: whoever builds raggio has one.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use raggio_denoise::Gpu;

/// GPUs that the library pretends to have, by the first byte of their UUID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code, reason = "each program of tests needs some")]
pub enum Pretended {
    /// What it makes of a picture is the picture.
    CopiesColor = 1,
    /// What it makes of a picture is its albedo.
    CopiesAlbedo = 2,
    /// What it makes of a picture are its normals.
    CopiesNormal = 3,
    /// It has no memory for any work.
    RunsOutOfMemory = 4,
    /// It refuses memory that it is handed.
    RefusesMemory = 5,
    /// It does not take memory of others.
    TakesNoMemory = 6,
    /// There is none.
    Missing = 7,
}

impl Pretended {
    pub fn gpu(self) -> Gpu {
        let mut uuid = [0; 16];
        uuid[0] = self as u8;
        Gpu { name: format!("{self:?}"), uuid, luid: None }
    }
}

/// Path of the library.
pub fn path() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let library = folder.join(format!("pretended-oidn-{}.so", std::process::id()));
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let mut words = compiler.split_whitespace();
        let mut command = Command::new(words.next().unwrap_or("cc"));
        command.args(words).args(["-shared", "-fPIC", "-O1", "-x", "c", "-", "-o"]).arg(&library);
        let mut compiler = command.stdin(Stdio::piped()).spawn().expect("there is a C compiler");
        let mut source = compiler.stdin.take().expect("it reads");
        source.write_all(include_bytes!("oidn.c")).expect("it reads the source");
        drop(source);
        assert!(compiler.wait().expect("it ends").success(), "the pretended library does not compile");
        library
    })
}
