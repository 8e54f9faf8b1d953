use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use raggio_render::{Film, Progress, UNLIMITED_SAMPLES};
use raggio_scene::counted;

use crate::output::say;

/// Tells the user how a render goes: a bar on a terminal, now and then a line elsewhere, nothing when quiet.
pub enum Reporter {
    Quiet,
    Bar { bar: ProgressBar, end: End },
    Lines { end: End, next: Instant, pause: Duration },
}

/// End of a render, as far as it is known before.
#[derive(Clone, Copy)]
pub struct End {
    /// Samples of each pixel; `UNLIMITED_SAMPLES` where something else is sure to come before.
    pub samples: u32,
    /// Longest time of sampling, in seconds.
    pub time_limit: Option<f32>,
}

impl Reporter {
    pub fn new(quiet: bool, end: End) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(1000);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3}%  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            Self::Bar { bar, end }
        } else {
            let pause = Duration::from_secs(2);
            Self::Lines { end, next: Instant::now() + pause, pause }
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
            Self::Bar { bar, end } => {
                bar.set_position((1000.0 * progress.fraction) as u64);
                bar.set_message(describe(progress, *end));
            }
            Self::Lines { end, next, pause } => {
                if Instant::now() >= *next {
                    say(format_args!("{:3.0}%  {}", 100.0 * progress.fraction, describe(progress, *end)));
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
        if let Some(line) = describe_samples(film, progress.samples < target, target) {
            self.say(&line);
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

fn describe(progress: &Progress, end: End) -> String {
    let rate = progress.total_samples as f64 / progress.seconds.max(1e-9);
    let samples = if end.samples < UNLIMITED_SAMPLES {
        format!("{}/{}", progress.samples, counted(end.samples as usize, "sample"))
    } else {
        counted(progress.samples as usize, "sample")
    };
    let mut text = format!("{samples}  {} samples/s", millions(rate));
    if let Some(noise) = progress.noise.filter(|noise| noise.error.is_finite()) {
        let [error, resting] = [noise.error, noise.resting].map(|part| 100.0 * part);
        text += &format!("  error {error:.1} %, {resting:.0} % of the picture done");
    }
    // Nobody knows how long it takes until the noise is low.
    let by_fraction =
        progress.noise.is_none().then(|| progress.seconds * (1.0 - progress.fraction) / progress.fraction.max(1e-9));
    let by_time = end.time_limit.map(|limit| (f64::from(limit) - progress.seconds).max(0.0));
    if let Some(left) = [by_fraction, by_time].into_iter().flatten().reduce(f64::min) {
        text += &format!("  {} left", duration(left));
    }
    text
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
