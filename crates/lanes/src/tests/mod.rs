//! Kernels at 1, 4, 8 and 16 lanes against an interpreter of the same SPIR-V, with any lanes active and anything in the
//! others.

mod assembly;
mod interpreter;
mod kernels;
mod random;

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::module::Module;
use crate::{Error, Options, RUNTIME, translate};
use assembly::{Given, Kernel, Source, WORDS, assemble};
use interpreter::{Buffers, Interpreter};
use random::Random;

/// Invocations of each kernel.
const COUNT: usize = 48;
/// Words of an invocation's element in `states`, and of one in `items`, of which there are 16.
const STATE: usize = 11;
const ITEM: usize = 18;

/// Numbers of lanes, options of the compiler for them on x86-64, and whether this processor can run the result.
fn levels() -> Vec<(&'static str, u32, Vec<&'static str>, bool)> {
    #[cfg(target_arch = "x86_64")]
    let (v2, v3, v4) = (
        is_x86_feature_detected!("sse4.2"),
        is_x86_feature_detected!("avx2"),
        is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512vl"),
    );
    #[cfg(not(target_arch = "x86_64"))]
    let (v2, v3, v4) = (false, false, false);
    vec![
        ("1", 1, vec![], true),
        ("4 of any processor", 4, vec![], true),
        ("4", 4, vec!["-march=x86-64-v2"], v2),
        ("8", 8, vec!["-march=x86-64-v3"], v3),
        ("16", 16, vec!["-march=x86-64-v4"], v4),
    ]
}

/// What one kernel is given: words of its input, and which invocations run.
struct Inputs {
    active: Vec<u32>,
    input: Vec<u32>,
}

fn inputs(given: Given, random: &mut Random) -> Inputs {
    let float = |random: &mut Random| match random.below(8) {
        0 => [0.0, -0.0, 1.0, -1.0, 0.5, 2.0][random.below(6) as usize],
        1 if given == Given::Floats => {
            let special = [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-40, -1e-42, f32::MAX, 3e38];
            special[random.below(7) as usize]
        }
        2 => random.below(16) as f32,
        _ => (random.word() as f32 / 2f32.powi(31) - 1.0) * 1000.0,
    };
    let mut active: Vec<u32> = (0..COUNT).map(|_| u32::from(random.below(4) > 0)).collect();
    // One group of lanes at each number of them without any that is active, and one with all.
    active[..16].fill(0);
    active[32..].fill(1);
    let mut input: Vec<u32> = (0..COUNT * WORDS)
        .map(|_| match given {
            Given::Words if random.below(4) == 0 => random.below(8),
            Given::Words => random.word(),
            Given::Floats => float(random).to_bits(),
            Given::Moderate => float(random).abs().to_bits(),
        })
        .collect();
    for (invocation, words) in input.chunks_mut(WORDS).enumerate() {
        if active[invocation] == 0 {
            words.iter_mut().for_each(|word| *word = [f32::NAN.to_bits(), u32::MAX, 0][random.below(3) as usize]);
        }
    }
    Inputs { active, input }
}

fn table(random: &mut Random) -> Vec<u32> {
    (0..16 * ITEM).map(|_| (random.word() as f32 / 2f32.powi(20)).to_bits()).collect()
}

