//! Kernels that run for several paths at once: SPIR-V -> C++ (crates/lanes), and what `cpp/wave.h` has to know of them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use raggio_lanes::{Options, RUNTIME, translate};

use crate::cpp::{COUNTS_WORD, TRAVERSAL_WORD};
use crate::declarations::Declarations;
use crate::layout::Places;

/// Functions that are written by hand, or done lane by lane: `Context` of `cpp/wave.h`.
const HOOKS: [&str; 2] = ["walk", "addTerms"];
/// Functions that are called, for they are long, and several places need them; the rest is put into its callers. With them
/// there is a third to a half less to compile.
const CALLED: [&str; 7] = [
    "PrincipledFresnel_dielectric",
    "RoughBoundary_at",
    "StretchedMirror_loss",
    "TexturedPoint_sample",
    "ThinFilm_reflectance",
    "attributesAt",
    "emission",
];
/// Functions that are called where the path tracer, a quarter slower with them, has copies: what they are given and return
/// is hundreds of numbers.
const CALLED_BUT_BY_PATHS: [&str; 2] = ["Bsdf_look", "PrincipledBsdf_evaluate"];
/// Buffer of the paths that wait between stages.
const PATHS: &str = "paths";

/// Kernels of which the C++ compiler gets some at a time: the name of the function that runs them, the place of their variant
/// in `slangc::LANES`, and their entry points. What most pictures are made with has kernels of its own for simple scenes and
/// for those with media.
const GROUPS: [(&str, usize, &[&str]); 5] = [
    ("path", 0, &["renew", "find", "shade"]),
    ("path_simple", 1, &["renew", "find", "shade"]),
    ("path_media", 2, &["renew", "find", "shade"]),
    ("inspect", 2, &["inspect"]),
    ("reference", 2, &["reference"]),
];

/// Functions that the kernels of a group call.
fn called(group: &str) -> impl Iterator<Item = &'static str> {
    let others = if group.starts_with("path") { &[][..] } else { &CALLED_BUT_BY_PATHS };
    CALLED.iter().chain(others).copied()
}

/// C++ of a group of kernels for several paths at once, complete but for what differs from level to level.
pub struct Lanes {
    /// Name of the function that runs the group.
    pub name: &'static str,
    /// The translated kernels, and constants and functions that `context.h` and `wave.h` use.
    pub text: String,
}

impl Lanes {
    /// Header that the text includes as `lanes.h`.
    pub const RUNTIME: &str = RUNTIME;

    /// Whether a level of so many lanes has these kernels. Few lanes gain little: only the path tracer is worth its
    /// compile time there.
    pub fn are_of(&self, lanes: u32) -> bool {
        lanes >= 8 || (lanes > 1 && self.name.starts_with("path"))
    }

    /// Name of the file with the text.
    pub fn file(&self) -> String {
        format!("{}.lanes.inc", self.name)
    }

    /// Text of the C++ file for a level of instruction set.
    pub fn translation_unit(&self, suffix: &str, lanes: u32) -> String {
        let (name, file) = (self.name, self.file());
        let driver = if name.starts_with("path") { "wave.h" } else { "pixels.h" };
        // The namespace has another name in each unit, or the linker would take functions of one for those of another.
        format!(
            "#define LANES {lanes}\n#define LEVEL {suffix}\n#define KERNEL {name}\n#define lanes lanes_{name}_{suffix}\n\
             #include \"{file}\"\n#include \"{driver}\"\n"
        )
    }

    /// Translates the kernels of all groups. `code` has the SPIR-V of each variant, with its reflection beside it; `places`
    /// are the parameters' in C++.
    pub fn translate_all(code: &[PathBuf], declarations: &Declarations, places: &Places) -> Result<Vec<Self>, String> {
        let translated = GROUPS.iter().map(|(name, variant, entry_points)| {
            Self::translate(name, entry_points, &code[*variant], declarations, places)
        });
        let translated: Vec<Self> = translated.collect::<Result<_, _>>()?;
        let calls = |name: &str| translated.iter().any(|lanes| lanes.text.contains(&format!(" void {name}_")));
        match CALLED.iter().chain(&CALLED_BUT_BY_PATHS).find(|name| !calls(name)) {
            None => Ok(translated),
            Some(name) => {
                Err(format!("the kernels call no function {name}: correct CALLED in crates/kernels/build/lanes.rs"))
            }
        }
    }

    fn translate(
        name: &'static str,
        entry_points: &[&str],
        code: &Path,
        declarations: &Declarations,
        places: &Places,
    ) -> Result<Self, String> {
        let bytes = std::fs::read(code).map_err(|e| format!("cannot read {}: {e}", code.display()))?;
        let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let options = Options {
            hooks: HOOKS.map(String::from).into(),
            calls: called(name).map(String::from).collect(),
            columns: vec![PATHS.into()],
            ..Options::default()
        };
        let translation =
            translate(&words, entry_points, &options).map_err(|e| format!("cannot translate the kernels: {e}"))?;
        let reflection = Places::read(&code.with_extension("json"))?;

        let mut text = translation.code;
        text += "\n// What wave.h has to know of the kernels.\n";
        text += "namespace lanes {\nstruct Context;\n";
        for (space, name) in [("path_columns", PATHS), ("work_words", "work"), ("film_words", "film")] {
            let _ = writeln!(text, "namespace {space} {{");
            for (member, word) in reflection.words_of(name)? {
                let _ = writeln!(text, "constexpr uint32_t {member} = {word};");
            }
            text += "}\n";
        }
        let block = declarations.constants.iter().find(|(constant, _)| constant == "BLOCK");
        let (_, block) = block.ok_or("the kernels have no constant `BLOCK`")?;
        let _ = writeln!(text, "constexpr uint32_t BLOCK = {block};");
        for name in ["work", "film", "resting"] {
            let _ = writeln!(text, "constexpr uint32_t {}_WORD = {};", name.to_uppercase(), places.word(name)?);
        }
        for (name, word) in [("TRAVERSAL", TRAVERSAL_WORD), ("COUNTS", COUNTS_WORD)] {
            let _ = writeln!(text, "constexpr uint32_t {name}_WORD = {word};");
        }
        text +=
            "\n/// Addresses of the kernels' buffers.\ninline void fill(Buffers& buffers, const uint64_t* globals) {\n";
        let _ = writeln!(text, "    const uint64_t* scene = (const uint64_t*)globals[{}];", places.word("scene")?);
        for buffer in translation.buffers.iter().filter(|buffer| !buffer.columns) {
            let name = &buffer.name;
            let place = match reflection.scene_list(buffer.set, buffer.binding) {
                Some(list) => format!("scene[{}]", places.scene_word(list)?),
                None => format!("globals[{}]", places.word(name)?),
            };
            let _ = writeln!(text, "    buffers.{name} = (char*){place};");
        }
        text += "    (void)scene;\n}\n}\n";
        Ok(Self { name, text })
    }
}
