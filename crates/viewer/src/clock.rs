//! Times of frames, which the panel shows and benchmarks report.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Most seconds that a frame spends on samples; with more the window would seem to hang.
const SLOWEST: f64 = 0.1;

/// Seconds from frame to frame at which motion still looks like motion, even if one comes late.
const FLUENT: f64 = 1.0 / 38.0;

/// Part of a frame's time that is planned for: what comes a moment too late is shown a whole frame too late.
const PUNCTUAL: f64 = 0.85;

/// Part of it that is planned for where the alternative is a picture of fewer pixels.
const PROMPT: f64 = 0.97;

/// Part of it that one sample of each pixel is worth there, though the frame comes late then: with fewer pixels it would be
/// early, for nothing is denoised, and the next would have all of them again.
const WHOLE: f64 = 0.75;

/// Purpose of frames at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Frames follow hands at the display's own rate.
    Display,
    /// Frames still follow hands, but take longer where a device needs the time to show more than mush.
    Fluent,
    /// Frames follow hands, and each is worth all of its time: with a sample less it would be of another size.
    Whole,
    /// Nobody moves anything: where frames are costly, as with a display drawn in software, fewer of them leave more
    /// time for samples.
    Alone,
}

/// Measures frames, and says how much of one may be spent on samples.
pub struct Clock {
    /// Time from one frame to the next, as the display wants it.
    interval: Duration,
    began: Instant,
    /// Seconds from one frame's start to the next one's, smoothed.
    period: f64,
    /// Seconds of everything in a frame but the samples, smoothed.
    overhead: f64,
    sampled: f64,
    /// Seconds that samples took beyond those that they were given, smoothed.
    excess: f64,
    /// Beginning of the last frame that showed something new, or of the section if there was none since.
    shown: Instant,
    /// End of the first frame that showed a picture.
    first: Option<Instant>,
    /// Frames that showed something new, in the section under way.
    frames: Option<Vec<Frame>>,
    section: String,
    /// Section that the next frame is the first of, if another one begins or none.
    next_section: Option<Option<String>>,
    sections: BTreeMap<String, Vec<Frame>>,
}

/// A frame that showed something new.
#[derive(Clone, Copy)]
struct Frame {
    /// Time since the one before, in milliseconds.
    milliseconds: f64,
    /// Samples of each pixel of the picture, counted at its full size.
    samples: f64,
}

/// Statistics of the frames in one section of a script that showed something new.
#[derive(Clone, Debug, PartialEq)]
pub struct Pacing {
    /// Name of the section in the script.
    pub section: String,
    /// Number of frames that showed something new.
    pub frames: usize,
    /// Median of the times from one of them to the next, in milliseconds.
    pub median: f64,
    /// Time that 99 of 100 do not exceed, in milliseconds.
    pub percentile_99: f64,
    /// The longest time, in milliseconds.
    pub longest: f64,
    /// Median of the samples of each pixel, counted at the picture's full size: below 1 where films were smaller.
    pub samples: f64,
}

impl Clock {
    /// Creates a clock for a display with so many seconds from frame to frame.
    pub fn new(interval: f64) -> Self {
        Self {
            interval: Duration::from_secs_f64(interval),
            began: Instant::now(),
            period: interval,
            overhead: 0.2 * interval,
            sampled: 0.0,
            excess: 0.0,
            shown: Instant::now(),
            first: None,
            frames: None,
            section: String::new(),
            next_section: None,
            sections: BTreeMap::new(),
        }
    }

    /// Changes the display's interval: so many seconds from frame to frame.
    pub fn set_interval(&mut self, interval: f64) {
        self.interval = Duration::from_secs_f64(interval);
    }

    /// Begins a frame; returns the seconds since the last one began, at most a tenth of a second: after a pause nothing
    /// is to jump.
    pub fn begin(&mut self) -> f64 {
        let now = Instant::now();
        let elapsed = (now - self.began).as_secs_f64();
        self.began = now;
        if elapsed < 0.5 {
            self.period += 0.1 * (elapsed - self.period);
        }
        elapsed.min(0.1)
    }

    /// Seconds of this frame that samples may take.
    pub fn budget(&self, pace: Pace) -> f64 {
        let interval = self.interval.as_secs_f64();
        let left = |interval: f64, part: f64| (part * interval - self.overhead - self.excess).max(0.25 * interval);
        match pace {
            Pace::Display => left(interval, PUNCTUAL),
            Pace::Fluent => left(interval.max(FLUENT), PUNCTUAL),
            Pace::Whole => left(interval, PROMPT),
            Pace::Alone => left(interval, PUNCTUAL).max((3.0 * self.overhead).min(SLOWEST)),
        }
    }

    /// Seconds that the first sample of each pixel may take in a frame that is given `budget` seconds.
    pub fn patience(&self, pace: Pace, budget: f64) -> f64 {
        if pace == Pace::Whole { budget.max(WHOLE * self.interval.as_secs_f64()) } else { budget }
    }

