use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use raggio_render::{Film, Progress, UNLIMITED_SAMPLES};
use raggio_scene::counted;

use crate::output::say;

/// Tells the user how a render goes: a bar on a terminal, now and then a line elsewhere, nothing when quiet.
pub enum Reporter {
    Quiet,
    Bar { bar: ProgressBar, target: u32 },
    Lines { target: u32, next: Instant, pause: Duration },
}

impl Reporter {
    pub fn new(quiet: bool, target: u32) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(1000);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3}%  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            Self::Bar { bar, target }
        } else {
            let pause = Duration::from_secs(2);
            Self::Lines { target, next: Instant::now() + pause, pause }
        }
    }

    /// Prints a line of its own, above the bar.
    pub fn say(&self, line: &str) {
        match self {
            Self::Quiet => {}
            Self::Bar { bar, .. } => bar.println(line),
            Self::Lines { .. } => say(line),
        }
    }

    pub fn update(&mut self, progress: &Progress) {
        match self {
            Self::Quiet => {}
            Self::Bar { bar, target } => {
                bar.set_position((1000.0 * progress.fraction) as u64);
                bar.set_message(describe(progress, *target));
            }
            Self::Lines { target, next, pause } => {
                if Instant::now() >= *next {
                    say(format_args!("{:3.0}%  {}", 100.0 * progress.fraction, describe(progress, *target)));
                    // Long renders need no line every two seconds.
                    *pause = (*pause * 3 / 2).min(Duration::from_secs(60));
                    *next = Instant::now() + *pause;
                }
            }
        }
    }

    pub fn finish(&self) {
        if let Self::Bar { bar, .. } = self {
            bar.finish_and_clear();
        }
    }

    /// Prints figures of a render that is over; `target` samples a pixel were asked for.
    pub fn report(&self, film: &Film, progress: &Progress, target: u32) {
        if film.clamped_share() > 0.0 {
            self.say(&format!("clamping took {:.2} % of the light off", 100.0 * film.clamped_share()));
        }
        let (fewest, most) = film.sample_range();
        if most > fewest + 1 {
            let mean = film.samples() as f64 / film.pixels().len() as f64;
            self.say(&format!("{fewest} to {most} samples per pixel, {mean:.1} on average"));
        } else if progress.samples < target {
            let is_limited = target < UNLIMITED_SAMPLES;
            let early = if is_limited { format!("stopped early: {fewest} of ") } else { String::new() };
            let number = if is_limited { target } else { fewest };
            self.say(&format!("{early}{} per pixel", counted(number as usize, "sample")));
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

fn describe(progress: &Progress, target: u32) -> String {
    let rate = progress.total_samples as f64 / progress.seconds.max(1e-9);
    if target == UNLIMITED_SAMPLES {
        return format!("{}  {} samples/s", counted(progress.samples as usize, "sample"), millions(rate));
    }
    let left = progress.seconds * (1.0 - progress.fraction) / progress.fraction.max(1e-9);
    let samples = counted(target as usize, "sample");
    format!("{}/{samples}  {} samples/s  {} left", progress.samples, millions(rate), duration(left))
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
fn duration(seconds: f64) -> String {
    let whole = seconds.round().min(1e9) as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
