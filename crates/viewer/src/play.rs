//! Scripts: the doings of a hand in the window, written down, for turntables, benchmarks and tests.

mod parse;

use std::path::Path;
use std::time::Duration;

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2};
use raggio_choice::{Choice, choice};
use raggio_scene::counted;

use crate::command::{Command, Navigate};
use crate::error::ViewError;

/// Duration of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// Time on the clock.
    Time(Duration),
    /// Number of frames, whatever time they take.
    Frames(u32),
}

/// One line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A command, at once.
    Do(Command),
    /// A key pressed and released at once.
    Press(Modifiers, Key),
    /// A key held for a span.
    Hold(Modifiers, Key, Span),
    /// A jump of the pointer, to a position in points.
    Move(Pos2),
    /// A number of clicks at a position in points.
    Click(PointerButton, Modifiers, Pos2, u32),
    /// A movement of the pointer with a button held, from one position in points to another.
    Drag(PointerButton, Modifiers, Pos2, Pos2, Span),
    /// Notches of the wheel, away from the user.
    Wheel(f32),
    /// An orbit of so many degrees around the point that the camera looks at.
    Orbit(f32, Span),
    /// A wait for a span.
    Wait(Span),
    /// A wait until each pixel has so many samples.
    WaitForSamples(u32),
    /// A wait until the export under way is written.
    WaitForExport,
    /// A wait until the picture is shown without its noise.
    WaitForDenoised,
    /// A wait until something has happened so many times in all.
    WaitForHappening(Happening, u32),
    /// A change of the window itself.
    Window(WindowStep),
}

/// A change of the window by a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WindowStep {
    /// Width and height, in pixels.
    Size([u32; 2]),
    /// Scale factor: pixels in a point.
    Scale(f32),
    /// Minimises the window.
    Minimise,
    /// Restores the window after it was minimised.
    Restore,
}

/// A script being played.
pub struct Player {
    steps: std::vec::IntoIter<Step>,
    /// The step that takes time, and the part of it that is done, 0 to 1.
    current: Option<(Step, f64)>,
    pointer: Pos2,
}

/// Input of a script in one frame.
#[derive(Default)]
pub struct Played {
    /// Events, like those from mouse and keyboard.
    pub events: Vec<Event>,
    /// Commands, like those from the panels.
    pub commands: Vec<Command>,
    /// Changes of the window, like those from its frame.
    pub window: Vec<WindowStep>,
}

choice! {
    /// A thing that others make happen while a script plays, and that it can wait for.
    pub enum Happening: "happening" {
        /// The scene's file has been read again.
        Reload = "reloads",
        /// The scene has been saved.
        Save = "saves",
        /// The kernels have been compiled again, and trace.
        Exchange = "kernels",
    }
}

/// Number of times that each [`Happening`] has happened.
pub type Happened = [u32; Happening::ALL.len()];

/// State of the viewer that a script can wait for.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Samples of each pixel at full resolution.
    pub samples: u32,
    /// Whether there will be no more samples.
    pub stopped: bool,
    /// Things that have happened so far.
    pub happened: Happened,
    /// Whether a denoised picture is awaited.
    pub denoising: bool,
    /// Whether a picture is being rendered for a file.
    pub exporting: bool,
}

