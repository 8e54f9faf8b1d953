//! Kernels that run for several paths at once: SPIR-V -> C++ (crates/lanes), and what `cpp/wave.h` has to know of them.

use std::fmt::Write as _;
use std::path::Path;

use raggio_lanes::{Options, RUNTIME, translate};

use crate::declarations::Declarations;
use crate::layout::Places;

/// Functions that are written by hand, or done lane by lane: `Context` of `cpp/wave.h`.
const HOOKS: [&str; 2] = ["walk", "addTerms"];
/// Buffer of the paths that wait between stages.
const PATHS: &str = "paths";

/// Kernels of which the C++ compiler gets some at a time: the name of what runs them, and their entry points.
pub const GROUPS: [(&str, &[&str]); 3] =
    [("path", &["renew", "find", "shade"]), ("inspect", &["inspect"]), ("reference", &["reference"])];

/// C++ of a group of kernels for several paths at once, complete but for what differs from level to level.
pub struct Lanes {
    /// Name of the group, and of the kernel that is entered.
    pub name: &'static str,
    /// The translated kernels, and constants and functions that `context.h` and `wave.h` use.
    pub text: String,
}

impl Lanes {
    /// Header that the text includes as `lanes.h`.
    pub const RUNTIME: &str = RUNTIME;

    /// Name of the file with the text.
    pub fn file(&self) -> String {
        format!("{}.lanes.inc", self.name)
    }

    /// Text of the C++ file for a level of instruction set.
    pub fn translation_unit(&self, suffix: &str, lanes: u32) -> String {
        let driver = if self.name == "path" { "wave.h" } else { "pixels.h" };
        format!(
            "#define LANES {lanes}\n#define LEVEL {suffix}\n#define KERNEL {}\n#include \"{}\"\n#include \"{driver}\"\n",
            self.name,
            self.file(),
        )
    }

    /// Translates the kernels of all groups in `code`, whose reflection stands beside it; `places` are the parameters' in
    /// C++.
    pub fn translate_all(code: &Path, declarations: &Declarations, places: &Places) -> Result<Vec<Self>, String> {
        let groups = GROUPS.iter();
        groups.map(|(name, entry_points)| Self::translate(name, entry_points, code, declarations, places)).collect()
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
            columns: vec![PATHS.into()],
            ..Options::default()
        };
        let translation = translate(&words, entry_points, &options).map_err(|e| format!("cannot translate the kernels: {e}"))?;
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
        for name in ["BLOCK"] {
            let value = declarations.constants.iter().find(|(constant, _)| constant == name);
            let (_, value) = value.ok_or(format!("the kernels have no constant `{name}`"))?;
            let _ = writeln!(text, "constexpr uint32_t {name} = {value};");
        }
        for name in ["work", "film", "resting"] {
            let _ = writeln!(text, "constexpr uint32_t {}_WORD = {};", name.to_uppercase(), places.word(name)?);
        }
        text += "\n/// Addresses of the kernels' buffers.\ninline void fill(Buffers& buffers, const uint64_t* globals) {\n";
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
