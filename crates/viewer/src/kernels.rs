//! Kernels that are edited while they run.

use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use raggio_kernels::{Spirv, compile};

use crate::error::ViewError;
use crate::watch::Watch;

/// SPIR-V, or what is wrong with the kernels, in the words of their compiler.
type Outcome = Result<Spirv, String>;

/// Compiles the kernels of a folder whenever they change, beside the frames.
pub struct KernelWatch {
    watch: Watch,
    /// Numbers of attempts, sent to the thread that compiles; it ends when this goes.
    ask: Sender<u64>,
    answers: Receiver<(u64, Outcome)>,
    asked: u64,
    answered: u64,
}

impl KernelWatch {
    /// Watches the kernels of a folder, those that ask hardware too if `queries` says that they are needed. `wake` is called
    /// after each change and each compilation; each time call [`poll`](Self::poll).
    pub fn new(folder: &Path, queries: bool, wake: impl Fn() + Send + Clone + 'static) -> Result<Self, ViewError> {
        let compile = move |folder: &Path| compile::spirv(folder, queries).map_err(|error| brief(&error.to_string()));
        Self::with_compiler(folder, wake, compile)
    }

    /// Watches so with another compiler.
    fn with_compiler(
        folder: &Path,
        wake: impl Fn() + Send + Clone + 'static,
        compile: impl Fn(&Path) -> Outcome + Send + 'static,
    ) -> Result<Self, ViewError> {
        let unwatched = |error: notify::Error| ViewError::File {
            path: folder.to_owned(),
            message: format!("changes of the kernels are not noticed: {error}"),
        };
        let watch = Watch::files_below(folder, "slang", wake.clone()).map_err(unwatched)?;

        let (ask, requests) = channel();
        let (answer, answers) = channel();
        let folder = folder.to_owned();
        thread::spawn(move || {
            while let Ok(request) = requests.recv() {
                // The newest of the changes during the last compilation counts.
                let attempt = requests.try_iter().last().unwrap_or(request);
                if answer.send((attempt, compile(&folder))).is_err() {
                    return;
                }
                wake();
            }
        });
        Ok(Self { watch, ask, answers, asked: 0, answered: 0 })
    }

    /// The kernels as they are after the latest change, once, when they are compiled.
    pub fn poll(&mut self) -> Option<Outcome> {
        if self.watch.changed() {
            self.asked += 1;
            // The thread listens for as long as `self` is there.
            let _ = self.ask.send(self.asked);
        }
        let (attempt, outcome) = self.answers.try_iter().last()?;
        self.answered = attempt;
        // Later changes are still being compiled.
        (attempt == self.asked).then_some(outcome)
    }

    /// Whether a change is settling, or being compiled.
    pub fn is_waiting(&self) -> bool {
        self.watch.is_waiting() || self.answered < self.asked
    }
}

/// Messages up to the second error: from there on it is mostly files that import the wrong one.
fn brief(messages: &str) -> String {
    let mut errors = 0;
    let lines = messages.lines().take_while(|line| {
        errors += usize::from(line.starts_with("error") || line.starts_with("fatal error"));
        errors < 2
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::time::{Duration, Instant};

    use super::*;

    /// Polls until `answer` returns a value.
    fn wait_for<T>(watch: &mut KernelWatch, answer: impl Fn(&mut KernelWatch) -> Option<T>) -> T {
        let deadline = Instant::now() + Duration::from_secs(120);
        loop {
            if let Some(answer) = answer(watch) {
                return answer;
            }
            assert!(Instant::now() < deadline, "nothing happens");
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Takes its time over a folder with one file; text without a brace is an error.
    fn compile(folder: &Path) -> Outcome {
        let text = fs::read_to_string(folder.join("camera.slang")).map_err(|error| error.to_string())?;
        thread::sleep(Duration::from_millis(400));
        if text.contains('}') { Ok(raggio_kernels::SPIRV) } else { Err(format!("error: {text}")) }
    }

    #[test]
    fn the_newest_kernels_are_handed_out_once() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |text: &str| fs::write(folder.path().join("camera.slang"), text).expect("the file can be written");
        write("{}");

        let (waker, woken) = channel();
        let wake = move || waker.send(()).unwrap_or_default();
        let mut watch = KernelWatch::with_compiler(folder.path(), wake, compile).expect("the folder can be watched");
        assert_eq!(watch.poll(), None);
        assert!(!watch.is_waiting());

        write("float broken( {");
        let error = wait_for(&mut watch, KernelWatch::poll).expect_err("this is not Slang");
        assert_eq!(error, "error: float broken( {");
        assert!(woken.try_iter().count() > 1, "a change and a compilation wake");

        // The second change comes while the first is being compiled.
        write("float broken again( {");
        wait_for(&mut watch, |watch| {
            assert_eq!(watch.poll(), None);
            (watch.asked == 2).then_some(())
        });
        write("{ }");
        assert!(watch.is_waiting());
        let code = wait_for(&mut watch, KernelWatch::poll).expect("the newest is right");
        assert!(code == raggio_kernels::SPIRV);
        assert_eq!(watch.poll(), None);
        assert!(!watch.is_waiting());
    }

    #[test]
    fn messages_are_brief() {
        let messages = "error: a\n  here\nwarning: b\nerror: c\nerror: d";
        assert_eq!(brief(messages), "error: a\n  here\nwarning: b");
    }
}
