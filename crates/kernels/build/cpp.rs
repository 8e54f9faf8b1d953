//! Compiles the generated C++ once for each level of instruction set.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use crate::cache::Cache;
use crate::lanes::Lanes;

/// Level of instruction set that kernels are compiled for.
#[derive(Clone, Copy)]
pub struct Level {
    /// Variant of the host's `InstructionSet`.
    name: &'static str,
    /// Ending of the symbols, and the level's name in `RAGGIO_KERNEL_LEVELS`.
    suffix: &'static str,
    /// Option of the C++ compiler.
    flag: Option<&'static str>,
    /// Number of paths that kernels follow at once; 1 for kernels of single paths alone.
    lanes: u32,
    /// Whether a read outside a buffer ends the program.
    checked: bool,
}

/// Levels to build, the most capable first: those that `RAGGIO_KERNEL_LEVELS` lists, separated by commas, or by default
/// all but `checked`. `native` is the best that this machine has, or the default where it builds for another; `all`
/// includes `checked`.
pub fn levels() -> Result<Vec<Level>, String> {
    println!("cargo:rerun-if-env-changed=RAGGIO_KERNEL_LEVELS");
    let all = all_levels();
    let listed = std::env::var("RAGGIO_KERNEL_LEVELS").unwrap_or_default();
    let names: Vec<&str> = listed.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
    let known = || all.iter().map(|level| level.suffix).chain(["native", "all"]);
    if let Some(name) = names.iter().find(|name| !known().any(|known| known == **name)) {
        let known: Vec<_> = known().collect();
        return Err(format!("RAGGIO_KERNEL_LEVELS names `{name}`, and there are {}", known.join(", ")));
    }
    let is_for_here = std::env::var("HOST") == std::env::var("TARGET");
    let means = |level: &Level, name: &str| match name {
        "all" => true,
        "native" if is_for_here => level.suffix == native(),
        "native" => !level.checked,
        name => level.suffix == name,
    };
    let wanted = |level: &Level| {
        if names.is_empty() { !level.checked } else { names.iter().any(|name| means(level, name)) }
    };
    Ok(all.into_iter().filter(wanted).collect())
}

fn all_levels() -> Vec<Level> {
    let level = |name, suffix, flag, lanes| Level { name, suffix, flag, lanes, checked: false };
    match std::env::var("CARGO_CFG_TARGET_ARCH").as_deref() {
        Ok("x86_64") => vec![
            level("X86V4", "v4", Some("-march=x86-64-v4"), 16),
            level("X86V3", "v3", Some("-march=x86-64-v3"), 8),
            level("X86V2", "v2", Some("-march=x86-64-v2"), 4),
            Level { checked: true, ..level("Checked", "checked", Some("-march=x86-64-v2"), 1) },
        ],
        _ => vec![
            level("Baseline", "baseline", None, 4),
            Level { checked: true, ..level("Checked", "checked", None, 1) },
        ],
    }
}

/// Suffix of the best level that the machine which builds has.
#[cfg(target_arch = "x86_64")]
fn native() -> &'static str {
    match crate::x86::level() {
        4 => "v4",
        3 => "v3",
        _ => "v2",
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn native() -> &'static str {
    "baseline"
}

/// Files of the package's folder `cpp`, which stand beside the generated ones.
const WRITTEN_BY_HAND: [(&str, &str); 6] = [
    ("rays.h", include_str!("../cpp/rays.h")),
    ("traversal.h", include_str!("../cpp/traversal.h")),
    ("hook.h", include_str!("../cpp/hook.h")),
    ("context.h", include_str!("../cpp/context.h")),
    ("wave.h", include_str!("../cpp/wave.h")),
    ("pixels.h", include_str!("../cpp/pixels.h")),
];

/// Words behind the kernels' parameters in which the host passes its `Traversal`, and its `Counts`.
pub const TRAVERSAL_WORD: usize = 15;
pub const COUNTS_WORD: usize = 16;

/// C++ of all kernels, in the parts that the C++ compiler gets.
pub struct Sources {
    prelude: String,
    kernels: String,
    entry_points: Vec<String>,
    lanes: Vec<Lanes>,
}

/// Kernels that the C++ compiler gets at once.
pub struct Unit<'a> {
    level: &'a Level,
    /// Kernels for several paths; `None` for those of single paths.
    lanes: Option<&'a Lanes>,
}

