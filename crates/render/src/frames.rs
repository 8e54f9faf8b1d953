//! Frames of an animation: their numbers, their moments, and the names of their files.

use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use raggio_scene::display_name;

/// Most frames of one command, and the largest number of a frame.
const MOST_FRAMES: u32 = 1_000_000;

/// Numbers of frames, each once and in the order in which they were asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames(Vec<u32>);

/// Frames a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRate(f64);

impl Frames {
    /// Numbers in the order of rendering.
    pub fn numbers(&self) -> &[u32] {
        &self.0
    }

    /// Numbers in the order of time.
    pub fn sorted(&self) -> Vec<u32> {
        let mut numbers = self.0.clone();
        numbers.sort_unstable();
        numbers
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut known = HashSet::new();
        let mut numbers = vec![];
        for part in text.split(',').map(str::trim) {
            let (range, step) = match part.split_once(':') {
                Some((range, step)) => (range, Some(step)),
                None => (part, None),
            };
            let (first, last) = match range.split_once('-') {
                // A number below zero is no range.
                Some((first, last)) if !first.trim().is_empty() => (number(first, part)?, number(last, part)?),
                _ => (number(range, part)?, number(range, part)?),
            };
            let step = match step {
                Some(_) if first == last && !range.contains('-') => {
                    return Err(format!(
                        "`{part}` has a step but no range: give the last frame too, as in {first}-{}:2",
                        first + 9
                    ));
                }
                Some(step) => {
                    step.trim().parse().ok().filter(|step| (1..=MOST_FRAMES).contains(step)).ok_or_else(|| {
                        format!(
                            "`{}` is no step: give a number of frames from 1 on, as in {first}-{last}:2",
                            step.trim()
                        )
                    })?
                }
                None => 1,
            };
            if first > last {
                return Err(format!("`{part}` counts down: give the first frame first, {last}-{first}"));
            }
            numbers.extend((first..=last).step_by(step as usize).filter(|frame| known.insert(*frame)));
        }
        Ok(Self(numbers))
    }
}

fn number(text: &str, part: &str) -> Result<u32, String> {
    let text = text.trim();
    if text.is_empty() {
        let whole = if part.is_empty() { "a frame is missing".into() } else { format!("`{part}` lacks a frame") };
        return Err(format!("{whole}: give frames as 1-240, or 1-3,5,7-10:2"));
    }
    match text.parse::<i64>() {
        Ok(frame) if (1..=i64::from(MOST_FRAMES)).contains(&frame) => Ok(frame as u32),
        Ok(frame) if frame > 0 => Err(format!("frame {frame} is too much: the last may be {MOST_FRAMES}")),
        Ok(frame) => Err(format!("there is no frame {frame}: frames are counted from 1, which is the moment 0")),
        Err(_) => Err(format!("`{text}` is no frame: give frames as 1-240, or 1-3,5,7-10:2")),
    }
}

impl FrameRate {
    /// Number of frames in a second.
    pub fn per_second(self) -> f64 {
        self.0
    }

    /// Seconds from frame 1 to this one.
    pub fn moment(self, frame: u32) -> f64 {
        f64::from(frame - 1) / self.0
    }

    /// Seconds from frame 1 to the one before this.
    pub fn moment_before(self, frame: u32) -> f64 {
        (f64::from(frame) - 2.0) / self.0
    }
}

impl FromStr for FrameRate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let rate = match text.split_once('/') {
            Some((frames, seconds)) => number(frames).zip(number(seconds)).map(|(frames, seconds)| frames / seconds),
            None => number(text),
        };
        let in_range = rate.filter(|rate| (0.001..=1000.0).contains(rate));
        in_range.map(Self).ok_or_else(|| "give frames a second from 0.001 to 1000, as 24, 29.97 or 30000/1001".into())
    }
}

/// Name of a file of each frame: the last row of `#` in it stands for the frame's number, with zeros before it.
#[derive(Clone, Debug)]
pub struct Pattern {
    path: PathBuf,
    /// Name of the file before and after the number, and how many digits that has at least.
    name: Option<(String, usize, String)>,
}

