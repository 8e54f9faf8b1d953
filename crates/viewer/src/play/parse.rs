//! Parser of scripts: the text goes in, its steps come out.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::LazyLock;
use std::time::Duration;

use egui::{Key, Modifiers, PointerButton, Pos2};
use raggio_render::{Choice, Comparison, ToneMapper, View};
use raggio_scene::{Geometry, Vec3};

use super::{Span, Step, WindowStep};
use crate::command::{Command, Edit, ExportRequest, Navigate};
use crate::error::ViewError;
use crate::navigation::Preset;

/// Parses a script: one step for each line that is neither empty nor a comment.
pub fn steps(text: &str, file: &str) -> Result<Vec<Step>, ViewError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    lines
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .map(|(line, text)| step(text).map_err(|message| ViewError::Script { file: file.to_owned(), line, message }))
        .collect()
}

/// The words that a line may begin with, and what follows each.
pub static WORDS: LazyLock<Vec<(&str, String)>> = LazyLock::new(|| {
    let words: &[(&str, &str)] = &[
        ("wait", "30 frames | 1.5 s | 64 samples | export | denoised | 1 reloads | 1 saves | 1 kernels"),
        ("press", "F1 | Ctrl+Z | …"),
        ("hold", "W 1 s | Shift+D 30 frames"),
        ("move", "X,Y"),
        ("click", "left|middle|right X,Y"),
        ("double-click", "left|middle|right X,Y"),
        ("drag", "[Shift+]left|middle|right X,Y X,Y over 1 s | 30 frames"),
        ("wheel", "NOTCHES"),
        ("orbit", "DEGREES over 5 s | 120 frames"),
        ("home", ""),
        (
            "camera",
            "TEXT of the table [camera] in one line, as in position=[0,1,4] look_at=[0,1,0] vertical_fov_degrees=40",
        ),
        ("preset", &one_of::<Preset>()),
        ("set", "KEY VALUE, as in materials.red.color [1, 0, 0]"),
        ("select", "NUMBER | none"),
        ("delete", ""),
        ("duplicate", ""),
        ("add", "sphere X,Y,Z RADIUS"),
        ("undo", ""),
        ("redo", ""),
        ("save", "[FILE]"),
        ("reload", ""),
        ("open", "FILE"),
        ("view", &one_of::<View>()),
        ("exposure", "STOPS"),
        ("tones", &one_of::<ToneMapper>()),
        ("denoise", "on | off"),
        ("denoise-in-motion", "auto | always | never"),
        ("reference", "FILE | none"),
        ("compare", &one_of::<Comparison>()),
        ("scene-size", "on | off"),
        ("fill", "on | off"),
        ("pause", ""),
        ("restart", ""),
        ("stop-at", "SAMPLES | never"),
        ("samples-per-frame", "N | auto"),
        ("panels", ""),
        ("help", ""),
        ("export", "FILE [WxH] [SAMPLES]"),
        ("screenshot", "FILE"),
        ("size", "WxH"),
        ("scale", "PIXELS-PER-POINT"),
        ("minimise", ""),
        ("restore", ""),
        ("section", "NAME | end"),
        ("lose-device", ""),
        ("quit", ""),
    ];
    words.iter().map(|(word, form)| (*word, (*form).to_owned())).collect()
});

/// Names of a choice, as the form of a line shows them.
fn one_of<T: Choice>() -> String {
    T::NAMES.join(" | ")
}