impl Unit<'_> {
    /// Name of the library that the unit becomes.
    fn library(&self) -> String {
        let part = self.lanes.map_or("kernels", |lanes| lanes.name);
        format!("raggio_{part}_{}", self.level.suffix)
    }
}

impl Sources {
    /// Splits the file `generated` into prelude and kernels, and writes both into the folder `out`, beside `lanes`.
    pub fn write(generated: &Path, entry_points: &[String], lanes: Vec<Lanes>, out: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(generated).map_err(|e| format!("cannot read slangc's C++: {e}"))?;
        // slangc puts its prelude at the head of the file; the prelude ends with its last conditional.
        let end = text.rfind("#endif").map(|i| i + "#endif".len()).ok_or("slangc's C++ has no prelude")?;
        let (prelude, kernels) = text.split_at(end);
        let kernels = hooked(&inlined(kernels)?)?;
        let sources = Self { prelude: prelude.into(), kernels, entry_points: entry_points.to_vec(), lanes };
        write(&out.join("slang_prelude.h"), &sources.prelude)?;
        write(&out.join("kernels.inc"), &sources.kernels)?;
        write(&out.join("lanes.h"), Lanes::RUNTIME)?;
        for lanes in &sources.lanes {
            write(&out.join(lanes.file()), &lanes.text)?;
        }
        for (name, text) in WRITTEN_BY_HAND {
            write(&out.join(name), text)?;
        }
        Ok(sources)
    }

    /// All there is to compile for `levels`, what takes longest first.
    pub fn units<'a>(&'a self, levels: &'a [Level]) -> Vec<Unit<'a>> {
        let lanes = levels.iter().flat_map(|level| {
            let lanes = self.lanes.iter().filter(|lanes| lanes.are_of(level.lanes));
            lanes.map(move |lanes| Unit { level, lanes: Some(lanes) })
        });
        lanes.chain(levels.iter().map(|level| Unit { level, lanes: None })).collect()
    }

    /// Compiles `unit` into a library in the folder `out`.
    pub fn compile(&self, cache: &Cache, unit: &Unit<'_>, out: &Path) -> Result<(), String> {
        let (level, library) = (unit.level, unit.library());
        let file = out.join(format!("{library}.cpp"));
        let text = match unit.lanes {
            Some(lanes) => lanes.translation_unit(level.suffix, level.lanes),
            None => translation_unit(level.suffix, &self.single(level)),
        };
        write(&file, &text)?;

        let mut build = compiler_of_kernels();
        build.std("c++17").opt_level(3).debug(false).warnings(false).file(&file);
        // Kernels use nothing of the C++ library. Lines for cargo are printed by `link`, where results are kept too.
        build.cargo_metadata(false).cpp_link_stdlib(None);
        if level.checked {
            build.define("SLANG_PRELUDE_ENABLE_ASSERT", None);
        }
        // No fused multiply-add, so that every instruction set gives the same bits. No fast-math: NaN must stay NaN.
        for option in ["-fno-math-errno", "-fno-trapping-math", "-fno-strict-aliasing", "-ffp-contract=off"] {
            build.flag_if_supported(option);
        }
        build.flag_if_supported("-fno-exceptions").flag_if_supported("-fno-rtti");
        if let Some(flag) = level.flag {
            build.flag(flag);
        }
        let failed = |e: cc::Error| {
            format!(
                "the C++ compiler that builds the CPU kernels failed or is missing: install g++ or clang++ (Debian and Ubuntu: apt install g++; Fedora: dnf install gcc-c++; macOS: xcode-select --install), or name it in $CXX. {e}"
            )
        };

        let compiler = build.try_get_compiler().map_err(failed)?;
        let version = version_of(compiler.path()).unwrap_or_default();
        // Flags name no folder, so that all profiles share what is kept: the unit finds its parts beside it.
        let recipe = format!("{:?} {:?}", compiler.path(), compiler.args());
        let file = if compiler.is_like_msvc() { format!("{library}.lib") } else { format!("lib{library}.a") };
        let parts: [&str; 2] = match unit.lanes {
            Some(lanes) => [Lanes::RUNTIME, &lanes.text],
            None => [&self.prelude, &self.kernels],
        };
        let by_hand = WRITTEN_BY_HAND.iter().map(|&(_, text)| text);
        let sources: Vec<&str> = [&*version, &recipe, &text].into_iter().chain(parts).chain(by_hand).collect();
        cache.get(&sources, out, &[file], || build.try_compile(&library).map_err(failed))
    }