/// C++ that runs all kernels on what it reads from a file, and writes what they leave.
fn harness(kernels: &[Kernel]) -> String {
    let mut text = String::from(
        "#include \"kernels.inc\"\n#include <stdio.h>\n#include <vector>\nusing namespace lanes;\nnamespace {\n\
         struct Context {\n const char* work; Buffers buffers; Columns states;\n\
         \u{20}__attribute__((noinline)) void hook(Mask mask, Uint a, Uint p, Uint& result, Uint& left) const {\n\
         \u{20} result = choose(mask, a * 3u + p, splat(0xdeadbeefu));\n\
         \u{20} left = choose(mask, p ^ a, splat(0x7fc00000u));\n }\n};\n\
         typedef void (*Kernel)(const Context&, Mask, Uint, Uint, Uint);\nconst Kernel KERNELS[] = {\n",
    );
    for Kernel { name, .. } in kernels {
        let _ = writeln!(text, " {name}<Context>,");
    }
    let _ = write!(
        text,
        "}};\ntypedef std::vector<uint32_t> Words;\n\
         void read(Words& words, FILE* file) {{ if (fread(words.data(), 4, words.size(), file) != words.size()) throw 1; }}\n\
         }}\nint main(int, char** paths) {{\n FILE* in = fopen(paths[1], \"rb\"), *out = fopen(paths[2], \"wb\");\n\
         \u{20}Words table({table}); read(table, in);\n for (Kernel kernel : KERNELS) {{\n\
         \u{20} Words active({COUNT}), input({COUNT} * {WORDS}), output({COUNT} * {WORDS}), states({COUNT} * {STATE});\n\
         \u{20} read(active, in); read(input, in); read(states, in);\n\
         \u{20} for (uint32_t first = 0; first < {COUNT}; first += LANES) {{\n\
         \u{20}  Context context = {{}};\n   context.buffers.input = (char*)input.data();\n\
         \u{20}  context.buffers.output = (char*)output.data();\n   context.buffers.items = (char*)table.data();\n\
         \u{20}  context.states = {{(float*)states.data() + first, {COUNT}}};\n   Uint at, on;\n\
         \u{20}  for (int i = 0; i < LANES; i++) set_lane(at, i, first + i), set_lane(on, i, active[first + i]);\n\
         \u{20}  kernel(context, not_equal(on, splat(0u)), at, splat(0u), splat(0u));\n  }}\n\
         \u{20} fwrite(output.data(), 4, output.size(), out); fwrite(states.data(), 4, states.size(), out);\n }}\n\
         \u{20}fclose(out);\n}}\n",
        table = 16 * ITEM,
    );
    text
}