fn step(line: &str) -> Result<Step, String> {
    let (word, rest) = split(line);
    let Some((_, form)) = WORDS.iter().find(|(known, _)| *known == word) else {
        let known: Vec<_> = WORDS.iter().map(|(word, _)| *word).collect();
        return Err(format!("unknown word `{word}`: a line begins with one of {}", known.join(", ")));
    };
    let wanted = || format!("write `{}`", format!("{word} {form}").trim());
    match word {
        "open" | "save" | "screenshot" | "reference" | "export" => file_step(word, rest),
        "set" => {
            let (key, value) = split(rest);
            let change = Edit::Key(key.to_owned(), value.to_owned());
            (!value.is_empty()).then_some(Step::Do(Command::Edit(change)))
        }
        "select" if rest == "0" => return Err("shapes are counted from 1: write `select 1` for the first".to_owned()),
        "camera" => return camera(rest).map(|camera| Step::Do(Command::PasteCamera(camera))),
        _ if form.is_empty() && rest.is_empty() => plain(word),
        _ => parameters(word, &rest.split_whitespace().collect::<Vec<_>>()),
    }
    .ok_or_else(wanted)
}

/// Parses lines of a single word.
fn plain(word: &str) -> Option<Step> {
    Some(match word {
        "minimise" => Step::Window(WindowStep::Minimise),
        "restore" => Step::Window(WindowStep::Restore),
        _ => Step::Do(match word {
            "home" => Command::Navigate(Navigate::Home),
            "delete" => Command::RemoveSelected,
            "duplicate" => Command::DuplicateSelected,
            "undo" => Command::Undo,
            "redo" => Command::Redo,
            "reload" => Command::Reload,
            "pause" => Command::Pause,
            "restart" => Command::Restart,
            "panels" => Command::Panels,
            "help" => Command::Help,
            "lose-device" => Command::LoseDevice,
            "quit" => Command::Quit,
            _ => return None,
        }),
    })
}

/// Parses lines that end in the name of a file, which may have spaces if nothing follows.
fn file_step(word: &str, rest: &str) -> Option<Step> {
    let path = || PathBuf::from(rest);
    Some(Step::Do(match (word, rest) {
        ("save", "") => Command::Save(None),
        ("reference", "none") => Command::Reference(None),
        (_, "") => return None,
        ("save", _) => Command::Save(Some(path())),
        ("open", _) => Command::Open(path()),
        ("screenshot", _) => Command::Screenshot(Some(path())),
        ("reference", _) => Command::Reference(Some(path())),
        _ => {
            let words: Vec<_> = rest.split_whitespace().collect();
            let (path, rest) = words.split_first()?;
            let size = rest.first().and_then(|word| size(word));
            let samples = match &rest[usize::from(size.is_some())..] {
                [] => None,
                [samples] => Some(number::<u32>(samples)?),
                _ => return None,
            };
            Command::Export(ExportRequest { path: path.into(), size, samples })
        }
    }))
}