impl Player {
    /// Reads a script.
    pub fn load(path: &Path) -> Result<Self, ViewError> {
        let text = std::fs::read_to_string(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => {
                ViewError::File { path: path.into(), message: "there is no such file".into() }
            }
            _ => ViewError::File { path: path.into(), message: format!("cannot be read: {e}") },
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses a script's text; `file` names it in errors.
    pub fn parse(text: &str, file: &str) -> Result<Self, ViewError> {
        let steps = parse::steps(text, file)?;
        Ok(Self { steps: steps.into_iter(), current: None, pointer: Pos2::ZERO })
    }

    /// Returns the input for a frame that comes `seconds` after the last; the script ends by closing the window.
    pub fn frame(&mut self, seconds: f64, state: State) -> Played {
        let mut played = Played::default();
        if let Some((step, done)) = self.current.take() {
            self.proceed(step, done, seconds, state, &mut played);
        }
        // Keys and clicks take a frame of their own, for a press and its release in one would be seen as neither.
        // A screenshot too, for what follows would be half in it.
        let pictured = |played: &Played| matches!(played.commands.last(), Some(Command::Screenshot(_)));
        while self.current.is_none() && played.events.is_empty() && played.window.is_empty() && !pictured(&played) {
            match self.steps.next() {
                Some(step) => self.begin(step, &mut played),
                None => {
                    played.commands.push(Command::Quit);
                    break;
                }
            }
        }
        played
    }

    fn begin(&mut self, step: Step, played: &mut Played) {
        match &step {
            Step::Do(command) => played.commands.push(command.clone()),
            Step::Window(step) => played.window.push(*step),
            Step::Press(modifiers, key) | Step::Hold(modifiers, key, _) => {
                press(*modifiers, *key, true, &mut played.events);
                self.current = Some((step, 0.0));
            }
            Step::Move(to) => self.point(*to, played),
            Step::Click(button, modifiers, at, _) | Step::Drag(button, modifiers, at, _, _) => {
                self.point(*at, played);
                self.button(*button, *modifiers, true, played);
                self.current = Some((step, 0.0));
            }
            Step::Wheel(notches) => played.events.push(Event::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: Vec2::new(0.0, *notches),
                phase: TouchPhase::Move,
                modifiers: Modifiers::NONE,
            }),
            // Steps before these in this frame have not been done yet, so that these look first in the next.
            Step::Orbit(..)
            | Step::Wait(_)
            | Step::WaitForSamples(_)
            | Step::WaitForExport
            | Step::WaitForDenoised
            | Step::WaitForHappening(..) => {
                self.current = Some((step, 0.0));
            }
        }
    }

    /// Goes on with a step of which the part `done` is behind.
    fn proceed(&mut self, step: Step, done: f64, seconds: f64, state: State, played: &mut Played) {
        let after = |span: Span| (done + span.share(seconds)).min(1.0);
        let now = match &step {
            Step::Press(modifiers, key) => {
                press(*modifiers, *key, false, &mut played.events);
                1.0
            }
            Step::Hold(modifiers, key, span) => {
                if after(*span) >= 1.0 {
                    press(*modifiers, *key, false, &mut played.events);
                }
                after(*span)
            }
            Step::Click(button, modifiers, _, times) => {
                // A press, a release, and so on.
                let events = 2 * times;
                let number = (done * f64::from(events)).round() as u32 + 1;
                self.button(*button, *modifiers, number.is_multiple_of(2), played);
                f64::from(number + u32::from(number + 1 == events)) / f64::from(events)
            }
            Step::Drag(button, modifiers, from, to, span) => {
                self.point(*from + (*to - *from) * after(*span) as f32, played);
                if after(*span) >= 1.0 {
                    self.button(*button, *modifiers, false, played);
                }
                after(*span)
            }
            Step::Orbit(degrees, span) => {
                let turn = f64::from(*degrees) * (after(*span) - done);
                played.commands.push(Command::Navigate(Navigate::Orbit(turn as f32)));
                after(*span)
            }
            Step::Wait(span) => after(*span),
            Step::WaitForSamples(samples) => {
                let enough = state.samples >= *samples;
                if state.stopped && !enough {
                    let (has, wanted) = (state.samples, counted(*samples as usize, "sample"));
                    let complaint = format!("waited for {wanted} per pixel, and sampling stopped at {has}");
                    played.commands.push(Command::Complain(complaint));
                }
                f64::from(u8::from(enough || state.stopped))
            }
            Step::WaitForDenoised => f64::from(u8::from(!state.denoising)),
            Step::WaitForHappening(what, times) => f64::from(u8::from(state.happened[*what as usize] >= *times)),
            Step::WaitForExport => f64::from(u8::from(!state.exporting)),
            Step::Do(_) | Step::Move(_) | Step::Wheel(_) | Step::Window(_) => 1.0,
        };
        // Rounding must not add a frame.
        if now < 1.0 - 1e-9 {
            self.current = Some((step, now));
        }
    }

    fn point(&mut self, to: Pos2, played: &mut Played) {
        self.pointer = to;
        played.events.push(Event::PointerMoved(to));
    }

    fn button(&self, button: PointerButton, modifiers: Modifiers, pressed: bool, played: &mut Played) {
        played.events.push(Event::ModifiersChanged(if pressed { modifiers } else { Modifiers::NONE }));
        played.events.push(Event::PointerButton { pos: self.pointer, button, pressed, modifiers });
    }
}

impl Span {
    /// Part of the span that passes in one frame of `seconds`.
    fn share(self, seconds: f64) -> f64 {
        match self {
            Self::Time(duration) => seconds / duration.as_secs_f64().max(1e-9),
            Self::Frames(frames) => 1.0 / f64::from(frames.max(1)),
        }
    }
}

fn press(modifiers: Modifiers, key: Key, pressed: bool, events: &mut Vec<Event>) {
    events.push(Event::ModifiersChanged(if pressed { modifiers } else { Modifiers::NONE }));
    events.push(Event::Key { key, physical_key: Some(key), pressed, repeat: false, modifiers });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The frames of a script until it ends, each a twentieth of a second long.
    fn frames(text: &str) -> Vec<Played> {
        let mut player = Player::parse(text, "test").unwrap_or_else(|error| panic!("{error}"));
        let mut frames = vec![];
        while frames.len() < 1000 {
            let played = player
                .frame(0.05, State { samples: frames.len() as u32, exporting: frames.len() < 5, ..State::default() });
            let over = played.commands.last() == Some(&Command::Quit);
            frames.push(played);
            if over {
                return frames;
            }
        }
        panic!("the script does not end");
    }

    #[test]
    fn commands_that_take_no_time_share_a_frame() {
        let frames = frames("pause\nrestart\nundo");
        assert_eq!(frames.len(), 1);
        assert_eq!(frames[0].commands, [Command::Pause, Command::Restart, Command::Undo, Command::Quit]);
    }

    #[test]
    fn spans_take_their_frames_or_their_time() {
        assert_eq!(frames("wait 7 frames").len(), 8);
        assert_eq!(frames("wait 0.5 s").len(), 11);
        assert_eq!(frames("wait 12 samples").len(), 13);
        assert_eq!(frames("wait export").len(), 6);
    }

    #[test]
    fn an_orbit_turns_by_its_angle_in_all() {
        let turns = frames("orbit 90 over 7 frames");
        let turn = |played: &Played| match played.commands[..] {
            [Command::Navigate(Navigate::Orbit(degrees)), ..] => degrees,
            _ => 0.0,
        };
        assert!((turns.iter().map(turn).sum::<f32>() - 90.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_pressed_is_released() {
        for script in [
            "press Ctrl+Z",
            "hold W 3 frames",
            "click left 1,2",
            "double-click left 1,2",
            "drag left 1,2 3,4 over 3 frames",
        ] {
            let mut down = 0;
            let mut presses = 0;
            for event in frames(script).iter().flat_map(|played| &played.events) {
                if let Event::Key { pressed, .. } | Event::PointerButton { pressed, .. } = event {
                    down += if *pressed { 1 } else { -1 };
                    presses += u32::from(*pressed);
                }
                assert!((0..=1).contains(&down), "{script}");
            }
            assert_eq!(down, 0, "{script}");
            assert_eq!(presses, if script.starts_with("double") { 2 } else { 1 }, "{script}");
        }
    }

    #[test]
    fn a_drag_ends_where_it_is_to_end() {
        let last =
            frames("drag right 10,20 110,70 over 4 frames").iter().flat_map(|p| p.events.clone()).rev().find_map(
                |event| match event {
                    Event::PointerMoved(at) => Some(at),
                    _ => None,
                },
            );
        assert_eq!(last, Some(Pos2::new(110.0, 70.0)));
    }
}
