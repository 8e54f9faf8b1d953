//! A folder to work in, and the program played by a script in it.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Mutex;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::common::{program, text};

/// Lock that a running program holds: two at once on a small machine would only measure each other.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
/// Longest time that a program may take: what takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder with a scene; it stays when a test fails, and says where.
pub struct Desk {
    folder: Option<tempfile::TempDir>,
}

impl Desk {
    pub fn new(scene: &str) -> Self {
        Self { folder: Some(crate::common::folder_with(scene)) }
    }

    pub fn folder(&self) -> &Path {
        self.folder.as_ref().expect("kept until the end").path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Starts `raggio view scene.toml` with a script.
    pub fn start(&self, script: &str, arguments: &[&str], display: Option<&Screen>) -> Run {
        std::fs::write(self.path("script.play"), script).expect("the script is written");
        let script = ["--play", "script.play", "--stats", "stats.json"];
        self.open(&[&script, arguments].concat(), display)
    }

    /// Starts `raggio view scene.toml` for hands to play with.
    pub fn open(&self, arguments: &[&str], display: Option<&Screen>) -> Run {
        let lock = ONE_AT_A_TIME.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut command = program();
        command.args(["view", "scene.toml"]).args(arguments);
        command.current_dir(self.folder()).env("RAGGIO_VALIDATE", "1");
        command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("DISPLAY");
        match display {
            Some(screen) => command.env("DISPLAY", &screen.name),
            None => command.arg("--hidden"),
        };
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("raggio starts");
        Run { child, begun: Instant::now(), _lock: lock }
    }

    /// Plays a script to its end, which has to be a good one without any message of the validation layers.
    #[track_caller]
    pub fn play(&self, script: &str, arguments: &[&str], display: Option<&Screen>) {
        assert_good(&self.start(script, arguments, display).finish());
        self.assert_valid();
    }

    /// Asserts that the validation layers had no message.
    #[track_caller]
    pub fn assert_valid(&self) {
        let stats: serde_json::Value = serde_json::from_str(&self.read("stats.json")).expect("stats are JSON");
        assert_eq!(stats["validation_messages"], serde_json::json!([]));
    }

    /// Renders a scene of this folder to an EXR or PNG on a device.
    #[track_caller]
    pub fn render(&self, scene: &str, output: &str, device: &str, size: (usize, usize), samples: u32) {
        let (size, samples) = (format!("{}x{}", size.0, size.1), samples.to_string());
        let arguments = ["render", scene, "-o", output, "--device", device, "--size", &size, "--samples", &samples];
        let rendered = crate::common::raggio(self.folder(), &arguments);
        assert!(rendered.status.success(), "{}", text(&rendered.stderr));
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let kept = self.folder.take().map(tempfile::TempDir::keep);
            eprintln!("script, scene and pictures are kept in {}", kept.unwrap_or_default().display());
        }
    }
}

/// The program while it runs.
pub struct Run {
    child: Child,
    begun: Instant,
    _lock: std::sync::MutexGuard<'static, ()>,
}

impl Run {
    /// Waits until the program has written a file.
    #[track_caller]
    pub fn wait_for(&mut self, path: &Path) {
        while !path.exists() {
            let over = self.child.try_wait().expect("the program can be asked");
            assert!(over.is_none(), "the program ended before it wrote {}", path.display());
            self.rest();
        }
    }

    /// Number of the program's process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Ends the program, whatever it is doing.
    pub fn kill(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Waits until the program ends.
    pub fn finish(mut self) -> Output {
        while self.child.try_wait().expect("the program can be asked").is_none() {
            self.rest();
        }
        self.child.wait_with_output().expect("the program's output")
    }

    fn rest(&mut self) {
        if self.begun.elapsed() > PATIENCE {
            let _ = self.child.kill();
            panic!("the script did not end within {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[track_caller]
pub fn assert_good(output: &Output) {
    assert!(output.status.success(), "status {:?}\n{}", output.status.code(), text(&output.stderr));
}

/// A virtual screen of 1600 by 1000 pixels.
pub struct Screen {
    server: Child,
    name: String,
}

impl Screen {
    /// Name of the screen, as `DISPLAY` has it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Starts a virtual screen; `None`, and a word about it, where there is none.
    pub fn new() -> Option<Self> {
        // Xvfb looks for a free number and writes it when it is ready.
        let arguments = ["-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp"];
        let started = Command::new("Xvfb")
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = started else {
            missing("Xvfb is not installed (Debian and Ubuntu: apt install xvfb)");
            return None;
        };
        let mut number = String::new();
        let answer = server.stdout.take().map(|out| BufReader::new(out).read_line(&mut number));
        assert!(matches!(answer, Some(Ok(1..))), "Xvfb does not start");
        Some(Self { server, name: format!(":{}", number.trim()) })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Whether there is a Vulkan device that can draw frames, with validation layers. The program is asked once.
pub fn can_draw() -> bool {
    static TROUBLE: OnceLock<Option<String>> = OnceLock::new();
    let trouble = TROUBLE.get_or_init(|| {
        let desk = Desk::new(crate::view::SCENE);
        // The processor traces: compiling the kernels for software Vulkan takes longer than most tests.
        let output = desk.start("quit", &["--device", "cpu", "--size", "64x64"], None).finish();
        (!output.status.success()).then(|| text(&output.stderr))
    });
    trouble.iter().for_each(|trouble| missing(trouble));
    trouble.is_none()
}

fn missing(what: &str) {
    let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
    assert!(!required, "RAGGIO_TEST_EVERYTHING=1, and {what}");
    eprintln!("skipped: {what}");
}
