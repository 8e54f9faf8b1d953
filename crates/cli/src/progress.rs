//! Words and figures of how a render goes, for people and for programs.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle as BarStyle};
use raggio_choice::choice;
use raggio_render::{Film, Observer, Phase, Progress, UNLIMITED_SAMPLES};
use raggio_scene::counted;
use serde_json::json;

use crate::output::{Language, say, say_json, say_openjd, speak};

choice! {
    /// Way of telling how a render goes.
    pub enum ProgressStyle: "progress style" {
        /// a bar on a terminal, now and then a line elsewhere
        Auto = "auto",
        /// a bar, which only a terminal shows
        Bar = "bar",
        /// now and then a line
        Lines = "lines",
        /// lines of JSON on standard error, and so is all else that is said
        Json = "json",
        /// lines of Open Job Description on standard output
        OpenJd = "openjd",
        /// no progress; warnings and what is written are told
        None = "none",
    }
}

/// Time from one line for a program to the next, at least.
const PAUSE: Duration = Duration::from_millis(500);

/// Seconds of compiling that are worth a line.
const A_WHILE: f64 = 1.0;
/// Progress of a render that has not begun.
const NONE: Progress = Progress { samples: 0, total_samples: 0, fraction: 0.0, noise: None, seconds: 0.0 };

/// Tells the user how a render goes.
pub struct Reporter {
    style: Style,
    end: End,
    phase: Phase,
    /// Path of the last checkpoint.
    checkpoint: Option<PathBuf>,
    /// Progress that was told last.
    last: Option<Progress>,
    /// Frame of a sequence that is being rendered.
    frame: Option<FramePlace>,
}

/// Place of a frame in the sequence that is rendered.
#[derive(Clone, Copy, Debug)]
pub struct FramePlace {
    /// Number of the frame.
    pub number: u32,
    /// Frames before it that are done, and how many there are in all.
    pub done: usize,
    pub total: usize,
    /// Mean seconds of those that this command has rendered; `None` for the first.
    pub mean_seconds: Option<f64>,
}

enum Style {
    Quiet,
    Silent,
    Bar(ProgressBar),
    Lines { next: Instant, pause: Duration, is_compiling: bool },
    Json { next: Instant },
    OpenJd { next: Instant },
}

/// End of a render, as far as it is known before.
#[derive(Clone, Copy)]
pub struct End {
    /// Samples of each pixel; `UNLIMITED_SAMPLES` where something else is sure to come before.
    pub samples: u32,
    /// Longest time of sampling, in seconds.
    pub time_limit: Option<f32>,
}

impl ProgressStyle {
    /// Says what is said from now on as programs read it, if they are to.
    pub fn speak(self) {
        match self {
            Self::Json => speak(Language::Json),
            Self::OpenJd => speak(Language::OpenJd),
            _ => {}
        }
    }
}

impl Reporter {
    pub fn new(quiet: bool, style: ProgressStyle, end: End) -> Self {
        let is_bar = style == ProgressStyle::Bar || style == ProgressStyle::Auto && std::io::stderr().is_terminal();
        let next = Instant::now();
        let style = match style {
            _ if quiet => Style::Quiet,
            ProgressStyle::None => Style::Silent,
            ProgressStyle::Json => Style::Json { next },
            ProgressStyle::OpenJd => Style::OpenJd { next },
            _ if is_bar => {
                let bar = ProgressBar::new(1000);
                let style = BarStyle::with_template("{bar:30} {percent:>3}%  {msg}");
                bar.set_style(style.unwrap_or_else(|_| BarStyle::default_bar()));
                Style::Bar(bar)
            }
            _ => {
                let pause = Duration::from_secs(2);
                Style::Lines { next: next + pause, pause, is_compiling: false }
            }
        };
        Self { style, end, phase: Phase::Sampling, checkpoint: None, last: None, frame: None }
    }

    /// Takes the end of each frame of a sequence, once it is known.
    pub fn set_end(&mut self, end: End) {
        self.end = end;
    }

    /// Takes the frame of a sequence that comes next.
    pub fn begin_frame(&mut self, frame: FramePlace) {
        self.frame = Some(frame);
        self.checkpoint = None;
        let fraction = frame.done as f64 / frame.total as f64;
        match &self.style {
            Style::Bar(bar) => bar.set_position((1000.0 * fraction) as u64),
            Style::OpenJd { .. } => say_openjd("progress", format_args!("{:.2}", 100.0 * fraction)),
            _ => {}
        }
    }

    /// Prints a warning.
    pub fn warn(&self, warning: &str) {
        self.say(&format!("warning: {warning}"));
    }