    /// Entry points of kernels of single paths that a level has.
    fn single(&self, level: &Level) -> Vec<String> {
        let elsewhere =
            |entry: &String| self.lanes.iter().any(|lanes| lanes.name == entry && lanes.are_of(level.lanes));
        self.entry_points.iter().filter(|entry| !elsewhere(entry)).cloned().collect()
    }

    /// Has the libraries of all units of `levels` linked.
    pub fn link(&self, levels: &[Level], out: &Path) {
        println!("cargo:rustc-link-search=native={}", out.display());
        for unit in self.units(levels) {
            println!("cargo:rustc-link-lib=static={}", unit.library());
        }
        let target = std::env::var("TARGET").unwrap_or_default();
        for variable in ["CXX", "CXXFLAGS"] {
            println!("cargo:rerun-if-env-changed={variable}");
            println!("cargo:rerun-if-env-changed={variable}_{target}");
            println!("cargo:rerun-if-env-changed={variable}_{}", target.replace('-', "_"));
        }
    }
}

/// The C++ compiler for kernels: the one that `$CXX` names, or clang, whose code is a sixth faster, or the system's.
fn compiler_of_kernels() -> cc::Build {
    let mut build = cc::Build::new();
    build.cpp(true);
    let target = std::env::var("TARGET").unwrap_or_default();
    let named = ["CXX".to_owned(), format!("CXX_{target}"), format!("CXX_{}", target.replace('-', "_"))];
    let is_for_here = std::env::var("HOST").is_ok_and(|host| host == target);
    if is_for_here && !target.contains("msvc") && named.iter().all(|variable| std::env::var_os(variable).is_none()) {
        let names = (OLDEST_CLANG..=NEWEST_CLANG).rev().map(|version| format!("clang++-{version}"));
        // Every unit asks, and one answer is enough.
        static FOUND: OnceLock<Option<String>> = OnceLock::new();
        let found = || names.chain(["clang++".to_owned()]).find(|name| is_recent_clang(name));
        if let Some(clang) = FOUND.get_or_init(found) {
            build.compiler(clang);
        }
    }
    build
}

/// Versions of clang that are looked for; older ones have not been tried.
const OLDEST_CLANG: u32 = 16;
const NEWEST_CLANG: u32 = 22;

fn is_recent_clang(name: &str) -> bool {
    let version = version_of(Path::new(name)).unwrap_or_default();
    let number = version.split("clang version ").nth(1).and_then(|rest| rest.split('.').next()?.parse().ok());
    number.is_some_and(|number: u32| number >= OLDEST_CLANG)
}