impl Pattern {
    /// Pattern of a path, whose folder's name stays as it is.
    pub fn new(path: &Path) -> Self {
        let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| {
            let end = name.rfind('#')? + 1;
            let start = name[..end].trim_end_matches('#').len();
            Some((name[..start].to_owned(), end - start, name[end..].to_owned()))
        });
        Self { path: path.into(), name }
    }

    /// Pattern for the frames of a picture that is called `stem`.
    pub fn named(stem: &OsStr) -> Self {
        let mut name = OsString::from(stem);
        name.push("-####.png");
        Self::new(Path::new(&name))
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a frame's file; all frames have one if the pattern has no `#`.
    pub fn of(&self, frame: u32) -> PathBuf {
        match &self.name {
            Some((before, digits, after)) => self.path.with_file_name(format!("{before}{frame:0digits$}{after}")),
            None => self.path.clone(),
        }
    }

    /// Checks that `frames` have a file each.
    ///
    /// # Errors
    /// A sentence for the user where they have not.
    pub fn check(&self, frames: &Frames) -> Result<(), String> {
        if self.name.is_some() || frames.numbers().len() == 1 {
            return Ok(());
        }
        let mut right = self.path.file_stem().unwrap_or_default().to_os_string();
        right.push("-####");
        if let Some(ending) = self.path.extension() {
            right.push(".");
            right.push(ending);
        }
        let [path, right] = [self.path.clone(), self.path.with_file_name(right)].map(|path| display_name(&path));
        let count = frames.numbers().len();
        Err(format!("cannot write {count} frames to {path}: each needs its number in the name, as in {right}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<u32> {
        text.parse::<Frames>().unwrap_or_else(|error| panic!("{text}: {error}")).0
    }

    fn refusal(text: &str) -> String {
        text.parse::<Frames>().expect_err(text)
    }

    #[test]
    fn frames_are_ranges_and_steps_and_each_comes_once() {
        assert_eq!(numbers("7"), [7]);
        assert_eq!(numbers("1-4"), [1, 2, 3, 4]);
        assert_eq!(numbers("1-3,5,7-10:2"), [1, 2, 3, 5, 7, 9]);
        assert_eq!(numbers(" 1 - 2 , 4 "), [1, 2, 4]);
        assert_eq!(numbers("1-9:4,1-5"), [1, 5, 9, 2, 3, 4]);
        assert_eq!("9,1-3".parse::<Frames>().expect("frames").sorted(), [1, 2, 3, 9]);
        assert_eq!(numbers("3-3:5"), [3]);
    }

    #[test]
    fn what_is_no_frame_is_told_with_what_would_be() {
        for (text, message) in [
            ("", "a frame is missing: give frames as 1-240, or 1-3,5,7-10:2"),
            ("1,,3", "a frame is missing: give frames as 1-240, or 1-3,5,7-10:2"),
            ("1-", "`1-` lacks a frame: give frames as 1-240, or 1-3,5,7-10:2"),
            ("a", "`a` is no frame: give frames as 1-240, or 1-3,5,7-10:2"),
            ("1..5", "`1..5` is no frame: give frames as 1-240, or 1-3,5,7-10:2"),
            ("0-3", "there is no frame 0: frames are counted from 1, which is the moment 0"),
            ("-3", "there is no frame -3: frames are counted from 1, which is the moment 0"),
            ("1-1000001", "frame 1000001 is too much: the last may be 1000000"),
            ("10-1", "`10-1` counts down: give the first frame first, 1-10"),
            ("1-10:0", "`0` is no step: give a number of frames from 1 on, as in 1-10:2"),
            ("1-10:x", "`x` is no step: give a number of frames from 1 on, as in 1-10:2"),
            ("4:2", "`4:2` has a step but no range: give the last frame too, as in 4-13:2"),
        ] {
            assert_eq!(refusal(text), message, "{text}");
        }
    }

    #[test]
    fn the_first_frame_is_the_moment_0() {
        let rate = "25".parse::<FrameRate>().expect("a rate");
        assert_eq!(
            [rate.moment(1), rate.moment(26), rate.moment_before(1), rate.moment_before(2)],
            [0.0, 1.0, -0.04, 0.0]
        );
        assert_eq!("30000/1001".parse::<FrameRate>(), Ok(FrameRate(30000.0 / 1001.0)));
        for wrong in ["0", "-24", "nan", "24fps", "1/0", ""] {
            assert!(wrong.parse::<FrameRate>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_take_the_place_of_the_last_row_of_signs() {
        let name = |pattern: &str, frame: u32| Pattern::new(Path::new(pattern)).of(frame);
        assert_eq!(name("out/frame-####.exr", 7), Path::new("out/frame-0007.exr"));
        assert_eq!(name("#.png", 12), Path::new("12.png"));
        assert_eq!(name("a##.png", 1234), Path::new("a1234.png"));
        assert_eq!(name("take#2/shot#-###.film", 5), Path::new("take#2/shot#-005.film"));
        assert_eq!(name("still.png", 5), Path::new("still.png"));
        assert_eq!(Pattern::named("a.b".as_ref()).of(3), Path::new("a.b-0003.png"));
    }

    #[test]
    fn several_frames_need_several_names() {
        let frames: Frames = "1-240".parse().expect("frames");
        let refused = Pattern::new(Path::new("out/a.exr")).check(&frames).expect_err("one name");
        assert_eq!(
            refused,
            "cannot write 240 frames to out/a.exr: each needs its number in the name, as in out/a-####.exr"
        );
        assert!(Pattern::new(Path::new("a.exr")).check(&"4".parse().expect("a frame")).is_ok());
        assert!(Pattern::new(Path::new("a#.exr")).check(&frames).is_ok());
    }
}