    /// Notes that so many seconds of this frame went into samples, which were given `budget` seconds.
    pub fn sampled(&mut self, seconds: f64, budget: f64) {
        self.sampled = seconds;
        self.excess += 0.2 * ((seconds - budget).max(0.0) - self.excess);
    }

    /// Notes that this frame shows something new, of so many samples of each pixel.
    pub fn show(&mut self, samples: f64) {
        self.first.get_or_insert_with(Instant::now);
        let since = self.began - std::mem::replace(&mut self.shown, self.began);
        if let Some(frames) = &mut self.frames {
            frames.push(Frame { milliseconds: 1000.0 * since.as_secs_f64(), samples });
        }
    }

    /// Ends the frame, which `waited` for the display.
    pub fn end(&mut self, waited: Duration) {
        let busy = self.began.elapsed().as_secs_f64();
        let overhead = (busy - self.sampled - waited.as_secs_f64()).clamp(0.0, 0.1);
        self.overhead += 0.2 * (overhead - self.overhead);
        self.sampled = 0.0;
        if let Some(section) = self.next_section.take() {
            self.close_section();
            if let Some(section) = section {
                self.section = section;
                self.frames = Some(vec![]);
                self.shown = self.began;
            }
        }
    }

    /// Moment at which there was a picture for the first time.
    pub fn first_picture(&self) -> Option<Instant> {
        self.first
    }

    /// Frames per second, smoothed.
    pub fn frames_per_second(&self) -> f64 {
        1.0 / self.period.max(1e-6)
    }

    /// Begins a section of the measurement with the next frame; `None`: frames from then on belong to none.
    pub fn enter(&mut self, section: Option<String>) {
        self.next_section = Some(section);
    }

    /// Ends the section under way.
    pub fn close_section(&mut self) {
        if let Some(frames) = self.frames.take() {
            self.sections.entry(std::mem::take(&mut self.section)).or_default().extend(frames);
        }
    }

    /// Statistics of each section that is over, in alphabetical order.
    pub fn pacing(&self) -> Vec<Pacing> {
        let measured = self.sections.iter().filter(|(_, frames)| !frames.is_empty());
        measured.map(|(section, frames)| pacing(section, frames)).collect()
    }
}

fn pacing(section: &str, frames: &[Frame]) -> Pacing {
    // The smallest value that so many of 100 do not exceed.
    let percentile = |p: usize, of: &dyn Fn(&Frame) -> f64| {
        let mut sorted: Vec<_> = frames.iter().map(of).collect();
        sorted.sort_by(f64::total_cmp);
        sorted[(sorted.len() * p).div_ceil(100).max(1) - 1]
    };
    let time = |frame: &Frame| frame.milliseconds;
    Pacing {
        section: section.to_owned(),
        frames: frames.len(),
        median: percentile(50, &time),
        percentile_99: percentile(99, &time),
        longest: percentile(100, &time),
        samples: percentile(50, &|frame| frame.samples),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_frames_measured() {
        let frame = |milliseconds| Frame { milliseconds, samples: 2.0 * milliseconds };
        let frames: Vec<_> = (1..=200).rev().map(f64::from).map(frame).collect();
        let found = pacing("moving", &frames);
        assert_eq!((found.frames, found.median, found.percentile_99, found.longest), (200, 100.0, 198.0, 200.0));
        assert_eq!(found.samples, 200.0);
        assert_eq!(pacing("one", &[frame(7.0)]).percentile_99, 7.0);
    }

    #[test]
    fn a_section_has_the_frames_after_the_one_that_begins_it_which_show_something_new() {
        let mut clock = Clock::new(0.016);
        let mut frame = |section: Option<Option<&str>>, new: bool| {
            std::thread::sleep(Duration::from_millis(4));
            clock.begin();
            section.into_iter().for_each(|section| clock.enter(section.map(String::from)));
            if new {
                clock.show(1.0);
            }
            clock.end(Duration::ZERO);
        };
        frame(None, true);
        frame(None, false);
        frame(Some(Some("moving")), true);
        frame(None, true);
        frame(None, false);
        frame(None, true);
        frame(Some(None), true);
        frame(None, true);
        let pacing = clock.pacing();
        assert_eq!((pacing.len(), &*pacing[0].section, pacing[0].frames), (1, "moving", 3));
        // The frame that showed nothing new counts as time of the one after it.
        assert!(pacing[0].longest >= 8.0 && pacing[0].median >= 4.0, "{pacing:?}");
    }

    #[test]
    fn samples_never_get_less_than_a_quarter_of_a_frame() {
        let mut clock = Clock::new(0.016);
        assert!(clock.budget(Pace::Display) < 0.016 && clock.budget(Pace::Fluent) > 0.016);
        assert_eq!([Pace::Whole, Pace::Display].map(|pace| clock.patience(pace, 0.004)), [0.012, 0.004]);
        assert!(clock.budget(Pace::Whole) > clock.budget(Pace::Display) && clock.budget(Pace::Whole) < 0.016);
        clock.overhead = 1.0;
        assert_eq!(clock.budget(Pace::Display), 0.004);
        assert_eq!(clock.budget(Pace::Alone), SLOWEST);
    }
}