/// Text in which a compiler says its version; `None` where it does not run.
fn version_of(compiler: &Path) -> Option<String> {
    let output = Command::new(compiler).arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Name and version of the C++ compiler for kernels, as people write them.
pub fn compiler_name() -> String {
    let Ok(compiler) = compiler_of_kernels().try_get_compiler() else { return "unknown compiler".into() };
    let version = version_of(compiler.path()).unwrap_or_default();
    let number = |words: &str| {
        let is_version = |word: &&str| word.contains('.') && word.starts_with(|c: char| c.is_ascii_digit());
        words.split([' ', '\n', '(', ')', '-', '+']).find(is_version).unwrap_or_default().to_owned()
    };
    let kind = if compiler.is_like_clang() {
        "clang"
    } else if compiler.is_like_gnu() {
        "gcc"
    } else {
        "msvc"
    };
    format!("{kind} {}", number(&version)).trim().to_owned()
}

/// Functions, by how their names begin, that are long and called from several places: a call costs little beside what
/// they do, and a copy for every caller costs minutes of the C++ compiler's time.
const CALLED: [&str; 22] = [
    "sobol4D",
    "RoughBoundary_",
    "sheenAlbedo",
    "PrincipledBsdf_evaluate",
    "PrincipledBsdf_x24init",
    "PrincipledFresnel_split",
    "PrincipledPoint_x24init",
    "attributesAt",
    "shapeAttributes",
    "triangleIsThere",
    "firstThere",
    "trace_",
    "walk_",
    "traceClosestBruteForce",
    "nextVertex",
    "chooseLight",
    "emission",
    "pdfOfLight",
    "probabilityOfLight",
    "sampleLights",
    "Bsdf_look",
    "ask",
];

/// Puts every function that is not [`CALLED`] into its callers, which doubles the speed: the vectors of the generated
/// code stay in registers. slangc exports the constructors it makes up; they become local like the rest, or the levels'
/// symbols would collide. A name in [`CALLED`] that no function begins with is an error: what was meant has another
/// name by now.
fn inlined(kernels: &str) -> Result<String, String> {
    let mut unused = Vec::from(CALLED);
    let mut text = String::with_capacity(2 * kernels.len());
    for line in kernels.replace("extern \"C\"\n", "static ").lines() {
        let Some(declaration) = line.strip_prefix("static ") else {
            text += line;
            text.push('\n');
            continue;
        };
        let name = declaration.split('(').next().and_then(|head| head.rsplit([' ', '*']).next()).unwrap_or_default();
        unused.retain(|start| !name.starts_with(start));
        let called = CALLED.iter().any(|start| name.starts_with(start));
        let kind = if called { "noinline" } else { "always_inline" };
        let _ = writeln!(text, "static {}__attribute__(({kind})) {declaration}", if called { "" } else { "inline " });
    }
    match &unused[..] {
        [] => Ok(text),
        names => Err(format!(
            "no function of the kernels begins with {names:?}: correct CALLED in crates/kernels/build/cpp.rs"
        )),
    }
}

/// Puts the walk that is written by hand in the place of the generated one: that gets another name, and `cpp/hook.h` chooses
/// between the two.
fn hooked(kernels: &str) -> Result<String, String> {
    const OWN_WALK: &str = "walkAsGenerated";
    let missing = |name: &str| format!("the generated kernels have no function {name} of the form that hook.h expects");
    let names = |start: &str| {
        kernels
            .lines()
            .filter(|line| line.starts_with("static "))
            .filter_map(Declaration::read)
            .find(|declaration| declaration.name.starts_with(start))
            .ok_or_else(|| missing(start))
    };
    let (walk, triangle, first) = (names("walk_")?, names("triangleIsThere_")?, names("firstThere_")?);
    let [ray, _, _, hit, context] = &walk.parameters[..] else { return Err(missing("walk")) };
    let definition = format!(" {}(", walk.name);
    let mut text = String::with_capacity(kernels.len() + 4096);
    for line in kernels.lines() {
        if line == walk.line {
            let _ = writeln!(text, "{line};");
            text += &line.replacen(&definition, &format!(" {OWN_WALK}("), 1);
        } else {
            text += line;
        }
        text.push('\n');
    }
    for (name, value) in [
        ("HIT", *hit),
        ("RAY", *ray),
        ("CONTEXT", *context),
        ("WALK", walk.name),
        ("OWN_WALK", OWN_WALK),
        ("TRIANGLE_IS_THERE", triangle.name),
        ("FIRST_THERE", first.name),
        ("TRAVERSAL_WORD", &TRAVERSAL_WORD.to_string()),
        ("COUNTS_WORD", &COUNTS_WORD.to_string()),
    ] {
        let _ = writeln!(text, "#define KERNEL_{name} {value}");
    }
    text += "#include \"hook.h\"\n";
    Ok(text)
}

/// Head of a generated function.
struct Declaration<'a> {
    line: &'a str,
    name: &'a str,
    /// Types of the parameters, without what makes pointers of them.
    parameters: Vec<&'a str>,
}

impl<'a> Declaration<'a> {
    fn read(line: &'a str) -> Option<Self> {
        // Attributes stand before the type of the result.
        let head = line.rsplit("__attribute__((").next()?;
        let head = head.split_once(")) ").map_or(head, |(_, head)| head);
        let (head, parameters) = head.strip_suffix(')')?.split_once('(')?;
        let (_, name) = head.rsplit_once(' ')?;
        let parameters = parameters.split(", ").filter_map(|parameter| parameter.split(' ').next()).collect();
        Some(Self { line, name, parameters })
    }
}

