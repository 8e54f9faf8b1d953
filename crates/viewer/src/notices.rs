//! Notices of the viewer, shown over the picture at the bottom left.

use std::time::{Duration, Instant};

/// Time that a notice of [`Kind::Done`] stays.
const BRIEF: Duration = Duration::from_secs(6);
/// Time at its end in which it fades.
const FADING: Duration = Duration::from_secs(1);

/// Notices for the user, one sentence each.
#[derive(Default)]
pub struct Notices {
    all: Vec<Notice>,
    failures: Vec<String>,
    of_scene: Vec<String>,
}

/// One sentence for the user.
#[derive(Clone, Debug)]
pub struct Notice {
    /// Text of the notice.
    pub text: String,
    /// Importance, which decides how long the notice stays.
    pub kind: Kind,
    since: Instant,
}

/// Importance of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Success of a command; goes by itself.
    Done,
    /// Work that goes on, for which the picture waits; goes when it is over.
    Ongoing,
    /// Warning of something that may not be meant; stays until it is dismissed.
    Warning,
    /// Warning of the scene; stays as long as it is true, unless it is dismissed.
    Scene,
    /// Failure of a command; stays until it is dismissed, or something succeeds.
    Error,
    /// Fault of a file that others change; stays until the file is right.
    Fault,
}

impl Notice {
    /// Opacity, 0 to 1.
    pub fn opacity(&self) -> f32 {
        if self.kind != Kind::Done {
            return 1.0;
        }
        (BRIEF.saturating_sub(self.since.elapsed()).as_secs_f32() / FADING.as_secs_f32()).min(1.0)
    }
}

impl Notices {
    /// Reports that something was done.
    pub fn done(&mut self, text: impl Into<String>) {
        self.say(Kind::Done, text.into());
    }

    /// Reports work for which the picture waits, as long as it goes on; `None`: there is none.
    pub fn ongoing(&mut self, what: Option<&str>) {
        self.all.retain(|notice| notice.kind != Kind::Ongoing);
        what.into_iter().for_each(|what| self.say(Kind::Ongoing, what.into()));
    }

    /// Warns of something that may not be meant.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.say(Kind::Warning, text.into());
    }

    /// Reports that something that was asked for cannot be done.
    pub fn fail(&mut self, text: impl ToString) {
        self.failures.push(text.to_string());
        self.say(Kind::Error, text.to_string());
    }

    /// Reports that a file that others change is wrong at the moment.
    pub fn fault(&mut self, text: impl ToString) {
        self.say(Kind::Fault, text.to_string());
    }

    /// Removes the faults of files, which are right again.
    pub fn mended(&mut self) {
        self.all.retain(|notice| notice.kind != Kind::Fault);
    }

    /// Shows the warnings of the scene as it is now, and removes those that are no longer true.
    pub fn warn_of_scene(&mut self, warnings: &[String]) {
        // A warning that was dismissed does not come back with the next edit.
        let known = std::mem::replace(&mut self.of_scene, warnings.to_vec());
        self.all.retain(|notice| notice.kind != Kind::Scene || warnings.contains(&notice.text));
        let new = warnings.iter().filter(|warning| !known.contains(warning));
        new.for_each(|warning| self.say(Kind::Scene, warning.clone()));
    }

    /// Removes failures of commands: something was done after all, so that they are no news any more.
    pub fn forgive(&mut self) {
        self.all.retain(|notice| notice.kind != Kind::Error);
    }

    /// Dismisses the notice at this index, if there is one.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.all.len() {
            self.all.remove(index);
        }
    }

    /// Current notices, the oldest first.
    pub fn current(&mut self) -> &[Notice] {
        self.all.retain(|notice| notice.kind != Kind::Done || notice.since.elapsed() < BRIEF);
        &self.all
    }

    /// Messages of everything that was asked for and could not be done, and of files that are wrong now.
    pub fn failures(&self) -> Vec<String> {
        let faults = self.all.iter().filter(|notice| notice.kind == Kind::Fault).map(|notice| notice.text.clone());
        self.failures.iter().cloned().chain(faults).collect()
    }

    /// Time for which the notices stay as they are.
    pub fn patience(&self) -> Duration {
        let brief = self.all.iter().filter(|notice| notice.kind == Kind::Done);
        let until_change = |notice: &Notice| match (BRIEF - FADING).saturating_sub(notice.since.elapsed()) {
            Duration::ZERO => Duration::from_millis(33),
            stays => stays,
        };
        brief.map(until_change).min().unwrap_or(Duration::MAX)
    }

    fn say(&mut self, kind: Kind, text: String) {
        self.all.retain(|notice| notice.text != text);
        self.all.push(Notice { text, kind, since: Instant::now() });
        // More notices than this are read by nobody.
        const MOST: usize = 6;
        let too_many = self.all.len().saturating_sub(MOST);
        self.all.drain(..too_many);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(notices: &mut Notices) -> Vec<String> {
        notices.current().iter().map(|notice| notice.text.clone()).collect()
    }

    #[test]
    fn what_goes_on_is_told_until_it_is_over() {
        let mut notices = Notices::default();
        notices.ongoing(Some("compiling kernels"));
        notices.done("wrote a.png");
        notices.ongoing(Some("compiling kernels"));
        assert_eq!(texts(&mut notices), ["wrote a.png", "compiling kernels"]);
        notices.ongoing(None);
        assert_eq!(texts(&mut notices), ["wrote a.png"]);
        assert_eq!(notices.failures(), Vec::<String>::new());
    }

    #[test]
    fn what_failed_is_remembered_even_when_it_is_no_longer_shown() {
        let mut notices = Notices::default();
        notices.fail("no such key");
        notices.fault("scene.toml:3: wrong");
        assert_eq!(texts(&mut notices), ["no such key", "scene.toml:3: wrong"]);
        notices.forgive();
        notices.mended();
        assert_eq!(texts(&mut notices), Vec::<String>::new());
        assert_eq!(notices.failures(), ["no such key"], "a file that was mended is none");
    }

    #[test]
    fn warnings_of_the_scene_last_as_long_as_they_are_true_or_until_they_are_sent_away() {
        let mut notices = Notices::default();
        let (dark, half) = ("nothing shines".to_owned(), "a half-space".to_owned());
        notices.warn_of_scene(std::slice::from_ref(&dark));
        notices.dismiss(0);
        notices.warn_of_scene(&[dark.clone(), half.clone()]);
        assert_eq!(texts(&mut notices), [half]);
        notices.warn_of_scene(&[]);
        notices.warn_of_scene(std::slice::from_ref(&dark));
        assert_eq!(texts(&mut notices), [dark]);
    }

    #[test]
    fn what_piles_up_makes_room() {
        let mut notices = Notices::default();
        (0..20).for_each(|i| notices.done(format!("{i}")));
        notices.done("19");
        assert_eq!(texts(&mut notices), ["14", "15", "16", "17", "18", "19"]);
    }
}