/// Parses all other lines.
fn parameters(word: &str, words: &[&str]) -> Option<Step> {
    let command = match (word, words) {
        ("wait", ["export"]) => return Some(Step::WaitForExport),
        ("wait", ["denoised"]) => return Some(Step::WaitForDenoised),
        ("wait", [count, "samples" | "sample"]) => return Some(Step::WaitForSamples(number(count)?)),
        ("wait", [count, what]) if let Ok(what) = what.parse() => {
            return Some(Step::WaitForHappening(what, number(count)?));
        }
        ("wait", span_words) => return Some(Step::Wait(span(span_words)?)),
        ("press", [keys]) => {
            let (modifiers, key) = chord(keys)?;
            return Some(Step::Press(modifiers, Key::from_name(key)?));
        }
        ("hold", [keys, span_words @ ..]) => {
            let (modifiers, key) = chord(keys)?;
            return Some(Step::Hold(modifiers, Key::from_name(key)?, span(span_words)?));
        }
        ("move", [to]) => return Some(Step::Move(point(to)?)),
        ("click" | "double-click", [button, at]) => {
            let (modifiers, button) = chord(button)?;
            let times = if word == "click" { 1 } else { 2 };
            return Some(Step::Click(mouse_button(button)?, modifiers, point(at)?, times));
        }
        ("drag", [button, from, to, "over", span_words @ ..]) => {
            let (modifiers, button) = chord(button)?;
            let button = mouse_button(button)?;
            return Some(Step::Drag(button, modifiers, point(from)?, point(to)?, span(span_words)?));
        }
        ("wheel", [notches]) => return Some(Step::Wheel(number(notches)?)),
        ("orbit", [degrees, "over", span_words @ ..]) => return Some(Step::Orbit(number(degrees)?, span(span_words)?)),
        ("size", [text]) => return Some(Step::Window(WindowStep::Size(size(text)?))),
        ("scale", [scale]) => {
            let scale = number::<f32>(scale).filter(|scale| (0.25..=8.0).contains(scale))?;
            return Some(Step::Window(WindowStep::Scale(scale)));
        }
        ("preset", [name]) => Command::Preset(name.parse().ok()?),
        ("select", ["none"]) => Command::Select(None),
        ("select", [shape]) => Command::Select(Some(number::<usize>(shape)?.checked_sub(1)?)),
        ("add", ["sphere", center, radius]) => {
            let center: Vec<f32> = center.split(',').map(number).collect::<Option<_>>()?;
            let [x, y, z] = center[..] else { return None };
            let geometry = Geometry::Sphere { center: Vec3::new(x, y, z), radius: number(radius)? };
            Command::Edit(Edit::Add(geometry, 0))
        }
        ("view", [name]) => Command::View(name.parse().ok()?),
        ("tones", [name]) => Command::Tones(name.parse().ok()?),
        ("denoise", ["on"]) => Command::Denoise(true),
        ("denoise", ["off"]) => Command::Denoise(false),
        ("denoise-in-motion", [way]) => Command::DenoiseInMotion(way.parse().ok()?),
        ("compare", [name]) => Command::Compare(name.parse().ok()?),
        ("scene-size", ["on"]) => Command::SceneSize(true),
        ("scene-size", ["off"]) => Command::SceneSize(false),
        ("fill", ["on"]) => Command::Fill(true),
        ("fill", ["off"]) => Command::Fill(false),
        ("exposure", [stops]) => Command::Exposure(number(stops)?),
        ("stop-at", ["never"]) => Command::StopAt(None),
        ("stop-at", [samples]) => Command::StopAt(Some(number(samples)?)),
        ("samples-per-frame", ["auto"]) => Command::SamplesPerFrame(None),
        ("samples-per-frame", [samples]) => Command::SamplesPerFrame(Some(number(samples)?)),
        ("section", ["end"]) => Command::Section(None),
        ("section", [name]) => Command::Section(Some((*name).to_owned())),
        _ => return None,
    };
    Some(Step::Do(command))
}

/// The words `key=value key=value` as the lines of a table.
fn camera(text: &str) -> Result<String, String> {
    let mut table = String::from("[camera]\n");
    let mut depth = 0;
    for letter in text.chars() {
        depth += i32::from(letter == '[') - i32::from(letter == ']');
        table.push(if letter == ' ' && depth == 0 { '\n' } else { letter });
    }
    crate::document::camera_from_text(&table).map(|_| table)
}

fn split(line: &str) -> (&str, &str) {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (word, rest.trim())
}

/// Parses a number written in digits, not in words such as `nan`.
fn number<T: FromStr>(text: &str) -> Option<T> {
    text.starts_with(|first: char| first.is_ascii_digit() || first == '-' || first == '.').then(|| text.parse().ok())?
}

/// Parses `WxH`, a width and a height in pixels, each 1 to 65536.
fn size(text: &str) -> Option<[u32; 2]> {
    pair(text, 'x').filter(|size| size.iter().all(|side| (1..=65536).contains(side)))
}

fn pair<T: FromStr>(text: &str, between: char) -> Option<[T; 2]> {
    let (a, b) = text.split_once(between)?;
    Some([number(a)?, number(b)?])
}

fn point(text: &str) -> Option<Pos2> {
    pair(text, ',').map(|[x, y]| Pos2::new(x, y))
}