    /// Prints a line of its own, above the bar.
    pub fn say(&self, line: &str) {
        match &self.style {
            Style::Quiet => {}
            Style::Bar(bar) if !bar.is_hidden() => bar.println(line),
            _ => say(line),
        }
    }

    /// Takes the phase that begins.
    pub fn begin(&mut self, phase: Phase) {
        self.phase = phase;
        let now = Instant::now();
        match &mut self.style {
            Style::Json { next } => *next = now,
            Style::OpenJd { next } => {
                *next = now;
                say_openjd("status", phase);
            }
            Style::Bar(_) | Style::Lines { .. } if phase == Phase::Denoising => self.say("denoising"),
            _ => {}
        }
        match (&self.style, self.last) {
            (Style::Json { .. }, Some(last)) => self.update(&last),
            (Style::Json { .. }, None) if phase == Phase::Compiling => self.compiling(0.0),
            _ => {}
        }
    }

    /// Takes for how many `seconds` the render has waited for kernels.
    pub fn compiling(&mut self, seconds: f64) {
        let now = Instant::now();
        match &mut self.style {
            Style::Bar(bar) => bar.set_message(format!("compiling kernels  {}", duration(seconds))),
            Style::Lines { is_compiling, .. } if seconds >= A_WHILE && !*is_compiling => {
                *is_compiling = true;
                say("compiling kernels");
            }
            Style::Json { next } if now >= *next => {
                *next = now + PAUSE;
                self.say_figures(self.phase.name(), &self.last.unwrap_or(NONE));
            }
            _ => {}
        }
    }

    /// Takes the path of a checkpoint that has been written.
    pub fn saved(&mut self, checkpoint: &Path) {
        self.checkpoint = Some(checkpoint.into());
    }

    pub fn update(&mut self, progress: &Progress) {
        self.last = Some(*progress);
        let (now, fraction) = (Instant::now(), whole_fraction(progress, self.frame));
        let describe = |progress| describe(progress, self.end, self.frame);
        match &mut self.style {
            Style::Quiet | Style::Silent => {}
            Style::Bar(bar) => {
                bar.set_position((1000.0 * fraction) as u64);
                bar.set_message(describe(progress));
            }
            Style::Lines { next, pause, .. } => {
                if now >= *next {
                    say(format_args!("{:3.0}%  {}", 100.0 * fraction, describe(progress)));
                    // Long renders need no line every two seconds.
                    *pause = (*pause * 3 / 2).min(Duration::from_secs(60));
                    *next = now + *pause;
                }
            }
            Style::Json { next } => {
                if now >= *next {
                    *next = now + PAUSE;
                    self.say_figures(self.phase.name(), progress);
                }
            }
            Style::OpenJd { next } => {
                if now >= *next {
                    *next = now + PAUSE;
                    say_openjd("progress", format_args!("{:.2}", 100.0 * fraction));
                    say_openjd("status", describe(progress));
                }
            }
        }
    }

    /// Prints a line of figures as JSON.
    fn say_figures(&self, phase: &str, progress: &Progress) {
        let mut line = json!({
            "phase": phase,
            "fraction": whole_fraction(progress, self.frame),
            "samples": progress.samples,
            "samples_wanted": (self.end.samples < UNLIMITED_SAMPLES).then_some(self.end.samples),
            "seconds": progress.seconds,
            "seconds_left": seconds_left(progress, self.end, self.frame),
            "noise": progress.noise.map(|noise| noise.error).filter(|error| error.is_finite()),
            "checkpoint": self.checkpoint.as_ref().map(|path| path.to_string_lossy()),
        });
        if let Some(FramePlace { number, done, total, .. }) = self.frame {
            line["frame"] = number.into();
            line["frames_done"] = done.into();
            line["frames"] = total.into();
        }
        say_json(&line);
    }

    /// Takes the bar away, for sampling is over.
    pub fn finish(&self) {
        if let Style::Bar(bar) = &self.style {
            bar.finish_and_clear();
        }
    }

    /// Tells programs that all is done.
    pub fn done(&mut self) {
        self.checkpoint = None;
        if let Some(frame) = &mut self.frame {
            frame.done = frame.total - 1;
        }
        match &self.style {
            Style::Json { .. } => {
                // Nothing is sampled where all frames were done before.
                self.say_figures("done", &Progress { fraction: 1.0, ..self.last.unwrap_or(NONE) });
            }
            Style::OpenJd { .. } => {
                say_openjd("progress", "100");
                say_openjd("status", "done");
            }
            _ => {}
        }
    }