fn translation_unit(suffix: &str, entry_points: &[String]) -> String {
    let mut text = format!("#define LEVEL {suffix}\n");
    text += "#include <cmath>\n#include <float.h>\n#include <math.h>\n#include <assert.h>\n#include <stdint.h>\n#include <stdlib.h>\n#include <string.h>\n\
         namespace {\n\
         // The C library's calls are not inlined and cost two thirds of the speed.\n\
         inline float raggio_min(float a, float b) { return a < b ? a : b; }\n\
         inline float raggio_max(float a, float b) { return a > b ? a : b; }\n\
         #define fminf raggio_min\n\
         #define fmaxf raggio_max\n\
         #include \"slang_prelude.h\"\n\
         #undef SLANG_PRELUDE_EXPORT\n\
         #define SLANG_PRELUDE_EXPORT static\n\
         #include \"kernels.inc\"\n\
         }\n";
    for entry in entry_points {
        let _ = write!(
            text,
            "extern \"C\" void raggio_{entry}_{suffix}(const uint32_t* groups, void* globals) {{\n\
             \x20   ComputeVaryingInput input = {{}};\n\
             \x20   input.endGroupID = uint3{{groups[0], groups[1], groups[2]}};\n\
             \x20   {entry}(&input, nullptr, globals);\n\
             }}\n"
        );
    }
    text
}

/// Variant of `EntryPoint` for the entry point of this name.
pub fn variant_name(entry: &str) -> String {
    entry[..1].to_uppercase() + &entry[1..]
}

/// Writes `cpu_table.rs`: Rust declarations of the compiled entry points and the choice among them.
pub fn write_table(levels: &[Level], entry_points: &[String], out: &Path) -> Result<(), String> {
    let mut text = String::from("unsafe extern \"C\" {\n");
    let (mut choices, mut walks, mut widths) = (String::new(), String::new(), String::new());
    for Level { name, suffix, lanes, .. } in levels {
        let mut choice = |entry: &str, (simple, media): (&str, &str), function: &str| {
            let _ = writeln!(text, "    fn raggio_{function}_{suffix}(groups: *const [u32; 3], globals: *const u64);");
            let variant = variant_name(entry);
            let _ = writeln!(
                choices,
                "        (InstructionSet::{name}, EntryPoint::{variant}, {simple}, {media}) => Some(raggio_{function}_{suffix}),"
            );
        };
        if *lanes > 1 {
            choice("path", ("true", "_"), "path_simple");
            choice("path", ("false", "true"), "path_media");
        }
        for entry in entry_points {
            choice(entry, ("_", "_"), entry);
        }
        let _ = writeln!(
            text,
            "    fn raggio_walk_{suffix}(globals: *const u64, rays: *const TracedRay, hits: *mut TracedHit, count: u32);"
        );
        let _ = writeln!(walks, "        InstructionSet::{name} => Some(raggio_walk_{suffix}),");
        let _ = writeln!(widths, "        InstructionSet::{name} => {lanes},");
    }
    text +=
        "}\n\n/// Levels that this build contains, the most capable first.\npub const BUILT: &[InstructionSet] = &[";
    for Level { name, .. } in levels {
        let _ = write!(text, "InstructionSet::{name}, ");
    }
    let _ = write!(
        text,
        "];\n\n/// C++ compiler that made the machine code.\npub const COMPILER: &str = {:?};\n",
        compiler_name()
    );
    let _ = writeln!(
        text,
        "\n/// Words behind the parameters of the kernels in which hand-written code finds its `Traversal`, and its `Counts`.\nconst TRAVERSAL_WORD: usize = {TRAVERSAL_WORD};\nconst COUNTS_WORD: usize = {COUNTS_WORD};"
    );
    text += "\n/// Function for `entry`, of those that know of principled materials and lights that are no surfaces or, if `simple`, need not, and of\n/// those that know of media, or need not.\n\
             fn entry_point(set: InstructionSet, entry: EntryPoint, simple: bool, media: bool) -> Option<Kernel> {\n    match (set, entry, simple, media) {\n";
    text += &choices;
    text += "        #[allow(unreachable_patterns)]\n        _ => None,\n    }\n}\n";
    text += "\n/// Function that follows given rays.\nfn walk_function(set: InstructionSet) -> Option<WalkFunction> {\n    match set {\n";
    text += &walks;
    text += "        #[allow(unreachable_patterns)]\n        _ => None,\n    }\n}\n";
    text += "\n/// Number of paths that the path tracer follows at once; 0 for levels that this build lacks.\nfn lanes(set: InstructionSet) -> u32 {\n    match set {\n";
    text += &widths;
    text += "        #[allow(unreachable_patterns)]\n        _ => 0,\n    }\n}\n";
    write(&out.join("cpu_table.rs"), &text)
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))
}
