//! The Python that has Ray.

use std::io::{BufRead, BufReader, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use raggio_scene::display_name;
use serde_json::Value;

use crate::error::Failure;

/// Variable that names the Python to run.
const VARIABLE: &str = "RAGGIO_PYTHON";
/// Program that tells which raggio a Python has, and whether it has Ray.
const FACTS: &str = "import importlib.util as u\n\
    print(u.find_spec('ray') is not None)\n\
    import raggio; print(raggio.__version__)";
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Time from one look at whether to stop to the next.
const PAUSE: Duration = Duration::from_millis(100);

/// A Python with this raggio and with Ray.
pub struct Python {
    path: PathBuf,
}

impl Python {
    /// Finds it: what `RAGGIO_PYTHON` names, else that of the environment that is active, else the first on the PATH.
    ///
    /// # Errors
    /// A [`Failure::Input`] that says what is missing.
    pub fn find() -> Result<Self, Failure> {
        let candidates = match std::env::var_os(VARIABLE) {
            Some(path) => vec![PathBuf::from(path)],
            None => {
                let environment = std::env::var_os("VIRTUAL_ENV").map(|folder| Path::new(&folder).join("bin/python"));
                environment.into_iter().chain(["python3".into(), "python".into()]).collect()
            }
        };
        let mut reason = format!("there is no {}", display_name(&candidates[candidates.len() - 1]));
        for path in candidates.into_iter().rev() {
            match lack(&path) {
                Ok(None) => return Ok(Self { path }),
                Ok(Some(lack)) => reason = format!("{} {lack}", display_name(&path)),
                Err(_) => {}
            }
        }
        Err(Failure::Input(format!(
            "--cluster needs a Python with raggio {VERSION} and Ray, and {reason}: `pip install 'raggio[cluster]=={VERSION}'` \
             installs both, and {VARIABLE} names another Python"
        )))
    }

    /// Runs `raggio.cluster` with an order, and hands what it says to `hear`, line by line. Once `stops` says so, the other
    /// side is told to come to an end.
    ///
    /// # Errors
    /// The failure that the other side tells of, or that it has ended without a word.
    pub fn run(&self, order: &Value, stops: &dyn Fn() -> bool, hear: &mut dyn FnMut(&Value)) -> Result<(), Failure> {
        let broken =
            |error: std::io::Error| Failure::Device(format!("cannot run {}: {error}", display_name(&self.path)));
        let mut said = tempfile::tempfile().map_err(broken)?;
        let mut command = Command::new(&self.path);
        command.args(["-m", "raggio.cluster"]).env("PYTHONSAFEPATH", "1");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(said.try_clone().map_err(broken)?);
        // Ctrl-C is for this program, which knows what to do about the other side.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(broken)?;
        let mut input = child.stdin.take();
        if let Some(input) = &mut input {
            // Whoever has ended already is asked for the reason below.
            let _ = writeln!(input, "{order}");
        }
        let (sender, lines) = channel::<Value>();
        let output = child.stdout.take();
        let reading = std::thread::spawn(move || {
            for line in output.into_iter().flat_map(|output| BufReader::new(output).lines()).map_while(Result::ok) {
                if let Ok(line) = serde_json::from_str(&line)
                    && sender.send(line).is_err()
                {
                    break;
                }
            }
        });
        let mut failure = None;
        loop {
            if stops() {
                // The end of its input tells the other side to end.
                drop(input.take());
            }
            match lines.recv_timeout(PAUSE) {
                Ok(line) => {
                    failure = failure.or_else(|| failure_of(&line));
                    hear(&line);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let status = child.wait().map_err(broken)?;
        let _ = reading.join();
        match failure {
            Some(failure) => Err(failure),
            None if status.success() => Ok(()),
            None => {
                let mut words = String::new();
                let _ = said.rewind().and_then(|()| said.read_to_string(&mut words));
                let last = words.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it says nothing").trim();
                Err(Failure::Device(format!("the Python that talks to the cluster has ended ({status}): {last}")))
            }
        }
    }
}

/// Lack of a Python, in words; `None` where it has all that is needed.
///
/// # Errors
/// The system's error where there is no such program.
fn lack(python: &Path) -> std::io::Result<Option<String>> {
    let output = Command::new(python).args(["-c", FACTS]).env("PYTHONSAFEPATH", "1").stdin(Stdio::null()).output()?;
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut lines = told.lines();
    let (has_ray, version) = (lines.next() == Some("True"), lines.next());
    Ok(match version {
        None => Some("has no raggio".into()),
        Some(VERSION) if has_ray => None,
        Some(VERSION) => Some("has no Ray".into()),
        Some(other) => Some(format!("has raggio {other}")),
    })
}

/// Failure that a line tells of.
fn failure_of(line: &Value) -> Option<Failure> {
    let [kind, sentence] = line["error"].as_array()?.as_slice() else { return None };
    let sentence = sentence.as_str()?.to_owned();
    Some(match kind.as_str()? {
        "DeviceError" | "InternalError" => Failure::Device(sentence),
        _ => Failure::Input(sentence),
    })
}