    /// Prints figures of a render that is over; `target` samples a pixel were asked for.
    pub fn report(&self, film: &Film, progress: &Progress, target: u32) {
        if film.clamped_share() > 0.0 {
            self.say(&format!("clamping took {:.2} % of the light off", 100.0 * film.clamped_share()));
        }
        if let Some(line) = describe_samples(film, progress.samples < target, target) {
            self.say(&line);
        }
        // Frames are many, and their figures are much alike.
        if self.frame.is_some() {
            return;
        }
        let seconds = progress.seconds.max(1e-9);
        self.say(&format!(
            "{} samples, {} rays in {}: {} samples/s, {} rays/s",
            millions(progress.total_samples as f64),
            millions(film.rays() as f64),
            duration(progress.seconds),
            millions(progress.total_samples as f64 / seconds),
            millions(film.rays() as f64 / seconds),
        ));
    }
}

/// Hears what is told before samples are taken.
impl Observer for Reporter {
    fn warn(&mut self, warning: &str) {
        Reporter::warn(self, warning);
    }

    fn begin(&mut self, phase: Phase) {
        Reporter::begin(self, phase);
    }

    fn compiling(&mut self, seconds: f64) {
        Reporter::compiling(self, seconds);
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.update(progress);
        ControlFlow::Continue(())
    }
}

/// Numbers of samples of a render that is over, where they are not those that were asked for.
fn describe_samples(film: &Film, stopped: bool, target: u32) -> Option<String> {
    let (fewest, most) = film.sample_range();
    let is_uneven = most > fewest + 1;
    if !stopped && !is_uneven {
        return None;
    }
    let range = if is_uneven { format!("{fewest} to ") } else { String::new() };
    let most = if is_uneven { most } else { fewest };
    let mut text = if stopped && target < UNLIMITED_SAMPLES {
        format!("stopped early: {range}{most} of {} per pixel", counted(target as usize, "sample"))
    } else {
        format!("{range}{} per pixel", counted(most as usize, "sample"))
    };
    if is_uneven {
        let mean = film.samples() as f64 / film.pixels().len() as f64;
        text += &format!(", {mean:.1} on average");
    }
    Some(text)
}

fn describe(progress: &Progress, end: End, frame: Option<FramePlace>) -> String {
    let rate = progress.total_samples as f64 / progress.seconds.max(1e-9);
    let mut text = match frame {
        Some(FramePlace { number, done, total, .. }) => format!("frame {number} ({} of {total})  ", done + 1),
        None => String::new(),
    };
    text += &if end.samples < UNLIMITED_SAMPLES {
        format!("{}/{}", progress.samples, counted(end.samples as usize, "sample"))
    } else {
        counted(progress.samples as usize, "sample")
    };
    text += &format!("  {} samples/s", millions(rate));
    if let Some(noise) = progress.noise.filter(|noise| noise.error.is_finite()) {
        let [error, resting] = [noise.error, noise.resting].map(|part| 100.0 * part);
        text += &format!("  error {error:.1} %, {resting:.0} % of the picture done");
    }
    if let Some(left) = seconds_left(progress, end, frame) {
        text += &format!("  {} left", duration(left));
    }
    text
}

/// Part of the whole that is done, all frames counted alike.
fn whole_fraction(progress: &Progress, frame: Option<FramePlace>) -> f64 {
    frame.map_or(progress.fraction, |frame| (frame.done as f64 + progress.fraction) / frame.total.max(1) as f64)
}

/// Seconds that a render has still to go, as far as its rate tells, and all frames after it.
fn seconds_left(progress: &Progress, end: End, frame: Option<FramePlace>) -> Option<f64> {
    // Nobody knows how long it takes until the noise is low.
    let is_known = progress.noise.is_none() && progress.fraction > 0.0;
    let by_fraction = is_known.then(|| progress.seconds * (1.0 - progress.fraction) / progress.fraction);
    let by_time = end.time_limit.map(|limit| (f64::from(limit) - progress.seconds).max(0.0));
    let left = [by_fraction, by_time].into_iter().flatten().reduce(f64::min)?;
    let Some(FramePlace { done, total, mean_seconds, .. }) = frame else { return Some(left) };
    let each = mean_seconds.unwrap_or(progress.seconds + left);
    Some(left + each * total.saturating_sub(done + 1) as f64)
}

/// Count in millions: `12.3 M`.
fn millions(count: f64) -> String {
    let count = count / 1e6;
    let digits = if count < 10.0 {
        2
    } else if count < 100.0 {
        1
    } else {
        0
    };
    format!("{count:.digits$} M")
}

/// Duration in words: `8.4 s`, `3 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round().min(1e9) as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