fn build(folder: &Path, name: &str, lanes: u32, options: &[&str]) -> PathBuf {
    let program = folder.join(format!("lanes{}", name.replace(' ', "-")));
    let output = Command::new(std::env::var_os("CXX").unwrap_or("c++".into()))
        .args(["-std=c++17", "-O1", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-w"])
        .args(["-fno-strict-aliasing", &format!("-DLANES={lanes}")])
        .args(options)
        .arg(folder.join("harness.cpp"))
        .arg("-o")
        .arg(&program)
        .output()
        .expect("there is a C++ compiler");
    assert!(output.status.success(), "{name} lanes: {}", String::from_utf8_lossy(&output.stderr));
    program
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn options() -> Options {
    Options {
        hooks: vec!["hook".into()],
        calls: vec!["called".into()],
        columns: vec!["states".into()],
        specialisation: HashMap::new(),
    }
}

#[test]
fn lanes_agree_with_the_interpreter() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut source = Source::default();
    kernels::instructions(&mut source);
    kernels::memory(&mut source);
    for i in 0..random_kernels() {
        random::kernel(&mut source, &format!("random{i}"), &mut random);
    }
    let folder = tempfile::tempdir().expect("there is room for temporary files");
    let Some(module) = assemble(&source.text(), folder.path()) else { return };
    let names: Vec<_> = source.kernels.iter().map(|kernel| &*kernel.name).collect();
    let translation = translate(&module, &names, &options()).expect("all of it has a translation");
    for (name, text) in
        [("lanes.h", RUNTIME), ("kernels.inc", &translation.code), ("harness.cpp", &harness(&source.kernels))]
    {
        std::fs::write(folder.path().join(name), text).expect("the folder is writable");
    }

    // What the interpreter makes of it.
    let module = Module::read(&module, &HashMap::new()).expect("it is valid");
    let table = table(&mut random);
    let (mut given, mut expected) = (table.clone(), vec![]);
    for (kernel, (_, entry)) in source.kernels.iter().zip(&module.entry_points) {
        let Inputs { active, input } = inputs(kernel.given, &mut random);
        let states: Vec<u32> = (0..COUNT * STATE).map(|_| random.below(8)).collect();
        let mut buffers = Buffers::from([
            ("input".into(), input.clone()),
            ("output".into(), vec![0; COUNT * WORDS]),
            ("items".into(), table.clone()),
            ("states".into(), transposed(&states, COUNT)),
        ]);
        given.extend([&active[..], &input, &states].concat());
        for (invocation, _) in active.iter().enumerate().filter(|(_, active)| **active != 0) {
            Interpreter::run(&module, *entry, invocation as u32, &mut buffers);
        }
        expected.push([&buffers["output"][..], &transposed(&buffers["states"], STATE)].concat());
    }
    let given: Vec<u8> = given.into_iter().flat_map(u32::to_le_bytes).collect();
    std::fs::write(folder.path().join("given"), given).expect("the folder is writable");

    for (name, lanes, options, runs) in levels() {
        if !runs {
            eprintln!("not checked: this processor lacks what {name} lanes need");
            continue;
        }
        let program = build(folder.path(), name, lanes, &options);
        let result = folder.path().join("result");
        let status = Command::new(program).arg(folder.path().join("given")).arg(&result).status();
        assert!(status.expect("it runs").success(), "{name} lanes");
        let result = words(&std::fs::read(&result).expect("it was written"));
        for ((kernel, expected), result) in source.kernels.iter().zip(&expected).zip(result.chunks(expected[0].len())) {
            for (i, (result, expected)) in result.iter().zip(expected).enumerate() {
                let is_nan = |word: u32| kernel.given != Given::Words && f32::from_bits(word).is_nan();
                let same = result == expected || is_nan(*result) && is_nan(*expected);
                let place = if i < COUNT * WORDS { (i / WORDS, i % WORDS) } else { (i % COUNT, i / COUNT) };
                assert!(same, "{name} lanes, {}, {place:?}: {result:#x}, not {expected:#x}", kernel.name);
            }
        }
    }
}

/// Random kernels of a run: `RAGGIO_LANES_KERNELS` asks for more.
fn random_kernels() -> u32 {
    std::env::var("RAGGIO_LANES_KERNELS").ok().and_then(|count| count.parse().ok()).unwrap_or(60)
}

/// A matrix of `rows` rows, with rows and columns exchanged.
fn transposed(words: &[u32], rows: usize) -> Vec<u32> {
    let columns = words.len() / rows;
    (0..words.len()).map(|i| words[i % columns * rows + i / columns]).collect()
}

#[test]
fn transposition() {
    assert_eq!(transposed(&[1, 2, 3, 4, 5, 6], 3), [1, 4, 2, 5, 3, 6]);
}

/// Error of translating one kernel with this body.
fn error_of(body: &str) -> Option<Error> {
    let mut source = Source::default();
    source.kernel("kernel", Given::Words, body);
    let folder = tempfile::tempdir().expect("there is room for temporary files");
    let module = assemble(&source.text(), folder.path())?;
    Some(translate(&module, &["kernel_"], &options()).expect_err("it has no translation"))
}

#[test]
fn errors_name_instruction_and_function() {
    let Some(error) = error_of("%@r = OpFMod %float %@f0 %@f1\n") else { return };
    assert_eq!(error, Error::Unsupported { instruction: "OpFMod".into(), function: "kernel_".into() });
    let Some(error) = error_of("%@r = OpExtInst %float %glsl Degrees %@f0\n") else { return };
    assert_eq!(error.to_string(), "Degrees of GLSL.std.450 in kernel_ has no translation");
    let Some(error) = error_of("%@r = OpAccessChain %toWord %states %c0 %@u0 %c0\n") else { return };
    assert!(error.to_string().contains("`states`"), "{error}");
}

#[test]
fn damaged_modules_are_errors() {
    assert!(matches!(translate(&[], &["kernel"], &options()), Err(Error::Malformed(_))));
    let header = [0x0723_0203, 0x0001_0400, 0, 8, 0];
    let missing = translate(&header, &["kernel"], &options());
    assert_eq!(missing.unwrap_err(), Error::Missing("kernel".into()));
    assert!(matches!(translate(&[&header[..], &[5 << 16 | 43]].concat(), &[], &options()), Err(Error::Malformed(_))));
}
