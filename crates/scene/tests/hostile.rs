//! Any text at all leads to an error or a sound scene, never to a panic, never to a wait.
//!
//! `RAGGIO_FUZZ_SECONDS` says how long the example is changed; the default is two seconds.

use std::time::{Duration, Instant};

use crate::common::{EXAMPLE, check_invariants, reference_scene};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::TestRunner;
use raggio_scene::Scene;

/// Time that is far more than any of these texts needs, even in a debug build on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

fn read(text: &str) {
    let start = Instant::now();
    match Scene::parse(text, "scene.toml") {
        Ok(scene) => check_invariants(&scene),
        Err(error) => check_error(&error, text),
    }
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

/// Checks that an error is one line of moderate length about a place that exists.
fn check_error(error: &raggio_scene::SceneError, text: &str) {
    assert!((1..=text.matches('\n').count() + 1).contains(&error.line), "{error}");
    let line = text.split('\n').nth(error.line - 1).unwrap();
    assert!((1..=line.chars().count() + 1).contains(&error.column), "{error}");
    assert!(!error.message.contains(char::is_control), "{error:?}");
    assert!(error.message.len() < 2000, "{error}");
}

const TOKENS: &[&str] = &[
    "version = 1\n",
    "version",
    "=",
    "\n",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    ",",
    ".",
    "\"",
    "'",
    "\"\"\"",
    "#",
    " ",
    "\r\n",
    "\t",
    "\u{feff}",
    "\u{0}",
    "\\",
    "ß",
    "\u{202e}",
    "[camera]\n",
    "[[shapes]]\n",
    "[[groups.a]]\n",
    "group = \"a\"\n",
    "transform = { scale = 2 }\n",
    "[shapes]\n",
    "[materials.red]\n",
    "[materials]\n",
    "[environment]\n",
    "[render]\n",
    "[[lights]]\n",
    "point = ",
    "spot = ",
    "directional = ",
    "direction = ",
    "angle_degrees = ",
    "position = ",
    "look_at = ",
    "up = ",
    "vertical_fov_degrees = ",
    "orthographic_height = ",
    "panorama = \"latitude-longitude\"\n",
    "intrinsics = { focal = [50, 50], size = [40, 30] }\n",
    "skew = ",
    "color = ",
    "\"#ff8800\"",
    "{ srgb = [1, 0.5, 0] }",
    "horizon = ",
    "zenith = ",
    "image = ",
    "material = ",
    "sphere = ",
    "plane = ",
    "rectangle = ",
    "box = ",
    "disk = ",
    "cylinder = ",
    "cone = ",
    "base = ",
    "top_radius = ",
    "mesh = ",
    "center = ",
    "radius = ",
    "scale = ",
    "reflection = ",
    "priority = ",
    "principled = ",
    "file = ",
    "time = ",
    "base_color_texture = ",
    "normal_map = ",
    "wrap = ",
    "{ image = \"a.png\" }",
    "\"a.ply\"",
    "[0, 1, 2]",
    "[1, 1]",
    "[[1], 2, 3]",
    "0",
    "1",
    "-1",
    "0x10",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "1e-400",
    "1_000",
    "1979-05-27T07:32:00Z",
    "true",
    "\"red\"",
    "'fresnel'",
    "red.green.blue",
    "{ center = [0, 0, 0], radius = 1 }\n",
];

/// Values that a number or string in the example may become.
const VALUES: &[&str] = &[
    "nan",
    "-nan",
    "inf",
    "-inf",
    "-1",
    "-0.0",
    "0",
    "1",
    "1e400",
    "-1e400",
    "1e300",
    "1e39",
    "1e15",
    "1e-15",
    "1e-14",
    "1e-46",
    "1e-300",
    "1e-400",
    "0.99999999999",
    "1.00000000001",
    "179.99999999999",
    "9223372036854775808",
    "99999999999999999999999999999999999999999999",
    "-170141183460469231731687303715884105729",
    "0xffffffffffffffffffffffffffffffffffff",
    "true",
    "\"red\"",
    "\"\"",
    "\"#f80\"",
    "\"#ff\"",
    "{ srgb = [1, 0.5, 0] }",
    "[]",
    "{}",
    "[1, 2, 3]",
    "2020-01-01",
    "{ x = 1 }",
];

#[derive(Clone, Debug)]
enum Change {
    DeleteLine(usize),
    DuplicateLine(usize),
    SwapLines(usize, usize),
    ReplaceLine(usize, &'static str),
    ReplaceValue(usize, &'static str),
    ReplaceByte(usize, u8),
    DeleteByte(usize),
    CutAfter(usize),
}

fn change() -> impl Strategy<Value = Change> {
    let any = any::<usize>;
    prop_oneof![
        1 => any().prop_map(Change::DeleteLine),
        1 => any().prop_map(Change::DuplicateLine),
        1 => (any(), any()).prop_map(|(a, b)| Change::SwapLines(a, b)),
        1 => (any(), select(TOKENS)).prop_map(|(at, token)| Change::ReplaceLine(at, token)),
        8 => (any(), select(VALUES)).prop_map(|(at, value)| Change::ReplaceValue(at, value)),
        2 => (any(), 0x20..0x7fu8).prop_map(|(at, byte)| Change::ReplaceByte(at, byte)),
        1 => any().prop_map(Change::DeleteByte),
        1 => any().prop_map(Change::CutAfter),
    ]
}

fn apply(text: &str, change: &Change) -> String {
    match *change {
        Change::ReplaceValue(at, value) => replace_value(text, at, value),
        Change::ReplaceByte(at, byte) => with_bytes(text, |bytes| {
            let at = at % bytes.len();
            bytes[at] = byte;
        }),
        Change::DeleteByte(at) => with_bytes(text, |bytes| {
            bytes.remove(at % bytes.len());
        }),
        Change::CutAfter(at) => with_bytes(text, |bytes| bytes.truncate(at % bytes.len() + 1)),
        Change::DeleteLine(at) => with_lines(text, |lines| {
            lines.remove(at % lines.len());
        }),
        Change::DuplicateLine(at) => with_lines(text, |lines| {
            let at = at % lines.len();
            lines.insert(at, lines[at]);
        }),
        Change::SwapLines(a, b) => with_lines(text, |lines| {
            let count = lines.len();
            lines.swap(a % count, b % count);
        }),
        Change::ReplaceLine(at, line) => with_lines(text, |lines| {
            let at = at % lines.len();
            lines[at] = line;
        }),
    }
}

fn with_bytes(text: &str, change: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut bytes = text.as_bytes().to_vec();
    if !bytes.is_empty() {
        change(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn with_lines(text: &str, change: impl FnOnce(&mut Vec<&str>)) -> String {
    let mut lines: Vec<&str> = text.split('\n').collect();
    change(&mut lines);
    lines.join("\n")
}

/// Replaces one number or string.
fn replace_value(text: &str, at: usize, value: &str) -> String {
    let ends = |c: char| " ,]}\n".contains(c);
    let starts: Vec<usize> = text
        .char_indices()
        .filter(|(_, c)| c.is_ascii_digit() || *c == '"')
        .map(|(start, _)| start)
        .filter(|start| text[..*start].ends_with([' ', '[']))
        .collect();
    if starts.is_empty() {
        return text.to_string();
    }
    let start = starts[at % starts.len()];
    let length = text[start..].find(ends).unwrap_or(text.len() - start);
    format!("{}{value}{}", &text[..start], &text[start + length..])
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn token_soup(tokens in prop::collection::vec(select(TOKENS), 0..60)) {
        read(&tokens.concat());
        read(&format!("version = 1\n{}", tokens.concat()));
    }

    #[test]
    fn bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn characters(text in "\\PC{0,200}") {
        read(&text);
        read(&format!("{EXAMPLE}{text}"));
    }

    #[test]
    fn changes_of_the_example(changes in prop::collection::vec(change(), 1..6)) {
        let text = changes.iter().fold(EXAMPLE.to_string(), |text, change| apply(&text, change));
        read(&text);
    }

    /// Numbers that are hard to keep in 32 bits stand at every place of the example.
    #[test]
    fn extreme_numbers(
        changes in prop::collection::vec((any::<usize>(), -1e16..1e16f64, -20..16i32), 1..8),
    ) {
        let text = changes.iter().fold(EXAMPLE.to_string(), |text, (at, mantissa, exponent)| {
            let value = format!("{:?}", mantissa * 1e-16 * 10f64.powi(*exponent));
            replace_value(&text, *at, &value)
        });
        read(&text);
    }
}

/// Changes the example and a reference scene for as many seconds as `RAGGIO_FUZZ_SECONDS` says, or two.
#[test]
fn fuzz_scenes() {
    let seconds = std::env::var("RAGGIO_FUZZ_SECONDS").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(2.0);
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let reference = std::fs::read_to_string(reference_scene("cornell")).unwrap();
    let texts = [EXAMPLE, &reference];
    let strategy = (0..texts.len(), prop::collection::vec(change(), 1..12));
    let mut scenes = 0;
    while Instant::now() < end {
        let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) };
        let outcome = TestRunner::new(config).run(&strategy, |(text, changes)| {
            read(&changes.iter().fold(texts[text].to_string(), |text, change| apply(&text, change)));
            Ok(())
        });
        outcome.unwrap();
        scenes += 100;
    }
    println!("{scenes} scenes read");
}

#[test]
fn every_value_in_every_place() {
    for at in 0..140 {
        for value in VALUES {
            read(&replace_value(EXAMPLE, at, value));
        }
    }
}

#[test]
fn every_beginning() {
    for end in 0..EXAMPLE.len() {
        read(&EXAMPLE[..end]);
    }
}

#[test]
fn deep_nesting() {
    let many = 200_000;
    for text in [
        format!("a = {}", "[".repeat(many)),
        format!("a = {}", "{a=".repeat(many)),
        format!("{}a = 1", "a.".repeat(many)),
        format!("[{}a]", "a.".repeat(many)),
        format!("[[{}a]]", "a.".repeat(many)),
        "[".repeat(many),
        "[a.b]\n".repeat(many),
    ] {
        read(&text);
        read(&format!("version = 1\n{text}"));
    }
}

#[test]
fn large_files() {
    let head = &EXAMPLE[..EXAMPLE.find("[[shapes]]").unwrap()];
    let sphere = "[[shapes]]\nmaterial = \"glass\"\nsphere = { center = [0, 1, 0], radius = 1 }\n";
    let many_shapes = format!("{head}{}", sphere.repeat(20_000));
    read(&many_shapes);
    read(&format!("{many_shapes}[[shapes]]\nmaterial = \"glas\"\n"));

    let materials: String = (0..20_000).map(|i| format!("[materials.m{i}]\npriority = 1\n")).collect();
    read(&format!("{EXAMPLE}{materials}"));
    read(&format!("{EXAMPLE}{materials}[[shapes]]\nmaterial = \"m\"\n"));

    let inline: String = (0..20_000).map(|i| format!("m{i} = {{ priority = 1 }}, ")).collect();
    let camera = "camera = { position = [0, 1, 4], look_at = [0, 1, 0], vertical_fov_degrees = 40 }";
    read(&format!("version = 1\n{camera}\nmaterials = {{ {inline} }}"));
}

#[test]
fn long_names() {
    let name = "x".repeat(1_000_000);
    read(&format!("{EXAMPLE}{name} = 1\n"));
    read(&format!("{EXAMPLE}[materials.{name}]\n[[shapes]]\nmaterial = \"{name}y\"\n"));
    read(&format!("{EXAMPLE}[[shapes]]\nmaterial = \"{}\"\n", "ß\u{1b}".repeat(100_000)));
    read(&EXAMPLE.replace("1280", &"9".repeat(1_000_000)));
    read(&EXAMPLE.replace("0.7", &format!("0.{}", "7".repeat(1_000_000))));
    read(&EXAMPLE.replace("\"box\"", &format!("\"{name}\"")));
}

#[test]
fn a_reference_scene_without_any_one_line() {
    let text = std::fs::read_to_string(reference_scene("cornell")).unwrap();
    for line in 0..text.lines().count() {
        read(&apply(&text, &Change::DeleteLine(line)));
        read(&apply(&text, &Change::DuplicateLine(line)));
    }
}
