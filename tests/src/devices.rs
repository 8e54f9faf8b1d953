//! The devices under test, opened once for all tests of a program.

use std::sync::OnceLock;

use raggio_render::{
    Answer, Device, DeviceChoice, DeviceError, DeviceScene, OpenOptions, Probe, Question, Tracer, open,
};
use raggio_scene::{Integrator, Scene};

/// A device under test.
#[derive(Clone, Copy)]
pub struct TestDevice {
    /// Name of the device in messages: `cpu` or `vulkan`.
    pub label: &'static str,
    /// Whether the device is software Vulkan: an order of magnitude slower than the CPU device, so tests take fewer
    /// samples there.
    pub slow: bool,
    /// The device itself.
    pub device: &'static dyn Device,
}

impl TestDevice {
    /// Returns `fast` on the CPU and on a GPU, `slow` on software Vulkan.
    pub fn pick<T>(&self, fast: T, slow: T) -> T {
        if self.slow { slow } else { fast }
    }

    /// Evaluates a function of the kernels in `scene`; as many questions as one likes.
    pub fn ask(&self, scene: &Scene, probe: Probe, questions: &[Question]) -> Vec<Answer> {
        self.ask_in(&DeviceScene::new(scene).expect("the scene fits devices"), probe, questions)
    }

    /// Evaluates a function of the kernels in a scene that has been translated.
    pub fn ask_in(&self, scene: &DeviceScene, probe: Probe, questions: &[Question]) -> Vec<Answer> {
        let mut session = self.device.load(scene).expect("the scene loads");
        questions
            .chunks(PROBES_AT_ONCE)
            .flat_map(|chunk| session.ask(probe, chunk).expect("the probe answers"))
            .collect()
    }
}

/// Whether `RAGGIO_TEST_LONG=1` asks for the tests that are slow and rarely find anything.
pub fn long() -> bool {
    is_on("RAGGIO_TEST_LONG")
}

/// Says that a part of a test is skipped, and why.
///
/// # Panics
/// If `RAGGIO_TEST_EVERYTHING=1` says that nothing may be.
pub fn lacks(why: &str) {
    assert!(!is_on("RAGGIO_TEST_EVERYTHING"), "RAGGIO_TEST_EVERYTHING=1, and {why}");
    eprintln!("skipped: {why}");
}

fn is_on(variable: &str) -> bool {
    std::env::var(variable).is_ok_and(|value| value == "1")
}

/// Questions of one dispatch: so many keep buffers small, and the dispatch far below the most workgroups that Vulkan
/// guarantees.
const PROBES_AT_ONCE: usize = 1 << 18;

/// Runs `test` on each device in turn; a message of Vulkan's validation layers fails it.
pub fn for_each_device(test: impl Fn(TestDevice)) {
    test(TestDevice { label: "cpu", slow: false, device: cpu() });
    let Some(device) = vulkan() else { return };
    test(TestDevice { label: "vulkan", slow: is_software(device), device });
    assert_valid(device);
}

/// Runs `test` on each device, but on software Vulkan for simple scenes alone: what else there is its compiler takes half a
/// minute to compile, for each scene anew. There its pictures agree with the CPU's
/// (`determinism::devices_agree`), and `make test-long` runs all.
pub fn for_each_device_with(scene: &Scene, test: impl Fn(TestDevice)) {
    let is_simple = || DeviceScene::new(scene).expect("the scene fits devices").buffers.is_simple();
    for_each_device(|device| {
        if !device.slow || long() || is_simple() {
            test(device);
        }
    });
}

/// Runs `test` on each device, as [`for_each_device_with`] does, with each integrator, which is set in the scene that the test
/// gets.
pub fn for_each_way(scene: &Scene, test: impl Fn(TestDevice, &Scene)) {
    for integrator in [Integrator::Path, Integrator::Reference] {
        let mut scene = scene.clone();
        scene.render.integrator = integrator;
        for_each_device_with(&scene, |device| test(device, &scene));
    }
}

/// CPU device with default options.
pub fn cpu() -> &'static dyn Device {
    static CPU: OnceLock<Box<dyn Device>> = OnceLock::new();
    &**CPU.get_or_init(|| open(DeviceChoice::Cpu, OpenOptions::default(), |_| ()).expect("the CPU is always there"))
}

/// Best Vulkan device, with validation, its rays traced by software as everywhere; `None` where there is none.
///
/// # Panics
/// If there is none and `RAGGIO_TEST_EVERYTHING=1` says that there has to be one.
pub fn vulkan() -> Option<&'static dyn Device> {
    static VULKAN: OnceLock<Option<Box<dyn Device>>> = OnceLock::new();
    VULKAN.get_or_init(open_vulkan).as_deref()
}

/// Opens the best Vulkan device once more, for tests that change it. In software its kernels are general ones.
pub fn open_vulkan() -> Option<Box<dyn Device>> {
    open_vulkan_with(true)
}

/// Opens the best Vulkan device once more, with kernels that are specialised for each scene in software too.
pub fn open_specialised_vulkan() -> Option<Box<dyn Device>> {
    open_vulkan_with(false)
}

fn open_vulkan_with(general_in_software: bool) -> Option<Box<dyn Device>> {
    let device = open_traced_by(Tracer::Software, general_in_software);
    device.map_err(|error| lacks(&format!("Vulkan cannot be used: {error}"))).ok()
}

/// Best Vulkan device whose hardware, or what passes for it, traces the rays, with validation; `None` where there is none.
///
/// # Panics
/// If there is none and `RAGGIO_TEST_EVERYTHING=1` says that there has to be one: `scripts/setup.sh --tests` installs Mesa 25,
/// whose software Vulkan answers ray queries.
pub fn hardware() -> Option<TestDevice> {
    static HARDWARE: OnceLock<Option<Box<dyn Device>>> = OnceLock::new();
    let device = HARDWARE.get_or_init(open_hardware).as_deref()?;
    Some(TestDevice { label: "hardware", slow: is_software(device), device })
}

/// Opens the device of [`hardware`] once more, for tests that change it.
pub fn open_hardware() -> Option<Box<dyn Device>> {
    let without = |error| {
        lacks(&format!(
            "no device here answers ray queries: {error}. `make setup-tests` installs Mesa 25 where it can, whose lavapipe does"
        ))
    };
    open_traced_by(Tracer::Hardware, true).map_err(without).ok()
}

fn open_traced_by(tracer: Tracer, general_in_software: bool) -> Result<Box<dyn Device>, DeviceError> {
    let options = OpenOptions { tracer, validate: true, general_in_software, ..OpenOptions::default() };
    open(DeviceChoice::Vulkan(None), options, |_| ())
}

/// Fails if Vulkan's validation layers have a message for `device`.
#[track_caller]
pub fn assert_valid(device: &dyn Device) {
    let messages = device.validation_messages();
    assert!(messages.is_empty(), "Vulkan's validation layers complain:\n{}", messages.join("\n"));
}

fn is_software(device: &dyn Device) -> bool {
    device.vulkan().is_some_and(|context| context.physical().kind.name() == "software")
}