fn span(words: &[&str]) -> Option<Span> {
    match words {
        [count, "frames" | "frame"] => Some(Span::Frames(number(count)?)),
        [seconds, "s"] => Duration::try_from_secs_f64(number(seconds)?).ok().map(Span::Time),
        _ => None,
    }
}

/// Splits a chord such as `Ctrl+Shift+Z` into the modifiers held and the key or button pressed with them.
fn chord(text: &str) -> Option<(Modifiers, &str)> {
    let mut modifiers = Modifiers::NONE;
    let mut parts = text.split('+').collect::<Vec<_>>();
    let last = parts.pop()?;
    for part in parts {
        modifiers |= match part {
            "Ctrl" => Modifiers { ctrl: true, command: true, ..Modifiers::NONE },
            "Shift" => Modifiers::SHIFT,
            "Alt" => Modifiers::ALT,
            _ => return None,
        };
    }
    Some((modifiers, last))
}

fn mouse_button(name: &str) -> Option<PointerButton> {
    match name {
        "left" => Some(PointerButton::Primary),
        "middle" => Some(PointerButton::Middle),
        "right" => Some(PointerButton::Secondary),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_a_line_that_is_understood() {
        let examples = "wait 3 frames\npress Ctrl+Z\nhold W 1 s\nmove 1,2\nclick left 1,2\ndouble-click left 1,2\n\
            drag Shift+middle 1,2 3,4 over 1 s\nwheel -1.5\norbit 90 over 9 frames\nhome\n\
            camera position=[0, 1, 4] look_at=[0,1,0] vertical_fov_degrees=40\npreset blender\nset a.b [1, 0, 0]\nselect 2\ndelete\nduplicate\n\
            add sphere 0,1,2 0.5\nundo\nredo\nsave a b.toml\nreload\nopen x.toml\nview normal\nexposure -1\n\
            tones agx\ndenoise on\ndenoise-in-motion never\nreference none\ncompare split\nscene-size on\nfill on\npause\nrestart\nstop-at 5\nsamples-per-frame auto\npanels\nhelp\nexport a.exr 64x48 9\n\
            screenshot a.png\nsize 64x48\nscale 2\nminimise\nrestore\nsection moving\nlose-device\nquit";
        let words: Vec<_> = examples.lines().map(|line| split(line.trim()).0).collect();
        assert_eq!(words, WORDS.iter().map(|(word, _)| *word).collect::<Vec<_>>());
        for line in examples.lines() {
            step(line.trim()).unwrap_or_else(|error| panic!("{line}: {error}"));
        }
    }

    #[test]
    fn shapes_are_counted_from_one() {
        let selected = |line: &str| match step(line) {
            Ok(Step::Do(Command::Select(shape))) => shape,
            other => panic!("{line}: {other:?}"),
        };
        assert_eq!([selected("select 1"), selected("select 12"), selected("select none")], [Some(0), Some(11), None]);
    }

    #[test]
    fn mistakes_name_their_line_and_what_would_be_right() {
        let message = |text: &str| steps(text, "tour.txt").unwrap_err().to_string();
        assert_eq!(
            message("# a tour\n\nwait long"),
            "tour.txt:3: write `wait 30 frames | 1.5 s | 64 samples | export | denoised | 1 reloads | 1 saves | 1 kernels`"
        );
        assert_eq!(message("select 0"), "tour.txt:1: shapes are counted from 1: write `select 1` for the first");
        assert!(message("jump").starts_with("tour.txt:1: unknown word `jump`: a line begins with one of wait, press"));
        for wrong in [
            "press Q+Z",
            "exposure nan",
            "export a.exr 0x10",
            "size 0x0",
            "wait -1 s",
            "wait 2 sheep",
            "size 0.5x3",
            "scale 0",
            "view sideways",
            "pause now",
            "export",
            "camera x",
            "select first",
            "select -1",
        ] {
            assert!(message(wrong).starts_with("tour.txt:1: "), "{wrong}");
        }
    }
}
